"""The line of springs of elliptic shape, g(x) = A/2 - (A/B) sqrt(B^2/4 - x^2), in closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymdr.units import FloatArray

SMALL = 1.0
"""Angle below which series replace differences that cancel."""
SLIVER = tuple((-1.0) ** k / math.factorial(2 * k + 3) for k in range(10))
"""Series of (x - sin x) / x^3 in x^2."""
_ENERGY = [
    (-1.0) ** k * ((3.0 ** (2 * k) - 1.0) / 4.0 - 2.0 * k) / math.factorial(2 * k + 1) for k in range(2, 16)
]
"""Series of (sin t - t cos t - sin(t)^3 / 3) / t^5 in t^2."""


@dataclass(frozen=True)
class Ellipse:
    """
    Lines of elliptic shape, one per entry.

    F = (E A B / 4) (t - sin t cos t), U = (E A^2 B / 8) (sin t - t cos t - sin(t)^3 / 3), a = (B / 2) sin t,
    cos t = 1 - 2 d / A (Zunker and Kamrin 2024, part I), for 0 <= d <= A / 2.
    """

    height: FloatArray
    """A in m."""
    width: FloatArray
    """B in m."""
    modulus: float
    """E_eff in Pa."""

    def contact_radius(self, d: FloatArray) -> FloatArray:
        """
        The contact radius in m at indentations d in m.

        Examples
        --------
        >>> float(Ellipse(np.array(0.02), np.array(0.5), 1.0).contact_radius(np.array(0.007)).round(12))
        0.238484800354
        """
        d = self._within(d)
        return np.asarray(self.width / self.height * np.sqrt(d * (self.height - d)))

    def force(self, d: FloatArray) -> FloatArray:
        """
        The force in N at indentations d in m.

        Examples
        --------
        >>> float(Ellipse(np.array(0.02), np.array(0.5), 1.0).force(np.array(0.007)).round(17))
        0.00244980478088604
        """
        twice = 2.0 * self._angle(d)
        sliver = np.where(
            twice < SMALL,
            twice**3 * np.polynomial.polynomial.polyval(twice**2, SLIVER),
            twice - np.sin(twice),
        )
        return np.asarray(0.125 * self.modulus * self.height * self.width * sliver)

    def energy(self, d: FloatArray) -> FloatArray:
        """
        The elastic energy int F dd in J at indentations d in m.

        Examples
        --------
        >>> float(Ellipse(np.array(2.0), np.array(2.0), 1.0).energy(np.array(1.0)).round(15))
        0.666666666666667
        """
        t = self._angle(d)
        sine = np.sin(t)
        part = np.where(
            t < 0.5 * SMALL,
            t**5 * np.polynomial.polynomial.polyval(t**2, _ENERGY),
            sine - t * np.cos(t) - sine**3 / 3.0,
        )
        return np.asarray(0.125 * self.modulus * self.height**2 * self.width * part)

    def depth(self, a: FloatArray) -> FloatArray:
        """The line g in m at positions a in m, at most B / 2."""
        rest = np.sqrt(np.maximum((0.5 * self.width - a) * (0.5 * self.width + a), 0.0))
        # A/2 - (A/B) s = (A/B) (B/2 - s), without cancellation
        return np.asarray(self.height / self.width * a * a / (0.5 * self.width + rest))

    def _within(self, d: FloatArray) -> FloatArray:
        return np.clip(d, 0.0, 0.5 * self.height)

    def _angle(self, d: FloatArray) -> FloatArray:
        return np.asarray(2.0 * np.arcsin(np.sqrt(self._within(d) / self.height)))


def ellipse_force(height: float, width: float, modulus: float, d: float) -> float:
    """
    The force in N of one line at one indentation d in m, as :meth:`Ellipse.force`, for steps one after the other.

    Examples
    --------
    >>> round(ellipse_force(0.02, 0.5, 1.0, 0.007), 17)
    0.00244980478088604
    """
    t = 4.0 * math.asin(math.sqrt(min(max(d / height, 0.0), 0.5)))
    if t >= SMALL:
        sliver = t - math.sin(t)
    else:
        sliver = 0.0
        for coefficient in reversed(SLIVER):
            sliver = sliver * t * t + coefficient
        sliver *= t**3
    return 0.125 * modulus * height * width * sliver
