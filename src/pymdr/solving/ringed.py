"""The history of a contact by boundary elements on rings, instead of the MDR."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from pymdr.errors import ProblemError
from pymdr.independent.history import RingHistory, gap_of, solve_steps
from pymdr.independent.memory import Bodies, RingMemory, follow_rings
from pymdr.independent.memory_zone import Attraction, Pulled, PulledSetting, follow_pulled
from pymdr.independent.rings import HALF_SPACE, Rings, RingSolution, Surface, solve_adhesion, solve_disk
from pymdr.independent.stacks import pair_of
from pymdr.interpretation.validity import Assumption, pulled_ring_claims, ring_claims, ring_memory_claims
from pymdr.mapping.moduli import effective_moduli
from pymdr.mapping.relaxation import Relaxation
from pymdr.problem.contact import Contact
from pymdr.problem.materials import common_exponent
from pymdr.problem.profiles import Sampled
from pymdr.problem.schedule import Stretch, uses
from pymdr.result import Result, Status
from pymdr.rows import taken
from pymdr.solving import memory
from pymdr.solving.mapped import Mapped, assumptions, half_space_assumptions, map_to_line, notes_of
from pymdr.solving.normal import check_normal_path, refuse_tension
from pymdr.solving.walk import Channels, Interpretation, LegProgress, Task, Walked, solution, walk
from pymdr.solving.zones import zone_relaxation
from pymdr.units import FloatArray

_FEWEST = 20
"""Number of rings below which the comparison uses more rings, not fewer."""
_FEWER = 0.618
"""Ratio of the numbers of rings in the comparison that estimates the error; chosen so that no edges coincide."""
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
    """The history of a contact by boundary elements on rings, instead of the MDR."""
    contact, rings = task.contact, _checked(task)
    if (exponent := common_exponent(contact.body, contact.counterbody)) != 0.0:
        raise ProblemError(
            f"the rings cover homogeneous half-spaces and layers only, and the bodies are graded (exponent {exponent:g}); "
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
    """Assumptions; on layers that slide on their base also the stress there, which is known for disks."""
    a, line = columns["contact_radius"], mapped.line
    disks = np.isclose(columns["contact_area"], np.pi * a * a, rtol=1e-9, atol=0.0)
    if contact.layered is None or not disks.all():
        return half_space_assumptions(contact, mapped, a)
    excess = np.where(a >= contact.profile.edge, columns["indentation"] - line.depth(a), 0.0)
    return assumptions(contact, mapped, a, excess)


def _checked(task: Task) -> Rings:
    contact, rings = task.contact, task.solver
    if not isinstance(rings, Rings):
        raise ProblemError(f"solver = {rings!r}; write solver=Rings(n=400), or leave it out")
    if (
        (contact.adhesion is not None and not (contact.is_viscoelastic and contact.is_cohesive))
        or contact.friction is not None
        or uses(task.path, "travel")
    ):
        raise ProblemError(
            "the rings solve frictionless contacts without machine, and without adhesion but that of a cohesive zone on bodies with "
            "memory; leave solver=Rings() out"
        )
    check_normal_path(task.path)
    return rings


def _step(
    contact: Contact,
    rings: Rings,
    _: None,
    stretch: Stretch,
    kept: np.ndarray | None,
    progress: LegProgress | None,
) -> tuple[dict[str, FloatArray], None, Channels]:
    """Row by row, without memory."""
    if stretch.by_force:
        refuse_tension(stretch.leg, stretch.normal)
    solutions: list[RingSolution | None] = []
    for target in stretch.normal:
        if solutions and progress is not None:
            progress(len(solutions))
        solutions += ring_solutions(contact, np.array([target]), stretch.by_force, rings)
    rows = {
        name: np.array([0.0 if solution is None else value(solution) for solution in solutions])
        for name, value in _QUANTITIES.items()
    }
    if not stretch.by_force:
        free = np.array([solution is None for solution in solutions])
        rows["indentation"] = np.where(free, stretch.normal, rows["indentation"])
    here = {name: float(rows[name][-1]) for name in ("indentation", "normal_force")}
    return taken(rows, kept), None, here


def ring_solutions(
    contact: Contact, targets: FloatArray, by_force: bool, rings: Rings
) -> list[RingSolution | None]:
    """Elastic contacts at some indentations in m, or forces in N; None out of contact."""
    surface, modulus = _pressed(contact)
    return solve_steps(contact.profile, modulus, targets, by_force, rings, surface)


def adhesive_disks(
    contact: Contact, radii: FloatArray, depths: FloatArray, works: FloatArray, rings: Rings
) -> Iterator[RingSolution]:
    """
    Contacts of some radii in m, pulled at their edges by works of adhesion in J/m^2.

    Where the edge is at a corner of the profile or rests (work NaN), the indentation in m is prescribed instead.
    """
    surface, modulus = _pressed(contact)
    profile, gap = contact.profile, gap_of(contact.profile)
    marks = () if isinstance(profile, Sampled) else tuple(profile.breakpoints)
    corners = np.array([*marks, profile.edge])
    for a, d, work in zip(radii.tolist(), depths.tolist(), works.tolist(), strict=True):
        fixed = math.isnan(work) or bool(np.any(np.abs(corners - a) <= 1e-9 * a))
        solve, prescribed = (solve_disk, d) if fixed else (solve_adhesion, work)
        yield solve(gap, a, prescribed, modulus, n=rings.n, breakpoints=marks, surface=surface)


def _pressed(contact: Contact) -> tuple[Surface, float]:
    """The surface and its E* in Pa; for layers that of the top layers."""
    if contact.layered is None:
        return HALF_SPACE, effective_moduli(contact.body, contact.counterbody).normal
    pair = pair_of(contact.body, contact.counterbody)
    return pair, pair.modulus


@dataclass(frozen=True)
class _Remembered:
    solutions: np.ndarray
    """(rows,) of RingSolution, None without contact."""
    change: FloatArray
    """Change by the extrapolation to zero step length."""
    answer: FloatArray
    """The force in N, or the indentation in m under prescribed forces."""
    coarse: FloatArray
    """The same with fewer rings."""
    prescribed: FloatArray
    """The indentation where it is prescribed, else NaN."""


def solve_memory_by_rings(task: Task) -> Result:
    """The history of bodies with memory, by boundary elements on rings."""
    rings = _checked(task)
    walked = _walk_memory(task, rings)
    rows = walked.rows
    columns = {
        name: np.array([0.0 if one is None else value(one) for one in rows.solutions])
        for name, value in _QUANTITIES.items()
    }
    columns["indentation"] = _depths(rows)
    fewer, length = _discretization_error(rows), None
    if task.contact.adhesion is None:
        claims = ring_memory_claims(rings.n, rows.change, fewer)
        length = np.array(
            [0.0 if one is None else one.stiffness / (2.0 * one.modulus) for one in rows.solutions]
        )
    else:
        claims = pulled_ring_claims(rings.n, fewer)
        columns["cohesive_radius"] = np.array(
            [0.0 if one is None else one.cohesive_radius for one in rows.solutions]
        )
        del columns["normal_stiffness"]
    return solution(
        task,
        walked,
        Interpretation(
            columns=columns,
            claims=claims,
            assumptions=memory.assumptions_with_memory(
                task.contact, columns["contact_radius"], float(np.nanmax(columns["indentation"]))
            ),
            status=Status.BY_RINGS,
            notes=notes_of(task.contact.profile),
            references=("johnson",),
            is_viscoelastic=True,
            conducting=length,
        ),
    )


def _discretization_error(rows: _Remembered) -> FloatArray:
    """Difference by fewer rings, relative to the largest force, or indentation where forces are prescribed."""
    difference, forced = np.abs(rows.answer - rows.coarse), np.isnan(rows.prescribed)
    for own in (forced, ~forced):
        difference[own] /= float(np.max(np.abs(rows.answer[own]), initial=0.0)) or 1.0
    return memory.later_too(difference, np.ones(difference.size))


def _depths(rows: _Remembered) -> FloatArray:
    depths = [np.nan if one is None else one.indentation for one in rows.solutions]
    return np.where(np.isnan(rows.prescribed), np.nan_to_num(depths), rows.prescribed)


def _walk_memory(task: Task, rings: Rings) -> Walked[_Remembered]:
    if task.contact.adhesion is not None:
        relaxation = zone_relaxation(task.contact, memory.span_along(task.contact, task.path))
        memory.refuse_rigid(relaxation)
        longest = math.inf if relaxation.rubbery > 0.0 else memory.times_along(task.path)[1]
        return walk(task, None, partial(_step_pulled, task.contact, relaxation, rings, longest))
    relaxation = memory.relaxation_along(task.contact, task.path)
    return walk(task, None, partial(_step_with_memory, task.contact, relaxation, rings))


def _fewer(rings: Rings) -> Rings:
    return Rings(max(round(_FEWER * rings.n), _FEWEST) if rings.n > _FEWEST else 2 * rings.n)


def _step_pulled(
    contact: Contact,
    relaxation: Relaxation,
    rings: Rings,
    longest: float,
    state: tuple[Pulled, ...] | None,
    stretch: Stretch,
    kept: np.ndarray | None,
    progress: LegProgress | None,
) -> tuple[_Remembered, tuple[Pulled, ...], Channels]:
    """A cohesive zone with memory, with two numbers of rings and lengths of steps."""
    law = contact.adhesion
    assert law is not None
    assert law.cohesive_stress is not None
    memory.refuse_sudden(stretch, relaxation)
    attraction = Attraction(law.cohesive_stress, law.work / law.cohesive_stress)
    time, target = (
        np.append(stretch.begin, memory.times_of(stretch)),
        np.append(stretch.start[0], stretch.normal),
    )
    bodies = Bodies(contact.profile)
    legs = [
        follow_pulled(
            PulledSetting(bodies, relaxation, attraction, stretch.by_force, each, longest), time, target, one
        )
        for one, each in zip(state or (None, None), (rings, _fewer(rings)), strict=True)
    ]
    fine, coarse = (leg.solutions for leg in legs)
    rows, here = _rows_of(stretch, fine, coarse, np.zeros(len(fine)))
    return taken(rows, kept), tuple(leg.state for leg in legs), here


def _rows_of(
    stretch: Stretch,
    fine: list[RingSolution | None],
    coarse: list[RingSolution | None],
    change: FloatArray,
) -> tuple[_Remembered, Channels]:
    """The rows of a leg by two numbers of rings, and where it ends."""
    solutions = np.empty(stretch.normal.size, dtype=object)
    solutions[:] = fine
    answer, other = (
        np.array(
            [0.0 if one is None else (one.indentation if stretch.by_force else one.force) for one in rows]
        )
        for rows in (fine, coarse)
    )
    prescribed = np.full(solutions.size, np.nan) if stretch.by_force else stretch.normal
    rows = _Remembered(solutions, change, answer, other, prescribed)
    here = {
        "indentation": float(_depths(rows)[-1]),
        "normal_force": 0.0 if fine[-1] is None else fine[-1].force,
    }
    return rows, here


def _step_with_memory(
    contact: Contact,
    relaxation: Relaxation,
    rings: Rings,
    state: tuple[RingMemory | None, RingMemory | None] | None,
    stretch: Stretch,
    kept: np.ndarray | None,
    progress: LegProgress | None,
) -> tuple[_Remembered, tuple[RingMemory | None, RingMemory | None], Channels]:
    if stretch.by_force:
        refuse_tension(stretch.leg, stretch.normal)
    memory.refuse_sudden(stretch, relaxation)
    touched = state is not None and state[0] is not None
    start = stretch.start[0] if touched else min(stretch.start[0], 0.0)
    time, target = np.append(stretch.begin, memory.times_of(stretch)), np.append(start, stretch.normal)
    before = (None, None) if state is None else state
    surface = HALF_SPACE if contact.layered is None else pair_of(contact.body, contact.counterbody)
    bodies = Bodies(contact.profile, surface)
    leg, compared = (
        follow_rings(bodies, relaxation, time, target, stretch.by_force, one, each)
        for one, each in zip(before, (rings, _fewer(rings)), strict=True)
    )
    rows, here = _rows_of(stretch, leg.solutions, compared.solutions, leg.change)
    return taken(rows, kept), (leg.state, compared.state), here


def ring_history_with_memory(task: Task) -> RingHistory:
    """The history from which fields of a contact with memory are computed, solved again."""
    assert isinstance(task.solver, Rings)
    rows = _walk_memory(task, task.solver).rows
    return RingHistory(task.contact.profile, tuple(rows.solutions), _depths(rows))
