"""Contacts of bodies with memory and friction that are moved step by step along a line."""

from __future__ import annotations

import math
from typing import Any, Self

import numpy as np

from pymdr.line.memory.modes import active_springs, modes_of, unpacked
from pymdr.line.memory.moved import RelaxingContacts
from pymdr.line.memory.tangential import row_data, unsheared
from pymdr.line.moved import BEFORE, NOW, OnNormal, beyond
from pymdr.mapping.relaxation import Relaxation
from pymdr.problem.values import LARGEST
from pymdr.units import FloatArray


class ShearedContacts(OnNormal):
    """
    Contacts whose springs with memory have tangential partners, which stick or slip.

    What they remember: that of the normal contact, (n, 2, springs, columns) tangential springs, and (n, 2, columns) rows of their
    kernels.

    Parameters
    ----------
    normal : RelaxingContacts
        The same contacts without friction.
    relaxation : Relaxation
        G*(t).
    friction : float
        mu, from 0 to inf.
    division : tuple
        By how much loads may deviate from straight lines within a part of a step, of the strength of the contact; and into how
        many parts each of these is divided.
    """

    normal: RelaxingContacts

    def __init__(
        self, normal: RelaxingContacts, relaxation: Relaxation, friction: float, division: tuple[float, int]
    ) -> None:
        from pymdr.line.memory import kernels as steps
        from pymdr.line.memory import tangential_kernels as kernels

        self.normal, self.relaxation, self.division = normal, relaxation, division
        self._at = kernels
        springs, modes, state = normal.springs, modes_of(relaxation), unsheared()
        size = springs.position.size
        first = unpacked(state.deflection, state.branches, state.free, size, relaxation, modes)
        body = steps.body_of(relaxation, modes)
        self._run = kernels.shear_of(steps.table_of(springs), float(friction), body)
        self._scratch = first.copy(), first.copy()
        start = (first, np.zeros(kernels.COLUMNS))
        self._own = tuple(np.tile(one, (normal.count, 2, *([1] * one.ndim))) for one in start)

    def copied(self) -> Self:
        """The same contacts, which move on their own."""
        other = super().copied()
        other._scratch = self._scratch[0].copy(), self._scratch[1].copy()
        return other

    def advance(self, depth: float, shift: Any, duration: Any) -> tuple[float, float]:
        """Go with one contact straight to an indentation and a shift in m within a duration in s; F_N and F_x in N."""
        place = _finite(float(shift))
        (lasting,) = self.normal.durations([depth], duration)
        return self._step(0, depth, place, lasting)

    def advance_all(self, depth: FloatArray, shift: Any, duration: Any) -> tuple[FloatArray, FloatArray]:
        """The same with all contacts."""
        shifts = [_finite(each) for each in np.broadcast_to(shift, depth.shape).tolist()]
        depths = depth.tolist()
        moves = zip(range(depth.size), depths, shifts, self.normal.durations(depths, duration), strict=True)
        normal, tangential = np.transpose([self._step(*move) for move in moves])
        return normal, tangential

    def _step(self, i: int, depth: float, shift: float, duration: float) -> tuple[float, float]:
        at, springs, row = self._at, self._own[0][i], self._own[1][i]
        for array in (springs, row):
            array[BEFORE] = array[NOW]
        here, normal = float(row[NOW, at.SHIFT]), 0.0
        for fraction, passage in self.normal.step_in_parts(i, depth, duration, self.division):
            rows = np.zeros((fraction.size, row.shape[1]))
            for scratch in self._scratch:
                scratch[:] = springs[NOW]
            self._run.own[:] = 0.0  # of the steps and contacts before
            at.shear(
                self._run,
                at.Pressed(row_data(self.normal.curve, passage, self.normal.relaxation), passage.notes),
                shift - (shift - here) * (1.0 - fraction),
                (False, 0.0),
                (float(row[NOW, at.SHIFT]), active_springs(springs[NOW])),
                (springs[NOW], *self._scratch),
                rows,
            )
            for column in (at.DISSIPATED, at.SLIP, at.WORK):
                rows[-1, column] = row[NOW, column] + rows[:, column].sum()
            row[NOW], normal = rows[-1], float(passage.force[-1])
        return normal, float(row[NOW, at.FORCE])

    @property
    def shift(self) -> FloatArray:
        """Shifts in m."""
        return self._now(self._at.SHIFT)

    @property
    def tangential_force(self) -> FloatArray:
        """F_x in N."""
        return self._now(self._at.FORCE)

    @property
    def stick_radius(self) -> FloatArray:
        """In m; the contact radius where all springs stick."""
        return np.asarray(np.minimum(self._now(self._at.STICK), self.contact_radius))

    @property
    def tangential_stiffness(self) -> FloatArray:
        """Stiffness of a sudden step in N/m of the springs that stick, of the moduli that have not relaxed; inf where a dashpot resists."""
        per_modulus = self.normal.curve.stiffness(self.stick_radius)
        if self.relaxation.viscosity > 0.0:
            return np.where(per_modulus > 0.0, math.inf, 0.0)
        return np.asarray(self.relaxation.glassy * per_modulus)

    @property
    def stored_tangential_energy(self) -> FloatArray:
        """Energy in J of all tangential springs."""
        return self._now(self._at.STORED)

    @property
    def dissipated_energy(self) -> FloatArray:
        """Energy in J of all dashpots and of slip so far."""
        dissipated = self._now(self._at.DISSIPATED) + self._now(self._at.SLIP)
        return np.asarray(self.normal.dissipated_energy + dissipated)

    def _now(self, column: int) -> FloatArray:
        return np.asarray(self._own[1][:, NOW, column])


def _finite(shift: float) -> float:
    if not abs(shift) <= LARGEST:
        raise beyond(f"shift = {shift:g} m")
    return shift
