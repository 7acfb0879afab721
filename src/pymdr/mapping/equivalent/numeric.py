"""The image of a profile with callables or samples in it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.mapping import chebyshev
from pymdr.mapping.equivalent.base import EquivalentProfile
from pymdr.mapping.equivalent.proxy import ProxyLine, proxy_line
from pymdr.mapping.equivalent.samples import Samples, samples_of
from pymdr.problem.profiles import Function, Profile, Sum
from pymdr.units import FloatArray, metres

COARSE_RADII = np.geomspace(1e-16, 1e8, 24 * 16 + 1)
"""Radii in m at which a profile without a length of its own is looked at first."""

_MOST_KNOTS = 400
"""With more breakpoints than that, panels follow the curve and not the breakpoints."""


def _never_rises(target: float, low: float) -> ProblemError:
    return ProblemError(
        f"the profile never rises to {metres(target)}, as far as it is defined and resolved (up to {metres(low)}): a contact "
        "without an edge has no end; add FlatPunch(radius) for a cylinder of that end shape, or state how far the "
        "profile goes with Function(..., reach=...)"
    )


@dataclass(frozen=True)
class NumericLine(EquivalentProfile):
    """The image of a profile with a callable or samples in it: mapped when it is asked."""

    profile: Profile
    edge: float = math.inf
    reach: float = math.inf
    breakpoints: tuple[float, ...] = ()
    fixed: bool = False
    """Whether the reach is that of data, so that all of it is mapped at once."""
    rises: bool = field(default=False, init=False)

    def g(self, x: ArrayLike) -> FloatArray:
        """Equivalent profile in m."""
        return self._interpolant(self._beyond_knots(self._top(x)))[0].value(x)

    def slope(self, x: ArrayLike) -> FloatArray:
        """Slope g'."""
        return self._interpolant(self._beyond_knots(self._top(x)))[0].slope(x)

    def moment(self, x: ArrayLike) -> FloatArray:
        """First moment."""
        return self.upto(self._top(x)).moment(x)

    def squared(self, x: ArrayLike) -> FloatArray:
        """Integral of (g(x) - g)^2."""
        return self.upto(self._top(x)).squared(x)

    def inverse(self, depth: ArrayLike) -> FloatArray:
        """Inverse of g, searched from small radii upward."""
        return self._grown(depth, "g").inverse(depth)

    def inverse_moment(self, moment: ArrayLike) -> FloatArray:
        """Inverse of the first moment."""
        return self._grown(moment, "moment").inverse_moment(moment)

    def _top(self, x: ArrayLike) -> float:
        largest = float(np.max(np.abs(x), initial=0.0))
        return largest if largest > 0.0 else self.some_radius()

    def some_radius(self) -> float:
        """A radius in m well inside what is known of the profile, for where any radius will do."""
        with np.errstate(all="ignore"):
            known = COARSE_RADII[np.isfinite(_rough_gap(self.profile))]
        last = float(known[-1]) if known.size else 1.0
        return min(1.0, 0.5 * last, 0.5 * self.reach)

    def _grown(self, target: ArrayLike, name: str) -> EquivalentProfile:
        return self.upto(self.top_for(float(np.max(target, initial=0.0)), name))

    def top_for(self, target: float, name: str = "g") -> float:
        """A radius in m at which g (or the moment) is above a value, by at most 20 % in radius."""
        return self.top_where(
            lambda samples, x: _value(samples, name, x),
            target,
            lambda r, f: f if name == "g" else 0.5 * r * f,
        )

    def top_where(
        self,
        curve: Callable[[Samples, float], float],
        target: float,
        rough: Callable[[FloatArray, FloatArray], FloatArray],
    ) -> float:
        """
        A radius in m at which a quantity is above a value for good, by at most 20 % in radius.

        Parameters
        ----------
        curve : callable
            The quantity at a radius, from the samples of g and its moment up to there.
        target : float
            The value to pass.
        rough : callable
            An estimate of the quantity from radii and f(r), from which the search begins.

        Returns
        -------
        float
            The end of the profile where that is data, or where the quantity stays below.
        """
        limit = min(self.edge, self.reach)
        if self.fixed:
            return limit

        def value(x: float) -> float:
            """The curve at x; nan where it is not defined."""
            try:
                with np.errstate(over="ignore", invalid="ignore"):
                    return curve(samples_of(self.profile, x), x)
            except ConvergenceError:
                return math.nan

        low = min(self._rough_top(rough, target), limit)
        while low > 1e-250 and not value(low) <= target:
            low /= 8.0
        high = low
        while value(high) <= target:
            if high >= limit:
                return limit
            if high > 1e100:
                raise _never_rises(target, high)
            low, high = high, min(2.0 * high, limit)
        for _ in range(60):
            if high < 1.2 * low and math.isfinite(value(high)):
                return high
            middle = math.sqrt(low * high)
            low, high = (middle, high) if value(middle) <= target else (low, middle)
        raise _never_rises(target, low)

    def _rough_top(self, rough: Callable[[FloatArray, FloatArray], FloatArray], target: float) -> float:
        """The last radius of a coarse grid at which an estimate from f itself is not above a value."""
        with np.errstate(all="ignore"):
            below = np.flatnonzero(rough(COARSE_RADII, _rough_gap(self.profile)) <= target)
        known = below.size > 0 and below[-1] < COARSE_RADII.size - 1
        return float(COARSE_RADII[below[-1] + 1]) if known else 1.0

    def upto(self, top: float) -> ProxyLine:
        """Interpolants of g and its integrals on [0, top]."""
        top = self._beyond_knots(min(top, self.edge, self.reach))
        curve, samples = self._interpolant(top)
        marks = (
            self.breakpoints if len(self.breakpoints) <= _MOST_KNOTS else tuple(curve.edges[1:-1].tolist())
        )
        return proxy_line(curve, samples.moment, marks, self.edge, top)

    def _beyond_knots(self, top: float) -> float:
        """A radius no less than `top` that leaves no sliver of a panel behind the last breakpoint."""
        below = [b for b in self.breakpoints if b <= top]
        if not below:
            return top
        last = below[-1]
        room = min(1.1 * last, self.edge, self.reach, *(b for b in self.breakpoints if b > top)) - last
        return last + 0.5 * room if top - last < 0.05 * room else top

    def _interpolant(self, top: float) -> tuple[chebyshev.Piecewise, Samples]:
        samples = samples_of(self.profile, top)
        exponent = 1.0 + chebyshev.tip_exponent(samples.slope, top, 0.0)
        marks, least = self.breakpoints, 0.0
        if len(marks) > _MOST_KNOTS:
            marks, least = (), 1e-12 * float(samples.g(np.array([top]))[0]) / top
        curve = chebyshev.build(
            samples.g,
            top,
            breakpoints=marks,
            rooted=True,
            tip_exponent=exponent,
            noise=lambda x: max(samples.noise(x), least) * x,
            what="g(x)",
        )
        return curve, samples


def _rough_gap(profile: Profile) -> FloatArray:
    """Gap f on the coarse grid; nan where it is not defined."""
    total = np.zeros(COARSE_RADII.shape)
    for part in profile.parts if isinstance(profile, Sum) else (profile,):
        if isinstance(part, Function) and part.f is None:
            slope = part.gap_slope(COARSE_RADII)
            steps = 0.5 * np.diff(COARSE_RADII) * (slope[1:] + slope[:-1])
            total = total + np.concatenate([[0.0], np.cumsum(steps)])
        else:
            total = total + part.gap(COARSE_RADII)
    return total


def _value(samples: Samples, name: str, x: float) -> float:
    curve = samples.g if name == "g" else samples.moment
    assert curve is not None
    return float(curve(np.array([x]))[0])
