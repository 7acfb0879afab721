"""The effect of layers on the line load of a contact as an equivalent profile: half-spaces under it carry the same load."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from pymdr.line.layered.equation import gauss
from pymdr.line.layered.tiles import product
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.mapping.layers import Kernel
from pymdr.numerics.panels import Position, basis, nodes, to_coefficients
from pymdr.units import FloatArray

_TERMS = 16
_NODES = 16
"""Nodes of the quadratures, on a panel."""


@dataclass(frozen=True)
class Added:
    """
    The part c(x) = (K q)(x) of a line load per modulus in m, smooth everywhere, as series on panels.

    Parameters
    ----------
    radius : float
        Of the contact in m.
    x, loads : ndarray
        Places in m and line loads there times their weights, in m of the unit length `thickness`.
    top : float
        Radius in m up to which it is needed.
    """

    kernel: Kernel
    thickness: float
    radius: float
    x: FloatArray
    loads: FloatArray

    def series(self, top: float) -> Series:
        """Panels of a thickness within the contact, and growing ones outside, up to a radius in m."""
        a, h = self.radius / self.thickness, self.thickness
        ends = np.linspace(0.0, a, max(1, math.ceil(a)) + 1).tolist()
        width = min(a, 1.0)
        while ends[-1] < top / h:
            ends.append(ends[-1] + width)
            width *= 1.5
        low, high = np.array(ends[:-1]), np.array(ends[1:])
        points = low[:, None] + (high - low)[:, None] * nodes(_TERMS)
        values = product(self.kernel.pair(points.ravel(), self.x), self.loads)
        coefficients = values.reshape(points.shape) @ to_coefficients(_TERMS).T
        return Series(low * h, high * h, coefficients)


@dataclass(frozen=True)
class Series:
    """A function on panels side by side from 0 on."""

    low: FloatArray
    high: FloatArray
    coefficients: FloatArray
    """Shape (panels, terms)."""

    def __call__(self, x: FloatArray, slope: bool = False) -> FloatArray:
        """Its values, or its derivative."""
        flat = np.abs(np.ravel(x))
        i = np.clip(np.searchsorted(self.low, flat, side="right") - 1, 0, self.low.size - 1)
        width = self.high[i] - self.low[i]
        coefficients = self._slopes if slope else self.coefficients
        functions = basis((flat - self.low[i]) / width, coefficients.shape[1])
        values = np.einsum("nj,nj->n", coefficients[i], functions)
        return np.asarray((values / width if slope else values).reshape(np.shape(x)))

    @cached_property
    def _slopes(self) -> FloatArray:
        """Coefficients of the derivative by the place on a panel, from 0 to 1."""
        return np.asarray(2.0 * chebyshev.chebder(self.coefficients, axis=1))


@dataclass(frozen=True)
class Coupled(EquivalentProfile):
    """
    The profile g - c + c(0) under which half-spaces carry the load of layers under g, in a contact of one radius.

    Parameters
    ----------
    bare : EquivalentProfile
        g.
    added : Added
        c.
    """

    bare: EquivalentProfile
    added: Added

    def __post_init__(self) -> None:
        for name in ("edge", "rises"):
            object.__setattr__(self, name, getattr(self.bare, name))

    @property
    def max_radius(self) -> float:
        """Largest x in m at which g is known."""
        return self.bare.max_radius

    @cached_property
    def _inside(self) -> Series:
        return self.added.series(self.added.radius)

    def _series_up_to(self, top: float) -> Series:
        return self._inside if top <= self.added.radius else self.added.series(top)

    def _panels(self, length: float) -> int:
        """Panels of a quadrature over a length in m."""
        return max(2, math.ceil(length / self.added.thickness) + 1)

    def kinks(self, top: float) -> tuple[float, ...]:
        """Places up to `top` to whose right g is not smooth; c is smooth."""
        return self.bare.kinks(top)

    def g(self, x: Position) -> FloatArray:
        """The profile g - c + c(0) in m."""
        at = np.asarray(x, dtype=float)
        added = self._series_up_to(float(np.max(at, initial=0.0)))
        return np.asarray(self.bare.g(x) - (added(at) - added(np.zeros(1))[0]))

    def slope(self, x: Position) -> FloatArray:
        """The slope g' - c'."""
        at = np.asarray(x, dtype=float)
        return self.bare.slope(x) - self._series_up_to(float(np.max(at, initial=0.0)))(at, slope=True)

    def moment(self, x: Position) -> FloatArray:
        """First moment in m^2."""
        at = np.asarray(x, dtype=float)
        return self.bare.moment(x) - _gauss_over(
            lambda t: t * self._series_up_to(float(np.max(at, initial=0.0)))(t, slope=True),
            at,
            self._panels(float(np.max(at))),
        )

    def squared(self, x: Position) -> FloatArray:
        """The integral of (g(x) - g(t))^2 in m^3."""
        at = np.asarray(x, dtype=float)
        inner = self.g(x)
        return _gauss_over(
            lambda t: (inner[..., None] - self.g(t)) ** 2, at, 4 * self._panels(float(np.max(at)))
        )

    def inverse(self, depth: ArrayLike) -> FloatArray:
        """Not known: the profile is that of one contact."""
        raise NotImplementedError

    def inverse_moment(self, moment: ArrayLike) -> FloatArray:
        """Not known either."""
        raise NotImplementedError

    def pressure_integral(self, r: Position, a: Position) -> FloatArray:
        """The integral int_r^a (g' - c') / sqrt(x^2 - r^2) dx."""
        radius, end = np.asarray(r, dtype=float), float(np.asarray(a, dtype=float))
        inside = radius <= end
        span = np.sqrt(np.maximum((end - radius) * (end + radius), 0.0))

        def integrand(t: FloatArray) -> FloatArray:
            x = np.hypot(radius[..., None], t)
            slope = self._inside(np.minimum(x, end), slope=True)
            return np.where(x > 0.0, slope / np.where(x > 0.0, x, 1.0), 0.0)

        part = _gauss_over(integrand, span, self._panels(end))
        return self.bare.pressure_integral(r, a) - np.where(inside, part, 0.0)

    def gap_integral(self, r: Position, a: Position) -> FloatArray:
        """The integral int_a^r (g' - c') arccos(x / r) dx in m."""
        radius, end = np.asarray(r, dtype=float), float(np.asarray(a, dtype=float))
        top = float(np.max(radius, initial=end))
        added = self._series_up_to(top)
        distance = (radius - end)[..., None]

        def integrand(u: FloatArray) -> FloatArray:
            left = distance * u * u
            x = radius[..., None] - left
            angle = np.arctan2(np.sqrt(left * (radius[..., None] + x)), x)
            return 2.0 * distance * u * angle * added(x, slope=True)

        part = _gauss_over(
            integrand, np.ones(radius.shape), 2 * self._panels(min(top - end, 16.0 * self.added.thickness))
        )
        return self.bare.gap_integral(r, a) - part

    def displacement_integral(self, r: ArrayLike, a: Position) -> FloatArray:
        """The integral int_0^a (g' - c') arcsin(x / r) dx in m, for r beyond a."""
        radius, end = np.asarray(r, dtype=float), float(np.asarray(a, dtype=float))

        def integrand(u: FloatArray) -> FloatArray:
            left = end * u * u
            x = end - left
            away = (radius[..., None] - end) + left
            return (
                2.0
                * end
                * u
                * np.arctan2(x, np.sqrt(away * (radius[..., None] + x)))
                * self._inside(x, slope=True)
            )

        part = _gauss_over(integrand, np.ones(radius.shape), 2 * self._panels(end))
        return self.bare.displacement_integral(r, a) - part

    def sunk(self, r: FloatArray) -> FloatArray:
        """Additional displacement in m of the surface of the layers relative to half-spaces, -(2/pi) int_0^r c / sqrt(r^2 - x^2) dx."""
        top = float(np.max(r, initial=0.0))
        added = self._series_up_to(top)
        whole = np.full(r.shape, 0.5 * math.pi)
        return (
            -2.0
            / math.pi
            * _gauss_over(
                lambda t: added(r[..., None] * np.sin(t)),
                whole,
                2 * self._panels(min(top, 256.0 * self.added.thickness)),
            )
        )


def _gauss_over(integrand: Callable[[FloatArray], FloatArray], top: FloatArray, panels: int) -> FloatArray:
    """Integrals from 0 to each of some ends, on panels side by side."""
    unit, weight = gauss(_NODES)
    u = ((np.arange(panels)[:, None] + 0.5 * (unit + 1.0)) / panels).ravel()
    weights = np.tile(0.5 * weight / panels, panels)
    ends = np.asarray(top, dtype=float)[..., None]
    return np.asarray((integrand(ends * u) * weights).sum(axis=-1) * ends[..., 0])
