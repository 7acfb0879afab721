"""Where a choice comes from and goes to: cases to start from, case files, results, lines of Python."""

from __future__ import annotations

import re
import tomllib
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pymdr.errors import CaseError, FileError, errors_of_case
from pymdr.explore.model.choice import PARTS, Choice, Plain, chosen, short_text, with_entry
from pymdr.problem.codec import tables
from pymdr.problem.schedule import Progress
from pymdr.result import Result
from pymdr.solving.verb import solve
from pymdr.workbench.casefile import Case, case_of_tables, case_text, read_tables
from pymdr.workbench.templates import template

STARTS = {
    "ball": "steel ball on glass",
    "cone": "cone into quartz",
    "worn": "worn ball",
    "punch": "punch with a dome",
    "tip": "measured tip",
    "gel": "adhesive ball on a gel",
    "joint": "shaken joint",
    "cycle": "load cycle",
    "rubber": "ball on rubber",
    "creep": "creeping plastic",
    "layers": "coated body",
    "switch": "switch of silver",
}
"""Cases to start from, by the names of :func:`pymdr.workbench.templates.template`."""


def start(kind: str) -> Choice:
    """
    One of the cases of :data:`STARTS`.

    Examples
    --------
    >>> start("ball").tables["profile"]["radius"]
    '10 mm'
    """
    return chosen(tomllib.loads(template(kind)))


def choices_of(cases: Path | None, leave_out: Callable[[str], object] = warnings.warn) -> dict[str, Choice]:
    """
    The cases to choose from by name: those of a file or a folder, then :data:`STARTS`.

    Parameters
    ----------
    cases : Path or None
        A case file, or a folder of them.
    leave_out : callable
        Called with a sentence for every file of the folder that is no case.
    """
    choices: dict[str, Choice] = {}
    if cases is not None and cases.is_dir():
        for file in sorted(cases.glob("*.toml")):
            try:
                choices[file.name] = of_file(file)
            except CaseError as error:
                leave_out(f"left out: {error}")
        if not choices:
            raise FileError(
                f"{cases}: no case file (*.toml) is in this folder; give a folder of cases, or one case"
            )
    elif cases is not None:
        choices[cases.name] = of_file(cases)
    return {**choices, **{words: start(kind) for kind, words in STARTS.items()}}


def of_file(file: Path) -> Choice:
    """The choice of a case file."""
    read = read_tables(file)
    with errors_of_case(f"{file}:"):
        case_of_tables(read)
    return chosen(read)


def case_of(choice: Choice) -> Case:
    """Contact, path and options of a choice."""
    return case_of_tables(choice.tables)


def answer(choice: Choice, progress: Progress | None = None) -> Result:
    """The result of a choice, by :func:`pymdr.solve`."""
    case = case_of(choice)
    return solve(case.contact, case.path, progress=progress, **case.options)


def fitted_to(choice: Choice, values: Mapping[str, tuple[float, str]]) -> Choice:
    """
    The choice with the values of parameters by their dotted names, each with its SI unit.

    Examples
    --------
    >>> fitted_to(start("gel"), {"body.young": (9567.1, "Pa")}).tables["body"]["young"]
    '9.5671 kPa'
    """
    for name, (value, unit) in values.items():
        parts = (part for part in re.split(r"[.\[\]]+", name) if part)
        place = tuple(int(part) if part.isdigit() else part for part in parts)
        choice = with_entry(choice, place, short_text(value, unit, digits=6))
    return choice


def toml(choice: Choice) -> str:
    """The case file of a choice."""
    return "# Solve it with: pymdr run CASE.toml\n" + case_text(choice.tables)


def python_lines(choice: Choice) -> str:
    """
    The choice as lines of Python.

    Examples
    --------
    >>> print(python_lines(start("cone")))
    import pymdr as mdr
    <BLANKLINE>
    contact = mdr.Contact(
        profile=mdr.Cone(half_angle='70.3 deg'),
        body=mdr.Elastic(young='210 GPa', poisson=0.3),
        counterbody=mdr.Elastic(young='70 GPa', poisson=0.22),
    )
    path = mdr.indent(indentation='100 nm', steps=40)
    result = mdr.solve(contact, path)
    print(result.summary())
    """
    parts = [f"    {name}={_call(choice.tables[name])},\n" for name in PARTS[:-1] if name in choice.tables]
    legs = " >> ".join(_call(leg) for leg in choice.tables["path"])
    given = {key: value for key, value in choice.tables.get("solve", {}).items() if key != "solver"}
    options = "".join(f", {key}={_source(value)}" for key, value in given.items())
    options += _rings(choice.tables.get("solve", {}))
    return (
        f"import pymdr as mdr\n\ncontact = mdr.Contact(\n{''.join(parts)})\npath = {legs}\n"
        f"result = mdr.solve(contact, path{options})\nprint(result.summary())"
    )


def _rings(options: Plain) -> str:
    return f", solver=mdr.Rings(n={options['solver'].get('n', 400)})" if "solver" in options else ""


def _call(entry: Plain) -> str:
    kind = entry["kind"]
    if kind == "sum":
        return " + ".join(_call(part) for part in entry["parts"])
    arguments = ", ".join(f"{key}={_source(value)}" for key, value in entry.items() if key != "kind")
    if kind in (*tables.ONE_CHANNEL_LEGS, *tables.ORBIT_LEGS, "cycle", "hold"):
        return f"mdr.{kind}({arguments})"
    owner = next(table[kind] for table in tables.TABLES.values() if kind in table)
    return f"mdr.{owner.__name__}({arguments})"


def _source(value: Any) -> str:
    if isinstance(value, Mapping):
        if "kind" in value:
            return _call(value)
        return f"mdr.Layer({', '.join(f'{key}={_source(entry)}' for key, entry in value.items())})"
    if isinstance(value, list | tuple | np.ndarray):
        return f"[{', '.join(_source(entry) for entry in value)}]"
    return repr(value.item() if isinstance(value, np.generic) else value)
