"""Starts of the descents: members of the family at many contact points."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np

from pymdr.numerics.panels import IndexArray
from pymdr.solving.fits.kernels.descent import (
    ITERATIONS,
    ROUGHLY,
    Ends,
    Limits,
    Wanted,
    ends_from,
    undecided,
)
from pymdr.solving.fits.kernels.model import (
    BASE,
    NUMBERS,
    OUTSIDE,
    POINT,
    SCALE,
    SHAPE,
    TILT,
    Batch,
    FamilyTable,
    on_rung,
    read,
)
from pymdr.solving.fits.kernels.pulls import BEST, FEW, starts_of_pull
from pymdr.solving.fits.request import SEEN
from pymdr.solving.fits.touching import BoolArray, first_guess_of_contact, scale_and_baseline
from pymdr.units import FloatArray

_TRIALS, _RUNGS, _KEPT = 21, 12, 2
_SOFT_TRIALS, _SOFT_RUNGS, _SCALES = 7, 6, np.geomspace(0.3, 1e4, 9)
"""For machines softer than the contact: contact points, members, and stiffnesses relative to that with the largest force at the whole depth."""
_PRESSED, _FRACTION, _FAR = 8, 0.05, 0.2
"""Smallest number of samples in contact, their smallest force relative to the largest, and the fraction of places without contact."""
_EXPLAINED = 2.0
"""Ratio of the squares of the forces to those of the residuals from which on a contact is more than a pull that fits some of the noise."""
_ASIDE = 1.0
"""Distance of the other starts in the logarithm of the number of the family."""


class Trials(NamedTuple):
    """Curves to which members of the family are fitted at several contact points."""

    depth: FloatArray
    """Travel less deflection in m, one curve in each row."""
    force: FloatArray
    level: FloatArray
    """Approximate force in N without contact."""
    points: FloatArray
    """Contact points of each curve."""
    baseline: float
    """In N; NaN if it is unknown."""


class Engine(NamedTuple):
    """The work per sample, interpreted or compiled."""

    descend_all: Callable[[Batch, FloatArray, FamilyTable, BoolArray, BoolArray, Limits, Ends], None]
    """:func:`pymdr.solving.fits.kernels.descent.descend_all`."""
    best_points: Callable[[Trials, FamilyTable, FloatArray, FloatArray], None]
    """:func:`best_points`."""
    tangents_all: Callable[
        [Batch, FloatArray, FamilyTable, FloatArray, BoolArray, BoolArray, FloatArray], None
    ]
    """:func:`pymdr.solving.fits.kernels.descent.tangents_all`."""

    def descents(
        self,
        batch: Batch,
        directions: FloatArray,
        family: FamilyTable,
        starts: FloatArray,
        used: BoolArray,
        limits: Limits,
        inside: BoolArray | None = None,
    ) -> Ends:
        """The ends of the descents of curves from some starts; samples in contact may be prescribed."""
        inside = undecided(len(starts)) if inside is None else inside
        ends = ends_from(starts, batch.place.shape[1], len(directions))
        # as compiled kernels do: what overflows is no better end
        with np.errstate(over="ignore", invalid="ignore"):
            self.descend_all(batch, directions, family, used, inside, limits, ends)
        return ends


def few_of(force: FloatArray) -> BoolArray:
    """Samples of the first search: a few along each record, and more if the contact is a small part of it."""
    stride, chosen = max(force.shape[1] // FEW, 1), np.zeros(force.shape, dtype=np.bool_)
    chosen[:, ::stride] = True
    along = force[:, ::stride]
    # a retreat starts in contact and ends far from it
    level = np.minimum(_levels_of(along), _levels_of(along[:, ::-1]))
    least = level + _FRACTION * (force.max(axis=1) - level)
    for i in np.flatnonzero(np.count_nonzero(along > least[:, None], axis=1) < _PRESSED):
        pressed = np.flatnonzero(force[i] > least[i])
        chosen[i, pressed[:: max(pressed.size // _PRESSED, 1)]] = True
    return chosen


def _levels_of(force: FloatArray) -> FloatArray:
    """Approximate forces in N at the beginning of records."""
    many = max(3, force.shape[1] // 20)
    return np.asarray(np.sort(force[:, :many], axis=1)[:, min(many, force.shape[1]) // 2])


def _levels_far_of(place: FloatArray, force: FloatArray) -> FloatArray:
    """Approximate forces in N farthest from the body."""
    low, high = place.min(axis=1, keepdims=True), place.max(axis=1, keepdims=True)
    far = place <= low + _FRACTION * (high - low)
    ranked = np.sort(np.where(far, force, math.inf), axis=1)
    return np.asarray(ranked[np.arange(len(ranked)), np.count_nonzero(far, axis=1) // 2])


def tilts_of(batch: Batch, wanted: Wanted) -> list[FloatArray]:
    """First tilts in N/m: the known one, or the slope of the force far from the body, and 0 for records that start in contact."""
    none = np.zeros(len(batch.place))
    if not wanted.free[TILT]:
        return [none + wanted.known[TILT]]
    low, high = batch.place.min(axis=1, keepdims=True), batch.place.max(axis=1, keepdims=True)
    far = batch.place < low + _FAR * (high - low)
    x = np.where(far, batch.place, 0.0)
    x = np.where(far, x - x.sum(axis=1, keepdims=True) / np.maximum(far.sum(axis=1, keepdims=True), 1), 0.0)
    power = (x * x).sum(axis=1)
    return [(x * batch.force).sum(axis=1) / np.where(power > 0.0, power, 1.0), none]


def best_points(trials: Trials, family: FamilyTable, scales: FloatArray, places: FloatArray) -> None:
    """
    Write the best place of every curve on some members of a family.

    Parameters
    ----------
    scales : ndarray, shape (members, 2)
        Members, and their scales, NaN if unknown.
    places : ndarray, shape (curves, members, 4)
        Sum of squares in N^2, initially infinite, scale, baseline, and contact point.
    """
    for i in range(len(places)):
        force, level, points = trials.force[i], float(trials.level[i]), trials.points[i]
        depth = trials.depth[i] - points[:, None]
        for own, (rung, known) in zip(places[i], scales, strict=True):
            member = on_rung(family, int(rung))
            touches = first_guess_of_contact(depth, force, member.fold, level)
            root = np.sqrt((depth[touches] - member.fold) / (member.deepest - member.fold))
            model = np.zeros(depth.shape)
            model[touches] = read(member.force, member.slope, np.minimum(root, OUTSIDE))[0]
            scale, offset = scale_and_baseline(model, force, float(known), trials.baseline)
            misfit = ((force - offset[:, None] - scale[:, None] * model) ** 2).sum(axis=1)
            misfit[~(scale > 0.0)] = math.inf
            best = int(np.argmin(misfit))
            if misfit[best] < own[0]:
                own[:] = misfit[best], scale[best], offset[best], points[best]


def _points_along(places: FloatArray, known: FloatArray, wanted: Wanted, many: int) -> FloatArray:
    """Contact points to try, one row per curve."""
    if not wanted.free[POINT]:
        return known[:, None]
    low, high = places.min(axis=1, keepdims=True), places.max(axis=1, keepdims=True)
    return np.asarray(high - (high - low) * np.linspace(1.0, 0.01, many))


def _starts_on_rungs(
    batch: Batch, wanted: Wanted, family: FamilyTable, known: FloatArray, engine: Engine
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The best place of each curve on some members: sums of squares, numbers of the model, and how far the largest pull is off."""
    depth = batch.place - batch.softness[:, None] * batch.force
    # the samples farthest from the body may still be in adhesive contact
    level = _levels_of(batch.force) if family.folds[0] < 0.0 else _levels_far_of(batch.place, batch.force)
    points = _points_along(depth, known[:, POINT] - batch.softness * level, wanted, _TRIALS)
    base = math.nan if wanted.free[BASE] else wanted.known[BASE]
    rungs = np.arange(0, family.folds.size, max(family.folds.size // _RUNGS, 1))
    numbers = family.first + family.step * rungs
    scales = np.full(rungs.size, math.nan)
    if wanted.tied:
        # the product of the scale and the number of the member is known
        scales = np.exp(wanted.known[SCALE] + wanted.known[SHAPE] - numbers)
    elif not wanted.free[SCALE]:
        scales[:] = math.exp(wanted.known[SCALE])
    trials = Trials(depth, batch.force, level, points, base)
    places = np.tile([math.inf, 1.0, 0.0, 0.0], (len(depth), rungs.size, 1))
    engine.best_points(trials, family, np.column_stack([rungs, scales]), places)
    misfits, scale, offset, point = np.moveaxis(places, 2, 0)
    theta = np.empty((len(depth), rungs.size, NUMBERS))
    theta[..., SCALE], theta[..., SHAPE], theta[..., BASE] = np.log(scale), numbers, offset
    # the deflection was subtracted including the baseline
    theta[..., POINT] = (
        point + batch.softness[:, None] * offset if wanted.free[POINT] else known[:, POINT, None]
    )
    pull = np.minimum(batch.force.min(axis=1) - level, 0.0)
    off = np.abs(scale * family.forces[rungs].min(axis=1) - pull[:, None])
    return misfits.copy(), theta, np.where(np.isfinite(misfits), off, math.inf)


def _starts_on_machine(
    batch: Batch, wanted: Wanted, family: FamilyTable, known: FloatArray, engine: Engine
) -> FloatArray:
    """
    The best starts on some members of a family at some stiffnesses, without the depths of the samples; NaN without contact.

    The depth of a sample is its travel less its deflection. If a machine is much softer than the contact, that difference is noise.
    """
    count, least = len(batch.place), np.full(len(batch.place), math.inf)
    span = batch.force.max(axis=1) - batch.force.min(axis=1)
    rungs = np.arange(0, family.folds.size, max(family.folds.size // _SOFT_RUNGS, 1))
    points = _points_along(batch.place, known[:, POINT], wanted, _SOFT_TRIALS)
    best, used = np.full((count, NUMBERS), math.nan), np.ones(batch.place.shape, dtype=np.bool_)
    base = np.eye(NUMBERS)[[BASE]] if wanted.free[BASE] else np.zeros((0, NUMBERS))
    for rung, part, point in product(rungs, _SCALES if wanted.free[SCALE] else [1.0], points.T):
        trial = known.copy()
        unit = np.log(part * span / np.abs(family.forces[rung]).max())
        trial[:, SCALE] = unit if wanted.free[SCALE] else wanted.known[SCALE]
        trial[:, SHAPE], trial[:, POINT], trial[:, TILT] = family.first + family.step * rung, point, 0.0
        if wanted.free[BASE]:
            trial[:, BASE] = batch.force.mean(axis=1)
        ends = engine.descents(batch, base, family, trial, used, Limits(3, 0.0))
        better = ends.touches.any(axis=1) & (ends.misfit < least)
        least[better], best[better] = ends.misfit[better], ends.theta[better]
    return best


def starts_at_tilts(
    batch: Batch, wanted: Wanted, family: FamilyTable, known: FloatArray, tilts: FloatArray, engine: Engine
) -> tuple[FloatArray, FloatArray]:
    """
    The smallest sums of squares of a few samples, infinite without contact, and their places, of searches from one tilt each.

    Parameters
    ----------
    known : ndarray, shape (curves, 5)
        Known numbers of the model, of each curve.
    tilts : ndarray, shape (curves,)
        In N/m.
    """
    level = batch.force - tilts[:, None] * batch.place
    half = Batch(batch.place[:, ::2].copy(), level[:, ::2].copy(), batch.softness)
    misfits, thetas, off = _starts_on_rungs(half, wanted, family, known, engine)
    thetas[..., TILT] = tilts[:, None]
    least, best = np.full(len(level), math.inf), known.copy()
    last = family.first + family.step * (family.folds.size - 1)
    at_end = np.ones(len(level), dtype=np.bool_)

    def try_from(curves: IndexArray, trial: FloatArray) -> None:
        if not curves.size:
            return
        whole = curves.size == len(level)
        some = batch if whole else Batch(*(column[curves] for column in batch))
        used = np.ones(some.place.shape, dtype=np.bool_)
        ends = engine.descents(some, wanted.directions, family, trial, used, Limits(ITERATIONS, ROUGHLY))
        better = ends.misfit < least[curves]
        least[curves[better]], best[curves[better]] = ends.misfit[better], ends.theta[better]

    if wanted.pulled:
        scanned = starts_of_pull(Batch(batch.place, level, batch.softness), wanted, family, known, tilts)
        for rank in range(BEST):
            there = np.flatnonzero(np.isfinite(scanned[:, rank]).all(axis=1))
            try_from(there, scanned[there, rank])
    for turn in range(_KEPT + 2 + misfits.shape[1]):
        if turn == _KEPT and family.folds.size == 1:
            break
        if turn in (_KEPT, _KEPT + 1):  # once more from either side of the best
            aside = best.copy()
            aside[:, SHAPE] += _ASIDE if turn == _KEPT else -_ASIDE
            try_from(np.arange(len(level)), aside)
            continue
        # the first has the same pull as the record, because a pull may have few samples
        chosen = np.argmin(off if turn == 0 and wanted.adhesive else misfits, axis=1)
        left = np.isfinite(misfits[np.arange(len(level)), chosen])
        if turn == _KEPT + 2:
            at_end = (best[:, SHAPE] <= family.first) | (best[:, SHAPE] >= last)
        left &= at_end
        curves = np.flatnonzero(left)
        if not curves.size and turn > _KEPT:
            break
        try_from(curves, thetas[curves, chosen[curves]])
        misfits[curves, chosen[curves]], off[curves, chosen[curves]] = math.inf, math.inf
    base = level.mean(axis=1, keepdims=True) if wanted.free[BASE] else wanted.known[BASE]
    without = ((level - base) ** 2).sum(axis=1)
    unseen = ~np.isfinite(least) | (without <= least * max(_EXPLAINED, 1.0 + SEEN / level.shape[1]))
    unseen &= (batch.softness > 0.0) & (not wanted.tied) & (family.folds.size == 1 or wanted.free[SHAPE])
    unseen &= np.ptp(level, axis=1) > 0.0
    if unseen.any():
        rest = np.flatnonzero(unseen)
        trial = _starts_on_machine(Batch(*(c[rest] for c in half)), wanted, family, known[rest], engine)
        trial[:, TILT] = tilts[rest]
        there = np.isfinite(trial[:, SCALE])
        try_from(rest[there], trial[there])
    return least, best
