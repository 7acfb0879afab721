"""Parameters of a contact in many measured curves."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from pymdr.errors import ProblemError
from pymdr.interpretation.theories import theory_of
from pymdr.interpretation.validity import Assumption, Claim
from pymdr.problem.contact import Contact
from pymdr.problem.parameters import with_parameters
from pymdr.problem.paths import indent
from pymdr.problem.schedule import Progress
from pymdr.result import Result
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.asking import (
    ENDINGS,
    FOUND,
    OF_LIMIT,
    PLATEAU,
    WAVES,
    Asked,
    Columns,
    FittedStretch,
    asked_of,
)
from pymdr.solving.fits.families import WORK
from pymdr.solving.fits.fitting import LEVENBERG_MARQUARDT
from pymdr.solving.fits.quick import reaches
from pymdr.solving.fits.records import Records, records_of
from pymdr.solving.fits.storing import Held, Kept, attributes_of
from pymdr.solving.fits.stretches import curves_of_chunk, fitted_stretches, of_limits
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
from pymdr.units import QuantityLike, written

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_TOLD = 5
"""Refusals that are told."""


@dataclass(frozen=True, kw_only=True)
class FittedMap(Study):
    """What fits found in many curves."""

    contact: Contact
    """That of which parameters were looked for."""
    data: xr.Dataset
    """
    Over the grid of the curves: what was found by its name and its standard error as ``..._error``, NaN where nothing was;
    ``noise`` (N), ``waves`` (see :attr:`~pymdr.solving.fits.FitResult.waves`), ``correlated``, ``indentation`` (m, the largest), ``of_limit``, the
    largest measure of what the model assumes of each curve in parts of its limit (above 1 the curve lies beyond), ``plateau``, the
    samples at the largest force while the depth changes, and ``ending``, a number whose meaning stands in its attributes. The
    claims are those of the curve that was pressed deepest.
    """
    names: tuple[str, ...]
    """What was looked for."""

    subject: ClassVar = "this map"
    summary_claims: ClassVar = ("normal_force",)
    claims_of_rows: ClassVar = False

    @property
    def counts(self) -> dict[str, int]:
        """How many curves ended how."""
        number = np.bincount(self.data["ending"].values.ravel(), minlength=len(ENDINGS))
        return {words: int(n) for words, n in zip(ENDINGS, number, strict=True) if n}

    def __repr__(self) -> str:
        return f"<pymdr.FittedMap {', '.join(self.names)}; {self._remarks()[0]}>"

    def _remarks(self) -> list[str]:
        counts = self.counts
        first = f"{counts.pop(ENDINGS[FOUND], 0)} of {self.data['ending'].size} curves fitted"
        return [first, *(f"{n}: {words}" for words, n in counts.items())]

    def _table(self) -> TextTable:
        """Median and quartiles of what was found and of the noise."""
        rows = []
        for name in (*self.names, "noise") if ENDINGS[FOUND] in self.counts else ():
            low, middle, high = np.nanquantile(self.data[name].values, [0.25, 0.5, 0.75]).tolist()
            unit = str(self.data[name].attrs["units"])
            rows.append([name, *(written(value, unit, 4) for value in (middle, low, high))])
        words = ["found", "median", "half of the curves from", "to"] if rows else []
        return (words, [""] * len(words)), rows

    def _columns(self) -> dict[str, np.ndarray]:
        """One row for each curve, with its place in the grid."""
        places = {dim: self.data[dim] for dim in self.data.dims}
        return Study._columns(replace(self, data=self.data.assign_coords(places)))

    def _figure(self) -> Figure:
        """A panel for each number that was found and for the noise: pictures of grids, else points."""
        from pymdr.presentation.plot import fitted_map

        return fitted_map(self.data, (*self.names, "noise"))


def fit_map(
    contact: Contact,
    curves: Sequence[MeasuredCurve] | xr.Dataset | str | os.PathLike[str],
    free: Free,
    *,
    contact_point: QuantityLike | None = None,
    baseline: QuantityLike | None = None,
    folder: str | os.PathLike[str] | None = None,
    workers: int | Any = 1,
    progress: Progress | None = None,
) -> FittedMap:
    """
    Find parameters of a contact in many measured force curves, in each by itself.

    Parameters
    ----------
    contact : Contact
        As for :func:`fit`.
    curves : sequence of MeasuredCurve, xarray.Dataset, or path
        A dataset, or the folder of a Zarr store of one, has ``force`` and ``travel`` or ``indentation`` over a grid and
        ``sample``, with ``units`` in their attributes; with travel ``spring_constant``, one or over the grid; ``time`` for bodies
        with memory. It is read a stretch at a time.
    free, contact_point, baseline
        As for :func:`fit`.
    folder : path, optional
        Of a Zarr store into which curves are written as they are finished: the same call goes on where a killed one was.
    workers : int or dask.distributed.Client
        Number of cores, or the client of a cluster; the numbers do not depend on it.
    progress : callable, optional
        Called as ``progress(done, total)``.

    Returns
    -------
    FittedMap

    Raises
    ------
    ProblemError
        If the contact has no number of a name, there are no curves, or they lack what the contact needs.
    FileError
        If the folder cannot be written or holds another work.
    MissingExtraError
        If zarr is not installed and a store is asked for.

    Notes
    -----
    Where a modulus is looked for, and at most one number more (the work of adhesion, or a radius), the forces are tabulated once
    for all curves, over the root of the depth beyond the fold, and a compiled search of Levenberg and Marquardt reads them; other
    parameters are looked for by :func:`fit`, curve by curve.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Paraboloid
    >>> depth = np.linspace(-1e-6, 1e-6, 101)
    >>> curves = [
    ...     MeasuredCurve(force=E * 16 / 9 * np.sqrt(5e-6) * np.maximum(depth, 0.0) ** 1.5, indentation=depth)
    ...     for E in (1e3, 2e3)
    ... ]
    >>> found = fit_map(Contact(Paraboloid("5 um"), Elastic("10 kPa", 0.5)), curves, ["body.young"])
    >>> found["body.young"].values.round(3).tolist()
    [1000.0, 2000.0]
    """
    if not isinstance(contact, Contact):
        raise ProblemError(f"fit_map: {contact!r} is not a Contact; write Contact(profile, body)")
    if contact.friction is not None:
        raise ProblemError(
            "fit_map: the contact has friction, which force curves do not feel; leave friction out, or give each record of "
            "tangential force and shift to fit"
        )
    if not hasattr(workers, "get_executor") and (type(workers) is not int or workers < 1):
        raise ProblemError(f"workers = {workers!r}: a whole number of at least 1 is needed, or a dask client")
    records = records_of(curves)
    total = math.prod(records.shape)
    known = origins({CONTACT_POINT: contact_point, BASELINE: baseline}, free)
    asked = asked_of(contact, without_tilt(free), known, total)
    chunk = curves_of_chunk(asked, records)
    store = Kept(folder, asked, records, chunk) if folder is not None else Held(asked, total)
    parts = [(first, min(first + chunk, total)) for first in range(0, total, chunk)]
    todo = [part for part in parts if not store.has(*part)]
    done = total - sum(last - first for first, last in todo)
    if progress is not None and done:
        progress(done, total)

    def told(more: int) -> None:
        if progress is not None:
            progress(done + more, total)

    for (first, last), fitted in fitted_stretches(asked, records, todo, workers, told):
        store.keep(first, last, fitted)
        done += last - first
        told(0)
    if asked.ways is not None:
        first = reaches(records.read(0, 1))[0]
        store.complete(OF_LIMIT, of_limits(asked, asked.ways, store.columns(), float(first)))
    return _interpreted(asked, records, FittedStretch(store.columns(), store.refusals()))


def _interpreted(asked: Asked, records: Records, fitted: FittedStretch) -> FittedMap:
    import xarray as xr

    columns = fitted.columns

    units = {**asked.units, "ending": ""}
    data = xr.Dataset(
        {
            name: (records.dims, columns[name].reshape(records.shape), attributes_of(name, unit))
            for name, unit in units.items()
        },
        coords=records.coords,
    )
    claims: Mapping[str, Claim] = {}
    assumed: tuple[Assumption, ...] = ()
    notes = [f"refused: {words}" for words in sorted(fitted.refusals)[:_TOLD]]
    found = np.flatnonzero(columns["ending"] == FOUND)
    references: tuple[str, ...] = ()
    if found.size:
        judged = _judged(asked, columns, int(found[np.argmax(columns["indentation"][found])]))
        references = judged.references
        # with memory they are those of a history, which differs from curve to curve
        if not asked.contact.remembers:
            claims, assumed = judged.claims, judged.assumptions
    for name, limit, words in (
        (
            WAVES,
            WAVY,
            "leave waves larger than their noise (waves): another law, a work of adhesion, a layer or a drift may be missing",
        ),
        (
            PLATEAU,
            0.0,
            "have samples at their largest force while the depth changes (plateau): where the detector had run out of range, set them to nan, or read the "
            "files by read_prepared_curves, which leaves them out",
        ),
        (OF_LIMIT, 1.0, "lie beyond a limit of what the model assumes (of_limit)"),
    ):
        many = int((columns[name][found] > limit).sum())
        if many:
            notes.append(f"{many} of {found.size} curves {words}")
    if asked.ways is not None and asked.ways.work is not None and found.size:
        number, law = asked.ways.number, asked.contact.adhesion
        assert number is not None
        assert law is not None
        numbers = asked.ways.numbers(np.column_stack([columns[u.name][found] for u in asked.unknowns]))
        # a law of short range is strained most where the work is smallest against the modulus, one of long range where it is largest
        strained = numbers.max() if theory_of(law).pulls_beyond else numbers.min()
        notes += range_of_law(with_parameters(asked.contact, {WORK: number.from_free(float(strained))}))
    if asked.ways is not None and asked.families:
        worst = max(family.error for family in asked.families.values())
        notes.append(f"tables of the forces are right to {worst:.1g} of their largest")
    return FittedMap(
        contact=asked.contact,
        data=data,
        names=asked.names,
        claims=claims,
        assumptions=assumed,
        references=(*references, LEVENBERG_MARQUARDT),
        notes=tuple(notes),
    )


def _judged(asked: Asked, columns: Columns, i: int) -> Result:
    """The contact that was found in one curve, where it was pressed deepest."""
    values = np.array([columns[u.name][i] for u in asked.unknowns])
    deepest = float(columns["indentation"][i])
    path = indent(deepest, duration=1.0) if asked.contact.remembers else indent(deepest)
    return solve(put_into(asked.contact, asked.unknowns, values), path)
