"""Which samples of a record are in contact, and the scale and the baseline of a model; also compiled for maps."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pymdr.units import FloatArray

BEYOND = 0.25
"""Of the depth of the fold: so much later a record may be found to leave contact."""
FULLY_OUT = 0.3
"""Of the largest pull: a smaller one is none."""

BoolArray = NDArray[np.bool_]


def in_contact(position: FloatArray, measured: FloatArray, model: FloatArray, fold: float) -> BoolArray:
    """
    Where bodies touch that attract each other.

    Between the position at which bodies jump into contact, 0, and the fold, at which they leave it, the record tells when they did:
    at the samples where it fits best, one while they approach and one while they recede.
    """
    deepest, index = int(np.argmax(position)), np.arange(position.size)
    # a little beyond the folds too: a model whose folds are not yet those of the record then fits no worse by a leap
    either = (position <= -fold) & (position >= (1.0 + BEYOND) * fold)
    gain = np.where(either, measured**2 - (measured - model) ** 2, 0.0)
    first = deepest - _best_count(gain[:deepest][::-1])
    last = deepest + _best_count(gain[deepest + 1 :])
    touches: BoolArray = np.where(either, (index >= first) & (index <= last), position > 0.0)
    return touches


def _best_count(gain: FloatArray) -> int:
    """Of how many samples, going away from the deepest one, the gains add up to most."""
    total = np.cumsum(gain)
    if total.size == 0:
        return 0
    best = int(np.argmax(total))
    return best + 1 if total[best] > 0.0 else 0


def first_guess_of_contact(position: FloatArray, force: FloatArray, fold: float, level: float) -> BoolArray:
    """Where bodies touch before a model is known: beyond 0 while they approach, and while something pulls after the deepest sample."""
    pull = min(force.min() - level, 0.0)
    after = np.arange(position.size) > np.argmax(position)
    held: BoolArray = after & (position >= fold) & (force - level < FULLY_OUT * pull)
    touches: BoolArray = (position > 0.0) | held
    return touches


def scale_and_baseline(
    model: FloatArray, force: FloatArray, scale: float, baseline: float
) -> tuple[float, float]:
    """Scale of a model and baseline by linear least squares; each looked for where it is given as nan."""
    if not math.isnan(scale):
        return scale, (force - scale * model).mean() if math.isnan(baseline) else baseline
    if not math.isnan(baseline):
        power = (model * model).sum()
        return ((model * (force - baseline)).sum() / power if power > 0.0 else -1.0), baseline
    centred = model - model.mean()
    power = (centred * centred).sum()
    found = (centred * force).sum() / power if power > 0.0 else -1.0
    return found, force.mean() - found * model.mean()
