"""Impacts of balls that yield: the loading dissipates, and the rebound is elastic."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import scipy

from pymdr.errors import PathError
from pymdr.interpretation.adhesion import energy_assumption
from pymdr.interpretation.validity import SOURCES
from pymdr.line.impact import (
    Along,
    Potential,
    depths_of_energy,
    move,
    parameter_of_energy,
    stop,
    work,
)
from pymdr.line.plastic import DEEPEST, Ball, Parting, parting_from, with_growth
from pymdr.problem.contact import Contact
from pymdr.problem.paths import indent
from pymdr.solving.colliding import Course, contact_times
from pymdr.solving.impacts.interpreting import interpret, with_numbers
from pymdr.solving.impacts.value import Event, Impact, ImpactRequest
from pymdr.solving.plastic import ball_of
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, metres, written

_DECADES = 12
"""Of largest indentations below the end of the model, among which that of the sticking speed is sought."""


def plastic(request: ImpactRequest) -> Impact:
    """The impact of a ball: it yields up to the turning point and rebounds elastically, or against adhesion."""
    contact, mass, rows = request.contact, request.mass, request.steps
    ball = impacting(contact)
    energy = 0.5 * mass * request.normal**2
    loading, largest = loading_to(ball, mass, np.array([request.normal]))
    deepest = float(largest[0])
    into = _passage(loading, mass, energy, deepest, rows)
    back = (
        _returned(ball, mass, deepest, rows)
        if contact.adhesion is None
        else parted(parting_from(ball, contact.adhesion.work, deepest), mass, rows)
    )
    m = into[1]
    course = Course(
        np.append(into[0], into[0][-1] + back.time),
        np.append(into[1], back.depth),
        np.append(into[2], back.velocity),
        np.append(ball.force(m, m), back.force),
        np.append(ball.contact_radius(m, m), back.radius),
        sticks=back.sticks,
        jump_loss=float(ball.dissipation(np.array(deepest))) + back.loss,
        deepest=into[1].size - 1,
    )
    marks = np.unique(np.concatenate([into[1], loading.knots]))
    balance = energy_assumption(abs(work(loading, marks[marks <= deepest]) / energy - 1.0))
    events = (
        Event("touch", 0.0, 0.0),
        Event("turning point", float(course.time[course.deepest]), deepest),
        Event("rest" if back.sticks else "separation", float(course.time[-1]), float(course.depth[-1])),
    )
    result = interpret(request, course, solve(contact, indent(deepest)), SOURCES["johnson"], balance, events)
    slowest = 0.0
    if contact.adhesion is not None:
        slowest = sticking_speed(ball, contact.adhesion.work, mass, loading)
    return with_numbers(result, {"sticking_speed": slowest})


def impacting(contact: Contact) -> Ball:
    """The ball of an impact; its apparent radius, if it grows, grows as in many steps."""
    body, ball = contact.plastic, ball_of(contact)
    assert body is not None
    return with_growth(ball) if body.apparent_radius else ball


def loading_to(ball: Ball, mass: float, speed: FloatArray) -> tuple[Potential, FloatArray]:
    """The work of loading over the indentation, and the largest indentations in m at some speeds in m/s."""
    top = DEEPEST * ball.radius

    def at(d: FloatArray) -> Along:
        return Along(d, np.ones(d.shape), ball.loading_force(d), ball.loading_work(d))

    most = float(ball.loading_work(np.array(top)))
    if 0.5 * mass * float(np.max(speed)) ** 2 > most:
        raise PathError(
            f"speed = {written(float(np.max(speed)), 'm/s', 6)}: the ball would not come to rest before the model of its yield ends at "
            f"d = {metres(top)}; the largest normal speed is {written(math.sqrt(2.0 * most / mass), 'm/s', 6)}"
        )
    potential = Potential(at, ball.knots)
    return potential, depths_of_energy(potential, 0.5 * mass * speed**2, top)


def unloading_from(ball: Ball, largest: float) -> Potential:
    """The energy that unloading returns, over the indentation above the residual one in m."""
    m = np.array(largest)
    start, scale, line = float(ball.residual(m)), float(ball.scale(m)), ball.line(m)

    def at(s: FloatArray) -> Along:
        d, within = start + s, s / scale
        energy = ball.elastic_energy(d, m) if ball.walled else scale * line.energy(within)
        return Along(s, np.ones(s.shape), line.force(within) * ball.wall(d), energy)

    return Potential(at)


def contact_times_to(ball: Ball, loading: Potential, mass: float, largest: FloatArray) -> FloatArray:
    """The contact times in s of impacts to largest indentations in m."""

    def half_times(potential: Potential, deepest: FloatArray) -> FloatArray:
        half = depths_of_energy(potential, 0.5 * potential.along(deepest).energy, float(deepest.max()))
        return 0.5 * contact_times(potential, mass, half, deepest)

    back = [
        half_times(unloading_from(ball, most), np.array([length]))[0]
        for most, length in zip(largest.tolist(), (largest - ball.residual(largest)).tolist(), strict=True)
    ]
    return np.asarray(half_times(loading, largest) + np.array(back))


class Back(NamedTuple):
    """Rows after the turning point; times in s count from it."""

    time: FloatArray
    depth: FloatArray
    velocity: FloatArray
    force: FloatArray
    radius: FloatArray
    loss: float = 0.0
    """Energy in J lost by the edge and in the separation, even if the bodies stick."""
    sticks: bool = False


def _returned(ball: Ball, mass: float, deepest: float, rows: int) -> Back:
    """The rebound without adhesion, as a loading that runs back."""
    m = np.array(deepest)
    start, returned = float(ball.residual(m)), float(ball.elastic_energy(m, m))
    time, length, speed = _passage(unloading_from(ball, deepest), mass, returned, deepest - start, rows)
    depth = start + length[-2::-1]
    force, radius = ball.force(depth, m), ball.contact_radius(depth, m)
    return Back(time[-1] - time[-2::-1], depth, -speed[-2::-1], force, radius)


def parted(parting: Parting, mass: float, rows: int) -> Back:
    """The rebound against adhesion, to separation or to rest on the way."""
    low, top = parting.separation, parting.largest

    def at(d: FloatArray) -> Along:
        states = parting.states(d)
        return Along(d, np.ones(d.shape), states.force, states.elastic_energy + states.dissipated)

    potential = Potential(at, (parting.receding,))
    energies = potential.along(np.array([low, top])).energy
    last, total = (float(each) for each in energies)
    bottom = float(
        scipy.optimize.brentq(
            lambda d: float(potential.along(np.array([d])).force[0]), low, top, xtol=1e-15 * top, rtol=1e-14
        )
    )
    least = float(potential.along(np.array([bottom])).energy[0])
    fractions = np.linspace(0.0, 1.0, max(rows // 6, 2) + 1)
    begin = parameter_of_energy(potential, 0.5 * (total + least), bottom, top)
    away = stop(potential, mass, total, begin, top, fractions)
    time, depth, speed = away.time[-1] - away.time[::-1], away.parameter[::-1], away.speed[::-1]
    parts = [(time[1:], depth[1:], speed[1:])]
    sticks = total <= last
    end, middle = low, low
    if sticks:
        end = parameter_of_energy(potential, total, low, bottom)
        middle = parameter_of_energy(potential, 0.5 * (total + least), end, bottom)
    on = move(potential, mass, total, begin, middle, fractions)
    parts.append((time[-1] + on.time[1:], on.parameter[1:], on.speed[1:]))
    if sticks:
        rest = stop(potential, mass, total, middle, end, fractions)
        parts.append((parts[-1][0][-1] + rest.time[1:], rest.parameter[1:], rest.speed[1:]))
    time, depth, speed = (np.concatenate(column) for column in zip(*parts, strict=True))
    states = parting.states(depth)
    force, radius = states.force, states.contact_radius
    if not sticks:  # a row after the jump to separation
        time, depth, speed = (np.append(column, column[-1]) for column in (time, depth, speed))
        force, radius = np.append(force, 0.0), np.append(radius, 0.0)
    return Back(time, depth, -speed, force, radius, last, sticks)


def sticking_speed(ball: Ball, work: float, mass: float, loading: Potential) -> float:
    """The first speed in m/s below which the bodies stick, though they may above another; inf if they stick at every speed of the model."""

    def surplus(logarithm: float) -> float:
        parting = parting_from(ball, work, math.exp(logarithm))
        ends = parting.states(np.array([parting.separation, parting.largest]))
        last, total = (ends.elastic_energy + ends.dissipated).tolist()
        return float((total - last) / (total + last))

    top = math.log(DEEPEST * ball.radius)
    marks = np.linspace(top - _DECADES * math.log(10.0), top, 8 * _DECADES + 1)
    values = np.array([surplus(mark) for mark in marks.tolist()])
    parts = np.flatnonzero(values > 0.0)
    if not parts.size:
        return math.inf
    first = int(parts[0])
    if first == 0:
        return 0.0
    root = float(scipy.optimize.brentq(surplus, marks[first - 1], marks[first], xtol=1e-13))
    return math.sqrt(2.0 * float(loading.along(np.array([math.exp(root)])).energy[0]) / mass)


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
