"""The claims of a contact before its history is solved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce
from operator import rshift

import numpy as np
from numpy.typing import ArrayLike

from pymdr.independent.rings import Rings
from pymdr.interpretation.validity import Assumption, Claim
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath
from pymdr.problem.schedule import ends_only, known_legs, total_rows
from pymdr.result import Claims, Status
from pymdr.solving.verb import asked, solve
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
    """Largest indentation (m), normal force (N) and contact radius (m) that the path reaches, as far as they are known."""
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
    State the claims of a contact for the loads that a path reaches.

    The claims and refusals are those of :func:`solve` for the rows of the path. With adhesion or friction a path of more than
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
    stiffness, kept = asked(contact, path, machine_stiffness, keep)
    rows = total_rows(path) if kept is None else kept.size
    laws = contact.adhesion is not None or contact.friction is not None
    whole = solver is None and (not laws or total_rows(path) <= _SHORT)
    result = solve(
        contact,
        path if whole else _extremes(path),
        machine_stiffness=stiffness,
        keep=kept if whole else None,
        solver=solver,
    )
    largest = {
        name: float(np.nanmax(result.data[name].values))
        for name in ("indentation", "normal_force", "contact_radius")
        if name in result.data and np.isfinite(result.data[name].values).any()
    }
    return Assessment(
        result.claims, result.assumptions, result.notes, largest, rows, len(result.data), result.status
    )


def _extremes(path: LoadingPath) -> LoadingPath:
    return reduce(rshift, map(ends_only, known_legs(path)))
