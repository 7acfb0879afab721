"""The interface of the equivalent profile to adhesion, and the adhesive states."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from pymdr.units import FloatArray


class Outline(Protocol):
    """The ends of a line and its breakpoints."""

    @property
    def edge(self) -> float:
        """Radius of a sharp outer edge [m]."""

    @property
    def max_radius(self) -> float:
        """Largest known x [m]."""

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Radii of kinks [m]."""


class States(NamedTuple):
    """Equilibrium states along an adhesive curve, arrays of the shape of the parameter."""

    contact_radius: FloatArray
    """Radius a of contact [m]."""
    cohesive_radius: FloatArray
    """Radius c of the cohesive zone [m]; c = a where there is no such zone."""
    indentation: FloatArray
    """Approach d [m]."""
    normal_force: FloatArray
    """Force F [N], negative when it pulls."""


def own_edge(line: Outline) -> float:
    """Return the radius of the sharp edge [m], or ``inf`` when the known profile does not reach it."""
    return float(line.edge) if line.edge <= line.max_radius else np.inf


def inner_knots(line: Outline) -> tuple[float, ...]:
    """Return the breakpoints strictly inside the known profile and its edge [m], ascending."""
    end = min(line.edge, line.max_radius)
    return tuple(sorted({float(x) for x in line.breakpoints if 0.0 < x < end}))
