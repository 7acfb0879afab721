"""Kinks that nobody named: where panels do not converge, they are found and located."""

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
"""Where panels are divided: at no place that people choose, and in more than one way, since a kink may lie by an edge."""
_MOST_PANELS = 1024
_DEEPEST = 24
_SHARP = 1e-8
"""Relative length of what is a kink to any panel, even if a closer look would resolve it."""
_BESIDE = 1e-6
"""How far from a kink, in parts of its radius, a curve is told from 0."""
_NAMED = 1e-3
"""How far from a breakpoint, in parts of it, a kink may lie that is meant by it."""
_SAME = 64.0 * EPS
"""How far from a breakpoint, in parts of it, a kink may lie that is none beside it."""
_WIDEST = 24.0
"""Length of the stretch on each side of a kink, in lengths of the panel that holds it."""
_SIDE_POINTS, _INSIDE_POINTS = 40, 48
_FREE_ORDERS = (0.5, 1.5, 2.5)


@dataclass(frozen=True)
class _Interval:
    """An unresolved stretch, and how far on both sides the curve is resolved."""

    low: float
    high: float
    free_low: float
    free_high: float


def find_kinks(
    curve: Curve, low: float, high: float, noise: float | None = None, of: str = "slope"
) -> list[float]:
    """
    Radii of the kinks of a profile on an interval on which polynomial panels do not converge.

    The interval is divided until the panels that stay unresolved are short. In each of them a jump is followed to
    the neighbouring floats; a kink, or a jump of a higher or fractional derivative, is where the polynomials from
    both sides part, polished by least squares over both stretches.

    Parameters
    ----------
    curve : callable
        f' with ``of="slope"``, f with ``of="value"``; taking and giving arrays.
    low, high : float
        Ends of the interval in m; singularities at the ends themselves are no kinks inside.
    noise : float, optional
        Standard deviation of the rounding of the curve; measured if not given.
    of : {"slope", "value"}
        What the curve is. A jump of f itself is refused.

    Returns
    -------
    list of float
        Rising radii in m, at most 32: the last floats at which a jump has not happened yet; empty where short panels
        resolve the curve.

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
    # where a curve all but vanishes it is no more exact for the map than elsewhere
    size = float(np.max(np.abs(curve(np.linspace(low, high, 257)))))
    noise = max(noise, EPS * size) if math.isfinite(size) else noise
    found: list[float] = []
    gaps = [(low, high)]
    while gaps:
        start, end = gaps.pop()
        more = _searched(curve, start, end, noise, of)
        found += more
        if len(found) > MOST_KINKS:
            raise _too_many(_Interval(min(found), max(found), low, high), of)
        # a strong kink may hide a weak one beside it
        marks = [start, *more, end]
        gaps += [
            (float(np.nextafter(one, math.inf)), other)
            for one, other in pairwise(marks)
            if more and other - one > 256.0 * EPS * other
        ]
    found.sort()
    return [_begun(curve, radius, before) for before, radius in pairwise([low, *found])]


def polished(
    curve: Curve, breakpoints: Sequence[float], reach: float, start: float = 0.0, stop: float = math.inf
) -> tuple[float, ...]:
    """
    Named breakpoints, and in place of those that the curve is not smooth beside, the kinks that are there.

    Parameters
    ----------
    curve : callable
        F' or f, taking and giving arrays.
    breakpoints : sequence of float
        Rising radii in m.
    reach : float
        Largest radius in m.
    start, stop : float
        Radii in m between which breakpoints are looked at.

    Returns
    -------
    tuple of float
        Rising radii in m. What is no simple kink is left where it was named, and others that are found beside it are added.

    Examples
    --------
    >>> polished(lambda r: np.where(r > 0.3, 1.0, 0.1), [0.3 - 1e-7], 1.0)
    (0.3,)
    """
    answer: list[float] = []
    marks = [0.0, *breakpoints, 2.0 * reach]
    for before, b, after in zip(marks, marks[1:], marks[2:], strict=False):
        if not start < b <= stop:
            answer.append(b)
            continue
        low, high = (
            max(b * (1.0 - _NAMED), 0.5 * (before + b)),
            min(b * (1.0 + _NAMED), 0.5 * (b + after), reach),
        )
        try:
            with np.errstate(all="ignore"):
                noise = float(np.max(scatter(curve, np.array([low]), stairs=False)))
            found = (
                [] if _smooth_between(curve, [low, b, high], noise) else find_kinks(curve, low, high, noise)
            )
            # the one that was named may be one of several
            others = sorted(found, key=lambda kink: abs(kink - b))[1:]
            for kinks in (sorted([b, *others]), found):
                if found and _smooth_between(curve, [low, *kinks, high], noise):
                    answer += kinks
                    break
            else:
                # beside a kink of a broken order the curve is not smooth either: panels end at both
                answer += [b, *(kink for kink in found if abs(kink - b) > _SAME * b)]
        except ProblemError:
            # where it is not defined, or is more than kinks
            answer.append(b)
    return tuple(sorted(set(answer)))


def _smooth_between(curve: Curve, marks: list[float], noise: float) -> bool:
    """Whether a curve is smooth between radii, a few roundings from them."""
    inner = 8.0 * EPS * np.array(marks)
    low, high = np.array(marks[:-1]) + inner[:-1], np.array(marks[1:]) - inner[1:]
    wide = high > low
    return not (wide.any() and _unresolved(curve, low[wide], high[wide], noise).any())


def _begun(curve: Curve, radius: float, before: float) -> float:
    """The last float at which a curve that is 0 before a radius is 0; the radius itself where it is not, or begins before."""
    low, high = radius * (1.0 - _BESIDE), radius * (1.0 + _BESIDE)
    if (
        low <= before
        or np.any(curve(radius * (1.0 - _BESIDE * np.array([1.0, 2.0, 4.0]))) != 0.0)
        or curve(np.array([high]))[0] == 0.0
    ):
        return radius
    while np.nextafter(low, math.inf) < high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if curve(np.array([middle]))[0] == 0.0 else (low, middle)
    return low


def _searched(curve: Curve, low: float, high: float, noise: float, of: str) -> list[float]:
    """Kinks inside an interval, rising; of those that hide each other only the strongest."""
    found: list[float] = []
    todo = [(_Interval(low, high, low, high), _LEVELS, 0)]
    while todo:
        place, levels, depth = todo.pop()
        clusters = _clusters(curve, place, noise, levels)
        length = place.high - place.low
        sharp = length <= _SHARP * place.high and low < place.low < place.high < high
        if not clusters and depth > 0 and sharp:
            found.append(0.5 * (place.low + place.high))
        elif not clusters and depth > 0:
            found += _faint(curve, place, noise)
        for cluster in clusters:
            if len(found) + len(todo) > 2 * MOST_KINKS:
                raise _too_many(cluster, of)
            kink = _located(curve, cluster, noise, depth > 0)
            width = cluster.high - cluster.low
            if kink is not None:
                if kink[1] == 0.0 and of == "value":
                    before, after = curve(np.array([kink[0], np.nextafter(kink[0], math.inf)]))
                    raise step_refused(kink[0], float(after - before))
                found.append(kink[0])
            elif width <= 64.0 * EPS * cluster.high:
                if low < cluster.low < cluster.high < high:
                    found.append(0.5 * (cluster.low + cluster.high))
            elif depth >= _DEEPEST:
                raise _lost(0.5 * (cluster.low + cluster.high))
            else:
                # all of it unresolved: there is more than one kink in it, or none
                todo.append((cluster, levels + 3 if width > 0.3 * length else _LEVELS, depth + 1))
    distinct: list[float] = []
    for radius in sorted(found):
        if low < radius < high and (not distinct or radius - distinct[-1] > 64.0 * EPS * radius):
            distinct.append(radius)
    return distinct


def _faint(curve: Curve, place: _Interval, noise: float) -> list[float]:
    """Kinks so close to the rounding that only panels no shorter than half of a stretch show them."""
    for levels in (2, 1):
        located = [_located(curve, part, noise, False) for part in _clusters(curve, place, noise, levels)]
        found = [kink[0] for kink in located if kink is not None and kink[1] > 0.0]
        if found:
            return found
    return []


def _lost(radius: float) -> ProblemError:
    return ProblemError(
        f"the profile is not smooth near r = {metres(radius)}, and the place cannot be told to the last digit: name the "
        f"kink as a breakpoint, Function(..., breakpoints=[{radius:.6g}])"
    )


def _too_many(place: _Interval, of: str) -> ProblemError:
    what = "the slope of the profile" if of == "slope" else "the profile"
    return ProblemError(
        f"{what} is not smooth at more than {MOST_KINKS} radii between {metres(place.free_low)} and "
        f"{metres(place.free_high)}, one a kink near r = {metres(place.low)}: name the kinks as breakpoints, "
        f"Function(..., breakpoints=[{place.low:.6g}, ...]), or smooth the noise"
    )


@lru_cache(maxsize=1)
def _check() -> tuple[FloatArray, FloatArray]:
    """Places in [0, 1], the nodes first, and the matrix from values at the nodes to those at the others."""
    angles = np.pi * (np.arange(_NODES) + 0.5) / _NODES
    nodes = (1.0 - np.cos(angles)) / 2.0
    # the ends too: a jump may hide behind the last node
    inside = (np.arange(_CHECKS) + np.random.default_rng(4).random(_CHECKS)) / _CHECKS
    others = np.concatenate([[0.0], inside, [1.0]])
    fit = np.linalg.inv(chebyshev.chebvander(2.0 * nodes - 1.0, _NODES - 1))
    matrix = chebyshev.chebvander(2.0 * others - 1.0, _NODES - 1) @ fit
    return np.concatenate([nodes, others]), matrix


def _unresolved(curve: Curve, low: FloatArray, high: FloatArray, noise: float) -> FloatArray:
    """Which panels a polynomial of degree 15 does not meet within the rounding of the curve and of the radii."""
    t, matrix = _check()
    width = high - low
    r = np.minimum(low[:, None] + width[:, None] * t, high[:, None])
    values = curve(r.ravel()).reshape(r.shape)
    if not np.all(np.isfinite(values)):
        bad = float(r[~np.isfinite(values)][0])
        raise ProblemError(
            f"the profile is not defined at r = {metres(bad)}: state how far it goes with Function(..., reach=...)"
        )
    shifted = values - values[:, :1]
    rest = np.abs(shifted[:, _NODES:] - shifted[:, :_NODES] @ matrix.T)
    return np.asarray(np.max(rest, axis=1) > _tolerance(values, width, r[:, -1], noise))


def _tolerance(values: FloatArray, width: FloatArray, radius: FloatArray, noise: float) -> FloatArray:
    """What rounding of values and radii may leave on panels, shape (panels,)."""
    rise = np.ptp(values, axis=1)
    size = np.max(np.abs(values), axis=1)
    return np.asarray(10.0 * noise + 2.0 * EPS * size + 8.0 * EPS * radius * rise / width)


def _clusters(curve: Curve, place: _Interval, noise: float, levels: int) -> list[_Interval]:
    """Short unresolved stretches, rising, with what is resolved between them."""
    pieces: list[tuple[float, float]] = []
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
        pieces += zip(low.tolist(), high.tolist(), strict=True)
    merged: list[list[float]] = []
    for start, end in sorted(pieces):
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
        """Its values, also beyond its stretch."""
        z = 2.0 * (r - self.low) / (self.high - self.low) - 1.0
        return np.asarray(chebyshev.chebval(z, self.coefficients))


@lru_cache(maxsize=1)
def _side_fit() -> tuple[FloatArray, FloatArray, FloatArray]:
    angles = np.pi * (np.arange(_SIDE_POINTS) + np.random.default_rng(5).random(_SIDE_POINTS)) / _SIDE_POINTS
    t = (1.0 - np.cos(angles)) / 2.0
    q, triangle = orthonormal(np.asfortranarray(chebyshev.chebvander(2.0 * t - 1.0, SIDE_DEGREE)))
    return t, q, np.asarray(np.linalg.inv(triangle))


def _side(curve: Curve, start: float, room: float, width: float, noise: float) -> _Side | None:
    """The polynomial on the longest stretch from `start` on that it resolves; towards smaller r if `room` is negative."""
    t, q, inverse = _side_fit()
    length = math.copysign(min(abs(room), _WIDEST * width), room)
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
    """Radius and order of the only singularity in a short stretch; None where the stretch is not that simple."""
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
        found = model.solved()
        if found is not None:
            best = found[:2]
            if not found[2]:
                break
    return best


def _jump(curve: Curve, place: _Interval, left: _Side, right: _Side, noise: float) -> float | None:
    """The last float before a jump, if each point of the stretch lies on one of the two sides."""
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
        # what is extrapolated may err, but must tell the sides apart
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
    """Models of whole order, whose start is a root of a derivative of the difference of the sides, and free ones."""
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
        # the stretches are long, so that the difference is a smooth curve over the panel between them
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
