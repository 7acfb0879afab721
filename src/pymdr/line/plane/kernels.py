"""Compiled springs that follow shifts in the plane, each exactly over a straight row. Loads numba.

Spring y carries the vector t = q / (mu E*) with |t| <= m = d - y, all lengths. Over a straight row the normalised shift moves by
s e, and m changes linearly with s, dm/ds = alpha. A spring sticks until |t + e s| = m. From then on it slips along t to the end of
the row, and the angle theta of t to e obeys m dtheta = -sin(theta) ds: with dtau = ds / m

    tan(theta / 2) = tan(theta_0 / 2) exp(-tau),
    cos(theta) = (1 + cos(theta_0) - exp(-2 tau) (1 - cos(theta_0))) / (1 + cos(theta_0) + exp(-2 tau) (1 - cos(theta_0))).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pymdr.compiling import Fused
from pymdr.line.plane.turning import slip_integrals
from pymdr.units import FloatArray

_SHORT = 0.03
"""Largest slip in units of the limit that is integrated by Simpson's rule: relative error 5e-9 of the lost part."""
_STICKS = 1e-12
"""Distance from Coulomb's limit, relative to it, from which on a spring counts as sticking."""
_AT_LIMIT = 1e-15
"""Distance of the square of a spring from that of its limit, relative to it, that is rounding."""
_SERIES = 0.25
"""Slip in units of the limit up to which its lost part is a series: w is below it."""
_ENDLESS = 340.0
"""Slip in units of the limit after which a spring lies along the row, and exp(-2 tau) is not 0 yet."""
_TINY = 1e-150
"""Lengths below it count as none."""
_ITERATIONS = 200
_PATIENCE = 10
"""Iterations that have to halve the residual."""
_HALVINGS = 12
_SOLVED = 1e-12
"""Residual of a prescribed force over mu F_N."""
_ACCEPTED = 1e3 * _SOLVED
"""The same where rounding stops the search."""
_TURNS, _DOUBLINGS = 12, 7
"""Directions and lengths from which a search begins anew."""

COMPLETE, NOT_ATTAINABLE, NOT_CONVERGED = 0, 1, 2
FORCE_X, FORCE_Y, STORED, WORK, STICK, SLID, SHIFT_X, SHIFT_Y = range(8)
"""Columns of the rows; forces over 2 mu E* dx, energies over 2 mu^2 E*^2 dx / G*, shifts over mu E* / G*."""

_FUSED = Fused(__file__)
inner, inlined = _FUSED.inner, _FUSED.inlined


class Spring(NamedTuple):
    """A spring after a row: its vector, its slip work, and the distance it slipped."""

    x: float
    y: float
    work: float
    slid: float


class Move(NamedTuple):
    """A straight row: the shift, its length and direction, the depths before and after."""

    x: float
    y: float
    length: float
    e_x: float
    e_y: float
    before: float
    after: float


@inner
def move_of(x: float, y: float, before: float, after: float) -> Move:
    """A row from its shift and depths; at those next to nothing, whose products underflow, there is no contact."""
    length = math.sqrt(x * x + y * y)
    before = before if before > _TINY else min(before, 0.0)
    after = after if after > _TINY else min(after, 0.0)
    if length > 0.0:
        return Move(x, y, length, x / length, y / length, before, after)
    return Move(0.0, 0.0, 0.0, 1.0, 0.0, before, after)


@inlined
def _arc(along: float, across: float, length: float, low: float) -> tuple[float, float, float]:
    """
    A spring at a constant limit after a slip of tau up to 1, along and across the row, and w of `_reduction`.

    Tanh(tau / 2) = p / q as a continued fraction, to rounding. Without branches, so that loops over springs are vectorized.
    """
    large = low + abs(along)
    inverse = 1.0 / (low * large)
    tau, small = length * large * inverse, across * across * low * inverse
    near = large if along >= 0.0 else small
    far = small if along >= 0.0 else large
    half = 0.5 * tau
    square = half * half
    p = half * (135135.0 + square * (17325.0 + square * (378.0 + square)))
    q = 135135.0 + square * (62370.0 + square * (3150.0 + square * 28.0))
    near *= (q + p) * (q + p)
    grown = 2.0 * p * q * far
    far *= (q - p) * (q - p)
    whole = near + far
    inverse = 1.0 / (whole * (whole + grown))
    scale = low * (whole + grown) * inverse
    return scale * (near - far), scale * 2.0 * (q - p) * (q + p) * across, grown * whole * inverse


@inlined
def _reduction(w: float) -> float:
    """Log((1 + w) / (1 - w)), the integral of (1 - cos(theta)) dtau, for w up to 0.25 by its series."""
    v = w * w
    s = 1.0 / 17.0 + v * (1.0 / 19.0 + v * (1.0 / 21.0 + v * (1.0 / 23.0 + v / 25.0)))
    s = 1.0 / 9.0 + v * (1.0 / 11.0 + v * (1.0 / 13.0 + v * (1.0 / 15.0 + v * s)))
    return 2.0 * w * (1.0 + v * (1.0 / 3.0 + v * (0.2 + v * (1.0 / 7.0 + v * s))))


@inlined
def _turned(along: float, across: float, move: Move, length: float, low: float) -> Spring:
    """As `slipped` at a constant limit for tau up to 1."""
    cosine, sine, w = _arc(along, across, length, low)
    reduction = _reduction(w) if w < _SERIES else math.log((1.0 + w) / (1.0 - w))
    slid = max(length - low * reduction, 0.0)
    return Spring(cosine * move.e_x - sine * move.e_y, cosine * move.e_y + sine * move.e_x, low * slid, slid)


@inner
def _level(
    labels: FloatArray, vectors: FloatArray, first: int, last: int, move: Move, after: FloatArray
) -> None:
    """
    Springs from one up to another after a row of constant depth, without branches.

    Parameters
    ----------
    after : (3, n + 1)
        Filled with their vectors and the distances they slip, which are negative where slip is too long for the series.
    """
    square = move.length * move.length
    # indices without sign cannot count from the end, which would keep the loop from being vectorized
    for i in range(np.uintp(first), np.uintp(last)):
        low = move.after - labels[i]
        x, y = vectors[0, i], vectors[1, i]
        end_x, end_y = x + move.x, y + move.y
        b = x * move.x + y * move.y
        c = min(x * x + y * y - low * low, 0.0)
        c = 0.0 if c >= -_AT_LIMIT * low * low else c
        root = math.sqrt(b * b - square * c)
        begin = (-c if b > 0.0 else root - b) / (b + root if b > 0.0 else square)
        sticks = (end_x * end_x + end_y * end_y <= low * low) | (begin >= 1.0)
        x, y = x + begin * move.x, y + begin * move.y
        rest = move.length * (1.0 - begin)
        cosine, sine, w = _arc(x * move.e_x + y * move.e_y, move.e_x * y - move.e_y * x, rest, low)
        slid = max(rest - low * _reduction(w), 0.0)
        slid = slid if rest <= _SERIES * low else -1.0
        after[0, i] = end_x if sticks else cosine * move.e_x - sine * move.e_y
        after[1, i] = end_y if sticks else cosine * move.e_y + sine * move.e_x
        after[2, i] = 0.0 if sticks else slid


@inner
def _first_beyond(labels: FloatArray, vectors: FloatArray, touching: int, move: Move) -> int:
    """The first spring that a row of constant depth moves beyond its limit, or their number."""
    for i in range(touching):
        low = move.after - labels[i]
        x, y = vectors[0, i] + move.x, vectors[1, i] + move.y
        if x * x + y * y > low * low:
            return i
    return touching


@inlined
def slipped(x: float, y: float, move: Move, length: float, low: float, high: float) -> Spring:
    """A spring at its limit that slips over a length, while the limit goes from `low` to `high`."""
    e_x, e_y = move.e_x, move.e_y
    along, across = x * e_x + y * e_y, e_x * y - e_y * x
    if low == high and length <= low:
        return _turned(along, across, move, length, low)
    grown = (high - low) / low
    if length == 0.0:
        tau = 0.0
    elif grown <= -1.0:
        tau = _ENDLESS
    elif abs(grown) < 1e-5:
        tau = length / low * (1.0 - grown * (0.5 - grown / 3.0))
    else:
        tau = length / low * math.log1p(grown) / grown
    # 1 + cos(theta) and 1 - cos(theta), times the limit; their ratio is tan(theta / 2)^2
    if along >= 0.0:
        near = low + along
        far = across * across / near
    else:
        far = low - along
        near = across * across / far
    turn = math.exp(-min(tau, _ENDLESS))
    end = turn * turn * far
    whole = near + end
    if abs(grown) < 1e-13:
        first = low * math.log((near + far) / whole)
        second = low * first
    elif tau <= _SHORT:
        before, middle, after = far / (near + far), turn * far / (near + turn * far), end / whole
        first = tau / 3.0 * (low * before + 4.0 * math.sqrt(low * high) * middle + high * after)
        second = tau / 3.0 * (low * low * before + 4.0 * low * high * middle + high * high * after)
    else:
        first, second = slip_integrals(tau, near, far, low, (high - low) / length)
    slid = max(length - first - (high - low), 0.0)
    work = max(0.5 * (low + high) * (length - (high - low)) - second, 0.0)
    cosine, sine = high * (near - end) / whole, high * 2.0 * turn * across / whole
    return Spring(cosine * e_x - sine * e_y, cosine * e_y + sine * e_x, work, slid)


@inlined
def advanced(x: float, y: float, label: float, move: Move, slips: bool) -> Spring:
    """A spring after a straight row."""
    low, high = move.before - label, move.after - label
    if low <= 0.0 and high <= 0.0:
        return Spring(0.0, 0.0, 0.0, 0.0)
    length = move.length
    if low <= 0.0:
        length *= high / (high - low)
        if not slips or length <= high:
            return Spring(length * move.e_x, length * move.e_y, 0.0, 0.0)
        return Spring(high * move.e_x, high * move.e_y, 0.5 * high * (length - high), length - high)
    change = high - low
    until = 1.0 if high >= 0.0 else -low / change
    if not slips:
        if high <= 0.0:
            x, y = x + until * move.x, y + until * move.y
            return Spring(0.0, 0.0, 0.5 * (x * x + y * y), 0.0)
        return Spring(x + move.x, y + move.y, 0.0, 0.0)
    if high > 0.0:  # |t| - m is convex along a row: a spring below its limit at both ends sticks
        end_x, end_y = x + move.x, y + move.y
        if end_x * end_x + end_y * end_y <= high * high:
            return Spring(end_x, end_y, 0.0, 0.0)
    a = (length - change) * (length + change)
    b = x * move.x + y * move.y - low * change
    c = min(x * x + y * y - low * low, 0.0)
    begin = math.inf
    if b > 0.0:
        if c >= -_AT_LIMIT * low * low:
            begin = 0.0
        else:
            inside = b * b - a * c
            if inside >= 0.0:
                begin = -c / (b + math.sqrt(inside))
    elif a > 0.0:
        begin = (math.sqrt(b * b - a * c) - b) / a
    if begin >= until:
        if high <= 0.0:
            return Spring(0.0, 0.0, 0.0, 0.0)
        x, y = x + move.x, y + move.y
        part = high / math.sqrt(x * x + y * y)  # beyond its limit by rounding
        return Spring(part * x, part * y, 0.0, 0.0)
    if begin > 0.0:
        x, y = x + begin * move.x, y + begin * move.y
        low += begin * change
    if not low > 0.0:
        return Spring(0.0, 0.0, 0.0, 0.0)
    return slipped(x, y, move, length * (until - begin), low, max(high, 0.0))


@inner
def force_of(labels: FloatArray, vectors: FloatArray, move: Move, slips: bool) -> tuple[float, float]:
    """The sum of the springs after a row."""
    x = y = 0.0
    for i in range(1, labels.size):
        spring = advanced(vectors[0, i], vectors[1, i], labels[i], move, slips)
        x += spring.x
        y += spring.y
    return x, y


@inner
def closer(
    labels: FloatArray,
    vectors: FloatArray,
    depths: tuple[float, float],
    target: FloatArray,
    slips: bool,
    begin: tuple[float, float, float],
    capacity: tuple[float, int],
) -> tuple[float, float, float]:
    """
    Newton's method with damping for the shift of a row that ends at a force.

    `begin` is a shift and its residual, as is the answer; `capacity` is mu F_N and the number of springs in contact.
    """
    x, y, size = begin
    limit, touching = capacity
    before, after = depths
    f_x, f_y = force_of(labels, vectors, move_of(x, y, before, after), slips)
    r_x, r_y = f_x - target[0], f_y - target[1]
    trusted, earlier = 4.0 * max(size / touching, 0.1 * math.hypot(x, y)), math.inf
    for iteration in range(_ITERATIONS):
        if size <= _SOLVED * limit:
            break
        if iteration % _PATIENCE == 0:
            if size > 0.5 * earlier:
                break
            earlier = size
        step = 1e-7 * (limit / touching + size / touching)
        a_x, a_y = force_of(labels, vectors, move_of(x + step, y, before, after), slips)
        b_x, b_y = force_of(labels, vectors, move_of(x, y + step, before, after), slips)
        xx, yx, xy, yy = (a_x - f_x) / step, (a_y - f_y) / step, (b_x - f_x) / step, (b_y - f_y) / step
        determinant = xx * yy - xy * yx
        if determinant > 0.0:
            g_x, g_y = (xy * r_y - yy * r_x) / determinant, (yx * r_x - xx * r_y) / determinant
        else:
            g_x, g_y = -r_x / touching, -r_y / touching
        # unloading may leave all springs at their limits: the first steps are those of springs that stick
        part = min(1.0, trusted / max(math.hypot(g_x, g_y), 1e-300))
        smaller = size
        for _halving in range(_HALVINGS):
            f_x, f_y = force_of(
                labels, vectors, move_of(x + part * g_x, y + part * g_y, before, after), slips
            )
            smaller = math.hypot(f_x - target[0], f_y - target[1])
            if smaller < size:
                break
            part *= 0.5
        if not smaller < size:
            break
        trusted = 4.0 * part * math.hypot(g_x, g_y)
        x, y, size = x + part * g_x, y + part * g_y, smaller
        r_x, r_y = f_x - target[0], f_y - target[1]
    return x, y, size


def _moved_to(
    labels: FloatArray, vectors: FloatArray, before: float, after: float, target: FloatArray, slips: bool
) -> tuple[float, float, int]:
    """
    The shift of a row that ends at a force, and how the search ended.

    A load that falls leaves all springs at their limits, so that short shifts turn their sum but do not change its size, and the residual
    has minima above 0. The search then begins anew from longer shifts: every force below mu F_N has one, since the force of long
    shifts is mu F_N along them.
    """
    limit, touching = 0.0, 0
    for i in range(1, labels.size):
        if labels[i] < after:
            limit += after - labels[i]
            touching += 1
    if touching == 0:
        return 0.0, 0.0, COMPLETE if target[0] == 0.0 and target[1] == 0.0 else NOT_ATTAINABLE
    if slips and math.hypot(target[0], target[1]) >= limit * (1.0 - 1e-9):
        return 0.0, 0.0, NOT_ATTAINABLE
    depths, capacity = (before, after), (limit, touching)
    f_x, f_y = force_of(labels, vectors, move_of(0.0, 0.0, before, after), slips)
    size = math.hypot(f_x - target[0], f_y - target[1])
    x, y, least = closer(labels, vectors, depths, target, slips, (0.0, 0.0, size), capacity)
    if least <= _ACCEPTED * limit:
        return x, y, COMPLETE
    first = math.atan2(target[1] - f_y, target[0] - f_x)
    for doubling in range(_DOUBLINGS):
        length = 0.25 * 2.0**doubling * max(before, after)
        for turn in range(_TURNS):
            angle = first + 2.0 * math.pi / _TURNS * turn
            x, y = length * math.cos(angle), length * math.sin(angle)
            f_x, f_y = force_of(labels, vectors, move_of(x, y, before, after), slips)
            size = math.hypot(f_x - target[0], f_y - target[1])
            x, y, least = closer(labels, vectors, depths, target, slips, (x, y, size), capacity)
            if least <= _ACCEPTED * limit:
                return x, y, COMPLETE
    return x, y, NOT_CONVERGED


@inner
def stick_border(
    labels: FloatArray, places: FloatArray, vectors: FloatArray, depth: float, edge: float
) -> float:
    """Radius of the springs below their limit: between two springs where the distance from it comes to 0."""
    i = labels.size - 1
    while i >= 0 and labels[i] >= depth:
        i -= 1
    border = edge
    while i >= 0:
        limit = depth - labels[i]
        square = vectors[0, i] * vectors[0, i] + vectors[1, i] * vectors[1, i]
        if square < (1.0 - 2.0 * _STICKS) * limit * limit:
            left = limit - math.sqrt(square)
            if border < edge and i > 0:
                inner_left = depth - labels[i - 1] - math.hypot(vectors[0, i - 1], vectors[1, i - 1])
                if inner_left > left:
                    rest = left * (places[i] - places[i - 1]) / (inner_left - left)
                    return float(min(places[i] + rest, border))
            return border
        border = places[i]
        i -= 1
    return 0.0


def _run(
    line: FloatArray,
    vectors: FloatArray,
    pressed: FloatArray,
    target: FloatArray,
    begin: FloatArray,
    rows: FloatArray,
    ahead: FloatArray,
    slips: bool,
) -> None:
    """
    Follow the rows of a leg; `vectors` of the springs are overwritten.

    Parameters
    ----------
    line : (2, n + 1)
        Labels y and places x of the springs, rising; the first is that of the middle and has no weight.
    vectors : (2, n + 1)
        Their vectors.
    pressed : (2, m)
        Depth and contact radius of every row.
    target : (m, 2)
        Shifts, in the units of `rows`.
    begin : (5,)
        Depth, shift along x and y, slip work and distance of full sliding before the first row.
    rows : (m, 8)
        Columns, filled.
    ahead : (3, n + 1)
        Memory for springs at constant depth.
    """
    labels, places, depth, edge = line[0], line[1], pressed[0], pressed[1]
    before, at_x, at_y, work, slid = begin[0], begin[1], begin[2], begin[3], begin[4]
    for row in range(depth.size):
        after = depth[row]
        x, y = target[row, 0] - at_x, target[row, 1] - at_y
        at_x, at_y = target[row, 0], target[row, 1]
        move = move_of(x, y, before, after)
        f_x = f_y = stored = 0.0
        # rows at constant depth: springs inside stick, and those up to the edge are advanced together
        inside = touching = 0
        if slips and before == after and move.length > 0.0:
            touching = int(np.searchsorted(labels, move.after))
            inside = _first_beyond(labels, vectors, touching, move)
            _level(labels, vectors, inside, touching, move, ahead)
        for i in range(labels.size):
            if i < inside:
                spring = Spring(vectors[0, i] + x, vectors[1, i] + y, 0.0, 0.0)
            elif i < touching and ahead[2, i] >= 0.0:
                spring = Spring(ahead[0, i], ahead[1, i], (after - labels[i]) * ahead[2, i], ahead[2, i])
            else:
                spring = advanced(vectors[0, i], vectors[1, i], labels[i], move, slips)
            vectors[0, i], vectors[1, i] = spring.x, spring.y
            if i == 0:
                slid += spring.slid
            else:
                f_x += spring.x
                f_y += spring.y
                stored += 0.5 * (spring.x * spring.x + spring.y * spring.y)
                work += spring.work
        before = after
        rows[row, FORCE_X], rows[row, FORCE_Y] = f_x, f_y
        rows[row, STORED], rows[row, WORK] = stored, work
        rows[row, SLID], rows[row, SHIFT_X], rows[row, SHIFT_Y] = slid, at_x, at_y
        if slips:
            rows[row, STICK] = stick_border(labels, places, vectors, after, edge[row])
        else:
            rows[row, STICK] = edge[row]


moved_to = _FUSED.compiled(_moved_to)
run = _FUSED.compiled(_run)
