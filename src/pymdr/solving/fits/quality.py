"""Quality of fitted curves: samples in contact, size of the residuals, and rise of the force along the baseline."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pymdr.units import FloatArray

FEWEST_IN_CONTACT, LARGEST_RESIDUAL, LARGEST_RISE = 10, 0.1, 0.1
"""Limits of good curves; residual and rise are relative to the range of the force."""
_LEAST_FREE = 8


class Quality(NamedTuple):
    """Measures of the quality of a fitted curve."""

    samples_in_contact: int
    relative_residual: float
    """Standard deviation of the residuals over the range of the force."""
    baseline_rise: float
    """Rise of the force along the baseline over the range of the force; NaN without a baseline."""

    def __str__(self) -> str:
        if faults := self.faults():
            return f"not good: {'; '.join(faults)}"
        rise = "none" if math.isnan(self.baseline_rise) else f"{100 * self.baseline_rise:.2g} %"
        return (
            f"good: {self.samples_in_contact} samples in contact; of the range of the force, residuals {100 * self.relative_residual:.2g} %, "
            f"rise of the baseline {rise}"
        )

    def faults(self) -> list[str]:
        """Texts on the measures that exceed their limits."""
        listed = []
        if self.samples_in_contact < FEWEST_IN_CONTACT:
            listed.append(f"{self.samples_in_contact} samples in contact (limit {FEWEST_IN_CONTACT})")
        if not self.relative_residual <= LARGEST_RESIDUAL:
            listed.append(
                f"residuals of {100 * self.relative_residual:.3g} % of the range of the force (limit {100 * LARGEST_RESIDUAL:g} %)"
            )
        if abs(self.baseline_rise) > LARGEST_RISE:
            listed.append(
                f"the baseline rises by {100 * self.baseline_rise:.3g} % of the range of the force (limit {100 * LARGEST_RISE:g} %)"
            )
        return listed


def worst_quality(
    curves: Sequence[tuple[FloatArray, FloatArray]], noises: Sequence[float], range_: float = 0.0
) -> Quality:
    """
    Each measure of the curve in which it is worst.

    Parameters
    ----------
    curves : sequence of (ndarray, ndarray)
        Travel or indentation in m beyond the contact point, and force in N above the baseline, less a fitted tilt, of each curve.
    noises : sequence of float
        Standard deviation of the residuals of each curve in N.
    range_ : float
        Distance in m before contact at which the bodies attract each other, where the baseline ends.
    """
    spans = [float(np.ptp(force)) for _, force in curves]
    rises = [
        rise_along_baseline(place, force, -range_) / span
        for (place, force), span in zip(curves, spans, strict=True)
    ]
    return Quality(
        min(int(np.count_nonzero(place > 0.0)) for place, _ in curves),
        max(noise / span for noise, span in zip(noises, spans, strict=True)),
        max(rises, key=lambda rise: abs(rise) if math.isfinite(rise) else -1.0),
    )


def rise_along_baseline(place: FloatArray, force: FloatArray, point: float) -> float:
    """
    Rise of the force along the baseline of an approach, by a straight line.

    Parameters
    ----------
    place, force : ndarray
        Travel or indentation in m and force in N; NaN are left out.
    point : float
        Contact point in m.

    Returns
    -------
    float
        In N; NaN with fewer than 8 samples before contact.
    """
    if not math.isfinite(point):
        return math.nan
    approach = slice(0, int(np.nanargmax(place)) + 1)
    x, y = place[approach], force[approach]
    free = np.isfinite(x) & np.isfinite(y) & (x < point)
    if np.count_nonzero(free) < _LEAST_FREE:
        return math.nan
    x, y = x[free] - x[free].mean(), y[free] - y[free].mean()
    power = float(x @ x)
    return float(x @ y) / power * (point - float(np.nanmin(place))) if power > 0.0 else math.nan
