"""``pymdr law`` and ``table``: output for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from pymdr.workbench.cli.folders import Tables, named_after, ready_folder, write_figure
from pymdr.workbench.cli.options import CaseFile, Json, Quiet
from pymdr.workbench.cli.reporting import columns_of, failures_as_json, report_answer, report_written


def law(
    case: CaseFile,
    to: Annotated[
        str | None,
        typer.Option(help="Largest indentation, such as '1 um'; by default the deepest of the path."),
    ] = None,
    tolerance: Annotated[float, typer.Option(help="Largest relative error, 1e-7 to 1e-2.")] = 1e-6,
    tangential: Annotated[
        bool, typer.Option("--tangential", help="Friction along a line in the C header, with its memory.")
    ] = False,
    springs: Annotated[
        int | None,
        typer.Option(
            help="Number of springs for bodies with memory, or with --tangential for friction in the plane."
        ),
    ] = None,
    name: Annotated[
        str | None, typer.Option(help="Prefix of files and C names; by default the name of the case.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Output folder; by default CASE.")
    ] = None,
    xlsx: Annotated[bool, typer.Option("--xlsx", help="Write the table as a spreadsheet too.")] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Write the force law of a case as a table and a C header."""
    from pymdr.workbench.laws import law_of_case, name_for, write_law

    with failures_as_json("law", case, as_json):
        Tables(csv=True, xlsx=xlsx).check()
        prefix = name_for(case, name)
        with ready_folder(output or named_after(case)) as folder:
            title, exported = law_of_case(case, to, tolerance, tangential, springs)
            written = write_law(exported, folder, prefix, xlsx)
            written.append(write_figure(exported.plot(), folder / f"{prefix}.png"))

    def own() -> dict[str, Any]:
        rows = exported.table.knots.u.size
        return {"rows": rows, "study": columns_of(exported), "references": list(exported.cite())}

    report_answer("law", case, title, exported, written, quiet, as_json, own)


def table(
    result_file: Annotated[
        Path, typer.Argument(metavar="RESULT", help="Result file of pymdr run, or its folder.")
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FILE", help="Table to write (.csv or .xlsx).")
    ],
    quantity: Annotated[
        list[str] | None, typer.Option(help="Quantity to write, such as normal_force; by default all.")
    ] = None,
    unit: Annotated[
        list[str] | None, typer.Option(help="Unit other than SI, such as indentation=um; repeatable.")
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Write a saved result as a table with its claims."""
    from pymdr.solving.reopening import open_result
    from pymdr.workbench.laws import named_units, write_result

    with failures_as_json("table", result_file, as_json):
        units = named_units(unit or [])
        result = open_result(result_file)
        write_result(result, output, quantity, units)
    report_written("table", result_file, result, [output], quiet, as_json)
