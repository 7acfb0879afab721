"""Smoothing splines through samples at any spacing. Loads numba."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pymdr.compiling import compiled
from pymdr.units import FloatArray

_ROUNDING = 1e-40
"""Variance below which noise counts as rounding, for heights of about 1."""
_SMALLEST = 1e-100
"""Smallest deviation whose square is a normal float."""
_REJECTION = 6.63
"""Twice the logarithm of a likelihood ratio that chance exceeds in 1 % of cases."""
_MANY = 5000
"""Number of samples above which the search takes wider steps."""


@dataclass(frozen=True)
class Smooth:
    """A smoothing spline at its samples."""

    values: FloatArray
    """f - f(0), f', f'' at the samples, shape (n, 3)."""
    higher: FloatArray
    """Derivatives of order 3, 4, 5 to the right of the samples, shape (n, 3)."""
    level: float
    """f(0)."""
    noise: float
    """Root mean square of the independent residuals, relative to the given deviations."""
    believed: bool
    """Whether the given deviations were used, not only their ratios."""


def smooth(r: FloatArray, y: FloatArray, deviation: FloatArray, known: bool) -> Smooth:
    """
    Smooth samples by restricted maximum likelihood.

    The curve minimises sum (y_i - f(r_i))^2 / s_i^2 + lambda int (d^3 f / dr^3)^2 dr with f'(0) = 0. It is
    the expectation of f if its third derivative is white noise, and lambda maximises the likelihood. A Kalman filter
    runs from the apex outward and carries (f, f', f'') with the triangular root of their covariance, at a cost
    proportional to the number of samples.

    Parameters
    ----------
    r, y : ndarray, shape (n,)
        Radii from 0 to about 1, and heights of about 1.
    deviation : ndarray, shape (n,)
        Standard deviations s_i of the noise, above 0.
    known : bool
        Whether the deviations are used unless the samples contradict them; else only their ratios are.

    Notes
    -----
    Wahba (1978), J. R. Stat. Soc. B 40, 364 (the expectation); Wecker and Ansley (1983), J. Am. Stat. Assoc. 78,
    81 (the likelihood by innovations); Wahba (1985), Ann. Stat. 13, 1378 (against cross-validation); Bryson and
    Frazier (1963) (backward pass); Kaminski, Bryson and Schmidt (1971), IEEE Trans. Autom. Control 16, 727 (roots).

    Examples
    --------
    >>> r = np.linspace(0.0, 1.0, 6)
    >>> curve = smooth(r, r**2 / 2.0, np.ones(6), known=False)
    >>> bool(np.max(np.abs(curve.values[:, 1] - r)) < 1e-12)
    True
    """
    from scipy.optimize import minimize_scalar

    n = r.size
    typical = max(float(np.median(deviation)), _SMALLEST)
    weight = np.clip(deviation / typical, 1e-15, 1e15) ** 2  # wider ratios are below rounding
    cache: dict[float, tuple[float, float]] = {}

    def parts(decades: float) -> tuple[float, float]:
        if decades not in cache:
            determinant, misfit, _, _ = likelihood(r, y, weight, 10.0 ** (0.5 * decades))
            cache[decades] = determinant, misfit / (n - 2)
        return cache[decades]

    def free(decades: float) -> float:
        determinant, mean = parts(decades)
        return determinant + (n - 2) * (math.log(max(mean, _ROUNDING)) + 1.0)

    def constrained(decades: float) -> float:
        determinant, mean = parts(decades)
        return determinant + (n - 2) * (2.0 * math.log(typical) + mean / typical**2)

    # from the parabola c_0 + c_2 r^2 to interpolation of the closest samples
    least, most = -3.0 - math.log10(n), 8.0 - 5.0 * math.log10(float(np.min(np.diff(r))))
    step = 1.0 if n <= _MANY else 2.0
    grid = [least + step * i for i in range(math.ceil((most - least) / step) + 1)]

    def likeliest(criterion: Callable[[float], float]) -> float:
        i = int(np.argmin([criterion(x) for x in grid]))
        ends = grid[max(i - 1, 0)], grid[min(i + 1, len(grid) - 1)]
        optimum = minimize_scalar(criterion, bounds=ends, method="bounded", options={"xatol": 1e-4})
        return min(float(optimum.x), grid[i], key=criterion)

    decades, believed = likeliest(free), False
    if known:
        other = likeliest(constrained)
        believed = constrained(other) - free(decades) <= _REJECTION
        decades = other if believed else decades
    drive = 10.0 ** (0.5 * decades)
    _, misfit, level, kappa = likelihood(r, y, weight, drive)
    values, higher = smoothed(r, y - level, weight, drive, kappa)
    return Smooth(values, higher, level, math.sqrt(misfit / (n - 2)) / typical, believed)


@compiled
def _predict(root: FloatArray, h: float, drive: float, b: FloatArray) -> None:
    """
    Carry the triangular root of the covariance of (f, f', f'') over a distance h, in place.

    The root of the contribution of white noise of f''' is known; orthogonalisation makes both triangular, so that
    no variance is a difference of larger ones.
    """
    first = drive * math.sqrt(h)
    second, third = first * h, first * h * h
    b[:] = 0.0
    b[0, 0] = root[0, 0] + h * (root[1, 0] + 0.5 * h * root[2, 0])
    b[0, 1] = h * (root[1, 1] + 0.5 * h * root[2, 1])
    b[0, 2] = 0.5 * h * h * root[2, 2]
    b[1, 0] = root[1, 0] + h * root[2, 0]
    b[1, 1] = root[1, 1] + h * root[2, 1]
    b[1, 2] = h * root[2, 2]
    b[2, 0], b[2, 1], b[2, 2] = root[2, 0], root[2, 1], root[2, 2]
    # the Cholesky factor of [[1/20, 1/8, 1/6], [1/8, 1/3, 1/2], [1/6, 1/2, 1]]
    b[0, 3] = third / math.sqrt(20.0)
    b[1, 3], b[1, 4] = second * math.sqrt(20.0) / 8.0, second / math.sqrt(48.0)
    b[2, 3], b[2, 4], b[2, 5] = first * math.sqrt(20.0) / 6.0, first / math.sqrt(3.0), first / 3.0
    for i in range(3):
        for j in range(i):
            product = 0.0
            for k in range(6):
                product += b[i, k] * b[j, k]
            root[i, j] = product
            for k in range(6):
                b[i, k] -= product * b[j, k]
        largest = 0.0
        for k in range(6):
            largest = max(largest, abs(b[i, k]))
        root[i, i] = 0.0
        if largest > 0.0:
            total = 0.0
            for k in range(6):
                total += (b[i, k] / largest) ** 2
            root[i, i] = largest * math.sqrt(total)
            for k in range(6):
                b[i, k] /= root[i, i]


@compiled
def likelihood(
    r: FloatArray, y: FloatArray, weight: FloatArray, drive: float
) -> tuple[float, float, float, float]:
    """
    The restricted likelihood of samples y = f0 + kappa r^2 / 2 + (integrated noise) + noise.

    Parameters
    ----------
    r, y, weight : ndarray, shape (n,)
        Radii from 0, heights, and variances of the noise up to a common factor.
    drive : float
        Square root of the intensity of f''' as white noise, over the same factor.

    Returns
    -------
    determinant : float
        Logarithm of the determinants.
    misfit : float
        Sum of the squared independent residuals, n - 2 of them.
    f0, kappa : float
        The estimates.
    """
    root, work = np.zeros((3, 3)), np.empty((3, 6))
    state = np.zeros((2, 3))  # of the heights and of r^2 / 2
    level = np.zeros(3)
    factor = np.zeros((3, 3))
    row = np.zeros(3)
    determinant = 0.0
    for i in range(r.size):
        if i > 0:
            h = r[i] - r[i - 1]
            _predict(root, h, drive, work)
            for m in range(2):
                state[m, 0] += h * (state[m, 1] + 0.5 * h * state[m, 2])
                state[m, 1] += h * state[m, 2]
            level[0] += h * (level[1] + 0.5 * h * level[2])
            level[1] += h * level[2]
        spread = weight[i] + root[0, 0] ** 2
        deviation = math.sqrt(spread)
        determinant += math.log(spread)
        row[0] = 1.0 - level[0]
        row[1] = 0.5 * r[i] ** 2 - state[1, 0]
        row[2] = y[i] - state[0, 0]
        for k in range(3):
            gain = root[k, 0] * root[0, 0] / spread
            level[k] += gain * row[0]
            state[1, k] += gain * row[1]
            state[0, k] += gain * row[2]
        for k in range(3):
            root[k, 0] *= math.sqrt(weight[i]) / deviation
            row[k] /= deviation
        for k in range(3):
            size = math.hypot(factor[k, k], row[k])
            if size > 0.0:
                c, s = factor[k, k] / size, row[k] / size
                for m in range(k, 3):
                    kept = factor[k, m]
                    factor[k, m] = c * kept + s * row[m]
                    row[m] = c * row[m] - s * kept
    determinant += 2.0 * math.log(abs(factor[0, 0] * factor[1, 1]))
    kappa = factor[1, 2] / factor[1, 1]
    return determinant, factor[2, 2] ** 2, (factor[0, 2] - factor[0, 1] * kappa) / factor[0, 0], kappa


@compiled
def smoothed(
    r: FloatArray, y: FloatArray, weight: FloatArray, drive: float, kappa: float
) -> tuple[FloatArray, FloatArray]:
    """
    The curve for a given stiffness, by the backward pass of the filter.

    Parameters
    ----------
    r, y, weight : ndarray, shape (n,)
    drive : float
        As in :func:`likelihood`; the heights are those above f(0).
    kappa : float
        f'' at r = 0.

    Returns
    -------
    values, higher : ndarray, shape (n, 3)
        f, f', f'' at the samples, and the derivatives of order 3, 4, 5 to the right of them.
    """
    n = r.size
    values, roots = np.empty((n, 3)), np.empty((n, 3, 3))
    gains, innovations = np.empty((n, 3)), np.empty(n)
    kept = np.empty(n)
    root, state, work = np.zeros((3, 3)), np.zeros(3), np.empty((3, 6))
    state[2] = kappa
    for i in range(n):
        if i > 0:
            h = r[i] - r[i - 1]
            _predict(root, h, drive, work)
            state[0] += h * (state[1] + 0.5 * h * state[2])
            state[1] += h * state[2]
        spread = weight[i] + root[0, 0] ** 2
        new = y[i] - state[0]
        for k in range(3):
            gains[i, k] = root[k, 0] * root[0, 0] / spread
            state[k] += gains[i, k] * new
        kept[i] = weight[i] / spread
        for k in range(3):
            root[k, 0] *= math.sqrt(kept[i])
        innovations[i] = new / spread
        for k in range(3):  # entry by entry: an assignment of arrays takes seconds to compile
            values[i, k] = state[k]
            for m in range(3):
                roots[i, k, m] = root[k, m]
    later, back = np.zeros(3), np.empty(3)
    higher = np.empty((n, 3))
    for i in range(n - 1, -1, -1):
        if i < n - 1:
            h = r[i + 1] - r[i]
            later[2] += h * (later[1] + 0.5 * h * later[0])
            later[1] += h * later[0]
        for k in range(3):
            back[k] = roots[i, 0, k] * later[0] + roots[i, 1, k] * later[1] + roots[i, 2, k] * later[2]
        for k in range(3):
            values[i, k] += roots[i, k, 0] * back[0] + roots[i, k, 1] * back[1] + roots[i, k, 2] * back[2]
        higher[i, 0] = drive * drive * later[2]
        higher[i, 1] = -drive * drive * later[1]
        higher[i, 2] = drive * drive * later[0]
        later[0] = innovations[i] + kept[i] * later[0] - gains[i, 1] * later[1] - gains[i, 2] * later[2]
    return values, higher
