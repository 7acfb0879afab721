"""The contact of bodies with memory under adhesion of short range along a path: an equation for the contact radius."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pymdr.errors import NotValidError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.validity import NORMAL_FIELDS, SOURCES, Assumption, Claim, Level, with_prescribed
from pymdr.line.foundation import mean_pressure
from pymdr.line.soft.small_zone import ShortSprings, SmallZone
from pymdr.problem.schedule import Stretch
from pymdr.result import Result, Status
from pymdr.result.readers import FieldReader
from pymdr.solving.mapped import notes_of
from pymdr.solving.memory import assumptions_with_memory, relaxation_along
from pymdr.solving.normal import refuse_tangential
from pymdr.solving.soft import controls_of
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
from pymdr.solving.zones import short_springs
from pymdr.units import FloatArray, metres, newtons

WITHOUT_FIELDS = "the law of a small zone gives the contact radius and forces only; use MaugisDugdale(work, range=...) for fields"
_IN_CONTACT = "elastic_energy is that of the springs in contact; energy that springs behind the edge still store counts as dissipated"
_PER_LENGTH = 1.5
"""Error over the length of the zone in contact radii, an upper bound of the differences from `MaugisDugdale` that were measured."""
_PER_LOAD = 0.35
"""Error over the load that springs have yet to relax where the contact grows, over that of the edge; measured alike."""
_PER_FORCE = 0.8
"""Error over the force of that load on the whole contact, over the largest force; measured alike."""
_LEAST = 2e-4
"""Least error, by the tolerance of the equation and the table."""
_RELAXED = 0.05


@dataclass(frozen=True)
class Rows:
    """Columns of a walk."""

    rows: dict[str, FloatArray]
    control: FloatArray
    """Machine stiffness in N/m equivalent to the control."""


def no_fields(result: Result) -> FieldReader:
    """The refusal of fields."""
    raise NotValidError(WITHOUT_FIELDS)


def solve_small_zone(task: Task) -> Result:
    """Map, walk and interpret."""
    refuse_tangential(
        task.path, "the contact is adhesive: adhesion with friction is not covered; leave the channel out"
    )
    springs = short_springs(task.contact, relaxation_along(task.contact, task.path))
    walked = walk(task, springs, partial(_step, task.machine_stiffness))
    return solution(task, walked, _interpret(task, springs.setting, walked, springs.parted))


def _step(
    stiffness: float | None,
    springs: ShortSprings,
    stretch: Stretch,
    kept: np.ndarray | None,
    progress: LegProgress | None,
) -> tuple[Rows, ShortSprings, Channels]:
    """Step 2: the equation of the contact radius."""
    assert kept is None
    time, control, k = controls_of(stretch, stiffness, springs.free)
    rows = springs.follow(time, control, k)
    d, force = float(rows["indentation"][-1]), float(rows["normal_force"][-1])
    return Rows(rows, np.full(time.size - 1, k)), springs, channels_at(d, force, stiffness)


def _through_advances(values: FloatArray, advances: np.ndarray) -> FloatArray:
    """Largest values of advancing rows so far, and of those to the end of an advance: its first row may span most of its effect."""
    largest = np.where(advances, values, 0.0)
    for row in range(values.size - 2, -1, -1):
        if advances[row + 1]:
            largest[row] = max(largest[row], largest[row + 1])
    return np.asarray(np.maximum.accumulate(largest))


def _interpret(
    task: Task, zone: SmallZone, walked: Walked[Rows], parted: tuple[float, float] | None
) -> Interpretation:
    """Step 3: quantities, claims and assumptions of every row, and where the bodies part."""
    rows, control = walked.rows.rows, walked.rows.control
    a, force = rows["contact_radius"], rows["normal_force"]
    attached, released = a > 0.0, rows["energy_release_rate"]
    length = rows["cohesive_radius"] - a
    missing = np.where(attached, np.abs(rows["unrelaxed"] / np.minimum(rows["line_load"], -1e-300)), 0.0)
    speed = np.array(
        [-zone.speed(g) if on else 0.0 for g, on in zip(released.tolist(), attached, strict=True)]
    )
    torn = np.isnan(force)
    energies = {
        "elastic_energy": rows["elastic_energy"],
        "surface_energy": rows["surface_energy"],
        "external_work": rows["elastic_energy"] + rows["surface_energy"] + rows["body_dissipation"],
        "dissipated_energy": rows["body_dissipation"],
    }
    columns = with_travel(
        task,
        {
            "indentation": rows["indentation"],
            "normal_force": force,
            "contact_radius": a,
            "cohesive_radius": rows["cohesive_radius"],
            "mean_pressure": mean_pressure(force, a),
            "energy_release_rate": released,
            **energies,
            "edge_speed": speed,
            "jumped": rows["jumped"],
        },
    )
    everywhere = np.ones(a.size, dtype=bool)
    claim = Claim(
        Level.APPROXIMATE,
        "the law of a cohesive zone that is short compared with the contact and moves steadily over its own length, on viscoelastic "
        "half-spaces that have relaxed where the contact grows. The stated error, relative to the largest force, is an upper bound of "
        "the differences from MaugisDugdale with memory: 1.5 times the largest ratio so far of the length of the zone to the contact "
        "radius; until an advance of the edge ends, also 0.35 times the ratio of the unrelaxed load of the springs to the load of the edge, "
        "and 0.8 times the ratio of the unrelaxed force to the largest force. The error is 1 near the separation, which the zone may delay",
        SOURCES["schapery"],
        everywhere,
    )
    wide = np.maximum.accumulate(length / np.where(attached, a, 1.0))
    late = _through_advances(missing, speed < 0.0)
    # in retraction the load is negative, and reaches no new springs
    unrelaxed_force = np.where(attached, np.maximum(2.0 * a * rows["unrelaxed"], 0.0), 0.0)
    largest = float(np.nanmax(np.abs(force), initial=0.0)) or 1.0
    missed = _PER_FORCE * _through_advances(unrelaxed_force, speed < 0.0) / largest
    errors = np.minimum(_LEAST + _PER_LENGTH * wide + _PER_LOAD * late + missed, 1.0)
    if parted is not None:
        # the zone may still be attached for as much of the way as the error
        travel = rows["indentation"] + np.divide(force, control, out=np.zeros(a.size), where=control > 0.0)
        last = int(np.flatnonzero(attached)[-1])
        overdue = parted[0] + (parted[1] / control[last] if control[last] > 0.0 else 0.0) - travel[last + 1 :]
        near = overdue <= errors[last] * (np.max(travel[: last + 1]) - travel[last])
        near[:1] = True
        errors[last + 1 :][near] = 1.0
    in_contact = replace(claim, reason=f"{claim.reason}; {_IN_CONTACT}")
    own = dict.fromkeys(columns, claim) | dict.fromkeys(("elastic_energy", "dissipated_energy"), in_contact)
    claims = with_errors(own, dict.fromkeys(columns, errors))
    prescribed = {"indentation": np.isinf(control), "normal_force": control == 0.0}
    if task.machine_stiffness is not None:
        prescribed["travel"] = (control > 0.0) & np.isfinite(control)
    claims = with_prescribed(claims, everywhere, prescribed)
    no_field = Claim(Level.NOT_VALID, WITHOUT_FIELDS, SOURCES["schapery"], ~everywhere)
    claims |= dict.fromkeys(NORMAL_FIELDS, no_field)
    if torn.any():
        claims = {
            name: one if name == "jumped" else replace(one, where=one.where & ~torn)
            for name, one in claims.items()
        }
    status = Status.ATTACHED if attached[-1] else Status.PULLED_OFF if attached.any() else Status.NOT_TOUCHED
    unrelaxed = Assumption(
        "relaxed body where the contact grows",
        "unrelaxed load of the springs over the load of the edge, in rows in which the edge advances",
        float(late[-1]),
        _RELAXED,
    )
    notes = notes_of(task.contact.profile)
    if parted is not None:
        row = int(np.flatnonzero(attached)[-1])
        notes = (*notes, f"pulled off after row {row}, at d = {metres(parted[0])}, F = {newtons(parted[1])}")
    return Interpretation(
        columns=columns,
        claims=claims,
        assumptions=(*assumptions_with_memory(task.contact, a), unrelaxed),
        status=status,
        notes=notes,
        references=("sneddon", "popov-hess", "schapery", "haiat-barthel"),
        is_viscoelastic=True,
    )
