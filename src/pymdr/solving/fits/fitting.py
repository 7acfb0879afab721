"""From measured curves to the numbers of a contact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypedDict

import numpy as np

from pymdr.deferred import xr
from pymdr.errors import ProblemError
from pymdr.interpretation.validity import EXACT_WITHIN, Claim
from pymdr.problem.contact import Contact, require_contact
from pymdr.result import labelled
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.calibrations import with_uncertainty
from pymdr.solving.fits.estimating import (
    Estimate,
    at_bounds,
    checked,
    edges_solved,
    estimated,
    solve_fitted,
    with_intervals,
)
from pymdr.solving.fits.loops import NORMAL, ShearRecord, shear_record
from pymdr.solving.fits.ranges import estimated_within, limits_of
from pymdr.solving.fits.results import FitResult, Fitted, force_of
from pymdr.solving.fits.searching import Search
from pymdr.solving.fits.unexplained import correlation_notes, unexplained
from pymdr.solving.fits.unknowns import (
    BASELINE,
    CONTACT_POINT,
    SHIFT_ORIGIN,
    TILT,
    Free,
    origins,
    unknowns_of,
    without_tilt,
)
from pymdr.units import FloatArray, QuantityLike, written

LEVENBERG_MARQUARDT, RESTRICTED = "levenberg-marquardt", "patterson-thompson"
SHARES = "standard error"
"""Beginning of notes on the sources of errors."""
_NOTED = 0.1
"""Ratio of a systematic to a standard error from which on it is noted."""


class FitOptions(TypedDict, total=False):
    """Options of :func:`fit` that hold for each of many records."""

    contact_point: QuantityLike | None
    baseline: QuantityLike | None
    fit_range: Mapping[str, QuantityLike] | None
    uncertainty: Mapping[str, QuantityLike] | None


def fit(
    contact: Contact,
    curve: MeasuredCurve | xr.Dataset | Sequence[MeasuredCurve] | Sequence[xr.Dataset],
    free: Free,
    *,
    contact_point: QuantityLike | None = None,
    shift_origin: QuantityLike | None = None,
    baseline: QuantityLike | None = None,
    fit_range: Mapping[str, QuantityLike] | None = None,
    uncertainty: Mapping[str, QuantityLike] | None = None,
) -> FitResult:
    """
    Fit parameters of a contact to measured force curves, or to records of friction.

    Parameters
    ----------
    contact : Contact
        Known parameters and the law: elastic bodies with or without adhesion, or bodies with memory; with friction for
        measured tangential forces. Its values are the start of unknown lengths.
    curve : MeasuredCurve, xarray.Dataset, or sequence of them
        One, or several of the same contact, each with its own origins. Of a contact with friction a record as
        :func:`pymdr.read_record` reads it: ``tangential_force``, ``shift``, and ``normal_force``, or without it ``indentation``,
        which is prescribed; ``used`` is false at samples that are solved but not compared.
    free : sequence of str, or mapping of str to pair of quantities or None
        Unknown parameters by their dotted names, such as ``["body.young", "adhesion.work"]``, with optional bounds. ``"tilt"`` among them, in N/m of the travel or indentation, is the rise of the force along the record before
        contact, as by drift or virtual deflection; the baseline is then that in the middle of the record.
    contact_point : quantity, optional
        The depth of the record in m at first touch; unknown by default.
    shift_origin : quantity, optional
        With friction the shift of the record in m at which the bodies were pressed together, before its first sample; unknown
        by default.
    baseline : quantity, optional
        The force of the record in N out of contact; unknown by default.
    fit_range : mapping of str to quantity, optional
        Largest ``indentation`` in m, ``force`` in N above the baseline, or both: samples beyond are left out. The whole record by default.
    uncertainty : mapping of str to quantity, optional
        Standard uncertainties of known numbers, in percent (``"10 %"``) or in their unit, which enter the intervals: of the ``spring_constant``,
        of the ``sensitivity`` of the deflection, and of parameters of the contact, such as ``"profile.radius"``.

    Returns
    -------
    FitResult
        ``contact`` with the fitted values, ``values`` with standard errors and 95 % intervals, residuals over the
        samples, claims and figure.

    Raises
    ------
    ProblemError
        If the contact has no such parameter, the records do not determine the unknowns (such as an adhesion or slip that they do not
        show), or do not belong to the law.
    ConvergenceError
        If the search does not converge.

    Notes
    -----
    The depth of a sample is its travel less the deflection of the machine; the weights account for the noise of the force,
    which is in both. With adhesion, samples between the depths of the jumps into contact and out of it belong to the nearer
    branch, and those adjacent to a jump are left out. The search starts from the best points of a grid over the nonlinear
    unknowns. Errors are those of least squares under the spectrum of the noise that the residuals determine, white noise and a slow
    part, by restricted likelihood (Patterson and Thompson 1971), averaged over its uncertainty.

    References
    ----------
    Patterson and Thompson (1971), Biometrika 58, 545-554, doi:10.1093/biomet/58.3.545

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> depth = np.linspace(-1e-6, 1e-6, 101)
    >>> force = 16e3 / 9 * np.sqrt(5e-6) * np.maximum(depth, 0.0) ** 1.5
    >>> result = mdr.fit(
    ...     mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("10 kPa", 0.5)),
    ...     mdr.MeasuredCurve(force=force, indentation=depth + 3e-7),
    ...     ["body.young"],
    ... )
    >>> round(result["body.young"].value, 6), round(1e9 * result["contact_point"].value, 6)
    (1000.0, 300.0)
    """
    require_contact(contact)
    search, marked = _search(
        contact,
        curve,
        free,
        {CONTACT_POINT: contact_point, SHIFT_ORIGIN: shift_origin, BASELINE: baseline},
    )
    notes: tuple[str, ...] = (
        (f"{marked} samples marked as outliers or saturated are left out",) if marked else ()
    )
    if fit_range is None:
        end = estimated(search)
    else:
        end, range_note = estimated_within(search, limits_of(fit_range))
        notes += (range_note,)
    result = _interpreted(end, uncertainty)
    return replace(result, notes=(*notes, *unexplained(result), *result.notes))


def _search(
    contact: Contact,
    curve: MeasuredCurve | xr.Dataset | Sequence[MeasuredCurve] | Sequence[xr.Dataset],
    free: Free,
    given: dict[str, QuantityLike | None],
) -> tuple[Search, int]:
    """The search, and the number of marked samples that are left out."""
    from xarray import Dataset

    listed = (curve,) if isinstance(curve, MeasuredCurve | Dataset) else tuple(curve)
    kind, needed = (
        (MeasuredCurve, "a MeasuredCurve")
        if contact.friction is None
        else (Dataset, "a record of shift and tangential_force, such as read_record reads,")
    )
    if not listed or not all(isinstance(one, kind) for one in listed):
        has = "has friction" if contact.friction is not None else "has no friction"
        raise ProblemError(f"one or several of these are needed, because the contact {has}: {needed}")
    unknowns, known = unknowns_of(contact, without_tilt(free)), origins(given, free)
    if contact.friction is None:
        if given.pop(SHIFT_ORIGIN) is not None:
            raise ProblemError(
                "shift_origin= is for contacts with friction; force curves have a contact_point"
            )
        curves = tuple(one for one in listed if isinstance(one, MeasuredCurve))
        marked = sum(int(one.marked.sum()) for one in curves)
        curves = tuple(checked(one) for one in curves)
        return Search(contact, unknowns, curves, known), marked
    if given.pop(CONTACT_POINT) is not None or TILT not in known:
        raise ProblemError(
            "contact_point= and a tilt are for normal forces; records of friction have a shift_origin and a baseline"
        )
    records = tuple(shear_record(one) for one in listed if isinstance(one, Dataset))
    used = () if all(one.used.all() for one in records) else tuple(one.used for one in records)
    return Search(contact, unknowns, records, known, used), 0


def _interpreted(estimate: Estimate, uncertainty: Mapping[str, QuantityLike] | None = None) -> FitResult:
    """The result of an estimate, with claims and notes."""
    search, values, noise_errors = estimate.search, estimate.values, estimate.errors
    result = solve_fitted(estimate)
    systematic = _systematic(estimate, result.claims[force_of(estimate.contact)])
    if systematic.any():
        errors = estimate.errors + systematic / estimate.width.max(axis=0)
        half = estimate.width * estimate.errors + systematic
        width = np.divide(half, errors, out=estimate.width.copy(), where=errors > 0.0)
        estimate = estimate._replace(errors=errors, width=width)
        values = with_intervals(search, estimate.best, errors, width)
    contributions: dict[str, dict[str, float]] = {}
    if uncertainty is not None:
        values, contributions = with_uncertainty(estimate, uncertainty)
    left_out = sum(int((~part).sum()) for part in search.used)
    why = "marked in the record" if search.shears else "adjacent to jumps"
    notes: tuple[str, ...] = (f"{left_out} samples {why} are left out",) if left_out else ()
    notes += tuple(
        f"{name} reached its bound {written(values[name].value, values[name].unit, 4)}: the best fit is beyond it, and the interval is "
        "that of the bounds"
        for name in at_bounds(search, estimate.best)
    )
    notes += tuple(
        f"the record does not determine {name}"
        for name, is_felt in zip(search.names, estimate.felt, strict=True)
        if not is_felt
    )
    notes += correlation_notes(estimate)
    notes += _contribution_notes(search, values, contributions)
    if np.any(systematic > _NOTED * noise_errors):
        notes += ("the intervals include the error of the model, which is not small compared with the noise",)
    return FitResult(
        contact=estimate.contact,
        curves=search.curves,
        values=values,
        data=_table(search, estimate),
        noise=estimate.noise,
        waves=estimate.waves,
        correlated=estimate.correlated,
        widened=estimate.widened,
        calibration=contributions,
        aicc=estimate.aicc,
        claims=result.claims,
        assumptions=result.assumptions,
        notes=notes,
        references=(*result.references, LEVENBERG_MARQUARDT, RESTRICTED),
        search=search,
        free=estimate.best,
    )


def _contribution_notes(
    search: Search, values: Mapping[str, Fitted], contributions: Mapping[str, Mapping[str, float]]
) -> tuple[str, ...]:
    """Notes on the sources of the standard error of each unknown of the contact."""
    notes = []
    for one in (values[u.name] for u in search.unknowns if contributions and u.name in values):
        texts = [
            f"{100.0 * part[one.name] / abs(one.value):.2g} % from {source}"
            for source, part in contributions.items()
        ]
        notes.append(f"{SHARES} of {one.name}: {', '.join(texts)}")
    return tuple(notes)


def _systematic(estimate: Estimate, claim: Claim) -> FloatArray:
    """Largest change of the free numbers by the error of the forces of the model, with the worst sign at each sample."""
    if estimate.contact.has_edge_history:
        solved = [one.claims["normal_force"] for one in edges_solved(estimate, len(estimate.search.curves))]
        used = estimate.search.used or [np.ones(one.where.size, dtype=bool) for one in solved]
        errors = [
            np.where(one.where, 0.0 if one.error is None else one.error, 0.0)[part]
            for one, part in zip(solved, used, strict=True)
        ]
        changes: FloatArray = estimate.moved @ np.concatenate(errors)
        return changes
    error = 0.0 if claim.error is None else float(np.max(claim.error, initial=0.0, where=claim.where))
    largest: FloatArray = estimate.moved.sum(axis=1)
    return (error if error > EXACT_WITHIN else 0.0) * largest


def _table(search: Search, estimate: Estimate) -> xr.Dataset:
    """The samples of all curves, concatenated, and their quality."""
    models = estimate.models
    used = search.used or tuple(np.ones(one.force.size, dtype=bool) for one in models)
    columns = {
        "shift" if search.shears else "indentation": np.concatenate([one.depth for one in models]),
        force_of(search.contact): np.concatenate([one.force for one in models]),
    }
    for name in NORMAL if search.shears else ():
        records = [one for one in search.curves if isinstance(one, ShearRecord) and one.channel == name]
        if len(records) == len(models):
            columns[name] = np.concatenate([one.normal for one in records])
    if search.contact.is_viscoelastic:
        columns["time"] = np.concatenate([curve.time for curve in search.curves if curve.time is not None])
    table = labelled(columns)
    more = {
        "model": np.concatenate([one.model for one in models]),
        "residual": np.concatenate([one.force - one.model for one in models]),
        "in_contact": np.concatenate([one.touches for one in models]),
        "used": np.concatenate(used),
        "curve": np.repeat(np.arange(len(models)), [one.force.size for one in models]),
    }
    units = {"model": "N", "residual": "N"}
    table = table.assign(
        {name: ("step", column, {"units": units.get(name, "")}) for name, column in more.items()}
    )
    if search.shears:
        return table
    quality = estimate.quality._asdict()
    return table.assign({name: ((), value, {"units": ""}) for name, value in quality.items()})
