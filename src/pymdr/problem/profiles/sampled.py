"""Profiles known at sampled radii, and the options for a curve through them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from pymdr.deferred import interpolate
from pymdr.errors import ProblemError
from pymdr.problem.profiles.base import Profile
from pymdr.problem.profiles.curves import cubic_spline, noise_of, power_of_two
from pymdr.problem.values import ArrayField, OptionalArrayField, Value
from pymdr.units import FloatArray, metres

FEWEST_SAMPLES = 5
CLOSEST = 1e-9
"""Least distance of neighbours over their radius; below it double precision cannot resolve a slope."""
WIDEST = 1e30
"""Largest ratio of the last radius to the first above 0; third powers of larger ones overflow."""
SMOOTHED = "smooth them with interpolation = { kind = 'smoothing_spline' }, in Python with SmoothingSpline"
"""Remedy for samples with noise."""


@dataclass(frozen=True, eq=False)
class CubicSpline(Value):
    """
    A cubic spline through every sample, for smooth data without noise.

    Parameters
    ----------
    tip : {"round", "sharp"}
        "round": f' = 0 at r = 0; "sharp": f' is free there (not-a-knot).

    Raises
    ------
    ProblemError
        If `tip` has another value.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.CubicSpline(tip="sharp").tip
    'sharp'
    """

    tip: str = "round"

    def __post_init__(self) -> None:
        if self.tip not in ("round", "sharp"):
            raise ProblemError(f"tip = {self.tip!r}: it must be 'round' (f' = 0 at r = 0) or 'sharp'")


@dataclass(frozen=True, eq=False)
class ShapePreserving(Value):
    """
    A piecewise cubic that rises only where the samples rise (PCHIP), for kinked data.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.ShapePreserving() == mdr.ShapePreserving()
    True
    """


@dataclass(frozen=True, eq=False)
class SmoothingSpline(Value):
    """
    A smoothing spline for noisy data, whose smoothing is estimated from the samples.

    The curve minimises sum (y_i - f(r_i))^2 / s_i^2 + lambda int (d^3 f / dr^3)^2 dr with f'(0) = 0, mirrored at r = 0,
    so that its tip is round. The penalty of a paraboloid is 0, so it is not flattened. Between samples the curve is the
    cubic with the heights and slopes of that minimum. Smooth samples without noise are interpolated.

    Without a scatter, all s_i are equal. Their size and lambda maximise the restricted likelihood, which is more robust
    than cross-validation for few samples.

    With a scatter, s_i is the scatter, taken as the noise of the samples: only lambda maximises the likelihood, and the
    residuals are about the scatter (chi-square is n minus the degrees of freedom of the curve). If the samples contradict
    the scatter (likelihood ratio test at 1 %; the scatter of an azimuthal mean is that of single heights, larger than the
    noise of the mean), only its ratios are used, and the size of the noise is estimated as without a scatter. An entry of
    0 means that samples were aligned there, not that one is exact: it is interpolated from its neighbours.

    See Also
    --------
    Sampled : the profile that it interpolates.
    CubicSpline : through every sample.

    Notes
    -----
    The expectation of f if its third derivative is white noise: Wahba (1978).
    Likelihood compared with cross-validation: Wahba (1985). Reinsch (1967) requires chi-square = n, which smooths too much because the curve contains part of the noise.

    References
    ----------
    - Wahba (1978), J. R. Stat. Soc. B 40, 364-372.
    - Wahba (1985), Ann. Stat. 13, 1378-1402.
    - Reinsch (1967), Numer. Math. 10, 177-183.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.SmoothingSpline() == mdr.SmoothingSpline()
    True
    """


_NO_NOISE = 5e-5
"""Noise over the range of the heights that twenty samples of a smooth bend seem to have; fewer seem to have more."""

Interpolation: TypeAlias = CubicSpline | ShapePreserving | SmoothingSpline


@dataclass(frozen=True)
class Curve:
    """A curve through samples."""

    poly: interpolate.PPoly
    """The piecewise cubic f(r) - f(0)."""
    offset: float
    """Its f(0) in m."""
    description: str
    """Of the curve."""
    misfit: float = 0.0
    """Root mean square distance in m of the samples from the curve."""


@dataclass(frozen=True, eq=False)
class Sampled(Profile):
    """
    A profile known at sampled radii, for example the azimuthal mean of a measured tip.

    Nothing is extrapolated beyond the last sample: loads whose contact or certificate would need it are refused.

    Parameters
    ----------
    radius : array_like or quantity
        Radii in m, rising strictly from 0; at least 5.
    height : array_like or quantity
        f at those radii in m; an offset at r = 0 is removed when the profile is mapped.
    scatter : array_like or quantity, optional
        Standard deviation of f at those radii in m, not negative. It gives a band on every quantity.
    interpolation : CubicSpline, ShapePreserving or SmoothingSpline, optional
        The curve through the samples; default ``SmoothingSpline()`` if an entry of `scatter` is above 0, else
        ``CubicSpline()``.

    Raises
    ------
    ProblemError
        If there are too few samples, the lengths differ, the radii do not rise from 0, neighbours are closer than
        1e-9 of their radius, the radii span more than 30 decades, or an entry of `scatter` is negative.
    UnitError
        If an entry is not a finite number.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> r = np.linspace(0, 1e-6, 21)
    >>> tip = mdr.Sampled(r, r**2 / 2e-6)
    >>> round(float(tip.gap(0.5e-6)), 18)
    1.25e-07
    >>> tip.curve_description
    'a cubic spline with a round tip through every sample'
    >>> mdr.Sampled(r, r**2 / 2e-6, scatter=1e-3 * r).interpolation
    SmoothingSpline()
    """

    radius: ArrayField = ArrayField("m", description="radii")
    height: ArrayField = ArrayField("m", description="gap at the radii")
    scatter: OptionalArrayField = OptionalArrayField("m", description="standard deviation of the gap")
    interpolation: Interpolation | None = None

    def __post_init__(self) -> None:
        r = self.radius
        if r.size < FEWEST_SAMPLES:
            raise ProblemError(f"{r.size} samples; at least {FEWEST_SAMPLES} are needed")
        for name in ("height", "scatter"):
            values = getattr(self, name)
            if values is not None and values.shape != r.shape:
                raise ProblemError(
                    f"{values.size} entries of {name} for {r.size} radii; give one entry per radius"
                )
        if r[0] != 0.0:
            order = "; reverse the order of the samples" if r[-1] == 0.0 else ""
            raise ProblemError(f"radius begins at {metres(r[0])}: it must begin at 0 m, the apex{order}")
        _refuse_unsorted(r)
        if self.scatter is not None and np.any(self.scatter < 0.0):
            raise ProblemError(f"scatter = {metres(self.scatter.min())}: it must be at least 0 m")
        if self.interpolation is None:
            noisy = self.scatter is not None and bool(np.any(self.scatter > 0.0))
            object.__setattr__(self, "interpolation", SmoothingSpline() if noisy else CubicSpline())
        elif not isinstance(self.interpolation, Interpolation):
            raise ProblemError(
                f"interpolation = {self.interpolation!r}: CubicSpline(), ShapePreserving() or "
                "SmoothingSpline() is needed"
            )

    @cached_property
    def _curve(self) -> Curve:
        assert self.interpolation is not None
        return curve(self.radius, self.height, self.scatter, self.interpolation)

    @property
    def spline(self) -> interpolate.PPoly:
        """The piecewise cubic f(r) - f(0)."""
        return self._curve.poly

    @property
    def curve_description(self) -> str:
        """Description of the curve through the samples, and of their noise."""
        return self._curve.description

    @property
    def misfit(self) -> float:
        """Root mean square distance in m of the samples from the curve; 0 for interpolation."""
        return self._curve.misfit

    @property
    def offset(self) -> float:
        """The removed height of the curve at r = 0 in m."""
        return self._curve.offset

    @cached_property
    def noise(self) -> float:
        """
        Standard deviation of the noise of the heights in m.

        It is estimated from the heights alone, independent of the curve: the median of the absolute residuals of three to
        five neighbours from a line, a parabola or a cubic, each over its standard deviation for unit noise, divided by
        0.6745. It is rounding for samples without noise, 0 if most samples repeat a height, too small for correlated noise,
        too large if few samples resolve a bend, and imprecise below about twenty samples.

        Notes
        -----
        Gasser, Sroka and Jennen-Steinmetz (1986), Biometrika 73, 625, with the median in place of the mean, so that
        kinks and outliers do not count as noise.

        Examples
        --------
        >>> r = np.linspace(0, 1e-6, 401)
        >>> error = 1e-12 * np.random.default_rng(0).standard_normal(401)
        >>> bool(0.8e-12 < Sampled(r, r**2 / 2e-6 + error).noise < 1.2e-12)
        True
        """
        return noise_of(self.radius, self.height)

    @property
    def unsmoothed(self) -> str:
        """How to smooth samples that have noise and a curve through every one; empty without noise."""
        least = _NO_NOISE * max(1.0, 20.0 / self.radius.size) ** 5 * float(np.ptp(self.height))
        if isinstance(self.interpolation, SmoothingSpline) or self.noise <= least:
            return ""
        return f"the curve passes through every sample, and these have a noise of about {metres(self.noise)}: {SMOOTHED}"

    @property
    def max_radius(self) -> float:
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


def _refuse_unsorted(r: FloatArray) -> None:
    steps = np.diff(r)
    if np.any(steps <= 0.0):
        i = int(np.argmax(steps <= 0.0))
        verb = "repeats" if steps[i] == 0.0 else "falls"
        raise ProblemError(
            f"radius {verb} at entry {i + 2} ({metres(r[i])}, then {metres(r[i + 1])}): radii must rise strictly; "
            "sort the samples and average those that repeat"
        )
    merged = steps < CLOSEST * r[1:]
    if np.any(merged):
        i = int(np.argmax(merged))
        raise ProblemError(
            f"radius: entries {i + 1} and {i + 2} ({float(r[i])!r} m, then {float(r[i + 1])!r} m) are "
            f"at a distance of {metres(steps[i])}, less than {CLOSEST:g} of their radius, where double precision cannot resolve a slope; "
            "average them"
        )
    if r[1] < r[-1] / WIDEST:
        raise ProblemError(
            f"radius: entry 2 is {float(r[1])!r} m, less than {1.0 / WIDEST:g} of the last, "
            f"{metres(r[-1])}; omit samples so close to the apex"
        )


def curve(
    radius: FloatArray, height: FloatArray, scatter: FloatArray | None, interpolation: Interpolation
) -> Curve:
    """
    Run a piecewise cubic through samples, with the value 0 at r = 0.

    Lengths are first divided by powers of two, so that the result is independent of the scale and no digit is lost.

    Parameters
    ----------
    radius, height : ndarray
        Samples in m.
    scatter : ndarray or None
        Standard deviations in m.
    """
    from scipy import interpolate

    with np.errstate(over="ignore", invalid="ignore"):
        width = power_of_two(float(radius[-1]))
        raised = height - height[0]
        highest = float(np.max(np.abs(raised)))
        size = power_of_two(highest or width)
        c, level, misfit, words = _scaled_curve(radius / width, raised / size, scatter, size, interpolation)
        for power in range(4):
            c[3 - power] *= size
            for _ in range(power):  # the third power of a small width underflows
                c[3 - power] /= width
    if not np.isfinite(c).all():
        raise ProblemError(
            f"the cubics through heights up to {highest:g} m over radii up to {float(radius[-1]):g} m overflow; give "
            "lengths in m"
        )
    poly = interpolate.PPoly(c, np.array(radius))
    for array in (poly.c, poly.x):
        array.flags.writeable = False
    return Curve(poly, float(height[0]) + level * size, words, misfit * size)


def _scaled_curve(
    r: FloatArray, f: FloatArray, scatter: FloatArray | None, size: float, interpolation: Interpolation
) -> tuple[FloatArray, float, float, str]:
    """Coefficients, f(0), misfit and description of the curve through samples of size 1."""
    from scipy import interpolate

    if not np.isfinite(f).all():
        return np.full((4, r.size - 1), math.nan), 0.0, 0.0, ""
    if isinstance(interpolation, SmoothingSpline):
        return _smoothing(r, f, scatter, size)
    if isinstance(interpolation, CubicSpline):
        c = cubic_spline(r, f, tip_slope=0.0 if interpolation.tip == "round" else None)
        words = f"a cubic spline with a {interpolation.tip} tip through every sample"
    else:
        c = np.array(interpolate.PchipInterpolator(r, f).c)
        words = "a shape-preserving cubic through every sample"
    c[3] = f[:-1]
    return c, 0.0, 0.0, words


def _smoothing(
    r: FloatArray, f: FloatArray, scatter: FloatArray | None, size: float
) -> tuple[FloatArray, float, float, str]:
    from pymdr.problem.profiles.smoothing import smooth

    known = scatter is not None and bool(np.any(scatter > 0.0))
    deviation = np.ones(r.size)
    if scatter is not None and known:
        positive = np.flatnonzero(scatter)
        deviation = np.interp(np.arange(r.size), positive, scatter[positive] / size)
    fit = smooth(r, f, deviation, known)
    value, slope, bend = fit.values[:-1].T
    third, fourth, fifth = fit.higher[:-1].T
    h = np.diff(r)
    # the cubic with the heights and slopes of the quintic at both ends, without differences of them
    c = np.array(
        [
            third / 6.0 + h * (fourth / 12.0 + h * fifth / 40.0),
            bend / 2.0 - h * h * (fourth / 24.0 + h * fifth / 60.0),
            slope,
            value,
        ]
    )
    misfit = math.sqrt(np.mean((f - fit.level - fit.values[:, 0]) ** 2))
    if not known:
        words = (
            f"a smoothing spline with a misfit of {metres(misfit * size)} (root mean square); the noise of the samples is about "
            f"{metres(fit.noise * size)}"
        )
    elif fit.believed:
        words = f"a smoothing spline by the scatter; the residuals are {fit.noise:.2g} times the scatter"
    else:
        words = (
            "a smoothing spline by the ratios of the scatter, not its size; the residuals are "
            f"{fit.noise:.2g} times the scatter"
        )
    return c, fit.level, misfit, words
