"""Contacts of bodies with memory that are moved step by step."""

from __future__ import annotations

import math
from typing import Any, Self

import numpy as np

from pymdr.errors import ConvergenceError, PathError
from pymdr.line.curves import Curve
from pymdr.line.memory.histories import contact_radii, prepared_run, virgin
from pymdr.line.memory.modes import modes_of
from pymdr.line.memory.springs import springs_to
from pymdr.line.moved import BEFORE, NOW, Moved, WithoutAdhesion, WithoutShift
from pymdr.mapping.relaxation import Relaxation
from pymdr.units import FloatArray, metres, shown


class RelaxingContacts(WithoutShift, WithoutAdhesion, Moved):
    """
    Contacts of one pair of bodies on springs with memory, each exact over a step on which the indentation is straight in time.

    What they remember: (n, 2, springs, columns) springs, (n, 2, 4) starts and (n, 2, columns) rows of the kernels of histories.

    Parameters
    ----------
    curve : Curve
        Per unit modulus.
    relaxation : Relaxation
        E*(t).
    deepest : float
        The largest indentation in m.
    springs : int
        Springs in the largest contact.
    count : int
        Number of contacts.
    """

    def __init__(
        self, curve: Curve, relaxation: Relaxation, deepest: float, springs: int, count: int
    ) -> None:
        from pymdr.line.memory import kernels, row_kernels

        self._curve, self._relaxation, self._springs = curve, relaxation, springs_to(curve, deepest, springs)
        self._rigid = relaxation.instantly_rigid or relaxation.viscosity > 0.0
        self._at, self._kernels = kernels, row_kernels
        self._run, start, first = prepared_run(
            self._springs, relaxation, modes_of(relaxation), virgin(), math.inf, 0.0
        )
        self._scratch, self._notes = first.copy(), np.zeros((row_kernels.NOTES, 0, first.shape[0]))
        row = np.zeros(kernels.COLUMNS)
        row[kernels.LAST] = -1.0
        self.arrays = tuple(np.tile(one, (count, 2, *([1] * one.ndim))) for one in (first, start, row))

    def advance(self, depth: float, shift: Any, duration: Any) -> tuple[float, float]:
        """Go with one contact straight to an indentation in m within a duration in s; F_N in N, and 0."""
        return self._step(0, depth, self._checked(duration)), 0.0

    def advance_all(self, depth: FloatArray, shift: Any, duration: Any) -> tuple[FloatArray, FloatArray]:
        """The same with all contacts."""
        lasts = np.broadcast_to(np.asarray([self._checked(each) for each in np.ravel(duration)]), depth.shape)
        moves = enumerate(zip(depth.tolist(), lasts.tolist(), strict=True))
        return np.array([self._step(i, d, t) for i, (d, t) in moves]), np.zeros(depth.shape)

    def _checked(self, duration: Any) -> float:
        if duration is None or not 0.0 <= float(duration) < math.inf:
            raise PathError(
                f"Stepper.advance: duration = {shown(duration)}; a body with memory needs the finite duration of the step in s"
            )
        return float(duration)

    def _step(self, i: int, depth: float, duration: float) -> float:
        springs, start, row = (array[i] for array in self.arrays)
        here, at = float(start[NOW, 1]), self._at
        if duration == 0.0 and self._rigid and here != depth and max(here, depth) > 0.0:
            raise PathError(
                f"Stepper.advance: indentation = {metres(depth)} in zero time, for which this rheology needs an infinite force; give the "
                "step a duration"
            )
        for array in (springs, start, row):
            array[BEFORE] = array[NOW]
        self._scratch[:] = springs[NOW]
        course = np.array([[start[NOW, 0] + duration], [depth], [0.0]])
        rows = row[NOW][None].copy()
        done = self._kernels.follow(
            self._run, course, start[NOW], (springs[NOW], self._scratch), rows, self._notes, None
        )
        if done != 1:
            raise ConvergenceError(f"Stepper.advance: no springs are known at {metres(depth)}")
        # times count from the last step, whose durations may be short against the whole
        start[NOW, 0] = 0.0
        for column in (at.WORK, at.DISSIPATED):
            rows[0, column] += row[BEFORE, column]
        row[NOW] = rows[0]
        return float(rows[0, at.FORCE])

    def copied(self) -> Self:
        """The same contacts, which move on their own."""
        other = super().copied()
        other._scratch = self._scratch.copy()
        return other

    @property
    def indentation(self) -> FloatArray:
        """Indentations in m."""
        return np.asarray(self.arrays[1][:, NOW, 1])

    @property
    def normal_force(self) -> FloatArray:
        """F_N in N."""
        return self._now(self._at.FORCE)

    @property
    def contact_radius(self) -> FloatArray:
        """In m; 0 without contact."""
        return contact_radii(self._curve, self._springs, self.arrays[2][:, NOW])

    @property
    def normal_stiffness(self) -> FloatArray:
        """Stiffness of a sudden step in N/m, of the moduli that have not relaxed; inf in contact where a dashpot resists."""
        per_modulus = self._curve.stiffness(self.contact_radius)
        if self._rigid:
            return np.where(per_modulus > 0.0, math.inf, 0.0)
        return np.asarray(self._relaxation.glassy * per_modulus)

    @property
    def elastic_energy(self) -> FloatArray:
        """Energy in J of all springs."""
        return self._now(self._at.STORED)

    @property
    def dissipated_energy(self) -> FloatArray:
        """Energy in J of all dashpots so far."""
        return self._now(self._at.DISSIPATED)

    def _now(self, column: int) -> FloatArray:
        return np.asarray(self.arrays[2][:, NOW, column])
