"""Sliding over an elastomer on the line: springs with memory that pass below a profile at a steady speed.

A spring enters at x = a without deflection and leaves it behind; at the way s = a - x it is pressed in by w = d - g, so
w' = dw/ds is g' in front of the tip and -g' behind it. Every term of the kernel bears h' = E w' - h / (v tau), and
q = sum h + viscosity v w'. With E w' = h' + h / (v tau) the drag is a sum of parts that are none below 0,

    F_x = int q dw = sum [h^2 / 2 E]_end + sum int h^2 / (E v tau) ds + viscosity v int w'^2 ds,

so that nothing cancels, however slow or fast. Contact ends where q falls to 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ConvergenceError
from pymdr.line.foundation import DiskStates, ElasticLine
from pymdr.numerics.panels import Place
from pymdr.numerics.quadrature import gauss
from pymdr.numerics.roots import boundary
from pymdr.problem.spectra import Relaxation
from pymdr.units import FloatArray, metres

BoolArray = NDArray[np.bool_]

NODES, FEWER = 16, 12
"""Nodes of a panel, and those whose difference tells the error."""
_GRADES = 46
_PANELS = 320
"""About how many halve toward weak kinks."""
_HALVED, _MOST = 12, 4096
_RESOLVED, _ALIKE = 1e-14, 1e-12
_ENDLESS = -0.99
"""The power of the distance from a knot with which g'^2 is taken to have no integral."""


class _Radau(NamedTuple):
    """Collocation on (0, 1] whose last node is the end, so that fast terms are damped."""

    nodes: FloatArray
    weights: FloatArray
    derivative: FloatArray
    """From values at 0 and the nodes to slopes at the nodes, shape (n, 1 + n)."""


@lru_cache(maxsize=4)
def _radau(n: int) -> _Radau:
    from scipy.special import roots_jacobi

    inner, _ = roots_jacobi(n - 1, 1.0, 0.0)
    nodes = np.append(0.5 * (inner + 1.0), 1.0)
    rule, share = gauss(n)
    weights = share @ _lagrange(nodes, rule)
    points = np.append(0.0, nodes)
    apart = points[:, None] - points + np.eye(n + 1)
    barycentric = 1.0 / apart.prod(axis=1)
    derivative = barycentric / barycentric[:, None] / apart
    np.fill_diagonal(derivative, 0.0)
    np.fill_diagonal(derivative, -derivative.sum(axis=1))
    return _Radau(nodes, weights, derivative[1:])


def _lagrange(points: FloatArray, at: FloatArray) -> FloatArray:
    """Values of the polynomials that are 1 at one of some points, shape (at, points)."""
    factors = (at[:, None, None] - points) / (points[:, None] - points + np.eye(points.size))
    factors[:, np.eye(points.size, dtype=bool)] = 1.0
    return np.asarray(factors.prod(axis=2))


@dataclass(frozen=True)
class SlidingLine:
    """A profile at a depth, on panels between which g' is smooth, in the order in which springs pass them."""

    depth: float
    """d in m."""
    radius: float
    """Where springs enter: the contact radius a in m."""
    begins: FloatArray
    """Where panels begin: x in m, falling from a."""
    widths: FloatArray
    """Of the panels in m."""
    slopes: FloatArray
    """w' at the nodes of the panels: above 0 before the tip, below behind it; shape (panels, nodes)."""
    knots: tuple[int, ...]
    """The panels, counted from the tip, that begin at it or at a kink."""

    @property
    def half(self) -> int:
        """The first panel behind the tip."""
        return self.widths.size // 2

    @property
    def nodes(self) -> FloatArray:
        """Positions x of the nodes in m, shape (panels, nodes)."""
        return self.begins[:, None] - self.widths[:, None] * _radau(self.slopes.shape[1]).nodes

    @cached_property
    def slope_square(self) -> float:
        """The integral of g'^2 from 0 to a in m; inf where g' grows too fast toward the tip or a kink."""
        widths, slopes = self.widths[self.half :], -self.slopes[self.half :]
        parts = widths * (slopes**2 @ _radau(slopes.shape[1]).weights)
        for knot in self.knots:
            # what lies beyond the smallest panels is a power of the distance
            first, near, far = np.cumsum(widths[knot : knot + 3])
            low, high = slopes[knot + 1 : knot + 3, -1]
            if low > 0.0 and high > 0.0:
                power = 2.0 * math.log(high / low) / math.log(far / near)
                if power <= _ENDLESS:
                    return math.inf
                parts[knot] = first * low**2 * (first / near) ** power / (1.0 + power)
        return float(parts.sum())

    @property
    def convex(self) -> bool:
        """Whether g' nowhere falls, so that springs which the profile has left it does not meet again."""
        behind = -self.slopes[self.half :].ravel()
        return bool(np.all(np.diff(behind) >= -1e-9 * behind.max(initial=0.0)))


def sliding_line(line: ElasticLine, states: DiskStates, n: int = NODES) -> SlidingLine:
    """
    Resolve a pressed profile.

    Parameters
    ----------
    line : ElasticLine
        With a rising g without a sharp edge, of homogeneous half-spaces.
    states : DiskStates
        One state of contact.
    n : int, optional
        Nodes of a panel.

    Returns
    -------
    SlidingLine
        Panels halve toward the tip, kinks and the edge on both sides, where terms of the kernel may be as fast as they
        like.

    Raises
    ------
    ConvergenceError
        If the contact ends so close to a kink that rounding hides the slope between them.

    Examples
    --------
    >>> from pymdr.line.foundation import states_at_depth
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0)
    >>> round(sliding_line(ball, states_at_depth(ball, [0.25])).slope_square, 14)
    0.16666666666667
    """
    place, depth = states.place, float(states.indentation[0])
    a = float(place.x[0])
    equivalent = line.equivalent
    kinks = [b for b in equivalent.kinks(a) if 0.0 < b < a]
    strong = {b for b, _ in equivalent.corners(a)}
    grades = {b: _GRADES if b in strong else _some_grades(len(kinks)) for b in kinks} | {0.0: _GRADES}
    marks = equivalent.resolving_radii(a)
    bases, offsets, widths, singular = [], [], [], []
    for left, right in zip([0.0, *kinks], [*kinks, None], strict=True):
        whole = float(place.base[0] - left) + float(place.offset[0]) if right is None else right - left
        ends = grades[left], _GRADES if right is None else grades[right]
        points = _graded(whole, marks - left, *ends)
        alone = np.zeros(2, dtype=bool) if right is None else np.array(ends) == _GRADES
        alone[0] = ends[0] == _GRADES
        for _ in range(_HALVED):
            rough = _rough(line, left, points, n, depth)
            rough[[0, -1]] &= ~alone
            if not rough.any() or points.size > _MOST:
                break
            middles = points[:-1][rough] + 0.5 * np.diff(points)[rough]
            points = np.sort(np.append(points, middles))
        meets = np.zeros(points.size - 1, dtype=bool)
        meets[[0, -1]] = alone
        bases.append(np.full(points.size - 1, left))
        offsets.append(points[:-1])
        widths.append(np.diff(points))
        singular.append(meets)
    base, low, width = (np.concatenate(parts) for parts in (bases, offsets, widths))
    meets = np.concatenate(singular)
    nodes = _radau(n).nodes
    behind = _slopes(line, base, low, width, nodes, meets)
    before = _slopes(line, base, low, width, 1.0 - nodes, meets)
    if not (np.isfinite(behind).all() and np.isfinite(before).all()):
        raise ConvergenceError(
            f"the contact ends at {metres(a)}, so close to a kink of the profile that rounding hides its slope: press harder"
        )
    return SlidingLine(
        depth,
        a,
        np.concatenate([(base + low + width)[::-1], -(base + low)]),
        np.concatenate([width[::-1], width]),
        np.concatenate([before[::-1], -behind]),
        tuple(np.flatnonzero(meets & (low == 0.0)).tolist()),
    )


def _some_grades(kinks: int) -> int:
    """How often panels halve toward a weak kink: less for those of a curve through many samples."""
    return min(max(_PANELS // (2 * kinks), 2), _GRADES) if kinks else _GRADES


def _graded(whole: float, marks: FloatArray, begin: int, end: int) -> FloatArray:
    """Distances from a knot to the next, which halve so often toward both."""
    first, last = (whole * 0.5 ** np.arange(1.0, number) for number in (begin, end))
    inside = marks[(marks > first[-1]) & (marks < whole - last[-1])]
    return np.unique(np.concatenate([[0.0, whole], first, whole - last, inside]))


def _slopes(
    line: ElasticLine,
    base: FloatArray,
    low: FloatArray,
    width: FloatArray,
    share: FloatArray,
    meets: BoolArray,
) -> FloatArray:
    """The slopes g' at shares of panels; its mean on those that meet a knot, where it may jump or have no bound."""
    equivalent = line.equivalent
    offset = low[:, None] + width[:, None] * share
    offset[meets] = (low + 0.5 * width)[meets, None]
    found = equivalent.slope(Place(np.repeat(base, share.size), offset.ravel())).reshape(offset.shape)
    ends = [equivalent.g(Place(base[meets], at[meets])) for at in (low, low + width)]
    found[meets] = (np.maximum(ends[1] - ends[0], 0.0) / width[meets])[:, None]
    return np.asarray(found)


def _rough(line: ElasticLine, left: float, points: FloatArray, n: int, depth: float) -> BoolArray:
    """Panels on which a Gaussian rule misses by how much g rises."""
    node, weight = gauss(n)
    width = np.diff(points)
    base = np.full(width.size, left)
    nowhere = np.zeros(width.size, dtype=bool)
    rise = (_slopes(line, base, points[:-1], width, node, nowhere) @ weight) * width
    exact = np.diff(line.equivalent.g(Place(np.full(points.size, left), points)))
    missed = np.abs(rise - exact)
    return np.asarray(
        (missed > _RESOLVED * depth) & (missed > _ALIKE * np.abs(exact)) & (width > _RESOLVED * points[-1])
    )


@dataclass(frozen=True)
class Slid:
    """Steady sliding at one speed."""

    load: float
    """The integral of q over the contact, F_N in N."""
    drag: float
    """The integral of q g' over the contact, F_x in N."""
    trailing: float
    """Where contact ends: x in m, not above 0."""
    panel: int
    """The panel in which it does."""
    share: float
    """How much of the panel is in contact."""
    loads: FloatArray
    """What the terms of the kernel bear there in N/m."""


def slide(pressed: SlidingLine, relaxation: Relaxation, speed: float) -> Slid:
    """
    Steady sliding of a profile over springs with memory.

    Parameters
    ----------
    pressed : SlidingLine
    relaxation : Relaxation
        E*(t).
    speed : float
        In m/s, above 0.

    Returns
    -------
    Slid

    Notes
    -----
    Popov and Hess (2015), chapter 11. Radau collocation of every term on every panel; the slope of a term needs no more
    nodes where it is far faster or slower than a panel is passed.

    Examples
    --------
    >>> from pymdr.line.foundation import states_at_depth
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0)
    >>> pressed = sliding_line(ball, states_at_depth(ball, [1.0]))
    >>> found = slide(pressed, Relaxation(1.0, viscosity=1.0), 1.0)
    >>> round(found.trailing, 12), round(found.drag / found.load, 12)
    (-0.414213562373, 0.93933982822)
    """
    rule = _radau(pressed.slopes.shape[1])
    moduli, rates = _terms(relaxation, speed)
    dashpot = relaxation.viscosity * speed
    each = [_term(pressed, rule, modulus, rate) for modulus, rate in zip(moduli, rates, strict=True)]
    at_nodes = np.array([values for values, _ in each]).reshape(len(each), *pressed.slopes.shape)
    at_begins = np.array([begins for _, begins in each]).reshape(len(each), pressed.widths.size)
    q = at_nodes.sum(axis=0) + dashpot * pressed.slopes
    panel, share = _parting(pressed, rule, q)
    # panels before, and the part of the last one
    node, weight = gauss(rule.nodes.size)
    inner = _lagrange(np.append(0.0, rule.nodes), np.append(share * node, share))
    last = inner @ np.concatenate([at_begins[:, panel, None], at_nodes[:, panel]], axis=1).T
    steep = (_lagrange(rule.nodes, share * node) @ pressed.slopes[panel]) if dashpot else np.zeros(node.size)
    width, part = pressed.widths[:panel], share * pressed.widths[panel]
    load = width @ (q[:panel] @ rule.weights) + part * (weight @ (last[:-1].sum(axis=1) + dashpot * steep))
    squares = (at_nodes[:, :panel] ** 2 @ rule.weights) @ width + part * (weight @ last[:-1] ** 2)
    drag = np.sum(0.5 * last[-1] ** 2 / moduli) + np.sum(squares * rates / moduli)
    if dashpot:
        turns = width @ (pressed.slopes[:panel] ** 2 @ rule.weights) + part * (weight @ steep**2)
        drag += dashpot * turns
    return Slid(float(load), float(drag), float(pressed.begins[panel] - part), panel, share, last[-1])


def _terms(relaxation: Relaxation, speed: float) -> tuple[FloatArray, FloatArray]:
    """Moduli in Pa and rates 1 / (v tau) in 1/m; that of what does not relax is 0."""
    moduli, rates = relaxation.moduli, 1.0 / (speed * relaxation.times)
    if relaxation.equilibrium > 0.0:
        moduli, rates = np.append(relaxation.equilibrium, moduli), np.append(0.0, rates)
    return moduli, rates


def _term(pressed: SlidingLine, rule: _Radau, modulus: float, rate: float) -> tuple[FloatArray, FloatArray]:
    """What one term bears in N/m at the nodes of the panels, and where they begin."""
    matrix = rule.derivative[:, 1:] + (rate * pressed.widths)[:, None, None] * np.eye(rule.nodes.size)
    source = modulus * pressed.widths[:, None] * pressed.slopes
    before = np.broadcast_to(-rule.derivative[:, 0], source.shape)
    own, kept = np.moveaxis(np.linalg.solve(matrix, np.stack([source, before], axis=-1)), -1, 0)
    begins, h = [], 0.0
    for fresh, share in zip(own[:, -1].tolist(), kept[:, -1].tolist(), strict=True):
        begins.append(h)
        h = fresh + share * h
    start = np.array(begins)
    return own + kept * start[:, None], start


def _parting(pressed: SlidingLine, rule: _Radau, q: FloatArray) -> tuple[int, float]:
    """The panel behind the tip in which q falls to 0, and how much of it is before that."""
    below = (q[pressed.half :] < 0.0).any(axis=1)
    if not below.any():
        return pressed.widths.size - 1, 1.0
    panel = pressed.half + int(np.argmax(below))

    def still(share: float) -> bool:
        return float((_lagrange(rule.nodes, np.array([share])) @ q[panel])[0]) > 0.0

    k = int(np.argmax(q[panel] < 0.0))
    low, high = (0.0 if k == 0 else float(rule.nodes[k - 1])), float(rule.nodes[k])
    if k == 0 and not still(0.0):
        return panel, 0.0
    return panel, float(boundary(np.vectorize(still, otypes=[bool]), low, high)[0])


def touches_again(
    pressed: SlidingLine, line: ElasticLine, relaxation: Relaxation, speed: float, slid: Slid
) -> float | None:
    """
    Where a profile meets springs again that it has left.

    Parameters
    ----------
    pressed : SlidingLine
    line : ElasticLine
    relaxation : Relaxation
    speed : float
        In m/s.
    slid : Slid
        Of :func:`slide` for the same.

    Returns
    -------
    float or None
        About x in m; None where it does not.

    Notes
    -----
    Free springs keep q = 0. Theirs is a deflection that decays without a turn, so a profile whose g' nowhere falls never
    meets them.
    """
    if pressed.convex:
        return None
    rule = _radau(pressed.slopes.shape[1])
    moduli, rates = _terms(relaxation, speed)
    dashpot = relaxation.viscosity * speed
    rest = (1.0 - slid.share) * pressed.widths[slid.panel]
    pieces = np.append(rest * 0.5 ** np.append(_GRADES - 1.0, np.arange(_GRADES - 1.0, 0.0, -1.0)), 0.0)
    widths = np.concatenate([pieces[pieces > 0.0], pressed.widths[slid.panel + 1 :]])
    x, h = slid.trailing, slid.loads
    w = pressed.depth - float(line.equivalent.g(np.array([-x]))[0])
    for width in widths.tolist():
        inverse = np.linalg.inv(
            rule.derivative[:, 1:] + (rates * width)[:, None, None] * np.eye(rule.nodes.size)
        )
        kept = -(inverse @ rule.derivative[:, 0]) * h[:, None]
        response = np.tensordot(moduli * width, inverse, 1) + dashpot * np.eye(rule.nodes.size)
        slope = np.linalg.solve(response, -kept.sum(axis=0))
        h = ((moduli * width)[:, None] * (inverse @ slope) + kept)[:, -1]
        free = w + width * np.linalg.solve(rule.derivative[:, 1:], slope)
        place = np.minimum(width * rule.nodes - x, pressed.radius)
        apart = free - (pressed.depth - line.equivalent.g(place))
        if np.any(apart < -1e-9 * pressed.depth):
            return -float(place[np.argmin(apart)])
        w, x = float(free[-1]), x - width
    return None


def slow_drag(pressed: SlidingLine, relaxation: Relaxation) -> float:
    """
    F_x / v in N s/m of the springs in the limit of slow sliding, 2 int (E* - E*_inf) dt int_0^a g'^2 dx.

    Parameters
    ----------
    pressed : SlidingLine
    relaxation : Relaxation

    Returns
    -------
    float
        Twice that of two half-spaces; inf where the integral has no end.
    """
    return 2.0 * (float(relaxation.moduli @ relaxation.times) + relaxation.viscosity) * pressed.slope_square


def fast_drag(line: ElasticLine, states: DiskStates, relaxation: Relaxation) -> float:
    """
    The F_x v in N m/s of the springs in the limit of fast sliding, 2 sum (E_i / tau_i) int_0^a (d - g)^2 dx.

    Parameters
    ----------
    line : ElasticLine
    states : DiskStates
        One state of contact.
    relaxation : Relaxation
        Without a dashpot beside the springs.

    Returns
    -------
    float
        Also that of two half-spaces: it holds no more than their elastic energy.
    """
    energy = float(line.equivalent.squared(states.place)[0])
    return 2.0 * float(np.sum(relaxation.moduli / relaxation.times)) * energy
