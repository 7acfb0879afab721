"""A line load as series on intervals and their punches, with fast sums at any point."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from pymdr.numerics.panels import basis, nodes, to_coefficients
from pymdr.units import FloatArray

if TYPE_CHECKING:
    from pymdr.interpretation.punch_kernel import Cells

_TERMS = 20
_RESOLVED = 3e-14
"""Ratio of the last terms of a series to its largest below which it is resolved."""
_NOTHING = 1e-16
"""Stress under an interval, over the typical stress, below which it is not resolved further."""
_SHORTEST = 1e-32
"""Width, over the loaded radius, of the interval at the end of a load that is not resolved further."""
_LEVELS = 130
_MOST = 4000
"""Largest number of intervals of a load."""


class Punches(NamedTuple):
    """Punches whose radii fill an interval; their density may have a root at its anchor, one of its ends."""

    anchor: float
    """In m."""
    extent: float
    """Distance in m from the anchor to the other end, negative if that lies below."""
    density: Callable[[FloatArray], FloatArray]
    """Weight per radius in Pa at distances in m from the anchor."""
    breaks: FloatArray | None = None
    """Rising distances in m, the ends included, between which the density is a polynomial; None of a density that is smooth, or has a root."""

    def parts(self) -> Sequence[Punches]:
        """The segments between its breaks."""
        if self.breaks is None:
            return (self,)
        return [
            Punches(self.anchor + low, high - low, partial(_shifted, self.density, low))
            for low, high in pairwise(self.breaks.tolist())
        ]


def _shifted(density: Callable[[FloatArray], FloatArray], low: float, above: FloatArray) -> FloatArray:
    """A density at distances from a place in m."""
    return density(low + above)


class _Sizes(NamedTuple):
    """The loaded radius in m, a typical stress in Pa, and the error of the load over that."""

    radius: float
    scale: float
    noise: float


def resolved(segments: Sequence[Punches], radius: float, scale: float, noise: float) -> Cells | None:
    """
    The intervals of a load.

    Parameters
    ----------
    radius : float
        The loaded radius in m.
    scale : float
        A typical stress in Pa.
    noise : float
        Error of the load over that.

    Returns
    -------
    Cells or None
        Lengths in the unit of :func:`unit_of` and weights over its typical stress; None where its density cannot be resolved.
    """
    from pymdr.interpretation.punch_kernel import Cells

    anchor, low, high, series = (
        np.concatenate(parts) for parts in _leaves(segments, _Sizes(radius, scale, noise))
    )
    if anchor.size == 0 or anchor.size > _MOST or np.isnan(series).any():
        return None
    order = np.lexsort((low, anchor + low))
    anchor, low, high, series = (values[order] for values in (anchor, low, high, series))
    _, w = _gauss()
    weights = 0.5 * (high - low)[:, None] * w * (series @ _values()[0].T)
    return Cells(*_tree((anchor, low, high), weights, series))


def _tree(
    intervals: tuple[FloatArray, FloatArray, FloatArray], weights: FloatArray, series: FloatArray
) -> tuple[np.ndarray, ...]:
    """The columns of a tree over intervals from left to right, given by anchors and ends counted from them; every node before its halves."""
    anchor, low, high = intervals
    spans: list[tuple[int, int]] = []
    halves: list[tuple[int, int]] = []
    height: list[int] = []

    def grow(first: int, last: int) -> int:
        own = len(spans)
        spans.append((first, last))
        halves.append((-1, -1))
        height.append(0)
        if last - first > 1:
            split = (first + last) // 2
            left, right = grow(first, split), grow(split, last)
            halves[own] = left, right
            height[own] = 1 + max(height[left], height[right])
        return own

    grow(0, anchor.size)
    (first, last), children, levels = np.array(spans).T, np.array(halves), np.array(height)
    last = last - 1
    # next to an anchor the radii themselves have no digits left
    shared = np.where(anchor[first] == anchor[last], anchor[first], 0.0)
    start, stop = (anchor[first] - shared) + low[first], (anchor[last] - shared) + high[last]
    x, leaf = _gauss()[0], levels == 0
    carried, terms = np.zeros((first.size, _TERMS)), np.zeros(first.size, dtype=int)
    own_series = np.tile(x, (first.size, 1))
    carried[leaf], own_series[leaf] = weights[first[leaf]], series[first[leaf]]
    size = np.abs(series)
    kept = size > 1e-17 * np.max(size, axis=1, keepdims=True)
    # the last term that is kept, at least the first
    kept[:, 0] = True
    terms[leaf] = _TERMS - np.argmax(kept[first[leaf], ::-1], axis=1)
    for level in range(1, int(levels[0]) + 1):
        own = np.flatnonzero(levels == level)
        centre, half = 0.5 * (start[own] + stop[own]), 0.5 * (stop[own] - start[own])
        for child in children[own].T:
            middle = (shared[child] - shared[own]) + (0.5 * (start[child] + stop[child]) - centre)
            at = (middle[:, None] + 0.5 * (stop - start)[child, None] * x) / half[:, None]
            carried[own] += np.einsum("nk,nkj->nj", carried[child], _interpolation(at))
    left, right = np.ascontiguousarray(children.T)
    return shared, start, stop, carried, own_series, terms, left, right


def _leaves(segments: Sequence[Punches], load: _Sizes) -> tuple[list[FloatArray], ...]:
    """Anchors, ends counted from them, and series of the intervals of all segments."""
    leaves: tuple[list[FloatArray], ...] = (
        [np.zeros(0)],
        [np.zeros(0)],
        [np.zeros(0)],
        [np.zeros((0, _TERMS))],
    )
    count, unit = 0, unit_of(load.radius)
    for segment in segments:
        low, high, series = _of_segment(segment, load)
        count += low.size
        if count > _MOST:
            return ([np.full(1, np.nan)],) * 3 + ([np.full((1, _TERMS), np.nan)],)
        low, high = low / unit, high / unit
        if segment.extent < 0.0:
            low, high, series = -high, -low, series * (-1.0) ** np.arange(_TERMS)
        values = np.full(low.size, segment.anchor / unit), low, high, series
        for parts, own in zip(leaves, values, strict=True):
            parts.append(own)
    return leaves


def unit_of(radius: float) -> float:
    """The power of 2 next to a radius in m; division by it is exact."""
    return math.ldexp(1.0, math.frexp(radius)[1])


def _of_segment(segment: Punches, load: _Sizes) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Ends of intervals as distances in m from the anchor, and their series over the typical stress."""
    ends = np.array([0.0, abs(segment.extent)]) if segment.breaks is None else segment.breaks
    low, high = ends[:-1], ends[1:]
    kept: list[tuple[FloatArray, FloatArray, FloatArray]] = []
    for _ in range(_LEVELS):
        at = low[:, None] + (high - low)[:, None] * nodes(_TERMS)
        series = segment.density(at.ravel()).reshape(at.shape) / load.scale @ to_coefficients(_TERMS).T
        largest = np.max(np.abs(series), axis=1)
        tail = np.max(np.abs(series[:, -2:]), axis=1)
        # closed forms grow as 1 / s at the axis, and elsewhere as 1 / sqrt(s - r)
        fraction = (high - low) / load.radius
        small = largest * (1.0 if segment.anchor == 0.0 else np.sqrt(fraction)) <= _NOTHING
        small |= fraction <= _SHORTEST
        done = (tail <= np.maximum(_RESOLVED * largest, load.noise)) | small
        kept.append((low[done], high[done], series[done]))
        low, high = low[~done], high[~done]
        if low.size == 0 or low.size > _MOST:
            break
        middle = 0.5 * (low + high)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    if low.size:
        kept.append((low, high, np.full((low.size, _TERMS), np.nan)))
    return tuple(np.concatenate(parts) for parts in zip(*kept, strict=True))  # type: ignore[return-value]


@lru_cache(maxsize=1)
def _gauss() -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of Gauss and Legendre on (-1, 1)."""
    x, w = np.polynomial.legendre.leggauss(_TERMS)
    return x, w


@lru_cache(maxsize=1)
def _values() -> tuple[FloatArray, FloatArray]:
    """Matrix from coefficients to values at the nodes, and its inverse."""
    matrix: FloatArray = np.asarray(chebyshev.chebvander(_gauss()[0], _TERMS - 1), dtype=float)
    return matrix, np.asarray(np.linalg.inv(matrix))


def _interpolation(x: FloatArray) -> FloatArray:
    """Lagrange's polynomials of the nodes at places, shape (..., nodes)."""
    return np.asarray(basis(0.5 * (x + 1.0), _TERMS) @ _values()[1])
