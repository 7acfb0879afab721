"""The normal motion of a mass on bodies with memory: line, kernel and steps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ConvergenceError, PathError, ProblemError
from pymdr.interpretation.traction import curves_down_to
from pymdr.line.curves import ElasticLine
from pymdr.line.foundation import rises_to
from pymdr.line.friction import ElasticCurves
from pymdr.line.impact import depths_of_energy, elastic_potential
from pymdr.line.rebound import Motion, rebound
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.relaxation import Relaxation, relaxation_of
from pymdr.problem.contact import Contact
from pymdr.solving.colliding import reaching
from pymdr.solving.memory import powers_of
from pymdr.units import metres, written

_SHORTEST, _LONGEST = 1e-8, 1e3
"""Of the contact time: the span of the exponentials that stand for a power of time."""
_NEAR = 30.0
"""By how much a contact time may differ from the one for which that span was chosen."""
_TRIES = 40
_SOFTER = 4.0


@dataclass(frozen=True)
class Ground:
    """What a mass meets: the line, its curves as far as they are known, and E*(t)."""

    contact: Contact
    line: ElasticLine
    """Per unit modulus."""
    curves: ElasticCurves
    relaxation: Relaxation
    span: tuple[float, float] | None
    """Of the exponentials that stand for a power of time, in s."""
    first: float
    """About a twentieth of the time in s in which the force grows, at a speed of 1 m/s."""


def followed(contact: Contact, mass: float, speeds: tuple[float, float]) -> tuple[Ground, Motion]:
    """
    The ground on which masses of all speeds between two are followed, and the motion of the fastest.

    Parameters
    ----------
    contact : Contact
        Of which a body has a memory.
    mass : float
        In kg.
    speeds : tuple of float
        The lowest and the highest in m/s.

    Raises
    ------
    PathError
        If the profile ends before the fastest comes to rest.
    ProblemError
        If the equivalent profile falls within the contact, or below its middle.
    """
    line = ElasticLine(equivalent_profile(contact.profile), 1.0)
    _refuse_hollow(line)
    if not powers_of(contact):
        return _followed(
            contact, line, mass, speeds[1], relaxation_of(contact.body, contact.counterbody), None
        )
    times = [_guess(contact, line, mass, speed) for speed in speeds]
    for _ in range(_TRIES):
        span = _SHORTEST * min(times), _LONGEST * max(times)
        ground, motion = _followed(
            contact, line, mass, speeds[1], relaxation_of(contact.body, contact.counterbody, span=span), span
        )
        slowest = motion_at(ground, mass, speeds[0])
        found = [slowest.contact_time, motion.contact_time]
        if all(not math.isfinite(t) or t <= _NEAR * max(times) for t in found) and all(
            t >= min(times) / _NEAR for t in found
        ):
            return ground, motion
        times = [t if math.isfinite(t) else old for t, old in zip(found, times, strict=True)]
    raise ConvergenceError(f"impact: no span of times was found for the rheology; the last is {span} s")


def _refuse_hollow(line: ElasticLine) -> None:
    """Refuse a line that falls below its middle, where something else touches first."""
    reach = (1.0 - 1e-12) * min(line.edge, line.reach)
    if line.rises or not math.isfinite(reach):
        return
    turns = np.array(line.turning_points(reach))
    depths = line.depth(turns) if turns.size else turns
    if np.min(depths, initial=0.0) < 0.0:
        lowest = int(np.argmin(depths))
        raise ProblemError(
            f"impact: at x = {metres(float(turns[lowest]))} the equivalent profile is {metres(-float(depths[lowest]))} below its "
            "middle: something else touches first, and the contact is no disk, which impacts of bodies with memory need; take "
            "a profile that rises, or follow indentations with solve(..., solver=Rings(n=400))"
        )


def motion_at(ground: Ground, mass: float, speed: float) -> Motion:
    """The motion of a mass no faster than the one for which the ground was made."""
    motion = rebound(ground.curves, ground.relaxation, mass, speed, ground.first / speed)
    if motion is None:
        raise ConvergenceError(
            f"impact: at {written(speed, 'm/s', 6)} the mass goes deeper than at a higher speed"
        )
    return motion


def _followed(
    contact: Contact,
    line: ElasticLine,
    mass: float,
    speed: float,
    relaxation: Relaxation,
    span: tuple[float, float] | None,
) -> tuple[Ground, Motion]:
    energy = 0.5 * mass * speed * speed
    potential = elastic_potential(line, math.inf)

    def depths_of(modulus: float) -> tuple[float, float, bool]:
        """How far curves are read, the depth itself, on which steps in all units depend alike, and whether the profile ends."""
        high, stored = reaching(potential, line, contact.profile, energy / modulus)
        if stored < energy / modulus:
            return high, high, True
        return high, float(depths_of_energy(potential, np.array([energy / modulus]), high)[0]), False

    modulus = relaxation.equilibrium + float(relaxation.moduli.sum())
    high, depth, ended = depths_of(modulus)
    for _ in range(4):
        modulus = _mean(relaxation, depth / speed)
        high, depth, ended = depths_of(modulus)
    for _ in range(_TRIES):
        curves = curves_down_to(line, high)
        ground = Ground(contact, line, curves, relaxation, span, 0.05 * depth)
        motion = rebound(curves, relaxation, mass, speed, ground.first / speed)
        if motion is not None:
            if not rises_to(line, motion.deepest):
                raise ProblemError(
                    "impact: the equivalent profile falls somewhere within the contact: with memory the contact of such a "
                    "profile is not followed; take one that rises, or smooth it"
                )
            return ground, motion
        if ended:
            break
        modulus /= _SOFTER
        high, depth, ended = depths_of(modulus)
    raise PathError(
        f"speed = {written(speed, 'm/s', 6)}: the bodies would not come to rest before the profile ends at "
        f"d = {metres(depth)}; reduce the speed or the mass, or give the profile farther out"
    )


def _mean(relaxation: Relaxation, time: float) -> float:
    """The mean of E*(t) in Pa up to a time in s."""
    flow = -np.expm1(-time / relaxation.times) * relaxation.times @ relaxation.moduli
    return relaxation.equilibrium + (float(flow) + relaxation.viscosity) / time


def _guess(contact: Contact, line: ElasticLine, mass: float, speed: float) -> float:
    """About the contact time in s: that of elastic bodies with the modulus at that time."""
    potential = elastic_potential(line, math.inf)
    energy = np.array([0.5 * mass * speed * speed])
    time = powers_of(contact)[0].time
    for _ in range(_TRIES):
        span = (time / 10.0, time * 10.0)
        modulus = float(relaxation_of(contact.body, contact.counterbody, span=span)(time))
        high, stored = reaching(potential, line, contact.profile, float(energy[0]) / modulus)
        enough = stored >= energy[0] / modulus
        depth = float(depths_of_energy(potential, energy / modulus, high)[0]) if enough else high
        before, time = time, 3.0 * depth / speed
        if abs(math.log(time / before)) < 0.5:
            break
    return time
