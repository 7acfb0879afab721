"""Segments of a record (approach, hold, retreat), detected from the change of its position."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from pymdr.units import FloatArray

_BLOCKS = 100
_SLOW = 0.1
"""Speed, relative to that of the record, below which a segment is a hold."""
_FRACTION = 0.25
"""Fraction of the distance that is moved at the speed of the record or more slowly; approach and retreat may differ
in speed."""
_LEAST = 8


class Segment(NamedTuple):
    """A stretch of samples."""

    name: str
    first: int
    end: int


def segments_in(position: FloatArray, time: FloatArray | None, numbers: FloatArray | None) -> list[Segment]:
    """
    Segments of a record.

    Parameters
    ----------
    position : ndarray
        In m, growing toward the body.
    time : ndarray or None
        In s; samples are taken to follow each other evenly unless given.
    numbers : ndarray or None
        Segment number of every sample, from the file; found from the motion unless given.

    Returns
    -------
    list of Segment
        Which hold all samples. A segment is a hold where the position changes, in the mean, at less than a tenth of the speed of the record, at
        or below which a quarter of all distance is moved.
    """
    clock = np.arange(float(position.size)) if time is None else time
    if numbers is not None:
        edges = [0, *(np.flatnonzero(np.diff(numbers) != 0.0) + 1).tolist(), position.size]
    else:
        edges = _turns(position, clock)
    edges = _long_enough(edges)
    pairs = list(itertools.pairwise(edges))
    speeds = [_speed(position[a:b], clock[a:b]) for a, b in pairs]
    durations = [float(clock[b - 1] - clock[a]) for a, b in pairs]
    usual = _usual(np.abs(speeds), np.asarray(durations))
    return [Segment(_named(v, usual), a, b) for v, (a, b) in zip(speeds, pairs, strict=True)]


def _speed(position: FloatArray, clock: FloatArray) -> float:
    ends = max(1, position.size // 50)
    moved = float(np.median(position[-ends:]) - np.median(position[:ends]))
    return moved / float(clock[-1] - clock[0])


def _usual(speeds: FloatArray, durations: FloatArray) -> float:
    """The speed of the record: a quarter of the distance is moved at it or more slowly."""
    order = np.argsort(speeds)
    moved = np.cumsum((speeds * durations)[order])
    return float(speeds[order][int(np.searchsorted(moved, _FRACTION * moved[-1]))])


def _named(speed: float, usual: float) -> str:
    if abs(speed) <= _SLOW * usual:
        return "hold"
    return "approach" if speed > 0.0 else "retreat"


def _long_enough(edges: list[int]) -> list[int]:
    """Edges without those that would cut off fewer samples than a curve has."""
    kept = [edges[0]]
    for edge in edges[1:-1]:
        if edge - kept[-1] >= _LEAST and edges[-1] - edge >= _LEAST:
            kept.append(edge)
    return [*kept, edges[-1]]


def _turns(position: FloatArray, clock: FloatArray) -> list[int]:
    """Where the motion changes between toward the body, rest and away from it."""
    size = max(4, position.size // _BLOCKS)
    starts = np.arange(0, max(position.size - size, 1), size)
    ends = np.append(starts[1:], position.size - 1)
    speeds = (position[ends] - position[starts]) / (clock[ends] - clock[starts])
    usual = _usual(np.abs(speeds), clock[ends] - clock[starts])
    kinds = np.where(np.abs(speeds) <= _SLOW * usual, 0, np.sign(speeds)).astype(int)
    # one block across a turn is no hold, and one against the others no motion
    for j in range(1, kinds.size - 1):
        if kinds[j] != kinds[j - 1] and kinds[j] != kinds[j + 1]:
            kinds[j] = kinds[j - 1]
    edges = [0]
    for k in (np.flatnonzero(np.diff(kinds)) + 1).tolist():
        first, end = max(int(starts[k]) - 2 * size, edges[-1]), min(int(starts[k]) + 2 * size, position.size)
        part = position[first:end]
        if kinds[k - 1] * kinds[k] < 0:
            edge = first + int(np.argmax(part) if kinds[k] < 0 else np.argmin(part)) + 1
        else:
            edge = first + _kink(clock[first:end], part)
        if edges[-1] < edge < position.size:
            edges.append(edge)
    return [*edges, position.size]


def _kink(x: FloatArray, y: FloatArray) -> int:
    """The place at which two lines that meet there have the smallest sum of squares."""
    best, least = x.size // 2, np.inf
    for k in range(2, x.size - 2):
        columns = np.stack([np.ones_like(x), x - x[k], np.clip(x - x[k], 0.0, None)], axis=1)
        left = float(np.sum((y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]) ** 2))
        if left < least:
            best, least = k, left
    return best
