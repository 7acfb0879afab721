"""Numbers of many curves and of what a model leaves of them. Loads numba."""

from __future__ import annotations

import math

import numpy as np

from pymdr.solving.fits.kernels.model import compiled
from pymdr.units import FloatArray


@compiled
def spans(places: FloatArray, forces: FloatArray, softness: FloatArray) -> FloatArray:
    """How far the depths of each curve reach in m; 0 where there are none."""
    found = np.zeros(places.shape[0])
    for i in range(places.shape[0]):
        low, high = math.inf, -math.inf
        for j in range(places.shape[1]):
            depth = places[i, j] - softness[i] * forces[i, j]
            if math.isfinite(depth):
                low, high = min(low, depth), max(high, depth)
        found[i] = max(high - low, 0.0)
    return found


@compiled
def correlation_times(residuals: FloatArray, most: int) -> tuple[FloatArray, FloatArray]:
    """
    1 + 2 sum rho_k of each row, up to the first lag within the noise; nan where that is none of the first `most`.

    And of each row its size, its mean square, and that of the differences between neighbours.
    """
    found, moments = np.empty(residuals.shape[0]), np.empty((residuals.shape[0], 3))
    for i in range(residuals.shape[0]):
        row = residuals[i]
        if not math.isfinite(row.sum()):
            row = row[np.isfinite(row)]
        n = row.size
        plain, square, beside = 0.0, 0.0, 0.0
        for j in range(n):
            plain += row[j]
            square += row[j] * row[j]
            if j:
                beside += row[j] * row[j - 1]
        mean = plain / max(n, 1)
        ends = row[0] + row[n - 1] if n else 0.0
        between = 2.0 * (square - beside) - (row[0] ** 2 + row[n - 1] ** 2 if n else 0.0)
        moments[i, 0], moments[i, 1], moments[i, 2] = n, square / max(n, 1), between / max(n - 1, 1)
        power, total, ended, lag = square - n * mean * mean, 1.0, n < 2, 1
        while not ended and lag <= most:
            products = beside - mean * (2.0 * plain - ends) + (n - 1) * mean * mean
            if lag > 1:
                products = 0.0
                for j in range(n - lag):
                    products += (row[j] - mean) * (row[j + lag] - mean)
            rho = products / power if power > 0.0 else 0.0
            if rho < 2.5 / math.sqrt(n) or lag >= n // 2:
                ended = True
            else:
                total += 2.0 * rho
            lag += 1
        found[i] = total if ended else math.nan
    return found, moments
