"""Compiled steps of a cohesive zone on springs with memory. Loads numba.

The state of a spring at x are the displacements v_j of its dashpots, which never jump: q = w - W with W = sum e_j v_j in
units of the instantaneous modulus. In contact (x < a) v_j = D_j(t) - g + y_j with D_j = int exp(-(t - s)/tau_j) d ds/tau_j, so
the deviations y_j decay alone. Outside it the modes m_j obey m' = -lambda m + beta q with q = -2 sigma sqrt(c^2 - x^2) in the
zone (a < x < c) and 0 beyond, W = beta . m. At frozen v the contact is elastic with the profile g + W. Nodes keep y or m of the
time at which they were last in motion: beyond the zone both only decay.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pymdr import compiling
from pymdr.units import FloatArray


def inner(function: compiling.Function) -> compiling.Function:
    """Compile for other kernels only."""
    return compiling.compiled(function, None, **compiling.INNER)


TIME, RADIUS, OUTER, DEPTH, FORCE, COUNT, FIRST, LAST = range(8)
"""Entries of a state: t, a, c, d, F, the number of steps, and in the end of a step the nodes of its zone, -1 for all."""
_TOUCHING = 1e-3
"""Distance of a node from an end of the zone, over the spacing, within which the end stands for it."""
_LONG = 3.0
_POINTS = np.array([0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262])
_WEIGHTS = np.array([0.17392742256872692, 0.32607257743127305, 0.32607257743127305, 0.17392742256872692])
_CELL_POINTS = np.array([0.1127016653792583, 0.5, 0.8872983346207417])
_CELL_WEIGHTS = np.array([0.2777777777777778, 0.4444444444444444, 0.2777777777777778])


class Body(NamedTuple):
    """Springs in units of the instantaneous modulus, with the cohesive stress and its range."""

    sigma: float
    height: float
    share: FloatArray
    """(n,) e_j = E_j / E_0."""
    rate: FloatArray
    """(n,) 1/tau_j."""
    decay: FloatArray
    """(n,) rates lambda_j of the modes of creep."""
    reach: FloatArray
    """(n,) beta_j: W = beta . m."""
    into: FloatArray
    """(n, n) m = into v."""
    back: FloatArray
    """(n, n) v = back m."""


class Line(NamedTuple):
    """The profile on uniform nodes from x = 0 on."""

    spacing: float
    g: FloatArray
    area: FloatArray
    """int_0^x g."""


class State(NamedTuple):
    """Where the contact is, and the springs."""

    now: FloatArray
    """TIME ... COUNT."""
    node: FloatArray
    """(nodes, n) y in contact, m outside."""
    since: FloatArray
    """(nodes,) time of the entries of each node."""
    depth: FloatArray
    """(n,) D_j."""
    sum: FloatArray
    """(n,) int_0^a y_j dx."""
    edge: FloatArray
    """(3, n) y and m at x = a, and m at x = c."""


class Step(NamedTuple):
    """A trial step of the length `length` to a, c."""

    length: float
    alpha: float
    beta: float
    control: float
    """alpha d + beta F at its end."""
    end: FloatArray
    """TIME ... FORCE at its end."""
    depth: FloatArray
    sum: FloatArray
    edge: FloatArray
    fade: FloatArray
    """(3, n) exp(-x), and the weights of d at both ends in D, x = length / tau."""
    room: FloatArray
    """(4, n) work space."""
    theta: FloatArray
    value: FloatArray


@inner
def fades(rate: float, length: float) -> tuple[float, float, float]:
    """exp(-x) and the weights of the values at both ends of a straight line, x = rate length."""
    x = rate * length
    e = math.exp(-x)
    mean = -math.expm1(-x) / x if x > 1e-8 else 1.0 - 0.5 * x
    return e, mean - e, 1.0 - mean


@inner
def cubic(x: float, at: FloatArray, values: FloatArray, count: int) -> float:
    """Lagrange's polynomial through up to four points."""
    total = 0.0
    for i in range(count):
        term = values[i]
        for k in range(count):
            if k != i:
                term *= (x - at[k]) / (at[i] - at[k])
        total += term
    return total


@inner
def of_table(line: Line, table: FloatArray, x: float) -> float:
    """A function of even parity in a table of nodes."""
    h = line.spacing
    k = min(max(int(x / h) - 1, 0), table.size - 4)
    total = 0.0
    u = x / h - k
    total += table[k] * (u - 1.0) * (u - 2.0) * (u - 3.0) / -6.0
    total += table[k + 1] * u * (u - 2.0) * (u - 3.0) / 2.0
    total += table[k + 2] * u * (u - 1.0) * (u - 3.0) / -2.0
    total += table[k + 3] * u * (u - 1.0) * (u - 2.0) / 6.0
    return float(total)


@inner
def deviation_at(body: Body, line: Line, state: State, x: float, out: FloatArray) -> None:
    """y_j now at x <= a."""
    now, h = state.now, line.spacing
    t, a = now[TIME], now[RADIUS]
    last = math.ceil((a - _TOUCHING * h) / h) - 1
    at, values = np.empty(4), np.empty(4)
    n = out.size
    if last < 3:
        for j in range(n):
            centre = state.node[0, j] * math.exp(-body.rate[j] * (t - state.since[0]))
            out[j] = centre + (state.edge[0, j] - centre) * (x / a) ** 2
        return
    k = int(x / h)
    first = min(k - 1, last - 3)
    with_edge = first == last - 3 and x > (last - 1) * h
    if with_edge:
        first = last - 2
    for j in range(n):
        for i in range(4):
            if with_edge and i == 3:
                at[i], values[i] = a, state.edge[0, j]
            else:
                own = abs(first + i)
                at[i] = (first + i) * h
                values[i] = state.node[own, j] * math.exp(-body.rate[j] * (t - state.since[own]))
        out[j] = cubic(x, at, values, 4)


@inner
def modes_at(body: Body, line: Line, state: State, x: float, out: FloatArray) -> None:
    """m_j now at x >= a."""
    now, h = state.now, line.spacing
    t, a, c = now[TIME], now[RADIUS], now[OUTER]
    at, values = np.empty(4), np.empty(4)
    inside = x < c
    low = math.floor((a + _TOUCHING * h) / h) + 1 if a > 0.0 else 0
    high = math.ceil((c - _TOUCHING * h) / h) - 1
    # positions in order: the edge or rim before node `low`, the nodes, and the rim after node `high`
    bottom, top = low, high + 1
    if inside:
        bottom = low - 1 if a > 0.0 else low
    else:
        low = high + 1
        while low * h < c + _TOUCHING * h:
            low += 1
        bottom, top = (low - 1 if c > 0.0 else low), state.since.size - 1
    count = min(4, top - bottom + 1)
    k = int(x / h)
    first = max(min(k - 1, top - count + 1), bottom)
    for j in range(out.size):
        for i in range(count):
            own = first + i
            place = own * h
            if own == low - 1:
                place, values[i] = (a, state.edge[1, j]) if inside else (c, state.edge[2, j])
            elif inside and own == high + 1:
                place, values[i] = c, state.edge[2, j]
            else:
                values[i] = state.node[own, j] * math.exp(-body.decay[j] * (t - state.since[own]))
            at[i] = math.sqrt(max(c - place, 0.0)) if inside else place
        out[j] = cubic(math.sqrt(c - x) if inside else x, at, values, count)


@inner
def pulled(
    body: Body,
    squares: tuple[float, float],
    x: float,
    part: tuple[float, float],
    length: float,
    m: FloatArray,
) -> None:
    """Advance modes at x over a part of a step, whose c^2 goes straight between two squares."""
    s0, s1 = part
    A, B = squares[0] - x * x, squares[1] - squares[0]
    n = m.size
    low, high = A + B * s0, A + B * s1
    if (low <= 0.0 and high <= 0.0) or s1 <= s0:
        for j in range(n):
            m[j] *= math.exp(-body.decay[j] * (s1 - s0) * length)
        return
    sa, sb = s0, s1
    if low < 0.0:
        sa = -A / B
    if high < 0.0:
        sb = -A / B
    ra, rb = math.sqrt(max(low, 0.0)), math.sqrt(max(high, 0.0))
    L = (sb - sa) * length
    for j in range(n):
        lam = body.decay[j]
        X = lam * L
        total = 0.0
        if X < _LONG:
            for i in range(4):
                u = _POINTS[i]
                r = ra + u * (rb - ra)
                done = u * (2.0 * ra + u * (rb - ra)) / (ra + rb)
                total += _WEIGHTS[i] * 2.0 * r * r / (ra + rb) * math.exp(-X * (1.0 - done))
            total *= L
        else:
            _, w0, w1 = fades(lam, L)
            total = (w0 * ra + w1 * rb) / lam
        total *= math.exp(-lam * (s1 - sb) * length)
        m[j] = m[j] * math.exp(-lam * (s1 - s0) * length) - 2.0 * body.sigma * body.reach[j] * total


@inner
def depth_sums(body: Body, state: State, depths: tuple[float, float], length: float, out: FloatArray) -> None:
    """D_j after a straight move of the depth."""
    for j in range(out.size):
        e, w0, w1 = fades(body.rate[j], length)
        out[j] = e * state.depth[j] + w0 * depths[0] + w1 * depths[1]


@inner
def node_end(body: Body, line: Line, state: State, step: Step, i: int, out: FloatArray) -> bool:
    """The entries of a node at the end of a step, and whether it is in contact then."""
    x, now, end = i * line.spacing, state.now, step.end
    a0, a1, d0, d1 = now[RADIUS], end[RADIUS], now[DEPTH], end[DEPTH]
    squares = (now[OUTER] ** 2, end[OUTER] ** 2)
    length, n = step.length, out.size
    idle = now[TIME] - state.since[i]
    was, stays = x < a0, x < a1
    crossing = (a0 - x) / (a0 - a1) if was != stays else 0.0
    if was:
        for j in range(n):
            out[j] = state.node[i, j] * math.exp(
                -body.rate[j] * (idle + (1.0 if stays else crossing) * length)
            )
        if stays:
            return True
        sums = step.room[3]
        depth_sums(body, state, (d0, d0 + crossing * (d1 - d0)), crossing * length, sums)
        for j in range(n):
            sums[j] += out[j] - line.g[i]
        for j in range(n):
            out[j] = 0.0
            for k in range(n):
                out[j] += body.into[j, k] * sums[k]
        pulled(body, squares, x, (crossing, 1.0), length, out)
        return False
    for j in range(n):
        out[j] = state.node[i, j] * math.exp(-body.decay[j] * idle)
    if not stays:
        pulled(body, squares, x, (0.0, 1.0), length, out)
        return False
    pulled(body, squares, x, (0.0, crossing), length, out)
    sums = step.room[3]
    depth_sums(body, state, (d0, d0 + crossing * (d1 - d0)), crossing * length, sums)
    held = step.room[2]
    for j in range(n):
        held[j] = line.g[i] - sums[j]
        for k in range(n):
            held[j] += body.back[j, k] * out[k]
    for j in range(n):
        out[j] = held[j] * math.exp(-body.rate[j] * (1.0 - crossing) * length)
    return True


@inner
def at_edge(body: Body, line: Line, state: State, step: Step) -> None:
    """y, m and d at the end of the contact after a step, and the sums over it that d gives."""
    now, end = state.now, step.end
    a0, a1, c1, d0 = now[RADIUS], end[RADIUS], end[OUTER], now[DEPTH]
    n, room = body.rate.size, step.room
    pull = 2.0 * body.sigma * math.sqrt(max((c1 - a1) * (c1 + a1), 0.0))
    g = of_table(line, line.g, a1)
    if a1 <= a0:
        deviation_at(body, line, state, a1, room[0])
        fixed, slope = g - pull, 1.0
        for j in range(n):
            room[0, j] *= step.fade[0, j]
            known = step.fade[0, j] * state.depth[j] + step.fade[1, j] * d0 - g + room[0, j]
            fixed += body.share[j] * known
            slope -= body.share[j] * step.fade[2, j]
        d1 = fixed / slope
        for j in range(n):
            step.depth[j] = step.fade[0, j] * state.depth[j] + step.fade[1, j] * d0 + step.fade[2, j] * d1
            step.edge[0, j] = room[0, j]
            room[1, j] = step.depth[j] - g + room[0, j]
        for j in range(n):
            step.edge[1, j] = 0.0
            for k in range(n):
                step.edge[1, j] += body.into[j, k] * room[1, k]
    else:
        modes_at(body, line, state, a1, room[0])
        pulled(body, (now[OUTER] ** 2, c1**2), a1, (0.0, 1.0), step.length, room[0])
        d1 = g - pull
        for j in range(n):
            d1 += body.reach[j] * room[0, j]
            step.edge[1, j] = room[0, j]
        for j in range(n):
            step.depth[j] = step.fade[0, j] * state.depth[j] + step.fade[1, j] * d0 + step.fade[2, j] * d1
            step.edge[0, j] = g - step.depth[j]
            for k in range(n):
                step.edge[0, j] += body.back[j, k] * room[0, k]
    end[DEPTH] = d1


@inner
def contact_sums(body: Body, line: Line, state: State, step: Step) -> None:
    """int_0^a y_j dx at the end of a step."""
    now, end, h = state.now, step.end, line.spacing
    a0, a1, t = now[RADIUS], end[RADIUS], now[TIME]
    n, here = body.rate.size, step.room[0]
    low, high = min(a0, a1), max(a0, a1)
    receding = a1 <= a0
    for j in range(n):
        step.sum[j] = state.sum[j] if receding else state.sum[j] * step.fade[0, j]
    if high == low:
        for j in range(n):
            step.sum[j] *= step.fade[0, j]
        return
    first = math.floor((low + _TOUCHING * h) / h) + 1
    last = math.ceil((high - _TOUCHING * h) / h) - 1
    if receding:
        # the ends: y at a1 before the step, and at a0
        before = step.room[1]
        if a1 > 0.0:
            deviation_at(body, line, state, a1, before)
        else:
            first = 1
            for j in range(n):
                before[j] = state.node[0, j] * math.exp(-body.rate[j] * (t - state.since[0]))
        place = low
        for i in range(first, last + 2):
            x = i * h if i <= last else high
            for j in range(n):
                y = state.edge[0, j]
                if i <= last:
                    y = state.node[i, j] * math.exp(-body.rate[j] * (t - state.since[i]))
                step.sum[j] -= 0.5 * (x - place) * (before[j] + y)
                before[j] = y
            place = x
        for j in range(n):
            step.sum[j] *= step.fade[0, j]
        return
    before = step.room[1]
    place = low
    if a0 > 0.0:
        for j in range(n):
            before[j] = state.edge[0, j] * step.fade[0, j]
    else:
        node_end(body, line, state, step, 0, here)
        first = 1
        for j in range(n):
            before[j] = here[j]
    for i in range(first, last + 2):
        x = i * h if i <= last else high
        if i <= last:
            node_end(body, line, state, step, i, here)
        for j in range(n):
            y = here[j] if i <= last else step.edge[0, j]
            step.sum[j] += 0.5 * (x - place) * (before[j] + y)
            before[j] = y
        place = x


@inner
def residuals(body: Body, line: Line, state: State, step: Step) -> tuple[float, float]:
    """What is missing of the range of the stress at c, over that range, and of the control."""
    end, h, sigma = step.end, line.spacing, body.sigma
    a, c = end[RADIUS], end[OUTER]
    n, m = body.rate.size, step.room[0]
    if a > 0.0:
        at_edge(body, line, state, step)
        contact_sums(body, line, state, step)
        d = end[DEPTH]
        area = of_table(line, line.area, a)
        inside = a * d - area
        for j in range(n):
            inside -= body.share[j] * (a * step.depth[j] - area + step.sum[j])
        root = math.sqrt(max((c - a) * (c + a), 0.0))
        end[FORCE] = 2.0 * inside - 2.0 * sigma * (c * c * math.atan2(root, a) - a * root)
        off = step.alpha * d + step.beta * end[FORCE] - step.control
    else:
        end[FORCE] = -math.pi * sigma * c * c
        end[DEPTH] = (step.control - step.beta * end[FORCE]) / step.alpha
        d = end[DEPTH]
        for j in range(n):
            step.sum[j] = 0.0
            step.depth[j] = (
                step.fade[0, j] * state.depth[j] + step.fade[1, j] * state.now[DEPTH] + step.fade[2, j] * d
            )
        off = 0.0
    low = math.floor((a + _TOUCHING * h) / h) + 1 if a > 0.0 else 0
    high = math.ceil((c - _TOUCHING * h) / h) - 1
    if end[LAST] >= 0.0:
        # the same nodes in a whole step, so that what is missing is smooth
        low, high = max(int(end[FIRST]), low), min(int(end[LAST]), high)
    total = of_table(line, line.g, c)
    if c >= state.now[RADIUS]:
        modes_at(body, line, state, c, m)
        pulled(body, (state.now[OUTER] ** 2, c * c), c, (0.0, 1.0), step.length, m)
    else:  # a jump
        deviation_at(body, line, state, c, step.room[1])
        for j in range(n):
            m[j] = 0.0
            for k in range(n):
                m[j] += body.into[j, k] * (state.depth[k] - total + step.room[1, k])
    for j in range(n):
        step.edge[2, j] = m[j]
        total += body.reach[j] * m[j]
    step.theta[0], step.value[0] = 0.0, total - d
    count = 1
    for i in range(high, low - 1, -1):
        node_end(body, line, state, step, i, m)
        total = line.g[i]
        for j in range(n):
            total += body.reach[j] * m[j]
        step.theta[count], step.value[count] = math.sqrt(c - i * h), total - d
        count += 1
    if a > 0.0:
        total = of_table(line, line.g, a)
        for j in range(n):
            total += body.reach[j] * step.edge[1, j]
        step.theta[count], step.value[count] = math.sqrt(c - a), total - d
        count += 1
    gap = -4.0 * sigma / math.pi * (c - a) + 4.0 / math.pi * over_zone(step, count, c)
    return gap / body.height - 1.0, off


@inner
def choose_nodes(line: Line, end: FloatArray) -> None:
    """The nodes of the zone of a step, by its predicted end."""
    h, a, c = line.spacing, end[RADIUS], end[OUTER]
    end[FIRST] = math.floor((a + 0.3 * h) / h) + 1.0 if a > 0.0 else 0.0
    end[LAST] = math.ceil((c - 0.3 * h) / h) - 1.0


@inner
def over_zone(step: Step, count: int, c: float) -> float:
    """The integral of the values over theta / sqrt(2 c - theta^2), cubic between the points."""
    total, at = 0.0, 0.0
    order = min(4, count)
    for cell in range(1, count):
        to = step.theta[cell]
        first = min(max(cell - 2, 0), count - order)
        for i in range(3):
            theta = at + _CELL_POINTS[i] * (to - at)
            value = cubic(theta, step.theta[first : first + order], step.value[first : first + order], order)
            total += _CELL_WEIGHTS[i] * (to - at) * value / math.sqrt(2.0 * c - theta * theta)
        at = to
    return total


@inner
def accept(body: Body, line: Line, state: State, step: Step) -> None:
    """Make the end of a step the state."""
    now, end, h = state.now, step.end, line.spacing
    low, high = min(now[RADIUS], end[RADIUS]), max(now[OUTER], end[OUTER])
    first = max(int(low / h) - 1, 0)
    last = min(int(high / h) + 1, state.since.size - 1)
    n, out = body.rate.size, step.room[0]
    for i in range(first, last + 1):
        node_end(body, line, state, step, i, out)
        for j in range(n):
            state.node[i, j] = out[j]
        state.since[i] = end[TIME]
    for j in range(n):
        state.depth[j], state.sum[j] = step.depth[j], step.sum[j]
        for k in range(3):
            state.edge[k, j] = step.edge[k, j]
    for i in range(FORCE + 1):
        now[i] = end[i]


@inner
def set_length(body: Body, state: State, step: Step, length: float, control: float) -> Step:
    """A step of another length from the same state."""
    for j in range(body.rate.size):
        step.fade[0, j], step.fade[1, j], step.fade[2, j] = fades(body.rate[j], length)
    step.end[TIME] = state.now[TIME] + length
    return Step(
        length,
        step.alpha,
        step.beta,
        control,
        step.end,
        step.depth,
        step.sum,
        step.edge,
        step.fade,
        step.room,
        step.theta,
        step.value,
    )
