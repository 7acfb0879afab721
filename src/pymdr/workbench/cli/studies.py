"""``pymdr impact``, ``rolling``, ``sliding``, ``heat`` and ``joule``: what is asked of a contact beside its path."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pymdr.workbench.cli.folders import write_found
from pymdr.workbench.cli.options import CaseFile, Json, Points, Quiet, Table, spread
from pymdr.workbench.cli.telling import (
    answer,
    failures_as_json,
    print_json,
    say_found,
    tell_study,
    validity_of,
    with_unit,
)

if TYPE_CHECKING:
    from pymdr.problem.contact import Contact
    from pymdr.solving.study import Study

NormalForce = Annotated[str | None, typer.Option(help="The constant load, such as '1 N'.")]
Indentation = Annotated[str | None, typer.Option(help="The constant depth in its place, such as '10 um'.")]
Speeds = Annotated[list[str], typer.Option(help="Speed of sliding, such as '1 mm/s'; one or several.")]


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
    from pymdr.solving.impacts import impact as collide
    from pymdr.workbench.casefile import read_contact

    with failures_as_json("impact", case, as_json):
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
        written = write_found(found, output, "impact")
    if as_json:
        told = answer(
            "impact",
            case,
            written,
            title=title,
            status="COMPLETED",
            rows=found.data.sizes["step"],
            impact={
                name: with_unit(value, quantity(name).unit)
                for values in found.groups().values()
                for name, value in values.items()
            },
            **validity_of(found),
        )
        print_json(told)
    elif not quiet:
        say_found(title or str(case), found.summary(), written)


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
            spread(creepage, points, "", "creepage"),
            normal_force=normal_force,
            indentation=indentation,
            direction=direction,
            law=law,
        )

    _study("rolling", case, ask, output, quiet, as_json)


def sliding(
    case: CaseFile,
    speed: Speeds,
    normal_force: NormalForce = None,
    indentation: Indentation = None,
    points: Points = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Friction of the contact of a case that slides over an elastomer; with -o its table and figure are written."""
    from pymdr.solving.sliding import sliding_friction

    ask = _at_speeds(sliding_friction, speed, points, normal_force=normal_force, indentation=indentation)
    _study("sliding", case, ask, output, quiet, as_json)


def heat(
    case: CaseFile,
    speed: Speeds,
    normal_force: NormalForce = None,
    indentation: Indentation = None,
    points: Points = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Temperature rise by friction of the contact of a case that slides slowly; with -o its table and figure are written."""
    from pymdr.solving.heating import frictional_heat

    ask = _at_speeds(frictional_heat, speed, points, normal_force=normal_force, indentation=indentation)
    _study("heat", case, ask, output, quiet, as_json)


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
    from pymdr.solving.heating import joule_heating
    from pymdr.solving.verb import solve
    from pymdr.workbench.casefile import read_case

    def ask() -> tuple[str, Study]:
        asked = read_case(case)
        result = solve(asked.contact, asked.path, **asked.options)
        return asked.title, joule_heating(
            result, temperature=temperature, voltage=voltage or None, current=current or None
        )

    tell_study("joule", case, ask, output, quiet, as_json)


def _at_speeds(
    find: Callable[..., Study], speed: Sequence[str], points: int | None, **load: str | None
) -> Callable[[Contact], Study]:
    """What is found of a contact that slides under a load at every speed."""
    return lambda contact: find(contact, spread(speed, points, "m/s", "speed"), **load)


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

    tell_study(command, case, asked, output, quiet, as_json)
