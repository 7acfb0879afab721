"""The interface of the equivalent profile to adhesion, and the adhesive states."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

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
    return float(line.edge) if line.edge <= line.max_radius else np.inf


def inner_knots(line: Outline) -> tuple[float, ...]:
    """Return the breakpoints strictly inside the known profile and its edge [m], ascending."""
    end = min(line.edge, line.max_radius)
    return tuple(sorted({float(x) for x in line.breakpoints if 0.0 < x < end}))
