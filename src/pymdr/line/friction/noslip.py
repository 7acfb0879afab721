"""Compiled kernels without slip (mu infinite) and the discretised line of springs. Loads numba.

Without slip the anchor curve b(y) is the shift at which spring y touched. It has no cone and may jump where the
body moved at rest in depth: two vertices at one depth. The top of the stack is the present (depth, shift) itself.
Shifts are normalised as v = G* u_x / E*.
"""

from __future__ import annotations

import math

import numpy as np

from pymdr.line.friction import layout
from pymdr.line.friction.kernels import (
    MERGE,
    TINY,
    Anchors,
    Point,
    at,
    clear,
    count,
    free_slope,
    lengthens,
    vertex,
)
from pymdr.line.friction.reading import curve, depth_of_force, fused
from pymdr.line.friction.runs import BEYOND, Run, write
from pymdr.numerics.graded.layout import MAX
from pymdr.units import FloatArray

SHIFT_CONTROL, FORCE_CONTROL = 0, 2
_GAUSS_X = tuple(0.5 + 0.5 * np.polynomial.legendre.leggauss(4)[0])
_GAUSS_W = tuple(0.5 * np.polynomial.legendre.leggauss(4)[1])


@fused.compiled
def moments(line: FloatArray, p: Point, q: Point) -> tuple[float, float]:
    """2 E* int a dt and 2 E* int (1 - t) a dt for t from 0 at p to 1 at q."""
    modulus = line[0, layout.MODULUS]
    length = q.y - p.y
    if length <= 0.0:
        return 2.0 * modulus * q.radius, modulus * q.radius
    zeroth = (q.force - p.force) / length
    first = ((q.work - p.work) / length - p.force) / length
    if length > 0.05 * q.y:
        return zeroth, first
    # short: the differences have lost digits; quadrature has not, unless a kink or step of a lies within
    smooth_zeroth = smooth_first = 0.0
    for k in range(4):
        stiffness = 2.0 * modulus * _GAUSS_W[k] * curve(line, p.y + length * _GAUSS_X[k])[0]
        smooth_zeroth += stiffness
        smooth_first += (1.0 - _GAUSS_X[k]) * stiffness
    rounding = 1e-14 * q.force / length
    if abs(zeroth - smooth_zeroth) <= rounding:
        zeroth = smooth_zeroth
    if abs(first - smooth_first) <= rounding * (1.0 + q.y / length):
        first = smooth_first
    return zeroth, first


@fused.compiled
def put_stuck(anchors: Anchors, i: int, point: Point) -> None:
    """Write vertex i > 0; the segment below may be upright."""
    zeroth, first = moments(anchors.line, at(anchors.stack, i - 1), point)
    here, below = vertex(anchors.stack, i), vertex(anchors.stack, i - 1)
    length = point.y - below.y
    step = point.b - below.b
    here.y = point.y
    here.b = point.b
    here.slope = step / length if length > 0.0 else 0.0
    here.force = point.force
    here.work = point.work
    here.pull = below.pull + step * zeroth
    here.energy = below.energy + step * (below.pull + step * first)
    here.radius = point.radius


@fused.compiled
def restore_stuck(anchors: Anchors, y: FloatArray, b: FloatArray) -> None:
    """Fill a stack with the vertices of a state without slip."""
    clear(anchors.stack, b[0])
    for i in range(1, y.size):
        a, force, work = curve(anchors.line, y[i])
        put_stuck(anchors, i, Point(y[i], b[i], force, work, a))
        here = vertex(anchors.stack, i)
        here.low = here.high = here.slope


@fused.compiled
def released(line: FloatArray, lower: Point, upper: Point, lag_l: float, lag_u: float) -> float:
    """E* int lag^2 da between two depths, lag linear: the energy that springs release when they separate."""
    zeroth, first = moments(line, lower, upper)
    edges = line[0, layout.MODULUS] * (lag_u * lag_u * upper.radius - lag_l * lag_l * lower.radius)
    return float(edges - (lag_u - lag_l) * (lag_l * first + lag_u * (zeroth - first)))


@fused.compiled
def lift(anchors: Anchors, m: int, end: Point) -> tuple[int, Point, float]:
    """Cut the anchors at a lesser depth. Returns the segment that is cut, the point on it and the energy released."""
    start = at(anchors.stack, m)
    per_depth = (end.b - start.b) / (end.y - start.y)
    total = 0.0
    upper = start
    i = m
    while True:
        lower = at(anchors.stack, i - 1)
        last = i == 1 or lower.y < end.y
        if last:
            b = lower.b + vertex(anchors.stack, i).slope * (end.y - lower.y)
            lower = Point(end.y, b, end.force, end.work, end.radius)
        if upper.y > lower.y:
            lag_l = start.b + per_depth * (lower.y - start.y) - lower.b
            lag_u = start.b + per_depth * (upper.y - start.y) - upper.b
            total += released(anchors.line, lower, upper, lag_l, lag_u)
        if last:
            return i, lower, total
        upper = lower
        i -= 1


@fused.compiled
def stick(anchors: Anchors, m: int, depth: float, shift: float) -> tuple[int, float]:
    """Go straight to (depth, shift), depth >= 0. Returns the top and the energy released."""
    start = at(anchors.stack, m)
    a, force, work = curve(anchors.line, depth)
    end = Point(depth, shift, force, work, a)
    total = 0.0
    if depth == start.y:
        if shift != start.b:
            if m == 0 or vertex(anchors.stack, m - 1).y < depth:
                m += 1
            put_stuck(anchors, m, end)
    elif depth > start.y:
        joined = False
        if m > 0 and vertex(anchors.stack, m).y > vertex(anchors.stack, m - 1).y:
            y, b = vertex(anchors.stack, m - 1).y, vertex(anchors.stack, m - 1).b
            slope = (shift - b) / (depth - y)
            size = max(max(abs(shift), abs(b)), max(abs(start.b), abs(slope) * depth))
            joined = lengthens(anchors.stack, m, slope, MERGE * size / (start.y - y))
        if joined:
            put_stuck(anchors, m, end)
            return m, 0.0
        m += 1
        put_stuck(anchors, m, end)
    else:
        m, cut, total = lift(anchors, m, end)
        if depth == 0.0:
            clear(anchors.stack, shift)
            return 0, total
        put_stuck(anchors, m, cut)
        if shift != cut.b:
            m += 1
            put_stuck(anchors, m, end)
    free_slope(anchors.stack, m)
    return m, total


@fused.compiled
def stuck_shift_for(anchors: Anchors, m: int, depth: float, pull: float) -> float:
    """Shift at which the normalised tangential force is `pull` at `depth` > 0."""
    a, force, work = curve(anchors.line, depth)
    here = at(anchors.stack, m)
    total = vertex(anchors.stack, m).pull
    if depth < here.y:
        while m > 1 and vertex(anchors.stack, m - 1).y >= depth:
            m -= 1
        below = vertex(anchors.stack, m - 1)
        b = below.b + vertex(anchors.stack, m).slope * (depth - below.y)
        here = Point(depth, b, force, work, a)
        total = below.pull + (b - below.b) * moments(anchors.line, at(anchors.stack, m - 1), here)[0]
    return float(here.b + (pull - total) / moments(anchors.line, here, Point(depth, 0.0, force, work, a))[0])


@fused.compiled
def released_by_force(anchors: Anchors, m: int, depth: float, force: float, pull: float) -> float:
    """
    Energy released by springs that separate while (F_N, S) goes straight down to (`force`, `pull`) at `depth`.

    E* int lag^2 da with lag = (S - S(y)) / (2 E* a), where S and the force S(y) of the curve below y are linear in
    F_N over a segment: 1/2 lag_u lag_l dk + dq (mean lag over F_N - mean of its ends), k = 2 E* a, q = k lag.
    """
    twice = 2.0 * anchors.line[0, layout.MODULUS]
    a, _force, work = curve(anchors.line, depth)
    end = Point(depth, 0.0, force, work, a)
    start_force, start_pull = vertex(anchors.stack, m).force, vertex(anchors.stack, m).pull
    per_force = (pull - start_pull) / (force - start_force)
    total = 0.0
    i = m
    while i > 0:
        upper, lower = at(anchors.stack, i), at(anchors.stack, i - 1)
        last = lower.y < depth or i == 1
        s_u, s_l = vertex(anchors.stack, i).pull, vertex(anchors.stack, i - 1).pull
        if last:
            s_l += vertex(anchors.stack, i).slope * (depth - lower.y) * moments(anchors.line, lower, end)[0]
            lower = end
        if upper.y > lower.y:
            q_u = start_pull + per_force * (upper.force - start_force) - s_u
            q_l = start_pull + per_force * (lower.force - start_force) - s_l
            lag_u = q_u / (twice * upper.radius)
            lag_l = q_l / (twice * lower.radius) if lower.y > 0.0 else 0.0
            step = q_u - q_l
            # by moments: over short ways differences of depths and forces have lost digits
            zeroth, first = moments(anchors.line, lower, upper)
            mean = (q_l + step * first / zeroth) / zeroth
            total += 0.5 * lag_u * lag_l * twice * (upper.radius - lower.radius)
            total += step * (mean - 0.5 * (lag_u + lag_l))
        if last:
            break
        i -= 1
    return float(total)


@fused.compiled
def shift_under(anchors: Anchors, d: float, pull: float, by_force: bool) -> float:
    """The normalised shift of a row of a pull at a depth, gone to from the present state."""
    depth, v = anchors.memory[layout.DEPTH], anchors.memory[layout.SHIFT]
    m = int(anchors.memory[layout.TOP])
    if d > TINY and depth < 0.0:
        clear(anchors.stack, v)
        return float(v + (stuck_shift_for(anchors, m, d, pull) - v) * ((d - depth) / d))
    if d > TINY:
        return stuck_shift_for(anchors, m, d, pull)
    if by_force and depth > TINY:
        return float(anchors.stack[0].b)
    return float(v)


@fused.compiled
def advance(anchors: Anchors, d: float, v: float) -> float:
    """One straight step to (d, v), with loss and return of the contact; the energy released."""
    depth, before = anchors.memory[layout.DEPTH], anchors.memory[layout.SHIFT]
    anchors.memory[layout.DEPTH], anchors.memory[layout.SHIFT] = d, v
    m = int(anchors.memory[layout.TOP])
    released_energy = 0.0
    touches = d > TINY
    if touches or depth > TINY:
        end, shift = d, v
        if not touches:  # the springs part at depth 0
            end, shift = 0.0, before + (v - before) * (depth / (depth - d))
        elif depth < 0.0:
            clear(anchors.stack, before + (v - before) * (-depth / (d - depth)))
        m, released_energy = stick(anchors, m, end, shift)
    if not touches:
        clear(anchors.stack, v)
        m = 0
    anchors.memory[layout.TOP] = m
    return released_energy


@fused.compiled
def run_stuck(
    run: Run, normal: FloatArray, tangential: FloatArray, span: tuple[int, int, int], control: int
) -> tuple[int, int, int]:
    """
    As :func:`run_displacements` and :func:`run_forces`, without slip; `control` says what is given.

    A straight way in forces is straight in (d, v) while F_N rises; while it falls only what is released differs.
    """
    j, stop, column = span
    anchors, scales = run.anchors, run.scales
    by_shift, by_force = control == SHIFT_CONTROL, control == FORCE_CONTROL
    limit = anchors.line[0, MAX] * BEYOND
    while j < stop:
        d, t = normal[j], tangential[j]
        if not (math.isfinite(d) and math.isfinite(t)):
            return layout.NOT_FINITE, j, column
        if by_force and d < 0.0:
            return layout.NOT_ATTAINABLE, j, column
        force = d
        if by_force:
            d = depth_of_force(anchors.line, force)
        if not d <= limit:
            return layout.TOO_DEEP, j, column
        if not (by_shift or d > TINY or t == 0.0):
            return layout.NOT_ATTAINABLE, j, column
        if anchors.memory[layout.TOP] + 4 > anchors.stack.size:
            return layout.STACK_FULL, j, column
        before, pull = anchors.memory[layout.DEPTH], t / scales.force
        m = int(anchors.memory[layout.TOP])
        work = 0.0
        if by_force and TINY < before > d:
            work = released_by_force(anchors, m, max(d, 0.0), force, pull)
        v = t / scales.shift if by_shift else shift_under(anchors, d, pull, by_force)
        released_energy = advance(anchors, d, v)
        count(anchors.memory, int(anchors.memory[layout.TOP]), work if by_force else released_energy, 0.0)
        column = write(run, j, column)
        j += 1
    return layout.COMPLETE, j, column


@fused.compiled
def run_springs(
    profile: FloatArray,
    pulls: FloatArray,
    indentation: FloatArray,
    shift: FloatArray,
    per_shift: float,
    sticks: bool,
    out: FloatArray,
) -> None:
    """
    Springs of the line, row by row: sums of t, of t^2 / 2, of the slip work and of the springs that stick.

    t is the spring's normalised shift, at most its depth D - y, and kept in `pulls`, 0 before the first row. A straight step is exact for a spring, whether it
    enters, stays or parts.
    """
    depth = v = slip_work = 0.0
    for j in range(indentation.size):
        d, v1 = indentation[j], per_shift * shift[j]
        d_depth, d_shift = d - depth, v1 - v
        force = energy = 0.0
        stuck = 0
        for i in range(profile.size):
            y = profile[i]
            if d > y:
                t = pulls[i] + d_shift
                if depth < y:
                    t = d_shift * ((d - y) / d_depth)
                cap = d - y
                if not sticks and abs(t) >= cap:
                    s = abs(t) - cap
                    if s > 0.0:
                        rate = math.copysign(1.0, t) * d_shift - d_depth
                        slip_work += s * (cap - 0.5 * d_depth * min(s / rate, 1.0))
                    t = math.copysign(cap, t)
                else:
                    stuck += 1
                force += t
                energy += 0.5 * t * t
                pulls[i] = t
            elif depth > y:
                s = abs(pulls[i] + d_shift * ((depth - y) / -d_depth))
                if sticks:
                    slip_work += 0.5 * s * s
                elif s > 0.0:
                    rate = (
                        math.copysign(1.0, pulls[i] + d_shift * ((depth - y) / -d_depth)) * d_shift - d_depth
                    )
                    slip_work -= 0.5 * d_depth * s * min(s / rate, 1.0)
                pulls[i] = 0.0
        out[0, j], out[1, j], out[2, j], out[3, j] = force, stuck, energy, slip_work
        depth, v = d, v1
