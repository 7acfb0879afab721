"""Impacts: what a mass that meets a contact does until it leaves again."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pymdr.errors import ProblemError, QuantityError
from pymdr.interpretation.adhesion import energy_assumption
from pymdr.interpretation.traction import curves_down_to
from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.line.foundation import normal_force, states_at_depth
from pymdr.line.friction import Sideways, evaluate, follow_collision
from pymdr.line.impact import Along, Potential, at_many, depths_of_energy, elastic_potential, work
from pymdr.problem.contact import Contact
from pymdr.problem.paths import indent
from pymdr.quantities import quantity
from pymdr.result import Result, labelled
from pymdr.rows import taken
from pymdr.solving.closure import is_curve
from pymdr.solving.colliding import Course, bounce, collide, contact_times, motion, stopping_depths
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.reach import Mapped, map_to_line
from pymdr.solving.verb import solve
from pymdr.units import (
    ArrayQuantityLike,
    FloatArray,
    QuantityLike,
    from_si,
    shown,
    to_si,
    to_si_array,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_QUASI_STATIC = (
    "the bodies pass through states of equilibrium: the contact time is assumed to be well above that which waves take to "
    "cross them, and gravity is left out"
)


class Event(NamedTuple):
    """What happens in an impact."""

    name: str
    """``"touch"``, ``"jump into contact"``, ``"turning point"``, ``"separation"`` or ``"rest"``."""
    time: float
    """In s since the first touch."""
    indentation: float
    """In m."""


@dataclass(frozen=True)
class Impact:
    """An impact from the first touch to the last, or to the first rest of bodies that stick."""

    contact: Contact
    """What meets."""
    data: xr.Dataset
    """Over ``step``: time, indentation, velocity (above 0 on the approach), normal_force and contact_radius; with friction
    also shift, tangential_velocity, tangential_force, stick_radius and dissipated_energy."""
    restitution: float
    """Normal speed after the impact over that before it; 0 of bodies that stick."""
    contact_time: float
    """In s; inf of bodies that stick."""
    rebound_speed: float
    """Normal speed after the impact in m/s."""
    largest_force: float
    """In N."""
    largest_indentation: float
    """In m."""
    largest_radius: float
    """Of the contact in m; nan of a force curve."""
    largest_pressure: float
    """In Pa at the turning point; inf under a sharp tip or edge, nan of a force curve."""
    energy_lost: float
    """Of the motion in J; all of it where the bodies stick."""
    sticking_speed: float
    """Normal speed in m/s below which the energy that adhesion takes keeps the bodies together; 0 without adhesion."""
    tangential_speed: float
    """Tangential speed of the centre after the impact in m/s."""
    spin: float
    """In rad/s after the impact."""
    contact_point_speed: float
    """Tangential speed v + R omega of the contact point after the impact in m/s."""
    tangential_restitution: float
    """Less the ratio of the contact point's tangential speeds after and before; nan without such a speed."""
    events: tuple[Event, ...]
    """What happens, in order."""
    claims: Mapping[str, Claim]
    """How far every quantity can be trusted."""
    assumptions: tuple[Assumption, ...]
    """Conditions of the model, measured."""
    notes: tuple[str, ...] = ()
    """What was said on the way."""

    def __getitem__(self, name: str) -> xr.DataArray:
        if name not in self.data.variables:
            known = ", ".join(map(str, self.data.variables))
            raise QuantityError(f"no history {shown(name)}; an impact has {known}")
        return self.data[name]

    def summary(self) -> str:
        """The numbers with units, what happens, and how far to trust them."""
        from pymdr.presentation.text import impact_summary

        return impact_summary(self.groups(), self.events, self.claims, self.assumptions, self.notes)

    def groups(self) -> dict[str, dict[str, float]]:
        """The numbers in SI units under headings, by the names of their quantities."""
        groups = {
            "impact": {
                "restitution": self.restitution,
                "contact_time": self.contact_time,
                "rebound_speed": self.rebound_speed,
                "energy_lost": self.energy_lost,
            },
            "largest": {
                "indentation": self.largest_indentation,
                "normal_force": self.largest_force,
                **({} if is_curve(self.contact) else self._of_area),
            },
        }
        if self.contact.adhesion is not None:
            groups["adhesion"] = {"sticking_speed": self.sticking_speed}
        if "shift" in self.data or self.tangential_speed != 0.0 or self.spin != 0.0:
            groups["sideways"] = {
                "tangential_speed": self.tangential_speed,
                "spin": self.spin,
                "contact_point_speed": self.contact_point_speed,
                "tangential_restitution": self.tangential_restitution,
            }
        return groups

    @property
    def _of_area(self) -> dict[str, float]:
        return {"contact_radius": self.largest_radius, "peak_pressure": self.largest_pressure}

    def __str__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        """The numbers, claims and assumptions as tables, for notebooks."""
        from pymdr.presentation.html import impact_html

        return impact_html(self.groups(), self.events, self.claims, self.assumptions, self.notes)

    def plot(self) -> Figure:
        """Force and radius against time, and force against indentation; with friction the tangential force."""
        from pymdr.presentation.plot import impact_figure

        mu = None if self.contact.friction is None else self.contact.friction.coefficient
        return impact_figure(self.data, mu)

    def to_csv(self, file: str | os.PathLike[str], *, units: Mapping[str, str] | None = None) -> None:
        """
        Write the history to a CSV file, one row per step, with units in the names of the columns.

        Parameters
        ----------
        file : path
            For example "impact.csv".
        units : mapping of str to str, optional
            Name of a quantity -> unit; SI units unless given.
        """
        from pymdr.presentation.files import write_table

        columns: dict[str, np.ndarray] = {"step": np.arange(self.data.sizes["step"])}
        for name in map(str, self.data):
            own = quantity(name).unit
            unit = (units or {}).get(name, own)
            columns[f"{name} [{unit}]"] = np.asarray(from_si(self.data[name].values, own, unit))
        write_table(columns, file)


def impact(
    contact: Contact,
    *,
    mass: QuantityLike,
    speed: QuantityLike,
    angle: QuantityLike = 0.0,
    inertia: QuantityLike | None = None,
    radius: QuantityLike | None = None,
    spin: QuantityLike = 0.0,
    steps: int = 200,
) -> Impact:
    """
    The impact of two bodies, by states of equilibrium.

    The normal motion is m d'' = -F(d). Without adhesion the bodies are deepest where U(d) = m v^2 / 2, and part with the
    speed with which they met after T = 2 int dd / sqrt(v^2 - 2 U(d) / m). Adhesion takes the energy W that is lost where
    the contact jumps under a prescribed indentation, e = sqrt(1 - 2 W / (m v^2)). With friction the contact point moves
    sideways by m_x u_x'' = -F_x, 1 / m_x = 1 / m + R^2 / I, where F_x remembers the whole history; the normal motion does
    not depend on it.

    Parameters
    ----------
    contact : Contact
        Profile, materials and laws.
    mass : quantity
        Reduced mass 1 / (1/m_1 + 1/m_2) in kg: that of the body where the other one is fixed.
    speed : quantity
        Speed at the first touch in m/s, above 0.
    angle : quantity, optional
        Angle of the velocity from the normal in rad, at least 0 and below pi/2, such as "30 deg".
    inertia : quantity, optional
        Moment of inertia I in kg m^2 about the centre, for friction; of a solid ball, 2/5 m R^2, unless given. It has to
        be given for other profiles than a sphere or a paraboloid.
    radius : quantity, optional
        Distance R in m from the centre to the contact point, for friction and spin; the radius of the ball unless given.
    spin : quantity, optional
        Angular velocity in rad/s, above 0 where it moves the contact point on in the direction of its tangential speed.
    steps : int
        Moves of the history, a multiple of 4.

    Returns
    -------
    Impact

    Raises
    ------
    ProblemError
        If a value is not above 0, the contact is not a disk on the way, or friction needs an inertia or a radius.
    PathError
        If the profile ends before the bodies come to rest.

    Notes
    -----
    Hertz (1882) for spheres; Thornton and Ning (1998) with adhesion; Maw, Barber and Fawcett (1976) with friction.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = Contact(Paraboloid("10 mm"), Elastic("210 GPa", 0.3))
    >>> hit = impact(ball, mass="33 g", speed="1 m/s")
    >>> round(hit.contact_time * 1 / hit.largest_indentation, 6)
    2.943275
    """
    asked = _read(contact, mass, speed, angle, inertia, radius, spin, steps)
    if contact.adhesion is not None:
        return _adhesive(asked)
    found = _elastic(asked)
    return replace(found, data=_of_shape(contact, found.data))


def _of_shape(contact: Contact, data: xr.Dataset) -> xr.Dataset:
    """Without radii where a contact is known by its force curve only."""
    return data.drop_vars(["contact_radius", "stick_radius"], errors="ignore") if is_curve(contact) else data


@dataclass(frozen=True)
class _Asked:
    """An impact in SI units."""

    contact: Contact
    mass: float
    normal: float
    """Normal speed in m/s."""
    sideways: float
    """Tangential speed of the centre in m/s."""
    spin: float
    radius: float | None
    inertia: float | None
    steps: int

    @property
    def contact_point(self) -> float:
        """Tangential speed of the contact point in m/s."""
        return self.sideways + (self.radius or 0.0) * self.spin


def _above(value: QuantityLike, unit: str, name: str, who: str = "impact") -> float:
    number = to_si(value, unit, name=name)
    if not 0.0 < number < math.inf:
        raise ProblemError(f"{who}: {name} = {shown(value)}; it must be above 0 {unit} and finite")
    return number


def _read(
    contact: Contact,
    mass: QuantityLike,
    speed: QuantityLike,
    angle: QuantityLike,
    inertia: QuantityLike | None,
    radius: QuantityLike | None,
    spin: QuantityLike,
    steps: int,
) -> _Asked:
    if not isinstance(contact, Contact):
        raise ProblemError(f"impact: {contact!r} is not a Contact; write Contact(profile, body)")
    m, v = _above(mass, "kg", "mass"), _above(speed, "m/s", "speed")
    tilt = to_si(angle, "rad", name="angle")
    if not 0.0 <= tilt < 0.5 * math.pi:
        raise ProblemError(
            f"impact: angle = {shown(angle)}; the angle from the normal must be at least 0 and below 90 deg (a plain number is "
            "in rad): at 90 deg the bodies do not meet"
        )
    if not isinstance(steps, int | np.integer) or isinstance(steps, bool) or steps < 8 or steps % 4:
        raise ProblemError(f"impact: steps = {steps!r}; a multiple of 4 is needed, at least 8")
    turning = to_si(spin, "rad/s", name="spin")
    ball = contact.profile.curvature_radius if _is_ball(contact) else None
    arm = ball if radius is None else _above(radius, "m", "radius")
    gyration = None if inertia is None else _above(inertia, "kg*m^2", "inertia")
    if gyration is None and ball is not None and (radius is None or arm == ball):
        gyration = 0.4 * m * ball * ball
    if arm is None and turning != 0.0:
        raise ProblemError(
            "impact: spin needs the distance from the centre to the contact point; give radius='10 mm'"
        )
    mu = 0.0 if contact.friction is None else contact.friction.coefficient
    if not math.isfinite(mu):
        raise ProblemError(
            f"impact: mu = {mu:g}; the coefficient of friction must be finite, for example Coulomb(1)"
        )
    slides = mu > 0.0
    if slides and (tilt > 0.0 or turning != 0.0) and (arm is None or gyration is None):
        raise ProblemError(
            f"impact: with friction a {type(contact.profile).__name__} needs the moment of inertia about its centre and the "
            "distance to the contact point; give inertia='4e-7 kg*m^2' and radius='10 mm' (only spheres and paraboloids of "
            "their own radius are taken for solid balls)"
        )
    normal, sideways = v * math.cos(tilt), v * math.sin(tilt)
    return _Asked(contact, m, normal, sideways, turning, arm, gyration, int(steps))


def _is_ball(contact: Contact) -> bool:
    from pymdr.problem.profiles import Paraboloid, Sphere

    return type(contact.profile) in (Sphere, Paraboloid)


def _columns(course: Course) -> dict[str, FloatArray]:
    return {
        "time": course.time,
        "indentation": course.depth,
        "velocity": course.velocity,
        "normal_force": course.force,
        "contact_radius": course.radius,
    }


def _elastic(asked: _Asked) -> Impact:
    contact = asked.contact
    mapped = map_to_line(contact)
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
    told = _told(asked, course, solved, SOURCES["hertz"], balance, events)
    friction = contact.friction
    if friction is None or friction.coefficient == 0.0 or asked.contact_point == 0.0:
        return told
    return _rubbed(asked, told, mapped, solved.claims["tangential_force"], friction.coefficient)


_SETTLED = 1e-8
"""Of the speed of the contact point: what halving the steps of a motion sideways may change."""
_MOST = 200_000


def _rubbed(asked: _Asked, normal: Impact, mapped: Mapped, claim: Claim, mu: float) -> Impact:
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
        "kinetic energy that the contact point loses less the work of friction, over what it had,",
        abs(kept - lost) / (0.5 * mass * before * before),
        1e-6,
    )
    reason = (
        f"{claim.reason}; {_QUASI_STATIC}; the motion is followed in {parts * asked.steps} steps, whose last halving changed "
        f"the speed by {change:.1g} of that before the impact"
    )
    sideways = replace(
        claim,
        level=Level.APPROXIMATE,
        reason=reason,
        source=f"{claim.source}; {SOURCES['maw']}",
        where=claim.where[:1],
        error=np.array([change + (0.0 if claim.error is None else float(np.max(claim.error)))]),
    )
    columns = {
        "shift": slid.shift,
        "tangential_velocity": slid.velocity,
        "tangential_force": slid.tangential_force,
        "stick_radius": np.minimum(slid.stick_radius, normal.data["contact_radius"].values),
        "dissipated_energy": slid.slip_work,
    }
    return replace(
        normal,
        data=normal.data.merge(labelled(columns)),
        energy_lost=lost,
        tangential_speed=asked.sideways - impulse / asked.mass,
        spin=asked.spin - arm * (impulse / asked.inertia),
        contact_point_speed=after,
        tangential_restitution=-after / before,
        claims={**normal.claims, **dict.fromkeys((*_SIDEWAYS, "energy_lost"), sideways)},
        assumptions=(*normal.assumptions, balance),
    )


def _adhesive(asked: _Asked) -> Impact:
    contact = asked.contact
    line = AdhesiveLine(contact)
    course = collide(line, asked.mass, asked.normal, asked.steps)
    deepest = float(course.depth[course.deepest])
    last = float(course.depth[-1])
    # a little farther, where it has parted
    back = last if course.sticks else last - 1e-3 * (deepest - last)
    solved = solve(contact, indent(deepest) >> indent(back))
    if not solved.claims["normal_force"].where.all():
        raise ProblemError(
            f"impact: the contact is not a disk on the way: {solved.claims['normal_force'].reason}"
        )
    balance = next(a for a in solved.assumptions if a.name == "energy balance")
    events = [Event("touch", 0.0, float(course.depth[0]))]
    if course.jumps_in:
        events.append(Event("jump into contact", 0.0, float(course.depth[1])))
    events.append(Event("turning point", float(course.time[course.deepest]), deepest))
    events.append(Event("rest" if course.sticks else "separation", float(course.time[-1]), last))
    return _told(asked, course, solved, SOURCES["thornton-ning"], balance, tuple(events))


def _told(
    asked: _Asked,
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


_SIDEWAYS = ("tangential_speed", "spin", "contact_point_speed", "tangential_restitution")
_NORMAL = ("restitution", "contact_time", "rebound_speed", "energy_lost", "sticking_speed")
_LARGEST = {
    "largest_force": "normal_force",
    "largest_indentation": "elastic_energy",
    "largest_radius": "contact_radius",
    "largest_pressure": "pressure",
}


def _claims(solved: Result, source: str) -> dict[str, Claim]:
    """Those of the deepest state, under the assumption that the motion is slow."""

    def slow(claim: Claim) -> Claim:
        reason = f"{claim.reason}; {_QUASI_STATIC}"
        error = None if claim.error is None else np.max(claim.error, keepdims=True)
        return replace(
            claim, reason=reason, source=f"{claim.source}; {source}", error=error, where=claim.where[:1]
        )

    force = slow(solved.claims["normal_force"])
    return {
        **dict.fromkeys((*_NORMAL, *_SIDEWAYS), force),
        **{name: slow(solved.claims[own]) for name, own in _LARGEST.items()},
    }


_RESTITUTION = ("restitution", "contact_time", "indentation", "normal_force", "contact_radius")


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
    m = _above(mass, "kg", "mass", "restitution")
    v = np.atleast_1d(to_si_array(speeds, "m/s", name="speeds"))
    if v.ndim != 1 or v.size == 0 or not np.all((v > 0.0) & np.isfinite(v)):
        raise ProblemError(
            f"restitution: speeds = {shown(speeds)}; one row of finite speeds above 0 m/s is needed"
        )
    columns = _many_elastic(contact, m, v) if contact.adhesion is None else _many_adhesive(contact, m, v)
    variables = {
        name: ("speed", values, {"units": quantity(name).unit, "long_name": quantity(name).words})
        for name, values in zip(_RESTITUTION, columns, strict=True)
    }
    speed = ("speed", v, {"units": "m/s", "long_name": "normal speed before the impact"})
    return _of_shape(contact, xr.Dataset(variables, coords={"speed": speed}))


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
        found = np.empty((len(_RESTITUTION), speeds.size))
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

    columns = np.empty((len(_RESTITUTION), speed.size))
    columns[:2, ~parts] = [[0.0], [math.inf]]
    if parts.any():
        columns[0, parts] = rebound / speed[parts]
        columns[1:, parts] = np.exp(at_many(parting, np.log(rebound), np.zeros(0), 1e-10))
    if not parts.all():
        columns[2:, ~parts] = np.exp(at_many(sticking, np.log(speed[~parts]), np.zeros(0), 1e-10))
    return list(columns)
