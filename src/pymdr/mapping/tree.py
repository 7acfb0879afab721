"""Compiled tree sums of :mod:`~pymdr.mapping.abel_sums` for many panels. Loads numba.

Neighbouring targets form groups. Sources at a distance of at least the width of a group act on it as a polynomial, nearer
tree nodes on each target by their points, and the nearest panels by a quadrature rule that removes the square root.
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
    """Nodes of all levels, the panels first, and the series of the panels."""

    first: IndexArray
    """Index of the first node of every level, and the total number of nodes, shape (L + 1,)."""
    base: FloatArray
    low: FloatArray
    high: FloatArray
    gap: FloatArray
    """Least distance in m at which a node acts by its points."""
    offset: FloatArray
    """Points as offsets in m, shape (B, n)."""
    strengths: FloatArray
    """Source strengths of f', f' r^2 and (r f')' at the points, shape (3, B, n)."""
    coefficients: FloatArray
    """Chebyshev coefficients of f' on the panels, shape (P, m)."""
    power: FloatArray
    """Integer powers divided out of the series, shape (P,)."""


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
    base : ndarray, shape (T,)
        Origin of the offsets of the targets in m; targets rise.
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
    near_nodes = np.empty((2, 4 * tree.first[1] + 4), dtype=np.int64)
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
        near_count = _from_afar(tree, b, low, high, rules.points, far, near_nodes)
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
            for i in range(near_count):
                _descend(
                    tree,
                    rules,
                    (near_nodes[0, i], near_nodes[1, i]),
                    base[t],
                    ends[:, t],
                    offset[t],
                    totals[t],
                    spare,
                )
        start = stop


@compiled
def _from_afar(
    tree: Tree,
    base: float,
    low: float,
    high: float,
    points: FloatArray,
    far: FloatArray,
    near_nodes: FloatArray,
) -> int:
    """Add the sums over distant nodes at the points of a group; list and count the nodes that are too close."""
    stack = np.empty((_STACK, 2), dtype=np.int64)
    stack[0, 0], stack[0, 1] = tree.first.size - 2, 0
    waiting, near_count, width = 1, 0, high - low
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
            _by_nodes(tree, j, base, place, far)
        elif level == 0 or tree.high[j] - tree.low[j] <= 0.5 * width:
            near_nodes[0, near_count], near_nodes[1, near_count] = level, i
            near_count += 1
        else:
            waiting = _push_children(tree, level, i, stack, waiting)
    return near_count


@inner
def _push_children(tree: Tree, level: int, i: int, stack: IndexArray, waiting: int) -> int:
    """Append the children of a node to the stack; return its new length."""
    for child in (2 * i, 2 * i + 1):
        if child < tree.first[level] - tree.first[level - 1]:
            stack[waiting, 0], stack[waiting, 1] = level - 1, child
            waiting += 1
    return waiting


@compiled
def _descend(
    tree: Tree,
    rules: Rules,
    node: tuple[int, int],
    base: float,
    ends: FloatArray,
    offset: FloatArray,
    total: FloatArray,
    spare: FloatArray,
) -> None:
    """Add the sums over a node and its children at one target."""
    stack = np.empty((_STACK, 2), dtype=np.int64)
    stack[0, 0], stack[0, 1] = node
    waiting = 1
    while waiting:
        waiting -= 1
        level, i = stack[waiting, 0], stack[waiting, 1]
        j = tree.first[level] + i
        shift = base - tree.base[j]
        if shift + ends[1] <= tree.low[j]:
            continue
        if shift + ends[0] - tree.high[j] >= tree.gap[j]:
            _by_nodes(tree, j, base, offset, total)
        elif level:
            waiting = _push_children(tree, level, i, stack, waiting)
        else:
            _add_adjacent(tree, rules, j, base, offset, total, spare)


@inner
def _by_nodes(tree: Tree, j: int, base: float, offset: FloatArray, total: FloatArray) -> None:
    """Add the sums over the points of a node at given places."""
    b = tree.base[j]
    shift = base - b
    for n in range(tree.offset.shape[1]):
        at = tree.offset[j, n]
        f, moment, rate = tree.strengths[0, j, n], tree.strengths[1, j, n], tree.strengths[2, j, n]
        if f == 0.0 and rate == 0.0:
            continue
        for i in range(offset.size):
            kernel = 1.0 / math.sqrt((shift + offset[i] - at) * (base + offset[i] + (b + at)))
            total[0, i] += f * kernel
            total[1, i] += moment * kernel
            total[2, i] += rate * kernel


@inner
def _add_adjacent(
    tree: Tree,
    rules: Rules,
    j: int,
    base: float,
    offset: FloatArray,
    total: FloatArray,
    spare: FloatArray,
) -> None:
    """Add the integrals over a panel at places close to it, or on it, by r = x - v^2."""
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
