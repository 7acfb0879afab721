"""Sums over the pressures of many disks: one integral along the line, evaluated at all their edges."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from pymdr.line.foundation import ElasticLine
from pymdr.units import FloatArray

_NODES, _LEVELS, _MAX_CELLS = 16, 60, 20_000
_SETTLED = 1e-14
_POINTS = -np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES)
_FIT = np.linalg.inv(chebyshev.chebvander(_POINTS, _NODES - 1))


def pressure_integrals(line: ElasticLine, r: float, start: float, edges: FloatArray) -> FloatArray | None:
    """
    The integrals of g' / sqrt(x^2 - r^2) from one radius to many others.

    With x^2 = r^2 + t^2 the integrand is g' / x dt. The substitution t - t_kink ~ s^2 makes it smooth after every kink;
    Chebyshev series on adaptively halved cells resolve it and are integrated in closed form.

    Parameters
    ----------
    r : float
        Radius in m.
    start : float
        Lower limit in m, at least r.
    edges : ndarray
        Upper limits in m, rising, above `start`.

    Returns
    -------
    ndarray or None
        Dimensionless; None if g' cannot be resolved.
    """
    top = float(edges[-1])
    marks = np.array([start, *(k for k in line.equivalent.kinks(top) if start < k < top), top])
    t = np.sqrt((marks - r) * (marks + r))
    width = np.diff(marks) * (marks[1:] + marks[:-1]) / (t[1:] + t[:-1])

    def integrand(stretch: NDArray[np.intp], s: FloatArray) -> FloatArray:
        along = t[stretch] + width[stretch] * s * s
        x = np.clip(np.hypot(r, along), np.nextafter(marks[stretch], top), marks[stretch + 1])
        return np.asarray(2.0 * width[stretch] * s * line.equivalent.slope(x) / x)

    cells = _resolved(integrand, marks.size - 1)
    if cells is None:
        return None
    keys, half, series, before = cells
    stretch = np.clip(np.searchsorted(marks, edges, side="left") - 1, 0, marks.size - 2)
    behind = edges - marks[stretch]
    distance = behind * (edges + marks[stretch]) / (np.sqrt((edges - r) * (edges + r)) + t[stretch])
    s = np.sqrt(np.clip(distance / width[stretch], 0.0, 1.0))
    cell = np.clip(np.searchsorted(keys, stretch + np.minimum(s, 1.0 - 1e-16), side="right") - 1, 0, None)
    at = np.clip((stretch + s - keys[cell]) / half[cell] - 1.0, -1.0, 1.0)
    return np.asarray(before[cell] + _values(series[cell], at))


def _resolved(
    integrand: Callable[[NDArray[np.intp], FloatArray], FloatArray], stretches: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray] | None:
    """Keys (stretch + s) of cells, their half widths, antiderivatives from their starts, and integrals up to them."""
    owner, low, high = np.arange(stretches), np.zeros(stretches), np.ones(stretches)
    resolved: list[tuple[FloatArray, ...]] = []
    size = 0.0
    for _ in range(_LEVELS):
        half = 0.5 * (high - low)
        s = low[:, None] + half[:, None] * (_POINTS + 1.0)
        series = integrand(np.repeat(owner, _NODES), s.ravel()).reshape(s.shape) @ _FIT.T * half[:, None]
        if not np.all(np.isfinite(series)):
            return None
        size = max(size, float(np.max(np.abs(series).sum(axis=1))))
        good = np.max(np.abs(series[:, -2:]), axis=1) <= _SETTLED * size
        resolved.append((owner[good] + low[good], half[good], series[good]))
        owner, low, high = owner[~good], low[~good], high[~good]
        if owner.size == 0:
            break
        middle = 0.5 * (low + high)
        owner, low, high = np.tile(owner, 2), np.append(low, middle), np.append(middle, high)
        if owner.size > _MAX_CELLS:
            return None
    else:
        return None
    keys, half, series = (np.concatenate([part[i] for part in resolved]) for i in range(3))
    order = np.argsort(keys)
    own = np.asarray(chebyshev.chebint(series[order], lbnd=-1.0, axis=1), dtype=float)
    total = np.asarray(own.sum(axis=1), dtype=float)
    before = np.cumsum(total) - total
    return keys[order], half[order], own, before


def _values(series: FloatArray, x: FloatArray) -> FloatArray:
    """Chebyshev series, one for each point."""
    one, two = np.zeros(x.shape), np.zeros(x.shape)
    for column in series.T[:0:-1]:
        one, two = column + 2.0 * x * one - two, one
    return series[:, 0] + x * one - two


def grouped(values: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Distinct values, with the sums of their weights and of the absolute weights."""
    distinct = np.unique(values, return_inverse=True)
    different: FloatArray = distinct[0]
    inverse = distinct[1]
    total: FloatArray = np.zeros(different.size)
    size: FloatArray = np.zeros(different.size)
    np.add.at(total, inverse, weights)
    np.add.at(size, inverse, np.abs(weights))
    return different, total, size


def stretches_of(edges: FloatArray) -> list[tuple[int, int]]:
    """Slices of a long array, which limit the size of tables."""
    marks = [*range(0, edges.size, 4096), edges.size]
    return list(pairwise(marks))
