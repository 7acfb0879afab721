"""Parameters of a contact in many measured curves."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from pymdr.errors import ConvergenceError, FileError, ProblemError, PymdrError, QuantityError
from pymdr.interpretation.validity import SOURCES, Assumption, Claim
from pymdr.problem.codec import encode
from pymdr.problem.contact import Contact
from pymdr.problem.measured import MeasuredCurve
from pymdr.problem.paths import indent
from pymdr.problem.schedule import Progress
from pymdr.result import Result
from pymdr.solving.fits.families import WORK, Family, Ways, family_of, ways_of
from pymdr.solving.fits.fitting import LEVENBERG_MARQUARDT, LMFIT, fit
from pymdr.solving.fits.forces import rounded_up
from pymdr.solving.fits.records import Records, Stretch, records_of, zarr
from pymdr.solving.fits.searching import autocorrelation_times
from pymdr.solving.fits.unknowns import (
    BASELINE,
    CONTACT_POINT,
    ORIGINS,
    Free,
    Unknown,
    origins,
    put_into,
    unknowns_of,
)
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, QuantityLike, from_si, shown, written

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

FOUND, UNSETTLED, NO_CONTACT, UNREAD, AT_END, REFUSED = range(6)
ENDINGS = (
    "found",
    "the search did not settle",
    "no contact in the curve",
    "no curve, or too few samples that are numbers",
    "the curve does not show what is looked for, or only beyond its bounds",
    "refused",
)
"""How the fit of a curve ended, by its number in ``ending``."""
_NOT_YET = -1
_CHUNK, _TOLD = 1024, 5
_SEEN = 5.0
"""Standard errors of a work of adhesion that a curve shows."""
_MARK = "pymdr_work"
_PLAIN = ("noise", "correlated", "indentation")
_UNITS = {"noise": "N", "correlated": "", "indentation": "m"}
_WORDS = {
    "noise": "standard deviation of the residuals",
    "correlated": "samples that tell as much as an independent one",
    "indentation": "largest indentation",
    "ending": "how the fit ended",
}


@dataclass(frozen=True, kw_only=True)
class FittedMap:
    """What fits found in many curves."""

    contact: Contact
    """That of which parameters were looked for."""
    data: xr.Dataset
    """
    Over the grid of the curves: what was found by its name and its standard error as ``..._error``, NaN where nothing was;
    ``noise`` (N), ``correlated``, ``indentation`` (m, the largest), and ``ending``, a number whose meaning stands in its
    attributes.
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
        if name not in self.data.variables:
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
        from pymdr.presentation.html import found_html

        head = ("found", "median", "half of the curves from", "to")
        return found_html(
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
        from pymdr.presentation.tables import write_csv

        columns = self.data.to_dataframe().reset_index()
        units = {str(name): str(array.attrs.get("units", "")) for name, array in self.data.variables.items()}
        titled = {
            str(name): f"{name} [{units[str(name)]}]" if units.get(str(name)) else str(name)
            for name in columns
        }
        write_csv({titled[str(name)]: columns[name].to_numpy() for name in columns}, file)

    def plot(self) -> Figure:
        """A panel for each number that was found and for the noise: pictures of grids, else points."""
        from pymdr.presentation.plot import fitted_map

        return fitted_map(self.data, (*self.names, "noise"))


@dataclass(frozen=True)
class _Asked:
    """What is looked for in all curves."""

    contact: Contact
    unknowns: tuple[Unknown, ...]
    known: Mapping[str, float]
    bounded: Mapping[str, tuple[float, float]]
    """Ends that were given."""
    free: Free

    @property
    def origins(self) -> tuple[str, ...]:
        """Those that are looked for."""
        return tuple(name for name in (CONTACT_POINT, BASELINE) if name not in self.known)

    @property
    def names(self) -> tuple[str, ...]:
        """All that is looked for."""
        return (*(u.name for u in self.unknowns), *self.origins)

    @property
    def units(self) -> dict[str, str]:
        """SI units of all columns."""
        own = {u.name: u.unit for u in self.unknowns} | ORIGINS
        named = {name: own[name] for name in self.names}
        return {**named, **{f"{name}_error": unit for name, unit in named.items()}, **_UNITS}

    @cached_property
    def ways(self) -> Ways | None:
        """Where the fast search applies."""
        return ways_of(self.contact, self.unknowns)

    @cached_property
    def families(self) -> dict[float, Family]:
        """Tables by the largest depth that they reach."""
        return {}

    @cached_property
    def refusals(self) -> set[str]:
        """What refused curves were told."""
        return set()

    def family(self, deepest: float) -> Family:
        """The tables for curves of a depth."""
        assert self.ways is not None
        number = self.ways.number
        bounds = None if number is None or self.ways.work is not None else self.bounded.get(number.name)
        if deepest not in self.families:
            self.families[deepest] = family_of(self.contact, self.ways, deepest, bounds)
        return self.families[deepest]


Columns = dict[str, FloatArray]


def fit_map(
    contact: Contact,
    curves: Sequence[MeasuredCurve] | xr.Dataset | str | os.PathLike[str],
    free: Free,
    *,
    contact_point: QuantityLike | None = None,
    baseline: QuantityLike | None = None,
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
    free, contact_point, baseline
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
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise ProblemError(f"workers = {workers!r}: a whole number of at least 1 is needed")
    records = records_of(curves)
    asked = _asked(contact, free, origins({CONTACT_POINT: contact_point, BASELINE: baseline}))
    total = math.prod(records.shape)
    chunk = _rows_of_chunk(records.shape)
    store = _Kept(folder, asked, records, chunk) if folder is not None else _Held(asked, total)
    parts = [(first, min(first + chunk, total)) for first in range(0, total, chunk)]
    todo = [part for part in parts if not store.has(*part)]
    done = total - sum(last - first for first, last in todo)
    if progress is not None and done:
        progress(done, total)
    for (first, last), columns in _fitted(asked, records, todo, workers, client):
        store.keep(first, last, columns)
        done += last - first
        if progress is not None:
            progress(done, total)
    return _interpreted(asked, records, store.columns())


def _asked(contact: Contact, free: Free, known: dict[str, float]) -> _Asked:
    unknowns = unknowns_of(contact, free)
    given = free if isinstance(free, Mapping) else {}
    bounded = {u.name: (u.low, u.high) for u in unknowns if given.get(u.name) is not None}
    # the numbers of the tables are those from which the unknowns are counted, which lie within the bounds
    begun = put_into(contact, unknowns, np.array([u.start for u in unknowns]))
    return _Asked(begun, unknowns, known, bounded, free)


def _rows_of_chunk(shape: tuple[int, ...]) -> int:
    """Whole slices of the first dimension."""
    inner = math.prod(shape[1:])
    return inner * max(1, min(shape[0], _CHUNK // inner))


def _fitted(
    asked: _Asked, records: Records, parts: Sequence[tuple[int, int]], workers: int, client: Any
) -> Iterator[tuple[tuple[int, int], Columns]]:
    """What the fits of stretches of curves give, as they are finished."""
    if client is not None:
        yield from _shared(asked, records, parts, client.get_executor(), 4 * max(len(client.ncores()), 1))
    elif workers == 1:
        for part in parts:
            yield part, _fit_stretch(asked, records.read(*part))
    elif asked.ways is not None:
        _prepare(asked, records, parts)
        with ThreadPoolExecutor(workers) as pool:
            yield from _shared(asked, records, parts, pool, 2 * workers)
    else:
        with ProcessPoolExecutor(workers) as pool:
            yield from _shared(asked, records, parts, pool, 2 * workers)


def _prepare(asked: _Asked, records: Records, parts: Sequence[tuple[int, int]]) -> None:
    """Tabulate and compile once, before threads begin."""
    if parts:
        first, _ = parts[0]
        _fit_stretch(asked, records.read(first, first + 1))


def _shared(
    asked: _Asked, records: Records, parts: Sequence[tuple[int, int]], pool: Executor, waiting: int
) -> Iterator[tuple[tuple[int, int], Columns]]:
    """Stretches in their order, a few of them under way at a time."""
    work: Callable[[Stretch], Columns] = partial(_fit_stretch, asked)
    under_way: list[tuple[tuple[int, int], Future[Columns]]] = []
    for part in parts:
        under_way.append((part, pool.submit(work, records.read(*part))))
        if len(under_way) >= waiting:
            oldest, future = under_way.pop(0)
            yield oldest, future.result()
    for oldest, future in under_way:
        yield oldest, future.result()


def _fit_stretch(asked: _Asked, stretch: Stretch) -> Columns:
    """Columns of what was found in some curves."""
    if asked.ways is not None:
        return _fit_by_family(asked, asked.ways, stretch)
    return _fit_one_by_one(asked, stretch)


def _empty(asked: _Asked, count: int) -> Columns:
    columns = {name: np.full(count, math.nan) for name in asked.units}
    columns["ending"] = np.full(count, _NOT_YET, dtype=np.int8)
    return columns


def _fit_one_by_one(asked: _Asked, stretch: Stretch) -> Columns:
    out = _empty(asked, len(stretch.place))
    for i in range(len(stretch.place)):
        try:
            curve = stretch.curve(i)
        except PymdrError:
            out["ending"][i] = UNREAD
            continue
        try:
            known = {name: asked.known.get(name) for name in (CONTACT_POINT, BASELINE)}
            found = fit(asked.contact, curve, asked.free, **known)
        except ConvergenceError:
            out["ending"][i] = UNSETTLED
        except PymdrError as error:
            out["ending"][i] = REFUSED
            asked.refusals.add(str(error))
        else:
            for name in asked.names:
                out[name][i], out[f"{name}_error"][i] = found[name].value, found[name].error
            out["noise"][i], out["correlated"][i] = found.noise, found.correlated
            out["indentation"][i] = float(found.data["indentation"].values.max())
            out["ending"][i] = FOUND
    return out


def _fit_by_family(asked: _Asked, ways: Ways, stretch: Stretch) -> Columns:
    from pymdr.solving.fits import kernels

    count, width = stretch.place.shape
    numbers, residuals = np.full((count, 7), math.nan), np.full((count, width), math.nan)
    covariances = np.full((count, len(asked.names), len(asked.names)), math.nan)
    ended = np.full(count, kernels.UNREAD, dtype=np.int8)
    columns = np.zeros((4, len(asked.names)))
    columns[:2, : len(ways.unknowns)] = ways.columns()
    for i, name in enumerate(asked.origins, len(ways.unknowns)):
        columns[kernels.POINT if name == CONTACT_POINT else kernels.BASE, i] = 1.0
    number = ways.number
    known = np.array([0.0, 0.0, asked.known.get(CONTACT_POINT, 0.0), asked.known.get(BASELINE, 0.0)])
    if number is not None and ways.shape is None:
        known[kernels.SHAPE] = number.to_free(number.start)
    free = np.array(
        [ways.scale is not None, ways.shape is not None, *(n not in asked.known for n in ORIGINS)]
    )
    for deepest, chosen in _by_depth(stretch):
        try:
            family = asked.family(deepest)
        except PymdrError as error:
            ended[chosen] = REFUSED
            asked.refusals.add(str(error))
            continue
        own = numbers[chosen], covariances[chosen], residuals[chosen], ended[chosen]
        kernels.fit_curves(
            np.ascontiguousarray(stretch.place[chosen]),
            np.ascontiguousarray(stretch.force[chosen]),
            np.ascontiguousarray(stretch.softness[chosen]),
            known,
            free,
            ways.is_tied,
            asked.contact.adhesion is not None,
            columns,
            family.table,
            *own,
        )
        numbers[chosen], covariances[chosen], residuals[chosen], ended[chosen] = own
    return _columns(asked, ways, numbers, covariances, residuals, ended)


def _by_depth(stretch: Stretch) -> Iterator[tuple[float, np.ndarray]]:
    """Curves by the depth, rounded up, that tables have to reach."""
    good = np.isfinite(stretch.place) & np.isfinite(stretch.force)
    place = np.where(good, stretch.place, math.nan)
    depth = np.where(good, stretch.place - stretch.softness[:, None] * stretch.force, math.nan)
    some = good.sum(axis=1) > 1
    spans = np.zeros(len(place))
    spans[some] = np.maximum(
        np.nanmax(depth[some], axis=1) - np.nanmin(depth[some], axis=1),
        0.0,
    )
    reach = np.array([rounded_up(float(span)) for span in spans])
    for deepest in np.unique(reach[reach > 0.0]):
        yield float(deepest), np.flatnonzero(reach == deepest)


def _columns(
    asked: _Asked,
    ways: Ways,
    numbers: FloatArray,
    covariances: FloatArray,
    residuals: FloatArray,
    ended: np.ndarray,
) -> Columns:
    """What is told of every curve."""
    out = _empty(asked, len(numbers))
    out["ending"][:] = ended
    theta, misfit, used, depth = numbers[:, :4], numbers[:, 4], numbers[:, 5], numbers[:, 6]
    free = len(asked.names)
    with np.errstate(invalid="ignore", divide="ignore"):
        noise = np.sqrt(misfit / np.maximum(used - free, 1.0))
    correlated = np.ones(len(numbers))
    fitted = np.flatnonzero(np.isfinite(noise))
    if fitted.size:
        correlated[fitted] = autocorrelation_times(residuals[fitted])
    error = noise[:, None] * np.sqrt(correlated[:, None] * np.abs(np.einsum("ijj->ij", covariances)))
    values, rates = ways.values(theta[:, 0], theta[:, 1])
    plain = {CONTACT_POINT: theta[:, 2], BASELINE: theta[:, 3]}
    for i, name in enumerate(asked.names):
        value = plain[name] if name in plain else values[:, i]
        out[name][:] = value
        out[f"{name}_error"][:] = error[:, i] * (1.0 if name in plain else np.abs(rates[:, i]))
    for name, (low, high) in asked.bounded.items():
        outside = (out[name] < low) | (out[name] > high)
        out["ending"][outside & (ended == FOUND)] = AT_END
    if WORK in out:
        unseen = out[WORK] < _SEEN * out[f"{WORK}_error"]
        out["ending"][unseen & (ended == FOUND)] = AT_END
    out["noise"][:], out["correlated"][:], out["indentation"][:] = noise, correlated, depth
    bad = out["ending"] != FOUND
    for name in asked.units:
        out[name][bad] = math.nan
    return out


class _Held:
    """Columns in memory."""

    def __init__(self, asked: _Asked, total: int) -> None:
        self._columns = _empty(asked, total)

    def has(self, first: int, last: int) -> bool:
        """Whether a stretch is finished."""
        return False

    def keep(self, first: int, last: int, columns: Columns) -> None:
        """Put a finished stretch in its place."""
        for name, values in columns.items():
            self._columns[name][first:last] = values

    def columns(self) -> Columns:
        """All of them."""
        return self._columns


class _Kept:
    """Columns in a Zarr store, in which a stretch is finished when its endings are written."""

    def __init__(self, folder: str | os.PathLike[str], asked: _Asked, records: Records, chunk: int) -> None:
        from pymdr.presentation.files import named_file

        package = zarr()
        self._shape = records.shape
        place, total = named_file(folder, "write"), math.prod(records.shape)
        mark = _mark(asked, records, total)
        try:
            fresh = not place.exists() or not any(place.iterdir())
            self._group = package.open_group(str(place), mode="a")
        except (OSError, ValueError) as error:
            raise FileError(f"cannot write into {place}: {error}; choose another folder") from error
        if fresh:
            self._make(asked, records, chunk)
            self._group.attrs[_MARK] = mark
        elif self._group.attrs.get(_MARK) != mark:
            raise FileError(
                f"{place} holds another work: something that was asked has changed since; take another folder, or empty this one"
            )
        self._names = (*asked.units, "ending")

    def _make(self, asked: _Asked, records: Records, chunk: int) -> None:
        import xarray as xr

        inner = records.shape[1:]
        chunks = (chunk // math.prod(inner), *inner)
        for name, unit in asked.units.items():
            array = self._group.create_array(
                name,
                shape=records.shape,
                chunks=chunks,
                dtype="f8",
                fill_value=math.nan,
                dimension_names=records.dims,
            )
            array.attrs.update(_attributes(name, unit))
        ending = self._group.create_array(
            "ending",
            shape=records.shape,
            chunks=chunks,
            dtype="i1",
            fill_value=_NOT_YET,
            dimension_names=records.dims,
        )
        ending.attrs.update(_attributes("ending", ""))
        xr.Dataset(coords=records.coords).to_zarr(self._group.store, mode="a", consolidated=False)

    def _rows(self, first: int, last: int) -> slice:
        inner = math.prod(self._shape[1:])
        return slice(first // inner, last // inner)

    def has(self, first: int, last: int) -> bool:
        """Whether a stretch is finished."""
        return bool(np.all(self._group["ending"][self._rows(first, last)] != _NOT_YET))

    def keep(self, first: int, last: int, columns: Columns) -> None:
        """Write a finished stretch, its endings last."""
        rows = self._rows(first, last)
        for name in self._names:
            self._group[name][rows] = columns[name].reshape(-1, *self._shape[1:])

    def columns(self) -> Columns:
        """All of them."""
        return {name: np.asarray(self._group[name][...]).ravel() for name in self._names}


def _mark(asked: _Asked, records: Records, total: int) -> str:
    """What changes with what is asked, and with the first and the last curve."""
    work = {
        "contact": encode(asked.contact),
        "free": [[u.name, u.low, u.high] for u in asked.unknowns],
        "known": dict(asked.known),
        "shape": list(records.shape),
    }
    mark = hashlib.sha256(json.dumps(work, sort_keys=True).encode())
    for first in (0, total - 1):
        for array in records.read(first, first + 1)[:3]:
            mark.update(np.ascontiguousarray(array).tobytes())
    return mark.hexdigest()


def _attributes(name: str, unit: str) -> dict[str, Any]:
    told: dict[str, Any] = {"units": unit} if unit else {"units": ""}
    if name in _WORDS:
        told["long_name"] = _WORDS[name]
    if name == "ending":
        told = {**told, "flag_values": list(range(len(ENDINGS))), "flag_meanings": "; ".join(ENDINGS)}
    return told


def _interpreted(asked: _Asked, records: Records, columns: Columns) -> FittedMap:
    import xarray as xr

    units = {**asked.units, "ending": ""}
    data = xr.Dataset(
        {
            name: (records.dims, columns[name].reshape(records.shape), _attributes(name, unit))
            for name, unit in units.items()
        },
        coords=records.coords,
    )
    claims: Mapping[str, Claim] = {}
    assumptions: tuple[Assumption, ...] = ()
    notes = [f"refused: {words}" for words in sorted(asked.refusals)[:_TOLD]]
    found = np.flatnonzero(columns["ending"] == FOUND)
    references: tuple[str, ...] = ()
    if found.size:
        judged = _judged(asked, columns, int(found[np.argmax(columns["indentation"][found])]))
        references = judged.references
        # with memory they are those of a history, which differs from curve to curve
        if not asked.contact.remembers:
            claims, assumptions = judged.claims, judged.assumptions
    if asked.ways is not None and asked.families:
        worst = max(family.error for family in asked.families.values())
        notes.append(f"tables of the forces are right to {worst:.1g} of their largest")
    return FittedMap(
        contact=asked.contact,
        data=data,
        names=asked.names,
        claims=claims,
        assumptions=assumptions,
        references=(*references, LEVENBERG_MARQUARDT, *(() if asked.ways is not None else (LMFIT,))),
        notes=tuple(notes),
    )


def _judged(asked: _Asked, columns: Columns, i: int) -> Result:
    """The contact that was found in one curve, where it was pressed deepest."""
    values = np.array([columns[u.name][i] for u in asked.unknowns])
    deepest = float(columns["indentation"][i])
    path = indent(deepest, duration=1.0) if asked.contact.remembers else indent(deepest)
    return solve(put_into(asked.contact, asked.unknowns, values), path)
