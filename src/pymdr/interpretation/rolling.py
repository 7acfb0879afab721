"""Kalker's coefficients of creep, and what can be claimed of a rolling contact."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ProblemError
from pymdr.interpretation.validity import SOURCES, BoolArray, Claim, Level
from pymdr.mapping.moduli import EffectiveModuli
from pymdr.problem.contact import Contact
from pymdr.problem.materials import Elastic, Rigid
from pymdr.problem.profiles import Paraboloid

DIRECTIONS = ("longitudinal", "lateral")
LAWS = ("plain", "calibrated")

_POISSON = (0.0, 0.25, 0.5)
_KALKER = {"longitudinal": (3.40, 4.12, 5.20), "lateral": (3.40, 3.67, 3.98)}
"""C11 and C22 of a circular contact over Poisson's ratio: Kalker (1990), a/b = 1."""
_MEASURED_POISSON = 0.3
_MEASURED = 0.036


def kalker_coefficient(poisson: float, direction: str = "longitudinal") -> float:
    """
    Kalker's coefficient of a circular contact, F = C G a^2 zeta for small creepages.

    The parabola through C11 = 3.40, 4.12, 5.20 and C22 = 3.40, 3.67, 3.98 at nu = 0, 1/4, 1/2.

    Parameters
    ----------
    poisson : float
        Poisson's ratio of the pair, 0 to 0.5.
    direction : str
        "longitudinal" (C11) or "lateral" (C22).

    Returns
    -------
    float

    Raises
    ------
    ProblemError
        If there is no coefficient: outside the table.

    Notes
    -----
    Kalker (1990), Three-Dimensional Elastic Bodies in Rolling Contact. Boundary elements gave 4.31 and 3.75 at nu = 0.3,
    and 0.5 % more than the table at its ends.

    Examples
    --------
    >>> round(kalker_coefficient(0.3), 4), round(kalker_coefficient(0.3, "lateral"), 4)
    (4.3072, 3.7288)
    """
    if not 0.0 <= poisson <= 0.5:
        raise ProblemError(
            f"rolling: Kalker's coefficients are known for Poisson's ratios 0 to 0.5, not for {poisson:g}; "
            "take law='plain'"
        )
    low, middle, high = _KALKER[direction]
    u = poisson / _POISSON[1]
    return low + u * (middle - low) + 0.5 * u * (u - 1.0) * (low - 2.0 * middle + high)


@dataclass(frozen=True)
class KalkerPair:
    """Elastic constants of a pair as Kalker defines them."""

    shear: float
    """G in Pa, 1/G = (1/G1 + 1/G2)/2."""
    poisson: float
    """The ratio nu, nu/G = (nu1/G1 + nu2/G2)/2."""


def kalker_pair(contact: Contact) -> KalkerPair | None:
    """The constants of two isotropic bodies, one of which may be rigid; None for other bodies."""
    bodies = [body for body in (contact.body, contact.counterbody) if not isinstance(body, Rigid)]
    elastic = [body for body in bodies if isinstance(body, Elastic)]
    if len(elastic) < len(bodies):
        return None
    softness = sum(1.0 / body.shear for body in elastic)
    return KalkerPair(2.0 / softness, sum(body.poisson / body.shear for body in elastic) / softness)


def calibrated_modulus(contact: Contact, moduli: EffectiveModuli, direction: str) -> float:
    """
    The modulus in Pa that gives the springs Kalker's slope, C G / 2 in the place of G*.

    With it xi becomes xi_K = C G a^2 zeta / (3 mu F_N) for a paraboloid.

    Raises
    ------
    ProblemError
        If the pair or the profile has no calibration, with the reason.

    Notes
    -----
    Shen, Hedrick and Elkins (1983), with Kalker's coefficients.
    """
    pair = kalker_pair(contact)
    if pair is None:
        raise ProblemError(
            "rolling: law='calibrated' needs isotropic bodies: Kalker's coefficients are not known for "
            f"{contact.body!r} on {contact.counterbody!r}; take law='plain'"
        )
    if contact.profile.tip_radius is None:
        raise ProblemError(
            f"rolling: law='calibrated' needs a round tip, Hertz's contact, for which Kalker's coefficients and the law of "
            f"saturation hold, and not a {type(contact.profile).__name__}; take law='plain'"
        )
    if not moduli.similar:
        raise ProblemError(
            "rolling: law='calibrated' needs elastically similar bodies: Kalker's coefficients leave out the coupling of "
            f"pressure and shear, Dundurs' beta = {moduli.dundurs_beta:.3g} here and not 0; take law='plain'"
        )
    return 0.5 * kalker_coefficient(pair.poisson, direction) * pair.shear


def rolling_claims(
    contact: Contact, moduli: EffectiveModuli, direction: str, law: str, everywhere: BoolArray
) -> dict[str, Claim]:
    """
    Claims of a rolling contact.

    Parameters
    ----------
    contact : Contact
    moduli : EffectiveModuli
    direction : str
        "longitudinal" or "lateral".
    law : str
        "plain" or "calibrated".
    everywhere : ndarray of bool
        True for every row.

    Returns
    -------
    dict of str to Claim
    """
    reason, source = _plain(contact, moduli, direction), SOURCES["popov-hess"]
    if law == "calibrated":
        reason, source = _calibrated(contact, direction), SOURCES["kalker"]
    if contact.profile.tip_radius is None:
        reason += "; the gap is taken to stay as it is, which only round tips see to when they roll"
    force = Claim(Level.APPROXIMATE, reason, source, everywhere)
    on_line = Claim(Level.APPROXIMATE, f"of the springs, not of the surface: {reason}", source, everywhere)
    local = Claim(
        Level.NOT_VALID,
        "springs along one line do not know how slip is spread over a rolling contact; only the force is given",
        SOURCES["popov-hess"],
        np.zeros(everywhere.shape, dtype=bool),
    )
    return {
        "creep_force": force,
        "traction_coefficient": force,
        "slip_length": on_line,
        "saturation_creepage": on_line,
        "shear_traction": local,
        "slip": local,
    }


def _plain(contact: Contact, moduli: EffectiveModuli, direction: str) -> str:
    general = "the slope of the springs, 2 G* a^2, is 33 to 49 % too small against Kalker's linear theory"
    pair = kalker_pair(contact)
    if pair is None:
        return f"{general} of isotropic bodies; for transversely isotropic ones this is not measured"
    if not moduli.similar:
        return (
            f"{general} of similar bodies; the coupling of pressure and shear, Dundurs' beta = {moduli.dundurs_beta:.3g}, "
            "is neglected"
        )
    if not 0.0 <= pair.poisson <= 0.5:
        return f"{general} for Poisson's ratios 0 to 0.5; at {pair.poisson:g} this is not measured"
    share = 2.0 * moduli.tangential / (kalker_coefficient(pair.poisson, direction) * pair.shear)
    return f"{general} ({100.0 * (1.0 - share):.0f} % here, {direction}, Poisson's ratio {pair.poisson:.3g})"


def _calibrated(contact: Contact, direction: str) -> str:
    pair = kalker_pair(contact)
    assert pair is not None
    law = "the slope is Kalker's, the way to saturation a cubic"
    measured = (
        isinstance(contact.profile, Paraboloid)
        and direction == "longitudinal"
        and math.isclose(pair.poisson, _MEASURED_POISSON, rel_tol=1e-9)
    )
    if measured:
        return (
            f"{law}: against boundary elements with friction the force is too small by at most {_MEASURED:g} mu F_N, at "
            "half of the saturation, which there is reached at three quarters of that of the cubic"
        )
    return f"{law}, whose error was measured for a paraboloid at Poisson's ratio {_MEASURED_POISSON:g}, longitudinal, only"
