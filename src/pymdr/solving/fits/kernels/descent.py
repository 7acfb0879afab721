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
"""Largest number of steps, and a gain relative to the sum of squares."""
_STUCK, _FREE, _SINGULAR = 1e8, 1e-3, 1e-13
_DOUBTED, _TRUSTED = 0.25, 0.75
"""Ratios of gained to expected decreases below and above which the damping grows and falls."""
_FARTHEST_STEP = 3.0
"""Largest step of the logarithm of the scale."""


class Wanted(NamedTuple):
    """The unknowns of each curve."""

    known: FloatArray
    """Known numbers of the model."""
    free: BoolArray
    """Free numbers of the model; scale and number of the family if an unknown moves them independently."""
    directions: FloatArray
    """Directions in the numbers of the model, one row per free number."""
    back: FloatArray
    """The free numbers of the unknowns, one in each row, as combinations of those of the search."""
    tied: bool
    """Whether the scale alone moves the number of the family."""
    adhesive: bool
    pulled: bool = False
    """Whether the number of the family is the work of a pull that does not deform the bodies: forces are linear in scale and pull."""
    intervals: bool = False
    """Whether the half widths of intervals are computed."""


class Limits(NamedTuple):
    """When a descent ends, and how it begins."""

    steps: int
    """Largest number of steps."""
    gain: float
    """Gain at which it ends, relative to the sum of squares."""
    damping: float = 1e-3
    """Of the first step; small next to the end."""


class End(NamedTuple):
    """The end of a descent."""

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
    """The ends of the descents of curves, as :class:`End`, one per row."""

    theta: FloatArray
    misfit: FloatArray
    settled: BoolArray
    covariance: FloatArray
    """Inverse of the normal equations of the free numbers."""
    force: FloatArray
    """Force of the model in N, without baseline."""
    touches: BoolArray
    left: FloatArray


def descend(
    record: Record,
    directions: FloatArray,
    family: FamilyTable,
    start: FloatArray,
    used: BoolArray,
    limits: Limits,
) -> End:
    """
    Least squares by Levenberg and Marquardt.

    Parameters
    ----------
    directions : ndarray
        As in :class:`Wanted`.
    start : ndarray, shape (5,)
        Numbers of the model.
    used : ndarray
        Whether a sample counts.
    """
    enough = limits.gain
    theta, last = start.copy(), family.first + family.step * (family.folds.size - 1)
    member = member_at(family, theta[SHAPE])
    model, left, misfit = compared(record, theta, member, used)
    square, side = normal_equations(record.place, model, left, used, directions)
    damping, settled = limits.damping, False
    for _ in range(limits.steps):
        matrix, pull = square, side
        if member.varies and (theta[SHAPE] <= family.first or theta[SHAPE] >= last):
            matrix, pull = fixed_at_end(square, side, directions[:, SHAPE], theta[SHAPE] >= last)
        step, moved, expected = solved(matrix, damping, pull), theta.copy(), 0.0
        for p in range(step.size):
            expected += step[p] * side[p]
            for i in range(NUMBERS):
                moved[i] += step[p] * directions[p, i]
        moved[SCALE] = theta[SCALE] + min(max(moved[SCALE] - theta[SCALE], -_FARTHEST_STEP), _FARTHEST_STEP)
        if member.varies:
            moved[SHAPE] = min(max(moved[SHAPE], family.first), last)
            if moved[SHAPE] != theta[SHAPE]:
                member = member_at(family, moved[SHAPE])
        trial, other, trial_misfit = compared(record, moved, member, used)
        gained, least = misfit - trial_misfit, enough * misfit
        # an expected small gain means convergence
        settled = abs(gained) <= least and expected <= least
        if not gained >= 0.0:
            damping *= 8.0
            settled |= damping > _STUCK
        else:
            theta, model, left, misfit = moved, trial, other, trial_misfit
            square, side = normal_equations(record.place, model, left, used, directions)
            settled |= damping < _FREE and abs(gained - expected) <= least
            if gained > _TRUSTED * expected:
                damping = max(0.1 * damping, 1e-12)
            elif gained < _DOUBTED * expected:
                damping *= 4.0
        if settled:
            break
    return End(theta, misfit, settled, square, model, left)


def compared(
    record: Record, theta: FloatArray, member: Member, used: BoolArray
) -> tuple[Model, FloatArray, float]:
    """The model, the residuals of a record in N, and the sum of their squares."""
    model = model_of(record, theta, member)
    left = used * (record.force - theta[BASE] - theta[TILT] * record.place - model.force)
    return model, left, float(np.dot(left, left))


def normal_equations(
    place: FloatArray, model: Model, left: FloatArray, used: BoolArray, directions: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The normal equations of the free numbers."""
    rates = tangents(place, model, used, directions)
    return np.dot(rates, rates.T), np.dot(rates, left)


def tangents(place: FloatArray, model: Model, used: BoolArray, directions: FloatArray) -> FloatArray:
    """Rates of the model over the free numbers, one in each row; 0 where a sample is not used."""
    rates = np.dot(directions[:, :BASE], model.rates) + directions[:, BASE : BASE + 1]
    return np.asarray((rates + directions[:, TILT:] * place) * used)


def fixed_at_end(
    square: FloatArray, side: FloatArray, over_shape: FloatArray, at_last: bool
) -> tuple[FloatArray, FloatArray]:
    """The normal equations without free numbers that would take the number of the family beyond its end."""
    matrix, pull = square.copy(), side.copy()
    for p in range(side.size):
        if over_shape[p] * side[p] * (1.0 if at_last else -1.0) > 0.0:
            matrix[p, :] = 0.0
            matrix[:, p] = 0.0
            pull[p] = 0.0
    return matrix, pull


def solved(square: FloatArray, damping: float, side: FloatArray) -> FloatArray:
    """Solve normal equations, whose diagonal is made 1 and then 1 + damping, by Cholesky; undetermined numbers stay 0."""
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
        lower[p, p] = math.sqrt(value) if value > _SINGULAR else math.inf
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
    """Write values into a row; a separate function because numba compiles the size check slowly."""
    row[:] = values


def descend_all(
    batch: Batch,
    directions: FloatArray,
    family: FamilyTable,
    used: BoolArray,
    inside: BoolArray,
    limits: Limits,
    ends: Ends,
) -> None:
    """
    :func:`descend` in curves, one after another, from the starts in `ends`, which it overwrites.

    `inside` has the prescribed samples in contact, shape (curves, samples), or (curves, 0) if the forces decide.
    """
    m = directions.shape[0]
    for i in range(batch.place.shape[0]):
        record = Record(batch.place[i], batch.force[i], batch.softness[i], inside[i])
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


def tangents_all(
    batch: Batch,
    directions: FloatArray,
    family: FamilyTable,
    thetas: FloatArray,
    used: BoolArray,
    inside: BoolArray,
    rates: FloatArray,
) -> None:
    """:func:`tangents` in curves at numbers of the model, written into `rates`, shape (curves, free, samples)."""
    for i in range(batch.place.shape[0]):
        record = Record(batch.place[i], batch.force[i], batch.softness[i], inside[i])
        model, _, _ = compared(record, thetas[i], member_at(family, thetas[i, SHAPE]), used[i])
        rows = tangents(record.place, model, used[i], directions)
        for p in range(directions.shape[0]):
            put(rates[i, p], rows[p])


def undecided(curves: int) -> BoolArray:
    """Samples in contact of curves, none of which is prescribed."""
    return np.zeros((curves, 0), dtype=np.bool_)


def ends_from(starts: FloatArray, samples: int, free: int) -> Ends:
    """Ends with some numbers of the model as start."""
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
    """Directions with a fixed number of the family."""
    return np.asarray(directions[directions[:, SHAPE] == 0.0])
