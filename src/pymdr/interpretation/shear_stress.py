"""Stress and displacement inside an elastic half-space under a shear traction in one direction or around the axis, from its load on the line.

The load is a sum of tangential punches, whose closed forms are those of normal ones and three more. Around the axis every component
is the cosine or the sine of the angle times one number (frame of Cattaneo and Mindlin: the traction is parallel to x). Torsion needs no more
closed forms, and nothing of it depends on the angle.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pymdr.interpretation.stress import LineLoad, integrated, punch_forms, quick_sums
from pymdr.units import FloatArray


class ShearSums(NamedTuple):
    """Imaginary parts of sums over punches, in Pa (`log` in N/m); R and P as in :mod:`pymdr.interpretation.stress`."""

    inverse: FloatArray
    """1 / R."""
    cubed: FloatArray
    """z zeta / R^3."""
    mean: FloatArray
    """1 / P."""
    mixed: FloatArray
    """z / (R P)."""
    shear: FloatArray
    """z r / R^3."""
    across: FloatArray
    """r / (R P)."""
    squared: FloatArray
    """r / P^2."""
    deep: FloatArray
    """z r / (R P^2)."""
    log: FloatArray
    """ln P."""


def shear_sums(load: LineLoad, r: FloatArray, z: FloatArray, *, logarithm: bool = True) -> ShearSums:
    """
    The integrals at points inside the body.

    Parameters
    ----------
    load : LineLoad
        Of the shear traction.
    r, z : ndarray
        Radius and depth in m, at least 0, of one shape.
    logarithm : bool
        Whether that of ln P, which only displacements need, is computed.

    Returns
    -------
    ShearSums
        Arrays of that shape.
    """
    integrals = quick_sums(load, r, z, logarithm)
    if integrals is None:
        integrals = integrated(
            load, r, z, punch_forms, np.append(np.ones(len(ShearSums._fields) - 1), load.radius)
        )
    return ShearSums(*integrals)


def shear_stress(integrals: ShearSums, poisson: float) -> FloatArray:
    """
    Stress in Pa under a traction in +x on the body, tension positive, shape (6, ...).

    Returns
    -------
    ndarray
        Amplitudes of rr, tt, zz and rz, times the cosine of the angle from x, and of rt and tz, times its sine.

    Notes
    -----
    From the potentials of Cerruti (Johnson 1985, section 3.6); under a sliding Hertz contact they are Hamilton's (1983).
    """
    nu = poisson
    return (
        np.array(
            [
                2.0 * integrals.across + nu * integrals.squared + integrals.deep - integrals.shear,
                nu * (2.0 * integrals.across - integrals.squared) - integrals.deep,
                integrals.shear,
                integrals.inverse + integrals.mixed - integrals.cubed,
                nu * integrals.squared - integrals.across + integrals.deep,
                integrals.mixed - integrals.inverse,
            ]
        )
        / math.pi
    )


def shear_displacement(
    integrals: ShearSums, r: FloatArray, z: FloatArray, poisson: float, shear: float
) -> FloatArray:
    """
    Displacements in m under a traction in +x on the body, shape (3, ...).

    Parameters
    ----------
    r, z : ndarray
        Radius and depth in m.
    poisson, shear : float
        nu, and G in Pa, of the body.

    Returns
    -------
    ndarray
        Amplitudes of u_r, times the cosine of the angle from x, of u_t, times its sine, and of u_z, times its cosine.
    """
    even = (2.0 - poisson) * integrals.log + z * integrals.mean
    odd = 0.5 * poisson * r * integrals.squared
    along = even - odd - r * integrals.deep
    inward = -z * integrals.across - (1.0 - 2.0 * poisson) * r * integrals.mean
    return np.array([along, -even - odd, inward]) / (2.0 * math.pi * shear)


def twist_stress(integrals: ShearSums, r: FloatArray) -> FloatArray:
    """
    Stress in Pa under a traction around the axis, shape (2, ...).

    Parameters
    ----------
    integrals : ShearSums
        Of the torsional load Q in Pa, in Pa/m.
    r : ndarray
        Radius in m.

    Returns
    -------
    ndarray
        Components rt and tz, of any isotropic body.

    Notes
    -----
    A rigid disk of radius s that is turned, Q = 8 G phi, has u_t = (Q r / 2 pi G) Im(ln P / 2 + r^2 / (4 P^2) + z / P) (Reissner and Sagoci
    1944; Sneddon 1947), with R and P of :mod:`pymdr.interpretation.stress`; hence tz = (Q r / 2 pi) Im(1 / R - z / (R P)) and
    rt = (Q r / 2 pi) Im(r / (R P) - r / (2 P^2) - z r / (R P^2)).
    """
    rt = integrals.across - 0.5 * integrals.squared - integrals.deep
    tz = integrals.inverse - integrals.mixed
    return np.asarray(r / (2.0 * math.pi) * np.array([rt, tz]))


def twist_displacement(integrals: ShearSums, r: FloatArray, z: FloatArray, shear: float) -> FloatArray:
    """
    Displacement u_t in m around the axis under a traction around it.

    Parameters
    ----------
    integrals : ShearSums
        Of the torsional load Q.
    r, z : ndarray
        Radius and depth in m.
    shear : float
        G in Pa.
    """
    turned = 0.5 * integrals.log + 0.25 * r * integrals.squared + z * integrals.mean
    return np.asarray(r / (2.0 * math.pi * shear) * turned)
