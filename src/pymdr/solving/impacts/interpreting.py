"""Step 3 of an impact: its quantities, claims and assumptions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pymdr.deferred import xr
from pymdr.interpretation.validity import Assumption, BoolArray, Claim
from pymdr.problem.contact import Contact, is_curve
from pymdr.quantities import quantity
from pymdr.result import Result, labelled
from pymdr.solving.colliding import Course
from pymdr.solving.impacts.value import Event, Impact, ImpactRequest
from pymdr.units import FloatArray

QUASI_STATIC = (
    "the bodies pass through states of equilibrium: the contact time is assumed to be much longer than waves need to "
    "cross the bodies, and gravity is neglected"
)
NOT_MEASURED = "the contact time is not compared with the time of waves through the bodies, because bodies have no density"
TANGENTIAL = ("tangential_speed", "spin", "contact_point_speed", "tangential_restitution")
NORMAL = ("restitution", "contact_time", "rebound_speed", "energy_lost", "sticking_speed")
LARGEST = {
    "largest_force": "normal_force",
    "largest_indentation": "elastic_energy",
    "largest_radius": "contact_radius",
    "largest_pressure": "pressure",
}
HISTORY = {
    "time": "contact_time",
    "indentation": "largest_indentation",
    "velocity": "rebound_speed",
    "normal_force": "largest_force",
    "contact_radius": "largest_radius",
    "shift": "contact_point_speed",
    "tangential_velocity": "contact_point_speed",
    "tangential_force": "contact_point_speed",
    "stick_radius": "contact_point_speed",
}
"""Columns of the history, and the number whose claim applies to them."""


def interpret(
    request: ImpactRequest,
    course: Course,
    solved: Result,
    source: str,
    balance: Assumption,
    events: tuple[Event, ...],
) -> Impact:
    """Step 3: quantities, claims and assumptions."""
    energy = 0.5 * request.mass * request.normal**2
    restitution = 0.0 if course.sticks else math.sqrt(max(1.0 - course.jump_loss / energy, 0.0))
    listed = tuple(a for a in solved.assumptions if a.name != balance.name)
    radius = request.radius or 0.0
    columns = {
        "time": course.time,
        "indentation": course.depth,
        "velocity": course.velocity,
        "normal_force": course.force,
        "contact_radius": course.radius,
    }
    numbers = {
        "restitution": restitution,
        "contact_time": math.inf if course.sticks else float(course.time[-1]),
        "rebound_speed": restitution * request.normal,
        "largest_force": float(course.force.max()),
        "largest_indentation": float(course.depth[course.deepest]),
        "largest_radius": math.nan if is_curve(request.contact) else float(course.radius.max()),
        "largest_pressure": math.nan
        if not solved.claims["pressure"].readable
        else float(solved["peak_pressure"].values[0]),
        "energy_lost": energy if course.sticks else course.jump_loss,
        "sticking_speed": math.sqrt(2.0 * max(course.jump_loss, 0.0) / request.mass),
        "tangential_speed": request.tangential,
        "spin": request.spin,
        "contact_point_speed": request.tangential + radius * request.spin,
        "tangential_restitution": -1.0 if request.contact_point != 0.0 else math.nan,
    }
    step = np.arange(course.time.size)
    impact = Impact(
        contact=request.contact,
        data=labelled(columns).assign_coords(step=("step", step, {"units": ""})),
        events=events,
        claims=_claims(solved, source),
        assumptions=(*listed, balance),
        notes=(*(solved.notes if request.contact.adhesion is None else ()), NOT_MEASURED),
    )
    return with_numbers(impact, numbers)


_UNITS = {"largest_force": "N", "largest_indentation": "m", "largest_radius": "m", "largest_pressure": "Pa"}


def with_numbers(
    impact: Impact, numbers: Mapping[str, float], columns: Mapping[str, FloatArray] | None = None
) -> Impact:
    """An impact with updated numbers, and more columns of its history."""
    units = {name: _UNITS[name] if name in _UNITS else quantity(name).unit for name in numbers}
    single = {name: ((), value, {"units": units[name]}) for name, value in numbers.items()}
    data = impact.data.assign(single)
    return replace(impact, data=data if columns is None else data.merge(labelled(columns)))


def of_shape(contact: Contact, data: xr.Dataset) -> xr.Dataset:
    """Data without radii if a contact is known by its force curve only."""
    return data.drop_vars(["contact_radius", "stick_radius"], errors="ignore") if is_curve(contact) else data


def with_history(impact: Impact) -> Impact:
    """An impact with claims of its history, relative to the largest values of the impact."""
    rows = np.ones(impact.data.sizes["step"], dtype=bool)
    claims = dict(impact.claims)
    for name, own in HISTORY.items():
        if name in impact.data:
            claims[name] = _over(claims[own], rows)
    if "dissipated_energy" in impact.data:
        for name in ("dissipated_energy", "elastic_energy"):
            if name in impact.data:
                claims[name] = _over(claims.get(name, claims["energy_lost"]), rows)
    return replace(impact, claims=claims)


def _over(claim: Claim, rows: BoolArray) -> Claim:
    """The claim of a single number over rows."""
    error = None if claim.error is None else np.full(rows.shape, float(np.max(claim.error)))
    reason = f"{claim.reason}; errors are relative to the largest value of the impact"
    return replace(claim, where=rows & claim.where.all(), error=error, reason=reason)


def slow(claim: Claim, source: str) -> Claim:
    """A claim of states of equilibrium, with the assumption of slow motion."""
    return replace(claim, reason=f"{claim.reason}; {QUASI_STATIC}", source=f"{claim.source}; {source}")


def _claims(solved: Result, source: str) -> dict[str, Claim]:
    """The claims of the deepest state, with the assumption of slow motion."""

    def single(claim: Claim) -> Claim:
        error = None if claim.error is None else np.max(claim.error, keepdims=True)
        return slow(replace(claim, error=error, where=claim.where[:1]), source)

    force = single(solved.claims["normal_force"])
    return {
        **dict.fromkeys((*NORMAL, *TANGENTIAL), force),
        **{name: single(solved.claims[own]) for name, own in LARGEST.items()},
    }
