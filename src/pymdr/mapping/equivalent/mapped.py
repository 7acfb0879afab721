"""The image of a profile on graded panels, which extends itself: its values and their errors."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import Any

import numpy as np

from pymdr.mapping.abel_sums import AbelSums
from pymdr.mapping.equivalent.base import EquivalentProfile
from pymdr.mapping.equivalent.searching import Search
from pymdr.mapping.images import CURVES, Image, joined_images, map_panels, rooted_copy
from pymdr.mapping.kernels import GradedAbelSums, power_fractions, root_order
from pymdr.mapping.resolving import SlopeSource, anchored_between
from pymdr.mapping.slopes import ABOVE_TAIL, PROBED, ResolvedSlope
from pymdr.numerics.panels import BoolArray, IndexArray, Panels, Place, Position, as_place, clenshaw, evaluate
from pymdr.problem.profiles import Interpolated
from pymdr.units import FloatArray

INWARD = 2.0**-8
"""Factor by which the tip is mapped further inward than requested."""
_SMALLEST = 1e-18
"""Start radius in m of the search for the size of a contact."""
_ROUGH = 0.97
"""Fraction of a value that an approximate image, with an error of 1 %, reaches at the end of the map."""
_SAVED = 2.0**-60
"""Innermost radius of the panels of a saved profile over the requested radius."""
_TRUSTED = 10.0
"""Largest accepted ratio of the deviation of a value to its error."""
WIDER = 2.0**0.25


class MappedProfile(EquivalentProfile):
    """The mapped part of a profile with values and errors; :class:`PanelLine` has the inverses and the integrals."""

    rises = False

    def __init__(
        self,
        source: SlopeSource,
        edge: float = math.inf,
        height: Callable[[FloatArray], FloatArray] | None = None,
        exponent: float = 0.0,
    ) -> None:
        self.exponent = exponent
        self.source = source
        self.edge = edge
        self.height = height
        self._turning: tuple[Image | None, tuple[float, ...]] = (None, ())
        self._resolved = ResolvedSlope(source, min(edge, source.max_radius))
        self._abel: AbelSums | None = None
        self._image: Image | None = None
        self._inner = math.inf
        self._continued = 0.0
        self._lock = threading.RLock()

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_lock"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._lock = threading.RLock()

    def as_panels(self, top: float) -> Interpolated:
        """The slope of the profile on the panels that resolve it, up to at least a radius in m if it goes so far."""
        self.map_to(top, _SAVED * top)
        slope = self._resolved
        assert slope.slopes is not None
        panels, series, tail = slope.slopes.panels, slope.slopes.series, slope.tail
        return Interpolated(
            tuple(panels.base.tolist()),
            tuple(panels.low.tolist()),
            tuple(panels.high.tolist()),
            tuple(series.power.tolist()),
            tuple(tuple(row) for row in series.coefficients.tolist()),
            (tail.radius, tail.slope, tail.power),
            tuple(b for b in slope.knots if b < slope.front),
        )

    # -- how far it is mapped ---------------------------------------------------------------------

    @property
    def max_radius(self) -> float:
        """Largest radius in m at which the profile is known to be defined."""
        return (
            self._resolved.limit if self._resolved.limit < self.source.max_radius else self.source.max_radius
        )

    @property
    def _end(self) -> float:
        return min(self.edge, self._resolved.limit)

    @property
    def front(self) -> float:
        """The radius in m up to which the line is mapped."""
        return 0.0 if self._image is None else float(self._image.panels.stop[-1])

    def map_to(self, x: float, inner: float | None = None) -> Image:
        """The image up to at least `x`, with everything on which values at `inner` and beyond depend."""
        with self._lock:
            x = min(x, self._end)
            inner = min(inner if inner is not None and inner > 0.0 else x, x)
            if (
                self._image is None
                or self.source.continued != self._continued
                or x > self.front
                or (inner < self._inner and not self._resolved.is_power_from(inner))
            ):
                self._extend(x, inner)
            assert self._image is not None
            return self._image

    def _extend(self, x: float, inner: float) -> None:
        slope = self._resolved
        inward = inner < self._inner
        if inward and self._image is not None:
            inner *= INWARD
        knots = list(slope.knots)
        slope.resolve_to(max(x, self.front), min(inner, self._inner))
        assert slope.slopes is not None
        if slope.continued != self._continued:
            # larger radii have shown that nothing but rounding was mapped
            self._image, self._continued = None, slope.continued
        graded = self.exponent != 0.0
        self._abel = (
            GradedAbelSums(slope.slopes, slope.tail, self.exponent)
            if graded
            else AbelSums(slope.slopes, slope.tail)
        )
        if inward or self._image is None:
            settled = self._settled() if knots == slope.knots else None
            stop = slope.front if settled is None else float(settled.panels.start[0])
            panels = self._panels(self._begin, None, stop)
            image = map_panels(self._abel, panels, self._tail_squared(self._begin))
            self._image = image if settled is None else joined_images(image, settled)
        last = self._image.panels
        place = (float(last.base[-1]), float(last.high[-1]))
        # the sum of the two may round to less than the breakpoint at which the last panel ends
        if slope.front - place[0] > place[1]:
            fresh = map_panels(
                self._abel, self._panels(self.front, place, slope.front), self._image.end_squared
            )
            self._image = joined_images(self._image, fresh)
        self._inner = min(self._inner, inner)

    def _settled(self) -> Image | None:
        """The part of the image that an extension inward does not change, with panels not counted from an earlier breakpoint."""
        if self._image is None:
            return None
        panels = self._image.panels
        first = np.flatnonzero((panels.start >= self._inner) & ((panels.base == 0.0) | panels.begins))
        return self._image.take(slice(int(first[0]), None)) if first.size else None

    @property
    def _begin(self) -> float:
        """Begin in m of the first panel of the image; below it the image is a power."""
        slope = self._resolved
        return min([ABOVE_TAIL * slope.tail_radius, *slope.knots[:1]])

    def _panels(self, start: float, place: tuple[float, float] | None, stop: float) -> Panels:
        """The first division of the line between two radii."""
        slope = self._resolved
        base, low = (0.0, start) if place is None else place
        # the sum of a base and an offset may round to another float than the breakpoint there
        if passed := [b for b in slope.knots if base < b and b - base <= low]:
            base, low = passed[-1], 0.0
        knots = np.array([b for b in slope.knots if max(start, base) < b < stop])
        return rooted_copy(anchored_between(base, low, knots, stop, stop), root_order(self.exponent))

    # -- the tip ----------------------------------------------------------------------------------

    def tip_power(self) -> tuple[float, float, float]:
        """n, g_0 in m and x_0 in m of the power g = g_0 (x / x_0)^n below what is mapped; needs a radius that was."""
        tail = self._resolved.tail
        n = tail.power + 1.0
        p = 0.5 * (1.0 + self.exponent)
        factor = 0.5 * math.exp(math.lgamma(0.5 * n) + math.lgamma(p) - math.lgamma(0.5 * n + p))
        return n, factor * tail.slope * tail.radius, tail.radius

    def _tail(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """g, g', m and s below the first panel."""
        n, top, radius = self.tip_power()
        with np.errstate(divide="ignore", invalid="ignore", under="ignore", over="ignore"):
            g = top * (x / radius) ** n
            slope = n * top / radius * (x / radius) ** (n - 1.0)
        slope = np.where((x == 0.0) & (top == 0.0), 0.0, slope)
        first, second = power_fractions(n, self.exponent)
        arm = x ** (1.0 + self.exponent)
        return g, slope, first * arm * g, second * arm * g * g

    def _tail_squared(self, x: float) -> float:
        return float(self._tail(np.array([x]))[3][0])

    # -- values -----------------------------------------------------------------------------------

    def _read(self, x: Position, which: str) -> FloatArray:
        place = as_place(x)
        shape = np.shape(place.offset)
        flat = Place(np.ravel(np.broadcast_to(place.base, shape)), np.ravel(place.offset))
        at = flat.x
        with np.errstate(invalid="ignore"):
            beyond = at > self._end * (1.0 + 1e-12)
        known = np.isfinite(at) & ~beyond
        answer = np.where(at == 0.0, 0.0, math.nan)
        positive = known & (at > 0.0)
        if positive.any():
            inside = flat.take(positive)
            answer[positive] = self._evaluate(self._map_over(inside), inside, which)
            # mapping may have found where the profile ends
            answer[positive & (at > self._end * (1.0 + 1e-12))] = math.nan
        if which == "slope":
            tip = known & (at == 0.0)
            if tip.any():
                answer[tip] = self._slope_on_axis()
        return answer.reshape(shape)

    def _slope_on_axis(self) -> float:
        self.map_to(self._some_radius())
        cusp = float(self.source.sample(np.zeros(1), np.zeros(1))[0][0])
        if self.exponent == 0.0 and 0.0 < abs(cusp) < math.inf:
            # a power in its stead would be 0 or infinite there, however close to 1 its exponent is
            return 0.5 * math.pi * cusp
        return float(self._tail(np.zeros(1))[1][0])

    def _map_over(self, place: Place) -> Image:
        """The image at some places, also beyond a breakpoint to which they round."""
        x = place.x
        last = float(x.max())
        beyond = (x == last) & (place.base == last) & (place.offset > 0.0)
        return self.map_to(math.nextafter(last, math.inf) if beyond.any() else last, float(x.min()))

    def _evaluate(self, image: Image, place: Place, which: str) -> FloatArray:
        index, offset = image.panels.locate(place)
        with np.errstate(invalid="ignore"):
            # before the first panel an offset is negative, and the tail holds
            values = evaluate(image.panels, getattr(image, which), index, offset)
        x = place.x
        low = x < image.panels.start[0]
        if low.any():
            order = ("g", "slope", "moment", "squared").index(which)
            values[low] = self._tail(x[low])[order]
        return values

    def _some_radius(self) -> float:
        """A radius in m at which the profile is or can be mapped."""
        return self.front or self._first_radius()

    def g(self, x: Position) -> FloatArray:
        """Equivalent profile in m; nan beyond what is known."""
        return self._read(x, "g")

    def slope(self, x: Position) -> FloatArray:
        """Slope g'."""
        return self._read(x, "slope")

    def moment(self, x: Position) -> FloatArray:
        """First moment in m^2."""
        return self._read(x, "moment")

    def squared(self, x: Position) -> FloatArray:
        """Integral of (g(x) - g)^2 in m^3."""
        return self._read(x, "squared")

    def error(self, x: Position) -> FloatArray:
        """Measured relative errors of g, g', m and s at places, shape (..., 4)."""
        place = as_place(x)
        at = np.ravel(place.x)
        answer = np.zeros((at.size, 4))
        known = np.isfinite(at) & (at > 0.0) & (at <= self._end * (1.0 + 1e-12))
        if known.any():
            flat = Place(
                np.ravel(np.broadcast_to(place.base, place.x.shape))[known], np.ravel(place.offset)[known]
            )
            image = self._map_over(flat)
            answer[known] = self._errors(image, *image.panels.locate(flat))
        return answer.reshape(*np.shape(place.x), 4)

    def slope_error(self, x: Position) -> FloatArray:
        """Largest relative error of integrals of g' over a contact up to x."""
        place = as_place(x)
        at = place.x
        answer = np.zeros(at.shape)
        known = np.isfinite(at) & (at > 0.0) & (at <= self._end * (1.0 + 1e-12))
        if known.any():
            inside = place.take(known)
            image = self._map_over(inside)
            index = image.panels.locate(inside)[0]
            answer[known] = image.integral_error[index]
        return answer

    def _errors(self, image: Image, index: IndexArray, offset: FloatArray) -> FloatArray:
        """Errors of panels, as much larger as their curves are smaller at offsets in them."""
        errors = image.error[index].copy()
        u = image.panels.variable(index, offset)
        for k, name in enumerate(("g", "slope", "moment", "squared")):
            value = np.abs(clenshaw(getattr(image, name).coefficients[index], u))
            with np.errstate(divide="ignore", invalid="ignore"):
                ratio = np.where(value > 0.0, image.size[index, k] / value, 1.0)
            errors[:, k] *= np.maximum(ratio, 1.0)
        return errors + self._next_to_breakpoints(image, index, offset)

    def _hidden_kinks(
        self, image: Image, index: IndexArray, offset: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """What may be added to g in m just before a located kink, which f may hide over a distance; and its inverse in 1/m."""
        ahead = np.minimum(index + 1, image.panels.count - 1)
        unseen, height = image.onset_error[ahead, 2:].T
        end, k = image.panels.base[ahead], self.exponent
        distance = (end - image.panels.base[index]) - offset
        near = (unseen > 0.0) & (distance > 0.0) & (distance < unseen)
        inverse = np.divide(1.0, unseen, where=near, out=np.zeros(index.size))
        # the integral of the jump of f' with the kernel
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            added = height * end ** (1.0 - k) * (2.0 * end * unseen) ** ((k - 1.0) / 2.0) * 2.0 / (1.0 + k)
        return np.where(near, added, 0.0), inverse

    def _next_to_breakpoints(self, image: Image, index: IndexArray, offset: FloatArray) -> FloatArray:
        """Errors of the curves by the uncertain exponent, or place, of the onset of a profile at a breakpoint."""
        exponent, place, unseen, height = image.onset_error[index].T
        added, inverse = self._hidden_kinks(image, index, offset)
        if not exponent.any() and not place.any() and not inverse.any():
            return np.zeros((index.size, 4))
        base, k = image.panels.base[index], self.exponent
        x = base + offset
        g, slope, m, s = (np.abs(evaluate(image.panels, image.curve(name), index, offset)) for name in CURVES)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            # beyond the first panel the power is no longer extrapolated
            first = (image.panels.low[index] == 0.0) & (exponent > 0.0)
            ratio = np.where(first, np.minimum(offset / image.panels.high[index], 1.0), 1.0)
            spread = exponent * np.abs(np.log(ratio))
            # beyond the stretch on which f rises unseen only that height has an effect, by the kernel and by its slope
            square = offset * (base + x)
            kernel = x ** (1.0 - k) * square ** ((k - 1.0) / 2.0)
            effect = height * kernel * (1.0 + 2.0 * (1.0 - k) * unseen * base / square)
            place = place + np.fmin(unseen, effect / slope) + np.where(added > 0.0, added / slope, 0.0)
            steep = np.maximum(np.abs(image.slope.power[index]), np.where(unseen > 0.0, 2.0, 0.0)) / offset
            steep = np.maximum(steep, inverse)
            rates = np.stack(
                [slope / g, steep, x ** (1.0 + k) * slope / m, 2.0 / (1.0 + k) * m * slope / s], axis=1
            )
            shifted = np.where(place[:, None] > 0.0, place[:, None] * rates, 0.0)
        return np.asarray(spread[:, None] * np.array([1.0, 1.0, 1.0, 2.0]) + np.nan_to_num(shifted))

    def place_error(self, place: Place, of_moment: BoolArray) -> FloatArray:
        """Largest error in m of the places at which g, or the moment, has a value, from all errors."""
        answer = np.zeros(place.x.shape)
        for k, which in ((0, "g"), (2, "moment")):
            rows = np.flatnonzero((of_moment == (which == "moment")) & (place.x < self._end))
            if rows.size:
                answer[rows] = self._away(place.take(rows), which, k) / _TRUSTED
        return answer

    def _away(self, place: Place, which: str, k: int) -> FloatArray:
        """Distances in m within which a curve has its computed values with certainty."""
        last = float(place.x.max())
        targets = getattr(self, which)(place)
        top = last
        while True:
            image = self.map_to(top)
            panels = image.panels
            offset = panels.offsets(PROBED)
            base = np.broadcast_to(panels.base[:, None], offset.shape)
            probes = Place(base.ravel(), offset.ravel())
            index = np.repeat(np.arange(panels.count), PROBED.size)
            values = evaluate(panels, image.curve(which), index, probes.offset)
            wide = _TRUSTED * self._errors(image, index, probes.offset)[:, k] * np.abs(values)
            wide += _TRUSTED * self._hidden(image, offset, k)
            # distances of probes from places keep the digits of the offsets
            distance = (probes.base - place.base[:, None]) + (probes.offset - place.offset[:, None])
            above = np.where((distance >= 0.0) & (values - wide >= targets[:, None]), distance, math.inf)
            below = np.where((distance <= 0.0) & (values + wide <= targets[:, None]), -distance, math.inf)
            outward, inward = above.min(axis=1), np.minimum(below.min(axis=1), place.x)
            if np.isfinite(outward).all() or top >= min(2.0 * last, self._end):
                return np.asarray(np.maximum(outward, inward))
            top = min(top * WIDER, self._end)

    def _hidden(self, image: Image, offset: FloatArray, k: int) -> FloatArray:
        """Errors of g in m, or of the moment, at offsets in panels where it is 0 and has no relative error."""
        assert self._abel is not None
        nothing = image.size[:, k] == 0.0
        answer = np.zeros(offset.shape)
        if nothing.any():
            base = image.panels.base[nothing]
            x = base[:, None] + offset[nothing]
            arm = x ** (1.0 + self.exponent) if k == 2 else 1.0
            answer[nothing] = arm * self._abel.spread_error(base, offset[nothing])
        return answer.ravel()

    # -- the search for a radius ------------------------------------------------------------------

    def _first_radius(self, target: float | None = None, which: str = "g") -> float:
        """A radius at which g (or the moment) is still below a value, found from small radii upward."""
        if self.source.known_everywhere:
            return self._end
        if target is None:
            return 0.5 * self._end if math.isfinite(self._end) else 1.0
        scale = target if which == "g" else target ** (1.0 / (2.0 + self.exponent))
        return self._search.climb(
            _SMALLEST * scale, lambda x, g, m: (g if which == "g" else m) > _ROUGH * target
        )

    def _next_radius(self, target: float, which: str) -> float:
        """A radius beyond the mapped ones, close to the one at which the value is reached."""
        if self.source.known_everywhere:
            return self._end
        slope = self._resolved.slopes
        assert slope is not None
        radii = np.append(slope.panels.start[-96::2], self.front)
        return self._search.up(radii, lambda x, g, m: (g if which == "g" else m) > _ROUGH * target)

    def rough_radius(self, reached: Callable[[FloatArray, FloatArray], BoolArray]) -> float:
        """A radius x in m near which ``reached(x, g(x))`` becomes true, going outward."""
        if self.source.known_everywhere:
            r = self._end * 2.0 ** -np.arange(0.0, 40.0, 0.25)[::-1]
            there = np.flatnonzero(reached(r, self.g(r)))
            return float(r[there[0]]) if there.size else self._end
        return self._search.climb(_SMALLEST, lambda x, g, m: bool(reached(np.array(x), np.array(g))))

    @property
    def _search(self) -> Search:
        return Search(self.source.rough, self._end, self.exponent)
