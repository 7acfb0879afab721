"""Which relaxation times a record can tell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.contact import Contact
from pymdr.problem.materials import Viscoelastic
from pymdr.problem.rheology import SpringsAndDashpots
from pymdr.solving.fits.unknowns import Unknown
from pymdr.units import FloatArray, written

_BEYOND = 100.0
"""How many times shorter than the steps of a record, or longer than it, a time is that leaves no trace of its own."""


def refuse_untimed(
    contact: Contact, unknowns: Sequence[Unknown], values: FloatArray, times: Sequence[FloatArray]
) -> None:
    """
    Refuse relaxation times that are far outside of the records.

    Parameters
    ----------
    contact : Contact
        With the values that were found.
    unknowns : sequence of Unknown
    values : ndarray
        In their units.
    times : sequence of ndarray
        Of the samples of each record in s.

    Raises
    ------
    ProblemError
        With what the records do determine: of a fast relaxation the product of modulus and time, of a slow one the sum with the equilibrium modulus.
    """
    step = min(float(np.diff(one).min()) for one in times)
    span = max(float(np.ptp(one)) for one in times)
    for unknown, value in zip(unknowns, values, strict=True):
        body = contact.body if unknown.name.startswith("body.") else contact.counterbody
        shear = body.shear if isinstance(body, Viscoelastic) else None
        if unknown.unit != "s" or not isinstance(shear, SpringsAndDashpots):
            continue
        if step / _BEYOND <= value <= span * _BEYOND:
            continue
        kernel = shear.kernel()
        modulus = float(kernel.moduli[np.argmin(np.abs(np.log(kernel.times / value)))])
        told = (
            f"so short that the records tell only its modulus times it, {written(modulus * value, 'Pa*s', 4)}, as of a dashpot (KelvinVoigt)"
            if value < step
            else "so long that the records tell only the sum with the equilibrium modulus, "
            f"{written(kernel.equilibrium + modulus, 'Pa', 4)}"
        )
        raise ProblemError(
            f"fit: the record asks for {unknown.name} {'below' if value < step else 'above'} "
            f"{written(step / _BEYOND if value < step else span * _BEYOND, 's', 3)}, and has steps of {written(step, 's', 3)} over {written(span, 's', 3)}: "
            f"{told}; take a law without it, or give bounds in free"
        )
