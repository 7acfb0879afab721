"""Starts of the search of a fit: a grid over nonlinear unknowns, the others by least squares."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ProblemError, PymdrError
from pymdr.line.soft.springs import HASTY, ROUGH, ZoneLevel
from pymdr.problem.contact import Contact
from pymdr.problem.parameters import with_parameters
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.curves.baselines import CHECK_SIGNS
from pymdr.solving.fits.edges import onset
from pymdr.solving.fits.forces import Forces, forces_of
from pymdr.solving.fits.loops import ShearRecord
from pymdr.solving.fits.searching import Search
from pymdr.solving.fits.touching import BoolArray, first_guess_of_contact, scale_and_baseline
from pymdr.solving.fits.unknowns import (
    BASELINE,
    CONTACT_POINT,
    SHIFT_ORIGIN,
    Unknown,
    candidates,
    put_into,
    scales_together,
)
from pymdr.units import FloatArray

_SAMPLES, _POINTS, _COMBINATIONS = 256, 33, 100
_FOLLOWED_POINTS, _FOLLOWED_COMBINATIONS = 9, 24
"""The same for bodies with memory, whose every trial solves the whole record."""
_EDGE_STARTS, _EDGE_COMBINATIONS, _AS_GOOD = 2, 9, 10.0
"""Largest numbers of searches and of combinations for an edge with a history, and the largest ratio of their misfits at the start."""
_OF_WORK = "J/m^2"
_NO_CONTACT = "no start of the adhesive contact resembles the record; check the signs of its columns"
_PULLS, _SAME_PULL, _SCALED_AT_ONCE = 5, 0.02, 30.0
"""Number of scalings of works to a measured pull, their relative change at which they end, and the largest factor of one."""
_WANDERS = 0.05
"""Largest deviation from one approach and one retreat, relative to the range of the depths."""
_SCALES = np.geomspace(0.3, 1e4, 17)
"""Stiffness relative to that of a contact with the largest force at a depth of the whole travel."""
_LADDER = np.linspace(0.0, 1.0, 257) ** 2
_FRICTION = "friction."
_STIFFNESS_RATIOS, _FRICTION_RATIOS = np.geomspace(0.7, 30.0, 7), (1.001, 1.4, 2.2, 6.0)
"""Stiffness and friction of a loop relative to the estimates from its largest force; those of a half loop are twice as large."""
_BEFORE, _PLAIN = (-0.1, 0.0, 0.1), 8
"""Origins of the shift, relative to its range."""


class Start(NamedTuple):
    """A start of a search."""

    misfit: float
    """Sum of squares in N^2."""
    values: FloatArray
    """Values of the unknowns."""
    origin: float
    """Origin of the position in m."""
    baseline: float
    tilt: float = 0.0


def starts(
    contact: Contact,
    unknowns: Sequence[Unknown],
    curve: MeasuredCurve | ShearRecord,
    known: dict[str, float],
    count: int,
) -> list[Start]:
    """
    The best starts of a grid.

    Parameters
    ----------
    contact : Contact
    unknowns : sequence of Unknown
    curve : MeasuredCurve or ShearRecord
    known : dict
        The known origins.
    count : int
        Number of starts.
    """
    if isinstance(curve, ShearRecord):
        return _sheared_starts(contact, unknowns, curve, known, count)
    position, size = curve.position, float(np.ptp(curve.position))
    few = np.unique(np.linspace(0, position.size - 1, min(_SAMPLES, position.size)).astype(int))
    time = None if curve.time is None else curve.time[few]
    points, most = (
        (_FOLLOWED_POINTS, _FOLLOWED_COMBINATIONS) if contact.is_viscoelastic else (_POINTS, _COMBINATIONS)
    )
    if CONTACT_POINT in known:
        tried = np.array([known[CONTACT_POINT]])
    else:
        tried = float(position.max()) - size * np.linspace(1.0, 0.01, points)
    together = scales_together(contact, unknowns)
    span = 0.0 if curve.time is None else float(np.ptp(curve.time))
    best_starts, failures = [], []
    for values in candidates(contact, unknowns, size, span, most):
        best = Start(math.inf, values, float(tried[0]), 0.0)
        try:
            forces = forces_of(put_into(contact, unknowns, values), size, 0.0, time)
        except PymdrError as error:
            failures.append(error)
            continue
        for point in tried:
            try:
                places = _tried(forces, curve, few, float(point), known, values, unknowns, together)
                best = min((best, *places), key=lambda start: start.misfit)
            except PymdrError as error:
                failures.append(error)
        best_starts.append(best)
    best_starts = [start for start in best_starts if math.isfinite(start.misfit)]
    if not best_starts:
        raise ProblemError(
            f"no start can be computed: {failures[-1] if failures else f'the force does not increase with the depth; {CHECK_SIGNS}'}"
        )
    return sorted(best_starts, key=lambda start: start.misfit)[:count]


def edge_starts(search: Search, count: int) -> list[list[Start]]:
    """
    Starts of every record at the onset of its force, for an edge with a history; from the own values of the contact and from a grid.

    Unknown works are scaled to the largest pulls of the records, with which the contact also separates near its place. All records have
    the same values.
    """
    contact, unknowns, known = search.contact, search.unknowns, search.known
    records = [_edge_record(contact, curve, known) for curve in search.measured]
    size = max(float(np.ptp(curve.position)) for curve in search.measured)
    span = max(0.0 if one.time is None else float(np.ptp(one.time)) for one in records)
    together = scales_together(contact, unknowns)
    works = np.array([u.unit == _OF_WORK and not together for u in unknowns])
    others = [u for u, is_work in zip(unknowns, works, strict=True) if not is_work]
    own = np.array([u.start for u in unknowns])
    complete: list[list[Start]] = []
    failures: list[PymdrError] = []

    def models(zone: ZoneLevel, values: FloatArray) -> list[FloatArray]:
        candidate = put_into(contact, unknowns, values)
        return [
            forces_of(candidate, size, one.curve.compliance, one.time, zone).at(one.position)[0]
            for one in records
        ]

    measured = np.array([one.level - one.curve.force.min() for one in records])
    grids = np.array([own[~works], *candidates(contact, others, size, span, _EDGE_COMBINATIONS)])
    for grid in np.unique(grids, axis=0):
        values = own.copy()
        values[~works] = grid
        zone = ROUGH if np.array_equal(values, own) else HASTY
        try:
            values, followed = _with_pulls(values, works, unknowns, measured, partial(models, zone))
        except PymdrError as error:
            failures.append(error)
            continue
        placed = [
            _placed(one.curve.force[one.few], model, None, one.point, one.known, values, unknowns, together)
            for one, model in zip(records, followed, strict=True)
        ]
        if None not in placed:
            complete.append([one for one in placed if one is not None])
    if not complete:
        raise ProblemError(f"no start can be computed: {failures[-1]}" if failures else _NO_CONTACT)
    totals = [sum(start.misfit for start in each) for each in complete]
    ranked = [complete[i] for i in np.argsort(totals, kind="stable") if totals[i] <= _AS_GOOD * min(totals)]
    return [list(each) for each in zip(*ranked[: min(count, _EDGE_STARTS)], strict=True)]


class _EdgeRecord(NamedTuple):
    """A record with few of its samples, and the guess of its origins."""

    curve: MeasuredCurve
    few: NDArray[np.intp]
    time: FloatArray | None
    point: float
    level: float
    known: dict[str, float]

    @property
    def position(self) -> FloatArray:
        """Positions of the few samples in m from the contact point."""
        return self.curve.position[self.few] - self.point


def _edge_record(contact: Contact, curve: MeasuredCurve, known: dict[str, float]) -> _EdgeRecord:
    point, level = onset(contact, curve)
    few = np.unique(np.linspace(0, curve.position.size - 1, min(_SAMPLES, curve.position.size)).astype(int))
    time = None if curve.time is None else curve.time[few]
    own = {BASELINE: level} | known
    return _EdgeRecord(curve, few, time, known.get(CONTACT_POINT, point), own[BASELINE], own)


def _with_pulls(
    values: FloatArray,
    works: BoolArray,
    unknowns: Sequence[Unknown],
    measured: FloatArray,
    models: Callable[[FloatArray], list[FloatArray]],
) -> tuple[FloatArray, list[FloatArray]]:
    """Values with the works scaled until the model has about the measured pulls in N, in the geometric mean, and its forces in N."""
    low, high = np.array([(u.low, u.high) for u in unknowns]).T
    for _ in range(_PULLS):
        followed = models(values)
        pulls = np.array([-model.min() for model in followed])
        ratios = measured / np.maximum(pulls, measured / _SCALED_AT_ONCE)
        ratio = float(np.exp(np.log(np.maximum(ratios, 1.0 / _SCALED_AT_ONCE)).mean()))
        scaled = np.where(works, np.clip(ratio * values, low, high), values)
        if np.allclose(scaled, values, rtol=_SAME_PULL):
            return values, followed
        values = scaled
    return values, models(values)


def is_pressed_once(curve: MeasuredCurve) -> bool:
    """Whether the positions increase and then decrease, without noise."""
    steps, deepest = np.diff(curve.position), int(np.argmax(curve.position))
    return bool((steps[:deepest] >= 0.0).all() and (steps[deepest:] <= 0.0).all())


def pressed_once(curve: MeasuredCurve, baseline: float | None) -> MeasuredCurve | None:
    """
    The indentations of a record as one approach and one retreat without noise; None if there are more, or no times.

    The contact point is approximately that of the travels. A monotone record of indentations is returned unchanged.
    """
    if curve.compliance == 0.0 and is_pressed_once(curve):
        return curve
    if curve.time is None:
        return None
    farthest = np.argsort(curve.position)[: max(1, curve.force.size // 10)]
    base = float(np.median(curve.force[farthest])) if baseline is None else baseline
    depth = curve.position - curve.compliance * (curve.force - base)
    deepest = int(np.argmax(depth))
    monotone = np.concatenate([_monotone(depth[: deepest + 1]), _monotone(depth[deepest:][::-1])[::-1][1:]])
    if float(np.sqrt(np.mean((monotone - depth) ** 2))) > _WANDERS * float(np.ptp(depth)):
        return None
    return MeasuredCurve(force=curve.force, indentation=monotone, time=curve.time)


def _monotone(values: FloatArray) -> FloatArray:
    """Monotone values: the mean of the running maximum and the reverse running minimum, linear between the middles of its plateaus."""
    even = 0.5 * (np.maximum.accumulate(values) + np.minimum.accumulate(values[::-1])[::-1])
    first = np.flatnonzero(np.diff(even, prepend=-np.inf) > 0.0)
    last = np.append(first[1:], even.size) - 1
    middle = 0.5 * (first + last)
    middle[-1] = first[-1]
    return np.interp(np.arange(even.size), middle, even[first])


def _sheared_starts(
    contact: Contact, unknowns: Sequence[Unknown], record: ShearRecord, known: dict[str, float], count: int
) -> list[Start]:
    """Starts for a record of friction, with several origins of the shift."""
    size, first = float(np.ptp(record.shift)), float(record.shift[0])
    tried = [known[SHIFT_ORIGIN]] if SHIFT_ORIGIN in known else [first + part * size for part in _BEFORE]
    best_starts, failures = [], []
    for values in _sheared_candidates(contact, unknowns, record):
        candidate = put_into(contact, unknowns, values)
        for origin in tried:
            try:
                left = (record.force - record.forces(candidate, origin))[record.used]
            except PymdrError as error:
                failures.append(error)
                continue
            baseline = known.get(BASELINE, float(left.mean()))
            best_starts.append(Start(float(((left - baseline) ** 2).sum()), values, origin, baseline))
    if not best_starts:
        raise ProblemError(f"no start can be computed: {failures[-1]}")
    return sorted(best_starts, key=lambda start: start.misfit)[:count]


def _sheared_candidates(
    contact: Contact, unknowns: Sequence[Unknown], record: ShearRecord
) -> list[FloatArray]:
    """Values with which sticking bodies carry about the measured force at the measured shift, and sufficient friction."""
    pull, amplitude = 0.5 * float(np.ptp(record.force)), 0.5 * float(np.ptp(record.shift))
    plain = [u for u in unknowns if not u.is_of_force and not u.name.startswith(_FRICTION)]
    values_tried = []
    for own in candidates(contact, plain, amplitude, 0.0, _PLAIN):
        shaped = put_into(contact, plain, own)
        grown = np.ones(1)
        if any(u.is_of_force for u in unknowns):
            stuck, _ = record.stuck(shaped)
            grown = (_STIFFNESS_RATIOS * pull / (amplitude * stuck)) ** 1.5
        for scale in grown:
            values = {
                u.name: float(np.clip(u.start * scale, u.low, u.high)) for u in unknowns if u.is_of_force
            }
            values |= {u.name: float(v) for u, v in zip(plain, own, strict=True)}
            _, load = record.stuck(with_parameters(contact, values))
            frictions = [u for u in unknowns if u.name.startswith(_FRICTION)]
            for ratio in _FRICTION_RATIOS if frictions else (1.0,):
                values |= {u.name: float(np.clip(ratio * pull / load, u.low, u.high)) for u in frictions}
                values_tried.append(np.array([values[u.name] for u in unknowns]))
    return values_tried


def _tried(
    forces: Forces,
    curve: MeasuredCurve,
    few: NDArray[np.intp],
    point: float,
    known: dict[str, float],
    values: FloatArray,
    unknowns: Sequence[Unknown],
    together: bool,
) -> Iterator[Start]:
    """Starts with one contact point, with scale and baseline by least squares."""
    force = curve.force[few]
    for scale, model in _scaled(forces, curve, curve.position[few] - point, force, together):
        start = _placed(force, model, scale, point, known, values, unknowns, together)
        if start is not None:
            yield start


def _placed(
    force: FloatArray,
    model: FloatArray,
    scale: float | None,
    point: float,
    known: dict[str, float],
    values: FloatArray,
    unknowns: Sequence[Unknown],
    together: bool,
) -> Start | None:
    """A start from the measured force and that of the model in N at a known scale, or at that of least squares."""
    # 1 if not all factors of the force are unknown
    known_scale = math.nan if together and scale is None else 1.0
    factor, baseline = scale_and_baseline(model, force, known_scale, known.get(BASELINE, math.nan))
    if not factor > 0.0:
        return None
    grown = factor if scale is None else scale
    own = [v * grown if u.is_of_force else v for u, v in zip(unknowns, values, strict=True)]
    misfit = float(((force - baseline - factor * model) ** 2).sum())
    return Start(misfit, np.array(own), point, float(baseline))


def _scaled(
    forces: Forces, curve: MeasuredCurve, position: FloatArray, force: FloatArray, together: bool
) -> Iterator[tuple[float | None, FloatArray]]:
    """
    Forces in N of the model: for one unknown scale, or on a machine for several scales.

    On a machine of compliance c a contact s times as stiff carries s F(d) at the travel d + c s F(d).
    """
    if curve.compliance == 0.0 or math.isinf(forces.fold):
        yield None, _carried(forces.fold, forces.at(position)[0], position, force)
        return
    top = max(float(position.max()), 0.0)
    depth = forces.fold + (max(top, 1e-3 * float(np.ptp(position))) - forces.fold) * _LADDER
    bare, _ = forces.at(depth)
    unit = float(np.ptp(force)) / float(np.abs(bare).max())
    for scale in unit * _SCALES if together else [1.0]:
        travel = np.maximum.accumulate(depth + curve.compliance * scale * bare)
        low = int(np.argmin(depth + curve.compliance * scale * bare))
        borne = np.interp(position, travel[low:], scale * bare[low:])
        yield scale, _carried(float(travel[low]), borne, position, force)


def _carried(fold: float, model: FloatArray, position: FloatArray, force: FloatArray) -> FloatArray:
    """Force in N of the model: contact from 0 on in approach, and while the force is tensile in retreat."""
    if math.isinf(fold):
        return model
    level = float(np.median(force[: max(3, force.size // 20)]))
    return np.where(first_guess_of_contact(position, force, fold, level), model, 0.0)
