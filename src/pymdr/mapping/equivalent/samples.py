"""f'(r) and g(x) of any profile at given points: what interpolants are built from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymdr.errors import ProblemError
from pymdr.mapping import abel, chebyshev
from pymdr.mapping.spline import spline_map
from pymdr.problem.profiles import Function, Interpolated, Profile, Sampled, Sum, call

_INTERPOLATION_NOISE = 3e-14
"""Rounding noise of a differentiated interpolant, relative to the steepest slope."""


@dataclass(frozen=True)
class Samples:
    """A profile on an interval: f'(r) where it is smooth, g(x), and their rounding noise."""

    slope: abel.Curve
    """f'(r)."""
    g: abel.Curve
    """Equivalent profile in m."""
    moment: abel.Curve | None
    """First moment int t g' dt in m^2, where it can be had without g'."""
    marks: tuple[float, ...]
    """Radii at which f' is not smooth."""
    noise: float
    """Rounding noise of f'."""


def _by_quadrature(slope: abel.Curve, marks: tuple[float, ...], noise: float) -> Samples:
    return Samples(
        slope,
        lambda x: abel.forward(slope, x, breakpoints=marks, noise=noise),
        lambda x: abel.moment(slope, x, breakpoints=marks, noise=noise),
        marks,
        noise,
    )


def samples_of(profile: Profile, top: float) -> Samples:
    """
    f'(r) and g(x) on [0, top].

    A function given without its derivative is interpolated and the interpolant differentiated; samples
    are mapped piece by piece in closed form.
    """
    if isinstance(profile, Sum):
        return _sum_of([samples_of(part, top) for part in profile.parts])
    if isinstance(profile, Sampled):
        spline = profile.spline
        return Samples(
            profile.gap_slope, lambda x: spline_map(spline.x, spline.c, x), None, profile.breakpoints, 0.0
        )
    if isinstance(profile, Function) and profile.derivative is None:
        return _differentiated(profile, top)
    pieces = profile.edges[1:-1] if isinstance(profile, Interpolated) else profile.breakpoints
    marks = tuple(b for b in pieces if b < top)
    steepest = float(np.max(np.abs(profile.gap_slope(np.array([0.25, 0.5, 1.0]) * top))))
    if isinstance(profile, Interpolated):
        return _by_quadrature(profile.gap_slope, marks, _INTERPOLATION_NOISE * steepest)
    # next to a kink the distance r - b is rounded, and the slope with it
    return _by_quadrature(profile.gap_slope, marks, 2e-15 * steepest if marks else 0.0)


def _sum_of(parts: list[Samples]) -> Samples:
    moments = [part.moment for part in parts if part.moment is not None]
    return Samples(
        lambda r: np.asarray(sum(part.slope(r) for part in parts)),
        lambda x: np.asarray(sum(part.g(x) for part in parts)),
        (lambda x: np.asarray(sum(moment(x) for moment in moments))) if len(moments) == len(parts) else None,
        tuple(sorted({b for part in parts for b in part.marks})),
        max(part.noise for part in parts),
    )


def _differentiated(profile: Function, top: float) -> Samples:
    _refuse_jumps(profile)
    f = profile.f
    assert f is not None
    offset = profile.offset
    size = float(np.max(np.abs(call(f, np.array([0.5, 1.0]) * top))))
    interpolant = chebyshev.build(
        lambda r: call(f, r) - offset,
        top,
        breakpoints=profile.breakpoints,
        noise=lambda r: 4e-16 * size,
        what="f(r)",
    )
    steepest = float(np.max(np.abs(interpolant.slope(interpolant.nodes))))
    marks = tuple(sorted({*interpolant.edges[1:-1].tolist(), *profile.breakpoints}))
    return _by_quadrature(interpolant.slope, marks, _INTERPOLATION_NOISE * steepest)


def _refuse_jumps(profile: Function) -> None:
    assert profile.f is not None
    for b in profile.breakpoints:
        left, right = call(profile.f, b * np.array([1.0 - 1e-12, 1.0 + 1e-12]))
        around = call(profile.f, b * np.array([0.5, 1.0, 1.5, 2.0])) - profile.offset
        size = float(np.max(np.abs(around[np.isfinite(around)]), initial=0.0))
        if abs(right - left) > 1e-6 * size:
            raise ProblemError(
                f"the profile jumps by {right - left:g} m at r = {b:g} m: a step is not a disk contact; "
                "use FlatPunch for a sharp edge"
            )
