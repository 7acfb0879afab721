"""Nanoindentation records from files of instruments: Hysitron, Agilent, MTS and KLA, Fischerscope, and tables."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pymdr.deferred import xr
from pymdr.errors import CaseError, ProblemError
from pymdr.presentation.files import named_file
from pymdr.problem.profiles import AreaFunction
from pymdr.units import FloatArray, shown
from pymdr.workbench.inputs import read_measured_text
from pymdr.workbench.spreadsheets import SPREADSHEETS, read_sheets
from pymdr.workbench.tables import columns_of_lines, decimal_points, refuse_cut_number, sheets_with_tables

_LARGEST = 500 * 2**20
_FEWEST = 8
_NAMES: Mapping[str, tuple[str, ...]] = {
    "time": ("time on sample", "time in contact", "test time", "time", "t"),
    "indentation": (
        "displacement into surface",
        "depth",
        "disp",
        "indent disp",
        "displacement",
        "indentation",
        "d",
        "h",
    ),
    "normal_force": (
        "load on sample",
        "force on surface",
        "load",
        "force",
        "indent load",
        "normal force",
        "f",
        "p",
    ),
    "harmonic_stiffness": (
        "harmonic contact stiffness",
        "harmonic stiffness",
        "dynamic stiffness",
        "stiffness",
    ),
}
"""Titles of columns, those first that are corrected for the surface and the springs of the instrument."""
_NEEDED = ("indentation", "normal_force")
_EXAMPLE = "time [s], depth [nm], load [mN]"
_TEST = re.compile(r"test\s*\d+", re.IGNORECASE)
_SECTION = re.compile(r"(?P<name>.*?)\s*Data Points:\s*(?P<count>\d+)\s*")
_COEFFICIENT = re.compile(r"Tip C(?P<index>\d):\s*(?P<value>\S+)")
_FISCHER = re.compile(r"\S+\.hap\s+\d\d\.\d\d\.\d{4}\s+\d\d:\d\d:\d\d\s*")


class _Test(NamedTuple):
    """One test of a file: its columns in SI units, and the area function of its tip, if the file has one."""

    name: str
    columns: dict[str, FloatArray]
    coefficients: tuple[float, ...] = ()
    """Of the area function, of depths in nm."""


def read_indents(file: str | os.PathLike[str]) -> tuple[xr.Dataset, ...]:
    r"""
    Read the indents of a file of a nanoindenter, as :func:`oliver_pharr` and :func:`calibrate_area` take them.

    Parameters
    ----------
    file : path
        ``.hld`` (Hysitron, Bruker), ``.xls`` or ``.xlsx`` with a sheet for each test (Agilent, MTS, KLA; the extras ``xls`` and ``xlsx``), text of
        Fischerscope, or a table with units, such as ``time [s], depth [nm], load [mN]``, as text or spreadsheet. A header may follow other
        lines, and units may be in the line below it.

    Returns
    -------
    tuple of xarray.Dataset
        One for each test, in the order of the file, over ``step``: ``indentation`` (m), ``normal_force`` (N), and if the file has them ``time``
        (s) and ``harmonic_stiffness`` (N/m, nan where not measured). The attributes ``test`` and ``file`` name it, ``area_coefficients`` are those of the
        file's area function for depths in nm. Depths and forces are those of the file: its contact point, and its corrections.

    Raises
    ------
    FileError
        If the file cannot be read.
    CaseError
        If it has no table of depth and load with units, entries are not numbers, or it is cut off.
    MissingExtraError
        If a spreadsheet needs a package that is not installed.

    See Also
    --------
    read_record : one table with other channels.

    Examples
    --------
    >>> import pymdr as mdr
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "indent.txt"
    ...     rows = [f"{0.1 * i:.1f}\t{10 * i}\t{i * i}" for i in range(9)]
    ...     _ = file.write_text("\n".join(["Number of Points = 9", "Time (s)\tDepth (nm)\tLoad (uN)", *rows]))
    ...     [indent] = mdr.read_indents(file)
    >>> float(indent["normal_force"][-1]), indent.attrs["test"]
    (6.4e-05, 'indent')
    """
    from pymdr.result import labelled

    source = named_file(file, "read")
    read = []
    for test in _tests(source):
        data = labelled(_cleaned(source, test))
        data.attrs.update(test=test.name, file=source.name)
        if test.coefficients:
            data.attrs["area_coefficients"] = list(test.coefficients)
        read.append(data)
    if not read:
        raise CaseError(f"{source}: no test with depth and load; export the indents with their raw data")
    return tuple(read)


def area_function_of(records: Sequence[xr.Dataset]) -> AreaFunction | None:
    """
    The area function stated in the files, for depths in nm.

    Returns
    -------
    AreaFunction or None
        None if a record has none.
    """
    coefficients = {tuple(record.attrs.get("area_coefficients", ())) for record in records}
    if () in coefficients:
        return None
    if len(coefficients) > 1:
        raise ProblemError(
            f"the files have {len(coefficients)} different area functions; give one, or evaluate the indents of each tip separately"
        )
    return AreaFunction(list(coefficients.pop()), unit="1 nm")


def _tests(source: Path) -> Iterator[_Test]:
    if source.suffix.lower() in SPREADSHEETS:
        yield from _sheets(source)
        return
    text = read_measured_text(source, _LARGEST, "indentation record")
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    refuse_cut_number(source, lines)
    if any(_SECTION.fullmatch(line) for line in lines[:2000]):
        yield _hysitron(source, lines)
    elif "Name of the application" in (lines[0] if lines else ""):
        yield from _fischerscope(source, lines)
    else:
        yield _Test(source.stem, _columns(source, lines))


def _columns(source: Path, lines: Sequence[str]) -> dict[str, FloatArray]:
    """A table whose columns of one quantity are reduced to the first of `_NAMES`."""
    names = dict(_NAMES)
    while True:
        try:
            return columns_of_lines(source, lines, names, _NEEDED, _EXAMPLE, tuple(_NAMES))
        except CaseError as error:
            doubled = re.search(r"\d+ columns of (\w+) in the header", str(error))
            if doubled is None or len(names[doubled[1]]) == 1:
                raise
            names[doubled[1]] = names[doubled[1]][:-1]


def _sheets(source: Path) -> Iterator[_Test]:
    sheets = read_sheets(source, _LARGEST)
    tests = [name for name in sheets if _TEST.fullmatch(name.strip())]
    if not tests:  # a table of a user
        tables = sheets_with_tables(sheets, _NAMES) or [name for name in sheets if len(sheets[name]) > 1][:1]
        if not tables:
            raise CaseError(f"{source}: an empty spreadsheet; export the indents with their raw data")
        yield from (_Test(name, _columns(source, sheets[name])) for name in tables)
        return
    coefficients = _coefficients(sheets.get("Results", []))
    for name in tests:
        lines = sheets[name]
        if len(lines) - 2 < _FEWEST:  # a test that was aborted
            continue
        number = int(re.sub(r"\D", "", name))
        yield _Test(name, _columns(source, lines), coefficients.get(number, ()))


def _coefficients(results: Sequence[str]) -> dict[int, tuple[float, ...]]:
    """Coefficients of the area function of each test, as the sheet of results has them."""
    if not results:
        return {}
    titles = results[0].split("\t")
    places = [(title, i) for i, title in enumerate(titles) if re.fullmatch(r"Area Coefficient \d", title)]
    by_test: dict[int, tuple[float, ...]] = {}
    for line in results[1:]:
        cells = line.split("\t")
        try:
            number = int(float(cells[0]))
            values = tuple(float(cells[i]) for _, i in sorted(places))
        except (ValueError, IndexError):
            continue
        if values and np.all(np.isfinite(values)):
            by_test[number] = values
    return by_test


def _hysitron(source: Path, lines: Sequence[str]) -> _Test:
    """The section of the test of a .hld; those of approach and drift are before it."""
    starts = [(i, match) for i, line in enumerate(lines) if (match := _SECTION.fullmatch(line))]
    section = next(((i, match) for i, match in starts if match["name"].strip() == "Test"), None)
    if section is None:
        raise CaseError(
            f"{source}: a Hysitron record without the section of its test; it was aborted, or the file is cut off"
        )
    start, match = section
    count = int(match["count"])
    rows = [line for line in lines[start + 2 : start + 2 + count] if line.strip()]
    if len(rows) < count:
        raise CaseError(
            f"{source}: the file is cut off: it has {len(rows)} of {count} rows of the test; copy it again from the instrument"
        )
    header = "\t".join(_bracketed(title) for title in lines[start + 1].split("\t"))
    coefficients: dict[int, float] = {}
    for line in lines[:start]:
        if known := _COEFFICIENT.match(line):
            try:
                coefficients[int(known["index"])] = float(known["value"])
            except ValueError as error:
                raise CaseError(
                    f"{source}: {shown(line.strip())} in the header is not a number; copy the file again from the instrument"
                ) from error
    values = tuple(coefficients.get(i, 0.0) for i in range(max(coefficients, default=-1) + 1))
    while values and values[-1] == 0.0:
        values = values[:-1]
    return _Test(source.stem, _columns(source, [header, *rows]), values)


def _bracketed(title: str) -> str:
    """A title such as Disp_nm with its unit in brackets."""
    name, _, unit = title.strip().rpartition("_")
    return f"{name} [{unit}]" if name else title


def _fischerscope(source: Path, lines: Sequence[str]) -> Iterator[_Test]:
    """The blocks of a text of Fischerscope, whose columns are in mN, um and s."""
    starts = [i for i, line in enumerate(lines) if _FISCHER.fullmatch(line)]
    for number, (first, last) in enumerate(zip(starts, [*starts[1:], len(lines)], strict=True), start=1):
        head = next((i for i in range(first, last) if lines[i].split("\t")[:3] == ["F", "h", "t"]), None)
        if head is None:
            continue
        titles = lines[head].split("\t")
        units = {"F": "mN", "h": "um", "t": "s"}
        header = "\t".join(f"{title} [{units[title]}]" if title in units else title for title in titles)
        rows = [line for line in lines[head + 1 : last] if line.count("\t") == len(titles) - 1]
        yield _Test(f"{number}", _columns(source, [header, *decimal_points(rows, "\t")]))


def _cleaned(source: Path, test: _Test) -> dict[str, FloatArray]:
    """The columns without rows that have no depth, force or time, such as marks of segments."""
    columns = test.columns
    known = np.all([np.isfinite(columns[name]) for name in columns if name != "harmonic_stiffness"], axis=0)
    if np.count_nonzero(known) < _FEWEST:
        raise CaseError(
            f"{source}, {test.name}: {np.count_nonzero(known)} of {known.size} rows have a depth and a load; at least {_FEWEST} are needed"
        )
    return {name: values[known] for name, values in columns.items()}
