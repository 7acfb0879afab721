"""``pymdr fit``: parameters of a contact fitted to measured curves or maps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pymdr.workbench.cli.folders import ready_folder, write_figure, write_study
from pymdr.workbench.cli.options import CaseFile, Json, KeepSigns, LeaveOut, Quiet, Sensitivity, Table
from pymdr.workbench.cli.reporting import (
    failures_as_json,
    print_json,
    print_report,
    report,
    stages,
    validity_of,
)

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
            help="A table with units of force (or deflection) and travel, height or indentation (with friction: tangential force, shift and load), an AFM "
            "file of one curve or a map, or the folder of a Zarr store of a map.",
        ),
    ],
    free: Annotated[
        list[str], typer.Option(help="Parameter to fit, such as body.young or tilt; repeatable.")
    ],
    spring_constant: Annotated[
        str | None,
        typer.Option(help="Spring constant of the machine if travel was measured, such as '0.1 N/m'."),
    ] = None,
    sensitivity: Sensitivity = None,
    leave_out_missing: LeaveOut = False,
    contact_point: Annotated[
        str | None,
        typer.Option(help="Contact point in the record; fitted by default."),
    ] = None,
    shift_origin: Annotated[
        str | None,
        typer.Option(help="With friction: shift of the record at zero tangential force; fitted by default."),
    ] = None,
    baseline: Annotated[
        str | None, typer.Option(help="Force of the record out of contact; fitted by default.")
    ] = None,
    max_indentation: Annotated[
        str | None, typer.Option(help="Largest fitted indentation, such as '500 nm'; one curve.")
    ] = None,
    max_force: Annotated[
        str | None, typer.Option(help="Largest fitted force above the baseline, such as '1 nN'; one curve.")
    ] = None,
    uncertainty: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            help="Standard uncertainty in the intervals, such as 'spring_constant=10 %', sensitivity or profile.radius; repeatable.",
        ),
    ] = None,
    over_indentation: Annotated[
        int | None,
        typer.Option(min=2, help="Number of growing fit ranges; writes the parameters over them."),
    ] = None,
    segment: Annotated[
        str | None,
        typer.Option(
            help="Part of a record: approach, retreat or record; by default the approach of an AFM curve, the record of a table, or "
            "with adhesion or memory."
        ),
    ] = None,
    keep_signs: KeepSigns = False,
    workers: Annotated[
        int, typer.Option(min=1, help="Processes for a map; results do not depend on it.")
    ] = 1,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Fit parameters of a contact to measured force curves.

    With -o a table and a figure are written; a map is also stored in DIR/fit.zarr, where an interrupted fit resumes.
    """
    from pymdr.errors import ProblemError
    from pymdr.workbench.casefile import read_contact

    origins = {"contact_point": contact_point, "shift_origin": shift_origin, "baseline": baseline}
    fitted: FitResult | FittedMap
    with failures_as_json("fit", case, as_json):
        title, contact = read_contact(case)
        curves = (
            _read(
                curve,
                {
                    "spring_constant": _parted(spring_constant)[0],
                    "sensitivity": sensitivity,
                    "leave_out_missing": leave_out_missing,
                },
                segment,
                contact.adhesion is not None or contact.is_viscoelastic,
                keep_signs=keep_signs,
            )
            if contact.friction is None
            else _read_sheared(curve, spring_constant, sensitivity, leave_out_missing, segment)
        )
        if isinstance(curves, list):
            from pymdr.solving.fits import fit as fit_curves

            ranges = {"indentation": max_indentation, "force": max_force}
            options: dict[str, Any] = {
                **origins,
                "fit_range": {name: limit for name, limit in ranges.items() if limit is not None} or None,
                "uncertainty": _uncertainties(uncertainty, spring_constant) or None,
            }
            fitted = fit_curves(contact, curves, free, **options)
            written = write_study(fitted, output, "fit")
            if over_indentation is not None:
                written += _over_indentation(contact, curves, free, origins, over_indentation, output)
            plain = _plain_fit(fitted)
        else:
            with stages(quiet or as_json) as stage:
                for name, given in (
                    ("--max-indentation", max_indentation),
                    ("--max-force", max_force),
                    ("--uncertainty", uncertainty),
                    ("--over-indentation", over_indentation),
                ):
                    if given:
                        raise ProblemError(f"{name} is for single records; fit one curve of the map")
                if origins.pop("shift_origin") is not None:
                    raise ProblemError(
                        "--shift-origin needs a case with friction; use --contact-point for force curves"
                    )
                options = {**origins, "workers": workers, "progress": stage("fitting")}
                fitted, written = _map(contact, curves, free, options, output)
            plain = _plain_map(fitted)
    if as_json:
        valid = validity_of(fitted)
        cited = list(fitted.cite())
        print_json(
            report("fit", case, written, title=title, status="COMPLETED", references=cited, **plain, **valid)
        )
    elif not quiet:
        print_report(title or str(case), fitted.summary(), written)


def _parted(given: str | None) -> tuple[str | None, str | None]:
    """A value and its uncertainty of ``VALUE +- UNCERTAINTY``."""
    value, sign, uncertainty = (given or "").replace("±", "+-").partition("+-")
    return (value.strip() if sign else given), (uncertainty.strip() if sign else None)


def _uncertainties(given: Sequence[str] | None, spring_constant: str | None) -> dict[str, str]:
    """Standard uncertainties by name."""
    from pymdr.errors import ProblemError

    found: dict[str, str] = {}
    own = _parted(spring_constant)[1]
    if own is not None:
        found["spring_constant"] = own
    for text in given or ():
        name, sign, value = (part.strip() for part in text.partition("="))
        if not sign or not name or not value or name in found:
            raise ProblemError(
                f"--uncertainty {text}: write each name once, with a value, such as --uncertainty 'profile.radius=5 %'"
            )
        found[name] = value
    return found


def _over_indentation(
    contact: Contact,
    curves: Sequence[Any],
    free: Sequence[str],
    origins: dict[str, str | None],
    steps: int,
    output: Path | None,
) -> list[Path]:
    """Fit growing ranges of one curve; print them, or write them into a folder."""
    from pymdr.errors import ProblemError
    from pymdr.solving.fits import fit_over_indentation

    if len(curves) != 1 or output is None:
        raise ProblemError(
            "--over-indentation needs one curve, and a folder for its table and figure: -o DIR"
        )
    known = {name: origins[name] for name in ("contact_point", "baseline")}
    study = fit_over_indentation(contact, curves[0], free, steps=steps, **known)
    return write_study(study, output, "over_indentation")


def _read(
    files: Sequence[Path],
    options: dict[str, Any],
    segment: str | None,
    whole: bool,
    *,
    keep_signs: bool,
) -> list[MeasuredCurve] | xr.Dataset | Path:
    """Curves of one contact, or a map as a dataset or the folder of its store."""
    from pymdr.errors import ProblemError
    from pymdr.workbench.curves import is_table, read_prepared_curves, read_segment, stack_curves

    curves: list[MeasuredCurve] = []
    for file in files:
        if file.is_dir():
            if len(files) > 1:
                raise ProblemError(f"{file} is a map of curves; give no other file with it")
            for name in ("spring_constant", "sensitivity", "leave_out_missing"):
                if options[name]:
                    raise ProblemError(
                        f"--{name.replace('_', '-')}: a stored map has its own forces, and its variable spring_constant"
                    )
            _refuse_segment(file, segment)
            return file
        if is_table(file):
            curves.append(read_segment(file, segment or "record", **options))
            if options["spring_constant"] is not None and curves[-1].spring_constant is None:
                raise ProblemError(
                    f"--spring-constant: not used for {file}, which has indentations and forces; it needs a column of travel"
                )
            continue
        part = segment or ("record" if whole else "approach")
        records = read_prepared_curves(file, segment=part, keep_signs=keep_signs or None, **options)
        if len(records) > 1:
            if len(files) > 1:
                raise ProblemError(f"{file} is a map of {len(records)} curves; give no other file with it")
            return stack_curves(records)
        curves += records
    return curves


def _read_sheared(
    files: Sequence[Path],
    spring_constant: str | None,
    sensitivity: str | None,
    leave_out_missing: bool,
    segment: str | None,
) -> list[xr.Dataset]:
    """Records of tangential force against shift."""
    from pymdr.errors import ProblemError
    from pymdr.workbench.tables import read_record

    if leave_out_missing or any(given is not None for given in (spring_constant, sensitivity, segment)):
        raise ProblemError(
            "--spring-constant, --sensitivity, --leave-out-missing and --segment are for force curves; a case with friction needs tables of "
            "shift, tangential force and load"
        )
    return [read_record(file) for file in files]


def _refuse_segment(file: Path, segment: str | None) -> None:
    from pymdr.errors import ProblemError

    if segment is not None:
        raise ProblemError(
            f"--segment {segment}: not used for {file}, which is fitted completely; leave the option out, or cut the curve first"
        )


def _map(
    contact: Contact,
    curves: xr.Dataset | Path,
    free: Sequence[str],
    options: dict[str, Any],
    output: Path | None,
) -> tuple[FittedMap, list[Path]]:
    """Fit a map, and write it if a folder is given."""
    from pymdr.solving.fits import fit_map

    if output is None:
        return fit_map(contact, curves, free, **options), []
    with ready_folder(output) as folder:
        fitted = fit_map(contact, curves, free, folder=folder / "fit.zarr", **options)
        fitted.to_csv(folder / "fit.csv")
        return fitted, [
            folder / "fit.zarr",
            folder / "fit.csv",
            write_figure(fitted.plot(), folder / "fit.png"),
        ]


def _plain_fit(result: FitResult) -> dict[str, Any]:
    values = {
        name: {"value": v.value, "error": v.error, "low": v.low, "high": v.high, "unit": v.unit}
        for name, v in result.values.items()
    }
    plain = {
        "values": values,
        "noise": result.noise,
        "waves": result.waves,
        "correlated": result.correlated,
        "aicc": result.aicc,
        "calibration": {source: dict(part) for source, part in result.calibration.items()},
    }
    return {"rows": result.data.sizes["step"], "fit": plain}


def _plain_map(fitted: FittedMap) -> dict[str, Any]:
    import numpy as np

    values: dict[str, Any] = {}
    for name in fitted.names if fitted.counts.get("fitted") else ():
        low, middle, high = (float(q) for q in np.nanquantile(fitted.data[name].values, [0.25, 0.5, 0.75]))
        unit = str(fitted.data[name].attrs["units"])
        values[name] = {"median": middle, "low_quartile": low, "high_quartile": high, "unit": unit}
    return {"rows": fitted.data["ending"].size, "fit": {"values": values, "endings": fitted.counts}}
