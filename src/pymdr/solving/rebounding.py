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
from pymdr.solving.colliding import depth_storing
from pymdr.solving.memory import powers_of
from pymdr.units import metres, written

_SHORTEST, _LONGEST = 1e-8, 1e3
"""Span of the exponentials that approximate a power of time, relative to the contact time."""
_NEAR = 30.0
"""Largest ratio of a contact time to the one for which that span was chosen."""
_TRIES = 40
_SOFTER = 4.0


@dataclass(frozen=True)
class Target:
    """The target of an impact: the line, its known curves, and E*(t)."""

    contact: Contact
    line: ElasticLine
    """Per unit modulus."""
    curves: ElasticCurves
    relaxation: Relaxation
    span: tuple[float, float] | None
    """Span in s of the exponentials that approximate a power of time."""
    first: float
    """About a twentieth of the rise time of the force in s, at a speed of 1 m/s."""


def followed(contact: Contact, mass: float, speeds: tuple[float, float]) -> tuple[Target, Motion]:
    """
    The target for masses of all speeds between two, and the motion at the highest.

    Parameters
    ----------
    contact : Contact
        With a body with memory.
    mass : float
        In kg.
    speeds : tuple of float
        The lowest and the highest in m/s.

    Raises
    ------
    PathError
        If the profile ends before the fastest mass comes to rest.
    ProblemError
        If the equivalent profile decreases within the contact, or below its middle.
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
        target, motion = _followed(
            contact, line, mass, speeds[1], relaxation_of(contact.body, contact.counterbody, span=span), span
        )
        slowest = motion_at(target, mass, speeds[0])
        contact_times = [slowest.contact_time, motion.contact_time]
        if all(not math.isfinite(t) or t <= _NEAR * max(times) for t in contact_times) and all(
            t >= min(times) / _NEAR for t in contact_times
        ):
            return target, motion
        times = [t if math.isfinite(t) else old for t, old in zip(contact_times, times, strict=True)]
    raise ConvergenceError(
        f"the search for the span of times of the rheology did not converge (last value {span} s); give the rheology as a Prony series (PowerLawRheology.prony)"
    )


def _refuse_hollow(line: ElasticLine) -> None:
    """Refuse a line that is lower than its middle elsewhere, and touches there first."""
    end = (1.0 - 1e-12) * min(line.edge, line.max_radius)
    if line.rises or not math.isfinite(end):
        return
    turns = np.array(line.turning_points(end))
    depths = line.depth(turns) if turns.size else turns
    if np.min(depths, initial=0.0) < 0.0:
        lowest = int(np.argmin(depths))
        raise ProblemError(
            f"at x = {metres(float(turns[lowest]))} the equivalent profile is {metres(-float(depths[lowest]))} below its "
            "middle and touches first, so the contact is not a disk, as impacts of bodies with memory need; use "
            "an increasing profile, or prescribe indentations in solve(..., solver=Rings(n=400))"
        )


def motion_at(target: Target, mass: float, speed: float) -> Motion:
    """The motion of a mass no faster than the one for which the target was made."""
    motion = rebound(target.curves, target.relaxation, mass, speed, target.first / speed)
    if motion is None:
        raise ConvergenceError(
            f"at {written(speed, 'm/s', 6)} the computed indentation exceeds that at a higher speed; use fewer speeds, or check the magnitudes of mass and moduli"
        )
    return motion


def _followed(
    contact: Contact,
    line: ElasticLine,
    mass: float,
    speed: float,
    relaxation: Relaxation,
    span: tuple[float, float] | None,
) -> tuple[Target, Motion]:
    energy = 0.5 * mass * speed * speed
    potential = elastic_potential(line, math.inf)

    def depths_of(modulus: float) -> tuple[float, float, bool]:
        """The depth range of the curves, the expected depth, and whether the profile ends before."""
        high, stored = depth_storing(potential, line, contact.profile, energy / modulus)
        if stored < energy / modulus:
            return high, high, True
        return high, float(depths_of_energy(potential, np.array([energy / modulus]), high)[0]), False

    modulus = relaxation.equilibrium + float(relaxation.moduli.sum())
    high, depth, ended = depths_of(modulus)
    for _ in range(4):
        # the mean of E*(t) in Pa up to a time
        time = depth / speed
        flow = -np.expm1(-time / relaxation.times) * relaxation.times @ relaxation.moduli
        modulus = relaxation.equilibrium + (float(flow) + relaxation.viscosity) / time
        high, depth, ended = depths_of(modulus)
    for _ in range(_TRIES):
        curves = curves_down_to(line, high)
        target = Target(contact, line, curves, relaxation, span, 0.05 * depth)
        motion = rebound(curves, relaxation, mass, speed, target.first / speed)
        if motion is not None:
            if not rises_to(line, motion.deepest):
                raise ProblemError(
                    "the equivalent profile decreases within the contact, which is not covered with memory; use an "
                    "increasing profile, or smooth it"
                )
            return target, motion
        if ended:
            break
        modulus /= _SOFTER
        high, depth, ended = depths_of(modulus)
    raise PathError(
        f"speed = {written(speed, 'm/s', 6)}: the bodies would not come to rest before the profile ends at "
        f"d = {metres(depth)}; reduce the speed or the mass, or extend the profile"
    )


def _guess(contact: Contact, line: ElasticLine, mass: float, speed: float) -> float:
    """Approximate contact time in s: that of elastic bodies with the modulus at that time."""
    potential = elastic_potential(line, math.inf)
    energy = np.array([0.5 * mass * speed * speed])
    time = powers_of(contact)[0].time
    for _ in range(_TRIES):
        span = (time / 10.0, time * 10.0)
        modulus = float(relaxation_of(contact.body, contact.counterbody, span=span)(time))
        high, stored = depth_storing(potential, line, contact.profile, float(energy[0]) / modulus)
        enough = stored >= energy[0] / modulus
        depth = float(depths_of_energy(potential, energy / modulus, high)[0]) if enough else high
        before, time = time, 3.0 * depth / speed
        if abs(math.log(time / before)) < 0.5:
            break
    return time
