"""Where a descent begins: members of the family at many contact points."""

from __future__ import annotations

import math

import numpy as np

from pymdr.numerics.panels import IndexArray
from pymdr.solving.fits.asking import SEEN
from pymdr.solving.fits.kernels.descent import ITERATIONS, ROUGHLY, Wanted, descend
from pymdr.solving.fits.kernels.model import (
    BASE,
    NUMBERS,
    OUTSIDE,
    POINT,
    SCALE,
    SHAPE,
    TILT,
    FamilyTable,
    Member,
    Record,
    member_at,
    on_machine,
    on_rung,
    read,
    roots_at,
)
from pymdr.solving.fits.touching import first_guess_of_contact, scale_and_baseline
from pymdr.units import FloatArray

FEW, _TRIALS, _RUNGS, _KEPT = 192, 21, 12, 2
_SOFT_TRIALS, _SCALES = 7, np.geomspace(0.3, 1e4, 9)
"""On machines that are softer than the contact: contact points, and stiffnesses in parts of what would bear the force at the whole depth."""
_PRESSED, _SHARE, _FAR = 8, 0.05, 0.2
"""Of them so many at least that are pressed: by more than that share of the largest force; the share of the places without contact."""
_ASIDE = 1.0
"""Of the logarithm of the number of the family."""
_MISFIT, _PULL = 0, 5
"""Columns of the places on the members: sum of squares, and by how much the largest pull is off; between them stand the numbers."""


def few_of(force: FloatArray) -> IndexArray:
    """Which samples a search begins with: a few along the record, and more where the contact is a small part of it."""
    stride, chosen = max(force.size // FEW, 1), np.zeros(force.size, dtype=np.bool_)
    chosen[::stride] = True
    along = force[chosen]
    # a retreat begins in contact, and ends far from it
    level = min(_level_of(along), _level_of(along[::-1].copy()))
    least = level + _SHARE * (force.max() - level)
    if np.count_nonzero(along > least) < _PRESSED:
        pressed = np.flatnonzero(force > least)
        chosen[pressed[:: max(pressed.size // _PRESSED, 1)]] = True
    return np.flatnonzero(chosen)


def _level_of(force: FloatArray) -> float:
    """About the force in N where the record begins."""
    return np.sort(force[: max(3, force.size // 20)])[max(3, force.size // 20) // 2]


def _level_far_of(place: FloatArray, force: FloatArray) -> float:
    """About the force in N farthest from the body."""
    low = place.min()
    far = np.sort(force[place <= low + _SHARE * (place.max() - low)])
    return far[far.size // 2]


def tilts_of(record: Record, wanted: Wanted) -> FloatArray:
    """Tilts in N/m to begin with: what is known, or about the rise of the force far from the body, and none, where a record begins in contact."""
    if not wanted.free[TILT]:
        return wanted.known[TILT:]
    low = record.place.min()
    far = record.place < low + _FAR * (record.place.max() - low)
    x = record.place[far]
    x = x - x.mean()
    power = (x * x).sum()
    return np.array([(x * record.force[far]).sum() / power if power > 0.0 else 0.0, 0.0])


def fitted_at(
    depth: FloatArray, force: FloatArray, member: Member, level: float, known: tuple[float, float]
) -> tuple[float, float, float]:
    """Scale and baseline of a member that fit best at depths about as they were, and what they leave; given ones are known, nan ones not."""
    touches = np.flatnonzero(first_guess_of_contact(depth, force, member.fold, level))
    model = np.zeros(depth.size)
    root = np.sqrt((depth[touches] - member.fold) / (member.deepest - member.fold))
    model[touches] = read(member.force, member.slope, np.minimum(root, OUTSIDE))[0]
    scale, offset = scale_and_baseline(model, force, known[0], known[1])
    return scale, offset, ((force - offset - scale * model) ** 2).sum()


def start_on_rungs(record: Record, wanted: Wanted, family: FamilyTable, rungs: IndexArray) -> FloatArray:
    """The best place on each of some members: sum of squares, the numbers of the model, and how far its largest pull is off."""
    depth = record.place - record.softness * record.force
    low, high = depth.min(), depth.max()
    # what is farthest from the body may still be held by adhesion
    level = _level_of(record.force) if family.folds[0] < 0.0 else _level_far_of(record.place, record.force)
    points = np.array([wanted.known[POINT] - record.softness * level])
    if wanted.free[POINT]:
        points = high - (high - low) * np.linspace(1.0, 0.01, _TRIALS)
    base = math.nan if wanted.free[BASE] else wanted.known[BASE]
    pull = min(record.force.min() - level, 0.0)
    places = np.full((rungs.size, NUMBERS + 1), math.inf)
    for k in range(rungs.size):
        rung = rungs[k]
        number, member = family.first + family.step * rung, on_rung(family, rung)
        scale = math.nan if wanted.free[SCALE] else math.exp(wanted.known[SCALE])
        if wanted.tied:
            # known is the product of the scale with the number of the member
            scale = math.exp(wanted.known[SCALE] + wanted.known[SHAPE] - number)
        for point in points:
            grown, offset, misfit = fitted_at(depth - point, record.force, member, level, (scale, base))
            if grown > 0.0 and misfit < places[k, _MISFIT]:
                # the deflection was taken off with the baseline in it
                origin = point + record.softness * offset if wanted.free[POINT] else wanted.known[POINT]
                places[k, _MISFIT], places[k, _PULL] = misfit, abs(grown * member.force.min() - pull)
                places[k, 1:_PULL] = np.array([math.log(grown), number, origin, offset])
    return places


def start_on_machine(record: Record, wanted: Wanted, family: FamilyTable) -> tuple[bool, FloatArray]:
    """
    The best place of a family of one member at some stiffnesses, without the depths of the samples; False where nothing touches.

    The depth of a sample is its travel less its deflection. Where a machine is much softer than the contact, that difference is noise.
    """
    member = member_at(family, family.first)
    unit = (record.force.max() - record.force.min()) / np.abs(member.force).max()
    low, high = record.place.min(), record.place.max()
    points = np.array([wanted.known[POINT]])
    if wanted.free[POINT]:
        points = high - (high - low) * np.linspace(1.0, 0.01, _SOFT_TRIALS)
    base = math.nan if wanted.free[BASE] else wanted.known[BASE]
    best, least = wanted.known.copy(), math.inf
    for part in _SCALES:
        scale = unit * part if wanted.free[SCALE] else math.exp(wanted.known[SCALE])
        if not scale > 0.0:
            break
        soft = record.softness * scale
        machine = on_machine(member, soft)
        for point in points:
            touches = np.flatnonzero(record.place - point > machine.travel)
            model = np.zeros(record.place.size)
            root = roots_at(member, machine, soft, record.place[touches] - point)
            model[touches] = scale * read(member.force, member.slope, root)[0]
            _, offset = scale_and_baseline(model, record.force, 1.0, base)
            misfit = ((record.force - offset - model) ** 2).sum()
            if touches.size and misfit < least:
                least = misfit
                best[SCALE], best[SHAPE] = math.log(scale), family.first
                best[POINT], best[BASE] = point, offset
    return math.isfinite(least), best


def start_at_tilt(
    record: Record, wanted: Wanted, family: FamilyTable, tilt: float
) -> tuple[float, FloatArray]:
    """The smallest sum of squares of a few samples, infinite where nothing touches, and its place, of searches from one tilt."""
    level = record.force - tilt * record.place
    half = Record(record.place[::2].copy(), level[::2].copy(), record.softness)
    rungs = np.arange(0, family.folds.size, max(family.folds.size // _RUNGS, 1))
    places = start_on_rungs(half, wanted, family, rungs)
    misfit, best, used = math.inf, wanted.known.copy(), np.ones(record.place.size)
    last = family.first + family.step * (family.folds.size - 1)
    for turn in range(_KEPT + 2 + rungs.size):
        if turn == _KEPT and family.folds.size == 1:
            break
        if turn == _KEPT + 2 and family.first < best[SHAPE] < last:
            break
        trial = best.copy()
        if turn in (_KEPT, _KEPT + 1):  # once more from either side of the best
            trial[SHAPE] += _ASIDE if turn == _KEPT else -_ASIDE
        else:
            # the first is the one that pulls as the record does: a pull may stand in a few samples
            column = places[:, _PULL if turn == 0 and wanted.adhesive else _MISFIT]
            chosen = np.argmin(np.where(np.isfinite(places[:, _MISFIT]), column, math.inf))
            if not math.isfinite(places[chosen, _MISFIT]):
                continue
            places[chosen, _MISFIT] = math.inf
            trial[:TILT] = places[chosen, 1:_PULL]
            trial[TILT] = tilt
        end = descend(record, wanted, family, trial, used, (ITERATIONS, ROUGHLY))
        if end.misfit < misfit:
            misfit, best = end.misfit, end.theta
    without = level - (level.mean() if wanted.free[BASE] else wanted.known[BASE])
    seen = math.isfinite(misfit) and (without**2).sum() > misfit * (1.0 + SEEN / level.size)
    if record.softness > 0.0 and family.folds.size == 1 and not wanted.tied and not seen:
        touches, trial = start_on_machine(half, wanted, family)
        if touches:
            trial[TILT] = tilt
            end = descend(record, wanted, family, trial, used, (ITERATIONS, ROUGHLY))
            if end.misfit < misfit:
                misfit, best = end.misfit, end.theta
    return misfit, best
