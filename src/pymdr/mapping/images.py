"""The image of a resolved slope on its own panels, with the error of every curve on every panel."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from pymdr.mapping.abel_sums import AbelSums
from pymdr.mapping.octave_panels import GAUSS_NODES
from pymdr.mapping.resolving import Slopes
from pymdr.mapping.tree_levels import PanelTree, panel_tree
from pymdr.numerics.panels import (
    TERMS,
    BoolArray,
    Panels,
    Selection,
    Series,
    basis,
    evaluate,
    joined,
    joined_series,
    nodes,
    to_coefficients,
)
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

_WORK = 1 << 17
_TOLERANCE = 4e-15
_RATE_TOLERANCE = 1e-13
_MANY = 2000
"""Number of initial panels above which larger errors are accepted, such as those of averages over knots."""
_OF_MANY = 256.0
"""Factor by which these errors may be larger."""
_SETTLED = 1e-9
_GENERATIONS = 26
_STEEP, _SPREAD = 8.0, 64.0
_GRADED = 24
_TESTED = 12
_MOST_PENDING = 400
_SPREAD_AT = np.array([0.0, 0.2, 0.6, 1.0])
_UNEVEN, _MATTERS = 4.0, 1e-12
_TOGETHER = 4.0
"""Factor from the error of g, times g over its first moment, to that of s."""
_FELT = 1e-14
"""Error of g' up to which it is not propagated to integrals."""
_FELT_NODES = 8
_MOST_FELT = 1 << 18

CURVES = ("g", "slope", "moment", "squared")


@dataclass(frozen=True)
class Image:
    """g, g', m and s = int_0^x t^k (g(x) - g(t))^2 dt on panels, with their errors."""

    panels: Panels
    g: Series
    slope: Series
    moment: Series
    squared: Series
    error: FloatArray
    """Errors of g, g', m and s on every panel, relative to their absolute integrands, shape (P, 4)."""
    size: FloatArray
    """Largest values of g, g', m and s on every panel, without their powers, shape (P, 4)."""
    end_squared: float
    """s at the upper end in m^3."""
    onset_error: FloatArray
    """Errors of the onset of f' at a breakpoint, as in `Slopes`, shape (P, 4)."""

    def take(self, index: Selection) -> Image:
        """The image on some of the panels, including the last."""
        g, slope, moment, squared = (self.curve(name).take(index) for name in CURVES)
        panels = self.panels.take(index)
        error, size, onset_error = self.error[index], self.size[index], self.onset_error[index]
        return Image(panels, g, slope, moment, squared, error, size, self.end_squared, onset_error)

    def curve(self, name: str) -> Series:
        """One of the curves by its name."""
        curve: Series = getattr(self, name)
        return curve

    @cached_property
    def tree(self) -> PanelTree:
        """The tree of the slope, for integrals over it."""
        return panel_tree(self.panels, self.slope)

    @cached_property
    def integral_error(self) -> FloatArray:
        """
        Errors of integrals of g' over a contact whose edge is on a panel, relative to their absolute integrands.

        The largest of int_r^a |error of g'| K dx / int_r^a |g'| K dx for any r, with the kernel K of the pressure; shape (P,).
        """
        own = self.error[:, 1]
        # the effect of an error on a panel is largest from the start of the panel
        rough = np.flatnonzero(own > _FELT)
        if rough.size == 0 or rough.size * own.size > _MOST_FELT:
            return np.asarray(np.maximum.accumulate(own))
        panels, power = self.panels, self.slope.power[:, None]
        s, weights = gauss(_FELT_NODES)
        t, n = s**panels.order, panels.order
        low, width = panels.low[:, None], panels.width[:, None]
        inside = width * t
        offset = low + inside
        index = np.broadcast_to(np.arange(panels.count)[:, None], offset.shape)
        value = np.abs(evaluate(panels, self.slope, index, offset))
        steep = np.where(power != 0.0, (offset / panels.high[:, None]) ** power, 1.0)
        rest = own[:, None] * self.size[:, 1:2] * steep
        weights = weights * n * s ** (n - 1.0) * width
        worst = np.zeros(panels.count)
        for j in rough.tolist():
            beyond = slice(j, None)
            base, at = panels.base[j], panels.low[j]
            distance = (panels.base[beyond] - base)[:, None] + (offset[beyond] - at)
            distance[0] = inside[j]
            square = distance * (2.0 * (base + at) + distance)
            kernel = weights[beyond] * square ** (1.0 / n - 1.0)
            wrong = np.cumsum(np.sum(rest[beyond] * kernel, axis=1))
            whole = np.cumsum(np.sum(value[beyond] * kernel, axis=1))
            ratio = np.divide(wrong, whole, where=whole > 0.0, out=np.zeros_like(whole))
            worst[beyond] = np.maximum(worst[beyond], ratio)
        before = np.concatenate([[0.0], worst[:-1]])
        return np.asarray(np.maximum(np.maximum(before, own), _FELT))


def map_panels(abel: AbelSums, panels: Panels, squared_below: float) -> Image:
    """
    The image of a slope on adjacent panels, divided where needed.

    Parameters
    ----------
    abel : AbelSums
        Integrals of the slope, resolved to the end of the panels.
    panels : Panels
        Initial panels, rooted after breakpoints.
    squared_below : float
        s at their lower end in m^3.
    """
    u = np.concatenate([nodes(), _tests()])
    pending = panels
    history = np.full(panels.count, math.inf)
    done: list[tuple[Panels, _Fitted]] = []
    for generation in range(_GENERATIONS + 1):
        fit = _fit_image(abel, pending, u)
        worst = np.max(fit.error[:, :3] / fit.allowed, axis=1) / (_OF_MANY if panels.count > _MANY else 1.0)
        stalled = (worst > 0.25 * history) & (np.max(fit.error[:, :3], axis=1) < _SETTLED)
        fits = ((worst <= 1.0) | stalled) & fit.even
        fits |= (generation == _GENERATIONS) | (pending.begins & (generation >= _GRADED))
        fits |= pending.width <= 64.0 * np.finfo(float).eps * pending.low
        # more panels would only resolve noise, which the errors include
        fits |= pending.count > _MOST_PENDING + 2 * panels.count
        done.append((pending.take(fits), fit.take(fits)))
        rest = np.flatnonzero(~fits)
        if rest.size == 0:
            break
        pending, history = _halved(pending.take(rest), worst[rest])
    every = [part for part, _ in done]
    order = np.lexsort((np.concatenate([p.low for p in every]), np.concatenate([p.base for p in every])))
    whole = joined(every).take(order)

    def series(k: int) -> Series:
        return Series(
            np.concatenate([fit.power[:, k] for _, fit in done])[order],
            np.concatenate([fit.coefficients[:, k] for _, fit in done])[order],
        )

    g, slope, moment = series(0), series(1), series(2)
    error = np.concatenate([fit.error for _, fit in done])[order]
    size = np.concatenate([fit.size for _, fit in done])[order]
    misfit = np.concatenate([fit.misfit for _, fit in done])[order]
    spread = np.concatenate([fit.spread for _, fit in done])[order]
    squared, end, missed, stored, size[:, 3] = _squares(whole, slope, moment, squared_below, abel.exponent)
    with np.errstate(divide="ignore", invalid="ignore"):
        # s accumulates its errors from below; errors of f' move g and g' together
        gathered = np.cumsum((misfit[:, 1] + misfit[:, 2]) * stored) + np.maximum.accumulate(
            missed * size[:, 3]
        )
        gathered += _TOGETHER * np.maximum.accumulate(spread * size[:, 0]) * size[:, 2]
        error[:, 3] = np.where(size[:, 3] > 0.0, gathered / size[:, 3], 0.0)
    return Image(whole, g, slope, moment, squared, error, size, end, _onset_errors(abel.slopes, whole))


def _onset_errors(slopes: Slopes, panels: Panels) -> FloatArray:
    """The errors of the onset of f' at breakpoints, on all panels of the image up to the next breakpoint."""
    errors = np.zeros((panels.count, 4))
    source = np.flatnonzero(slopes.panels.begins & slopes.onset_error.any(axis=1))
    for i in source.tolist():
        errors[panels.base == slopes.panels.base[i]] = slopes.onset_error[i]
    return errors


@lru_cache(maxsize=1)
def _tests() -> FloatArray:
    """Points between the nodes, none of them in the middle."""
    inner = 0.5 * (nodes()[1:] + nodes()[:-1])
    return np.concatenate([[0.0008], inner[:: max(1, inner.size // _TESTED)], [0.9991]])


@lru_cache(maxsize=1)
def _test_basis() -> FloatArray:
    return basis(_tests()).T


@lru_cache(maxsize=1)
def _squared_at() -> FloatArray:
    return np.concatenate([nodes(), _tests(), [1.0]])


@dataclass(frozen=True)
class _Fitted:
    power: FloatArray
    coefficients: FloatArray
    error: FloatArray
    size: FloatArray
    allowed: FloatArray
    even: BoolArray
    misfit: FloatArray
    """Misfits of the series of g, g' and m, with the errors of the jumps of f' in g', shape (T, 3)."""
    spread: FloatArray
    """Error of g from those of f', shape (T,)."""

    def take(self, index: Selection) -> _Fitted:
        names = ("power", "coefficients", "error", "size", "allowed", "even", "misfit", "spread")
        return _Fitted(*(getattr(self, name)[index] for name in names))


def _fit_image(abel: AbelSums, panels: Panels, u: FloatArray) -> _Fitted:
    offset = panels.offsets(u)
    sums = abel.sums(panels, u)
    values = np.stack([sums.g, sums.slope, sums.moment], axis=1)
    power = _image_powers(abel, panels, offset, values)
    plain, steep = values.copy(), np.flatnonzero(power.any(axis=1))
    with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
        part = power[steep, :, None]
        scale = np.where(part != 0.0, (offset / panels.high[:, None])[steep, None, :] ** part, 1.0)
        plain[steep] = np.where(scale > 0.0, values[steep] / scale, 0.0)
    coefficients = plain[:, :, :TERMS] @ to_coefficients().T
    misfit = np.max(np.abs(coefficients @ _test_basis() - plain[:, :, TERMS:]), axis=2)
    size = np.max(np.abs(plain), axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.where(size > 0.0, misfit / size, 0.0)
        at = panels.low[:, None] + panels.width[:, None] * _SPREAD_AT
        at[panels.begins, 0] = at[panels.begins, 1]
        # with a power divided out the series represents ratios
        parts = np.where(power[:, :1] != 0.0, (at / panels.high[:, None]) ** power[:, :1], 1.0) * size[:, :1]
        rough = np.where(size[:, :1] > 0.0, abel.spread_error(panels.base, at) / parts, 0.0)
        jumps = abel.jump_error(panels.base, at)
        jumps = np.where(size[:, 1] > 0.0, np.max(jumps, axis=1) / np.max(np.abs(values[:, 1]), axis=1), 0.0)
    # a panel that is rough only at its end, where the profile may end steeply, is divided
    known, spread = np.median(rough[:, 1:], axis=1), np.max(rough, axis=1)
    allowed = np.stack(
        [_TOLERANCE + 4.0 * known, _RATE_TOLERANCE + 64.0 * known + 4.0 * jumps, _TOLERANCE + 4.0 * known],
        axis=1,
    )
    # values of one sign on a panel after a breakpoint must be of one order of magnitude
    lowest, highest = plain.min(axis=2), plain.max(axis=2)
    one_sign = (lowest > 0.0) | (highest < 0.0)
    uneven = one_sign & (size > _SPREAD * np.min(np.abs(plain), axis=2))
    even = ~(panels.begins & uneven.any(axis=1))
    # an error that matters only at the lower end is not assigned to a whole panel
    even &= ~((rough[:, 0] > _UNEVEN * np.max(rough[:, 1:], axis=1)) & (rough[:, 0] > _MATTERS))
    error[:, 1] += jumps
    misfit, error = error, error + spread[:, None] * np.array([1.0, 16.0, 1.0])
    squared_column = ((0, 0), (0, 1))
    return _Fitted(
        power,
        coefficients,
        np.pad(error, squared_column),
        np.pad(size, squared_column),
        allowed,
        even,
        misfit,
        spread,
    )


def _image_powers(abel: AbelSums, panels: Panels, offset: FloatArray, values: FloatArray) -> FloatArray:
    """Powers of g, g' and m: local powers of steep panels, theoretical powers after a breakpoint."""
    first, last = values[:, :, 0], values[:, :, TERMS - 1]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = last / first
        power = np.log(ratio) / np.log(offset[:, TERMS - 1] / offset[:, 0])[:, None]
    steep = np.isfinite(power) & (ratio > 0.0) & ((ratio > _STEEP) | (ratio < 1.0 / _STEEP))
    answer = np.where(steep & ~panels.begins[:, None], power, 0.0)
    source, begins = abel.slopes, {}
    # the kernel raises a power of the distance from a breakpoint by `gain`; its derivative lowers it by `loss`
    gain, loss = 0.5 * (1.0 + abel.exponent), 0.5 * (1.0 - abel.exponent)
    at = np.flatnonzero(source.panels.begins)
    begins = {float(source.panels.base[i]): int(i) for i in at}
    loaded = np.flatnonzero(source.size > 0.0)
    first_loaded = int(loaded[0]) if loaded.size else source.size.size
    for t in np.flatnonzero(panels.begins):
        i = begins.get(float(panels.base[t]))
        if i is None:
            continue
        p, jump = float(source.series.power[i]), float(source.jump[i])
        if abel.tail.slope == 0.0 and i <= first_loaded:
            answer[t] = (p + gain, p - loss, p + gain)
        elif jump != 0.0:
            answer[t, 1] = -loss
        elif 0.0 < p < loss:
            answer[t, 1] = p - loss
    return answer


def _halved(panels: Panels, worst: FloatArray) -> tuple[Panels, FloatArray]:
    """Two panels for each, at the middle of its variable."""
    middle = panels.offsets(np.array([0.5]))[:, 0]
    twice = Panels(
        np.concatenate([panels.base, panels.base]),
        np.concatenate([panels.low, middle]),
        np.concatenate([middle, panels.high]),
        np.concatenate([panels.rooted, panels.rooted]),
        panels.order,
    )
    if panels.order != 2.0:
        # the half next to a breakpoint resembles the whole, which shows nothing about rounding
        worst = np.where(panels.begins, math.inf, worst)
    return twice, np.concatenate([worst, worst])


def _squares(
    panels: Panels, slope: Series, moment: Series, below: float, k: float
) -> tuple[Series, float, FloatArray, FloatArray, FloatArray]:
    """S = 2 / (1 + k) int g' m dt as a series, its last value, its misfit, its variation on panels, and its size."""
    u = _squared_at()
    twice, n = 2.0 / (1.0 + k), panels.order
    increments = np.empty((panels.count, u.size))
    # after a breakpoint the integrand is a power of the variable times a smooth factor
    power = slope.power + moment.power
    lead = np.where(panels.begins, n * power + (n - 1.0), 0.0)
    loaded = np.concatenate([[below > 0.0], moment.coefficients[:-1].any(axis=1)])
    # after a breakpoint with a positive s no relative precision is needed
    plain = (power == 0.0) & (~panels.begins | np.logical_or.accumulate(loaded))
    # other roots than the square root leave no polynomial
    plain &= ~panels.begins | (n == 2.0)
    increments[plain] = twice * _plain_increments(panels.take(plain), slope.take(plain), moment.take(plain))
    for exponent in np.unique(lead[~plain]):
        rows = np.flatnonzero((lead == exponent) & ~plain)
        s, w = gauss(GAUSS_NODES, exponent)
        at = u[:, None] * s
        block = max(1, _WORK // at.size)
        for start in range(0, rows.size, block):
            i = rows[start : start + block]
            product = twice * (slope.coefficients[i] @ basis(at.ravel()).T)
            product *= moment.coefficients[i] @ basis(at.ravel()).T
            begins = panels.begins[i]
            offset = panels.take(i).offsets(at.ravel())
            stretch = panels.take(i).stretch(offset)
            # on a panel that begins at a breakpoint the weights contain the power of the variable
            steep = np.where(
                (power[i] != 0.0)[:, None] & ~begins[:, None], offset / panels.high[i][:, None], 1.0
            )
            steep = steep ** power[i][:, None]
            factor = np.where(begins[:, None], n * panels.high[i][:, None], stretch * steep)
            whole = (product * factor).reshape(i.size, *at.shape) @ w
            increments[i] = whole * u ** (exponent + 1.0)
    ends = below + np.cumsum(increments[:, -1])
    starts = np.concatenate([[below], ends[:-1]])
    values = starts[:, None] + increments
    own = np.where(panels.begins & (starts == 0.0), power + 1.0, 0.0)
    first, last = values[:, 0], values[:, TERMS - 1]
    offset = panels.offsets(u)
    with np.errstate(divide="ignore", invalid="ignore"):
        steep = np.log(last / first) / np.log(offset[:, TERMS - 1] / offset[:, 0])
        use = np.isfinite(steep) & (np.abs(last) > _STEEP * np.abs(first)) & ~panels.begins
        own = np.where(use, steep, own)
        scale = np.where(own[:, None] != 0.0, (offset / panels.high[:, None]) ** own[:, None], 1.0)
        plain = np.where(scale > 0.0, values / scale, 0.0)
    coefficients = plain[:, :TERMS] @ to_coefficients().T
    misfit = np.max(np.abs(coefficients @ _test_basis() - plain[:, TERMS:-1]), axis=1)
    size = np.max(np.abs(plain), axis=1)
    with np.errstate(invalid="ignore"):
        error = np.where(size > 0.0, misfit / size, 0.0)
    moved = np.sum(np.abs(np.diff(increments[:, np.argsort(u)], axis=1, prepend=0.0)), axis=1)
    return Series(own, coefficients), float(ends[-1]), error, moved, size


def _plain_increments(panels: Panels, slope: Series, moment: Series) -> FloatArray:
    """Integrals of g' m from the lower ends of panels on which it is a polynomial of the variable."""
    at, values, integrals = _product_rule()
    low, n = panels.root(panels.low)[:, None], panels.order
    span = panels.root(panels.high)[:, None] - low
    root = low + span * at
    rate = root if n == 2.0 else root ** (n - 1.0)
    stretch = np.where(panels.rooted[:, None], n * span * rate, panels.width[:, None])
    product = (slope.coefficients @ values) * (moment.coefficients @ values) * stretch
    return np.asarray(product @ integrals)


@lru_cache(maxsize=1)
def _product_rule() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points that determine a product of two series and a line, the basis there, and its integrals up to `_squared_at`."""
    n = 2 * TERMS
    u = _squared_at()
    s, weights = gauss(GAUSS_NODES)
    integrals = np.einsum("ijk,j,i->ki", basis(u[:, None] * s, n), weights, u)
    return nodes(n), basis(nodes(n)).T, to_coefficients(n).T @ integrals


def joined_images(first: Image, second: Image) -> Image:
    """Two adjacent images in one."""
    g, slope, moment, squared = (joined_series([first.curve(name), second.curve(name)]) for name in CURVES)
    return Image(
        joined([first.panels, second.panels]),
        g,
        slope,
        moment,
        squared,
        np.concatenate([first.error, second.error]),
        np.concatenate([first.size, second.size]),
        second.end_squared,
        np.concatenate([first.onset_error, second.onset_error]),
    )


def rooted_copy(panels: Panels, order: float) -> Panels:
    """The same panels, rooted after breakpoints."""
    return Panels(panels.base, panels.low, panels.high, panels.base > 0.0, order)
