"""Knots of exported laws: cubic Hermite interpolation, refined to a tolerance.

This is the output format, which twenty lines of C or CSV can read: few knots of a law and its slope over the depth, for the tolerance
of the user. Inside the package functions are tabulated by :mod:`pymdr.numerics`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.units import FloatArray

_WITHIN = np.array([0.01, 0.1, 0.21, 0.35, 0.5, 0.65, 0.79, 0.9])
"""Check points in an interval; the error of the slope of a cubic is largest near 0.21 and 0.79, at the tip near the start."""
_MIDDLE = int(np.searchsorted(_WITHIN, 0.5))
_FRACTION = 0.7
"""Allowed error at the check points relative to the tolerance, because it may be larger in between."""
_MOST = 20_000
_CLOSE = 1e-8
"""Width, relative to the parameter and its range, of intervals at a kink, which are not divided."""


@dataclass(frozen=True)
class Knots:
    """Two functions y and z of one coordinate u, with their slopes."""

    u: FloatArray
    y: FloatArray
    y_slope: FloatArray
    z: FloatArray
    z_slope: FloatArray

    def take(self, index: np.ndarray) -> Knots:
        """Some of the knots."""
        return Knots(*(getattr(self, name)[index] for name in self.__dataclass_fields__))

    def with_others(self, others: Knots, order: np.ndarray) -> Knots:
        """These and others, in an order."""
        return Knots(
            *(
                np.concatenate([getattr(self, name), getattr(others, name)])[order]
                for name in self.__dataclass_fields__
            )
        )

    def at(self, u: FloatArray) -> Knots:
        """The cubic Hermite interpolants of y and z, and the slope of y."""
        from scipy.interpolate import CubicHermiteSpline

        y = CubicHermiteSpline(self.u, self.y, self.y_slope)
        z = CubicHermiteSpline(self.u, self.z, self.z_slope)
        return Knots(u, y(u), y(u, 1), z(u), np.full(np.shape(u), np.nan))


Sample = Callable[[FloatArray], Knots]
Error = Callable[[Knots, Knots], FloatArray]


def adapted(sample: Sample, marks: FloatArray, error: Error, tolerance: float) -> Knots:
    """
    Knots whose interpolants have errors below a tolerance.

    Parameters
    ----------
    sample : callable
        Exact values and slopes at parameters; u increases with them.
    marks : ndarray
        Parameters between which the functions are smooth.
    error : callable
        Error of interpolated values (first) against exact ones, one number for each.

    Examples
    --------
    >>> def sample(x):
    ...     return Knots(x, np.exp(x), np.exp(x), x, np.ones(x.shape))
    >>> knots = adapted(sample, np.array([0.0, 1.0]), lambda ours, exact: np.abs(ours.y - exact.y), 1e-9)
    >>> x = np.linspace(0.0, 1.0, 1001)
    >>> bool(np.max(np.abs(knots.at(x).y - np.exp(x))) < 1e-9)
    True
    """
    x = marks
    knots = sample(x)
    settled = _narrow(x)
    while not settled.all():
        wide = np.flatnonzero(~settled)
        between = (x[wide, None] + np.diff(x)[wide, None] * _WITHIN).ravel()
        exact = sample(between)
        errors = error(knots.at(exact.u), exact).reshape(wide.size, -1)
        bad = ~(np.max(errors, axis=1) <= _FRACTION * tolerance)
        if x.size + np.count_nonzero(bad) > _MOST:
            raise ConvergenceError(
                f"{_MOST} knots have an error of {np.nanmax(errors):.2g} (limit {tolerance:g}, the tolerance); "
                "the law is rough at this scale: use a larger tolerance, or smooth the profile"
            )
        settled[wide[~bad]] = True
        middle = np.flatnonzero(bad) * _WITHIN.size + _MIDDLE
        at = np.concatenate([x, between[middle]])
        order = np.argsort(at, kind="stable")
        knots = knots.with_others(exact.take(middle), order)
        # both halves of a divided interval are checked again
        x, settled = (
            at[order],
            np.repeat(settled, np.where(np.isin(np.arange(settled.size), wide[bad]), 2, 1)),
        )
        settled |= _narrow(x)
    return knots


def _narrow(x: FloatArray) -> np.ndarray:
    """Whether intervals are too narrow to be divided."""
    return np.asarray(np.diff(x) <= _CLOSE * (np.abs(x[1:]) + x[-1] - x[0]))
