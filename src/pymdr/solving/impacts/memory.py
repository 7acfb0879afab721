"""Impacts of bodies with memory."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.memory import LineState, pressure
from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.line.memory import follow_springs, line_state, springs_to, virgin
from pymdr.line.rebound import Motion, largest_force, motion_rows, rebound
from pymdr.problem.contact import Contact
from pymdr.problem.materials import Elastic, Rigid
from pymdr.problem.paths import indent
from pymdr.result import Result, labelled
from pymdr.solving.colliding import Course
from pymdr.solving.impacts.asking import Asked
from pymdr.solving.impacts.telling import QUASI_STATIC, told
from pymdr.solving.impacts.value import Event, Impact
from pymdr.solving.rebounding import Ground, followed, powers_of, sketched
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, written

_SPRINGS, _PARTS, _LOOKS = 500, 4, 50
"""Springs that follow the motion found, moves between two rows for them, and how often their pressure is looked at."""
_FEWEST, _WORK = 200, 4000
_AUDIT = 1e-3
_FIELD_ERROR = 5e-3
"""Of the largest pressure: what the distance of the springs and of the looks at them does."""


def remembering(asked: Asked) -> Impact:
    """Bodies with memory, one of which is hit and gives back a part of what it takes."""
    contact, mass, speed = asked.contact, asked.mass, asked.normal
    ground, motion = followed(contact, mass, (speed, speed))
    halved = rebound(ground.curves, ground.relaxation, mass, speed, ground.first / speed, halved=motion)
    course = _course(ground, motion, asked.steps)
    springs = _sprung(ground, motion, course, 1)
    coarse = _sprung(ground, motion, course, 2)
    # of the shape alone: slopes, tips and what the map says of it
    solved = solve(Contact(contact.profile, Elastic(1.0, 0.5), Rigid()), indent(motion.deepest))
    energy = 0.5 * mass * speed * speed
    lost = 0.5 * mass * (speed - motion.rebound_speed) * (speed + motion.rebound_speed)
    kept = float(springs.stored[-1] + springs.dissipated[-1])
    balance = Assumption(
        "energy balance",
        "kinetic energy that is lost less what springs that follow the motion keep and their dashpots take, over the first,",
        abs(lost - kept) / energy,
        _AUDIT,
    )
    events = [Event("touch", 0.0, 0.0)]
    if motion.rests:
        events.append(Event("rest", float(course.time[-1]), motion.deepest))
    else:
        events.append(Event("turning point", motion.turning_time, motion.deepest))
        events.append(Event("separation", motion.contact_time, motion.last_depth))
    found = told(asked, course, solved, SOURCES["ting"], balance, tuple(events))
    errors = _errors(motion, motion if halved is None else halved)
    for name, own, other in (
        ("elastic_energy", springs.stored, coarse.stored),
        ("dissipated_energy", springs.dissipated, coarse.dissipated),
    ):
        errors[name] = float(np.max(np.abs(own - other))) / energy
    peak = _peak(ground, float(solved["peak_pressure"].values[0]), springs.pressure)
    return replace(
        found,
        data=found.data.merge(
            labelled({"elastic_energy": springs.stored, "dissipated_energy": springs.dissipated})
        ),
        restitution=motion.rebound_speed / speed,
        rebound_speed=motion.rebound_speed,
        energy_lost=lost,
        sticking_speed=0.0,
        largest_force=largest_force(motion)[1],
        largest_pressure=peak,
        claims=_claims(found.claims, solved, errors, ground),
        assumptions=tuple(a for a in found.assumptions if a.name != "elastic similarity"),
        notes=(*solved.notes, *_notes(ground, motion)),
    )


def _course(ground: Ground, motion: Motion, steps: int) -> Course:
    """Rows of the history: a half of them follows the steps, which are short where much happens, a half the clock."""
    begin, turn = motion.steps[:, 0], motion.turn
    stretches = [begin[: turn + 1]] + ([] if motion.rests else [begin[turn:]])
    parts = [np.zeros(1)]
    for marks in stretches:
        moves = steps // (2 * len(stretches))
        share = np.linspace(0.0, marks.size - 1.0, moves // 2 + 1)
        by_step = np.interp(share, np.arange(marks.size), marks)[1:]
        by_clock = marks[0] + (marks[-1] - marks[0]) * 0.5 * (
            1.0 - np.cos(math.pi * (np.arange(moves - moves // 2) + 0.5) / (moves - moves // 2))
        )
        parts.append(np.sort(np.concatenate([by_step, by_clock])))
    time = np.concatenate(parts)
    rows = motion_rows(motion, time)
    middle = time.size - 1 if motion.rests else int(np.argmax(time >= motion.turning_time))
    return Course(
        time, rows.depth, rows.velocity, rows.force, rows.radius, sticks=motion.rests, deepest=middle
    )


class _Springs(NamedTuple):
    """What springs do that follow a motion, one entry per row; the largest pressure of some looks at them."""

    stored: FloatArray
    dissipated: FloatArray
    pressure: float


def _sprung(ground: Ground, motion: Motion, course: Course, coarser: int) -> _Springs:
    parts, waits = _PARTS // coarser, np.diff(course.time)
    time = course.time[:-1, None] + waits[:, None] * (np.arange(1.0, parts + 1.0) / parts)
    time[:, -1] = course.time[1:]
    depth = motion_rows(motion, time.ravel()).depth.reshape(time.shape)
    relaxation = sketched(ground, float(course.time[-1]))
    n = min(_SPRINGS, max(_FEWEST, _WORK // max(relaxation.moduli.size, 1))) // coarser
    state = replace(virgin(), springs=springs_to(ground.line, motion.deepest, n))
    stored, dissipated, peaks = [np.zeros(1)], [np.zeros(1)], [0.0]
    for rows in np.array_split(np.arange(waits.size), min(_LOOKS // coarser**3, waits.size)):
        found = follow_springs(ground.line, relaxation, time[rows].ravel(), depth[rows].ravel(), state)
        state = found.state
        stored.append(found.stored[parts - 1 :: parts])
        dissipated.append(found.dissipated[parts - 1 :: parts])
        radius = float(found.contact_radius[-1])
        x, w, load = line_state(state, relaxation)
        peaks.append(_largest(LineState(x, w, load, radius)) if radius > 0.0 else 0.0)
    return _Springs(np.concatenate(stored), np.concatenate(dissipated), max(peaks))


def _largest(line: LineState) -> float:
    """The largest pressure of a line within its edge, where that of a dashpot has no bound."""
    return float(np.max(pressure(line, line.radius * np.linspace(0.0, 0.97, 64))))


def _peak(ground: Ground, shape: float, found: float) -> float:
    """The largest pressure in Pa; inf under tips and edges that are sharp, and at the edge of a contact that grows on fluid."""
    powers = powers_of(ground.contact)
    fluid = ground.relaxation.viscosity > 0.0 and (not powers or max(p.exponent for p in powers) >= 0.5)
    return math.inf if fluid or math.isinf(shape) else found


def _errors(motion: Motion, halved: Motion) -> dict[str, float]:
    """What halving every step changes, relative."""

    def change(value: float, other: float) -> float:
        return 0.0 if value == other else abs(other / value - 1.0)

    speed = change(motion.rebound_speed, halved.rebound_speed)
    depth = change(motion.deepest, halved.deepest)
    return {
        "restitution": speed,
        "rebound_speed": speed,
        "energy_lost": speed,
        "contact_time": change(motion.contact_time, halved.contact_time),
        "largest_force": change(largest_force(motion)[1], largest_force(halved)[1]),
        "largest_indentation": depth,
        "largest_radius": depth,
    }


def _claims(
    claims: Mapping[str, Claim], solved: Result, errors: dict[str, float], ground: Ground
) -> dict[str, Claim]:
    """Those of the shape, with what the steps add; that the contact is a disk with pressure only is proved, not measured."""
    kernel = ground.relaxation.error
    remark = f"; the kernel of the rheology errs by at most {kernel:.1g}" if kernel > 0.0 else ""
    shape = solved.claims["normal_force"]
    reason = (
        "exact for viscoelastic half-spaces in frictionless contact on a disk: the force only pushes, so that there is one "
        "approach and one retreat, on which no spring is touched again and the load of the line falls outward"
        f"{remark}; {QUASI_STATIC}"
    )
    source = f"{SOURCES['lee-radok']}; {SOURCES['ting']}"
    mapped = 0.0 if shape.error is None else float(np.max(shape.error))
    base = replace(shape, reason=reason, source=source, where=shape.where[:1], error=np.array([mapped]))
    names = (*claims, "elastic_energy", "dissipated_energy")
    found = with_errors(
        dict.fromkeys(names, base),
        {name: np.array([mapped + kernel + errors.get(name, 0.0)]) for name in names},
        "; errors are what halving every step changes, and those of energies what half as many springs do",
        "as the steps do",
    )
    peak = found["largest_pressure"]
    found["largest_pressure"] = replace(
        peak,
        level=Level.APPROXIMATE,
        reason=f"{peak.reason}; read from springs",
        error=np.array([_FIELD_ERROR]),
    )
    return found


def _notes(ground: Ground, motion: Motion) -> tuple[str, ...]:
    notes = []
    if ground.span is not None:
        first, last = (written(t, "s") for t in ground.span)
        notes.append(
            f"the power of time is {ground.relaxation.moduli.size} exponentials from {first} to {last}, which err by at most "
            f"{ground.relaxation.error:.1g}; what is faster is a dashpot of the same impulse"
        )
    if motion.rests:
        notes.append(
            "one of the bodies is a liquid that is too viscous to throw the other one back: it comes to rest in it"
        )
    return tuple(notes)
