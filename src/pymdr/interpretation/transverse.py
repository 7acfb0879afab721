"""Stress and displacement inside transversely isotropic half-spaces: the closed forms of punches at stretched depths.

Displacements are gradients of potentials at the depths lambda z, where lambda^2 are the roots of a quadratic equation. The roots may be
complex; then the punches of -s are no longer conjugate to those of s, and both are summed.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pymdr.interpretation.shear_stress import shear_sums, twist_displacement, twist_stress
from pymdr.interpretation.stress import LineLoad, integrated
from pymdr.problem.materials import Stiffnesses
from pymdr.units import FloatArray

ComplexArray: TypeAlias = NDArray[np.complex128]

_EQUAL = 1e-3
"""Relative difference of the roots below which the sums of both lose digits by cancellation."""
_CHANGE_OF_C44 = 1e-4
"""Relative change of c44 (to the fourth power) to the neighbours of a body with equal roots, from which its stress is
extrapolated."""
_EXTRAPOLATED = ((1.0, 2.0 / 3.0), (-1.0, 2.0 / 3.0), (2.0, -1.0 / 6.0), (-2.0, -1.0 / 6.0))
"""Changes in that unit, and weights."""


class _Sums(NamedTuple):
    """Sums over punches at a stretched depth, in Pa (`log` in N/m); real for real roots."""

    inverse: ComplexArray
    mean: ComplexArray
    across: ComplexArray
    squared: ComplexArray
    log: ComplexArray


def _at(load: LineLoad, r: FloatArray, z: FloatArray, root: complex) -> _Sums:
    """The sums at the depth root * z."""
    sizes = np.append(np.ones(2 * len(_Sums._fields) - 2), [load.radius, load.radius])
    halves = []
    for each in (root, root.conjugate()):

        def punch(
            centre: FloatArray, depth: FloatArray, s: FloatArray, above: FloatArray, each: complex = each
        ) -> FloatArray:
            radius = centre + each.imag / each.real * depth
            near, far = depth + 1j * above, depth + 1j * (above + 2.0 * radius)
            distance = np.sqrt(near) * np.sqrt(far)
            total = distance + 0.5 * (near + far)
            inverse, mean = 1.0 / distance, 1.0 / total
            forms = inverse, mean, radius * inverse * mean, radius * mean * mean, np.log(total)
            return np.array([part for form in forms for part in (form.real, form.imag)])

        integrals = integrated(load, r - each.imag * z, each.real * z, punch, sizes)
        halves.append(integrals[::2] + 1j * integrals[1::2])
    return _Sums(*((halves[0] - halves[1].conj()) / 2j))


@dataclass(frozen=True)
class TransverseSolid:
    """A transversely isotropic half-space whose axis is the normal."""

    stiffnesses: Stiffnesses

    @cached_property
    def _bodies(self) -> tuple[tuple[TransverseSolid, float], ...]:
        """The body itself, or the neighbours of one with nearly equal roots, with their weights."""
        first, second = self._roots
        if abs(first - second) >= _EQUAL * abs(first):
            return ((self, 1.0),)
        c44 = self.stiffnesses.c44
        return tuple(
            (
                replace(
                    self, stiffnesses=self.stiffnesses._replace(c44=c44 * (1.0 + change * _CHANGE_OF_C44))
                ),
                weight,
            )
            for change, weight in _EXTRAPOLATED
        )

    @cached_property
    def _roots(self) -> tuple[complex, complex]:
        """The roots lambda of positive real part."""
        c11, c33, c13, c44, _ = self.stiffnesses
        # c33 c44 L^2 - 2 b L + c11 c44 = 0; their product is c11 / c33
        half = 0.5 * (c11 * c33 - c13 * (c13 + 2.0 * c44))
        mean = math.sqrt(c11) * math.sqrt(c33)
        below, above = half - mean * c44, half + mean * c44
        # (lambda1 +- lambda2)^2 = 2 (b +- c44 sqrt(c11 c33)) / (c33 c44)
        total = math.sqrt(2.0 * above / (c33 * c44))
        difference = cmath.sqrt(2.0 * below / (c33 * c44))
        return 0.5 * (total + difference), 0.5 * (total - difference)

    def _terms(self) -> list[tuple[complex, complex, complex]]:
        """Root lambda, m and k of each potential."""
        _, c33, c13, c44, _ = self.stiffnesses
        ratios = [(c13 + c44) / (c33 * root * root - c44) for root in self._roots]
        return [(root, m, c44 * (1.0 + m)) for root, m in zip(self._roots, ratios, strict=True)]

    def normal_stress(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """Components rr, tt, zz and rz in Pa under a pressure, tension positive, shape (4, ...)."""
        return np.asarray(sum(weight * body._normal_stress(load, r, z) for body, weight in self._bodies))

    def _normal_stress(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        c11, _, c13, _, c66 = self.stiffnesses
        total: ComplexArray = np.zeros((4, *np.shape(r)), dtype=complex)
        for (root, m, k), weight in zip(self._terms(), self._normal_weights(), strict=True):
            integrals, factor = _at(load, r, z, root), weight / k
            squeezed = c13 * m * root * root
            total += [
                factor * ((squeezed - c11) * integrals.inverse + 2.0 * c66 * integrals.mean),
                factor * ((squeezed - c11 + 2.0 * c66) * integrals.inverse - 2.0 * c66 * integrals.mean),
                weight * integrals.inverse,
                weight * root * integrals.across,
            ]
        return np.asarray(2.0 * total.real)

    def _normal_weights(self) -> tuple[complex, complex]:
        first, second = self._roots
        scale = 1.0 / (2.0 * math.pi * (first - second))
        return -second * scale, first * scale

    def shear_stress(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """Amplitudes of rr, tt, zz, rz (cosine) and rt, tz (sine) in Pa under a traction in +x, shape (6, ...)."""
        return np.asarray(sum(weight * body._shear_stress(load, r, z) for body, weight in self._bodies))

    def _shear_stress(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        c11, _, c13, _, c66 = self.stiffnesses
        total: ComplexArray = np.zeros((6, *np.shape(r)), dtype=complex)
        for (root, m, k), weight in zip(self._terms(), self._shear_weights(), strict=True):
            integrals, factor = _at(load, r, z, root), weight / k
            squeezed = c13 * m * root * root
            total += [
                factor * (c66 * integrals.squared + (squeezed - c11) * integrals.across),
                factor * ((squeezed - c11 + 2.0 * c66) * integrals.across - c66 * integrals.squared),
                weight * integrals.across,
                weight * root * (integrals.mean - integrals.inverse),
                factor * c66 * integrals.squared,
                weight * root * integrals.mean,
            ]
        root, factor = self._twist()
        integrals, along = _at(load, r, z, root), factor * self.stiffnesses.c44 * root
        total += [
            -c66 * factor * integrals.squared,
            c66 * factor * integrals.squared,
            np.zeros(np.shape(r)),
            -along * integrals.mean,
            c66 * factor * (integrals.across - integrals.squared),
            along * (integrals.inverse - integrals.mean),
        ]
        return np.asarray(2.0 * total.real)

    def _shear_weights(self) -> tuple[complex, complex]:
        first, second = self._roots
        scale = 1.0 / (2.0 * math.pi * (first - second))
        return -scale, scale

    def _twist(self) -> tuple[complex, float]:
        """The third root, and the weight of its potential."""
        *_, c44, c66 = self.stiffnesses
        root = math.sqrt(c66) / math.sqrt(c44)
        return complex(root), -1.0 / (2.0 * math.pi * c44 * root)

    def normal_displacement(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """u_r and u_z in m under a pressure, shape (2, ...)."""
        return np.asarray(
            sum(weight * body._normal_displacement(load, r, z) for body, weight in self._bodies)
        )

    def _normal_displacement(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        total: ComplexArray = np.zeros((2, *np.shape(r)), dtype=complex)
        for (root, m, k), weight in zip(self._terms(), self._normal_weights(), strict=True):
            integrals, factor = _at(load, r, z, root), weight / k
            total += [-factor * r * integrals.mean, factor * m * root * integrals.log]
        return np.asarray(2.0 * total.real)

    def shear_displacement(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """Amplitudes of u_r (cosine), u_t (sine) and u_z (cosine) in m under a traction in +x, shape (3, ...)."""
        return np.asarray(sum(weight * body._shear_displacement(load, r, z) for body, weight in self._bodies))

    def _shear_displacement(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        total: ComplexArray = np.zeros((3, *np.shape(r)), dtype=complex)
        for (root, m, k), weight in zip(self._terms(), self._shear_weights(), strict=True):
            integrals, factor = _at(load, r, z, root), weight / k
            first = 0.5 * r * integrals.squared - integrals.log
            total += [
                factor * (first - r * integrals.squared),
                -factor * first,
                -2.0 * factor * m * root * r * integrals.mean,
            ]
        root, factor = self._twist()
        integrals = _at(load, r, z, root)
        first = 0.5 * r * integrals.squared - integrals.log
        total += [factor * first, factor * (r * integrals.squared - first), np.zeros(np.shape(r))]
        return np.asarray(total.real)

    def twist_stress(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """Components rt and tz in Pa under a traction around the axis, shape (2, ...)."""
        root = self._twist()[0].real
        rt, tz = twist_stress(shear_sums(load, r, root * z, logarithm=False), r)
        return np.array([root * rt, tz])

    def twist_displacement(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """u_t in m under a traction around the axis."""
        root = self._twist()[0].real
        return twist_displacement(shear_sums(load, r, root * z), r, root * z, self.stiffnesses.c44 * root)
