"""CSV files and spreadsheets with units in their headers, and the claims behind their numbers."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pymdr.deferred import pd
from pymdr.errors import FileError, MissingExtraError
from pymdr.interpretation.validity import Assumption, Claim, Level
from pymdr.presentation.files import named_file, write_atomically
from pymdr.presentation.text import assumption_text, largest_error
from pymdr.problem.contact import Contact
from pymdr.quantities import of_whole
from pymdr.version import __version__

if TYPE_CHECKING:
    from openpyxl import Workbook
    from openpyxl.worksheet.worksheet import Worksheet

About = Sequence[tuple[str, str, str]]
"""Rows about a table: kind, name, text."""

_LONGEST = 300
"""Characters of the text of a part of a contact: long arrays are cut."""
_MOST_ROWS, _MOST_COLUMNS = 2**20 - 1, 2**14
"""Largest sheet: rows below the header, and columns."""
_WIDEST = 100
_NO_TEXT = (".nc", ".h5", ".hdf5", ".zarr", ".npy", ".npz")
_UNPRINTABLE = dict.fromkeys((*range(32), *range(127, 160), 0x2028, 0x2029), " ")
"""Characters that end a line or are not allowed in a sheet."""


def about_rows(
    contact: Contact | None,
    claims: Mapping[str, Claim],
    assumptions: Iterable[Assumption] = (),
    notes: Iterable[str] = (),
    sources: Iterable[str] = (),
    others: Mapping[str, str] | None = None,
) -> list[tuple[str, str, str]]:
    """
    Rows about a table: contact, claims, errors, assumptions, notes and sources.

    Parameters
    ----------
    assumptions, notes, sources : iterable
        Those of the result; `sources` are full references.
    others : mapping of str to str, optional
        Further rows: text by kind.

    Returns
    -------
    list of tuple of str
        Kind, name, text.
    """
    rows = [("version", "", f"pymdr {__version__}")]
    if contact is not None:
        rows += [
            (part, "", part_text(value))
            for part in ("profile", "body", "counterbody", "adhesion", "friction")
            if (value := getattr(contact, part)) is not None
        ]
    rows += [(kind, "", text) for kind, text in (others or {}).items()]
    for name, claim in claims.items():
        steps = f"holds in {int(claim.where.sum())} of {claim.where.size}"
        rows.append(("claim", name, f"{claim.level.name}: {claim.reason} [{claim.source}]; {steps}"))
        error = largest_error(claim)
        if claim.readable:
            size = "not known" if error is None else f"relative errors of up to {error:.1e}"
            size += f" outside {claim.excluded}" if claim.excluded else ""
            rows.append(("error", name, size))
    rows += [("assumption", a.name, assumption_text(a)) for a in assumptions]
    rows += [("note", "", note) for note in notes]
    return rows + [("cite", "", source) for source in sources]


def part_text(value: object) -> str:
    """A part of a contact on one line, cut after 300 characters."""
    text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def with_error_columns(
    columns: Mapping[str, np.ndarray], claims: Mapping[str, Claim]
) -> dict[str, np.ndarray]:
    """
    Columns, each approximate one followed by its relative errors (nan where not known).

    Parameters
    ----------
    columns : mapping of str to ndarray
        By title, a quantity with its unit in brackets.
    claims : mapping of str to Claim
        By quantity. Exact quantities (error below 1e-9) have no column of errors. A claim with fewer entries than there are
        rows applies to equal blocks of rows.

    Examples
    --------
    >>> from pymdr.interpretation.validity import Level
    >>> claim = Claim(Level.APPROXIMATE, "", "", np.array([True]), np.array([0.1]))
    >>> list(with_error_columns({"normal_force [N]": np.ones(1)}, {"normal_force": claim}))
    ['normal_force [N]', 'normal_force_error']
    """
    extended: dict[str, np.ndarray] = {}
    for title, values in columns.items():
        extended[title] = values
        name = title.partition(" [")[0]
        claim = claims.get(of_whole(name))
        if claim is None or claim.level is not Level.APPROXIMATE or values.size % max(claim.where.size, 1):
            continue
        error = np.full(claim.where.shape, np.nan) if claim.error is None else claim.error
        valid = np.where(claim.where, error, np.nan)
        extended[f"{name}_error"] = np.repeat(valid, values.size // claim.where.size)
    return extended


def write_csv(columns: Mapping[str, np.ndarray], file: str | os.PathLike[str], about: About = ()) -> None:
    """
    Write columns as CSV atomically; nan is written as an empty cell.

    Parameters
    ----------
    about : sequence
        Rows written above the header, in lines that begin with ``#``.
    """
    suffix = named_file(file, "write").suffix.lower()
    if suffix == ".xlsx":
        raise FileError(f"cannot write {str(file)!r}: to_csv writes text; use to_xlsx for a spreadsheet")
    if suffix in _NO_TEXT:
        raise FileError(
            f"cannot write {str(file)!r}: to_csv writes text, and {suffix!r} is a suffix of array files; use a name such as 'table.csv'"
        )
    table = pd.DataFrame(dict(columns))

    def write(temporary: Path) -> None:
        with temporary.open("w", encoding="utf-8", newline="") as opened:
            opened.writelines(f"# {line.translate(_UNPRINTABLE)}\n" for line in about_lines(about))
            table.to_csv(opened, index=False, lineterminator=os.linesep)

    write_atomically(file, write)


def about_lines(about: About) -> list[str]:
    """
    Rows about a table as lines; quantities with the same text share a line.

    Examples
    --------
    >>> about_lines([("claim", "normal_force", "exact"), ("claim", "contact_radius", "exact"), ("note", "", "odd")])
    ['claim of normal_force, contact_radius: exact', 'note: odd']
    """
    names: dict[tuple[str, str], list[str]] = {}
    for kind, name, text in about:
        names.setdefault((kind, text), []).extend([name] if name else [])
    return [
        f"{kind} of {', '.join(shared)}: {text}" if shared else f"{kind}: {text}"
        for (kind, text), shared in names.items()
    ]


def write_xlsx(columns: Mapping[str, np.ndarray], about: About, file: str | os.PathLike[str]) -> None:
    """
    Write columns as a spreadsheet atomically, with the rows about them on a second sheet.

    Parameters
    ----------
    about : sequence
        Kind, name and text.
    file : path
        With a name that ends with ``.xlsx``.

    Raises
    ------
    MissingExtraError
        Without openpyxl.
    FileError
        If the file cannot be written, its suffix is not ``.xlsx``, or the table is larger than a sheet.
    """
    if named_file(file, "write").suffix.lower() != ".xlsx":
        raise FileError(
            f"cannot write {str(file)!r}: to_xlsx needs a name that ends with '.xlsx', such as 'ball.xlsx'"
        )
    rows = max((len(column) for column in columns.values()), default=0)
    if rows > _MOST_ROWS or len(columns) > _MOST_COLUMNS:
        raise FileError(
            f"cannot write {str(file)!r}: the table has {rows} rows and {len(columns)} columns (limit of a sheet: {_MOST_ROWS} and "
            f"{_MOST_COLUMNS}); use to_csv or fewer steps"
        )
    book = new_book()
    table = book.active
    table.title = "table"
    _fill(
        table, list(columns), zip(*(np.asarray(column).tolist() for column in columns.values()), strict=True)
    )
    _fill(book.create_sheet("about"), ["kind", "name", "text"], about)
    write_atomically(file, book.save)


def new_book() -> Workbook:
    """An empty spreadsheet; also called early to check that openpyxl is installed."""
    try:
        from openpyxl import Workbook
    except ImportError as error:
        raise MissingExtraError(
            f"spreadsheets need openpyxl, which cannot be imported ({error}); install it with pip install 'pymdr[xlsx]', or "
            "write CSV"
        ) from error
    return Workbook()


def _fill(sheet: Worksheet, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    from openpyxl.styles import Font

    widths = [len(title) for title in header]
    for i, row in enumerate((header, *rows), start=1):
        for j, value in enumerate(row, start=1):
            if isinstance(value, str):
                # text that begins like a formula stays text
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
