"""Graded tables as values, read by NumPy."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.numerics.graded import layout
from pymdr.numerics.graded.building import build
from pymdr.numerics.graded.panels import Description, Rising, polynomial, segments_of
from pymdr.units import FloatArray

_STEPS = 200
_SETTLED = 4e-16
_BEYOND = 1.0 + 1e-14


@dataclass(frozen=True, eq=False)
class GradedTable:
    """A positive rising function on 0 < x <= max_argument, made by :func:`graded_table`."""

    rows: FloatArray
    """All numbers, by the columns of :mod:`pymdr.numerics.graded.layout`."""
    error: float
    """Largest relative error of the function between the nodes."""

    @property
    def max_argument(self) -> float:
        """The largest argument."""
        return float(self.rows[0, layout.MAX])

    def __call__(self, x: ArrayLike) -> FloatArray:
        """
        Evaluate f, its integral and its second integral.

        Parameters
        ----------
        x : array_like
            Arguments; the integrals are 0 at 0 and below, and f is set to 0 there.

        Returns
        -------
        ndarray, shape (3, ...)
            f, factor int_0^x f and the integral of that; NaN above the largest argument.
        """
        points = np.asarray(x, dtype=float)
        answers = np.zeros((3, points.size))
        flat = points.ravel()
        answers[:, ~(flat <= self.max_argument * _BEYOND)] = math.nan
        inside = np.flatnonzero((flat > 0.0) & (flat <= self.max_argument * _BEYOND))
        answers[:, inside] = self._read(np.minimum(flat[inside], self.max_argument))
        return answers.reshape(3, *points.shape)

    def inverse(self, integral: ArrayLike) -> FloatArray:
        """
        Arguments x from values of factor int_0^x f.

        Returns
        -------
        ndarray
            NaN below 0 and above the integral up to the largest argument.
        """
        values = np.asarray(integral, dtype=float)
        flat = values.ravel()
        header = self.rows[0]
        answers = np.where(flat == 0.0, 0.0, math.nan)
        full = header[layout.FULL_INTEGRAL]
        answers[(flat >= full) & (flat <= full * _BEYOND)] = self.max_argument
        active = np.flatnonzero((flat > 0.0) & (flat < full))
        target = flat[active]
        low, high = np.zeros(active.size), np.full(active.size, self.max_argument)
        x = self._near(target)
        for _ in range(_STEPS):
            value, here, _second = self._read(x)
            low, high = np.where(here < target, x, low), np.where(here >= target, x, high)
            newton = x - (here - target) / (header[layout.FACTOR] * value)
            middle = low + 0.5 * (high - low)
            following = np.where((newton > low) & (newton < high), newton, middle)
            near = np.abs(here - target) <= _SETTLED * target
            settled = near | (middle == low) | (middle == high)
            answers[active[settled]] = np.where(near, newton, following)[settled]
            active, target, low, high, x = (
                values[~settled] for values in (active, target, low, high, following)
            )
            if not active.size:
                break
        return answers.reshape(values.shape)

    def _near(self, integral: FloatArray) -> FloatArray:
        """Arguments near those of integrals."""
        header, law = self.rows[0], self.rows[int(self.rows[layout.SEGMENT, layout.FIRST]) - 1]
        inner = header[layout.INNER_INTEGRAL]
        begin = int(header[layout.NEAR])
        near = self.rows[begin:, : layout.PER_ROW].ravel()
        key = layout.key_of(np.maximum(integral, inner))
        entry = key - layout.key_of(np.array([inner]))
        fraction = (np.maximum(integral, inner) - layout.value_of(key)) / (
            layout.value_of(key + 1) - layout.value_of(key)
        )
        x = near[entry] + fraction * (near[entry + 1] - near[entry])
        exponent = 1.0 if law[layout.B] > 0.0 else 1.0 / (1.0 + law[layout.Q])
        below = (integral / inner) ** exponent / law[layout.PER_WIDTH]
        return np.asarray(np.minimum(np.where(integral < inner, below, x), self.max_argument))

    def _read(self, x: FloatArray) -> FloatArray:
        row, offset, t = self._located(x)
        answers = np.empty((3, x.size))
        smooth = self.rows[row, layout.KIND] == layout.POLYNOMIAL
        terms, t = self.rows[row[smooth]], t[smooth, None]
        for i, (begin, end) in enumerate(((1, 9), (9, 18), (18, 28))):
            answers[i, smooth] = polynomial(terms[:, begin:end], t)[:, 0]
        b, c, q, per_width, integral, integral_b, integral_c, second, second_b, second_c = self.rows[
            row[~smooth], layout.B : layout.SECOND_C + 1
        ].T
        offset = offset[~smooth]
        power = np.where(c > 0.0, (offset * per_width) ** q, 0.0)
        answers[0, ~smooth] = b + c * power
        answers[1, ~smooth] = integral + offset * (integral_b + integral_c * power)
        answers[2, ~smooth] = second + offset * (integral + offset * (second_b + second_c * power))
        return answers

    def _located(self, x: FloatArray) -> tuple[layout.IntArray, FloatArray, FloatArray]:
        """Rows of the panels, offsets from their marks, and t in the panels."""
        origins = self.rows[layout.SEGMENT : layout.SEGMENT + int(self.rows[0, layout.COUNT]), layout.ORIGIN]
        segment = self.rows[layout.SEGMENT - 1 + np.searchsorted(origins, x, side="right")]
        offset = x - segment[:, layout.ORIGIN]
        key = layout.key_of(offset)
        t = (offset - layout.value_of(key)) / (layout.value_of(key + 1) - layout.value_of(key))
        panel = key - segment[:, layout.LOWEST].astype(np.int64)
        t = np.where(panel < 0, offset * segment[:, layout.PER_INNERMOST], t)
        row = segment[:, layout.FIRST].astype(np.int64) + np.maximum(panel, -1)
        while (divided := np.flatnonzero(self.rows[row, layout.KIND] == layout.DIVIDED)).size:
            t[divided] *= self.rows[row[divided], layout.PARTS]
            part = t[divided].astype(np.int64)
            t[divided] -= part
            row[divided] = self.rows[row[divided], layout.CHILD].astype(np.int64) + part
        return row, offset, t


def graded_table(
    function: Rising,
    largest: float,
    *,
    marks: ArrayLike = (),
    tolerance: float = 1e-13,
    factor: float = 1.0,
    describe: Description | None = None,
) -> GradedTable:
    """
    Tabulate a positive rising function on 0 < x <= largest, with errors relative to its value.

    Toward 0 and toward each mark from above the panels shrink in proportion to the distance, down to 1e-51 of `largest` or until
    the function is b + c (x - mark)^q to rounding. Panels are divided until the polynomial meets the tolerance between the nodes,
    or until division gains nothing because the function has noise.

    Parameters
    ----------
    function : callable
        f > 0 of an array of arguments, with a small relative error; not falling. f(0+) may be positive.
    largest : float
        Positive and finite.
    marks : array_like, optional
        Arguments at which f is not smooth, in any order: above one f may behave like b + c (x - mark)^q, or step up. A kink that is
        not a mark needs more panels; an unbounded slope that is not at a mark is not resolved.
    tolerance : float, optional
        Largest relative error of f.
    factor : float, optional
        Positive factor of both integrals.
    describe : callable, optional
        Of x and f(x), the begin of the message for values that are refused.

    Raises
    ------
    ProblemError
        If f is not finite, not positive, or falls.
    ConvergenceError
        If more than 200 000 panels are needed.

    Examples
    --------
    >>> table = graded_table(lambda x: np.sqrt(x) + x, 1.0)
    >>> f, integral, second = table([1e-30, 0.25, 1.0])
    >>> [f"{value:.10g}" for value in f], f"{integral[2]:.10g}", table.error < 1e-13
    (['1e-15', '0.75', '2'], '1.166666667', True)
    >>> bool(abs(table.inverse(integral)[1] / 0.25 - 1.0) < 1e-15)
    True
    """
    places = np.asarray(marks, dtype=float).ravel()
    segments = segments_of(function, places, float(largest), describe or _described)
    return GradedTable(*build(segments, float(factor), tolerance))


def _described(x: float, value: float) -> str:
    """Text of a value of the function, for messages."""
    return f"f({x!r}) = {value!r}"
