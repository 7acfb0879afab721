"""The motion m d'' = -F of a mass on springs with memory, from the touch to the separation."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.line.friction import ElasticCurves
from pymdr.mapping.relaxation import Relaxation
from pymdr.units import FloatArray

if TYPE_CHECKING:
    from pymdr.line.rebound.kernels import Body, Track

_TOLERANCE = 1e-9
_MOST = 4000


class Motion(NamedTuple):
    """The steps of a motion, and what the line remembers at the begin of each."""

    curves: ElasticCurves
    relaxation: Relaxation
    mass: float
    """In kg."""
    steps: FloatArray
    """(n + 1, k) begin, length, depth, and the terms of speed and of k(d) d' over a step."""
    pulls: FloatArray
    """(n + 1, branches) int exp(-(t - s)/tau) dd(s) in m."""
    forces: FloatArray
    """(n + 1, branches) int E exp(-(t - s)/tau) dF0(s) in N, up to the turning point."""
    turn: int
    """Steps before the turning point."""
    rests: bool
    """Whether the mass comes to rest in a liquid, and never leaves."""

    @property
    def turning_time(self) -> float:
        """In s since the touch."""
        return float(self.steps[self.turn, 0])

    @property
    def deepest(self) -> float:
        """The largest indentation in m."""
        return float(self.steps[self.turn, 2])

    @property
    def contact_time(self) -> float:
        """In s; inf of a mass that comes to rest."""
        return math.inf if self.rests else float(self.steps[-1, 0])

    @property
    def last_depth(self) -> float:
        """The indentation in m at which the bodies part."""
        return float(self.steps[-1, 2])

    @property
    def rebound_speed(self) -> float:
        """In m/s, no more than that of the touch, beyond which steps err; 0 of a mass that comes to rest."""
        return 0.0 if self.rests else min(-float(self.steps[-1, 3]), float(self.steps[0, 3]))


class MotionRows(NamedTuple):
    """One entry per row."""

    depth: FloatArray
    """In m."""
    velocity: FloatArray
    """In m/s, above 0 on the approach."""
    force: FloatArray
    """In N."""
    radius: FloatArray
    """In m."""
    touched: FloatArray
    """T1 in s, at which the edge was touched; 0 without contact."""


def rebound(
    curves: ElasticCurves,
    relaxation: Relaxation,
    mass: float,
    speed: float,
    first: float,
    *,
    halved: Motion | None = None,
) -> Motion | None:
    """
    Follow a mass from the touch to the separation.

    Springs with memory only push, so that d'' <= 0: there is one approach and one retreat, and on the retreat a spring
    that has parted is never touched again. The force is therefore Lee and Radok's, F = int E*(t - s) dF0(d(s)), up to the
    turning point, and Ting's after it, with the integral ended at the t1 for which int_t1^t E*(t - s) dd(s) = 0.

    Parameters
    ----------
    curves : ElasticCurves
        Per unit modulus.
    relaxation : Relaxation
        E*(t).
    mass, speed : float
        In kg and m/s.
    first : float
        About a twentieth of the time in s in which the force grows.
    halved : Motion, optional
        The same motion, each of whose steps is to be divided in two.

    Returns
    -------
    Motion or None
        None if the curves end before the mass comes to rest.

    Raises
    ------
    ConvergenceError
        If a step is not solved.

    Notes
    -----
    Lee and Radok (1960); Ting (1966). That no spring is touched again: with E falling and d' falling in time,
    d/dt int_t1^t E(t - s) dd(s) = E(0) d'(t) + int E'(t - s) dd(s) <= E(t - t1) d'(t) < 0 on the retreat and after it.

    Examples
    --------
    >>> from pymdr.line.friction import power_law_curves
    >>> ball = power_law_curves(2.0, 1.0, 1.0)
    >>> hit = rebound(ball, Relaxation(4.0, viscosity=0.04), 1.0, 1.0, 0.02)
    >>> round(hit.rebound_speed, 9)
    0.967113381
    """
    from pymdr.line.rebound import kernels

    n = relaxation.moduli.size
    given = np.zeros(0)
    if halved is not None:
        lengths = np.repeat(0.5 * halved.steps[:-1, 1], 2)
        given = np.concatenate([[2.0 * halved.turn], lengths])
    most = _MOST if halved is None else 2 * halved.steps.shape[0] + 64
    track = kernels.Track(*(np.zeros((most, k)) for k in (kernels.COLUMNS, n, n)))
    track.steps[0, kernels.SPEED] = speed
    body = _body(curves, relaxation, mass)
    code, turn, count = kernels.run(body, track, float(first), _TOLERANCE, given, kernels.workspace())
    if code == kernels.TOO_DEEP:
        return None
    if code not in (kernels.COMPLETE, kernels.RESTS):
        at = track.steps[count]
        raise ConvergenceError(
            f"the impact cannot be followed beyond t = {at[0]:g} s at d = {at[2]:g} m: "
            + (
                f"more than {most} steps are needed; use fewer or longer relaxation times"
                if code == kernels.TOO_MANY
                else "the equations of a step have no solution; check the magnitudes of mass, speed and moduli"
            )
        )
    rows = slice(0, count + 1)
    rests = code == kernels.RESTS
    steps, pulls, forces = (part[rows].copy() for part in track)
    return Motion(curves, relaxation, mass, steps, pulls, forces, turn, rests)


def motion_rows(motion: Motion, time: FloatArray) -> MotionRows:
    """
    A motion at times in s.

    Parameters
    ----------
    time : ndarray, shape (m,)
        Rising, from 0 to the contact time.
    """
    from pymdr.line.rebound import kernels

    out = np.zeros((time.size, kernels.READ))
    kernels.read(*_followed(motion), np.array(time, dtype=float), out, kernels.workspace())
    return MotionRows(*out.T.copy())


def branches(motion: Motion, time: FloatArray) -> FloatArray:
    """The integrals int exp(-(t - s)/tau) dd(s) in m at rising times in s, shape (m, branches)."""
    from pymdr.line.rebound import kernels

    out = np.zeros((time.size, motion.relaxation.times.size))
    body, track, _, count = _followed(motion)
    kernels.extended(body.times, track, count, np.array(time, dtype=float), out, kernels.workspace().part)
    return out


def largest_force(motion: Motion) -> tuple[float, float]:
    """Time in s and size in N of the largest force of a motion."""
    from pymdr.line.rebound import kernels

    when, most = kernels.hardest(*_followed(motion), kernels.workspace())
    return float(when), float(most)


def _body(curves: ElasticCurves, relaxation: Relaxation, mass: float) -> Body:
    """What the kernels know of a body; they compile anew for arrays that cannot be written."""
    from pymdr.line.rebound.kernels import body_of

    moduli, times = relaxation.moduli.copy(), relaxation.times.copy()
    e = float(relaxation.equilibrium), float(relaxation.viscosity)
    return body_of(curves.rows, moduli, times, e, float(mass))


def _followed(motion: Motion) -> tuple[Body, Track, int, int]:
    """The body, the steps, and how many they are up to the turning point and in all."""
    from pymdr.line.rebound.kernels import Track

    track = Track(motion.steps, motion.pulls, motion.forces)
    body = _body(motion.curves, motion.relaxation, motion.mass)
    return body, track, motion.turn, motion.steps.shape[0] - 1
