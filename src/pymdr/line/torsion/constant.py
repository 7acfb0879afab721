"""Twists at constant indentation: the limit of the springs as tables, on which a move is a few readings."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pymdr.line.torsion.limits import NODES, WEIGHTS, Limit
from pymdr.line.torsion.moves import Segment, TwistState
from pymdr.numerics.panels import IndexArray
from pymdr.numerics.roots import rising_root
from pymdr.numerics.table import Effort, Table, tabulated
from pymdr.units import FloatArray

_DEEPEST = 21.4
"""Largest t = arcosh(a/x): springs nearer to the axis than 1e-9 of the contact radius slip with those beside them."""
_ROUNDING = 4.0 * float(np.finfo(float).eps)
_NARROW = 2.0**-10
"""Width of a cell that is not divided further, where the slip at a sharp edge is rounding."""


class _Moments(NamedTuple):
    """Properties of the springs from some radii outward."""

    load: FloatArray
    """Q_max in Pa."""
    torque: FloatArray
    """2 int x^2 Q_max dx in N m."""
    slip: FloatArray
    """int_x^a y^2 Q_max(y) [Q_max(x) - Q_max(y)] dy in N^2/m: the slip of a first twist up to Q_max(x)."""

    @property
    def squares(self) -> FloatArray:
        """Integral of x^2 Q_max^2 in N^2/m."""
        return 0.5 * self.load * self.torque - self.slip

    def beyond(self, q: float) -> FloatArray:
        """Integral of y^2 Q_max(y) [q - Q_max(y)] in N^2/m."""
        return self.slip + 0.5 * (q - self.load) * self.torque


@dataclass(frozen=True, eq=False)
class TabulatedLimit:
    """The limit at one indentation over t = arcosh(a/x), and the inverse."""

    limit: Limit
    moments: Table
    """Q_max, the torque and the slip over t."""
    place: Table
    """T over Q_max."""
    full_slip: float
    """Torque of full slip in N m."""

    @property
    def resolved(self) -> bool:
        """Whether the tables have converged to 1e-13."""
        return self.moments.resolved and self.place.resolved

    def at(self, x: FloatArray) -> _Moments:
        """The moments of the springs from some radii in m outward."""
        return _Moments(*self.moments(self.variable(x)))

    def variable(self, x: FloatArray | float) -> FloatArray:
        """T = arcosh(a/x) at some radii in m, without cancellation at the edge, up to its largest value."""
        with np.errstate(divide="ignore"):
            t = 2.0 * np.arcsinh(np.sqrt(0.5 * np.maximum(self.limit.radius - x, 0.0) / np.asarray(x)))
        return np.asarray(np.minimum(t, _DEEPEST))

    def radius(self, q: float) -> float:
        """The radius in m at which Q_max is q in Pa: 0 or the contact radius beyond its values."""
        if q <= self.place.low[0] * (1.0 + _ROUNDING):
            return self.limit.radius
        if q >= self.place.high[-1]:
            return 0.0
        return self.limit.radius / math.cosh(self.place.at(q)[0])


def tabulated_limit(limit: Limit) -> TabulatedLimit:
    """
    Tabulate a limit.

    Parameters
    ----------
    limit : Limit
        Of a contact radius and a coefficient of friction above 0 and finite.
    """
    a = limit.radius
    inner = np.array(limit.twisted.kinks(a))[::-1]
    marks = np.concatenate([[0.0], 2.0 * np.arcsinh(np.sqrt(0.5 * (a - inner) / inner)), [_DEEPEST]])
    marks = marks[marks <= _DEEPEST]
    low, high = marks[:-1], marks[1:]
    effort = Effort(rounding=_ROUNDING * _DEEPEST, narrow=_NARROW, graded=True)

    def load(t: FloatArray, _: IndexArray) -> FloatArray:
        q = limit.load(a / np.cosh(t))
        # the integrands too are resolved
        return np.stack([q, q / np.cosh(t) ** 3])

    loads = tabulated(load, low, high, effort)
    moments = tabulated(_integrals(loads, a), low, high, effort)
    ends = moments(marks)[0]

    def place(q: FloatArray, segment: IndexArray) -> FloatArray:
        return rising_root(lambda t: moments(t)[0], q, low[segment], high[segment])[None, :]

    inverse = Effort(rounding=_ROUNDING * float(ends[-1]), narrow=_NARROW, graded=True)
    return TabulatedLimit(
        limit, moments, tabulated(place, ends[:-1], ends[1:], inverse), float(limit.torque(np.zeros(1))[0])
    )


def _integrals(loads: Table, a: float) -> Callable[[FloatArray, IndexArray], FloatArray]:
    """Q_max, the torque and the slip at t, from integrals over the cells of the loads."""

    def between(segment: IndexArray, start: FloatArray, stop: FloatArray) -> FloatArray:
        """Integrals of x^2 Q_max and x^2 Q_max^2 between two variables v of a segment, shape (2, n)."""
        v = start[:, None] + (stop - start)[:, None] * (NODES + 1.0) / 2.0
        whole = v**2 + (1.0 - v) ** 2
        length = (loads.high - loads.low)[segment][:, None]
        t = loads.low[segment][:, None] + length * v**2 / whole
        per_v = 2.0 * length * v * (1.0 - v) / whole**2
        q = loads(t.ravel(), np.repeat(segment, NODES.size))[0].reshape(t.shape)
        weight = a**3 * np.sinh(t) / np.cosh(t) ** 4 * per_v * WEIGHTS * (stop - start)[:, None] / 2.0
        return np.stack([np.sum(weight * q, axis=1), np.sum(weight * q**2, axis=1)])

    segments = np.floor(loads.keys).astype(np.intp)
    cells = between(segments, loads.start, loads.start + loads.width)
    before = np.cumsum(cells, axis=1) - cells

    def values(t: FloatArray, segment: IndexArray) -> FloatArray:
        v = np.sqrt(t - loads.low[segment])
        v /= v + np.sqrt(loads.high[segment] - t)
        cell = np.searchsorted(loads.keys, segment + v, side="right") - 1
        torque, squares = before[:, cell] + between(segment, loads.start[cell], v)
        q = loads(t, segment)[0]
        return np.stack([q, 2.0 * torque, q * torque - squares])

    return values


def turn_at_constant_depth(
    table: TabulatedLimit, state: TwistState, twist: float
) -> tuple[TwistState, float]:
    """
    Turn a contact whose springs have reached no other limit.

    Parameters
    ----------
    table : TabulatedLimit
        Of the indentation of the state.
    state : TwistState
        For which :func:`is_simple` holds.
    twist : float
        Target in rad.

    Returns
    -------
    TwistState
        After the move.
    float
        Work of slip in J.

    Notes
    -----
    Q_max falls with x, so that an outer ring slips. Of a segment Q = C + s Q_max the springs slip in a sense other than s where
    Q_max < |C|/2 (Masing), and those with s = 0 where Q_max < |C|.
    """
    limit, compliance = table.limit, 1.0 / (8.0 * table.limit.twisted.shear)
    gained = (twist - state.twist) / compliance
    sense = int(np.sign(gained))
    kept = [replace(one, constant=one.constant + gained) for one in state.segments]
    slid: list[tuple[Segment, float, float]] = []
    border = limit.radius
    while kept:
        one = kept[-1]
        q = sense * one.constant
        if one.sign == sense:
            inner = one.low if q > 0.0 else one.high
        else:
            inner = table.radius(0.5 * q if one.sign else q)
        border = min(max(inner, one.low), one.high)
        if border >= one.high:
            break
        slid.append((one, border, one.high))
        kept.pop()
        if border > one.low:
            kept.append(replace(one, high=border))
            break
    if slid:
        kept.append(Segment(border, limit.radius, 0.0, sense, limit))
    # one reading of the ends of all segments and of those that have slipped
    ends = np.array([0.0, *(one.high for one in kept), *(end for _, *pair in slid for end in pair)])
    moments, inside = table.at(ends), slice(0, len(kept) + 1)
    constant, sign = np.array([(one.constant, one.sign) for one in kept], dtype=float).T
    cubes = np.diff(ends[inside] ** 3) / 3.0
    torques, squares = -np.diff(moments.torque[inside]), -np.diff(moments.squares[inside])
    torque = float(np.sum(2.0 * constant * cubes + sign * torques))
    energy = float(np.sum(constant**2 * cubes + constant * sign * torques + sign**2 * squares))
    work = 0.0
    for i, (one, *_) in enumerate(slid):
        first = len(kept) + 1 + 2 * i
        work += _slip(_Moments(*(column[first : first + 2] for column in moments)), one, sense)
    moved = TwistState(tuple(kept), limit.depth, twist, torque, compliance * energy, state.excess)
    return moved, 2.0 * compliance * work


def twist_at_torque(table: TabulatedLimit, state: TwistState, torque: float) -> float:
    """
    The twist in rad at which :func:`turn_at_constant_depth` arrives at a torque in N m, below that of full slip.

    Notes
    -----
    The springs of one segment after the other slip, from the edge inward. While the border of slip stays at the end of a segment, the torque is
    linear in the twist; inside a segment both are functions of the border, which is searched in the table.
    """
    from scipy.optimize import brentq

    if torque == state.torque:
        return state.twist
    limit, segments = table.limit, state.segments
    sense: float = math.copysign(1.0, torque - state.torque)
    per_gain: float = sense / (8.0 * limit.twisted.shear)
    loads, beyond, _ = (c.tolist() for c in table.at(np.array([0.0, *(one.high for one in segments)])))
    within = [0.0]
    """Torque of the springs within the end of each segment, in the sense of the turn."""
    for i, one in enumerate(segments):
        stuck = 2.0 / 3.0 * one.constant * (one.high**3 - one.low**3)
        within.append(within[-1] + sense * (stuck + one.sign * (beyond[i] - beyond[i + 1])))
    wanted, gained = sense * torque, 0.0
    for i, one in reversed(list(enumerate(segments))):
        before, factor = sense * one.constant, 2.0 if one.sign else 1.0
        at_high = (wanted - within[i + 1] - beyond[i + 1]) / (2.0 / 3.0 * one.high**3)
        gained = max(gained, (0.0 if one.sign == sense else factor * loads[i + 1]) - before)
        if at_high <= gained:
            return float(state.twist + per_gain * at_high)
        if one.sign == sense:
            continue
        within_low, inner = within[i] + beyond[i] - wanted, 2.0 / 3.0 * one.low**3
        if within_low + inner * (factor * loads[i] - before) >= 0.0:
            break
        gained = factor * loads[i] - before
    else:
        return state.twist + per_gain * gained

    def excess(t: float) -> float:
        x, (q, outside, _) = limit.radius / math.cosh(t), table.moments.at(t)
        own = 2.0 / 3.0 * before * (x**3 - one.low**3) + (1.0 - sense * one.sign) * (outside - beyond[i])
        return float(within_low + own + 2.0 / 3.0 * (factor * q - before) * x**3)

    ends = (float(table.variable(x)) for x in (one.high, one.low))
    t = float(brentq(excess, *ends, xtol=1e-300, rtol=8.9e-16))
    return state.twist + per_gain * (factor * table.moments.at(t)[0] - before)


def is_simple(state: TwistState, limit: Limit) -> bool:
    """Whether no spring of a state has reached a limit other than this or entered while the body turned."""
    return state.indentation == limit.depth and all(
        one.rate == 0.0 and one.limit in (None, limit) for one in state.segments
    )


def _slip(ends: _Moments, one: Segment, sense: int) -> float:
    """Integral of x^2 Q_max (|Q| - Q_max) in N^2/m between the ends of springs that were moved beyond their limit."""
    q = sense * one.constant
    if one.sign == sense:
        parts = 0.5 * q * ends.torque
    elif one.sign:
        parts = 2.0 * ends.beyond(0.5 * q)
    else:
        parts = ends.beyond(q)
    return max(float(parts[0] - parts[1]), 0.0)
