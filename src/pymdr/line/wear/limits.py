"""The limiting profile of fretting wear under constant indentation, in closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymdr.line.wear.mesh import Curve, inner_integral
from pymdr.numerics.quadrature import gauss
from pymdr.numerics.roots import rising_root
from pymdr.units import FloatArray

_NODES = 64
_DOUBLINGS = 60


@dataclass(frozen=True)
class WearLimit:
    """The end of wear under constant indentation."""

    radius: float
    """Radius b in m at which the limiting profile meets the original one."""
    volume: float
    """Worn volume in m^3."""
    half_load: float
    """int_0^c (d - g) dx in m^2; the load is 2 E* times it."""


def limiting_profile(
    r: FloatArray, depth: float, stick: float, gap: Curve, kinks: tuple[float, ...] = ()
) -> FloatArray:
    """
    The limiting profile beyond the stick radius, f = (2/pi) [int_0^c g/sqrt(r^2 - x^2) dx + d arccos(c/r)].

    Parameters
    ----------
    r : ndarray
        Radii in m, at least c.
    depth, stick : float
        Indentation d and stick radius c in m.
    gap : callable
        g(x) of the profile before wear.
    kinks : tuple of float
        Where g' jumps, in m.

    Returns
    -------
    ndarray
        In m; the worn profile is the larger of it and the original one.

    Notes
    -----
    Popov (2014); Dimaki, Dmitriev, Menga, Papangelo, Ciavarella and Popov (2016). Beyond c the bodies touch without pressure.

    Examples
    --------
    >>> import numpy as np
    >>> ball = limiting_profile(np.array([0.4]), 0.25, 0.3, lambda x: x**2)
    >>> round(float(ball[0]), 12)
    0.132953111134
    """
    return inner_integral(r, stick, gap, kinks) + 2.0 / math.pi * depth * np.arccos(stick / r)


def outer_radius(
    depth: float,
    stick: float,
    gap: Curve,
    profile: Curve,
    kinks: tuple[float, ...] = (),
    radius: float = 0.0,
) -> float:
    """
    The radius b in m at which the limiting profile meets the original one; inf if they never meet.

    Where nothing sticks the search begins at `radius`, that of the contact before wear in m.

    Examples
    --------
    >>> round(outer_radius(0.25, 0.3, lambda x: x**2, lambda r: 0.5 * r**2), 12)
    0.593615999299
    """

    def below(r: FloatArray) -> FloatArray:
        if stick > 0.0:
            return profile(r) - limiting_profile(r, depth, stick, gap, kinks)
        return profile(r) - depth

    low = stick if stick > 0.0 else radius
    high = 2.0 * low
    for _ in range(_DOUBLINGS):
        if below(np.array([high]))[0] > 0.0:
            break
        high *= 1.5
    else:
        return math.inf
    # just beyond c both profiles agree, and the original one is the lower
    start = np.array([low + 1e-9 * (high - low)])
    return float(rising_root(below, np.zeros(1), start, np.array([high]))[0])


def wear_limit(
    depth: float,
    stick: float,
    gap: Curve,
    profile: Curve,
    kinks: tuple[float, ...] = (),
    radius: float = 0.0,
) -> WearLimit:
    """
    Radius, volume and load at which wear under constant indentation ends; `radius` as for `outer_radius`.

    Examples
    --------
    >>> end = wear_limit(0.25, 0.3, lambda x: x**2, lambda r: 0.5 * r**2)
    >>> round(2.0 * end.half_load, 12)
    0.132
    """
    b = outer_radius(depth, stick, gap, profile, kinks, radius)
    t, weight = gauss(_NODES)
    marks = np.array([stick, *(k for k in kinks if stick < k < b), b])
    width = np.diff(marks)[:, None]
    # beyond c and beyond a kink the depth grows like a root
    r = (marks[:-1, None] + width * t * t).ravel()
    worn = (limiting_profile(r, depth, stick, gap, kinks) if stick > 0.0 else depth) - profile(r)
    scale = (2.0 * width * t * weight).ravel()
    volume = 2.0 * math.pi * float(np.sum(scale * r * worn))
    inner = np.array([0.0, *(k for k in kinks if 0.0 < k < stick), stick])
    steps = np.diff(inner)[:, None]
    springs = depth - gap((inner[:-1, None] + steps * t).ravel()).reshape(steps.size, -1)
    return WearLimit(b, volume, float(np.sum(steps * weight * springs)))
