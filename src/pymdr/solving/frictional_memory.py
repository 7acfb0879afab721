"""The contact of bodies with memory and friction along a path."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pymdr.errors import PathError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.friction import similarity_assumption
from pymdr.interpretation.memory_friction import (
    SHEARED_QUANTITIES,
    ShearedSurface,
    sheared_claims,
    sheared_errors,
    uncoupled,
)
from pymdr.interpretation.validity import TANGENTIAL_FIELDS, Claim, Level
from pymdr.line.curves import ElasticLine
from pymdr.line.memory import (
    MemoryHistory,
    MemoryState,
    Parts,
    Passage,
    TangentialHistory,
    TangentialState,
    compliant,
    relaxed,
    shear_springs,
    unsheared,
)
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.relaxation import Relaxation, largest_coupling
from pymdr.problem.paths import TORSIONAL_CHANNELS
from pymdr.problem.schedule import Stretch
from pymdr.result import Result
from pymdr.rows import joined, taken
from pymdr.solving import memory
from pymdr.solving.normal import refuse_tangential
from pymdr.solving.viscoelastic import (
    LEVELS,
    SPRINGS,
    MemoryRows,
    followed_leg,
    interpreted,
    kernel_errors,
    parts_between,
    refuse_untimed,
    rows_met,
    status_of,
    surface_with_memory,
    untouched_states,
)
from pymdr.solving.walk import Channels, Interpretation, LegProgress, Task, Walked, solution, walk
from pymdr.units import FloatArray, newtons

_SLACK = (0.0, 1e-3, 4e-3)
"""Accepted relative deficit of the friction that the springs of each level carry."""


@dataclass(frozen=True)
class _Sheared:
    """Tangential rows; energies are cumulative."""

    shift: FloatArray
    tangential_force: FloatArray
    stick_radius: FloatArray
    stored: FloatArray
    dissipated: FloatArray
    slip_work: FloatArray
    work: FloatArray
    slip_distance: FloatArray
    disk: np.ndarray


_SUMMED = {"dissipated": "dissipated", "slip_work": "slip_work", "work": "work", "slip_distance": "slid"}


@dataclass(frozen=True)
class _Rows:
    normal: MemoryRows
    fine: _Sheared
    coarse: _Sheared
    """Results with half as many springs and steps."""
    coarsest: _Sheared
    """Results with a quarter of the springs."""
    forced: np.ndarray
    """Whether the tangential force is prescribed."""


@dataclass(frozen=True)
class _State:
    normal: MemoryState
    tangential: TangentialState
    sums: tuple[float, ...]
    """Cumulative values of the quantities `_SUMMED`."""


@dataclass(frozen=True)
class _Bodies:
    line: ElasticLine
    normal: Relaxation
    tangential: Relaxation
    friction: float


def solve_frictional_memory(task: Task) -> Result:
    """Map, walk and interpret."""
    refuse_tangential(
        task.path, "torsion of bodies with memory is not available; use Elastic bodies", TORSIONAL_CHANNELS
    )
    bodies = _bodies(task, None)
    walked = walk(task, None, partial(_step, task, bodies))
    if memory.depends_on_rows(task.contact, task.path):
        bodies = _bodies(task, walked.time)
        walked = walk(task, None, partial(_step, task, bodies))
    return solution(task, walked, _interpret(task, bodies, walked))


def _bodies(task: Task, time: FloatArray | None) -> _Bodies:
    contact = task.contact
    assert contact.friction is not None
    return _Bodies(
        ElasticLine(equivalent_profile(contact.profile), 1.0),
        memory.relaxation_along(contact, task.path, time),
        memory.tangential_relaxation_along(contact, task.path, time),
        contact.friction.coefficient,
    )


def _step(
    task: Task,
    bodies: _Bodies,
    state: tuple[_State, ...] | None,
    stretch: Stretch,
    kept: np.ndarray | None,
    progress: LegProgress | None,
) -> tuple[_Rows, tuple[_State, ...], Channels]:
    """Step 2: springs with memory and their tangential partners on three levels."""
    refuse_untimed(stretch, bodies.normal)
    if state is None:
        none = (0.0,) * len(_SUMMED)
        virgin = untouched_states(task, bodies.line, bodies.normal, stretch)
        state = tuple(_State(normal, unsheared(), none) for normal in virgin)
    # on the springs of the finest level, as a stepper does
    parts = parts_between(task, bodies.line, bodies.normal, stretch, state[0].normal, loads=True, n=SPRINGS)
    pressed, (sheared, half, quarter), ends = zip(
        *(
            _followed(task, bodies, stretch, one, parts.halved(2 * many), n, slack)
            for one, (many, n), slack in zip(state, LEVELS, _SLACK, strict=True)
        ),
        strict=True,
    )
    rows, here = rows_met(task, bodies.line, bodies.normal, stretch, pressed)
    forced = np.full(rows.indentation.size, stretch.controls.tangential == "tangential_force")
    here = {
        **here,
        "shift": float(sheared.shift[-1]),
        "tangential_force": float(sheared.tangential_force[-1]),
    }
    return taken(_Rows(rows, sheared, half, quarter, forced), kept), ends, here


def _followed(
    task: Task, bodies: _Bodies, stretch: Stretch, state: _State, parts: Parts, n: int, slack: float
) -> tuple[MemoryHistory, _Sheared, _State]:
    """A leg on n springs, in parts of its rows."""
    forced = stretch.controls.tangential == "tangential_force"
    target = parts.along(stretch.tangential, stretch.start[1])
    histories: list[TangentialHistory] = []
    now, done = state.tangential, 0

    def watch(passage: Passage) -> None:
        nonlocal now, done
        rows = target[done : done + passage.force.size]
        part = shear_springs(
            bodies.line,
            passage,
            (bodies.normal, bodies.tangential),
            bodies.friction,
            rows,
            forced,
            now,
            slack=slack,
        )
        if part.shift.size < rows.size:
            stopped = part.shift.size
            row = int(parts.row[done + stopped])
            _refuse_beyond(stretch, bodies.friction, row, float(passage.force[stopped]))
        histories.append(part)
        now, done = part.state, done + rows.size

    normal = followed_leg(task, bodies.line, bodies.normal, stretch, state.normal, parts, n, watch)
    sheared = (
        joined([_taken(part) for part in histories])
        if histories
        else _separated(stretch, target, now, forced, parts)
    )
    if not histories:
        now = replace(now, shift=float(sheared.shift[-1]))
    before = dict(zip(_SUMMED, state.sums, strict=True))
    summed = {name: before[name] + np.cumsum(getattr(sheared, name)) for name in _SUMMED}
    sheared = replace(sheared, **summed)
    end = _State(normal.state, now, tuple(float(values[-1]) for values in summed.values()))
    return normal, taken(sheared, parts.own), end


def _taken(part: TangentialHistory) -> _Sheared:
    """Rows of the tangential springs by the names of their quantities."""
    names = {"tangential_force": "force", **_SUMMED}
    return _Sheared(**{name: getattr(part, names.get(name, name)) for name in _Sheared.__annotations__})


def _separated(
    stretch: Stretch, target: FloatArray, state: TangentialState, forced: bool, parts: Parts
) -> _Sheared:
    """Rows of bodies that have not touched."""
    if forced and target.any():
        _refuse_beyond(stretch, 0.0, int(parts.row[np.argmax(target != 0.0)]), 0.0)
    none = np.zeros(target.size)
    shift = np.full(target.size, state.shift) if forced else target
    return _Sheared(shift, *(none,) * 7, np.ones(target.size, dtype=bool))


def _refuse_beyond(stretch: Stretch, friction: float, row: int, pressed: float) -> None:
    most = friction * pressed if pressed > 0.0 else 0.0
    raise PathError(
        f"tangential_force = {newtons(float(stretch.tangential[row]))} in {stretch.leg.row(row)}: friction carries "
        f"at most mu F_N = {newtons(most)} before it is reached, and then the whole contact slides; reduce it, or move the body "
        "with shift(...)"
    )


def _interpret(task: Task, bodies: _Bodies, walked: Walked[_Rows]) -> Interpretation:
    """Step 3: quantities, claims and assumptions of every row."""
    rows, contact = walked.rows, task.contact
    assert contact.friction is not None
    pressed = Walked(rows.normal, walked.starts, walked.time)
    normal = interpreted(task, bodies.line, bodies.normal, pressed)
    sheared = rows.fine
    columns = {
        **normal.columns,
        "shift": sheared.shift,
        "tangential_force": _scaled_forces(rows, bodies.friction, normal.columns["normal_force"]),
        "stick_radius": np.minimum(sheared.stick_radius, normal.columns["contact_radius"]),
        "slip_distance": sheared.slip_distance,
        "stored_tangential_energy": sheared.stored,
        "slip_work": sheared.slip_work,
        "dissipated_energy": rows.normal.dissipated + sheared.dissipated + sheared.slip_work,
        "external_work": rows.normal.work + sheared.work,
    }
    coupling = largest_coupling(
        contact.body, contact.counterbody, memory.span_along(contact, task.path, walked.time)
    )
    claims = uncoupled(normal.claims, contact, coupling)
    own = [name for name in columns if name in SHEARED_QUANTITIES]
    where = claims["contact_radius"].where
    tangential = sheared_claims(contact, coupling, (*own, *TANGENTIAL_FIELDS), where, sheared.disk)
    fields = sheared_errors(_surface(task, bodies, walked, normal.columns), where.size)
    errors, kernel = _errors(rows), _kernel_errors(bodies, walked, columns, contact.friction.coefficient)
    tangential = with_errors(
        tangential,
        {name: error + kernel[name] for name, error in errors.items()}
        | {name: error + bodies.tangential.error for name, error in fields.items()},
        f"; energies are those of the springs and dashpots that the rheology names{memory.OWN_ERRORS}",
        f"as {SPRINGS} springs in four steps or more between the rows do",
    )
    if "shift" in tangential:
        tangential["shift"] = _shift_claim(tangential["shift"], rows.forced)
    claims = {**claims, **tangential}
    similar = similarity_assumption(coupling, bodies.friction)
    return Interpretation(
        columns=columns,
        claims=claims,
        assumptions=(*normal.assumptions, similar),
        status=status_of(claims),
        notes=normal.notes,
        is_viscoelastic=True,
        references=("sneddon", "popov-hess", "ting", "cattaneo-mindlin"),
        starts=walked.starts,
    )


def _surface(
    task: Task, bodies: _Bodies, walked: Walked[_Rows], columns: Mapping[str, FloatArray]
) -> ShearedSurface:
    assert walked.time is not None
    depth, radius = columns["indentation"], columns["contact_radius"]
    normal = surface_with_memory(task.contact, bodies.normal, walked.time, depth, radius)
    return ShearedSurface(normal, bodies.tangential, bodies.friction, walked.rows.fine.shift)


def _scaled_forces(rows: _Rows, friction: float, force: FloatArray) -> FloatArray:
    """Tangential forces for a normal force that may be computed without springs; in full slip they are mu F_N to rounding."""
    springs, tangential = rows.normal.normal_force, rows.fine.tangential_force
    if math.isinf(friction):
        return tangential
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((springs > 0.0) & ~rows.forced, tangential * (force / springs), tangential)


def _shift_claim(claim: Claim, forced: np.ndarray) -> Claim:
    """The claim of shifts; prescribed ones are known for any contact."""
    if forced.all():
        return claim
    if not forced.any():
        return replace(claim, level=Level.EXACT, reason="prescribed", where=~forced, error=None)
    reason = f"prescribed in {int((~forced).sum())} of {forced.size} rows; else {claim.reason}"
    return replace(claim, reason=reason, where=claim.where | ~forced)


def _errors(rows: _Rows) -> dict[str, FloatArray]:
    """Relative errors of rows, from fewer springs and steps."""
    normal = rows.normal
    levels = zip(
        (rows.fine, rows.coarse, rows.coarsest),
        (normal.dissipated, *normal.of_fewer("dissipated")),
        (normal.work, *normal.of_fewer("work")),
        strict=True,
    )
    fine, coarse, coarsest = (_compared(*level) for level in levels)
    return {name: memory.error_of_levels(fine[name], coarse[name], coarsest[name]) for name in fine}


def _compared(sheared: _Sheared, dissipated: FloatArray, work: FloatArray) -> dict[str, FloatArray]:
    """Quantities by which levels are compared, including the energies of the normal springs."""
    return {
        "shift": sheared.shift,
        "tangential_force": sheared.tangential_force,
        "stick_radius": sheared.stick_radius,
        "slip_distance": sheared.slip_distance,
        "stored_tangential_energy": sheared.stored,
        "slip_work": sheared.slip_work,
        "dissipated_energy": dissipated + sheared.dissipated + sheared.slip_work,
        "external_work": work + sheared.work,
    }


def _kernel_errors(
    bodies: _Bodies, walked: Walked[_Rows], columns: Mapping[str, FloatArray], friction: float
) -> dict[str, FloatArray]:
    """
    Relative errors of rows by the error of the kernel, as `kernel_errors` gives them for normal quantities.

    Springs slip where their moves would load them beyond mu times their pressure: in a row they are loaded by 2 mu F_N at most,
    however stiff a sudden move would find them.
    """
    assert walked.time is not None
    pressed = kernel_errors(bodies.line, bodies.normal, walked.rows.normal, walked.time)
    shift, force = columns["shift"], columns["tangential_force"]
    moves = np.abs(np.diff(shift, prepend=0.0))
    stiffness = bodies.line.stiffness(columns["contact_radius"])
    bears = memory.travelled(bodies.tangential, relaxed, walked.time, np.cumsum(stiffness * moves))
    if math.isfinite(friction):
        pressed_by = np.maximum(columns["normal_force"], 0.0)
        most = np.cumsum(np.maximum(pressed_by, np.append(0.0, pressed_by[:-1])))
        bears = np.minimum(bears, 2.0 * friction * bodies.tangential.error * most)
    load = np.divide(force, stiffness, out=np.zeros(force.size), where=stiffness > 0.0)
    creeps = memory.travelled(bodies.tangential, compliant, walked.time, load)
    work = 2.0 * np.cumsum(bears * moves)
    names = ("stored_tangential_energy", "slip_work", "dissipated_energy", "external_work")
    return {name: memory.relative_errors(work, columns[name]) + pressed.get(name, 0.0) for name in names} | {
        "shift": memory.relative_errors(creeps, shift),
        "tangential_force": memory.relative_errors(bears, force),
        "stick_radius": memory.relative_errors(bears, force),
        "slip_distance": memory.relative_errors(
            bodies.tangential.error * np.cumsum(moves), columns["slip_distance"]
        ),
    }
