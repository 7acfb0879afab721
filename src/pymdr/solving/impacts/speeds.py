"""Many impacts of one contact."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from pymdr.errors import ProblemError
from pymdr.line.foundation import normal_force, states_at_depth
from pymdr.line.impact import at_many, depths_of_energy
from pymdr.line.rebound import Motion, largest_force, rebound
from pymdr.problem.contact import Contact
from pymdr.problem.values import within_range
from pymdr.quantities import quantity
from pymdr.solving.colliding import collide, contact_times, stopping_depths
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.impacts.asking import above, coefficient_of
from pymdr.solving.impacts.telling import of_shape
from pymdr.solving.reach import map_to_springs
from pymdr.solving.rebounding import followed, motion_at
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, shown, to_si_array

if TYPE_CHECKING:
    import xarray as xr

COLUMNS = ("restitution", "contact_time", "indentation", "normal_force", "contact_radius")


def restitution(contact: Contact, *, mass: QuantityLike, speeds: ArrayQuantityLike) -> xr.Dataset:
    """
    Restitution and contact time of many normal impacts of one contact, on one curve.

    Friction changes nothing in them, and is not asked for.

    Parameters
    ----------
    contact : Contact
    mass : quantity
        Reduced mass in kg.
    speeds : array_like or quantity
        Normal speeds in m/s, above 0.

    Returns
    -------
    xarray.Dataset
        Over ``speed`` (m/s): restitution, contact_time (s; inf of bodies that stick), and the largest indentation (m),
        normal_force (N) and contact_radius (m). With memory its attribute ``error`` is the largest relative error, measured
        by halving the steps at three of the speeds, and between the nodes of the series through all of them.

    Raises
    ------
    ProblemError, PathError
        As :func:`impact` does.

    Examples
    --------
    >>> from pymdr.problem.laws import JKR
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Paraboloid
    >>> gel = Contact(Paraboloid("1 mm"), Elastic("30 kPa", 0.5), adhesion=JKR("50 mJ/m^2"))
    >>> restitution(gel, mass="1 mg", speeds=[0.05, 0.1, 0.5])["restitution"].values.round(4).tolist()
    [0.0, 0.4207, 0.9834]
    """
    import xarray as xr

    if not isinstance(contact, Contact):
        raise ProblemError(f"restitution: {contact!r} is not a Contact; write Contact(profile, body)")
    m = above(mass, "kg", "mass", "restitution")
    v = np.atleast_1d(to_si_array(speeds, "m/s", name="speeds"))
    if v.ndim != 1 or v.size == 0 or not np.all((v > 0.0) & np.isfinite(v)):
        raise ProblemError(
            f"restitution: speeds = {shown(speeds)}; one row of finite speeds above 0 m/s is needed"
        )
    for extreme in (v.min(), v.max()):
        within_range(extreme, "m/s", "restitution: speeds", size=True)
    coefficient_of(contact, "restitution")
    attributes = {}
    if contact.remembers:
        columns, attributes["error"] = _many_remembering(contact, m, v)
    elif contact.adhesion is None:
        columns = _many_elastic(contact, m, v)
    else:
        columns = _many_adhesive(contact, m, v)
    variables = {
        name: ("speed", values, {"units": quantity(name).unit, "long_name": quantity(name).words})
        for name, values in zip(COLUMNS, columns, strict=True)
    }
    speed = ("speed", v, {"units": "m/s", "long_name": "normal speed before the impact"})
    return of_shape(contact, xr.Dataset(variables, coords={"speed": speed}, attrs=attributes))


def _many_elastic(contact: Contact, mass: float, speed: FloatArray) -> list[FloatArray]:
    line = map_to_springs(contact).line
    potential, _, largest = stopping_depths(contact, line, mass, np.array([speed.max()]))

    def followed(logarithm: FloatArray) -> FloatArray:
        energy = 0.5 * mass * np.minimum(np.exp(logarithm), speed.max()) ** 2
        half, deepest = (depths_of_energy(potential, e, float(largest[0])) for e in (0.5 * energy, energy))
        return np.log([contact_times(potential, mass, half, deepest), deepest])

    knots = potential.along(np.array(potential.knots)).energy
    time, deepest = np.exp(at_many(followed, np.log(speed), 0.5 * np.log(2.0 * knots / mass)))
    states = states_at_depth(line, deepest)
    return [np.ones(speed.size), time, deepest, normal_force(line, states), states.contact_radius]


def _many_adhesive(contact: Contact, mass: float, speed: FloatArray) -> list[FloatArray]:
    line = AdhesiveLine(contact)

    def followed(speeds: FloatArray) -> FloatArray:
        found = np.empty((len(COLUMNS), speeds.size))
        # the fastest first: it needs most of the curve
        for i in np.argsort(-speeds):
            course = collide(line, mass, float(speeds[i]), 8)
            share = course.lost / (0.5 * mass * speeds[i] ** 2)
            found[:, i] = (
                0.0 if course.sticks else math.sqrt(max(1.0 - share, 0.0)),
                math.inf if course.sticks else course.time[-1],
                course.depth[course.deepest],
                course.force.max(),
                course.radius.max(),
            )
        return found

    fastest = collide(line, mass, float(speed.max()), 8)
    slowest = math.sqrt(2.0 * fastest.lost / mass)
    parts = speed > slowest
    if fastest.branches > 1:
        return list(followed(speed))
    # the rebound speed is what the contact time depends on smoothly
    rebound = np.sqrt((speed[parts] - slowest) * (speed[parts] + slowest))

    def parting(logarithm: FloatArray) -> FloatArray:
        return np.log(followed(np.hypot(np.exp(logarithm), slowest))[1:])

    def sticking(logarithm: FloatArray) -> FloatArray:
        return np.log(followed(np.exp(logarithm))[2:])

    columns = np.empty((len(COLUMNS), speed.size))
    columns[:2, ~parts] = [[0.0], [math.inf]]
    if parts.any():
        columns[0, parts] = rebound / speed[parts]
        columns[1:, parts] = np.exp(at_many(parting, np.log(rebound), np.zeros(0), 1e-10))
    if not parts.all():
        columns[2:, ~parts] = np.exp(at_many(sticking, np.log(speed[~parts]), np.zeros(0), 1e-10))
    return list(columns)


_BETWEEN = 1e-9
"""Of the logarithms of what an impact with memory is known by: what its series may err between its nodes."""
_NOTHING = 1e-300
"""Restitution, and the inverse of the contact time in s, of bodies that come to rest: their logarithms are numbers."""


def _many_remembering(contact: Contact, mass: float, speed: FloatArray) -> tuple[list[FloatArray], float]:
    ground, fastest = followed(contact, mass, (float(speed.min()), float(speed.max())))
    line = ground.line

    def numbers(motion: Motion) -> FloatArray:
        e = motion.rebound_speed / float(motion.steps[0, 3])
        time = min(motion.contact_time, 1.0 / _NOTHING)
        return np.log([max(e, _NOTHING), time, motion.deepest, largest_force(motion)[1]])

    def at(logarithm: float) -> Motion:
        return motion_at(ground, mass, min(math.exp(logarithm), float(speed.max())))

    def followed_at(logarithm: FloatArray) -> FloatArray:
        return np.stack([numbers(at(each)) for each in logarithm], axis=1)

    inner = [line.depth(np.array([b]))[0] for b in line.breakpoints if b < line.reach]
    marks = [_speed_at(at, float(np.log(speed.min())), float(np.log(speed.max())), d) for d in inner]
    marks = [mark for mark in marks if mark is not None]
    e, time, deepest, force = np.exp(at_many(followed_at, np.log(speed), np.array(marks), _BETWEEN))
    rests = e <= 2.0 * _NOTHING
    error = _BETWEEN
    for motion in (fastest, at(float(np.log(np.median(speed)))), at(float(np.log(speed.min())))):
        own = float(motion.steps[0, 3])
        halved = rebound(ground.curves, ground.relaxation, mass, own, ground.first / own, halved=motion)
        if halved is not None and not motion.rests:
            error = max(error, float(np.max(np.abs(numbers(halved) - numbers(motion)))))
    columns = [
        np.where(rests, 0.0, e),
        np.where(rests, math.inf, time),
        deepest,
        force,
        states_at_depth(line, deepest).contact_radius,
    ]
    return columns, error + ground.relaxation.error


def _speed_at(at: Callable[[float], Motion], low: float, high: float, depth: float) -> float | None:
    """The logarithm of the speed at which a mass goes as deep as a kink, between two others; None if it is beyond them."""
    if not at(low).deepest < depth < at(high).deepest:
        return None
    return float(brentq(lambda s: math.log(at(s).deepest / depth), low, high, xtol=1e-12, rtol=1e-12))
