"""``pymdr nanoindent``: hardness and modulus of indents."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pymdr.workbench.cli.folders import write_study
from pymdr.workbench.cli.options import Json, Quiet, Table
from pymdr.workbench.cli.reporting import (
    columns_of,
    failures_as_json,
    print_json,
    print_report,
    report,
    validity_of,
)

if TYPE_CHECKING:
    import xarray as xr

    from pymdr.problem.profiles import AreaFunction


def nanoindent(
    records: Annotated[
        list[Path],
        typer.Argument(
            metavar="RECORD...",
            help="Files of a nanoindenter (.hld, .xls, .xlsx, text), or tables of load and depth with units; with the unloading.",
        ),
    ],
    area: Annotated[
        str | None,
        typer.Option(
            help="Coefficients C0 C1 ... of the area function: '24.5 900'; by default those of the files."
        ),
    ] = None,
    area_unit: Annotated[str, typer.Option(help="Length in which they are given.")] = "1 nm",
    area_table: Annotated[
        Path | None, typer.Option(help="CSV of contact depth and area with units, instead.")
    ] = None,
    reference: Annotated[
        list[str] | None,
        typer.Option(help="Indent in fused silica, to calibrate area and frame; repeatable."),
    ] = None,
    terms: Annotated[int, typer.Option(help="Coefficients of the calibrated area function.")] = 3,
    frame_compliance: Annotated[
        str | None, typer.Option(help="Compliance of the frame, such as '0.3 nm/mN'.")
    ] = None,
    tip_young: Annotated[str, typer.Option(help="Young's modulus of the tip.")] = "1141 GPa",
    tip_poisson: Annotated[float, typer.Option(help="Poisson's ratio of the tip.")] = 0.07,
    poisson: Annotated[float | None, typer.Option(help="Poisson's ratio of the sample.")] = None,
    beta: Annotated[float, typer.Option(help="Beta of the power law; 1.034 for Berkovich tips.")] = 1.0,
    epsilon: Annotated[
        float, typer.Option(help="Epsilon of the power law; 0 takes that of its exponent.")
    ] = 0.75,
    fit_from: Annotated[
        float, typer.Option(help="Smallest force of the power law, over the largest.")
    ] = 0.25,
    fit_to: Annotated[float, typer.Option(help="Largest force of the power law, over the largest.")] = 0.98,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Hardness and modulus of indents from their unloading."""
    from pymdr.problem.materials import Elastic
    from pymdr.solving.nanoindentation import calibrate_area, oliver_pharr

    written: list[Path] = []
    with failures_as_json("nanoindent", records[0], as_json):
        tip = Elastic(tip_young, tip_poisson)
        calibration = None
        if reference:
            _refuse_two_areas(area, area_table)
            calibration = calibrate_area(
                [record for file in reference for record in _indents(Path(file))],
                tip=tip,
                terms=terms,
                frame_compliance=frame_compliance,
                beta=beta,
                epsilon=epsilon or None,
                fit_range=(fit_from, fit_to),
            )
            written += write_study(calibration, output, "area")
        indents = [record for file in records for record in _indents(file)]
        study = oliver_pharr(
            indents,
            calibration or _area_function(area, area_unit, area_table, indents),
            frame_compliance=None if calibration else frame_compliance,
            tip=tip,
            poisson=poisson,
            beta=beta,
            epsilon=epsilon or None,
            fit_range=(fit_from, fit_to),
        )
        written += write_study(study, output, "nanoindent")
    if as_json:
        plain = report(
            "nanoindent",
            records[0],
            written,
            status="COMPLETED",
            rows=study.data.sizes["indent"],
            study=columns_of(study),
            **validity_of(study),
        )
        print_json(plain)
    elif not quiet:
        calibrated = f"{calibration.summary()}\n" if calibration is not None else ""
        print_report(", ".join(map(str, records)), calibrated + study.summary(), written)


def _refuse_two_areas(area: str | None, table: Path | None) -> None:
    from pymdr.errors import ProblemError

    if area is not None or table is not None:
        raise ProblemError("give one of --area, --area-table and --reference")


def _indents(file: Path) -> Sequence[xr.Dataset]:
    """The indents of a file of an instrument, or the record of a table."""
    from pymdr.workbench.indents import read_indents

    return read_indents(file)


def _area_function(
    area: str | None, unit: str, table: Path | None, indents: Sequence[xr.Dataset]
) -> AreaFunction:
    """The area function of the options, or else of the files."""
    from pymdr.errors import ProblemError
    from pymdr.problem.profiles import AreaFunction
    from pymdr.workbench.indents import area_function_of
    from pymdr.workbench.tables import read_area_function

    if area is None and table is None and (known := area_function_of(indents)) is not None:
        return known
    if (area is None) == (table is None):
        raise ProblemError("give one of --area '24.5 900', --area-table FILE and --reference FILE")
    if table is not None:
        return read_area_function(table)
    assert area is not None
    try:
        coefficients = [float(value) for value in area.replace(",", " ").split()]
    except ValueError:
        raise ProblemError(f"--area {area!r}: numbers are needed, such as '24.5 900'") from None
    return AreaFunction(coefficients, unit=unit)
