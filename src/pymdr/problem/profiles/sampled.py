"""Profiles known at sampled radii, and the ways to run a curve through them."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.problem.profiles.base import Profile
from pymdr.problem.values import ArrayField, OptionalArrayField, Value
from pymdr.units import FloatArray, metres

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

FEWEST_SAMPLES = 5


@dataclass(frozen=True, eq=False)
class CubicSpline(Value):
    """
    A cubic spline through every sample, for smooth data without noise.

    Parameters
    ----------
    tip : {"round", "sharp"}
        Whether f' is 0 at r = 0, or free there (not-a-knot).

    Raises
    ------
    ProblemError
        If `tip` is another word.

    Examples
    --------
    >>> CubicSpline(tip="sharp").tip
    'sharp'
    """

    tip: str = "round"

    def __post_init__(self) -> None:
        if self.tip not in ("round", "sharp"):
            raise ProblemError(
                f"CubicSpline.tip = {self.tip!r}: it must be 'round' (f' = 0 at r = 0) or 'sharp'"
            )


@dataclass(frozen=True, eq=False)
class ShapePreserving(Value):
    """
    A piecewise cubic that rises only where the samples rise (PCHIP), for kinked data.

    Examples
    --------
    >>> ShapePreserving() == ShapePreserving()
    True
    """


@dataclass(frozen=True, eq=False)
class SmoothingSpline(Value):
    """
    A cubic smoothing spline whose stiffness generalised cross-validation chooses, for noisy data.

    Mirrored at r = 0, so that the tip is round; where a scatter is given it weighs the samples.

    Examples
    --------
    >>> SmoothingSpline() == SmoothingSpline()
    True
    """


Interpolation: TypeAlias = CubicSpline | ShapePreserving | SmoothingSpline


@dataclass(frozen=True, eq=False)
class Sampled(Profile):
    """
    A profile known at sampled radii, for example the azimuthal mean of a measured tip.

    Nothing is extrapolated beyond the last sample: loads whose contact or certificate would need it are
    refused.

    Parameters
    ----------
    radius : array_like or quantity
        Radii in m, rising strictly from 0; at least 5.
    height : array_like or quantity
        f at those radii in m; an offset at r = 0 is removed when the profile is mapped.
    scatter : array_like or quantity, optional
        Standard deviation of f at those radii in m, not below 0. It becomes a band on every quantity.
    interpolation : CubicSpline, ShapePreserving or SmoothingSpline
        How a curve is run through the samples.

    Raises
    ------
    ProblemError
        If there are too few samples, the lengths differ, the radii do not rise from 0, or an entry of
        `scatter` is negative.
    UnitError
        If an entry is not a finite number.

    Examples
    --------
    >>> r = np.linspace(0, 1e-6, 21)
    >>> tip = Sampled(r, r**2 / 2e-6)
    >>> round(float(tip.gap(0.5e-6)), 18)
    1.25e-07
    """

    radius: ArrayField = ArrayField("m", words="radii")
    height: ArrayField = ArrayField("m", words="gap at the radii")
    scatter: OptionalArrayField = OptionalArrayField("m", words="standard deviation of the gap")
    interpolation: Interpolation = field(default_factory=CubicSpline)

    def __post_init__(self) -> None:
        r = self.radius
        if r.size < FEWEST_SAMPLES:
            raise ProblemError(f"Sampled: {r.size} samples; at least {FEWEST_SAMPLES} are needed")
        for name in ("height", "scatter"):
            values = getattr(self, name)
            if values is not None and values.shape != r.shape:
                raise ProblemError(
                    f"Sampled: {values.size} entries of {name} for {r.size} radii; give one for each"
                )
        steps = np.diff(r)
        if r[0] != 0.0:
            raise ProblemError(f"Sampled.radius begins at {metres(r[0])}: it must begin at 0 m, the apex")
        if np.any(steps <= 0.0):
            i = int(np.argmax(steps <= 0.0))
            word = "repeats" if steps[i] == 0.0 else "falls"
            raise ProblemError(
                f"Sampled.radius {word} at entry {i + 1} ({metres(r[i])}, then {metres(r[i + 1])}): radii must rise strictly; "
                "sort the samples and average those that repeat"
            )
        if self.scatter is not None and np.any(self.scatter < 0.0):
            raise ProblemError(f"Sampled.scatter = {metres(self.scatter.min())}: it must be at least 0 m")
        if not isinstance(self.interpolation, Interpolation):
            raise ProblemError(
                f"Sampled.interpolation = {self.interpolation!r}: CubicSpline(), ShapePreserving() or "
                "SmoothingSpline() is needed"
            )

    @cached_property
    def spline(self) -> PPoly:
        """The piecewise cubic f(r) - f(0)."""
        return interpolant(self.radius, self.height, self.scatter, self.interpolation)

    @property
    def offset(self) -> float:
        """The height at r = 0 in m that is removed."""
        return float(self.height[0])

    @property
    def reach(self) -> float:
        """The last sampled radius."""
        return float(self.radius[-1])

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The knots of the interpolant."""
        return tuple(self.spline.x[1:-1].tolist())

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m; nan beyond the last sample."""
        return np.asarray(self.spline(np.asarray(r, dtype=float), extrapolate=False))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r); nan beyond the last sample."""
        return np.asarray(self.spline(np.asarray(r, dtype=float), 1, extrapolate=False))


def interpolant(
    radius: FloatArray, height: FloatArray, scatter: FloatArray | None, interpolation: Interpolation
) -> PPoly:
    """
    Run a piecewise cubic through samples, with the value 0 at r = 0.

    Lengths are scaled by the last radius and the largest height first, so that nanometres and metres are
    treated alike.

    Parameters
    ----------
    radius, height : ndarray
        Samples in m.
    scatter : ndarray or None
        Standard deviations in m.
    interpolation : CubicSpline, ShapePreserving or SmoothingSpline

    Returns
    -------
    scipy.interpolate.PPoly
    """
    from scipy import interpolate

    width = float(radius[-1])
    size = float(np.max(np.abs(height - height[0]))) or width
    r, f = radius / width, (height - height[0]) / size
    if isinstance(interpolation, CubicSpline):
        ends = ((1, 0.0), "not-a-knot") if interpolation.tip == "round" else "not-a-knot"
        poly = interpolate.CubicSpline(r, f, bc_type=ends)
    elif isinstance(interpolation, ShapePreserving):
        poly = interpolate.PchipInterpolator(r, f)
    else:
        poly = _smoothing(r, f, None if scatter is None else scatter / size)
    breaks = np.array(poly.x)
    coefficients = np.array(poly.c) * size
    for power in range(4):
        coefficients[3 - power] /= width**power
    return interpolate.PPoly(coefficients, breaks * width)


def _smoothing(r: FloatArray, f: FloatArray, scatter: FloatArray | None) -> PPoly:
    """The smoothing spline of the samples mirrored at r = 0, cut to r >= 0 and shifted to f(0) = 0."""
    from scipy import interpolate

    weights = None
    if scatter is not None and np.any(scatter > 0.0):
        floor = 0.1 * float(np.median(scatter[scatter > 0.0]))
        weights = 1.0 / np.maximum(scatter, floor)
        weights = np.concatenate([weights[:0:-1], weights])
    mirrored = interpolate.make_smoothing_spline(
        np.concatenate([-r[:0:-1], r]), np.concatenate([f[:0:-1], f]), w=weights
    )
    poly = interpolate.PPoly.from_spline(mirrored)
    inner = (poly.x[:-1] >= -1e-14) & (poly.x[1:] > poly.x[:-1]) & (poly.x[:-1] < 1.0 - 1e-14)
    breaks = np.concatenate([np.maximum(poly.x[:-1][inner], 0.0), [1.0]])
    coefficients = np.array(poly.c[:, inner])
    coefficients[3] -= coefficients[3, 0]
    coefficients[2, 0] = 0.0
    return interpolate.PPoly(coefficients, breaks)
