"""What answers to questions without a path have in common: labelled columns, claims, and how they read."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from pymdr.errors import ProblemError, QuantityError
from pymdr.interpretation.validity import Assumption, Claim
from pymdr.quantities import one_name
from pymdr.units import ArrayQuantityLike, FloatArray, from_si, good_unit, shown, to_si_array

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


class Column(NamedTuple):
    """A column of the summary."""

    words: str
    unit: str
    """The SI unit."""


@dataclass(frozen=True, kw_only=True)
class Study(ABC):
    """Quantities over what was asked, each with its claim."""

    data: xr.Dataset
    claims: Mapping[str, Claim]
    """How far each quantity can be trusted."""
    assumptions: tuple[Assumption, ...]
    """Conditions of the model, measured."""
    notes: tuple[str, ...]
    """What was said on the way."""

    what: ClassVar[str]
    """What was studied, for messages."""
    columns: ClassVar[Mapping[str, Column]]
    """Of the summary, by quantity."""
    told: ClassVar[tuple[str, ...]]
    """The quantities whose claims the summary tells."""

    def __getitem__(self, name: str) -> xr.DataArray:
        if one_name(name) in self.claims:
            self.claims[name].require(name)
        if name not in self.data.variables:
            known = ", ".join(map(str, self.data.variables))
            raise QuantityError(f"no quantity {shown(name)}; {self.what} has {known}")
        return self.data[name]

    @abstractmethod
    def plot(self) -> Figure:
        """What a person wants to see first."""

    def _remarks(self) -> list[str]:
        """Lines of the summary between the table and the claims."""
        return []

    def summary(self) -> str:
        """A line per row, with units, and how far to trust it."""
        head, rows = self._table()
        lines = [" ".join(f"{cell:>12}" for cell in row) for row in (*head, *rows)]
        lines += self._remarks()
        for name in self.told:
            claim = self.claims[name]
            which = f"{self.columns[name].words}: " if len(self.told) > 1 else ""
            lines.append(f"{which}{claim.level.value}: {claim.reason}")
        lines += [
            f"not met: {a.words} {a.measure:.3g}, limit {a.limit:.3g}" for a in self.assumptions if not a.met
        ]
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def _table(self) -> tuple[tuple[list[str], list[str]], list[list[str]]]:
        """Words and units, and the numbers."""
        names = [name for name in self.columns if name in self.data.variables]
        units = [good_unit(self.data[name].values, self.columns[name].unit) for name in names]
        columns = [
            from_si(self.data[name].values, self.columns[name].unit, unit)
            for name, unit in zip(names, units, strict=True)
        ]
        rows = [
            ["-" if np.isnan(value) else f"{value:.4g}" for value in row]
            for row in zip(*columns, strict=True)
        ]
        return ([self.columns[name].words for name in names], units), rows

    def _repr_html_(self) -> str:
        """The summary as a table, for notebooks."""
        from pymdr.presentation.html import table

        (words, units), rows = self._table()
        head = [f"{word} ({unit})" if unit else word for word, unit in zip(words, units, strict=True)]
        claims = "".join(self.claims[name]._repr_html_() for name in self.told)
        return f"<div>{table(head, rows)}{claims}</div>"

    def __str__(self) -> str:
        return self.summary()

    def to_csv(
        self, file: str | os.PathLike[str], *, units: Mapping[str, str] | None = None, about: bool = False
    ) -> None:
        """
        Write the columns to a CSV file, one row per row, with units in their names.

        A quantity that is approximate has a column of its relative errors beside it, empty where they are not known.

        Parameters
        ----------
        file : path
            For example "study.csv".
        units : mapping of str to str, optional
            Name of a quantity -> unit; SI units unless given.
        about : bool
            Whether the version, claims, assumptions and notes stand above the header, in lines that begin with ``#``.
        """
        from pymdr.presentation.tables import write_csv

        write_csv(self._written(units), file, self._about() if about else ())

    def to_xlsx(self, file: str | os.PathLike[str], *, units: Mapping[str, str] | None = None) -> None:
        """
        Write the same to a spreadsheet; what the numbers rest on is its second sheet.

        Parameters
        ----------
        file : path
            For example "study.xlsx".
        units
            As for :meth:`to_csv`.

        Raises
        ------
        MissingExtraError
            Without openpyxl, which the extra ``xlsx`` brings.
        """
        from pymdr.presentation.tables import write_xlsx

        write_xlsx(self._written(units), self._about(), file)

    def _written(self, units: Mapping[str, str] | None) -> dict[str, np.ndarray]:
        """What is written, by the titles of its columns."""
        from pymdr.presentation.tables import with_error_columns

        written: dict[str, np.ndarray] = {}
        for name in (*self.data.coords, *self.data.data_vars):
            array = self.data[name]
            if array.ndim:
                own = str(array.attrs["units"])
                unit = (units or {}).get(str(name), own)
                title = f"{name} [{unit}]" if unit else str(name)
                written[title] = np.asarray(from_si(array.values, own, unit))
        return with_error_columns(written, self.claims)

    def _about(self) -> list[tuple[str, str, str]]:
        from pymdr.presentation.tables import about_rows

        return about_rows(None, self.claims, self.assumptions, self.notes)


def one_row(given: ArrayQuantityLike, unit: str, who: str, name: str) -> FloatArray:
    """One row of numbers in SI units."""
    values = np.atleast_1d(to_si_array(given, unit, name=name))
    if values.ndim != 1 or values.size == 0:
        raise ProblemError(f"{who}: {name} = {shown(given)}; one row of numbers is needed")
    return values
