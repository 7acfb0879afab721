"""Compiled single steps of a ball that yields, without adhesion. Loads numba."""

from __future__ import annotations

import math

from pymdr.compiling import Fused
from pymdr.line.moved import BEFORE, NOW
from pymdr.line.plastic.ellipse import SLIVER, SMALL
from pymdr.line.plastic.layout import (
    DEPTH,
    FORCE,
    LARGEST,
    MODULUS,
    POISSON,
    RADIUS,
    SHEAR,
    STRENGTH,
    WALLED,
    YIELD_DEPTH,
)
from pymdr.units import FloatArray

_fused = Fused(__file__)


@_fused.inner
def normal_force(ball: FloatArray, d: float, largest: float) -> float:
    """The force in N, as :meth:`~pymdr.line.plastic.ball.Ball.force`."""
    radius, first = ball[RADIUS], ball[YIELD_DEPTH]
    height, width, depth = 4.0 * radius, 2.0 * radius, d
    if largest >= first:
        pressure = ball[STRENGTH] * (1.0 + 1.75 * math.exp(-4.4 * largest / radius))
        square = largest * (2.0 * radius - largest) - first * (radius - first)
        a = math.sqrt(max(square, first * radius))
        half = 2.0 * pressure * a / ball[MODULUS]
        z = radius - largest + half
        far = math.sqrt(a * a + z * z)
        poisson = ball[POISSON]
        lifted = 2.0 * (poisson - 1.0) - (2.0 * poisson - 1.0) * z / (far + z)
        lifted *= pressure * a * a / (2.0 * ball[SHEAR] * far)
        height, width = 2.0 * half, 2.0 * a
        depth = (d - (largest - half - lifted)) / (1.0 + lifted / half)
    twice = 4.0 * math.asin(math.sqrt(min(max(depth / height, 0.0), 0.5)))
    if twice >= SMALL:
        sliver = twice - math.sin(twice)
    else:
        sliver, square = 0.0, twice * twice
        for k in range(len(SLIVER) - 1, -1, -1):
            sliver = sliver * square + SLIVER[k]
        sliver *= twice * square
    force = 0.125 * ball[MODULUS] * height * width * sliver
    if ball[WALLED] > 0.0:
        force *= 1.0 + math.exp(10.7 * d / radius - 10.0)
    return float(force)


@_fused.compiled
def step(ball: FloatArray, memory: FloatArray, depth: float) -> float:
    """
    Go straight to an indentation.

    Parameters
    ----------
    ball : ndarray
        Constants, see :mod:`pymdr.line.plastic.layout`.
    memory : ndarray, shape (2, 6)
        What the contact remembers, now and before the last step.
    depth : float
        In m.

    Returns
    -------
    float
        The force in N.
    """
    for i in range(memory.shape[1]):
        memory[BEFORE, i] = memory[NOW, i]
    now = memory[NOW]
    now[DEPTH], now[LARGEST] = depth, max(now[LARGEST], depth)
    now[FORCE] = normal_force(ball, depth, now[LARGEST])
    return float(now[FORCE])


@_fused.compiled
def step_all(
    ball: FloatArray, memory: FloatArray, depth: FloatArray, force: FloatArray, some: tuple[int, int]
) -> None:
    """Steps of the contacts from one up to another, as :func:`step`; the forces in N are written."""
    for i in range(some[0], some[1]):
        force[i] = step(ball, memory[i], depth[i])
