"""The integrals over a cohesive zone a < x < c and the roots of the gap condition, with error estimates.

With x = c cos ψ, ψ0 = arccos(a/c) and δ = c - a, partial integration turns every integral over the zone into
one of g' with a positive weight, so nothing cancels however thin the zone is:

    J0 = int_0^ψ0 g' cos ψ dψ
    J1 = int_a^c g' arccos(x/c) dx                      = int_a^c (g - g(a)) / sqrt(c² - x²) dx
    J2 = ½ c² int_a^c g' (ψ - sin ψ cos ψ) dx           = int_a^c (g - g(a)) sqrt(c² - x²) dx

The gap at the outer end c of the zone is (2/π) H with H = J1 + 2k (sqrt(c² - a²) ψ0 - δ), k = σ0/E*.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ConvergenceError
from pymdr.line.adhesion.equivalent_line import inner_knots
from pymdr.line.adhesion.zone_panels import panel_integrals, segment, zone_root
from pymdr.mapping.equivalent import EquivalentProfile, PowerLine
from pymdr.mapping.equivalent.panels import PanelLine
from pymdr.numerics.panels import Place, Position
from pymdr.units import FloatArray, metres

_Index = NDArray[np.intp]

_TOLERANCE = 3e-13
_NOISE = 1e-11
_LEVELS = 8
_STEP = 2.0**0.25
"""Ratio of radii by which a search goes where nothing is known yet."""
_LARGEST = 1e30
_NARROW = 8.0 * float(np.finfo(float).eps)
"""Width of a zone, in parts of its inner radius, up to which g' is constant over it."""
_FEW = 4
"""Breakpoints at which a rough quadrature splits a zone, at least."""
_MANY, _EACH = 100, 8
"""Number of zones beyond which every eighth width is solved first, and the others start from these."""
_SETTLED = 1e-7
"""Relative step at which the search for a width ends."""
_SMALL = 0.8
"""Angle below which closed forms would cancel and their series, of so many terms, are summed."""
_TERMS = np.arange(1.0, 13.0)
_ODD = np.cumprod(-1.0 / ((2.0 * _TERMS) * (2.0 * _TERMS + 1.0)))
"""(-1)^k / (2 k + 1)!"""
_FIRST = -2.0 * _TERMS * _ODD
"""Of sin y - y cos y in y^(2 k + 1)."""
_CLOSED = {1.0: _FIRST + _ODD * (9.0**_TERMS - 1.0) / 4.0, 2.0: 0.125 * _FIRST + _ODD * 4.0**_TERMS / 16.0}
"""Of sin y - y cos y - sin³ y / 3, and of (sin y - y cos y) / 8 - (2 y - sin 2 y) / 32, by the power of g."""


@cache
def _rule(level: int) -> tuple[FloatArray, FloatArray]:
    """Return nodes in (0, 1) and weights: Gauss-Legendre in u with t = u⁶ (7 - 6 u), at last tanh-sinh.

    The substitution makes any powers at the inner end smooth, also next to a tip, and half-integer ones at the
    outer end; tanh-sinh serves what is rougher.
    """
    if level < 4:
        x, w = np.polynomial.legendre.leggauss(20 * 2**level)
        u, rest = 0.5 * (1.0 + x), 0.5 * (1.0 - x)
        return u**6 * (1.0 + 6.0 * rest), 21.0 * w * u**5 * rest
    step = 0.08 / 2 ** (level - 4)
    u = step * np.arange(-np.floor(3.6 / step), np.floor(3.6 / step) + 1)
    # t = 1 / (1 + exp(-π sinh u)): accurate at the end t = 0, where the relative distance matters
    t = 1.0 / (1.0 + np.exp(-np.pi * np.sinh(u)))
    return t, step * np.pi * np.cosh(u) * t * (1.0 / (1.0 + np.exp(np.pi * np.sinh(u))))


class _Marks(NamedTuple):
    """Where the quadrature is split."""

    knots: tuple[float, ...]
    corners: FloatArray
    """Those at which g' is infinite."""


def _marks(line: EquivalentProfile) -> _Marks:
    knots = np.array(inner_knots(line))
    return _Marks(tuple(knots.tolist()), knots[np.isinf(line.slope(knots))])


def _integrals_at(
    line: EquivalentProfile,
    marks: _Marks,
    radius: FloatArray,
    width: FloatArray,
    level: int,
    *,
    third: bool,
    rough: bool = False,
) -> FloatArray:
    """Return J0, J1 [m] and J2 [m³] (0 unless `third`) of flat arrays of zones at one level of quadrature.

    `rough` splits a zone at few of many breakpoints, as a search for a bracket may.
    """
    t, weight = _rule(level)
    c = radius + width
    totals = np.zeros((3, radius.size))
    # panels from the contact outward, each by its inner end (x, sqrt(c² - x²))
    starts = [(radius, zone_root(radius, width))]
    first, last = (float(radius.min()), float(c.max())) if radius.size else (0.0, 0.0)
    knots, corners = marks
    if rough and len(knots) > _FEW and corners.size == 0:
        knots = knots[:: len(knots) // _FEW]
    for b in knots:
        if first < b < last:
            x = np.clip(b, radius, c)
            # exactly none for the zones that end before b: its root would cut 1e-8 off their last panel
            beyond = np.where(x < c, np.maximum((radius - x) + width, 0.0), 0.0)
            starts.append((x, np.where(x > radius, np.sqrt(beyond * (c + x)), starts[0][1])))
    starts.append((c, np.zeros_like(c)))
    corners = corners[corners < last]
    for (inner, root), (x_end, root_end) in pairwise(starts):
        at = np.flatnonzero(x_end > inner)
        if at.size == 0:
            continue
        start, rise = inner[at, None], root[at, None]
        inner_angle = np.arctan2(rise, start)
        span = inner_angle - np.arctan2(root_end, x_end)[at, None]
        step = span * t
        # a sum of positive terms: accurate next to a tip x = 0 and next to a breakpoint
        x = start * np.cos(step) + rise * np.sin(step)
        x = np.minimum(x, np.nextafter(x_end[at, None], 0.0))
        repair: FloatArray | float = 1.0
        if corners.size and corners[0] <= inner[at].max():
            x, repair = _beyond_corner(corners, start, rise, step, x)
        psi = inner_angle - step
        sine = np.sin(psi)
        slope = line.slope(x) * (span * weight) * repair
        totals[0, at] += np.sum(slope * x, axis=1) / c[at]
        totals[1, at] += np.sum(slope * psi * sine, axis=1) * c[at]
        if third:
            totals[2, at] += np.sum(slope * segment(psi) * sine, axis=1) * (0.5 * c[at] ** 3)
    return totals


def _beyond_corner(
    corners: FloatArray, start: FloatArray, rise: FloatArray, step: FloatArray, x: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return nodes x beyond corners b of f, where g' grows like 1/sqrt(x - b), and factors that undo rounding.

    x = start cos(step) + rise sin(step) loses the distance x - b; the factor sqrt((x - b)/distance) turns
    g' at the rounded node into g' at the true one.
    """
    index = np.searchsorted(corners, start, side="right") - 1
    corner = np.where(index >= 0, corners[np.maximum(index, 0)], -np.inf)
    distance = (start - corner) + (rise * np.sin(step) - 2.0 * start * np.sin(0.5 * step) ** 2)
    x = np.maximum(x, np.nextafter(corner, np.inf))
    with np.errstate(invalid="ignore"):
        factor = np.sqrt((x - corner) / distance)
    return x, np.where(np.isfinite(factor), factor, 1.0)


def zone_integrals(
    line: EquivalentProfile,
    radius: Position,
    width: FloatArray,
    *,
    third: bool = False,
    marks: _Marks | None = None,
    rough: bool = False,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return J0, J1 and J2 of the module's head, each to 3e-13 of itself (1e-11 beyond a corner of f).

    Parameters
    ----------
    line : EquivalentProfile
        The equivalent profile; every integral is split at its breakpoints.
    radius : ndarray or Place
        Contact radii a >= 0 [m], flat.
    width : ndarray
        Widths δ = c - a > 0 of the zones [m], of the same length.
    third : bool
        Whether J2 is computed; it is 0 otherwise.
    marks : optional
        The breakpoints, where they are known already.
    rough : bool
        Whether the first level of the quadrature is enough, as for a bracket.

    Returns
    -------
    tuple of ndarray
        J0 (dimensionless), J1 [m] and J2 [m³].

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> cone = SimpleNamespace(slope=np.ones_like, edge=np.inf, max_radius=np.inf, breakpoints=())
    >>> j0, j1, j2 = zone_integrals(cone, np.zeros(1), np.full(1, 2.0), third=True)
    >>> np.allclose([j0[0], j1[0], j2[0]], [1, 2, 8 / 3], rtol=1e-13)
    True
    """
    # next to a breakpoint the offset keeps the width
    inner = radius.offset if isinstance(radius, Place) else np.asarray(radius, dtype=float)
    narrow = width <= _NARROW * inner
    if narrow.any():
        result, at, rest = np.empty((3, width.size)), np.flatnonzero(narrow), np.flatnonzero(~narrow)
        result[:, at] = _narrow_integrals(line, _taken(radius, at), width[at])
        if rest.size:
            wide = _taken(radius, rest), width[rest]
            result[:, rest] = zone_integrals(line, *wide, third=third, marks=marks, rough=rough)
        return result[0], result[1], result[2]
    if isinstance(line, PanelLine):
        j0, j1, j2 = panel_integrals(line, radius, width, third=third)
        return j0, j1, j2
    radius = np.asarray(radius, dtype=float)
    if isinstance(line, PowerLine) and line.n in _CLOSED:
        return _closed_integrals(line, radius, width, third)
    marks = marks or _marks(line)
    result = _integrals_at(line, marks, radius, width, 0, third=third, rough=rough)
    if rough:
        return result[0], result[1], result[2]
    left, before = np.arange(radius.size), np.full(radius.size, np.inf)
    for level in range(1, _LEVELS):
        fine = _integrals_at(line, marks, radius[left], width[left], level, third=third)
        with np.errstate(divide="ignore", invalid="ignore"):
            change = np.abs(fine - result[:, left]) / np.abs(fine)
        error = np.max(np.where(fine == result[:, left], 0.0, change), axis=0)
        # rounding of a slope that is infinite at a corner ends the convergence: keep the better values
        stuck = (before <= _NOISE) & (error >= 0.5 * before)
        result[:, left] = np.where(stuck, result[:, left], fine)
        wanting = ~(stuck | (error <= _TOLERANCE))
        left, before = left[wanting], error[wanting]
        if left.size == 0:
            return result[0], result[1], result[2]
    worst = int(left[0])
    raise ConvergenceError(
        f"the integrals over the cohesive zone from {metres(radius[worst])} to "
        f"{metres(radius[worst] + width[worst])} did not converge; declare the kinks of the profile as breakpoints"
    )


def _closed_integrals(
    line: PowerLine, radius: FloatArray, width: FloatArray, third: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """J0, J1 and J2 of a cone (n = 1) and a paraboloid (n = 2), whose integrands are products of sines and cosines."""
    c = radius + width
    angle, slope = np.arctan2(zone_root(radius, width), radius), line.slope(c)
    y, sine = line.n * angle, np.sin(line.n * angle)
    first = _odd_series(y, sine - y * np.cos(y), _FIRST)
    cone = line.n == 1.0
    j0, j1 = (sine, first) if cone else (0.5 * angle + 0.25 * sine, 0.125 * first)
    j2 = np.zeros_like(c)
    if third:
        less = sine**3 / 3.0 if cone else (2.0 * y - np.sin(2.0 * y)) / 32.0
        j2 = 0.5 * c**3 * _odd_series(y, j1 - less, _CLOSED[line.n])
    return slope * j0, slope * c * j1, slope * j2


def _odd_series(y: FloatArray, closed: FloatArray, coefficients: FloatArray) -> FloatArray:
    """Values of a closed form, by its series in odd powers of small y."""
    square = np.minimum(y, _SMALL) ** 2
    series = np.full_like(y, coefficients[-1])
    for one in coefficients[-2::-1]:
        series = one + square * series
    return np.where(y < _SMALL, y * square * series, closed)


def _narrow_integrals(line: EquivalentProfile, position: Position, width: FloatArray) -> FloatArray:
    """J0, J1 and J2 of zones so narrow that c rounds to a: g' is constant over them, and ψ0² = 2δ/a."""
    radius = np.asarray(position, dtype=float)
    angle = np.arctan2(zone_root(radius, width), radius)
    terms = [angle, radius * angle**3 / 3.0, radius**3 * angle**5 / 15.0]
    # g' may be infinite where the profile ends
    inside = position if isinstance(position, Place) else np.nextafter(radius, 0.0)
    return np.asarray(line.slope(inside) * np.stack(terms))


def _gap(
    line: EquivalentProfile,
    marks: _Marks,
    k: float,
    position: Position,
    width: FloatArray,
    outward: bool,
    rough: bool,
) -> tuple[FloatArray, FloatArray]:
    """Return H [m] and, dimensionless, dH/dc at constant a when `outward`, else -dH/da at constant c."""
    radius = np.asarray(position, dtype=float)
    j0, j1, _ = zone_integrals(line, position, width, marks=marks, rough=rough)
    c = radius + width
    root = zone_root(radius, width)
    angle = np.arctan2(root, radius)
    half = 0.5 * angle
    # sqrt(c² - a²) ψ - δ = 2 c sin(ψ/2) [ψ cos(ψ/2) - sin(ψ/2)]
    own = 2.0 * c * np.sin(half) * (angle * np.cos(half) - np.sin(half))
    rate = (
        j0 + 2.0 * k * (angle * c / root - width / c)
        if outward
        else angle * (line.slope(position) + 2.0 * k * radius / root)
    )
    return j1 + 2.0 * k * own, rate


def solve_width(
    line: EquivalentProfile,
    k: float,
    target: float,
    given: Position,
    upper: FloatArray,
    *,
    outward: bool,
    begin: float | None = None,
) -> FloatArray:
    """Return the widths δ of the zones whose gap condition holds, H = target.

    Parameters
    ----------
    k : float
        Cohesive stress over modulus, σ0/E*.
    target : float
        The value of H [m], π γ / (2 σ0).
    given : ndarray or Place
        The radii that are given [m]: a when `outward`, else c (an array). Flat.
    upper : ndarray
        Upper bounds of δ [m], of the same length; where H(upper) < target the bound itself is returned.
    outward : bool
        Whether c = a + δ is sought (else a = c - δ).
    begin : float, optional
        Width [m] from which the search goes; `upper` unless given. Beyond the first c it goes outward by quarter
        octaves, so that no profile is evaluated far outside its states.

    Returns
    -------
    ndarray
        δ [m] to a few rounding errors of itself.

    Notes
    -----
    H grows with δ at constant a and at constant c. Newton steps in (log δ, log H) inside a bracket at one
    level of the quadrature, then Newton steps with the error-controlled integrals.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> flat = SimpleNamespace(slope=np.zeros_like, edge=np.inf, max_radius=np.inf, breakpoints=())
    >>> width = solve_width(flat, 0.5, np.pi / 2 - 1, np.zeros(1), np.full(1, 9.0), outward=True)
    >>> round(float(width[0]), 13)
    1.0
    """
    marks = _Marks((), np.zeros(0)) if isinstance(line, PanelLine) else _marks(line)

    def residual(width: FloatArray, at: _Index, rough: bool) -> tuple[FloatArray, FloatArray]:
        radius = _taken(given, at) if outward else fixed[at] - width
        return _gap(line, marks, k, radius, width, outward, rough)

    fixed = np.asarray(given, dtype=float)
    start = np.minimum(upper, _LARGEST if begin is None else begin)
    if begin is not None and fixed.size > _MANY:
        order = np.argsort(fixed)
        some = np.append(order[:-1:_EACH], order[-1])
        known = solve_width(line, k, target, _taken(given, some), upper[some], outward=outward, begin=begin)
        start = np.minimum(upper, np.interp(fixed, fixed[some], known))
    front = np.full(upper.shape, np.inf) if begin is None else fixed + start
    width = _bracketed(lambda x, at: residual(x, at, True), target, start, upper, fixed, front)
    left = np.flatnonzero(width < upper)
    before = np.full(left.size, np.inf)
    for _ in range(30):
        if left.size == 0:
            return width
        value, rate = residual(width[left], left, False)
        # no zone under a flat end
        step = np.divide(target - value, rate, where=rate > 0.0, out=width[left].copy())
        width[left] = np.clip(width[left] + step, 0.25 * width[left], upper[left])
        error = np.abs(step) / width[left]
        # the noise of the width is that of both gaps over the fraction of the gap from the zone
        settled = (error <= 2e-14) | ((before <= 4.0 * _NOISE) & (error >= 0.5 * before))
        left, before = left[~settled], error[~settled]
    raise ConvergenceError(
        f"the width of the cohesive zone did not converge (last value {metres(width[left[0]])} "
        f"at {metres(fixed[left[0]])}); declare the kinks of the profile as breakpoints"
    )


def _taken(position: Position, at: _Index) -> Position:
    return position.take(at) if isinstance(position, Place) else np.asarray(position, dtype=float)[at]


def _bracketed(
    residual: Callable[[FloatArray, _Index], tuple[FloatArray, FloatArray]],
    target: float,
    start: FloatArray,
    upper: FloatArray,
    fixed: FloatArray,
    front: FloatArray,
) -> FloatArray:
    """Return roots x in (0, upper] of an increasing residual(x, index) = target, to 1e-7 or better.

    The search begins at `start`; beyond `front`, fixed + x grows by quarter octaves only.
    """
    x, low, high = start.copy(), np.zeros_like(upper), np.full(upper.shape, np.inf)
    left = np.arange(upper.size)
    for turn in range(600):
        if left.size == 0:
            return x
        here = x[left]
        value, rate = residual(here, left)
        above = value >= target
        high[left[above]], low[left[~above]] = here[above], here[~above]
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            new = here * np.exp(np.log(target / value) * value / (here * rate))
        lo, hi = low[left], high[left]
        settled = np.abs(new - here) <= _SETTLED * here
        outside = ~((new > lo) & (new < hi))
        # the rate of a rough residual is inexact, so every fourth step bisects
        outside |= (turn % 4 == 3) & (lo > 0.0) & np.isfinite(hi)
        with np.errstate(invalid="ignore"):
            middle = np.where(lo > 0.0, np.where(np.isfinite(hi), np.sqrt(lo * hi), 2.0 * lo), hi / 64.0)
        # a step of rounding size may end on the bracket
        outside &= ~settled
        new[outside] = middle[outside]
        step = np.maximum(front[left], _STEP * (fixed[left] + here)) - fixed[left]
        new = np.minimum(new, np.minimum(step, upper[left]))
        beyond = ~above & (here >= upper[left])
        x[left] = new
        open_ = np.isinf(hi) | (hi - lo > 1e-9 * hi)
        left = left[(np.abs(new - here) > _SETTLED * here) & ~beyond & open_]
    raise ConvergenceError(
        f"the gap at the edge of the cohesive zone does not reach its range (last width "
        f"{metres(x[left[0]])}); declare the kinks of the profile as breakpoints"
    )
