"""A spring with memory under a periodic rough line: its stationary forces, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pymdr.compiling import compiled
from pymdr.errors import ConvergenceError
from pymdr.line.memory.kernels import (
    MODULUS,
    PART_CROSS,
    PART_DECAY,
    PART_MEAN,
    PART_MOVED,
    PART_OWN,
    Body,
    body_of,
    fill,
)
from pymdr.problem.spectra import Relaxation
from pymdr.units import FloatArray

_SETTLED = 1e-12
_PROBE = 1e-6
_STEPS = 60


class Stationary(NamedTuple):
    """Means over a passage."""

    pressure: float
    """The mean of q in N/m."""
    drag: float
    """The mean of q z' in N/m."""


@compiled
def _passage(
    heights: FloatArray, depth: float, dashpot: float, body: Body, state: FloatArray, sums: FloatArray
) -> tuple[float, float]:
    """
    One passage from a state (terms, then the deflection), which is updated; sums of w and of the dissipation.

    `sums` accumulates the terms before every step.
    """
    terms, branch, equilibrium = body.branches, body.table, body.equilibrium
    stiff = equilibrium + dashpot
    for i in range(terms):
        stiff += branch[i, MODULUS] * branch[i, PART_MEAN]
    w = state[terms]
    total = dissipated = 0.0
    for j in range(heights.size):
        bears = equilibrium * w
        for i in range(terms):
            sums[i] += state[i]
            bears += branch[i, PART_DECAY] * state[i]
        move = max(depth + heights[j] - w, -bears / stiff)
        w += move
        for i in range(terms):
            h, elastic = state[i], branch[i, MODULUS] * move
            dissipated += (
                branch[i, PART_OWN] * h * h
                + elastic * (2.0 * branch[i, PART_CROSS] * h + branch[i, PART_MOVED] * elastic)
            ) / branch[i, MODULUS]
            state[i] = branch[i, PART_DECAY] * h + branch[i, PART_MEAN] * elastic
        dissipated += dashpot * move * move
        total += w
    state[terms] = w
    return total, dissipated


def stationary(
    heights: FloatArray, length: float, depth: float, relaxation: Relaxation, speed: float
) -> Stationary:
    """
    Means over a rough line that slides steadily over springs with memory, in contact where they touch it.

    Parameters
    ----------
    heights : ndarray
        z in m at even places of a line that repeats itself.
    length : float
        Of the line in m.
    depth : float
        By how much its mean lies below the surface in m.
    relaxation : Relaxation
        E*(t) in Pa, with an equilibrium above 0.
    speed : float
        In m/s.

    Raises
    ------
    ConvergenceError
        If no state of the springs is the same again after a passage.

    Notes
    -----
    Every spring passes over the same line, one after the other: the mean over springs is the time mean of one. Exact in time for a
    straight line between places. What its terms bear at the highest place is found by Newton's method, however slow they are: over
    a passage, after which w is what it was, a term changes by what it loses, which is as its sum. The mean of q is E*_inf times
    that of w, whatever relaxes, and what a passage takes is dissipated.
    """
    step = length / heights.size
    dt = step / speed
    terms = relaxation.times.size
    body = body_of(relaxation)
    fill(dt, body)
    fades = -np.expm1(-dt / relaxation.times)
    passed = -np.expm1(-length / (speed * relaxation.times))
    dashpot = relaxation.viscosity / dt
    # start at the highest point, whose height the springs have
    around = np.roll(heights, -1 - int(np.argmax(heights)))
    deepest = depth + float(around[-1])
    if deepest <= 0.0:
        return Stationary(0.0, 0.0)

    def passage(start: FloatArray) -> tuple[FloatArray, float, float]:
        """Change of the terms by a passage, and its sums."""
        state, sums = np.append(start, deepest), np.zeros(terms)
        total, dissipated = _passage(around, depth, dashpot, body, state, sums)
        # the difference cancels if little relaxes in a passage
        changed = np.where(passed > 0.5, state[:terms] - start, -fades * sums)
        return changed / passed, total, dissipated

    size = relaxation.equilibrium + float((relaxation.moduli * body.table[:, PART_MEAN]).sum())
    size *= float(np.ptp(heights)) + deepest
    start = np.zeros(terms)
    missed, total, dissipated = passage(start)
    for _ in range(_STEPS):
        if float(np.max(np.abs(missed), initial=0.0)) <= _SETTLED * size:
            return Stationary(relaxation.equilibrium * total / heights.size, dissipated / length)
        probe = _PROBE * size
        slopes = np.array([(passage(start + probe * unit)[0] - missed) / probe for unit in np.eye(terms)]).T
        move = np.linalg.solve(slopes, -missed)
        for damping in 0.5 ** np.arange(12.0):
            residual, total, dissipated = passage(start + damping * move)
            if np.max(np.abs(residual)) < np.max(np.abs(missed)):
                break
        start, missed = start + damping * move, residual
    raise ConvergenceError(
        f"the springs under a rough line did not reach a steady state at {speed:g} m/s in {_STEPS} iterations; increase the load, or use a shorter line"
    )
