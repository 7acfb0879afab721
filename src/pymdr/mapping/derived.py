"""The slope f'(r) of a callable that gives f alone."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.mapping.callables import (
    Steps,
    TipLaw,
    find_kinks,
    polished,
    rounding,
    scatter,
    slope_panel,
    tip_law,
    underflow_law,
)
from pymdr.mapping.resolving import SlopeSource, anchored, radii_next_to
from pymdr.numerics.panels import TERMS, Panels, clenshaw
from pymdr.numerics.roots import boundary
from pymdr.problem.profiles import Function, call
from pymdr.units import FloatArray, metres

_WIDTH = 1e-12
"""Relative error of f' above which a panel is divided if that helps."""
_DEEPEST = 40
_STAIRS = 1e-9
"""Relative error of f' that is accepted if it grows on halves of a panel, as that of a staircase does."""
_GAIN = 0.5
_NOISY = 1e3
"""Error of f' on a panel by rounding alone, in roundings of f over the width."""
_MOST = 1024
_KINKED = 2.0**-6
"""Width of a panel, over its distance from the preceding breakpoint, from which on kinks are searched."""
_SERIES = ("_low", "_high", "_series", "_error")
_SURE, _CANCELLED = 1e-10, 64.0
_INWARD, _OUTWARD = 2.0 ** -np.arange(0.0, 40.0, 4.0), 2.0 ** np.arange(4.0, 44.0, 4.0)
"""Radii at which a cancellation of f is searched, over the radius of the contact."""
_UNDERFLOW = 1e-290
_FIRST, _SPREAD = 0.02, 2.0
"""Position on a panel at a breakpoint, and the ratio of f' at its end to f' there above which f' spans orders of
magnitude."""
_DIGITS = 1e6
_INTEGRALS = np.array([0.0 if j % 2 else 1.0 / (1.0 - j * j) for j in range(TERMS)])
"""Integrals of the Chebyshev polynomials over a panel of length 1."""
_MISSED = 16.0
"""Roundings of f and of a radius by which the rise of f may differ from the integral of its slope."""
_EPS = float(np.finfo(float).eps)
_ROUNDED = 4.0
"""Rounding error of a value of f, including elementary functions, in units of its last place."""
_HIDDEN = 4.0
"""Undetected rise of f, in roundings of f."""


class DerivedSource(SlopeSource):
    """
    f' by differentiating series of f on panels, and below the radii at which f cancels by the law of its tip.

    Parameters
    ----------
    profile : Function
        With `f` and without `derivative`.
    """

    def __init__(self, profile: Function) -> None:
        self.profile = profile
        self.max_radius = profile.max_radius
        self.knots = profile.breakpoints
        self._polished = 0.0
        self._law: TipLaw | None = None
        self._prepared_to = 0.0
        self._searched_beyond = 0.0
        self._end = math.inf
        self._low: list[float] = []
        self._high: list[float] = []
        self._series: list[FloatArray] = []
        self._error: list[float] = []
        self._done: set[tuple[float, float]] = set()
        self._order = np.zeros(0, dtype=np.intp)
        self._starts = np.zeros(0)
        self._scatters: dict[float, float] = {}
        self._steps = Steps(self._f)
        self._detected: set[float] = set()

    @property
    def continued(self) -> float:
        """Radius in m below which the law of the tip stands for f; 0 where f has its digits all the way."""
        return 0.0 if self._law is None else self._law.radius

    def _f(self, r: FloatArray) -> FloatArray:
        f = self.profile.f
        assert f is not None
        values: FloatArray = call(f, r)
        return values

    @cached_property
    def _apex(self) -> float:
        """F(0) in m."""
        return float(self._f(np.zeros(1))[0])

    def sample(self, base: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Slope f' at the rounded radii, and their offsets; NaN on the axis, unless a law replaces f there."""
        r = radii_next_to(self.knots, base, offset)
        outermost = float(r.max())
        if outermost > 0.0:
            self.foresee(outermost)
        answer = np.full(r.shape, math.nan)
        below = r < self.continued
        if below.any() and self._law is not None:
            answer[below] = self._law.slope(r[below])
        known = ~below & (r > 0.0) & (r <= self._end)
        if known.any():
            self._cover(r[known])
            answer[known] = self._value(r[known])
        return answer, r - base

    def uncertainty(self, panels: Panels) -> FloatArray:
        """Error of f' on panels, from the rounding of f."""
        total = self._series_errors(panels) + self._steps.errors(panels.base, panels.low, panels.width)
        law = self._law
        if law is None:
            return total
        inside = panels.stop <= law.radius * (1.0 + 1e-9)
        law_error = law.error_at(np.minimum(np.maximum(panels.start, 1e-300), law.radius))
        whole: FloatArray = np.where(
            inside, law_error * np.abs(law.slope(np.minimum(panels.stop, law.radius))), total
        )
        return whole

    def _series_errors(self, panels: Panels) -> FloatArray:
        """Errors of the series on panels; a thin panel is weighted by its fraction of an integral with an inverse square root."""
        if not self._error:
            return np.zeros(panels.count)
        errors = np.array(self._error)[self._order]
        root = np.sqrt(np.array(self._high)[self._order] - self._starts)
        first = np.clip(np.searchsorted(self._starts, panels.start, side="right") - 1, 0, errors.size - 1)
        last = np.maximum(np.searchsorted(self._starts, panels.stop), first + 1)
        ends = np.column_stack([first, last]).ravel()
        # what begins at the last one has no end
        largest = np.maximum.reduceat(np.append(errors, 0.0), ends)[::2]
        shared = np.maximum.reduceat(np.append(errors * root, 0.0), ends)[::2]
        return np.asarray(np.minimum(largest, shared / np.sqrt(panels.width)))

    def rounding(self, r: float) -> float:
        """Scatter in m of f around a radius in m."""
        return float(np.nan_to_num(self._scatter(r)))

    def rise(self, r: float) -> tuple[float, float]:
        """F(r) - f(0) in m and its rounding."""
        return rise_of(self._f, r)

    def _scatter(self, r: float) -> float:
        """Rounding of f around a radius in m, found once; nan where f is not defined."""
        if r not in self._scatters:
            self._scatters[r] = float(rounding(self._f, np.array([r]))[0])
        return self._scatters[r]

    def kinks(self, low: float, high: float) -> list[float]:
        """Kinks of f between two radii that were not named; panels end at them from then on."""
        known = [b for b in self.knots if low < b < high]
        # a kink is located once: its place is as sharp as the rounding of f allows, and differs with the interval
        located = [
            b
            for start, end in pairwise([low, *known, high])
            for b in find_kinks(self._f, start, end, of="value")
        ]
        if located:
            self._detected.update(located)
            self.knots = tuple(sorted({*self.knots, *located}))
            self._forget(min(located))
        return sorted([*located, *(b for b in known if b in self._detected)])

    def _forget(self, b: float) -> None:
        """Drop the series on panels of the grid that a new breakpoint may cut or move: they are no longer than half of it."""
        dropped = [edge for _, edge in self._done if edge > 0.5 * b]
        self._done = {key for key in self._done if key[1] <= 0.5 * b}
        kept = [i for i, low in enumerate(self._low) if low < min(dropped, default=math.inf)]
        for name in _SERIES:
            setattr(self, name, [getattr(self, name)[i] for i in kept])

    def polish(self, top: float) -> bool:
        """Move breakpoints to the neighbouring kinks of f."""
        before, self.knots = self.knots, polished(self._f, self.knots, self.max_radius, self._polished, top)
        self._polished = max(self._polished, top)
        self.moved = self.moved | ({*self.knots} - {*before})
        return self.knots != before

    def foresee(self, top: float) -> None:
        """Find the law of the tip where f cancels on radii far below `top`; it may need larger radii for that."""
        self._steps.refuse(top, self.knots)
        if self._prepared_to or self._law is not None:
            return
        end = min([math.inf, *self.knots[:1], self.max_radius])
        self._law = underflow_law(self._f, top, end)
        if self._law is not None:
            return
        if self._cancels(top * _INWARD):
            self._prepared_to = top
        elif not self._cancels_beyond(top, end):
            return
        for most in (end, 1024.0 * top, 16.0 * top, top):
            try:
                self._law = tip_law(self._f, min(most, end))
            except ProblemError:
                if most == top:
                    raise
                continue
            break

    def _cancels_beyond(self, top: float, end: float) -> bool:
        """
        Whether f cancels farther out, as r^2 / 2 R + A (1 - cos k r) does.

        Where k r is below 1e-8 the cosine is exactly 1, and f looks precise though it lacks its second term.
        """
        if top <= self._searched_beyond:
            return False
        self._searched_beyond = top
        r = top * _OUTWARD
        try:
            return self._cancels(r[r <= end])
        except ProblemError:
            # f need not be defined beyond the contact
            return False

    def _cancels(self, r: FloatArray) -> bool:
        """Whether 40 roundings of f are more than 1e-10 of its rise, and many of its own, in an octave below some radii."""
        if r.size == 0:
            return False
        values = self._f(np.concatenate([r, 0.84 * r])).reshape(2, -1)
        measured, least = scatter(self._f, r)
        with np.errstate(invalid="ignore"):
            rise, gap = np.abs(values[0] - values[1]), np.abs(values[0] - self._apex)
            noise, unit = np.maximum(measured, least), np.nanmax(least / np.abs(values[0]), initial=_EPS)
            resolved = (gap > _UNDERFLOW) | (noise > _UNDERFLOW)
            unresolved = (40.0 * noise > _SURE * rise) & (noise > _CANCELLED * unit * gap) & resolved
        return bool(np.any(unresolved & np.isfinite(rise)))

    def rough(self, r: FloatArray) -> FloatArray:
        """Approximate f' at radii in m, by parabolas."""
        values = self._f(np.concatenate([0.84 * r, 0.92 * r, r])).reshape(3, -1)
        answer: FloatArray = (values[0] - 4.0 * values[1] + 3.0 * values[2]) / (0.16 * r)
        below = r < self.continued
        if below.any() and self._law is not None:
            answer[below] = self._law.slope(r[below])
        return answer

    def _value(self, r: FloatArray) -> FloatArray:
        index = self._order[
            np.clip(np.searchsorted(self._starts, r, side="right") - 1, 0, self._order.size - 1)
        ]
        low, high = np.array(self._low)[index], np.array(self._high)[index]
        u = ((r - low) / (high - low)).clip(0.0, 1.0)
        values = clenshaw(np.array(self._series)[index], u)
        return np.where((r >= low) & (r <= high), values, math.nan)

    def _cover(self, r: FloatArray) -> None:
        """Series on all panels of the grid in which some radii lie."""
        fresh = False
        for base, end in self._sections(r):
            inside = r[(r >= base) & (r <= end)]
            if inside.size == 0:
                continue
            low = float(inside.min())
            start = low - base
            grid = self._grid(base, start, float(inside.max()), end)
            edges = base + np.concatenate([grid.low, grid.high[-1:]])
            used = np.unique(np.clip(np.searchsorted(edges, inside, side="right") - 1, 0, grid.count - 1))
            for i in used.tolist():
                key = (base, round(float(edges[i]), 300) if edges[i] else 0.0)
                if key not in self._done:
                    made = self._divided(float(edges[i]), float(edges[i + 1]), base)
                    if made is None:
                        # a kink was found, and sections are others
                        self._cover(r)
                        return
                    self._done.add(key)
                    for name, values in zip(_SERIES, zip(*made, strict=True), strict=False):
                        getattr(self, name).extend(values)
                    fresh = True
        if fresh or self._order.size != len(self._low):
            self._order = np.argsort(self._low, kind="stable")
            self._starts = np.array(self._low)[self._order]

    def _sections(self, r: FloatArray) -> list[tuple[float, float]]:
        marks = [0.0, *self.knots, self.max_radius]
        low, high = float(r.min()), float(r.max())
        return [(a, b) for a, b in pairwise(marks) if a <= high and b >= low]

    def _grid(self, base: float, low: float, stop: float, end: float) -> Panels:
        """Panels of the grid from the one in which an offset lies."""
        unit = base if base > 0.0 else 1.0
        j = math.floor(4.0 * math.log2((base + low) / unit) + 1e-9)
        first = _anchor(base, j)
        if base + first >= end:
            # the end itself lies in the panel before it
            first = _anchor(base, j - 1)
        return anchored(base, max(min(first, low), 0.0), min(max(stop, base + low * 1.01), end), end)

    def _divided(
        self, low: float, high: float, base: float
    ) -> list[tuple[float, float, FloatArray, float]] | None:
        """Ends, series and errors on a panel or on its halves, where these are better; None where a kink was found in it."""
        todo = [(low, high, math.inf, 0)]
        made: list[tuple[float, float, FloatArray, float]] = []
        searched = False
        while todo:
            if len(made) + len(todo) > _MOST:
                raise ConvergenceError(
                    f"the profile is not resolved between r = {metres(low)} and {metres(high)}: it is rough there on every "
                    "scale; give a smooth profile, or name the radii where it is not smooth as breakpoints"
                )
            left, right, before, depth = todo.pop()
            panel = self._panel(left, right)
            if panel is None:
                continue
            series, error, right = panel
            size = float(np.sum(np.abs(series)))
            middle = left + (0.25 if left == base and base > 0.0 else 0.5) * (right - left)
            settled = error <= _WIDTH * size or (size == 0.0 and self._hides_on(right - left, error))
            if not settled and error > _GAIN * before:
                # finer panels only help where the misfit is more than rounding
                noise = self._noise_beyond(base, right)
                settled = error <= _NOISY * noise / (right - left) or (
                    error > before and error <= _STAIRS * size
                )
            begins = left == base and base > 0.0
            settled = settled and not (
                begins
                and (
                    self._starts_steeply(series, left, right, base)
                    or (base in self._detected and self._misses_rise(series, error, left, right))
                )
            )
            if not settled and not searched and right - left < _KINKED * (left - base):
                searched = True
                if self._has_kinks(low, min(high, self._end)):
                    return None
            thinnest = 64.0 * np.finfo(float).eps if begins else 1e-9
            thin = depth >= _DEEPEST or right - left <= thinnest * right or not left < middle < right
            if settled or thin:
                made.append((left, right, series, error))
                continue
            todo += [(middle, right, error, depth + 1), (left, middle, error, depth + 1)]
        return made

    def _has_kinks(self, low: float, high: float) -> bool:
        """Whether there are kinks that were not named between two radii, which are breakpoints from then on."""
        try:
            return bool(self.kinks(low, high))
        except ProblemError:
            # other defects of the profile are refused where they matter
            return False

    def _noise_beyond(self, base: float, r: float) -> float:
        """Rounding of f around a radius in m; just beyond a breakpoint it is measured outward from the breakpoint."""
        noise = self._scatter(r)
        if base > 0.0:
            nearby = rounding(lambda h: self._f(base + h), np.array([r - base]))
            noise = max(noise, float(np.nan_to_num(nearby)[0]))
        return noise

    def _starts_steeply(self, series: FloatArray, low: float, high: float, base: float) -> bool:
        """Whether f' spans orders of magnitude next to a breakpoint and f is above its rounding there."""
        first, last = np.abs(clenshaw(np.stack([series, series]), np.array([_FIRST, 1.0])))
        rise, noise = last * (high - low), self._noise_beyond(base, high)
        return bool(last > _SPREAD * first and rise > _DIGITS * noise)

    def _misses_rise(self, series: FloatArray, error: float, low: float, high: float) -> bool:
        """Whether f rises by another height than its slope gives, as where another kink lies close beyond a breakpoint."""
        first, last = self._f(np.array([low, high]))
        missed = abs(float(last - first - (high - low) * (series @ _INTEGRALS)))
        rounded = max(abs(first), abs(last)) + high * float(np.sum(np.abs(series)))
        return bool(missed > error * (high - low) + _MISSED * _EPS * rounded)

    def _panel(self, low: float, high: float) -> tuple[FloatArray, float, float] | None:
        places = np.linspace(0.0, 1.0, 33)
        values = self._f(low + (high - low) * places)
        if not np.isfinite(values).all():
            high = self._defined(low, high)
            self._end = min(self._end, high)
            if not high > low * (1.0 + 1e-12):
                return None
            values = self._f(low + (high - low) * places)
        apex = self._apex
        if np.all(np.abs(values - apex) < _UNDERFLOW):
            # an offset hides what rises less than its rounding
            return np.zeros(TERMS), _EPS * abs(apex) / max(high - low, self._hidden_beyond(high)), high
        series, error = slope_panel(self._f, low, high, TERMS)
        return series, error, high

    def _hides_on(self, width: float, error: float) -> bool:
        """Whether f does not rise beyond a panel either, over more than the width of the panel: halving it would add no information."""
        return error * width < 0.99 * _EPS * abs(self._apex)

    def _hidden_beyond(self, r: float) -> float:
        """Distance in m beyond a radius over which the offset of f hides its rise."""
        away = r * 2.0 ** -np.arange(0.0, 50.0)
        away = away[r + away <= min(self.max_radius, self._end)]
        f = self._f(np.append(r + away, r))
        hides = np.abs(f[:-1] - f[-1]) <= _HIDDEN * _EPS * np.abs(f[-1])
        return float(away[hides].max(initial=0.0))

    def _defined(self, low: float, high: float) -> float:
        """The last radius at which f is finite."""
        if not np.isfinite(self._f(np.array([low]))[0]):
            raise ConvergenceError(
                f"the profile is not defined at r = {metres(low)}; use smaller radii, and declare the "
                "last radius: Function(..., max_radius=...)"
            )
        return float(boundary(lambda r: np.isfinite(self._f(r)), np.array([low]), high)[0][0])


def rise_of(f: Callable[[FloatArray], ArrayLike], r: float) -> tuple[float, float]:
    """F(r) - f(0) in m of a callable and its rounding."""
    apex, value = call(f, np.array([0.0, r])).tolist()
    return value - apex, _ROUNDED * _EPS * max(abs(apex), abs(value))


def _anchor(base: float, j: int) -> float:
    """The offset in m at which a panel of the grid begins."""
    return base * math.expm1(j * math.log(2.0) / 4.0) if base > 0.0 else 2.0 ** (j / 4.0)
