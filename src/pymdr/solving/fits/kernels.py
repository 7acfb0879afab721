"""Compiled least squares of one family of forces: thousands of curves, one after another. Loads numba."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pymdr import compiling
from pymdr.solving.fits.asking import AT_END, FOUND, NO_CONTACT, SEEN, UNREAD, UNSETTLED
from pymdr.solving.fits.forces import BEYOND, FULLY_OUT
from pymdr.units import FloatArray


def compiled(function: compiling.Function) -> compiling.Function:
    """Compile with numba when first called; kept on disk. Products and sums may be fused, nothing else."""
    return compiling.compiled(function, fastmath={"contract"})


SCALE, SHAPE, POINT, BASE = range(4)
"""Columns: logarithms of the scale of the forces and of the number in which the family differs, contact point in m, and
baseline in N."""
_FEW, _TRIALS, _RUNGS, _KEPT = 192, 21, 12, 2
_ASIDE = 1.0
"""Of the logarithm of the number of the family."""
_ITERATIONS, _POLISH, _FEW_STEPS = 60, 100, 6
_ROUGHLY, _TOLD, _STUCK, _LAST = 1e-3, 1e-3, 1e8, 100.0
"""Gains in parts of the sum of squares; the second times the samples, where 1 is a standard error. Steps of Gauss and Newton, which
are taken to their end, square what is left: the last of them may gain more by so much."""
_MANY, _FREE = 8, 1e-3
_NEWTON, _CLOSE = 30, 1e-8
"""The error left is the square of the last step."""
_UNKNOWN, _BLIND = -1.0, 1e-13
POORLY, ASIDES, NORMAL_95 = 20, np.array([-0.8, -0.5, -0.3, -0.15, 0.15, 0.3, 0.5, 0.8]), 1.96
"""Samples of a pull that are few; other starts there, in the logarithm of the number of the family."""
_OUTSIDE = 1.02
"""Of the reach of the family in the root of the depth."""


@compiled
def _row(
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
def _read(values: FloatArray, slopes: FloatArray, r: float) -> tuple[float, float]:
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
        if 2.0 * reach * middle + soft * _read(row[0], row[1], middle)[1] < 0.0:
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
def _model(
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
    first_travel = fold + reach * start * start + soft * _read(row[0], row[1], start)[0]
    deepest_at = 0
    for i in range(place.size):
        if place[i] > place[deepest_at]:
            deepest_at = i
        travel = place[i] - theta[POINT]
        r = start
        if travel > first_travel:
            if soft == 0.0:
                r = min(math.sqrt((travel - fold) / reach), _OUTSIDE)
            else:
                r = min(max(root[i] if root[i] >= 0.0 else root[i - 1], start + 1e-9), _OUTSIDE)
                for _ in range(_NEWTON):
                    value, slope = _read(row[0], row[1], r)
                    off = fold + reach * r * r + soft * value - travel
                    moved = r - off / max(2.0 * reach * r + soft * slope, 1e-6 * reach)
                    moved = min(max(moved, 0.5 * (r + start)), _OUTSIDE)
                    done = abs(moved - r) < _CLOSE
                    r = moved
                    if done:
                        break
        root[i] = r
        value, slope = _read(row[0], row[1], r)
        over_shape, _ = _read(row[2], row[3], r)
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


@compiled
def _misfit(force: FloatArray, base: float, out: FloatArray, used: NDArray[np.bool_]) -> float:
    total = 0.0
    for i in range(force.size):
        if used[i]:
            difference = force[i] - base - out[i, 0]
            total += difference * difference
    return total


@compiled
def _reduced(
    full: FloatArray, right: FloatArray, ways: FloatArray, square: FloatArray, side: FloatArray
) -> None:
    """The normal equations of the free numbers, of those of all four, of which the lower half stands."""
    for p in range(4):
        for q in range(p):
            full[q, p] = full[p, q]
    for p in range(side.size):
        side[p] = 0.0
        for i in range(4):
            side[p] += ways[i, p] * right[i]
        for q in range(side.size):
            square[p, q] = 0.0
            for i in range(4):
                for j in range(4):
                    square[p, q] += ways[i, p] * full[i, j] * ways[j, q]


@compiled
def _normal(
    force: FloatArray,
    base: float,
    out: FloatArray,
    used: NDArray[np.bool_],
    ways: FloatArray,
    square: FloatArray,
    side: FloatArray,
) -> None:
    """The normal equations of the free numbers."""
    full, right = np.zeros((4, 4)), np.zeros(4)
    rates = np.empty(4)
    for i in range(force.size):
        if used[i]:
            difference = force[i] - base - out[i, 0]
            rates[0], rates[1], rates[2], rates[3] = out[i, 1], out[i, 2], out[i, 3], 1.0
            for p in range(4):
                right[p] += rates[p] * difference
                for q in range(p + 1):
                    full[p, q] += rates[p] * rates[q]
    _reduced(full, right, ways, square, side)


@compiled
def _solve(square: FloatArray, damping: float, side: FloatArray, out: FloatArray) -> None:
    """Solve normal equations, whose diagonal is made 1 and then 1 + damping, by Cholesky; what is not told stays 0."""
    m = side.size
    lower, size = np.zeros((m, m)), np.empty(m)
    for p in range(m):
        size[p] = math.sqrt(square[p, p]) if square[p, p] > 0.0 else 1.0
    for p in range(m):
        for q in range(p + 1):
            value = square[p, q] / (size[p] * size[q])
            if p == q:
                value += damping
            for i in range(q):
                value -= lower[p, i] * lower[q, i]
            if p == q:
                lower[p, p] = math.sqrt(value) if value > _BLIND else math.inf
            else:
                lower[p, q] = value / lower[q, q]
    for p in range(m):
        value = side[p] / size[p]
        for i in range(p):
            value -= lower[p, i] * out[i]
        out[p] = value / lower[p, p]
    for p in range(m - 1, -1, -1):
        value = out[p]
        for i in range(p + 1, m):
            value -= lower[i, p] * out[i]
        out[p] = value / lower[p, p]
    for p in range(m):
        out[p] /= size[p]


@compiled
def _descend(
    place: FloatArray,
    force: FloatArray,
    used: NDArray[np.bool_],
    theta: FloatArray,
    ways: FloatArray,
    family: tuple[FloatArray, FloatArray, FloatArray, float, float, float],
    softness: float,
    most: int,
    enough: float,
    root: FloatArray,
    square: FloatArray,
    touches: NDArray[np.bool_],
    out: FloatArray,
) -> tuple[float, bool]:
    """Least squares by Levenberg and Marquardt; `theta`, `out`, `square` and `touches` are left at the best place."""
    forces, slopes, folds, first, step, deepest = family
    n, m = place.size, ways.shape[1]
    row = np.empty((4, forces.shape[1]))
    gain, side, trial, step_x, moved = np.empty(n), np.empty(m), np.empty((n, 4)), np.empty(m), np.empty(4)
    touching = np.empty(n, dtype=np.bool_)
    last = first + step * (folds.size - 1)
    fold, fold_rate = _row(forces, slopes, folds, first, step, theta[SHAPE], row)
    _model(place, force, theta, (row, fold, fold_rate, deepest), softness, root, gain, out, touches)
    misfit = _misfit(force, theta[BASE], out, used)
    damping, settled, fresh = 1e-3, False, True
    for _ in range(most):
        if fresh:
            _normal(force, theta[BASE], out, used, ways, square, side)
        held, pull = square, side
        if folds.size > 1 and (theta[SHAPE] <= first or theta[SHAPE] >= last):
            held, pull = square.copy(), side.copy()
            for p in range(m):
                if ways[SHAPE, p] * side[p] * (1.0 if theta[SHAPE] >= last else -1.0) > 0.0:
                    # it stays at its end
                    held[p, :], held[:, p], pull[p] = 0.0, 0.0, 0.0
        _solve(held, damping, pull, step_x)
        for i in range(4):
            moved[i] = theta[i]
            for p in range(m):
                moved[i] += ways[i, p] * step_x[p]
        moved[SCALE] = min(max(moved[SCALE], theta[SCALE] - 3.0), theta[SCALE] + 3.0)
        if folds.size > 1:
            moved[SHAPE] = min(max(moved[SHAPE], first), last)
            if moved[SHAPE] != theta[SHAPE]:
                fold, fold_rate = _row(forces, slopes, folds, first, step, moved[SHAPE], row)
        _model(place, force, moved, (row, fold, fold_rate, deepest), softness, root, gain, trial, touching)
        found = _misfit(force, moved[BASE], trial, used)
        if found <= misfit:
            gained, expected = misfit - found, 0.0
            for p in range(m):
                expected += step_x[p] * side[p]
            misfit, fresh = found, True
            theta[:], out[:, :], touches[:] = moved, trial, touching
            damping = max(0.1 * damping, 1e-12)
            # what is gained as it was expected leaves nothing that counts
            if gained <= enough * misfit or (damping < _FREE and abs(gained - expected) <= enough * misfit):
                settled = True
                break
        else:
            fresh = False
            damping *= 8.0
            if damping > _STUCK:
                settled = True
                break
    _normal(force, theta[BASE], out, used, ways, square, side)
    return misfit, settled


@compiled
def _sum_up(
    place: FloatArray,
    force: FloatArray,
    theta: FloatArray,
    row: FloatArray,
    deepest: float,
    softness: float,
    root: FloatArray,
    residual: FloatArray,
    full: FloatArray,
    right: FloatArray,
) -> float:
    """Sum of squares, residuals and normal equations of a contact without adhesion, in one pass."""
    full[:, :], right[:] = 0.0, 0.0
    scale, point, base = math.exp(theta[SCALE]), theta[POINT], theta[BASE]
    soft = softness * scale
    misfit, many, ss, sp, pp, sb, pb = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    side_s, side_p, side_b = 0.0, 0.0, 0.0
    before = 0.5
    for i in range(place.size):
        travel, difference = place[i] - point, force[i] - base
        many += 1.0
        if travel > 0.0:
            if soft == 0.0:
                r = min(math.sqrt(travel / deepest), _OUTSIDE)
                value, slope = _read(row[0], row[1], r)
            else:
                r = root[i] if root[i] > 0.0 else before
                for _ in range(_NEWTON):
                    value, slope = _read(row[0], row[1], r)
                    off = deepest * r * r + soft * value - travel
                    moved = r - off / max(2.0 * deepest * r + soft * slope, 1e-6 * deepest)
                    moved = min(max(moved, 0.5 * r), _OUTSIDE)
                    done = abs(moved - r) < _CLOSE
                    r = moved
                    if done:
                        break
                value, slope = _read(row[0], row[1], r)
                root[i], before = r, r
            share = scale * slope / (2.0 * deepest * max(r, 1e-4) + soft * slope)
            model = scale * value
            difference -= model
            over_scale = model - share * soft * value
            ss += over_scale * over_scale
            sp -= over_scale * share
            pp += share * share
            sb += over_scale
            pb -= share
            side_s += over_scale * difference
            side_p -= share * difference
        side_b += difference
        misfit += difference * difference
        residual[i] = difference
    full[SCALE, SCALE], full[POINT, SCALE], full[POINT, POINT] = ss, sp, pp
    full[BASE, SCALE], full[BASE, POINT], full[BASE, BASE] = sb, pb, many
    right[SCALE], right[POINT], right[BASE] = side_s, side_p, side_b
    return misfit


@compiled
def _settle(
    place: FloatArray,
    force: FloatArray,
    theta: FloatArray,
    ways: FloatArray,
    family: tuple[FloatArray, FloatArray, FloatArray, float, float, float],
    softness: float,
    enough: float,
    square: FloatArray,
    residual: FloatArray,
) -> tuple[float, bool]:
    """
    Least squares by Gauss and Newton of a contact without adhesion, from near the end; False where that leads uphill.

    What is left at `theta` stands in the last two.
    """
    m, deepest = ways.shape[1], family[5]
    row = np.empty((2, family[0].shape[1]))
    row[0], row[1] = family[0][0], family[1][0]
    full, right, side, step_x = np.empty((4, 4)), np.empty(4), np.empty(m), np.empty(m)
    root, moved, before = np.full(place.size, _UNKNOWN), theta.copy(), math.inf
    for _ in range(_FEW_STEPS):
        misfit = _sum_up(place, force, moved, row, deepest, softness, root, residual, full, right)
        if misfit > before * (1.0 + enough):
            return before, False
        before = misfit
        theta[:] = moved
        _reduced(full, right, ways, square, side)
        _solve(square, 0.0, side, step_x)
        expected = 0.0
        for p in range(m):
            expected += step_x[p] * side[p]
            for i in range(4):
                moved[i] += ways[i, p] * step_x[p]
        if expected <= _LAST * enough * misfit:
            # the last step changes nothing that counts, and brings the rest of the digits
            theta[:] = moved
            return misfit, True
    return before, False


@compiled
def _start(
    place: FloatArray,
    force: FloatArray,
    known: FloatArray,
    free: NDArray[np.bool_],
    tied: bool,
    family: tuple[FloatArray, FloatArray, FloatArray, float, float, float],
    softness: float,
    rungs: NDArray[np.int64],
    found: FloatArray,
) -> None:
    """The best place of every rung: misfit, four numbers, and how far its largest pull is off, in the rows of `found`."""
    forces, slopes, folds, first, step, deepest = family
    n = place.size
    depth = place - softness * force
    low, high, deepest_at = depth.min(), depth.max(), int(np.argmax(depth))
    few = max(3, n // 20)
    level = np.median(force[:few])
    pull = min(force.min() - level, 0.0)
    trials = _TRIALS if free[POINT] else 1
    for k in range(rungs.size):
        rung = rungs[k]
        fold, reach = folds[rung], deepest - folds[rung]
        found[k, 0], found[k, 5] = math.inf, math.inf
        for i in range(trials):
            point = known[POINT] - softness * level
            if free[POINT]:
                point = high - (high - low) * (1.0 - 0.99 * i / (trials - 1))
            s, sf, sm, smm, smf, sff = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for j in range(n):
                value, d = 0.0, depth[j] - point
                held = j > deepest_at and d >= fold and force[j] - level < FULLY_OUT * pull
                if d > 0.0 or held:
                    value = _read(forces[rung], slopes[rung], min(math.sqrt((d - fold) / reach), _OUTSIDE))[0]
                s += 1.0
                sf += force[j] - level
                sm += value
                smm += value * value
                smf += value * (force[j] - level)
                sff += (force[j] - level) ** 2
            base, scale = known[BASE] - level, math.exp(known[SCALE])
            if tied:
                # known is the product of the scale with the number of the rung
                scale = math.exp(known[SCALE] + known[SHAPE] - first - step * rung)
            if tied or not free[SCALE]:
                if free[BASE]:
                    base = (sf - scale * sm) / s
            elif free[BASE]:
                power = smm - sm * sm / s
                scale = (smf - sm * sf / s) / power if power > 0.0 else -1.0
                base = (sf - scale * sm) / s
            else:
                scale = (smf - base * sm) / smm if smm > 0.0 else -1.0
            if scale <= 0.0:
                continue
            misfit = (
                sff
                - 2.0 * (base * sf + scale * smf)
                + 2.0 * base * scale * sm
                + base * base * s
                + scale * scale * smm
            )
            if misfit < found[k, 0]:
                found[k, 0] = misfit
                found[k, 1] = math.log(scale)
                found[k, 2] = first + step * rung
                # the deflection was taken off with the baseline in it
                found[k, 3] = point + softness * (base + level) if free[POINT] else known[POINT]
                found[k, 4] = base + level
                found[k, 5] = abs(scale * forces[rung].min() - pull)


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
def _held(ways: FloatArray) -> FloatArray:
    """Ways of the numbers that leave that of the family as it is."""
    held, kept = np.zeros((4, ways.shape[1])), 0
    for p in range(ways.shape[1]):
        if ways[SHAPE, p] == 0.0:
            held[:, kept] = ways[:, p]
            kept += 1
    return held[:, :kept].copy()


@compiled
def _other_ends(
    place: FloatArray,
    force: FloatArray,
    theta: FloatArray,
    ways: FloatArray,
    family: tuple[FloatArray, FloatArray, FloatArray, float, float, float],
    softness: float,
    enough: float,
    misfit: float,
    root: FloatArray,
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
    n, held = place.size, _held(ways)
    everything = np.ones(n, dtype=np.bool_)
    ends, values = np.empty((ASIDES.size, 4)), np.empty(ASIDES.size)
    other_square, held_square = square.copy(), np.empty((held.shape[1], held.shape[1]))
    other_touches, other_out, trial = touches.copy(), out.copy(), theta.copy()
    begun = theta.copy()
    for k in range(ASIDES.size):
        ends[k], values[k] = begun, math.inf
        ends[k, SHAPE] += ASIDES[k]
        if not family[3] <= ends[k, SHAPE] <= family[3] + family[4] * (family[2].size - 1):
            continue
        values[k], _ = _descend(
            place, force, everything, ends[k], held, family, softness, _ITERATIONS, enough, root, held_square,
            other_touches, other_out,
        )  # fmt: skip
        if values[k] < misfit:
            trial[:] = ends[k]
            found, _ = _descend(
                place, force, everything, trial, ways, family, softness, _ITERATIONS, enough, root, other_square,
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


@compiled
def fit_curve(
    place: FloatArray,
    force: FloatArray,
    known: FloatArray,
    free: NDArray[np.bool_],
    tied: bool,
    ways: FloatArray,
    family: tuple[FloatArray, FloatArray, FloatArray, float, float, float],
    softness: float,
    adhesive: bool,
    theta: FloatArray,
    covariance: FloatArray,
    residual: FloatArray,
    used: NDArray[np.bool_],
) -> tuple[int, float, float, float]:
    """
    Fit one curve: how it ended, the sum of squares in N^2, the largest depth in m, and what is gained by the family.

    The last is by how many variances of the noise the sum grows with the smallest number of the family. `theta`, the inverse of the normal equations, residuals
    and what was used are left in the last four.
    """
    n, m = place.size, ways.shape[1]
    covariance[:, :], residual[:], used[:] = math.nan, math.nan, False
    theta[:] = math.nan
    if n < 2 * m + 2 or not np.all(np.isfinite(force)) or not np.all(np.isfinite(place)):
        return UNREAD, math.nan, math.nan, math.nan
    folds = family[2]
    stride = max(n // _FEW, 1)
    few_place, few_force = place[::stride].copy(), force[::stride].copy()
    rungs = np.arange(0, folds.size, max(folds.size // _RUNGS, 1))
    found = np.empty((rungs.size, 6))
    _start(few_place[::2].copy(), few_force[::2].copy(), known, free, tied, family, softness, rungs, found)
    all_few, all_samples = np.ones(few_place.size, dtype=np.bool_), np.ones(n, dtype=np.bool_)
    square, best, misfit = np.empty((m, m)), known.copy(), math.inf
    root = np.full(few_place.size, _UNKNOWN)
    touches, out = np.empty(few_place.size, dtype=np.bool_), np.empty((few_place.size, 4))
    last = family[3] + family[4] * (folds.size - 1)
    turn = -1
    while turn < _KEPT + 1 + rungs.size:
        turn += 1
        if turn == _KEPT and folds.size == 1:
            break
        if turn == _KEPT + 2 and family[3] < best[SHAPE] < last:
            break
        if turn < _KEPT or turn > _KEPT + 1:
            # the first is the one that pulls as the record does: a pull may stand in a few samples
            by, lowest = 5 if turn == 0 and adhesive else 0, 0
            for k in range(rungs.size):
                if math.isfinite(found[k, 0]) and found[k, by] < found[lowest, by]:
                    lowest = k
            if not math.isfinite(found[lowest, 0]):
                continue
            found[lowest, 0] = math.inf
            trial = found[lowest, 1:5].copy()
        else:
            # and once more from either side of the best
            trial = best.copy()
            trial[SHAPE] += _ASIDE if turn == _KEPT else -_ASIDE
        value, _ = _descend(
            few_place,
            few_force,
            all_few,
            trial,
            ways,
            family,
            softness,
            _ITERATIONS,
            _ROUGHLY,
            root,
            square,
            touches,
            out,
        )
        if value < misfit:
            misfit, best = value, trial
    if not math.isfinite(misfit):
        return NO_CONTACT, math.nan, math.nan, math.nan
    theta[:] = best
    plain = not adhesive and folds.size == 1
    if n > _MANY * few_place.size:
        # the last steps over all samples are then few
        between = max(n // (_MANY * _FEW), 1)
        some_place, some_force = place[::between].copy(), force[::between].copy()
        near, left, settled = theta.copy(), np.empty(some_place.size), False
        if plain:
            _, settled = _settle(some_place, some_force, near, ways, family, softness, _ROUGHLY, square, left)
        if settled:
            theta[:] = near
        else:
            some = np.ones(some_place.size, dtype=np.bool_)
            root, touches = np.full(some_place.size, _UNKNOWN), np.empty(some_place.size, dtype=np.bool_)
            out = np.empty((some_place.size, 4))
            _descend(
                some_place, some_force, some, theta, ways, family, softness, _ITERATIONS, _ROUGHLY, root, square, touches, out
            )  # fmt: skip
    enough = _TOLD / n
    used[:] = True
    settled, near, apart, grows = False, theta.copy(), np.zeros(4), math.inf
    if plain:
        misfit, settled = _settle(place, force, near, ways, family, softness, enough, square, residual)
        if settled:
            theta[:] = near
    if not settled:
        root = np.full(n, _UNKNOWN)
        touches, out = np.empty(n, dtype=np.bool_), np.empty((n, 4))
        misfit, settled = _descend(
            place,
            force,
            all_samples,
            theta,
            ways,
            family,
            softness,
            _POLISH,
            enough,
            root,
            square,
            touches,
            out,
        )
        if adhesive and free[SHAPE] and not tied and pulling(touches, out[:, 0]) < POORLY:
            misfit = _other_ends(
                place, force, theta, ways, family, softness, enough, misfit, root, square, touches, out, apart
            )
        if adhesive and free[SHAPE] and not tied:
            held = _held(ways)
            bare, bare_square = theta.copy(), np.empty((held.shape[1], held.shape[1]))
            bare[SHAPE] = family[3]
            larger, _ = _descend(
                place, force, all_samples, bare, held, family, softness, _ITERATIONS, _ROUGHLY, root.copy(), bare_square,
                touches.copy(), out.copy(),
            )  # fmt: skip
            grows = (larger / misfit - 1.0) * n if misfit > 0.0 else math.inf
        if adhesive:
            for i in range(n - 1):
                if touches[i] != touches[i + 1]:
                    used[i], used[i + 1] = False, False
            misfit, settled = _descend(
                place, force, used, theta, ways, family, softness, _POLISH, enough, root, square, touches, out
            )
        for i in range(n):
            residual[i] = force[i] - theta[BASE] - out[i, 0]
    count, total, squares = 0, 0.0, 0.0
    for i in range(n):
        if used[i]:
            count += 1
            total += force[i]
            squares += force[i] * force[i]
    level = total / count if free[BASE] else known[BASE]
    flat = squares - 2.0 * level * total + count * level * level
    unit, column = np.zeros(m), np.empty(m)
    for p in range(m):
        unit[:] = 0.0
        unit[p] = 1.0
        _solve(square, 0.0, unit, column)
        covariance[:, p] = column
    if apart[SHAPE] != 0.0 and misfit > 0.0:
        # other ends that fit as well widen what the curvature tells
        for p in range(m):
            column[p] = 0.0
            for i in range(4):
                if ways[i, p] != 0.0:
                    column[p] = apart[i] / ways[i, p]
                    break
        for p in range(m):
            for q in range(m):
                covariance[p, q] += column[p] * column[q] / NORMAL_95**2 * (count - m) / misfit
    at = int(np.argmax(place))
    deepest = place[at] - theta[POINT] - softness * (force[at] - theta[BASE] - residual[at])
    if not settled:
        return UNSETTLED, misfit, deepest, grows
    if (flat / max(misfit, 1e-300) - 1.0) * count < SEEN or deepest <= 0.0:
        return NO_CONTACT, misfit, deepest, grows
    if folds.size > 1 and (theta[SHAPE] <= family[3] or theta[SHAPE] >= last):
        return AT_END, misfit, deepest, grows
    return FOUND, misfit, deepest, grows


@compiled
def fit_curves(
    places: FloatArray,
    forces: FloatArray,
    softness: FloatArray,
    known: FloatArray,
    free: NDArray[np.bool_],
    tied: bool,
    adhesive: bool,
    ways: FloatArray,
    family: tuple[FloatArray, FloatArray, FloatArray, float, float, float],
    numbers: FloatArray,
    covariances: FloatArray,
    residuals: FloatArray,
    ended: NDArray[np.int8],
) -> None:
    """
    Fit many curves, one in each row; samples that are not finite are left out.

    Numbers: the four of the model, sum of squares in N^2, samples used, largest depth in m, and what :func:`fit_curve` says that the
    sum grows by.
    """
    for i in range(places.shape[0]):
        place, force = places[i], forces[i]
        if not (np.all(np.isfinite(place)) and np.all(np.isfinite(force))):
            good = np.isfinite(place) & np.isfinite(force)
            place, force = place[good], force[good]
        residual, used = np.empty(place.size), np.empty(place.size, dtype=np.bool_)
        ended[i], numbers[i, 4], numbers[i, 6], numbers[i, 7] = fit_curve(
            place, force, known, free, tied, ways, family, softness[i], adhesive, numbers[i, :4], covariances[i],
            residual, used,
        )  # fmt: skip
        kept = residual[used]
        numbers[i, 5] = kept.size
        residuals[i, :] = math.nan
        residuals[i, : kept.size] = kept


@compiled
def spans(places: FloatArray, forces: FloatArray, softness: FloatArray) -> FloatArray:
    """How far the depths of each curve reach in m; 0 where there are none."""
    found = np.zeros(places.shape[0])
    for i in range(places.shape[0]):
        low, high = math.inf, -math.inf
        for j in range(places.shape[1]):
            depth = places[i, j] - softness[i] * forces[i, j]
            if math.isfinite(depth):
                low, high = min(low, depth), max(high, depth)
        found[i] = max(high - low, 0.0)
    return found


@compiled
def correlation_times(residuals: FloatArray, most: int) -> tuple[FloatArray, FloatArray]:
    """
    1 + 2 sum rho_k of each row, up to the first lag within the noise; nan where that is none of the first `most`.

    And of each row its size, its mean square, and that of the differences between neighbours.
    """
    found, moments = np.empty(residuals.shape[0]), np.empty((residuals.shape[0], 3))
    for i in range(residuals.shape[0]):
        row = residuals[i]
        if not math.isfinite(row.sum()):
            row = row[np.isfinite(row)]
        n = row.size
        plain, square, beside = 0.0, 0.0, 0.0
        for j in range(n):
            plain += row[j]
            square += row[j] * row[j]
            if j:
                beside += row[j] * row[j - 1]
        mean = plain / max(n, 1)
        ends = row[0] + row[n - 1] if n else 0.0
        between = 2.0 * (square - beside) - (row[0] ** 2 + row[n - 1] ** 2 if n else 0.0)
        moments[i, 0], moments[i, 1], moments[i, 2] = n, square / max(n, 1), between / max(n - 1, 1)
        power, total, ended, lag = square - n * mean * mean, 1.0, n < 2, 1
        while not ended and lag <= most:
            products = beside - mean * (2.0 * plain - ends) + (n - 1) * mean * mean
            if lag > 1:
                products = 0.0
                for j in range(n - lag):
                    products += (row[j] - mean) * (row[j + lag] - mean)
            rho = products / power if power > 0.0 else 0.0
            if rho < 2.5 / math.sqrt(n) or lag >= n // 2:
                ended = True
            else:
                total += 2.0 * rho
            lag += 1
        found[i] = total if ended else math.nan
    return found, moments
