"""Impacts with adhesion."""

from __future__ import annotations

from pymdr.errors import RefusedError
from pymdr.interpretation.validity import SOURCES
from pymdr.problem.paths import indent
from pymdr.solving.colliding import collide
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.impacts.interpreting import interpret
from pymdr.solving.impacts.request import ImpactRequest
from pymdr.solving.impacts.value import Event, Impact
from pymdr.solving.verb import solve


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
            f"impact: the contact is not a disk throughout the impact: {solved.claims['normal_force'].reason}"
        )
    balance = next(a for a in solved.assumptions if a.name == "energy balance")
    events = [Event("touch", 0.0, float(course.depth[0]))]
    if course.jumps_in:
        events.append(Event("jump into contact", 0.0, float(course.depth[1])))
    events.append(Event("turning point", float(course.time[course.deepest]), deepest))
    events.append(Event("rest" if course.sticks else "separation", float(course.time[-1]), last))
    return interpret(request, course, solved, SOURCES["thornton-ning"], balance, tuple(events))
