"""``pymdr verify``: the method held against boundary elements."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pymdr.workbench.cli.folders import named_after, ready_folder, write_figures
from pymdr.workbench.cli.options import CaseFile, Json, Output, Quiet
from pymdr.workbench.cli.telling import (
    REFUSED,
    Stage,
    answer,
    failures_as_json,
    print_json,
    say,
    say_written,
    stages,
    table_of,
)

if TYPE_CHECKING:
    from pymdr.workbench.casefile import Case
    from pymdr.workbench.comparison import Comparison


def verify(
    case: CaseFile,
    output: Output = None,
    rings: Annotated[int, typer.Option(help="Number of rings, 20 to 5000.")] = 400,
    cells: Annotated[int, typer.Option(help="With friction: cells along a side of the grid, 8 to 80.")] = 32,
    pixels: Annotated[
        int, typer.Option(help="Of a body that is not of revolution: pixels along a side, 33 to 1025.")
    ] = 129,
    steps: Annotated[
        int | None, typer.Option(help="How many steps of the path are solved by both; 5, with friction 20.")
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Hold the method against boundary elements: on rings, with friction or bodies not of revolution on a grid; draw both."""
    from pymdr.workbench.casefile import read_case

    with failures_as_json("verify", case, as_json):
        folder = output or named_after(case)
        asked = read_case(case)
        with ready_folder(folder), stages(quiet or as_json) as stage:
            found, told = _verified(asked, rings, pixels, cells, steps, stage)
            written = write_figures({"verify": found.plot()}, folder, stage("drawing"))
    # without any difference to tell the method gave nothing
    refused = not math.isfinite(told["largest_difference"])
    if as_json:
        report = answer(
            "verify",
            case,
            written,
            title=asked.title,
            status="REFUSED" if refused else "COMPLETED",
            rows=found.data.sizes["step"],
            verification={**told, "table": table_of(found.data)},
        )
        print_json(report)
    elif not quiet:
        say(found.summary())
        say_written(written)
    if refused:
        raise typer.Exit(REFUSED)


def _verified(
    asked: Case, rings: int, pixels: int, cells: int, steps: int | None, stage: Stage
) -> tuple[Comparison, dict[str, Any]]:
    """What both say, and how it is told in JSON."""
    from pymdr.problem.profiles import Shape
    from pymdr.workbench.sliding import SlidingVerification
    from pymdr.workbench.verification import verify as hold_against_elements

    if asked.contact.friction is not None:
        solver, n, words = "cells", cells, "solving on a grid"
    elif isinstance(asked.contact.profile, Shape):
        solver, n, words = "pixels", pixels, "pressing by boundary elements"
    else:
        solver, n, words = "rings", rings, "solving by rings"
    found = hold_against_elements(
        asked.contact,
        asked.path,
        elements=n,
        steps=steps,
        machine_stiffness=asked.options.get("machine_stiffness"),
        progress=stage(words),
    )
    told: dict[str, Any] = {"solver": solver, "n": n, "largest_difference": found.largest_difference}
    if isinstance(found, SlidingVerification):
        told |= {"path_rows": found.path_rows, "rows": found.rows.tolist()}
    return found, told
