"""What can be claimed of a contact with adhesion, and when it is a disk."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from pymdr.interpretation.certificate import Certificate
from pymdr.interpretation.disks import TOLERANCE, Landscape, landscape_of, least_gap, seen_upto
from pymdr.interpretation.validity import (
    NORMAL_FIELDS,
    SOURCES,
    Assumption,
    BoolArray,
    Claim,
    Level,
)
from pymdr.line.adhesion.short_range import jkr_opening
from pymdr.line.foundation import ElasticLine
from pymdr.problem.laws import JKR, AdhesionLaw, MaugisDugdale
from pymdr.units import FloatArray, metres

_NODES = 33
"""Radii on the curve of equilibria at which the least gap is read before it is refined."""
_HALVINGS = 30


def certify_stretched_disk(
    line: ElasticLine, indentation: FloatArray, contact_radius: FloatArray, law: AdhesionLaw
) -> Certificate:
    """
    Check that the surfaces do not touch outside an adhesive contact: gap >= 0 with the stretched edge.

    Pressure is no criterion here, since tension is legitimate; that the contact has not opened inside is an
    assumption. The least gap is followed along the curve of equilibria over all radii between those of the steps.

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
    landscape = landscape_of(equivalent, top) if top > 0.0 else None
    doubtful = known & (contact_radius < equivalent.edge)
    if landscape is None or not doubtful.any():
        return Certificate(disk, "")
    a = contact_radius[doubtful]

    def margin(radius: float) -> float:
        return _margin(landscape, line.modulus, law.work, radius)

    bad = _negative(margin, float(a.min()), float(a.max()), landscape)
    inside = np.zeros(a.shape, dtype=bool)
    for low, high in bad:
        inside |= (a >= low) & (a <= high)
    disk[doubtful] = ~inside
    if not inside.any():
        return Certificate(disk, "")
    i = int(np.flatnonzero(~disk)[-1])
    worst = float(contact_radius[i])
    touch = least_gap(landscape, worst, -_opening(worst, line.modulus, law.work), loose=False)
    return Certificate(
        disk,
        f"at d = {metres(float(indentation[i]))} the surfaces touch again outside a disk of radius {metres(worst)}, at "
        f"r = {metres(touch.radius)}, so the adhesive contact is not a disk",
    )


def _opening(a: float, modulus: float, work: float) -> float:
    return float(jkr_opening(a, modulus, work))


def _margin(landscape: Landscape, modulus: float, work: float, a: float) -> float:
    """The least gap outside a disk on the curve of equilibria, over its indentation; 1 where g stays above d."""
    g = float(landscape.equivalent.g(np.array([a]))[0])
    d = g - _opening(a, modulus, work)
    beyond = landscape.radii[landscape.radii > a]
    if beyond.size == 0 or float(np.min(landscape.equivalent.g(beyond))) >= min(d, g):
        return 1.0
    return least_gap(landscape, a, d - g, loose=False).value + TOLERANCE


def _negative(
    margin: Callable[[float], float], low: float, high: float, landscape: Landscape
) -> list[tuple[float, float]]:
    """
    Intervals between two radii in which a margin, a continuous function of the radius, is negative.

    It is read at the ends of the falls of g and between them, and its least and largest values are refined where it may
    change its sign; the ends are bisected.
    """
    marks = [end for fall in landscape.falls for end in (fall.start, fall.stop)]
    a = np.unique(np.concatenate([np.linspace(low, high, _NODES), [x for x in marks if low < x < high]]))
    values = np.array([margin(float(x)) for x in a])
    for i in range(1, a.size - 1):
        left, here, right = values[i - 1 : i + 2]
        turns = (here > 0.0 and left > here < right) or (here < 0.0 and left < here > right)
        if turns:
            x, y = _extreme(margin, a[i - 1], a[i], a[i + 1], here)
            a, values = np.append(a, x), np.append(values, y)
    order = np.argsort(a, kind="stable")
    a, values = a[order], values[order]
    bad = values < 0.0
    ends = [float(a[0])] if bad[0] else []
    for j in np.flatnonzero(bad[1:] != bad[:-1]).tolist():
        left, right = float(a[j]), float(a[j + 1])
        for _ in range(_HALVINGS):
            middle = 0.5 * (left + right)
            left, right = (middle, right) if (margin(middle) < 0.0) == bad[j] else (left, middle)
        ends.append(left if bad[j] else right)
    ends += [float(a[-1])] if bad[-1] else []
    return list(zip(ends[::2], ends[1::2], strict=True))


def _extreme(
    margin: Callable[[float], float], low: float, middle: float, high: float, value: float
) -> tuple[float, float]:
    """The extreme of a margin toward 0 between three radii, until it passes 0 or is found."""
    from scipy.optimize import minimize_scalar

    sign = 1.0 if value > 0.0 else -1.0
    found = minimize_scalar(
        lambda x: sign * margin(float(x)),
        bounds=(low, high),
        method="bounded",
        options={"maxiter": _HALVINGS},
    )
    return (float(found.x), sign * float(found.fun)) if found.fun < sign * value else (middle, value)


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
