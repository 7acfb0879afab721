"""Many impacts of one contact."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pymdr.errors import ProblemError
from pymdr.line.foundation import normal_force, states_at_depth
from pymdr.line.impact import at_many, depths_of_energy
from pymdr.problem.contact import Contact
from pymdr.quantities import quantity
from pymdr.solving.colliding import collide, contact_times, stopping_depths
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.impacts.asking import above
from pymdr.solving.reach import map_to_line
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
        normal_force (N) and contact_radius (m).

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
    columns = _many_elastic(contact, m, v) if contact.adhesion is None else _many_adhesive(contact, m, v)
    variables = {
        name: ("speed", values, {"units": quantity(name).unit, "long_name": quantity(name).words})
        for name, values in zip(COLUMNS, columns, strict=True)
    }
    speed = ("speed", v, {"units": "m/s", "long_name": "normal speed before the impact"})
    return xr.Dataset(variables, coords={"speed": speed})


def _many_elastic(contact: Contact, mass: float, speed: FloatArray) -> list[FloatArray]:
    line = map_to_line(contact).line
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
