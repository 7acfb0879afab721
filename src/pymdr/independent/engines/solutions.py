"""What all engines begin with and are held to."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.independent.engines.protocol import Pressing
from pymdr.units import FloatArray

_ALLOWED = 2.0
"""Tolerances by which a solution may miss, since packages measure errors in their own ways."""
_MOST_STEPS = 40
_FIRST_TOLERANCE = 1e-2


def first_pressure(below: FloatArray, indentation: float | None) -> FloatArray:
    """
    A pressure to begin with, of any size: 1 where the undeformed bodies overlap, or on the higher tenth.

    Parameters
    ----------
    below : ndarray
        Distances of the pixels from the highest one.
    indentation : float or None

    Returns
    -------
    ndarray
    """
    near = below < (np.quantile(below, 0.1) if indentation is None else indentation)
    return np.where(near | (below == 0.0), 1.0, 0.0)


def worst_miss(found: Pressing) -> float:
    """Largest gap inside or penetration outside over the indentation; inf where something pulls, or nothing touches."""
    touching = found.pressure > 0.0
    if not touching.any() or not float(np.min(found.pressure)) >= 0.0 or not found.indentation > 0.0:
        return math.inf
    inside = float(np.max(np.abs(found.gap[touching])))
    return max(inside, -float(np.min(found.gap))) / found.indentation


def is_solved(found: Pressing, tolerance: float) -> bool:
    """Whether it is a contact: no gaps inside, no penetration outside, no pulls."""
    # what is no number is no contact either
    return worst_miss(found) <= _ALLOWED * tolerance


def refuse_unsolved(package: str, found: Pressing, tolerance: float) -> None:
    """
    Refuse what is no contact: gaps inside, penetration outside, or pulls.

    Raises
    ------
    ConvergenceError
    """
    if not is_solved(found, tolerance):
        raise ConvergenceError(
            f"{package} did not converge in {found.iterations} iterations: gaps and penetrations of {worst_miss(found):.2g} of the indentation, "
            f"{tolerance:.2g} are asked; take a smoother surface, or another engine"
        )


def by_force(
    press: Callable[[float, float], Pressing], indentation: float, first: float, tolerance: float
) -> Pressing:
    """
    The solution at an indentation by an engine that knows forces.

    Parameters
    ----------
    press : callable
        The solution at a force, to a tolerance.
    indentation : float
    first : float
        A force to begin with.
    tolerance : float
        Of the indentation.

    Returns
    -------
    Pressing

    Raises
    ------
    ConvergenceError

    Notes
    -----
    Secants of log F over log d, which for powers are exact. A solution far from the indentation is solved to a part of
    its distance only; the last one to the tolerance.
    """
    force, slope, near = first, 1.5, _FIRST_TOLERANCE
    before: tuple[float, float] | None = None
    for _ in range(_MOST_STEPS):
        near = max(near, tolerance)
        found = press(force, near)
        off = math.log(indentation / found.indentation)
        if abs(off) <= tolerance and near == tolerance:
            return found
        near *= min(1.0, abs(off))
        if before is not None and before[1] != off:
            slope = min(max((math.log(force) - before[0]) / (before[1] - off), 0.2), 5.0)
        before = math.log(force), off
        force *= math.exp(slope * off)
    raise ConvergenceError(
        f"no force of an indentation of {indentation:g} was found: the last one is {force:g}, at {found.indentation:g}; give forces"
    )


class ByForces(ABC):
    """A half-space of a package that knows forces only: an indentation is found by some solutions."""

    area: float
    """Of a pixel."""

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
        """Press a rigid surface on the half-space, as :class:`~pymdr.independent.engines.protocol.HalfSpace` has it."""
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
            found = self.at_force(below, load, pressure, near)
            pressure = found.pressure
            return found

        return by_force(solve, indentation, guess, tolerance)
