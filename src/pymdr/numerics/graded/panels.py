"""Polynomials of a function on panels of its segments, and their errors between the nodes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ProblemError
from pymdr.numerics.graded.layout import TERMS, IntArray
from pymdr.units import FloatArray

Rising: TypeAlias = Callable[[FloatArray], FloatArray]
Description: TypeAlias = Callable[[float, float], str]

_CHEBYSHEV = 0.5 - 0.5 * np.cos(np.pi * (np.arange(TERMS) + 0.5) / TERMS)
_BETWEEN = [0.0, 0.1464466, 0.5, 0.8535534, 1.0]  # with the ends, at which steps show
_NODES = np.concatenate([_CHEBYSHEV, _BETWEEN])
_ORDER = np.argsort(_NODES)
DEEPEST = 170  # octaves at which the grading ends in any case: 1e-51
NOISE = 1e-9  # relative to f: an error below it that division does not reduce is noise


def _to_monomials() -> FloatArray:
    """Chebyshev polynomials on [0, 1] as rows of powers."""
    rows = [np.polynomial.chebyshev.cheb2poly(np.eye(TERMS)[i]) for i in range(TERMS)]
    composed = [np.polynomial.Polynomial(row)(np.polynomial.Polynomial([-1.0, 2.0])).coef for row in rows]
    return np.array([np.pad(row, (0, TERMS - row.size)) for row in composed])


_MONOMIALS = _to_monomials()
_PROJECTION = np.linalg.inv(np.polynomial.chebyshev.chebvander(2.0 * _CHEBYSHEV - 1.0, TERMS - 1)).T


class Fit(NamedTuple):
    """Polynomials over t, offset = start + width t, with their largest relative errors between the nodes."""

    segment: IntArray
    start: FloatArray
    width: FloatArray
    terms: FloatArray
    error: FloatArray

    def of(self, which: NDArray[Any]) -> Fit:
        """Some of the panels."""
        return Fit(*(values[which] for values in self))


@dataclass(frozen=True)
class Segments:
    """A function between marks, over the offset from the mark at the lower end."""

    function: Rising
    describe: Description
    origin: FloatArray
    last: FloatArray
    """Largest argument of each."""
    span: FloatArray
    """Offset of the next mark."""

    @property
    def length(self) -> FloatArray:
        """Largest offset of each."""
        return self.last - self.origin

    def at(self, segment: IntArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values at rising offsets, one row for each segment, and the offsets of the nearest floats."""
        origin = self.origin[segment, None]
        x = np.clip(origin + offset, np.nextafter(origin, math.inf), self.last[segment, None])
        values = np.asarray(self.function(x.ravel()), dtype=float).reshape(x.shape)
        self.check(values, x)
        return values, x - origin

    def check(self, values: FloatArray, x: FloatArray) -> None:
        """Refuse values that are not finite, not positive, or fall along the last axis."""
        bad = ~(np.isfinite(values) & (values > 0.0))
        bad[..., 1:] |= np.diff(values, axis=-1) < -NOISE * values[..., 1:]
        if bad.any():
            where = tuple(np.argwhere(bad)[0])
            text = self.describe(float(x[where]), float(values[where]))
            raise ProblemError(f"{text}; it must be finite, above 0 and not falling")

    def fit(self, segment: IntArray, start: FloatArray, width: FloatArray) -> Fit:
        """Polynomials on panels. One that exceeds its segment is fitted over an equal width before the end."""
        length = self.length[segment]
        whole = start + width <= length
        low = np.where(whole, start, np.maximum(length - width, 0.0))
        high = np.where(whole, start + width, length)
        size = (high - low)[:, None]
        values = np.empty((start.size, _NODES.size))
        offset = np.empty_like(values)
        values[:, _ORDER], offset[:, _ORDER] = self.at(segment, low[:, None] + size * _NODES[_ORDER])
        u = (offset - low[:, None]) / size
        terms = (values[:, :TERMS] @ _PROJECTION) @ _MONOMIALS
        # next to a mark the spacing of floats displaces the nodes
        displaced = np.flatnonzero(np.max(np.abs(u - _NODES), axis=1, initial=0.0) > 1e-4)
        bases = np.polynomial.chebyshev.chebvander(2.0 * u[displaced, :TERMS] - 1.0, TERMS - 1)
        terms[displaced] = np.linalg.solve(bases, values[displaced, :TERMS, None])[..., 0] @ _MONOMIALS
        for _ in range(4):
            rest = values - polynomial(terms, u)
            if np.max(np.abs(rest[:, :TERMS]) / values[:, :TERMS], initial=0.0) < 4e-16:
                break
            terms += (rest[:, :TERMS] @ _PROJECTION) @ _MONOMIALS
        error = np.max(np.abs(rest) / values, axis=1, initial=0.0)
        partial = np.flatnonzero(~whole)
        ahead = (start - low)[partial] / size[partial, 0]
        terms[partial] = _moved(terms[partial], ahead, width[partial] / size[partial, 0])
        return Fit(segment, start, width, terms, np.where(np.isfinite(error), error, math.inf))


def polynomial(terms: FloatArray, t: FloatArray) -> FloatArray:
    """Polynomials, one per row, at points, one or more per row."""
    value = np.broadcast_to(terms[:, -1:], t.shape)
    for i in range(terms.shape[1] - 2, -1, -1):
        value = value * t + terms[:, i : i + 1]
    return value


def _moved(terms: FloatArray, ahead: FloatArray, scale: FloatArray) -> FloatArray:
    """Coefficients over t of polynomials of ahead + scale t."""
    moved = terms.copy()
    for i in range(TERMS - 1):
        for j in range(TERMS - 2, i - 1, -1):
            moved[:, j] += ahead * moved[:, j + 1]
    return moved * scale[:, None] ** np.arange(TERMS)


def segments_of(function: Rising, marks: FloatArray, largest: float, describe: Description) -> Segments:
    """Segments between marks that differ by more than rounding."""
    origins = [0.0]
    for mark in np.unique(marks[(marks > math.ldexp(largest, -DEEPEST)) & (marks < largest)]):
        if mark - origins[-1] > 64.0 * np.spacing(mark) and largest - mark > 64.0 * np.spacing(largest):
            origins.append(float(mark))
    origin = np.array(origins)
    last = np.append(np.nextafter(origin[1:], 0.0), largest)
    return Segments(function, describe, origin, last, np.append(origin[1:], largest) - origin)
