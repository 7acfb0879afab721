"""What can be claimed of a contact with friction."""

from __future__ import annotations

import math

import numpy as np

from pymdr.interpretation.traction import TANGENTIAL_FIELDS
from pymdr.interpretation.validity import NORMAL_FIELDS, SOURCES, Assumption, BoolArray, Claim, Level
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
"""Up to it the errors of sliding bodies are measured."""
_MEASURED_ERRORS = ((0.0, 0.0), (0.3, 1.5e-3), (0.5, 5e-3))
"""Poisson's ratio, and what the force was found off at most, of the largest mu F_N, where load and shift turn together."""


def frictional_claims(
    contact: Contact, moduli: EffectiveModuli, names: tuple[str, ...], everywhere: BoolArray
) -> dict[str, Claim]:
    """
    Claims of the contact with friction.

    Parameters
    ----------
    contact : Contact
    moduli : EffectiveModuli
        For Dundurs' beta.
    names : tuple of str
        Quantities of the result.
    everywhere : ndarray of bool
        True for every step.

    Returns
    -------
    mapping of str to Claim
    """
    assert contact.friction is not None
    level, reason = Level.EXACT, "exact for elastically similar half-spaces in contact on a disk"
    if contact.friction.coefficient == 0.0:
        reason = "exact for elastic half-spaces in frictionless contact on a disk"
    elif not moduli.similar:
        level = Level.APPROXIMATE
        reason = (
            "friction changes the pressure of bodies that are not elastically similar, Dundurs' beta = "
            f"{moduli.dundurs_beta:.3g}; this coupling is neglected"
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
    The measured error of tangential forces in the frame of Cattaneo and Mindlin, of the largest mu F_N so far.

    None where it was not measured: without slip, of bodies that are not similar, and outside of the measured Poisson's ratios.

    Notes
    -----
    Against vector friction on the half-space by boundary elements; between the measured ratios the chord, which lies above the
    curve through them.
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
    """Poisson's ratio by which the surfaces slide, the largest of both: 1 - S_L/S_T."""
    surfaces = [surface_compliances(body) for body in (contact.body, contact.counterbody)]
    ratios = [1.0 - one.longitudinal / one.transverse for one in surfaces if one.transverse > 0.0]
    return max(ratios, key=abs)


def _tangential(contact: Contact, moduli: EffectiveModuli) -> tuple[Level, str, str]:
    law = contact.friction
    assert law is not None
    source = SOURCES["cattaneo-mindlin"]
    if law.coefficient == 0.0:
        return Level.EXACT, "without friction nothing is carried sideways", source
    # of two bodies that are similar, sliding depends on their pressure and these compliances alone
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
            "in the frame of Cattaneo and Mindlin, which neglects the coupling of pressure and shear of bodies that "
            f"are not elastically similar (Dundurs' beta = {moduli.dundurs_beta:.3g})",
            source,
        )
    if abs(poisson) <= 1e-12:
        like = "" if isotropic else ", and for bodies that slide as if they had it"
        return (
            Level.EXACT,
            f"exact for Poisson's ratio 0{like}, where the traction of one direction makes displacements of one direction",
            source,
        )
    frame = "exact in the frame of Cattaneo and Mindlin (traction in one direction, lateral slip ignored). "
    here = f"{poisson:g} here" if isotropic else f"the surface slides as one of {poisson:.6g}, by S_L/S_T"
    if not isotropic and not -1.0 < poisson <= _LARGEST_POISSON:
        return (
            Level.APPROXIMATE,
            f"{frame}Its error is measured for Poisson's ratios up to 0.5 and not for such transversely isotropic bodies: {here}",
            source,
        )
    below = "; at -0.9 0.15 % was found under constant load" if poisson < 0.0 else ""
    return (
        Level.APPROXIMATE,
        f"{frame}Against "
        "vector friction on the half-space the force errs, of the largest mu F_N of the history, by at most 0.05 % at "
        "Poisson's ratio 0.3 and 0.17 % at 0.5 under constant load, by 0.15 % and 0.5 % where load and shift turn together "
        f"({here}{below}); the direction of slip deviates by 6 and 11 degrees and more",
        source,
    )


def similarity_assumption(dundurs_beta: float, friction: float) -> Assumption:
    """Elastic similarity, which friction needs."""
    coupled = 0.0 if friction == 0.0 else abs(dundurs_beta)
    return Assumption(
        "elastic similarity",
        "Dundurs' beta; friction couples pressure and shear",
        coupled,
        _SIMILAR,
    )
