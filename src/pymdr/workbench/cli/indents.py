"""``pymdr nanoindent``, ``drift``, ``stiffness`` and ``pop-in``: records of nanoindenters."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pymdr.errors import ProblemError
from pymdr.workbench.cli.folders import write_report, write_study
from pymdr.workbench.cli.options import Json, Quiet, ReportFile, Table, with_uncertainty
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

    from pymdr.problem.materials import Elastic, Rigid
    from pymdr.problem.profiles import AreaFunction
    from pymdr.solving.nanoindentation import ThermalDrift
    from pymdr.solving.nanoindentation.calibrating import AreaCalibration
    from pymdr.solving.nanoindentation.records import Records
    from pymdr.solving.study import Study

IndentFiles = Annotated[
    list[Path],
    typer.Argument(
        metavar="RECORD...",
        help="Files of a nanoindenter (.hld, .xls, .xlsx, text), or tables of load and depth with units.",
    ),
]
Area = Annotated[
    str | None,
    typer.Option(
        help="Coefficients C0 C1 ... of the area function: '24.5 900'; by default those of the files."
    ),
]
AreaUnit = Annotated[str, typer.Option(help="Unit of length of the coefficients.")]
AreaTable = Annotated[
    Path | None, typer.Option(help="Instead of coefficients: CSV of contact depth and area.")
]
Reference = Annotated[
    list[str] | None, typer.Option(help="Indent in fused silica, to calibrate area and frame; repeatable.")
]
Terms = Annotated[int, typer.Option(help="Number of coefficients of the calibrated area function.")]
Frame = Annotated[str | None, typer.Option(help="Compliance of the frame, such as '0.3 nm/mN'.")]
TipYoung = Annotated[str, typer.Option(help="Young's modulus of the tip.")]
TipPoisson = Annotated[float, typer.Option(help="Poisson's ratio of the tip.")]
Poisson = Annotated[float | None, typer.Option(help="Poisson's ratio of the sample.")]
Beta = Annotated[float, typer.Option(help="Beta of the power law; 1.034 for Berkovich tips.")]
Drift = Annotated[bool, typer.Option("--drift", help="Subtract the thermal drift measured in a hold.")]
Hold = Annotated[
    str | None, typer.Option(help="Start and end of the hold, such as '60 s to 90 s'; detected by default.")
]
Settle = Annotated[float, typer.Option(help="Fraction of the hold left out at its start.")]


def nanoindent(
    records: IndentFiles,
    area: Area = None,
    area_unit: AreaUnit = "1 nm",
    area_table: AreaTable = None,
    reference: Reference = None,
    terms: Terms = 3,
    frame_compliance: Frame = None,
    tip_young: TipYoung = "1141 GPa",
    tip_poisson: TipPoisson = 0.07,
    poisson: Poisson = None,
    beta: Beta = 1.0,
    epsilon: Annotated[
        float, typer.Option(help="Epsilon of the method; 0 derives it from the fitted exponent.")
    ] = 0.75,
    fit_from: Annotated[float, typer.Option(help="Smallest fitted force over the largest force.")] = 0.25,
    fit_to: Annotated[float, typer.Option(help="Largest fitted force over the largest force.")] = 0.98,
    drift: Drift = False,
    hold: Hold = None,
    output: Table = None,
    report_file: ReportFile = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Hardness and modulus of indents from their unloading."""
    settings = dict(locals())
    from pymdr.problem.materials import Elastic
    from pymdr.solving.nanoindentation import oliver_pharr

    def studies() -> list[tuple[str, Study]]:
        tip = Elastic(tip_young, tip_poisson)
        procedure: dict[str, Any] = {
            "beta": beta, "epsilon": epsilon or None, "fit_range": (fit_from, fit_to), "tip": tip
        }  # fmt: skip
        known = _calibrated(settings, procedure)
        read = _read(records)
        first, indents = _corrected(read, drift, hold)
        used_area = known or _area_function(area, area_unit, area_table, read)
        compliance = None if known else frame_compliance
        study = oliver_pharr(indents, used_area, frame_compliance=compliance, poisson=poisson, **procedure)
        return [*_named("area", known), *first, ("nanoindent", study)]

    _report("nanoindent", records, studies, settings)


def drift(
    records: IndentFiles,
    hold: Hold = None,
    settle: Settle = 0.2,
    output: Table = None,
    report_file: ReportFile = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Thermal drift of indents from a hold at constant force."""
    settings = dict(locals())
    _report("drift", records, lambda: [("drift", _drift(_read(records), hold, settle))], settings)


def stiffness(
    records: IndentFiles,
    area: Area = None,
    area_unit: AreaUnit = "1 nm",
    area_table: AreaTable = None,
    reference: Reference = None,
    terms: Terms = 3,
    frame_compliance: Frame = None,
    tip_young: TipYoung = "1141 GPa",
    tip_poisson: TipPoisson = 0.07,
    poisson: Poisson = None,
    beta: Beta = 1.0,
    epsilon: Annotated[float, typer.Option(help="Epsilon of the method, (h - h_c) S/F.")] = 0.75,
    points: Annotated[int, typer.Option(help="Number of depths.")] = 40,
    drift: Drift = False,
    hold: Hold = None,
    film_thickness: Annotated[
        str | None,
        typer.Option(
            help="Thickness of a film, such as '500 nm' or '500 nm +- 10 nm': its modulus is fitted."
        ),
    ] = None,
    substrate: Annotated[
        str | None,
        typer.Option(help="Young's modulus and Poisson's ratio of the substrate, '165 GPa, 0.22'; or rigid."),
    ] = None,
    widths: Annotated[str, typer.Option(help="Range of contact radius over film thickness to fit.")] = "0 3",
    output: Table = None,
    report_file: ReportFile = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Hardness and modulus over depth, and the modulus of a film."""
    settings = dict(locals())
    from pymdr.problem.materials import Elastic
    from pymdr.solving.nanoindentation import continuous_stiffness, film_modulus

    def studies() -> list[tuple[str, Study]]:
        if (film_thickness is None) != (substrate is None):
            raise ProblemError("a film needs both --film-thickness '500 nm' and --substrate '165 GPa, 0.22'")
        tip = Elastic(tip_young, tip_poisson)
        known = _calibrated(settings, {"beta": beta, "epsilon": epsilon, "tip": tip})
        read = _read(records)
        first, indents = _corrected(read, drift, hold)
        profile = continuous_stiffness(
            indents,
            known or _area_function(area, area_unit, area_table, read),
            frame_compliance=None if known else frame_compliance,
            tip=tip,
            poisson=poisson,
            beta=beta,
            epsilon=epsilon,
            points=points,
        )
        made = [*_named("area", known), *first, ("continuous_stiffness", profile)]
        if film_thickness is not None and substrate is not None:
            value, error = with_uncertainty(film_thickness)
            base, spread, fitted = _substrate(substrate), error or 0.0, _numbers("widths", widths, "0 3")
            film = film_modulus(profile, value, base, thickness_error=spread, widths=fitted)
            made.append(("film", film))
        return made

    _report("stiffness", records, studies, settings)


def pop_in(
    records: IndentFiles,
    radius: Annotated[
        str | None, typer.Option(help="Radius of the round tip, for the shear stress, such as '1 um'.")
    ] = None,
    young: Annotated[str | None, typer.Option(help="Young's modulus of the sample.")] = None,
    poisson: Poisson = None,
    tip_young: TipYoung = "1141 GPa",
    tip_poisson: TipPoisson = 0.07,
    shear_strength: Annotated[
        str | None, typer.Option(help="Shear strength, such as '5 GPa'; gives the load that reaches it.")
    ] = None,
    significance: Annotated[
        float, typer.Option(help="Smallest pop-in that counts, in standard deviations.")
    ] = 6.0,
    output: Table = None,
    report_file: ReportFile = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """First pop-in of indents, and the shear stress at its load."""
    settings = dict(locals())
    from pymdr.problem.contact import Contact
    from pymdr.problem.materials import Elastic
    from pymdr.problem.profiles import Sphere
    from pymdr.solving.nanoindentation import first_pop_in

    def studies() -> list[tuple[str, Study]]:
        contact, given = None, (radius, young, poisson)
        if radius is not None and young is not None and poisson is not None:
            contact = Contact(Sphere(radius), Elastic(young, poisson), Elastic(tip_young, tip_poisson))
        elif any(one is not None for one in given):
            raise ProblemError(
                "the shear stress needs all of --radius '1 um', --young '70 GPa' and --poisson 0.17"
            )
        study = first_pop_in(
            _read(records), contact, shear_strength=shear_strength, significance=significance
        )
        return [("pop_in", study)]

    _report("pop-in", records, studies, settings)


def _report(
    command: str,
    records: Sequence[Path],
    make: Callable[[], list[tuple[str, Study]]],
    settings: dict[str, Any],
) -> None:
    """Make studies, write them, and report the last one; the text has all."""
    title = ", ".join(map(str, records))
    outputs = ("output", "report_file", "quiet", "as_json")
    with failures_as_json(command, records[0], settings["as_json"]):
        studies = make()
        written = [file for name, study in studies for file in write_study(study, settings["output"], name)]
        study = studies[-1][1]
        own = {name: value for name, value in settings.items() if name not in outputs}
        written += write_report(study, settings["report_file"], f"{command}: {title}", own)
    if settings["as_json"]:
        plain = report(
            command,
            records[0],
            written,
            status="COMPLETED",
            rows=next(iter(study.data.sizes.values())),
            study=columns_of(study),
            preceding_studies={name: columns_of(one) for name, one in studies[:-1]} or None,
            references=list(study.cite()),
            **validity_of(study),
        )
        print_json(plain)
    elif not settings["quiet"]:
        print_report(title, "\n".join(study.summary() for _, study in studies), written)


def _named(name: str, study: Study | None) -> list[tuple[str, Study]]:
    return [] if study is None else [(name, study)]


def _calibrated(settings: dict[str, Any], procedure: dict[str, Any]) -> AreaCalibration | None:
    """The calibration by indents in fused silica, if they are given."""
    from pymdr.solving.nanoindentation import calibrate_area

    if not settings["reference"]:
        return None
    if settings["area"] is not None or settings["area_table"] is not None:
        raise ProblemError("give one of --area, --area-table and --reference")
    return calibrate_area(
        _read([Path(file) for file in settings["reference"]]),
        terms=settings["terms"],
        frame_compliance=settings["frame_compliance"],
        **procedure,
    )


def _corrected(
    indents: list[xr.Dataset], with_drift: bool, hold: str | None
) -> tuple[list[tuple[str, Study]], Records]:
    """The records, without their drift if that is wanted, and its study."""
    if not with_drift:
        if hold is not None:
            raise ProblemError("--hold is for --drift; give both")
        return [], indents
    corrected = _drift(indents, hold)
    return [("drift", corrected)], corrected


def _drift(indents: list[xr.Dataset], hold: str | None, settle: float = 0.2) -> ThermalDrift:
    from pymdr.solving.nanoindentation import thermal_drift

    ends = None if hold is None else [part.strip() for part in hold.split(" to ")]
    if ends is not None and len(ends) != 2:
        raise ProblemError(f"--hold {hold!r}: write its start and end, such as '60 s to 90 s'")
    return thermal_drift(indents, hold=ends, settle=settle)


def _read(files: Sequence[Path]) -> list[xr.Dataset]:
    """The indents of files of an instrument, and the records of tables."""
    from pymdr.workbench.indents import read_indents

    return [record for file in files for record in read_indents(file)]


def _substrate(text: str) -> Elastic | Rigid:
    from pymdr.problem.materials import Elastic, Rigid

    if text.strip().lower() == "rigid":
        return Rigid()
    young, comma, poisson = text.rpartition(",")
    if not comma:
        raise ProblemError(
            f"--substrate {text!r}: write Young's modulus and Poisson's ratio, such as '165 GPa, 0.22', or rigid"
        )
    return Elastic(young.strip(), poisson.strip())


def _numbers(option: str, text: str, example: str) -> list[float]:
    try:
        return [float(value) for value in re.split(r",?\s+", text.strip())]
    except ValueError:
        raise ProblemError(
            f"--{option} {text!r}: numbers are needed, with decimal points and blanks between them, such as '{example}'"
        ) from None


def _area_function(
    area: str | None, unit: str, table: Path | None, indents: Sequence[xr.Dataset]
) -> AreaFunction:
    """The area function of the options, or else of the files."""
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
    return AreaFunction(_numbers("area", area, "24.5 900"), unit=unit)
