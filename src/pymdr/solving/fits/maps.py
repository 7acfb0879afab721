"""Parameters of a contact in many measured curves."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import ClassVar, Unpack

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError
from pymdr.interpretation.theories import theory_of
from pymdr.interpretation.validity import Assumption, Claim
from pymdr.numerics.panels import IndexArray
from pymdr.presentation import plot
from pymdr.problem.contact import Contact, require_contact
from pymdr.problem.options import with_options
from pymdr.problem.parameters import with_parameters
from pymdr.problem.paths import indent
from pymdr.problem.schedule import Progress
from pymdr.result import Result
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.families import WORK, FamilyAxes
from pymdr.solving.fits.fitting import LEVENBERG_MARQUARDT, RESTRICTED, FitOptions
from pymdr.solving.fits.quality import FEWEST_IN_CONTACT, LARGEST_RESIDUAL, LARGEST_RISE
from pymdr.solving.fits.quick import depth_ranges, table_error
from pymdr.solving.fits.ranges import limits_of, range_text, refuse_history
from pymdr.solving.fits.records import Records, records_of
from pymdr.solving.fits.request import (
    DRIFT,
    ENDINGS,
    FITTED,
    IN_CONTACT,
    OF_LIMIT,
    PLATEAU,
    RESIDUAL,
    SYSTEMATIC,
    TOO_FEW,
    WAVES,
    Columns,
    FitRequest,
    FittedStretch,
    request_of,
)
from pymdr.solving.fits.storing import InMemory, Kept, attributes_of
from pymdr.solving.fits.stretches import curves_of_chunk, fitted_stretches, of_limits
from pymdr.solving.fits.systematic import refuse_uncertainty
from pymdr.solving.fits.unexplained import WAVY, range_of_law
from pymdr.solving.fits.unknowns import (
    BASELINE,
    CONTACT_POINT,
    Free,
    origins,
    put_into,
    without_tilt,
)
from pymdr.solving.study import Study, TextTable
from pymdr.solving.verb import solve
from pymdr.solving.workers import Workers, checked_workers
from pymdr.units import FloatArray, QuantityLike, shown, written

_CORRELATED = 2.25
"""Number of samples equivalent to one from which on the correlation of residuals is noted."""
GOOD = "good"
_SHOWN_REFUSALS = 5
"""Largest number of refusals in the notes."""


@dataclass(frozen=True, kw_only=True)
class FittedMap(Study):
    """Fits of many curves."""

    contact: Contact
    """The contact whose parameters were fitted."""
    data: xr.Dataset
    """
    Over the grid of the curves: values by name and standard errors by noise as ``..._error``, NaN where a fit failed;
    with ``uncertainty=`` the standard errors that all curves share as ``..._systematic``, and 95 % intervals with both as ``..._low`` and ``..._high``;
    ``noise`` (N), ``waves`` (see :attr:`~pymdr.solving.fits.FitResult.waves`), ``correlated``, ``indentation`` (m, the largest), ``of_limit``, the
    largest ratio of a measure of the assumptions to its limit (not met above 1), ``plateau``, the number of samples at the largest
    force while the depth changes, ``samples_in_contact``, ``relative_residual`` (standard deviation of the residuals) and ``baseline_rise`` (of the
    force along the baseline of the approach, without a fitted tilt), both relative to the range of the force, ``good``, the mask of :meth:`mask` with its defaults, and ``ending``, a number with its meaning in the attributes. The claims are those of the curve
    with the largest indentation.
    """
    names: tuple[str, ...]
    """Names of the unknowns."""

    subject: ClassVar = "this map"
    summary_claims: ClassVar = ("normal_force",)
    claims_of_rows: ClassVar = False

    @property
    def counts(self) -> dict[str, int]:
        """Number of curves by ending."""
        number = np.bincount(self.data["ending"].values.ravel(), minlength=len(ENDINGS))
        return {text: int(n) for text, n in zip(ENDINGS, number, strict=True) if n}

    def mask(
        self,
        *,
        samples_in_contact: int = FEWEST_IN_CONTACT,
        relative_residual: float = LARGEST_RESIDUAL,
        baseline_rise: float = LARGEST_RISE,
        of_limit: float = math.inf,
    ) -> xr.DataArray:
        """
        Whether each curve is good enough: fitted, and within all limits.

        Parameters
        ----------
        samples_in_contact : int
            Smallest number of samples in contact.
        relative_residual : float
            Largest standard deviation of the residuals, relative to the range of the force.
        baseline_rise : float
            Largest rise or fall along the baseline, relative to the range of the force; curves without a baseline pass.
        of_limit : float
            Largest ratio of an assumption to its limit; any by default.

        Returns
        -------
        xarray.DataArray
            True for good curves; ``result["body.young"].where(result.mask())`` leaves the others out.

        Raises
        ------
        ProblemError
            If a limit is negative or not a number.
        """
        limits = {
            IN_CONTACT: samples_in_contact,
            RESIDUAL: relative_residual,
            DRIFT: baseline_rise,
            OF_LIMIT: of_limit,
        }
        for name, limit in limits.items():
            is_number = isinstance(limit, Real) and not isinstance(limit, bool)
            if not (is_number and limit >= 0.0):
                text = f"{limit:g}" if is_number else shown(limit)
                raise ProblemError(f"mask: {name} = {text}; a limit of 0 or more is needed")
        data = self.data
        rise = data[DRIFT].values
        good = (
            (data["ending"].values == FITTED)
            & (data[IN_CONTACT].values >= samples_in_contact)
            & (data[RESIDUAL].values <= relative_residual)
            & ((np.abs(rise) <= baseline_rise) | np.isnan(rise))
        )
        if math.isfinite(of_limit):
            good &= data[OF_LIMIT].values <= of_limit
        ending = data["ending"]
        return xr.DataArray(good, ending.coords, ending.dims, GOOD)

    def __repr__(self) -> str:
        return f"<pymdr.FittedMap {', '.join(self.names)}; {self._remarks()[0]}>"

    def _remarks(self) -> list[str]:
        counts = self.counts
        first = f"{counts.pop(ENDINGS[FITTED], 0)} of {self.data['ending'].size} curves fitted"
        return [first, *(f"{n}: {text}" for text, n in counts.items())]

    def _table(self) -> TextTable:
        """Median and quartiles of the values and of the noise."""
        rows = []
        for name in (*self.names, "noise") if ENDINGS[FITTED] in self.counts else ():
            low, middle, high = np.nanquantile(self.data[name].values, [0.25, 0.5, 0.75]).tolist()
            unit = str(self.data[name].attrs["units"])
            rows.append([name, *(written(value, unit, 4) for value in (middle, low, high))])
        header = ["parameter", "median", "half of the curves from", "to"] if rows else []
        return (header, [""] * len(header)), rows

    def _columns(self) -> dict[str, np.ndarray]:
        """One row for each curve, with its place in the grid."""
        places = {dim: self.data[dim] for dim in self.data.dims}
        return Study._columns(replace(self, data=self.data.assign_coords(places)))

    def _figure(self) -> mpl.figure.Figure:
        """A panel per value and one for the noise: images of grids, else points."""
        return plot.fitted_map(self.data, (*self.names, "noise"))


@with_options(FitOptions)
def fit_map(
    contact: Contact,
    curves: Sequence[MeasuredCurve] | xr.Dataset | str | os.PathLike[str],
    free: Free,
    *,
    folder: str | os.PathLike[str] | None = None,
    workers: Workers = 1,
    progress: Progress | None = None,
    **options: Unpack[FitOptions],
) -> FittedMap:
    """
    Fit parameters of a contact to each of many measured force curves.

    Parameters
    ----------
    contact : Contact
        As for :func:`fit`.
    curves : sequence of MeasuredCurve, xarray.Dataset, or path
        A dataset, or the folder or URL of a Zarr store of one, has ``force`` and ``travel`` or ``indentation`` over a grid and
        ``sample``, with ``units`` in their attributes; with travel ``spring_constant``, one or over the grid; ``time`` for bodies
        with memory. It is read in parts.
    free
        As for :func:`fit`.
    folder : path, optional
        Zarr store of finished curves, a folder or a URL that fsspec opens; the same call continues an interrupted one.
    workers : int or dask.distributed.Client
        Number of cores, or the client of a cluster; the numbers do not depend on it.
    progress : callable, optional
        Called as ``progress(done, total)``.
    contact_point, baseline, fit_range
        As for :func:`fit`; the range is found for each curve.
    uncertainty
        As for :func:`fit`; all curves share it.

    Returns
    -------
    FittedMap
        Over the grid of the curves: every parameter with its standard error, quality and outcome.

    Raises
    ------
    ProblemError
        If the contact has no such parameter, there are no curves, a variable is missing, or no curve has enough samples in `fit_range`.
    FileError
        If the folder cannot be written or belongs to another fit.
    MissingExtraError
        If zarr is not installed and a store is used.

    Notes
    -----
    With a modulus and at most one other unknown (the work of adhesion, or a radius), the forces are tabulated once for all curves,
    over the root of the depth beyond the fold, and a compiled Levenberg-Marquardt search reads them; otherwise :func:`fit` is
    applied to each curve.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> depth = np.linspace(-1e-6, 1e-6, 101)
    >>> curves = [
    ...     mdr.MeasuredCurve(force=E * 16 / 9 * np.sqrt(5e-6) * np.maximum(depth, 0.0) ** 1.5, indentation=depth)
    ...     for E in (1e3, 2e3)
    ... ]
    >>> result = mdr.fit_map(mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("10 kPa", 0.5)), curves, ["body.young"])
    >>> result["body.young"].values.round(3).tolist()
    [1000.0, 2000.0]
    """
    require_contact(contact)
    checked_workers(workers)
    records = records_of(curves)
    total = math.prod(records.shape)
    request = _request(contact, records, free, **options)
    chunk = curves_of_chunk(request, records)
    store = Kept(folder, request, records, chunk) if folder is not None else InMemory(request, total)
    parts = [(first, min(first + chunk, total)) for first in range(0, total, chunk)]
    todo = [part for part in parts if not store.has(*part)]
    done = total - sum(last - first for first, last in todo)
    if progress is not None and done:
        progress(done, total)

    def report(more: int) -> None:
        if progress is not None:
            progress(done + more, total)

    for (first, last), fitted in fitted_stretches(request, records, todo, workers, report):
        store.keep(first, last, fitted)
        done += last - first
        report(0)
    if request.axes is not None:
        first = depth_ranges(records.read(0, 1))[0]
        store.complete(OF_LIMIT, of_limits(request, request.axes, store.columns(), float(first)))
    result = _interpreted(request, records, FittedStretch(store.columns(), store.refusals()))
    if isinstance(store, Kept):
        store.keep_mask(result.data[GOOD])
    return result


def _request(
    contact: Contact,
    records: Records,
    free: Free,
    *,
    contact_point: QuantityLike | None = None,
    baseline: QuantityLike | None = None,
    fit_range: Mapping[str, QuantityLike] | None = None,
    uncertainty: Mapping[str, QuantityLike] | None = None,
) -> FitRequest:
    """The request of a map, checked."""
    if contact.friction is not None:
        raise ProblemError(
            "the contact has friction, which does not affect force curves; leave friction out, or pass each record of "
            "tangential force and shift to fit"
        )
    known = origins({CONTACT_POINT: contact_point, BASELINE: baseline}, free)
    limits = {} if fit_range is None else limits_of(fit_range)
    if limits:
        refuse_history(contact)
    shared = {} if uncertainty is None else uncertainty
    request = request_of(contact, without_tilt(free), known, math.prod(records.shape), limits, shared)
    if uncertainty is not None:
        refuse_uncertainty(request, records.read(0, 1))
    return request


def _interpreted(request: FitRequest, records: Records, fitted: FittedStretch) -> FittedMap:
    columns = fitted.columns

    units = {**request.units, "ending": ""}
    data = xr.Dataset(
        {
            name: (records.dims, columns[name].reshape(records.shape), attributes_of(name, unit))
            for name, unit in units.items()
        },
        coords=records.coords,
    )
    claims: Mapping[str, Claim] = {}
    assumed: tuple[Assumption, ...] = ()
    notes = [range_text(request.limits)] if request.limits else []
    notes += [f"refused: {text}" for text in sorted(fitted.refusals)[:_SHOWN_REFUSALS]]
    fits = np.flatnonzero(columns["ending"] == FITTED)
    references: tuple[str, ...] = ()
    if fits.size:
        deepest = _solve_deepest(request, columns, int(fits[np.argmax(columns["indentation"][fits])]))
        references = deepest.references
        # with memory they are those of a history, which is different for each curve
        if not request.contact.is_viscoelastic:
            claims, assumed = deepest.claims, deepest.assumptions
        notes += _uncertainty_notes(request, columns, fits)
    elif np.any(columns["ending"] == TOO_FEW):
        raise ProblemError(f"no curve is fitted: {'; '.join(sorted(fitted.refusals)[:_SHOWN_REFUSALS])}")
    for name, limit, text in (
        (
            WAVES,
            WAVY,
            "have residual waves larger than their noise (waves): another law, a work of adhesion, a layer or a drift may be missing",
        ),
        (
            "correlated",
            _CORRELATED,
            f"have correlated residuals, which widen their errors by more than a factor of {math.sqrt(_CORRELATED):g} (correlated)",
        ),
        (
            PLATEAU,
            0.0,
            "have samples at their largest force while the depth changes (plateau): if the detector was saturated, set them to nan, or read the "
            "files with read_prepared_curves, which leaves them out",
        ),
        (OF_LIMIT, 1.0, "exceed a limit of the assumptions (of_limit)"),
    ):
        many = int((columns[name][fits] > limit).sum())
        if many:
            notes.append(f"{many} of {fits.size} curves {text}")
    if request.axes is not None and fits.size:
        numbers = request.axes.numbers(np.column_stack([columns[u.name][fits] for u in request.unknowns]))
        notes += _table_notes(request, request.axes, numbers)
    fitted_map = FittedMap(
        contact=request.contact,
        data=data,
        names=request.names,
        claims=claims,
        assumptions=assumed,
        references=(*references, LEVENBERG_MARQUARDT, RESTRICTED),
        notes=tuple(notes),
    )
    good = fitted_map.mask().assign_attrs(
        units="",
        long_name="fitted, with enough samples in contact and small residuals and rise of the baseline",
    )
    return replace(fitted_map, data=data.assign({GOOD: good}))


def _table_notes(request: FitRequest, axes: FamilyAxes, numbers: FloatArray) -> list[str]:
    """Notes on the range of a law of adhesion and on the tables of the forces, at the free numbers of the family of fitted curves."""
    number, law = axes.number, request.contact.adhesion
    notes: list[str] = []
    if axes.work is not None and number is not None and law is not None:
        # the critical work for the range of a law is the smallest one for JKR-like laws, the largest one for DMT-like laws
        strained = numbers.max() if theory_of(law).pulls_beyond else numbers.min()
        notes += range_of_law(with_parameters(request.contact, {WORK: number.from_free(float(strained))}))
    if request.families:
        worst = table_error(request, axes, numbers)
        notes.append(f"tables of the forces have an error of {worst:.1g} of their largest value")
    return notes


def _uncertainty_notes(request: FitRequest, columns: Columns, fits: IndexArray) -> list[str]:
    """Notes on the relative standard errors by the uncertainties that all curves share, and by noise."""
    notes = []
    for name in (u.name for u in request.unknowns) if request.uncertainty else ():
        shared, noise = (
            float(np.nanmedian(np.abs(columns[f"{name}{end}"][fits] / columns[name][fits])))
            for end in (SYSTEMATIC, "_error")
        )
        notes.append(
            f"median standard error of {name}: {100.0 * shared:.2g} % from {', '.join(request.uncertainty)}, which all curves share "
            f"({name}{SYSTEMATIC}), and {100.0 * noise:.2g} % from the noise of each ({name}_error)"
        )
    return notes


def _solve_deepest(request: FitRequest, columns: Columns, i: int) -> Result:
    """The contact of one curve, solved at its largest indentation."""
    values = np.array([columns[u.name][i] for u in request.unknowns])
    deepest = float(columns["indentation"][i])
    path = indent(deepest, duration=1.0) if request.contact.is_viscoelastic else indent(deepest)
    return solve(put_into(request.contact, request.unknowns, values), path)
