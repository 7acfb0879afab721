"""Rolling on the line: springs that enter free of stress at the leading edge and are sheared up to the limit of friction.

In lengths, with q / (mu E*) for the line load: a spring enters at x = a, rises by `rise` = G* zeta / (mu E*) per length
rolled, and is capped by the cap d - g(x). With t = a - x the steady state is the lowest line of that slope from what
lies before, q(t) = min(0, cap(s) - rise s over s <= t) + rise t: exact for any g, with slip and stick in any order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pymdr.line.foundation import DiskStates, ElasticLine
from pymdr.numerics.quadrature import gauss
from pymdr.numerics.roots import boundary
from pymdr.units import FloatArray

_NODES, _GRADES, _COARSE = 12, 46, 65
_MOST = 4096
"""Largest number of nodes in halving cells."""
_ROUNDING = 1e-14


@dataclass(frozen=True)
class RollingLine:
    """A pressed line, resolved so finely that g and g' are smooth between its nodes."""

    line: ElasticLine
    depth: float
    """d in m."""
    nodes: FloatArray
    """Nodes in m, rising from 0 to the contact radius."""
    slope: FloatArray
    """g' at the nodes."""
    heights: FloatArray
    """The cap at the nodes in m."""
    sums: FloatArray
    """Its integral from 0 to the nodes in m^2."""
    edge_excess: float
    """Depth in m of a sharp edge beyond g(a); 0 without one."""

    @property
    def radius(self) -> float:
        """Contact radius a in m."""
        return float(self.nodes[-1])

    def cap(self, x: FloatArray) -> FloatArray:
        """The cap d - g of friction at x on either side in m."""
        within = np.minimum(np.abs(x), self.radius)
        caps = np.maximum(self.depth - self.line.equivalent.g(within), 0.0)
        # the difference cancels next to the edge
        last = within > self.nodes[-2]
        if last.any():
            caps[last] = self.edge_excess + _fall(self.line, within[last], self.radius)
        return caps

    @property
    def whole(self) -> float:
        """The integral of the cap over the contact in m^2: F_N / E*."""
        # d a minus the integral of g cancels for a profile that is flat up to its edge
        a = np.array([self.radius])
        return float(2.0 * (self.line.equivalent.moment(a)[0] + self.radius * self.edge_excess))

    @cached_property
    def saturation(self) -> float:
        """The least rise for full slip, max g'; inf if g' is unbounded or an edge is sharp."""
        corners = self.line.equivalent.corners(self.radius)
        if self.edge_excess > 0.0 or any(0.0 < b < self.radius and jump > 0.0 for b, jump in corners):
            return math.inf
        i = int(np.argmax(self.slope))
        around = self.nodes[max(i - 1, 0)], self.nodes[min(i + 1, self.nodes.size - 1)]
        for _ in range(20):
            radii = np.linspace(*around, 9)
            slopes = self.line.equivalent.slope(radii)
            j = int(np.argmax(slopes))
            around = radii[max(j - 1, 0)], radii[min(j + 1, 8)]
        return float(max(slopes[j], self.slope[i]))


def rolling_line(line: ElasticLine, states: DiskStates) -> RollingLine:
    """
    Resolve a pressed line.

    Parameters
    ----------
    line : ElasticLine
        With a rising g, of homogeneous half-spaces.
    states : DiskStates
        One state of contact.

    Examples
    --------
    >>> from pymdr.line.foundation import states_at_depth
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0)
    >>> pressed = rolling_line(ball, states_at_depth(ball, [0.25]))
    >>> pressed.radius, pressed.saturation
    (0.5, 1.0)
    """
    a, d = float(states.contact_radius[0]), float(states.indentation[0])
    excess = float(states.edge_excess[0])
    equivalent = line.equivalent
    grading = 0.5 ** np.arange(_GRADES)
    knots = [b for b in (0.0, *equivalent.kinks(a)) if b < a]
    behind = [b + (a - b) * grading for b in knots]
    x = np.concatenate([np.linspace(0.0, a, _COARSE), equivalent.resolving_radii(a), *behind, knots])
    x = np.unique(np.clip(x, 0.0, a))
    node, weight = gauss(_NODES)
    while x.size < _MOST:
        width = np.diff(x)
        inner = (d - equivalent.g(x[:-1, None] + width[:, None] * node)) @ weight * width
        exact = np.diff(d * x - equivalent.integral(x))
        rough = (np.abs(inner - exact) > _ROUNDING * d * a) & (width > _ROUNDING * a)
        # cells resolved to rounding are not halved
        rough &= np.abs(inner - exact) > _ROUNDING * (np.abs(inner) + np.abs(exact))
        if not rough.any():
            break
        x = np.sort(np.append(x, x[:-1][rough] + 0.5 * width[rough]))
    heights = np.maximum(d - equivalent.g(x), 0.0)
    heights[-1] = excess
    return RollingLine(line, d, x, equivalent.slope(x), heights, d * x - equivalent.integral(x), excess)


def _fall(line: ElasticLine, x: FloatArray, end: float) -> FloatArray:
    """The rise of g from x to an end in m, for a g' that is smooth in between."""
    node, weight = gauss(_NODES)
    width = end - x
    return np.asarray((line.equivalent.slope(x[:, None] + width[:, None] * node) @ weight) * width)


@dataclass(frozen=True)
class _Segments:
    """Segments of the line on which cap - rise t is monotone, from the leading edge on."""

    x: FloatArray
    """Ends of the segments in m, decreasing from a to -a."""
    cap: FloatArray
    """The cap there in m."""
    least: FloatArray
    """min(0, cap - rise t) in m up to every end."""
    slips: np.ndarray
    """Whether a segment slips at its end."""
    late: np.ndarray
    """Indices of the segments that first stick and then slip."""
    parts: FloatArray
    """The integral of the cap over every segment in m^2."""


def _segments(pressed: RollingLine, rise: FloatArray) -> list[_Segments]:
    """The segments for every rise."""
    steeper = pressed.slope > rise[:, None]
    row, turn = np.nonzero(steeper[:, :-1] != steeper[:, 1:])
    slope = pressed.line.equivalent.slope
    turned, _ = boundary(
        lambda x: (slope(x) > rise[row]) == steeper[row, turn], pressed.nodes[turn], pressed.nodes[turn + 1]
    )
    integral = pressed.depth * turned - pressed.line.equivalent.integral(turned)
    more = np.stack([turned, pressed.cap(turned), integral])
    known = np.stack([pressed.nodes, pressed.heights, pressed.sums])
    return [
        _one_row(np.insert(known, turn[row == i] + 1, more[:, row == i], axis=1), one)
        for i, one in enumerate(rise.tolist())
    ]


def _one_row(nodes: FloatArray, rise: float) -> _Segments:
    """The segments between nodes, with the cap and its integral there."""
    x, cap, sums = nodes
    parts = np.diff(sums)
    x, cap = np.concatenate([x[::-1], -x[1:]]), np.concatenate([cap[::-1], cap[1:]])
    height = cap - rise * (x[0] - x)
    # nothing has slipped before the first spring enters
    least = np.minimum.accumulate(np.minimum(height, 0.0))
    slips = height[1:] < least[:-1]
    late = np.flatnonzero(slips & (height[:-1] > least[:-1]))
    return _Segments(x, cap, least, slips, late, np.concatenate([parts[::-1], parts]))


@dataclass(frozen=True)
class SteadyRolling:
    """Steady states, one entry per rise."""

    load: FloatArray
    """The integral of q / (mu E*) over the line in m^2: F_x / (mu E*)."""
    slip_length: FloatArray
    """Slipping length of the line in m."""


def steady_rolling(pressed: RollingLine, rise: FloatArray) -> SteadyRolling:
    """
    Steady rolling: F_x / (mu E*) and the slipping length.

    Parameters
    ----------
    rise : ndarray
        G* zeta / (mu E*), not below 0; one row.

    Notes
    -----
    Popov and Hess (2015), chapter 6. Stick is integrated in closed form, slip by the integral of g; the end of a slip
    zone that is shorter than the nodes by quadrature, since that difference has no digits there.

    Examples
    --------
    >>> from pymdr.line.foundation import states_at_depth
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0)
    >>> pressed = rolling_line(ball, states_at_depth(ball, [0.25]))
    >>> result = steady_rolling(pressed, np.array([0.4]))
    >>> round(float(result.load[0]) / pressed.whole, 12), round(float(result.slip_length[0]), 12)
    (0.784, 0.4)
    """
    a, node, weight = pressed.radius, *gauss(_NODES)
    load, slipping = np.zeros(rise.shape), np.zeros(rise.shape)
    whole = rise >= pressed.saturation
    load[whole], slipping[whole] = pressed.whole, 2.0 * a
    rows = np.flatnonzero((rise > 0.0) & ~whole)
    segments = _segments(pressed, rise[rows])
    if not segments:
        return SteadyRolling(load, slipping)
    steep = np.repeat(rise[rows], [each.late.size for each in segments])
    high = np.concatenate([each.x[each.late] for each in segments])
    low = np.concatenate([each.x[each.late + 1] for each in segments])
    floor = np.concatenate([each.least[each.late] for each in segments])
    begins, _ = boundary(lambda x: pressed.cap(x) - steep * (a - x) > floor, high, low)
    width = begins - low
    fresh = (pressed.cap(begins[:, None] - width[:, None] * node) @ weight) * width
    first = 0
    for i, one, each in zip(rows, rise[rows].tolist(), segments, strict=True):
        span = slice(first, first + each.late.size)
        first = span.stop
        start = np.where(each.slips, each.x[:-1], each.x[1:])
        start[each.late] = begins[span]
        parts = np.where(each.slips, each.parts, 0.0)
        parts[each.late] = fresh[span]
        # the line load at the start of every segment, and the stick part up to its slip
        q = np.minimum(each.least[:-1] + one * (a - each.x[:-1]), each.cap[:-1])
        q[0] = 0.0
        stuck = each.x[:-1] - start
        load[i] = np.sum(stuck * (q + 0.5 * one * stuck)) + parts.sum()
        slipping[i] = np.sum(start - each.x[1:])
    return SteadyRolling(load, slipping)


def line_load(pressed: RollingLine, rise: FloatArray, x: FloatArray) -> FloatArray:
    """
    The steady q / (mu E*) along the line in m.

    Parameters
    ----------
    rise : ndarray
        G* zeta / (mu E*), not below 0; one row.
    x : ndarray
        Positions in m, -a to a; rolling goes toward +x.
    """
    t, cap = pressed.radius - x, pressed.cap(x)
    loads = np.zeros((rise.size, x.size))
    for i, (one, each) in enumerate(zip(rise.tolist(), _segments(pressed, rise), strict=True)):
        before = np.searchsorted(-each.x, -x, side="right") - 1
        least = np.minimum(each.least[before], cap - one * t)
        loads[i] = np.clip(np.minimum(least, 0.0) + one * t, 0.0, cap)
    return loads


@dataclass(frozen=True)
class RolledPath:
    """The result of a path of creepages."""

    load: FloatArray
    """F_x / (mu E*) in m^2 at the end of every row."""
    error: float
    """Its change by the last halving of the spring spacing, over the integral of the cap."""


_CHANGE = 1e-6
"""Change below which the spring spacing is fine enough."""
_FEWEST, _CLOSEST = 256, 8192


def rolled_path(pressed: RollingLine, distance: FloatArray, rise: FloatArray) -> RolledPath:
    """
    March springs through the contact under creepages that are constant between rows, from a contact without traction.

    Parameters
    ----------
    distance : ndarray
        Rolled by the end of every row in m, rising, above 0.
    rise : ndarray
        G* zeta / (mu E*) of every row, of either sign.

    Returns
    -------
    RolledPath
        With as many springs, up to 8192, as change the loads by less than 1e-6.

    Notes
    -----
    Springs are carried along exactly, so nothing is smeared; trapezoids over them, and the cap between two of their
    places, err with the square of the spacing. What was before is forgotten after 2 a: rows as long as that are steady.
    """
    n, coarse = _FEWEST, march(pressed, distance, rise, _FEWEST)
    while True:
        n *= 2
        fine = march(pressed, distance, rise, n)
        change = float(np.max(np.abs(fine - coarse))) / pressed.whole
        if change <= _CHANGE or n >= _CLOSEST:
            return RolledPath(fine, change)
        coarse = fine


def march(pressed: RollingLine, distance: FloatArray, rise: FloatArray, n: int) -> FloatArray:
    """
    The loads of :func:`rolled_path` with n springs in the contact.

    Examples
    --------
    >>> from pymdr.line.foundation import states_at_depth
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0)
    >>> pressed = rolling_line(ball, states_at_depth(ball, [0.25]))
    >>> load = march(pressed, np.array([0.7, 1.3]), np.array([0.4, 0.4]), 1000)
    >>> round(float(load[1]) / pressed.whole, 5)
    0.784
    """
    a = pressed.radius
    h = 2.0 * a / n
    # one node per spring; between two nodes the last spring leaves the contact
    t: FloatArray = h * np.arange(n + 1.0)
    at_nodes = pressed.cap(a - t)
    q, phase = np.zeros(n + 1), 0.0
    loads = np.zeros(rise.shape)
    for i, (length, one) in enumerate(zip(np.diff(distance, prepend=0.0), rise.tolist(), strict=True)):
        if length >= 2.0 * a:
            sign, size = math.copysign(1.0, one), np.array([abs(one)])
            q, phase = sign * line_load(pressed, size, a - t)[0], 0.0
            loads[i] = sign * steady_rolling(pressed, size).load[0]
            continue
        left = float(length)
        while left > 0.0:
            step = min(h - phase, left)
            left -= step
            q += one * step
            phase += step
            if phase >= h * (1.0 - _ROUNDING):
                q, phase, cap = np.append(0.0, q[:-1]), 0.0, at_nodes
            else:
                cap = pressed.cap(a - (t + phase))
            q = np.clip(q, -cap, cap)
        loads[i] = _trapezoids(pressed, q, h, phase, one)
    return loads


def _trapezoids(pressed: RollingLine, q: FloatArray, h: float, phase: float, rise: float) -> float:
    """The integral of q over the contact, with springs at phase + j h from the leading edge."""
    if phase == 0.0:
        return float(h * (q.sum() - 0.5 * (q[0] + q[-1])))
    inside = q[:-1]
    cap = float(pressed.cap(np.array([pressed.radius]))[0])
    rest = h - phase
    last = min(max(float(inside[-1]) + rise * rest, -cap), cap)
    total = h * (inside.sum() - 0.5 * (inside[0] + inside[-1]))
    return float(total + 0.5 * phase * inside[0] + 0.5 * rest * (inside[-1] + last))
