"""Profiles given by a callable, and the polynomials that stand for them in files."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.problem.profiles.base import Profile
from pymdr.problem.values import SIField
from pymdr.units import FloatArray, to_si_array

ArrayFunction: TypeAlias = Callable[[FloatArray], ArrayLike]


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
            raw = function(flat)
            if np.iscomplexobj(raw):
                raise ProblemError(f"Function.{name} gives complex numbers; a profile is real")
            values = np.asarray(raw, dtype=float)
            if values.shape != flat.shape:
                values = np.array(np.broadcast_to(values, flat.shape))
            return values.reshape(np.shape(r))
        except (TypeError, ValueError) as error:
            raise ProblemError(
                f"Function.{name} does not take arrays ({error}): write it with NumPy functions, "
                "or wrap it in numpy.vectorize"
            ) from error


@dataclass(frozen=True, eq=False)
class Interpolated(Profile):
    """
    A profile held as polynomials: what a saved result keeps of a :class:`Function`.

    On each piece f' = (r/high)^tip sum_j c_j T_j(2 t - 1), r = low + (high - low) t, where tip is 0 but on the
    first pieces.

    Parameters
    ----------
    edges : sequence of float
        Radii in m at which the pieces begin and end, rising from 0.
    coefficients : sequence of sequences of float
        Chebyshev coefficients c_j of f' on each piece.
    tip : float
        Exponent of the first pieces.
    tip_pieces : int
        Number of pieces with that exponent.
    kinks : sequence of float
        The edges at which f' is not smooth.

    Examples
    --------
    >>> round(float(Interpolated((0.0, 1.0), ((2.0,),), tip=1.0).gap(0.5)), 14)
    0.25
    """

    edges: tuple[float, ...]
    coefficients: tuple[tuple[float, ...], ...]
    tip: float = 0.0
    tip_pieces: int = 1
    kinks: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "edges", tuple(float(e) for e in self.edges))
        object.__setattr__(self, "coefficients", tuple(tuple(map(float, c)) for c in self.coefficients))
        object.__setattr__(self, "kinks", tuple(float(b) for b in self.kinks))
        object.__setattr__(self, "tip", float(self.tip))
        object.__setattr__(self, "tip_pieces", int(self.tip_pieces))
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
        for i, (low, high) in enumerate(pairwise(self.edges)):
            inside = (r >= low) & (r <= high)
            answer[inside] = self._piece_slope(r[inside], i)
        return answer

    def gap(self, r: ArrayLike) -> FloatArray:
        """Gap f(r) in m by Gauss-Legendre on each piece; nan beyond the reach."""
        r = np.asarray(r, dtype=float)
        nodes, weights = np.polynomial.legendre.leggauss(64)
        s = ((nodes + 1.0) / 2.0) ** 2
        weights = weights * (nodes + 1.0) / 2.0
        answer = np.where(r <= self.reach, 0.0, math.nan)
        for i, (low, high) in enumerate(pairwise(self.edges)):
            width = np.clip(r, low, high) - low
            for node, weight in zip(s, weights, strict=True):
                x = low + width * node
                answer = answer + weight * width * np.where(width > 0.0, self._piece_slope(x, i), 0.0)
        return answer

    def _piece_slope(self, r: FloatArray, i: int) -> FloatArray:
        low, high = self.edges[i], self.edges[i + 1]
        values = np.polynomial.chebyshev.chebval(2.0 * (r - low) / (high - low) - 1.0, self.coefficients[i])
        return np.asarray(values * (r / high) ** self.tip if i < self.tip_pieces else values)
