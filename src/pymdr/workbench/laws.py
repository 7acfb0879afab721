"""Exported laws of cases, and tables of saved results."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from pymdr.errors import CaseError, FileError, QuantityError
from pymdr.presentation.header import identifier
from pymdr.result import Result
from pymdr.solving.assessing import assess
from pymdr.solving.exporting import ContactLaw, check_lawful, export_law
from pymdr.units import shown
from pymdr.workbench.casefile import read_case, read_contact, read_tables


def law_of_case(
    case: Path, to: str | None, tolerance: float, tangential: bool = False, springs: int | None = None
) -> tuple[str, ContactLaw]:
    """
    The title of a case and the law of its contact.

    Parameters
    ----------
    case : path
        The path in it may be left out where `to` is given.
    to : str or None
        The largest indentation; the deepest of the path unless given.
    springs : int or None
        Number of springs with memory, or for friction in the plane.
    """
    if to is not None:
        title, contact = read_contact(case)
        return title, export_law(contact, to, tolerance=tolerance, tangential=tangential, springs=springs)
    if "path" not in read_tables(case):
        raise CaseError(
            f"{case}: without [[path]] the largest indentation is unknown; give --to, such as --to '1 um'"
        )
    request = read_case(case)
    check_lawful(request.contact, tolerance)
    deepest = assess(request.contact, request.path, **request.options).largest.get("indentation", 0.0)
    if not deepest > 0.0:
        raise CaseError(
            f"{case}: its path never presses the bodies together; give the largest indentation with --to '1 um'"
        )
    return request.title, export_law(
        request.contact, deepest, tolerance=tolerance, tangential=tangential, springs=springs
    )


def name_for(case: Path, name: str | None) -> str:
    """
    The name of a header: the given one, or the name of the case reduced to letters allowed in C.

    Examples
    --------
    >>> name_for(Path("cases/2-ball on glass.toml"), None)
    'law_2_ball_on_glass'
    """
    if name is not None:
        return identifier(name)
    plain = re.sub(r"[^A-Za-z0-9_]", "_", case.stem)[:36]
    return plain if re.match("[A-Za-z]", plain) else f"law_{plain}"


def write_law(law: ContactLaw, folder: Path, name: str, xlsx: bool) -> list[Path]:
    """Write the header and the table of a law; a name that is not an identifier of C is refused first."""
    file = folder / f"{name}.h"
    law.to_c(file, name=name)
    law.to_csv(folder / f"{name}.csv")
    written = [file, folder / f"{name}.csv"]
    if xlsx:
        law.to_xlsx(folder / f"{name}.xlsx")
        written.append(folder / f"{name}.xlsx")
    return written


def named_units(given: Sequence[str]) -> dict[str, str]:
    """
    Units by quantity.

    Examples
    --------
    >>> named_units(["indentation = um"])
    {'indentation': 'um'}
    """
    units = {}
    for one in given:
        name, sign, unit = (part.strip() for part in one.partition("="))
        if not (name and sign and unit):
            raise QuantityError(
                f"--unit {shown(one)}: a quantity with its unit is needed, such as indentation=um"
            )
        if name in units:
            raise QuantityError(f"--unit {shown(one)}: {name} has a unit already; give each quantity one")
        units[name] = unit
    return units


def write_result(
    result: Result, file: Path, quantities: Sequence[str] | None, units: Mapping[str, str]
) -> None:
    """Write a result as a table with its claims and assumptions; the suffix of the file selects the format."""
    if file.suffix.lower() == ".xlsx":
        result.to_xlsx(file, quantities=quantities or None, units=units)
    elif file.suffix.lower() == ".csv":
        result.to_csv(file, quantities=quantities or None, units=units, about=True)
    else:
        raise FileError(f"cannot write {file}: a table is a .csv or an .xlsx; name it with -o table.csv")
