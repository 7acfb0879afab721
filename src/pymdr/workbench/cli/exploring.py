"""``pymdr explore``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from pymdr.explore.model import Choice


def explore(
    cases: Annotated[
        Path | None,
        typer.Argument(metavar="[CASE.toml|DIR]", help="Case to begin with, or a folder of cases."),
    ] = None,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port; by default one that is free.")] = 0,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Only print the address.")] = False,
) -> None:
    """Open a page on which contacts are changed by sliders.

    It is served to this computer alone, at an address with a token.
    """
    from pymdr.errors import MissingExtraError

    try:
        import panel  # noqa: F401
    except ImportError as error:
        raise MissingExtraError(
            "pymdr explore needs panel, which is not installed; install it with pip install 'pymdr[explore]'"
        ) from error
    choices = _choices(cases)
    from pymdr.explore.serve import serve

    serve(choices, typer.echo, port, show=not no_browser)


def _choices(cases: Path | None) -> dict[str, Choice]:
    """The cases to choose from by name, those of the files first."""
    from pymdr.errors import CaseError, FileError
    from pymdr.explore.model import STARTS, of_file, start
    from pymdr.workbench.cli.reporting import print_error

    found: dict[str, Choice] = {}
    if cases is not None and cases.is_dir():
        for file in sorted(cases.glob("*.toml")):
            try:
                found[file.name] = of_file(file)
            except CaseError as error:
                print_error(f"left out: {error}")
        if not found:
            raise FileError(
                f"{cases}: no case file (*.toml) is in this folder; give a folder of cases, or one case"
            )
    elif cases is not None:
        found[cases.name] = of_file(cases)
    return {**found, **{words: start(kind) for kind, words in STARTS.items()}}
