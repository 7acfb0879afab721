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
    from pymdr.solving.fits import FitResult, FittedMap


def fit(
    case: CaseFile,
    curve: Annotated[
        list[Path],
        typer.Argument(
            metavar="CURVE.csv...",
            help="Force and travel or indentation, with units; or the folder of a Zarr store of a map of curves.",
        ),
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
    workers: Annotated[int, typer.Option(help="Cores for a map; the numbers do not depend on them.")] = 1,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Find parameters of the contact of a case in measured force curves; with -o a table and a figure are written.

    What is found in a map stands in DIR/fit.zarr too, where a killed fit goes on when it is called again.
    """
    from pymdr.workbench.casefile import read_contact

    origins = {"contact_point": contact_point, "baseline": baseline}
    found: FitResult | FittedMap
    with failures_as_json("fit", case, as_json):
        title, contact = read_contact(case)
        if any(file.is_dir() for file in curve):
            with stages(quiet or as_json) as stage:
                options = {**origins, "workers": workers, "progress": stage("fitting")}
                found, written = _map(contact, curve, free, spring_constant, options, output)
            told = _told_of_map(found)
        else:
            from pymdr.solving.fits import fit as find
            from pymdr.workbench.tables import read_curve

            curves = [read_curve(file, spring_constant=spring_constant) for file in curve]
            found = find(contact, curves, free, **origins)
            written = write_found(found, output, "fit")
            told = _told_of_fit(found)
    if as_json:
        valid = validity_of(found)
        print_json(answer("fit", case, written, title=title, status="COMPLETED", **told, **valid))
    elif not quiet:
        say_found(title or str(case), found.summary(), written)


def _map(
    contact: Any,
    files: Sequence[Path],
    free: Sequence[str],
    spring_constant: str | None,
    options: dict[str, Any],
    output: Path | None,
) -> tuple[FittedMap, list[Path]]:
    """Fit the one map that is named, and write what was found where a folder is."""
    from pymdr.errors import ProblemError
    from pymdr.solving.fits import fit_map

    if len(files) > 1:
        raise ProblemError(
            f"{len(files)} files with a folder among them: a map of curves is fitted alone; name one"
        )
    if spring_constant is not None:
        raise ProblemError("--spring-constant: a map has its own, as a variable spring_constant of its store")
    if output is None:
        return fit_map(contact, files[0], free, **options), []
    with ready_folder(output) as folder:
        found = fit_map(contact, files[0], free, folder=folder / "fit.zarr", **options)
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
    fitted = {"values": values, "noise": found.noise, "correlated": found.correlated, "aicc": found.aicc}
    return {"rows": found.data.sizes["step"], "fit": fitted}


def _told_of_map(found: FittedMap) -> dict[str, Any]:
    import numpy as np

    values: dict[str, Any] = {}
    for name in found.names if found.counts.get("found") else ():
        low, middle, high = (float(q) for q in np.nanquantile(found.data[name].values, [0.25, 0.5, 0.75]))
        unit = str(found.data[name].attrs["units"])
        values[name] = {"median": middle, "low_quartile": low, "high_quartile": high, "unit": unit}
    return {"rows": found.data["ending"].size, "fit": {"values": values, "endings": found.counts}}
