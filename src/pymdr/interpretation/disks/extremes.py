"""The least pressure and the least gap of a disk, with and without the rings next to concave kinks."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pymdr.interpretation.disks.features import ProfileFeatures
from pymdr.interpretation.punch import punch_gap, punch_pressure
from pymdr.units import FloatArray

RING = 1e-3
"""Largest width of a neglected ring next to a concave kink, over the contact radius."""
_MAX_REFINED = 16
"""Largest number of local minima that are refined at once."""
MAX_RADII = 384
"""Largest number of radii at which a single disk is checked."""


@dataclass(frozen=True)
class Extreme:
    """The least pressure or gap over the radii."""

    radius: float
    """In m."""
    value: float
    """Pressure over the mean pressure, or gap over the indentation."""


def pressure_ratios(features: ProfileFeatures, a: float, excess: float, r: FloatArray) -> FloatArray:
    """Pressures of a disk over its mean pressure."""
    p = features.equivalent.pressure_integral(r, a)
    if excess > 0.0:
        p = p + excess * punch_pressure(features.equivalent.exponent, a, r)
    return np.asarray(p / mean_of(features, a, excess, p))


def mean_of(features: ProfileFeatures, a: float, excess: float, p: FloatArray) -> float:
    """The mean of a pressure integral over a disk, at least the rounding of its values."""
    power = 1.0 + features.equivalent.exponent
    moment = float(features.equivalent.moment(np.array([a]))[0]) + excess * float(a**power)
    size = float(np.max(np.abs(p), initial=1e-300, where=np.isfinite(p)))
    return max(2.0 * moment / (power * a * a), 1e-13 * size)


def gap_ratios(features: ProfileFeatures, a: float, excess: float, r: FloatArray) -> FloatArray:
    """Gaps outside a disk over its indentation, at least the rounding of g."""
    h = features.equivalent.gap_integral(r, a)
    if excess != 0.0:
        h = h - excess * punch_gap(features.equivalent.exponent, a, r)
    return np.asarray(2.0 / math.pi * h / depths_of(features, a, excess, features.equivalent.g(r)))


def depths_of(features: ProfileFeatures, a: float, excess: float, g: FloatArray) -> FloatArray:
    """The reference of gaps: the indentation, at least the rounding of g."""
    d = abs(float(features.equivalent.g(np.array([a]))[0]) + excess) if a > 0.0 else 0.0
    return np.maximum(d + 1e-3 * np.abs(g), 1e-300)


def least_pressure(features: ProfileFeatures, a: float, excess: float, loose: bool) -> Extreme:
    """The least pressure of a disk."""
    r = without_windows(features, _thinned(features, features.radii[features.radii < a]), a, loose)
    return least_of(r, lambda at: pressure_ratios(features, a, excess, at), segments(features, r))


def least_gap(features: ProfileFeatures, a: float, excess: float, loose: bool) -> Extreme:
    """The least gap outside a disk."""
    width = max(features.top - a, 0.0)
    near = a + width * 4.0 ** -np.arange(24.0, 3.0, -1.0)
    r = np.unique(np.concatenate([near, _thinned(features, features.radii[features.radii > a])]))
    r = without_windows(features, r[r > a], a, loose)
    return least_of(r, lambda at: gap_ratios(features, a, excess, at), segments(features, r))


def _thinned(features: ProfileFeatures, r: FloatArray) -> FloatArray:
    """At most some hundreds of radii, including those in decreasing intervals."""
    if r.size <= MAX_RADII:
        return r
    middles = np.array([0.5 * (each.start + each.stop) for each in features.decreasing])
    middles = middles[(middles > r[0]) & (middles < r[-1])]
    return np.unique(np.concatenate([r[:: math.ceil(r.size / MAX_RADII)], middles]))


def outside_window(features: ProfileFeatures, r: float, a: float, loose: bool) -> FloatArray:
    """A radius, moved to the end of its window if it is in one."""
    half = 0.5 * RING * a
    for b in features.concave_kinks if loose else ():
        if abs(r - b) < half:
            r = b + math.copysign(half, r - b)
    return np.array([r])


def with_window_ends(
    features: ProfileFeatures,
    r: FloatArray,
    values: FloatArray,
    a: float,
    loose: bool,
    function: Callable[[FloatArray], FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Radii and values outside the windows next to concave kinks, with those at the ends of the windows."""
    if not loose or r.size == 0:
        return r, values
    kept = without_windows(features, r, a, loose)
    old = np.isin(kept, r)
    answer = np.empty(kept.shape)
    answer[old] = values[np.isin(r, kept)]
    if not old.all():
        answer[~old] = function(kept[~old])
    return kept, answer


def without_windows(features: ProfileFeatures, r: FloatArray, a: float, loose: bool) -> FloatArray:
    """Radii outside the windows next to concave kinks, with the ends of the windows."""
    if not loose or r.size == 0:
        return r
    low, high = r[0], r[-1]
    for b in features.concave_kinks:
        half = 0.5 * RING * a
        ends = np.array([b - half, b + half])
        r = np.concatenate([r[np.abs(r - b) > half], ends[(ends > low) & (ends < high)]])
    return np.unique(r)


def segments(features: ProfileFeatures, r: FloatArray) -> np.ndarray:
    """The number of concave kinks below each radius; minima are not refined across them."""
    return np.searchsorted(np.array(features.concave_kinks), r)


def least_of(
    r: FloatArray,
    function: Callable[[FloatArray], FloatArray],
    segment: np.ndarray,
    values: FloatArray | None = None,
) -> Extreme:
    """The least value over radii, refined between neighbours where a parabola may be below 0 or the least value."""
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
    # the minimum of a parabola through three points is at most half of their span below the middle one
    low &= here - 0.5 * (np.maximum(left, right) - here) < max(min(best.value, 0.0), best.value) + 1e-300
    chosen = i[low]
    chosen = chosen[np.argsort(values[chosen])][:_MAX_REFINED]
    if chosen.size == 0:
        return best
    minima = elementwise.find_minimum(
        function, (r[chosen - 1], r[chosen], r[chosen + 1]), tolerances={"xrtol": 1e-9}, maxiter=30
    )
    refined = int(np.argmin(minima.f_x))
    if minima.f_x[refined] < best.value:
        return Extreme(float(minima.x[refined]), float(minima.f_x[refined]))
    return best
