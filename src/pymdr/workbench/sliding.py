"""The friction stack side by side with vector friction on the half-space."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from pymdr.errors import PathError, ProblemError
from pymdr.independent.sliding import HalfSpaceGrid, SlidingSolution, solve_sliding
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath, Path
from pymdr.problem.schedule import is_planar
from pymdr.quantities import QUANTITIES
from pymdr.result import Result
from pymdr.solving.drawing import infinite_in
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, QuantityLike
from pymdr.workbench.comparison import Comparison
from pymdr.workbench.subsurface import compare_subsurface, drawn_stress

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_PARTS = (8, 16)
"""Parts into which the grid divides a row with a changing depth; results are extrapolated to rows without length."""
_FINE = 24
"""Points that draw the method's curve over a row."""

COMPARED = ("normal_force", "tangential_force", "contact_radius", "stick_radius")


@dataclass(frozen=True, kw_only=True, eq=False)
class SlidingVerification(Comparison):
    """The same history by the method and by boundary elements with vector friction."""

    data: xr.Dataset
    """Over ``step``: indentation and shift in m, and every compared quantity by both, as ``_mdr`` and ``_grid``."""
    tractions: xr.Dataset
    """Shear traction of the last step over r, ``mdr`` and ``grid``, in Pa."""
    curves: xr.Dataset
    """The method on fine grids: ``shift`` and ``tangential_force`` over ``row``, ``shear_traction`` over ``r``."""
    rows: np.ndarray
    """Rows of the path that were followed, counted from 0."""
    path_rows: int
    """Rows that the path has."""
    extrapolated: float
    """
    Largest change of the grid's tangential force by its extrapolation, over the largest force.

    A cell that enters within a row is wrong by the first power of the row, so that rows are divided and extrapolated.
    """
    cells: int
    """Cells along a side of the grid."""
    slip_angle: float
    """Largest angle in degrees between traction and path in the last step, among slipping cells that carry."""

    subject: ClassVar = "a verification"
    compared: ClassVar = COMPARED
    others: ClassVar = {"grid": "elements"}

    @property
    def largest_difference(self) -> float:
        """Largest difference of the tangential forces over the largest of them."""
        mdr, grid = (self.data[f"tangential_force_{way}"].values for way in ("mdr", "grid"))
        size = float(np.max(np.abs(mdr)))
        return float(np.max(np.abs(mdr - grid))) / size if size else math.nan

    def _along(self) -> tuple[str, ...]:
        return "indentation", "shift"

    def _remarks(self) -> list[str]:
        lines = [
            f"boundary elements with vector friction on {self.cells} x {self.cells} cells",
            f"followed: {self.rows.size} rows of the path's {self.path_rows}, from row {self.rows[0] + 1} to row {self.rows[-1] + 1}"
            + ("" if self.rows[-1] == self.path_rows - 1 else "; give more steps to come to its end"),
            f"the grid was extrapolated to rows without length, by {100 * self.extrapolated:.2g} %",
            f"largest difference of the tangential force: {100 * self.largest_difference:.2g} % of its largest value",
            f"tractions deviate from the direction of the path by {self.slip_angle:.2g} degrees where they slip in the last step",
        ]
        return lines if self.subsurface is None else [*lines, *self.subsurface.remarks()]

    def _figure(self) -> Figure:
        """Both loops, both tractions of the last step, and its stress in the body."""
        from pymdr.presentation.plot import compared_tractions

        return compared_tractions(self.data, self.tractions, self.curves, drawn_stress(self.subsurface))


def verify_sliding(
    contact: Contact,
    path: LoadingPath,
    cells: int,
    steps: int,
    machine_stiffness: QuantityLike | None,
    progress: Callable[[int, int], None] | None,
) -> SlidingVerification:
    """
    Follow a history both by the friction stack and by boundary elements with vector friction.

    A history of more rows than `steps` is thinned to its turning points and rows between them, and both follow
    what is left, straight in (indentation, shift). If it has more turning points than `steps`, only the first are
    followed; `rows` tells which.

    Parameters
    ----------
    contact : Contact
        With ``friction=Coulomb(mu)``, mu above 0 and finite.
    cells : int
        Cells along a side of the grid, 8 to 80.
    steps : int
        Most rows that are followed, at least 2.
    machine_stiffness : quantity or None
        As for :func:`pymdr.solve`.
    progress : callable or None
        Called as ``progress(done, total)``.

    Raises
    ------
    ProblemError, PathError, ConvergenceError
        As :func:`pymdr.solve`.
    """
    grid = HalfSpaceGrid(cells)
    if isinstance(steps, bool) or not isinstance(steps, int) or steps < 2:
        raise PathError(f"verify: steps = {steps!r}; a whole number of at least 2 is needed")
    assert contact.friction is not None
    if is_planar(path):
        raise ProblemError(
            "verify: shifts in the plane are not compared here; pymdr.independent.sliding.solve_sliding follows them on a grid"
        )
    if contact.adhesion is not None:
        raise ProblemError(
            "verify: adhesion with friction has no independent solver here; leave one of them out"
        )
    if contact.is_viscoelastic:
        raise ProblemError(
            "verify: the grid solves friction of elastic bodies only, and a body is Viscoelastic; use Elastic with the stiffness at "
            "one time, or leave friction out (rings then solve the viscoelastic contact)"
        )
    if not 0.0 < contact.friction.coefficient < math.inf:
        raise ProblemError(
            f"verify: mu = {contact.friction.coefficient:g}; the grid solves friction with a coefficient above 0 and "
            "finite, for example Coulomb(0.3)"
        )
    whole = solve(contact, path, machine_stiffness=machine_stiffness)
    chosen = thinned_rows([whole.data[name].values for name in ("indentation", "shift")], steps)
    d, u = (whole.data[name].values[chosen] for name in ("indentation", "shift"))
    mdr = solve(contact, Path(indentation=d, shift=u))
    moves = np.diff(d, prepend=0.0) * np.diff(u, prepend=0.0) != 0.0
    parts = [np.where(moves, n, 1) for n in (_PARTS if moves.any() else (1,))]
    total = int(sum(p.sum() for p in parts))
    done = 0
    rows = []
    for each in parts:
        rows.append(
            solve_sliding(
                contact.profile,
                contact.body,
                contact.counterbody,
                contact.friction.coefficient,
                refined_rows(d, each),
                refined_rows(u, each),
                grid,
                progress=None if progress is None else partial(_report_progress, progress, done, total),
            )
        )
        done += int(each.sum())
    ends = [np.cumsum(each) - 1 for each in parts]
    forces = [other.tangential_force[at] for other, at in zip(rows, ends, strict=True)]
    change = forces[-1] - forces[0]
    size = float(np.max(np.abs(forces[-1]))) or 1.0
    return SlidingVerification(
        contact=contact,
        data=_table(mdr, rows[-1], ends[-1], forces[-1] + change),
        tractions=_tractions(mdr, rows[-1]),
        curves=_curves(contact, d, u),
        subsurface=compare_subsurface(mdr, np.arange(d.size)),
        rows=chosen,
        path_rows=whole.data.sizes["step"],
        extrapolated=float(np.max(np.abs(change))) / size,
        cells=cells,
        slip_angle=rows[-1].largest_slip_angle,
    )


def _report_progress(
    progress: Callable[[int, int], None], before: int, total: int, done: int, _: int
) -> None:
    progress(before + done, total)


def refined_rows(values: FloatArray, parts: np.ndarray) -> FloatArray:
    """Every straight step from the row before, at first from 0, in equal parts."""
    before = np.concatenate([[0.0], values[:-1]])
    return np.concatenate(
        [np.linspace(a, b, n + 1)[1:] for a, b, n in zip(before, values, parts, strict=True)]
    )


def thinned_rows(channels: Sequence[FloatArray], steps: int) -> np.ndarray:
    """Rows of a history: its turning points, and others in between while there is room."""
    n = channels[0].size
    if n <= steps:
        return np.arange(n)
    turns = np.zeros(n, dtype=bool)
    for values in channels:
        way = np.sign(np.diff(values))
        turns[1:-1] |= way[1:] != way[:-1]
    turns[[0, -1]] = True
    kept = np.flatnonzero(turns)
    if kept.size >= steps:
        return kept[:steps]
    return np.unique(np.concatenate([kept, np.linspace(0, n - 1, steps - kept.size + 1).round().astype(int)]))


def _table(mdr: Result, other: SlidingSolution, ends: np.ndarray, force: FloatArray) -> xr.Dataset:
    import xarray as xr

    columns: dict[str, tuple[str, FloatArray, dict[str, str]]] = {
        name: ("step", mdr.data[name].values, {"units": "m"}) for name in ("indentation", "shift")
    }
    for name in COMPARED:
        unit = {"units": QUANTITIES[name].unit}
        columns[f"{name}_mdr"] = ("step", mdr.data[name].values, unit)
        columns[f"{name}_grid"] = ("step", getattr(other, name)[ends], unit)
    columns["tangential_force_grid"] = ("step", force, {"units": "N"})
    return xr.Dataset(columns)


def _tractions(mdr: Result, other: SlidingSolution) -> xr.Dataset:
    import xarray as xr

    middle = other.x.size // 2
    r = np.hypot(other.x[middle:], other.x[middle])
    tau = mdr.field("shear_traction", r=r, step=-1).values
    return xr.Dataset(
        {
            "mdr": ("r", tau, {"units": "Pa"}),
            "grid": ("r", other.q_x[middle:, middle], {"units": "Pa"}),
        },
        coords={"r": ("r", r, {"units": "m"})},
        attrs={"infinite": infinite_in(mdr, mdr.data.sizes["step"] - 1)},
    )


def _curves(contact: Contact, d: FloatArray, u: FloatArray) -> xr.Dataset:
    import xarray as xr

    parts = np.full(d.size, _FINE)
    fine = solve(contact, Path(indentation=refined_rows(d, parts), shift=refined_rows(u, parts)))
    r = np.linspace(0.0, 1.05 * float(fine.data["contact_radius"].values[-1]), 400)
    return xr.Dataset(
        {
            "shift": ("row", fine.data["shift"].values, {"units": "m"}),
            "tangential_force": ("row", fine.data["tangential_force"].values, {"units": "N"}),
            "shear_traction": ("r", fine.field("shear_traction", r=r, step=-1).values, {"units": "Pa"}),
        },
        coords={"r": ("r", r, {"units": "m"})},
    )
