"""The same history by boundary elements on rings, without the method."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pymdr.errors import ProblemError
from pymdr.independent.history import solve_steps
from pymdr.independent.rings import Rings, RingSolution
from pymdr.interpretation.validity import BoolArray, ring_claims
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath
from pymdr.problem.schedule import Controls, Progress, known_legs, stretch, times, total_rows, uses
from pymdr.result import Result, Status, labelled
from pymdr.solving.normal import check_normal_path, refuse_tension
from pymdr.solving.reach import assumptions, map_to_line
from pymdr.units import FloatArray


def solve_by_rings(contact: Contact, path: LoadingPath, rings: Rings, progress: Progress | None) -> Result:
    """The same history by boundary elements on rings, without the method."""
    if not isinstance(rings, Rings):
        raise ProblemError(f"solve: solver = {rings!r}; write solver=Rings(n=400), or leave it out")
    if contact.adhesion is not None or contact.friction is not None or uses(path, "travel"):
        raise ProblemError(
            "solve: the rings solve frictionless contacts without adhesion and machine; leave solver=Rings() out"
        )
    check_normal_path(path)
    moduli = effective_moduli(contact.body, contact.counterbody)
    found: list[RingSolution | None] = []
    prescribed: list[FloatArray] = []
    forced: list[BoolArray] = []
    controls = Controls()
    here = {"indentation": 0.0, "normal_force": 0.0}
    total = total_rows(path)
    for leg in known_legs(path):
        rows = stretch(leg, controls, here)
        controls, targets, by_force = rows.controls, rows.normal, rows.by_force
        if by_force:
            refuse_tension(targets)
        for target in targets:
            found += solve_steps(contact.profile, moduli.normal, np.array([target]), by_force, rings)
            if progress is not None:
                progress(len(found), total)
        prescribed.append(targets)
        forced.append(np.full(targets.size, by_force))
        last = found[-1]
        force, d = (0.0, 0.0) if last is None else (last.force, last.indentation)
        here = {"indentation": d, "normal_force": force, controls.normal: float(targets[-1])}
    wanted, is_forced = np.concatenate(prescribed), np.concatenate(forced)
    zero = np.where(is_forced, 0.0, wanted)
    columns = {
        "indentation": np.array(
            [d if s is None else s.indentation for s, d in zip(found, zero, strict=True)]
        ),
        "normal_force": _each(found, lambda s: s.force),
        "contact_radius": _each(found, lambda s: s.contact_radius),
        "inner_contact_radius": _each(found, lambda s: s.zones[0][0]),
        "contact_area": _each(found, lambda s: s.contact_area),
        "normal_stiffness": _each(found, lambda s: s.stiffness),
        "mean_pressure": _each(found, lambda s: s.mean_pressure),
        "elastic_energy": _each(found, lambda s: s.energy),
    }
    time = times(path)
    if time is not None:
        columns = {"time": time, **columns}
    mapped = map_to_line(contact)
    return Result(
        contact=contact,
        path=path,
        data=labelled(columns),
        claims=ring_claims(rings.n, wanted.size),
        assumptions=assumptions(contact, mapped, columns["contact_radius"]),
        status=Status.BY_RINGS,
        notes=mapped.notes,
        references=("johnson",),
        rings=rings,
    )


def _each(found: list[RingSolution | None], value: Callable[[RingSolution], float]) -> FloatArray:
    return np.array([0.0 if solution is None else value(solution) for solution in found])
