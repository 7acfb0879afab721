"""Compiled equation of the contact radius behind a zone that is short compared with it. Loads numba."""

from __future__ import annotations

import math
from typing import NamedTuple

from pymdr.compiling import compiled, inner, merged
from pymdr.line.soft.kernels import cubics
from pymdr.units import FloatArray

CONTROL, SLOPE, MACHINE, RUBBERY, GLASSY, TOP, CLOSED, WORK, UNIT, SHORTEST, LIMIT = range(11)
"""Control [m or N] at the begin of a row and its rate, stiffness of the machine [N/m], E_inf and E_0 [Pa], end of the profile's table and the
radius at which a contact rests as closed [m], γ [J/m²], π γ E_inf/4σ² [m], logarithm of the shortest passing time [s], G/γ of the fastest steady
recession."""
MODULUS, TIME = range(2)
"""Rows of the springs: E_i [Pa], τ_i [s]."""
PASSING, MEAN, ADVANCE, FACTOR = range(4)
"""Rows of a zone's table: evenly spaced logarithms of passing times, γ/G of recession, G/γ and M of advance."""
FREE, SEPARATED, PARTED_DEPTH, PARTED_FORCE, PACE, PASSED, SPEED, STEEPNESS, RADIUS = range(9)
"""Entries of a state: whether the bodies are out of contact, and whether they have been in contact before, depth and force where the edge became
faster than any steady one, length of the next step [s], time within a row [s], speed of the edge [m/s] and slope
of its logarithm [1/m] in the step before; then what the equation integrates: contact radius, displacements of
the dashpots, dissipated energy."""
OUT_A, OUT_D, OUT_F, OUT_LOAD, OUT_UNRELAXED, OUT_SPENT, OUT_JUMPED, OUT_STRAINS, OUTPUTS = range(9)
"""Contact radius, depth, force, q_a, Q - E_inf d, dissipated energy, whether the bodies parted, Σ E_i (d - v_i)²; and their number."""
DONE, BEYOND, STUCK = range(3)
"""How rows end."""
_TOLERANCE, _EXACT = 1e-8, 1e-12
"""Tolerances of a step, and of the roots within it, over the sizes and the values of the state."""
_ITERATIONS = 60
LEVELS, _LEAST = 9, 3
"""Largest and smallest number of levels of extrapolation in a step."""
_TARGET = 6
"""Levels with which a step is as long as it should be."""
_SHORTEST, _MOST = 1e-40, 20_000
"""Shortest step over the duration of a row, and largest number of steps in it."""
_OPEN = 3.0
"""Radius below which a contact that recedes is open, over that at which it rests."""
_LOCATED = 1e-7
"""Move of the edge over its radius in the step in which it becomes faster than any steady one."""


@inner
def hermite(table: FloatArray, row: int, k: int, u: float) -> tuple[float, float]:
    """Value and slope, per interval, of a row of a table at the fraction u of interval k, smooth from one interval to the next."""
    last = table.shape[1] - 1
    y0, y1 = table[row, k], table[row, k + 1]
    m0 = 0.5 * (y1 - table[row, k - 1]) if k > 0 else y1 - y0
    m1 = 0.5 * (table[row, k + 2] - y0) if k + 1 < last else y1 - y0
    c2, c3 = 3.0 * (y1 - y0) - 2.0 * m0 - m1, m0 + m1 - 2.0 * (y1 - y0)
    return y0 + u * (m0 + u * (c2 + u * c3)), m0 + u * (2.0 * c2 + 3.0 * u * c3)


@inner
def place_of(value: float, table: FloatArray, row: int) -> tuple[int, float]:
    """Interval and fraction at which a row, which rises, has a value."""
    low, high = 0, table.shape[1] - 1
    while high - low > 1:
        middle = (low + high) >> 1
        if table[row, middle] <= value:
            low = middle
        else:
            high = middle
    u = (value - table[row, low]) / (table[row, high] - table[row, low])
    for _ in range(3):
        y, slope = hermite(table, row, low, u)
        if slope > 0.0:
            u = min(max(u - (y - value) / slope, 0.0), 1.0)
    return low, u


@compiled
def speed(release: float, table: FloatArray, unit: float, shortest: float) -> float:
    """da/dt [m/s] of an edge at G/γ, below 0 where it recedes, that of the shortest passing time beyond the limits."""
    last = table.shape[1] - 1
    place, first, interval = shortest, table[PASSING, 0], table[PASSING, 1] - table[PASSING, 0]
    if release >= 1.0:
        if 1.0 / release >= table[MEAN, last]:
            return 0.0
        if 1.0 / release > table[MEAN, 0]:
            k, u = place_of(1.0 / release, table, MEAN)
            place = max(first + interval * (k + u), shortest)
        return -release * unit / math.exp(place)
    if release >= table[ADVANCE, last]:
        return 0.0
    factor = table[FACTOR, 0]
    if release > table[ADVANCE, 0]:
        k, u = place_of(release, table, ADVANCE)
        place = first + interval * (k + u)
        factor, _ = hermite(table, FACTOR, k, u)
    return float(unit / (factor * math.exp(max(place, shortest))))


@inner
def branches(y: FloatArray, length: float, setting: FloatArray, springs: FloatArray) -> tuple[float, float]:
    """Σ E_i v_i and E_0 after implicit steps of the dashpots at depth 0 and what they take from E_0, from a state y."""
    lag, firm = 0.0, setting[GLASSY]
    for i in range(springs.shape[1]):
        x = length / springs[TIME, i]
        lag += springs[MODULUS, i] * y[1 + i] / (1.0 + x)
        firm -= springs[MODULUS, i] * x / (1.0 + x)
    return lag, firm


@inner
def bear(
    t: float, a: float, lag: float, firm: float, setting: FloatArray, profile: FloatArray
) -> tuple[float, float, float, float]:
    """Depth, force, Q and q_a at a time of a row, for a contact radius and Q = firm d - lag."""
    a, k = max(a, 0.1 * setting[CLOSED]), setting[MACHINE]
    g, area = cubics(profile, math.sqrt(a / setting[TOP]) * (profile.shape[1] - 1))
    control, rest = setting[CONTROL] + setting[SLOPE] * t, setting[RUBBERY] * area
    if k == 0.0:
        Q = (0.5 * control + rest) / a
        d = (Q + lag) / firm
    else:
        d = (control + 2.0 / k * (a * lag + rest)) / (1.0 + 2.0 * a * firm / k)
        Q = firm * d - lag
    return d, 2.0 * (a * Q - rest), Q, Q - setting[RUBBERY] * g


@inner
def state(
    t: float, y: FloatArray, setting: FloatArray, springs: FloatArray, profile: FloatArray
) -> tuple[float, float, float, float]:
    """Depth, force, Q and q_a at a time of a row, for a contact radius and displacements of the dashpots."""
    lag, firm = branches(y, 0.0, setting, springs)
    return bear(t, y[0], lag, firm, setting, profile)


@inner
def release(a: float, load: float, setting: FloatArray) -> float:
    """G/γ of a tensile load of the edge."""
    a = max(a, 0.1 * setting[CLOSED])
    return float(min(load, 0.0) ** 2 / (2.0 * math.pi * a * setting[RUBBERY] * setting[WORK]))


@inner
def edge_speed(
    t: float, a: float, lag: float, firm: float, setting: FloatArray, profile: FloatArray, table: FloatArray
) -> float:
    """da/dt [m/s] at a contact radius."""
    _, _, _, load = bear(t, a, lag, firm, setting, profile)
    v = speed(release(a, load, setting), table, setting[UNIT], setting[SHORTEST])
    if v < 0.0:
        # a contact that closes comes to rest, instead of an event that a step may pass
        v *= min(max(a / setting[CLOSED] - 1.0, 0.0), 1.0)
    return float(v)


class Equation(NamedTuple):
    """What the rates depend on besides time and state, and the sizes of the state."""

    setting: FloatArray
    springs: FloatArray
    profile: FloatArray
    table: FloatArray
    sizes: FloatArray
    work: FloatArray
    """(LEVELS + 1, n) work space for n entries of the state: levels, and the state after a step."""


@merged
def move_edge(
    t: float, length: float, a: float, lag: float, firm: float, equation: Equation, memory: FloatArray
) -> float:
    """
    The contact radius after an implicit step of Euler, below 0 if there is none: a root in the logarithm of the speed, since that is nearly linear.

    The memory has the speed of the step before, and the slope of that logarithm.
    """
    setting, _, profile, table, sizes, _ = equation
    first = edge_speed(t, a, lag, firm, setting, profile, table)
    if first == 0.0:
        return a
    side = 1.0 if first > 0.0 else -1.0
    x, low, high, slope = length * abs(first), 0.0, math.inf, memory[1]
    known = memory[0] * side > 0.0
    if known:
        x = min(x, length * abs(memory[0]))
    last, before = math.nan, math.nan
    for _ in range(_ITERATIONS):
        if side < 0.0 and not x < a:
            return -1.0
        v = edge_speed(t, a + side * x, lag, firm, setting, profile, table) * side
        if v > 0.0:
            off = math.log(length * v / x)
            if off > 0.0:
                low = x
            else:
                high = x
            if x != last and off != before:
                slope = (off - before) / (x - last) if before == before else slope
            last, before = x, off
            new = x - off / slope if slope < 0.0 else x * math.exp(0.5 * off)
        else:
            # beyond the place where the edge rests
            high, new = x, math.nan
        if not low < new < high:
            new = 0.5 * (low + high) if high < math.inf else 2.0 * x
        # the nearest root: there is another beyond a jump
        new = min(new, 2.0 * x)
        change = abs(new - x)
        x = new
        if change < _EXACT * (sizes[0] + a) or change < 1e-13 * x:
            break
    memory[0], memory[1] = side * x / length, slope
    return a + side * x


@merged
def dissipated(d: float, Q: float, load: float, v: float, y: FloatArray, equation: Equation) -> float:
    """Rate of the energy dissipated by the dashpots, and of that which the springs at the edge store, less the work of adhesion."""
    setting, springs = equation.setting, equation.springs
    spent, strains = 0.0, 0.0
    for i in range(springs.shape[1]):
        own = springs[MODULUS, i] * (d - y[1 + i]) ** 2
        strains += own
        spent += own / springs[TIME, i]
    relaxed = d - (Q - load) / setting[RUBBERY]
    stored = setting[RUBBERY] * relaxed * relaxed + strains
    return float(2.0 * y[0] * spent + (2.0 * math.pi * y[0] * setting[WORK] - stored) * v)


@merged
def stepped(t: float, h: float, y: FloatArray, equation: Equation, memory: FloatArray) -> tuple[int, float]:
    """
    Step from y by extrapolation of implicit steps of Euler (Deuflhard 1983).

    Returns the number of levels and the difference of the last two over the tolerance; the end is in the work space.
    """
    setting, springs, profile, _, sizes, work = equation
    n, error, before, level = y.size, math.inf, math.inf, 0
    end = work[LEVELS]
    while level < LEVELS:
        parts = level + 1
        part = h / parts
        for i in range(n):
            end[i] = y[i]
        for j in range(parts):
            to = t + (j + 1) * part
            lag, firm = branches(end, part, setting, springs)
            a = move_edge(to, part, end[0], lag, firm, equation, memory)
            if not a > 0.0:
                return level, math.inf
            d, _, Q, load = bear(to, a, lag, firm, setting, profile)
            v = (a - end[0]) / part
            end[0] = a
            for i in range(springs.shape[1]):
                x = part / springs[TIME, i]
                end[1 + i] = (end[1 + i] + x * d) / (1.0 + x)
            end[n - 1] += part * dissipated(d, Q, load, v, end, equation)
        error = 0.0
        for i in range(n):
            # the row of the scheme of Aitken and Neville in place of the last
            value = end[i]
            for k in range(1, parts):
                old = work[k - 1, i]
                work[k - 1, i] = value
                value += (value - old) / (parts / (parts - k) - 1.0)
            work[level, i] = value
            if level > 0:
                error = max(error, abs(value - work[level - 1, i]) / (_TOLERANCE * (sizes[i] + abs(value))))
        level += 1
        if level >= _LEAST and (error <= 1.0 or not error < 3.0 * before):
            break
        if level > 1:
            before = error
    for i in range(n):
        end[i] = work[level - 1, i]
    return level, error if end[0] > 0.0 else math.inf


@merged
def part_bodies(now: FloatArray, d: float, equation: Equation) -> None:
    """Free the bodies, with what the rest of the contact stores dissipated."""
    setting, springs = equation.setting, equation.springs
    n, a = springs.shape[1], now[RADIUS]
    stored = setting[RUBBERY] * d * d
    for i in range(n):
        stored += springs[MODULUS, i] * (d - now[RADIUS + 1 + i]) ** 2
    now[RADIUS + 1 + n] += a * stored - math.pi * a * a * setting[WORK]
    now[FREE] = now[SEPARATED] = 1.0


@compiled
def follow_rows(
    now: FloatArray, equation: Equation, spans: FloatArray, controls: FloatArray, out: FloatArray
) -> tuple[int, int]:
    """
    Follow rows of given durations, between which the control is linear, until the bodies part; how it ended, and the number of rows done.

    Controls begin with that before the first row, of which now[PASSED] seconds are over.
    """
    setting, springs, profile, _, _, work = equation
    y, end, memory = now[RADIUS:], work[LEVELS], now[SPEED:RADIUS]
    for row in range(spans.size):
        span = spans[row]
        setting[SLOPE] = (controls[row + 1] - controls[row]) / span if span > 0.0 else 0.0
        setting[CONTROL] = controls[row] if span > 0.0 else controls[row + 1]
        trials, t = 0, now[PASSED]
        d, _, _, load = state(t, y, setting, springs, profile)
        while t < span:
            trials += 1
            left = span - t
            h = min(now[PACE], left)
            is_last = h >= left * (1.0 - 1e-9)
            if is_last:
                h = left
            pace, steepness = memory[0], memory[1]
            level, error = stepped(t, h, y, equation, memory)
            if not error <= 1.0:
                memory[0], memory[1], now[PACE] = pace, steepness, 0.25 * h
                if h < _SHORTEST * span or trials > _MOST:
                    return STUCK, row
                continue
            if end[0] > setting[TOP]:
                return BEYOND, row
            before = release(y[0], load, setting)
            d, force, _, load = state(t + h, end, setting, springs, profile)
            if before <= setting[LIMIT] < release(end[0], load, setting):
                if y[0] - end[0] > _LOCATED * y[0]:
                    memory[0], memory[1], now[PACE] = pace, steepness, 0.25 * h
                    _, _, _, load = state(t, y, setting, springs, profile)
                    continue
                now[PARTED_DEPTH], now[PARTED_FORCE] = d, force
            closing = end[0] < y[0]
            for i in range(y.size):
                y[i] = end[i]
            t = now[PASSED] = span if is_last else t + h
            longer = 2.0 if level < _TARGET else min(max(0.9 * (error + 1e-9) ** (-1.0 / level), 0.5), 1.5)
            now[PACE] = max(now[PACE], longer * h) if is_last else longer * h
            if closing and y[0] < _OPEN * setting[CLOSED]:
                part_bodies(now, d, equation)
                out[row, OUT_JUMPED] = 1.0
                break
        now[PASSED] = 0.0
        n = springs.shape[1]
        out[row, OUT_SPENT] = y[1 + n]
        if now[FREE] > 0.0:
            return DONE, row + 1
        d, force, Q, load = state(span, y, setting, springs, profile)
        out[row, OUT_A], out[row, OUT_D], out[row, OUT_F], out[row, OUT_LOAD] = y[0], d, force, load
        out[row, OUT_UNRELAXED] = Q - setting[RUBBERY] * d
        for i in range(n):
            out[row, OUT_STRAINS] += springs[MODULUS, i] * (d - y[1 + i]) ** 2
    return DONE, spans.size
