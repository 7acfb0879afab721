"""Functions along a curve of states, tabulated where very many states are asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pymdr.units import FloatArray

_NODES, _LEVELS, _MOST = 16, 48, 2000
_SETTLED = 1e-13
_POINTS = -np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES)
_FIT = np.linalg.inv(np.polynomial.chebyshev.chebvander(_POINTS, _NODES - 1))


@dataclass(frozen=True)
class Table:
    """Functions of a parameter s between knots, as Chebyshev series in theta of s = low + (high - low) sin^2(theta/2)."""

    marks: FloatArray
    """Ends of the stretches in m."""
    keys: FloatArray
    """Stretch + theta / pi at the start of every cell, rising."""
    half: FloatArray
    """Half widths of the cells in theta / pi."""
    series: FloatArray
    """(terms, functions, cells); nan where a cell was not resolved."""

    def __call__(self, s: FloatArray) -> FloatArray:
        """The functions at parameters, shape (functions, n); nan where they were not resolved."""
        stretch = np.clip(np.searchsorted(self.marks, s, side="right") - 1, 0, self.marks.size - 2)
        low, high = self.marks[stretch], self.marks[stretch + 1]
        share = 2.0 / np.pi * np.arctan2(np.sqrt(s - low), np.sqrt(high - s))
        key = stretch + np.minimum(share, 1.0 - 1e-16)
        cell = np.searchsorted(self.keys, key, side="right") - 1
        x = np.clip((stretch + share - self.keys[cell]) / self.half[cell] - 1.0, -1.0, 1.0)
        one, two = np.zeros((self.series.shape[1], s.size)), np.zeros((self.series.shape[1], s.size))
        for term in self.series[:0:-1]:
            one, two = term[:, cell] + 2.0 * x * one - two, one
        return np.asarray(self.series[0][:, cell] + x * one - two)


def tabulated(
    function: Callable[[FloatArray], FloatArray], low: float, high: float, knots: tuple[float, ...]
) -> Table:
    """
    A table of functions, each resolved to 1e-13 of its largest value on every cell.

    Parameters
    ----------
    function : callable
        From parameters (n,) to values (functions, n), smooth between the knots but for half-integer powers there.
    low, high : float
        Range of the parameter in m.
    knots : tuple of float
        Parameters in m where the functions are not smooth.

    Returns
    -------
    Table

    Examples
    --------
    >>> table = tabulated(lambda s: np.stack([np.sqrt(s), np.exp(s)]), 0.0, 2.0, ())
    >>> bool(np.all(np.abs(table(np.array([0.3, 2.0])) / [[0.3**0.5, 2**0.5], [np.exp(0.3), np.exp(2.0)]] - 1) < 1e-12))
    True
    """
    marks = np.array([low, *sorted({k for k in knots if low < k < high}), high])
    owner = np.arange(marks.size - 1)
    begin, end = np.zeros(owner.size), np.ones(owner.size)
    found: list[tuple[FloatArray, ...]] = []
    count = 0
    for level in range(_LEVELS):
        count += owner.size
        half = 0.5 * (end - begin)
        angle = 0.5 * np.pi * (begin[:, None] + half[:, None] * (_POINTS + 1.0))
        bottom, top = marks[owner][:, None], marks[owner + 1][:, None]
        s = np.clip(
            bottom + (top - bottom) * np.sin(angle) ** 2, np.nextafter(bottom, top), np.nextafter(top, bottom)
        )
        values = function(s.ravel()).reshape(-1, owner.size, _NODES)
        series = values @ _FIT.T
        size = np.max(np.abs(series), axis=2)
        good = np.all(np.max(np.abs(series[:, :, -2:]), axis=2) <= _SETTLED * size, axis=0)
        last = level == _LEVELS - 1 or count > _MOST
        series[:, ~good] = np.nan
        done = good | last
        found.append((owner[done] + begin[done], half[done], series[:, done]))
        owner, begin, end = owner[~done], begin[~done], end[~done]
        if owner.size == 0:
            break
        middle = 0.5 * (begin + end)
        owner, begin, end = np.tile(owner, 2), np.append(begin, middle), np.append(middle, end)
    keys, half = (np.concatenate([part[i] for part in found]) for i in range(2))
    order = np.argsort(keys)
    whole = np.concatenate([part[2] for part in found], axis=1)[:, order]
    return Table(marks, keys[order], half[order], np.ascontiguousarray(np.moveaxis(whole, 2, 0)))
