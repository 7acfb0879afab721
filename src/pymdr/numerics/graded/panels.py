"""Panels of the segments of a function: polynomials with their errors between the nodes, and the innermost ones."""

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


_SURE = 100  # octaves down to which f must be finite, positive and rising
_WINDOW = 48  # octaves over which a power is compared with f
_FEWEST = 20  # octaves above a panel with a power: powers are slow
_CHUNK = 4  # octaves between two trials
_RESOLVED = 9  # octaves from the spacing of floats at a mark to the innermost panel
# some close to the mark, where the error of b is largest relative to c (offset / width)^q
_PARTS = np.concatenate(
    [[0.0], 2.0 ** np.arange(-48, -5, 4), [1 / 32, 1 / 16, 1 / 8, 1 / 4, 3 / 8, 1 / 2, 3 / 4, 1.0]]
)
_UNDERFLOW = 1e-280
_VANISHING = 1e-150  # below it, the next value may underflow to 0


class Innermost(NamedTuple):
    """The panels of all segments from their marks to the offsets 2^edge."""

    edge: IntArray
    power: NDArray[np.bool_]
    """Whether it is b + c z^q rather than a polynomial."""
    fit: Fit
    """The polynomials."""
    law: FloatArray
    """b, c, q and width of the powers b + c (offset / width)^q."""


def innermost_of(segments: Segments, factor: float, tolerance: float) -> Innermost:
    """The widest innermost panel of each segment that meets the tolerance."""
    count = segments.origin.size
    top = np.frexp(segments.length)[1].astype(np.int64)
    least = np.frexp(np.spacing(segments.origin))[1].astype(np.int64) + (_RESOLVED - 1)
    edge, power, law = top.copy(), np.zeros(count, dtype=bool), np.zeros((count, 4))
    power[0] = True
    edge[0], law[0] = _at_zero(segments, factor, tolerance)
    empty = np.zeros(count)
    innermost = Fit(np.arange(count), empty.copy(), empty.copy(), np.zeros((count, TERMS)), empty.copy())
    active = np.arange(1, count)
    while active.size:
        fit = segments.fit(active, empty[active], np.ldexp(1.0, edge[active]))
        size = np.minimum(fit.width, segments.length[active])
        # wider panels would have nodes that are farther apart than those of other panels
        done = (fit.error <= tolerance) & (size <= 0.25 * segments.origin[active])
        for stored, values in zip(innermost, fit, strict=True):
            stored[active] = values
        deep = np.flatnonzero(~done & (edge[active] <= np.maximum(top[active] - _FEWEST, least[active])))
        law[active[deep]], error = _law(segments, active[deep], size[deep], tolerance)
        at_end = edge[active[deep]] <= least[active[deep]]
        ends = deep[(error <= tolerance) | at_end]
        power[active[ends]] = True
        done[ends] = True
        active = active[~done]
        edge[active] = np.maximum(edge[active] - _CHUNK, least[active])
    return Innermost(edge, power, innermost, law)


def _law(
    segments: Segments, segment: IntArray, width: FloatArray, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    """The law b + c (offset / width)^q through three offsets, and its largest relative error between them."""
    f, offset = segments.at(segment, width[:, None] * _PARTS)
    z = offset / width[:, None]
    free = _through(f[:, -1], f[:, -5], f[:, -7], 4.0)
    _, c, q = free.T
    at_mark = np.asarray(segments.function(segments.origin[segment]), dtype=float)
    laws = np.stack(
        [
            _above(at_mark, f[:, -1], f[:, -5], 4.0),  # if f does not step up there
            np.column_stack([np.maximum(f[:, 0] - c * z[:, 0] ** q, 0.0), c, q]),  # if b << c
            free,
        ]
    )
    error = np.max(np.abs(laws[..., :1] + laws[..., 1:2] * z ** laws[..., 2:] - f) / f, axis=-1)
    best = np.where(error[0] <= tolerance, 0, np.argmin(error, axis=0)), np.arange(segment.size)
    return np.column_stack([laws[best], width]), error[best]


def _above(b: FloatArray, f0: FloatArray, f1: FloatArray, ratio: float) -> FloatArray:
    """b, c and q of b + c z^q from b and its values at 1 and 1 / ratio."""
    c, second = np.maximum(f0 - b, 0.0), f1 - b
    rises = (second > 4e-16 * f0) & (c > 1.01 * second)
    return np.column_stack(
        [b, c, np.log(np.where(rises, c, ratio) / np.where(rises, second, 1.0)) / math.log(ratio)]
    )


def _through(f0: FloatArray, f1: FloatArray, f2: FloatArray, ratio: float) -> FloatArray:
    """b, c and q of b + c z^q from its values at 1, 1 / ratio and 1 / ratio^2."""
    first, second = f0 - f1, f1 - f2
    rises = (second > 4e-16 * f0) & (first > 1.01 * second)
    growth = np.where(rises, first, ratio) / np.where(rises, second, 1.0)
    c = np.maximum(first, 0.0) / (1.0 - 1.0 / growth)
    return np.column_stack([np.maximum(f0 - c, 0.0), np.minimum(c, f0), np.log(growth) / math.log(ratio)])


def _at_zero(segments: Segments, factor: float, tolerance: float) -> tuple[int, FloatArray]:
    """The octave below which f is b + c x^q to rounding, with b, c, q and the width of that panel."""
    top = int(np.frexp(segments.length[0])[1]) - 1
    steps = np.arange(min(2 * (DEEPEST + _WINDOW), 2 * (top + 1020)) + 1)
    x = np.ldexp(np.where(steps % 2, math.sqrt(0.5), 1.0), top - steps // 2)
    f = np.asarray(segments.function(x), dtype=float)
    with np.errstate(under="ignore", invalid="ignore"):
        normal = np.minimum(f, 1.0) * np.minimum(x, 1.0) ** 2 * min(factor, 1.0) > _UNDERFLOW
        good = np.isfinite(f) & ((f > 0.0) | (np.append(f[:1], f[:-1]) < _VANISHING))
        good[1:] &= f[1:] <= f[:-1] * (1.0 + NOISE)
    good[0] &= bool(f[0] > 0.0)
    size = max(int(np.argmin(normal)), 1) if not normal.all() else normal.size
    if not good[: size + 1].all():
        size = int(np.argmin(good))
        if size <= 2 * _SURE:
            segments.check(f[size::-1], x[size::-1])
    final = max(min(size - 3, 2 * DEEPEST), 0) // 2 * 2
    best, law = math.inf, np.zeros(3)
    i = min(2 * _FEWEST, final)
    while True:
        window = f[i : min(i + 2 * _WINDOW, size - 1) + 1]
        octaves = 0.5 * np.arange(window.size)
        for candidate in _candidates(window):
            errors = np.abs(candidate[0] + candidate[1] * 2.0 ** (-candidate[2] * octaves) - window) / window
            if (error := float(errors.max())) < best:
                best, law = error, candidate
        if best <= 0.4 * tolerance or i >= final:
            break
        best = math.inf
        i = min(i + 2 * _CHUNK, final)
    return top - i // 2, np.append(law, x[i])


def _candidates(f: FloatArray) -> list[FloatArray]:
    """b, c and q of a power law, and of one above a plateau, from values at half octaves."""
    if f.size < 2:
        return [np.array([0.0, f[0], 1.0])]
    q = 2.0 * math.log2(f[0] / f[-1]) / (f.size - 1)
    laws = [np.array([0.0, f[0], q])] if q > 1e-13 else [np.array([f[0], 0.0, 1.0])]
    if f.size > 16:
        laws.append(_through(f[:1], f[8:9], f[16:17], 16.0)[0])
    return laws
