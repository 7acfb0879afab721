"""Functions of one variable that are asked for at very many places: Chebyshev series on cells of smooth pieces.

Half-integer powers at both ends of a piece are made smooth by x = low + (high - low) v^2 / [v^2 + (1 - v)^2]; cells of v are
halved until the series has converged on each.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pymdr.numerics.panels import IndexArray, nodes, to_coefficients
from pymdr.units import FloatArray

_LEVELS = 48
_BLOCK = 8192
_GRADES = 12
_EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class Table:
    """Functions on pieces of their variable; made by :func:`tabulated`."""

    low: FloatArray
    """Lower ends of the pieces, shape (P,)."""
    high: FloatArray
    """Upper ends."""
    keys: FloatArray
    """Piece + v at the beginnings of the cells, rising, shape (C,)."""
    start: FloatArray
    """v at the beginnings of the cells."""
    width: FloatArray
    """Widths of the cells in v."""
    coefficients: FloatArray
    """Of T_0, T_1, ... in cells, shape (terms, functions, C); nan where a cell was not resolved."""

    @property
    def resolved(self) -> bool:
        """Whether the series converged on all cells."""
        return not np.isnan(self.coefficients[0]).any()

    def first_unresolved(self) -> tuple[int, float]:
        """The piece, and the place in it, at which a cell begins that was not resolved."""
        cell = int(np.flatnonzero(np.isnan(self.coefficients[0]).any(axis=0))[0])
        piece = int(np.floor(self.keys[cell]))
        return piece, float(_place(self.low[piece], self.high[piece], self.start[cell]))

    def __call__(self, x: FloatArray, piece: IndexArray | None = None) -> FloatArray:
        """
        The functions at places.

        Parameters
        ----------
        x : ndarray, shape (n,)
        piece : ndarray of int, optional
            The piece of every place; by default pieces follow one another and are looked up.

        Returns
        -------
        ndarray, shape (functions, n)
            nan where they were not resolved.
        """
        if piece is None:
            piece = np.clip(np.searchsorted(self.low, x, side="right") - 1, 0, self.low.size - 1)
        answer = np.empty((self.coefficients.shape[1], x.size))
        for i in range(0, x.size, _BLOCK):
            part = slice(i, i + _BLOCK)
            self._block(x[part], piece[part], answer[:, part])
        return answer

    def _block(self, x: FloatArray, piece: IndexArray, answer: FloatArray) -> None:
        """Write a block that stays in the cache."""
        v = np.sqrt(np.maximum(x - self.low[piece], 0.0))
        v /= v + np.sqrt(np.maximum(self.high[piece] - x, 0.0))
        cell = np.searchsorted(self.keys, piece + np.minimum(v, 1.0 - _EPS), side="right") - 1
        u = np.clip((v - self.start[cell]) * (2.0 / self.width[cell]) - 1.0, -1.0, 1.0)
        for row, out in enumerate(answer):
            terms = self.coefficients[:, row]
            last, before = np.zeros(u.shape), np.zeros(u.shape)
            for term in terms[:0:-1]:
                # b_j = c_j + 2 u b_(j+1) - b_(j+2), in place
                np.subtract(term.take(cell), before, out=before)
                before += 2.0 * u * last
                last, before = before, last
            np.subtract(terms[0].take(cell), before, out=out)
            out += u * last


@dataclass(frozen=True)
class Effort:
    """How far functions are resolved."""

    terms: int = 16
    tolerance: float = 1e-13
    """Of the last terms of a series, in parts of its largest."""
    rounding: float = 0.0
    """Of the variable: what that makes of the functions is not resolved."""
    narrow: float = 0.0
    """Width of a cell, in parts of its piece, at which it stands for a kink and is not divided."""
    most: int = 2000
    """Cells that are tried."""
    graded: bool = False
    """Whether the first piece is divided toward its lower end at once, where a small state deserves a small absolute error."""


def tabulated(
    function: Callable[[FloatArray, IndexArray], FloatArray],
    low: FloatArray,
    high: FloatArray,
    effort: Effort | None = None,
) -> Table:
    """
    Tabulate functions on pieces.

    Parameters
    ----------
    function : callable
        From places (n,) and the pieces in which they lie to values (functions, n); smooth inside a piece but for
        half-integer powers of the distance from its ends, and not asked at the ends.
    low, high : ndarray, shape (P,)
        Ends of the pieces.
    effort : Effort, optional

    Returns
    -------
    Table

    Examples
    --------
    >>> table = tabulated(lambda s, _: np.stack([np.sqrt(s), np.exp(s)]), np.zeros(1), np.full(1, 2.0))
    >>> bool(np.all(np.abs(table(np.array([0.3, 2.0])) / [[0.3**0.5, 2**0.5], [np.exp(0.3), np.exp(2.0)]] - 1) < 1e-12))
    True
    """
    effort = Effort() if effort is None else effort
    n, u, fit = effort.terms, nodes(effort.terms), to_coefficients(effort.terms)
    piece, start, width = _begun(low.size, effort.graded)
    done: list[tuple[IndexArray, FloatArray, FloatArray, FloatArray]] = []
    count = 0
    for level in range(_LEVELS):
        count += piece.size
        bottom, top = low[piece][:, None], high[piece][:, None]
        x = _place(bottom, top, start[:, None] + width[:, None] * u)
        x = np.clip(x, np.nextafter(bottom, top), np.nextafter(top, bottom))
        values = function(x.ravel(), np.repeat(piece, n)).reshape(-1, piece.size, n)
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
        done.append((piece[good], start[good], width[good], series[:, good]))
        piece, start, width = np.tile(piece[~good], 2), start[~good], np.tile(0.5 * width[~good], 2)
        start = np.append(start, start + width[: start.size])
        if piece.size == 0:
            break
    piece, start, width = (np.concatenate([part[i] for part in done]) for i in range(3))
    order = np.lexsort((start, piece))
    whole = np.concatenate([part[3] for part in done], axis=1)[:, order]
    terms = np.ascontiguousarray(np.moveaxis(whole, 2, 0))
    return Table(low, high, (piece + start)[order], start[order], width[order], terms)


def _begun(pieces: int, graded: bool) -> tuple[IndexArray, FloatArray, FloatArray]:
    """The first cells: a piece each, the first of them divided toward its lower end."""
    piece, start, width = np.arange(pieces), np.zeros(pieces), np.ones(pieces)
    if graded:
        octaves = 2.0 ** -np.arange(1.0, _GRADES + 1.0)
        piece = np.append(piece, np.zeros(_GRADES, dtype=np.intp))
        start, width = np.append(start, octaves), np.append(width, octaves)
        width[0] = octaves[-1]
    return piece, start, width


def _place(low: FloatArray, high: FloatArray, v: FloatArray) -> FloatArray:
    """The place in a piece at which the variable is v."""
    return np.asarray(low + (high - low) * (v * v / (v * v + (1.0 - v) ** 2)))
