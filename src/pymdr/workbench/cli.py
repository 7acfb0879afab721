"""The command line: ``pymdr run``, ``check``, ``verify``, ``plot``, ``new``, ``schema`` and ``info``.

Every command body imports what it needs, so that ``pymdr --help`` stays quick.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pymdr.interpretation.validity import Assumption, Claim
    from pymdr.result import Result
    from pymdr.workbench.casefile import Case

app = typer.Typer(
    help="Contacts by the Method of Dimensionality Reduction: exact where the theory is, honest where it is not.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    add_completion=True,
)

OK, FAILED, WRONG_USE = 0, 1, 2

CaseFile = Annotated[Path, typer.Argument(metavar="CASE.toml", help="The case file.")]
CaseFiles = Annotated[list[Path], typer.Argument(metavar="CASE.toml...", help="One case file or several.")]
Output = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", metavar="DIR", help="Folder for result.nc and the figures; CASE unless given."
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of the summary.")]


def main() -> None:
    """Run the command line; errors of pymdr become one line and exit status 1."""
    from pymdr.errors import PymdrError

    try:
        app()
    except PymdrError as error:
        typer.echo(f"pymdr: {error}", err=True)
        raise SystemExit(FAILED) from None


@app.callback(invoke_without_command=True)
def version_option(
    show: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
) -> None:
    """Options that need no command."""
    if show:
        import pymdr

        typer.echo(f"pymdr {pymdr.__version__}")
        raise typer.Exit(OK)


@app.command()
def run(cases: CaseFiles, output: Output = None, quiet: Quiet = False, as_json: Json = False) -> None:
    """Solve cases; write result.nc and figures; print the summary.

    Several cases write into one folder each; one that fails does not stop the others.
    """
    if len(cases) == 1:
        told = _run_one(cases[0], output or cases[0].with_suffix(""), quiet, as_json)
        if as_json:
            typer.echo(json.dumps(told, indent=2))
        return
    from pymdr.errors import PymdrError

    failures: dict[Path, str] = {}
    answers = []
    for case in cases:
        folder = output / case.stem if output else case.with_suffix("")
        try:
            answers.append(_run_one(case, folder, quiet, as_json))
        except PymdrError as error:
            failures[case] = str(error)
            answers.append({"case": str(case), "error": str(error)})
    if as_json:
        typer.echo(json.dumps(answers, indent=2))
    if failures:
        _print_failures(cases, failures)
        raise typer.Exit(FAILED)


def _run_one(case: Path, folder: Path, quiet: bool, as_json: bool) -> dict[str, Any]:
    from pymdr.solving import solve
    from pymdr.workbench.casefile import read_case

    asked = read_case(case)
    with _ready_folder(folder):
        if not quiet and not as_json:
            _tell_memory(asked)
        result = solve(asked.contact, asked.path, progress=_progress(quiet or as_json), **asked.options)
        result.save(folder / "result.nc")
        written = [folder / "result.nc", *_write_figures(result.figures(), folder)]
    if not quiet and not as_json:
        typer.echo(asked.title or str(case))
        typer.echo(result.summary())
        typer.echo("Written: " + ", ".join(str(file) for file in written))
    return _as_json(asked, result, written)


_LARGE = 50_000_000


def _tell_memory(case: Case) -> None:
    """Say what a long history will take before it is followed."""
    from pymdr.presentation.text import in_bytes
    from pymdr.problem.schedule import total_rows

    rows = total_rows(case.path)
    kept = rows // int(case.options.get("keep") or 1)
    if 13 * 8 * kept > _LARGE:
        typer.echo(
            f"{rows} rows, of which {kept} are kept, take about {in_bytes(13 * 8 * kept)}, and twice that while they are solved; [solve] keep = k keeps "
            "every k-th",
            err=True,
        )


def _print_failures(cases: Sequence[Path], failures: Mapping[Path, str]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table("case", "ended", title=f"{len(failures)} of {len(cases)} cases failed")
    for case in cases:
        table.add_row(str(case), failures.get(case, "written"))
    Console(stderr=True).print(table)


@app.command()
def new(
    kind: Annotated[
        str,
        typer.Argument(help="ball, cone, punch, tip (measured), gel (adhesion), joint (friction) or cycle."),
    ] = "ball",
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="CASE.toml", help="File to write; printed unless given."),
    ] = None,
) -> None:
    """Write a commented case to start from."""
    from pymdr.presentation.files import write_whole
    from pymdr.workbench.templates import template

    text = template(kind)
    if output is None:
        typer.echo(text, nl=False)
        return
    from pymdr.errors import FileError

    if output.exists():
        raise FileError(f"{output} exists already; name another file with -o")
    write_whole(output, lambda beside: beside.write_text(text, encoding="utf-8"))


@app.command()
def schema() -> None:
    """Print the JSON schema of case files, for editors."""
    from pymdr.problem.codec import case_adapter

    plain = case_adapter().json_schema()
    typer.echo(json.dumps({"$schema": "https://json-schema.org/draft/2020-12/schema", **plain}, indent=2))


@app.command()
def info() -> None:
    """Print versions of pymdr and what it stands on, for bug reports."""
    import platform
    from importlib.metadata import PackageNotFoundError, version

    typer.echo(
        f"pymdr {version('pymdr')}\nPython {platform.python_version()} on {platform.system()} {platform.machine()}"
    )
    for name in (
        "numpy",
        "scipy",
        "xarray",
        "h5netcdf",
        "h5py",
        "pandas",
        "pint",
        "pydantic",
        "matplotlib",
        "numba",
        "typer",
        "rich",
    ):
        try:
            typer.echo(f"{name} {version(name)}")
        except PackageNotFoundError:
            typer.echo(f"{name} is missing")


@app.command()
def check(case: CaseFile, quiet: Quiet = False, as_json: Json = False) -> None:
    """Validate a case and print what can be claimed of it; nothing is written."""
    from pymdr.solving import assess
    from pymdr.workbench.casefile import read_case

    asked = read_case(case)
    assessment = assess(asked.contact, asked.path, **asked.options)
    if as_json:
        typer.echo(
            json.dumps(
                {
                    "case": str(case),
                    "rows": assessment.rows,
                    "memory": assessment.memory,
                    "largest": assessment.largest,
                    "claims": _plain_claims(assessment.claims),
                    "assumptions": _plain_assumptions(assessment.assumptions),
                    "notes": list(assessment.notes),
                },
                indent=2,
            )
        )
    elif not quiet:
        typer.echo(asked.title or f"{case} is a valid case.")
        typer.echo(assessment.summary())


@app.command()
def verify(
    case: CaseFile,
    output: Output = None,
    rings: Annotated[int, typer.Option(help="Number of rings, 20 to 5000.")] = 400,
    cells: Annotated[int, typer.Option(help="With friction: cells along a side of the grid, 8 to 80.")] = 32,
    steps: Annotated[
        int | None, typer.Option(help="How many steps of the path are solved by both; 5, with friction 20.")
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Hold the method against boundary elements: on rings, and with friction on a grid; draw both."""
    from pymdr.workbench.casefile import read_case
    from pymdr.workbench.verification import verify as hold_against_rings

    asked = read_case(case)
    if asked.contact.friction is not None:
        _verify_sliding(asked, output or case.with_suffix(""), cells, steps or 20, quiet, as_json)
        return
    with _ready_folder(output or case.with_suffix("")) as folder:
        found = hold_against_rings(
            asked.contact, asked.path, rings=rings, steps=steps or 5, progress=_progress(quiet or as_json)
        )
        written = _write_figures({"verify": found.plot()}, folder)
    if as_json:
        table = {str(name): [_finite(float(v)) for v in array.values] for name, array in found.table.items()}
        typer.echo(json.dumps({"case": str(case), "rings": rings, "table": table}, indent=2))
    elif not quiet:
        typer.echo(found.summary())
        typer.echo("Written: " + ", ".join(str(file) for file in written))


def _verify_sliding(asked: Case, folder: Path, cells: int, steps: int, quiet: bool, as_json: bool) -> None:
    from pymdr.workbench.sliding import verify_sliding

    with _ready_folder(folder):
        found = verify_sliding(
            asked.contact,
            asked.path,
            machine_stiffness=asked.options.get("machine_stiffness"),
            cells=cells,
            steps=steps,
            progress=_progress(quiet or as_json),
        )
        written = _write_figures({"verify": found.plot()}, folder)
    if as_json:
        table = {str(name): [_finite(float(v)) for v in array.values] for name, array in found.table.items()}
        difference = _finite(found.largest_difference)
        told = {
            "case": str(asked.file),
            "cells": cells,
            "rows": found.rows.tolist(),
            "path_rows": found.path_rows,
            "largest_difference": difference,
            "table": table,
        }
        typer.echo(json.dumps(told, indent=2))
    elif not quiet:
        typer.echo(found.summary())
        typer.echo("Written: " + ", ".join(str(file) for file in written))


@app.command()
def plot(
    result_file: Annotated[Path, typer.Argument(metavar="RESULT.nc", help="A file written by pymdr run.")],
    output: Output = None,
    step: Annotated[int, typer.Option(help="Row to draw, counted from 0; -1 is the last.")] = -1,
    quiet: Quiet = False,
) -> None:
    """Draw the figures of a saved result."""
    from pymdr.result import open_result

    result = open_result(result_file)
    with _ready_folder(output or result_file.parent) as folder:
        written = _write_figures(result.figures(step), folder)
    if not quiet:
        typer.echo("Written: " + ", ".join(str(file) for file in written))


@contextmanager
def _ready_folder(folder: Path) -> Iterator[Path]:
    """Make the folder and see that it takes files before any work is done; without result it goes again."""
    from pymdr.errors import FileError

    is_new = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".pymdr-probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise FileError(
            f"cannot write into {folder}: {error.strerror or error}; choose another with -o DIR"
        ) from error
    try:
        yield folder
    except BaseException:
        if is_new and not any(folder.iterdir()):
            folder.rmdir()
        raise


def _write_figures(figures: Mapping[str, Figure], folder: Path) -> list[Path]:
    from pymdr.presentation.files import write_whole

    files = []
    for name, figure in figures.items():
        file = folder / f"{name}.png"
        write_whole(file, lambda beside, figure=figure: figure.savefig(beside, dpi=150))  # type: ignore[misc]
        files.append(file)
    return files


def _progress(silent: bool) -> Any:
    """A progress bar on a terminal, nothing in a pipe."""
    if silent or not sys.stderr.isatty():
        return None
    from rich.progress import Progress

    bar = Progress(transient=True)
    task = bar.add_task("solving")

    def show(done: int, total: int) -> None:
        bar.start()
        bar.update(task, completed=done, total=total)
        if done >= total:
            bar.stop()

    return show


def _as_json(case: Case, result: Result, written: Sequence[Path]) -> dict[str, Any]:
    last = {
        str(name): {"value": _finite(float(array.values[-1])), "unit": array.attrs["units"]}
        for name, array in result.data.items()
    }
    return {
        "case": str(case.file),
        "status": result.status.name,
        "steps": result.data.sizes["step"],
        "last": last,
        "claims": _plain_claims(result.claims),
        "assumptions": _plain_assumptions(result.assumptions),
        "notes": list(result.notes),
        "references": list(result.cite()),
        "written": [str(file) for file in written],
    }


def _finite(value: float) -> float | None:
    return value if abs(value) < float("inf") else None


def _plain_claims(claims: Mapping[str, Claim]) -> dict[str, Any]:
    from pymdr.presentation.text import largest_error

    return {
        name: {
            "level": claim.level.name,
            "reason": claim.reason,
            "source": claim.source,
            "steps_valid": int(claim.where.sum()),
            "error": largest_error(claim),
        }
        for name, claim in claims.items()
    }


def _plain_assumptions(assumptions: Sequence[Assumption]) -> list[dict[str, Any]]:
    return [
        {"name": a.name, "words": a.words, "measure": a.measure, "limit": a.limit, "met": a.met}
        for a in assumptions
    ]
