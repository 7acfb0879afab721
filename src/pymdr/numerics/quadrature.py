"""Gauss rules, and integrals over panels with an error estimate by two rules."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
import scipy

from pymdr.units import FloatArray

LEVELS = (24, 48, 96, 192, 320)
TOLERANCE = 1e-13
_JACOBI_LEVELS = (12, 20, 32, 48, 96, 192)
_JACOBI_TOLERANCE = 3e-13
"""Gauss-Jacobi rules with a singular weight are accurate to about 1e-13, better with fewer nodes."""


@lru_cache(maxsize=64)
def gauss(n: int, exponent: float = 0.0) -> tuple[FloatArray, FloatArray]:
    """
    Nodes and weights on [0, 1] for the weight t^exponent (Gauss-Jacobi).

    Parameters
    ----------
    n : int
        Number of nodes.
    exponent : float
        Exponent of the weight at t = 0, above -1.

    Returns
    -------
    nodes, weights : ndarray, shape (n,)

    Examples
    --------
    >>> t, w = gauss(8)
    >>> bool(abs((w * t**3).sum() - 0.25) < 1e-15)
    True
    """
    if exponent == 0.0:
        nodes, weights = np.polynomial.legendre.leggauss(n)
    else:
        nodes, weights = scipy.special.roots_jacobi(n, 0.0, exponent)
    return (nodes + 1.0) / 2.0, weights / 2.0 ** (exponent + 1.0)


Integrand: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]
"""Called with the variable t and the column's parameter."""


@dataclass(frozen=True)
class Rule:
    """Options of the integration over panels."""

    exponent: float = 0.0
    """Exponent of the weight t^exponent."""
    power: int = 1
    """Panels are mapped by s^power from the lower end, or from the upper end if negative."""
    tip_power: int = 1
    """A panel that starts at t = 0 uses the weight in its rule, or is mapped by t = s^tip_power."""
    levels: tuple[int, ...] = LEVELS
    """Numbers of nodes, tried in order."""
    tolerance: float = TOLERANCE
    """Largest difference of two levels, relative to the integral of the absolute value."""
    noise: float = 0.0
    """Additional absolute tolerance."""


def _panel_sum(
    integrand: Integrand, edges: FloatArray, columns: FloatArray, n: int, rule: Rule
) -> tuple[FloatArray, FloatArray]:
    """Integral of t^exponent * integrand, and of its absolute value, over the panels of each column."""
    exponent, power, tip_power = rule.exponent, rule.power, rule.tip_power
    total = np.zeros(edges.shape[1])
    size = np.zeros(edges.shape[1])
    special_at_zero = exponent != 0.0 or tip_power > 1
    for low, high in pairwise(edges):
        for at_zero in (True, False) if special_at_zero else (False,):
            chosen = high > low
            if special_at_zero:
                chosen &= at_zero == (low == 0.0)
            if not chosen.any():
                continue
            inside: Any = slice(None) if chosen.all() else chosen
            start, width = low[inside], (high - low)[inside]
            weighted = at_zero and exponent != 0.0
            s, weights = gauss(n, exponent if weighted else 0.0)
            s, weights = s[:, None], weights[:, None] * width
            m = 1 if weighted else tip_power if at_zero and tip_power > 1 else abs(power)
            if m > 1:
                weights = weights * (m * s ** (m - 1))
                s = s**m
            downward = power < 0 and not weighted and m == -power
            offset = s * width
            t = high[inside] - offset if downward else start + offset
            values = integrand(t, columns[inside]) * weights
            if weighted:
                values = values * width**exponent
            elif exponent:
                values = values * t**exponent
            total[inside] += values.sum(axis=0)
            size[inside] += np.abs(values).sum(axis=0)
    return total, size


def integrate(integrand: Integrand, edges: FloatArray, columns: FloatArray, rule: Rule) -> FloatArray:
    """
    Integrate t^exponent * integrand(t, column) over the panels of each column, with error control.

    Parameters
    ----------
    integrand : callable
        Of t and the parameters of the columns, arrays that broadcast.
    edges : ndarray, shape (panels + 1, columns)
        Rising ends of the panels.
    columns : ndarray
        A parameter for every column.

    Returns
    -------
    ndarray
        Of the shape of `columns`; nan where no two rules agree.

    Examples
    --------
    >>> ends = np.array([[0.0, 0.0], [1.0, 2.0]])
    >>> integrate(lambda t, c: c * t, ends, np.array([2.0, 3.0]), Rule()).round(14).tolist()
    [1.0, 6.0]
    """
    levels, tolerance = rule.levels, rule.tolerance
    if rule.exponent != 0.0:
        levels, tolerance = _JACOBI_LEVELS, max(tolerance, _JACOBI_TOLERANCE)
    answer = np.full(columns.shape, math.nan)
    pending = np.arange(columns.size)
    coarse = np.full(columns.shape, math.inf)
    for n in levels:
        fine, size = _panel_sum(integrand, edges, columns[pending], n, rule)
        with np.errstate(invalid="ignore"):
            converged = np.abs(fine - coarse) <= tolerance * size + rule.noise
        answer[pending[converged]] = fine[converged]
        pending, edges, coarse = pending[~converged], edges[:, ~converged], fine[~converged]
        if pending.size == 0:
            break
    return answer
