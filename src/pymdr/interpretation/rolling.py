"""Kalker's creep coefficients, and the claims of a rolling contact."""

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
"""Relative difference between boundary elements and the parabola through that table."""
_ABOVE_CUBIC = 0.04
"""Largest excess of boundary elements with friction above the cubic with Kalker's slope, over mu F_N."""
_SATURATES = (0.77, 0.84)
"""Creepage at saturation by boundary elements, over that of the cubic."""


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

    Notes
    -----
    Kalker (1990), Three-Dimensional Elastic Bodies in Rolling Contact. Boundary elements give 4.31 and 3.75 at nu = 0.3,
    and 0.5 % more than the table at its ends.

    Examples
    --------
    >>> round(kalker_coefficient(0.3), 4), round(kalker_coefficient(0.3, "lateral"), 4)
    (4.3072, 3.7288)
    """
    if not 0.0 <= poisson <= 0.5:
        raise ProblemError(
            f"Poisson's ratio = {poisson:g}, but Kalker's coefficients are known for 0 to 0.5; use law='plain'"
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
    """The constants of two isotropic bodies, of which one may be rigid; None for other bodies."""
    bodies = [body for body in (contact.body, contact.counterbody) if not isinstance(body, Rigid)]
    elastic = [body for body in bodies if isinstance(body, Elastic)]
    if len(elastic) < len(bodies):
        return None
    softness = sum(1.0 / body.shear for body in elastic)
    return KalkerPair(2.0 / softness, sum(body.poisson / body.shear for body in elastic) / softness)


def calibrated_modulus(contact: Contact, moduli: EffectiveModuli, direction: str) -> float:
    """
    The modulus C G / 2 in Pa that replaces G* and gives the springs Kalker's slope.

    With it xi becomes xi_K = C G a^2 zeta / (3 mu F_N) for a paraboloid.

    Notes
    -----
    Shen, Hedrick and Elkins (1983), with Kalker's coefficients.
    """
    pair = kalker_pair(contact)
    if pair is None:
        raise ProblemError(
            "law='calibrated' needs isotropic bodies; Kalker's coefficients are not known for "
            f"{contact.body!r} on {contact.counterbody!r}; use law='plain'"
        )
    if contact.profile.tip_radius is None:
        raise ProblemError(
            "law='calibrated' needs a round tip (Hertz contact, for which Kalker's coefficients and the law of saturation "
            f"are known), not a {type(contact.profile).__name__}; use law='plain'"
        )
    if not moduli.similar:
        raise ProblemError(
            "law='calibrated' needs elastically similar bodies, because Kalker's coefficients neglect the coupling of "
            f"pressure and shear; Dundurs' beta = {moduli.dundurs_beta:.3g}, not 0; use law='plain'"
        )
    return 0.5 * kalker_coefficient(pair.poisson, direction) * pair.shear


def unknown_error_reason(contact: Contact, moduli: EffectiveModuli) -> str:
    """Why the error of creep forces is unknown; empty if it is known."""
    pair = kalker_pair(contact)
    if type(contact.profile) not in (Paraboloid, Sphere):
        return f"it was measured only for paraboloids and spheres, not for a {type(contact.profile).__name__}"
    if pair is None or not 0.0 <= pair.poisson <= 0.5:
        return "it was measured only for isotropic bodies with Poisson's ratios 0 to 0.5"
    if not moduli.similar:
        return "it was measured only without the coupling of pressure and shear"
    return ""


def creep_error(force_fraction: FloatArray, calibrated: FloatArray, linear: FloatArray) -> FloatArray:
    """
    Largest relative error of creep forces compared with the exact theory of rolling.

    The exact force is between that of the calibrated springs and the least of that plus 0.04 mu F_N, Kalker's linear force and
    mu F_N.

    Parameters
    ----------
    force_fraction : ndarray
        |F_x|/(mu F_N) of the law.
    calibrated : ndarray
        |F_x|/(mu F_N) of the springs with Kalker's slope.
    linear : ndarray
        |F_x|/(mu F_N) of Kalker's linear theory, C G a^2 zeta/(mu F_N).

    Returns
    -------
    ndarray
        Relative to the exact force.

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
        error = np.max([np.abs(force_fraction / high - 1.0), np.abs(force_fraction / low - 1.0)], axis=0)
    return np.where(calibrated > 0.0, error, 0.0)


def saturation_error(ratio: float) -> float:
    """Largest relative error of the creepage at full slip; `ratio` is this creepage over that of the calibrated springs."""
    return max(abs(ratio / fraction - 1.0) for fraction in _SATURATES)


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
    errors : mapping of str to ndarray
        Known errors of the law by quantity, relative to the exact theory.
    """
    reason, source = _plain(contact, moduli, direction), SOURCES["popov-hess"]
    if law == "calibrated":
        reason, source = _calibrated(contact, direction), SOURCES["kalker"]
    if contact.profile.tip_radius is None:
        reason += "; the gap is assumed constant in rolling, which is true only for round tips"
    if why := unknown_error_reason(contact, moduli):
        reason += f"; the error at these creepages is unknown: {why}"
    elif "creep_force" not in errors:
        reason += (
            "; the error along a path is unknown: the comparison with Kalker's theory is for steady rolling"
        )

    def claim(name: str, text: str) -> Claim:
        return Claim(Level.APPROXIMATE, text, source, everywhere, errors.get(name))

    force = claim("creep_force", reason)
    on_line = f"for the springs, not for the surface: {reason}"
    unknown = "springs along one line do not determine the distribution of slip over a rolling contact; only the force is given"
    nowhere = np.zeros(everywhere.shape, dtype=bool)
    local = Claim(Level.NOT_VALID, unknown, SOURCES["popov-hess"], nowhere)
    return {
        "creep_force": force,
        "traction_coefficient": force,
        "slip_length": claim("slip_length", on_line),
        "saturation_creepage": claim("saturation_creepage", on_line),
        "shear_traction": local,
        "slip": local,
    }


def _plain(contact: Contact, moduli: EffectiveModuli, direction: str) -> str:
    general = "the slope of the springs, 2 G* a^2, is 33 to 49 % below Kalker's linear theory"
    pair = kalker_pair(contact)
    if pair is None:
        return f"{general} for isotropic bodies; the error for transversely isotropic bodies is unknown"
    if not moduli.similar:
        return (
            f"{general} for similar bodies; the coupling of pressure and shear is neglected (Dundurs' beta = "
            f"{moduli.dundurs_beta:.3g})"
        )
    if not 0.0 <= pair.poisson <= 0.5:
        return f"{general} for Poisson's ratios 0 to 0.5; the error at {pair.poisson:g} is unknown"
    fraction = 2.0 * moduli.tangential / (kalker_coefficient(pair.poisson, direction) * pair.shear)
    return (
        f"{general} ({100.0 * (1.0 - fraction):.0f} % here, {direction}, Poisson's ratio {pair.poisson:.3g})"
    )


def _calibrated(contact: Contact, direction: str) -> str:
    few, many = _SATURATES
    return (
        f"Kalker's slope, with a cubic to saturation: compared with boundary elements with friction ({direction}, Poisson's ratios 0 "
        f"to 0.5) the force of a paraboloid is too small by at most {_ABOVE_CUBIC:g} mu F_N, at half of the saturation creepage; "
        f"boundary elements saturate at {few:g} to {many:g} of the creepage of the cubic"
    )
