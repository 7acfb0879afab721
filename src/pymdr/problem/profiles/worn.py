"""Worn profiles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.problem.profiles.base import Profile
from pymdr.problem.values import ArrayField, OptionalArrayField
from pymdr.units import FloatArray, metres, shown

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

_FEWEST = 3


@dataclass(frozen=True, eq=False)
class Worn(Profile):
    """
    A profile that has lost material, f = f0(r) + h(r) - h(0), with the depth of wear h on a ring or a disk.

    The depth is a monotone cubic between the radii, constant within the first and 0 beyond the last.

    Parameters
    ----------
    original : Profile
        The profile f0 before wear, on which bodies touch in a disk.
    radius : array_like or quantity
        Radii in m, rising strictly, at least 0; at least 3.
    depth : array_like or quantity
        Depth of wear h in m at those radii, of both bodies together, at least 0, and 0 at the last.
    spring_radius, spring_depth : array_like or quantity, optional
        Places x and equivalent profile g(x) in m of the springs beyond the original part of the line, both not falling; g is linear in x^2
        between them. Homogeneous bodies are solved with them, to the indentation of the last spring, instead of with the image of h.

    Raises
    ------
    ProblemError
        If the original is no profile of revolution, the lengths differ, the radii do not rise, or a depth is below 0.

    See Also
    --------
    wear : computes it.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Worn(mdr.Paraboloid("10 mm"), ["0.1 mm", "0.2 mm", "0.3 mm"], ["0 um", "1 um", "0 um"])
    >>> round(float(ball.gap(0.2e-3)) * 1e6, 12)
    3.0
    """

    whole: ClassVar[bool] = True
    # near the end of wear the bodies touch almost without pressure, whose sign errors of the mesh decide
    instead: ClassVar[str] = (
        "the force curve of the row of the study, force_curve(row), or the worn profile of a row with less wear"
    )

    original: Profile
    radius: ArrayField = ArrayField("m", description="radii, rising")
    depth: ArrayField = ArrayField("m", description="depth of wear at the radii")
    spring_radius: OptionalArrayField = OptionalArrayField(
        "m", description="places of the springs of the line"
    )
    spring_depth: OptionalArrayField = OptionalArrayField(
        "m", description="equivalent profile g of the springs"
    )

    def __post_init__(self) -> None:
        r, h = self.radius, self.depth
        if not isinstance(self.original, Profile) or self.original.whole or self.original.no_radius:
            raise ProblemError(
                f"original = {shown(self.original)}: a profile of revolution is needed, such as Sphere('10 mm')"
            )
        if r.size < _FEWEST or h.shape != r.shape:
            raise ProblemError(
                f"{r.size} radii and {h.size} depths; give the same number of each, at least {_FEWEST}"
            )
        if not r[0] >= 0.0 or not np.all(np.diff(r) > 0.0):
            raise ProblemError("radius must rise strictly from 0 m or more; sort the radii")
        if np.any(h < 0.0) or h[-1] != 0.0:
            raise ProblemError(
                f"depth: the smallest is {metres(h.min())}, the last {metres(h[-1])}; depths must be at least 0 m, and the last 0 m"
            )

        self._check_springs()

    def _check_springs(self) -> None:
        x, g = self.spring_radius, self.spring_depth
        if x is None and g is None:
            return
        if x is None or g is None or x.shape != g.shape or x.size < _FEWEST:
            raise ProblemError(
                f"give both spring_radius and spring_depth, with the same number of values, at least {_FEWEST}"
            )
        if not x[0] >= 0.0 or np.any(np.diff(x) < 0.0) or np.any(np.diff(g) < 0.0):
            raise ProblemError(
                "spring_radius (from 0 m or more) and spring_depth must not decrease from row to row, as in every contact on a disk; sort the rows"
            )

    @cached_property
    def _spline(self) -> PPoly:
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.radius, self.depth)

    @property
    def max_radius(self) -> float:
        """That of the original."""
        return self.original.max_radius

    @property
    def edge(self) -> float:
        """That of the original."""
        return self.original.edge

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The radii, between which the depth is a cubic, and the breakpoints of the original."""
        return tuple(sorted({*self.original.breakpoints, *self.radius[self.radius > 0.0].tolist()}))

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m."""
        r = np.asarray(r, dtype=float)
        return np.asarray(self.original.gap(r) + self.depth_at(r) - self.depth[0])

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        r = np.asarray(r, dtype=float)
        inside = (r >= self.radius[0]) & (r <= self.radius[-1])
        slope = np.where(inside, self._spline(np.clip(r, self.radius[0], self.radius[-1]), 1), 0.0)
        return np.asarray(self.original.gap_slope(r) + slope)

    def depth_at(self, r: ArrayLike) -> FloatArray:
        """Depth of wear h(r) in m."""
        r = np.asarray(r, dtype=float)
        inside = self._spline(np.clip(r, self.radius[0], self.radius[-1]))
        return np.asarray(np.where(r <= self.radius[-1], inside, 0.0))
