"""The value of a result: quantities by name, fields on demand, figures and files."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

import pymdr
from pymdr import presentation
from pymdr.deferred import mpl, pd, xr
from pymdr.errors import FileError, NotValidError, QuantityError
from pymdr.inside import (
    Inside,
    Superposed,
    animated_stress,
    checked,
    drawn_stress,
    interior_field,
    largest_in,
    point_columns,
)
from pymdr.interpretation.closure import known_error, pressed_curve
from pymdr.interpretation.conductance import driven
from pymdr.interpretation.interior import INTERIOR_FIELDS, LARGEST, Interior, known_sides
from pymdr.interpretation.peaks import largest_value
from pymdr.interpretation.validity import SOURCES, Assumption, Claim
from pymdr.mapping.portable import portable, require_known
from pymdr.problem.contact import Contact
from pymdr.problem.options import Checked, with_options
from pymdr.problem.paths import LoadingPath
from pymdr.problem.profiles import ForceCurve
from pymdr.quantities import POSITION, RADIUS, one_name, quantity
from pymdr.result.arrays import (
    by_component,
    error_with_band,
    field_array,
    labelled,
    locked_claim,
    locked_data,
    titled_columns,
)
from pymdr.result.readers import DirectedReader, EdgedField, FieldReader
from pymdr.result.rows import drawn_row, row_indices, spread_rows
from pymdr.result.status import Claims, Status
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, from_si, shown, to_si, to_si_array

if TYPE_CHECKING:
    from pymdr.presentation.plot import Plots


_HISTORIES = (
    ("shift", "tangential_force"),
    ("twist", "torque"),
    ("indentation", "normal_force"),
    ("normal_force", "contact_radius"),
    ("indentation", "contact_radius"),
)
"""Curves that are drawn next to an animation: the first pair whose quantities exist."""
_FEW_PEAKS = 500
"""Rows up to which tables hold the peak pressure, which takes about 10 ms a row."""


@dataclass(frozen=True)
class Reading:
    """How a result is read: its fields, their source, and its figures."""

    fields: tuple[str, ...]
    """Fields on the surface."""
    line_fields: tuple[str, ...]
    """Fields on the line."""
    reader: Callable[[Result], FieldReader]
    plots: Callable[[Result, int], Plots]
    """The figures of a row; -1 if none is valid."""
    elsewhere: Mapping[str, str] = field(default_factory=dict)
    """Fields and quantities of other contacts, with the reason why they are missing."""
    carried: Mapping[str, Callable[[Result], EdgedField]] = field(default_factory=dict)
    """Fields of heat and current flow, with their sources."""
    interior: Callable[[Result, str | None], Interior] | None = None
    """Source of fields inside the body of a side, if they are known."""


@dataclass(frozen=True, eq=False)
class Result(Checked):
    """
    The result of a solution.

    ``result["normal_force"]`` is a labelled array over ``step`` in SI units; ``result.to(name, unit)``
    converts; ``result.field(name, r, step)`` computes a field; ``result.claims[name]`` says how far a
    quantity can be trusted.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("210 GPa", 0.3))
    >>> result = mdr.solve(ball, mdr.load("50 N", steps=5))
    >>> round(float(result.to("contact_radius", "um")[-1]), 2)
    117.56
    >>> "torque" in result, list(result)[:3]
    (False, ['indentation', 'normal_force', 'contact_radius'])
    >>> result.claims["pressure"].level
    <Level.EXACT: 'exact'>
    """

    contact: Contact
    path: LoadingPath
    data: xr.Dataset
    """All quantities over ``step``, NaN where they are not valid."""
    claims: Mapping[str, Claim]
    assumptions: tuple[Assumption, ...]
    status: Status
    notes: tuple[str, ...]
    reading: Reading
    """How fields and figures are computed."""
    references: tuple[str, ...]
    """Keys of the theory that was used; :meth:`cite` writes them out."""
    rings: pymdr.Rings | None = None
    """The ring solver, if it was used instead of the method."""
    machine_stiffness: float | None = None
    """Stiffness of the machine in N/m, if there is one."""
    starts: tuple[Mapping[str, float], ...] | None = None
    """With friction: positions of all channels at the start of each leg, in SI units."""

    def __post_init__(self) -> None:
        data = self.data
        if "step" not in data.dims:  # no quantity is valid at any row
            rows = max((claim.where.size for claim in self.claims.values()), default=0)
            data = data.assign_coords(row=("step", np.arange(rows), {"long_name": "row of the path"}))
        object.__setattr__(self, "data", locked_data(data))
        object.__setattr__(self, "claims", Claims((n, locked_claim(c)) for n, c in self.claims.items()))

    def __getitem__(self, name: str) -> xr.DataArray:
        """A quantity over ``step``, in SI units; a copy of its own."""
        if one_name(name) == "peak_pressure" and name not in self.data:
            self._require("pressure")
            return self._peak_pressure.copy()
        if name in LARGEST:
            return self._largest_quantity(name).copy()
        self._require(name)
        self._refuse_missing(name)
        return self.data[name].copy()

    def __iter__(self) -> Iterator[str]:
        """The names of the quantities that can be read."""
        for name in self._names():
            claim = "pressure" if name == "peak_pressure" and name not in self.data else name
            if claim not in self.claims or self.claims[claim].readable:
                yield name

    def __contains__(self, name: object) -> bool:
        return name in tuple(self) or name in tuple(self.data.coords)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)

    def __getattr__(self, name: str) -> Any:
        remedy = ""
        if "data" in self.__dict__ and not name.startswith("_"):
            if name in self._names():
                remedy = f"; write result[{name!r}]"
            elif name in self._fields:
                remedy = f"; write result.field({name!r})"
        raise AttributeError(f"a result has no attribute {name!r}{remedy}")

    def _refuse_missing(self, name: str) -> None:
        if name not in self.data:
            if name in self.reading.elsewhere and quantity(name).dims == ("step",):
                raise QuantityError(f"{name}: {self.reading.elsewhere[name]}")
            if name in self._fields or name in self.reading.elsewhere:
                raise QuantityError(f"{name!r} is a field: read it with result.field({name!r}, r=...)")
            raise QuantityError(f"no quantity {shown(name)}; this result has {', '.join(self._names())}")

    def _names(self) -> list[str]:
        """Quantities that can be read."""
        inside = LARGEST if "stress" in self.claims and self.claims["stress"].readable else ()
        return list(dict.fromkeys([*map(str, self.data), "peak_pressure", *inside]))

    @property
    def bands(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Lower and upper ends of the bands by the scatter of a sampled profile, by quantity."""
        return {
            name: (self.data[f"{name}_low"].values, self.data[f"{name}_high"].values)
            for name in map(str, self.data)
            if f"{name}_low" in self.data
        }

    def _require(self, name: str) -> None:
        if name in self.claims:
            self.claims[name].require(name)

    def to(self, name: str, unit: str) -> xr.DataArray:
        """
        A quantity converted to another unit.

        Parameters
        ----------
        name : str
            Name of the quantity.
        unit : str
            Unit of the result, such as "um".

        Returns
        -------
        xarray.DataArray
            Over ``step``.

        Raises
        ------
        UnitError
            If the unit has another dimension.
        NotValidError
            If the quantity is not valid for this contact.
        """
        array = self[name]
        return array.copy(data=from_si(array.values, quantity(name).unit, unit)).assign_attrs(units=unit)

    @cached_property
    def _peak_pressure(self) -> xr.DataArray:
        """The largest pressure of every row, inf at a sharp edge or tip; computed on first use."""
        valid = self.claims["pressure"].where
        states = [
            self.data[name].values
            for name in ("indentation", "contact_radius", "cohesive_radius")
            if name in self.data
        ]
        values = np.full(self.data.sizes["step"], np.nan)
        rows = np.flatnonzero(valid)
        # rows of one state share a pressure
        _, firsts, of_state = np.unique(
            np.array([state[rows] for state in states]), axis=1, return_index=True, return_inverse=True
        )
        peaks = np.array([self._peak(int(rows[i])) for i in firsts])
        values[rows] = peaks[of_state.ravel()]
        return labelled({"peak_pressure": values})["peak_pressure"]

    def _peak(self, row: int) -> float:
        surface, end = self.surface, float(self.data["contact_radius"].values[row])
        return largest_value(lambda r: surface.field("pressure", r, row), end, surface.marks(row))

    @cached_property
    def surface(self) -> FieldReader:
        """The source of fields."""
        return self.reading.reader(self)

    @property
    def _fields(self) -> tuple[str, ...]:
        return (*self.reading.fields, *self.reading.line_fields, *self.reading.carried)

    @with_options(Inside)
    def field(
        self,
        name: str,
        r: ArrayQuantityLike | None = None,
        step: int | Sequence[int] | None = -1,
        *,
        angle: QuantityLike | None = None,
        drop: QuantityLike | None = None,
        flow: QuantityLike | None = None,
        **inside: Unpack[Inside],
    ) -> xr.DataArray:
        """
        A field on the surface (over radius r), on the line (over position x) or inside a body (over r and depth z, or x, y and z).

        Parameters
        ----------
        name : str
            ``"pressure"``, ``"normal_displacement"``, ``"gap"``; with friction ``"shear_traction"``,
            ``"tangential_displacement"`` and ``"slip"`` (the shift less the displacement of the surface, the relative
            displacement of initially opposite points; NaN outside the contact); on the line
            ``"equivalent_profile"``, ``"spring_force"`` and with friction ``"spring_shift"``; for bodies with
            conductivities ``"heat_flux"`` and ``"current_density"``, per unit of the drop between the bodies; inside a body
            ``"stress"``, ``"principal_stress"``, ``"von_mises"``, ``"tresca"``, ``"hydrostatic"`` (tension positive) and
            ``"interior_displacement"``.
        r : array_like or quantity, optional
            Radii (positions) in m; by default a graded grid to twice the contact radius.
        step : int or sequence of int, optional
            Index of a row, or several; None gives all rows.
        angle : quantity, optional
            For bodies that are not of revolution: the direction of the radii in rad from the x-axis; 0 by default.
        drop : quantity, optional
            For a flux: the voltage in V, or the temperature difference in K, between the bodies.
        flow : quantity, optional
            For a flux, instead of `drop`: the current in A, or the heat flow in W, through the contact.
        **inside
            Inside a body, all optional: ``z``, depths in m, at least 0 (to twice the contact radius by default); ``x`` and ``y``,
            positions in m along and across the shift, needed instead of `r` with friction (``y`` is 0 by default); ``side``,
            ``"body"`` or ``"counterbody"`` (by default the first whose stress is known), on which the shear traction acts against
            x; ``superposed``, a stress that is added, such as ``{"xx": "100 MPa"}``: components by name, each in Pa or a function
            of an array of depths in m.

        Returns
        -------
        xarray.DataArray
            Over ``r`` (``x``), or over ``step`` and ``r`` for several rows, tangential fields of a path in the plane over ``axis``
            before ``r``, NaN in those that are not valid; inside a body over
            ``z`` and ``r``, or ``z``, ``y`` if given, and ``x``, tensors and vectors over ``component`` before them (under torsion with
            ``rt`` and ``tz``, around the axis). Pressure and fluxes are inf at a singular edge,
            with its amplitude as the coordinate ``edge_amplitude``.

        Raises
        ------
        NotValidError
            If the field is not valid for this contact or this step.
        QuantityError
            If there is no such field, `drop` or `flow` is given for another field than a flux, both are given, or `drop` is a temperature.
        ProblemError
            If the gap or the equivalent profile is read beyond the saved range of a callable.
        """
        places = checked(inside, name, within=one_name(name) in INTERIOR_FIELDS)
        if name in INTERIOR_FIELDS:
            if angle is not None or drop is not None or flow is not None:
                raise QuantityError(f"angle=, drop= and flow= do not apply to {name}; leave them out")
            interior = self._interior(places.get("side"))
            return interior_field(interior, name, r, places, self._valid_rows("stress", name, step))
        self._require_field(name)
        chosen, several = self._valid_rows(name, name, step)
        carried = self.reading.carried.get(name)
        surface: EdgedField = self.surface if carried is None else carried(self)
        if angle is not None:
            surface = self._towards(to_si(angle, "rad", name="angle"))
        radii = (
            surface.default_radii(chosen[-1]) if r is None else np.atleast_1d(to_si_array(r, "m", name="r"))
        )
        if radii.ndim != 1:
            raise QuantityError(f"r has the shape {radii.shape}; one row of radii is needed")
        if name in ("gap", "equivalent_profile"):
            require_known(self.contact.profile, radii, name)
        values = np.array([surface.field(name, np.abs(radii), i) for i in chosen])
        axis = POSITION if name in self.reading.line_fields else RADIUS
        row = quantity(name)
        unit, long_name, factor = row.unit, row.long_name, np.ones(len(chosen))
        if drop is not None or flow is not None:
            unit, factor = driven(name, drop, flow, partial(self._column_values, chosen), len(chosen))
            values, long_name = values * factor[:, None], long_name.split(" per ")[0]
        edged = name == "pressure" or carried is not None
        amplitude = np.array([surface.edge_amplitude(i) for i in chosen]) * factor
        return field_array(
            name,
            values,
            (axis, radii),
            chosen,
            several,
            {"units": unit, "long_name": long_name, "symbol": row.symbol},
            (amplitude, f"{unit}*m^0.5") if edged else None,
        )

    def _require_field(self, name: str) -> None:
        self._require(name)
        if name in self._fields:
            return
        if name in self.reading.elsewhere:
            raise QuantityError(f"{name}: {self.reading.elsewhere[name]}")
        raise QuantityError(
            f"no field {shown(name)}; fields are {', '.join((*self._fields, *INTERIOR_FIELDS))}"
        )

    def _interior(self, side: str | None) -> Interior:
        self._require("stress")
        if self.reading.interior is None:
            raise QuantityError(
                "the stress in the bodies is not computed for this kind of contact; read the fields on the surface instead"
            )
        return self.reading.interior(self, side)

    def largest(
        self,
        name: str,
        step: int | Sequence[int] | None = None,
        *,
        side: str | None = None,
        superposed: Superposed | None = None,
    ) -> xr.DataArray:
        """
        The largest value of an equivalent or principal stress inside a body, and where it is.

        Parameters
        ----------
        name : str
            ``"von_mises"``, ``"tresca"`` or ``"principal_stress"`` (the largest tension); of layers also ``"interface_shear"`` and
            ``"interface_tension"``, the tractions on the interfaces.
        step : int or sequence of int, optional
            Row, or several; all unless given.
        side : str, optional
            ``"body"`` or ``"counterbody"``, as for :meth:`field`.
        superposed : mapping, optional
            A stress that is added, as for :meth:`field`.

        Returns
        -------
        xarray.DataArray
            In Pa, with the coordinates ``r`` and ``z`` in m of the place (with friction ``x``, ``y`` and ``z``), over ``step`` for
            several rows; inf where the stress has no bound. ``result["largest_mises"]``, ``result["largest_shear"]`` (half of the
            largest Tresca stress) and ``result["largest_principal"]`` are those of all rows.

        Raises
        ------
        NotValidError
            If the stress is not valid, or has no bound in all of these rows.

        Notes
        -----
        The field is searched, not a grid: the value is found to 1e-8, the place to 1e-4 of the contact radius.

        Examples
        --------
        >>> import pymdr as mdr
        >>> ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("210 GPa", 0.3))
        >>> result = mdr.solve(ball, mdr.load("50 N"))
        >>> mises = result.largest("von_mises", step=-1)
        >>> round(float(mises / result["peak_pressure"][-1]), 6), round(float(mises.z / result["contact_radius"][-1]), 4)
        (0.620041, 0.4809)
        """
        rows = self._valid_rows("stress", name, step)
        return largest_in(self._interior(side), name, superposed, rows, self.claims["stress"].where)

    @cached_property
    def _largest_stress(self) -> dict[str, xr.DataArray]:
        """Largest stresses over all rows by quantity, each computed at first use."""
        return {}

    def _largest_quantity(self, name: str) -> xr.DataArray:
        if name not in self._largest_stress:
            measure, factor = LARGEST[name]
            row = quantity(name)
            words = {"units": row.unit, "long_name": row.long_name, "symbol": row.symbol}
            values = (factor * self.largest(measure)).drop_vars("step")
            self._largest_stress[name] = values.rename(name).assign_attrs(words)
        return self._largest_stress[name]

    def _valid_rows(
        self, claimed: str, name: str, step: int | Sequence[int] | None
    ) -> tuple[list[int], bool]:
        """The rows that are read, and whether they are several; one alone has to be valid."""
        several = step is None or isinstance(step, list | tuple | range | np.ndarray)
        chosen = row_indices(step, self.data.sizes["step"])
        claim = self.claims.get(claimed)
        if not several and claim is not None and not claim.where[chosen[0]]:
            replace(claim, where=np.zeros(1, dtype=bool)).require(f"{name} at step {step}")
        return chosen, several

    def _column_values(self, rows: Sequence[int], name: str) -> FloatArray:
        self._require(name)
        return np.asarray(self.data[name].values[list(rows)])

    def _towards(self, angle: float) -> FieldReader:
        surface = self.surface
        if not isinstance(surface, DirectedReader):
            raise QuantityError("angle= is for bodies that are not of revolution; leave it out")
        return surface.towards(angle)

    def summary(self) -> str:
        """The last step, the claims and the assumptions, as text."""
        return presentation.text.summary(
            by_component(self.data),
            self.claims,
            self.assumptions,
            self.status.name,
            self.status.value,
            self.notes,
        )

    def __str__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        """The summary as tables, for notebooks."""
        return presentation.html.result_html(
            by_component(self.data),
            self.claims,
            self.assumptions,
            self.status.name,
            self.status.value,
            self.notes,
        )

    def __repr__(self) -> str:
        return f"<pymdr.Result {self.status.name}, {self.data.sizes.get('step', 0)} steps>"

    def cite(self) -> tuple[str, ...]:
        """References of the theory that this result used."""
        return tuple(SOURCES[key] for key in self.references)

    def plot(self, name: str | None = None, *, step: int = -1) -> mpl.figure.Figure:
        """
        The overview figure, or one figure by name.

        Parameters
        ----------
        name : str, optional
            ``"stress"``, as by :meth:`plot_stress`, or a name of :meth:`figures`; unless given the overview: the contact in section
            above its springs, its curve or loop, and a field.
        step : int
            The row to draw; by default the last in contact, with memory that of the largest load.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        QuantityError
            If there is no such figure.
        NotValidError
            If the stress is drawn and not valid.
        """
        if name == "stress":
            return self.plot_stress(step)
        plots = self.reading.plots(self, self._drawn_row(step))
        if name is None:
            return plots.overview(plots.data)
        figures = plots.figures(plots.data)
        if not isinstance(name, str) or name not in figures:
            hint = f"; for a row write step={name}" if isinstance(name, int) else ""
            raise QuantityError(f"no figure {shown(name)}; figures are {', '.join(figures)}, stress{hint}")
        return figures[name]

    def figures(self, step: int = -1) -> dict[str, mpl.figure.Figure]:
        """
        All figures of the result by name.

        Parameters
        ----------
        step : int
            The row to draw, as in :meth:`plot`.

        Returns
        -------
        dict of str to matplotlib.figure.Figure
            ``section``, ``curves`` and ``fields``; with adhesion ``section``, ``loop``, ``radius`` and ``fields``;
            with friction ``section``, ``loop``, ``tractions`` and ``energies``.
        """
        plots = self.reading.plots(self, self._drawn_row(step))
        return plots.figures(plots.data)

    def plot_stress(
        self,
        step: int = -1,
        *,
        name: str = "von_mises",
        side: str | None = None,
        superposed: Superposed | None = None,
    ) -> mpl.figure.Figure:
        """
        The stress inside the bodies: a measure in section with its largest value, and the components on the axis and at the surface.

        Parameters
        ----------
        step : int
            The row that is drawn, as in :meth:`plot`.
        name : str
            ``"von_mises"``, ``"tresca"``, ``"principal_stress"`` (the largest) or ``"hydrostatic"``.
        side : str, optional
            ``"body"`` or ``"counterbody"``; unless given every body whose stress is known, the counterbody above the surface.
        superposed : mapping, optional
            A stress that is added, as for :meth:`field`.

        Returns
        -------
        matplotlib.figure.Figure
            With friction along the shift; where the stress has no bound the reason is named.

        Raises
        ------
        NotValidError
            If the stress is not valid in this contact or row.
        QuantityError
            If stress is not drawn by this measure.
        """
        row = self._drawn_row(step)
        self._valid_rows("stress", "stress", max(row, 0))
        return drawn_stress(self._interiors(side), name, row, superposed)

    def _interiors(self, side: str | None) -> dict[str, Interior]:
        """The body of a side, or every one whose stress is known."""
        sides = known_sides(self.contact) if side is None else [side]
        return {one: self._interior(one) for one in sides or ["body"]}

    def animate_stress(
        self,
        file: str | os.PathLike[str],
        *,
        name: str = "von_mises",
        side: str | None = None,
        step: int | Sequence[int] | None = None,
        superposed: Superposed | None = None,
    ) -> None:
        """
        Write the stress in section along the path as an animation, next to the curve or loop of the path.

        Parameters
        ----------
        file : path
            For example "cycle.gif".
        name, side, superposed
            As for :meth:`plot_stress`.
        step : sequence of int, optional
            The rows, one per frame; unless given 24 rows in contact, spread evenly.

        Raises
        ------
        FileError
            If the name of the file does not end with .gif, or it cannot be written.
        NotValidError
            If the stress is not valid, or the bodies do not touch in any of the rows.
        """
        target = presentation.files.named_file(file, "write")
        if target.suffix.lower() != ".gif":
            raise FileError(f"cannot write {target}: an animation is a GIF; end its name with .gif")
        self._require("stress")
        interiors = self._interiors(side)
        touching = np.nan_to_num(self.data["contact_radius"].values) > 0.0
        valid = self.claims["stress"].where & touching
        rows = spread_rows(valid) if step is None else row_indices(step, valid.size)
        if not rows or not valid[rows].all():
            raise NotValidError(
                "in these rows the stress is not valid or the bodies do not touch; choose rows in contact with step="
            )
        history = next(
            (self.data[x], self.data[y])
            for x, y in _HISTORIES
            if x in self.data and y in self.data and self.data[x].ndim == self.data[y].ndim == 1
        )
        presentation.files.write_atomically(
            target, lambda temporary: animated_stress(interiors, (name, superposed), rows, history, temporary)
        )

    @with_options(Inside)
    def stress_to_csv(
        self,
        file: str | os.PathLike[str],
        *,
        r: ArrayQuantityLike | None = None,
        step: int = -1,
        **inside: Unpack[Inside],
    ) -> None:
        """
        Write the stress inside a body to a CSV file, one row per point.

        Parameters
        ----------
        file : path
            For example "stress.csv".
        r, step
            As for :meth:`field`; the row is chosen as in :meth:`plot`.
        **inside
            ``x``, ``y``, ``z``, ``side`` and ``superposed``, as for :meth:`field`.

        Raises
        ------
        FileError
            If the file cannot be written.
        NotValidError
            If the stress is not valid in this contact or row.
        """
        row = max(self._drawn_row(step), 0)
        fields = [
            self.field(name, r, row, **inside)
            for name in ("stress", "principal_stress", "von_mises", "tresca")
        ]
        presentation.tables.write_csv(point_columns(fields), file)

    def _drawn_row(self, step: int) -> int:
        return drawn_row(self.data, self.claims["pressure"].where, step, self.contact.is_viscoelastic)

    def save(self, file: str | os.PathLike[str]) -> None:
        """
        Write the result to a NetCDF file, whole or not at all.

        Parameters
        ----------
        file : path
            For example "ball.nc"; :func:`pymdr.open_result` reads it back, and checks it by a checksum after the end of
            the file.

        Raises
        ------
        FileError
            If the file cannot be written, or its name is that of another format.
        """
        presentation.files.write_dataset(self.to_dataset(), file)

    def to_csv(
        self,
        file: str | os.PathLike[str],
        *,
        quantities: Sequence[str] | None = None,
        units: Mapping[str, str] | None = None,
        about: bool = False,
    ) -> None:
        """
        Write the quantities to a CSV file, one row per step, with units in the names of the columns.

        Parameters
        ----------
        file : path
            For example "ball.csv".
        quantities : sequence of str, optional
            Columns, such as ``["indentation", "peak_pressure"]``; by default all of ``data``, and the peak pressure if there are
            at most 500 rows. It takes about 10 ms a row; that of more rows has to be named.
        units : mapping of str to str, optional
            Name of a quantity -> unit, such as ``{"indentation": "um"}``; SI units by default.
        about : bool
            Whether to write the version, the contact, claims, assumptions, notes and sources above the header, in lines that
            begin with ``#``.

        Raises
        ------
        FileError
            If the file cannot be written.
        UnitError
            If a unit has another dimension.
        QuantityError
            If the result does not have a quantity, or `units` names one that is not written.
        NotValidError
            If a named quantity is not valid for this contact.

        Notes
        -----
        Fields and the path are not in the table: :meth:`save` keeps them. Values that are not valid are
        empty. An approximate quantity has an adjacent column of relative errors, empty where they are not known. :func:`pymdr.read_record` reads loads and displacements back, :func:`pymdr.read_path` and
        :func:`pymdr.read_force_curve` as far as they are paths and curves.
        """
        presentation.tables.write_csv(self._columns(quantities, units), file, self._about() if about else ())

    def to_xlsx(
        self,
        file: str | os.PathLike[str],
        *,
        quantities: Sequence[str] | None = None,
        units: Mapping[str, str] | None = None,
    ) -> None:
        """
        Write the quantities to a spreadsheet; the second sheet has the claims, assumptions and sources.

        Parameters
        ----------
        file : path
            For example "ball.xlsx".
        quantities, units
            As for :meth:`to_csv`.

        Raises
        ------
        MissingExtraError
            If openpyxl (the extra ``xlsx``) is not installed.
        FileError, UnitError, QuantityError, NotValidError
            As :meth:`to_csv` does.
        """
        presentation.tables.write_xlsx(self._columns(quantities, units), self._about(), file)

    def _columns(
        self, quantities: Sequence[str] | None, units: Mapping[str, str] | None
    ) -> dict[str, np.ndarray]:
        names = self._names()
        if quantities is None and self.data.sizes["step"] <= _FEW_PEAKS and self.claims["pressure"].readable:
            quantities = [name for name in names if name not in LARGEST]
        rows = self.data.coords.get("row")
        return titled_columns(by_component(self._table(quantities)), rows, self.claims, units or {}, names)

    def _about(self) -> list[tuple[str, str, str]]:
        others = {
            "status": f"{self.status.name}: {self.status.value}",
            "path": presentation.tables.part_text(self.path),
        }
        if self.machine_stiffness is not None:
            others["machine_stiffness"] = f"{self.machine_stiffness!r} N/m"
        if self.rings is not None:
            others["solver"] = repr(self.rings)
        return presentation.tables.about_rows(
            self.contact, self.claims, self.assumptions, self.notes, self.cite(), others
        )

    def to_dataset(self) -> xr.Dataset:
        """The whole result as one dataset with text attributes."""
        return presentation.files.pack(
            self.data,
            self._saved_contact(),
            self.path,
            self.claims,
            self.assumptions,
            status=self.status.name,
            notes=self.notes,
            references=self.references,
            rings=None if self.rings is None else self.rings.n,
            machine_stiffness=self.machine_stiffness,
            starts=None if self.starts is None else [dict(start) for start in self.starts],
        )

    def force_curve(self) -> ForceCurve:
        """
        The force curve of a result, for use as the profile of another contact.

        Its modulus is the E* of this contact. Rows are sorted by depth. Its points have the errors of the claims.

        Returns
        -------
        ForceCurve

        Raises
        ------
        ProblemError
            If the contact has adhesion, memory or a graded body, or fewer than 5 rows are in contact.
        NotValidError
            If the force or the indentation is not valid.

        Examples
        --------
        >>> import pymdr as mdr
        >>> ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("1 GPa", 0.3))
        >>> mdr.solve(ball, mdr.indent("1 um", steps=50)).force_curve().force.size
        50
        """
        depth, force = (self[name].values for name in ("indentation", "normal_force"))
        errors = (
            error_with_band(known_error(self.claims[name]), self[name].values, self.bands.get(name))
            for name in ("indentation", "normal_force")
        )
        return pressed_curve(self.contact, depth, force, *errors)

    def _saved_contact(self) -> Contact:
        radius = max(self._largest("contact_radius"), self._largest("cohesive_radius"))
        return portable(self.contact, radius, self._largest("indentation"))

    def _largest(self, name: str) -> float:
        """The largest value of a quantity over all rows, and at least 0."""
        return float(np.nanmax(self.data[name].values, initial=0.0)) if name in self.data else 0.0

    def to_dataframe(self, *, quantities: Sequence[str] | None = None) -> pd.DataFrame:
        """One row per step, one column per quantity, in SI units; `quantities` as in :meth:`to_csv`."""
        return by_component(self._table(quantities)).to_dataframe()

    def _table(self, quantities: Sequence[str] | None) -> xr.Dataset:
        """The requested quantities over ``step``; all stored ones by default."""
        if quantities is None:
            return self.data
        if isinstance(quantities, str) or not isinstance(quantities, Sequence) or not quantities:
            raise QuantityError(
                f"quantities = {shown(quantities)}: a list of names is needed, such as ['normal_force', 'peak_pressure']"
            )
        table = self.data[[]]
        return table.assign({name: self[name].variable for name in quantities})

    def to_xarray(self) -> xr.Dataset:
        """The labelled arrays over ``step``, as copies."""
        return self.data.copy(deep=True)

    def __getstate__(self) -> dict[str, Any]:
        state = {f.name: getattr(self, f.name) for f in fields(self)}
        return {**state, "contact": self._saved_contact()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.__post_init__()
