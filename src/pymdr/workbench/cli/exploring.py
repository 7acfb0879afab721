"""``pymdr explore``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pymdr.errors import MissingExtraError


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
    try:
        import panel  # noqa: F401
    except ImportError as error:
        raise MissingExtraError(
            "pymdr explore needs panel, which is not installed; install it with pip install 'pymdr[explore]'"
        ) from error
    from pymdr.explore.model import choices_of
    from pymdr.explore.serve import serve
    from pymdr.workbench.cli.reporting import print_error

    serve(choices_of(cases, print_error), typer.echo, port, show=not no_browser)
