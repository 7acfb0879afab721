"""Fields of a history on demand: the formula of every field name, and its radii."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pymdr.errors import QuantityError
from pymdr.interpretation import fields
from pymdr.interpretation.cohesion import cohesive_displacement, cohesive_pressure, cohesive_spring_shift
from pymdr.interpretation.stress import LineLoad, Loads, line_load
from pymdr.interpretation.theories import theory_of
from pymdr.interpretation.validity import NORMAL_FIELDS
from pymdr.line.curves import ElasticLine, Line
from pymdr.line.foundation import DiskStates, disk_states, states_at_depth
from pymdr.line.layered import LayeredLine
from pymdr.line.lines import line_of
from pymdr.mapping.abel import Curve
from pymdr.mapping.equivalent import gap_function
from pymdr.numerics.panels import Place
from pymdr.problem.contact import Contact
from pymdr.units import FloatArray

SURFACE_FIELDS = NORMAL_FIELDS
LINE_FIELDS = ("equivalent_profile", "spring_force")


@dataclass(frozen=True)
class Cohesion:
    """A ring of constant tension around the contact, one entry per step."""

    radius: FloatArray
    """c in m."""
    strength: float
    """Cohesive stress in Pa."""


@dataclass(frozen=True)
class Surface:
    """The line of a contact with the states of every step."""

    line: Line
    gap_function: Curve
    states: DiskStates
    cohesion: Cohesion | None = None
    """The cohesive zone around the contact, if any."""

    @property
    def springs(self) -> ElasticLine:
        """The line of half-spaces, which all laws except adhesion of short range need."""
        assert isinstance(self.line, ElasticLine)
        return self.line

    def default_radii(self, step: int) -> FloatArray:
        """A grid from 0 to twice the contact radius and beyond a cohesive zone, graded to their edges."""
        a = float(self.states.contact_radius[step])
        if a <= 0.0:
            a = float(np.nanmax(self.states.contact_radius, initial=0.0)) or 1.0
        inner = a * np.sin(np.linspace(0.0, math.pi / 2.0, 101))
        c = a if self.cohesion is None else max(float(self.cohesion.radius[step]), a)
        top = min(max(2.0 * a, 1.2 * c), self._known())
        outer = a + (top - a) * np.linspace(0.0, 1.0, 61)[1:] ** 2
        edge = c * np.array([1.0 - 1e-9, 1.0 + 1e-9]) if a < c < top else np.empty(0)
        return np.unique(np.concatenate([inner, outer[outer > a], edge]))

    def marks(self, step: int) -> tuple[float, ...]:
        """Radii in m in the contact at which its pressure may have a kink."""
        return self.line.equivalent.kinks(float(self.states.contact_radius[step]))

    @property
    def revolves(self) -> bool:
        """Nothing depends on the direction."""
        return True

    def loads(self, step: int) -> Loads:
        """The normal load on the line."""
        a = float(self.states.contact_radius[step])
        zone, strength = 0.0, 0.0
        if self.cohesion is not None and a < self.line.equivalent.edge:
            zone, strength = float(self.cohesion.radius[step]), self.cohesion.strength
        excess = float(self.states.edge_excess[step])
        place, springs = self.states.place.take(step), self.line
        if isinstance(springs, LayeredLine):
            if not a > 0.0:
                return Loads(LineLoad((), a, 0.0, a, 0.0))
            springs, excess, _ = springs.carried(place, excess)
        assert isinstance(springs, ElasticLine)
        return Loads(line_load(springs, place, excess, zone=zone, strength=strength))

    def _known(self) -> float:
        equivalent = self.line.equivalent
        return equivalent.max_radius if equivalent.edge == math.inf else math.inf

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Values of a field at radii (or positions on the line) in one step."""
        place = self.states.place.take(step)
        a = float(place.x)
        d = float(self.states.indentation[step])
        excess = float(self.states.edge_excess[step])
        if math.isnan(a):
            return np.full(position.shape, math.nan)
        # a punch in contact up to its sharp edge has no cohesive zone
        if self.cohesion is not None and self.cohesion.radius[step] > 0.0 and a < self.line.equivalent.edge:
            return self._with_cohesion(name, position, d, a, self.cohesion, step)
        if name == "pressure":
            return fields.pressure(self.line, place, excess, position)
        if name == "normal_displacement":
            return fields.normal_displacement(self.line, self.gap_function, d, place, excess, position)
        if name == "gap":
            return fields.gap(self.line, self.gap_function, d, place, excess, position)
        if name == "spring_force" and a > 0.0:
            springs, pressed, _ = self.line.carried(place, excess)
            if springs is not self.line:
                return _line_load(springs, a, pressed, position)
        return self._on_the_line(name, position, d, a)

    def _on_the_line(self, name: str, position: FloatArray, d: float, a: float) -> FloatArray:
        """Values of a field of the line at positions in m."""
        x, equivalent = np.abs(position), self.line.equivalent
        if name == "equivalent_profile":
            return np.where(x > equivalent.edge, math.inf, equivalent.g(np.minimum(x, equivalent.edge)))
        if name == "spring_force":
            force = np.zeros(x.shape)
            # the profile outside the contact may not be mapped yet
            inside = _inside(x, a)
            pressed = d - equivalent.g(np.minimum(x[inside], equivalent.edge))
            with np.errstate(divide="ignore", invalid="ignore"):
                loads = self.line.modulus * x[inside] ** self.line.exponent * pressed
            # springs at x = 0 are infinitely stiff for k < 0, and carry nothing where they are not pressed
            force[inside] = np.where(pressed != 0.0, loads, 0.0)
            return force
        raise QuantityError(f"no field {name!r}; fields are {', '.join((*SURFACE_FIELDS, *LINE_FIELDS))}")

    def _with_cohesion(
        self, name: str, position: FloatArray, d: float, a: float, cohesion: Cohesion, step: int
    ) -> FloatArray:
        c, strength = float(cohesion.radius[step]), cohesion.strength
        if name == "pressure":
            return cohesive_pressure(self.springs, strength, a, c, position)
        if name in ("normal_displacement", "gap"):
            u = cohesive_displacement(self.springs, self.gap_function, strength, d, a, c, position)
            if name == "normal_displacement":
                return u
            return np.where(_inside(position, a), 0.0, self.gap_function(position) - d + u)
        force = self._on_the_line(name, position, d, a)
        if name == "spring_force":
            pulled = self.line.modulus * cohesive_spring_shift(self.springs, strength, c, position)
            force = np.where(_inside(position, a), force, pulled)
        return force

    def edge_amplitude(self, step: int) -> float:
        """Amplitude of the pressure singularity at the edge in Pa m^0.5."""
        a, w = self.states.contact_radius[step], self.states.edge_excess[step]
        return float(fields.edge_amplitude(self.line, a, w))


def _inside(position: FloatArray, a: float) -> np.ndarray:
    """Where the bodies touch; nowhere if a is 0."""
    return (np.abs(position) <= a) & (a > 0.0)


def _line_load(springs: ElasticLine, a: float, excess: float, position: FloatArray) -> FloatArray:
    """The load per length in N/m of a contact on its equivalent springs."""
    x = np.minimum(np.abs(position), a)
    depth = springs.depth(np.array([a]))[0] + excess
    return np.where(np.abs(position) <= a, springs.modulus * (depth - springs.depth(x)), 0.0)


def surface_of(
    contact: Contact,
    indentation: FloatArray,
    contact_radius: FloatArray,
    cohesive_radius: FloatArray | None = None,
) -> Surface:
    """
    The surface of a contact in given states.

    Parameters
    ----------
    indentation, contact_radius : ndarray
        d and a of every step in m.
    cohesive_radius : ndarray, optional
        c of every step in m, for contacts with a cohesive zone.
    """
    line = line_of(contact)
    states = disk_states(line, indentation, contact_radius)
    if contact.adhesion is None:
        # next to a breakpoint the indentation determines the radius to more digits
        exact = states_at_depth(line, indentation)
        with np.errstate(invalid="ignore"):
            same = np.abs(exact.contact_radius - contact_radius) <= 1e-9 * contact_radius
        place = Place(*(np.where(same, new, old) for new, old in zip(exact.place, states.place, strict=True)))
        states = replace(states, place=place)
        return Surface(line, gap_function(contact.profile, line.equivalent), states)
    if contact.adhesion.has_hysteresis or contact.friction is not None:
        # the edge may rest between both works, and shear takes a part of the work
        rows = _against_edge(line, indentation, contact_radius, ~(contact_radius > 0.0))
        states = replace(states, edge_excess=rows)
        return Surface(line, gap_function(contact.profile, line.equivalent), states)
    theory = theory_of(contact.adhesion)
    # the springs at the edge are stretched, except at a sharp edge, where they may be pressed
    stretched = contact_radius < line.equivalent.edge
    opening = theory.opening(contact.adhesion, line, np.where(stretched, contact_radius, 0.0))
    at_edge = _against_edge(line, indentation, contact_radius, stretched)
    states = replace(states, edge_excess=np.where(stretched, -opening, at_edge))
    stress = contact.adhesion.cohesive_stress
    cohesion = None if cohesive_radius is None or stress is None else Cohesion(cohesive_radius, stress)
    return Surface(line, gap_function(contact.profile, line.equivalent), states, cohesion)


def _against_edge(line: Line, d: FloatArray, a: FloatArray, stretched: np.ndarray) -> FloatArray:
    """Depth in m in excess of that of a smooth edge; 0 in rows with a stretched edge."""
    excess = np.zeros(d.shape)
    excess[~stretched] = d[~stretched] - line.depth(a[~stretched])
    return excess
