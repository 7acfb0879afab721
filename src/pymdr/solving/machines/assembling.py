"""A machine as the system of equations that is integrated."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pymdr.errors import ProblemError
from pymdr.interpretation.traction import curves_down_to
from pymdr.line.foundation import states_at_depth
from pymdr.line.motion import Joints, System
from pymdr.mapping.equivalent import PowerLine
from pymdr.problem.contact import Contact
from pymdr.problem.machines import Body, Coefficients, Drive, Force, Joint, Machine, Mass, Rotor, Spring
from pymdr.problem.profiles import Shape
from pymdr.solving.colliding import first_depth
from pymdr.solving.frictional import disks_down_to
from pymdr.solving.mapped import Springs, map_to_springs, refuse_unreachable
from pymdr.units import FloatArray

_MARGIN = 1.5
"""First guess of the largest indentation over that of the energy at the start."""


class Inertia(NamedTuple):
    """A free coordinate: its mass in kg, and its position in m and velocity in m/s at the start."""

    mass: float
    position: float
    velocity: float


def inertia_of(body: Body) -> Inertia:
    """The coordinate of a mass, or of the rim of a rotor."""
    if isinstance(body, Rotor):
        mass = body.inertia / body.radius / body.radius
        return Inertia(mass, body.radius * body.angle, body.radius * body.spin)
    assert isinstance(body, Mass)
    return Inertia(body.mass, body.position, body.velocity)


def ordered(machine: Machine) -> tuple[list[Body], list[Drive]]:
    """The free bodies, and the drives, in the order of the coordinates."""
    free = [body for body in machine.bodies if not isinstance(body, Drive)]
    return free, [body for body in machine.bodies if isinstance(body, Drive)]


def map_contact(contact: Contact) -> Springs:
    """Step 1 of a contact of a machine."""
    coefficient = coefficient_of(contact)
    for refused, why in (
        (contact.adhesion is not None, "adhesive contacts are not available; leave adhesion out"),
        (
            contact.is_viscoelastic,
            "bodies with memory are not available; use Elastic with the modulus at one time",
        ),
        (contact.plastic is not None, "bodies that yield are not available; impact(...) integrates them"),
        (
            contact.layered is not None,
            "layered bodies are not available; give the force_curve() of solve(...) as the profile of half-spaces",
        ),
        (
            contact.body.grading != 0.0 or contact.counterbody.grading != 0.0,
            "graded bodies are not available; use Elastic",
        ),
        (
            isinstance(contact.profile, Shape),
            "the contact is not a disk; give the force_curve() of solve(...) as its profile",
        ),
        (
            not math.isfinite(coefficient),
            f"mu = {coefficient:g}; the coefficient of friction must be finite, for example Coulomb(10)",
        ),
    ):
        if refused:
            raise ProblemError(why)
    return map_to_springs(contact)


def coefficient_of(contact: Contact) -> float:
    """The coefficient of friction; 0 without a law."""
    return 0.0 if contact.friction is None else contact.friction.coefficient


def first_depths(machine: Machine, mapped: dict[Contact, Springs]) -> dict[Contact, float]:
    """Indentations in m up to which the curves of the contacts are made at first; inf for power laws, whose curves are closed forms."""
    free, drives = ordered(machine)
    energy = sum(0.5 * part.mass * part.velocity**2 for part in map(inertia_of, free))
    start = {body.name: inertia_of(body).position for body in free} | {d.name: d.position for d in drives}
    swing = {d.name: float(np.sum(np.abs(d.amplitude))) for d in drives}
    depths: dict[Contact, float] = {}
    for joint in machine.joints:
        line = mapped[joint.contact].line
        if isinstance(line.equivalent, PowerLine):
            depths[joint.contact] = math.inf
            continue
        pressed = joint.indentation + sum(
            factor * start[name] + abs(factor) * swing.get(name, 0.0) for name, factor in joint.normal
        )
        stored = float(first_depth(line, energy)) if energy > 0.0 and joint.normal else 0.0
        guess = _MARGIN * max(pressed, 0.0) + stored
        depths[joint.contact] = max(
            guess or first_depth(line, 1e-12 * line.modulus * joint_size(joint)),
            depths.get(joint.contact, 0.0),
        )
    return depths


def joint_size(joint: Joint) -> float:
    """A volume in m^3 of the profile, as a scale of energies."""
    radius = getattr(joint.contact.profile, "curvature_radius", None) or 1.0
    return float(radius) ** 3


def system_of(machine: Machine, mapped: dict[Contact, Springs], depths: dict[Contact, float]) -> System:
    """The equations of motion."""
    free, drives = ordered(machine)
    index = {body.name: i for i, body in enumerate([*free, *drives])}
    count, n = len(index), len(free)

    def row(pairs: Coefficients) -> FloatArray:
        values = np.zeros(count)
        for name, factor in pairs:
            values[index[name]] = factor
        return values

    inertias = [inertia_of(body) for body in free]
    push, waves = np.zeros(n), []
    for force in (link for link in machine.links if isinstance(link, Force)):
        factors = row(force.on)[:n]
        push += force.force * factors
        waves += [
            _wave(int(i), factors[i], force, k)
            for i in np.flatnonzero(factors)
            for k in range(force.amplitude.size)
        ]
    moved = [_wave(i, 1.0, drive, k) for i, drive in enumerate(drives) for k in range(drive.amplitude.size)]
    springs = [
        [link.stiffness, link.damping, link.elongation, *row(link.between)]
        for link in machine.links
        if isinstance(link, Spring)
    ]
    return System(
        np.array([part.mass for part in inertias]),
        np.array([part.position for part in inertias]),
        np.array([part.velocity for part in inertias]),
        push,
        np.array(waves).reshape(-1, 4),
        np.array([[drive.position, drive.velocity] for drive in drives]).reshape(-1, 2),
        np.array(moved).reshape(-1, 4),
        np.array(springs).reshape(-1, 3 + count),
        _joints(machine.joints, mapped, depths, [[row(j.normal), row(j.tangential)] for j in machine.joints]),
    )


def _joints(
    joints: tuple[Joint, ...],
    mapped: dict[Contact, Springs],
    depths: dict[Contact, float],
    rows: list[list[FloatArray]],
) -> Joints:
    curves = {}
    for contact, depth in depths.items():
        line = mapped[contact].line
        if math.isfinite(depth):
            refuse_unreachable(line, contact.profile, states_at_depth(line, np.array([depth])))
            disks_down_to(contact, line, depth, "move")
        curves[contact] = curves_down_to(line, depth if math.isfinite(depth) else 1.0)
    moduli = [mapped[joint.contact].moduli for joint in joints]
    coordinates = np.array(rows).reshape(len(joints), 2, -1) if joints else np.zeros((0, 2, 0))
    return Joints(
        [curves[joint.contact] for joint in joints],
        np.array([coefficient_of(joint.contact) for joint in joints]),
        np.array([m.normal / m.tangential for m in moduli]),
        np.array([joint.indentation for joint in joints]),
        coordinates[:, 0],
        coordinates[:, 1],
    )


def _wave(coordinate: int, factor: float, waves: Drive | Force, k: int) -> list[float]:
    """A row of the table of waves: coordinate, amplitude, angular frequency, phase."""
    angular = 2.0 * math.pi * float(waves.frequency[k])
    return [float(coordinate), factor * float(waves.amplitude[k]), angular, float(waves.phase[k])]
