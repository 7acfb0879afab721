"""Compiled kernels of the memory stack. Imported only when a history is followed: it loads numba.

Normalised shift v = G* u_x / (mu E*) in m, normalised tangential force S = F_x / mu in N. One row of the stack per
vertex (y, b) of the anchor curve: y, b, slope of the segment below, F_N(y), W(y), the force and the energy of
the part of the curve below the vertex, a(y), the moment of the segment below, and the least and largest slope that
the segment may still take when it is lengthened.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.legendre import leggauss

from pymdr.compiling import INTERPRETED
from pymdr.line.friction.layout import CARRY, DEPTH, MODULUS, SHIFT, SLIDE, SLIP_WORK, TOP
from pymdr.line.friction.reading import curve, fused
from pymdr.units import FloatArray

VERTEX = np.dtype(
    [
        (name, float)
        for name in ("y", "b", "slope", "force", "work", "pull", "energy", "radius", "moment", "low", "high")
    ]
)
if INTERPRETED:
    VERTEX = np.dtype((np.record, VERTEX))  # whose parts have names without numba too

MERGE = 2.0**-47  # of the coordinates: bends below it are rounding of the input
MEET = 2.0**-49  # of the coordinates: a border of slip this close to a vertex stands on it
_ROUNDING_OF_WORK = 1e-14  # of W: what rounding of a table takes
_SHORT = 0.1  # of the depth: over such a part of it a changes little
_ROUNDING_OF_SLIP = 2e-14  # of the force times the way, and of W: what the closed form of a short slip loses
_NODES = tuple((0.5 * (float(x) + 1.0), 0.5 * float(w)) for x, w in zip(*leggauss(5), strict=True))
_THIRD, _SIXTH = 1.0 / 3.0, 1.0 / 6.0
TINY = 1e-150  # lengths below it count as none: their products underflow


class Point(NamedTuple):
    """A point of the anchor curve, with F_N, W and a at its depth."""

    y: float
    b: float
    force: float
    work: float
    radius: float


class Anchors(NamedTuple):
    """The curves of a body, the stack of vertices, and the state that a run passes from one row to the next."""

    line: FloatArray
    stack: Any
    memory: FloatArray


class Step(NamedTuple):
    """A straight step: its start, and the change of depth and shift."""

    y: float
    b: float
    d_depth: float
    d_shift: float


@fused.inlined
def moment(line: FloatArray, p: Point, q: Point) -> float:
    """
    Moment int (y_q - y) dF_N between two points, p above q in depth.

    Over a short segment the difference of W has lost its digits; then by what a smooth a gives, unless the two
    differ by more than was lost (a kink or step of a). a rises, so that it never leaves E* length^2 [a_p, a_q].
    """
    length = q.y - p.y
    exact = q.work - p.work - length * p.force
    if length > 2e-3 * q.y:
        return exact
    per_radius = line[0, MODULUS] * length * length
    if length > 2e-5 * q.y:
        smooth = length * 0.5 * (q.force - p.force) - per_radius * (q.radius - p.radius) * _SIXTH
    else:
        smooth = per_radius * (2.0 * p.radius + q.radius) * _THIRD
    likely = smooth if abs(smooth - exact) <= _ROUNDING_OF_WORK * q.work else exact
    return float(min(max(likely, per_radius * p.radius), per_radius * q.radius))


@fused.inlined
def vertex(stack: Any, i: int) -> Any:
    """Vertex i >= 0: numba counts signed indices from the end too, at a tenth of a step's time."""
    return stack[np.uint64(i)]


@fused.inlined
def at(stack: Any, i: int) -> Point:
    """Vertex i as a point."""
    here = vertex(stack, i)
    return Point(here.y, here.b, here.force, here.work, here.radius)


@fused.inlined
def on_segment(anchors: Anchors, i: int, y: float) -> Point:
    """The point at a depth on the segment below vertex i."""
    a, force, work = curve(anchors.line, y)
    below = vertex(anchors.stack, i - 1)
    return Point(y, below.b + vertex(anchors.stack, i).slope * (y - below.y), force, work, a)


@fused.inlined
def put(anchors: Anchors, i: int, point: Point, slope: float) -> None:
    """Write vertex i > 0 at the end of a segment of the given slope."""
    here, below = vertex(anchors.stack, i), vertex(anchors.stack, i - 1)
    length = point.y - below.y
    turn = moment(anchors.line, at(anchors.stack, i - 1), point)
    here.y = point.y
    here.b = point.b
    here.slope = slope
    here.force = point.force
    here.work = point.work
    here.pull = below.pull + slope * (point.force - below.force)
    here.energy = below.energy + slope * (length * below.pull + slope * turn)
    here.radius = point.radius
    here.moment = turn


@fused.inlined
def push(anchors: Anchors, i: int, point: Point, slope: float) -> None:
    """Write vertex i > 0 at the end of a new segment."""
    put(anchors, i, point, slope)
    free_slope(anchors.stack, i)


@fused.inlined
def free_slope(stack: Any, i: int) -> None:
    """Let segment i take any slope when it is lengthened."""
    here = vertex(stack, i)
    here.low = -math.inf
    here.high = math.inf


@fused.inlined
def keep_slope(stack: Any, i: int) -> None:
    """Let segment i be lengthened by its own slope alone."""
    here = vertex(stack, i)
    here.low = here.slope
    here.high = here.slope


@fused.compiled
def clear(stack: Any, b: float) -> None:
    """Write the vertex at depth 0."""
    here = stack[0]
    here.y = 0.0
    here.b = b
    here.slope = 0.0
    here.force = 0.0
    here.work = 0.0
    here.pull = 0.0
    here.energy = 0.0
    here.radius = 0.0
    here.moment = 0.0
    here.low = -math.inf
    here.high = math.inf


@fused.inlined
def lengthens(stack: Any, i: int, chord: float, tolerance: float) -> bool:
    """Whether segment i may end at the slope of a chord: all its ends so far are within `room` of a line."""
    top = vertex(stack, i)
    low = max(top.low, top.slope - tolerance)
    high = min(top.high, top.slope + tolerance)
    if not low <= chord <= high:
        return False
    top.low = low
    top.high = high
    return True


@fused.merged
def extend(anchors: Anchors, m: int, point: Point, slope: float) -> int:
    """Append a stuck segment, joined to the top one when all its points stay within rounding of a line."""
    if m > 0:
        top, below = vertex(anchors.stack, m), vertex(anchors.stack, m - 1)
        size = max(abs(slope) * point.y, max(abs(point.b), abs(below.b)))
        chord = (point.b - below.b) / (point.y - below.y)
        if lengthens(anchors.stack, m, chord, MERGE * size / (top.y - below.y)):
            put(anchors, m, point, min(max(chord, -1.0), 1.0))
            return m
    push(anchors, m + 1, point, slope)
    return m + 1


@fused.inlined
def detachment_work(
    slope: float, g: float, lag: float, upper: Point, lower: Point, step: Step, turn: float
) -> float:
    """-int phi' dF_N for phi = |dD| s^2 / (2 kappa), s linear from `lag` at the upper point, slip toward g."""
    rate = g * step.d_shift - step.d_depth
    if rate <= TINY:
        return 0.0
    per_slip = slope * g * step.d_depth - g * step.d_shift
    per_rate = 1.0 / rate
    p_u = per_slip * min(lag * per_rate, 1.0)
    return -(per_slip / step.d_depth) * (per_slip * per_rate) * turn - p_u * (upper.force - lower.force)


@fused.inlined
def lag_behind(point: Point, step: Step) -> float:
    """Lag of the anchor at a point behind the shift at which its spring separates."""
    return step.b + step.d_shift / step.d_depth * (point.y - step.y) - point.b


@fused.merged
def slip_work(
    bend: float, lag: float, end: Point, step: Step, per_rate: float, upper: Point, lower: Point, turn: float
) -> float:
    """-int phi' dF_N for phi = (D - y) s - dD s^2 / (2 kappa), s linear from `lag`, bend = ds/dy."""
    p_u = (end.y - upper.y - step.d_depth * min(lag * per_rate, 1.0)) * bend - lag
    return -bend * (2.0 + bend * step.d_depth * per_rate) * turn - p_u * (upper.force - lower.force)


@fused.merged
def shallow_slip_work(
    line: FloatArray, end: Point, upper: float, lower: float, lag: float, bend: float
) -> float:
    """
    -int phi' dF_N for phi = (D - y) s at constant depth D, with the part of a(y) that is not a(D).

    A constant a adds nothing over all segments of a step, as phi is 0 at both ends, and the slip work of a slip far
    smaller than the depth would be lost in its rounding.
    """
    length = upper - lower
    total = 0.0
    for node, weight in _NODES:
        y = lower + length * node
        a, _force, _work = curve(line, y)
        total += weight * (lag - bend * (upper - y) - bend * (end.y - y)) * (a - end.radius)
    return float(2.0 * line[0, MODULUS] * length * total)


@fused.merged
def lift(anchors: Anchors, m: int, step: Step, end: Point) -> tuple[int, Point, float]:
    """Cut the anchors at a lesser depth. Returns the segment that is cut, the point on it and the slip work."""
    upper = at(anchors.stack, m)
    total = 0.0
    i = m
    while True:
        slope, turn = vertex(anchors.stack, i).slope, vertex(anchors.stack, i).moment
        lower = at(anchors.stack, i - 1)
        last = lower.y <= end.y
        if last:
            b = lower.b + slope * (end.y - lower.y)
            lower = Point(end.y, b, end.force, end.work, end.radius)
            turn = moment(anchors.line, lower, upper)
        lag_u, lag_l = lag_behind(upper, step), lag_behind(lower, step)
        g = 1.0 if lag_u + lag_l > 0.0 else -1.0
        if lag_u * lag_l < 0.0:  # the springs slip to both sides
            g = 1.0 if lag_u > 0.0 else -1.0
            y = lower.y + (upper.y - lower.y) * (lag_l / (lag_l - lag_u))
            middle = on_segment(anchors, i, min(max(y, lower.y), upper.y))
            turn = moment(anchors.line, middle, upper)
            total += detachment_work(slope, g, abs(lag_u), upper, middle, step, turn)
            turn = moment(anchors.line, lower, middle)
            upper, lag_u, g = middle, 0.0, -g
        total += detachment_work(slope, g, abs(lag_u), upper, lower, step, turn)
        if last:
            if i < m:
                keep_slope(anchors.stack, i)
            return i, lower, total
        upper = lower
        i -= 1


@fused.merged
def slip(anchors: Anchors, i: int, upper: Point, step: Step, end: Point) -> tuple[int, float, float]:
    """
    Cut the anchors at the edge of the cone of `end`, from a point of segment i on that lies outside.

    Returns the top of the stack, the slip work of the springs replaced and the distance that the innermost slips.
    """
    g = 1.0 if end.b > upper.b else -1.0
    lag = g * (end.b - upper.b) - (end.y - upper.y)
    rate = g * step.d_shift - step.d_depth
    per_rate = 1.0 / rate if rate > TINY else 0.0
    turn = vertex(anchors.stack, i).moment
    if i > 0 and upper.y < vertex(anchors.stack, i).y:
        turn = moment(anchors.line, at(anchors.stack, i - 1), upper)
    total = closer = 0.0
    while i > 0:
        slope = vertex(anchors.stack, i).slope
        bend = 1.0 - g * slope
        lower = at(anchors.stack, i - 1)
        next_lag = (g * end.b - end.y) - (g * lower.b - lower.y)
        bottom = lower.y
        if next_lag <= 0.0:  # the border of slip is on this segment
            y = upper.y - lag / bend if lag < bend * (upper.y - bottom) else bottom
            if y - bottom > MEET * (end.y + abs(end.b)):
                lower = on_segment(anchors, i, y)
            turn = moment(anchors.line, lower, upper)
        total += slip_work(bend, lag, end, step, per_rate, upper, lower, turn)
        if step.d_depth == 0.0 and end.y - lower.y < _SHORT * end.y:
            closer += shallow_slip_work(anchors.line, end, upper.y, lower.y, lag, bend)
        if next_lag <= 0.0:
            # by the closer sum, unless a bends or steps in between
            rounding = _ROUNDING_OF_SLIP * (end.force * rate + end.work)
            if step.d_depth == 0.0 and end.y - lower.y < _SHORT * end.y and abs(closer - total) <= rounding:
                total = closer
            if lower.y > bottom:
                put(anchors, i, lower, slope)
            else:
                i -= 1
                if i > 0 and vertex(anchors.stack, i).slope == g:
                    i -= 1
            push(anchors, i + 1, end, g)
            return i + 1, total, 0.0
        upper = lower
        lag = next_lag
        i -= 1
        turn = vertex(anchors.stack, i).moment
    clear(anchors.stack, end.b - g * end.y)
    push(anchors, i + 1, end, g)
    return i + 1, total, lag


@fused.inlined
def count(memory: FloatArray, m: int, work: float, slid: float) -> None:
    """Keep the top of the stack, and add to the slip work, by Kahan's summation, and to the distance slid."""
    term = max(work, 0.0) - memory[CARRY]
    total = memory[SLIP_WORK] + term
    memory[CARRY] = (total - memory[SLIP_WORK]) - term
    memory[SLIP_WORK] = total
    memory[SLIDE] += slid
    memory[TOP] = m


@fused.inner
def advance(anchors: Anchors, depth: float, shift: float) -> None:
    """
    Go straight to (depth, shift), with loss and return of the contact.

    Counts the slip work over mu^2 E* / G* and the distance that the innermost spring slips.
    """
    before, v = anchors.memory[DEPTH], anchors.memory[SHIFT]
    anchors.memory[DEPTH], anchors.memory[SHIFT] = depth, shift
    if depth > TINY:
        y, b = depth, shift
        if before < 0.0:
            clear(anchors.stack, v + (shift - v) * (-before / (depth - before)))
    elif before > TINY:  # the springs part at depth 0
        y, b = 0.0, v + (shift - v) * (before / (before - depth))
    else:
        anchors.memory[TOP] = 0.0
        clear(anchors.stack, shift)
        return
    m = int(anchors.memory[TOP])
    upper = at(anchors.stack, m)
    step = Step(upper.y, upper.b, y - upper.y, b - upper.b)
    if step.d_depth == 0.0 and step.d_shift == 0.0:
        return
    work = 0.0
    end = Point(y, b, upper.force, upper.work, upper.radius)
    if step.d_depth != 0.0:
        a, force, w = curve(anchors.line, y)
        end = Point(y, b, force, w, a)
    if step.d_depth > 0.0:
        if abs(step.d_shift) <= step.d_depth:
            anchors.memory[TOP] = extend(anchors, m, end, step.d_shift / step.d_depth)
            return
        work = (abs(step.d_shift) - step.d_depth) * moment(anchors.line, upper, end) / step.d_depth
    elif step.d_depth < 0.0:
        m, upper, work = lift(anchors, m, step, end)
        if y == 0.0:
            count(anchors.memory, m, work, abs(b - upper.b))
            anchors.memory[TOP] = 0.0
            clear(anchors.stack, shift)
            return
        if b == upper.b:
            put(anchors, m, end, vertex(anchors.stack, m).slope)
            count(anchors.memory, m, work, 0.0)
            return
    m, replaced, slid = slip(anchors, m, upper, step, end)
    count(anchors.memory, m, work + replaced, slid)
