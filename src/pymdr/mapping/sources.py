"""Sources of f'(r) of every kind of profile, for its resolution on panels."""

from __future__ import annotations

import math
from functools import singledispatch

import numpy as np
from numpy.polynomial import chebyshev

from pymdr.errors import ProblemError
from pymdr.mapping.callables import Steps, TipLaw, check_consistency, find_kinks, polished, underflow_law
from pymdr.mapping.derived import DerivedSource, rise_of
from pymdr.mapping.resolving import KNOTS_AVERAGED, SlopeSource, radii_next_to
from pymdr.numerics.panels import TERMS, BoolArray, Panels, Place, Series, evaluate
from pymdr.problem.profiles import (
    AreaFunction,
    Function,
    Interpolated,
    Profile,
    Sampled,
    SmoothingSpline,
    Sum,
    Waviness,
    call,
    precision,
)
from pymdr.units import FloatArray, metres

_EPS = float(np.finfo(float).eps)
_ROUNDED = 8.0
"""Accepted misfit of a series, in roundings of f'."""
_CHECKED_BEYOND = 1.5
_OUTWARD = 2.0**30
_COSTLY_KNOTS = 4000
_BETWEEN = np.array([0.0, 0.25, 0.5, 0.75])
"""Positions between knots at which misfits are measured."""
MANY_KNOTS = 400
"""Samples from which on knots only count where panels do not resolve the curve across them."""


_SHORT_OF = 1.0 - 1e-9
"""Fraction of the radius at which a profile is vertical, as a sphere at its equator, up to which panels resolve
it."""


def _resolvable(profile: Profile) -> float:
    """The radius in m up to which the slope of a profile can be resolved."""
    end = profile.max_radius
    if isinstance(profile, Function) or not math.isfinite(end):
        return end
    with np.errstate(divide="ignore", invalid="ignore"):
        upright = not np.isfinite(profile.gap_slope(np.array([end]))[0])
    return _SHORT_OF * end if upright else end


class CurveSource(SlopeSource):
    """f' of a profile that gives it at any radius."""

    def __init__(self, profile: Profile) -> None:
        self.profile = profile
        self.knots = profile.breakpoints
        self.max_radius = _resolvable(profile)
        self._polished = 0.0
        self.surveyed = not isinstance(profile, Function | Waviness)
        self._checked = 0.0
        self._law: TipLaw | None = None
        given = isinstance(profile, Function) and profile.f is not None
        self._steps = Steps(self._f) if given else None

    def _f(self, r: FloatArray) -> FloatArray:
        profile = self.profile
        assert isinstance(profile, Function)
        assert profile.f is not None
        values: FloatArray = call(profile.f, r)
        return values

    def uncertainty(self, panels: Panels) -> FloatArray:
        """Error of f' on panels, from steps of f that are constants of few digits, and from numbers of few digits."""
        total = self.grain(panels) / _ROUNDED
        return (
            total
            if self._steps is None
            else total + self._steps.errors(panels.base, panels.low, panels.width)
        )

    def grain(self, panels: Panels) -> FloatArray:
        """Error of f' on panels by numbers of few digits."""
        given = self.profile.derivative if isinstance(self.profile, Function) else None
        if given is None or not panels.count or (unit := precision(given, float(panels.stop[0]))) <= _EPS:
            return np.zeros(panels.count)
        return np.asarray(_ROUNDED * unit * np.abs(self.profile.gap_slope(panels.stop)))

    def sample(self, base: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        """F' at the rounded radii, and their offsets."""
        r = radii_next_to(self.knots, base, offset)
        values = self.profile.gap_slope(r)
        below = r < self.continued
        if below.any() and self._law is not None:
            values = np.array(values)
            values[below] = self._law.slope(r[below])
        return values, r - base

    @property
    def continued(self) -> float:
        """Radius in m below which f' underflows, and is a power; 0 where it has its digits all the way."""
        return 0.0 if self._law is None else self._law.radius

    def polish(self, top: float) -> bool:
        """Move breakpoints of a callable to the neighbouring kinks of f'."""
        if not isinstance(self.profile, Function):
            return False
        slope, before = self.profile.gap_slope, self.knots
        self.knots = polished(slope, before, self.max_radius, self._polished, top)
        self._polished = max(self._polished, top)
        self.moved = self.moved | ({*self.knots} - {*before})
        return self.knots != before

    def foresee(self, top: float) -> None:
        """Refuse a derivative that is not that of f on the radii up to `top`."""
        profile = self.profile
        if self._steps is not None:
            self._steps.refuse(top, self.knots)
        if not isinstance(profile, Function) or top <= _CHECKED_BEYOND * self._checked:
            return
        self._checked = top
        if self._law is None:
            self._law = underflow_law(
                profile.gap_slope, top, min([self.max_radius, *self.knots[:1]]), "slope"
            )
        if profile.f is None:
            return
        derivative = profile.derivative
        assert derivative is not None

        def slope(r: FloatArray) -> FloatArray:
            return call(derivative, r, "derivative")

        try:
            check_consistency(self._f, slope, top / 1024.0, top, self.knots)
        except ProblemError:
            # unless it is the rounding of f that shows farther out only
            farthest = min(_OUTWARD * top, self.max_radius)
            check_consistency(self._f, slope, top / 1024.0, top, self.knots, farthest=farthest)

    def rise(self, r: float) -> tuple[float, float]:
        """F(r) - f(0) in m and its rounding; NaN where only f' is known."""
        f = self.profile.f if isinstance(self.profile, Function) else None
        return (math.nan, math.nan) if f is None else rise_of(f, r)

    def kinks(self, low: float, high: float) -> list[float]:
        """Kinks between two radii that were not named."""
        return find_kinks(self.profile.gap_slope, low, high) if isinstance(self.profile, Function) else []


_GRAIN = 8.0 * _EPS
"""Largest relative difference of roundings of neighbouring heights, and its effect on a spline."""


class SplineSource(SlopeSource):
    """f' of a piecewise cubic, whose offsets from its knots are not rounded."""

    surveyed = True

    def __init__(self, profile: Sampled) -> None:
        spline = profile.spline
        self.breaks = np.asarray(spline.x, dtype=float)
        self.coefficients = np.asarray(spline.c, dtype=float)
        inner = self.breaks[1:-1]
        many = inner.size > MANY_KNOTS
        # panels between many knots are not resolved before they are needed
        self.known_everywhere = inner.size <= _COSTLY_KNOTS
        self.heights = np.abs(self.coefficients[3] + profile.offset)
        self.knots = () if many else tuple(inner.tolist())
        if many:
            self.soft_knots = inner
        self.max_radius = float(self.breaks[-1])
        if isinstance(profile.interpolation, SmoothingSpline):
            self.fitted = f"of the fitted curve, with a misfit of {metres(profile.misfit)} (root mean square)"

    def grain(self, panels: Panels) -> FloatArray:
        """Error of f' on panels by the rounding of heights."""
        inside = np.diff(np.searchsorted(self.breaks, [panels.start, panels.stop]), axis=0)[0]
        heights = np.interp(panels.stop, self.breaks[:-1], self.heights)
        return np.asarray(_GRAIN * heights * inside / panels.width)

    def known_polynomials(self, panels: Panels) -> tuple[BoolArray, Series, FloatArray]:
        """Panels between neighbouring knots, on which f' is a parabola."""
        middle = panels.base + 0.5 * (panels.low + panels.high)
        i = np.clip(np.searchsorted(self.breaks, middle, side="right") - 1, 0, self.breaks.size - 2)
        inside = (self.breaks[i] - panels.base <= panels.low) & (
            panels.high <= self.breaks[i + 1] - panels.base
        )
        inside &= panels.base > 0.0
        panels, i = panels.take(inside), i[inside]
        third, second, first = (
            3.0 * self.coefficients[0, i],
            2.0 * self.coefficients[1, i],
            self.coefficients[2, i],
        )
        t, width = (panels.base - self.breaks[i]) + panels.low, panels.width
        # f' = a + b u + c u^2
        a, b, c = (third * t + second) * t + first, width * (second + 2.0 * third * t), third * width**2
        with np.errstate(divide="ignore", invalid="ignore"):
            top = np.where((b * c < 0.0) & (np.abs(b) < 2.0 * np.abs(c)), a - 0.25 * b * b / c, 0.0)
        size = np.max(np.abs([a, a + b + c, top]), axis=0)
        # where nothing but a flat lies before, f' keeps its digits as a power
        power = np.zeros(i.size)
        loaded = int(np.argmax(self.coefficients[:3].any(axis=0)))
        for k in np.flatnonzero(
            (panels.base == self.breaks[loaded]) & (panels.low == 0.0) & (a == 0.0)
        ).tolist():
            power[k] = 1.0 if b[k] else 2.0
            a[k], b[k], c[k] = (b[k], c[k], 0.0) if b[k] else (c[k], 0.0, 0.0)
        coefficients = np.zeros((i.size, TERMS))
        coefficients[:, :3] = np.transpose([a + 0.5 * b + 0.375 * c, 0.5 * (b + c), 0.125 * c])
        return inside, Series(power, coefficients), size

    def averaged(self, panels: Panels) -> tuple[FloatArray, FloatArray]:
        """
        Derivatives of polynomials fitted to the heights at many knots, and their error as integrals feel it, shape (P,).

        A misfit e of f' that changes its sign from knot to knot, distances h apart, and whose integral stays below p, adds to
        an integral with an inverse square root over a panel of width w no more than a constant misfit of
        e sqrt(h / w) + (p + e h) / sqrt(h w) does.
        """
        coefficients, error = super().averaged(panels)
        first, last = np.searchsorted(self.breaks, [panels.start, panels.stop])
        for i in np.flatnonzero(last - first >= KNOTS_AVERAGED).tolist():
            knots = self.breaks[first[i] : last[i]]
            step, width = np.diff(knots, prepend=knots[0]), float(panels.width[i])
            r = (knots - step * _BETWEEN[:, None]).ravel()
            z = 2.0 * (r - panels.start[i]) / width - 1.0
            heights = self.coefficients[3][first[i] : last[i]]
            basis = chebyshev.chebvander(z[: knots.size], TERMS)
            # normal equations are accurate enough for dense knots; the misfit reveals where they are not
            gram = np.einsum("ij,ik->jk", basis, basis)
            fitted = np.linalg.lstsq(gram, basis.T @ (heights - heights[0]), rcond=None)[0]
            coefficients[i] = chebyshev.chebder(fitted) * (2.0 / width)
            base = np.full(r.size, panels.base[i])
            values = self.sample(base, r - base)[0]
            misfit = float(np.max(np.abs(values - chebyshev.chebval(z, coefficients[i]))))
            gathered = float(np.ptp(heights - heights[0] - basis @ fitted))
            largest = float(step.max())
            error[i] = misfit * math.sqrt(largest / width)
            error[i] += (gathered + misfit * largest) / math.sqrt(largest * width)
        return coefficients, error

    def sample(self, base: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        """F' next to base + offset."""
        r = base + offset
        segment = np.clip(np.searchsorted(self.breaks, r, side="right") - 1, 0, self.breaks.size - 2)
        start = self.breaks[segment]
        # a base that is a knot begins its segment, however r is rounded
        own = np.clip(np.searchsorted(self.breaks, base, side="right") - 1, 0, self.breaks.size - 2)
        on_knot = (self.breaks[own] == base) & (segment == own + 1) & (r <= self.breaks[own + 1])
        segment = np.where(on_knot, own, segment)
        start = self.breaks[segment]
        t = (base - start) + offset
        third, second, first = (self.coefficients[k][segment] for k in range(3))
        values = (3.0 * third * t + 2.0 * second) * t + first
        return np.where(r > self.max_radius, math.nan, values), offset


class PanelSource(SlopeSource):
    """f' that is already known on panels, as that of a saved profile."""

    known_everywhere = True
    surveyed = True

    def __init__(self, profile: Interpolated) -> None:
        base, low, high, power = (
            np.array(getattr(profile, name)) for name in ("base", "low", "high", "power")
        )
        coefficients = np.zeros((base.size, TERMS))
        for row, given in zip(coefficients, profile.coefficients, strict=True):
            row[: len(given)] = given
        self.panels = Panels(base, low, high, np.zeros(base.shape, dtype=bool))
        self.series = Series(power, coefficients)
        self.tip = profile.tip
        self.knots = profile.kinks
        self.max_radius = profile.max_radius

    def sample(self, base: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        """F' next to base + offset."""
        index, delta = self.panels.locate(Place(base, offset))
        values = evaluate(self.panels, self.series, index, delta)
        r = base + offset
        radius, slope, exponent = self.tip
        below = r < self.panels.start[0]
        if below.any():
            with np.errstate(divide="ignore", under="ignore"):
                values[below] = slope * (r[below] / radius) ** exponent
        return np.where(r > self.max_radius * (1.0 + 1e-12), math.nan, values), offset


class SumSource(SlopeSource):
    """The sum of several slopes."""

    def __init__(self, parts: list[SlopeSource]) -> None:
        self.parts = parts
        self.knots = tuple(sorted({b for part in parts for b in part.knots}))
        self.soft_knots = np.unique(np.concatenate([part.soft_knots for part in parts]))
        self.max_radius = min(part.max_radius for part in parts)
        self.known_everywhere = all(part.known_everywhere for part in parts) and math.isfinite(
            self.max_radius
        )
        self.surveyed = all(part.surveyed for part in parts)
        self.fitted = "; ".join(part.fitted for part in parts if part.fitted)

    def sample(self, base: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        """F' at the rounded radii, and their offsets."""
        rounded = radii_next_to(self.knots, base, offset) - base
        return np.asarray(sum(part.sample(base, rounded)[0] for part in self.parts)), rounded

    @property
    def continued(self) -> float:
        """The largest radius in m below which a law stands for a part."""
        return max(part.continued for part in self.parts)

    def polish(self, top: float) -> bool:
        """Those of the parts."""
        # each of them, whichever moves
        moving = [part.polish(top) for part in self.parts]
        if not any(moving):
            return False
        self.knots = tuple(sorted({b for part in self.parts for b in part.knots}))
        self.moved = {b for part in self.parts for b in part.moved}
        return True

    def foresee(self, top: float) -> None:
        """Pass the largest radius on to the parts."""
        for part in self.parts:
            part.foresee(top)

    def rough(self, r: FloatArray) -> FloatArray:
        """Approximate f' at radii in m; parts may cancel."""
        return np.asarray(sum(part.rough(r) for part in self.parts))

    def uncertainty(self, panels: Panels) -> FloatArray:
        """Those of the parts together."""
        return np.asarray(sum(part.uncertainty(panels) for part in self.parts))

    def grain(self, panels: Panels) -> FloatArray:
        """Those of the parts together."""
        return np.asarray(sum(part.grain(panels) for part in self.parts))

    def rounding(self, r: float) -> float:
        """Those of the parts together."""
        return sum(part.rounding(r) for part in self.parts)

    def rise(self, r: float) -> tuple[float, float]:
        """Those of the parts together."""
        rises, rounded = zip(*(part.rise(r) for part in self.parts), strict=True)
        return sum(rises), sum(rounded)

    def kinks(self, low: float, high: float) -> list[float]:
        """Those of the parts."""
        return sorted({b for part in self.parts for b in part.kinks(low, high)})


@singledispatch
def source_of(profile: Profile) -> SlopeSource:
    """F' of a profile, to be resolved."""
    return CurveSource(profile)


@source_of.register
def _(profile: Interpolated) -> SlopeSource:
    return PanelSource(profile)


@source_of.register
def _(profile: Sampled) -> SlopeSource:
    return SplineSource(profile)


@source_of.register
def _(profile: AreaFunction) -> SlopeSource:
    return CurveSource(profile) if profile.sampled is None else SplineSource(profile.sampled)


@source_of.register
def _(profile: Function) -> SlopeSource:
    return DerivedSource(profile) if profile.derivative is None else CurveSource(profile)


@source_of.register
def _(profile: Sum) -> SlopeSource:
    return SumSource([source_of(part) for part in profile.parts])
