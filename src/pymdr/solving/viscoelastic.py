"""The contact of bodies with memory along a path."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from pymdr.errors import PathError, ProblemError, PymdrError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.layered_memory import LayeredMemorySurface, layered_memory_claims
from pymdr.interpretation.memory import NOT_CHECKED, MemorySurface, check_memory, memory_claims
from pymdr.interpretation.validity import NORMAL_FIELDS, BoolArray, Claim, Level
from pymdr.line.curves import Line
from pymdr.line.foundation import mean_pressure, normal_force, normal_stiffness, rises_to, states_at_depth
from pymdr.line.layered import LayeredLine
from pymdr.line.lines import unit_line_of
from pymdr.line.memory import (
    Goal,
    MemoryHistory,
    MemoryState,
    Parts,
    Watch,
    compliant,
    creep,
    deepest_under,
    follow_loads,
    follow_springs,
    follow_travels,
    parts_of,
    prepared,
    relaxed,
    ting,
    virgin,
)
from pymdr.line.memory import Rows as Ting
from pymdr.mapping.equivalent import equivalent_profile, gap_function
from pymdr.mapping.relaxation import Relaxation
from pymdr.problem.contact import Contact
from pymdr.problem.profiles import ForceCurve
from pymdr.problem.schedule import Stretch, known_legs
from pymdr.result import Result, Status
from pymdr.rows import taken
from pymdr.solving import memory
from pymdr.solving.mapped import notes_of, refuse_unreachable
from pymdr.solving.normal import check_normal_path, refuse_tension
from pymdr.solving.walk import (
    Channels,
    Interpretation,
    LegProgress,
    Task,
    Walked,
    channels_at,
    solution,
    walk,
    with_travel,
)
from pymdr.units import FloatArray

_COMPARED = ("force", "contact_radius", "stored", "dissipated", "indentation", "work")
SPRINGS = 1000
"""Springs in the largest contact."""
LEVELS = ((2, SPRINGS), (1, SPRINGS // 2), (1, SPRINGS // 4))
"""Parts of a step and numbers of springs by which rows and their errors are computed."""
STRAIGHT = 1e-3
"""Largest deviation of an indentation that is not prescribed from a straight line within a part of a row, over the
largest indentation, before the parts are refined twice more."""
_LARGE = 0.01
"""Error of pressures from which on claims say what reduces it."""
_SHALLOW = 0.1
"""Fraction of the largest target below which the first rows are divided by their own size."""


@dataclass(frozen=True)
class MemoryRows:
    """Rows of springs with memory."""

    indentation: FloatArray
    normal_force: FloatArray
    contact_radius: FloatArray
    stored: FloatArray
    dissipated: FloatArray
    work: FloatArray
    disk: np.ndarray
    forced: BoolArray
    """Whether the force is prescribed."""
    moved: BoolArray
    """Whether the indentation is."""
    coarse: FloatArray
    """Results with half as many springs and steps, where needed: one column for each of `_COMPARED`."""
    coarsest: FloatArray
    """Results with a quarter of the springs."""

    def of_fewer(self, name: str) -> tuple[FloatArray, FloatArray]:
        """One quantity with half and with a quarter of the springs."""
        column = _COMPARED.index(name)
        return self.coarse[:, column], self.coarsest[:, column]


def solve_viscoelastic(task: Task) -> Result:
    """Map, walk and interpret."""
    check_normal_path(task.path)
    relaxation = memory.relaxation_along(task.contact, task.path)
    line = unit_line_of(task.contact)
    walked = walk(task, None, partial(_step, task, line, relaxation))
    if memory.depends_on_rows(task.contact, task.path):
        relaxation = memory.relaxation_along(task.contact, task.path, walked.time)
        walked = walk(task, None, partial(_step, task, line, relaxation))
    return solution(task, walked, interpreted(task, line, relaxation, walked))


def _step(
    task: Task,
    line: Line,
    relaxation: Relaxation,
    state: Sequence[MemoryState] | None,
    stretch: Stretch,
    kept: np.ndarray | None,
    progress: LegProgress | None,
) -> tuple[MemoryRows, Sequence[MemoryState], Channels]:
    """Step 2: springs with memory, and fewer springs for the error."""
    refuse_untimed(stretch, relaxation)
    state = untouched_states(task, line, relaxation, stretch) if state is None else state
    # as with friction, which changes nothing here
    loads = stretch.controls.normal != "indentation"
    parts = parts_between(task, line, relaxation, stretch, state[1], loads=loads)
    levels = [
        followed_leg(task, line, relaxation, stretch, one, parts.halved(2 * many), n)
        for one, (many, n) in zip(state, LEVELS, strict=True)
    ]
    rows, here = rows_met(task, line, relaxation, stretch, levels)
    return taken(rows, kept), [one.state for one in levels], here


def refuse_untimed(stretch: Stretch, relaxation: Relaxation) -> None:
    """Refuse legs without times, tensile forces, and moves that would need an infinite force."""
    memory.times_of(stretch)
    memory.refuse_sudden(stretch, relaxation)
    if stretch.by_force:
        refuse_tension(stretch.leg, stretch.normal)


def rows_met(
    task: Task,
    line: Line,
    relaxation: Relaxation,
    stretch: Stretch,
    levels: Sequence[MemoryHistory],
) -> tuple[MemoryRows, Channels]:
    """Rows of a leg with those by fewer springs, and the end of the leg."""
    fine, *others = levels
    deepest = states_at_depth(line, np.array([float(np.max(fine.indentation))]))
    refuse_unreachable(line, task.contact.profile, deepest)
    if not rises_to(line, float(deepest.indentation[0])):
        raise ProblemError(
            "the equivalent profile decreases within the contact, which is not covered with memory; use an increasing profile, "
            "or smooth it"
        )
    assert stretch.time is not None
    # a series of exponentials for a power of time gives way at once where its first term ends
    rigid = (stretch.time == stretch.begin) & relaxation.instantly_rigid & (fine.indentation > 0.0)
    k = task.machine_stiffness or 0.0  # all of a travel bends the machine
    depth = np.where(rigid, 0.0, fine.indentation)
    force = stretch.normal if stretch.by_force else np.where(rigid, k * stretch.normal, fine.force)
    # a load that has not indented rests on the flat end, if there is one
    resting = rigid | ((depth == 0.0) & (force > 0.0))
    flat = _flat_radius(line, deepest.indentation[0]) if resting.any() else 0.0
    rows = MemoryRows(
        depth,
        force,
        np.where(resting, flat, fine.contact_radius),
        np.where(rigid, 0.0, fine.stored),
        np.where(rigid, 0.0, fine.dissipated),
        np.where(rigid, 0.0, fine.work),
        fine.disk,
        np.full(fine.force.size, stretch.by_force),
        np.full(fine.force.size, stretch.controls.normal == "indentation"),
        *(np.stack([getattr(one, name) for name in _COMPARED], axis=1) for one in others),
    )
    for fewer in (rows.coarse, rows.coarsest):
        fewer[resting, _COMPARED.index("contact_radius")] = flat
    return rows, channels_at(float(fine.indentation[-1]), float(fine.force[-1]), task.machine_stiffness)


def _flat_radius(line: Line, depth: float) -> float:
    """Radius in m of a flat end, on which bodies rest without indentation; 0 of a pointed or round one."""
    radius = float(states_at_depth(line, [max(1e-30 * depth, 1e-60)]).contact_radius[0])
    return radius if line.equivalent.g(np.array([0.5 * radius]))[0] == 0.0 else 0.0


def untouched_states(task: Task, line: Line, relaxation: Relaxation, stretch: Stretch) -> list[MemoryState]:
    """Bodies that have not touched, with all springs, half of them and so on, for the deepest indentation that any leg names.

    A first leg under forces lays its own, where that goes deeper.
    """
    separated = virgin(stretch.begin, min(stretch.start[0], 0.0))
    named = [getattr(leg, "indentation", None) for leg in known_legs(task.path)]
    deepest = max((float(np.max(each)) for each in named if each is not None), default=0.0)
    try:
        if stretch.by_force and deepest > 0.0:
            time, force = (
                np.append(stretch.begin, memory.times_of(stretch)),
                np.append(stretch.start[0], stretch.normal),
            )
            deepest = max(deepest, deepest_under(line, relaxation, time, force))
        return [prepared(line, relaxation, deepest, separated, n) for _, n in LEVELS]
    except PymdrError:  # too deep, as the leg that goes there says when it is followed
        return [separated] * len(LEVELS)


def parts_between(
    task: Task,
    line: Line,
    relaxation: Relaxation,
    stretch: Stretch,
    state: MemoryState,
    loads: bool,
    n: int = SPRINGS // 2,
) -> Parts:
    """Parts of the rows of a leg, as short as its indentation bends where it is not prescribed, or its loads; n springs are laid if none are."""
    assert stretch.time is not None
    machine = 0.0 if stretch.by_force else math.inf
    if stretch.controls.normal == "travel" and task.machine_stiffness is not None:
        machine = task.machine_stiffness
    goal = Goal(stretch.time, stretch.normal, stretch.start[0], machine)
    return _divided(line, relaxation, goal, state, loads, n)


def _divided(
    line: Line, relaxation: Relaxation, goal: Goal, state: MemoryState, loads: bool, n: int
) -> Parts:
    """Parts of rows; of first ones that are far shallower than the deepest, as if they were the whole path."""
    parts = parts_of(line, relaxation, goal, state, tolerance=STRAIGHT, loads=loads, n=n)
    so_far = np.maximum.accumulate(goal.target)
    shallow = int(np.count_nonzero(so_far < _SHALLOW * so_far[-1]))
    if shallow == 0 or so_far[shallow - 1] <= 0.0 or state.deflection.any():
        return parts
    first = goal._replace(time=goal.time[:shallow], target=goal.target[:shallow])
    whole = _divided(line, relaxation, first, virgin(state.time, state.indentation), loads, n)
    later = parts.row >= shallow
    return Parts(
        np.concatenate([whole.row, parts.row[later]]), np.concatenate([whole.fraction, parts.fraction[later]])
    )


def followed_leg(
    task: Task,
    line: Line,
    relaxation: Relaxation,
    stretch: Stretch,
    state: MemoryState,
    parts: Parts,
    n: int,
    watch: Watch | None = None,
) -> MemoryHistory:
    """A leg on n springs; in parts between rows that are watched or whose indentation is not prescribed."""
    assert stretch.time is not None
    by_travel = stretch.controls.normal == "travel" and task.machine_stiffness is not None
    if watch is None and not (stretch.by_force or by_travel):
        return follow_springs(line, relaxation, stretch.time, stretch.normal, state, n=n)
    time, target = parts.along(stretch.time, stretch.begin), parts.along(stretch.normal, stretch.start[0])
    if stretch.by_force:
        history = follow_loads(line, relaxation, time, target, state, n=n, watch=watch)
    elif by_travel:
        assert task.machine_stiffness is not None
        history = follow_travels(
            line, relaxation, time, target, task.machine_stiffness, state, n=n, watch=watch
        )
    else:
        history = follow_springs(line, relaxation, time, target, state, n=n, watch=watch)
    own = {name: getattr(history, name)[parts.own] for name in history._fields if name != "state"}
    return history._replace(**own)


def interpreted(task: Task, line: Line, relaxation: Relaxation, walked: Walked[MemoryRows]) -> Interpretation:
    """Step 3: quantities, claims and assumptions of every row."""
    rows, time = walked.rows, walked.time
    assert time is not None
    depth, force, radius = rows.indentation, rows.normal_force, rows.contact_radius
    exact, grown = _ting(line, relaxation, walked), _grown(line, relaxation, walked)
    errors, kernel = _errors(rows), kernel_errors(line, relaxation, rows, time)
    notes = [*notes_of(task.contact.profile)]
    if exact is not None:
        force, radius = exact.force[1:], exact.contact_radius[1:]
        errors |= dict.fromkeys(("normal_force", "contact_radius"), np.zeros(force.size))
        kernel |= _sized(relaxation, exact, "normal_force")
        notes.append(
            "one approach and one retraction: force and contact radius are Ting's (1966), without springs"
        )
    if grown is not None:
        pressed = depth > 0.0
        depth = np.where(pressed, grown.indentation[1:], 0.0)
        radius = np.where(pressed, grown.contact_radius[1:], radius)
        errors |= dict.fromkeys(("indentation", "contact_radius"), np.zeros(force.size))
        kernel |= _sized(relaxation, grown, "indentation")
        notes.append(
            "a contact that grows under its forces: indentation and contact radius are Lee and Radok's (1960), without springs"
        )
    given = {"indentation": rows.moved, "normal_force": rows.forced}
    errors = {
        name: error + np.where(given.get(name, False), 0.0, kernel[name]) for name, error in errors.items()
    }
    if relaxation.error > 0.0:
        notes.append(
            f"the rheology is a Prony series whose kernel has an error of at most {relaxation.error:.1g}"
        )
    alike = states_at_depth(line, depth)
    elastic = normal_force(line, alike)
    with np.errstate(divide="ignore", invalid="ignore"):
        secant = np.where(elastic > 0.0, force / elastic, math.nan)
        growth = np.where(elastic > 0.0, normal_stiffness(line, alike) * depth / elastic, 0.0)
    moved = errors["indentation"] * ~rows.moved
    errors["effective_modulus"] = np.fmin(errors["normal_force"] + growth * moved, 1.0)
    errors["mean_pressure"] = np.fmin(errors["normal_force"] + 2.0 * errors["contact_radius"], 1.0)
    columns = with_travel(
        task,
        {
            "indentation": depth,
            "normal_force": force,
            "contact_radius": radius,
            "mean_pressure": mean_pressure(force, radius),
            "effective_modulus": secant,
            "elastic_energy": rows.stored,
            "external_work": rows.work,
            "dissipated_energy": rows.dissipated,
        },
    )
    # the fields of a load that rests on a flat end without indentation are not computed: no spring bears it
    indented = (depth > 0.0) | (force <= 0.0) | (radius == 0.0)
    surface = surface_with_memory(task.contact, relaxation, time, depth, np.where(indented, radius, 0.0))
    fields = _claims_with_fields(task.contact, surface, rows, (*columns, *NORMAL_FIELDS), force)
    claims = fields.claims | {name: _where(fields.claims[name], indented) for name in NORMAL_FIELDS}
    errors |= fields.errors
    if task.contact.layered is not None:
        mapped = np.maximum.accumulate(np.nan_to_num(line.error(radius).max(axis=-1)))
        errors = {name: error + mapped for name, error in errors.items()}
    claims["effective_modulus"] = _where(claims["effective_modulus"], elastic > 0.0)
    claims["mean_pressure"] = _where(claims["mean_pressure"], (radius > 0.0) | (force <= 0.0))
    claims = with_errors(
        claims,
        errors,
        f"; energies are those of the springs and dashpots that the rheology names{memory.OWN_ERRORS}",
        f"as {SPRINGS} springs do",
    )
    return Interpretation(
        columns=columns,
        claims=claims,
        assumptions=memory.assumptions_with_memory(task.contact, radius, float(np.max(depth))),
        status=status_of(claims),
        notes=tuple(notes),
        references=("sneddon", "popov-hess", "ting"),
        is_viscoelastic=True,
    )


class _Claimed(NamedTuple):
    claims: dict[str, Claim]
    errors: dict[str, FloatArray]
    """Of the fields."""


def _claims_with_fields(
    contact: Contact, surface: MemorySurface, rows: MemoryRows, names: Sequence[str], force: FloatArray
) -> _Claimed:
    """Claims by a check of pressure and gap, and the errors of the fields."""
    if isinstance(contact.profile, ForceCurve):  # whose line has neither pressure nor gap
        check = NOT_CHECKED
    else:
        check = check_memory(surface, None if rows.moved.all() else force)
    kernel = surface.relaxation.error
    remark = "" if kernel == 0.0 else f"; the kernel of the rheology has an error of at most {kernel:.1g}"
    if surface.marks(int(np.argmax(surface.contact_radius))):
        remark += "; the error of the pressure is larger within 1 % of the radius of a kink of the profile"
    errors = {name: check.error(name, force.size) + kernel for name in NORMAL_FIELDS}
    if not rows.moved.all() and float(np.max(errors["pressure"], initial=0.0)) > _LARGE:
        remark += (
            f"; fields have errors above {_LARGE:g}, because they follow indentations that are straight between rows, and with few rows no spring "
            "shows the edge: give more steps, such as load(..., steps=20)"
        )
    given = rows.disk, rows.forced, rows.moved
    if isinstance(surface, LayeredMemorySurface):
        claims = layered_memory_claims(names, surface.curve, surface.indentation, given, (check, remark))
        return _Claimed(claims, errors)
    return _Claimed(memory_claims(names, *given, check, remark), errors)


def _where(claim: Claim, known: BoolArray) -> Claim:
    """The claim of a number that is not known in all rows."""
    where = claim.where & known
    if where.all():
        return claim
    why = "not defined without indentation, as in a row that loads a power-law rheology or a dashpot in zero time"
    if where.any():
        return replace(claim, where=where, reason=f"{claim.reason}; {why}")
    return Claim(Level.NOT_VALID, why, claim.source, where)


def status_of(claims: Mapping[str, Claim]) -> Status:
    """The status: whether the contact is a disk in all rows."""
    valid = claims["contact_radius"].where
    return Status.COMPLETED if valid.all() else Status.PARTLY_REFUSED if valid.any() else Status.REFUSED


def _errors(rows: MemoryRows) -> dict[str, FloatArray]:
    """Relative errors of rows, from fewer springs and steps."""
    fine = {
        "normal_force": rows.normal_force,
        "contact_radius": rows.contact_radius,
        "elastic_energy": rows.stored,
        "dissipated_energy": rows.dissipated,
        "indentation": rows.indentation,
        "external_work": rows.work,
    }
    coarser = zip(rows.coarse.T, rows.coarsest.T, strict=True)
    return {
        name: memory.error_of_levels(values, *pair)
        for (name, values), pair in zip(fine.items(), coarser, strict=True)
    }


def kernel_errors(
    line: Line, relaxation: Relaxation, rows: MemoryRows, time: FloatArray
) -> dict[str, FloatArray]:
    """
    Relative errors of rows by the error of the kernel.

    A kernel that errs by a part of itself moves a force by no more than that part of int E*(t - s) |dF0(d(s))|, which a force that
    is left after a retreat is small beside; a depth by the same of int J(t - s) |d(F/k)|; energies by what such forces do.
    """
    elastic = normal_force(line, states_at_depth(line, rows.indentation))
    bears = memory.travelled(relaxation, relaxed, time, elastic)
    stiffness = line.stiffness(rows.contact_radius)
    load = np.divide(rows.normal_force, stiffness, out=np.zeros(time.size), where=stiffness > 0.0)
    creeps = memory.travelled(relaxation, compliant, time, load)
    work = 2.0 * np.cumsum(bears * np.abs(np.diff(rows.indentation, prepend=0.0)))
    return {
        "normal_force": memory.relative_errors(bears, rows.normal_force),
        "indentation": memory.relative_errors(creeps, rows.indentation),
        "contact_radius": memory.relative_errors(creeps, rows.indentation),
        "elastic_energy": memory.relative_errors(work, rows.stored),
        "dissipated_energy": memory.relative_errors(work, rows.dissipated),
        "external_work": memory.relative_errors(work, rows.work),
    }


def _sized(relaxation: Relaxation, rows: Ting, name: str) -> dict[str, FloatArray]:
    """Errors of the kernel in rows without springs."""
    sizes = {name: rows.gained[1:], "contact_radius": rows.widened[1:]}
    return {name: np.fmin(relaxation.error * np.nan_to_num(size), 1.0) for name, size in sizes.items()}


def _ting(line: Line, relaxation: Relaxation, walked: Walked[MemoryRows]) -> Ting | None:
    """Rows without springs, where the path is one approach and one retreat under prescribed indentations."""
    rows, time = walked.rows, walked.time
    d = rows.indentation
    if not (rows.moved.all() and d.max() > 0.0) or time is None or relaxation.viscosity > 0.0:
        return None
    start = min(float(walked.starts[0].get("indentation", 0.0)), 0.0)
    try:
        return ting(line, relaxation, np.append(0.0, time), np.append(min(start, 0.0), d))
    except PathError:
        return None


def _grown(line: Line, relaxation: Relaxation, walked: Walked[MemoryRows]) -> Ting | None:
    """Rows without springs, where all are forces under which the contact grows."""
    rows, time = walked.rows, walked.time
    if time is None or not rows.forced.all() or not rows.normal_force.any():
        return None
    try:
        return creep(line, relaxation, np.append(0.0, time), np.append(0.0, rows.normal_force))
    except PathError:
        return None


def surface_with_memory(
    contact: Contact, relaxation: Relaxation, time: FloatArray, depth: FloatArray, radius: FloatArray
) -> MemorySurface:
    """The surface from which fields of a contact with memory are computed."""
    equivalent = equivalent_profile(contact.profile)
    gap = gap_function(contact.profile, equivalent)
    columns = equivalent, relaxation, gap, time, depth, radius, SPRINGS
    line = unit_line_of(contact)
    return LayeredMemorySurface(*columns, line) if isinstance(line, LayeredLine) else MemorySurface(*columns)
