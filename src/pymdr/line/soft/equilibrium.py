"""Compiled equilibrium of a cohesive zone at the end of a step: edges, force and range. Loads numba.

For a trial c the contact radius a follows from the control, which the continuity of q at a turns into an equation of a alone; the
range of the stress at c is then one equation of c. Both rise with their unknown where the contact is stable.
"""

from __future__ import annotations

import math

import numpy as np

from pymdr.compiling import Addressed, call, inner, merged
from pymdr.line.soft.kernels import (
    ALPHA,
    BEFORE,
    BEHIND,
    BETA,
    CELLS,
    CONTROL,
    DEPTH,
    FADE,
    FORCE,
    FRACTION,
    HEIGHT,
    HERE,
    INNER_EDGE,
    INTO,
    KNOTS,
    LAG,
    OUTER,
    OUTER_EDGE,
    PARTICIPATION,
    RADIUS,
    RATE,
    RIM,
    SIGMA,
    SPACING,
    SQUARES,
    SQUARES_BEFORE,
    SUM,
    SUM_BEFORE,
    TIME,
    TOUCHING,
    WAS,
    WILL,
    Zone,
    deviation_at,
    modes_at,
    node_end,
    of_table,
    pulled,
    weigh,
)

UNBOUND = 1e30
"""Excess of the gap where no contact bears the control."""
_ITERATIONS, _SECANTS = 100, 14
_GRADE = 0.3
"""Largest distance of chosen nodes over that from a."""
_CELL_POINTS = np.array([0.1127016653792583, 0.5, 0.8872983346207417])
_CELL_WEIGHTS = np.array([0.2777777777777778, 0.4444444444444444, 0.2777777777777778])


@merged
def sum_deviations(zone: Zone) -> None:
    """
    int_0^a y_j dx and int_0^a y_j^2 dx at the end of a step, by those before it and the nodes between.

    By the trapezoidal rule with the second differences of three points of which the first is a node behind.
    """
    now, end, body, workspace, node = zone.now, zone.end, zone.body, zone.workspace, zone.node
    h, a0, a1, t, after = end[SPACING], now[RADIUS], end[RADIUS], now[TIME], zone.after
    n = body.shape[1]
    low, high = min(a0, a1), max(a0, a1)
    receding = a1 <= a0
    for j in range(n):
        fade = 1.0 if receding else workspace[FADE, j]
        after[SUM_BEFORE, j], after[SQUARES_BEFORE, j] = zone.edge[SUM, j], zone.edge[SQUARES, j]
        after[SUM, j], after[SQUARES, j] = fade * zone.edge[SUM, j], fade * fade * zone.edge[SQUARES, j]
    if high > low:
        first = math.floor((low + TOUCHING * h) / h) + 1 if low > 0.0 else 1
        last = math.ceil((high - TOUCHING * h) / h) - 1
        behind = math.ceil(low / h) - 2
        # y at the lower end: before the step where the edge recedes, else after it
        if low > 0.0:
            if receding:
                deviation_at(zone, a1)
            else:
                for j in range(n):
                    workspace[HERE, j] = zone.edge[INNER_EDGE, j] * workspace[FADE, j]
        elif receding:
            for j in range(n):
                workspace[HERE, j] = node[0, j] * math.exp(-body[RATE, j] * (t - node[0, n]))
        else:
            node_end(zone, first - 1)
        for j in range(n):
            workspace[BEFORE, j] = workspace[HERE, j]
            workspace[BEHIND, j] = 0.0
            if behind >= 0:
                idle = t - node[behind, n]
                workspace[BEHIND, j] = node[behind, j] * math.exp(-body[RATE, j] * idle)
                if not receding:
                    workspace[BEHIND, j] *= workspace[FADE, j]
        place, back = low, behind * h
        for i in range(first, last + 2):
            x = i * h if i <= last else high
            if i <= last and not receding:
                node_end(zone, i)
            width = x - place
            for j in range(n):
                if i <= last:
                    y = (
                        node[i, j] * math.exp(-body[RATE, j] * (t - node[i, n]))
                        if receding
                        else workspace[HERE, j]
                    )
                else:
                    y = zone.edge[INNER_EDGE, j] if receding else after[INNER_EDGE, j]
                y0, y1 = workspace[BEHIND, j], workspace[BEFORE, j]
                part, square = 0.5 * width * (y1 + y), 0.5 * width * (y1 * y1 + y * y)
                if behind >= 0 and width > 0.0:
                    bend, span = width**3 / 6.0 / (x - back), place - back
                    part -= bend * ((y - y1) / width - (y1 - y0) / span)
                    square -= bend * ((y * y - y1 * y1) / width - (y1 * y1 - y0 * y0) / span)
                after[SUM, j] += -part if receding else part
                after[SQUARES, j] += -square if receding else square
                workspace[BEHIND, j], workspace[BEFORE, j] = y1, y
            place, back = x, place
            behind = 0
    if receding:
        for j in range(n):
            after[SUM_BEFORE, j], after[SQUARES_BEFORE, j] = after[SUM, j], after[SQUARES, j]
            after[SUM, j] *= workspace[FADE, j]
            after[SQUARES, j] *= workspace[FADE, j] ** 2


@Addressed
def bear(zone: Zone) -> None:
    """The force at the end of a step whose radii and depth are known."""
    end, body = zone.end, zone.body
    a, c, d = end[RADIUS], end[OUTER], end[DEPTH]
    if a == 0.0:
        for j in range(body.shape[1]):
            zone.after[SUM, j] = zone.after[SQUARES, j] = 0.0
            zone.after[SUM_BEFORE, j] = zone.after[SQUARES_BEFORE, j] = 0.0
        end[FORCE] = -math.pi * end[SIGMA] * c * c
        return
    sum_deviations(zone)
    _, area = of_table(zone, a)
    inside = a * d - area
    for j in range(body.shape[1]):
        inside -= body[FRACTION, j] * (a * zone.after[LAG, j] - area + zone.after[SUM, j])
    root = math.sqrt(max((c - a) * (c + a), 0.0))
    end[FORCE] = 2.0 * inside - 2.0 * end[SIGMA] * (c * c * math.atan2(root, a) - a * root)


@merged
def edge_at(zone: Zone, a1: float, advancing: bool) -> float:
    """State of the edge at a1 at the end of a step, with the depth by continuity of q; the excess of the control."""
    now, end, body, workspace, after = zone.now, zone.end, zone.body, zone.workspace, zone.after
    n, c1, d0 = body.shape[1], end[OUTER], now[DEPTH]
    end[RADIUS] = a1
    pull = 2.0 * end[SIGMA] * math.sqrt(max((c1 - a1) * (c1 + a1), 0.0))
    g, _ = of_table(zone, a1)
    if advancing:
        modes_at(zone, a1)
        pulled(zone, a1, 0.0, 1.0)
        d1 = g - pull
        for j in range(n):
            d1 += body[PARTICIPATION, j] * workspace[HERE, j]
            after[OUTER_EDGE, j] = workspace[HERE, j]
    else:
        deviation_at(zone, a1)
        fixed, slope = g - pull, 1.0
        for j in range(n):
            workspace[HERE, j] *= workspace[FADE, j]
            fixed += body[FRACTION, j] * (
                workspace[FADE, j] * zone.edge[LAG, j] + workspace[WAS, j] * d0 - g + workspace[HERE, j]
            )
            slope -= body[FRACTION, j] * workspace[WILL, j]
        d1 = fixed / slope
    for j in range(n):
        after[LAG, j] = (
            workspace[FADE, j] * zone.edge[LAG, j] + workspace[WAS, j] * d0 + workspace[WILL, j] * d1
        )
    for j in range(n):
        if advancing:
            after[INNER_EDGE, j] = g - after[LAG, j]
            for k in range(n):
                after[INNER_EDGE, j] += body[INTO + n + j, k] * workspace[HERE, k]
        else:
            after[INNER_EDGE, j] = workspace[HERE, j]
            after[OUTER_EDGE, j] = 0.0
            for k in range(n):
                after[OUTER_EDGE, j] += body[INTO + j, k] * (after[LAG, k] - g + workspace[HERE, k])
    end[DEPTH] = d1
    if end[BETA] == 0.0:
        return float(end[ALPHA] * d1 - end[CONTROL])
    call(zone.bear, None, (zone,))
    return float(end[ALPHA] * d1 + end[BETA] * end[FORCE] - end[CONTROL])


@merged
def rest(zone: Zone, off: float) -> None:
    """An edge at rest: the depth by the control, with the springs of the contact, by its excess at the depth of continuity."""
    end, workspace, after, body = zone.end, zone.workspace, zone.after, zone.body
    a, n = end[RADIUS], body.shape[1]
    # the force is linear in the depth
    slope = 1.0
    for j in range(n):
        slope -= body[FRACTION, j] * workspace[WILL, j]
    change = -off / (end[ALPHA] + 2.0 * a * end[BETA] * slope)
    end[DEPTH] += change
    g, _ = of_table(zone, a)
    for j in range(n):
        after[LAG, j] += workspace[WILL, j] * change
    for j in range(n):
        after[OUTER_EDGE, j] = 0.0
        for k in range(n):
            after[OUTER_EDGE, j] += body[INTO + j, k] * (after[LAG, k] - g + after[INNER_EDGE, k])


@merged
def radius_under(zone: Zone, c: float) -> int:
    """The contact radius at c under the control, from that in the end of the step: 1; 0 for no contact; -1 where c is too small."""
    end, a0 = zone.end, zone.now[RADIUS]
    end[OUTER] = c
    lowest, highest = 1e-6 * c, c * (1.0 - 1e-9)
    low, high, guess = lowest, highest, end[RADIUS]
    has_low, has_high, advancing, ends, rests = False, False, a0 <= low, False, False
    at_kink = lowest < a0 < highest
    x, previous, last = min(max(a0 if at_kink else guess, lowest), highest), 0.0, 0.0
    points, outcome = 0, 1
    for step in range(_ITERATIONS):
        off = edge_at(zone, x, advancing)
        if rests:
            rest(zone, off)
            break
        if ends or off == 0.0:
            break
        if off < 0.0:
            low, has_low = x, True
        else:
            high, has_high = x, True
        if at_kink and off < 0.0 and not advancing:
            # the other side of the edge
            advancing = True
            continue
        if at_kink and advancing and off > 0.0:
            # between both values the edge rests
            advancing, rests = False, True
            continue
        if x <= lowest and off > 0.0:
            outcome = 0
            break
        if x >= highest and off < 0.0:
            outcome = -1
            break
        if has_low and has_high and high - low < 1e-12 * (c - x) + 4e-16 * c:
            break
        if at_kink:
            new = guess if low < guess < high else x + (0.02 if advancing else -0.02) * (c - x)
        elif points == 0:
            new = x + (-1e-3 if off > 0.0 else 1e-3) * (c - x)
        elif step < _SECANTS and last != off:
            new = x - off * (x - previous) / (off - last)
        else:
            new = 0.5 * (low + high)
        at_kink = False
        # a limit that has not been tried comes first
        if new >= high:
            new = high if not has_high and step < _SECANTS else 0.5 * (low + high)
        elif new <= low:
            new = low if not has_low and step < _SECANTS else 0.5 * (low + high)
        ends = points > 0 and abs(new - x) < 1e-8 * (c - x)
        previous, last, x = x, off, new
        points += 1
    return outcome


@inner
def choose_nodes(zone: Zone, a: float, c: float) -> None:
    """Nodes for the gap of a zone from a to c: even in sqrt(c - x), closer near a, at multiples of powers of two."""
    end = zone.end
    h = end[SPACING]
    if a < 0.1 * c:  # the contact may end in the step
        a = 0.0
    low = math.floor((a + 0.3 * h) / h) + 1 if a > 0.0 else 0
    i = math.ceil((c - 0.3 * h) / h) - 1
    count = 0
    cell = 2.0 * math.sqrt(c - a) / end[CELLS]
    while i >= low:
        zone.chosen[count] = i
        count += 1
        widest = math.sqrt(c - i * h) * cell
        if a > 0.0:
            widest = min(widest, _GRADE * (i * h - a))
        stride = 1
        while 2.0 * stride * h <= widest:
            stride *= 2
        i = (i - 1) // stride * stride
    end[KNOTS] = count


@merged
def over_zone(zone: Zone, count: int, c: float) -> float:
    """The integral of the values over theta / sqrt(2 c - theta^2), cubic between the points."""
    total, at, points, stencil = 0.0, 0.0, zone.points, zone.stencil
    order = min(4, count)
    for cell in range(1, count):
        to = points[0, cell]
        first = min(max(cell - 2, 0), count - order)
        for k in range(order):
            stencil[0, k] = points[0, first + k]
        for i in range(3):
            theta = at + _CELL_POINTS[i] * (to - at)
            weigh(zone, theta, order)
            value = 0.0
            for k in range(order):
                value += stencil[1, k] * points[1, first + k]
            total += _CELL_WEIGHTS[i] * (to - at) * value / math.sqrt(2.0 * c - theta * theta)
        at = to
    return total


@Addressed
def excess(zone: Zone, c: float) -> float:
    """Gap at c at the end of a step over the range of the stress, less 1, with the contact radius under the control."""
    end, body, workspace, after = zone.end, zone.body, zone.workspace, zone.after
    n, h, sigma = body.shape[1], end[SPACING], end[SIGMA]
    outcome = radius_under(zone, c)
    if outcome < 0:
        return -1.0
    if outcome == 0:
        if end[ALPHA] == 0.0:
            return UNBOUND
        end[RADIUS] = 0.0
        end[DEPTH] = (end[CONTROL] + end[BETA] * math.pi * sigma * c * c) / end[ALPHA]
        for j in range(n):
            after[LAG, j] = (
                workspace[FADE, j] * zone.edge[LAG, j]
                + workspace[WAS, j] * zone.now[DEPTH]
                + workspace[WILL, j] * end[DEPTH]
            )
            after[INNER_EDGE, j] = after[OUTER_EDGE, j] = 0.0
    a, d = end[RADIUS], end[DEPTH]
    total, _ = of_table(zone, c)
    if c >= zone.now[RADIUS]:
        modes_at(zone, c)
        pulled(zone, c, 0.0, 1.0)
    else:  # a jump
        deviation_at(zone, c)
        for j in range(n):
            workspace[BEFORE, j] = workspace[HERE, j]
        for j in range(n):
            workspace[HERE, j] = 0.0
            for k in range(n):
                workspace[HERE, j] += body[INTO + j, k] * (zone.edge[LAG, k] - total + workspace[BEFORE, k])
    for j in range(n):
        after[RIM, j] = workspace[HERE, j]
        total += body[PARTICIPATION, j] * workspace[HERE, j]
    zone.points[0, 0], zone.points[1, 0] = 0.0, total - d
    count = 1
    for p in range(int(end[KNOTS])):
        i = zone.chosen[p]
        x = i * h
        if x < c - TOUCHING * h and (x > a + TOUCHING * h or (a == 0.0 and i >= 0)):
            node_end(zone, i)
            total = zone.profile[0, i]
            for j in range(n):
                total += body[PARTICIPATION, j] * workspace[HERE, j]
            zone.points[0, count], zone.points[1, count] = math.sqrt(c - x), total - d
            count += 1
    if a > 0.0:
        total, _ = of_table(zone, a)
        for j in range(n):
            total += body[PARTICIPATION, j] * after[OUTER_EDGE, j]
        zone.points[0, count], zone.points[1, count] = math.sqrt(c - a), total - d
        count += 1
    gap = 4.0 / math.pi * (over_zone(zone, count, c) - sigma * (c - a))
    return float(gap / end[HEIGHT] - 1.0)
