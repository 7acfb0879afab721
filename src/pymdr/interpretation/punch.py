"""Pressure, displacement and gap of a flat punch for a unit of excess depth at the edge.

For springs of stiffness c |x|^k per length: k = 0 for homogeneous half-spaces (Sneddon 1965), others for graded ones (Booker,
Balaam and Davis 1985; Hess 2016). Pressures are over c / pi, gaps and displacements over 2 / pi.
"""

from __future__ import annotations

import numpy as np

from pymdr.mapping.kernels import arc_above, arc_below
from pymdr.units import FloatArray


def punch_pressure(exponent: float, a: float | FloatArray, r: FloatArray) -> FloatArray:
    """
    Pressure (a^2 - r^2)^((k - 1) / 2) inside the edge.

    Examples
    --------
    >>> punch_pressure(0.0, 1.0, np.array([0.0, 0.6])).tolist()
    [1.0, 1.25]
    """
    inside = (a - r) * (a + r)
    return np.asarray(1.0 / np.sqrt(inside) if exponent == 0.0 else inside ** (0.5 * (exponent - 1.0)))


def punch_displacement(exponent: float, a: float, r: FloatArray) -> FloatArray:
    """
    Displacement (pi/2) I(a^2 / r^2; (1+k)/2, (1-k)/2) outside the edge, arcsin(a / r) for k = 0.

    Examples
    --------
    >>> bool(abs(punch_displacement(1e-9, 1.0, np.array([2.0]))[0] - np.arcsin(0.5)) < 1e-8)
    True
    """
    if exponent == 0.0:
        return np.asarray(np.arctan2(a, np.sqrt((r - a) * (r + a))))
    return arc_below(a / r, (r - a) * (r + a) / (r * r), exponent)


def punch_gap(exponent: float, a: float, r: FloatArray) -> FloatArray:
    """
    Gap (pi/2) I(1 - a^2 / r^2; (1-k)/2, (1+k)/2) outside the edge, arccos(a / r) for k = 0.

    Examples
    --------
    >>> whole = punch_gap(0.3, 1.0, np.array([2.0])) + punch_displacement(0.3, 1.0, np.array([2.0]))
    >>> bool(abs(whole[0] - np.pi / 2) < 1e-15)
    True
    """
    if exponent == 0.0:
        return np.asarray(np.arctan2(np.sqrt((r - a) * (r + a)), a))
    return arc_above(a / r, (r - a) * (r + a) / (r * r), exponent)
