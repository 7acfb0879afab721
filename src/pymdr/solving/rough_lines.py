"""The line of a rough contact, and its springs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pymdr.errors import PathError, ProblemError
from pymdr.line.rough import SortedSprings, sorted_springs
from pymdr.mapping.moduli import effective_moduli
from pymdr.mapping.patch import full_contact_stiffness
from pymdr.mapping.rough import default_points, rough_heights
from pymdr.problem.materials import Graded, Material, Rigid, Viscoelastic
from pymdr.problem.profiles import ForceCurve
from pymdr.problem.rough import GEIKE, RoughSurface
from pymdr.units import FloatArray, QuantityLike, metres, shown, to_si

if TYPE_CHECKING:
    pass


States = tuple[FloatArray, FloatArray]


_END = 0.98
"""Fraction of half the line of a ball beyond which springs must not be in contact."""


@dataclass(frozen=True)
class RoughLine:
    """The lines of a surface between two bodies: heights, springs and force curves by the number of the realisation."""

    surface: RoughSurface
    modulus: float
    """E* in Pa."""
    coefficient: float
    """lambda."""
    points: int
    radius: float | None
    """Radius in m of a rough ball; None for a nominally flat patch."""

    @property
    def length(self) -> float:
        """Length of the line in m: that of the stiffness of full contact, or of the patch under a ball."""
        if self.radius is not None:
            return self.surface.longer_side
        return full_contact_stiffness(*self.surface.size)

    @property
    def rms(self) -> float:
        """Root mean square height of the line in m."""
        return self.surface.rms * math.sqrt(self.coefficient / math.pi)

    @property
    def scale(self) -> float:
        """The force in N at which d = h in full contact, or for the smooth ball, above which roughness does not matter."""
        if self.radius is not None:
            return 4.0 / 3.0 * self.modulus * math.sqrt(self.radius) * math.sqrt(self.surface.rms) ** 3
        return self.modulus * self.length * self.rms

    @property
    def places(self) -> FloatArray:
        """Positions x of the springs in m."""
        return np.asarray(self.length * ((np.arange(self.points) + 0.5) / self.points - 0.5))

    def heights(self, realisation: int = 0) -> FloatArray:
        """Heights of the springs in m, those of a ball lower by x^2/R."""
        if not isinstance(realisation, int | np.integer) or isinstance(realisation, bool) or realisation < 0:
            raise ProblemError(f"realisation = {shown(realisation)}; a whole number of at least 0 is needed")
        heights = rough_heights(self.surface, int(realisation), self.points, self.coefficient)
        if self.radius is not None:
            x = self.places
            heights -= x * x / self.radius
        return heights

    def springs(self, realisation: int = 0) -> SortedSprings:
        """F(d), k(d), U(d) and d(F) of a realisation."""
        return self._sorted(self.heights(realisation))

    def force_curve(
        self, realisation: int = 0, *, indentation: QuantityLike, points: int = 400
    ) -> ForceCurve:
        """
        F(d) of a realisation as a profile, for friction, memory and impacts.

        Parameters
        ----------
        realisation : int, optional
        indentation : quantity
            The deepest d in m, from the highest summit.
        points : int, optional
            Number of points, denser toward first touch.

        Returns
        -------
        ForceCurve
            For bodies of E* = ``modulus``; forces are proportional to E*. It is as approximate as the line; the errors of its
            points are NaN, because the error of a single line is not known.

        Raises
        ------
        ProblemError
            If the indentation is not above 0, or points are fewer than a curve needs.
        PathError
            If the contact of a ball reaches the end of its line.
        """
        deepest = to_si(indentation, "m", name="indentation")
        if not deepest > 0.0:
            raise ProblemError(f"indentation = {metres(deepest)}; it must be above 0 m")
        depth = deepest * (np.arange(1, whole_number("points", points) + 1) / points) ** 2
        force = self.force(depth, realisation)
        return ForceCurve(depth, force, self.modulus, contact_point=0.0, error=math.nan)

    def force(self, depth: FloatArray, realisation: int) -> FloatArray:
        """F in N at depths in m."""
        heights = self.heights(realisation)
        self._refuse_end(depth, self.end_depth(heights))
        return self._sorted(heights).force(depth)

    def _sorted(self, heights: FloatArray) -> SortedSprings:
        return sorted_springs(heights, self.modulus * self.length / self.points)

    def end_depth(self, heights: FloatArray) -> float:
        """The depth in m at which contact comes to the end of the line of a ball."""
        if self.radius is None:
            return math.inf
        ends = np.abs(self.places) >= 0.5 * _END * self.length
        return float(heights.max() - heights[ends].max())

    def _refuse_end(self, depth: FloatArray, last: float) -> None:
        if np.any(depth > last):
            raise PathError(
                f"at an indentation of {metres(float(depth.max()))} the contact of the ball reaches the end of the line, "
                f"{metres(self.length)} long; reduce the load, or increase the size of the surface"
            )

    def states(self, realisation: int, rows: FloatArray, by_force: bool, grid: FloatArray) -> States:
        """
        Responses at forces or depths, and stiffnesses at the forces of a grid.

        Parameters
        ----------
        realisation : int
        rows : ndarray
            In N, or in m.
        by_force : bool
            Whether rows are forces.
        grid : ndarray
            In N.
        """
        heights = self.heights(realisation)
        last = self.end_depth(heights)
        springs = self._sorted(heights)
        depth = springs.indentation(rows) if by_force else rows
        self._refuse_end(depth, last)
        drawn = springs.indentation(grid)
        responses = (depth, springs.force(depth), springs.normal_stiffness(depth), springs.energy(depth))
        return np.array(responses), np.where(drawn > last, np.nan, springs.normal_stiffness(drawn))


def rough_line(
    surface: RoughSurface,
    body: Material,
    counterbody: Material | None = None,
    *,
    coefficient: float | None = None,
    points: int | None = None,
    radius: QuantityLike | None = None,
) -> RoughLine:
    """
    The lines of springs of a rough surface between two bodies, as used by :func:`press_rough`.

    Parameters
    ----------
    surface, body, counterbody, coefficient, points, radius
        As for :func:`press_rough`.

    Returns
    -------
    RoughLine
        Its ``heights``, ``springs`` and ``force_curve`` by the number of the realisation.

    Raises
    ------
    ProblemError
        If a body is graded or viscoelastic, or a number is not above 0.

    Examples
    --------
    >>> import pymdr as mdr
    >>> surface = mdr.RoughSurface(hurst=0.7, rms="1 um", size="1 mm", shortest="20 um")
    >>> line = mdr.rough_line(surface, mdr.Elastic("210 GPa", 0.3))
    >>> round(line.length * 1e3, 5), line.points
    (1.1523, 1024)
    >>> springs = line.springs(realisation=3)
    >>> bool(springs.force(springs.indentation(10.0)).round(9) == 10.0)
    True
    """
    if not isinstance(surface, RoughSurface):
        raise ProblemError(
            f"{shown(surface)} is not a RoughSurface; write RoughSurface(hurst=0.8, rms='1 um', size='1 mm', "
            "shortest='10 um')"
        )
    other = Rigid() if counterbody is None else counterbody
    for one in (body, other):
        if isinstance(one, Graded | Viscoelastic):
            raise ProblemError(
                f"a {type(one).__name__} body: rough lines are for homogeneous elastic half-spaces; use Elastic or "
                "TransverselyIsotropic"
            )
    modulus = effective_moduli(body, other).normal
    factor = line_coefficient(coefficient)
    ball = None if radius is None else to_si(radius, "m", name="radius")
    if ball is not None and not ball > 0.0:
        raise ProblemError(f"radius = {metres(ball)}; it must be above 0 m")
    number = default_points(surface) if points is None else whole_number("points", points)
    return RoughLine(surface, modulus, factor, number, ball)


def line_coefficient(given: float | None) -> float:
    """The lambda of a line, by default that of Geike."""
    factor = GEIKE if given is None else to_si(given, "", name="coefficient")
    if not factor > 0.0:
        raise ProblemError(f"coefficient = {factor:g}; the lambda of C1D = lambda q C2D must be above 0")
    return factor


def whole_number(name: str, value: int) -> int:
    """The value, if it is a whole number from 1 on."""
    if not isinstance(value, int | np.integer) or isinstance(value, bool) or value < 1:
        raise ProblemError(f"{name} = {shown(value)}; a whole number of at least 1 is needed")
    return int(value)
