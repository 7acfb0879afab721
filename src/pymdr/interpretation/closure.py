"""Claims of a contact that is known only by its force curve."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pymdr.errors import ProblemError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.validity import SOURCES, BoolArray, Claim, Level, total_error
from pymdr.mapping.closure import Closure
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.contact import Contact
from pymdr.problem.materials import common_exponent
from pymdr.problem.profiles import ForceCurve
from pymdr.units import FloatArray

OF_THE_CURVE = frozenset(
    {
        "indentation",
        "travel",
        "normal_force",
        "normal_stiffness",
        "elastic_energy",
        "effective_modulus",
        "external_work",
        "dissipated_energy",
        "shift",
        "tangential_force",
        "tangential_stiffness",
        "stored_tangential_energy",
        "slip_distance",
        "slip_work",
        "thermal_conductance",
        "electrical_resistance",
    }
)
"""Quantities that a force curve determines."""
_ON_A_DISK = " on a disk"
"""Words in the reasons of laws that need a known shape."""
_GROWTH = 1e-6
"""Least growth of a contact that counts, over its largest size."""
_DISTINCT = 1e-9
"""Least distance between distinct rows, over the largest depth."""
ASSUMED = "as exact as the force curve, for contacts of any shape between half-spaces with small slopes, without adhesion and tilt"
_MEMORY = (
    "for viscoelastic half-spaces whose contact grows (Lee and Radok 1960), or grows and then shrinks (Ting 1966); only for a growing "
    "contact is it proven that the contact depends on the depth alone"
)
_REGROWN = (
    "the contact grows again after shrinking; for contacts of any shape it is not proven that it then depends on the depth "
    "alone"
)
_NOT_IN_IT = (
    "not determined by a force curve: contacts of different area and pressure have the same curve, and the contact length on "
    "the line is not a radius; give the shape as a profile, or solve it by boundary elements"
)
_UNKNOWN = (
    "the points do not determine it at these depths: the curves that they allow differ by as much as its value; press deeper, "
    "or measure more points there"
)


class Slip(NamedTuple):
    """What slips in the rows of a contact with friction."""

    stuck: FloatArray
    """Depths in m at which the contact is as large as the part that sticks, whose stiffness is the tangential one."""
    opposed: Mapping[str, FloatArray]
    """Sum of the magnitudes of all parts over that of their sum, which is far smaller where parts cancel."""


def closure_claims(
    claims: Mapping[str, Claim],
    closure: Closure,
    depth: FloatArray,
    remembered: BoolArray | None = None,
    *,
    sheared: bool = False,
    prescribed: Mapping[str, BoolArray] | None = None,
    balance: FloatArray | None = None,
    slip: Slip | None = None,
) -> dict[str, Claim]:
    """
    Claims of a law for a contact that is known by its force curve.

    Parameters
    ----------
    depth : ndarray
        Indentations in m of the rows.
    remembered : ndarray of bool, optional
        With memory: rows from the first regrowth after shrinking on.
    prescribed : mapping of str to ndarray of bool, optional
        Rows in which a quantity is prescribed and therefore known.
    balance : ndarray of shape (2, n), optional
        Work of the tangential force and stored energy, over the dissipated energy; inf where unknown. Their difference bounds the
        error of the dissipation where the rise of the stiffness does not, as in sliding.
    slip : Slip, optional
        With friction.
    """
    is_viscoelastic = remembered is not None or sheared
    both = closure.error, closure.given_error
    errors, given = (closure_errors(one, depth, is_viscoelastic=is_viscoelastic) for one in both)
    if slip is not None:
        for each, error_at in zip((errors, given), both, strict=True):
            of_stuck = np.where(slip.stuck > 0.0, error_at(slip.stuck)[0], 0.0)
            for name in ("tangential_stiffness", "stored_tangential_energy"):
                each[name] = np.maximum(each[name], of_stuck)
    if balance is not None:
        unknown = ~(errors["dissipated_energy"] + np.nan_to_num(given["dissipated_energy"]) < 1.0)
        unknown &= np.isfinite(balance).all(axis=0)
        work, stored = np.where(unknown, balance, 0.0)
        for each in (errors, given):
            bound = work * each["tangential_force"] + stored * each["stored_tangential_energy"]
            each["dissipated_energy"] = np.where(unknown, bound, each["dissipated_energy"])
    known = dict(prescribed or {})
    if slip is not None:
        for name, factor in slip.opposed.items():
            # values near 0 stay: they are known to a part of mu F_N, or of the largest energy
            size = errors[name] + np.nan_to_num(given[name])
            known[name] = known.get(name, False) | (size < 1.0)
            for each in (errors, given):
                each[name] = np.where(each[name] > 0.0, each[name] * factor, each[name])
    remark = "; only the scatter of the points is known: ForceCurve.error was not given"
    if closure.given is not None:
        remark = "; errors include those of the points"
    adjusted: dict[str, Claim] = {}
    for name, claim in claims.items():
        if name not in OF_THE_CURVE:
            nowhere = np.zeros(claim.where.shape, dtype=bool)
            adjusted[name] = Claim(Level.NOT_VALID, _NOT_IN_IT, SOURCES["closure"], nowhere)
        elif claim.level is Level.NOT_VALID or claim.reason.startswith("prescribed"):
            adjusted[name] = replace(claim, reason=claim.reason.replace(_ON_A_DISK, ""))
        else:
            own = _of_curve(claim, (errors[name], given[name]), remembered, known.get(name, False))
            adjusted[name] = _with_given(own, given[name], remark)
    return adjusted


def _of_curve(
    claim: Claim, errors: tuple[FloatArray, FloatArray], remembered: BoolArray | None, known: BoolArray | bool
) -> Claim:
    """The claim of a law for a contact given by its force curve, valid where a value is known or the errors are below 1."""
    error, given = errors
    reason_of_law, level = claim.reason.replace(_ON_A_DISK, ""), claim.level
    if remembered is not None:
        reason_of_law = f"{_MEMORY}; {reason_of_law}" if level is Level.APPROXIMATE else _MEMORY
        if remembered.any():
            reason_of_law, level = f"{reason_of_law}; {_REGROWN}", Level.APPROXIMATE
    words = f"{ASSUMED}. {reason_of_law[:1].upper()}{reason_of_law[1:]}"
    sources = f"{claim.source}; {SOURCES['closure']}"
    own = replace(claim, level=level, reason=words, source=sources)
    total = total_error(error, claim.error)
    whole = (error if total is None else total) + np.nan_to_num(given)
    where = claim.where & ((whole < 1.0) | known)
    if claim.where.any() and not where.any():
        return Claim(Level.NOT_VALID, _UNKNOWN, SOURCES["closure"], where)
    if where.sum() < claim.where.sum():
        own = replace(own, where=where, reason=f"{own.reason}; not valid where {_UNKNOWN}")
    if total is None:
        return own
    return with_errors({"": own}, {"": error}, "", "from other curves that the points allow")[""]


def _with_given(claim: Claim, given: FloatArray, remark: str) -> Claim:
    """A claim with the errors of the points added; its error is None where they are unknown."""
    if claim.level is Level.NOT_VALID:
        return claim
    if np.isnan(given[claim.where]).any():
        unknown = f"{claim.reason}; the errors of the points of the curve are unknown"
        return replace(claim, level=Level.APPROXIMATE, reason=unknown, error=None)
    reason = f"{claim.reason}{remark}"
    if claim.error is None:
        return replace(claim, reason=reason)
    error = np.where(claim.where, given, 0.0)
    return with_errors(
        {"": replace(claim, reason=reason)}, {"": error}, "", "from the points of the force curve"
    )[""]


def closure_errors(
    error_at: Callable[[FloatArray], FloatArray], depth: FloatArray, *, is_viscoelastic: bool
) -> dict[str, FloatArray]:
    """
    Relative errors of the quantities of a force curve, from those of k, F and U at its depths.

    Parameters
    ----------
    error_at : callable
        Relative errors of k, F, U and the rise of k at depths in m, shape (4, n).
    depth : ndarray
        Indentations in m of the rows.
    is_viscoelastic : bool
        Whether rows depend on earlier rows, and so on the largest depth so far.
    """
    known = np.nan_to_num(depth)
    # without contact all quantities are 0 and exact
    stiffness, force, energy, rise = np.where(known > 0.0, error_at(known), 0.0)
    if is_viscoelastic and depth.size:
        deepest = np.maximum.accumulate(known)
        before = np.where(deepest > 0.0, error_at(deepest), 0.0)
        stiffness, force, energy, rise = np.maximum((stiffness, force, energy, rise), before)
    slid = stiffness + force
    given = {
        "normal_stiffness": stiffness,
        "elastic_energy": energy,
        "external_work": energy,
        "dissipated_energy": slid + rise,
        "stored_tangential_energy": slid + energy,
        "slip_work": slid + energy,
        "tangential_force": slid,
        "tangential_stiffness": stiffness,
        "shift": slid,
        "slip_distance": slid,
        "thermal_conductance": stiffness,
        "electrical_resistance": stiffness,
    }
    return {name: given.get(name, force) for name in OF_THE_CURVE}


def regrown(radius: FloatArray) -> BoolArray:
    """Rows from the first regrowth of a contact after shrinking on, from its contact length on the line."""
    size = np.nan_to_num(radius)
    if not size.size:
        return np.zeros(0, dtype=bool)
    moves = np.diff(size, prepend=size[:1])
    slack = _GROWTH * float(np.max(size))
    shrank = np.maximum.accumulate(moves < -slack)
    return np.asarray(np.maximum.accumulate(shrank & (moves > slack)))


def known_error(claim: Claim) -> FloatArray:
    """Relative errors of a quantity over its rows: 0 where it is exact to rounding, nan where they are unknown."""
    return np.full(claim.where.shape, math.nan) if claim.error is None else claim.error


def error_of_force(
    depth: FloatArray, force: FloatArray, depth_error: FloatArray, force_error: FloatArray
) -> FloatArray:
    """
    Relative errors of the forces of a curve including those of its depths: e_F + (d/F) (dF/dd) e_d.

    Parameters
    ----------
    depth, force : ndarray of shape (n,)
        In m and N, in the order of the depths.
    depth_error, force_error : ndarray of shape (n,)
        Relative; nan where unknown.

    Returns
    -------
    ndarray
        Relative, with the steeper of the slopes to both neighbours.
    """
    slope = np.diff(force) / np.diff(depth)
    steeper = np.maximum(np.append(slope[:1], slope), np.append(slope, slope[-1:]))
    with np.errstate(divide="ignore", invalid="ignore"):
        exponent = np.where(force > 0.0, np.abs(steeper * depth / force), 1.0)
    return np.asarray(force_error + exponent * depth_error)


def pressed_curve(
    contact: Contact, depth: FloatArray, force: FloatArray, depth_error: FloatArray, force_error: FloatArray
) -> ForceCurve:
    """
    The force curve of the rows of a contact in the order of their depths, for any path.

    Parameters
    ----------
    depth, force : ndarray of shape (n,)
        Indentation in m and normal force in N.
    depth_error, force_error : ndarray of shape (n,)
        Their relative errors; nan where unknown.
    """
    lacking = {
        "adhesion": contact.adhesion is not None,
        "a memory": contact.is_viscoelastic,
        "a graded body": common_exponent(contact.body, contact.counterbody) != 0.0,
        "a layered body": contact.layered is not None,
    }
    for name in (name for name, has in lacking.items() if has):
        raise ProblemError(
            f"this contact has {name}; a ForceCurve needs homogeneous elastic half-spaces without adhesion"
        )
    rows = np.argsort(depth, kind="stable")
    rows = rows[np.isfinite(depth[rows]) & np.isfinite(force[rows])]
    distinct = np.diff(depth[rows]) > _DISTINCT * float(np.max(np.abs(depth[rows]), initial=0.0))
    rows = rows[np.append(True, distinct)] if rows.size else rows
    depth, force = depth[rows], force[rows]
    free = float(np.max(depth[force <= 0.0], initial=-np.inf))
    touches = free <= 0.0 < float(np.min(depth[force > 0.0], initial=np.inf))
    modulus = effective_moduli(contact.body, contact.counterbody).normal
    error = error_of_force(depth, force, depth_error[rows], force_error[rows])
    return ForceCurve(depth, force, modulus=modulus, contact_point=0.0 if touches else None, error=error)
