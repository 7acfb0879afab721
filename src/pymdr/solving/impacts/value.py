"""What an impact is when it is known."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pymdr.errors import QuantityError
from pymdr.interpretation.validity import Assumption, Claim
from pymdr.mapping.portable import portable
from pymdr.problem.contact import Contact
from pymdr.quantities import one_name, quantity
from pymdr.solving.closure import is_curve
from pymdr.units import from_si, shown

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


class Event(NamedTuple):
    """What happens in an impact."""

    name: str
    """``"touch"``, ``"jump into contact"``, ``"turning point"``, ``"separation"`` or ``"rest"``."""
    time: float
    """In s since the first touch."""
    indentation: float
    """In m."""


@dataclass(frozen=True)
class Impact:
    """An impact from the first touch to the last, or to the first rest of bodies that stick."""

    contact: Contact
    """What meets."""
    data: xr.Dataset
    """Over ``step``: time, indentation, velocity (above 0 on the approach), normal_force and contact_radius; with friction
    also shift, tangential_velocity, tangential_force, stick_radius and dissipated_energy; with memory elastic_energy and
    dissipated_energy of the springs."""
    restitution: float
    """Normal speed after the impact over that before it; 0 of bodies that stick."""
    contact_time: float
    """In s; inf of bodies that stick."""
    rebound_speed: float
    """Normal speed after the impact in m/s."""
    largest_force: float
    """In N."""
    largest_indentation: float
    """In m."""
    largest_radius: float
    """Of the contact in m; nan of a force curve."""
    largest_pressure: float
    """In Pa, without memory that at the turning point; inf under a sharp tip or edge, nan of a force curve."""
    energy_lost: float
    """Of the motion in J; all of it where the bodies stick. With memory a part of it is still in the springs as they part."""
    sticking_speed: float
    """Normal speed in m/s below which the energy that adhesion takes keeps the bodies together; 0 without adhesion."""
    tangential_speed: float
    """Tangential speed of the centre after the impact in m/s."""
    spin: float
    """In rad/s after the impact."""
    contact_point_speed: float
    """Tangential speed v + R omega of the contact point after the impact in m/s."""
    tangential_restitution: float
    """Less the ratio of the contact point's tangential speeds after and before; nan without such a speed."""
    events: tuple[Event, ...]
    """What happens, in order."""
    claims: Mapping[str, Claim]
    """How far every quantity can be trusted."""
    assumptions: tuple[Assumption, ...]
    """Conditions of the model, measured."""
    notes: tuple[str, ...] = ()
    """What was said on the way."""

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "contact": portable(self.contact, self.largest_radius)}

    def __getitem__(self, name: str) -> xr.DataArray:
        if one_name(name) not in self.data.variables:
            known = ", ".join(map(str, self.data.variables))
            raise QuantityError(f"no history {shown(name)}; an impact has {known}")
        return self.data[name]

    def summary(self) -> str:
        """The numbers with units, what happens, and how far to trust them."""
        from pymdr.presentation.text import impact_summary

        return impact_summary(self.groups(), self.events, self.claims, self.assumptions, self.notes)

    def groups(self) -> dict[str, dict[str, float]]:
        """The numbers in SI units under headings, by the names of their quantities."""
        groups = {
            "impact": {
                "restitution": self.restitution,
                "contact_time": self.contact_time,
                "rebound_speed": self.rebound_speed,
                "energy_lost": self.energy_lost,
            },
            "largest": {
                "indentation": self.largest_indentation,
                "normal_force": self.largest_force,
                **({} if is_curve(self.contact) else self._of_area),
            },
        }
        if self.contact.adhesion is not None:
            groups["adhesion"] = {"sticking_speed": self.sticking_speed}
        if "elastic_energy" in self.data:
            groups["at the end"] = {
                name: float(self.data[name][-1]) for name in ("dissipated_energy", "elastic_energy")
            }
        if "shift" in self.data or self.tangential_speed != 0.0 or self.spin != 0.0:
            groups["sideways"] = {
                "tangential_speed": self.tangential_speed,
                "spin": self.spin,
                "contact_point_speed": self.contact_point_speed,
                "tangential_restitution": self.tangential_restitution,
            }
        return groups

    @property
    def _of_area(self) -> dict[str, float]:
        return {"contact_radius": self.largest_radius, "peak_pressure": self.largest_pressure}

    def __str__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        """The numbers, claims and assumptions as tables, for notebooks."""
        from pymdr.presentation.html import impact_html

        return impact_html(self.groups(), self.events, self.claims, self.assumptions, self.notes)

    def plot(self) -> Figure:
        """Force and radius against time, and force against indentation; with friction the tangential force."""
        from pymdr.presentation.plot import impact_figure

        mu = None if self.contact.friction is None else self.contact.friction.coefficient
        return impact_figure(self.data, mu)

    def to_csv(
        self, file: str | os.PathLike[str], *, units: Mapping[str, str] | None = None, about: bool = False
    ) -> None:
        """
        Write the history to a CSV file, one row per step, with units in the names of the columns.

        Parameters
        ----------
        file : path
            For example "impact.csv".
        units : mapping of str to str, optional
            Name of a quantity -> unit; SI units unless given.
        about : bool
            Whether the version, the contact, claims, assumptions and notes stand above the header, in lines that begin with
            ``#``.
        """
        from pymdr.presentation.tables import write_csv

        write_csv(self._columns(units), file, self._about() if about else ())

    def to_xlsx(self, file: str | os.PathLike[str], *, units: Mapping[str, str] | None = None) -> None:
        """
        Write the same to a spreadsheet; what the numbers rest on is its second sheet.

        Parameters
        ----------
        file : path
            For example "impact.xlsx".
        units
            As for :meth:`to_csv`.

        Raises
        ------
        MissingExtraError
            Without openpyxl, which the extra ``xlsx`` brings.
        """
        from pymdr.presentation.tables import write_xlsx

        write_xlsx(self._columns(units), self._about(), file)

    def _columns(self, units: Mapping[str, str] | None) -> dict[str, np.ndarray]:
        columns: dict[str, np.ndarray] = {"step": np.arange(self.data.sizes["step"])}
        for name in map(str, self.data):
            own = quantity(name).unit
            unit = (units or {}).get(name, own)
            columns[f"{name} [{unit}]"] = np.asarray(from_si(self.data[name].values, own, unit))
        return columns

    def _about(self) -> list[tuple[str, str, str]]:
        from pymdr.presentation.tables import about_rows

        return about_rows(self.contact, self.claims, self.assumptions, self.notes)
