"""Pieces of a table: polynomials of a(d) over offsets from a mark, and by how much they miss it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ProblemError
from pymdr.line.friction.layout import TERMS, IntArray
from pymdr.units import FloatArray, metres

Radius: TypeAlias = Callable[[FloatArray], FloatArray]

_CHEBYSHEV = 0.5 - 0.5 * np.cos(np.pi * (np.arange(TERMS) + 0.5) / TERMS)
_BETWEEN = [0.0, 0.1464466, 0.5, 0.8535534, 1.0]  # the ends, or a step there is unseen
_NODES = np.concatenate([_CHEBYSHEV, _BETWEEN])
_ORDER = np.argsort(_NODES)
DEEPEST = 170  # octaves at which the grading ends in any case: 1e-51
NOISE = 1e-9  # of a: what cutting does not reduce is noise below it


def _to_monomials() -> FloatArray:
    """Chebyshev polynomials on [0, 1] as rows of powers."""
    rows = [np.polynomial.chebyshev.cheb2poly(np.eye(TERMS)[i]) for i in range(TERMS)]
    composed = [np.polynomial.Polynomial(row)(np.polynomial.Polynomial([-1.0, 2.0])).coef for row in rows]
    return np.array([np.pad(row, (0, TERMS - row.size)) for row in composed])


_MONOMIALS = _to_monomials()
_PROJECTION = np.linalg.inv(np.polynomial.chebyshev.chebvander(2.0 * _CHEBYSHEV - 1.0, TERMS - 1)).T


class Fit(NamedTuple):
    """Polynomials of a over t, offset = start + width t, and by how much of a they miss it between the nodes."""

    segment: IntArray
    start: FloatArray
    width: FloatArray
    radius: FloatArray
    misfit: FloatArray

    def of(self, which: NDArray[Any]) -> Fit:
        """Some of the pieces."""
        return Fit(*(values[which] for values in self))


@dataclass(frozen=True)
class Segments:
    """a(d) between marks, over the offset from the mark at the shallow end."""

    function: Radius
    origin: FloatArray
    last: FloatArray
    """Largest depth of each."""
    span: FloatArray
    """Offset of the next mark."""

    @property
    def length(self) -> FloatArray:
        """Largest offset of each."""
        return self.last - self.origin

    def at(self, segment: IntArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Radii at rising offsets, one row for each of the segments, and the offsets that depths can have."""
        origin = self.origin[segment, None]
        d = np.clip(origin + offset, np.nextafter(origin, math.inf), self.last[segment, None])
        a = np.asarray(self.function(d.ravel()), dtype=float).reshape(d.shape)
        check_radius(a, d)
        return a, d - origin

    def fit(self, segment: IntArray, start: FloatArray, width: FloatArray) -> Fit:
        """Polynomials on given pieces. One that ends beyond its segment is fitted over as much before the end."""
        length = self.length[segment]
        whole = start + width <= length
        low = np.where(whole, start, np.maximum(length - width, 0.0))
        high = np.where(whole, start + width, length)
        size = (high - low)[:, None]
        a = np.empty((start.size, _NODES.size))
        offset = np.empty_like(a)
        a[:, _ORDER], offset[:, _ORDER] = self.at(segment, low[:, None] + size * _NODES[_ORDER])
        u = (offset - low[:, None]) / size
        radius = (a[:, :TERMS] @ _PROJECTION) @ _MONOMIALS
        # beside a mark floats are so coarse that the nodes are not where they were asked for
        astray = np.flatnonzero(np.max(np.abs(u - _NODES), axis=1, initial=0.0) > 1e-4)
        bases = np.polynomial.chebyshev.chebvander(2.0 * u[astray, :TERMS] - 1.0, TERMS - 1)
        radius[astray] = np.linalg.solve(bases, a[astray, :TERMS, None])[..., 0] @ _MONOMIALS
        for _ in range(4):
            rest = a - polynomial(radius, u)
            if np.max(np.abs(rest[:, :TERMS]) / a[:, :TERMS], initial=0.0) < 4e-16:
                break
            radius += (rest[:, :TERMS] @ _PROJECTION) @ _MONOMIALS
        misfit = np.max(np.abs(rest) / a, axis=1, initial=0.0)
        partial = np.flatnonzero(~whole)
        ahead = (start - low)[partial] / size[partial, 0]
        radius[partial] = _moved(radius[partial], ahead, width[partial] / size[partial, 0])
        return Fit(segment, start, width, radius, np.where(np.isfinite(misfit), misfit, math.inf))


def check_radius(a: FloatArray, d: FloatArray) -> None:
    """Refuse what is no contact radius; a and d rise along the last axis."""
    bad = ~(np.isfinite(a) & (a > 0.0))
    bad[..., 1:] |= np.diff(a, axis=-1) < -NOISE * a[..., 1:]
    if bad.any():
        where = tuple(np.argwhere(bad)[0])
        raise ProblemError(
            f"tabulated_curves: a({metres(d[where])}) = {metres(a[where])}; it must be finite, above 0 and not "
            "falling with the depth"
        )


def polynomial(coefficients: FloatArray, t: FloatArray) -> FloatArray:
    """Polynomials, one in each row, at points, one or more in each row."""
    value = np.broadcast_to(coefficients[:, -1:], t.shape)
    for i in range(coefficients.shape[1] - 2, -1, -1):
        value = value * t + coefficients[:, i : i + 1]
    return value


def _moved(coefficients: FloatArray, ahead: FloatArray, scale: FloatArray) -> FloatArray:
    """Coefficients over t of polynomials of ahead + scale t."""
    moved = coefficients.copy()
    for i in range(TERMS - 1):
        for j in range(TERMS - 2, i - 1, -1):
            moved[:, j] += ahead * moved[:, j + 1]
    return moved * scale[:, None] ** np.arange(TERMS)


def segments_of(function: Radius, marks: FloatArray, depth: float) -> Segments:
    """Segments between marks that floats can tell apart."""
    origins = [0.0]
    for mark in np.unique(marks[(marks > math.ldexp(depth, -DEEPEST)) & (marks < depth)]):
        if mark - origins[-1] > 64.0 * np.spacing(mark) and depth - mark > 64.0 * np.spacing(depth):
            origins.append(float(mark))
    origin = np.array(origins)
    last = np.append(np.nextafter(origin[1:], 0.0), depth)
    return Segments(function, origin, last, np.append(origin[1:], depth) - origin)
