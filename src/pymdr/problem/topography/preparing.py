"""What is done to measured heights before they are used: trends are taken off, missing ones are filled or cut off."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.topography.heights import Heights, Surface
from pymdr.units import FloatArray, metres, shown

TRENDS = ("mean", "plane", "sphere", "curvature")
REMEDIES = ("interpolate", "crop")
_FILLED = "filled by interpolation"
_COUNTED = re.compile(rf"(\d+) of (\d+) heights were missing .*{_FILLED}")


def detrend(topography: Surface, trend: str) -> Surface:
    """
    The heights less the trend that lies nearest to them, by least squares over the heights that are known.

    Parameters
    ----------
    topography : Topography
    trend : {"mean", "plane", "sphere", "curvature"}
        A constant; a plane; a plane and one curvature, (x^2 + y^2)/(2 R); or a plane and all terms of second order.

    Returns
    -------
    Topography
        Its last step says what was taken off.

    Raises
    ------
    ProblemError
        If there is no such trend, or too few heights are known for it.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(8.0), np.arange(8.0), indexing="ij")
    >>> from pymdr import Topography
    >>> flat = Topography(1e-9 * (3.0 * x - y), "8 um").detrend("plane")
    >>> bool(np.max(np.abs(flat.heights)) < 1e-22)
    True
    >>> flat.steps
    ('a plane taken off, of slope 0.003 along x and -0.001 along y',)
    """
    if not isinstance(trend, str) or trend not in TRENDS:
        raise ProblemError(f"detrend: {shown(trend)}; a trend is one of {', '.join(TRENDS)}")
    scale = float(topography.size.max())
    x = (topography.x - 0.5 * topography.size[0])[:, None] / scale
    y = (topography.y - 0.5 * topography.size[1])[None, :] / scale
    columns = {
        "mean": [1.0 + 0.0 * x],
        "plane": [1.0 + 0.0 * x, x, y],
        "sphere": [1.0 + 0.0 * x, x, y, x * x + y * y],
        "curvature": [1.0 + 0.0 * x, x, y, x * x, x * y, y * y],
    }[trend]
    known = ~topography.missing
    middle = float(np.mean(topography.heights, where=known))
    heights = np.where(known, topography.heights - middle, 0.0)
    # sums over the grid, so that no matrix of all pixels stands in memory
    masked = [column * known for column in columns]
    matrix = np.empty((len(columns), len(columns)))
    for i, one in enumerate(masked):
        for j, other in enumerate(columns[: i + 1]):
            matrix[i, j] = matrix[j, i] = float(np.sum(one * other))
    sides = np.array([float(np.sum(one * heights)) for one in masked])
    if np.linalg.matrix_rank(matrix, hermitian=True) < len(columns):
        raise ProblemError(
            f"detrend: {int(known.sum())} known heights lie so that a {trend} is not told by them; take a trend of lower order"
        )
    found = np.linalg.solve(matrix, sides)
    off: FloatArray = middle + np.asarray(sum(c * column for c, column in zip(found, columns, strict=True)))
    return replace(
        topography,
        heights=topography.heights - off,
        steps=(*topography.steps, _told(trend, middle, found / scale, found / scale**2)),
    )


def _told(trend: str, middle: float, slopes: FloatArray, bends: FloatArray) -> str:
    if trend == "mean":
        return f"the mean taken off, {metres(middle)}"
    plane = f"of slope {slopes[1]:.3g} along x and {slopes[2]:.3g} along y"
    if trend == "plane":
        return f"a plane taken off, {plane}"
    if trend == "sphere":
        return f"a sphere taken off, {_radius(2.0 * bends[3])}, {plane}"
    root = math.hypot(bends[3] - bends[5], bends[4])
    radii = " and ".join(_radius(float(bends[3] + bends[5] + sign * root)) for sign in (-1.0, 1.0))
    return f"a surface of second order taken off, {radii}, {plane}"


def _radius(bend: float) -> str:
    if bend == 0.0:
        return "flat"
    return f"{'a cap' if bend < 0.0 else 'a bowl'} of radius {metres(1.0 / abs(bend))}"


def fill_missing(topography: Surface, remedy: str) -> Surface:
    """
    A surface without missing heights.

    Parameters
    ----------
    topography : Topography
    remedy : {"interpolate", "crop"}
        Fill them by the smoothest continuation, Laplace's equation, whose values are means of their neighbours; or cut down to the
        largest rectangle in which none is missing.

    Returns
    -------
    Topography
        Its last step says how many were filled or cut off. The same one, if nothing is missing.

    Raises
    ------
    ProblemError
        If there is no such remedy, more than half of the heights are missing and were to be filled, or nothing of 2 x 2 is left.

    Notes
    -----
    What is filled is a guess: it has no roughness of its own, and no summit.

    Examples
    --------
    >>> heights = np.add.outer(np.arange(5.0), np.arange(4.0))
    >>> heights[2, 1] = np.nan
    >>> from pymdr import Topography
    >>> filled = Topography(heights, 1.0).fill_missing("interpolate")
    >>> round(float(filled.heights[2, 1]), 12)
    3.0
    >>> filled.steps
    ('1 of 20 heights were missing (5 %), filled by interpolation',)
    >>> Topography(heights, 1.0).fill_missing("crop").heights.shape
    (5, 2)
    """
    if not isinstance(remedy, str) or remedy not in REMEDIES:
        raise ProblemError(
            f"fill_missing: {shown(remedy)}; missing heights are for one of {', '.join(REMEDIES)}"
        )
    count, total = int(np.count_nonzero(topography.missing)), topography.heights.size
    if count == 0:
        return topography
    told = f"{count} of {total} heights were missing ({100.0 * count / total:.2g} %)"
    if remedy == "crop":
        rows, columns = _largest_rectangle(~topography.missing)
        part = topography.heights[rows, columns]
        if min(part.shape) < 2:
            raise ProblemError(
                f"fill_missing: {told}, so that no rectangle of 2 x 2 is without gaps; interpolate them"
            )
        size = topography.spacing * part.shape
        step = (
            f"{told}, cut down to {part.shape[0]} x {part.shape[1]} from ({rows.start}, {columns.start}) on"
        )
        return replace(topography, heights=part, size=size, steps=(*topography.steps, step))
    if 2 * count > total:
        raise ProblemError(
            f"fill_missing: {told}, more than half of them; crop the surface to what was measured"
        )
    return replace(
        topography,
        heights=_continued(topography.heights, topography.spacing),
        steps=(*topography.steps, f"{told}, {_FILLED}"),
    )


def interpolated_share(topography: Heights) -> float:
    """
    The share of the heights that :func:`fill_missing` has interpolated, as its step says.

    Parameters
    ----------
    topography : Topography

    Returns
    -------
    float

    Examples
    --------
    >>> heights = np.add.outer(np.arange(5.0), np.arange(4.0))
    >>> heights[2, 1] = np.nan
    >>> from pymdr import Topography
    >>> interpolated_share(Topography(heights, 1.0).fill_missing("interpolate"))
    0.05
    """
    counted = (_COUNTED.fullmatch(step) for step in topography.steps)
    return sum(int(found[1]) / int(found[2]) for found in counted if found)


def _continued(heights: FloatArray, spacing: FloatArray) -> FloatArray:
    """Laplace's equation where heights are missing; no flow through the edges of the patch."""
    from scipy.sparse import coo_array, csr_array
    from scipy.sparse.linalg import spsolve

    gap = np.isnan(heights)
    count = int(gap.sum())
    number = np.full(heights.shape, -1)
    number[gap] = np.arange(count)
    diagonal, sides = np.zeros(count), np.zeros(count)
    entries: list[tuple[FloatArray, FloatArray, FloatArray]] = []
    middle = float(np.nanmean(heights))
    weights = (float(spacing.min()) / spacing) ** 2
    for axis, weight in enumerate(weights):
        for here, there in (_shifted(axis, 1), _shifted(axis, -1)):
            unknown = gap[here]
            own, other = number[here][unknown], number[there][unknown]
            diagonal += np.bincount(own, minlength=count) * weight
            inner = other >= 0
            entries.append((own[inner], other[inner], np.full(int(inner.sum()), -weight)))
            values = (heights[there][unknown] - middle)[~inner]
            sides += np.bincount(own[~inner], weight * values, minlength=count)
    i, j, v = (np.concatenate(part) for part in zip(*entries, strict=True))
    every = np.arange(count)
    matrix = coo_array(
        (np.append(v, diagonal), (np.append(i, every), np.append(j, every))), shape=(count, count)
    )
    filled = heights.copy()
    filled[gap] = middle + spsolve(csr_array(matrix), sides)
    return filled


def _shifted(axis: int, step: int) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """Where pixels lie, and where their neighbours on one side do."""
    low, high, everything = slice(None, -1), slice(1, None), slice(None)
    here, there = (low, high) if step > 0 else (high, low)
    return (
        tuple(here if k == axis else everything for k in range(2)),
        tuple(there if k == axis else everything for k in range(2)),
    )


def _largest_rectangle(known: np.ndarray) -> tuple[slice, slice]:
    """The rectangle of most pixels that are all known: the largest one under a histogram, row by row."""
    best, found = 0, (slice(0, 0), slice(0, 0))
    depth = np.zeros(known.shape[1], dtype=int)
    for i, row in enumerate(known):
        depth = np.where(row, depth + 1, 0)
        if depth.max() * depth.size <= best:
            continue
        stack: list[tuple[int, int]] = []  # where a depth began, and the depth
        for j, d in enumerate([*depth.tolist(), 0]):
            start = j
            while stack and stack[-1][1] >= d:
                start, tall = stack.pop()
                if tall * (j - start) > best:
                    best = tall * (j - start)
                    found = slice(i - tall + 1, i + 1), slice(start, j)
            stack.append((start, d))
    return found
