"""``pymdr fit``: parameters of a contact found in measured curves, one by one or in a map of them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pymdr.workbench.cli.folders import ready_folder, write_figure, write_found
from pymdr.workbench.cli.options import CaseFile, Json, Quiet, Table
from pymdr.workbench.cli.telling import answer, failures_as_json, print_json, say_found, stages, validity_of

if TYPE_CHECKING:
    import xarray as xr

    from pymdr.problem.contact import Contact
    from pymdr.solving.curves import MeasuredCurve
    from pymdr.solving.fits import FitResult, FittedMap


def fit(
    case: CaseFile,
    curve: Annotated[
        list[Path],
        typer.Argument(
            metavar="CURVE...",
            help="A table of force and travel or indentation with units, for a case with friction of tangential force, shift and load; a file of an atomic force microscope, of one curve or of a map; or "
            "the folder of a Zarr store of a map.",
        ),
    ],
    free: Annotated[
        list[str],
        typer.Option(
            help="What is looked for, such as body.young; one or several. tilt is that of the baseline: a drift, or a virtual deflection."
        ),
    ],
    spring_constant: Annotated[
        str | None, typer.Option(help="Of the machine, where travel was measured, such as '0.1 N/m'.")
    ] = None,
    contact_point: Annotated[
        str | None,
        typer.Option(help="Depth of the record at which the bodies touch; looked for unless given."),
    ] = None,
    shift_origin: Annotated[
        str | None,
        typer.Option(
            help="With friction, shift of the record at which the bodies were pressed together; looked for unless given."
        ),
    ] = None,
    baseline: Annotated[
        str | None, typer.Option(help="Force of the record when they do not touch; looked for unless given.")
    ] = None,
    segment: Annotated[
        str | None,
        typer.Option(
            help="What is taken of a file of a microscope: approach, retreat or record; the approach unless the case has adhesion or memory."
        ),
    ] = None,
    workers: Annotated[
        int, typer.Option(min=1, help="Cores for a map; the numbers do not depend on them.")
    ] = 1,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Find parameters of the contact of a case in measured force curves; with -o a table and a figure are written.

    What is found in a map stands in DIR/fit.zarr too, where a killed fit goes on when it is called again.
    """
    from pymdr.errors import ProblemError
    from pymdr.workbench.casefile import read_contact

    origins = {"contact_point": contact_point, "shift_origin": shift_origin, "baseline": baseline}
    found: FitResult | FittedMap
    with failures_as_json("fit", case, as_json):
        title, contact = read_contact(case)
        curves = (
            _read(curve, spring_constant, segment, contact.adhesion is not None or contact.remembers)
            if contact.friction is None
            else _read_sheared(curve, spring_constant, segment)
        )
        if isinstance(curves, list):
            from pymdr.solving.fits import fit as find

            found = find(contact, curves, free, **origins)
            written = write_found(found, output, "fit")
            told = _told_of_fit(found)
        else:
            with stages(quiet or as_json) as stage:
                if origins.pop("shift_origin") is not None:
                    raise ProblemError(
                        "--shift-origin: is for cases with friction; force curves have --contact-point"
                    )
                options = {**origins, "workers": workers, "progress": stage("fitting")}
                found, written = _map(contact, curves, free, options, output)
            told = _told_of_map(found)
    if as_json:
        valid = validity_of(found)
        cited = list(found.cite())
        print_json(
            answer("fit", case, written, title=title, status="COMPLETED", references=cited, **told, **valid)
        )
    elif not quiet:
        say_found(title or str(case), found.summary(), written)


def _read(
    files: Sequence[Path], spring_constant: str | None, segment: str | None, whole: bool
) -> list[MeasuredCurve] | xr.Dataset | Path:
    """Curves of one contact, or a map of them: a dataset, or the folder of its store."""
    from pymdr.errors import ProblemError
    from pymdr.workbench.curves import read_prepared_curves, stack_curves
    from pymdr.workbench.tables import read_curve

    curves: list[MeasuredCurve] = []
    for file in files:
        if file.is_dir():
            if len(files) > 1:
                raise ProblemError(f"{file} is a map of curves: it is fitted alone; name no other file")
            if spring_constant is not None:
                raise ProblemError(
                    "--spring-constant: a stored map has its own, as its variable spring_constant"
                )
            _refuse_segment(file, segment)
            return file
        if file.suffix.lower() in (".csv", ".tsv", ".txt", ".dat"):
            _refuse_segment(file, segment)
            curves.append(read_curve(file, spring_constant=spring_constant))
            if spring_constant is not None and curves[-1].travel is None:
                raise ProblemError(
                    f"--spring-constant: {file} has indentations, which need none; a column of travel does"
                )
            continue
        taken = segment or ("record" if whole else "approach")
        records = read_prepared_curves(file, segment=taken, spring_constant=spring_constant)
        if len(records) > 1:
            if len(files) > 1:
                raise ProblemError(
                    f"{file} is a map of {len(records)} curves: it is fitted alone; name no other file"
                )
            return stack_curves(records)
        curves += records
    return curves


def _read_sheared(
    files: Sequence[Path], spring_constant: str | None, segment: str | None
) -> list[xr.Dataset]:
    """Records of tangential force against shift."""
    from pymdr.errors import ProblemError
    from pymdr.workbench.tables import read_record

    if spring_constant is not None or segment is not None:
        raise ProblemError(
            "--spring-constant and --segment are for force curves; the case has friction, and its records tables of shift, "
            "tangential force and load"
        )
    return [read_record(file) for file in files]


def _refuse_segment(file: Path, segment: str | None) -> None:
    from pymdr.errors import ProblemError

    if segment is not None:
        raise ProblemError(
            f"--segment {segment}: {file} is taken whole; leave the option out, or cut the curve before"
        )


def _map(
    contact: Contact,
    curves: xr.Dataset | Path,
    free: Sequence[str],
    options: dict[str, Any],
    output: Path | None,
) -> tuple[FittedMap, list[Path]]:
    """Fit a map, and write what was found where a folder is named."""
    from pymdr.solving.fits import fit_map

    if output is None:
        return fit_map(contact, curves, free, **options), []
    with ready_folder(output) as folder:
        found = fit_map(contact, curves, free, folder=folder / "fit.zarr", **options)
        found.to_csv(folder / "fit.csv")
        return found, [
            folder / "fit.zarr",
            folder / "fit.csv",
            write_figure(found.plot(), folder / "fit.png"),
        ]


def _told_of_fit(found: FitResult) -> dict[str, Any]:
    values = {
        name: {"value": one.value, "error": one.error, "low": one.low, "high": one.high, "unit": one.unit}
        for name, one in found.values.items()
    }
    fitted = {
        "values": values,
        "noise": found.noise,
        "waves": found.waves,
        "correlated": found.correlated,
        "aicc": found.aicc,
    }
    return {"rows": found.data.sizes["step"], "fit": fitted}


def _told_of_map(found: FittedMap) -> dict[str, Any]:
    import numpy as np

    values: dict[str, Any] = {}
    for name in found.names if found.counts.get("found") else ():
        low, middle, high = (float(q) for q in np.nanquantile(found.data[name].values, [0.25, 0.5, 0.75]))
        unit = str(found.data[name].attrs["units"])
        values[name] = {"median": middle, "low_quartile": low, "high_quartile": high, "unit": unit}
    return {"rows": found.data["ending"].size, "fit": {"values": values, "endings": found.counts}}
