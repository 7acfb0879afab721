"""Profiles whose equivalent profile is known in closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.problem.profiles.base import Profile
from pymdr.problem.values import OptionalSIField, SIField
from pymdr.units import FloatArray


class Round(Profile):
    """A profile with a round apex."""

    @property
    def tip_radius(self) -> float | None:
        """Radius of curvature of the round apex."""
        return self.curvature_radius


@dataclass(frozen=True, eq=False)
class Sphere(Round):
    """
    The true sphere, f = R - sqrt(R^2 - r^2), known up to r = R.

    Parameters
    ----------
    radius : quantity
        Radius R in m, above 0.

    Examples
    --------
    >>> import pymdr as mdr
    >>> round(float(mdr.Sphere("10 mm").gap(1e-3)), 15)
    5.0125628934e-05
    """

    radius: SIField = SIField("m", above=0.0, description="radius of the sphere")

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f = r^2 / (R + sqrt(R^2 - r^2)), the form without cancellation."""
        r, R = np.asarray(r, dtype=float), self.radius
        with np.errstate(invalid="ignore"):
            return np.asarray(r * (r / (R + np.sqrt((R - r) * (R + r)))))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f' = r / sqrt(R^2 - r^2)."""
        r, R = np.asarray(r, dtype=float), self.radius
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(r / np.sqrt((R - r) * (R + r)))

    @property
    def max_radius(self) -> float:
        """The sphere ends at r = R."""
        return self.radius

    @property
    def curvature_radius(self) -> float | None:
        """The radius R."""
        return self.radius


@dataclass(frozen=True, eq=False)
class SphereOnSphere(Round):
    """
    A sphere on a spherical sample, such as a bead on a cell: the sum of both gaps.

    Parameters
    ----------
    radius : quantity
        Radius R_1 of the sphere in m, above 0.
    sample_radius : quantity
        Radius R_2 of the sample in m, above 0.

    Notes
    -----
    Near the apex it is a paraboloid of the effective radius R = R_1 R_2/(R_1 + R_2) (Hertz 1882); the gap
    is that of the true spheres, up to the smaller radius. Only the contact with the sphere is described: a sample that also deforms
    on its support has another indentation there.

    References
    ----------
    Hertz (1882), J. reine angew. Math. 92, 156-171.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.SphereOnSphere("3 um", sample_radius="6 um").tip_radius
    2e-06
    """

    radius: SIField = SIField("m", above=0.0, description="radius of the sphere")
    sample_radius: SIField = SIField("m", above=0.0, description="radius of the spherical sample")

    @property
    def parts(self) -> tuple[Sphere, Sphere]:
        """Both spheres."""
        return Sphere(self.radius), Sphere(self.sample_radius)

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m, the sum of both."""
        one, other = self.parts
        return np.asarray(one.gap(r) + other.gap(r))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r), the sum of both."""
        one, other = self.parts
        return np.asarray(one.gap_slope(r) + other.gap_slope(r))

    @property
    def max_radius(self) -> float:
        """The gap ends at the smaller radius."""
        return min(self.radius, self.sample_radius)

    @property
    def curvature_radius(self) -> float | None:
        """The effective radius R."""
        return self.radius / (1.0 + self.radius / self.sample_radius)


@dataclass(frozen=True, eq=False)
class Paraboloid(Round):
    """
    A paraboloid, f = r^2 / (2 R).

    Parameters
    ----------
    radius : quantity
        Radius of curvature R at the apex in m, above 0.

    Examples
    --------
    >>> import pymdr as mdr
    >>> float(mdr.Paraboloid("10 mm").gap(1e-3))
    5e-05
    """

    radius: SIField = SIField("m", above=0.0, description="radius of curvature at the apex")

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m."""
        r = np.asarray(r, dtype=float)
        return np.asarray(r * (r / (2.0 * self.radius)))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        return np.asarray(np.asarray(r, dtype=float) / self.radius)

    @property
    def curvature_radius(self) -> float | None:
        """The radius R."""
        return self.radius


@dataclass(frozen=True, eq=False)
class Ellipsoid(Round):
    """
    An elliptic cap, f = H (1 - sqrt(1 - (r / A)^2)), known up to r = A.

    Its image is that of the sphere of radius A times H / A, g = (H / A) x artanh(x / A).

    Parameters
    ----------
    radius : quantity
        Semi-axis A across the axis of symmetry in m, above 0.
    height : quantity
        Semi-axis H along the axis of symmetry in m, above 0.

    See Also
    --------
    EllipticParaboloid : for contacts that are ellipses.

    Notes
    -----
    Popov, Hess and Willert (2019), chapter 2.

    References
    ----------
    Popov, Hess and Willert (2019), Handbook of Contact Mechanics, Springer, doi:10.1007/978-3-662-58709-6.

    Examples
    --------
    >>> import pymdr as mdr
    >>> round(float(mdr.Ellipsoid("5 mm", "2 mm").gap(3e-3)), 15)
    0.0004
    """

    radius: SIField = SIField("m", above=0.0, description="semi-axis across the axis of symmetry")
    height: SIField = SIField("m", above=0.0, description="semi-axis along the axis of symmetry")

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m: that of a sphere times H / A."""
        return np.asarray(self.height / self.radius * Sphere(self.radius).gap(r))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        return np.asarray(self.height / self.radius * Sphere(self.radius).gap_slope(r))

    @property
    def max_radius(self) -> float:
        """The ellipsoid ends at r = A."""
        return self.radius

    @property
    def curvature_radius(self) -> float | None:
        """Radius of curvature A^2 / H at the apex."""
        return self.radius * (self.radius / self.height)


def slope_field() -> OptionalSIField:
    """The field of the slope of a flank."""
    hint = "an angle between axis and flank is half_angle='70 deg'"
    return OptionalSIField("", above=0.0, description="slope of the flank", hint=hint)


def half_angle_field() -> OptionalSIField:
    """The field of the half angle of a flank."""
    return OptionalSIField("rad", above=0.0, below=math.pi / 2, description="angle between axis and flank")


class Flanked(Profile):
    """A profile with a straight flank, of which exactly one of slope and half angle is given."""

    slope: OptionalSIField
    half_angle: OptionalSIField

    def __post_init__(self) -> None:
        if (self.slope is None) == (self.half_angle is None):
            raise ProblemError(
                f"slope = {self.slope}, half_angle = {self.half_angle}: give exactly one, for "
                "example half_angle='70 deg'"
            )

    @property
    def gradient(self) -> float:
        """Slope f' of the flank."""
        if self.half_angle is None:
            assert self.slope is not None
            return self.slope
        return math.tan(math.pi / 2 - self.half_angle)


@dataclass(frozen=True, eq=False)
class Cone(Flanked):
    """
    A cone, f = slope r, given by exactly one of its slope and its half angle.

    Parameters
    ----------
    slope : quantity, optional
        Slope of the flank, f' = cot(half angle), above 0.
    half_angle : quantity, optional
        Angle between axis and flank in rad, between 0 and pi/2.

    Raises
    ------
    ProblemError
        If not exactly one is given, or a value is outside its limits.

    Examples
    --------
    >>> import pymdr as mdr
    >>> round(mdr.Cone(half_angle="70 deg").gradient, 12)
    0.363970234266
    """

    slope: OptionalSIField = slope_field()
    half_angle: OptionalSIField = half_angle_field()

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m."""
        return np.asarray(self.gradient * np.asarray(r, dtype=float))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        return np.full(np.shape(r), self.gradient)


@dataclass(frozen=True, eq=False)
class PowerLaw(Round):
    """
    A power law, f = height (r / radius)^exponent.

    Parameters
    ----------
    exponent : quantity
        Exponent n, above 0.
    height : quantity
        Gap in m at r = `radius`, above 0.
    radius : quantity
        Reference radius in m, above 0.

    Examples
    --------
    >>> import pymdr as mdr
    >>> float(mdr.PowerLaw(4, "1 um", "1 mm").gap(2e-3))
    1.6e-05
    """

    exponent: SIField = SIField("", above=0.0, description="exponent n")
    height: SIField = SIField("m", above=0.0, description="gap at the reference radius")
    radius: SIField = SIField("m", above=0.0, description="reference radius")

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m."""
        return np.asarray(self.height * (np.asarray(r, dtype=float) / self.radius) ** self.exponent)

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        n = self.exponent
        with np.errstate(divide="ignore"):
            relative = (np.asarray(r, dtype=float) / self.radius) ** (n - 1.0)
        return np.asarray(n * (self.height / self.radius) * relative)

    @property
    def curvature_radius(self) -> float | None:
        """Radius of curvature R^2 / (2 h) of a power law with n = 2, a paraboloid."""
        return self.radius * (self.radius / (2.0 * self.height)) if self.exponent == 2.0 else None


@dataclass(frozen=True, eq=False)
class FlatPunch(Profile):
    """
    A flat cylindrical punch with a sharp edge: f = 0 up to its radius, infinite beyond.

    Added to another profile it gives a cylinder whose end has that shape.

    Parameters
    ----------
    radius : quantity
        Radius b of the cylinder in m, above 0.

    Examples
    --------
    >>> import pymdr as mdr
    >>> rounded = mdr.FlatPunch("1 mm") + mdr.Paraboloid("20 mm")
    >>> rounded.edge
    0.001
    """

    radius: SIField = SIField("m", above=0.0, description="radius of the cylinder")

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m."""
        return np.where(np.asarray(r, dtype=float) <= self.radius, 0.0, math.inf)

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r) below the edge."""
        return np.zeros(np.shape(r))

    @property
    def edge(self) -> float:
        """The sharp edge at r = b."""
        return self.radius
