"""What a record shows and a fit leaves unexplained, in words."""

from __future__ import annotations

import math

import numpy as np

from pymdr.interpretation.theories import theory_of
from pymdr.line.adhesion import maugis_parameter
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.contact import Contact
from pymdr.solving.fits.found import FitResult
from pymdr.units import written

_PULLS, _SMALL = 8.0, 0.02
"""A pull that is told: in parts of the noise, and of the range of the force."""
WAVY = 1.0
"""Waves in the residuals that are told, in parts of the noise."""


def unexplained(found: FitResult) -> tuple[str, ...]:
    """Notes on a plateau of the detector, a pull without adhesion, the range of a law of adhesion, and waves that the model leaves."""
    return (
        *_unmarked_plateau(found),
        *_undetermined(found),
        *_unexplained_pull(found),
        *range_of_law(found.contact),
        *_unexplained_waves(found),
    )


def range_of_law(contact: Contact) -> tuple[str, ...]:
    """How far the attraction may reach for the law of adhesion of a contact to hold; nothing where Maugis' parameter is not defined."""
    law, radius = contact.adhesion, contact.profile.tip_radius
    bodies = [one for one in (contact.body, contact.counterbody) if one is not None]
    if law is None or radius is None or not all(one.homogeneous for one in bodies):
        return ()
    modulus = effective_moduli(contact.body, contact.counterbody).normal
    # of a range of 1 m, to which it is inversely proportional
    size = float(maugis_parameter(radius, modulus, law.work, law.work))
    note = theory_of(law).range_note(law, size)
    return (note,) if note else ()


def _unmarked_plateau(found: FitResult) -> tuple[str, ...]:
    """Whether a record stays at its largest force while it is pressed on."""
    curves = found.search.measured
    count = sum(int(one.mark_saturated().marked.sum()) for one in curves if one.saturated is None)
    if not count:
        return ()
    return (
        f"{count} samples have the largest force, while the depth changes: where the detector had run out of range, leave them out by "
        "prepare or mark_saturated",
    )


def _undetermined(found: FitResult) -> tuple[str, ...]:
    """A note on sizes whose errors are larger than they are themselves."""
    sizes = [found.values[one.name] for one in found.search.unknowns if one.is_size]
    blurred = [one for one in sizes if one.error > one.value]
    return tuple(
        f"{one.name} is not determined: its standard error, {written(one.error, one.unit, 3)}, is larger than it; only the ends of its interval say something"
        for one in blurred
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
