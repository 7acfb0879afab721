"""Curves on adjacent panels: Chebyshev series in the offset from a breakpoint, times a local power.

A place on the line is a pair (base, offset): x = base + offset, where the base is 0 or a breakpoint. Next to a
breakpoint the offset keeps digits that x loses. A curve on a panel low <= offset <= high is

    value = (offset / high)^power * sum_j c_j T_j(2 u - 1),

where u runs from 0 to 1 with the offset or, on rooted panels, with a root of it (usually the square root).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, DTypeLike, NDArray

from pymdr.units import FloatArray

IndexArray: TypeAlias = NDArray[np.intp]
BoolArray: TypeAlias = NDArray[np.bool_]
Selection: TypeAlias = Any
"""An index of arrays."""

TERMS = 16
"""Chebyshev coefficients of every curve on a panel."""
_BLOCK = 1 << 13
"""Points evaluated at once, so that gathered coefficients stay in the cache."""
_ROUNDING = TERMS * float(np.finfo(float).eps)
"""Relative rounding of a sum of terms."""


class Place(NamedTuple):
    """
    Positions x = base + offset on the line in m; the offset keeps its digits next to the base. As an array, they are rounded.

    Examples
    --------
    >>> np.asarray(Place(np.ones(1), np.full(1, 0.5))).tolist()
    [1.5]
    """

    base: FloatArray
    offset: FloatArray

    @property
    def x(self) -> FloatArray:
        """The rounded positions in m."""
        return self.base + self.offset

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> FloatArray:
        return np.asarray(self.base + self.offset, dtype=dtype)

    def take(self, index: Selection) -> Place:
        """Some of the places."""
        return Place(self.base[index], self.offset[index])


Position: TypeAlias = ArrayLike | Place


def as_place(x: Position) -> Place:
    """Positions as places; plain ones count from 0."""
    if isinstance(x, Place):
        return x
    values = np.asarray(x, dtype=float)
    return Place(np.zeros(values.shape), np.abs(values))


@lru_cache(maxsize=8)
def nodes(n: int = TERMS) -> FloatArray:
    """Chebyshev points of the first kind on (0, 1), rising, shape (n,)."""
    points: FloatArray = np.sin(np.pi * (np.arange(n) + 0.5) / (2 * n)) ** 2
    points.flags.writeable = False
    return points


@lru_cache(maxsize=8)
def to_coefficients(n: int = TERMS) -> FloatArray:
    """Matrix from values at :func:`nodes` to Chebyshev coefficients, by discrete orthogonality."""
    # cosines of multiples of pi / 2n, reduced as integers to avoid rounding of angles
    turn = np.arange(n)[:, None] * (2 * n - 1 - 2 * np.arange(n)) % (4 * n)
    turn = np.minimum(turn, 4 * n - turn)
    sign = np.where(turn > n, -1.0, 1.0)
    turn = np.minimum(turn, 2 * n - turn)
    matrix = 2.0 / n * sign * np.sin(np.pi * (n - turn) / (2 * n))
    matrix[0] *= 0.5
    return np.asarray(matrix)


def basis(u: FloatArray, n: int = TERMS) -> FloatArray:
    """Values T_j(2 u - 1), shape (..., n)."""
    return np.asarray(chebyshev.chebvander(2.0 * u - 1.0, n - 1))


def basis_slope(u: FloatArray, n: int = TERMS) -> FloatArray:
    """Derivatives of T_j(2 u - 1) with respect to u, shape (..., n)."""
    return basis(u, n - 1) @ _differentiation(n)


@lru_cache(maxsize=8)
def _differentiation(n: int) -> FloatArray:
    return np.asarray(2.0 * chebyshev.chebder(np.eye(n), axis=0))


@dataclass(frozen=True)
class Panels:
    """Adjacent rising intervals on the line, arrays of shape (P,)."""

    base: FloatArray
    """Breakpoint b in m, or 0, from which offsets are counted."""
    low: FloatArray
    """Offset of the lower end in m."""
    high: FloatArray
    """Offset of the upper end in m."""
    rooted: BoolArray
    """Whether the variable is a root of the offset."""
    order: float = 2.0
    """Order of the root."""

    @property
    def count(self) -> int:
        """Number of panels."""
        return int(self.base.size)

    @property
    def width(self) -> FloatArray:
        """Lengths in m."""
        return self.high - self.low

    @property
    def start(self) -> FloatArray:
        """Lower ends x in m."""
        return self.base + self.low

    @property
    def stop(self) -> FloatArray:
        """Upper ends x in m."""
        return self.base + self.high

    def take(self, index: Selection) -> Panels:
        """Some of the panels."""
        base, low, high = self.base[index], self.low[index], self.high[index]
        return Panels(base, low, high, self.rooted[index], self.order)

    def offsets(self, u: FloatArray) -> FloatArray:
        """Offsets at variables u of shape (k,), or (P, k): shape (P, k)."""
        plain = self.low[:, None] + self.width[:, None] * u
        if not self.rooted.any():
            return plain
        low, high = self.root(self.low)[:, None], self.root(self.high)[:, None]
        n = self.order
        return np.where(self.rooted[:, None], np.clip((low + (high - low) * u) ** n, low**n, high**n), plain)

    def root(self, offset: FloatArray) -> FloatArray:
        """The roots of offsets, the variable of rooted panels."""
        return np.sqrt(offset) if self.order == 2.0 else np.asarray(offset ** (1.0 / self.order))

    def stretch(self, offset: FloatArray) -> FloatArray:
        """Derivatives of the offset with respect to the variable, at offsets of shape (P, k)."""
        span = self.root(self.high) - self.root(self.low)
        root = self.root(offset)
        rate = root if self.order == 2.0 else root ** (self.order - 1.0)
        return np.where(self.rooted[:, None], self.order * span[:, None] * rate, self.width[:, None])

    def variable(self, index: IndexArray, offset: FloatArray) -> FloatArray:
        """The variable u of offsets in given panels."""
        low, high = self.low[index], self.high[index]
        u = (offset - low) / (high - low)
        rooted = self.rooted[index]
        if rooted.any():
            root = self.root(low)
            with np.errstate(invalid="ignore"):
                u = np.where(rooted, (self.root(offset) - root) / (self.root(high) - root), u)
        return u.clip(0.0, 1.0)

    @property
    def begins(self) -> BoolArray:
        """Whether a panel begins at a breakpoint."""
        return np.asarray((self.low == 0.0) & (self.base > 0.0))

    def locate(self, place: Place) -> tuple[IndexArray, FloatArray]:
        """Panel of every place, and its offset from the base of that panel."""
        x = place.x
        index = np.clip(np.searchsorted(self.start, x, side="right") - 1, 0, self.count - 1)
        offset = (place.base - self.base[index]) + place.offset
        while True:
            # panels thinner than the rounding of x begin at the same float
            early = (offset < self.low[index]) & (index > 0)
            if not early.any():
                break
            # a place just before a breakpoint may round to it
            early &= (self.base[index - 1] == self.base[index]) | (self.low[index] == 0.0)
            if not early.any():
                break
            index = np.where(early, index - 1, index)
            offset = (place.base - self.base[index]) + place.offset
        return index, offset


def joined(parts: list[Panels]) -> Panels:
    """Concatenate panels."""
    base, low, high = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("base", "low", "high")
    )
    rooted = np.concatenate([part.rooted for part in parts])
    return Panels(base, low, high, rooted, max(part.order for part in parts))


@dataclass(frozen=True)
class Series:
    """A curve on panels."""

    power: FloatArray
    """Exponent of offset / high that is divided out, shape (P,)."""
    coefficients: FloatArray
    """Chebyshev coefficients, shape (P, TERMS)."""

    def take(self, index: Selection) -> Series:
        """The curve on some of the panels."""
        return Series(self.power[index], self.coefficients[index])


def joined_series(parts: list[Series]) -> Series:
    """Concatenate curves on panels."""
    return Series(
        np.concatenate([part.power for part in parts]),
        np.concatenate([part.coefficients for part in parts]),
    )


def evaluate(panels: Panels, series: Series, index: IndexArray, offset: FloatArray) -> FloatArray:
    """
    Values of a curve at offsets in given panels.

    Parameters
    ----------
    series : Series
        The curve on these panels.
    index : ndarray of int
        Panel of every point, or of every row of points.
    offset : ndarray
        Offsets from the bases of these panels in m, of the shape of `index`, or with one dimension more.

    Returns
    -------
    ndarray
        Of the shape of `offset`.

    Examples
    --------
    >>> one = Panels(np.zeros(1), np.zeros(1), np.ones(1), np.zeros(1, dtype=bool))
    >>> line = Series(np.zeros(1), np.eye(1, TERMS, 1))
    >>> float(evaluate(one, line, np.zeros(1, dtype=np.intp), np.full(1, 0.75))[0])
    0.5
    """
    panel = np.ravel(index)
    at = np.reshape(offset, (panel.size, -1)) if panel.size else np.empty((0, 1))
    values = np.empty(at.shape)
    rows = max(_BLOCK // at.shape[1], 1)
    for start in range(0, panel.size, rows):
        part = slice(start, start + rows)
        i, delta = panel[part], at[part]
        values[part] = clenshaw(series.coefficients[i], panels.variable(i[:, None], delta))
        power = series.power[i]
        if power.any():
            special = np.flatnonzero(power)
            with np.errstate(divide="ignore", under="ignore"):
                scale = (delta[special] / panels.high[i[special], None]) ** power[special, None]
            # a sum that is only rounding of its terms is 0, also times an infinite power
            rounded = np.abs(values[part][special]) <= _ROUNDING * np.sum(
                np.abs(series.coefficients[i[special]]), axis=1, keepdims=True
            )
            scale[np.isinf(scale) & rounded] = 0.0
            values[part][special] *= scale
    return values.reshape(np.shape(offset))


def evaluate_slope(panels: Panels, series: Series, index: IndexArray, offset: FloatArray) -> FloatArray:
    """
    Derivatives of a curve without powers by its variable in 1/m, at offsets in given panels.

    Parameters
    ----------
    series : Series
        The curve on these panels; its powers are all 0.
    index : ndarray of int, shape (n,)
        Panel of every point.
    offset : ndarray, shape (n,)
        Offsets from the bases of these panels in m.

    Returns
    -------
    ndarray, shape (n,)
        Infinite at breakpoints that begin a rooted panel.

    Examples
    --------
    >>> one = Panels(np.zeros(1), np.zeros(1), np.full(1, 4.0), np.ones(1, dtype=bool))
    >>> root = Series(np.zeros(1), np.eye(1, TERMS, 1))
    >>> float(evaluate_slope(one, root, np.zeros(1, dtype=np.intp), np.full(1, 0.25))[0])
    1.0
    """
    rate = np.sum(series.coefficients[index] * basis_slope(panels.variable(index, offset)), axis=1)
    # a root is infinitely steep at its start
    with np.errstate(divide="ignore"):
        return np.asarray(rate / panels.take(index).stretch(offset[:, None])[:, 0])


def clenshaw(coefficients: FloatArray, u: FloatArray) -> FloatArray:
    """Sums of c_j T_j(2 u - 1), with one row of coefficients per u, or per row of u."""
    columns = coefficients.T.reshape(coefficients.shape[1], -1, *(1,) * (u.ndim - 1))
    twice = 4.0 * u - 2.0
    last, before, new = np.zeros_like(u), np.zeros_like(u), np.empty_like(u)
    for column in columns[:0:-1]:
        np.multiply(twice, last, out=new)
        new += column
        new -= before
        last, before, new = new, last, before
    return np.asarray(columns[0] + 0.5 * twice * last - before)
