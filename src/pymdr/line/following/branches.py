"""The monotone branches of a curve s -> D(s): all its folds, and tables that invert the rising branches.

The substitution s = p + (q - p) sin²(θ/2), and the same in D, makes half-integer powers at the ends of a segment smooth;
Chebyshev series on adaptively halved cells then resolve the segment.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ConvergenceError
from pymdr.numerics.panels import nodes, to_coefficients
from pymdr.numerics.roots import roots_of
from pymdr.numerics.table import Effort, Table, tabulated
from pymdr.units import FloatArray

_Function = Callable[[FloatArray], FloatArray]
_NODES = 12
_SLOPE_NODES = 24
_FINE = 4
_GRADES = 7.0
"""Number of cells graded toward the first state, each an eighth of the next; they are divided further where needed."""
_SETTLED = 3e-13
_NARROW = 1e-9
_MOST_CELLS = 40_000
_EPS = float(np.finfo(float).eps)


def turning_points(
    slope: _Function, start: float, stop: float, knots: tuple[float, ...]
) -> tuple[FloatArray, list[bool]]:
    """Return start, all folds and stop of a curve, and whether it rises on each segment between them.

    Parameters
    ----------
    slope : callable
        D'(s); finite inside (start, stop), except at `knots`. Zero counts as not rising.
    start, stop : float
        Range of s.
    knots : tuple of float
        Values of s where the slope is not smooth.

    Returns
    -------
    ndarray, list of bool
        The turning points [n + 1], exact to rounding, and the n directions, which alternate.

    Raises
    ------
    ConvergenceError
        When the slope is not piecewise smooth.

    Examples
    --------
    >>> points, rising = turning_points(np.cos, 0.0, 6.0, ())
    >>> np.allclose(points, [0, np.pi / 2, 3 * np.pi / 2, 6]), rising
    (True, [True, False, True])
    """
    marks = np.array([start, *sorted({k for k in knots if start < k < stop}), stop])
    # the first segment is graded toward the start, whose features may be far smaller than the range
    graded = start + (marks[1] - start) * 8.0 ** -np.arange(_GRADES, 0.0, -1.0)
    edges = np.unique(np.concatenate([marks, graded]))
    low, high = edges[:-1], edges[1:]
    fine = np.pi * (np.arange(_FINE * _SLOPE_NODES) + 0.5) / (_FINE * _SLOPE_NODES)
    to_fine = np.polynomial.chebyshev.chebvander(2.0 * fine / np.pi - 1.0, _SLOPE_NODES - 1)
    samples: list[tuple[FloatArray, FloatArray]] = []
    negligible, count = 1e-16 * (stop - start), 0
    for _ in range(80):
        count += low.size
        if count > _MOST_CELLS:
            break
        theta = np.pi * nodes(_SLOPE_NODES)
        s = _inside(low, high, theta)
        values = slope(s) * np.sin(theta)
        if not np.all(np.isfinite(values)):
            raise ConvergenceError(
                f"the slope of the curve is not finite at s = {s[~np.isfinite(values)][0]:.6g}; end the profile below it (max_radius)"
            )
        series = values @ to_coefficients(_SLOPE_NODES).T
        tail = np.max(np.abs(series[:, -3:]), axis=1)
        narrow = high - low <= np.maximum(1e-13 * np.maximum(np.abs(low), np.abs(high)), negligible)
        # rounding of s perturbs a slope that varies within few roundings of s
        shaken = 8.0 * _EPS * np.maximum(np.abs(low), np.abs(high)) / (high - low) * np.ptp(values, axis=1)
        done = (tail <= np.maximum(1e-9 * np.max(np.abs(series), axis=1), shaken)) | narrow
        samples.append((_inside(low[done], high[done], fine), (series[done] @ to_fine.T) / np.sin(fine)))
        middle = 0.5 * (low + high)[~done]
        low, high = np.concatenate([low[~done], middle]), np.concatenate([middle, high[~done]])
        if low.size == 0:
            return _alternating(slope, marks, samples)
    raise ConvergenceError(
        f"the slope of the curve is not smooth near s = {low[0]:.6g}; give its kinks as knots (breakpoints)"
    )


def _inside(low: FloatArray, high: FloatArray, angle: FloatArray) -> FloatArray:
    """Points strictly between the ends of cells, where a slope may be unbounded."""
    s = low[:, None] + (high - low)[:, None] * np.sin(0.5 * angle) ** 2
    inside: FloatArray = np.clip(s, np.nextafter(low, high)[:, None], np.nextafter(high, low)[:, None])
    return inside


def _alternating(
    slope: _Function, marks: FloatArray, samples: list[tuple[FloatArray, FloatArray]]
) -> tuple[FloatArray, list[bool]]:
    """Return the turning points and directions from resolved samples of the slope; see `turning_points`."""
    grid, values = (np.concatenate([pair[i] for pair in samples]) for i in (0, 1))
    # a slope that comes close to zero between samples and leaves again may hide two folds
    size = np.abs(values)
    dip = (size[:, 1:-1] < size[:, :-2]) & (size[:, 1:-1] <= size[:, 2:])
    curvature = size[:, 2:] - 2.0 * size[:, 1:-1] + size[:, :-2]
    with np.errstate(divide="ignore", invalid="ignore"):
        vertex = size[:, 1:-1] - (size[:, 2:] - size[:, :-2]) ** 2 / (8.0 * curvature)
    row, column = np.nonzero(dip & (vertex < 0.1 * np.maximum(size[:, 2:], size[:, :-2])))
    between = np.linspace(grid[row, column], grid[row, column + 2], 35)[1:-1].ravel()
    s, up = grid.ravel(), values.ravel() > 0.0
    if between.size:
        s, up = np.append(s, between), np.append(up, slope(between) > 0.0)
    order = np.argsort(s)
    s, up = s[order], up[order]

    at = np.flatnonzero(up[1:] != up[:-1])
    low, high = s[at], s[at + 1]
    rises = (slope(np.concatenate([low, high])) > 0.0).reshape(2, -1)
    real = rises[0] != rises[1]
    low, high = low[real], high[real]

    def signed(x: FloatArray) -> FloatArray:
        value = slope(x)
        return np.where(value > 0.0, value, np.minimum(value, -1e-280))

    folds = roots_of(signed, low, high)
    nearest = marks[np.clip(np.searchsorted(marks, folds), 0, marks.size - 1)]
    below = marks[np.clip(np.searchsorted(marks, folds) - 1, 0, marks.size - 1)]
    for mark in (nearest, below):
        folds = np.where(np.abs(folds - mark) <= 8.0 * _EPS * np.abs(mark), mark, folds)
    points = np.unique(np.concatenate([marks[:1], folds, marks[-1:]]))
    rising = slope(0.5 * (points[:-1] + points[1:])) > 0.0
    keep = np.concatenate([[True], rising[1:] != rising[:-1], [True]])
    return points[keep], [bool(x) for x in rising[keep[:-1]]]


@dataclass(frozen=True)
class Inverse:
    """Tables of s(D) on the rising branches of a curve; made by `inverse_of`, called with branches and D."""

    low: FloatArray
    """D at the lower ends of the branches."""
    high: FloatArray
    """D at their upper ends."""
    keys: FloatArray
    """Starts of the smooth segments of branches: branch index plus fraction of its D."""
    table: Table
    """S, and further functions of the states."""

    def __call__(self, branch: NDArray[np.intp], control: FloatArray) -> FloatArray:
        """Return s of the states with the given D on the given branches."""
        segment = branch
        if self.keys.size > self.low.size:
            low = self.low[branch]
            key = branch + (control - low) / (self.high[branch] - low)
            segment = np.searchsorted(self.keys, key, side="right") - 1
        return np.asarray(self.table(control, segment)[0])


Columns = Callable[[FloatArray, FloatArray], FloatArray]
"""Functions of s and D, shape (functions, n)."""


def inverse_of(
    control: _Function, bottom: FloatArray, top: FloatArray, knots: FloatArray, columns: Columns | None = None
) -> Inverse:
    """Return tables that invert D(s) on rising branches from s = bottom to s = top.

    Parameters
    ----------
    control : callable
        D(s), rising on every branch.
    bottom, top : ndarray
        Ends of the branches in s, rising.
    knots : ndarray
        Rising values of s where D is not smooth.
    columns : callable, optional
        Functions that are tabulated beside s.

    Returns
    -------
    Inverse
        Exact to about 1e-12 of s, or to the rounding of D where that is more.

    Examples
    --------
    >>> inverse = inverse_of(np.square, np.array([0.0]), np.array([3.0]), np.empty(0))
    >>> bool(abs(inverse(np.array([0]), np.array([2.0]))[0] - 2**0.5) < 1e-12)
    True
    """
    ends = [
        np.concatenate([[lo], knots[(knots > lo) & (knots < hi)], [hi]])
        for lo, hi in zip(bottom, top, strict=True)
    ]
    levels = [control(e) for e in ends]
    kept = [np.concatenate([[True], np.diff(D) > 0.0]) for D in levels]
    ends, levels = ([v[k] for v, k in zip(x, kept, strict=True)] for x in (ends, levels))
    p, q = (np.concatenate([e[part] for e in ends]) for part in (slice(None, -1), slice(1, None)))
    below, above = (np.concatenate([D[part] for D in levels]) for part in (slice(None, -1), slice(1, None)))
    low, high = np.array([D[0] for D in levels]), np.array([D[-1] for D in levels])
    keys = [i + (D[:-1] - D[0]) / (D[-1] - D[0]) for i, D in enumerate(levels)]

    def parameter(D: FloatArray, segment: NDArray[np.intp]) -> FloatArray:
        s = roots_of(lambda x, y: control(x) - y, p[segment], q[segment], D)
        return s[None] if columns is None else np.concatenate([s[None], columns(s, D)])

    size = max(np.max(np.abs(low)), np.max(np.abs(high)))
    effort = Effort(_NODES, _SETTLED, 16.0 * _EPS * size, _NARROW, _MOST_CELLS, graded=True)
    table = tabulated(parameter, below, above, effort)
    if not table.resolved:
        segment, _ = table.first_unresolved()
        raise ConvergenceError(
            f"the curve is not smooth between s = {p[segment]:.6g} and {q[segment]:.6g}; give its kinks as knots"
        )
    return Inverse(low, high, np.concatenate(keys), table)
