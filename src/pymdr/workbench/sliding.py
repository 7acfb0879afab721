"""The friction stack side by side with vector friction on the half-space."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import PathError, ProblemError
from pymdr.independent.sliding import HalfSpaceGrid, SlidingSolution, solve_sliding
from pymdr.presentation import plot
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

_PARTS = (8, 16)
"""Parts into which the grid divides a row with a changing depth; results are extrapolated to rows without length."""
_PLANE_PARTS = (3, 6)
"""The same of a row of a path in the plane that shifts the body."""
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

    A cell that enters or turns within a row is wrong by the first power of the row, so that rows are divided and extrapolated.
    """
    cells: int
    """Cells along a side of the grid."""
    slip_angle: float
    """Largest angle in degrees between traction and path in the last step, among slipping cells that carry."""

    subject: ClassVar = "a verification"
    compared: ClassVar[tuple[str, ...]] = COMPARED
    others: ClassVar = {"grid": "elements"}

    @property
    def largest_difference(self) -> float:
        """Largest difference of the tangential forces over the largest of them."""
        mdr, grid = (self.data[f"tangential_force_{direction}"].values for direction in ("mdr", "grid"))
        size = float(np.max(np.abs(mdr)))
        return float(np.max(np.abs(mdr - grid))) / size if size else math.nan

    def _along(self) -> tuple[str, ...]:
        return "indentation", "shift"

    def _remarks(self) -> list[str]:
        lines = [
            f"boundary elements with vector friction on {self.cells} x {self.cells} cells",
            f"solved: {self.rows.size} of {self.path_rows} rows of the path, from row {self.rows[0] + 1} to row {self.rows[-1] + 1}"
            + ("" if self.rows[-1] == self.path_rows - 1 else "; use more steps to reach its end"),
            f"extrapolation to rows of zero length changes the results by {100 * self.extrapolated:.2g} %",
            f"largest difference of the tangential force: {100 * self.largest_difference:.2g} % of its largest value",
            f"tractions deviate from the direction of the path by {self.slip_angle:.2g} degrees where they slip in the last step",
        ]
        return lines if self.subsurface is None else [*lines, *self.subsurface.remarks()]

    def _figure(self) -> mpl.figure.Figure:
        """Both loops, both tractions of the last step, and its stress in the body."""
        return plot.compared_tractions(self.data, self.tractions, self.curves, drawn_stress(self.subsurface))


@dataclass(frozen=True, kw_only=True, eq=False)
class PlaneVerification(SlidingVerification):
    """
    The same path in the plane by springs with vectors and by boundary elements with vector friction.

    In ``data`` shift and tangential force have components, ``shift_x`` and ``tangential_force_y_grid``. ``tractions`` has both components of
    the last step over r, near the x axis: ``mdr_x``, ``grid_x``, ``mdr_y`` and ``grid_y``. The angle of slip is not given.
    """

    compared: ClassVar = (
        "normal_force",
        "tangential_force_x",
        "tangential_force_y",
        "contact_radius",
        "stick_radius",
    )

    @property
    def largest_difference(self) -> float:
        """Length of the largest difference of the tangential forces over the largest of them."""
        mdr, grid = (
            np.stack([self.data[f"tangential_force_{axis}_{end}"].values for axis in "xy"])
            for end in ("mdr", "grid")
        )
        size = float(np.max(np.hypot(*mdr)))
        return float(np.max(np.hypot(*(mdr - grid)))) / size if size else math.nan

    def _along(self) -> tuple[str, ...]:
        return "indentation", "shift_x", "shift_y"

    def _remarks(self) -> list[str]:
        lines = [line for line in super()._remarks() if not line.startswith("tractions deviate")]
        return [
            *lines,
            "springs whose forces are vectors are approximate along curved paths: the claim states an error of 20 % of mu F_N",
        ]

    def _figure(self) -> mpl.figure.Figure:
        """Both forces in the plane, and both components of the traction of the last step."""
        return plot.compared_plane(self.data, self.tractions, self.curves)


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
    """
    grid = HalfSpaceGrid(cells)
    if isinstance(steps, bool) or not isinstance(steps, int) or steps < 2:
        raise PathError(f"steps = {steps!r}; a whole number of at least 2 is needed")
    assert contact.friction is not None
    if contact.adhesion is not None:
        raise ProblemError("adhesion with friction has no independent solver here; leave one of them out")
    if contact.is_viscoelastic:
        raise ProblemError(
            "the grid solves friction of elastic bodies only, and a body is viscoelastic; use Elastic with the stiffness at "
            "one time, or leave friction out (rings then solve the viscoelastic contact)"
        )
    if not 0.0 < contact.friction.coefficient < math.inf:
        raise ProblemError(
            f"mu = {contact.friction.coefficient:g}; the grid solves friction with a coefficient above 0 and "
            "finite, for example Coulomb(0.3)"
        )
    whole = solve(contact, path, machine_stiffness=machine_stiffness)
    planar = is_planar(path)
    measured = {name: whole.data[name].values for name in ("indentation", "shift")}
    chosen = thinned_rows([measured["indentation"], *np.atleast_2d(measured["shift"].T)], steps)
    d, u = (values[chosen] for values in measured.values())
    if not np.isfinite(u).all():
        raise PathError(
            "a tangential force of the path reaches mu F_N, at which the whole contact slides; prescribe the shift"
        )
    mdr = solve(contact, Path(indentation=d, shift=u))
    rows, force, extrapolated = _by_grid(contact, d, u, grid, progress)
    common: dict[str, Any] = {
        "contact": contact,
        "rows": chosen,
        "path_rows": whole.data.sizes["step"],
        "extrapolated": extrapolated,
        "cells": cells,
        "curves": _curves(contact, d, u),
    }
    last, ends = rows
    if planar:
        table = _plane_table(mdr, last, ends, force)
        return PlaneVerification(
            data=table, tractions=_plane_tractions(mdr, last), slip_angle=math.nan, **common
        )
    return SlidingVerification(
        data=_table(mdr, last, ends, force[:, 0]),
        tractions=_tractions(mdr, last),
        subsurface=compare_subsurface(mdr, np.arange(d.size)),
        slip_angle=last.largest_slip_angle,
        **common,
    )


def _by_grid(
    contact: Contact,
    d: FloatArray,
    u: FloatArray,
    grid: HalfSpaceGrid,
    progress: Callable[[int, int], None] | None,
) -> tuple[tuple[SlidingSolution, np.ndarray], FloatArray, float]:
    """The finest solution with its rows at the ends of those given, the extrapolated forces (n, 2), and their largest change."""
    assert contact.friction is not None
    both = np.atleast_2d(u.T)
    moves = (np.diff(d, prepend=0.0) * np.diff(both, axis=1, prepend=0.0) != 0.0).any(axis=0)
    counts = _PARTS
    if u.ndim == 2:  # where the direction of slip turns
        moves, counts = (np.diff(both, axis=1, prepend=0.0) != 0.0).any(axis=0), _PLANE_PARTS
    parts = [np.where(moves, n, 1) for n in (counts if moves.any() else (1,))]
    total, done = int(sum(p.sum() for p in parts)), 0
    solutions, forces = [], []
    for each in parts:
        shift = np.stack([refined_rows(component, each) for component in both], axis=1)
        one = solve_sliding(
            contact.profile,
            contact.body,
            contact.counterbody,
            contact.friction.coefficient,
            refined_rows(d, each),
            shift if u.ndim == 2 else shift[:, 0],
            grid,
            progress=None if progress is None else partial(_report_progress, progress, done, total),
        )
        done += int(each.sum())
        ends = np.cumsum(each) - 1
        solutions.append((one, ends))
        forces.append(np.stack([one.tangential_force, one.transverse_force], axis=1)[ends])
    change = forces[-1] - forces[0]
    size = float(np.max(np.hypot(*forces[-1].T))) or 1.0
    return solutions[-1], forces[-1] + change, float(np.max(np.hypot(*change.T))) / size


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
        direction = np.sign(np.diff(values))
        turns[1:-1] |= direction[1:] != direction[:-1]
    turns[[0, -1]] = True
    kept = np.flatnonzero(turns)
    if kept.size >= steps:
        return kept[:steps]
    return np.unique(np.concatenate([kept, np.linspace(0, n - 1, steps - kept.size + 1).round().astype(int)]))


def _table(mdr: Result, other: SlidingSolution, ends: np.ndarray, force: FloatArray) -> xr.Dataset:
    columns: dict[str, tuple[str, FloatArray, dict[str, str]]] = {
        name: ("step", mdr.data[name].values, {"units": "m"}) for name in ("indentation", "shift")
    }
    for name in COMPARED:
        unit = {"units": QUANTITIES[name].unit}
        columns[f"{name}_mdr"] = ("step", mdr.data[name].values, unit)
        columns[f"{name}_grid"] = ("step", getattr(other, name)[ends], unit)
    columns["tangential_force_grid"] = ("step", force, {"units": "N"})
    return xr.Dataset(columns)


def _plane_table(mdr: Result, other: SlidingSolution, ends: np.ndarray, force: FloatArray) -> xr.Dataset:
    """As `_table`, with components of shift and force."""
    columns: dict[str, tuple[str, FloatArray, dict[str, str]]] = {
        "indentation": ("step", mdr.data["indentation"].values, {"units": "m"})
    }
    for i, axis in enumerate("xy"):
        columns[f"shift_{axis}"] = ("step", mdr.data["shift"].values[:, i], {"units": "m"})
        name = f"tangential_force_{axis}"
        columns[f"{name}_mdr"] = ("step", mdr.data["tangential_force"].values[:, i], {"units": "N"})
        columns[f"{name}_grid"] = ("step", force[:, i], {"units": "N"})
    for name in ("normal_force", "contact_radius", "stick_radius"):
        unit = {"units": QUANTITIES[name].unit}
        columns[f"{name}_mdr"] = ("step", mdr.data[name].values, unit)
        columns[f"{name}_grid"] = ("step", getattr(other, name)[ends], unit)
    return xr.Dataset(columns)


def _plane_tractions(mdr: Result, other: SlidingSolution) -> xr.Dataset:
    middle = other.x.size // 2
    r = np.hypot(other.x[middle:], other.x[middle])
    tau = mdr.field("shear_traction", r=r, step=-1).values
    unit = {"units": "Pa"}
    columns = {}
    for i, (axis, grid) in enumerate((("x", other.q_x), ("y", other.q_y))):
        columns[f"mdr_{axis}"] = ("r", tau[i], unit)
        columns[f"grid_{axis}"] = ("r", grid[middle:, middle], unit)
    return xr.Dataset(columns, coords={"r": ("r", r, {"units": "m"})})


def _tractions(mdr: Result, other: SlidingSolution) -> xr.Dataset:
    middle = other.x.size // 2
    r = np.hypot(other.x[middle:], other.x[middle])
    tau = mdr.field("shear_traction", r=r, step=-1).values
    return xr.Dataset(
        {"mdr": ("r", tau, {"units": "Pa"}), "grid": ("r", other.q_x[middle:, middle], {"units": "Pa"})},
        coords={"r": ("r", r, {"units": "m"})},
        attrs={"infinite": infinite_in(mdr, mdr.data.sizes["step"] - 1)},
    )


def _curves(contact: Contact, d: FloatArray, u: FloatArray) -> xr.Dataset:
    parts = np.full(d.size, _FINE)
    both = np.stack([refined_rows(component, parts) for component in np.atleast_2d(u.T)], axis=1)
    fine = solve(contact, Path(indentation=refined_rows(d, parts), shift=both if u.ndim == 2 else both[:, 0]))
    r = np.linspace(0.0, 1.05 * float(fine.data["contact_radius"].values[-1]), 400)
    tau = np.atleast_2d(fine.field("shear_traction", r=r, step=-1).values)
    columns: dict[str, tuple[str, FloatArray, dict[str, str]]] = {}
    for i, end in enumerate(("_x", "_y") if u.ndim == 2 else ("",)):
        for name in ("shift", "tangential_force"):
            values = fine.data[name].values.reshape(d.size * _FINE, -1)[:, i]
            columns[f"{name}{end}"] = ("row", values, {"units": QUANTITIES[name].unit})
        columns[f"shear_traction{end}"] = ("r", tau[i], {"units": "Pa"})
    return xr.Dataset(columns, coords={"r": ("r", r, {"units": "m"})})
