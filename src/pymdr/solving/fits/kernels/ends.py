"""What else fits as well, where a pull stands in a few samples. Loads numba."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pymdr.solving.fits.forces import FULLY_OUT
from pymdr.solving.fits.kernels.descent import ITERATIONS, descend
from pymdr.solving.fits.kernels.model import ALL, SHAPE, Family, compiled
from pymdr.units import FloatArray

POORLY, ASIDES, NORMAL_95 = 20, np.array([-0.8, -0.5, -0.3, -0.15, 0.15, 0.3, 0.5, 0.8]), 1.96
"""Samples of a pull that are few; other starts there, in the logarithm of the number of the family."""


@compiled
def pulling(touches: NDArray[np.bool_], model: FloatArray) -> int:
    """How many samples stand in the pull: touch with a third of its largest at least."""
    lowest, count = 0.0, 0
    for i in range(model.size):
        if touches[i]:
            lowest = min(lowest, model[i])
    for i in range(model.size):
        if touches[i] and model[i] < FULLY_OUT * lowest:
            count += 1
    return count


@compiled
def ways_without_shape(ways: FloatArray) -> FloatArray:
    """Ways of the numbers that leave that of the family as it is."""
    held, kept = np.zeros((ALL, ways.shape[1])), 0
    for p in range(ways.shape[1]):
        if ways[SHAPE, p] == 0.0:
            held[:, kept] = ways[:, p]
            kept += 1
    return held[:, :kept].copy()


@compiled
def other_ends(
    place: FloatArray,
    force: FloatArray,
    theta: FloatArray,
    ways: FloatArray,
    family: Family,
    softness: float,
    enough: float,
    misfit: float,
    square: FloatArray,
    touches: NDArray[np.bool_],
    out: FloatArray,
    apart: FloatArray,
) -> float:
    """
    The smallest sum of squares with numbers of the family on both sides, which is left in the arrays.

    Where a pull stands in a few samples, each that is taken for held or lost is a step in the misfit, which its curvature does not
    tell. How far the farthest number lies that fits as well, within the 95 % of one number, is left in `apart`.
    """
    n, held = place.size, ways_without_shape(ways)
    everything = np.ones(n, dtype=np.bool_)
    ends, values = np.empty((ASIDES.size, ALL)), np.empty(ASIDES.size)
    other_square, held_square = square.copy(), np.empty((held.shape[1], held.shape[1]))
    other_touches, other_out, trial = touches.copy(), out.copy(), theta.copy()
    begun = theta.copy()
    for k in range(ASIDES.size):
        ends[k], values[k] = begun, math.inf
        ends[k, SHAPE] += ASIDES[k]
        if not family[3] <= ends[k, SHAPE] <= family[3] + family[4] * (family[2].size - 1):
            continue
        values[k], _ = descend(
            place, force, everything, ends[k], held, family, softness, ITERATIONS, enough, held_square,
            other_touches, other_out,
        )  # fmt: skip
        if values[k] < misfit:
            trial[:] = ends[k]
            found, _ = descend(
                place, force, everything, trial, ways, family, softness, ITERATIONS, enough, other_square,
                other_touches, other_out,
            )  # fmt: skip
            if found < misfit:
                misfit = found
                theta[:], square[:, :] = trial, other_square
                touches[:], out[:, :] = other_touches, other_out
    for k in range(values.size):
        as_well = values[k] <= misfit * (1.0 + NORMAL_95**2 / n)
        if as_well and abs(ends[k, SHAPE] - theta[SHAPE]) > abs(apart[SHAPE]):
            apart[:] = ends[k] - theta
    return misfit
