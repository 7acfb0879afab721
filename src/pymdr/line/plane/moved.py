"""Contacts that are moved step by step in the plane."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pymdr.errors import PathError, ProblemError
from pymdr.line.moved import BEFORE, NOW, Moved, OnNormal, beyond
from pymdr.line.plane import layout as at
from pymdr.line.plane.springs import PlaneLaw, Springs
from pymdr.problem.values import LARGEST
from pymdr.units import FloatArray, shown

_AT_LIMIT = 1.0 - 1e-12
"""Length of a spring over its limit from which on it slips."""


class PlaneContacts(OnNormal):
    """
    Contacts of one body whose springs carry vectors; each spring advances exactly over a step.

    What they remember: that of the normal contact, (n, 2, 2, springs + 1) vectors, and (n, 2, 6) columns of
    :mod:`pymdr.line.plane.layout`.

    Parameters
    ----------
    springs : Springs
        Up to the largest contact radius.
    normal : Moved
        The same contacts without friction.
    """

    def __init__(self, law: PlaneLaw, springs: Springs, normal: Moved) -> None:
        from pymdr.line.plane import steps

        self._law, self._springs, self.normal = law, springs, normal
        self.slips = math.isfinite(law.friction)
        self._places = springs.place.copy()
        scales = np.array([2.0 * law.scale * law.modulus * springs.spacing, law.shift_scale])
        self.body = springs.label.copy(), scales
        self._steps: Any = steps
        count, size = normal.count, springs.label.size
        self._own = (np.zeros((count, 2, 2, size)), np.zeros((count, 2, at.WORK + 1)))

    def advance(self, depth: float, shift: Any, duration: Any) -> tuple[float, float, float]:
        """Go with one contact straight to an indentation and a shift (x, y) in m; F_N, F_x and F_y in N."""
        x, y = _pair(shift)
        x, y = float(x), float(y)
        if not (abs(x) <= LARGEST and abs(y) <= LARGEST):
            raise beyond(f"shift = ({x:g}, {y:g}) m")
        vectors, memory = self._own
        normal, _ = self.normal.advance(depth, 0.0, None)
        f_x, f_y = self._steps.step(*self.body, vectors[0], memory[0], (depth, x, y), self.slips)
        return normal, f_x, f_y

    def advance_all(
        self, depth: FloatArray, shift: Any, duration: Any
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The same with all contacts."""
        targets, forces = np.empty((3, self.count)), np.empty((2, self.count))
        targets[0] = depth
        targets[1], targets[2] = _pair(shift)
        known = (np.abs(targets) <= LARGEST).all(axis=0)
        if not known.all():
            i = int(np.argmin(known))
            raise beyond(f"shift = ({targets[1, i]:g}, {targets[2, i]:g}) m")
        normal, _ = self.normal.advance_all(depth, 0.0, None)
        given = *self.body, *self._own, targets, self.slips, forces
        self.threads.run(lambda some: self._steps.step_all(*given, some))
        return normal, forces[0], forces[1]

    def rotate(self, angle: Any) -> None:
        """Turn shift, force and springs of every contact by an angle in rad."""
        turn = np.broadcast_to(np.asarray(angle, dtype=float), (self.count,))
        if not np.isfinite(turn).all():
            raise PathError(f"angle = {shown(angle)}; finite values in rad are needed")
        matrix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        vectors, memory = self._own
        for array in self.arrays:
            array[:, BEFORE] = array[:, NOW]
        vectors[:, NOW] = np.einsum("ijn,njk->nik", matrix, vectors[:, NOW])
        for first in (at.AT_X, at.FORCE_X):
            pair = memory[:, NOW, first : first + 2]
            pair[:] = np.einsum("ijn,nj->ni", matrix, pair)

    @property
    def shift(self) -> FloatArray:
        """Shifts in m, shape (count, 2)."""
        return np.asarray(self._own[1][:, NOW, at.AT_X : at.AT_Y + 1])

    @property
    def tangential_force(self) -> FloatArray:
        """F_x and F_y in N, shape (count, 2)."""
        return np.asarray(self._own[1][:, NOW, at.FORCE_X : at.FORCE_Y + 1])

    @property
    def stick_radius(self) -> FloatArray:
        """Radius in m of the springs below their limit; without slip the contact radius, without friction 0."""
        radius = self.contact_radius.copy()
        if self._law.friction == 0.0:
            radius[:] = 0.0
        elif self.slips:
            self._steps.stick_borders(self.body[0], self._places, *self._own, radius)
        return radius

    @property
    def tangential_stiffness(self) -> FloatArray:
        """
        Tangent stiffness in N/m as the motion goes on, shape (count, 2, 2).

        A spring that sticks has the stiffness 2 G* dx in all directions, one that slips along its vector t that across it,
        2 G* dx (1 - t t / |t|^2).
        """
        vectors, limit = self._touching
        square = np.sum(vectors * vectors, axis=1)
        slides = np.logical_and(self.slips, np.sqrt(square) >= _AT_LIMIT * limit)
        with np.errstate(divide="ignore", invalid="ignore"):
            along = np.where(slides & (square > 0.0), 1.0 / square, 0.0)
        each = np.eye(2)[:, :, None] * (limit > 0.0)[:, None, None, :]
        each = each - np.einsum("nik,njk,nk->nijk", vectors, vectors, along)
        return np.asarray(self.body[1][at.PER_FORCE] / self.body[1][at.PER_SHIFT] * each.sum(axis=3))

    @property
    def stored_tangential_energy(self) -> FloatArray:
        """Energy in J stored by the shift."""
        vectors, _ = self._touching
        scale = 0.5 * self.body[1][at.PER_FORCE] * self.body[1][at.PER_SHIFT]
        return np.asarray(scale * np.sum(vectors * vectors, axis=(1, 2)))

    @property
    def dissipated_energy(self) -> FloatArray:
        """Slip work in J so far, without slip the energy released by separating springs."""
        return np.asarray(self._own[1][:, NOW, at.WORK])

    @property
    def _touching(self) -> tuple[FloatArray, FloatArray]:
        """Vectors of the springs that carry, (n, 2, springs), and their limits, (n, springs)."""
        vectors, memory = self._own
        limit = np.maximum(memory[:, NOW, at.DEPTH, None] - self.body[0][1:], 0.0)
        return vectors[:, NOW, :, 1:], limit


def _pair(shift: Any) -> Any:
    """Shifts along x and y."""
    try:
        x, y = (0.0, 0.0) if isinstance(shift, float) and shift == 0.0 else shift
    except (TypeError, ValueError):
        raise ProblemError(f"shift = {shown(shift)}; in the plane a pair (x, y) is needed") from None
    return x, y
