"""The intervals on which g rises that may contain disks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pymdr.interpretation.disks.ends import Stretch, disks_on
from pymdr.interpretation.disks.extremes import MAX_RADII, gap_ratios, pressure_ratios, without_windows
from pymdr.interpretation.disks.features import TOLERANCE, ProfileFeatures
from pymdr.numerics.roots import rising_root
from pymdr.units import FloatArray

_SAMPLES = 9
"""Number of disks of an interval that are compared with those of others."""


def stretches_of(features: ProfileFeatures, deepest: float) -> list[Stretch]:
    """The intervals that may contain disks; with many radii, a subset excludes most intervals first."""
    ends = [
        each for each in _carrying(features, _rising(features, deepest)) if not _near_fault(features, *each)
    ]
    if features.radii.size > 2 * MAX_RADII and len(ends) > 1:
        some = features.radii[:: math.ceil(features.radii.size / MAX_RADII)]
        coarse = replace(features, radii=some)
        left = [
            each for each in _with_integrals(coarse, ends) if disks_on(coarse, each, loose=True) is not None
        ]
        ends = [(each.low, each.high) for each in left]
    return _with_integrals(features, ends)


def _with_integrals(features: ProfileFeatures, ends: Sequence[tuple[float, float]]) -> list[Stretch]:
    """Intervals with the integrals of the disks at their ends, accumulated from one end to the next."""
    equivalent, radii = features.equivalent, features.radii
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
    return [Stretch(*each, p, h) for each, p, h in zip(ends, pressures, gaps[::-1], strict=True)]


def _rising(features: ProfileFeatures, deepest: float) -> list[tuple[float, float]]:
    """The parts of the intervals on which g rises that belong to depths up to the deepest."""
    if deepest <= 0.0:
        return []
    decreasing = features.decreasing
    low = np.array([0.0, *(each.stop for each in decreasing)])
    high = np.array([*(each.start for each in decreasing), features.top])
    g = features.equivalent.g
    bottom, end = g(low), g(high)
    relevant = (high > low) & (bottom < deepest) & (end > 0.0)
    low, high, bottom, end = low[relevant], high[relevant], bottom[relevant], end[relevant]
    beyond, hollow = end > deepest, bottom < 0.0
    high[beyond] = rising_root(g, deepest, low[beyond], high[beyond])
    low[hollow] = rising_root(g, 0.0, low[hollow], high[hollow])
    return list(zip(low.tolist(), high.tolist(), strict=True))


def _carrying(features: ProfileFeatures, ends: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """
    Those intervals on which some disk may carry the largest force of all disks of its depth.

    For such disks int_0^a x^k g touches its lower convex hull over X = a^(1+k) / (1+k); between samples it exceeds its tangent
    by at most dg dX / 8.
    """
    if len(ends) < 3:
        return ends
    fraction = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    low, high = np.array(ends).T
    a = low[:, None] + (high - low)[:, None] * fraction
    g, m = features.equivalent.g(a), features.equivalent.integral(a)
    power = 1.0 + features.equivalent.exponent
    along, width = a**power / power, (high**power - low**power) / power
    x, y = np.append(0.0, along.ravel()), np.append(0.0, m.ravel())
    hull: list[int] = []
    for i in range(x.size):
        while len(hull) > 1 and (y[hull[-1]] - y[hull[-2]]) * (x[i] - x[hull[-2]]) >= (y[i] - y[hull[-2]]) * (
            x[hull[-1]] - x[hull[-2]]
        ):
            hull.pop()
        hull.append(i)
    above = m - np.interp(along, x[hull], y[hull])
    allowed = 0.25 * np.max(np.diff(g, axis=1), axis=1) * width / _SAMPLES
    allowed += 1e-14 * np.max(np.abs(m), axis=1)
    return [each for each, viable in zip(ends, above.min(axis=1) <= allowed, strict=True) if viable]


def _near_fault(features: ProfileFeatures, low: float, high: float) -> bool:
    """Whether a few radii in the next decreasing intervals already exclude an interval."""
    before = np.array(
        [f.start + s * (f.stop - f.start) for f in features.decreasing if f.stop <= low for s in (0.0, 0.5)]
    )[-8:]
    before = without_windows(features, before, high, loose=True)
    if before.size and pressure_ratios(features, high, 0.0, before).min() < -features.tolerance:
        return True
    beyond = np.array([f.stop for f in features.decreasing if f.start >= high])[:4]
    beyond = without_windows(features, beyond, low, loose=True)
    return low > 0.0 and bool(beyond.size) and bool(gap_ratios(features, low, 0.0, beyond).min() < -TOLERANCE)
