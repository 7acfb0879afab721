"""The consistency of f with its given derivative."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev

from pymdr.errors import ProblemError
from pymdr.mapping.callables.noise import EPS, Curve, jitter, scatter
from pymdr.units import FloatArray, metres

_AN_OCTAVE, _MOST, _LEAST = 16, 400, 64
_LENGTHS = np.array([0.19, 0.012])
"""Relative lengths of additional panels over which f' is integrated."""
_NODES = 17
_ROUNDINGS = 16.0
_ROUNDS, _PERSISTS = 7, 3
_NOISE_RADII = 64
_FEW_LEVELS = 12
_UNDERFLOW = 1e-290
_RELATIVE = 1e-7
"""Accepted relative difference, for constants with 8 digits and derivatives by differences."""


def check_consistency(
    f: Curve,
    derivative: Curve,
    low: float,
    high: float,
    breakpoints: Sequence[float] = (),
    farthest: float | None = None,
) -> None:
    """
    Refuse a derivative that is inconsistent with f.

    On panels that cover all radii, the integral of the derivative is compared with the difference of f. Both are
    inconsistent if they differ by more than the rounding of f, the difference of two quadrature rules, and a fraction of
    the integral of abs(f'), on a panel, on parts of it, and on parts of these.

    Parameters
    ----------
    f, derivative : callable
        Taking and giving arrays; an offset of f does not matter.
    low, high : float
        Range of radii in m, 0 < low < high.
    breakpoints : sequence of float
        Radii at which f' jumps: no panel crosses one.
    farthest : float, optional
        Largest radius in m at which the rounding of f is measured; near the tip it may be invisible.

    Raises
    ------
    ProblemError
        With the radius and both slopes.

    Examples
    --------
    >>> check_consistency(lambda r: 3.0 + r * r / 2.0, lambda r: r, 1e-9, 1.0)
    >>> check_consistency(lambda r: r * r / 2.0, lambda r: 2.0 * r, 1e-9, 1.0)
    Traceback (most recent call last):
        ...
    pymdr.errors.ProblemError: f(r) and derivative contradict each other ...
    """
    with np.errstate(all="ignore"):
        noise = _noise_of(f, low, high if farthest is None else farthest)
        start, end = _panels(low, high, breakpoints)
        values = f(np.geomspace(low, high, _NOISE_RADII))
        if not np.isfinite(values).any():
            raise ProblemError(
                f"f(r) returns {values[-1]} from r = {metres(low)} to {metres(high)}, where derivative is defined; define both "
                "on the same radii, or give only one"
            )
        stairs = _stairs(values)
        streak = np.zeros(start.shape, dtype=int)
        for _ in range(_ROUNDS):
            rise, integral, sure, spread = _compared(f, derivative, noise, start, end)
            difference = np.abs(rise - integral)
            # a callable with only a few levels on these radii does not determine a slope
            wrong = (difference > sure + 16.0 * spread) & (difference > stairs)
            streak = np.where(wrong, streak + 1, 0)
            worst = int(np.argmax(streak * 1e300 + np.nan_to_num(difference / sure)))
            if streak[worst] >= _PERSISTS:
                raise _contradiction(start[worst], end[worst], rise[worst], integral[worst])
            # panels that the rules do not resolve are divided into three parts, too
            unresolved = np.flatnonzero(difference > sure)
            if unresolved.size == 0:
                return
            first = np.argsort(-streak[unresolved], kind="stable")[
                :: max(1, math.ceil(unresolved.size / 160))
            ]
            cuts = np.linspace(start[unresolved[first]], end[unresolved[first]], 4)
            start, end, streak = cuts[:-1].ravel(), cuts[1:].ravel(), np.tile(streak[unresolved[first]], 3)


def _contradiction(start: float, end: float, rise: float, integral: float) -> ProblemError:
    """The error for a derivative that contradicts f."""
    return ProblemError(
        f"f(r) and derivative contradict each other near r = {metres(0.5 * (start + end))}: the slope of f is "
        f"{rise / (end - start):.6g}, derivative gives {integral / (end - start):.6g}; correct one of them, or give only one"
    )


def _noise_of(f: Curve, low: float, high: float) -> Curve:
    """Rounding of f at any radius; where f cancels, at least the rounding further out."""
    r = np.geomspace(low, high, max(_NOISE_RADII, math.ceil(4.0 * math.log2(high / low))))
    # the lesser of two neighbours, because one may be at a kink or at the end of a sphere
    measured, least = np.array([scatter(f, r), scatter(f, r * 0.997)]).min(axis=0)
    noise = np.nan_to_num(np.maximum(measured, least), nan=0.0)
    values = f(np.concatenate([[0.0], r]))
    unit = np.nanmax(least / np.abs(values[1:]), initial=EPS)
    cancels = noise > 64.0 * unit * np.abs(values[1:] - values[0])
    inward = np.maximum.accumulate(np.where(cancels, noise, 0.0)[::-1])[::-1]
    noise = np.maximum(noise, inward)

    def at(x: FloatArray) -> FloatArray:
        after = np.clip(np.searchsorted(r, x), 1, r.size - 1)
        return np.asarray(np.maximum(noise[after], noise[after - 1]))

    return at


def _panels(low: float, high: float, breakpoints: Sequence[float]) -> tuple[FloatArray, FloatArray]:
    """Ends of panels: of several lengths around irregular radii, and adjacent ones."""
    octaves = math.log2(high / low)
    count = int(min(max(_AN_OCTAVE * octaves, _LEAST), _MOST))
    centres = low * (high / low) ** ((np.arange(count) + jitter(count, 0.5)) / count)
    half = 0.5 * centres[:, None] * np.minimum(_LENGTHS, 0.8 * math.log(high / low))
    start = np.concatenate([(centres[:, None] - half).ravel(), centres[:-1]])
    end = np.concatenate([(centres[:, None] + half).ravel(), centres[1:]])
    start, end = np.maximum(start, low), np.minimum(end, high)
    for b in sorted(breakpoints):
        # at a breakpoint each callable may give either side
        margin = 8.0 * EPS * b
        crossing = (start < b + margin) & (end > b - margin)
        before, after = start[crossing], end[crossing]
        start = np.concatenate([start[~crossing], before, np.full(after.shape, b + margin)])
        end = np.concatenate([end[~crossing], np.full(before.shape, b - margin), after])
    long = end - start > 1e-9 * end
    return start[long], end[long]


def _stairs(values: FloatArray) -> float:
    """Twice the range of a callable with a few even levels; 0 for others, inf for a constant."""
    levels = np.unique(values[np.isfinite(values)])
    if levels.size == 1:
        return math.inf
    even = levels.size < _FEW_LEVELS and np.min(np.diff(levels)) * 2.0 * levels.size > np.ptp(levels)
    return 2.0 * float(np.ptp(levels)) if even else 0.0


@lru_cache(maxsize=1)
def _rules() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Nodes in [0, 1] and weights of Clenshaw and Curtis, for all nodes and for every other node."""

    def rule(count: int) -> tuple[FloatArray, FloatArray]:
        z = -np.cos(np.pi * np.arange(count) / (count - 1))
        z[0], z[-1] = -1.0, 1.0
        orders = np.arange(count)
        moments = np.where(orders % 2 == 0, 2.0 / (1.0 - orders**2.0 + (orders == 1)), 0.0)
        weights = np.linalg.solve(chebyshev.chebvander(z, count - 1).T, moments) / 2.0
        return (z + 1.0) / 2.0, np.asarray(weights, dtype=np.float64)

    t, fine = rule(_NODES)
    return t, fine, rule((_NODES + 1) // 2)[1]


def _compared(
    f: Curve, derivative: Curve, noise: Curve, start: FloatArray, end: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Differences of f, integrals of the derivative, their allowed difference, and the error of the integrals."""
    width = end - start
    t, fine, coarse = _rules()
    # the rules include the ends, so no jump can hide behind the last node
    slopes = derivative(np.minimum(start[:, None] + width[:, None] * t, end[:, None]).ravel()).reshape(
        width.size, -1
    )
    integral = width * (slopes @ fine)
    spread = np.abs(integral - width * (slopes[:, ::2] @ coarse))
    size = width * (np.abs(slopes) @ fine)
    ends = f(np.concatenate([start, end])).reshape(2, -1)
    rounded = np.maximum(noise(end), EPS * np.max(np.abs(ends), axis=0))
    # radii are rounded too, and slopes, on panels so short
    sure = _ROUNDINGS * rounded + (_RELATIVE + 8.0 * EPS * end / width) * size + _UNDERFLOW
    return ends[1] - ends[0], integral, sure, spread
