"""Claims and conditions of fretting wear."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pymdr.interpretation.friction import frictional_claims
from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.mapping.moduli import EffectiveModuli
from pymdr.problem.contact import Contact
from pymdr.units import FloatArray

SMALL = 0.1
"""Largest amplitude over the contact radius: beyond, the track of the slider is not of revolution."""
_LAWS = {
    "archard": ("depth of wear = k p s, Archard's law with a constant coefficient", "archard"),
    "energy": ("depth of wear = k tau s, the energy law with a constant coefficient", "fouvry"),
}


def wear_claims(
    contact: Contact, moduli: EffectiveModuli, law: str, error: Mapping[str, FloatArray]
) -> dict[str, Claim]:
    """
    Claims of fretting wear.

    Parameters
    ----------
    law : str
        "archard" or "energy".
    error : mapping of str to ndarray
        Measured relative errors of the quantities, of blocks and cells.
    """
    everywhere = np.ones(next(iter(error.values())).shape, dtype=bool)
    sheared = frictional_claims(contact, moduli, ("stick_radius",), everywhere)["stick_radius"]
    text, source = _LAWS[law]
    reason = (
        f"{text}; wear particles (third bodies) are not modelled; slip is the mean around the axis; friction: "
        f"{sheared.reason}"
    )
    claim = Claim(Level.APPROXIMATE, reason, f"{SOURCES[source]}; {SOURCES['popov-wear']}", everywhere)
    return {name: replace(claim, error=values) for name, values in error.items()}


def small_amplitude(amplitude: float, radius: float) -> Assumption:
    """The condition that the worn surface stays of revolution."""
    return Assumption(
        "small amplitude", "amplitude of the shift over the contact radius", amplitude / radius, SMALL
    )
