"""Profiles from CSV files with units in their header."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np

from pymdr.errors import CaseError, FileError, UnitError
from pymdr.problem.profiles import Sampled
from pymdr.problem.profiles.sampled import Interpolation
from pymdr.units import FloatArray, to_si

_COLUMN = re.compile(r"\s*(?P<name>[^\[\]()]*?)\s*[\[(]\s*(?P<unit>[^\[\]()]+?)\s*[\])]\s*")
_NAMES = {
    "radius": ("r", "radius", "radial distance"),
    "height": ("f", "height", "gap", "z"),
    "scatter": ("scatter", "std", "sd", "sigma", "standard deviation"),
}
_LARGEST = 200 * 2**20


def read_columns(file: str | os.PathLike[str]) -> dict[str, FloatArray]:
    """
    Radius, height and scatter in m from a CSV file.

    The first line that is no comment (``#``) is the header; every length column names its unit in brackets,
    as in ``r [nm], f [nm], scatter [nm]``. Other columns are left alone.

    Parameters
    ----------
    file : path

    Returns
    -------
    dict of str to ndarray
        ``radius``, ``height`` and, where there is one, ``scatter``.

    Raises
    ------
    FileError
        If the file cannot be read.
    CaseError
        If the header has no units or columns are missing, or a row is not numbers.
    """
    source = Path(file)
    try:
        if source.stat().st_size > _LARGEST:
            raise CaseError(f"{source}: larger than {_LARGEST} bytes; thin the samples out")
        lines = source.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise FileError(f"cannot read {source}: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise CaseError(f"{source}: not a text file in UTF-8") from error
    numbered = [
        (i + 1, line) for i, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(numbered) < 2:
        raise CaseError(f"{source}: no table; write a header such as 'r [nm], f [nm]' and rows of numbers")
    header = numbered[0][1].split(",")
    columns = {}
    for quantity, names in _NAMES.items():
        found = [i for i, title in enumerate(header) if _title(title)[0] in names]
        if len(found) > 1:
            raise CaseError(
                f"{source}: {len(found)} columns of {quantity} in the header {numbered[0][1]!r}; keep one"
            )
        if found:
            columns[quantity] = _column(
                source, quantity, header[found[0]], found[0], len(header), numbered[1:]
            )
        elif quantity != "scatter":
            raise CaseError(
                f"{source}: no column of {quantity} in the header {numbered[0][1]!r}; name one "
                f"{names[0]!r} with its unit, for example '{names[0]} [nm]'"
            )
    return columns


def _title(title: str) -> tuple[str, str | None]:
    match = _COLUMN.fullmatch(title)
    return (match["name"].lower(), match["unit"]) if match else (title.strip().lower(), None)


def _column(
    source: Path, quantity: str, title: str, index: int, width: int, rows: list[tuple[int, str]]
) -> FloatArray:
    unit = _title(title)[1]
    if unit is None:
        raise CaseError(
            f"{source}: column {title.strip()!r} has no unit; write for example '{title.strip()} [nm]'"
        )
    try:
        factor = to_si(f"1 {unit}", "m", name=f"unit of column {title.strip()!r}")
    except UnitError as error:
        raise CaseError(f"{source}: {error}") from error
    values = np.empty(len(rows))
    for i, (line, row) in enumerate(rows):
        cells = row.split(",")
        if len(cells) != width:
            raise CaseError(f"{source}, line {line}: {len(cells)} entries for {width} columns of the header")
        try:
            values[i] = float(cells[index])
        except ValueError as error:
            raise CaseError(
                f"{source}, line {line}: {quantity} = {cells[index].strip()!r} is not a number"
            ) from error
        if not np.isfinite(values[i]):
            raise CaseError(
                f"{source}, line {line}: {quantity} = {cells[index].strip()!r}; every entry must be a finite "
                "number: delete rows without data"
            )
    inverse = 1.0 / factor
    return values / float(f"{inverse:.15g}") if factor < 1.0 else values * factor


def read_profile(file: str | os.PathLike[str], *, interpolation: Interpolation | None = None) -> Sampled:
    """
    Read a sampled profile from a CSV file with units in its header.

    Parameters
    ----------
    file : path
        With the columns r, f and optionally scatter, each with its unit: ``r [nm], f [nm], scatter [nm]``.
    interpolation : CubicSpline, ShapePreserving or SmoothingSpline, optional
        How a curve is run through the samples. Unless given, it is a smoothing spline where the file has a
        scatter, and a cubic spline with a round tip otherwise.

    Returns
    -------
    Sampled

    Raises
    ------
    FileError, CaseError, ProblemError
        If the file cannot be read, is not such a table, or the samples are not a profile.
    """
    columns = read_columns(file)
    return Sampled(**columns, interpolation=interpolation)
