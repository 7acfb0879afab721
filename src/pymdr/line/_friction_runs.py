"""Compiled runs of the memory stack under displacement, force and mixed control. Loads numba."""

from __future__ import annotations

import math
from typing import Any

from pymdr.line._friction_curves import IntArray
from pymdr.line._friction_kernels import (
    ENERGY,
    FORCE,
    MODULUS,
    RADIUS,
    REACH,
    SLOPE,
    SUM,
    B,
    Point,
    Y,
    at,
    base,
    compiled,
    inlined,
    borrowed,
    curve,
    depth_of_force,
    extend,
    mean_force,
    move,
    put,
)
from pymdr.units import FloatArray

COMPLETE, NOT_FINITE, NOT_ATTAINABLE, TOO_DEEP, STACK_FULL = range(5)
# registers of a run: kept from one call to the next
DEPTH, SHIFT, LOW, HIGH, SLIP_WORK, CARRY, SLIDE, TOP = range(8)
_ATTAINED = 1.0 + 1e-12  # a pull above the limit by less than this is rounding


@compiled
def mean_depth(line: FloatArray, upper: float, lower: float) -> float:
    """Mean of d over the forces between F_N(lower) and F_N(upper)."""
    if upper == lower:
        return upper
    a_u, f_u, w_u = curve(line, upper)
    a_l, f_l, w_l = curve(line, lower)
    if abs(upper - lower) > 1e-3 * max(upper, lower):
        return (upper * f_u - w_u - lower * f_l + w_l) / (f_u - f_l)
    return 0.5 * (upper + lower) - (f_u - f_l) * (1.0 / a_u - 1.0 / a_l) / (24.0 * line[MODULUS])


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
    rate = g * step[1] - step[0]
    before = g * start[1] - start[0]
    n_u = n_l = start[0]
    d_u = d_l = depth_of_force(line, start[0])
    if step[0] != 0.0:
        n_u += step[0] * min(max((g * s_u - upper[2] - before) / rate, 0.0), 1.0)
        n_l += step[0] * min(max((g * s_l - lower[2] - before) / rate, 0.0), 1.0)
        d_u = depth_of_force(line, n_u)
        d_l = depth_of_force(line, n_l)
    middle = mean_force(line[MODULUS], lower, upper)
    n_mean = n_l + (n_u - n_l) * (middle - lower[2]) / rise
    body = length * (n_mean + upper[2] - 2.0 * middle) - rise * (mean_depth(line, d_u, d_l) - lower[0])
    return (1.0 - g * slope) * body


@compiled
def swept_parting(
    line: FloatArray,
    stack: FloatArray,
    i: int,
    upper: Point,
    s_u: float,
    lower: Point,
    s_l: float,
    start: Any,
    step: Any,
) -> float:
    """Slip work while the contact shrinks over a piece of segment i: the side is that of the chord."""
    slope = stack[i, SLOPE]
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
    g = 1.0 if lag_u + lag_l > 0.0 else -1.0
    return swept(line, slope, g, upper, s_u, lower, s_l, start, step)


@compiled
def load(
    line: FloatArray, stack: FloatArray, m: int, low: float, high: float, force: float, pull: float
) -> tuple[int, float, float, float]:
    """Go straight to (F_N, S), |S| <= F_N: the same stack in forces. Returns top, window and slip work."""
    start = (stack[m, FORCE], stack[m, SUM])
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
        m, low, high = extend(stack, m, low, high, end, slope, True)
        return m, low, high, 0.0
    total = 0.0
    i = m
    s_u = start[1]
    g = 1.0 if step[1] > 0.0 else -1.0
    if step[0] < 0.0:
        while i > 0 and stack[i - 1, FORCE] > force:
            lower = at(stack, i - 1)
            s_l = stack[i - 1, SUM]
            total += swept_parting(line, stack, i, upper, s_u, lower, s_l, start, step)
            upper = lower
            s_u = s_l
            i -= 1
        b = stack[i - 1, B] + stack[i, SLOPE] * (depth - stack[i - 1, Y])
        lower = (depth, b, force, end[3], end[4])
        s_l = stack[i - 1, SUM] + stack[i, SLOPE] * (force - stack[i - 1, FORCE])
        total += swept_parting(line, stack, i, upper, s_u, lower, s_l, start, step)
        upper = lower
        s_u = s_l
        if i < m:
            low = high = stack[i, SLOPE]
        if depth == 0.0:
            base(stack, b)
            return 0, -math.inf, math.inf, total
        if pull == s_u:
            put(stack, i, upper, stack[i, SLOPE])
            return i, low, high, total
        g = 1.0 if pull > s_u else -1.0
    edge = g * pull - force
    while i > 1 and edge > g * stack[i - 1, SUM] - stack[i - 1, FORCE]:
        lower = at(stack, i - 1)
        s_l = stack[i - 1, SUM]
        total += swept(line, stack[i, SLOPE], g, upper, s_u, lower, s_l, start, step)
        upper = lower
        s_u = s_l
        i -= 1
    lower = at(stack, i - 1)
    s_l = stack[i - 1, SUM]
    y = border(line, stack, i, g, edge, upper[0])
    if y > lower[0]:
        a, f, work = curve(line, y)
        s_l += stack[i, SLOPE] * (f - lower[2])
        lower = (y, lower[1] + stack[i, SLOPE] * (y - lower[0]), f, work, a)
    total += swept(line, stack[i, SLOPE], g, upper, s_u, lower, s_l, start, step)
    if y > stack[i - 1, Y]:
        put(stack, i, lower, stack[i, SLOPE])
        i += 1
    put(stack, i, (depth, lower[1] + g * (depth - lower[0]), force, end[3], end[4]), g)
    return i, -math.inf, math.inf, total


@compiled
def border(line: FloatArray, stack: FloatArray, i: int, g: float, edge: float, top: float) -> float:
    """Depth on segment i, not below `top`, where g S - F_N = edge: the border of slip."""
    bend = 1.0 - g * stack[i, SLOPE]
    excess = g * stack[i - 1, SUM] - stack[i - 1, FORCE] - edge
    if not excess > 0.0 or bend <= 0.0:
        return stack[i - 1, Y]
    y = depth_of_force(line, stack[i - 1, FORCE] + excess / bend)
    if not y < top:
        return top
    return max(y, stack[i - 1, Y])


@compiled
def shift_for(line: FloatArray, stack: FloatArray, m: int, depth: float, force: float, pull: float) -> float:
    """Shift at which the normalised tangential force is `pull` at `depth`, |pull| <= F_N(depth) = force.

    The force rises with the shift and its inverse is known between the values at which the border of slip
    stands on a vertex, so the segment is found by descending the stack.
    """
    i = m
    y, b, s = stack[m, Y], stack[m, B], stack[m, SUM]
    if depth > y:
        rise = force - stack[m, FORCE]
        if abs(pull - s) <= rise:
            return b + (pull - s) / rise * (depth - y)
    elif depth < y:
        while i > 1 and stack[i - 1, Y] > depth:
            i -= 1
        y = depth
        b = stack[i - 1, B] + stack[i, SLOPE] * (depth - stack[i - 1, Y])
        s = stack[i - 1, SUM] + stack[i, SLOPE] * (force - stack[i - 1, FORCE])
    if pull == s:
        return b
    g = 1.0 if pull > s else -1.0
    edge = g * pull - force
    while i > 1 and edge > g * stack[i - 1, SUM] - stack[i - 1, FORCE]:
        i -= 1
    if i == 0:
        return stack[0, B] + g * depth
    y = border(line, stack, i, g, edge, min(stack[i, Y], depth))
    return stack[i - 1, B] + stack[i, SLOPE] * (y - stack[i - 1, Y]) + g * (depth - y)


@compiled
def restore(line: FloatArray, y: FloatArray, b: FloatArray, slope: FloatArray, stack: FloatArray) -> None:
    """Fill a stack with the vertices of a state."""
    base(stack, b[0])
    for i in range(1, y.size):
        a, force, work = curve(line, y[i])
        put(stack, i, (y[i], b[i], force, work, a), slope[i - 1])


@inlined
def go(
    line: FloatArray,
    stack: FloatArray,
    m: int,
    low: float,
    high: float,
    before: Any,
    depth: float,
    shift: float,
) -> tuple[int, float, float, float, float]:
    """One straight step from `before` = (depth, shift), with loss and return of the contact."""
    if depth > 0.0:
        if before[0] < 0.0:
            base(stack, before[1] + (shift - before[1]) * (-before[0] / (depth - before[0])))
        return move(line, stack, m, low, high, depth, shift)
    work = slid = 0.0
    if before[0] > 0.0:
        last = before[1] + (shift - before[1]) * (before[0] / (before[0] - depth))
        m, low, high, work, slid = move(line, stack, m, low, high, 0.0, last)
    base(stack, shift)
    return 0, -math.inf, math.inf, work, slid


@inlined
def record(stack: FloatArray, m: int, out: FloatArray, row: int) -> None:
    """Write force, stick radius and stored energy of the stack, normalised."""
    held = m
    if m > 0 and abs(stack[m, SLOPE]) == 1.0:
        held = m - 1
    out[0, row] = stack[m, SUM]
    out[1, row] = stack[held, RADIUS]
    out[2, row] = stack[m, ENERGY]


@compiled
def run_displacements(
    line: FloatArray,
    stack: FloatArray,
    register: FloatArray,
    indentation: FloatArray,
    shift: FloatArray,
    scales: tuple[float, float, float],
    rows: IntArray,
    out: FloatArray,
    span: tuple[int, int, int],
) -> tuple[int, int, int]:
    """
    Follow rows span[0] <= j < span[1]; write from column span[2] on.

    `scales` turn normalised forces, energies and shifts into SI. Returns the ending, the row where it stopped
    and the next column.
    """
    line, stack, out = borrowed(line), borrowed(stack), borrowed(out)
    j, stop, column = span
    to_force, to_energy, to_shift = scales
    per_shift = 1.0 / to_shift
    limit = line[REACH] * (1.0 + 1e-14)
    every = rows.size == 0
    depth, v, low, high, total, carry, slide = register[:7]
    m = int(register[TOP])
    room = stack.shape[0] - 4
    code = COMPLETE
    while j < stop:
        d = indentation[j]
        v1 = shift[j] * per_shift
        if not (math.isfinite(d) and math.isfinite(v1)):
            code = NOT_FINITE
            break
        if d > limit:
            code = TOO_DEEP
            break
        if m > room:
            code = STACK_FULL
            break
        m, low, high, work, slid = go(line, stack, m, low, high, (depth, v), d, v1)
        depth, v = d, v1
        term = work - carry  # Kahan's summation
        summed = total + term
        carry = (summed - total) - term
        total = summed
        slide += slid
        if every or (column < rows.size and rows[column] == j):
            record(stack, m, out, column)
            out[0, column] *= to_force
            out[2, column] *= to_energy
            out[3, column] = to_energy * total
            out[4, column] = to_shift * slide
            column += 1
        j += 1
    save(register, depth, v, low, high, total, carry, slide, m)
    return code, j, column


@inlined
def save(
    register: FloatArray,
    depth: float,
    v: float,
    low: float,
    high: float,
    total: float,
    carry: float,
    slide: float,
    m: int,
) -> None:
    """Keep the state of a run for the next call."""
    register[DEPTH], register[SHIFT], register[LOW], register[HIGH] = depth, v, low, high
    register[SLIP_WORK], register[CARRY], register[SLIDE], register[TOP] = total, carry, slide, m


@compiled
def run_forces(
    line: FloatArray,
    stack: FloatArray,
    register: FloatArray,
    normal: FloatArray,
    tangential: FloatArray,
    scales: tuple[float, float, float],
    rows: IntArray,
    out: FloatArray,
    span: tuple[int, int, int],
    by_force: bool,
) -> tuple[int, int, int]:
    """As :func:`run_displacements` with F_x given, and F_N (`by_force`) or the indentation in `normal`."""
    line, stack, out = borrowed(line), borrowed(stack), borrowed(out)
    j, stop, column = span
    to_force, to_energy, to_shift = scales
    per_shift = 1.0 / to_shift
    limit = line[REACH] * (1.0 + 1e-14)
    if by_force and math.isfinite(limit):
        limit = curve(line, line[REACH])[1] * (1.0 + 1e-14)
    every = rows.size == 0
    depth, v, low, high, total, carry, slide = register[:7]
    m = int(register[TOP])
    code = COMPLETE
    while j < stop:
        given = normal[j]
        pull = tangential[j] / to_force
        if not (math.isfinite(given) and math.isfinite(pull)):
            code = NOT_FINITE
            break
        if given > limit:
            code = TOO_DEEP
            break
        force = given
        if not by_force:
            a, force, work = curve(line, given)
        if force < 0.0 or abs(pull) > force * _ATTAINED:
            code = NOT_ATTAINABLE
            break
        if m + 4 > stack.shape[0]:
            code = STACK_FULL
            break
        pull = min(max(pull, -force), force)
        slid = 0.0
        if by_force:
            if depth < 0.0:
                base(stack, v)
            m, low, high, work = load(line, stack, m, low, high, force, pull)
            depth, v = stack[m, Y], stack[m, B]
        else:
            v1 = v
            if given > 0.0:
                v1 = shift_for(line, stack, m, given, force, pull)
                if depth < 0.0:
                    v1 = v + pull / force * (given - depth)
            m, low, high, work, slid = go(line, stack, m, low, high, (depth, v), given, v1)
            depth, v = given, v1
        term = work - carry  # Kahan's summation
        summed = total + term
        carry = (summed - total) - term
        total = summed
        slide += slid
        if every or (column < rows.size and rows[column] == j):
            record(stack, m, out, column)
            out[0, column] *= to_force
            out[2, column] *= to_energy
            out[3, column] = to_energy * total
            out[4, column] = to_shift * slide
            out[5, column] = depth
            out[6, column] = to_shift * v
            column += 1
        j += 1
    save(register, depth, v, low, high, total, carry, slide, m)
    return code, j, column
