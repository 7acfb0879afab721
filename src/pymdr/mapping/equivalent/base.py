"""The interface of equivalent profiles."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from pymdr.mapping import abel
from pymdr.numerics.panels import BoolArray, Place, Position
from pymdr.numerics.roots import rising_root
from pymdr.problem.values import values_html
from pymdr.units import FloatArray


class EquivalentProfile(ABC):
    """
    The profile on the line. All arguments and values are SI floats or arrays of them.

    Positions are numbers, or a :class:`~pymdr.numerics.panels.Place` that keeps their distance from a breakpoint.
    """

    exponent: float = 0.0
    """k of a power-law graded half-space, E(z) ~ z^k, -1 < k < 1; 0 for a homogeneous one."""
    edge: float = math.inf
    """Sharp edge in m that no contact passes."""
    rises: bool = True
    """Whether g is known to rise everywhere, so that every contact is a disk."""

    @property
    def max_radius(self) -> float:
        """Largest x in m at which g is known."""
        return math.inf

    @abstractmethod
    def g(self, x: Position) -> FloatArray:
        """Equivalent profile g(x) in m."""

    @abstractmethod
    def slope(self, x: Position) -> FloatArray:
        """Slope g'(x)."""

    @abstractmethod
    def moment(self, x: Position) -> FloatArray:
        """First moment int_0^x t^(1+k) g'(t) dt in m^(2+k)."""

    @abstractmethod
    def squared(self, x: Position) -> FloatArray:
        """The integral int_0^x t^k (g(x) - g(t))^2 dt in m^(3+k); its derivative is 2 g' moment / (1 + k)."""

    @abstractmethod
    def inverse(self, depth: ArrayLike) -> FloatArray:
        """The first x in m at which g(x) = depth; inf where g never gets there."""

    @abstractmethod
    def inverse_moment(self, moment: ArrayLike) -> FloatArray:
        """The first x in m at which the first moment has the given value."""

    def place(self, depth: ArrayLike) -> Place:
        """As `inverse`, with full precision next to a breakpoint."""
        x = self.inverse(depth)
        return Place(np.zeros(np.shape(x)), x)

    def place_of_moment(self, moment: ArrayLike) -> Place:
        """As `inverse_moment`, with full precision next to a breakpoint."""
        x = self.inverse_moment(moment)
        return Place(np.zeros(np.shape(x)), x)

    def between(self, depth: FloatArray, low: float, high: float) -> Place:
        """The places at which g(x) = depth on a stretch on which g rises."""
        bounds = np.full(depth.shape, low), np.full(depth.shape, high)
        x = rising_root(self.g, depth, *bounds)
        return Place(np.zeros(x.shape), x)

    def _repr_html_(self) -> str:
        """The range of the profile and where it is not smooth as a table, for notebooks."""
        rows = (
            ("edge", self.edge if math.isfinite(self.edge) else None, "m"),
            ("max_radius", self.max_radius if math.isfinite(self.max_radius) else None, "m"),
            ("breakpoints", np.array(self.breakpoints) if self.breakpoints else None, "m"),
            ("rises", self.rises or "not known", ""),
            ("exponent", self.exponent or None, ""),
            ("rests_on", "; ".join(self.rests_on()) or None, ""),
        )
        return values_html("EquivalentProfile", rows)

    def integral(self, x: Position) -> FloatArray:
        """The integral int_0^x t^k g(t) dt in m^(2+k)."""
        rise = 1.0 + self.exponent
        return (np.asarray(x, dtype=float) ** rise * self.g(x) - self.moment(x)) / rise

    def error(self, x: Position) -> FloatArray:
        """Measured relative errors of g, g', the moment and the square integral, shape (..., 4)."""
        return np.zeros((*np.shape(x), 4))

    def slope_error(self, x: Position) -> FloatArray:
        """Largest relative error of integrals of g' over a contact up to x, relative to their absolute integrands."""
        return np.zeros(np.shape(x))

    def place_error(self, place: Place, of_moment: BoolArray) -> FloatArray:
        """Largest error in m of the places at which g, or the moment, has a value, from all errors."""
        return np.zeros(np.shape(place.x))

    def kinks(self, top: float) -> tuple[float, ...]:
        """Places in m up to `top` to whose right g is not smooth."""
        return ()

    def corners(self, top: float) -> tuple[tuple[float, float], ...]:
        """Kinks of f up to `top` as (radius in m, jump of f'), where f' jumps by more than its rounding."""
        return ()

    def resolving_radii(self, top: float) -> FloatArray:
        """Rising radii in m up to `top` between which g bends little; empty where it is known to rise."""
        return np.empty(0)

    def turning_points(self, top: float) -> tuple[float, ...]:
        """Places in m up to `top` at which g' changes its sign; 0 where g begins to fall."""
        return ()

    def overlap_radius(self, depth: float) -> float:
        """The largest radius in m at which the bodies would overlap if they were shifted by a depth in m."""
        return min(float(self.inverse(depth)), self.edge, self.max_radius)

    def rough_radius(self, reached: Callable[[FloatArray, FloatArray], BoolArray]) -> float:
        """A radius x in m near which ``reached(x, g(x))`` becomes true, going outward; where a search may begin."""
        return 1.0

    def searched_to(self, depth: float) -> float:
        """Radius in m of the search for contact at a depth in m; 0 where the profile is known to rise."""
        return 0.0

    def rests_on(self) -> tuple[str, ...]:
        """Text on the basis of the map besides values of the profile."""
        return ()

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """All places in m, as far as they are known, to whose right g is not smooth."""
        return ()

    def pressure_integral(self, r: Position, a: Position) -> FloatArray:
        """The integral int_r^a g'(x) (x^2 - r^2)^((k-1)/2) dx."""
        return abel.edge_average(
            self.slope, np.asarray(r, dtype=float), float(np.asarray(a, dtype=float)), k=self.exponent
        )

    def pressure_between(self, r: FloatArray, low: float, high: float) -> FloatArray:
        """The part of the pressure integral from x = low to high, for r up to low."""
        return self.pressure_integral(r, high) - self.pressure_integral(r, low)

    def gap_between(self, r: FloatArray, low: float, high: float) -> FloatArray:
        """The part of the gap integral from x = low to high, for r from high on."""
        return self.gap_integral(r, low) - self.gap_integral(r, high)

    def gap_integral(self, r: Position, a: Position) -> FloatArray:
        """
        The integral int_a^r g'(x) A(x / r) dx in m, for r beyond a.

        A(s) = cos(k pi/2) int_s^1 t^k (1 - t^2)^(-(1+k)/2) dt, which is arccos(s) for k = 0. The gap outside a disk is
        2/pi times [this - (d - g(a)) A(a / r)].
        """
        low = float(np.asarray(a, dtype=float))
        start = self.g(np.array([low]))[0]
        radii = np.asarray(r, dtype=float)
        scale = float(np.max(np.abs(self.g(radii)), initial=0.0))
        average = abel.line_average(
            lambda x: self.g(x) - start, radii, low=low, k=self.exponent, noise=1e-14 * scale
        )
        return 0.5 * math.pi * math.cos(0.5 * math.pi * self.exponent) * average

    def displacement_integral(self, r: ArrayLike, a: Position) -> FloatArray:
        """
        The integral int_0^a g'(x) B(x / r) dx in m, for r beyond a.

        B(s) = pi/2 - A(s), which is arcsin(s) for k = 0.
        """
        high = float(np.asarray(a, dtype=float))
        top = float(self.g(np.array([high]))[0])
        average = abel.line_average(
            lambda x: top - self.g(np.minimum(x, high)), r, high=high, k=self.exponent, noise=1e-14 * top
        )
        return 0.5 * math.pi * math.cos(0.5 * math.pi * self.exponent) * average
