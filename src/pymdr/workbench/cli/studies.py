"""``pymdr impact``, ``yield``, ``shakedown``, ``pull-off``, ``fatigue``, ``rolling``, ``sliding``, ``heat`` and ``joule``, and ``wear`` along one cycle: studies of cases."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pymdr.errors import ProblemError
from pymdr.workbench.cli.folders import ready_output, write_study
from pymdr.workbench.cli.options import CaseFile, Json, Points, Quiet, Table, spread, values_of
from pymdr.workbench.cli.reporting import (
    failures_as_json,
    report_answer,
    report_study,
    study_command,
    with_unit,
)

if TYPE_CHECKING:
    from pymdr.solving.study import Study

NormalForce = Annotated[str | None, typer.Option(help="Constant load, such as '1 N'.")]
Indentation = Annotated[str | None, typer.Option(help="Constant indentation instead, such as '10 um'.")]
Side = Annotated[
    str | None, typer.Option(help="Side: body or counterbody; by default the first whose stress is known.")
]
Speeds = Annotated[
    list[str], typer.Option(help="Sliding speed, such as '1 mm/s', or several: '1 mm/s, 2 mm/s'.")
]


def impact(
    case: CaseFile,
    mass: Annotated[str, typer.Option(help="Reduced mass, such as '33 g'.")],
    speed: Annotated[
        list[str],
        typer.Option(
            help="Speed at the first touch, such as '0.3 m/s'; several give a table of restitution."
        ),
    ],
    angle: Annotated[
        str | None, typer.Option(help="Angle of incidence from the normal, such as '40 deg'.")
    ] = None,
    inertia: Annotated[
        str | None, typer.Option(help="Moment of inertia, such as '1 g*cm^2'; by default of a solid ball.")
    ] = None,
    radius: Annotated[
        str | None, typer.Option(help="Distance from centre to contact point; by default of the ball.")
    ] = None,
    spin: Annotated[str | None, typer.Option(help="Angular velocity, such as '10 rad/s'.")] = None,
    points: Points = None,
    output: Table = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Simulate impacts at one or several speeds; needs no [[path]]."""
    from pymdr.quantities import quantity
    from pymdr.solving.impacts import impact as collide
    from pymdr.solving.impacts import restitution
    from pymdr.workbench.casefile import read_contact

    oblique = {"angle": angle, "inertia": inertia, "radius": radius, "spin": spin}
    given: dict[str, Any] = {name: value for name, value in oblique.items() if value is not None}
    speeds = values_of(speed)

    def rebounds() -> tuple[str, Study]:
        title, contact = read_contact(case)
        if given:
            raise ProblemError(
                f"--{next(iter(given))} applies to oblique impacts at one speed; give one --speed, or leave "
                "the option out"
            )
        return title, restitution(contact, mass=mass, speeds=spread(speed, points, "m/s", "speed"))

    if len(speeds) > 1:
        report_study("impact", case, rebounds, output, quiet, as_json)
        return
    with failures_as_json("impact", case, as_json), ready_output(output):
        if points is not None:
            spread(speed, points, "m/s", "speed")
        title, contact = read_contact(case)
        study = collide(contact, mass=mass, speed=speeds[0], **given)
        written = write_study(study, output, "impact")

    def own() -> dict[str, Any]:
        numbers = {
            name: with_unit(value, quantity(name).unit)
            for values in study.groups().values()
            for name, value in values.items()
        }
        return {"rows": study.data.sizes["step"], "impact": numbers}

    report_answer("impact", case, title, study, written, quiet, as_json, own)


@study_command("yield")
def yields(
    case: CaseFile,
    strength: Annotated[
        list[str], typer.Option(help="Yield strength, such as '1.2 GPa'; repeatable, one per layer.")
    ],
    tensile_strength: Annotated[
        list[str] | None,
        typer.Option(help="Largest tension at the first crack, such as '70 MPa'; repeatable, one per layer."),
    ] = None,
    bond_strength: Annotated[
        str | None, typer.Option(help="Shear strength of the interfaces of layers, such as '300 MPa'.")
    ] = None,
    side: Side = None,
    force_ratio: Annotated[
        float | None, typer.Option(help="With friction: tangential over normal force; sliding unless given.")
    ] = None,
) -> tuple[str, Study]:
    """Load and place of first yield or crack; needs no [[path]]."""
    from pymdr.solving.yielding import first_yield
    from pymdr.workbench.casefile import read_contact

    title, contact = read_contact(case)
    return title, first_yield(
        contact,
        strength=values_of(strength),
        tensile_strength=values_of(tensile_strength or []) or None,
        bond_strength=bond_strength,
        side=side,
        force_ratio=force_ratio,
    )


@study_command("shakedown")
def shakedown(
    case: CaseFile,
    strength: Annotated[str, typer.Option(help="Yield strength, such as '1.2 GPa'.")],
    force_ratio: Annotated[
        list[str] | None,
        typer.Option(help="Tangential over normal force, or several: '0, 0.1, 0.2'; sliding unless given."),
    ] = None,
    side: Side = None,
) -> tuple[str, Study]:
    """Load of shakedown in rolling and sliding; needs no [[path]]."""
    from pymdr.solving.shakedown import shakedown as limits_of
    from pymdr.workbench.casefile import read_contact

    title, contact = read_contact(case)
    ratios = None if force_ratio is None else values_of(force_ratio)
    return title, limits_of(contact, strength=strength, force_ratio=ratios, side=side)


@study_command("pull_off")
def pull_off(
    case: CaseFile,
    preload: Annotated[str | None, typer.Option(help="Force before the retraction, such as '1 mN'.")] = None,
    pressed_to: Annotated[str | None, typer.Option(help="Indentation instead, such as '10 um'.")] = None,
    speed: Annotated[
        list[str] | None,
        typer.Option(help="With memory: speed of retraction, or several: '1 um/s, 10 um/s'."),
    ] = None,
    dwell: Annotated[
        list[str] | None, typer.Option(help="With memory: time at rest, or several: '1 s, 10 s'.")
    ] = None,
    approach_speed: Annotated[
        str | None, typer.Option(help="With memory: speed of approach, such as '10 um/s'.")
    ] = None,
    machine_stiffness: Annotated[
        str | None,
        typer.Option(
            help="Machine stiffness, such as '5 N/m'; by default that of [solve], or infinite; 0 is a dead load."
        ),
    ] = None,
    edge: Annotated[
        bool, typer.Option("--edge", help="With memory: work of the edge over its speed instead.")
    ] = False,
    tolerance: Annotated[
        float | None, typer.Option(help="Cohesive zone with memory: error of the force, 1e-6 to 1e-2.")
    ] = None,
    points: Points = None,
) -> tuple[str, Study]:
    """Pull-off of an adhesive contact; needs no [[path]]."""
    from pymdr.workbench.case_studies import pull_off_arguments, pull_off_of
    from pymdr.workbench.casefile import read_contact, read_tables

    title, contact = read_contact(case)
    tables = read_tables(case)
    of_case = pull_off_arguments(tables.get("solve", {}), tables.get("pull_off", {}))
    if preload is not None or pressed_to is not None:
        of_case = {name: value for name, value in of_case.items() if name not in ("preload", "pressed_to")}
    options = {
        "machine_stiffness": 0.0 if machine_stiffness == "0" else machine_stiffness,
        "pressed_to": pressed_to,
        "preload": preload,
        "speed": None if speed is None else spread(speed, points, "m/s", "speed"),
        "dwell": None if dwell is None else values_of(dwell),
        "approach_speed": approach_speed,
        "edge": edge or None,
        "tolerance": tolerance,
    }
    given = {name: value for name, value in options.items() if value is not None}
    return title, pull_off_of(contact, **{**of_case, **given})


@study_command("fatigue")
def fatigue(
    case: CaseFile,
    criterion: Annotated[
        str,
        typer.Option(help="dang-van, findley, fatemi-socie, smith-watson-topper, ruiz-work or ruiz-damage."),
    ],
    slope: Annotated[
        str | None,
        typer.Option(help="Weight of the mean stress (dang-van) or normal stress (findley, fatemi-socie)."),
    ] = None,
    yield_strength: Annotated[
        str | None, typer.Option(help="Yield strength (fatemi-socie), such as '500 MPa'.")
    ] = None,
    limit: Annotated[
        str | None, typer.Option(help="Endurance limit in the unit of the criterion, such as '250 MPa'.")
    ] = None,
    bulk: Annotated[
        str | None, typer.Option(help="Constant bulk stress along the shift, such as '50 MPa'.")
    ] = None,
    bulk_amplitude: Annotated[
        str | None, typer.Option(help="Bulk stress in phase with the tangential force, such as '80 MPa'.")
    ] = None,
    side: Side = None,
) -> tuple[str, Study]:
    """Fatigue over the last cycle of the path: place and plane."""
    from pymdr.solving.fatigue import criterion_of, cycled_bulk
    from pymdr.solving.fatigue import fatigue as endangered
    from pymdr.solving.verb import solve
    from pymdr.workbench.casefile import read_case

    chosen = criterion_of(criterion, slope=slope, yield_strength=yield_strength, limit=limit)
    problem = read_case(case)
    result = solve(problem.contact, problem.path, **problem.options)
    added = cycled_bulk(result, bulk, bulk_amplitude)
    return problem.title, endangered(result, criterion=chosen, side=side, superposed=added)


@study_command("rolling")
def rolling(
    case: CaseFile,
    creepage: Annotated[
        list[str], typer.Option(help="Creepage: difference of the speeds over their mean; repeatable.")
    ],
    normal_force: NormalForce = None,
    indentation: Indentation = None,
    points: Points = None,
    direction: Annotated[
        str, typer.Option(help="Direction of creep: longitudinal or lateral.")
    ] = "longitudinal",
    law: Annotated[
        str, typer.Option(help="plain (MDR springs) or calibrated (with Kalker's slope).")
    ] = "plain",
) -> tuple[str, Study]:
    """Creep forces of rolling; the case needs no [[path]]."""
    from pymdr.solving.rolling import rolling as roll
    from pymdr.workbench.casefile import read_contact

    title, contact = read_contact(case)
    return title, roll(
        contact,
        spread(creepage, points, "", "creepage"),
        normal_force=normal_force,
        indentation=indentation,
        direction=direction,
        law=law,
    )


@study_command("sliding")
def sliding(
    case: CaseFile,
    speed: Speeds,
    normal_force: NormalForce = None,
    indentation: Indentation = None,
    points: Points = None,
) -> tuple[str, Study]:
    """Friction of sliding on an elastomer; needs no [[path]]."""
    from pymdr.solving.sliding import sliding_friction
    from pymdr.workbench.casefile import read_contact

    title, contact = read_contact(case)
    speeds = spread(speed, points, "m/s", "speed")
    return title, sliding_friction(contact, speeds, normal_force=normal_force, indentation=indentation)


@study_command("heat")
def heat(
    case: CaseFile,
    speed: Speeds,
    normal_force: NormalForce = None,
    indentation: Indentation = None,
    points: Points = None,
) -> tuple[str, Study]:
    """Temperature rise of slow sliding; the case needs no [[path]]."""
    from pymdr.solving.heating import frictional_heat
    from pymdr.workbench.casefile import read_contact

    title, contact = read_contact(case)
    speeds = spread(speed, points, "m/s", "speed")
    return title, frictional_heat(contact, speeds, normal_force=normal_force, indentation=indentation)


@study_command("wear")
def wear(
    case: CaseFile,
    coefficient: Annotated[
        str, typer.Option(help="Wear coefficient, such as '1e-6 mm^3/(N m)', for energy '1e-6 mm^3/J'.")
    ],
    cycles: Annotated[
        list[str], typer.Option(help="Number of cycles, or the numbers at which rows are wanted.")
    ],
    law: Annotated[str, typer.Option(help="archard (load times path) or energy.")] = "archard",
    profile: Annotated[
        Path | None, typer.Option(help="CSV for the worn profile, radius and height, that [profile] reads.")
    ] = None,
) -> tuple[str, Study]:
    """Fretting wear over many cycles; [[path]] is one cycle."""
    from pymdr.solving.wear import wear as wear_out
    from pymdr.workbench.casefile import read_case
    from pymdr.workbench.worn import write_worn_profile

    problem = read_case(case)
    numbers = values_of(cycles)
    study = wear_out(problem.contact, problem.path, coefficient=coefficient, cycles=numbers, law=law)
    if profile is not None:
        write_worn_profile(study, profile)
    return problem.title, study


@study_command("joule")
def joule(
    case: CaseFile,
    temperature: Annotated[str, typer.Option(help="Temperature of both bodies, such as '20 degC'.")],
    voltage: Annotated[
        list[str] | None,
        typer.Option(help="Voltage between the bodies, such as '50 mV'; one, or one per row."),
    ] = None,
    current: Annotated[
        list[str] | None, typer.Option(help="Current in place of the voltage, such as '10 A'.")
    ] = None,
) -> tuple[str, Study]:
    """Temperature rise by electric current in every row of the path."""
    from pymdr.solving.heating import joule_heating
    from pymdr.solving.verb import solve
    from pymdr.workbench.casefile import read_case

    problem = read_case(case)
    result = solve(problem.contact, problem.path, **problem.options)
    return problem.title, joule_heating(
        result, temperature=temperature, voltage=voltage or None, current=current or None
    )
