"""The geometry of a cohesive zone a < x < c, without subtraction."""

from __future__ import annotations

import numpy as np

from pymdr.units import FloatArray


def zone_root(radius: FloatArray, width: FloatArray) -> FloatArray:
    """Return sqrt(c² - a²) [m] of a zone from a with c = a + δ, without subtraction."""
    return np.sqrt(width * (2.0 * radius + width))


def segment(angle: FloatArray) -> FloatArray:
    """Return ψ - sin ψ cos ψ, by its series where the difference would cancel.

    Examples
    --------
    >>> bool(abs(segment(np.array(1e-4)) / (2e-12 / 3) - 1) < 1e-8)
    True
    """
    z = (2.0 * angle) ** 2
    series = np.ones_like(z)
    for k in (14, 12, 10, 8, 6, 4):
        series = 1.0 - z * series / (k * (k + 1))
    return np.where(angle < 0.4, angle * z * series / 6.0, angle - np.sin(angle) * np.cos(angle))
