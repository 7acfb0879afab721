"""Many impacts of one contact."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
import scipy

from pymdr.deferred import xr
from pymdr.errors import ProblemError, RefusedError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.validity import SOURCES, Claim
from pymdr.line.foundation import normal_force, states_at_depth
from pymdr.line.impact import at_many, depths_of_energy
from pymdr.line.plastic import Ball, parting_from
from pymdr.line.rebound import Motion, largest_force, rebound
from pymdr.problem.contact import Contact, require_contact
from pymdr.problem.materials import Elastic, Rigid
from pymdr.problem.paths import LoadingPath, Path, indent
from pymdr.problem.values import within_range
from pymdr.quantities import quantity
from pymdr.result import Result
from pymdr.solving.colliding import Course, collide, contact_times, stopping_depths
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.impacts.interpreting import NOT_MEASURED, of_shape, slow
from pymdr.solving.impacts.plastic import contact_times_to, impacting, loading_to, parted
from pymdr.solving.impacts.value import Restitution, above, coefficient_of
from pymdr.solving.mapped import map_to_springs
from pymdr.solving.rebounding import followed, motion_at
from pymdr.solving.verb import solve
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, shown, to_si_array

_ALONG, _ADHESIVE = 1e-12, 1e-10
"""Tolerance of the logarithms in a series over the speed, without and with adhesion."""
COLUMNS = ("restitution", "contact_time", "indentation", "normal_force", "contact_radius")


def restitution(contact: Contact, *, mass: QuantityLike, speeds: ArrayQuantityLike) -> Restitution:
    """
    Restitution and contact time of many normal impacts of one contact, on one curve.

    Friction has no effect on them.

    Parameters
    ----------
    contact : Contact
        Profile, materials and laws.
    mass : quantity
        Reduced mass in kg.
    speeds : array_like or quantity
        Normal speeds in m/s, above 0.

    Returns
    -------
    Restitution
        Over ``speed`` (m/s): restitution, contact_time (s; inf for bodies that stick), and the largest indentation (m),
        normal_force (N) and contact_radius (m). The errors in its claims include those of the shape at the largest indentations,
        of the series over the speed and, with memory, of the steps, which are halved at three of the speeds.

    Raises
    ------
    ProblemError, PathError
        As :func:`impact` does.

    Examples
    --------
    >>> import pymdr as mdr
    >>> gel = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("30 kPa", 0.5), adhesion=mdr.JKR("50 mJ/m^2"))
    >>> mdr.restitution(gel, mass="1 mg", speeds=[0.05, 0.1, 0.5])["restitution"].values.round(4).tolist()
    [0.0, 0.4207, 0.9834]
    """
    require_contact(contact)
    m = above(mass, "kg", "mass")
    v = np.atleast_1d(to_si_array(speeds, "m/s", name="speeds"))
    if v.ndim != 1 or v.size == 0 or not np.all((v > 0.0) & np.isfinite(v)):
        raise ProblemError(f"speeds = {shown(speeds)}; one row of finite speeds above 0 m/s is needed")
    for extreme in (v.min(), v.max()):
        within_range(extreme, "m/s", "speeds", size=True)
    coefficient_of(contact)
    many = _many_elastic if contact.adhesion is None else _many_adhesive
    if contact.plastic is not None:
        many = _many_plastic
    impacts = (_many_remembering if contact.is_viscoelastic else many)(contact, m, v)
    variables = {
        name: ("speed", values, {"units": quantity(name).unit, "long_name": quantity(name).long_name})
        for name, values in zip(COLUMNS, impacts.columns, strict=True)
    }
    speed = ("speed", v, {"units": "m/s", "long_name": "normal speed before the impact"})
    claims, solved = _claims(contact, impacts)
    similar = "elastic similarity" if contact.is_viscoelastic else ""
    return Restitution(
        data=of_shape(contact, xr.Dataset(variables, coords={"speed": speed}, attrs={"mass": m})),
        claims=claims,
        assumptions=tuple(a for a in solved.assumptions if a.name not in (similar, "energy balance")),
        notes=(*(solved.notes if contact.adhesion is None else ()), NOT_MEASURED),
        contact=contact,
    )


class _Many(NamedTuple):
    """Results of many impacts."""

    columns: list[FloatArray]
    """By the order of COLUMNS."""
    error: float
    """Relative error of the series over the speed and of the steps of the motion."""
    source: str
    parting: float | None = None
    """With adhesion: the indentation in m at which the bodies separate at the highest speed, if they do."""


_OWN = {"indentation": "elastic_energy", "normal_force": "normal_force", "contact_radius": "contact_radius"}
"""The quantities of a static contact whose claims apply to an impact; the others use that of the force."""


def _claims(contact: Contact, many: _Many) -> tuple[dict[str, Claim], Result]:
    """The claims of the static contact at the largest indentation of every speed, and that result."""
    depth = many.columns[2]
    levels, which = np.unique(depth, return_inverse=True)
    static = replace(contact, friction=None)
    if contact.is_viscoelastic:
        # of the shape alone: the error of the motion includes the relaxation
        static = Contact(contact.profile, Elastic(1.0, 0.5), Rigid())
    path: LoadingPath = Path(indentation=levels)
    if many.parting is not None:
        # slightly beyond separation
        path = path >> indent(many.parting - 1e-3 * (float(levels[-1]) - many.parting))
    solved = solve(static, path)
    rows = solved.claims["normal_force"].where
    if not rows.all():
        raise RefusedError(
            f"the contact is not a disk throughout the impact: {solved.claims['normal_force'].reason}"
        )

    def at_speeds(claim: Claim) -> Claim:
        pressing, pulling = np.split(
            np.zeros(rows.size) if claim.error is None else claim.error, [levels.size]
        )
        error = np.maximum(pressing, np.max(pulling, initial=0.0))[which]
        own_claim = replace(
            claim, where=claim.where[: levels.size][which], error=None if claim.error is None else error
        )
        if contact.is_viscoelastic:
            own_claim = replace(
                own_claim, reason=own_claim.reason.replace("elastic half-spaces", "viscoelastic half-spaces")
            )
        return slow(own_claim, many.source)

    own = {name: at_speeds(solved.claims[_OWN.get(name, "normal_force")]) for name in COLUMNS}
    motion = np.full(depth.shape, many.error)
    cause = "of the motion and of its series over the speed"
    return with_errors(own, dict.fromkeys(own, motion), cause=cause), solved


def _many_elastic(contact: Contact, mass: float, speed: FloatArray) -> _Many:
    line = map_to_springs(contact).line
    potential, _, largest = stopping_depths(contact, line, mass, np.array([speed.max()]))

    def followed(logarithm: FloatArray) -> FloatArray:
        energy = 0.5 * mass * np.minimum(np.exp(logarithm), speed.max()) ** 2
        half, deepest = (depths_of_energy(potential, e, float(largest[0])) for e in (0.5 * energy, energy))
        return np.log([contact_times(potential, mass, half, deepest), deepest])

    knots = potential.along(np.array(potential.knots)).energy
    time, deepest = np.exp(at_many(followed, np.log(speed), 0.5 * np.log(2.0 * knots / mass)))
    states = states_at_depth(line, deepest)
    columns = [np.ones(speed.size), time, deepest, normal_force(line, states), states.contact_radius]
    return _Many(columns, _ALONG, SOURCES["hertz"])


def _many_plastic(contact: Contact, mass: float, speed: FloatArray) -> _Many:
    ball = impacting(contact)
    loading, largest = loading_to(ball, mass, speed)
    if contact.adhesion is not None:
        return _many_parting(contact.adhesion.work, ball, mass, speed)

    def followed(logarithm: FloatArray) -> FloatArray:
        _, depths = loading_to(ball, mass, np.minimum(np.exp(logarithm), speed.max()))
        return np.log(contact_times_to(ball, loading, mass, depths))[None]

    knots = 0.5 * np.log(2.0 * loading.along(np.array(loading.knots)).energy / mass)
    time = np.exp(at_many(followed, np.log(speed), knots)[0])
    loss = ball.dissipation(largest) / (0.5 * mass * speed**2)
    e = np.sqrt(np.maximum(1.0 - loss, 0.0))
    columns = [e, time, largest, ball.force(largest, largest), ball.contact_radius(largest, largest)]
    return _Many(columns, _ALONG, SOURCES["johnson"])


def _many_parting(work: float, ball: Ball, mass: float, speed: FloatArray) -> _Many:
    """Each on its own: the edge recedes differently from every largest indentation."""
    loading, largest = loading_to(ball, mass, speed)
    columns = np.empty((len(COLUMNS), speed.size))
    for i, deepest in enumerate(largest.tolist()):
        m = np.array(deepest)
        back = parted(parting_from(ball, work, deepest), mass, 12)
        half = depths_of_energy(loading, 0.5 * loading.along(largest[i : i + 1]).energy, deepest)
        into = 0.5 * float(contact_times(loading, mass, half, largest[i : i + 1])[0])
        loss = (float(ball.dissipation(m)) + back.loss) / (0.5 * mass * speed[i] ** 2)
        columns[:, i] = (
            0.0 if back.sticks else math.sqrt(max(1.0 - loss, 0.0)),
            math.inf if back.sticks else into + float(back.time[-1]),
            deepest,
            float(ball.force(m, m)),
            float(ball.contact_radius(m, m)),
        )
    return _Many(list(columns), _ALONG, SOURCES["johnson"])


def _many_adhesive(contact: Contact, mass: float, speed: FloatArray) -> _Many:
    line = AdhesiveLine(contact)

    def followed(speeds: FloatArray) -> FloatArray:
        values = np.empty((len(COLUMNS), speeds.size))
        # the fastest first: it needs the longest curve
        for i in np.argsort(-speeds):
            course = collide(line, mass, float(speeds[i]), 8)
            fraction = course.jump_loss / (0.5 * mass * speeds[i] ** 2)
            values[:, i] = (
                0.0 if course.sticks else math.sqrt(max(1.0 - fraction, 0.0)),
                math.inf if course.sticks else course.time[-1],
                course.depth[course.deepest],
                course.force.max(),
                course.radius.max(),
            )
        return values

    fastest = collide(line, mass, float(speed.max()), 8)
    slowest = math.sqrt(2.0 * fastest.jump_loss / mass)
    parts = speed > slowest
    ready = partial(_Many, source=SOURCES["thornton-ning"], parting=_parting(fastest))
    if fastest.branches > 1:
        return ready(list(followed(speed)), _ALONG)
    # the contact time is a smooth function of the rebound speed
    rebound = np.sqrt((speed[parts] - slowest) * (speed[parts] + slowest))

    def parting(logarithm: FloatArray) -> FloatArray:
        return np.log(followed(np.hypot(np.exp(logarithm), slowest))[1:])

    def sticking(logarithm: FloatArray) -> FloatArray:
        return np.log(followed(np.exp(logarithm))[2:])

    columns = np.empty((len(COLUMNS), speed.size))
    columns[:2, ~parts] = [[0.0], [math.inf]]
    if parts.any():
        columns[0, parts] = rebound / speed[parts]
        columns[1:, parts] = np.exp(at_many(parting, np.log(rebound), np.zeros(0), _ADHESIVE))
    if not parts.all():
        columns[2:, ~parts] = np.exp(at_many(sticking, np.log(speed[~parts]), np.zeros(0), _ADHESIVE))
    return ready(list(columns), _ADHESIVE)


def _parting(fastest: Course) -> float | None:
    """The indentation in m at separation; None if the bodies stick."""
    return None if fastest.sticks else float(fastest.depth[-1])


_BETWEEN = 1e-9
"""Tolerance of the logarithms in a series over the speed, with memory."""
_NOTHING = 1e-300
"""Restitution and inverse contact time in s of bodies that come to rest, with finite logarithms."""


def _many_remembering(contact: Contact, mass: float, speed: FloatArray) -> _Many:
    target, fastest = followed(contact, mass, (float(speed.min()), float(speed.max())))
    line = target.line

    def numbers(motion: Motion) -> FloatArray:
        e = motion.rebound_speed / float(motion.steps[0, 3])
        time = min(motion.contact_time, 1.0 / _NOTHING)
        return np.log([max(e, _NOTHING), time, motion.deepest, largest_force(motion)[1]])

    def at(logarithm: float) -> Motion:
        return motion_at(target, mass, min(math.exp(logarithm), float(speed.max())))

    def followed_at(logarithm: FloatArray) -> FloatArray:
        return np.stack([numbers(at(each)) for each in logarithm], axis=1)

    inner = [line.depth(np.array([b]))[0] for b in line.breakpoints if b < line.max_radius]
    marks = [_speed_at(at, float(np.log(speed.min())), float(np.log(speed.max())), d) for d in inner]
    marks = [mark for mark in marks if mark is not None]
    e, time, deepest, force = np.exp(at_many(followed_at, np.log(speed), np.array(marks), _BETWEEN))
    rests = e <= 2.0 * _NOTHING
    error = _BETWEEN
    for motion in (fastest, at(float(np.log(np.median(speed)))), at(float(np.log(speed.min())))):
        own = float(motion.steps[0, 3])
        halved = rebound(target.curves, target.relaxation, mass, own, target.first / own, halved=motion)
        if halved is not None and not motion.rests:
            error = max(error, float(np.max(np.abs(numbers(halved) - numbers(motion)))))
    columns = [
        np.where(rests, 0.0, e),
        np.where(rests, math.inf, time),
        deepest,
        force,
        states_at_depth(line, deepest).contact_radius,
    ]
    return _Many(columns, error + target.relaxation.error, SOURCES["ting"])


def _speed_at(at: Callable[[float], Motion], low: float, high: float, depth: float) -> float | None:
    """The logarithm of the speed at which the indentation reaches a kink; None if it is not between two others."""
    if not at(low).deepest < depth < at(high).deepest:
        return None
    return float(
        scipy.optimize.brentq(lambda s: math.log(at(s).deepest / depth), low, high, xtol=1e-12, rtol=1e-12)
    )
