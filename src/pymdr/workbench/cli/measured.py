"""``pymdr loops``, ``fretting`` and ``topography``: measured records and surfaces."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pymdr.errors import ProblemError
from pymdr.workbench.cli.folders import write_figure, write_study
from pymdr.workbench.cli.options import Json, Quiet, Table
from pymdr.workbench.cli.reporting import (
    failures_as_json,
    print_json,
    print_report,
    report,
    report_answer,
    report_study,
    stages,
    table_of,
)

if TYPE_CHECKING:
    import xarray as xr

    from pymdr.problem.contact import Contact
    from pymdr.problem.topography import Topography
    from pymdr.result import Result
    from pymdr.solving.study import Study


def loops(
    record: Annotated[
        Path,
        typer.Argument(
            metavar="RECORD", help="CSV of force and displacement with units, a result or a case."
        ),
    ],
    least: Annotated[
        str | None,
        typer.Option(
            help="Smallest swing that counts as a turn, such as '0.1 um'; by default a tenth of the range."
        ),
    ] = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Energy per cycle, damping and slip of a record or a case."""
    from pymdr.workbench.records import measured_loops

    with failures_as_json("loops", record, as_json):
        study = measured_loops(_read_cycles(record), least=least)
        written = write_study(study, output, "loops")

    def own() -> dict[str, Any]:
        return {"rows": study.data.sizes["cycle"], "loops": table_of(study.data)}

    report_answer("loops", record, "", study, written, quiet, as_json, own)


def fretting(
    record: Annotated[
        Path, typer.Argument(metavar="RECORD", help="CSV of tangential force and shift, or a result.")
    ],
    case: Annotated[
        Path | None, typer.Option(help="Case of the contact, whose loops the record is compared with.")
    ] = None,
    normal_force: Annotated[
        str | None, typer.Option(help="Constant load, if the record has none, such as '10 N'.")
    ] = None,
    machine_stiffness: Annotated[
        str | None, typer.Option(help="Tangential stiffness of the machine, to be subtracted.")
    ] = None,
    worn_volume: Annotated[
        str | None, typer.Option(help="Worn volume after the record, such as '0.01 mm^3'.")
    ] = None,
    cycles: Annotated[
        float | None,
        typer.Option(help="Number of cycles that caused the worn volume; by default those recorded."),
    ] = None,
    least: Annotated[
        str | None,
        typer.Option(help="Smallest swing that counts as a turn; by default a tenth of the range."),
    ] = None,
    chart: Annotated[
        Path | None,
        typer.Option("--map", help="Figure of load against amplitude with the cycles; needs --case."),
    ] = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Friction, stiffness and slip regime of every measured cycle."""
    from pymdr.workbench.casefile import read_contact
    from pymdr.workbench.fretting import fretting_log

    def studied() -> tuple[str, Study]:
        contact = None if case is None else read_contact(case)[1]
        with stages(quiet or as_json) as stage:
            study = fretting_log(
                _read_cycles(record),
                contact=contact,
                normal_force=normal_force,
                machine_stiffness=machine_stiffness,
                worn_volume=worn_volume,
                cycles=cycles,
                least=least,
                progress=stage("measuring cycles"),
            )
        if chart is not None:
            _draw_map(study, contact, chart)
        return str(record), study

    report_study("fretting", record, studied, output, quiet, as_json)


def _draw_map(study: Study, contact: Contact | None, file: Path) -> None:
    """Load against amplitude with the cycles of a record, up to a quarter above its largest load."""
    import numpy as np

    from pymdr.solving.running import running_conditions

    if contact is None:
        raise ProblemError("--map needs the contact whose gross slip it shows; give --case")
    if "normal_force" not in study.data:
        raise ProblemError("--map needs the load of the record; give --normal-force")
    if contact.friction is None:
        raise ProblemError("--map needs a coefficient of friction; give [friction] in the case")
    loads = np.linspace(0.02, 1.25, 60) * float(study.data["normal_force"].max())
    write_figure(running_conditions(contact, loads, record=study).plot(), file)


def _read_cycles(record: Path) -> xr.Dataset | Result:
    """A saved result, the solution of a case, or a measured record."""
    from pymdr.solving.reopening import open_result
    from pymdr.solving.verb import solve
    from pymdr.workbench.casefile import read_case
    from pymdr.workbench.tables import read_record

    if record.suffix == ".toml":
        case = read_case(record)
        return solve(case.contact, case.path, **case.options)
    is_result = record.suffix == ".nc" or record.is_dir()
    return open_result(record) if is_result else read_record(record)


def topography(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A measured surface.")],
    channel: Annotated[
        str | None, typer.Option(help="Number or name of the channel, if the file has several.")
    ] = None,
    size: Annotated[
        list[str] | None,
        typer.Option(help="Side of the patch, such as '10 um', or twice for both sides; if not in the file."),
    ] = None,
    unit: Annotated[
        str | None, typer.Option(help="Unit of the heights, such as nm; if not in the file.")
    ] = None,
    missing: Annotated[
        str | None, typer.Option(help="Treatment of missing heights: interpolate or crop.")
    ] = None,
    detrend: Annotated[
        str | None,
        typer.Option(
            help="Trend to subtract: none, mean, plane, sphere or curvature; by default plane, with --profile none."
        ),
    ] = None,
    tip_radius: Annotated[
        str | None, typer.Option(help="Radius of the measuring tip; waves it did not resolve are left out.")
    ] = None,
    periodic: Annotated[
        bool, typer.Option("--periodic", help="The patch is one period of the surface.")
    ] = False,
    profile: Annotated[
        bool,
        typer.Option("--profile", help="Mean profile about the apex of one bump, instead of the spectrum."),
    ] = False,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Power spectrum or mean profile of a measured surface."""
    from pymdr.solving.azimuth import azimuthal_profile
    from pymdr.solving.roughness import power_spectrum
    from pymdr.workbench.topographies import described, read_topography

    def surface() -> Topography:
        trend = detrend or ("none" if profile else "plane")
        number = int(channel) if channel is not None and channel.isdecimal() else channel
        subtracted = None if trend == "none" else trend
        return read_topography(
            file, number, size=size or None, unit=unit, missing=missing, detrend=subtracted
        )

    def analysed() -> tuple[str, Study]:
        heights = surface()
        return described(heights), power_spectrum(heights, periodic=periodic, tip_radius=tip_radius)

    if not profile:
        report_study("topography", file, analysed, output, quiet, as_json)
        return
    with failures_as_json("topography", file, as_json):
        if tip_radius is not None or periodic:
            raise ProblemError(
                "--tip-radius and --periodic apply to the spectrum; leave them out with --profile"
            )
        bump = azimuthal_profile(surface())
        written = write_study(bump, output, "profile")
    if as_json:
        data = bump.profile
        columns = {"radius": data.radius, "height": data.height, "scatter": data.scatter}
        study = {
            name: {"values": (values.tolist() if values is not None else []), "unit": "m"}
            for name, values in columns.items()
        }
        plain = report(
            "topography",
            file,
            written,
            title=described(bump.topography),
            status="COMPLETED",
            rows=data.radius.size,
            study=study,
            notes=list(bump.topography.steps),
        )
        print_json(plain)
    elif not quiet:
        print_report(described(bump.topography), bump.summary(), written)
