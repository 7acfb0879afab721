"""Motion of masses on springs, dampers and contacts, by the discrete gradient. Loads numba when it runs."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from pymdr.line.friction import ElasticCurves, virgin_state
from pymdr.line.motion.layout import STACK_FULL
from pymdr.units import FloatArray

_CAPACITY = 16
"""Vertices for which every stack has room at first."""


class Outcome(Enum):
    """How a motion ended."""

    COMPLETE = "all rows were followed"
    TOO_DEEP = "an indentation is deeper than the curves"
    STACK_FULL = "the stack of turning points is full"
    NOT_CONVERGED = "the iteration of a step did not converge"


OUTCOMES = tuple(Outcome)


class Joints(NamedTuple):
    """The contacts of a system."""

    curves: Sequence[ElasticCurves]
    """Of each joint."""
    friction: FloatArray
    """(j,) coefficients of friction; 0 without."""
    modulus_ratio: FloatArray
    """(j,) E* / G*."""
    indentation: FloatArray
    """(j,) in m where all coordinates are 0."""
    normal: FloatArray
    """(j, n + m) coefficients of the indentation."""
    tangential: FloatArray
    """(j, n + m) coefficients of the shift."""


class System(NamedTuple):
    """Masses, springs, forces and drives; free coordinates come before driven ones. All in SI units."""

    mass: FloatArray
    """(n,)."""
    position: FloatArray
    """(n,) at time 0."""
    velocity: FloatArray
    """(n,) at time 0."""
    push: FloatArray
    """(n,) constant forces."""
    force_waves: FloatArray
    """(k, 4) coordinate, amplitude, angular frequency and phase of a force."""
    course: FloatArray
    """(m, 2) position and speed of the driven coordinates at time 0."""
    drive_waves: FloatArray
    """(k, 4) driven coordinate, amplitude, angular frequency and phase of a position."""
    springs: FloatArray
    """(s, 3 + n + m) stiffness, damping, elongation where all coordinates are 0, and its coefficients."""
    joints: Joints


class Followed(NamedTuple):
    """Rows of a motion, the first at time 0."""

    position: FloatArray
    """(rows, n + m)."""
    velocity: FloatArray
    """(rows, n)."""
    joints: FloatArray
    """(rows, j, 6) columns of :mod:`pymdr.line.motion.layout`."""
    energies: FloatArray
    """(rows, 8) energies of the state, then sums over the steps."""
    outcome: Outcome
    steps: int
    """Steps that were taken."""


def follow_motion(system: System, step: float, rows: int, parts: int) -> Followed:
    r"""
    Integrate :math:`m \ddot x = F` by steps whose mean force is the change of the energies over the way.

    .. math:: M (v_1 - v_0) = h \bar F, \quad x_1 - x_0 = \tfrac{h}{2} (v_0 + v_1), \quad \bar F_N = \frac{U(d_1) - U(d_0)}{d_1 - d_0}

    and likewise for the shift, with the energy stored by it and dissipated by slip along the straight step. Energies are conserved to
    rounding for every step; the error of the motion is of second order; contact, slip and separation need no search for events.

    Parameters
    ----------
    step : float
        h in s.
    rows, parts : int
        Number of rows after the first, and steps of each.

    Returns
    -------
    Followed
        Up to the row at which it ended.

    Notes
    -----
    Gonzalez (1996), J. Nonlinear Sci. 6, 449-467.

    Examples
    --------
    >>> none = Joints((), *np.zeros((3, 0)), np.zeros((0, 1)), np.zeros((0, 1)))
    >>> one = np.ones(1)
    >>> spring = np.array([[1.0, 0.0, 0.0, 1.0]])
    >>> waves = np.zeros((0, 4))
    >>> system = System(one, 0 * one, one, 0 * one, waves, np.zeros((0, 2)), waves, spring, none)
    >>> followed = follow_motion(system, 1e-3, 1, 1000)
    >>> bool(abs(followed.position[-1, 0] - np.sin(1.0)) < 1e-7)
    True
    """
    from pymdr.line.motion import kernels

    body, state = _coefficients(system), _start(system)
    n, count, joints = system.mass.size, state.position.shape[1], len(system.joints.curves)
    out = np.zeros((rows + 1, count + n + 6 * joints + 8))
    code, taken = kernels.run(body, state, out, float(step), parts, 0)
    while code == STACK_FULL:
        state = _with_larger_stacks(state)
        code, taken = kernels.run(body, state, out, float(step), parts, taken)
    out = out[: 1 + taken // parts]
    at = count + n
    return Followed(
        out[:, :count],
        out[:, count:at],
        out[:, at : at + 6 * joints].reshape(len(out), joints, 6),
        out[:, at + 6 * joints :],
        OUTCOMES[code],
        taken,
    )


def _coefficients(system: System) -> Any:
    """The system as the kernels read it."""
    from pymdr.line.motion.kernels import Body

    joints = system.joints
    states = [
        virgin_state(mu or 1.0, ratio)
        for mu, ratio in zip(joints.friction, joints.modulus_ratio, strict=True)
    ]
    scales = [[s.traction_scale, s.energy_scale, s.shift_scale] for s in states]
    tables = [curves.rows for curves in joints.curves]
    ends = np.cumsum([0, *(len(rows) for rows in tables)])
    arrays: dict[str, Any] = {name: np.array(getattr(system, name), dtype=float) for name in Body._fields[:6]}
    return Body(
        **arrays,
        normal=np.column_stack([joints.indentation, joints.normal]),
        tangential=np.array(joints.tangential, dtype=float),
        lines=np.concatenate(tables) if tables else np.zeros((0, 1)),
        ends=np.column_stack([ends[:-1], ends[1:]]),
        scales=np.array(scales).reshape(-1, 3),
        slips=np.logical_and(joints.friction > 0.0, np.any(joints.tangential != 0.0, axis=1)),
        first=_first_linked(system),
    )


def _first_linked(system: System) -> Any:
    """The first coordinate that each is linked to: the factor of the matrix of a step is 0 before it."""
    n = system.mass.size
    first = np.arange(n)
    for arms in (*system.springs[:, 3:], *system.joints.normal, *system.joints.tangential):
        among = np.flatnonzero(arms[:n])
        first[among] = np.minimum(first[among], among[:1])
    return first


def _start(system: System) -> Any:
    """The state at time 0, before the joints touch."""
    from pymdr.line.friction.kernels import VERTEX
    from pymdr.line.friction.layout import TOP
    from pymdr.line.motion.kernels import State

    n, joints = system.mass.size, len(system.joints.curves)
    driven = system.course[:, 0].copy()
    for i, amplitude, _, phase in system.drive_waves:
        driven[int(i)] += amplitude * np.sin(phase)
    position, velocity = np.zeros((2, n + driven.size)), np.zeros((3, n))
    position[0, :n], position[0, n:], velocity[0] = system.position, driven, system.velocity
    vertices = np.zeros((joints, 2, _CAPACITY), dtype=VERTEX)
    vertices["low"][:, :, 0], vertices["high"][:, :, 0] = -np.inf, np.inf
    return State(
        position,
        velocity,
        np.zeros((joints, 2, 6)),
        np.zeros((joints, 2, 3)),
        vertices,
        np.zeros((joints, 2, TOP + 1)),
        np.zeros((4, n + driven.size)),
        np.zeros((n, n)),
        np.zeros(n),
        np.zeros((2, 4)),
    )


def _with_larger_stacks(state: Any) -> Any:
    """Twice the room for vertices."""
    joints, both, capacity = state.vertices.shape
    larger = np.zeros((joints, both, 2 * capacity), dtype=state.vertices.dtype)
    larger[:, :, :capacity] = state.vertices
    return state._replace(vertices=larger)
