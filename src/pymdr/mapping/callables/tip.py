"""The power law of a callable at its tip where its digits cancel: 1 - sqrt(1 - r^2), sqrt(R^2 + r^2) - R, ..."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

from pymdr.errors import ProblemError
from pymdr.mapping.callables.noise import EPS, Curve, jitter, orthonormal, scatter, search_points, slope_panel
from pymdr.units import FloatArray, metres

_SURE = 1e-10
"""Largest accepted relative error of f' computed from f alone."""
_SAFETY = 40.0
"""Roundings of f by which f' errs on a panel of a quarter octave, times its width."""
_UNUSABLE = 1e-4
_UNDERFLOW, _UNDERFLOW_SINGLE = 1e-290, 1e-31
_LOWEST, _HIGHEST = -980, 120
_POINTS, _TERMS, _OCTAVES = 900, 16, 9
_BLOCKS = 20
_SIZE = 16
_DEEPEST, _LAST, _DEPTH, _OUTWARD = 56.0, 1000.0, 24.0, (0.0, 6.0, 24.0)
"""Octaves searched for an underflow, the last one below 1 m, those above the first 0, and those above the requested radius."""
_FAINT = 0.3
"""Fraction of rounding to the power 1.5 times the values at the requested radii: smaller values that end in 0 are no differences."""
_FALLEN = 16.0
"""Ratio of the last value of a law to that of the callable above which the callable does not follow the law."""
_UNFELT = 1e-40
"""Fraction of the values farther out that is negligible."""
_CANCELLATION, _ROUNDINGS = 1e-13, 16.0
_STEADY = 1e-6
"""Largest change of an exponent from octave to octave of a power law."""
_SCATTERED = 12.0
"""Median deviations in an octave, eight standard deviations of noise, beyond which a deviation is a feature of the profile."""
_LEAST_DIFFERENCE = 0.1
"""Difference of two exponents below which a fit cannot separate them."""


@dataclass(frozen=True)
class TipLaw:
    """
    The law of f' below the radius down to which f resolves it.

    f' = (r / radius)^(exponent - 1) sum_j c_j T_j(2 (r / radius)^step - 1) for 0 < r <= radius.
    """

    radius: float
    """Radius in m below which the law replaces f: a power of 2^(1/4)."""
    exponent: float
    """Power of r with which f - f(0) starts."""
    coefficients: FloatArray
    """Chebyshev coefficients of f' / (r / radius)^(exponent - 1)."""
    error: float
    """Measured bound of its error relative to f'."""
    step: float = 1.0
    """Step of the powers in f; 1 for integer powers."""
    exponent_error: float = 0.0
    """Uncertainty of an exponent that is not a simple number; it makes a relative error of f' of this times ln(radius / r)."""

    def slope(self, r: ArrayLike) -> FloatArray:
        """Slope f' at radii up to `radius`."""
        t = np.asarray(r, dtype=float) / self.radius
        series = chebyshev.chebval(2.0 * t**self.step - 1.0, self.coefficients)
        with np.errstate(divide="ignore"):
            return np.asarray(t ** (self.exponent - 1.0) * series)

    def error_at(self, r: FloatArray) -> FloatArray:
        """
        Relative error of f' at radii up to `radius`.

        Further in, the error of an exponent that is not a simple number grows, and so does a hidden term with the next smaller
        integer power.
        """
        if self.exponent_error == 0.0:
            return np.full(np.shape(r), self.error)
        inward = self.radius / r
        fraction = self.exponent - math.floor(self.exponent)
        # close powers are hard to distinguish
        hidden = self.error * inward**fraction / max(fraction, _LEAST_DIFFERENCE) ** 2
        return np.asarray(hidden + self.exponent_error * np.log(inward))


def tip_law(f: Curve, top: float = math.inf) -> TipLaw | None:
    """
    The law that continues f' to the tip where f cancels, from the radii at which f does not cancel.

    f(r) = f(0) + r^n (a_0 + a_1 r^s + ...) is fitted by weighted least squares, with integer n before others and
    s = 2 before 1, on intervals of several octaves above the radius where 40 roundings of f exceed 1e-10 of f'.
    The residual must be rounding there and below, and the law must agree with the fit on another interval.

    Parameters
    ----------
    f : callable
        Taking and giving arrays, with its offset f(0) if it has one.
    top : float
        Radius in m up to which f is smooth: its first breakpoint or its last radius. The larger, the better.

    Returns
    -------
    TipLaw or None
        None if f is precise down to the tip.

    Raises
    ------
    ProblemError
        If f is noise at all radii, or is not a power of r at the tip.

    Examples
    --------
    >>> tip_law(lambda r: r**1.5) is None
    True
    >>> law = tip_law(lambda r: 1.0 - np.sqrt(1.0 - r * r))
    >>> law.exponent, bool(abs(law.slope(1e-9) - 1e-9) < 1e-21)
    (2.0, True)
    """
    with np.errstate(all="ignore"):
        return _continued(f, top)


def underflow_law(curve: Curve, top: float, end: float = math.inf, of: str = "value") -> TipLaw | None:
    """
    The power law of a callable below the radii at which its terms underflow, as r^20 does.

    Parameters
    ----------
    curve : callable
        f, or its slope.
    top : float
        Requested radius in m; larger ones are used where digits are lost close to it.
    end : float
        Radius in m up to which the callable is smooth.
    of : {"value", "slope"}
        Quantity of the callable.

    Returns
    -------
    TipLaw or None
        None unless its values vanish through an underflow.

    Examples
    --------
    >>> law = underflow_law(lambda r: 1e150 * r**20, 1e-9)
    >>> law.exponent, bool(abs(law.slope(1e-16) / 20e-154 - 1.0) < 1e-12)
    (20.0, True)
    """
    last = 0.25 * math.floor(4.0 * math.log2(end)) if math.isfinite(end) else math.inf
    highest = min(0.25 * math.floor(4.0 * math.log2(top)), last)
    with np.errstate(all="ignore"):
        far = curve(2.0 ** (highest - np.arange(0.0, min(_DEEPEST, highest + _LAST), 8.0)))
        if far.all():
            return None
        zero = highest - 8.0 * int(np.argmin(far != 0.0))
        for outward in _OUTWARD:
            begin = min(zero + _DEPTH + outward, highest + outward, last)
            r = 2.0 ** np.arange(begin, zero - 0.125, -0.25)
            values = np.abs(curve(r))
            deepest = int(np.max(np.flatnonzero(values), initial=0))
            measured, least = scatter(curve, r[: deepest + 1])
            nonzero = values[: deepest + 1]
            unit = float(np.nanmax((least / nonzero)[nonzero > _UNDERFLOW], initial=EPS))
            digits = max(_CANCELLATION, _ROUNDINGS * unit)
            sure = (np.maximum(measured, least) <= digits * nonzero) & (
                nonzero > (_UNDERFLOW if unit == EPS else _UNDERFLOW_SINGLE)
            )
            # one octave further out the values are precise
            first = int(np.argmin(np.append(sure, False))) - 4
            # two octaves show its power, and whether it stays
            if first >= 9:
                break
        if not 9 <= first < values.size or not 0.0 < values[deepest] < _FAINT * unit**1.5 * values[0]:
            return None
        power, before = np.log2(values[[first - 5, first - 9]] / values[[first - 1, first - 5]])
        faint = values[first - 1] < _UNFELT * np.max(np.abs(far))
        last_by_law = values[first - 1] * (r[deepest] / r[first - 1]) ** power
        # rounding to the smallest numbers changes the last value by a factor of 2; a kink below the sure radii by more
        if not faint and not last_by_law < _FALLEN * values[deepest]:
            return None
    if not abs(power - before) < max(_STEADY, digits):
        if not (faint and power > before):
            return None
        # it decreases ever faster, as exp(-1 / r): any law is good enough for negligible values
        unsure = 1.0
    else:
        unsure = digits + abs(power - before)
    simple = round(power * 60.0) / 60.0
    if abs(power - simple) < max(1e-9, digits):
        power, before = simple, simple
    rises = of == "value"
    slope = values[first - 1] * (power / r[first - 1] if rises else 1.0)
    return TipLaw(
        float(r[first - 1]),
        float(power) + (0.0 if rises else 1.0),
        np.array([slope]),
        float(unsure),
        exponent_error=float(abs(power - before)),
    )


def _continued(f: Curve, top: float) -> TipLaw | None:
    """The law that continues f below the radii at which it cancels; None if it does not cancel."""
    refused: ProblemError | None = None
    for radius, ends in _cancellations(f, top):
        law = _law(f, radius, ends)
        if law is not None:
            return law
        refused = refused or ProblemError(
            f"f(r) loses all significant digits below r = {metres(radius)} and does not follow a power of r there; give "
            "derivative= too, or write f without a difference of large numbers (numpy.expm1, "
            "r**2 / (R + sqrt(R**2 - r**2)))"
        )
    if refused is not None:
        raise refused
    return None


def _law(f: Curve, radius: float, ends: list[float]) -> TipLaw | None:
    """The law below a radius from the octaves above it; None if there is none."""
    fits = _Stretches(f, radius, ends)
    best: TipLaw | None = None
    for exponent, step, spread in _families(f, fits):
        law = _established(fits, exponent, step, spread)
        if law is not None and step == 2.0:
            # a small odd term hides from an even series, not from a full one
            full = _established(fits, exponent, 1.0, spread)
            if full is not None and np.any(_relative_difference(law, full) > full.error):
                law = full
        if law is not None and (best is None or law.error < 0.1 * best.error):
            best = law
        if best is not None and best.error < _SURE:
            break
    if best is None or best.error >= _UNUSABLE:
        return None
    # a bump may hide between the radii of a fit; where r is rounded as part of r - m, most of an octave deviates
    excess = _excess(fits, best, search_points(2.0**-_DEPTH * radius, radius)).reshape(int(_DEPTH), -1)
    scattered = _SCATTERED * np.median(excess, axis=1, keepdims=True)
    return best if np.all(excess <= np.maximum(1.0, scattered)) else None


def _relative_difference(law: TipLaw, other: TipLaw) -> FloatArray:
    """Relative difference of two laws with the same exponent."""
    z = 2.0 * _nodes() - 1.0
    return np.asarray(
        np.abs(chebyshev.chebval(z, law.coefficients) / chebyshev.chebval(z, other.coefficients) - 1.0)
    )


def _cancellations(f: Curve, top: float) -> Iterator[tuple[float, list[float]]]:
    """Radii, from the outer one, below which f is noise and above which it is not; and ends of clean stretches."""
    most = math.floor(4.0 * math.log2(min(top, 2.0**_HIGHEST)))
    far, near = np.arange(4 * _LOWEST, most + 1, 32), np.arange(max(-240, 4 * _LOWEST), min(160, most) + 1, 4)
    steps = np.unique(np.concatenate([far, near, np.arange(most - 16, most + 1, 4)]))
    states = _States(f, steps)
    for _ in range(6):
        more = states.between_changes()
        if more.size == 0:
            break
        states = states.joined(_States(f, more))
    usable = states.moves & np.isfinite(states.ratio)
    if not usable.any():
        return
    best = float(states.ratio[usable].min())
    limit = max(_SURE, 10.0 * best)
    clean = usable & (states.ratio <= limit)
    cancelling = usable & ~clean & states.cancels
    pairs = clean[1:] & clean[:-1]
    if cancelling.any() and (limit > _UNUSABLE or not pairs.any()):
        raise ProblemError(
            f"the slope of f(r) is only noise up to r = {metres(float(2.0 ** (states.steps[cancelling][-1] / 4.0)))}: its "
            f"rounding is at least {best / _SAFETY:.1e} of its rise; give derivative= too, or write f without a difference of large "
            "numbers"
        )
    for i in range(clean.size - 2, 0, -1):
        if clean[i] and clean[i + 1] and not clean[i - 1]:
            below = np.flatnonzero(clean[:i])
            if not cancelling[below[-1] + 1 if below.size else 0 : i].any():
                continue
            radius = float(2.0 ** (states.steps[i] / 4.0))
            above = states.steps[i:][~clean[i:]]
            last = min(float(2.0 ** ((above[0] - 1) / 4.0)) if above.size else math.inf, top)
            ends = [radius * 2.0**k for k in range(1, _OCTAVES + 1) if radius * 2.0**k <= last]
            if ends and last < 2.0 * ends[-1] and last == top and len(ends) < _OCTAVES:
                ends.append(top)
            if ends:
                yield radius, ends


class _States:
    """Whether f moves, and 40 roundings over its rise in an octave, at radii of 2^(quarters / 4) m."""

    def __init__(self, f: Curve, steps: NDArray[np.int_]) -> None:
        self.steps = steps
        r = 2.0 ** (steps / 4.0)
        measured, least = scatter(f, r)
        noise = np.maximum(measured, least)
        inside = np.array([1.0, 0.87, 0.74, 0.61, 0.5])
        values = f((r[:, None] * inside).ravel()).reshape(r.size, inside.size)
        with np.errstate(all="ignore"):
            rise = np.ptp(values, axis=1)
            gap = np.abs(values[:, 0] - f(np.zeros(1))[0])
            unit = float(np.nanmax(least / np.abs(values[:, 0]), initial=EPS))
            self.moves = np.isfinite(rise) & (rise > _UNDERFLOW) & np.isfinite(noise)
            self.ratio = np.where(self.moves, _SAFETY * noise / rise, math.inf)
            self.cancels = noise > 64.0 * unit * gap

    def between_changes(self) -> NDArray[np.int_]:
        """Quarters that are missing between such that differ: octaves first."""
        sure = np.where(self.moves, np.where(self.ratio <= _SURE, 2, 1), 0)
        more: list[int] = []
        for i in np.flatnonzero((sure[1:] != sure[:-1]) | (sure[1:] == 1)):
            low, high = int(self.steps[i]), int(self.steps[i + 1])
            if high - low > 4:
                more += range(low + 4, high, 4)
            elif sure[i] != sure[i + 1]:
                more += range(low + 1, high)
        return np.array(more, dtype=int)

    def joined(self, other: _States) -> _States:
        """Both, rising."""
        order = np.argsort(np.concatenate([self.steps, other.steps]))
        for name in ("steps", "moves", "ratio", "cancels"):
            both = np.concatenate([getattr(self, name), getattr(other, name)])
            setattr(self, name, both[order])
        return self


class _Stretches:
    """Weighted fits of f over [0, end] for several ends."""

    def __init__(self, f: Curve, radius: float, ends: list[float]) -> None:
        self.f, self.radius, self.ends = f, radius, ends
        self.offset = float(f(np.zeros(1))[0])
        octaves = math.log2(ends[-1] / radius)
        grid = radius * 2.0 ** np.linspace(0.0, octaves, max(math.ceil(4.0 * octaves), 4) + 1)
        grid[-1] = ends[-1]
        noise, least = scatter(f, grid)
        noise = np.maximum(noise, 0.2 * least)
        wide = np.pad(noise, 2, mode="edge")
        self._grid = grid
        self._noise = np.median(np.lib.stride_tricks.sliding_window_view(wide, 5), axis=1)
        self._least = float(max(0.5 * EPS * abs(self.offset), 5e-324))
        self._data: dict[float, tuple[FloatArray, FloatArray, FloatArray]] = {}

    def noise(self, r: FloatArray) -> FloatArray:
        """Standard deviation of the rounding of f; below the clean radii it does not grow smaller."""
        return np.maximum(np.interp(r, self._grid, self._noise), self._least)

    def data(self, end: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Radii over the end, f - f(0) and its standard deviation; first at the tip."""
        if end not in self._data:
            u = np.concatenate(
                [[0.0], (np.arange(_POINTS) + np.random.default_rng(3).random(_POINTS)) / _POINTS]
            )
            r = end * u
            values = self.f(r) - self.offset
            self._data[end] = (r / end, values, self.noise(r))
        return self._data[end]


@dataclass(frozen=True)
class _Fit:
    end: float
    terms: int
    slope: FloatArray
    """f' / (r / radius)^(n - 1) at nodes of [0, radius]."""
    spread: float
    """Its relative standard deviation."""


def _nodes() -> FloatArray:
    return np.asarray((1.0 - np.cos(np.pi * (np.arange(_SIZE) + 0.5) / _SIZE)) / 2.0)


class _Series:
    """Weighted fits of c + r^n (a_0 + a_1 r^s + ...) on [0, end], all numbers of terms at once."""

    def __init__(self, fits: _Stretches, end: float, n: float, s: float) -> None:
        self.end, self.n, self.s = end, n, s
        self.ratio = fits.radius / end
        u, values, noise = fits.data(end)
        basis = u[:, None] ** n * chebyshev.chebvander(2.0 * u**s - 1.0, _TERMS + 1)
        matrix = np.column_stack([np.full(u.size, noise.min()), basis]) / noise[:, None]
        self.scale = np.linalg.norm(matrix, axis=0)
        self.matrix, self.target = matrix / self.scale, values / noise
        self.q, self.triangle = orthonormal(np.asfortranarray(self.matrix))
        self.parts = self.q.T @ self.target
        self.clean = u * end >= fits.radius

    def rest(self, terms: int) -> FloatArray:
        """Residuals of a fit of f, over its rounding."""
        return self.target - self.q[:, : terms + 1] @ self.parts[: terms + 1]

    def misfit(self, terms: int) -> float:
        """Misfit; about 1 if only rounding is left."""
        rest = self.rest(terms)
        above, below = rest[self.clean], rest[~self.clean]
        size = above.size // _BLOCKS
        blocks = above[: size * _BLOCKS].reshape(_BLOCKS, size).mean(axis=1)
        return max(
            math.sqrt(float(np.mean(above**2))) / 1.3,
            float(np.max(np.abs(blocks))) * math.sqrt(size) / 5.0,
            float(np.max(np.abs(below), initial=0.0)) / 6.0,
        )

    def fit(self, terms: int) -> _Fit:
        """The slope of a fit."""
        size = terms + 1
        inverse = np.linalg.inv(self.triangle[:size, :size])
        solution = inverse @ self.parts[:size]
        # once more, for what rounding of the products has left
        rest = self.target - self.matrix[:, :size] @ solution
        solution = solution + inverse @ (self.q[:, :size].T @ rest)
        # whole powers are written in r / radius, others in its power
        v = (_nodes() ** (1.0 / _polynomial_step(self.s)) * self.ratio) ** self.s
        z = 2.0 * v - 1.0
        vander = chebyshev.chebvander(z, terms - 1)
        rise = 0.0 * vander
        if terms > 1:
            rise = chebyshev.chebvander(z, terms - 2) @ chebyshev.chebder(np.eye(terms))
        rows = (self.n * vander + 2.0 * self.s * v[:, None] * rise) * self.ratio ** (self.n - 1.0) / self.end
        rows = rows / self.scale[1:size]
        slope = rows @ solution[1:]
        spread = np.linalg.norm(rows @ inverse[1:], axis=1)
        level = max(math.sqrt(float(np.mean(rest**2))), 1.0)
        rounded = EPS * (np.abs(rows) @ np.abs(solution[1:]))
        with np.errstate(divide="ignore"):
            return _Fit(self.end, terms, slope, float(np.max((level * spread + rounded) / np.abs(slope))))


def _polynomial_step(step: float) -> float:
    """The power of r / radius in which a series is a polynomial."""
    return 1.0 if step in (1.0, 2.0) else step


def _good_fits(fits: _Stretches, n: float, s: float) -> Iterator[_Fit]:
    """On each stretch the two series after the shortest one that leaves only rounding."""
    fitting = False
    for count, end in enumerate(fits.ends):
        if count == 2 and not fitting:
            # the shortest stretches are the easiest
            return
        series = _Series(fits, end, n, s)
        if not series.misfit(_TERMS) <= 1.0:
            continue
        fitting = True
        terms = next(terms for terms in range(1, _TERMS + 1) if series.misfit(terms) <= 1.0)
        # the shortest one may still hide a truncation in the rounding
        yield series.fit(terms + 1)
        yield series.fit(terms + 2)


def _established(fits: _Stretches, n: float, s: float, exponent_error: float) -> TipLaw | None:
    """The best fit of a family, with the error that the fits on other stretches show; None if they contradict it."""
    good_fits = list(_good_fits(fits, n, s))
    if len(good_fits) < 2:
        return None
    best = min(good_fits, key=lambda fit: fit.spread)
    others = [fit for fit in good_fits if fit is not best and fit.spread < 30.0 * best.spread]
    differences = [float(np.max(np.abs(fit.slope / best.slope - 1.0))) for fit in others]
    for fit, distance in zip(others, differences, strict=True):
        if distance > 8.0 * (fit.spread + best.spread) + 16.0 * EPS:
            return None
    z = 2.0 * _nodes() - 1.0
    series = np.asarray(np.linalg.solve(chebyshev.chebvander(z, _SIZE - 1), best.slope), dtype=float)
    series = series[: int(np.flatnonzero(np.abs(series) > 0.1 * EPS * np.abs(series).max())[-1]) + 1]
    # rounding is no white noise: its standard deviation is safe within a factor of two
    error = 8.0 * best.spread + 2.0 * max(differences, default=0.0) + 8.0 * EPS
    law = TipLaw(fits.radius, n, series, error, _polynomial_step(s), exponent_error)
    inside = fits.radius * 2.0 ** (-_DEPTH * jitter(96, 0.1))
    return law if np.all(_excess(fits, law, inside) <= 1.0) else None


def _excess(fits: _Stretches, law: TipLaw, r: FloatArray) -> FloatArray:
    """Deviation of f from a law at radii below that of the law, over eight roundings of f and the error of the law."""
    # int_0^1 t^(n-1) Q(w t^s) dt with v = t^s is a polynomial in w
    power = law.exponent / law.step
    v, weights = scipy.special.roots_jacobi(_SIZE, 0.0, power - 1.0)
    nodes = _nodes()
    means = chebyshev.chebval(nodes[:, None] * (v + 1.0) - 1.0, law.coefficients) @ weights
    series = np.linalg.solve(chebyshev.chebvander(2.0 * nodes - 1.0, _SIZE - 1), means)
    t = r / law.radius
    gap = r * t ** (law.exponent - 1.0) * chebyshev.chebval(2.0 * t**law.step - 1.0, series)
    gap /= 2.0**power * law.step
    values = fits.f(r) - fits.offset
    allowed = 8.0 * (fits.noise(r) + EPS * np.abs(values)) + EPS * abs(fits.offset) + law.error * np.abs(gap)
    return np.asarray(np.abs(values - gap) / allowed)


def _families(f: Curve, fits: _Stretches) -> Iterator[tuple[float, float, float]]:
    """Exponents and steps of the series to be tried, the simplest first, and the uncertainty of the exponent."""
    ends = [fits.radius, *fits.ends]
    if len(ends) < 3:
        return
    slopes = []
    for r in ends[:5]:
        coefficients, _ = slope_panel(f, r / 1.19, r)
        slopes.append(float(chebyshev.chebval(1.0, coefficients)))
    same = next((i for i, slope in enumerate(slopes) if not slope * slopes[0] > 0.0), len(slopes))
    if same < 2:
        return
    local = np.diff(np.log(np.abs(slopes[:same]))) / np.diff(np.log(ends[:same])) + 1.0
    guess = float(local[0])
    if local.size > 2:
        bend = local[2] - 2.0 * local[1] + local[0]
        if bend != 0.0 and abs(local[1] - local[0]) < abs(local[2] - local[1]):
            guess -= float((local[1] - local[0]) ** 2 / bend)
    # next to the radius, a term of higher power may still be the larger one
    highest = math.ceil(max(guess, float(local[0])) - 0.05)
    wholes = sorted(range(1, min(highest, 16) + 1), key=lambda whole: abs(whole - guess))
    yield from ((float(whole), step, 0.0) for step in (2.0, 1.0) for whole in wholes)
    simple = round(guess * 12.0) / 12.0
    for step in dict.fromkeys((2.0, 1.0, 0.5, 1.5, simple)):
        free = _free_exponent(fits, guess, step) if step > 0.0 else None
        if free is None:
            continue
        n, spread = free
        rational = round(n * 120.0) / 120.0
        if abs(n - rational) <= max(16.0 * spread, 1e-12):
            yield rational, step, 0.0
        else:
            yield n, step, max(4.0 * spread, 2.0 * EPS * n)


def _free_exponent(fits: _Stretches, guess: float, step: float) -> tuple[float, float] | None:
    """The exponent that is known best of those that leave only rounding on a stretch, and its standard deviation."""
    candidates: list[tuple[float, float]] = []
    for count, end in enumerate(fits.ends):
        if count == 2 and not candidates:
            return None
        for terms in range(1, 7):
            n, spread = guess, math.inf
            for _ in range(8):
                n, spread, change = _better_exponent(fits, end, n, step, terms)
                if not 0.0 < n < 64.0 or abs(change) < 1e-15:
                    break
            if 0.0 < n < 64.0 and _Series(fits, end, n, step).misfit(terms) <= 1.0:
                candidates.append((spread, n))
                break
    if not candidates:
        return None
    spread, n = min(candidates)
    return n, spread


def _better_exponent(
    fits: _Stretches, end: float, n: float, s: float, terms: int
) -> tuple[float, float, float]:
    """One step of Gauss and Newton for the exponent, its standard deviation and the step."""
    u, values, noise = fits.data(end)
    basis = u[:, None] ** n * chebyshev.chebvander(2.0 * u**s - 1.0, terms - 1)
    matrix = np.column_stack([np.full(u.size, noise.min()), basis]) / noise[:, None]
    scale = np.linalg.norm(matrix, axis=0)
    q, triangle = orthonormal(np.asfortranarray(matrix / scale))
    if (
        not np.abs(np.diagonal(triangle)).min() > 0.0
    ):  # terms equal within rounding do not determine an exponent
        return n, math.inf, 0.0
    solution = np.linalg.solve(triangle, q.T @ (values / noise)) / scale
    rest = values / noise - matrix @ solution
    steepness = basis @ solution[1:] * np.log(np.where(u > 0.0, u, 1.0)) / noise
    # what the other terms cannot do
    steepness = steepness - q @ (q.T @ steepness)
    power = float(steepness @ steepness)
    if not (math.isfinite(power) and power > 0.0):
        return n, math.inf, 0.0
    change = min(max(float(steepness @ rest) / power, -0.2), 0.2)
    return n + change, 1.0 / math.sqrt(power), change
