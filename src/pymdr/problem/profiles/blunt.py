"""Truncated and rounded tips."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.problem.profiles.base import Profile
from pymdr.problem.profiles.closed import Flanked, half_angle_field, slope_field
from pymdr.problem.values import OptionalSIField, SIField
from pymdr.units import FloatArray, metres

_NEAR_THE_EQUATOR = 0.999
"""Largest relative radius of a truncated sphere, whose flank is vertical at the equator."""


def _flat_field() -> SIField:
    return SIField("m", above=0.0, description="radius of the flat end")


def _beyond(r: ArrayLike, b: float, curve: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """A curve for r > b, and 0 below."""
    r = np.asarray(r, dtype=float)
    return np.where(r <= b, 0.0, curve(np.maximum(r, b)))


class Truncated(Profile):
    """A profile that is flat up to a rim."""

    flat_radius: SIField

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The rim of the flat, where f' jumps."""
        return (self.flat_radius,)


@dataclass(frozen=True, eq=False)
class TruncatedCone(Truncated, Flanked):
    """
    A cone whose tip is cut off flat at r = b, f = t (r - b) for r > b and 0 below.

    Its image is g = t x arccos(b / x) beyond b; the contact begins with the whole flat.

    Parameters
    ----------
    flat_radius : quantity
        Radius b of the flat end in m, above 0.
    slope : quantity, optional
        Slope t of the flank, above 0.
    half_angle : quantity, optional
        Angle between axis and flank in rad, between 0 and pi/2, instead of the slope.

    Raises
    ------
    ProblemError
        If not exactly one of slope and half angle is given, or a value is outside its limits.

    See Also
    --------
    Cone : before it was worn.

    Notes
    -----
    Popov, Hess and Willert (2019), chapter 2: F = t E* a^2 [arccos(b/a) + (b/a) sqrt(1 - (b/a)^2)].

    References
    ----------
    Popov, Hess and Willert (2019), Handbook of Contact Mechanics, Springer, doi:10.1007/978-3-662-58709-6.

    Examples
    --------
    >>> import pymdr as mdr
    >>> round(float(mdr.TruncatedCone(slope=0.1, flat_radius="1 um").gap(3e-6)), 15)
    2e-07
    """

    flat_radius: SIField = _flat_field()
    slope: OptionalSIField = slope_field()
    half_angle: OptionalSIField = half_angle_field()

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m."""
        b = self.flat_radius
        return _beyond(r, b, lambda r: self.gradient * (r - b))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        return _beyond(r, self.flat_radius, lambda r: np.full(r.shape, self.gradient))


@dataclass(frozen=True, eq=False)
class TruncatedParaboloid(Truncated):
    """
    A paraboloid worn flat up to r = b, f = (r^2 - b^2) / (2 R) for r > b and 0 below.

    Its image is g = (x / R) sqrt(x^2 - b^2) beyond b; the contact begins with the whole flat.

    Parameters
    ----------
    radius : quantity
        Original radius of curvature R of the apex in m, above 0.
    flat_radius : quantity
        Radius b of the flat end in m, above 0.

    See Also
    --------
    Paraboloid : before it was worn.

    Notes
    -----
    Popov, Hess and Willert (2019), chapter 2: F = (2 E* / (3 R)) (2 a^2 + b^2) sqrt(a^2 - b^2).

    References
    ----------
    Popov, Hess and Willert (2019), Handbook of Contact Mechanics, Springer, doi:10.1007/978-3-662-58709-6.

    Examples
    --------
    >>> import pymdr as mdr
    >>> round(float(mdr.TruncatedParaboloid("1 mm", flat_radius="10 um").gap(20e-6)), 15)
    1.5e-07
    """

    radius: SIField = SIField("m", above=0.0, description="original radius of curvature of the apex")
    flat_radius: SIField = _flat_field()

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m."""
        b = self.flat_radius
        return _beyond(r, b, lambda r: (r - b) * ((r + b) / (2.0 * self.radius)))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        return _beyond(r, self.flat_radius, lambda r: r / self.radius)


@dataclass(frozen=True, eq=False)
class TruncatedSphere(Truncated):
    """
    A worn sphere: flat up to r = b, beyond it f = sqrt(R^2 - b^2) - sqrt(R^2 - r^2), known up to 0.999 R.

    Its image is g = x artanh sqrt((x^2 - b^2) / (R^2 - b^2)) beyond b; the contact begins with the whole flat.

    Parameters
    ----------
    radius : quantity
        Radius R of the sphere in m, above 0.
    flat_radius : quantity
        Radius b of the flat end in m, above 0 and below 0.999 R.

    See Also
    --------
    Sphere : before it was worn.

    Notes
    -----
    The image of the sphere (Popov and Hess 2015, chapter 3) with the integral starting at b. With
    u = sqrt(a^2 - b^2) and c = sqrt(R^2 - b^2), F = E* [(R^2 + a^2) artanh(u / c) - u c].

    References
    ----------
    Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, Springer,
    doi:10.1007/978-3-642-53876-6.

    Examples
    --------
    >>> import pymdr as mdr
    >>> round(float(mdr.TruncatedSphere("10 mm", flat_radius="6 mm").gap(8e-3)), 15)
    0.002
    """

    radius: SIField = SIField("m", above=0.0, description="radius of the sphere")
    flat_radius: SIField = _flat_field()

    def __post_init__(self) -> None:
        if not self.flat_radius < self.max_radius:
            raise ProblemError(
                f"flat_radius = {metres(self.flat_radius)}: it must be below 0.999 of the radius, "
                f"{metres(self.radius)}; for a cylinder with a flat end use FlatPunch(radius)"
            )

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m, the form without cancellation."""
        b, flat = self.flat_radius, self._height(np.asarray(self.flat_radius))
        return _beyond(r, b, lambda r: (r - b) * ((r + b) / (flat + self._height(r))))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        with np.errstate(divide="ignore"):
            return _beyond(r, self.flat_radius, lambda r: r / self._height(r))

    def _height(self, r: FloatArray) -> FloatArray:
        with np.errstate(invalid="ignore"):
            return np.asarray(np.sqrt((self.radius - r) * (self.radius + r)))

    @property
    def max_radius(self) -> float:
        """0.999 of the radius: the flank is vertical at the equator."""
        return _NEAR_THE_EQUATOR * self.radius


@dataclass(frozen=True, eq=False)
class RoundedCone(Flanked):
    """
    A cone with a parabolic tip, f = r^2 / (2 R) up to r = b = t R and t (r - b / 2) beyond, without a kink.

    Its image is g = x^2 / R up to b, and t x [(x - sqrt(x^2 - b^2)) / b + arccos(b / x)] beyond.

    Parameters
    ----------
    tip_radius : quantity
        Radius of curvature R at the apex in m, above 0.
    slope : quantity, optional
        Slope t of the flank, above 0.
    half_angle : quantity, optional
        Angle between axis and flank in rad, between 0 and pi/2, instead of the slope.

    Raises
    ------
    ProblemError
        If not exactly one of slope and half angle is given, or a value is outside its limits.

    See Also
    --------
    Cone : with a sharp tip.
    Hyperboloid : another round tip on a cone.

    Notes
    -----
    Popov, Hess and Willert (2019), chapter 2 (conical indenter with parabolic cap).

    References
    ----------
    Popov, Hess and Willert (2019), Handbook of Contact Mechanics, Springer, doi:10.1007/978-3-662-58709-6.

    Examples
    --------
    >>> import pymdr as mdr
    >>> tip = mdr.RoundedCone(slope=0.5, tip_radius="100 nm")
    >>> tip.breakpoints
    (5e-08,)
    """

    tip_radius: SIField = SIField("m", above=0.0, description="radius of curvature at the apex")
    slope: OptionalSIField = slope_field()
    half_angle: OptionalSIField = half_angle_field()

    @property
    def curvature_radius(self) -> float | None:
        """The radius R of the tip."""
        return self.tip_radius

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Start of the flank, b = t R, where f'' jumps."""
        return (self.gradient * self.tip_radius,)

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m."""
        r, b = np.asarray(r, dtype=float), self.breakpoints[0]
        inside = np.minimum(r, b)
        return np.asarray(
            inside * (inside / (2.0 * self.tip_radius)) + self.gradient * np.maximum(r - b, 0.0)
        )

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        return np.asarray(np.minimum(np.asarray(r, dtype=float) / self.tip_radius, self.gradient))


@dataclass(frozen=True, eq=False)
class Hyperboloid(Flanked):
    """
    A hyperboloid, f = t (sqrt(r^2 + c^2) - c) with c = t R: round at its apex, a cone far from it.

    Its image is g = t x arctan(x / c).

    Parameters
    ----------
    tip_radius : quantity
        Radius of curvature R at the apex in m, above 0.
    slope : quantity, optional
        Slope t of the asymptotic cone, above 0.
    half_angle : quantity, optional
        Angle between axis and asymptotic flank in rad, between 0 and pi/2, instead of the slope.

    Raises
    ------
    ProblemError
        If not exactly one of slope and half angle is given, or a value is outside its limits.

    See Also
    --------
    RoundedCone : another round tip on a cone.

    Notes
    -----
    Popov, Hess and Willert (2019), chapter 2.

    References
    ----------
    Popov, Hess and Willert (2019), Handbook of Contact Mechanics, Springer, doi:10.1007/978-3-662-58709-6.

    Examples
    --------
    >>> import pymdr as mdr
    >>> round(float(mdr.Hyperboloid(slope=0.5, tip_radius="6 um").gap(4e-6)), 15)
    1e-06
    """

    tip_radius: SIField = SIField("m", above=0.0, description="radius of curvature at the apex")
    slope: OptionalSIField = slope_field()
    half_angle: OptionalSIField = half_angle_field()

    @property
    def curvature_radius(self) -> float | None:
        """The radius R of the tip."""
        return self.tip_radius

    @property
    def _scale(self) -> float:
        return self.gradient * self.tip_radius

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f = t r^2 / (sqrt(r^2 + c^2) + c), the form without cancellation."""
        r, c = np.asarray(r, dtype=float), self._scale
        return np.asarray(self.gradient * r * (r / (np.hypot(r, c) + c)))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        r = np.asarray(r, dtype=float)
        return np.asarray(self.gradient * (r / np.hypot(r, self._scale)))
