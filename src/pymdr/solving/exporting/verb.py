"""The verb `export_law`: the law of a contact as a table with a stated error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import xarray as xr

from pymdr.errors import ConvergenceError, ProblemError, RefusedError
from pymdr.interpretation.theories import theory_of
from pymdr.interpretation.validity import Claim, approximated
from pymdr.numerics.panels import IndexArray
from pymdr.presentation.text import largest_error
from pymdr.problem.contact import Contact, require_contact
from pymdr.problem.paths import LoadingPath, Path, indent
from pymdr.problem.values import within_range
from pymdr.quantities import quantity
from pymdr.result import Result
from pymdr.solving.bands import scatter_of
from pymdr.solving.exporting.histories import remembered, touch_of
from pymdr.solving.exporting.knots import adapted
from pymdr.solving.exporting.sources import source_of
from pymdr.solving.exporting.value import LAW_QUANTITIES, SAFETY, ContactLaw, Table
from pymdr.solving.memory import powers_of
from pymdr.solving.pulloff import elastic_pull_off
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, QuantityLike, metres, shown, to_si

_BETWEEN = np.array([0.001, 0.02, 0.07, 0.18, 0.31, 0.46, 0.57, 0.72, 0.83, 0.96, 0.999])
"""Points of every interval at which the law is compared with `solve`, other than those of the refinement."""
_FINE = 0.5 - 0.5 * np.cos(np.pi * (np.arange(50) + 0.5) / 50)
"""Points of the intervals with the largest errors, close enough that the error is at most 1 % larger in between."""
_NEARLY, _MOST_FINER = 0.85, 16
"""Ratio of the error in an interval to the largest one from which on it is checked at these points, and number of such intervals."""
_ROUNDING = 1e-12
"""Relative rounding error of a table and of the exact states, which is added to the bounds."""
_ITSELF = {"normal_force": "the force", "normal_stiffness": "the stiffness", "contact_radius": "the radius"}
_TIGHTEST, _LOOSEST = 1e-7, 1e-2
"""Range of tolerances; below it rounding of d - d_off matters at the loss of contact."""
_FEW, _FINER = 33, 0.3
_OF_A_PATH = ("jumped into contact", "bands are")
"""Beginnings of notes on paths, which do not apply to a law."""


def export_law(
    contact: Contact,
    to: QuantityLike,
    *,
    tolerance: float = 1e-6,
    tangential: bool = False,
    springs: int | None = None,
) -> ContactLaw:
    """
    The normal force, stiffness and contact radius over the indentation, as a table with a stated error.

    Without adhesion, or with DMT, ln F is interpolated over ln d by cubic Hermite polynomials with the exact slope d k / F, and
    below the first knot by the power law of the tip; with JKR F is interpolated over sqrt(d - d_off), from the pull-off under
    displacement control on. Intervals are halved until the errors of force, stiffness and radius are below the tolerance; the
    law is compared with :func:`pymdr.solve` between all knots, at 50 more depths in each of the intervals with the largest errors,
    and far below the first knot. The bounds of the errors are 2 % above the largest of these differences. With JKR the stiffness jumps, or
    changes with a vertical tangent, at kinks; between the knots on both sides of one its error has a bound of its own, `kink_error`.

    Parameters
    ----------
    contact : Contact
        Elastic bodies of revolution: half-spaces, graded or layered, without adhesion or with JKR, of one or two works, or DMT; or `Viscoelastic` half-spaces
        without adhesion. Friction has no effect on the table.
    to : quantity
        The largest indentation in m.
    tolerance : float
        Largest relative error of force, stiffness and radius, 1e-7 to 1e-2. With adhesion force and stiffness pass through 0: the
        error of the force is then relative to its size plus the largest pull, and with JKR that of the stiffness relative to its
        size plus the stiffness at the fixed radius of the pull-off.
    tangential : bool
        Whether the C header also has friction along a line, with its memory: :class:`Coulomb` friction of a coefficient above 0, which is finite with springs. Bodies with
        memory need a rheology without a parallel dashpot; each step has 16 equal parts, the first divided from the shortest relaxation time; the claims have the error of that.
    springs : int, optional
        Number of springs, 8 to 4096: with `tangential` for friction in the plane instead of along a line; of bodies with memory, 100
        by default, each of which keeps its deflection and the forces of its relaxation times in the C header.

    Returns
    -------
    ContactLaw
        A table of force (N), stiffness (N/m) and radius (m) over the indentation (m), with bounds of its errors; it
        writes a C header. The table of bodies with memory is that of a sudden indentation, of the moduli that have not relaxed; the
        claims of force and energies are those of the springs. That of two works of adhesion is of an edge that advances; the header also has
        the edge that recedes and rests.

    Raises
    ------
    ProblemError
        If the contact has no radius or no unique force at each depth, is not a disk at some depth, has no friction that is asked for,
        or the tolerance is outside its limits.
    PathError
        If the depth cannot be reached.
    ConvergenceError
        If the tolerance cannot be met.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("210 GPa", 0.3))
    >>> law = mdr.export_law(ball, "10 um")
    >>> exact = mdr.solve(ball, mdr.indent("3 um"))["normal_force"][0]
    >>> bool(abs(law.force("3 um") / exact - 1) < 1e-6), max(law.errors.values()) < 1e-6
    (True, True)
    """
    deepest = _depth(to)
    check_lawful(contact, tolerance)
    memory = remembered(contact, deepest, tangential, springs)
    alone = memory.table
    plain = _solved(alone, np.geomspace(1e-9, 1.0, _FEW) * deepest)
    source = source_of(alone, deepest, tolerance)
    # an error may be larger between the points of the refinement
    for fraction in (1.0, _FINER):
        knots = adapted(source.sample, source.marks, source.form.error, fraction * tolerance)
        table = Table(source.form, knots, deepest)
        checks, exact = _checked_against_solve(table, alone, tolerance)
        errors = {name: SAFETY * float(np.max(checks[name].values)) + _ROUNDING for name in LAW_QUANTITIES}
        worst = max(errors, key=lambda name: errors[name])
        if errors[worst] <= tolerance:
            break
    else:
        raise ConvergenceError(
            f"the {quantity(worst).long_name} has an error of {errors[worst]:.2g} between the knots (limit "
            f"{tolerance:g}, the tolerance); use a larger tolerance, or smooth the profile"
        )
    pull_off = None if contact.adhesion is None else elastic_pull_off(alone, pressed_to=deepest)
    return ContactLaw(
        contact=contact,
        tolerance=tolerance,
        data=table.data(),
        claims=_claims(exact, errors, knots.u.size) | _spread(memory.claims, knots.u.size),
        assumptions=plain.assumptions,
        notes=_notes(contact, plain, tangential) + ((memory.note,) if memory.note else ()),
        errors=errors,
        kink_error=table.kink_error(tolerance),
        relative_to={name: source.form.relative_to().get(name, text) for name, text in _ITSELF.items()},
        table=table,
        checks=checks,
        history=memory.history or touch_of(source.form, pull_off),
        pull_off=pull_off,
        references=plain.references,
    )


def _depth(to: QuantityLike) -> float:
    deepest = to_si(to, "m", name="to")
    if not deepest > 0.0:
        raise ProblemError(f"to = {shown(to)}; the largest indentation must be above 0 m")
    return float(within_range(deepest, "m", "to", size=True))


def check_lawful(contact: Contact, tolerance: float) -> None:
    """Refuse contacts without a law of the depth alone, or without a radius."""
    require_contact(contact)
    if (
        isinstance(tolerance, bool)
        or not isinstance(tolerance, int | float)
        or not _TIGHTEST <= tolerance <= _LOOSEST
    ):
        raise ProblemError(
            f"tolerance = {shown(tolerance)}; a number from {_TIGHTEST:g} to {_LOOSEST:g} is needed, such as 1e-6"
        )
    for refused, why in (
        (
            contact.is_viscoelastic and contact.layered is not None,
            "the memory of layers is not in headers; use Stepper, or viscoelastic half-spaces",
        ),
        (
            contact.is_viscoelastic and contact.adhesion is not None,
            "the memory of bodies with adhesion is not in headers; leave the adhesion out",
        ),
        (
            bool(powers_of(contact)),
            "PowerLawRheology has no fixed relaxation times; give a Prony series fitted over the times of the motion",
        ),
        (
            contact.is_cohesive,
            f"{type(contact.adhesion).__name__} has a cohesive zone, which a table of force, stiffness and radius does not "
            "represent; Stepper.c_header writes the step of elastic bodies, or give JKR or DMT, as adhesion_regime(contact) recommends",
        ),
        (
            contact.plastic is not None,
            "the force of a body that yields depends on its largest indentation; use Stepper, which follows it step by step, or its c_header",
        ),
        (
            contact.adhesion is not None
            and not contact.adhesion.has_hysteresis
            and not theory_of(contact.adhesion).proportional(contact.adhesion),
            f"{type(contact.adhesion).__name__} is not tabulated; give JKR or DMT, or write the curve of solve(...) with Result.to_csv",
        ),
        (
            bool(contact.profile.no_radius),
            f"the contact of {type(contact.profile).__name__} has no radius: {contact.profile.no_radius}; write the curve of solve(...) with "
            "Result.to_csv",
        ),
    ):
        if refused:
            raise ProblemError(why)


def _solved(contact: Contact, depths: FloatArray) -> Result:
    """Exact states at increasing depths in m, all of them disks."""
    path: LoadingPath = Path(indentation=depths)
    if contact.adhesion is not None:
        # the branch in contact, from the touch at 0 on
        path = indent(max(float(depths[-1]), 0.0)) >> Path(indentation=depths[::-1])
    result = solve(contact, path)
    claim = result.claims["contact_radius"]
    if not claim.where.all() or not claim.readable:
        at = result.data["indentation"].values[~claim.where]
        below = depths[depths < np.nanmin(at)] if np.isfinite(at).any() else depths[:0]
        remedy = f"; it is a disk up to d = {metres(below[-1])}: export up to there" if below.size else ""
        raise RefusedError(f"the contact is not a disk at every depth: {claim.reason}{remedy}")
    return result


def _checked_against_solve(table: Table, contact: Contact, tolerance: float) -> tuple[xr.Dataset, Result]:
    """Errors of the law between the knots and below them, finer in the intervals with the largest ones, and the exact states."""
    u, form = table.knots.u, table.form
    smooth = np.flatnonzero(~table.kinks(tolerance))
    d = form.checked(_inner_depths(table, smooth, _BETWEEN), table.first)
    checks, exact = _compared_at(table, contact, np.unique(np.append(np.minimum(d, table.last), table.last)))
    at = np.searchsorted(u, form.coordinate(checks["indentation"].values), side="right") - 1
    worst = np.zeros(u.size - 1, dtype=bool)
    for name in LAW_QUANTITIES:
        largest = np.zeros(u.size - 1)
        inside = (at >= 0) & (at < u.size - 1)
        np.maximum.at(largest, at[inside], checks[name].values[inside])
        ranked = np.argsort(largest)[::-1][:_MOST_FINER]
        worst[ranked[largest[ranked] >= _NEARLY * largest.max()]] = True
    finer = _inner_depths(table, smooth[worst[smooth]], _FINE)
    if form.tip is None:
        finer = form.checked(finer, table.first)
    if not finer.size:
        return checks, exact
    more, _ = _compared_at(table, contact, np.unique(np.minimum(finer, table.last)))
    return xr.concat([checks, more], "check").sortby("indentation"), exact


def _inner_depths(table: Table, intervals: IndexArray, fractions: FloatArray) -> FloatArray:
    """Depths in m inside of some intervals between knots."""
    u = table.knots.u
    return table.form.depth((u[intervals, None] + np.diff(u)[intervals, None] * fractions).ravel())


def _compared_at(table: Table, contact: Contact, d: FloatArray) -> tuple[xr.Dataset, Result]:
    """Errors of the law at increasing depths in m, and the exact states."""
    form, exact = table.form, _solved(contact, d)
    rows = slice(None) if contact.adhesion is None else slice(None, 0, -1)
    force, stiffness, radius = (exact[name].values[rows] for name in LAW_QUANTITIES)
    ours = table.at(d)
    columns = {
        "normal_force": np.abs(ours[0] - force) / (np.abs(force) + form.added[0]),
        "normal_stiffness": np.abs(ours[1] - stiffness) / (np.abs(stiffness) + form.added[1]),
        "contact_radius": np.abs(ours[2] - radius) / radius,
    }
    checks = xr.Dataset(
        {name: ("check", values, {"units": ""}) for name, values in columns.items()}
        | {"indentation": ("check", d, {"units": "m"})}
    )
    return checks, exact


def _claims(exact: Result, errors: Mapping[str, float], knots: int) -> dict[str, Claim]:
    """The claims of the exact states, with the errors of the table."""
    everywhere = np.ones(knots, dtype=bool)
    claims: dict[str, Claim] = {}
    for name in LAW_QUANTITIES:
        claim = exact.claims[name]
        own = np.full(knots, largest_error(claim) or 0.0)
        whole = {name: replace(claim, where=everywhere, error=own)}
        claims |= approximated(whole, "; as a table, whose errors are added", errors[name])
    return claims


def _spread(claims: Mapping[str, Claim], knots: int) -> dict[str, Claim]:
    """Claims of the largest indentation for all knots."""
    return {
        name: replace(
            claim,
            where=np.full(knots, bool(claim.where.all())),
            error=None if claim.error is None else np.full(knots, float(claim.error.max())),
        )
        for name, claim in claims.items()
    }


def _notes(contact: Contact, result: Result, tangential: bool) -> tuple[str, ...]:
    notes = tuple(note for note in result.notes if not note.startswith(_OF_A_PATH))
    if contact.friction is not None and not tangential:
        notes += ("friction has no effect on the law",)
    if scatter_of(contact.profile):
        notes += ("the scatter of the profile is ignored",)
    return notes
