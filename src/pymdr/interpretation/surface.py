"""Fields of a whole history on demand: which formula a field name stands for, and where it is read."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymdr.errors import QuantityError
from pymdr.interpretation import fields
from pymdr.line.foundation import DiskStates, ElasticLine, disk_states, line_upto_depth
from pymdr.mapping.abel import Curve
from pymdr.mapping.equivalent import equivalent_profile, gap_function
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.contact import Contact
from pymdr.units import FloatArray

SURFACE_FIELDS = ("pressure", "normal_displacement", "gap")
LINE_FIELDS = ("equivalent_profile", "spring_force")


@dataclass(frozen=True)
class Surface:
    """The line of a contact with the states of every step."""

    line: ElasticLine
    gap_function: Curve
    states: DiskStates

    def default_radii(self, step: int) -> FloatArray:
        """A grid from 0 to twice the contact radius, graded to the edge of the contact."""
        a = float(self.states.contact_radius[step])
        if a <= 0.0:
            a = float(np.max(self.states.contact_radius, initial=0.0)) or 1.0
        inner = a * np.sin(np.linspace(0.0, math.pi / 2.0, 101))
        top = min(2.0 * a, self._known())
        outer = a + (top - a) * np.linspace(0.0, 1.0, 61)[1:] ** 2
        return np.concatenate([inner, outer[outer > a]])

    def _known(self) -> float:
        equivalent = self.line.equivalent
        return equivalent.reach if equivalent.edge == math.inf else math.inf

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Values of a field at radii (or positions on the line) in one step."""
        a = float(self.states.contact_radius[step])
        d = float(self.states.indentation[step])
        excess = float(self.states.edge_excess[step])
        if math.isnan(a):
            return np.full(position.shape, math.nan)
        if name == "pressure":
            return fields.pressure(self.line, a, excess, position)
        if name == "normal_displacement":
            return fields.normal_displacement(self.line, self.gap_function, d, a, position)
        if name == "gap":
            return fields.gap(self.line, self.gap_function, d, a, position)
        x = np.abs(position)
        g = np.where(
            x > self.line.equivalent.edge,
            math.inf,
            self.line.equivalent.g(np.minimum(x, self.line.equivalent.edge)),
        )
        if name == "equivalent_profile":
            return g
        if name == "spring_force":
            return np.where(x <= a, self.line.modulus * np.maximum(d - np.where(x <= a, g, d), 0.0), 0.0)
        raise QuantityError(f"no field {name!r}; fields are {', '.join((*SURFACE_FIELDS, *LINE_FIELDS))}")

    def edge_amplitude(self, step: int) -> float:
        """Amplitude of the pressure singularity at the edge in Pa m^0.5."""
        a, w = self.states.contact_radius[step], self.states.edge_excess[step]
        return float(fields.edge_amplitude(self.line.modulus, a, w))


def surface_of(contact: Contact, indentation: FloatArray, contact_radius: FloatArray) -> Surface:
    """
    The surface of a contact in given states.

    Parameters
    ----------
    contact : Contact
    indentation, contact_radius : ndarray
        d and a of every step in m.

    Returns
    -------
    Surface
    """
    moduli = effective_moduli(contact.body, contact.counterbody)
    line = ElasticLine(equivalent_profile(contact.profile), moduli.normal)
    deepest = float(np.max(indentation[np.isfinite(indentation)], initial=0.0))
    line = line_upto_depth(line, deepest) if deepest > 0.0 else line
    states = disk_states(line, indentation, contact_radius)
    return Surface(line, gap_function(contact.profile, line.equivalent), states)
