"""Features of an equivalent profile that decide which contacts are disks: decreasing intervals and concave kinks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pymdr.line.foundation import touching_radius
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.units import FloatArray

TOLERANCE = 1e-10
"""Effect of rounding on a certificate, over the mean pressure and the indentation."""
_LEAST_TRUSTED = 1e-6
_ROUNDING = 1e-12
"""Least jump of the slope that counts, over the slope."""
_INWARD = 2.0**-12
"""Least radius of the search for the least pressure, over the first radius from which g decreases."""


@dataclass(frozen=True)
class DecreasingInterval:
    """An interval on which g decreases; of zero width at a concave kink if narrower than rounding."""

    start: float
    stop: float
    drop: float
    """Decrease of g in m."""


@dataclass(frozen=True)
class ProfileFeatures:
    """Features of an equivalent profile that decide which contacts are disks."""

    equivalent: EquivalentProfile
    top: float
    """Radius in m up to which bodies might touch."""
    decreasing: tuple[DecreasingInterval, ...]
    concave_kinks: tuple[float, ...]
    """Radii in m of concave kinks, where the slope of f falls; 0 for the apex of a hollow cone."""
    radii: FloatArray
    """Radii in m that resolve g."""
    tolerance: float
    """Effect of the measured error of g', over the mean pressure."""


def touching_range(equivalent: EquivalentProfile, depth: float) -> float:
    """The radius in m up to which bodies at a depth in m might touch."""
    return min(touching_radius(equivalent, depth), equivalent.edge, equivalent.max_radius)


def profile_features(equivalent: EquivalentProfile, top: float) -> ProfileFeatures | None:
    """Features that decide which contacts are disks up to a radius in m; None if g rises throughout."""
    turning = equivalent.turning_points(top)
    concave_kinks = _concave_kinks(equivalent, top)
    if turning and turning[0] == 0.0 and apex_kink(equivalent) < 0.0:
        concave_kinks = (0.0, *concave_kinks)
    if not turning and not concave_kinks:
        return None
    decreasing = _decreasing_intervals(equivalent, turning, concave_kinks, top)
    radii = _candidates(equivalent, decreasing, top)
    error = equivalent.error(radii)[:, 1]
    tolerance = float(np.clip(4.0 * np.max(error, initial=0.0), TOLERANCE, _LEAST_TRUSTED))
    return ProfileFeatures(equivalent, top, decreasing, concave_kinks, radii, tolerance)


def apex_kink(equivalent: EquivalentProfile) -> float:
    """The jump of f' with the same logarithmic pressure as the apex of a cone; 0 for other tips."""
    if equivalent.exponent != 0.0:
        return 0.0
    rate = 2.0 * float(equivalent.slope(np.zeros(1))[0])
    return rate if math.isfinite(rate) else 0.0


def _concave_kinks(equivalent: EquivalentProfile, top: float) -> tuple[float, ...]:
    """
    Radii of concave kinks whose jump exceeds the error of the slope.

    There the pressure is logarithmically infinite on homogeneous half-spaces; on graded ones no ring is neglected.
    """
    if equivalent.exponent != 0.0:
        return ()
    corners = np.array(equivalent.corners(top)).reshape(-1, 2)
    radii, jumps = corners[corners[:, 1] < 0.0].T
    # at the kink itself the slope of g is infinite
    before = radii * (1.0 - 1e-6)
    error = np.maximum(4.0 * equivalent.error(before)[:, 1], _ROUNDING)
    return tuple(radii[-jumps > error * np.abs(equivalent.slope(before))].tolist())


def _decreasing_intervals(
    equivalent: EquivalentProfile, turning: Sequence[float], concave_kinks: Sequence[float], top: float
) -> tuple[DecreasingInterval, ...]:
    marks = [*turning, top] if (len(turning) % 2 == 1) else [*turning]
    ends = [(marks[i], marks[i + 1]) for i in range(0, len(marks), 2)]
    for b in concave_kinks:
        adjacent = [i for i, (start, _) in enumerate(ends) if abs(start - b) <= 1e-9 * b]
        if adjacent:
            ends[adjacent[0]] = (b, max(ends[adjacent[0]][1], b))
        elif not any(start < b < stop for start, stop in ends):
            ends.append((b, b))
    ends.sort()
    g = equivalent.g(np.array(ends).ravel()).reshape(-1, 2)
    return tuple(
        DecreasingInterval(start, stop, max(float(first - last), 0.0))
        for (start, stop), (first, last) in zip(ends, g, strict=True)
    )


def _candidates(
    equivalent: EquivalentProfile, decreasing: Sequence[DecreasingInterval], top: float
) -> FloatArray:
    """Radii at which pressures and gaps are evaluated before their minima are refined."""
    marks = np.array(sorted({0.0, top, *(end for each in decreasing for end in (each.start, each.stop))}))
    first = float(marks[1])
    count = max(3, min(24, 768 // marks.size))
    inner = 0.5 - 0.5 * np.cos(np.pi * (np.arange(count) + 0.5) / count)
    between = (marks[:-1, None] + np.diff(marks)[:, None] * inner).ravel()
    steps = np.array([0.1, 0.3, 0.6, 1.0, 2.0, 4.0])
    around = np.array(
        [(f.start - (f.stop - f.start) * steps, f.stop + (f.stop - f.start) * steps) for f in decreasing]
    ).ravel()
    toward_tip = first * 2.0 ** -np.arange(0.0, -math.log2(_INWARD), 0.25)
    resolving = equivalent.resolving_radii(top)
    radii = np.unique(np.concatenate([between, around, toward_tip, resolving, marks]))
    radii = radii[(radii >= _INWARD * first) & (radii <= top)]
    return np.asarray(radii[np.append(True, np.diff(radii) > 1e-12 * radii[1:])])
