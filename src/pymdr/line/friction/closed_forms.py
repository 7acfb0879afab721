"""Closed forms of tangential contact at constant normal force, for power-law profiles and any exponent."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pymdr.units import FloatArray


def cattaneo_mindlin(shift_ratio: ArrayLike, exponent: float) -> tuple[FloatArray, FloatArray]:
    """
    Force and stick radius of partial slip: F_x/(mu F_N) = 1 - (1 - l)^((n+1)/n), c/a = (1 - l)^(1/n).

    Parameters
    ----------
    shift_ratio : array_like
        l = u_x / u_s, 0 to 1; u_s = mu (E* / G*) d is the shift at which the contact slides.
    exponent : float
        n of the profile f = c r^n.

    Returns
    -------
    force_ratio, stick_ratio : ndarray
        F_x / (mu F_N) and c / a.

    Notes
    -----
    Cattaneo (1938), Mindlin (1949) for n = 2; Jaeger (1995), Ciavarella (1998).

    Examples
    --------
    >>> force, stick = cattaneo_mindlin(0.4, 1.0)
    >>> round(float(force), 12), round(float(stick), 12)
    (0.64, 0.6)
    """
    with np.errstate(divide="ignore"):
        stuck = np.log1p(-np.asarray(shift_ratio, dtype=float))
        return -np.expm1(stuck * (exponent + 1.0) / exponent), np.exp(stuck / exponent)


def shift_ratio_at(force_ratio: ArrayLike, exponent: float) -> FloatArray:
    """
    Shift of partial slip, u_x/u_s = 1 - (1 - F_x/(mu F_N))^(n/(n+1)).

    Parameters
    ----------
    force_ratio : array_like
        F_x / (mu F_N), 0 to 1.
    exponent : float
        n of the profile f = c r^n.

    Examples
    --------
    >>> round(float(shift_ratio_at(0.64, 1.0)), 12)
    0.4
    """
    with np.errstate(divide="ignore"):
        left = np.log1p(-np.asarray(force_ratio, dtype=float))
    ratio: FloatArray = -np.expm1(left * exponent / (exponent + 1.0))
    return ratio


def loop_energy(shift_ratio: ArrayLike, exponent: float) -> FloatArray:
    """
    Work of friction in one cycle at constant depth between -u_a and u_a, over mu F_N u_s.

    8 [l - (1 - (1 - l)^(m+1)) / (m + 1)] - 4 l [1 - (1 - l)^m] with m = (n + 1) / n, by Masing's rule. For small l,
    where this cancels, 4 m (m - 1) int_0^l s (l - s) (1 - s)^(m-2) ds.

    Parameters
    ----------
    shift_ratio : array_like
        l = u_a / u_s, 0 to 1.
    exponent : float
        n of the profile f = c r^n.

    Notes
    -----
    For n = 2: Mindlin and Deresiewicz (1953); for other powers the difference of two normal contacts, Jaeger (1995).

    Examples
    --------
    >>> round(float(loop_energy(0.4, 1.0)), 12)
    0.085333333333
    """
    ratio = np.asarray(shift_ratio, dtype=float)
    m = (exponent + 1.0) / exponent
    stuck = 1.0 - ratio
    direct = 8.0 * (ratio - (1.0 - stuck ** (m + 1.0)) / (m + 1.0)) - 4.0 * ratio * (1.0 - stuck**m)
    node, weight = np.polynomial.legendre.leggauss(12)
    s = 0.5 * (1.0 + node) * np.minimum(ratio, 0.1)[..., None]
    small = np.minimum(ratio, 0.1)
    body = (s * (small[..., None] - s) * (1.0 - s) ** (m - 2.0)) @ weight
    return np.where(ratio > 0.1, direct, 2.0 * m * (m - 1.0) * small * body)
