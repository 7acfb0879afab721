"""Forces of one member of a family, and their rates. Loads numba."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pymdr import compiling
from pymdr.solving.fits.forces import BEYOND
from pymdr.units import FloatArray

_STAMP = compiling.stamp_of(__file__)


def compiled(function: compiling.Function) -> compiling.Function:
    """Compile with numba when first called; kept on disk. Products and sums may be fused, nothing else."""
    return compiling.compiled(function, stamp=_STAMP, fastmath={"contract"})


Family = tuple[FloatArray, FloatArray, FloatArray, float, float, float]
"""Forces and their slopes over the root of the depth, one rung in each row; folds in m; the first logarithm and the step of the
rungs; the deepest depth in m."""
SCALE, SHAPE, POINT, BASE = range(4)
"""Columns: logarithms of the scale of the forces and of the number in which the family differs, contact point in m, and
baseline in N."""
OUTSIDE = 1.02
"""Of the reach of the family in the root of the depth."""
NEWTON, CLOSE = 30, 1e-8
"""The error left is the square of the last step."""
UNKNOWN = -1.0
"""A root that was not found yet."""


@compiled
def member_at(
    forces: FloatArray,
    slopes: FloatArray,
    folds: FloatArray,
    first: float,
    step: float,
    at: float,
    out: FloatArray,
) -> tuple[float, float]:
    """
    The member of the family at one logarithm: its fold and the rate of the fold.

    Forces, their slopes over the root, and the rates of both stand in the rows of `out`; cubic in the logarithm.
    """
    rungs = folds.size
    if rungs == 1:
        out[0], out[1], out[2], out[3] = forces[0], slopes[0], 0.0, 0.0
        return folds[0], 0.0
    k = min(max(int((at - first) / step) - 1, 0), rungs - 4)
    t = (at - first) / step - k
    weight, rate = np.empty(4), np.empty(4)
    for i in range(4):
        w, r = 1.0, 0.0
        for j in range(4):
            if j != i:
                r = r * (t - j) / (i - j) + w / (i - j)
                w *= (t - j) / (i - j)
        weight[i], rate[i] = w, r / step
    fold, fold_rate = 0.0, 0.0
    for i in range(4):
        # powers of the number, near enough
        part = math.log(-folds[k + i]) if folds[0] < 0.0 else folds[k + i]
        fold += weight[i] * part
        fold_rate += rate[i] * part
    if folds[0] < 0.0:
        fold = -math.exp(fold)
        fold_rate *= fold
    for j in range(forces.shape[1]):
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        for i in range(4):
            a += weight[i] * forces[k + i, j]
            b += weight[i] * slopes[k + i, j]
            c += rate[i] * forces[k + i, j]
            d += rate[i] * slopes[k + i, j]
        out[0, j], out[1, j], out[2, j], out[3, j] = a, b, c, d
    return fold, fold_rate


@compiled
def read(values: FloatArray, slopes: FloatArray, r: float) -> tuple[float, float]:
    """Value and slope at a root between 0 and 1, by the cubic of Hermite."""
    cells = values.size - 1
    x = r * cells
    j = min(int(x), cells - 1)
    t, h = x - j, 1.0 / cells
    a, b = values[j], values[j + 1]
    u, v = slopes[j] * h, slopes[j + 1] * h
    c3 = 2.0 * (a - b) + u + v
    c2 = 3.0 * (b - a) - 2.0 * u - v
    return a + t * (u + t * (c2 + t * c3)), (u + t * (2.0 * c2 + 3.0 * t * c3)) / h


@compiled
def _first_root(row: FloatArray, reach: float, soft: float) -> float:
    """The root at which the machine lets go: where the travel reach r^2 + soft F(r) is smallest."""
    if soft == 0.0:
        return 0.0
    cells = row.shape[1] - 1
    best, where = math.inf, 0
    for j in range(cells + 1):
        r = j / cells
        travel = reach * r * r + soft * row[0, j]
        if travel < best:
            best, where = travel, j
    low, high = max(where - 1, 0) / cells, min((where + 1) / cells, 1.0)
    for _ in range(50):
        middle = 0.5 * (low + high)
        if 2.0 * reach * middle + soft * read(row[0], row[1], middle)[1] < 0.0:
            low = middle
        else:
            high = middle
    return float(0.5 * (low + high))


@compiled
def _turn(gain: FloatArray, first: int, last: int, way: int) -> int:
    """The sample, going from `first` to before `last`, up to which being in contact fits best."""
    total, best, where = 0.0, 0.0, first - way
    i = first
    while i != last:
        total += gain[i]
        if total > best:
            best, where = total, i
        i += way
    return where


@compiled
def model_of(
    place: FloatArray,
    force: FloatArray,
    theta: FloatArray,
    member: tuple[FloatArray, float, float, float],
    softness: float,
    root: FloatArray,
    gain: FloatArray,
    out: FloatArray,
    touches: NDArray[np.bool_],
) -> None:
    """Forces of the model and their rates over scale, shape and contact point, in the columns of `out`, and what touches."""
    row, fold, fold_rate, deepest = member
    scale, reach = math.exp(theta[SCALE]), deepest - fold
    soft = softness * scale
    start = _first_root(row, reach, soft)
    first_travel = fold + reach * start * start + soft * read(row[0], row[1], start)[0]
    deepest_at = 0
    for i in range(place.size):
        if place[i] > place[deepest_at]:
            deepest_at = i
        travel = place[i] - theta[POINT]
        r = start
        if travel > first_travel:
            if soft == 0.0:
                r = min(math.sqrt((travel - fold) / reach), OUTSIDE)
            else:
                r = min(max(root[i] if root[i] >= 0.0 else root[i - 1], start + 1e-9), OUTSIDE)
                for _ in range(NEWTON):
                    value, slope = read(row[0], row[1], r)
                    off = fold + reach * r * r + soft * value - travel
                    moved = r - off / max(2.0 * reach * r + soft * slope, 1e-6 * reach)
                    moved = min(max(moved, 0.5 * (r + start)), OUTSIDE)
                    done = abs(moved - r) < CLOSE
                    r = moved
                    if done:
                        break
        root[i] = r
        value, slope = read(row[0], row[1], r)
        over_shape, _ = read(row[2], row[3], r)
        out[i, 0] = scale * value
        if travel > first_travel:
            stretch = 2.0 * reach * max(r, 1e-4) + soft * slope
            share = scale * slope / max(stretch, 1e-4 * reach)
            out[i, 1] = scale * value - share * soft * value
            out[i, 2] = scale * over_shape - share * (fold_rate * (1.0 - r * r) + soft * over_shape)
            out[i, 3] = -share
        else:
            out[i, 1], out[i, 2], out[i, 3] = scale * value, scale * over_shape, 0.0
        touches[i] = travel > 0.0
        gain[i] = 0.0
        if -first_travel >= travel >= (1.0 + BEYOND) * first_travel and first_travel < 0.0:
            measured = force[i] - theta[BASE]
            gain[i] = measured * measured - (measured - out[i, 0]) ** 2
    if first_travel < 0.0:
        before = _turn(gain, deepest_at - 1, -1, -1)
        after = _turn(gain, deepest_at + 1, place.size, 1)
        for i in range(place.size):
            travel = place[i] - theta[POINT]
            if -first_travel >= travel >= (1.0 + BEYOND) * first_travel:
                touches[i] = before <= i <= after
    for i in range(place.size):
        if not touches[i]:
            out[i, 0], out[i, 1], out[i, 2], out[i, 3] = 0.0, 0.0, 0.0, 0.0
