"""``pymdr move``: the motion of a machine."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pymdr.errors import errors_of_case
from pymdr.workbench.cli.options import CaseFile, Json, Quiet, Table
from pymdr.workbench.cli.reporting import print_json, print_text, report, report_study

if TYPE_CHECKING:
    from pymdr.problem.codec.machines import MachineCase
    from pymdr.solving.study import Study


def move(
    case: CaseFile,
    output: Table = None,
    animate: Annotated[
        bool, typer.Option("--animate", help="With -o: write move.gif, the line of the first joint, too.")
    ] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Move the masses, springs and contacts of a [machine]."""
    from pymdr.solving.machines import move as moved

    if animate and output is None:
        raise typer.BadParameter("--animate writes a file; give its folder with -o")

    def study() -> tuple[str, Study]:
        read = _read(case)
        return read.title, moved(read.machine, **read.options)

    report_study("move", case, study, output, quiet, as_json, animate)


def _read(case: Path) -> MachineCase:
    """A case whose duration, steps and accuracy are valid."""
    from pymdr.solving.machines.verb import checked_span
    from pymdr.workbench.casefile import read_machine_case

    read = read_machine_case(case)
    with errors_of_case(f"{case}: [machine]"):
        checked_span(**read.options)
    return read


def check_machine(case: Path, quiet: bool, as_json: bool) -> None:
    """Validate a case of a machine and its contact; its claims are those of the motion."""
    from pymdr.solving.machines.assembling import map_contact

    read = _read(case)
    for joint in read.machine.joints:
        map_contact(joint.contact)
    if as_json:
        print_json(report("check", case, title=read.title, status="COMPLETED", rows=0))
    elif not quiet:
        print_text(read.title or f"{case} is a valid case.")
        bodies, links = len(read.machine.bodies), len(read.machine.links)
        print_text(
            f"A machine of {bodies} {'body' if bodies == 1 else 'bodies'} and {links} {'link' if links == 1 else 'links'}; pymdr move {case} moves it."
        )
