"""``pymdr fit``: parameters of a contact found in measured curves."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pymdr.workbench.cli.folders import write_found
from pymdr.workbench.cli.options import CaseFile, Json, Quiet, Table
from pymdr.workbench.cli.telling import answer, failures_as_json, print_json, say_found, validity_of


def fit(
    case: CaseFile,
    curve: Annotated[
        list[Path],
        typer.Argument(metavar="CURVE.csv...", help="Force and travel or indentation, with units."),
    ],
    free: Annotated[list[str], typer.Option(help="What is looked for, such as body.young; one or several.")],
    spring_constant: Annotated[
        str | None, typer.Option(help="Of the machine, where travel was measured, such as '0.1 N/m'.")
    ] = None,
    contact_point: Annotated[
        str | None,
        typer.Option(help="Depth of the record at which the bodies touch; looked for unless given."),
    ] = None,
    baseline: Annotated[
        str | None, typer.Option(help="Force of the record when they do not; looked for unless given.")
    ] = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Find parameters of the contact of a case in measured force curves; with -o a table and a figure are written."""
    from pymdr.solving.fits import fit as find
    from pymdr.workbench.casefile import read_contact
    from pymdr.workbench.tables import read_curve

    with failures_as_json("fit", case, as_json):
        title, contact = read_contact(case)
        curves = [read_curve(file, spring_constant=spring_constant) for file in curve]
        found = find(contact, curves, free, contact_point=contact_point, baseline=baseline)
        written = write_found(found, output, "fit")
    if as_json:
        values = {
            name: {"value": one.value, "error": one.error, "low": one.low, "high": one.high, "unit": one.unit}
            for name, one in found.values.items()
        }
        told = answer(
            "fit",
            case,
            written,
            title=title,
            status="COMPLETED",
            rows=found.data.sizes["step"],
            fit={"values": values, "noise": found.noise, "correlated": found.correlated, "aicc": found.aicc},
            **validity_of(found),
        )
        print_json(told)
    elif not quiet:
        say_found(title or str(case), found.summary(), written)
