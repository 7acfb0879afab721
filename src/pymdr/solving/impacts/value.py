"""The request of an impact, and its results."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError
from pymdr.presentation import plot
from pymdr.problem.contact import Contact, is_curve, require_contact
from pymdr.problem.values import within_range
from pymdr.solving.study import Column, Study, number
from pymdr.units import QuantityLike, metres, shown, to_si, written


@dataclass(frozen=True)
class ImpactRequest:
    """An impact in SI units."""

    contact: Contact
    mass: float
    normal: float
    """Normal speed in m/s."""
    tangential: float
    """Tangential speed of the centre in m/s."""
    spin: float
    radius: float | None
    inertia: float | None
    steps: int

    @property
    def contact_point(self) -> float:
        """Tangential speed of the contact point in m/s."""
        return self.tangential + (self.radius or 0.0) * self.spin


def above(value: QuantityLike, unit: str, name: str) -> float:
    """A number above 0 in a unit, or an error that names it."""
    number = to_si(value, unit, name=name)
    if not 0.0 < number < math.inf:
        raise ProblemError(f"{name} = {shown(value)}; it must be above 0 {unit} and finite")
    return float(within_range(number, unit, name, size=True))


def read(
    contact: Contact,
    mass: QuantityLike,
    speed: QuantityLike,
    angle: QuantityLike,
    inertia: QuantityLike | None,
    radius: QuantityLike | None,
    spin: QuantityLike,
    steps: int,
) -> ImpactRequest:
    """Check the arguments; balls are solid by default."""
    require_contact(contact)
    m, v = above(mass, "kg", "mass"), above(speed, "m/s", "speed")
    tilt = to_si(angle, "rad", name="angle")
    if not 0.0 <= tilt < 0.5 * math.pi:
        raise ProblemError(
            f"angle = {shown(angle)}; the angle from the normal must be at least 0 and below 90 deg (a plain number is "
            "in rad): at 90 deg the bodies do not meet"
        )
    if not isinstance(steps, int | np.integer) or isinstance(steps, bool) or steps < 8 or steps % 4:
        raise ProblemError(f"steps = {steps!r}; a multiple of 4 is needed, at least 8")
    turning = float(within_range(to_si(spin, "rad/s", name="spin"), "rad/s", "spin"))
    from pymdr.problem.profiles import Paraboloid, Sphere

    ball = contact.profile.curvature_radius if type(contact.profile) in (Sphere, Paraboloid) else None
    arm = ball if radius is None else above(radius, "m", "radius")
    gyration = None if inertia is None else above(inertia, "kg*m^2", "inertia")
    if gyration is None and ball is not None and (radius is None or arm == ball):
        gyration = 0.4 * m * ball * ball
    if arm is None and turning != 0.0:
        raise ProblemError(
            "spin needs the distance from the centre to the contact point; give radius='10 mm'"
        )
    mu = coefficient_of(contact)
    if not math.isfinite(mu):
        raise ProblemError(f"mu = {mu:g}; the coefficient of friction must be finite, for example Coulomb(1)")
    slides = mu > 0.0
    if slides and (tilt > 0.0 or turning != 0.0) and (arm is None or gyration is None):
        raise ProblemError(
            f"with friction a {type(contact.profile).__name__} needs the moment of inertia about its centre and the "
            "distance to the contact point; give inertia='4e-7 kg*m^2' and radius='10 mm' (only spheres and paraboloids of "
            "their own radius have defaults, those of solid balls)"
        )
    normal, tangential = v * math.cos(tilt), v * math.sin(tilt)
    return ImpactRequest(contact, m, normal, tangential, turning, arm, gyration, int(steps))


def coefficient_of(contact: Contact) -> float:
    """The coefficient of friction, 0 without."""
    if contact.layered is not None:
        raise ProblemError(
            "impacts on a Layered body are not available: the quasi-static force law ignores waves reflected by the base; "
            "solve(...) gives that law, or use Elastic for the body"
        )
    mu = 0.0 if contact.friction is None else contact.friction.coefficient
    if mu > 0.0 and contact.is_viscoelastic:
        raise ProblemError(
            f"friction (mu = {mu:g}) in impacts of bodies with memory is not available; leave friction out for the normal "
            "motion, or use Elastic with the modulus at one time"
        )
    return mu


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

    def _figure(self) -> mpl.figure.Figure:
        """Force and radius against time, and force against indentation; with friction the tangential force."""
        mu = None if self.contact.friction is None else self.contact.friction.coefficient
        return plot.impact_figure(self.data, mu)


@dataclass(frozen=True, kw_only=True)
class Restitution(Study):
    """Normal impacts of one contact at many speeds."""

    data: xr.Dataset
    """Over ``speed`` (m/s): restitution, contact_time (s; inf for bodies that stick), and the largest indentation (m),
    normal_force (N) and contact_radius (m)."""

    subject: ClassVar = "a study of restitution"
    _drawn: ClassVar = ("restitution_study", "data")
    columns: ClassVar = {
        "speed": Column("speed", "m/s"),
        "restitution": Column("restitution", ""),
        "contact_time": Column("time", "s"),
        "indentation": Column("depth", "m"),
        "normal_force": Column("F_N", "N"),
        "contact_radius": Column("radius", "m"),
    }
    summary_claims: ClassVar = ("restitution", "indentation")
