"""Contact radii along a curve: the parameter is the radius, stretched after corners of the profile.

After a corner b of f, g grows like (a - b)^((1 + k)/2), k the exponent of a graded body or 0, so that a state depends on
a - b, which a does not resolve. There

    a - b = L φ((s - s_b)/L),  φ(x) = x^n (n - (n - 1) x),  n = 2/(1 + k),  0 < x < 1,

which joins a = s smoothly at both ends, makes all quantities smooth in s and preserves all digits of a - b.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np

from pymdr.line.adhesion.equivalent_line import Outline, inner_knots
from pymdr.line.curves import ElasticLine
from pymdr.line.layered import LayeredLine
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.numerics.panels import Place, Position
from pymdr.numerics.roots import boundary
from pymdr.units import FloatArray

_LENGTH = 0.125
"""Length L of a stretched interval over the radius of its corner or over the distance to the next breakpoint."""
_RATE_AT = 2.0**-26
"""The x at which the rates of a corner are evaluated, with an error of 1e-8."""
_LEAST = 1e-200
"""The least x^n at which they are evaluated; below it distances and rates underflow or overflow."""


@dataclass(frozen=True)
class Radii:
    """The radius a(s) of contact.

    Attributes
    ----------
    origin : float
        Parameter of a = 0 in m.
    corners : ndarray
        Corners b of the profile in m, rising.
    lengths : ndarray
        L behind every corner in m.
    exact : bool
        Whether the line takes places.
    """

    origin: float
    corners: FloatArray
    lengths: FloatArray
    exact: bool = False
    power: float = 2.0
    """n."""

    @property
    def starts(self) -> FloatArray:
        """Parameters s_b of the corners in m."""
        return self.origin + self.corners

    @property
    def knots(self) -> tuple[float, ...]:
        """Parameters in m where a stretch ends; a is not smooth there."""
        return tuple((self.starts + self.lengths).tolist())

    def place(self, s: FloatArray) -> Place:
        """Contact radii at parameters, with their distance from the last corner."""
        if self.corners.size == 0:
            return Place(np.zeros(s.shape), s - self.origin)
        k, x, behind = self._stretch(s)
        near = behind & (x < 1.0)
        offset = np.where(near, self.lengths[k] * self._fraction(x), s - self.starts[k])
        return Place(np.where(behind, self.corners[k], 0.0), np.where(behind, offset, s - self.origin))

    def position(self, s: FloatArray) -> Position:
        """As `place`, rounded to a float if the line has no exact places."""
        place = self.place(s)
        return place if self.exact else place.x

    def rate(self, s: FloatArray) -> FloatArray:
        """The derivative da/ds; next to a corner that at the smallest resolved distance from it."""
        if self.corners.size == 0:
            return np.ones(s.shape)
        _, x, behind = self._stretch(s)
        n, x = self.power, np.clip(x, self._least, 1.0)
        return np.where(behind & (x < 1.0), x ** (n - 1.0) * (n * n - (n * n - 1.0) * x), 1.0)

    def off_corners(self, s: FloatArray) -> FloatArray:
        """The parameters, but none so close to a corner that rates over the radius are infinite."""
        if self.corners.size == 0:
            return s
        k, x, behind = self._stretch(s)
        return np.where(behind & (x < self._least), self.starts[k] + self._least * self.lengths[k], s)

    def parameter(self, radius: FloatArray) -> FloatArray:
        """The parameters of contact radii in m."""
        s = self.origin + radius
        if self.corners.size == 0:
            return s
        k = np.searchsorted(self.corners, radius, side="right") - 1
        fraction = np.where(k >= 0, (radius - self.corners[k]) / self.lengths[k], 1.0)
        _, high = boundary(lambda x: self._fraction(x) < fraction, np.zeros(s.shape), 1.0)
        return np.where(fraction < 1.0, self.starts[k] + high * self.lengths[k], s)

    @property
    def _least(self) -> float:
        return max(_RATE_AT, math.pow(_LEAST, 1.0 / self.power))

    def _fraction(self, x: FloatArray) -> FloatArray:
        """The part φ of its length that a stretch is behind at x."""
        x = np.clip(x, 0.0, 1.0)
        return np.asarray(x**self.power * (self.power - (self.power - 1.0) * x))

    def _stretch(self, s: FloatArray) -> tuple[np.ndarray, FloatArray, np.ndarray]:
        k = np.searchsorted(self.starts, s, side="right") - 1
        behind = k >= 0
        return k, np.where(behind, (s - self.starts[k]) / self.lengths[k], 1.0), behind


def radii_of(line: Outline, rate: Callable[[FloatArray], FloatArray], origin: float = 0.0) -> Radii:
    """The radii of a line, stretched behind its known corners.

    Parameters
    ----------
    line : Outline
        Edge, largest radius and breakpoints of the profile.
    rate : callable
        g'(x); corners are breakpoints at which it is infinite.
    origin : float
        Parameter of a = 0 in m.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> worn = SimpleNamespace(edge=np.inf, max_radius=np.inf, breakpoints=(1.0,))
    >>> radii = radii_of(worn, lambda x: np.where(x == 1.0, np.inf, 1.0))
    >>> radii.place(np.array([0.5, 1.0, 1.0625, 2.0])).x.tolist()
    [0.5, 1.0, 1.046875, 2.0]
    """
    if not isinstance(line, Hashable):
        return _from_corners(line, rate, origin)
    known = _known.get(line)
    if known is None or known[0] != (line.breakpoints, line.max_radius):
        known = (line.breakpoints, line.max_radius), _from_corners(line, rate, 0.0)
        _known[line] = known
    return replace(known[1], origin=origin)


_known: WeakKeyDictionary[Hashable, tuple[tuple[tuple[float, ...], float], Radii]] = WeakKeyDictionary()


def _from_corners(line: Outline, rate: Callable[[FloatArray], FloatArray], origin: float) -> Radii:
    knots = np.array(inner_knots(line))
    if knots.size == 0:
        return Radii(origin, knots, knots)
    gaps = np.minimum(np.diff(np.append(knots, min(line.edge, line.max_radius))), knots)
    corner = np.isinf(rate(knots))
    mapped = line.equivalent if isinstance(line, ElasticLine | LayeredLine) else line
    exact = isinstance(mapped, EquivalentProfile) and bool(corner.any())
    power = 2.0 / (1.0 + line.exponent) if isinstance(line, ElasticLine) else 2.0
    return Radii(origin, knots[corner], _LENGTH * gaps[corner], exact, power)
