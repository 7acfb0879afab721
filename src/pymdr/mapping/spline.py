"""The Abel map of piecewise cubics, piece by piece in closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pymdr.units import FloatArray

_BLOCK = 2_000_000
"""Pieces times points in one block of work."""


def spline_map(breaks: FloatArray, coefficients: FloatArray, x: ArrayLike) -> FloatArray:
    """
    Equivalent profile of a piecewise cubic, g(x) = x sum_i int (piece of f') / sqrt(x^2 - r^2) dr.

    With s = r - m about the middle m of a piece (of the first: about its tip), f' = c_0 + c_1 s + c_2 s^2 there, and the integrals of
    1, r and r^2 over sqrt(x^2 - r^2) are differences of arcsin(r/x), -sqrt(x^2 - r^2) and
    (x^2 arcsin(r/x) - r sqrt(x^2 - r^2)) / 2, written without subtracting neighbours.

    Parameters
    ----------
    breaks : ndarray, shape (n + 1,)
        Radii in m at which the pieces begin and end.
    coefficients : ndarray, shape (4, n)
        Powers of r - breaks[i], highest first, in m.
    x : array_like
        Positions on the line in m, up to the last break.

    Returns
    -------
    ndarray
        g in m, of the shape of `x`.

    Notes
    -----
    Popov and Hess (2015), eq. 3.27, integrated piece by piece; no raw data are differentiated.

    Examples
    --------
    >>> g = spline_map(np.array([0.0, 1.0, 2.0]), np.array([[0, 0], [0.5, 0.5], [0, 1.0], [0, 0.5]]), [1.5])
    >>> bool(abs(g[0] - 1.5**2) < 1e-14)
    True
    """
    points = np.asarray(x, dtype=float)
    flat = np.ravel(points)
    half = 0.5 * np.diff(breaks)
    half[0] = 0.0  # about the tip itself, where f' may be small
    middle = breaks[:-1] + half
    third, second, first = coefficients[0], coefficients[1], coefficients[2]
    c = np.array(
        [3.0 * third * half**2 + 2.0 * second * half + first, 6.0 * third * half + 2.0 * second, 3.0 * third]
    )
    answer = np.empty(flat.shape)
    block = max(1, _BLOCK // half.size)
    for start in range(0, flat.size, block):
        answer[start : start + block] = _map_block(breaks, middle, c, flat[start : start + block])
    return answer.reshape(points.shape)


def _map_block(breaks: FloatArray, middle: FloatArray, c: FloatArray, x: FloatArray) -> FloatArray:
    used = int(np.searchsorted(breaks[:-1], x.max(), side="right"))
    top = x[:, None]
    r = np.minimum(breaks[: used + 1], top)
    root = np.sqrt((top - r) * (top + r))
    low, high, root_low, root_high = r[:, :-1], r[:, 1:], root[:, :-1], root[:, 1:]
    width = high - low
    with np.errstate(invalid="ignore", divide="ignore"):
        fall = np.where(width > 0.0, width * (high + low) / (root_low + root_high), 0.0)
    # sin and cos of the difference of the two arcsines
    turn = np.arctan2(width * root_low + low * fall, low * high + root_low * root_high)
    m, c = middle[:used], c[:, :used]
    second = 0.5 * (top * top * turn - width * root_high + low * fall)
    i1 = fall - m * turn
    i2 = second - 2.0 * m * fall + m * m * turn
    return np.asarray(x * (c[0] * turn + c[1] * i1 + c[2] * i2).sum(axis=1))
