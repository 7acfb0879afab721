"""``pymdr sweep``: a case over grids of its parameters."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pymdr.workbench.cli.folders import Tables, ready_folder, write_figure
from pymdr.workbench.cli.options import CaseFile, Json, Quiet, spread
from pymdr.workbench.cli.telling import (
    FAILED,
    REFUSALS,
    REFUSED,
    answer,
    claims_of,
    complain,
    failures_as_json,
    print_json,
    say_found,
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
        typer.Option(
            help="A parameter with its values, such as 'body.young = 1 MPa, 2 MPa'; once for each parameter."
        ),
    ],
    points: Annotated[
        int | None,
        typer.Option(help="How many in all where two values are given, evenly in their logarithm."),
    ] = None,
    quantity: Annotated[
        list[str] | None, typer.Option(help="What is kept, such as normal_force; everything unless given.")
    ] = None,
    workers: Annotated[int, typer.Option(min=1, help="Processes; the numbers do not depend on them.")] = 1,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="DIR",
            help="Folder for sweep.nc and the figure; called again, a killed sweep goes on there.",
        ),
    ] = None,
    csv: Annotated[bool, typer.Option("--csv", help="Write sweep.csv too.")] = False,
    xlsx: Annotated[bool, typer.Option("--xlsx", help="Write sweep.xlsx too.")] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Solve a case for all combinations of some of its parameters; with -o the arrays and a figure are written."""
    import contextlib

    from pymdr.errors import ProblemError
    from pymdr.solving.sweep import sweep as solve_all
    from pymdr.workbench.casefile import read_case

    tables = Tables(csv, xlsx)
    with failures_as_json("sweep", case, as_json):
        tables.check()
        asked = read_case(case)
        grid: dict[str, FloatArray | list[str]] = {}
        for given in over:
            name, values = _swept(asked.contact, given, points)
            if name in grid:
                raise ProblemError(
                    f"--over {given!r}: {name} is given already; write all its values in one --over"
                )
            grid[name] = values
        if points is not None and not any(_ends(given) for given in over):
            raise ProblemError(
                f"--points {points}: it is how many lie between two values, and no --over gives two; leave it out, or write such as "
                "--over 'body.young = 1 MPa, 2 MPa'"
            )
        folder = contextlib.nullcontext(None) if output is None else ready_folder(output)
        options = {key: asked.options[key] for key in ("machine_stiffness", "keep") if key in asked.options}
        with folder as into, stages(quiet or as_json) as stage:
            found = solve_all(
                asked.contact,
                asked.path,
                grid,
                quantities=quantity,
                workers=workers,
                folder=None if into is None else into / "parts",
                progress=stage("solving"),
                **options,
            )
            written = []
            if into is not None:
                found.save(into / "sweep.nc")
                written = [into / "sweep.nc", write_figure(found.plot(), into / "sweep.png")]
                written += tables.write(found, into, "sweep")
    status = _ending(found)
    if as_json:
        print_json(
            answer(
                "sweep",
                case,
                written,
                title=asked.title,
                status=status,
                rows=found.data["status"].size,
                claims=claims_of(found.claims),
            )
        )
    elif not quiet:
        say_found(asked.title or str(case), found.summary(), written)
    if found.failed:
        complain(f"{case}: {found.failed} of {found.data['status'].size} points have no result")
        raise typer.Exit(FAILED)
    if status == "REFUSED":
        complain(f"{case}: the method refuses the contact at every point")
        raise typer.Exit(REFUSED)


def _ending(found: Sweep) -> str:
    """How a sweep ended, in a word."""
    if found.failed:
        return "PARTLY_FAILED"
    statuses = {str(name) for name in found.data["status"].values.ravel()}
    if statuses <= set(REFUSALS):
        return "REFUSED"
    return "PARTLY_REFUSED" if any(name.endswith("REFUSED") for name in statuses) else "COMPLETED"


def _listed(given: str) -> list[str]:
    """The values of ``name = value, value``."""
    return [value.strip() for value in given.partition("=")[2].split(",") if value.strip()]


def _ends(given: str) -> bool:
    """Whether two values are given, which may be the ends of several."""
    return len(_listed(given)) == 2


def _swept(contact: Contact, given: str, points: int | None) -> tuple[str, FloatArray | list[str]]:
    """The name of a parameter and its values from ``name = value, value``."""
    from pymdr.errors import ProblemError
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
