"""The program: its commands in the order of the help, and its exit status."""

from __future__ import annotations

import atexit
import gc
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated

import typer

from pymdr.errors import PymdrError
from pymdr.workbench.cli.bench import bench
from pymdr.workbench.cli.cases import check, plot, run
from pymdr.workbench.cli.curves import curves
from pymdr.workbench.cli.exploring import explore
from pymdr.workbench.cli.fits import fit
from pymdr.workbench.cli.indents import drift, nanoindent, pop_in, stiffness
from pymdr.workbench.cli.laws import law, table
from pymdr.workbench.cli.machines import move
from pymdr.workbench.cli.measured import fretting, loops, topography
from pymdr.workbench.cli.options import Once
from pymdr.workbench.cli.reporting import OK, exit_status, print_error
from pymdr.workbench.cli.starting import info, new, schema
from pymdr.workbench.cli.studies import (
    fatigue,
    heat,
    impact,
    joule,
    pull_off,
    rolling,
    shakedown,
    sliding,
    wear,
    yields,
)
from pymdr.workbench.cli.surfaces import press, rough
from pymdr.workbench.cli.sweep import sweep
from pymdr.workbench.cli.verify import verify
from pymdr.workbench.cli.wording import error_text

_COMMANDS = (
    run,
    new,
    schema,
    info,
    check,
    explore,
    verify,
    bench,
    loops,
    fretting,
    wear,
    impact,
    rolling,
    sliding,
    heat,
    joule,
    yields,
    shakedown,
    pull_off,
    fatigue,
    rough,
    press,
    sweep,
    curves,
    fit,
    nanoindent,
    drift,
    stiffness,
    pop_in,
    topography,
    law,
    move,
    table,
    plot,
)
"""In the order of the help."""


def before_commands(
    show: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
    plugins: Annotated[
        list[Path] | None,
        typer.Option(
            "--plugin", metavar="FILE.py", help="Import a Python file that registers your own kinds."
        ),
    ] = None,
) -> None:
    """Options before a command."""
    if plugins:
        from pymdr.workbench.plugins import import_file

        for file in plugins:
            import_file(file)
    if show:
        import pymdr

        typer.echo(f"pymdr {pymdr.__version__}")
        raise typer.Exit(OK)


def _name(command: Callable[..., None]) -> str:
    return "yield" if command is yields else command.__name__.replace("_", "-")


def _program_of(commands: Iterable[Callable[..., None]]) -> typer.Typer:
    program = typer.Typer(
        help="Contact mechanics by the Method of Dimensionality Reduction (MDR).",
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        add_completion=True,
    )
    for command in commands:
        program.command(_name(command), cls=Once)(command)
    program.callback(invoke_without_command=True)(before_commands)
    return program


app = _program_of(_COMMANDS)

_ALLOCATIONS = 500_000
"""Allocations between garbage collections; modules and figures live until the command ends, so more find little."""


def main() -> None:
    """Run the command line; errors of pymdr become one line and an exit status."""
    gc.set_threshold(_ALLOCATIONS)
    # the interpreter's last search for garbage visits all modules, a quarter of the CPU time of a short command
    atexit.register(gc.freeze)
    # a command is a tenth of the time that all take to set up
    named = [command for command in _COMMANDS if _name(command) in sys.argv[1:2]]
    try:
        (_program_of(named) if named else app)()
    except (PymdrError, MemoryError) as error:
        print_error(error_text(error))
        raise SystemExit(exit_status(error)) from None
