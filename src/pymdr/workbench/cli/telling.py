"""What a command tells: lines that steer no terminal, progress, JSON, and how it ends."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from pymdr.workbench.cli.folders import write_found

if TYPE_CHECKING:
    import xarray as xr

    from pymdr.interpretation.validity import Assumption, Claim
    from pymdr.result import Result
    from pymdr.solving.study import Answer, Study

OK, FAILED, REFUSED = 0, 1, 3
"""Exit statuses beside the 2 of wrong use; REFUSED: the method gives nothing for this contact."""
REFUSALS = ("REFUSED", "ADHESION_REFUSED")
"""Statuses of results in which nothing but a bound is given."""


def say(text: str) -> None:
    """Print a text in which no character steers the terminal."""
    from pymdr.workbench.inputs import printable, writable

    typer.echo(writable(printable(text), sys.stdout.encoding))


def say_written(files: Sequence[Path]) -> None:
    """Name the files that were written, if any."""
    if files:
        say("Written: " + ", ".join(str(file) for file in files))


def say_found(title: str, summary: str, written: Sequence[Path]) -> None:
    """Print what was found and where it was written."""
    say(title)
    say(summary)
    say_written(written)


def tell_written(
    command: str, file: Path, result: Result, written: Sequence[Path], quiet: bool, as_json: bool
) -> None:
    """Tell what was written of a saved result."""
    if as_json:
        rows = result.data.sizes["step"]
        print_json(answer(command, file, written, status=result.status.name, rows=rows))
    elif not quiet:
        say_written(written)


def complain(text: str) -> None:
    """Print one line where errors go."""
    from pymdr.workbench.inputs import printable, writable

    line = printable(" ".join(text.split("\n")))
    typer.echo(writable(f"pymdr: {line}", sys.stderr.encoding), err=True)


Stage = Callable[[str], Callable[[int, int], None] | None]
"""Names the stage at which the work is; gives what its progress is told to."""


@contextmanager
def stages(silent: bool) -> Iterator[Stage]:
    """One progress bar that names the stage at which the work is; nothing in a pipe."""
    if silent or not sys.stderr.isatty():
        yield lambda words: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("reading", total=None)

        def stage(words: str) -> Callable[[int, int], None]:
            bar.reset(task, description=words, total=None)
            return lambda done, total: bar.update(task, completed=done, total=total)

        yield stage


def answer(command: str, case: Path, written: Sequence[Path] = (), **told: Any) -> dict[str, Any]:
    """What every command tells as JSON: the same keys, null or empty where it has nothing to say."""
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
        "fit": None,
        "curves": None,
        "written": [str(file) for file in written],
        "error": None,
    }
    return {**empty, **told}


def words_of(error: BaseException) -> str:
    """What an error says."""
    return str(error) or "the memory of this machine is not enough; take fewer steps"


def exit_status(error: BaseException) -> int:
    """How a command ends by an error."""
    from pymdr.errors import RefusedError

    return REFUSED if isinstance(error, RefusedError) else FAILED


def failure(command: str, case: Path, error: BaseException) -> dict[str, Any]:
    """The answer of a command that failed, or whose contact the method refuses."""
    status = "REFUSED" if exit_status(error) == REFUSED else "FAILED"
    return answer(
        command, case, status=status, error={"kind": type(error).__name__, "message": words_of(error)}
    )


def print_json(told: Any) -> None:
    """Print one answer or a list of them; numbers that JSON lacks are null."""
    typer.echo(json.dumps(_plain(told), indent=2, allow_nan=False))


def _plain(told: Any) -> Any:
    if isinstance(told, dict):
        return {name: _plain(one) for name, one in told.items()}
    if isinstance(told, list | tuple):
        return [_plain(one) for one in told]
    return None if isinstance(told, float) and not math.isfinite(told) else told


@contextmanager
def failures_as_json(command: str, case: Path | Sequence[Path], as_json: bool) -> Iterator[None]:
    """Tell an error as JSON before it becomes one line."""
    from pymdr.errors import PymdrError

    try:
        yield
    except (PymdrError, MemoryError) as error:
        if as_json:
            cases = [case] if isinstance(case, Path) else case
            told = [failure(command, c, error) for c in cases]
            print_json(told[0] if len(told) == 1 else told)
        raise


def with_unit(value: float | None, unit: str) -> dict[str, Any]:
    """A value with its unit."""
    return {"value": value, "unit": unit}


def table_of(data: xr.Dataset) -> dict[str, list[float]]:
    """The columns of a table."""
    return {str(name): [float(value) for value in array.values] for name, array in data.items()}


def validity_of(found: Result | Answer) -> dict[str, Any]:
    """How far what was found can be trusted."""
    return {
        "claims": claims_of(found.claims),
        "assumptions": _assumptions_of(found.assumptions),
        "notes": list(found.notes),
    }


def claims_of(claims: Mapping[str, Claim]) -> dict[str, Any]:
    """What is claimed of every quantity."""
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


def _assumptions_of(assumptions: Sequence[Assumption]) -> list[dict[str, Any]]:
    return [
        {
            "name": a.name,
            "words": a.words,
            "measure": a.measure,
            "limit": a.limit,
            "met": a.met,
        }
        for a in assumptions
    ]


def columns_of(found: Study) -> dict[str, Any]:
    """Its columns as plain values."""
    return {
        str(name): {
            "values": [float(value) for value in found.data[name].values.ravel()],
            "unit": found.data[name].attrs["units"],
        }
        for name in (*found.data.coords, *found.data.data_vars)
    }


def tell_study(
    command: str,
    case: Path,
    ask: Callable[[], tuple[str, Study]],
    output: Path | None,
    quiet: bool,
    as_json: bool,
) -> None:
    """Ask for a study and the title of its case, write and tell it."""
    with failures_as_json(command, case, as_json):
        title, found = ask()
        written = write_found(found, output, command)
    if as_json:
        told = answer(
            command,
            case,
            written,
            title=title,
            status="COMPLETED",
            rows=next(iter(found.data.sizes.values())),
            study=columns_of(found),
            **validity_of(found),
        )
        print_json(told)
    elif not quiet:
        say_found(title or str(case), found.summary(), written)
