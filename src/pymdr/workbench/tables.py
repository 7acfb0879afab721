"""Tables with units in their header: measured profiles, and records of loads and displacements."""

from __future__ import annotations

import csv
import os
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from pymdr.deferred import xr
from pymdr.errors import CaseError, PathError, ProblemError, PymdrError, UnitError, errors_of_case
from pymdr.interpretation.closure import error_of_force
from pymdr.presentation.files import named_file
from pymdr.problem.paths import CHANNELS, NORMAL_CHANNELS, TANGENTIAL_CHANNELS
from pymdr.problem.paths import Path as MeasuredPath
from pymdr.problem.profiles import AreaFunction, ForceCurve, Sampled
from pymdr.problem.profiles.sampled import Interpolation
from pymdr.quantities import QUANTITIES
from pymdr.solving.curves import MeasuredCurve
from pymdr.units import FloatArray, QuantityLike, to_si
from pymdr.workbench.inputs import read_measured_text
from pymdr.workbench.spreadsheets import SPREADSHEETS, read_sheets

_COLUMN = re.compile(r"\s*(?P<name>.*?)\s*[\[(]\s*(?P<unit>[^\[\]()]+?)\s*[\])]\s*")
_NUMBER = re.compile(r"\s*[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?\s*", re.ASCII)
_COMMA = re.compile(r"[+-]?[0-9]*,[0-9]+(?:[eE][+-]?[0-9]+)?", re.ASCII)
_POINT = re.compile(r"[+-]?[0-9]*\.[0-9]+(?:[eE][+-]?[0-9]+)?", re.ASCII)
_THOUSANDS = re.compile(r"[+-]?[1-9][0-9]{0,2},[0-9]{3}", re.ASCII)
_EXCEL = re.compile(r"sep=.", re.IGNORECASE)
"""First line of Excel files that gives the separator of columns."""
_DECIMALS = re.compile(r"\.[0-9]+(?:[eE][+-]?[0-9]+)?$", re.ASCII)
"""What follows the point of the last number of a line."""
_FIXED = 20
"""Smallest number of rows with equal decimals that show a fixed format."""
_LARGEST = 200 * 2**20
_PREAMBLE = 400
"""Lines among which the header of columns is searched."""
_PRIMES = (("\u2033", "''"), ("\u2032", "'"), ("\u2019", "'"), ('"', "''"))
"""Other characters for the primes of G' and G''."""

Names = Mapping[str, tuple[str, ...]]

_PROFILE: Names = {
    "radius": ("r", "radius", "radial distance"),
    "height": ("f", "height", "gap", "z"),
    "scatter": ("scatter", "std", "sd", "sigma", "standard deviation"),
}
_CURVE: Names = {
    "indentation": ("displacement", "indentation", "d", "depth", "approach"),
    "normal_force": ("load", "normal force", "force", "f", "fn", "fz", "f n", "f z"),
}
_CURVE_ERRORS: Names = {
    "indentation_error": ("indentation error",),
    "normal_force_error": ("normal force error", "force error", "error"),
}
_RECORD: Names = {
    "time": ("time", "t"),
    "indentation": ("displacement", "indentation", "d", "depth", "approach"),
    "normal_force": ("load", "normal force", "force", "fn", "fz", "f n", "f z"),
    "travel": ("travel", "piezo", "crosshead"),
    "shift": ("shift", "ux", "u x", "tangential displacement", "lateral displacement"),
    "tangential_force": ("tangential force", "lateral force", "friction force", "fx", "ft", "f x", "f t"),
}
_FORCE_RECORD: Names = {
    **_RECORD,
    "travel": (*_RECORD["travel"], "z piezo", "piezo displacement", "piezo position"),
    "height": (
        "height",
        "height measured",
        "height (measured)",
        "measured height",
        "height piezo",
        "height (piezo)",
        "cantilever height",
        "z height",
    ),
    "deflection": ("deflection", "cantilever", "cantilever deflection", "vertical deflection", "defl"),
    "signal": ("deflection", "cantilever deflection", "vertical deflection", "defl", "signal", "photodiode"),
    "current": ("deflection", "cantilever deflection", "vertical deflection", "defl", "dfl", "photodiode"),
}
"""Deflections are lengths, or signals of the photodiode: voltages or currents."""
_DEFLECTIONS = {"deflection": "m", "signal": "V", "current": "A"}
_AREA: Names = {
    "indentation": ("contact depth", "depth", "h", "hc", "h c"),
    "contact_area": ("area", "contact area", "projected area", "a"),
}
_GRID: Names = {"x": ("x",), "y": ("y",), "height": ("z", "height", "h")}

_RHEOMETRY: Names = {
    "time": ("time", "t"),
    "frequency": ("frequency", "f"),
    "angular_frequency": ("angular frequency", "omega", "w"),
    "modulus": ("g", "shear modulus", "shear relaxation modulus"),
    "storage": ("g'", "shear storage", "shear storage modulus"),
    "loss": ("g''", "shear loss", "shear loss modulus"),
    "young": ("e", "young modulus", "young's modulus", "tensile modulus", "tensile relaxation modulus"),
    "young_storage": ("e'", "young storage", "young's storage modulus", "tensile storage modulus"),
    "young_loss": ("e''", "young loss", "young's loss modulus", "tensile loss modulus"),
    "loss_tangent": ("tan delta", "tan d", "tan(delta)", "loss tangent", "loss factor"),
    "some modulus": ("modulus", "relaxation modulus"),
    "some storage modulus": ("storage", "storage modulus"),
    "some loss modulus": ("loss", "loss modulus"),
}
_UNNAMED = "some "
_TESTS = (
    ("time", "modulus"),
    ("time", "young"),
    ("omega", "storage", "loss"),
    ("omega", "young_storage", "young_loss"),
)


def read_rheometry(file: str | os.PathLike[str]) -> dict[str, FloatArray]:
    """
    A relaxation test or a frequency sweep from a CSV file with units in its header.

    Parameters
    ----------
    file : path
        With the columns time and G or E, or frequency (Hz) or angular frequency (rad/s) with G' and G'' or E' and E''; tan delta
        may replace one of the two. Frequencies may rise or fall.

    Returns
    -------
    dict of str to ndarray
        ``time`` (s) and the shear ``modulus`` or ``young`` (Pa); or ``omega`` (rad/s) with ``storage`` and ``loss`` in shear, or
        ``young_storage`` and ``young_loss`` (Pa).
    """
    example = "time [s], G [kPa]' or 'frequency [Hz], G' [kPa], G'' [kPa]"
    columns = _read(file, _RHEOMETRY, (), example)
    unnamed = [name for name in columns if name.startswith(_UNNAMED)]
    if unnamed:
        raise CaseError(
            f"{file}: the column {unnamed[0].removeprefix(_UNNAMED)} does not say whether it is a shear or a Young's modulus; "
            "name the columns G, or G' and G'', for shear, and E, or E' and E'', for Young's modulus"
        )
    if "frequency" in columns and "angular_frequency" not in columns:
        columns["angular_frequency"] = 2.0 * np.pi * columns.pop("frequency")
    if "angular_frequency" in columns:
        columns["omega"] = columns.pop("angular_frequency")
    if "omega" in columns and (np.diff(columns["omega"]) < 0.0).all():
        columns = {name: values[::-1] for name, values in columns.items()}
    tangent = columns.pop("loss_tangent", None)
    for storage, loss in (("storage", "loss"), ("young_storage", "young_loss")):
        if tangent is not None and storage in columns and loss not in columns:
            columns[loss] = columns[storage] * tangent
        elif tangent is not None and loss in columns and storage not in columns and (tangent > 0.0).all():
            columns[storage] = columns[loss] / tangent
    for names in _TESTS:
        if set(columns) == set(names):
            return {name: columns[name] for name in names}
    raise CaseError(
        f"{file} has {', '.join(columns)}; a relaxation test needs time and a modulus (G or E), a frequency sweep needs "
        f"frequency with G' and G'', or E' and E''; write a header such as '{example}'"
    )


def read_columns(file: str | os.PathLike[str]) -> dict[str, FloatArray]:
    """
    Radius, height and scatter in m from a CSV file.

    The first line that is not a comment (``#``) is the header; every length column has its unit in brackets,
    as in ``r [nm], f [nm], scatter [nm]``. Other columns are ignored. Columns are separated by commas, semicolons or
    tabs, and entries may be quoted. Decimals have a point, or a comma if columns are separated by semicolons or tabs.
    The text is UTF-8, UTF-16 or latin-1.

    Returns
    -------
    dict of str to ndarray
        ``radius``, ``height`` and optionally ``scatter``.
    """
    return _read(file, _PROFILE, ("radius", "height"), "r [nm], f [nm]")


def read_grid_columns(file: str | os.PathLike[str]) -> dict[str, FloatArray]:
    """
    Positions and heights in m from a CSV file with units in its header, such as ``x [um], y [um], z [nm]``.

    Returns
    -------
    dict of str to ndarray
        ``x``, ``y`` and ``height``.
    """
    return _read(file, _GRID, ("x", "y", "height"), "x [um], y [um], z [nm]")


def read_curve_columns(file: str | os.PathLike[str]) -> dict[str, FloatArray]:
    """
    Depths and forces in SI units from a CSV file with units in its header, such as ``d [nm], F [uN]``.

    Returns
    -------
    dict of str to ndarray
        ``indentation`` (m) and ``force`` (N), and, if the file has columns of errors as written by ``to_csv``, ``error``: the
        relative errors of the forces including those of the indentations, nan where empty.
    """
    names = {**_CURVE, **_CURVE_ERRORS}
    columns = _read(file, names, ("indentation", "normal_force"), "d [nm], F [uN]", tuple(_CURVE_ERRORS))
    depth, force = columns["indentation"], columns["normal_force"]
    if not any(name in columns for name in _CURVE_ERRORS):
        return {"indentation": depth, "force": force}
    errors = (columns.get(name, np.zeros(depth.shape)) for name in _CURVE_ERRORS)
    return {"indentation": depth, "force": force, "error": error_of_force(depth, force, *errors)}


def read_record(file: str | os.PathLike[str]) -> xr.Dataset:
    r"""
    Read a measured record of loads and displacements from a CSV file with units in its header.

    Parameters
    ----------
    file : path
        With any of the columns time, displacement (or indentation), load (or normal force), travel, shift and
        tangential force, each with its unit: ``time [s], load [mN], shift [um]``. Names with underscores, as
        written by :meth:`pymdr.Result.to_csv`, are accepted; other columns are ignored, and lines that begin with ``#``
        are comments. Columns are separated by commas, semicolons or tabs, and entries may be quoted. Decimals have a
        point, or a comma if columns are separated by semicolons or tabs. The text is UTF-8, UTF-16 or latin-1.

    Returns
    -------
    xarray.Dataset
        The columns over ``step`` in SI units, under the names of quantities: ``time``, ``indentation``,
        ``normal_force``, ``travel``, ``shift``, ``tangential_force``.

    Raises
    ------
    FileError
        If the file cannot be read.
    CaseError
        If the header has no units or no such column, or a row is not numbers.

    Examples
    --------
    >>> import pymdr as mdr
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "record.csv"
    ...     _ = file.write_text("load [mN], displacement [um]\n1, 0.5\n2, 1\n")
    ...     record = mdr.read_record(file)
    >>> record["normal_force"].values.tolist()
    [0.001, 0.002]
    """
    from pymdr.result import labelled

    return labelled(_read(file, _RECORD, (), "time [s], load [mN], shift [um]"))


def read_path(
    file: str | os.PathLike[str],
    *,
    channels: Sequence[str] | Mapping[str, str] | None = None,
    relative_time: bool = False,
) -> MeasuredPath:
    r"""
    Read a measured history as a path from a CSV file with units in its header.

    Parameters
    ----------
    file : path
        As for :func:`read_record`.
    channels : sequence of str, or mapping of str to str, optional
        Columns to prescribe: at most one of ``indentation``, ``normal_force`` and ``travel``, and at most one of ``shift``
        and ``tangential_force``; needed if the file has several of one direction. A mapping gives each the title of its
        column without the unit, ``{"shift": "displacement"}``, and ``time`` likewise where its column has another title.
    relative_time : bool
        Whether the times count on from the legs before the record, see :class:`pymdr.Path`.

    Returns
    -------
    Path
        One row per row of the file, with its times if it has them.

    Raises
    ------
    FileError, CaseError
        As :func:`read_record`.
    PathError
        If the prescribed channels are ambiguous, or times do not rise.

    Examples
    --------
    >>> import pymdr as mdr
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "shifts.csv"
    ...     _ = file.write_text("time [s], shift [um]\n1, 0.5\n2, 1\n")
    ...     path = mdr.read_path(file)
    >>> path.shift.tolist()
    [5e-07, 1e-06]
    """
    names, needed = _RECORD, list[str]()
    if isinstance(channels, Mapping):
        names, needed = _titled(channels), list(channels)
        channels = [name for name in channels if name != "time"]
    columns = _read(file, names, needed, "time [s], load [mN], shift [um]")
    named = (
        [name for name in CHANNELS if name in columns]
        if channels is None
        else _chosen(file, channels, columns)
    )
    directions = [[n for n in named if n in group] for group in (NORMAL_CHANNELS, TANGENTIAL_CHANNELS)]
    for both in directions:
        if len(both) > 1:
            one_each = [names[0] for names in directions if names]
            raise PathError(
                f"{file} has {' and '.join(both)}, of which only one can be prescribed; choose, for example, "
                f"channels = {one_each}"
            )
    if not named:
        raise PathError(
            f"{file} has no column of {', '.join(CHANNELS[:-1])} or {CHANNELS[-1]}; name one so, or give channels"
        )
    with _named_file(file):
        time = columns.get("time")
        prescribed = {name: columns[name] for name in named}
        return MeasuredPath(time=time, **prescribed, relative_time=relative_time and time is not None)


@contextmanager
def _named_file(file: str | os.PathLike[str]) -> Iterator[None]:
    """Add the name of the file to errors about its contents."""
    try:
        yield
    except PymdrError as error:
        error.args = (f"{file}: {error}",)
        raise


def read_curve(file: str | os.PathLike[str], *, spring_constant: QuantityLike | None = None) -> MeasuredCurve:
    """
    Read a measured force curve from a CSV file with units in its header.

    Parameters
    ----------
    file : path
        As for :func:`read_record`: load with displacement (or indentation) or travel, and optionally time.
    spring_constant : quantity, optional
        Spring constant of the machine in N/m; needed with travel.

    Returns
    -------
    MeasuredCurve

    Raises
    ------
    FileError, CaseError
        As :func:`read_record`.
    ProblemError
        If not exactly one of displacement and travel is given, or travel has no spring constant.

    See Also
    --------
    read_force_curve : a force curve used as the profile of a contact.
    """
    return curve_of_columns(file, read_force_columns(file, missing=False), spring_constant)


class _MissingEntryError(CaseError):
    """An entry without a number."""


def read_force_columns(file: str | os.PathLike[str], *, missing: bool) -> dict[str, FloatArray]:
    """
    The columns of a force curve in SI units, as far as the table has them.

    Parameters
    ----------
    file : path
        As for :func:`read_record`, behind a preamble or without one. In place of a force there may be a ``deflection`` in m, V or A, and a
        ``height`` in place of a travel.
    missing : bool
        Whether invalid entries are nan; else they are refused.

    Returns
    -------
    dict of str to ndarray
        ``normal_force``, ``indentation``, ``travel``, ``time``; ``height`` and ``deflection`` in m; ``signal`` in V, ``current`` in A.
    """
    names = tuple(_FORCE_RECORD) if missing else ()
    try:
        columns = _read(file, _FORCE_RECORD, (), "time [s], load [mN], travel [um]", names)
    except _MissingEntryError as error:
        raise CaseError(f"{error}; leave_out_missing omits them") from error
    if not {"normal_force", *_DEFLECTIONS} & set(columns):
        raise CaseError(
            f"{file} is a table of {', '.join(columns)} without a force; name a column 'load' or 'deflection' with its unit, for example 'load [N]'"
        )
    if "normal_force" in columns:  # the deflection of a cantilever is its force over the spring constant
        for name in _DEFLECTIONS:
            columns.pop(name, None)
    return columns


def curve_of_columns(
    file: str | os.PathLike[str],
    columns: Mapping[str, FloatArray],
    spring_constant: QuantityLike | None,
) -> MeasuredCurve:
    """The force curve of the columns of a file."""
    try:
        return MeasuredCurve(
            force=columns["normal_force"],
            indentation=columns.get("indentation"),
            travel=columns.get("travel"),
            time=columns.get("time"),
            spring_constant=spring_constant,
        )
    except ProblemError as error:
        raise ProblemError(f"{file}: {error}") from error


def _titled(channels: Mapping[str, str]) -> Names:
    """Titles of the columns of a record with those of some channels replaced."""
    for name, title in channels.items():
        if name not in ("time", *CHANNELS) or not isinstance(title, str):
            raise PathError(
                f"channels: {name!r} = {title!r}; give channels the titles of their columns, for example "
                "channels = {shift = 'displacement'}"
            )
    titles = {name: _title(title)[0] for name, title in channels.items()}
    others = {
        name: tuple(word for word in words if word not in titles.values())
        for name, words in _RECORD.items()
        if name not in titles
    }
    return {**others, **{name: (title,) for name, title in titles.items()}}


def _chosen(file: object, channels: Sequence[str], columns: Mapping[str, FloatArray]) -> list[str]:
    if (
        not isinstance(channels, Sequence)
        or isinstance(channels, str)
        or not all(isinstance(name, str) for name in channels)
        or not channels
    ):
        raise PathError(
            f"channels = {channels!r}: a list of names such as ['normal_force', 'shift'] is needed"
        )
    has = [name for name in CHANNELS if name in columns]
    for name in channels:
        if name not in has:
            remedy = f"; give the title of its column, for example channels = {{{name} = 'displacement'}}"
            raise PathError(
                f"channels: {file} has no column of {name!r}; it has {', '.join(has) or 'none'}{remedy if name in CHANNELS else ''}"
            )
    return list(channels)


def _read(
    file: str | os.PathLike[str],
    names: Names,
    needed: Sequence[str],
    example: str,
    missing: Sequence[str] = (),
) -> dict[str, FloatArray]:
    source = named_file(file, "read")
    return columns_of_lines(source, lines_of(source, names), names, needed, example, missing)


def lines_of(source: Path, names: Names) -> list[str]:
    """The lines of a text, or the rows of the sheet of a spreadsheet that has a table, with tabs between their cells."""
    if source.suffix.lower() in SPREADSHEETS:
        sheets = read_sheets(source, _LARGEST)
        tables = sheets_with_tables(sheets, names)
        if len(tables) > 1:
            raise CaseError(
                f"{source}: {len(tables)} sheets have tables ({', '.join(tables[:5])}); save each as a file of its own"
            )
        return next((sheets[name] for name in [*tables, *sheets] if sheets[name]), [])
    text = read_measured_text(source, _LARGEST, "table")
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    refuse_cut_number(source, lines)
    return lines


def sheets_with_tables(sheets: Mapping[str, list[str]], names: Names) -> list[str]:
    """The names of the sheets with a header of named columns and their units."""
    known = {title for titles in names.values() for title in titles}
    tables = []
    for name, lines in sheets.items():
        rows = _rows_of(lines)[1]
        titles = map(_title, _header_in(rows, names)[2]) if len(rows) > 1 else ()
        if any(title in known and unit is not None for title, unit in titles):
            tables.append(name)
    return tables


def refuse_cut_number(source: Path, lines: Sequence[str], decimals: re.Pattern[str] = _DECIMALS) -> None:
    """Refuse a text whose last line has no end and fewer decimals in its last number than all other lines: a cut-off exponent would be another number."""
    if not lines[-1] or lines[-1].startswith("#"):
        return
    rows = [match for line in lines[:-1] if (match := decimals.search(line))]
    widths = {len(match[0]) for match in rows}
    last = decimals.search(lines[-1])
    if len(rows) >= _FIXED and len(widths) == 1 and (len(last[0]) if last else 0) < widths.pop():
        raise CaseError(
            f"{source}: the file is cut off in its last line, {lines[-1][-40:]!r}: copy it again from the instrument, or delete that line; if the "
            "line is complete, end it with a line break"
        )


def columns_of_lines(
    source: Path,
    lines: Sequence[str],
    names: Names,
    needed: Sequence[str],
    example: str,
    missing: Sequence[str] = (),
) -> dict[str, FloatArray]:
    """The named columns of a table in SI units; its header may follow a preamble, and its units may be in the line below it."""
    numbered, rows = _rows_of(lines)
    if len(rows) < 2:
        raise CaseError(f"{source}: no table; write a header such as '{example}' and rows of numbers")
    first, separator, header, shown = _header_in(rows, names)
    columns = {
        quantity: [i for i, title in enumerate(header) if _title(title)[0] in titles]
        for quantity, titles in names.items()
    }
    columns = {quantity: indices for quantity, indices in columns.items() if indices}
    if not any(_title(header[i])[1] for indices in columns.values() for i in indices):
        # the line is not repeated: the file may be no table, but confidential
        raise CaseError(
            f"{source}: the first line that is not a comment is not a header of columns with units, separated "
            f"by commas, semicolons or tabs, for example '{example}'"
        )
    for quantity in needed:
        if quantity not in columns:
            title = names[quantity][0]
            remedy = (
                f"name one {title!r} with its unit, for example '{title} [{_si_unit(quantity)}]'"
                if title in _RECORD.get(quantity, names[quantity])
                else f"none is {title!r}, give {', '.join(dict.fromkeys(_title(one)[0] for one in header[:-1]))} or {_title(header[-1])[0]}"
            )
            raise CaseError(f"{source}: no column of {quantity} in the header {shown!r}; {remedy}")
    columns = _by_unit(columns, header)
    for quantity, indices in columns.items():
        if len(indices) > 1:
            raise CaseError(
                f"{source}: {len(indices)} columns of {quantity} in the header {shown!r}; keep one"
            )
    chosen = {quantity: indices[0] for quantity, indices in columns.items()}
    factors = {quantity: _factor(source, quantity, header[i]) for quantity, i in chosen.items()}
    entries = decimal_points(rows[first:], separator)
    table = _numbers(source, entries, numbered[first:], chosen, header, separator, missing)
    return {quantity: _scaled(table[:, i], factors[quantity]) for i, quantity in enumerate(chosen)}


def _rows_of(lines: Sequence[str]) -> tuple[list[int], list[str]]:
    """The numbers of the lines that are neither empty nor comments, and these lines."""
    numbered = [i for i, line in enumerate(lines) if line.strip() and not line.lstrip(' \t"').startswith("#")]
    if numbered and _EXCEL.fullmatch(lines[numbered[0]]):
        numbered = numbered[1:]
    return numbered, [lines[i] for i in numbered]


def _header_in(rows: Sequence[str], names: Names) -> tuple[int, str, list[str], str]:
    """The first row below the header, the separator of columns, their titles with their units, and the header as it is written."""
    known = {title for titles in names.values() for title in titles}
    for number, row in enumerate(rows[:_PREAMBLE]):
        separator = _separator(row, names)
        header = [title.strip() for title in _cells(row, separator)]
        titles = [_title(title) for title in header]
        if any(name in known and unit is not None for name, unit in titles):
            return number + 1, separator, _cells(row, separator), row
        below = _cells(rows[number + 1], separator) if number + 1 < len(rows) else []
        if len(below) == len(header) and sum(name in known for name, _ in titles) > 1 and _are_units(below):
            named = [
                f"{title} [{unit.strip()}]" if unit.strip() else title
                for title, unit in zip(header, below, strict=True)
            ]
            return number + 2, separator, named, row
    separator = _separator(rows[0], names)
    return 1, separator, _cells(rows[0], separator), rows[0]


def _are_units(cells: Sequence[str]) -> bool:
    """Whether a row has units, not numbers."""
    filled = [cell.strip() for cell in cells if cell.strip()]
    return bool(filled) and not any(_NUMBER.fullmatch(cell.replace(",", ".")) for cell in filled)


def _by_unit(columns: Mapping[str, list[int]], header: Sequence[str]) -> dict[str, list[int]]:
    """Columns without others of the same title and another kind of unit, such as depth (nm) and depth (V)."""
    kept = dict(columns)
    same = [quantity for quantity in _DEFLECTIONS if quantity in columns]
    for quantity, indices in columns.items():
        if len(indices) > 1 or quantity in same:
            kept[quantity] = [i for i in indices if _has_unit(header[i], _si_unit(quantity))]
            if not kept[quantity] and (quantity not in same):
                kept[quantity] = indices  # the units are refused later
    if same and not any(kept[quantity] for quantity in same):
        kept[same[0]] = columns[same[0]]
    return {quantity: indices for quantity, indices in kept.items() if indices}


def _has_unit(title: str, si_unit: str) -> bool:
    try:
        to_si(f"1 {_title(title)[1]}", si_unit, name="unit")
    except UnitError:
        return False
    return True


def decimal_points(rows: Sequence[str], separator: str | None) -> Sequence[str]:
    """
    Replace decimal commas by points, unless commas separate columns.

    Rows stay unchanged if they have decimal points too, or if all commas may separate thousands; such numbers are
    refused later.

    Examples
    --------
    >>> [decimal_points(rows, ";") for rows in (["1,5;2,25"], ["1,500;2,250"], ["1,5;2.25"])]
    [['1.5;2.25'], ['1,500;2,250'], ['1,5;2.25']]
    """
    if separator == "," or not any("," in row for row in rows):
        return rows
    # numbers contain no separator, so quotes can go
    table = [[cell.strip().strip('"') for cell in row.split(separator)] for row in rows]
    commas = {cell for cells in table for cell in cells if _COMMA.fullmatch(cell)}
    pointed = any(_POINT.fullmatch(cell) for cells in table for cell in cells)
    if pointed or all(map(_THOUSANDS.fullmatch, commas)):
        return rows
    between = separator or " "
    return [
        between.join(
            cell.replace(",", ".") if bare in commas else cell
            for cell, bare in zip(row.split(separator), cells, strict=True)
        )
        for row, cells in zip(rows, table, strict=True)
    ]


def _separator(header: str, names: Names) -> str:
    """The separator (comma, semicolon or tab) that gives most known titles."""
    known = {title for titles in names.values() for title in titles}
    return max(",;\t", key=lambda mark: sum(_title(title)[0] in known for title in _cells(header, mark)))


def _cells(line: str, separator: str) -> list[str]:
    """The entries of a line without quotes."""
    if '"' in line:
        try:
            return next(csv.reader([line], delimiter=separator, skipinitialspace=True))
        except csv.Error:  # an entry too long for csv
            pass
    return line.split(separator)


def _title(title: str) -> tuple[str, str | None]:
    match = _COLUMN.fullmatch(title)
    name, unit = (match["name"], match["unit"]) if match else (title.strip(), None)
    for prime, typed in _PRIMES:
        name = name.replace(prime, typed)
    return name.lower().replace("_", " "), unit


def _si_unit(quantity: str) -> str:
    if quantity in _CURVE_ERRORS:
        return ""
    if quantity in _RHEOMETRY and quantity not in QUANTITIES:
        return {"frequency": "Hz", "loss_tangent": ""}.get(quantity, "Pa")
    return QUANTITIES[quantity].unit if quantity in QUANTITIES else _DEFLECTIONS.get(quantity, "m")


def _factor(source: Path, quantity: str, title: str) -> float:
    unit = _title(title)[1]
    si_unit = _si_unit(quantity)
    if not si_unit and unit in (None, "-", "1"):
        return 1.0
    if unit is None:
        raise CaseError(
            f"{source}: column {title.strip()!r} has no unit; write for example '{title.strip()} [{si_unit}]'"
        )
    with errors_of_case(f"{source}:"):
        return to_si(f"1 {unit}", si_unit, name=f"unit of column {title.strip()!r}")


def _scaled(values: FloatArray, factor: float) -> FloatArray:
    inverse = 1.0 / factor
    return values / float(f"{inverse:.15g}") if factor < 1.0 else values * factor


def _numbers(
    source: Path,
    rows: Sequence[str],
    numbered: Sequence[int],
    chosen: Mapping[str, int],
    header: Sequence[str],
    separator: str,
    missing: Sequence[str],
) -> FloatArray:
    """The chosen columns; an invalid entry is refused, unless entries of its column may be missing."""
    width = len(header)
    if all(row.count(separator) == width - 1 for row in rows):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                table = np.loadtxt(
                    rows,
                    delimiter=separator,
                    quotechar='"',
                    comments=None,
                    usecols=list(chosen.values()),
                    ndmin=2,
                    dtype=float,
                )
        except (ValueError, UserWarning):
            pass
        else:
            if len(table) == len(rows):
                is_finite = np.isfinite(table).all(axis=1)
                if is_finite.all():
                    return table
                if not missing:  # the rows before the first that is refused are known
                    first = int(np.argmin(is_finite))
                    rows, numbered = rows[first:], numbered[first:]
    table = np.empty((len(rows), len(chosen)))
    for target, line, row in zip(table, numbered, rows, strict=True):
        cells = _cells(row, separator)
        if len(cells) != width:
            raise CaseError(
                f"{source}, line {line + 1}: {len(cells)} entries for {width} columns of the header; give one entry for each column"
            )
        for k, (quantity, i) in enumerate(chosen.items()):
            entry = f"{source}, line {line + 1}: {header[i].strip()[:40]} = {cells[i].strip()[:40]!r}"
            if cells[i].strip().lower().lstrip("+-") in ("nan", "inf", "infinity", ""):
                if quantity in missing:
                    target[k] = np.nan
                    continue
                raise _MissingEntryError(
                    f"{entry}; every entry must be a finite number: delete rows without data"
                )
            if not _NUMBER.fullmatch(cells[i]):
                remedy = "; write all decimals with a point" if "," in cells[i] else ""
                raise CaseError(f"{entry} is not a number{remedy}")
            target[k] = float(cells[i])
            if not np.isfinite(target[k]):
                raise CaseError(f"{entry} is outside the range of floats; check its unit")
    return table


def read_profile(file: str | os.PathLike[str], *, interpolation: Interpolation | None = None) -> Sampled:
    r"""
    Read a sampled profile from a CSV file with units in its header.

    Parameters
    ----------
    file : path
        With the columns r, f and optionally scatter, each with its unit: ``r [nm], f [nm], scatter [nm]``.
    interpolation : CubicSpline, ShapePreserving or SmoothingSpline, optional
        Interpolation of the samples; by default a smoothing spline if the file has a scatter, else a cubic spline with a
        round tip.

    Returns
    -------
    Sampled
        A profile for :class:`~pymdr.Contact`.

    Raises
    ------
    FileError, CaseError, ProblemError
        If the file cannot be read, is not such a table, or the samples are not a profile.

    Examples
    --------
    >>> import pymdr as mdr
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "tip.csv"
    ...     _ = file.write_text("r [um], height [nm]\n0, 0\n1, 5\n2, 20\n3, 45\n4, 80\n")
    ...     tip = mdr.read_profile(file)
    >>> tip.height.tolist()
    [0.0, 5e-09, 2e-08, 4.5e-08, 8e-08]
    """
    columns = read_columns(file)
    with _named_file(file):
        return Sampled(**columns, interpolation=interpolation)


def read_area_function(file: str | os.PathLike[str]) -> AreaFunction:
    r"""
    Read the area function of a tip from a CSV file with units in its header.

    Parameters
    ----------
    file : path
        With the columns contact depth (or h) and area (or A), each with its unit: ``h [nm], A [nm^2]``.

    Returns
    -------
    AreaFunction
        A profile that interpolates the table.

    Raises
    ------
    FileError, CaseError, ProblemError
        If the file cannot be read, is not such a table, or depths or areas do not rise.

    Examples
    --------
    >>> import pymdr as mdr
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "area.csv"
    ...     _ = file.write_text("h [nm], A [nm^2]\n10, 12000\n20, 28000\n40, 75000\n80, 230000\n")
    ...     tip = mdr.read_area_function(file)
    >>> round(float(tip.area_at("20 nm")) * 1e18)
    28000
    """
    columns = _read(file, _AREA, ("indentation", "contact_area"), "h [nm], A [nm^2]")
    with _named_file(file):
        return AreaFunction(depth=columns["indentation"], area=columns["contact_area"])


def read_force_curve(
    file: str | os.PathLike[str], *, modulus: QuantityLike, contact_point: QuantityLike | None = None
) -> ForceCurve:
    r"""
    Read a force curve from a CSV file with units in its header.

    Parameters
    ----------
    file : path
        With the columns d (or depth, indentation, displacement) and F (or force, load), each with its unit:
        ``d [nm], F [uN]``; only the approach, with rising depths. Relative errors of the forces are read from a column
        ``error``, or from ``normal_force_error`` and ``indentation_error`` as written by ``to_csv``.
    modulus, contact_point : quantity
        As for :class:`pymdr.ForceCurve`.

    Returns
    -------
    ForceCurve
        A profile for :class:`~pymdr.Contact`.

    Raises
    ------
    FileError, CaseError, ProblemError
        If the file cannot be read, is not such a table, or the points are not a force curve.

    Examples
    --------
    >>> import pymdr as mdr
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "curve.csv"
    ...     _ = file.write_text("d [nm], F [uN]\n10, 1\n20, 3\n30, 6\n40, 10\n50, 15\n")
    ...     curve = mdr.read_force_curve(file, modulus="1 GPa")
    >>> curve.force.tolist()
    [1e-06, 3e-06, 6e-06, 1e-05, 1.5e-05]
    """
    columns = read_curve_columns(file)
    with _named_file(file):
        return ForceCurve(**columns, modulus=modulus, contact_point=contact_point)
