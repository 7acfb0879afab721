"""Sheets of spreadsheets as lines of text, with tabs between their cells."""

from __future__ import annotations

import io
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from pymdr.errors import CaseError, MissingExtraError
from pymdr.workbench.inputs import read_filled

SPREADSHEETS = (".xlsx", ".xlsm", ".xls")
_ZIP = b"PK"
"""First bytes of an .xlsx file, whatever its name."""
_NO_NUMBER = 1e300
"""Instruments write the largest float where they have no number."""


def read_sheets(source: Path, largest: int) -> dict[str, list[str]]:
    """
    The rows of all sheets of a spreadsheet.

    Parameters
    ----------
    source : Path
        A file .xlsx or .xlsm (the extra ``xlsx``), or .xls (the extra ``xls``).

    Returns
    -------
    dict of str to list of str
        Name of the sheet -> its rows, without empty ones at the end. Values are those of the last calculation.
    """
    content = read_filled(source, largest, "spreadsheet")
    is_old = source.suffix.lower() == ".xls" and not content.startswith(_ZIP)
    sheets = _old(source, content) if is_old else _new(source, content)
    return {name: _lines(rows) for name, rows in sheets.items()}


def _new(source: Path, content: bytes) -> dict[str, list[Sequence[Any]]]:
    """The sheets of an .xlsx file."""
    try:
        from openpyxl import load_workbook
    except ImportError as error:
        raise MissingExtraError(
            f"{source.name} is a spreadsheet, which needs openpyxl ({error}): pip install 'pymdr[xlsx]'; tables as text (.csv) need none"
        ) from error
    try:
        book = load_workbook(io.BytesIO(content), read_only=True, data_only=True)
        return {sheet.title: list(sheet.iter_rows(values_only=True)) for sheet in book.worksheets}
    except Exception as error:  # openpyxl has no error of its own for damaged files
        raise _damaged(source, error) from error


def _old(source: Path, content: bytes) -> dict[str, list[Sequence[Any]]]:
    """The sheets of an .xls file."""
    try:
        import xlrd
    except ImportError as error:
        raise MissingExtraError(
            f"{source.name} is a spreadsheet of Excel 97 to 2003, which needs xlrd ({error}): pip install 'pymdr[xls]'; or save it as .xlsx or "
            "text (.csv)"
        ) from error
    try:
        with xlrd.open_workbook(file_contents=content, logfile=io.StringIO(), on_demand=True) as book:
            return {sheet.name: [list(map(_old_cell, row)) for row in sheet.get_rows()] for sheet in book}
    except Exception as error:  # damaged files raise errors of all kinds
        raise _damaged(source, error) from error


def _old_cell(cell: Any) -> Any:
    """The value of a cell of an .xls file; errors of its formulas, which are codes there, are no numbers."""
    from xlrd.biffh import XL_CELL_ERROR

    return None if cell.ctype == XL_CELL_ERROR else cell.value


def _damaged(source: Path, error: Exception) -> CaseError:
    return CaseError(
        f"{source}: no spreadsheet, or it is damaged or encrypted ({type(error).__name__}); save it again, or as text (.csv)"
    )


def _lines(rows: Iterable[Sequence[Any]]) -> list[str]:
    lines = ["\t".join(map(_text, row)) for row in rows]
    while lines and not lines[-1].strip():
        lines.pop()
    return lines


def _text(cell: Any) -> str:
    if cell is None:
        return ""
    if isinstance(cell, bool | int | float):
        number = float(cell)
        return repr(number) if math.isfinite(number) and abs(number) < _NO_NUMBER else "nan"
    return " ".join(str(cell).split())
