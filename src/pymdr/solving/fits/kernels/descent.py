"""Least squares by Levenberg and Marquardt from near their end."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymdr.solving.fits.kernels.model import (
    BASE,
    NUMBERS,
    SCALE,
    SHAPE,
    TILT,
    Batch,
    FamilyTable,
    Member,
    Model,
    Record,
    member_at,
    model_of,
)
from pymdr.solving.fits.touching import BoolArray
from pymdr.units import FloatArray

ITERATIONS, ROUGHLY = 60, 1e-3
"""The second, a gain in parts of the sum of squares."""
_STUCK, _FREE, _BLIND = 1e8, 1e-3, 1e-13
_FARTHEST_STEP = 3.0
"""Of the logarithm of the scale."""


class Wanted(NamedTuple):
    """What is looked for in each curve."""

    known: FloatArray
    """Numbers of the model that are not looked for."""
    free: BoolArray
    """Which are; the scale and the number of the family are those that unknowns of their own move."""
    directions: FloatArray
    """Of the numbers of the model, one free number in each row."""
    tied: bool
    """Whether the scale alone moves the number of the family."""
    adhesive: bool


class End(NamedTuple):
    """Where a descent ends."""

    theta: FloatArray
    """The numbers of the model."""
    misfit: float
    """Sum of squares in N^2."""
    settled: bool
    square: FloatArray
    """The normal equations of the free numbers."""
    model: Model
    left: FloatArray
    """Force of the record less the model in N; 0 where a sample is not used."""


class Ends(NamedTuple):
    """Where the descents of curves end, as :class:`End`, one in each row."""

    theta: FloatArray
    misfit: FloatArray
    settled: BoolArray
    covariance: FloatArray
    """Inverse of the normal equations of the free numbers."""
    force: FloatArray
    """Of the model in N, without baseline."""
    touches: BoolArray
    left: FloatArray


def descend(
    record: Record,
    directions: FloatArray,
    family: FamilyTable,
    start: FloatArray,
    used: BoolArray,
    limits: tuple[int, float],
) -> End:
    """
    Least squares by Levenberg and Marquardt.

    Parameters
    ----------
    record : Record
    directions : ndarray
        Of :class:`Wanted`.
    family : FamilyTable
    start : ndarray, shape (5,)
        Numbers of the model.
    used : ndarray
        Whether a sample counts.
    limits : (int, float)
        Most steps, and the gain in parts of the sum of squares at which it ends.
    """
    most, enough = limits
    theta, last = start.copy(), family.first + family.step * (family.folds.size - 1)
    member = member_at(family, theta[SHAPE])
    model, left, misfit = compared(record, theta, member, used)
    square, side = normal_equations(record.place, model, left, used, directions)
    damping, settled = 1e-3, False
    for _ in range(most):
        held, pull = square, side
        if member.varies and (theta[SHAPE] <= family.first or theta[SHAPE] >= last):
            held, pull = held_at_end(square, side, directions[:, SHAPE], theta[SHAPE] >= last)
        step, moved, expected = solved(held, damping, pull), theta.copy(), 0.0
        for p in range(step.size):
            expected += step[p] * side[p]
            for i in range(NUMBERS):
                moved[i] += step[p] * directions[p, i]
        moved[SCALE] = theta[SCALE] + min(max(moved[SCALE] - theta[SCALE], -_FARTHEST_STEP), _FARTHEST_STEP)
        if member.varies:
            moved[SHAPE] = min(max(moved[SHAPE], family.first), last)
            if moved[SHAPE] != theta[SHAPE]:
                member = member_at(family, moved[SHAPE])
        trial, other, found = compared(record, moved, member, used)
        if not found <= misfit:
            damping *= 8.0
            if damping > _STUCK:
                settled = True
                break
            continue
        gained = misfit - found
        theta, model, left, misfit = moved, trial, other, found
        square, side = normal_equations(record.place, model, left, used, directions)
        damping = max(0.1 * damping, 1e-12)
        # what is gained as it was expected leaves nothing that counts
        if gained <= enough * misfit or (damping < _FREE and abs(gained - expected) <= enough * misfit):
            settled = True
            break
    return End(theta, misfit, settled, square, model, left)


def compared(
    record: Record, theta: FloatArray, member: Member, used: BoolArray
) -> tuple[Model, FloatArray, float]:
    """The model, what it leaves of a record in N, and the sum of its squares."""
    model = model_of(record, theta, member)
    left = used * (record.force - theta[BASE] - theta[TILT] * record.place - model.force)
    return model, left, float(np.dot(left, left))


def normal_equations(
    place: FloatArray, model: Model, left: FloatArray, used: BoolArray, directions: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Of the free numbers."""
    rates = np.dot(directions[:, :BASE], model.rates) + directions[:, BASE : BASE + 1]
    rates = (rates + directions[:, TILT:] * place) * used
    return np.dot(rates, rates.T), np.dot(rates, left)


def held_at_end(
    square: FloatArray, side: FloatArray, over_shape: FloatArray, at_last: bool
) -> tuple[FloatArray, FloatArray]:
    """The normal equations without free numbers that would take the number of the family beyond its end."""
    held, pull = square.copy(), side.copy()
    for p in range(side.size):
        if over_shape[p] * side[p] * (1.0 if at_last else -1.0) > 0.0:
            held[p, :] = 0.0
            held[:, p] = 0.0
            pull[p] = 0.0
    return held, pull


def solved(square: FloatArray, damping: float, side: FloatArray) -> FloatArray:
    """Solve normal equations, whose diagonal is made 1 and then 1 + damping, by Cholesky; what is not told stays 0."""
    m = side.size
    lower, size, out = np.zeros((m, m)), np.ones(m), np.zeros(m)
    for p in range(m):
        if square[p, p] > 0.0:
            size[p] = math.sqrt(square[p, p])
        for q in range(p):
            value = square[p, q] / (size[p] * size[q])
            for i in range(q):
                value -= lower[p, i] * lower[q, i]
            lower[p, q] = value / lower[q, q]
        value = square[p, p] / (size[p] * size[p]) + damping
        for i in range(p):
            value -= lower[p, i] * lower[p, i]
        lower[p, p] = math.sqrt(value) if value > _BLIND else math.inf
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
    return out


def put(row: NDArray[Any], values: NDArray[Any]) -> None:
    """Write values into a row, of which numba would compile slowly what it says where the sizes differ."""
    row[:] = values


def descend_all(
    batch: Batch,
    directions: FloatArray,
    family: FamilyTable,
    used: BoolArray,
    limits: tuple[int, float],
    ends: Ends,
) -> None:
    """:func:`descend` in curves, one after another, from the places that stand where their ends are to stand."""
    m = directions.shape[0]
    for i in range(batch.place.shape[0]):
        record = Record(batch.place[i], batch.force[i], batch.softness[i])
        end = descend(record, directions, family, ends.theta[i], used[i], limits)
        ends.misfit[i], ends.settled[i] = end.misfit, end.settled
        put(ends.theta[i], end.theta)
        put(ends.left[i], end.left)
        put(ends.force[i], end.model.force)
        put(ends.touches[i], end.model.touches)
        for p in range(m):
            unit = np.zeros(m)
            unit[p] = 1.0
            put(ends.covariance[i, p], solved(end.square, 0.0, unit))


def ends_from(starts: FloatArray, samples: int, free: int) -> Ends:
    """Curves that begin at some numbers of the model."""
    count = len(starts)
    return Ends(
        starts.copy(),
        np.full(count, math.nan),
        np.zeros(count, dtype=np.bool_),
        np.zeros((count, free, free)),
        np.zeros((count, samples)),
        np.zeros((count, samples), dtype=np.bool_),
        np.zeros((count, samples)),
    )


def without_shape(directions: FloatArray) -> FloatArray:
    """Those that leave the number of the family as it is."""
    return np.asarray(directions[directions[:, SHAPE] == 0.0])
