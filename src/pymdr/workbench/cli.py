"""The command line: ``pymdr run``, ``check``, ``verify``, ``loops``, ``impact``, ``rolling``, ``sliding``, ``rough``, ``press``, ``sweep``, ``topography``, ``heat``, ``joule``, ``law``, ``table``, ``plot``, ``new``, ``schema`` and ``info``.

Every command body imports what it needs, so that ``pymdr --help`` stays quick.
"""

from __future__ import annotations

import json
import logging
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pymdr.interpretation.validity import Assumption, Claim
    from pymdr.problem.contact import Contact
    from pymdr.problem.topography import Topography
    from pymdr.result import Result
    from pymdr.solving import Impact
    from pymdr.solving.study import Study
    from pymdr.solving.sweep import Sweep
    from pymdr.units import FloatArray
    from pymdr.workbench.casefile import Case

app = typer.Typer(
    help="Contacts by the Method of Dimensionality Reduction: exact where the theory is, honest where it is not.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    add_completion=True,
)

OK, FAILED, WRONG_USE, REFUSED = 0, 1, 2, 3
"""Exit statuses; REFUSED: all was done, and the method gives nothing for this contact."""

CaseFile = Annotated[Path, typer.Argument(metavar="CASE.toml", help="The case file.")]
CaseFiles = Annotated[list[Path], typer.Argument(metavar="CASE.toml...", help="One case file or several.")]
Output = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", metavar="DIR", help="Folder for result.nc and the figures; CASE unless given."
    ),
]
Table = Annotated[
    Path | None,
    typer.Option(
        "-o",
        "--output",
        metavar="DIR",
        help="Folder for the table and the figure; nothing is written unless given.",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of the summary, also of what fails.")]


def main() -> None:
    """Run the command line; errors of pymdr become one line and exit status 1."""
    from pymdr.errors import PymdrError

    try:
        app()
    except PymdrError as error:
        _complain(str(error))
        raise SystemExit(FAILED) from None
    except MemoryError:
        _complain("the memory of this machine is not enough; take fewer steps")
        raise SystemExit(FAILED) from None


def _say(text: str) -> None:
    """Print a text in which no character steers the terminal."""
    from pymdr.workbench.inputs import printable, writable

    typer.echo(writable(printable(text), sys.stdout.encoding))


def _complain(text: str) -> None:
    from pymdr.workbench.inputs import printable, writable

    line = printable(" ".join(text.split("\n")))
    typer.echo(writable(f"pymdr: {line}", sys.stderr.encoding), err=True)


@app.callback(invoke_without_command=True)
def version_option(
    show: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
) -> None:
    """Options that need no command."""
    if show:
        import pymdr

        typer.echo(f"pymdr {pymdr.__version__}")
        raise typer.Exit(OK)


@app.command()
def run(
    cases: CaseFiles,
    output: Output = None,
    csv: Annotated[bool, typer.Option("--csv", help="Write result.csv too.")] = False,
    xlsx: Annotated[bool, typer.Option("--xlsx", help="Write result.xlsx too.")] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Solve cases; write result.nc and figures; print the summary.

    Several cases write into one folder each; one that fails does not stop the others. The exit status is 1 if one
    failed, else 3 if the method refuses one.
    """
    from pymdr.errors import PymdrError

    tables = _Tables(csv, xlsx)
    with _failures_as_json("run", cases, as_json):
        tables.check()
        folders = _folders(cases, output)
    answers: list[dict[str, Any]] = []
    failures: dict[Path, str] = {}
    for case, folder in folders.items():
        try:
            answers.append(_run_one(case, folder, tables, quiet, as_json))
        except (PymdrError, MemoryError) as error:
            failures[case] = str(error) or "the memory of this machine is not enough"
            answers.append(_answer("run", case, status="FAILED", error=_plain_error(error)))
            if len(folders) == 1 and not as_json:
                raise
    if as_json:
        _print_json(answers[0] if len(folders) == 1 else answers)
    if len(folders) == 1:
        for told in failures.values():
            _complain(told)
    elif failures:
        _print_failures(list(folders), failures)
    refused = any(answer["status"] in _REFUSALS for answer in answers)
    if failures or refused:
        raise typer.Exit(FAILED if failures else REFUSED)


_REFUSALS = ("REFUSED", "ADHESION_REFUSED")


def _folders(cases: Sequence[Path], output: Path | None) -> dict[Path, Path]:
    """Where every case is written: no two into one folder."""
    from pymdr.errors import CaseError

    whole = {case: case.resolve() for case in cases}
    if output is None:
        folders = {case: _named_after(case) for case in cases}
    elif len(cases) == 1:
        folders = {cases[0]: output}
    else:
        folders = {case: output / case.stem for case in cases}
        if len(set(folders.values())) < len(folders):
            shared = os.path.commonpath([file.parent for file in whole.values()])
            folders = {c: output / whole[c].parent.relative_to(shared) / c.stem for c in cases}
    taken: dict[Path, Path] = {}
    for case, folder in folders.items():
        other = taken.setdefault(folder.resolve(), case)
        if other != case or list(cases).count(case) > 1:
            raise CaseError(f"{other} and {case} would both be written into {folder}; name each of them once")
    return folders


def _named_after(case: Path) -> Path:
    """The folder of a case beside its file."""
    from pymdr.errors import FileError

    if not case.name:
        raise FileError(f"cannot read {case}: a case file is a regular file, not a folder")
    return case.with_suffix("")


class _Tables(NamedTuple):
    """Which tables are written."""

    csv: bool
    xlsx: bool

    def check(self) -> None:
        """Refuse before any work what cannot be written after it."""
        if self.xlsx:
            from pymdr.presentation.tables import new_book

            new_book()

    def write(self, found: Result | Sweep, folder: Path, name: str) -> list[Path]:
        """Write them into a folder."""
        written = []
        if self.csv:
            found.to_csv(folder / f"{name}.csv")
            written.append(folder / f"{name}.csv")
        if self.xlsx:
            found.to_xlsx(folder / f"{name}.xlsx")
            written.append(folder / f"{name}.xlsx")
        return written


def _run_one(case: Path, folder: Path, tables: _Tables, quiet: bool, as_json: bool) -> dict[str, Any]:
    from pymdr.solving import solve
    from pymdr.workbench.casefile import read_case

    asked = read_case(case)
    if quiet:
        logging.getLogger("pymdr").setLevel(logging.ERROR)
    with _ready_folder(folder), _stages(quiet or as_json) as stage:
        if not quiet and not as_json:
            _tell_memory(asked)
        result = solve(asked.contact, asked.path, progress=stage("solving"), **asked.options)
        result.save(folder / "result.nc")
        written = [folder / "result.nc", *tables.write(result, folder, "result")]
        written += _write_figures(result.figures(), folder, stage("drawing"))
    if not as_json and result.status.name in _REFUSALS:
        _complain(f"{case}: {result.status.name}: {result.status.value}")
    if not quiet and not as_json:
        _say(asked.title or str(case))
        _say(result.summary())
        _say("Written: " + ", ".join(str(file) for file in written))
    last = {
        str(name): {"value": _finite(float(array.values[-1])), "unit": array.attrs["units"]}
        for name, array in result.data.items()
    }
    return _answer(
        "run",
        case,
        title=asked.title,
        status=result.status.name,
        rows=result.data.sizes["step"],
        last=last,
        largest={
            name: {"value": _finite(float(result.data[name].max())), "unit": result.data[name].attrs["units"]}
            for name in ("indentation", "normal_force", "contact_radius")
            if name in result.data
        },
        claims=_plain_claims(result.claims),
        assumptions=_plain_assumptions(result.assumptions),
        notes=list(result.notes),
        references=list(result.cite()),
        written=[str(file) for file in written],
    )


_LARGE = 50_000_000


def _tell_memory(case: Case) -> None:
    """Say what a long history will take before it is followed."""
    from pymdr.presentation.text import in_bytes
    from pymdr.problem.schedule import total_rows
    from pymdr.solving.verb import bytes_of

    rows = total_rows(case.path)
    keep = int(case.options.get("keep") or 1)
    if bytes_of(rows, keep) > _LARGE:
        _complain(
            f"{rows} rows, of which {rows // keep} are kept, take about {in_bytes(bytes_of(rows, keep))} while they are "
            "solved; with friction [solve] keep = k keeps every k-th"
        )


def _print_failures(cases: Sequence[Path], failures: Mapping[Path, str]) -> None:
    _complain(f"{len(failures)} of {len(cases)} cases failed")
    for case in cases:
        if case in failures:
            _complain(f"{case}: {failures[case]}".replace(f"{case}: {case}", str(case), 1))


@app.command()
def new(
    kind: Annotated[
        str,
        typer.Argument(
            help="ball, cone, worn (blunt shapes), punch, tip (measured), gel (adhesion), joint (friction), cycle or rough."
        ),
    ] = "ball",
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="CASE.toml", help="File to write; printed unless given."),
    ] = None,
) -> None:
    """Write a commented case to start from."""
    from pymdr.presentation.files import write_whole
    from pymdr.workbench.templates import template

    text = template(kind)
    if output is None:
        typer.echo(text, nl=False)
        return
    from pymdr.errors import FileError

    if output.exists():
        raise FileError(f"{output} exists already; name another file with -o")
    write_whole(output, lambda beside: beside.write_text(text, encoding="utf-8"))


@app.command()
def schema(
    of_rough: Annotated[bool, typer.Option("--rough", help="Of the cases that pymdr rough takes.")] = False,
) -> None:
    """Print the JSON schema of case files, for editors."""
    from pymdr.problem.codec import case_schema, rough_adapter

    plain = rough_adapter().json_schema() if of_rough else case_schema()
    typer.echo(json.dumps({"$schema": "https://json-schema.org/draft/2020-12/schema", **plain}, indent=2))


@app.command()
def info() -> None:
    """Print versions of pymdr and what it stands on, for bug reports."""
    import platform
    from importlib.metadata import PackageNotFoundError, version

    typer.echo(
        f"pymdr {version('pymdr')}\nPython {platform.python_version()} on {platform.system()} {platform.machine()}"
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


@app.command()
def check(case: CaseFile, quiet: Quiet = False, as_json: Json = False) -> None:
    """Validate a case and print what can be claimed of it; nothing is written."""
    from pymdr.quantities import quantity
    from pymdr.solving import assess
    from pymdr.workbench.casefile import read_case

    with _failures_as_json("check", case, as_json):
        asked = read_case(case)
        assessment = assess(asked.contact, asked.path, **asked.options)
    status = assessment.status.name
    if as_json:
        largest = {
            name: {"value": _finite(value), "unit": quantity(name).unit}
            for name, value in assessment.largest.items()
        }
        told = _answer(
            "check",
            case,
            title=asked.title,
            status=status,
            rows=assessment.rows,
            memory=assessment.memory,
            largest=largest,
            claims=_plain_claims(assessment.claims),
            assumptions=_plain_assumptions(assessment.assumptions),
            notes=list(assessment.notes),
        )
        _print_json(told)
    elif not quiet:
        _say(asked.title or f"{case} is a valid case.")
        _say(assessment.summary())
    if status in _REFUSALS:
        if not as_json:
            _complain(f"{case}: {status}: {assessment.status.value}")
        raise typer.Exit(REFUSED)


@app.command()
def verify(
    case: CaseFile,
    output: Output = None,
    rings: Annotated[int, typer.Option(help="Number of rings, 20 to 5000.")] = 400,
    cells: Annotated[int, typer.Option(help="With friction: cells along a side of the grid, 8 to 80.")] = 32,
    pixels: Annotated[
        int, typer.Option(help="Of a body that is not of revolution: pixels along a side, 33 to 1025.")
    ] = 129,
    steps: Annotated[
        int | None, typer.Option(help="How many steps of the path are solved by both; 5, with friction 20.")
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Hold the method against boundary elements: on rings, with friction or bodies not of revolution on a grid; draw both."""
    from pymdr.workbench.casefile import read_case

    with _failures_as_json("verify", case, as_json):
        folder = output or _named_after(case)
        asked = read_case(case)
        with _ready_folder(folder), _stages(quiet or as_json) as stage:
            if asked.contact.friction is None:
                found, told = _by_elements(asked, rings, pixels, 5 if steps is None else steps, stage)
            else:
                found, told = _by_cells(asked, cells, 20 if steps is None else steps, stage)
            written = _write_figures({"verify": found.plot()}, folder, stage("drawing"))
    # without any difference to tell the method gave nothing
    refused = told["largest_difference"] is None
    if as_json:
        table = {str(name): [_finite(float(v)) for v in array.values] for name, array in found.table.items()}
        answer = _answer(
            "verify",
            case,
            title=asked.title,
            status="REFUSED" if refused else "COMPLETED",
            rows=found.table.sizes["step"],
            verification={**told, "table": table},
            written=[str(file) for file in written],
        )
        _print_json(answer)
    elif not quiet:
        _say(found.summary())
        _say("Written: " + ", ".join(str(file) for file in written))
    if refused:
        raise typer.Exit(REFUSED)


def _by_elements(
    asked: Case, rings: int, pixels: int, steps: int, stage: Stage
) -> tuple[Any, dict[str, Any]]:
    from pymdr.problem.profiles import Shape
    from pymdr.workbench.verification import verify as hold_against_elements

    whole = isinstance(asked.contact.profile, Shape)
    found = hold_against_elements(
        asked.contact,
        asked.path,
        rings=rings,
        pixels=pixels,
        steps=steps,
        machine_stiffness=asked.options.get("machine_stiffness"),
        progress=stage("pressing by boundary elements" if whole else "solving by rings"),
    )
    solver, n = ("pixels", pixels) if whole else ("rings", rings)
    return found, {"solver": solver, "n": n, "largest_difference": _finite(found.largest_difference)}


def _by_cells(asked: Case, cells: int, steps: int, stage: Stage) -> tuple[Any, dict[str, Any]]:
    from pymdr.workbench.sliding import verify_sliding

    found = verify_sliding(
        asked.contact,
        asked.path,
        machine_stiffness=asked.options.get("machine_stiffness"),
        cells=cells,
        steps=steps,
        progress=stage("solving on a grid"),
    )
    told = {
        "solver": "cells",
        "n": cells,
        "path_rows": found.path_rows,
        "rows": found.rows.tolist(),
        "largest_difference": _finite(found.largest_difference),
    }
    return found, told


@app.command()
def loops(
    record: Annotated[Path, typer.Argument(metavar="RECORD.csv", help="Force and displacement, with units.")],
    least: Annotated[
        str | None,
        typer.Option(help="The smallest swing that is a turn, such as '0.1 um'; a tenth of the range."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Energy per cycle and equivalent damping of a measured record; nothing is written."""
    from pymdr.workbench.records import measured_loops
    from pymdr.workbench.tables import read_record

    with _failures_as_json("loops", record, as_json):
        found = measured_loops(read_record(record), least=least)
    if as_json:
        table = {str(name): [_finite(float(v)) for v in array.values] for name, array in found.data.items()}
        _print_json(_answer("loops", record, status="COMPLETED", rows=found.data.sizes["cycle"], loops=table))
    else:
        _say(found.summary())


@app.command()
def impact(
    case: CaseFile,
    mass: Annotated[str, typer.Option(help="Reduced mass, such as '33 g'.")],
    speed: Annotated[str, typer.Option(help="Speed at the first touch, such as '0.3 m/s'.")],
    angle: Annotated[str, typer.Option(help="From the normal, such as '40 deg'.")] = "0 deg",
    inertia: Annotated[
        str | None, typer.Option(help="Moment of inertia, such as '1 g*cm^2'; of a solid ball unless given.")
    ] = None,
    radius: Annotated[
        str | None, typer.Option(help="From the centre to the contact point; of the ball unless given.")
    ] = None,
    spin: Annotated[str, typer.Option(help="Angular velocity, such as '10 rad/s'.")] = "0 rad/s",
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """The impact of the contact of a case, whose path may be left out; with -o its history and figure are written."""
    from pymdr.quantities import quantity
    from pymdr.solving import impact as collide
    from pymdr.workbench.casefile import read_contact

    with _failures_as_json("impact", case, as_json):
        title, contact = read_contact(case)
        found = collide(
            contact,
            mass=mass,
            speed=speed,
            angle=angle,
            inertia=inertia,
            radius=radius,
            spin=spin,
        )
        written = _write_found(found, output, "impact")
    if as_json:
        told = {
            name: {"value": _finite(value), "unit": quantity(name).unit}
            for values in found.groups().values()
            for name, value in values.items()
        }
        answer = _answer(
            "impact",
            case,
            title=title,
            status="COMPLETED",
            rows=found.data.sizes["step"],
            impact=told,
            claims=_plain_claims(found.claims),
            assumptions=_plain_assumptions(found.assumptions),
            notes=list(found.notes),
            written=[str(file) for file in written],
        )
        _print_json(answer)
    elif not quiet:
        _say(title or str(case))
        _say(found.summary())
        if written:
            _say("Written: " + ", ".join(str(file) for file in written))


NormalForce = Annotated[str | None, typer.Option(help="The constant load, such as '1 N'.")]
Indentation = Annotated[str | None, typer.Option(help="The constant depth in its place, such as '10 um'.")]
Points = Annotated[
    int | None,
    typer.Option(help="How many in all, evenly in their logarithm from the first of two to the second."),
]


@app.command()
def rolling(
    case: CaseFile,
    creepage: Annotated[
        list[str], typer.Option(help="Difference of the speeds over their mean; one or several.")
    ],
    normal_force: NormalForce = None,
    indentation: Indentation = None,
    points: Points = None,
    direction: Annotated[str, typer.Option(help="longitudinal or lateral.")] = "longitudinal",
    law: Annotated[
        str, typer.Option(help="plain, the springs of the method; calibrated, with Kalker's slope.")
    ] = "plain",
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Creep forces of the contact of a case that rolls, whose path may be left out; with -o its table and figure are written."""
    from pymdr.solving.rolling import rolling as roll

    def ask(contact: Contact) -> Study:
        return roll(
            contact,
            _spread(creepage, points, "", "creepage"),
            normal_force=normal_force,
            indentation=indentation,
            direction=direction,
            law=law,
        )

    _study("rolling", case, ask, output, quiet, as_json)


@app.command()
def sliding(
    case: CaseFile,
    speed: Annotated[list[str], typer.Option(help="Speed of sliding, such as '1 mm/s'; one or several.")],
    normal_force: NormalForce = None,
    indentation: Indentation = None,
    points: Points = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Friction of the contact of a case that slides over an elastomer; with -o its table and figure are written."""
    from pymdr.solving.sliding import sliding_friction

    def ask(contact: Contact) -> Study:
        return sliding_friction(
            contact,
            _spread(speed, points, "m/s", "speed"),
            normal_force=normal_force,
            indentation=indentation,
        )

    _study("sliding", case, ask, output, quiet, as_json)


@app.command()
def heat(
    case: CaseFile,
    speed: Annotated[list[str], typer.Option(help="Speed of sliding, such as '1 mm/s'; one or several.")],
    normal_force: NormalForce = None,
    indentation: Indentation = None,
    points: Points = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Temperature rise by friction of the contact of a case that slides slowly; with -o its table and figure are written."""
    from pymdr.solving.heating import frictional_heat

    def ask(contact: Contact) -> Study:
        return frictional_heat(
            contact,
            _spread(speed, points, "m/s", "speed"),
            normal_force=normal_force,
            indentation=indentation,
        )

    _study("heat", case, ask, output, quiet, as_json)


@app.command()
def joule(
    case: CaseFile,
    temperature: Annotated[str, typer.Option(help="Of both bodies, such as '20 degC'.")],
    voltage: Annotated[
        list[str] | None, typer.Option(help="Between the bodies, such as '50 mV'; one, or one for every row.")
    ] = None,
    current: Annotated[
        list[str] | None, typer.Option(help="The current in its place, such as '10 A'.")
    ] = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Largest temperature by a current through the contact of a case, row by row of its path; with -o its table and figure."""
    from pymdr.solving import solve
    from pymdr.solving.heating import joule_heating
    from pymdr.workbench.casefile import read_case

    def ask() -> tuple[str, Study]:
        asked = read_case(case)
        result = solve(asked.contact, asked.path, **asked.options)
        return asked.title, joule_heating(
            result, temperature=temperature, voltage=voltage or None, current=current or None
        )

    _tell_study("joule", case, ask, output, quiet, as_json)


@app.command()
def rough(
    case: Annotated[
        Path,
        typer.Argument(
            metavar="CASE.toml", help="The case file, with [surface] in the place of [profile] and [[path]]."
        ),
    ],
    normal_force: Annotated[
        list[str] | None, typer.Option(help="Force, such as '1 N'; one or several.")
    ] = None,
    indentation: Annotated[
        list[str] | None, typer.Option(help="Depths below the highest summit in its place, such as '1 um'.")
    ] = None,
    points: Points = None,
    realisations: Annotated[int, typer.Option(help="Lines of the ensemble.")] = 100,
    coefficient: Annotated[
        float | None,
        typer.Option(
            "--coefficient",
            help="lambda of C1D = lambda q C2D, the spectrum of the line; pi, of Geike, unless given.",
        ),
    ] = None,
    workers: Annotated[int | None, typer.Option(help="Threads; the numbers do not depend on them.")] = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Stiffness of a randomly rough surface that is pressed on a plane; with -o its table and figure are written."""
    from pymdr.solving.rough import press_rough
    from pymdr.workbench.casefile import read_rough_case

    def ask() -> tuple[str, Study]:
        asked = read_rough_case(case)
        return asked.title, press_rough(
            asked.surface,
            asked.body,
            asked.counterbody,
            normal_force=_spread(normal_force, points, "N", "normal-force") if normal_force else None,
            indentation=_spread(indentation, points, "m", "indentation") if indentation else None,
            realisations=realisations,
            coefficient=coefficient,
            radius=asked.radius,
            workers=workers,
        )

    _tell_study("rough", case, ask, output, quiet, as_json)


@app.command()
def press(
    case: Annotated[
        Path,
        typer.Argument(
            metavar="CASE.toml", help="The case file, with [surface] in the place of [profile] and [[path]]."
        ),
    ],
    normal_force: Annotated[
        list[str] | None, typer.Option(help="Force, such as '1 N'; one or several.")
    ] = None,
    indentation: Annotated[
        list[str] | None, typer.Option(help="Depths of the highest pixel in its place, such as '1 um'.")
    ] = None,
    points: Points = None,
    engine: Annotated[
        str | None,
        typer.Option(help="contactmechanics unless given, tamaas, aspher, or one of another package."),
    ] = None,
    keep: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Folder that keeps every load, from which a run goes on that was ended."
        ),
    ] = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Press a measured or random surface by boundary elements; with -o its table and figure are written."""
    from pymdr.presentation.text import in_bytes
    from pymdr.solving.press import bytes_of, patch_of
    from pymdr.solving.press import press as press_surface
    from pymdr.workbench.casefile import read_press_case

    def ask() -> tuple[str, Study]:
        asked, surface = read_press_case(case)
        patch, punch = patch_of(surface, asked.punch)
        forces = _spread(normal_force, points, "N", "normal-force") if normal_force else None
        depths = _spread(indentation, points, "m", "indentation") if indentation else None
        loads = forces if forces is not None else depths
        if not quiet and not as_json and loads is not None:
            nx, ny = patch.heights.shape
            needed = in_bytes(round(bytes_of((nx, ny), len(loads), engine)))
            _complain(f"{nx} x {ny} pixels at {len(loads)} loads take about {needed}")
        with _stages(quiet or as_json) as stage:
            return asked.title, press_surface(
                patch,
                asked.body,
                asked.counterbody,
                normal_force=forces,
                indentation=depths,
                punch=punch,
                engine=engine,
                keep=keep,
                progress=stage("pressing"),
            )

    _tell_study("press", case, ask, output, quiet, as_json)


@app.command()
def sweep(
    case: CaseFile,
    over: Annotated[
        list[str],
        typer.Option(
            help="A parameter with its values, such as 'body.young = 1 MPa, 2 MPa'; once for each parameter."
        ),
    ],
    points: Annotated[
        int | None,
        typer.Option(help="How many in all where two values are given, evenly in their logarithm."),
    ] = None,
    quantity: Annotated[
        list[str] | None, typer.Option(help="What is kept, such as normal_force; everything unless given.")
    ] = None,
    workers: Annotated[int, typer.Option(help="Processes; the numbers do not depend on them.")] = 1,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="DIR",
            help="Folder for sweep.nc and the figure; called again, a killed sweep goes on there.",
        ),
    ] = None,
    csv: Annotated[bool, typer.Option("--csv", help="Write sweep.csv too.")] = False,
    xlsx: Annotated[bool, typer.Option("--xlsx", help="Write sweep.xlsx too.")] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Solve a case for all combinations of some of its parameters; with -o the arrays and a figure are written."""
    import contextlib

    from pymdr.errors import ProblemError
    from pymdr.solving.sweep import sweep as solve_all
    from pymdr.workbench.casefile import read_case

    tables = _Tables(csv, xlsx)
    with _failures_as_json("sweep", case, as_json):
        tables.check()
        asked = read_case(case)
        grid: dict[str, FloatArray | list[str]] = {}
        for given in over:
            name, values = _swept(asked.contact, given, points)
            if name in grid:
                raise ProblemError(
                    f"--over {given!r}: {name} is given already; write all its values in one --over"
                )
            grid[name] = values
        folder = contextlib.nullcontext(None) if output is None else _ready_folder(output)
        options = {key: asked.options[key] for key in ("machine_stiffness", "keep") if key in asked.options}
        with folder as into, _stages(quiet or as_json) as stage:
            found = solve_all(
                asked.contact,
                asked.path,
                grid,
                quantities=quantity,
                workers=workers,
                folder=None if into is None else into / "parts",
                progress=stage("solving"),
                **options,
            )
            written = []
            if into is not None:
                found.save(into / "sweep.nc")
                written = [into / "sweep.nc", _write_figure(found.plot(), into / "sweep.png")]
                written += tables.write(found, into, "sweep")
    if as_json:
        _print_json(
            _answer(
                "sweep",
                case,
                title=asked.title,
                status="COMPLETED" if not found.failed else "PARTLY_FAILED",
                rows=found.data["status"].size,
                claims=_plain_claims(found.claims),
                written=[str(file) for file in written],
            )
        )
    elif not quiet:
        _say(asked.title or str(case))
        _say(found.summary())
        if written:
            _say("Written: " + ", ".join(str(file) for file in written))


def _swept(contact: Contact, given: str, points: int | None) -> tuple[str, FloatArray | list[str]]:
    """The name of a parameter and its values from ``name = value, value``."""
    from pymdr.errors import ProblemError
    from pymdr.problem.parameters import parameter_of

    name, sign, values = (part.strip() for part in given.partition("="))
    listed = [value.strip() for value in values.split(",") if value.strip()]
    if not sign or not name or not listed:
        raise ProblemError(
            f"--over {given!r}: a parameter with its values is needed, such as 'body.young = 1 MPa, 2 MPa'"
        )
    unit = "N/m" if name == "machine_stiffness" else parameter_of(contact, name).unit
    return name, _spread(listed, points if len(listed) == 2 else None, unit, f"over {name}")


@app.command()
def topography(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A measured surface.")],
    channel: Annotated[
        str | None, typer.Option(help="Number or name of the channel, where the file has several.")
    ] = None,
    size: Annotated[
        list[str] | None,
        typer.Option(
            help="Side of the square patch, or twice for both, where the file has none, such as '10 um'."
        ),
    ] = None,
    unit: Annotated[
        str | None, typer.Option(help="Unit of the heights, where the file has none, such as nm.")
    ] = None,
    missing: Annotated[
        str | None, typer.Option(help="What becomes of missing heights: interpolate or crop.")
    ] = None,
    detrend: Annotated[
        str | None,
        typer.Option(
            help="What is taken off: none, mean, plane, sphere or curvature; a plane unless given, none with --profile."
        ),
    ] = None,
    tip_radius: Annotated[
        str | None,
        typer.Option(help="Of the tip that measured it: waves it cannot have resolved are left out."),
    ] = None,
    periodic: Annotated[
        bool, typer.Option("--periodic", help="The patch is one period of the surface.")
    ] = False,
    profile: Annotated[
        bool,
        typer.Option(
            "--profile", help="The mean profile about the apex of one bump in place of the spectrum."
        ),
    ] = False,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """The power spectrum of a measured surface and its self-affine law; with -o its table and figure are written."""
    from pymdr.errors import ProblemError
    from pymdr.solving.azimuth import azimuthal_profile
    from pymdr.solving.roughness import power_spectrum
    from pymdr.workbench.topographies import described, read_topography

    def surface() -> Topography:
        taken = detrend or ("none" if profile else "plane")
        number = int(channel) if channel is not None and channel.isdecimal() else channel
        return read_topography(
            file,
            number,
            size=size or None,
            unit=unit,
            missing=missing,
            detrend=None if taken == "none" else taken,
        )

    def ask() -> tuple[str, Study]:
        found = surface()
        return described(found), power_spectrum(found, periodic=periodic, tip_radius=tip_radius)

    if not profile:
        _tell_study("topography", file, ask, output, quiet, as_json)
        return
    with _failures_as_json("topography", file, as_json):
        if tip_radius is not None or periodic:
            raise ProblemError(
                "--tip-radius and --periodic are for the spectrum; leave them out with --profile"
            )
        found = azimuthal_profile(surface())
        written = []
        if output is not None:
            with _ready_folder(output) as folder:
                found.to_csv(folder / "profile.csv")
                written = [folder / "profile.csv", _write_figure(found.plot(), folder / "profile.png")]
    if as_json:
        data = found.profile
        columns = {"radius": data.radius, "height": data.height, "scatter": data.scatter}
        study = {
            name: {"values": (values.tolist() if values is not None else []), "unit": "m"}
            for name, values in columns.items()
        }
        answer = _answer(
            "topography",
            file,
            title=described(found.topography),
            status="COMPLETED",
            rows=data.radius.size,
            study=study,
            notes=list(found.topography.steps),
            written=[str(one) for one in written],
        )
        _print_json(answer)
    elif not quiet:
        _say(described(found.topography))
        _say(found.summary())
        if written:
            _say("Written: " + ", ".join(str(one) for one in written))


def _spread(given: Sequence[str], points: int | None, unit: str, name: str) -> FloatArray | list[str]:
    """The values that are given, or so many between two of them."""
    import numpy as np

    from pymdr.errors import ProblemError
    from pymdr.units import to_si_array

    bare = [value for value in given if unit and re.fullmatch(r"\s*[-+.\d][-+.\deE]*\s*", value)]
    if bare:
        raise ProblemError(
            f"--{name} {bare[0]}: a unit is missing; write --{name} '{bare[0].strip()} {unit}'"
        )
    if points is None:
        return list(given)
    ends = to_si_array(list(given), unit, name=name)
    if ends.shape != (2,) or not np.all(ends > 0.0) or not 2 <= points <= _MOST_POINTS:
        raise ProblemError(
            f"--points {points} with --{name} {', '.join(given)}: give two above 0 and 2 to {_MOST_POINTS} points "
            "from the one to the other"
        )
    return np.geomspace(ends[0], ends[1], points)


_MOST_POINTS = 1000


def _study(
    command: str,
    case: Path,
    ask: Callable[[Contact], Study],
    output: Path | None,
    quiet: bool,
    as_json: bool,
) -> None:
    """Ask for a study of the contact of a case, write and tell it."""
    from pymdr.workbench.casefile import read_contact

    def asked() -> tuple[str, Study]:
        title, contact = read_contact(case)
        return title, ask(contact)

    _tell_study(command, case, asked, output, quiet, as_json)


def _tell_study(
    command: str,
    case: Path,
    ask: Callable[[], tuple[str, Study]],
    output: Path | None,
    quiet: bool,
    as_json: bool,
) -> None:
    """Ask for a study and the title of its case, write and tell it."""
    with _failures_as_json(command, case, as_json):
        title, found = ask()
        written = _write_found(found, output, command)
    if as_json:
        answer = _answer(
            command,
            case,
            title=title,
            status="COMPLETED",
            rows=next(iter(found.data.sizes.values())),
            study=_columns_of(found),
            claims=_plain_claims(found.claims),
            assumptions=_plain_assumptions(found.assumptions),
            notes=list(found.notes),
            written=[str(file) for file in written],
        )
        _print_json(answer)
    elif not quiet:
        _say(title or str(case))
        _say(found.summary())
        if written:
            _say("Written: " + ", ".join(str(file) for file in written))


def _columns_of(found: Study) -> dict[str, Any]:
    """Its columns as plain values."""
    return {
        str(name): {
            "values": [_finite(float(value)) for value in found.data[name].values.ravel()],
            "unit": found.data[name].attrs["units"],
        }
        for name in (*found.data.coords, *found.data.data_vars)
    }


def _write_found(found: Impact | Study, output: Path | None, name: str) -> list[Path]:
    """The table and the figure of what was found, where a folder is named for them."""
    if output is None:
        return []
    with _ready_folder(output) as folder:
        found.to_csv(folder / f"{name}.csv")
        return [folder / f"{name}.csv", _write_figure(found.plot(), folder / f"{name}.png")]


@app.command()
def law(
    case: CaseFile,
    to: Annotated[
        str | None,
        typer.Option(help="Largest indentation, such as '1 um'; the deepest of the path unless given."),
    ] = None,
    tolerance: Annotated[float, typer.Option(help="Largest relative error, 1e-7 to 1e-2.")] = 1e-6,
    name: Annotated[
        str | None,
        typer.Option(
            help="What the files and the names in the header begin with; that of the case unless given."
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="DIR", help="Folder for what is written; CASE unless given."),
    ] = None,
    xlsx: Annotated[bool, typer.Option("--xlsx", help="Write the table as a spreadsheet too.")] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """The law of force, stiffness and radius over the indentation: a table, a C header and a figure."""
    from pymdr.workbench.laws import law_of_case, name_for, write_law

    with _failures_as_json("law", case, as_json):
        _Tables(csv=True, xlsx=xlsx).check()
        called = name_for(case, name)
        with _ready_folder(output or _named_after(case)) as folder:
            title, found = law_of_case(case, to, tolerance)
            written = write_law(found, folder, called, xlsx)
            written.append(_write_figure(found.plot(), folder / f"{called}.png"))
    if as_json:
        answer = _answer(
            "law",
            case,
            title=title,
            status="COMPLETED",
            rows=found.table.knots.u.size,
            study=_columns_of(found),
            claims=_plain_claims(found.claims),
            assumptions=_plain_assumptions(found.assumptions),
            notes=list(found.notes),
            references=list(found.cite()),
            written=[str(file) for file in written],
        )
        _print_json(answer)
    elif not quiet:
        _say(title or str(case))
        _say(found.summary())
        _say("Written: " + ", ".join(str(file) for file in written))


@app.command()
def table(
    result_file: Annotated[
        Path, typer.Argument(metavar="RESULT", help="A file written by pymdr run, or its folder.")
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FILE", help="The table, a .csv or an .xlsx.")
    ],
    quantity: Annotated[
        list[str] | None,
        typer.Option(help="What is written, such as normal_force; everything stored unless given."),
    ] = None,
    unit: Annotated[
        list[str] | None,
        typer.Option(help="Units other than SI, such as indentation=um, once for each quantity."),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write a saved result as a table, with what its numbers rest on."""
    from pymdr.solving.reopening import open_result
    from pymdr.workbench.laws import named_units, write_result

    units = named_units(unit or [])
    file = result_file / "result.nc" if result_file.is_dir() else result_file
    write_result(open_result(file), output, quantity, units)
    if not quiet:
        _say(f"Written: {output}")


@app.command()
def plot(
    result_file: Annotated[
        Path, typer.Argument(metavar="RESULT", help="A file written by pymdr run, or its folder.")
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="DIR|FILE",
            help="Folder for the figures; or one file (.png, .pdf, .svg) for the overview.",
        ),
    ] = None,
    step: Annotated[int, typer.Option(help="Row to draw, counted from 0; -1 is the last.")] = -1,
    quiet: Quiet = False,
) -> None:
    """Draw the figures of a saved result, or its overview as a file for print."""
    from pymdr.solving.reopening import open_result

    file = result_file / "result.nc" if result_file.is_dir() else result_file
    result = open_result(file)
    picture = output is not None and output.suffix.lower() in _PICTURES and not output.is_dir()
    place = output.parent if output is not None and picture else output or file.parent
    with _ready_folder(place) as folder, _stages(quiet) as stage:
        if output is not None and picture:
            written = [_write_figure(result.plot(step), output)]
        else:
            written = _write_figures(result.figures(step), folder, stage("drawing"))
    if not quiet:
        _say("Written: " + ", ".join(str(file) for file in written))


@contextmanager
def _ready_folder(folder: Path) -> Iterator[Path]:
    """Make the folder and see that it takes files before any work is done; without result it goes again."""
    from pymdr.errors import FileError

    is_new = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".pymdr-probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise FileError(
            f"cannot write into {folder}: {error.strerror or error}; choose another with -o DIR"
        ) from error
    try:
        yield folder
    except BaseException:
        if is_new and not any(folder.iterdir()):
            folder.rmdir()
        raise


def _write_figures(
    figures: Mapping[str, Figure], folder: Path, progress: Callable[[int, int], None] | None
) -> list[Path]:
    files = []
    for name, figure in figures.items():
        files.append(_write_figure(figure, folder / f"{name}.png"))
        if progress is not None:
            progress(len(files), len(figures))
    return files


_PICTURES = (".png", ".pdf", ".svg")


def _write_figure(figure: Figure, file: Path) -> Path:
    from pymdr.presentation.files import write_whole

    write_whole(file, lambda beside: figure.savefig(beside, dpi=150))
    return file


Stage = Callable[[str], Callable[[int, int], None] | None]


@contextmanager
def _stages(silent: bool) -> Iterator[Stage]:
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


def _answer(command: str, case: Path, **told: Any) -> dict[str, Any]:
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
        "written": [],
        "error": None,
    }
    return {**empty, **told}


def _print_json(answer: Any) -> None:
    typer.echo(json.dumps(answer, indent=2, allow_nan=False))


def _plain_error(error: BaseException) -> dict[str, str]:
    return {"kind": type(error).__name__, "message": str(error)}


@contextmanager
def _failures_as_json(command: str, case: Path | Sequence[Path], as_json: bool) -> Iterator[None]:
    """Tell an error as JSON before it becomes one line."""
    from pymdr.errors import PymdrError

    try:
        yield
    except (PymdrError, MemoryError) as error:
        if as_json:
            cases = [case] if isinstance(case, Path) else case
            told = [_answer(command, c, status="FAILED", error=_plain_error(error)) for c in cases]
            _print_json(told[0] if len(told) == 1 else told)
        raise


def _finite(value: float | None) -> float | None:
    return value if value is not None and abs(value) < float("inf") else None


def _plain_claims(claims: Mapping[str, Claim]) -> dict[str, Any]:
    from pymdr.presentation.text import largest_error

    return {
        name: {
            "level": claim.level.name,
            "reason": claim.reason,
            "source": claim.source,
            "steps_valid": int(claim.where.sum()),
            "error": _finite(largest_error(claim)),
        }
        for name, claim in claims.items()
    }


def _plain_assumptions(assumptions: Sequence[Assumption]) -> list[dict[str, Any]]:
    return [
        {
            "name": a.name,
            "words": a.words,
            "measure": _finite(a.measure),
            "limit": _finite(a.limit),
            "met": a.met,
        }
        for a in assumptions
    ]
