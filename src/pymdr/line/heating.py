"""Heat of currents and of friction in a contact."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError
from pymdr.line.curves import ElasticLine
from pymdr.numerics.panels import Place
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

LORENZ = 2.443e-8
"""Lorenz number of metals, L = (pi k/e)^2/3 in V^2/K^2 (Sommerfeld)."""

_NODES = (16, 32, 64, 128, 256)
_TOLERANCE, _TOLERABLE = 1e-12, 1e-6
_GRADING = 0.25 ** np.arange(20, 0, -1.0)


def largest_rise(voltage: ArrayLike, temperature: ArrayLike) -> FloatArray:
    """
    Rise T_max - T0 of the hottest place of a contact under a voltage, T_max^2 = T0^2 + V^2/(4 L).

    Parameters
    ----------
    voltage : array_like
        V in V.
    temperature : array_like
        T0 of the bodies in K.

    Returns
    -------
    ndarray
        In K.

    Notes
    -----
    Kohlrausch (1900); Holm (1967): with rho lambda = L T in both bodies T^2 + phi^2/L is the same everywhere, phi the potential
    from its mean.

    Examples
    --------
    >>> rise = largest_rise(0.1, 300.0)
    >>> bool(abs((rise + 300.0) ** 2 - 300.0**2 - 0.1**2 / (4 * LORENZ)) < 1e-9)
    True
    """
    t0, height = np.asarray(temperature), 0.5 * np.abs(voltage) / math.sqrt(LORENZ)
    return np.asarray(height * (height / (np.hypot(t0, height) + t0)))


def current_load(voltage: ArrayLike, temperature: ArrayLike) -> FloatArray:
    """
    Current times cold resistance under a voltage, I R0 = 2 T0 sqrt(L) arctan(V/(2 T0 sqrt(L))).

    It equals 2 T0 sqrt(L) arccos(T0/T_max), and is below pi T0 sqrt(L).

    Parameters
    ----------
    voltage, temperature
        As for :func:`largest_rise`.

    Returns
    -------
    ndarray
        I R0 in V.

    Notes
    -----
    Holm (1967), with a lambda that does not change: the current is the integral of d phi/rho = lambda d phi/(L T).

    Examples
    --------
    >>> float(current_load(2.0 * math.sqrt(LORENZ) * 300.0, 300.0) / (math.sqrt(LORENZ) * 300.0) / math.pi)
    0.5
    """
    scale = 2.0 * math.sqrt(LORENZ) * np.asarray(temperature)
    return np.asarray(scale * np.arctan2(voltage, scale))


def frictional_rise(
    displacement: ArrayLike, modulus: float, shear_speed: ArrayLike, conductivity: float
) -> FloatArray:
    """
    Temperature rise T = mu v E* u / (2 (lambda_1 + lambda_2)) of slowly sliding surfaces.

    Heat mu v p and pressure p act through the same kernel 1/R, so the temperature is proportional to the displacement.

    Parameters
    ----------
    displacement : array_like
        u in m, d - f(r) in the contact.
    modulus : float
        E* in Pa.
    shear_speed : array_like
        mu v in m/s.
    conductivity : float
        lambda_1 + lambda_2 in W/(m K).

    Returns
    -------
    ndarray
        In K.

    Notes
    -----
    Popov and Hess (2015), chapter 8, for one conducting body; of two with equal temperatures far away the sum conducts. Exact
    as the Peclet number goes to 0.

    Examples
    --------
    >>> float(frictional_rise(1e-4, 1e6, 0.3 * 2.0, 40.0))
    0.75
    """
    return np.asarray(
        0.5 * np.asarray(shear_speed) * (modulus / conductivity) * np.asarray(displacement, dtype=float)
    )


def mean_displacement(line: ElasticLine, a: float, d: float) -> tuple[float, float]:
    """
    Mean of d - f(r) over the contact, (4/(pi a^2)) int_0^a (d - g) sqrt(a^2 - x^2) dx, and its error.

    Parameters
    ----------
    line : ElasticLine
        Of homogeneous half-spaces.
    a, d : float
        Contact radius and indentation in m.

    Returns
    -------
    mean : float
        In m.
    error : float
        Relative to it.

    Raises
    ------
    ConvergenceError
        If the quadrature does not settle.

    Notes
    -----
    f(r) = (2/pi) int_0^r g/sqrt(r^2 - x^2) dx, integrated over the disk first over r.

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> round(mean_displacement(ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0), 0.1, 0.01)[0], 15)
    0.0075
    """
    inside = [x for x in line.equivalent.kinks(a) if 0.0 < x < a]
    begin = np.unique([0.0, *(a * _GRADING), *inside])[:, None]
    angle = np.arctan2(begin, np.sqrt((a - begin) * (a + begin)))
    width = np.diff(angle, axis=0, append=0.5 * math.pi)
    before, mean = math.nan, math.nan
    for n in _NODES:
        t, w = gauss(n)
        # after a kink g grows like a root
        away = width * t**2
        cosine = np.cos(angle + away)
        offset = 2.0 * a * np.cos(angle + 0.5 * away) * np.sin(0.5 * away)
        place = Place(np.broadcast_to(begin, offset.shape).ravel(), offset.ravel())
        springs = d - line.equivalent.g(place).reshape(offset.shape)
        mean = float(4.0 / math.pi * np.sum(2.0 * width * t * w * springs * cosine**2))
        error = abs(mean - before) / mean
        if error <= _TOLERANCE:
            return mean, error
        before = mean
    if error <= _TOLERABLE:
        return mean, error
    raise ConvergenceError(
        f"the mean of the profile does not converge: {mean:.6g} m with {_NODES[-1]} nodes, relative error {error:.1g}; name the radii where the profile is not smooth as breakpoints"
    )
