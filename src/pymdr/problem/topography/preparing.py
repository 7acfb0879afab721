"""Preparation of measured heights: subtraction of trends, filling or cropping of missing heights."""

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
    The heights minus a least-squares trend of the known heights.

    Parameters
    ----------
    trend : {"mean", "plane", "sphere", "curvature"}
        A constant; a plane; a plane and one curvature, (x^2 + y^2)/(2 R); or a plane and all terms of second order.

    Returns
    -------
    Topography
        Its last step describes the trend.

    Raises
    ------
    ProblemError
        If the trend is unknown, or too few heights are known for it.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> x, y = np.meshgrid(np.arange(8.0), np.arange(8.0), indexing="ij")
    >>> flat = mdr.Topography(1e-9 * (3.0 * x - y), "8 um").detrend("plane")
    >>> bool(np.max(np.abs(flat.heights)) < 1e-22)
    True
    >>> flat.steps
    ('a plane subtracted, of slope 0.003 along x and -0.001 along y',)
    """
    if not isinstance(trend, str) or trend not in TRENDS:
        raise ProblemError(f"trend = {shown(trend)}; it must be one of {', '.join(TRENDS)}")
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
    # normal equations by sums over the grid, to save memory
    masked = [column * known for column in columns]
    matrix = np.empty((len(columns), len(columns)))
    for i, column in enumerate(masked):
        for j, other in enumerate(columns[: i + 1]):
            matrix[i, j] = matrix[j, i] = float(np.sum(column * other))
    sides = np.array([float(np.sum(column * heights)) for column in masked])
    if np.linalg.matrix_rank(matrix, hermitian=True) < len(columns):
        raise ProblemError(
            f"{int(known.sum())} known heights do not determine a {trend}; use a trend of lower order"
        )
    terms = np.linalg.solve(matrix, sides)
    surface: FloatArray = middle + np.asarray(
        sum(c * column for c, column in zip(terms, columns, strict=True))
    )
    return replace(
        topography,
        heights=topography.heights - surface,
        steps=(*topography.steps, _trend_text(trend, middle, terms / scale, terms / scale**2)),
    )


def _trend_text(trend: str, middle: float, slopes: FloatArray, curvatures: FloatArray) -> str:
    if trend == "mean":
        return f"the mean subtracted, {metres(middle)}"
    plane = f"of slope {slopes[1]:.3g} along x and {slopes[2]:.3g} along y"
    if trend == "plane":
        return f"a plane subtracted, {plane}"
    if trend == "sphere":
        return f"a sphere subtracted, {_radius(2.0 * curvatures[3])}, {plane}"
    root = math.hypot(curvatures[3] - curvatures[5], curvatures[4])
    radii = " and ".join(_radius(float(curvatures[3] + curvatures[5] + sign * root)) for sign in (-1.0, 1.0))
    return f"a surface of second order subtracted, {radii}, {plane}"


def _radius(curvature: float) -> str:
    if curvature == 0.0:
        return "flat"
    return f"{'a cap' if curvature < 0.0 else 'a bowl'} of radius {metres(1.0 / abs(curvature))}"


def fill_missing(topography: Surface, remedy: str) -> Surface:
    """
    A surface without missing heights.

    Parameters
    ----------
    remedy : {"interpolate", "crop"}
        Fill missing heights by Laplace's equation, or crop to the largest rectangle without missing heights.

    Returns
    -------
    Topography
        Its last step gives the number of missing heights. The same topography if none is missing.

    Raises
    ------
    ProblemError
        If the remedy is unknown, more than half of the heights are to be filled, or less than 2 x 2 remain.

    Notes
    -----
    Filled heights are estimates without roughness or summits.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> heights = np.add.outer(np.arange(5.0), np.arange(4.0))
    >>> heights[2, 1] = np.nan
    >>> filled = mdr.Topography(heights, 1.0).fill_missing("interpolate")
    >>> round(float(filled.heights[2, 1]), 12)
    3.0
    >>> filled.steps
    ('1 of 20 heights were missing (5 %), filled by interpolation',)
    >>> mdr.Topography(heights, 1.0).fill_missing("crop").heights.shape
    (5, 2)
    """
    if not isinstance(remedy, str) or remedy not in REMEDIES:
        raise ProblemError(f"remedy = {shown(remedy)}; it must be one of {', '.join(REMEDIES)}")
    count, total = int(np.count_nonzero(topography.missing)), topography.heights.size
    if count == 0:
        return topography
    text = f"{count} of {total} heights were missing ({100.0 * count / total:.2g} %)"
    if remedy == "crop":
        rows, columns = _largest_rectangle(~topography.missing)
        part = topography.heights[rows, columns]
        if min(part.shape) < 2:
            raise ProblemError(f"{text}, so no complete rectangle of 2 x 2 remains; use 'interpolate'")
        size = topography.spacing * part.shape
        step = f"{text}, cropped to {part.shape[0]} x {part.shape[1]} from ({rows.start}, {columns.start}) on"
        return replace(topography, heights=part, size=size, steps=(*topography.steps, step))
    if 2 * count > total:
        raise ProblemError(f"{text}, more than half; use 'crop'")
    return replace(
        topography,
        heights=_continued(topography.heights, topography.spacing),
        steps=(*topography.steps, f"{text}, {_FILLED}"),
    )


def interpolated_fraction(topography: Heights) -> float:
    """
    The fraction of the heights that :func:`fill_missing` has interpolated, from its step.

    Examples
    --------
    >>> heights = np.add.outer(np.arange(5.0), np.arange(4.0))
    >>> heights[2, 1] = np.nan
    >>> from pymdr import Topography
    >>> interpolated_fraction(Topography(heights, 1.0).fill_missing("interpolate"))
    0.05
    """
    counted = (_COUNTED.fullmatch(step) for step in topography.steps)
    return sum(int(match[1]) / int(match[2]) for match in counted if match)


def _continued(heights: FloatArray, spacing: FloatArray) -> FloatArray:
    """Solve Laplace's equation for missing heights, with zero normal gradient at the edges of the patch."""
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
    indices = np.arange(count)
    matrix = coo_array(
        (np.append(v, diagonal), (np.append(i, indices), np.append(j, indices))), shape=(count, count)
    )
    filled = heights.copy()
    filled[gap] = middle + spsolve(csr_array(matrix), sides)
    return filled


def _shifted(axis: int, step: int) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """Slices of pixels, and of their neighbours on one side."""
    low, high, full = slice(None, -1), slice(1, None), slice(None)
    here, there = (low, high) if step > 0 else (high, low)
    return (
        tuple(here if k == axis else full for k in range(2)),
        tuple(there if k == axis else full for k in range(2)),
    )


def _largest_rectangle(known: np.ndarray) -> tuple[slice, slice]:
    """The largest rectangle of known pixels, by the largest rectangle under a histogram for each row."""
    area, best = 0, (slice(0, 0), slice(0, 0))
    depth = np.zeros(known.shape[1], dtype=int)
    for i, row in enumerate(known):
        depth = np.where(row, depth + 1, 0)
        if depth.max() * depth.size <= area:
            continue
        stack: list[tuple[int, int]] = []  # start and depth
        for j, d in enumerate([*depth.tolist(), 0]):
            start = j
            while stack and stack[-1][1] >= d:
                start, tall = stack.pop()
                if tall * (j - start) > area:
                    area = tall * (j - start)
                    best = slice(i - tall + 1, i + 1), slice(start, j)
            stack.append((start, d))
    return best
