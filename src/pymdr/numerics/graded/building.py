"""Construction of graded tables: panels are divided until they meet the tolerance, integrated and written into rows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.numerics.graded import layout
from pymdr.numerics.graded.panels import NOISE, Fit, Innermost, Segments, innermost_of, polynomial
from pymdr.units import FloatArray

_GAIN = 0.1  # a part has less than this fraction of the error of the whole, or division gains nothing
_MOST_PANELS = 200_000
_MOST_KEYS = 16_384


def build(segments: Segments, factor: float, tolerance: float) -> tuple[FloatArray, float]:
    """The rows of a table, and its largest relative error between the nodes."""
    innermost = innermost_of(segments, factor, tolerance)
    lowest = (innermost.edge + 1023) << layout.BITS
    counts = np.maximum(layout.key_of(segments.length) - lowest + 1, 0)
    counts[segments.length <= 0.0] = 0
    segment = np.repeat(np.arange(counts.size), counts)
    key = lowest[segment] + np.arange(segment.size) - np.repeat(np.cumsum(counts) - counts, counts)
    start, after = layout.value_of(key), layout.value_of(key + 1)
    graded = segments.fit(segment, start, after - start)
    return _Builder(segments, factor, tolerance).table(innermost, lowest, counts, graded)


class _Records(NamedTuple):
    """Panels and their rows."""

    fit: Fit
    row: layout.IntArray
    kind: layout.IntArray
    child: layout.IntArray
    parts: layout.IntArray

    def joined(self, other: _Records) -> _Records:
        fit = Fit(*(np.concatenate(pair) for pair in zip(self.fit, other.fit, strict=True)))
        return _Records(fit, *(np.concatenate(pair) for pair in zip(self[1:], other[1:], strict=True)))


def _records(fit: Fit, row: layout.IntArray) -> _Records:
    zero = np.zeros(row.size, dtype=np.int64)
    return _Records(fit, row, zero, zero.copy(), zero.copy())


@dataclass(frozen=True)
class _Builder:
    """Divides panels, integrates and writes the rows."""

    segments: Segments
    factor: float
    tolerance: float

    def table(
        self, innermost: Innermost, lowest: layout.IntArray, counts: layout.IntArray, graded: Fit
    ) -> tuple[FloatArray, float]:
        """Header, segments, look-up of segments, panels, look-up of the inverse."""
        number = counts.size
        lookup, header = self._lookup()
        first = layout.SEGMENT + number + lookup.shape[0] + np.cumsum(counts + 1) - counts - 1
        size = int(first[-1] + counts[-1]) + 1
        in_order = np.arange(graded.start.size) - np.repeat(np.cumsum(counts) - counts, counts)
        smooth = np.flatnonzero(~innermost.power)
        records = _records(graded, first[graded.segment] + 1 + in_order)
        records = records.joined(_records(innermost.fit.of(smooth), first[smooth]))
        records, size = self._divided(records, size)
        rows = np.zeros((size, layout.COLUMNS))
        rows[layout.SEGMENT : layout.SEGMENT + number, layout.ORIGIN] = self.segments.origin
        rows[layout.SEGMENT : layout.SEGMENT + number, layout.LOWEST] = lowest
        rows[layout.SEGMENT : layout.SEGMENT + number, layout.FIRST] = first + 1
        rows[layout.SEGMENT : layout.SEGMENT + number, layout.PER_INNERMOST] = np.ldexp(1.0, -innermost.edge)
        rows[layout.SEGMENT + number : layout.SEGMENT + number + lookup.shape[0]] = lookup
        divided = records.kind == layout.DIVIDED
        rows[records.row[divided], layout.KIND] = layout.DIVIDED
        rows[records.row[divided], layout.CHILD] = records.child[divided]
        rows[records.row[divided], layout.PARTS] = records.parts[divided]
        x, integral = self._integrate(rows, innermost, first, records)
        rows[0, layout.FACTOR] = self.factor
        rows[0, layout.MAX] = self.segments.last[-1]
        rows[0, layout.COUNT] = number
        rows[0, layout.FIRST_MARK] = self.segments.origin[1] if number > 1 else math.inf
        rows[0, layout.LOOKUP : layout.LOOKUP + 3] = header
        rows[0, layout.NEAR] = size
        rows[0, layout.INNER_INTEGRAL : layout.INNER_INTEGRAL + 2] = integral[[1, -1]]
        error = float(records.fit.error[~divided].max(initial=0.0))
        # arguments near those at which the integral begins an eighth of an octave, from the lowest one on
        first, last = layout.key_of(integral[[1, -1]]).tolist()
        levels = layout.value_of(np.arange(first, last + 2))
        near = np.interp(np.log(levels), np.log(integral[1:]), np.log(x[1:]))
        return np.concatenate([rows, _in_rows(np.exp(near))]), error

    def _divided(self, records: _Records, size: int) -> tuple[_Records, int]:
        """Divide panels until they meet the tolerance, or until division gains nothing."""
        active = np.arange(records.row.size)
        while True:
            fit = records.fit.of(active)
            fine = np.spacing(self.segments.origin[fit.segment] + fit.start)
            active = active[(fit.error > self.tolerance) & (fit.width > 64.0 * fine)]
            if not active.size:
                return records, size
            fit = records.fit.of(active)
            wanted = (fit.error / self.tolerance) ** (1.0 / layout.TERMS)
            parts = np.where(wanted < 3.6, 4, np.where(wanted < 7.2, 8, 16))
            parent = np.repeat(np.arange(active.size), parts)
            place = np.arange(parent.size) - np.repeat(np.cumsum(parts) - parts, parts)
            width = (fit.width / parts)[parent]
            start = fit.start[parent] + width * place
            inside = start <= self.segments.length[fit.segment[parent]]
            parent, place = parent[inside], place[inside]
            part = self.segments.fit(fit.segment[parent], start[inside], width[inside])
            poor = np.bincount(parent, part.error > _GAIN * fit.error[parent], active.size)
            gained = (poor < 0.75 * np.bincount(parent, minlength=active.size)) | (fit.error > NOISE)
            cut = active[gained]
            first = size + np.cumsum(parts * gained) - parts * gained
            size += int(np.sum(parts[gained]))
            if size > _MOST_PANELS:
                raise ConvergenceError(
                    f"a table of {_MOST_PANELS} panels has a relative error of {part.error.max():.1g} "
                    f"(limit {self.tolerance:.1g}, the tolerance); use a smoother function, give the marks at which it "
                    "is not smooth, or use a larger tolerance"
                )
            records.kind[cut] = layout.DIVIDED
            records.child[cut] = first[gained]
            records.parts[cut] = parts[gained]
            kept = gained[parent]
            active = records.row.size + np.arange(np.count_nonzero(kept))
            records = records.joined(_records(part.of(kept), (first[parent] + place)[kept]))

    def _integrate(
        self, rows: FloatArray, innermost: Innermost, first: layout.IntArray, records: _Records
    ) -> tuple[FloatArray, FloatArray]:
        """Write the undivided panels; the arguments and integrals at their starts and at the end."""
        leaf = records.kind == layout.POLYNOMIAL
        fit, row = records.fit.of(leaf), records.row[leaf]
        power = np.flatnonzero(innermost.power)
        b, c, q, law_width = innermost.law[power].T
        segment = np.concatenate([fit.segment, power])
        start = np.concatenate([fit.start, np.zeros(power.size)])
        size = np.concatenate([fit.width, np.ldexp(1.0, innermost.edge[power])])
        size = np.minimum(size, self.segments.span[segment] - start)
        width = fit.width[:, None]
        powers = np.arange(1, layout.TERMS + 1)
        integral = self.factor * width * fit.terms / powers
        second = width * integral / (powers + 1)
        t = size[: row.size, None] / width
        z = (size[row.size :] / law_width) ** q
        integral_b, integral_c = self.factor * b, self.factor * c / (q + 1.0)
        second_b, second_c = 0.5 * integral_b, integral_c / (q + 2.0)
        gained = np.concatenate(
            [polynomial(integral, t)[:, 0] * t[:, 0], size[row.size :] * (integral_b + integral_c * z)]
        )
        more = np.concatenate(
            [polynomial(second, t)[:, 0] * t[:, 0] ** 2, size[row.size :] ** 2 * (second_b + second_c * z)]
        )
        order = np.lexsort((start, segment))
        integral_at, integral_end = _summed(gained, order)
        second_at, _ = _summed(more + integral_at * size, order)
        rows[row, 1 : 1 + layout.TERMS] = fit.terms
        rows[row, 1 + layout.TERMS] = integral_at[: row.size]
        rows[row, 2 + layout.TERMS : 2 + 2 * layout.TERMS] = integral
        rows[row, 2 + 2 * layout.TERMS] = second_at[: row.size]
        rows[row, 3 + 2 * layout.TERMS] = integral_at[: row.size] * fit.width
        rows[row, 4 + 2 * layout.TERMS :] = second
        rows[first[power], layout.KIND] = layout.POWER
        at_mark = integral_at[row.size :], second_at[row.size :]
        values = (
            b,
            c,
            q,
            1.0 / law_width,
            at_mark[0],
            integral_b,
            integral_c,
            at_mark[1],
            second_b,
            second_c,
        )
        rows[first[power], layout.B : layout.SECOND_C + 1] = np.column_stack(values)
        x = (self.segments.origin[segment] + start)[order]
        return np.append(x, self.segments.last[-1]), np.append(integral_at[order], integral_end)

    def _lookup(self) -> tuple[FloatArray, tuple[int, int, int]]:
        """Rows of the last segment that begins before a key of the argument; their first row, lowest key and dropped bits."""
        origin, largest = self.segments.origin, self.segments.last[-1:]
        if origin.size == 1:
            return np.zeros((0, layout.COLUMNS)), (0, 0, 0)
        for bits in range(8, -1, -1):
            lowest, highest = int(layout.key_of(origin[1:2], bits)[0]), int(layout.key_of(largest, bits)[0])
            if highest - lowest < _MOST_KEYS:
                break
        begin = layout.value_of(np.arange(lowest, highest + 2, dtype=np.int64), bits)
        last = np.searchsorted(origin, begin, side="right") - 1 + layout.SEGMENT
        return _in_rows(last.astype(float)), (layout.SEGMENT + origin.size, lowest, 52 - bits)


def _summed(values: FloatArray, order: layout.IntArray) -> tuple[FloatArray, float]:
    """The sums of all values before each one in order, and of all."""
    sums = np.cumsum(values[order].astype(np.longdouble))
    before = np.empty_like(values)
    before[order] = np.concatenate([[0.0], sums[:-1]])
    return before, float(sums[-1])


def _in_rows(values: FloatArray) -> FloatArray:
    rows = np.zeros((-(-values.size // layout.PER_ROW), layout.COLUMNS))
    padded = np.zeros(rows.shape[0] * layout.PER_ROW)
    padded[: values.size] = values
    rows[:, : layout.PER_ROW] = padded.reshape(-1, layout.PER_ROW)
    return rows
