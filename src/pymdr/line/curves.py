"""The line as curves in its contact radius, the input of every law.

A linear elastic body pressed by a profile on a disk is known from two families of solutions, the smooth contact d0(a),
F0(a), U0(a) and the flat punch of stiffness k(a), with dF0 = k dd0. At a radius a with the excess w = d - d0(a),

    d = d0 + w,   F = F0 + k w,   U = U0 + F0 w + k w^2 / 2,

where w > 0 is a sharp edge and w < 0 an adhesive one, whose energy release rate is k'(a) w^2 / (4 pi a). Machines,
friction, memory and conductance need a :class:`Curve`; adhesion and fields a :class:`Disk`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.numerics.panels import BoolArray, Place, Position
from pymdr.units import FloatArray


class Curve(Protocol):
    """Contacts of one body by their radius a in m; all results have the shape of the argument."""

    @property
    def edge(self) -> float:
        """Radius of the sharp edge in m, the largest contact radius."""

    @property
    def max_radius(self) -> float:
        """Largest radius in m at which the profile is known."""

    @property
    def rises(self) -> bool:
        """Whether d0 is known to rise everywhere."""

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Radii in m to whose right the curve is not smooth."""

    def depth(self, a: Position) -> FloatArray:
        """The indentation d0 in m."""

    def force(self, a: Position) -> FloatArray:
        """The normal force F0 in N."""

    def energy(self, a: Position) -> FloatArray:
        """The elastic energy U0 in J."""

    def stiffness(self, a: Position) -> FloatArray:
        """The normal stiffness k = dF/dd in N/m."""

    def place(self, depth: ArrayLike) -> Place:
        """The first radius at which d0 has a value in m; inf where it never has."""

    def place_of_force(self, force: ArrayLike) -> Place:
        """The first radius at which F0 has a value in N."""

    def between(self, depth: FloatArray, low: float, high: float) -> Place:
        """The radii at which d0 has values in m on a stretch on which it rises."""

    def turning_points(self, top: float) -> tuple[float, ...]:
        """Radii in m up to `top` at which d0 turns; 0 where it begins to fall."""

    def overlap_radius(self, depth: float) -> float:
        """The largest radius in m at which the bodies would overlap if they were shifted by a depth in m."""

    def rough_radius(self, reached: Callable[[FloatArray, FloatArray], BoolArray]) -> float:
        """A radius a in m near which ``reached(a, d0)`` becomes true, going outward."""


class Disk(Curve, Protocol):
    """A curve whose radius is that of a contact on a disk."""

    def depth_rate(self, a: Position) -> FloatArray:
        """The derivative d0'(a)."""

    def stiffness_rate(self, a: Position) -> FloatArray:
        """The derivative k'(a) in N/m^2."""

    def punch(self, a: Position) -> Punch:
        """Stiffnesses of flat punches of some radii, with their derivatives."""

    def contacts(self, a: Position) -> Contacts:
        """What determines all contacts of a radius with an edge, at once."""


class Punch(NamedTuple):
    """Flat punches of some radii."""

    stiffness: FloatArray
    """k in N/m."""
    rate: FloatArray
    """k' in N/m^2."""
    power: FloatArray | float
    """The local power a k''/k' of k'."""


class Contacts(NamedTuple):
    """The smooth contacts and the punches of some radii."""

    depth: FloatArray
    """d0 in m."""
    force: FloatArray
    """F0 in N."""
    stiffness: FloatArray
    """k in N/m."""
    stiffness_rate: FloatArray
    """k' in N/m^2."""


class Line(Disk, Protocol):
    """A disk made of an equivalent profile, pressed into bodies whose surface has a modulus."""

    @property
    def equivalent(self) -> EquivalentProfile:
        """The profile g(x)."""

    @property
    def modulus(self) -> float:
        """E* of the surface in Pa, or c in Pa/m^k for the exponent k."""

    @property
    def exponent(self) -> float:
        """Exponent k of the grading; 0 for homogeneous bodies and layers."""

    def under(self, equivalent: EquivalentProfile) -> Line:
        """The same bodies under another profile."""

    def error(self, place: Position) -> FloatArray:
        """Measured relative errors of d0, d0', F0 and U0, shape (..., 4)."""

    def carried(self, a: Position, excess: float) -> Carried:
        """The half-spaces that carry the same pressure in a contact of one radius in m and an excess w in m."""


class Carried(NamedTuple):
    """Equivalent half-spaces: their fields equal those of the body, except for an addition outside."""

    line: ElasticLine
    excess: float
    """Their excess depth at the edge in m."""
    sunk: Callable[[FloatArray], FloatArray] | None = None
    """Additional displacement in m of the body at radii in m outside; None for none."""


class Profiled:
    """The properties that a line has from its equivalent profile."""

    equivalent: EquivalentProfile

    @property
    def exponent(self) -> float:
        """Exponent k of the grading; 0 for homogeneous bodies and layers."""
        return self.equivalent.exponent

    @property
    def edge(self) -> float:
        """Sharp edge in m that no contact passes."""
        return self.equivalent.edge

    @property
    def max_radius(self) -> float:
        """Largest radius in m at which the profile is known."""
        return self.equivalent.max_radius

    @property
    def rises(self) -> bool:
        """Whether g is known to rise everywhere; d0 then does where its contacts are disks."""
        return self.equivalent.rises

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Radii in m to whose right g is not smooth."""
        return self.equivalent.breakpoints


@dataclass(frozen=True)
class ElasticLine(Profiled):
    """
    Independent springs of stiffness c |x|^k per length under an equivalent profile: half-spaces, homogeneous and graded.

    d0 = g(a), F0 = 2 c int_0^a x^k (g(a) - g) dx, U0 = c int_0^a x^k (g(a) - g)^2 dx, stiffness 2 c a^(1+k) / (1+k).

    Parameters
    ----------
    equivalent : EquivalentProfile
        g(x), with the exponent k of the grading.
    modulus : float
        c in Pa/m^k: E* of homogeneous half-spaces, c_N / z0^k of graded ones.

    Notes
    -----
    Galin (1946), Sneddon (1965), Popov and Hess (2015), chapter 3, for k = 0; Hess (2016) for graded bodies.
    """

    equivalent: EquivalentProfile
    modulus: float

    @property
    def _per_length(self) -> float:
        """Stiffness over a^(1+k): 2 c / (1 + k)."""
        return 2.0 * self.modulus / (1.0 + self.exponent)

    def depth(self, a: Position) -> FloatArray:
        """The indentation g(a) in m."""
        return self.equivalent.g(a)

    def depth_rate(self, a: Position) -> FloatArray:
        """The slope g'(a)."""
        return self.equivalent.slope(a)

    def force(self, a: Position) -> FloatArray:
        """The normal force 2 c / (1 + k) int_0^a x^(1+k) g' dx in N."""
        return self._per_length * self.equivalent.moment(a)

    def energy(self, a: Position) -> FloatArray:
        """The elastic energy in J."""
        return self.modulus * self.equivalent.squared(a)

    def stiffness(self, a: Position) -> FloatArray:
        """The normal stiffness in N/m."""
        radius = np.asarray(a, dtype=float)
        return self._per_length * (radius if self.exponent == 0.0 else radius ** (1.0 + self.exponent))

    def stiffness_rate(self, a: Position) -> FloatArray:
        """The derivative 2 c a^k of the stiffness in N/m^2."""
        with np.errstate(divide="ignore", over="ignore"):
            return np.asarray(2.0 * self.modulus * np.asarray(a, dtype=float) ** self.exponent)

    def punch(self, a: Position) -> Punch:
        """Stiffnesses of flat punches of some radii, with their derivatives."""
        return Punch(self.stiffness(a), self.stiffness_rate(a), self.exponent)

    def contacts(self, a: Position) -> Contacts:
        """The smooth contacts and the punches of some radii."""
        return Contacts(self.depth(a), self.force(a), self.stiffness(a), self.stiffness_rate(a))

    def under(self, equivalent: EquivalentProfile) -> ElasticLine:
        """The same bodies under another profile."""
        return ElasticLine(equivalent, self.modulus)

    def error(self, place: Position) -> FloatArray:
        """Measured relative errors of d0, d0', F0 and U0, those of the map of the profile, shape (..., 4)."""
        return self.equivalent.error(place)

    def carried(self, a: Position, excess: float) -> Carried:
        """The line itself."""
        return Carried(self, excess)

    def place(self, depth: ArrayLike) -> Place:
        """The first radius at which g has a value in m; inf where it never has."""
        return self.equivalent.place(depth)

    def place_of_force(self, force: ArrayLike) -> Place:
        """The first radius at which the force has a value in N."""
        return self.equivalent.place_of_moment(np.asarray(force, dtype=float) / self._per_length)

    def between(self, depth: FloatArray, low: float, high: float) -> Place:
        """The radii at which g has values in m on a stretch on which it rises."""
        return self.equivalent.between(depth, low, high)

    def turning_points(self, top: float) -> tuple[float, ...]:
        """Radii in m up to `top` at which g turns; 0 where it begins to fall."""
        return self.equivalent.turning_points(top)

    def overlap_radius(self, depth: float) -> float:
        """The largest radius in m at which the bodies would overlap if they were shifted by a depth in m."""
        return self.equivalent.overlap_radius(depth)

    def rough_radius(self, reached: Callable[[FloatArray, FloatArray], BoolArray]) -> float:
        """A radius x in m near which ``reached(x, g(x))`` becomes true, going outward."""
        return self.equivalent.rough_radius(reached)


def touching_part(before: FloatArray, after: FloatArray) -> FloatArray:
    """
    The part of straight rows in contact, from their indentations in m before and after.

    Examples
    --------
    >>> touching_part(np.array([-1.0, 1.0, 2.0]), np.array([1.0, 2.0, -2.0])).tolist()
    [0.5, 1.0, 0.5]
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = np.abs((np.maximum(after, 0.0) - np.maximum(before, 0.0)) / (after - before))
    return np.where((before > 0.0) == (after > 0.0), before > 0.0, crossing)
