"""Folders of force curves, and tables of the samples that they belong to."""

from __future__ import annotations

import csv
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypedDict, Unpack

from pymdr.errors import CaseError, FileError, PymdrError
from pymdr.presentation.files import named_file
from pymdr.problem.options import with_options
from pymdr.solving.curves import MeasuredCurve
from pymdr.units import QuantityLike
from pymdr.workbench.curves import read_curves, read_fittable_curves
from pymdr.workbench.inputs import read_measured_text

_LARGEST, _MOST_FILES = 50 * 2**20, 10_000
_ZARR = ("zarr.json", ".zgroup", ".zmetadata", ".zattrs")


class CurveOptions(TypedDict, total=False):
    """Options of :func:`read_prepared_curves` that apply to every file."""

    spring_constant: QuantityLike | None
    sensitivity: QuantityLike | None
    leave_out_missing: bool
    keep_signs: bool | None


@dataclass(frozen=True)
class CurveFolder:
    """The force curves of a folder, as :func:`fit_each` takes them."""

    curves: Mapping[str, MeasuredCurve]
    """By file, relative to the folder; with the number of the record if the file has several."""
    groups: Mapping[str, str]
    """The group of each curve: that of the table, or the subfolder."""
    excluded: Mapping[str, str] = field(default_factory=dict)
    """Files that are not read, with the reason."""


def is_zarr(folder: Path) -> bool:
    """Whether a folder is a Zarr store."""
    return any((folder / name).exists() for name in _ZARR)


@with_options(CurveOptions, read_curves)
def read_curve_folder(
    folder: str | os.PathLike[str],
    *,
    groups: str | os.PathLike[str] | None = None,
    segment: str | None = None,
    whole: bool = False,
    **options: Unpack[CurveOptions],
) -> CurveFolder:
    r"""
    Read the force curves of a folder and of its subfolders.

    Parameters
    ----------
    folder : path
        Every file in it is read, except hidden ones and the table of groups.
    groups : path, optional
        A table of two columns with a header, such as ``file, sample``: a file, relative to the folder or by its name, and its group. By default the
        group is the subfolder that contains the file.
    segment, whole : optional
        Part of each record, ``"approach"``, ``"retreat"`` or ``"record"``; by default the record of a table, and of a file of an instrument the
        approach, or with `whole` the record.
    **options
        Of :func:`read_prepared_curves`: `spring_constant`, `sensitivity`, `leave_out_missing`, `keep_signs`.

    Returns
    -------
    CurveFolder
        Curves and their groups by file name, and the files that cannot be read, with the reason.

    Raises
    ------
    FileError
        If the folder cannot be read or has no files.
    CaseError
        If the table of groups has no two columns, names a file twice or one that is not in the folder.

    See Also
    --------
    fit_each : fits all of them.

    Examples
    --------
    >>> import pymdr as mdr
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as name:
    ...     (Path(name) / "gel").mkdir()
    ...     rows = [f"{i * i}, {10 * i}" for i in range(9)]
    ...     _ = (Path(name) / "gel" / "1.csv").write_text("\n".join(["load [nN], indentation [nm]", *rows]))
    ...     result = mdr.read_curve_folder(name)
    >>> list(result.curves), result.groups
    (['gel/1.csv'], {'gel/1.csv': 'gel'})
    """
    root = named_file(folder, "read")
    table = None if groups is None else named_file(groups, "read")
    files = _files(root, table)
    known = None if table is None else _groups(table, files)
    curves: dict[str, MeasuredCurve] = {}
    of_group: dict[str, str] = {}
    excluded: dict[str, str] = {}
    for name, file in files.items():
        group = (
            (Path(name).parent.as_posix() if "/" in name else root.name) if known is None else known.get(name)
        )
        of_group[name] = group or ""
        if group is None:
            excluded[name] = f"it is not in {table}"
            continue
        try:
            read = read_fittable_curves(file, segment, whole=whole, **options)
        except PymdrError as error:
            excluded[name] = str(error).removeprefix(f"{file}: ").removeprefix(f"{file} is ")
            continue
        several = len(read) > 1
        for i, curve in enumerate(read, 1):
            one = f"{name} #{i}" if several else name
            curves[one], of_group[one] = curve, group
    return CurveFolder(curves, of_group, excluded)


def _files(root: Path, table: Path | None) -> dict[str, Path]:
    """Files by their names relative to the folder, in order."""
    if not root.is_dir():
        raise FileError(f"cannot read {root}: it is not a folder; give the folder of the curves")
    by_name = {}
    for parent, folders, files in os.walk(root):
        folders[:] = sorted(
            name for name in folders if not name.startswith(".") and not is_zarr(Path(parent, name))
        )
        for name in sorted(files):
            file = Path(parent, name)
            if not name.startswith(".") and (table is None or not table.exists() or not file.samefile(table)):
                by_name[file.relative_to(root).as_posix()] = file
        if len(by_name) > _MOST_FILES:
            raise FileError(f"{root}: more than {_MOST_FILES} files; fit large sets of curves as a map")
    if not by_name:
        raise FileError(f"{root}: the folder has no files; put the force curves into it")
    return by_name


def _groups(table: Path, files: Mapping[str, Path]) -> dict[str, str]:
    """The group of each file in the table."""
    text = read_measured_text(table, _LARGEST, "table of groups")
    lines = [line for line in text.splitlines() if line.strip()]
    delimiter = next((mark for mark in "\t;," if lines and mark in lines[0]), ",")
    rows = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=delimiter)]
    short = next((row for row in rows if len(row) < 2 or not row[0] or not row[1]), None)
    if len(rows) < 2 or short is not None:
        what = "it has no rows" if short is None else f"the row {', '.join(short)!r} has no group"
        raise CaseError(f"{table}: {what}; a header and two columns are needed, such as 'file, sample'")
    names = {Path(name).name: name for name in files}
    groups: dict[str, str] = {}
    for row in rows[1:]:
        name = row[0] if row[0] in files else names.get(row[0])
        if name is None:
            raise CaseError(
                f"{table}: {row[0]!r} is not in the folder, which has {len(files)} files; correct the name"
            )
        if name in groups:
            raise CaseError(
                f"{table}: {row[0]!r} is given twice; give each file once, with its folder if names repeat"
            )
        groups[name] = row[1]
    return groups
