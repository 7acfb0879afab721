"""The ball whose apparent radius grows with its plastic volume, in the steps of a particle code."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy

from pymdr.errors import ConvergenceError
from pymdr.line.plastic.ball import DEEPEST, ApparentRadius, Ball, lift, wall_factor, yield_pressure
from pymdr.line.plastic.ellipse import ellipse_force
from pymdr.units import metres

_WINDOW = 10
"""Steps over which the growth of the radius is averaged."""
_TURNS = 200
_DECAY, _PART, _TERMS = 4.4, 0.02, 24
"""Of the pressure at yield over the indentation; longest step over R, and degree of the series, of the growth in the limit of many steps."""


class Row(NamedTuple):
    """One step."""

    indentation: float
    """In m."""
    force: float
    """In N."""
    apparent_radius: float
    """In m."""
    height: float
    """A in m of the line."""
    width: float
    """B in m of the line."""
    line_depth: float
    """Indentation in m of the line."""
    scale: float
    """Indentation per indentation of the line."""
    residual: float
    """Indentation in m at which the force vanishes."""
    yielding: bool
    """Whether the ball yields in this step."""


@dataclass(frozen=True)
class Growth:
    """The state after a step."""

    radius: float
    """Apparent radius in m."""
    mean_growth: float = 0.0
    """Moving mean of the growth of the radius in m."""
    indentation: float = 0.0
    """In m, of the ball of the initial radius."""
    largest: float = 0.0
    """Largest indentation in m of the apparent ball."""
    yielded_at: float = math.nan
    """c = d_Y^2 - d_Y R in m^2, fixed in the step of first yield; NaN before."""
    volume_strain: float = 0.0
    """Elastic volume strain of the last step."""
    plastic_volume: float = 0.0
    """Volume in m^3 that the last step displaced."""
    rim: float = 0.0
    """Area in m^2 by which the volume makes the radius grow."""
    areas: tuple[float, float] = (0.0, 0.0)
    """Contact area in m^2, and its excess over the area of the cap."""
    force: float = 0.0
    """In N."""
    work: float = 0.0
    """Work in J by the trapezoidal rule over the steps."""


@dataclass(frozen=True)
class GrowingBall:
    """
    A ball that yields, of a growing apparent radius (Zunker and Kamrin 2024, part II).

    The volume that yields in a step moves to the free surface: the radius R grows by
    dR = max(0, w (V_p - dV_e) / (2 pi R (d + R - R_0) - 4 pi R^2)), w = 1 / (1 + exp(-75 (psi - 0.2))), where psi is the free
    fraction of the surface, V_p = -pi dd (2 d R_0 - d^2 + R^2 - R_0^2) and dV_e the change of the elastic volume V_0 F (R_0 - d) /
    (3 K V). The growth is averaged over ten steps.
    """

    ball: Ball
    """The ball of the initial radius."""

    @property
    def start(self) -> Growth:
        """The state before the first touch."""
        return Growth(self.ball.radius)

    def advance(self, state: Growth, d: float) -> tuple[Row, Growth]:
        """One step to an indentation d in m of the ball of the initial radius."""
        state = self._grown(state)
        own, radius, first = self.ball, state.radius, self.ball.radius
        depth = d + state.radius - first
        largest = max(state.largest, depth)
        advancing = depth >= state.largest
        constant = state.yielded_at
        if math.isnan(constant) and advancing and depth > 0.0:
            pressure = 4.0 * own.modulus * math.sqrt(depth) / (3.0 * math.pi * math.sqrt(radius))
            if pressure > yield_pressure(own.strength, largest / radius):
                constant = math.pi * (depth**2 - depth * radius)
        height, width, offset, scale = line_of(own, radius, largest, constant)
        within = (depth - offset) / scale
        bare = ellipse_force(height, width, own.modulus, within)
        force = bare
        if self.ball.walled:
            force = bare * float(wall_factor(d, first))
        yielding = advancing and not math.isnan(constant) and bare > 0.0
        residual = offset - (radius - first)
        row = Row(d, force, radius, height, width, within, scale, residual, yielding)
        strain = bare * (first - d) * (1.0 - 2.0 * own.poisson) / (2.0 * own.shear * (1.0 + own.poisson))
        strain = -strain / (4.0 / 3.0 * math.pi * first**3 * (1.0 + state.volume_strain))
        pressed = max(d, 0.0) - max(state.indentation, 0.0)  # a way apart displaces nothing and takes no work
        area = depth * radius if math.isnan(constant) else depth * (2.0 * radius - depth)
        area = max(math.pi * area + (0.0 if math.isnan(constant) else constant), 0.0)
        after = replace(
            state,
            indentation=d,
            largest=largest,
            yielded_at=constant,
            volume_strain=strain,
            plastic_volume=0.0,
            rim=0.0,
            areas=(area, area - 2.0 * math.pi * radius * largest),
            force=force,
            work=state.work + 0.5 * (force + state.force) * pressed,
        )
        if yielding:
            volume = 4.0 / 3.0 * math.pi * first**3 * (state.volume_strain - strain)
            swept = d * (2.0 * first - d) + (radius - first) * (radius + first)
            volume -= math.pi * pressed * swept
            after = replace(after, plastic_volume=volume, rim=2.0 * math.pi * radius * depth)
        return row, after

    def advance_to(
        self, state: Growth, target: float, channel: Callable[[Row], float], low: float
    ) -> tuple[Row, Growth] | None:
        """One step to a force or travel, above `low` in m; None if 0.9 R does not suffice."""
        top = DEEPEST * self.ball.radius

        def missing(d: float) -> float:
            return channel(self.advance(state, d)[0]) - target

        if missing(top) < 0.0:
            return None
        # begin where the force vanishes, not above it
        residual = self.advance(state, low)[0].residual
        begin = min(low, residual)
        if missing(begin) >= 0.0:
            return self.advance(state, residual if target == 0.0 else begin)
        start = max(begin, min(state.indentation, top))
        ends = (start, top) if missing(start) < 0.0 else (begin, start)
        d, info = scipy.optimize.brentq(
            missing, *ends, xtol=1e-15 * self.ball.radius, rtol=1e-14, maxiter=_TURNS, full_output=True
        )
        if not info.converged:
            raise ConvergenceError(
                f"the search for the indentation at the prescribed force or travel did not converge (last value {metres(float(d))}); prescribe the indentation"
            )
        return self.advance(state, float(d))

    def _grown(self, state: Growth) -> Growth:
        """The state with the growth of the radius by the last step."""
        if state.plastic_volume == 0.0 and state.rim == 0.0:
            return state
        sphere = 4.0 * math.pi * state.radius**2
        contact, excess = state.areas
        whole = sphere + excess
        free = (whole - contact) / whole
        weight = 1.0 / (1.0 + math.exp(-75.0 * (free - 0.2)))
        growth = max(state.plastic_volume / (state.rim - sphere) * weight, 0.0)
        if growth == 0.0:
            return state
        mean = state.mean_growth + (growth - state.mean_growth) / _WINDOW
        return replace(state, radius=state.radius + mean, mean_growth=mean)


def with_growth(ball: Ball) -> Ball:
    """
    The ball whose apparent radius grows as that of :class:`GrowingBall` does in the limit of many steps of loading.

    With u = R_0 - d the elastic volume strain s = -q / (1 + s), q = pi a^2 p_Y u (1 - 2 nu) / (2 G (1 + nu) V_0), and the growth
    dR = max(0, w (V_0 ds + pi (R^2 - u^2) dd) / (2 pi R (R + u))) is an equation for R(d).
    """
    first, depth = ball.radius, ball.yield_depth
    if math.isinf(depth):
        return ball
    volume = 4.0 / 3.0 * math.pi * first**3
    bulk = (1.0 - 2.0 * ball.poisson) / (2.0 * ball.shear * (1.0 + ball.poisson) * volume)
    constant = depth * (depth - first)

    def rate(m: float, radius: float) -> float:
        u = first - m
        square = (radius - u) * (radius + u) + constant
        pressure = float(yield_pressure(ball.strength, 1.0 - u / radius))
        slope = -_DECAY * (pressure - ball.strength)
        # derivatives of q with d and with R
        rest = bulk * math.pi * u
        by_depth = rest * (2.0 * u * pressure + square * slope / radius) - bulk * math.pi * square * pressure
        by_radius = rest * (2.0 * radius * pressure + square * slope * u / radius**2)
        elastic = volume / math.sqrt(1.0 - 4.0 * rest * square * pressure)
        free = 2.0 * radius * (radius + u)
        weight = 1.0 / (1.0 + math.exp(-75.0 * (free / (free + square) - 0.2)))
        swept = math.pi * (radius - u) * (radius + u)
        growth = weight * (swept - elastic * by_depth)
        return growth / (math.pi * free + weight * elastic * by_radius)

    # the change of the elastic volume exceeds the volume that yields at first
    end = DEEPEST * first
    if rate(end, first) <= 0.0:
        return ball
    onset = depth
    if rate(depth, first) < 0.0:
        onset = float(scipy.optimize.brentq(rate, depth, end, (first,), xtol=1e-15 * first))
    solved = scipy.integrate.solve_ivp(
        lambda m, radii: [max(rate(m * first, float(radii[0]) * first), 0.0)],
        (onset / first, DEEPEST),
        [1.0],
        method="DOP853",
        rtol=1e-13,
        atol=1e-14,
        max_step=_PART,
        dense_output=True,
    )
    series = np.polynomial.chebyshev.chebinterpolate(
        lambda x: first * solved.sol(0.5 * (onset / first + DEEPEST + (DEEPEST - onset / first) * x))[0],
        _TERMS,
    )
    return replace(ball, grown=ApparentRadius(first, onset, series))


def line_of(ball: Ball, radius: float, largest: float, constant: float) -> tuple[float, float, float, float]:
    """Height and width of the line, the indentation at which its force vanishes, and the scale of its indentation; `constant` is NaN before yield."""
    if math.isnan(constant):
        return 4.0 * radius, 2.0 * radius, 0.0, 1.0
    pressure = float(yield_pressure(ball.strength, largest / radius))
    a = math.sqrt(2.0 * largest * radius - largest**2 + constant / math.pi)
    half = 2.0 * pressure * a / ball.modulus
    lifted = float(lift(pressure, a, radius - (largest - half), ball.poisson, ball.shear))
    return 2.0 * half, 2.0 * a, largest - half - lifted, 1.0 + lifted / half
