"""Step 3 of a motion: its quantities, claims and assumptions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.line.motion import Followed, System
from pymdr.problem.contact import Contact
from pymdr.problem.machines import Machine
from pymdr.quantities import quantity
from pymdr.solving.closure import is_curve
from pymdr.solving.machines.assembling import ordered
from pymdr.solving.machines.value import ENERGIES, Motion, residual_of
from pymdr.solving.stepping import Stepper
from pymdr.units import FloatArray, metres, written

QUASI_STATIC = "contacts pass through states of equilibrium: times are assumed to be above a few transits of waves through the contact"
_JOINTS = ("indentation", "shift", "normal_force", "tangential_force", "contact_radius", "stick_radius")
_FRICTION = ("shift", "tangential_force", "stick_radius", "stored_tangential_energy", "dissipated_energy")
_SOURCES = ("gonzalez", "popov-hess")


class Run(NamedTuple):
    """A motion, and the same with steps twice as long."""

    fine: Followed
    coarse: Followed
    time: FloatArray
    """Of the rows in s."""
    change: float
    """Largest change of the positions by the last halving, relative to the way of each body."""


def interpret(machine: Machine, system: System, run: Run) -> Motion:
    """Step 3: quantities, claims and assumptions."""
    import xarray as xr

    values, before = (_quantities(machine, system, followed, run.time) for followed in (run.fine, run.coarse))
    dims = {2: ("step", "body"), 1: ("step",)}
    free, drives = ordered(machine)
    variables = {
        name: (("step", "joint") if name in _JOINTS else dims[array.ndim], array, _attributes(name))
        for name, array in values.items()
    }
    coords = {
        "time": ("step", run.time, _attributes("time")),
        "body": ("body", [body.name for body in (*free, *drives)]),
    }
    if machine.joints:
        coords["joint"] = ("joint", [joint.name for joint in machine.joints])
    balance = Assumption(
        "energy balance",
        "relative residual; change of energies and dissipation minus work of drives and forces",
        residual_of({name: values.get(name, np.zeros(run.time.size)) for name in ENERGIES}),
        1e-9,
    )
    return Motion(
        machine=machine,
        data=xr.Dataset(variables, coords=coords, attrs={"steps": run.fine.steps}),
        claims=_claims(machine, run, values, before),
        assumptions=(balance,),
        notes=_notes(system, run),
        references=_SOURCES,
    )


def _attributes(name: str) -> dict[str, str]:
    q = quantity(name)
    return {"units": q.unit, "long_name": q.long_name, "symbol": q.symbol}


def _quantities(
    machine: Machine, system: System, followed: Followed, time: FloatArray
) -> dict[str, FloatArray]:
    """Quantities by name; without friction those of the shift are left out, without joints those of contacts."""
    moved = np.empty((time.size, system.course.shape[0]))
    moved[:] = system.course[:, 1]
    for i, amplitude, angular, phase in system.drive_waves:
        moved[:, int(i)] += amplitude * angular * np.cos(angular * time + phase)
    values = {"position": followed.position, "velocity": np.column_stack([followed.velocity, moved])}
    if machine.joints:
        values |= {name: followed.joints[:, :, i] for i, name in enumerate(_JOINTS)}
    values |= {name: followed.energies[:, i] for i, name in enumerate(ENERGIES)}
    slips = bool(np.any(system.joints.friction[:, None] * system.joints.tangential))
    unknown = {name for name in _FRICTION if not slips}
    if any(is_curve(joint.contact) for joint in machine.joints):
        unknown |= {"contact_radius", "stick_radius"}
    if not machine.joints:
        unknown.add("elastic_energy")
    return {name: array for name, array in values.items() if name not in unknown}


def _claims(
    machine: Machine, run: Run, values: Mapping[str, FloatArray], before: Mapping[str, FloatArray]
) -> dict[str, Claim]:
    """The claims of the contacts at their deepest, with the errors of the integration."""
    of_contacts = [_claims_of(contact, depth) for contact, depth in _deepest(machine, run.fine).items()]
    everywhere = np.ones(run.time.size, dtype=bool)
    claims = {}
    for name, array in values.items():
        own = [_claim_for(name, claims_of) for claims_of in of_contacts]
        reason = "; ".join(dict.fromkeys([*(claim.reason for claim in own), QUASI_STATIC]))
        source = "; ".join(dict.fromkeys([*(claim.source for claim in own), SOURCES["gonzalez"]]))
        level = max((claim.level for claim in own), key=list(Level).index, default=Level.EXACT)
        errors = [math.nan if claim.error is None else float(np.max(claim.error)) for claim in own]
        known = not any(map(math.isnan, errors))
        error = max(errors, default=0.0) + _changes(array, before[name]) if known else None
        counted = (
            f"{run.fine.steps} steps; errors by halving them, relative to the largest value of the motion"
        )
        claims[name] = Claim(level, f"{reason}; {counted}", source, everywhere, error)
    return claims


def _claim_for(name: str, claims: Mapping[str, Claim]) -> Claim:
    """The claim of a quantity of a contact; of any other that of its forces."""
    return claims.get(name) or claims.get("tangential_force") or claims["normal_force"]


def _deepest(machine: Machine, followed: Followed) -> dict[Contact, float]:
    """The largest indentation in m of every contact that touched."""
    deepest: dict[Contact, float] = {}
    for joint, depth in zip(machine.joints, followed.joints[:, :, 0].max(axis=0), strict=True):
        if depth > 0.0:
            deepest[joint.contact] = max(float(depth), deepest.get(joint.contact, 0.0))
    return deepest


def _claims_of(contact: Contact, deepest: float) -> Mapping[str, Claim]:
    return Stepper(contact, deepest).claims


def _changes(fine: FloatArray, coarse: FloatArray) -> FloatArray:
    """Largest change of every row by the last halving so far, relative to the largest value of the motion."""
    fine, coarse = fine.reshape(len(fine), -1), coarse.reshape(len(coarse), -1)
    size = np.abs(fine).max(axis=0)
    change = np.abs(fine - coarse) / np.where(size > 0.0, size, 1.0)
    return np.asarray(np.maximum.accumulate(change.max(axis=1)))


def fastest(system: System, followed: Followed) -> float:
    """The largest angular frequency in rad/s of a coordinate on its springs and contacts, or of a wave."""
    n = system.mass.size
    stiffness = (system.springs[:, :1] * system.springs[:, 3:] ** 2).sum(axis=0)
    if len(system.joints.curves):
        radius = followed.joints[:, :, 4].max(axis=0)
        modulus = np.array([curves.modulus for curves in system.joints.curves])
        across = system.joints.tangential**2 / system.joints.modulus_ratio[:, None]
        squares = system.joints.normal**2 + across * (system.joints.friction[:, None] > 0.0)
        stiffness = stiffness + (2.0 * modulus * radius)[:, None].T @ squares
    waves = [float(wave[2]) for wave in (*system.force_waves, *system.drive_waves)]
    return max(float(np.sqrt(np.max(stiffness.ravel()[:n] / system.mass))), *waves, 0.0)


def _notes(system: System, run: Run) -> tuple[str, ...]:
    """The time that has to be compared with that of waves: bodies have no density here."""
    if not len(system.joints.curves):
        return ()
    period, width = 2.0 * math.pi / fastest(system, run.fine), 2.0 * float(run.fine.joints[:, :, 4].max())
    if width == 0.0:
        return ("the bodies never touched",)
    return (
        f"the shortest period is {written(period, 's', 3)}: waves are assumed to cross the widest contact, 2a = {metres(width)}, in "
        "much less; bodies have no density here",
    )
