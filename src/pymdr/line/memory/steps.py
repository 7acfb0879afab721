"""Compiled single steps of springs with memory, for programs that integrate a motion. Loads numba."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pymdr.compiling import uncounted
from pymdr.line.memory.kernels import COLUMNS, DISSIPATED, FORCE, WORK, Body
from pymdr.line.memory.row_kernels import NOTES, TARGET, TIME, Run, follow
from pymdr.line.moved import BEFORE, NOW
from pymdr.problem.values import LARGEST
from pymdr.units import FloatArray

COMPLETE, IMPOSSIBLE, UNKNOWN = range(3)
"""How a step ended: taken; not taken, because a duration is none or a dashpot would need an infinite force; or because no springs are known there."""


class Workspace(NamedTuple):
    """Work space of contacts, so that threads may move different ones; their number is the first index."""

    tables: FloatArray
    known: FloatArray
    row: FloatArray
    springs: FloatArray
    course: FloatArray
    ends: FloatArray
    unnoted: FloatArray
    """No notes, of all contacts."""


def workspace_of(run: Run, state: FloatArray, count: int) -> Workspace:
    """Workspace for a number of contacts whose springs have the shape of `state`."""
    each = run.body.table, run.body.known, run.row, state, np.zeros((3, 1)), np.zeros((1, COLUMNS))
    several = [np.tile(one, (count, *([1] * one.ndim))) for one in each]
    return Workspace._make([*several, np.zeros((NOTES, 0, state.shape[0]))])


@uncounted
def own_run(run: Run, space: Workspace, i: int) -> Run:
    """What is followed, with the work space of contact i."""
    same = run.body
    body = Body(
        same.equilibrium,
        same.viscosity,
        same.branches,
        same.modes,
        space.tables[i],
        space.known[i],
        same.crossing,
        same.changes,
        same.form,
        same.dissolve,
    )
    return Run(run.springs, body, run.machine, run.limit, space.row[i], run.step, run.history)


@uncounted
def step(
    line: tuple[Run, Any, bool],
    space: Workspace,
    states: tuple[FloatArray, ...],
    i: int,
    depth: float,
    duration: float,
) -> tuple[int, float]:
    """
    Go with one contact straight to an indentation.

    Parameters
    ----------
    line : tuple
        The springs of all contacts, the address of what meets an indentation, and whether they resist sudden steps without limit.
    states : tuple of ndarray
        Springs, starts and rows of all contacts, now and before the last step.
    i : int
        Number of the contact.
    depth, duration : float
        Indentation in m, duration in s.

    Returns
    -------
    tuple
        The ending, and the force in N. All endings but COMPLETE keep the state.
    """
    springs, start, row = states[0][i], states[1][i], states[2][i]
    run, meet, rigid = line
    if not 0.0 <= duration <= LARGEST:
        return IMPOSSIBLE, 0.0
    here = start[NOW, 1]
    if rigid and duration == 0.0 and here != depth and max(here, depth) > 0.0:
        return IMPOSSIBLE, 0.0
    start[NOW, 0] = 0.0  # times count from here: a duration may be short against the whole
    scratch, course, ends = space.springs[i], space.course[i], space.ends[i]
    for k in range(springs.shape[1]):
        for j in range(springs.shape[2]):
            springs[BEFORE, k, j] = scratch[k, j] = springs[NOW, k, j]
    for j in range(start.shape[1]):
        start[BEFORE, j] = start[NOW, j]
    for j in range(row.shape[1]):
        row[BEFORE, j] = row[NOW, j]
    course[TIME, 0], course[TARGET, 0] = duration, depth
    done = follow(
        own_run(run, space, i), course, start[NOW], (springs[NOW], scratch), ends, space.unnoted, meet
    )
    if done != 1:
        return UNKNOWN, 0.0
    ends[0, WORK] += row[NOW, WORK]
    ends[0, DISSIPATED] += row[NOW, DISSIPATED]
    for j in range(row.shape[1]):
        row[NOW, j] = ends[0, j]
    return COMPLETE, float(row[NOW, FORCE])
