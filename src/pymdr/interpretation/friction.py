"""Claims of a contact with friction."""

from __future__ import annotations

import math

import numpy as np

from pymdr.interpretation.validity import (
    NORMAL_FIELDS,
    SOURCES,
    TANGENTIAL_FIELDS,
    Assumption,
    BoolArray,
    Claim,
    Level,
)
from pymdr.mapping.moduli import EffectiveModuli, surface_compliances
from pymdr.problem.contact import Contact

TANGENTIAL_QUANTITIES = (
    "tangential_force",
    "tangential_stiffness",
    "stick_radius",
    "slip_distance",
    "stored_tangential_energy",
    "dissipated_energy",
    "shift",
)
_SIMILAR = 0.01
_LARGEST_POISSON = 0.5
"""Largest Poisson's ratio for which the errors were measured."""
_MEASURED_ERRORS = ((0.0, 0.0), (0.3, 1.5e-3), (0.5, 5e-3))
"""Poisson's ratio and the largest measured error of the force over the largest mu F_N, when load and shift reverse together."""


def frictional_claims(
    contact: Contact, moduli: EffectiveModuli, names: tuple[str, ...], everywhere: BoolArray
) -> dict[str, Claim]:
    """
    Claims of a contact with friction.

    Parameters
    ----------
    moduli : EffectiveModuli
        For Dundurs' beta.
    """
    assert contact.friction is not None
    level, reason = Level.EXACT, "exact for elastically similar half-spaces in contact on a disk"
    if contact.friction.coefficient == 0.0:
        reason = "exact for elastic half-spaces in frictionless contact on a disk"
    elif not moduli.similar:
        level = Level.APPROXIMATE
        reason = (
            "the bodies are not elastically similar, so friction changes the pressure (Dundurs' beta = "
            f"{moduli.dundurs_beta:.3g}); this coupling is neglected"
        )
    normal = Claim(level, reason, SOURCES["sneddon"], everywhere)
    tangential = Claim(*_tangential(contact, moduli), everywhere)
    return {
        **{name: tangential if name in TANGENTIAL_QUANTITIES else normal for name in names},
        **dict.fromkeys(NORMAL_FIELDS, normal),
        **dict.fromkeys(TANGENTIAL_FIELDS, tangential),
    }


def frame_error(contact: Contact, moduli: EffectiveModuli) -> float | None:
    """
    The measured error of tangential forces in the frame of Cattaneo and Mindlin, over the largest mu F_N so far.

    None where it was not measured: without slip, for dissimilar bodies, and outside the measured Poisson's ratios.

    Notes
    -----
    Compared with vector friction on the half-space by boundary elements; interpolated linearly between the measured ratios,
    which is an upper bound.
    """
    assert contact.friction is not None
    if not moduli.similar or math.isinf(contact.friction.coefficient):
        return None
    poisson = _sliding_ratio(contact)
    if not -1e-12 <= poisson <= _LARGEST_POISSON + 1e-12:
        return None
    ratios, errors = zip(*_MEASURED_ERRORS, strict=True)
    return float(np.interp(poisson, ratios, errors))


def _sliding_ratio(contact: Contact) -> float:
    """Effective Poisson's ratio 1 - S_L/S_T of tangential loading, the larger of both surfaces."""
    surfaces = [surface_compliances(body) for body in (contact.body, contact.counterbody)]
    ratios = [1.0 - one.longitudinal / one.transverse for one in surfaces if one.transverse > 0.0]
    return max(ratios, key=abs)


def _tangential(contact: Contact, moduli: EffectiveModuli) -> tuple[Level, str, str]:
    law = contact.friction
    assert law is not None
    source = SOURCES["cattaneo-mindlin"]
    if law.coefficient == 0.0:
        return Level.EXACT, "exact: without friction there is no tangential load", source
    # for similar bodies slip depends only on the pressure and these compliances
    surfaces = [surface_compliances(body) for body in (contact.body, contact.counterbody)]
    poisson = _sliding_ratio(contact)
    isotropic = all(
        max(abs(one.longitudinal - one.normal), abs(one.coupling - 2.0 * one.normal + one.transverse))
        <= 1e-12 * one.transverse
        for one in surfaces
    )
    if not moduli.similar:
        return (
            Level.APPROXIMATE,
            "in the frame of Cattaneo and Mindlin, which neglects the coupling of pressure and shear of elastically "
            f"dissimilar bodies (Dundurs' beta = {moduli.dundurs_beta:.3g})",
            source,
        )
    if abs(poisson) <= 1e-12:
        like = "" if isotropic else " and for bodies with S_L = S_T"
        return (
            Level.EXACT,
            f"exact for Poisson's ratio 0{like}, where traction in one direction makes displacements only in that direction",
            source,
        )
    frame = "exact in the frame of Cattaneo and Mindlin (traction in one direction, lateral slip ignored). "
    here = f"Poisson's ratio {poisson:g} here" if isotropic else f"here 1 - S_L/S_T = {poisson:.6g}"
    if not isotropic and not -1.0 < poisson <= _LARGEST_POISSON:
        return (
            Level.APPROXIMATE,
            f"{frame}Its error is known for Poisson's ratios up to 0.5 but not for such transversely isotropic bodies: {here}",
            source,
        )
    below = "; 0.15 % under constant load at -0.9" if poisson < 0.0 else ""
    return (
        Level.APPROXIMATE,
        f"{frame}Compared with "
        "vector friction on the half-space, the error of the force is at most 0.05 % of the largest mu F_N of the history at "
        "Poisson's ratio 0.3 and 0.17 % at 0.5 under constant load, 0.15 % and 0.5 % when load and shift reverse together "
        f"({here}{below}); the direction of slip deviates by at least 6 and 11 degrees",
        source,
    )


def similarity_assumption(dundurs_beta: float, friction: float) -> Assumption:
    """The assumption of elastic similarity in a contact with friction."""
    coupled = 0.0 if friction == 0.0 else abs(dundurs_beta)
    return Assumption(
        "elastic similarity", "Dundurs' beta; friction couples pressure and shear", coupled, _SIMILAR
    )
