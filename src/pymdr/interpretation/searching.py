"""The largest value of a measure of stress in a half-space, and where it is."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from pymdr.interpretation.tensors import fixed_axes
from pymdr.units import FloatArray

_STEPS = 9
"""Radii that are searched between two marks of the profile."""
DEPTHS = np.append(0.0, np.geomspace(1e-4, 2.0, 25))
"""Depths of the search, over the loaded radius."""
_PLACE = 1e-6
"""Tolerance of the place of a largest value, over the loaded radius."""
_RIVALS = 0.02
"""Fraction below the largest sample within which other samples also start a search."""
_ANGLES = 24
"""Intervals of half a turn in which an angle is searched first."""
_TURNS = 22
"""Number of halvings of the interval around an angle."""

_POLISHING = (2e-2, 2e-3, 2e-4)
"""Widths of the nets around an approximately known peak, over the loaded radius."""

Tensor: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]
"""Components in Pa at radii and depths in m, components first."""


class Largest(NamedTuple):
    """A largest value and where it is."""

    value: float
    r: float
    """In m."""
    z: float
    """In m."""
    angle: float = 0.0
    """From x, in rad."""
    layer: int = 0
    """From 0, of a layered body."""


def largest_on(
    measure: Callable[[FloatArray], FloatArray],
    revolving: Tensor,
    amplitudes: Tensor | None,
    background: Callable[[FloatArray], FloatArray] | None,
    marks: Sequence[float],
    radius: float,
) -> Largest:
    """
    The largest value of a measure of stress.

    Parameters
    ----------
    measure : callable
        From components, shape (4, ...) or (6, ...).
    revolving : callable
        Components rr, tt, zz, rz, and under torsion rt and tz, that do not depend on the angle.
    amplitudes : callable or None
        Of a shear traction: rr, tt, zz, rz times the cosine and rt, tz times the sine.
    background : callable or None
        Components in fixed directions at depths.
    marks : sequence of float
        Radii in m in the loaded disk at which the stress is not smooth at the surface.
    radius : float
        That of the loaded disk in m.
    """
    net = searched_radii(marks, radius), radius * DEPTHS
    return largest_in_span(measure, (revolving, amplitudes, background), net, radius)


def searched_radii(marks: Sequence[float], radius: float) -> FloatArray:
    """Radii in m that are searched, around those at which the stress at the surface is not smooth, up to 1.5 of the loaded radius."""
    inside = (m for m in marks if 0.0 < m < radius)
    bounds = np.unique([0.0, *inside, radius, 1.5 * radius])
    fractions = 0.5 * (1.0 - np.cos(np.linspace(0.0, math.pi, _STEPS)))
    return np.unique(bounds[:-1, None] + np.diff(bounds)[:, None] * fractions)


def largest_in_span(
    measure: Callable[[FloatArray], FloatArray],
    parts: tuple[Tensor, Tensor | None, Callable[[FloatArray], FloatArray] | None],
    net: tuple[FloatArray, FloatArray],
    size: float,
    span: tuple[float, float] = (0.0, math.inf),
) -> Largest:
    """
    The largest value of a measure of stress between two depths.

    Parameters
    ----------
    measure : callable
        From components, shape (4, ...) or (6, ...).
    parts : tuple
        What does not depend on the angle, the amplitudes of a shear traction, and a background, as of :func:`largest_on`.
    net : tuple of ndarray
        Radii and depths in m, rising, from which the search begins.
    size : float
        Length in m relative to which the place is precise.
    span : tuple of float
        Smallest and largest depth in m.
    """
    revolving, amplitudes, background = parts
    if amplitudes is None and background is None:
        return _searched(lambda r, z: measure(revolving(r, z)), *net, _PLACE * size, span)

    def turned(r: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        steady = np.zeros((6, *r.shape))
        known = revolving(r, z)
        steady[: known.shape[0]] = known
        moving = np.zeros(steady.shape) if amplitudes is None else amplitudes(r, z)
        added = None if background is None else background(z)
        return _over_angles(measure, steady, moving, added)

    best = _searched(lambda r, z: turned(r, z)[0], *net, _PLACE * size, span)
    _, angle = turned(np.array([best.r]), np.array([best.z]))
    return best._replace(angle=float(angle[0]))


def _over_angles(
    measure: Callable[[FloatArray], FloatArray],
    steady: FloatArray,
    moving: FloatArray,
    added: FloatArray | None,
) -> tuple[FloatArray, FloatArray]:
    """The largest value over all angles, and its angle in rad."""

    def at(angle: FloatArray) -> FloatArray:
        c, s = np.cos(angle), np.sin(angle)
        tensor = steady + moving * np.array([c] * 4 + [s] * 2)
        if added is None:
            return measure(tensor)
        return measure(fixed_axes(tensor, c, s) + added)

    shape = steady.shape[1:]
    # without a background both halves are alike
    low = 0.0 if added is None else -math.pi
    angles = np.linspace(low, math.pi, _ANGLES * (1 if added is None else 2) + 1)
    best, angle = np.full(shape, -math.inf), np.zeros(shape)
    for one in angles:
        value = at(np.full(shape, one))
        better = value > best
        best, angle = np.where(better, value, best), np.where(better, one, angle)
    half = 0.5 * (angles[1] - angles[0])
    for _ in range(_TURNS):
        for other in (angle - half, angle + half):
            value = at(other)
            better = value > best
            best, angle = np.where(better, value, best), np.where(better, other, angle)
        half *= 0.5
    return best, angle


def _searched(
    value: Tensor, radii: FloatArray, depths: FloatArray, precision: float, span: tuple[float, float]
) -> Largest:
    """The largest value from a net of radii and depths."""
    values = value(*np.meshgrid(radii, depths, indexing="ij"))
    top = values.max()
    rivals = values >= top - _RIVALS * abs(top)
    return max(
        _refined(value, (radii, depths), (int(i), int(k)), precision, span)
        for i, k in np.argwhere(_is_peak(values) & rivals)
    )


def polished(value: Tensor, near: tuple[float, float], radius: float, distance: float) -> Largest | None:
    """
    The largest value close to a place inside the body, by parabolas of two variables on ever smaller nets.

    Parameters
    ----------
    value : callable
        At radii and depths in m, even in the radius.
    near : tuple of float
        Radius and depth in m.
    radius : float
        Typical length in m.
    distance : float
        Of the largest value from that place at most, over that length.

    Returns
    -------
    Largest or None
        None if the values are not those of a peak inside the body.
    """
    best = np.array(near)
    for half in _POLISHING[distance <= _POLISHING[1] :]:
        steps = half * radius * np.array([-1.0, 0.0, 1.0])
        if best[1] <= 2.0 * steps[-1]:
            return None
        r, z = best[0] + steps[:, None] + np.zeros(3), best[1] + np.zeros((3, 1)) + steps
        v = value(np.abs(r), z)
        slope = 0.5 * np.array([v[2, 1] - v[0, 1], v[1, 2] - v[1, 0]])
        cross = 0.25 * (v[2, 2] - v[2, 0] - v[0, 2] + v[0, 0])
        bend = v[2, 1] - 2.0 * v[1, 1] + v[0, 1], v[1, 2] - 2.0 * v[1, 1] + v[1, 0]
        rest = bend[0] * bend[1] - cross * cross
        if not (bend[0] < 0.0 and rest > 0.0):
            return None
        move = np.array([cross * slope[1] - bend[1] * slope[0], cross * slope[0] - bend[0] * slope[1]]) / rest
        if not np.max(np.abs(move)) <= 1.5:
            return None
        best = best + half * radius * move
    place = np.abs(best)
    return Largest(float(value(place[:1], place[1:])[0]), float(place[0]), float(place[1]))


def _is_peak(values: FloatArray) -> np.ndarray:
    """Where a value on a net is at least as large as its neighbours."""
    wide = np.pad(values, 1, constant_values=-math.inf)
    rows, columns = values.shape
    around = [wide[i : i + rows, k : k + columns] for i in range(3) for k in range(3)]
    return np.asarray(values >= np.max(around, axis=0))


def _refined(
    value: Tensor,
    nets: tuple[FloatArray, FloatArray],
    start: tuple[int, int],
    precision: float,
    span: tuple[float, float],
) -> Largest:
    """The largest value near a node of a net, on nets that shrink around it."""
    best = np.array([net[n] for net, n in zip(nets, start, strict=True)])
    half = np.array(
        [
            np.max(np.abs(np.diff(net[max(n - 1, 0) : n + 2])), initial=0.0)
            for net, n in zip(nets, start, strict=True)
        ]
    )
    # a value that rises forever outward has no peak
    top, widest = -math.inf, 2.0 * float(nets[0][-1])
    while half.max() > precision:
        r, z = (
            np.clip(centre + width * np.linspace(-1.0, 1.0, 5), *ends)
            for centre, width, ends in zip(best, half, ((0.0, widest), span), strict=True)
        )
        values = value(*np.meshgrid(r, z, indexing="ij"))
        row, column = np.unravel_index(np.argmax(values), values.shape)
        best, top = np.array([r[row], z[column]]), max(top, float(values[row, column]))
        # a net whose largest value lies at its rim is moved before it shrinks
        moved = row in (0, 4) and 0.0 < r[row] < widest, column in (0, 4) and span[0] < z[column] < span[1]
        half *= np.where(moved, 1.0, 0.5)
    return Largest(top, float(best[0]), float(best[1]))
