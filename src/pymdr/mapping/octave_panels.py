"""The Abel map on quarter-octave panels of the grid 2^(j/4) m that is anchored at the tip.

The integrals over one such panel at another depend only on the number of panels between them. Panels up to two octaves
away enter by the integrals of their polynomials, all panels further in by their moments

    1 / sqrt(x^2 - r^2) = (1/x) sum_k b_k (r/x)^(2k),   b_k = (2k)! / (2^k k!)^2,

which only scale from panel to panel.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pymdr.numerics.panels import BoolArray, IndexArray, Panels, basis, basis_slope
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

STEP = 2.0**0.25
GAUSS_NODES = 24
"""Gauss nodes for integrals up to an inverse square root."""
FAR_STEPS = 8
"""Distance in panels from which a panel acts by its moments: its end is at 2^(-7/4) of the start of the other."""
_MOMENTS = 16
"""Number of moments in (r/x)^2 up to 2^(-7/2); the next is below rounding."""


def is_quarter_octave(panels: Panels) -> BoolArray:
    """Whether panels are whole quarter octaves of the grid that is anchored at the tip."""
    whole = (panels.base == 0.0) & (panels.low > 0.0)
    with np.errstate(divide="ignore"):
        ratio = np.where(whole, panels.high / panels.low, 0.0)
    return np.asarray(whole & (np.abs(ratio - STEP) <= 4.0 * np.finfo(float).eps))


@lru_cache(maxsize=32)
def pair(steps: int, u: tuple[float, ...]) -> FloatArray:
    """
    Integrals g / x, m and g' of the polynomials on a quarter octave from r = 1, at points u of one some steps outward.

    Shape (3, TERMS, k).
    """
    low = STEP**steps
    inside = low * (STEP - 1.0) * np.array(u)
    x = low + inside
    s, weights = gauss(GAUSS_NODES)
    # distances from both ends of the source, exact where the panels meet
    far = np.sqrt((low - 1.0) * (steps > 0) + inside)
    near = np.sqrt((low - STEP) * (steps > 1) + inside) if steps else np.zeros_like(x)
    v = near[:, None] + (far - near)[:, None] * s
    r = np.clip(x[:, None] - v * v, 1.0, STEP)
    kernel = 2.0 * (far - near)[:, None] * weights / np.sqrt(x[:, None] + r)
    at = (r - 1.0) / (STEP - 1.0)
    value, rate = basis(at), basis_slope(at) / (STEP - 1.0)
    return np.stack(
        [
            np.einsum("ij,ijk->ki", kernel, value),
            np.einsum("ij,ijk->ki", kernel * r * r, value),
            np.einsum("ij,ijk->ki", kernel, value + r[:, :, None] * rate),
        ]
    )


@lru_cache(maxsize=4)
def _near(u: tuple[float, ...]) -> FloatArray:
    """The pairs up to two octaves, the most distant first, for panels that begin at x = 1; shape (FAR_STEPS TERMS, 3 k)."""
    scale = np.array([0.0, -0.5, 0.0])[:, None, None]
    pairs = [pair(j, u) * 2.0 ** (j * scale) for j in reversed(range(FAR_STEPS))]
    return np.concatenate([np.concatenate(list(part), axis=1) for part in pairs])


@lru_cache(maxsize=1)
def _moments() -> FloatArray:
    """
    Moments of polynomials on the quarter octave two octaves below x = 1, shape (TERMS, 2, _MOMENTS + 1).

    The first are those of f', the second those of (r f')'.
    """
    s, weights = gauss(GAUSS_NODES)
    r = 0.25 * (1.0 + (STEP - 1.0) * s)
    weights = 0.25 * (STEP - 1.0) * weights
    value, rate = basis(s), basis_slope(s) / (0.25 * (STEP - 1.0))
    powers = weights[:, None] * r[:, None] ** (2.0 * np.arange(_MOMENTS + 1))
    return np.stack([value.T @ powers, (value + r[:, None] * rate).T @ powers], axis=1)


@lru_cache(maxsize=4)
def _far(u: tuple[float, ...]) -> FloatArray:
    """Values of moments at points u of a quarter octave that begins at x = 1, shape (2 (_MOMENTS + 1), 3 k)."""
    x = 1.0 + (STEP - 1.0) * np.array(u)
    kernel = _binomials()[:, None] * x ** -(2.0 * np.arange(_MOMENTS)[:, None] + 1.0)
    matrix = np.zeros((2, _MOMENTS + 1, 3, x.size))
    matrix[0, :-1, 0] = kernel
    matrix[0, 1:, 1] = kernel
    matrix[1, :-1, 2] = kernel
    return matrix.reshape(2 * (_MOMENTS + 1), 3 * x.size)


def accumulated_moments(coefficients: FloatArray, slope: float, power: float) -> FloatArray:
    """
    Moments of everything two octaves or more below consecutive quarter octaves.

    Parameters
    ----------
    coefficients : ndarray, shape (S, TERMS)
        f' on them, S >= 8.
    slope, power : float
        Below the first, at r = R, f' = slope (r/R)^power.

    Returns
    -------
    ndarray
        Moments of f' and of (r f')' below every panel from the ninth on, and beyond the last, relative to the radius at which
        it begins; shape (S - 7, 2, k).
    """
    arriving = np.tensordot(coefficients[: coefficients.shape[0] - FAR_STEPS + 1], _moments(), axes=1)
    twice = 2.0 * np.arange(_MOMENTS + 1)
    outward = STEP ** -(twice + 1.0)
    # the tail one step further in
    now = slope * 0.25 ** (twice + 1.0) / (power + 1.0 + twice) / outward * np.array([[1.0], [1.0 + power]])
    for fresh in arriving:
        now *= outward
        now += fresh
        fresh[:] = now
    return np.asarray(arriving)


def sums_on_octave_panels(
    coefficients: FloatArray, low: FloatArray, below: FloatArray, target: IndexArray, u: tuple[float, ...]
) -> FloatArray:
    """
    Integrals g / x, m and g' on quarter octaves over all radii below.

    Parameters
    ----------
    coefficients : ndarray, shape (S, TERMS)
        f' on consecutive quarter octaves.
    low : ndarray, shape (S,)
        Radii in m at which these begin.
    below : ndarray
        Result of :func:`accumulated_moments`.
    target : ndarray of int, shape (T,)
        Indices of the target panels, each at least 8.
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
    >>> below = accumulated_moments(cone, 1.0, 0.0)
    >>> sums = sums_on_octave_panels(cone, low, below, np.array([12, 16]), (0.0,))
    >>> np.round(sums[0, :, 0], 14).tolist() == [round(np.pi / 2, 14)] * 2
    True
    """
    window = coefficients[target[:, None] - np.arange(FAR_STEPS - 1, -1, -1)].reshape(target.size, -1)
    answer = window @ _near(u) + below[target - FAR_STEPS].reshape(target.size, -1) @ _far(u)
    sums = np.moveaxis(answer.reshape(target.size, 3, len(u)), 1, 0).copy()
    sums[1] *= low[target][:, None] ** 2
    return np.asarray(sums)


def sums_from_below(below: FloatArray, low: FloatArray, x: FloatArray) -> FloatArray:
    """
    The same integrals at places outside given radii, over everything two octaves or more below these radii.

    Parameters
    ----------
    below : ndarray, shape (T, 2, k)
        Moments by :func:`accumulated_moments`.
    low : ndarray, shape (T,)
        The radii in m.
    x : ndarray, shape (T, n)
        Places in m, not below the radii.

    Returns
    -------
    ndarray
        Of shape (3, T, n).
    """
    inward = low[:, None] / x
    square = inward * inward
    terms = np.stack([below[:, 0, :-1], below[:, 0, 1:], below[:, 1, :-1]]) * _binomials()
    total = np.zeros((3, *x.shape))
    for k in range(_MOMENTS - 1, -1, -1):
        total *= square
        total += terms[:, :, k, None]
    total *= inward
    total[1] *= low[:, None] ** 2
    return total


@lru_cache(maxsize=1)
def _binomials() -> FloatArray:
    k = np.arange(1.0, _MOMENTS)
    return np.concatenate([[1.0], np.cumprod((2.0 * k - 1.0) / (2.0 * k))])
