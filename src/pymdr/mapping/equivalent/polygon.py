"""The line of a force curve: g(x) = d at x = k(d) / (2 E*), a polygon."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from pymdr.mapping.closure.polyline import Polyline
from pymdr.mapping.equivalent.base import EquivalentProfile
from pymdr.numerics.panels import BoolArray, Place, Position, as_place
from pymdr.units import FloatArray

_STEEP = 1e-12
"""Relative widening in x of an interval of constant stiffness, on which g jumps, so that g has one value."""
DEEPER, WIDER = 1e-9, 1e-6
"""Extension of the line, over the last depth and stiffness, so that the last point lies inside."""


@dataclass(frozen=True, eq=False)
class PolygonLine(EquivalentProfile):
    """
    A rising polygon g(x) from (0, 0) on; where it is horizontal, a ring comes into contact at once.

    Integrals are sums of closed forms of its segments.

    Examples
    --------
    >>> line = PolygonLine(np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.0, 1.0]))
    >>> float(line.moment(2.0)), float(line.inverse(0.5))
    (1.5, 1.5)
    """

    x: FloatArray
    """Corners in m, rising strictly from 0."""
    depth: FloatArray
    """G there in m, not falling from 0."""

    @property
    def max_radius(self) -> float:
        """The last corner."""
        return float(self.x[-1])

    @cached_property
    def _segments(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        return self._summed()

    def _summed(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Slopes of the segments; first moment and square integral at the corners."""
        h, rise = np.diff(self.x), np.diff(self.depth)
        x = self.x[:-1]
        moment = np.append(0.0, np.cumsum(rise * (x + 0.5 * h)))
        squared = np.append(0.0, np.cumsum(2.0 * rise * (moment[:-1] + rise * (0.5 * x + h / 6.0))))
        return rise / h, moment, squared

    def _at(self, x: Position) -> tuple[np.ndarray, FloatArray, np.ndarray]:
        """Pieces of positions, how far in m they lie beyond the beginning of theirs, and whether they are beyond all."""
        base, offset = as_place(x)
        h, last = np.diff(self.x), self.x.size - 2
        whole = base + offset
        beyond = whole > self.x[-1]
        j = np.searchsorted(self.x, base, side="right") - 1
        t = offset + (base - self.x[j])
        away = (t < 0.0) | (j > last) | (t > h[np.minimum(j, last)])
        moved = np.clip(np.searchsorted(self.x, whole, side="right") - 1, 0, last)
        j = np.where(away, moved, j)
        t = np.where(away, np.where(beyond, h[j], np.where(beyond, 0.0, whole) - self.x[j]), t)
        return j, t, beyond

    def g(self, x: Position) -> FloatArray:
        """Equivalent profile in m; inf beyond its end."""
        j, t, beyond = self._at(x)
        return np.asarray(np.where(beyond, math.inf, self.depth[j] + self._segments[0][j] * t))

    def slope(self, x: Position) -> FloatArray:
        """Slope g', that to the right at a corner."""
        return np.asarray(self._segments[0][self._at(x)[0]])

    def moment(self, x: Position) -> FloatArray:
        """First moment."""
        j, t, beyond = self._at(x)
        slope, moment, _ = self._segments
        return np.asarray(np.where(beyond, math.inf, moment[j] + slope[j] * t * (self.x[j] + 0.5 * t)))

    def squared(self, x: Position) -> FloatArray:
        """Integral of (g(x) - g)^2."""
        j, t, beyond = self._at(x)
        slope, moment, squared = self._segments
        rise = slope[j] * t
        more = 2.0 * rise * (moment[j] + rise * (0.5 * self.x[j] + t / 6.0))
        return np.asarray(np.where(beyond, math.inf, squared[j] + more))

    def inverse(self, depth: ArrayLike) -> FloatArray:
        """The first x at which g has a value."""
        return self.place(depth).x

    def inverse_moment(self, moment: ArrayLike) -> FloatArray:
        """The first x at which the first moment has a value."""
        return self.place_of_moment(moment).x

    def place(self, depth: ArrayLike) -> Place:
        """As `inverse`, with the digits next to a corner."""
        d = np.asarray(depth, dtype=float)
        j = np.clip(np.searchsorted(self.depth, d, side="left") - 1, 0, self.x.size - 2)
        return self._place(d, d - self.depth[j], j, self.depth, lambda y, slope, _: y / slope)

    def place_of_moment(self, moment: ArrayLike) -> Place:
        """As `inverse_moment`, with the digits next to a corner."""
        m = np.asarray(moment, dtype=float)
        known = self._segments[1]
        j = np.clip(np.searchsorted(known, m, side="left") - 1, 0, self.x.size - 2)

        def root(y: FloatArray, slope: FloatArray, x: FloatArray) -> FloatArray:
            left = 2.0 * y / slope
            return np.asarray(left / (x + np.sqrt(x * x + left)))

        return self._place(m, m - known[j], j, known, root)

    def _place(
        self,
        target: FloatArray,
        more: FloatArray,
        j: np.ndarray,
        known: FloatArray,
        root: Callable[[FloatArray, FloatArray, FloatArray], FloatArray],
    ) -> Place:
        none, beyond = ~(target > 0.0), target > known[-1]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.minimum(root(more, self._segments[0][j], self.x[j]), np.diff(self.x)[j])
        base = np.where(none | beyond, 0.0, self.x[j])
        return Place(base, np.where(none, 0.0, np.where(beyond, math.inf, t)))

    def between(self, depth: FloatArray, low: float, high: float) -> Place:
        """The places at which g has values, wherever they are."""
        return self.place(depth)

    def kinks(self, top: float) -> tuple[float, ...]:
        """Corners up to `top`."""
        return tuple(self.x[(self.x > 0.0) & (self.x <= top)].tolist())

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The corners."""
        return tuple(self.x[1:-1].tolist())

    def rough_radius(self, reached: Callable[[FloatArray, FloatArray], BoolArray]) -> float:
        """The first corner at which it is reached, or the last one."""
        there = np.flatnonzero(reached(self.x[1:], self.depth[1:]))
        return float(self.x[1 + there[0]]) if there.size else self.max_radius


def polygon_of(stiffness: Polyline, modulus: float) -> PolygonLine:
    """
    The line of a stiffness k(d), x = k / (2 E*).

    Parameters
    ----------
    modulus : float
        E* in Pa of the bodies whose stiffness it is.

    Notes
    -----
    Popov and Hess (2015), chapter 10.
    """
    d, k = stiffness
    d, k = np.append(d, d[-1] * (1.0 + DEEPER)), np.append(k, k[-1] * (1.0 + WIDER))
    # of a run of constant stiffness, to rounding, its ends
    least = _STEEP * float(np.min(k[k > 0.0]))
    level = np.append(False, np.diff(k) <= np.maximum(_STEEP * k[:-1], least))
    kept = ~(level & np.append(level[1:], False))
    d, k, level = d[kept], k[kept], level[kept]
    k[1:] = np.where(level[1:], np.maximum(k[1:], k[:-1] + np.maximum(_STEEP * k[:-1], least)), k[1:])
    x = k / (2.0 * modulus)
    rising = np.append(True, np.diff(x) > 0.0)
    return PolygonLine(x[rising], d[rising])
