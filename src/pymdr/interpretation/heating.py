"""What can be claimed of the heat of currents and of friction."""

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
    "exact for contacts of any shape between metals that obey rho lambda = L T, whose temperatures far away are equal and whose "
    "surfaces lose no heat; the hottest place is at the mean potential, which is the interface of like bodies only"
)
_CURRENT = (
    "; current and resistance are tied to voltage and temperature as by a thermal conductivity that does not change with "
    "temperature"
)
_RUBBED = (
    "exact as the Peclet number goes to 0, for half-spaces whose temperatures far away are equal, whose surfaces lose no heat and "
    "are not bent by it"
)


def joule_claims(
    where: BoolArray, *, by_current: bool, resistance: Claim | None, known: bool
) -> dict[str, Claim]:
    """
    Claims of what a current heats.

    Parameters
    ----------
    where : ndarray of bool
        True for every row.
    by_current : bool
        Whether the current is given, and not the voltage.
    resistance : Claim or None
        That of the cold resistance, where it is of a contact.
    known : bool
        Whether the cold resistance is.

    Returns
    -------
    dict of str to Claim
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
    """How far rho lambda of bodies that say both is from L T0; None where none does."""
    apart = [
        float(np.max(np.abs(body.resistivity * body.thermal_conductivity / (LORENZ * temperature) - 1.0)))
        for body in (contact.body, contact.counterbody)
        if body.resistivity is not None and body.thermal_conductivity is not None
    ]
    if not apart:
        return None
    words = "difference of rho lambda/(L T0) of the bodies from 1"
    return Assumption("Wiedemann and Franz", words, max(apart), _WIEDEMANN_FRANZ)


def slow_sliding(peclet: float) -> Assumption:
    """That bodies move slowly below the contact."""
    return Assumption(
        "slow sliding",
        "largest Peclet number v a/(2 kappa) of bodies that move below the contact",
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
    contact : Contact
    moduli : EffectiveModuli
    where : ndarray of bool
        True for every row.
    taken_away : mapping of str to ndarray
        Share epsilon of the largest and the mean rise that moving bodies carry away at every speed, to first order.
    why_no_mean : str
        Why there is no mean; empty if there is one.

    Returns
    -------
    dict of str to Claim

    Notes
    -----
    The kernel exp(-z)/R of a body that moves is no less than by its mean z (Jensen), so that the rise is at least exp(-epsilon) of
    the one that is given: it errs by at most exp(epsilon) - 1 where one body moves and takes the heat.
    """
    pressed = frictional_claims(contact, moduli, ("contact_radius",), where)["contact_radius"]
    neglected = "" if pressed.level is Level.EXACT else f"; {pressed.reason}"
    source = SOURCES["popov-hess"]
    claims = {}
    for name, share in taken_away.items():
        told = f"{_RUBBED}; at the largest speed moving takes away {float(np.max(share)):.2g} of it, to first order"
        known = 0.0 if pressed.error is None else pressed.error
        error = total_error(np.expm1(np.minimum(share, 1.0)), known)
        claims[name] = Claim(pressed.level, told + neglected, source, where, error)
    if why_no_mean:
        nowhere = np.zeros(where.shape, dtype=bool)
        claims["mean_temperature_rise"] = Claim(Level.NOT_VALID, why_no_mean, SOURCES["closure"], nowhere)
    claims["heat"] = Claim(Level.EXACT, "exact: mu F_N v", source, where)
    return claims
