"""``pymdr rough`` and ``press``: rough contacts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pymdr.workbench.cli.options import Cluster, Json, Points, Quiet, Table, at_work, spread
from pymdr.workbench.cli.reporting import print_error, report_study, stages, study_command

if TYPE_CHECKING:
    from pymdr.problem.codec import SurfaceCase
    from pymdr.solving.study import Study
    from pymdr.units import FloatArray

CaseOfSurface = Annotated[
    Path,
    typer.Argument(metavar="CASE.toml", help="Case file with [surface] instead of [profile] and [[path]]."),
]
Forces = Annotated[
    list[str] | None, typer.Option(help="Force, such as '1 N'; repeatable; by default that of the case.")
]


@study_command("rough")
def rough(
    case: CaseOfSurface,
    normal_force: Forces = None,
    indentation: Annotated[
        list[str] | None, typer.Option(help="Depth below the highest summit instead, such as '1 um'.")
    ] = None,
    points: Points = None,
    realisations: Annotated[int, typer.Option(help="Number of random lines.")] = 100,
    coefficient: Annotated[
        float | None,
        typer.Option(
            "--coefficient",
            help="lambda of C1D = lambda q C2D, the spectrum of the line; by default pi (Geike).",
        ),
    ] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads; results do not depend on it.")] = None,
    cluster: Cluster = None,
) -> tuple[str, Study]:
    """Stiffness of a randomly rough surface on a plane."""
    from pymdr.solving.rough import press_rough
    from pymdr.workbench.casefile import read_rough_case

    problem = read_rough_case(case)
    forces, depths = _loads(problem, normal_force, indentation, points)
    with at_work(workers, cluster) as workforce:
        return problem.title, press_rough(
            problem.surface,
            problem.body,
            problem.counterbody,
            normal_force=forces,
            indentation=depths,
            realisations=realisations,
            coefficient=coefficient,
            radius=problem.radius,
            workers=workforce,
        )


def press(
    case: CaseOfSurface,
    normal_force: Forces = None,
    indentation: Annotated[
        list[str] | None, typer.Option(help="Depth of the highest pixel instead, such as '1 um'.")
    ] = None,
    points: Points = None,
    engine: Annotated[
        str | None,
        typer.Option(help="contactmechanics (default), tamaas, aspher, or one of another package."),
    ] = None,
    keep: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder that stores every load; an interrupted run resumes there."),
    ] = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Press a rough surface by boundary elements.

    With -o a table, a figure and a file for open_pressed_surface are written.
    """
    from pymdr.presentation.text import bytes_text
    from pymdr.solving.press import bytes_of, pixels_of
    from pymdr.solving.press import press as press_surface
    from pymdr.workbench.casefile import read_press_case

    def studied() -> tuple[str, Study]:
        problem, surface = read_press_case(case)
        forces, depths = _loads(problem, normal_force, indentation, points)
        loads = forces if forces is not None else depths
        if not quiet and not as_json and loads is not None:
            nx, ny = pixels_of(surface)
            needed = bytes_text(round(bytes_of((nx, ny), len(loads), engine)))
            print_error(
                f"{nx} x {ny} pixels at {len(loads)} load{'s' * (len(loads) != 1)} need about {needed}"
            )
        with stages(quiet or as_json) as stage:
            return problem.title, press_surface(
                surface,
                problem.body,
                problem.counterbody,
                normal_force=forces,
                indentation=depths,
                punch=problem.punch,
                engine=engine,
                keep=keep,
                progress=stage("pressing"),
            )

    report_study("press", case, studied, output, quiet, as_json)


def _loads(
    case: SurfaceCase,
    normal_force: Sequence[str] | None,
    indentation: Sequence[str] | None,
    points: int | None,
) -> tuple[FloatArray | list[str] | None, FloatArray | list[str] | None]:
    """Given forces or depths, or those of the case."""
    if not normal_force and not indentation:
        normal_force, indentation = case.normal_force, case.indentation
    forces = spread(normal_force, points, "N", "normal-force") if normal_force else None
    depths = spread(indentation, points, "m", "indentation") if indentation else None
    return forces, depths
