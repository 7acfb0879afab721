"""Contacts of bodies with memory under a cohesive zone that are moved step by step."""

from __future__ import annotations

import math
from copy import deepcopy
from typing import Any, Self

import numpy as np

from pymdr.errors import PathError
from pymdr.line.moved import BEFORE, NOW, BoolArray, IntArray, Moved, WithoutShift, durations_of
from pymdr.line.soft.small_zone import ShortSprings
from pymdr.line.soft.springs import ZoneSprings
from pymdr.units import FloatArray, metres

_KEPT = (
    "indentation",
    "normal_force",
    "contact_radius",
    "cohesive_radius",
    "elastic_energy",
    "surface_energy",
    "body_dissipation",
    "jump_dissipation",
    "jumped",
    "touched",
)
_NUDGE = 1e-3
"""Sudden step by which a stiffness is measured, over the range of the attraction."""
_SUDDEN = 1e-6
"""Its duration over the shortest relaxation time."""


class ZoneContacts(WithoutShift, Moved):
    """
    Contacts of one pair of bodies on springs with memory that attract each other by a constant stress, or within a short range.

    What they remember: the arrays of the springs, and (n, 2, 10) quantities after the step.

    Parameters
    ----------
    springs : ZoneSprings or ShortSprings
        Of bodies that have not touched.
    count : int
        Number of contacts.
    """

    def __init__(self, springs: ZoneSprings | ShortSprings, count: int) -> None:
        self.springs = springs
        start = *springs.state, np.zeros(len(_KEPT))
        self.arrays = tuple(np.tile(one, (count, 2, *([1] * one.ndim))) for one in start)

    def advance(self, depth: float, shift: Any, duration: Any) -> tuple[float, float]:
        """Go with one contact straight to an indentation in m within a duration in s; F_N in N, and 0."""
        force, zero = self.advance_all(np.array([depth]), shift, duration)
        return float(force[0]), float(zero[0])

    def advance_all(self, depth: FloatArray, shift: Any, duration: Any) -> tuple[FloatArray, FloatArray]:
        """The same with all contacts."""
        durations = durations_of(depth.size, duration)
        free = self._now("cohesive_radius") == 0.0
        sudden = (np.array(durations) == 0.0) & ~free & (depth != self.indentation)
        if sudden.any():
            i = int(np.argmax(sudden))
            raise PathError(
                f"indentation = {metres(depth[i])} in zero time, which adhesion with memory does not cover; give the step a duration"
            )
        steps = enumerate(zip(depth.tolist(), durations, strict=True))
        ends = [self._follow(i, d, lasts) for i, (d, lasts) in steps]
        for array, *after in zip(self.arrays, *ends, strict=True):
            array[:, BEFORE] = array[:, NOW]
            array[:, NOW] = after
        return self.normal_force.copy(), np.zeros(depth.shape)

    def _follow(self, i: int, depth: float, duration: float) -> list[FloatArray]:
        """All that contact i remembers after a step, which is not yet taken."""
        *remembered, row = (array[i, NOW] for array in self.arrays)
        for array, now in zip(self.springs.state, remembered, strict=True):
            array[...] = now
        begin = float(row[_KEPT.index("indentation")])
        after = self.springs.follow(np.array([0.0, duration]), np.array([begin, depth]), math.inf, True)
        after["jump_dissipation"] += row[_KEPT.index("jump_dissipation")]
        touched = (row[_KEPT.index("touched")] > 0.0) | (after["cohesive_radius"] > 0.0)
        columns = after | {"indentation": np.array([depth]), "touched": touched}
        ends = [array.copy() for array in self.springs.state]
        return [*ends, np.array([columns[name][0] for name in _KEPT])]

    def copied(self) -> Self:
        """The same contacts, which move on their own."""
        other = super().copied()
        other.springs = deepcopy(self.springs)
        return other

    @property
    def indentation(self) -> FloatArray:
        """Indentations in m."""
        return self._now("indentation")

    @property
    def normal_force(self) -> FloatArray:
        """F_N in N."""
        return self._now("normal_force")

    @property
    def contact_radius(self) -> FloatArray:
        """In m; 0 where only the attraction acts."""
        return self._now("contact_radius")

    @property
    def normal_stiffness(self) -> FloatArray:
        """Stiffness in N/m of a sudden step, as the difference of two small ones; 0 for free bodies."""
        setting = self.springs.setting
        nudge = _NUDGE * setting.work / setting.strength
        lasting = _SUDDEN * float(setting.relaxation.times.min())
        force = _KEPT.index("normal_force")
        stiffness = np.zeros(self.count)
        for i in np.flatnonzero(self._now("cohesive_radius")).tolist():
            here = float(self.indentation[i])
            up, down = (self._follow(i, here + side * nudge, lasting)[-1][force] for side in (1.0, -1.0))
            stiffness[i] = 0.5 * (up - down) / nudge
        return stiffness

    @property
    def elastic_energy(self) -> FloatArray:
        """Energy in J of all springs."""
        return self._now("elastic_energy")

    @property
    def surface_energy(self) -> FloatArray:
        """Energy in J of the attraction."""
        return self._now("surface_energy")

    @property
    def dissipated_energy(self) -> FloatArray:
        """Energy in J of all dashpots and of jumps so far."""
        return np.asarray(self._now("body_dissipation") + self._now("jump_dissipation"))

    @property
    def jumped(self) -> BoolArray:
        """Whether the last step jumped."""
        return self._now("jumped") > 0.0

    @property
    def branch(self) -> IntArray:
        """0 where the bodies attract each other or touch, else -1."""
        return np.where(self._now("cohesive_radius") > 0.0, 0, -1)

    @property
    def touched(self) -> BoolArray:
        """Whether the bodies have attracted each other after a step."""
        return self._now("touched") > 0.0

    def _now(self, name: str) -> FloatArray:
        return np.asarray(self.arrays[-1][:, NOW, _KEPT.index(name)])
