"""``pymdr loops`` and ``topography``: what was measured, a record or a surface."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pymdr.workbench.cli.folders import write_found
from pymdr.workbench.cli.options import Json, Quiet, Table
from pymdr.workbench.cli.telling import (
    answer,
    failures_as_json,
    print_json,
    say,
    say_found,
    table_of,
    tell_study,
)

if TYPE_CHECKING:
    from pymdr.problem.topography import Topography
    from pymdr.solving.study import Study


def loops(
    record: Annotated[
        Path,
        typer.Argument(metavar="RECORD", help="Force and displacement with units in a CSV, or a result.nc."),
    ],
    least: Annotated[
        str | None,
        typer.Option(help="The smallest swing that is a turn, such as '0.1 um'; a tenth of the range."),
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Energy per cycle and equivalent damping of a measured record or a result; nothing is written."""
    from pymdr.solving.reopening import open_result
    from pymdr.workbench.records import measured_loops
    from pymdr.workbench.tables import read_record

    with failures_as_json("loops", record, as_json):
        read = open_result if record.suffix == ".nc" else read_record
        found = measured_loops(read(record), least=least)
    if as_json:
        rows, table = found.data.sizes["cycle"], table_of(found.data)
        print_json(answer("loops", record, status="COMPLETED", rows=rows, loops=table))
    elif not quiet:
        say(found.summary())


def topography(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A measured surface.")],
    channel: Annotated[
        str | None, typer.Option(help="Number or name of the channel, where the file has several.")
    ] = None,
    size: Annotated[
        list[str] | None,
        typer.Option(
            help="Side of the square patch, or twice for both, where the file has none, such as '10 um'."
        ),
    ] = None,
    unit: Annotated[
        str | None, typer.Option(help="Unit of the heights, where the file has none, such as nm.")
    ] = None,
    missing: Annotated[
        str | None, typer.Option(help="What becomes of missing heights: interpolate or crop.")
    ] = None,
    detrend: Annotated[
        str | None,
        typer.Option(
            help="What is taken off: none, mean, plane, sphere or curvature; a plane unless given, none with --profile."
        ),
    ] = None,
    tip_radius: Annotated[
        str | None,
        typer.Option(help="Of the tip that measured it: waves it cannot have resolved are left out."),
    ] = None,
    periodic: Annotated[
        bool, typer.Option("--periodic", help="The patch is one period of the surface.")
    ] = False,
    profile: Annotated[
        bool,
        typer.Option(
            "--profile", help="The mean profile about the apex of one bump in place of the spectrum."
        ),
    ] = False,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """The power spectrum of a measured surface and its self-affine law; with -o its table and figure are written."""
    from pymdr.errors import ProblemError
    from pymdr.solving.azimuth import azimuthal_profile
    from pymdr.solving.roughness import power_spectrum
    from pymdr.workbench.topographies import described, read_topography

    def surface() -> Topography:
        taken = detrend or ("none" if profile else "plane")
        number = int(channel) if channel is not None and channel.isdecimal() else channel
        return read_topography(
            file,
            number,
            size=size or None,
            unit=unit,
            missing=missing,
            detrend=None if taken == "none" else taken,
        )

    def ask() -> tuple[str, Study]:
        found = surface()
        return described(found), power_spectrum(found, periodic=periodic, tip_radius=tip_radius)

    if not profile:
        tell_study("topography", file, ask, output, quiet, as_json)
        return
    with failures_as_json("topography", file, as_json):
        if tip_radius is not None or periodic:
            raise ProblemError(
                "--tip-radius and --periodic are for the spectrum; leave them out with --profile"
            )
        found = azimuthal_profile(surface())
        written = write_found(found, output, "profile")
    if as_json:
        data = found.profile
        columns = {"radius": data.radius, "height": data.height, "scatter": data.scatter}
        study = {
            name: {"values": (values.tolist() if values is not None else []), "unit": "m"}
            for name, values in columns.items()
        }
        told = answer(
            "topography",
            file,
            written,
            title=described(found.topography),
            status="COMPLETED",
            rows=data.radius.size,
            study=study,
            notes=list(found.topography.steps),
        )
        print_json(told)
    elif not quiet:
        say_found(described(found.topography), found.summary(), written)
