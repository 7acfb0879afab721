"""Comparison of the method with boundary elements, on rings or in three dimensions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, TypedDict, Unpack

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import PathError, ProblemError
from pymdr.independent.history import RingHistory
from pymdr.independent.rings import Rings
from pymdr.presentation import plot
from pymdr.problem.contact import Contact, refuse_curve
from pymdr.problem.laws import JKR
from pymdr.problem.materials import common_exponent
from pymdr.problem.options import with_options
from pymdr.problem.paths import LoadingPath, Path
from pymdr.problem.profiles import Shape
from pymdr.problem.schedule import is_torsional, planned, uses
from pymdr.quantities import QUANTITIES
from pymdr.result import FieldReader, Result
from pymdr.solving.drawing import infinite_in
from pymdr.solving.ringed import adhesive_disks
from pymdr.solving.verb import check_tolerance, solve
from pymdr.units import FloatArray, QuantityLike
from pymdr.workbench.comparison import Comparison
from pymdr.workbench.shapes import hold_shape
from pymdr.workbench.sliding import verify_sliding
from pymdr.workbench.subsurface import compare_subsurface, drawn_stress
from pymdr.workbench.turning import verify_torsion
from pymdr.workbench.worn_rings import verify_wear

COMPARED = ("indentation", "normal_force", "contact_radius", "normal_stiffness", "elastic_energy")
"""Quantities that are compared: those that the path does not prescribe and the method gives."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Verification(Comparison):
    """Both solutions of some steps of a path; with adhesion, of contacts of the same radius."""

    data: xr.Dataset
    """Over ``step``: ``indentation``, with memory ``time`` and ``row``; each quantity by the method (``_mdr``) and by rings
    (``_rings``), its relative difference (``_difference``), and the largest ``pressure_difference`` over the largest pressure.
    With memory or adhesion differences are relative to the largest value of the history."""
    pressures: xr.Dataset
    """Over ``r``, at the last step: ``mdr`` and ``rings`` in Pa."""
    rings: int
    """Number of rings."""
    history: xr.Dataset | None = None
    """With memory, over all rows of the path: ``time``, ``normal_force`` and ``indentation`` as ``_mdr`` and ``_rings``."""
    to_largest: bool = False
    """Whether differences are relative to the largest value."""

    subject: ClassVar = "a verification"
    compared: ClassVar = COMPARED
    others: ClassVar = {"rings": "rings", "difference": "difference"}

    @property
    def largest_in_history(self) -> float:
        """With memory, the largest difference of the forces in rows in contact by both, over the largest force; else NaN."""
        if self.history is None:
            return math.nan
        a, b = (self.history[f"normal_force_{method}"].values for method in ("mdr", "rings"))
        both = (a != 0.0) & (b != 0.0)
        return float(np.nanmax(np.abs(a - b), where=both, initial=0.0) / (np.nanmax(np.abs(b)) or 1.0))

    def _along(self) -> tuple[str, ...]:
        return ("indentation",) if self.history is None else ("time",)

    def _remarks(self) -> list[str]:
        p = self.data["pressure_difference"].values
        largest = f"{np.nanmax(p):.1e}" if np.isfinite(p).any() else "not known"
        lines = [
            f"boundary elements on {self.rings} rings",
            f"largest difference of pressures, 0.05 a < r < 0.9 a, over their largest value: {largest}",
        ]
        if self.to_largest:
            lines.append("differences of quantities are relative to their largest value in the history")
        if self.history is not None:
            lines.append(
                f"largest difference of forces in {self.history.sizes['row']} rows, where both are in contact: "
                f"{self.largest_in_history:.1e} of the largest force"
            )
        return lines if self.subsurface is None else [*lines, *self.subsurface.remarks()]

    def _figure(self) -> mpl.figure.Figure:
        """Both pressures over the radius, and their difference; the stress in the body; with memory also both forces over time."""
        return plot.compared_pressures(self.pressures, self.history, drawn_stress(self.subsurface))


class MethodOptions(TypedDict, total=False):
    """Options of :func:`pymdr.solve` for the solution by the method."""

    machine_stiffness: QuantityLike | None
    tolerance: float | None


@with_options(MethodOptions)
def verify(
    contact: Contact,
    path: LoadingPath,
    *,
    elements: int | None = None,
    steps: int | None = None,
    engine: str | None = None,
    wear: Mapping[str, Any] | None = None,
    progress: Callable[[int, int], None] | None = None,
    **options: Unpack[MethodOptions],
) -> Comparison:
    """
    Solve some steps of a path both by the method and by boundary elements: on rings, or, with friction or bodies not of revolution, on a grid.

    Parameters
    ----------
    contact : Contact
        Profile, materials and laws.
    path : LoadingPath
        As for :func:`pymdr.solve`.
    elements : int, optional
        Number of rings, 20 to 5000; 400 unless given. Of a body that is not of revolution: pixels along either side of the grid, 33 to 1025,
        of which the contact takes about 0.7; 129 unless given. With friction: cells along a side, 8 to 80; 32 unless given; under
        torsion and wear rings, 20 to 1000; 200 unless given, of wear 120.
    steps : int, optional
        Number of compared steps, evenly over those of the path; 5 unless given. With friction this is the number of turning
        points and rows between them; 20 unless given. Bodies with memory are followed along all rows by
        both, the rings under the same forces or indentations. With adhesion the rings have the contact radius of the method, and
        determine the indentation from the singularity at its edge; where a corner pins the edge, indentation and radius are given.
    engine : str, optional
        Package that presses a body that is not of revolution, as for :func:`pymdr.press`.
    wear : mapping, optional
        ``coefficient``, ``cycles`` and ``law`` of :func:`pymdr.wear`, whose cycle the path is: then wear is compared.
    progress : callable, optional
        Called as ``progress(done, total)``.
    machine_stiffness, tolerance : optional
        As for :func:`pymdr.solve`.

    Returns
    -------
    Verification, ShapeVerification, SlidingVerification, PlaneVerification, TorsionVerification or WearVerification
        The second of a body that is not of revolution, the third with friction, the fourth along a path in the plane, the fifth under torsion,
        the last of wear. Where the method is refused its values are NaN.
        ``subsurface`` compares the stress in an isotropic half-space, at the last compared step, with a double integral of point loads.

    Raises
    ------
    ProblemError, PathError, ConvergenceError
        As :func:`pymdr.solve`.
    MissingExtraError
        If a body is not of revolution, and the package of the engine is not installed.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("1 MPa", 0.5))
    >>> mdr.verify(ball, mdr.indent("0.1 mm"), elements=100).largest_difference < 1e-5
    True
    """
    refuse_curve(contact, "boundary elements need its shape")
    machine_stiffness, tolerance = options.get("machine_stiffness"), options.get("tolerance")
    check_tolerance(contact, tolerance)
    if wear is not None:
        number, most = 120 if elements is None else elements, 5 if steps is None else steps
        return verify_wear(contact, path, wear, number, most, progress)
    if contact.friction is not None and is_torsional(path):
        number, most = 200 if elements is None else elements, 20 if steps is None else steps
        return verify_torsion(contact, path, number, most, machine_stiffness, progress)
    if contact.friction is not None:
        number, most = 32 if elements is None else elements, 20 if steps is None else steps
        return verify_sliding(contact, path, number, most, machine_stiffness, progress)
    _refuse_without_solver(contact)
    steps = 5 if steps is None else steps
    if isinstance(steps, bool) or not isinstance(steps, int) or steps < 1:
        raise PathError(f"steps = {steps!r}; a whole number of at least 1 is needed")
    if isinstance(contact.profile, Shape):
        touched = _touched(solve(contact, path, machine_stiffness=machine_stiffness))
        pixels = 129 if elements is None else elements
        return hold_shape(contact, touched[_spread(touched.size, steps)], pixels, engine, progress)
    solver = Rings(400 if elements is None else elements)
    if isinstance(contact.adhesion, JKR) and not contact.is_viscoelastic:
        mdr = solve(contact, path, machine_stiffness=machine_stiffness)
        return _verify_adhesion(_works(contact.adhesion, mdr), mdr, solver, steps, progress)
    if contact.is_viscoelastic:
        return _verify_history(solve(contact, path, tolerance=tolerance), path, solver, steps, progress)
    depths = _touched(solve(contact, path, machine_stiffness=machine_stiffness))
    chosen = depths[_spread(depths.size, steps)]
    route = Path(indentation=chosen)
    mdr = solve(contact, route)
    ring = solve(contact, route, solver=solver, progress=progress)
    rows = np.arange(chosen.size)
    rings = _ring_state(ring)
    table = _table(mdr, rings, rows, [name for name in COMPARED if name != "indentation"])
    pressures, stress = _pressures(mdr, rings, rows), compare_subsurface(mdr, rows)
    return Verification(data=table, pressures=pressures, subsurface=stress, rings=solver.n, contact=contact)


def _refuse_without_solver(contact: Contact) -> None:
    """Refuse frictionless contacts that boundary elements do not solve."""
    if contact.plastic is not None:
        raise ProblemError(
            "a body is ElasticPlastic, but boundary elements here are elastic; its model has no independent solver here"
        )
    if not isinstance(contact.adhesion, JKR | None) and not (contact.is_viscoelastic and contact.is_cohesive):
        raise ProblemError(
            "rings solve contacts without adhesion, with JKR, or with MaugisDugdale on bodies with memory; other laws of adhesion have "
            "no independent solver here"
        )
    if (exponent := common_exponent(contact.body, contact.counterbody)) != 0.0:
        raise ProblemError(
            f"rings exist for homogeneous half-spaces and layers only; graded bodies (exponent {exponent:g}) have no independent "
            "solver here"
        )


def _works(law: JKR, mdr: Result) -> np.ndarray:
    """The work of adhesion in J/m^2 of every row; NaN where the edge rests between two works."""
    works = np.full(mdr.data.sizes["step"], law.work)
    if law.has_hysteresis:
        released = mdr.data["energy_release_rate"].values
        works[:] = math.nan
        for work in law.works:
            works[np.abs(released - work) <= 1e-9 * work] = work
    return works


def _verify_adhesion(
    works: np.ndarray, mdr: Result, solver: Rings, steps: int, progress: Callable[[int, int], None] | None
) -> Verification:
    """Contacts of the same radii."""
    a = mdr.data["contact_radius"].values
    in_contact = np.flatnonzero(a > 0.0)
    if in_contact.size == 0:
        raise PathError("the path makes no contact at any step; give a path that presses the bodies together")
    rows = in_contact[_spread(in_contact.size, steps)]
    solutions: list[Any] = [None] * a.size
    disks = adhesive_disks(mdr.contact, a[rows], mdr.data["indentation"].values[rows], works[rows], solver)
    for done, (row, one) in enumerate(zip(rows, disks, strict=True)):
        solutions[row] = one
        if progress is not None:
            progress(done + 1, rows.size)
    columns = {name: np.full(a.size, math.nan) for name in ("indentation", "normal_force", "elastic_energy")}
    for row in rows:
        one = solutions[row]
        for name, value in zip(columns, (one.indentation, one.force, one.energy), strict=True):
            columns[name][row] = value
    ring = _RingState(columns, RingHistory(mdr.contact.profile, tuple(solutions), columns["indentation"]))
    table = _table(mdr, ring, rows, list(columns), to_largest=True)
    pressures = _pressures(mdr, ring, rows)
    return Verification(
        data=table,
        pressures=pressures,
        subsurface=compare_subsurface(mdr, rows),
        rings=solver.n,
        to_largest=True,
        contact=mdr.contact,
    )


def _verify_history(
    mdr: Result,
    path: LoadingPath,
    solver: Rings,
    steps: int,
    progress: Callable[[int, int], None] | None,
) -> Verification:
    """Compare both histories in all rows, and all quantities in some of the rows in contact."""
    ring = solve(mdr.contact, path, solver=solver, progress=progress)
    touching = np.flatnonzero(ring.data["contact_radius"].values > 0.0)
    if touching.size == 0:
        raise PathError("the path makes no contact at any step; give a path that presses the bodies together")
    rows = touching[_spread(touching.size, steps)]
    loaded = uses(path, "normal_force")
    moved = any(leg.controls.normal == "indentation" for leg in planned(path))
    skipped = {name for name, free in (("indentation", loaded), ("normal_force", moved)) if not free}
    names = [name for name in COMPARED if name in mdr.claims and name not in skipped]
    rings = _ring_state(ring)
    table = _table(mdr, rings, rows, names, to_largest=True)
    return Verification(
        data=table,
        pressures=_pressures(mdr, rings, rows),
        subsurface=compare_subsurface(mdr, rows),
        rings=solver.n,
        history=_history(mdr, ring),
        to_largest=True,
        contact=mdr.contact,
    )


class _RingState(NamedTuple):
    """The solution by rings, over the steps of the path."""

    columns: Mapping[str, FloatArray]
    surface: FieldReader


def _ring_state(ring: Result) -> _RingState:
    return _RingState({str(name): array.values for name, array in ring.data.variables.items()}, ring.surface)


def _spread(size: int, steps: int) -> np.ndarray:
    """A given number of some places, including the first and the last."""
    at = np.linspace(0, size - 1, min(steps, size)) if steps > 1 else np.array([size - 1])
    return np.unique(at.round().astype(int))


def _touched(result: Result) -> FloatArray:
    """Indentations of the steps in contact, rising, at least one."""
    if "indentation" not in result.data:
        raise PathError("the method gives no indentation for this load; prescribe indentations instead")
    d = result.data["indentation"].values
    touched = np.unique(d[np.isfinite(d) & (result.data["force_lower_bound"].values > 0.0)])
    if touched.size == 0:
        raise PathError("the path makes no contact at any step; give a path that presses the bodies together")
    return touched


def _table(
    mdr: Result, ring: _RingState, rows: np.ndarray, names: list[str], to_largest: bool = False
) -> xr.Dataset:
    memory = "time" in ring.columns
    labels = ("time", "indentation") if memory else ("indentation",)
    columns: dict[str, tuple[str, Any, dict[str, str]]] = {
        name: ("step", ring.columns[name][rows], {"units": QUANTITIES[name].unit}) for name in labels
    }
    if memory:
        columns["row"] = ("step", rows, {"units": ""})
    for name in names:
        unit = {"units": QUANTITIES[name].unit}
        a, b = _column(mdr, name)[rows], ring.columns[name][rows]
        size = np.max(np.abs(ring.columns[name][rows if not memory else slice(None)])) if to_largest else b
        columns[f"{name}_mdr"] = ("step", a, unit)
        columns[f"{name}_rings"] = ("step", b, unit)
        columns[f"{name}_difference"] = ("step", (a - b) / size, {"units": ""})
    differences = np.array([_pressure_difference(mdr, ring, int(i)) for i in rows])
    columns["pressure_difference"] = ("step", differences, {"units": ""})
    return xr.Dataset(columns)


def _column(result: Result, name: str) -> FloatArray:
    """A quantity of a result, NaN if the result does not have it."""
    none = np.full(result.data.sizes["step"], math.nan)
    return result.data[name].values if name in result.data else none


def _history(mdr: Result, ring: Result) -> xr.Dataset:
    columns = {"time": ("row", ring.data["time"].values, {"units": "s"})}
    for name in ("indentation", "normal_force"):
        for method, result in (("mdr", mdr), ("rings", ring)):
            columns[f"{name}_{method}"] = ("row", _column(result, name), {"units": QUANTITIES[name].unit})
    return xr.Dataset(columns)


def _pressure_difference(mdr: Result, ring: _RingState, step: int) -> float:
    a = float(_column(mdr, "contact_radius")[step])
    if not mdr.claims["pressure"].where[step] or not a > 0.0:
        return math.nan
    r = np.linspace(0.05, 0.9, 60) * a
    by_mdr, by_rings = (one.field("pressure", r, step) for one in (mdr.surface, ring.surface))
    return float(np.max(np.abs(by_mdr - by_rings)) / np.max(np.abs(by_rings)))


def _pressures(mdr: Result, ring: _RingState, rows: np.ndarray) -> xr.Dataset:
    """Pressures at the last of some rows in which the method gives one."""
    valid = rows[mdr.claims["pressure"].where[rows]]
    step = int(valid[-1] if valid.size else rows[-1])
    r = ring.surface.default_radii(step)
    by_rings = ring.surface.field("pressure", r, step)
    by_mdr = mdr.field("pressure", r=r, step=step).values if valid.size else np.full(r.shape, math.nan)
    bounded = ~np.isinf(by_mdr) & ~np.isinf(by_rings)
    return xr.Dataset(
        {"mdr": ("r", by_mdr[bounded], {"units": "Pa"}), "rings": ("r", by_rings[bounded], {"units": "Pa"})},
        coords={"r": ("r", r[bounded], {"units": "m"})},
        attrs={
            "indentation": float(ring.columns["indentation"][step]),
            "infinite": infinite_in(mdr, step) if valid.size else (),
        },
    )
