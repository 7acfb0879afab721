"""Fretting wear of a contact over cycles of shift at constant load or indentation."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError
from pymdr.interpretation.certificate import certify_history
from pymdr.interpretation.wear import small_amplitude, wear_claims
from pymdr.line.curves import ElasticLine
from pymdr.line.foundation import rises_to
from pymdr.line.wear import History
from pymdr.machine import one_thread
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.moduli import effective_moduli
from pymdr.presentation import plot
from pymdr.problem.contact import Contact, require_contact
from pymdr.problem.paths import LoadingPath
from pymdr.problem.profiles import ForceCurve, Profile, Worn
from pymdr.result.rows import row_index
from pymdr.solving.frictional import frictional_assumptions, pressed_joint
from pymdr.solving.study import Column, Study
from pymdr.solving.wearing import (
    UNITS,
    Coarser,
    WearCase,
    coarser,
    columns_of,
    followed,
    limit_of,
    line_of_wear,
    loads_of_wear,
    one_cycle,
    refuse_unknown_wear,
    surface_of_wear,
)
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, shown, to_si, to_si_array

_ROWS, _DECADES = 31, 5.0
_FOOT = 0.01
"""Fraction of the largest depth below which the edge of a worn ring is extrapolated from deeper points."""
_FALLS = 1e-4
"""Decrease of an equivalent profile, over the indentation, with which no contact is a disk."""
_INNER = 200
"""Springs of an earlier wear within the first stick radius."""
_COUNTED = 100.0
"""Cycles above which the rows are at whole numbers of them."""
LAWS = ("archard", "energy")
"""Laws of wear: proportional to pressure or to shear traction times slip."""


@dataclass(frozen=True, kw_only=True)
class Wear(Study):
    """Fretting wear over cycles, by :func:`wear`."""

    data: xr.Dataset
    """
    Over ``cycles``: worn_volume (m^3), worn_depth (m), the largest, worn_radius (m), contact_radius, stick_radius and indentation
    (m), normal_force (N), normal_stiffness (N/m), force_amplitude (N) of the tangential force, dissipated_per_cycle (J), mean_pressure
    and central_pressure (Pa).
    """
    surface: xr.Dataset
    """
    Over ``cycles`` and ``node``, with the radii ``r`` (m): profile (m), f(r) of the worn gap from the original apex, worn_depth (m), pressure (Pa) and slip (m)
    between a turning point and the middle of the motion, and limiting_profile (m) at constant indentation. Late in
    wear the pressure at the stick radius c is infinite, inside it like 1/sqrt(c - r).
    """
    springs: xr.Dataset
    """Over ``cycles`` and ``spring``: equivalent_profile (m) of the worn gap at ``x`` (m), from the first stick radius to the contact radius."""
    original: Profile
    """The profile before wear."""

    subject: ClassVar = "wear"
    columns: ClassVar = {
        "cycles": Column("cycles", ""),
        "worn_volume": Column("volume", "m^3"),
        "worn_depth": Column("depth", "m"),
        "contact_radius": Column("contact", "m"),
        "stick_radius": Column("stick", "m"),
        "indentation": Column("indentation", "m"),
        "normal_force": Column("force", "N"),
        "normal_stiffness": Column("stiffness", "N/m"),
        "dissipated_per_cycle": Column("dissipated", "J"),
        "mean_pressure": Column("mean p", "Pa"),
        "central_pressure": Column("central p", "Pa"),
    }
    summary_claims: ClassVar = ("worn_volume", "contact_radius")

    def worn(self, row: int = -1) -> Worn:
        """
        The worn profile of a row, for :func:`pymdr.solve`, files and figures.

        Parameters
        ----------
        row : int
            Row of the data; the last by default.

        Returns
        -------
        Worn

        Raises
        ------
        QuantityError
            If there is no such row.
        ProblemError
            If nothing has worn in that row.
        """
        row = row_index(row, self.data.sizes["cycles"], "row", "")
        r, depth = self.surface["r"].values[row], self.surface["worn_depth"].values[row]
        if not depth.max() > 0.0:
            raise ProblemError(f"row {row} has no wear; use the original profile")
        first, last = np.flatnonzero(depth > 0.0)[[0, -1]] + [-1, 1]
        ring = slice(max(int(first), 0), int(last) + 1)
        r, depth = r[ring], depth[ring]
        known = np.append(True, np.diff(r) > 0.0)
        r, depth = r[known], depth[known]
        # at its edge the ring has a foot of a cell or two, which the mesh does not resolve
        kept = depth > _FOOT * depth.max()
        kept[[0, -1]] = True
        r, depth = r[kept], depth[kept]
        if isinstance(self.original, Worn):
            before = self.original
            radii = np.union1d(r, before.radius)
            inside = np.interp(radii, r, depth, right=0.0)
            total = np.maximum(before.depth_at(radii) + inside, 0.0)
            total[-1] = 0.0
            return self._solvable(Worn(before.original, radii, total), row)
        return self._solvable(Worn(self.original, r, depth), row)

    def _solvable(self, profile: Worn, row: int) -> Worn:
        """The profile, with its springs where errors of the mesh would decide that its contact is no disk."""
        x, g = (self.springs[name].values[row] for name in ("x", "equivalent_profile"))
        if x[0] == 0.0:  # a middle that has worn and slips is a second spring there
            first = int(np.flatnonzero(x == 0.0)[-1])
            x, g = x[first:], g[first:] - g[first]
        image = equivalent_profile(profile)
        level = image.g(x[x > profile.radius[0]])
        falls = np.any(np.maximum.accumulate(level) - level > _FALLS * g[-1])
        if not falls and certify_history(ElasticLine(image, 1.0), float(g[-1])).disk.all():
            return profile
        if profile.original is not self.original and x[0] > 0.0:  # worn before
            inner = np.linspace(min(profile.radius[0], x[0]), x[0], _INNER, endpoint=False)
            x, g = np.append(inner, x), np.append(equivalent_profile(self.original).g(inner), g)
        return replace(profile, spring_radius=x, spring_depth=np.maximum.accumulate(g))

    def force_curve(self, row: int = -1) -> ForceCurve:
        """
        The force curve F(d) of the worn contact of a row, for :func:`pymdr.solve` with friction, machines and memory.

        The springs of the worn contact give it, F = 2 E* int (d - g) dx, up to the indentation of the row. It is known to the end of
        wear, where the surfaces touch without pressure and the worn profile is not a disk to the error of its mesh.

        Parameters
        ----------
        row : int
            Row of the data; the last by default.

        Returns
        -------
        ForceCurve
            With the indentation in m from the first touch of the worn bodies.

        Raises
        ------
        QuantityError
            If there is no such row.

        Examples
        --------
        >>> import pymdr as mdr
        >>> steel = mdr.Elastic("210 GPa", 0.0)
        >>> ball = mdr.Contact(mdr.Paraboloid("10 mm"), steel, friction=mdr.Coulomb(0.5))
        >>> one = mdr.indent("1 um") >> mdr.cycle(shift="0.2 um")
        >>> worn = mdr.wear(ball, one, coefficient="1e-5 mm^3/(N m)", cycles=1e8)
        >>> again = mdr.solve(mdr.Contact(worn.force_curve(), steel, friction=mdr.Coulomb(0.5)), one)
        >>> bool(abs(again["tangential_force"].max() / worn["force_amplitude"][-1] - 1.0) < 1e-9)
        True
        """
        assert self.contact is not None
        row = row_index(row, self.data.sizes["cycles"], "row", "")
        modulus = effective_moduli(self.contact.body, self.contact.counterbody).normal
        x, g = (self.springs[name].values[row] for name in ("x", "equivalent_profile"))
        depth, half_load = loads_of_wear(equivalent_profile(self.original), x, g)
        error = 0.0
        for name in ("normal_force", "indentation"):
            own = self.claims[name].error
            error += 0.0 if own is None else float(own[row])
        return ForceCurve(depth - depth[0], 2.0 * modulus * half_load, modulus=modulus, error=error)

    def _figure(self) -> mpl.figure.Figure:
        """The worn profile, the pressure, the worn volume and the radii over cycles."""
        return plot.wear_study(self.data, self.surface)

    def groups(self) -> dict[str, dict[str, float]]:
        """The end of wear at constant indentation."""
        names = {"limit_volume": "worn_volume", "limit_radius": "worn_radius", "limit_force": "normal_force"}
        known = {
            short: float(self.data.attrs[name]) for name, short in names.items() if name in self.data.attrs
        }
        return {"at the end of wear": known} if known else {}

    def _stored(self) -> xr.Dataset:
        fields = self.surface.rename({name: f"surface_{name}" for name in self.surface.data_vars})
        springs = self.springs.rename({name: f"springs_{name}" for name in self.springs.data_vars})
        whole = super()._stored()
        return whole.merge(fields, combine_attrs="override").merge(springs, combine_attrs="override")


def wear(
    contact: Contact,
    path: LoadingPath,
    *,
    coefficient: QuantityLike,
    cycles: ArrayQuantityLike,
    law: str = "archard",
    progress: Callable[[int, int], None] | None = None,
) -> Wear:
    """
    Fretting wear of a contact over many cycles of equal amplitude, at constant indentation or load.

    In every cycle the gap grows by k p(r) s(r) (Archard) or k tau(r) s(r) (energy), with the pressure p, the shear traction tau = mu p
    and the slip path s = 4 |U0 - u_x| of the cycle. Blocks of cycles are implicit, and the springs, their slip and
    the stick radius belong to the worn profile.

    Parameters
    ----------
    contact : Contact
        With ``friction=Coulomb(mu)`` and homogeneous elastic bodies, without adhesion. Wear of both bodies adds up.
    path : LoadingPath
        One cycle: ``indent(...)`` or ``load(...)``, which is kept, and then a shift to and fro, such as ``cycle(shift="1 um")``.
    coefficient : quantity
        Wear coefficient k in m^2/N (volume per load and path, such as "1e-6 mm^3/(N m)"), or in m^3/J for the energy law; above 0.
    cycles : array_like
        Number of cycles, or the rising numbers at which rows are wanted.
    law : {"archard", "energy"}
        Whose coefficient it is, by default Archard's: both have the same unit, which cannot tell them apart.
    progress : callable, optional
        Called with the number of finished rows and of all rows.

    Returns
    -------
    Wear
        Over ``cycles``: volume (m^3), depth, radii and indentation (m), force (N), stiffness (N/m) and dissipation (J).

    Raises
    ------
    ProblemError
        If a value is not above 0, the path is no such cycle, the amplitude of gross slip is above a tenth of the contact radius,
        or the contact has adhesion, memory, grading, layers, a force curve or a sharp edge.
    ConvergenceError
        If a block of cycles has no solution.

    See Also
    --------
    friction_loop : the loop of one cycle.
    Worn : a worn profile.

    Notes
    -----
    Archard (1953); Fouvry, Kapsa and Vincent (1996). At constant indentation wear ends at the shape of Popov (2014), which the
    summary shows; at constant load the stick radius grows, and the end has no closed form. The model has no wear particles.

    References
    ----------
    - Archard (1953), J. Appl. Phys. 24, 981-988, doi:10.1063/1.1721448.
    - Fouvry, Kapsa and Vincent (1996), Wear 200, 186-205, doi:10.1016/S0043-1648(96)07306-1.
    - Popov (2014), Phys. Mesomech. 17, 163-172.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("210 GPa", 0.0), friction=mdr.Coulomb(0.5))
    >>> one = mdr.indent("1 um") >> mdr.cycle(shift="0.1 um")
    >>> worn = mdr.wear(ball, one, coefficient="1e-5 mm^3/(N m)", cycles=1e6)
    >>> bool(0.99 < worn["worn_volume"][-1] / worn.data.attrs["limit_volume"] < 1.0)
    True
    """
    require_contact(contact)
    refuse_unknown_wear(contact)
    k = _coefficient(coefficient, law)
    rows = _counted(cycles)
    request = one_cycle(path)
    mapped, d, mu, _ = pressed_joint("wear", contact, request.normal_force, request.indentation)
    if not rises_to(mapped.line, d):
        raise ProblemError("the equivalent profile decreases within the contact; use an increasing one")
    rate = k * (mu if law == "energy" else 1.0)
    case = WearCase(contact, mapped.line.equivalent, mapped.moduli, d, mu, request, rate)
    with one_thread():  # systems of a few hundred unknowns are slower in several threads
        solved = followed(case, rows, progress)
        coarse = coarser(case, solved, rows)
    history = solved.history
    columns = columns_of(case, solved.wearing, history)
    errors = _errors(columns, coarse, solved.half.missed)
    constants = {"amplitude": request.amplitude, "friction_coefficient": mu, "coefficient": k, "law": law}
    return Wear(
        data=_labelled(rows, columns, constants | limit_of(case)),
        surface=_surface(case, history, rows),
        springs=_springs(case, history, rows),
        original=contact.profile,
        claims=wear_claims(contact, mapped.moduli, law, errors),
        assumptions=(
            *frictional_assumptions(contact, mapped, np.append(case.radius, columns["contact_radius"].max())),
            small_amplitude(request.amplitude, case.radius),
        ),
        notes=(*mapped.notes, *_notes(case, history, len(solved.half.blocks))),
        contact=contact,
        references=("archard", "fouvry", "popov-wear", "cattaneo-mindlin"),
    )


def _coefficient(given: QuantityLike, law: str) -> float:
    """The wear coefficient in m^2/N, or m^3/J."""
    if law not in LAWS:
        raise ProblemError(f"law = {shown(law)}; it must be 'archard' or 'energy'")
    k = to_si(given, "m^2/N", name="coefficient")
    if not 0.0 < k < math.inf:
        raise ProblemError(f"coefficient = {shown(given)}; it must be above 0 m^2/N and finite")
    return k


def _labelled(rows: FloatArray, columns: Mapping[str, FloatArray], attrs: Mapping[str, Any]) -> xr.Dataset:
    return xr.Dataset(
        {name: ("cycles", values, {"units": UNITS[name]}) for name, values in columns.items()},
        coords={"cycles": ("cycles", rows, {"long_name": "number of cycles", "units": ""})},
        attrs=attrs,
    )


def _surface(case: WearCase, history: History, rows: FloatArray) -> xr.Dataset:
    """Profiles and fields over the nodes of every row."""
    fields = {
        name: (("cycles", "node"), values, {"units": "Pa" if name == "pressure" else "m"})
        for name, values in surface_of_wear(case, history).items()
    }
    return xr.Dataset(fields, coords={"cycles": rows}).set_coords("r")


def _springs(case: WearCase, history: History, rows: FloatArray) -> xr.Dataset:
    """The line of every row beyond the first stick radius."""
    columns = {
        name: (("cycles", "spring"), values, {"units": "m"})
        for name, values in line_of_wear(case, history).items()
    }
    return xr.Dataset(columns, coords={"cycles": rows}).set_coords("x")


def _counted(cycles: ArrayQuantityLike) -> FloatArray:
    """Numbers of cycles of the rows, from 0."""
    given = np.atleast_1d(to_si_array(cycles, "", name="cycles"))
    if given.ndim != 1 or given.size == 0 or not np.all(given >= 0.0) or not np.all(np.diff(given) > 0.0):
        raise ProblemError(
            f"cycles = {shown(cycles)}; a number above 0, or rising numbers of at least 0, are needed"
        )
    last = float(given[-1])
    if not last > 0.0:
        raise ProblemError(f"cycles = {shown(cycles)}; the last number must be above 0")
    if given.size > 1:
        return given
    spaced = np.geomspace(last * 10.0**-_DECADES, last, _ROWS)
    return np.unique(np.append(0.0, np.where(spaced > _COUNTED, np.round(spaced), spaced)))


def _errors(fine: Mapping[str, FloatArray], coarse: Coarser, missed: list[float]) -> dict[str, FloatArray]:
    """
    Relative errors by a half and a quarter of the cells and half the blocks.

    The edge of contact falls unevenly between the nodes, so that the differences change sign: the largest up to a row counts.
    """
    errors = {}
    for name, values in fine.items():
        # the pressure at the tip of a cone is infinite
        known = (values != 0.0) & np.isfinite(values)
        values, half, quarter, longer = (
            np.where(known, each[name], 0.0) for each in (fine, coarse.cells, coarse.quarter, coarse.blocks)
        )
        size = np.where(known, np.abs(values), 1.0)
        cells = np.fmax(np.abs(values - half), np.abs(half - quarter) / 4.0)
        blocks = np.abs(half - longer) / 3.0
        cells = np.maximum.accumulate(np.where(known, cells / size, 0.0))
        errors[name] = np.where(known, cells + np.fmax(blocks / size, missed), 0.0)
    return errors


def _notes(case: WearCase, history: History, blocks: int) -> tuple[str, ...]:
    """How the cycles were followed."""
    regime = "gross slip" if case.gross else "partial slip"
    control = "indentation" if case.request.normal_force is None else "load"
    stuck = [n for n, (mesh, _) in zip(history.cycles, history.states, strict=True) if mesh.stick > 0.0]
    if case.gross and stuck:
        regime = f"gross slip (from {stuck[0]:g} cycles on the centre sticks)"
    return (f"{regime} at constant {control}; {blocks} blocks of cycles, {_cells(history)} cells",)


def _cells(history: History) -> int:
    return int(history.states[0][0].rings.size)
