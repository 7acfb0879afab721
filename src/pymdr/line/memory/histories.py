"""Histories of springs with memory."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError, PathError
from pymdr.line.curves import Curve
from pymdr.line.foundation import states_at_depth, states_at_force
from pymdr.line.memory.modes import Modes, active_springs, modes_of, packed, unpacked
from pymdr.line.memory.springs import Springs, extended, next_depth, springs_to
from pymdr.line.memory.ting import compliant
from pymdr.mapping.relaxation import Relaxation
from pymdr.units import FloatArray, metres, newtons

if TYPE_CHECKING:
    from pymdr.line.memory.row_kernels import Run


@dataclass(frozen=True, eq=False)
class MemoryState:
    """What a contact remembers after a row: all that a later row needs."""

    time: float
    """In s."""
    indentation: float
    """d in m."""
    springs: Springs | None
    """The springs; None before the first contact is asked for."""
    deflection: FloatArray
    """(n,) w in m."""
    branches: FloatArray
    """(n, k) forces h of the Maxwell branches per length of the line and side, q = E_inf w + sum h, in Pa m."""
    free: FloatArray
    """(n,) 1 where a spring is free, 0 in contact."""
    work: float = 0.0
    """Work of the indentation so far in J."""
    dissipated: float = 0.0
    """Energy dissipated so far in J."""


class MemoryHistory(NamedTuple):
    """One entry per row, and the state after the last one."""

    indentation: FloatArray
    """d in m."""
    force: FloatArray
    """F in N."""
    contact_radius: FloatArray
    """a in m; 0 without contact."""
    stored: FloatArray
    """Energy of all springs of all branches in J."""
    dissipated: FloatArray
    """Energy of all dashpots so far in J."""
    work: FloatArray
    """Work of the indentation on the springs so far in J."""
    disk: np.ndarray
    """Whether the springs in contact are those of a disk."""
    state: MemoryState


class Passage(NamedTuple):
    """Rows of a history with what every spring bears; arrays over the springs have one row more, that before the first."""

    springs: Springs
    time: FloatArray
    """(m + 1,) in s."""
    indentation: FloatArray
    """(m + 1,) d in m."""
    force: FloatArray
    """(m,) F in N."""
    contact_radius: FloatArray
    """(m,) a in m."""
    notes: FloatArray
    """(3, m + 1 or more, n): loads; gaps in m above the free springs, -1 in contact; and the part of a row at which a spring last
    changed sides, 0 where it did not."""

    @property
    def load(self) -> FloatArray:
        """(m + 1, n) q per length in Pa m of the springs in contact, without a parallel dashpot."""
        return self.notes[0, : self.time.size]


Watch = Callable[[Passage], None]
"""Called with rows as they are followed; the arrays over the springs are theirs only until the next rows."""

WATCHED = 512
"""Most rows of a passage."""


def virgin(time: float = 0.0, indentation: float = 0.0) -> MemoryState:
    """The state of bodies that have not touched."""
    none = np.zeros(0)
    return MemoryState(time, indentation, None, none, np.zeros((0, 0)), none)


def prepared(
    curve: Curve, relaxation: Relaxation, depth: float, state: MemoryState, n: int = 1000
) -> MemoryState:
    """The state with n springs in the contact of a depth in m, for bodies that are to go there in several parts of a path."""
    if state.springs is not None or depth <= 0.0:
        return state
    springs = springs_to(curve, depth, n)
    size = springs.position.size
    return replace(
        state,
        springs=springs,
        deflection=np.zeros(size),
        branches=np.zeros((size, relaxation.moduli.size)),
        free=np.ones(size),
    )


def line_state(state: MemoryState, relaxation: Relaxation) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    The line after a row: x in m, w in m and q per length in Pa m, which is 0 outside the contact.

    A dashpot adds its viscosity times the speed of the indentation to q in the contact.
    """
    if state.springs is None:
        none = np.zeros(0)
        return none, none, none
    q = relaxation.equilibrium * state.deflection + state.branches.sum(axis=1)
    return state.springs.position, state.deflection, np.where(state.free != 0.0, 0.0, q)


def follow_springs(
    curve: Curve,
    relaxation: Relaxation,
    time: ArrayLike,
    depth: ArrayLike,
    state: MemoryState | None = None,
    *,
    n: int = 1000,
    watch: Watch | None = None,
) -> MemoryHistory:
    """
    Follow indentations that are straight in time between the rows.

    A spring in contact has w = d - d0 and q = int E*(t - s) dw; a free one has q = 0. It parts where its force would
    pull and is touched again where the indentation overtakes it as it creeps back. Exact in time for every spring.

    Parameters
    ----------
    curve : Curve
        Per unit modulus: ``ElasticLine(equivalent, 1.0)`` for half-spaces. Its d0 has to rise.
    relaxation : Relaxation
        E*(t).
    time, depth : array_like, shape (m,)
        t in s, not falling, and d in m. A row at the time of the one before is a sudden move.
    state : MemoryState, optional
        Where to go on. Without it the bodies just touch, or are apart, at the first time.
    n : int
        Springs in the largest contact; of the path, or of its first leg.
    watch : callable, optional
        Called with the rows and the loads of their springs, some at a time; not where nothing has touched.

    Returns
    -------
    MemoryHistory
        Forces err as 1/n^2, and so does the radius: the smooth d0 + w of the free springs is continued to the edge.

    Raises
    ------
    PathError
        If the times fall, a value is not finite, or a dashpot is moved suddenly.
    ConvergenceError
        If the curve ends before the depth.

    Notes
    -----
    Lee and Radok (1960), Ting (1966), Popov and Hess (2015), chapter 8.

    Examples
    --------
    >>> from pymdr.line.curves import ElasticLine
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> line = ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0)
    >>> maxwell = Relaxation(0.0, np.array([4.0]), np.array([0.4]))
    >>> follow_springs(line, maxwell, [0.0, 0.9], [0.0, 0.36]).force.round(5).tolist()
    [0.0, 0.54874]
    """
    d = np.asarray(depth, dtype=float)
    return _follow(curve, relaxation, (time, d, math.inf), state, n, float(np.max(d, initial=0.0)), watch)


def follow_loads(
    curve: Curve,
    relaxation: Relaxation,
    time: ArrayLike,
    force: ArrayLike,
    state: MemoryState | None = None,
    *,
    n: int = 1000,
    watch: Watch | None = None,
) -> MemoryHistory:
    """
    Follow forces; the indentation is straight in time between the rows, which errs as the square of their distance.

    Parameters are those of :func:`follow_springs`, with forces in N, not below 0. A force of 0 ends at the largest
    indentation that needs none.

    Raises
    ------
    PathError
        As :func:`follow_springs`, or if a force is below 0.
    ConvergenceError
        As :func:`follow_springs`, if no disk within the known curve bears the largest force, or if the search for an indentation does
        not converge.
    """
    load = np.asarray(force, dtype=float)
    for wrong in load[load < 0.0]:
        raise PathError(
            f"a force of {newtons(wrong)} pulls: bodies without adhesion separate at 0 N; give forces of at least 0 N"
        )
    deepest = deepest_under(curve, relaxation, time, load)
    if deepest == math.inf:
        raise ConvergenceError(
            f"no disk contact under {newtons(float(load.max()))} up to r = {metres(curve.max_radius)}, where the known profile ends: "
            "extend the profile, or reduce the force"
        )
    return _follow(curve, relaxation, (time, load, 0.0), state, n, deepest, watch)


def follow_travels(
    curve: Curve,
    relaxation: Relaxation,
    time: ArrayLike,
    travel: ArrayLike,
    machine_stiffness: float,
    state: MemoryState | None = None,
    *,
    n: int = 1000,
    watch: Watch | None = None,
) -> MemoryHistory:
    """Follow travels d + F/k of a machine of the stiffness k in N/m, above 0; otherwise as :func:`follow_loads`."""
    moved = np.asarray(travel, dtype=float)
    if machine_stiffness == math.inf:
        return follow_springs(curve, relaxation, time, moved, state, n=n, watch=watch)
    pulled = machine_stiffness * moved
    deepest = min(float(np.max(moved, initial=0.0)), deepest_under(curve, relaxation, time, pulled))
    return _follow(curve, relaxation, (time, pulled, machine_stiffness), state, n, deepest, watch)


def deepest_under(curve: Curve, relaxation: Relaxation, time: ArrayLike, force: ArrayLike) -> float:
    """
    About how deep in m forces in N go that are straight in time between the rows: 0 where none presses.

    As if the contact grew; where that is more than is known of the curve, as deep as bodies go that have no time to relax,
    or inf.
    """
    t, load = np.asarray(time, dtype=float), np.maximum(np.asarray(force, dtype=float), 0.0)
    if t.size == 0 or not (np.isfinite(load).all() and np.isfinite(t).all() and (np.diff(t) >= 0.0).all()):
        return 0.0
    if not load.any():
        return 0.0
    stiffest = relaxation.glassy
    if relaxation.viscosity > 0.0:
        if t[-1] == t[0]:
            return 0.0
        stiffest = (
            relaxation.equilibrium + float(relaxation.moduli.sum()) + relaxation.viscosity / (t[-1] - t[0])
        )
    at_once = float(load.max()) / stiffest
    for most in (float(compliant(relaxation, t, load).max()), at_once):
        states = states_at_force(curve, [most])
        depth, radius = float(states.indentation[0]), float(states.contact_radius[0])
        if math.isfinite(depth) and 0.0 < radius <= curve.max_radius:
            return depth
    return math.inf


def prepared_run(
    springs: Springs, relaxation: Relaxation, modes: Modes, state: MemoryState, machine: float, target: float
) -> tuple[Run, Any, FloatArray, FloatArray]:
    """Arguments of compiled histories: what is followed and how, where it starts before a target, and the springs of a state."""
    from pymdr.line.memory import kernels, row_kernels

    body = kernels.body_of(relaxation, modes)
    first = unpacked(state.deflection, state.branches, state.free, springs.position.size, relaxation, modes)
    table = kernels.table_of(springs)
    run, meet = row_kernels.run_of(table, body, float(machine), float(springs.limit), first)
    return run, meet, np.array([state.time, state.indentation, target, active_springs(first)]), first


def _follow(
    curve: Curve,
    relaxation: Relaxation,
    course: tuple[ArrayLike, FloatArray, float],
    state: MemoryState | None,
    n: int,
    deepest: float,
    watch: Watch | None,
) -> MemoryHistory:
    from pymdr.line.memory import kernels

    t, (_, target, machine) = np.asarray(course[0], dtype=float), course
    state = _checked(t, target, machine, state)
    if math.isinf(machine) and relaxation.viscosity > 0.0:
        _refuse_jumps(state, np.diff(t, prepend=state.time), target)
    springs = state.springs
    if springs is None:
        if deepest <= 0.0:
            return _without_contact(state, t, target, machine)
        springs = springs_to(curve, deepest, n)
    elif math.isinf(machine):
        springs = extended(curve, springs, deepest)
    modes = modes_of(relaxation)
    rows = np.zeros((t.size, kernels.COLUMNS))
    now, radii = replace(state, springs=springs), np.zeros(t.size)
    done = 0
    while True:
        now, done = _follow_rows(
            curve, relaxation, modes, (t, target, machine), now, (rows, radii, done), watch
        )
        if done == t.size:
            break
        assert now.springs is not None
        now = replace(now, springs=extended(curve, now.springs, next_depth(curve, now.springs)))
    rows[:, kernels.WORK] += state.work
    rows[:, kernels.DISSIPATED] += state.dissipated
    work, dissipated = float(rows[-1, kernels.WORK]), float(rows[-1, kernels.DISSIPATED])
    return MemoryHistory(
        rows[:, kernels.INDENTATION].copy(),
        rows[:, kernels.FORCE].copy(),
        radii,
        rows[:, kernels.STORED].copy(),
        rows[:, kernels.DISSIPATED].copy(),
        rows[:, kernels.WORK].copy(),
        rows[:, kernels.COUNT] == rows[:, kernels.LAST] + 1.0,
        replace(now, work=work, dissipated=dissipated),
    )


def _follow_rows(
    curve: Curve,
    relaxation: Relaxation,
    modes: Modes,
    course: tuple[FloatArray, FloatArray, float],
    state: MemoryState,
    results: tuple[FloatArray, FloatArray, int],
    watch: Watch | None,
) -> tuple[MemoryState, int]:
    """Follow rows until all are done or the springs end: the state there, and how many are done."""
    from pymdr.line.memory import kernels, row_kernels

    (t, target, machine), (rows, radii, done), springs = course, results, state.springs
    assert springs is not None
    run, meet, start, first = prepared_run(springs, relaxation, modes, state, machine, 0.0)
    watched = 0 if watch is None else min(WATCHED, t.size - done) + 1
    notes = np.zeros((row_kernels.NOTES, watched, springs.position.size))
    while done < t.size:
        stop = t.size if watch is None else min(done + WATCHED, t.size)
        before = start.copy()
        sections = np.stack([t[done:stop], target[done:stop], np.zeros(stop - done)])
        count = row_kernels.follow(run, sections, start, (first, first.copy()), rows[done:stop], notes, meet)
        if count == row_kernels.STUCK:
            raise ConvergenceError(
                f"no indentation that meets the target at t = {start[0]:g} s was found in {row_kernels.TRIES} steps: "
                "use more rows there, or check the magnitudes of its force, duration and moduli"
            )
        here = slice(done, done + count)
        radii[here] = contact_radii(curve, springs, rows[here])
        for column in (kernels.WORK, kernels.DISSIPATED):
            rows[here, column] += rows[done - 1, column] if done else 0.0
        if count > 0 and watch is not None:
            time, depth = np.append(before[0], t[here]), np.append(before[1], rows[here, kernels.INDENTATION])
            watch(Passage(springs, time, depth, rows[here, kernels.FORCE], radii[here], notes))
        done += count
        if done < stop:
            break
    end = MemoryState(float(start[0]), float(start[1]), springs, *packed(first, relaxation, modes))
    return end, done


def _checked(t: FloatArray, target: FloatArray, machine: float, state: MemoryState | None) -> MemoryState:
    """Where rows begin, which have to be numbers at times that do not fall."""
    if t.shape != target.shape or t.ndim != 1 or t.size == 0:
        raise PathError(
            f"times of shape {t.shape} for rows of shape {target.shape}; give one time for every row"
        )
    if not (np.isfinite(t).all() and np.isfinite(target).all()):
        raise PathError("a row of the path is not finite; give finite times and values")
    if state is None:
        first = (
            float(target[0]) if math.isinf(machine) else float(target[0]) / machine if machine > 0.0 else 0.0
        )
        state = virgin(float(t[0]), min(first, 0.0))
    waits = np.diff(t, prepend=state.time)
    if waits.min() < 0.0:
        at = int(np.argmin(waits))
        raise PathError(
            f"the time of row {at} is {-waits[at]:g} s before that of the preceding row: times must not decrease; sort the rows"
        )
    return state


def _refuse_jumps(state: MemoryState, waits: FloatArray, depth: FloatArray) -> None:
    before = np.concatenate([[state.indentation], depth[:-1]])
    sudden = (waits == 0.0) & (depth != before) & (np.maximum(depth, before) > 0.0)
    if sudden.any():
        row = int(np.argmax(sudden))
        raise PathError(
            f"row {row} moves the indentation from {metres(float(before[row]))} to {metres(float(depth[row]))} in zero time, for which "
            "this rheology needs an infinite force: give the row a duration"
        )


def _without_contact(state: MemoryState, t: FloatArray, target: FloatArray, machine: float) -> MemoryHistory:
    """Rows that press nowhere: bodies apart, at rest on each other, or too stiff for a load that has no time to act."""
    none = np.zeros(t.size)
    d = target.copy() if math.isinf(machine) else np.minimum(target / machine, 0.0) if machine > 0.0 else none
    force = none if math.isinf(machine) else np.maximum(target, 0.0)
    end = replace(state, time=float(t[-1]), indentation=float(d[-1]))
    return MemoryHistory(d, force, none, none, none, none, np.ones(t.size, dtype=bool), end)


def contact_radii(curve: Curve, springs: Springs, rows: FloatArray) -> FloatArray:
    """Radii of rows at which d0 is the depth of the edge, between the last spring in contact and the first one that is not."""
    from pymdr.line.memory.kernels import EDGE_DEPTH, LAST

    outermost = rows[:, LAST].astype(int)
    touched = outermost >= 0
    radius = np.zeros(rows.shape[0])
    if touched.any():
        inner = springs.position[outermost[touched]]
        beyond = outermost[touched] + 1
        outer = np.append(springs.position, springs.border)[beyond]
        depths = rows[touched, EDGE_DEPTH]
        radius[touched] = np.where(
            beyond < springs.position.size,
            np.clip(states_at_depth(curve, depths).contact_radius, inner, outer),
            outer,
        )
    return radius
