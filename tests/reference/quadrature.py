"""Equivalent profiles by quadrature in extended precision, written without pymdr.

A curve here is any object with

- ``edges``: radii in m at which panels begin, numpy.longdouble, rising from 0;
- ``kinds``: what the curve is to the right of each edge: ANALYTIC (nothing happens there, the edge only keeps
  panels short), KINK (another analytic piece begins) or BRANCH (the piece begins like a fractional power);
- ``jumps``: the jump of f' at each edge;
- ``slope(base, offset)`` and ``bend(base, offset)``: f' and f'' at r = base + offset, where base is an edge and
  r lies in the panel that begins there.

Positions are pairs (index of the panel, offset from its edge), so that a point at b (1 + 1e-20) is as good as any
other: every distance is formed from offsets. With r = x cos(phi), dr / sqrt(x^2 - r^2) = d(phi) and what is left to
integrate is f' alone, panel by panel: Gauss-Legendre where f' is analytic, tanh-sinh (Takahasi and Mori 1974) where
it begins like a fractional power. Panels must be short beside their distance to what happens below them
(random_profiles.TermCurve sees to that). A value is taken when two levels of nodes agree; the finer one is given.
"""

import itertools
from dataclasses import dataclass
from functools import cache

import numpy as np

LONG = np.longdouble
PI = LONG("3.14159265358979323846264338327950288")
ANALYTIC, KINK, BRANCH = 0, 1, 2
TOLERANCE = LONG("1e-17")
"""Two levels agree when they differ by less than this, relative to the integral of the absolute integrand."""
LEVELS = 5
_AT_ONCE = 300_000


@dataclass(frozen=True)
class Rule:
    """Nodes at u from the lower and v = 1 - u from the upper end of a panel of length 1."""

    u: np.ndarray
    v: np.ndarray
    weight: np.ndarray


@cache
def gauss(n):
    """Gauss-Legendre nodes on [-1, 1] and weights, by Newton from those in double precision."""
    x = np.polynomial.legendre.leggauss(n)[0].astype(LONG)
    for _ in range(3):
        below, here = np.ones_like(x), x.copy()
        for k in range(2, n + 1):
            below, here = here, ((2 * k - 1) * x * here - (k - 1) * below) / LONG(k)
        slope = n * (x * here - below) / ((x - 1) * (x + 1))
        x = x - here / slope
    return x, 2 / ((1 - x) * (1 + x) * slope * slope)


@cache
def gauss_rule(level):
    """Gauss-Legendre for analytic panels."""
    x, w = gauss((28, 40, 60, 90, 140)[level])
    return Rule((1 + x) / 2, (1 - x) / 2, w / 2)


@cache
def root_rule(level):
    """Gauss-Legendre in the root of the offset, for what grows like half-integer powers of it."""
    rule = gauss_rule(level)
    q = rule.u
    return Rule(q * q, rule.v * (1 + q), 2 * q * rule.weight)


@cache
def tanh_sinh(level):
    """Tanh-sinh; the lower end is followed to 1e-124 of the panel, for powers as small as 0.2."""
    step = LONG(0.125) / 2**level
    t = np.arange(-int(3.6 / step), int(5.2 / step) + 1).astype(LONG) * step
    s = PI / 2 * np.sinh(t)
    weight = step * PI / 4 * np.cosh(t) / np.cosh(s) ** 2
    return Rule(1 / (1 + np.exp(2 * s)), 1 / (1 + np.exp(-2 * s)), weight)


def place(curve, base, offset=0.0):
    """The pairs (index, offset) of x = base + offset, where base should be the edge nearest below."""
    base, offset = np.broadcast_arrays(np.asarray(base, dtype=LONG), np.asarray(offset, dtype=LONG))
    index = np.searchsorted(curve.edges, base, side="right") - 1
    rest = (base - curve.edges[index]) + offset
    widths = np.append(np.diff(curve.edges), np.inf)
    while True:
        beyond = rest > widths[index]
        if not beyond.any():
            return index, rest
        rest = np.where(beyond, (base - curve.edges[np.minimum(index + 1, widths.size - 1)]) + offset, rest)
        index = np.where(beyond, index + 1, index)


def radius(curve, index, offset):
    """The radius of a position, rounded."""
    return curve.edges[index] + offset


@dataclass(frozen=True)
class Images:
    """Values of the map at some positions and, of each, the integral of the absolute integrand (its size)."""

    g: np.ndarray
    slope: np.ndarray
    moment: np.ndarray
    g_size: np.ndarray
    slope_size: np.ndarray
    moment_size: np.ndarray


def images(curve, index, offset, with_slope=True, checked=True):
    """
    g(x) = x int_0^x f' / sqrt(x^2 - r^2) dr, its slope g' and the moment int_0^x r^2 f' / sqrt(x^2 - r^2) dr.

    g' = int_0^x (r f')' / sqrt(x^2 - r^2) dr + sum_k D_k b_k / sqrt(x^2 - b_k^2) with the jumps D_k of f' at b_k.
    Unchecked, the first level is taken: what short panels give without asking the next level.
    """
    index, offset = (np.atleast_1d(v) for v in (index, np.asarray(offset, dtype=LONG)))
    answer = _images_in_parts(curve, index, offset, with_slope, 0)
    todo = np.arange(index.size if checked else 0)
    for level in range(1, LEVELS):
        if todo.size == 0:
            return Images(*answer)
        finer = _images_in_parts(curve, index[todo], offset[todo], with_slope, level)
        rough = (abs(finer[:3] - answer[:3, todo]) > TOLERANCE * finer[3:]).any(axis=0)
        answer[:, todo] = finer
        todo = todo[rough]
    if todo.size:
        bad = todo[0]
        raise ArithmeticError(
            f"quadrature at x = {curve.edges[index[bad]]} + {offset[bad]} (panel {index[bad]})"
        )
    return Images(*answer)


def _images_in_parts(curve, index, offset, with_slope, level):
    nodes = gauss_rule(level).u.size
    ends = np.cumsum((index + 1) * nodes)
    part = (ends - 1) // _AT_ONCE
    cuts = np.append(np.flatnonzero(np.diff(part, prepend=-1)), index.size)
    parts = [_images(curve, index[i:j], offset[i:j], with_slope, level) for i, j in itertools.pairwise(cuts)]
    return np.concatenate(parts, axis=1)


def _images(curve, index, offset, with_slope, level):
    count = index + 1
    first = np.cumsum(count) - count
    target = np.repeat(np.arange(index.size), count)
    panel = np.arange(target.size) - first[target]
    edges = curve.edges
    x = edges[index] + offset
    low = edges[panel]
    inside = panel < index[target]
    top = edges[np.minimum(panel + 1, edges.size - 1)]
    xx, k = x[target], index[target]
    phi_low = _angle(xx, low, (edges[k] - low) + offset[target])
    phi_top = np.where(inside, _angle(xx, top, np.maximum((edges[k] - top) + offset[target], 0)), 0)
    width = np.where(inside, top - low, offset[target])
    with np.errstate(invalid="ignore", divide="ignore"):
        # a difference of angles from the difference of radii, without cancellation
        span = 2 * np.arcsin(width / (2 * xx * np.sin((phi_low + phi_top) / 2)))
    span = np.where(width == 0, 0, np.where(inside, span, phi_low))
    sums = np.zeros((6, target.size), dtype=LONG)
    kinds = np.asarray(curve.kinds)[panel]
    for branch in (False, True):
        chosen = np.flatnonzero(((kinds == BRANCH) == branch) & (span > 0))
        if chosen.size:
            rule = tanh_sinh(level) if branch else gauss_rule(level)
            sums[:, chosen] = _panels(
                curve, rule, low[chosen], phi_low[chosen], span[chosen], xx[chosen], with_slope
            )
    total = np.add.reduceat(sums, first, axis=1)
    g, slope, moment, g_size, slope_size, moment_size = total
    if with_slope and np.any(curve.jumps):
        for b, jump, i in zip(edges, curve.jumps, range(edges.size), strict=True):
            if jump != 0 and b > 0:
                distance = np.where(index >= i, (edges[index] - b) + offset, 0)
                beyond = distance > 0
                term = jump * b / np.sqrt(np.where(beyond, distance, 1) * (x + b))
                slope = slope + np.where(beyond, term, 0)
                slope_size = slope_size + np.where(beyond, abs(term), 0)
    return np.array([g * x, slope, moment, g_size * x, slope_size, moment_size])


def _angle(x, r, distance):
    """The angle phi of r = x cos(phi), from x - r."""
    return np.arctan2(np.sqrt(distance * (x + r)), r)


def _panels(curve, rule, low, phi_low, span, x, with_slope):
    """Integrals over panels: of f', (r f')', r^2 f', and of their sizes."""
    low, phi_low, span, x = (v[:, None] for v in (low, phi_low, span, x))
    angle = span * rule.u
    offset = 2 * x * np.sin(phi_low - angle / 2) * np.sin(angle / 2)
    base = np.broadcast_to(low, offset.shape)
    r = low + offset
    f1 = curve.slope(base, offset)
    values = [f1, f1 + r * curve.bend(base, offset) if with_slope else np.zeros_like(f1), f1 * r * r]
    return np.array([v @ rule.weight for v in (*values, *np.abs(values))]) * span[:, 0]


def squared(curve, index, offset):
    """The integral s(x) = int_0^x (g(x) - g(t))^2 dt, whose integrand is positive."""
    index, offset = (np.atleast_1d(v) for v in (index, np.asarray(offset, dtype=LONG)))
    answer = _squared(curve, index, offset, 0)
    todo = np.arange(index.size)
    for level in range(1, LEVELS):
        finer = _squared(curve, index[todo], offset[todo], level)
        rough = abs(finer - answer[todo]) > 10 * TOLERANCE * finer
        answer[todo] = finer
        todo = todo[rough]
        if todo.size == 0:
            return answer
    raise ArithmeticError(
        f"quadrature of the energy at x = {curve.edges[index[todo[0]]]} + {offset[todo[0]]}"
    )


def _squared(curve, index, offset, level):
    g = images(curve, index, offset, with_slope=False).g
    widths = np.diff(curve.edges)
    rules = [(gauss_rule, root_rule, tanh_sinh)[kind](level) for kind in curve.kinds]
    # whole panels are shared by all targets beyond them, the last one belongs to one target
    queue = [(np.flatnonzero(index > k), k, widths[k]) for k in range(int(index.max()))]
    queue += [(np.array([row]), int(index[row]), offset[row]) for row in range(index.size)]
    # tanh-sinh needs its second level for steep powers, Gauss on short panels does not
    checked = bool(np.any(curve.kinds == BRANCH))
    at = np.concatenate([np.full(rules[k].u.size, k) for _, k, _ in queue])
    nodes = np.concatenate([width * rules[k].u for _, k, width in queue])
    g_nodes = images(curve, at, nodes, with_slope=False, checked=checked).g
    answer, start = np.zeros(index.size, dtype=LONG), 0
    for rows, k, width in queue:
        rule = rules[k]
        drop = (g[rows, None] - g_nodes[start : start + rule.u.size]) ** 2
        answer[rows] += width * (drop @ rule.weight)
        start += rule.u.size
    return answer


def carlson(x, y, z):
    """Carlson's R_F(x, y, z) by duplication (Carlson 1995)."""
    x, y, z = np.broadcast_arrays(x, y, z)
    while True:
        mean = (x + y + z) / 3
        worst = np.maximum(abs(x - mean), np.maximum(abs(y - mean), abs(z - mean)))
        if np.all(worst <= LONG("4e-4") * mean):
            break
        a, b, c = np.sqrt(x), np.sqrt(y), np.sqrt(z)
        shift = a * b + a * c + b * c
        x, y, z = (x + shift) / 4, (y + shift) / 4, (z + shift) / 4
    u, v = (mean - x) / mean, (mean - y) / mean
    w = -u - v
    e2, e3 = u * v - w * w, u * v * w
    series = 1 - e2 / 10 + e3 / 14 + e2 * e2 / 24 - 3 * e2 * e3 / 44 - 5 * e2**3 / 208 + 3 * e3 * e3 / 104
    return series / np.sqrt(mean)


def kernel(r, rho, a, distance, to_a_r, to_a_rho):
    """
    The integral int_M^a dx / sqrt((x^2 - r^2) (x^2 - rho^2)) with M = max(r, rho) (DLMF 19.29.4).

    apart = |r - rho|, to_a_r = a - r, to_a_rho = a - rho.
    """
    r, rho, distance, to_a_r, to_a_rho = np.broadcast_arrays(r, rho, distance, to_a_r, to_a_rho)
    outer = rho > r
    high, low = np.where(outer, rho, r), np.where(outer, r, rho)
    x2 = np.where(outer, to_a_rho, to_a_r) * (a + high)
    x3 = np.where(outer, to_a_r, to_a_rho) * (a + low)
    y3 = distance * (high + low)
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = high * high * np.maximum(x3, y3)
        value = carlson(a * a * y3 / unit, high * high * y3 / unit, x3 * high * high / unit)
        return np.where(x2 > 0, np.sqrt(np.maximum(x2, 0) / unit) * value, 0)


def pressure_integral(curve, r_at, a_at):
    """
    P(r, a) = int_r^a g'(x) / sqrt(x^2 - r^2) dx for one r < a, and its size.

    With the order of the integrations exchanged it is a single integral of (rho f')' against :func:`kernel`.
    """
    value, size = _pressure(curve, r_at, a_at, 0)
    for level in range(1, LEVELS):
        coarse, (value, size) = value, _pressure(curve, r_at, a_at, level)
        if abs(value - coarse) <= TOLERANCE * size:
            return value, size
    raise ArithmeticError(f"quadrature of the pressure at r = {r_at}, a = {a_at}")


def _segments(curve, marks, first, last):
    """
    Segments (panel, lower offset, upper offset) from one position to another, split at marks (pairs).

    No segment is longer than twice its distance to a mark, a kink or the origin that is not its own end.
    """
    edges = curve.edges
    bounds = {(k, LONG(0)) for k in range(first[0] + 1, last[0] + 1)} | {first, last}
    bounds = sorted(bounds | {m for m in marks if first < m < last})
    special = (
        list(marks) + [(int(k), LONG(0)) for k in np.flatnonzero(curve.kinds != ANALYTIC)] + [(0, LONG(0))]
    )
    answer = []
    for start, stop in itertools.pairwise(bounds):
        k, low = start
        high = stop[1] if stop[0] == k else edges[k + 1] - edges[k]
        if high <= low:
            continue
        # distances of all that is special to both ends
        away = [((edges[k] - edges[n]) + (low - o), (edges[n] - edges[k]) + (o - high)) for n, o in special]
        below = min((b for b, _ in away if b > 0), default=LONG(np.inf))
        above = min((b for _, b in away if b > 0), default=LONG(np.inf))
        cuts = [LONG(0), high - low]
        while 2 * (below + cuts[-2]) < (rest := cuts[-1] - cuts[-2]) / 2:
            cuts.insert(-1, cuts[-2] + min(2 * (below + cuts[-2]), rest / 2))
        tail = [LONG(0)]
        while 2 * (above + tail[-1]) < (rest := cuts[-1] - cuts[-2] - tail[-1]) / 2:
            tail.append(tail[-1] + min(2 * (above + tail[-1]), rest / 2))
        offsets = [low + c for c in cuts[:-1]] + [high - c for c in tail[::-1]]
        answer += [(k, p, q) for p, q in itertools.pairwise(offsets) if q > p]
    return answer


def _pressure(curve, r_at, a_at, level):
    (i, e), (j, d) = ((int(k), LONG(o)) for k, o in (r_at, a_at))
    edges = curve.edges
    r, a = edges[i] + e, edges[j] + d
    segments = _segments(curve, [(i, e), (j, d)], (0, LONG(0)), (j, d))
    panel = np.array([s[0] for s in segments])
    low, high = (np.array([s[n] for s in segments], dtype=LONG)[:, None] for n in (1, 2))
    rule = tanh_sinh(level)
    base = edges[panel][:, None]
    width = high - low
    offset = low + width * rule.u
    rho = base + offset
    below = (panel < i) | ((panel == i) & (high[:, 0] <= e))
    to_r = np.where(
        below[:, None],
        ((edges[i] - base) + (e - high)) + width * rule.v,
        ((base - edges[i]) + (low - e)) + width * rule.u,
    )
    to_a = ((edges[j] - base) + (d - high)) + width * rule.v
    to_a_r = (edges[j] - edges[i]) + (d - e)
    wide = np.broadcast_to(base, rho.shape)
    source = curve.slope(wide, offset) + rho * curve.bend(wide, offset)
    values = width * source * kernel(r, rho, a, np.maximum(to_r, 0), to_a_r, np.maximum(to_a, 0))
    value, size = (values @ rule.weight).sum(), (abs(values) @ rule.weight).sum()
    for n in np.flatnonzero(curve.jumps != 0):
        b, to_a_b = edges[n], (edges[j] - edges[n]) + d
        if n <= j and b > 0 and to_a_b > 0:
            term = curve.jumps[n] * b * kernel(r, b, a, abs((edges[n] - edges[i]) - e), to_a_r, to_a_b)
            value, size = value + term, size + abs(term)
    return value, size


def gap(curve, r_at, a_at):
    """The gap (2 / pi) int_a^r g'(x) arccos(x / r) dx outside a contact of radius a < r, and its size."""
    value, size = _gap(curve, r_at, a_at, 0)
    for level in range(1, LEVELS):
        coarse, (value, size) = value, _gap(curve, r_at, a_at, level)
        if abs(value - coarse) <= 10 * TOLERANCE * size:
            return value, size
    raise ArithmeticError(f"quadrature of the gap at r = {r_at}, a = {a_at}")


def _gap(curve, r_at, a_at, level):
    (i, e), (j, d) = ((int(k), LONG(o)) for k, o in (r_at, a_at))
    edges = curve.edges
    r = edges[i] + e
    segments = _segments(curve, [], (j, d), (i, e))
    panel = np.array([s[0] for s in segments])
    low, high = (np.array([s[n] for s in segments], dtype=LONG)[:, None] for n in (1, 2))
    rule = tanh_sinh(level)
    base = edges[panel][:, None]
    width = high - low
    offset = low + width * rule.u
    to_r = np.maximum(((edges[i] - base) + (e - high)) + width * rule.v, 0)
    x = base + offset
    computed = images(curve, np.repeat(panel, rule.u.size), offset.ravel())
    angle = np.arctan2(np.sqrt(to_r * (r + x)), x)
    values = width * computed.slope.reshape(offset.shape) * angle
    return 2 / PI * (values @ rule.weight).sum(), 2 / PI * (abs(values) @ rule.weight).sum()


def polish(curve, target, index, offset, of="g", steps=60):
    """
    Solve g(x) = target (or moment(x) = target) from a start in the right panel, for arrays.

    Newton between the logarithms of the offset and of what the curve rises from its value at the edge, which is
    exact for powers, kept in a bracket that closes; returns offsets.
    """
    index = np.atleast_1d(index)
    offset = np.array(np.broadcast_to(np.asarray(offset, dtype=LONG), index.shape))
    target = np.asarray(target, dtype=LONG) * np.ones(index.shape, dtype=LONG)
    widths = np.append(np.diff(curve.edges), np.inf)[index].astype(LONG)
    first = np.zeros(index.shape, dtype=LONG)
    for k in np.unique(index[index > 0]):
        edge = images(curve, [k - 1], [curve.edges[k] - curve.edges[k - 1]], with_slope=False)
        first[index == k] = (edge.g if of == "g" else edge.moment)[0]
    low, high = np.zeros(index.shape, dtype=LONG), widths
    live = np.arange(index.size)
    for _ in range(steps):
        computed = images(curve, index[live], offset[live])
        x = curve.edges[index[live]] + offset[live]
        value, slope, size = (
            (computed.g, computed.slope, computed.g_size)
            if of == "g"
            else (computed.moment, x * computed.slope, computed.moment_size)
        )
        miss = value - target[live]
        low[live] = np.where(miss <= 0, offset[live], low[live])
        high[live] = np.where(miss >= 0, offset[live], high[live])
        with np.errstate(all="ignore"):
            rise, wanted = value - first[live], target[live] - first[live]
            new = offset[live] * np.exp(-np.log(rise / wanted) * rise / (offset[live] * slope))
            plain = offset[live] - miss / slope
            new = np.where(abs(miss) < abs(wanted) / 1000, plain, new)
            middle = np.where(
                np.isinf(high[live]),
                offset[live] * 16,
                np.where(low[live] > 0, np.sqrt(low[live] * high[live]), high[live] / LONG(1e6)),
            )
        sound = np.isfinite(new) & (new > low[live]) & (new < high[live])
        # rounding of the sums is below this; what is left of the root is its condition times as much
        done = (abs(miss) <= LONG("2e-18") * size) | (
            sound & (abs(new - offset[live]) <= LONG("2e-18") * offset[live])
        )
        offset[live] = np.where(sound, new, np.where(done, offset[live], middle))
        live = live[~done]
        if live.size == 0:
            return offset
    raise ArithmeticError(f"quadrature: the inverse of {target[live[0]]} is still at {offset[live[0]]}")


def invert(curve, target, of="g"):
    """Positions (index, offset) at which the rising curve g, or the moment, takes the values asked."""
    target = np.atleast_1d(np.asarray(target, dtype=LONG))
    ends = np.diff(curve.edges)
    index = np.zeros(target.size, dtype=int)
    if ends.size:
        computed = images(curve, np.arange(ends.size), ends, with_slope=False)
        index = np.searchsorted(computed.g if of == "g" else computed.moment, target, side="left")
    start = np.append(ends, max(curve.edges[-1], LONG(1e-300)))[index] / 2
    return index, polish(curve, target, index, start, of, steps=200)
