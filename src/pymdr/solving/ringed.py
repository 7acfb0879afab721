"""The same history by boundary elements on rings, without the method."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ProblemError
from pymdr.independent.history import solve_steps
from pymdr.independent.rings import Rings, RingSolution
from pymdr.interpretation.validity import ring_claims
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.contact import Contact
from pymdr.problem.schedule import Stretch, uses
from pymdr.result import Result, Status
from pymdr.rows import taken
from pymdr.solving.normal import check_normal_path, refuse_tension
from pymdr.solving.reach import assumptions, map_to_line
from pymdr.solving.walk import Task, Told, solution, walk
from pymdr.units import FloatArray


@dataclass(frozen=True)
class _Rows:
    """Quantities by their names."""

    indentation: FloatArray
    normal_force: FloatArray
    contact_radius: FloatArray
    inner_contact_radius: FloatArray
    contact_area: FloatArray
    normal_stiffness: FloatArray
    mean_pressure: FloatArray
    elastic_energy: FloatArray


@dataclass(frozen=True)
class _RingLaw:
    """A history without memory, row by row."""

    contact: Contact
    modulus: float
    rings: Rings

    def start(self) -> Mapping[str, float]:
        return {}

    def where(self, state: Mapping[str, float]) -> Mapping[str, float]:
        return state

    def step(
        self, state: Mapping[str, float], asked: Stretch, kept: np.ndarray | None, told: Told | None
    ) -> tuple[_Rows, Mapping[str, float]]:
        if asked.by_force:
            refuse_tension(asked.leg, asked.normal)
        found = []
        for i, target in enumerate(asked.normal):
            if i and told is not None:
                told(i)
            found += [
                _quantities(solution, 0.0 if asked.by_force else float(target))
                for solution in solve_steps(
                    self.contact.profile, self.modulus, np.array([target]), asked.by_force, self.rings
                )
            ]
        rows = _Rows(*np.array(found).T)
        here = {name: float(getattr(rows, name)[-1]) for name in ("indentation", "normal_force")}
        return taken(rows, kept), here


def _quantities(solution: RingSolution | None, free_depth: float) -> tuple[float, ...]:
    if solution is None:
        return (free_depth, *(0.0,) * 7)
    return (
        solution.indentation,
        solution.force,
        solution.contact_radius,
        solution.zones[0][0],
        solution.contact_area,
        solution.stiffness,
        solution.mean_pressure,
        solution.energy,
    )


def solve_by_rings(task: Task) -> Result:
    """The same history by boundary elements on rings, without the method."""
    contact, rings = task.contact, task.solver
    if not isinstance(rings, Rings):
        raise ProblemError(f"solve: solver = {rings!r}; write solver=Rings(n=400), or leave it out")
    if contact.adhesion is not None or contact.friction is not None or uses(task.path, "travel"):
        raise ProblemError(
            "solve: the rings solve frictionless contacts without adhesion and machine; leave solver=Rings() out"
        )
    check_normal_path(task.path)
    moduli = effective_moduli(contact.body, contact.counterbody)
    if moduli.exponent != 0.0:
        raise ProblemError(
            f"solve: the rings know homogeneous half-spaces only, and the bodies are graded (exponent {moduli.exponent:g}); "
            "leave solver=Rings() out"
        )
    law = _RingLaw(contact, moduli.normal, rings)
    columns = vars(walk(task, law).rows)
    mapped = map_to_line(contact)
    return solution(
        task,
        columns,
        ring_claims(rings.n, columns["indentation"].size),
        assumptions=assumptions(contact, mapped, columns["contact_radius"]),
        status=Status.BY_RINGS,
        notes=mapped.notes,
        references=("johnson",),
    )
