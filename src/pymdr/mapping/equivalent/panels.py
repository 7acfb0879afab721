"""Inverses, features and surface integrals of the image of a profile on graded panels."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from pymdr.mapping import inverse_map
from pymdr.mapping.equivalent.mapped import INWARD, WIDER, MappedProfile
from pymdr.mapping.equivalent.searching import never_rises
from pymdr.mapping.images import Image
from pymdr.mapping.tree_levels import with_slope
from pymdr.numerics.panels import (
    IndexArray,
    Panels,
    Place,
    Position,
    Selection,
    Series,
    as_place,
    clenshaw,
    evaluate,
)
from pymdr.numerics.roots import rising_root
from pymdr.units import FloatArray, metres

_FALLEN = 256.0
"""Ratio of radii over which a curve is followed beyond its highest value."""
_HOLLOW = 1e6
_NEWTON = 60
_NOTHING = 1e-60
"""Fraction of g below which a decrease is not detected."""
_LAST = 1e-10
"""Relative change of a value by a step of Newton's method below which it is the last one."""
_NEXT_TO = 1e-13
"""Relative change below which steps of Newton's method may be rounding."""
_ENDED = 8.0 * float(np.finfo(float).eps)
"""Rounding of the lower end of a panel, over its distance from the base."""
_FIRST_STEP, _STEP_GROWTH = 1e-9, 64.0
"""The shortest step outward, over the mapped radius, and its growth from step to step."""
_SEARCHED = 2.0**10
"""Distance, in contact radii, up to which a profile without an end is searched for another contact."""


class PanelLine(MappedProfile):
    """
    g, g', its first moment and square integral on panels graded to the tip and to every breakpoint.

    Every value is accurate relative to its own size there, and `error` is the measured error. Mapped panels are kept; a
    place, a depth or a moment beyond it extends the map, outward panel by panel or inward.

    Parameters
    ----------
    source : SlopeSource
        f' of the profile.
    edge : float
        Sharp edge in m that no contact passes.
    height : callable, optional
        f(r), if the profile has it in closed form.
    exponent : float
        k of a power-law graded half-space, -1 < k < 1.
    """

    # -- inverses ---------------------------------------------------------------------------------

    def place(self, depth: ArrayLike) -> Place:
        """The first place at which g(x) = depth; inf where g never gets there."""
        return self._solve(np.asarray(depth, dtype=float), "g")

    def place_of_moment(self, moment: ArrayLike) -> Place:
        """The first place at which the first moment has the given value."""
        return self._solve(np.asarray(moment, dtype=float), "moment")

    def inverse(self, depth: ArrayLike) -> FloatArray:
        """The x in m at which g first is `depth`; inf where it never is."""
        return self.place(depth).x

    def inverse_moment(self, moment: ArrayLike) -> FloatArray:
        """The x in m at which the first moment is `moment`; inf where it never is."""
        return self.place_of_moment(moment).x

    def _solve(self, target: FloatArray, which: str) -> Place:
        flat = np.ravel(target)
        base, offset = np.zeros(flat.shape), np.zeros(flat.shape)
        targets = flat > 0.0
        if targets.any():
            image = self._reaching(float(flat[targets].max()), float(flat[targets].min()), which)
            base[targets], offset[targets] = self._roots(image, flat[targets], which, 0, image.panels.count)
        return Place(base.reshape(target.shape), offset.reshape(target.shape))

    def between(self, depth: FloatArray, low: float, high: float) -> Place:
        """The places between two turning points of g, or the tip, at which g(x) = depth, for a rising stretch."""
        if low == 0.0:
            return self.place(depth)
        image = self.map_to(high)
        first = int(np.searchsorted(image.panels.stop, low, side="right"))
        last = int(np.searchsorted(image.panels.start, high, side="left"))
        base, offset = self._roots(image, depth, "g", first, max(last, first + 1))
        outside = ~((base + offset >= low) & (base + offset <= high))
        if outside.any():
            # the stretch ends inside a panel, whose ends do not bracket what is next to a turning point
            bounds = np.full(int(outside.sum()), low), np.full(int(outside.sum()), high)
            base[outside], offset[outside] = 0.0, rising_root(self.g, depth[outside], *bounds)
        return Place(base, offset)

    def _at_ends(self, image: Image, which: str) -> FloatArray:
        """Values of a curve at the upper ends of the panels."""
        series: Series = getattr(image, which)
        return clenshaw(series.coefficients, np.ones(image.panels.count))

    def _reaching(self, target: float, least: float, which: str) -> Image:
        """The image far enough out for one value, and far enough in for another."""
        with self._lock:
            if self._image is None:
                radius = self._first_radius(target, which)
                self.map_to(radius, INWARD * radius)
            image = self._image
            assert image is not None
            started, step = self.front, _FIRST_STEP
            while float(np.max(self._at_ends(image, which))) < target:
                if self.front >= self._end * (1.0 - 1e-15):
                    break
                ends = self._at_ends(image, which)
                best = int(np.argmax(ends))
                # a hollow end is far below its tip before it rises
                described = ends[best] > 1e-6 * target
                if self.front > (
                    _FALLEN * float(image.panels.stop[best]) if described else _HOLLOW * started
                ):
                    raise never_rises(self.front)
                # rough images of parts that cancel are far too high: short steps grow
                image = self.map_to(max(self._next_radius(target, which), (1.0 + step) * self.front))
                step = min(_STEP_GROWTH * step, WIDER - 1.0)
            ends = self._at_ends(image, which)
            first = int(np.argmax(np.maximum.accumulate(ends) >= least))
            inner = float(image.panels.start[first])
            while first == 0 and self._read_tail(which, inner) > least and inner > 1e-300:
                inner *= INWARD
            return self.map_to(self.front, inner)

    def _read_tail(self, which: str, x: float) -> float:
        return float(self._tail(np.array([x]))[("g", "slope", "moment", "squared").index(which)][0])

    def _roots(
        self, image: Image, target: FloatArray, which: str, first: int, last: int
    ) -> tuple[FloatArray, FloatArray]:
        panels = image.panels
        series: Series = getattr(image, which)
        tops = np.maximum.accumulate(self._at_ends(image, which)[first:last])
        index = first + np.searchsorted(tops, target, side="left")
        beyond = index >= last
        index = np.minimum(index, last - 1)
        start = float(panels.start[0])
        low = (first == 0) & (target <= self._read_tail(which, start))
        base, offset = panels.base[index].copy(), np.empty(target.shape)
        inside = ~beyond & ~low
        if inside.any():
            offset[inside] = _newton(panels, series, index[inside], target[inside])
        if low.any():
            n, top, radius = self.tip_power()
            if which == "moment":
                rise = 1.0 + self.exponent
                n, top = n + rise, n / (n + rise) * radius**rise * top
            base[low] = 0.0
            offset[low] = radius * (target[low] / top) ** (1.0 / n) if top > 0.0 else start
        base[beyond], offset[beyond] = 0.0, math.inf
        return base, offset

    # -- what the curve looks like ----------------------------------------------------------------

    def kinks(self, top: float) -> tuple[float, ...]:
        """Places in m up to `top` to whose right g is not smooth."""
        if top > 0.0:
            self.map_to(top)
        return tuple(b for b in self._resolved.knots if b < top)

    def corners(self, top: float) -> tuple[tuple[float, float], ...]:
        """Kinks of f up to `top` as (radius in m, jump of f'), where f' jumps by more than its error."""
        if top > 0.0:
            self.map_to(top)
        slopes = self._resolved.slopes
        if slopes is None:
            return ()
        noise = 8.0 * np.maximum(slopes.error, np.append(0.0, slopes.error[:-1]))
        jumping = np.flatnonzero((np.abs(slopes.jump) > noise) & (slopes.panels.base < top))
        return tuple(zip(slopes.panels.base[jumping].tolist(), slopes.jump[jumping].tolist(), strict=True))

    def resolving_radii(self, top: float) -> FloatArray:
        """Rising radii in m up to `top` between which g bends little."""
        panels = self.map_to(top).panels
        thick = panels.take(panels.width > 1e-6 * panels.stop)
        offsets = thick.offsets(np.array([0.1, 0.5, 0.9]))
        radii = np.sort((thick.base[:, None] + offsets).ravel())
        return radii[radii < top]

    def turning_points(self, top: float) -> tuple[float, ...]:
        """Places in m up to `top` at which g' changes its sign; 0 where g begins to fall."""
        image = self.map_to(top)
        # the image itself: another may come to lie where it was in memory
        if self._turning[0] is not image:
            self._turning = (image, _turning_points(image, self.front))
        return tuple(x for x in self._turning[1] if x < top)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """All places in m, as far as they are known, to whose right g is not smooth."""
        return tuple(self._resolved.knots)

    def overlap_radius(self, depth: float) -> float:
        """
        The largest radius in m at which the bodies would overlap if they were shifted by a depth in m.

        Contact, where the displacement d - f(r) is positive, lies within it. Beyond the first radius at which
        g = depth the profile is searched to its `max_radius`, or else to 1024 times that radius.
        """
        first = min(float(self.place(np.array([depth])).x[0]), self._end)
        return max(first, self._last_overlap(depth, first))

    def rests_on(self) -> tuple[str, ...]:
        """Text on the basis of the map: the fit of samples, the law of the tip with its radius, and the width of undetected features."""
        text = [self.source.fitted] if self.source.fitted else []
        if self.source.continued > 0.0:
            text.append(
                f"extrapolated below r = {metres(self.source.continued)}, where rounding dominates its values"
            )
        if not self.source.surveyed:
            text.append("features narrower than 1/2500 of their radius may be missed")
        return tuple(text)

    def searched_to(self, depth: float) -> float:
        """Radius in m up to which `overlap_radius` searches at a depth in m."""
        first = float(self.place(np.array([depth])).x[0])
        return min(self._end, _SEARCHED * first)

    def _last_overlap(self, depth: float, first: float) -> float:
        last = min(self._end, _SEARCHED * first)
        if not first < last:
            return first
        r = search_points(first, last)
        with np.errstate(all="ignore"):
            overlapping = self._heights(r) <= depth
        if not overlapping.any():
            return first
        at = int(np.flatnonzero(overlapping)[-1])
        return last if at == r.size - 1 else float(r[at + 1])

    def _heights(self, r: FloatArray) -> FloatArray:
        """F at rising radii beyond the mapped ones, roughly where only its derivative is known."""
        if self.height is not None:
            return self.height(r)
        start = float(2.0 / math.pi * self.gap_integral(np.array([r[0]]), 0.0)[0])
        slope = self.source.sample(np.zeros(r.shape), r)[0]
        steps = 0.5 * np.diff(r) * (slope[1:] + slope[:-1])
        return start + np.concatenate([[0.0], np.cumsum(steps)])

    # -- the way back -----------------------------------------------------------------------------

    def pressure_integral(self, r: Position, a: Position) -> FloatArray:
        """The integral int_r^a g'(x) (x^2 - r^2)^((k-1)/2) dx; inf where it is."""
        radius, edge = as_place(r), as_place(a)
        image = self.map_to(float(edge.x))
        shape = np.shape(radius.offset)
        base = np.ravel(np.broadcast_to(radius.base, shape)).astype(float)
        offset = np.ravel(radius.offset).astype(float)
        stop = (float(edge.base), float(edge.offset))
        inside = (base - stop[0]) + offset < stop[1]
        x = base + offset
        # for k below 0 the centre feels the tip deep inside
        targets = x[inside & ((x > 0.0) | (self.exponent < 0.0))]
        if targets.size:
            image = self.map_to(float(edge.x), max(float(targets.min()), 2.0**-60 * float(edge.x)))
        answer = np.zeros(x.shape)
        part = inverse_map.Stretch(image.tree, (0.0, 0.0), stop)
        answer[inside] = inverse_map.over_root(part, base[inside], offset[inside], self.exponent)
        start = float(image.panels.start[0])
        low = inside & (x < start)
        if low.any():
            top = min(start, float(edge.x))
            n = self.tip_power()[0]
            slope = float(self._tail(np.array([top]))[1][0])
            answer[low] += inverse_map.tail_over_root(n - 1.0, slope, top, x[low], self.exponent)
        return answer.reshape(shape)

    def pressure_between(self, r: FloatArray, low: float, high: float) -> FloatArray:
        """The part of the pressure integral from x = low to high, for r up to low."""
        image = self.map_to(high, low)
        if low < float(image.panels.start[0]):
            return super().pressure_between(r, low, high)
        part = inverse_map.Stretch(image.tree, (0.0, low), (0.0, high))
        return inverse_map.over_root(part, np.zeros(r.shape), r, self.exponent)

    def gap_between(self, r: FloatArray, low: float, high: float) -> FloatArray:
        """The part of the gap integral from x = low to high, for r from high on."""
        image = self.map_to(float(np.max(r, initial=high)), low)
        if low < float(image.panels.start[0]):
            return super().gap_between(r, low, high)
        part = inverse_map.Stretch(image.tree, (0.0, low), (0.0, high))
        return inverse_map.with_arccos(part, np.zeros(r.shape), r, self.exponent)

    def gap_integral(self, r: Position, a: Position) -> FloatArray:
        """The integral int_a^r g'(x) arccos(x / r) dx, or its like for k, beyond a."""
        radius, edge = as_place(r), as_place(a)
        shape = np.shape(radius.offset)
        base = np.ravel(np.broadcast_to(radius.base, shape)).astype(float)
        offset = np.ravel(radius.offset).astype(float)
        x = base + offset
        answer = np.zeros(x.shape)
        start = (float(edge.base), float(edge.offset))
        outside = (base - start[0]) + offset > start[1]
        if not outside.any():
            return answer.reshape(shape)
        image = self.map_to(float(x[outside].max()), float(x[outside].min()))
        last = (float(image.panels.base[-1]), float(image.panels.high[-1]))
        part = inverse_map.Stretch(image.tree, start, last)
        answer[outside] = inverse_map.with_arccos(part, base[outside], offset[outside], self.exponent)
        first = float(image.panels.start[0])
        if start[0] + start[1] < first:
            answer[outside] += self._tail_gap(x[outside], start[0] + start[1], first)
        return answer.reshape(shape)

    def _tail_gap(self, r: FloatArray, a: float, first: float) -> FloatArray:
        """The part of the gap integral below the first panel."""
        n, top, radius = self.tip_power()
        scale, k = top * (r / radius) ** n, self.exponent
        whole = scale * inverse_map.power_with_arccos(n, np.minimum(first, r), r, k)
        if a > 0.0:
            whole -= scale * inverse_map.power_with_arccos(n, np.full(r.shape, a), r, k)
        return np.asarray(whole)

    def displacement_integral(self, r: ArrayLike, a: Position) -> FloatArray:
        """The integral int_0^a g'(x) arcsin(x / r) dx, or its like for k, for r beyond a."""
        edge = as_place(a)
        x = np.ravel(np.asarray(r, dtype=float))
        image = self.map_to(float(edge.x))
        if self.exponent != 0.0:
            return self._graded_displacement(x, edge, image).reshape(np.shape(r))
        stop = (float(edge.base), float(edge.offset))
        part = inverse_map.Stretch(image.tree, (0.0, 0.0), stop)
        answer = inverse_map.with_arcsin(part, np.zeros(x.shape), x)
        first = min(float(image.panels.start[0]), float(edge.x))
        n, top, radius = self.tip_power()
        answer += top * (x / radius) ** n * inverse_map.power_with_arcsin(n, np.full(x.shape, first), x)
        return answer.reshape(np.shape(r))

    def _graded_displacement(self, r: FloatArray, edge: Place, image: Image) -> FloatArray:
        """The displacement integral; next to the contact by the difference of pi/2 and the gap integral."""
        k, stop = self.exponent, (float(edge.base), float(edge.offset))
        part = inverse_map.Stretch(image.tree, (0.0, 0.0), stop)
        first = min(float(image.panels.start[0]), float(edge.x))
        n, top, radius = self.tip_power()
        close = r < 2.0 * float(edge.x)
        answer = np.empty(r.shape)
        for chosen, integral, power in (
            (close, inverse_map.with_arccos, inverse_map.power_with_arccos),
            (~close, inverse_map.with_arcsin, inverse_map.power_with_arcsin),
        ):
            x = r[chosen]
            answer[chosen] = integral(part, np.zeros(x.shape), x, k)
            answer[chosen] += top * (x / radius) ** n * power(n, np.full(x.shape, first), x, k)
        answer[close] = 0.5 * math.pi * self.g(edge) - answer[close]
        return answer


def search_points(low: float, high: float) -> FloatArray:
    """Jittered radii between two others, 2048 in an octave."""
    count = max(64, math.ceil(2048.0 * math.log2(high / low)))
    golden = 0.5 * (math.sqrt(5.0) - 1.0)
    jitter = (0.5 + golden * np.arange(1.0, count + 1.0)) % 1.0
    return np.asarray(low * (high / low) ** ((np.arange(count) + jitter) / count))


def _newton(panels: Panels, series: Series, index: IndexArray, target: FloatArray) -> FloatArray:
    """Offsets at which a series that rises over its panel has the given values, by bracketed Newton steps in u."""
    coefficients, power = series.coefficients[index], series.power[index]
    high, low = panels.high[index], panels.low[index]
    rooted, n = panels.rooted[index], panels.order
    first, last = panels.root(low), panels.root(high)
    ended = np.where(rooted, first / (last - first), low / (high - low))

    def offset_of(u: FloatArray, i: Selection) -> FloatArray:
        root = first[i] + (last[i] - first[i]) * u
        return np.where(rooted[i], root**n, low[i] + (high[i] - low[i]) * u)

    answer_u = np.empty(target.shape)
    left, right = np.zeros(target.shape), np.ones(target.shape)
    u = panels.variable(index, low + (high - low) * _straight(series, index, low / high, target))
    open_ = np.arange(target.size)
    for _ in range(_NEWTON):
        c, rate = with_slope(coefficients[open_], u[open_])
        p, h = power[open_], high[open_]
        delta = offset_of(u[open_], open_)
        rate_of = panels.root(delta) if n == 2.0 else panels.root(delta) ** (n - 1.0)
        stretch = np.where(rooted[open_], n * (last[open_] - first[open_]) * rate_of, h - low[open_])
        with np.errstate(divide="ignore", invalid="ignore", under="ignore", over="ignore"):
            targets = np.where(p != 0.0, target[open_] / (delta / h) ** p, target[open_])
            # the logarithm of a power times a series is nearly straight in that of the offset
            factor = np.exp(np.log(targets / c) / (p + rate * delta / (c * stretch)))
            root = panels.root(delta * factor)
            along = np.where(
                rooted[open_],
                (root - first[open_]) / (last[open_] - first[open_]),
                (delta * factor - low[open_]) / (h - low[open_]),
            )
        above = c > targets
        right[open_] = np.where(above, u[open_], right[open_])
        left[open_] = np.where(above, left[open_], u[open_])
        with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
            new = np.where(p != 0.0, along, u[open_] + (targets - c) / rate)
        # a value that is met steps out of its bracket by rounding, also of where the panel begins, which is no reason to halve it
        near = _NEXT_TO * new + _ENDED * ended[open_]
        bad = ~((new >= left[open_] - near) & (new <= right[open_] + near))
        new = np.where(bad, 0.5 * (left[open_] + right[open_]), np.clip(new, left[open_], right[open_]))
        new = np.where(c == targets, u[open_], new)
        moved = np.abs(new - u[open_])
        u[open_] = new
        settled = moved <= 2e-16 * np.maximum(new, 1e-3)
        # the next step would be of the order of the square
        settled |= ~bad & (moved <= _LAST * new)
        settled |= right[open_] - left[open_] <= 4e-16 * np.maximum(new, 1e-300)
        done = open_[settled]
        answer_u[done] = u[done]
        open_ = open_[~settled]
        if open_.size == 0:
            break
    answer_u[open_] = u[open_]
    return offset_of(answer_u, slice(None))


def _straight(series: Series, index: IndexArray, begin: FloatArray, target: FloatArray) -> FloatArray:
    """Positions in (0, 1) at which straight lines between the ends of panels have some values; `begin` is the lower offset over the upper one."""
    ends = np.array([[1.0], [-1.0]]) ** np.arange(series.coefficients.shape[1])
    last, first = ends @ series.coefficients.T
    with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
        power = series.power[index]
        first = first[index] * np.where(power != 0.0, begin**power, 1.0)
        fraction = (target - first) / (last[index] - first)
    return np.where((fraction > 0.0) & (fraction < 1.0), fraction, 0.5)


def _turning_points(image: Image, top: float) -> tuple[float, ...]:
    """Sign changes of g' beyond its error."""
    panels = image.panels
    fine = np.asarray((np.arange(96) + 0.5) / 96.0, dtype=float)
    offset = panels.offsets(fine)
    index = np.broadcast_to(np.arange(panels.count)[:, None], offset.shape)
    slope = evaluate(panels, image.slope, index.ravel(), offset.ravel())
    x = (panels.base[:, None] + offset).ravel()
    size = np.repeat(np.max(np.abs(slope.reshape(offset.shape)), axis=1), fine.size)
    noise = np.repeat(np.maximum(image.error[:, 1], 1e-13), fine.size) * 4.0 * size
    # a fall that is nothing to g farther out, as numbers that underflow show, turns nothing
    rise = np.abs(slope) * x
    sure = (np.abs(slope) > noise) & (rise > _NOTHING * np.max(rise)) & (x < top)
    x, slope, index = x[sure], slope[sure], index.ravel()[sure]
    if x.size == 0:
        return ()
    places = [0.0] if slope[0] < 0.0 else []
    at = np.flatnonzero(np.sign(slope[1:]) != np.sign(slope[:-1]))
    low, high, before = x[at], x[at + 1], np.sign(slope[at])
    for _ in range(80):
        middle = 0.5 * (low + high)
        if not np.any((low < middle) & (middle < high)):
            break
        i, delta = panels.locate(Place(np.zeros(middle.shape), middle))
        same = np.sign(evaluate(panels, image.slope, i, delta)) == before
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return (*places, *(0.5 * (low + high)).tolist())
