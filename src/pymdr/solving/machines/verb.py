"""The verb `move`."""

from __future__ import annotations

import math

import numpy as np

from pymdr.errors import ConvergenceError, PathError, ProblemError
from pymdr.line.motion import Followed, System, follow_motion
from pymdr.line.motion.driver import Outcome
from pymdr.problem.machines import Machine
from pymdr.solving.machines.assembling import first_depths, map_contact, system_of
from pymdr.solving.machines.interpreting import Run, fastest, interpret
from pymdr.solving.machines.value import Motion
from pymdr.units import QuantityLike, shown, to_si, written

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
        raise ProblemError(f"move: {shown(machine)} is not a machine; give Machine(bodies, links)")
    span = to_si(duration, "s", name="duration")
    if not 0.0 < span < math.inf:
        raise ProblemError(f"move: duration = {shown(duration)}; it must be above 0 s and finite")
    if not isinstance(steps, int | np.integer) or isinstance(steps, bool) or not 2 <= steps <= _MOST // 2:
        raise ProblemError(f"move: steps = {shown(steps)}; a whole number from 2 to {_MOST // 2} is needed")
    if not isinstance(accuracy, int | float) or not 1e-12 <= accuracy < 1.0:
        raise ProblemError(f"move: accuracy = {shown(accuracy)}; it must be at least 1e-12 and below 1")
    system, run = _halved(machine, span, int(steps), float(accuracy))
    return interpret(machine, system, run)


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
                    "move: an indentation grows without bound; check forces, drives and signs of normal="
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
        f"move: {rows * parts // 2} steps over {written(span, 's')}: {reached}, above accuracy = {accuracy:g}; move for a shorter "
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
            f"move: {written(span, 's')} are {largest * span / (2.0 * math.pi):.3g} periods of the fastest spring or wave, more than "
            f"{_MOST} steps resolve; move for a shorter duration"
        )
    return int(2 ** math.ceil(math.log2(max(needed, 1.0))))


def _change(fine: Followed, coarse: Followed) -> float:
    """The largest change of a position, relative to the way of its body."""
    extent = np.ptp(fine.position, axis=0)
    size = np.maximum(extent, 1e-9 * np.max(extent, initial=0.0))
    change = np.abs(fine.position - coarse.position).max(axis=0)
    return float(np.max(change / np.where(size > 0.0, size, 1.0)))
