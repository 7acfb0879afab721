"""The contact of bodies with memory under adhesion of short range along a path: an equation for the contact radius."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pymdr.errors import NotValidError, ProblemError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.validity import NORMAL_FIELDS, SOURCES, Assumption, Claim, Level, with_prescribed
from pymdr.line.foundation import mean_pressure
from pymdr.line.soft.small_zone import ShortRows, ShortSprings, SmallZone
from pymdr.problem.laws import JKR
from pymdr.problem.materials import Elastic, Rigid
from pymdr.problem.schedule import Stretch
from pymdr.result import Result, Status
from pymdr.result.readers import FieldReader
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.mapped import notes_of
from pymdr.solving.memory import assumptions_with_memory, refuse_flow, relaxation_along
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
from pymdr.solving.zones import refuse_edge, springs_of
from pymdr.units import FloatArray, metres, newtons

WITHOUT_FIELDS = "the law of a small zone gives the contact radius and forces only; use MaugisDugdale(work, range=...) for fields"
_LONGEST = 0.2
"""Largest length of the zone at rest over the contact radius."""
_PER_LENGTH = 1.5
"""Error over the length of the zone in contact radii, an upper bound of the differences from `MaugisDugdale` that were measured."""
_PER_LOAD = 0.35
"""Error over the load that springs have yet to relax where the contact grows, over that of the edge; measured alike."""
_LEAST = 2e-4
"""Least error, by the tolerance of the equation and the table."""
_RELAXED = 0.05


@dataclass(frozen=True)
class Rows:
    """Columns of a walk."""

    rows: ShortRows
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
    contact = task.contact
    law = contact.adhesion
    assert isinstance(law, JKR)
    assert law.range is not None
    relaxation = relaxation_along(contact, task.path)
    refuse_flow(relaxation)
    zone = SmallZone(relaxation, law.work, law.work / law.range)
    line = AdhesiveLine(
        replace(contact, body=Elastic(relaxation.rubbery, 0.0), counterbody=Rigid(), adhesion=JKR(law.work))
    )
    size = line.natural_radius
    rest = float(zone.zone_length(law.work))
    if rest > _LONGEST * size:
        raise ProblemError(
            f"solve: JKR.range = {metres(law.range)}: the cohesive zone at rest would be {metres(rest)} long, more than {_LONGEST:g} of the contact "
            f"radius without load, {metres(size)}; use MaugisDugdale(work, range=...), which has no such limit"
        )
    refuse_edge(line, math.inf)
    springs = ShortSprings(zone, springs_of(line), size, line.end)
    walked = walk(task, springs, partial(_step, task.machine_stiffness))
    return solution(
        task, walked, _interpret(task, zone, walked, springs.parted if springs.separated else None)
    )


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
    here = channels_at(float(rows.indentation[-1]), float(rows.normal_force[-1]), stiffness)
    return Rows(rows, np.full(rows.indentation.size, k)), springs, here


def _interpret(
    task: Task, zone: SmallZone, walked: Walked[Rows], parted: tuple[float, float] | None
) -> Interpretation:
    """Step 3: quantities, claims and assumptions of every row, and where the bodies part."""
    rows, control = walked.rows.rows, walked.rows.control
    a, force = rows.contact_radius, rows.normal_force
    attached = a > 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        released = np.minimum(rows.line_load, 0.0) ** 2 / (2.0 * math.pi * a * zone.relaxation.rubbery)
        released = np.where(attached, released, 0.0)
        length = np.where(attached, zone.zone_length(released), 0.0)
        missing = np.where(attached, np.abs(rows.unrelaxed / np.minimum(rows.line_load, -1e-300)), 0.0)
    speed = np.array(
        [-zone.speed(g) if on else 0.0 for g, on in zip(released.tolist(), attached, strict=True)]
    )
    torn = np.isnan(force)
    columns = with_travel(
        task,
        {
            "indentation": rows.indentation,
            "normal_force": force,
            "contact_radius": a,
            "cohesive_radius": a + length,
            "mean_pressure": mean_pressure(force, a),
            "energy_release_rate": released,
            "edge_speed": speed,
            "jumped": rows.jumped,
        },
    )
    everywhere = np.ones(a.size, dtype=bool)
    claim = Claim(
        Level.APPROXIMATE,
        "the law of a cohesive zone that is short compared with the contact and moves steadily over its own length, on viscoelastic "
        "half-spaces that have relaxed where the contact grows. The stated error, relative to the largest force, is an upper bound of "
        "the differences from MaugisDugdale with memory: 1.5 times the largest length of the zone so far over the contact radius, plus "
        "0.35 times the load of springs yet to relax over that of the edge, where the contact grew",
        SOURCES["schapery"],
        everywhere,
    )
    wide = np.maximum.accumulate(length / np.where(attached, a, 1.0))
    late = np.maximum.accumulate(np.where(speed < 0.0, missing, 0.0))
    errors = np.minimum(_LEAST + _PER_LENGTH * wide + _PER_LOAD * late, 1.0)
    claims = with_errors(dict.fromkeys(columns, claim), dict.fromkeys(columns, errors))
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
        "load of springs yet to relax over that of the edge, in rows in which it advances",
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
