"""The contact of two elastic half-spaces on an ellipse (Hertz)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy

from pymdr.units import FloatArray


def axis_ratio(radius_x: float, radius_y: float) -> float:
    """
    The ratio a_y / a_x of the semi-axes, the root of R_x / R_y = R_D(0, 1, k^2) / R_D(0, k^2, 1).

    Parameters
    ----------
    radius_x, radius_y : float
        Radii of curvature in m, above 0.

    Returns
    -------
    float
        1 for a paraboloid of revolution, about (R_y / R_x)^(2/3) near it.

    Notes
    -----
    Johnson (1985), eq. (4.26), is (E / (1 - e^2) - K) / (K - E), whose terms cancel near the circle; both differences are
    e^2 / 3 times integrals of Carlson (DLMF 19.25.1), so that e^2 drops out.

    Examples
    --------
    >>> axis_ratio(1.0, 1.0)
    1.0
    >>> round(axis_ratio(4.0, 1.0) * axis_ratio(1.0, 4.0), 14)
    1.0
    """
    wanted = math.log(radius_x / radius_y)
    mirrored = wanted < 0.0
    target = abs(wanted)

    def missed(s: float) -> float:
        square = math.exp(2.0 * s)
        return (
            math.log(
                float(scipy.special.elliprd(0.0, 1.0, square))
                / float(scipy.special.elliprd(0.0, square, 1.0))
            )
            - target
        )

    # the slope lies between -3/2 at the circle and -2 of long ellipses
    s = scipy.optimize.brentq(missed, -target, -0.49 * target, xtol=1e-15) if target > 0.0 else 0.0
    return math.exp(-s if mirrored else s)


@dataclass(frozen=True)
class HertzEllipse:
    """
    The elliptic contact of Hertz for an effective modulus of 1 Pa, at any depth.

    Parameters
    ----------
    radius_x, radius_y : float
        Radii of curvature in m.
    """

    radius_x: float
    radius_y: float

    def semi_axes(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """
        Semi-axes a_x and a_y in m, a_x^2 = 2 R_x d R_D(0, k^2, 1) / (3 R_F(0, k^2, 1)) with k = a_y / a_x.

        Parameters
        ----------
        depth : ndarray
            Indentations d in m.

        Returns
        -------
        tuple of ndarray
            0 without contact.

        Examples
        --------
        >>> [float(a[0]) for a in HertzEllipse(4.0, 4.0).semi_axes(np.array([1.0]))]
        [2.0, 2.0]
        """
        d = np.maximum(depth, 0.0)
        ratio = axis_ratio(self.radius_x, self.radius_y)
        if ratio > 1.0:
            a_y, a_x = HertzEllipse(self.radius_y, self.radius_x).semi_axes(depth)
            return a_x, a_y
        square = ratio * ratio
        shape = (
            2.0 * scipy.special.elliprd(0.0, square, 1.0) / (3.0 * scipy.special.elliprf(0.0, square, 1.0))
        )
        a_x = np.sqrt(shape * self.radius_x) * np.sqrt(d)
        return a_x, ratio * a_x

    def force(self, depth: FloatArray) -> FloatArray:
        """
        F / E* = 2 pi a_x d / (3 R_F(0, k^2, 1)) in m^2.

        Examples
        --------
        >>> round(float(HertzEllipse(2.0, 1.0).force(np.array([1.0]))[0]), 12)
        1.601454951101
        """
        axes = self.semi_axes(depth)
        longer, ratio = np.maximum(*axes), axis_ratio(self.radius_x, self.radius_y)
        square = min(ratio, 1.0 / ratio) ** 2
        d = np.maximum(depth, 0.0)
        return np.asarray(2.0 * math.pi / 3.0 * longer * d / scipy.special.elliprf(0.0, square, 1.0))
