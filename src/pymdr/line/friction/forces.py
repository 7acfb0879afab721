"""Compiled kernels of force control: the same stack in (F_N, F_x / mu). Loads numba."""

from __future__ import annotations

import math
from typing import NamedTuple

from numpy.polynomial.legendre import leggauss

from pymdr.line.friction.kernels import (
    MEET,
    MERGE,
    Anchors,
    Point,
    at,
    clear,
    keep_slope,
    lengthens,
    moment,
    on_segment,
    push,
    put,
    vertex,
)
from pymdr.line.friction.layout import MODULUS
from pymdr.line.friction.reading import curve, depth_of_force, fused
from pymdr.units import FloatArray

_OUTER, _INNER = (
    tuple((0.5 * (float(x) + 1.0), 0.5 * float(w)) for x, w in zip(*leggauss(n), strict=True)) for n in (6, 4)
)
_ROUNDING = 1e-14  # of force times depth: what the closed form of the slip work loses on a table


class Loading(NamedTuple):
    """A straight step in forces: its start in (F_N, S), and the changes."""

    force: float
    pull: float
    d_force: float
    d_pull: float


class Loaded(NamedTuple):
    """A point of the anchor curve, and S there."""

    point: Point
    pull: float


@fused.inlined
def loaded(anchors: Anchors, i: int) -> Loaded:
    """Vertex i."""
    return Loaded(at(anchors.stack, i), vertex(anchors.stack, i).pull)


@fused.inner
def mean_depth(line: FloatArray, upper: float, lower: float) -> float:
    """Mean of d over the forces between F_N(lower) and F_N(upper)."""
    if upper == lower:
        return upper
    a_u, f_u, w_u = curve(line, upper)
    a_l, f_l, w_l = curve(line, lower)
    if abs(upper - lower) > 1e-3 * max(upper, lower):
        return (upper * f_u - w_u - lower * f_l + w_l) / (f_u - f_l)
    return float(0.5 * (upper + lower) - (f_u - f_l) * (1.0 / a_u - 1.0 / a_l) / (24.0 * line[0, MODULUS]))


@fused.inner
def force_ahead(here: Loaded, g: float, step: Loading) -> float:
    """F_N - F_N(y) when slip toward g reaches the spring at a point, within the step."""
    to_start = step.force - here.point.force
    to_end = (step.force + step.d_force) - here.point.force  # no rounding where the force ends at 0
    if step.d_force == 0.0:
        return to_start
    gained = g * (step.d_force * (here.pull - step.pull) + step.d_pull * to_start)
    gained /= g * step.d_pull - step.d_force
    return float(min(max(gained, min(to_start, to_end)), max(to_start, to_end)))


@fused.inner
def slip_work(line: FloatArray, slope: float, g: float, upper: Loaded, lower: Loaded, step: Loading) -> float:
    """
    Slip work while the border of slip toward g passes over a part of a segment under force control.

    |slope - g| int [F_N(D) - F_N(y) - 2 E* (D - y) a(y)] dy with F_N(D) linear in F_N(y).
    """
    p, q = lower.point, upper.point
    length = q.y - p.y
    rise = q.force - p.force
    if length <= 0.0 or rise <= 0.0 or slope == g:
        return 0.0
    e_u, e_l = force_ahead(upper, g, step), force_ahead(lower, g, step)
    d_u = depth_of_force(line, q.force + e_u)
    d_l = depth_of_force(line, p.force + e_l)
    middle = p.force + moment(line, p, q) / length
    n_mean = (p.force + e_l) + (rise + e_u - e_l) * (middle - p.force) / rise
    body = length * (n_mean + q.force - 2.0 * middle) - rise * (mean_depth(line, d_u, d_l) - p.y)
    if max(e_u, e_l) < 0.05 * q.force and p.y > 1e-3 * q.y:
        closer = short_slip_work(line, q, e_u, p, e_l)
        if abs(closer - body) <= _ROUNDING * q.force * q.y:
            body = closer
    return float((1.0 - g * slope) * body)


@fused.merged
def short_slip_work(line: FloatArray, upper: Point, e_u: float, lower: Point, e_l: float) -> float:
    """
    Integral of F_N(D) - F_N(y) - 2 E* (D - y) a(y) over a segment where D is close to y, by quadrature.

    With delta = D - y it is 2 E* int_0^delta [a(y + t) - a(y)] dt: the terms of the closed form cancel to the
    second order in delta, those of this one to the first.
    """
    per_rise = (e_u - e_l) / (upper.force - lower.force)
    twice = 2.0 * line[0, MODULUS]
    panels = 1 + int(3.0 * math.log(upper.y / lower.y))
    ratio = (upper.y / lower.y) ** (1.0 / panels)
    total = 0.0
    low = lower.y
    for panel in range(panels):
        width = (low * ratio if panel < panels - 1 else upper.y) - low
        for node, weight in _OUTER:
            y = low + width * node
            a, force, _work = curve(line, y)
            ahead = e_l + per_rise * (force - lower.force)
            delta = ahead / (twice * a)
            grown = 0.0
            for turn in range(3):
                grown = 0.0
                for part, gauss_weight in _INNER:
                    grown += gauss_weight * (curve(line, y + delta * part)[0] - a)
                if turn < 2:
                    delta -= (delta * (a + grown) - ahead / twice) / curve(line, y + delta)[0]
            total += width * weight * grown * delta
        low += width
    return float(twice * total)


@fused.inner
def detach(line: FloatArray, slope: float, upper: Loaded, lower: Loaded, step: Loading) -> float:
    """Slip work while the contact shrinks over a part of a segment: the side is that of the chord."""
    p, q = lower.point, upper.point
    ratio = step.d_pull / step.d_force
    lag_u = step.pull + ratio * (q.force - step.force) - upper.pull
    lag_l = step.pull + ratio * (p.force - step.force) - lower.pull
    if lag_u == 0.0 and lag_l == 0.0:
        return 0.0
    if lag_u * lag_l >= 0.0:
        return slip_work(line, slope, 1.0 if lag_u + lag_l > 0.0 else -1.0, upper, lower, step)
    force = p.force + (q.force - p.force) * (lag_l / (lag_l - lag_u))
    y = min(max(depth_of_force(line, force), p.y), q.y)
    a, force, work = curve(line, y)
    pull = lower.pull + slope * (force - p.force)
    middle = Loaded(Point(y, p.b + slope * (y - p.y), force, work, a), pull)
    g = 1.0 if lag_u > 0.0 else -1.0
    return slip_work(line, slope, g, upper, middle, step) + slip_work(line, slope, -g, middle, lower, step)


@fused.merged
def extend(anchors: Anchors, m: int, end: Point, slope: float) -> int:
    """Append a segment that sticks, joined to the top one when all its points stay within rounding of a line."""
    if m > 0:
        top, below = vertex(anchors.stack, m), vertex(anchors.stack, m - 1)
        pull = top.pull + slope * (end.force - top.force)
        size = max(abs(slope) * end.force, max(abs(pull), abs(below.pull)))
        # a bend at a force that is lost beside the new one may still be seen in the shift
        seen = max(abs(slope) * end.y, max(abs(end.b), abs(below.b)))
        tolerance = MERGE * min(size / (top.force - below.force), seen / (top.y - below.y))
        chord = (pull - below.pull) / (end.force - below.force)
        if lengthens(anchors.stack, m, chord, tolerance):
            joined = Point(end.y, below.b + chord * (end.y - below.y), end.force, end.work, end.radius)
            put(anchors, m, joined, min(max(chord, -1.0), 1.0))
            return m
    push(anchors, m + 1, end, slope)
    return m + 1


@fused.merged
def lift(anchors: Anchors, m: int, step: Loading, end: Point) -> tuple[int, Loaded, float]:
    """Cut the anchors at a lesser force. Returns the segment that is cut, the point on it and the slip work."""
    upper = loaded(anchors, m)
    total = 0.0
    i = m
    while i > 0 and vertex(anchors.stack, i - 1).force > end.force:
        lower = loaded(anchors, i - 1)
        total += detach(anchors.line, vertex(anchors.stack, i).slope, upper, lower, step)
        upper = lower
        i -= 1
    slope = vertex(anchors.stack, i).slope
    below = loaded(anchors, i - 1)
    b = below.point.b + slope * (end.y - below.point.y)
    pull = below.pull + slope * (end.force - below.point.force)
    cut = Loaded(Point(end.y, b, end.force, end.work, end.radius), pull)
    total += detach(anchors.line, slope, upper, cut, step)
    if i < m:
        keep_slope(anchors.stack, i)
    return i, cut, total


@fused.merged
def slip(
    anchors: Anchors, i: int, upper: Loaded, step: Loading, end: Point, pull: float
) -> tuple[int, float]:
    """Let springs slip from a point of segment i on, until they carry `pull`. Returns the top and the slip work."""
    total = 0.0
    g = 1.0 if pull > upper.pull else -1.0
    edge = g * pull - end.force
    lower = loaded(anchors, i - 1)
    while i > 1 and edge > g * lower.pull - lower.point.force:
        total += slip_work(anchors.line, vertex(anchors.stack, i).slope, g, upper, lower, step)
        upper = lower
        i -= 1
        lower = loaded(anchors, i - 1)
    slope = vertex(anchors.stack, i).slope
    bottom = lower.point.y
    y = slip_border(anchors, i, g, edge, upper.point.y)
    if y - bottom > MEET * end.y:
        point = on_segment(anchors, i, y)
        lower = Loaded(point, lower.pull + slope * (point.force - lower.point.force))
    total += slip_work(anchors.line, slope, g, upper, lower, step)
    if lower.point.y > bottom:
        put(anchors, i, lower.point, slope)
        i += 1
    elif i > 1 and vertex(anchors.stack, i - 1).slope == g:
        i -= 1
    b = lower.point.b + g * (end.y - lower.point.y)
    push(anchors, i, Point(end.y, b, end.force, end.work, end.radius), g)
    return i, total


@fused.merged
def load(anchors: Anchors, m: int, force: float, pull: float) -> tuple[int, float]:
    """Go straight to (F_N, S), |S| <= F_N: the same stack in forces. Returns top and slip work."""
    upper = loaded(anchors, m)
    end = upper.point
    if force != end.force:
        y = depth_of_force(anchors.line, force)
        a, force, work = curve(anchors.line, y)
        end = Point(y, end.b, force, work, a)
    pull = min(max(pull, -force), force)
    step = Loading(upper.point.force, upper.pull, force - upper.point.force, pull - upper.pull)
    if step.d_force == 0.0 and step.d_pull == 0.0:
        return m, 0.0
    if step.d_force > 0.0 and abs(step.d_pull) <= step.d_force:
        slope = step.d_pull / step.d_force
        b = end.b + slope * (end.y - upper.point.y)
        return extend(anchors, m, Point(end.y, b, end.force, end.work, end.radius), slope), 0.0
    total = 0.0
    if step.d_force < 0.0:
        m, upper, total = lift(anchors, m, step, end)
        if end.y == 0.0:
            clear(anchors.stack, upper.point.b)
            return 0, max(total, 0.0)
        if pull == upper.pull:
            put(anchors, m, upper.point, vertex(anchors.stack, m).slope)
            return m, max(total, 0.0)
    m, work = slip(anchors, m, upper, step, end, pull)
    return m, max(total + work, 0.0)


@fused.inner
def slip_border(anchors: Anchors, i: int, g: float, edge: float, top: float) -> float:
    """Depth on segment i, not below `top`, where g S - F_N = edge: the border of slip."""
    below = vertex(anchors.stack, i - 1)
    bend = 1.0 - g * vertex(anchors.stack, i).slope
    excess = g * below.pull - below.force - edge
    if not excess > 0.0 or bend <= 0.0:
        return float(below.y)
    y = depth_of_force(anchors.line, below.force + excess / bend)
    return float(max(y, below.y)) if y < top else top


@fused.merged
def shift_for(anchors: Anchors, m: int, depth: float, force: float, pull: float) -> float:
    """
    Shift at which the normalised tangential force is `pull` at `depth`, |pull| <= F_N(depth) = force.

    The force rises with the shift and its inverse is known between the values at which the border of slip
    stands on a vertex, so the segment is found by descending the stack.
    """
    i = m
    y, b, s = vertex(anchors.stack, m).y, vertex(anchors.stack, m).b, vertex(anchors.stack, m).pull
    if depth > y:
        rise = force - vertex(anchors.stack, m).force
        if abs(pull - s) <= rise:
            return float(b + (pull - s) / rise * (depth - y))
    elif depth < y:
        while i > 1 and vertex(anchors.stack, i - 1).y > depth:
            i -= 1
        below = vertex(anchors.stack, i - 1)
        b = below.b + vertex(anchors.stack, i).slope * (depth - below.y)
        s = below.pull + vertex(anchors.stack, i).slope * (force - below.force)
    if pull == s:
        return float(b)
    g = 1.0 if pull > s else -1.0
    edge = g * pull - force
    while i > 1 and edge > g * vertex(anchors.stack, i - 1).pull - vertex(anchors.stack, i - 1).force:
        i -= 1
    if i == 0:
        return float(anchors.stack[0].b + g * depth)
    y = slip_border(anchors, i, g, edge, min(vertex(anchors.stack, i).y, depth))
    below = vertex(anchors.stack, i - 1)
    return float(below.b + vertex(anchors.stack, i).slope * (y - below.y) + g * (depth - y))
