"""f'(r) and g(x) of any profile at given points: what interpolants are built from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from pymdr.errors import ProblemError
from pymdr.mapping import abel, chebyshev
from pymdr.mapping.spline import spline_map
from pymdr.problem.profiles import Function, Interpolated, Profile, Sampled, Sum, call
from pymdr.units import FloatArray, metres

_INTERPOLATION_NOISE = 3e-14
"""Rounding noise of a differentiated interpolant, relative to the steepest slope."""
_TIP_NODES, _TIP_TERMS = 64, 18


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
    noise: Callable[[float], float]
    """Rounding noise of f' up to a radius."""


_SPLINE_NOISE = 4e-16
"""Of the terms of the map of a spline: what their sum rounds."""


def _by_quadrature(slope: abel.Curve, marks: tuple[float, ...], noise: float) -> Samples:
    return Samples(
        slope,
        lambda x: abel.forward(slope, x, breakpoints=marks, noise=noise),
        lambda x: abel.moment(slope, x, breakpoints=marks, noise=noise),
        marks,
        lambda r: noise,
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
        # second moments about the middle of a piece next to x cancel by (x / width)^2 sqrt(width / x)
        width = np.diff(spline.x)
        inside = spline.x[:-1, None] + width[:, None] * np.arange(5.0) / 4.0
        terms = np.max(np.abs(profile.gap_slope(inside)), axis=1) * (
            16.0 + 2.0 * (spline.x[1:] / width) ** 1.5
        )
        rounding = _SPLINE_NOISE * np.maximum.accumulate(terms)
        return Samples(
            profile.gap_slope,
            lambda x: spline_map(spline.x, spline.c, x),
            None,
            profile.breakpoints,
            lambda r: float(rounding[np.searchsorted(spline.x[1:-1], r)]),
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
        lambda r: max(part.noise(r) for part in parts),
    )


def _differentiated(profile: Function, top: float) -> Samples:
    _refuse_jumps(profile)
    f = profile.f
    assert f is not None
    offset = profile.offset

    def gap(r: FloatArray) -> FloatArray:
        return call(f, r) - offset

    size = float(np.max(np.abs(call(f, np.array([0.5, 1.0]) * top))))
    noise = max(4e-16 * size, 2.0 * _rounding(gap, top))
    curve, exponent = _with_tip(gap, min((top, *profile.breakpoints)), noise)
    interpolant = chebyshev.build(
        curve,
        top,
        breakpoints=profile.breakpoints,
        tip_exponent=exponent,
        # panels by the tip are divided by the power, on at most the 4 times smaller radii that they do not share
        noise=lambda r: noise * 4.0**exponent,
        what="f(r)",
    )
    steepest = float(np.max(np.abs(interpolant.slope(interpolant.nodes))))
    marks = tuple(sorted({*interpolant.edges[1:-1].tolist(), *profile.breakpoints}))
    return _by_quadrature(interpolant.slope, marks, _INTERPOLATION_NOISE * steepest)


def _rounding(curve: abel.Curve, top: float) -> float:
    """Absolute rounding noise of a callable: its scatter about smooth pieces that are short to any profile."""
    away = np.linspace(-1.0, 1.0, 33)
    r = top * np.array([1e-3, 0.03, 0.1, 0.3, 0.5, 0.7, 0.9])
    values = curve((r[:, None] * (1.0 + 1e-4 * away)).ravel()).reshape(r.size, away.size)
    smooth = np.polynomial.chebyshev.chebfit(away, values.T, 7)
    scatter = np.abs(values - np.polynomial.chebyshev.chebval(away, smooth))
    return float(np.median(np.max(scatter, axis=1)))


def _with_tip(curve: abel.Curve, top: float, noise: float) -> tuple[abel.Curve, float]:
    """
    A callable with all its digits next to the tip, and the exponent with which it starts; 0 where there is none.

    sqrt(R^2 + r^2) - R and the like are rounding there; whole powers that fit farther out take its place.
    """
    exponent = chebyshev.tip_exponent(curve, top, 0.0)
    if exponent > 0.0:
        r = top * np.array([1e-9, 1e-8, 1e-7])
        ratio = curve(r) / (r / top) ** exponent
        if np.ptp(ratio) <= 1e-12 * np.abs(ratio).min():
            return curve, exponent
    for power in (4, 3, 2, 1):
        for upto in top * 0.5 ** np.arange(8.0):
            series = _series(curve, upto, power, noise)
            if series is not None:
                return _joined(curve, upto, power, series), float(power)
    return curve, 0.0


def _series(curve: abel.Curve, upto: float, power: int, noise: float) -> FloatArray | None:
    """Chebyshev coefficients q with curve = t^power q(2 t - 1), t = r / upto, if they fit within the noise."""
    basis, inverse = _tip_basis(power)
    values = curve(upto * chebyshev.nodes(_TIP_NODES))
    if not 2.0 * noise < 1e-10 * np.max(np.abs(values)):
        return None
    series: FloatArray = inverse @ values
    return series if np.max(np.abs(basis @ series - values)) <= 2.0 * noise else None


@cache
def _tip_basis(power: int) -> tuple[FloatArray, FloatArray]:
    """Values of t^power T_k(2 t - 1) at the nodes, and their least-squares inverse."""
    t = chebyshev.nodes(_TIP_NODES)
    basis = t[:, None] ** power * np.polynomial.chebyshev.chebvander(2.0 * t - 1.0, _TIP_TERMS - 1)
    return basis, np.asarray(np.linalg.pinv(basis), dtype=np.float64)


def _joined(curve: abel.Curve, upto: float, power: int, series: FloatArray) -> abel.Curve:
    def joined(r: FloatArray) -> FloatArray:
        t = r / upto
        inside = np.minimum(t, 1.0)
        tip = inside**power * np.polynomial.chebyshev.chebval(2.0 * inside - 1.0, series)
        return np.where(t < 1.0, tip, curve(r))

    return joined


def _refuse_jumps(profile: Function) -> None:
    assert profile.f is not None
    for b in profile.breakpoints:
        left, right = call(profile.f, b * np.array([1.0 - 1e-12, 1.0 + 1e-12]))
        around = call(profile.f, b * np.array([0.5, 1.0, 1.5, 2.0])) - profile.offset
        size = float(np.max(np.abs(around[np.isfinite(around)]), initial=0.0))
        if abs(right - left) > 1e-6 * size:
            raise ProblemError(
                f"the profile jumps by {metres(right - left)} at r = {metres(b)}: a step is not a disk contact; "
                "use FlatPunch for a sharp edge"
            )
