"""Compiled sums of exponentials and a straight line on [0, 1]: values and the first crossing of 0. Loads numba.

    f(p) = c + s p + sum_i [a_i exp(-x_i p) + b_i p mean(x_i p)],    mean(x) = (1 - exp(-x))/x.

The terms b_i keep their digits however small x_i is, 0 included. Every term is monotone; the falling ones are convex and lie
above their tangents, the rising ones are concave and lie above their chord. So f is bounded from below on any interval, and
its derivative from both sides: an interval is halved until f surely stays above 0, rises, or falls.
"""

from __future__ import annotations

import math

from pymdr.compiling import Addressed, inner
from pymdr.units import FloatArray

DECAYING, GROWING, RATES = range(3)
"""First columns of the terms of a sum, one term per row: a, b and x, which is not below 0."""
ROUNDING = 2e-15
"""Relative size of the terms that counts as 0."""
SHORTEST = 2.0**-40
"""Width of intervals that are not halved."""
NEVER = 2.0
"""Result for a sum without a zero."""
CROSSED = 0.0, int(0.0)
"""The type of what :func:`first_crossing` returns."""
_NEWTON = 60
_VALUE, _SLOPE, _FALLING, _RISE, _BEND, _DROP, _CURL, _SIZE = range(8)
"""Of a sum at one place: f and f'; its falling terms; f' and f'' of its rising and of its falling terms; the size of c and of what is left of a."""
Bounds = tuple[float, float, float, float, float, float, float, float]


@inner
def mean(x: float) -> float:
    """The mean of exp(-x p) over p from 0 to 1."""
    return -math.expm1(-x) / x if x > 0.0 else 1.0


@inner
def moments(x: float) -> tuple[float, float, float, float, float, float]:
    """
    Moments m0 to m5 of a Maxwell element (spring h) under a straight move e over x relaxation times.

    It bears m0 h + m1 e in the end, m1 h + m2 e on average, and takes m3 h^2 + 2 m4 h e + m5 e^2.
    """
    c = -math.expm1(-x)
    left, own = 1.0 - c if x < 0.5 else math.exp(-x), -0.5 * math.expm1(-2.0 * x)
    if x > 0.3:
        return left, c / x, (x - c) / (x * x), own, 0.5 * c * c / x, (x - c - 0.5 * c * c) / (x * x)
    ramp, moved, term, power = 0.0, 0.0, 0.5, 2.0  # the differences above lose their digits
    for k in range(2, 16):
        ramp += term
        moved += term * (2.0 - power)
        term *= -x / (k + 1)
        power *= 2.0
    even = c / x if x > 0.0 else 1.0
    return left, even, ramp, own, 0.5 * c * even, moved


@inner
def _at(line: tuple[float, float], terms: FloatArray, count: int, p: float) -> Bounds:
    """Bounds of a sum near p."""
    falling, rise, bend, drop, curl = 0.0, 0.0, 0.0, 0.0, 0.0
    value, size = line[0] + line[1] * p, abs(line[0])
    for i in range(count):
        x, a, b = terms[i, RATES], terms[i, DECAYING], terms[i, GROWING]
        gone = -math.expm1(-x * p)
        left = 1.0 - gone
        term = left * a + b * (gone / x if x > 0.0 else p)
        slope = b - x * a
        slope = (
            left * slope if abs(slope) > ROUNDING * abs(x * a) else 0.0
        )  # a steady term is no more than its rounding
        value += term
        size += left * abs(a)
        if slope > 0.0:
            rise, bend = rise + slope, bend - x * slope
        else:
            falling, drop, curl = falling + term, drop + slope, curl - x * slope
    return value, line[1] + rise + drop, falling, rise, bend, drop, curl, size


@inner
def _least(before: float, after: float, fall: float, fallen: float, steep: float, flat: float) -> float:
    """
    Bound from below of a sum that goes from `before` to `after`.

    Its convex part goes from `fall` to `fallen`, with the slopes `steep` and `flat` over the whole way; the rest is concave.
    """
    least = min(before, after)
    if steep < flat:
        meet = min(max((fallen - flat - fall) / (steep - flat), 0.0), 1.0)
        chord = (after - fallen) - (before - fall)
        least = min(least, before + (steep + chord) * meet)
    return least


@inner
def _root(
    line: tuple[float, float], terms: FloatArray, count: int, low: float, high: float, guess: float
) -> float:
    """The zero of a decreasing sum, by Newton's method within a bracket."""
    p = min(max(guess, low), high)
    for _ in range(_NEWTON):
        here = _at(line, terms, count, p)
        if here[_VALUE] > 0.0:
            low = p
        else:
            high = p
        following = p - here[_VALUE] / here[_SLOPE] if here[_SLOPE] < 0.0 else low
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - p) <= ROUNDING:
            return following
        p = following
    return p


@Addressed
def first_crossing(
    line: tuple[float, float], terms: FloatArray, count: int, begin: float
) -> tuple[float, int]:
    """
    The first p from `begin` to 1 at which a sum falls below 0, or NEVER; and how many intervals were tried.

    `line` is c and s; the first `count` rows of `terms` are the terms. A sum that is below 0 at `begin` by more than rounding
    crosses there.
    """
    now = _at(line, terms, count, begin)
    if now[_VALUE] < -ROUNDING * now[_SIZE]:
        return begin, 1
    p, width, tried = begin, 1.0 - begin, 0
    while p < 1.0:
        tried += 1
        end = min(p + width, 1.0)
        width = end - p
        ahead = _at(line, terms, count, end)
        slack = -ROUNDING * max(now[_SIZE], ahead[_SIZE])
        above = ahead[_VALUE] >= -ROUNDING * ahead[_SIZE]  # of what is left of the terms there
        stays = above and (
            _least(
                now[_VALUE],
                ahead[_VALUE],
                now[_FALLING],
                ahead[_FALLING],
                width * now[_DROP],
                width * ahead[_DROP],
            )
            >= slack
        )
        if not stays:
            least_rise = _least(
                now[_SLOPE], ahead[_SLOPE], now[_RISE], ahead[_RISE], width * now[_BEND], width * ahead[_BEND]
            )
            least_descent = _least(
                -now[_SLOPE],
                -ahead[_SLOPE],
                -now[_DROP],
                -ahead[_DROP],
                -width * now[_CURL],
                -width * ahead[_CURL],
            )
            short = width <= SHORTEST
            if least_descent >= 0.0 and not above:
                guess = p + width * now[_VALUE] / (now[_VALUE] - ahead[_VALUE])
                return _root(line, terms, count, p, end, guess), tried
            if short and not above:
                return end, tried
            stays = (above and (least_rise >= 0.0 or least_descent >= 0.0 or short)) or least_rise >= 0.0
        if stays:
            p, width, now = end, 2.0 * width, ahead
        else:
            width *= 0.5
    return NEVER, tried
