"""Results of impacts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, NamedTuple

from pymdr.problem.contact import Contact
from pymdr.solving.closure import is_curve
from pymdr.solving.study import Column, Study, number
from pymdr.units import metres, written

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


class Event(NamedTuple):
    """An event of an impact."""

    name: str
    """``"touch"``, ``"jump into contact"``, ``"turning point"``, ``"separation"`` or ``"rest"``."""
    time: float
    """In s since the first touch."""
    indentation: float
    """In m."""


@dataclass(frozen=True, kw_only=True)
class Impact(Study):
    """An impact from first touch to separation, or to the first rest of bodies that stick."""

    data: xr.Dataset
    """Over ``step``: time, indentation, velocity (above 0 on the approach), normal_force and contact_radius; with friction
    also shift, tangential_velocity, tangential_force, stick_radius and dissipated_energy; with memory elastic_energy and
    dissipated_energy of the springs. The single numbers are also attributes."""
    contact: Contact
    """The contact of the bodies."""
    events: tuple[Event, ...]
    """Events in order."""

    subject: ClassVar = "an impact"

    restitution = number(
        "restitution", "Normal speed after the impact over that before it; 0 for bodies that stick."
    )
    contact_time = number("contact_time", "In s; inf for bodies that stick.")
    rebound_speed = number("rebound_speed", "Normal speed after the impact in m/s.")
    largest_force = number("largest_force", "In N.")
    largest_indentation = number("largest_indentation", "In m.")
    largest_radius = number("largest_radius", "Contact radius in m; NaN for a force curve.")
    largest_pressure = number(
        "largest_pressure",
        "In Pa, without memory that at the turning point; inf under a sharp tip or edge, NaN for a force curve or a body that yields.",
    )
    energy_lost = number(
        "energy_lost",
        "Kinetic energy lost in J; all of it if the bodies stick. With memory a part of it is in the springs at separation.",
    )
    sticking_speed = number(
        "sticking_speed",
        "Normal speed in m/s below which the bodies stick because of adhesion; 0 without adhesion.",
    )
    tangential_speed = number("tangential_speed", "Tangential speed of the centre after the impact in m/s.")
    spin = number("spin", "In rad/s after the impact.")
    contact_point_speed = number(
        "contact_point_speed", "Tangential speed v + R omega of the contact point after the impact in m/s."
    )
    tangential_restitution = number(
        "tangential_restitution",
        "Negative ratio of the contact point's tangential speeds after and before; NaN without such a speed.",
    )

    def groups(self) -> dict[str, dict[str, float]]:
        """The numbers in SI units under headings, by the names of their quantities."""
        of_area = {"contact_radius": self.largest_radius}
        if self.contact.plastic is None:
            of_area["peak_pressure"] = self.largest_pressure
        groups = {
            "impact": self._numbers("restitution", "contact_time", "rebound_speed", "energy_lost"),
            "largest": {
                "indentation": self.largest_indentation,
                "normal_force": self.largest_force,
                **({} if is_curve(self.contact) else of_area),
            },
        }
        if self.contact.adhesion is not None:
            groups["adhesion"] = self._numbers("sticking_speed")
        if "elastic_energy" in self.data:
            groups["at the end"] = {
                name: float(self.data[name][-1]) for name in ("dissipated_energy", "elastic_energy")
            }
        if "shift" in self.data or self.tangential_speed != 0.0 or self.spin != 0.0:
            groups["tangential"] = self._numbers(
                "tangential_speed", "spin", "contact_point_speed", "tangential_restitution"
            )
        return groups

    def _numbers(self, *names: str) -> dict[str, float]:
        return {name: float(self.data[name]) for name in names}

    def _remarks(self) -> list[str]:
        lines = [f"  {name:<36}{written(time, 's'):>16}  at d = {metres(d)}" for name, time, d in self.events]
        return ["events:", *lines]

    def _figure(self) -> Figure:
        """Force and radius against time, and force against indentation; with friction the tangential force."""
        from pymdr.presentation.plot import impact_figure

        mu = None if self.contact.friction is None else self.contact.friction.coefficient
        return impact_figure(self.data, mu)


@dataclass(frozen=True, kw_only=True)
class Restitution(Study):
    """Normal impacts of one contact at many speeds."""

    data: xr.Dataset
    """Over ``speed`` (m/s): restitution, contact_time (s; inf for bodies that stick), and the largest indentation (m),
    normal_force (N) and contact_radius (m)."""

    subject: ClassVar = "a study of restitution"
    columns: ClassVar = {
        "speed": Column("speed", "m/s"),
        "restitution": Column("restitution", ""),
        "contact_time": Column("time", "s"),
        "indentation": Column("depth", "m"),
        "normal_force": Column("F_N", "N"),
        "contact_radius": Column("radius", "m"),
    }
    summary_claims: ClassVar = ("restitution", "indentation")

    def _figure(self) -> Figure:
        """Restitution and contact time against the speed."""
        from pymdr.presentation.plot import restitution_study

        return restitution_study(self.data)
