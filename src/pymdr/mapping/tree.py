"""How many panels of a slope act on many panels of the line: the tree of `charges`, compiled. Loads numba.

Neighbouring targets are groups: what lies at least a group's width below one acts on it as a polynomial. Nearer bunches of panels
act on the places of each target by their nodes, and the nearest panels by a rule that takes out the square root.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pymdr.compiling import compiled, inner
from pymdr.numerics.panels import IndexArray, nodes, to_coefficients
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

_GROUP = 4
"""Targets of a group."""
_POINTS = 20
"""Chebyshev points of a group."""
_FLAT = 0.05
"""Distance from x over 2 x up to which few Gauss nodes integrate a parabola over the square root."""
_FEW, _NEAR = 8, 24
_STACK = 256
"""More than twice the levels of any tree."""


class Tree(NamedTuple):
    """Bunches of all levels in one, the panels first, and the series of the panels."""

    first: IndexArray
    """Where the bunches of every level begin, and where the last one ends, shape (L + 1,)."""
    base: FloatArray
    low: FloatArray
    high: FloatArray
    gap: FloatArray
    """Distance from which the nodes of a bunch act, in m."""
    offset: FloatArray
    """Nodes as offsets in m, shape (B, n)."""
    charges: FloatArray
    """Those of f', f' r^2 and (r f')' at the nodes, shape (3, B, n)."""
    coefficients: FloatArray
    """Chebyshev coefficients of f' on the panels, shape (P, m)."""
    power: FloatArray
    """Whole powers that are divided out there, shape (P,)."""


class Rules(NamedTuple):
    """Points of groups and Gauss rules."""

    points: FloatArray
    matrix: FloatArray
    few: FloatArray
    """Nodes and weights, shape (2, n)."""
    near: FloatArray


def act(tree: Tree, base: FloatArray, offset: FloatArray) -> FloatArray:
    """
    Integrals of f', f' r^2 and (r f')' over 1 / sqrt(x^2 - r^2) at places on panels.

    Parameters
    ----------
    tree : Tree
    base : ndarray, shape (T,)
        From which the offsets of targets count, in m; targets rise.
    offset : ndarray, shape (T, k)

    Returns
    -------
    ndarray
        Of shape (3, T, k).
    """
    totals = np.zeros((base.size, 3, offset.shape[1]))
    ends = np.stack([offset.min(axis=1), offset.max(axis=1)])
    rules = Rules(
        np.array(nodes(_POINTS)),
        np.array(to_coefficients(_POINTS)),
        np.array(gauss(_FEW)),
        np.array(gauss(_NEAR)),
    )
    _groups(tree, rules, np.array(base), np.array(offset), ends, totals)
    return np.moveaxis(totals, 1, 0)


@compiled
def _groups(
    tree: Tree, rules: Rules, base: FloatArray, offset: FloatArray, ends: FloatArray, totals: FloatArray
) -> None:
    """Add to the totals of all targets, shape (T, 3, k)."""
    count, k = offset.shape
    size = rules.points.size
    far = np.empty((3, size))
    coefficients = np.empty((3, size))
    spare = np.empty((5, max(k, size)))
    close = np.empty((2, 4 * tree.first[1] + 4), dtype=np.int64)
    start = 0
    while start < count:
        stop, b = start + 1, base[start]
        low, high = ends[0, start], ends[1, start]
        while stop < count and stop < start + _GROUP:
            # a gap between targets, or one that is far wider, ends a group
            shift = base[stop] - b
            width = ends[1, stop] - ends[0, stop]
            if (
                shift + ends[0, stop] - high > high - low
                or width > 4.0 * (high - low)
                or 16.0 * width < high - low
            ):
                break
            high = shift + ends[1, stop]
            stop += 1
        far[:] = 0.0
        listed = _from_afar(tree, b, low, high, rules.points, far, close, spare)
        for j in range(3):
            for m in range(size):
                total = 0.0
                for i in range(size):
                    total += rules.matrix[m, i] * far[j, i]
                coefficients[j, m] = total
        for t in range(start, stop):
            for i in range(k):
                twice = 4.0 * ((base[t] - b) + offset[t, i] - low) / (high - low) - 2.0
                for j in range(3):
                    last, before = 0.0, 0.0
                    for m in range(size - 1, 0, -1):
                        last, before = coefficients[j, m] + twice * last - before, last
                    totals[t, j, i] += coefficients[j, 0] + 0.5 * twice * last - before
            for i in range(listed):
                _descend(
                    tree, rules, close[0, i], close[1, i], base[t], ends[:, t], offset[t], totals[t], spare
                )
        start = stop


@inner
def _from_afar(
    tree: Tree,
    base: float,
    low: float,
    high: float,
    points: FloatArray,
    far: FloatArray,
    close: FloatArray,
    spare: FloatArray,
) -> int:
    """Add what acts on a group from afar at its points; the bunches that are too close for that are listed, and counted."""
    stack = np.empty((_STACK, 2), dtype=np.int64)
    stack[0, 0], stack[0, 1] = tree.first.size - 2, 0
    waiting, listed, width = 1, 0, high - low
    place = low + width * points
    while waiting:
        waiting -= 1
        level, i = stack[waiting, 0], stack[waiting, 1]
        j = tree.first[level] + i
        shift = base - tree.base[j]
        if shift + high <= tree.low[j]:
            continue
        distance = shift + low - tree.high[j]
        if distance >= tree.gap[j] and distance >= width:
            _by_nodes(tree, j, base, place, far, spare)
        elif level == 0 or tree.high[j] - tree.low[j] <= 0.5 * width:
            close[0, listed], close[1, listed] = level, i
            listed += 1
        else:
            waiting = _push_children(tree, level, i, stack, waiting)
    return listed


@inner
def _push_children(tree: Tree, level: int, i: int, stack: IndexArray, waiting: int) -> int:
    for child in (2 * i, 2 * i + 1):
        if child < tree.first[level] - tree.first[level - 1]:
            stack[waiting, 0], stack[waiting, 1] = level - 1, child
            waiting += 1
    return waiting


@inner
def _descend(
    tree: Tree,
    rules: Rules,
    level: int,
    i: int,
    base: float,
    ends: FloatArray,
    offset: FloatArray,
    total: FloatArray,
    spare: FloatArray,
) -> None:
    """Add what a bunch does to one target."""
    stack = np.empty((_STACK, 2), dtype=np.int64)
    stack[0, 0], stack[0, 1] = level, i
    waiting = 1
    while waiting:
        waiting -= 1
        level, i = stack[waiting, 0], stack[waiting, 1]
        j = tree.first[level] + i
        shift = base - tree.base[j]
        if shift + ends[1] <= tree.low[j]:
            continue
        if shift + ends[0] - tree.high[j] >= tree.gap[j]:
            _by_nodes(tree, j, base, offset, total, spare)
        elif level:
            waiting = _push_children(tree, level, i, stack, waiting)
        else:
            _beside(tree, rules, j, base, offset, total, spare)


@inner
def _by_nodes(
    tree: Tree, j: int, base: float, offset: FloatArray, total: FloatArray, spare: FloatArray
) -> None:
    """Add what the nodes of a bunch do to places."""
    b = tree.base[j]
    shift = base - b
    for n in range(tree.offset.shape[1]):
        at = tree.offset[j, n]
        f, moment, rate = tree.charges[0, j, n], tree.charges[1, j, n], tree.charges[2, j, n]
        if f == 0.0 and rate == 0.0:
            continue
        for i in range(offset.size):
            kernel = 1.0 / math.sqrt((shift + offset[i] - at) * (base + offset[i] + (b + at)))
            total[0, i] += f * kernel
            total[1, i] += moment * kernel
            total[2, i] += rate * kernel


@inner
def _beside(
    tree: Tree,
    rules: Rules,
    j: int,
    base: float,
    offset: FloatArray,
    total: FloatArray,
    spare: FloatArray,
) -> None:
    """Add what a panel does to places close to it, or on it, by r = x - v^2."""
    b, low, high = tree.base[j], tree.low[j], tree.high[j]
    shift = base - b
    degree = tree.coefficients.shape[1]
    while degree > 1 and tree.coefficients[j, degree - 1] == 0.0:
        degree -= 1
    last = shift + offset[offset.size - 1]
    parabola = degree <= 3 and tree.power[j] == 0.0
    rule = rules.near
    if parabola and last - low <= _FLAT * (2.0 * b + last + low):
        rule = rules.few
    near, step = spare[0], spare[1]
    for i in range(offset.size):
        near[i] = math.sqrt(max((shift - high) + offset[i], 0.0))
        step[i] = math.sqrt(max((shift - low) + offset[i], 0.0)) - near[i]
    c0, c1 = tree.coefficients[j, 0], tree.coefficients[j, 1]
    c2 = tree.coefficients[j, 2]
    scale = 2.0 / (high - low)
    for n in range(rule.shape[1]):
        s, weight = rule[0, n], 2.0 * rule[1, n]
        for i in range(offset.size):
            v = near[i] + step[i] * s
            place = shift + offset[i]
            r = min(max(place - v * v, low), high)
            if parabola:
                z = (r - low) * scale - 1.0
                f = (c0 - c2) + z * (c1 + 2.0 * c2 * z)
                rate = (c1 + 4.0 * c2 * z) * scale
            else:
                f, rate = _series(tree, j, degree, r)
            kernel = step[i] * weight / math.sqrt(2.0 * b + place + r)
            total[0, i] += f * kernel
            total[1, i] += f * (b + r) * (b + r) * kernel
            total[2, i] += (f + (b + r) * rate) * kernel


@inner
def _series(tree: Tree, j: int, degree: int, r: float) -> tuple[float, float]:
    """F' on a panel and its derivative by r."""
    low, high, p = tree.low[j], tree.high[j], tree.power[j]
    scale = 2.0 / (high - low)
    z = (r - low) * scale - 1.0
    value, before, rate, rate_before = 0.0, 0.0, 0.0, 0.0
    for m in range(degree - 1, 0, -1):
        rate, rate_before = 2.0 * z * rate - rate_before + 2.0 * value, rate
        value, before = tree.coefficients[j, m] + 2.0 * z * value - before, value
    f = tree.coefficients[j, 0] + z * value - before
    slope = (value + z * rate - rate_before) * scale
    if p == 0.0:
        return f, slope
    y = r / high
    return f * y**p, slope * y**p + p * f * y ** (p - 1.0) / high
