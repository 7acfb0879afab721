"""Compiled runs of the memory stack under displacement, force and mixed control. Loads numba."""

from __future__ import annotations

import math
from typing import NamedTuple

from pymdr.line.friction import layout
from pymdr.line.friction.forces import load, shift_for
from pymdr.line.friction.kernels import (
    TINY,
    Anchors,
    Point,
    advance,
    at,
    clear,
    count,
    keep_slope,
    moment,
    on_segment,
    put,
    vertex,
)
from pymdr.line.friction.reading import curve, depth_of_force, fused
from pymdr.numerics.graded.layout import MAX, IntArray
from pymdr.units import FloatArray

_ATTAINED = 1.0 + 1e-12  # a pull above the limit by less than this is rounding
BEYOND = 1.0 + 1e-14  # of the largest depth


class Scales(NamedTuple):
    """Factors from normalised forces, energies and shifts to SI units."""

    force: float
    energy: float
    shift: float


class Run(NamedTuple):
    """A run in progress; `kept` are the rows that `out` has columns for, unless it has one for every row."""

    anchors: Anchors
    out: FloatArray
    kept: IntArray
    every: bool
    scales: Scales


@fused.compiled
def restore(anchors: Anchors, y: FloatArray, b: FloatArray, slope: FloatArray) -> None:
    """Fill a stack with the vertices of a state."""
    clear(anchors.stack, b[0])
    for i in range(1, y.size):
        a, force, work = curve(anchors.line, y[i])
        put(anchors, i, Point(y[i], b[i], force, work, a), slope[i - 1])
        keep_slope(anchors.stack, i)


@fused.inlined
def write(run: Run, row: int, column: int) -> int:
    """Write force, stick radius, stored energy, slip work and distance slid of a row to be kept; the next column."""
    if not run.every and (column >= run.kept.size or run.kept[column] != row):
        return column
    m = int(run.anchors.memory[layout.TOP])
    top = vertex(run.anchors.stack, m)
    stuck = m - 1 if m > 0 and abs(top.slope) == 1.0 else m
    run.out[0, column] = run.scales.force * top.pull
    run.out[1, column] = vertex(run.anchors.stack, stuck).radius
    run.out[2, column] = run.scales.energy * max(top.energy, 0.0)
    run.out[3, column] = run.scales.energy * run.anchors.memory[layout.SLIP_WORK]
    if run.anchors.memory[layout.SLIDE] > 0.0:  # else the zero pages of the array stay untouched
        run.out[4, column] = run.scales.shift * run.anchors.memory[layout.SLIDE]
    if run.out.shape[0] > 6:
        run.out[5, column] = run.anchors.memory[layout.DEPTH]
        run.out[6, column] = run.scales.shift * run.anchors.memory[layout.SHIFT]
    return column + 1


@fused.compiled
def run_displacements(
    run: Run, indentation: FloatArray, shift: FloatArray, span: tuple[int, int, int]
) -> tuple[int, int, int]:
    """
    Follow rows span[0] <= j < span[1]; write from column span[2] on.

    Returns the ending, the row where it stopped and the next column.
    """
    j, stop, column = span
    anchors = run.anchors
    per_shift = 1.0 / run.scales.shift
    limit = anchors.line[0, MAX] * BEYOND
    while j < stop:
        d = indentation[j]
        v = shift[j] * per_shift
        if not (math.isfinite(d) and math.isfinite(v)):
            return layout.NOT_FINITE, j, column
        if d > limit:
            return layout.TOO_DEEP, j, column
        if anchors.memory[layout.TOP] > anchors.stack.size - 4:
            return layout.STACK_FULL, j, column
        advance(anchors, d, v)
        column = write(run, j, column)
        j += 1
    return layout.COMPLETE, j, column


@fused.compiled
def run_opposed(
    run: Run, indentation: FloatArray, shift: FloatArray, span: tuple[int, int, int]
) -> tuple[int, int, int]:
    """
    As :func:`run_displacements`, every row; writes the magnitudes of all parts of force and stored energy over those of their sums.

    A segment of slope s has the force s dF and the energy int s t dF, with t = t_above + s (y_above - y).
    """
    j, stop, _ = span
    anchors = run.anchors
    while j < stop:
        ending, j, _ = run_displacements(run, indentation, shift, (j, j + 1, j))
        if ending != layout.COMPLETE:
            return ending, j, j
        top = vertex(anchors.stack, int(anchors.memory[layout.TOP]))
        force = energy = 0.0
        for i in range(1, int(anchors.memory[layout.TOP]) + 1):
            slope = vertex(anchors.stack, i).slope
            lower, upper = at(anchors.stack, i - 1), at(anchors.stack, i)
            below, above = top.b - lower.b, top.b - upper.b
            force += abs(slope * (upper.force - lower.force))
            if below * above < 0.0:
                middle = on_segment(anchors, i, min(max(lower.y + below / slope, lower.y), upper.y))
                energy += slope * slope * moment(anchors.line, lower, middle)
                lower = middle
            turn = moment(anchors.line, lower, upper)
            energy += abs(slope * (above * (upper.force - lower.force) + slope * turn))
        run.out[0, j - 1] = force / abs(top.pull) if force > 0.0 else 1.0
        run.out[1, j - 1] = energy / max(top.energy, 0.0) if energy > 0.0 else 1.0
    return layout.COMPLETE, j, j


@fused.compiled
def run_collision(
    run: Run, indentation: FloatArray, time: FloatArray, mass: float, velocity: FloatArray
) -> int:
    """
    Follow the shift of a mass under its own friction while the indentation is given, by velocity Verlet.

    The first velocity is given, the others are written, and the shift in place of the distance slid. Returns the ending.
    """
    x = 0.0
    for j in range(1, indentation.size):
        if indentation[j] > run.anchors.line[0, MAX] * BEYOND:
            return layout.TOO_DEEP
        half = 0.5 * (time[j] - time[j - 1]) / mass
        v = velocity[j - 1] - half * run.out[0, j - 1]
        x += (time[j] - time[j - 1]) * v
        advance(run.anchors, indentation[j], x / run.scales.shift)
        write(run, j, j)
        run.out[4, j] = x
        velocity[j] = v - half * run.out[0, j]
    return layout.COMPLETE


@fused.compiled
def run_forces(
    run: Run, normal: FloatArray, tangential: FloatArray, span: tuple[int, int, int], by_force: bool
) -> tuple[int, int, int]:
    """As :func:`run_displacements` with F_x given, and F_N (`by_force`) or the indentation in `normal`."""
    j, stop, column = span
    anchors = run.anchors
    limit = anchors.line[0, MAX] * BEYOND
    if by_force and math.isfinite(limit):
        limit = curve(anchors.line, anchors.line[0, MAX])[1] * BEYOND
    while j < stop:
        given = normal[j]
        pull = tangential[j] / run.scales.force
        if not (math.isfinite(given) and math.isfinite(pull)):
            return layout.NOT_FINITE, j, column
        if given > limit:
            return layout.TOO_DEEP, j, column
        force = given if by_force else curve(anchors.line, given)[1]
        if force < 0.0 or abs(pull) > force * _ATTAINED:
            return layout.NOT_ATTAINABLE, j, column
        if anchors.memory[layout.TOP] + 4 > anchors.stack.size:
            return layout.STACK_FULL, j, column
        pull = min(max(pull, -force), force)
        if by_force:
            if anchors.memory[layout.DEPTH] < 0.0:
                clear(anchors.stack, anchors.memory[layout.SHIFT])
            m, work = load(anchors, int(anchors.memory[layout.TOP]), force, pull)
            count(anchors.memory, m, work, 0.0)
            top = vertex(anchors.stack, m)
            anchors.memory[layout.DEPTH], anchors.memory[layout.SHIFT] = top.y, top.b
        else:
            v = anchors.memory[layout.SHIFT]
            if given > TINY and anchors.memory[layout.DEPTH] < 0.0:
                v += pull / force * (given - anchors.memory[layout.DEPTH])
            elif given > TINY:
                v = shift_for(anchors, int(anchors.memory[layout.TOP]), given, force, pull)
            advance(anchors, given, v)
        column = write(run, j, column)
        j += 1
    return layout.COMPLETE, j, column


@fused.compiled
def invert_all(line: FloatArray, force: FloatArray, out: FloatArray) -> None:
    """Depths of many forces."""
    for j in range(force.size):
        out[j] = depth_of_force(line, force[j])
