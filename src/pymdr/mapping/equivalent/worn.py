"""The line of a worn contact whose springs are known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.mapping.equivalent.base import EquivalentProfile
from pymdr.mapping.equivalent.polygon import DEEPER, WIDER, PolygonLine
from pymdr.numerics.panels import Place, Position, as_place
from pymdr.problem.profiles import Worn
from pymdr.units import FloatArray

_JUMP = 1e-7
"""Relative width of the cell on which g rises where it jumps, so that it has one value."""

_THIN = 1e-6
"""Relative width of cells whose angles are those of their middle."""


@dataclass(frozen=True, eq=False)
class WornLine(PolygonLine):
    """
    The original g up to the first spring, and beyond g between springs, linear in x^2 and not falling.

    Examples
    --------
    >>> from pymdr.mapping.equivalent.closed import PowerLine
    >>> ball = PowerLine(2.0, 2.0, 1.0)
    >>> line = WornLine(np.array([1.0, 2.0, 3.0]), np.array([2.0, 8.0, 18.0]), ball)
    >>> x = np.array([0.5, 1.5, 2.9])
    >>> bool(np.allclose(line.squared(x), ball.squared(x), rtol=1e-14))
    True
    """

    inner: EquivalentProfile

    def _summed(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """G' / (2 x) of the cells; first moment and square integral at the springs."""
        x, h = self.x[:-1], np.diff(self.x)
        rate, start = np.diff(self.depth) / (h * (2.0 * x + h)), self.x[:1]
        more = _moment(rate, x, h)
        moment = self.inner.moment(start) + np.append(0.0, np.cumsum(more))
        squared = _squared(rate, x, h, moment[:-1])
        return rate, moment, self.inner.squared(start) + np.append(0.0, np.cumsum(squared))

    def _within(self, x: Position) -> np.ndarray:
        return np.asarray(np.asarray(x, dtype=float) < self.x[0])

    def g(self, x: Position) -> FloatArray:
        """Equivalent profile in m; inf beyond its end."""
        j, t, beyond = self._at(x)
        own = self.depth[j] + self._segments[0][j] * t * (2.0 * self.x[j] + t)
        return np.where(self._within(x), self._inner("g", x), np.where(beyond, math.inf, own))

    def slope(self, x: Position) -> FloatArray:
        """Slope g', that to the right at a spring."""
        own = 2.0 * self._segments[0][self._at(x)[0]] * np.asarray(x, dtype=float)
        return np.where(self._within(x), self._inner("slope", x), own)

    def moment(self, x: Position) -> FloatArray:
        """First moment."""
        j, t, beyond = self._at(x)
        rate, moment, _ = self._segments
        own = moment[j] + _moment(rate[j], self.x[j], t)
        return np.where(self._within(x), self._inner("moment", x), np.where(beyond, math.inf, own))

    def squared(self, x: Position) -> FloatArray:
        """Integral of (g(x) - g)^2."""
        j, t, beyond = self._at(x)
        rate, moment, squared = self._segments
        own = squared[j] + _squared(rate[j], self.x[j], t, moment[j])
        return np.where(self._within(x), self._inner("squared", x), np.where(beyond, math.inf, own))

    def _inner(self, name: str, x: Position) -> FloatArray:
        """A curve of the original, at its end for positions beyond."""
        base, offset = as_place(x)
        outside = base + offset > self.x[0]
        place = Place(np.where(outside, self.x[0], base), np.where(outside, 0.0, offset))
        return np.asarray(getattr(self.inner, name)(place))

    def place(self, depth: ArrayLike) -> Place:
        """As `inverse`, with the digits next to a spring."""
        d = np.asarray(depth, dtype=float)
        j = np.clip(np.searchsorted(self.depth, d, side="left") - 1, 0, self.x.size - 2)

        def root(y: FloatArray, rate: FloatArray, x: FloatArray) -> FloatArray:
            return np.asarray(y / rate / (x + np.sqrt(x * x + y / rate)))

        own = self._place(d, d - self.depth[j], j, self.depth, root)
        return _either(d <= self.depth[0], self.inner.place(np.minimum(d, self.depth[0])), own)

    def place_of_moment(self, moment: ArrayLike) -> Place:
        """As `inverse_moment`, with the digits next to a spring."""
        m = np.asarray(moment, dtype=float)
        known = self._segments[1]
        j = np.clip(np.searchsorted(known, m, side="left") - 1, 0, self.x.size - 2)

        def root(y: FloatArray, rate: FloatArray, x: FloatArray) -> FloatArray:
            cubes = 1.5 * y / rate
            end = np.cbrt(x**3 + cubes)
            return np.asarray(cubes / (end * end + end * x + x * x))

        own = self._place(m, m - known[j], j, known, root)
        return _either(m <= known[0], self.inner.place_of_moment(np.minimum(m, known[0])), own)

    def _cells(self, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Parts of the cells between two radii, shape (radii, cells)."""
        first = np.clip(self.x[:-1], low[:, None], high[:, None])
        return first, np.maximum(np.minimum(self.x[1:], high[:, None]), first)

    def pressure_integral(self, r: Position, a: Position) -> FloatArray:
        """The integral int_r^a g'(x) (x^2 - r^2)^(-1/2) dx."""
        radii, end = np.atleast_1d(np.asarray(r, dtype=float)), float(np.asarray(a, dtype=float))
        low, high = self._cells(radii, np.full(radii.size, max(end, self.x[0])))
        roots = [np.sqrt(np.maximum((x - radii[:, None]) * (x + radii[:, None]), 0.0)) for x in (low, high)]
        both = roots[0] + roots[1]
        parts = 2.0 * (high - low) * (high + low) / np.where(both > 0.0, both, 1.0)
        total = np.sum(self._segments[0] * parts, axis=1)
        inside = radii < min(end, self.x[0])
        if inside.any():
            total[inside] += self.inner.pressure_integral(radii[inside], np.asarray(min(end, self.x[0])))
        return np.asarray(total.reshape(np.shape(r)))

    def gap_integral(self, r: Position, a: Position) -> FloatArray:
        """The integral int_a^r g'(x) arccos(x/r) dx in m, for r beyond a; NaN beyond the springs."""
        radii, start = np.atleast_1d(np.asarray(r, dtype=float)), float(np.asarray(a, dtype=float))
        total = self._angles(radii, np.full(radii.size, start), np.maximum(radii, start))[0]
        if start < self.x[0]:
            within = radii <= self.x[0]
            last = np.asarray(self.x[0])
            total[within] += self.inner.gap_integral(radii[within], np.asarray(start))
            total[~within] += self.inner.gap_between(radii[~within], start, float(last))
        return np.where(radii > self.max_radius, math.nan, total).reshape(np.shape(r))

    def displacement_integral(self, r: ArrayLike, a: Position) -> FloatArray:
        """The integral int_0^a g'(x) arcsin(x/r) dx in m, for r beyond a."""
        radii, end = np.atleast_1d(np.asarray(r, dtype=float)), float(np.asarray(a, dtype=float))
        inside = min(end, float(self.x[0]))
        ends = np.full(radii.size, max(end, inside))
        total = self._angles(radii, np.full(radii.size, self.x[0]), ends)[1]
        if inside > 0.0:
            total += self.inner.displacement_integral(radii, np.asarray(inside))
        return np.asarray(total.reshape(np.shape(r)))

    def _angles(self, r: FloatArray, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The integrals of g' arccos(x/r) and g' arcsin(x/r) over the cells between two radii."""
        first, last = self._cells(low, np.maximum(low, high))
        squares = (last - first) * (last + first)
        ratio = np.minimum(0.5 * (first + last) / r[:, None], 1.0)
        thin = squares * np.arccos(ratio)
        whole = np.where(last - first < _THIN * last, thin, _arcs(last, r) - _arcs(first, r))
        rate = self._segments[0]
        return np.sum(rate * whole, axis=1), np.sum(rate * (0.5 * math.pi * squares - whole), axis=1)

    def kinks(self, top: float) -> tuple[float, ...]:
        """Springs up to `top`, and the kinks of the original within the first."""
        inner = self.inner.kinks(min(top, float(self.x[0])))
        return tuple(sorted({*inner, *super().kinks(top)}))


def _moment(rate: FloatArray, x: FloatArray, t: FloatArray) -> FloatArray:
    """Growth of the first moment over a length t from x on."""
    return 2.0 / 3.0 * rate * t * (3.0 * x * (x + t) + t * t)


def _squared(rate: FloatArray, x: FloatArray, t: FloatArray, moment: FloatArray) -> FloatArray:
    """Growth of the square integral over a length t from x on, without cancellation."""
    rest = t * t * (x**3 * 1.5 + t * (2.0 * x**2 + t * (x + 0.2 * t)))
    return 2.0 * rate * (moment * t * (2.0 * x + t) + 4.0 / 3.0 * rate * rest)


def _arcs(x: FloatArray, r: FloatArray) -> FloatArray:
    """An integral of 2 x arccos(x/r) over x."""
    r = r[:, None]
    ratio = np.minimum(x / r, 1.0)
    return (
        x**2 * np.arccos(ratio)
        + 0.5 * r**2 * np.arcsin(ratio)
        - 0.5 * x * r * np.sqrt((1.0 - ratio) * (1.0 + ratio))
    )


def _either(first: np.ndarray, one: Place, other: Place) -> Place:
    return Place(np.where(first, one.base, other.base), np.where(first, one.offset, other.offset))


def worn_line(profile: Worn, inner: EquivalentProfile) -> WornLine:
    """The line of a worn profile with springs, whose original is mapped to `inner`."""
    assert profile.spring_radius is not None
    assert profile.spring_depth is not None
    x, g = profile.spring_radius, np.maximum.accumulate(profile.spring_depth)
    # where g jumps, two springs have one place
    x = np.where(np.append(False, np.diff(x) <= 0.0), np.nextafter(x * (1.0 + _JUMP), math.inf), x)
    rises = np.append(True, np.diff(x) > 0.0)
    x, g = x[rises], g[rises]
    g[0] = float(inner.g(x[:1])[0])
    # the last depth lies inside
    x, g = np.append(x, x[-1] * (1.0 + WIDER)), np.append(g, g[-1] * (1.0 + DEEPER))
    return WornLine(x, np.maximum.accumulate(g), inner)
