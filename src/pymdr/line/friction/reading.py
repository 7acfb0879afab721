"""Compiled reading of the curves. Loads numba."""

from __future__ import annotations

import math

from pymdr import compiling
from pymdr.line.friction import layout
from pymdr.numerics.graded import reading as table
from pymdr.units import FloatArray

fused = compiling.Fused(__file__)
"""Compiles the kernels of friction, into which the reader of tables is compiled."""


@fused.inlined
def from_radius(line: FloatArray, y: float, ratio: float) -> tuple[float, float, float]:
    """a, F_N, W of a power law at a depth, from a over its unit."""
    a = line[0, layout.UNIT] * ratio
    force = line[0, layout.FORCE_FACTOR] * a * y
    return a, force, line[0, layout.WORK_FACTOR] * force * y


@fused.inlined
def curve(line: FloatArray, y: float) -> tuple[float, float, float]:
    """a, F_N, W at one depth; NaN below a table."""
    if y <= 0.0:
        return 0.0, 0.0, 0.0
    if line[0, layout.EXPONENT] <= 0.0:
        return table.read(line, y)
    per_length = y * line[0, layout.PER_COEFFICIENT]
    if line[0, layout.EXPONENT] == 2.0:
        return from_radius(line, y, math.sqrt(per_length))
    return from_radius(line, y, per_length ** line[0, layout.INVERSE])


@fused.inner
def depth_of_force(line: FloatArray, force: float) -> float:
    """Depth d with F_N(d) = force, NaN if there is none."""
    n: float = line[0, layout.EXPONENT]
    modulus: float = line[0, layout.MODULUS]
    if not force > 0.0:
        return 0.0 if force == 0.0 else math.nan
    if n <= 0.0:
        return table.inverse(line, force)
    per_radius: float = line[0, layout.PER_COEFFICIENT] ** -line[0, layout.INVERSE] / line[0, layout.UNIT]
    y: float = (force / line[0, layout.FORCE_FACTOR] * per_radius) ** (n / (n + 1.0))
    a, f, _work = curve(line, y)
    return y - (f - force) / (2.0 * modulus * a)
