"""The table of a(d), F_N(d) and W(d) that the kernels read, right relative to its own size at every depth.

The depths are cut at marks, where a(d) is not smooth. In each segment the offset from the mark at its shallow end is
graded by octaves in eight parts, so that the leading bits of the offset are the index of a piece. A piece holds a
polynomial of a; F_N and W are its exact integrals, summed over the pieces before, all of them positive, so that
dF_N/dd = 2 E* a and dW/dd = F_N hold to rounding. Pieces that do not fit are cut into equal parts. The grading ends
at a floor: where the rest toward the mark is one polynomial or b + c offset^q.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.units import FloatArray, metres

IntArray: TypeAlias = NDArray[np.int64]
Radius: TypeAlias = Callable[[FloatArray], FloatArray]

# Columns of the first row; what counts or points to rows is kept as the bits of an integer
MODULUS, EXPONENT, INVERSE, PER_COEFFICIENT, UNIT, FORCE_FACTOR, WORK_FACTOR, REACH = range(8)
FIRST_MARK, LOOKUP, LOOKUP_LOWEST, LOOKUP_SHIFT, NEAR, FLOOR_FORCE, FULL_FORCE = range(8, 15)
SEGMENT = 1
"""Row of the first segment."""
ORIGIN, LOWEST, FIRST, PER_FLOOR = range(4)
KIND, CHILD, PARTS = range(3)
PIECE, PARTED, CLOSED = range(3)
"""Kinds of rows: a, F_N and W as polynomials; cut in equal parts; b + c z^q."""
B, C, Q, PER_WIDTH, FORCE, FORCE_B, FORCE_C, WORK, WORK_B, WORK_C = range(1, 11)
"""Columns of a closed floor."""
TERMS = 8
COLUMNS = 1 + TERMS + (TERMS + 1) + (TERMS + 2)
PER_ROW = 16
"""Entries in a row of the look-up of segments and of depths by force."""
BITS = 3
"""An octave has 2^BITS pieces."""

_CHEBYSHEV = 0.5 - 0.5 * np.cos(np.pi * (np.arange(TERMS) + 0.5) / TERMS)
_NODES = np.concatenate(
    [_CHEBYSHEV, [0.0, 0.1464466, 0.5, 0.8535534, 1.0]]
)  # the ends, or a step there is unseen
_ORDER = np.argsort(_NODES)
_DEEPEST = 170  # octaves at which the grading ends in any case: 1e-51
_SURE = 100  # octaves down to which a(d) must be a contact radius
_WINDOW = 48  # octaves over which a closing power law is held against a(d)
_FEWEST = 20  # octaves above a closed floor: powers are slow
_CHUNK = 4  # octaves that are added before a floor is tried again
_RESOLVED = 9  # octaves from the spacing of floats at a mark to the floor
_UNDERFLOW = 1e-280
_VANISHING = 1e-150  # a of half an octave above that may underflow to 0
_GAIN = 0.1  # a part misses less than this of what the whole misses, or cutting gains nothing
_NOISE = 1e-9  # of a: what cutting does not reduce is noise below it
_MOST_PIECES = 200_000
_MOST_KEYS = 16_384


def _to_monomials() -> FloatArray:
    """Chebyshev polynomials on [0, 1] as rows of powers."""
    rows = [np.polynomial.chebyshev.cheb2poly(np.eye(TERMS)[i]) for i in range(TERMS)]
    composed = [np.polynomial.Polynomial(row)(np.polynomial.Polynomial([-1.0, 2.0])).coef for row in rows]
    return np.array([np.pad(row, (0, TERMS - row.size)) for row in composed])


_MONOMIALS = _to_monomials()
_PROJECTION = np.linalg.inv(np.polynomial.chebyshev.chebvander(2.0 * _CHEBYSHEV - 1.0, TERMS - 1)).T


class Table(NamedTuple):
    """The rows that the kernels read, and how well they fit."""

    rows: FloatArray
    misfit: float
    """Largest error of a that was found between the nodes, relative to a."""


class _Fit(NamedTuple):
    """Polynomials of a over t, offset = start + width t, and by how much of a they miss it between the nodes."""

    segment: IntArray
    start: FloatArray
    width: FloatArray
    radius: FloatArray
    misfit: FloatArray

    def of(self, which: NDArray[Any]) -> _Fit:
        """Some of the pieces."""
        return _Fit(*(values[which] for values in self))


class _Floors(NamedTuple):
    """What closes the segments from their marks to 2^edge."""

    edge: IntArray
    closed: NDArray[np.bool_]
    fit: _Fit
    """Where it is a polynomial."""
    law: FloatArray
    """b, c, q and width of b + c (offset / width)^q where it is closed."""


@dataclass(frozen=True)
class _Segments:
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

    def fit(self, segment: IntArray, start: FloatArray, width: FloatArray) -> _Fit:
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
            rest = a - _polynomial(radius, u)
            if np.max(np.abs(rest[:, :TERMS]) / a[:, :TERMS], initial=0.0) < 4e-16:
                break
            radius += (rest[:, :TERMS] @ _PROJECTION) @ _MONOMIALS
        misfit = np.max(np.abs(rest) / a, axis=1, initial=0.0)
        partial = np.flatnonzero(~whole)
        ahead = (start - low)[partial] / size[partial, 0]
        radius[partial] = _moved(radius[partial], ahead, width[partial] / size[partial, 0])
        return _Fit(segment, start, width, radius, np.where(np.isfinite(misfit), misfit, math.inf))


def tabulate(function: Radius, depth: float, modulus: float, marks: ArrayLike, tolerance: float) -> Table:
    """The table of a contact radius; see :func:`pymdr.line.friction.tabulated_curves`."""
    segments = _cut(function, np.asarray(marks, dtype=float).ravel(), depth)
    floors = _floors(segments, modulus, tolerance)
    lowest = (floors.edge + 1023) << BITS
    counts = np.maximum(_key(segments.length, BITS) - lowest + 1, 0)
    counts[segments.length <= 0.0] = 0
    segment = np.repeat(np.arange(counts.size), counts)
    key = lowest[segment] + np.arange(segment.size) - np.repeat(np.cumsum(counts) - counts, counts)
    start, after = _value(key, BITS), _value(key + 1, BITS)
    return _Builder(segments, modulus, tolerance).table(
        floors, lowest, counts, segments.fit(segment, start, after - start)
    )


def check_radius(a: FloatArray, d: FloatArray) -> None:
    """Refuse what is no contact radius; a and d rise along the last axis."""
    bad = ~(np.isfinite(a) & (a > 0.0))
    bad[..., 1:] |= np.diff(a, axis=-1) < -_NOISE * a[..., 1:]
    if bad.any():
        where = tuple(np.argwhere(bad)[0])
        raise ProblemError(
            f"tabulated_curves: a({metres(d[where])}) = {metres(a[where])}; it must be finite, above 0 and not "
            "falling with the depth"
        )


def as_float(number: ArrayLike) -> Any:
    """The bits of integers as floats."""
    return np.asarray(number, dtype=np.int64).view(np.float64)


def _key(values: FloatArray, bits: int) -> IntArray:
    return values.view(np.int64) >> (52 - bits)


def _value(key: IntArray, bits: int) -> FloatArray:
    return (key << (52 - bits)).view(np.float64)


def _polynomial(coefficients: FloatArray, t: FloatArray) -> FloatArray:
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


def _cut(function: Radius, marks: FloatArray, depth: float) -> _Segments:
    """Segments between marks that floats can tell apart."""
    origins = [0.0]
    for mark in np.unique(marks[(marks > math.ldexp(depth, -_DEEPEST)) & (marks < depth)]):
        if mark - origins[-1] > 64.0 * np.spacing(mark) and depth - mark > 64.0 * np.spacing(depth):
            origins.append(float(mark))
    origin = np.array(origins)
    last = np.append(np.nextafter(origin[1:], 0.0), depth)
    return _Segments(function, origin, last, np.append(origin[1:], depth) - origin)


# --- floors: what closes a segment toward its mark ---------------------------------------------------------------


def _floors(segments: _Segments, modulus: float, tolerance: float) -> _Floors:
    count = segments.origin.size
    top = np.frexp(segments.length)[1].astype(np.int64)
    least = np.frexp(np.spacing(segments.origin))[1].astype(np.int64) + (_RESOLVED - 1)
    edge, closed, law = top.copy(), np.zeros(count, dtype=bool), np.zeros((count, 4))
    closed[0] = True
    edge[0], law[0] = _first_floor(segments, modulus, tolerance)
    empty = np.zeros(count)
    floor = _Fit(np.arange(count), empty.copy(), empty.copy(), np.zeros((count, TERMS)), empty.copy())
    active = np.arange(1, count)
    while active.size:
        fit = segments.fit(active, empty[active], np.ldexp(1.0, edge[active]))
        size = np.minimum(fit.width, segments.length[active])
        # wider, the nodes would be farther apart than those of other pieces
        done = (fit.misfit <= tolerance) & (size <= 0.25 * segments.origin[active])
        for stored, found in zip(floor, fit, strict=True):
            stored[active] = found
        deep = np.flatnonzero(~done & (edge[active] <= np.maximum(top[active] - _FEWEST, least[active])))
        law[active[deep]], misfit = _law(segments, active[deep], size[deep], tolerance)
        at_end = edge[active[deep]] <= least[active[deep]]
        ends = deep[(misfit <= tolerance) | at_end]
        closed[active[ends]] = True
        done[ends] = True
        active = active[~done]
        edge[active] = np.maximum(edge[active] - _CHUNK, least[active])
    return _Floors(edge, closed, floor, law)


def _law(
    segments: _Segments, segment: IntArray, width: FloatArray, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    """The law b + c (offset / width)^q through three offsets, and by how much of a it misses some between them."""
    parts = np.array([0.0, 2**-16, 2**-12, 2**-8, 1 / 32, 1 / 16, 1 / 8, 1 / 4, 3 / 8, 1 / 2, 3 / 4, 1.0])
    a, offset = segments.at(segment, width[:, None] * parts)
    z = offset / width[:, None]
    free = _through(a[:, 11], a[:, 7], a[:, 5], 4.0)
    _, c, q = free.T
    at_mark = np.asarray(segments.function(segments.origin[segment]), dtype=float)
    laws = np.stack(
        [
            _above(at_mark, a[:, 11], a[:, 7], 4.0),  # if a(d) does not step up there
            np.column_stack([np.maximum(a[:, 0] - c * z[:, 0] ** q, 0.0), c, q]),  # if b << c
            free,
        ]
    )
    misfit = np.max(np.abs(laws[..., :1] + laws[..., 1:2] * z ** laws[..., 2:] - a) / a, axis=-1)
    best = np.where(misfit[0] <= tolerance, 0, np.argmin(misfit, axis=0)), np.arange(segment.size)
    return np.column_stack([laws[best], width]), misfit[best]


def _above(b: FloatArray, a0: FloatArray, a1: FloatArray, ratio: float) -> FloatArray:
    """b, c and q of b + c z^q from b and its values at 1 and 1 / ratio."""
    c, second = np.maximum(a0 - b, 0.0), a1 - b
    rises = (second > 4e-16 * a0) & (c > 1.01 * second)
    return np.column_stack(
        [b, c, np.log(np.where(rises, c, ratio) / np.where(rises, second, 1.0)) / math.log(ratio)]
    )


def _through(a0: FloatArray, a1: FloatArray, a2: FloatArray, ratio: float) -> FloatArray:
    """b, c and q of b + c z^q from its values at 1, 1 / ratio and 1 / ratio^2."""
    first, second = a0 - a1, a1 - a2
    rises = (second > 4e-16 * a0) & (first > 1.01 * second)
    growth = np.where(rises, first, ratio) / np.where(rises, second, 1.0)
    c = np.maximum(first, 0.0) / (1.0 - 1.0 / growth)
    return np.column_stack([np.maximum(a0 - c, 0.0), np.minimum(c, a0), np.log(growth) / math.log(ratio)])


def _first_floor(segments: _Segments, modulus: float, tolerance: float) -> tuple[int, FloatArray]:
    """The octave below which a(d) is b + c d^q to rounding, and b, c, q and the width of the floor."""
    top = int(np.frexp(segments.length[0])[1]) - 1
    steps = np.arange(min(2 * (_DEEPEST + _WINDOW), 2 * (top + 1020)) + 1)
    d = np.ldexp(np.where(steps % 2, math.sqrt(0.5), 1.0), top - steps // 2)
    a = np.asarray(segments.function(d), dtype=float)
    with np.errstate(under="ignore", invalid="ignore"):
        held = np.minimum(a, 1.0) * np.minimum(d, 1.0) ** 2 * min(modulus, 1.0) > _UNDERFLOW
        good = np.isfinite(a) & ((a > 0.0) | (np.append(a[:1], a[:-1]) < _VANISHING))
        good[1:] &= a[1:] <= a[:-1] * (1.0 + _NOISE)
    good[0] &= bool(a[0] > 0.0)
    size = max(int(np.argmin(held)), 1) if not held.all() else held.size
    if not good[: size + 1].all():
        size = int(np.argmin(good))
        if size <= 2 * _SURE:
            check_radius(a[size::-1], d[size::-1])
    final = max(min(size - 17, 2 * _DEEPEST), 0) // 2 * 2
    best, law = math.inf, np.zeros(3)
    i = min(2 * _FEWEST, final)
    while True:
        window = a[i : min(i + 2 * _WINDOW, size - 1) + 1]
        octaves = 0.5 * np.arange(window.size)
        for candidate in _candidates(window):
            off = np.abs(candidate[0] + candidate[1] * 2.0 ** (-candidate[2] * octaves) - window) / window
            if (misfit := float(off.max())) < best:
                best, law = misfit, candidate
        if best <= 0.4 * tolerance or i >= final:
            break
        best = math.inf
        i = min(i + 2 * _CHUNK, final)
    return top - i // 2, np.append(law, d[i])


def _candidates(a: FloatArray) -> list[FloatArray]:
    """b, c and q of a power law, and of one above a plateau, from values at half octaves."""
    if a.size < 2:
        return [np.array([0.0, a[0], 1.0])]
    q = 2.0 * math.log2(a[0] / a[-1]) / (a.size - 1)
    laws = [np.array([0.0, a[0], q])] if q > 1e-13 else [np.array([a[0], 0.0, 1.0])]
    if a.size > 16:
        laws.append(_through(a[:1], a[8:9], a[16:17], 16.0)[0])
    return laws


# --- rows --------------------------------------------------------------------------------------------------------


class _Records(NamedTuple):
    """Pieces, and the rows where they stand."""

    fit: _Fit
    row: IntArray
    kind: IntArray
    child: IntArray
    parts: IntArray

    def added(self, other: _Records) -> _Records:
        fit = _Fit(*(np.concatenate(pair) for pair in zip(self.fit, other.fit, strict=True)))
        return _Records(fit, *(np.concatenate(pair) for pair in zip(self[1:], other[1:], strict=True)))


def _records(fit: _Fit, row: IntArray) -> _Records:
    zero = np.zeros(row.size, dtype=np.int64)
    return _Records(fit, row, zero, zero.copy(), zero.copy())


@dataclass(frozen=True)
class _Builder:
    """Cuts what does not fit, integrates and writes the rows."""

    segments: _Segments
    modulus: float
    tolerance: float

    def table(self, floors: _Floors, lowest: IntArray, counts: IntArray, bins: _Fit) -> Table:
        """First row, segments, look-up of segments, floors and pieces, depths near given forces."""
        number = counts.size
        lookup, first_row = self._lookup()
        floor = SEGMENT + number + lookup.shape[0] + np.cumsum(counts + 1) - counts - 1
        size = int(floor[-1] + counts[-1]) + 1
        in_order = np.arange(bins.start.size) - np.repeat(np.cumsum(counts) - counts, counts)
        smooth = np.flatnonzero(~floors.closed)
        records = _records(bins, floor[bins.segment] + 1 + in_order)
        records = records.added(_records(floors.fit.of(smooth), floor[smooth]))
        records, size = self._divided(records, size)
        rows = np.zeros((size, COLUMNS))
        rows[SEGMENT : SEGMENT + number, ORIGIN] = self.segments.origin
        rows[SEGMENT : SEGMENT + number, LOWEST] = as_float(lowest)
        rows[SEGMENT : SEGMENT + number, FIRST] = as_float(floor + 1)
        rows[SEGMENT : SEGMENT + number, PER_FLOOR] = np.ldexp(1.0, -floors.edge)
        rows[SEGMENT + number : SEGMENT + number + lookup.shape[0]] = lookup
        parted = records.kind == PARTED
        rows[records.row[parted], KIND] = as_float(PARTED)
        rows[records.row[parted], CHILD] = as_float(records.child[parted])
        rows[records.row[parted], PARTS] = records.parts[parted]
        depths, forces = self._integrate(rows, floors, floor, records)
        rows[0, REACH] = self.segments.last[-1]
        rows[0, MODULUS] = self.modulus
        rows[0, FIRST_MARK] = self.segments.origin[1] if number > 1 else math.inf
        rows[0, LOOKUP : LOOKUP + 3] = as_float(first_row)
        rows[0, NEAR] = as_float(size)
        rows[0, FLOOR_FORCE : FLOOR_FORCE + 2] = forces[[1, -1]]
        misfit = float(records.fit.misfit[~parted].max(initial=0.0))
        return Table(np.concatenate([rows, _inverse(depths, forces)]), misfit)

    def _divided(self, records: _Records, size: int) -> tuple[_Records, int]:
        """Pieces cut until they fit, or until cutting gains nothing."""
        active = np.arange(records.row.size)
        while True:
            fit = records.fit.of(active)
            fine = np.spacing(self.segments.origin[fit.segment] + fit.start)
            active = active[(fit.misfit > self.tolerance) & (fit.width > 64.0 * fine)]
            if not active.size:
                return records, size
            fit = records.fit.of(active)
            wanted = (fit.misfit / self.tolerance) ** (1.0 / TERMS)
            parts = np.where(wanted < 3.6, 4, np.where(wanted < 7.2, 8, 16))
            parent = np.repeat(np.arange(active.size), parts)
            place = np.arange(parent.size) - np.repeat(np.cumsum(parts) - parts, parts)
            width = (fit.width / parts)[parent]
            start = fit.start[parent] + width * place
            inside = start <= self.segments.length[fit.segment[parent]]
            parent, place = parent[inside], place[inside]
            part = self.segments.fit(fit.segment[parent], start[inside], width[inside])
            missed = np.bincount(parent, part.misfit > _GAIN * fit.misfit[parent], active.size)
            gained = (missed < 0.75 * np.bincount(parent, minlength=active.size)) | (fit.misfit > _NOISE)
            cut = active[gained]
            first = size + np.cumsum(parts * gained) - parts * gained
            size += int(np.sum(parts[gained]))
            if size > _MOST_PIECES:
                raise ConvergenceError(
                    f"tabulated_curves: more than {_MOST_PIECES} pieces; the misfit of a(d) is still "
                    f"{part.misfit.max():.1g} of a where {self.tolerance:.1g} is allowed: give a smoother a(d), the "
                    "marks at which it is not smooth, or a larger tolerance"
                )
            records.kind[cut] = PARTED
            records.child[cut] = first[gained]
            records.parts[cut] = parts[gained]
            kept = gained[parent]
            active = records.row.size + np.arange(np.count_nonzero(kept))
            records = records.added(_records(part.of(kept), (first[parent] + place)[kept]))

    def _integrate(
        self, rows: FloatArray, floors: _Floors, floor: IntArray, records: _Records
    ) -> tuple[FloatArray, FloatArray]:
        """Write what pieces and closed floors hold; their depths and forces at the start, with those at the end."""
        leaf = records.kind == PIECE
        fit, row = records.fit.of(leaf), records.row[leaf]
        closed = np.flatnonzero(floors.closed)
        b, c, q, law_width = floors.law[closed].T
        segment = np.concatenate([fit.segment, closed])
        start = np.concatenate([fit.start, np.zeros(closed.size)])
        size = np.concatenate([fit.width, np.ldexp(1.0, floors.edge[closed])])
        size = np.minimum(size, self.segments.span[segment] - start)
        width = fit.width[:, None]
        powers = np.arange(1, TERMS + 1)
        force = 2.0 * self.modulus * width * fit.radius / powers
        work = width * force / (powers + 1)
        t = size[: row.size, None] / width
        z = (size[row.size :] / law_width) ** q
        force_b, force_c = 2.0 * self.modulus * b, 2.0 * self.modulus * c / (q + 1.0)
        work_b, work_c = 0.5 * force_b, force_c / (q + 2.0)
        gained = np.concatenate(
            [_polynomial(force, t)[:, 0] * t[:, 0], size[row.size :] * (force_b + force_c * z)]
        )
        more = np.concatenate(
            [_polynomial(work, t)[:, 0] * t[:, 0] ** 2, size[row.size :] ** 2 * (work_b + work_c * z)]
        )
        order = np.lexsort((start, segment))
        force_at, force_end = _summed(gained, order)
        work_at, _ = _summed(more + force_at * size, order)
        rows[row, 1 : 1 + TERMS] = fit.radius
        rows[row, 1 + TERMS] = force_at[: row.size]
        rows[row, 2 + TERMS : 2 + 2 * TERMS] = force
        rows[row, 2 + 2 * TERMS] = work_at[: row.size]
        rows[row, 3 + 2 * TERMS] = force_at[: row.size] * fit.width
        rows[row, 4 + 2 * TERMS :] = work
        rows[floor[closed], KIND] = as_float(CLOSED)
        force_at_mark, work_at_mark = force_at[row.size :], work_at[row.size :]
        values = (b, c, q, 1.0 / law_width, force_at_mark, force_b, force_c, work_at_mark, work_b, work_c)
        rows[floor[closed], B : WORK_C + 1] = np.column_stack(values)
        depths = (self.segments.origin[segment] + start)[order]
        return np.append(depths, self.segments.last[-1]), np.append(force_at[order], force_end)

    def _lookup(self) -> tuple[FloatArray, tuple[int, int, int]]:
        """The last segment that begins before a key of a depth: rows; the first of them, lowest key, bits to drop."""
        origin, depth = self.segments.origin, self.segments.last[-1:]
        if origin.size == 1:
            return np.zeros((0, COLUMNS)), (0, 0, 0)
        for bits in range(8, -1, -1):
            lowest, highest = int(_key(origin[1:2], bits)[0]), int(_key(depth, bits)[0])
            if highest - lowest < _MOST_KEYS:
                break
        begin = _value(np.arange(lowest, highest + 2, dtype=np.int64), bits)
        last = np.searchsorted(origin, begin, side="right") - 1 + SEGMENT
        return _in_rows(as_float(last), PER_ROW), (SEGMENT + origin.size, lowest, 52 - bits)


def _summed(values: FloatArray, order: IntArray) -> tuple[FloatArray, float]:
    """Sums of what stands before each value in order, and of all."""
    sums = np.cumsum(values[order].astype(np.longdouble))
    before = np.empty_like(values)
    before[order] = np.concatenate([[0.0], sums[:-1]])
    return before, float(sums[-1])


def _inverse(depths: FloatArray, forces: FloatArray) -> FloatArray:
    """Depths near those of forces that begin an eighth of an octave, from the lowest one on: rows."""
    lowest, highest = _key(forces[[1, -1]], BITS)
    force = _value(np.arange(lowest, highest + 2), BITS)
    near = np.interp(np.log(force), np.log(forces[1:]), np.log(depths[1:]))
    return _in_rows(np.exp(near), PER_ROW)


def _in_rows(values: FloatArray, per_row: int) -> FloatArray:
    rows = np.zeros((-(-values.size // per_row), COLUMNS))
    padded = np.zeros(rows.shape[0] * per_row)
    padded[: values.size] = values
    rows[:, :per_row] = padded.reshape(-1, per_row)
    return rows
