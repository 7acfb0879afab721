"""Impacts of elastic bodies, against friction sideways."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pymdr.interpretation.adhesion import energy_assumption
from pymdr.interpretation.traction import curves_down_to
from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.line.friction import Sideways, evaluate, follow_collision
from pymdr.line.impact import Along, Potential, depths_of_energy, elastic_potential, work
from pymdr.problem.paths import indent
from pymdr.rows import taken
from pymdr.solving.colliding import bounce, motion
from pymdr.solving.impacts.asking import Asked
from pymdr.solving.impacts.telling import QUASI_STATIC, SIDEWAYS, told, with_numbers
from pymdr.solving.impacts.value import Event, Impact
from pymdr.solving.reach import Springs, map_to_springs
from pymdr.solving.verb import solve
from pymdr.units import FloatArray


def elastic(asked: Asked) -> Impact:
    """Bodies that give back what they take; with friction the motion sideways besides."""
    contact = asked.contact
    mapped = map_to_springs(contact)
    course = bounce(contact, mapped, asked.mass, asked.normal, asked.steps)
    deepest = float(course.depth[course.deepest])
    solved = solve(contact, indent(deepest))
    energy = 0.5 * asked.mass * asked.normal**2
    potential = elastic_potential(mapped.line, deepest)
    marks = np.unique(np.concatenate([course.depth[: course.deepest + 1], potential.knots]))
    balance = energy_assumption(abs(work(potential, marks) / energy - 1.0))
    events = (
        Event("touch", 0.0, 0.0),
        Event("turning point", float(course.time[course.deepest]), deepest),
        Event("separation", float(course.time[-1]), 0.0),
    )
    found = told(asked, course, solved, SOURCES["hertz"], balance, events)
    friction = contact.friction
    if friction is None or friction.coefficient == 0.0 or asked.contact_point == 0.0:
        return found
    return _rubbed(asked, found, mapped, solved.claims["tangential_force"], friction.coefficient)


_SETTLED = 1e-8
"""Of the speed of the contact point: what halving the steps of a motion sideways may change."""
_MOST = 200_000


def _rubbed(asked: Asked, normal: Impact, mapped: Springs, claim: Claim, mu: float) -> Impact:
    """The impact with the motion of the contact point against friction, in steps that are halved until nothing changes."""
    assert asked.radius is not None
    assert asked.inertia is not None
    arm, before = asked.radius, asked.contact_point
    mass = 1.0 / (1.0 / asked.mass + arm * (arm / asked.inertia))
    deepest = normal.largest_indentation
    curves = curves_down_to(mapped.line, deepest)

    def at(d: FloatArray) -> Along:
        _, force, energy = evaluate(curves, d)
        return Along(d, np.ones(d.shape), force, energy)

    table = Potential(at, elastic_potential(mapped.line, deepest).knots)
    energy = np.array([0.25 * asked.mass * asked.normal**2])
    depths = (float(depths_of_energy(table, energy, deepest)[0]), deepest)

    def run(parts: int) -> Sideways:
        time, depth, _ = motion(table, asked.mass, asked.normal, depths, parts * asked.steps)
        found = follow_collision(curves, depth, time, mass, before, mu, mapped.moduli.tangential)
        return taken(found, slice(None, None, parts))

    parts, slid, change = 1, run(1), math.inf
    while change > _SETTLED and 2 * parts * asked.steps <= _MOST:
        finer = run(2 * parts)
        change = float(np.max(np.abs(finer.velocity - slid.velocity))) / abs(before)
        parts, slid = 2 * parts, finer
    after = float(slid.velocity[-1])
    impulse = mass * (before - after)
    lost = float(slid.slip_work[-1])
    kept = 0.5 * mass * (before - after) * (before + after)
    balance = Assumption(
        "energy balance sideways",
        "relative residual; kinetic energy lost at the contact point minus work of friction",
        abs(kept - lost) / (0.5 * mass * before * before),
        1e-6,
    )
    reason = (
        f"{claim.reason}; {QUASI_STATIC}; the motion is followed in {parts * asked.steps} steps, whose last halving changed "
        f"the speed by {change:.1g} of that before the impact"
    )
    sideways = replace(
        claim,
        level=Level.APPROXIMATE,
        reason=reason,
        source=f"{claim.source}; {SOURCES['maw']}",
        where=claim.where[:1],
        error=None if claim.error is None else np.array([change + float(np.max(claim.error))]),
    )
    columns = {
        "shift": slid.shift,
        "tangential_velocity": slid.velocity,
        "tangential_force": slid.tangential_force,
        "stick_radius": np.minimum(slid.stick_radius, normal.data["contact_radius"].values),
        "dissipated_energy": slid.slip_work,
    }
    numbers = {
        "energy_lost": lost,
        "tangential_speed": asked.sideways - impulse / asked.mass,
        "spin": asked.spin - arm * (impulse / asked.inertia),
        "contact_point_speed": after,
        "tangential_restitution": -after / before,
    }
    return replace(
        with_numbers(normal, numbers, columns),
        claims={**normal.claims, **dict.fromkeys((*SIDEWAYS, "energy_lost"), sideways)},
        assumptions=(*normal.assumptions, balance),
    )
