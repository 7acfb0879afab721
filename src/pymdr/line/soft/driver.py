"""Compiled paths of a cohesive zone on springs with memory: steps in time, and jumps at once. Loads numba."""

from __future__ import annotations

import math

from pymdr.compiling import Addressed, call, compiled, inner, merged
from pymdr.line.soft.equilibrium import bear, choose_nodes, excess
from pymdr.line.soft.kernels import (
    ALPHA,
    BETA,
    CELLS,
    CONTROL,
    COUNT,
    DECAY,
    DEPTH,
    FORCE,
    FRACTION,
    HEIGHT,
    INTO,
    LAG,
    OUTER,
    OUTER_EDGE,
    PARTICIPATION,
    RADIUS,
    RATE,
    RIM,
    RISE,
    SCRATCH,
    SIGMA,
    SPACING,
    SPENT,
    SQUARES_BEFORE,
    TIME,
    Zone,
    accept,
    fades,
    of_table,
    set_length,
)
from pymdr.units import FloatArray

DONE, STUCK, TOO_WIDE, TOO_MANY, _SMALL = range(5)
"""How a leg ends."""
_NODES = 2.5
"""Nodes in the smallest zone without contact."""
(
    OUT_TIME,
    OUT_A,
    OUT_C,
    OUT_D,
    OUT_F,
    OUT_JUMPED,
    OUT_STORED,
    OUT_COHESIVE,
    OUT_WORK,
    OUT_JUMP_LOSS,
    OUT_SPENT,
) = range(11)
OUT_EVENT_D, OUT_EVENT_F, OUT_JUMP_TIME, OUTPUTS = range(11, 15)
"""Depth and force before the first attraction or separation in a row, and time from its start to the first jump, nan without one; and their number."""
LARGEST, MISSED = range(2)
"""Limits of a step: largest move of a and c, and largest difference from the extrapolated c, over c - a."""
WANTED, RATE_A, RATE_C, KNOWN, ROW = range(5)
"""What the next step is chosen by: its length (0 at the start of a leg), the rates of a and c, and whether they are known; and the row."""
_HALVINGS, _MOST = 40, 300_000
_BISECTIONS, _SCANS, _TRIALS = 80, 4000, 40
_SOLVED = 1e-7
"""Residual at which a step is solved."""
_UNMOVED = 1e-9
"""Relative growth of c in a leap that is one of rounding."""
_QUICK = 1e-5
"""Time of a jump over the shortest of a row, the relaxation times, and the time in which the control moves by the range of the attraction."""
_FIRST, _WHOLE_ROW = 10.0, 0.12
"""First step over the shortest relaxation time, over the limit of what it misses; and the limit of moves with which a step may be a row."""
_NOISE = 0.05
"""Scatter of c by interpolation, over the spacing of the nodes."""
_SUMMED = 40.0
"""Nodes that energies are summed over, over the cells of the gap, and more near the edges."""
_ROOT, _NONE, _WIDE = range(3)
_ENERGIES = 0.0, 0.0, 0.0
"""The type of what :func:`energies` returns."""


def addressed(zone: Zone) -> Zone:
    """A zone with the addresses of the kernels that its own call."""
    return zone._replace(
        bear=bear.address(None, zone),
        excess=excess.address(0.0, zone, 0.0),
        accept=accept.address(None, zone),
        energies=energies.address(_ENERGIES, zone),
        find=find.address(_NONE, zone, 0.0, 0.0),
    )


@Addressed
def find(zone: Zone, guess: float, bound: float) -> int:
    """
    Equilibrium at the end of a step, from a guess of c.

    Within `bound` of the c now by secants of which the first has the slope of the last; or, for no bound, in a leap at frozen springs, the next stable
    state in the direction of motion, wherever it is.
    """
    end, h = zone.end, zone.end[SPACING]
    leap = bound == 0.0
    c0 = zone.now[OUTER]
    limit = (zone.profile.shape[1] - 4) * h
    low, high, below, above = 0.0, 0.0, 0.0, 0.0
    has_low, has_high, at_bound = False, False, False
    outcome = _NONE
    previous, last, c, side, pace = 0.0, 0.0, guess, 0, 1.0
    if leap and c0 == 0.0:
        c = 2.0 * h
    for trial in range(_SCANS if leap else _TRIALS):
        radius = end[RADIUS]
        if leap:
            choose_nodes(zone, min(radius, 0.99 * c), c)
        f = min(call(zone.excess, 0.0, (zone, c)), 10.0)
        if abs(f) < (0.01 * _SOLVED if leap else _SOLVED):
            outcome = _ROOT
            break
        moved = 1 if f > 0.0 else -1
        if f < 0.0:
            low, below, has_low = c, f, True
        else:
            high, above, has_high = c, f, True
        both = has_low and has_high and low < high
        slope = end[RISE] if trial == 0 else (f - last) / (c - previous)
        if trial == 0 and leap:
            end[RISE] = f
        elif slope > 0.0:
            end[RISE] = slope
        if both:
            width = high - low
            if width < (1e-13 if leap else 1e-9) * (c - end[RADIUS]) + 4e-16 * c:
                outcome = _NONE if f > 1.0 else _ROOT
                break
            if side == moved:
                # the end that stays weighs less (Illinois)
                if moved > 0:
                    below *= 0.5
                else:
                    above *= 0.5
            new = high - above * width / (above - below)
            if not low < new < high or trial % 8 == 7 or below <= -1.0 or above >= 10.0:
                new = low + 0.5 * width
            side = moved
        elif leap:
            # the gap changes over the length of the zone near an edge of the past, else over the radius
            pace = max(0.7 * pace, 1.0) if abs(f - last) > 0.05 else 1.3 * pace
            new = c - moved * min(0.05 * pace * max(c - end[RADIUS], 2.0 * h), 0.03 * max(c, 2.0 * h))
            if new >= limit:
                outcome = _WIDE
                break
            if new <= 2.0 * h:
                break
        else:
            if at_bound:
                break
            new = c - f / slope if slope > 0.0 else c - moved * 0.3 * bound
            if abs(new - c) > 0.6 * bound:
                new = c - moved * 0.6 * bound
            if abs(new - c0) >= bound:
                new = c0 - moved * bound
                at_bound = True
                if new == c:
                    break
            if new >= limit:
                outcome = _WIDE
                break
            if new <= 0.0:
                break
        previous, last, c = c, f, new
        end[RADIUS] = max(min(radius if end[RADIUS] == 0.0 else end[RADIUS], c * (1.0 - 1e-6)), 0.0)
    if outcome == _ROOT:
        call(zone.bear, None, (zone,))
    return outcome


@merged
def separate(zone: Zone) -> None:
    """Free the springs at once: the path of a soft machine in so short a time would move them by metres."""
    end = zone.end
    time = end[TIME]
    set_length(zone, 0.0, end[CONTROL])
    end[TIME] = time
    end[RADIUS], end[OUTER], end[FORCE] = 0.0, 0.0, 0.0
    end[DEPTH] = end[CONTROL] / end[ALPHA] if end[ALPHA] > 0.0 else -end[HEIGHT]
    for j in range(zone.body.shape[1]):
        for k in range(SQUARES_BEFORE + 1):
            zone.after[k, j] = zone.edge[k, j] if k == LAG else 0.0


@inner
def under_root(s0: float, s1: float, f0: float, f1: float) -> float:
    """Integral of sqrt(s) f from s1 to s0 with f linear, f0 at s0 and f1 at s1."""
    if s0 <= s1:
        return 0.0
    r0, r1 = s0 * math.sqrt(s0), s1 * math.sqrt(s1)
    whole = (r0 - r1) / 1.5
    return f1 * whole + (f0 - f1) / (s0 - s1) * ((s0 * r0 - s1 * r1) / 2.5 - s1 * whole)


@Addressed
def energies(zone: Zone) -> tuple[float, float, float]:
    """Energy of the springs, of the attraction, and dissipated so far, in units of the instantaneous modulus times a length cubed."""
    now, body, node = zone.now, zone.body, zone.node
    h, sigma = zone.end[SPACING], zone.end[SIGMA]
    t, a, c, d = now[TIME], now[RADIUS], now[OUTER], now[DEPTH]
    n = body.shape[1]
    v, stored, cohesive, pending = zone.workspace[SCRATCH], 0.0, 0.0, 0.0
    cells = zone.end[CELLS]
    rest, widest, graded = 1.0, h * node.shape[0] / (_SUMMED * cells), 1.25 / cells
    for j in range(n):
        rest -= body[FRACTION, j]
    i, stride, last_own, last_idle = 0, 0, 0.0, 0.0
    # g - d + W times sqrt(c + x) in the zone; the stress itself is integrated in closed form
    place, opened = -1.0, 0.0
    if a > 0.0:
        place = a
        opened, _ = of_table(zone, a)
        opened -= d
        for k in range(n):
            opened += body[PARTICIPATION, k] * zone.edge[OUTER_EDGE, k]
        opened *= math.sqrt(c + a)
    while i < node.shape[0]:
        x, g, idle = i * h, zone.profile[0, i], t - node[i, n]
        at_rest = 0.0
        if x < a:
            w = d - g
            for j in range(n):
                v[j] = zone.edge[LAG, j] - g + node[i, j] * math.exp(-body[RATE, j] * idle)
        else:
            w = 0.0
            for j in range(n):
                v[j] = 0.0
            for k in range(n):
                m = node[i, k] * math.exp(-body[DECAY, k] * idle)
                if idle > 0.0:
                    at_rest += body[DECAY, k] * (node[i, k] - m) * (node[i, k] + m)
                w += body[PARTICIPATION, k] * m
                for j in range(n):
                    v[j] += body[INTO + n + j, k] * m
            if x < c:
                value = (g - d + w) * math.sqrt(c + x)
                if place >= 0.0:
                    cohesive += under_root(c - place, c - x, opened, value)
                place, opened = x, value
                w -= 2.0 * sigma * math.sqrt(c * c - x * x)
        own = rest * w * w
        for j in range(n):
            own += body[FRACTION, j] * (w - v[j]) ** 2
        stored += 0.5 * h * stride * (own + last_own)
        pending += 0.5 * h * stride * (at_rest + last_idle)
        last_own, last_idle = own, at_rest
        # closer nodes near both edges
        allowed = min(widest, graded * min(abs(x - a), abs(x - c)))
        stride = 1
        while 2.0 * stride * h <= allowed:
            stride *= 2
        i += stride
    if c > 0.0 and place >= 0.0:
        value, _ = of_table(zone, c)
        value -= d
        for k in range(n):
            value += body[PARTICIPATION, k] * zone.edge[RIM, k]
        cohesive += under_root(c - place, 0.0, opened, value * math.sqrt(2.0 * c))
    cohesive -= 2.0 * sigma * (c - a) ** 2 * (2.0 * c + a) / 3.0
    surface = 4.0 * sigma * cohesive - math.pi * sigma * zone.end[HEIGHT] * c * c
    return stored, surface, now[SPENT] + pending


@inner
def potential(zone: Zone, load: float) -> float:
    """Energy of the springs, the attraction, the machine and a dead load."""
    stored, cohesive, _ = call(zone.energies, _ENERGIES, (zone,))
    now, end = zone.now, zone.end
    machine = 0.0 if end[ALPHA] == 0.0 else 0.5 * end[BETA] * now[FORCE] ** 2
    return float(stored + cohesive + machine - load * now[DEPTH])


@inner
def begins(zone: Zone, length: float, control: float) -> bool:
    """Whether a free surface is within the range of the stress after a time."""
    n, creep = zone.body.shape[1], 0.0
    idle = zone.now[TIME] + length - zone.node[0, n]
    for j in range(n):
        creep += zone.body[PARTICIPATION, j] * zone.node[0, j] * math.exp(-zone.body[DECAY, j] * idle)
    return bool(creep - control / zone.end[ALPHA] - zone.end[HEIGHT] <= 0.0)


@inner
def creep_free(zone: Zone, length: float, depth: float) -> None:
    """Let free springs creep for a time, to a depth."""
    now = zone.now
    for j in range(zone.body.shape[1]):
        e, w0, w1 = fades(zone.body[RATE, j], length)
        zone.edge[LAG, j] = e * zone.edge[LAG, j] + w0 * now[DEPTH] + w1 * depth
    now[TIME] += length
    now[DEPTH] = depth if zone.end[ALPHA] > 0.0 else -zone.end[HEIGHT]


@merged
def wait_free(zone: Zone, span: float, p0: float, p1: float) -> bool:
    """Let free springs creep until the attraction begins within a span, or to its end; whether it begins."""
    now, alpha = zone.now, zone.end[ALPHA]
    started, length = False, span
    if alpha > 0.0 and begins(zone, span, p1):
        started, low, high = True, 0.0, span
        for bisection in range(_BISECTIONS):
            # first whether it has begun
            middle = 0.5 * (low + high) if bisection > 0 else 0.0
            if begins(zone, middle, p0 + middle / span * (p1 - p0)):
                high = middle
            else:
                low = middle
        length = high
    fraction = length / span if span > 0.0 else 1.0
    creep_free(zone, length, (p0 + fraction * (p1 - p0)) / alpha if alpha > 0.0 else now[DEPTH])
    return started


@merged
def fall(zone: Zone, out: FloatArray, vanishes: bool, retreats: bool) -> int:
    """Jump to the next stable state, or separate, at once where the zone vanishes; the loss is that of the energy at constant control."""
    now, end = zone.now, zone.end
    c0, depth, free = now[OUTER], now[DEPTH], now[OUTER] == 0.0
    load = end[CONTROL] if end[ALPHA] == 0.0 else 0.0
    was, length = potential(zone, load), c0 - now[RADIUS]
    end[RADIUS] = now[RADIUS]
    outcome = _NONE if vanishes else call(zone.find, _NONE, (zone, c0, 0.0))
    small = end[RADIUS] == 0.0 and end[OUTER] < _NODES * end[SPACING]
    if free and small and (outcome == _NONE or (retreats and outcome == _ROOT)):
        return _SMALL
    # the gap of so few nodes is not smooth in c, and a leap could stay at a step of it for ever
    if outcome == _ROOT and small and end[OUTER] <= c0 * (1.0 + (_UNMOVED if retreats else 0.0)):
        outcome = _NONE
    if outcome == _WIDE or (free and outcome == _NONE):
        return TOO_WIDE
    if (free or outcome == _NONE) and math.isnan(out[OUT_EVENT_D]):
        out[OUT_EVENT_D], out[OUT_EVENT_F] = depth, now[FORCE]
    jumped = True
    if outcome == _ROOT:
        out[OUT_WORK] += load * (end[DEPTH] - depth)
        jumped = abs(end[OUTER] - c0) > 0.02 * length
    else:
        separate(zone)
        load = 0.0
    spent = now[SPENT]
    call(zone.accept, None, (zone,))
    if jumped:
        # at once, so that nothing is spent in the body
        now[SPENT] = spent
        if out[OUT_JUMPED] == 0.0:
            out[OUT_JUMP_TIME] = now[TIME]
        out[OUT_JUMPED] = 1.0
        out[OUT_JUMP_LOSS] += was - potential(zone, load)
    return DONE


@compiled
def follow_rows(
    zone: Zone, limits: FloatArray, pace: FloatArray, spans: FloatArray, controls: FloatArray, out: FloatArray
) -> int:
    """
    Follow rows of given durations between which the control is linear; controls begin with that before the first row.

    With the pace of the rows before, the rows of a leg are the same in one call or several.
    """
    now, end, h = zone.now, zone.end, zone.end[SPACING]
    fastest = zone.body[RATE].max()
    first = _FIRST * limits[MISSED] / fastest
    wanted = pace[WANTED] if pace[WANTED] > 0.0 else first
    rate_a, rate_c, known = pace[RATE_A], pace[RATE_C], pace[KNOWN] > 0.0
    for row in range(spans.size):
        # times count from the start of the row: a long wait would leave no digits to short steps
        zone.node[:, -1] -= now[TIME]
        now[TIME], pace[ROW] = 0.0, row
        span, p0, change = spans[row], controls[row], controls[row + 1] - controls[row]
        if span == 0.0 and now[OUTER] == 0.0 and end[ALPHA] > 0.0:
            now[DEPTH] = controls[row + 1] / end[ALPHA]
        longest = span * limits[LARGEST] / _WHOLE_ROW
        # within a jump the control moves by a small part of the range too, since its work is not counted
        ranges = abs(change) / (end[ALPHA] * end[HEIGHT]) if end[ALPHA] > 0.0 else 0.0
        tiny, quick = 1e-13 * span, _QUICK * min(span / max(ranges, 1.0), 1.0 / fastest)
        halvings, trials = 0, 0
        while span > 0.0 and span - now[TIME] > tiny:
            trials += 1
            now[COUNT] += 1.0
            if trials > _MOST:
                return TOO_MANY
            left = span - now[TIME]
            here = p0 + now[TIME] / span * change
            free = now[OUTER] == 0.0
            if free and not (end[ALPHA] == 0.0 and here >= 0.0):
                if not wait_free(zone, left, here, p0 + change):
                    break
                here = p0 + now[TIME] / span * change
                left = span - now[TIME]
            # a zone of few nodes, of springs that are stiff at once
            vanishes = not free and known and rate_c < 0.0 and now[RADIUS] == 0.0 and now[OUTER] < _NODES * h
            leap = free or vanishes or wanted < quick or halvings > _HALVINGS
            if leap:
                # a free surface that is attracted, or a fold beyond which no state is near
                length = 0.0 if free else min(4.0 * quick, left)
                set_length(zone, length, here + length / span * change)
                ends = fall(zone, out[row], vanishes, change < 0.0)
                if ends == _SMALL:
                    # on a sharp tip the zone grows from nothing: the surfaces stay free until it is two nodes wide
                    pause = 0.01 * span
                    if end[ALPHA] > 0.0 and change != 0.0:
                        pause = max(0.5 * end[RISE] * end[HEIGHT] * end[ALPHA] / abs(change), 2e-3) * span
                    pause = min(pause, left)
                    depth = (here + pause / span * change) / end[ALPHA] if end[ALPHA] > 0.0 else now[DEPTH]
                    creep_free(zone, pause, depth)
                    continue
                if ends != DONE:
                    return ends
                known, halvings, rate_a, rate_c = False, 0, 0.0, 0.0
                wanted = first
                continue
            length = min(wanted, longest)
            if length >= left * (1.0 - 1e-9):
                length = left
            elif length > 0.5 * left:
                length = 0.5 * left
            set_length(zone, length, here + length / span * change)
            a, c, d, force = now[RADIUS], now[OUTER], now[DEPTH], now[FORCE]
            whole = c - a
            guess = c + rate_c * length
            end[RADIUS] = a + rate_a * length
            if not 0.0 <= end[RADIUS] < guess:
                end[RADIUS], guess = a, c
            choose_nodes(zone, end[RADIUS], guess)
            solved = call(zone.find, _NONE, (zone, guess, limits[LARGEST] * whole)) == _ROOT
            missed = abs(end[OUTER] - guess)
            if solved:
                tolerance = limits[MISSED] * whole + _NOISE * h
                solved = abs(end[RADIUS] - a) <= limits[LARGEST] * whole and missed <= tolerance
            if not solved:
                wanted = 0.5 * length
                halvings += 1
                if halvings > 3:
                    known, rate_a, rate_c = False, 0.0, 0.0
                continue
            rate_a, rate_c = (end[RADIUS] - a) / length, (end[OUTER] - c) / length
            out[row, OUT_WORK] += 0.5 * (force + end[FORCE]) * (end[DEPTH] - d)
            if end[ALPHA] > 0.0:
                out[row, OUT_WORK] += 0.5 * end[BETA] * (end[FORCE] ** 2 - force**2)
            call(zone.accept, None, (zone,))
            quickens = halvings == 0 and (not known or missed < 0.3 * limits[MISSED] * whole)
            wanted = max(wanted, 1.6 * length if quickens else length)
            known, halvings = True, 0
        now[TIME] = span
        for i in range(FORCE + 1):
            out[row, i] = now[i]
        out[row, OUT_STORED], out[row, OUT_COHESIVE], out[row, OUT_SPENT] = call(
            zone.energies, _ENERGIES, (zone,)
        )
    pace[WANTED], pace[RATE_A], pace[RATE_C], pace[KNOWN] = wanted, rate_a, rate_c, 1.0 if known else 0.0
    return DONE
