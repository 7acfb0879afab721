"""The contacts of one profile on layers as series in the radius, extended on demand.

The table contains the stiffness and the edge of a flat punch, and depth, force and energy of the smooth contact, all
relative to a half-space of the top layer, which avoids cancellation at every radius. Panels are at most an octave of the
radius; after a corner of the gap the series are in the root of the distance.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError, PymdrError
from pymdr.line.layered.equation import WIDEST, Outline, numbers, solve_at_order, solve_contact
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.mapping.layers import Kernel
from pymdr.numerics.panels import (
    TERMS,
    BoolArray,
    Panels,
    Place,
    Series,
    as_place,
    basis,
    evaluate,
    evaluate_slope,
    joined,
    nodes,
    to_coefficients,
)
from pymdr.numerics.roots import boundary, rising_root, roots_of
from pymdr.units import FloatArray, metres

STIFFNESS, EDGE, DEPTH, FORCE, ENERGY = range(5)
_TESTS = np.array([0.005, 0.13, 0.47, 0.81, 0.995])
"""Positions on a panel at which its series is compared with the equation."""
_RESOLVED = 1e-11
"""Residual at which a panel is not divided further."""
_HALVINGS = 6
_WORST = 1e-3
"""Largest accepted error of a panel."""
_NEGLIGIBLE = 1e-14
"""Relative size of the terms that are neglected in small contacts."""
_WIDE = 8.0
"""Ratio of the ends of panels far below the thickness, where the series are all but straight."""
_SHORT = 1e-12
"""Relative distance of contacts below a limit, so that rounding does not exceed it."""
_BEFORE = 1e-6
"""Distance of the last bound before a decrease of g, over its radius."""
_BEHIND = 0.25
"""Length of the panel behind a corner, over its radius."""


@dataclass(frozen=True)
class _Segment:
    """Panels between two bounds."""

    panels: Panels
    coefficients: FloatArray
    """Shape (P, 5, TERMS)."""
    error: FloatArray
    """Relative, shape (P, 5)."""


@dataclass(frozen=True)
class Limit:
    """The largest smooth contact up to which all contacts can be solved, and the error beyond it."""

    depth: float
    """d0 in m."""
    load: float
    """F0 per 2 E* in m^2 of a table, in N of a line."""
    error: PymdrError
    """The error of the next larger contact."""


@dataclass(eq=False)
class Table:
    """The contacts of a profile on a layered body."""

    equivalent: EquivalentProfile
    kernel: Kernel
    _segments: dict[float, _Segment] = field(default_factory=dict)
    _ends: dict[float, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.thickness = self.kernel.compliance.thickness
        bent = max(self.kernel.bending, abs(self.kernel.at_zero), 1e-3)
        self.small = self.thickness * (_NEGLIGIBLE / bent) ** (1.0 / 3.0)
        """Radius in m below which the kernel is M(0) everywhere."""
        self.slender = 2.0 / math.pi * self.kernel.at_zero / self.thickness
        """Relative increase of the stiffness of a punch of radius a there, divided by a, in 1/m."""
        self._sort()

    # -- reading ------------------------------------------------------------------------------------

    def read(self, at: Place, which: tuple[int, ...], slopes: bool = False) -> FloatArray:
        """Values of some columns at places, shape (n, columns), or their derivatives by the radius in 1/m."""
        a = at.x
        self._cover(a)
        # no contact is infinitely wide: what is read there only has to leave infinite depths as they are
        values = np.ones((a.size, len(which)))
        below, above = a < self.small, (a >= self.small) & np.isfinite(a)
        if below.any():
            values[below] = self._slender(at.take(below), which, slopes)
        if above.any():
            values[above] = self._series(at.take(above), which, slopes)
        return values

    def error(self, at: Place) -> FloatArray:
        """Relative errors of all columns at places, shape (n, 5)."""
        a = at.x
        self._cover(a)
        errors = np.zeros((a.size, 5))
        above = (a >= self.small) & np.isfinite(a)
        if above.any():
            errors[above] = self._whole.error[self._whole.panels.locate(at.take(above))[0]]
        return errors

    def _series(self, at: Place, which: tuple[int, ...], slopes: bool) -> FloatArray:
        panels = self._whole.panels
        index, offset = panels.locate(at)
        read = evaluate_slope if slopes else evaluate
        return np.stack([read(panels, self._columns[c], index, offset) for c in which], axis=1)

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

    # -- making -------------------------------------------------------------------------------------

    def _cover(self, a: FloatArray) -> None:
        """Make the panels that some radii need."""
        known = a[(a >= self.small) & np.isfinite(a)]
        if known.size == 0:
            return
        bounds = self.bounds(float(np.max(known)))
        needed = np.unique(np.clip(np.searchsorted(bounds, known, side="right") - 1, 0, bounds.size - 2))
        missing = [i for i in needed if float(bounds[i]) not in self._segments]
        for i in missing:
            self._segments[float(bounds[i])] = self._segment(float(bounds[i]), float(bounds[i + 1]))
        if missing:
            self._sort()

    def _sort(self) -> None:
        parts = [self._segments[start] for start in sorted(self._segments)]
        if parts:
            self._whole = _joined(parts)
            self._columns = _columns(self._whole)

    @property
    def corners(self) -> FloatArray:
        """Breakpoints in m at which g leaves with an infinite slope, or any where there are few."""
        marks = np.array([b for b in self.equivalent.breakpoints if b > self.small])
        if marks.size <= 8:
            return marks
        return marks[np.isinf(self.equivalent.slope(marks))]

    @cached_property
    def end(self) -> float:
        """The end of the profile in m, below the radius at which it is infinite, such as that of a sphere."""
        end = min(self.equivalent.edge, self.equivalent.max_radius)
        return (1.0 - 1e-4) * end if self._is_endless else end

    @cached_property
    def _is_endless(self) -> bool:
        """Whether g is unbounded toward the end of the profile."""
        end = min(self.equivalent.edge, self.equivalent.max_radius)
        return math.isfinite(end) and not math.isfinite(float(self.equivalent.g(np.array([end]))[0]))

    def _fall(self, top: float) -> float:
        """Radius in m just below the one up to `top` from which g decreases; inf where it rises."""
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

    def _segment(self, start: float, stop: float) -> _Segment:
        """The panels between two bounds, divided until the equation is met between their nodes."""
        behind = np.array([start in self.corners])
        low, high = (0.0, stop - start) if behind[0] else (start, stop)
        base = np.where(behind, start, 0.0)
        todo, done = [(Panels(base, np.array([low]), np.array([high]), behind), 0)], []
        while todo:
            panel, halvings = todo.pop()
            made, resolved = self._made(panel)
            if resolved or halvings >= _HALVINGS:
                if not float(np.max(made.error)) <= _WORST:
                    raise ConvergenceError(
                        f"the relative error of contacts on layers with radii from {metres(start)} to {metres(stop)} is "
                        f"{float(np.max(made.error)):.1g}: the profile is not smooth enough there; declare its breakpoints, or smooth it"
                    )
                done.append(made)
            else:
                middle = panel.offsets(np.array([0.5]))[:, 0]
                lower, upper = replace(panel, high=middle), replace(panel, low=middle)
                todo += [(upper, halvings + 1), (lower, halvings + 1)]
        return _joined(done)

    def _made(self, panel: Panels) -> tuple[_Segment, bool]:
        u = np.concatenate([nodes(), _TESTS])
        at = Place(np.full(u.shape, panel.base[0]), panel.offsets(u)[0])
        # the widest contact needs the most nodes
        widest = self._outline(at.take(slice(u.size - 1, None)))
        solved, error, order = solve_contact(self.kernel, widest)
        values = np.array(
            [
                solve_at_order(self.kernel, self._outline(at.take(slice(i, i + 1))), order)
                for i in range(u.size - 1)
            ]
        )
        values = np.concatenate([values, numbers(solved, widest)[None]])
        coefficients = (to_coefficients() @ values[:TERMS]).T
        residual = np.abs(basis(_TESTS) @ coefficients.T / values[TERMS:] - 1.0)
        tail = np.max(np.abs(coefficients[:, -2:]), axis=1) / np.min(np.abs(values), axis=0)
        missed = np.maximum(np.max(residual, axis=0), tail)
        resolved = bool(np.max(missed) <= max(_RESOLVED, 3.0 * float(np.max(error))))
        return _Segment(panel, coefficients[None], (missed + error)[None]), resolved

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

    def rough_radius(self, reached: Callable[[FloatArray, FloatArray], BoolArray]) -> float:
        """A radius in m near which ``reached(a, d0)`` becomes true, going outward; that of the widest contact if never."""
        bounds = self.bounds(WIDEST * self.thickness)
        a = 0.0
        for bound in bounds[bounds <= WIDEST * self.thickness].tolist():
            a = (1.0 - _SHORT) * bound
            if reached(np.array(a), self._at_bound(bound)[0]):
                break
        return a

    def limit(self, is_enough: Callable[[float, float], bool]) -> Limit | None:
        """
        The deepest contact that can be solved, if a smaller one than the required contact cannot be.

        Parameters
        ----------
        is_enough : callable
            Whether d0 in m and F0 per 2 E* in m^2 reach the required contact.

        Returns
        -------
        Limit or None
            None if all contacts up to the required one can be solved.
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
                bound = self._at_bound(a)
                if bound[0] < depth:
                    raise _falling(a)
                self._cover(np.array([0.5 * (before + a)]))
                self.refuse_falling(self.equivalent.overlap_radius(float(bound[0])))
            except (ConvergenceError, ProblemError) as error:
                deepest = self._before_touching(depth, a)
                if deepest > depth:
                    place = self.first(DEPTH, np.array([deepest]))
                    depth = deepest
                    moment = float((self.equivalent.moment(place) * self.read(place, (FORCE,))[:, 0])[0])
                return Limit((1.0 - _SHORT) * depth, (1.0 - _SHORT) * moment, error)
            depth, moment = map(float, bound)
            i += 1
        return None

    def _before_touching(self, depth: float, a: float) -> float:
        """The largest depth in m from one on at which the surfaces do not overlap where g falls, in a contact up to a radius in m."""
        if a not in self._ends or not float(self._ends[a][0]) > depth:
            return depth

        def rises(d: FloatArray) -> BoolArray:
            return np.array(math.isinf(self._fall(self.equivalent.overlap_radius(float(d)))))

        return float(boundary(rises, depth, float(self._ends[a][0]), within=1e-12)[0])

    def _climbed(self, column: int, top: float) -> tuple[FloatArray, FloatArray]:
        """Bounds up to the first at which a value is reached, and the column there."""
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
        """Refuse an equivalent profile that decreases."""
        turning = () if self.equivalent.rises else self.equivalent.turning_points(top)
        if turning:
            raise ProblemError(
                f"the equivalent profile decreases at r = {metres(turning[0])}, but layers need a rising one; smooth the profile, or "
                "use a half-space"
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
        between = np.unique(np.searchsorted(values, y[rest]) - 1)
        self._cover(bounds[between])
        chosen = _joined([self._segments[float(bounds[i])] for i in between])
        panels, part = chosen.panels, _columns(chosen)[column]

        def value(offset: FloatArray, i: np.ndarray) -> FloatArray:
            at = Place(panels.base[i], offset)
            return np.asarray(whole(at) * evaluate(panels, part, i, offset))

        every = np.arange(panels.count)
        tops = np.maximum.accumulate(value(panels.high, every))
        which = np.minimum(np.searchsorted(tops, y[rest]), every.size - 1)
        low_value, high_value = value(panels.low[which], which), value(panels.high[which], which)
        aim = np.clip(y[rest], np.minimum(low_value, high_value), high_value)
        # panels join to their error; a root beside an end is at it
        offset = np.where(aim <= low_value, panels.low[which], panels.high[which])
        inside = (aim > low_value) & (aim < high_value)
        i = which[inside]
        offset[inside] = roots_of(
            lambda x, i, y: value(x, i.astype(np.intp)) - y, panels.low[i], panels.high[i], i, aim[inside]
        )
        places.base[rest], places.offset[rest] = panels.base[which], offset


def _joined(parts: list[_Segment]) -> _Segment:
    return _Segment(
        joined([part.panels for part in parts]),
        np.concatenate([part.coefficients for part in parts]),
        np.concatenate([part.error for part in parts]),
    )


def _columns(segment: _Segment) -> list[Series]:
    """One curve for every column."""
    powers = np.zeros(segment.panels.count)
    return [Series(powers, np.ascontiguousarray(segment.coefficients[:, c])) for c in range(5)]


def _falling(a: float) -> ProblemError:
    """The error for a depth that decreases while the contact grows."""
    return ProblemError(
        f"below a contact radius of {metres(a)} the indentation of a smooth contact decreases while the contact grows, so it is not "
        "a disk, which layers need; use a profile that rises more evenly"
    )
