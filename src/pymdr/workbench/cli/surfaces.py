"""``pymdr rough`` and ``press``: rough surfaces that are pressed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pymdr.workbench.cli.options import Json, Points, Quiet, Table, spread
from pymdr.workbench.cli.telling import complain, stages, tell_study

if TYPE_CHECKING:
    from pymdr.solving.study import Study
    from pymdr.units import FloatArray

SurfaceCase = Annotated[
    Path,
    typer.Argument(
        metavar="CASE.toml", help="The case file, with [surface] in the place of [profile] and [[path]]."
    ),
]
Forces = Annotated[list[str] | None, typer.Option(help="Force, such as '1 N'; one or several.")]


def rough(
    case: SurfaceCase,
    normal_force: Forces = None,
    indentation: Annotated[
        list[str] | None, typer.Option(help="Depths below the highest summit in its place, such as '1 um'.")
    ] = None,
    points: Points = None,
    realisations: Annotated[int, typer.Option(help="Lines of the ensemble.")] = 100,
    coefficient: Annotated[
        float | None,
        typer.Option(
            "--coefficient",
            help="lambda of C1D = lambda q C2D, the spectrum of the line; pi, of Geike, unless given.",
        ),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Threads; the numbers do not depend on them.")
    ] = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Stiffness of a randomly rough surface that is pressed on a plane; with -o its table and figure are written."""
    from pymdr.solving.rough import press_rough
    from pymdr.workbench.casefile import read_rough_case

    def ask() -> tuple[str, Study]:
        asked = read_rough_case(case)
        forces, depths = _loads(normal_force, indentation, points)
        return asked.title, press_rough(
            asked.surface,
            asked.body,
            asked.counterbody,
            normal_force=forces,
            indentation=depths,
            realisations=realisations,
            coefficient=coefficient,
            radius=asked.radius,
            workers=workers,
        )

    tell_study("rough", case, ask, output, quiet, as_json)


def press(
    case: SurfaceCase,
    normal_force: Forces = None,
    indentation: Annotated[
        list[str] | None, typer.Option(help="Depths of the highest pixel in its place, such as '1 um'.")
    ] = None,
    points: Points = None,
    engine: Annotated[
        str | None,
        typer.Option(help="contactmechanics unless given, tamaas, aspher, or one of another package."),
    ] = None,
    keep: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Folder that keeps every load, from which a run goes on that was ended."
        ),
    ] = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Press a measured or random surface by boundary elements; with -o its table and figure are written, and a file for open_pressed_surface."""
    from pymdr.presentation.text import bytes_text
    from pymdr.solving.press import bytes_of, pixels_of
    from pymdr.solving.press import press as press_surface
    from pymdr.workbench.casefile import read_press_case

    def ask() -> tuple[str, Study]:
        asked, surface = read_press_case(case)
        forces, depths = _loads(normal_force, indentation, points)
        loads = forces if forces is not None else depths
        if not quiet and not as_json and loads is not None:
            nx, ny = pixels_of(surface)
            needed = bytes_text(round(bytes_of((nx, ny), len(loads), engine)))
            complain(f"{nx} x {ny} pixels at {len(loads)} loads take about {needed}")
        with stages(quiet or as_json) as stage:
            return asked.title, press_surface(
                surface,
                asked.body,
                asked.counterbody,
                normal_force=forces,
                indentation=depths,
                punch=asked.punch,
                engine=engine,
                keep=keep,
                progress=stage("pressing"),
            )

    tell_study("press", case, ask, output, quiet, as_json)


def _loads(
    normal_force: list[str] | None, indentation: list[str] | None, points: int | None
) -> tuple[FloatArray | list[str] | None, FloatArray | list[str] | None]:
    """Forces and depths, of which a question takes the ones or the others."""
    forces = spread(normal_force, points, "N", "normal-force") if normal_force else None
    depths = spread(indentation, points, "m", "indentation") if indentation else None
    return forces, depths
