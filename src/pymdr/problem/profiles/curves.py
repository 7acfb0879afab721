"""Samples without smoothing: powers of two, cubic splines, noise."""

from __future__ import annotations

import math

import numpy as np

from pymdr.units import FloatArray


def power_of_two(length: float) -> float:
    """
    The largest power of two that is not above a length; dividing by it is exact.

    Examples
    --------
    >>> power_of_two(5.0)
    4.0
    """
    return math.ldexp(0.5, math.frexp(length)[1])


def cubic_spline(r: FloatArray, f: FloatArray, tip_slope: float | None) -> FloatArray:
    """
    Coefficients of the cubic spline through samples (not-a-knot at the last but one).

    The slopes s follow from s_(i-1) / h_(i-1) + 2 (1 / h_(i-1) + 1 / h_i) s_i + s_(i+1) / h_i
    = 3 (d_(i-1) / h_(i-1) + d_i / h_i), where h are the distances and d the mean slopes between samples. These
    equations are symmetric and dominated by their diagonal whatever the distances, so that no pivots are needed:
    pivoting of a general banded solver would carry the rounding of long distances into short ones. The slopes at the
    ends follow afterwards.

    Parameters
    ----------
    r, f : ndarray, shape (n,)
        Rising radii and heights, n >= 5.
    tip_slope : float or None
        f' at the first radius; if None, not-a-knot at the second.

    Returns
    -------
    ndarray, shape (4, n - 1)
        Coefficients of the powers 3 to 0 of the distance to the sample on the left.

    Notes
    -----
    De Boor (1978), A Practical Guide to Splines, chapter 4.

    Examples
    --------
    >>> r = np.array([0.0, 1e-9, 1e-6, 1e-3, 1.0, 2.0])
    >>> bool(np.max(np.abs(cubic_spline(r, r**2, tip_slope=0.0)[1] - 1.0)) < 1e-9)
    True
    """
    from scipy.linalg import solveh_banded

    h = np.diff(r)
    d = np.diff(f) / h
    stiff = 1.0 / h
    band = np.zeros((2, r.size - 2))
    band[0, 1:] = stiff[1:-1]
    band[1] = 2.0 * (stiff[:-1] + stiff[1:])
    sides = np.zeros((r.size - 2, 3))
    sides[:, 0] = 3.0 * (stiff[:-1] * d[:-1] + stiff[1:] * d[1:])
    sides[0, 1], sides[-1, 2] = -stiff[0], -stiff[-1]
    inner = solveh_banded(band, sides)
    # equal third derivatives of the two outermost cubics, in terms of the slopes at both ends
    last = _jump(h[-1], h[-2], d[-1], d[-2], inner[-1], inner[-2])
    last[2] += min(1.0, (h[-2] / h[-1]) ** 2)
    if tip_slope is None:
        first = _jump(h[0], h[1], d[0], d[1], inner[0], inner[1])
        first[1] += min(1.0, (h[1] / h[0]) ** 2)
        low, high = np.linalg.solve(np.array([first[1:], last[1:]]), -np.array([first[0], last[0]]))
    else:
        low = tip_slope
        high = -(last[0] + last[1] * low) / last[2]
    slope = np.concatenate([[low], inner @ np.array([1.0, low, high]), [high]])
    excess = slope[:-1] + slope[1:] - 2.0 * d
    return np.array([excess / h**2, (d - slope[:-1] - excess) / h, slope[:-1], f[:-1]])


def _jump(
    outer: float, inner: float, d_outer: float, d_inner: float, near: FloatArray, next_: FloatArray
) -> FloatArray:
    """
    Jump of the third derivative between the two outermost cubics, without the term of the end slope.

    Given as coefficients of 1 and of the slopes at both ends, from those of the two adjacent slopes.
    """
    shorter = min(outer, inner)
    a, b = (shorter / outer) ** 2, (shorter / inner) ** 2
    jump = a * near - b * (near + next_)
    jump[0] += 2.0 * (b * d_inner - a * d_outer)
    return np.asarray(jump)


def noise_of(radius: FloatArray, height: FloatArray) -> float:
    """
    The noise of heights from one sample to the next; see :attr:`pymdr.Sampled.noise`.

    Parameters
    ----------
    radius, height : ndarray, shape (n,)
        Samples in m, n >= 5.

    Returns
    -------
    float
        In m: the smallest estimate by differences of order 2, 3 and 4, because curvature of the profile adds to them.

    Examples
    --------
    >>> noise_of(np.arange(9.0), np.arange(9.0) ** 3)
    0.0
    """
    largest = float(np.max(np.abs(height)))
    size = power_of_two(largest)
    if largest == 0.0:
        return 0.0
    estimates = []
    for order in (2, 3, 4):
        r = np.lib.stride_tricks.sliding_window_view(radius, order + 1)
        y = np.lib.stride_tricks.sliding_window_view(height / size, order + 1)
        x = (r - r[:, :1]) / (r[:, -1:] - r[:, :1])
        weight = 1.0 / np.prod(x[:, :, None] - x[:, None, :] + np.eye(order + 1), axis=2)
        weight /= np.max(np.abs(weight), axis=1, keepdims=True)
        difference = np.sum(weight * (y - y[:, :1]), axis=1) / np.linalg.norm(weight, axis=1)
        estimates.append(float(np.median(np.abs(difference))))
    return min(estimates) / 0.6745 * size
