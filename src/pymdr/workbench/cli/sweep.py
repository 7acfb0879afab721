"""``pymdr sweep``: a case over grids of its parameters."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pymdr.errors import ProblemError
from pymdr.workbench.cli.folders import Tables, ready_folder, write_figure
from pymdr.workbench.cli.options import CaseFile, Cluster, Json, Quiet, at_work, spread, values_of
from pymdr.workbench.cli.reporting import (
    FAILED,
    REFUSALS,
    REFUSED,
    claims_of,
    failures_as_json,
    print_error,
    print_json,
    print_report,
    report,
    stages,
)

if TYPE_CHECKING:
    from pymdr.problem.contact import Contact
    from pymdr.solving.sweep import Sweep
    from pymdr.units import FloatArray


def sweep(
    case: CaseFile,
    over: Annotated[
        list[str],
        typer.Option(help="Parameter with values, such as 'body.young = 1 MPa, 2 MPa'; repeatable."),
    ],
    points: Annotated[
        int | None, typer.Option(help="Total number of values, log-spaced between the two given.")
    ] = None,
    quantity: Annotated[
        list[str] | None, typer.Option(help="Quantity to keep, such as normal_force; by default all.")
    ] = None,
    workers: Annotated[int, typer.Option(min=1, help="Processes; results do not depend on it.")] = 1,
    cluster: Cluster = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="DIR",
            help="Folder for sweep.nc and the figure; an interrupted sweep resumes there.",
        ),
    ] = None,
    csv: Annotated[bool, typer.Option("--csv", help="Write sweep.csv too.")] = False,
    xlsx: Annotated[bool, typer.Option("--xlsx", help="Write sweep.xlsx too.")] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Solve a case over a grid of its parameters."""
    import contextlib

    from pymdr.solving.sweep import sweep as solve_all
    from pymdr.workbench.casefile import read_case

    tables = Tables(csv, xlsx)
    with failures_as_json("sweep", case, as_json):
        tables.check()
        problem = read_case(case)
        grid: dict[str, FloatArray | list[str]] = {}
        for given in over:
            name, values = _swept(problem.contact, given, points)
            if name in grid:
                raise ProblemError(
                    f"--over {given!r}: {name} is already given; write all its values in one --over"
                )
            grid[name] = values
        if points is not None and not any(_ends(given) for given in over):
            raise ProblemError(
                f"--points {points} needs an --over with two values, such as --over 'body.young = 1 MPa, 2 MPa'; else leave it out"
            )
        folder = contextlib.nullcontext(None) if output is None else ready_folder(output)
        options = {
            key: problem.options[key]
            for key in ("machine_stiffness", "keep", "tolerance")
            if key in problem.options
        }
        with folder as target, stages(quiet or as_json) as stage, at_work(workers, cluster) as workforce:
            swept = solve_all(
                problem.contact,
                problem.path,
                grid,
                quantities=quantity,
                workers=workforce,
                folder=None if target is None else target / "parts",
                progress=stage("solving"),
                **options,
            )
            written = []
            if target is not None:
                swept.save(target / "sweep.nc")
                written = [target / "sweep.nc", write_figure(swept.plot(), target / "sweep.png")]
                written += tables.write(swept, target, "sweep")
    status = _ending(swept)
    if as_json:
        print_json(
            report(
                "sweep",
                case,
                written,
                title=problem.title,
                status=status,
                rows=swept.data["status"].size,
                claims=claims_of(swept.claims),
            )
        )
    elif not quiet:
        print_report(problem.title or str(case), swept.summary(), written)
    if swept.failed:
        print_error(f"{case}: {swept.failed} of {swept.data['status'].size} points failed")
        raise typer.Exit(FAILED)
    if status == "REFUSED":
        print_error(f"{case}: the method refuses the contact at all points")
        raise typer.Exit(REFUSED)


def _ending(swept: Sweep) -> str:
    """The status of a sweep."""
    if swept.failed:
        return "PARTLY_FAILED"
    statuses = {str(name) for name in swept.data["status"].values.ravel()}
    if statuses <= set(REFUSALS):
        return "REFUSED"
    return "PARTLY_REFUSED" if any(name.endswith("REFUSED") for name in statuses) else "COMPLETED"


def _listed(given: str) -> list[str]:
    """The values of ``name = value, value``; 1,5 is no list of two."""
    return [value.strip() for value in values_of([given.partition("=")[2]]) if value.strip()]


def _ends(given: str) -> bool:
    """Whether two values are given, the ends of a range."""
    return len(_listed(given)) == 2


def _swept(contact: Contact, given: str, points: int | None) -> tuple[str, FloatArray | list[str]]:
    """The name of a parameter and its values from ``name = value, value``."""
    from pymdr.problem.parameters import parameter_of

    name, sign, _ = (part.strip() for part in given.partition("="))
    listed = _listed(given)
    if not sign or not name or not listed:
        raise ProblemError(
            f"--over {given!r}: a parameter with its values is needed, such as 'body.young = 1 MPa, 2 MPa'"
        )
    unit = "N/m" if name == "machine_stiffness" else parameter_of(contact, name).unit
    return name, spread(
        listed, points if _ends(given) else None, unit, f"over {name}", f"--over '{name} = {{value}}'"
    )
