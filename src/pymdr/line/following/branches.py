"""The monotone branches of a curve s -> D(s): all its folds, and tables that invert the rising branches.

Half-integer powers at the ends of a piece are made smooth, in s by s = p + (q - p) sin²(θ/2) and in D likewise;
then Chebyshev series resolve the piece on cells that are halved until the series has converged.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ConvergenceError
from pymdr.units import FloatArray

_Function = Callable[[FloatArray], FloatArray]
_NODES = 12
_SLOPE_NODES = 24
_FINE = 4
_GRADES = 7.0
"""Octants toward the first state; its cell is sampled down to 3e-6 of it, and divided where that shows more."""
_BLOCK = 8192
_MOST_CELLS = 40_000
_EPS = float(np.finfo(float).eps)


def _chebyshev_points(n: int) -> FloatArray:
    points: FloatArray = -np.cos(np.pi * (np.arange(n) + 0.5) / n)
    return points


def _chebyshev_fit(n: int) -> FloatArray:
    """Return the matrix from values at the points of the first kind to Chebyshev coefficients."""
    k = np.arange(n)
    fit: FloatArray = np.cos(np.outer(k, np.pi * (n - k - 0.5) / n)) * (2.0 / n)
    fit[0] *= 0.5
    return fit


_POINTS = _chebyshev_points(_NODES)
_FIT = _chebyshev_fit(_NODES)
_SLOPE_POINTS = _chebyshev_points(_SLOPE_NODES)
_SLOPE_FIT = _chebyshev_fit(_SLOPE_NODES)


def roots_of(
    function: Callable[..., FloatArray], low: FloatArray, high: FloatArray, *args: FloatArray
) -> FloatArray:
    """Return one root of function(x, *args) in every bracket, to rounding.

    Parameters
    ----------
    function : callable
        Of arrays x and `args`; of opposite sign (or zero) at the two ends of each bracket.
    low, high : ndarray
        Brackets, flat and of one length, as are `args`.

    Returns
    -------
    ndarray
        The roots.

    Raises
    ------
    ConvergenceError
        When a bracket holds no change of sign or does not close.

    Notes
    -----
    Chandrupatla (1997), from ``scipy.optimize.elementwise``.

    Examples
    --------
    >>> roots_of(lambda x, y: x**2 - y, np.zeros(2), np.full(2, 3.0), np.array([1.0, 4.0]))
    array([1., 2.])
    """
    if low.size == 0:
        return low.copy()
    from scipy.optimize import elementwise

    found = elementwise.find_root(function, (low, high), args=args)
    if not np.all(found.success):
        worst = int(np.flatnonzero(~found.success)[0])
        raise ConvergenceError(
            f"no root between {float(low[worst])!r} and {float(high[worst])!r} (last value {float(found.x[worst])!r})"
        )
    return np.asarray(found.x, dtype=np.float64)


def turning_points(
    slope: _Function, start: float, stop: float, knots: tuple[float, ...]
) -> tuple[FloatArray, list[bool]]:
    """Return start, all folds and stop of a curve, and whether it rises on each piece between them.

    Parameters
    ----------
    slope : callable
        D'(s); finite inside (start, stop) but perhaps at `knots`. Zero counts as not rising.
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
    # the first piece is graded toward the start, whose features may be far smaller than the range
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
        theta = 0.5 * np.pi * (_SLOPE_POINTS + 1.0)
        s = _inside(low, high, theta)
        values = slope(s) * np.sin(theta)
        if not np.all(np.isfinite(values)):
            raise ConvergenceError(
                f"the slope of the curve is not finite at s = {float(s[~np.isfinite(values)][0])!r}"
            )
        series = values @ _SLOPE_FIT.T
        tail = np.max(np.abs(series[:, -3:]), axis=1)
        narrow = high - low <= np.maximum(1e-13 * np.maximum(np.abs(low), np.abs(high)), negligible)
        # rounding of s shakes a slope that varies within few roundings of s
        shaken = 8.0 * _EPS * np.maximum(np.abs(low), np.abs(high)) / (high - low) * np.ptp(values, axis=1)
        done = (tail <= np.maximum(1e-9 * np.max(np.abs(series), axis=1), shaken)) | narrow
        samples.append((_inside(low[done], high[done], fine), (series[done] @ to_fine.T) / np.sin(fine)))
        middle = 0.5 * (low + high)[~done]
        low, high = np.concatenate([low[~done], middle]), np.concatenate([middle, high[~done]])
        if low.size == 0:
            return _alternating(slope, marks, samples)
    raise ConvergenceError(
        f"the slope of the curve is not smooth near s = {float(low[0])!r}; give its kinks as knots (breakpoints)"
    )


def _inside(low: FloatArray, high: FloatArray, angle: FloatArray) -> FloatArray:
    """Places between the ends of cells, where a slope may have no bound: never these, however few roundings they are apart."""
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
    s = np.concatenate([grid.ravel(), between])
    up = np.concatenate([values.ravel(), slope(between)]) > 0.0
    order = np.argsort(s)
    s, up = s[order], up[order]

    at = np.flatnonzero(up[1:] != up[:-1])
    low, high = s[at], s[at + 1]
    real = (slope(low) > 0.0) != (slope(high) > 0.0)
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
    """Tables of s(D) on the rising branches of a curve; made by `inverse_of`, called with branches and D.

    Attributes
    ----------
    low, high : ndarray
        D at the ends of the branches.
    piece_keys, piece_low, piece_high : ndarray
        Branches are split into smooth pieces: key = branch + share of its D, and the D of the ends.
    cell_keys, cell_low, cell_width : ndarray
        Pieces are split into cells of v = sqrt(D - low) / [sqrt(D - low) + sqrt(high - D)], in which s is
        smooth at folds: key = piece + v.
    coefficients : ndarray
        Powers of the local coordinate in (-1, 1) of every cell, highest first.
    """

    low: FloatArray
    high: FloatArray
    piece_keys: FloatArray
    piece_low: FloatArray
    piece_high: FloatArray
    cell_keys: FloatArray
    cell_low: FloatArray
    cell_width: FloatArray
    coefficients: FloatArray

    def __call__(self, branch: NDArray[np.intp], control: FloatArray) -> FloatArray:
        """Return s of the states with the given D on the given branches."""
        out = np.empty(control.size)
        for i in range(0, control.size, _BLOCK):
            part = slice(i, i + _BLOCK)
            self._block(branch[part], control[part], out[part])
        return out

    def _block(self, branch: NDArray[np.intp], control: FloatArray, s: FloatArray) -> None:
        """Write s of one block that stays in the cache."""
        piece = branch
        if self.piece_low.size > self.low.size:
            low = self.low[branch]
            key = branch + (control - low) / (self.high[branch] - low)
            piece = np.searchsorted(self.piece_keys, key, side="right") - 1
        share = np.sqrt(np.maximum(control - self.piece_low[piece], 0.0))
        share /= share + np.sqrt(np.maximum(self.piece_high[piece] - control, 0.0))
        cell = np.searchsorted(self.cell_keys, piece + np.minimum(share, 1.0 - _EPS), side="right") - 1
        x = (share - self.cell_low[cell]) * (2.0 / self.cell_width[cell]) - 1.0
        self.coefficients[0].take(cell, out=s, mode="clip")
        term = np.empty_like(s)
        for row in self.coefficients[1:]:
            s *= x
            s += row.take(cell, out=term, mode="clip")


def inverse_of(control: _Function, bottom: FloatArray, top: FloatArray, knots: FloatArray) -> Inverse:
    """Return tables that invert D(s) on rising branches from s = bottom to s = top.

    Parameters
    ----------
    control : callable
        D(s), rising on every branch.
    bottom, top : ndarray
        Ends of the branches in s, rising.
    knots : ndarray
        Rising values of s where D is not smooth.

    Returns
    -------
    Inverse
        Exact to about 1e-12 of s, or to the rounding of D where that is more.

    Raises
    ------
    ConvergenceError
        When D is not piecewise smooth.

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
    Dp, Dq = (np.concatenate([D[part] for D in levels]) for part in (slice(None, -1), slice(1, None)))
    low, high = np.array([D[0] for D in levels]), np.array([D[-1] for D in levels])
    keys = [i + (D[:-1] - D[0]) / (D[-1] - D[0]) for i, D in enumerate(levels)]

    piece = np.arange(p.size)
    start, end = np.zeros(p.size), np.ones(p.size)
    # graded toward the first state: a small contact deserves small absolute errors
    grade = 2.0 ** -np.arange(1.0, 13.0)
    piece = np.concatenate([piece, np.zeros(grade.size, dtype=np.intp)])
    start, end = np.concatenate([start, grade]), np.concatenate([end, 2.0 * grade])
    end[0] = grade[-1]
    done: list[tuple[FloatArray, ...]] = []
    count, size = 0, max(np.max(np.abs(low)), np.max(np.abs(high)))
    for _ in range(40):
        count += piece.size
        if count > _MOST_CELLS:
            break
        share = start[:, None] + (end - start)[:, None] * (0.5 * _POINTS + 0.5)
        D = Dp[piece, None] + (Dq - Dp)[piece, None] * (share**2 / (share**2 + (1.0 - share) ** 2))
        lo, hi = (np.repeat(v[piece], _NODES) for v in (p, q))
        s = roots_of(lambda x, y: control(x) - y, lo, hi, D.ravel()).reshape(D.shape)
        series = s @ _FIT.T
        tail = np.max(np.abs(series[:, -3:]), axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            noise = size * np.max(np.diff(s, axis=1) / np.diff(D, axis=1), axis=1)
        good = (tail <= 3e-13 * np.max(np.abs(s), axis=1)) | ~(tail > 16.0 * _EPS * noise)
        good |= end - start <= 1e-9
        done.append((piece[good].astype(np.float64), start[good], end[good], series[good]))
        piece, start, end = piece[~good], start[~good], end[~good]
        if piece.size == 0:
            break
        middle = 0.5 * (start + end)
        piece = np.concatenate([piece, piece])
        start, end = np.concatenate([start, middle]), np.concatenate([middle, end])
    if piece.size:
        raise ConvergenceError(
            f"the curve is not smooth between s = {float(p[piece[0]])!r} and {float(q[piece[0]])!r}; give its kinks as knots"
        )
    owner, start, end, series = (np.concatenate([part[i] for part in done]) for i in range(4))
    order = np.lexsort((start, owner))
    powers = np.array([_powers(row) for row in np.eye(_NODES)])
    return Inverse(
        low,
        high,
        np.concatenate(keys),
        Dp,
        Dq,
        (owner + start)[order],
        start[order],
        (end - start)[order],
        np.ascontiguousarray((series @ powers)[order, ::-1].T),
    )


def _powers(series: FloatArray) -> FloatArray:
    """Return the powers of a Chebyshev series, filled up to full length."""
    powers = np.polynomial.chebyshev.cheb2poly(series)
    return np.concatenate([powers, np.zeros(_NODES - powers.size)])
