"""``pymdr verify``: comparison with boundary elements."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pymdr.workbench.cli.folders import named_after, ready_folder, write_figures
from pymdr.workbench.cli.options import CaseFile, Json, Quiet
from pymdr.workbench.cli.reporting import (
    REFUSED,
    Stage,
    failures_as_json,
    print_json,
    print_text,
    print_written,
    report,
    stages,
    table_of,
)

if TYPE_CHECKING:
    from pymdr.workbench.casefile import Case
    from pymdr.workbench.comparison import Comparison


def verify(
    case: CaseFile,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="DIR", help="Folder for the figure; by default CASE."),
    ] = None,
    rings: Annotated[int, typer.Option(help="Number of rings, 20 to 5000.")] = 400,
    cells: Annotated[int, typer.Option(help="Cells along a side of the grid, 8 to 80 (with friction).")] = 32,
    pixels: Annotated[int, typer.Option(help="Pixels along a side, 33 to 1025 (not axisymmetric).")] = 129,
    steps: Annotated[
        int | None, typer.Option(help="Steps of the path solved by both; by default 5, with friction 20.")
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Compare the method with boundary elements and draw both."""
    from pymdr.workbench.casefile import read_case

    with failures_as_json("verify", case, as_json):
        folder = output or named_after(case)
        problem = read_case(case)
        with ready_folder(folder), stages(quiet or as_json) as stage:
            comparison, plain = _verified(problem, rings, pixels, cells, steps, stage)
            written = write_figures({"verify": comparison.plot()}, folder, stage("drawing"))
    # no finite difference: the method refused the contact
    refused = not math.isfinite(plain["largest_difference"])
    if as_json:
        verified = report(
            "verify",
            case,
            written,
            title=problem.title,
            status="REFUSED" if refused else "COMPLETED",
            rows=comparison.data.sizes["step"],
            verification={**plain, "table": table_of(comparison.data)},
        )
        print_json(verified)
    elif not quiet:
        print_text(comparison.summary())
        print_written(written)
    if refused:
        raise typer.Exit(REFUSED)


def _verified(
    problem: Case, rings: int, pixels: int, cells: int, steps: int | None, stage: Stage
) -> tuple[Comparison, dict[str, Any]]:
    """The comparison, and its entries for JSON."""
    from pymdr.problem.profiles import Shape
    from pymdr.problem.schedule import is_torsional
    from pymdr.workbench.sliding import SlidingVerification
    from pymdr.workbench.verification import MethodOptions
    from pymdr.workbench.verification import verify as compare_with_elements

    wear = problem.outputs.get("wear")
    if wear is not None:
        solver, n, label = "rings", min(rings, 120), "wearing rings"
    elif problem.contact.friction is not None and is_torsional(problem.path):
        solver, n, label = "rings", min(rings, 200), "turning rings"
    elif problem.contact.friction is not None:
        solver, n, label = "cells", cells, "solving on a grid"
    elif isinstance(problem.contact.profile, Shape):
        solver, n, label = "pixels", pixels, "pressing by boundary elements"
    else:
        solver, n, label = "rings", rings, "solving by rings"
    comparison = compare_with_elements(
        problem.contact,
        problem.path,
        elements=n,
        steps=steps,
        wear=wear,
        progress=stage(label),
        **{name: problem.options[name] for name in MethodOptions.__annotations__ if name in problem.options},
    )
    plain: dict[str, Any] = {"solver": solver, "n": n, "largest_difference": comparison.largest_difference}
    if isinstance(comparison, SlidingVerification):
        plain |= {"path_rows": comparison.path_rows, "rows": comparison.rows.tolist()}
    if comparison.subsurface is not None:
        plain["stress"] = comparison.subsurface.as_json()
    return comparison, plain
