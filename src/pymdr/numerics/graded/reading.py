"""Compiled reader of graded tables. Loads numba."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pymdr import compiling
from pymdr.numerics.graded import layout
from pymdr.numerics.newton import narrowed
from pymdr.units import FloatArray

_fused = compiling.Fused(__file__)


@_fused.inlined
def entry_of(rows: FloatArray, first: float, entry: Any) -> float:
    """An entry of a look-up that begins at a row."""
    row = int(first) + entry // layout.PER_ROW
    return float(rows[np.uint64(row), np.uint64(entry % layout.PER_ROW)])


@_fused.merged
def segment_of(rows: FloatArray, x: float) -> int:
    """Row of the segment of an argument."""
    key = np.float64(x).view(np.int64) >> int(rows[0, layout.LOOKUP_SHIFT])
    key -= int(rows[0, layout.LOOKUP_LOWEST])
    first = rows[0, layout.LOOKUP]
    low, high = int(entry_of(rows, first, key)), int(entry_of(rows, first, key + 1))
    while low < high:
        middle = (low + high + 1) >> 1
        if x >= rows[np.uint64(middle), layout.ORIGIN]:
            low = middle
        else:
            high = middle - 1
    return low


@_fused.merged
def power_panel(rows: FloatArray, row: Any, offset: float) -> tuple[float, float, float]:
    """F = b + c z^q and its integrals."""
    c = rows[row, layout.C]
    grown = (offset * rows[row, layout.PER_WIDTH]) ** rows[row, layout.Q] if c > 0.0 else 0.0
    rise = offset * (rows[row, layout.INTEGRAL_B] + rows[row, layout.INTEGRAL_C] * grown)
    second = rows[row, layout.INTEGRAL] + offset * (
        rows[row, layout.SECOND_B] + rows[row, layout.SECOND_C] * grown
    )
    return (
        rows[row, layout.B] + c * grown,
        rows[row, layout.INTEGRAL] + rise,
        rows[row, layout.SECOND] + offset * second,
    )


@_fused.inlined
def read(rows: FloatArray, x: float) -> tuple[float, float, float]:
    """f, its integral and its second integral at x > 0; NaN above the largest argument."""
    largest = rows[0, layout.MAX]
    if not x <= largest:
        if not x <= largest * (1.0 + 1e-14):
            return math.nan, math.nan, math.nan
        x = largest
    segment = np.uint64(layout.SEGMENT)
    if x >= rows[0, layout.FIRST_MARK]:
        segment = np.uint64(segment_of(rows, x))
    offset = x - rows[segment, layout.ORIGIN]
    word = np.float64(offset).view(np.int64)
    key: Any = (word >> layout.DROPPED) - int(rows[segment, layout.LOWEST])
    t = np.int64(((word << layout.BITS) & layout.MANTISSA) | layout.ONE).view(np.float64) - 1.0
    if key < 0:
        key = -1
        t = offset * rows[segment, layout.PER_INNERMOST]
    panel = np.uint64(int(rows[segment, layout.FIRST]) + key)
    kind = rows[panel, layout.KIND]
    while kind != layout.POLYNOMIAL:
        if kind == layout.POWER:
            return power_panel(rows, panel, offset)
        t *= rows[panel, layout.PARTS]
        part = int(t)
        t -= part
        panel = np.uint64(int(rows[panel, layout.CHILD]) + part)
        kind = rows[panel, layout.KIND]
    t2 = t * t
    t4 = t2 * t2
    f = (rows[panel, 1] + t * rows[panel, 2]) + t2 * (rows[panel, 3] + t * rows[panel, 4])
    f += t4 * ((rows[panel, 5] + t * rows[panel, 6]) + t2 * (rows[panel, 7] + t * rows[panel, 8]))
    t8 = t4 * t4
    first = (rows[panel, 9] + t * rows[panel, 10]) + t2 * (rows[panel, 11] + t * rows[panel, 12])
    first += t4 * ((rows[panel, 13] + t * rows[panel, 14]) + t2 * (rows[panel, 15] + t * rows[panel, 16]))
    first += t8 * rows[panel, 17]
    second = (rows[panel, 18] + t * rows[panel, 19]) + t2 * (rows[panel, 20] + t * rows[panel, 21])
    second += t4 * ((rows[panel, 22] + t * rows[panel, 23]) + t2 * (rows[panel, 24] + t * rows[panel, 25]))
    second += t8 * (rows[panel, 26] + t * rows[panel, 27])
    return f, first, second


@_fused.inner
def inverse(rows: FloatArray, integral: float) -> float:
    """X > 0 with a given integral > 0; NaN above the integral up to the largest argument."""
    full: float = rows[0, layout.FULL_INTEGRAL]
    if integral >= full:
        return float(rows[0, layout.MAX]) if integral <= full * (1.0 + 2e-14) else math.nan
    inner: float = rows[0, layout.INNER_INTEGRAL]
    low: float = 0.0
    high: float = rows[0, layout.MAX]
    if integral < inner:
        panel = np.uint64(int(rows[layout.SEGMENT, layout.FIRST]) - 1)
        high = 1.0 / rows[panel, layout.PER_WIDTH]
        if rows[panel, layout.B] == 0.0:
            return float(high * (integral / inner) ** (1.0 / (1.0 + rows[panel, layout.Q])))
        x = min(integral / rows[panel, layout.INTEGRAL_B], high)
    else:
        word = np.float64(integral).view(np.int64)
        entry = (word >> layout.DROPPED) - (np.float64(inner).view(np.int64) >> layout.DROPPED)
        first = rows[0, layout.NEAR]
        near = entry_of(rows, first, entry)
        t = np.int64(((word << layout.BITS) & layout.MANTISSA) | layout.ONE).view(np.float64) - 1.0
        x = min(near + t * (entry_of(rows, first, entry + 1) - near), high)
    for _ in range(200):  # convex: Newton from above; halve where rounding or a step of f spoils it
        f, here, _second = read(rows, x)
        slope = rows[0, layout.FACTOR] * f
        if here == integral:
            return float(x)
        still = abs(here - integral) <= 2e-16 * x * slope
        # below a step of f the slopes from above are far too steep
        if still and abs(here - integral) <= 2e-15 * integral:
            return float(x - (here - integral) / slope)
        low, high, x = narrowed(low, high, x, here - integral, 0.0 if still else slope)
        if not low < x < high:
            return float(x)
    return float(x)
