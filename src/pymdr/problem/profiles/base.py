"""The base of profiles, and sums of profiles."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.problem.values import Value
from pymdr.units import FloatArray


class Profile(Value, ABC):
    """An axisymmetric gap f(r); profiles add up with ``+``."""

    whole: ClassVar[bool] = False
    """Whether it describes a complete contact, so that no profile can be added."""
    no_radius: ClassVar[str] = ""
    """Why its contacts have no radius; empty where they have one."""
    instead: ClassVar[str] = ""
    """What serves for friction where its contacts are not disks; empty where that is not known."""

    @abstractmethod
    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m; inf beyond a sharp edge, nan where not defined."""

    @abstractmethod
    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Radii in m at which f' jumps or is not smooth."""
        return ()

    @property
    def edge(self) -> float:
        """Radius in m of a sharp outer edge that limits the contact; inf without one."""
        return math.inf

    @property
    def max_radius(self) -> float:
        """Largest radius in m at which the profile is known; inf if everywhere."""
        return math.inf

    @property
    def curvature_radius(self) -> float | None:
        """Reference radius in m of the small-slope condition a/R; None without one."""
        return None

    @property
    def tip_radius(self) -> float | None:
        """Radius of curvature in m of a round tip; None for others."""
        return None

    def __add__(self, other: Profile) -> Sum:
        if not isinstance(other, Profile):
            return NotImplemented
        return Sum((*_parts(self), *_parts(other)))

    def __radd__(self, other: int) -> Profile:
        """``sum`` begins with 0."""
        return self if other == 0 else NotImplemented


def _parts(profile: Profile) -> tuple[Profile, ...]:
    return profile.parts if isinstance(profile, Sum) else (profile,)


@dataclass(frozen=True, eq=False)
class Sum(Profile):
    """
    The sum of several profiles, written ``a + b`` or ``sum([a, b])``.

    Parameters
    ----------
    parts : tuple of Profile
        At least one profile.

    Examples
    --------
    >>> from pymdr.problem.profiles import Cone, Paraboloid
    >>> (Paraboloid("1 mm") + Cone(slope=0.1)).parts[1].gradient
    0.1
    """

    parts: tuple[Profile, ...]

    def __post_init__(self) -> None:
        parts = tuple(self.parts)
        if not parts or not all(isinstance(part, Profile) for part in parts):
            raise ProblemError(f"Sum.parts = {self.parts!r}: one or more profiles are needed")
        for part in parts:
            if part.whole:
                raise ProblemError(
                    f"{type(part).__name__} cannot be added to other profiles, because it describes the complete contact"
                )
        object.__setattr__(self, "parts", tuple(leaf for part in parts for leaf in _parts(part)))

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m."""
        return np.asarray(sum(part.gap(r) for part in self.parts))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        return np.asarray(sum(part.gap_slope(r) for part in self.parts))

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """All breakpoints of the parts."""
        return tuple(sorted({b for part in self.parts for b in part.breakpoints}))

    @property
    def edge(self) -> float:
        """The innermost sharp edge."""
        return min(part.edge for part in self.parts)

    @property
    def max_radius(self) -> float:
        """The smallest radius up to which all parts are known."""
        return min(part.max_radius for part in self.parts)

    @property
    def curvature_radius(self) -> float | None:
        """Radius of the summed curvatures, 1/R = sum of 1/R_i, of the parts that have one."""
        curvature = sum(1.0 / part.curvature_radius for part in self.parts if part.curvature_radius)
        return 1.0 / curvature if curvature else None

    @property
    def tip_radius(self) -> float | None:
        """Radius of the summed curvatures, 1/R = sum of 1/R_i, if all parts are round."""
        radii = [part.tip_radius for part in self.parts]
        return None if None in radii else 1.0 / sum(1.0 / radius for radius in radii if radius)
