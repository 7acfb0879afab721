"""``pymdr move``: the motion of a machine."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pymdr.workbench.cli.options import CaseFile, Json, Quiet, Table
from pymdr.workbench.cli.reporting import report_study

if TYPE_CHECKING:
    from pymdr.solving.study import Study


def move(case: CaseFile, output: Table = None, quiet: Quiet = False, as_json: Json = False) -> None:
    """Move the masses, springs and contacts of a [machine]."""
    from pymdr.solving.machines import move as moved
    from pymdr.workbench.casefile import read_machine_case

    def study() -> tuple[str, Study]:
        read = read_machine_case(case)
        return read.title, moved(read.machine, **read.options)

    report_study("move", case, study, output, quiet, as_json)
