"""Equivalent profiles as piecewise Chebyshev interpolants."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError
from pymdr.mapping import abel, chebyshev
from pymdr.mapping.abel import gauss
from pymdr.mapping.equivalent.base import EquivalentProfile, rising_root
from pymdr.units import FloatArray


@dataclass(frozen=True, kw_only=True)
class ProxyLine(EquivalentProfile):
    """g, its moment and its square integral as piecewise Chebyshev interpolants on [0, reach]."""

    curve: chebyshev.Piecewise
    first_moment: chebyshev.Piecewise
    square: chebyshev.Piecewise
    breakpoints: tuple[float, ...]
    corners: tuple[float, ...]
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


def proxy_line(
    curve: chebyshev.Piecewise,
    moment: abel.Curve | None,
    breakpoints: tuple[float, ...],
    edge: float,
    top: float,
) -> ProxyLine:
    """A :class:`ProxyLine` from an interpolant of g, and samples of its first moment if there are any."""
    exponent = curve.panels[0].tip_exponent
    if moment is None:
        first_moment = _cumulative(curve, lambda i, t: t, exponent)
    else:
        first_moment = curve.resample(lambda x, _: moment(x), exponent + 1.0)
    # int (g(x) - g)^2 dt = int 2 g' m dt, which has no subtraction in it; a product has twice the degree
    square = _cumulative(curve, lambda i, t: 2.0 * first_moment.panels[i].value(t), 2.0 * exponent, finer=2)
    turning = _turning_points(curve)
    return ProxyLine(
        curve=curve,
        first_moment=first_moment,
        square=square,
        breakpoints=tuple(b for b in breakpoints if b < top),
        corners=tuple(panel.low for panel in curve.panels if panel.rises_steeply),
        edge=edge,
        reach=top,
        rises=not turning,
        turning_points=turning,
    )


def _cumulative(
    curve: chebyshev.Piecewise,
    weight: Callable[[int, FloatArray], FloatArray],
    exponent: float,
    finer: int = 1,
) -> chebyshev.Piecewise:
    """The integral int_0^x g'(t) weight(panel, t) dt, whose integrand starts like t^exponent."""
    index = {panel.low: i for i, panel in enumerate(curve.panels)}
    below = {0.0: 0.0}

    def sample(x: FloatArray, panel: chebyshev.Panel) -> FloatArray:
        i = index[panel.low]
        g = curve.panels[i]

        def upto(x: FloatArray) -> FloatArray:
            if panel.low == 0.0:
                s, w = gauss(x.size + 8, exponent)
                t = x[:, None] * s
                return np.asarray(x * ((g.slope(t) * weight(i, t) / s**exponent) @ w))
            width = panel.high - panel.low
            root = ((x - panel.low) / width) ** (1.0 / panel.power)
            s, w = gauss(x.size + 8)
            u = root[:, None] * s
            if panel.tip_exponent:
                t = panel.low + width * u
                return np.asarray(width * root * ((g.slope(t) * weight(i, t)) @ w))
            return np.asarray(root * ((g.rate(u) * weight(i, panel.low + width * u**panel.power)) @ w))

        below[panel.high] = below[panel.low] + float(upto(np.array([panel.high]))[0])
        return below[panel.low] + upto(x)

    return curve.resample(sample, exponent + 1.0, finer)


def _turning_points(curve: chebyshev.Piecewise) -> tuple[float, ...]:
    """Points where g' changes sign, ignoring rounding noise."""
    fine = np.linspace(1e-3, 1.0, 321)
    to_the_tip = np.concatenate([np.geomspace(1e-12, 1e-3, 73)[:-1], fine])
    grids = [
        panel.low + (panel.high - panel.low) * (fine if panel.low > 0.0 else to_the_tip) ** panel.power
        for panel in curve.panels
    ]
    x = np.concatenate(grids)
    slope = np.concatenate([panel.slope(grid) for panel, grid in zip(curve.panels, grids, strict=True)])
    steepness = slope * x
    noise = 1e-11 * float(np.max(np.abs(steepness), initial=0.0))
    if not math.isfinite(noise):
        raise ConvergenceError("g'(x) is not finite inside its panels: the profile is not resolved")
    sure = np.abs(steepness) > noise
    x, slope = x[sure], slope[sure]
    if x.size == 0:
        return ()
    found = [0.0] if slope[0] < 0.0 else []
    at = np.flatnonzero(np.sign(slope[1:]) != np.sign(slope[:-1]))
    low, high, before = x[at], x[at + 1], np.sign(slope[at])
    for _ in range(80):
        middle = 0.5 * (low + high)
        if not np.any((low < middle) & (middle < high)):
            break
        same = np.sign(curve.slope(middle)) == before
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    found += (0.5 * (low + high)).tolist()
    return tuple(found)
