"""Refusal of relaxation times that a record does not determine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.contact import Contact
from pymdr.problem.materials import Viscoelastic
from pymdr.problem.rheology import SpringsAndDashpots
from pymdr.solving.fits.unknowns import Unknown
from pymdr.units import FloatArray, written

_NOTHING = 1e-6
"""Ratio to the equilibrium modulus below which a relaxation has no effect."""
_BEYOND = 100.0
"""Factor to the steps or the duration of a record beyond which a time is not determined."""


def refuse_untimed(
    contact: Contact, unknowns: Sequence[Unknown], values: FloatArray, times: Sequence[FloatArray]
) -> None:
    """
    Refuse relaxation times that are far outside of the records, and relaxations without strength.

    A relaxation whose modulus is less than 1e-6 of the equilibrium modulus fits equally well with any time; the message then names
    the shortest.

    Parameters
    ----------
    contact : Contact
        With the fitted values.
    values : ndarray
        In their units.
    times : sequence of ndarray
        Times of the samples of each record in s.
    """
    step = min(float(np.diff(one).min()) for one in times)
    span = max(float(np.ptp(one)) for one in times)
    for unknown, value in zip(unknowns, values, strict=True):
        body = contact.body if unknown.name.startswith("body.") else contact.counterbody
        shear = body.shear if isinstance(body, Viscoelastic) else None
        if unknown.unit != "s" or not isinstance(shear, SpringsAndDashpots):
            continue
        kernel = shear.kernel()
        modulus = float(kernel.moduli[np.argmin(np.abs(np.log(kernel.times / value)))])
        if modulus < _NOTHING * kernel.equilibrium:
            value = min(value, _NOTHING * step)
        if step / _BEYOND <= value <= span * _BEYOND:
            continue
        end = "below" if value < step else "above"
        limit = step / _BEYOND if value < step else span * _BEYOND
        raise ProblemError(
            f"{unknown.name} is {end} {written(limit, 's', 3)}, beyond the steps of {written(step, 's', 3)} and the duration of {written(span, 's', 3)} of the record, which determines only "
            f"{_determined_text(kernel.equilibrium, modulus, value, step)}; use a law without it, or give bounds in free"
        )


def _determined_text(equilibrium: float, modulus: float, time: float, step: float) -> str:
    """Text on the combination that a record determines of a relaxation far outside of it."""
    if time > step:
        return (
            f"the sum of its modulus and the equilibrium modulus, {written(equilibrium + modulus, 'Pa', 4)}"
        )
    if modulus * time < _NOTHING * equilibrium * step:
        return f"the equilibrium modulus, {written(equilibrium, 'Pa', 4)}"
    return f"its modulus times it, {written(modulus * time, 'Pa*s', 4)}, as of a dashpot (KelvinVoigt)"
