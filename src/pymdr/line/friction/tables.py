"""The table of a(d), F_N(d) and W(d) that the kernels read, right relative to its own size at every depth.

The depths are cut at marks, where a(d) is not smooth. In each segment the offset from the mark at its shallow end is
graded by octaves in eight parts, so that the leading bits of the offset are the index of a piece. A piece holds a
polynomial of a; F_N and W are its exact integrals, summed over the pieces before, all of them positive, so that
dF_N/dd = 2 E* a and dW/dd = F_N hold to rounding. Pieces that do not fit are cut into equal parts. The grading ends
at a floor: where the rest toward the mark is one polynomial or b + c offset^q.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError
from pymdr.line.friction.floors import Floors, floors_of
from pymdr.line.friction.layout import (
    BITS,
    CHILD,
    CLOSED,
    COLUMNS,
    FIRST,
    FIRST_MARK,
    FLOOR_FORCE,
    KIND,
    LOOKUP,
    LOWEST,
    MODULUS,
    NEAR,
    ORIGIN,
    PARTED,
    PARTS,
    PER_FLOOR,
    PER_ROW,
    PIECE,
    REACH,
    SEGMENT,
    TERMS,
    WORK_C,
    B,
    IntArray,
    key_of,
    value_of,
)
from pymdr.line.friction.pieces import NOISE, Fit, Radius, Segments, polynomial, segments_of
from pymdr.units import FloatArray

_GAIN = 0.1  # a part misses less than this of what the whole misses, or cutting gains nothing
_MOST_PIECES = 200_000
_MOST_KEYS = 16_384


class Table(NamedTuple):
    """The rows that the kernels read, and how well they fit."""

    rows: FloatArray
    misfit: float
    """Largest error of a that was found between the nodes, relative to a."""


def tabulate(function: Radius, depth: float, modulus: float, marks: ArrayLike, tolerance: float) -> Table:
    """The table of a contact radius; see :func:`pymdr.line.friction.tabulated_curves`."""
    segments = segments_of(function, np.asarray(marks, dtype=float).ravel(), depth)
    floors = floors_of(segments, modulus, tolerance)
    lowest = (floors.edge + 1023) << BITS
    counts = np.maximum(key_of(segments.length, BITS) - lowest + 1, 0)
    counts[segments.length <= 0.0] = 0
    segment = np.repeat(np.arange(counts.size), counts)
    key = lowest[segment] + np.arange(segment.size) - np.repeat(np.cumsum(counts) - counts, counts)
    start, after = value_of(key, BITS), value_of(key + 1, BITS)
    return _Builder(segments, modulus, tolerance).table(
        floors, lowest, counts, segments.fit(segment, start, after - start)
    )


class _Records(NamedTuple):
    """Pieces, and the rows where they stand."""

    fit: Fit
    row: IntArray
    kind: IntArray
    child: IntArray
    parts: IntArray

    def added(self, other: _Records) -> _Records:
        fit = Fit(*(np.concatenate(pair) for pair in zip(self.fit, other.fit, strict=True)))
        return _Records(fit, *(np.concatenate(pair) for pair in zip(self[1:], other[1:], strict=True)))


def _records(fit: Fit, row: IntArray) -> _Records:
    zero = np.zeros(row.size, dtype=np.int64)
    return _Records(fit, row, zero, zero.copy(), zero.copy())


@dataclass(frozen=True)
class _Builder:
    """Cuts what does not fit, integrates and writes the rows."""

    segments: Segments
    modulus: float
    tolerance: float

    def table(self, floors: Floors, lowest: IntArray, counts: IntArray, bins: Fit) -> Table:
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
        rows[SEGMENT : SEGMENT + number, LOWEST] = lowest
        rows[SEGMENT : SEGMENT + number, FIRST] = floor + 1
        rows[SEGMENT : SEGMENT + number, PER_FLOOR] = np.ldexp(1.0, -floors.edge)
        rows[SEGMENT + number : SEGMENT + number + lookup.shape[0]] = lookup
        parted = records.kind == PARTED
        rows[records.row[parted], KIND] = PARTED
        rows[records.row[parted], CHILD] = records.child[parted]
        rows[records.row[parted], PARTS] = records.parts[parted]
        depths, forces = self._integrate(rows, floors, floor, records)
        rows[0, REACH] = self.segments.last[-1]
        rows[0, MODULUS] = self.modulus
        rows[0, FIRST_MARK] = self.segments.origin[1] if number > 1 else math.inf
        rows[0, LOOKUP : LOOKUP + 3] = first_row
        rows[0, NEAR] = size
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
            gained = (missed < 0.75 * np.bincount(parent, minlength=active.size)) | (fit.misfit > NOISE)
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
        self, rows: FloatArray, floors: Floors, floor: IntArray, records: _Records
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
            [polynomial(force, t)[:, 0] * t[:, 0], size[row.size :] * (force_b + force_c * z)]
        )
        more = np.concatenate(
            [polynomial(work, t)[:, 0] * t[:, 0] ** 2, size[row.size :] ** 2 * (work_b + work_c * z)]
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
        rows[floor[closed], KIND] = CLOSED
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
            lowest, highest = int(key_of(origin[1:2], bits)[0]), int(key_of(depth, bits)[0])
            if highest - lowest < _MOST_KEYS:
                break
        begin = value_of(np.arange(lowest, highest + 2, dtype=np.int64), bits)
        last = np.searchsorted(origin, begin, side="right") - 1 + SEGMENT
        return _in_rows(last.astype(float), PER_ROW), (SEGMENT + origin.size, lowest, 52 - bits)


def _summed(values: FloatArray, order: IntArray) -> tuple[FloatArray, float]:
    """Sums of what stands before each value in order, and of all."""
    sums = np.cumsum(values[order].astype(np.longdouble))
    before = np.empty_like(values)
    before[order] = np.concatenate([[0.0], sums[:-1]])
    return before, float(sums[-1])


def _inverse(depths: FloatArray, forces: FloatArray) -> FloatArray:
    """Depths near those of forces that begin an eighth of an octave, from the lowest one on: rows."""
    lowest, highest = key_of(forces[[1, -1]], BITS)
    force = value_of(np.arange(lowest, highest + 2), BITS)
    near = np.interp(np.log(force), np.log(forces[1:]), np.log(depths[1:]))
    return _in_rows(np.exp(near), PER_ROW)


def _in_rows(values: FloatArray, per_row: int) -> FloatArray:
    rows = np.zeros((-(-values.size // per_row), COLUMNS))
    padded = np.zeros(rows.shape[0] * per_row)
    padded[: values.size] = values
    rows[:, :per_row] = padded.reshape(-1, per_row)
    return rows
