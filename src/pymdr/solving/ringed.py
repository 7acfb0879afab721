"""The same history by boundary elements on rings, without the method."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from pymdr.errors import ProblemError
from pymdr.independent.history import RingHistory, gap_of, solve_steps
from pymdr.independent.memory import RingMemory, follow_rings
from pymdr.independent.rings import HALF_SPACE, Rings, RingSolution, Surface, solve_adhesion, solve_disk
from pymdr.independent.stacks import stack_of
from pymdr.interpretation.validity import Assumption, ring_claims, ring_memory_claims
from pymdr.mapping.moduli import effective_moduli
from pymdr.mapping.relaxation import Relaxation
from pymdr.problem.contact import Contact
from pymdr.problem.materials import common_exponent
from pymdr.problem.profiles import Sampled
from pymdr.problem.schedule import Stretch, uses
from pymdr.result import Result, Status
from pymdr.rows import taken
from pymdr.solving.memory import (
    assumptions_with_memory,
    later_too,
    refuse_sudden,
    relaxation_along,
    times_of,
)
from pymdr.solving.normal import check_normal_path, refuse_tension
from pymdr.solving.reach import Mapped, assumptions, half_space_assumptions, map_to_line, notes_of
from pymdr.solving.walk import Channels, Interpretation, Task, Told, Walked, solution, walk
from pymdr.units import FloatArray

_FEWEST = 20
"""Rings below which more of them, and not fewer, tell how far they err."""
_FEWER = 0.618
"""Part of the rings that tells how far all of them err: one whose edges lie elsewhere."""
_QUANTITIES: dict[str, Callable[[RingSolution], float]] = {
    "indentation": lambda s: s.indentation,
    "normal_force": lambda s: s.force,
    "contact_radius": lambda s: s.contact_radius,
    "inner_contact_radius": lambda s: s.zones[0][0] if s.zones else 0.0,
    "contact_area": lambda s: s.contact_area,
    "normal_stiffness": lambda s: s.stiffness,
    "mean_pressure": lambda s: s.mean_pressure,
    "elastic_energy": lambda s: s.energy,
}


def solve_by_rings(task: Task) -> Result:
    """The same history by boundary elements on rings, without the method."""
    contact, rings = task.contact, _checked(task)
    if (exponent := common_exponent(contact.body, contact.counterbody)) != 0.0:
        raise ProblemError(
            f"solve: the rings know homogeneous half-spaces and layers only, and the bodies are graded (exponent {exponent:g}); "
            "leave solver=Rings() out"
        )
    walked = walk(task, None, partial(_step, contact, rings))
    columns = walked.rows
    mapped = map_to_line(contact)
    return solution(
        task,
        walked,
        Interpretation(
            columns=columns,
            claims=ring_claims(rings.n, columns["indentation"].size, contact.layered is not None),
            assumptions=_assumptions(contact, mapped, columns),
            status=Status.BY_RINGS,
            notes=mapped.notes,
            references=("johnson",),
            conducting=columns["normal_stiffness"] / (2.0 * mapped.moduli.normal),
        ),
    )


def _assumptions(contact: Contact, mapped: Mapped, columns: dict[str, FloatArray]) -> tuple[Assumption, ...]:
    """Of layers that slide on their base too, if the contacts are disks, of which the line knows the stress there."""
    a, line = columns["contact_radius"], mapped.line
    disks = np.isclose(columns["contact_area"], np.pi * a * a, rtol=1e-9, atol=0.0)
    if contact.layered is None or not disks.all():
        return half_space_assumptions(contact, mapped, a)
    excess = np.where(a >= contact.profile.edge, columns["indentation"] - line.depth(a), 0.0)
    return assumptions(contact, mapped, a, excess)


def _checked(task: Task) -> Rings:
    contact, rings = task.contact, task.solver
    if not isinstance(rings, Rings):
        raise ProblemError(f"solve: solver = {rings!r}; write solver=Rings(n=400), or leave it out")
    if contact.adhesion is not None or contact.friction is not None or uses(task.path, "travel"):
        raise ProblemError(
            "solve: the rings solve frictionless contacts without adhesion and machine; leave solver=Rings() out"
        )
    check_normal_path(task.path)
    return rings


def _step(
    contact: Contact,
    rings: Rings,
    _: None,
    asked: Stretch,
    kept: np.ndarray | None,
    told: Told | None,
) -> tuple[dict[str, FloatArray], None, Channels]:
    """Row by row, without memory."""
    if asked.by_force:
        refuse_tension(asked.leg, asked.normal)
    found: list[RingSolution | None] = []
    for target in asked.normal:
        if found and told is not None:
            told(len(found))
        found += ring_solutions(contact, np.array([target]), asked.by_force, rings)
    rows = {
        name: np.array([0.0 if solution is None else value(solution) for solution in found])
        for name, value in _QUANTITIES.items()
    }
    if not asked.by_force:
        free = np.array([solution is None for solution in found])
        rows["indentation"] = np.where(free, asked.normal, rows["indentation"])
    here = {name: float(rows[name][-1]) for name in ("indentation", "normal_force")}
    return taken(rows, kept), None, here


def ring_solutions(
    contact: Contact, targets: FloatArray, by_force: bool, rings: Rings
) -> list[RingSolution | None]:
    """Elastic contacts at some indentations in m, or forces in N; None where nothing is touched."""
    surface, modulus = _pressed(contact)
    return solve_steps(contact.profile, modulus, targets, by_force, rings, surface)


def adhesive_disks(
    contact: Contact, radii: FloatArray, depths: FloatArray, work: float, rings: Rings
) -> Iterator[RingSolution]:
    """
    Contacts of some radii in m, pulled at their edges by a work of adhesion in J/m^2.

    Where a corner of the profile holds the edge, which is pulled less, they have the indentations in m that are given.
    """
    surface, modulus = _pressed(contact)
    profile, gap = contact.profile, gap_of(contact.profile)
    marks = () if isinstance(profile, Sampled) else tuple(profile.breakpoints)
    corners = np.array([*marks, profile.edge])
    for a, d in zip(radii.tolist(), depths.tolist(), strict=True):
        held = bool(np.any(np.abs(corners - a) <= 1e-9 * a))
        solve, asked = (solve_disk, d) if held else (solve_adhesion, work)
        yield solve(gap, a, asked, modulus, n=rings.n, breakpoints=marks, surface=surface)


def _pressed(contact: Contact) -> tuple[Surface, float]:
    """What is pressed, and its E* in Pa; of layers that of the top one."""
    layered = contact.layered
    if layered is None:
        return HALF_SPACE, effective_moduli(contact.body, contact.counterbody).normal
    stack = stack_of(layered)
    return stack, stack.modulus


@dataclass(frozen=True)
class _Remembered:
    solutions: np.ndarray
    """(rows,) of RingSolution, None before anything was touched."""
    change: FloatArray
    """What the extrapolation to steps without length changed."""
    answer: FloatArray
    """The force in N, or the indentation in m under prescribed forces."""
    coarse: FloatArray
    """What fewer rings make of it."""
    prescribed: FloatArray
    """The indentation where it is prescribed, else nan."""


def solve_memory_by_rings(task: Task) -> Result:
    """The history of bodies that remember, by rings of which each does."""
    rings = _checked(task)
    walked = _walk_memory(task, rings)
    rows = walked.rows
    columns = {
        name: np.array([0.0 if one is None else value(one) for one in rows.solutions])
        for name, value in _QUANTITIES.items()
    }
    columns["indentation"] = _depths(rows)
    return solution(
        task,
        walked,
        Interpretation(
            columns=columns,
            claims=ring_memory_claims(rings.n, rows.change, _made_otherwise(rows)),
            assumptions=assumptions_with_memory(task.contact, columns["contact_radius"]),
            status=Status.BY_RINGS,
            notes=notes_of(task.contact.profile),
            references=("johnson",),
            remembers=True,
            conducting=np.array(
                [0.0 if one is None else one.stiffness / (2.0 * one.modulus) for one in rows.solutions]
            ),
        ),
    )


def _made_otherwise(rows: _Remembered) -> FloatArray:
    """What fewer rings tell, of the largest force, or indentation where forces are prescribed."""
    apart, forced = np.abs(rows.answer - rows.coarse), np.isnan(rows.prescribed)
    for own in (forced, ~forced):
        apart[own] /= float(np.max(np.abs(rows.answer[own]), initial=0.0)) or 1.0
    return later_too(apart, np.ones(apart.size))


def _depths(rows: _Remembered) -> FloatArray:
    found = [np.nan if one is None else one.indentation for one in rows.solutions]
    return np.where(np.isnan(rows.prescribed), np.nan_to_num(found), rows.prescribed)


def _walk_memory(task: Task, rings: Rings) -> Walked[_Remembered]:
    relaxation = relaxation_along(task.contact, task.path)
    return walk(task, None, partial(_step_with_memory, task.contact, relaxation, rings))


def _step_with_memory(
    contact: Contact,
    relaxation: Relaxation,
    rings: Rings,
    state: tuple[RingMemory | None, RingMemory | None] | None,
    asked: Stretch,
    kept: np.ndarray | None,
    told: Told | None,
) -> tuple[_Remembered, tuple[RingMemory | None, RingMemory | None], Channels]:
    if asked.by_force:
        refuse_tension(asked.leg, asked.normal)
    refuse_sudden(asked, relaxation)
    touched = state is not None and state[0] is not None
    start = asked.start[0] if touched else min(asked.start[0], 0.0)
    time, target = np.append(asked.begin, times_of(asked)), np.append(start, asked.normal)
    before = (None, None) if state is None else state
    other = Rings(max(round(_FEWER * rings.n), _FEWEST) if rings.n > _FEWEST else 2 * rings.n)
    leg, compared = (
        follow_rings(contact.profile, relaxation, time, target, asked.by_force, one, each)
        for one, each in zip(before, (rings, other), strict=True)
    )
    solutions = np.empty(asked.normal.size, dtype=object)
    solutions[:] = leg.solutions
    answer, coarse = (
        np.array([0.0 if one is None else (one.indentation if asked.by_force else one.force) for one in rows])
        for rows in (leg.solutions, compared.solutions)
    )
    rows = _Remembered(
        solutions,
        leg.change,
        answer,
        coarse,
        np.full(solutions.size, np.nan) if asked.by_force else asked.normal,
    )
    last = leg.solutions[-1]
    here = {"indentation": float(_depths(rows)[-1]), "normal_force": 0.0 if last is None else last.force}
    return taken(rows, kept), (leg.state, compared.state), here


def ring_history_with_memory(task: Task) -> RingHistory:
    """What fields of a contact with memory are computed from, followed again."""
    assert isinstance(task.solver, Rings)
    rows = _walk_memory(task, task.solver).rows
    return RingHistory(task.contact.profile, tuple(rows.solutions), _depths(rows))
