"""Compiled kernels without slip (mu infinite) and the discretised line of springs. Loads numba.

Without slip the anchor curve b(y) is the shift at which spring y touched. It has no cone and may jump where the
body moved at rest in depth: two vertices at one depth. The top of the stack is the present (depth, shift) itself.
Shifts are normalised as v = G* u_x / E*.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pymdr.line.friction.kernels import MERGE, TINY, Point, at, base, vertex
from pymdr.line.friction.layout import MODULUS, REACH, IntArray
from pymdr.line.friction.reading import compiled, curve, depth_of_force
from pymdr.line.friction.runs import (
    COMPLETE,
    FORCE_CONTROL,
    NOT_ATTAINABLE,
    NOT_FINITE,
    SHIFT_CONTROL,
    STACK_FULL,
    TOO_DEEP,
    keep_register,
)
from pymdr.units import FloatArray

_GAUSS_X = tuple(0.5 + 0.5 * np.polynomial.legendre.leggauss(4)[0])
_GAUSS_W = tuple(0.5 * np.polynomial.legendre.leggauss(4)[1])


@compiled
def moments(line: FloatArray, p: Point, q: Point) -> tuple[float, float]:
    """2 E* int a dt and 2 E* int (1 - t) a dt for t from 0 at p to 1 at q."""
    modulus = line[0, MODULUS]
    length = q[0] - p[0]
    if length <= 0.0:
        return 2.0 * modulus * q[4], modulus * q[4]
    zeroth = (q[2] - p[2]) / length
    first = ((q[3] - p[3]) / length - p[2]) / length
    if length > 0.05 * q[0]:
        return zeroth, first
    # short: the differences have lost digits; quadrature has not, unless a kink or step of a lies within
    smooth_zeroth = smooth_first = 0.0
    for k in range(4):
        stiffness = 2.0 * modulus * _GAUSS_W[k] * curve(line, p[0] + length * _GAUSS_X[k])[0]
        smooth_zeroth += stiffness
        smooth_first += (1.0 - _GAUSS_X[k]) * stiffness
    lost = 1e-14 * q[2] / length
    if abs(zeroth - smooth_zeroth) <= lost:
        zeroth = smooth_zeroth
    if abs(first - smooth_first) <= lost * (1.0 + q[0] / length):
        first = smooth_first
    return zeroth, first


@compiled
def put_stuck(line: FloatArray, stack: Any, i: int, point: Point) -> None:
    """Write vertex i > 0; the segment below may be upright."""
    y, b, force, work, radius = point
    zeroth, first = moments(line, at(stack, i - 1), point)
    here, below = vertex(stack, i), vertex(stack, i - 1)
    length = y - below.y
    step = b - below.b
    here.y = y
    here.b = b
    here.slope = step / length if length > 0.0 else 0.0
    here.force = force
    here.work = work
    here.pull = below.pull + step * zeroth
    here.energy = below.energy + step * (below.pull + step * first)
    here.radius = radius


@compiled
def restore_stuck(line: FloatArray, y: FloatArray, b: FloatArray, stack: Any) -> None:
    """Fill a stack with the vertices of a state without slip."""
    base(stack, b[0])
    for i in range(1, y.size):
        a, force, work = curve(line, y[i])
        put_stuck(line, stack, i, (y[i], b[i], force, work, a))


@compiled
def released(line: FloatArray, lower: Point, upper: Point, lag_l: float, lag_u: float) -> float:
    """E* int lag^2 da between two depths, lag linear: what springs hold when they part."""
    zeroth, first = moments(line, lower, upper)
    edges = line[0, MODULUS] * (lag_u * lag_u * upper[4] - lag_l * lag_l * lower[4])
    return float(edges - (lag_u - lag_l) * (lag_l * first + lag_u * (zeroth - first)))


@compiled
def stick(
    line: FloatArray, stack: Any, m: int, low: float, high: float, depth: float, shift: float
) -> tuple[int, float, float, float]:
    """Go straight to (depth, shift), depth >= 0. Returns the top, its window and the energy released."""
    start = at(stack, m)
    d_depth = depth - start[0]
    a, force, work = curve(line, depth)
    end = (depth, shift, force, work, a)
    if d_depth == 0.0:
        if shift != start[1]:
            if m == 0 or vertex(stack, m - 1).y < depth:
                m += 1
            put_stuck(line, stack, m, end)
        return m, -math.inf, math.inf, 0.0
    if d_depth > 0.0:
        if m > 0 and vertex(stack, m).y > vertex(stack, m - 1).y:
            y, b = vertex(stack, m - 1).y, vertex(stack, m - 1).b
            slope = (shift - b) / (depth - y)
            size = max(abs(shift), abs(b), abs(start[1]), abs(slope) * depth)
            room = MERGE * size / (start[0] - y)
            low = max(low, vertex(stack, m).slope - room)
            high = min(high, vertex(stack, m).slope + room)
            if low <= slope <= high:
                put_stuck(line, stack, m, end)
                return m, low, high, 0.0
        put_stuck(line, stack, m + 1, end)
        return m + 1, -math.inf, math.inf, 0.0
    per_depth = (shift - start[1]) / d_depth
    total = 0.0
    upper = start
    i = m
    while True:
        bottom = vertex(stack, i - 1).y
        lower = at(stack, i - 1)
        last = i == 1 or bottom < depth
        if last:
            b = vertex(stack, i - 1).b + vertex(stack, i).slope * (depth - bottom)
            lower = (depth, b, force, work, a)
        if upper[0] > lower[0]:
            lag_l = start[1] + per_depth * (lower[0] - start[0]) - lower[1]
            lag_u = start[1] + per_depth * (upper[0] - start[0]) - upper[1]
            total += released(line, lower, upper, lag_l, lag_u)
        if last:
            break
        upper = lower
        i -= 1
    if depth == 0.0:
        base(stack, shift)
        return 0, -math.inf, math.inf, total
    put_stuck(line, stack, i, lower)
    if shift != lower[1]:
        i += 1
        put_stuck(line, stack, i, end)
    return i, -math.inf, math.inf, total


@compiled
def stuck_shift_for(line: FloatArray, stack: Any, m: int, depth: float, pull: float) -> float:
    """Shift at which the normalised tangential force is `pull` at `depth` > 0."""
    a, force, work = curve(line, depth)
    here = at(stack, m)
    total = vertex(stack, m).pull
    if depth < here[0]:
        while m > 1 and vertex(stack, m - 1).y >= depth:
            m -= 1
        b = vertex(stack, m - 1).b + vertex(stack, m).slope * (depth - vertex(stack, m - 1).y)
        here = (depth, b, force, work, a)
        total = (
            vertex(stack, m - 1).pull
            + (b - vertex(stack, m - 1).b) * moments(line, at(stack, m - 1), here)[0]
        )
    return float(here[1] + (pull - total) / moments(line, here, (depth, 0.0, force, work, a))[0])


@compiled
def released_by_force(line: FloatArray, stack: Any, m: int, depth: float, force: float, pull: float) -> float:
    """
    What springs hold when they part while (F_N, S) goes straight down to (`force`, `pull`) at `depth`.

    E* int lag^2 da with lag = (S - S(y)) / (2 E* a), where S and the force S(y) of the curve below y are linear in
    F_N over a segment: 1/2 lag_u lag_l dk + dq (mean lag over F_N - mean of its ends), k = 2 E* a, q = k lag.
    """
    twice = 2.0 * line[0, MODULUS]
    top = vertex(stack, m)
    a, _, work = curve(line, depth)
    end = (depth, 0.0, force, work, a)
    per_force = (pull - top.pull) / (force - top.force)
    start_force, start_pull = top.force, top.pull
    total = 0.0
    i = m
    while i > 0:
        upper, lower = at(stack, i), at(stack, i - 1)
        last = lower[0] < depth or i == 1
        s_u, s_l = vertex(stack, i).pull, vertex(stack, i - 1).pull
        if last:
            b = lower[1] + vertex(stack, i).slope * (depth - lower[0])
            s_l += (b - lower[1]) * moments(line, lower, end)[0]
            lower = end
        if upper[0] > lower[0]:
            q_u = start_pull + per_force * (upper[2] - start_force) - s_u
            q_l = start_pull + per_force * (lower[2] - start_force) - s_l
            lag_u = q_u / (twice * upper[4])
            lag_l = q_l / (twice * lower[4]) if lower[0] > 0.0 else 0.0
            step = q_u - q_l
            # by moments: over short ways differences of depths and forces have lost digits
            zeroth, first = moments(line, lower, upper)
            mean = (q_l + step * first / zeroth) / zeroth
            total += 0.5 * lag_u * lag_l * twice * (upper[4] - lower[4])
            total += step * (mean - 0.5 * (lag_u + lag_l))
        if last:
            break
        i -= 1
    return float(total)


@compiled
def run_stuck(
    line: FloatArray,
    stack: Any,
    register: FloatArray,
    normal: FloatArray,
    tangential: FloatArray,
    scales: tuple[float, float, float],
    rows: IntArray,
    out: FloatArray,
    span: tuple[int, int, int],
    every: bool,
    control: int,
) -> tuple[int, int, int]:
    """
    As :func:`run_displacements` and :func:`run_forces`, without slip; `control` says what is given.

    A straight way in forces is straight in (d, v) while F_N rises; while it falls only what is released differs.
    """
    j, stop, column = span
    to_force, to_energy, to_shift = scales
    limit = line[0, REACH] * (1.0 + 1e-14)
    depth, v, low, high, total, carry, slide = register[:7]
    m = int(register[7])
    code = COMPLETE
    while j < stop:
        d, t = normal[j], tangential[j]
        if not (math.isfinite(d) and math.isfinite(t)):
            code = NOT_FINITE
            break
        if control == FORCE_CONTROL and d < 0.0:
            code = NOT_ATTAINABLE
            break
        given = d
        if control == FORCE_CONTROL:
            d = depth_of_force(line, d)
        if not d <= limit:
            code = TOO_DEEP
            break
        if control != SHIFT_CONTROL and not d > TINY and t != 0.0:
            code = NOT_ATTAINABLE
            break
        if m + 4 > stack.shape[0]:
            code = STACK_FULL
            break
        v1 = t / to_shift
        work = 0.0
        if control != SHIFT_CONTROL:
            pull = t / to_force
            v1 = v
            if d > TINY and depth < 0.0:
                base(stack, v)
                v1 = v + (stuck_shift_for(line, stack, 0, d, pull) - v) * ((d - depth) / d)
            elif d > TINY:
                v1 = stuck_shift_for(line, stack, m, d, pull)
            elif control == FORCE_CONTROL and depth > TINY:
                v1 = vertex(stack, 0).b
            if control == FORCE_CONTROL and TINY < depth > d:
                work = released_by_force(line, stack, m, max(d, 0.0), given, pull)
        lost = 0.0
        if d > TINY:
            if depth < 0.0:
                base(stack, v + (v1 - v) * (-depth / (d - depth)))
            m, low, high, lost = stick(line, stack, m, low, high, d, v1)
        else:
            if depth > TINY:
                last = v + (v1 - v) * (depth / (depth - d))
                m, low, high, lost = stick(line, stack, m, low, high, 0.0, last)
            base(stack, v1)
            m = 0
        if control != FORCE_CONTROL:
            work = lost
        depth, v = d, v1
        total += work
        if every or (column < rows.size and rows[column] == j):
            out[0, column] = to_force * vertex(stack, m).pull
            out[1, column] = vertex(stack, m).radius
            out[2, column] = to_energy * max(vertex(stack, m).energy, 0.0)
            out[3, column] = to_energy * total
            if control != SHIFT_CONTROL:
                out[5, column] = depth
                out[6, column] = to_shift * v
            column += 1
        j += 1
    keep_register(register, depth, v, low, high, total, carry, slide, m)
    return code, j, column


@compiled
def run_springs(
    profile: FloatArray,
    indentation: FloatArray,
    shift: FloatArray,
    per_shift: float,
    sticks: bool,
    out: FloatArray,
) -> None:
    """
    Springs of the line, row by row: sums of t, of t^2 / 2, of the slip work and of the springs that stick.

    t is the spring's normalised shift, at most its depth D - y. A straight step is exact for a spring, whether it
    enters, stays or parts.
    """
    pulls = np.zeros(profile.size)
    depth = v = lost = 0.0
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
                        lost += s * (cap - 0.5 * d_depth * min(s / rate, 1.0))
                    t = math.copysign(cap, t)
                else:
                    stuck += 1
                force += t
                energy += 0.5 * t * t
                pulls[i] = t
            elif depth > y:
                s = abs(pulls[i] + d_shift * ((depth - y) / -d_depth))
                if sticks:
                    lost += 0.5 * s * s
                elif s > 0.0:
                    rate = (
                        math.copysign(1.0, pulls[i] + d_shift * ((depth - y) / -d_depth)) * d_shift - d_depth
                    )
                    lost -= 0.5 * d_depth * s * min(s / rate, 1.0)
                pulls[i] = 0.0
        out[0, j], out[1, j], out[2, j], out[3, j] = force, stuck, energy, lost
        depth, v = d, v1
