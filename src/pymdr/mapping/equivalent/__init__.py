"""The equivalent profile g(x) of a profile f(r)."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache, singledispatch

import numpy as np

from pymdr.errors import ProblemError
from pymdr.mapping.abel import Curve
from pymdr.mapping.closure import closure_of
from pymdr.mapping.equivalent.base import EquivalentProfile as EquivalentProfile
from pymdr.mapping.equivalent.closed import PowerLine as PowerLine
from pymdr.mapping.equivalent.closed import SphereLine as SphereLine
from pymdr.mapping.equivalent.closed import SumLine as SumLine
from pymdr.mapping.equivalent.closed import power_factor as power_factor
from pymdr.mapping.equivalent.panels import PanelLine as PanelLine
from pymdr.mapping.equivalent.polygon import PolygonLine as PolygonLine
from pymdr.mapping.equivalent.polygon import polygon_of
from pymdr.mapping.equivalent.worn import worn_line
from pymdr.mapping.sources import source_of
from pymdr.problem import profiles
from pymdr.units import FloatArray

_STEEPEST = 0.95
"""Largest |k| for panels; for larger ones distances underflow on which curves next to a breakpoint still change."""


@singledispatch
def equivalent_profile(profile: profiles.Profile, exponent: float = 0.0) -> EquivalentProfile:
    """
    Map a profile onto the line, g(x) = x^(1-k) int_0^x f'(r) (x^2 - r^2)^((k-1)/2) dr.

    Parameters
    ----------
    profile : Profile
        The gap f(r).
    exponent : float
        k of a power-law graded half-space, E(z) ~ z^k, -1 < k < 1; 0 for a homogeneous one.

    Returns
    -------
    EquivalentProfile
        With ``g(x)``, ``slope(x)``, ``integral(x)``, ``inverse(depth)`` and more, in SI units.

    Raises
    ------
    ProblemError
        If the profile is not known to pymdr, or the exponent not between -1 and 1.

    See Also
    --------
    foundation : the line as discrete springs.
    effective_moduli : the stiffness of its springs.

    Notes
    -----
    Galin (1961), Sneddon (1965); Popov and Hess (2015), chapter 3; Hess (2016) for k.

    References
    ----------
    - Galin (1961), Contact Problems in the Theory of Elasticity; first published in Russian, 1953.
    - Sneddon (1965), Int. J. Eng. Sci. 3, 47-57, doi:10.1016/0020-7225(65)90019-4.
    - Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, Springer,
      doi:10.1007/978-3-642-53876-6.
    - Hess (2016), Int. J. Eng. Sci. 104, 20-33.

    Examples
    --------
    >>> import pymdr as mdr
    >>> line = mdr.equivalent_profile(mdr.Paraboloid(2.0))
    >>> float(line.g(1.0))
    0.5
    >>> round(float(mdr.equivalent_profile(mdr.Paraboloid(2.0), 0.5).g(1.0)), 15) == round(1 / 3, 15)
    True
    """
    raise ProblemError(
        f"no map for {type(profile).__name__}; give the profile as Function(f, derivative=...)"
    )


@equivalent_profile.register
def _(profile: profiles.Sphere, exponent: float = 0.0) -> EquivalentProfile:
    return SphereLine(profile.radius) if exponent == 0.0 else _on_panels(profile, exponent)


@equivalent_profile.register
def _(profile: profiles.SphereOnSphere, exponent: float = 0.0) -> EquivalentProfile:
    return equivalent_profile(profiles.Sum(profile.parts), exponent)


@equivalent_profile.register
def _(profile: profiles.Ellipsoid, exponent: float = 0.0) -> EquivalentProfile:
    if exponent != 0.0:
        return _on_panels(profile, exponent)
    return SphereLine(profile.radius, profile.height / profile.radius)


@equivalent_profile.register
def _(profile: profiles.Paraboloid, exponent: float = 0.0) -> EquivalentProfile:
    # kappa(2) = 2 / (1 + k)
    return PowerLine(2.0, profile.radius / (1.0 + _checked(exponent)), profile.radius, exponent)


@equivalent_profile.register
def _(profile: profiles.Cone, exponent: float = 0.0) -> EquivalentProfile:
    kappa = math.pi / 2.0 if exponent == 0.0 else power_factor(1.0, _checked(exponent))
    return PowerLine(1.0, kappa * profile.gradient, 1.0, exponent)


@equivalent_profile.register
def _(profile: profiles.PowerLaw, exponent: float = 0.0) -> EquivalentProfile:
    kappa = power_factor(profile.exponent, _checked(exponent))
    return PowerLine(profile.exponent, kappa * profile.height, profile.radius, exponent)


@equivalent_profile.register
def _(profile: profiles.FlatPunch, exponent: float = 0.0) -> EquivalentProfile:
    return SumLine((), profile.radius, exponent=_checked(exponent))


@equivalent_profile.register
def _(profile: profiles.DomedPunch, exponent: float = 0.0) -> EquivalentProfile:
    radius = profile.dome_radius
    dome = PowerLine(2.0, radius / (1.0 + _checked(exponent)), radius, exponent)
    return SumLine((dome,), profile.radius, exponent=exponent)


def _by_panels(profile: profiles.Profile, exponent: float = 0.0) -> EquivalentProfile:
    return _on_panels(profile, exponent)


# closed forms of g beside a rim lose the digits that places keep, and their energies have none
for _kind in (
    profiles.AreaFunction,
    profiles.ConcavePunch,
    profiles.Function,
    profiles.Hyperboloid,
    profiles.Interpolated,
    profiles.RoundedCone,
    profiles.RoundedFlat,
    profiles.Sampled,
    profiles.TruncatedCone,
    profiles.TruncatedParaboloid,
    profiles.TruncatedSphere,
    profiles.Waviness,
):
    equivalent_profile.register(_kind, _by_panels)


@equivalent_profile.register
def _(profile: profiles.Worn, exponent: float = 0.0) -> EquivalentProfile:
    if profile.spring_radius is None or exponent != 0.0:
        return _on_panels(profile, exponent)
    return worn_line(profile, equivalent_profile(profile.original))


@equivalent_profile.register
def _(profile: profiles.ForceCurve, exponent: float = 0.0) -> EquivalentProfile:
    if exponent != 0.0:
        raise ProblemError(
            f"a ForceCurve needs homogeneous half-spaces, but the exponent is {exponent:g}; give exponent 0"
        )
    return _polygon(profile)


@equivalent_profile.register
def _(profile: profiles.Shape, exponent: float = 0.0) -> EquivalentProfile:
    name = type(profile).__name__
    raise ProblemError(
        f"{name} is not of revolution and has no equivalent profile: solve(...) gives its normal force without adhesion and friction; "
        "for friction, memory and impacts use solve(...).force_curve() as the profile of "
        "another contact; azimuthal_mean(shape) is the profile of its lower bound"
    )


@lru_cache(maxsize=64)
def _polygon(profile: profiles.ForceCurve) -> PolygonLine:
    return polygon_of(closure_of(profile).stiffness, profile.modulus)


@equivalent_profile.register
def _(profile: profiles.Sum, exponent: float = 0.0) -> EquivalentProfile:
    # a registered map may support the homogeneous half-space only
    graded = (exponent,) if exponent != 0.0 else ()
    parts = [equivalent_profile(part, *graded) for part in profile.parts]
    if any(isinstance(part, PanelLine) for part in parts):
        return _on_panels(profile, exponent)
    return SumLine(
        tuple(p for part in parts for p in (part.parts if isinstance(part, SumLine) else (part,))),
        profile.edge,
        profile.max_radius,
        exponent,
    )


@lru_cache(maxsize=256)
def _on_panels(profile: profiles.Profile, exponent: float) -> PanelLine:
    """One map for every profile and exponent, however many contacts it is part of."""
    parts = profile.parts if isinstance(profile, profiles.Sum) else (profile,)
    known = all(not isinstance(part, profiles.Function) or part.f is not None for part in parts)
    if abs(_checked(exponent)) > _STEEPEST:
        raise ProblemError(
            f"{type(profile).__name__} has no closed form on a graded half-space of exponent {exponent:g}, and panels resolve "
            f"exponents from {-_STEEPEST:g} to {_STEEPEST:g}; beyond that use PowerLaw or FlatPunch"
        )
    return PanelLine(source_of(profile), profile.edge, profile.gap if known else None, exponent)


def _checked(exponent: float) -> float:
    if not -1.0 < exponent < 1.0:
        raise ProblemError(
            f"the exponent of a graded half-space is {exponent:g}; it must lie between -1 and 1"
        )
    return exponent


def gap_function(profile: profiles.Profile, equivalent: EquivalentProfile) -> Curve:
    """
    f(r) of a profile as a callable, by the inverse map where a derivative was given.

    Parameters
    ----------
    equivalent : EquivalentProfile
        Its image on the line.
    """
    parts = profile.parts if isinstance(profile, profiles.Sum) else (profile,)
    if all(not isinstance(part, profiles.Function) or part.f is not None for part in parts):
        return profile.gap
    end = min(equivalent.edge, equivalent.max_radius)

    def gap(r: FloatArray) -> FloatArray:
        inside = np.minimum(r, end)
        f = 2.0 / math.pi * equivalent.gap_integral(inside, 0.0)
        return np.where(r > end, math.inf if end == equivalent.edge else math.nan, f)

    return gap


def slope_function(profile: profiles.Profile) -> Curve:
    """f'(r) of a profile as a callable, as used by its map; that of a force curve raises an error when called."""
    if isinstance(profile, profiles.ForceCurve):
        return profile.gap_slope
    source = source_of(profile)

    def slope(r: FloatArray) -> FloatArray:
        return source.sample(np.zeros(r.shape), r)[0]

    return slope


def has_callables(profile: profiles.Profile) -> bool:
    """
    Whether a profile holds a callable, which no file can.

    Examples
    --------
    >>> from pymdr import Sphere
    >>> has_callables(Sphere(1.0))
    False
    """
    parts = profile.parts if isinstance(profile, profiles.Sum) else (profile,)
    parts = tuple(part.original if isinstance(part, profiles.Worn) else part for part in parts)
    return any(isinstance(part, profiles.Function | profiles.Function2D) for part in parts)


def without_callables(profile: profiles.Profile, top: float) -> profiles.Profile:
    """
    The profile with every :class:`Function` replaced by the panels on which it is mapped, for saving; of a Function2D, a grid.

    Parameters
    ----------
    top : float
        Largest radius in m that is needed; all that is mapped is kept.
    """
    if isinstance(profile, profiles.Sum):
        return profiles.Sum(tuple(without_callables(part, top) for part in profile.parts))
    if isinstance(profile, profiles.Worn):
        return replace(profile, original=without_callables(profile.original, top))
    if isinstance(profile, profiles.Function2D):
        return _on_grid(profile, min(top, profile.max_radius))
    return _on_panels(profile, 0.0).as_panels(top) if isinstance(profile, profiles.Function) else profile


_PIXELS = 129
"""Number of points along both sides of the grid that replaces a callable of x and y; odd, for its apex."""


def _on_grid(profile: profiles.Function2D, top: float) -> profiles.Sampled2D:
    """Its gap on a square of half a diagonal of at most `top` m about the apex, as large as all of it is known."""
    half = top / math.sqrt(2.0)
    for _ in range(60):
        x = np.linspace(-half, half, _PIXELS)
        x[_PIXELS // 2] = 0.0
        gap = profile.gap_at(x[:, None], x)
        if np.isfinite(gap).all():
            spacing = 2.0 * half / (_PIXELS - 1)
            return profiles.Sampled2D(-gap, _PIXELS * spacing)
        half /= 2.0
    raise ProblemError(f"the gap is not finite around the apex, up to {top:g} m; define it there")
