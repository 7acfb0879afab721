"""The line of springs of Popov and Hess with Coulomb's limit, as the method is taught."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pymdr.line.friction.state import frozen
from pymdr.units import FloatArray


class SpringHistory(NamedTuple):
    """Results of the springs, one entry per row."""

    tangential_force: FloatArray
    """F_x in N."""
    stick_radius: FloatArray
    """Half the length of the line below Coulomb's limit, in m."""
    stored_energy: FloatArray
    """Energy of the springs in J."""
    slip_work: FloatArray
    """Work of friction so far in J."""


def springs(
    profile: ArrayLike,
    spacing: float,
    indentation: ArrayLike,
    shift: ArrayLike,
    friction: float,
    modulus: float,
    tangential_modulus: float,
) -> SpringHistory:
    """
    Follow rows of (indentation, shift) with springs of stiffness G* dx and the cap mu E* dx (d - g).

    A spring that touches within a row takes only the part of the shift after its touch; a spring over its cap is
    set back to it, also when the cap falls; a spring that parts loses its shift. Every step is exact for a spring:
    the force errs by the midpoint rule, O(1/N^2) for N springs.

    Parameters
    ----------
    profile : array_like, shape (N,)
        g(x) in m of the springs on one side, at x = (j + 1/2) dx. Both sides are counted.
    spacing : float
        dx in m.
    indentation, shift : array_like, shape (n,)
        d and u_x in m; the first row is reached from (0, 0).
    friction : float
        mu; 0 and infinite are allowed.
    modulus, tangential_modulus : float
        E* and G* in Pa.

    Notes
    -----
    Popov and Hess (2015), chapter 5, in one direction.

    Examples
    --------
    >>> x = (np.arange(2000) + 0.5) / 2000
    >>> round(float(springs(x**2, 1 / 2000, [0.5, 0.5], [0.0, 0.25], 1.0, 1.0, 1.0).tangential_force[1]), 5)
    0.30474
    """
    from pymdr.line.friction.noslip import run_springs

    depth, moved = frozen(indentation), frozen(shift)
    out = np.zeros((4, depth.size))
    if friction > 0.0:
        mu = friction if math.isfinite(friction) else 1.0
        ratio = mu * modulus / tangential_modulus
        labels = frozen(profile)
        sticks = not math.isfinite(friction)
        run_springs(labels, np.zeros(labels.size), depth, moved, 1.0 / ratio, sticks, out)
        out[0] *= 2.0 * spacing * mu * modulus
        out[1] *= spacing
        out[2:] *= 2.0 * spacing * mu * modulus * ratio
    return SpringHistory(out[0], out[1], out[2], out[3])
