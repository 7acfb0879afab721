"""Equivalent profiles in closed form."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError
from pymdr.mapping import inverse_map
from pymdr.mapping.equivalent.base import EquivalentProfile
from pymdr.mapping.kernels import power_fractions
from pymdr.numerics.panels import Position
from pymdr.numerics.quadrature import gauss
from pymdr.numerics.roots import rising_root
from pymdr.units import FloatArray


def power_factor(n: float, exponent: float = 0.0) -> float:
    """
    The factor kappa(n) of r^n -> kappa x^n.

    Parameters
    ----------
    n : float
        Power, above 0.
    exponent : float
        k of a power-law graded half-space, -1 < k < 1.

    Notes
    -----
    sqrt(pi) Gamma(n/2 + 1) / Gamma((n + 1)/2) for k = 0 (Hess 2011), else (n/2) B(n/2, (1 + k)/2) (Hess 2016).

    Examples
    --------
    >>> round(power_factor(2), 14)
    2.0
    """
    rise = 1.0 + exponent
    gamma = math.sqrt(math.pi) if exponent == 0.0 else math.gamma(rise / 2.0)
    return gamma * math.exp(math.lgamma(n / 2.0 + 1.0) - math.lgamma((n + rise) / 2.0))


@dataclass(frozen=True)
class PowerLine(EquivalentProfile):
    """g = scale (x / unit)^n, the image of a power law; `unit` keeps the numbers near 1."""

    n: float
    scale: float
    unit: float
    exponent: float = 0.0

    def g(self, x: Position) -> FloatArray:
        """Equivalent profile in m."""
        return self._height(np.asarray(x, dtype=float))

    def _height(self, x: FloatArray) -> FloatArray:
        return np.asarray(self.scale * self._power(x / self.unit, self.n))

    def slope(self, x: Position) -> FloatArray:
        """Slope g'."""
        with np.errstate(divide="ignore"):
            relative = self._power(np.asarray(x, dtype=float) / self.unit, self.n - 1.0)
        return np.asarray(self.n * (self.scale / self.unit) * relative)

    def moment(self, x: Position) -> FloatArray:
        """First moment, n/(n+1+k) x^(1+k) g."""
        x, fraction = np.asarray(x, dtype=float), power_fractions(self.n, self.exponent)[0]
        return np.asarray(fraction * self._power(x, 1.0 + self.exponent) * self._height(x))

    def squared(self, x: Position) -> FloatArray:
        """Integral of x^k (g(x) - g)^2, 2 n^2 / ((1+k)(n+1+k)(2n+1+k)) x^(1+k) g^2."""
        x, fraction = np.asarray(x, dtype=float), power_fractions(self.n, self.exponent)[1]
        return np.asarray(fraction * self._power(x, 1.0 + self.exponent) * self._height(x) ** 2)

    def inverse(self, depth: ArrayLike) -> FloatArray:
        """Inverse of g."""
        relative = np.maximum(np.asarray(depth, dtype=float), 0.0) / self.scale
        return np.asarray(self.unit * self._power(relative, 1.0 / self.n))

    def inverse_moment(self, moment: ArrayLike) -> FloatArray:
        """Inverse of the first moment."""
        rise = 1.0 + self.exponent
        factor = power_fractions(self.n, self.exponent)[0] * self.scale * self.unit**rise
        relative = np.maximum(np.asarray(moment, dtype=float), 0.0) / factor
        return np.asarray(self.unit * self._power(relative, 1.0 / (self.n + rise)))

    def pressure_integral(self, r: Position, a: Position) -> FloatArray:
        """Closed for the cone and the paraboloid, by quadrature otherwise."""
        top = np.asarray(a, dtype=float)
        inside = np.minimum(np.asarray(r, dtype=float), top)
        half_chord = np.sqrt((top - inside) * (top + inside))
        rise = 1.0 + self.exponent
        if self.n == 2.0:
            chord = self._power(half_chord, rise)
            return np.asarray(2.0 / rise * (self.scale / self.unit) * (chord / self.unit))
        if self.n == 1.0 and rise == 1.0:
            with np.errstate(divide="ignore"):
                return np.asarray((self.scale / self.unit) * np.arcsinh(half_chord / inside))
        return super().pressure_integral(r, a)

    def displacement_integral(self, r: ArrayLike, a: Position) -> FloatArray:
        """By quadrature for k = 0, closed otherwise."""
        if self.exponent == 0.0:
            return super().displacement_integral(r, a)
        radius = np.asarray(r, dtype=float)
        top = np.full(radius.shape, float(np.asarray(a, dtype=float)))
        return self.g(radius) * inverse_map.power_with_arcsin(self.n, top, radius, self.exponent)

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
    """g = aspect x artanh(x / R), the image of the true sphere, or of an ellipsoid whose height is aspect R."""

    radius: float
    aspect: float = 1.0

    @property
    def max_radius(self) -> float:
        """It ends at R."""
        return self.radius

    def g(self, x: Position) -> FloatArray:
        """Equivalent profile in m; inf at R, nan beyond."""
        x = np.asarray(x, dtype=float)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.aspect * x * np.arctanh(x / self.radius))

    def slope(self, x: Position) -> FloatArray:
        """Slope g' = aspect [artanh t + t / (1 - t^2)]."""
        t = np.asarray(x, dtype=float) / self.radius
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.aspect * (np.arctanh(t) + t / ((1.0 - t) * (1.0 + t))))

    def moment(self, x: Position) -> FloatArray:
        """First moment aspect R^2/2 [(1 + t^2) artanh t - t], as a series below t = 1/2."""
        t = np.asarray(x, dtype=float) / self.radius
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.aspect * self.radius**2 * _sphere_moment(t, np.arctanh(t))

    def squared(self, x: Position) -> FloatArray:
        """Integral of (g(x) - g)^2 by Gauss-Legendre in s, t = tanh(s), where g = aspect R s tanh(s)."""
        x = np.asarray(x, dtype=float)
        top = np.arctanh(np.ravel(x) / self.radius)
        answer = np.zeros(top.shape)
        nodes, weights = gauss(32)
        depth = top * np.tanh(top)
        for node, weight in zip(nodes, weights, strict=True):
            s = top * node
            tanh = np.tanh(s)
            answer += weight * (depth - s * tanh) ** 2 * (1.0 - tanh) * (1.0 + tanh)
        return np.asarray((self.aspect**2 * self.radius**3 * top * answer).reshape(x.shape))

    def inverse(self, depth: ArrayLike) -> FloatArray:
        """Inverse of g by Newton's method on s tanh(s) = depth / (aspect R)."""
        y = np.maximum(np.asarray(depth, dtype=float), 0.0) / (self.aspect * self.radius)
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
                f"sphere or ellipsoid: the search for the contact radius at d/H = {y[bad][0]:g} did not converge (last s = {s[bad][0]:g}); use a smaller indentation or force"
            )
        return np.asarray(self.radius * np.tanh(s))

    def inverse_moment(self, moment: ArrayLike) -> FloatArray:
        """Inverse of the first moment by Newton's method in s = artanh(x / R); R where no contact inside has it."""
        target = np.maximum(np.asarray(moment, dtype=float), 0.0)
        beyond = target > self.moment(self.radius * (1.0 - 1e-15))
        y = np.where(beyond, 0.0, target) / self.radius / (self.aspect * self.radius)
        s = np.where(y < 1.0, np.cbrt(1.5 * y), y + 0.5)
        for _ in range(60):
            t = np.tanh(s)
            with np.errstate(invalid="ignore", divide="ignore"):
                step = (_sphere_moment(t, s) - y) / (t * (s * (1.0 - t) * (1.0 + t) + t))
            step = np.where(s > 0.0, step, 0.0)
            s = s - step
            # as long as the steps are more than the rounding of the moment
            if np.all(np.abs(step) <= 1e-15 * s):
                return np.asarray(np.where(beyond, self.radius, self.radius * np.tanh(s)))
        bad = np.abs(step) > 4e-15 * s
        if bad.any():
            raise ConvergenceError(
                f"sphere or ellipsoid: the search for the contact radius at m/(H R) = {y[bad][0]:g} did not converge (last s = {s[bad][0]:g}); use a smaller indentation or force"
            )
        return np.asarray(np.where(beyond, self.radius, self.radius * np.tanh(s)))


def _sphere_moment(t: FloatArray, s: FloatArray) -> FloatArray:
    """First moment in R^2 at t = x / R = tanh(s)."""
    small = np.minimum(np.abs(t), 0.5)
    series = small**3 * np.polynomial.polynomial.polyval(small**2, _SPHERE_MOMENT)
    return np.asarray(np.where(np.abs(t) < 0.5, series, ((1.0 + t * t) * s - t) / 2.0))


@dataclass(frozen=True)
class SumLine(EquivalentProfile):
    """The sum of closed forms, powers for k not 0, cut at a sharp edge; without parts it is the flat punch."""

    parts: tuple[EquivalentProfile, ...]
    edge: float = math.inf
    max_radius: float = math.inf
    exponent: float = 0.0

    def g(self, x: Position) -> FloatArray:
        """Equivalent profile in m."""
        return sum((part.g(x) for part in self.parts), np.zeros(np.shape(x)))

    def slope(self, x: Position) -> FloatArray:
        """Slope g'."""
        return sum((part.slope(x) for part in self.parts), np.zeros(np.shape(x)))

    def moment(self, x: Position) -> FloatArray:
        """First moment."""
        return sum((part.moment(x) for part in self.parts), np.zeros(np.shape(x)))

    def squared(self, x: Position) -> FloatArray:
        """Integral of x^k (g(x) - g)^2, for k = 0 by Gauss-Legendre on panels graded to 0."""
        if len(self.parts) <= 1:
            return self.parts[0].squared(x) if self.parts else np.zeros(np.shape(x))
        if self.exponent != 0.0:
            return self._squared_of_powers(x)
        x = np.asarray(x, dtype=float)
        depth, answer = self.g(x), np.zeros(x.shape)
        nodes, weights = gauss(24)
        for low, high in pairwise((0.0, *0.25 ** np.arange(13.0, -1.0, -1.0))):
            for s, w in zip(low + (high - low) * nodes, (high - low) * weights, strict=True):
                answer += w * (depth - self.g(s * x)) ** 2
        return np.asarray(x * answer)

    def _squared_of_powers(self, x: Position) -> FloatArray:
        """The same for powers, by the integrals of their products."""
        rise = 1.0 + self.exponent
        powers = [part for part in self.parts if isinstance(part, PowerLine)]
        answer = np.zeros(np.shape(x))
        for one in powers:
            for two in powers:
                fraction = one.n * two.n * (one.n + two.n + 2.0 * rise)
                fraction /= rise * (one.n + rise) * (two.n + rise) * (one.n + two.n + rise)
                answer += fraction * one.g(x) * two.g(x)
        return np.asarray(np.asarray(x, dtype=float) ** rise * answer)

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

    def pressure_integral(self, r: Position, a: Position) -> FloatArray:
        """Sum of the parts' integrals."""
        return sum((part.pressure_integral(r, a) for part in self.parts), np.zeros(np.shape(r)))

    def displacement_integral(self, r: ArrayLike, a: Position) -> FloatArray:
        """By quadrature for k = 0, the sum of the parts' integrals otherwise."""
        if self.exponent == 0.0:
            return super().displacement_integral(r, a)
        return sum((part.displacement_integral(r, a) for part in self.parts), np.zeros(np.shape(r)))
