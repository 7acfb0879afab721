"""A curve on both sides of one kink as two branches; the kink is located by least squares."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from pymdr.mapping.callables.noise import EPS, Curve, orthonormal
from pymdr.units import FloatArray

SIDE_DEGREE, _PARTED_DEGREE = 10, 6
_NEAR = 0.7 ** np.arange(2.0, 62.0)
_NEAR_POINTS, _HALVINGS = 96, 8
_SLIGHT = 1e-2
"""Amplitude at a kink, over the largest one past it, below which the kink may be of higher order."""
_LIKE_A_KINK = 0.02
"""Largest difference of a fitted order from 1 at a kink."""


class _Fitted(NamedTuple):
    """Result of the least squares of a model."""

    b: float
    order: float
    level: float
    solution: FloatArray
    rest: FloatArray


@dataclass(frozen=True)
class Model:
    """P(r) + (r - b)_+^order Q(r) over radii on both sides of the stretch that holds b, or the same mirrored."""

    curve: Curve
    r: FloatArray
    values: FloatArray
    tolerance: float
    ends: tuple[float, float]
    """Interval that contains b."""
    start: float
    order: float
    free: bool
    """Whether the order is fitted too."""
    mirrored: bool

    def solved(self) -> tuple[float, float, bool] | None:
        """
        B and order by Gauss and Newton, and whether a higher order may do; None if b leaves the stretch or the model fails.

        It fails where it leaves more than rounding. Beside a kink of higher order there is always a place where one of a lower
        order with hardly an amplitude leaves no more.
        """
        fitted = self._fitted()
        if fitted is None or not self._meets(fitted):
            return None
        series = fitted.solution[SIDE_DEGREE + 1 :]
        amplitude = np.abs(chebyshev.chebval(np.linspace(-1.0, 1.0, 33), series))
        slight = bool(amplitude[0] < _SLIGHT * amplitude.max())
        if abs(fitted.order - 1.0) < _LIKE_A_KINK:
            return self._polished(fitted.b), 1.0, slight
        return fitted.b, fitted.order, slight

    def _polished(self, b: float) -> float:
        """A kink over ever shorter stretches, until no less is left: what is tolerated may be many roundings."""
        kink = replace(self, order=1.0, free=False, mirrored=False)
        before, after, left, t = b - self.r[0], self.r[-1] - b, math.inf, _one_sided_places()
        for _ in range(_HALVINGS):
            r = np.concatenate([b - before * t[::-1], b + after * t])
            fitted = replace(kink, r=r, values=self.curve(r), start=b)._fitted()
            if fitted is None:
                break
            b, last, left = fitted.b, left, float(np.linalg.norm(fitted.rest))
            if left > 0.7 * last:
                break
            before, after = 0.5 * before, 0.5 * after
        return b

    def _fitted(self) -> _Fitted | None:
        order, b = self.order, self.start
        half = 0.5 * (self.r[-1] - self.r[0])
        level = float(np.mean(self.values))
        width = self.ends[1] - self.ends[0]
        smooth = self._smooth(self.r)
        for step in range(24):
            beyond = self._beyond(self.r, b)
            inside = beyond > 0.0
            with np.errstate(divide="ignore", invalid="ignore"):
                power = np.where(inside, beyond**order, 0.0)
                steep = np.where(inside, order * beyond ** (order - 1.0), 0.0)
                growth = np.where(inside, power * np.log(np.where(inside, beyond, 1.0)), 0.0)
            series = self._past(self.r, b)
            matrix = np.column_stack([smooth, power[:, None] * series])
            scale = np.linalg.norm(matrix, axis=0)
            if not np.all(scale > 0.0) or not np.all(np.isfinite(scale)):
                return None
            q, triangle = orthonormal(np.asfortranarray(matrix / scale))
            if np.min(np.abs(np.diag(triangle))) < 1e-13:
                return None
            parts = q.T @ (self.values - level)
            rest = self.values - level - q @ parts
            solution = np.linalg.solve(triangle, parts) / scale
            amplitude = series @ solution[SIDE_DEGREE + 1 :]
            sign = -1.0 if self.mirrored else 1.0
            columns = [-sign * steep * amplitude / half] + ([growth * amplitude] if self.free else [])
            tangent = np.column_stack(columns)
            tangent = tangent - q @ (q.T @ tangent)
            sizes = np.linalg.norm(tangent, axis=0)
            if not np.all(np.isfinite(sizes)) or np.any(sizes == 0.0):
                return None
            change = np.linalg.lstsq(tangent / sizes, rest, rcond=1e-10)[0] / sizes
            shift = float(np.clip(change[0], -0.25 * width, 0.25 * width))
            b += shift
            if self.free:
                order += float(np.clip(change[1], -0.2, 0.2))
            if not self.ends[0] - 0.5 * width < b < self.ends[1] + 0.5 * width or not 0.02 < order < 6.0:
                return None
            if abs(shift) <= 2.0 * EPS * b and step > 1:
                break
        return _Fitted(b, order, level, solution, rest)

    def _meets(self, fitted: _Fitted) -> bool:
        """Whether only rounding is left, also next to the kink, where another one may be hidden."""
        if np.max(np.abs(fitted.rest)) > self.tolerance:
            return False
        b, (low, high) = fitted.b, self.ends
        near = b + (high - low) * np.concatenate([-(_NEAR[::-1]), _NEAR])
        near = np.unique(near[(near > low) & (near < high)])
        smooth, series = self._smooth(near), self._past(near, b)
        beyond = self._beyond(near, b)
        power = np.where(beyond > 0.0, beyond**fitted.order, 0.0)
        met = fitted.level + smooth @ fitted.solution[: SIDE_DEGREE + 1]
        met = met + power * (series @ fitted.solution[SIDE_DEGREE + 1 :])
        # where the curve is steep, the place itself is rounded
        place = 4.0 * EPS * b * np.abs(np.gradient(met, near)) if near.size > 2 else 0.0
        return bool(np.all(np.abs(self.curve(near) - met) <= self.tolerance + place))

    def _beyond(self, r: FloatArray, b: float) -> FloatArray:
        """Distances of radii past the kink, in half lengths of the interval."""
        past = b - r if self.mirrored else r - b
        return np.asarray(np.maximum(past / (0.5 * (self.r[-1] - self.r[0])), 0.0))

    def _smooth(self, r: FloatArray) -> FloatArray:
        """Chebyshev polynomials of P over the whole."""
        centre, half = 0.5 * (self.r[0] + self.r[-1]), 0.5 * (self.r[-1] - self.r[0])
        return np.asarray(chebyshev.chebvander((r - centre) / half, SIDE_DEGREE))

    def _past(self, r: FloatArray, b: float) -> FloatArray:
        """Chebyshev polynomials of Q past the kink."""
        largest = max(float(self._beyond(self.r[[0, -1]], b).max()), EPS)
        return np.asarray(chebyshev.chebvander(2.0 * self._beyond(r, b) / largest - 1.0, _PARTED_DEGREE))


@lru_cache(maxsize=1)
def _one_sided_places() -> FloatArray:
    """Places in (0, 1) on one side of a kink, denser toward both ends."""
    angles = np.pi * (np.arange(_NEAR_POINTS) + np.random.default_rng(7).random(_NEAR_POINTS)) / _NEAR_POINTS
    return np.asarray((1.0 - np.cos(angles)) / 2.0)
