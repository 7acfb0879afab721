"""The way back from the line to the surface: integrals over g' on the panels of an image.

    pressure        int_r^a g'(x) / sqrt(x^2 - r^2) dx
    gap             int_a^r g'(x) arccos(x / r) dx
    displacement    int_0^a g'(x) arcsin(x / r) dx

Where x comes close to r a substitution takes out the root; behind a breakpoint b, where g' may be an inverse square
root of x - b, it is taken out together with it. Distances are differences of offsets.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from pymdr.mapping.abel import gauss
from pymdr.mapping.series import BoolArray, IndexArray, Panels, Series, evaluate
from pymdr.units import FloatArray

_POINTS = 20
_CLOSE = 0.6
_WORK = 400_000
_BITS = 27.0
"""Half the number of bits of a double: below 4^-(27 / (n + 1)) of a stretch nothing is left of int x^n dx."""
_Kernel: TypeAlias = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""Of the distance from r, x and r."""


@dataclass(frozen=True)
class Stretch:
    """A part of the line between two places of an image."""

    panels: Panels
    slope: Series
    low: FloatArray
    """Offset in m at which each panel is entered, shape (P,)."""
    high: FloatArray


def stretch(panels: Panels, slope: Series, start: tuple[float, float], stop: tuple[float, float]) -> Stretch:
    """
    The panels between two places (base, offset), cut to them.

    Parameters
    ----------
    panels, slope : Panels, Series
        The image.
    start, stop : tuple of float
        Places as (base, offset) in m.

    Returns
    -------
    Stretch
    """
    low = np.maximum(panels.low, (start[0] - panels.base) + start[1])
    high = np.minimum(panels.high, (stop[0] - panels.base) + stop[1])
    inside = np.flatnonzero(high > low)
    return Stretch(panels.take(inside), slope.take(inside), low[inside], high[inside])


def over_root(part: Stretch, base: FloatArray, offset: FloatArray) -> FloatArray:
    """
    The integral of g' / sqrt(x^2 - r^2) over what of a stretch lies beyond each r.

    Parameters
    ----------
    part : Stretch
    base, offset : ndarray, shape (R,)
        Radii r as places in m.

    Returns
    -------
    ndarray, shape (R,)
    """

    def kernel(distance: FloatArray, x: FloatArray, r: FloatArray) -> FloatArray:
        return 1.0 / np.sqrt(distance * (x + r))

    answer = _integrated(part, base, offset, kernel, above=True)
    corner = np.flatnonzero(part.panels.begins & (part.low == 0.0) & (part.slope.power <= -0.5))
    for i in corner:
        on_it = (base - part.panels.base[i]) + offset == 0.0
        answer[on_it] = math.copysign(math.inf, part.slope.coefficients[i].sum())
    return answer


def with_arccos(part: Stretch, base: FloatArray, offset: FloatArray) -> FloatArray:
    """The integral of g' arccos(x / r) over what of a stretch lies below each r, shape (R,)."""

    def kernel(distance: FloatArray, x: FloatArray, r: FloatArray) -> FloatArray:
        # of x = r - distance, without rounding beside r
        return 2.0 * np.arcsin(np.sqrt(np.minimum(0.5 * distance / r, 1.0)))

    return _integrated(part, base, offset, kernel, above=False)


def with_arcsin(part: Stretch, base: FloatArray, offset: FloatArray) -> FloatArray:
    """The integral of g' arcsin(x / r) over a stretch that lies below each r, shape (R,)."""

    def kernel(distance: FloatArray, x: FloatArray, r: FloatArray) -> FloatArray:
        return np.arctan2(x, np.sqrt(distance * (r + x)))

    return _integrated(part, base, offset, kernel, above=False)


def _integrated(
    part: Stretch, base: FloatArray, offset: FloatArray, kernel: _Kernel, *, above: bool
) -> FloatArray:
    panels = part.panels
    total = np.zeros(base.shape)
    if panels.count == 0 or base.size == 0:
        return total
    rows = max(1, _WORK // (panels.count * _POINTS))
    for start in range(0, base.size, rows):
        chosen = slice(start, start + rows)
        total[chosen] = _block(part, base[chosen], offset[chosen], kernel, above)
    return total


def _block(part: Stretch, base: FloatArray, offset: FloatArray, kernel: _Kernel, above: bool) -> FloatArray:
    panels = part.panels
    at = (base[:, None] - panels.base) + offset[:, None]
    low = np.maximum(part.low, at) if above else np.broadcast_to(part.low, at.shape)
    high = np.broadcast_to(part.high, at.shape) if above else np.minimum(part.high, at)
    used = high > low
    width = high - low
    distance = low - at if above else at - high
    far = used & (distance >= _CLOSE * width) & ~_touches(panels, low)
    close = used & ~far
    total = np.zeros(base.shape)
    row, panel = np.nonzero(far)
    if row.size:
        s, w = gauss(_POINTS)
        lo, hi = low[row, panel], high[row, panel]
        u, jacobian = _in_variable(panels, panel, lo, hi, s)
        value = _at(part, panel, u) * w * jacobian
        x = panels.base[panel][:, None] + u
        gap = u - at[row, panel][:, None] if above else at[row, panel][:, None] - u
        r = (base + offset)[row][:, None]
        np.add.at(total, row, (value * kernel(gap, x, r)).sum(axis=1))
    row, panel = np.nonzero(close)
    if row.size:
        total += _near(
            part, row, panel, low[row, panel], high[row, panel], at[row, panel], base, offset, kernel, above
        )
    return total


def _touches(panels: Panels, low: FloatArray) -> BoolArray:
    """Whether a part begins at its breakpoint, where g' may be an inverse square root."""
    return np.asarray(panels.rooted & (low == 0.0))


def _in_variable(
    panels: Panels, panel: IndexArray, low: FloatArray, high: FloatArray, s: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Offsets and their derivatives with respect to s in (0, 1), in the square root on rooted panels."""
    rooted = panels.rooted[panel][:, None]
    first, last = np.sqrt(low)[:, None], np.sqrt(high)[:, None]
    t = first + (last - first) * s
    plain = low[:, None] + (high - low)[:, None] * s
    offset = np.where(rooted, np.clip(t * t, low[:, None], high[:, None]), plain)
    return offset, np.where(rooted, 2.0 * t * (last - first), (high - low)[:, None])


def _at(part: Stretch, panel: IndexArray, offset: FloatArray) -> FloatArray:
    index = np.broadcast_to(panel[:, None], offset.shape)
    return evaluate(part.panels, part.slope, index.ravel(), offset.ravel()).reshape(offset.shape)


def _near(
    part: Stretch,
    row: IndexArray,
    panel: IndexArray,
    low: FloatArray,
    high: FloatArray,
    at: FloatArray,
    base: FloatArray,
    offset: FloatArray,
    kernel: _Kernel,
    above: bool,
) -> FloatArray:
    """Parts beside r: x = r +- v^2, or the same in the square root of the offset on rooted panels."""
    total = np.zeros(base.shape)
    rooted = part.panels.rooted[panel]
    s, w = gauss(_POINTS)
    plain = np.flatnonzero(~rooted)
    if plain.size:
        i, p = row[plain], panel[plain]
        inner, outer = (low[plain] - at[plain], high[plain] - at[plain])
        if not above:
            inner, outer = -outer, -inner
        first, last = np.sqrt(np.maximum(inner, 0.0))[:, None], np.sqrt(outer)[:, None]
        v = first + (last - first) * s
        gap = v * v
        delta = np.clip(
            at[plain][:, None] + (gap if above else -gap), low[plain][:, None], high[plain][:, None]
        )
        value = _at(part, p, delta) * 2.0 * v * (last - first) * w
        x, r = part.panels.base[p][:, None] + delta, (base + offset)[i][:, None]
        np.add.at(total, i, (value * kernel(gap, x, r)).sum(axis=1))
    roots = np.flatnonzero(rooted)
    if roots.size:
        i, p, lo, hi = _octaves(
            row[roots], panel[roots], low[roots], high[roots], at[roots], part.slope.power[panel[roots]]
        )
        place = (base[i] - part.panels.base[p]) + offset[i]
        delta, gap, jacobian = _through_both(lo, hi, place, s, above)
        # parts thinner than rounding have no weight
        gap = np.where(gap > 0.0, gap, 1.0)
        value = _at(part, p, delta) * jacobian * w
        x, r = part.panels.base[p][:, None] + delta, (base + offset)[i][:, None]
        np.add.at(total, i, (value * kernel(gap, x, r)).sum(axis=1))
    return total


def _octaves(
    row: IndexArray, panel: IndexArray, low: FloatArray, high: FloatArray, at: FloatArray, power: FloatArray
) -> tuple[IndexArray, IndexArray, FloatArray, FloatArray]:
    """
    Parts of rooted panels divided where the offset has grown fourfold, down to the distance of r.

    Those that begin at a breakpoint with a power that the root does not take out are divided down to where nothing is
    left to integrate.
    """
    scale = np.abs(at)
    smallest = np.maximum(low, np.minimum(np.where(scale > 0.0, scale, 0.0), high))
    smallest = np.where(smallest > 0.0, smallest, high * 4.0**-60)
    broken = (low == 0.0) & (2.0 * power != np.round(2.0 * power))
    smallest = np.where(broken, 0.0, smallest)
    smallest = np.maximum(smallest, high * 4.0 ** np.where(broken, -_BITS / (power + 1.0), -60.0))
    count = np.maximum(np.ceil(np.log2(high / smallest) / 2.0), 0.0).astype(int) + 1
    index = np.repeat(np.arange(row.size), count)
    step = np.arange(index.size) - np.repeat(np.cumsum(count) - count, count)
    upper = high[index] * 4.0 ** -step.astype(float)
    last = step == count[index] - 1
    lower = np.where(last, low[index], np.maximum(upper / 4.0, low[index]))
    real = upper > lower
    index, lower, upper = index[real], lower[real], upper[real]
    return row[index], panel[index], lower, upper


def _through_both(
    low: FloatArray, high: FloatArray, at: FloatArray, s: FloatArray, above: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Offsets, distances from r and derivatives in a variable that takes out both roots.

    With t = sqrt(offset) it is t = t_r cosh for x beyond r, t_r sinh where r lies before the breakpoint, and
    t = t_r sin for x below r; t_r is the root of the distance of r from the breakpoint.
    """
    root = np.sqrt(np.abs(at))[:, None]
    first, last = np.sqrt(low)[:, None], np.sqrt(high)[:, None]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        if above:
            outside = (at <= 0.0)[:, None]
            start = np.where(outside, np.arcsinh(first / root), _beyond(low - at, root))
            stop = np.where(outside, np.arcsinh(last / root), _beyond(high - at, root))
            theta = start + (stop - start) * s
            t = root * np.where(outside, np.sinh(theta), np.cosh(theta))
            other = root * np.where(outside, np.cosh(theta), np.sinh(theta))
            on_it = root == 0.0
            plain = first + (last - first) * s
            t = np.where(on_it, plain, t)
            gap = np.where(on_it, plain * plain, other * other)
            # d(offset) = 2 t dt, and dt = other dtheta
            jacobian = 2.0 * t * np.where(on_it, last - first, other * (stop - start))
        else:
            start, stop = np.arcsin(first / root), np.arcsin(np.minimum(last / root, 1.0))
            theta = start + (stop - start) * s
            t = root * np.sin(theta)
            other = root * np.cos(theta)
            gap = other * other
            jacobian = 2.0 * t * other * (stop - start)
    return np.clip(t * t, low[:, None], high[:, None]), gap, jacobian


def _beyond(distance: FloatArray, root: FloatArray) -> FloatArray:
    """arcosh(t / root) from the distance t^2 - root^2, which keeps its digits next to t = root."""
    return np.asarray(np.arcsinh(np.sqrt(np.maximum(distance, 0.0))[:, None] / root))


def tail_over_root(power: float, slope: float, top: float, r: FloatArray) -> FloatArray:
    """
    The integral of g' / sqrt(x^2 - r^2) from r to `top`, where g' = slope (x / top)^power.

    Parameters
    ----------
    power, slope : float
        Above -1; g' at `top`.
    top : float
        In m.
    r : ndarray
        Radii in m, at most `top`; at 0 the integral may be infinite.

    Returns
    -------
    ndarray
    """
    answer = np.zeros(r.shape)
    if slope == 0.0:
        return answer
    centre = r < 1e-300
    answer[centre] = slope / power if power > 0.0 else math.copysign(math.inf, slope)
    s, w = gauss(24)
    for i in np.flatnonzero(~centre & (r < top)):
        radius = float(r[i])
        octaves = math.ceil(math.log2(top / radius))
        edges = np.minimum(radius * 2.0 ** np.arange(octaves + 1.0), top)
        v = math.sqrt(edges[1] - radius) * s
        x = radius + v * v
        total = float(((x / top) ** power / np.sqrt(x + radius)) @ w) * 2.0 * math.sqrt(edges[1] - radius)
        x = edges[1:-1, None] + np.diff(edges[1:])[:, None] * s
        total += float(((x / top) ** power / np.sqrt((x - radius) * (x + radius)) @ w) @ np.diff(edges[1:]))
        answer[i] = slope * total
    return answer


def power_with_arccos(n: float, high: FloatArray, r: FloatArray) -> FloatArray:
    """
    The integral int_0^h n t^(n-1) arccos(t) dt for h = high / r, n above 0 and high not above r.

    Notes
    -----
    By parts h^n arccos(h) + B(h^2; (n+1)/2, 1/2) / 2 with the incomplete beta function.

    Examples
    --------
    >>> round(float(power_with_arccos(1.0, np.ones(1), np.ones(1))[0]), 14)
    1.0
    """
    rest = np.sqrt(np.maximum((r - high) * (r + high), 0.0))
    return (high / r) ** n * np.arctan2(rest, high) + _half_beta(n, high / r, rest / r)


def power_with_arcsin(n: float, high: FloatArray, r: FloatArray) -> FloatArray:
    """
    The integral int_0^h n t^(n-1) arcsin(t) dt for h = high / r, n above 0 and high not above r.

    Examples
    --------
    >>> round(float(power_with_arcsin(1.0, np.ones(1), np.ones(1))[0]), 15) == round(0.5 * math.pi - 1.0, 15)
    True
    """
    rest = np.sqrt(np.maximum((r - high) * (r + high), 0.0))
    return (high / r) ** n * np.arctan2(high, rest) - _half_beta(n, high / r, rest / r)


def _half_beta(n: float, sine: FloatArray, cosine: FloatArray) -> FloatArray:
    """The integral int_0^sine t^n / sqrt(1 - t^2) dt."""
    from scipy.special import beta, betainc, betaincc

    p = 0.5 * (n + 1.0)
    part = np.where(sine < 0.7, betainc(p, 0.5, sine * sine), betaincc(0.5, p, cosine * cosine))
    return np.asarray(0.5 * beta(p, 0.5) * part)
