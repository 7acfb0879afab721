"""The contact of bodies with memory under a cohesive zone along a path."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pymdr.errors import ConvergenceError, PathError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.adhesion import energy_assumption
from pymdr.interpretation.soft import ZoneCheck, ZoneSurface, check_zone
from pymdr.interpretation.validity import NORMAL_FIELDS, SOURCES, Claim, Level
from pymdr.line.foundation import mean_pressure
from pymdr.line.soft.springs import (
    COARSE,
    FINE,
    HASTY,
    ROUGH,
    ZoneLevel,
    ZoneLine,
    ZoneSetting,
    ZoneSprings,
    zone_level,
)
from pymdr.mapping.equivalent import equivalent_profile, gap_function
from pymdr.mapping.relaxation import Relaxation
from pymdr.problem.contact import Contact
from pymdr.problem.schedule import Stretch, planned, total_rows
from pymdr.result import Result, Status
from pymdr.solving import memory
from pymdr.solving.mapped import notes_of
from pymdr.solving.normal import refuse_tangential
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
from pymdr.solving.zones import with_measured_zone, zone_relaxation, zone_setting
from pymdr.units import FloatArray, metres, newtons

_CONTROL = {"indentation": math.inf, "normal_force": 0.0}
_UNKNOWN_WHEN_TORN = (
    "indentation",
    "normal_force",
    "mean_pressure",
    "travel",
    "external_work",
    "dissipated_energy",
    "jump_dissipation",
    *NORMAL_FIELDS,
)
"""Quantities that are not known after a dead load has separated the bodies."""
_LARGEST_SPACING, _LEAST_SPACING = 4.0, 0.25
"""First and last spacing of the nodes that a tolerance tries, over that of `FINE`."""
_AIM, _ORDER = 0.6, 1.5
"""Error over the tolerance for which the next spacing is chosen, and the order of convergence from singular instants on."""
_CHECKED = 8
"""Rows in which the errors of fields are measured."""
_BALANCED = 1e-3
"""Largest relative residual of the balance of energies."""
_COMPARED = (
    "indentation",
    "normal_force",
    "contact_radius",
    "cohesive_radius",
    "elastic_energy",
    "surface_energy",
)


_SHARED = 1e-7
"""Relative error that all levels have alike: that to which a step is solved."""
_OF_INSTANT = 3.0
"""Error of the instant of a jump over its difference from those of two coarser levels, since values are singular before it."""
_OF_ROWS = "work", "jump_dissipation"
"""Energies of each row alone."""


@dataclass(frozen=True)
class ZoneRows:
    """Rows of all levels, by name."""

    fine: dict[str, FloatArray]
    coarse: dict[str, FloatArray]
    rough: dict[str, FloatArray]
    control: FloatArray
    """Machine stiffness in N/m equivalent to the control."""
    time: FloatArray
    """In s."""


def solve_soft(task: Task) -> Result:
    """Map, walk and interpret, with closer nodes and shorter steps until a tolerance is met."""
    refuse_tangential(
        task.path, "the contact is adhesive: adhesion with friction is not covered; leave the channel out"
    )
    setting = _setting(task)
    if task.tolerance is None:
        return _interpreted(task, *_followed(task, setting, (FINE, COARSE, ROUGH)))
    spacing = _LARGEST_SPACING
    while True:
        reached = math.inf
        try:
            followed = _followed(task, setting, tuple(zone_level(n * spacing) for n in (1.0, 2.0, 4.0)))
            reached = _error_reached(followed[-1].rows)
        except ConvergenceError:
            if spacing <= 1.0:
                raise
        if reached <= task.tolerance:
            return _interpreted(task, *followed)
        if spacing <= _LEAST_SPACING:
            result = _interpreted(task, *followed)
            missed = f"the tolerance {task.tolerance:g} is not met: an error of {reached:.2g} of the largest value remains"
            return replace(result, notes=(*result.notes, missed))
        refined = (_AIM * task.tolerance / reached) ** (1.0 / _ORDER)
        spacing = max(spacing * min(max(refined, 0.25), 0.75), _LEAST_SPACING)


def _interpreted(
    task: Task, setting: ZoneSetting, levels: tuple[ZoneSprings, ...], walked: Walked[ZoneRows]
) -> Result:
    """The result, with the errors of fields in some rows."""
    surface = _surface(task, setting, walked.rows.fine, walked.starts)
    # fields are computed at `FINE`
    coarse = next(one for one in levels[1:] if one.spacing >= FINE.spacing)
    range_ = setting.work / setting.strength
    check = check_zone(surface, _watched(task), levels[0].lines, coarse.lines, range_)
    return solution(task, walked, _interpret(task, setting, walked, check))


def _error_reached(rows: ZoneRows) -> float:
    """Largest error of force and indentation over their largest values, but in rows beside jumps."""
    known = ~(_parted_differently(rows) | _beside_jumps(rows))
    reached = 0.0
    for name, prescribed in _CONTROL.items():
        value = np.abs(np.nan_to_num(rows.fine[name]))
        off = value * np.where(known & (rows.control != prescribed), _error_of(rows, name), 0.0)
        reached = max(reached, float(np.max(off)) / float(np.max(value) or 1.0))
    return reached


def _watched(task: Task) -> list[int]:
    """Rows in which fields are checked."""
    return sorted({int(row) for row in np.linspace(0, total_rows(task.path) - 1, _CHECKED)})


def _followed(
    task: Task, setting: ZoneSetting, each: tuple[ZoneLevel, ...], time: FloatArray | None = None
) -> tuple[ZoneSetting, tuple[ZoneSprings, ...], Walked[ZoneRows]]:
    """The rows of all levels, with the times of rows of a former solution where only these tell the duration of the path."""
    watched = _watched(task)
    levels = tuple(
        ZoneSprings(replace(setting, relaxation=_relaxation(task, time, level)), level, watched)
        for level in each
    )
    walked = walk(task, levels, partial(_step, task.machine_stiffness))
    assert walked.time is not None
    if time is None and not setting.relaxation.rubbery > 0.0 and memory.has_times_of_rows(task.path):
        return _followed(task, _setting(task, walked.time), each, walked.time)
    return setting, levels, walked


def zone_force(
    contact: Contact, time: FloatArray, control: FloatArray, stiffness: float, level: ZoneLevel = FINE
) -> FloatArray:
    """
    Normal force in N along a record, without the error that :func:`solve_soft` measures.

    Parameters
    ----------
    contact : Contact
        With memory and a cohesive zone.
    time, control : ndarray
        Times in s, and indentations or travels in m, from a free body on.
    stiffness : float
        Of the machine in N/m; inf for indentations.
    level : ZoneLevel
        Resolution.
    """
    span = float(np.diff(time).min()), float(np.ptp(time))
    relaxation = zone_relaxation(contact, span, level)
    largest = {stiffness: max(float(control.max()), 0.0)}
    setting = zone_setting(contact, relaxation, largest, span[1])
    from_start = np.append(time[0], time), np.append(control[0], control)

    def follow(springs: ZoneSprings) -> Mapping[str, FloatArray]:
        return springs.follow(*from_start, stiffness)

    # one of many guesses is refused where it needs many nodes
    measured = setting if level is HASTY else with_measured_zone(setting, follow)
    return follow(ZoneSprings(measured, level))["normal_force"]


def zone_surface(result: Result) -> ZoneSurface:
    """The source of fields, which follows the path again up to the requested row."""
    task = Task(result.contact, result.path, result.reading, result.machine_stiffness)
    setting = _setting(task, result.data["time"].values)
    columns = {name: result.data[name].values for name in ("contact_radius", "cohesive_radius")}
    assert result.starts is not None
    return _surface(task, setting, columns, result.starts)


def _surface(
    task: Task, setting: ZoneSetting, columns: Mapping[str, FloatArray], starts: Sequence[Channels]
) -> ZoneSurface:
    equivalent = equivalent_profile(task.contact.profile)
    return ZoneSurface(
        equivalent,
        gap_function(task.contact.profile, equivalent),
        setting.relaxation.rubbery,
        setting.relaxation.glassy,
        setting.strength,
        columns["contact_radius"],
        columns["cohesive_radius"],
        partial(_line_at, task, setting, starts),
    )


def _line_at(task: Task, setting: ZoneSetting, starts: Sequence[Channels], row: int) -> ZoneLine:
    """The springs of a row, by the same steps as those of the solution."""
    springs, now = ZoneSprings(setting, FINE, (row,)), 0.0
    for leg, start in zip(planned(task.path), starts, strict=True):
        stretch = leg.stretch(start, now)
        time, control, k = _controls(stretch, task.machine_stiffness)
        now = float(time[-1])
        rows = min(row - leg.first, leg.size - 1) + 2
        springs.follow(time[:rows], control[:rows], k)
        if springs.lines:
            break
    return springs.lines[0]


def _relaxation(task: Task, time: FloatArray | None, level: ZoneLevel) -> Relaxation:
    return zone_relaxation(task.contact, memory.span_along(task.contact, task.path, time), level)


def _setting(task: Task, time: FloatArray | None = None) -> ZoneSetting:
    """The springs, for the zones of the softest contact at the largest target of the path, or for those of the path where they are far longer."""
    relaxation = _relaxation(task, time, FINE)
    longest = math.inf if relaxation.rubbery > 0.0 else memory.times_along(task.path, time)[1]
    largest: dict[float, float] = {}
    for leg in planned(task.path):
        target = np.ravel(np.asarray(getattr(leg.leg, leg.controls.normal, 0.0), dtype=float))
        k = _CONTROL.get(leg.controls.normal, task.machine_stiffness or math.inf)
        largest[k] = max(float(np.max(target, initial=0.0)), largest.get(k, 0.0))
    setting = zone_setting(task.contact, relaxation, largest, longest)

    def follow(springs: ZoneSprings) -> Mapping[str, FloatArray]:
        levels: tuple[ZoneSprings, ...] = (springs,)
        return walk(replace(task, progress=None), levels, partial(_step, task.machine_stiffness)).rows.fine

    return with_measured_zone(setting, follow)


def _step(
    stiffness: float | None,
    levels: tuple[ZoneSprings, ...],
    stretch: Stretch,
    kept: np.ndarray | None,
    progress: LegProgress | None,
) -> tuple[ZoneRows, tuple[ZoneSprings, ...], Channels]:
    """Step 2: springs and zone, and fewer nodes and longer steps for the error, or one level for all."""
    assert kept is None
    setting = levels[0].setting
    range_ = setting.work / setting.strength
    time, control, k = controls_of(stretch, stiffness, levels[0].free, range_)
    each = [one.follow(time, control, k) for one in levels]
    fine, coarse, rough = each * (3 // len(each))
    free = fine["cohesive_radius"] == 0.0
    for rows in (fine, coarse, rough):
        if math.isinf(k):
            rows["indentation"] = control[1:].copy()
        if k == 0.0:
            separated = rows["cohesive_radius"] == 0.0
            rows["indentation"] = np.where(separated, math.nan, rows["indentation"])
            rows["normal_force"] = np.where(separated, math.nan, control[1:])
    d, force = float(fine["indentation"][-1]), float(fine["normal_force"][-1])
    leg = ZoneRows(fine, coarse, rough, np.full(free.size, k), time[1:])
    return leg, levels, channels_at(d, force, stiffness)


def controls_of(
    stretch: Stretch, stiffness: float | None, free: bool, range_: float = 0.0
) -> tuple[FloatArray, FloatArray, float]:
    """As `_controls`, after refusing moves in zero time and pulls on a free body, which is attracted from a distance in m on."""
    time, control, k = _controls(stretch, stiffness)
    sudden = (np.diff(time) == 0.0) & (np.diff(control) != 0.0)
    if free:
        # it may start anywhere, but needs time to be attracted
        sudden[0] = time[-1] == time[0] and control[-1] > (-range_ if k > 0.0 else 0.0)
    if sudden.any():
        end = float(time[1 + int(np.argmax(sudden))])
        least = (
            f" above {np.spacing(end):.1g} s (the resolution of numbers at this time)" if end > 0.0 else ""
        )
        raise PathError(
            f"the row at t = {end:.6g} s moves in zero time, which adhesion with memory does not cover; give every move a duration{least}, or a rate"
        )
    if k == 0.0 and not math.isnan(stretch.start[0]) and free and control[1] < 0.0:
        raise PathError(
            f"normal_force = {newtons(float(control[1]))}: a body out of contact cannot be pulled; make contact first, for example with "
            "load('0 N', duration='1 s') >> ..."
        )
    return time, control, k


def _controls(stretch: Stretch, stiffness: float | None) -> tuple[FloatArray, FloatArray, float]:
    """Times and controls of a leg, from those before it on, and the stiffness of the machine."""
    time = np.append(stretch.begin, memory.times_of(stretch))
    control = np.append(stretch.start[0], stretch.normal)
    if math.isnan(control[0]):  # lost under a force
        control[0] = control[1]
    return time, control, _CONTROL.get(stretch.controls.normal, math.inf if stiffness is None else stiffness)


def _interpret(
    task: Task, setting: ZoneSetting, walked: Walked[ZoneRows], check: ZoneCheck
) -> Interpretation:
    """Step 3: quantities, claims and assumptions of every row."""
    rows, relaxation = walked.rows, setting.relaxation
    fine = rows.fine
    k = task.machine_stiffness
    force = fine["normal_force"]
    machine = np.zeros(force.size) if k is None or math.isinf(k) else 0.5 * np.nan_to_num(force) ** 2 / k
    work = np.cumsum(fine["work"])
    spent = fine["body_dissipation"] + np.cumsum(fine["jump_dissipation"])
    balance = work - fine["elastic_energy"] - fine["surface_energy"] - machine - spent
    columns = with_travel(
        task,
        {
            "indentation": fine["indentation"],
            "normal_force": force,
            "contact_radius": fine["contact_radius"],
            "cohesive_radius": fine["cohesive_radius"],
            "mean_pressure": mean_pressure(force, fine["contact_radius"]),
            "elastic_energy": fine["elastic_energy"],
            "surface_energy": fine["surface_energy"],
            "external_work": work,
            "dissipated_energy": spent,
            "jumped": fine["jumped"],
            "jump_dissipation": fine["jump_dissipation"],
        },
    )
    everywhere = np.ones(force.size, dtype=bool)
    claim = Claim(
        Level.EXACT,
        "exact for viscoelastic half-spaces of constant Poisson's ratio in frictionless contact on a disk that attract each other by a "
        "constant stress up to its range; assumes that the gap stays positive in the cohesive zone",
        SOURCES["haiat-barthel"],
        everywhere,
    )
    errors = _errors(rows, columns, balance)
    # of the series of a power of time, whose faster terms the levels share
    errors = {
        name: np.where(error > 0.0, np.minimum(error + relaxation.error, 1.0), 0.0)
        for name, error in errors.items()
    }
    radii = np.maximum(errors["contact_radius"], errors["cohesive_radius"])
    errors |= {name: np.minimum(check.error(name, force.size) + radii, 1.0) for name in NORMAL_FIELDS}
    claims = with_errors(
        dict.fromkeys((*columns, *NORMAL_FIELDS), claim),
        errors,
        cause="from calculations with twice and four times the spacing of nodes and longer steps",
    )
    torn = np.isnan(force)
    if torn.any():
        claims = {
            name: replace(one, where=~torn) if name in _UNKNOWN_WHEN_TORN else one
            for name, one in claims.items()
        }
    touched = fine["cohesive_radius"] > 0.0
    status = Status.ATTACHED if touched[-1] else Status.PULLED_OFF if touched.any() else Status.NOT_TOUCHED
    notes = [*notes_of(task.contact.profile), *_jump_notes(rows)]
    if relaxation.error > 0.0:
        notes.append(
            f"the rheology is a Prony series whose kernel has an error of at most {relaxation.error:.1g}"
        )
    return Interpretation(
        columns=columns,
        claims=claims,
        assumptions=(
            *memory.assumptions_with_memory(task.contact, fine["contact_radius"]),
            *check.assumptions,
            energy_assumption(_residual(rows, balance, work), _BALANCED),
        ),
        status=status,
        notes=tuple(notes),
        references=("sneddon", "popov-hess", "haiat-barthel", "maugis"),
        starts=walked.starts,
        is_viscoelastic=True,
    )


def _errors(rows: ZoneRows, columns: dict[str, FloatArray], balance: FloatArray) -> dict[str, FloatArray]:
    """Relative errors from twice and four times the spacing and longer steps, 1 where only some of the levels are attached."""
    fine = rows.fine
    differ = _parted_differently(rows)
    errors = {name: _error_of(rows, name) for name in _COMPARED}
    sizes = np.abs(columns["external_work"]) + np.abs(fine["elastic_energy"]) + np.abs(fine["surface_energy"])
    whole = np.maximum.accumulate(np.nan_to_num(sizes))
    # the balance of the energies, of which each has its own quadrature, and what a change of all of them leaves in balance
    missed = np.maximum.accumulate(np.nan_to_num(np.abs(balance)))
    body, jumps, worked = (
        _difference(rows, name) for name in ("body_dissipation", "jump_dissipation", "work")
    )
    unknown = differ | _beside_jumps(rows)
    # later rows do not inherit a jump that some of the levels have yet to make
    jumps = np.where(unknown, 0.0, jumps)
    # all levels may miss the instant of a jump alike
    worked *= 1.0 + np.maximum.accumulate(fine["jumped"])
    missed += memory.later_too(np.maximum(body + 2.0 * jumps, worked), whole)
    with np.errstate(divide="ignore", invalid="ignore"):
        errors["dissipated_energy"] = np.minimum(
            np.nan_to_num(missed / np.abs(columns["dissipated_energy"])), 1.0
        )
        errors["external_work"] = errors["jump_dissipation"] = np.minimum(np.nan_to_num(missed / whole), 1.0)
    errors["mean_pressure"] = np.minimum(errors["normal_force"] + 2.0 * errors["contact_radius"], 1.0)
    errors["travel"] = errors["indentation"] + errors["normal_force"]
    errors["jumped"] = np.zeros(differ.size)
    moved = {"indentation": np.isinf(rows.control), "normal_force": rows.control == 0.0}
    moved["travel"] = (rows.control > 0.0) & np.isfinite(rows.control)
    errors = {name: np.where(unknown, 1.0, error) for name, error in errors.items()}
    return {
        name: np.where(moved[name], 0.0, error) if name in moved else error for name, error in errors.items()
    }


def _parted_differently(rows: ZoneRows) -> np.ndarray:
    """Rows in which only some of the levels are attached."""
    free, coarse, rough = (one["cohesive_radius"] == 0.0 for one in (rows.fine, rows.coarse, rows.rough))
    return np.asarray((free != coarse) | (free != rough))


def _error_of(rows: ZoneRows, name: str) -> FloatArray:
    """Relative errors of a column; later rows do not inherit the difference of those in which only some of the levels are attached."""
    value = rows.fine[name]
    difference = np.where(_parted_differently(rows), 0.0, _difference(rows, name) + _SHARED * np.abs(value))
    error: FloatArray = memory.error_of(value, value + difference)
    return error


def _beside_jumps(rows: ZoneRows) -> np.ndarray:
    """Rows that are nearer to a jump than the error of its instant, so that all levels may be on the same wrong side of it."""
    beside = np.zeros(rows.time.size, dtype=bool)
    fine, coarse, rough = (
        one["jump_time"][np.isfinite(one["jump_time"])] for one in (rows.fine, rows.coarse, rows.rough)
    )
    if coarse.size and rough.size:
        for instant in fine.tolist():
            half, quarter = (float(one[np.argmin(np.abs(one - instant))]) for one in (coarse, rough))
            error = _OF_INSTANT * (abs(instant - half) + 0.5 * abs(half - quarter))
            beside |= np.abs(rows.time - instant) <= error
    return beside


def _difference(rows: ZoneRows, name: str) -> FloatArray:
    """Difference of a column from those of two coarser levels, because one may agree by chance; singular instants reduce the order to 1."""
    fine, coarse, rough = (one[name] for one in (rows.fine, rows.coarse, rows.rough))
    if name in _OF_ROWS:
        fine, coarse, rough = np.cumsum(fine), np.cumsum(coarse), np.cumsum(rough)
    return np.nan_to_num(np.abs(fine - coarse) + 0.5 * np.abs(coarse - rough))


def _residual(rows: ZoneRows, balance: FloatArray, work: FloatArray) -> float:
    """Largest residual of the balance of energies over their largest sum."""
    fine = rows.fine
    sizes = np.abs(work) + np.abs(fine["elastic_energy"]) + np.abs(fine["surface_energy"])
    known = np.isfinite(balance) & np.isfinite(fine["normal_force"])
    size = float(np.max(sizes[known], initial=0.0))
    return float(np.max(np.abs(balance[known]), initial=0.0)) / size if size > 0.0 else 0.0


def _jump_notes(rows: ZoneRows) -> tuple[str, ...]:
    """
    Notes on the first attraction and the last separation.

    A separation is located between the rows by what the control prescribes, depth or force: in a snap the rest changes at once.
    """
    fine = rows.fine
    touched = fine["cohesive_radius"] > 0.0
    if not touched.any():
        return ()
    first = int(np.argmax(touched))
    notes = [f"attracted before row {first}, at d = {metres(float(fine['event_depth'][first]))}"]
    separations = np.flatnonzero(touched[:-1] & ~touched[1:])
    if separations.size:
        row = int(separations[-1])
        place, k = "", rows.control[row + 1]
        if math.isinf(k):
            place = f" at d = {metres(float(fine['event_depth'][row + 1]))},"
        elif k == 0.0:
            place = f" at F = {newtons(float(fine['event_force'][row + 1]))},"
        d, force = float(fine["indentation"][row]), float(fine["normal_force"][row])
        notes.append(f"pulled off{place} after row {row}, d = {metres(d)}, F = {newtons(force)}")
    return tuple(notes)
