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
SCALE, SHAPE, POINT, BASE, TILT = range(5)
"""Columns: logarithms of the scale of the forces and of the number in which the family differs, contact point in m, baseline in N, and
its tilt in N/m about the origin of the places."""
ALL = 5
OUTSIDE = 1.02
"""Of the reach of the family in the root of the depth."""
_NEWTON, _CLOSE = 30, 1e-6
"""The error left is the square of the last step."""

Machine = tuple[FloatArray, float, float, float, int]
"""Travels in m at the ends of the cells of a member; the root at which the machine lets go, the travel there, its rate, and the cell."""


@compiled
def member_at(
    forces: FloatArray,
    slopes: FloatArray,
    folds: FloatArray,
    first: float,
    step: float,
    at: float,
    values: FloatArray,
    rises: FloatArray,
) -> tuple[float, float]:
    """
    The member of the family at one logarithm: its fold and the rate of the fold.

    Forces and their rates over the logarithm stand in the rows of `values`, those of their slopes over the root in `rises`; cubic in
    the logarithm.
    """
    rungs = folds.size
    if rungs == 1:
        values[0], values[1], rises[0], rises[1] = forces[0], 0.0, slopes[0], 0.0
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
        values[0, j], values[1, j], rises[0, j], rises[1, j] = a, c, b, d
    return fold, fold_rate


@compiled
def read(values: FloatArray, slopes: FloatArray, k: int, r: float) -> tuple[float, float, float]:
    """Value, slope and bend of a row at a root between 0 and 1, by the cubic of Hermite."""
    cells = values.shape[1] - 1
    x = r * cells
    j = min(int(x), cells - 1)
    t, h = x - j, 1.0 / cells
    a, b = values[k, j], values[k, j + 1]
    u, v = slopes[k, j] * h, slopes[k, j + 1] * h
    c3 = 2.0 * (a - b) + u + v
    c2 = 3.0 * (b - a) - 2.0 * u - v
    return (
        a + t * (u + t * (c2 + t * c3)),
        (u + t * (2.0 * c2 + 3.0 * t * c3)) * cells,
        (2.0 * c2 + 6.0 * t * c3) * (cells * cells),
    )


@compiled
def on_machine(values: FloatArray, slopes: FloatArray, fold: float, reach: float, soft: float) -> Machine:
    """A member on a machine: its travel fold + reach r^2 + soft F(r) is smallest where the machine lets go."""
    cells = values.shape[1] - 1
    travels = np.empty(cells + 1)
    where = 0
    for j in range(cells + 1):
        r = j / cells
        travels[j] = fold + reach * r * r + soft * values[0, j]
        if travels[j] < travels[where]:
            where = j
    if soft == 0.0:
        return travels, 0.0, fold, 0.0, 0
    low, high = max(where - 1, 0) / cells, min((where + 1) / cells, 1.0)
    for _ in range(50):
        middle = 0.5 * (low + high)
        if 2.0 * reach * middle + soft * read(values, slopes, 0, middle)[1] < 0.0:
            low = middle
        else:
            high = middle
    start = 0.5 * (low + high)
    value, slope, _ = read(values, slopes, 0, start)
    rate = max(2.0 * reach * start + soft * slope, 0.0)
    return (
        travels,
        start,
        fold + reach * start * start + soft * value,
        rate,
        min(int(start * cells), cells - 1),
    )


@compiled
def at_travel(
    values: FloatArray,
    slopes: FloatArray,
    fold: float,
    reach: float,
    soft: float,
    machine: Machine,
    travel: float,
    cell: int,
) -> tuple[float, float, float, int]:
    """Root, force and its slope at a travel beyond the first of a soft machine, and the cell, which is looked for from the given one on."""
    travels, start, first_travel, first_rate, first_cell = machine
    cells = travels.size - 1
    while cell < cells - 1 and travel > travels[cell + 1]:
        cell += 1
    while cell > first_cell and travel < travels[cell]:
        cell -= 1
    h = 1.0 / cells
    low, before, wide = cell * h, travels[cell], h
    rate = 2.0 * reach * low + soft * slopes[0, cell]
    if cell <= first_cell:
        cell, low, before, rate = first_cell, start, first_travel, first_rate
        wide = (cell + 1) * h - low
    # the parabola through both ends of the cell, which is the travel itself beside the fold
    across, off = travels[cell + 1] - before, travel - before
    r = low + 2.0 * off * wide / (
        rate * wide + math.sqrt(max(rate * rate * wide * wide + 4.0 * (across - rate * wide) * off, 1e-300))
    )
    r = min(r, OUTSIDE)
    value, slope = 0.0, 0.0
    for _ in range(_NEWTON):
        value, slope, bend = read(values, slopes, 0, r)
        off = travel - fold - reach * r * r - soft * value
        moved = r + off / max(2.0 * reach * r + soft * slope, 1e-6 * reach)
        step = min(max(moved, 0.5 * (r + start)), OUTSIDE) - r
        r += step
        if abs(step) < _CLOSE:
            value += step * (slope + 0.5 * step * bend)
            slope += step * bend
            break
    return r, value, slope, cell


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
    member: tuple[FloatArray, FloatArray, float, float, float],
    softness: float,
    gain: FloatArray,
    out: FloatArray,
    touches: NDArray[np.bool_],
) -> None:
    """Forces of the model and their rates over scale, shape and contact point, in the columns of `out`, and what touches."""
    values, slopes, fold, fold_rate, deepest = member
    scale, reach = math.exp(theta[SCALE]), deepest - fold
    soft = softness * scale
    machine = on_machine(values, slopes, fold, reach, soft)
    start, first_travel, cell = machine[1], machine[2], machine[4]
    start_value, start_slope, _ = read(values, slopes, 0, start)
    deepest_at = 0
    for i in range(place.size):
        if place[i] > place[deepest_at]:
            deepest_at = i
        travel = place[i] - theta[POINT]
        r, value, slope = start, start_value, start_slope
        if travel > first_travel and soft == 0.0:
            r = min(math.sqrt((travel - fold) / reach), OUTSIDE)
            value, slope, _ = read(values, slopes, 0, r)
        elif travel > first_travel:
            r, value, slope, cell = at_travel(values, slopes, fold, reach, soft, machine, travel, cell)
        over_shape = read(values, slopes, 1, r)[0]
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
            measured = force[i] - theta[BASE] - theta[TILT] * place[i]
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
