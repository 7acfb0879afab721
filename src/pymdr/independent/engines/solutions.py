"""Initial pressures and checks of all engines, and indentations by engines that prescribe forces."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.independent.engines.protocol import Pressing
from pymdr.units import FloatArray

_ALLOWED = 2.0
"""Accepted residual in units of the tolerance, because packages define errors differently."""
_MOST_STEPS = 40
_FIRST_TOLERANCE = 1e-2


def first_pressure(below: FloatArray, indentation: float | None) -> FloatArray:
    """
    An initial pressure of any size: 1 where the undeformed bodies overlap, or on the highest tenth.

    Parameters
    ----------
    below : ndarray
        Distances of the pixels from the highest one.
    """
    near = below < (np.quantile(below, 0.1) if indentation is None else indentation)
    return np.where(near | (below == 0.0), 1.0, 0.0)


def largest_residual(pressing: Pressing) -> float:
    """Largest gap inside or penetration outside over the indentation; inf under tension or without contact."""
    touching = pressing.pressure > 0.0
    if not touching.any() or not float(np.min(pressing.pressure)) >= 0.0 or not pressing.indentation > 0.0:
        return math.inf
    inside = float(np.max(np.abs(pressing.gap[touching])))
    return max(inside, -float(np.min(pressing.gap))) / pressing.indentation


def is_solved(pressing: Pressing, tolerance: float) -> bool:
    """Whether it is a contact without gaps inside, penetration outside, tension or nan."""
    return largest_residual(pressing) <= _ALLOWED * tolerance


def refuse_unsolved(package: str, pressing: Pressing, tolerance: float) -> None:
    """Refuse gaps inside the contact, penetration outside, or tension."""
    if not is_solved(pressing, tolerance):
        raise ConvergenceError(
            f"{package} did not converge in {pressing.iterations} iterations: gaps and penetrations are {largest_residual(pressing):.2g} of the indentation "
            f"(limit {tolerance:.2g}); use a smoother surface or another engine"
        )


def by_force(
    press: Callable[[float, float], Pressing], indentation: float, first: float, tolerance: float
) -> Pressing:
    """
    The solution at an indentation by an engine that prescribes forces.

    Parameters
    ----------
    press : callable
        The solution at a force, to a tolerance.

    Notes
    -----
    Secants of log F over log d, exact for powers. Intermediate solutions are solved only to a part of their distance from
    the indentation, the last one to the tolerance.
    """
    force, slope, near = first, 1.5, _FIRST_TOLERANCE
    before: tuple[float, float] | None = None
    for _ in range(_MOST_STEPS):
        near = max(near, tolerance)
        pressing = press(force, near)
        error = math.log(indentation / pressing.indentation)
        if abs(error) <= tolerance and near == tolerance:
            return pressing
        near *= min(1.0, abs(error))
        if before is not None and before[1] != error:
            slope = min(max((math.log(force) - before[0]) / (before[1] - error), 0.2), 5.0)
        before = math.log(force), error
        force *= math.exp(slope * error)
    raise ConvergenceError(
        f"the search for the force at an indentation of {indentation:g} did not converge (last value {force:g} at "
        f"{pressing.indentation:g}); prescribe forces"
    )


class ByForces(ABC):
    """A half-space of a package that prescribes forces only; an indentation takes several solutions."""

    area: float
    """Area of a pixel."""

    @abstractmethod
    def at_force(self, below: FloatArray, force: float, start: FloatArray, tolerance: float) -> Pressing:
        """The solution at a force, of pixels at distances from the highest one; `start` is a pressure of any size."""

    def press(
        self,
        heights: FloatArray,
        *,
        indentation: float | None = None,
        force: float | None = None,
        start: FloatArray | None = None,
        tolerance: float = 1e-6,
    ) -> Pressing:
        """Press a rigid surface on the half-space, as :class:`~pymdr.independent.engines.protocol.HalfSpace`."""
        below = np.max(heights) - heights
        first = first_pressure(below, indentation) if start is None else start
        if indentation is None:
            assert force is not None
            return self.at_force(below, force, first, tolerance)
        # stiffness of a disk of the same area
        guess = indentation * math.sqrt(self.area * np.count_nonzero(first))
        pressure = first

        def solve(load: float, near: float) -> Pressing:
            nonlocal pressure
            pressing = self.at_force(below, load, pressure, near)
            pressure = pressing.pressure
            return pressing

        return by_force(solve, indentation, guess, tolerance)
