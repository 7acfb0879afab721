"""The Abel integrals of a resolved slope: three integrals over f' at given places of the line.

They are computed together, each a sum of terms of one sign where f' has one sign,

    g(x) = x int_0^x f' / sqrt(x^2 - r^2) dr,
    m(x) = int_0^x t g' dt = int_0^x f' r^2 / sqrt(x^2 - r^2) dr,
    g'(x) = int_0^x (r f')' / sqrt(x^2 - r^2) dr + sum over kinks b of jump b / sqrt(x^2 - b^2).

Quarter octaves far below x enter by their moments, other panels by Gauss nodes, tree nodes by interpolation, and panels
adjacent to x by rules that remove the square root. Differences x - r are formed from offsets, which avoids cancellation
next to a breakpoint.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np
import scipy

from pymdr.mapping.octave_panels import (
    FAR_STEPS,
    GAUSS_NODES,
    accumulated_moments,
    is_quarter_octave,
    pair,
    sums_from_below,
    sums_on_octave_panels,
)
from pymdr.mapping.resolving import Slopes
from pymdr.mapping.slopes import Tail
from pymdr.mapping.tree_levels import POINTS, TreeLevel, levels_of, with_slope, with_tail
from pymdr.numerics.panels import TERMS, BoolArray, IndexArray, Panels, Series, basis, basis_slope
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

if TYPE_CHECKING:
    from pymdr.mapping.tree import Tree

_LEAF_GAP, _NODE_GAP = 0.5, 1.0
"""Least distance at which a panel or a tree node acts by its points, over its width."""
_WORK = 1 << 17
_CACHED = 1 << 15
"""Size of arrays that are reused many times."""
_MANY = 2000


@dataclass(frozen=True)
class Sums:
    """g, its first moment and its slope at some places, each of the shape of the places."""

    g: FloatArray
    moment: FloatArray
    slope: FloatArray


class AbelSums:
    """
    The Abel integrals of a resolved slope.

    Parameters
    ----------
    slopes : Slopes
        f' on panels.
    tail : Tail
        The power law below the first panel.
    """

    exponent: float = 0.0
    """k of the kernel (x^2 - r^2)^((k - 1) / 2)."""

    def __init__(self, slopes: Slopes, tail: Tail) -> None:
        self.slopes = slopes
        self.tail = tail
        odd = ~(is_quarter_octave(slopes.panels) & (slopes.series.power == 0.0))
        self.octave_count = int(np.argmax(odd)) if odd.any() else odd.size
        """Number of leading panels that are quarter octaves without a power; 0 if too few."""
        if self.octave_count < FAR_STEPS:
            self.octave_count = 0
        self.first = max(self.octave_count - FAR_STEPS + 1, 0)
        """The first panel that never acts by its moments."""

    @cached_property
    def below(self) -> FloatArray:
        """Moments of the quarter octaves."""
        return accumulated_moments(
            self.slopes.series.coefficients[: self.octave_count], self.tail.slope, self.tail.power
        )

    @cached_property
    def levels(self) -> list[TreeLevel]:
        """The tree of the panels that do not act by moments."""
        leaves = self._leaves(self.first)
        return levels_of(leaves if self.octave_count else with_tail(leaves, self.tail))

    @cached_property
    def _tree(self) -> Tree | None:
        """The compiled tree of all panels; None with graded kernels, jumps or fractional powers."""
        from pymdr.mapping.tree import Tree

        series = self.slopes.series
        if self.exponent != 0.0 or self.slopes.jump.any() or _is_fractional(self.slopes.panels, series).any():
            return None
        levels = levels_of(with_tail(self._leaves(0), self.tail))

        def together(name: str) -> FloatArray:
            parts = [getattr(level, name) for level in levels]
            if parts[0].ndim == 2:
                # points without a strength
                parts[0] = np.pad(parts[0], ((0, 0), (0, POINTS - parts[0].shape[1])))
            return np.concatenate(parts)

        base, low, high, offset, f, rate = map(together, ("base", "low", "high", "offset", "slope", "rate"))
        counts = [level.base.size for level in levels]
        gap = np.repeat([_LEAF_GAP] + [_NODE_GAP] * (len(levels) - 1), counts) * (high - low)
        sources = np.stack([f, f * (base[:, None] + offset) ** 2, rate])
        # the tail, the first leaf, has no series and is never adjacent
        coefficients, power = np.pad(series.coefficients, ((1, 0), (0, 0))), np.append(0.0, series.power)
        return Tree(np.cumsum([0, *counts]), base, low, high, gap, offset, sources, coefficients, power)

    def _leaves(self, first: int) -> TreeLevel:
        """The panels from one on."""
        panels, series = self.slopes.panels.take(slice(first, None)), self.slopes.series
        index = np.arange(first, series.power.size)
        u, weights = gauss(TERMS)
        offset = panels.offsets(u)
        f, rate = self._values(index, offset)
        width = panels.width[:, None] * weights
        offset_rate = offset
        f, rate = f * width, rate * width
        fractional = np.flatnonzero(_is_fractional(panels, series.take(index)))
        if fractional.size:
            offset_rate = offset.copy()
        for i in fractional:
            offset[i], f[i], offset_rate[i], rate[i] = self._fractional_leaf(int(index[i]))
        jump = self.slopes.jump[first:]
        if jump.any():
            # a jump of f' is a point source of (r f')' at its breakpoint
            offset_rate = np.column_stack([np.zeros(jump.size), offset_rate])
            rate = np.column_stack([jump * panels.base, rate])
        return TreeLevel(panels.base, panels.low, panels.high, offset, f, offset_rate, rate)

    def _fractional_leaf(self, i: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        high, p = float(self.slopes.panels.high[i]), float(self.slopes.series.power[i])
        s, w = gauss(TERMS, p)
        s_rate, w_rate = gauss(TERMS, p - 1.0)
        f, _ = self._regular(i, high * s)
        _, rate = self._regular(i, high * s_rate)
        return high * s, high * w * f, high * s_rate, high * w_rate * rate

    def _regular(self, i: int, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        """F' / y^p and (r f')' / y^(p-1) with y = offset / high, on a panel that begins at a breakpoint."""
        panels, series = self.slopes.panels, self.slopes.series
        high, p = panels.high[i], series.power[i]
        y = offset / high
        c = basis(y.ravel()) @ series.coefficients[i]
        rate = basis_slope(y.ravel()) @ series.coefficients[i] / high
        c, rate = c.reshape(y.shape), rate.reshape(y.shape)
        return c, c * y + (panels.base[i] + offset) * (p * c / high + y * rate)

    def _values(self, index: IndexArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        """F' and (r f')' in some panels, shape (n,), at offsets of shape (n, ...)."""
        panels, series = self.slopes.panels.take(index), self.slopes.series.take(index)
        delta = offset.reshape(index.size, -1)
        width, power = panels.width[:, None], series.power[:, None]
        u = ((delta - panels.low[:, None]) / width).clip(0.0, 1.0)
        c, rate = with_slope(series.coefficients, u)
        value, curvature = c, rate / width
        if power.any():
            with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
                factor = np.where(power != 0.0, (delta / panels.high[:, None]) ** power, 1.0)
                curvature = factor * (curvature + np.where(power != 0.0, power * c / delta, 0.0))
                value = c * factor
        flux = value + (panels.base[:, None] + delta) * curvature
        return value.reshape(offset.shape), flux.reshape(offset.shape)

    def sums(self, panels: Panels, u: FloatArray) -> Sums:
        """
        g, m and g' on panels.

        Parameters
        ----------
        panels : Panels
            Shape (T,).
        u : ndarray, shape (k,)
            Values of the variable on every panel.

        Returns
        -------
        Sums
            Of shape (T, k).
        """
        base, offset = panels.base, panels.offsets(u)
        totals = np.zeros((3, *offset.shape))
        x = base[:, None] + offset
        own, whole = self._octave_panel_of(panels)
        source = self.slopes.panels
        if whole.any():
            coefficients = self.slopes.series.coefficients
            totals[:, whole] = sums_on_octave_panels(
                coefficients, source.low, self.below, own[whole], tuple(u.tolist())
            )
        within = np.flatnonzero((own >= 0) & ~whole)
        if within.size:
            # a part of a quarter octave
            at = own[within]
            totals[:, within] = sums_from_below(self.below[at - FAR_STEPS], source.low[at], x[within])
            stop = np.searchsorted(source.start, panels.stop[within])
            adjacent = [np.arange(i - FAR_STEPS + 1, j) for i, j in zip(at, stop, strict=True)]
            target = np.repeat(within, [part.size for part in adjacent])
            self._add_near(totals, base, offset, target, np.concatenate(adjacent))
        beyond = np.flatnonzero(own < 0)
        if beyond.size and source.count > _MANY and self._tree is not None:
            from pymdr.mapping.tree import act

            rising = beyond[np.lexsort((panels.low[beyond], base[beyond]))]
            totals[:, rising] = act(self._tree, base[rising], offset[rising])
        elif beyond.size:
            if self.octave_count:
                end = np.full(beyond.size, source.high[self.octave_count - 1])
                below = np.broadcast_to(self.below[-1], (beyond.size, *self.below.shape[1:]))
                totals[:, beyond] = sums_from_below(below, end, x[beyond])
            self._add_tree(totals, panels, u, beyond)
        g, moment, slope = totals
        return Sums(x * g, moment, slope)

    def _octave_panel_of(self, panels: Panels) -> tuple[IndexArray, BoolArray]:
        """Index of the quarter octave, from the ninth on, in which a panel begins, else -1; and whether both are equal."""
        low, high = (end[: self.octave_count] for end in (self.slopes.panels.low, self.slopes.panels.high))
        at = np.searchsorted(low, panels.low, side="right") - 1
        inside = (panels.base == 0.0) & (at >= FAR_STEPS)
        inside[inside] = panels.low[inside] < high[at[inside]]
        at = np.where(inside, at, -1)
        whole = inside.copy()
        own = at[inside]
        whole[inside] = (panels.low[inside] == low[own]) & (panels.high[inside] == high[own])
        return at, whole

    def _add_tree(self, totals: FloatArray, panels: Panels, u: FloatArray, target: IndexArray) -> None:
        """Add the integrals over all panels that do not act by moments."""
        base, offset = panels.base, panels.offsets(u)
        node = np.zeros(target.size, dtype=np.intp)
        lowest, highest = offset.min(axis=1), offset.max(axis=1)
        for level in range(len(self.levels) - 1, -1, -1):
            sources = self.levels[level]
            shift = base[target] - sources.base[node]
            below = shift + highest[target] > sources.low[node]
            target, node, shift = target[below], node[below], shift[below]
            gap = _NODE_GAP if level else _LEAF_GAP
            width = sources.high[node] - sources.low[node]
            far = shift + lowest[target] - sources.high[node] >= gap * width
            self._add_far(totals, sources, base, offset, target[far], node[far])
            target, node = target[~far], node[~far]
            if level:
                twice = np.concatenate([2 * node, 2 * node + 1])
                known = twice < self.levels[level - 1].base.size
                target, node = np.concatenate([target, target])[known], twice[known]
        # the tail, a leaf without quarter octaves, is never adjacent
        source = node + self.first - (self.octave_count == 0)
        target, source = target[source >= 0], source[source >= 0]
        self._add_jumps(totals[2], base, offset, target, source)
        self._add_adjacent(totals, panels, u, target, source)

    def _add_adjacent(
        self, totals: FloatArray, panels: Panels, u: FloatArray, target: IndexArray, source: IndexArray
    ) -> None:
        """Add the integrals over panels at adjacent targets, or at the panels themselves."""
        for add in (self._add_octave_pairs, self._add_own):
            done = add(totals, panels, u, target, source)
            target, source = target[~done], source[~done]
        self._add_near(totals, panels.base, panels.offsets(u), target, source)

    def _add_far(
        self,
        totals: FloatArray,
        sources: TreeLevel,
        base: FloatArray,
        offset: FloatArray,
        target: IndexArray,
        node: IndexArray,
    ) -> None:
        block = max(1, _WORK // (offset.shape[1] * sources.offset.shape[1]))
        same = sources.offset is sources.offset_rate
        for start in range(0, target.size, block):
            t, c = target[start : start + block], node[start : start + block]
            b, place = sources.base[c], offset[t]
            shift = (base[t] - b)[:, None] + place
            x = base[t][:, None] + place
            kernel = self._kernel(shift, x, b, sources.offset[c])
            r = b[:, None] + sources.offset[c]
            f = sources.slope[c]
            parts = [
                np.einsum("ijk,ik->ij", kernel, f),
                np.einsum("ijk,ik->ij", kernel, f * r * r),
            ]
            if not same:
                kernel = self._kernel(shift, x, b, sources.offset_rate[c])
            parts.append(np.einsum("ijk,ik->ij", kernel, sources.rate[c]))
            for total, part in zip(totals, parts, strict=True):
                np.add.at(total, t, part)

    def _add_jumps(
        self, total: FloatArray, base: FloatArray, offset: FloatArray, target: IndexArray, source: IndexArray
    ) -> None:
        """Add the terms of jumps of f' at the lower ends of panels to g' on targets nearby."""
        jumping = self.slopes.jump[source] != 0.0
        target, source = target[jumping], source[jumping]
        b, jump = self.slopes.panels.base[source, None], self.slopes.jump[source, None]
        distance = (base[target, None] - b) + offset[target]
        beyond = distance > 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            term = jump * b / self._root(distance * (2.0 * b + distance))
        np.add.at(total, target, np.where(beyond, term, 0.0))

    def _add_octave_pairs(
        self, totals: FloatArray, targets: Panels, u: FloatArray, target: IndexArray, source: IndexArray
    ) -> BoolArray:
        """Add the integrals between adjacent quarter octaves by their common table; return the mask of these pairs."""
        panels, series = self.slopes.panels, self.slopes.series
        plain = is_quarter_octave(panels) & (series.power == 0.0)
        regular: BoolArray = is_quarter_octave(targets)[target] & plain[source]
        t, s = target[regular], source[regular]
        low = panels.low[s]
        steps = np.round(4.0 * np.log2(targets.low[t] / low)).astype(int)
        for j in np.unique(steps).tolist():
            here = steps == j
            c, scale = series.coefficients[s[here]], low[here][:, None] ** 2
            for k, matrix in enumerate(pair(j, tuple(u.tolist()))):
                part = c @ matrix
                np.add.at(totals[k], t[here], part * scale if k == 1 else part)
        return regular

    def _add_own(
        self, totals: FloatArray, targets: Panels, u: FloatArray, target: IndexArray, source: IndexArray
    ) -> BoolArray:
        """Add the integrals of panels that begin at a breakpoint at themselves; return the mask of these pairs."""
        panels, series = self.slopes.panels, self.slopes.series
        own = targets.begins[target] & targets.rooted[target] & panels.begins[source]
        own &= (targets.base[target] == panels.base[source]) & (targets.high[target] == panels.high[source])
        own &= series.power[source] == 0.0
        target, source = target[own], source[own]
        weights = gauss(GAUSS_NODES)[1]
        at, value, rate = _own_rule(tuple(u.tolist()))
        block = max(1, _CACHED // at.size)
        for start in range(0, target.size, block):
            t, i = target[start : start + block], source[start : start + block]
            c, b, high = series.coefficients[i], panels.base[i, None, None], panels.high[i, None, None]
            r, place = high * at, high * (u * u)[:, None]
            kernel = 2.0 * np.sqrt(high) * u[:, None] * weights / np.sqrt(2.0 * b + place + r)
            f = (c @ value).reshape(r.shape) * kernel
            steep = (c @ rate).reshape(r.shape) / high * kernel
            for total, part in zip(totals, (f, f * (b + r) ** 2, f + (b + r) * steep), strict=True):
                np.add.at(total, t, part.sum(axis=-1))
        return own

    def _add_near(
        self, totals: FloatArray, base: FloatArray, offset: FloatArray, target: IndexArray, source: IndexArray
    ) -> None:
        panels = self.slopes.panels
        fractional = _is_fractional(panels, self.slopes.series)[source]
        for t, s in zip(target[fractional].tolist(), source[fractional].tolist(), strict=True):
            for total, part in zip(totals, self._fractional_near(base[t], offset[t], s), strict=True):
                total[t] += part
        target, source = target[~fractional], source[~fractional]
        block = max(1, _CACHED // (offset.shape[1] * GAUSS_NODES))
        for start in range(0, target.size, block):
            t, s = target[start : start + block], source[start : start + block]
            shift = (base[t] - panels.base[s])[:, None]
            parts = self._through_root(shift, offset[t], s, panels.low[s][:, None], panels.high[s][:, None])
            for total, part in zip(totals, parts, strict=True):
                np.add.at(total, t, part)

    def _through_root(
        self, shift: FloatArray, offset: FloatArray, source: IndexArray, low: FloatArray, high: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Integrals over low <= r - b <= high and r < x by r = x - v^2, shape of `offset`; x - b = shift + offset."""
        s, weights = gauss(GAUSS_NODES)
        # next to the end of a panel the distance is computed from offsets
        beyond = (shift - high) + offset
        near = np.sqrt(np.maximum(beyond, 0.0))
        far = np.sqrt(np.maximum((shift - low) + offset, 0.0))
        v = near[..., None] + (far - near)[..., None] * s
        place = shift + offset
        r = np.clip(place[..., None] - v * v, low[..., None], high[..., None])
        b = self.slopes.panels.base[source][:, None, None]
        f, rate = self._values(source, r)
        kernel = 2.0 * (far - near)[..., None] * weights / np.sqrt(2.0 * b + place[..., None] + r)
        f = f * kernel
        return f.sum(axis=-1), (f * (b + r) ** 2).sum(axis=-1), (rate * kernel).sum(axis=-1)

    def _fractional_near(
        self, base: float, offset: FloatArray, source: int
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """As above for one panel on which f' begins with a fractional power at a breakpoint."""
        panels, series = self.slopes.panels, self.slopes.series
        b, high, p = float(panels.base[source]), float(panels.high[source]), float(series.power[source])
        place = (base - b) + offset
        parts = np.zeros((3, offset.size))
        inside = (place > 0.0) & (place <= high)
        at = place[inside][:, None]
        gain = 0.5 * (1.0 + self.exponent)
        for exponent, rows in ((p, (0, 1)), (p - 1.0, (2,))):
            y, w = _doubly_singular(exponent, gain)
            r = at * y
            f, rate = self._regular(source, r)
            value = rate if rows == (2,) else f
            factor = (at / high) ** exponent * at**gain / self._root(2.0 * b + at + r) * w
            parts[rows[0], inside] = (value * factor).sum(axis=1)
            if rows == (0, 1):
                parts[1, inside] = (value * factor * (b + r) ** 2).sum(axis=1)
        beyond = place > high
        if beyond.any():
            at = place[beyond]
            half = np.full((1, 1), 0.5 * high)
            shift = np.full((1, 1), base - b)
            upper = self._through_root(
                shift, offset[None, beyond], np.array([source]), half, np.full((1, 1), high)
            )
            parts[:, beyond] = np.array([part[0] for part in upper])
            for exponent, rows in ((p, (0, 1)), (p - 1.0, (2,))):
                y, w = gauss(TERMS, exponent)
                r = 0.5 * high * y
                f, rate = self._regular(source, r)
                value = 0.5**exponent * 0.5 * high * w * (rate if rows == (2,) else f)
                kernel = 1.0 / self._root((at[:, None] - r) * (2.0 * b + at[:, None] + r))
                parts[rows[0], beyond] += kernel @ value
                if rows == (0, 1):
                    parts[1, beyond] += kernel @ (value * (b + r) ** 2)
        return parts[0], parts[1], parts[2]

    def jump_error(self, base: FloatArray, offset: FloatArray) -> FloatArray:
        """Error of g' on panels, shape of `offset` (T, k), from the errors of the jumps of f'."""
        slopes = self.slopes
        size = np.maximum(slopes.size, np.append(0.0, slopes.size[:-1]))
        rough = np.flatnonzero(slopes.jump_error + slopes.blur > 16.0 * np.finfo(float).eps * size)
        total = np.zeros(offset.shape)
        panels = slopes.panels.take(rough)
        places = panels.base, panels.low, panels.width, slopes.jump_error[rough], slopes.blur[rough]
        for start, low, width, error, blur in zip(*(values.tolist() for values in places), strict=True):
            beyond = np.flatnonzero((base - start) + (offset[:, -1] - low) > 0.0)
            distance = (base[beyond] - start)[:, None] + (offset[beyond] - low)
            b = start + low
            with np.errstate(divide="ignore", invalid="ignore"):
                effect = error + blur * np.minimum(width / distance, 1.0)
                term = effect * b / self._root(distance * (2.0 * b + distance))
            total[beyond] += np.where(distance > 0.0, term, 0.0)
        return total

    def spread_error(self, base: FloatArray, offset: FloatArray) -> FloatArray:
        """Error of g at places on panels, shape of `offset` (T, k), from the measured errors of f'."""
        panels, slopes = self.slopes.panels, self.slopes
        # with many panels only errors above rounding count
        least = 8.0 * np.finfo(float).eps * slopes.size if slopes.size.size > _MANY else 0.0
        rough = np.flatnonzero(slopes.error > least)
        total = np.full(offset.size, self.tail.error)
        bases, offsets = np.repeat(base, offset.shape[1])[:, None], offset.reshape(-1, 1)
        x = bases + offsets
        for start in range(0, rough.size, 4096):
            i = rough[start : start + 4096]
            # adjacent panels share their ends
            covered = slice(int(i[0]), int(i[-1]) + 1)
            edge_base = np.append(panels.base[covered], panels.base[i[-1]])
            edge_offset = np.append(panels.low[covered], panels.high[i[-1]])
            # next to a breakpoint only the offsets keep all digits
            angle = offsets - edge_offset
            if base.any() or edge_base.any():
                angle += bases - edge_base
            np.maximum(angle, 0.0, out=angle)
            steep = np.flatnonzero(panels.begins[i] & (slopes.series.power[i] > 0.0))
            # the error of a panel that begins with a power is relative to that power
            onset = (
                np.minimum(angle[:, i[steep] - i[0]] / panels.high[i[steep]], 1.0)
                ** slopes.series.power[i[steep]]
            )
            angle /= x
            fraction = np.diff(self._fraction_above(angle))[:, i - i[0]]
            fraction[:, steep] *= onset
            total -= x[:, 0] * (fraction @ slopes.error[i])
        return total.reshape(offset.shape)

    def _kernel(self, shift: FloatArray, x: FloatArray, base: FloatArray, offset: FloatArray) -> FloatArray:
        """1 / sqrt(x^2 - r^2), shape (pairs, places, nodes)."""
        answer = shift[:, :, None] - offset[:, None, :]
        answer *= x[:, :, None] + (base[:, None] + offset)[:, None, :]
        answer = self._root(answer)
        return np.divide(1.0, answer, out=answer)

    def _root(self, square: FloatArray) -> FloatArray:
        """Denominator of the kernel from x^2 - r^2."""
        return np.sqrt(square)

    def _fraction_above(self, distance: FloatArray) -> FloatArray:
        """The integral of the kernel for x = 1 over radii nearer than a distance."""
        # half of the angle whose cosine is r / x
        return np.asarray(2.0 * np.arcsin(np.sqrt(0.5 * distance)))


def _is_fractional(panels: Panels, series: Series) -> BoolArray:
    return np.asarray((panels.low == 0.0) & (series.power != 0.0) & (series.power != np.round(series.power)))


@lru_cache(maxsize=2)
def _own_rule(u: tuple[float, ...]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Offsets from a breakpoint up to those at points u of a rooted panel, in its width, and the basis there."""
    s, _ = gauss(GAUSS_NODES)
    at = np.square(u)[:, None] * ((1.0 - s) * (1.0 + s))
    return at, basis(at.ravel()).T, basis_slope(at.ravel()).T


@lru_cache(maxsize=64)
def _doubly_singular(exponent: float, gain: float) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights on [0, 1] for the weight y^exponent (1 - y)^(gain - 1)."""
    z, w = scipy.special.roots_jacobi(GAUSS_NODES, gain - 1.0, exponent)
    return (z + 1.0) / 2.0, w / 2.0 ** (exponent + gain)
