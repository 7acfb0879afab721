"""Notes on what a record shows and a fit leaves unexplained."""

from __future__ import annotations

import math

import numpy as np

from pymdr.interpretation.theories import theory_of
from pymdr.line.adhesion import maugis_parameter
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.contact import Contact
from pymdr.solving.fits.estimating import Estimate
from pymdr.solving.fits.residuals import is_rounding
from pymdr.solving.fits.results import FitResult
from pymdr.units import written

WIDENED, _ENOUGH = 1.2, 50.0
"""Smallest factor of the errors by correlated residuals that is noted, and correlation lengths for an accurate one."""
_PULLS, _SMALL = 8.0, 0.02
"""Smallest pull that is noted, relative to the noise and to the range of the force."""
_WIDE = 4.0
"""Smallest ratio of the ends of an interval that is noted."""
WAVY = 1.0
"""Smallest waves in the residuals that are noted, relative to the noise."""


def unexplained(result: FitResult) -> tuple[str, ...]:
    """Notes on a plateau of the detector, a pull without adhesion, the range of a law of adhesion, and waves that the model leaves."""
    return (
        *_unmarked_plateau(result),
        *_undetermined(result),
        *_unexplained_pull(result),
        *range_of_law(result.contact),
        *_unexplained_waves(result),
    )


def correlation_notes(estimate: Estimate) -> tuple[str, ...]:
    """A note on correlated residuals that widen the intervals."""
    factor, length = math.sqrt(estimate.correlated), estimate.correlation_length
    models = estimate.models
    span = max(float(np.ptp(one.force)) for one in models)
    if not length or factor < WIDENED or is_rounding(np.array(estimate.noise), np.array(span)):
        return ()
    text = f"the residuals are correlated over about {length:.2g} samples: the intervals are widened by a factor of {factor:.2g}"
    lengths = sum(one.force.size for one in models) / length
    if lengths < _ENOUGH:
        text += f"; the record has {lengths:.2g} correlation lengths, and below {_ENOUGH:g} the 95 % intervals cover 85 to 95 %"
    return (text,)


def range_of_law(contact: Contact) -> tuple[str, ...]:
    """A note on the largest range of attraction for which the law of adhesion holds, if Maugis' parameter is defined."""
    law, radius = contact.adhesion, contact.profile.tip_radius
    bodies = [one for one in (contact.body, contact.counterbody) if one is not None]
    if (
        law is None
        or radius is None
        or contact.has_edge_history
        or not all(one.homogeneous for one in bodies)
    ):
        return ()
    modulus = effective_moduli(contact.body, contact.counterbody).normal
    # for a range of 1 m; it is inversely proportional to the range
    size = float(maugis_parameter(radius, modulus, law.work, law.work))
    note = theory_of(law).range_note(law, size)
    return (note,) if note else ()


def _unmarked_plateau(result: FitResult) -> tuple[str, ...]:
    """A note on records that stay at their largest force while the depth changes."""
    curves = result.search.measured
    count = sum(int(one.mark_saturated().marked.sum()) for one in curves if one.saturated is None)
    if not count:
        return ()
    return (
        f"{count} samples have the largest force while the depth changes: if the detector was saturated, mark them as "
        "saturated or leave them out",
    )


def _undetermined(result: FitResult) -> tuple[str, ...]:
    """Notes on sizes whose errors are larger than they are themselves, or whose intervals span several times their value."""
    notes = []
    for one in (result.values[unknown.name] for unknown in result.search.unknowns if unknown.is_size):
        ends = [written(end, one.unit) for end in (one.low, one.high) if not 0.0 < end < math.inf]
        if ends and not one.is_at_bound:
            notes.append(
                f"{one.name} is not determined: the interval extends to {' and '.join(ends)}, where the law has limits that fit as well; fix it, or add "
                "records that show it"
            )
        elif one.error > one.value:
            notes.append(
                f"{one.name} is not determined: its standard error, {written(one.error, one.unit, 3)}, is larger than its value; use its interval only"
            )
        elif not one.is_at_bound and one.high > _WIDE * one.low:
            notes.append(
                f"{one.name} is hardly determined: its 95 % interval spans a factor of {one.high / one.low:.2g}, over which the misfit is not parabolic, "
                "and the true value may be beyond its ends; fix it, or add records that show it"
            )
    return tuple(notes)


def _unexplained_pull(result: FitResult) -> tuple[str, ...]:
    """A note on a pull in the record of a contact without adhesion; the noise is that between neighbours."""
    if result.contact.adhesion is not None or result.contact.friction is not None:
        return ()
    force = result.data["normal_force"].values
    noise = 1.4826 * float(np.median(np.abs(np.diff(force)))) / math.sqrt(2.0)
    smooth = np.median(np.lib.stride_tricks.sliding_window_view(force, 3), axis=1)
    pull = -float(smooth.min())
    if pull <= max(_PULLS * noise, _SMALL * float(np.ptp(force))):
        return ()
    return (
        f"the force falls to {written(pull, 'N', 3)} below the fitted baseline, but the contact has no adhesion: "
        "add a law, such as JKR(work), or fit the approach alone",
    )


def _unexplained_waves(result: FitResult) -> tuple[str, ...]:
    """A note on residuals whose correlated part is larger than their noise."""
    if result.waves <= WAVY:
        return ()
    missing = (
        "another law, a work of adhesion, a layer, the shape of the tip, or a drift"
        if result.contact.friction is None
        else "another law, slip before the record begins (make used false where it acts), or a drift"
    )
    return (
        f"the residuals have waves {result.waves:.2g} times as large as the noise between neighbours: {missing} may be "
        "missing; the intervals cover the noise only",
    )
