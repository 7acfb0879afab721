"""What a record shows and a fit leaves unexplained, in words."""

from __future__ import annotations

import math

import numpy as np

from pymdr.problem.measured import MeasuredCurve
from pymdr.solving.curves import mark_saturated
from pymdr.solving.fits.found import FitResult
from pymdr.units import written

_PULLS, _SMALL = 8.0, 0.02
"""A pull that is told: in parts of the noise, and of the range of the force."""
WAVY = 1.0
"""Waves in the residuals that are told, in parts of the noise."""


def unexplained(found: FitResult) -> tuple[str, ...]:
    """Notes on a plateau of the detector, a pull without adhesion, and waves that the model leaves."""
    return (*_unmarked_plateau(found), *_unexplained_pull(found), *_unexplained_waves(found))


def _unmarked_plateau(found: FitResult) -> tuple[str, ...]:
    """Whether a record stays at its largest force while it is pressed on."""
    curves = [one for one in found.curves if isinstance(one, MeasuredCurve)]
    count = sum(int(mark_saturated(one).marked.sum()) for one in curves if one.saturated is None)
    if not count:
        return ()
    return (
        f"{count} samples have the largest force, while the depth changes: where the detector had run out of range, leave them out by "
        "prepare or mark_saturated",
    )


def _unexplained_pull(found: FitResult) -> tuple[str, ...]:
    """A note where a record pulls, and the contact has no adhesion; the noise is that between neighbours."""
    if found.contact.adhesion is not None or found.contact.friction is not None:
        return ()
    force = found.data["normal_force"].values
    noise = 1.4826 * float(np.median(np.abs(np.diff(force)))) / math.sqrt(2.0)
    smooth = np.median(np.lib.stride_tricks.sliding_window_view(force, 3), axis=1)
    pull = -float(smooth.min())
    if pull <= max(_PULLS * noise, _SMALL * float(np.ptp(force))):
        return ()
    return (
        f"the record pulls with up to {written(pull, 'N', 3)}, below the baseline that was found, and the contact has no adhesion: "
        "fit it with one, such as JKR(work), or the approach alone",
    )


def _unexplained_waves(found: FitResult) -> tuple[str, ...]:
    """A note where what the model leaves hangs together more than it is noise."""
    if found.waves <= WAVY:
        return ()
    missing = (
        "another law, a work of adhesion, a layer, the shape of the tip, or a drift"
        if found.contact.friction is None
        else "another law, slip before the record begins (make used false where it acts), or a drift"
    )
    return (
        f"what the model leaves are waves {found.waves:.2g} times as large as the noise between neighbours: {missing} may be "
        "missing; the intervals hold the noise, not that",
    )
