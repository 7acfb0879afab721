"""What every equivalent profile offers, and the inversion of rising curves."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError
from pymdr.mapping import abel
from pymdr.units import FloatArray


class EquivalentProfile(ABC):
    """The profile on the line. All arguments and values are SI floats or arrays of them."""

    edge: float = math.inf
    """Sharp edge in m that no contact passes."""
    reach: float = math.inf
    """Largest x in m at which g is known."""
    breakpoints: tuple[float, ...] = ()
    """Points in m to whose right g is not smooth."""
    corners: tuple[float, ...] = ()
    """Those breakpoints at which f' jumps, so that g' is an inverse square root to their right."""
    rises: bool = True
    """Whether g is known to rise everywhere, so that every contact is a disk."""

    @abstractmethod
    def g(self, x: ArrayLike) -> FloatArray:
        """Equivalent profile g(x) in m."""

    @abstractmethod
    def slope(self, x: ArrayLike) -> FloatArray:
        """Slope g'(x)."""

    @abstractmethod
    def moment(self, x: ArrayLike) -> FloatArray:
        """First moment int_0^x t g'(t) dt in m^2."""

    @abstractmethod
    def squared(self, x: ArrayLike) -> FloatArray:
        """The integral int_0^x (g(x) - g(t))^2 dt in m^3."""

    @abstractmethod
    def inverse(self, depth: ArrayLike) -> FloatArray:
        """The x in m at which g(x) = depth, for rising g; inf where g never gets there."""

    @abstractmethod
    def inverse_moment(self, moment: ArrayLike) -> FloatArray:
        """The x in m at which the first moment has the given value, for rising g."""

    def integral(self, x: ArrayLike) -> FloatArray:
        """The integral int_0^x g(t) dt in m^2."""
        return np.asarray(x, dtype=float) * self.g(x) - self.moment(x)

    def pressure_integral(self, r: ArrayLike, a: float) -> FloatArray:
        """The integral int_r^a g'(x) / sqrt(x^2 - r^2) dx."""
        return abel.edge_average(self.slope, r, a, breakpoints=self.breakpoints, corners=self.corners)

    def upto(self, top: float) -> EquivalentProfile:
        """The same profile made fast on [0, top]."""
        return self


def rising_root(
    curve: Callable[[FloatArray], FloatArray], target: ArrayLike, low: ArrayLike, high: ArrayLike
) -> FloatArray:
    """
    Solve curve(x) = target for a rising curve inside a bracket, for arrays, to rounding error.

    Parameters
    ----------
    curve : callable
        Rising, on arrays.
    target, low, high : array_like
        Values and brackets, broadcast together.

    Returns
    -------
    ndarray

    Raises
    ------
    ConvergenceError
        If a root is not inside its bracket.

    Notes
    -----
    Chandrupatla (1997), from ``scipy.optimize.elementwise``; its tolerance is relative to the root, so a
    nanometre is found as exactly as a metre.

    Examples
    --------
    >>> bool(abs(rising_root(lambda x: x**2, 2.0, 1.0, 2.0) - 2**0.5) < 1e-15)
    True
    """
    from scipy.optimize import elementwise

    y, start, stop = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (target, low, high)))
    below, above = curve(start) - y, curve(stop) - y
    answer = np.where(np.abs(below) <= np.abs(above), start, stop)
    open_ = (below < 0.0) & (above > 0.0)
    missed = ~open_ & ~(np.minimum(np.abs(below), np.abs(above)) <= 1e-12 * np.abs(y))
    if missed.any():
        raise ConvergenceError(
            f"no root between {start[missed][0]:g} and {stop[missed][0]:g} for {y[missed][0]:g}"
        )
    if open_.any():
        found = elementwise.find_root(
            lambda x, y: curve(x) - y, (start[open_], stop[open_]), args=(y[open_],)
        )
        if not np.all(found.success):
            raise ConvergenceError(f"root search stopped at {found.x[~found.success][0]:g}")
        answer[open_] = found.x
    return answer
