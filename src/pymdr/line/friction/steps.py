"""Compiled single steps of the memory stack, for programs that integrate a motion. Loads numba."""

from __future__ import annotations

from typing import Any

from pymdr.line.friction import layout, noslip
from pymdr.line.friction.kernels import Anchors, advance, count, vertex
from pymdr.line.friction.reading import fused
from pymdr.line.friction.runs import BEYOND
from pymdr.line.moved import BEFORE, NOW
from pymdr.numerics.graded.layout import MAX
from pymdr.problem.values import LARGEST
from pymdr.units import FloatArray


@fused.inlined
def _first_changed(stacks: Any, least: int) -> int:
    """The first vertex that the last step may have changed: one below the lesser of both tops, if those below it are the same."""
    first = max(least - 1, 0)
    while first > 0:
        now, before = vertex(stacks[NOW], first - 1), vertex(stacks[BEFORE], first - 1)
        if now.y == before.y and now.b == before.b and now.energy == before.energy:  # sums of all below
            return first
        first -= 1
    return first


@fused.inlined
def _ending(line: FloatArray, stacks: Any, memory: FloatArray, depth: float, shift: float) -> int:
    """Whether a step can be taken; if so the present state is kept as the one before."""
    if not (abs(depth) <= LARGEST and abs(shift) <= LARGEST):
        return layout.NOT_FINITE
    if depth > line[0, MAX] * BEYOND:
        return layout.TOO_DEEP
    top = int(memory[NOW, layout.TOP])
    if top > stacks.shape[1] - 4:
        return layout.STACK_FULL
    for i in range(_first_changed(stacks, min(top, int(memory[BEFORE, layout.TOP]))), top + 1):
        stacks[BEFORE, i] = stacks[NOW, i]
    for i in range(memory.shape[1]):
        memory[BEFORE, i] = memory[NOW, i]
    return layout.COMPLETE


@fused.inlined
def _forces(stacks: Any, memory: FloatArray, scale: float) -> tuple[float, float]:
    """F_N and F_x in N."""
    if not memory[NOW, layout.DEPTH] > 0.0:
        return 0.0, 0.0
    top = vertex(stacks[NOW], int(memory[NOW, layout.TOP]))
    return top.force, scale * top.pull


@fused.compiled
def step(
    line: FloatArray, scales: FloatArray, stacks: Any, memory: FloatArray, depth: float, shift: float
) -> tuple[int, float, float]:
    """
    Go straight to an indentation and a shift in m.

    Parameters
    ----------
    line : ndarray
        The curves of the body, :attr:`~pymdr.line.friction.ElasticCurves.rows`.
    scales : ndarray, shape (3,)
        Factors from normalised forces, energies and shifts to SI units.
    stacks : ndarray, shape (2, capacity)
        Vertices now and before the last step.
    memory : ndarray, shape (2, 6)
        What a run remembers besides them.

    Returns
    -------
    tuple
        The ending, and F_N and F_x in N.
    """
    ending = _ending(line, stacks, memory, depth, shift)
    if ending == layout.COMPLETE:
        advance(Anchors(line, stacks[NOW], memory[NOW]), depth, shift / scales[layout.SHIFT_SCALE])
    normal, tangential = _forces(stacks, memory, scales[layout.FORCE_SCALE])
    return ending, normal, tangential


@fused.compiled
def step_stuck(
    line: FloatArray, scales: FloatArray, stacks: Any, memory: FloatArray, depth: float, shift: float
) -> tuple[int, float, float]:
    """As :func:`step`, without slip."""
    ending = _ending(line, stacks, memory, depth, shift)
    if ending == layout.COMPLETE:
        anchors = Anchors(line, stacks[NOW], memory[NOW])
        released = noslip.advance(anchors, depth, shift / scales[layout.SHIFT_SCALE])
        count(anchors.memory, int(anchors.memory[layout.TOP]), released, 0.0)
    normal, tangential = _forces(stacks, memory, scales[layout.FORCE_SCALE])
    return ending, normal, tangential


@fused.compiled
def step_all(
    line: FloatArray,
    scales: FloatArray,
    stacks: Any,
    memory: FloatArray,
    given: FloatArray,
    forces: FloatArray,
    some: tuple[int, int],
) -> tuple[int, int]:
    """
    Steps of the contacts of one body from one up to another.

    Parameters
    ----------
    stacks, memory : ndarray, shape (n, 2, capacity) and (n, 2, 6)
        Of every contact.
    given, forces : ndarray, shape (2, n)
        Indentation and shift in m; F_N and F_x in N, written.
    some : tuple of int
        The first of these contacts, and that after the last.

    Returns
    -------
    tuple
        The ending, and the contact at which it ended.
    """
    for i in range(some[0], some[1]):
        ending, forces[0, i], forces[1, i] = step(
            line, scales, stacks[i], memory[i], given[0, i], given[1, i]
        )
        if ending != layout.COMPLETE:
            return ending, i
    return layout.COMPLETE, some[1]


@fused.compiled
def step_all_stuck(
    line: FloatArray,
    scales: FloatArray,
    stacks: Any,
    memory: FloatArray,
    given: FloatArray,
    forces: FloatArray,
    some: tuple[int, int],
) -> tuple[int, int]:
    """As :func:`step_all`, without slip; a program needs one of both, and compiles no other."""
    for i in range(some[0], some[1]):
        ending, forces[0, i], forces[1, i] = step_stuck(
            line, scales, stacks[i], memory[i], given[0, i], given[1, i]
        )
        if ending != layout.COMPLETE:
            return ending, i
    return layout.COMPLETE, some[1]
