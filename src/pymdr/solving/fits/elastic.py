"""The forces of elastic contacts at measured depths."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import ClassVar

import numpy as np

from pymdr.errors import ProblemError, PymdrError
from pymdr.line.curves import Line
from pymdr.line.foundation import normal_force, states_at_depth
from pymdr.line.shapes import ShapeLaw, shape_law
from pymdr.mapping.equivalent import PowerLine, equivalent_profile
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.contact import Contact
from pymdr.problem.parameters import parameters_of, with_parameters
from pymdr.problem.profiles import Shape
from pymdr.solving.mapped import map_to_line
from pymdr.units import FloatArray

_WITHIN = 1.0 - 1e-9


class LinearForces(ABC):
    """Forces of elastic bodies without adhesion."""

    fold: ClassVar[float] = 0.0

    @property
    def end(self) -> float:
        """The depth in m at the end of the profile; inf without an end."""
        return math.inf

    @abstractmethod
    def at(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force in N and stiffness in N/m."""

    @abstractmethod
    def radius(self, depth: FloatArray) -> FloatArray:
        """Contact radius in m at depths in m; of shapes that are not of revolution the longest distance of the edge from the apex."""

    def over_root(self, r: FloatArray, span: float) -> tuple[FloatArray, FloatArray]:
        """Force in N and its slope over r at the depths span r^2, in m."""
        force, stiffness = self.at(span * r * r)
        return force, stiffness * 2.0 * r * span


@dataclass(frozen=True)
class ElasticForces(LinearForces):
    """Forces of elastic bodies without adhesion."""

    line: Line

    @cached_property
    def end(self) -> float:
        """The depth in m at the end of the profile, beyond which the force is extrapolated along its tangent; inf without an end."""
        return (
            float(self.line.depth(np.array(_WITHIN * self.line.max_radius)))
            if math.isfinite(self.line.max_radius)
            else math.inf
        )

    def at(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force in N and stiffness in N/m."""
        states = states_at_depth(self.line, np.clip(depth, 0.0, self.end))
        stiffness = self.line.stiffness(states.place)
        return normal_force(self.line, states) + stiffness * np.maximum(depth - self.end, 0.0), stiffness

    def radius(self, depth: FloatArray) -> FloatArray:
        """Contact radius in m at depths in m."""
        return np.asarray(states_at_depth(self.line, np.maximum(depth, 0.0)).contact_radius)


@dataclass(frozen=True)
class ScaledForces(LinearForces):
    """Forces of layered bodies, by those of bodies of the same ratios, which are tabulated once."""

    reference: ElasticForces
    own: Contact
    depth: float
    """In m per m of the reference."""
    force: float
    """In N per N of the reference."""
    width: float
    """Radius in m per m of the reference."""

    @property
    def end(self) -> float:
        """The depth in m at the end of the profile."""
        return self.depth * self.reference.end

    def at(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force in N and stiffness in N/m."""
        try:
            force, stiffness = self.reference.at(depth / self.depth)
        except PymdrError:  # with its own radii in the message
            return ElasticForces(_line_of(self.own)).at(depth)
        return self.force * force, self.force / self.depth * stiffness

    def radius(self, depth: FloatArray) -> FloatArray:
        """Contact radius in m at depths in m."""
        return self.width * self.reference.radius(depth / self.depth)


@dataclass(frozen=True)
class ShapeForces(LinearForces):
    """Forces of elastic bodies whose profile is a pyramid or an elliptic paraboloid."""

    law: ShapeLaw
    modulus: float
    """E* in Pa."""

    def at(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force in N and stiffness in N/m."""
        states = self.law.at(depth, np.zeros_like(depth))
        return self.modulus * states.force, self.modulus * states.stiffness

    def radius(self, depth: FloatArray) -> FloatArray:
        """Longest distance in m of the edge of the contact from the apex at depths in m."""
        return self.law.at(depth, np.zeros_like(depth)).longest


def elastic_forces(contact: Contact) -> LinearForces:
    """
    The forces of elastic bodies; with layers in multiples of the modulus of one part.

    Forces are proportional to all moduli together. Under a power law, f ~ r^n, contacts of all thicknesses are similar: with lengths along
    the surface in multiples of a thickness h, depths are proportional to h^n and forces to h^(n + 1).
    """
    if isinstance(contact.profile, Shape):
        return _shape_forces(contact, contact.profile)
    if contact.layered is None or contact.is_viscoelastic:
        return ElasticForces(_line_of(contact))
    own = [p for p in parameters_of(contact) if not p.name.startswith("profile.")]
    moduli = {p.name: p.value for p in own if p.unit == "Pa"}
    lengths = {p.name: p.value for p in own if p.unit == "m"}
    modulus, (thickness, *_) = contact.layered.top.young, lengths.values()
    equivalent, n, unit = equivalent_profile(contact.profile), 0.0, thickness
    if isinstance(equivalent, PowerLine):
        n, unit = equivalent.n, equivalent.unit
    # quotients first: they are the same for all bodies of the same ratios
    scaled = {name: value / modulus for name, value in moduli.items()}
    scaled |= {name: value / thickness * unit for name, value in lengths.items()}
    forces, longer = ElasticForces(_line_of(with_parameters(contact, scaled))), thickness / unit
    return ScaledForces(forces, contact, longer**n, modulus * longer ** (n + 1.0), longer)


def _shape_forces(contact: Contact, shape: Shape) -> ShapeForces:
    """The forces of a body that is not of revolution, if they are known and not only estimated."""
    law = shape_law(shape)
    if not law.known:
        raise ProblemError(
            f"the force of {type(shape).__name__} is only bounded and estimated; fit a Pyramid or an EllipticParaboloid, or "
            "azimuthal_mean(shape), whose force is a lower bound"
        )
    return ShapeForces(law, effective_moduli(contact.body, contact.counterbody).normal)


@lru_cache(maxsize=16)
def _line_of(contact: Contact) -> Line:
    return map_to_line(contact).line
