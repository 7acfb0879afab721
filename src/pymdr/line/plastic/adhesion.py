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
        """The radius in m at which the bodies separate under a prescribed indentation, where the opening is least."""
        return self.critical_radius_at(0.0)

    def critical_radius_at(self, softness: float) -> float:
        """
        The radius in m at which the bodies separate, where the control is least while the edge recedes.

        Parameters
        ----------
        softness : float
            E_eff times the compliance of the machine over the scale of the indentation, in 1/m; inf under a prescribed force.

        Notes
        -----
        a g'(a) is the elongation of the edge times 3/2 - 1 / (1 + 2 q a), with the softness q: 1/2 under a prescribed indentation.
        """
        half, slope = 0.5 * float(self.line.width), float(self.line.height / self.line.width)
        elongation = math.sqrt(2.0 * math.pi * self.work / self.line.modulus)

        def steeper(t: float) -> float:
            # a = (B/2) sin t
            sine = math.sin(t)
            part = 1.5 - 1.0 / (1.0 + 2.0 * softness * half * sine) if sine > 0.0 else 0.5
            return float(slope * sine**1.5 * math.sqrt(half) - part * elongation * math.cos(t))

        return half * math.sin(float(scipy.optimize.brentq(steeper, 0.0, 0.5 * math.pi, xtol=1e-16)))

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
    """Rows of a contact whose edge may be stretched; NaN where a prescribed tension pulled the bodies off."""

    depth: FloatArray
    """Indentation in m."""
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


@dataclass(frozen=True)
class _Pull:
    """What holds an edge: its line at one largest indentation, and the control."""

    edge: Edge
    residual: float
    """Indentation in m at which the line begins."""
    scale: float
    """Indentation per indentation of the line."""
    compliance: float | None
    """Of the machine in m/N; None for prescribed forces."""

    def control(self, d: float, a: float) -> float:
        """The control, a travel in m or a force in N, at an indentation d of the line in m and a radius in m."""
        force = self.edge.force(d, a)
        return force if self.compliance is None else self.residual + self.scale * d + self.compliance * force

    def at_rest(self, target: float, a: float) -> float:
        """The indentation of the line in m where the edge rests at a radius in m: the control is linear in it."""
        g, stiffness = float(self.edge.line.depth(np.array(a))), 2.0 * self.edge.line.modulus * a
        rate = stiffness if self.compliance is None else self.scale + self.compliance * stiffness
        return g + (target - self.control(g, a)) / rate

    def last(self, a: float) -> float:
        """The radius in m to which the edge recedes before the bodies separate."""
        softness = math.inf
        if self.compliance is not None:
            softness = self.edge.line.modulus * self.compliance / self.scale
        return min(a, self.edge.critical_radius_at(softness))

    def receded(self, target: float, a: float) -> tuple[float, float]:
        """The indentation of the line and the radius in m where the edge rests or recedes to; a radius of 0 if separated."""
        d = self.at_rest(target, a)
        if d >= self.edge.opening(a):
            return d, a

        def missing(r: float) -> float:
            return self.control(self.edge.opening(r), r) - target

        last = self.last(a)
        if last == a or missing(last) > 0.0:
            return d, 0.0
        r = float(scipy.optimize.brentq(missing, last, a, xtol=1e-15 * a, rtol=1e-14))
        return self.edge.opening(r), r

    def loss(self, a: float, receded: float) -> float:
        """The energy in J that the edge takes on its way between two radii in m; a jump to separation takes that of springs and machine."""
        last = receded if receded > 0.0 else self.last(a)
        spent = self.scale * self.edge.work * math.pi * (a - last) * (a + last)
        if receded == 0.0:
            d = self.edge.opening(last)
            machine = 0.5 * (self.compliance or 0.0) * self.edge.force(d, last) ** 2
            spent += self.scale * self.edge.energy(d, last) + machine
        return spent


def follow_edge(
    ball: Ball,
    work: float,
    d: FloatArray,
    largest: FloatArray,
    before: tuple[float, float],
    targets: FloatArray | None = None,
    compliance: float | None = 0.0,
) -> tuple[EdgeRows, tuple[float, float]]:
    """
    Follow the edge along rows.

    Parameters
    ----------
    work : float
        Work of adhesion in J/m^2.
    d, largest : ndarray
        Indentations and largest indentations in m, row by row, that the control has without adhesion.
    before : tuple of float
        Contact radius in m and dissipated energy in J before.
    targets : ndarray, optional
        Forces in N or travels in m; by default the indentations.
    compliance : float or None
        Of the machine in m/N, 0 for prescribed indentations; None for prescribed forces.
    """
    lines, residual, scales = ball.line(largest), ball.residual(largest), ball.scale(largest)
    within, pressed = ball.line_depth(d, largest), ball.contact_radius(d, largest)
    rows, targets = np.zeros((5, d.size)), d if targets is None else targets
    a, dissipated = before
    for i, target in enumerate(targets.tolist()):
        edge = Edge(Ellipse(lines.height[i], lines.width[i], lines.modulus), work)
        depth, at = float(within[i]), float(d[i])
        if a > pressed[i]:
            pull = _Pull(edge, float(residual[i]), float(scales[i]), compliance)
            depth, receded = pull.receded(target, a)
            if receded < a:
                dissipated += pull.loss(a, receded)
            a = receded
            if a > 0.0 and compliance != 0.0:
                at = pull.residual + pull.scale * depth
        else:
            a = float(pressed[i])
        if a > 0.0:
            rows[:, i] = at, a, edge.force(depth, a), scales[i] * edge.energy(depth, a), dissipated
        elif compliance is None and target < 0.0:
            rows[:, i] = *(math.nan,) * 4, dissipated
        else:
            rows[:, i] = at, 0.0, 0.0, 0.0, dissipated
    return EdgeRows(*rows), (a, dissipated)


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
        return EdgeRows(d, a, force + 2.0 * modulus * stretch * a, scale * energy, scale * spent)


def parting_from(ball: Ball, work: float, largest: float) -> Parting:
    """The unloading of a ball from a largest indentation in m, with a work of adhesion in J/m^2."""
    at = np.array(largest)
    return Parting(ball, Edge(ball.line(at), work), largest, float(ball.contact_radius(at, at)))
