"""Contacts of bodies with memory that are moved step by step."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from pymdr.errors import ConvergenceError, PathError
from pymdr.line.curves import Curve
from pymdr.line.memory.dividing import Parts, divided_rows, elastic_force, mean_moduli
from pymdr.line.memory.histories import WATCHED, Passage, contact_radii, prepared_run, virgin
from pymdr.line.memory.modes import modes_of
from pymdr.line.memory.springs import springs_to
from pymdr.line.moved import BEFORE, NOW, Moved, WithoutAdhesion, WithoutShift, durations_of
from pymdr.mapping.relaxation import Relaxation
from pymdr.units import FloatArray, metres

if TYPE_CHECKING:
    from pymdr.line.memory.row_kernels import Run
    from pymdr.line.memory.steps import Workspace


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

    body: tuple[tuple[Run, Any, bool], Workspace]
    """The springs, and work space of every contact, as compiled steps read them."""

    def __init__(
        self, curve: Curve, relaxation: Relaxation, deepest: float, springs: int, count: int
    ) -> None:
        from pymdr.line.memory import kernels, row_kernels, steps

        self.curve, self.relaxation, self.springs = curve, relaxation, springs_to(curve, deepest, springs)
        self._rigid = relaxation.instantly_rigid or relaxation.viscosity > 0.0
        self._at, self._kernels, self._steps = kernels, row_kernels, steps
        self._run, self._meet, start, first = prepared_run(
            self.springs, relaxation, modes_of(relaxation), virgin(), math.inf, 0.0
        )
        self.body = (self._run, self._meet, self._rigid), steps.workspace_of(self._run, first, count)
        # springs of a flat profile have no height
        self._size = max(deepest, float(self.springs.height[-1]))
        self._elastic = elastic_force(curve, self._size)
        row = np.zeros(kernels.COLUMNS)
        row[kernels.LAST] = -1.0
        self.arrays = tuple(np.tile(one, (count, 2, *([1] * one.ndim))) for one in (first, start, row))

    def advance(self, depth: float, shift: Any, duration: Any) -> tuple[float, float]:
        """Go with one contact straight to an indentation in m within a duration in s; F_N in N, and 0."""
        (lasting,) = self.durations([depth], duration)
        return self._step(0, depth, lasting), 0.0

    def advance_all(self, depth: FloatArray, shift: Any, duration: Any) -> tuple[FloatArray, FloatArray]:
        """The same with all contacts."""
        depths = depth.tolist()
        moves = enumerate(zip(depths, self.durations(depths, duration), strict=True))
        return np.array([self._step(i, d, t) for i, (d, t) in moves]), np.zeros(depth.shape)

    def durations(self, depths: list[float], duration: Any) -> list[float]:
        """Durations in s of steps to indentations in m, all of which can be taken."""
        lasting = durations_of(len(depths), duration)
        if self._rigid and 0.0 in lasting:
            for depth, here, lasts in zip(depths, self.indentation.tolist(), lasting, strict=True):
                if lasts == 0.0 and here != depth and max(here, depth) > 0.0:
                    raise PathError(
                        f"indentation = {metres(depth)} in zero time, for which this rheology needs an infinite force; "
                        "give the step a duration"
                    )
        return lasting

    def _step(self, i: int, depth: float, duration: float) -> float:
        """Go with contact i straight to an indentation in m within a duration in s; F_N in N."""
        ending, force = self._steps.step(*self.body, self.arrays, i, depth, duration)
        if ending != self._steps.COMPLETE:
            raise self._ended(depth)
        return float(force)

    @staticmethod
    def _ended(depth: float) -> ConvergenceError:
        return ConvergenceError(f"no springs are known at {metres(depth)}")

    def step_in_parts(
        self, i: int, depth: float, duration: float, division: tuple[float, int]
    ) -> Iterator[tuple[FloatArray, Passage]]:
        """
        The same in parts on which the loads of all springs are straight; yields their ends as shares of the step, and their loads.

        `division` are the tolerance, of the strength of the contact, and the number of parts into which each part is divided once more.
        """
        self._keep(i)
        tolerance, times = division
        springs, start, _ = (array[i, NOW] for array in self.arrays)
        strength = float(mean_moduli(self.relaxation, np.array([duration]))[0]) * self._elastic
        course = np.array([[duration], [depth], [strength]])
        within = self._kernels.Division(tolerance * self._size, tolerance)
        parts = divided_rows(self._run, self._meet, (start, springs), course, within)
        assert isinstance(parts, Parts), "an indentation within the springs is always met"
        parts = parts.halved(times)
        time, places = parts.along(course[0], start[0]), parts.along(course[1], start[1])
        for first in range(0, time.size, WATCHED):
            some = slice(first, first + WATCHED)
            t, d = np.append(start[0], time[some]), np.append(start[1], places[some])
            notes = np.zeros((self._kernels.NOTES, t.size, springs.shape[0]))
            rows = self._follow(i, np.stack([t[1:], d[1:], np.zeros(t.size - 1)]), notes)
            radii = contact_radii(self.curve, self.springs, rows)
            yield parts.fraction[some], Passage(self.springs, t, d, rows[:, self._at.FORCE], radii, notes)

    def _keep(self, i: int) -> None:
        """Keep the state before a step. Times count from there: its duration may be short against the whole."""
        self.arrays[1][i, NOW, 0] = 0.0
        for array in self.arrays:
            array[i, BEFORE] = array[i, NOW]

    def _follow(self, i: int, course: FloatArray, notes: FloatArray) -> FloatArray:
        """Rows of a step; their work and dissipation are those so far."""
        springs, start, row = (array[i, NOW] for array in self.arrays)
        scratch = self.body[1].springs[i]
        scratch[:] = springs
        rows = np.zeros((course.shape[1], row.size))
        done = self._kernels.follow(self._run, course, start, (springs, scratch), rows, notes, self._meet)
        if done != course.shape[1]:
            raise self._ended(float(course[1, -1]))
        for column in (self._at.WORK, self._at.DISSIPATED):
            rows[:, column] += row[column]
        row[:] = rows[-1]
        return rows

    def copied(self) -> Self:
        """The same contacts, which move on their own."""
        other = super().copied()
        same, space = self.body
        other.body = same, type(space)(*(array.copy() for array in space))
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
        return contact_radii(self.curve, self.springs, self.arrays[2][:, NOW])

    @property
    def normal_stiffness(self) -> FloatArray:
        """Stiffness of a sudden step in N/m, of the moduli that have not relaxed; inf in contact where a dashpot resists."""
        per_modulus = self.curve.stiffness(self.contact_radius)
        if self._rigid:
            return np.where(per_modulus > 0.0, math.inf, 0.0)
        return np.asarray(self.relaxation.glassy * per_modulus)

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
