"""Steps of contacts for the compiled code of other programs, with one signature for every kind of memory. Loads numba."""

from __future__ import annotations

import math
from functools import singledispatch
from typing import Any

from pymdr.compiling import Fused
from pymdr.errors import ProblemError
from pymdr.line import following, friction, memory, plane, plastic
from pymdr.line.following import Branches, RestingBranches
from pymdr.line.following import layout as at
from pymdr.line.following import steps as branches
from pymdr.line.friction import Stacks
from pymdr.line.friction import steps as stacks
from pymdr.line.friction.layout import COMPLETE, STACK_FULL
from pymdr.line.memory import RelaxingContacts
from pymdr.line.memory import steps as relaxing
from pymdr.line.memory.row_kernels import Run
from pymdr.line.moved import CompiledStep, Moved
from pymdr.line.plane import PlaneContacts
from pymdr.line.plane import steps as springs
from pymdr.line.plastic import YieldingContacts
from pymdr.line.plastic import steps as yielding
from pymdr.problem.values import LARGEST, NOTHING
from pymdr.units import FloatArray

TAKEN, REFUSED, LEFT = range(3)
"""How a step ended: taken; refused, because a value is not finite or too deep; left to the stepper itself. All but TAKEN keep the state."""

_fused = Fused(
    __file__, following.__file__, friction.__file__, memory.__file__, plane.__file__, plastic.__file__
)
_Line = tuple[float, float, FloatArray, FloatArray]
_States = tuple[Any, FloatArray]


@_fused.inlined
def _given(depth: float) -> float:
    """The indentation of a step, 0 where the rows of a path are."""
    return 0.0 if abs(depth) < NOTHING else depth


@_fused.compiled
def along_line(
    body: _Line, states: _States, i: int, depth: float, shift: float, duration: float = 0.0
) -> tuple[int, float, float]:
    """A step of a stack."""
    deepest, moves, line, scales = body
    if not depth <= deepest:
        return REFUSED, 0.0, 0.0
    ending, normal, tangential = stacks.step(
        line, scales, states[0][i], states[1][i], _given(depth), moves * shift
    )
    if ending == COMPLETE:
        return TAKEN, normal, moves * tangential
    return (LEFT if ending == STACK_FULL else REFUSED), 0.0, 0.0


@_fused.compiled
def without_slip(
    body: _Line, states: _States, i: int, depth: float, shift: float, duration: float = 0.0
) -> tuple[int, float, float]:
    """A step of a stack without slip."""
    deepest, _, line, scales = body
    if not depth <= deepest:
        return REFUSED, 0.0, 0.0
    ending, normal, tangential = stacks.step_stuck(
        line, scales, states[0][i], states[1][i], _given(depth), shift
    )
    if ending == COMPLETE:
        return TAKEN, normal, tangential
    return (LEFT if ending == STACK_FULL else REFUSED), 0.0, 0.0


@_fused.compiled
def in_plane(
    body: tuple[_Line, FloatArray, FloatArray, bool],
    states: tuple[FloatArray, FloatArray, Any, FloatArray],
    i: int,
    depth: float,
    shift: tuple[float, float],
    duration: float = 0.0,
) -> tuple[int, float, tuple[float, float]]:
    """A step of springs in the plane."""
    line, labels, scales, slips = body
    if not (abs(shift[0]) <= LARGEST and abs(shift[1]) <= LARGEST):
        return REFUSED, 0.0, (0.0, 0.0)
    ending, normal, _ = along_line(line, (states[2], states[3]), i, depth, 0.0)
    if ending != TAKEN:
        return ending, 0.0, (0.0, 0.0)
    target = _given(depth), shift[0], shift[1]
    return TAKEN, normal, springs.step(labels, scales, states[0][i], states[1][i], target, slips)


@_fused.compiled
def on_branches(
    body: tuple[float, FloatArray],
    states: tuple[FloatArray],
    i: int,
    depth: float,
    shift: float,
    duration: float = 0.0,
) -> tuple[int, float, float]:
    """A step on the branches of a curve."""
    deepest, rows = body
    if not -LARGEST <= depth <= deepest:
        return REFUSED, 0.0, 0.0
    return TAKEN, branches.step(rows, states[0][i], _given(depth)), 0.0


@_fused.compiled
def on_resting_branches(
    body: tuple[float, FloatArray, FloatArray, FloatArray],
    states: tuple[FloatArray],
    i: int,
    depth: float,
    shift: float,
    duration: float = 0.0,
) -> tuple[int, float, float]:
    """A step on the branches of two curves, between which the edge rests."""
    deepest, advancing, receding, edge = body
    if not -LARGEST <= depth <= deepest:
        return REFUSED, 0.0, 0.0
    ending, force = branches.step_resting(
        advancing, receding, edge, states[0][i], _given(depth), at.NOWHERE, 0.0
    )
    return (TAKEN if ending == at.COMPLETE else LEFT), force, 0.0


@_fused.compiled
def on_ball(
    body: tuple[float, FloatArray],
    states: tuple[FloatArray],
    i: int,
    depth: float,
    shift: float,
    duration: float = 0.0,
) -> tuple[int, float, float]:
    """A step of a ball that yields."""
    deepest, ball = body
    if not -LARGEST <= depth <= deepest:
        return REFUSED, 0.0, 0.0
    return TAKEN, yielding.step(ball, states[0][i], _given(depth)), 0.0


@_fused.compiled
def with_memory(
    body: tuple[float, tuple[Run, Any, bool], relaxing.Workspace],
    states: tuple[FloatArray, ...],
    i: int,
    depth: float,
    shift: float,
    duration: float = math.nan,
) -> tuple[int, float, float]:
    """A step of springs with memory, which needs its duration in s."""
    deepest, line, space = body
    if not -LARGEST <= depth <= deepest:
        return REFUSED, 0.0, 0.0
    ending, force = relaxing.step(line, space, states, i, _given(depth), duration)
    if ending == relaxing.COMPLETE:
        return TAKEN, force, 0.0
    return (LEFT if ending == relaxing.UNKNOWN else REFUSED), 0.0, 0.0


@singledispatch
def compiled_of(contacts: Moved, deepest: float, capacity: int) -> CompiledStep:
    """
    The compiled step of contacts.

    Parameters
    ----------
    deepest : float
        The largest indentation in m.
    capacity : int
        Number of turning points that every stack can hold.
    """
    raise ProblemError(
        "contacts of bodies with memory and friction or adhesion, and of bodies that yield with adhesion or apparent_radius, "
        "have no compiled step; "
        "call advance, with count= for many contacts at once"
    )


@compiled_of.register
def _(contacts: Stacks, deepest: float, capacity: int) -> CompiledStep:
    contacts.grow(capacity)
    step = along_line if contacts.slips else without_slip
    return CompiledStep(step, (deepest, contacts.moves, *contacts.body), contacts.arrays)


@compiled_of.register
def _(contacts: PlaneContacts, deepest: float, capacity: int) -> CompiledStep:
    normal = compiled_of(contacts.normal, deepest, capacity)
    return CompiledStep(in_plane, (normal.body, *contacts.body, contacts.slips), contacts.arrays)


@compiled_of.register
def _(contacts: Branches, deepest: float, capacity: int) -> CompiledStep:
    return CompiledStep(on_branches, (deepest, contacts.rows), contacts.arrays)


@compiled_of.register
def _(contacts: RestingBranches, deepest: float, capacity: int) -> CompiledStep:
    return CompiledStep(on_resting_branches, (deepest, *contacts.both), contacts.arrays)


@compiled_of.register
def _(contacts: YieldingContacts, deepest: float, capacity: int) -> CompiledStep:
    if contacts.adhesive:
        compiled_of.dispatch(Moved)(contacts, deepest, capacity)
    return CompiledStep(on_ball, (deepest, contacts.body), contacts.arrays)


@compiled_of.register
def _(contacts: RelaxingContacts, deepest: float, capacity: int) -> CompiledStep:
    return CompiledStep(with_memory, (deepest, *contacts.body), contacts.arrays)
