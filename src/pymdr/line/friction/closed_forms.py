"""
Closed forms of tangential contact at constant normal force, for power-law profiles and any exponent.

The line of springs of Popov and Hess with Coulomb's limit follows, as the method is taught.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pymdr.line.friction.state import frozen
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


class SpringHistory(NamedTuple):
    """Results of the springs, one entry per row."""

    tangential_force: FloatArray
    """F_x in N."""
    stick_radius: FloatArray
    """Half the length of the line below Coulomb's limit, in m."""
    stored_energy: FloatArray
    """Energy of the springs in J."""
    slip_work: FloatArray
    """Work of friction so far in J."""


def springs(
    profile: ArrayLike,
    spacing: float,
    indentation: ArrayLike,
    shift: ArrayLike,
    friction: float,
    modulus: float,
    tangential_modulus: float,
) -> SpringHistory:
    """
    Follow rows of (indentation, shift) with springs of stiffness G* dx and the cap mu E* dx (d - g).

    A spring that touches within a row takes only the part of the shift after its touch; a spring over its cap is
    set back to it, also when the cap falls; a spring that parts loses its shift. Every step is exact for a spring:
    the force errs by the midpoint rule, O(1/N^2) for N springs.

    Parameters
    ----------
    profile : array_like, shape (N,)
        g(x) in m of the springs on one side, at x = (j + 1/2) dx. Both sides are counted.
    spacing : float
        dx in m.
    indentation, shift : array_like, shape (n,)
        d and u_x in m; the first row is reached from (0, 0).
    friction : float
        mu; 0 and infinite are allowed.
    modulus, tangential_modulus : float
        E* and G* in Pa.

    Notes
    -----
    Popov and Hess (2015), chapter 5, in one direction.

    Examples
    --------
    >>> x = (np.arange(2000) + 0.5) / 2000
    >>> round(float(springs(x**2, 1 / 2000, [0.5, 0.5], [0.0, 0.25], 1.0, 1.0, 1.0).tangential_force[1]), 5)
    0.30474
    """
    from pymdr.line.friction.noslip import run_springs

    depth, moved = frozen(indentation), frozen(shift)
    out = np.zeros((4, depth.size))
    if friction > 0.0:
        mu = friction if math.isfinite(friction) else 1.0
        ratio = mu * modulus / tangential_modulus
        labels = frozen(profile)
        sticks = not math.isfinite(friction)
        run_springs(labels, np.zeros(labels.size), depth, moved, 1.0 / ratio, sticks, out)
        out[0] *= 2.0 * spacing * mu * modulus
        out[1] *= spacing
        out[2:] *= 2.0 * spacing * mu * modulus * ratio
    return SpringHistory(out[0], out[1], out[2], out[3])
