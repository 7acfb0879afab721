"""Compiled reader of tables of many functions. Loads numba."""

from __future__ import annotations

import math

import numpy as np

from pymdr import compiling
from pymdr.numerics.table import FIRST_TERM, KEY, START, WIDTH
from pymdr.units import FloatArray

_fused = compiling.Fused(__file__)
_BEFORE_NEXT = 1.0 - float(np.finfo(float).eps)


@_fused.inner
def cell_of(
    rows: FloatArray, first: int, count: int, segment: int, ends: tuple[float, float], x: float
) -> tuple[int, float]:
    """
    The cell of an argument in a segment.

    Parameters
    ----------
    rows : ndarray
        Packed cells from the row `first` on, `count` of them.
    ends : tuple of float
        Ends of the segment.

    Returns
    -------
    tuple
        Its row, and the argument of its Chebyshev terms.
    """
    low, high = ends
    v = math.sqrt(max(x - low, 0.0))
    v /= v + math.sqrt(max(high - x, 0.0))
    key = segment + min(v, _BEFORE_NEXT)
    lower, upper = first, first + count - 1
    while lower < upper:
        middle = (lower + upper + 1) >> 1
        if key >= rows[middle, KEY]:
            lower = middle
        else:
            upper = middle - 1
    u = (v - rows[lower, START]) * (2.0 / rows[lower, WIDTH]) - 1.0
    return lower, min(max(u, -1.0), 1.0)


@_fused.inner
def value_in(rows: FloatArray, cell: int, function: int, terms: int, u: float) -> float:
    """A function in a cell: the sum of its Chebyshev terms, by Clenshaw's recurrence."""
    begin = FIRST_TERM + function * terms
    last = before = 0.0
    for j in range(begin + terms - 1, begin, -1):
        last, before = rows[cell, j] + 2.0 * u * last - before, last
    return float(rows[cell, begin] + u * last - before)
