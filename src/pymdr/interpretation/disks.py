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
from dataclasses import dataclass, replace
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
_SAMPLES = 9
"""Disks of a stretch that are compared with those of others."""
_MOST = 384
"""Most radii at which a single disk is looked at."""


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
    stretches = _stretches(landscape, deepest)
    found = []
    for loose in (False, True) if landscape.dents else (False,):
        intervals = [(-math.inf, _first_touch(landscape))]
        for each in stretches:
            radii = _disks_on(landscape, each, loose)
            if radii is not None:
                ends = equivalent.g(np.array(radii))
                last = math.inf if each.high == top < equivalent.edge else float(ends[1])
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
    # at the kink itself the slope of g is infinite
    before = radii * (1.0 - 1e-6)
    error = np.maximum(4.0 * equivalent.error(before)[:, 1], _ROUNDING)
    return tuple(radii[-jumps > error * np.abs(equivalent.slope(before))].tolist())


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


@dataclass(frozen=True)
class _Stretch:
    """A stretch on which g rises, whose disks may carry most."""

    low: float
    high: float
    pressure: FloatArray
    """The pressure integral of the disk of radius `low` at the candidate radii below it."""
    gap: FloatArray
    """The gap integral outside the disk of radius `high` at the candidate radii beyond it."""


def _stretches(landscape: Landscape, deepest: float) -> list[_Stretch]:
    """The stretches that may hold disks; of many radii, some rule most stretches out before all are looked at."""
    ends = [
        each
        for each in _carrying(landscape, _rising(landscape, deepest))
        if not _near_fault(landscape, *each)
    ]
    if landscape.radii.size > 2 * _MOST and len(ends) > 1:
        some = landscape.radii[:: math.ceil(landscape.radii.size / _MOST)]
        coarse = replace(landscape, radii=some)
        left = [
            each for each in _with_integrals(coarse, ends) if _disks_on(coarse, each, loose=True) is not None
        ]
        ends = [(each.low, each.high) for each in left]
    return _with_integrals(landscape, ends)


def _with_integrals(landscape: Landscape, ends: Sequence[tuple[float, float]]) -> list[_Stretch]:
    """Stretches with the integrals of the disks at their ends; along them only what lies between is added."""
    equivalent, radii = landscape.equivalent, landscape.radii
    pressures: list[FloatArray] = []
    before = 0.0
    p = np.empty(0)
    for low, _ in ends:
        known = radii[: p.size]
        fresh = radii[(radii < low) & (np.arange(radii.size) >= p.size)]
        if low > 0.0:
            grown = p + equivalent.pressure_between(known, before, low) if known.size else p
            p = np.concatenate([grown, equivalent.pressure_integral(fresh, low)])
        pressures.append(p)
        before = low
    gaps: list[FloatArray] = []
    h = np.empty(0)
    for _, high in ends[::-1]:
        known = radii[radii.size - h.size :]
        fresh = radii[(radii > high) & (np.arange(radii.size) < radii.size - h.size)]
        h = np.concatenate(
            [equivalent.gap_integral(fresh, high), h + equivalent.gap_between(known, high, before)]
            if h.size
            else [equivalent.gap_integral(fresh, high)]
        )
        gaps.append(h)
        before = high
    return [_Stretch(*each, p, h) for each, p, h in zip(ends, pressures, gaps[::-1], strict=True)]


def _rising(landscape: Landscape, deepest: float) -> list[tuple[float, float]]:
    """The stretches on which g rises, as far as they belong to depths that are asked for."""
    if deepest <= 0.0:
        return []
    falls = landscape.falls
    starts = np.array([0.0, *(fall.stop for fall in falls)])
    stops = np.array([*(fall.start for fall in falls), landscape.top])
    g = landscape.equivalent.g
    found = []
    for low, high, bottom, end in zip(starts.tolist(), stops.tolist(), g(starts), g(stops), strict=True):
        if not high > low or bottom >= deepest or end <= 0.0:
            continue
        if end > deepest:
            high = float(rising_root(g, deepest, low, high))
        if bottom < 0.0:
            low = float(rising_root(g, 0.0, low, high))
        found.append((low, high))
    return found


def _carrying(landscape: Landscape, ends: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """
    Those stretches on which some disk may carry most of all disks of its depth.

    Such disks are where int_0^a g touches its lower convex hull; between samples it rises above its tangent by no more
    than dg h / 8.
    """
    if len(ends) < 3:
        return ends
    share = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    low, high = np.array(ends).T
    a = low[:, None] + (high - low)[:, None] * share
    g, m = landscape.equivalent.g(a), landscape.equivalent.integral(a)
    x, y = np.append(0.0, a.ravel()), np.append(0.0, m.ravel())
    hull: list[int] = []
    for i in range(x.size):
        while len(hull) > 1 and (y[hull[-1]] - y[hull[-2]]) * (x[i] - x[hull[-2]]) >= (y[i] - y[hull[-2]]) * (
            x[hull[-1]] - x[hull[-2]]
        ):
            hull.pop()
        hull.append(i)
    above = m - np.interp(a, x[hull], y[hull])
    allowed = 0.25 * np.max(np.diff(g, axis=1), axis=1) * (high - low) / _SAMPLES
    allowed += 1e-14 * np.max(np.abs(m), axis=1)
    return [each for each, viable in zip(ends, above.min(axis=1) <= allowed, strict=True) if viable]


def _near_fault(landscape: Landscape, low: float, high: float) -> bool:
    """Whether a few radii in the next falls already rule a stretch out."""
    before = np.array(
        [f.start + s * (f.stop - f.start) for f in landscape.falls if f.stop <= low for s in (0.0, 0.5)]
    )[-8:]
    before = _without_windows(landscape, before, high, loose=True)
    if before.size and pressure_ratios(landscape, high, 0.0, before).min() < -landscape.tolerance:
        return True
    beyond = np.array([f.stop for f in landscape.falls if f.start >= high])[:4]
    beyond = _without_windows(landscape, beyond, low, loose=True)
    return (
        low > 0.0 and bool(beyond.size) and bool(gap_ratios(landscape, low, 0.0, beyond).min() < -TOLERANCE)
    )


def _disks_on(landscape: Landscape, stretch: _Stretch, loose: bool) -> tuple[float, float] | None:
    """The least and largest radius of the disks of a stretch on which g rises."""
    if not loose and any(b <= stretch.low for b in landscape.dents):
        return None
    last = _last_without_touch(landscape, stretch, loose)
    if last is None:
        return None
    first = _first_without_tension(landscape, stretch, last, loose)
    return None if first is None else (first, last)


def _first_without_tension(landscape: Landscape, stretch: _Stretch, high: float, loose: bool) -> float | None:
    low, equivalent = stretch.low, landscape.equivalent
    if low == 0.0:
        return 0.0
    radii = landscape.radii[: stretch.pressure.size]

    def least(a: float) -> Extreme:
        p = stretch.pressure + (equivalent.pressure_between(radii, low, a) if a > low else 0.0)
        p = p / _mean(landscape, a, 0.0, p)
        r, p = _with_window_ends(
            landscape, radii, p, a, loose, lambda at: pressure_ratios(landscape, a, 0.0, at)
        )
        return _least(r, lambda at: pressure_ratios(landscape, a, 0.0, at), _segments(landscape, r), p)

    if least(high).value < -landscape.tolerance:
        return None
    return _approached(
        low,
        high,
        least,
        lambda a, r: float(pressure_ratios(landscape, a, 0.0, _beside_window(landscape, r, a, loose))[0]),
        landscape.tolerance,
    )


def _last_without_touch(landscape: Landscape, stretch: _Stretch, loose: bool) -> float | None:
    low, high, equivalent = stretch.low, stretch.high, landscape.equivalent
    if high >= landscape.top or stretch.gap.size == 0:
        return high
    radii = landscape.radii[landscape.radii.size - stretch.gap.size :]
    g = equivalent.g(radii)
    lowest = float(np.min(g))
    bottom, end = equivalent.g(np.array([low, high])).tolist()
    if lowest >= end:
        return high
    near = high + (float(radii[0]) - high) * 4.0 ** -np.arange(12.0, 0.0, -1.0)

    def least(a: float) -> Extreme:
        h = stretch.gap + (equivalent.gap_between(radii, a, high) if a < high else 0.0)
        h = 2.0 / math.pi * h / _depths(landscape, a, 0.0, g)
        r = np.concatenate([near, radii])
        h = np.concatenate([gap_ratios(landscape, a, 0.0, near), h])
        r, h = _with_window_ends(landscape, r, h, a, loose, lambda at: gap_ratios(landscape, a, 0.0, at))
        return _least(r, lambda at: gap_ratios(landscape, a, 0.0, at), _segments(landscape, r), h)

    if lowest > bottom:
        # nothing outside is below g(a), so no gap is negative
        good = float(rising_root(equivalent.g, lowest, low, high))
        good = 0.5 * (good + low) if low > 0.0 else 0.5 * good
    else:
        good = low if low > 0.0 else 1e-9 * high
        if least(good).value < -TOLERANCE:
            return None
    return _approached(
        high,
        good,
        least,
        lambda a, r: float(gap_ratios(landscape, a, 0.0, _beside_window(landscape, r, a, loose))[0]),
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
    g = landscape.equivalent.g(landscape.radii)
    if g.min() >= 0.0:
        return 0.0
    least = _least(
        landscape.radii,
        lambda r: 2.0 / math.pi * landscape.equivalent.gap_integral(r, 0.0),
        np.zeros(landscape.radii.size, dtype=int),
    )
    size = float(np.max(np.abs(g)))
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
    p = landscape.equivalent.pressure_integral(r, a)
    if excess > 0.0:
        p = p + excess / np.sqrt((a - r) * (a + r))
    return np.asarray(p / _mean(landscape, a, excess, p))


def _mean(landscape: Landscape, a: float, excess: float, p: FloatArray) -> float:
    """The mean of a pressure integral over a disk, or rounding of its values where that is more."""
    moment = float(landscape.equivalent.moment(np.array([a]))[0]) + a * excess
    size = float(np.max(np.abs(p), initial=1e-300, where=np.isfinite(p)))
    return max(2.0 * moment / (a * a), 1e-13 * size)


def gap_ratios(landscape: Landscape, a: float, excess: float, r: FloatArray) -> FloatArray:
    """Gaps outside a disk over its indentation, or over rounding of g where that is more."""
    h = landscape.equivalent.gap_integral(r, a)
    if excess != 0.0:
        h = h - excess * np.arctan2(np.sqrt((r - a) * (r + a)), a)
    return np.asarray(2.0 / math.pi * h / _depths(landscape, a, excess, landscape.equivalent.g(r)))


def _depths(landscape: Landscape, a: float, excess: float, g: FloatArray) -> FloatArray:
    d = abs(float(landscape.equivalent.g(np.array([a]))[0]) + excess) if a > 0.0 else 0.0
    return np.maximum(d + 1e-3 * np.abs(g), 1e-300)


def least_pressure(landscape: Landscape, a: float, excess: float, loose: bool) -> Extreme:
    """The least pressure of a disk."""
    r = _without_windows(landscape, _thinned(landscape, landscape.radii[landscape.radii < a]), a, loose)
    return _least(r, lambda at: pressure_ratios(landscape, a, excess, at), _segments(landscape, r))


def least_gap(landscape: Landscape, a: float, excess: float, loose: bool) -> Extreme:
    """The least gap outside a disk."""
    width = max(landscape.top - a, 0.0)
    near = a + width * 4.0 ** -np.arange(24.0, 3.0, -1.0)
    r = np.unique(np.concatenate([near, _thinned(landscape, landscape.radii[landscape.radii > a])]))
    r = _without_windows(landscape, r[r > a], a, loose)
    return _least(r, lambda at: gap_ratios(landscape, a, excess, at), _segments(landscape, r))


def _thinned(landscape: Landscape, r: FloatArray) -> FloatArray:
    """At most some hundreds of radii, those in the falls among them."""
    if r.size <= _MOST:
        return r
    middles = np.array([0.5 * (fall.start + fall.stop) for fall in landscape.falls])
    middles = middles[(middles > r[0]) & (middles < r[-1])]
    return np.unique(np.concatenate([r[:: math.ceil(r.size / _MOST)], middles]))


def _beside_window(landscape: Landscape, r: float, a: float, loose: bool) -> FloatArray:
    """A radius moved to the end of the window that it is in."""
    half = 0.5 * RING * a
    for b in landscape.dents if loose else ():
        if abs(r - b) < half:
            r = b + math.copysign(half, r - b)
    return np.array([r])


def _with_window_ends(
    landscape: Landscape,
    r: FloatArray,
    values: FloatArray,
    a: float,
    loose: bool,
    function: Callable[[FloatArray], FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Radii and values outside the windows beside concave kinks, with those at the ends of the windows."""
    if not loose or r.size == 0:
        return r, values
    kept = _without_windows(landscape, r, a, loose)
    old = np.isin(kept, r)
    answer = np.empty(kept.shape)
    answer[old] = values[np.isin(r, kept)]
    if not old.all():
        answer[~old] = function(kept[~old])
    return kept, answer


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


def _least(
    r: FloatArray,
    function: Callable[[FloatArray], FloatArray],
    segment: np.ndarray,
    values: FloatArray | None = None,
) -> Extreme:
    """The least value over radii, refined between neighbours where a parabola may get below 0 or the least."""
    from scipy.optimize import elementwise

    if r.size == 0:
        return Extreme(math.nan, math.inf)
    values = function(r) if values is None else values
    at = int(np.argmin(values))
    best = Extreme(float(r[at]), float(values[at]))
    i = np.arange(1, r.size - 1)
    left, here, right = values[i - 1], values[i], values[i + 1]
    low = (here <= left) & (here <= right) & ((here < left) | (here < right))
    low &= (segment[i - 1] == segment[i + 1]) & np.isfinite(left + right)
    # a parabola through three points is never lower than half of their span below the middle one, if they are smooth
    low &= here - 0.5 * (np.maximum(left, right) - here) < max(min(best.value, 0.0), best.value) + 1e-300
    chosen = i[low]
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
    if intervals[-1][1] < deepest - TOLERANCE * abs(deepest):
        left.append((intervals[-1][1], deepest))
    return [(low, min(high, deepest)) for low, high in left]
