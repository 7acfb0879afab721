"""The claims of a contact before its history is solved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.interpretation.surface import Surface
from pymdr.interpretation.validity import Assumption, Claim, certify_disk, normal_claims
from pymdr.line.foundation import normal_force, states_at_depth
from pymdr.mapping.equivalent import gap_function
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath
from pymdr.problem.schedule import ends_only, known_legs, total_rows
from pymdr.solving.normal import check_normal_path, follow_normal, range_words
from pymdr.solving.reach import assumptions, map_to_line
from pymdr.solving.verb import check_problem, kept_rows, read_stiffness, solve
from pymdr.units import QuantityLike

_SHORT = 100_000
"""Rows that a friction stack follows in no time."""


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

    @property
    def memory(self) -> int:
        """Bytes that the arrays of the result take; solving a long history takes about twice as much."""
        return 8 * self.rows * self.columns

    def summary(self) -> str:
        """The claims and assumptions as a text."""
        from pymdr.presentation.text import assessment

        return assessment(self.largest, self.claims, self.assumptions, self.notes, self.rows, self.memory)

    def __str__(self) -> str:
        return self.summary()


def assess(
    contact: Contact,
    path: LoadingPath,
    *,
    machine_stiffness: QuantityLike | None = None,
    keep: int | ArrayLike | None = None,
) -> Assessment:
    """
    Map a contact and state its claims for the loads that a path reaches.

    A contact with adhesion visits the ends of the legs only, and so does one with friction whose path is long.

    Parameters
    ----------
    contact : Contact
    path : LoadingPath
    machine_stiffness, keep : optional
        As for :func:`solve`.

    Returns
    -------
    Assessment
        Claims for 40 loads up to the largest one, assumptions and notes.

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
    route = _extremes(path)
    rows = total_rows(path)
    kept = kept_rows(keep, path) if contact.friction is not None else None
    if contact.friction is not None and rows <= _SHORT:
        route = path
    if contact.adhesion is not None or contact.friction is not None:
        result = solve(contact, route, machine_stiffness=machine_stiffness)
        largest = {
            name: float(np.nanmax(result.data[name].values))
            for name in ("indentation", "normal_force", "contact_radius")
            if name in result.data
        }
        return Assessment(
            result.claims,
            result.assumptions,
            result.notes,
            largest,
            rows if kept is None else kept.size,
            len(result.data),
        )
    check_normal_path(route)
    stiffness = None if machine_stiffness is None else read_stiffness(machine_stiffness)
    history = follow_normal(contact, map_to_line(contact), route, stiffness)
    mapped, line = history.mapped, history.mapped.line
    deepest = float(np.max(history.states.indentation, initial=0.0))
    states = states_at_depth(line, deepest * np.arange(1.0, 41.0) / 40.0)
    surface = Surface(line, gap_function(contact.profile, line.equivalent), states)
    certificate = certify_disk(line, states)
    claims = normal_claims(certificate.disk, certificate.reason, range_words(line, surface, certificate.disk))
    largest = {
        "indentation": deepest,
        "normal_force": float(normal_force(line, states)[-1]),
        "contact_radius": float(np.max(states.contact_radius)),
    }
    found = assumptions(contact, mapped, states.contact_radius)
    return Assessment(claims, found, mapped.notes, largest, rows, 7)


def _extremes(path: LoadingPath) -> LoadingPath:
    pieces = [ends_only(leg) for leg in known_legs(path)]
    route = pieces[0]
    for leg in pieces[1:]:
        route = route >> leg
    return route
