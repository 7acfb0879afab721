"""Shapes whose force is known: Hertz's ellipses, and pyramids."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.line.shapes.base import ShapeLaw, ShapeStates
from pymdr.mapping.ellipse import HertzEllipse
from pymdr.problem.profiles import EllipticParaboloid, Pyramid
from pymdr.units import FloatArray

PYRAMID_FORCES = {3: 0.882409, 4: 0.737678, 5: 0.69334, 6: 0.6733, 7: 0.66239, 8: 0.655767}
"""C of F = C E* d^2 / slope by boundary elements on 256 x 256 points."""
PYRAMID_ERROR = 3e-4
"""Relative error of these forces."""
MANY_SIDES_ERROR = 0.0025
"""Relative error of the estimate of a pyramid of 8 sides, which falls with their number."""
LONGEST_RATIO = 10.0
"""Ratio of the radii of curvature up to which the estimate was compared with Hertz."""


@dataclass(frozen=True)
class EllipseLaw(ShapeLaw):
    """Hertz."""

    shape: EllipticParaboloid

    @property
    def source(self) -> str:
        """Hertz."""
        return "exact"

    def semi_axes(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Semi-axes in m along x and y at depths in m."""
        return HertzEllipse(self.shape.radius_x, self.shape.radius_y).semi_axes(depth)

    def slopes(self, depth: FloatArray, size: float) -> tuple[float, float]:
        """The largest slope of the ellipses, which is also their largest semi-axis over its radius of curvature."""
        a_x, a_y = (float(np.max(a)) for a in self.semi_axes(depth))
        steepest = max(a_x / self.shape.radius_x, a_y / self.shape.radius_y)
        return steepest, steepest

    def at(self, depth: FloatArray, radius: FloatArray) -> ShapeStates:
        """States at depths in m."""
        rx, ry = self.shape.radius_x, self.shape.radius_y
        d = np.maximum(depth, 0.0)
        force = HertzEllipse(rx, ry).force(d)
        ratio = max(rx, ry) / min(rx, ry)
        none = np.full(d.shape, math.nan)
        estimate, clipped = none, np.zeros(d.shape)
        if ratio <= LONGEST_RATIO:
            factor, cut_off = ellipse_factor(ratio)
            estimate, clipped = factor * math.sqrt(min(rx, ry)) * d * np.sqrt(d), clipped + cut_off
        with np.errstate(divide="ignore", invalid="ignore"):
            stiffness = np.where(d > 0.0, 1.5 * force / d, 0.0)
            error = np.where(d > 0.0, np.abs(estimate / force - 1.0), 0.0)
        return ShapeStates(
            force, stiffness, 0.4 * force * d, estimate, error, np.maximum(*self.semi_axes(d)), clipped
        )


@dataclass(frozen=True)
class PyramidLaw(ShapeLaw):
    """The law F = C E* d^2 / slope of pyramids, exact by self-similarity up to the constant C."""

    shape: Pyramid

    @property
    def source(self) -> str:
        """Boundary elements, for the numbers of sides that were computed."""
        return "boundary elements" if self.shape.sides in PYRAMID_FORCES else ""

    def slopes(self, depth: FloatArray, size: float) -> tuple[float, float]:
        """The slope of the faces, and nan."""
        return self.shape.gradient, math.nan

    def at(self, depth: FloatArray, radius: FloatArray) -> ShapeStates:
        """States at depths in m."""
        slope, d = self.shape.gradient, np.maximum(depth, 0.0)
        estimated, longest = pyramid_factor(self.shape.sides)
        known = PYRAMID_FORCES.get(self.shape.sides)
        error = MANY_SIDES_ERROR if known is None else abs(estimated / known - 1.0) + PYRAMID_ERROR
        known = estimated if known is None else known
        square = d * (d / slope)
        force = known * square
        return ShapeStates(
            force,
            2.0 * known * (d / slope),
            force * d / 3.0,
            estimated * square,
            0.0 * d + error,
            longest * (d / slope),
            0.0 * d,
        )


@lru_cache(maxsize=64)
def ellipse_factor(ratio: float) -> tuple[float, float]:
    """
    The estimate F / (E* sqrt(R) d^(3/2)) of an elliptic paraboloid, R being its smaller radius.

    Parameters
    ----------
    ratio : float
        Of the radii of curvature, at least 1.

    Returns
    -------
    tuple of float
        The factor, and the fraction of directions without an outline of their own.

    Examples
    --------
    >>> round(ellipse_factor(2.0)[0], 8), round(ellipse_factor(1.0)[0], 8)
    (1.60168035, 1.33333333)
    """
    phi = 2.0 * math.pi * (np.arange(4096) + 0.5) / 4096
    estimate = homogeneous_estimate(
        2, 0.5 * (np.cos(phi) ** 2 / ratio + np.sin(phi) ** 2), np.full(4096, 1.0 / 4096)
    )
    return estimate[0], estimate[2]


@lru_cache(maxsize=64)
def pyramid_factor(sides: int) -> tuple[float, float]:
    """
    The estimate F slope / (E* d^2) of a regular pyramid.

    Returns
    -------
    tuple of float
        The factor, and the longest radius of its outline times slope / d.

    Examples
    --------
    >>> round(pyramid_factor(4)[0], 4)
    0.7243
    """
    x, weights = np.polynomial.legendre.leggauss(40)
    estimate = homogeneous_estimate(1, np.cos(0.5 * math.pi / sides * (x + 1.0)), 0.5 * weights)
    return estimate[0], estimate[1]


def homogeneous_estimate(power: int, shape: FloatArray, weights: FloatArray) -> tuple[float, float, float]:
    """
    F / E* of f = r^power shape(phi) at d = 1 by the functional of :class:`RayLaw`, whose equation has a closed derivative here.

    Parameters
    ----------
    shape, weights : ndarray
        Over directions; the weights of a quadrature.

    Returns
    -------
    tuple of float
        Force, longest radius, and fraction of directions in which there is no root.
    """
    n = power
    moment = shape * 0.5 * math.sqrt(math.pi) * math.gamma(0.5 * n + 1.0) / math.gamma(0.5 * n + 1.5)
    top = (2.0 / ((n + 1) * (n + 2) * moment)) ** (1.0 / n)
    end = (2.0 / ((n + 2) * moment)) ** (1.0 / n)
    highest = 2.0 * top - (n + 2) * moment * top ** (n + 1)
    a = (1.0 / ((n + 1) * moment)) ** (1.0 / n)
    level = 0.0
    for _ in range(100):
        before = level
        level = float((weights * (a * a - moment * a ** (n + 2))).sum() / (weights * a).sum())
        if abs(level - before) <= 1e-15 * level:
            return 2.0 * level, float(a.max()), float(weights[level >= highest].sum() / weights.sum())
        # concave beyond its top, so that Newton's steps from the right stay there
        a = end.copy()
        for _ in range(60):
            fall = np.minimum(2.0 - (n + 1) * (n + 2) * moment * a**n, -1e-300)
            a = np.maximum(a - (2.0 * a - (n + 2) * moment * a ** (n + 1) - level) / fall, top)
        a = np.where(level >= highest, top, a)
    raise ConvergenceError(
        f"the estimate of a shape with f ~ r^{n} did not converge (last value {level:g}); use a smaller exponent"
    )
