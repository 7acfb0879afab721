"""Stress in an elastic half-space by a direct double integral of point loads over its surface, without the method."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.units import FloatArray, shown


def normal_point_load(x: FloatArray, y: FloatArray, z: FloatArray, poisson: float) -> FloatArray:
    """
    Stress xx, yy, zz, xz, xy, yz in 1/m^2 under a unit force into the body at the origin, tension positive.

    Parameters
    ----------
    x, y, z : ndarray
        Position in m, z > 0.

    Notes
    -----
    Boussinesq (1885); Johnson (1985), eq. 3.20.

    Examples
    --------
    >>> float(normal_point_load(np.zeros(1), np.zeros(1), np.ones(1), 0.3)[2, 0] * 2.0 * math.pi)
    -3.0
    """
    d = np.sqrt(x * x + y * y + z * z)
    one, two = 1.0 / (d * (d + z)), (2.0 * d + z) / (d**3 * (d + z) ** 2)
    soft, five = 1.0 - 2.0 * poisson, 3.0 * z / d**5
    lateral = soft * z / d**3 - soft * one
    return np.array(
        [
            lateral + soft * x * x * two - five * x * x,
            lateral + soft * y * y * two - five * y * y,
            -five * z * z,
            -five * x * z,
            (soft * two - five) * x * y,
            -five * y * z,
        ]
    ) / (2.0 * math.pi)


def tangential_point_load(x: FloatArray, y: FloatArray, z: FloatArray, poisson: float) -> FloatArray:
    """
    Stress xx, yy, zz, xz, xy, yz in 1/m^2 under a unit force on the body in +x at the origin, tension positive.

    Notes
    -----
    Cerruti (1882); Johnson (1985), eq. 3.76.

    Examples
    --------
    >>> float(tangential_point_load(np.ones(1), np.zeros(1), np.zeros(1), 0.5)[0, 0] * 2.0 * math.pi)
    -3.0
    """
    d = np.sqrt(x * x + y * y + z * z)
    five, soft = 3.0 / d**5, 1.0 - 2.0 * poisson
    one = 1.0 / (d * (d + z) ** 2)
    two = (3.0 * d + z) / (d**3 * (d + z) ** 3)
    return np.array(
        [
            x * (soft * (d**-3 - 3.0 * one + x * x * two) - five * x * x),
            x * (soft * (d**-3 - one + y * y * two) - five * y * y),
            -five * x * z * z,
            -five * x * x * z,
            y * (soft * (x * x * two - one) - five * x * x),
            -five * x * y * z,
        ]
    ) / (2.0 * math.pi)


def stress_of_tractions(
    radii: ArrayLike,
    pressure: Callable[[FloatArray], FloatArray],
    traction: Callable[[FloatArray], FloatArray],
    points: ArrayLike,
    poisson: float,
    *,
    n: int = 200,
) -> FloatArray:
    """
    Stress under a pressure and a shear traction in +x on rings, by a double integral of point loads.

    Parameters
    ----------
    radii : array_like
        Radii in m, rising, between which both are smooth; at each of them they may have a square root. The last is the edge.
    pressure, traction : callable
        p(r) and tau(r) in Pa at radii in m.
    points : array_like, shape (m, 3)
        x, y and z in m, z > 0.
    n : int
        Nodes between two radii, and 2 n around the axis. The error falls as exp(-n z / edge).

    Returns
    -------
    ndarray, shape (6, m)
        xx, yy, zz, xz, xy, yz in Pa, tension positive.

    Notes
    -----
    r = (b + c)/2 - (c - b)/2 cos(theta) removes square roots at both ends b and c. Around the axis the trapezoidal rule is exact up to
    the exponentially small.

    Examples
    --------
    >>> hertz = lambda r: np.sqrt(1.0 - r * r)
    >>> result = stress_of_tractions([1.0], hertz, np.zeros_like, [[0.0, 0.0, 1.0]], 0.3)
    >>> round(float(result[2, 0]), 12)
    -0.5
    """
    places = np.asarray(points, dtype=float)
    if not np.all(places[:, 2] > 0.0):
        raise ProblemError(f"depths {shown(places[:, 2])}; all must be above 0 m")
    bounds = np.array([0.0, *np.atleast_1d(np.asarray(radii, dtype=float))])
    t, w = np.polynomial.legendre.leggauss(n)
    theta, half = 0.5 * math.pi * (t + 1.0), 0.5 * np.diff(bounds)[:, None]
    r = (bounds[:-1, None] + half * (1.0 - np.cos(theta))).ravel()
    weight = (0.5 * math.pi * w * half * np.sin(theta)).ravel() * r * math.pi / n
    phi = math.pi * np.arange(2 * n) / n
    x, y = (r[:, None] * turn(phi) for turn in (np.cos, np.sin))
    normal, shear = (weight * values(r) for values in (pressure, traction))
    stresses = np.empty((6, len(places)))
    for i, (px, py, pz) in enumerate(places):
        at = px - x, py - y, np.full(x.shape, pz)
        stresses[:, i] = normal_point_load(*at, poisson).sum(axis=-1) @ normal
        stresses[:, i] += tangential_point_load(*at, poisson).sum(axis=-1) @ shear
    return stresses
