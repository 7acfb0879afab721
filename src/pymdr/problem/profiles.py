"""Profiles: the combined initial gap f(r) of the two bodies, with f(0) = 0."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.problem.values import OptionalSIField, SIField, Value
from pymdr.units import FloatArray, to_si_array

ArrayFunction: TypeAlias = Callable[[FloatArray], ArrayLike]


class Profile(Value, ABC):
    """An axisymmetric gap f(r); profiles add up with ``+``."""

    @abstractmethod
    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m; inf beyond a sharp edge, nan where the profile does not exist."""

    @abstractmethod
    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Radii in m at which f' jumps or bends sharply."""
        return ()

    @property
    def edge(self) -> float:
        """Radius in m of a sharp outer edge that no contact passes; inf without one."""
        return math.inf

    @property
    def reach(self) -> float:
        """Largest radius in m at which the profile is known; inf if everywhere."""
        return math.inf

    @property
    def curvature_radius(self) -> float | None:
        """Radius in m against which small-slope theory measures the contact; None without one."""
        return None

    def __add__(self, other: Profile) -> Sum:
        if not isinstance(other, Profile):
            return NotImplemented
        return Sum((*_parts(self), *_parts(other)))


def _parts(profile: Profile) -> tuple[Profile, ...]:
    return profile.parts if isinstance(profile, Sum) else (profile,)


@dataclass(frozen=True, eq=False)
class Sphere(Profile):
    """
    The true sphere, f = R - sqrt(R^2 - r^2), known up to r = R.

    Parameters
    ----------
    radius : quantity
        Radius R in m, above 0.

    Examples
    --------
    >>> float(Sphere("10 mm").gap(1e-3))
    5.012562893380045e-05
    """

    radius: SIField = SIField("m", above=0.0, words="radius of the sphere")

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f = r^2 / (R + sqrt(R^2 - r^2)), the form without cancellation."""
        r, R = np.asarray(r, dtype=float), self.radius
        with np.errstate(invalid="ignore"):
            return np.asarray(r * (r / (R + np.sqrt((R - r) * (R + r)))))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f' = r / sqrt(R^2 - r^2)."""
        r, R = np.asarray(r, dtype=float), self.radius
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(r / np.sqrt((R - r) * (R + r)))

    @property
    def reach(self) -> float:
        """The sphere ends at r = R."""
        return self.radius

    @property
    def curvature_radius(self) -> float | None:
        """The radius R."""
        return self.radius


@dataclass(frozen=True, eq=False)
class Paraboloid(Profile):
    """
    A paraboloid, f = r^2 / (2 R).

    Parameters
    ----------
    radius : quantity
        Radius of curvature R at the apex in m, above 0.

    Examples
    --------
    >>> float(Paraboloid("10 mm").gap(1e-3))
    5e-05
    """

    radius: SIField = SIField("m", above=0.0, words="radius of curvature at the apex")

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m."""
        r = np.asarray(r, dtype=float)
        return np.asarray(r * (r / (2.0 * self.radius)))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        return np.asarray(np.asarray(r, dtype=float) / self.radius)

    @property
    def curvature_radius(self) -> float | None:
        """The radius R."""
        return self.radius


@dataclass(frozen=True, eq=False)
class Cone(Profile):
    """
    A cone, f = slope r, given by exactly one of its slope and its half angle.

    Parameters
    ----------
    slope : quantity, optional
        Slope of the flank, f' = cot(half angle), above 0.
    half_angle : quantity, optional
        Angle between axis and flank in rad, between 0 and pi/2.

    Raises
    ------
    ProblemError
        If none or both are given, or a value is outside its limits.

    Examples
    --------
    >>> round(Cone(half_angle="70 deg").gradient, 12)
    0.363970234266
    """

    slope: OptionalSIField = OptionalSIField("", above=0.0, words="slope of the flank")
    half_angle: OptionalSIField = OptionalSIField(
        "rad", above=0.0, below=math.pi / 2, words="angle between axis and flank"
    )

    def __post_init__(self) -> None:
        if (self.slope is None) == (self.half_angle is None):
            raise ProblemError(
                f"Cone(slope={self.slope}, half_angle={self.half_angle}): give exactly one of the two, "
                "for example half_angle='70 deg'"
            )

    @property
    def gradient(self) -> float:
        """Slope f' of the flank."""
        if self.slope is not None:
            return self.slope
        assert self.half_angle is not None
        return math.tan(math.pi / 2 - self.half_angle)

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m."""
        return np.asarray(self.gradient * np.asarray(r, dtype=float))

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        return np.full(np.shape(r), self.gradient)


@dataclass(frozen=True, eq=False)
class PowerLaw(Profile):
    """
    A power law, f = height (r / radius)^exponent.

    Parameters
    ----------
    exponent : quantity
        Exponent n, above 0.
    height : quantity
        Gap in m at r = `radius`, above 0.
    radius : quantity
        Reference radius in m, above 0.

    Examples
    --------
    >>> float(PowerLaw(4, "1 um", "1 mm").gap(2e-3))
    1.6e-05
    """

    exponent: SIField = SIField("", above=0.0, words="exponent n")
    height: SIField = SIField("m", above=0.0, words="gap at the reference radius")
    radius: SIField = SIField("m", above=0.0, words="reference radius")

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m."""
        return np.asarray(self.height * (np.asarray(r, dtype=float) / self.radius) ** self.exponent)

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        n = self.exponent
        with np.errstate(divide="ignore"):
            relative = (np.asarray(r, dtype=float) / self.radius) ** (n - 1.0)
        return np.asarray(n * (self.height / self.radius) * relative)


@dataclass(frozen=True, eq=False)
class FlatPunch(Profile):
    """
    A flat cylindrical punch with a sharp edge: f = 0 up to its radius, infinite beyond.

    Added to another profile it gives a cylinder whose end has that shape.

    Parameters
    ----------
    radius : quantity
        Radius b of the cylinder in m, above 0.

    Examples
    --------
    >>> rounded = FlatPunch("1 mm") + Paraboloid("20 mm")
    >>> rounded.edge
    0.001
    """

    radius: SIField = SIField("m", above=0.0, words="radius of the cylinder")

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m."""
        return np.where(np.asarray(r, dtype=float) <= self.radius, 0.0, math.inf)

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r) below the edge."""
        return np.zeros(np.shape(r))

    @property
    def edge(self) -> float:
        """The sharp edge at r = b."""
        return self.radius


@dataclass(frozen=True, eq=False)
class Function(Profile):
    """
    Any profile given as a callable f(r), its derivative f'(r), or both.

    Parameters
    ----------
    f : callable, optional
        Gap in m, taking and giving arrays. An offset f(0) is removed when the profile is mapped.
    breakpoints : array_like or quantity
        Radii in m, above 0, at which f' jumps or is not smooth.
    derivative : callable, optional
        f'(r), taking and giving arrays. With it the map is exact to 1e-13, with f alone to 1e-12.
    reach : quantity
        Largest radius in m at which the callables may be evaluated.

    Raises
    ------
    ProblemError
        If neither callable is given, or a breakpoint is not above 0.

    Examples
    --------
    >>> bowl = Function(lambda r: r**4, derivative=lambda r: 4 * r**3)
    >>> float(bowl.gap_slope(0.5))
    0.5
    """

    f: ArrayFunction | None = None
    breakpoints: tuple[float, ...] = ()
    derivative: ArrayFunction | None = None
    reach: SIField = SIField("m", above=0.0, default=math.inf)

    def __post_init__(self) -> None:
        if self.f is None and self.derivative is None:
            raise ProblemError("Function(): give f, derivative or both, for example Function(lambda r: r**4)")
        for name in ("f", "derivative"):
            given = getattr(self, name)
            if given is not None and not callable(given):
                raise ProblemError(f"Function.{name} = {given!r}: a callable of the radius is needed")
        radii = np.atleast_1d(to_si_array(self.breakpoints, "m", name="Function.breakpoints"))
        if np.any(radii <= 0.0):
            raise ProblemError(f"Function.breakpoints = {radii.tolist()}: every radius must be above 0 m")
        object.__setattr__(self, "breakpoints", tuple(np.unique(radii).tolist()))

    @property
    def offset(self) -> float:
        """The offset f(0) in m that is removed."""
        return 0.0 if self.f is None else float(call(self.f, np.zeros(1), "f")[0])

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) - f(0) in m."""
        if self.f is None:
            raise ProblemError("Function.gap: only the derivative was given; integrate it")
        return np.asarray(call(self.f, np.asarray(r, dtype=float), "f") - self.offset)

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r)."""
        if self.derivative is None:
            raise ProblemError("Function.gap_slope: no derivative was given; differentiate f")
        return call(self.derivative, np.asarray(r, dtype=float), "derivative")


def call(function: ArrayFunction, r: FloatArray, name: str = "f") -> FloatArray:
    """
    Evaluate a user's callable on an array of any shape.

    Parameters
    ----------
    function : callable
        Taking and giving one-dimensional arrays.
    r : ndarray
        Radii in m.
    name : str
        What is called, for the message.

    Returns
    -------
    ndarray
        Values of the shape of `r`; nan where the callable is not defined.

    Raises
    ------
    ProblemError
        If the callable does not take arrays.

    Examples
    --------
    >>> call(lambda r: 2 * r, np.ones((1, 2))).tolist()
    [[2.0, 2.0]]
    """
    flat = np.ravel(r)
    with np.errstate(all="ignore"):
        try:
            values = np.asarray(function(flat), dtype=float)
            if values.shape != flat.shape:
                values = np.array(np.broadcast_to(values, flat.shape))
            return values.reshape(np.shape(r))
        except (TypeError, ValueError) as error:
            raise ProblemError(
                f"Function.{name} does not take arrays ({error}): write it with NumPy functions, "
                "or wrap it in numpy.vectorize"
            ) from error


@dataclass(frozen=True, eq=False)
class Sum(Profile):
    """
    The sum of several profiles, written ``a + b``.

    Parameters
    ----------
    parts : tuple of Profile
        At least one profile.

    Examples
    --------
    >>> (Paraboloid("1 mm") + Cone(slope=0.1)).parts[1].gradient
    0.1
    """

    parts: tuple[Profile, ...]

    def __post_init__(self) -> None:
        parts = tuple(self.parts)
        if not parts or not all(isinstance(part, Profile) for part in parts):
            raise ProblemError(f"Sum.parts = {self.parts!r}: one or more profiles are needed")
        object.__setattr__(self, "parts", parts)

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
    def reach(self) -> float:
        """The smallest reach of the parts."""
        return min(part.reach for part in self.parts)

    @property
    def curvature_radius(self) -> float | None:
        """Radius of the summed curvatures, 1/R = sum of 1/R_i, of the parts that have one."""
        curvature = sum(1.0 / part.curvature_radius for part in self.parts if part.curvature_radius)
        return 1.0 / curvature if curvature else None


@dataclass(frozen=True, eq=False)
class Interpolated(Profile):
    """
    A profile held as polynomials: what a saved result keeps of a :class:`Function`.

    On each piece f' = r^tip sum_j c_j T_j(2 t - 1), r = low + (high - low) t, with r^tip only on the first.

    Parameters
    ----------
    edges : sequence of float
        Radii in m at which the pieces begin and end, rising from 0.
    coefficients : sequence of sequences of float
        Chebyshev coefficients c_j of f' on each piece.
    tip : float
        Exponent of the first piece.
    kinks : sequence of float
        The edges at which f' is not smooth.

    Examples
    --------
    >>> float(Interpolated((0.0, 1.0), ((2.0,),), tip=1.0).gap(0.5))
    0.25
    """

    edges: tuple[float, ...]
    coefficients: tuple[tuple[float, ...], ...]
    tip: float = 0.0
    kinks: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "edges", tuple(float(e) for e in self.edges))
        object.__setattr__(self, "coefficients", tuple(tuple(map(float, c)) for c in self.coefficients))
        object.__setattr__(self, "kinks", tuple(float(b) for b in self.kinks))
        object.__setattr__(self, "tip", float(self.tip))
        if len(self.edges) != len(self.coefficients) + 1 or np.any(np.diff(self.edges) <= 0.0):
            raise ProblemError("Interpolated.edges must rise and be one more than the pieces")

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The kinks."""
        return self.kinks

    @property
    def reach(self) -> float:
        """The last edge."""
        return self.edges[-1]

    def gap_slope(self, r: ArrayLike) -> FloatArray:
        """Slope f'(r); nan beyond the reach."""
        r = np.asarray(r, dtype=float)
        answer = np.full(r.shape, math.nan)
        for i, c in enumerate(self.coefficients):
            low, high = self.edges[i], self.edges[i + 1]
            inside = (r >= low) & (r <= high)
            t = (r[inside] - low) / (high - low)
            values = np.polynomial.chebyshev.chebval(2.0 * t - 1.0, c)
            answer[inside] = values * r[inside] ** self.tip if i == 0 else values
        return answer

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m by Gauss-Legendre on each piece; nan beyond the reach."""
        r = np.asarray(r, dtype=float)
        nodes, weights = np.polynomial.legendre.leggauss(64)
        s = ((nodes + 1.0) / 2.0) ** 2
        weights = weights * (nodes + 1.0) / 2.0
        answer = np.where(r <= self.reach, 0.0, math.nan)
        for low, high in zip(self.edges[:-1], self.edges[1:], strict=True):
            width = np.clip(r, low, high) - low
            for node, weight in zip(s, weights, strict=True):
                x = low + width * node
                answer = answer + weight * width * np.where(width > 0.0, self._piece_slope(x, low), 0.0)
        return answer

    def _piece_slope(self, r: FloatArray, low: float) -> FloatArray:
        i = self.edges.index(low)
        t = (r - low) / (self.edges[i + 1] - low)
        values = np.polynomial.chebyshev.chebval(2.0 * t - 1.0, self.coefficients[i])
        return np.asarray(values * r**self.tip if i == 0 and self.tip else values)
