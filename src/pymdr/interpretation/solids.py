"""The half-spaces whose stress is known from the load on the line, each with the same closed forms."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import singledispatch
from typing import Protocol

import numpy as np

from pymdr.interpretation.shear_stress import (
    shear_displacement,
    shear_stress,
    shear_sums,
    twist_displacement,
    twist_stress,
)
from pymdr.interpretation.stress import LineLoad, displacement, stress, sums
from pymdr.interpretation.transverse import TransverseSolid
from pymdr.problem.layers import Layered
from pymdr.problem.materials import Elastic, Material, TransverselyIsotropic, Viscoelastic
from pymdr.units import FloatArray


class Solid(Protocol):
    """Stress and displacement under loads on the line, at radii and depths in m."""

    def normal_stress(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """Components rr, tt, zz and rz in Pa under a pressure, tension positive, shape (4, ...)."""

    def shear_stress(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """Amplitudes of rr, tt, zz, rz (cosine) and rt, tz (sine) in Pa under a traction in +x, shape (6, ...)."""

    def normal_displacement(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """u_r and u_z in m under a pressure, shape (2, ...)."""

    def shear_displacement(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """Amplitudes of u_r (cosine), u_t (sine) and u_z (cosine) in m under a traction in +x, shape (3, ...)."""

    def twist_stress(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """Components rt and tz in Pa under a traction around the axis, shape (2, ...)."""

    def twist_displacement(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """u_t in m under a traction around the axis."""


@dataclass(frozen=True)
class IsotropicSolid:
    """An isotropic half-space."""

    poisson: float
    shear: float
    """G in Pa; nan where it depends on time."""

    def normal_stress(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """As of every solid."""
        return stress(sums(load, r, z, logarithm=False), self.poisson)

    def shear_stress(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """As of every solid."""
        return shear_stress(shear_sums(load, r, z, logarithm=False), self.poisson)

    def normal_displacement(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """As of every solid."""
        return displacement(sums(load, r, z), r, z, self.poisson, self.shear)

    def shear_displacement(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """As of every solid."""
        return shear_displacement(shear_sums(load, r, z), r, z, self.poisson, self.shear)

    def twist_stress(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """As of every solid."""
        return twist_stress(shear_sums(load, r, z, logarithm=False), r)

    def twist_displacement(self, load: LineLoad, r: FloatArray, z: FloatArray) -> FloatArray:
        """As of every solid."""
        return twist_displacement(shear_sums(load, r, z), r, z, self.shear)


@singledispatch
def solid_of(body: Material) -> Solid | None:
    """The solid of a body, or None if its stress does not follow from the load on the line."""
    return None


@solid_of.register
def _(body: Layered) -> Solid:
    # under its surface it differs from its top layer by what the interfaces reflect
    return IsotropicSolid(body.top.poisson, math.nan if body.is_viscoelastic else body.top.shear)


@solid_of.register
def _(body: Elastic) -> Solid:
    return IsotropicSolid(body.poisson, body.shear)


@solid_of.register
def _(body: Viscoelastic) -> Solid | None:
    # under one load the stress depends on nu alone, so that it is known where nu is constant in time
    return None if body.poisson is None else IsotropicSolid(body.poisson, math.nan)


@solid_of.register
def _(body: TransverselyIsotropic) -> Solid:
    return TransverseSolid(body.stiffnesses)


def traction_at(amplitudes: FloatArray, cosine: FloatArray, sine: FloatArray) -> FloatArray:
    """Components rr, tt, zz, rz, rt, tz at an angle from x, from amplitudes of a shear traction."""
    return np.asarray(amplitudes * np.array([cosine] * 4 + [sine] * 2))
