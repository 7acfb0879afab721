"""Compiled kernels of force control: the same stack in (F_N, F_x / mu). Loads numba."""

from __future__ import annotations

import math
from typing import Any

from numpy.polynomial.legendre import leggauss

from pymdr.line.friction.kernels import MEET, Point, at, base, extend, moment, put, vertex
from pymdr.line.friction.layout import MODULUS
from pymdr.line.friction.reading import compiled, curve, depth_of_force, inlined
from pymdr.units import FloatArray

_OUTER, _INNER = (
    tuple((0.5 * (float(x) + 1.0), 0.5 * float(w)) for x, w in zip(*leggauss(n), strict=True)) for n in (6, 4)
)
_ROUNDED = 1e-14  # of force times depth: what the closed form of the slip work loses on a table


@compiled
def mean_depth(line: FloatArray, upper: float, lower: float) -> float:
    """Mean of d over the forces between F_N(lower) and F_N(upper)."""
    if upper == lower:
        return upper
    a_u, f_u, w_u = curve(line, upper)
    a_l, f_l, w_l = curve(line, lower)
    if abs(upper - lower) > 1e-3 * max(upper, lower):
        return (upper * f_u - w_u - lower * f_l + w_l) / (f_u - f_l)
    return float(0.5 * (upper + lower) - (f_u - f_l) * (1.0 / a_u - 1.0 / a_l) / (24.0 * line[0, MODULUS]))


@inlined
def lead(point: Point, pull: float, g: float, start: Any, step: Any) -> float:
    """F_N - F_N(y) when slip toward g reaches the spring at a point where S = `pull`, within the step."""
    to_start, to_end = start[0] - point[2], start[0] + step[0] - point[2]
    if step[0] == 0.0:
        return float(to_start)
    gained = g * (step[0] * (pull - start[1]) + step[1] * to_start) / (g * step[1] - step[0])
    return float(min(max(gained, min(to_start, to_end)), max(to_start, to_end)))


@compiled
def swept(
    line: FloatArray,
    slope: float,
    g: float,
    upper: Point,
    s_u: float,
    lower: Point,
    s_l: float,
    start: Any,
    step: Any,
) -> float:
    """
    Slip work while the border of slip sweeps a segment under force control.

    |slope - g| int [F_N(D) - F_N(y) - 2 E* (D - y) a(y)] dy with F_N(D) linear in F_N(y); slip toward g,
    from `start` = (F_N, S) by `step`.
    """
    length = upper[0] - lower[0]
    rise = upper[2] - lower[2]
    if length <= 0.0 or rise <= 0.0 or slope == g:
        return 0.0
    e_u, e_l = lead(upper, s_u, g, start, step), lead(lower, s_l, g, start, step)
    d_u = depth_of_force(line, upper[2] + e_u)
    d_l = depth_of_force(line, lower[2] + e_l)
    middle = lower[2] + moment(line, lower, upper) / length
    n_mean = (lower[2] + e_l) + (rise + e_u - e_l) * (middle - lower[2]) / rise
    body = length * (n_mean + upper[2] - 2.0 * middle) - rise * (mean_depth(line, d_u, d_l) - lower[0])
    if max(e_u, e_l) < 0.05 * upper[2] and lower[0] > 1e-3 * upper[0]:
        closer = slid(line, upper, e_u, lower, e_l)
        if abs(closer - body) <= _ROUNDED * upper[2] * upper[0]:
            body = closer
    return float((1.0 - g * slope) * body)


@compiled
def slid(line: FloatArray, upper: Point, e_u: float, lower: Point, e_l: float) -> float:
    """
    Integral of F_N(D) - F_N(y) - 2 E* (D - y) a(y) over a piece where D is close to y, by quadrature.

    With delta = D - y it is 2 E* int_0^delta [a(y + t) - a(y)] dt: the terms of the closed form cancel to the
    second order in delta, those of this one to the first.
    """
    per_rise = (e_u - e_l) / (upper[2] - lower[2])
    twice = 2.0 * line[0, MODULUS]
    panels = 1 + int(3.0 * math.log(upper[0] / lower[0]))
    ratio = (upper[0] / lower[0]) ** (1.0 / panels)
    total = 0.0
    low = lower[0]
    for panel in range(panels):
        width = (low * ratio if panel < panels - 1 else upper[0]) - low
        for node, weight in _OUTER:
            y = low + width * node
            a, force, _ = curve(line, y)
            ahead = e_l + per_rise * (force - lower[2])
            delta = ahead / (twice * a)
            grown = 0.0
            for turn in range(3):
                grown = 0.0
                for part, share in _INNER:
                    grown += share * (curve(line, y + delta * part)[0] - a)
                if turn < 2:
                    delta -= (delta * (a + grown) - ahead / twice) / curve(line, y + delta)[0]
            total += width * weight * grown * delta
        low += width
    return float(twice * total)


@compiled
def swept_parting(
    line: FloatArray,
    stack: Any,
    i: int,
    upper: Point,
    s_u: float,
    lower: Point,
    s_l: float,
    start: Any,
    step: Any,
) -> float:
    """Slip work while the contact shrinks over a piece of segment i: the side is that of the chord."""
    slope = vertex(stack, i).slope
    ratio = step[1] / step[0]
    lag_u = start[1] + ratio * (upper[2] - start[0]) - s_u
    lag_l = start[1] + ratio * (lower[2] - start[0]) - s_l
    if lag_u * lag_l < 0.0:
        force = lower[2] + (upper[2] - lower[2]) * (lag_l / (lag_l - lag_u))
        y = min(max(depth_of_force(line, force), lower[0]), upper[0])
        a, force, work = curve(line, y)
        middle = (y, lower[1] + slope * (y - lower[0]), force, work, a)
        s_m = s_l + slope * (force - lower[2])
        g = 1.0 if lag_u > 0.0 else -1.0
        return swept(line, slope, g, upper, s_u, middle, s_m, start, step) + swept(
            line, slope, -g, middle, s_m, lower, s_l, start, step
        )
    if lag_u == 0.0 and lag_l == 0.0:
        return 0.0
    g = 1.0 if lag_u + lag_l > 0.0 else -1.0
    return swept(line, slope, g, upper, s_u, lower, s_l, start, step)


@compiled
def load(
    line: FloatArray, stack: Any, m: int, low: float, high: float, force: float, pull: float
) -> tuple[int, float, float, float]:
    """Go straight to (F_N, S), |S| <= F_N: the same stack in forces. Returns top, window and slip work."""
    start = (vertex(stack, m).force, vertex(stack, m).pull)
    upper = at(stack, m)
    end = upper
    if force != start[0]:
        y = depth_of_force(line, force)
        a, force, work = curve(line, y)
        end = (y, upper[1], force, work, a)
    pull = min(max(pull, -force), force)
    step = (force - start[0], pull - start[1])
    if step[0] == 0.0 and step[1] == 0.0:
        return m, low, high, 0.0
    depth = end[0]
    if step[0] > 0.0 and abs(step[1]) <= step[0]:
        slope = step[1] / step[0]
        end = (depth, upper[1] + slope * (depth - upper[0]), end[2], end[3], end[4])
        m, low, high = extend(line, stack, m, low, high, end, slope, True)
        return m, low, high, 0.0
    total = 0.0
    i = m
    s_u = start[1]
    g = 1.0 if step[1] > 0.0 else -1.0
    if step[0] < 0.0:
        while i > 0 and vertex(stack, i - 1).force > force:
            lower = at(stack, i - 1)
            s_l = vertex(stack, i - 1).pull
            total += swept_parting(line, stack, i, upper, s_u, lower, s_l, start, step)
            upper = lower
            s_u = s_l
            i -= 1
        b = vertex(stack, i - 1).b + vertex(stack, i).slope * (depth - vertex(stack, i - 1).y)
        lower = (depth, b, force, end[3], end[4])
        s_l = vertex(stack, i - 1).pull + vertex(stack, i).slope * (force - vertex(stack, i - 1).force)
        total += swept_parting(line, stack, i, upper, s_u, lower, s_l, start, step)
        upper = lower
        s_u = s_l
        if i < m:
            low = high = vertex(stack, i).slope
        if depth == 0.0:
            base(stack, b)
            return 0, -math.inf, math.inf, max(total, 0.0)
        if pull == s_u:
            put(line, stack, i, upper, vertex(stack, i).slope)
            return i, low, high, max(total, 0.0)
        g = 1.0 if pull > s_u else -1.0
    edge = g * pull - force
    while i > 1 and edge > g * vertex(stack, i - 1).pull - vertex(stack, i - 1).force:
        lower = at(stack, i - 1)
        s_l = vertex(stack, i - 1).pull
        total += swept(line, vertex(stack, i).slope, g, upper, s_u, lower, s_l, start, step)
        upper = lower
        s_u = s_l
        i -= 1
    lower = at(stack, i - 1)
    s_l = vertex(stack, i - 1).pull
    y = border(line, stack, i, g, edge, upper[0])
    if y - lower[0] <= MEET * depth:
        y = lower[0]
    if y > lower[0]:
        a, f, work = curve(line, y)
        s_l += vertex(stack, i).slope * (f - lower[2])
        lower = (y, lower[1] + vertex(stack, i).slope * (y - lower[0]), f, work, a)
    total += swept(line, vertex(stack, i).slope, g, upper, s_u, lower, s_l, start, step)
    if y > vertex(stack, i - 1).y:
        put(line, stack, i, lower, vertex(stack, i).slope)
        i += 1
    elif i > 1 and vertex(stack, i - 1).slope == g:
        i -= 1
    put(line, stack, i, (depth, lower[1] + g * (depth - lower[0]), force, end[3], end[4]), g)
    return i, -math.inf, math.inf, max(total, 0.0)


@compiled
def border(line: FloatArray, stack: Any, i: int, g: float, edge: float, top: float) -> float:
    """Depth on segment i, not below `top`, where g S - F_N = edge: the border of slip."""
    bend = 1.0 - g * vertex(stack, i).slope
    excess = g * vertex(stack, i - 1).pull - vertex(stack, i - 1).force - edge
    if not excess > 0.0 or bend <= 0.0:
        return float(vertex(stack, i - 1).y)
    y = depth_of_force(line, vertex(stack, i - 1).force + excess / bend)
    if not y < top:
        return top
    return float(max(y, vertex(stack, i - 1).y))


@compiled
def shift_for(line: FloatArray, stack: Any, m: int, depth: float, force: float, pull: float) -> float:
    """Shift at which the normalised tangential force is `pull` at `depth`, |pull| <= F_N(depth) = force.

    The force rises with the shift and its inverse is known between the values at which the border of slip
    stands on a vertex, so the segment is found by descending the stack.
    """
    i = m
    y, b, s = vertex(stack, m).y, vertex(stack, m).b, vertex(stack, m).pull
    if depth > y:
        rise = force - vertex(stack, m).force
        if abs(pull - s) <= rise:
            return float(b + (pull - s) / rise * (depth - y))
    elif depth < y:
        while i > 1 and vertex(stack, i - 1).y > depth:
            i -= 1
        y = depth
        b = vertex(stack, i - 1).b + vertex(stack, i).slope * (depth - vertex(stack, i - 1).y)
        s = vertex(stack, i - 1).pull + vertex(stack, i).slope * (force - vertex(stack, i - 1).force)
    if pull == s:
        return float(b)
    g = 1.0 if pull > s else -1.0
    edge = g * pull - force
    while i > 1 and edge > g * vertex(stack, i - 1).pull - vertex(stack, i - 1).force:
        i -= 1
    if i == 0:
        return float(vertex(stack, 0).b + g * depth)
    y = border(line, stack, i, g, edge, min(vertex(stack, i).y, depth))
    return float(
        vertex(stack, i - 1).b + vertex(stack, i).slope * (y - vertex(stack, i - 1).y) + g * (depth - y)
    )
