"""The equivalent profile g(x) of a profile f(r)."""

from __future__ import annotations

import math
from functools import singledispatch

import numpy as np

from pymdr.errors import ProblemError
from pymdr.mapping import abel, chebyshev
from pymdr.mapping.equivalent.base import EquivalentProfile as EquivalentProfile
from pymdr.mapping.equivalent.base import rising_root as rising_root
from pymdr.mapping.equivalent.closed import PowerLine as PowerLine
from pymdr.mapping.equivalent.closed import SphereLine as SphereLine
from pymdr.mapping.equivalent.closed import SumLine as SumLine
from pymdr.mapping.equivalent.closed import power_factor as power_factor
from pymdr.mapping.equivalent.numeric import NumericLine as NumericLine
from pymdr.mapping.equivalent.proxy import ProxyLine as ProxyLine
from pymdr.mapping.equivalent.samples import samples_of as samples_of
from pymdr.problem.profiles import (
    Cone,
    FlatPunch,
    Function,
    Interpolated,
    Paraboloid,
    PowerLaw,
    Profile,
    Sampled,
    Sphere,
    Sum,
)
from pymdr.units import FloatArray


@singledispatch
def equivalent_profile(profile: Profile) -> EquivalentProfile:
    """
    Map a profile onto the line, g(x) = x int_0^x f'(r) / sqrt(x^2 - r^2) dr.

    Parameters
    ----------
    profile : Profile
        The gap f(r).

    Returns
    -------
    EquivalentProfile
        With ``g(x)``, ``slope(x)``, ``integral(x)``, ``inverse(depth)`` and more, in SI units.

    Raises
    ------
    ProblemError
        If the profile is not known to pymdr.

    Notes
    -----
    Galin (1946), Sneddon (1965); Popov and Hess (2015), chapter 3.

    Examples
    --------
    >>> line = equivalent_profile(Paraboloid(2.0))
    >>> float(line.g(1.0))
    0.5
    """
    raise ProblemError(
        f"no map for {type(profile).__name__}; give the profile as Function(f, derivative=...)"
    )


@equivalent_profile.register
def _(profile: Sphere) -> EquivalentProfile:
    return SphereLine(profile.radius)


@equivalent_profile.register
def _(profile: Paraboloid) -> EquivalentProfile:
    return PowerLine(2.0, profile.radius, profile.radius)


@equivalent_profile.register
def _(profile: Cone) -> EquivalentProfile:
    return PowerLine(1.0, math.pi / 2.0 * profile.gradient, 1.0)


@equivalent_profile.register
def _(profile: PowerLaw) -> EquivalentProfile:
    return PowerLine(profile.exponent, power_factor(profile.exponent) * profile.height, profile.radius)


@equivalent_profile.register
def _(profile: FlatPunch) -> EquivalentProfile:
    return SumLine((), profile.radius)


@equivalent_profile.register(Function)
@equivalent_profile.register(Interpolated)
def _(profile: Function | Interpolated) -> EquivalentProfile:
    return NumericLine(profile, profile.edge, profile.reach, profile.breakpoints)


@equivalent_profile.register
def _(profile: Sampled) -> EquivalentProfile:
    return NumericLine(profile, profile.edge, profile.reach, profile.breakpoints, fixed=True)


@equivalent_profile.register
def _(profile: Sum) -> EquivalentProfile:
    parts = [equivalent_profile(part) for part in profile.parts]
    if any(isinstance(part, NumericLine) for part in parts):
        fixed = any(isinstance(part, NumericLine) and part.fixed for part in parts)
        return NumericLine(profile, profile.edge, profile.reach, profile.breakpoints, fixed=fixed)
    return SumLine(
        tuple(p for part in parts for p in (part.parts if isinstance(part, SumLine) else (part,))),
        profile.edge,
        profile.reach,
    )


def gap_function(profile: Profile, equivalent: EquivalentProfile) -> abel.Curve:
    """
    f(r) of a profile as a callable, by the inverse map where only the derivative was given.

    Parameters
    ----------
    profile : Profile
    equivalent : EquivalentProfile
        Its image on the line.

    Returns
    -------
    callable
    """
    parts = profile.parts if isinstance(profile, Sum) else (profile,)
    if all(not isinstance(part, Function) or part.f is not None for part in parts):
        return profile.gap
    edge = equivalent.edge

    def gap(r: FloatArray) -> FloatArray:
        inside = np.minimum(r, edge)
        f = abel.inverse(equivalent.g, inside, breakpoints=equivalent.breakpoints)
        return np.where(r > edge, math.inf, f)

    return gap


def has_callables(profile: Profile) -> bool:
    """
    Whether a profile holds a callable, which no file can.

    Examples
    --------
    >>> has_callables(Sphere(1.0))
    False
    """
    parts = profile.parts if isinstance(profile, Sum) else (profile,)
    return any(isinstance(part, Function) for part in parts)


def without_callables(profile: Profile, top: float) -> Profile:
    """
    The profile with every :class:`Function` replaced by its interpolant on [0, top], for saving.

    Parameters
    ----------
    profile : Profile
    top : float
        Largest radius in m that is needed.

    Returns
    -------
    Profile
    """
    if isinstance(profile, Sum):
        return Sum(tuple(without_callables(part, top) for part in profile.parts))
    if not isinstance(profile, Function):
        return profile
    top = min(top, profile.reach)
    samples = samples_of(profile, top)
    tip = chebyshev.tip_exponent(samples.slope, top, 0.0)
    if profile.derivative is None:
        # differentiated values are noise near the tip: only a pure power is believed, from larger radii
        tip = chebyshev.tip_exponent(samples.slope, 1e6 * top, 0.0)
        tip = tip if tip == round(tip) else 0.0
    slope = chebyshev.build(
        samples.slope,
        top,
        breakpoints=samples.marks,
        tip_exponent=tip,
        noise=samples.noise,
        what="f'(r)",
    )
    return Interpolated(
        tuple(slope.edges.tolist()),
        tuple(tuple(panel.coefficients.tolist()) for panel in slope.panels),
        tip,
        sum(panel.tip_exponent != 0.0 for panel in slope.panels),
        profile.breakpoints,
    )
