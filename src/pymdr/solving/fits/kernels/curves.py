"""Least squares of one family of forces in many curves, one after another."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymdr.solving.fits.asking import AT_END, FOUND, NO_CONTACT, SEEN, UNREAD, UNSETTLED
from pymdr.solving.fits.kernels.descent import (
    ITERATIONS,
    ROUGHLY,
    End,
    Wanted,
    descend,
    solved,
    without_shape,
)
from pymdr.solving.fits.kernels.model import BASE, NUMBERS, POINT, SHAPE, TILT, FamilyTable, Record
from pymdr.solving.fits.kernels.starts import FEW, few_of, start_at_tilt, tilts_of
from pymdr.solving.fits.touching import FULLY_OUT, BoolArray
from pymdr.units import FloatArray

_POLISH, _TOLD, _MANY = 100, 1e-3, 8
"""The second, a gain in parts of the sum of squares times the samples, where 1 is a standard error."""
_ROUNDED = 1e-14
"""Of the largest force: what a record that does not change is off its mean."""
_POORLY, _ASIDES, _NORMAL_95 = 20, np.array([-0.8, -0.5, -0.3, -0.15, 0.15, 0.3, 0.5, 0.8]), 1.96
"""Samples of a pull that are few; other starts there, in the logarithm of the number of the family."""


class Curves(NamedTuple):
    """Curves that are fitted, one in each row; samples that are not finite are left out."""

    place: FloatArray
    """Travel or indentation in m."""
    force: FloatArray
    """In N."""
    softness: FloatArray
    """Compliance of the machine of each in m/N."""


class Found(NamedTuple):
    """What is found in curves, into which it is written."""

    numbers: FloatArray
    """Those of the model, of which the baseline stands in the middle of the places, sum of squares in N^2, samples used, largest depth
    in m, and by how many variances of the noise the sum grows with the smallest number of the family."""
    covariances: FloatArray
    """Inverse of the normal equations of the free numbers."""
    residuals: FloatArray
    """In N, of the samples that are used."""
    ended: NDArray[np.int8]


class Fit(NamedTuple):
    """The fit of one curve."""

    ended: int
    theta: FloatArray
    """The numbers of the model."""
    misfit: float
    deepest: float
    grows: float
    covariance: FloatArray
    left: FloatArray


def _pulling(end: End) -> int:
    """How many samples stand in the pull: touch with a third of its largest at least."""
    return np.count_nonzero(
        end.model.touches & (end.model.force < FULLY_OUT * min(end.model.force.min(), 0.0))
    )


def _other_ends(
    record: Record, wanted: Wanted, family: FamilyTable, best: End, enough: float
) -> tuple[End, FloatArray]:
    """
    The end of the smallest sum of squares with numbers of the family on both sides, and the distance to the farthest that fits as well.

    Where a pull stands in a few samples, each that is taken for held or lost is a step in the misfit, which its curvature does not
    tell. The farthest number is sought within the 95 % of one number.
    """
    n, begun = record.place.size, best.theta.copy()
    held, used, limits = without_shape(wanted), np.ones(n), (ITERATIONS, enough)
    ends, misfits = np.empty((_ASIDES.size, NUMBERS)), np.full(_ASIDES.size, math.inf)
    for k in range(_ASIDES.size):
        ends[k] = begun
        ends[k, SHAPE] += _ASIDES[k]
        if family.first <= ends[k, SHAPE] <= family.first + family.step * (family.folds.size - 1):
            beside = descend(record, held, family, ends[k], used, limits)
            ends[k], misfits[k] = beside.theta, beside.misfit
            if beside.misfit < best.misfit:
                other = descend(record, wanted, family, beside.theta, used, limits)
                if other.misfit < best.misfit:
                    best = other
    apart = np.zeros(NUMBERS)
    for k in range(_ASIDES.size):
        as_well = misfits[k] <= best.misfit * (1.0 + _NORMAL_95**2 / n)
        if as_well and abs(ends[k, SHAPE] - best.theta[SHAPE]) > abs(apart[SHAPE]):
            apart = ends[k] - best.theta
    return best, apart


def _grown_without_family(record: Record, wanted: Wanted, family: FamilyTable, best: End) -> float:
    """By how many variances of the noise the sum of squares grows with the smallest number of the family."""
    bare, used = best.theta.copy(), np.ones(record.place.size)
    bare[SHAPE] = family.first
    larger = descend(record, without_shape(wanted), family, bare, used, (ITERATIONS, ROUGHLY)).misfit
    return (larger / best.misfit - 1.0) * used.size if best.misfit > 0.0 else math.inf


def _covariance(square: FloatArray, apart: FloatArray, directions: FloatArray, variance: float) -> FloatArray:
    """Inverse of the normal equations; other ends that fit as well widen what the curvature tells."""
    m = square.shape[0]
    covariance = np.empty((m, m))
    for p in range(m):
        covariance[:, p] = solved(square, 0.0, np.eye(m)[p])
    if apart[SHAPE] != 0.0 and variance > 0.0:
        moved = np.zeros(m)
        for p in range(m):
            i = np.argmax(np.abs(directions[p]) > 0.0)
            moved[p] = apart[i] / directions[p, i]
        for p in range(m):
            covariance[p] += moved[p] * moved / (_NORMAL_95**2 * variance)
    return covariance


def _shows_contact(record: Record, wanted: Wanted, fit: End, used: BoolArray, deepest: float) -> bool:
    """Whether a constant force leaves squares that are larger than the noise makes them."""
    level = (record.force - fit.theta[TILT] * record.place)[used]
    flat = level - (level.mean() if wanted.free[BASE] else wanted.known[BASE])
    total = (flat * flat).sum()
    grows = (total / max(fit.misfit, 1e-300) - 1.0) * level.size >= SEEN
    return grows and deepest > 0.0 and total > level.size * (_ROUNDED * np.abs(level).max()) ** 2


def _nothing(wanted: Wanted, ended: int) -> Fit:
    """That of a curve in which nothing is found."""
    unknown, m = np.full(NUMBERS, math.nan), wanted.directions.shape[0]
    return Fit(ended, unknown, math.nan, math.nan, math.nan, np.full((m, m), math.nan), np.zeros(0))


def fit_curve(record: Record, wanted: Wanted, family: FamilyTable) -> Fit:
    """Fit one curve, whose samples are finite."""
    n, m = record.place.size, wanted.directions.shape[0]
    if n < 2 * m + 2:
        return _nothing(wanted, UNREAD)
    chosen = few_of(record.force)
    few = Record(record.place[chosen], record.force[chosen], record.softness)
    misfit, theta = math.inf, wanted.known
    for tilt in tilts_of(few, wanted):
        least, place = start_at_tilt(few, wanted, family, tilt)
        if least < misfit:
            misfit, theta = least, place
    if not math.isfinite(misfit):
        return _nothing(wanted, NO_CONTACT)
    if n > _MANY * chosen.size:
        # more samples first, so that the last steps over all of them are few
        stride = max(n // (_MANY * FEW), 1)
        more = Record(record.place[::stride].copy(), record.force[::stride].copy(), record.softness)
        theta = descend(more, wanted, family, theta, np.ones(more.place.size), (ITERATIONS, ROUGHLY)).theta
    limits, used = (_POLISH, _TOLD / n), np.ones(n, dtype=np.bool_)
    end = descend(record, wanted, family, theta, np.ones(n), limits)
    apart, grows = np.zeros(NUMBERS), math.inf
    if wanted.adhesive:
        if wanted.free[SHAPE] and not wanted.tied:
            if _pulling(end) < _POORLY:
                end, apart = _other_ends(record, wanted, family, end, _TOLD / n)
            grows = _grown_without_family(record, wanted, family, end)
        jumps = np.flatnonzero(end.model.touches[1:] != end.model.touches[:-1])
        used[jumps] = False
        used[jumps + 1] = False
        end = descend(record, wanted, family, end.theta, used.astype(np.float64), limits)
    count = np.count_nonzero(used)
    covariance = _covariance(end.square, apart, wanted.directions, end.misfit / (count - m))
    at = np.argmax(record.place)
    deepest = record.place[at] - end.theta[POINT] - record.softness * end.model.force[at]
    last = family.first + family.step * (family.folds.size - 1)
    ended = FOUND
    if not end.settled:
        ended = UNSETTLED
    elif not _shows_contact(record, wanted, end, used, deepest):
        ended = NO_CONTACT
    elif family.folds.size > 1 and not family.first < end.theta[SHAPE] < last:
        ended = AT_END
    return Fit(ended, end.theta, end.misfit, deepest, grows, covariance, end.left[used])


FitCurve = Callable[[Record, Wanted, FamilyTable], Fit]
""":func:`fit_curve`, or the same compiled."""


def fit_curves(
    curves: Curves, wanted: Wanted, family: FamilyTable, found: Found, fit_one: FitCurve = fit_curve
) -> None:
    """Fit many curves, one after another."""
    for i in range(curves.place.shape[0]):
        good = np.isfinite(curves.place[i]) & np.isfinite(curves.force[i])
        place, force = curves.place[i][good], curves.force[i][good]
        known, middle = wanted.known.copy(), 0.0
        if place.size and wanted.free[TILT]:
            middle = 0.5 * (place.min() + place.max())
            known[POINT] -= middle
        own = wanted._replace(known=known)
        fit = fit_one(Record(place - middle, force, float(curves.softness[i])), own, family)
        found.ended[i] = fit.ended
        found.numbers[i, :NUMBERS] = fit.theta
        found.numbers[i, POINT] += middle
        found.numbers[i, NUMBERS:] = np.array([fit.misfit, float(fit.left.size), fit.deepest, fit.grows])
        found.covariances[i] = fit.covariance
        found.residuals[i, :] = math.nan
        found.residuals[i, : fit.left.size] = fit.left
