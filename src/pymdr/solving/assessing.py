"""The claims of a contact before its history is solved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.independent.rings import Rings
from pymdr.interpretation.validity import Assumption, Claim
from pymdr.line.foundation import normal_force
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath
from pymdr.problem.schedule import ends_only, known_legs, total_rows
from pymdr.result import Claims, Result, Status
from pymdr.solving.normal import check_normal_path, claims_of, follow_normal, normal_status
from pymdr.solving.reach import assumptions, map_to_line
from pymdr.solving.verb import check_problem, kept_rows, read_stiffness, refuse_beyond_memory, solve
from pymdr.units import QuantityLike

_SHORT = 100_000
"""Rows that are followed in no time."""


@dataclass(frozen=True)
class Assessment:
    """What can be claimed of a contact along a path, before its history is solved."""

    claims: Mapping[str, Claim]
    assumptions: tuple[Assumption, ...]
    notes: tuple[str, ...]
    largest: Mapping[str, float]
    """Largest indentation (m), normal force (N) and contact radius (m) that the path reaches."""
    rows: int
    """Number of rows that :func:`solve` keeps."""
    columns: int
    """Number of quantities over them."""
    status: Status
    """How the solution ends, or how that of the visited rows does."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "claims", Claims(self.claims))

    @property
    def memory(self) -> int:
        """Bytes that the arrays of the result take; solving a long history takes about twice as much."""
        return 8 * self.rows * self.columns

    def summary(self) -> str:
        """The claims and assumptions as a text."""
        from pymdr.presentation.text import assessment

        return assessment(self.largest, self.claims, self.assumptions, self.notes, self.rows, self.memory)

    def _repr_html_(self) -> str:
        """The summary as tables, for notebooks."""
        from pymdr.presentation.html import assessment_html

        return assessment_html(
            self.largest, self.claims, self.assumptions, self.notes, self.rows, self.memory
        )

    def __str__(self) -> str:
        return self.summary()


def assess(
    contact: Contact,
    path: LoadingPath,
    *,
    machine_stiffness: QuantityLike | None = None,
    keep: int | ArrayLike | None = None,
    solver: Rings | None = None,
) -> Assessment:
    """
    Map a contact and state its claims for the loads that a path reaches.

    The claims are those of :func:`solve` for the rows of the path. With adhesion or friction a path of more than
    100 000 rows visits the ends of its legs only.

    Parameters
    ----------
    contact : Contact
    path : LoadingPath
    machine_stiffness, keep, solver : optional
        As for :func:`solve`; with `solver` the ends of the legs are solved.

    Returns
    -------
    Assessment
        Claims for every row of the path, assumptions and notes.

    Raises
    ------
    ProblemError, PathError
        As :func:`solve`.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.paths import load
    >>> from pymdr.problem.profiles import Sphere
    >>> ball = Contact(Sphere("10 mm"), Elastic("210 GPa", 0.3))
    >>> assess(ball, load("50 N")).claims["pressure"].level.name
    'EXACT'
    """
    check_problem(contact, path)
    rows = total_rows(path)
    if solver is not None:
        ends = solve(contact, _extremes(path), machine_stiffness=machine_stiffness, keep=keep, solver=solver)
        return _assessed(ends, rows)
    kept = kept_rows(keep, path) if contact.friction is not None else None
    route = path if rows <= _SHORT else _extremes(path)
    if contact.adhesion is not None or contact.friction is not None:
        result = solve(contact, route, machine_stiffness=machine_stiffness)
        return _assessed(result, rows if kept is None else kept.size)
    check_normal_path(path)
    refuse_beyond_memory(path)
    stiffness = None if machine_stiffness is None else read_stiffness(machine_stiffness)
    history = follow_normal(contact, map_to_line(contact), path, stiffness)
    mapped, states = history.mapped, history.states
    claims, disk = claims_of(contact, history)
    if stiffness is not None:
        claims["travel"] = claims["normal_force"]
    deepest = int(np.argmax(states.indentation))
    largest = {
        "indentation": float(states.indentation[deepest]),
        "normal_force": float(normal_force(mapped.line, states.take(slice(deepest, deepest + 1)))[0]),
        "contact_radius": float(states.contact_radius[deepest]),
    }
    found = assumptions(contact, mapped, states.contact_radius)
    status = normal_status(disk)
    return Assessment(claims, found, mapped.notes, largest, rows, 7, status)


def _assessed(result: Result, rows: int) -> Assessment:
    """What a solution of the ends of the legs says of all rows."""
    largest = {
        name: float(np.nanmax(result.data[name].values))
        for name in ("indentation", "normal_force", "contact_radius")
        if name in result.data and np.isfinite(result.data[name].values).any()
    }
    return Assessment(
        result.claims, result.assumptions, result.notes, largest, rows, len(result.data), result.status
    )


def _extremes(path: LoadingPath) -> LoadingPath:
    pieces = [ends_only(leg) for leg in known_legs(path)]
    route = pieces[0]
    for leg in pieces[1:]:
        route = route >> leg
    return route
