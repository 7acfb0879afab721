"""Parts of rows whose indentation is not prescribed, as short as it bends."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pymdr.line.curves import Curve
from pymdr.line.foundation import normal_force, states_at_depth
from pymdr.line.memory.histories import MemoryState, deepest_under, prepared_run
from pymdr.line.memory.modes import modes_of
from pymdr.line.memory.springs import extended, next_depth, springs_to
from pymdr.mapping.relaxation import Relaxation
from pymdr.units import FloatArray

if TYPE_CHECKING:
    from pymdr.line.memory.row_kernels import Division, Run

_PARTS = 1024
"""Largest number of parts at first."""


class Parts(NamedTuple):
    """Parts of rows, in order."""

    row: np.ndarray
    """(k,) the row of each."""
    fraction: FloatArray
    """(k,) its end as a fraction of the row, which is 1 for the last part of a row."""

    @property
    def own(self) -> np.ndarray:
        """Where the rows themselves are among the ends of their parts."""
        return np.flatnonzero(self.fraction == 1.0)

    def halved(self, parts: int) -> Parts:
        """Each of them in that many parts alike."""
        begin = np.append(0.0, np.where(self.fraction == 1.0, 0.0, self.fraction)[:-1])
        left = np.arange(parts - 1.0, -1.0, -1.0) / parts
        fraction = self.fraction[:, None] - (self.fraction - begin)[:, None] * left
        return Parts(np.repeat(self.row, parts), fraction.ravel())

    def along(self, values: FloatArray, start: float) -> FloatArray:
        """Values at the ends of the parts, straight between those of the rows and from a start."""
        moves = np.diff(values, prepend=start)
        return np.asarray(values[self.row] - moves[self.row] * (1.0 - self.fraction))


def whole_rows(count: int) -> Parts:
    """Rows that are not divided."""
    return Parts(np.arange(count), np.ones(count))


class Goal(NamedTuple):
    """What rows ask for."""

    time: FloatArray
    """(m,) t in s."""
    target: FloatArray
    """(m,) F in N, or for a machine d + F/k in m."""
    start: float
    """The target before the first row."""
    machine_stiffness: float
    """In N/m; 0 under forces, inf where the target is the indentation, which is straight."""


def parts_of(
    curve: Curve,
    relaxation: Relaxation,
    goal: Goal,
    state: MemoryState,
    *,
    tolerance: float,
    loads: bool = False,
    n: int = 1000,
) -> Parts:
    """
    Parts of rows on which the indentation is all but straight in time, and the loads of the springs if that is asked for.

    A part is halved where the indentation that meets its force half-way is not half-way: where a load comes or goes, and where
    relaxation is fast.

    Parameters
    ----------
    curve : Curve
        Per unit modulus.
    relaxation : Relaxation
        E*(t).
    goal : Goal
    state : MemoryState
        Where to go on.
    tolerance : float
        By how much an indentation or a load may be off half-way, of the largest, and its work, of that of the history.
    loads : bool
        Whether the loads of all springs are to be all but straight too.
    n : int
        Springs in the largest contact, if none are laid yet.

    Returns
    -------
    Parts
        Whole rows where nothing is asked for or touches, or the history itself cannot be followed.
    """
    from pymdr.line.memory import row_kernels

    t, values, start, machine_stiffness = goal
    if (np.diff(t, prepend=state.time) < 0.0).any():  # as the history itself says
        return whole_rows(t.size)
    by_depth, by_force = math.isinf(machine_stiffness), machine_stiffness == 0.0
    pulled, first_target = (values, start)
    if not by_depth and not by_force:
        pulled, first_target = machine_stiffness * values, machine_stiffness * start
    deepest = math.inf if by_force else float(np.max(values, initial=0.0))
    if not by_depth:
        under = deepest_under(curve, relaxation, np.append(state.time, t), np.append(first_target, pulled))
        deepest = min(deepest, under)
    springs = state.springs
    if (by_depth and not loads) or not math.isfinite(deepest) or (springs is None and deepest <= 0.0):
        return whole_rows(t.size)
    if springs is None:
        springs = springs_to(curve, deepest, n)
    # that of the path, for which the springs were laid
    size = max(deepest, state.indentation, float(springs.height[-1]))
    if size <= 0.0:
        return whole_rows(t.size)
    springs = extended(curve, springs, deepest)
    strength = mean_moduli(relaxation, np.diff(t, prepend=state.time)) * elastic_force(curve, size)
    course = np.stack([t, pulled, strength])
    division = row_kernels.Division(tolerance * size, tolerance if loads else math.inf)
    modes = modes_of(relaxation)
    while True:
        run, meet, begin, first = prepared_run(
            springs, relaxation, modes, state, goal.machine_stiffness, first_target
        )
        parts = divided_rows(run, meet, (begin, first), course, division)
        if isinstance(parts, Parts):
            return parts
        if parts == row_kernels.STUCK:
            return whole_rows(t.size)
        springs = extended(curve, springs, next_depth(curve, springs))


def divided_rows(
    run: Run,
    meet: Any,
    start: tuple[FloatArray, FloatArray],
    course: FloatArray,
    division: Division,
) -> Parts | int:
    """The parts of rows of :func:`pymdr.line.memory.row_kernels.divide`, or why they were not divided; the state stays."""
    from pymdr.line.memory import kernels, row_kernels

    (begin, first), most = start, _PARTS + 2 * course.shape[1]
    while True:
        rows = np.zeros((most, kernels.COLUMNS))
        states = first.copy(), first.copy(), first.copy()
        count = row_kernels.divide(run, course, begin.copy(), states, rows, meet, division)
        run.body.known[kernels.GROUPED] = 0.0  # the group of the copies
        if count >= 0:
            return Parts(rows[:count, kernels.OWNER].astype(np.int64), rows[:count, kernels.PART].copy())
        if count != row_kernels.FULL:
            return int(count)
        most *= 4


def mean_moduli(relaxation: Relaxation, time: FloatArray) -> FloatArray:
    """The mean of E*(t) in Pa up to some times in s; 0 up to 0, where nothing is divided."""
    flow = -np.expm1(-time[:, None] / relaxation.times) * relaxation.times @ relaxation.moduli
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(time > 0.0, relaxation.equilibrium + (flow + relaxation.viscosity) / time, 0.0)


def elastic_force(curve: Curve, depth: float) -> float:
    """The elastic force in N per unit modulus at a depth in m."""
    return float(normal_force(curve, states_at_depth(curve, [depth]))[0])
