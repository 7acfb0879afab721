"""Moves of a contact in indentation and twist: segments of its springs, their loads, torque, energy, traction and displacement."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pymdr.line.torsion.limits import Limit, TwistedLine, nodes_above
from pymdr.numerics.quadrature import gauss
from pymdr.numerics.roots import roots_of
from pymdr.units import FloatArray

_TERMS = 20
_OCTAVES = 34
_FEW_OCTAVES = 6
"""Toward the axis, for integrands with a factor x^2."""
_KINKS = 14
"""Panels above the kinks of g, each four times as long as the one before, for tractions next to kinks."""
_LEAST_DROP = 1e-11
"""Of the largest load: steps of the load below it are those of a border between stick and slip, which is found to rounding."""


@dataclass(frozen=True)
class Segment:
    """Springs between two radii with Q = constant + sign Q_max(x) - rate g(x)."""

    low: float
    high: float
    constant: float = 0.0
    """In Pa."""
    sign: int = 0
    limit: Limit | None = None
    """The limit Q_max that these springs reached, if they have a sign."""
    rate: float = 0.0
    """In Pa/m, of springs that entered while the body turned."""

    def slips(self, indentation: float) -> bool:
        """Whether the springs are at their limit at an indentation."""
        return self.limit is not None and self.limit.depth == indentation and self.constant == 0.0


def load_of(line: TwistedLine, segment: Segment, x: FloatArray) -> FloatArray:
    """Q in Pa of some springs of a segment."""
    q = np.full(x.shape, segment.constant)
    if segment.limit is not None:
        q = q + segment.sign * segment.limit.load(x)
    return q - segment.rate * line.line.equivalent.g(x) if segment.rate else q


def load_slope(line: TwistedLine, segment: Segment, x: FloatArray) -> FloatArray:
    """Derivative of :func:`load_of` over x in Pa/m at some x in m above 0, from the right."""
    slope = np.zeros(x.shape) if segment.limit is None else segment.sign * segment.limit.slope(x)
    return slope - segment.rate * line.line.equivalent.slope(x) if segment.rate else slope


def steps_of(line: TwistedLine, segments: Sequence[Segment]) -> tuple[tuple[float, float], ...]:
    """Radii in m at which the load Q drops, with the drops in Pa: of springs that entered a contact already twisted, and at its edge."""
    borders = np.array([one.high for one in segments])
    inner = np.array(
        [float(load_of(line, one, at)[0]) for one, at in zip(segments, borders[:, None], strict=True)]
    )
    outer = [
        float(load_of(line, one, at)[0]) for one, at in zip(segments[1:], borders[:-1, None], strict=True)
    ]
    drops = inner - np.append(outer, [0.0] * bool(segments))
    size = np.max(np.abs([*inner, *(one.constant for one in segments)]), initial=0.0)
    steep = np.abs(drops) > _LEAST_DROP * size
    return tuple(zip(borders[steep].tolist(), drops[steep].tolist(), strict=True))


def torque_of(line: TwistedLine, segments: Iterable[Segment]) -> float:
    """M = 2 int x^2 Q dx in N m."""
    total = 0.0
    for one in segments:
        total += 2.0 / 3.0 * one.constant * (one.high**3 - one.low**3)
        if one.limit is not None:
            low, high = one.limit.torque(np.array([one.low, one.high]))
            total += one.sign * float(low - high)
        if one.rate:
            x, weights = nodes_of(line, one.low, one.high)
            total -= 2.0 * one.rate * float(np.sum(weights * x**2 * line.line.equivalent.g(x)))
    return total


def energy_of(line: TwistedLine, segments: Iterable[Segment]) -> float:
    """U = int x^2 Q^2 dx / (8 G) in J."""
    total = 0.0
    for one in segments:
        if one.sign or one.rate:
            x, weights = nodes_of(line, one.low, one.high)
            total += float(np.sum(weights * x**2 * load_of(line, one, x) ** 2))
        else:
            total += one.constant**2 * (one.high**3 - one.low**3) / 3.0
    return total / (8.0 * line.shear)


def traction_of(line: TwistedLine, segments: Sequence[Segment], r: FloatArray) -> FloatArray:
    """
    Circumferential traction in Pa at some r above 0 in m, below the contact radius.

    tau = -(r/2 pi) int_r^a dQ(x)/sqrt(x^2 - r^2), with x^2 = r^2 + y^2 and every step of Q, the last at the edge.
    """
    total = np.zeros(r.shape)
    innermost = float(np.min(r, initial=math.inf))
    for one in segments:
        if one.high <= innermost or not (one.sign or one.rate):
            continue
        inside = max(one.low, innermost, 1e-10 * one.high)
        base, low, high = _panels(line, inside, one.high, _OCTAVES)
        root, width = np.sqrt(low - base), np.sqrt(high - base) - np.sqrt(low - base)
        u = np.cos(math.pi * (np.arange(_TERMS) + 0.5) / _TERMS)
        at = base + (root + width * (u[:, None] + 1.0) / 2.0) ** 2
        values = load_of(line, one, at.ravel()).reshape(_TERMS, -1)
        series = np.polynomial.chebyshev.chebfit(u, values, _TERMS - 1)
        slopes = np.asarray(np.polynomial.chebyshev.chebder(series), dtype=np.float64)
        # shorter panels next to kinks, of the same series: the rounding of loads would be a larger part of theirs
        longer = low
        base, low, high = _panels(line, inside, one.high, _OCTAVES, _KINKS)
        of = np.searchsorted(longer, low, side="right") - 1
        slopes, root, width = slopes[:, of], root[of], width[of]
        inner, start, stop = (
            np.sqrt(np.maximum((end - r[:, None]) * (end + r[:, None]), 0.0)) for end in (base, low, high)
        )
        offset, weights = nodes_above(inner, start, stop)
        y = start[:, :, None] + offset
        x = np.sqrt(r[:, None, None] ** 2 + y**2)
        # x less the base without cancellation
        above = ((start - inner)[:, :, None] + offset) * (y + inner[:, :, None])
        nearest = np.maximum(r[:, None], base)[:, :, None]
        above = above / (x + nearest) + (nearest - base[:, None])
        v = np.sqrt(np.clip(above, np.maximum(low - base, 1e-300)[:, None], (high - base)[:, None]))
        rates = _series(slopes, 2.0 * (v - root[:, None]) / width[:, None] - 1.0) / (v * width[:, None] * x)
        total -= np.sum(weights * rates, axis=(1, 2))
    for radius, drop in steps_of(line, segments):
        with np.errstate(divide="ignore"):
            total += np.where(r <= radius, drop / np.sqrt(np.maximum((radius - r) * (radius + r), 0.0)), 0.0)
    return np.asarray(r / (2.0 * math.pi) * total)


def displacement_of(line: TwistedLine, segments: Iterable[Segment], r: FloatArray) -> FloatArray:
    """
    Circumferential displacement in m at some r above 0 in m.

    u = (4/pi r) int_0^min(r, a) x w dx/sqrt(r^2 - x^2), w = x Q/(8 G), with x = r sin(angle).
    """
    total = np.zeros(r.shape)
    for one in segments:
        panels = _panels(line, one.low, one.high, _FEW_OCTAVES)
        base, start, stop = (np.arcsin(np.minimum(end / r[:, None], 1.0)) for end in panels)
        angle, weights = nodes_above(base, start, stop)
        x = r[:, None, None] * np.sin(start[:, :, None] + angle)
        q = load_of(line, one, np.minimum(x, one.high).ravel()).reshape(x.shape)
        total += np.sum(weights * x**2 * q, axis=(1, 2))
    return np.asarray(4.0 / (math.pi * r) * total / (8.0 * line.shear))


def nodes_of(line: TwistedLine, low: float, high: float) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of integrals between two radii."""
    base, start, stop = _panels(line, low, high, _FEW_OCTAVES)
    offset, weights = nodes_above(base, start, stop)
    return (start[:, None] + offset).ravel(), weights.ravel()


def _panels(
    line: TwistedLine, low: float, high: float, octaves: int, above_kinks: int = 0
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Base, start and end of panels between two radii; the variable is the root of the distance from the base.

    Loads have roots above the kinks of g, and logarithms at the axis: the base is the last of these points below a panel. Panels are in
    octaves toward the axis.
    """
    points, marks = line.marks(high)
    toward_axis = high * 0.5 ** np.arange(octaves, 0.0, -1.0)
    gaps = np.diff(np.append(points, high))[1:, None]
    toward_kinks = points[1:, None] + gaps * 0.25 ** np.arange(above_kinks, 0.0, -1.0)
    inside = np.concatenate([toward_axis, marks, toward_kinks.ravel()])
    edges = np.unique(np.concatenate([[low], inside[(inside > low) & (inside < high)], [high]]))
    return points[np.searchsorted(points, edges[:-1], side="right") - 1], edges[:-1], edges[1:]


def _series(coefficients: FloatArray, u: FloatArray) -> FloatArray:
    """Chebyshev series of panels, shape (terms, panels), at u of shape (..., panels, nodes)."""
    last, before = np.zeros(u.shape), np.zeros(u.shape)
    for term in coefficients[:0:-1]:
        last, before = term[:, None] + 2.0 * u * last - before, last
    return np.asarray(coefficients[0][:, None] + u * last - before)


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
    indentation, twist : float
        Targets in m and rad.

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
