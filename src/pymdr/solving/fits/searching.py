"""The search of a fit: least squares from the best starts, and what the record determines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from pymdr.errors import ConvergenceError, ProblemError, PymdrError
from pymdr.numerics.panels import IndexArray
from pymdr.problem.contact import Contact
from pymdr.solving.curves import MeasuredCurve
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
from pymdr.units import FloatArray, written

_STEP, _FORWARD = 1e-4, 1e-6
_TOLERANCE, _TRIALS = 1e-8, 400
_LAGS = 32
"""Whose correlations are summed one by one; longer ones come from the spectrum."""
_SIGNIFICANT, _FLAT = 5.0, 1e-4
_BLIND = 1e-6
"""Of the largest: singular values of unknowns that a record cannot tell apart."""
_LOST = math.log(1e3)
_ALONE = 0.05
"""Of the unknown that moves most: what the others take part in."""
_BEYOND = 1e6
"""Times the start: a size that nothing holds back."""
_POOR = 10.0
"""A residual in parts of the noise, where the model cannot be computed."""


class Modelled(NamedTuple):
    """The model at the samples of one curve."""

    depth: FloatArray
    """Indentation from the contact point, or the shift from its origin."""
    force: FloatArray
    """As it was measured, without offset."""
    model: FloatArray
    touches: BoolArray


@dataclass(frozen=True)
class Search:
    """What is looked for, in which records."""

    contact: Contact
    unknowns: tuple[Unknown, ...]
    curves: tuple[MeasuredCurve, ...] | tuple[ShearRecord, ...]
    known: dict[str, float]
    """The origins that are not looked for."""
    used: tuple[BoolArray, ...] = field(default=())

    @property
    def shears(self) -> bool:
        """Whether the records are of tangential forces."""
        return isinstance(self.curves[0], ShearRecord)

    @property
    def place(self) -> str:
        """What the origin of the positions is called."""
        return SHIFT_ORIGIN if self.shears else CONTACT_POINT

    @property
    def _origins(self) -> tuple[str, ...]:
        return (self.place, BASELINE) if self.shears else (self.place, BASELINE, TILT)

    @property
    def _free_origins(self) -> list[str]:
        return [name for name in self._origins if name not in self.known]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of all free numbers: unknowns, then the origins of every curve."""
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
        found = [
            {name: self.known[name] if name in self.known else float(next(shifts)) for name in self._origins}
            for _ in self.curves
        ]
        return values, found

    def models(self, free: FloatArray) -> list[Modelled]:
        """The model at all samples of all curves."""
        values, origins = self.from_free(free)
        contact = put_into(self.contact, self.unknowns, values)
        found = []
        for i, origin in enumerate(origins):
            found.append(
                _modelled(
                    contact, self.curves[i], origin[self.place], origin[BASELINE], origin.get(TILT, 0.0)
                )
            )
        return found

    def residuals(self, free: FloatArray) -> FloatArray:
        """Differences in N of all samples that are used; far too large ones where nothing can be computed."""
        try:
            models = self.models(free)
        except PymdrError:
            sizes = (
                sum(int(used.sum()) for used in self.used)
                if self.used
                else sum(c.force.size for c in self.curves)
            )
            return np.full(sizes, _POOR * max(float(np.ptp(c.force)) for c in self.curves))
        residuals = [m.force - m.model for m in models]
        if self.used:
            residuals = [r[used] for r, used in zip(residuals, self.used, strict=True)]
        return np.concatenate(residuals)

    def slopes(self, free: FloatArray) -> FloatArray:
        """Rates of the residuals, one column per free number."""
        columns = []
        for i in range(free.size):
            step = np.zeros(free.size)
            step[i] = _STEP * (1.0 if i < len(self.unknowns) else 1e-2)
            columns.append((self.residuals(free + step) - self.residuals(free - step)) / (2.0 * step[i]))
        return np.column_stack(columns)

    def named(self, free: FloatArray) -> dict[str, float]:
        """Unknowns and origins by name, in SI units."""
        values, places = self.from_free(free)
        named = {u.name: float(v) for u, v in zip(self.unknowns, values, strict=True)}
        for i, place in enumerate(places):
            for name, value in place.items():
                named[f"{name}[{i}]" if len(places) > 1 else name] = value
        return named

    def bounds(self) -> list[tuple[float, float]]:
        """Of the free numbers."""
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
    contact: Contact, curve: MeasuredCurve | ShearRecord, origin: float, baseline: float, tilt: float
) -> Modelled:
    middle = 0.5 * float(curve.position.min() + curve.position.max())
    force, position = curve.force - baseline - tilt * (curve.position - middle), curve.position - origin
    if isinstance(curve, ShearRecord):
        return Modelled(position, force, curve.forces(contact, origin), np.ones(force.size, dtype=bool))
    deepest = max(float(np.ptp(curve.depth)), float(position.max() - curve.compliance * force.max()))
    forces = forces_of(contact, deepest, curve.compliance, curve.time)
    model, touches = modelled(forces, position, force)
    return Modelled(position - curve.compliance * model, force, model, touches)


class Minimum(NamedTuple):
    """Where a search over free numbers ends."""

    free: FloatArray
    misfit: float
    """In N^2."""
    settled: bool
    trials: int
    message: str


def found_from(search: Search, start: FloatArray, fixed: int | None = None) -> Minimum:
    """Least squares by Levenberg and Marquardt from one start, within bounds by trust regions; one free number may be fixed."""
    from scipy.optimize import least_squares

    low, high = np.array(search.bounds()).T
    room = np.where(np.isfinite(high - low), 1e-9 * (high - low), 1e-9)
    free = np.clip(start, low + room, high - room)
    moving = np.flatnonzero(np.arange(free.size) != fixed)
    unit = max(float(np.ptp(curve.force)) for curve in search.curves)

    def residuals(x: FloatArray) -> FloatArray:
        free[moving] = x
        return search.residuals(free) / unit

    def slopes(x: FloatArray) -> FloatArray:
        here = residuals(x)
        steps = np.where(x + _FORWARD > high[moving], -_FORWARD, _FORWARD)
        return np.column_stack(
            [(residuals(x + one) - here) / step for one, step in zip(np.diag(steps), steps, strict=True)]
        )

    if fixed is not None:
        free[fixed] = start[fixed]
    if not moving.size:
        return Minimum(free, float((search.residuals(free) ** 2).sum()), True, 1, "")
    bounded = bool(np.isfinite([*low[moving], *high[moving]]).any())
    found = least_squares(
        residuals,
        free[moving],
        slopes,
        bounds=(low[moving], high[moving]),
        method="trf" if bounded else "lm",
        x_scale="jac",
        ftol=_TOLERANCE,
        xtol=_TOLERANCE,
        gtol=1e-15,
        max_nfev=_TRIALS,
    )
    free[moving] = found.x
    return Minimum(
        free, 2.0 * float(found.cost) * unit**2, bool(found.success), int(found.nfev), found.message
    )


def profile_end(search: Search, best: FloatArray, i: int, step: float, grows: float) -> float:
    """Where a free number, moved from its best in steps of a direction, leaves a sum of squares larger by a part."""
    from scipy.optimize import brentq

    least, others = float((search.residuals(best) ** 2).sum()), best.copy()

    def beyond(x: float) -> float:
        start = others.copy()
        start[i] = x
        end = found_from(search, start, fixed=i)
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


def refuse_blind(search: Search, free: FloatArray) -> None:
    """
    Refuse unknowns that the records cannot tell apart.

    Raises
    ------
    ProblemError
        With what they do determine.
    """
    own, sizes = _own_slopes(search, search.slopes(free))
    left = np.linalg.norm(own, axis=0)
    unfelt = left <= _BLIND * np.maximum(sizes, sizes.max())
    if unfelt.any():
        raise ProblemError(_unfelt(search, free, unfelt))
    _, singular, rows = np.linalg.svd(own / np.linalg.norm(own, axis=0), full_matrices=False)
    if singular[-1] > _BLIND * singular[0]:
        return
    direction = rows[-1] / np.linalg.norm(own, axis=0)
    raise ProblemError(_combination(search, free, direction / np.abs(direction).max()))


def refuse_lost(search: Search, free: FloatArray, slopes: FloatArray, noise: float) -> None:
    """
    Refuse sizes that the noise of records, in N, moves by more than a factor of a thousand.

    Raises
    ------
    ProblemError
        With what the records do determine.
    """
    if not all(u.is_size for u in search.unknowns) or not search.unknowns:
        return
    own, _ = _own_slopes(search, slopes)
    _, singular, rows = np.linalg.svd(own, full_matrices=False)
    if noise <= _LOST * singular[-1]:
        return
    weakest = rows[-1] / np.abs(rows[-1]).max()
    if np.count_nonzero(np.abs(weakest) > _ALONE) > 1:
        raise ProblemError(_combination(search, free, np.where(np.abs(weakest) > _ALONE, weakest, 0.0)))
    lost = np.abs(weakest) == 1.0
    raise ProblemError(_unfelt(search, free, lost))


def _own_slopes(search: Search, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rates of the residuals over the unknowns, without what the origins of the records take up, and how large they were with that."""
    n = len(search.unknowns)
    own, origin = slopes[:, :n], slopes[:, n:]
    sizes = np.linalg.norm(own, axis=0)
    if origin.shape[1]:
        own = own - origin @ np.linalg.lstsq(origin, own, rcond=None)[0]
    return own, sizes


def _unfelt(search: Search, free: FloatArray, unfelt: BoolArray) -> str:
    """What is determined where unknowns leave no trace."""
    values, _ = search.from_free(free)
    told = [_near(u, float(v)) for u, v in zip(search.unknowns, values, strict=True)]
    silent = [one for one, is_silent in zip(told, unfelt, strict=True) if is_silent]
    heard = [one for one, is_silent in zip(told, unfelt, strict=True) if not is_silent]
    rest = f"; it determines {', '.join(heard)}" if heard else ""
    names = " and ".join(u.name for u, is_silent in zip(search.unknowns, unfelt, strict=True) if is_silent)
    return (
        f"fit: the record does not feel {names}, which is fitted best with {', '.join(silent)}{rest}; leave {names} out of free, or take a contact "
        "without it"
    )


def _near(unknown: Unknown, value: float) -> str:
    """A value in words where a search took it beyond all measure."""
    if unknown.is_size and value < unknown.start / _BEYOND:
        return f"{unknown.name} near 0"
    if unknown.is_size and value > unknown.start * _BEYOND:
        return f"{unknown.name} without end"
    return f"{unknown.name} = {written(value, unknown.unit, 4)}"


def _combination(search: Search, free: FloatArray, direction: FloatArray) -> str:
    """What is determined where unknowns may change along a direction without a trace."""
    values, _ = search.from_free(free)
    moving = [i for i in range(direction.size) if abs(direction[i]) > 1e-3]
    names = [search.unknowns[i].name for i in moving]
    told = f"fit: the record cannot tell {' and '.join(names)} apart"
    record = search.curves[0]
    if isinstance(record, ShearRecord):
        stiffness, load = record.stuck(put_into(search.contact, search.unknowns, values))
        told += (
            f": of the bodies it determines the tangential stiffness where they stick, {stiffness:.4g} N/m under "
            f"{written(load, 'N', 4)}"
        )
    elif all(search.unknowns[i].is_size for i in moving):
        last = max(moving, key=lambda i: abs(direction[i]))
        products = []
        for i in moving:
            if i != last:
                power = round(-direction[i] / direction[last], 3)
                value = float(values[i] * values[last] ** power)
                u, v = search.unknowns[i], search.unknowns[last]
                products.append(f"{u.name} x {v.name}^{power:g} = {value:.4g} (in {u.unit} and {v.unit})")
        told += f": it determines {', and '.join(products)}"
    return f"{told}; fix one of them"


class Hanging(NamedTuple):
    """How the residuals of records hang together."""

    correlated: FloatArray
    """1 + 2 sum_k rho_k, up to the first lag whose correlation is within the noise; at least 1: how many samples tell as much as
    one independent one."""
    waves: FloatArray
    """What of them hangs together, in parts of what differs between neighbours."""


def hanging(residuals: FloatArray, span: FloatArray) -> Hanging:
    """
    How residuals hang together.

    Parameters
    ----------
    residuals : ndarray, shape (records, samples)
        In the order in which they were measured; shorter records are filled up with nan at their ends.
    span : ndarray, shape (records,)
        Of the forces of each record: waves of less than 1e-4 of it are none.

    Returns
    -------
    Hanging
        The waves are sqrt(2/eta - 1) with von Neumann's ratio eta of the mean squares of differences between neighbours and of the
        residuals themselves, which is 2 for white noise; 0 where it lies within five standard deviations, 2/sqrt(n), of that.

    Examples
    --------
    >>> noise, wave = np.random.default_rng(1).normal(size=1000), 3.0 * np.sin(np.linspace(0.0, 20.0, 1000))
    >>> found = hanging(np.array([noise, noise + wave]), np.full(2, 100.0))
    >>> found.waves.round(1).tolist(), found.correlated.round().tolist()
    ([0.0, 2.1], [1.0, 80.0])
    """
    there = np.isfinite(residuals)
    n = there.sum(axis=1)
    values = np.where(there, residuals, 0.0)
    square = (values**2).sum(axis=1)
    differences = np.where(there[:, 1:], np.diff(values, axis=1), 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = (differences**2).sum(axis=1) / (n - 1) / (square / n)
        waves = np.sqrt(np.maximum(2.0 / ratio - 1.0, 0.0))
        plain = (ratio > 2.0 - _SIGNIFICANT * 2.0 / np.sqrt(n)) | (np.sqrt(square / n) < _FLAT * span)
        centred = np.where(there, values - (values.sum(axis=1) / n)[:, None], 0.0)
    times = _correlation_times(centred, n)
    long = np.flatnonzero(np.isnan(times))
    if long.size:
        times[long] = _long_correlations(centred[long], n[long])
    return Hanging(times, np.where(plain | ~np.isfinite(waves), 0.0, waves))


def _correlation_times(centred: FloatArray, n: IndexArray) -> FloatArray:
    """1 + 2 sum rho_k of each row, up to the first lag within the noise; nan where that is none of the first."""
    times, total, rows = np.full(n.size, math.nan), np.ones(n.size), np.arange(n.size)
    power = (centred**2).sum(axis=1)
    for lag in range(1, _LAGS + 1):
        products = np.einsum("ij,ij->i", centred[:, lag:], centred[:, :-lag])
        with np.errstate(invalid="ignore", divide="ignore"):
            rho = np.where(power > 0.0, products / power, 0.0)
            ended = (rho < 2.5 / np.sqrt(n)) | (lag >= n // 2) | (n < 2)
        times[rows[ended]] = total[ended]
        going = ~ended
        if not going.any():
            break
        if ended.any():
            centred, n, power, rows = centred[going], n[going], power[going], rows[going]
        total = total[going] + 2.0 * rho[going]
    return times


def _long_correlations(centred: FloatArray, n: IndexArray) -> FloatArray:
    """The same by the spectrum."""
    width = centred.shape[1]
    lags = width // 2 + 1
    size = next_fast_len(width + lags, real=True)
    spectrum = np.abs(rfft(centred, size)) ** 2
    rho = irfft(spectrum, size)[:, :lags] / (centred**2).sum(axis=1)[:, None]
    noise = (rho < (2.5 / np.sqrt(n))[:, None]) | (np.arange(rho.shape[1]) >= (n // 2)[:, None])
    noise[:, 0], noise[:, -1] = False, True
    sums = np.cumsum(rho, axis=1)[np.arange(n.size), np.argmax(noise, axis=1) - 1] - rho[:, 0]
    return np.asarray(np.maximum(1.0, 1.0 + 2.0 * sums))


def beside_jumps(models: Sequence[Modelled], search: Search) -> tuple[BoolArray, ...]:
    """Which samples are used: not those on either side of a jump into contact or out of it."""
    used = []
    for one in models:
        keep = np.ones(one.touches.size, dtype=bool)
        if search.contact.adhesion is not None and not search.shears:
            at = np.flatnonzero(np.diff(one.touches.astype(int)))
            for shift in (0, 1):
                keep[np.clip(at + shift, 0, keep.size - 1)] = False
        used.append(keep)
    return tuple(used)


def refuse_unsettled(found: Minimum) -> None:
    """
    Refuse a search that did not end.

    Raises
    ------
    ConvergenceError
    """
    if not found.settled:
        raise ConvergenceError(
            f"fit: the search did not settle after {found.trials} trials: {found.message} See with curve.orient() whether a sign is turned, or give "
            "bounds in free"
        )
