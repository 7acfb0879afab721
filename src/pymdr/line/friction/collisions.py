"""Tangential motion of a mass against friction at given indentations. Loads numba when it runs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import PathError
from pymdr.line.friction.curves import ElasticCurves
from pymdr.line.friction.driver import ENDINGS
from pymdr.line.friction.layout import COMPLETE
from pymdr.line.friction.state import frozen, virgin_state
from pymdr.units import FloatArray


class TangentialMotion(NamedTuple):
    """The tangential motion, one entry per row."""

    tangential_force: FloatArray
    """F_x in N, which slows the mass down."""
    stick_radius: FloatArray
    """In m."""
    stored_energy: FloatArray
    """Of the tangential springs in J."""
    slip_work: FloatArray
    """Work of friction so far in J."""
    shift: FloatArray
    """In m."""
    velocity: FloatArray
    """In m/s."""


def follow_collision(
    curves: ElasticCurves,
    indentation: ArrayLike,
    time: ArrayLike,
    mass: float,
    velocity: float,
    friction: float,
    tangential_modulus: float,
) -> TangentialMotion:
    """
    Follow m u_x'' = -F_x while the indentation is given, by velocity Verlet: its errors fall like the square of a step.

    Parameters
    ----------
    indentation, time : array_like, shape (n,)
        d in m and t in s; the first row is that of the touch.
    mass : float
        In kg.
    velocity : float
        Of the first row in m/s.
    friction : float
        Mu, above 0 and finite.
    tangential_modulus : float
        G* in Pa.

    Raises
    ------
    PathError
        If an indentation is deeper than the curves.

    Examples
    --------
    >>> from pymdr.line.friction import power_law_curves
    >>> t = np.linspace(0.0, 1.0, 11)
    >>> slid = follow_collision(power_law_curves(2.0, 1.0, 1.0), 0.1 * t, t, 1e9, 1.0, 0.3, 1.0)
    >>> bool(abs(slid.tangential_force[-1] / (0.3 * 4 / 3 * 0.1**1.5) - 1) < 1e-12)
    True
    """
    from pymdr.line.friction import kernels, runs

    state = virgin_state(friction, curves.modulus / tangential_modulus)
    mu = state.traction_scale
    scales = runs.Scales(float(mu), mu * mu * state.modulus_ratio, state.shift_scale)
    d, t = frozen(indentation), frozen(time)
    out = np.zeros((5, d.size))
    # a step puts one vertex on the stack at most
    stack = np.zeros(d.size + 64, dtype=kernels.VERTEX)
    kernels.clear(stack, 0.0)
    anchors = kernels.Anchors(curves.rows, stack, np.zeros(6))
    run = runs.Run(anchors, out, np.zeros(0, dtype=np.int64), True, scales)
    speed = np.full(d.size, float(velocity))
    code = runs.run_collision(run, d, t, float(mass), speed)
    if code != COMPLETE:
        raise PathError(f"the impact cannot be followed: {ENDINGS[code].value}")
    return TangentialMotion(out[0], out[1], out[2], out[3], out[4], speed)
