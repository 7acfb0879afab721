"""The kernels of a power-law graded half-space, E(z) ~ z^k, and the Abel integrals of a slope with them.

    g(x) = x^(1-k) int_0^x f' K dr,    K = (x^2 - r^2)^((k-1)/2),
    m(x) = int_0^x t^(1+k) g' dt = int_0^x f' r^2 K dr,
    g'(x) = x^-k [int_0^x (r f')' K dr + sum over kinks b of jump b K(b)],

Booker et al. (1985), Giannakopoulos and Suresh (1997), Hess (2016).
"""

from __future__ import annotations

import math

import numpy as np

from pymdr.mapping.abel_sums import AbelSums, Sums
from pymdr.mapping.octave_panels import GAUSS_NODES
from pymdr.mapping.resolving import Slopes
from pymdr.mapping.slopes import Tail
from pymdr.numerics.panels import IndexArray, Panels
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

_HALFWAY = 0.7
"""s above which 1 - s^2 is the more precise argument."""
_MILD = 0.6
"""|k| below which a root of higher order makes curves after a breakpoint smoother."""
_LEAST = float(np.finfo(float).tiny)
_RATIO = 4.0
"""Ratio of the distances from x of the ends of a segment on which the kernel is smooth."""


def arc_below(s: FloatArray, rest: FloatArray, k: float) -> FloatArray:
    """
    The integral cos(k pi/2) int_0^s t^k (1 - t^2)^(-(1+k)/2) dt, which is arcsin(s) for k = 0.

    Parameters
    ----------
    s : ndarray
        From 0 to 1.
    rest : ndarray
        1 - s^2, precise near s = 1.
    k : float
        Exponent of the grading.

    Examples
    --------
    >>> bool(abs(arc_below(np.ones(1), np.zeros(1), 0.3)[0] - math.pi / 2) < 1e-15)
    True
    """
    from scipy.special import betainc, betaincc

    p = 0.5 * (1.0 + k)
    inner, outer = betainc(p, 1.0 - p, s * s), betaincc(1.0 - p, p, rest)
    return np.asarray(0.5 * math.pi * np.where(s < _HALFWAY, inner, outer))


def arc_above(s: FloatArray, rest: FloatArray, k: float) -> FloatArray:
    """
    The difference of pi/2 and `arc_below`, which is arccos(s) for k = 0.

    Examples
    --------
    >>> bool(abs(arc_above(np.array([0.5]), np.array([0.75]), 0.0)[0] - math.pi / 3) < 1e-15)
    True
    """
    from scipy.special import betainc, betaincc

    p = 0.5 * (1.0 + k)
    inner, outer = betaincc(p, 1.0 - p, s * s), betainc(1.0 - p, p, rest)
    return np.asarray(0.5 * math.pi * np.where(s < _HALFWAY, inner, outer))


def fraction_below(s: FloatArray, k: float) -> FloatArray:
    """
    The integral int_0^s (1 - t^2)^((k-1)/2) dt, which is arcsin(s) for k = 0.

    Examples
    --------
    >>> bool(abs(fraction_below(np.ones(1), 0.0)[0] - math.pi / 2) < 1e-15)
    True
    """
    from scipy.special import beta, betainc

    p = 0.5 * (1.0 + k)
    return np.asarray(0.5 * beta(0.5, p) * betainc(0.5, p, s * s))


def power_fractions(n: float, k: float) -> tuple[float, float]:
    """
    Moment and square integral of g = c x^n, over x^(1+k) g and x^(1+k) g^2.

    Examples
    --------
    >>> power_fractions(1.0, 0.0) == (1 / 2, 1 / 3)
    True
    """
    rise = 1.0 + k
    return n / (n + rise), 2.0 * n * n / (rise * (n + rise) * (2.0 * n + rise))


def fraction_above(distance: FloatArray, k: float) -> FloatArray:
    """
    The integral int_(1-d)^1 (1 - t^2)^((k-1)/2) dt, to the precision of d.

    Examples
    --------
    >>> bool(abs(fraction_above(np.ones(1), 0.0)[0] - math.pi / 2) < 1e-15)
    True
    """
    from scipy.special import beta, betainc

    p = 0.5 * (1.0 + k)
    near = betainc(p, 0.5, distance * (2.0 - distance))
    far = 1.0 - betainc(0.5, p, (1.0 - distance) ** 2)
    return np.asarray(0.5 * beta(0.5, p) * np.where(distance < 0.5, near, far))


def root_order(k: float) -> float:
    """
    Order of the root of the distance from a breakpoint in which curves on a graded half-space are smooth.

    Curves contain the powers d^((1+k)/2) and d^((1-k)/2) of the distance d: integer powers of the root for k = 0, else powers
    of at least 2, or of at least 1 where offsets would underflow.

    Examples
    --------
    >>> root_order(0.0)
    2.0
    """
    if k == 0.0:
        return 2.0
    return (4.0 if abs(k) < _MILD else 2.0) / (1.0 - abs(k))


class GradedAbelSums(AbelSums):
    """
    The Abel integrals of a resolved slope for a graded half-space.

    Parameters
    ----------
    slopes : Slopes
        f' on panels.
    tail : Tail
        The power law below the first panel.
    exponent : float
        k of the grading.
    """

    def __init__(self, slopes: Slopes, tail: Tail, exponent: float) -> None:
        super().__init__(slopes, tail)
        self.exponent = exponent
        # the moments of quarter octaves are for the inverse square root only
        self.octave_count = self.first = 0

    def sums(self, panels: Panels, u: FloatArray) -> Sums:
        """g, m and g' on panels of shape (T,) at variables of shape (k,): each of shape (T, k)."""
        plain = super().sums(panels, u)
        scale = (panels.base[:, None] + panels.offsets(u)) ** -self.exponent
        return Sums(plain.g * scale, plain.moment, plain.slope * scale)

    def jump_error(self, base: FloatArray, offset: FloatArray) -> FloatArray:
        """Error of g' on panels, shape of `offset` (T, k), from the errors of the jumps of f'."""
        return super().jump_error(base, offset) * (base[:, None] + offset) ** -self.exponent

    def _root(self, square: FloatArray) -> FloatArray:
        return np.asarray(square ** (0.5 * (1.0 - self.exponent)))

    def _fraction_above(self, distance: FloatArray) -> FloatArray:
        return fraction_above(distance, self.exponent)

    def _add_adjacent(
        self, totals: FloatArray, panels: Panels, u: FloatArray, target: IndexArray, source: IndexArray
    ) -> None:
        self._add_near(totals, panels.base, panels.offsets(u), target, source)

    def _through_root(
        self, shift: FloatArray, offset: FloatArray, source: IndexArray, low: FloatArray, high: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Integrals over low <= r - b <= high and r < x, on segments proportional to their distance from x."""
        inner = np.maximum((shift - high) + offset, 0.0).ravel()
        outer = np.maximum((shift - low) + offset, 0.0).ravel()
        row = np.arange(inner.size) // offset.shape[1]
        place = (shift + offset).ravel()
        low, high = (
            np.broadcast_to(low[:, 0], offset.shape[:1]),
            np.broadcast_to(high[:, 0], offset.shape[:1]),
        )
        totals = np.zeros((3, inner.size))
        touching = np.flatnonzero((inner == 0.0) & (outer > 0.0))
        separated = np.flatnonzero((inner > 0.0) & (outer > inner))
        span = np.log(outer[separated]) - np.log(inner[separated])
        count = np.ceil(span / math.log(_RATIO)).astype(int).clip(1)
        index = np.repeat(separated, count)
        step = np.arange(index.size) - np.repeat(np.cumsum(count) - count, count)
        # halves of the powers, which do not overflow
        each = 0.5 * np.repeat(span / count, count)
        start = inner[index] * np.exp(step * each) * np.exp(step * each)
        stop = inner[index] * np.exp((step + 1) * each) * np.exp((step + 1) * each)
        gain = 0.5 * (1.0 + self.exponent)
        for i, begin, end, power in (
            (touching, np.zeros(touching.size), outer[touching], gain - 1.0),
            (index, start, stop, 0.0),
        ):
            if not i.size:
                continue
            s, weights = gauss(GAUSS_NODES, power)
            width = (end - begin)[:, None]
            gap = begin[:, None] + width * s
            t = row[i]
            r = np.clip(place[i][:, None] - gap, low[t][:, None], high[t][:, None])
            b = self.slopes.panels.base[source[t]][:, None]
            f, curvature = self._values(source[t], r)
            kernel = width ** (1.0 + power) * weights / self._root(2.0 * b + place[i][:, None] + r)
            if power == 0.0:
                kernel /= self._root(np.maximum(gap, _LEAST))
            f = f * kernel
            for total, part in zip(totals, (f, f * (b + r) ** 2, curvature * kernel), strict=True):
                total += np.bincount(i, part.sum(axis=1), total.size)
        result = totals.reshape(3, *offset.shape)
        return result[0], result[1], result[2]
