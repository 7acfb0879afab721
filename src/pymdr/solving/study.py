"""The common part of studies, which answer questions without a path: labelled columns, claims, summary, files."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pymdr import presentation
from pymdr.deferred import mpl, xr
from pymdr.errors import QuantityError
from pymdr.interpretation.conductance import CONDUCTIONS
from pymdr.interpretation.validity import SOURCES, Assumption, Claim
from pymdr.mapping.portable import portable
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.problem.options import Checked
from pymdr.quantities import of_whole, one_name
from pymdr.result import Claims
from pymdr.units import FloatArray, from_si, good_unit, shown

if TYPE_CHECKING:
    from pymdr.presentation.report import ReportPart
    from pymdr.presentation.text import StudyText


TextTable = tuple[tuple[list[str], list[str]], list[list[str]]]
"""Labels and units of columns, and rows of cells."""
_SHOWN = 40
"""Largest number of rows of a summary."""


class Column(NamedTuple):
    """A column of the summary."""

    label: str
    unit: str
    """The SI unit."""


@dataclass(frozen=True, kw_only=True)
class Answer(Checked):
    """Data with claims, conditions and sources, and how they are shown and written."""

    data: xr.Dataset
    claims: Mapping[str, Claim] = field(default_factory=dict)
    """Validity and error of each quantity."""
    assumptions: tuple[Assumption, ...] = ()
    """Conditions of the model, measured."""
    notes: tuple[str, ...] = ()
    """Remarks on the computation."""
    contact: Contact | None = None
    """The contact, if the study is about one."""
    references: tuple[str, ...] = ()
    """Keys of the sources that :meth:`cite` names."""

    columns: ClassVar[Mapping[str, Column]] = {}
    """Columns of the summary, by quantity."""
    summary_claims: ClassVar[tuple[str, ...]] = ()
    """The quantities whose claims the summary shows; all by default."""
    claims_of_rows: ClassVar[bool] = True
    """Whether the claims are about the rows of the data, whose tables then show their errors."""
    _drawn: ClassVar[tuple[str, ...]] = ()
    """The function of :mod:`pymdr.presentation.plot` that draws the study, and the attributes that it draws."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "claims", Claims(self.claims))

    def __getstate__(self) -> dict[str, Any]:
        if self.contact is None:
            return self.__dict__
        radii = [self.data[name].values for name in map(str, self.data) if name.endswith("radius")]
        largest = max((float(np.nanmax(radius, initial=0.0)) for radius in radii), default=math.nan)
        return {**self.__dict__, "contact": portable(self.contact, largest)}

    def cite(self) -> tuple[str, ...]:
        """References of the theory and of the method."""
        return tuple(SOURCES[key] for key in self.references)

    def plot(self) -> mpl.figure.Figure:
        """The overview figure, with the conditions that are not met below it."""
        return plot.with_unmet(self._figure(), self.assumptions)

    def _figure(self) -> mpl.figure.Figure:
        """The figure; by default the columns of the summary over the rows."""
        from pymdr.presentation import plot

        if self._drawn:
            draw, *parts = self._drawn
            figure: mpl.figure.Figure = getattr(plot, draw)(*(getattr(self, part) for part in parts))
            return figure
        return plot.columns_study(self.data, {name: column.label for name, column in self.columns.items()})

    def groups(self) -> dict[str, dict[str, float]]:
        """Single numbers in SI units under headings, by the names of their quantities."""
        return {}

    def _remarks(self) -> list[str]:
        """Lines of the summary between the table and the claims."""
        return []

    @property
    def _shown_claims(self) -> dict[str, Claim]:
        chosen = self.summary_claims or self.claims
        refused = [
            one.quantity for one in CONDUCTIONS if one.quantity in self.claims
        ]  # why the table lacks them
        refused = [name for name in refused if not self.claims[name].readable]
        return {name: self.claims[name] for name in [*chosen, *refused] if name in self.claims}

    def summary(self) -> str:
        """The numbers with units, their claims, and the conditions of the model that are not met."""
        return presentation.text.study_summary(*self._said())

    def _said(self) -> StudyText:
        """Content of the summary, for text and HTML."""
        header, cells = self._table()
        rows = max(self.data.sizes.values(), default=1)
        cut = [f"{len(cells)} of {rows} rows"] if len(cells) == _SHOWN < rows else []
        remarks = [*cut, *self._remarks()]
        return self.groups(), (header, cells), remarks, self._shown_claims, self.assumptions, self.notes

    def _table(self) -> TextTable:
        """Labels, units and cells of the summary."""
        columns = self._columns()
        names = [name for name in self.columns if name in columns]
        for name in names:
            columns[name] = columns[name][_some_rows(columns[name].size)]
        texts = {name for name in names if columns[name].dtype.kind == "U"}
        units = ["" if name in texts else good_unit(columns[name], self.columns[name].unit) for name in names]
        values = [
            columns[name] if name in texts else from_si(columns[name], self.columns[name].unit, unit)
            for name, unit in zip(names, units, strict=True)
        ]
        rows = [[_cell(value) for value in row] for row in zip(*values, strict=True)]
        return ([self.columns[name].label for name in names], units), rows

    def _columns(self) -> dict[str, np.ndarray]:
        """Quantities in SI units, one entry per row; single numbers only if there are no arrays."""
        from pymdr.result.arrays import by_component

        data = by_component(self.data)
        names = [str(name) for name in (*data.coords, *data.data_vars) if data[name].ndim or not data.dims]
        arrays = xr.broadcast(*(data[name] for name in names))
        return {name: np.atleast_1d(array.values.ravel()) for name, array in zip(names, arrays, strict=True)}

    def _repr_html_(self) -> str:
        """The summary as HTML tables, for notebooks."""
        return presentation.html.study_html(*self._said())

    def __str__(self) -> str:
        return self.summary()

    def save(self, file: str | os.PathLike[str]) -> None:
        """
        Write data, claims, assumptions and notes to a NetCDF file, whole or not at all.

        Parameters
        ----------
        file : path
            For example "study.nc"; ``xarray.open_dataset`` reads the data, and its attribute ``pymdr_metadata`` is JSON.

        Raises
        ------
        FileError
            If the file cannot be written, or its name is that of another format.
        """
        presentation.files.write_dataset(self._stored(), file)

    def _stored(self) -> xr.Dataset:
        """Content of a file: the data, and the rest as JSON."""
        as_json = presentation.files.study_json(self.claims, self.assumptions, self.notes)
        return self.data.assign_attrs(pymdr_format="pymdr study 1", pymdr_metadata=as_json)

    def to_csv(
        self, file: str | os.PathLike[str], *, units: Mapping[str, str] | None = None, about: bool = False
    ) -> None:
        """
        Write the columns to a CSV file, with units in their names.

        An approximate quantity has an adjacent column of relative errors, empty where they are not known.

        Parameters
        ----------
        file : path
            For example "study.csv".
        units : mapping of str to str, optional
            Name of a quantity -> unit; SI units by default.
        about : bool
            Whether to write the version, claims, assumptions and notes above the header, in lines that begin with ``#``.
        """
        presentation.tables.write_csv(self._written(units), file, self._about() if about else ())

    def to_xlsx(self, file: str | os.PathLike[str], *, units: Mapping[str, str] | None = None) -> None:
        """
        Write the same to a spreadsheet; the second sheet has the claims, assumptions and sources.

        Parameters
        ----------
        file : path
            For example "study.xlsx".
        units
            As for :meth:`to_csv`.

        Raises
        ------
        MissingExtraError
            If openpyxl (the extra ``xlsx``) is not installed.
        """
        presentation.tables.write_xlsx(self._written(units), self._about(), file)

    def to_html(
        self, file: str | os.PathLike[str], *, title: str = "", settings: Mapping[str, str] | None = None
    ) -> None:
        """
        Write a printable report, one HTML file with everything in it: tables, figures, claims, assumptions, notes and sources.

        Parameters
        ----------
        file : path
            For example "report.html".
        title : str
            Its heading.
        settings : mapping of str to str, optional
            Further rows of the table of settings, by name; the parts of the contact and the version are in it.

        Raises
        ------
        FileError
            If the file cannot be written, or its name is that of another format.
        """
        about = [
            (kind, text) for kind, name, text in self._about() if not name and kind not in ("note", "cite")
        ]
        header, cells = self._table()
        text = self.groups(), (header, cells), self._report_lines(), self.claims, self.assumptions, self.notes
        rows = [*(settings or {}).items(), *about]
        presentation.report.write_report(
            file, presentation.report.Report(title, rows, text, self.plot, self._report_parts(), self.cite())
        )

    def _report_lines(self) -> list[str]:
        """Lines of a report between the table and the figure."""
        return self._remarks()

    def _report_parts(self) -> list[ReportPart]:
        """Further sections of a report."""
        return []

    def _written(self, units: Mapping[str, str] | None) -> dict[str, np.ndarray]:
        """Columns of a table, by their titles."""
        written: dict[str, np.ndarray] = {}
        columns = self._columns()
        for name, values in columns.items():
            quantity = self._quantity_of(name)
            own = str(self.data[quantity].attrs.get("units", ""))
            unit = (units or {}).get(quantity, own)
            title = f"{name} [{unit}]" if unit else name
            written[title] = np.asarray(from_si(values, own, unit)) if unit else values
        owners = {name: self._quantity_of(name) for name in columns}
        of_columns = {name: self.claims[own] for name, own in owners.items() if own in self.claims}
        return presentation.tables.with_error_columns(
            written, {**self.claims, **of_columns} if self.claims_of_rows else {}
        )

    def _quantity_of(self, column: str) -> str:
        """The quantity of a column of a table."""
        return column if column in self.data else of_whole(column)

    def _about(self) -> list[tuple[str, str, str]]:
        return presentation.tables.about_rows(
            self.contact, self.claims, self.assumptions, self.notes, self.cite(), self._others()
        )

    def _others(self) -> dict[str, str]:
        """Other information of a table, by kind."""
        single = presentation.text.number_lines(self.groups() if self.data.dims else {})
        return {f"{heading} {label}": value for heading, rows in single for label, value in rows}


@dataclass(frozen=True, kw_only=True)
class Study(Answer):
    """Quantities over the rows of a request, or single numbers, each with its claim."""

    subject: ClassVar[str]
    """Name of the study in messages."""

    def __getitem__(self, name: str) -> xr.DataArray:
        if one_name(name) in self.claims:
            self.claims[name].require(name)
        if name not in self.data.variables:
            known = ", ".join(map(str, self.data.variables))
            raise QuantityError(f"no quantity {shown(name)}; {self.subject} has {known}")
        return self.data[name]

    def __iter__(self) -> Iterator[str]:
        """The names of the quantities that can be read."""
        return (n for n in map(str, self.data) if n not in self.claims or self.claims[n].readable)

    def __contains__(self, name: object) -> bool:
        return name in tuple(self) or name in tuple(self.data.coords)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)

    def __getattr__(self, name: str) -> Any:
        known = "data" in self.__dict__ and not name.startswith("_") and name in self.data.variables
        raise AttributeError(
            f"{type(self).__name__} has no attribute {name!r}" + (f"; write [{name!r}]" if known else "")
        )

    def to(self, name: str, unit: str) -> xr.DataArray:
        """
        A quantity converted to another unit.

        Raises
        ------
        QuantityError
            If there is no such quantity.
        NotValidError
            If it is nowhere valid.
        UnitError
            If the unit is of another kind.
        """
        array = self[name]
        own = str(array.attrs.get("units", ""))
        return array.copy(data=from_si(array.values, own, unit)).assign_attrs(units=unit)


def _some_rows(count: int) -> np.ndarray:
    """All rows of a short table, evenly spaced rows of a long one."""
    return np.unique(np.linspace(0, count - 1, min(count, _SHOWN)).round().astype(int))


def _cell(value: float | str) -> str:
    if isinstance(value, str):
        return value
    return "-" if np.isnan(value) else f"{value:.4g}"


def number(name: str, doc: str) -> property:
    """A single number of the data in SI units, as an attribute."""
    return property(lambda study: float(study.data[name]), doc=doc)


def dataset(
    variables: Mapping[str, Any],
    coords: Mapping[str, Any] | None = None,
    attrs: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """A data set of xarray, which is imported when the first one is made."""
    return xr.Dataset(variables, coords, attrs)


def over_rows(
    over: str,
    along: ArrayLike,
    columns: Mapping[str, FloatArray],
    labels: Mapping[str, Column],
    attrs: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Columns over one coordinate, with the units of their labels; bands have the unit of their quantity."""

    def unit(name: str) -> dict[str, str]:
        return {"units": labels[name.removesuffix("_low").removesuffix("_high")].unit}

    return dataset(
        {name: (over, values, unit(name)) for name, values in columns.items()},
        coords={over: (over, along, unit(over))} if over in labels else {},
        attrs=attrs,
    )
