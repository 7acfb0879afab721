"""The monotone branches of a curve s -> D(s): all its folds, and tables that invert the rising branches.

Every piece between knots is mapped by s = p + (q - p) sin²(θ/2), which makes half-integer powers at its ends
smooth, and resolved by Chebyshev series on cells that are halved until the series has converged.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.units import FloatArray

_Function = Callable[[FloatArray], FloatArray]
_NODES = 14
_FINE = 4
_MOST_CELLS = 40_000
_TINY = float(np.finfo(float).tiny)
_EPS = float(np.finfo(float).eps)


def _chebyshev_points(n: int) -> FloatArray:
    return -np.cos(np.pi * (np.arange(n) + 0.5) / n)


def _chebyshev_fit(n: int) -> FloatArray:
    """Return the matrix from values at the points of the first kind to Chebyshev coefficients."""
    k = np.arange(n)
    fit = np.cos(np.outer(k, np.pi * (n - k - 0.5) / n)) * (2.0 / n)
    fit[0] *= 0.5
    return fit


_POINTS = _chebyshev_points(_NODES)
_FIT = _chebyshev_fit(_NODES)


def roots_of(
    function: Callable[..., FloatArray], low: FloatArray, high: FloatArray, *args: FloatArray
) -> FloatArray:
    """Return one root of function(x, *args) in every bracket, to rounding.

    Parameters
    ----------
    function : callable
        Of arrays x and `args`; of opposite sign (or zero) at the two ends of each bracket.
    low, high : ndarray
        Brackets, flat and of one length, as are `args`.

    Returns
    -------
    ndarray
        The roots.

    Raises
    ------
    ConvergenceError
        When a bracket holds no change of sign or does not close.

    Notes
    -----
    Chandrupatla (1997), from ``scipy.optimize.elementwise``.

    Examples
    --------
    >>> roots_of(lambda x, y: x**2 - y, np.zeros(2), np.full(2, 3.0), np.array([1.0, 4.0]))
    array([1., 2.])
    """
    if low.size == 0:
        return low.copy()
    from scipy.optimize import elementwise

    found = elementwise.find_root(function, (low, high), args=args)
    if not np.all(found.success):
        worst = int(np.flatnonzero(~found.success)[0])
        raise ConvergenceError(
            f"no root between {low[worst]!r} and {high[worst]!r} (last value {found.x[worst]!r})"
        )
    return np.asarray(found.x, dtype=np.float64)


def turning_points(
    slope: _Function, start: float, stop: float, knots: tuple[float, ...]
) -> tuple[FloatArray, list[bool]]:
    """Return start, all folds and stop of a curve, and whether it rises on each piece between them.

    Parameters
    ----------
    slope : callable
        D'(s); finite inside (start, stop) but perhaps at `knots`. Zero counts as not rising.
    start, stop : float
        Range of s.
    knots : tuple of float
        Values of s where the slope is not smooth.

    Returns
    -------
    ndarray, list of bool
        The turning points [n + 1], exact to rounding, and the n directions, which alternate.

    Raises
    ------
    ConvergenceError
        When the slope is not piecewise smooth.

    Examples
    --------
    >>> points, rising = turning_points(np.cos, 0.0, 6.0, ())
    >>> np.allclose(points, [0, np.pi / 2, 3 * np.pi / 2, 6]), rising
    (True, [True, False, True])
    """
    marks = np.array([start, *sorted({k for k in knots if start < k < stop}), stop])
    # the first piece is graded toward the start, whose features may be far smaller than the range
    graded = start + (marks[1] - start) * 8.0 ** -np.arange(20.0, 0.0, -1.0)
    edges = np.unique(np.concatenate([marks, graded]))
    low, high = edges[:-1], edges[1:]
    grid_low, grid_high = [], []
    fine = np.pi * (np.arange(_FINE * _NODES) + 0.5) / (_FINE * _NODES)
    to_fine = np.polynomial.chebyshev.chebvander(2.0 * fine / np.pi - 1.0, _NODES - 1)
    samples: list[tuple[FloatArray, FloatArray]] = []
    count = 0
    for _ in range(80):
        count += low.size
        if count > _MOST_CELLS:
            break
        theta = 0.5 * np.pi * (_POINTS + 1.0)
        s = low[:, None] + (high - low)[:, None] * np.sin(0.5 * theta) ** 2
        values = slope(s) * np.sin(theta)
        if not np.all(np.isfinite(values)):
            raise ConvergenceError(
                f"the slope of the curve is not finite at s = {s[~np.isfinite(values)][0]!r}"
            )
        series = values @ _FIT.T
        tail = np.max(np.abs(series[:, -3:]), axis=1)
        narrow = high - low <= 1e-13 * np.maximum(np.abs(low), np.abs(high))
        done = (tail <= 1e-9 * np.max(np.abs(series), axis=1)) | narrow
        at = low[done, None] + (high - low)[done, None] * np.sin(0.5 * fine) ** 2
        samples.append((at, series[done] @ to_fine.T))
        middle = 0.5 * (low + high)[~done]
        low, high = np.concatenate([low[~done], middle]), np.concatenate([middle, high[~done]])
        if low.size == 0:
            del grid_low, grid_high
            return _alternating(slope, marks, samples)
    raise ConvergenceError(
        f"the slope of the curve is not smooth near s = {low[0]!r}; give its kinks as knots (breakpoints)"
    )
