"""Roots and boundaries of functions of one variable, elementwise, to rounding."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymdr.errors import ConvergenceError
from pymdr.units import FloatArray

_HALVINGS = 64
_STEPS = 2048
_RELATIVE, _TINY = 4.0 * np.finfo(np.float64).eps, float(np.finfo(np.float64).smallest_normal)


def roots_of(
    function: Callable[..., FloatArray], low: FloatArray, high: FloatArray, *args: NDArray[Any]
) -> FloatArray:
    """
    Find one root of function(x, *args) in every bracket, elementwise.

    Parameters
    ----------
    function : callable
        Of arrays x and `args`, with opposite signs (or zero) at the ends of each bracket.
    low, high : ndarray
        One-dimensional brackets of the length of `args`.

    Returns
    -------
    ndarray
        The roots.

    Raises
    ------
    ConvergenceError
        If a bracket has no change of sign or does not close.

    Notes
    -----
    Chandrupatla (1997), with a tolerance relative to the root, so that nanometres are as accurate as metres. The roots are those of
    ``scipy.optimize.elementwise``, whose steps cost some ten times as much as a cheap function.

    Examples
    --------
    >>> roots_of(lambda x, y: x**2 - y, np.zeros(2), np.full(2, 3.0), np.array([1.0, 4.0]))
    array([1., 2.])
    """
    if low.size == 0:
        return low.copy()
    start, stop, *known = np.broadcast_arrays(low, high, *args)
    a, b = (np.array(end, dtype=np.float64) for end in (start, stop))
    both = function(np.concatenate([a, b]), *(np.concatenate([one, one]) for one in known))
    f, g = np.array(both, dtype=np.float64).reshape(2, -1)
    c, h = b, g
    roots, active = np.full(a.shape, np.nan), np.arange(a.size)
    for step in range(_STEPS):
        nearer = np.abs(f) < np.abs(g)
        best, least = np.where(nearer, a, b), np.where(nearer, f, g)
        width, tolerance = np.abs(b - a), np.abs(best) * _RELATIVE + 4.0 * _TINY
        exact = np.abs(least) <= _TINY
        unbracketed = ~exact & (
            (np.sign(f) == np.sign(g)) | ~np.isfinite(width) | (np.isnan(f) & np.isnan(g))
        )
        if unbracketed.any():
            active, best = active[unbracketed], np.full(1, np.nan)
            break
        closed = exact | (width < tolerance)
        roots[active[closed]] = best[closed]
        if closed.all():
            return roots
        if closed.any():
            a, f, b, g, c, h, width, tolerance, active, *known = (
                one[~closed] for one in (a, f, b, g, c, h, width, tolerance, active, *known)
            )
        part = _next_part((a, f, b, g, c, h), 0.5 * tolerance / width) if step else np.full(a.shape, 0.5)
        x = a + part * (b - a)
        value = np.asarray(function(x, *known), dtype=np.float64)
        same = np.sign(value) == np.sign(f)
        c, h, b, g = np.where(same, a, b), np.where(same, f, g), np.where(same, b, a), np.where(same, g, f)
        a, f = x, value
    worst = int(active[0])
    raise ConvergenceError(
        f"no root between {float(start[worst])!r} and {float(stop[worst])!r} (last value {float(best[0])!r}); check the magnitudes of the problem"
    )


def _next_part(brackets: tuple[FloatArray, ...], least: FloatArray) -> FloatArray:
    """Where in the brackets the next values are computed: by inverse quadratic interpolation if it is safe, else in the middle."""
    a, f, b, g, c, h = brackets
    with np.errstate(all="ignore"):
        xi, phi = (a - b) / (c - b), (f - g) / (h - g)
        smooth = ((1 - np.sqrt(1 - xi)) < phi) & (phi < np.sqrt(xi))
        alpha = (c - a) / (b - a)
        inverse = f / (f - g) * h / (h - g) - alpha * f / (h - f) * g / (g - h)
    return np.clip(np.where(smooth, inverse, 0.5), least, 1 - least)


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
            f"no root between {start[missed][0]:g} and {stop[missed][0]:g} for {y[missed][0]:g}; check the magnitudes of the problem"
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
    Bisect intervals for the boundary of a condition.

    Parameters
    ----------
    holds : callable
        The condition for an array of positions of the shape of `inside` and `outside`.
    inside, outside : array_like
        Ends of the intervals, in either order; the condition holds at the first and is false at the second, which is not
        evaluated.
    within : float
        Final distance of the ends relative to the initial one; by default neighbouring floats or 2^-64.

    Returns
    -------
    inside, outside : ndarray
        Last position at which the condition holds and first at which it does not.

    Examples
    --------
    >>> last, first = boundary(lambda x: x * x < 2.0, 1.0, 2.0)
    >>> bool(last < 2**0.5 <= first) and float(first - last) < 3e-16
    True
    """
    true_end, false_end = np.broadcast_arrays(
        np.asarray(inside, dtype=float), np.asarray(outside, dtype=float)
    )
    least = within * np.abs(false_end - true_end)
    for _ in range(_HALVINGS):
        middle = true_end + 0.5 * (false_end - true_end)
        between = (middle != true_end) & (middle != false_end) & (np.abs(false_end - true_end) > least)
        if not between.any():
            break
        good = np.asarray(holds(middle))
        true_end, false_end = (
            np.where(between & good, middle, true_end),
            np.where(between & ~good, middle, false_end),
        )
    return true_end, false_end
