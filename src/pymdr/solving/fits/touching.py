"""The samples of a record in contact, and the scale and the baseline of a model; also compiled for maps."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pymdr.units import FloatArray

BEYOND = 3.0
"""Distance beyond the fold, relative to its depth, at which a sample may still be in contact: less, and a search whose model loses contact early, as in a gradual separation that no law of adhesion has, ends in one of many false minima."""
FULLY_OUT = 0.3
"""Ratio to the largest pull below which a force is out of contact."""

ROUNDS_OF_JUMPS = 8
"""Largest number of searches for an end that leaves out the samples adjacent to its own jumps."""

BoolArray = NDArray[np.bool_]


def in_contact(position: FloatArray, measured: FloatArray, model: FloatArray, fold: float) -> BoolArray:
    """
    Samples in contact, with adhesion.

    Between the position of the jump into contact, 0, and the fold, at which contact is lost, the record decides: the first and the
    last sample in contact are those of the best fit, one in approach and one in retreat.
    """
    deepest, index = int(np.argmax(position)), np.arange(position.size)
    # a little beyond the folds too, so that the misfit of a model with other folds does not jump
    last_places = [last_place(float(position[end]), fold) for end in (0, -1)]
    either = (position <= -fold) & (position >= np.where(index < deepest, *last_places))
    gain = np.where(either, measured**2 - (measured - model) ** 2, 0.0)
    first = deepest - _best_count(gain[:deepest][::-1])
    last = deepest + _best_count(gain[deepest + 1 :])
    touches: BoolArray = np.where(either, (index >= first) & (index <= last), position > 0.0)
    return touches


def last_place(end: float, fold: float) -> float:
    """The place in m up to which samples of a leg with an end may be in contact: those of the outer half beyond the fold show the baseline."""
    return max((1.0 + BEYOND) * fold, min(fold, 0.5 * (fold + end)))


def in_contact_by_law(position: FloatArray, onset: float, fold: float | FloatArray) -> BoolArray:
    """Samples in contact with the jumps of the law: beyond the onset in approach, and up to the fold in retreat; positions of shape (..., samples)."""
    after = np.arange(position.shape[-1]) > np.argmax(position, axis=-1)[..., None]
    touches: BoolArray = np.where(after, position > fold, position > onset)
    return touches


def off_changes(touches: BoolArray) -> BoolArray:
    """Samples that are not adjacent to a change of contact, shape (..., samples)."""
    keep, changes = np.ones(touches.shape, dtype=np.bool_), touches[..., 1:] != touches[..., :-1]
    keep[..., 1:] &= ~changes
    keep[..., :-1] &= ~changes
    return keep


def _best_count(gain: FloatArray) -> int:
    """The number of samples, counted from the deepest one, with the largest sum of gains."""
    total = np.cumsum(gain)
    if total.size == 0:
        return 0
    best = int(np.argmax(total))
    return best + 1 if total[best] > 0.0 else 0


def first_guess_of_contact(position: FloatArray, force: FloatArray, fold: float, level: float) -> BoolArray:
    """Samples in contact before a model is known: beyond 0 in approach, and with a tensile force in retreat; positions of shape (..., samples)."""
    pull = min(force.min() - level, 0.0)
    after = np.arange(position.shape[-1]) > np.argmax(position, axis=-1)[..., None]
    pulled: BoolArray = after & (position >= fold) & (force - level < FULLY_OUT * pull)
    touches: BoolArray = (position > 0.0) | pulled
    return touches


def scale_and_baseline(
    model: FloatArray, force: FloatArray, scale: float, baseline: float
) -> tuple[FloatArray, FloatArray]:
    """Scales of models of shape (..., samples) and baselines by linear least squares; each unknown if it is NaN."""
    count = model.shape[:-1]
    if not math.isnan(scale):
        offset = (force - scale * model).mean(axis=-1) if math.isnan(baseline) else np.full(count, baseline)
        return np.full(count, scale), offset
    offset = force.mean() if math.isnan(baseline) else baseline
    middle = model.mean(axis=-1) if math.isnan(baseline) else np.zeros(count)
    centred = model - middle[..., None]
    power = (centred * centred).sum(axis=-1)
    factor = np.where(power > 0.0, centred @ (force - offset) / np.where(power > 0.0, power, 1.0), -1.0)
    return factor, offset - factor * middle
