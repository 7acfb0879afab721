"""The slope f'(r) of any profile as Chebyshev series on graded panels with measured errors.

Panels are anchored at fixed radii, quarter octaves 2^(j/4) m toward the tip and b 2^(j/4) beyond a breakpoint b, so that
they do not depend on the largest radius of a path. Panels that do not resolve the slope are divided.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.mapping.callables import search_points
from pymdr.mapping.resolving import (
    FIRST,
    Slopes,
    SlopeSource,
    Stopped,
    anchored_between,
    joined_slopes,
    resolve,
    without_wide_start,
)
from pymdr.numerics.panels import TERMS, BoolArray, IndexArray, clenshaw, evaluate
from pymdr.units import FloatArray, metres

_SEARCH_DEPTH = 2.0**-12
"""Least radius of the search below the tail radius, over the tail radius."""
MOST_KINKS = 32
_TINY = 1e-290
_AT_END = 1.0 - 1e-15
ABOVE_TAIL = 4.0
"""Least radius at which the image of a slope is independent of its tail, over the tail radius."""
_SUDDEN = 1e-200
_WEIGHTLESS = 1e-30
"""Fraction of a result below which the slope further in is negligible."""
_SEARCH_OCTAVES = 20, 48, 160
"""Numbers of octaves that are searched for a tail radius, in turn."""
_LEAST_INNER = 1e-280
"""Least radius in m with octaves further in."""
_PURE = 1e-14
_FLAT = 0.5
"""Exponent of f at the tip below which the rise of f up to the tail radius matters."""
_DEEPEST, _LAST_OCTAVES = 970, 8
"""Octaves below 1 m in which f' is evaluated, and the last of them, in which its power is measured."""
_FLATTEST = 1e-3
"""Least such exponent for the quadrature rules."""
_OPEN = 1e-6
"""Largest relative uncertainty from the law of a flat tip."""
_UNNAMED = 32.0 * float(np.finfo(float).eps)
"""Relative error of the radius of a detected kink."""
_AHEAD = 1.23
"""Largest ratio of the last panel end to the needed radius at a breakpoint."""
_SLIGHT = 32.0
"""Largest insignificant jump at a detected kink, over its rounding error."""
_DROWNED = 0.1
"""Error of f', in parts of it, from which jumps between panels count as errors."""
_LEAST_LEAP = 1e-12
_MISSED = 1e-12
"""Relative misfit of f' above which a panel next to a breakpoint does not resolve it."""
PROBED = np.array([0.03, 0.1, 0.25, 0.5, 0.75, 1.0])
"""Positions on a panel at which an uncertain curve is evaluated."""


@dataclass(frozen=True)
class Tail:
    """The tip below the first panel: f' = slope (r / radius)^power."""

    radius: float
    slope: float
    power: float
    error: float = 0.0
    """Error in m of the rise of f up to the radius."""


@dataclass
class ResolvedSlope:
    """f' of a profile from near its tip to the largest requested radius, extended on demand."""

    source: SlopeSource
    limit: float
    """Last radius in m at which the profile is defined."""
    knots: list[float] = field(init=False)
    slopes: Slopes | None = None
    front: float = 0.0
    """Radius in m up to which the slope is resolved."""
    tail_radius: float = 0.0
    """Radius in m below which it is a power law."""
    inner: float = math.inf
    """Least radius in m at which results do not depend on the tail."""
    tail: Tail = field(init=False)
    _power_from: float = math.inf
    continued: float = 0.0
    """Radius in m below which a law replaced the profile when the slope was resolved."""
    undeclared: list[float] = field(default_factory=list)
    """Kinks in m that were not declared."""

    def __post_init__(self) -> None:
        self.knots = sorted(self.source.knots)

    def _matters_below(self, inner: float) -> bool:
        """Whether a feature between the octaves below the first panel matters to results at a radius in m."""
        assert self.slopes is not None
        if self.tail_radius < 2.0**-40 * inner or self.tail.slope == 0.0:
            return False
        # the tail radius is a power of two, which scales exactly
        r = self.tail_radius * _below_begin()
        r = r[r < min([self.limit, *self.knots[:1]])]
        given = self.source.sample(np.zeros(r.size), r)[0]
        law = self.tail.slope * (r / self.tail.radius) ** self.tail.power
        panels, last = self.slopes.panels, max(inner, ABOVE_TAIL * self.tail_radius)
        scale = float(
            np.max(self.slopes.size * np.minimum(panels.stop, last), where=panels.start < last, initial=0.0)
        )
        # slopes close to underflow are negligible further out
        return scale > _SUDDEN and bool(np.max(np.abs(given - law) * r) > 1e-15 * scale)

    def is_power_from(self, x: float) -> bool:
        """Whether the tip is one power, to rounding, from a radius in m up to the first panel."""
        tail = self.tail
        if tail.slope == 0.0 or x >= self._power_from:
            return x >= self._power_from or bool(self.knots and x < self.knots[0])
        deep = max(min(x, self.tail_radius) * 2.0**-8, 1e-290)
        # the image is a power up to there
        r = search_points(deep, min(self._power_from, ABOVE_TAIL * self.tail_radius))
        given = self.source.sample(np.zeros(r.size), r)[0]
        with np.errstate(under="ignore"):
            law = tail.slope * (r / tail.radius) ** tail.power
        if bool(np.all(np.abs(given - law) <= np.maximum(_PURE * np.abs(law), _TINY))):
            self._power_from = deep
            return True
        return False

    def resolve_to(self, x: float, inner: float) -> None:
        """Resolve the slope on radii up to `x`, and inward as far as a result at `inner` depends on it."""
        x = min(x, self.limit)
        if self.source.polish(_AHEAD * x):
            self.knots = sorted({*self.source.knots, *self.undeclared})
        self.source.foresee(x)
        while True:
            # larger radii may show that only rounding was resolved
            if self.slopes is None or inner < self.inner or self.source.continued != self.continued:
                self._begin(x, min(inner, self.inner))
            # the profile may end before x
            while self.front < min(x, self.limit) * _AT_END:
                self._extend(x)
            if self.source.continued == self.continued:
                break

    # -- the two ends -----------------------------------------------------------------------------

    def _begin(self, x: float, inner: float) -> None:
        """Resolve from the tail radius for a result at `inner`, and from further in where that matters."""
        start = inner
        self._begin_below(x, start)
        while self._matters_below(inner):
            start *= _SEARCH_DEPTH
            self._begin_below(x, start)
        self.inner = inner

    def _begin_below(self, x: float, start: float) -> None:
        """Resolve from a tail radius below a radius in m."""
        self.continued = self.source.continued
        top, last = max(x, self.front), self.tail_radius if self.slopes is not None else math.inf
        while True:
            bottom = min(start, x, *self.knots[:1])
            tail_radius = min(_tail_radius(self.source, bottom), last)
            self.tail_radius, self.front, self.slopes = tail_radius, tail_radius, None
            while self.front < min(top, self.limit):
                self._extend(top)
            # the image begins at the first kink, which must be above the tail
            if not self.knots or self.knots[0] >= ABOVE_TAIL * tail_radius:
                break
            last = tail_radius
        assert self.slopes is not None
        self.tail = _tail(self.slopes, tail_radius)
        if self.tail.power < _FLAT - 1.0:
            self.tail = _flat_tail(self.source, self.tail, self.slopes, bottom)
        self._power_from = math.inf

    def _extend(self, x: float) -> None:
        """Append panels up to `x`, or up to the first undeclared kink."""
        knots = np.array(self.knots)
        passed, before = np.searchsorted(knots, [self.front, x], side="right")
        before = max(before - (before > 0 and knots[before - 1] == x), passed)
        base = self.knots[passed - 1] if passed else 0.0
        end = min(self.knots[before] if before < knots.size else math.inf, self.limit)
        panels = anchored_between(base, self._front_offset(base), knots[passed:before], min(x, end), end)
        panels = without_wide_start(panels, x)
        made = resolve(self.source, panels, x, self._largest_part, self._find_kinks)
        if isinstance(made, Stopped):
            self._handle_stop(made)
            return
        if not self.source.surveyed:
            leaps, drowned = _jumps_between(made, self.slopes)
            if kinks := self._kinks_between(made, leaps):
                if kinks[0] < self.front * (1.0 + FIRST):
                    # no sliver is left between it and the panels before
                    self.slopes, self.front = None, self.tail_radius
                self._handle_stop(Stopped(kinks))
                return
            made = replace(made, jump_error=np.maximum(made.jump_error, np.maximum(leaps, drowned)))
        made = _with_onsets(made, self.slopes, [*self.undeclared, *self.source.moved], self.source)
        self.slopes = made if self.slopes is None else joined_slopes(self.slopes, made)
        # panels divided beyond the needed radius are not included
        complete = made.panels.high[-1] == panels.high[-1] == end - panels.base[-1]
        self.front = end if complete else float(made.panels.stop[-1])

    @property
    def _largest_part(self) -> float:
        """Estimate of the largest contribution in m of the resolved slope to the image."""
        return 0.0 if self.slopes is None else float(np.max(self.slopes.size * self.slopes.panels.stop))

    def _kinks_between(self, made: Slopes, leaps: FloatArray) -> list[float]:
        """Kinks between panels that resolve f' on both sides."""
        for i in np.flatnonzero(leaps).tolist():
            edge, base = float(made.panels.start[i]), float(made.panels.base[i])
            before = made.panels if i or self.slopes is None else self.slopes.panels
            # equal widths on both sides show a faint kink best
            width = float(max(before.width[i - 1], made.panels.width[i]))
            low = max(edge - width, base)
            high = min([edge + width, self.limit, *(b for b in self.knots if b > edge)])
            try:
                between = [b for b in self._find_kinks(low, high) if low < b < high]
            except ProblemError:
                # there is a jump, but no kink that can be located
                continue
            if between:
                return between
        return []

    def _front_offset(self, base: float) -> float:
        """Offset of the start of the next panel, without rounding."""
        if self.slopes is None or self.slopes.panels.base[-1] != base:
            return self.front - base
        return float(self.slopes.panels.high[-1])

    def _find_kinks(self, low: float, high: float) -> list[float]:
        soft = self.source.soft_knots
        inside = soft[(soft > low) & (soft < high)]
        if inside.size:
            return list(inside.tolist())
        if len(self.undeclared) >= MOST_KINKS:
            raise ConvergenceError(
                f"the profile has more than {MOST_KINKS} undeclared kinks, the next near r = {metres(low)}; declare them: "
                "Function(..., breakpoints=[...])"
            )
        kinks = self.source.kinks(low, high)
        self.undeclared += kinks
        return kinks

    def _handle_stop(self, made: Stopped) -> None:
        if made.kinks:
            self.knots = sorted({*self.knots, *made.kinks})
            return
        self.limit = made.end
        if self.limit <= self.front:
            raise ConvergenceError(
                f"the profile gives {made.value} at r = {metres(made.end)}; use smaller radii, and declare the last radius: "
                "Function(..., max_radius=...)"
            )


def _jumps_between(made: Slopes, before: Slopes | None) -> tuple[FloatArray, FloatArray]:
    """Jumps of f' at the lower ends of panels that follow others: those that errors cannot explain, and those in noise; each (P,)."""
    whole = made if before is None else joined_slopes(before.last, made)
    panels, series = whole.panels, whole.series
    # T_j is 1 at the upper and (-1)^j at the lower end
    last = series.coefficients.sum(axis=1)
    first = series.coefficients @ (1.0 - 2.0 * (np.arange(TERMS) % 2))
    steep = np.flatnonzero(series.power)
    with np.errstate(divide="ignore", invalid="ignore"):
        first[steep] *= (panels.low[steep] / panels.high[steep]) ** series.power[steep]
    allowed = 64.0 * np.finfo(float).eps * whole.size + 8.0 * whole.error
    # where f' is close to 0 its rounding is no less than further in
    allowed += _LEAST_LEAP * np.maximum.accumulate(whole.size * panels.stop) / panels.stop
    jump_size = np.abs(first[1:] - last[:-1])
    jump_size = np.where(panels.low[1:] > 0.0, jump_size, 0.0)
    explained = allowed[1:] + allowed[:-1]
    # in noise of the size of f' the whole rise over a kink may be between panels
    drowned = explained > _DROWNED * np.maximum(whole.size[1:], whole.size[:-1])
    padding = np.zeros(made.panels.count - jump_size.size)
    leaps, hidden = (
        np.append(padding, np.where(mask, jump_size, 0.0)) for mask in (jump_size > explained, drowned)
    )
    return leaps, hidden


@lru_cache(maxsize=1)
def _below_begin() -> FloatArray:
    """Radii of the search for features below the tail radius, over the tail radius."""
    return search_points(_SEARCH_DEPTH, ABOVE_TAIL)


def _with_onsets(made: Slopes, before: Slopes | None, detected: list[float], source: SlopeSource) -> Slopes:
    """Slopes with the jumps of f' at breakpoints, their errors, and the errors of the places."""
    panels = made.panels
    begins = np.flatnonzero(panels.begins)
    if begins.size == 0:
        return made
    made = _with_continuous_ends(made, begins, source.uncertainty(panels.take(begins)))
    series = made.series
    jump, jump_error, onset_error = np.array(made.jump), np.array(made.jump_error), np.array(made.onset_error)
    right = np.where(
        series.power[begins] == 0.0, clenshaw(series.coefficients[begins], np.zeros(begins.size)), 0.0
    )
    left, size, error = np.zeros(begins.size), np.zeros(begins.size), np.array(made.error[begins])
    inner = begins > 0
    left[inner] = clenshaw(series.coefficients[begins[inner] - 1], np.ones(int(inner.sum())))
    size[inner] = made.size[begins[inner] - 1]
    error[inner] += made.error[begins[inner] - 1]
    if not inner.all() and before is not None:
        left[~inner] = clenshaw(before.series.coefficients[-1:], np.ones(1))
        size[~inner] = before.size[-1]
        error[~inner] += before.error[-1]
    difference = right - left
    rounding = np.finfo(float).eps * np.maximum(size, made.size[begins])
    jumping = np.abs(difference) > 64.0 * rounding + error
    quiet, seen = before is None or _is_nothing(before).all(), np.zeros(begins.size, dtype=bool)
    for k, i in enumerate(begins.tolist()):
        if panels.base[i] in detected:
            starts_here = quiet and _is_nothing(made)[:i].all()
            # the error of an intersection of two curves follows from that of their difference; the width converts the
            # rounding of f' to that of f
            shifted = abs(difference[k]) if starts_here else max(size[k], made.size[i])
            width = float(error[k] / shifted * panels.width[i] / 8.0) if jumping[k] else 0.0
            height = 2.0 * source.rounding(float(panels.base[i]))
            if not starts_here:
                # the rounding of f hides the jump of f' over a distance
                onset_error[i, 2:] = (height / abs(difference[k]), height) if jumping[k] else (0.0, 0.0)
            elif height > 0.0:
                # where f is known and 0 before, the slope is uncertain only over its hidden rise
                seen[k], width = True, 0.0
                onset_error[i, 2:] = _hidden_rise(made, i, height), height
            onset_error[i, 1] = _UNNAMED * panels.base[i] + width
    jumping = np.abs(difference) > 64.0 * rounding + error
    jump[begins] = np.where(jumping, difference, 0.0)
    jump_error[begins] = rounding + np.maximum(error - made.blur[begins], 0.0)
    # near a slightly misplaced bend f' seems to jump
    slight = np.isin(panels.base[begins], detected) & (
        np.abs(difference) < _SLIGHT * (64.0 * rounding + error)
    )
    jump_error[begins] += np.where(slight, np.abs(difference), 0.0)
    blur = np.array(made.blur)
    blur[begins[seen]] += jump_error[begins[seen]] - rounding[seen]
    jump_error[begins[seen]] = rounding[seen]
    # without a jump, f' is continuous
    correction = np.where(jumping | (made.blur[begins] == 0.0), 0.0, -difference)
    coefficients = np.array(series.coefficients)
    coefficients[begins, 0] += 0.5 * correction
    coefficients[begins, 1] -= 0.5 * correction
    series = replace(series, coefficients=coefficients)
    return replace(made, series=series, jump=jump, jump_error=jump_error, blur=blur, onset_error=onset_error)


def _with_continuous_ends(made: Slopes, begins: IndexArray, uncertainty: FloatArray) -> Slopes:
    """
    Make unresolved panels next to breakpoints end where the next ones begin.

    Their error then matters only on and next to them; further out only the rise of f' over them counts.
    """
    panels, series = made.panels, made.series
    rough = begins[(begins + 1 < panels.count) & (series.power[begins] == 0.0)]
    rough = rough[(panels.base[rough + 1] == panels.base[rough]) & (series.power[rough + 1] == 0.0)]
    missed = (made.error[begins] - uncertainty)[np.isin(begins, rough)]
    unresolved = missed > _MISSED * made.size[rough]
    rough, missed = rough[unresolved], missed[unresolved]
    ends = clenshaw(series.coefficients[rough], np.ones(rough.size))
    starts = clenshaw(series.coefficients[rough + 1], np.zeros(rough.size))
    coefficients, blur = np.array(series.coefficients), np.array(made.blur)
    coefficients[rough, :2] += 0.5 * (starts - ends)[:, None]
    blur[rough] = missed
    return replace(made, series=replace(series, coefficients=coefficients), blur=blur)


def _is_nothing(slopes: Slopes) -> BoolArray:
    """Whether f' on panels is below its error."""
    return np.asarray(slopes.size <= 4.0 * slopes.error)


def _hidden_rise(slopes: Slopes, first: int, height: float) -> float:
    """Distance in m beyond a breakpoint, before which f is flat, over which f rises by less than a height in m."""
    panels = slopes.panels.take(slice(first, None))
    own = np.flatnonzero(panels.base == panels.base[0])
    offset = panels.take(own).offsets(PROBED)
    index = np.repeat(own, PROBED.size)
    f = np.abs(evaluate(panels, slopes.series.take(slice(first, None)), index, offset.ravel()))
    h = offset.ravel()
    k = int(np.argmax(h * f >= height)) if np.any(h * f >= height) else h.size - 1
    if height == 0.0 or not f[k] > 0.0:
        return 0.0 if height == 0.0 else float(h[k])
    i = max(k, 1)
    power = math.log(f[i] / f[i - 1]) / math.log(h[i] / h[i - 1]) if f[i - 1] > 0.0 else 0.0
    return float(h[k] * min((height / (h[k] * f[k])) ** (1.0 / (1.0 + max(power, 0.0))), 1.0))


def _tail_radius(source: SlopeSource, inner: float) -> float:
    """A radius below which only the local power of the tip matters to results at `inner`."""
    inner = max(inner, _LEAST_INNER)
    # powers of very small radii lose their digits, so the search extends only as far as it matters
    for count in _SEARCH_OCTAVES:
        tail_radius = _tail_radius_among(
            source, inner * 2.0 ** -np.arange(float(count)), count == _SEARCH_OCTAVES[-1]
        )
        if tail_radius is not None:
            break
    assert tail_radius is not None
    return tail_radius


def _tail_radius_among(source: SlopeSource, radii: FloatArray, last: bool) -> float | None:
    """The tail radius among some octaves, or None if further ones are needed and these are not the `last`."""
    radii = radii[radii > 1e-300]
    slope = source.sample(np.zeros(radii.size), radii)[0]
    with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
        size = np.abs(slope)
        weight = size * radii / np.max(size[:8] * radii[:8])
        power = -np.diff(np.log(size)) / math.log(2.0)
        change = np.abs(np.diff(np.abs(power), append=np.abs(power[-1])))
    known = np.flatnonzero(size > _TINY)
    if known.size == 0:
        return _octave(radii[min(8, radii.size - 1)])
    deepest = int(known[-1])
    if deepest < size.size - 1 and size[deepest] > _SUDDEN and weight[deepest] > _WEIGHTLESS:
        # not an underflow but a tip with zero slope
        return _octave(radii[min(deepest + 8, radii.size - 1)])
    for k in range(4, deepest - 3):
        # a slope like 1/r has no integral, so it must change further in
        steady = np.all(change[k : k + 3] < 0.5) and power[k] > _FLATTEST - 1.0
        if steady and weight[k] * np.max(change[k : k + 3]) < 1e-17:
            return _octave(radii[k])
    if deepest < 4:
        # so steep that the slope underflows: everything further in is negligible
        return 2.0 * _octave(radii[deepest])
    if not last and deepest == size.size - 1:
        return None
    return _octave(radii[max(min(deepest - 1, 140), 4)])


def _octave(radius: float) -> float:
    """The power of 2 at or below a radius in m."""
    return float(2.0 ** math.floor(math.log2(radius)))


def _tail(slopes: Slopes, tail_radius: float) -> Tail:
    """The power law of f' below the first panel."""
    panels, series = slopes.panels, slopes.series
    u = np.array([0.0, 0.5, 1.0])
    offsets = panels.take(slice(0, 1)).offsets(u)[0]
    values = clenshaw(np.repeat(series.coefficients[:1], u.size, axis=0), u)
    values = values * (offsets / panels.high[0]) ** series.power[0]
    if values[0] == 0.0 or np.any(values[1:] / values[0] <= 0.0):
        power = 0.0
    else:
        power = float(np.log(values[-1] / values[0]) / np.log(offsets[-1] / offsets[0]))
        nearest = round(power * 60.0) / 60.0
        power = nearest if abs(power - nearest) < 1e-9 else power
    return Tail(tail_radius, float(values[0]), power)


def _flat_tail(source: SlopeSource, tail: Tail, slopes: Slopes, inner: float) -> Tail:
    """
    The tail of a tip so flat that the rise of f up to the tail radius matters; it equals that of f where f is known.

    Where only f' is known, the error is the deviation of f' from the power, down to the smallest numbers.
    """
    radius, n = tail.radius, 1.0 + tail.power
    law = tail.slope * radius / n if n >= _FLATTEST else math.inf
    rise, rounded = source.rise(radius)
    if math.isfinite(rise):
        unresolved = rounded
        if not abs(law - rise) <= rounded:
            # beyond the tail radius only the total rise counts
            n = tail.slope * radius / rise if rise else math.inf
            law = rise
    else:
        unresolved = _missed_by_power(source, tail) if n >= _FLATTEST else math.inf
    panels = slopes.panels
    total = abs(law) + float(np.sum(slopes.size * panels.width, where=panels.start < inner))
    if not (_FLATTEST <= n <= 1.0 and unresolved <= _OPEN * total):
        open_ = (
            f", with an uncertainty of {unresolved / total:.1g} of the rise of f (limit {_OPEN:g})"
            if unresolved < total
            else ""
        )
        raise ProblemError(
            f"the tip of the profile is too flat: f ~ r^n, n = {1.0 + tail.power:.3g} at r = {metres(radius)}"
            f"{open_}; exponents from {_FLATTEST:g} are resolved if n is constant there or f is given: give f, or "
            "use PowerLaw(exponent=...)"
        )
    return Tail(radius, tail.slope, n - 1.0, unresolved)


def _missed_by_power(source: SlopeSource, tail: Tail) -> float:
    """Deviation of the rise of f below the tail radius from that of the tail, in m."""
    n, radius = 1.0 + tail.power, tail.radius
    octaves = np.arange(math.floor(math.log2(radius)) + _DEEPEST)
    if octaves.size < _LAST_OCTAVES:
        return math.inf
    r: FloatArray = np.ldexp(radius, -octaves.astype(int))
    with np.errstate(all="ignore"):
        given = np.log(np.abs(source.sample(np.zeros(r.size), r)[0] / tail.slope))
        wrong = given - tail.power * np.log(r / radius)
        # the power may differ further in
        steeper = abs(wrong[-1] - wrong[-_LAST_OCTAVES]) / (math.log(2.0) * (_LAST_OCTAVES - 1) * n)
        fraction = 2.0 ** (-n * octaves)
        missed = np.sum(fraction * np.abs(np.expm1(wrong))) * (1.0 - 2.0**-n) + fraction[-1] * steeper
    return float(np.nan_to_num(missed * abs(tail.slope) * radius / n, nan=math.inf))
