"""Step 3 of an impact: its quantities, claims and assumptions."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from pymdr.interpretation.validity import Assumption, Claim
from pymdr.problem.contact import Contact
from pymdr.result import Result, labelled
from pymdr.solving.closure import is_curve
from pymdr.solving.colliding import Course
from pymdr.solving.impacts.asking import Asked
from pymdr.solving.impacts.value import Event, Impact
from pymdr.units import FloatArray

if TYPE_CHECKING:
    import xarray as xr

QUASI_STATIC = (
    "the bodies pass through states of equilibrium: the contact time is assumed to be well above that which waves take to "
    "cross them, and gravity is left out"
)


def _columns(course: Course) -> dict[str, FloatArray]:
    return {
        "time": course.time,
        "indentation": course.depth,
        "velocity": course.velocity,
        "normal_force": course.force,
        "contact_radius": course.radius,
    }


def told(
    asked: Asked,
    course: Course,
    solved: Result,
    source: str,
    balance: Assumption,
    events: tuple[Event, ...],
) -> Impact:
    """Step 3: quantities, claims and assumptions."""
    energy = 0.5 * asked.mass * asked.normal**2
    restitution = 0.0 if course.sticks else math.sqrt(max(1.0 - course.lost / energy, 0.0))
    listed = tuple(a for a in solved.assumptions if a.name != balance.name)
    radius = asked.radius or 0.0
    return Impact(
        contact=asked.contact,
        data=labelled(_columns(course)),
        restitution=restitution,
        contact_time=math.inf if course.sticks else float(course.time[-1]),
        rebound_speed=restitution * asked.normal,
        largest_force=float(course.force.max()),
        largest_indentation=float(course.depth[course.deepest]),
        largest_radius=math.nan if is_curve(asked.contact) else float(course.radius.max()),
        largest_pressure=math.nan if is_curve(asked.contact) else float(solved["peak_pressure"].values[0]),
        energy_lost=energy if course.sticks else course.lost,
        sticking_speed=math.sqrt(2.0 * max(course.lost, 0.0) / asked.mass),
        tangential_speed=asked.sideways,
        spin=asked.spin,
        contact_point_speed=asked.sideways + radius * asked.spin,
        tangential_restitution=-1.0 if asked.contact_point != 0.0 else math.nan,
        events=events,
        claims=_claims(solved, source),
        assumptions=(*listed, balance),
        notes=solved.notes if asked.contact.adhesion is None else (),
    )


def of_shape(contact: Contact, data: xr.Dataset) -> xr.Dataset:
    """Without radii where a contact is known by its force curve only."""
    return data.drop_vars(["contact_radius", "stick_radius"], errors="ignore") if is_curve(contact) else data


SIDEWAYS = ("tangential_speed", "spin", "contact_point_speed", "tangential_restitution")
NORMAL = ("restitution", "contact_time", "rebound_speed", "energy_lost", "sticking_speed")
LARGEST = {
    "largest_force": "normal_force",
    "largest_indentation": "elastic_energy",
    "largest_radius": "contact_radius",
    "largest_pressure": "pressure",
}


def _claims(solved: Result, source: str) -> dict[str, Claim]:
    """Those of the deepest state, under the assumption that the motion is slow."""

    def slow(claim: Claim) -> Claim:
        reason = f"{claim.reason}; {QUASI_STATIC}"
        error = None if claim.error is None else np.max(claim.error, keepdims=True)
        return replace(
            claim, reason=reason, source=f"{claim.source}; {source}", error=error, where=claim.where[:1]
        )

    force = slow(solved.claims["normal_force"])
    return {
        **dict.fromkeys((*NORMAL, *SIDEWAYS), force),
        **{name: slow(solved.claims[own]) for name, own in LARGEST.items()},
    }
