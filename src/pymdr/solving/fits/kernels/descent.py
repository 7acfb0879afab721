"""Least squares from near their end: Levenberg and Marquardt, Gauss and Newton. Loads numba."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pymdr.solving.fits.kernels.model import (
    ALL,
    BASE,
    OUTSIDE,
    POINT,
    SCALE,
    SHAPE,
    TILT,
    Family,
    at_travel,
    compiled,
    member_at,
    model_of,
    on_machine,
    read,
)
from pymdr.units import FloatArray

ITERATIONS, ROUGHLY = 60, 1e-3
"""The second, a gain in parts of the sum of squares."""
_FEW_STEPS, _STUCK, _LAST, _FREE, _BLIND = 6, 1e8, 100.0, 1e-3, 1e-13
"""Steps of Gauss and Newton, which are taken to their end, square what is left: the third, by how much more the last of them may gain."""


@compiled
def _misfit(
    place: FloatArray, force: FloatArray, theta: FloatArray, out: FloatArray, used: NDArray[np.bool_]
) -> float:
    total = 0.0
    for i in range(force.size):
        if used[i]:
            difference = force[i] - theta[BASE] - theta[TILT] * place[i] - out[i, 0]
            total += difference * difference
    return total


@compiled
def _reduced(
    full: FloatArray, right: FloatArray, ways: FloatArray, square: FloatArray, side: FloatArray
) -> None:
    """The normal equations of the free numbers, of those of all, of which the lower half stands."""
    for p in range(ALL):
        for q in range(p):
            full[q, p] = full[p, q]
    for p in range(side.size):
        side[p] = 0.0
        for i in range(ALL):
            side[p] += ways[i, p] * right[i]
        for q in range(side.size):
            square[p, q] = 0.0
            for i in range(ALL):
                for j in range(ALL):
                    square[p, q] += ways[i, p] * full[i, j] * ways[j, q]


@compiled
def _normal(
    place: FloatArray,
    force: FloatArray,
    theta: FloatArray,
    out: FloatArray,
    used: NDArray[np.bool_],
    ways: FloatArray,
    square: FloatArray,
    side: FloatArray,
) -> None:
    """The normal equations of the free numbers."""
    full, right = np.zeros((ALL, ALL)), np.zeros(ALL)
    rates = np.empty(ALL)
    for i in range(force.size):
        if used[i]:
            difference = force[i] - theta[BASE] - theta[TILT] * place[i] - out[i, 0]
            rates[0], rates[1], rates[2], rates[3], rates[TILT] = (
                out[i, 1],
                out[i, 2],
                out[i, 3],
                1.0,
                place[i],
            )
            for p in range(ALL):
                right[p] += rates[p] * difference
                for q in range(p + 1):
                    full[p, q] += rates[p] * rates[q]
    _reduced(full, right, ways, square, side)


@compiled
def solved(square: FloatArray, damping: float, side: FloatArray, out: FloatArray) -> None:
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
def descend(
    place: FloatArray,
    force: FloatArray,
    used: NDArray[np.bool_],
    theta: FloatArray,
    ways: FloatArray,
    family: Family,
    softness: float,
    most: int,
    enough: float,
    square: FloatArray,
    touches: NDArray[np.bool_],
    out: FloatArray,
) -> tuple[float, bool]:
    """Least squares by Levenberg and Marquardt; `theta`, `out`, `square` and `touches` are left at the best place."""
    forces, slopes, folds, first, step, deepest = family
    n, m = place.size, ways.shape[1]
    values, rises = np.empty((2, forces.shape[1])), np.empty((2, forces.shape[1]))
    gain, side, trial, step_x, moved = np.empty(n), np.empty(m), np.empty((n, 4)), np.empty(m), np.empty(ALL)
    touching = np.empty(n, dtype=np.bool_)
    last = first + step * (folds.size - 1)
    fold, fold_rate = member_at(forces, slopes, folds, first, step, theta[SHAPE], values, rises)
    model_of(place, force, theta, (values, rises, fold, fold_rate, deepest), softness, gain, out, touches)
    misfit = _misfit(place, force, theta, out, used)
    damping, settled, fresh = 1e-3, False, True
    for _ in range(most):
        if fresh:
            _normal(place, force, theta, out, used, ways, square, side)
        held, pull = square, side
        if folds.size > 1 and (theta[SHAPE] <= first or theta[SHAPE] >= last):
            held, pull = square.copy(), side.copy()
            for p in range(m):
                if ways[SHAPE, p] * side[p] * (1.0 if theta[SHAPE] >= last else -1.0) > 0.0:
                    # it stays at its end
                    held[p, :], held[:, p], pull[p] = 0.0, 0.0, 0.0
        solved(held, damping, pull, step_x)
        for i in range(ALL):
            moved[i] = theta[i]
            for p in range(m):
                moved[i] += ways[i, p] * step_x[p]
        moved[SCALE] = min(max(moved[SCALE], theta[SCALE] - 3.0), theta[SCALE] + 3.0)
        if folds.size > 1:
            moved[SHAPE] = min(max(moved[SHAPE], first), last)
            if moved[SHAPE] != theta[SHAPE]:
                fold, fold_rate = member_at(forces, slopes, folds, first, step, moved[SHAPE], values, rises)
        model_of(
            place, force, moved, (values, rises, fold, fold_rate, deepest), softness, gain, trial, touching
        )
        found = _misfit(place, force, moved, trial, used)
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
    _normal(place, force, theta, out, used, ways, square, side)
    return misfit, settled


@compiled
def _sum_up(
    place: FloatArray,
    force: FloatArray,
    theta: FloatArray,
    family: Family,
    softness: float,
    tilted: bool,
    residual: FloatArray,
    full: FloatArray,
    right: FloatArray,
) -> float:
    """Sum of squares, residuals and normal equations of a contact without adhesion, in one pass."""
    full[:, :], right[:] = 0.0, 0.0
    scale, point, base, tilt = math.exp(theta[SCALE]), theta[POINT], theta[BASE], theta[TILT]
    soft = softness * scale
    misfit, many, ss, sp, pp, sb, pb = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    side_s, side_p, side_b, side_t = 0.0, 0.0, 0.0, 0.0
    st, pt, bt, tt = 0.0, 0.0, 0.0, 0.0
    values, slopes, deepest = family[0], family[1], family[5]
    machine = on_machine(values, slopes, 0.0, deepest, soft)
    cell = machine[4]
    for i in range(place.size):
        travel, difference = place[i] - point, force[i] - base - tilt * place[i]
        many += 1.0
        if travel > 0.0:
            if soft == 0.0:
                r = min(math.sqrt(travel / deepest), OUTSIDE)
                value, slope, _ = read(values, slopes, 0, r)
            else:
                r, value, slope, cell = at_travel(values, slopes, 0.0, deepest, soft, machine, travel, cell)
            share = scale * slope / (2.0 * deepest * max(r, 1e-4) + soft * slope)
            model = scale * value
            difference -= model
            over_scale = model - share * soft * value
            ss += over_scale * over_scale
            sp -= over_scale * share
            pp += share * share
            sb += over_scale
            pb -= share
            if tilted:
                st += over_scale * place[i]
                pt -= share * place[i]
            side_s += over_scale * difference
            side_p -= share * difference
        side_b += difference
        if tilted:
            side_t += place[i] * difference
            bt += place[i]
            tt += place[i] * place[i]
        misfit += difference * difference
        residual[i] = difference
    full[SCALE, SCALE], full[POINT, SCALE], full[POINT, POINT] = ss, sp, pp
    full[BASE, SCALE], full[BASE, POINT], full[BASE, BASE] = sb, pb, many
    full[TILT, SCALE], full[TILT, POINT], full[TILT, BASE], full[TILT, TILT] = st, pt, bt, tt
    right[SCALE], right[POINT], right[BASE], right[TILT] = side_s, side_p, side_b, side_t
    return misfit


@compiled
def settle(
    place: FloatArray,
    force: FloatArray,
    theta: FloatArray,
    ways: FloatArray,
    family: Family,
    softness: float,
    enough: float,
    square: FloatArray,
    residual: FloatArray,
) -> tuple[float, bool]:
    """
    Least squares by Gauss and Newton of a contact without adhesion, from near the end; False where that leads uphill.

    What is left at `theta` stands in the last two.
    """
    m, tilted = ways.shape[1], bool(np.any(ways[TILT] != 0.0))
    full, right, side, step_x = np.empty((ALL, ALL)), np.empty(ALL), np.empty(m), np.empty(m)
    moved, before = theta.copy(), math.inf
    for _ in range(_FEW_STEPS):
        misfit = _sum_up(place, force, moved, family, softness, tilted, residual, full, right)
        if misfit > before * (1.0 + enough):
            return before, False
        before = misfit
        theta[:] = moved
        _reduced(full, right, ways, square, side)
        solved(square, 0.0, side, step_x)
        expected = 0.0
        for p in range(m):
            expected += step_x[p] * side[p]
            for i in range(ALL):
                moved[i] += ways[i, p] * step_x[p]
        if expected <= _LAST * enough * misfit:
            # the last step changes nothing that counts, and brings the rest of the digits
            theta[:] = moved
            return misfit, True
    return before, False
