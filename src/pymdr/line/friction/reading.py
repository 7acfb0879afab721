"""Compiled reading of the curves, and how kernels are compiled. Loads numba."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numba import types
from numba.extending import intrinsic

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
from pymdr.units import FloatArray

_DROPPED = 52 - BITS
_MANTISSA, _ONE = (1 << 52) - 1, 1023 << 52

Function = TypeVar("Function", bound=Callable[..., Any])


_STAMP = compiling.stamp_of(__file__)


def compiled(function: Function, **options: Any) -> Function:
    """Compile with numba when first called; kept on disk. Products and sums may be fused, nothing else."""
    return compiling.compiled(function, _STAMP, fastmath={"contract"}, **options)


def inlined(function: Function) -> Function:
    """Compile into the callers: a call with arrays costs more than a short kernel."""
    return compiled(function, forceinline=True)


def _intrinsics() -> tuple[Any, Any, Any]:
    """
    An array without its owner, the bits of a float as an integer, and the float that has the bits of an integer.

    Counting references of an array costs a fifth of a step of the stack; where numba does not show how to leave it
    out, or compiles nothing, it is counted. Only arrays that the caller holds for as long as the result is used lose
    their owner.
    """
    if compiling.INTERPRETED:
        return (
            lambda array: array,
            lambda value: int(np.float64(value).view(np.int64)),
            lambda value: float(np.int64(value).view(np.float64)),
        )

    def bits(typing_context: Any, value: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.bitcast(arguments[0], context.get_value_type(types.int64))

        return types.int64(types.float64), generate

    def number(typing_context: Any, value: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.bitcast(arguments[0], context.get_value_type(types.float64))

        return types.float64(types.int64), generate

    try:
        from numba.core.cgutils import get_null_value
        from numba.np.arrayobj import make_array
    except ImportError:
        return compiled(lambda array: array), intrinsic(bits), intrinsic(number)

    def owned_by_caller(typing_context: Any, array: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            view = make_array(signature.args[0])(context, builder, arguments[0])
            view.meminfo = get_null_value(view.meminfo.type)
            return view._getvalue()

        return array(array), generate

    return intrinsic(owned_by_caller), intrinsic(bits), intrinsic(number)


borrowed, bits_of, float_of = _intrinsics()


@inlined
def entry_of(line: FloatArray, rows: int, entry: int) -> float:
    """One of the numbers that fill the rows to which the first row points."""
    return float(line[np.uint64(bits_of(line[0, rows]) + entry // PER_ROW), np.uint64(entry % PER_ROW)])


@compiled
def segment_of(line: FloatArray, y: float) -> int:
    """Row of the segment of a table to which a depth belongs."""
    key = (bits_of(y) >> bits_of(line[0, LOOKUP_SHIFT])) - bits_of(line[0, LOOKUP_LOWEST])
    low, high = bits_of(entry_of(line, LOOKUP, key)), bits_of(entry_of(line, LOOKUP, key + 1))
    while low < high:
        middle = (low + high + 1) >> 1
        if y >= line[np.uint64(middle), ORIGIN]:
            low = middle
        else:
            high = middle - 1
    return int(low)


@compiled
def closed(line: FloatArray, row: Any, offset: float) -> tuple[float, float, float]:
    """a, F_N, W where a table is closed by b + c z^q."""
    c = line[row, C]
    grown = (offset * line[row, PER_WIDTH]) ** line[row, Q] if c > 0.0 else 0.0
    rise = offset * (line[row, FORCE_B] + line[row, FORCE_C] * grown)
    work = line[row, FORCE] + offset * (line[row, WORK_B] + line[row, WORK_C] * grown)
    return line[row, B] + c * grown, line[row, FORCE] + rise, line[row, WORK] + offset * work


@inlined
def curve(line: FloatArray, y: float) -> tuple[float, float, float]:
    """Return a, F_N, W at one depth; NaN below a table."""
    if y <= 0.0:
        return 0.0, 0.0, 0.0
    n = line[0, EXPONENT]
    if n > 0.0:
        z = y * line[0, PER_COEFFICIENT]
        if n == 2.0:
            a = math.sqrt(z)
        elif n == 1.0:
            a = z
        else:
            a = z ** line[0, INVERSE]
        a *= line[0, UNIT]
        force = line[0, FORCE_FACTOR] * a * y
        return a, force, line[0, WORK_FACTOR] * force * y
    reach = line[0, REACH]
    if not y <= reach:
        if not y <= reach * (1.0 + 1e-14):
            return math.nan, math.nan, math.nan
        y = reach
    segment = np.uint64(SEGMENT)
    if y >= line[0, FIRST_MARK]:
        segment = np.uint64(segment_of(line, y))
    offset = y - line[segment, ORIGIN]
    word = bits_of(offset)
    key = (word >> _DROPPED) - bits_of(line[segment, LOWEST])
    t = float_of(((word << BITS) & _MANTISSA) | _ONE) - 1.0
    if key < 0:
        key = -1
        t = offset * line[segment, PER_FLOOR]
    piece = np.uint64(bits_of(line[segment, FIRST]) + key)
    kind = bits_of(line[piece, KIND])
    while kind != PIECE:
        if kind == CLOSED:
            return closed(line, piece, offset)
        t *= line[piece, PARTS]
        part = int(t)
        t -= part
        piece = np.uint64(bits_of(line[piece, CHILD]) + part)
        kind = bits_of(line[piece, KIND])
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
        a, f = curve(line, y)[:2]
        return y - (f - force) / (2.0 * modulus * a)
    full: float = line[0, FULL_FORCE]
    if force >= full:
        return line[0, REACH] if force <= full * (1.0 + 2e-14) else math.nan
    lowest: float = line[0, FLOOR_FORCE]
    low: float = 0.0
    high: float = line[0, REACH]
    if force < lowest:
        floor = np.uint64(bits_of(line[SEGMENT, FIRST]) - 1)
        high = 1.0 / line[floor, PER_WIDTH]
        if line[floor, B] == 0.0:
            return float(high * (force / lowest) ** (1.0 / (1.0 + line[floor, Q])))
        y = min(force / line[floor, FORCE_B], high)
    else:
        word = bits_of(force)
        entry = (word >> _DROPPED) - (bits_of(lowest) >> _DROPPED)
        near = entry_of(line, NEAR, entry)
        t = float_of(((word << BITS) & _MANTISSA) | _ONE) - 1.0
        y = min(near + t * (entry_of(line, NEAR, entry + 1) - near), high)
    for _ in range(200):  # F_N is convex: Newton from above; halve where rounding or a step of a(d) spoil it
        a, f = curve(line, y)[:2]
        if f > force:
            high = y
        elif f < force:
            low = y
        else:
            return y
        step = y - (f - force) / (2.0 * modulus * a)
        still = abs(step - y) <= 2e-16 * y
        if (
            still and abs(f - force) <= 2e-15 * force
        ):  # below a step of a(d) slopes from above are far too steep
            return step
        if still or not low < step < high:
            step = 0.5 * (low + high)
            if not low < step < high:
                return step
        y = step
    return y
