"""Records of indents as arrays in SI units."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np

from pymdr.errors import ProblemError
from pymdr.solving.curves import MeasuredCurve
from pymdr.units import FloatArray, shown, to_si_array

T = TypeVar("T")
_FEWEST = 8
_UNITS = {"indentation": "m", "normal_force": "N", "time": "s", "harmonic_stiffness": "N/m"}


class Record(NamedTuple):
    """One indent, in the order of measurement."""

    depth: FloatArray
    """In m, the deflection of the frame included."""
    force: FloatArray
    """In N."""
    time: FloatArray | None = None
    """In s."""
    stiffness: FloatArray | None = None
    """Harmonic stiffness in N/m, nan where it was not measured."""
    elapsed: FloatArray | None = None
    """Time in s since contact, in proportion to which drift was subtracted from the depth."""
    rate_error: float = 0.0
    """Standard deviation in m/s of the rate of that drift."""
    name: str = ""
    """Of its file and test, if known."""
    refusal: str = ""
    """Why a correction for drift is not possible; no evaluation takes such a record."""

    def without(self, rows: slice) -> Record:
        """The record without some rows."""
        kept = np.ones(self.depth.size, dtype=bool)
        kept[rows] = False

        def some(column: FloatArray | None) -> FloatArray | None:
            return None if column is None else column[kept]

        return self._replace(
            depth=self.depth[kept],
            force=self.force[kept],
            time=some(self.time),
            stiffness=some(self.stiffness),
            elapsed=some(self.elapsed),
        )


@dataclass(frozen=True, kw_only=True)
class CorrectedRecords:
    """Records whose depths were corrected, which evaluations take in place of records."""

    corrected: tuple[Record, ...]
    """Indents whose depths are corrected for drift, without the hold; those that could not be corrected have a refusal."""


Records: TypeAlias = (
    MeasuredCurve
    | Mapping[Any, Any]
    | CorrectedRecords
    | Sequence[MeasuredCurve]
    | Sequence[Mapping[Any, Any]]
)
"""Of one indent or of several; a dataset is a mapping."""


def records_of(given: Records) -> tuple[Record, ...]:
    """
    Indents in SI units.

    Parameters
    ----------
    given : MeasuredCurve, xarray.Dataset, mapping of str to array_like of quantity, a sequence of them, or CorrectedRecords
    """
    if isinstance(given, CorrectedRecords):
        return given.corrected
    listed: Sequence[Any] = (
        [given]
        if isinstance(given, MeasuredCurve | Mapping | str) or not isinstance(given, Sequence)
        else given
    )
    if not len(listed):
        raise ProblemError("no record is given")
    records = []
    for i, one in enumerate(listed, 1):
        with named_indent(f"indent {i}" if len(listed) > 1 else ""):
            records.append(_record(one))
    return tuple(records)


@contextmanager
def named_indent(label: str) -> Iterator[None]:
    """Errors inside begin with the label of an indent; the only one has an empty label."""
    try:
        yield
    except ProblemError as error:
        if not label:
            raise
        raise ProblemError(f"{label}: {error}") from error


def _record(given: Any) -> Record:
    if isinstance(given, MeasuredCurve):
        return Record(given.depth, given.force, given.time)
    if not isinstance(given, Mapping):
        raise ProblemError(
            f"{shown(given)} is not a record; give a MeasuredCurve or what read_record returns"
        )
    for name in ("indentation", "normal_force"):
        if name not in given:
            raise ProblemError(f"the record has no {name}; indentation and normal_force are needed")
    columns = {
        name: to_si_array(given[name], unit, name=name, missing=name == "harmonic_stiffness")
        for name, unit in _UNITS.items()
        if name in given
    }
    shapes = {name: column.shape for name, column in columns.items()}
    if len(set(shapes.values())) > 1 or len(shapes["indentation"]) != 1:
        text = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise ProblemError(f"columns of the shapes {text}; rows of equal length are needed")
    if columns["indentation"].size < _FEWEST:
        raise ProblemError(f"{columns['indentation'].size} rows; at least {_FEWEST} are needed for an indent")
    time = columns.get("time")
    if time is not None and not np.all(np.diff(time) > 0.0):
        i = int(np.argmin(np.diff(time)))
        raise ProblemError(
            f"time[{i + 1}] = {time[i + 1]:g} s is not above {time[i]:g} s: times must rise; sort the rows and average those of equal time"
        )
    return Record(
        columns["indentation"],
        columns["normal_force"],
        time,
        columns.get("harmonic_stiffness"),
        name=_name_of(getattr(given, "attrs", {})),
    )


def _name_of(attributes: Mapping[str, Any]) -> str:
    """The name of a record that was read from a file: that of the file, and that of its test if the file has several."""
    file, test = (str(attributes.get(key, "")) for key in ("file", "test"))
    return file if not test or PurePath(file).stem == test else f"{file}, {test}".removeprefix(", ")


def labels_of(records: Sequence[Record]) -> list[str]:
    """How messages call each record; the only one has no label."""
    if len(records) == 1:
        return [""]
    return [f"indent {i}" + (f" ({one.name})" if one.name else "") for i, one in enumerate(records, 1)]


def numbered(records: Sequence[Record]) -> dict[str, Any]:
    """Coordinates of indents: their numbers, and the names of several records of files."""
    numbers = {"indent": ("indent", np.arange(1, len(records) + 1), {"units": ""})}
    if len(records) == 1 or not any(one.name for one in records):
        return numbers
    return {**numbers, "record": ("indent", [one.name for one in records], {"units": ""})}


def refuse_uncorrected(record: Record) -> None:
    """Refuse a record that could not be corrected for drift."""
    if record.refusal:
        raise ProblemError(record.refusal)


def attempted(
    records: Sequence[Record],
    evaluate: Callable[[int, Record], T],
    errors: dict[int, ProblemError],
) -> dict[int, T]:
    """
    What is evaluated of each record, by its number from 1.

    Parameters
    ----------
    evaluate : callable
        Called with the number and the record.
    errors : dict of int to ProblemError
        Records in it are left out; those that cannot be evaluated are added.
    """
    results = {}
    for number, (record, label) in enumerate(zip(records, labels_of(records), strict=True), 1):
        if number not in errors:
            try:
                with named_indent(label):
                    refuse_uncorrected(record)
                    results[number] = evaluate(number, record)
            except ProblemError as error:
                errors[number] = error
    if not results:
        raise errors[min(errors)]
    return results


def refusals(errors: Mapping[int, ProblemError]) -> list[str]:
    """Notes of the records that cannot be evaluated."""
    return [f"{errors[number]}; its numbers are nan" for number in sorted(errors)]
