"""The Abel map where panels are quarters of an octave on the grid 2^(j/4) m that is anchored at the tip.

Two such panels act on one another alike wherever they lie, as far as they are equally many quarters apart. Panels
next to one another, up to two octaves, enter by the integrals of their polynomials, all those farther in by their
moments

    1 / sqrt(x^2 - r^2) = (1/x) sum_k b_k (r/x)^(2k),   b_k = (2k)! / (2^k k!)^2,

which a step outward only scales.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pymdr.numerics.panels import BoolArray, IndexArray, Panels, basis, basis_slope
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

QUARTER = 2.0**0.25
NEAR = 24
"""Gauss nodes for integrals up to an inverse square root."""
APART = 8
"""Quarters from which a panel counts by its moments: it ends at 2^(-7/4) of where the other begins."""
_MOMENTS = 16
"""Of (r/x)^2 up to 2^(-7/2): the next is below rounding."""


def are_quarters(panels: Panels) -> BoolArray:
    """Whether panels are whole quarters of an octave on the grid that is anchored at the tip."""
    whole = (panels.base == 0.0) & (panels.low > 0.0)
    with np.errstate(divide="ignore"):
        ratio = np.where(whole, panels.high / panels.low, 0.0)
    return np.asarray(whole & (np.abs(ratio - QUARTER) <= 4.0 * np.finfo(float).eps))


@lru_cache(maxsize=32)
def pair(apart: int, u: tuple[float, ...]) -> FloatArray:
    """Integrals of the polynomials of a quarter octave from r = 1 at points u of one that is some quarters farther out.

    Those of g / x, m and g', shape (3, TERMS, k).
    """
    low = QUARTER**apart
    inside = low * (QUARTER - 1.0) * np.array(u)
    x = low + inside
    s, weights = gauss(NEAR)
    # distances from both ends of the source, exact where the panels meet
    far = np.sqrt((low - 1.0) * (apart > 0) + inside)
    near = np.sqrt((low - QUARTER) * (apart > 1) + inside) if apart else np.zeros_like(x)
    v = near[:, None] + (far - near)[:, None] * s
    r = np.clip(x[:, None] - v * v, 1.0, QUARTER)
    kernel = 2.0 * (far - near)[:, None] * weights / np.sqrt(x[:, None] + r)
    at = (r - 1.0) / (QUARTER - 1.0)
    value, rate = basis(at), basis_slope(at) / (QUARTER - 1.0)
    return np.stack(
        [
            np.einsum("ij,ijk->ki", kernel, value),
            np.einsum("ij,ijk->ki", kernel * r * r, value),
            np.einsum("ij,ijk->ki", kernel, value + r[:, :, None] * rate),
        ]
    )


@lru_cache(maxsize=4)
def _near(u: tuple[float, ...]) -> FloatArray:
    """The pairs up to two octaves apart, farthest first, for panels that begin at x = 1; shape (APART TERMS, 3 k)."""
    scale = np.array([0.0, -0.5, 0.0])[:, None, None]
    pairs = [pair(j, u) * 2.0 ** (j * scale) for j in reversed(range(APART))]
    return np.concatenate([np.concatenate(list(part), axis=1) for part in pairs])


@lru_cache(maxsize=1)
def _moments() -> FloatArray:
    """Moments of polynomials on the quarter octave two octaves below x = 1, shape (TERMS, 2, _MOMENTS + 1).

    Those of f', and those of (r f')'.
    """
    s, weights = gauss(NEAR)
    r = 0.25 * (1.0 + (QUARTER - 1.0) * s)
    weights = 0.25 * (QUARTER - 1.0) * weights
    value, rate = basis(s), basis_slope(s) / (0.25 * (QUARTER - 1.0))
    powers = weights[:, None] * r[:, None] ** (2.0 * np.arange(_MOMENTS + 1))
    return np.stack([value.T @ powers, (value + r[:, None] * rate).T @ powers], axis=1)


@lru_cache(maxsize=4)
def _far(u: tuple[float, ...]) -> FloatArray:
    """What moments are at points u of a quarter that begins at x = 1, shape (2 (_MOMENTS + 1), 3 k)."""
    x = 1.0 + (QUARTER - 1.0) * np.array(u)
    kernel = _binomials()[:, None] * x ** -(2.0 * np.arange(_MOMENTS)[:, None] + 1.0)
    matrix = np.zeros((2, _MOMENTS + 1, 3, x.size))
    matrix[0, :-1, 0] = kernel
    matrix[0, 1:, 1] = kernel
    matrix[1, :-1, 2] = kernel
    return matrix.reshape(2 * (_MOMENTS + 1), 3 * x.size)


def gathered(coefficients: FloatArray, slope: float, power: float) -> FloatArray:
    """
    Moments of all that lies two octaves and more below quarter octaves that follow one another.

    Parameters
    ----------
    coefficients : ndarray, shape (S, TERMS)
        f' on them, S >= 8.
    slope, power : float
        Below the first, at r = R, f' = slope (r/R)^power.

    Returns
    -------
    ndarray
        Of shape (S - 7, 2, k): those of f' and of (r f')' below every panel from the ninth on, and beyond the last, in
        parts of the radius at which that begins.
    """
    arriving = np.tensordot(coefficients[: coefficients.shape[0] - APART + 1], _moments(), axes=1)
    twice = 2.0 * np.arange(_MOMENTS + 1)
    outward = QUARTER ** -(twice + 1.0)
    # what the tail would have been a quarter farther in
    now = slope * 0.25 ** (twice + 1.0) / (power + 1.0 + twice) / outward * np.array([[1.0], [1.0 + power]])
    for fresh in arriving:
        now *= outward
        now += fresh
        fresh[:] = now
    return np.asarray(arriving)


def sums_on_quarters(
    coefficients: FloatArray, low: FloatArray, below: FloatArray, target: IndexArray, u: tuple[float, ...]
) -> FloatArray:
    """
    Integrals g / x, m and g' on quarter octaves over all that is below them.

    Parameters
    ----------
    coefficients : ndarray, shape (S, TERMS)
        f' on quarter octaves that follow one another.
    low : ndarray, shape (S,)
        Radii in m at which these begin.
    below : ndarray
        What :func:`gathered` gives.
    target : ndarray of int, shape (T,)
        Which of them are asked, each at least 8.
    u : tuple of float
        Points on every panel, shape (k,).

    Returns
    -------
    ndarray
        Of shape (3, T, k).

    Examples
    --------
    A cone, g = pi x / 2:

    >>> low = 2.0 ** (np.arange(-16, 1) / 4)
    >>> cone = np.eye(1, 16)[np.zeros(low.size, dtype=int)]
    >>> found = sums_on_quarters(cone, low, gathered(cone, 1.0, 0.0), np.array([12, 16]), (0.0,))
    >>> np.round(found[0, :, 0], 14).tolist() == [round(np.pi / 2, 14)] * 2
    True
    """
    window = coefficients[target[:, None] - np.arange(APART - 1, -1, -1)].reshape(target.size, -1)
    answer = window @ _near(u) + below[target - APART].reshape(target.size, -1) @ _far(u)
    sums = np.moveaxis(answer.reshape(target.size, 3, len(u)), 1, 0).copy()
    sums[1] *= low[target][:, None] ** 2
    return np.asarray(sums)


def sums_from_below(below: FloatArray, low: FloatArray, x: FloatArray) -> FloatArray:
    """
    The same integrals anywhere beyond radii over all that lies two octaves and more below these.

    Parameters
    ----------
    below : ndarray, shape (T, 2, k)
        Moments as :func:`gathered` gives them.
    low : ndarray, shape (T,)
        The radii in m.
    x : ndarray, shape (T, n)
        Places in m, not below them.

    Returns
    -------
    ndarray
        Of shape (3, T, n).
    """
    inward = low[:, None] / x
    square = inward * inward
    shares = np.stack([below[:, 0, :-1], below[:, 0, 1:], below[:, 1, :-1]]) * _binomials()
    total = np.zeros((3, *x.shape))
    for k in range(_MOMENTS - 1, -1, -1):
        total *= square
        total += shares[:, :, k, None]
    total *= inward
    total[1] *= low[:, None] ** 2
    return total


@lru_cache(maxsize=1)
def _binomials() -> FloatArray:
    k = np.arange(1.0, _MOMENTS)
    return np.concatenate([[1.0], np.cumprod((2.0 * k - 1.0) / (2.0 * k))])
