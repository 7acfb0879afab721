"""Adhesion of a ball that has yielded: its edge recedes by the rule of Hess and never advances by attraction."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from pymdr.line.plastic.ball import Ball
from pymdr.line.plastic.ellipse import Ellipse
from pymdr.numerics.roots import roots_of
from pymdr.units import FloatArray

_ABOVE_FOLD = 1e-6
"""Distance from the separation at which a search begins, over that to the largest indentation."""


@dataclass(frozen=True)
class Edge:
    """The edge of an adhesive contact on one line."""

    line: Ellipse
    """One line."""
    work: float
    """Work of adhesion in J/m^2."""

    def length(self, a: float) -> float:
        """The largest elongation sqrt(2 pi a w / E_eff) in m of the springs at the edge (Hess 2011)."""
        return math.sqrt(2.0 * math.pi * a * self.work / self.line.modulus)

    def opening(self, a: float) -> float:
        """The indentation g(a) - sqrt(2 pi a w / E_eff) in m at which the edge recedes from a radius in m."""
        return float(self.line.depth(np.array(a))) - self.length(a)

    @property
    def critical_radius(self) -> float:
        """The radius in m at which the bodies separate, where the opening is least."""
        half, slope = 0.5 * float(self.line.width), float(self.line.height / self.line.width)
        factor = math.sqrt(0.5 * math.pi * self.work / self.line.modulus)

        def steeper(t: float) -> float:
            # g' sqrt(a) against the derivative of the elongation, a = (B/2) sin t
            return float(slope * math.sin(t) ** 1.5 * math.sqrt(half) - factor * math.cos(t))

        return half * math.sin(float(scipy.optimize.brentq(steeper, 0.0, 0.5 * math.pi, xtol=1e-16)))

    def receded(self, a: float, d: float) -> float:
        """The radius in m to which the edge recedes from another at an indentation d of the line in m; 0 if separated."""
        if d >= self.opening(a):
            return a
        least = self.critical_radius
        if a <= least or d < self.opening(least):
            return 0.0
        return float(scipy.optimize.brentq(lambda r: self.opening(r) - d, least, a, xtol=1e-15 * a))

    def force(self, d: float, a: float) -> float:
        """The force F(g(a)) + 2 E_eff (d - g(a)) a in N."""
        g = self.line.depth(np.array(a))
        return float(self.line.force(g)) + 2.0 * self.line.modulus * (d - float(g)) * a

    def energy(self, d: float, a: float) -> float:
        """The elastic energy in J."""
        g = self.line.depth(np.array(a))
        stretch = d - float(g)
        return float(self.line.energy(g)) + stretch * (
            float(self.line.force(g)) + self.line.modulus * a * stretch
        )


class EdgeRows(NamedTuple):
    """Rows of a contact whose edge may be stretched."""

    contact_radius: FloatArray
    """In m."""
    force: FloatArray
    """In N."""
    elastic_energy: FloatArray
    """In J."""
    dissipated: FloatArray
    """Energy in J that the edge dissipated up to the row."""


def start_of_edge() -> tuple[float, float]:
    """The contact radius in m and the energy in J dissipated by the edge, before the first touch."""
    return 0.0, 0.0


def follow_edge(
    ball: Ball, work: float, d: FloatArray, largest: FloatArray, before: tuple[float, float]
) -> tuple[EdgeRows, tuple[float, float]]:
    """
    Follow the edge along indentations.

    Parameters
    ----------
    work : float
        Work of adhesion in J/m^2.
    d, largest : ndarray
        Indentations and largest indentations in m, row by row.
    before : tuple of float
        Contact radius in m and dissipated energy in J before.

    Returns
    -------
    rows, after
    """
    lines, within = ball.line(largest), ball.line_depth(d, largest)
    scales, pressed = ball.scale(largest), ball.contact_radius(d, largest)
    rows = np.zeros((4, d.size))
    a, dissipated = before
    for i in range(d.size):
        edge = Edge(Ellipse(lines.height[i], lines.width[i], lines.modulus), work)
        depth, scale = float(within[i]), float(scales[i])
        if a > pressed[i]:
            receded = edge.receded(a, depth)
            if receded < a:
                # the edge takes the work of adhesion; a jump to separation loses the energy of the springs
                last = receded if receded > 0.0 else min(edge.critical_radius, a)
                dissipated += scale * work * math.pi * (a - last) * (a + last)
                if receded == 0.0:
                    dissipated += scale * edge.energy(edge.opening(last), last)
                a = receded
        a = max(a, float(pressed[i]))
        if a > 0.0:
            rows[:3, i] = a, edge.force(depth, a), scale * edge.energy(depth, a)
        rows[3, i] = dissipated
    return EdgeRows(*rows), (a, dissipated)


def depth_at_force(
    ball: Ball, work: float, target: float, largest: float, before: tuple[float, float]
) -> float:
    """
    The indentation in m at a force in N of at least 0, after a largest indentation in m; inf where 0.9 R does not suffice.

    The force rises with the indentation on every branch at rest, and where the edge recedes down to the fold of force control, at which
    it is negative.

    Parameters
    ----------
    work : float
        Work of adhesion in J/m^2.
    before : tuple of float
        As in :func:`follow_edge`.
    """
    pressed, most = ball.follow(np.array([target]), None, largest)
    if before[0] == 0.0 or float(most[0]) > largest:
        return float(pressed[0])
    at = np.array(largest)
    edge = Edge(ball.line(at), work)
    least = edge.opening(min(edge.critical_radius, before[0]))
    low = float(ball.residual(at) + ball.scale(at) * least)
    low += _ABOVE_FOLD * (largest - low)

    def missing(d: float) -> float:
        rows, _ = follow_edge(ball, work, np.array([d]), at[None], before)
        return float(rows.force[0]) - target

    return float(scipy.optimize.brentq(missing, low, largest, xtol=1e-15 * largest, rtol=1e-14))


class Parting(NamedTuple):
    """Unloading of a ball that adheres, from its largest indentation to separation."""

    ball: Ball
    edge: Edge
    largest: float
    """In m."""
    radius: float
    """Contact radius in m there."""

    @property
    def least(self) -> float:
        """Contact radius in m at separation."""
        return min(self.radius, self.edge.critical_radius)

    @property
    def separation(self) -> float:
        """Indentation in m at which the bodies separate."""
        return self._depth_of(self.edge.opening(self.least))

    @property
    def receding(self) -> float:
        """Indentation in m from which on the edge recedes."""
        return self._depth_of(self.edge.opening(self.radius))

    def _depth_of(self, within: float) -> float:
        at = np.array(self.largest)
        return float(self.ball.residual(at) + self.ball.scale(at) * within)

    def states(self, d: FloatArray) -> EdgeRows:
        """States at indentations in m of one dimension, down to that of separation."""
        line, work, modulus = self.edge.line, self.edge.work, self.edge.line.modulus
        scale = self.ball.scale(np.array(self.largest))
        within = self.ball.line_depth(d, np.array(self.largest))

        def opening(a: FloatArray, at: FloatArray) -> FloatArray:
            return np.asarray(line.depth(a) - np.sqrt(2.0 * math.pi * a * work / modulus) - at)

        a = np.full(d.shape, self.radius)
        moves = within < self.edge.opening(self.radius)
        if moves.any():
            # rounding must not take a depth below that of separation
            at = np.maximum(within[moves], self.edge.opening(self.least))
            a[moves] = roots_of(opening, np.full(at.shape, self.least), a[moves], at)
        g = line.depth(a)
        stretch, force = within - g, line.force(g)
        energy = line.energy(g) + stretch * (force + modulus * a * stretch)
        spent = math.pi * work * (self.radius - a) * (self.radius + a)
        return EdgeRows(a, force + 2.0 * modulus * stretch * a, scale * energy, scale * spent)


def parting_from(ball: Ball, work: float, largest: float) -> Parting:
    """The unloading of a ball from a largest indentation in m, with a work of adhesion in J/m^2."""
    at = np.array(largest)
    return Parting(ball, Edge(ball.line(at), work), largest, float(ball.contact_radius(at, at)))
