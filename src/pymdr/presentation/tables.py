"""Tables for people: CSV files and spreadsheets with units in their headers, and what their numbers rest on."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pymdr.errors import FileError, MissingExtraError
from pymdr.interpretation.validity import Assumption, Claim, Level
from pymdr.presentation.files import named_file, write_whole
from pymdr.presentation.text import largest_error
from pymdr.problem.contact import Contact

if TYPE_CHECKING:
    from openpyxl import Workbook
    from openpyxl.worksheet.worksheet import Worksheet

About = Sequence[tuple[str, str, str]]
"""Rows of what is said of a table: kind, name, words."""

_LONGEST = 300
"""Characters of a part of a contact: arrays are not written out."""
_MOST_ROWS, _MOST_COLUMNS = 2**20 - 1, 2**14
"""That a sheet has below its header, and beside one another."""
_WIDEST = 100
_NO_TEXT = (".nc", ".h5", ".hdf5", ".zarr", ".npy", ".npz")
_UNPRINTABLE = dict.fromkeys((*range(32), *range(127, 160), 0x2028, 0x2029), " ")
"""What would end a line, or is no character of a sheet."""


def about_rows(
    contact: Contact | None,
    claims: Mapping[str, Claim],
    assumptions: Iterable[Assumption] = (),
    notes: Iterable[str] = (),
    sources: Iterable[str] = (),
    others: Mapping[str, str] | None = None,
) -> list[tuple[str, str, str]]:
    """
    What the numbers of a table rest on.

    Parameters
    ----------
    contact : Contact or None
    claims : mapping of str to Claim
        By quantity.
    assumptions, notes, sources : iterable
        Those of the answer; `sources` are references written out.
    others : mapping of str to str, optional
        What else is said, by kind.

    Returns
    -------
    list of tuple of str
        Kind, name, words.
    """
    rows = [("version", "", f"pymdr {version('pymdr')}")]
    if contact is not None:
        rows += [
            (part, "", part_in_words(value))
            for part in ("profile", "body", "counterbody", "adhesion", "friction")
            if (value := getattr(contact, part)) is not None
        ]
    rows += [(kind, "", words) for kind, words in (others or {}).items()]
    for name, claim in claims.items():
        held = f"holds in {int(claim.where.sum())} of {claim.where.size}"
        rows.append(("claim", name, f"{claim.level.name}: {claim.reason} [{claim.source}]; {held}"))
        error = largest_error(claim)
        if claim.readable:
            words = "not known" if error is None else f"relative errors of up to {error:.1e}"
            rows.append(("error", name, words))
    rows += [
        (
            "assumption",
            a.name,
            f"{a.words} is {a.measure:.3g}, limit {a.limit:g}{'' if a.met else ', NOT MET'}",
        )
        for a in assumptions
    ]
    rows += [("note", "", note) for note in notes]
    return rows + [("cite", "", source) for source in sources]


def part_in_words(value: object) -> str:
    """A part of a contact on one line, cut where it holds long arrays."""
    text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def with_error_columns(
    columns: Mapping[str, np.ndarray], claims: Mapping[str, Claim]
) -> dict[str, np.ndarray]:
    """
    Columns with the relative errors of what is approximate beside them, nan where an error is not known.

    Parameters
    ----------
    columns : mapping of str to ndarray
        By title, a quantity with its unit in brackets.
    claims : mapping of str to Claim
        By quantity. One that is exact errs by at most 1e-9, and has no column of errors; one with fewer entries than there are
        rows holds for runs of equally many.

    Returns
    -------
    dict of str to ndarray

    Examples
    --------
    >>> from pymdr.interpretation.validity import Level
    >>> claim = Claim(Level.APPROXIMATE, "", "", np.array([True]), np.array([0.1]))
    >>> list(with_error_columns({"normal_force [N]": np.ones(1)}, {"normal_force": claim}))
    ['normal_force [N]', 'normal_force_error']
    """
    written: dict[str, np.ndarray] = {}
    for title, values in columns.items():
        written[title] = values
        name = title.partition(" [")[0]
        claim = claims.get(name)
        if claim is None or claim.level is not Level.APPROXIMATE or values.size % max(claim.where.size, 1):
            continue
        error = np.full(claim.where.shape, np.nan) if claim.error is None else claim.error
        each = np.where(claim.where, error, np.nan)
        written[f"{name}_error"] = np.repeat(each, values.size // claim.where.size)
    return written


def write_csv(columns: Mapping[str, np.ndarray], file: str | os.PathLike[str], about: About = ()) -> None:
    """
    Write columns as CSV, whole or not at all; numbers that are nan are empty.

    Parameters
    ----------
    columns : mapping of str to ndarray
        By title.
    file : path
    about : sequence
        What stands above the header, in lines that begin with ``#``.

    Raises
    ------
    FileError
        If the file cannot be written, or is named as a spreadsheet or a file of arrays.
    """
    import pandas as pd

    suffix = named_file(file, "write").suffix.lower()
    if suffix == ".xlsx":
        raise FileError(
            f"cannot write {str(file)!r}: to_csv writes text; a spreadsheet is written by to_xlsx"
        )
    if suffix in _NO_TEXT:
        raise FileError(
            f"cannot write {str(file)!r}: to_csv writes text, and files that end with {suffix!r} hold arrays; name it 'table.csv'"
        )
    table = pd.DataFrame(dict(columns))

    def write(beside: Path) -> None:
        with beside.open("w", encoding="utf-8", newline="") as opened:
            opened.writelines(f"# {line.translate(_UNPRINTABLE)}\n" for line in about_lines(about))
            table.to_csv(opened, index=False, lineterminator=os.linesep)

    write_whole(file, write)


def about_lines(about: About) -> list[str]:
    """
    The same in lines, quantities of which the same is said together.

    Examples
    --------
    >>> about_lines([("claim", "normal_force", "exact"), ("claim", "contact_radius", "exact"), ("note", "", "odd")])
    ['claim of normal_force, contact_radius: exact', 'note: odd']
    """
    names: dict[tuple[str, str], list[str]] = {}
    for kind, name, words in about:
        names.setdefault((kind, words), []).extend([name] if name else [])
    return [
        f"{kind} of {', '.join(some)}: {words}" if some else f"{kind}: {words}"
        for (kind, words), some in names.items()
    ]


def write_xlsx(columns: Mapping[str, np.ndarray], about: About, file: str | os.PathLike[str]) -> None:
    """
    Write columns as a spreadsheet, whole or not at all; what their numbers rest on is its second sheet.

    Parameters
    ----------
    columns : mapping of str to ndarray
        By title.
    about : sequence
        Kind, name and words.
    file : path
        With a name that ends with ``.xlsx``.

    Raises
    ------
    MissingExtraError
        Without openpyxl.
    FileError
        If the file cannot be written, its name is that of another format, or a sheet has no room for the table.
    """
    if named_file(file, "write").suffix.lower() != ".xlsx":
        raise FileError(
            f"cannot write {str(file)!r}: to_xlsx needs a name that ends with '.xlsx', such as 'ball.xlsx'"
        )
    rows = max((len(column) for column in columns.values()), default=0)
    if rows > _MOST_ROWS or len(columns) > _MOST_COLUMNS:
        raise FileError(
            f"cannot write {str(file)!r}: {rows} rows and {len(columns)} columns, and a sheet has room for {_MOST_ROWS} and "
            f"{_MOST_COLUMNS}; write to_csv, or fewer steps"
        )
    book = new_book()
    table = book.active
    table.title = "table"
    _fill(
        table, list(columns), zip(*(np.asarray(column).tolist() for column in columns.values()), strict=True)
    )
    _fill(book.create_sheet("about"), ["kind", "name", "words"], about)
    write_whole(file, book.save)


def new_book() -> Workbook:
    """
    An empty spreadsheet, for those too who ask early whether one can be written.

    Raises
    ------
    MissingExtraError
        Without openpyxl.
    """
    try:
        from openpyxl import Workbook
    except ImportError as error:
        raise MissingExtraError(
            f"a spreadsheet needs openpyxl, which cannot be imported ({error}): pip install 'pymdr[xlsx]'; tables as CSV are written "
            "without it"
        ) from error
    return Workbook()


def _fill(sheet: Worksheet, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    from openpyxl.styles import Font

    widths = [len(title) for title in head]
    for i, row in enumerate((head, *rows), start=1):
        for j, value in enumerate(row, start=1):
            if isinstance(value, str):
                # a text that begins like a formula stays a text
                cell = sheet.cell(i, j)
                cell.value = value.translate(_UNPRINTABLE)
                cell.data_type = "s"
                widths[j - 1] = max(widths[j - 1], len(value))
            elif math.isinf(value):
                sheet.cell(i, j, str(value))
            elif not math.isnan(value):
                sheet.cell(i, j, value)
    for j, width in enumerate(widths, start=1):
        cell = sheet.cell(1, j)
        cell.font = Font(bold=True)
        sheet.column_dimensions[cell.column_letter].width = min(max(width + 2, 12), _WIDEST)
    sheet.freeze_panes = "A2"
