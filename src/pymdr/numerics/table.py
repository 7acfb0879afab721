"""Tables of functions of one variable: Chebyshev series on cells of smooth segments.

Half-integer powers at both ends of a segment become smooth by x = low + (high - low) v^2 / [v^2 + (1 - v)^2]; cells of v are
halved until the series converges on each.

NumPy reads many functions together, each accurate relative to its largest value on a cell. One positive rising function that kernels
read value by value, with its integrals and inverse and an accuracy relative to every value, is a :mod:`pymdr.numerics.graded` table.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pymdr.numerics.panels import IndexArray, nodes, to_coefficients
from pymdr.units import FloatArray

KEY, START, WIDTH, FIRST_TERM = range(4)
"""Columns of packed cells: segment + v at the beginning, v at the beginning, width in v, then the terms of one function after the other."""
_LEVELS = 48
_BLOCK = 8192
_GRADES = 12
_EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class Table:
    """Functions on segments of their variable, made by :func:`tabulated`."""

    low: FloatArray
    """Lower ends of the segments, shape (P,)."""
    high: FloatArray
    """Upper ends."""
    keys: FloatArray
    """Segment + v at the beginnings of the cells, rising, shape (C,)."""
    start: FloatArray
    """v at the beginnings of the cells."""
    width: FloatArray
    """Widths of the cells in v."""
    coefficients: FloatArray
    """Coefficients of T_0, T_1, ... in cells, shape (terms, functions, C); nan in unresolved cells."""

    @property
    def resolved(self) -> bool:
        """Whether the series converged on all cells."""
        return not np.isnan(self.coefficients[0]).any()

    def first_unresolved(self) -> tuple[int, float]:
        """Segment and start of the first unresolved cell."""
        cell = int(np.flatnonzero(np.isnan(self.coefficients[0]).any(axis=0))[0])
        segment = int(np.floor(self.keys[cell]))
        return segment, float(_place(self.low[segment], self.high[segment], self.start[cell]))

    def __call__(self, x: FloatArray, segment: IndexArray | None = None) -> FloatArray:
        """
        Evaluate the functions.

        Parameters
        ----------
        x : ndarray, shape (n,)
        segment : ndarray of int, optional
            The segment of every x; by default it is looked up in adjacent segments.

        Returns
        -------
        ndarray, shape (functions, n)
            nan in unresolved cells.
        """
        if segment is None:
            segment = np.clip(np.searchsorted(self.low, x, side="right") - 1, 0, self.low.size - 1)
        values = np.empty((self.coefficients.shape[1], x.size))
        for i in range(0, x.size, _BLOCK):
            part = slice(i, i + _BLOCK)
            self._block(x[part], segment[part], values[:, part])
        return values

    def at(self, x: float) -> list[float]:
        """The functions at one point, the same to the last bit, without arrays: a tenth of the time."""
        segment = max(bisect_right(self.low, x) - 1, 0)
        low, high = float(self.low[segment]), float(self.high[segment])
        v = math.sqrt(max(x - low, 0.0))
        v /= v + math.sqrt(max(high - x, 0.0))
        cell = bisect_right(self.keys, segment + min(v, 1.0 - _EPS)) - 1
        u = (v - float(self.start[cell])) * (2.0 / float(self.width[cell])) - 1.0
        u = min(max(u, -1.0), 1.0)
        values = []
        for first, *terms in self.coefficients[:, :, cell].T.tolist():
            last = before = 0.0
            for term in reversed(terms):
                last, before = term - before + 2.0 * u * last, last
            values.append(first - before + u * last)
        return values

    @property
    def packed(self) -> FloatArray:
        """The cells in rows, as compiled kernels read them."""
        series = self.coefficients.transpose(2, 1, 0).reshape(self.keys.size, -1)
        return np.column_stack([self.keys, self.start, self.width, series])

    def _block(self, x: FloatArray, segment: IndexArray, values: FloatArray) -> None:
        """Evaluate a block that stays in the cache."""
        v = np.sqrt(np.maximum(x - self.low[segment], 0.0))
        v /= v + np.sqrt(np.maximum(self.high[segment] - x, 0.0))
        cell = np.searchsorted(self.keys, segment + np.minimum(v, 1.0 - _EPS), side="right") - 1
        u = np.clip((v - self.start[cell]) * (2.0 / self.width[cell]) - 1.0, -1.0, 1.0)
        last, before = np.zeros(values.shape), np.zeros(values.shape)
        for terms in self.coefficients[:0:-1]:
            # b_j = c_j + 2 u b_(j+1) - b_(j+2), in place
            np.subtract(terms.take(cell, axis=1), before, out=before)
            before += 2.0 * u * last
            last, before = before, last
        np.subtract(self.coefficients[0].take(cell, axis=1), before, out=values)
        values += u * last


@dataclass(frozen=True)
class Effort:
    """Resolution of a table."""

    terms: int = 16
    tolerance: float = 1e-13
    """Largest last term of a series, relative to its largest term."""
    rounding: float = 0.0
    """Absolute rounding of the variable; its effect on the functions is not resolved."""
    narrow: float = 0.0
    """Width of a cell, relative to its segment, that is not divided further (a kink)."""
    most: int = 2000
    """Largest number of cells."""
    graded: bool = False
    """Whether the first segment is graded toward its lower end, for a small absolute error of small values."""


def tabulated(
    function: Callable[[FloatArray, IndexArray], FloatArray],
    low: FloatArray,
    high: FloatArray,
    effort: Effort | None = None,
) -> Table:
    """
    Tabulate functions on segments.

    Parameters
    ----------
    function : callable
        Of positions (n,) and their segments, returning values (functions, n); smooth inside a segment except for
        half-integer powers of the distance from its ends, where it is not evaluated.
    low, high : ndarray, shape (P,)
        Ends of the segments.
    effort : Effort, optional

    Examples
    --------
    >>> table = tabulated(lambda s, _: np.stack([np.sqrt(s), np.exp(s)]), np.zeros(1), np.full(1, 2.0))
    >>> bool(np.all(np.abs(table(np.array([0.3, 2.0])) / [[0.3**0.5, 2**0.5], [np.exp(0.3), np.exp(2.0)]] - 1) < 1e-12))
    True
    """
    effort = Effort() if effort is None else effort
    n, u, fit = effort.terms, nodes(effort.terms), to_coefficients(effort.terms)
    segment, start, width = _first_cells(low.size, effort.graded)
    done: list[tuple[IndexArray, FloatArray, FloatArray, FloatArray]] = []
    count = 0
    for level in range(_LEVELS):
        count += segment.size
        bottom, top = low[segment][:, None], high[segment][:, None]
        x = _place(bottom, top, start[:, None] + width[:, None] * u)
        x = np.clip(x, np.nextafter(bottom, top), np.nextafter(top, bottom))
        values = function(x.ravel(), np.repeat(segment, n)).reshape(-1, segment.size, n)
        series = values @ fit.T
        size, tail = (np.max(np.abs(part), axis=2) for part in (series, series[:, :, -2:]))
        fits = tail <= effort.tolerance * size
        if effort.rounding > 0.0:
            with np.errstate(divide="ignore", invalid="ignore"):
                steepest = np.max(np.abs(np.diff(values, axis=2) / np.diff(x, axis=1)), axis=2)
            fits |= ~(tail > effort.rounding * steepest)
        good = fits.all(axis=0) | (width <= effort.narrow)
        series[:, ~good] = np.nan
        good |= level == _LEVELS - 1 or count > effort.most
        done.append((segment[good], start[good], width[good], series[:, good]))
        segment, start, width = np.tile(segment[~good], 2), start[~good], np.tile(0.5 * width[~good], 2)
        start = np.append(start, start + width[: start.size])
        if segment.size == 0:
            break
    segment, start, width = (np.concatenate([part[i] for part in done]) for i in range(3))
    order = np.lexsort((start, segment))
    series = np.concatenate([part[3] for part in done], axis=1)[:, order]
    terms = np.ascontiguousarray(np.moveaxis(series, 2, 0))
    return Table(low, high, (segment + start)[order], start[order], width[order], terms)


def _first_cells(segments: int, graded: bool) -> tuple[IndexArray, FloatArray, FloatArray]:
    """The initial cells: one per segment, the first optionally graded toward its lower end."""
    segment, start, width = np.arange(segments), np.zeros(segments), np.ones(segments)
    if graded:
        octaves = 2.0 ** -np.arange(1.0, _GRADES + 1.0)
        segment = np.append(segment, np.zeros(_GRADES, dtype=np.intp))
        start, width = np.append(start, octaves), np.append(width, octaves)
        width[0] = octaves[-1]
    return segment, start, width


def _place(low: FloatArray, high: FloatArray, v: FloatArray) -> FloatArray:
    """Position x in a segment for the variable v."""
    return np.asarray(low + (high - low) * (v * v / (v * v + (1.0 - v) ** 2)))
