"""Floors of a table: what closes a segment toward its mark."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymdr.line.friction.layout import TERMS, IntArray
from pymdr.line.friction.pieces import DEEPEST, NOISE, Fit, Segments, check_radius
from pymdr.units import FloatArray

_SURE = 100  # octaves down to which a(d) must be a contact radius
_WINDOW = 48  # octaves over which a closing power law is held against a(d)
_FEWEST = 20  # octaves above a closed floor: powers are slow
_CHUNK = 4  # octaves that are added before a floor is tried again
_RESOLVED = 9  # octaves from the spacing of floats at a mark to the floor
# close to the mark too: b may grow there by more than c (offset / width)^q does
_PARTS = np.concatenate(
    [[0.0], 2.0 ** np.arange(-48, -5, 4), [1 / 32, 1 / 16, 1 / 8, 1 / 4, 3 / 8, 1 / 2, 3 / 4, 1.0]]
)
_UNDERFLOW = 1e-280
_VANISHING = 1e-150  # a of half an octave above that may underflow to 0


class Floors(NamedTuple):
    """What closes the segments from their marks to 2^edge."""

    edge: IntArray
    closed: NDArray[np.bool_]
    fit: Fit
    """Where it is a polynomial."""
    law: FloatArray
    """b, c, q and width of b + c (offset / width)^q where it is closed."""


def floors_of(segments: Segments, modulus: float, tolerance: float) -> Floors:
    """The floors of all segments, tried from the widest down."""
    count = segments.origin.size
    top = np.frexp(segments.length)[1].astype(np.int64)
    least = np.frexp(np.spacing(segments.origin))[1].astype(np.int64) + (_RESOLVED - 1)
    edge, closed, law = top.copy(), np.zeros(count, dtype=bool), np.zeros((count, 4))
    closed[0] = True
    edge[0], law[0] = _first_floor(segments, modulus, tolerance)
    empty = np.zeros(count)
    floor = Fit(np.arange(count), empty.copy(), empty.copy(), np.zeros((count, TERMS)), empty.copy())
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
    return Floors(edge, closed, floor, law)


def _law(
    segments: Segments, segment: IntArray, width: FloatArray, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    """The law b + c (offset / width)^q through three offsets, and by how much of a it misses some between them."""
    a, offset = segments.at(segment, width[:, None] * _PARTS)
    z = offset / width[:, None]
    free = _through(a[:, -1], a[:, -5], a[:, -7], 4.0)
    _, c, q = free.T
    at_mark = np.asarray(segments.function(segments.origin[segment]), dtype=float)
    laws = np.stack(
        [
            _above(at_mark, a[:, -1], a[:, -5], 4.0),  # if a(d) does not step up there
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


def _first_floor(segments: Segments, modulus: float, tolerance: float) -> tuple[int, FloatArray]:
    """The octave below which a(d) is b + c d^q to rounding, and b, c, q and the width of the floor."""
    top = int(np.frexp(segments.length[0])[1]) - 1
    steps = np.arange(min(2 * (DEEPEST + _WINDOW), 2 * (top + 1020)) + 1)
    d = np.ldexp(np.where(steps % 2, math.sqrt(0.5), 1.0), top - steps // 2)
    a = np.asarray(segments.function(d), dtype=float)
    with np.errstate(under="ignore", invalid="ignore"):
        held = np.minimum(a, 1.0) * np.minimum(d, 1.0) ** 2 * min(modulus, 1.0) > _UNDERFLOW
        good = np.isfinite(a) & ((a > 0.0) | (np.append(a[:1], a[:-1]) < _VANISHING))
        good[1:] &= a[1:] <= a[:-1] * (1.0 + NOISE)
    good[0] &= bool(a[0] > 0.0)
    size = max(int(np.argmin(held)), 1) if not held.all() else held.size
    if not good[: size + 1].all():
        size = int(np.argmin(good))
        if size <= 2 * _SURE:
            check_radius(a[size::-1], d[size::-1])
    final = max(min(size - 3, 2 * DEEPEST), 0) // 2 * 2
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
