"""Compiled reading of the curves. Loads numba."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pymdr import compiling
from pymdr.line.friction.layout import (
    BITS,
    CHILD,
    CLOSED,
    EXPONENT,
    FIRST,
    FIRST_MARK,
    FLOOR_FORCE,
    FORCE,
    FORCE_B,
    FORCE_C,
    FORCE_FACTOR,
    FULL_FORCE,
    INVERSE,
    KIND,
    LOOKUP,
    LOOKUP_LOWEST,
    LOOKUP_SHIFT,
    LOWEST,
    MODULUS,
    NEAR,
    ORIGIN,
    PARTS,
    PER_COEFFICIENT,
    PER_FLOOR,
    PER_ROW,
    PER_WIDTH,
    PIECE,
    REACH,
    SEGMENT,
    UNIT,
    WORK,
    WORK_B,
    WORK_C,
    WORK_FACTOR,
    B,
    C,
    Q,
)
from pymdr.numerics.newton import narrowed
from pymdr.units import FloatArray

_DROPPED = 52 - BITS
_MANTISSA, _ONE = (1 << 52) - 1, 1023 << 52

_STAMP = compiling.stamp_of(__file__)


def compiled(function: compiling.Function, **options: Any) -> compiling.Function:
    """Compile with numba when first called; kept on disk. Products and sums may be fused, nothing else."""
    return compiling.compiled(function, _STAMP, fastmath={"contract"}, **options)


def inlined(function: compiling.Function) -> compiling.Function:
    """Compile into the callers, for the shortest: a call with arrays costs more than they do."""
    return compiled(function, forceinline=True, **compiling.INNER)


@inlined
def entry_of(line: FloatArray, first: float, entry: Any) -> float:
    """One of the numbers that fill the rows from the first one on."""
    row = int(first) + entry // PER_ROW
    return float(line[np.uint64(row), np.uint64(entry % PER_ROW)])


@inlined
def segment_of(line: FloatArray, y: float) -> int:
    """Row of the segment of a table to which a depth belongs."""
    key = np.float64(y).view(np.int64) >> int(line[0, LOOKUP_SHIFT])
    key -= int(line[0, LOOKUP_LOWEST])
    first = line[0, LOOKUP]
    low, high = int(entry_of(line, first, key)), int(entry_of(line, first, key + 1))
    while low < high:
        middle = (low + high + 1) >> 1
        if y >= line[np.uint64(middle), ORIGIN]:
            low = middle
        else:
            high = middle - 1
    return low


@inlined
def closed(line: FloatArray, row: Any, offset: float) -> tuple[float, float, float]:
    """a, F_N, W where a table is closed by b + c z^q."""
    c = line[row, C]
    grown = (offset * line[row, PER_WIDTH]) ** line[row, Q] if c > 0.0 else 0.0
    rise = offset * (line[row, FORCE_B] + line[row, FORCE_C] * grown)
    work = line[row, FORCE] + offset * (line[row, WORK_B] + line[row, WORK_C] * grown)
    return line[row, B] + c * grown, line[row, FORCE] + rise, line[row, WORK] + offset * work


@inlined
def from_table(line: FloatArray, y: float) -> tuple[float, float, float]:
    """a, F_N, W of a table at a depth above 0."""
    reach = line[0, REACH]
    if not y <= reach:
        if not y <= reach * (1.0 + 1e-14):
            return math.nan, math.nan, math.nan
        y = reach
    segment = np.uint64(SEGMENT)
    if y >= line[0, FIRST_MARK]:
        segment = np.uint64(segment_of(line, y))
    offset = y - line[segment, ORIGIN]
    word = np.float64(offset).view(np.int64)
    key: Any = (word >> _DROPPED) - int(line[segment, LOWEST])
    t = np.int64(((word << BITS) & _MANTISSA) | _ONE).view(np.float64) - 1.0
    if key < 0:
        key = -1
        t = offset * line[segment, PER_FLOOR]
    piece = np.uint64(int(line[segment, FIRST]) + key)
    kind = line[piece, KIND]
    while kind != PIECE:
        if kind == CLOSED:
            return closed(line, piece, offset)
        t *= line[piece, PARTS]
        part = int(t)
        t -= part
        piece = np.uint64(int(line[piece, CHILD]) + part)
        kind = line[piece, KIND]
    t2 = t * t
    t4 = t2 * t2
    a = (line[piece, 1] + t * line[piece, 2]) + t2 * (line[piece, 3] + t * line[piece, 4])
    a += t4 * ((line[piece, 5] + t * line[piece, 6]) + t2 * (line[piece, 7] + t * line[piece, 8]))
    t8 = t4 * t4
    force = (line[piece, 9] + t * line[piece, 10]) + t2 * (line[piece, 11] + t * line[piece, 12])
    force += t4 * ((line[piece, 13] + t * line[piece, 14]) + t2 * (line[piece, 15] + t * line[piece, 16]))
    force += t8 * line[piece, 17]
    work = (line[piece, 18] + t * line[piece, 19]) + t2 * (line[piece, 20] + t * line[piece, 21])
    work += t4 * ((line[piece, 22] + t * line[piece, 23]) + t2 * (line[piece, 24] + t * line[piece, 25]))
    work += t8 * (line[piece, 26] + t * line[piece, 27])
    return a, force, work


@inlined
def from_radius(line: FloatArray, y: float, ratio: float) -> tuple[float, float, float]:
    """a, F_N, W of a power law at a depth, from a over its unit."""
    a = line[0, UNIT] * ratio
    force = line[0, FORCE_FACTOR] * a * y
    return a, force, line[0, WORK_FACTOR] * force * y


@inlined
def curve(line: FloatArray, y: float) -> tuple[float, float, float]:
    """Return a, F_N, W at one depth; NaN below a table."""
    # numba counts references to an array where branches meet again: every branch returns
    if y <= 0.0:
        return 0.0, 0.0, 0.0
    if line[0, EXPONENT] <= 0.0:
        return from_table(line, y)
    per_length = y * line[0, PER_COEFFICIENT]
    if line[0, EXPONENT] == 2.0:
        return from_radius(line, y, math.sqrt(per_length))
    return from_radius(line, y, per_length ** line[0, INVERSE])


@compiled
def depth_of_force(line: FloatArray, force: float) -> float:
    """Depth d with F_N(d) = force, NaN if there is none."""
    n: float = line[0, EXPONENT]
    modulus: float = line[0, MODULUS]
    if not force > 0.0:
        return 0.0 if force == 0.0 else math.nan
    if n > 0.0:
        per_radius: float = line[0, PER_COEFFICIENT] ** -line[0, INVERSE] / line[0, UNIT]
        y: float = (force / line[0, FORCE_FACTOR] * per_radius) ** (n / (n + 1.0))
        a, f, _work = curve(line, y)
        return y - (f - force) / (2.0 * modulus * a)
    full: float = line[0, FULL_FORCE]
    if force >= full:
        return line[0, REACH] if force <= full * (1.0 + 2e-14) else math.nan
    lowest: float = line[0, FLOOR_FORCE]
    low: float = 0.0
    high: float = line[0, REACH]
    if force < lowest:
        floor = np.uint64(int(line[SEGMENT, FIRST]) - 1)
        high = 1.0 / line[floor, PER_WIDTH]
        if line[floor, B] == 0.0:
            return float(high * (force / lowest) ** (1.0 / (1.0 + line[floor, Q])))
        y = min(force / line[floor, FORCE_B], high)
    else:
        word = np.float64(force).view(np.int64)
        entry = (word >> _DROPPED) - (np.float64(lowest).view(np.int64) >> _DROPPED)
        first = line[0, NEAR]
        near = entry_of(line, first, entry)
        t = np.int64(((word << BITS) & _MANTISSA) | _ONE).view(np.float64) - 1.0
        y = min(near + t * (entry_of(line, first, entry + 1) - near), high)
    for _ in range(200):  # F_N is convex: Newton from above; halve where rounding or a step of a(d) spoil it
        a, f, _work = curve(line, y)
        slope = 2.0 * modulus * a
        if f == force:
            return y
        still = abs(f - force) <= 2e-16 * y * slope
        # below a step of a(d) slopes from above are far too steep
        if still and abs(f - force) <= 2e-15 * force:
            return y - (f - force) / slope
        low, high, y = narrowed(low, high, y, f - force, 0.0 if still else slope)
        if not low < y < high:
            return y
    return y
