"""Fatigue of a body over a cycle of a contact: the largest value of a criterion, its place and its plane."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import NotValidError, ProblemError
from pymdr.inside import background_of
from pymdr.interpretation.endangered import Site, most_endangered
from pymdr.interpretation.fatigue import Rating, StressCycle, rating_of, stress_cycle
from pymdr.interpretation.interior import Background, Interior
from pymdr.interpretation.validity import Claim, Level
from pymdr.presentation import plot
from pymdr.problem.fatigue import (
    DangVan,
    FatemiSocie,
    FatigueCriterion,
    Findley,
    RuizDamage,
    RuizWork,
    SmithWatsonTopper,
)
from pymdr.problem.layers import Layered
from pymdr.problem.paths import Cycle
from pymdr.quantities import ACROSS, ALONG, DEPTH, quantity
from pymdr.result import Result
from pymdr.solving.study import Study, dataset, number
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, shown, to_si, to_si_array

CycledStress: TypeAlias = Mapping[str, QuantityLike | ArrayQuantityLike | Callable[[FloatArray], Any]]
"""Components of a stress by name: a quantity, one value for every row of the result, or a function of the depths in m."""
_PLACE = ("fatigue_x", "fatigue_y", "fatigue_z")
_PLANE = ("plane_x", "plane_y", "plane_z")
_SPAN, _COLUMNS, _LINES = 2.0, 41, 17
"""Of a map: half of its width over the loaded radius, and its points along and down."""


@dataclass(frozen=True, kw_only=True)
class Fatigue(Study):
    """
    The largest value of a criterion of fatigue over a cycle, by :func:`fatigue`.

    Single numbers: the value, by the name of the criterion (dang_van_stress, findley_stress and smith_watson_topper in Pa, fatemi_socie_strain,
    ruiz_work in N/m, ruiz_damage in Pa N/m); fatigue_x, fatigue_y and fatigue_z (m), the place; plane_x, plane_y and plane_z, the unit
    normal of the plane; fatigue_ratio, the value over the endurance limit, if one was given.
    """

    criterion: FatigueCriterion
    rows: tuple[int, ...]
    """Rows of the result that are the cycle."""
    rating: Rating
    cycle: StressCycle
    contact_radius: float
    """The largest of the cycle in m."""

    subject: ClassVar = "a fatigue study"
    claims_of_rows: ClassVar[bool] = False
    x = number("fatigue_x", "Place along the shift in m.")
    y = number("fatigue_y", "Place across the shift in m.")
    z = number("fatigue_z", "Depth of the place in m.")

    @property
    def value(self) -> float:
        """The largest value of the criterion in its SI unit."""
        return float(self.data[self.criterion.quantity])

    @property
    def plane(self) -> FloatArray:
        """Unit normal of the plane, shape (3,); nan if the criterion has no plane."""
        return np.array([float(self.data[name]) if name in self.data else math.nan for name in _PLANE])

    @property
    def on_surface(self) -> bool:
        """Whether the criterion is known on the surface only."""
        return isinstance(self.criterion, RuizWork | RuizDamage)

    def __getstate__(self) -> dict[str, Any]:
        raise ProblemError(
            "a fatigue study cannot be pickled, because it keeps the fields of its result; save it with save(), or pickle the result"
        )

    def groups(self) -> dict[str, dict[str, float]]:
        """The value, the place and the plane under headings."""
        shown_names = [self.criterion.quantity, *(["fatigue_ratio"] if "fatigue_ratio" in self.data else [])]
        groups = {
            type(self.criterion).__name__: {name: float(self.data[name]) for name in shown_names},
            "place": {name: float(self.data[name]) for name in _PLACE},
        }
        if not np.isnan(self.plane).any():
            groups["normal of the plane"] = dict(zip(_PLANE, self.plane.tolist(), strict=True))
        return groups

    def field(
        self,
        x: ArrayQuantityLike | None = None,
        y: ArrayQuantityLike | None = None,
        z: ArrayQuantityLike | None = None,
    ) -> xr.DataArray:
        """
        A map of the criterion, at every point on the plane where it is largest.

        Parameters
        ----------
        x, y, z : array_like or quantity, optional
            Positions in m along and across the shift, and depths of at least 0; one row each. By default a section through the most
            endangered place. The parameters of Ruiz are known at z = 0 only.

        Returns
        -------
        xarray.DataArray
            Over ``z``, ``y`` and ``x``.

        Raises
        ------
        ProblemError
            If a row is not one of finite numbers, or a depth is below 0 (for the parameters of Ruiz, other than 0).
        """
        size = _SPAN * self.cycle.radius
        depths = np.zeros(1) if self.on_surface else np.linspace(0.0, 0.75 * size, _LINES)
        centre = np.zeros(1) if math.isnan(self.y) else np.array([self.y])
        axes = {
            "z": _row("z", z, depths),
            "y": _row("y", y, centre),
            "x": _row("x", x, np.linspace(-size, size, _COLUMNS + 40 * self.on_surface)),
        }
        low = axes["z"].min()
        if low < 0.0 or (self.on_surface and axes["z"].any()):
            need = "0 m, the surface," if self.on_surface else "depths of at least 0 m"
            raise ProblemError(f"z = {shown(z)}; {need} {'is' if self.on_surface else 'are'} needed")
        grid = [axis.ravel() for axis in np.meshgrid(*axes.values(), indexing="ij")]
        values, _ = self.rating.whole(np.hypot(grid[2], grid[1]), np.arctan2(grid[1], grid[2]), grid[0])
        row = quantity(self.criterion.quantity)
        words = {"z": DEPTH.long_name, "y": ACROSS.long_name, "x": ALONG.long_name}
        return xr.DataArray(
            values.reshape([axis.size for axis in axes.values()]),
            dims=tuple(axes),
            coords={
                name: (name, axis, {"units": "m", "long_name": words[name]}) for name, axis in axes.items()
            },
            name=row.name,
            attrs={"units": row.unit, "long_name": row.long_name, "symbol": row.symbol},
        )

    def _figure(self) -> mpl.figure.Figure:
        """The map through the most endangered place, with its plane."""
        size = _SPAN * self.cycle.radius
        across = np.linspace(-0.75 * size, 0.75 * size, 61) if self.on_surface else None
        field = self.field(y=across)
        return plot.fatigue_study(
            field, self.contact_radius, (self.x, self.y, self.z), self.plane, self.value
        )


def fatigue(
    result: Result,
    *,
    criterion: FatigueCriterion,
    steps: Sequence[int] | None = None,
    side: str | None = None,
    superposed: CycledStress | None = None,
) -> Fatigue:
    """
    The largest value of a criterion of fatigue in a body over a cycle of a contact, where it is, and on which plane.

    Parameters
    ----------
    result : Result
        Of a contact of elastic half-spaces, with or without friction, whose stress is valid in the rows of the cycle.
    criterion : FatigueCriterion
        DangVan, Findley, FatemiSocie or SmithWatsonTopper; on the surface of contacts with friction RuizWork or RuizDamage.
    steps : sequence of int, optional
        The rows of the cycle; unless given, those of the last cycle if the path ends with :func:`cycle`, otherwise all.
    side : str, optional
        ``"body"`` or ``"counterbody"``; the first whose stress is known unless given.
    superposed : mapping, optional
        A stress that is added, such as a bulk stress: components xx, yy, zz, xz, xy, yz by name, each a quantity in Pa, one value for every
        row of the result, or a function of an array of depths in m that gives Pa.

    Returns
    -------
    Fatigue
        The value, the place and the plane; :meth:`Fatigue.field` maps the criterion.

    Raises
    ------
    ProblemError
        If the criterion is of another kind, or there are fewer than two rows.
    NotValidError
        If the stress is not valid or has no bound in a row, the body is layered, or the criterion needs strain or slip that are not known.

    See Also
    --------
    first_yield : the load at which a body yields.
    wear : fretting wear over cycles.

    Notes
    -----
    The stress is that of the rows; stresses between the rows are not considered. The place is searched on the field, not on a grid. All criteria are
    empirical.

    References
    ----------
    - Dang Van, Griveau and Message (1989), in Biaxial and Multiaxial Fatigue, EGF 3, 479-496.
    - Findley (1959), J. Eng. Ind. 81, 301-306.
    - Fatemi and Socie (1988), Fatigue Fract. Eng. Mater. Struct. 11, 149-165.
    - Smith, Watson and Topper (1970), J. Mater. 5, 767-778.
    - Ruiz, Boddington and Chen (1984), Exp. Mech. 24, 208-217.

    Examples
    --------
    >>> import pymdr as mdr
    >>> steel = mdr.Elastic("210 GPa", 0.3)
    >>> joint = mdr.Contact(mdr.Sphere("10 mm"), steel, steel, friction=mdr.Coulomb(0.5))
    >>> result = mdr.solve(joint, mdr.load("100 N") >> mdr.cycle(tangential_force="30 N", steps=16))
    >>> worst = mdr.fatigue(result, criterion=mdr.SmithWatsonTopper(endurance_limit="5 MPa"))
    >>> round(abs(worst.x) / float(result["contact_radius"][-1]), 4), worst.z
    (1.0, 0.0)
    """
    interior = _stress_of(result, criterion, side)
    rows, how = _rows_of(result, steps)
    name = side or ("counterbody" if interior.sign < 0.0 else "body")
    if isinstance(getattr(result.contact, name), Layered):
        raise NotValidError(
            "fatigue is not valid here: it is computed in half-spaces, not in layers; give the other side="
        )
    cycle = stress_cycle(interior, rows, _backgrounds(superposed, result.data.sizes["step"], rows))
    rating = rating_of(criterion, cycle, interior, rows)
    site = most_endangered(rating, cycle)
    columns = _columns(criterion, site)
    claim = _empirical(criterion, result.claims["stress"])
    return Fatigue(
        data=dataset(
            {
                one: ((), value, {"units": quantity(one).unit, "long_name": quantity(one).long_name})
                for one, value in columns.items()
            }
        ),
        claims=dict.fromkeys(columns, claim),
        assumptions=result.assumptions,
        notes=(*result.notes, how),
        contact=result.contact,
        references=("stress", "shear-stress", *result.references),
        criterion=criterion,
        rows=tuple(rows),
        rating=rating,
        cycle=cycle,
        contact_radius=float(np.nanmax(result.data["contact_radius"].values[list(rows)])),
    )


def _stress_of(result: Result, criterion: FatigueCriterion, side: str | None) -> Interior:
    """The stress in a body; refuse what is not a result and a criterion, and results without the stress or slip that the criterion needs."""
    if not isinstance(result, Result):
        raise ProblemError(f"{shown(result)} is not a Result; write fatigue(solve(contact, path), ...)")
    if not isinstance(criterion, FatigueCriterion):
        raise ProblemError(
            f"criterion = {shown(criterion)}; a criterion such as DangVan(hydrostatic_slope=0.3) is needed"
        )
    result.claims["stress"].require("fatigue")
    if isinstance(criterion, RuizWork | RuizDamage) and "slip" in result.claims:
        result.claims["slip"].require(f"{type(criterion).__name__} of slip")
    if result.reading.interior is None:
        raise NotValidError(
            "fatigue is not valid here: the stress in the bodies is not computed for this kind of contact"
        )
    return result.reading.interior(result, side)


def _empirical(criterion: FatigueCriterion, stress: Claim) -> Claim:
    """The claim of a criterion, from that of the stress."""
    return Claim(
        Level.APPROXIMATE,
        f"the criterion is empirical; the stress is {stress.level.value} in its model",
        criterion.source,
        np.ones(1, dtype=bool),
    )


def _columns(criterion: FatigueCriterion, site: Site) -> dict[str, float]:
    """The numbers of a study by name, in SI units."""
    across = 0.0 if abs(site.angle) == math.pi else site.r * math.sin(site.angle)
    columns = {
        criterion.quantity: site.value,
        **dict(zip(_PLACE, (site.r * math.cos(site.angle), across, site.z), strict=True)),
    }
    if not np.isnan(site.plane).any():
        columns |= dict(zip(_PLANE, site.plane.tolist(), strict=True))
    if criterion.endurance_limit is not None:
        columns["fatigue_ratio"] = site.value / criterion.endurance_limit
    return columns


def _rows_of(result: Result, steps: Sequence[int] | None) -> tuple[list[int], str]:
    """The rows of a cycle, and a note that names them."""
    count = result.data.sizes["step"]
    if steps is None:
        rows, what = list(range(count)), "all rows"
        leg = getattr(result.path, "legs", (result.path,))[-1]
        if isinstance(leg, Cycle):
            assert leg.steps is not None
            kept = result.data["row"].values if "row" in result.data.coords else np.arange(count)
            total = int(kept[-1]) + 1
            rows = np.flatnonzero(kept >= total - leg.steps // leg.cycles).tolist()
            what = "the last cycle"
    else:
        given = np.atleast_1d(np.asarray(steps))
        if given.ndim != 1 or given.dtype.kind not in "iu" or not np.all((given >= -count) & (given < count)):
            raise ProblemError(f"steps = {shown(steps)}; rows of the result from 0 to {count - 1} are needed")
        rows, what = [int(i) % count for i in given], "as given"
    if len(rows) < 2:
        raise ProblemError(f"{len(rows)} row{'s' * (len(rows) != 1)}; a cycle needs at least 2 rows")
    return (
        rows,
        f"one cycle, rows {min(rows)} to {max(rows)} ({what}); stresses between rows are not evaluated",
    )


def _backgrounds(superposed: CycledStress | None, count: int, rows: Sequence[int]) -> list[Background] | None:
    """A superposed stress in every row of the cycle."""
    if superposed is None:
        return None
    fixed: dict[str, Any] = {}
    cycled: dict[str, FloatArray] = {}
    # background_of checks names and units of what does not change
    for name, value in (superposed if isinstance(superposed, Mapping) else {}).items():
        if callable(value) or isinstance(value, str) or np.ndim(np.asarray(value, dtype=object)) == 0:
            fixed[name] = value
            continue
        values = to_si_array(getattr(value, "values", value), "Pa", name=f"superposed[{name!r}]")
        if values.shape != (count,) or not np.isfinite(values).all():
            raise ProblemError(
                f"superposed[{name!r}] has the shape {values.shape}; one finite stress in Pa for each of the {count} rows of the "
                "result is needed, or one for all"
            )
        cycled[name], fixed[name] = values, 0.0
    if not fixed:
        background_of(superposed)  # type: ignore[arg-type]
    added = []
    for row in rows:
        one = background_of(fixed | {name: float(values[row]) for name, values in cycled.items()})
        assert one is not None
        added.append(one)
    return added


def _row(name: str, given: ArrayQuantityLike | None, otherwise: FloatArray) -> FloatArray:
    """One row of positions in m."""
    values = otherwise if given is None else np.atleast_1d(to_si_array(given, "m", name=name))
    if values.ndim != 1 or values.size == 0 or not np.isfinite(values).all():
        raise ProblemError(f"{name} = {shown(given)}; one row of finite positions is needed")
    return values


_SLOPES = {DangVan: "hydrostatic_slope", Findley: "normal_slope", FatemiSocie: "normal_slope"}
CRITERIA: Mapping[str, type[FatigueCriterion]] = {
    "dang-van": DangVan,
    "findley": Findley,
    "fatemi-socie": FatemiSocie,
    "smith-watson-topper": SmithWatsonTopper,
    "ruiz-work": RuizWork,
    "ruiz-damage": RuizDamage,
}
"""Criteria by their names in the shell."""


def criterion_of(
    name: str, *, slope: str | None = None, yield_strength: str | None = None, limit: str | None = None
) -> FatigueCriterion:
    """
    A criterion by its name in the shell.

    Parameters
    ----------
    name : str
        One of :data:`CRITERIA`.
    slope, yield_strength, limit : str, optional
        Its arguments, with units.
    """
    if name not in CRITERIA:
        raise ProblemError(f"criterion = {shown(name)}; one of {', '.join(CRITERIA)} is needed")
    kind = CRITERIA[name]
    needed = {"slope": _SLOPES.get(kind), "yield_strength": "yield_strength" if kind is FatemiSocie else None}
    arguments: dict[str, Any] = {} if limit is None else {"endurance_limit": limit}
    for option, value in (("slope", slope), ("yield_strength", yield_strength)):
        argument, shell = needed[option], f"--{option.replace('_', '-')}"
        if (argument is None) != (value is None):
            what = "needs" if value is None else "has no"
            remedy = f"give {shell}" if value is None else f"leave {shell} out"
            raise ProblemError(f"{name} {what} {shell}; {remedy}")
        if argument is not None:
            arguments[argument] = value
    return kind(**arguments)


def cycled_bulk(result: Result, constant: str | None, amplitude: str | None) -> CycledStress | None:
    """
    A bulk stress along the shift, constant or in phase with the tangential force.

    Parameters
    ----------
    constant, amplitude : str, optional
        In Pa; the amplitude belongs to the largest tangential force.
    """
    if constant is None and amplitude is None:
        return None
    values = np.full(result.data.sizes["step"], to_si(constant or 0.0, "Pa", name="bulk"))
    if amplitude is not None:
        size = to_si(amplitude, "Pa", name="bulk_amplitude")
        force = result.data["tangential_force"].values if "tangential_force" in result.data else np.zeros(1)
        largest = float(np.nanmax(np.abs(force)))
        if not largest > 0.0:
            raise ProblemError(
                "bulk_amplitude needs a tangential force, with which it is in phase; give a cycle of shift or force"
            )
        values = values + size * force / largest
    return {"xx": values}
