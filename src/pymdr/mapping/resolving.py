"""Chebyshev series of a slope f'(r) on graded panels, which are divided until they resolve it, with measured errors."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Set
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.numerics.panels import (
    TERMS,
    BoolArray,
    Panels,
    Series,
    basis,
    basis_slope,
    joined,
    joined_series,
    nodes,
    to_coefficients,
)
from pymdr.numerics.roots import boundary
from pymdr.units import FloatArray, metres

_RESOLVED = 4e-15
_SOFT = 1e-10
"""Relative misfit allowed across knots of many samples, at least their rounding over their distance."""
_AVERAGED = 4e-10
"""Relative misfit allowed for averages over knots."""
KNOTS_AVERAGED = TERMS**2
"""Least number of knots on a panel for a stable polynomial fit to the heights."""
_BETTER = 0.5
"""Factor by which halving a panel must reduce the error of its average, or else knots are not averaged."""
_ROUNDING = 4.0 * float(np.finfo(float).eps)
"""Relative rounding of known polynomials."""
_SEARCHED = 512
"""Points on a quarter octave at which series are compared with the slope."""
_FEWEST = 48
_GENERATIONS = 36
_KINK_GENERATION = 5
_ROUNDED, _ROUNDED_ALIKE = 2e-14, 1e-12
"""Relative misfit that counts as rounding where dividing does not help; the second if it is uniform over a panel."""
_STEEP = 8.0
"""Ratio of the slopes at the ends of a panel above which its local power is divided out."""
_SPREAD = 64.0
"""Largest ratio of slopes on a panel after a breakpoint."""
_RATIO = 4.0
"""Largest ratio of the offsets from a breakpoint at the ends of a panel that goes on."""
_GRADED = 18
"""Largest number of times that the first panel after a breakpoint is quartered."""
_SLIVER = 0.1
FIRST = 2.0**0.25 - 1.0
"""Width of the first panel after a breakpoint, over its radius."""
_MOST_PANELS = 20_000
_CORRECTIONS = 4
"""Number of powers of the offset that follow the first one after a breakpoint."""
_SIMPLE = 1e-4
"""Largest error of an exponent that is rounded to the nearest simple one."""


class SlopeSource(ABC):
    """The slope of a profile as the input of its resolution."""

    knots: tuple[float, ...]
    """Radii in m at which f' is not smooth."""
    moved: Set[float] = frozenset()
    """Knots in m that were declared at slightly different radii."""
    soft_knots: FloatArray = np.zeros(0)
    """Smooth knots of a piecewise polynomial in m, which matter only if they are few."""
    max_radius: float
    """Largest radius in m."""
    known_everywhere: bool = False
    """Whether f' is cheap to evaluate up to `max_radius`, as for samples."""
    surveyed: bool = False
    """Whether no narrow feature can hide between the points at which f' is evaluated."""

    fitted: str = ""
    """Description of the curve fitted to samples."""

    @abstractmethod
    def sample(self, base: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        """F' at base + offset, and the offsets of the radii at which it was evaluated."""

    @property
    def continued(self) -> float:
        """Radius in m below which a law replaces the values of the profile; 0 without a law."""
        return 0.0

    def polish(self, top: float) -> bool:
        """Move each breakpoint up to `top` in m once to the kink next to it; return whether any has moved."""
        return False

    def foresee(self, top: float) -> None:  # noqa: B027
        """Prepare for radii up to `top` in m."""

    def rough(self, r: FloatArray) -> FloatArray:
        """Approximate f' at radii in m."""
        return self.sample(np.zeros(r.size), r)[0]

    def uncertainty(self, panels: Panels) -> FloatArray:
        """Error of f' on panels that is invisible in its samples, shape (P,)."""
        return np.zeros(panels.count)

    def rounding(self, r: float) -> float:
        """Scatter in m of a differentiated f near a radius in m; 0 where f' is given."""
        return 0.0

    def grain(self, panels: Panels) -> FloatArray:
        """Error of f' on panels from the rounding of samples or of values with few digits; shape (P,)."""
        return np.zeros(panels.count)

    def known_polynomials(self, panels: Panels) -> tuple[BoolArray, Series, FloatArray]:
        """Mask of the panels on which f' is one known polynomial, shape (P,), with its series and its largest size there."""
        return np.zeros(panels.count, dtype=bool), Series(np.zeros(0), np.zeros((0, TERMS))), np.zeros(0)

    def averaged(self, panels: Panels) -> tuple[FloatArray, FloatArray]:
        """Coefficients that average f' over many knots, shape (P, TERMS), and their error in integrals; inf with few knots."""
        return np.zeros((panels.count, TERMS)), np.full(panels.count, math.inf)

    def rise(self, r: float) -> tuple[float, float]:
        """F(r) - f(0) in m and its rounding; NaN where only f' is known."""
        return math.nan, math.nan

    def kinks(self, low: float, high: float) -> list[float]:
        """Undeclared radii between two others at which f' is not smooth."""
        return []


def radii_next_to(knots: tuple[float, ...], base: FloatArray, offset: FloatArray) -> FloatArray:
    """
    Rounded radii in m, each kept on its side of every knot.

    Examples
    --------
    >>> (radii_next_to((1.0,), np.array([1.0, 0.0]), np.array([1e-20, 1.0])) - 1.0).tolist()
    [2.220446049250313e-16, -1.1102230246251565e-16]
    """
    r = base + offset
    on = np.isin(r, knots) if knots else np.zeros(r.shape, dtype=bool)
    if on.any():
        r = np.where(on & (base < r), np.nextafter(r, 0.0), r)
        r = np.where(on & (base == r) & (offset > 0.0), np.nextafter(r, np.inf), r)
    return np.asarray(r)


@dataclass(frozen=True)
class Slopes:
    """f' on panels."""

    panels: Panels
    series: Series
    error: FloatArray
    """Measured error of f' on every panel, shape (P,)."""
    size: FloatArray
    """Largest |f'| on every panel, shape (P,)."""
    jump: FloatArray
    """Jump of f' at the lower end of panels that begin at a breakpoint, else 0; shape (P,)."""
    jump_error: FloatArray
    """Error of that jump, shape (P,)."""
    blur: FloatArray
    """Part of the error of a panel after a breakpoint that does not extend beyond the panel, else 0; shape (P,)."""
    onset_error: FloatArray
    """
    Errors of the onset of f' there: of the exponent, of the place in m, and the width and height in m of a hidden rise of f;
    shape (P, 4).
    """

    @property
    def last(self) -> Slopes:
        """The last panel alone."""
        end = slice(-1, None)
        return Slopes(
            self.panels.take(end), self.series.take(end), *(getattr(self, name)[end] for name in _MEASURED)
        )


_MEASURED = ("error", "size", "jump", "jump_error", "blur", "onset_error")


def joined_slopes(first: Slopes, second: Slopes) -> Slopes:
    """Two adjacent sets of slopes in one."""
    return Slopes(
        joined([first.panels, second.panels]),
        joined_series([first.series, second.series]),
        *(np.concatenate([getattr(first, name), getattr(second, name)]) for name in _MEASURED),
    )


def anchored(base: float, low: float, stop: float, end: float) -> Panels:
    """
    Panels from an offset to at least a radius on the grid of anchors of a base, cut at `end`.

    Parameters
    ----------
    base : float
        Origin of the offsets: a breakpoint in m, or 0.
    low : float
        Offset in m of the lower end of the first panel.
    stop : float
        Radius in m, above the lower end and at most `end`.
    end : float
        Largest radius in m of the panels; a sliver before it is merged with its neighbour.
    """
    if low == 0.0 and end - base <= FIRST * base:
        return _row(base, np.array([0.0, end - base]))
    unit = base if base > 0.0 else 1.0
    first = math.floor(4.0 * math.log2((base + low) / unit) + 1e-6)
    last = math.ceil(4.0 * math.log2(min(stop, 1e300) / unit) - 1e-9)
    j = np.arange(first, max(last, first + 1) + 1)
    grid = base * np.expm1(j * (math.log(2.0) / 4.0)) if base > 0.0 else 2.0 ** (j / 4.0)
    inner = grid[(grid > low * (1.0 + 1e-9)) & (grid > 0.0)]
    edges = np.concatenate([[low], inner])
    if edges[-1] + base >= end * (1.0 - 1e-15) or edges.size < 2:
        edges = np.append(edges[edges + base < end], end - base)
    if math.isfinite(end):
        # a short rest before the end is merged
        step = edges[-1] - edges[-2]
        if end - base - edges[-1] < _SLIVER * step:
            edges[-1] = end - base
        if (
            edges.size > 2
            and edges[-1] == end - base
            and edges[-1] - edges[-2] < _SLIVER * (edges[-2] - edges[-3])
        ):
            edges = np.delete(edges, -2)
    return _row(base, edges)


def without_wide_start(panels: Panels, needed: float) -> Panels:
    """
    Panels, the first of which is divided where it goes on from close to a breakpoint, as far as they begin below a radius in m.

    A power is resolved over any ratio of offsets, but integrals over it are not.

    Examples
    --------
    >>> wide = Panels(np.ones(1), np.array([1e-3]), np.array([0.1]), np.zeros(1, dtype=bool))
    >>> without_wide_start(wide, 1.01).high.tolist()
    [0.004, 0.016]
    """
    base, low, high = float(panels.base[0]), float(panels.low[0]), float(panels.high[0])
    if base == 0.0 or low == 0.0 or high <= _RATIO * low:
        return panels
    count = math.ceil(math.log(high / low, _RATIO) - 1e-6)
    edges = np.append(low * _RATIO ** np.arange(float(count)), high)
    divided = joined([_row(base, edges), panels.take(slice(1, None))])
    # one that is not needed would leave a gap where those before it are divided
    return divided.take(slice(0, max(1, int(np.sum(divided.start < needed)))))


def anchored_between(base: float, low: float, knots: FloatArray, stop: float, end: float) -> Panels:
    """
    Like :func:`anchored`, divided at breakpoints, each of which is the origin of the next offsets.

    Parameters
    ----------
    base, low : float
        Breakpoint in m, or 0, and the offset in m at which the first panel begins.
    knots : ndarray
        Rising radii in m, above `base + low` and below `stop`.
    stop : float
        Radius in m that the last panel reaches.
    end : float
        Largest radius in m of the panels.
    """
    if not knots.size:
        return anchored(base, low, stop, end)
    begin, width = knots[:-1], np.diff(knots)
    wide = np.flatnonzero(width > FIRST * begin)
    parts, first = [anchored(base, low, float(knots[0]), float(knots[0]))], 0
    for i in (*wide.tolist(), begin.size):
        thin = slice(first, i)
        zeros = np.zeros(i - first)
        parts.append(Panels(begin[thin], zeros, width[thin], zeros > 0.0))
        if i < begin.size:
            parts.append(anchored(float(knots[i]), 0.0, float(knots[i + 1]), float(knots[i + 1])))
        first = i + 1
    parts.append(anchored(float(knots[-1]), 0.0, stop, end))
    return joined(parts)


def _row(base: float, edges: FloatArray) -> Panels:
    count = edges.size - 1
    return Panels(np.full(count, base), edges[:-1], edges[1:], np.zeros(count, dtype=bool))


@dataclass(frozen=True)
class Stopped:
    """Why panels could not be resolved: kinks on them, or the end of the profile."""

    kinks: list[float]
    end: float = math.inf
    value: float = math.nan


@lru_cache(maxsize=16)
def _tested(count: int) -> tuple[FloatArray, FloatArray]:
    """Nodes followed by the test points of series, and the basis at the test points."""
    # points in (0, 1) by a Kronecker sequence, on no regular grid
    golden = 0.5 * (math.sqrt(5.0) - 1.0)
    inner = np.sort((0.5 + golden * np.arange(1.0, count + 1.0)) % 1.0)
    # a kink next to the end of a panel is visible only at the end
    u_test = np.concatenate([[1e-7, 1e-4], inner, [1.0 - 1e-4, 1.0 - 1e-7]])
    return np.concatenate([nodes(), u_test]), basis(u_test).T


def resolve(
    source: SlopeSource,
    panels: Panels,
    needed: float,
    inner: float,
    kinks: Callable[[float, float], list[float]],
) -> Slopes | Stopped:
    """Series of f' on panels, divided until they fit; divided panels beyond the needed radius are omitted."""
    known, series, size = source.known_polynomials(panels)
    pending, family = panels.take(~known), np.flatnonzero(~known)
    sizes = inner_size = np.zeros(panels.count)
    sizes[known] = size
    none, onset_error = np.zeros(size.size), np.zeros((size.size, 4))
    done = [Slopes(panels.take(known), series, _ROUNDING * size, size, none, none, none, onset_error)]
    searched: set[int] = set()
    unaveraged: list[float] = []
    soft = source.soft_knots.size > 0
    uniform = np.zeros(panels.count, dtype=bool)
    averages = np.full(pending.count, math.inf)
    for generation in range(_GENERATIONS + 1):
        if not pending.count:
            break
        fit = _fitted(source, pending)
        if isinstance(fit, Stopped):
            return fit
        if generation == 0:
            sizes[family] = fit.size
            # where f' is close to 0 its rounding is no less than further in
            inner_size = np.maximum.accumulate(np.maximum(sizes * panels.stop, inner)) / panels.stop
        # the weight of a thin panel is its largest fraction of an integral with an inverse square root
        fraction = np.sqrt(pending.width / panels.width[family])
        allowed = np.maximum(
            _RESOLVED * fit.size, 1e-17 * sizes[family] / np.maximum(fraction, 1e-300) * (generation > 3)
        )
        fits = (fit.error <= allowed) & fit.even
        hopeless = np.zeros(pending.count, dtype=bool)
        if soft:
            fit, better, error = _averaged(source, pending, fit)
            fits |= better | (fit.error <= np.maximum(_SOFT * fit.size, source.grain(pending)))
            # if halving does not improve the average, the rest is noise
            hopeless, averages = error > _BETTER * averages, error
        if generation >= 2 and not fits.all():
            rest = np.flatnonzero(~fits)
            left = pending.take(rest)
            rounded = np.maximum(8.0 * _noise(source, left), source.grain(left))
            fits[rest] |= (fit.error[rest] <= rounded) & fit.even[rest]
        if generation == _KINK_GENERATION:
            # rounding is uniform over a panel, features are in few parts of it
            missed = np.bincount(family, np.where(fits, 0.0, pending.width), panels.count)
            uniform = missed >= 0.125 * (np.minimum(panels.stop, needed) - panels.start)
        if generation >= _KINK_GENERATION:
            rounded = np.where(uniform[family], _ROUNDED_ALIKE, _ROUNDED)
            fits |= (fit.error <= rounded * np.maximum(fit.size, inner_size[family])) & fit.even
        begins = pending.begins
        thinnest = np.maximum(64.0 * np.finfo(float).eps * pending.base, 1e-300)
        last = (pending.width <= thinnest) | (generation == _GENERATIONS)
        # an unresolved panel acts like a jump
        leap = np.where(last & ~fits, fit.error, 0.0)
        fits |= last | (begins & (generation >= _GRADED))
        taken = pending.take(fits)
        error = fit.error[fits] + source.uncertainty(taken)
        onset_error = np.pad(fit.exponent_error[fits][:, None], ((0, 0), (0, 3)))
        none = np.zeros(taken.count)
        done.append(
            Slopes(taken, fit.series.take(fits), error, fit.size[fits], none, leap[fits], none, onset_error)
        )
        rest = np.flatnonzero(~fits)
        if rest.size == 0:
            break
        soft = source.soft_knots.size > 0
        if generation == _KINK_GENERATION or soft:
            # halves of a panel with many knots may average over them
            few = rest[~_has_many_knots(source.soft_knots, pending.take(rest)) | hopeless[rest]]
            few = rest if generation == _KINK_GENERATION else few
            unresolved = sorted(set(family[few].tolist()) - searched)
            searched.update(unresolved)
            stretches = ((float(panels.start[i]), float(panels.stop[i])) for i in unresolved)
            new_kinks = _kinks_of(kinks, stretches)
            if new_kinks and not soft:
                return Stopped(new_kinks)
            unaveraged += new_kinks
            if new_kinks:
                rest = rest[~np.isin(family[rest], unresolved)]
        averages = np.concatenate([averages[rest], averages[rest]])
        pending, family = _divided(pending.take(rest), family[rest])
        relevant = pending.start < needed
        pending, family, averages = pending.take(relevant), family[relevant], averages[relevant]
        if pending.count > _MOST_PANELS:
            place = metres(float(pending.start.min()))
            raise ConvergenceError(
                f"the slope of the profile is not resolved at r = {place}, where it is rough on every scale; give a smooth "
                "profile, or declare the radii where it is not smooth as breakpoints"
            )
    if unaveraged:
        return Stopped(unaveraged)
    return _in_order(done)


def _averaged(source: SlopeSource, panels: Panels, fit: _Fit) -> tuple[_Fit, BoolArray, FloatArray]:
    """Fits replaced by averages over knots where these are better, the mask of these, and the errors of the averages."""
    coefficients, error = source.averaged(panels)
    better = (error < fit.error) & (error <= _AVERAGED * fit.size)
    series = Series(
        np.where(better, 0.0, fit.series.power),
        np.where(better[:, None], coefficients, fit.series.coefficients),
    )
    return replace(fit, series=series, error=np.where(better, error, fit.error)), better, error


def _in_order(done: list[Slopes]) -> Slopes:
    """Resolved panels in the order of their radii."""
    panels = joined([part.panels for part in done])
    order = np.lexsort((panels.low, panels.base))
    return Slopes(
        panels.take(order),
        joined_series([part.series for part in done]).take(order),
        *(np.concatenate([getattr(part, name) for part in done])[order] for name in _MEASURED),
    )


def _has_many_knots(knots: FloatArray, panels: Panels) -> BoolArray:
    """Whether halves of panels have enough knots for averages."""
    first, last = np.searchsorted(knots, [panels.start, panels.stop])
    return np.asarray(last - first >= 2 * KNOTS_AVERAGED)


def _kinks_of(
    kinks: Callable[[float, float], list[float]], stretches: Iterable[tuple[float, float]]
) -> list[float]:
    """All kinks in stretches that panels do not resolve."""
    located: list[float] = []
    for low, high in stretches:
        try:
            located += [b for b in kinks(low, high) if low < b < high]
        except ProblemError:
            if not located:
                raise
            # the panels change at the kinks already located
            break
    return located


@dataclass(frozen=True)
class _Fit:
    series: Series
    error: FloatArray
    size: FloatArray
    even: np.ndarray
    """Whether values on a panel after a breakpoint are of one order of magnitude."""
    exponent_error: FloatArray


def _fitted(source: SlopeSource, panels: Panels) -> _Fit | Stopped:
    """Series of f' on panels, each tested at a density of 2048 points per octave."""
    with np.errstate(divide="ignore"):
        halvings = np.floor(-np.log2(4.0 * np.log2(panels.stop / panels.start)))
    tests = np.maximum(_SEARCHED * 2.0 ** -np.maximum(halvings, 0.0), _FEWEST).astype(int)
    if np.all(tests == tests[0]):
        return _fitted_at(source, panels, int(tests[0]))
    groups = [np.flatnonzero(tests == count) for count in np.unique(tests)]
    made = [_fitted_at(source, panels.take(group), int(tests[group[0]])) for group in groups]
    stopped = [fit for fit in made if isinstance(fit, Stopped)]
    if stopped:
        return min(stopped, key=lambda stop: stop.end)
    fits = [fit for fit in made if isinstance(fit, _Fit)]
    order = np.argsort(np.concatenate(groups))
    return _Fit(
        joined_series([fit.series for fit in fits]).take(order),
        *(
            np.concatenate([getattr(fit, name) for fit in fits])[order]
            for name in ("error", "size", "even", "exponent_error")
        ),
    )


def _fitted_at(source: SlopeSource, panels: Panels, tests: int) -> _Fit | Stopped:
    u, at_tests = _tested(tests)
    targets = panels.offsets(u)
    base = np.repeat(panels.base, u.size)
    values, actual = source.sample(base, targets.ravel())
    values, actual = values.reshape(targets.shape), actual.reshape(targets.shape)
    size = np.max(np.abs(values), axis=1)
    if not np.isfinite(size).all():
        return _end_of_definition(source, panels, values, targets)
    power, exponent_error = _powers(panels, actual, values)
    plain, largest = values, size
    if power.any():
        with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
            scale = np.where(power[:, None] != 0.0, (actual / panels.high[:, None]) ** power[:, None], 1.0)
            plain = np.where(scale > 0.0, values / scale, 0.0)
    coefficients = plain[:, :TERMS] @ to_coefficients().T
    if panels.base.any():
        # radii next to a breakpoint are rounded, so the nodes move
        moved = (actual - panels.low[:, None]) / panels.width[:, None] - u
        plain = plain - moved * (coefficients @ basis_slope(u).T)
        coefficients = plain[:, :TERMS] @ to_coefficients().T
    misfit = coefficients @ at_tests
    misfit -= plain[:, TERMS:]
    if plain is not values:
        largest = np.max(np.abs(plain), axis=1)
    # with a power divided out the series represents ratios, and the error is relative to the largest slope
    ratio = np.where((size > 0.0) & (largest > 0.0), largest, 1.0)
    error = np.max(np.abs(misfit, out=misfit), axis=1) / ratio * size
    even = ~panels.begins
    adjacent = plain[~even]
    one_sign = (np.min(adjacent, axis=1) > 0.0) | (np.max(adjacent, axis=1) < 0.0)
    even[~even] = ~one_sign | (largest[~even] <= _SPREAD * np.min(np.abs(adjacent), axis=1))
    return _Fit(Series(power, coefficients), error, size, even, exponent_error)


def _powers(panels: Panels, offset: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Local powers of steep slopes, and the powers of slopes that begin at 0 after a breakpoint, with their errors."""
    first, last = values[:, 0], values[:, TERMS - 1]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = last / first
        power = np.log(ratio) / np.log(offset[:, TERMS - 1] / offset[:, 0])
    steep = np.isfinite(power) & (ratio > 0.0) & ((ratio > _STEEP) | (ratio < 1.0 / _STEEP))
    answer = np.where(steep & (panels.low > 0.0), power, 0.0)
    error = np.zeros(panels.count)
    begins = np.flatnonzero(panels.begins & (first != 0.0))
    guesses = _guessed(offset[begins, :TERMS], values[begins, :TERMS])
    for i, guess in zip(begins[guesses != 0.0], guesses[guesses != 0.0], strict=True):
        answer[i], error[i] = _first_power(offset[i, :TERMS], values[i, :TERMS], float(guess))
    return answer, error


def _guessed(offset: FloatArray, values: FloatArray) -> FloatArray:
    """Estimated exponents of slopes that start like offset^p; 0 for others."""
    one_sign = (offset[:, 0] > 0.0) & (np.all(values > 0.0, axis=1) | np.all(values < 0.0, axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        local = np.diff(np.log(np.abs(values[:, :4]))) / np.diff(np.log(offset[:, :4]))
        bend = (local[:, 1] - local[:, 0]) * offset[:, 0] / (offset[:, 1] - offset[:, 0])
        guess = local[:, 0] - bend
        power = one_sign & (np.abs(guess) >= 0.02) & (np.ptp(local, axis=1) <= 0.5 * np.abs(guess))
    return np.where(power, guess, 0.0)


def _first_power(offset: FloatArray, values: FloatArray, guess: float) -> tuple[float, float]:
    """Exponent of a slope that starts like offset^p, and its error."""
    height, size = np.log(offset / offset[-1]), np.log(values / values[-1])
    # log f' = const + p log(offset) + the shortest sufficient series in the offset
    series = np.exp(height)[:, None] ** np.arange(_CORRECTIONS + 1)
    rounding = np.finfo(float).eps * (1.0 + abs(guess))
    for count in range(1, _CORRECTIONS + 2):
        matrix = np.column_stack([height, series[:, :count]])
        inverse = np.linalg.pinv(matrix)
        rest = float(np.max(np.abs(size - matrix @ (inverse @ size))))
        if rest <= 8.0 * rounding:
            break
    power = float(inverse[0] @ size)
    error = 4.0 * max(rest, rounding) * float(np.linalg.norm(inverse[0]))
    # round to simple powers
    simple = round(power * 60.0) / 60.0
    near = abs(power - simple) < max(1e-9, min(error, _SIMPLE))
    return (simple, 0.0) if near else (power, error)


def _divided(panels: Panels, family: np.ndarray) -> tuple[Panels, np.ndarray]:
    """Two panels for each: divided at a quarter after a breakpoint, at the middle elsewhere."""
    fraction = np.where(panels.begins, 0.25, 0.5)
    middle = panels.low + fraction * panels.width
    twice = Panels(
        np.concatenate([panels.base, panels.base]),
        np.concatenate([panels.low, middle]),
        np.concatenate([middle, panels.high]),
        np.concatenate([panels.rooted, panels.rooted]),
    )
    return twice, np.concatenate([family, family])


def _noise(source: SlopeSource, panels: Panels) -> FloatArray:
    """Rounding of the slope on panels: its scatter about very short parabolas; straight lines leave their curvature, 1e-11."""
    steps = np.linspace(-1.0, 1.0, 9)
    away = np.array([0.21, 0.5, 0.83])[:, None] + 1e-5 * steps
    offset = panels.offsets(np.broadcast_to(away.ravel(), (panels.count, away.size)))
    values, _ = source.sample(np.repeat(panels.base, away.size), offset.ravel())
    values = values.reshape(panels.count, 3, steps.size)
    parabola = np.stack([np.ones_like(steps), steps, steps**2], axis=1)
    smooth = values @ (np.linalg.pinv(parabola).T @ parabola.T)
    return np.asarray(np.median(np.max(np.abs(values - smooth), axis=2), axis=1))


def _end_of_definition(
    source: SlopeSource, panels: Panels, values: FloatArray, offset: FloatArray
) -> Stopped:
    """The last radius at which f' is finite, by bisection."""
    at = np.flatnonzero(~np.isfinite(values).all(axis=1))[0]
    bad = offset[at][~np.isfinite(values[at])]
    base, low, high = panels.base[at : at + 1], float(panels.low[at]), float(bad.min())
    value = float(values[at][~np.isfinite(values[at])][0])
    last, _ = boundary(lambda r: np.isfinite(source.sample(base, r)[0]), np.array([low]), high)
    return Stopped([], float(base[0] + last[0]), value)
