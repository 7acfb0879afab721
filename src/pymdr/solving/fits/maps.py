"""Parameters of a contact in many measured curves."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError, PymdrError, QuantityError
from pymdr.interpretation.validity import SOURCES, Assumption, Claim
from pymdr.line.curves import ElasticLine
from pymdr.line.foundation import states_at_depth
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.numerics.panels import IndexArray
from pymdr.problem.contact import Contact
from pymdr.problem.laws import DMT
from pymdr.problem.parameters import with_parameters
from pymdr.problem.paths import indent
from pymdr.problem.schedule import Progress
from pymdr.quantities import one_name
from pymdr.result import Result
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.curves.marking import FLAT, SHORTEST
from pymdr.solving.fits.asking import (
    ENDINGS,
    FOUND,
    OF_LIMIT,
    PLATEAU,
    REFUSED,
    UNREAD,
    UNSETTLED,
    UNTOLD,
    WAVES,
    Asked,
    Columns,
    FittedStretch,
    asked_of,
    empty_columns,
    fewest_in_contact,
    leave_untold_out,
)
from pymdr.solving.fits.families import WORK, Ways
from pymdr.solving.fits.fitting import LEVENBERG_MARQUARDT, Estimate, estimate, judged
from pymdr.solving.fits.forces import rounded_up
from pymdr.solving.fits.quick import fit_by_family, reaches
from pymdr.solving.fits.records import Records, Stretch, records_of
from pymdr.solving.fits.storing import Held, Kept, attributes_of
from pymdr.solving.fits.unexplained import WAVY, range_of_law
from pymdr.solving.fits.unknowns import (
    BASELINE,
    CONTACT_POINT,
    Free,
    origins,
    put_into,
)
from pymdr.solving.memory import assumptions_with_memory
from pymdr.solving.reach import assumptions, map_to_line
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, QuantityLike, from_si, shown, written

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_CHUNK, _TOLD = 2**19, 5
"""Samples that are fitted, and kept, at a time; refusals that are told."""
_JUDGED, _WIDER, _SIMILAR = 17, 1.0 + 1e-9, "elastic similarity"
"""Depths, and numbers of a family, at which what is assumed is measured."""


@dataclass(frozen=True, kw_only=True)
class FittedMap:
    """What fits found in many curves."""

    contact: Contact
    """That of which parameters were looked for."""
    data: xr.Dataset
    """
    Over the grid of the curves: what was found by its name and its standard error as ``..._error``, NaN where nothing was;
    ``noise`` (N), ``waves`` (see :attr:`~pymdr.solving.fits.FitResult.waves`), ``correlated``, ``indentation`` (m, the largest), ``of_limit``, the
    largest measure of what the model assumes of each curve in parts of its limit (above 1 the curve lies beyond), ``plateau``, the
    samples at the largest force while the depth changes, and ``ending``, a number whose meaning stands in its attributes.
    """
    names: tuple[str, ...]
    """What was looked for."""
    claims: Mapping[str, Claim]
    """Those of the curve that was pressed deepest."""
    assumptions: tuple[Assumption, ...]
    references: tuple[str, ...]
    """Keys of the sources that :meth:`cite` names."""
    notes: tuple[str, ...] = field(default=())

    def __getitem__(self, name: str) -> xr.DataArray:
        if one_name(name) not in self.data.variables:
            raise QuantityError(
                f"no {shown(name)} in this map; it has {', '.join(map(str, self.data.variables))}"
            )
        return self.data[name].copy()

    def to(self, name: str, unit: str) -> xr.DataArray:
        """
        What was found, in another unit.

        Parameters
        ----------
        name : str
            For example "body.young".
        unit : str
            For example "kPa".

        Raises
        ------
        QuantityError
            If there is no such name.
        UnitError
            If the unit does not measure it.
        """
        array = self[name]
        own = str(array.attrs.get("units", ""))
        return array.copy(data=np.asarray(from_si(array.values, own, unit))).assign_attrs(units=unit)

    @property
    def counts(self) -> dict[str, int]:
        """How many curves ended how."""
        number = np.bincount(self.data["ending"].values.ravel(), minlength=len(ENDINGS))
        return {words: int(n) for words, n in zip(ENDINGS, number, strict=True) if n}

    def summary(self) -> str:
        """Medians and quartiles of what was found, how the fits ended, and how far to trust the model."""
        lines = self._told_of_endings()
        lines += [
            f"{name}: median {middle}, half of the curves between {low} and {high}"
            for name, middle, low, high in self._quartiles()
        ]
        if self.claims:
            claim = self.claims["normal_force"]
            lines.append(f"model, where pressed deepest: {claim.level.value}: {claim.reason}")
        lines += [
            f"not met: {a.words} {a.measure:.3g}, limit {a.limit:.3g}" for a in self.assumptions if not a.met
        ]
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def _told_of_endings(self) -> list[str]:
        counts = self.counts
        first = f"{counts.get(ENDINGS[FOUND], 0)} of {self.data['ending'].size} curves fitted"
        return [first, *(f"{n}: {words}" for words, n in counts.items() if words != ENDINGS[FOUND])]

    def _quartiles(self) -> list[tuple[str, str, str, str]]:
        """Name, median and quartiles of what was found and of the noise."""
        if ENDINGS[FOUND] not in self.counts:
            return []
        told = []
        for name in (*self.names, "noise"):
            unit = str(self.data[name].attrs["units"])
            ends = np.nanquantile(self.data[name].values, [0.25, 0.5, 0.75])
            low, middle, high = (written(float(q), unit, 4) for q in ends)
            told.append((name, middle, low, high))
        return told

    def __str__(self) -> str:
        return self.summary()

    def __repr__(self) -> str:
        return f"<pymdr.FittedMap {', '.join(self.names)}; {self._told_of_endings()[0]}>"

    def _repr_html_(self) -> str:
        """The summary as tables, for notebooks."""
        from pymdr.presentation.html import fit_html

        head = ("found", "median", "half of the curves from", "to")
        return fit_html(
            head, self._quartiles(), self._told_of_endings(), self.claims, self.assumptions, self.notes
        )

    def cite(self) -> tuple[str, ...]:
        """References of the theory and of the search."""
        return tuple(SOURCES[key] for key in self.references)

    def to_csv(self, file: str | os.PathLike[str]) -> None:
        """
        Write one row for each curve, with units in the names of the columns.

        Parameters
        ----------
        file : path
            For example "map.csv".

        Raises
        ------
        FileError
            If the file cannot be written.
        """
        from pymdr.presentation.tables import titled_columns, write_csv

        write_csv(titled_columns(self.data), file)

    def plot(self) -> Figure:
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
    tilt: bool = False,
    folder: str | os.PathLike[str] | None = None,
    workers: int = 1,
    client: Any = None,
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
    free, contact_point, baseline, tilt
        As for :func:`fit`.
    folder : path, optional
        Of a Zarr store into which curves are written as they are finished: the same call goes on where a killed one was.
    workers : int
        Number of cores; the numbers do not depend on it.
    client : dask.distributed.Client, optional
        Of a cluster that works in their place.
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
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise ProblemError(f"workers = {workers!r}: a whole number of at least 1 is needed")
    records = records_of(curves)
    total = math.prod(records.shape)
    known = origins({CONTACT_POINT: contact_point, BASELINE: baseline}, tilt)
    asked = asked_of(contact, free, known, total)
    chunk = _curves_of_chunk(asked, records)
    store = Kept(folder, asked, records, chunk) if folder is not None else Held(asked, total)
    parts = [(first, min(first + chunk, total)) for first in range(0, total, chunk)]
    todo = [part for part in parts if not store.has(*part)]
    done = total - sum(last - first for first, last in todo)
    if progress is not None and done:
        progress(done, total)

    def told(more: int) -> None:
        if progress is not None:
            progress(done + more, total)

    for (first, last), fitted in _fitted(asked, records, todo, workers, client, told):
        store.keep(first, last, fitted)
        done += last - first
        told(0)
    if asked.ways is not None:
        first = reaches(records.read(0, 1))[0]
        store.complete(OF_LIMIT, _of_limits(asked, asked.ways, store.columns(), float(first)))
    return _interpreted(asked, records, FittedStretch(store.columns(), store.refusals()))


def _curves_of_chunk(asked: Asked, records: Records) -> int:
    """Whole slices of the first dimension; one where each curve takes its time."""
    inner, samples = math.prod(records.shape[1:]), records.read(0, 1).place.size
    if asked.ways is None:
        return inner
    return inner * max(1, min(records.shape[0], _CHUNK // (inner * samples)))


def _fitted(
    asked: Asked,
    records: Records,
    parts: Sequence[tuple[int, int]],
    workers: int,
    client: Any,
    told: Callable[[int], None],
) -> Iterator[tuple[tuple[int, int], FittedStretch]]:
    """What the fits of stretches of curves give, as they are finished."""
    workers = min(workers, max(1, len(parts)))
    if client is not None:
        yield from _shared(asked, records, parts, client.get_executor(), 4 * max(len(client.ncores()), 1))
    elif workers == 1:
        for part in parts:
            yield part, _fit_stretch(asked, records.read(*part), told)
    elif asked.ways is not None:
        _prepare(asked, records, parts)
        with ThreadPoolExecutor(workers) as pool:
            yield from _shared(asked, records, parts, pool, 2 * workers)
    else:
        with ProcessPoolExecutor(workers) as pool:
            yield from _shared(asked, records, parts, pool, 2 * workers)


def _prepare(asked: Asked, records: Records, parts: Sequence[tuple[int, int]]) -> None:
    """Tabulate and compile once, before threads begin."""
    if parts:
        first, _ = parts[0]
        _fit_stretch(asked, records.read(first, first + 1))


def _shared(
    asked: Asked, records: Records, parts: Sequence[tuple[int, int]], pool: Executor, waiting: int
) -> Iterator[tuple[tuple[int, int], FittedStretch]]:
    """Stretches in their order, a few of them under way at a time."""
    work: Callable[[Stretch], FittedStretch] = partial(_fit_stretch, asked)
    under_way: list[tuple[tuple[int, int], Future[FittedStretch]]] = []
    for part in parts:
        under_way.append((part, pool.submit(work, records.read(*part))))
        if len(under_way) >= waiting:
            oldest, future = under_way.pop(0)
            yield oldest, future.result()
    for oldest, future in under_way:
        yield oldest, future.result()


def _fit_stretch(asked: Asked, stretch: Stretch, told: Callable[[int], None] | None = None) -> FittedStretch:
    """What was found in some curves."""
    if asked.ways is not None:
        fitted = fit_by_family(asked, asked.ways, stretch)
        if asked.contact.adhesion is None and CONTACT_POINT not in asked.known:
            ending = fitted.columns["ending"]
            few = _pressed(fitted.columns, stretch) < fewest_in_contact(len(asked.unknowns))
            ending[few & (ending == FOUND)] = UNTOLD
    else:
        fitted = _fit_one_by_one(asked, stretch, told)
    fitted.columns[PLATEAU][:] = _plateaus(stretch)
    leave_untold_out(asked, fitted.columns)
    return fitted


def _pressed(columns: Columns, stretch: Stretch) -> IndexArray:
    """How many samples of each curve are in contact, without adhesion: those beyond the contact point, also on a machine."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.count_nonzero(stretch.place > columns[CONTACT_POINT][:, None], axis=1))


def _plateaus(stretch: Stretch) -> FloatArray:
    """How many samples of each curve have its largest force while it is pressed on."""
    force = stretch.force
    with np.errstate(invalid="ignore"):
        largest, least = np.fmax.reduce(force, axis=1), np.fmin.reduce(force, axis=1)
        near = force >= (largest - 1.01 * FLAT * (largest - least))[:, None]
    if force.shape[1] < SHORTEST:
        return np.zeros(len(force))
    long = np.logical_and.reduce([near[:, i : near.shape[1] - SHORTEST + 1 + i] for i in range(SHORTEST)])
    counts = np.zeros(len(force))
    for i in np.flatnonzero(long.any(axis=1)):
        with suppress(PymdrError):
            counts[i] = stretch.curve(int(i)).mark_saturated().marked.sum()
    return counts


def _fit_one_by_one(asked: Asked, stretch: Stretch, told: Callable[[int], None] | None) -> FittedStretch:
    out, refusals = empty_columns(asked, len(stretch.place)), set()
    for i in range(len(stretch.place)):
        if told is not None and i:
            told(i)
        try:
            curve = stretch.curve(i)
        except PymdrError:
            out["ending"][i] = UNREAD
            continue
        try:
            found = estimate(asked.contact, curve, asked.free, asked.known)
            assumed = _assumed(found)
        except ConvergenceError:
            out["ending"][i] = UNSETTLED
        except PymdrError as error:
            out["ending"][i] = REFUSED
            refusals.add(str(error))
        else:
            for name in asked.names:
                out[name][i], out[f"{name}_error"][i] = found.values[name].value, found.values[name].error
            out["noise"][i], out["correlated"][i] = found.noise, found.correlated
            out[WAVES][i], out[OF_LIMIT][i] = found.waves, _of_limit(assumed)
            out["indentation"][i] = found.deepest
            out["ending"][i] = FOUND
    return FittedStretch(out, frozenset(refusals))


def _assumed(found: Estimate) -> tuple[Assumption, ...]:
    """What the model assumes of a curve; for bodies with memory without the history, which takes longer than the search."""
    if not found.contact.remembers:
        return judged(found).assumptions
    line = ElasticLine(equivalent_profile(found.contact.profile), 1.0)
    return assumptions_with_memory(
        found.contact, states_at_depth(line, [max(found.deepest, 0.0)]).contact_radius
    )


def _of_limit(assumed: Sequence[Assumption]) -> float:
    """The largest measure in parts of its limit; Dundurs' beta, which does not change with the curve, is none."""
    parts = [a.measure / a.limit for a in assumed if a.name != _SIMILAR and a.limit > 0.0]
    return max((part for part in parts if math.isfinite(part)), default=math.nan)


def _of_limits(asked: Asked, ways: Ways, columns: Columns, first: float) -> FloatArray:
    """
    That of every curve, from a table over the largest depth and the number in which the contacts differ.

    The family is that of the first curve where it reaches, which is known already, and does not depend on what was kept before.
    """
    from scipy.interpolate import RegularGridInterpolator

    out = np.full(columns["ending"].size, math.nan)
    found = np.flatnonzero((columns["ending"] == FOUND) & (columns["indentation"] > 0.0))
    if not found.size:
        return out
    depth = columns["indentation"][found]
    numbers = ways.numbers(np.column_stack([columns[u.name][found] for u in asked.unknowns]))
    family = asked.family(max(first, rounded_up(float(depth.max()))))
    last = len(family.members) - 1
    rungs = np.clip((numbers - family.first) / family.step, 0.0, float(last))
    chosen = np.unique(
        np.linspace(np.floor(rungs.min()), min(np.floor(rungs.max()) + 1.0, last), _JUDGED).astype(int)
    )
    depths = np.geomspace(depth.min(), depth.max() * _WIDER, _JUDGED)
    table = np.empty((chosen.size, depths.size))
    for row, rung in zip(table, chosen, strict=True):
        value = (
            {}
            if ways.number is None
            else {ways.number.name: ways.number.from_free(family.first + family.step * rung)}
        )
        contact = with_parameters(
            replace(asked.contact, adhesion=None), {k: v for k, v in value.items() if k != WORK}
        )
        mapped, member = map_to_line(contact), family.members[rung]
        row[:] = [_of_limit(assumptions(contact, mapped, radius[None])) for radius in member.radius(depths)]
    at = np.column_stack([np.log(depth), rungs])
    if chosen.size == 1:
        out[found] = np.exp(np.interp(at[:, 0], np.log(depths), np.log(table[0])))
    else:
        out[found] = np.exp(RegularGridInterpolator((np.log(depths), chosen), np.log(table.T))(at))
    return out


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
            "files by read_records, which leaves them out",
        ),
        (OF_LIMIT, 1.0, "lie beyond a limit of what the model assumes (of_limit)"),
    ):
        many = int((columns[name][found] > limit).sum())
        if many:
            notes.append(f"{many} of {found.size} curves {words}")
    if asked.ways is not None and asked.ways.work is not None and found.size:
        number = asked.ways.number
        assert number is not None
        numbers = asked.ways.numbers(np.column_stack([columns[u.name][found] for u in asked.unknowns]))
        # a law of short range is strained most where the work is smallest against the modulus, one of long range where it is largest
        strained = numbers.max() if isinstance(asked.contact.adhesion, DMT) else numbers.min()
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
