"""``pymdr fit``: parameters of a contact fitted to measured curves or maps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pymdr.errors import ProblemError
from pymdr.workbench.cli.folders import ready_folder, write_figure, write_report, write_study
from pymdr.workbench.cli.options import (
    CaseFile,
    Cluster,
    FitSegment,
    Groups,
    Json,
    KeepSigns,
    LeaveOut,
    Quiet,
    ReportFile,
    Sensitivity,
    Table,
    Uncertainties,
    at_work,
    with_uncertainty,
)
from pymdr.workbench.cli.reporting import (
    Stage,
    columns_of,
    failures_as_json,
    report_answer,
    stages,
)

if TYPE_CHECKING:
    import xarray as xr

    from pymdr.problem.contact import Contact
    from pymdr.solving.curves import MeasuredCurve
    from pymdr.solving.fits import FitResult, FittedCurves, FittedMap
    from pymdr.solving.workers import Workers
    from pymdr.units import QuantityLike


_NOT_SETTINGS = ("report_file", "workers", "cluster", "output", "quiet", "as_json")
"""Options of a fit that its report does not list."""


def fit(
    case: CaseFile,
    curve: Annotated[
        list[Path],
        typer.Argument(
            metavar="CURVE...",
            help="A table with units of force (or deflection) and travel, height or indentation (with friction: tangential force, shift and load), an AFM "
            "file of one curve or a map, the folder of a Zarr store of a map, or a folder of curves, which are fitted one by one.",
        ),
    ],
    free: Annotated[
        list[str], typer.Option(help="Parameter to fit, such as body.young or tilt; repeatable.")
    ],
    spring_constant: Annotated[
        str | None,
        typer.Option(help="Spring constant if travel was measured, such as '0.1 N/m' or '0.1 N/m +- 10 %'."),
    ] = None,
    sensitivity: Sensitivity = None,
    leave_out_missing: LeaveOut = False,
    contact_point: Annotated[
        str | None, typer.Option(help="Contact point in the record; fitted by default.")
    ] = None,
    shift_origin: Annotated[
        str | None,
        typer.Option(help="With friction: shift of the record at zero tangential force; fitted by default."),
    ] = None,
    baseline: Annotated[
        str | None, typer.Option(help="Force of the record out of contact; fitted by default.")
    ] = None,
    max_indentation: Annotated[
        str | None, typer.Option(help="Largest fitted indentation, such as '500 nm'.")
    ] = None,
    max_force: Annotated[
        str | None, typer.Option(help="Largest fitted force above the baseline, such as '1 nN'.")
    ] = None,
    uncertainty: Uncertainties = None,
    over_indentation: Annotated[
        int | None, typer.Option(min=2, help="Number of growing fit ranges; writes the parameters over them.")
    ] = None,
    segment: FitSegment = None,
    keep_signs: KeepSigns = False,
    groups: Groups = None,
    report_file: ReportFile = None,
    workers: Annotated[
        int, typer.Option(min=1, help="Processes for a map; results do not depend on it.")
    ] = 1,
    cluster: Cluster = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Fit parameters of a contact to measured force curves.

    With -o a table and a figure are written; a map is also stored in DIR/fit.zarr, where an interrupted fit resumes. The curves of a folder are
    fitted one by one, with statistics of the samples.
    """
    given = {"records" if name == "curve" else name: value for name, value in locals().items()}
    settings = {name: value for name, value in given.items() if name not in _NOT_SETTINGS}
    from pymdr.workbench.casefile import read_contact

    with failures_as_json("fit", case, as_json):
        title, contact = read_contact(case)
        with stages(quiet or as_json) as stage, at_work(workers, cluster) as workforce:
            fitted, written = _fitted(contact, curve, free, settings, workforce, stage, output)
        written += write_report(fitted, report_file, title or f"Fit of {case.stem}", settings)
    report_answer("fit", case, title, fitted, written, quiet, as_json, lambda: _plain(fitted))


def _fitted(
    contact: Contact,
    files: Sequence[Path],
    free: Sequence[str],
    settings: dict[str, Any],
    workers: Workers,
    stage: Stage,
    output: Path | None,
) -> tuple[FitResult | FittedMap | FittedCurves, list[Path]]:
    """Fit what the files hold: records that share the parameters, a folder of records, or a map."""
    from pymdr.solving.fits import fit as fit_curves
    from pymdr.workbench.folders import is_zarr

    origins = {name: settings[name] for name in ("contact_point", "shift_origin", "baseline")}
    ranges = {"indentation": settings["max_indentation"], "force": settings["max_force"]}
    calibration, uncertainty = _calibration(settings)
    options: dict[str, Any] = {
        "fit_range": {name: limit for name, limit in ranges.items() if limit is not None} or None,
        "uncertainty": uncertainty or None,
    }
    reading = {**calibration, "leave_out_missing": settings["leave_out_missing"]}
    is_folder = len(files) == 1 and files[0].is_dir() and not is_zarr(files[0])
    if settings["groups"] is not None and not is_folder:
        raise ProblemError("--groups is for a folder of curves; give the folder in place of the files")
    if is_folder:
        if workers != 1:
            option = f"--workers {workers}" if isinstance(workers, int) else "--cluster"
            raise ProblemError(f"{option} is for a map; the curves of a folder are fitted in one process")
        if contact.friction is not None or settings["over_indentation"] is not None:
            raise ProblemError(
                "a folder is for force curves of contacts without friction, and without --over-indentation; give one file"
            )
        del origins["shift_origin"]
        return _each(contact, files[0], free, settings, reading, {**origins, **options}, stage, output)
    curves = (
        _read(
            files,
            reading,
            settings["segment"],
            contact.adhesion is not None or contact.is_viscoelastic,
            keep_signs=settings["keep_signs"],
        )
        if contact.friction is None
        else _read_sheared(files, settings)
    )
    if isinstance(curves, list):
        fitted = fit_curves(contact, curves, free, **origins, **options)
        written = write_study(fitted, output, "fit")
        if settings["over_indentation"] is not None:
            written += _over_indentation(contact, curves, free, origins, settings["over_indentation"], output)
        return fitted, written
    if settings["over_indentation"] is not None:
        raise ProblemError("--over-indentation is for single records; fit one curve of the map")
    if origins.pop("shift_origin") is not None:
        raise ProblemError("--shift-origin needs a case with friction; use --contact-point for force curves")
    chosen = {**origins, **options, "workers": workers, "progress": stage("fitting")}
    return _map(contact, curves, free, chosen, output)


def _each(
    contact: Contact,
    folder: Path,
    free: Sequence[str],
    settings: dict[str, Any],
    reading: dict[str, Any],
    options: dict[str, Any],
    stage: Stage,
    output: Path | None,
) -> tuple[FittedCurves, list[Path]]:
    """Fit the records of a folder one by one."""
    from pymdr.solving.fits import fit_each
    from pymdr.workbench.folders import read_curve_folder

    if output is not None and folder.resolve() in (output.resolve(), *output.resolve().parents):
        raise ProblemError(
            f"-o {output} is in the folder of the records; choose another folder, so that the next run does not read it"
        )
    read = read_curve_folder(
        folder,
        groups=settings["groups"],
        segment=settings["segment"],
        whole=contact.adhesion is not None or contact.is_viscoelastic,
        keep_signs=settings["keep_signs"] or None,
        **reading,
    )
    progress = stage("fitting")
    fitted = fit_each(
        contact, read.curves, free, groups=read.groups, excluded=read.excluded, progress=progress, **options
    )
    written = write_study(fitted, output, "fit")
    if output is not None:
        for name, study in fitted.statistics.items():
            study.to_csv(output / f"groups_{name}.csv")
            written.append(output / f"groups_{name}.csv")
    return fitted, written


def _calibration(settings: dict[str, Any]) -> tuple[dict[str, str | None], dict[str, QuantityLike]]:
    """Spring constant and sensitivity, and standard uncertainties by name: theirs, and those of --uncertainty."""
    from pymdr.solving.fits.calibrations import SENSITIVITY, SPRING_CONSTANT, relative_uncertainty
    from pymdr.workbench.readers.record import calibration_of

    values: dict[str, str | None] = {SPRING_CONSTANT: None, SENSITIVITY: None}
    by_name: dict[str, QuantityLike] = {}
    for name in values:
        if settings[name] is not None:
            values[name], own = with_uncertainty(settings[name])
            if own is not None:
                by_name[name] = own
    if SENSITIVITY in by_name:  # records do not keep their sensitivity, so that it becomes relative here
        known = calibration_of(None, values[SENSITIVITY])
        assert known.sensitivity is not None
        by_name[SENSITIVITY] = relative_uncertainty(
            by_name[SENSITIVITY], known.sensitivity, known.sensitivity_unit, SENSITIVITY
        )
    for text in settings["uncertainty"] or ():
        name, sign, value = (part.strip() for part in text.partition("="))
        if not sign or not name or not value or name in by_name:
            raise ProblemError(
                f"--uncertainty {text}: write each name once, with a value, such as --uncertainty 'profile.radius=5 %'"
            )
        by_name[name] = value
    return values, by_name


def _over_indentation(
    contact: Contact,
    curves: Sequence[Any],
    free: Sequence[str],
    origins: dict[str, str | None],
    steps: int,
    output: Path | None,
) -> list[Path]:
    """Fit growing ranges of one curve; print them, or write them into a folder."""
    from pymdr.solving.fits import fit_over_indentation

    if len(curves) != 1 or output is None:
        raise ProblemError(
            "--over-indentation needs one curve, and a folder for its table and figure: -o DIR"
        )
    known = {name: origins[name] for name in ("contact_point", "baseline")}
    study = fit_over_indentation(contact, curves[0], free, steps=steps, **known)
    return write_study(study, output, "over_indentation")


def _read(
    files: Sequence[Path], options: dict[str, Any], segment: str | None, whole: bool, *, keep_signs: bool
) -> list[MeasuredCurve] | xr.Dataset | Path:
    """Curves of one contact, or a map as a dataset or the folder of its store."""
    from pymdr.workbench.curves import read_fittable_curves, stack_curves

    curves: list[MeasuredCurve] = []
    for file in files:
        if file.is_dir():
            if len(files) > 1:
                raise ProblemError(f"{file} is a map of curves; give no other file with it")
            for name in ("spring_constant", "sensitivity", "leave_out_missing"):
                if options[name]:
                    raise ProblemError(
                        f"--{name.replace('_', '-')}: a stored map has its own forces, and its variable spring_constant; leave the option out"
                    )
            _refuse_segment(file, segment)
            return file
        records = read_fittable_curves(file, segment, whole=whole, keep_signs=keep_signs or None, **options)
        if len(records) > 1:
            if len(files) > 1:
                raise ProblemError(f"{file} is a map of {len(records)} curves; give no other file with it")
            return stack_curves(records)
        curves += records
    return curves


def _read_sheared(files: Sequence[Path], settings: dict[str, Any]) -> list[xr.Dataset]:
    """Records of tangential force against shift."""
    from pymdr.workbench.tables import read_record

    if any(settings[name] for name in ("spring_constant", "sensitivity", "leave_out_missing", "segment")):
        raise ProblemError(
            "--spring-constant, --sensitivity, --leave-out-missing and --segment are for force curves; a case with friction needs tables of "
            "shift, tangential force and load"
        )
    return [read_record(file) for file in files]


def _refuse_segment(file: Path, segment: str | None) -> None:
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


def _plain(fitted: FitResult | FittedMap | FittedCurves) -> dict[str, Any]:
    """References, rows and values for JSON."""
    from pymdr.solving.fits import FittedCurves, FittedMap

    if isinstance(fitted, FittedMap):
        plain = _plain_map(fitted)
    else:
        plain = _plain_each(fitted) if isinstance(fitted, FittedCurves) else _plain_fit(fitted)
    return {"references": list(fitted.cite()), **plain}


def _plain_each(fitted: FittedCurves) -> dict[str, Any]:
    groups = {name: columns_of(study) for name, study in fitted.statistics.items()}
    return {"rows": fitted.data.sizes["curve"], "fit": {"curves": columns_of(fitted), "groups": groups}}


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
        "quality": None
        if result.quality is None
        else {**result.quality._asdict(), "good": not result.quality.faults()},
        "calibration": {source: dict(part) for source, part in result.calibration.items()},
    }
    return {"rows": result.data.sizes["step"], "fit": plain}


def _plain_map(fitted: FittedMap) -> dict[str, Any]:
    import numpy as np

    from pymdr.solving.fits.request import SYSTEMATIC

    values: dict[str, Any] = {}
    for name in fitted.names if fitted.counts.get("fitted") else ():
        low, middle, high = (float(q) for q in np.nanquantile(fitted.data[name].values, [0.25, 0.5, 0.75]))
        unit = str(fitted.data[name].attrs["units"])
        values[name] = {"median": middle, "low_quartile": low, "high_quartile": high, "unit": unit}
        for key, end in (("median_error", "_error"), ("median_systematic", SYSTEMATIC)):
            if f"{name}{end}" in fitted.data:
                values[name][key] = float(np.nanmedian(fitted.data[f"{name}{end}"].values))
    return {"rows": fitted.data["ending"].size, "fit": {"values": values, "endings": fitted.counts}}
