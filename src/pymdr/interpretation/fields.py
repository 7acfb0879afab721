"""Fields on the surface from the springs on the line."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from pymdr.interpretation.punch import punch_displacement, punch_gap, punch_pressure
from pymdr.line.curves import ElasticLine as ElasticLine
from pymdr.line.curves import Line
from pymdr.mapping.abel import Curve
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.numerics.panels import Position
from pymdr.units import FloatArray


def pressure(line: Line, a: Position, edge_excess: float, r: ArrayLike) -> FloatArray:
    """
    Pressure p = (c/pi) [ int_r^a g' (x^2 - r^2)^((k-1)/2) dx + (d - g(a)) (a^2 - r^2)^((k-1)/2) ].

    For homogeneous half-spaces c = E* and k = 0.

    Parameters
    ----------
    line : ElasticLine
        Profile and modulus.
    a : float or Place
        Contact radius in m.
    edge_excess : float
        d - g(a) in m, not 0 at a sharp or an adhesive edge.
    r : array_like
        Radii in m.

    Returns
    -------
    ndarray
        p in Pa; 0 outside the contact, inf at a singular edge.

    Notes
    -----
    Sneddon (1965); Popov and Hess (2015), chapter 3; Hess (2016) for graded half-spaces. The second term is added in closed
    form.

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> line = ElasticLine(equivalent_profile(Paraboloid(1.0)), math.pi)
    >>> float(pressure(line, 1.0, 0.0, 0.6))
    1.6
    """
    radius: FloatArray = np.abs(np.asarray(r, dtype=float))
    edge = float(np.asarray(a, dtype=float))
    if edge <= 0.0:
        return np.zeros(radius.shape)
    springs, excess, _ = line.carried(a, edge_excess)
    regular = springs.equivalent.pressure_integral(radius, a)
    if excess != 0.0:
        with np.errstate(divide="ignore", invalid="ignore"):
            singular = excess * punch_pressure(line.exponent, edge, radius)
        regular = np.where(radius <= edge, regular + singular, 0.0)
    return line.modulus / math.pi * regular


def edge_amplitude(line: Line, a: ArrayLike, edge_excess: ArrayLike) -> FloatArray:
    """
    Amplitude K of the edge singularity, p -> K / sqrt(a - r), K = w sqrt(E* k'(a) / 2) / (pi sqrt(2 a)).

    For homogeneous half-spaces k' = 2 E*.

    Parameters
    ----------
    line : Line
        For graded half-spaces the singularity has another exponent, and K is nan.
    a : array_like
        Contact radii in m.
    edge_excess : array_like
        w = d - d0(a) in m.

    Returns
    -------
    ndarray
        K in Pa m^0.5.

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import FlatPunch
    >>> float(edge_amplitude(ElasticLine(equivalent_profile(FlatPunch(0.5)), math.pi), 0.5, 1.0))
    1.0
    """
    excess = np.asarray(edge_excess, dtype=float)
    if line.exponent != 0.0:
        return np.where(excess == 0.0, 0.0, math.nan)
    radius = np.asarray(a, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        stiffness = np.sqrt(0.5 * line.modulus * line.stiffness_rate(np.where(excess == 0.0, 0.0, radius)))
        amplitude = stiffness * excess / (math.pi * np.sqrt(2.0 * radius))
    return np.where(excess == 0.0, 0.0, amplitude)


def normal_displacement(
    line: Line, gap_function: Curve, d: float, a: Position, edge_excess: float, r: ArrayLike
) -> FloatArray:
    """
    Surface displacement u(r): d - f(r) inside the contact, (2/pi) int_0^a (d - g) / sqrt(r^2 - x^2) dx outside.

    Under graded half-spaces outside (2/pi) cos(k pi/2) int_0^a x^k (d - g) (r^2 - x^2)^(-(1+k)/2) dx.

    Parameters
    ----------
    line : ElasticLine
        Profile and modulus.
    gap_function : callable
        f(r).
    d : float
        Indentation in m.
    a : float or Place
        Contact radius in m.
    edge_excess : float
        d - g(a) in m.
    r : array_like
        Radii in m.

    Returns
    -------
    ndarray
        u in m, of both bodies together, into the half-space positive (Popov and Hess 2015, chapter 3).

    Notes
    -----
    By parts the integral is int_0^a g' arcsin(x / r) dx + (d - g(a)) arcsin(a / r), whose terms have one sign.
    """
    radius: FloatArray = np.abs(np.asarray(r, dtype=float))
    u = np.zeros(radius.shape)
    edge = float(np.asarray(a, dtype=float))
    if edge <= 0.0:
        return u
    inside = radius <= edge
    u[inside] = d - gap_function(radius[inside])
    far = radius[~inside]
    if far.size:
        springs, excess, sunk = line.carried(a, edge_excess)
        regular = springs.equivalent.displacement_integral(far, a)
        u[~inside] = 2.0 / math.pi * (regular + excess * punch_displacement(line.exponent, edge, far))
        if sunk is not None:
            u[~inside] += sunk(far)
    return u


def gap(
    line: Line, gap_function: Curve, d: float, a: Position, edge_excess: float, r: ArrayLike
) -> FloatArray:
    """
    Gap between the deformed surfaces: 0 inside the contact, f(r) - d + u(r) outside.

    Computed as an integral over g' between a and r where g is known up to r, which avoids cancellation next to the edge.

    Parameters
    ----------
    line, gap_function, d, a, edge_excess, r
        As for :func:`normal_displacement`.

    Returns
    -------
    ndarray
        Gap in m; inf beyond a sharp edge, nan where the profile does not exist.
    """
    radius: FloatArray = np.abs(np.asarray(r, dtype=float))
    end = float(np.asarray(a, dtype=float))
    if end <= 0.0:
        return gap_function(radius) - d
    h = np.zeros(radius.shape)
    equivalent = line.equivalent
    outside = (radius > end) & (radius < min(equivalent.max_radius, equivalent.edge))
    if outside.any() and end != equivalent.edge:
        springs, excess, _ = line.carried(a, edge_excess)
        h[outside] = line_gap(springs.equivalent, a, excess, radius[outside])
    far = (radius > end) & ~outside
    if far.any():
        u = normal_displacement(line, gap_function, d, a, edge_excess, radius[far])
        h[far] = gap_function(radius[far]) - d + u
    return h


def line_gap(equivalent: EquivalentProfile, a: Position, edge_excess: float, r: FloatArray) -> FloatArray:
    """
    Gap (2/pi) [int_a^r g' arccos(x/r) dx - (d - g(a)) arccos(a/r)] outside a disk, where g is known up to r.

    Parameters
    ----------
    equivalent : EquivalentProfile
        g(x).
    a : float or Place
        Contact radius in m.
    edge_excess : float
        d - g(a) in m.
    r : ndarray
        Radii in m.

    Returns
    -------
    ndarray
        Gap in m.
    """
    h = equivalent.gap_integral(r, a)
    if edge_excess != 0.0:
        h = h - edge_excess * punch_gap(equivalent.exponent, float(np.asarray(a, dtype=float)), r)
    return 2.0 / math.pi * h
