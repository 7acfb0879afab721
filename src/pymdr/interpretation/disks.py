"""The depths at which a contact without adhesion is a disk, as intervals.

A disk of radius a with g(a) = d is the contact where its pressure is nowhere negative and its gap is nowhere negative
(together they are the unilateral conditions, whose solution is unique). Along a stretch on which g rises,

    d/da int_r^a g' / sqrt(x^2 - r^2) dx = g'(a) / sqrt(a^2 - r^2)  >= 0   for every r inside,
    d/da int_a^r g' arccos(x / r) dx     = -g'(a) arccos(a / r)     <= 0   for every r outside,

so the disks of a stretch without tension are those beyond a radius, the disks without another touch are those before
a radius, and what is both is one interval. Its ends are found by the extreme radius r, refined between those that
resolve g', and the root in a for that r, in turn; no depth is sampled.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from pymdr.line.foundation import touching_radius
from pymdr.mapping.equivalent import EquivalentProfile, rising_root
from pymdr.units import FloatArray

TOLERANCE = 1e-10
"""Of the mean pressure and the indentation: what rounding can do to a certificate."""
_LEAST_TRUSTED = 1e-6
_ROUNDING = 1e-12
"""Of the slope: a smaller jump is none."""
RING = 1e-3
"""Of the contact radius: how wide a ring beside a concave kink may be that a disk passes over."""
_INWARD = 2.0**-12
"""Of the first radius at which g falls: where the least pressure is searched from."""
_REFINED = 16
"""Most local minima that are refined at once."""
_STEPS = 60


@dataclass(frozen=True)
class Fall:
    """A stretch on which g falls; without width beside a concave kink whose fall is thinner than rounding."""

    start: float
    stop: float
    size: float
    """How far it falls in m."""


@dataclass(frozen=True)
class Extreme:
    """The least of a pressure or gap over the radii."""

    radius: float
    """In m."""
    value: float
    """Pressure over the mean pressure, or gap over the indentation."""


@dataclass(frozen=True)
class Landscape:
    """What of an equivalent profile decides where its contacts are disks."""

    equivalent: EquivalentProfile
    top: float
    """Radius in m up to which bodies might touch."""
    falls: tuple[Fall, ...]
    dents: tuple[float, ...]
    """Radii in m of concave kinks, where the slope of f falls."""
    radii: FloatArray
    """Radii in m between which g bends little."""
    tolerance: float
    """Of the mean pressure: what the measured error of g' can do."""


@dataclass(frozen=True)
class DiskDepths:
    """Where contacts are disks, as intervals of depth."""

    strict: tuple[tuple[float, float], ...]
    """Lowest and highest depth in m of every interval, rising."""
    nearly: tuple[tuple[float, float], ...]
    """The same where rings beside concave kinks, narrower than 1e-3 of the contact radius, are passed over."""
    landscape: Landscape | None
    """None where every contact is a disk."""


def seen_upto(equivalent: EquivalentProfile, depth: float) -> float:
    """The radius in m up to which bodies at a depth in m might touch."""
    return min(touching_radius(equivalent, depth), equivalent.edge, equivalent.reach)


@lru_cache(maxsize=128)
def disk_depths(equivalent: EquivalentProfile, deepest: float) -> DiskDepths:
    """
    The depths up to a deepest one at which the contact of a profile is a disk.

    Parameters
    ----------
    equivalent : EquivalentProfile
        g(x).
    deepest : float
        In m.

    Returns
    -------
    DiskDepths
        Depths without contact are among them.

    Notes
    -----
    Conditions of Signorini (1959); the disk that satisfies them carries most (Barber 1974).

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> disk_depths(equivalent_profile(Paraboloid(1.0)), 1.0).strict
    ((-inf, inf),)
    """
    whole = ((-math.inf, math.inf),)
    top = 0.0 if equivalent.rises else seen_upto(equivalent, deepest)
    if top == 0.0:
        return DiskDepths(whole, whole, None)
    landscape = landscape_of(equivalent, top)
    if landscape is None:
        return DiskDepths(whole, whole, None)
    found = []
    for loose in (False, True) if landscape.dents else (False,):
        intervals = [(-math.inf, _first_touch(landscape))]
        stretches = _rising(landscape, deepest)
        with np.errstate(divide="ignore", invalid="ignore"):
            for low, high in stretches:
                radii = _disks_between(landscape, low, high, loose)
                if radii is not None:
                    ends = equivalent.g(np.array(radii))
                    last = math.inf if high == top < equivalent.edge else float(ends[1])
                    intervals.append((float(ends[0]) if radii[0] > 0.0 else 0.0, last))
            if top >= equivalent.edge and (loose or not any(b < top for b in landscape.dents)):
                intervals.append((_least_depth_at_edge(landscape, loose), math.inf))
        found.append(_joined(intervals))
    return DiskDepths(found[0], found[-1], landscape)


def landscape_of(equivalent: EquivalentProfile, top: float) -> Landscape | None:
    """What decides where contacts are disks up to a radius in m; None where g rises all the way."""
    turning = equivalent.turning_points(top)
    dents = _dents(equivalent, top)
    if not turning and not dents:
        return None
    falls = _falls(equivalent, turning, dents, top)
    radii = _candidates(equivalent, falls, top)
    error = equivalent.error(radii)[:, 1]
    tolerance = float(np.clip(4.0 * np.max(error, initial=0.0), TOLERANCE, _LEAST_TRUSTED))
    return Landscape(equivalent, top, falls, dents, radii, tolerance)


def _dents(equivalent: EquivalentProfile, top: float) -> tuple[float, ...]:
    """Radii of concave kinks, whose jump is more than what the error of the slope can do."""
    corners = np.array(equivalent.corners(top)).reshape(-1, 2)
    radii, jumps = corners[corners[:, 1] < 0.0].T
    error = np.maximum(4.0 * equivalent.error(radii)[:, 1], _ROUNDING)
    return tuple(radii[-jumps > error * np.abs(equivalent.slope(radii))].tolist())


def _falls(
    equivalent: EquivalentProfile, turning: Sequence[float], dents: Sequence[float], top: float
) -> tuple[Fall, ...]:
    marks = [*turning, top] if (len(turning) % 2 == 1) else [*turning]
    ends = [(marks[i], marks[i + 1]) for i in range(0, len(marks), 2)]
    for b in dents:
        beside = [i for i, (start, _) in enumerate(ends) if abs(start - b) <= 1e-9 * b]
        if beside:
            ends[beside[0]] = (b, max(ends[beside[0]][1], b))
        elif not any(start < b < stop for start, stop in ends):
            ends.append((b, b))
    ends.sort()
    g = equivalent.g(np.array(ends).ravel()).reshape(-1, 2)
    return tuple(
        Fall(start, stop, max(float(first - last), 0.0))
        for (start, stop), (first, last) in zip(ends, g, strict=True)
    )


def _candidates(equivalent: EquivalentProfile, falls: Sequence[Fall], top: float) -> FloatArray:
    """Radii among which least pressures and gaps are looked for before they are refined."""
    marks = np.array(sorted({0.0, top, *(end for fall in falls for end in (fall.start, fall.stop))}))
    first = float(marks[1])
    count = max(3, min(24, 768 // marks.size))
    inner = 0.5 - 0.5 * np.cos(np.pi * (np.arange(count) + 0.5) / count)
    between = (marks[:-1, None] + np.diff(marks)[:, None] * inner).ravel()
    steps = np.array([0.1, 0.3, 0.6, 1.0, 2.0, 4.0])
    beside = np.array(
        [(f.start - (f.stop - f.start) * steps, f.stop + (f.stop - f.start) * steps) for f in falls]
    ).ravel()
    toward_tip = first * 2.0 ** -np.arange(0.0, -math.log2(_INWARD), 0.25)
    resolving = equivalent.resolving_radii(top)
    radii = np.unique(np.concatenate([between, beside, toward_tip, resolving, marks]))
    radii = radii[(radii >= _INWARD * first) & (radii <= top)]
    return np.asarray(radii[np.append(True, np.diff(radii) > 1e-12 * radii[1:])])


def _rising(landscape: Landscape, deepest: float) -> list[tuple[float, float]]:
    """The stretches on which g rises, as far as they belong to depths that are asked for."""
    if deepest <= 0.0:
        return []
    falls = landscape.falls
    starts = [0.0, *(fall.stop for fall in falls)]
    stops = [*(fall.start for fall in falls), landscape.top]
    g = landscape.equivalent.g
    found = []
    for low, high in zip(starts, stops, strict=True):
        if not high > low:
            continue
        bottom, end = g(np.array([low, high])).tolist()
        if bottom >= deepest or end <= 0.0:
            continue
        if end > deepest:
            high = float(rising_root(g, deepest, low, high))
        if bottom < 0.0:
            low = max(low, float(rising_root(g, 0.0, low, high)))
        found.append((low, high))
    return found


def _disks_between(landscape: Landscape, low: float, high: float, loose: bool) -> tuple[float, float] | None:
    """The least and largest radius of the disks of a stretch on which g rises."""
    if not loose and any(b <= low for b in landscape.dents):
        return None
    if _near_fault(landscape, low, high, loose):
        return None
    last = _last_without_touch(landscape, low, high, loose)
    if last is None:
        return None
    first = _first_without_tension(landscape, low, last, loose)
    return None if first is None else (first, last)


def _near_fault(landscape: Landscape, low: float, high: float, loose: bool) -> bool:
    """Whether a few radii in the next falls already rule a stretch out."""
    before = np.array(
        [f.start + s * (f.stop - f.start) for f in landscape.falls if f.stop <= low for s in (0.0, 0.5)]
    )
    if before.size:
        r = _without_windows(landscape, before[-8:], high, loose)
        if r.size and pressure_ratios(landscape, high, 0.0, r).min() < -landscape.tolerance:
            return True
    beyond = np.array([f.stop for f in landscape.falls if f.start >= high])[:4]
    r = _without_windows(landscape, beyond, low, loose)
    return low > 0.0 and bool(r.size) and bool(gap_ratios(landscape, low, 0.0, r).min() < -TOLERANCE)


def _first_without_tension(landscape: Landscape, low: float, high: float, loose: bool) -> float | None:
    if low == 0.0 or least_pressure(landscape, high, 0.0, low, loose).value < -landscape.tolerance:
        return None if low > 0.0 else 0.0
    return _approached(
        low,
        high,
        lambda a: least_pressure(landscape, a, 0.0, low, loose),
        lambda a, r: float(pressure_ratios(landscape, a, 0.0, np.array([r]))[0]),
        landscape.tolerance,
    )


def _last_without_touch(landscape: Landscape, low: float, high: float, loose: bool) -> float | None:
    if high >= landscape.top:
        return high
    beyond = landscape.radii[landscape.radii > high]
    lowest = float(np.min(landscape.equivalent.g(beyond), initial=math.inf))
    bottom, end = landscape.equivalent.g(np.array([low, high])).tolist()
    if lowest >= end:
        return high
    if low > 0.0 and least_gap(landscape, low, 0.0, high, loose).value < -TOLERANCE:
        return None
    if lowest > bottom and low == 0.0:
        # nothing is below g(a) outside, so no gap is negative
        low = 0.5 * float(rising_root(landscape.equivalent.g, lowest, low, high))
    elif low == 0.0:
        low = 1e-9 * high
        if least_gap(landscape, low, 0.0, high, loose).value < -TOLERANCE:
            return None
    return _approached(
        high,
        low,
        lambda a: least_gap(landscape, a, 0.0, high, loose),
        lambda a, r: float(gap_ratios(landscape, a, 0.0, np.array([r]))[0]),
        TOLERANCE,
    )


def _approached(
    bad: float,
    good: float,
    least: Callable[[float], Extreme],
    ratio: Callable[[float, float], float],
    tolerance: float,
) -> float:
    """The radius nearest to the bad end at which the least ratio is allowed, by its extreme and a root in turn."""
    from scipy.optimize import brentq

    a = bad
    for _ in range(_STEPS):
        worst = least(a)
        if worst.value >= -tolerance or a == good:
            return a

        def above(x: float, r: float = worst.radius) -> float:
            return ratio(x, r) + 0.5 * tolerance

        if not above(good) > 0.0:
            return good
        new = float(brentq(above, min(a, good), max(a, good), xtol=1e-15 * max(a, good), rtol=1e-14))
        if new == a:
            return a
        a = new
    return a


def _first_touch(landscape: Landscape) -> float:
    """The depth at which the first point touches, min f, at most 0."""
    least = _least(
        landscape.radii,
        lambda r: 2.0 / math.pi * landscape.equivalent.gap_integral(r, 0.0),
        np.zeros(landscape.radii.size, dtype=int),
    )
    size = float(np.max(np.abs(landscape.equivalent.g(landscape.radii)), initial=0.0))
    return least.value * (1.0 - TOLERANCE) if least.value < -TOLERANCE * 1e-3 * size else 0.0


def _least_depth_at_edge(landscape: Landscape, loose: bool) -> float:
    """The depth at which a contact up to a sharp edge is without tension, g(b) + max (-int g' ...) sqrt(b^2 - r^2)."""
    equivalent, b = landscape.equivalent, landscape.equivalent.edge
    r = _without_windows(landscape, landscape.radii[landscape.radii < b], b, loose)

    def scaled(at: FloatArray) -> FloatArray:
        return equivalent.pressure_integral(at, b) * np.sqrt((b - at) * (b + at))

    needed = max(0.0, -_least(r, scaled, _segments(landscape, r)).value)
    g = float(equivalent.g(np.array([b]))[0])
    size = float(np.max(np.abs(equivalent.g(landscape.radii)), initial=0.0))
    return g + needed - 4.0 * TOLERANCE * size * (needed > 0.0)


def pressure_ratios(landscape: Landscape, a: float, excess: float, r: FloatArray) -> FloatArray:
    """Pressures of a disk over its mean pressure."""
    equivalent = landscape.equivalent
    p = equivalent.pressure_integral(r, a)
    if excess > 0.0:
        p = p + excess / np.sqrt((a - r) * (a + r))
    moment = float(equivalent.moment(np.array([a]))[0]) + a * excess
    finite = p[np.isfinite(p)]
    return np.asarray(p / max(2.0 * moment / (a * a), 1e-13 * float(np.max(np.abs(finite), initial=1e-300))))


def gap_ratios(landscape: Landscape, a: float, excess: float, r: FloatArray) -> FloatArray:
    """Gaps outside a disk over its indentation, or over rounding of g where that is more."""
    equivalent = landscape.equivalent
    h = equivalent.gap_integral(r, a)
    if excess != 0.0:
        h = h - excess * np.arctan2(np.sqrt((r - a) * (r + a)), a)
    d = abs(float(equivalent.g(np.array([a]))[0]) + excess) if a > 0.0 else 0.0
    return np.asarray(2.0 / math.pi * h / np.maximum(d + 1e-3 * np.abs(equivalent.g(r)), 1e-300))


def least_pressure(landscape: Landscape, a: float, excess: float, upto: float, loose: bool) -> Extreme:
    """The least pressure of a disk between its centre and a radius up to which g is not known to rise."""
    r = _without_windows(landscape, landscape.radii[landscape.radii < min(upto, a)], a, loose)
    return _least(r, lambda at: pressure_ratios(landscape, a, excess, at), _segments(landscape, r))


def least_gap(landscape: Landscape, a: float, excess: float, beyond: float, loose: bool) -> Extreme:
    """The least gap outside a disk, from a radius on up to which g is known to rise."""
    start = max(beyond, a)
    width = max(landscape.top - start, 0.0)
    r = np.concatenate([start + width * 4.0 ** -np.arange(24.0, 3.0, -1.0), landscape.radii])
    r = _without_windows(landscape, np.unique(r[r > start]), a, loose)
    return _least(r, lambda at: gap_ratios(landscape, a, excess, at), _segments(landscape, r))


def _without_windows(landscape: Landscape, r: FloatArray, a: float, loose: bool) -> FloatArray:
    """Radii outside the windows beside concave kinks, with the ends of the windows."""
    if not loose or r.size == 0:
        return r
    low, high = r[0], r[-1]
    for b in landscape.dents:
        half = 0.5 * RING * a
        ends = np.array([b - half, b + half])
        r = np.concatenate([r[np.abs(r - b) > half], ends[(ends > low) & (ends < high)]])
    return np.unique(r)


def _segments(landscape: Landscape, r: FloatArray) -> np.ndarray:
    """The number of concave kinks below each radius: minima are not refined across them."""
    return np.searchsorted(np.array(landscape.dents), r)


def _least(r: FloatArray, function: Callable[[FloatArray], FloatArray], segment: np.ndarray) -> Extreme:
    """The least value over radii, refined between neighbours."""
    from scipy.optimize import elementwise

    if r.size == 0:
        return Extreme(math.nan, math.inf)
    values = function(r)
    at = int(np.argmin(values))
    best = Extreme(float(r[at]), float(values[at]))
    inner = np.arange(1, r.size - 1)
    low = (values[inner] <= values[inner - 1]) & (values[inner] <= values[inner + 1])
    low &= (values[inner] < values[inner - 1]) | (values[inner] < values[inner + 1])
    low &= (segment[inner - 1] == segment[inner + 1]) & np.isfinite(values[inner - 1] + values[inner + 1])
    chosen = inner[low]
    chosen = chosen[np.argsort(values[chosen])][:_REFINED]
    if chosen.size == 0:
        return best
    found = elementwise.find_minimum(
        function, (r[chosen - 1], r[chosen], r[chosen + 1]), tolerances={"xrtol": 1e-9}, maxiter=30
    )
    refined = int(np.argmin(found.f_x))
    if found.f_x[refined] < best.value:
        return Extreme(float(found.x[refined]), float(found.f_x[refined]))
    return best


def _joined(intervals: list[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Intervals that touch or overlap in one; ends that differ by rounding touch."""
    found: list[tuple[float, float]] = []
    for low, high in sorted(intervals):
        if high < low:
            continue
        if found and low <= found[-1][1] + TOLERANCE * abs(low):
            found[-1] = (found[-1][0], max(found[-1][1], high))
        else:
            found.append((low, high))
    return tuple(found)


def holes(intervals: Sequence[tuple[float, float]], deepest: float) -> list[tuple[float, float]]:
    """
    What rising intervals from -inf on leave out up to a depth.

    Examples
    --------
    >>> holes(((-math.inf, 1.0), (2.0, 3.0)), 5.0)
    [(1.0, 2.0), (3.0, 5.0)]
    """
    left = [(first[1], second[0]) for first, second in pairwise(intervals) if first[1] < deepest]
    if intervals[-1][1] < deepest:
        left.append((intervals[-1][1], deepest))
    return [(low, min(high, deepest)) for low, high in left]
