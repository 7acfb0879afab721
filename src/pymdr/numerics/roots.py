"""Roots and boundaries of functions of one variable, for arrays of them, to rounding."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymdr.errors import ConvergenceError
from pymdr.units import FloatArray

_HALVINGS = 64


def roots_of(
    function: Callable[..., FloatArray], low: FloatArray, high: FloatArray, *args: NDArray[Any]
) -> FloatArray:
    """
    Find one root of function(x, *args) in every bracket, elementwise.

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
    Chandrupatla (1997), from ``scipy.optimize.elementwise``; its tolerance is relative to the root, so a
    nanometre is found as exactly as a metre.

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
            f"no root between {float(low[worst])!r} and {float(high[worst])!r} (last value {float(found.x[worst])!r})"
        )
    return np.asarray(found.x, dtype=np.float64)


def rising_root(
    curve: Callable[[FloatArray], FloatArray], target: ArrayLike, low: ArrayLike, high: ArrayLike
) -> FloatArray:
    """
    Solve curve(x) = target for a rising curve inside a bracket, for arrays, to rounding error.

    Parameters
    ----------
    curve : callable
        Rising, on arrays.
    target, low, high : array_like
        Values and brackets, broadcast together.

    Returns
    -------
    ndarray

    Raises
    ------
    ConvergenceError
        If a root is not inside its bracket.

    Examples
    --------
    >>> bool(abs(rising_root(lambda x: x**2, 2.0, 1.0, 2.0) - 2**0.5) < 1e-15)
    True
    """
    y, start, stop = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (target, low, high)))
    below, above = curve(start) - y, curve(stop) - y
    answer = np.where(np.abs(below) <= np.abs(above), start, stop)
    open_ = (below < 0.0) & (above > 0.0)
    missed = ~open_ & ~(np.minimum(np.abs(below), np.abs(above)) <= 1e-12 * np.abs(y))
    if missed.any():
        raise ConvergenceError(
            f"no root between {start[missed][0]:g} and {stop[missed][0]:g} for {y[missed][0]:g}"
        )
    answer[open_] = roots_of(lambda x, y: curve(x) - y, start[open_], stop[open_], y[open_])
    return answer


def boundary(
    holds: Callable[[FloatArray], NDArray[np.bool_]],
    inside: ArrayLike,
    outside: ArrayLike,
    within: float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """
    Where conditions that hold at one end of intervals cease to hold on the way to the other, by halving.

    Parameters
    ----------
    holds : callable
        Of an array of places, of the shape of `inside` and `outside`: whether the condition holds there.
    inside, outside : array_like
        Ends of the intervals, in either order; it holds at the first and not at the second, which is not asked.
    within : float
        Part of their first distance to which the two ends are brought; by default to neighbouring floats, or 2^-64 of it.

    Returns
    -------
    inside, outside : ndarray
        The last place at which it held and the first at which it did not.

    Examples
    --------
    >>> last, first = boundary(lambda x: x * x < 2.0, 1.0, 2.0)
    >>> bool(last < 2**0.5 <= first) and float(first - last) < 3e-16
    True
    """
    held, failed = np.broadcast_arrays(np.asarray(inside, dtype=float), np.asarray(outside, dtype=float))
    least = within * np.abs(failed - held)
    for _ in range(_HALVINGS):
        middle = held + 0.5 * (failed - held)
        between = (middle != held) & (middle != failed) & (np.abs(failed - held) > least)
        if not between.any():
            break
        good = np.asarray(holds(middle))
        held, failed = np.where(between & good, middle, held), np.where(between & ~good, middle, failed)
    return held, failed
