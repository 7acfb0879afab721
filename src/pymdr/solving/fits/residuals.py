"""Serial correlation of the residuals of records."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from pymdr.numerics.panels import IndexArray
from pymdr.units import FloatArray

_LAGS = 32
"""Lags whose correlations are summed directly; longer ones come from the spectrum."""
_SIGNIFICANT, _FLAT = 5.0, 1e-4


class SerialCorrelation(NamedTuple):
    """Serial correlation of the residuals of records."""

    correlated: FloatArray
    """1 + 2 sum_k rho_k, up to the first lag whose correlation is within the noise; at least 1: the number of samples
    that are equivalent to one independent sample."""
    waves: FloatArray
    """Correlated part of the residuals relative to the noise between neighbours."""


def serial_correlation(residuals: FloatArray, span: FloatArray) -> SerialCorrelation:
    """
    Serial correlation of residuals.

    Parameters
    ----------
    residuals : ndarray, shape (records, samples)
        In the order in which they were measured; shorter records are padded with NaN.
    span : ndarray, shape (records,)
        Range of the forces of each record: smaller residuals than 1e-4 of it are not waves.

    Returns
    -------
    Hanging
        The waves are sqrt(2/eta - 1) with von Neumann's ratio eta of the mean squares of differences between neighbours and of the
        residuals themselves, which is 2 for white noise; 0 where it lies within five standard deviations, 2/sqrt(n), of that.

    Examples
    --------
    >>> noise, wave = np.random.default_rng(1).normal(size=1000), 3.0 * np.sin(np.linspace(0.0, 20.0, 1000))
    >>> result = serial_correlation(np.array([noise, noise + wave]), np.full(2, 100.0))
    >>> result.waves.round(1).tolist(), result.correlated.round().tolist()
    ([0.0, 2.1], [1.0, 80.0])
    """
    known = np.isfinite(residuals)
    n = known.sum(axis=1)
    values = np.where(known, residuals, 0.0)
    square = (values**2).sum(axis=1)
    differences = np.where(known[:, 1:], np.diff(values, axis=1), 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = (differences**2).sum(axis=1) / (n - 1) / (square / n)
        waves = np.sqrt(np.maximum(2.0 / ratio - 1.0, 0.0))
        plain = (ratio > 2.0 - _SIGNIFICANT * 2.0 / np.sqrt(n)) | (np.sqrt(square / n) < _FLAT * span)
        centred = np.where(known, values - (values.sum(axis=1) / n)[:, None], 0.0)
    times = _correlation_times(centred, n)
    long = np.flatnonzero(np.isnan(times))
    if long.size:
        times[long] = _long_correlations(centred[long], n[long])
    return SerialCorrelation(times, np.where(plain | ~np.isfinite(waves), 0.0, waves))


def _correlation_times(centred: FloatArray, n: IndexArray) -> FloatArray:
    """1 + 2 sum rho_k of each row, up to the first lag within the noise; NaN if that is beyond the direct sums."""
    times, total, rows = np.full(n.size, math.nan), np.ones(n.size), np.arange(n.size)
    power = (centred**2).sum(axis=1)
    for lag in range(1, _LAGS + 1):
        products = np.einsum("ij,ij->i", centred[:, lag:], centred[:, :-lag])
        with np.errstate(invalid="ignore", divide="ignore"):
            rho = np.where(power > 0.0, products / power, 0.0)
            ended = (rho < 2.5 / np.sqrt(n)) | (lag >= n // 2) | (n < 2)
        times[rows[ended]] = total[ended]
        going = ~ended
        if not going.any():
            break
        if ended.any():
            centred, n, power, rows = centred[going], n[going], power[going], rows[going]
        total = total[going] + 2.0 * rho[going]
    return times


def _long_correlations(centred: FloatArray, n: IndexArray) -> FloatArray:
    """Correlation times by the spectrum."""
    width = centred.shape[1]
    lags = width // 2 + 1
    size = next_fast_len(width + lags, real=True)
    spectrum = np.abs(rfft(centred, size)) ** 2
    rho = irfft(spectrum, size)[:, :lags] / (centred**2).sum(axis=1)[:, None]
    noise = (rho < (2.5 / np.sqrt(n))[:, None]) | (np.arange(rho.shape[1]) >= (n // 2)[:, None])
    noise[:, 0], noise[:, -1] = False, True
    sums = np.cumsum(rho, axis=1)[np.arange(n.size), np.argmax(noise, axis=1) - 1] - rho[:, 0]
    return np.asarray(np.maximum(1.0, 1.0 + 2.0 * sums))
