"""Profiles given by a callable, and the polynomials that stand for them in files."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.problem.profiles.base import Profile
from pymdr.problem.values import SIField
from pymdr.units import FloatArray, to_si_array

ArrayFunction: TypeAlias = Callable[[FloatArray], ArrayLike]


@dataclass(frozen=True, eq=False)
class Function(Profile):
    """
    Any profile given as a callable f(r), its derivative f'(r), or both.

    Parameters
    ----------
    f : callable, optional
        Gap in m, taking and giving arrays. An offset f(0) is removed when the profile is mapped.
    breakpoints : array_like or quantity
        Radii in m, above 0, at which f' jumps or is not smooth.
    derivative : callable, optional
        f'(r), taking and giving arrays. With it the map is exact to 1e-13, with f alone to 1e-12.
    reach : quantity
        Largest radius in m at which the callables may be evaluated.

    Raises
    ------
    ProblemError
        If neither callable is given, or a breakpoint is not above 0.

    Examples
    --------
    >>> bowl = Function(lambda r: r**4, derivative=lambda r: 4 * r**3)
    >>> float(bowl.gap_slope(0.5))
    0.5
    """

    f: ArrayFunction | None = None
    breakpoints: tuple[float, ...] = ()
    derivative: ArrayFunction | None = None
    reach: SIField = SIField("m", above=0.0, default=math.inf)

    def __post_init__(self) -> None:
        if self.f is None and self.derivative is None:
            raise ProblemError("Function(): give f, derivative or both, for example Function(lambda r: r**4)")
        for name in ("f", "derivative"):
            given = getattr(self, name)
            if given is not None and not callable(given):
                raise ProblemError(f"Function.{name} = {given!r}: a callable of the radius is needed")
        radii = np.atleast_1d(to_si_array(self.breakpoints, "m", name="Function.breakpoints"))
        if np.any(radii <= 0.0):
            raise ProblemError(f"Function.breakpoints = {radii.tolist()}: every radius must be above 0 m")
        object.__setattr__(self, "breakpoints", tuple(np.unique(radii).tolist()))

    @property
    def offset(self) -> float:
        """The offset f(0) in m that is removed."""
        return 0.0 if self.f is None else float(call(self.f, np.zeros(1), "f")[0])

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) - f(0) in m."""
        if self.f is None:
            raise ProblemError("Function.gap: only the derivative was given; integrate it")
        return np.asarray(call(self.f, np.asarray(r, dtype=float), "f") - self.offset)

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        if self.derivative is None:
            raise ProblemError("Function.gap_slope: no derivative was given; differentiate f")
        return call(self.derivative, np.asarray(r, dtype=float), "derivative")


def call(function: ArrayFunction, r: FloatArray, name: str = "f") -> FloatArray:
    """
    Evaluate a user's callable on an array of any shape.

    Parameters
    ----------
    function : callable
        Taking and giving one-dimensional arrays.
    r : ndarray
        Radii in m.
    name : str
        What is called, for the message.

    Returns
    -------
    ndarray
        Values of the shape of `r`; nan where the callable is not defined.

    Raises
    ------
    ProblemError
        If the callable does not take arrays.

    Examples
    --------
    >>> call(lambda r: 2 * r, np.ones((1, 2))).tolist()
    [[2.0, 2.0]]
    """
    flat = np.ravel(r)
    with np.errstate(all="ignore"):
        try:
            raw = function(flat)
            if np.iscomplexobj(raw):
                raise ProblemError(f"Function.{name} gives complex numbers; a profile is real")
            values = np.asarray(raw, dtype=float)
            if values.shape != flat.shape:
                values = np.array(np.broadcast_to(values, flat.shape))
            return values.reshape(np.shape(r))
        except (TypeError, ValueError) as error:
            raise ProblemError(
                f"Function.{name} does not take arrays ({error}): write it with NumPy functions, "
                "or wrap it in numpy.vectorize"
            ) from error


@dataclass(frozen=True, eq=False)
class Interpolated(Profile):
    """
    A profile held as polynomials: what a saved result keeps of a :class:`Function`.

    On each panel f' = (t/high)^power sum_j c_j T_j(2 u - 1) with t = r - base and u = (t - low) / (high - low); below
    the first one f' = slope (r/radius)^exponent.

    Parameters
    ----------
    base, low, high : sequence of float
        Origin of every panel in m, and its ends as offsets from it.
    power : sequence of float
        Exponent on every panel.
    coefficients : sequence of sequences of float
        Chebyshev coefficients c_j of f' on every panel.
    tip : tuple of float
        radius in m, slope and exponent of f' below the first panel.
    kinks : sequence of float
        Radii in m at which f' is not smooth.

    Examples
    --------
    >>> cone = Interpolated((0.0,), (0.5,), (1.0,), (0.0,), ((2.0,),), (0.5, 2.0, 0.0))
    >>> round(float(cone.gap(0.75)), 14)
    1.5
    """

    base: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    power: tuple[float, ...]
    coefficients: tuple[tuple[float, ...], ...]
    tip: tuple[float, float, float]
    kinks: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for name in ("base", "low", "high", "power", "tip", "kinks"):
            object.__setattr__(self, name, tuple(float(value) for value in getattr(self, name)))
        object.__setattr__(self, "coefficients", tuple(tuple(map(float, c)) for c in self.coefficients))
        sizes = {len(getattr(self, name)) for name in ("base", "low", "high", "power", "coefficients")}
        ends = np.add(self.base, self.high)
        if len(sizes) != 1 or len(self.tip) != 3 or not ends.size or np.any(np.diff(ends) <= 0.0):
            raise ProblemError(
                "Interpolated: its panels must rise, with base, low, high, power and coefficients for each"
            )

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The kinks."""
        return self.kinks

    @property
    def reach(self) -> float:
        """The end of the last panel."""
        return self.base[-1] + self.high[-1]

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r); nan beyond the reach."""
        r = np.asarray(r, dtype=float)
        answer = np.full(r.shape, math.nan)
        panel = np.searchsorted(np.add(self.base, self.low), r, side="right") - 1
        known = r <= self.reach
        below = known & (panel < 0)
        answer[below] = self._tip_slope(r[below])
        for i in np.unique(panel[known & (panel >= 0)]):
            inside = known & (panel == i)
            answer[inside] = self._panel_slope(r[inside] - self.base[i], int(i))
        return answer

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m by Gauss-Legendre on each panel; nan beyond the reach."""
        r = np.asarray(r, dtype=float)
        nodes, weights = np.polynomial.legendre.leggauss(24)
        s, weights = (nodes + 1.0) / 2.0, weights / 2.0
        radius, slope, exponent = self.tip
        inner = np.minimum(r, radius)
        with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
            answer = slope * radius / (exponent + 1.0) * (inner / radius) ** (exponent + 1.0)
        for i in range(len(self.base)):
            t = np.clip(r - self.base[i], self.low[i], self.high[i])
            width = t - self.low[i]
            if not np.any(width > 0.0):
                break
            for node, weight in zip(s, weights, strict=True):
                values = self._panel_slope(self.low[i] + width * node, i)
                answer = answer + weight * width * np.where(width > 0.0, values, 0.0)
        return np.asarray(np.where(r <= self.reach, answer, math.nan))

    def _tip_slope(self, r: FloatArray) -> FloatArray:
        radius, slope, exponent = self.tip
        with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
            return np.asarray(slope * (r / radius) ** exponent)

    def _panel_slope(self, t: FloatArray, i: int) -> FloatArray:
        u = ((t - self.low[i]) / (self.high[i] - self.low[i])).clip(0.0, 1.0)
        values = np.polynomial.chebyshev.chebval(2.0 * u - 1.0, self.coefficients[i])
        if self.power[i]:
            with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
                values = values * (t / self.high[i]) ** self.power[i]
        return np.asarray(values)
