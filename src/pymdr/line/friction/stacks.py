"""Memory stacks of contacts that are moved step by step."""

from __future__ import annotations

import math
from typing import NamedTuple, Self

import numpy as np

from pymdr.line.friction.curves import ElasticCurves
from pymdr.line.friction.driver import ENDINGS
from pymdr.line.friction.layout import (
    BEFORE,
    DEPTH,
    ENERGY_SCALE,
    FORCE_SCALE,
    NOW,
    SHIFT,
    SHIFT_SCALE,
    SLIP_WORK,
    STACK_FULL,
    TOP,
)
from pymdr.line.friction.state import Ending, FrictionState
from pymdr.units import FloatArray

_CAPACITY = 16
"""Vertices for which every stack has room at first."""


class StackArrays(NamedTuple):
    """All that the contacts remember."""

    vertices: np.ndarray
    """(n, 2, capacity) vertices of the anchor curves, now and before the last step."""
    memory: FloatArray
    """(n, 2, 6) columns of :mod:`pymdr.line.friction.layout`, now and before the last step."""

    def copied(self) -> StackArrays:
        """A copy."""
        return StackArrays(self.vertices.copy(), self.memory.copy())


class Stacks:
    """
    Contacts of one body, each with its stack, which grows with its history.

    Parameters
    ----------
    curves : ElasticCurves
        Of the body.
    start : FrictionState
        Bodies that have not touched, with the coefficient of friction and the ratio of the moduli.
    count : int
        Number of contacts.
    """

    arrays: StackArrays

    def __init__(self, curves: ElasticCurves, start: FrictionState, count: int) -> None:
        from pymdr.line.friction import kernels, steps

        scales = np.array([start.traction_scale, start.energy_scale, start.shift_scale])
        self._body = curves.rows, scales
        slips = math.isfinite(start.friction)
        self._step = steps.step if slips else steps.step_stuck
        self._step_all = steps.step_all if slips else steps.step_all_stuck
        vertices = np.zeros((count, 2, _CAPACITY), dtype=kernels.VERTEX)
        vertices["low"][:, :, 0], vertices["high"][:, :, 0] = -math.inf, math.inf
        self.arrays = StackArrays(vertices, np.zeros((count, 2, TOP + 1)))

    @property
    def count(self) -> int:
        """Number of contacts."""
        return int(self.arrays.memory.shape[0])

    def advance(self, depth: float, shift: float) -> tuple[Ending, float, float]:
        """Go with one contact straight to an indentation and a shift in m; the ending, and F_N and F_x in N."""
        (line, scales), (stacks, memory) = self._body, self.arrays
        code, normal, tangential = self._step(line, scales, stacks[0], memory[0], depth, shift)
        if code == STACK_FULL:
            self._grow()
            return self.advance(depth, shift)
        return ENDINGS[code], normal, tangential

    def advance_all(self, given: FloatArray) -> FloatArray:
        """Go with all contacts to finite indentations within the curves and shifts in m, shape (2, n); F_N and F_x in N alike."""
        forces, first = np.empty(given.shape), 0
        while first < self.count:
            code, first = self._step_all(*self._body, *self.arrays, given, forces, first)
            if code == STACK_FULL:
                self._grow()
        return forces

    def undo(self) -> None:
        """Give all contacts the state before the last step."""
        for array in self.arrays:
            array[:, NOW] = array[:, BEFORE]

    def copy(self) -> Self:
        """The same contacts, which move on their own."""
        other = object.__new__(type(self))
        other.__dict__ |= self.__dict__ | {"arrays": self.arrays.copied()}
        return other

    @property
    def indentation(self) -> FloatArray:
        """Indentations in m."""
        return self._now(DEPTH)

    @property
    def shift(self) -> FloatArray:
        """Shifts in m."""
        return np.asarray(self._now(SHIFT) * self._body[1][SHIFT_SCALE])

    @property
    def slip_work(self) -> FloatArray:
        """Slip work so far in J, without slip the energy released."""
        return np.asarray(self._now(SLIP_WORK) * self._body[1][ENERGY_SCALE])

    @property
    def normal_force(self) -> FloatArray:
        """F_N in N."""
        return self._last("force")

    @property
    def tangential_force(self) -> FloatArray:
        """F_x in N."""
        return np.asarray(self._last("pull") * self._body[1][FORCE_SCALE])

    @property
    def normal_energy(self) -> FloatArray:
        """Energy in J stored by the indentation."""
        return self._last("work")

    @property
    def tangential_energy(self) -> FloatArray:
        """Energy in J stored by the shift."""
        return np.asarray(np.maximum(self._last("energy"), 0.0) * self._body[1][ENERGY_SCALE])

    @property
    def contact_radius(self) -> FloatArray:
        """In m."""
        return self._last("radius")

    @property
    def stick_radius(self) -> FloatArray:
        """In m; that of the vertex below one that slips."""
        slips = (np.abs(self._last("slope")) == 1.0) & (self._now(TOP) > 0)
        return self._last("radius", below=slips)

    def _now(self, column: int) -> FloatArray:
        return np.asarray(self.arrays.memory[:, NOW, column])

    def _last(self, name: str, below: np.ndarray | int = 0) -> FloatArray:
        """A value of the last vertex of every stack, or of one below it; 0 without contact."""
        at = self._now(TOP).astype(int) - below
        values = self.arrays.vertices[np.arange(self.count), NOW, at][name]
        return np.where(self.indentation > 0.0, values, 0.0)

    def _grow(self) -> None:
        """Twice the room for vertices."""
        n, both, capacity = self.arrays.vertices.shape
        larger = np.zeros((n, both, 2 * capacity), dtype=self.arrays.vertices.dtype)
        larger[:, :, :capacity] = self.arrays.vertices
        self.arrays = self.arrays._replace(vertices=larger)
