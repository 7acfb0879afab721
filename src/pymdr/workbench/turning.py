"""The springs of torsion side by side with rings that stick or slip."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import PathError, ProblemError
from pymdr.independent.rings import Rings
from pymdr.independent.rings.solution import pressure_at
from pymdr.independent.torsion import TorsionRows, follow_torsion
from pymdr.interpretation.torsion import torsional_modulus
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath, Path
from pymdr.quantities import QUANTITIES
from pymdr.result import Result
from pymdr.solving.ringed import ring_solutions
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, QuantityLike
from pymdr.workbench.comparison import Comparison
from pymdr.workbench.sliding import refined_rows, thinned_rows

_PARTS = 8
"""Parts into which the rings divide a row in which the indentation changes."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True, kw_only=True, eq=False)
class TorsionVerification(Comparison):
    """The same history of load and twist by the method and by rings with friction."""

    data: xr.Dataset
    """Over ``step``: indentation in m, twist in rad, and the torque by both, as ``_mdr`` and ``_grid``."""
    tractions: xr.Dataset
    """Torsional traction of the last step over r, ``mdr`` and ``grid``, in Pa."""
    curves: xr.Dataset
    """The method on fine grids: ``twist`` and ``torque`` over ``row``, ``torsional_traction`` over ``r``."""
    rings: int

    subject: ClassVar = "a verification"
    compared: ClassVar = ("torque",)
    others: ClassVar = {"grid": "rings"}

    @property
    def largest_difference(self) -> float:
        """Largest difference of the torques over the largest of them."""
        mdr, grid = (self.data[f"torque_{method}"].values for method in ("mdr", "grid"))
        size = float(np.max(np.abs(mdr)))
        return float(np.max(np.abs(mdr - grid))) / size if size else float("nan")

    def _along(self) -> tuple[str, ...]:
        return "indentation", "twist"

    def _remarks(self) -> list[str]:
        return [
            f"boundary elements on {self.rings} rings that stick or slip; pressures by rings too",
            f"largest difference of the torque: {100 * self.largest_difference:.2g} % of its largest value",
        ]

    def _figure(self) -> mpl.figure.Figure:
        """Both torques over the twist, and both tractions of the last step."""
        return plot.compared_tractions(self.data, self.tractions, self.curves)


def verify_torsion(
    contact: Contact,
    path: LoadingPath,
    rings: int,
    steps: int,
    machine_stiffness: QuantityLike | None,
    progress: Callable[[int, int], None] | None,
) -> TorsionVerification:
    """
    Follow a history of load and twist both by the springs of torsion and by rings that stick or slip.

    Parameters
    ----------
    contact : Contact
        With ``friction=Coulomb(mu)``, mu above 0 and finite.
    steps : int
        Most rows that are followed, at least 2: turning points, and rows between them.
    """
    if isinstance(rings, bool) or not isinstance(rings, int) or not 20 <= rings <= 1000:
        raise ProblemError(f"elements = {rings!r}; a whole number of rings from 20 to 1000 is needed")
    if isinstance(steps, bool) or not isinstance(steps, int) or steps < 2:
        raise PathError(f"steps = {steps!r}; a whole number of at least 2 is needed")
    assert contact.friction is not None
    if not 0.0 < contact.friction.coefficient < float("inf"):
        raise ProblemError(
            f"mu = {contact.friction.coefficient:g}; the rings need a coefficient above 0 and finite, for example Coulomb(0.3)"
        )
    whole = solve(contact, path, machine_stiffness=machine_stiffness)
    chosen = thinned_rows([whole.data[name].values for name in ("indentation", "twist")], steps)
    depths, twists = (whole.data[name].values[chosen] for name in ("indentation", "twist"))
    mdr = solve(contact, Path(indentation=depths, twist=twists))
    top = float(np.max(mdr.data["contact_radius"].values))
    if not top > 0.0:
        raise PathError("the bodies do not touch in any row; give a path that presses them")
    edges = np.linspace(0.0, 1.02 * top, rings + 1)
    other = _followed(contact, edges, depths, twists, progress)
    curves = _curves(contact, depths, twists)
    return TorsionVerification(
        contact=contact, data=_table(mdr, other), tractions=_tractions(mdr, other), curves=curves, rings=rings
    )


def _followed(
    contact: Contact,
    edges: FloatArray,
    depths: FloatArray,
    twists: FloatArray,
    progress: Callable[[int, int], None] | None,
) -> TorsionRows:
    """The history by rings, row by row."""
    assert contact.friction is not None
    friction, n = contact.friction.coefficient, 2 * (edges.size - 1)
    places = (edges[:-1, None] + np.diff(edges)[:, None] * (_NODES + 1.0) / 2.0).ravel()
    weights = np.tile(_WEIGHTS, edges.size - 1) * places
    areas = weights.reshape(-1, _NODES.size).sum(axis=1)
    done = 0

    @lru_cache(maxsize=4)
    def limit(depth: float) -> FloatArray:
        nonlocal done
        done += 1
        if progress is not None:
            progress(min(done, _PARTS * depths.size), _PARTS * depths.size)
        if depth <= 0.0:
            return np.zeros(edges.size - 1)
        solution = ring_solutions(contact, np.array([depth]), False, Rings(n))[0]
        if solution is None:
            return np.zeros(edges.size - 1)
        means = (weights * pressure_at(solution, places)).reshape(-1, _NODES.size).sum(axis=1) / areas
        return np.asarray(friction * means)

    inner = np.minimum(edges[:-1], contact.profile.max_radius)
    entries = equivalent_profile(contact.profile).g(inner)
    shear = torsional_modulus(contact)
    return follow_torsion(edges, limit, shear, depths.tolist(), twists.tolist(), entries, _PARTS)


def _table(mdr: Result, other: TorsionRows) -> xr.Dataset:
    columns: dict[str, tuple[str, FloatArray, dict[str, str]]] = {
        name: ("step", mdr.data[name].values, {"units": QUANTITIES[name].unit})
        for name in ("indentation", "twist")
    }
    unit = {"units": QUANTITIES["torque"].unit}
    columns["torque_mdr"] = ("step", mdr.data["torque"].values, unit)
    columns["torque_grid"] = ("step", other.torque, unit)
    return xr.Dataset(columns)


def _tractions(mdr: Result, other: TorsionRows) -> xr.Dataset:
    r = (other.edges[1:] + other.edges[:-1]) / 2.0
    tau = mdr.field("torsional_traction", r=r, step=-1).values
    unit = {"units": "Pa"}
    return xr.Dataset(
        {"mdr": ("r", tau, unit), "grid": ("r", other.traction[-1], unit)},
        coords={"r": ("r", r, {"units": "m"})},
    )


def _curves(contact: Contact, depths: FloatArray, twists: FloatArray) -> xr.Dataset:
    parts = np.full(depths.size, 8)
    fine = solve(contact, Path(indentation=refined_rows(depths, parts), twist=refined_rows(twists, parts)))
    r = np.linspace(0.0, 1.05 * float(fine.data["contact_radius"].values[-1]), 400)
    return xr.Dataset(
        {
            "twist": ("row", fine.data["twist"].values, {"units": "rad"}),
            "torque": ("row", fine.data["torque"].values, {"units": "N*m"}),
            "torsional_traction": (
                "r",
                fine.field("torsional_traction", r=r, step=-1).values,
                {"units": "Pa"},
            ),
        },
        coords={"r": ("r", r, {"units": "m"})},
    )
