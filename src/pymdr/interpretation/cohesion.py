"""Fields of a contact with a cohesive zone: a constant stress on the ring a < r < c around the contact."""

from __future__ import annotations

import math

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pymdr.line.foundation import ElasticLine
from pymdr.mapping.abel import Curve
from pymdr.units import FloatArray


def cohesive_spring_shift(line: ElasticLine, strength: float, c: float, x: ArrayLike) -> FloatArray:
    """
    Displacement w = -(2 sigma0 / E*) sqrt(c^2 - x^2) of the springs in the cohesive zone.

    Parameters
    ----------
    line : ElasticLine
        For the modulus.
    strength : float
        Cohesive stress sigma0 in Pa.
    c : float
        Radius of the zone in m.
    x : array_like
        Positions in m, |x| >= a.

    Returns
    -------
    ndarray
        w in m; 0 outside the zone (Maugis 1992; Popov and Hess 2015, chapter 4).
    """
    at: FloatArray = np.abs(np.asarray(x, dtype=float))
    return np.asarray(-(2.0 * strength / line.modulus) * np.sqrt(np.maximum((c - at) * (c + at), 0.0)))


def cohesive_pressure(line: ElasticLine, strength: float, a: float, c: float, r: ArrayLike) -> FloatArray:
    """
    Pressure (E*/pi) int_r^a g' / sqrt(x^2 - r^2) dx - (2 sigma0/pi) arctan sqrt((c^2 - a^2)/(a^2 - r^2)).

    Parameters
    ----------
    line : ElasticLine
        Profile and modulus.
    strength : float
        Cohesive stress sigma0 in Pa.
    a, c : float
        Radii of contact and cohesive zone in m.
    r : array_like
        Radii in m.

    Returns
    -------
    ndarray
        p in Pa: -sigma0 in the zone a < r < c, 0 outside.

    Notes
    -----
    Maugis (1992), for any profile by superposition on the line.
    """
    radius: FloatArray = np.abs(np.asarray(r, dtype=float))
    p = np.where(radius < c, -strength, 0.0)
    inside = radius < a
    if inside.any():
        s = radius[inside]
        pull = np.arctan2(math.sqrt((c - a) * (c + a)), np.sqrt((a - s) * (a + s)))
        repulsion = line.modulus / math.pi * line.equivalent.pressure_integral(s, a)
        p[inside] = repulsion - 2.0 * strength / math.pi * pull
    return p


def cohesive_displacement(
    line: ElasticLine, gap_function: Curve, strength: float, d: float, a: float, c: float, r: ArrayLike
) -> FloatArray:
    """
    Surface displacement: d - f(r) inside the contact, (2/pi) int_0^min(r, c) w / sqrt(r^2 - x^2) dx outside.

    Parameters
    ----------
    line, strength, a, c, r
        As for :func:`cohesive_pressure`.
    gap_function : callable
        f(r).
    d : float
        Indentation in m.

    Returns
    -------
    ndarray
        u in m, of both bodies together.
    """
    radius: FloatArray = np.abs(np.asarray(r, dtype=float))
    u = np.zeros(radius.shape)
    inside = (radius <= a) & (a > 0.0)
    u[inside] = d - gap_function(radius[inside])
    outside = ~inside
    if outside.any():
        s = radius[outside]
        if a > 0.0:
            excess = d - float(line.equivalent.g(np.array([a]))[0])
            springs = line.equivalent.displacement_integral(s, a) + excess * np.arcsin(np.minimum(a / s, 1.0))
            u[outside] = 2.0 / math.pi * springs
        u[outside] += pulled_up(line, strength, a, c, s)
    return u


def pulled_up(line: ElasticLine, strength: float, a: float, c: float, r: FloatArray) -> FloatArray:
    """
    Displacement in m outside the contact from the springs of the cohesive zone.

    Parameters
    ----------
    line, strength, a, c, r
        As for :func:`cohesive_pressure`.
    """
    # with x = min(r, c) sin t, the integrals of sqrt(c^2 - x^2) / sqrt(r^2 - x^2) are elliptic
    top = np.minimum(r, c)
    start = np.arcsin(np.minimum(a / np.where(top > 0.0, top, 1.0), 1.0))
    within, m = r <= c, (top / np.maximum(r, c)) ** 2
    second = scipy.special.ellipe(m) - scipy.special.ellipeinc(start, m)
    first = np.where(
        within,
        0.0,
        scipy.special.ellipkm1(np.where(within, 1.0, 1.0 - m)) - scipy.special.ellipkinc(start, m),
    )
    integral = np.where(within, c * second, r * (second - (1.0 - m) * first))
    return np.asarray(-(4.0 * strength / (math.pi * line.modulus)) * integral)
