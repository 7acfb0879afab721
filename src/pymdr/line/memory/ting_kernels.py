"""Compiled approach and retreat of bodies with memory, by tables of their stiffness. Imported only when one is followed: it loads numba."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pymdr import compiling
from pymdr.numerics.graded import reading
from pymdr.numerics.graded.layout import MAX
from pymdr.units import FloatArray

_fused = compiling.Fused(__file__)

MET, TOUCHED_AGAIN = 0, 1
"""Endings of a path: all targets are met, or the contact grows while the bodies separate."""
_LEAST, _FEW, _MANY = (np.polynomial.legendre.leggauss(n) for n in (4, 10, 16))
"""Nodes and weights of parts in which depth and time change little, in which the depth grows by less than 2.5, and by more."""
_STEADY, _BRIEF = 0.9, 0.25
"""Ratio of the depths above which they change little; relaxation times below which the time does."""
_GROWN, _TIMES = 0.4, 4.0
"""Ratio of the depths at the ends of a part above which the stiffness is smooth over it; relaxation times in a part."""
_STRAIGHT, _STEPS, _CLOSE = 10, 200, 1e-14
"""Of a search for a root: steps after which every other one halves, and their number; and of the depth or of a row."""
_CONSTANT = 1e-13
"""Decrease of a constant travel that counts as rounding, relative to the travel."""
_FORGOTTEN = 36.0
"""Relaxation times after which a contribution is below rounding."""
_SHORT = 1e-7
"""Of a rise: what is moved within a relaxation time of which the mean delay stands for its course."""
_SAME = 1e-9
"""Fraction of the largest load per length by which a contact that does not grow may fall short."""


class Bodies(NamedTuple):
    """Two bodies by the table of their stiffness over the depth, their relaxation, and the compliance of the machine in m/N."""

    table: FloatArray
    equilibrium: float
    viscosity: float
    moduli: FloatArray
    times: FloatArray
    softness: float


class Record(NamedTuple):
    """Rows: t, d, and by the branches what the contact bears and how far the bodies moved, both as it is left of them."""

    time: FloatArray
    depth: FloatArray
    carried: FloatArray
    path: FloatArray


@_fused.inner
def _stiffness(bodies: Bodies, depth: float) -> float:
    """Stiffness per unit modulus in m at a positive depth; constant beyond the table."""
    return reading.read(bodies.table, min(depth, bodies.table[0, MAX]))[0]


@_fused.inner
def _force(bodies: Bodies, depth: float) -> float:
    """The integral of the stiffness in m^2, 0 without contact."""
    return reading.read(bodies.table, min(depth, bodies.table[0, MAX]))[1] if depth > 0.0 else 0.0


@_fused.inner
def _mean(x: float) -> float:
    """The mean of an exponential over x of its times."""
    return -math.expm1(-x) / x if x > 1e-300 else 1.0


@_fused.inner
def _gained(bodies: Bodies, low: float, high: float, wait: float, time: float) -> float:
    """The integral of exp(-(end - s)/time) dF0 over a straight rise, whose part before the bodies touch counts for nothing."""
    if high <= 0.0 or high <= low:
        return 0.0
    if wait <= 0.0:
        return _force(bodies, high) - _force(bodies, low)
    speed = (high - low) / wait
    last = time * speed
    if last < _SHORT * (high - max(low, 0.0)):  # the difference of depths below would lose its digits
        return last * _stiffness(bodies, high - last)
    begin = max(low, 0.0, high - _FORGOTTEN * last)
    parts = max(1, math.ceil((high - begin) / (_TIMES * last)))
    total, width = 0.0, (high - begin) / parts
    for p in range(parts):
        start, end = begin + width * p, begin + width * (p + 1)
        if start > _GROWN * end:
            few = start > _STEADY * end and width < _BRIEF * last
            nodes, weights = _LEAST if few else _FEW
            for q in range(nodes.size):
                depth = start + 0.5 * width * (1.0 + nodes[q])
                fading = math.exp(-max(high - depth, 0.0) / last)
                total += 0.5 * width * weights[q] * _stiffness(bodies, depth) * fading
        else:  # smooth in the fourth root of the depth
            here = math.sqrt(math.sqrt(start))
            half = 0.5 * (math.sqrt(math.sqrt(end)) - here)
            for q in range(_MANY[0].size):
                root = here + half * (1.0 + _MANY[0][q])
                fading = math.exp(-max(high - root**4, 0.0) / last)
                total += 4.0 * half * _MANY[1][q] * root**3 * _stiffness(bodies, root**4) * fading
    return total


@_fused.inner
def _borne(bodies: Bodies, carried: FloatArray, low: float, high: float, wait: float) -> float:
    """The force in N of a contact that grows from one depth to another."""
    moduli, times = bodies.moduli, bodies.times
    total = bodies.equilibrium * _force(bodies, high)
    for j in range(times.size):
        fresh = _gained(bodies, low, high, wait, times[j])
        total += moduli[j] * (math.exp(-wait / times[j]) * carried[j] + fresh)
    if bodies.viscosity > 0.0 and high > low and high > 0.0:
        total += bodies.viscosity * (high - low) / wait * _stiffness(bodies, high)
    return float(total)


@_fused.inner
def _pressed(
    bodies: Bodies, carried: FloatArray, low: float, wait: float, target: float
) -> tuple[float, float]:
    """
    The depth in m at which a growing contact meets a travel, and the force there; -inf if it would have to shrink.

    A dashpot may bear nearly all of a travel: the force is then that of the deflection of the machine.
    """
    softness = bodies.softness
    if softness == 0.0 or target <= 0.0:
        return target, _borne(bodies, carried, low, target, wait)
    under, over, side = max(low, 0.0), target, 0
    short = -target
    if low > 0.0:
        force = _borne(bodies, carried, low, low, wait)
        short = low + softness * force - target
        if short > _CONSTANT * target:
            return -math.inf, 0.0
        if short >= 0.0:
            return low, force
    much = softness * _borne(bodies, carried, low, target, wait)
    for step in range(_STEPS):
        if over - under <= _CLOSE * over or much == short:
            break
        depth = (under * much - over * short) / (much - short)
        if step > _STRAIGHT and step % 2:
            depth = 0.5 * (under + over)
        force = _borne(bodies, carried, low, depth, wait)
        off = depth + softness * force - target
        if off > 0.0:
            over, much, short = depth, off, 0.5 * short if side > 0 else short
            side = 1
        else:
            under, short, much = depth, off, 0.5 * much if side < 0 else much
            side = -1
        if abs(off) <= _CLOSE * target:
            return depth, force
    return over, (target - over) / softness


@_fused.inner
def _pull(
    bodies: Bodies, record: Record, row: int, part: float, now: int, target: float
) -> tuple[float, float, float]:
    """
    The negative load per length at the edge of the contact at a part of an earlier row, and the force and the depth now.

    The first rises with the part.
    """
    (time, depth, carried, path), moduli, times = record, bodies.moduli, bodies.times
    wait, move = part * (time[row + 1] - time[row]), part * (depth[row + 1] - depth[row])
    force = bodies.equilibrium * _force(bodies, depth[row] + move)
    lag = time[now] - time[row] - wait
    for j in range(times.size):
        rest = math.exp(-lag / times[j])
        if rest > 0.0:
            old = carried[row, j]
            if part > 0.0:
                old = math.exp(-wait / times[j]) * old + _gained(
                    bodies, depth[row], depth[row] + move, wait, times[j]
                )
            force += moduli[j] * rest * old
    there = target - bodies.softness * force
    duration, change = time[now] - time[now - 1], there - depth[now - 1]
    total = bodies.equilibrium * (depth[row] + move - there)
    if bodies.viscosity > 0.0 and change != 0.0:
        total -= bodies.viscosity * change / duration
    for j in range(times.size):
        then = math.exp(-wait / times[j]) * path[row, j] + _mean(wait / times[j]) * move
        x = duration / times[j]
        total -= moduli[j] * (
            math.exp(-x) * path[now - 1, j] + _mean(x) * change - math.exp(-lag / times[j]) * then
        )
    return float(total), force, there


@_fused.compiled
def follow(bodies: Bodies, record: Record, target: FloatArray, force: FloatArray) -> int:
    """
    Follow travels, or indentations where the softness is 0, of bodies that are apart at first; how it ended.

    The record, filled here but for its times, and `force` have one row per target; the first is that before a sudden move.
    """
    (time, depth, carried, path), moduli, times = record, bodies.moduli, bodies.times
    n, kinds = target.size, times.size
    depth[0], force[0] = target[0], 0.0
    top = 0
    while top + 1 < n:  # grows
        k = top + 1
        wait = time[k] - time[top]
        there, pressing = _pressed(bodies, carried[top], depth[top], wait, target[k])
        if there < depth[top] and depth[top] > 0.0:
            break
        depth[k], force[k] = there, pressing
        for j in range(kinds):
            x = wait / times[j]
            path[k, j] = math.exp(-x) * path[top, j] + _mean(x) * (there - depth[top])
            carried[k, j] = math.exp(-x) * carried[top, j] + _gained(
                bodies, depth[top], there, wait, times[j]
            )
        top = k
    first = top
    while first > 0 and depth[first] > 0.0:
        first -= 1
    begin = -depth[first] / (depth[first + 1] - depth[first]) if top > first else 0.0
    allowed = bodies.equilibrium * max(depth[top], 0.0)
    for j in range(kinds):
        allowed += moduli[j] * path[top, j]
    allowed *= _SAME
    row, part = top - 1, 1.0
    for k in range(top + 1, n):  # shrinks
        over, pressing, there = _pull(bodies, record, row, part, k, target[k])
        if over < -allowed:
            return TOUCHED_AGAIN
        if over > allowed:
            high, part = part, 0.0
            under = over
            while True:
                part = begin if row == first else 0.0
                under, pressing, there = _pull(bodies, record, row, part, k, target[k])
                if under <= 0.0 or row == first:
                    break
                row, high, over = row - 1, 1.0, under
            if under < 0.0:
                low, side = part, 0
                for step in range(_STEPS):
                    if high - low <= _CLOSE or over == under:
                        break
                    part = (low * over - high * under) / (over - under)
                    if step > _STRAIGHT and step % 2:
                        part = 0.5 * (low + high)
                    off, pressing, there = _pull(bodies, record, row, part, k, target[k])
                    if off == 0.0:
                        break
                    if off > 0.0:
                        high, over, under = part, off, 0.5 * under if side > 0 else under
                        side = 1
                    else:
                        low, under, over = part, off, 0.5 * over if side < 0 else over
                        side = -1
                    if abs(off) <= 1e-3 * allowed:
                        break
        force[k], depth[k] = pressing, there
        duration, change = time[k] - time[k - 1], depth[k] - depth[k - 1]
        for j in range(kinds):
            x = duration / times[j]
            path[k, j] = math.exp(-x) * path[k - 1, j] + _mean(x) * change
    return MET
