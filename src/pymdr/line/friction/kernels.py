"""Compiled kernels of the memory stack. Imported only when a history is followed: it loads numba.

Normalised shift v = G* u_x / (mu E*) in m, normalised tangential force S = F_x / mu in N. One row of the stack per
vertex (y, b) of the anchor curve: y, b, slope of the segment below, F_N(y), W(y), the force and the energy of
the part of the curve below the vertex, a(y). `window` holds the slopes that the top segment may still take.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias, TypeVar, cast

import numpy as np
from numba import njit
from numba.core.cgutils import get_null_value
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from pymdr.units import FloatArray

# the packed line
MODULUS, EXPONENT, INVERSE, PER_COEFFICIENT, FORCE_FACTOR, WORK_FACTOR, REACH, PER_REACH = range(8)
CHILD, BUCKETS = 0, 256
VERTEX = np.dtype([(name, float) for name in ("y", "b", "slope", "force", "work", "sum", "energy", "radius")])

MERGE = 2.0**-47  # of the coordinates: bends below it are rounding of the input
_SHORT = 1e-2  # likewise for its second difference; two nodes for the weight 1 - t
_SHORT_X = (0.4 - math.sqrt(0.06), 0.4 + math.sqrt(0.06))
_SHORT_W = (0.25 + math.sqrt(6.0) / 36.0, 0.25 - math.sqrt(6.0) / 36.0)
_CLOSE = 1e-4  # below this relative length, W(y2) - W(y1) has lost too many digits
Point: TypeAlias = tuple[float, float, float, float, float]

Function = TypeVar("Function", bound=Callable[..., Any])


# numba keeps compiled code until the file of the outermost function changes; here, until any file of the folder does
_FILES = [file.stat() for file in Path(__file__).parent.glob("*.py")]
_STAMP = (max(file.st_mtime for file in _FILES), sum(file.st_size for file in _FILES))


def compiled(function: Function, **options: Any) -> Function:
    """Compile with numba when first called; kept on disk. Products and sums may be fused, nothing else."""
    kernel = njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"}, **options)(function)
    index: Any = getattr(getattr(kernel, "_cache", None), "_cache_file", None)
    if index is not None and hasattr(index, "_source_stamp"):
        index._source_stamp = _STAMP
    return cast(Function, kernel)


def inlined(function: Function) -> Function:
    """Compile into the callers: a call with arrays costs more than a short kernel."""
    return compiled(function, forceinline=True)


def _borrowed(typing_context: Any, array: Any) -> Any:
    """The same array without its owner: counting references costs more than a step of the stack.

    Only for arrays that the caller holds for as long as the result is used.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        view = make_array(signature.args[0])(context, builder, arguments[0])  # type: ignore[no-untyped-call]
        view.meminfo = get_null_value(view.meminfo.type)  # type: ignore[no-untyped-call]
        return view._getvalue()

    return array(array), generate


borrowed: Any = intrinsic(_borrowed)


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
        force = line[0, FORCE_FACTOR] * a * y
        return a, force, line[0, WORK_FACTOR] * force * y
    x = BUCKETS * math.sqrt(y * line[0, PER_REACH])
    if not x <= BUCKETS * (1.0 + 1e-14):
        return math.nan, math.nan, math.nan
    j = min(int(x), BUCKETS - 1)
    t = x - j
    j += 1
    while line[j, CHILD] > 0.0:
        j = int(line[j, CHILD])
        t *= 2.0
        if t >= 1.0:
            t -= 1.0
            j += 1
    t2 = t * t
    t4 = t2 * t2
    a = (line[j, 1] + t * line[j, 2]) + t2 * (line[j, 3] + t * line[j, 4])
    force = (line[j, 5] + t * line[j, 6]) + t2 * (line[j, 7] + t * line[j, 8])
    force += t4 * (line[j, 9] + t * line[j, 10])
    work = (line[j, 11] + t * line[j, 12]) + t2 * (line[j, 13] + t * line[j, 14])
    work += t4 * ((line[j, 15] + t * line[j, 16]) + t2 * (line[j, 17] + t * line[j, 18]))
    return a, force, work


@compiled
def depth_of_force(line: FloatArray, force: float) -> float:
    """Depth d with F_N(d) = force, NaN if there is none."""
    n: float = line[0, EXPONENT]
    modulus: float = line[0, MODULUS]
    if not force > 0.0:
        return 0.0 if force == 0.0 else math.nan
    if n > 0.0:
        y: float = (force / line[0, FORCE_FACTOR] * line[0, PER_COEFFICIENT] ** -line[0, INVERSE]) ** (
            n / (n + 1.0)
        )
        a, f = curve(line, y)[:2]
        return y - (f - force) / (2.0 * modulus * a)
    low = 0.0
    high: float = line[0, REACH]
    y = high
    a, f = curve(line, y)[:2]
    if force > f:
        return y if force <= f * (1.0 + 1e-14) else math.nan
    for _ in range(200):  # F_N is convex: Newton from above; halve where rounding or a flat start spoil it
        if f == force:
            return y
        if f > force:
            high = y
        else:
            low = y
        step = y - (f - force) / (2.0 * modulus * a) if a > 0.0 else low
        if not low < step < high:
            step = 0.5 * (low + high)
        if abs(step - y) <= 2e-16 * y or not low < step < high:
            return step
        y = step
        a, f = curve(line, y)[:2]
    return y


@inlined
def mean_force(modulus: float, p: Point, q: Point) -> float:
    """Mean of F_N over the depths between two points (y, b, F_N, W, a), p above q in the list."""
    length = q[0] - p[0]
    if length > _CLOSE * q[0]:
        return (q[3] - p[3]) / length
    return 0.5 * (p[2] + q[2]) - modulus * length * (q[4] - p[4]) / 6.0


@inlined
def at(stack: Any, i: int) -> Point:
    """Vertex i as a point."""
    return stack[i].y, stack[i].b, stack[i].force, stack[i].work, stack[i].radius


@compiled
def short_bend(line: FloatArray, low: float, high: float, bend: float, work: float) -> float:
    """int (high - y) dF_N over a short piece, from `bend`, its value as a difference of W that lost digits.

    By quadrature, except where a(d) is not smooth and the two differ by more than what was lost.
    """
    length = high - low
    smooth = 0.0
    for k in range(2):
        a = curve(line, low + _SHORT_X[k] * length)[0]
        smooth += _SHORT_W[k] * a
    smooth *= 2.0 * line[0, MODULUS] * length * length
    return smooth if abs(smooth - bend) <= 1e-15 * work else bend


@inlined
def put(line: FloatArray, stack: Any, i: int, point: Point, slope: float) -> None:
    """Write vertex i > 0 at the end of a segment of the given slope."""
    y, b, force, work, radius = point
    low = stack[i - 1].y
    length = y - low
    below = stack[i - 1].force
    bend = work - stack[i - 1].work - length * below
    if length < _SHORT * y:
        bend = short_bend(line, low, y, bend, work)
    stack[i].y = y
    stack[i].b = b
    stack[i].slope = slope
    stack[i].force = force
    stack[i].work = work
    stack[i].sum = stack[i - 1].sum + slope * (force - below)
    stack[i].energy = stack[i - 1].energy + slope * (length * stack[i - 1].sum + slope * bend)
    stack[i].radius = radius


@inlined
def base(stack: Any, b: float) -> None:
    """Write the vertex at depth 0."""
    stack[0].y = 0.0
    stack[0].b = b
    stack[0].slope = 0.0
    stack[0].force = 0.0
    stack[0].work = 0.0
    stack[0].sum = 0.0
    stack[0].energy = 0.0
    stack[0].radius = 0.0


@inlined
def extend(
    line: FloatArray, stack: Any, m: int, low: float, high: float, point: Point, slope: float, by_force: bool
) -> tuple[int, float, float]:
    """Append a stuck segment, joined to the top one when all its points stay within rounding of a line."""
    if m > 0:
        x, z, x_m, x_b, z_b = point[0], point[1], stack[m].y, stack[m - 1].y, stack[m - 1].b
        if by_force:
            z = stack[m].sum + slope * (point[2] - stack[m].force)
            x, x_m, x_b, z_b = point[2], stack[m].force, stack[m - 1].force, stack[m - 1].sum
        room = MERGE * max(x, abs(z), abs(z_b)) / (x_m - x_b)
        low = max(low, stack[m].slope - room)
        high = min(high, stack[m].slope + room)
        chord = (z - z_b) / (x - x_b)
        if low <= chord <= high:
            b = point[1]
            if by_force:
                b = stack[m - 1].b + chord * (point[0] - stack[m - 1].y)
            put(line, stack, m, (point[0], b, point[2], point[3], point[4]), min(max(chord, -1.0), 1.0))
            return m, low, high
    put(line, stack, m + 1, point, slope)
    return m + 1, -math.inf, math.inf


@inlined
def parting(
    line: FloatArray,
    stack: Any,
    i: int,
    upper: Point,
    lower: Point,
    start: Point,
    d_depth: float,
    d_shift: float,
) -> float:
    """Slip work of springs that lose contact, between two points of segment i; the step begins at `start`."""
    modulus: float = line[0, MODULUS]
    slope = stack[i].slope
    # lag of the anchor behind the shift at which each spring parts
    per_depth = d_shift / d_depth
    lag_u = start[1] + per_depth * (upper[0] - start[0]) - upper[1]
    lag_l = start[1] + per_depth * (lower[0] - start[0]) - lower[1]
    if lag_u * lag_l < 0.0:
        y = lower[0] + (upper[0] - lower[0]) * (lag_l / (lag_l - lag_u))
        a, force, work = curve(line, min(max(y, lower[0]), upper[0]))
        middle = (y, lower[1] + slope * (y - lower[0]), force, work, a)
        g = 1.0 if lag_u > 0.0 else -1.0
        return parted(modulus, slope, g, abs(lag_u), 0.0, upper, middle, d_depth, d_shift) + parted(
            modulus, slope, -g, 0.0, abs(lag_l), middle, lower, d_depth, d_shift
        )
    g = 1.0 if lag_u + lag_l > 0.0 else -1.0
    return parted(modulus, slope, g, abs(lag_u), abs(lag_l), upper, lower, d_depth, d_shift)


@inlined
def parted(
    modulus: float,
    slope: float,
    g: float,
    s_u: float,
    s_l: float,
    upper: Point,
    lower: Point,
    d_depth: float,
    d_shift: float,
) -> float:
    """-int phi' dF_N for phi = |dD| s^2 / (2 kappa), s linear between the points, slip toward g."""
    rate = g * d_shift - d_depth
    per_slip = slope * g * d_depth - g * d_shift
    p_u = per_slip * (s_u / rate) if s_u < rate else per_slip
    p_l = per_slip * (s_l / rate) if s_l < rate else per_slip
    total = p_l * lower[2] - p_u * upper[2]
    if p_u != p_l:
        total += (p_u - p_l) * mean_force(modulus, lower, upper)
    return total


@inlined
def replaced(
    modulus: float,
    bend: float,
    depth: float,
    d_depth: float,
    per_rate: float,
    upper: Point,
    s_u: float,
    lower: Point,
    s_l: float,
) -> float:
    """-int phi' dF_N for phi = (D - y) s - dD s^2 / (2 kappa), s linear between the points, bend = ds/dy."""
    r_u = min(s_u * per_rate, 1.0)
    r_l = min(s_l * per_rate, 1.0)
    p_u = (depth - upper[0] - d_depth * r_u) * bend - s_u
    p_l = (depth - lower[0] - d_depth * r_l) * bend - s_l
    total = p_l * lower[2] - p_u * upper[2]
    steep = d_depth * per_rate
    if abs(steep) < 10.0:
        return total - bend * (2.0 + bend * steep) * (upper[3] - lower[3])
    if p_u != p_l:
        total += (p_u - p_l) * mean_force(modulus, lower, upper)
    return total


@inlined
def move(
    line: FloatArray, stack: Any, m: int, low: float, high: float, depth: float, shift: float
) -> tuple[int, float, float, float, float]:
    """
    Go straight to (depth, shift), depth >= 0 (mdr_math 5.4, 17.8).

    Returns the top of the stack, its window of slopes, the slip work over mu^2 E* / G* and the distance that
    the innermost spring slips.
    """
    modulus: float = line[0, MODULUS]
    d_depth = depth - stack[m].y
    d_shift = shift - stack[m].b
    total = 0.0
    start = at(stack, m)
    upper = start
    i = m
    if d_depth == 0.0:
        if d_shift == 0.0:
            return m, low, high, 0.0, 0.0
        end = (depth, shift, upper[2], upper[3], upper[4])
        g = 1.0 if d_shift > 0.0 else -1.0
        rate = abs(d_shift)
        lag = rate
    else:
        a, force, work = curve(line, depth)
        end = (depth, shift, force, work, a)
        if d_depth > 0.0:
            if abs(d_shift) <= d_depth:
                m, low, high = extend(line, stack, m, low, high, end, d_shift / d_depth, False)
                return m, low, high, 0.0, 0.0
            g = 1.0 if d_shift > 0.0 else -1.0
            rate = abs(d_shift) - d_depth
            lag = rate
            total = rate * (mean_force(modulus, upper, end) - upper[2])
        else:
            while i > 0 and stack[i - 1].y > depth:
                lower = at(stack, i - 1)
                total += parting(line, stack, i, upper, lower, start, d_depth, d_shift)
                upper = lower
                i -= 1
            b = stack[i - 1].b + stack[i].slope * (depth - stack[i - 1].y)
            lower = (depth, b, force, work, a)
            total += parting(line, stack, i, upper, lower, start, d_depth, d_shift)
            upper = lower
            if i < m:
                low = high = stack[i].slope
            lag = abs(shift - b)
            if depth == 0.0:
                base(stack, shift)
                return 0, -math.inf, math.inf, total, lag
            if lag == 0.0:
                put(line, stack, i, end, stack[i].slope)
                return i, low, high, total, 0.0
            g = 1.0 if shift > b else -1.0
            rate = g * d_shift - d_depth
    edge = g * shift - depth
    per_rate = 1.0 / rate if rate > 0.0 else math.inf
    while i > 0:
        bend = 1.0 - g * stack[i].slope
        next_lag = edge - (g * stack[i - 1].b - stack[i - 1].y)
        if next_lag <= 0.0:
            break
        lower = at(stack, i - 1)
        total += replaced(modulus, bend, depth, d_depth, per_rate, upper, lag, lower, next_lag)
        upper = lower
        lag = next_lag
        i -= 1
    slid = 0.0
    if i == 0:
        slid = lag
        base(stack, shift - g * depth)
    else:
        bottom = stack[i - 1].y
        y = upper[0] - lag / bend if lag < bend * (upper[0] - bottom) else bottom
        if y > bottom:
            a, force, work = curve(line, y)
            lower = (y, stack[i - 1].b + stack[i].slope * (y - bottom), force, work, a)
        else:
            lower = at(stack, i - 1)
        total += replaced(modulus, bend, depth, d_depth, per_rate, upper, lag, lower, 0.0)
        if y > bottom:
            put(line, stack, i, lower, stack[i].slope)
        else:
            i -= 1
    put(line, stack, i + 1, end, g)
    return i + 1, -math.inf, math.inf, total, slid
