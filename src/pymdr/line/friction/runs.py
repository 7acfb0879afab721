"""Compiled runs of the memory stack under displacement, force and mixed control. Loads numba."""

from __future__ import annotations

import math
from typing import Any

from pymdr.line.friction.forces import load, shift_for
from pymdr.line.friction.kernels import TINY, base, move, put, vertex
from pymdr.line.friction.layout import REACH, IntArray
from pymdr.line.friction.reading import borrowed, compiled, curve, depth_of_force, inlined
from pymdr.units import FloatArray

COMPLETE, NOT_FINITE, NOT_ATTAINABLE, TOO_DEEP, STACK_FULL = range(5)
SHIFT_CONTROL, PULL_CONTROL, FORCE_CONTROL = range(3)
# registers of a run: kept from one call to the next
DEPTH, SHIFT, LOW, HIGH, SLIP_WORK, CARRY, SLIDE, TOP = range(8)
_ATTAINED = 1.0 + 1e-12  # a pull above the limit by less than this is rounding


@compiled
def restore(line: FloatArray, y: FloatArray, b: FloatArray, slope: FloatArray, stack: Any) -> None:
    """Fill a stack with the vertices of a state."""
    base(stack, b[0])
    for i in range(1, y.size):
        a, force, work = curve(line, y[i])
        put(line, stack, i, (y[i], b[i], force, work, a), slope[i - 1])


@inlined
def go(
    line: FloatArray,
    stack: Any,
    m: int,
    low: float,
    high: float,
    before: Any,
    depth: float,
    shift: float,
) -> tuple[int, float, float, float, float]:
    """One straight step from `before` = (depth, shift), with loss and return of the contact."""
    if depth > TINY:
        if before[0] < 0.0:
            base(stack, before[1] + (shift - before[1]) * (-before[0] / (depth - before[0])))
        return move(line, stack, m, low, high, depth, shift)
    work = slid = 0.0
    if before[0] > TINY:
        last = before[1] + (shift - before[1]) * (before[0] / (before[0] - depth))
        m, low, high, work, slid = move(line, stack, m, low, high, 0.0, last)
    base(stack, shift)
    return 0, -math.inf, math.inf, work, slid


@inlined
def record(stack: Any, m: int, out: FloatArray, row: int) -> None:
    """Write force, stick radius and stored energy of the stack, normalised."""
    held = m
    if m > 0 and abs(vertex(stack, m).slope) == 1.0:
        held = m - 1
    out[0, row] = vertex(stack, m).pull
    out[1, row] = vertex(stack, held).radius
    out[2, row] = max(vertex(stack, m).energy, 0.0)


@inlined
def write_row(
    stack: Any,
    m: int,
    out: FloatArray,
    row: int,
    scales: tuple[float, float, float],
    lost: float,
    slide: float,
) -> None:
    """Write what `record` does, the energy lost in slip and the distance slid, in SI."""
    to_force, to_energy, to_shift = scales
    record(stack, m, out, row)
    out[0, row] *= to_force
    out[2, row] *= to_energy
    out[3, row] = to_energy * lost
    if slide > 0.0:  # else the zero pages of the array stay untouched
        out[4, row] = to_shift * slide


@compiled
def run_displacements(
    line: FloatArray,
    stack: Any,
    register: FloatArray,
    indentation: FloatArray,
    shift: FloatArray,
    scales: tuple[float, float, float],
    rows: IntArray,
    out: FloatArray,
    span: tuple[int, int, int],
    every: bool,
) -> tuple[int, int, int]:
    """
    Follow rows span[0] <= j < span[1]; write from column span[2] on.

    `scales` turn normalised forces, energies and shifts into SI. Returns the ending, the row where it stopped
    and the next column.
    """
    line, stack, out = borrowed(line), borrowed(stack), borrowed(out)
    j, stop, column = span
    per_shift = 1.0 / scales[2]
    limit = line[0, REACH] * (1.0 + 1e-14)
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
            write_row(stack, m, out, column, scales, total, slide)
            column += 1
        j += 1
    keep_register(register, depth, v, low, high, total, carry, slide, m)
    return code, j, column


@compiled
def run_collision(
    line: FloatArray,
    stack: Any,
    indentation: FloatArray,
    time: FloatArray,
    scales: tuple[float, float, float],
    motion: tuple[float, float],
    out: FloatArray,
) -> int:
    """
    Follow the shift of a mass under its own friction while the indentation is given, by velocity Verlet.

    `motion` is the mass and the velocity at the first row. Writes force, stick radius, stored energy, slip work, shift
    and velocity of every row; returns the ending.
    """
    line, stack, out = borrowed(line), borrowed(stack), borrowed(out)
    to_force, to_energy, to_shift = scales
    mass, speed = motion
    per_shift = 1.0 / to_shift
    limit = line[0, REACH] * (1.0 + 1e-14)
    base(stack, 0.0)
    depth = v = x = total = carry = force = 0.0
    low, high = -math.inf, math.inf
    m = 0
    out[:, 0] = 0.0
    out[5, 0] = speed
    for j in range(1, indentation.size):
        d, h = indentation[j], time[j] - time[j - 1]
        if d > limit:
            return TOO_DEEP
        if m > stack.shape[0] - 4:
            return STACK_FULL
        speed -= 0.5 * h * force / mass
        x += h * speed
        v1 = x * per_shift
        m, low, high, work, _ = go(line, stack, m, low, high, (depth, v), d, v1)
        depth, v = d, v1
        term = work - carry  # Kahan's summation
        summed = total + term
        carry = (summed - total) - term
        total = summed
        record(stack, m, out, j)
        force = to_force * out[0, j]
        speed -= 0.5 * h * force / mass
        out[0, j] = force
        out[2, j] *= to_energy
        out[3, j] = to_energy * total
        out[4, j] = x
        out[5, j] = speed
    return COMPLETE


@inlined
def keep_register(
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
    stack: Any,
    register: FloatArray,
    normal: FloatArray,
    tangential: FloatArray,
    scales: tuple[float, float, float],
    rows: IntArray,
    out: FloatArray,
    span: tuple[int, int, int],
    every: bool,
    by_force: bool,
) -> tuple[int, int, int]:
    """As :func:`run_displacements` with F_x given, and F_N (`by_force`) or the indentation in `normal`."""
    line, stack, out = borrowed(line), borrowed(stack), borrowed(out)
    j, stop, column = span
    to_force, _, to_shift = scales
    limit = line[0, REACH] * (1.0 + 1e-14)
    if by_force and math.isfinite(limit):
        limit = curve(line, line[0, REACH])[1] * (1.0 + 1e-14)
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
            force = curve(line, given)[1]
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
            depth, v = vertex(stack, m).y, vertex(stack, m).b
        else:
            v1 = v
            if given > TINY:
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
            write_row(stack, m, out, column, scales, total, slide)
            out[5, column] = depth
            out[6, column] = to_shift * v
            column += 1
        j += 1
    keep_register(register, depth, v, low, high, total, carry, slide, m)
    return code, j, column


@compiled
def evaluate_all(line: FloatArray, depth: FloatArray, out: FloatArray) -> None:
    """Curves at many depths."""
    for j in range(depth.size):
        out[0, j], out[1, j], out[2, j] = curve(line, depth[j])


@compiled
def invert_all(line: FloatArray, force: FloatArray, out: FloatArray) -> None:
    """Depths of many forces."""
    for j in range(force.size):
        out[j] = depth_of_force(line, force[j])
