"""Output of commands: text, progress, JSON and exit status."""

from __future__ import annotations

import inspect
import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_type_hints

import typer

from pymdr.errors import PymdrError, RefusedError
from pymdr.workbench.cli.folders import ready_output, write_study
from pymdr.workbench.cli.options import Json, Quiet, Table
from pymdr.workbench.cli.wording import error_text

if TYPE_CHECKING:
    import xarray as xr

    from pymdr.interpretation.validity import Claim
    from pymdr.result import Result
    from pymdr.solving.study import Answer, Study

OK, FAILED, REFUSED = 0, 1, 3
"""Exit statuses; 2 is wrong usage, REFUSED means that the method does not apply to the contact."""
REFUSALS = ("REFUSED", "ADHESION_REFUSED")
"""Statuses of results that give only a bound."""


def print_text(text: str) -> None:
    """Print a text without control characters."""
    from pymdr.workbench.inputs import printable, writable

    typer.echo(writable(printable(text), sys.stdout.encoding))


def print_written(files: Sequence[Path]) -> None:
    """Print the written files, if any."""
    if files:
        print_text("Written: " + ", ".join(str(file) for file in files))


def print_report(title: str, summary: str, written: Sequence[Path]) -> None:
    """Print title, summary and written files."""
    print_text(title)
    print_text(summary)
    print_written(written)


def report_written(
    command: str, file: Path, result: Result, written: Sequence[Path], quiet: bool, as_json: bool
) -> None:
    """Report the files written from a saved result."""
    if as_json:
        rows = result.data.sizes["step"]
        print_json(report(command, file, written, status=result.status.name, rows=rows))
    elif not quiet:
        print_written(written)


def print_error(text: str) -> None:
    """Print one line to the error stream."""
    from pymdr.workbench.inputs import printable, writable

    line = printable(" ".join(text.split("\n")))
    typer.echo(writable(f"pymdr: {line}", sys.stderr.encoding), err=True)


Stage = Callable[[str], Callable[[int, int], None] | None]
"""Called with the name of a stage; returns its progress callback."""


@contextmanager
def stages(silent: bool) -> Iterator[Stage]:
    """A progress bar with the name of the current stage; silent in a pipe."""
    if silent or not sys.stderr.isatty():
        yield lambda name: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("reading", total=None)

        def stage(name: str) -> Callable[[int, int], None]:
            bar.reset(task, description=name, total=None)
            return lambda done, total: bar.update(task, completed=done, total=total)

        yield stage


def report(command: str, case: Path, written: Sequence[Path] = (), **entries: Any) -> dict[str, Any]:
    """The JSON report of a command: always the same keys, null or empty if not used."""
    empty: dict[str, Any] = {
        "command": command,
        "case": str(case),
        "title": "",
        "status": None,
        "rows": None,
        "memory": None,
        "last": {},
        "largest": {},
        "claims": {},
        "assumptions": [],
        "notes": [],
        "references": [],
        "verification": None,
        "loops": None,
        "impact": None,
        "study": None,
        "preceding_studies": None,
        "fit": None,
        "curves": None,
        "written": [str(file) for file in written],
        "error": None,
    }
    return {**empty, **entries}


def exit_status(error: BaseException) -> int:
    """The exit status of an error."""
    return REFUSED if isinstance(error, RefusedError) else FAILED


def failure_report(command: str, case: Path, error: BaseException) -> dict[str, Any]:
    """The JSON report of a command that failed or whose contact is refused."""
    status = "REFUSED" if exit_status(error) == REFUSED else "FAILED"
    return report(
        command, case, status=status, error={"kind": type(error).__name__, "message": error_text(error)}
    )


def print_json(reports: Any) -> None:
    """Print one report or a list; numbers that JSON lacks are null."""
    typer.echo(json.dumps(_plain(reports), indent=2, allow_nan=False))


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


@contextmanager
def failures_as_json(command: str, case: Path | Sequence[Path], as_json: bool) -> Iterator[None]:
    """Print an error as JSON before it becomes one line."""
    try:
        yield
    except (PymdrError, MemoryError) as error:
        if as_json:
            cases = [case] if isinstance(case, Path) else case
            reports = [failure_report(command, c, error) for c in cases]
            print_json(reports[0] if len(reports) == 1 else reports)
        raise


def with_unit(value: float | None, unit: str) -> dict[str, Any]:
    """A value with its unit."""
    return {"value": value, "unit": unit}


def table_of(data: xr.Dataset) -> dict[str, list[float]]:
    """The columns of a table."""
    return {str(name): [float(value) for value in array.values] for name, array in data.items()}


def validity_of(study: Result | Answer) -> dict[str, Any]:
    """Claims, assumptions and notes for JSON."""
    return {
        "claims": claims_of(study.claims),
        "assumptions": [{**asdict(a), "met": a.met} for a in study.assumptions],
        "notes": list(study.notes),
    }


def claims_of(claims: Mapping[str, Claim]) -> dict[str, Any]:
    """Claims by quantity for JSON."""
    from pymdr.presentation.text import largest_error

    return {
        name: {
            "level": claim.level.name,
            "reason": claim.reason,
            "source": claim.source,
            "steps_valid": int(claim.where.sum()),
            "error": largest_error(claim),
            **({"excluded": claim.excluded} if claim.excluded else {}),
        }
        for name, claim in claims.items()
    }


def columns_of(study: Study) -> dict[str, Any]:
    """The columns of a study as plain values."""
    return {
        str(name): {
            "values": study.data[name].values.ravel().tolist(),
            "unit": study.data[name].attrs.get("units", ""),
        }
        for name in (*study.data.coords, *study.data.data_vars)
    }


def report_answer(
    command: str,
    case: Path,
    title: str,
    study: Answer,
    written: Sequence[Path],
    quiet: bool,
    as_json: bool,
    own: Callable[[], dict[str, Any]],
) -> None:
    """Report a study; `own` computes the other entries of its JSON report, and is called for JSON only."""
    if as_json:
        entries = {"title": title, "status": "COMPLETED", **validity_of(study), **own()}
        print_json(report(command, case, written, **entries))
    elif not quiet:
        print_report(title or str(case), study.summary(), written)


def report_study(
    command: str,
    case: Path,
    make: Callable[[], tuple[str, Study]],
    output: Path | None,
    quiet: bool,
    as_json: bool,
    animate: bool = False,
) -> None:
    """Make a study with the title of its case, write and report it."""
    with failures_as_json(command, case, as_json), ready_output(output):
        title, study = make()
        written = write_study(study, output, command, animate=animate)

    def own() -> dict[str, Any]:
        return {"rows": next(iter(study.data.sizes.values()), 1), "study": columns_of(study)}

    report_answer(command, case, title, study, written, quiet, as_json, own)


def study_command(name: str) -> Callable[[Callable[..., tuple[str, Study]]], Callable[..., None]]:
    """
    Make a command of a function that returns a study and the title of its case.

    The command writes and reports the study; its last options are those of that: --output, --quiet and --json.
    """

    def decorated(make: Callable[..., tuple[str, Study]]) -> Callable[..., None]:
        @wraps(make)
        def command(
            *,
            case: Path,
            output: Path | None = None,
            quiet: bool = False,
            as_json: bool = False,
            **options: Any,
        ) -> None:
            report_study(name, case, lambda: make(case, **options), output, quiet, as_json)

        command.__annotations__ = {**make.__annotations__, "output": Table, "quiet": Quiet, "as_json": Json}
        del command.__annotations__["return"]  # its types are imported by checkers only
        hints = get_type_hints(command, include_extras=True)
        own = inspect.signature(make).parameters.values()
        added = (
            inspect.Parameter(each, inspect.Parameter.KEYWORD_ONLY, default=default)
            for each, default in _ADDED
        )
        parameters = [one.replace(annotation=hints[one.name]) for one in (*own, *added)]
        command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        return command

    return decorated


_ADDED = (("output", None), ("quiet", False), ("as_json", False))
"""Options of every command that makes a study, with their defaults."""
