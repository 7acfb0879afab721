"""Criteria of fatigue as functions of a cycle of stress, and the planes on which they are largest."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Protocol

import numpy as np

from pymdr.interpretation.cycles import (
    dang_van,
    in_plane,
    normal_stress,
    shear_amplitude,
    stress_factors,
    upward,
)
from pymdr.units import FloatArray

_NORMALS = 96
"""Planes that are searched first, over half of the sphere."""
_DIRECTIONS = 6
"""Directions in each of them in which the range of the shear stress is measured first."""
_RIVALS, _DISTINCT = 6, math.cos(math.radians(20.0))
"""Planes from which a search begins, and the cosine of the least angle between them."""
_FINEST = 1e-4
"""Last distance of neighbouring planes in rad; the vertex of a parabola through them is far more precise."""
_WIDE = 0.15
"""First distance of neighbouring planes in rad."""
_MOVES = 60
_CHUNK = 256
"""Points that are searched at once."""


class Measure(Protocol):
    """A criterion of fatigue as a function of the cycle of stress at points."""

    def rough(self, cycle: FloatArray) -> FloatArray:
        """Values at points from few planes, not above the true ones, shape (m,)."""

    def starts(self, cycle: FloatArray) -> FloatArray:
        """Planes from which the search for the largest begins, shape (k, 3, m)."""

    def best(
        self, cycle: FloatArray, planes: FloatArray, width: float = _WIDE
    ) -> tuple[FloatArray, FloatArray]:
        """Values at points, and their planes, searched from given ones."""


@dataclass(frozen=True)
class InstantMeasure:
    """Dang Van's criterion, which searches instants instead of planes."""

    slope: float

    def rough(self, cycle: FloatArray) -> FloatArray:
        """As of every measure."""
        return self.best(cycle, np.zeros((3, cycle.shape[2])))[0]

    def starts(self, cycle: FloatArray) -> FloatArray:
        """One, which is not used."""
        return np.zeros((1, 3, cycle.shape[2]))

    def best(
        self, cycle: FloatArray, planes: FloatArray, width: float = _WIDE
    ) -> tuple[FloatArray, FloatArray]:
        """As of every measure."""
        return dang_van(cycle, self.slope)


Combination = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""A measure from the shear amplitude and the largest normal stress of a plane in Pa, and the amplitude of its normal strain."""


@dataclass(frozen=True)
class PlaneMeasure:
    """A criterion that is largest on one plane."""

    combination: Combination
    sheared: bool
    """Whether it needs the shear amplitude; otherwise the normal strain."""
    poisson: float = 0.0
    young: float = math.nan

    def on(self, cycle: FloatArray, plane: FloatArray) -> FloatArray:
        """The measure on planes, shape (3, m), of the cycles at m points."""
        normal = normal_stress(cycle, plane)
        shear = shear_amplitude(cycle, plane) if self.sheared else np.zeros(normal.shape[1])
        return self._combined(cycle, normal, shear)

    def _combined(self, cycle: FloatArray, normal: FloatArray, shear: FloatArray) -> FloatArray:
        strain = np.zeros(normal.shape[-1])
        if not self.sheared:
            trace = cycle[:, :3].sum(axis=1)
            strains = ((1.0 + self.poisson) * normal - self.poisson * trace) / self.young
            strain = 0.5 * np.ptp(strains, axis=0)
        return self.combination(shear, normal.max(axis=0), strain)

    def _on_normals(self, cycle: FloatArray) -> FloatArray:
        """The measure on all first planes, its shear amplitude from a few directions, shape (k, m)."""
        values = []
        for normal, one, two in zip(*_frames(), strict=True):
            stress = np.einsum("c,ncm->nm", stress_factors(normal, normal), cycle)
            shear = np.zeros(cycle.shape[2])
            if self.sheared:
                first = np.einsum("c,ncm->nm", stress_factors(normal, one), cycle)
                second = np.einsum("c,ncm->nm", stress_factors(normal, two), cycle)
                for angle in np.arange(_DIRECTIONS) * math.pi / _DIRECTIONS:
                    along = math.cos(angle) * first + math.sin(angle) * second
                    shear = np.maximum(shear, 0.5 * np.ptp(along, axis=0))
            values.append(self._combined(cycle, stress, shear))
        return np.array(values)

    def rough(self, cycle: FloatArray) -> FloatArray:
        """As of every measure."""
        return np.asarray(self._on_normals(cycle).max(axis=0))

    def starts(self, cycle: FloatArray) -> FloatArray:
        """As of every measure."""
        values, normals = self._on_normals(cycle), _frames()[0]
        near = np.abs(normals @ normals.T) > _DISTINCT
        chosen = []
        for _ in range(_RIVALS):
            best = np.argmax(values, axis=0)
            chosen.append(normals[best].T)
            values = np.where(near[:, best], -math.inf, values)
        return np.array(chosen)

    def best(
        self, cycle: FloatArray, planes: FloatArray, width: float = _WIDE
    ) -> tuple[FloatArray, FloatArray]:
        """
        The largest value of each point near a plane, by parabolas of two variables on ever smaller nets.

        The measure of a plane is the largest of many smooth functions, one for each choice of rows, so that it is smooth where it is
        largest.
        """
        plane, points = planes.copy(), cycle.shape[2]
        step = np.full(points, width)
        value = self.on(cycle, plane)
        left = np.arange(points)
        for _ in range(_MOVES):
            some, h = plane[:, left], step[left]
            one, two = in_plane(some)
            around = [_turned(some, one, two, i * h, k * h) for i in (-1, 0, 1) for k in (-1, 0, 1)]
            part = cycle[:, :, left]
            neighbours = np.concatenate([p for n, p in enumerate(around) if n != 4], axis=1)
            v = self.on(np.tile(part, (1, 1, 8)), neighbours).reshape(8, -1)
            v = np.concatenate([v[:4], value[None, left], v[4:]])
            move, peaked = _vertex(v.reshape(3, 3, -1))
            vertex = _turned(some, one, two, move[0] * h, move[1] * h)
            tried = np.concatenate([v, self.on(part, vertex)[None]])
            best = np.where(peaked & (tried[9] >= tried[:9].max(axis=0)), 9, np.argmax(tried, axis=0))
            candidates = np.array([*around, vertex])
            plane[:, left] = candidates[best, :, np.arange(left.size)].T
            value[left] = tried[best, np.arange(left.size)]
            near = (best == 4) | ((best == 9) & (np.abs(move) <= 1.0).all(axis=0))
            step[left] = np.where(near, 0.2 * h, h)
            left = left[step[left] >= _FINEST]
            if left.size == 0:
                break
        return value, upward(plane)


def _turned(plane: FloatArray, one: FloatArray, two: FloatArray, i: FloatArray, k: FloatArray) -> FloatArray:
    """Planes turned by small angles toward two directions."""
    turned = plane + i * one + k * two
    return np.asarray(turned / np.linalg.norm(turned, axis=0))


def _vertex(v: FloatArray) -> tuple[FloatArray, np.ndarray]:
    """The vertex of parabolas of two variables through nets of 3 x 3 values, in steps, and whether it is a nearby peak."""
    slope = 0.5 * np.array([v[2, 1] - v[0, 1], v[1, 2] - v[1, 0]])
    cross = 0.25 * (v[2, 2] - v[2, 0] - v[0, 2] + v[0, 0])
    bend = v[2, 1] - 2.0 * v[1, 1] + v[0, 1], v[1, 2] - 2.0 * v[1, 1] + v[1, 0]
    rest = bend[0] * bend[1] - cross * cross
    peaked = (bend[0] < 0.0) & (rest > 0.0)
    move = np.array([cross * slope[1] - bend[1] * slope[0], cross * slope[0] - bend[0] * slope[1]])
    move = np.where(peaked, move / np.where(peaked, rest, 1.0), 0.0)
    peaked = peaked & (np.abs(move) <= 2.0).all(axis=0)
    return np.where(peaked, move, 0.0), peaked


@cache
def _frames() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Evenly spread normals over half of the sphere (a spiral), and two directions in each plane, of shape (k, 3)."""
    n = np.arange(_NORMALS)
    z = (n + 0.5) / _NORMALS
    turn = n * math.pi * (3.0 - math.sqrt(5.0))
    flat = np.sqrt(1.0 - z * z)
    # the planes in which a body is cut first
    named = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    normals = np.concatenate([named, np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)])
    one, two = in_plane(normals.T)
    return normals, one.T, two.T


def largest_on_planes(measure: Measure, cycle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """
    A criterion at points, on the worst plane of each.

    Parameters
    ----------
    cycle : ndarray, shape (n, 6, m)
        Stress in Pa over the rows of a cycle.

    Returns
    -------
    value, plane : ndarray, shapes (m,) and (3, m)
    """
    value, plane = np.empty(cycle.shape[2]), np.empty((3, cycle.shape[2]))
    for some in np.array_split(np.arange(cycle.shape[2]), max(1, -(-cycle.shape[2] // _CHUNK))):
        part = cycle[:, :, some]
        peaks = [measure.best(part, start) for start in measure.starts(part)]
        values = np.array([one for one, _ in peaks])
        best = np.argmax(values, axis=0)
        value[some] = values[best, np.arange(some.size)]
        plane[:, some] = np.array([one for _, one in peaks])[best, :, np.arange(some.size)].T
    return value, plane
