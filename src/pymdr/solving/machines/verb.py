"""The verb `move`, with step 3 of a motion: its quantities, claims and assumptions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pymdr.errors import ConvergenceError, PathError, ProblemError
from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.line.friction import evaluate
from pymdr.line.motion import Followed, System, follow_motion
from pymdr.line.motion.driver import Outcome
from pymdr.problem.contact import Contact, is_curve
from pymdr.problem.machines import Machine
from pymdr.quantities import quantity
from pymdr.solving.machines.assembling import first_depths, map_contact, ordered, system_of
from pymdr.solving.machines.value import ENERGIES, Motion, residual_of
from pymdr.solving.stepping import Stepper
from pymdr.solving.study import dataset
from pymdr.units import FloatArray, QuantityLike, metres, shown, to_si, written

QUASI_STATIC = "contacts are assumed to be in equilibrium: all times must exceed a few transits of waves through the contact"
_JOINTS = ("indentation", "shift", "normal_force", "tangential_force", "contact_radius", "stick_radius")
_FRICTION = ("shift", "tangential_force", "stick_radius", "stored_tangential_energy", "dissipated_energy")
_SOURCES = ("gonzalez", "popov-hess")


class Run(NamedTuple):
    """A motion, and the same with steps twice as long."""

    fine: Followed
    coarse: Followed
    time: FloatArray
    """Of the rows in s."""
    change: float
    """Largest change of the positions by the last halving, relative to the way of each body."""


def interpret(machine: Machine, system: System, run: Run) -> Motion:
    """Step 3: quantities, claims and assumptions."""
    values, before = (_quantities(machine, system, followed, run.time) for followed in (run.fine, run.coarse))
    dims = {2: ("step", "body"), 1: ("step",)}
    free, drives = ordered(machine)
    variables = {
        name: (("step", "joint") if name in _JOINTS else dims[array.ndim], array, _attributes(name))
        for name, array in values.items()
    }
    coords = {
        "time": ("step", run.time, _attributes("time")),
        "body": ("body", [body.name for body in (*free, *drives)]),
    }
    if machine.joints:
        coords["joint"] = ("joint", [joint.name for joint in machine.joints])
    balance = Assumption(
        "energy balance",
        "relative residual; change of energies and dissipation minus work of drives and forces",
        residual_of({name: values.get(name, np.zeros(run.time.size)) for name in ENERGIES}),
        1e-9,
    )
    return Motion(
        machine=machine,
        data=dataset(variables, coords=coords, attrs={"steps": run.fine.steps}),
        claims=_claims(machine, system, run, (values, before)),
        assumptions=(balance,),
        notes=_notes(system, run),
        references=_SOURCES,
    )


def _attributes(name: str) -> dict[str, str]:
    q = quantity(name)
    return {"units": q.unit, "long_name": q.long_name, "symbol": q.symbol}


def _quantities(
    machine: Machine, system: System, followed: Followed, time: FloatArray
) -> dict[str, FloatArray]:
    """Quantities by name; without friction those of the shift are left out, without joints those of contacts."""
    moved = np.empty((time.size, system.course.shape[0]))
    moved[:] = system.course[:, 1]
    for i, amplitude, angular, phase in system.drive_waves:
        moved[:, int(i)] += amplitude * angular * np.cos(angular * time + phase)
    values = {"position": followed.position, "velocity": np.column_stack([followed.velocity, moved])}
    if machine.joints:
        values |= {name: followed.joints[:, :, i] for i, name in enumerate(_JOINTS)}
    values |= {name: followed.energies[:, i] for i, name in enumerate(ENERGIES)}
    slips = bool(np.any(system.joints.friction[:, None] * system.joints.tangential))
    unknown = {name for name in _FRICTION if not slips}
    if any(is_curve(joint.contact) for joint in machine.joints):
        unknown |= {"contact_radius", "stick_radius"}
    if not machine.joints:
        unknown.add("elastic_energy")
    return {name: array for name, array in values.items() if name not in unknown}


def _claims(
    machine: Machine,
    system: System,
    run: Run,
    results: tuple[Mapping[str, FloatArray], Mapping[str, FloatArray]],
) -> dict[str, Claim]:
    """The claims of the contacts at their deepest, with the errors of the integration."""
    of_contacts = [Stepper(contact, depth).claims for contact, depth in _deepest(machine, run.fine).items()]
    everywhere, (values, before) = np.ones(run.time.size, dtype=bool), results
    claims = {}
    for name, array in values.items():
        own = [_claim_for(name, claims_of) for claims_of in of_contacts]
        reason = "; ".join(dict.fromkeys([*(claim.reason for claim in own), QUASI_STATIC]))
        source = "; ".join(dict.fromkeys([*(claim.source for claim in own), SOURCES["gonzalez"]]))
        level = max((claim.level for claim in own), key=list(Level).index, default=Level.EXACT)
        errors = [math.nan if claim.error is None else float(np.max(claim.error)) for claim in own]
        change = _change_of(name, array, before[name], system, run)
        known = change is not None and not any(map(math.isnan, errors))
        error = max(errors, default=0.0) + change if known and change is not None else None
        counted = (
            f"{run.fine.steps} steps; errors by halving them, relative to the largest value of the motion"
        )
        if change is None:
            level = max(level, Level.APPROXIMATE, key=list(Level).index)
            counted = "it jumps where slip reverses; rows nearer to a jump than the error of its time may lie on the other side"
        claims[name] = Claim(level, f"{reason}; {counted}", source, everywhere, error)
    return claims


def _change_of(
    name: str, fine: FloatArray, coarse: FloatArray, system: System, run: Run
) -> FloatArray | None:
    """The error of every row of a quantity by the last halving, relative to its largest value; None if it jumps in time."""
    if name == "stick_radius":
        return None
    size = _size(fine)
    if name != "contact_radius":
        # the largest of all rows, because the difference changes sign
        return np.full(len(fine), np.max(np.abs(fine - coarse) / size))
    # the radius of a touch rises infinitely fast, the indentation does not
    depth = run.fine.joints[:, :, 0]
    change = np.abs(depth - run.coarse.joints[:, :, 0]).max(axis=0)
    ends = [
        np.column_stack(
            [evaluate(curves, d)[0] for curves, d in zip(system.joints.curves, at.T, strict=True)]
        )
        for at in (np.minimum(depth + change, depth.max(axis=0)), depth - change)
    ]
    return np.asarray(((ends[0] - ends[1]) / size).max(axis=1))


def _size(values: FloatArray) -> FloatArray:
    """Largest value of the motion of every body or joint; 1 where all are 0."""
    size = np.abs(values).max(axis=0)
    return np.where(size > 0.0, size, 1.0)


def _claim_for(name: str, claims: Mapping[str, Claim]) -> Claim:
    """The claim of a quantity of a contact; of any other that of its forces."""
    return claims.get(name) or claims.get("tangential_force") or claims["normal_force"]


def _deepest(machine: Machine, followed: Followed) -> dict[Contact, float]:
    """The largest indentation in m of every contact that touched."""
    deepest: dict[Contact, float] = {}
    for joint, depth in zip(machine.joints, followed.joints[:, :, 0].max(axis=0), strict=True):
        if depth > 0.0:
            deepest[joint.contact] = max(float(depth), deepest.get(joint.contact, 0.0))
    return deepest


def fastest(system: System, followed: Followed) -> float:
    """The largest angular frequency in rad/s of a coordinate on its springs and contacts, or of a wave."""
    n = system.mass.size
    stiffness = (system.springs[:, :1] * system.springs[:, 3:] ** 2).sum(axis=0)
    if len(system.joints.curves):
        radius = followed.joints[:, :, 4].max(axis=0)
        modulus = np.array([curves.modulus for curves in system.joints.curves])
        across = system.joints.tangential**2 / system.joints.modulus_ratio[:, None]
        squares = system.joints.normal**2 + across * (system.joints.friction[:, None] > 0.0)
        stiffness = stiffness + (2.0 * modulus * radius)[:, None].T @ squares
    waves = [float(wave[2]) for wave in (*system.force_waves, *system.drive_waves)]
    return max(float(np.sqrt(np.max(stiffness.ravel()[:n] / system.mass))), *waves, 0.0)


def _notes(system: System, run: Run) -> tuple[str, ...]:
    """The time that has to be compared with that of waves: bodies have no density here."""
    if not len(system.joints.curves):
        return ()
    rate, width = fastest(system, run.fine), 2.0 * float(run.fine.joints[:, :, 4].max())
    if width == 0.0:
        return ("the bodies never touched",)
    if rate == 0.0:
        return ()
    return (
        f"the shortest period is {written(2.0 * math.pi / rate, 's', 3)}; waves must cross the widest contact, 2a = {metres(width)}, in a much "
        "shorter time, which is not checked because bodies have no density",
    )


_MOST = 20_000_000
"""Largest number of steps of the integration."""
_FIRST = 0.2
"""Step at the start over the inverse of the largest angular frequency that is known before."""
_RESOLVED = 0.5
"""Largest step of a motion over the inverse of its largest angular frequency."""
_DEEPENINGS = 200


def move(machine: Machine, duration: QuantityLike, *, steps: int = 1000, accuracy: float = 1e-3) -> Motion:
    r"""
    Move a machine with contacts from its start.

    .. math:: M (v_1 - v_0) = h \bar F, \quad x_1 - x_0 = \tfrac{h}{2} (v_0 + v_1), \quad \bar F_N = \frac{U(d_1) - U(d_0)}{d_1 - d_0}

    The mean force of a step is the change of the energy of the line over the change of the indentation, likewise with the energy stored by
    the shift and dissipated by slip. The balance of energies therefore closes at any step h, and contact, slip and separation need no
    search for events. The steps are halved until the motion no longer changes.

    Parameters
    ----------
    machine : Machine
        Bodies, springs, forces, and elastic contacts without adhesion, with or without friction.
    duration : quantity
        In s, above 0.
    steps : int
        Rows after the first, evenly spaced in time.
    accuracy : float
        Largest change of a position by the last halving, relative to the way of its body; between 1e-12 and 1.

    Returns
    -------
    Motion
        Over ``step``: positions and velocities in m and m/s, forces of the joints in N, energies in J.

    Raises
    ------
    ProblemError
        If a value is outside its limits, or a contact has adhesion, memory, layers, grading, plasticity or no slip.
    PathError
        If a profile ends before the bodies come to rest.
    RefusedError
        If a contact is not a disk at every indentation.
    ConvergenceError
        If 20 million steps do not reach the accuracy.

    See Also
    --------
    impact : one collision, with adhesion, memory and plasticity.
    Stepper : one contact for other integrators.

    Notes
    -----
    Second order, symmetric in time. Bodies are rigid outside their contacts. A joint that is pressed at the start was pressed without
    friction.

    References
    ----------
    - Gonzalez (1996), J. Nonlinear Sci. 6, 449-467, doi:10.1007/BF02440162.
    - Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, chapters 12 to 14.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("210 GPa", 0.3))
    >>> falling = mdr.Machine([mdr.Mass("ball", "33 g", velocity="1 m/s")], [mdr.Joint(ball, "ball")])
    >>> motion = mdr.move(falling, "100 us", steps=100)
    >>> round(float(motion["velocity"].sel(body="ball")[-1]), 9)
    -1.0
    """
    if not isinstance(machine, Machine):
        raise ProblemError(f"{shown(machine)} is not a machine; give Machine(bodies, links)")
    span = checked_span(duration, steps, accuracy)
    system, run = _halved(machine, span, int(steps), float(accuracy))
    return interpret(machine, system, run)


def checked_span(duration: QuantityLike, steps: int = 1000, accuracy: float = 1e-3) -> float:
    """The duration in s of a motion."""
    span = to_si(duration, "s", name="duration")
    if not 0.0 < span < math.inf:
        raise ProblemError(f"duration = {shown(duration)}; it must be above 0 s and finite")
    if not isinstance(steps, int | np.integer) or isinstance(steps, bool) or not 2 <= steps <= _MOST // 2:
        raise ProblemError(f"steps = {shown(steps)}; a whole number from 2 to {_MOST // 2} is needed")
    if not isinstance(accuracy, int | float) or not 1e-12 <= accuracy < 1.0:
        raise ProblemError(f"accuracy = {shown(accuracy)}; it must be at least 1e-12 and below 1")
    return span


def _halved(machine: Machine, span: float, rows: int, accuracy: float) -> tuple[System, Run]:
    """The motion whose steps are halved until it no longer changes."""
    mapped = {joint.contact: map_contact(joint.contact) for joint in machine.joints}
    depths = first_depths(machine, mapped)
    system = system_of(machine, mapped, depths)
    parts = _first_parts(system, span, rows)
    coarse, change, deepened = None, math.inf, 0
    while rows * parts <= _MOST:
        step = span / (rows * parts)
        followed = follow_motion(system, step, rows, parts)
        if followed.outcome is Outcome.TOO_DEEP:
            deepened += 1
            if deepened > _DEEPENINGS:
                raise PathError(
                    "an indentation grows without bound; check forces, drives and signs of normal="
                )
            depths = {contact: 2.0 * depth for contact, depth in depths.items()}
            system, coarse = system_of(machine, mapped, depths), None
            continue
        if followed.outcome is Outcome.COMPLETE:
            if coarse is not None:
                change = _change(followed, coarse)
                if change <= accuracy and step * fastest(system, followed) <= _RESOLVED:
                    return system, Run(followed, coarse, np.linspace(0.0, span, rows + 1), change)
            coarse = followed
        parts *= 2
    reached = (
        "steps did not converge"
        if math.isinf(change)
        else f"the last halving changed a position by {change:.2g} of its range"
    )
    raise ConvergenceError(
        f"{rows * parts // 2} steps over {written(span, 's')}: {reached}, above accuracy = {accuracy:g}; move for a shorter "
        "duration, or give a larger accuracy (a chaotic motion never converges)"
    )


def _first_parts(system: System, span: float, rows: int) -> int:
    """Steps of a row at first, a power of 2."""
    stiffness = (system.springs[:, :1] * system.springs[:, 3:] ** 2).sum(axis=0)[: system.mass.size]
    own = np.sqrt(stiffness / system.mass)
    waves = np.concatenate([system.force_waves[:, 2], system.drive_waves[:, 2]])
    largest = float(max(np.max(own, initial=0.0), np.max(waves, initial=0.0)))
    needed = largest * span / rows / _FIRST
    if needed * rows > _MOST:
        raise ConvergenceError(
            f"{written(span, 's')} are {largest * span / (2.0 * math.pi):.3g} periods of the fastest spring or wave, more than "
            f"{_MOST} steps resolve; move for a shorter duration"
        )
    return int(2 ** math.ceil(math.log2(max(needed, 1.0))))


def _change(fine: Followed, coarse: Followed) -> float:
    """The largest change of a position, relative to the way of its body."""
    extent = np.ptp(fine.position, axis=0)
    size = np.maximum(extent, 1e-9 * np.max(extent, initial=0.0))
    change = np.abs(fine.position - coarse.position).max(axis=0)
    return float(np.max(change / np.where(size > 0.0, size, 1.0)))
