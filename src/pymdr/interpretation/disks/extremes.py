"""The least pressure and the least gap of a disk, with and without the rings beside concave kinks."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pymdr.interpretation.disks.landscape import Landscape
from pymdr.interpretation.punch import punch_gap, punch_pressure
from pymdr.units import FloatArray

RING = 1e-3
"""Of the contact radius: how wide a ring beside a concave kink may be that a disk passes over."""
_REFINED = 16
"""Most local minima that are refined at once."""
MOST = 384
"""Most radii at which a single disk is looked at."""


@dataclass(frozen=True)
class Extreme:
    """The least of a pressure or gap over the radii."""

    radius: float
    """In m."""
    value: float
    """Pressure over the mean pressure, or gap over the indentation."""


def pressure_ratios(landscape: Landscape, a: float, excess: float, r: FloatArray) -> FloatArray:
    """Pressures of a disk over its mean pressure."""
    p = landscape.equivalent.pressure_integral(r, a)
    if excess > 0.0:
        p = p + excess * punch_pressure(landscape.equivalent.exponent, a, r)
    return np.asarray(p / mean_of(landscape, a, excess, p))


def mean_of(landscape: Landscape, a: float, excess: float, p: FloatArray) -> float:
    """The mean of a pressure integral over a disk, or rounding of its values where that is more."""
    power = 1.0 + landscape.equivalent.exponent
    moment = float(landscape.equivalent.moment(np.array([a]))[0]) + excess * float(a**power)
    size = float(np.max(np.abs(p), initial=1e-300, where=np.isfinite(p)))
    return max(2.0 * moment / (power * a * a), 1e-13 * size)


def gap_ratios(landscape: Landscape, a: float, excess: float, r: FloatArray) -> FloatArray:
    """Gaps outside a disk over its indentation, or over rounding of g where that is more."""
    h = landscape.equivalent.gap_integral(r, a)
    if excess != 0.0:
        h = h - excess * punch_gap(landscape.equivalent.exponent, a, r)
    return np.asarray(2.0 / math.pi * h / depths_of(landscape, a, excess, landscape.equivalent.g(r)))


def depths_of(landscape: Landscape, a: float, excess: float, g: FloatArray) -> FloatArray:
    """What gaps are held against: the indentation, or rounding of g where that is more."""
    d = abs(float(landscape.equivalent.g(np.array([a]))[0]) + excess) if a > 0.0 else 0.0
    return np.maximum(d + 1e-3 * np.abs(g), 1e-300)


def least_pressure(landscape: Landscape, a: float, excess: float, loose: bool) -> Extreme:
    """The least pressure of a disk."""
    r = without_windows(landscape, _thinned(landscape, landscape.radii[landscape.radii < a]), a, loose)
    return least_of(r, lambda at: pressure_ratios(landscape, a, excess, at), segments(landscape, r))


def least_gap(landscape: Landscape, a: float, excess: float, loose: bool) -> Extreme:
    """The least gap outside a disk."""
    width = max(landscape.top - a, 0.0)
    near = a + width * 4.0 ** -np.arange(24.0, 3.0, -1.0)
    r = np.unique(np.concatenate([near, _thinned(landscape, landscape.radii[landscape.radii > a])]))
    r = without_windows(landscape, r[r > a], a, loose)
    return least_of(r, lambda at: gap_ratios(landscape, a, excess, at), segments(landscape, r))


def _thinned(landscape: Landscape, r: FloatArray) -> FloatArray:
    """At most some hundreds of radii, those in the falls among them."""
    if r.size <= MOST:
        return r
    middles = np.array([0.5 * (fall.start + fall.stop) for fall in landscape.falls])
    middles = middles[(middles > r[0]) & (middles < r[-1])]
    return np.unique(np.concatenate([r[:: math.ceil(r.size / MOST)], middles]))


def beside_window(landscape: Landscape, r: float, a: float, loose: bool) -> FloatArray:
    """A radius moved to the end of the window that it is in."""
    half = 0.5 * RING * a
    for b in landscape.dents if loose else ():
        if abs(r - b) < half:
            r = b + math.copysign(half, r - b)
    return np.array([r])


def with_window_ends(
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
    kept = without_windows(landscape, r, a, loose)
    old = np.isin(kept, r)
    answer = np.empty(kept.shape)
    answer[old] = values[np.isin(r, kept)]
    if not old.all():
        answer[~old] = function(kept[~old])
    return kept, answer


def without_windows(landscape: Landscape, r: FloatArray, a: float, loose: bool) -> FloatArray:
    """Radii outside the windows beside concave kinks, with the ends of the windows."""
    if not loose or r.size == 0:
        return r
    low, high = r[0], r[-1]
    for b in landscape.dents:
        half = 0.5 * RING * a
        ends = np.array([b - half, b + half])
        r = np.concatenate([r[np.abs(r - b) > half], ends[(ends > low) & (ends < high)]])
    return np.unique(r)


def segments(landscape: Landscape, r: FloatArray) -> np.ndarray:
    """The number of concave kinks below each radius: minima are not refined across them."""
    return np.searchsorted(np.array(landscape.dents), r)


def least_of(
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
