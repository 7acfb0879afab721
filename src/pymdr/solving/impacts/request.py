"""The request of an impact."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.contact import Contact, require_contact
from pymdr.problem.values import within_range
from pymdr.units import QuantityLike, shown, to_si


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


def above(value: QuantityLike, unit: str, name: str, prefix: str = "impact") -> float:
    """A number above 0 in a unit, or an error that names it."""
    number = to_si(value, unit, name=name)
    if not 0.0 < number < math.inf:
        raise ProblemError(f"{prefix}: {name} = {shown(value)}; it must be above 0 {unit} and finite")
    return float(within_range(number, unit, f"{prefix}: {name}", size=True))


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
    require_contact(contact, "impact")
    m, v = above(mass, "kg", "mass"), above(speed, "m/s", "speed")
    tilt = to_si(angle, "rad", name="angle")
    if not 0.0 <= tilt < 0.5 * math.pi:
        raise ProblemError(
            f"impact: angle = {shown(angle)}; the angle from the normal must be at least 0 and below 90 deg (a plain number is "
            "in rad): at 90 deg the bodies do not meet"
        )
    if not isinstance(steps, int | np.integer) or isinstance(steps, bool) or steps < 8 or steps % 4:
        raise ProblemError(f"impact: steps = {steps!r}; a multiple of 4 is needed, at least 8")
    turning = float(within_range(to_si(spin, "rad/s", name="spin"), "rad/s", "impact: spin"))
    ball = contact.profile.curvature_radius if _is_ball(contact) else None
    arm = ball if radius is None else above(radius, "m", "radius")
    gyration = None if inertia is None else above(inertia, "kg*m^2", "inertia")
    if gyration is None and ball is not None and (radius is None or arm == ball):
        gyration = 0.4 * m * ball * ball
    if arm is None and turning != 0.0:
        raise ProblemError(
            "impact: spin needs the distance from the centre to the contact point; give radius='10 mm'"
        )
    mu = coefficient_of(contact, "impact")
    if not math.isfinite(mu):
        raise ProblemError(
            f"impact: mu = {mu:g}; the coefficient of friction must be finite, for example Coulomb(1)"
        )
    slides = mu > 0.0
    if slides and (tilt > 0.0 or turning != 0.0) and (arm is None or gyration is None):
        raise ProblemError(
            f"impact: with friction a {type(contact.profile).__name__} needs the moment of inertia about its centre and the "
            "distance to the contact point; give inertia='4e-7 kg*m^2' and radius='10 mm' (only spheres and paraboloids of "
            "their own radius have defaults, those of solid balls)"
        )
    normal, tangential = v * math.cos(tilt), v * math.sin(tilt)
    return ImpactRequest(contact, m, normal, tangential, turning, arm, gyration, int(steps))


def coefficient_of(contact: Contact, prefix: str) -> float:
    """
    The coefficient of friction, 0 without.

    Raises
    ------
    ProblemError
        If a body has memory and the coefficient is above 0, or a body is layered.
    """
    if contact.layered is not None:
        raise ProblemError(
            f"{prefix}: impacts on a Layered body are not available: the quasi-static force law ignores waves reflected by the base; "
            "solve(...) gives that law, or use Elastic for the body"
        )
    mu = 0.0 if contact.friction is None else contact.friction.coefficient
    if mu > 0.0 and contact.is_viscoelastic:
        raise ProblemError(
            f"{prefix}: friction (mu = {mu:g}) in impacts of bodies with memory is not available; leave friction out for the normal "
            "motion, or use Elastic with the modulus at one time"
        )
    return mu


def _is_ball(contact: Contact) -> bool:
    from pymdr.problem.profiles import Paraboloid, Sphere

    return type(contact.profile) in (Sphere, Paraboloid)
