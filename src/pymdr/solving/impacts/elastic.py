"""Impacts of elastic bodies, with adhesion, or with friction in the tangential direction."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pymdr.errors import RefusedError
from pymdr.interpretation.adhesion import energy_assumption
from pymdr.interpretation.traction import curves_down_to
from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.line.friction import TangentialMotion, evaluate, follow_collision
from pymdr.line.impact import Along, Potential, depths_of_energy, elastic_potential, work
from pymdr.problem.paths import indent
from pymdr.rows import taken
from pymdr.solving.colliding import bounce, collide, motion
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.impacts.interpreting import QUASI_STATIC, TANGENTIAL, interpret, with_numbers
from pymdr.solving.impacts.value import Event, Impact, ImpactRequest
from pymdr.solving.mapped import Springs, map_to_springs
from pymdr.solving.verb import solve
from pymdr.units import FloatArray


def elastic(request: ImpactRequest) -> Impact:
    """A lossless normal impact; with friction also the tangential motion."""
    contact = request.contact
    mapped = map_to_springs(contact)
    course = bounce(contact, mapped, request.mass, request.normal, request.steps)
    deepest = float(course.depth[course.deepest])
    solved = solve(contact, indent(deepest))
    energy = 0.5 * request.mass * request.normal**2
    potential = elastic_potential(mapped.line, deepest)
    marks = np.unique(np.concatenate([course.depth[: course.deepest + 1], potential.knots]))
    balance = energy_assumption(abs(work(potential, marks) / energy - 1.0))
    events = (
        Event("touch", 0.0, 0.0),
        Event("turning point", float(course.time[course.deepest]), deepest),
        Event("separation", float(course.time[-1]), 0.0),
    )
    result = interpret(request, course, solved, SOURCES["hertz"], balance, events)
    friction = contact.friction
    if friction is None or friction.coefficient == 0.0 or request.contact_point == 0.0:
        return result
    return _rubbed(request, result, mapped, solved.claims["tangential_force"], friction.coefficient)


_SETTLED = 1e-8
"""Tolerance of the halving of steps of a tangential motion, relative to the speed of the contact point."""
_MOST = 200_000


def _rubbed(request: ImpactRequest, normal: Impact, mapped: Springs, claim: Claim, mu: float) -> Impact:
    """The impact with the tangential motion of the contact point, in steps that are halved until convergence."""
    assert request.radius is not None
    assert request.inertia is not None
    arm, before = request.radius, request.contact_point
    mass = 1.0 / (1.0 / request.mass + arm * (arm / request.inertia))
    deepest = normal.largest_indentation
    curves = curves_down_to(mapped.line, deepest)

    def at(d: FloatArray) -> Along:
        _, force, energy = evaluate(curves, d)
        return Along(d, np.ones(d.shape), force, energy)

    table = Potential(at, elastic_potential(mapped.line, deepest).knots)
    energy = np.array([0.25 * request.mass * request.normal**2])
    depths = (float(depths_of_energy(table, energy, deepest)[0]), deepest)

    def run(parts: int) -> TangentialMotion:
        time, depth, _ = motion(table, request.mass, request.normal, depths, parts * request.steps)
        followed = follow_collision(curves, depth, time, mass, before, mu, mapped.moduli.tangential)
        return taken(followed, slice(None, None, parts))

    parts, slid, change = 1, run(1), math.inf
    while change > _SETTLED and 2 * parts * request.steps <= _MOST:
        finer = run(2 * parts)
        change = float(np.max(np.abs(finer.velocity - slid.velocity))) / abs(before)
        parts, slid = 2 * parts, finer
    after = float(slid.velocity[-1])
    impulse = mass * (before - after)
    slip_work = float(slid.slip_work[-1])
    kept = 0.5 * mass * (before - after) * (before + after)
    balance = Assumption(
        "tangential energy balance",
        "relative residual; kinetic energy lost at the contact point minus work of friction",
        abs(kept - slip_work) / (0.5 * mass * before * before),
        1e-6,
    )
    reason = (
        f"{claim.reason}; {QUASI_STATIC}; {parts * request.steps} steps, whose last halving changed the speed by {change:.1g} "
        "of that before the impact"
    )
    tangential = replace(
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
        "energy_lost": slip_work,
        "tangential_speed": request.tangential - impulse / request.mass,
        "spin": request.spin - arm * (impulse / request.inertia),
        "contact_point_speed": after,
        "tangential_restitution": -after / before,
    }
    return replace(
        with_numbers(normal, numbers, columns),
        claims={**normal.claims, **dict.fromkeys((*TANGENTIAL, "energy_lost"), tangential)},
        assumptions=(*normal.assumptions, balance),
    )


def adhesive(request: ImpactRequest) -> Impact:
    """An impact along the stable branches of the adhesive contact, with jumps between them."""
    contact = request.contact
    line = AdhesiveLine(contact)
    course = collide(line, request.mass, request.normal, request.steps)
    deepest = float(course.depth[course.deepest])
    last = float(course.depth[-1])
    # slightly beyond separation
    back = last if course.sticks else last - 1e-3 * (deepest - last)
    solved = solve(contact, indent(deepest) >> indent(back))
    if not solved.claims["normal_force"].where.all():
        raise RefusedError(
            f"the contact is not a disk throughout the impact: {solved.claims['normal_force'].reason}"
        )
    balance = next(a for a in solved.assumptions if a.name == "energy balance")
    events = [Event("touch", 0.0, float(course.depth[0]))]
    if course.jumps_in:
        events.append(Event("jump into contact", 0.0, float(course.depth[1])))
    events.append(Event("turning point", float(course.time[course.deepest]), deepest))
    events.append(Event("rest" if course.sticks else "separation", float(course.time[-1]), last))
    return interpret(request, course, solved, SOURCES["thornton-ning"], balance, tuple(events))
