"""Punches with rounded edge, dome or hollow, and waves."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.problem.profiles.base import Profile
from pymdr.problem.values import SIField
from pymdr.units import FloatArray


@dataclass(frozen=True, eq=False)
class RoundedFlat(Profile):
    """
    A flat whose edge is rounded, f = (r - b)^2 / (2 R) for r > b and 0 below.

    Its image is g = (x / R) [sqrt(x^2 - b^2) - b arccos(b / x)] beyond b; the contact begins with the whole flat.

    Parameters
    ----------
    flat_radius : quantity
        Radius b of the flat in m, above 0.
    edge_radius : quantity
        Radius of curvature R of the edge in m, above 0.

    See Also
    --------
    FlatPunch : with a sharp edge.

    Notes
    -----
    Popov, Hess and Willert (2019), chapter 2 (flat punch with a rounded edge); Ciavarella, Hills and Monno (1998).

    References
    ----------
    - Popov, Hess and Willert (2019), Handbook of Contact Mechanics, Springer, doi:10.1007/978-3-662-58709-6.
    - Ciavarella, Hills and Monno (1998), Proc. Inst. Mech. Eng. C 212, 319-328.

    Examples
    --------
    >>> import pymdr as mdr
    >>> round(float(mdr.RoundedFlat("1 mm", "0.5 mm").gap(1.1e-3)), 15)
    1e-05
    """

    flat_radius: SIField = SIField("m", above=0.0, description="radius of the flat")
    edge_radius: SIField = SIField("m", above=0.0, description="radius of curvature of the edge")

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m."""
        beyond = np.maximum(np.asarray(r, dtype=float) - self.flat_radius, 0.0)
        return np.asarray(beyond * (beyond / (2.0 * self.edge_radius)))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        return np.asarray(np.maximum(np.asarray(r, dtype=float) - self.flat_radius, 0.0) / self.edge_radius)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The edge of the flat, where f'' jumps."""
        return (self.flat_radius,)


@dataclass(frozen=True, eq=False)
class DomedPunch(Profile):
    """
    A cylinder with a domed end, f = r^2 / (2 R) up to its sharp edge at r = b; FlatPunch(b) + Paraboloid(R).

    Its image is g = x^2 / R up to b. The full end is in contact from the indentation b^2 / R.

    Parameters
    ----------
    radius : quantity
        Radius b of the cylinder in m, above 0.
    dome_radius : quantity
        Radius of curvature R of the end in m, above 0.

    See Also
    --------
    FlatPunch : without the cap.
    ConcavePunch : with a hollow end.

    Notes
    -----
    Popov, Hess and Willert (2019), chapter 2 (cylindrical punch with parabolic cap).

    References
    ----------
    Popov, Hess and Willert (2019), Handbook of Contact Mechanics, Springer, doi:10.1007/978-3-662-58709-6.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.DomedPunch("1 mm", "50 mm").edge
    0.001
    """

    radius: SIField = SIField("m", above=0.0, description="radius of the cylinder")
    dome_radius: SIField = SIField("m", above=0.0, description="radius of curvature of the domed end")

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m; inf beyond the edge."""
        r = np.asarray(r, dtype=float)
        return np.where(r <= self.radius, r * (r / (2.0 * self.dome_radius)), math.inf)

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r) below the edge."""
        return np.asarray(np.asarray(r, dtype=float) / self.dome_radius)

    @property
    def edge(self) -> float:
        """The sharp edge at r = b."""
        return self.radius

    @property
    def curvature_radius(self) -> float | None:
        """The radius R of the dome."""
        return self.dome_radius


@dataclass(frozen=True, eq=False)
class ConcavePunch(Profile):
    """
    A cylinder with a hollow end, f = -r^2 / (2 R) up to its sharp edge at r = b.

    Its image is g = -x^2 / R. The rim touches first: the contact is a ring, which the method refuses, until the
    hollow is pressed flat at the indentation b^2 / R beyond the depth of its centre. Above that depth the solution is exact.

    Parameters
    ----------
    radius : quantity
        Radius b of the cylinder in m, above 0.
    hollow_radius : quantity
        Radius of curvature R of the hollow end in m, above 0.

    See Also
    --------
    DomedPunch : a punch with a convex end.

    Notes
    -----
    Barber (1976); Popov, Hess and Willert (2019), chapter 2 (concave paraboloid). For an indentation d >= b^2 / R,
    F = 2 E* (d b + b^3 / (3 R)).

    References
    ----------
    - Barber (1976), J. Elasticity 6, 149-159.
    - Popov, Hess and Willert (2019), Handbook of Contact Mechanics, Springer, doi:10.1007/978-3-662-58709-6.

    Examples
    --------
    >>> import pymdr as mdr
    >>> float(mdr.ConcavePunch("1 mm", "0.5 m").gap(1e-3))
    -1e-06
    """

    radius: SIField = SIField("m", above=0.0, description="radius of the cylinder")
    hollow_radius: SIField = SIField("m", above=0.0, description="radius of curvature of the hollow end")

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m, below 0 up to the edge; inf beyond it."""
        r = np.asarray(r, dtype=float)
        return np.where(r <= self.radius, -r * (r / (2.0 * self.hollow_radius)), math.inf)

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r) below the edge."""
        return np.asarray(-np.asarray(r, dtype=float) / self.hollow_radius)

    @property
    def edge(self) -> float:
        """The sharp edge at r = b."""
        return self.radius


@dataclass(frozen=True, eq=False)
class Waviness(Profile):
    """
    Circular waves, f = h (1 - cos(2 pi r / wavelength)), to be added to another profile.

    Their image is g = (pi / 2) h k x H_0(k x), k = 2 pi / wavelength, with the Struve function H_0. Added to a
    paraboloid of radius R, every contact is a disk if h k^2 R <= 3.1859; above, some are rings.

    Parameters
    ----------
    height : quantity
        Amplitude h in m, above 0; crests are 2 h above troughs.
    wavelength : quantity
        Distance of the crests in m, above 0.

    See Also
    --------
    Rings : solver of contacts that are rings.

    Notes
    -----
    Guduru (2007); Popov, Hess and Willert (2019), chapter 2.

    References
    ----------
    - Guduru (2007), J. Mech. Phys. Solids 55, 445-472.
    - Popov, Hess and Willert (2019), Handbook of Contact Mechanics, Springer, doi:10.1007/978-3-662-58709-6.

    Examples
    --------
    >>> import pymdr as mdr
    >>> wavy = mdr.Waviness("10 nm", "1 um")
    >>> float(wavy.gap(0.5e-6))
    2e-08
    """

    height: SIField = SIField("m", above=0.0, description="amplitude of the waves")
    wavelength: SIField = SIField("m", above=0.0, description="distance of the crests")

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f = 2 h sin^2(k r / 2), the form without cancellation."""
        half = np.sin(math.pi / self.wavelength * np.asarray(r, dtype=float))
        return np.asarray(2.0 * self.height * half * half)

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        k = 2.0 * math.pi / self.wavelength
        return np.asarray(self.height * k * np.sin(k * np.asarray(r, dtype=float)))

    @property
    def curvature_radius(self) -> float | None:
        """Radius of curvature 1 / (h k^2) in m of the apex."""
        k = 2.0 * math.pi / self.wavelength
        return 1.0 / (self.height * k) / k
