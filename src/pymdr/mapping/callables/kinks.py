"""Undeclared kinks: where panels do not converge, kinks are detected and located."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev

from pymdr.errors import ProblemError
from pymdr.mapping.callables.branches import SIDE_DEGREE, Model
from pymdr.mapping.callables.noise import EPS, Curve, orthonormal, scatter
from pymdr.mapping.callables.steps import step_refused
from pymdr.units import FloatArray, metres

MOST_KINKS = 32
_NODES, _CHECKS = 16, 24
_LEVELS = 4
_SPLITS = (0.4837, 0.5391, 0.4289)
"""Where panels are divided: at unusual places, and at several, because a kink may be at an edge."""
_MOST_PANELS = 1024
_DEEPEST = 24
_SHARP = 1e-8
"""Relative length of a feature that counts as a kink."""
_ZERO_DISTANCE = 1e-6
"""Relative distance from a kink at which a curve is compared with 0."""
_NAMED = 1e-3
"""Largest relative distance between a breakpoint and its kink."""
_SAME = 64.0 * EPS
"""Relative distance from a breakpoint up to which a kink is the same."""
_WIDEST = 24.0
"""Length of the interval on each side of a kink, over the length of its panel."""
_SIDE_POINTS, _INSIDE_POINTS = 40, 48
_FREE_ORDERS = (0.5, 1.5, 2.5)


@dataclass(frozen=True)
class _Interval:
    """An unresolved interval, and the ends of the resolved intervals on both sides."""

    low: float
    high: float
    free_low: float
    free_high: float


def find_kinks(
    curve: Curve, low: float, high: float, noise: float | None = None, of: str = "slope"
) -> list[float]:
    """
    Radii of the kinks of a profile on an interval on which polynomial panels do not converge.

    The interval is divided until the unresolved panels are short. In each of them a jump is located to neighbouring
    floats; a kink, or a jump of a higher or fractional derivative, is where the polynomials from both sides separate,
    refined by least squares over both sides.

    Parameters
    ----------
    curve : callable
        f' with ``of="slope"``, f with ``of="value"``; taking and giving arrays.
    low, high : float
        Ends of the interval in m; singularities at the ends are not included.
    noise : float, optional
        Standard deviation of the rounding of the curve; measured if not given.
    of : {"slope", "value"}
        What the curve is. A jump of f itself is refused.

    Returns
    -------
    list of float
        Rising radii in m, at most 32: the last floats before a jump; empty if short panels resolve the curve.

    Raises
    ------
    ProblemError
        If f jumps, there are more than 32 kinks, or one cannot be located.

    Examples
    --------
    >>> find_kinks(lambda r: np.where(r > 0.3, 1.0, 0.1), 0.25, 0.35)
    [0.3]
    """
    if noise is None:
        with np.errstate(all="ignore"):
            measured = scatter(curve, np.linspace(low, high, 9)[1:], stairs=of == "value")
        noise = float(np.nanmax(np.maximum(*measured)))
    # the map needs no more absolute precision where a curve is close to 0
    size = float(np.max(np.abs(curve(np.linspace(low, high, 257)))))
    noise = max(noise, EPS * size) if math.isfinite(size) else noise
    kinks: list[float] = []
    gaps = [(low, high)]
    while gaps:
        start, end = gaps.pop()
        more = _searched(curve, start, end, noise, of)
        kinks += more
        if len(kinks) > MOST_KINKS:
            raise _too_many(_Interval(min(kinks), max(kinks), low, high), of)
        # a strong kink may hide a weak one next to it
        marks = [start, *more, end]
        gaps += [
            (float(np.nextafter(one, math.inf)), other)
            for one, other in pairwise(marks)
            if more and other - one > 256.0 * EPS * other
        ]
    kinks.sort()
    return [_onset(curve, radius, before) for before, radius in pairwise([low, *kinks])]


def polished(
    curve: Curve, breakpoints: Sequence[float], max_radius: float, start: float = 0.0, stop: float = math.inf
) -> tuple[float, ...]:
    """
    Breakpoints, each moved to the kink next to it if there is one.

    Parameters
    ----------
    curve : callable
        F' or f, taking and giving arrays.
    breakpoints : sequence of float
        Rising radii in m.
    max_radius : float
        Largest radius in m.
    start, stop : float
        Radii in m between which breakpoints are checked.

    Returns
    -------
    tuple of float
        Rising radii in m. A breakpoint without a simple kink stays; other kinks next to it are added.

    Examples
    --------
    >>> polished(lambda r: np.where(r > 0.3, 1.0, 0.1), [0.3 - 1e-7], 1.0)
    (0.3,)
    """
    answer: list[float] = []
    marks = [0.0, *breakpoints, 2.0 * max_radius]
    for before, b, after in zip(marks, marks[1:], marks[2:], strict=False):
        if not start < b <= stop:
            answer.append(b)
            continue
        low, high = (
            max(b * (1.0 - _NAMED), 0.5 * (before + b)),
            min(b * (1.0 + _NAMED), 0.5 * (b + after), max_radius),
        )
        try:
            with np.errstate(all="ignore"):
                noise = float(np.max(scatter(curve, np.array([low]), stairs=False)))
            located = (
                [] if _smooth_between(curve, [low, b, high], noise) else find_kinks(curve, low, high, noise)
            )
            # the declared one may be one of several
            others = sorted(located, key=lambda kink: abs(kink - b))[1:]
            for kinks in (sorted([b, *others]), located):
                if located and _smooth_between(curve, [low, *kinks, high], noise):
                    answer += kinks
                    break
            else:
                # next to a kink of fractional order the curve is not smooth either: panels end at both, unless the side
                # of the breakpoint on which the located one lies is smooth, so that only rounding sets it apart
                rounded = [
                    (kink < b and _smooth_between(curve, [low, b], noise))
                    or (kink > b and _smooth_between(curve, [b, high], noise))
                    for kink in located
                ]
                answer += [b]
                answer += [
                    kink
                    for kink, same in zip(located, rounded, strict=True)
                    if not same and abs(kink - b) > _SAME * b
                ]
        except ProblemError:
            # not defined there, or not only kinks
            answer.append(b)
    return tuple(sorted(set(answer)))


def _smooth_between(curve: Curve, marks: list[float], noise: float) -> bool:
    """Whether a curve is smooth between radii, a few roundings from them."""
    inner = 8.0 * EPS * np.array(marks)
    low, high = np.array(marks[:-1]) + inner[:-1], np.array(marks[1:]) - inner[1:]
    wide = high > low
    return not (wide.any() and _unresolved(curve, low[wide], high[wide], noise).any())


def _onset(curve: Curve, radius: float, before: float) -> float:
    """The last float at which a curve that is 0 before a radius is 0; the radius itself for other curves."""
    low, high = radius * (1.0 - _ZERO_DISTANCE), radius * (1.0 + _ZERO_DISTANCE)
    if (
        low <= before
        or np.any(curve(radius * (1.0 - _ZERO_DISTANCE * np.array([1.0, 2.0, 4.0]))) != 0.0)
        or curve(np.array([high]))[0] == 0.0
    ):
        return radius
    while np.nextafter(low, math.inf) < high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if curve(np.array([middle]))[0] == 0.0 else (low, middle)
    return low


def _searched(curve: Curve, low: float, high: float, noise: float, of: str) -> list[float]:
    """Kinks inside an interval, rising; of kinks that hide each other only the strongest."""
    located: list[float] = []
    todo = [(_Interval(low, high, low, high), _LEVELS, 0)]
    while todo:
        place, levels, depth = todo.pop()
        clusters = _clusters(curve, place, noise, levels)
        length = place.high - place.low
        sharp = length <= _SHARP * place.high and low < place.low < place.high < high
        if not clusters and depth > 0 and sharp:
            located.append(0.5 * (place.low + place.high))
        elif not clusters and depth > 0:
            located += _faint(curve, place, noise)
        for cluster in clusters:
            if len(located) + len(todo) > 2 * MOST_KINKS:
                raise _too_many(cluster, of)
            kink = _located(curve, cluster, noise, depth > 0)
            width = cluster.high - cluster.low
            if kink is not None:
                if kink[1] == 0.0 and of == "value":
                    before, after = curve(np.array([kink[0], np.nextafter(kink[0], math.inf)]))
                    raise step_refused(kink[0], float(after - before))
                located.append(kink[0])
            elif width <= 64.0 * EPS * cluster.high:
                if low < cluster.low < cluster.high < high:
                    located.append(0.5 * (cluster.low + cluster.high))
            elif depth >= _DEEPEST:
                raise _not_located(0.5 * (cluster.low + cluster.high))
            else:
                # more than one kink, or none
                todo.append((cluster, levels + 3 if width > 0.3 * length else _LEVELS, depth + 1))
    distinct: list[float] = []
    for radius in sorted(located):
        if low < radius < high and (not distinct or radius - distinct[-1] > 64.0 * EPS * radius):
            distinct.append(radius)
    return distinct


def _faint(curve: Curve, place: _Interval, noise: float) -> list[float]:
    """Kinks so close to the rounding that only long panels show them."""
    for levels in (2, 1):
        located = [_located(curve, part, noise, False) for part in _clusters(curve, place, noise, levels)]
        radii = [kink[0] for kink in located if kink is not None and kink[1] > 0.0]
        if radii:
            return radii
    return []


def _not_located(radius: float) -> ProblemError:
    return ProblemError(
        f"the profile has a kink near r = {metres(radius)} that cannot be located exactly: declare it, "
        f"Function(..., breakpoints=[{radius:.6g}])"
    )


def _too_many(place: _Interval, of: str) -> ProblemError:
    """The error for a profile with too many kinks."""
    subject = "the slope of the profile" if of == "slope" else "the profile"
    return ProblemError(
        f"{subject} is not smooth at more than {MOST_KINKS} radii between {metres(place.free_low)} and "
        f"{metres(place.free_high)}, one of them near r = {metres(place.low)}: declare the kinks, "
        f"Function(..., breakpoints=[{place.low:.6g}, ...]), or smooth the noise"
    )


@lru_cache(maxsize=1)
def _check() -> tuple[FloatArray, FloatArray]:
    """Points in [0, 1], the nodes first, and the matrix from values at the nodes to values at the other points."""
    angles = np.pi * (np.arange(_NODES) + 0.5) / _NODES
    nodes = (1.0 - np.cos(angles)) / 2.0
    # the ends too: a jump may hide behind the last node
    inside = (np.arange(_CHECKS) + np.random.default_rng(4).random(_CHECKS)) / _CHECKS
    others = np.concatenate([[0.0], inside, [1.0]])
    fit = np.linalg.inv(chebyshev.chebvander(2.0 * nodes - 1.0, _NODES - 1))
    matrix = chebyshev.chebvander(2.0 * others - 1.0, _NODES - 1) @ fit
    return np.concatenate([nodes, others]), matrix


def _unresolved(curve: Curve, low: FloatArray, high: FloatArray, noise: float) -> FloatArray:
    """Mask of the panels that a polynomial of degree 15 does not fit within the rounding of the curve and of the radii."""
    t, matrix = _check()
    width = high - low
    r = np.minimum(low[:, None] + width[:, None] * t, high[:, None])
    values = curve(r.ravel()).reshape(r.shape)
    if not np.all(np.isfinite(values)):
        bad = float(r[~np.isfinite(values)][0])
        raise ProblemError(
            f"the profile is not defined at r = {metres(bad)}: declare its last radius, Function(..., max_radius=...)"
        )
    shifted = values - values[:, :1]
    rest = np.abs(shifted[:, _NODES:] - shifted[:, :_NODES] @ matrix.T)
    return np.asarray(np.max(rest, axis=1) > _tolerance(values, width, r[:, -1], noise))


def _tolerance(values: FloatArray, width: FloatArray, radius: FloatArray, noise: float) -> FloatArray:
    """Largest residual on panels from the rounding of values and radii, shape (panels,)."""
    rise = np.ptp(values, axis=1)
    size = np.max(np.abs(values), axis=1)
    return np.asarray(10.0 * noise + 2.0 * EPS * size + 8.0 * EPS * radius * rise / width)


def _clusters(curve: Curve, place: _Interval, noise: float, levels: int) -> list[_Interval]:
    """Short unresolved intervals, rising, with the resolved intervals between them."""
    intervals: list[tuple[float, float]] = []
    for split in _SPLITS:
        low, high = np.array([place.low]), np.array([place.high])
        for _ in range(levels):
            middle = low + split * (high - low)
            low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
            wide = high > np.nextafter(low, math.inf)
            low, high = low[wide], high[wide]
            keep = _unresolved(curve, low, high, noise) if low.size else np.zeros(0, dtype=bool)
            low, high = low[keep], high[keep]
            if low.size > _MOST_PANELS:
                raise _too_many(place, "slope")
        intervals += zip(low.tolist(), high.tolist(), strict=True)
    merged: list[list[float]] = []
    for start, end in sorted(intervals):
        if merged and start <= merged[-1][1]:
            merged[-1][1] = max(merged[-1][1], end)
        else:
            merged.append([start, end])
    starts = [place.free_low, *(end for _, end in merged)]
    ends = [*(start for start, _ in merged), place.free_high]
    return [
        _Interval(start, end, free_low, free_high)
        for (start, end), free_low, free_high in zip(merged, starts[:-1], ends[1:], strict=True)
    ]


@dataclass(frozen=True)
class _Side:
    """A polynomial from one side of a kink: its Chebyshev coefficients over [low, high]."""

    low: float
    high: float
    coefficients: FloatArray

    def at(self, r: FloatArray) -> FloatArray:
        """Its values, extrapolated outside [low, high]."""
        z = 2.0 * (r - self.low) / (self.high - self.low) - 1.0
        return np.asarray(chebyshev.chebval(z, self.coefficients))


@lru_cache(maxsize=1)
def _side_fit() -> tuple[FloatArray, FloatArray, FloatArray]:
    angles = np.pi * (np.arange(_SIDE_POINTS) + np.random.default_rng(5).random(_SIDE_POINTS)) / _SIDE_POINTS
    t = (1.0 - np.cos(angles)) / 2.0
    q, triangle = orthonormal(np.asfortranarray(chebyshev.chebvander(2.0 * t - 1.0, SIDE_DEGREE)))
    return t, q, np.asarray(np.linalg.inv(triangle))


def _side(curve: Curve, start: float, extent: float, width: float, noise: float) -> _Side | None:
    """The polynomial on the longest interval from `start` that it fits; toward smaller r if `extent` is negative."""
    t, q, inverse = _side_fit()
    length = math.copysign(min(abs(extent), _WIDEST * width), extent)
    for _ in range(6):
        if abs(length) < 0.7 * width:
            return None
        low, high = min(start, start + length), max(start, start + length)
        r = low + (high - low) * t
        values = curve(r)
        level = float(np.mean(values))
        parts = q.T @ (values - level)
        rest = values - level - q @ parts
        tolerance = _tolerance(values[None], np.array([high - low]), np.array([high]), noise)[0]
        if np.max(np.abs(rest)) <= 0.5 * tolerance:
            coefficients = inverse @ parts
            coefficients[0] += level
            return _Side(low, high, coefficients)
        length /= 2.0
    return None


def _located(curve: Curve, place: _Interval, noise: float, free: bool) -> tuple[float, float] | None:
    """Radius and order of the only singularity in a short interval; None for more complex intervals."""
    width = place.high - place.low
    left = _side(curve, place.low, place.free_low - place.low, width, noise)
    right = _side(curve, place.high, place.free_high - place.high, width, noise)
    if left is None or right is None:
        return None
    jump = _jump(curve, place, left, right, noise)
    if jump is not None:
        return jump, 0.0
    best: tuple[float, float] | None = None
    for model in _models(curve, place, left, right, noise):
        if model.free and (best is not None or not free):
            break
        if best is not None and model.order <= best[1]:
            continue
        solution = model.solved()
        if solution is not None:
            best = solution[:2]
            if not solution[2]:
                break
    return best


def _jump(curve: Curve, place: _Interval, left: _Side, right: _Side, noise: float) -> float | None:
    """The last float before a jump, if each point of the interval is on one of the two sides."""
    low, high = place.low, place.high
    r = np.linspace(low, high, _INSIDE_POINTS)
    while True:
        r = np.unique(r)
        values = curve(r)
        before, after = np.abs(values - left.at(r)), np.abs(values - right.at(r))
        size = np.abs(left.at(r) - right.at(r))
        tolerance = _tolerance(
            values[None], np.array([max(high - low, EPS * high)]), np.array([high]), noise
        )[0]
        # extrapolations may be imprecise, but must distinguish the sides
        nearest = np.minimum(before, after)
        if np.any(
            nearest
            > np.maximum(
                8.0 * tolerance - 8.0 * EPS * high * np.ptp(values) / max(high - low, EPS * high), 1e-6 * size
            )
        ) or np.any(size < 64.0 * (12.0 * noise + 16.0 * EPS * np.max(np.abs(values)))):
            return None
        passed = after < before
        first = int(np.argmax(passed)) if passed.any() else r.size - 1
        if not passed[first:].all() or first == 0:
            return None
        low, high = float(r[first - 1]), float(r[first])
        if high <= np.nextafter(low, math.inf):
            return low
        r = low + (high - low) * np.linspace(0.0, 1.0, 17)


def _models(curve: Curve, place: _Interval, left: _Side, right: _Side, noise: float) -> Iterator[Model]:
    """Models of integer order, which start at a root of a derivative of the difference of the sides, and free ones."""
    inside = place.low + (place.high - place.low) * (
        (np.arange(_INSIDE_POINTS) + np.random.default_rng(6).random(_INSIDE_POINTS)) / _INSIDE_POINTS
    )
    t, _, _ = _side_fit()
    r = np.concatenate(
        [left.low + (left.high - left.low) * t, inside, right.low + (right.high - right.low) * t]
    )
    values = curve(r)
    tolerance = float(_tolerance(values[None], np.array([r[-1] - r[0]]), np.array([r[-1]]), noise)[0])
    width, ends = place.high - place.low, (place.low, place.high)
    x = np.linspace(place.low, place.high, 257)
    between = right.at(x) - left.at(x)
    for order in (1, 2, 3):
        # the sides are long, so their difference is smooth over the panel between them
        series = chebyshev.chebfit(np.linspace(-1.0, 1.0, 257), between, 5)
        roots = chebyshev.chebroots(chebyshev.chebder(series, order - 1)) if order < 6 else np.zeros(0)
        real = np.sort(roots.real[(np.abs(roots.imag) < 0.3) & (np.abs(roots.real) < 1.3)])
        for root in real:
            start = 0.5 * (place.low + place.high) + 0.5 * width * float(root)
            yield Model(curve, r, values, tolerance, ends, start, float(order), False, False)
    for mirrored in (False, True):
        for order_ in _FREE_ORDERS:
            for part in (0.3, 0.7):
                start = place.low + part * width
                yield Model(curve, r, values, tolerance, ends, start, order_, True, mirrored)
