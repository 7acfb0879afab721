"""Claims of the heat of currents and of friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pymdr.interpretation.friction import frictional_claims
from pymdr.interpretation.validity import SOURCES, Assumption, BoolArray, Claim, Level, total_error
from pymdr.line.heating import LORENZ
from pymdr.mapping.moduli import EffectiveModuli
from pymdr.problem.contact import Contact
from pymdr.units import FloatArray

_WIEDEMANN_FRANZ = 0.1
SLOW = 0.1
"""Largest Peclet number of slow sliding."""

_HOTTEST = (
    "exact for contacts of any shape between metals with rho lambda = L T, equal temperatures far away and surfaces without heat "
    "loss; the hottest place is at the mean potential, which is the interface only for equal bodies"
)
_CURRENT = "; current and resistance are computed with a thermal conductivity independent of temperature"
_RUBBED = (
    "exact in the limit of Peclet number 0, for half-spaces with equal temperatures far away and surfaces without heat loss and "
    "thermal deformation"
)


def joule_claims(
    where: BoolArray, *, by_current: bool, resistance: Claim | None, known: bool
) -> dict[str, Claim]:
    """
    Claims of Joule heating.

    Parameters
    ----------
    by_current : bool
        Whether the current is given instead of the voltage.
    resistance : Claim or None
        Claim of the cold resistance of a contact.
    known : bool
        Whether the cold resistance is known.
    """
    source = SOURCES["kohlrausch"]
    exact = Claim(Level.EXACT, _HOTTEST, source, where)
    tied = Claim(Level.APPROXIMATE, _HOTTEST + _CURRENT, source, where)
    if resistance is not None and resistance.level is not Level.EXACT:
        tied = replace(tied, reason=f"{tied.reason}; of the cold resistance: {resistance.reason}")
    hottest = tied if by_current else exact
    claims = {"largest_temperature": hottest, "temperature_rise": hottest}
    if by_current:
        claims["voltage"] = tied
    elif known:
        claims["current"] = tied
    if known:
        claims["hot_resistance"] = tied
    return claims


def wiedemann_franz(contact: Contact, temperature: FloatArray) -> Assumption | None:
    """The relative difference of rho lambda from L T0 of bodies that have both; None if no body has both."""
    differences = [
        float(np.max(np.abs(body.resistivity * body.thermal_conductivity / (LORENZ * temperature) - 1.0)))
        for body in (contact.body, contact.counterbody)
        if body.resistivity is not None and body.thermal_conductivity is not None
    ]
    if not differences:
        return None
    text = "difference of rho lambda/(L T0) of the bodies from 1"
    return Assumption("Wiedemann and Franz", text, max(differences), _WIEDEMANN_FRANZ)


def slow_sliding(peclet: float) -> Assumption:
    """The assumption of slow sliding."""
    return Assumption(
        "slow sliding",
        "largest Peclet number v a/(2 kappa) of the bodies that move relative to the contact",
        peclet,
        SLOW,
    )


def frictional_heat_claims(
    contact: Contact,
    moduli: EffectiveModuli,
    where: BoolArray,
    taken_away: Mapping[str, FloatArray],
    why_no_mean: str,
) -> dict[str, Claim]:
    """
    Claims of the heat of friction.

    Parameters
    ----------
    taken_away : mapping of str to ndarray
        Fraction epsilon of the largest and the mean rise that moving bodies carry away at every speed, to first order.
    why_no_mean : str
        Why there is no mean rise; empty if there is one.

    Notes
    -----
    By Jensen's inequality the kernel exp(-z)/R of a moving body with mean z makes the rise at least exp(-epsilon) times the
    given one, so its relative error is at most exp(epsilon) - 1 if one body moves and takes the heat.
    """
    pressed = frictional_claims(contact, moduli, ("contact_radius",), where)["contact_radius"]
    neglected = "" if pressed.level is Level.EXACT else f"; {pressed.reason}"
    source = SOURCES["popov-hess"]
    claims = {}
    for name, part in taken_away.items():
        reason = f"{_RUBBED}; at the largest speed convection removes the fraction {float(np.max(part)):.2g} of it (first order)"
        known = 0.0 if pressed.error is None else pressed.error
        error = total_error(np.expm1(np.minimum(part, 1.0)), known)
        claims[name] = Claim(pressed.level, reason + neglected, source, where, error)
    if why_no_mean:
        none = np.zeros(where.shape, dtype=bool)
        claims["mean_temperature_rise"] = Claim(Level.NOT_VALID, why_no_mean, SOURCES["closure"], none)
    claims["heat"] = Claim(Level.EXACT, "exact: mu F_N v", source, where)
    return claims
