"""Impacts of bodies with memory."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.closure import ASSUMED
from pymdr.interpretation.memory import LineState, surface_load
from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.line.rebound import Motion, energies, largest_force, motion_rows, rebound
from pymdr.problem.contact import Contact, is_curve
from pymdr.problem.materials import Elastic, Rigid
from pymdr.problem.paths import indent
from pymdr.result import Result
from pymdr.solving.colliding import Course
from pymdr.solving.impacts.interpreting import NOT_MEASURED, QUASI_STATIC, interpret, with_numbers
from pymdr.solving.impacts.value import Event, Impact, ImpactRequest
from pymdr.solving.memory import powers_of
from pymdr.solving.rebounding import Target, followed
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, written

_PARTS, _LOOKS, _RADII = 8, 120, 64
"""Parts of a step for energies, and numbers of rows and radii for pressures."""
_WITHIN = 0.97
"""Largest radius for pressures relative to the contact radius; beyond it there are too few springs."""
_WORK = 8e7
"""Products of rows, springs and branches beyond which steps are divided in fewer parts."""
_AUDIT = 1e-3
_ROUNDING = 1e-15
_FAINT = 1e-9
"""Rebound speed relative to the impact speed, below which it may be a rounding error."""


def remembering(request: ImpactRequest) -> Impact:
    """An impact of bodies with memory."""
    contact, mass, speed = request.contact, request.mass, request.normal
    target, motion = followed(contact, mass, (speed, speed))
    halved = _halved(target, motion, mass, speed)
    course = _course(target, motion, request.steps)
    # of the shape alone: slopes, tips and errors of the map
    solved = solve(Contact(contact.profile, Elastic(1.0, 0.5), Rigid()), indent(motion.deepest))
    largest = _unbounded(solved, target)
    fine = _audited(motion, course, 1, _LOOKS if largest is None else 0)
    coarse = _audited(motion, course, 2, _LOOKS // 2 if largest is None else 0)
    energy = 0.5 * mass * speed * speed
    energy_lost = 0.5 * mass * (speed - motion.rebound_speed) * (speed + motion.rebound_speed)
    # the error of the sums of springs is proportional to the width of their parts
    kept = float(2.0 * (fine.stored[-1] + fine.dissipated[-1]) - (coarse.stored[-1] + coarse.dissipated[-1]))
    balance = Assumption(
        "energy balance",
        "relative residual; kinetic energy lost minus energy stored and dissipated in the springs",
        abs(energy_lost - kept) / energy,
        _AUDIT,
    )
    events = [Event("touch", 0.0, 0.0)]
    if motion.rests:
        events.append(Event("rest", float(course.time[-1]), motion.deepest))
    else:
        events.append(Event("turning point", motion.turning_time, motion.deepest))
        events.append(Event("separation", motion.contact_time, motion.last_depth))
    result = interpret(request, course, solved, SOURCES["ting"], balance, tuple(events))
    errors = _errors(motion, motion if halved is None else halved)
    # a difference of squares, small where nearly all is given back
    returned = motion.rebound_speed / speed
    unsure = max(errors["rebound_speed"], _ROUNDING) + target.relaxation.error
    errors["energy_lost"] = min(unsure * 2.0 * returned**2 / max(1.0 - returned**2, _ROUNDING), 1.0)
    for name, own, other in (
        ("elastic_energy", fine.stored, coarse.stored),
        ("dissipated_energy", fine.dissipated, coarse.dissipated),
    ):
        errors[name] = float(np.max(np.abs(own - other))) / energy
    if largest is None and fine.pressure > 0.0:
        errors["largest_pressure"] = abs(coarse.pressure / fine.pressure - 1.0)
    numbers = {
        "restitution": motion.rebound_speed / speed,
        "rebound_speed": motion.rebound_speed,
        "energy_lost": energy_lost,
        "sticking_speed": 0.0,
        "largest_force": largest_force(motion)[1],
        "largest_pressure": fine.pressure if largest is None else largest,
    }
    energies_of_rows = {"elastic_energy": fine.stored, "dissipated_energy": fine.dissipated}
    return replace(
        with_numbers(result, numbers, energies_of_rows),
        claims=_claims(result.claims, solved, errors, target),
        assumptions=tuple(a for a in result.assumptions if a.name != "elastic similarity"),
        notes=(*solved.notes, NOT_MEASURED, *_notes(target, motion)),
    )


def _halved(target: Target, motion: Motion, mass: float, speed: float) -> Motion | None:
    """The motion in steps of half the length."""
    try:
        return rebound(target.curves, target.relaxation, mass, speed, target.first / speed, halved=motion)
    except ConvergenceError as error:
        if motion.rebound_speed > _FAINT * speed:
            raise
        raise ConvergenceError(
            f"the rebound speed is below the rounding error, about {motion.rebound_speed / speed:.1g} of "
            f"{written(speed, 'm/s', 6)}: the bodies practically stick; use a lower viscosity, shorter relaxation times or a larger mass"
        ) from error


def _course(target: Target, motion: Motion, steps: int) -> Course:
    """Rows of the history, midway between an even distribution over the steps and one over time."""
    begin, turn = motion.steps[:, 0], motion.turn
    stretches = [begin[: turn + 1]] + ([] if motion.rests else [begin[turn:]])
    parts = [np.zeros(1)]
    for marks in stretches:
        fraction = np.linspace(0.0, 1.0, steps // len(stretches) + 1)[1:]
        by_step = np.interp(fraction * (marks.size - 1), np.arange(marks.size), marks)
        by_clock = marks[0] + (marks[-1] - marks[0]) * np.sin(0.5 * math.pi * fraction) ** 2
        parts.append(0.5 * (by_step + by_clock))
        parts[-1][-1] = marks[-1]
    time = np.concatenate(parts)
    rows = motion_rows(motion, time)
    if not motion.rests:  # separation, but for rounding of the time
        rows.force[-1] = rows.radius[-1] = 0.0
    middle = time.size - 1 if motion.rests else int(np.argmax(time >= motion.turning_time))
    return Course(
        time, rows.depth, rows.velocity, rows.force, rows.radius, sticks=motion.rests, deepest=middle
    )


class _Audit(NamedTuple):
    """Energies of the rows in J, and the largest pressure in Pa."""

    stored: FloatArray
    dissipated: FloatArray
    pressure: float


def _audited(motion: Motion, course: Course, coarser: int, looks: int = 0) -> _Audit:
    begin, width = motion.steps[:-1, 0, None], np.diff(motion.steps[:, 0])[:, None]
    parts = _PARTS
    while parts > 2 and (parts * begin.size) ** 2 * motion.relaxation.times.size > _WORK:
        parts //= 2
    inner = begin + width * np.arange(0.0, 1.0, coarser / parts)
    near = np.searchsorted(course.time, inner)
    gaps = np.abs(inner - course.time[[np.maximum(near - 1, 0), np.minimum(near, course.time.size - 1)]])
    time = np.union1d(inner[gaps.min(axis=0) > 0.01 * width], course.time)
    audit, radius = energies(motion, time), motion_rows(motion, time).radius
    rows = np.searchsorted(time, course.time)
    seen = np.linspace(0, time.size - 1, looks).astype(int)[1:-1]
    # a mass that comes to rest touches its last springs almost simultaneously
    distinct = np.diff(audit.position, prepend=0.0) > 1e-9 * audit.position[-1]
    x, load = audit.position[distinct], audit.load[:, distinct]
    loads = [LineState(x, load[i], load[i], float(radius[i])) for i in seen]
    return _Audit(
        audit.stored[rows],
        audit.dissipated[rows],
        max((_largest(line, _RADII // coarser) for line in loads if line.radius > 0.0), default=0.0),
    )


def _largest(line: LineState, radii: int) -> float:
    """The largest pressure of a line within its edge."""
    return float(np.max(surface_load(line, line.radius * np.linspace(0.0, _WITHIN, radii))))


def _unbounded(solved: Result, target: Target) -> float | None:
    """The largest pressure if it is known in advance: inf, or NaN for a force curve."""
    if is_curve(target.contact):
        return math.nan
    tip = math.isinf(float(solved["peak_pressure"].values[0]))
    return math.inf if tip or _presses_at_edges(target) else None


def _presses_at_edges(target: Target) -> bool:
    """Whether the pressure is unbounded at the edge of a growing contact: with dashpots, and powers of time from 1/2 on."""
    powers = powers_of(target.contact)
    return target.relaxation.viscosity > 0.0 or max((p.exponent for p in powers), default=0.0) >= 0.5


def _errors(motion: Motion, halved: Motion) -> dict[str, float]:
    """Relative changes by halving every step."""

    def change(value: float, other: float) -> float:
        return 0.0 if value == other else abs(other / value - 1.0)

    # the computed speeds, even above the impact speed
    speed = change(*(0.0 if one.rests else -float(one.steps[-1, 3]) for one in (motion, halved)))
    depth = change(motion.deepest, halved.deepest)
    return {
        "restitution": speed,
        "rebound_speed": speed,
        "contact_time": change(motion.contact_time, halved.contact_time),
        "largest_force": change(largest_force(motion)[1], largest_force(halved)[1]),
        "largest_indentation": depth,
        "largest_radius": depth,
    }


def _claims(
    claims: Mapping[str, Claim], solved: Result, errors: dict[str, float], target: Target
) -> dict[str, Claim]:
    """The claims of the shape, with the errors of the steps; that the contact is a disk under pressure only is proved."""
    kernel = target.relaxation.error
    remark = f"; the kernel of the rheology has an error of at most {kernel:.1g}" if kernel > 0.0 else ""
    shape = solved.claims["normal_force"]
    curve = is_curve(target.contact)
    shaped = f"{ASSUMED}; viscoelastic and" if curve else "exact for viscoelastic half-spaces on a disk,"
    reason = (
        f"{shaped} frictionless: the force is compressive, so there is one approach and one retraction, in which no spring is "
        f"touched again and the load of the line decreases outward{remark}; {QUASI_STATIC}"
    )
    source = f"{SOURCES['lee-radok']}; {SOURCES['ting']}"
    mapped = 0.0 if shape.error is None else float(np.max(shape.error))
    base = replace(shape, reason=reason, source=source, where=shape.where[:1], error=np.array([mapped]))
    names = (*claims, "elastic_energy", "dissipated_energy")
    claims_of_motion = with_errors(
        dict.fromkeys(names, base),
        {name: np.array([mapped + kernel + errors.get(name, 0.0)]) for name in names},
        "; errors are the changes by halving every step, and for energies by halving the parts of steps, relative to the kinetic energy",
        "as the steps do",
    )
    if curve:
        if shape.error is None:
            claims_of_motion = {
                name: replace(claim, level=Level.APPROXIMATE, error=None)
                for name, claim in claims_of_motion.items()
            }
        return claims_of_motion | {name: claims[name] for name in ("largest_radius", "largest_pressure")}
    peak = claims_of_motion["largest_pressure"]
    claims_of_motion["largest_pressure"] = replace(
        peak,
        level=Level.APPROXIMATE,
        reason=(
            f"{peak.reason}; computed from the load of the line within {_WITHIN:g} of the contact radius; its error is the change with half as "
            "many springs, rows and radii"
        ),
    )
    return claims_of_motion


def _notes(target: Target, motion: Motion) -> tuple[str, ...]:
    notes = []
    if target.span is not None:
        first, last = (written(t, "s") for t in target.span)
        notes.append(
            f"the power law of time is a sum of {target.relaxation.moduli.size} exponentials from {first} to {last}, with an error of at most "
            f"{target.relaxation.error:.1g}; faster relaxation keeps its impulse"
        )
    if motion.rests:
        notes.append(
            "one of the bodies is a liquid too viscous for a rebound: the other one comes to rest in it"
        )
    return tuple(notes)
