"""What adhesion asks of the equivalent profile, and the states that it gives back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from pymdr.mapping.series import Position, rounded
from pymdr.units import FloatArray


class Outline(Protocol):
    """How far a line goes, and where it is not smooth."""

    @property
    def edge(self) -> float:
        """Radius of a sharp outer edge [m]."""

    @property
    def reach(self) -> float:
        """Largest known x [m]."""

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Radii of kinks [m]."""


class EquivalentLine(Outline, Protocol):
    """The equivalent profile g(x) of step 1, as far as a cohesive zone needs it.

    All methods take radii x >= 0 in m (any shape) and return arrays of that shape.
    """

    def g(self, x: Any) -> FloatArray:
        """Return the equivalent profile g(x) [m]; at the edge its value from inside."""

    def slope(self, x: Any) -> FloatArray:
        """Return g'(x), dimensionless."""

    def moment(self, x: Any) -> FloatArray:
        """Return int_0^x t g'(t) dt [m^2], half the force without adhesion over E*."""

    def squared(self, x: Any) -> FloatArray:
        """Return int_0^x (g(x) - g(t))^2 dt [m^3], the energy without adhesion over E*."""


@dataclass(frozen=True)
class States:
    """Equilibrium states along an adhesive curve, each field an array of the shape of the parameter.

    Attributes
    ----------
    contact_radius, cohesive_radius : ndarray
        Radius a of contact and c of the cohesive zone [m]; c = a where there is no such zone.
    indentation : ndarray
        Approach d [m].
    normal_force : ndarray
        Force F [N], negative when it pulls.
    """

    contact_radius: FloatArray
    cohesive_radius: FloatArray
    indentation: FloatArray
    normal_force: FloatArray


def as_floats(values: ArrayLike) -> FloatArray:
    """Return `values` as an array of doubles."""
    return np.asarray(values, dtype=np.float64)


def own_edge(line: Outline) -> float:
    """Return the radius of the sharp edge [m], or ``inf`` when the known profile does not reach it."""
    return float(line.edge) if line.edge <= line.reach else np.inf


def inner_knots(line: Outline) -> tuple[float, ...]:
    """Return the breakpoints strictly inside the known profile and its edge [m], ascending."""
    end = min(line.edge, line.reach)
    return tuple(sorted({float(x) for x in line.breakpoints if 0.0 < x < end}))


def stretched_energy(
    line: EquivalentLine, modulus: float, radius: Position, opening: FloatArray
) -> FloatArray:
    """Return E* int_0^a (g(a) - opening - g)² dx [J], the energy of the springs inside the contact.

    Expanded as E* [squared(a) - 2 opening moment(a) + opening² a], whose terms are of one size.
    """
    terms = line.squared(radius) - 2.0 * opening * line.moment(radius) + opening**2 * rounded(radius)
    return modulus * terms
