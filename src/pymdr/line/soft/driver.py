"""Compiled paths of a cohesive zone on springs with memory: steps in time, and jumps at once. Loads numba."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pymdr.compiling import compiled
from pymdr.line.soft.kernels import (
    COUNT,
    DEPTH,
    FORCE,
    LAST,
    OUTER,
    RADIUS,
    TIME,
    Body,
    Line,
    State,
    Step,
    accept,
    choose_nodes,
    fades,
    inner,
    node_end,
    residuals,
    set_length,
)
from pymdr.units import FloatArray

DONE, STUCK, TOO_WIDE, TOO_MANY = range(4)
"""How a leg ends."""
OUT_TIME, OUT_A, OUT_C, OUT_D, OUT_F, OUT_JUMPED, OUT_STORED, OUT_COHESIVE, OUT_WORK, OUT_LOST, OUT_STEP = (
    range(11)
)
_ITERATIONS, _HALVINGS, _MOST = 12, 26, 300_000
_BISECTIONS, _SCANS = 80, 4000
_QUICK = 1e-5
"""Time of a jump over the shortest of a row and the relaxation times."""
_NOISE = 0.05
"""Scatter of c by interpolation, over the spacing of the nodes."""
_ENOUGH = 1e-4
"""Residual within which a solution may lie between values that differ by errors of interpolation, where steps are short."""


class Effort(NamedTuple):
    """Limits of a step."""

    share: float
    """Largest move of a and c over c - a."""
    missed: float
    """Largest difference from the extrapolated c over c - a."""
    solved: float
    """Residual at which a step is solved."""


@inner
def solve_step(
    body: Body, line: Line, state: State, step: Step, jacobian: FloatArray, solved: float, enough: float
) -> bool:
    """Newton's method for a and c, from those in the end of the step, by Broyden's updates; the best iterate if that is enough."""
    end = step.end
    least = body.height if step.alpha > 0.0 else body.sigma * end[OUTER] ** 2
    scale = max(abs(step.control), least)
    limit = (line.g.size - 4) * line.spacing
    x = np.array([end[RADIUS], end[OUTER]])
    f0, f1 = residuals(body, line, state, step)
    f = np.array([f0, f1 / scale])
    best, best_a, best_c = abs(f[0]) + abs(f[1]), x[0], x[1]
    fresh = jacobian[0, 0] == 0.0 and jacobian[1, 1] == 0.0
    for iteration in range(_ITERATIONS):
        if abs(f[0]) + abs(f[1]) < solved:
            return True
        if fresh or iteration == 5:
            fresh = False
            for k in range(2):
                change = 1e-6 * (x[1] - x[0]) * (1.0 if k == 1 else -1.0)
                end[RADIUS], end[OUTER] = x[0], x[1]
                if k == 0:
                    end[RADIUS] = x[0] + change
                else:
                    end[OUTER] = x[1] + change
                g0, g1 = residuals(body, line, state, step)
                jacobian[0, k], jacobian[1, k] = (g0 - f[0]) / change, (g1 / scale - f[1]) / change
        det = jacobian[0, 0] * jacobian[1, 1] - jacobian[0, 1] * jacobian[1, 0]
        if not abs(det) > 0.0:
            break
        da = -(jacobian[1, 1] * f[0] - jacobian[0, 1] * f[1]) / det
        dc = -(-jacobian[1, 0] * f[0] + jacobian[0, 0] * f[1]) / det
        zone = x[1] - x[0]
        most = max(abs(da), abs(dc)) / (0.5 * zone)
        if not most < 1e6:
            break
        if most > 1.0:
            da, dc = da / most, dc / most
        a, c = x[0] + da, x[1] + dc
        if a <= 0.0 or c <= a or c >= limit:
            break
        end[RADIUS], end[OUTER] = a, c
        g0, g1 = residuals(body, line, state, step)
        h = np.array([g0, g1 / scale])
        norm = da * da + dc * dc
        for i in range(2):
            # the model predicted what is left
            left = h[i] - f[i] - jacobian[i, 0] * da - jacobian[i, 1] * dc
            jacobian[i, 0] += left * da / norm
            jacobian[i, 1] += left * dc / norm
        x[0], x[1] = a, c
        f[0], f[1] = h[0], h[1]
        if abs(f[0]) + abs(f[1]) < best:
            best, best_a, best_c = abs(f[0]) + abs(f[1]), a, c
    if best < max(solved, enough):
        end[RADIUS], end[OUTER] = best_a, best_c
        residuals(body, line, state, step)
        return True
    return False


@inner
def solve_lifted(body: Body, line: Line, state: State, step: Step, effort: Effort) -> bool:
    """The zone without contact: c alone, from that in the end of the step, by the secant method."""
    end = step.end
    limit = (line.g.size - 4) * line.spacing
    end[RADIUS] = 0.0
    c = end[OUTER]
    f, _ = residuals(body, line, state, step)
    slope = 0.0
    for _ in range(2 * _ITERATIONS):
        if abs(f) < effort.solved:
            return True
        if slope == 0.0:
            end[OUTER] = c * (1.0 + 1e-6)
            g, _ = residuals(body, line, state, step)
            slope = (g - f) / (1e-6 * c)
        change = -f / slope
        if abs(change) > 0.3 * c:
            change = math.copysign(0.3 * c, change)
        if not 0.0 < c + change < limit:
            return False
        end[OUTER] = c + change
        g, _ = residuals(body, line, state, step)
        slope = (g - f) / change
        c, f = c + change, g
        if not slope > 0.0:
            return False
    return False


@inner
def lift(body: Body, state: State, step: Step) -> float:
    """The gap at the axis at the end of a step without contact; the entries of the node there are in the work space."""
    total = -2.0 * body.sigma * step.end[OUTER] - step.end[DEPTH]
    for j in range(body.rate.size):
        total += body.reach[j] * step.room[0, j]
    return float(total)


@inner
def edge_under(body: Body, line: Line, state: State, step: Step, c: float) -> float:
    """What is missing of the range at c at frozen springs, with the contact radius that the control gives; -1 where c is too small."""
    end = step.end
    end[OUTER] = c
    low, high = 1e-6 * c, c * (1.0 - 1e-9)
    end[RADIUS] = high
    _, off = residuals(body, line, state, step)
    if off < 0.0:
        return -1.0
    end[RADIUS] = low
    _, off = residuals(body, line, state, step)
    if off > 0.0:
        if step.alpha == 0.0:
            return 1e30
        end[RADIUS] = 0.0
        missing, _ = residuals(body, line, state, step)
        return missing
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        end[RADIUS] = middle
        _, off = residuals(body, line, state, step)
        if off < 0.0:
            low = middle
        else:
            high = middle
        if high - low < 1e-13 * c:
            break
    end[RADIUS] = 0.5 * (low + high)
    missing, _ = residuals(body, line, state, step)
    return missing


@inner
def jump(body: Body, line: Line, state: State, step: Step) -> bool:
    """Jump at frozen springs and constant control to the next stable state; False where the body separates."""
    end, h = step.end, line.spacing
    end[LAST] = -1.0
    limit = (line.g.size - 4) * h
    c = state.now[OUTER]
    if c == 0.0:
        c = 2.0 * h
        here = -1.0
    else:
        here = edge_under(body, line, state, step, c)
    outward = here < 0.0
    before = c
    for _ in range(_SCANS):
        zone = max(c - end[RADIUS], 2.0 * h) if c > 0.0 else 2.0 * h
        c = before + (0.05 if outward else -0.05) * zone
        if c <= 2.0 * h and not outward:
            return False
        if c >= limit:
            return False
        there = edge_under(body, line, state, step, c)
        if (there > 0.0) == outward:
            low, high = (before, c) if outward else (c, before)
            for _ in range(_BISECTIONS):
                middle = 0.5 * (low + high)
                if edge_under(body, line, state, step, middle) > 0.0:
                    high = middle
                else:
                    low = middle
                if high - low < 1e-13 * high:
                    break
            edge_under(body, line, state, step, 0.5 * (low + high))
            return True
        before = c
    return False


@inner
def separate(body: Body, line: Line, state: State, step: Step) -> None:
    """Free the springs at once."""
    end = step.end
    end[RADIUS], end[OUTER], end[FORCE] = 0.0, 0.0, 0.0
    end[DEPTH] = step.control / step.alpha if step.alpha > 0.0 else -body.height
    for j in range(body.rate.size):
        step.sum[j], step.depth[j] = 0.0, state.depth[j]
        step.edge[0, j], step.edge[1, j], step.edge[2, j] = 0.0, 0.0, 0.0
    accept(body, line, state, step)


@inner
def centre_creep(body: Body, state: State, length: float) -> float:
    """W at the axis of a free surface after a time."""
    total = 0.0
    for j in range(body.rate.size):
        idle = state.now[TIME] + length - state.since[0]
        total += body.reach[j] * state.node[0, j] * math.exp(-body.decay[j] * idle)
    return total


@inner
def begins(body: Body, state: State, step: Step, length: float, control: float) -> bool:
    """Whether a free surface is within the range of the stress after a time."""
    return centre_creep(body, state, length) - control / step.alpha - body.height <= 0.0


@inner
def wait_free(body: Body, state: State, step: Step, span: float, controls: tuple[float, float]) -> bool:
    """Let free springs creep until the attraction begins within a span, or to its end; whether it begins."""
    now = state.now
    p0, p1 = controls
    started, length = False, span
    if step.alpha > 0.0 and begins(body, state, step, span, p1):
        started, low, high = True, 0.0, span
        if begins(body, state, step, 0.0, p0):
            high = 0.0
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            if begins(body, state, step, middle, p0 + middle / span * (p1 - p0)):
                high = middle
            else:
                low = middle
        length = high
    share = length / span if span > 0.0 else 1.0
    d0 = now[DEPTH]
    d1 = (p0 + share * (p1 - p0)) / step.alpha if step.alpha > 0.0 else d0
    for j in range(body.rate.size):
        e, w0, w1 = fades(body.rate[j], length)
        state.depth[j] = e * state.depth[j] + w0 * d0 + w1 * d1
    now[TIME] += length
    now[DEPTH] = d1 if step.alpha > 0.0 else -body.height
    return started


@inner
def energies(body: Body, line: Line, state: State) -> tuple[float, float]:
    """Energy of the springs, and of the attraction, in units of the instantaneous modulus times a length cubed."""
    now, h = state.now, line.spacing
    t, a, c, d = now[TIME], now[RADIUS], now[OUTER], now[DEPTH]
    n = body.rate.size
    v, stored, cohesive = np.empty(n), 0.0, 0.0
    rest = 1.0
    for j in range(n):
        rest -= body.share[j]
    last = state.since.size - 1
    for i in range(state.since.size):
        x = i * h
        if x < a:
            for j in range(n):
                y = state.node[i, j] * math.exp(-body.rate[j] * (t - state.since[i]))
                v[j] = state.depth[j] - line.g[i] + y
            w = d - line.g[i]
        else:
            w = 0.0
            for j in range(n):
                v[j] = 0.0
            for k in range(n):
                m = state.node[i, k] * math.exp(-body.decay[k] * (t - state.since[i]))
                w += body.reach[k] * m
                for j in range(n):
                    v[j] += body.back[j, k] * m
            if x < c:
                w -= 2.0 * body.sigma * math.sqrt(c * c - x * x)
        own = rest * w * w
        for j in range(n):
            own += body.share[j] * (w - v[j]) ** 2
        weight = 0.5 * h if i == 0 or i == last else h
        stored += weight * own
        if a <= x < c:
            cohesive += weight * (line.g[i] - d + w) * math.sqrt(c * c - x * x)
    return stored, 4.0 * body.sigma * cohesive - math.pi * body.sigma * body.height * c * c


@inner
def fall(body: Body, line: Line, state: State, step: Step, out: FloatArray) -> None:
    """Jump to the next stable state, or separate; the loss is that of the energy at constant control."""
    was, before = potential(body, line, state, step), state.now[OUTER]
    depth = state.now[DEPTH]
    zone = before - state.now[RADIUS]
    if jump(body, line, state, step):
        end = step.end
        moved = abs(end[OUTER] - before)
        if step.alpha == 0.0:
            out[OUT_WORK] += step.control * (end[DEPTH] - depth)
        accept(body, line, state, step)
        jumped = moved > 0.02 * zone
    else:
        separate(body, line, state, step)
        jumped = before > 0.0
    if jumped:
        out[OUT_JUMPED] = 1.0
        out[OUT_LOST] += was - potential(body, line, state, step)


@inner
def potential(body: Body, line: Line, state: State, step: Step) -> float:
    """Energy of the springs, the attraction and the machine."""
    stored, cohesive = energies(body, line, state)
    force = state.now[FORCE]
    if step.alpha == 0.0:
        return stored + cohesive - (force * state.now[DEPTH] if state.now[OUTER] > 0.0 else 0.0)
    return float(stored + cohesive + 0.5 * step.beta * force * force)


@inner
def advance(
    body: Body,
    line: Line,
    state: State,
    step: Step,
    effort: Effort,
    span: float,
    controls: tuple[float, float],
    out: FloatArray,
) -> int:
    """Follow one row, over which the control is straight; the energies that it takes are added to `out`."""
    now = state.now
    begin = now[TIME]
    stop = begin + span
    jacobian = np.zeros((2, 2))
    rate_a, rate_c, known, halvings = 0.0, 0.0, False, 0
    length = min(span, out[OUT_STEP])
    tiny = 1e-13 * span
    quick = _QUICK * min(span, 1.0 / np.max(body.rate))
    while stop - now[TIME] > tiny:
        now[COUNT] += 1.0
        if now[COUNT] > _MOST:
            return TOO_MANY
        done = (now[TIME] - begin) / span
        here = controls[0] + done * (controls[1] - controls[0])
        if now[OUTER] == 0.0:
            pressed = step.alpha == 0.0 and here >= 0.0
            if not pressed:
                pressed = wait_free(body, state, step, stop - now[TIME], (here, controls[1]))
                done = (now[TIME] - begin) / span
                here = controls[0] + done * (controls[1] - controls[0])
            if not pressed:
                break
            step = set_length(body, state, step, 0.0, here)
            was = potential(body, line, state, step)
            if not jump(body, line, state, step):
                return TOO_WIDE
            if step.alpha == 0.0:
                was += here * body.height
                out[OUT_WORK] += here * (step.end[DEPTH] + body.height)
            accept(body, line, state, step)
            out[OUT_JUMPED] = 1.0
            out[OUT_LOST] += was - potential(body, line, state, step)
            known, halvings, jacobian[:] = False, 0, 0.0
            length = min(stop - now[TIME], 0.02 / np.max(body.rate))
            continue
        length = min(length, stop - now[TIME])
        to = controls[0] + (now[TIME] + length - begin) / span * (controls[1] - controls[0])
        step = set_length(body, state, step, length, to)
        a, c, d, force = now[RADIUS], now[OUTER], now[DEPTH], now[FORCE]
        zone, end = c - a, step.end
        guess = c + rate_c * length
        end[RADIUS], end[OUTER] = max(a + rate_a * length, 1e-3 * a), max(guess, 0.5 * (a + c))
        if end[RADIUS] >= end[OUTER]:
            end[RADIUS], end[OUTER] = a, c
        if a > 0.0:
            enough = _ENOUGH * 10.0 ** (halvings - 8.0) if halvings >= 3 else 0.0
            choose_nodes(line, end)
            solved = solve_step(body, line, state, step, jacobian, effort.solved, min(enough, 30.0 * _ENOUGH))
            end[LAST] = -1.0
        else:
            solved = solve_lifted(body, line, state, step, effort)
            if solved:
                node_end(body, line, state, step, 0, step.room[0])
                solved = lift(body, state, step) >= 0.0
        if solved:
            solved = max(abs(end[OUTER] - c), abs(end[RADIUS] - a)) <= effort.share * zone
            if known:
                solved = solved and abs(end[OUTER] - guess) <= effort.missed * zone + _NOISE * line.spacing
            else:
                solved = solved and abs(end[OUTER] - c) <= effort.missed * zone + _NOISE * line.spacing
        if not solved:
            jacobian[:] = 0.0
            length *= 0.5
            halvings += 1
            if halvings > 3:
                known = known and halvings < 6
                rate_a, rate_c = (rate_a, rate_c) if known else (0.0, 0.0)
            if halvings > _HALVINGS or length < quick:
                # slightly beyond a fold, where no state is left nearby
                length = min(4.0 * quick, stop - now[TIME])
                to = controls[0] + (now[TIME] + length - begin) / span * (controls[1] - controls[0])
                step = set_length(body, state, step, length, to)
                fall(body, line, state, step, out)
                known, halvings, rate_a, rate_c = False, 0, 0.0, 0.0
                length = min(stop - now[TIME], 0.02 / np.max(body.rate))
            continue
        rate_a, rate_c = (end[RADIUS] - a) / length, (end[OUTER] - c) / length
        away = abs(end[OUTER] - guess) / zone
        out[OUT_WORK] += 0.5 * (force + end[FORCE]) * (end[DEPTH] - d)
        if step.alpha > 0.0:
            out[OUT_WORK] += 0.5 * step.beta * (end[FORCE] ** 2 - force**2)
        accept(body, line, state, step)
        length *= 1.6 if halvings == 0 and (not known or away < 0.3 * effort.missed) else 1.0
        known, halvings = True, 0
        out[OUT_STEP] = length
    now[TIME] = stop
    return DONE


@compiled
def follow_rows(
    body: Body,
    line: Line,
    state: State,
    step: Step,
    effort: Effort,
    times: FloatArray,
    controls: FloatArray,
    out: FloatArray,
) -> int:
    """Follow rows; times and controls begin with those before the first row."""
    length = 0.02 / np.max(body.rate)
    for row in range(times.size - 1):
        out[row, OUT_STEP] = length
        span = times[row + 1] - times[row]
        ends = DONE
        if span == 0.0 and state.now[OUTER] == 0.0 and step.alpha > 0.0:
            state.now[DEPTH] = controls[row + 1] / step.alpha
        if span > 0.0:
            ends = advance(
                body, line, state, step, effort, span, (controls[row], controls[row + 1]), out[row]
            )
        if ends != DONE:
            return ends
        length = out[row, OUT_STEP]
        for i in range(FORCE + 1):
            out[row, i] = state.now[i]
        out[row, OUT_STORED], out[row, OUT_COHESIVE] = energies(body, line, state)
    return DONE
