"""A spring with memory that a rough line passes again and again: its stationary forces, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pymdr.compiling import compiled
from pymdr.errors import ConvergenceError
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
    heights: FloatArray,
    depth: float,
    equilibrium: float,
    dashpot: float,
    kept: FloatArray,
    fresh: FloatArray,
    state: FloatArray,
) -> tuple[float, float]:
    """One passage from a state (terms, then the deflection and q of the springs), which it leaves behind; sums of q and q dw."""
    terms = kept.size
    stiff = equilibrium + dashpot
    for i in range(terms):
        stiff += fresh[i]
    w, rest = state[terms], state[terms + 1]
    load = work = 0.0
    for j in range(heights.size):
        bears = equilibrium * w
        for i in range(terms):
            state[i] *= kept[i]
            bears += state[i]
        move = max(depth + heights[j] - w, -bears / stiff)
        w += move
        springs = equilibrium * w
        for i in range(terms):
            state[i] += fresh[i] * move
            springs += state[i]
        flow = dashpot * move
        load += 0.5 * (rest + springs) + flow
        work += (0.5 * (rest + springs) + flow) * move
        rest = springs
    state[terms], state[terms + 1] = w, rest
    return load, work


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

    Returns
    -------
    Stationary

    Raises
    ------
    ConvergenceError
        If no state of the springs is the same again after a passage.

    Notes
    -----
    Every spring sees the same line, one after the other: the mean over springs is that over the time of one. Exact in time for a
    straight line between places. What its terms bear at the highest place is found by Newton's method, however slow they are. The mean
    of q is E*_inf times that of w, whatever relaxes.
    """
    step = length / heights.size
    dt = step / speed
    kept = np.exp(-dt / relaxation.times)
    passed = -np.expm1(-length / (speed * relaxation.times))
    fresh = relaxation.moduli * -np.expm1(-dt / relaxation.times) * relaxation.times / dt
    dashpot = relaxation.viscosity / dt
    # from the highest place on, where springs are as deep as it is
    around = np.roll(heights, -1 - int(np.argmax(heights)))
    deepest = depth + float(around[-1])
    if deepest <= 0.0:
        return Stationary(0.0, 0.0)
    terms = kept.size

    def passage(start: FloatArray) -> tuple[FloatArray, float, float]:
        """By how much terms would still change, and the sums of a passage."""
        state = np.append(start, [deepest, relaxation.equilibrium * deepest + float(start.sum())])
        load, work = _passage(around, depth, relaxation.equilibrium, dashpot, kept, fresh, state)
        return (state[:terms] - start) / passed, load, work

    size = relaxation.glassy if relaxation.viscosity == 0.0 else relaxation.equilibrium + float(fresh.sum())
    size *= float(np.ptp(heights)) + deepest
    start = np.zeros(terms)
    missed, load, work = passage(start)
    for _ in range(_STEPS):
        if float(np.max(np.abs(missed), initial=0.0)) <= _SETTLED * size:
            return Stationary(load / heights.size, work / length)
        probe = _PROBE * size
        slopes = np.array([(passage(start + probe * unit)[0] - missed) / probe for unit in np.eye(terms)]).T
        move = np.linalg.solve(slopes, -missed)
        for share in 0.5 ** np.arange(12.0):
            found, load, work = passage(start + share * move)
            if np.max(np.abs(found)) < np.max(np.abs(missed)):
                break
        start, missed = start + share * move, found
    raise ConvergenceError(
        f"no stationary state of the springs under a rough line was found at {speed:g} m/s"
    )
