"""The slope f'(r) of any profile as Chebyshev series on graded panels, each with its measured error.

Panels are anchored at fixed radii, quarter octaves 2^(j/4) m toward the tip and b 2^(j/4) beyond a breakpoint b, so
that they do not depend on how far a path happens to reach. Those that do not resolve the slope are divided.
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
)
from pymdr.numerics.panels import (
    TERMS,
    BoolArray,
    IndexArray,
    clenshaw,
    evaluate,
)
from pymdr.units import FloatArray, metres

_FELT_FROM = 2.0**-12
"""How far below the floor something is looked for that is felt above it, in parts of it."""
MOST_KINKS = 32
_TINY = 1e-290
_AT_END = 1.0 - 1e-15
ABOVE_TAIL = 4.0
"""Radii from which on the image of a slope does not feel how its tip was closed, in radii of the floor."""
_SUDDEN = 1e-200
_WEIGHTLESS = 1e-30
"""Share of a result, below which what a slope is farther in does not matter."""
_FLOORS = 20, 48, 160
"""Octaves in which a floor is looked for, as far as it takes."""
_LEAST_INNER = 1e-280
"""Radius in m from which there are octaves farther in."""
_PURE = 1e-14
_FLAT = 0.5
"""Exponent of f at the tip below which f has risen by something that matters at the floor."""
_DEEPEST, _BESIDE_DEEPEST = 970, 8
"""Octaves below 1 m down to which f' is asked, and those of the last stretch, in which its power is measured."""
_FLATTEST = 1e-3
"""Least such exponent that rules of quadrature take."""
_OPEN = 1e-6
"""Largest share of a result that the law of a flat tip may leave open."""
_UNNAMED = 32.0 * float(np.finfo(float).eps)
"""How far a kink that was found may lie from the true one, in its radius."""
_AHEAD = 1.23
"""How much farther than needed panels may end at a breakpoint."""
_SLIGHT = 32.0
"""Jump at a kink that was found, in what rounding leaves open, up to which there may be none."""
_LEAST_LEAP = 1e-12
_MISSED = 1e-12
"""Misfit of f', in parts of it, from which a panel beside a breakpoint is taken not to resolve it."""
PROBED = np.array([0.03, 0.1, 0.25, 0.5, 0.75, 1.0])
"""Where on a panel a curve is looked at, if it is too uncertain for more."""


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
    """f' of a profile from near its tip to as far as it was asked for, extended when more is asked."""

    source: SlopeSource
    limit: float
    """Last radius in m at which the profile is defined."""
    knots: list[float] = field(init=False)
    slopes: Slopes | None = None
    front: float = 0.0
    """Radius in m up to which the slope is resolved."""
    floor: float = 0.0
    """Radius in m below which it is a power."""
    inner: float = math.inf
    """Radius in m down to which results do not depend on how the tip is closed."""
    tail: Tail = field(init=False)
    _power_from: float = math.inf
    continued: float = 0.0
    """Radius in m below which a law stood for the profile when the slope was resolved."""
    found: list[float] = field(default_factory=list)
    """Kinks in m that were not declared."""

    def __post_init__(self) -> None:
        self.knots = sorted(self.source.knots)

    def _is_felt_below(self, inner: float) -> bool:
        """Whether something below the first panel of an image, which octaves step over, matters to results at a radius in m."""
        assert self.slopes is not None
        if self.floor < 2.0**-40 * inner or self.tail.slope == 0.0:
            return False
        # the floor is a power of two, which scales exactly
        r = self.floor * _below_begin()
        r = r[r < min([self.limit, *self.knots[:1]])]
        given = self.source.sample(np.zeros(r.size), r)[0]
        law = self.tail.slope * (r / self.tail.radius) ** self.tail.power
        panels, last = self.slopes.panels, max(inner, ABOVE_TAIL * self.floor)
        scale = float(
            np.max(self.slopes.size * np.minimum(panels.stop, last), where=panels.start < last, initial=0.0)
        )
        # what is next to an underflow is nothing to anything farther out
        return scale > _SUDDEN and bool(np.max(np.abs(given - law) * r) > 1e-15 * scale)

    def is_power_from(self, x: float) -> bool:
        """Whether the tip goes on as one power, to rounding, from a radius in m up to the first panel."""
        tail = self.tail
        if tail.slope == 0.0 or x >= self._power_from:
            return x >= self._power_from or bool(self.knots and x < self.knots[0])
        deep = max(min(x, self.floor) * 2.0**-8, 1e-290)
        # the image is a power up to there
        r = search_points(deep, min(self._power_from, ABOVE_TAIL * self.floor))
        given = self.source.sample(np.zeros(r.size), r)[0]
        with np.errstate(under="ignore"):
            law = tail.slope * (r / tail.radius) ** tail.power
        if bool(np.all(np.abs(given - law) <= np.maximum(_PURE * np.abs(law), _TINY))):
            self._power_from = deep
            return True
        return False

    def resolve_to(self, x: float, inner: float) -> None:
        """Resolve the slope on radii up to `x`, and as far inward as a result at `inner` depends on it."""
        x = min(x, self.limit)
        if self.source.polish(_AHEAD * x):
            self.knots = sorted({*self.source.knots, *self.found})
        self.source.foresee(x)
        while True:
            # larger radii may show that nothing but rounding was resolved
            if self.slopes is None or inner < self.inner or self.source.continued != self.continued:
                self._begin(x, min(inner, self.inner))
            # where the profile is found to end before, no more is asked
            while self.front < min(x, self.limit) * _AT_END:
                self._extend(x)
            if self.source.continued == self.continued:
                break

    # -- the two ends -----------------------------------------------------------------------------

    def _begin(self, x: float, inner: float) -> None:
        """Resolve from the floor that a result at `inner` needs, and from farther in where that is felt there."""
        start = inner
        self._begin_below(x, start)
        while self._is_felt_below(inner):
            start *= _FELT_FROM
            self._begin_below(x, start)
        self.inner = inner

    def _begin_below(self, x: float, start: float) -> None:
        """Resolve from a floor below a radius in m."""
        self.continued = self.source.continued
        top, last = max(x, self.front), self.floor if self.slopes is not None else math.inf
        while True:
            bottom = min(start, x, *self.knots[:1])
            floor = min(_floor(self.source, bottom), last)
            self.floor, self.front, self.slopes = floor, floor, None
            while self.front < min(top, self.limit):
                self._extend(top)
            # the image begins at the first kink, and is to lie above the tail
            if not self.knots or self.knots[0] >= ABOVE_TAIL * floor:
                break
            last = floor
        assert self.slopes is not None
        self.tail = _tail(self.slopes, floor)
        if self.tail.power < _FLAT - 1.0:
            self.tail = _flat_tail(self.source, self.tail, self.slopes, bottom)
        self._power_from = math.inf

    def _extend(self, x: float) -> None:
        """Append panels up to `x`, or up to the first kink that nobody had named."""
        knots = np.array(self.knots)
        passed, before = np.searchsorted(knots, [self.front, x], side="right")
        before = max(before - (before > 0 and knots[before - 1] == x), passed)
        base = self.knots[passed - 1] if passed else 0.0
        end = min(self.knots[before] if before < knots.size else math.inf, self.limit)
        panels = anchored_between(base, self._front_offset(base), knots[passed:before], min(x, end), end)
        made = resolve(self.source, panels, x, self._felt, self._look_for_kinks)
        if isinstance(made, Stopped):
            self._stopped(made)
            return
        if not self.source.surveyed:
            leaps = _leaps(made, self.slopes)
            if kinks := self._kinks_between(made, leaps):
                if kinks[0] < self.front * (1.0 + FIRST):
                    # no sliver is left between it and the panels before
                    self.slopes, self.front = None, self.floor
                self._stopped(Stopped(kinks))
                return
            made = replace(made, jump_error=np.maximum(made.jump_error, leaps))
        made = _beginning(made, self.slopes, [*self.found, *self.source.moved], self.source)
        self.slopes = made if self.slopes is None else joined_slopes(self.slopes, made)
        # what was divided beyond the radius that is needed has not been taken
        complete = made.panels.high[-1] == panels.high[-1] == end - panels.base[-1]
        self.front = end if complete else float(made.panels.stop[-1])

    @property
    def _felt(self) -> float:
        """About the largest part in m of what is resolved in a value of the image."""
        return 0.0 if self.slopes is None else float(np.max(self.slopes.size * self.slopes.panels.stop))

    def _kinks_between(self, made: Slopes, leaps: FloatArray) -> list[float]:
        """Kinks where panels meet that resolve f' on both sides of them."""
        for i in np.flatnonzero(leaps).tolist():
            edge, base = float(made.panels.start[i]), float(made.panels.base[i])
            before = made.panels if i or self.slopes is None else self.slopes.panels
            # as much on either side, so that what is faint parts from both
            width = float(max(before.width[i - 1], made.panels.width[i]))
            low = max(edge - width, base)
            high = min([edge + width, self.limit, *(b for b in self.knots if b > edge)])
            try:
                found = [b for b in self._look_for_kinks(low, high) if low < b < high]
            except ProblemError:
                # the leap is felt, but nothing that could be named
                continue
            if found:
                return found
        return []

    def _front_offset(self, base: float) -> float:
        """Where the next panel begins, without rounding."""
        if self.slopes is None or self.slopes.panels.base[-1] != base:
            return self.front - base
        return float(self.slopes.panels.high[-1])

    def _look_for_kinks(self, low: float, high: float) -> list[float]:
        soft = self.source.soft_knots
        inside = soft[(soft > low) & (soft < high)]
        if inside.size:
            return list(inside.tolist())
        if len(self.found) >= MOST_KINKS:
            raise ConvergenceError(
                f"the profile has more than {MOST_KINKS} kinks that were not named, the next near r = {metres(low)}; "
                "name them as breakpoints: Function(..., breakpoints=[...])"
            )
        found = self.source.kinks(low, high)
        self.found += found
        return found

    def _stopped(self, made: Stopped) -> None:
        if made.kinks:
            self.knots = sorted({*self.knots, *made.kinks})
            return
        self.limit = made.end
        if self.limit <= self.front:
            raise ConvergenceError(
                f"the profile gives {made.value} at r = {metres(made.end)}; stay inside the radii where it is defined "
                "(Function(..., reach=...) states them)"
            )


def _leaps(made: Slopes, before: Slopes | None) -> FloatArray:
    """By how much f' leaps at the lower ends of panels that follow others, 0 where that may be their errors, shape (P,)."""
    whole = made if before is None else joined_slopes(before.last, made)
    panels, series = whole.panels, whole.series
    # T_j is 1 at the upper and (-1)^j at the lower end
    last = series.coefficients.sum(axis=1)
    first = series.coefficients @ (1.0 - 2.0 * (np.arange(TERMS) % 2))
    steep = np.flatnonzero(series.power)
    with np.errstate(divide="ignore", invalid="ignore"):
        first[steep] *= (panels.low[steep] / panels.high[steep]) ** series.power[steep]
    allowed = 64.0 * np.finfo(float).eps * whole.size + 8.0 * whole.error
    # where f' all but vanishes its rounding is no less than farther in
    allowed += _LEAST_LEAP * np.maximum.accumulate(whole.size * panels.stop) / panels.stop
    apart = np.abs(first[1:] - last[:-1])
    apart = np.where((apart > allowed[1:] + allowed[:-1]) & (panels.low[1:] > 0.0), apart, 0.0)
    return np.append(np.zeros(made.panels.count - apart.size), apart)


@lru_cache(maxsize=1)
def _below_begin() -> FloatArray:
    """Where features below the floor are looked for, in parts of it."""
    return search_points(_FELT_FROM, ABOVE_TAIL)


def _beginning(made: Slopes, before: Slopes | None, found: list[float], source: SlopeSource) -> Slopes:
    """What happens at breakpoints: the jumps of f' with their errors, and how well the places are known."""
    panels = made.panels
    begins = np.flatnonzero(panels.begins)
    if begins.size == 0:
        return made
    made = _closed(made, begins, source.uncertainty(panels.take(begins)))
    series = made.series
    jump, jump_error, beside = np.array(made.jump), np.array(made.jump_error), np.array(made.beside)
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
        if panels.base[i] in found:
            begun = quiet and _is_nothing(made)[:i].all()
            # where two curves meet is as uncertain as their difference, and a shift is felt in parts of what is shifted; the
            # width makes the rounding of f from that of f'
            shifted = abs(difference[k]) if begun else max(size[k], made.size[i])
            width = float(error[k] / shifted * panels.width[i] / 8.0) if jumping[k] else 0.0
            height = 2.0 * source.rounding(float(panels.base[i])) if begun else 0.0
            if height > 0.0:
                # where f, which is nothing before, is known, its slope errs no farther than where it rises unseen
                seen[k], width = True, 0.0
                beside[i, 2:] = _hidden_rise(made, i, height), height
            beside[i, 1] = _UNNAMED * panels.base[i] + width
    jumping = np.abs(difference) > 64.0 * rounding + error
    jump[begins] = np.where(jumping, difference, 0.0)
    jump_error[begins] = rounding + np.maximum(error - made.blur[begins], 0.0)
    # beside its true place a bend seems to jump a little
    slight = np.isin(panels.base[begins], found) & (np.abs(difference) < _SLIGHT * (64.0 * rounding + error))
    jump_error[begins] += np.where(slight, np.abs(difference), 0.0)
    blur = np.array(made.blur)
    blur[begins[seen]] += jump_error[begins[seen]] - rounding[seen]
    jump_error[begins[seen]] = rounding[seen]
    # what does not jump begins where it came from
    lost = np.where(jumping | (made.blur[begins] == 0.0), 0.0, -difference)
    coefficients = np.array(series.coefficients)
    coefficients[begins, 0] += 0.5 * lost
    coefficients[begins, 1] -= 0.5 * lost
    series = replace(series, coefficients=coefficients)
    return replace(made, series=series, jump=jump, jump_error=jump_error, blur=blur, beside=beside)


def _closed(made: Slopes, begins: IndexArray, uncertainty: FloatArray) -> Slopes:
    """
    Panels beside breakpoints that do not resolve f', as powers of the offset that follow a jump, end where the next ones begin.

    What they miss of f' is then felt on them and next to them only: beyond, it is how much f' rises over them that counts.
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
    """On which panels f' is no more than its error."""
    return np.asarray(slopes.size <= 4.0 * slopes.error)


def _hidden_rise(slopes: Slopes, first: int, height: float) -> float:
    """How far in m beyond a breakpoint, before which f is flat, it does not rise by a height in m."""
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


def _floor(source: SlopeSource, inner: float) -> float:
    """A radius below which only the local power of the tip matters to results at `inner`."""
    inner = max(inner, _LEAST_INNER)
    # far below, powers of a radius have no digits left: no farther than it matters
    for count in _FLOORS:
        floor = _floor_among(source, inner * 2.0 ** -np.arange(float(count)), count == _FLOORS[-1])
        if floor is not None:
            break
    assert floor is not None
    return floor


def _floor_among(source: SlopeSource, radii: FloatArray, last: bool) -> float | None:
    """The first of some octaves, or None if farther ones may tell; the `last` ones have to."""
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
        # not an underflow but a tip on which the slope is nothing
        return _octave(radii[min(deepest + 8, radii.size - 1)])
    for k in range(4, deepest - 3):
        # a slope like 1/r has no integral: something else begins farther in
        steady = np.all(change[k : k + 3] < 0.5) and power[k] > _FLATTEST - 1.0
        if steady and weight[k] * np.max(change[k : k + 3]) < 1e-17:
            return _octave(radii[k])
    if deepest < 4:
        # steeper than numbers hold: farther in nothing is left that could be felt
        return 2.0 * _octave(radii[deepest])
    if not last and deepest == size.size - 1:
        return None
    return _octave(radii[max(min(deepest - 1, 140), 4)])


def _octave(radius: float) -> float:
    return float(2.0 ** math.floor(math.log2(radius)))


def _tail(slopes: Slopes, floor: float) -> Tail:
    """The power with which f' goes on below the first panel."""
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
    return Tail(floor, float(values[0]), power)


def _flat_tail(source: SlopeSource, tail: Tail, slopes: Slopes, inner: float) -> Tail:
    """
    The tail of a tip so flat that f has risen noticeably up to the floor: by as much, where f is known.

    Where only f' is known, the error is what f' farther in leaves of the power, down to the smallest numbers.
    """
    radius, n = tail.radius, 1.0 + tail.power
    law = tail.slope * radius / n if n >= _FLATTEST else math.inf
    rise, rounded = source.rise(radius)
    if math.isfinite(rise):
        missed = rounded
        if not abs(law - rise) <= rounded:
            # beyond the floor only the rise counts, not the way there
            n = tail.slope * radius / rise if rise else math.inf
            law = rise
    else:
        missed = _missed_by_power(source, tail) if n >= _FLATTEST else math.inf
    panels = slopes.panels
    felt = abs(law) + float(np.sum(slopes.size * panels.width, where=panels.start < inner))
    if not (_FLATTEST <= n <= 1.0 and missed <= _OPEN * felt):
        open_ = (
            f", and leaves {missed / felt:.1g} of the rise of f open (limit {_OPEN:g})"
            if missed < felt
            else ""
        )
        raise ProblemError(
            f"the tip of the profile is too flat: f starts with r^n, n = {1.0 + tail.power:.3g} at r = {metres(radius)}"
            f"{open_}; exponents from {_FLATTEST:g} are resolved if n is steady there or Function.f is given: give f, or "
            "PowerLaw(exponent=...)"
        )
    return Tail(radius, tail.slope, n - 1.0, missed)


def _missed_by_power(source: SlopeSource, tail: Tail) -> float:
    """What the power of a tail leaves of the rise of f below the floor in m."""
    n, radius = 1.0 + tail.power, tail.radius
    octaves = np.arange(math.floor(math.log2(radius)) + _DEEPEST)
    if octaves.size < _BESIDE_DEEPEST:
        return math.inf
    r: FloatArray = np.ldexp(radius, -octaves.astype(int))
    with np.errstate(all="ignore"):
        given = np.log(np.abs(source.sample(np.zeros(r.size), r)[0] / tail.slope))
        wrong = given - tail.power * np.log(r / radius)
        # the power itself may be another farther in
        steeper = abs(wrong[-1] - wrong[-_BESIDE_DEEPEST]) / (math.log(2.0) * (_BESIDE_DEEPEST - 1) * n)
        share = 2.0 ** (-n * octaves)
        missed = np.sum(share * np.abs(np.expm1(wrong))) * (1.0 - 2.0**-n) + share[-1] * steeper
    return float(np.nan_to_num(missed * abs(tail.slope) * radius / n, nan=math.inf))
