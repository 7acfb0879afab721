"""Contacts of a ball that yields, moved step by step."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import astuple
from typing import Any, NamedTuple

import numpy as np

from pymdr.line.moved import BEFORE, NOW, BoolArray, Moved, WithoutAdhesion, WithoutShift
from pymdr.line.plastic import layout as at
from pymdr.line.plastic.adhesion import follow_edge
from pymdr.line.plastic.ball import Ball
from pymdr.line.plastic.ellipse import Ellipse
from pymdr.line.plastic.growth import GrowingBall, Growth, Row
from pymdr.units import FloatArray

_AREAS = 8
"""Column of the first area of a growing ball."""
_GROWN = len(Growth.__dataclass_fields__) + 1
"""Columns of a growing ball, which has two areas, before those of its last step."""


class _Yielding(WithoutShift, WithoutAdhesion, Moved):
    """Contacts without friction that take one step after the other."""

    @abstractmethod
    def _step(self, now: FloatArray, depth: float) -> float:
        """Change the columns of one contact by a step to an indentation in m; F_N in N."""

    def advance(self, depth: float, shift: Any, duration: Any) -> tuple[float, float]:
        """Go with one contact straight to an indentation in m; F_N in N, and 0."""
        (columns,) = self.arrays
        columns[0, BEFORE] = columns[0, NOW]
        return self._step(columns[0, NOW], depth), 0.0

    def advance_all(self, depth: FloatArray, shift: Any, duration: Any) -> tuple[FloatArray, FloatArray]:
        """The same with all contacts."""
        (columns,) = self.arrays
        columns[:, BEFORE] = columns[:, NOW]
        steps = zip(columns[:, NOW], depth.tolist(), strict=True)
        return np.array([self._step(now, d) for now, d in steps]), np.zeros(depth.shape)

    def _now(self, column: int) -> FloatArray:
        return np.asarray(self.arrays[0][:, NOW, column])


class YieldingContacts(_Yielding):
    """
    Contacts of a ball that yields, which remember the largest indentation, and with adhesion where the edge rests.

    Parameters
    ----------
    work : float
        Of adhesion in J/m^2, 0 without.
    """

    def __init__(self, ball: Ball, work: float, count: int) -> None:
        from pymdr.line.plastic import steps

        self._ball, self._work, self.adhesive = ball, work, work > 0.0
        limits = ball.yield_depth, float(ball.walled)
        self.body = np.array([ball.radius, ball.modulus, ball.shear, ball.poisson, ball.strength, *limits])
        self._steps: Any = steps
        self.arrays = (np.zeros((count, 2, at.JUMPED + 1)),)

    def _step(self, now: FloatArray, depth: float) -> float:
        """A step with adhesion."""
        largest = max(float(now[at.LARGEST]), depth)
        now[at.DEPTH], now[at.LARGEST] = depth, largest
        before = float(now[at.EDGE]), float(now[at.DISSIPATED])
        ends = np.array([depth]), np.array([largest])
        rows, (now[at.EDGE], now[at.DISSIPATED]) = follow_edge(self._ball, self._work, *ends, before)
        now[at.FORCE] = rows.force[0]
        now[at.JUMPED] = before[0] > 0.0 and now[at.EDGE] == 0.0 and now[at.DISSIPATED] > before[1]
        return float(now[at.FORCE])

    def advance(self, depth: float, shift: Any, duration: Any) -> tuple[float, float]:
        """Go with one contact straight to an indentation in m; F_N in N, and 0."""
        if self.adhesive:
            return super().advance(depth, shift, duration)
        return float(self._steps.step(self.body, self.arrays[0][0], depth)), 0.0

    def advance_all(self, depth: FloatArray, shift: Any, duration: Any) -> tuple[FloatArray, FloatArray]:
        """The same with all contacts, without adhesion together."""
        if self.adhesive:
            return super().advance_all(depth, shift, duration)
        force = np.empty(depth.shape)
        every = self.body, self.arrays[0], depth, force
        self.threads.run(lambda some: self._steps.step_all(*every, some))
        return force, np.zeros(depth.shape)

    @property
    def _at(self) -> tuple[FloatArray, FloatArray]:
        return self._now(at.DEPTH), self._now(at.LARGEST)

    @property
    def indentation(self) -> FloatArray:
        """Indentations in m."""
        return self._now(at.DEPTH)

    @property
    def normal_force(self) -> FloatArray:
        """F_N in N."""
        return self._now(at.FORCE)

    @property
    def contact_radius(self) -> FloatArray:
        """In m; 0 without contact."""
        return self._now(at.EDGE) if self.adhesive else self._ball.contact_radius(*self._at)

    @property
    def normal_stiffness(self) -> FloatArray:
        """Tangent stiffness in N/m of unloading and reloading."""
        if self.adhesive:
            return np.asarray(2.0 * self._ball.modulus * self._now(at.EDGE) / self._ball.scale(self._at[1]))
        return self._ball.stiffness(*self._at)

    @property
    def elastic_energy(self) -> FloatArray:
        """Energy in J that unloading returns."""
        if not self.adhesive:
            return self._ball.elastic_energy(*self._at)
        stored = [
            # the edge is where it rests, from which it does not move
            follow_edge(self._ball, self._work, d, most, (float(edge), 0.0))[0].elastic_energy[0]
            for edge, d, most in zip(self._now(at.EDGE), *(ends[:, None] for ends in self._at), strict=True)
        ]
        return np.array(stored)

    @property
    def dissipated_energy(self) -> FloatArray:
        """Energy in J dissipated by yield, and by the edge, so far."""
        return self._ball.dissipation(self._at[1]) + self._now(at.DISSIPATED)

    @property
    def yielded(self) -> BoolArray:
        """Whether the ball has yielded."""
        return self._ball.residual(self._now(at.LARGEST)) > 0.0

    @property
    def jumped(self) -> BoolArray:
        """Whether the bodies separated under tension in the last step."""
        return self._now(at.JUMPED) > 0.0


class GrowingContacts(_Yielding):
    """Contacts of a ball that yields, of a growing apparent radius."""

    def __init__(self, growing: GrowingBall, count: int) -> None:
        self._growing = growing
        row, state = growing.advance(growing.start, 0.0)
        self.arrays = (np.tile(_columns(state, row), (count, 2, 1)),)

    def _step(self, now: FloatArray, depth: float) -> float:
        row, state = self._growing.advance(_state(now), depth)
        now[:] = _columns(state, row)
        return row.force

    @property
    def _last(self) -> _Rows:
        return _Rows(*self.arrays[0][:, NOW, _GROWN:].T)

    @property
    def _line(self) -> Ellipse:
        return Ellipse(self._last.height, self._last.width, self._growing.ball.modulus)

    @property
    def indentation(self) -> FloatArray:
        """Indentations in m, of the ball of the initial radius."""
        return self._last.indentation

    @property
    def normal_force(self) -> FloatArray:
        """F_N in N."""
        return self._last.force

    @property
    def contact_radius(self) -> FloatArray:
        """In m; 0 without contact."""
        return self._line.contact_radius(self._last.line_depth)

    @property
    def normal_stiffness(self) -> FloatArray:
        """Tangent stiffness in N/m of unloading and reloading."""
        ball, last = self._growing.ball, self._last
        elastic = 2.0 * ball.modulus * self.contact_radius / last.scale * ball.wall(last.indentation)
        return np.asarray(elastic + ball.wall_rate(last.indentation) * last.force)

    @property
    def elastic_energy(self) -> FloatArray:
        """Energy in J that unloading returns."""
        last = self._last
        return np.asarray(
            last.scale * self._growing.ball.wall(last.indentation) * self._line.energy(last.line_depth)
        )

    @property
    def dissipated_energy(self) -> FloatArray:
        """Energy in J dissipated by yield so far."""
        return self._now(_GROWN - 1) - self.elastic_energy

    @property
    def yielded(self) -> BoolArray:
        """Whether the ball has yielded."""
        return self._last.residual > 0.0


class _Rows(NamedTuple):
    """Steps of contacts, as :class:`~pymdr.line.plastic.growth.Row`."""

    indentation: FloatArray
    force: FloatArray
    apparent_radius: FloatArray
    height: FloatArray
    width: FloatArray
    line_depth: FloatArray
    scale: FloatArray
    residual: FloatArray
    yielding: FloatArray


def _columns(state: Growth, row: Row) -> FloatArray:
    """All that a contact remembers as numbers."""
    return np.array([*np.hstack(astuple(state)), *row], dtype=float)


def _state(columns: FloatArray) -> Growth:
    """The state of a contact from its numbers."""
    own: list[Any] = columns[:_GROWN].tolist()
    own[_AREAS : _AREAS + 2] = [tuple(own[_AREAS : _AREAS + 2])]
    return Growth(*own)
