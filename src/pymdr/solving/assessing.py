"""The claims of a contact before its history is solved."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from operator import rshift
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pymdr.deferred import xr
from pymdr.independent.rings import Rings
from pymdr.presentation.text import bytes_text
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath
from pymdr.problem.schedule import ends_only, known_legs, total_rows
from pymdr.quantities import QUANTITIES
from pymdr.result import Status
from pymdr.solving.study import Study, dataset
from pymdr.solving.verb import check_request, solve
from pymdr.units import QuantityLike

_SHORT = 100_000
"""Largest number of rows for which the whole path is followed."""


@dataclass(frozen=True, kw_only=True)
class Assessment(Study):
    """Claims for a contact along a path, before its history is solved."""

    data: xr.Dataset
    """Largest indentation (m), normal force (N) and contact radius (m) that the path reaches, as far as they are known."""
    rows: int
    """Number of rows that :func:`solve` keeps."""
    quantities: int
    """Number of quantities over these rows."""
    status: Status
    """Status of the solution, or of the solution of the visited rows."""

    subject: ClassVar = "an assessment"
    _drawn: ClassVar = ("conditions_study", "assumptions")

    @property
    def largest(self) -> dict[str, float]:
        """The data as plain numbers in SI units."""
        return {str(name): float(value) for name, value in self.data.items()}

    @property
    def memory(self) -> int:
        """Bytes of the arrays of the result; solving a long history needs about twice as much."""
        return 8 * self.rows * self.quantities

    def groups(self) -> dict[str, dict[str, float]]:
        """The largest values along the path."""
        return {"the path reaches": self.largest}

    def _remarks(self) -> list[str]:
        return [f"the result has {self.rows} row{'s' if self.rows != 1 else ''} ({bytes_text(self.memory)})"]


def assess(
    contact: Contact,
    path: LoadingPath,
    *,
    machine_stiffness: QuantityLike | None = None,
    keep: int | ArrayLike | None = None,
    solver: Rings | None = None,
    tolerance: float | None = None,
) -> Assessment:
    """
    State the claims of a contact for the loads that a path reaches.

    The claims and refusals are those of :func:`solve` for the rows of the path. With adhesion or friction a path of more than
    100 000 rows visits the ends of its legs only.

    Parameters
    ----------
    contact : Contact
        Profile, materials and laws.
    path : LoadingPath
        Loads for which the claims are stated.
    machine_stiffness, keep, solver, tolerance : optional
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
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("210 GPa", 0.3))
    >>> mdr.assess(ball, mdr.load("50 N")).claims["pressure"].level.name
    'EXACT'
    """
    stiffness, kept = check_request(contact, path, machine_stiffness, keep)
    rows = total_rows(path) if kept is None else kept.size
    laws = contact.adhesion is not None or contact.friction is not None
    whole = solver is None and (not laws or total_rows(path) <= _SHORT)
    result = solve(
        contact,
        path if whole else reduce(rshift, map(ends_only, known_legs(path))),
        machine_stiffness=stiffness,
        keep=kept if whole else None,
        solver=solver,
        tolerance=tolerance,
    )
    largest = {
        name: ((), float(np.nanmax(result.data[name].values)), {"units": QUANTITIES[name].unit})
        for name in ("indentation", "normal_force", "contact_radius")
        if name in result.data and np.isfinite(result.data[name].values).any()
    }
    return Assessment(
        data=dataset(largest),
        claims=result.claims,
        assumptions=result.assumptions,
        notes=result.notes,
        contact=contact,
        rows=rows,
        quantities=len(result.data),
        status=result.status,
    )
