"""Where a descent begins: all rungs of the family at many contact points. Loads numba."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pymdr.solving.fits.asking import SEEN
from pymdr.solving.fits.forces import FULLY_OUT
from pymdr.solving.fits.kernels.descent import ITERATIONS, ROUGHLY, descend
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
    on_machine,
    read,
)
from pymdr.units import FloatArray

FEW, _TRIALS, _RUNGS, _KEPT = 192, 21, 12, 2
_SOFT_TRIALS, _SCALES = 7, np.geomspace(0.3, 1e4, 9)
"""On machines that are softer than the contact: contact points, and stiffnesses in parts of what would bear the force at the whole depth."""
_PRESSED, _SHARE, _FAR = 8, 0.05, 0.2
"""Of them so many at least that are pressed: by more than that share of the largest force; the share of the places without contact."""
_ASIDE = 1.0
"""Of the logarithm of the number of the family."""


@compiled
def few_of(force: FloatArray) -> NDArray[np.int64]:
    """Which samples a search begins with: a few along the record, and more where the contact is a small part of it."""
    n = force.size
    stride = max(n // FEW, 1)
    along = force[::stride].copy()
    # a retreat begins in contact, and ends far from it
    level, highest = min(_level_of(along), _level_of(along[::-1])), force.max()
    least = level + _SHARE * (highest - level)
    chosen = np.arange(0, n, stride)
    if np.count_nonzero(along > least) >= _PRESSED:
        return chosen
    pressed = np.flatnonzero(force > least)
    return np.unique(np.append(chosen, pressed[:: max(pressed.size // _PRESSED, 1)]))


@compiled
def _level_of(force: FloatArray) -> float:
    """About the force in N where the record begins."""
    return float(np.median(force[: max(3, force.size // 20)]))


@compiled
def _level_far_of(place: FloatArray, force: FloatArray) -> float:
    """About the force in N farthest from the body."""
    low = place.min()
    return float(np.median(force[place <= low + _SHARE * (place.max() - low)]))


@compiled
def _tilt_of(place: FloatArray, force: FloatArray) -> float:
    """About the rise of the force in N/m far from the body."""
    low = place.min()
    far = place < low + _FAR * (place.max() - low)
    x, f = place[far], force[far]
    x = x - x.mean()
    power = (x * x).sum()
    return float((x * f).sum() / power) if power > 0.0 else 0.0


@compiled
def start_on_rungs(
    place: FloatArray,
    force: FloatArray,
    known: FloatArray,
    free: NDArray[np.bool_],
    tied: bool,
    family: Family,
    softness: float,
    rungs: NDArray[np.int64],
    found: FloatArray,
) -> None:
    """The best place of every rung: misfit, four numbers, and how far its largest pull is off, in the rows of `found`."""
    forces, slopes, folds, first, step, deepest = family
    n = place.size
    depth = place - softness * force
    low, high, deepest_at = depth.min(), depth.max(), int(np.argmax(depth))
    # what is farthest from the body may still be held by adhesion
    level = _level_of(force) if folds[0] < 0.0 else _level_far_of(place, force)
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
                    value = read(forces, slopes, rung, min(math.sqrt((d - fold) / reach), OUTSIDE))[0]
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
def start_on_machine(
    place: FloatArray,
    force: FloatArray,
    known: FloatArray,
    free: NDArray[np.bool_],
    family: Family,
    softness: float,
    theta: FloatArray,
) -> bool:
    """
    The best place of a family of one member at some stiffnesses, without the depths of the samples; False where nothing touches.

    The depth of a sample is its travel less its deflection. Where a machine is much softer than the contact, that difference is noise.
    """
    forces, slopes, folds, first, _, deepest = family
    unit = (force.max() - force.min()) / np.abs(forces[0]).max()
    low, high = place.min(), place.max()
    best, trials = math.inf, _SOFT_TRIALS if free[POINT] else 1
    for k in range(_SCALES.size):
        scale = unit * _SCALES[k] if free[SCALE] else math.exp(known[SCALE])
        if not scale > 0.0:
            return False
        machine = on_machine(forces, slopes, folds[0], deepest - folds[0], softness * scale)
        cell = machine[4]
        for i in range(trials):
            point = high - (high - low) * (1.0 - 0.99 * i / (trials - 1)) if free[POINT] else known[POINT]
            some, square, touching = 0.0, 0.0, 0
            for j in range(place.size):
                difference = force[j]
                if place[j] - point > machine[2]:
                    _, value, _, cell = at_travel(
                        forces,
                        slopes,
                        folds[0],
                        deepest - folds[0],
                        softness * scale,
                        machine,
                        place[j] - point,
                        cell,
                    )
                    difference -= scale * value
                    touching += 1
                some += difference
                square += difference * difference
            base = some / place.size if free[BASE] else known[BASE]
            misfit = square - 2.0 * base * some + place.size * base * base
            if touching > 0 and misfit < best:
                best = misfit
                theta[:] = known
                theta[SCALE], theta[SHAPE], theta[POINT], theta[BASE] = math.log(scale), first, point, base
    return math.isfinite(best)


@compiled
def _begun_with(
    place: FloatArray,
    force: FloatArray,
    tilt: float,
    known: FloatArray,
    free: NDArray[np.bool_],
    tied: bool,
    ways: FloatArray,
    family: Family,
    softness: float,
    adhesive: bool,
    theta: FloatArray,
) -> float:
    """The same from one tilt."""
    folds, m = family[2], ways.shape[1]
    rungs = np.arange(0, folds.size, max(folds.size // _RUNGS, 1))
    found = np.empty((rungs.size, 6))
    level = force.copy()
    for i in range(place.size):
        level[i] -= tilt * place[i]
    start_on_rungs(place[::2].copy(), level[::2].copy(), known, free, tied, family, softness, rungs, found)
    everything = np.ones(place.size, dtype=np.bool_)
    square, best, misfit = np.empty((m, m)), known.copy(), math.inf
    touches, out = np.empty(place.size, dtype=np.bool_), np.empty((place.size, 4))
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
            trial = np.empty(ALL)
            trial[:TILT], trial[TILT] = found[lowest, 1:5], tilt
        else:
            # and once more from either side of the best
            trial = best.copy()
            trial[SHAPE] += _ASIDE if turn == _KEPT else -_ASIDE
        value, _ = descend(
            place,
            force,
            everything,
            trial,
            ways,
            family,
            softness,
            ITERATIONS,
            ROUGHLY,
            square,
            touches,
            out,
        )
        if value < misfit:
            misfit, best = value, trial
    without = level - (level.mean() if free[BASE] else known[BASE])
    seen = math.isfinite(misfit) and (without**2).sum() > misfit * (1.0 + SEEN / place.size)
    if softness > 0.0 and folds.size == 1 and not tied and not seen:
        trial = known.copy()
        if start_on_machine(place[::2].copy(), level[::2].copy(), known, free, family, softness, trial):
            trial[TILT] = tilt
            value, _ = descend(
                place, force, everything, trial, ways, family, softness, ITERATIONS, ROUGHLY, square, touches, out
            )  # fmt: skip
            if value < misfit:
                misfit, best = value, trial
    if math.isfinite(misfit):
        theta[:] = best
    return misfit


@compiled
def begun(
    place: FloatArray,
    force: FloatArray,
    known: FloatArray,
    free: NDArray[np.bool_],
    tied: bool,
    ways: FloatArray,
    family: Family,
    softness: float,
    adhesive: bool,
    theta: FloatArray,
) -> float:
    """The smallest sum of squares of a few samples, infinite where nothing touches; its place is left in `theta`."""
    if not free[TILT]:
        return _begun_with(
            place, force, known[TILT], known, free, tied, ways, family, softness, adhesive, theta
        )
    # far from the body the tilt is that of the force, unless the record begins in contact
    least, trial = math.inf, np.empty(ALL)
    for tilt in (_tilt_of(place, force), 0.0):
        misfit = _begun_with(place, force, tilt, known, free, tied, ways, family, softness, adhesive, trial)
        if misfit < least:
            least = misfit
            theta[:] = trial
    return least
