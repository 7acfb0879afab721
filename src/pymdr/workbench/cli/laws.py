"""``pymdr law`` and ``table``: what other programs read."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pymdr.workbench.cli.folders import Tables, named_after, ready_folder, write_figure
from pymdr.workbench.cli.options import CaseFile, Json, Quiet
from pymdr.workbench.cli.telling import (
    answer,
    columns_of,
    failures_as_json,
    print_json,
    say_found,
    tell_written,
    validity_of,
)


def law(
    case: CaseFile,
    to: Annotated[
        str | None,
        typer.Option(help="Largest indentation, such as '1 um'; the deepest of the path unless given."),
    ] = None,
    tolerance: Annotated[float, typer.Option(help="Largest relative error, 1e-7 to 1e-2.")] = 1e-6,
    name: Annotated[
        str | None,
        typer.Option(
            help="What the files and the names in the header begin with; that of the case unless given."
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="DIR", help="Folder for what is written; CASE unless given."),
    ] = None,
    xlsx: Annotated[bool, typer.Option("--xlsx", help="Write the table as a spreadsheet too.")] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """The law of force, stiffness and radius over the indentation: a table, a C header and a figure."""
    from pymdr.workbench.laws import law_of_case, name_for, write_law

    with failures_as_json("law", case, as_json):
        Tables(csv=True, xlsx=xlsx).check()
        called = name_for(case, name)
        with ready_folder(output or named_after(case)) as folder:
            title, found = law_of_case(case, to, tolerance)
            written = write_law(found, folder, called, xlsx)
            written.append(write_figure(found.plot(), folder / f"{called}.png"))
    if as_json:
        told = answer(
            "law",
            case,
            written,
            title=title,
            status="COMPLETED",
            rows=found.table.knots.u.size,
            study=columns_of(found),
            references=list(found.cite()),
            **validity_of(found),
        )
        print_json(told)
    elif not quiet:
        say_found(title or str(case), found.summary(), written)


def table(
    result_file: Annotated[
        Path, typer.Argument(metavar="RESULT", help="A file written by pymdr run, or its folder.")
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FILE", help="The table, a .csv or an .xlsx.")
    ],
    quantity: Annotated[
        list[str] | None,
        typer.Option(help="What is written, such as normal_force; everything stored unless given."),
    ] = None,
    unit: Annotated[
        list[str] | None,
        typer.Option(help="Units other than SI, such as indentation=um, once for each quantity."),
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Write a saved result as a table, with what its numbers rest on."""
    from pymdr.solving.reopening import open_result
    from pymdr.workbench.laws import named_units, write_result

    with failures_as_json("table", result_file, as_json):
        units = named_units(unit or [])
        file = result_file / "result.nc" if result_file.is_dir() else result_file
        result = open_result(file)
        write_result(result, output, quantity, units)
    tell_written("table", result_file, result, [output], quiet, as_json)
