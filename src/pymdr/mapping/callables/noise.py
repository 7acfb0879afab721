"""Measured properties of a callable: its rounding, its slope, and radii for the search for features."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.units import FloatArray, metres

Curve: TypeAlias = Callable[[FloatArray], FloatArray]

EPS = float(np.finfo(float).eps)
_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
_STRETCHES = (2e-2, 1e-3, 5e-5, 2e-6)
"""Relative lengths over which a callable counts as smooth; over the shortest ones every profile does."""
_SCATTERED, _DEGREE = 28, 6
_LEAST_OF_FOUR = 1.18
"""Ratio of a standard deviation to the mean of the smallest of four estimates of it."""
_ALONE = 8192
"""Entries of a matrix up to which OpenBLAS, which numpy brings, takes one thread for it and a vector."""
_SPARE = 4
"""Coefficients beyond the requested ones, to test whether these are enough."""


def jitter(count: int, seed: float = 0.0) -> FloatArray:
    """The first numbers in [0, 1) of a sequence that fills the interval evenly and on no grid, shape (count,)."""
    return np.asarray(((np.arange(count) + 1.0) * _GOLDEN + seed * math.sqrt(2.0)) % 1.0)


def search_points(low: float, high: float, seed: float = 0.0, density: int = 2048) -> FloatArray:
    """
    Radii at which narrow features of a profile are looked for, one in each of 2048 strips an octave.

    Their places in the strips follow a sequence of low discrepancy, so that no wave keeps step with them.

    Parameters
    ----------
    low, high : float
        Ends in m, 0 < low < high.
    seed : float
        Another seed gives other places.
    density : int
        Radii an octave.

    Returns
    -------
    ndarray
        Rising radii in m between the ends, at least 16.

    Examples
    --------
    >>> r = search_points(1.0, 4.0)
    >>> r.size, bool(np.all(np.diff(r) > 0.0)), bool(np.max(r[1:] / r[:-1]) < 2 ** (2 / 2048))
    (4096, True, True)
    """
    # a panel by a breakpoint may be so narrow that high / low is 1
    stretch = (high - low) / low
    count = max(math.ceil(density * math.log2(1.0 + stretch)), 16)
    steps = (np.arange(count) + jitter(count, seed)) / count
    return np.asarray(np.clip(low + low * np.expm1(steps * math.log1p(stretch)), low, high))


def orthonormal(matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """
    Q and R of a tall matrix with few columns, in one thread: for so little work others take longer to wake.

    By reflections, or where linear algebra would use threads by Gram and Schmidt done twice.
    """
    if matrix.size <= _ALONE:
        answer = np.linalg.qr(matrix)
        return answer.Q, answer.R
    q = np.empty_like(matrix)
    triangle = np.zeros((matrix.shape[1], matrix.shape[1]))
    for j in range(matrix.shape[1]):
        column = matrix[:, j].copy()
        for _ in range(2):
            parts = q[:, :j].T @ column
            column -= q[:, :j] @ parts
            triangle[:j, j] += parts
        triangle[j, j] = math.sqrt(float(column @ column))
        q[:, j] = column / triangle[j, j]
    return q, triangle


@lru_cache(maxsize=1)
def _short_fit() -> tuple[FloatArray, FloatArray]:
    """Places in (0, 1) over a stretch, and the projection of values there on what a polynomial leaves."""
    # even steps would keep step with the roundings, and a sequence of low discrepancy has nearly even ones
    t = (np.arange(_SCATTERED) + np.random.default_rng(1).random(_SCATTERED)) / _SCATTERED
    basis, _ = np.linalg.qr(chebyshev.chebvander(2.0 * t - 1.0, _DEGREE))
    return t, np.eye(_SCATTERED) - basis @ basis.T


def rounding(f: Curve, radii: ArrayLike) -> FloatArray:
    """
    Rounding noise of a callable around radii: its scatter about smooth segments over short stretches.

    It is never taken as less than one rounding of f itself; where all values have no more digits than single
    precision, than one of those.

    Parameters
    ----------
    f : callable
        Taking and giving arrays, with its offset f(0) if it has one.
    radii : array_like
        In m.

    Returns
    -------
    ndarray
        Standard deviation in the unit of f, of the shape of `radii`; nan where f is not defined.

    Examples
    --------
    >>> bool(rounding(lambda r: 1.0 - np.sqrt(1.0 - r * r), 1e-3) > 1e-17)
    True
    """
    radii = np.asarray(radii, dtype=float)
    with np.errstate(all="ignore"):
        noise, least = scatter(f, np.ravel(radii))
    return np.maximum(noise, least).reshape(radii.shape)


def scatter(f: Curve, r: FloatArray, stairs: bool = True) -> tuple[FloatArray, FloatArray]:
    """
    Measured scatter of a callable around radii, 0 where it is constant, and one rounding of its values.

    With `stairs`, what is constant around a radius and takes few values in an octave is taken for rounded, as f is
    where it cancels; a slope may have such steps by itself.
    """
    t, left = _short_fit()
    lengths = np.array(_STRETCHES)
    # to the left only: f may end at the radius
    points = r[:, None, None] * (1.0 - lengths[:, None] * (1.0 - t))
    values = f(points.ravel()).reshape(points.shape)
    last = f(r)
    with np.errstate(all="ignore"):
        # a common part would be rounded in the projection
        deviations = (values - values[:, :, -1:]) @ left.T
        # squares of what is tiny are 0
        largest = np.max(np.abs(deviations), axis=2)
        fractions = deviations / np.where(largest > 0.0, largest, 1.0)[:, :, None]
        deviation = largest * np.sqrt(np.sum(fractions**2, axis=2) / (_SCATTERED - _DEGREE - 1))
        varies = np.isfinite(deviation) & (np.ptp(values, axis=2) > 0.0)
    noise = np.where(varies.all(axis=1), _LEAST_OF_FOUR * np.min(deviation, axis=1), 0.0)
    still = np.flatnonzero(~varies.all(axis=1) & np.isfinite(last) & (r > 0.0))
    if stairs and still.size:
        octave = f((r[still, None] * (1.0 - 0.5 * (1.0 - t))).ravel()).reshape(still.size, -1)
        for i, wide in zip(still.tolist(), octave, strict=True):
            stretches = (*values[i, ::-1], wide)
            noise[i] = next((step for stretch in stretches if (step := _stairs(stretch)) > 0.0), 0.0)
    unit = EPS
    given = values[np.isfinite(values) & (values != 0.0)]
    with np.errstate(over="ignore"):
        single = given.astype(np.float32).astype(float) == given
    if single.all() and np.unique(given[:4096]).size > 16:
        unit = float(np.finfo(np.float32).eps)
    known = np.isfinite(last)
    return np.where(known, noise, math.nan), np.where(known, unit * np.abs(last), math.nan)


def _stairs(values: FloatArray) -> float:
    """Half the step of values on a staircase of equal steps; 0 for other values."""
    # most are constant
    if np.all(values == values[0]):
        return 0.0
    levels, counts = np.unique(values, return_counts=True)
    if not np.all(np.isfinite(levels)):
        return 0.0
    steps = np.diff(levels) / np.min(np.diff(levels))
    repeated = levels.size >= 5 or np.count_nonzero(counts > 1) >= 2
    return (
        0.5 * float(np.min(np.diff(levels)))
        if repeated and np.all(np.abs(steps - np.round(steps)) < 1e-3)
        else 0.0
    )


@lru_cache(maxsize=32)
def _panel_fit(n: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Places t in (0, 1), orthonormal polynomials there, their slopes as Chebyshev coefficients and largest slopes."""
    count = max(12 * n, 160)
    angles = np.pi * (np.arange(count) + np.random.default_rng(2).random(count)) / count
    t = (1.0 - np.cos(angles)) / 2.0
    basis, mixing = np.linalg.qr(chebyshev.chebvander(2.0 * t - 1.0, n + _SPARE))
    series = np.linalg.inv(mixing)
    slopes = 2.0 * chebyshev.chebder(series)
    ends = chebyshev.chebvander(np.linspace(-1.0, 1.0, 65), n + _SPARE - 1) @ slopes
    return t, basis, np.asarray(slopes), np.asarray(ends)


def slope_panel(f: Curve, low: float, high: float, n: int = 16) -> tuple[FloatArray, float]:
    """
    Slope f' on a panel as a Chebyshev series, from f alone.

    A polynomial of no higher degree than its rounding lets see is fitted to f by least squares at 12 n radii, so
    that rounding averages out, and differentiated.

    Parameters
    ----------
    f : callable
        Taking and giving arrays, smooth on the panel.
    low, high : float
        Its ends in m.
    n : int
        Number of coefficients.

    Returns
    -------
    coefficients : ndarray
        c_j with f' = sum c_j T_j(2 t - 1), t = (r - low) / (high - low), shape (n,).
    error : float
        Measured bound of the error of f' on the panel, from what the fit leaves: large where n coefficients are
        not enough.

    Raises
    ------
    ProblemError
        If f is not finite there.

    Examples
    --------
    >>> c, error = slope_panel(lambda r: r**1.5, 1.0, 1.19)
    >>> bool(abs(np.polynomial.chebyshev.chebval(1.0, c) - 1.5 * 1.19**0.5) < error < 1e-12)
    True
    """
    t, basis, slopes, at_ends = _panel_fit(n)
    width = high - low
    r = low + width * t
    values = f(r)
    if not np.all(np.isfinite(values)):
        bad = r[~np.isfinite(values)][0]
        raise ProblemError(
            f"the profile is not defined at r = {metres(float(bad))}: declare its last radius, Function(..., max_radius=...)"
        )
    middle = float(values[values.size // 2])
    shifted = values - middle
    # radii are rounded, and f with them
    off = (r - low) - width * t
    for _ in range(2):
        parts = basis.T @ shifted
        slope = chebyshev.chebval(2.0 * t - 1.0, slopes @ parts) / width
        shifted = values - middle - off * slope
    parts = basis.T @ shifted
    left = shifted - basis @ parts
    noise = math.sqrt(float(left @ left) / (t.size - parts.size))
    noise = max(noise, 0.25 * EPS * float(np.max(np.abs(values))))
    noise *= _reddening(left)
    seen = np.flatnonzero(np.abs(parts[: n + 1]) > 4.0 * noise)
    last = min(int(seen[-1]) + 1 if seen.size else 0, n)
    kept = np.where(np.arange(parts.size) <= last, parts, 0.0)
    coefficients: FloatArray = (slopes @ kept)[:n] / width
    scatter = np.sqrt(np.max(np.sum(at_ends[:, : last + 3] ** 2, axis=1)))
    beyond = np.max(np.abs(at_ends[:, n + 1 :] @ parts[n + 1 :]))
    if np.all(np.abs(parts[n + 1 :]) <= 4.0 * noise):
        beyond = 0.0
    error = (5.0 * noise * scatter + 2.0 * beyond) / width + 4.0 * EPS * float(np.sum(np.abs(coefficients)))
    return coefficients, float(error)


def _reddening(left: FloatArray) -> float:
    """Factor by which correlated rounding errors of neighbours weaken the average over them."""
    power = float(left @ left)
    if power == 0.0:
        return 1.0
    together = min(max(float(left[1:] @ left[:-1]) / power, 0.0), 0.98)
    return math.sqrt((1.0 + together) / (1.0 - together))
