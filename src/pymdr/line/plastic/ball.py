"""The ball that yields: its state follows from the indentation and the largest one before."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
import scipy

from pymdr.line.plastic.ellipse import Ellipse
from pymdr.numerics.quadrature import gauss
from pymdr.numerics.roots import rising_root, roots_of
from pymdr.units import FloatArray

DEEPEST = 0.9
"""Largest indentation over R; near 1 the force of the model falls."""
_NODES, _OF_LOADING = 48, 24
"""Of quadratures of the energy that unloading returns, and of the work of yielding, whose force is smooth."""
_STEEPNESS, _DELAY = 10.7, 10.0
"""Of the factor of the wall, 1 + exp(10.7 d / R - 10)."""

Number = TypeVar("Number", float, FloatArray)


def wall_factor(depth: Number, radius: float) -> Number:
    """The factor of the force on a wall by the stiffening of the whole ball, 1 + exp(10.7 d / R - 10)."""
    factor: Number = 1.0 + np.exp(_STEEPNESS * depth / radius - _DELAY)
    return factor


def yield_pressure(strength: float, fraction: Number) -> Number:
    """Mean pressure p_Y = Y (1 + 1.75 exp(-4.4 M / R)) in Pa of a contact that yields, by its largest indentation over R."""
    pressure: Number = strength * (1.0 + 1.75 * np.exp(-4.4 * fraction))
    return pressure


def lift(pressure: Number, a: Number, z: Number, poisson: float, shear: float) -> Number:
    """
    The displacement d_R in m of the contact by its load pi a^2 p_Y, negative, a depth z in m above the centre of the ball.

    d_R = p_Y a^2 (2 (nu - 1) - (2 nu - 1) z / (s + z)) / (2 G s), s = sqrt(a^2 + z^2).
    """
    far: Number = np.hypot(a, z)
    # sqrt(a^2 + z^2) - z = a^2 / (sqrt(a^2 + z^2) + z)
    lifted: Number = pressure * a * a * (2.0 * (poisson - 1.0) - (2.0 * poisson - 1.0) * z / (far + z))
    return lifted / (2.0 * shear * far)


@dataclass(frozen=True)
class ApparentRadius:
    """The apparent radius of a ball over its largest indentation."""

    initial: float
    """In m."""
    onset: float
    """Largest indentation in m from which on it grows."""
    series: FloatArray
    """Chebyshev coefficients in m from there to 0.9 R."""

    def __call__(self, largest: FloatArray) -> FloatArray:
        """In m, after largest indentations in m."""
        end = DEEPEST * self.initial
        x = (2.0 * np.clip(largest, self.onset, end) - self.onset - end) / (end - self.onset)
        return np.asarray(np.polynomial.chebyshev.chebval(x, self.series))


@dataclass(frozen=True)
class Ball:
    """
    A ball that yields on a rigid flat (Zunker and Kamrin 2024).

    With p_Y = Y (1 + 1.75 exp(-4.4 M / R)) at the largest indentation M, d_Y where 4 E sqrt(d_Y / R) / (3 pi) = p_Y(d_Y), and
    c = d_Y^2 - d_Y R, the contact radius at M is a_M = sqrt(2 M R - M^2 + c). The line has A = 4 p_Y a_M / E and B = 2 a_M, its
    indentation is d_e = (d - M + A/2 + d_R) / (1 + 2 d_R / A), with
    d_R = F_M (2 a_M^2 (nu - 1) - (2 nu - 1) z (sqrt(a_M^2 + z^2) - z)) / (2 pi a_M^2 G sqrt(a_M^2 + z^2)), z = R - M + A/2.
    Before yield A = 4 R, B = 2 R and d_e = d.
    """

    radius: float
    """R in m."""
    modulus: float
    """E_eff in Pa."""
    shear: float
    """G in Pa."""
    poisson: float
    strength: float
    """Y in Pa."""
    walled: bool = False
    """Whether the force is multiplied by 1 + exp(10.7 d / R - 10)."""
    grown: ApparentRadius | None = None
    """Of the ball, if it grows; R - M of the apparent ball is then that of the initial one."""

    yield_depth: float = field(init=False)
    """The indentation d_Y in m of first yield; inf if the ball does not yield up to 0.9 R."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "yield_depth", self._first_yield())

    def _first_yield(self) -> float:
        def excess(t: float) -> float:
            hertz = 4.0 * self.modulus * math.sqrt(t) / (3.0 * math.pi)
            return hertz / self.strength - (1.0 + 1.75 * math.exp(-4.4 * t))

        if excess(DEEPEST) < 0.0:
            return math.inf
        # below, p_Y is at most 2.75 Y
        low = min(1.0, (3.0 * math.pi * self.strength / (4.0 * self.modulus)) ** 2)
        t = scipy.optimize.brentq(excess, 0.5 * low, min(8.0 * low, 1.0), xtol=1e-15 * low, rtol=1e-15)
        return self.radius * float(t)

    @property
    def knots(self) -> tuple[float, ...]:
        """Indentations in m of the first loading at which the ball yields, and its apparent radius begins to grow."""
        knots = (self.yield_depth,) if math.isfinite(self.yield_depth) else ()
        return knots if self.grown is None else (*knots, self.grown.onset)

    def yield_pressure(self, largest: FloatArray) -> FloatArray:
        """P_Y in Pa after largest indentations in m."""
        return self._contact_of(largest)[1]

    def yielded(self, largest: FloatArray) -> FloatArray:
        """1 where the ball has yielded, else 0."""
        return np.asarray(np.asarray(largest) >= self.yield_depth, dtype=float)

    def full_radius(self, largest: FloatArray) -> FloatArray:
        """The contact radius a_M in m at largest indentations in m, after yield."""
        return np.sqrt(self._contact_of(largest)[0])

    def _contact_of(self, largest: FloatArray) -> tuple[FloatArray, FloatArray]:
        """a_M^2 in m^2 and p_Y in Pa after largest indentations in m, after yield."""
        first = min(self.yield_depth, self.radius)
        square = largest * (2.0 * self.radius - largest) - first * (self.radius - first)
        # the indentation of the apparent ball over its radius, 1 - (R - M) / R
        fraction = largest / self.radius
        if self.grown is not None:
            apparent = self.grown(largest)
            square = square + (apparent - self.radius) * (apparent + self.radius)
            fraction = 1.0 - (self.radius - largest) / apparent
        pressure = np.asarray(yield_pressure(self.strength, fraction))
        return np.maximum(square, first * self.radius), pressure

    def line(self, largest: FloatArray) -> Ellipse:
        """The line after largest indentations in m."""
        largest = np.asarray(largest, dtype=float)
        square, pressure = self._contact_of(largest)
        a = np.sqrt(square)
        height = 4.0 * pressure * a / self.modulus
        yielded = self.yielded(largest) > 0.0
        return Ellipse(
            np.where(yielded, height, 4.0 * self.radius),
            np.where(yielded, 2.0 * a, 2.0 * self.radius),
            self.modulus,
        )

    def lift(self, largest: FloatArray) -> FloatArray:
        """The displacement d_R in m by which the load lifts the contact, negative; 0 before yield."""
        largest = np.asarray(largest, dtype=float)
        square, pressure = self._contact_of(largest)
        a = np.sqrt(square)
        z = self.radius - largest + 2.0 * pressure * a / self.modulus
        lifted = lift(pressure, a, z, self.poisson, self.shear)
        return np.where(self.yielded(largest) > 0.0, lifted, 0.0)

    def scale(self, largest: FloatArray) -> FloatArray:
        """Indentation per indentation of the line, 1 + 2 d_R / A."""
        return np.asarray(1.0 + 2.0 * self.lift(largest) / self.line(largest).height)

    def residual(self, largest: FloatArray) -> FloatArray:
        """The residual indentation in m, at which the force vanishes after a largest indentation in m."""
        largest = np.asarray(largest, dtype=float)
        depth = largest - 0.5 * self.line(largest).height - self.lift(largest)
        return np.where(self.yielded(largest) > 0.0, depth, 0.0)

    def line_depth(self, d: FloatArray, largest: FloatArray) -> FloatArray:
        """The indentation d_e of the line in m."""
        largest = np.asarray(largest, dtype=float)
        return np.asarray((d - self.residual(largest)) / self.scale(largest))

    def wall(self, d: FloatArray) -> FloatArray:
        """The factor of the force by opposite walls; 1 without it."""
        if not self.walled:
            return np.ones(np.shape(d))
        return np.asarray(wall_factor(np.asarray(d, dtype=float), self.radius))

    def wall_rate(self, d: FloatArray) -> FloatArray:
        """The rate in 1/m at which the logarithm of the factor of the walls rises."""
        factor = self.wall(d)
        return np.asarray(_STEEPNESS / self.radius * (factor - 1.0) / factor)

    def contact_radius(self, d: FloatArray, largest: FloatArray) -> FloatArray:
        """The contact radius in m."""
        return self.line(largest).contact_radius(self.line_depth(d, largest))

    def force(self, d: FloatArray, largest: FloatArray) -> FloatArray:
        """The normal force in N."""
        return np.asarray(self.line(largest).force(self.line_depth(d, largest)) * self.wall(d))

    def stiffness(self, d: FloatArray, largest: FloatArray) -> FloatArray:
        """The stiffness dF/dd in N/m of unloading and reloading."""
        a, force = self.contact_radius(d, largest), self.force(d, largest)
        return np.asarray(
            2.0 * self.modulus * a / self.scale(largest) * self.wall(d) + self.wall_rate(d) * force
        )

    def elastic_energy(self, d: FloatArray, largest: FloatArray) -> FloatArray:
        """The energy in J that unloading returns."""
        d, largest = np.broadcast_arrays(np.asarray(d, dtype=float), np.asarray(largest, dtype=float))
        stored = self.scale(largest) * self.line(largest).energy(self.line_depth(d, largest))
        if self.walled:
            start = self.residual(largest)
            t, weights = gauss(_NODES)
            # d = start + length t^2, because the force begins like a power of d
            length = np.maximum(d - start, 0.0)[..., None]
            at = start[..., None] + length * t * t
            extra = self.line(largest[..., None]).force(self.line_depth(at, largest[..., None])) * (
                self.wall(at) - 1.0
            )
            stored = stored + (extra * 2.0 * length * t) @ weights
        return np.asarray(stored)

    def loading_force(self, d: FloatArray) -> FloatArray:
        """The force in N of the first loading."""
        return self.force(d, np.maximum(d, 0.0))

    def loading_work(self, d: FloatArray) -> FloatArray:
        """The work in J of the first loading up to indentations in m."""
        d = np.maximum(np.asarray(d, dtype=float), 0.0)
        elastic = np.minimum(d, min(self.yield_depth, DEEPEST * self.radius))
        work = self.elastic_energy(elastic, np.nextafter(elastic, 0.0))
        t, weights = gauss(_OF_LOADING)
        for low, high in itertools.pairwise((*self.knots, math.inf)):
            length = np.clip(d - low, 0.0, high - low)[..., None]
            at = low + length * t
            square, pressure = self._contact_of(at)
            pressed = math.pi * square * pressure * self.wall(at)
            # row by row: products of matrices round equal rows differently
            work = work + (length * pressed * weights).sum(axis=-1)
        return np.asarray(work)

    def dissipation(self, largest: FloatArray) -> FloatArray:
        """The energy in J dissipated by yielding up to largest indentations in m."""
        largest = np.asarray(largest, dtype=float)
        dissipated = self.loading_work(largest) - self.elastic_energy(largest, largest)
        return np.where(self.yielded(largest) > 0.0, dissipated, 0.0)

    def follow(
        self, control: FloatArray, compliance: float | None, largest: float
    ) -> tuple[FloatArray, FloatArray]:
        """
        Indentations and largest indentations under a prescribed force or travel.

        Parameters
        ----------
        control : ndarray
            Forces in N, at least 0, or travels d + compliance F in m, row by row.
        compliance : float or None
            Of the machine in m/N; None for prescribed forces.
        largest : float
            The largest indentation in m before.

        Returns
        -------
        indentation, largest : ndarray
            In m; inf where 0.9 R does not suffice.
        """

        def channel(d: FloatArray, most: FloatArray) -> FloatArray:
            force = self.force(d, most)
            return force if compliance is None else d + compliance * force

        def loading(d: FloatArray) -> FloatArray:
            return channel(d, np.maximum(d, 0.0))

        # force and travel rise with the indentation on the first loading: its largest value gives the largest indentation
        top = np.array([DEEPEST * self.radius])
        peaks = np.maximum.accumulate(control)
        extended = np.maximum(peaks, float(loading(np.array([largest]))[0]))
        known = extended <= float(loading(top)[0])
        most = np.full(control.shape, math.inf)
        most[known] = largest
        new = known & (peaks > float(loading(np.array([largest]))[0]))
        if new.any():
            levels, which = np.unique(peaks[new], return_inverse=True)
            most[new] = rising_root(loading, levels, max(largest, 0.0), top[0])[which]
        depth = np.full(control.shape, math.inf)
        if known.any():
            m, target = most[known], control[known]
            low = self.residual(m) if compliance is None else np.minimum(self.residual(m), target)
            full = channel(m, m)
            below = target < full
            d = m.copy()
            if below.any():
                one, sought = m[below], target[below]
                d[below] = roots_of(lambda x, y, m: channel(x, m) - y, low[below], one, sought, one)
            depth[known] = d
        return depth, most
