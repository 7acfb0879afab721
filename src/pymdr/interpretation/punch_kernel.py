"""The closed forms of punches summed over a tree of intervals of the line, for many points at once. Loads numba.

An interval far from a point, on the scale of its width, acts by a few punches. The density of a near one is a series, and its integral
is taken over t with s = r + z sinh(t), where the closed forms are smooth.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pymdr.compiling import INNER, compiled
from pymdr.units import FloatArray

IntArray = np.ndarray

NODES = 20
"""Punches of an interval, and terms of its series."""
FORMS = 9
"""1/R, z zeta/R^3, 1/P, z/(R P), z r/R^3, r/(R P), r/P^2, z r/(R P^2), ln P: their imaginary parts."""
FAR = 5.2
"""rho + 1/rho of the ellipse around an interval on which a point has to lie for the punches: with 20 of them the error is rho^-20."""
PANEL = 2.6
"""Largest interval of t: 16 nodes leave about 2.8^-32."""

_X, _W = np.polynomial.legendre.leggauss(16)
_FAR_X = np.polynomial.legendre.leggauss(NODES)[0]


class Cells(NamedTuple):
    """Intervals of the line, parents before their halves, in a unit of length of about the loaded radius."""

    anchor: FloatArray
    """Reference radius (anchor) from which offsets are measured."""
    low: FloatArray
    """Lower end, counted from the anchor; the very number that is the upper end of the interval below."""
    high: FloatArray
    """Upper end."""
    weights: FloatArray
    """Weights of the punches, shape (n, NODES)."""
    series: FloatArray
    """Chebyshev coefficients of the density of a leaf, shape (n, NODES)."""
    terms: IntArray
    """Number of significant coefficients."""
    left: IntArray
    """The lower half, -1 for a leaf."""
    right: IntArray
    """The upper half."""


def _add(out: FloatArray, r: float, z: float, above: float, weight: float, logarithm: bool) -> None:
    """The closed forms of a punch of radius r + above."""
    s = r + above
    real, imaginary = z * z - above * (r + s), 2.0 * z * s
    size = math.sqrt(real * real + imaginary * imaginary)
    if real >= 0.0:
        root_r = math.sqrt(0.5 * (size + real))
        root_i = 0.5 * imaginary / root_r
    else:
        root_i = math.sqrt(0.5 * (size - real))
        root_r = 0.5 * imaginary / root_i
    scale = 1.0 / size
    inv_r, inv_i = root_r * scale, -root_i * scale
    total_r, total_i = root_r + z, root_i + s
    scale = 1.0 / (total_r * total_r + total_i * total_i)
    mean_r, mean_i = total_r * scale, -total_i * scale
    both_r, both_i = inv_r * mean_r - inv_i * mean_i, inv_r * mean_i + inv_i * mean_r
    two_r, two_i = inv_r * inv_r - inv_i * inv_i, 2.0 * inv_r * inv_i
    three_r, three_i = two_r * inv_r - two_i * inv_i, two_r * inv_i + two_i * inv_r
    deep, across = weight * z, weight * r
    out[0] += weight * inv_i
    out[1] += deep * (three_r * s + three_i * z)
    out[2] += weight * mean_i
    out[3] += deep * both_i
    out[4] += deep * r * three_i
    out[5] += across * both_i
    out[6] += across * 2.0 * mean_r * mean_i
    out[7] += deep * r * (both_r * mean_i + both_i * mean_r)
    if logarithm:
        out[8] += weight * math.atan2(total_i, total_r)


def _add_near(
    out: FloatArray,
    r: float,
    z: float,
    place: tuple[float, float],
    series: FloatArray,
    terms: int,
    logarithm: bool,
) -> None:
    """The punches of a near interval."""
    bottom, top = place
    middle, half = 0.5 * (bottom + top), 0.5 * (top - bottom)
    for part in range(2):
        low, high = bottom, top
        if part == 0:
            high = min(high, 0.0)
        else:
            low = max(low, 0.0)
        if high <= low:
            continue
        first, last = math.asinh(low / z), math.asinh(high / z)
        panels = math.ceil((last - first) / PANEL)
        width = 0.5 * (last - first) / max(panels, 1)
        for panel in range(panels):
            start = first + (2 * panel + 1) * width
            for k in range(_X.size):
                grown = math.exp(start + width * _X[k])
                shrunk = 1.0 / grown
                above = 0.5 * z * (grown - shrunk)
                u = 2.0 * min(max((above - middle) / half, -1.0), 1.0)
                now, before = 0.0, 0.0
                for j in range(terms - 1, 0, -1):
                    now, before = series[j] + u * now - before, now
                density = series[0] + 0.5 * u * now - before
                _add(out, r, z, above, 0.5 * width * _W[k] * z * (grown + shrunk) * density, logarithm)


def _summed(cells: Cells, r: FloatArray, z: FloatArray, out: FloatArray, logarithm: bool) -> None:
    """The sums at points, into an array of zeros of shape (points, FORMS)."""
    anchor, low, high, weights, series, terms, left, right = cells
    waiting = np.empty(128, dtype=np.int64)
    for i in range(r.size):
        count = 1
        waiting[0] = 0
        while count > 0:
            count -= 1
            cell = waiting[count]
            bottom, top = (anchor[cell] - r[i]) + low[cell], (anchor[cell] - r[i]) + high[cell]
            away, h = 0.5 * (bottom + top), 0.5 * (high[cell] - low[cell])
            near, far = math.hypot(away - h, z[i]), math.hypot(away + h, z[i])
            if near + far >= FAR * h:
                for k in range(NODES):
                    _add(out[i], r[i], z[i], away + h * _FAR_X[k], weights[cell, k], logarithm)
            elif left[cell] >= 0:
                waiting[count] = left[cell]
                waiting[count + 1] = right[cell]
                count += 2
            else:
                _add_near(out[i], r[i], z[i], (bottom, top), series[cell], terms[cell], logarithm)


_add = compiled(_add, None, **INNER)
_add_near = compiled(_add_near, None, **INNER)
summed = compiled(_summed)
