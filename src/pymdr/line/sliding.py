"""Sliding over an elastomer on the line: springs with memory that pass below a profile at a steady speed.

A spring enters at x = a without deflection; after the distance s = a - x its deflection is w = d - g, so that
w' = dw/ds is g' in front of the tip and -g' behind it. Every term of the kernel obeys h' = E w' - h / (v tau), and
q = sum h + viscosity v w'. With E w' = h' + h / (v tau) the drag is a sum of non-negative terms,

    F_x = int q dw = sum [h^2 / 2 E]_end + sum int h^2 / (E v tau) ds + viscosity v int w'^2 ds,

without cancellation at any speed. Contact ends where q decreases to 0.
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
"""Nodes of a panel, and the second number for the error estimate."""
_GRADES = 46
_PANELS = 320
"""Approximate number of panels that are halved toward weak kinks."""
_HALVED, _MOST = 12, 4096
_RESOLVED, _ALIKE = 1e-14, 1e-12
_ENDLESS = -0.99
"""Exponent of the distance from a knot below which g'^2 counts as not integrable."""


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
    rule, fraction = gauss(n)
    weights = fraction @ _lagrange(nodes, rule)
    points = np.append(0.0, nodes)
    distances = points[:, None] - points + np.eye(n + 1)
    barycentric = 1.0 / distances.prod(axis=1)
    derivative = barycentric / barycentric[:, None] / distances
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
    """A profile at a depth, on panels on which g' is smooth, in the order in which springs pass them."""

    depth: float
    """d in m."""
    radius: float
    """Contact radius a in m, where springs enter."""
    begins: FloatArray
    """Starts x of the panels in m, decreasing from a."""
    widths: FloatArray
    """Widths of the panels in m."""
    slopes: FloatArray
    """w' at the nodes of the panels: positive in front of the tip, negative behind it; shape (panels, nodes)."""
    knots: tuple[int, ...]
    """Indices, counted from the tip, of the panels that begin at the tip or at a kink."""

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
            # on the smallest panel the integrand is a power of the distance
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
        """Whether g' never decreases, so that the profile does not touch free springs again."""
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
            f"the contact ends at {metres(a)}, so close to a kink of the profile that double precision cannot resolve its slope; increase the load"
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
    """Number of halvings of panels toward a weak kink: fewer for a curve through many samples."""
    return min(max(_PANELS // (2 * kinks), 2), _GRADES) if kinks else _GRADES


def _graded(whole: float, marks: FloatArray, begin: int, end: int) -> FloatArray:
    """Distances from a knot to the next, halved a given number of times toward both."""
    first, last = (whole * 0.5 ** np.arange(1.0, number) for number in (begin, end))
    inside = marks[(marks > first[-1]) & (marks < whole - last[-1])]
    return np.unique(np.concatenate([[0.0, whole], first, whole - last, inside]))


def _slopes(
    line: ElasticLine,
    base: FloatArray,
    low: FloatArray,
    width: FloatArray,
    fraction: FloatArray,
    meets: BoolArray,
) -> FloatArray:
    """The slopes g' at fractions of panels; the mean on panels at a knot, where g' may jump or be unbounded."""
    equivalent = line.equivalent
    offset = low[:, None] + width[:, None] * fraction
    offset[meets] = (low + 0.5 * width)[meets, None]
    values = equivalent.slope(Place(np.repeat(base, fraction.size), offset.ravel())).reshape(offset.shape)
    ends = [equivalent.g(Place(base[meets], at[meets])) for at in (low, low + width)]
    values[meets] = (np.maximum(ends[1] - ends[0], 0.0) / width[meets])[:, None]
    return np.asarray(values)


def _rough(line: ElasticLine, left: float, points: FloatArray, n: int, depth: float) -> BoolArray:
    """Mask of the panels on which a Gaussian rule does not resolve the rise of g."""
    node, weight = gauss(n)
    width = np.diff(points)
    base = np.full(width.size, left)
    none = np.zeros(width.size, dtype=bool)
    rise = (_slopes(line, base, points[:-1], width, node, none) @ weight) * width
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
    """Position x of the trailing edge in m, not above 0."""
    panel: int
    """Index of the panel with the trailing edge."""
    fraction: float
    """Fraction of that panel in contact."""
    loads: FloatArray
    """Line loads of the terms of the kernel there in N/m."""


def slide(pressed: SlidingLine, relaxation: Relaxation, speed: float) -> Slid:
    """
    Steady sliding of a profile over springs with memory.

    Parameters
    ----------
    relaxation : Relaxation
        E*(t).
    speed : float
        In m/s, above 0.

    Notes
    -----
    Popov and Hess (2015), chapter 11. Radau collocation of every term on every panel, which also resolves terms that are far
    faster or slower than the passage of a panel.

    Examples
    --------
    >>> from pymdr.line.foundation import states_at_depth
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0)
    >>> pressed = sliding_line(ball, states_at_depth(ball, [1.0]))
    >>> result = slide(pressed, Relaxation(1.0, viscosity=1.0), 1.0)
    >>> round(result.trailing, 12), round(result.drag / result.load, 12)
    (-0.414213562373, 0.93933982822)
    """
    rule = _radau(pressed.slopes.shape[1])
    moduli, rates = _terms(relaxation, speed)
    dashpot = relaxation.viscosity * speed
    each = [_term(pressed, rule, modulus, rate) for modulus, rate in zip(moduli, rates, strict=True)]
    at_nodes = np.array([values for values, _ in each]).reshape(len(each), *pressed.slopes.shape)
    at_begins = np.array([begins for _, begins in each]).reshape(len(each), pressed.widths.size)
    q = at_nodes.sum(axis=0) + dashpot * pressed.slopes
    panel, fraction = _trailing_panel(pressed, rule, q)
    # panels before, and the part of the last one
    node, weight = gauss(rule.nodes.size)
    inner = _lagrange(np.append(0.0, rule.nodes), np.append(fraction * node, fraction))
    last = inner @ np.concatenate([at_begins[:, panel, None], at_nodes[:, panel]], axis=1).T
    steep = (
        (_lagrange(rule.nodes, fraction * node) @ pressed.slopes[panel]) if dashpot else np.zeros(node.size)
    )
    width, part = pressed.widths[:panel], fraction * pressed.widths[panel]
    load = width @ (q[:panel] @ rule.weights) + part * (weight @ (last[:-1].sum(axis=1) + dashpot * steep))
    squares = (at_nodes[:, :panel] ** 2 @ rule.weights) @ width + part * (weight @ last[:-1] ** 2)
    drag = np.sum(0.5 * last[-1] ** 2 / moduli) + np.sum(squares * rates / moduli)
    if dashpot:
        turns = width @ (pressed.slopes[:panel] ** 2 @ rule.weights) + part * (weight @ steep**2)
        drag += dashpot * turns
    return Slid(float(load), float(drag), float(pressed.begins[panel] - part), panel, fraction, last[-1])


def _terms(relaxation: Relaxation, speed: float) -> tuple[FloatArray, FloatArray]:
    """Moduli in Pa and rates 1 / (v tau) in 1/m; the rate of the equilibrium modulus is 0."""
    moduli, rates = relaxation.moduli, 1.0 / (speed * relaxation.times)
    if relaxation.equilibrium > 0.0:
        moduli, rates = np.append(relaxation.equilibrium, moduli), np.append(0.0, rates)
    return moduli, rates


def _term(pressed: SlidingLine, rule: _Radau, modulus: float, rate: float) -> tuple[FloatArray, FloatArray]:
    """Line load of one term in N/m at the nodes and at the starts of the panels."""
    matrix = rule.derivative[:, 1:] + (rate * pressed.widths)[:, None, None] * np.eye(rule.nodes.size)
    source = modulus * pressed.widths[:, None] * pressed.slopes
    before = np.broadcast_to(-rule.derivative[:, 0], source.shape)
    own, kept = np.moveaxis(np.linalg.solve(matrix, np.stack([source, before], axis=-1)), -1, 0)
    begins, h = [], 0.0
    for fresh, fraction in zip(own[:, -1].tolist(), kept[:, -1].tolist(), strict=True):
        begins.append(h)
        h = fresh + fraction * h
    start = np.array(begins)
    return own + kept * start[:, None], start


def _trailing_panel(pressed: SlidingLine, rule: _Radau, q: FloatArray) -> tuple[int, float]:
    """The panel behind the tip in which q decreases to 0, and the fraction of it in contact."""
    below = (q[pressed.half :] < 0.0).any(axis=1)
    if not below.any():
        return pressed.widths.size - 1, 1.0
    panel = pressed.half + int(np.argmax(below))

    def still(fraction: float) -> bool:
        return float((_lagrange(rule.nodes, np.array([fraction])) @ q[panel])[0]) > 0.0

    k = int(np.argmax(q[panel] < 0.0))
    low, high = (0.0 if k == 0 else float(rule.nodes[k - 1])), float(rule.nodes[k])
    if k == 0 and not still(0.0):
        return panel, 0.0
    return panel, float(boundary(np.vectorize(still, otypes=[bool]), low, high)[0])


def find_recontact(
    pressed: SlidingLine, line: ElasticLine, relaxation: Relaxation, speed: float, slid: Slid
) -> float | None:
    """
    Position at which a profile touches free springs again.

    Parameters
    ----------
    speed : float
        In m/s.
    slid : Slid
        Result of :func:`slide` for the same arguments.

    Returns
    -------
    float or None
        Approximate x in m; None without a second contact.

    Notes
    -----
    Free springs have q = 0, and their deflection decays monotonically, so a profile whose g' never decreases never meets
    them.
    """
    if pressed.convex:
        return None
    rule = _radau(pressed.slopes.shape[1])
    moduli, rates = _terms(relaxation, speed)
    dashpot = relaxation.viscosity * speed
    rest = (1.0 - slid.fraction) * pressed.widths[slid.panel]
    rests = np.append(rest * 0.5 ** np.append(_GRADES - 1.0, np.arange(_GRADES - 1.0, 0.0, -1.0)), 0.0)
    widths = np.concatenate([rests[rests > 0.0], pressed.widths[slid.panel + 1 :]])
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
        gap = free - (pressed.depth - line.equivalent.g(place))
        if np.any(gap < -1e-9 * pressed.depth):
            return -float(place[np.argmin(gap)])
        w, x = float(free[-1]), x - width
    return None


def slow_drag(pressed: SlidingLine, relaxation: Relaxation) -> float:
    """
    F_x / v in N s/m of the springs in the limit of slow sliding, 2 int (E* - E*_inf) dt int_0^a g'^2 dx.

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
    states : DiskStates
        One state of contact.
    relaxation : Relaxation
        Without a parallel dashpot.

    Returns
    -------
    float
        Also that of two half-spaces: it holds no more than their elastic energy.
    """
    energy = float(line.equivalent.squared(states.place)[0])
    return 2.0 * float(np.sum(relaxation.moduli / relaxation.times)) * energy
