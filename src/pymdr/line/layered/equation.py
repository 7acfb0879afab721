"""The line load of a contact of one radius on layers: a Fredholm equation of the second kind by quadrature.

Lengths are in thicknesses h of the top layer. The kernel is analytic within two thicknesses of the real axis, so that Gauss
nodes on panels no wider than three resolve the line load, which is an analytic function too. The gap is not: where it has a
tip or a corner its moments with the polynomials of a narrower panel are integrated instead.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from pymdr.errors import ConvergenceError
from pymdr.line.layered.tiles import product, solve_positive
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.mapping.layers import Kernel
from pymdr.numerics.panels import BoolArray, IndexArray, Place
from pymdr.units import FloatArray, metres

WIDEST = 300.0
"""Largest contact radius in thicknesses of the top layer."""
_PANEL, _NARROW = 3.0, 1.0
"""Largest widths of panels: of smooth ones, and of those on which the gap is not."""
ORDERS = (12, 16, 20, 24)
"""Nodes of a panel, which are raised until two agree."""
_AGREE, _DOUBT = 1e-10, 1e-6
"""Differences of two orders: below the first the solution is accepted, above the second it fails."""
_SOFT = 1e-2
"""A compliance of the widest waves below which 12 nodes are too few."""
_TIP = 15
"""Panels, each a quarter of the next, toward the tip of a gap."""
_INNER = 16
"""Nodes of the quadrature of the gap between its marks."""


@dataclass(frozen=True)
class Outline:
    """A gap on the line up to a radius of contact."""

    equivalent: EquivalentProfile
    thickness: float
    """Of the top layer in m."""
    place: Place
    """The radius a, of shape (1,)."""

    @property
    def radius(self) -> float:
        """The radius in thicknesses."""
        return float(self.place.x[0]) / self.thickness

    @property
    def marks(self) -> FloatArray:
        """Rising positions in m below the radius where g is not smooth: 0, and breakpoints."""
        a = float(self.place.x[0])
        inside = [b for b in self.equivalent.breakpoints if 0.0 < b < a]
        return np.array([0.0, *sorted(inside)])

    def rise(self, at: Place) -> FloatArray:
        """The rise g(a) - g in m."""
        return self.equivalent.g(self.place) - self.equivalent.g(at)

    def moments(self, panels: FloatArray, nodes: FloatArray, weights: FloatArray) -> FloatArray:
        """
        Weights w_j in m with which int (g(a) - g) f dx = sum w_j f(x_j) for polynomials on each panel, shape (P, n).

        Parameters
        ----------
        panels : ndarray
            Their ends, in thicknesses, shape (P, 2).
        nodes, weights : ndarray
            Those of Gauss on [-1, 1], shape (n,).
        """
        h = self.thickness
        half, middle = 0.5 * (panels[:, 1] - panels[:, 0]), 0.5 * (panels[:, 1] + panels[:, 0])
        at, rule_weights, panel = self._between_marks(panels)
        u = (at.x / h - middle[panel]) / half[panel]
        terms = (
            legendre.legvander(u, nodes.size - 1)
            * (rule_weights * self.rise(at) / (half[panel] * h))[:, None]
        )
        values = np.add.reduceat(terms, np.searchsorted(panel, np.arange(half.size)), axis=0)
        return np.asarray(half[:, None] * weights * (values @ _projector(nodes.size).T))

    def _between_marks(self, panels: FloatArray) -> tuple[Place, FloatArray, IndexArray]:
        """Nodes and weights in m of the stretches between the marks on panels, and the panel of each node, in order."""
        marks, (low, high) = self.marks, panels.T * self.thickness
        first, last = np.searchsorted(marks, low, side="right"), np.searchsorted(marks, high, side="left")
        count = last - first + 1
        panel = np.repeat(np.arange(low.size), count)
        nth = np.arange(panel.size) - np.repeat(np.cumsum(count) - count, count)
        ends = nth == count[panel] - 1
        start = np.where(nth == 0, low[panel], marks[first[panel] + nth - 1])
        stop = np.where(ends, high[panel], marks[np.minimum(first[panel] + nth, marks.size - 1)])
        mark = marks[np.searchsorted(marks, start, side="right") - 1]
        # the last mark may be closer to the radius than their rounding: take the exact distance
        adjacent = ends & (mark == float(self.place.base[0])) & (panels[panel, 1] == self.radius)
        distance = np.where(adjacent & (mark > 0.0), float(self.place.offset[0]), stop - mark)
        tip = start == 0.0
        x, weight = _unit_tip()
        offsets, weights = _stretches(start - mark, distance, mark > 0.0)
        parts = [
            (stop[i] * x, stop[i] * weight) if tip[i] else (offsets[i], weights[i]) for i in range(tip.size)
        ]
        sizes = np.where(tip, x.size, offsets.shape[1])
        place = Place(np.repeat(mark, sizes), np.concatenate([part[0] for part in parts]))
        return place, np.concatenate([part[1] for part in parts]), np.repeat(panel, sizes)


@lru_cache(maxsize=32)
def gauss(n: int) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of Gauss on [-1, 1]."""
    nodes, weights = legendre.leggauss(n)
    return np.asarray(nodes), np.asarray(weights)


@lru_cache(maxsize=32)
def _projector(n: int) -> FloatArray:
    """Matrix from moments with Legendre polynomials to values of a polynomial at the nodes, shape (n, n)."""
    nodes, _ = gauss(n)
    return np.asarray(legendre.legvander(nodes, n - 1) * (np.arange(n) + 0.5))


def _stretches(low: FloatArray, high: FloatArray, rooted: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights between two distances behind marks; where they are `rooted`, g runs in the root of the distance."""
    nodes, weights = gauss(_INNER)
    first, last = (np.where(rooted, np.sqrt(end), end)[:, None] for end in (low, high))
    half = 0.5 * (last - first)
    at = first + half * (nodes + 1.0)
    behind = rooted[:, None]
    return np.where(behind, at * at, at), half * weights * np.where(behind, 2.0 * at, 1.0)


@lru_cache(maxsize=2)
def _unit_tip() -> tuple[FloatArray, FloatArray]:
    """From the axis to 1, for a g that is any power there."""
    nodes, weights = gauss(_INNER)
    ends = np.append(0.0, 4.0 ** np.arange(1.0 - _TIP, 1.0))
    half = 0.5 * np.diff(ends)
    return (ends[:-1, None] + half[:, None] * (nodes + 1.0)).ravel(), (half[:, None] * weights).ravel()


@dataclass(frozen=True)
class _Nodes:
    """Nodes of the equation: on narrow panels where the gap is not smooth, then on equal wide panels."""

    x: FloatArray
    weight: FloatArray
    rise: FloatArray
    """Weights in m of the rise of the gap."""
    wide: IndexArray
    """Which of the wide panels from the axis on are among them."""
    width: float
    """That of a wide panel."""
    order: int
    """Nodes of a panel."""


def _nodes(outline: Outline, order: int) -> _Nodes:
    radius, h = outline.radius, outline.thickness
    unit, weight = gauss(order)
    width = radius / max(1, math.ceil(radius / _PANEL - 1e-9))
    low = width * np.arange(round(radius / width))
    marks = outline.marks / h
    # behind a mark the gap needs a panel's length to become smooth
    among = np.array([bool(np.any((marks > x - width) & (marks < x + width))) for x in low])
    cuts = [_narrow(k * width, (k + 1) * width, marks) for k in np.flatnonzero(among)]
    if among[-1]:
        cuts[-1][-1] = radius
    narrow = [ends for edges in cuts for ends in itertools.pairwise(edges)]
    wide = np.flatnonzero(~among)
    start = np.concatenate([[ends[0] for ends in narrow], low[wide]])
    half = 0.5 * np.concatenate([[ends[1] - ends[0] for ends in narrow], np.full(wide.size, width)])
    x = start[:, None] + half[:, None] * (unit + 1.0)
    smooth = (
        half[len(narrow) :, None]
        * weight
        * outline.rise(Place(np.zeros((wide.size, order)), x[len(narrow) :] * h))
    )
    rise = np.concatenate([outline.moments(np.array(narrow), unit, weight).ravel(), smooth.ravel()])
    return _Nodes(x.ravel(), (half[:, None] * weight).ravel(), rise, wide, width, order)


def _narrow(low: float, high: float, marks: FloatArray) -> list[float]:
    """Ends of narrow panels between the ends of a wide one; behind the axis alone the gap soon is smooth."""
    parts = max(1, math.ceil((high - low) / _NARROW - 1e-9))
    ends: list[float] = np.linspace(low, high, parts + 1).tolist()
    if low == 0.0 and parts > 2 and not np.any((marks > 0.0) & (marks < high)):
        return [ends[0], ends[1], ends[-1]]
    return ends


def _acting(kernel: Kernel, at: _Nodes) -> FloatArray:
    """The kernel between all nodes, whose blocks between wide panels depend on their distance and sum alone."""
    n, m = at.x.size, at.wide.size
    first = n - m * at.order
    matrix = np.empty((n, n))
    matrix[:first] = kernel.pair(at.x[:first], at.x)
    matrix[first:, :first] = matrix[:first, first:].T
    if m:
        unit = 0.5 * at.width * (gauss(at.order)[0] + 1.0)
        last = int(at.wide[-1])
        by_distance = kernel(np.abs(at.width * np.arange(last + 1)[:, None, None] + (unit[:, None] - unit)))
        together = at.width * np.arange(2 * int(at.wide[0]), 2 * last + 1)[:, None, None] + (
            unit[:, None] + unit
        )
        sums = kernel(together)
        away = np.concatenate([np.swapaxes(by_distance[:0:-1], 1, 2), by_distance]) / math.pi
        sums /= math.pi
        for k, row in zip(at.wide, matrix[first:].reshape(m, at.order, n), strict=True):
            blocks = away[last + k - at.wide] + sums[k + at.wide - 2 * at.wide[0]]
            row[:, first:] = blocks.transpose(1, 0, 2).reshape(at.order, -1)
    return matrix


@dataclass(frozen=True)
class Solved:
    """
    A contact of one radius: its line loads at nodes, and derived quantities.

    `coupled` are the parts K q of line loads: of the rise g(a) - g in m, and of a punch of the depth 1.
    """

    radius: float
    """In thicknesses."""
    x: FloatArray
    weight: FloatArray
    rise: FloatArray
    """Weights in m of the rise."""
    coupled: FloatArray
    """Shape (2, n)."""
    at_edge: FloatArray
    """The same at the edge, shape (2,)."""
    stiffness: float
    """The integral of q_A."""
    lift: float
    """The depth g(a) - d0 in m."""
    force: float
    """The integral of the smooth line load, less that of the rise, in m."""
    energy: float
    """The integral of q (d0 - g), less that of the square of the rise, in m^2."""

    @property
    def punch_edge(self) -> float:
        """q_A at the edge."""
        return 1.0 + float(self.at_edge[1])

    def loads(self, excess: float) -> FloatArray:
        """Line loads per modulus times their weights in m, with an excess of depth in m at the edge."""
        pressed = excess - self.lift
        weights = self.rise + pressed * self.weight
        return np.asarray(weights + self.weight * (self.coupled[0] + pressed * self.coupled[1]))


def _solved(kernel: Kernel, outline: Outline, order: int) -> Solved:
    at = _nodes(outline, order)
    x, w = at.x, at.weight
    acting = _acting(kernel, at)
    edge = kernel.pair(np.array([outline.radius]), x)[0]
    root = np.sqrt(w)
    acting *= root[:, None]
    acting *= root
    sources = np.stack([product(acting, at.rise / root), product(acting, root)], axis=1)
    np.negative(acting, out=acting)
    # L > 0 makes the symmetric matrix positive definite; where its quadrature is not, nodes are missing
    acting.flat[:: x.size + 1] += 1.0
    coupled = (solve_positive(acting, sources) / root[:, None]).T
    at_edge = np.array([edge @ at.rise, float(np.sum(edge * w))]) + (coupled * w) @ edge
    stiffness = float(np.sum(w * (1.0 + coupled[1])))
    lift = float(at_edge[0]) / (1.0 + float(at_edge[1]))
    extra = float(w @ coupled[0])
    whole = float(np.sum(at.rise))
    return Solved(
        outline.radius,
        x,
        w,
        at.rise,
        coupled,
        at_edge,
        stiffness,
        lift,
        extra - lift * stiffness,
        float(coupled[0] @ at.rise) - 2.0 * lift * (whole + extra) + lift * lift * stiffness,
    )


def numbers(solved: Solved, outline: Outline) -> FloatArray:
    """
    Values for a table of contacts: k / (2 E* a), q_A(a), and d0, F0 and U0 relative to a half-space.

    Returns
    -------
    ndarray
        Shape (5,); the last three 1 where the gap is flat.
    """
    place, h = outline.place, outline.thickness
    line = outline.equivalent
    g, m, s = (float(f(place)[0]) for f in (line.g, line.moment, line.squared))
    punch = solved.stiffness / solved.radius, solved.punch_edge
    if m == 0.0:
        return np.array([*punch, 1.0, 1.0, 1.0])
    return np.array([*punch, 1.0 - solved.lift / g, 1.0 + solved.force * h / m, 1.0 + solved.energy * h / s])


def solve_contact(kernel: Kernel, outline: Outline) -> tuple[Solved, FloatArray, int]:
    """
    The contact of one radius, with more nodes until two solutions agree.

    Returns
    -------
    solved : Solved
    error : ndarray
        Relative errors of its :func:`numbers`, shape (5,).
    order : int
        Nodes of a panel that it took.
    """
    if not outline.radius <= WIDEST * (1.0 + 1e-12):
        raise ConvergenceError(
            f"the contact radius is above the limit of {WIDEST:g} thicknesses of the top layer ({metres(WIDEST * outline.thickness)}); "
            "treat the layer as an elastic foundation, or omit it"
        )
    worst, least, before = math.inf, math.inf, np.full(5, math.nan)
    for order in ORDERS[1 if kernel.softening(outline.radius) < _SOFT else 0 :]:
        try:
            solution = _solved(kernel, outline, order)
        except np.linalg.LinAlgError:
            before, worst = np.full(5, math.nan), math.inf
            continue
        now = numbers(solution, outline)
        if not np.all(now > 0.0):
            before, worst = np.full(5, math.nan), math.inf
            continue
        error = np.abs(now - before) / now
        worst = float(np.max(error)) if np.all(np.isfinite(error)) else math.inf
        # differences that no longer fall are rounding
        if worst <= _AGREE or (worst < _DOUBT and worst >= 0.5 * least):
            return solution, error, order
        before, least = now, min(least, worst)
    if worst < _DOUBT:
        return solution, error, order
    raise ConvergenceError(
        f"a contact radius of {outline.radius:.4g} thicknesses of the top layer is not resolved: solutions with {ORDERS[-2]} and "
        f"{ORDERS[-1]} nodes per panel differ by {worst:.1g}; reduce the load, or use layers that differ less"
    )


def solve_at_order(kernel: Kernel, outline: Outline, order: int) -> FloatArray:
    """The :func:`numbers` of a contact whose neighbour took an order."""
    return numbers(_solved(kernel, outline, order), outline)
