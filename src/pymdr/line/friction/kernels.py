"""Compiled kernels of the memory stack. Imported only when a history is followed: it loads numba.

Normalised shift v = G* u_x / (mu E*) in m, normalised tangential force S = F_x / mu in N. One row of the stack per
vertex (y, b) of the anchor curve: y, b, slope of the segment below, F_N(y), W(y), the force and the energy of
the part of the curve below the vertex, a(y), the moment of the segment below. `window` holds the slopes that the top segment may still take.
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
from numpy.polynomial.legendre import leggauss

from pymdr.compiling import INTERPRETED
from pymdr.line.friction.layout import MODULUS
from pymdr.line.friction.reading import curve, inlined
from pymdr.units import FloatArray

VERTEX = np.dtype(
    [(name, float) for name in ("y", "b", "slope", "force", "work", "pull", "energy", "radius", "moment")]
)

MERGE = 2.0**-47  # of the coordinates: bends below it are rounding of the input
MEET = 2.0**-49  # of the coordinates: a border of slip this close to a vertex stands on it
if INTERPRETED:
    VERTEX = np.dtype((np.record, VERTEX))  # whose parts have names without numba too
_LOST = 1e-14  # of W: what rounding of a table takes
_SHORT = 0.1  # of the depth: over such a part of it a changes little
_CREPT = 2e-14  # of the force times the way, and of W: what the closed form of a short slip loses
_NODES = tuple((0.5 * (float(x) + 1.0), 0.5 * float(w)) for x, w in zip(*leggauss(5), strict=True))
_THIRD, _SIXTH = 1.0 / 3.0, 1.0 / 6.0
TINY = 1e-150  # lengths below it count as none: their products underflow
Point: TypeAlias = tuple[float, float, float, float, float]


@inlined
def moment(line: FloatArray, p: Point, q: Point) -> float:
    """
    Moment int (y_q - y) dF_N between two points (y, b, F_N, W, a), p above q in depth.

    Over a short piece the difference of W has lost its digits; then by what a smooth a gives, unless the two
    differ by more than was lost (a kink or step of a). a rises, so that it never leaves E* length^2 [a_p, a_q].
    """
    length = q[0] - p[0]
    exact = q[3] - p[3] - length * p[2]
    if length > 2e-3 * q[0]:
        return exact
    per_radius = line[0, MODULUS] * length * length
    if length > 2e-5 * q[0]:
        smooth = length * 0.5 * (q[2] - p[2]) - per_radius * (q[4] - p[4]) * _SIXTH
    else:
        smooth = per_radius * (2.0 * p[4] + q[4]) * _THIRD
    likely = smooth if abs(smooth - exact) <= _LOST * q[3] else exact
    return float(min(max(likely, per_radius * p[4]), per_radius * q[4]))


@inlined
def vertex(stack: Any, i: int) -> Any:
    """Vertex i >= 0: numba counts signed indices from the end too, at a tenth of a step's time."""
    return stack[np.uint64(i)]


@inlined
def at(stack: Any, i: int) -> Point:
    """Vertex i as a point."""
    here = vertex(stack, i)
    return here.y, here.b, here.force, here.work, here.radius


@inlined
def put(line: FloatArray, stack: Any, i: int, point: Point, slope: float) -> None:
    """Write vertex i > 0 at the end of a segment of the given slope."""
    y, b, force, work, radius = point
    here, below = vertex(stack, i), vertex(stack, i - 1)
    length = y - below.y
    turn = moment(line, at(stack, i - 1), point)
    here.y = y
    here.b = b
    here.slope = slope
    here.force = force
    here.work = work
    here.pull = below.pull + slope * (force - below.force)
    here.energy = below.energy + slope * (length * below.pull + slope * turn)
    here.radius = radius
    here.moment = turn


@inlined
def base(stack: Any, b: float) -> None:
    """Write the vertex at depth 0."""
    here = vertex(stack, 0)
    here.y = 0.0
    here.b = b
    here.slope = 0.0
    here.force = 0.0
    here.work = 0.0
    here.pull = 0.0
    here.energy = 0.0
    here.radius = 0.0
    here.moment = 0.0


@inlined
def extend(
    line: FloatArray, stack: Any, m: int, low: float, high: float, point: Point, slope: float, by_force: bool
) -> tuple[int, float, float]:
    """Append a stuck segment, joined to the top one when all its points stay within rounding of a line."""
    if m > 0:
        top, below = vertex(stack, m), vertex(stack, m - 1)
        x, z, x_m, x_b, z_b = point[0], point[1], top.y, below.y, below.b
        if by_force:
            z = top.pull + slope * (point[2] - top.force)
            x, x_m, x_b, z_b = point[2], top.force, below.force, below.pull
        room = MERGE * max(abs(slope) * x, abs(z), abs(z_b)) / (x_m - x_b)
        if by_force:  # a bend at a force that is lost beside the new one may still be seen in the shift
            size = max(abs(slope) * point[0], abs(point[1]), abs(below.b))
            room = min(room, MERGE * size / (top.y - below.y))
        low = max(low, top.slope - room)
        high = min(high, top.slope + room)
        chord = (z - z_b) / (x - x_b)
        if low <= chord <= high:
            b = point[1]
            if by_force:
                b = below.b + chord * (point[0] - below.y)
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
    per_depth: float,
    piece_moment: float,
) -> float:
    """Slip work of springs that lose contact, between two points of segment i; the step begins at `start`."""
    slope = vertex(stack, i).slope
    # lag of the anchor behind the shift at which each spring parts
    oblique = d_shift * per_depth
    lag_u = start[1] + oblique * (upper[0] - start[0]) - upper[1]
    lag_l = start[1] + oblique * (lower[0] - start[0]) - lower[1]
    if lag_u * lag_l < 0.0:
        y = lower[0] + (upper[0] - lower[0]) * (lag_l / (lag_l - lag_u))
        a, force, work = curve(line, min(max(y, lower[0]), upper[0]))
        middle = (y, lower[1] + slope * (y - lower[0]), force, work, a)
        g = 1.0 if lag_u > 0.0 else -1.0
        return parted(
            line,
            slope,
            g,
            abs(lag_u),
            upper,
            middle,
            d_depth,
            d_shift,
            per_depth,
            moment(line, middle, upper),
        ) + parted(
            line, slope, -g, 0.0, middle, lower, d_depth, d_shift, per_depth, moment(line, lower, middle)
        )
    g = 1.0 if lag_u + lag_l > 0.0 else -1.0
    return parted(line, slope, g, abs(lag_u), upper, lower, d_depth, d_shift, per_depth, piece_moment)


@inlined
def parted(
    line: FloatArray,
    slope: float,
    g: float,
    s_u: float,
    upper: Point,
    lower: Point,
    d_depth: float,
    d_shift: float,
    per_depth: float,
    piece_moment: float,
) -> float:
    """-int phi' dF_N for phi = |dD| s^2 / (2 kappa), s linear from s_u at the upper point, slip toward g."""
    rate = g * d_shift - d_depth
    if rate <= TINY:
        return 0.0
    per_slip = slope * g * d_depth - g * d_shift
    per_rate = 1.0 / rate
    p_u = per_slip * min(s_u * per_rate, 1.0)
    turn = -(per_slip * per_depth) * (per_slip * per_rate)
    return turn * piece_moment - p_u * (upper[2] - lower[2])


@inlined
def replaced(
    line: FloatArray,
    bend: float,
    depth: float,
    d_depth: float,
    per_rate: float,
    upper: Point,
    s_u: float,
    lower: Point,
    piece_moment: float,
) -> float:
    """-int phi' dF_N for phi = (D - y) s - dD s^2 / (2 kappa), s linear from s_u, bend = ds/dy."""
    p_u = (depth - upper[0] - d_depth * min(s_u * per_rate, 1.0)) * bend - s_u
    turn = -bend * (2.0 + bend * d_depth * per_rate)
    return turn * piece_moment - p_u * (upper[2] - lower[2])


@inlined
def crept(
    line: FloatArray, depth: float, radius: float, upper: float, lower: float, s_u: float, bend: float
) -> float:
    """
    -int phi' dF_N for phi = (D - y) s at constant depth D, with the part of a(y) that is not a(D).

    A constant a adds nothing over all pieces of a step, as phi is 0 at both ends, and the slip work of a slip far
    smaller than the depth would be lost in its rounding.
    """
    length = upper - lower
    total = 0.0
    for node, weight in _NODES:
        y = lower + length * node
        a, _, _ = curve(line, y)
        total += weight * (s_u - bend * (upper - y) - bend * (depth - y)) * (a - radius)
    return float(2.0 * line[0, MODULUS] * length * total)


@inlined
def move(
    line: FloatArray, stack: Any, m: int, low: float, high: float, depth: float, shift: float
) -> tuple[int, float, float, float, float]:
    """
    Go straight to (depth, shift), depth >= 0.

    Returns the top of the stack, its window of slopes, the slip work over mu^2 E* / G* and the distance that
    the innermost spring slips.
    """
    d_depth = depth - vertex(stack, m).y
    d_shift = shift - vertex(stack, m).b
    total = 0.0
    piece_moment = vertex(stack, m).moment
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
            total = rate * moment(line, upper, end) / d_depth
        else:
            per_depth = 1.0 / d_depth
            while i > 0 and vertex(stack, i - 1).y > depth:
                lower = at(stack, i - 1)
                piece_moment = vertex(stack, i).moment
                total += parting(
                    line, stack, i, upper, lower, start, d_depth, d_shift, per_depth, piece_moment
                )
                upper = lower
                i -= 1
            b = vertex(stack, i - 1).b + vertex(stack, i).slope * (depth - vertex(stack, i - 1).y)
            lower = (depth, b, force, work, a)
            total += parting(
                line, stack, i, upper, lower, start, d_depth, d_shift, per_depth, moment(line, lower, upper)
            )
            upper = lower
            piece_moment = moment(line, at(stack, i - 1), lower)
            if i < m:
                low = high = vertex(stack, i).slope
            lag = abs(shift - b)
            if depth == 0.0:
                base(stack, shift)
                return 0, -math.inf, math.inf, max(total, 0.0), lag
            if lag == 0.0:
                put(line, stack, i, end, vertex(stack, i).slope)
                return i, low, high, max(total, 0.0), 0.0
            g = 1.0 if shift > b else -1.0
            rate = g * d_shift - d_depth
    edge = g * shift - depth
    per_rate = 1.0 / rate if rate > TINY else 0.0
    closer = 0.0
    while i > 0:
        bend = 1.0 - g * vertex(stack, i).slope
        next_lag = edge - (g * vertex(stack, i - 1).b - vertex(stack, i - 1).y)
        if next_lag <= 0.0:
            break
        lower = at(stack, i - 1)
        total += replaced(line, bend, depth, d_depth, per_rate, upper, lag, lower, piece_moment)
        if d_depth == 0.0 and depth - lower[0] < _SHORT * depth:
            closer += crept(line, depth, end[4], upper[0], lower[0], lag, bend)
        upper = lower
        lag = next_lag
        i -= 1
        piece_moment = vertex(stack, i).moment
    slid = 0.0
    if i == 0:
        slid = lag
        base(stack, shift - g * depth)
    else:
        bottom = vertex(stack, i - 1).y
        y = upper[0] - lag / bend if lag < bend * (upper[0] - bottom) else bottom
        if y - bottom <= MEET * (depth + abs(shift)):
            y = bottom
        if y > bottom:
            a, force, work = curve(line, y)
            lower = (y, vertex(stack, i - 1).b + vertex(stack, i).slope * (y - bottom), force, work, a)
        else:
            lower = at(stack, i - 1)
        total += replaced(line, bend, depth, d_depth, per_rate, upper, lag, lower, moment(line, lower, upper))
        if d_depth == 0.0 and depth - lower[0] < _SHORT * depth:
            closer += crept(line, depth, end[4], upper[0], lower[0], lag, bend)
            # unless a bends or steps in between
            if abs(closer - total) <= _CREPT * (end[2] * rate + end[3]):
                total = closer
        if y > bottom:
            put(line, stack, i, lower, vertex(stack, i).slope)
        else:
            i -= 1
            if i > 0 and vertex(stack, i).slope == g:
                i -= 1
    put(line, stack, i + 1, end, g)
    return i + 1, -math.inf, math.inf, max(total, 0.0), slid
