"""``pymdr run``, ``check`` and ``plot``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pymdr.errors import PymdrError, QuantityError
from pymdr.workbench.cli.folders import (
    Tables,
    folders_of,
    ready_folder,
    write_figure,
    write_figures,
    write_stress,
    write_study,
)
from pymdr.workbench.cli.machines import check_machine
from pymdr.workbench.cli.options import CaseFile, Json, Output, Quiet
from pymdr.workbench.cli.reporting import (
    FAILED,
    REFUSALS,
    REFUSED,
    columns_of,
    failure_report,
    failures_as_json,
    print_error,
    print_json,
    print_report,
    print_text,
    report,
    report_written,
    stages,
    validity_of,
    with_unit,
)
from pymdr.workbench.cli.wording import error_text

if TYPE_CHECKING:
    from pymdr.workbench.casefile import Case

_LARGE = 50_000_000
_PICTURES = (".png", ".pdf", ".svg")


def run(
    cases: Annotated[list[Path], typer.Argument(metavar="CASE.toml...", help="One or several case files.")],
    output: Output = None,
    csv: Annotated[bool, typer.Option("--csv", help="Write result.csv too.")] = False,
    xlsx: Annotated[bool, typer.Option("--xlsx", help="Write result.xlsx too.")] = False,
    no_figures: Annotated[bool, typer.Option("--no-figures", help="Write no figures.")] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Solve cases; write result.nc and figures; print the summary.

    Each of several cases has its own folder; a failure does not stop the others. The exit status is 1 if a case failed,
    else 3 if the method refuses one.
    """
    tables = Tables(csv, xlsx)
    with failures_as_json("run", cases, as_json):
        tables.check()
        folders = folders_of(cases, output)
    reports: list[dict[str, Any]] = []
    failures: dict[Path, str] = {}
    for case, folder in folders.items():
        try:
            reports.append(_run_one(case, folder, tables, not no_figures, quiet, as_json))
        except (PymdrError, MemoryError) as error:
            failures[case] = error_text(error)
            reports.append(failure_report("run", case, error))
            if len(folders) == 1 and not as_json:
                raise
    if as_json:
        print_json(reports[0] if len(folders) == 1 else reports)
    if len(folders) == 1:
        for message in failures.values():
            print_error(message)
    elif failures:
        _print_failures(list(folders), failures)
    statuses = {single["status"] for single in reports}
    if "FAILED" in statuses or not statuses.isdisjoint(REFUSALS):
        raise typer.Exit(FAILED if "FAILED" in statuses else REFUSED)


def _run_one(
    case: Path, folder: Path, tables: Tables, figures: bool, quiet: bool, as_json: bool
) -> dict[str, Any]:
    """Solve a case and write its files; the JSON report, or its status alone."""
    import logging

    import numpy as np

    from pymdr.result.arrays import by_component
    from pymdr.solving.verb import solve
    from pymdr.workbench.case_studies import contact_studies, fatigue_of
    from pymdr.workbench.casefile import read_case

    problem = read_case(case)
    if quiet:
        logging.getLogger("pymdr").setLevel(logging.ERROR)
    studies = contact_studies(problem)
    with ready_folder(folder), stages(quiet or as_json) as stage:
        if not quiet and not as_json:
            _warn_of_memory(problem)
        result = solve(problem.contact, problem.path, progress=stage("solving"), **problem.options)
        result.save(folder / "result.nc")
        written = [folder / "result.nc", *tables.write(result, folder, "result")]
        if figures:
            written += write_figures(result.figures(), folder, stage("drawing"))
        if result.status.name not in REFUSALS:
            if "stress" in problem.outputs:
                written += write_stress(result, problem.outputs["stress"], folder, figures)
            if "fatigue" in problem.outputs:
                studies["fatigue"] = fatigue_of(problem, result)
        for name, study in studies.items():
            written += write_study(study, folder, name, figures)
    if not as_json:
        if result.status.name in REFUSALS:
            print_error(f"{case}: {result.status.name}: {result.status.value}")
        if not quiet:
            summaries = [f"{name.replace('_', ' ')}:\n{study.summary()}" for name, study in studies.items()]
            print_report(problem.title or str(case), "\n".join([result.summary(), *summaries]), written)
        return {"status": result.status.name}
    return report(
        "run",
        case,
        written,
        title=problem.title,
        status=result.status.name,
        rows=result.data.sizes["step"],
        last={
            str(name): with_unit(float(array.values[-1]), array.attrs["units"])
            for name, array in by_component(result.data).items()
        },
        largest={
            name: with_unit(float(np.fmax.reduce(result.data[name].values)), result.data[name].attrs["units"])
            for name in ("indentation", "normal_force", "contact_radius")
            if name in result.data
        },
        **({"studies": {name: columns_of(study) for name, study in studies.items()}} if studies else {}),
        references=list(result.cite()),
        **validity_of(result),
    )


def _warn_of_memory(case: Case) -> None:
    """Print the memory that a long path needs before it is solved."""
    from pymdr.presentation.text import bytes_text
    from pymdr.problem.schedule import total_rows
    from pymdr.solving.verb import bytes_of

    rows = total_rows(case.path)
    keep = int(case.options.get("keep") or 1)
    if bytes_of(rows, keep) > _LARGE:
        print_error(
            f"{rows} rows, {rows // keep} of them kept, need about {bytes_text(bytes_of(rows, keep))}; with friction, "
            "[solve] keep = k keeps every k-th row"
        )


def _print_failures(cases: Sequence[Path], failures: Mapping[Path, str]) -> None:
    print_error(f"{len(failures)} of {len(cases)} cases failed")
    for case in cases:
        if case in failures:
            print_error(f"{case}: {failures[case]}".replace(f"{case}: {case}", str(case), 1))


def check(case: CaseFile, quiet: Quiet = False, as_json: Json = False) -> None:
    """Validate a case and print its claims; write nothing."""
    from pymdr.quantities import quantity
    from pymdr.solving.assessing import assess
    from pymdr.workbench.casefile import has_table, read_case

    with failures_as_json("check", case, as_json):
        for table, checked in (("machine", check_machine), ("surface", _check_surface)):
            if has_table(case, table):
                checked(case, quiet, as_json)
                return
        problem = read_case(case)
        assessment = assess(problem.contact, problem.path, **problem.options)
    status = assessment.status.name
    if as_json:
        plain = report(
            "check",
            case,
            title=problem.title,
            status=status,
            rows=assessment.rows,
            memory=assessment.memory,
            largest={
                name: with_unit(value, quantity(name).unit) for name, value in assessment.largest.items()
            },
            **validity_of(assessment),
        )
        print_json(plain)
    elif not quiet:
        print_text(problem.title or f"{case} is a valid case.")
        print_text(assessment.summary())
    if status in REFUSALS:
        if not as_json:
            print_error(f"{case}: {status}: {assessment.status.value}")
        raise typer.Exit(REFUSED)


def _check_surface(case: Path, quiet: bool, as_json: bool) -> None:
    """Validate a case of a rough surface, which commands of their own solve."""
    from pymdr.workbench.casefile import has_table, read_press_case, read_rough_case

    is_ball = has_table(case, "ball")
    title = read_rough_case(case).title if is_ball else read_press_case(case)[0].title
    if as_json:
        print_json(report("check", case, title=title, status="COMPLETED", rows=0))
    elif not quiet:
        print_text(title or f"{case} is a valid case.")
        verbs = (
            "pymdr rough solves it" if is_ball else "pymdr press solves it, and pymdr rough if it is random"
        )
        print_text(f"A rough surface; {verbs}.")


def plot(
    result_file: Annotated[
        Path, typer.Argument(metavar="RESULT", help="Result file of pymdr run, or its folder.")
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="DIR|FILE",
            help="Folder for all figures, or a file (.png, .pdf, .svg) for the overview.",
        ),
    ] = None,
    step: Annotated[int, typer.Option(help="Row to draw, counted from 0; -1 is the last.")] = -1,
    stress: Annotated[
        bool, typer.Option("--stress", help="Draw the stress inside the bodies instead, as stress.png.")
    ] = False,
    animate: Annotated[
        bool, typer.Option("--animate", help="With --stress: write stress.gif along the path too.")
    ] = False,
    measure: Annotated[
        str, typer.Option(help="With --stress: von_mises, tresca, principal_stress or hydrostatic.")
    ] = "von_mises",
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Draw the figures of a saved result."""
    from pymdr.solving.reopening import open_result

    with failures_as_json("plot", result_file, as_json):
        if (animate or measure != "von_mises") and not stress:
            raise QuantityError("--animate and --measure are for the stress inside the bodies; add --stress")
        result, own = open_result(result_file), result_file if result_file.is_dir() else result_file.parent
        picture = output is not None and output.suffix.lower() in _PICTURES and not output.is_dir()
        place = output.parent if output is not None and picture else output or own
        with ready_folder(place) as folder, stages(quiet or as_json) as stage:
            if stress:
                file = output if output is not None and picture else folder / "stress.png"
                written = [write_figure(result.plot_stress(step, name=measure), file)]
                if animate:
                    result.animate_stress(file.with_suffix(".gif"), name=measure)
                    written.append(file.with_suffix(".gif"))
            elif output is not None and picture:
                written = [write_figure(result.plot(step=step), output)]
            else:
                written = write_figures(result.figures(step), folder, stage("drawing"))
    report_written("plot", result_file, result, written, quiet, as_json)
