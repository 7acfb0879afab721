"""Compiled springs with memory under a cohesive zone: what a step of the edges does to them. Loads numba.

The state of a spring at x are the displacements v_j of its dashpots, which never jump: q = w - W with W = sum e_j v_j in
units of the instantaneous modulus. In contact (x < a) v_j = D_j(t) - g + y_j with D_j = int exp(-(t - s)/tau_j) d ds/tau_j, so
the deviations y_j decay alone. Outside it the modes m_j obey m' = -lambda m + beta q with q = -2 sigma sqrt(c^2 - x^2) in the
zone (a < x < c) and 0 beyond, W = beta . m. At frozen v the contact is elastic with the profile g + W. Nodes keep y or m of the
time at which they were last in motion: beyond the zone both only decay.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from pymdr.compiling import Addressed, inner, merged
from pymdr.units import FloatArray

TIME, RADIUS, OUTER, DEPTH, FORCE, COUNT, SPENT = range(7)
"""t, a, c, d, F now and at the end of a step; now also the number of steps, and the energy dissipated in springs that a step has passed."""
LENGTH, ALPHA, BETA, CONTROL, SIGMA, HEIGHT, SPACING, KNOTS, CELLS, RISE = range(6, 16)
"""Entries of the end of a step: its length, alpha d + beta F = control at its end, cohesive stress and range, spacing of the nodes,
number of the nodes chosen for the gap, cells of the gap over the zone, slope of the gap in c."""
FRACTION, RATE, DECAY, PARTICIPATION, INTO = range(5)
"""Rows of a body: e_j = E_j/E_0, 1/tau_j, lambda_j, beta_j; from INTO on the matrix of m = into v, then that of v = back m."""
LAG, SUM, SQUARES, INNER_EDGE, OUTER_EDGE, RIM, SUM_BEFORE, SQUARES_BEFORE = range(8)
"""Rows at the edges: D_j, int_0^a y_j dx, int_0^a y_j^2 dx, y and m at x = a, m at x = c; both integrals before the step, to the smaller a."""
FADE, WAS, WILL, HERE, BEFORE, SCRATCH, KEPT, ENTRY, BEHIND = range(9)
"""Rows of the work space: exp(-x) and the weights of d at both ends of a step in D, x = length / tau; and seven vectors."""
TOUCHING = 1e-3
"""Distance of a node from an end of the zone, over the spacing, within which the end stands for it."""
_LONG = 3.0
_POINTS = np.array([0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262])
_WEIGHTS = np.array([0.17392742256872692, 0.32607257743127305, 0.32607257743127305, 0.17392742256872692])


class Zone(NamedTuple):
    """Springs, edges and a trial step, in units of the instantaneous modulus and the largest radius."""

    body: FloatArray
    """(4 + 2 n, n) for n relaxation times: rows FRACTION ... INTO."""
    profile: FloatArray
    """(2, nodes) g and int_0^x g on uniform nodes from x = 0 on."""
    now: FloatArray
    """TIME ... SPENT."""
    node: FloatArray
    """(nodes, n + 1) y in contact, m outside, and the time of the entries."""
    edge: FloatArray
    """(8, n) LAG ... SQUARES_BEFORE now."""
    end: FloatArray
    """TIME ... RISE at the end of a step."""
    after: FloatArray
    """(8, n) LAG ... SQUARES_BEFORE at the end of a step."""
    workspace: FloatArray
    """(9, n) work space."""
    stencil: FloatArray
    """(2, 4) places and weights of an interpolation."""
    points: FloatArray
    """(2, nodes) sqrt(c - x) in the zone and the gap there but for the stress."""
    chosen: npt.NDArray[np.int64]
    """(nodes,) nodes of the zone by which the gap is integrated, from c inward."""
    bear: Any = 0
    excess: Any = 0
    accept: Any = 0
    energies: Any = 0
    find: Any = 0
    """Addresses of what is long and called in several places."""


@inner
def fades(rate: float, length: float) -> tuple[float, float, float]:
    """exp(-x) and the weights of the values at both ends of a straight line, x = rate length."""
    x = rate * length
    e = math.exp(-x)
    mean = -math.expm1(-x) / x if x > 1e-8 else 1.0 - 0.5 * x
    return e, mean - e, 1.0 - mean


@inner
def weigh(zone: Zone, x: float, count: int) -> None:
    """Weights of Lagrange's polynomial at x through up to four places of the stencil."""
    stencil = zone.stencil
    for i in range(count):
        weight = 1.0
        for k in range(count):
            if k != i:
                weight *= (x - stencil[0, k]) / (stencil[0, i] - stencil[0, k])
        stencil[1, i] = weight


@inner
def cubics(table: FloatArray, place: float) -> tuple[float, float]:
    """Values of both rows of a table at a place in units of its nodes, by cubics."""
    k = min(max(int(place) - 1, 0), table.shape[1] - 4)
    u = place - k
    w0, w1 = (u - 1.0) * (u - 2.0) * (u - 3.0) / -6.0, u * (u - 2.0) * (u - 3.0) / 2.0
    w2, w3 = u * (u - 1.0) * (u - 3.0) / -2.0, u * (u - 1.0) * (u - 2.0) / 6.0
    first = w0 * table[0, k] + w1 * table[0, k + 1] + w2 * table[0, k + 2] + w3 * table[0, k + 3]
    second = w0 * table[1, k] + w1 * table[1, k + 1] + w2 * table[1, k + 2] + w3 * table[1, k + 3]
    return first, second


@inner
def of_table(zone: Zone, x: float) -> tuple[float, float]:
    """Values of g and of its integral at x."""
    return cubics(zone.profile, x / zone.end[SPACING])


@inner
def deviation_at(zone: Zone, x: float) -> None:
    """y_j now at x <= a, into HERE of the work space."""
    now, node, body, stencil = zone.now, zone.node, zone.body, zone.stencil
    h, t, a = zone.end[SPACING], now[TIME], now[RADIUS]
    n = body.shape[1]
    last = math.ceil((a - TOUCHING * h) / h) - 1
    if last < 3:
        for j in range(n):
            centre = node[0, j] * math.exp(-body[RATE, j] * (t - node[0, n]))
            zone.workspace[HERE, j] = centre + (zone.edge[INNER_EDGE, j] - centre) * (x / a) ** 2
        return
    first = min(int(x / h) - 1, last - 3)
    with_edge = first == last - 3 and x > (last - 1) * h
    if with_edge:
        first = last - 2
    for i in range(4):
        stencil[0, i] = a if with_edge and i == 3 else (first + i) * h
    count = stencil.shape[1]
    weigh(zone, x, count)
    for j in range(n):
        total = 0.0
        for i in range(4):
            if with_edge and i == 3:
                total += stencil[1, i] * zone.edge[INNER_EDGE, j]
            else:
                own = abs(first + i)
                total += stencil[1, i] * node[own, j] * math.exp(-body[RATE, j] * (t - node[own, n]))
        zone.workspace[HERE, j] = total


@inner
def modes_at(zone: Zone, x: float) -> None:
    """m_j now at x >= a, into HERE of the work space."""
    now, node, body, stencil = zone.now, zone.node, zone.body, zone.stencil
    h, t, a, c = zone.end[SPACING], now[TIME], now[RADIUS], now[OUTER]
    n = body.shape[1]
    inside = x < c
    low = math.floor((a + TOUCHING * h) / h) + 1 if a > 0.0 else 0
    high = math.ceil((c - TOUCHING * h) / h) - 1
    # positions in order: the edge or rim before node `low`, the nodes, and the rim after node `high`
    bottom, top = low, high + 1
    if inside:
        bottom = low - 1 if a > 0.0 else low
    else:
        low = high + 1
        while low * h < c + TOUCHING * h:
            low += 1
        bottom, top = (low - 1 if c > 0.0 else low), node.shape[0] - 1
    count = min(4, top - bottom + 1)
    first = max(min(int(x / h) - 1, top - count + 1), bottom)
    for i in range(count):
        own = first + i
        place = own * h
        if own == low - 1:
            place = a if inside else c
        elif inside and own == high + 1:
            place = c
        stencil[0, i] = math.sqrt(max(c - place, 0.0)) if inside else place
    weigh(zone, math.sqrt(c - x) if inside else x, count)
    for j in range(n):
        total = 0.0
        for i in range(count):
            own = first + i
            if own == low - 1:
                value = zone.edge[OUTER_EDGE if inside else RIM, j]
            elif inside and own == high + 1:
                value = zone.edge[RIM, j]
            else:
                idle = t - node[own, n]
                value = node[own, j]
                if idle > 0.0:
                    value *= math.exp(-body[DECAY, j] * idle)
            total += stencil[1, i] * value
        zone.workspace[HERE, j] = total


@inner
def pulled(zone: Zone, x: float, s0: float, s1: float) -> None:
    """Advance modes at x, in HERE of the work space, from s0 to s1 of a step, whose c^2 is linear in time."""
    body, workspace = zone.body, zone.workspace
    length, sigma = zone.end[LENGTH], zone.end[SIGMA]
    n = body.shape[1]
    A, B = zone.now[OUTER] ** 2 - x * x, zone.end[OUTER] ** 2 - zone.now[OUTER] ** 2
    low, high = A + B * s0, A + B * s1
    if (low <= 0.0 and high <= 0.0) or s1 <= s0:
        for j in range(n):
            workspace[HERE, j] *= math.exp(-body[DECAY, j] * (s1 - s0) * length)
        return
    sa = -A / B if low < 0.0 else s0
    sb = -A / B if high < 0.0 else s1
    ra, rb = math.sqrt(max(low, 0.0)), math.sqrt(max(high, 0.0))
    L = (sb - sa) * length
    for j in range(n):
        lam = body[DECAY, j]
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
        if s1 > sb:
            total *= math.exp(-lam * (s1 - sb) * length)
        kept = math.exp(-lam * (s1 - s0) * length)
        workspace[HERE, j] = workspace[HERE, j] * kept - 2.0 * sigma * body[PARTICIPATION, j] * total


@inner
def node_end(zone: Zone, i: int) -> bool:
    """The entries of a node at the end of a step, into HERE of the work space, and whether it is in contact then."""
    now, end, body, workspace = zone.now, zone.end, zone.body, zone.workspace
    n = body.shape[1]
    x, a0, a1, d0 = i * end[SPACING], now[RADIUS], end[RADIUS], now[DEPTH]
    length, idle = end[LENGTH], now[TIME] - zone.node[i, n]
    was, stays = x < a0, x < a1
    crossing = (a0 - x) / (a0 - a1) if was != stays else 0.0
    start, stop = 0.0, 1.0
    entries = RATE if was else DECAY
    contact_time = (length if stays else crossing * length) if was else 0.0
    for j in range(n):
        value = zone.node[i, j]
        if idle + contact_time > 0.0:
            value *= math.exp(-body[entries, j] * (idle + contact_time))
        workspace[HERE, j] = value
    if was and stays:
        return True
    if was or stays:
        if stays:
            pulled(zone, x, start, crossing)
        d1 = d0 + crossing * (end[DEPTH] - d0)
        for j in range(n):  # v in contact but for y
            e, w0, w1 = fades(body[RATE, j], crossing * length)
            workspace[SCRATCH, j] = e * zone.edge[LAG, j] + w0 * d0 + w1 * d1 - zone.profile[0, i]
            workspace[KEPT, j] = workspace[HERE, j]
        if stays:
            for j in range(n):
                y = -workspace[SCRATCH, j]
                for k in range(n):
                    y += body[INTO + n + j, k] * workspace[KEPT, k]
                workspace[HERE, j] = y * math.exp(-body[RATE, j] * (1.0 - crossing) * length)
            return True
        for j in range(n):
            workspace[HERE, j] = 0.0
            for k in range(n):
                workspace[HERE, j] += body[INTO + j, k] * (workspace[SCRATCH, k] + workspace[KEPT, k])
    pulled(zone, x, crossing, stop)
    return False


@inner
def mean_products(x: float) -> tuple[float, float, float]:
    """Means over a step of p^2, 2 p (1 - p) and (1 - p)^2, where p falls from 1 to 0 as exp(-x s)."""
    if x < 1e-3:
        mean, square = 0.5 - x / 12.0, 1.0 / 3.0 - x / 12.0
    else:
        rest = 1.0 / math.expm1(x) if x < 500.0 else 0.0
        mean = 1.0 / x - rest
        square = 0.5 / x - rest * mean
    return square, 2.0 * (mean - square), 1.0 - 2.0 * mean + square


@inner
def beyond_rounding(value: float, other: float) -> float:
    """A difference, 0 within the rounding of its terms: a long wait would multiply its square by many relaxation times."""
    difference = value - other
    return difference if abs(difference) > 4e-15 * abs(value) else 0.0


@merged
def spent_in_contact(zone: Zone, low: float) -> float:
    """Energy dissipated in a step in the springs that stay in contact, x < low, 2 int int sum e_j (w - v_j)^2 / tau_j dx dt."""
    now, end, body, edge, after = zone.now, zone.end, zone.body, zone.edge, zone.after
    total = 0.0
    for j in range(body.shape[1]):
        x = body[RATE, j] * end[LENGTH]
        e, before = zone.workspace[FADE, j], now[DEPTH] - edge[LAG, j]
        to = beyond_rounding(end[DEPTH], after[LAG, j])
        y, square = after[SUM_BEFORE, j], after[SQUARES_BEFORE, j]
        w0, w01, w1 = mean_products(x)
        total += (
            2.0
            * body[FRACTION, j]
            * x
            * (
                w0 * (before * before * low - 2.0 * before * y + square)
                + w01 * (before * to * low - (to + e * before) * y + e * square)
                + w1 * (to * to * low - 2.0 * to * e * y + e * e * square)
            )
        )
    return total


@inner
def spent_at(zone: Zone, i: int) -> float:
    """
    Energy per length dissipated at a node since the time of its entries, after `node_end`.

    Outside the contact it is 2 int sum m_j'^2 dt.
    """
    now, end, body, workspace = zone.now, zone.end, zone.body, zone.workspace
    n = body.shape[1]
    x, a0, a1, length = i * end[SPACING], now[RADIUS], end[RADIUS], end[LENGTH]
    idle = now[TIME] - zone.node[i, n]
    was, stays = x < a0, x < a1
    crossing = (a0 - x) / (a0 - a1) if was != stays else 0.0
    before = crossing * length if was != stays else length
    last = length - before
    # with the rounding of `pulled`
    first, change = now[OUTER] ** 2 - x * x, end[OUTER] ** 2 - now[OUTER] ** 2
    q0 = -2.0 * end[SIGMA] * math.sqrt(max(first, 0.0))
    q1 = -2.0 * end[SIGMA] * math.sqrt(max(first + change, 0.0))
    w = now[DEPTH] + crossing * (end[DEPTH] - now[DEPTH]) - zone.profile[0, i]
    total = 0.0
    for j in range(n):
        if was != stays:
            # w - v at the crossing
            lag = w
            if was:
                lag -= workspace[SCRATCH, j] + workspace[KEPT, j]
            else:
                for k in range(n):
                    lag -= body[INTO + n + j, k] * workspace[KEPT, k]
            workspace[BEFORE, j] = lag
    for j in range(n):
        rate = body[RATE, j] if was else body[DECAY, j]
        entry = zone.node[i, j]
        if not was and idle > 0.0:
            total += rate * entry * entry * -math.expm1(-2.0 * rate * idle)
        entry *= math.exp(-rate * idle)
        begin = now[DEPTH] - zone.edge[LAG, j] - entry if was else body[PARTICIPATION, j] * q0 - rate * entry
        weight = body[FRACTION, j] * rate if was else 1.0
        if was == stays:
            to = beyond_rounding(body[PARTICIPATION, j] * q1, rate * workspace[HERE, j])
            p, both, q = mean_products(rate * length)
            total += 2.0 * weight * length * (p * begin * begin + both * begin * to + q * to * to)
            continue
        speed = 0.0
        for k in range(n):
            speed += body[INTO + j, k] * body[RATE, k] * workspace[BEFORE, k]
        to = workspace[BEFORE, j] if was else speed
        p, both, q = mean_products(rate * before)
        total += 2.0 * weight * before * (p * begin * begin + both * begin * to + q * to * to)
        # the other side of the edge
        begin = speed if was else workspace[BEFORE, j]
        rate = body[DECAY, j] if was else body[RATE, j]
        weight = 1.0 if was else body[FRACTION, j] * rate
        to = beyond_rounding(body[PARTICIPATION, j] * q1, rate * workspace[HERE, j])
        if not was:
            to = beyond_rounding(end[DEPTH], zone.after[LAG, j]) - workspace[HERE, j]
        p, both, q = mean_products(rate * last)
        total += 2.0 * weight * last * (p * begin * begin + both * begin * to + q * to * to)
    return total


@inner
def spent_at_edge(zone: Zone) -> float:
    """Energy per length dissipated in a step where the smaller of both contacts ends, whose y before the step are in ENTRY of the work space."""
    now, end, body = zone.now, zone.end, zone.body
    total = 0.0
    for j in range(body.shape[1]):
        x, y = body[RATE, j] * end[LENGTH], zone.workspace[ENTRY, j]
        begin = now[DEPTH] - zone.edge[LAG, j] - y
        to = beyond_rounding(end[DEPTH], zone.after[LAG, j]) - zone.workspace[FADE, j] * y
        p, both, q = mean_products(x)
        total += 2.0 * body[FRACTION, j] * x * (p * begin * begin + both * begin * to + q * to * to)
    return total


@Addressed
def accept(zone: Zone) -> None:
    """Make the end of a step the state."""
    now, end, node = zone.now, zone.end, zone.node
    n, h = zone.body.shape[1], end[SPACING]
    low, high = min(now[RADIUS], end[RADIUS]), max(now[OUTER], end[OUTER])
    first = max(int(low / h) - 1, 0)
    last = min(int(high / h) + 1, node.shape[0] - 1)
    spent, at_edge, next_to = 0.0, 0.0, True
    if low > 0.0:
        if end[RADIUS] < now[RADIUS]:
            deviation_at(zone, low)
        for j in range(n):
            zone.workspace[ENTRY, j] = (
                zone.workspace[HERE, j] if end[RADIUS] < now[RADIUS] else zone.edge[INNER_EDGE, j]
            )
        spent, at_edge = spent_in_contact(zone, low), spent_at_edge(zone)
    for i in range(first, last + 1):
        node_end(zone, i)
        if i * h >= low:
            if next_to and low > 0.0:
                # from the edge to the first node, whose own part begins half a spacing before it
                to = i * h - low
                spent += 0.5 * to * at_edge + 0.5 * (to - h) * spent_at(zone, i)
            elif next_to:
                spent -= 0.5 * h * spent_at(zone, i)
            next_to = False
            spent += h * spent_at(zone, i)
        for j in range(n):
            node[i, j] = zone.workspace[HERE, j]
        node[i, n] = end[TIME]
    now[SPENT] += spent
    for j in range(n):
        for k in range(SQUARES_BEFORE + 1):
            zone.edge[k, j] = zone.after[k, j]
    for i in range(FORCE + 1):
        now[i] = end[i]


@inner
def set_length(zone: Zone, length: float, control: float) -> None:
    """Begin a trial step from the state."""
    for j in range(zone.body.shape[1]):
        e, w0, w1 = fades(zone.body[RATE, j], length)
        zone.workspace[FADE, j], zone.workspace[WAS, j], zone.workspace[WILL, j] = e, w0, w1
    end = zone.end
    end[LENGTH], end[CONTROL], end[TIME] = length, control, zone.now[TIME] + length
