"""One contact over a grid of its parameters."""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, ClassVar, NamedTuple, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError, PymdrError, QuantityError
from pymdr.interpretation.validity import Claim, Level
from pymdr.machine import memory_of_machine
from pymdr.mapping.equivalent import has_callables
from pymdr.presentation import plot
from pymdr.presentation.text import largest_error
from pymdr.problem.codec import encode, encode_case
from pymdr.problem.contact import Contact, require_contact
from pymdr.problem.options import with_options
from pymdr.problem.parameters import parameter_of, with_parameters
from pymdr.problem.paths import LoadingPath
from pymdr.problem.profiles import Profile
from pymdr.problem.schedule import Progress
from pymdr.problem.values import Value, read_stiffness
from pymdr.quantities import AXES, magnitudes, quantity
from pymdr.result import Result, Status
from pymdr.solving.batch import Request, solutions
from pymdr.solving.study import Study, dataset
from pymdr.solving.verb import check_limits_of_tolerance
from pymdr.solving.workers import KeptParts, Workers
from pymdr.units import FloatArray, QuantityLike, shown, to_si_array, written

_MACHINE, _PATH = "machine_stiffness", "path"
_APPLIED = "keep", "tolerance"
"""Options that apply to every point."""
_BETWEEN_WRITES = 2.0
"""Time between writes in s."""
_LEVELS = (Level.EXACT, Level.APPROXIMATE, Level.NOT_VALID)


@dataclass(frozen=True, kw_only=True)
class Sweep(Study):
    """Results over a grid of parameters of a contact."""

    data: xr.Dataset
    """
    All quantities over the parameters and ``step`` (vectors of paths in the plane over ``axis`` too), NaN where they are not valid or the point failed; ``status`` and
    ``refusal`` (why a point has no result) over the parameters.
    """
    claims: Mapping[str, Claim]
    """The weakest claim of every quantity; `where` and `error` are over the flattened points: whether the quantity can be read, and
    its largest relative error."""

    subject: ClassVar = "this sweep"
    summary_claims: ClassVar = (
        "normal_force",
        "contact_radius",
        "indentation",
        "tangential_force",
        "dissipated_energy",
    )

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the swept parameters, the dimensions of the grid."""
        return tuple(str(name) for name in self.data["status"].dims)

    @property
    def failed(self) -> int:
        """Number of points without a result."""
        return int((self.data["refusal"].values != "").sum())

    def _remarks(self) -> list[str]:
        """Swept parameters, and the range of the largest values of the quantities."""
        total = self.data["status"].size
        lines = [f"{total} points over", *(f"  {name}: {text}" for name, text in self._ranges().items())]
        if self.failed:
            refusals = self.data["refusal"].values.ravel()
            first = int(np.argmax(refusals != ""))
            lines.append(
                f"{self.failed} without a result; the first, {self._place(first)}: {refusals[first]}"
            )
        statuses = self.data["status"].values.ravel()
        lines += [
            f"{np.sum(statuses == status.name)} of {total} points {status.name}: {status.value}"
            for status in Status
            if status.name.endswith("REFUSED") and np.any(statuses == status.name)
        ]
        for name, claim in self._shown_claims.items():
            if claim.readable and name in self.data:
                row, largest = quantity(name), self._largest(name)
                ends = [written(float(end), row.unit, 4) for end in (largest.min(), largest.max())]
                lines.append(
                    f"largest {row.long_name}: {ends[0] if ends[0] == ends[1] else ' to '.join(ends)}"
                )
        return lines

    def _ranges(self) -> dict[str, str]:
        return {name: _range(self.data[name]) for name in self.parameters}

    def _others(self) -> dict[str, str]:
        return {f"sweep over {name}": text for name, text in self._ranges().items()}

    def _largest(self, name: str) -> FloatArray:
        """Largest value over the path, of every point that has one; of vectors the largest magnitude."""
        values = magnitudes(self.data[name]).values.reshape(-1, self.data.sizes["step"])
        return np.asarray(np.nanmax(values[~np.isnan(values).all(axis=1)], axis=1, initial=-math.inf))

    def _place(self, point: int) -> str:
        index = np.unravel_index(point, self.data["status"].shape)
        return ", ".join(
            f"{name} = {_shown_value(self.data[name], int(i))}"
            for name, i in zip(self.parameters, index, strict=True)
        )

    def plot(self, name: str = "normal_force") -> mpl.figure.Figure:
        """
        A quantity along the path at every point, and its largest value over the first parameter; of vectors the magnitudes.

        Returns
        -------
        matplotlib.figure.
        """
        self[name]
        return plot.sweep_curves(self.data, name, self.parameters)


class SolveOptions(TypedDict, total=False):
    """Options of :func:`solve` that apply to every point."""

    machine_stiffness: QuantityLike | None
    keep: int | ArrayLike | None
    tolerance: float | None


class _Axis(NamedTuple):
    """Values of one parameter."""

    name: str
    values: list[Any]
    unit: str | None
    """Unit of numbers, None for parts."""


@with_options(SolveOptions)
def sweep(
    contact: Contact,
    path: LoadingPath,
    over: Mapping[str, Sequence[Any] | ArrayLike],
    *,
    quantities: Sequence[str] | None = None,
    workers: Workers = 1,
    folder: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
    **options: Unpack[SolveOptions],
) -> Sweep:
    """
    Solve a contact for all combinations of some of its parameters.

    Parameters
    ----------
    contact : Contact
        The contact whose parameters vary.
    path : LoadingPath
        Path of every point.
    over : mapping of str to sequence
        Values by dotted names, such as ``{"body.young": ["1 MPa", "2 MPa"], "profile.radius": radii}``; whole parts too,
        such as ``{"profile": [Sphere("1 mm"), Cone(slope=0.1)]}``, and ``"machine_stiffness"`` or ``"path"``.
    quantities : sequence of str, optional
        Quantities to keep, such as ``["indentation", "normal_force"]``; all by default.
    workers : int or dask.distributed.Client
        Number of processes, or the client of a cluster; the numbers do not depend on it.
    folder : path, optional
        Folder of finished points; the same call continues an interrupted one.
    progress : callable, optional
        Called as ``progress(done, total)``.
    machine_stiffness, keep, tolerance
        As for :func:`solve`.

    Returns
    -------
    Sweep
        Labelled by the parameters. A point that cannot be solved has a reason in ``refusal`` and NaN elsewhere.

    Raises
    ------
    ProblemError
        If the contact has no such parameter, `over` or one of its entries is empty, or the result exceeds half of the memory.
    UnitError
        If a value has the wrong unit.
    FileError
        If the folder cannot be written or holds another sweep.
    PymdrError
        The error of the first point, if no point can be solved.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("1 MPa", 0.5))
    >>> swept = mdr.sweep(ball, mdr.indent("1 um"), {"profile.radius": ["1 mm", "4 mm"], "body.young": ["1 MPa", "3 MPa"]})
    >>> (swept["normal_force"].isel(step=-1) / swept["normal_force"][0, 0, -1]).values.round(12).tolist()
    [[1.0, 3.0], [2.0, 6.0]]
    """
    require_contact(contact)
    wanted = None if quantities is None else _names(quantities)
    if not isinstance(over, Mapping) or not over:
        raise ProblemError(
            f"over = {shown(over)}; parameters with their values are needed, such as {{'body.young': ['1 MPa', '2 MPa']}}"
        )
    axes = [_axis(contact, str(name), values) for name, values in over.items()]
    applied, stiffness = {name: options.get(name) for name in _APPLIED}, options.get("machine_stiffness")
    machine = None if stiffness is None else read_stiffness(stiffness)
    check_limits_of_tolerance(options.get("tolerance"))
    points = list(product(*(axis.values for axis in axes)))
    answers = _Answers(len(points), wanted)
    kept = (
        None
        if folder is None
        else KeptParts(folder, _identity(contact, path, axes, machine, applied, wanted))
    )
    if kept is not None:
        for first, block in kept.parts():
            answers.read(first, block)
    missing = np.flatnonzero(~answers.known)
    requests = [_point(contact, path, machine, axes, points[i]) for i in missing]
    ready = [one for one in requests if not isinstance(one, PymdrError)]
    results = solutions(ready, applied, workers)
    written_at, first = time.monotonic(), 0
    for k, (i, one) in enumerate(zip(missing, requests, strict=True)):
        answers.add(int(i), one if isinstance(one, PymdrError) else next(results))
        is_last = k + 1 == missing.size or missing[k + 1] != i + 1
        if kept is not None and (is_last or time.monotonic() - written_at > _BETWEEN_WRITES):
            kept.keep(int(missing[first]), answers.block(int(missing[first]), int(i) + 1))
            written_at, first = time.monotonic(), k + 1
        if progress is not None:
            progress(len(points) - missing.size + k + 1, len(points))
    return answers.swept(contact, axes)


def _names(quantities: Any) -> list[str]:
    names = list(quantities) if isinstance(quantities, Iterable) and not isinstance(quantities, str) else None
    if names is None or not all(isinstance(name, str) for name in names):
        raise ProblemError(
            f"quantities = {shown(quantities)}; a list of names is needed, such as ['normal_force']"
        )
    return names


def _axis(contact: Contact, name: str, values: Any) -> _Axis:
    listed: Any = [values] if isinstance(values, str | Value) else values
    parts = isinstance(listed, list | tuple) and any(
        part is None or isinstance(part, Value) for part in listed
    )
    if parts:
        if name == _PATH and not all(isinstance(part, LoadingPath) for part in listed):
            raise ProblemError("over['path'] has an entry that is not a path, such as indent('1 um')")
        return _Axis(name, list(listed), None)
    if name == _MACHINE and isinstance(listed, list | tuple) and listed:
        return _Axis(name, [read_stiffness(stiffness) for stiffness in listed], "N/m")
    unit = "N/m" if name == _MACHINE else parameter_of(contact, name).unit
    numbers = np.atleast_1d(to_si_array(listed, unit, name=f"over[{name!r}]"))
    if numbers.ndim != 1 or numbers.size == 0:
        raise ProblemError(f"over[{name!r}] has the shape {numbers.shape}; one row of values is needed")
    return _Axis(name, [float(number) for number in numbers], unit)


def _point(
    contact: Contact, path: LoadingPath, machine: float | None, axes: Sequence[_Axis], values: Sequence[Any]
) -> Request | PymdrError:
    """The request at a point, or its error."""
    chosen = {axis.name: value for axis, value in zip(axes, values, strict=True)}
    path, machine = chosen.pop(_PATH, path), chosen.pop(_MACHINE, machine)
    try:
        return Request(with_parameters(contact, chosen), path, machine)
    except PymdrError as error:
        return error


def _identity(
    contact: Contact,
    path: LoadingPath,
    axes: Sequence[_Axis],
    machine: float | None,
    applied: Mapping[str, Any],
    quantities: Sequence[str] | None,
) -> dict[str, Any]:
    swept = [part for axis in axes for part in axis.values if isinstance(part, Profile)]
    if any(has_callables(profile) for profile in (contact.profile, *swept)):
        raise ProblemError(
            "folder= cannot compare a Function with that of an earlier run; leave the folder out, or "
            "sample the function as a profile"
        )
    return {
        "case": encode_case("", contact, path),
        "over": {
            axis.name: [encode(part) if isinstance(part, Value) else part for part in axis.values]
            for axis in axes
        },
        "machine_stiffness": machine,
        **{name: None if value is None else np.asarray(value).tolist() for name, value in applied.items()},
        "quantities": None if quantities is None else list(quantities),
    }


class _Answers:
    """The points of a sweep that are known so far."""

    def __init__(self, points: int, quantities: Sequence[str] | None) -> None:
        self.wanted = None if quantities is None else set(quantities)
        self.known = np.zeros(points, dtype=bool)
        self.columns: dict[str, FloatArray] = {}
        self.rows: dict[str, Any] = {}
        self.status = np.full(points, "", dtype=object)
        self.refusal = np.full(points, "", dtype=object)
        self.claims = np.full(points, "{}", dtype=object)

    def add(self, i: int, answer: Result | PymdrError) -> None:
        """Add the result or error of a point."""
        self.known[i] = True
        if isinstance(answer, PymdrError):
            self.refusal[i] = str(answer)
            return
        if self.wanted is not None and (strange := self.wanted - set(answer.claims) - {"time"}):
            raise QuantityError(
                f"quantities: no {', '.join(sorted(strange))}; there are {', '.join(answer.claims)}"
            )
        if "row" in answer.data.coords:
            self.rows = {"row": answer.data.coords["row"]}
        for name, array in answer.data.items():
            if self.wanted is None or name in self.wanted:
                self._column(str(name), array.shape)[i] = array.values
        self.status[i] = answer.status.name
        self.claims[i] = json.dumps(
            {
                name: [
                    claim.level.name,
                    claim.reason,
                    claim.source,
                    claim.readable,
                    largest_error(claim),
                    claim.excluded,
                ]
                for name, claim in answer.claims.items()
                if self.wanted is None or name in self.wanted
            }
        )

    def _column(self, name: str, shape: tuple[int, ...]) -> FloatArray:
        rows = shape[0]
        if name not in self.columns:
            size = 8.0 * self.known.size * math.prod(shape) * (len(self.columns) + 1)
            if size > 0.5 * memory_of_machine():
                raise ProblemError(
                    f"{self.known.size} points of {rows} rows need {size / 1e9:.3g} GB (limit {0.5 * memory_of_machine() / 1e9:.3g} GB, half of the "
                    "memory); give keep= for fewer rows, or quantities= for fewer columns"
                )
            self.columns[name] = np.full((self.known.size, *shape), math.nan)
        others = self.columns[name].shape[1:]
        if others[0] != rows:
            raise ProblemError(
                f"a point has {rows} rows and another {others[0]}; sweep over paths of one length"
            )
        if others != shape:
            raise ProblemError(
                "some paths are in the plane and others along a line; sweep over them one kind at a time"
            )
        return self.columns[name]

    def block(self, first: int, end: int) -> xr.Dataset:
        """A dataset of some points over ``part``."""
        part = slice(first, end)
        texts = {"status": self.status, "refusal": self.refusal, "claims": self.claims}
        return dataset(
            {
                name: (("part", "step", "axis")[: values.ndim], values[part])
                for name, values in self.columns.items()
            }
            | {name: ("part", values[part].astype(str)) for name, values in texts.items()},
            coords=self.rows,
        )

    def read(self, first: int, block: xr.Dataset) -> None:
        """The inverse of :meth:`block`."""
        part = slice(first, first + block.sizes["part"])
        self.known[part] = True
        if "row" in block.coords:
            self.rows = {"row": block.coords["row"]}
        for name, array in block.items():
            if name in ("status", "refusal", "claims"):
                getattr(self, str(name))[part] = array.values
            else:
                self._column(str(name), array.shape[1:])[part] = array.values

    def swept(self, contact: Contact, axes: Sequence[_Axis]) -> Sweep:
        """The whole grid, or the error of the first point if all failed."""
        if np.all(self.refusal != ""):
            raise ProblemError(
                f"none of {self.known.size} points can be solved; the first: {self.refusal[0]}"
            )
        names, shape = [axis.name for axis in axes], [len(axis.values) for axis in axes]
        coords = {axis.name: _coordinate(axis) for axis in axes}
        coords["step"] = ("step", np.arange(next(iter(self.columns.values())).shape[1]))
        data = {
            name: (
                (*names, "step", "axis")[: len(names) + values.ndim - 1],
                values.reshape(*shape, *values.shape[1:]),
                _attributes(name),
            )
            for name, values in self.columns.items()
        }
        if any(values.ndim == 3 for values in self.columns.values()):
            coords["axis"] = ("axis", list(AXES))
        texts = {
            name: (names, values.reshape(shape).astype(str))
            for name, values in (("status", self.status), ("refusal", self.refusal))
        }
        return Sweep(
            contact=contact, data=dataset(data | texts, coords=coords | self.rows), claims=self._weakest()
        )

    def _weakest(self) -> dict[str, Claim]:
        """The weakest claim of every quantity, with the number of points that have it."""
        claims_by_point = [json.loads(claims) for claims in self.claims]
        weakest: dict[str, Claim] = {}
        for name in dict.fromkeys(name for claims in claims_by_point for name in claims):
            there = [claims.get(name) for claims in claims_by_point]
            where = np.array([one is not None and bool(one[3]) for one in there])
            read = [one for one in there if one is not None and one[3]] or [
                one for one in there if one is not None
            ]
            level = max((Level[one[0]] for one in read), key=_LEVELS.index)
            worst = [one for one in read if one[0] == level.name]
            reason = worst[0][1]
            if len(worst) < len(there):
                reason = f"at {len(worst)} of {len(there)} points: {reason}"
            errors = [one[4] if one is not None and one[3] else 0.0 for one in there]
            known = None if None in errors else np.array(errors, dtype=float)
            excluded = next((text for one in read for text in one[5:] if text), "")
            weakest[name] = Claim(level, reason, worst[0][2], where, known, excluded)
        return weakest


def _coordinate(axis: _Axis) -> tuple[Any, ...]:
    if axis.unit is None:
        return (axis.name, [repr(part) for part in axis.values])
    return (axis.name, np.array(axis.values), {"units": axis.unit})


def _attributes(name: str) -> dict[str, str]:
    base = name.removesuffix("_low").removesuffix("_high")
    row = quantity(base)
    return {"units": row.unit, "long_name": row.long_name, "symbol": row.symbol}


def _shown_value(values: xr.DataArray, i: int) -> str:
    unit = values.attrs.get("units")
    return str(values.values[i]) if unit is None else written(float(values.values[i]), unit)


def _range(values: xr.DataArray) -> str:
    """Number of values of a parameter and their ends, as text."""
    if values.size == 1:
        return _shown_value(values, 0)
    ends = f"{_shown_value(values, 0)} to {_shown_value(values, values.size - 1)}"
    return f"{values.size} values, {ends}" if "units" in values.attrs else f"{values.size} values"
