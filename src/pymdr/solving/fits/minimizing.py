"""Least squares from a start, and profiles of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.solving.fits.edges import off_jumps
from pymdr.solving.fits.searching import Modelled, Search
from pymdr.solving.fits.touching import BoolArray
from pymdr.solving.fits.unknowns import FARTHEST
from pymdr.units import FloatArray

_FORWARD = 1e-6
"""Step of the free numbers of forward differences."""
TOLERANCE, _TRIALS = 1e-8, 400
GAIN = 1e-6
"""Gain of the sum of squares, in variances of the noise, with which the last search ends: a thousandth of a standard error."""
_PATIENCE = 80
"""Trials after which a search that reduces the sum of squares by less than one variance of the noise is given up: it creeps along a valley."""


class Minimum(NamedTuple):
    """The end of a search over free numbers."""

    free: FloatArray
    misfit: float
    """In N^2."""
    settled: bool
    trials: int
    message: str
    creeps: bool = False
    """Whether the search was given up in a valley, which the records hardly determine."""


class _CreepsError(Exception):
    """A search along a valley of the sum of squares."""


class _Progress:
    """The trials of a search: the best one, and whether they still gain."""

    def __init__(self, residuals: Callable[[FloatArray], FloatArray]) -> None:
        self._residuals = residuals
        self.least: list[float] = []
        """Least sum of squares after each trial."""
        self.best = np.empty(0)

    def __call__(self, x: FloatArray) -> FloatArray:
        left = self._residuals(x)
        misfit = float(left @ left)
        if not self.least or misfit < self.least[-1]:
            self.best = x.copy()
        self.least.append(min(misfit, *self.least[-1:]) if self.least else misfit)
        variance = self.least[-1] / max(left.size - x.size, 1)
        if len(self.least) > _PATIENCE and self.least[-1 - _PATIENCE] - self.least[-1] < variance:
            raise _CreepsError
        return left


def forward_steps(search: Search, free: FloatArray, high: FloatArray) -> FloatArray:
    """Short steps of forward differences, backward at upper bounds."""
    steps = search.steps(_FORWARD, _FORWARD)
    return np.where(free + steps > high, -steps, steps)


def minimize_from(
    search: Search, start: FloatArray, fixed: int | None = None, tolerance: float = TOLERANCE
) -> Minimum:
    """Least squares by Levenberg and Marquardt from one start, within bounds by trust regions; one free number may be fixed."""
    from scipy.optimize import least_squares

    low, high = np.array(search.bounds()).T
    margin = np.where(np.isfinite(high - low), 1e-9 * (high - low), 1e-9)
    free = np.clip(start, low + margin, high - margin)
    moving = np.flatnonzero(np.arange(free.size) != fixed)
    unit = max(float(np.ptp(curve.force)) for curve in search.curves)

    def residuals(x: FloatArray) -> FloatArray:
        free[moving] = x
        return search.residuals(free) / unit

    def slopes(x: FloatArray) -> FloatArray:
        free[moving] = x
        return search.slopes(free, forward_steps(search, free, high), moving, central=False) / unit

    if fixed is not None:
        free[fixed] = start[fixed]
    if not moving.size:
        return Minimum(free, float((search.residuals(free) ** 2).sum()), True, 1, "")
    bounded = bool(np.isfinite([*low[moving], *high[moving]]).any())
    progress = _Progress(residuals)
    try:
        solution = least_squares(
            progress,
            free[moving],
            slopes,
            bounds=(low[moving], high[moving]),
            method="trf" if bounded else "lm",
            x_scale="jac",
            ftol=tolerance,
            xtol=TOLERANCE,
            gtol=1e-15,
            max_nfev=_TRIALS,
        )
    except _CreepsError:
        free[moving] = progress.best
        names = " and ".join(u.name for u in search.unknowns)
        text = f"its last {_PATIENCE} trials reduced the sum of squares by less than one variance of the noise, so the record hardly determines {names}; fix {'one of them' if len(search.unknowns) > 1 else 'it'}"
        return Minimum(free, progress.least[-1] * unit**2, False, len(progress.least), text, True)
    free[moving] = solution.x
    return Minimum(
        free,
        2.0 * float(solution.cost) * unit**2,
        bool(solution.success),
        int(solution.nfev),
        solution.message,
    )


def profile_end(search: Search, best: FloatArray, i: int, step: float, grows: float) -> float:
    """The value of a free number, on one side of its best, at which the sum of squares has grown by a fraction."""
    from scipy.optimize import brentq

    least, others = float((search.residuals(best) ** 2).sum()), best.copy()

    def beyond(x: float) -> float:
        start = others.copy()
        start[i] = x
        end = minimize_from(search, start, fixed=i)
        others[:] = end.free
        return end.misfit / least - 1.0 - grows

    low, high = search.bounds()[i]
    inner, outer = float(best[i]), float(best[i])
    while low < outer < high and abs(outer) < FARTHEST:
        inner, outer = outer, min(max(best[i] + step, low), high)
        if beyond(outer) > 0.0:
            return float(brentq(beyond, inner, outer, xtol=1e-6 * abs(step)))
        step *= 2.0
    return outer


def samples_off_jumps(
    models: Sequence[Modelled], search: Search, widths: Sequence[int] = ()
) -> tuple[BoolArray, ...]:
    """
    Used samples: all but those adjacent to a jump into contact or out of it.

    Close to a jump the rates of the force are unbounded; the widths are the numbers of samples of each curve to either side, 1 by default.
    """
    if search.contact.has_edge_history:
        return tuple(
            off_jumps(curve, one.force, one.touches)
            for curve, one in zip(search.measured, models, strict=True)
        )
    used = []
    for one, width in zip(models, widths or [1] * len(models), strict=True):
        keep = np.ones(one.touches.size, dtype=bool)
        if search.contact.adhesion is not None and not search.shears:
            for at in np.flatnonzero(np.diff(one.touches.astype(int))).tolist():
                keep[max(at + 1 - width, 0) : at + 1 + width] = False
        used.append(keep)
    return tuple(used)


def refuse_unsettled(minimum: Minimum) -> None:
    """Refuse a search that did not converge."""
    if minimum.creeps:
        raise ConvergenceError(f"the search did not converge: {minimum.message}, or give bounds in free")
    if not minimum.settled:
        raise ConvergenceError(
            f"the search did not converge in {minimum.trials} trials ({minimum.message.rstrip('.')}); check the columns "
            "and units of the record and its signs, or give bounds in free"
        )
