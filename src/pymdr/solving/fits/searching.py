"""The search of a fit: least squares from a start."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pymdr.errors import ConvergenceError, PymdrError
from pymdr.interpretation.theories import theory_of
from pymdr.problem.contact import Contact
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.edges import off_jumps
from pymdr.solving.fits.forces import forces_of, modelled
from pymdr.solving.fits.loops import ShearRecord
from pymdr.solving.fits.touching import BoolArray
from pymdr.solving.fits.unknowns import (
    BASELINE,
    CONTACT_POINT,
    FARTHEST,
    SHIFT_ORIGIN,
    TILT,
    Unknown,
    put_into,
)
from pymdr.units import FloatArray

_STEP, _FORWARD = 1e-4, 1e-6
_LONG_STEP = 1e-3
"""Step of rates of an edge with memory: its steps in time change with the unknowns, by which the force scatters by about 1e-6."""
TOLERANCE, _TRIALS = 1e-8, 400
_PATIENCE = 80
"""Trials after which a search that reduces the sum of squares by less than one variance of the noise is given up: it creeps along a valley."""
_POOR = 10.0
"""Residual relative to the range of the force where the model cannot be solved."""


class Modelled(NamedTuple):
    """The model at the samples of one curve."""

    depth: FloatArray
    """Indentation from the contact point, or the shift from its origin."""
    force: FloatArray
    """As measured, without offset."""
    model: FloatArray
    touches: BoolArray


@dataclass(frozen=True)
class Search:
    """Unknowns of a contact, and the records of the fit."""

    contact: Contact
    unknowns: tuple[Unknown, ...]
    curves: tuple[MeasuredCurve, ...] | tuple[ShearRecord, ...]
    known: dict[str, float]
    """The known origins."""
    used: tuple[BoolArray, ...] = field(default=())
    touches: tuple[BoolArray, ...] = field(default=())
    """Samples in contact of every curve, if they are prescribed."""

    @property
    def shears(self) -> bool:
        """Whether the records are of tangential forces."""
        return not self.measured

    @property
    def measured(self) -> tuple[MeasuredCurve, ...]:
        """The records of normal forces."""
        return tuple(one for one in self.curves if isinstance(one, MeasuredCurve))

    @property
    def place(self) -> str:
        """Name of the origin of the positions."""
        return SHIFT_ORIGIN if self.shears else CONTACT_POINT

    @property
    def _origins(self) -> tuple[str, ...]:
        return (self.place, BASELINE) if self.shears else (self.place, BASELINE, TILT)

    @property
    def _free_origins(self) -> list[str]:
        return [name for name in self._origins if name not in self.known]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of all free numbers: unknowns, then the origins of every curve."""
        several = len(self.curves) > 1
        return (
            *(u.name for u in self.unknowns),
            *(
                f"{name}[{i}]" if several else name
                for i in range(len(self.curves))
                for name in self._free_origins
            ),
        )

    @cached_property
    def origin_scales(self) -> FloatArray:
        """Sizes of the free origins, in the order of their names."""
        sizes = [
            {
                self.place: float(np.ptp(curve.depth)),
                BASELINE: float(np.ptp(curve.force)),
                TILT: float(np.ptp(curve.force) / np.ptp(curve.position)),
            }
            for curve in self.curves
        ]
        return np.array([size[name] for size in sizes for name in self._free_origins])

    def to_free(self, values: Sequence[float], origins: Sequence[dict[str, float]]) -> FloatArray:
        """The numbers that the search changes."""
        own = [u.to_free(v) for u, v in zip(self.unknowns, values, strict=True)]
        shifts = [one[name] for one in origins for name in self._free_origins]
        return np.array([*own, *(np.array(shifts) / self.origin_scales)])

    def from_free(self, free: FloatArray) -> tuple[FloatArray, list[dict[str, float]]]:
        """Values of the unknowns, and the origins of every curve."""
        n = len(self.unknowns)
        values = np.array([u.from_free(x) for u, x in zip(self.unknowns, free[:n], strict=True)])
        shifts = iter(free[n:] * self.origin_scales)
        origins = [
            {name: self.known[name] if name in self.known else float(next(shifts)) for name in self._origins}
            for _ in self.curves
        ]
        return values, origins

    def models(self, free: FloatArray) -> list[Modelled]:
        """The model at all samples of all curves."""
        values, origins = self.from_free(free)
        contact = put_into(self.contact, self.unknowns, values)
        return [
            _modelled(contact, self.curves[i], one, self.touches[i] if self.touches else None)
            for i, one in enumerate(origins)
        ]

    def residuals(self, free: FloatArray) -> FloatArray:
        """Residuals in N of all used samples; large ones if the model cannot be solved."""
        try:
            models = self.models(free)
        except PymdrError:
            size = sum(one.force.size for one in self.curves)
            size = sum(int(one.sum()) for one in self.used) if self.used else size
            return np.full(size, _POOR * max(float(np.ptp(one.force)) for one in self.curves))
        residuals = [one.force - one.model for one in models]
        if self.used:
            residuals = [one[part] for one, part in zip(residuals, self.used, strict=True)]
        return residuals[0] if len(residuals) == 1 else np.concatenate(residuals)

    def with_touches_at(self, free: FloatArray) -> Search:
        """
        The search with the samples in contact of some free numbers, if the contact has adhesion.

        The force jumps where a sample gets in or out of contact; the rates of the residuals are those between the jumps.
        """
        if self.contact.adhesion is None or self.shears or self.touches:
            return self
        try:
            return replace(self, touches=tuple(one.touches for one in self.models(free)))
        except PymdrError:
            return self

    @cached_property
    def jumps(self) -> bool:
        """Whether the force of the model jumps at the contact point, by a pull that does not deform the bodies."""
        law = self.contact.adhesion
        return law is not None and not self.shears and theory_of(law).pulls_beyond

    def slopes(self, free: FloatArray) -> FloatArray:
        """Rates of the residuals, one column per free number."""
        columns, fixed = [], self.with_touches_at(free)
        for step in np.diag(self.steps(_STEP, 1e-2 * _STEP)):
            change = fixed.residuals(free + step) - fixed.residuals(free - step)
            columns.append(change / (2.0 * step.sum()))
        return np.column_stack(columns)

    def steps(self, unknown: float, origin: float) -> FloatArray:
        """Steps of the free numbers by which rates are computed: those given, or longer ones where the force scatters."""
        if self.contact.has_edge_history and self.contact.is_viscoelastic:
            unknown, origin = _LONG_STEP, 0.1 * _LONG_STEP
        return np.where(np.arange(len(self.names)) < len(self.unknowns), unknown, origin)

    def named(self, free: FloatArray) -> dict[str, float]:
        """Unknowns and origins by name, in SI units."""
        values, places = self.from_free(free)
        named = {u.name: float(v) for u, v in zip(self.unknowns, values, strict=True)}
        for i, place in enumerate(places):
            for name, value in place.items():
                named[f"{name}[{i}]" if len(places) > 1 else name] = value
        return named

    def bounds(self) -> list[tuple[float, float]]:
        """Bounds of the free numbers."""
        inner = []
        for u in self.unknowns:
            low = (
                -math.inf
                if u.is_size and u.low == 0.0
                else u.to_free(u.low)
                if math.isfinite(u.low)
                else -math.inf
            )
            high = u.to_free(u.high) if math.isfinite(u.high) else math.inf
            inner.append((low, high))
        return [*inner, *[(-math.inf, math.inf)] * self.origin_scales.size]


def _modelled(
    contact: Contact,
    curve: MeasuredCurve | ShearRecord,
    origins: Mapping[str, float],
    touches: BoolArray | None,
) -> Modelled:
    origin = origins[SHIFT_ORIGIN if isinstance(curve, ShearRecord) else CONTACT_POINT]
    baseline, tilt = origins[BASELINE], origins.get(TILT, 0.0)
    middle = 0.5 * float(curve.position.min() + curve.position.max())
    force, position = curve.force - baseline - tilt * (curve.position - middle), curve.position - origin
    if isinstance(curve, ShearRecord):
        return Modelled(position, force, curve.forces(contact, origin), np.ones(force.size, dtype=bool))
    deepest = max(float(np.ptp(curve.depth)), float(position.max() - curve.compliance * force.max()))
    forces = forces_of(contact, deepest, curve.compliance, curve.time)
    model, touches = modelled(forces, position, force, touches)
    return Modelled(position - curve.compliance * model, force, model, touches)


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

    def residuals(x: FloatArray, own: Search = search) -> FloatArray:
        free[moving] = x
        return own.residuals(free) / unit

    def slopes(x: FloatArray) -> FloatArray:
        free[moving] = x
        own = search.with_touches_at(free)
        here = residuals(x, own)
        steps = search.steps(_FORWARD, _FORWARD)[moving]
        steps = np.where(x + steps > high[moving], -steps, steps)
        return np.column_stack(
            [(residuals(x + one, own) - here) / step for one, step in zip(np.diag(steps), steps, strict=True)]
        )

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
    """
    Refuse a search that did not converge.

    Raises
    ------
    ConvergenceError
    """
    if minimum.creeps:
        raise ConvergenceError(f"fit: the search creeps: {minimum.message}, or give bounds in free")
    if not minimum.settled:
        raise ConvergenceError(
            f"fit: the search did not converge in {minimum.trials} trials ({minimum.message.rstrip('.')}); check the columns "
            "and units of the record and its signs (curve.orient()), or give bounds in free"
        )
