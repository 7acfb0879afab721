"""The least and largest disk of an interval on which g rises, alternating between an extreme radius and a root."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pymdr.interpretation.disks.extremes import (
    Extreme,
    depths_of,
    gap_ratios,
    least_of,
    mean_of,
    outside_window,
    pressure_ratios,
    segments,
    with_window_ends,
)
from pymdr.interpretation.disks.features import TOLERANCE, ProfileFeatures
from pymdr.numerics.roots import rising_root
from pymdr.units import FloatArray

_STEPS = 60


@dataclass(frozen=True)
class Stretch:
    """An interval on which g rises, whose disks may carry the largest force."""

    low: float
    high: float
    pressure: FloatArray
    """The pressure integral of the disk of radius `low` at the candidate radii below it."""
    gap: FloatArray
    """The gap integral outside the disk of radius `high` at the candidate radii beyond it."""


def disks_on(features: ProfileFeatures, stretch: Stretch, loose: bool) -> tuple[float, float] | None:
    """The least and largest radius of the disks of an interval on which g rises."""
    if not loose and any(b <= stretch.low for b in features.concave_kinks):
        return None
    last = _last_without_touch(features, stretch, loose)
    if last is None:
        return None
    first = _first_without_tension(features, stretch, last, loose)
    return None if first is None else (first, last)


def _first_without_tension(
    features: ProfileFeatures, stretch: Stretch, high: float, loose: bool
) -> float | None:
    low, equivalent = stretch.low, features.equivalent
    if low == 0.0:
        return 0.0
    radii = features.radii[: stretch.pressure.size]

    def least(a: float) -> Extreme:
        p = stretch.pressure + (equivalent.pressure_between(radii, low, a) if a > low else 0.0)
        p = p / mean_of(features, a, 0.0, p)
        r, p = with_window_ends(
            features, radii, p, a, loose, lambda at: pressure_ratios(features, a, 0.0, at)
        )
        return least_of(r, lambda at: pressure_ratios(features, a, 0.0, at), segments(features, r), p)

    if least(high).value < -features.tolerance:
        return None
    return _approached(
        low,
        high,
        least,
        lambda a, r: float(pressure_ratios(features, a, 0.0, outside_window(features, r, a, loose))[0]),
        features.tolerance,
    )


def _last_without_touch(features: ProfileFeatures, stretch: Stretch, loose: bool) -> float | None:
    low, high, equivalent = stretch.low, stretch.high, features.equivalent
    if high >= features.top or stretch.gap.size == 0:
        return high
    radii = features.radii[features.radii.size - stretch.gap.size :]
    g = equivalent.g(radii)
    lowest = float(np.min(g))
    bottom, end = equivalent.g(np.array([low, high])).tolist()
    if lowest >= end:
        return high
    near = high + (float(radii[0]) - high) * 4.0 ** -np.arange(12.0, 0.0, -1.0)

    def least(a: float) -> Extreme:
        h = stretch.gap + (equivalent.gap_between(radii, a, high) if a < high else 0.0)
        h = 2.0 / math.pi * h / depths_of(features, a, 0.0, g)
        r = np.concatenate([near, radii])
        h = np.concatenate([gap_ratios(features, a, 0.0, near), h])
        r, h = with_window_ends(features, r, h, a, loose, lambda at: gap_ratios(features, a, 0.0, at))
        return least_of(r, lambda at: gap_ratios(features, a, 0.0, at), segments(features, r), h)

    if lowest > bottom:
        # g outside is above g(a), so no gap is negative
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
        lambda a, r: float(gap_ratios(features, a, 0.0, outside_window(features, r, a, loose))[0]),
        TOLERANCE,
    )


def _approached(
    bad: float,
    good: float,
    least: Callable[[float], Extreme],
    ratio: Callable[[float, float], float],
    tolerance: float,
) -> float:
    """The radius nearest to the bad end with an acceptable least ratio, alternating between its extreme and a root."""
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
        if above(a) >= 0.0:
            # the extreme is in the window that is neglected at this end
            a = 0.5 * (a + good)
            continue
        new = float(brentq(above, min(a, good), max(a, good), xtol=1e-15 * max(a, good), rtol=1e-14))
        if new == a:
            return a
        a = new
    return a
