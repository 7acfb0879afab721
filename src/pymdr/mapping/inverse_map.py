"""The inverse map from the line to the surface: integrals over g' on the panels of an image.

    pressure        int_r^a g'(x) / sqrt(x^2 - r^2) dx
    gap             int_a^r g'(x) arccos(x / r) dx
    displacement    int_0^a g'(x) arcsin(x / r) dx

Near x = r a substitution removes the root, and after a breakpoint b, where g' may be an inverse square root of x - b, also
that root. Distances are differences of offsets. For the other powers in the kernels of a graded half-space, segments are
graded toward r and toward b instead, and the weights of the segments that end there contain the powers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from pymdr.mapping.kernels import arc_above, arc_below
from pymdr.mapping.tree_levels import POINTS, Level, PanelTree
from pymdr.numerics.panels import BoolArray, IndexArray, Selection, evaluate
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

_CLOSE, _FAR = 0.6, 1.0
"""Least distance from r at which a panel or a tree node is replaced by its source strengths, over its width."""
_CLEAR = 1.5
"""Least distance of r from a segment that begins at a breakpoint, in the root of the offset."""
_WORK = 400_000
_BITS = 27.0
"""Half the number of bits of a double: the part below 4^-(27 / (n + 1)) of an interval is negligible in int x^n dx."""
_Kernel: TypeAlias = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""Function of the distance from r, x and r."""


@dataclass(frozen=True)
class Stretch:
    """A part of the line between two places (base, offset) in m."""

    slope: PanelTree
    start: tuple[float, float]
    stop: tuple[float, float]


def over_root(part: Stretch, base: FloatArray, offset: FloatArray, k: float = 0.0) -> FloatArray:
    """
    The integral of g' (x^2 - r^2)^((k-1)/2) over the part of a stretch outside each r.

    Parameters
    ----------
    base, offset : ndarray, shape (R,)
        Radii r as places in m.
    k : float
        Exponent of the grading.

    Returns
    -------
    ndarray, shape (R,)
    """

    def kernel(distance: FloatArray, x: FloatArray, r: FloatArray) -> FloatArray:
        square = distance * (x + r)
        return 1.0 / (np.sqrt(square) if k == 0.0 else square ** (0.5 * (1.0 - k)))

    return _integrated(part, _Radii(base, offset, kernel, True, k))


def with_arccos(part: Stretch, base: FloatArray, offset: FloatArray, k: float = 0.0) -> FloatArray:
    """The integral of g' arccos(x / r), or its analogue for k, over the part of a stretch below each r, shape (R,)."""

    def kernel(distance: FloatArray, x: FloatArray, r: FloatArray) -> FloatArray:
        if k != 0.0:
            return arc_above(*_sides(distance, x, r), k)
        # arccos(x / r) for x = r - distance, without cancellation
        return 2.0 * np.arcsin(np.sqrt(np.minimum(0.5 * distance / r, 1.0)))

    return _integrated(part, _Radii(base, offset, kernel, False, k))


def with_arcsin(part: Stretch, base: FloatArray, offset: FloatArray, k: float = 0.0) -> FloatArray:
    """The integral of g' arcsin(x / r), or its analogue for k, over a stretch below each r, shape (R,)."""

    def kernel(distance: FloatArray, x: FloatArray, r: FloatArray) -> FloatArray:
        if k != 0.0:
            return arc_below(*_sides(distance, x, r), k)
        return np.arctan2(x, np.sqrt(distance * (r + x)))

    return _integrated(part, _Radii(base, offset, kernel, False, k))


def _sides(distance: FloatArray, x: FloatArray, r: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The ratio s = x / r and 1 - s^2, each to full precision."""
    return np.minimum(x / r, 1.0), np.minimum(distance * (r + x) / (r * r), 1.0)


class _Radii(NamedTuple):
    """The radii and the kernel of an integral."""

    base: FloatArray
    offset: FloatArray
    kernel: _Kernel
    above: bool
    """Whether the integral is over x above each radius, or below it."""
    k: float

    def take(self, index: slice) -> _Radii:
        """Some of the radii."""
        return self._replace(base=self.base[index], offset=self.offset[index])

    @property
    def r(self) -> FloatArray:
        """The rounded radii in m."""
        return self.base + self.offset


class _Parts(NamedTuple):
    """Parts of panels or tree nodes, flat."""

    row: IndexArray
    """Index of the radius."""
    panel: IndexArray
    low: FloatArray
    high: FloatArray
    """Ends, as offsets from the base of the panel."""
    at: FloatArray
    """The radius, as such an offset."""

    def take(self, index: Selection) -> _Parts:
        """Some of the parts."""
        row, panel, *rest = self
        return _Parts(row[index], panel[index], *(column[index] for column in rest))


def _integrated(part: Stretch, radii: _Radii) -> FloatArray:
    total = np.zeros(radii.base.shape)
    rows = max(1, _WORK // part.slope.levels[-1].base.size)
    for start in range(0, radii.base.size, rows):
        chosen = slice(start, start + rows)
        total[chosen] = _block(part, radii.take(chosen))
    return total


def _block(part: Stretch, radii: _Radii) -> FloatArray:
    """Descend from the widest tree nodes to those far enough from r, and to the adjacent panels."""
    base, offset, _, above, k = radii
    total = np.zeros(base.shape)
    levels = part.slope.levels
    row, node = (index.ravel() for index in np.indices((base.size, levels[-1].base.size)))
    for depth in range(len(levels) - 1, -1, -1):
        level = levels[depth]
        own = level.base[node]
        at = (base[row] - own) + offset[row]
        low = np.maximum(level.low[node], (part.start[0] - own) + part.start[1])
        high = np.minimum(level.high[node], (part.stop[0] - own) + part.stop[1])
        low, high = np.maximum(low, at) if above else low, high if above else np.minimum(high, at)
        parts = _Parts(row, node, low, high, at).take(high > low)
        row, node, low, high, at = parts
        width = level.high[node] - level.low[node]
        far = (low == level.low[node]) & (high == level.high[node])
        far &= (low - at if above else at - high) >= (_FAR if depth else _CLOSE) * width
        if k != 0.0 and not above:
            # the kernels begin like x^(1+k)
            far &= level.base[node] + low >= width
        _add_far(total, level, parts.take(far), radii)
        parts = parts.take(~far)
        row, node, *_ = parts
        if depth:
            row, node = np.concatenate([row, row]), np.concatenate([2 * node, 2 * node + 1])
            known = node < levels[depth - 1].base.size
            row, node = row[known], node[known]
    if row.size:
        total += (_near if k == 0.0 else _near_graded)(part.slope, parts, radii)
    return total


def _add_far(total: FloatArray, level: Level, parts: _Parts, radii: _Radii) -> None:
    row, node, _, _, at = parts
    rows = _WORK // POINTS
    for start in range(0, row.size, rows):
        chosen = slice(start, start + rows)
        i, c = row[chosen], node[chosen]
        place = level.offset[c]
        gap = place - at[chosen, None] if radii.above else at[chosen, None] - place
        values = radii.kernel(gap, level.base[c][:, None] + place, radii.r[i][:, None])
        total += np.bincount(i, np.einsum("ij,ij->i", level.strength[c], values), total.size)


def _at(slope: PanelTree, panel: IndexArray, offset: FloatArray) -> FloatArray:
    index = np.broadcast_to(panel[:, None], offset.shape)
    return evaluate(slope.panels, slope.curve, index.ravel(), offset.ravel()).reshape(offset.shape)


def _near(slope: PanelTree, parts: _Parts, radii: _Radii) -> FloatArray:
    """Parts adjacent to r: x = r +- v^2, or the same in the square root of the offset on rooted panels."""
    row, panel, low, high, at = parts
    base, offset, kernel, above, _ = radii
    total = np.zeros(base.shape)
    rooted = slope.panels.rooted[panel]
    s, w = gauss(POINTS)
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
        value = _at(slope, p, delta) * 2.0 * v * (last - first) * w
        x, r = slope.panels.base[p][:, None] + delta, (base + offset)[i][:, None]
        np.add.at(total, i, (value * kernel(gap, x, r)).sum(axis=1))
    roots = np.flatnonzero(rooted)
    if roots.size:
        i, p, lo, hi = _octaves(
            row[roots], panel[roots], low[roots], high[roots], at[roots], slope.curve.power[panel[roots]]
        )
        place = (base[i] - slope.panels.base[p]) + offset[i]
        delta, gap, jacobian = _through_both(lo, hi, place, s, above)
        # parts thinner than rounding have no weight
        gap = np.where(gap > 0.0, gap, 1.0)
        value = _at(slope, p, delta) * jacobian * w
        x, r = slope.panels.base[p][:, None] + delta, (base + offset)[i][:, None]
        np.add.at(total, i, (value * kernel(gap, x, r)).sum(axis=1))
    if above:
        # at a breakpoint at which the slope is an inverse square root
        on_it = rooted & (at == 0.0) & (low == 0.0) & (slope.curve.power[panel] <= -0.5)
        sign = slope.curve.coefficients[panel[on_it]].sum(axis=1)
        total[row[on_it]] = np.copysign(math.inf, sign)
    return total


def _near_graded(slope: PanelTree, parts: _Parts, radii: _Radii) -> FloatArray:
    """Parts adjacent to r on segments graded toward it and toward breakpoints."""
    row, panel, low, high, at = parts
    base, offset, kernel, above, k = radii
    total = np.zeros(base.shape)
    panels, n = slope.panels, slope.panels.order
    gain = 0.5 * (1.0 + k)
    for i, lo, hi, kind in _segments(panels.rooted[panel], low, high, at, n, above):
        p, r = panel[i], (base + offset)[row[i]][:, None]
        b, place = panels.base[p][:, None], at[i][:, None]
        power = slope.curve.power[p]
        width = (hi - lo)[:, None]
        for exponent in np.unique(power) if kind in ("begins", "both") else (math.nan,):
            rows = slice(None) if math.isnan(exponent) else power == exponent
            if kind == "touches":
                # the kernel is the power of the distance in the weights, and a smooth factor
                rule = gain - 1.0 if above else 1.0 - gain
                s, w = gauss(POINTS, rule)
                gap = width * s
                delta = np.clip(place + (gap if above else -gap), lo[:, None], hi[:, None])
                value = _at(slope, p, delta) * width * w / s**rule
            elif kind == "plain":
                s, w = gauss(POINTS)
                rooted = panels.rooted[p][:, None]
                first, last = panels.root(lo)[:, None], panels.root(hi)[:, None]
                root = first + (last - first) * s
                delta = np.clip(np.where(rooted, root**n, lo[:, None] + width * s), lo[:, None], hi[:, None])
                gap = np.abs(delta - place)
                rate = np.where(rooted, n * (last - first) * root ** (n - 1.0), width)
                value = _at(slope, p, delta) * rate * w
            else:
                own = exponent + (gain - 1.0 if kind == "both" else 0.0)
                if own <= -1.0 + 1e-12:
                    sign = slope.curve.coefficients[p[rows]].sum(axis=1)
                    total[row[i[rows]]] = np.copysign(math.inf, sign)
                    continue
                rule = n * (own + 1.0) - 1.0
                s, w = gauss(POINTS, rule)
                delta = np.maximum(hi[rows, None] * s**n, np.finfo(float).tiny)
                gap = np.maximum(np.abs(delta - place[rows]), np.finfo(float).tiny)
                value = _at(slope, p[rows], delta) * n * hi[rows, None] * s ** (n - 1.0 - rule) * w
            value = value * kernel(gap, b[rows] + delta, r[rows])
            total += np.bincount(row[i[rows]], value.sum(axis=1), total.size)
    return total


def _segments(
    rooted: BoolArray, low: FloatArray, high: FloatArray, at: FloatArray, order: float, above: bool
) -> Iterator[tuple[IndexArray, FloatArray, FloatArray, str]]:
    """
    Segments of low <= offset <= high with r at `at`, for one quadrature rule each.

    They come in groups of a kind: segments that touch r, that begin at a breakpoint, that do both, and plain ones that are
    no longer than their distance from r and from the breakpoint.
    """
    index, lo, hi = np.arange(low.size), low, high
    separation = _CLEAR**order
    while index.size:
        place, begins = at[index], rooted[index] & (lo == 0.0)
        touches = (lo == place) if above else (hi == place)
        near = np.where(above, lo - place, place - hi)
        width = hi - lo
        toward_low = (rooted[index] & (lo == 0.0)) | above
        middle = lo + np.where(toward_low, 0.25, 0.75) * width
        thin = ~((lo < middle) & (middle < hi))
        clearance = np.where(rooted[index], np.minimum(near, lo), near)
        clear = {
            "both": begins & touches & above,
            "touches": touches & ~begins & (~rooted[index] | (width <= lo)),
            "begins": begins & ~touches & (np.where(above, near, place) >= separation * hi),
            "plain": ~touches & ~begins & (thin | (width <= 3.0 * clearance)),
        }
        done = thin
        for kind, chosen in clear.items():
            done = done | chosen
            if chosen.any():
                yield index[chosen], lo[chosen], hi[chosen], kind
        # the quarter next to the graded end is divided further
        index, lo, middle, hi = index[~done], lo[~done], middle[~done], hi[~done]
        index = np.concatenate([index, index])
        lo, hi = np.concatenate([lo, middle]), np.concatenate([middle, hi])


def _octaves(
    row: IndexArray, panel: IndexArray, low: FloatArray, high: FloatArray, at: FloatArray, power: FloatArray
) -> tuple[IndexArray, IndexArray, FloatArray, FloatArray]:
    """
    Parts of rooted panels divided at fourfold offsets, down to the distance of r.

    Parts that begin at a breakpoint with a power that the root does not remove are divided until the rest is negligible.
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
    Offsets, distances from r and derivatives in a variable that removes both roots.

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
    """arcosh(t / root) from the distance t^2 - root^2, without cancellation next to t = root."""
    return np.asarray(np.arcsinh(np.sqrt(np.maximum(distance, 0.0))[:, None] / root))


def tail_over_root(power: float, slope: float, top: float, r: FloatArray, k: float = 0.0) -> FloatArray:
    """
    The integral of g' (x^2 - r^2)^((k-1)/2) from r to `top`, where g' = slope (x / top)^power.

    Parameters
    ----------
    power, slope : float
        Above -1; g' at `top`.
    top : float
        In m.
    r : ndarray
        Radii in m, at most `top`; at 0 the integral may be infinite.
    k : float
        Exponent of the grading.
    """
    answer = np.zeros(r.shape)
    if slope == 0.0:
        return answer
    centre = r == 0.0
    answer[centre] = slope / (power + k) * top**k if power + k > 0.0 else math.copysign(math.inf, slope)
    s, w = gauss(24)
    loss = 0.5 * (1.0 - k)
    s_first, w_first = gauss(24, -loss)
    for i in np.flatnonzero(~centre & (r < top)):
        radius = float(r[i])
        octaves = math.ceil(math.log2(top) - math.log2(radius))
        edges = np.minimum(radius * 2.0 ** np.arange(octaves + 1.0), top)
        if k == 0.0:
            v = math.sqrt(edges[1] - radius) * s
            x = radius + v * v
            total = float(((x / top) ** power / np.sqrt(x + radius)) @ w) * 2.0 * math.sqrt(edges[1] - radius)
        else:
            width = edges[1] - radius
            x = radius + width * s_first
            total = float(((x / top) ** power / (x + radius) ** loss) @ w_first) * width ** (1.0 - loss)
        octave = np.diff(edges[1:])[:, None]
        x = edges[1:-1, None] + octave * s
        # the squares may underflow
        root = (
            np.sqrt(x - radius) * np.sqrt(x + radius)
            if k == 0.0
            else (x - radius) ** loss * (x + radius) ** loss
        )
        total += float(np.sum((x / top) ** power * (octave / root) @ w))
        answer[i] = slope * total
    return answer


def power_with_arccos(n: float, high: FloatArray, r: FloatArray, k: float = 0.0) -> FloatArray:
    """
    The integral int_0^h n t^(n-1) arccos(t) dt, or its analogue for k, where h = high / r is at most 1 and n above 0.

    Notes
    -----
    By parts h^n arccos(h) + B(h^2; (n+1+k)/2, (1-k)/2) cos(k pi/2) / 2 with the incomplete beta function.

    Examples
    --------
    >>> round(float(power_with_arccos(1.0, np.ones(1), np.ones(1))[0]), 14)
    1.0
    """
    rest = np.sqrt(np.maximum((r - high) * (r + high), 0.0))
    angle = np.arctan2(rest, high) if k == 0.0 else arc_above(high / r, (rest / r) ** 2, k)
    return (high / r) ** n * angle + _half_beta(n, high / r, rest / r, k)


def power_with_arcsin(n: float, high: FloatArray, r: FloatArray, k: float = 0.0) -> FloatArray:
    """
    The integral int_0^h n t^(n-1) arcsin(t) dt, or its analogue for k, where h = high / r is at most 1 and n above 0.

    Examples
    --------
    >>> round(float(power_with_arcsin(1.0, np.ones(1), np.ones(1))[0]), 15) == round(0.5 * math.pi - 1.0, 15)
    True
    """
    rest = np.sqrt(np.maximum((r - high) * (r + high), 0.0))
    angle = np.arctan2(high, rest) if k == 0.0 else arc_below(high / r, (rest / r) ** 2, k)
    return (high / r) ** n * angle - _half_beta(n, high / r, rest / r, k)


def _half_beta(n: float, sine: FloatArray, cosine: FloatArray, k: float) -> FloatArray:
    """The integral cos(k pi/2) int_0^sine t^(n+k) (1 - t^2)^(-(1+k)/2) dt."""
    from scipy.special import beta, betainc, betaincc

    p, q = 0.5 * (n + 1.0 + k), 0.5 * (1.0 - k)
    part = np.where(sine < 0.7, betainc(p, q, sine * sine), betaincc(q, p, cosine * cosine))
    return np.asarray(0.5 * math.cos(0.5 * math.pi * k) * beta(p, q) * part)
