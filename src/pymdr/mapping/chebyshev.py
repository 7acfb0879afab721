"""Piecewise Chebyshev interpolants that refine themselves: the fast form of a curve known by samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError
from pymdr.units import FloatArray, metres

_SIZES = (24, 40, 64)
_TAIL = 3e-15
_TIP_LEVELS = 26
_DEEPEST = 40
_MOST_PANELS = 128
"""Panels between two breakpoints on average: more are spent on noise only."""


@lru_cache(maxsize=8)
def nodes(n: int) -> FloatArray:
    """Chebyshev points of the first kind on (0, 1), rising, shape (n,)."""
    points: FloatArray = (1.0 - np.cos(np.pi * (np.arange(n) + 0.5) / n)) / 2.0
    points.flags.writeable = False
    return points


@lru_cache(maxsize=8)
def _fit(n: int) -> FloatArray:
    """Matrix from values at :func:`nodes` to Chebyshev coefficients in 2 t - 1."""
    vandermonde = chebyshev.chebvander(2.0 * nodes(n) - 1.0, n - 1)
    return np.asarray(np.linalg.inv(vandermonde), dtype=np.float64)


@dataclass(frozen=True)
class Panel:
    """One interpolant: x = low + width t^power, value = (x / high)^tip_exponent * series(2 t - 1)."""

    low: float
    high: float
    power: int
    tip_exponent: float
    coefficients: FloatArray

    @cached_property
    def significant(self) -> FloatArray:
        """The coefficients without their tail of rounding noise."""
        large = np.flatnonzero(np.abs(self.coefficients) > 1e-16 * np.max(np.abs(self.coefficients)))
        return self.coefficients[: large[-1] + 1 if large.size else 1]

    @cached_property
    def derivative(self) -> FloatArray:
        """Chebyshev coefficients of the derivative with respect to t."""
        return np.asarray(2.0 * chebyshev.chebder(self.coefficients), dtype=np.float64)

    @property
    def spans_decades(self) -> bool:
        """Whether the series of a panel by the tip is so small at its lower end that it loses digits there."""
        if not self.tip_exponent:
            return False
        ends = chebyshev.chebval(np.array([-1.0, 1.0]), self.coefficients)
        return bool(abs(ends[0]) < abs(ends[1]) / 64.0)

    @property
    def nodes(self) -> FloatArray:
        """The interpolation points x."""
        return self.low + (self.high - self.low) * nodes(self.coefficients.size) ** self.power

    def _t(self, x: FloatArray) -> FloatArray:
        t: FloatArray = np.asarray((x - self.low) / (self.high - self.low), dtype=np.float64).clip(0.0, 1.0)
        return np.sqrt(t) if self.power == 2 else t

    def value(self, x: FloatArray) -> FloatArray:
        """The interpolated curve at `x`."""
        series = np.asarray(chebyshev.chebval(2.0 * self._t(x) - 1.0, self.significant), dtype=np.float64)
        return series * (x / self.high) ** self.tip_exponent if self.tip_exponent else series

    @cached_property
    def _slope_over_t(self) -> FloatArray | None:
        """Coefficients of (d/dt)/t, where the derivative with respect to t is 0 at t = 0."""
        at_nodes = chebyshev.chebval(2.0 * nodes(self.coefficients.size) - 1.0, self.derivative)
        at_start = chebyshev.chebval(-1.0, self.derivative)
        rounding = 1e-15 * self.coefficients.size**2 * np.max(np.abs(self.coefficients))
        if self.power != 2 or abs(at_start) > max(1e-11 * np.max(np.abs(at_nodes)), rounding):
            return None
        return _fit(self.coefficients.size) @ ((at_nodes - at_start) / nodes(self.coefficients.size))

    def rate(self, t: FloatArray) -> FloatArray:
        """The derivative with respect to t, of a panel without tip exponent."""
        return np.asarray(chebyshev.chebval(2.0 * t - 1.0, self.derivative))

    @property
    def rises_steeply(self) -> bool:
        """Whether the derivative is an inverse square root at the lower end."""
        return self.power == 2 and self._slope_over_t is None

    def slope(self, x: FloatArray) -> FloatArray:
        """The derivative at `x`; inf at the lower end of a panel where it is an inverse square root."""
        t = self._t(x)
        z = 2.0 * t - 1.0
        width = self.high - self.low
        with np.errstate(divide="ignore"):
            if self.power == 1:
                slope = chebyshev.chebval(z, self.derivative) / width
            elif self._slope_over_t is not None:
                slope = chebyshev.chebval(z, self._slope_over_t) / (2.0 * width)
            else:
                slope = chebyshev.chebval(z, self.derivative) / (2.0 * width * t)
        if not self.tip_exponent:
            return np.asarray(slope)
        n = self.tip_exponent
        series = chebyshev.chebval(z, self.coefficients)
        with np.errstate(divide="ignore"):
            return np.asarray((x / self.high) ** (n - 1.0) / self.high * (n * series + x * slope))


@dataclass(frozen=True)
class Piecewise:
    """Panels side by side from 0 to their top."""

    panels: tuple[Panel, ...]

    @property
    def edges(self) -> FloatArray:
        """Panel edges, shape (panels + 1,)."""
        return np.array([self.panels[0].low, *(p.high for p in self.panels)])

    @property
    def nodes(self) -> FloatArray:
        """All interpolation points, rising."""
        return np.concatenate([p.nodes for p in self.panels])

    def _piecewise(self, x: ArrayLike, evaluate: Callable[[Panel, FloatArray], FloatArray]) -> FloatArray:
        x = np.asarray(x, dtype=float)
        flat = np.ravel(x)
        if len(self.panels) == 1:
            return np.asarray(evaluate(self.panels[0], flat).reshape(x.shape))
        index = np.clip(np.searchsorted(self.edges, flat, side="right") - 1, 0, len(self.panels) - 1)
        answer = np.empty(flat.shape)
        for i in np.flatnonzero(np.bincount(index)):
            inside = index == i
            answer[inside] = evaluate(self.panels[i], flat[inside])
        return answer.reshape(x.shape)

    def value(self, x: ArrayLike) -> FloatArray:
        """The curve at `x`."""
        return self._piecewise(x, Panel.value)

    def slope(self, x: ArrayLike) -> FloatArray:
        """The derivative at `x`."""
        return self._piecewise(x, Panel.slope)

    def resample(
        self, sample: Callable[[FloatArray, Panel], FloatArray], tip_exponent: float = 0.0, finer: int = 1
    ) -> Piecewise:
        """Another curve on the same panels, with `finer` times the nodes; ``sample(x, panel)`` gives its values."""
        made = []
        for panel in self.panels:
            size = finer * panel.coefficients.size
            x = panel.low + (panel.high - panel.low) * nodes(size) ** panel.power
            exponent = tip_exponent if panel.low == 0.0 or panel.tip_exponent else 0.0
            values = sample(x, panel) / (x / panel.high) ** exponent
            made.append(Panel(panel.low, panel.high, panel.power, exponent, _fit(size) @ values))
        return Piecewise(tuple(made))


def build(
    sample: Callable[[FloatArray], FloatArray],
    top: float,
    *,
    breakpoints: Sequence[float] = (),
    rooted: bool = False,
    tip_exponent: float = 0.0,
    noise: Callable[[float], float] = lambda x: 0.0,
    what: str = "curve",
) -> Piecewise:
    """
    Interpolate a curve on [0, top] to rounding error, splitting panels where it needs it.

    Parameters
    ----------
    sample : callable
        The curve on arrays.
    top : float
        Upper end, above 0.
    breakpoints : sequence of float
        Rising points at which the curve is not smooth.
    rooted : bool
        Whether the curve behaves like a square root to the right of each breakpoint.
    tip_exponent : float
        Exponent n of a curve that starts like x^n; below the first breakpoint, curve / x^n is interpolated.
    noise : callable
        Absolute rounding noise of the samples up to x, below which no refinement is tried.
    what : str
        Name of the curve, for errors.

    Returns
    -------
    Piecewise

    Raises
    ------
    ConvergenceError
        If a panel does not converge.

    Examples
    --------
    >>> curve = build(np.exp, 2.0)
    >>> bool(abs(curve.slope(1.0) - np.e) < 1e-12)
    True
    """
    marks = [b for b in breakpoints if b < top]
    starts = [0.0, *marks]
    todo = [
        (lo, hi, 2 if rooted and lo > 0.0 else 1, 0, tip_exponent if lo == 0.0 else 0.0)
        for lo, hi in zip(starts, [*marks, top], strict=True)
    ][::-1]
    done: list[Panel] = []
    most = _MOST_PANELS * len(starts)
    while todo:
        low, high, power, depth, exponent = todo.pop()
        panel = _converged_panel(sample, low, high, power, exponent, noise(high))
        if panel is None and low == 0.0 and depth >= _TIP_LEVELS:
            panel = _panel(sample, low, high, power, exponent)[0]
        if panel is not None and (depth >= _TIP_LEVELS or not panel.spans_decades):
            done.append(panel)
            continue
        if depth >= _DEEPEST or len(done) > most:
            raise ConvergenceError(
                f"{what}: it is not smooth at {metres(low)}; name the radius as a breakpoint, or stay inside "
                "the radii where the profile is defined"
            )
        middle = low + (high - low) / (4.0 if low == 0.0 or power == 2 else 2.0)
        if not low < middle < high:
            raise ConvergenceError(f"{what}: it is not smooth at {metres(low)}")
        todo += [(middle, high, 1, depth + 1, exponent), (low, middle, power, depth + 1, exponent)]
    return Piecewise(tuple(done))


def _panel(
    sample: Callable[[FloatArray], FloatArray],
    low: float,
    high: float,
    power: int,
    exponent: float,
    size: int = _SIZES[-1],
) -> tuple[Panel, FloatArray]:
    x = low + (high - low) * nodes(size) ** power
    values = sample(x)
    if exponent:
        values = values / (x / high) ** exponent
    if not np.all(np.isfinite(values)):
        raise ConvergenceError(
            f"the profile gives {values[~np.isfinite(values)][0]} at r = {metres(x[~np.isfinite(values)][0])}; "
            "stay inside the radii where it is defined (Function(..., reach=...) states them)"
        )
    return Panel(low, high, power, exponent, _fit(size) @ values), values


def _converged_panel(
    sample: Callable[[FloatArray], FloatArray],
    low: float,
    high: float,
    power: int,
    exponent: float,
    noise: float,
) -> Panel | None:
    for size in _SIZES:
        panel, values = _panel(sample, low, high, power, exponent, size)
        scale = float(np.max(np.abs(values)))
        tail = float(np.max(np.abs(panel.coefficients[-3:])))
        if tail <= max(_TAIL * scale, noise) or scale == 0.0:
            return panel
    return None


def tip_exponent(curve: Callable[[FloatArray], FloatArray], top: float, default: float = 1.0) -> float:
    """
    Exponent n of a curve that starts like x^n, from its values far inside `top`, or a default.

    Examples
    --------
    >>> tip_exponent(lambda x: x**2, 1.0)
    2.0
    """
    x = top * np.array([1e-9, 1e-8, 1e-7])
    with np.errstate(all="ignore"):
        exponents = np.diff(np.log(curve(x))) / math.log(10.0)
    if not np.all(np.isfinite(exponents)) or abs(exponents[1] - exponents[0]) > 1e-3:
        return default
    exponent = float(exponents[0])
    nearest = round(exponent * 120.0) / 120.0
    if abs(exponent - nearest) < 1e-6:
        exponent = nearest
    return exponent if -0.95 < exponent < 64.0 else default
