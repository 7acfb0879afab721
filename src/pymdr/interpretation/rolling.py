"""Kalker's coefficients of creep, and what can be claimed of a rolling contact."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ProblemError
from pymdr.interpretation.validity import SOURCES, BoolArray, Claim, Level
from pymdr.mapping.moduli import EffectiveModuli
from pymdr.problem.contact import Contact
from pymdr.problem.materials import Elastic, Rigid
from pymdr.problem.profiles import Paraboloid, Sphere
from pymdr.units import FloatArray

DIRECTIONS = ("longitudinal", "lateral")
LAWS = ("plain", "calibrated")

_POISSON = (0.0, 0.25, 0.5)
_KALKER = {"longitudinal": (3.40, 4.12, 5.20), "lateral": (3.40, 3.67, 3.98)}
"""C11 and C22 of a circular contact over Poisson's ratio: Kalker (1990), a/b = 1."""
_TABLE = 0.01
"""By how much boundary elements differ from that table and the parabola through it."""
_ABOVE_CUBIC = 0.04
"""Of mu F_N: by how much boundary elements with friction are above the cubic with Kalker's slope, at most."""
_SATURATES = (0.77, 0.84)
"""Of the saturation of that cubic: where boundary elements reach it."""


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


def has_known_error(contact: Contact, moduli: EffectiveModuli) -> str:
    """Why the error of creep forces is not known; empty where it is."""
    pair = kalker_pair(contact)
    if type(contact.profile) not in (Paraboloid, Sphere):
        return f"it was measured for paraboloids and spheres only, not for a {type(contact.profile).__name__}"
    if pair is None or not 0.0 <= pair.poisson <= 0.5:
        return "it was measured for isotropic bodies with Poisson's ratios 0 to 0.5 only"
    if not moduli.similar:
        return "it was measured without the coupling of pressure and shear only"
    return ""


def creep_error(share: FloatArray, calibrated: FloatArray, linear: FloatArray) -> FloatArray:
    """
    Largest relative error of creep forces against the exact theory of rolling.

    The exact force lies between that of the calibrated springs and the least of that plus 0.04 mu F_N, Kalker's linear force and
    mu F_N.

    Parameters
    ----------
    share : ndarray
        |F_x|/(mu F_N) of the law whose error is asked for.
    calibrated : ndarray
        That of the springs with Kalker's slope.
    linear : ndarray
        That of Kalker's linear theory, C G a^2 zeta/(mu F_N).

    Returns
    -------
    ndarray
        Over the exact force.

    Notes
    -----
    Boundary elements on up to 48 x 48 cells with friction in one direction, Poisson's ratios 0, 0.3 and 0.5, longitudinal and
    lateral: 0 to 0.04 mu F_N above the cubic. Kalker's coefficients are known to 1 %.

    Examples
    --------
    >>> creep_error(np.array([0.055e-3]), np.array([0.1e-3]), np.array([0.1e-3])).round(3).tolist()
    [0.455]
    """
    high = np.minimum(np.minimum(calibrated + _ABOVE_CUBIC, (1.0 + _TABLE) * linear), 1.0)
    low = calibrated * (1.0 - _TABLE * (1.0 - calibrated))
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.max([np.abs(share / high - 1.0), np.abs(share / low - 1.0)], axis=0)
    return np.where(calibrated > 0.0, found, 0.0)


def saturation_error(ratio: float) -> float:
    """That of the creepage at which all slips, over the exact one; `ratio` is it over that of the calibrated springs."""
    return max(abs(ratio / share - 1.0) for share in _SATURATES)


def rolling_claims(
    contact: Contact,
    moduli: EffectiveModuli,
    direction: str,
    law: str,
    errors: Mapping[str, FloatArray],
    everywhere: BoolArray,
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
    errors : mapping of str to ndarray
        Those of the law by quantity, relative to the exact theory, as far as they are known.
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
    if why := has_known_error(contact, moduli):
        reason += f"; the error at these creepages is not known: {why}"
    elif "creep_force" not in errors:
        reason += "; how far forces along a path are off is not known: Kalker's theory was compared for steady rolling only"

    def claim(name: str, words: str) -> Claim:
        return Claim(Level.APPROXIMATE, words, source, everywhere, errors.get(name))

    force = claim("creep_force", reason)
    on_line = f"of the springs, not of the surface: {reason}"
    local = Claim(
        Level.NOT_VALID,
        "springs along one line do not know how slip is spread over a rolling contact; only the force is given",
        SOURCES["popov-hess"],
        np.zeros(everywhere.shape, dtype=bool),
    )
    return {
        "creep_force": force,
        "traction_coefficient": force,
        "slip_length": claim("slip_length", on_line),
        "saturation_creepage": claim("saturation_creepage", on_line),
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
    few, many = _SATURATES
    return (
        f"the slope is Kalker's, the way to saturation a cubic: against boundary elements with friction ({direction} too, Poisson's "
        f"ratios 0 to 0.5) the force of a paraboloid is too small by at most {_ABOVE_CUBIC:g} mu F_N, at half of the saturation, which "
        f"there is reached at {few:g} to {many:g} of that of the cubic"
    )
