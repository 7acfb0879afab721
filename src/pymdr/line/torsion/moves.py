"""Moves of a contact in indentation and twist."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pymdr.line.torsion.limits import Limit, TwistedLine
from pymdr.line.torsion.segments import Segment, energy_of, load_of, nodes_of, torque_of, traction_of
from pymdr.numerics.quadrature import gauss
from pymdr.numerics.roots import roots_of
from pymdr.units import FloatArray

_SAMPLES = 24
"""Number of positions in a segment at which slip is searched."""
_ROUNDING = 1e-12
_RULES = (8, 16, 32)
"""Nodes of the rules for the work of slip over a move."""
_SETTLED = 1e-7
_CHECKED = np.array([0.005, 0.02, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.98, 0.995])
"""Positions in a segment at which the traction is compared with friction."""


@dataclass(frozen=True)
class TwistState:
    """A contact under torsion."""

    segments: tuple[Segment, ...] = ()
    """From the axis to the contact radius."""
    indentation: float = 0.0
    twist: float = 0.0
    torque: float = 0.0
    energy: float = 0.0
    """Elastic energy of the twist in J."""
    excess: float = 0.0
    """Largest traction beyond friction in any move so far, relative to mu p: 0 where the springs are exact."""

    @property
    def stick_radius(self) -> float:
        """Outer radius in m of the springs that stick."""
        sticks = [one.high for one in self.segments if not one.slips(self.indentation)]
        return sticks[-1] if sticks else 0.0


def turn(line: TwistedLine, state: TwistState, indentation: float, twist: float) -> TwistState:
    """
    Move a contact along a straight line in indentation and twist.

    Parameters
    ----------
    line : TwistedLine
    state : TwistState
    indentation, twist : float
        Targets in m and rad.

    Returns
    -------
    TwistState

    Notes
    -----
    Q_max is concave in the indentation, so springs that slip in a move slip up to its end: one step is exact.

    Where the slipping springs are an outer ring of one sense, the surface inside keeps its displacement and the traction outside is
    mu p, so the springs are exact as long as the traction inside is below mu p; `excess` measures that. Lubkin (1951), J. Appl.
    Mech. 18, 183-187, for spheres under constant load.
    """
    limit = line.limit_at(indentation)
    if limit.radius == 0.0:
        return TwistState((), indentation, twist)
    segments = _slipped(line, _moved(line, state, limit, twist), limit)
    torque, energy = torque_of(line, segments), energy_of(line, segments)
    excess = max(state.excess, _excess(line, segments, limit))
    return TwistState(segments, indentation, twist, torque, energy, excess)


def slip_work(line: TwistedLine, begin: TwistState, end: TwistState) -> tuple[float, float]:
    """
    Work of slip in J of a straight move, and its estimated error in J: 0 at constant indentation or twist.

    Where both change, the power of slip 2 int x^2 Q_max |ds/dt| dx with the slip s = (Q_stick - Q)/(8 G) is integrated over the move by
    rules of 8, 16 and 32 nodes until two agree.
    """
    rise, gained = end.indentation - begin.indentation, 8.0 * line.shear * (end.twist - begin.twist)
    if gained == 0.0:
        return max(begin.energy - end.energy, 0.0), 0.0
    if rise == 0.0:
        limit = line.limit_at(end.indentation)
        moved = _moved(line, begin, limit, end.twist)
        return (_slip_work(line, moved, end.segments[-1], limit) if end.segments else 0.0), 0.0

    def power(part: float) -> float:
        depth, twist = (
            start + part * (stop - start)
            for start, stop in ((begin.indentation, end.indentation), (begin.twist, end.twist))
        )
        limit = line.limit_at(depth)
        if limit.radius == 0.0:
            return 0.0
        segments = _slipped(line, _moved(line, begin, limit, twist), limit)
        return sum(_slip_power(limit, one, rise, gained) for one in segments if one.slips(depth))

    # up to where the bodies part
    last = begin.indentation / -rise if end.indentation < 0.0 else 1.0
    first = max(-begin.indentation, 0.0) / rise if begin.indentation < 0.0 else 0.0
    work = error = math.inf
    for count in _RULES:
        node, weight = gauss(count)
        # slip zones begin with a power of the motion
        total = sum(
            2.0 * v * w * power(first + (last - first) * v * v)
            for v, w in zip(node.tolist(), weight.tolist(), strict=True)
        ) * (last - first)
        error, work = abs(total - work), total
        if error <= _SETTLED * work:
            break
    return work, error


def _slip_power(limit: Limit, one: Segment, rise: float, gained: float) -> float:
    """Work of slip in J over a whole move of springs that slip all the time as they slip now."""
    line = limit.twisted
    x, weights = nodes_of(line, one.low, one.high)
    rate = np.maximum(one.sign * gained - rise * limit.rate(x), 0.0)
    return 2.0 / (8.0 * line.shear) * float(np.sum(weights * x**2 * limit.load(x) * rate))


def _moved(line: TwistedLine, state: TwistState, limit: Limit, twist: float) -> tuple[Segment, ...]:
    """The segments before they slip: cut at the new radius, or with the springs that entered."""
    indentation, radius = limit.depth, limit.radius
    gained = 8.0 * line.shear * (twist - state.twist)
    segments = [
        replace(one, high=min(one.high, radius), constant=one.constant + gained)
        for one in state.segments
        if one.low < radius
    ]
    inner = segments[-1].high if segments else 0.0
    if inner < radius:
        rise = indentation - state.indentation
        rate = gained / rise if rise > 0.0 else 0.0
        segments.append(Segment(inner, radius, rate * indentation, rate=rate))
    return tuple(segments)


def _slipped(line: TwistedLine, segments: tuple[Segment, ...], limit: Limit) -> tuple[Segment, ...]:
    """Segments whose springs are within a limit."""
    fraction = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    # closely at both ends: slip begins at the edge
    fraction = np.concatenate([[1e-9], fraction**2 * (3.0 - 2.0 * fraction), [1.0 - 1e-9]])
    done: list[Segment] = []
    for one in segments:
        at = one.low + (one.high - one.low) * fraction
        q, most = load_of(line, one, at), limit.load(at)
        sense = np.where(np.abs(q) > most * (1.0 + _ROUNDING), np.sign(q), 0.0)
        change = np.flatnonzero(np.diff(sense))
        borders = [
            one.low,
            *(_border(line, one, limit, at[i : i + 2], sense[i : i + 2]) for i in change),
            one.high,
        ]
        senses = [int(sense[0]), *(int(sense[i + 1]) for i in change)]
        for low, high, sign in zip(borders[:-1], borders[1:], senses, strict=True):
            part = Segment(low, high, 0.0, sign, limit) if sign else replace(one, low=low, high=high)
            if done and replace(done[-1], low=low, high=high) == part:
                done[-1] = replace(done[-1], high=high)
            elif high > low:
                done.append(part)
    return tuple(done)


def _border(line: TwistedLine, one: Segment, limit: Limit, at: FloatArray, sense: FloatArray) -> float:
    """The radius between two at which the springs reach their limit."""
    sign = sense[0] or sense[1]

    def excess(x: FloatArray) -> FloatArray:
        return np.asarray(sign * load_of(line, one, x) - limit.load(x))

    ends = excess(at)
    if ends[0] * ends[1] >= 0.0:
        return float(at[int(np.argmin(np.abs(ends)))])
    return float(roots_of(excess, at[:1], at[1:])[0])


def _slip_work(line: TwistedLine, moved: tuple[Segment, ...], outer: Segment, limit: Limit) -> float:
    """2 int x^2 Q_max s dx, with the slip s = (|Q| - Q_max)/(8 G) of springs that were moved beyond their limit."""
    if not outer.slips(limit.depth):
        return 0.0
    total = 0.0
    for one in moved:
        if one.high > outer.low:
            x, weights = nodes_of(line, max(one.low, outer.low), one.high)
            most = limit.load(x)
            beyond = np.maximum(outer.sign * load_of(line, one, x) - most, 0.0)
            total += float(np.sum(weights * x**2 * most * beyond))
    return 2.0 * total / (8.0 * line.shear)


def _excess(line: TwistedLine, segments: tuple[Segment, ...], limit: Limit) -> float:
    """Relative excess of the traction of sticking springs over mu p, after a decrease of the load that follows slip."""
    if all(one.limit.depth <= limit.depth for one in segments if one.limit is not None):
        return 0.0
    places = [one.low + (one.high - one.low) * _CHECKED for one in segments if not one.slips(limit.depth)]
    if not places:
        return 0.0
    r = np.concatenate(places)
    most = limit.traction(r)
    over = np.abs(traction_of(line, segments, r)) / most - 1.0
    return float(np.max(over, initial=0.0)) if np.max(over, initial=0.0) > 1e-9 else 0.0
