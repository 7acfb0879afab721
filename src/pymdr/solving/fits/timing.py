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

_NOTHING = 1e-6
"""Of the equilibrium modulus: a weaker relaxation leaves no trace."""
_BEYOND = 100.0
"""How many times shorter than the steps of a record, or longer than it, a time is that leaves no trace of its own."""


def refuse_untimed(
    contact: Contact, unknowns: Sequence[Unknown], values: FloatArray, times: Sequence[FloatArray]
) -> None:
    """
    Refuse relaxation times that are far outside of the records, and relaxations without strength.

    A relaxation whose modulus is less than 1e-6 of the equilibrium modulus fits alike with any time; of these equal minima the
    shortest time is named, wherever the search ended.

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
        kernel = shear.kernel()
        modulus = float(kernel.moduli[np.argmin(np.abs(np.log(kernel.times / value)))])
        if modulus < _NOTHING * kernel.equilibrium:
            value = min(value, _NOTHING * step)
        if step / _BEYOND <= value <= span * _BEYOND:
            continue
        end = "below" if value < step else "above"
        limit = step / _BEYOND if value < step else span * _BEYOND
        raise ProblemError(
            f"fit: the record asks for {unknown.name} {end} {written(limit, 's', 3)}, and has steps of {written(step, 's', 3)} over {written(span, 's', 3)}: it tells only "
            f"{_told(kernel.equilibrium, modulus, value, step)}; take a law without it, or give bounds in free"
        )


def _told(equilibrium: float, modulus: float, time: float, step: float) -> str:
    """What a record tells of a relaxation far outside of it."""
    if time > step:
        return (
            f"the sum of its modulus and the equilibrium modulus, {written(equilibrium + modulus, 'Pa', 4)}"
        )
    if modulus * time < _NOTHING * equilibrium * step:
        return f"the equilibrium modulus, {written(equilibrium, 'Pa', 4)}"
    return f"its modulus times it, {written(modulus * time, 'Pa*s', 4)}, as of a dashpot (KelvinVoigt)"
