"""The largest value of a criterion of fatigue in a body, with its place and plane."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pymdr.interpretation.fatigue import Rating, StressCycle, first_radii, searched_angles
from pymdr.units import FloatArray

_RIVALS = 0.15
"""Of the largest value of the first search: how far others may be below it from which the second begins."""
_STARTS = 6
"""Places and planes from which it begins."""
_TURN, _ALIKE = 0.15, 1e-4
"""Distance of planes in rad that are compared first, and 1 less the cosine of the angle of planes that are one."""
_CLOSE, _CLOSER = 1e-2, 1e-3
"""Of the loaded radius: the width of nets at which starts are compared, and how far, of the largest value, others are searched on."""
_PLACE = 1e-6
"""Of the loaded radius: how closely a largest value is located."""


class Site(NamedTuple):
    """The largest value of a criterion, and where it is."""

    value: float
    r: float
    """In m."""
    angle: float
    """From x, in rad."""
    z: float
    """In m."""
    plane: FloatArray
    """Unit normal, nan if the criterion knows no plane."""


def most_endangered(rating: Rating, cycle: StressCycle) -> Site:
    """
    The largest value of a criterion in a body.

    Returns
    -------
    Site
        With nan for the place if the criterion is nowhere above 0.

    Notes
    -----
    A net of radii, angles and depths is searched with few planes, and around its largest values ever smaller nets with all planes.
    """
    radius = cycle.radius
    angles = np.zeros(1) if rating.revolves else searched_angles(cycle)
    net = first_radii(cycle), angles, radius * rating.depths
    grid = np.meshgrid(*net, indexing="ij")
    values = rating.rough(*(axis.ravel() for axis in grid)).reshape(grid[0].shape)
    top = float(values.max())
    if not top > 0.0:
        return Site(0.0, math.nan, math.nan, math.nan, np.full(3, math.nan))
    peaks = np.argwhere(_is_peak(values) & (values >= top * (1.0 - _RIVALS)))
    order = np.argsort([-values[tuple(peak)] for peak in peaks])[:_STARTS]
    candidates = [
        _nearer(rating, cycle, start, _CLOSE)
        for start in _starts(rating, net, [tuple(p) for p in peaks[order]])
    ]
    candidates.sort(key=lambda one: -one[0].value)
    best_site = candidates[0][0]
    last: list[Site] = []
    for site, half in candidates:
        known = any(_same(site, other, radius) for other in last)
        if site.value >= best_site.value * (1.0 - _CLOSER) and not known:
            last.append(_nearer(rating, cycle, (site, half), _PLACE)[0])
    return max(last, key=lambda one: one.value)


def _starts(
    rating: Rating, net: tuple[FloatArray, ...], peaks: Sequence[tuple[int, ...]]
) -> list[tuple[Site, FloatArray]]:
    """The best planes at some nodes of a net, with the distances of the neighbours of the nodes."""
    place = np.array(
        [[axis[i] for i in nodes] for axis, nodes in zip(net, zip(*peaks, strict=True), strict=True)]
    )
    points = place[0], place[1], place[2]
    starts: list[tuple[Site, FloatArray]] = []
    for planes in rating.starts(*points):
        value, best = rating.best(points, planes, _TURN)
        for n, nodes in enumerate(peaks):
            half = np.array(
                [
                    np.max(np.abs(np.diff(axis[max(i - 1, 0) : i + 2])), initial=0.0)
                    for axis, i in zip(net, nodes, strict=True)
                ]
            )
            r, angle, z = place[:, n].tolist()
            starts.append((Site(float(value[n]), r, angle, z, best[:, n]), half))
    starts.sort(key=lambda one: -one[0].value)
    distinct: list[tuple[Site, FloatArray]] = []
    for site, half in starts:
        near = any(
            site[1:4] == other[1:4] and not abs(float(site.plane @ other.plane)) < 1.0 - _ALIKE
            for other, _ in distinct
        )
        if site.value >= starts[0][0].value * (1.0 - _RIVALS) and not near:
            distinct.append((site, half))
    return distinct[:_STARTS]


def _same(one: Site, other: Site, radius: float) -> bool:
    """Whether two searches lead to one place and plane."""
    places = [
        np.array([site.r * math.cos(site.angle), site.r * math.sin(site.angle), site.z])
        for site in (one, other)
    ]
    near = float(np.max(np.abs(places[0] - places[1]))) < 3.0 * _CLOSE * radius
    alike = abs(float(one.plane @ other.plane))
    return near and not alike < 1.0 - _CLOSE


def _is_peak(values: FloatArray) -> np.ndarray:
    """Where a value on a net of three dimensions is at least as large as its neighbours."""
    wide = np.pad(values, 1, constant_values=-math.inf)
    n, m, k = values.shape
    around = [
        wide[i : i + n, j : j + m, l : l + k]
        for i in range(3)
        for j in range(3)
        for l in range(3)  # noqa: E741
    ]
    return np.asarray(values >= np.max(around, axis=0))


def _nearer(
    rating: Rating, cycle: StressCycle, start: tuple[Site, FloatArray], precision: float
) -> tuple[Site, FloatArray]:
    """The largest value around a place on nets that shrink around it, until they are as small as the precision."""
    (value, *place, plane), half = start
    best, half = np.array(place), half.copy()
    radius, turning = cycle.radius, not rating.revolves
    steps = np.array([-1.0, 0.0, 1.0])
    while max(half[0] / radius, half[2] / radius, half[1] if turning else 0.0) > precision:
        axes = [
            centre + width * steps if width > 0.0 else np.array([centre])
            for centre, width in zip(best, half, strict=True)
        ]
        axes[0], axes[2] = np.unique(np.clip(axes[0], 0.0, 2.0 * radius)), np.unique(np.maximum(axes[2], 0.0))
        grid = [axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")]
        planes = np.repeat(plane[:, None], grid[0].size, axis=1)
        width = min(0.1, max(2.0 * float(half.max() / radius), 2e-3))
        values, best_planes = rating.best((grid[0], grid[1], grid[2]), planes, width)
        top = int(np.argmax(values))
        moved = np.zeros(3, dtype=bool)
        if values[top] > value:
            new = np.array([axis[top] for axis in grid])
            moved = new != best
            best, value, plane = new, float(values[top]), best_planes[:, top]
        # a net whose largest value lies at its rim is moved before it shrinks
        half *= np.where(moved, 1.0, 0.5)
        if best[0] >= 2.0 * radius:
            half[0] *= 0.5
    return Site(value, float(best[0]), float(best[1]), float(best[2]), plane), half
