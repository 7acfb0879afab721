"""The contacts of one profile on layers, solved once: series in the radius, made as far as they are asked.

Held are the stiffness and the edge of a flat punch, and depth, force and energy of the smooth contact, all as parts of what
they are on a half-space of the top layer, so that they keep their digits at every radius. Panels are an octave of the
radius or less; behind a corner of the gap series run in the root of the distance.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError, PymdrError
from pymdr.line.layered.equation import WIDEST, Outline, numbers, solve_again, solve_contact
from pymdr.mapping.equivalent import EquivalentProfile, rising_root
from pymdr.mapping.layers import Kernel
from pymdr.mapping.series import Place, as_place, basis, basis_slope, nodes, to_coefficients
from pymdr.units import FloatArray, metres

STIFFNESS, EDGE, DEPTH, FORCE, ENERGY = range(5)
_TERMS = 16
_TESTS = np.array([0.005, 0.13, 0.47, 0.81, 0.995])
"""Where on a panel its series is held against the equation."""
_RESOLVED = 1e-11
"""Residual at which a panel is not divided further."""
_HALVINGS = 6
_WORST = 1e-3
"""Error above which a panel is no result."""
_NEGLIGIBLE = 1e-14
"""What may be left out of small contacts."""
_WIDE = 8.0
"""Ratio of the ends of panels far below the thickness, where the series are all but straight."""
_SHORT = 1e-12
"""How far contacts stay below a limit, in parts of it, so that rounding takes none beyond."""
_BEFORE = 1e-6
"""Distance of the last bound before a fall of g, in parts of its radius."""
_BEHIND = 0.25
"""Length of the panel behind a corner, in parts of its radius."""


@dataclass
class _Panel:
    base: float
    """The corner in m behind which it lies; negative where its variable is the logarithm of the radius."""
    low: float
    high: float
    """Ends of its variable: log a, or the root of a - base."""
    coefficients: FloatArray
    """Shape (5, 16)."""
    error: FloatArray
    """Relative, shape (5,)."""


@dataclass(frozen=True)
class Limit:
    """The largest smooth contact up to which all can be solved, and why none beyond."""

    depth: float
    """d0 in m."""
    load: float
    """F0 per 2 E* in m^2 of a table, in N of a line."""
    error: PymdrError
    """Why no contact beyond is solved."""


@dataclass(eq=False)
class Table:
    """
    The contacts of a profile on a layered body.

    Parameters
    ----------
    equivalent : EquivalentProfile
    kernel : Kernel
    """

    equivalent: EquivalentProfile
    kernel: Kernel
    _panels: dict[float, list[_Panel]] = field(default_factory=dict)
    _ends: dict[float, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.thickness = self.kernel.compliance.thickness
        bent = max(self.kernel.bending, abs(self.kernel.at_zero), 1e-3)
        self.small = self.thickness * (_NEGLIGIBLE / bent) ** (1.0 / 3.0)
        """Radius in m below which the kernel is M(0) everywhere."""
        self.slender = 2.0 / math.pi * self.kernel.at_zero / self.thickness
        """What a punch of radius a is stiffer by, there, per a, in 1/m."""
        self._sort()

    # -- reading ------------------------------------------------------------------------------------

    def read(self, at: Place, which: tuple[int, ...], slopes: bool = False) -> FloatArray:
        """Values of some columns at places, shape (n, columns), or their derivatives by the radius in 1/m."""
        a = at.x
        self._cover(a)
        # no contact is infinitely wide: what is read there only has to leave infinite depths as they are
        found = np.ones((a.size, len(which)))
        below, above = a < self.small, (a >= self.small) & np.isfinite(a)
        if below.any():
            found[below] = self._slender(at.take(below), which, slopes)
        if above.any():
            found[above] = self._series(at.take(above), which, slopes)
        return found

    def error(self, at: Place) -> FloatArray:
        """Relative errors of all columns at places, shape (n, 5)."""
        a = at.x
        self._cover(a)
        found = np.zeros((a.size, 5))
        above = (a >= self.small) & np.isfinite(a)
        if above.any():
            found[above] = self._errors[self._index(a[above])]
        return found

    def _series(self, at: Place, which: tuple[int, ...], slopes: bool) -> FloatArray:
        i = self._index(at.x)
        base, low, width = self._base[i], self._low[i], self._high[i] - self._low[i]
        v, rate = _variable(at, base)
        u = np.clip((v - low) / width, 0.0, 1.0)
        values = (basis_slope if slopes else basis)(u, _TERMS)
        found = np.stack([_sums(self._columns[c].take(i, axis=0), values) for c in which], axis=1)
        return found * (rate / width)[:, None] if slopes else found

    def _slender(self, at: Place, which: tuple[int, ...], slopes: bool) -> FloatArray:
        """Small contacts, where the kernel is M(0) everywhere, to rounding."""
        a, b = at.x, self.slender
        punch = 1.0 / (1.0 - b * a)
        g, m, s = (f(at) for f in (self.equivalent.g, self.equivalent.moment, self.equivalent.squared))
        with np.errstate(divide="ignore", invalid="ignore"):
            depth, energy = np.where(m > 0.0, m / g, 0.0), np.where(m > 0.0, m * m / s, 0.0)
            if not slopes:
                values = [punch, punch, 1.0 - b * depth, np.ones(a.shape), 1.0 - b * energy]
            else:
                # of d0 = g - b m, as a part of g
                rate = np.where(m > 0.0, self.equivalent.slope(at) * (m / g - a) / g, 0.0) * b
                values = [b * punch**2, b * punch**2, rate, np.zeros(a.shape), np.zeros(a.shape)]
        return np.stack([values[c] for c in which], axis=1)

    def _index(self, a: FloatArray) -> np.ndarray:
        return np.maximum(np.searchsorted(self._starts, a, side="right") - 1, 0)

    # -- making -------------------------------------------------------------------------------------

    def _cover(self, a: FloatArray) -> None:
        """Make the panels that some radii need."""
        known = a[(a >= self.small) & np.isfinite(a)]
        if known.size == 0:
            return
        bounds = self.bounds(float(np.max(known)))
        needed = np.unique(np.clip(np.searchsorted(bounds, known, side="right") - 1, 0, bounds.size - 2))
        missing = [i for i in needed if float(bounds[i]) not in self._panels]
        for i in missing:
            self._panels[float(bounds[i])] = self._segment(float(bounds[i]), float(bounds[i + 1]))
        if missing:
            self._sort()

    def _sort(self) -> None:
        panels = [panel for start in sorted(self._panels) for panel in self._panels[start]]
        self._base = np.array([panel.base for panel in panels])
        self._low = np.array([panel.low for panel in panels])
        self._high = np.array([panel.high for panel in panels])
        self._starts = np.array([_place(panel, np.zeros(1)).x[0] for panel in panels])
        stacked = np.array([panel.coefficients for panel in panels]).reshape(-1, 5, _TERMS)
        self._columns = [np.ascontiguousarray(stacked[:, c]) for c in range(5)]
        self._errors = np.array([panel.error for panel in panels]).reshape(-1, 5)

    @property
    def corners(self) -> FloatArray:
        """Breakpoints in m at which g leaves with an infinite slope, or any where there are few."""
        marks = np.array([b for b in self.equivalent.breakpoints if b > self.small])
        if marks.size <= 8:
            return marks
        return marks[np.isinf(self.equivalent.slope(marks))]

    @cached_property
    def end(self) -> float:
        """The end of the profile in m, short of where it is infinite, as that of a sphere is."""
        end = min(self.equivalent.edge, self.equivalent.reach)
        return (1.0 - 1e-4) * end if self._is_endless else end

    @cached_property
    def _is_endless(self) -> bool:
        """Whether g has no bound toward the end of the profile."""
        end = min(self.equivalent.edge, self.equivalent.reach)
        return math.isfinite(end) and not math.isfinite(float(self.equivalent.g(np.array([end]))[0]))

    def _fall(self, top: float) -> float:
        """Radius in m just below the one up to `top` from which g falls; inf where it rises."""
        turning = () if self.equivalent.rises else self.equivalent.turning_points(top)
        return (1.0 - _BEFORE) * turning[0] if turning and turning[0] > self.small else math.inf

    def bounds(self, top: float) -> FloatArray:
        """Rising radii in m between which panels are made, up to beyond `top` or the end of the profile."""
        end, h = self.end, self.thickness
        ends = [self.small]
        top = max(top, end) if self._is_endless else top
        while ends[-1] <= top:
            ratio = _WIDE if ends[-1] * _WIDE < 0.2 * h else 2.0
            ends.append(ends[-1] * ratio)
        for last in (WIDEST * h, self._fall(ends[-1])):
            if last < ends[-1]:
                ends = sorted({*ends, last})
        if self._is_endless:
            # panels shrink toward it as the distance does
            near = end * (1.0 - 0.5 ** np.arange(1.0, 13.0))
            ends = sorted({*(x for x in ends if x < near[0]), *near.tolist()})
        for b in self.corners:
            if b <= ends[-1]:
                ends = [x for x in ends if not 0.9 * b < x < (1.0 + _BEHIND) * b]
                following = self.corners[self.corners > b]
                beyond = min((1.0 + _BEHIND) * b, *(0.5 * (b + following[:1])), math.inf)
                ends = sorted({*ends, float(b), float(beyond)})
        bounds = np.array(ends)
        return np.append(bounds[bounds < end], end) if end <= bounds[-1] else bounds

    def _segment(self, start: float, stop: float) -> list[_Panel]:
        """The panels between two bounds, divided until the equation is met between their nodes."""
        rooted = start in self.corners
        whole = (0.0, math.sqrt(stop - start)) if rooted else (math.log(start), math.log(stop))
        base = start if rooted else -1.0
        todo, done = [(*whole, 0)], []
        while todo:
            low, high, halvings = todo.pop()
            panel, resolved = self._made(base, low, high)
            if resolved or halvings >= _HALVINGS:
                if not float(np.max(panel.error)) <= _WORST:
                    raise ConvergenceError(
                        f"contacts of layers between radii of {metres(start)} and {metres(stop)} err by "
                        f"{float(np.max(panel.error)):.1g}: the profile is not smooth enough there; name its breakpoints, or smooth it"
                    )
                done.append(panel)
            else:
                middle = 0.5 * (low + high)
                todo += [(middle, high, halvings + 1), (low, middle, halvings + 1)]
        return done

    def _made(self, base: float, low: float, high: float) -> tuple[_Panel, bool]:
        panel = _Panel(base, low, high, np.zeros((5, _TERMS)), np.zeros(5))
        u = np.concatenate([nodes(_TERMS), _TESTS])
        at = _place(panel, u)
        # the widest contact tells the nodes that all need
        widest = self._outline(at.take(slice(u.size - 1, None)))
        solved, error, order = solve_contact(self.kernel, widest)
        values = np.array(
            [
                solve_again(self.kernel, self._outline(at.take(slice(i, i + 1))), order)
                for i in range(u.size - 1)
            ]
        )
        values = np.concatenate([values, numbers(solved, widest)[None]])
        panel.coefficients = (to_coefficients(_TERMS) @ values[:_TERMS]).T
        residual = np.abs(basis(_TESTS, _TERMS) @ panel.coefficients.T / values[_TERMS:] - 1.0)
        tail = np.max(np.abs(panel.coefficients[:, -2:]), axis=1) / np.min(np.abs(values), axis=0)
        panel.error = np.maximum(np.max(residual, axis=0), tail) + error
        return panel, bool(np.max(panel.error - error) <= max(_RESOLVED, 3.0 * float(np.max(error))))

    def _outline(self, place: Place) -> Outline:
        return Outline(self.equivalent, self.thickness, place)

    # -- inverses -----------------------------------------------------------------------------------

    def first(self, column: int, target: FloatArray) -> Place:
        """The first place at which d0 in m, or F0 per 2 E* in m^2, has a value; inf where it never has."""
        y = np.asarray(target, dtype=float).ravel()
        places = Place(np.zeros(y.size), np.zeros(y.size))
        places.offset[:] = np.where(np.isnan(y), math.nan, np.where(y > 0.0, math.inf, 0.0))
        open_ = (y > 0.0) & np.isfinite(y)
        if open_.any():
            bounds, values = self._climbed(column, float(np.max(y[open_])))
            self._between(column, y, open_, bounds, values, places)
        shape = np.shape(target)
        return Place(places.base.reshape(shape), places.offset.reshape(shape))

    def rough_radius(self, reached: Callable[[float, float], bool]) -> float:
        """A radius in m near which ``reached(a, d0)`` becomes true, going outward; that of the widest contact if never."""
        bounds = self.bounds(WIDEST * self.thickness)
        for a in bounds[bounds <= WIDEST * self.thickness]:
            if reached(float(a), float(self._at_bound(float(a))[0])):
                return float(a)
        return float(min(bounds[-1], WIDEST * self.thickness))

    def limit(self, is_enough: Callable[[float, float], bool]) -> Limit | None:
        """
        What can be solved, where something on the way to a contact cannot be.

        Parameters
        ----------
        is_enough : callable
            Whether d0 in m and F0 per 2 E* in m^2 are all that is needed.

        Returns
        -------
        Limit or None
            None where all can be solved that is needed.
        """
        depth = moment = a = 0.0
        bounds, i = self.bounds(self.small), 0
        while not is_enough(depth, moment):
            if i == bounds.size:
                bounds = self.bounds(2.0 * float(bounds[-1]))
                if i == bounds.size:
                    return None
            before, a = a, float(bounds[i])
            try:
                found = self._at_bound(a)
                if found[0] < depth:
                    raise _falling(a)
                self._cover(np.array([0.5 * (before + a)]))
                self.refuse_falling(self.equivalent.overlap_radius(float(found[0])))
            except (ConvergenceError, ProblemError) as error:
                deepest = self._before_touching(depth, a)
                if deepest > depth:
                    place = self.first(DEPTH, np.array([deepest]))
                    depth = deepest
                    moment = float((self.equivalent.moment(place) * self.read(place, (FORCE,))[:, 0])[0])
                return Limit((1.0 - _SHORT) * depth, (1.0 - _SHORT) * moment, error)
            depth, moment = map(float, found)
            i += 1
        return None

    def _before_touching(self, depth: float, a: float) -> float:
        """The largest depth in m from one on at which the surfaces do not overlap where g falls, in a contact up to a radius in m."""
        if a not in self._ends or not float(self._ends[a][0]) > depth:
            return depth
        low, high = depth, float(self._ends[a][0])
        for _ in range(40):
            middle = 0.5 * (low + high)
            touching = self.equivalent.overlap_radius(middle)
            low, high = (middle, high) if math.isinf(self._fall(touching)) else (low, middle)
        return low

    def _climbed(self, column: int, top: float) -> tuple[FloatArray, FloatArray]:
        """Bounds up to the first at which a value is reached, and what the column is there."""
        count, bounds = 1, self.bounds(self.small)
        while True:
            value = self._at_bound(float(bounds[count - 1]))[column - DEPTH]
            if value >= top or count == bounds.size:
                more = self.bounds(2.0 * float(bounds[-1])) if value < top else bounds
                if more.size == bounds.size:
                    break
                bounds = more
            count += 1
        bounds = bounds[:count]
        return bounds, np.array([self._at_bound(float(b))[column - DEPTH] for b in bounds])

    def refuse_falling(self, top: float) -> None:
        """
        Refuse a profile that falls on the line.

        Raises
        ------
        ProblemError
            If g falls somewhere up to `top` in m.
        """
        turning = () if self.equivalent.rises else self.equivalent.turning_points(top)
        if turning:
            raise ProblemError(
                f"the equivalent profile falls at r = {metres(turning[0])}: on layers only profiles are followed that rise on the "
                "line; smooth the profile, or take a half-space"
            )

    def _at_bound(self, a: float) -> FloatArray:
        """d0 in m and F0 per 2 E* in m^2 at a bound."""
        if a not in self._ends:
            self.refuse_falling(a)
            place = as_place(np.array([a]))
            g, m = float(self.equivalent.g(place)[0]), float(self.equivalent.moment(place)[0])
            if a <= self.small:
                parts = self._slender(place, (DEPTH, FORCE), False)[0]
            else:
                solved, _, _ = solve_contact(self.kernel, self._outline(place))
                parts = numbers(solved, self._outline(place))[[DEPTH, FORCE]]
            self._ends[a] = np.array([g, m]) * parts
        return self._ends[a]

    def _between(
        self,
        column: int,
        y: FloatArray,
        open_: np.ndarray,
        bounds: FloatArray,
        values: FloatArray,
        places: Place,
    ) -> None:
        if np.any(np.diff(values) < 0.0):
            raise _falling(float(bounds[1:][np.diff(values) < 0.0][0]))
        whole = self.equivalent.g if column == DEPTH else self.equivalent.moment
        low = open_ & (y <= values[0])
        if low.any():
            start = (self.equivalent.inverse if column == DEPTH else self.equivalent.inverse_moment)(
                0.5 * y[low]
            )
            places.offset[low] = rising_root(
                lambda a: whole(a) * self._slender(as_place(a), (column,), False)[:, 0],
                y[low],
                np.minimum(start, self.small),
                np.full(start.shape, self.small),
            )
        rest = np.flatnonzero(open_ & (y > values[0]) & (y <= values[-1]))
        if rest.size == 0:
            return
        segment = np.searchsorted(values, y[rest]) - 1
        self._cover(bounds[np.unique(segment)])
        panels = [panel for i in np.unique(segment) for panel in self._panels[float(bounds[i])]]
        base = np.array([p.base for p in panels])
        ends = np.array([[p.low, p.high] for p in panels])

        def value(i: np.ndarray, v: FloatArray) -> FloatArray:
            at = _from_variable(base[i], v)
            return np.asarray(whole(at) * self._on(panels, i, at, column))

        every = np.arange(len(panels))
        tops = value(every, ends[:, 1])
        which = np.minimum(np.searchsorted(np.maximum.accumulate(tops), y[rest]), every.size - 1)
        low_value, high_value = value(which, ends[which, 0]), value(which, ends[which, 1])
        aim = np.clip(y[rest], np.minimum(low_value, high_value), high_value)
        # panels join to their error; a root beside an end is at it
        v = np.where(aim <= low_value, ends[which, 0], ends[which, 1])
        inside = (aim > low_value) & (aim < high_value)
        if inside.any():
            v[inside] = _roots(value, which[inside], aim[inside], ends[which[inside]])
        found = _from_variable(base[which], v)
        places.base[rest], places.offset[rest] = found.base, found.offset

    def _on(self, panels: list[_Panel], i: np.ndarray, at: Place, column: int) -> FloatArray:
        coefficients = np.array([p.coefficients[column] for p in panels])
        low = np.array([p.low for p in panels])[i]
        width = np.array([p.high - p.low for p in panels])[i]
        v, _ = _variable(at, np.array([p.base for p in panels])[i])
        return _sums(coefficients[i], basis(np.clip((v - low) / width, 0.0, 1.0), _TERMS))


def _falling(a: float) -> ProblemError:
    return ProblemError(
        f"below a contact radius of {metres(a)} the indentation of a smooth contact falls while the contact grows: it is "
        "no disk, and contacts of layers are followed on disks only; use a profile that rises more evenly"
    )


def _roots(
    value: Callable[[np.ndarray, FloatArray], FloatArray],
    which: np.ndarray,
    aim: FloatArray,
    ends: FloatArray,
) -> FloatArray:
    """Where panels have values, each between two ends at which they are less and more."""
    from scipy.optimize import elementwise

    found = elementwise.find_root(
        lambda v, i, y: value(i.astype(np.intp), v) - y, (ends[:, 0], ends[:, 1]), args=(which, aim)
    )
    if not np.all(found.success):
        raise ConvergenceError(f"no contact radius between {ends.min():g} and {ends.max():g} was found")
    return np.asarray(found.x)


def _sums(coefficients: FloatArray, functions: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("nj,nj->n", coefficients, functions))


def _variable(at: Place, base: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The variable of panels at places, and its derivative by the radius."""
    rooted = base >= 0.0
    offset = np.where(at.base == base, at.offset, at.x - base)
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(np.maximum(np.where(rooted, offset, 0.0), 0.0))
        v = np.where(rooted, root, np.log(np.where(rooted, 1.0, at.x)))
        return v, np.where(rooted, 0.5 / root, 1.0 / at.x)


def _from_variable(base: FloatArray, v: FloatArray) -> Place:
    rooted = base >= 0.0
    return Place(np.where(rooted, base, 0.0), np.where(rooted, v * v, np.exp(np.where(rooted, 0.0, v))))


def _place(panel: _Panel, u: FloatArray) -> Place:
    v = panel.low + (panel.high - panel.low) * u
    return _from_variable(np.full(v.shape, panel.base), v)
