"""The equivalent profile g(x) of a profile f(r): closed forms where they exist, a proxy elsewhere.

Every form offers g, its slope, its integral, its first moment int t g' dt (half the force over E*), the
integral of (g(x) - g(t))^2 (the energy over E*), the inverses of g and of the moment, and the pressure
integral int_r^a g' / sqrt(x^2 - r^2) dx.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import singledispatch
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import gammaln

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.mapping import abel, chebyshev
from pymdr.mapping.abel import gauss
from pymdr.problem.profiles import (
    Cone,
    FlatPunch,
    Function,
    Interpolated,
    Paraboloid,
    PowerLaw,
    Profile,
    Sphere,
    Sum,
    call,
)
from pymdr.units import FloatArray


class EquivalentProfile(ABC):
    """The profile on the line. All arguments and values are SI floats or arrays of them."""

    edge: float = math.inf
    """Sharp edge in m that no contact passes."""
    reach: float = math.inf
    """Largest x in m at which g is known."""
    breakpoints: tuple[float, ...] = ()
    """Points in m to whose right g is not smooth."""
    rises: bool = True
    """Whether g is known to rise everywhere, so that every contact is a disk."""

    @abstractmethod
    def g(self, x: ArrayLike) -> FloatArray:
        """Equivalent profile g(x) in m."""

    @abstractmethod
    def slope(self, x: ArrayLike) -> FloatArray:
        """Slope g'(x)."""

    @abstractmethod
    def moment(self, x: ArrayLike) -> FloatArray:
        """First moment int_0^x t g'(t) dt in m^2."""

    @abstractmethod
    def squared(self, x: ArrayLike) -> FloatArray:
        """The integral int_0^x (g(x) - g(t))^2 dt in m^3."""

    @abstractmethod
    def inverse(self, depth: ArrayLike) -> FloatArray:
        """The x in m at which g(x) = depth, for rising g; inf where g never gets there."""

    @abstractmethod
    def inverse_moment(self, moment: ArrayLike) -> FloatArray:
        """The x in m at which the first moment has the given value, for rising g."""

    def integral(self, x: ArrayLike) -> FloatArray:
        """The integral int_0^x g(t) dt in m^2."""
        return np.asarray(x, dtype=float) * self.g(x) - self.moment(x)

    def pressure_integral(self, r: ArrayLike, a: float) -> FloatArray:
        """The integral int_r^a g'(x) / sqrt(x^2 - r^2) dx."""
        return abel.edge_average(self.slope, r, a, breakpoints=self.breakpoints)

    def upto(self, top: float) -> EquivalentProfile:
        """The same profile made fast on [0, top]."""
        return self


def power_factor(n: float) -> float:
    """
    The factor kappa(n) = sqrt(pi) Gamma(n/2 + 1) / Gamma((n + 1)/2) of r^n -> kappa x^n (Hess 2011).

    Examples
    --------
    >>> round(power_factor(2), 14)
    2.0
    """
    return math.sqrt(math.pi) * math.exp(gammaln(n / 2.0 + 1.0) - gammaln((n + 1.0) / 2.0))


@dataclass(frozen=True)
class PowerLine(EquivalentProfile):
    """g = scale (x / unit)^n, the image of a power law; `unit` keeps the numbers near 1."""

    n: float
    scale: float
    unit: float

    def g(self, x: ArrayLike) -> FloatArray:
        """Equivalent profile in m."""
        return np.asarray(self.scale * self._power(np.asarray(x, dtype=float) / self.unit, self.n))

    def slope(self, x: ArrayLike) -> FloatArray:
        """Slope g'."""
        with np.errstate(divide="ignore"):
            relative = self._power(np.asarray(x, dtype=float) / self.unit, self.n - 1.0)
        return np.asarray(self.n * (self.scale / self.unit) * relative)

    def moment(self, x: ArrayLike) -> FloatArray:
        """First moment, n/(n+1) x g."""
        return np.asarray(self.n / (self.n + 1.0) * np.asarray(x, dtype=float) * self.g(x))

    def squared(self, x: ArrayLike) -> FloatArray:
        """Integral of (g(x) - g)^2, 2 n^2 / ((n+1)(2n+1)) x g^2."""
        n = self.n
        return np.asarray(
            2.0 * n * n / ((n + 1.0) * (2.0 * n + 1.0)) * np.asarray(x, dtype=float) * self.g(x) ** 2
        )

    def inverse(self, depth: ArrayLike) -> FloatArray:
        """Inverse of g."""
        relative = np.maximum(np.asarray(depth, dtype=float), 0.0) / self.scale
        return np.asarray(self.unit * self._power(relative, 1.0 / self.n))

    def inverse_moment(self, moment: ArrayLike) -> FloatArray:
        """Inverse of the first moment."""
        factor = self.n / (self.n + 1.0) * self.scale * self.unit
        relative = np.maximum(np.asarray(moment, dtype=float), 0.0) / factor
        return np.asarray(self.unit * self._power(relative, 1.0 / (self.n + 1.0)))

    def pressure_integral(self, r: ArrayLike, a: float) -> FloatArray:
        """Closed for the cone and the paraboloid, by quadrature otherwise."""
        r = np.asarray(r, dtype=float)
        inside = np.minimum(r, a)
        half_chord = np.sqrt((a - inside) * (a + inside))
        if self.n == 2.0:
            return np.asarray(2.0 * (self.scale / self.unit) * (half_chord / self.unit))
        if self.n == 1.0:
            with np.errstate(divide="ignore"):
                return np.asarray((self.scale / self.unit) * np.arcsinh(half_chord / inside))
        return super().pressure_integral(r, a)

    @staticmethod
    def _power(x: FloatArray, n: float) -> FloatArray:
        if n == 0.5:
            return np.asarray(np.sqrt(x))
        if n == 1.0:
            return x
        if n == 2.0:
            return np.asarray(x * x)
        return np.asarray(np.cbrt(x) if n == 1.0 / 3.0 else x**n)


_SPHERE_TERMS = np.arange(1.0, 31.0)
_SPHERE_MOMENT = 2.0 * _SPHERE_TERMS / (4.0 * _SPHERE_TERMS**2 - 1.0)


@dataclass(frozen=True)
class SphereLine(EquivalentProfile):
    """g = x artanh(x / R), the image of the true sphere."""

    radius: float

    @property
    def reach(self) -> float:  # type: ignore[override]
        """The sphere ends at R."""
        return self.radius

    def g(self, x: ArrayLike) -> FloatArray:
        """Equivalent profile in m; inf at R, nan beyond."""
        x = np.asarray(x, dtype=float)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(x * np.arctanh(x / self.radius))

    def slope(self, x: ArrayLike) -> FloatArray:
        """Slope g' = artanh t + t / (1 - t^2)."""
        t = np.asarray(x, dtype=float) / self.radius
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.arctanh(t) + t / ((1.0 - t) * (1.0 + t)))

    def moment(self, x: ArrayLike) -> FloatArray:
        """First moment R^2/2 [(1 + t^2) artanh t - t], as a series below t = 1/2."""
        t = np.asarray(x, dtype=float) / self.radius
        small = np.minimum(np.abs(t), 0.5)
        series = small**3 * np.polynomial.polynomial.polyval(small**2, _SPHERE_MOMENT)
        with np.errstate(divide="ignore", invalid="ignore"):
            closed = ((1.0 + t * t) * np.arctanh(t) - t) / 2.0
        return np.asarray(self.radius**2 * np.where(np.abs(t) < 0.5, series, closed))

    def squared(self, x: ArrayLike) -> FloatArray:
        """Integral of (g(x) - g)^2 by Gauss-Legendre in s, t = tanh(s), where g = R s tanh(s)."""
        x = np.asarray(x, dtype=float)
        top = np.arctanh(np.ravel(x) / self.radius)
        answer = np.zeros(top.shape)
        nodes, weights = gauss(32)
        depth = top * np.tanh(top)
        for node, weight in zip(nodes, weights, strict=True):
            s = top * node
            tanh = np.tanh(s)
            answer += weight * (depth - s * tanh) ** 2 * (1.0 - tanh) * (1.0 + tanh)
        return np.asarray((self.radius**3 * top * answer).reshape(x.shape))

    def inverse(self, depth: ArrayLike) -> FloatArray:
        """Inverse of g by Newton's method on s tanh(s) = depth / R."""
        y = np.maximum(np.asarray(depth, dtype=float), 0.0) / self.radius
        s = np.sqrt(y) * np.sqrt(1.0 + y)
        for _ in range(60):
            tanh = np.tanh(s)
            with np.errstate(invalid="ignore", divide="ignore"):
                step = (s * tanh - y) / (tanh + s * (1.0 - tanh) * (1.0 + tanh))
            step = np.where(s > 0.0, step, 0.0)
            s = s - step
            if np.all(np.abs(step) <= 4e-16 * s):
                return np.asarray(self.radius * np.tanh(s))
        bad = np.abs(step) > 4e-15 * s
        if bad.any():
            raise ConvergenceError(
                f"sphere: no contact radius for d/R = {y[bad][0]:g}; last s = {s[bad][0]:g}"
            )
        return np.asarray(self.radius * np.tanh(s))

    def inverse_moment(self, moment: ArrayLike) -> FloatArray:
        """Inverse of the first moment by bracketing."""
        target = np.maximum(np.asarray(moment, dtype=float), 0.0)
        hertz = np.cbrt(1.5 * target * self.radius)
        low = np.minimum(hertz * 0.5, self.radius * 0.5)
        return rising_root(self.moment, target, low, np.minimum(hertz, self.radius * (1.0 - 1e-15)))


@dataclass(frozen=True)
class SumLine(EquivalentProfile):
    """The sum of closed forms, cut at a sharp edge; without parts it is the flat punch."""

    parts: tuple[EquivalentProfile, ...]
    edge: float = math.inf
    reach: float = math.inf

    def g(self, x: ArrayLike) -> FloatArray:
        """Equivalent profile in m."""
        return sum((part.g(x) for part in self.parts), np.zeros(np.shape(x)))

    def slope(self, x: ArrayLike) -> FloatArray:
        """Slope g'."""
        return sum((part.slope(x) for part in self.parts), np.zeros(np.shape(x)))

    def moment(self, x: ArrayLike) -> FloatArray:
        """First moment."""
        return sum((part.moment(x) for part in self.parts), np.zeros(np.shape(x)))

    def squared(self, x: ArrayLike) -> FloatArray:
        """Integral of (g(x) - g)^2 by Gauss-Legendre on panels graded to 0."""
        if len(self.parts) <= 1:
            return self.parts[0].squared(x) if self.parts else np.zeros(np.shape(x))
        x = np.asarray(x, dtype=float)
        depth, answer = self.g(x), np.zeros(x.shape)
        nodes, weights = gauss(24)
        for low, high in pairwise((0.0, *0.25 ** np.arange(13.0, -1.0, -1.0))):
            for s, w in zip(low + (high - low) * nodes, (high - low) * weights, strict=True):
                answer += w * (depth - self.g(s * x)) ** 2
        return np.asarray(x * answer)

    def inverse(self, depth: ArrayLike) -> FloatArray:
        """Inverse of g, bracketed by the inverses of the parts."""
        return self._inverse(depth, self.g, [part.inverse for part in self.parts])

    def inverse_moment(self, moment: ArrayLike) -> FloatArray:
        """Inverse of the first moment, bracketed by those of the parts."""
        return self._inverse(moment, self.moment, [part.inverse_moment for part in self.parts])

    def _inverse(
        self,
        values: ArrayLike,
        curve: Callable[[FloatArray], FloatArray],
        inverses: list[Callable[[FloatArray], FloatArray]],
    ) -> FloatArray:
        target = np.maximum(np.asarray(values, dtype=float), 0.0)
        if not inverses:
            return np.where(target > 0.0, math.inf, 0.0)
        if len(inverses) == 1:
            return inverses[0](target)
        high = np.min([inverse(target) for inverse in inverses], axis=0)
        low = np.min([inverse(target / len(inverses)) for inverse in inverses], axis=0)
        return rising_root(curve, target, low, high)

    def pressure_integral(self, r: ArrayLike, a: float) -> FloatArray:
        """Sum of the parts' integrals."""
        return sum((part.pressure_integral(r, a) for part in self.parts), np.zeros(np.shape(r)))


def rising_root(
    curve: Callable[[FloatArray], FloatArray], target: ArrayLike, low: ArrayLike, high: ArrayLike
) -> FloatArray:
    """
    Solve curve(x) = target for a rising curve inside a bracket, for arrays, to rounding error.

    Parameters
    ----------
    curve : callable
        Rising, on arrays.
    target, low, high : array_like
        Values and brackets, broadcast together.

    Returns
    -------
    ndarray

    Raises
    ------
    ConvergenceError
        If a root is not inside its bracket.

    Notes
    -----
    Chandrupatla (1997), from ``scipy.optimize.elementwise``; its tolerance is relative to the root, so a
    nanometre is found as exactly as a metre.

    Examples
    --------
    >>> float(rising_root(lambda x: x**2, 2.0, 1.0, 2.0))
    1.4142135623730951
    """
    from scipy.optimize import elementwise

    y, start, stop = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (target, low, high)))
    below, above = curve(start) - y, curve(stop) - y
    answer = np.where(np.abs(below) <= np.abs(above), start, stop)
    open_ = (below < 0.0) & (above > 0.0)
    missed = ~open_ & ~(np.minimum(np.abs(below), np.abs(above)) <= 1e-12 * np.abs(y))
    if missed.any():
        raise ConvergenceError(
            f"no root between {start[missed][0]:g} and {stop[missed][0]:g} for {y[missed][0]:g}"
        )
    if open_.any():
        found = elementwise.find_root(
            lambda x, y: curve(x) - y, (start[open_], stop[open_]), args=(y[open_],)
        )
        if not np.all(found.success):
            raise ConvergenceError(f"root search stopped at {found.x[~found.success][0]:g}")
        answer[open_] = found.x
    return answer


@dataclass(frozen=True, kw_only=True)
class ProxyLine(EquivalentProfile):
    """g, its moment and its square integral as piecewise Chebyshev interpolants on [0, reach]."""

    curve: chebyshev.Piecewise
    first_moment: chebyshev.Piecewise
    square: chebyshev.Piecewise
    breakpoints: tuple[float, ...]
    edge: float
    reach: float
    rises: bool
    turning_points: tuple[float, ...]
    """Points in m where g' changes its sign."""

    def g(self, x: ArrayLike) -> FloatArray:
        """Equivalent profile in m; nan beyond the reach."""
        return self._known(x, self.curve.value)

    def slope(self, x: ArrayLike) -> FloatArray:
        """Slope g'."""
        return self._known(x, self.curve.slope)

    def moment(self, x: ArrayLike) -> FloatArray:
        """First moment."""
        return self._known(x, self.first_moment.value)

    def squared(self, x: ArrayLike) -> FloatArray:
        """Integral of (g(x) - g)^2."""
        return self._known(x, self.square.value)

    def _known(self, x: ArrayLike, evaluate: Callable[[FloatArray], FloatArray]) -> FloatArray:
        x = np.asarray(x, dtype=float)
        with np.errstate(invalid="ignore"):
            values = evaluate(x)
        beyond = x > self.reach * (1.0 + 1e-12)
        return np.where(beyond, math.nan, values) if beyond.any() else values

    def inverse(self, depth: ArrayLike) -> FloatArray:
        """Inverse of a rising g; inf above g(reach)."""
        return self._inverse(depth, self.g)

    def inverse_moment(self, moment: ArrayLike) -> FloatArray:
        """Inverse of the rising first moment; inf above its last value."""
        return self._inverse(moment, self.moment)

    def _inverse(self, target: ArrayLike, curve: Callable[[FloatArray], FloatArray]) -> FloatArray:
        target = np.asarray(target, dtype=float)
        x = np.array([0.0, *self.curve.nodes, self.reach])
        table = np.maximum.accumulate(curve(x))
        index = np.clip(np.searchsorted(table, target, side="left"), 1, x.size - 1)
        beyond = target > table[-1]
        inside = (target > 0.0) & ~beyond
        answer = np.where(beyond, math.inf, 0.0)
        if inside.any():
            i = index[inside]
            answer[inside] = rising_root(curve, target[inside], x[i - 1], x[i])
        return answer


@dataclass(frozen=True)
class NumericLine(EquivalentProfile):
    """The image of a profile with a callable in it: mapped by quadrature when it is asked."""

    profile: Profile
    edge: float = math.inf
    reach: float = math.inf
    breakpoints: tuple[float, ...] = ()
    rises: bool = field(default=False, init=False)

    def g(self, x: ArrayLike) -> FloatArray:
        """Equivalent profile in m."""
        return self._interpolant(self._top(x))[0].value(x)

    def slope(self, x: ArrayLike) -> FloatArray:
        """Slope g'."""
        return self._interpolant(self._top(x))[0].slope(x)

    def moment(self, x: ArrayLike) -> FloatArray:
        """First moment."""
        return self.upto(self._top(x)).moment(x)

    def squared(self, x: ArrayLike) -> FloatArray:
        """Integral of (g(x) - g)^2."""
        return self.upto(self._top(x)).squared(x)

    def inverse(self, depth: ArrayLike) -> FloatArray:
        """Inverse of g, searched from small radii upward."""
        return self._grown(depth, "g").inverse(depth)

    def inverse_moment(self, moment: ArrayLike) -> FloatArray:
        """Inverse of the first moment."""
        return self._grown(moment, "moment").inverse_moment(moment)

    def _top(self, x: ArrayLike) -> float:
        largest = float(np.max(np.abs(x), initial=0.0))
        return largest if largest > 0.0 else 1.0

    def _grown(self, target: ArrayLike, name: str) -> EquivalentProfile:
        return self.upto(self.top_for(float(np.max(target, initial=0.0)), name))

    def top_for(self, target: float, name: str = "g") -> float:
        """A radius in m at which g (or the moment) is above a value, by at most 20 % in radius."""
        limit = min(self.edge, self.reach)

        def value(x: float) -> float:
            """The curve at x; nan where it is not defined."""
            try:
                return float(getattr(slope_samples(self.profile, x), name)(np.array([x]))[0])
            except ConvergenceError:
                return math.nan

        low = min(1.0, limit)
        while low > 1e-250 and not value(low) <= target:
            low /= 8.0
        high = low
        while value(high) <= target:
            if high >= limit:
                return limit
            if high > 1e250:
                raise ProblemError(
                    f"the profile never rises to {target:g}: a contact without an edge has no end; add "
                    "FlatPunch(radius) for a cylinder of that end shape"
                )
            low, high = high, min(2.0 * high, limit)
        for _ in range(60):
            if high < 1.2 * low and math.isfinite(value(high)):
                return high
            middle = math.sqrt(low * high)
            low, high = (middle, high) if value(middle) <= target else (low, middle)
        raise ConvergenceError(
            f"g(x) rises to {target:g} only where it cannot be resolved, at {high:g} m; "
            "Function(..., reach=...) states how far the profile is defined"
        )

    def upto(self, top: float) -> ProxyLine:
        """Interpolants of g and its integrals on [0, top]."""
        top = min(top, self.edge, self.reach)
        curve, samples = self._interpolant(top)
        exponent = curve.panels[0].tip_exponent
        return proxy_line(curve, samples.moment, exponent, self.breakpoints, self.edge, top)

    def _interpolant(self, top: float) -> tuple[chebyshev.Piecewise, SlopeSamples]:
        samples = slope_samples(self.profile, top)
        curve = chebyshev.build(
            samples.g,
            top,
            breakpoints=self.breakpoints,
            rooted=True,
            tip_exponent=1.0 + chebyshev.tip_exponent(samples.slope, top, 0.0),
            noise=lambda x: samples.noise * x,
            what="g(x)",
        )
        return curve, samples


@dataclass(frozen=True)
class SlopeSamples:
    """f'(r) on an interval, the radii at which it is not smooth, and its rounding noise."""

    slope: abel.Curve
    marks: tuple[float, ...]
    noise: float = 0.0

    def g(self, x: FloatArray) -> FloatArray:
        """Equivalent profile by quadrature."""
        return abel.forward(self.slope, x, breakpoints=self.marks, noise=self.noise)

    def moment(self, x: FloatArray) -> FloatArray:
        """First moment by quadrature."""
        return abel.moment(self.slope, x, breakpoints=self.marks, noise=self.noise)


def proxy_line(
    curve: chebyshev.Piecewise,
    moment: abel.Curve,
    exponent: float,
    breakpoints: tuple[float, ...],
    edge: float,
    top: float,
) -> ProxyLine:
    """A :class:`ProxyLine` from an interpolant of g and samples of its first moment."""
    first_moment = curve.resample(lambda x, _: moment(x), exponent + 1.0)
    square = _square_integral(curve, first_moment, exponent)
    turning = _turning_points(curve)
    flat = tuple(b for b in breakpoints if b < top)
    return ProxyLine(
        curve=curve,
        first_moment=first_moment,
        square=square,
        breakpoints=flat,
        edge=edge,
        reach=top,
        rises=not turning,
        turning_points=turning,
    )


def _square_integral(
    curve: chebyshev.Piecewise, moment: chebyshev.Piecewise, exponent: float
) -> chebyshev.Piecewise:
    """The integral of (g(x) - g)^2 as int 2 g' m dt, which has no subtraction in it."""
    below = {0.0: 0.0}

    def sample(x: FloatArray, panel: chebyshev.Panel) -> FloatArray:
        index = next(i for i, p in enumerate(curve.panels) if p.low == panel.low)
        g, m = curve.panels[index], moment.panels[index]

        def upto(x: FloatArray) -> FloatArray:
            if panel.low == 0.0:
                s, w = gauss(x.size + 8, 2.0 * exponent)
                t = x[:, None] * s
                return x * ((2.0 * g.slope(t) * m.value(t) / s ** (2.0 * exponent)) @ w)
            width = panel.high - panel.low
            root = ((x - panel.low) / width) ** (1.0 / panel.power)
            s, w = gauss(x.size + 8)
            u = root[:, None] * s
            t = panel.low + width * u**panel.power
            stretch = width * panel.power * u ** (panel.power - 1)
            return root * ((2.0 * g.slope(t) * stretch * m.value(t)) @ w)

        below[panel.high] = below[panel.low] + float(upto(np.array([panel.high]))[0])
        return below[panel.low] + upto(x)

    return curve.resample(sample, 2.0 * exponent + 1.0)


def _turning_points(curve: chebyshev.Piecewise) -> tuple[float, ...]:
    """Points where g' changes sign, ignoring rounding noise."""
    from_panels = [
        panel.low
        + (panel.high - panel.low) * np.linspace(1e-3, 1.0, 8 * panel.coefficients.size) ** panel.power
        for panel in curve.panels
    ]
    x = np.concatenate(from_panels)
    slope = curve.slope(x)
    steepness = slope * x
    noise = 1e-11 * float(np.max(np.abs(steepness), initial=0.0))
    sure = np.abs(steepness) > noise
    x, slope = x[sure], slope[sure]
    if x.size == 0:
        return ()
    found = [0.0] if slope[0] < 0.0 else []
    for i in np.flatnonzero(np.sign(slope[1:]) != np.sign(slope[:-1])):
        low, high = x[i], x[i + 1]
        for _ in range(80):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            same = np.sign(float(curve.slope(np.array([middle]))[0])) == np.sign(slope[i])
            low, high = (middle, high) if same else (low, middle)
        found.append(0.5 * (low + high))
    return tuple(found)


_INTERPOLATION_NOISE = 3e-14
"""Rounding noise of a differentiated interpolant, relative to the steepest slope."""


def slope_samples(profile: Profile, top: float) -> SlopeSamples:
    """
    f'(r) on [0, top], ready to be mapped.

    A function given without its derivative is interpolated and the interpolant differentiated.
    """
    if isinstance(profile, Sum):
        parts = [slope_samples(part, top) for part in profile.parts]
        return SlopeSamples(
            lambda r: np.asarray(sum(part.slope(r) for part in parts)),
            tuple(sorted({b for part in parts for b in part.marks})),
            max(part.noise for part in parts),
        )
    if not isinstance(profile, Function) or profile.derivative is not None:
        pieces = profile.edges[1:-1] if isinstance(profile, Interpolated) else profile.breakpoints
        marks = tuple(b for b in pieces if b < top)
        steepest = float(np.max(np.abs(profile.gap_slope(np.array([0.25, 0.5, 1.0]) * top))))
        if isinstance(profile, Interpolated):
            return SlopeSamples(profile.gap_slope, marks, _INTERPOLATION_NOISE * steepest)
        # next to a kink the distance r - b is rounded, and the slope with it
        return SlopeSamples(profile.gap_slope, marks, 2e-15 * steepest if marks else 0.0)
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
    inner = interpolant.edges[1:-1].tolist()
    steepest = float(np.max(np.abs(interpolant.slope(interpolant.nodes))))
    return SlopeSamples(
        interpolant.slope, tuple(sorted({*inner, *profile.breakpoints})), _INTERPOLATION_NOISE * steepest
    )


def _refuse_jumps(profile: Function) -> None:
    assert profile.f is not None
    for b in profile.breakpoints:
        left, right = call(profile.f, b * np.array([1.0 - 1e-12, 1.0 + 1e-12]))
        size = max(abs(left - profile.offset), abs(right - profile.offset))
        if abs(right - left) > 1e-6 * size:
            raise ProblemError(
                f"the profile jumps by {right - left:g} m at r = {b:g} m: a step is not a disk contact; "
                "use FlatPunch for a sharp edge"
            )


@singledispatch
def equivalent_profile(profile: Profile) -> EquivalentProfile:
    """
    Map a profile onto the line, g(x) = |x| int_0^|x| f'(r) / sqrt(x^2 - r^2) dr.

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
def _(profile: Sum) -> EquivalentProfile:
    parts = [equivalent_profile(part) for part in profile.parts]
    if any(isinstance(part, NumericLine) for part in parts):
        return NumericLine(profile, profile.edge, profile.reach, profile.breakpoints)
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
    samples = slope_samples(profile, top)
    tip = chebyshev.tip_exponent(samples.slope, top, 0.0) if profile.derivative is not None else 0.0
    slope = chebyshev.build(
        samples.slope,
        top,
        breakpoints=samples.marks,
        tip_exponent=tip,
        noise=lambda r: samples.noise,
        what="f'(r)",
    )
    return Interpolated(
        tuple(slope.edges.tolist()),
        tuple(tuple(panel.coefficients.tolist()) for panel in slope.panels),
        tip,
        profile.breakpoints,
    )
