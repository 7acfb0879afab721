"""Waves in the residuals of records."""

from __future__ import annotations

import numpy as np

from pymdr.units import FloatArray

_SIGNIFICANT, _FLAT = 5.0, 1e-4
DECIDED = 0.01
"""Probability of white noise below which the slow part of a spectrum counts as waves."""


def is_rounding(noise: FloatArray, span: FloatArray) -> FloatArray:
    """Whether residuals are that small, relative to the range of the forces, that their waves have no meaning."""
    return np.asarray(noise < _FLAT * span)


def waves_of(residuals: FloatArray, span: FloatArray, slow: FloatArray | float = 0.0) -> FloatArray:
    """
    Correlated part of residuals relative to the noise between neighbours.

    Parameters
    ----------
    residuals : ndarray, shape (records, samples)
        In the order in which they were measured; shorter records are padded with NaN.
    span : ndarray, shape (records,)
        Range of the forces of each record: smaller residuals than 1e-4 of it are not waves.
    slow : ndarray, shape (records,), optional
        Covariance of neighbours by the slow part of a spectrum, where it is certain.

    Returns
    -------
    ndarray, shape (records,)
        sqrt(2/eta - 1) with von Neumann's ratio eta of the mean squares of differences between neighbours and of the
        residuals themselves, which is 2 for white noise. Where it lies within five standard deviations, 2/sqrt(n), of that,
        or above it, as with anticorrelated neighbours, the waves are those of the slow part.

    Examples
    --------
    >>> noise, wave = np.random.default_rng(1).normal(size=1000), 3.0 * np.sin(np.linspace(0.0, 20.0, 1000))
    >>> waves_of(np.array([noise, noise + wave]), np.full(2, 100.0)).round(1).tolist()
    [0.0, 2.1]
    """
    known = np.isfinite(residuals)
    n = known.sum(axis=1)
    values = np.where(known, residuals, 0.0)
    square = (values**2).sum(axis=1)
    differences = np.where(known[:, 1:], np.diff(values, axis=1), 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        between = (differences**2).sum(axis=1) / (n - 1)
        ratio = between / (square / n)
        waves = np.sqrt(np.maximum(2.0 / ratio - 1.0, 0.0))
        plain = ratio > 2.0 - _SIGNIFICANT * 2.0 / np.sqrt(n)
        waves = np.where(plain, np.sqrt(2.0 * slow / between), waves)
        none = is_rounding(np.sqrt(square / n), span) | ~np.isfinite(waves)
    return np.where(none, 0.0, waves)
