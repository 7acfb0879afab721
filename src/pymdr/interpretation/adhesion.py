"""What can be claimed of a contact with adhesion, and when it is a disk."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pymdr.interpretation.fields import line_gap
from pymdr.interpretation.validity import (
    NORMAL_FIELDS,
    SOURCES,
    Assumption,
    BoolArray,
    Certificate,
    Claim,
    Level,
    seen_upto,
)
from pymdr.line.foundation import ElasticLine
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.problem.laws import JKR, AdhesionLaw, MaugisDugdale
from pymdr.units import FloatArray, metres

_TOLERANCE = 1e-10
_CHECKED = 400
"""Most states whose gap is integrated; those between two that are disks are taken to be disks."""


def certify_stretched_disk(
    line: ElasticLine, indentation: FloatArray, contact_radius: FloatArray, law: AdhesionLaw
) -> Certificate:
    """
    Check that the surfaces do not touch outside an adhesive contact: gap >= 0 with the stretched edge.

    Pressure is no criterion here, since tension is legitimate; that the contact has not opened inside is an
    assumption.

    Parameters
    ----------
    line : ElasticLine
        Profile and modulus.
    indentation, contact_radius : ndarray
        d and a of every step in m; nan without contact.
    law : AdhesionLaw
        Laws other than JKR are only made for rising profiles, where this holds.

    Returns
    -------
    Certificate
    """
    disk = np.ones(indentation.shape, dtype=bool)
    equivalent = line.equivalent
    known = np.isfinite(indentation) & (contact_radius > 0.0)
    if equivalent.rises or not isinstance(law, JKR) or not known.any():
        return Certificate(disk, "")
    widest, deepest = float(np.max(contact_radius[known])), float(np.max(indentation[known]))
    top = max(min(widest, equivalent.edge), seen_upto(equivalent, deepest))
    turning = equivalent.turning_points(top)
    doubtful = np.flatnonzero(known & ~_stays_above(equivalent, turning, top, contact_radius, indentation))
    if doubtful.size == 0:
        return Certificate(disk, "")
    order = doubtful[np.argsort(contact_radius[doubtful], kind="stable")]
    chosen = np.unique(np.linspace(0, order.size - 1, min(order.size, _CHECKED)).astype(int))
    checked = order[chosen]
    failures = [
        _touches_outside(equivalent, top, float(indentation[i]), float(contact_radius[i])) for i in checked
    ]
    good = np.array([not failure for failure in failures])
    between = np.searchsorted(chosen, np.arange(order.size), side="left")
    disk[order] = good[between] & good[np.maximum(between - (chosen[between] != np.arange(order.size)), 0)]
    return Certificate(disk, next((failure for failure in reversed(failures) if failure), ""))


def _stays_above(
    equivalent: EquivalentProfile, turning: tuple[float, ...], top: float, a: FloatArray, d: FloatArray
) -> BoolArray:
    """Where g stays above d outside the contact, which makes every gap positive."""
    marks = np.append(np.array(turning), top)
    lowest_beyond = np.minimum.accumulate(equivalent.g(marks)[::-1])[::-1]
    first_beyond = np.searchsorted(marks, np.nan_to_num(a), side="left").clip(0, marks.size - 1)
    return np.asarray((d <= lowest_beyond[first_beyond]) | (a >= top))


def _touches_outside(equivalent: EquivalentProfile, top: float, d: float, a: float) -> str:
    if a >= top:
        return ""
    r = a + (top - a) * ((np.arange(96) + 0.5) / 96) ** 2
    h = line_gap(equivalent, a, d - float(equivalent.g(np.array([a]))[0]), r)
    if h.min() >= -_TOLERANCE * max(abs(d), float(np.max(np.abs(equivalent.g(r))))):
        return ""
    return (
        f"at d = {metres(d)} the surfaces touch again outside a disk of radius {metres(a)}, at r = {metres(r[h.argmin()])}, "
        "so the adhesive contact is not a disk"
    )


def adhesive_claims(
    law: AdhesionLaw, names: Sequence[str], disk: BoolArray, why: str, maugis: float
) -> dict[str, Claim]:
    """
    Claims of the contact with adhesion.

    Parameters
    ----------
    law : AdhesionLaw
    names : sequence of str
        Quantities of the result.
    disk : ndarray of bool
        Steps at which the disk is certified.
    why : str
        Why it is not elsewhere.
    maugis : float
        Maugis' parameter, where the range of the attraction and the radius of the tip are known; else nan.

    Returns
    -------
    mapping of str to Claim
    """
    level, reason, source = _of_law(law, maugis)
    if not disk.all():
        reason += f"; {int((~disk).sum())} of {disk.size} steps are not a disk: {why}"
    if not disk.any():
        level, reason = Level.NOT_VALID, why
    claim = Claim(level, reason, source, disk)
    return dict.fromkeys((*names, *NORMAL_FIELDS), claim)


def _of_law(law: AdhesionLaw, maugis: float) -> tuple[Level, str, str]:
    if isinstance(law, JKR):
        return (
            Level.EXACT,
            "exact for elastic half-spaces that attract each other only where they touch (a Griffith edge), in "
            "frictionless contact on a disk that has not opened inside",
            SOURCES["hess"],
        )
    if isinstance(law, MaugisDugdale):
        return (
            Level.EXACT,
            "exact for elastic half-spaces in frictionless contact that attract each other by a constant stress "
            "up to its range; that the gap stays positive in the cohesive zone is assumed",
            SOURCES["maugis"],
        )
    measured = "unknown here, give DMT(work, range=...)" if math.isnan(maugis) else f"{maugis:.3g} here"
    return (
        Level.APPROXIMATE,
        "the limit of Maugis and Dugdale for stiff, small bodies: the attraction does not deform them; its errors "
        f"are of the order of Maugis' parameter, which should be below 0.1 and is {measured}",
        SOURCES["dmt"],
    )


def energy_assumption(residual: float) -> Assumption:
    """The energy balance as a measured condition."""
    return Assumption(
        "energy balance",
        "work by quadrature less the change of energy and what the jumps dissipate, over the largest of them,",
        residual,
        1e-8,
    )
