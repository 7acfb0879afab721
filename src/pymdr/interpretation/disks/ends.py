"""The least and largest disk of a stretch on which g rises, by an extreme radius and a root in turn."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pymdr.interpretation.disks.extremes import (
    Extreme,
    beside_window,
    depths_of,
    gap_ratios,
    least_of,
    mean_of,
    pressure_ratios,
    segments,
    with_window_ends,
)
from pymdr.interpretation.disks.landscape import TOLERANCE, Landscape
from pymdr.numerics.roots import rising_root
from pymdr.units import FloatArray

_STEPS = 60


@dataclass(frozen=True)
class Stretch:
    """A stretch on which g rises, whose disks may carry most."""

    low: float
    high: float
    pressure: FloatArray
    """The pressure integral of the disk of radius `low` at the candidate radii below it."""
    gap: FloatArray
    """The gap integral outside the disk of radius `high` at the candidate radii beyond it."""


def disks_on(landscape: Landscape, stretch: Stretch, loose: bool) -> tuple[float, float] | None:
    """The least and largest radius of the disks of a stretch on which g rises."""
    if not loose and any(b <= stretch.low for b in landscape.dents):
        return None
    last = _last_without_touch(landscape, stretch, loose)
    if last is None:
        return None
    first = _first_without_tension(landscape, stretch, last, loose)
    return None if first is None else (first, last)


def _first_without_tension(landscape: Landscape, stretch: Stretch, high: float, loose: bool) -> float | None:
    low, equivalent = stretch.low, landscape.equivalent
    if low == 0.0:
        return 0.0
    radii = landscape.radii[: stretch.pressure.size]

    def least(a: float) -> Extreme:
        p = stretch.pressure + (equivalent.pressure_between(radii, low, a) if a > low else 0.0)
        p = p / mean_of(landscape, a, 0.0, p)
        r, p = with_window_ends(
            landscape, radii, p, a, loose, lambda at: pressure_ratios(landscape, a, 0.0, at)
        )
        return least_of(r, lambda at: pressure_ratios(landscape, a, 0.0, at), segments(landscape, r), p)

    if least(high).value < -landscape.tolerance:
        return None
    return _approached(
        low,
        high,
        least,
        lambda a, r: float(pressure_ratios(landscape, a, 0.0, beside_window(landscape, r, a, loose))[0]),
        landscape.tolerance,
    )


def _last_without_touch(landscape: Landscape, stretch: Stretch, loose: bool) -> float | None:
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
        h = 2.0 / math.pi * h / depths_of(landscape, a, 0.0, g)
        r = np.concatenate([near, radii])
        h = np.concatenate([gap_ratios(landscape, a, 0.0, near), h])
        r, h = with_window_ends(landscape, r, h, a, loose, lambda at: gap_ratios(landscape, a, 0.0, at))
        return least_of(r, lambda at: gap_ratios(landscape, a, 0.0, at), segments(landscape, r), h)

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
        lambda a, r: float(gap_ratios(landscape, a, 0.0, beside_window(landscape, r, a, loose))[0]),
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
        if above(a) >= 0.0:
            # the radius of the extreme lies in the window that is let pass at this end
            a = 0.5 * (a + good)
            continue
        new = float(brentq(above, min(a, good), max(a, good), xtol=1e-15 * max(a, good), rtol=1e-14))
        if new == a:
            return a
        a = new
    return a
