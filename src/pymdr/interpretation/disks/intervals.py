"""The depths at which contacts are disks, as intervals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from pymdr.interpretation.disks.ends import disks_on
from pymdr.interpretation.disks.extremes import least_of, segments, without_windows
from pymdr.interpretation.disks.features import TOLERANCE, ProfileFeatures, profile_features, touching_range
from pymdr.interpretation.disks.stretches import stretches_of
from pymdr.interpretation.punch import punch_pressure
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.units import FloatArray


@dataclass(frozen=True)
class DiskDepths:
    """Intervals of depth in which contacts are disks."""

    strict: tuple[tuple[float, float], ...]
    """Lowest and highest depth in m of every interval, rising."""
    nearly: tuple[tuple[float, float], ...]
    """The same if rings next to concave kinks are neglected that are narrower than 1e-3 of the contact radius."""
    features: ProfileFeatures | None
    """None where every contact is a disk."""


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
        Depths without contact are included.

    Notes
    -----
    Conditions of Signorini (1959); the disk that satisfies them carries the largest force (Barber 1974).

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> disk_depths(equivalent_profile(Paraboloid(1.0)), 1.0).strict
    ((-inf, inf),)
    """
    whole = ((-math.inf, math.inf),)
    top = 0.0 if equivalent.rises else touching_range(equivalent, deepest)
    if top == 0.0:
        return DiskDepths(whole, whole, None)
    features = profile_features(equivalent, top)
    if features is None:
        return DiskDepths(whole, whole, None)
    stretches = stretches_of(features, deepest)
    by_strictness = []
    for loose in (False, True) if features.concave_kinks else (False,):
        intervals = [(-math.inf, _first_touch(features))]
        for each in stretches:
            radii = disks_on(features, each, loose)
            if radii is not None:
                ends = equivalent.g(np.array(radii))
                last = math.inf if each.high == top < equivalent.edge else float(ends[1])
                intervals.append((float(ends[0]) if radii[0] > 0.0 else 0.0, last))
        if top >= equivalent.edge and (loose or not any(b < top for b in features.concave_kinks)):
            intervals.append((_least_depth_at_edge(features, loose), math.inf))
        by_strictness.append(_joined(intervals))
    return DiskDepths(by_strictness[0], by_strictness[-1], features)


def _first_touch(features: ProfileFeatures) -> float:
    """The depth at which the first point touches, min f, at most 0."""
    g = features.equivalent.g(features.radii)
    if g.min() >= 0.0:
        return 0.0
    least = least_of(
        features.radii,
        lambda r: 2.0 / math.pi * features.equivalent.gap_integral(r, 0.0),
        np.zeros(features.radii.size, dtype=int),
    )
    size = float(np.max(np.abs(g)))
    return least.value * (1.0 - TOLERANCE) if least.value < -TOLERANCE * 1e-3 * size else 0.0


def _least_depth_at_edge(features: ProfileFeatures, loose: bool) -> float:
    """The least depth at which a contact up to a sharp edge has no tension, g(b) + max (-int g' ...) over the punch."""
    equivalent, b = features.equivalent, features.equivalent.edge
    r = without_windows(features, features.radii[features.radii < b], b, loose)

    def scaled(at: FloatArray) -> FloatArray:
        return equivalent.pressure_integral(at, b) / punch_pressure(equivalent.exponent, b, at)

    needed = max(0.0, -least_of(r, scaled, segments(features, r)).value)
    g = float(equivalent.g(np.array([b]))[0])
    size = float(np.max(np.abs(equivalent.g(features.radii)), initial=0.0))
    return g + needed - 4.0 * TOLERANCE * size * (needed > 0.0)


def _joined(intervals: list[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Intervals with those merged that overlap or whose ends differ by rounding."""
    joined: list[tuple[float, float]] = []
    for low, high in sorted(intervals):
        if high < low:
            continue
        if joined and low <= joined[-1][1] + TOLERANCE * abs(low):
            joined[-1] = (joined[-1][0], max(joined[-1][1], high))
        else:
            joined.append((low, high))
    return tuple(joined)


def holes(intervals: Sequence[tuple[float, float]], deepest: float) -> list[tuple[float, float]]:
    """
    The intervals up to a depth that are not covered by rising intervals from -inf on.

    Examples
    --------
    >>> holes(((-math.inf, 1.0), (2.0, 3.0)), 5.0)
    [(1.0, 2.0), (3.0, 5.0)]
    """
    between = [(first[1], second[0]) for first, second in pairwise(intervals) if first[1] < deepest]
    if intervals[-1][1] < deepest - TOLERANCE * abs(deepest):
        between.append((intervals[-1][1], deepest))
    return [(low, min(high, deepest)) for low, high in between]
