"""Memory stacks of contacts that are moved step by step."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from pymdr.line.friction import layout
from pymdr.line.friction.curves import ElasticCurves
from pymdr.line.friction.state import FrictionState
from pymdr.line.moved import NOW, Moved, WithoutAdhesion, beyond
from pymdr.problem.values import LARGEST
from pymdr.units import FloatArray

_CAPACITY = 16
"""Vertices for which every stack has room at first."""


class Stacks(WithoutAdhesion, Moved):
    """
    Contacts of one body, each with its stack, which grows with its history.

    What they remember: (n, 2, capacity) vertices of the anchor curves, and (n, 2, 6) columns of :mod:`pymdr.line.friction.layout`.

    Parameters
    ----------
    curves : ElasticCurves
        Of the body.
    start : FrictionState
        Bodies that have not touched, with the coefficient of friction and the ratio of the moduli.
    moves : bool
        Whether there is friction; without it the shift stays 0 and no spring slips.
    count : int
        Number of contacts.
    """

    moves: float
    """1 with friction, else 0."""
    body: tuple[FloatArray, FloatArray]
    """The line and the scales, as compiled steps read them."""
    slips: bool
    """Whether springs may slip."""

    def __init__(self, curves: ElasticCurves, start: FrictionState, moves: bool, count: int) -> None:
        from pymdr.line.friction import kernels, steps

        self.moves = float(moves)
        scales = np.array([start.traction_scale, start.energy_scale, start.shift_scale])
        self.body = curves.rows, scales
        self._stiffness = 2.0 * curves.modulus
        self._tangential_stiffness = self.moves * self._stiffness / start.modulus_ratio
        self.slips = math.isfinite(start.friction)
        self._step = steps.step if self.slips else steps.step_stuck
        self._step_all = steps.step_all if self.slips else steps.step_all_stuck
        vertices = np.zeros((count, 2, _CAPACITY), dtype=kernels.VERTEX)
        vertices["low"][:, :, 0], vertices["high"][:, :, 0] = -math.inf, math.inf
        self.arrays = (vertices, np.zeros((count, 2, layout.TOP + 1)))
        self._one: tuple[Any, Any] = (None, ())

    def advance(self, depth: float, shift: Any, duration: Any) -> tuple[float, float]:
        """Go with one contact straight to an indentation and a shift in m; F_N and F_x in N."""
        arrays = self.arrays
        if self._one[0] is not arrays:  # views take as long as the step
            self._one = arrays, (*self.body, *(array[0] for array in arrays))
        line, scales, stack, memory = self._one[1]
        code, normal, tangential = self._step(line, scales, stack, memory, depth, self.moves * float(shift))
        if code == layout.COMPLETE:
            return normal, self.moves * tangential
        if code != layout.STACK_FULL:
            raise beyond(f"shift = {shift:g} m")
        self.grow(self._capacity + 1)
        return self.advance(depth, shift, duration)

    def advance_all(self, depth: FloatArray, shift: Any, duration: Any) -> tuple[FloatArray, FloatArray]:
        """Go with all contacts to indentations and shifts in m; F_N and F_x in N alike."""
        given = np.empty((2, self.count))
        given[0], given[1] = depth, np.multiply(shift, self.moves)
        known = np.abs(given[1]) <= LARGEST
        if not known.all():
            raise beyond(f"shift = {given[1][~known][0]:g} m")
        forces, parts = np.empty(given.shape), self.threads.parts
        while parts:
            every: tuple[Any, ...] = (*self.body, *self.arrays, given, forces)
            ends = self.threads.run(partial(self._step_all, *every), parts)
            parts = [(at, end) for (_, at), (_, end) in zip(ends, parts, strict=True) if at < end]
            if parts:  # their next contacts have full stacks
                self.grow(self._capacity + 1)
        return forces[0], self.moves * forces[1]

    @property
    def indentation(self) -> FloatArray:
        """Indentations in m."""
        return self._now(layout.DEPTH)

    @property
    def shift(self) -> FloatArray:
        """Shifts in m."""
        return np.asarray(self._now(layout.SHIFT) * self.body[1][layout.SHIFT_SCALE])

    @property
    def dissipated_energy(self) -> FloatArray:
        """Energy in J dissipated by slip so far, without slip released by separating springs."""
        return np.asarray(self.moves * self._now(layout.SLIP_WORK) * self.body[1][layout.ENERGY_SCALE])

    @property
    def normal_force(self) -> FloatArray:
        """F_N in N."""
        return self._last("force")

    @property
    def tangential_force(self) -> FloatArray:
        """F_x in N."""
        return np.asarray(self.moves * self._last("pull") * self.body[1][layout.FORCE_SCALE])

    @property
    def elastic_energy(self) -> FloatArray:
        """Energy in J stored by the indentation."""
        return self._last("work")

    @property
    def stored_tangential_energy(self) -> FloatArray:
        """Energy in J stored by the shift."""
        return np.asarray(
            self.moves * np.maximum(self._last("energy"), 0.0) * self.body[1][layout.ENERGY_SCALE]
        )

    @property
    def contact_radius(self) -> FloatArray:
        """In m."""
        return self._last("radius")

    @property
    def stick_radius(self) -> FloatArray:
        """In m; that of the vertex below one that slips."""
        slips = (np.abs(self._last("slope")) == 1.0) & (self._now(layout.TOP) > 0)
        return np.asarray(self.moves * self._last("radius", below=slips))

    @property
    def normal_stiffness(self) -> FloatArray:
        """Tangent stiffness 2 E* a in N/m."""
        return np.asarray(self._stiffness * self.contact_radius)

    @property
    def tangential_stiffness(self) -> FloatArray:
        """Tangent stiffness 2 G* c in N/m as the motion goes on, c the radius of the part that sticks."""
        return np.asarray(self._tangential_stiffness * self.stick_radius)

    def _now(self, column: int) -> FloatArray:
        return np.asarray(self.arrays[1][:, NOW, column])

    def _last(self, name: str, below: np.ndarray | int = 0) -> FloatArray:
        """A value of the last vertex of every stack, or of one below it; 0 without contact."""
        at = self._now(layout.TOP).astype(int) - below
        values = self.arrays[0][np.arange(self.count), NOW, at][name]
        return np.where(self.indentation > 0.0, values, 0.0)

    @property
    def _capacity(self) -> int:
        return int(self.arrays[0].shape[2])

    def grow(self, vertices: int) -> None:
        """Enlarge the stacks to at least a number of vertices, by doubling."""
        n, both, capacity = self.arrays[0].shape
        doublings = max(0, math.ceil(math.log2(vertices / capacity)))
        if doublings:
            larger = np.zeros((n, both, capacity << doublings), dtype=self.arrays[0].dtype)
            larger[:, :, :capacity] = self.arrays[0]
            self.arrays = (larger, self.arrays[1])
