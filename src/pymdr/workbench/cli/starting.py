"""``pymdr new``, ``schema`` and ``info``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from pymdr.errors import FileError


def kinds_starting(incomplete: str) -> list[str]:
    """Kinds of cases that complete a word."""
    from pymdr.workbench.templates import KINDS

    return [kind for kind in KINDS if kind.startswith(incomplete)]


def new(
    kind: Annotated[
        str,
        typer.Argument(
            autocompletion=kinds_starting,
            help="ball, cone, worn (truncated), punch, tip (measured), gel (adhesion), joint (friction), cycle, rubber, creep, "
            "layers, switch (conduction), rough, press or machine.",
        ),
    ] = "ball",
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="CASE.toml", help="File to write; by default print."),
    ] = None,
) -> None:
    """Write a commented case to start from."""
    from pymdr.presentation.files import write_atomically
    from pymdr.workbench.templates import template

    text = template(kind)
    if output is None:
        typer.echo(text, nl=False)
        return
    if output.exists():
        raise FileError(f"{output} already exists; choose another file with -o")
    write_atomically(output, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def schema(
    of_rough: Annotated[bool, typer.Option("--rough", help="Schema of cases for pymdr rough.")] = False,
    of_press: Annotated[bool, typer.Option("--press", help="Schema of cases for pymdr press.")] = False,
    of_machine: Annotated[bool, typer.Option("--machine", help="Schema of cases for pymdr move.")] = False,
) -> None:
    """Print the JSON schema of case files."""
    from pymdr.problem.codec import case_schema, import_plugins, machine_adapter, press_adapter, rough_adapter

    wanted = ((of_rough, rough_adapter), (of_press, press_adapter), (of_machine, machine_adapter))
    adapters = [adapter for is_wanted, adapter in wanted if is_wanted]
    if len(adapters) > 1:
        raise typer.BadParameter("give one of --rough, --press and --machine")
    import_plugins()
    plain = adapters[0]().json_schema() if adapters else case_schema()
    typer.echo(json.dumps({"$schema": "https://json-schema.org/draft/2020-12/schema", **plain}, indent=2))


def info() -> None:
    """Print versions for bug reports."""
    import platform
    from importlib.metadata import PackageNotFoundError, version

    from pymdr.version import __version__

    typer.echo(
        f"pymdr {__version__}\nPython {platform.python_version()} on {platform.system()} {platform.machine()}"
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
