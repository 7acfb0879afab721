"""Laws between depth and force of shapes."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from pymdr.mapping.azimuth import ray_slopes
from pymdr.problem.profiles import Shape
from pymdr.units import FloatArray

BELOW = 1e-3
"""Accepted difference of an estimate below the force of a disk, relative to that force."""


@dataclass(frozen=True)
class ShapeStates:
    """States of a shape at some depths, for an effective modulus of 1 Pa; NaN where unknown."""

    force: FloatArray
    """F / E* in m^2."""
    stiffness: FloatArray
    """In m."""
    energy: FloatArray
    """In m^3."""
    estimate: FloatArray
    """Value of the functional of Shield, Barber and Fabrikant, in m^2."""
    error: FloatArray
    """Relative error of the estimate (model and numerics); NaN where unknown."""
    longest: FloatArray
    """Largest distance of the edge from the apex in m, as far as it is known."""
    clipped: FloatArray
    """Fraction of the directions in which the outline of the estimate is cut off."""

    def above(self, bound: FloatArray) -> ShapeStates:
        """States whose force is not below a bound, F / E* in m^2; estimates below it are discarded."""
        wrong = self.force < bound * (1.0 - BELOW)
        force, stiffness, estimate = (
            np.where(wrong, math.nan, one) for one in (self.force, self.stiffness, self.estimate)
        )
        return replace(self, force=force, stiffness=stiffness, estimate=estimate)


class ShapeLaw(ABC):
    """A shape as a law between depth and force."""

    shape: Shape
    known: ClassVar[bool] = True
    """Whether its force is known, and not only bounded and estimated."""

    @property
    def source(self) -> str:
        """Source of a force that is not an estimate; empty for estimates."""
        return ""

    def semi_axes(self, depth: FloatArray) -> tuple[FloatArray, FloatArray] | None:
        """Semi-axes of an elliptic contact in m along x and y at depths in m; None of others."""
        return None

    def slopes(self, depth: FloatArray, size: float) -> tuple[float, float]:
        """The largest slope in contacts up to a size in m, and the largest semi-axis over its radius of curvature, nan of others."""
        return float(
            np.nanmax(ray_slopes(self.shape, min(size, self.shape.max_radius)), initial=0.0)
        ), math.nan

    @abstractmethod
    def at(self, depth: FloatArray, radius: FloatArray) -> ShapeStates:
        """States at depths in m, given the radii in m of the disks of the lower bound."""
