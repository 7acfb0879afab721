"""The frictionless contact without adhesion along a path."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymdr.errors import PathError
from pymdr.interpretation.accuracy import normal_errors, with_errors
from pymdr.interpretation.certificate import (
    certify_disk,
    describe_ranges,
    noise_words,
    valid_ranges,
)
from pymdr.interpretation.fields import edge_amplitude
from pymdr.interpretation.validity import BoolArray, Claim, normal_claims
from pymdr.line.foundation import (
    DiskStates,
    ElasticLine,
    elastic_energy,
    joined_states,
    mean_pressure,
    normal_force,
    normal_stiffness,
    states_at_depth,
    states_at_force,
    states_at_travel,
)
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath, named_channels
from pymdr.problem.schedule import (
    Controls,
    Progress,
    channel_values,
    known_legs,
    stretch,
    times,
    total_rows,
)
from pymdr.result import Result, Status, labelled
from pymdr.solving.reach import Mapped, assumptions, g_samples, map_remark, map_to_line, refuse_unreachable
from pymdr.units import FloatArray, newtons


@dataclass(frozen=True)
class NormalHistory:
    """The states of every row, and the force where it is prescribed, else nan."""

    mapped: Mapped
    states: DiskStates
    prescribed: FloatArray


def check_normal_path(path: LoadingPath) -> None:
    """Refuse what a contact without friction and adhesion cannot follow."""
    for leg in known_legs(path):
        sideways = [name for name in named_channels(leg) if name in ("shift", "tangential_force")]
        if sideways:
            raise PathError(
                f"the path prescribes {sideways[0]}, but the contact has no friction: add "
                "Contact(..., friction=Coulomb(0.3))"
            )
    for force in channel_values(path, "normal_force"):
        refuse_tension(force)


def refuse_tension(force: FloatArray) -> None:
    """Refuse negative forces."""
    if np.min(force) < 0.0:
        raise PathError(
            f"normal_force = {newtons(float(np.min(force)))}: without adhesion the force cannot be below 0 N; "
            "unload to 0 N, or lift off with indent(...)"
        )


def solve_normal(
    contact: Contact, path: LoadingPath, machine_stiffness: float | None, progress: Progress | None
) -> Result:
    """Map, solve and interpret."""
    check_normal_path(path)
    history = follow_normal(contact, map_to_line(contact), path, machine_stiffness, progress)
    return interpret_normal(contact, path, history, machine_stiffness)


def follow_normal(
    contact: Contact,
    mapped: Mapped,
    path: LoadingPath,
    machine_stiffness: float | None = None,
    progress: Progress | None = None,
) -> NormalHistory:
    """Step 2: the states of every row, leg by leg."""
    rows: list[DiskStates] = []
    forced: list[FloatArray] = []
    controls = Controls()
    here = {"indentation": 0.0, "normal_force": 0.0, "travel": 0.0}
    total = total_rows(path)
    done = 0
    for leg in known_legs(path):
        leg_rows = stretch(leg, controls, here)
        controls, targets = leg_rows.controls, leg_rows.normal
        if leg_rows.by_force:
            refuse_tension(targets)
        states = _states(mapped.line, controls.normal, targets, machine_stiffness)
        refuse_unreachable(
            mapped.line, contact.profile, states, float(np.max(targets)) if leg_rows.by_force else None
        )
        rows.append(states)
        forced.append(targets if leg_rows.by_force else np.full(targets.size, math.nan))
        here = _end(mapped.line, states, machine_stiffness)
        here[controls.normal] = float(targets[-1])
        done += targets.size
        if progress is not None:
            progress(done, total)
    return NormalHistory(mapped, joined_states(rows), np.concatenate(forced))


def _states(
    line: ElasticLine, channel: str, targets: FloatArray, machine_stiffness: float | None
) -> DiskStates:
    if channel == "normal_force":
        return states_at_force(line, targets)
    if channel == "travel" and machine_stiffness is not None and math.isfinite(machine_stiffness):
        return states_at_travel(line, targets, machine_stiffness)
    return states_at_depth(line, targets)


def _end(line: ElasticLine, states: DiskStates, machine_stiffness: float | None) -> dict[str, float]:
    last = states.take(slice(-1, None))
    d, force = float(last.indentation[0]), float(normal_force(line, last)[0])
    return {"indentation": d, "normal_force": force, "travel": d + force / (machine_stiffness or math.inf)}


def interpret_normal(
    contact: Contact, path: LoadingPath, history: NormalHistory, machine_stiffness: float | None
) -> Result:
    """Step 3: quantities, claims and assumptions of every row."""
    mapped, states, prescribed = history.mapped, history.states, history.prescribed
    line = mapped.line
    by_force = np.isfinite(prescribed)
    force = np.where(by_force, prescribed, normal_force(line, states))
    claims, disk = claims_of(contact, history)
    columns: dict[str, FloatArray] = {
        "indentation": states.indentation,
        "normal_force": force,
        "contact_radius": states.contact_radius,
        "normal_stiffness": normal_stiffness(line, states),
        "mean_pressure": mean_pressure(force, states.contact_radius),
        "elastic_energy": elastic_energy(line, states),
        "force_lower_bound": force,
    }
    if math.isfinite(line.edge) and line.exponent == 0.0:
        columns["edge_amplitude"] = edge_amplitude(line, states.contact_radius, states.edge_excess)
    if machine_stiffness is not None:
        columns["travel"] = states.indentation + force / machine_stiffness
        claims["travel"] = claims["normal_force"]
    time = times(path)
    valid = {
        name: values if claims[name].where.all() else np.where(claims[name].where, values, math.nan)
        for name, values in columns.items()
        if claims[name].readable
    }
    if time is not None:
        valid = {"time": time, **valid}
    return Result(
        contact=contact,
        path=path,
        data=labelled(valid),
        claims=claims,
        assumptions=assumptions(contact, mapped, states.contact_radius),
        status=normal_status(disk),
        notes=mapped.notes,
        machine_stiffness=machine_stiffness,
        references=("sneddon", "popov-hess", *(() if disk.all() else ("barber",))),
    )


def normal_status(disk: BoolArray) -> Status:
    """How a solution ends whose rows are a disk or not."""
    return Status.COMPLETED if disk.all() else Status.PARTLY_REFUSED if disk.any() else Status.REFUSED


def claims_of(contact: Contact, history: NormalHistory) -> tuple[dict[str, Claim], BoolArray]:
    """The claims of every quantity, and whether every row is a disk."""
    line, states = history.mapped.line, history.states
    by_force = np.isfinite(history.prescribed)
    certificate = certify_disk(line, states)
    claims = normal_claims(
        certificate.disk,
        certificate.reason,
        _range_words(contact, line, states, certificate.disk),
        {"indentation": ~by_force, "normal_force": by_force},
        certificate.remark,
    )
    errors = normal_errors(line, states, by_force)
    if certificate.error is not None:
        passed = certificate.error
        errors = {name: errors.get(name, np.zeros(passed.shape)) + passed for name in claims}
    claims = with_errors(claims, errors, map_remark(line, states))
    if not (math.isfinite(line.edge) and line.exponent == 0.0):
        del claims["edge_amplitude"]
    return claims, certificate.disk


def _range_words(contact: Contact, line: ElasticLine, states: DiskStates, disk: BoolArray) -> str:
    """For which loads the contact is a disk, if it is not for all, and what may be done about it."""
    if disk.all():
        return ""
    deepest = float(np.max(states.indentation))
    remedy = noise_words(contact.profile, line.equivalent, deepest)
    if math.isfinite(line.equivalent.edge):
        deepest = max(4.0 * deepest, 4.0 * float(np.max(np.abs(g_samples(line)))))
    ranges = valid_ranges(line, deepest)
    top = normal_force(line, states_at_depth(line, np.array([deepest])))
    return remedy + describe_ranges(ranges, float(top[0]))
