"""Lower bounds of the force on a body of any shape, by the best ellipse as trial area of contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from operator import itemgetter

import numpy as np
import scipy

from pymdr.mapping.azimuth import mean_over_ellipses
from pymdr.problem.profiles import Shape
from pymdr.units import FloatArray

_SEARCHED = 16, 24
"""Nodes along and around an ellipse in the search."""
_FINEST = 256
_SAME = 1e-9
"""Relative difference of two means at convergence."""
_DEPTHS = 6
"""Number of indentations at which ellipses are optimised; between them they are interpolated in the logarithm."""
_SMALLER, _SHRUNK = 4, 0.99
"""Largest number of reductions of an ellipse that exceeds the known part of the body, and their factor."""
_STEP, _CLOSE, _FLAT, _TRIES = 0.25, 1e-2, 1e-7, 400
"""Search: first and last steps over the radius of the disk, last relative step of the force, and largest number of trials."""


@dataclass(frozen=True)
class EllipseBounds:
    """The best bounds at some depths; nan without contact."""

    force: FloatArray
    """F / E* in m^2."""
    error: FloatArray
    """Relative error of the mean of the gap."""
    x: FloatArray
    """Position of the centre in m."""
    y: FloatArray
    longer: FloatArray
    """Semi-axes in m."""
    shorter: FloatArray
    angle: FloatArray
    """Direction of the longer semi-axis in rad."""


def ellipse_bounds(shape: Shape, depth: FloatArray, radius: FloatArray) -> EllipseBounds:
    """
    Lower bounds F = k (d - <f>) of the force, with ellipses as trial areas of contact.

    k is the stiffness of a flat elliptic punch and <f> the mean of the gap under its pressure. Of all areas the true one carries the largest force. For an ellipse with semi-axes r s and r / s, k = pi E* r s / K(e), and
    the pressure is proportional to 1 / sqrt(1 - rho^2). Centre, size, aspect ratio and direction are optimised.

    Parameters
    ----------
    shape : Shape
    depth : ndarray
        In m.
    radius : ndarray
        Of the disks of the bound about the apex, in m, from which the search starts.

    Notes
    -----
    Shield (1967), J. Appl. Math. Phys. 18, 682-693; Barber (1974), Int. J. Eng. Sci. 12, 813-819. Every
    ellipse gives a bound.

    Examples
    --------
    >>> from pymdr.problem.profiles import Function2D
    >>> wheel = Function2D(lambda x, y: x**2 / 8 + y**2 / 2)
    >>> result = ellipse_bounds(wheel, np.array([0.01]), np.array([0.1]))
    >>> round(float(result.force[0]), 7), round(float(result.longer[0] / result.shorter[0]), 2)  # by Hertz 0.0019607, 2.50
    (0.0019607, 2.5)
    """
    best = np.full((7, depth.size), math.nan)
    rows = np.flatnonzero((depth > 0.0) & (radius > 0.0) & np.isfinite(radius))
    if rows.size:
        each, first, of_depth = np.unique(depth[rows], return_index=True, return_inverse=True)
        best[:, rows] = _solved(shape, each, radius[rows][first])[:, of_depth.ravel()]
    return EllipseBounds(*best)


def _solved(shape: Shape, depth: FloatArray, radius: FloatArray) -> FloatArray:
    places = np.unique(np.linspace(0.0, depth.size - 1.0, min(_DEPTHS, depth.size)).round().astype(int))
    best: list[FloatArray] = []
    for i in places:
        tried = [_searched(shape, depth[i], radius[i], start) for start in (np.zeros(5), *best[-1:])]
        best.append(max(tried, key=itemgetter(0))[1])
    known = np.array(best)
    logs, at = np.log(depth), np.log(depth[places])
    between = np.stack([np.interp(logs, at, column) for column in known.T], axis=1)
    below = np.clip(np.searchsorted(at, logs, side="right") - 1, 0, places.size - 1)
    solutions = np.empty((7, depth.size))
    for i in range(depth.size):
        near = known[below[i]], known[min(below[i] + 1, places.size - 1)], between[i]
        force = [_force(shape, depth[i], radius[i], one, _SEARCHED)[0] for one in near]
        solutions[:, i] = _refined(
            shape, depth[i], radius[i], near[int(np.argmax(np.nan_to_num(force, nan=-math.inf)))]
        )
    return solutions


def _searched(shape: Shape, depth: float, radius: float, start: FloatArray) -> tuple[float, FloatArray]:
    """Force and ellipse: centre and logarithm of the size in units of the disk, logarithm of the stretch along 0 and 45 degrees."""

    def missing(one: FloatArray) -> float:
        force = _force(shape, depth, radius, one, _SEARCHED)[0] / (radius * depth)
        return -force if math.isfinite(force) else math.inf

    # smaller, because the known part of a body may end close to the disk
    steps = _STEP * np.diag([1.0, 1.0, -1.0, 1.0, 1.0])
    simplex = start + np.concatenate([np.zeros((1, 5)), steps])
    options = {"initial_simplex": simplex, "xatol": _CLOSE, "fatol": _FLAT, "maxfev": _TRIES}
    with np.errstate(invalid="ignore"):
        minimum = scipy.optimize.minimize(missing, start, method="Nelder-Mead", options=options)
    return -float(minimum.fun), minimum.x


def _force(
    shape: Shape, depth: float, radius: float, one: FloatArray, nodes: tuple[int, int]
) -> tuple[float, FloatArray]:
    """F / E* in m^2, and x, y, longer and shorter semi-axis and angle of the ellipse."""
    stretch, angle = math.exp(math.hypot(one[3], one[4])), 0.5 * math.atan2(one[4], one[3])
    size = radius * math.exp(one[2])
    ellipse = np.array([radius * one[0], radius * one[1], size * stretch, size / stretch, angle])
    left = depth - mean_over_ellipses(shape, ellipse, *nodes)
    return math.pi * size * stretch / float(scipy.special.ellipkm1(stretch**-4)) * left, ellipse


def _refined(shape: Shape, depth: float, radius: float, one: FloatArray) -> FloatArray:
    """Force, its error, and the ellipse, with nodes doubled until two forces agree."""
    for _ in range(_SMALLER):
        force_at = partial(_force, shape, depth, radius, one)
        nodes, change = 32, math.inf
        now, ellipse = force_at((nodes, nodes))
        while nodes < _FINEST and change > _SAME:
            nodes, before = 2 * nodes, now
            now = force_at((nodes, nodes))[0]
            change = abs(now - before) / abs(now) if now else math.inf
        if math.isfinite(now):
            break
        # the few nodes of the search may miss the unknown part of the gap
        one = one + np.array([0.0, 0.0, math.log(_SHRUNK), 0.0, 0.0])
    return np.array([now, change, *ellipse])
