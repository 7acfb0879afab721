"""Impacts of balls that yield: the loading dissipates, and the rebound is elastic."""

from __future__ import annotations

import math

import numpy as np

from pymdr.errors import PathError, ProblemError
from pymdr.interpretation.adhesion import energy_assumption
from pymdr.interpretation.validity import SOURCES
from pymdr.line.impact import Along, Potential, depths_of_energy, move, stop, work
from pymdr.line.plastic import DEEPEST, Ball
from pymdr.problem.contact import Contact
from pymdr.problem.paths import indent
from pymdr.solving.colliding import Course, contact_times
from pymdr.solving.impacts.interpreting import interpret, with_numbers
from pymdr.solving.impacts.request import ImpactRequest
from pymdr.solving.impacts.value import Event, Impact
from pymdr.solving.plastic import ball_of
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, metres, written


def plastic(request: ImpactRequest) -> Impact:
    """The impact of a ball: it yields up to the turning point and rebounds elastically."""
    contact, mass, rows = request.contact, request.mass, request.steps
    ball = impacting(contact, "impact")
    energy = 0.5 * mass * request.normal**2
    loading, largest = loading_to(ball, mass, np.array([request.normal]))
    deepest = float(largest[0])
    into = _passage(loading, mass, energy, deepest, rows)
    rebound = unloading_from(ball, deepest)
    start = float(ball.residual(np.array(deepest)))
    returned = float(ball.elastic_energy(np.array(deepest), np.array(deepest)))
    back = _passage(rebound, mass, returned, deepest - start, rows)
    time = np.append(into[0], into[0][-1] + back[0][-1] - back[0][-2::-1])
    depth = np.append(into[1], start + back[1][-2::-1])
    m = np.full(depth.shape, deepest)
    m[: into[1].size] = into[1]
    course = Course(
        time,
        depth,
        np.append(into[2], -back[2][-2::-1]),
        ball.force(depth, m),
        ball.contact_radius(depth, m),
        jump_loss=float(ball.dissipation(np.array(deepest))),
        deepest=rows // 2,
    )
    marks = np.unique(np.concatenate([into[1], loading.knots]))
    balance = energy_assumption(abs(work(loading, marks[marks <= deepest]) / energy - 1.0))
    events = (
        Event("touch", 0.0, 0.0),
        Event("turning point", float(time[course.deepest]), deepest),
        Event("separation", float(time[-1]), start),
    )
    result = interpret(request, course, solve(contact, indent(deepest)), SOURCES["johnson"], balance, events)
    return with_numbers(result, {"sticking_speed": 0.0})


def impacting(contact: Contact, prefix: str) -> Ball:
    """
    The ball of an impact.

    Raises
    ------
    ProblemError
        If it adheres, or its radius grows with the rows.
    """
    body = contact.plastic
    assert body is not None
    if contact.adhesion is not None:
        raise ProblemError(
            f"{prefix}: adhesion of a body that yields is not available in impacts; leave it out"
        )
    if body.apparent_radius:
        raise ProblemError(
            f"{prefix}: apparent_radius needs the steps of a particle code, and an impact has none; leave it out"
        )
    return ball_of(contact)


def loading_to(ball: Ball, mass: float, speed: FloatArray) -> tuple[Potential, FloatArray]:
    """
    The work of loading over the indentation, and the largest indentations in m at some speeds in m/s.

    Raises
    ------
    PathError
        If the model ends before the ball comes to rest.
    """
    top = DEEPEST * ball.radius

    def at(d: FloatArray) -> Along:
        return Along(d, np.ones(d.shape), ball.loading_force(d), ball.loading_work(d))

    most = float(ball.loading_work(np.array(top)))
    if 0.5 * mass * float(np.max(speed)) ** 2 > most:
        raise PathError(
            f"speed = {written(float(np.max(speed)), 'm/s', 6)}: the ball would not come to rest before the model of its yield ends at "
            f"d = {metres(top)}; the largest normal speed is {written(math.sqrt(2.0 * most / mass), 'm/s', 6)}"
        )
    knots = (ball.yield_depth,) if ball.yield_depth < top else ()
    potential = Potential(at, knots)
    return potential, depths_of_energy(potential, 0.5 * mass * speed**2, top)


def unloading_from(ball: Ball, largest: float) -> Potential:
    """The energy that unloading returns, over the indentation above the residual one in m."""
    m = np.array(largest)
    start = float(ball.residual(m))

    def at(s: FloatArray) -> Along:
        d = start + s
        return Along(s, np.ones(s.shape), ball.force(d, m), ball.elastic_energy(d, m))

    return Potential(at)


def contact_time(ball: Ball, loading: Potential, mass: float, largest: float) -> float:
    """The contact time in s of an impact to a largest indentation in m."""
    length = largest - float(ball.residual(np.array(largest)))
    total = 0.0
    for potential, end in ((loading, largest), (unloading_from(ball, largest), length)):
        deepest = np.array([end])
        half = depths_of_energy(potential, 0.5 * potential.along(deepest).energy, end)
        total += 0.5 * float(contact_times(potential, mass, half, deepest)[0])
    return total


def _passage(
    potential: Potential, mass: float, energy: float, deepest: float, rows: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Time in s, parameter in m and speed in m/s from 0 to the state of rest."""
    fractions = np.linspace(0.0, 1.0, rows // 4 + 1)
    half = float(depths_of_energy(potential, np.array([0.5 * energy]), deepest)[0])
    into = move(potential, mass, energy, 0.0, half, fractions)
    rest = stop(potential, mass, energy, half, deepest, fractions)
    return (
        np.append(into.time, into.time[-1] + rest.time[1:]),
        np.append(into.parameter, rest.parameter[1:]),
        np.append(into.speed, rest.speed[1:]),
    )
