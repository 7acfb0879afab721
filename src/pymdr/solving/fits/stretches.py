"""Fits of many curves, stretch by stretch."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np

from pymdr.errors import ConvergenceError, PymdrError
from pymdr.interpretation.validity import Assumption
from pymdr.line.curves import ElasticLine
from pymdr.line.foundation import states_at_depth
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.numerics.panels import IndexArray
from pymdr.problem.parameters import with_parameters
from pymdr.problem.paths import indent
from pymdr.problem.profiles import Shape
from pymdr.solving.curves.marking import FLAT, SHORTEST
from pymdr.solving.fits.calibrations import with_uncertainty
from pymdr.solving.fits.estimating import Estimate, estimated, search_of, solve_fitted
from pymdr.solving.fits.families import WORK, FamilyAxes
from pymdr.solving.fits.forces import rounded_up
from pymdr.solving.fits.quality import rise_along_baseline
from pymdr.solving.fits.quick import fit_by_family
from pymdr.solving.fits.ranges import (
    ROUNDS,
    FewSamplesError,
    estimated_within,
    few_text,
    next_samples,
    samples_within,
)
from pymdr.solving.fits.records import Records, Stretch
from pymdr.solving.fits.request import (
    DRIFT,
    FITTED,
    HIGH,
    IN_CONTACT,
    LOW,
    OF_LIMIT,
    PLATEAU,
    REFUSED,
    RESIDUAL,
    SYSTEMATIC,
    TOO_FEW,
    UNDETERMINED,
    UNREAD,
    UNSETTLED,
    WAVES,
    Columns,
    FitRequest,
    FittedStretch,
    empty_columns,
    fewest_in_contact,
    mark_undetermined,
)
from pymdr.solving.fits.systematic import put_systematic
from pymdr.solving.fits.unknowns import (
    CONTACT_POINT,
    TILT,
)
from pymdr.solving.mapped import assumptions, map_to_line
from pymdr.solving.memory import assumptions_with_memory
from pymdr.solving.verb import solve
from pymdr.solving.workers import Workers, in_order, is_cluster
from pymdr.units import FloatArray

_CHUNK = 2**19
"""Number of samples that are fitted and stored at a time."""
_JUDGED, _WIDER, _SIMILAR = 17, 1.0 + 1e-9, "elastic similarity"
"""Number of depths and of members of a family at which the assumptions are measured."""


def curves_of_chunk(request: FitRequest, records: Records) -> int:
    """Number of curves of a stretch: whole slices of the first dimension, one if the fast search does not apply."""
    inner, samples = math.prod(records.shape[1:]), records.read(0, 1).place.size
    if request.axes is None:
        return inner
    return inner * max(1, min(records.shape[0], _CHUNK // (inner * samples)))


def fitted_stretches(
    request: FitRequest,
    records: Records,
    parts: Sequence[tuple[int, int]],
    workers: Workers,
    progress: Callable[[int], None],
) -> Iterator[tuple[tuple[int, int], FittedStretch]]:
    """Fits of stretches of curves, in order."""
    if not is_cluster(workers):
        workers = min(workers, max(1, len(parts)))
    in_threads = workers != 1 and not is_cluster(workers) and request.axes is not None
    if in_threads:
        _prepare(request, records, parts)
    # callbacks stay in this process
    work = partial(_fit_stretch, request, progress=progress if workers == 1 else None)
    read = (records.read(*part) for part in parts)
    pool = ThreadPoolExecutor if in_threads else ProcessPoolExecutor
    yield from zip(parts, in_order(work, read, workers, pool), strict=True)


def _prepare(request: FitRequest, records: Records, parts: Sequence[tuple[int, int]]) -> None:
    """Tabulate and compile once, before threads start."""
    if parts:
        first, _ = parts[0]
        _fit_stretch(request, records.read(first, first + 1))


def _fit_stretch(
    request: FitRequest, stretch: Stretch, progress: Callable[[int], None] | None = None
) -> FittedStretch:
    """Fit some curves."""
    if request.axes is not None:
        fitted, stretch = _fit_family_within(request, request.axes, stretch)
        if request.uncertainty:
            put_systematic(request, stretch, fitted.columns, _refit)
        _judge(request, fitted.columns, stretch)
        mark_undetermined(request, fitted.columns)
    else:  # what each fit by itself does not determine is refused there
        fitted = _fit_one_by_one(request, stretch, progress)
    fitted.columns[PLATEAU][:] = _plateaus(stretch)
    for name in request.units:
        fitted.columns[name][fitted.columns["ending"] != FITTED] = math.nan
    return fitted


def _fit_family(request: FitRequest, axes: FamilyAxes, stretch: Stretch) -> FittedStretch:
    """Fit some curves by a family of forces, with those of too few samples in contact marked."""
    fitted = fit_by_family(request, axes, stretch)
    if request.contact.adhesion is None and CONTACT_POINT not in request.known:
        ending = fitted.columns["ending"]
        few = _pressed(fitted.columns[CONTACT_POINT], stretch) < fewest_in_contact(len(request.unknowns))
        ending[few & (ending == FITTED)] = UNDETERMINED
    return fitted


def _refit(request: FitRequest, stretch: Stretch) -> Columns:
    assert request.axes is not None
    return _fit_family(request, request.axes, stretch).columns


def _fit_family_within(
    request: FitRequest, axes: FamilyAxes, stretch: Stretch
) -> tuple[FittedStretch, Stretch]:
    """Fit the samples of some curves within the limits of a request, found in turn; also the curves without the others."""
    fitted = _fit_family(request, axes, stretch)
    if not request.limits:
        return fitted, stretch
    columns, refusals = fitted.columns, set(fitted.refusals)
    fewest = fewest_in_contact(len(request.unknowns), int(CONTACT_POINT not in request.known))
    whole = np.isfinite(stretch.place) & np.isfinite(stretch.force)
    seen, rows = [whole], np.flatnonzero(columns["ending"] == FITTED)
    for _ in range(ROUNDS):
        own = {name: column[rows] for name, column in columns.items()}
        kept, moving = seen[-1].copy(), []
        for i, *masks in zip(rows, *samples_within(request, axes, stretch.rows(rows), own), strict=True):
            within, touches = (mask[whole[i]] for mask in masks)
            if text := few_text(request.limits, within, touches, fewest):
                refusals.add(text)
                columns["ending"][i] = TOO_FEW
            elif (new := next_samples([one[i][whole[i]] for one in seen], within)) is not None:
                kept[i, whole[i]] = new
                moving.append(i)
        if not moving:
            break
        rows = np.array(moving)
        seen.append(kept)
        cut = stretch.rows(rows)
        again = _fit_family(request, axes, cut._replace(force=np.where(kept[rows], cut.force, math.nan)))
        refusals |= again.refusals
        for name, column in again.columns.items():
            columns[name][rows] = column
        rows = rows[columns["ending"][rows] == FITTED]
    else:
        columns["ending"][rows] = UNSETTLED
    force = np.where(seen[-1], stretch.force, math.nan)
    return FittedStretch(columns, frozenset(refusals)), stretch._replace(force=force)


def _pressed(point: FloatArray, stretch: Stretch) -> IndexArray:
    """Number of samples of each curve beyond the contact point, also on a machine."""
    with np.errstate(invalid="ignore"):
        beyond = (stretch.place > point[:, None]) & np.isfinite(stretch.force)
    return np.asarray(np.count_nonzero(beyond, axis=1))


def _judge(request: FitRequest, columns: Columns, stretch: Stretch) -> None:
    """Measures of quality of each curve: samples in contact, and residuals and rise of the baseline over the force range."""
    known, law = request.known.get(CONTACT_POINT), request.contact.adhesion
    point = columns[CONTACT_POINT] if known is None else np.full(len(stretch.place), known)
    with np.errstate(invalid="ignore", divide="ignore"):
        span = np.fmax.reduce(stretch.force, axis=1) - np.fmin.reduce(stretch.force, axis=1)
        columns[IN_CONTACT][:] = _pressed(point, stretch)
        columns[RESIDUAL][:] = columns["noise"] / span
        if law is not None:
            point = point - (law.attraction_range or 0.0)  # before contact, the end of the baseline
        columns[DRIFT][:] = _rises(stretch, point) / span
    if TILT in columns:  # a fitted tilt explains its rise
        middle = np.nan_to_num(point - np.fmin.reduce(stretch.place, axis=1))
        with np.errstate(invalid="ignore", divide="ignore"):
            columns[DRIFT][:] -= columns[TILT] * middle / span


def _rises(stretch: Stretch, point: FloatArray) -> FloatArray:
    """Rise in N of the force along the baseline of each approach, by a straight line; nan with fewer than 8 samples."""
    rows = zip(stretch.place, stretch.force, point, strict=True)
    return np.array([rise_along_baseline(place, force, float(end)) for place, force, end in rows])


def _plateaus(stretch: Stretch) -> FloatArray:
    """Number of samples of each curve at its largest force while the depth changes."""
    force = stretch.force
    with np.errstate(invalid="ignore"):
        largest, least = np.fmax.reduce(force, axis=1), np.fmin.reduce(force, axis=1)
        near = force >= (largest - 1.01 * FLAT * (largest - least))[:, None]
    if force.shape[1] < SHORTEST:
        return np.zeros(len(force))
    long = np.logical_and.reduce([near[:, i : near.shape[1] - SHORTEST + 1 + i] for i in range(SHORTEST)])
    counts = np.zeros(len(force))
    for i in np.flatnonzero(long.any(axis=1)):
        with suppress(PymdrError):
            counts[i] = stretch.curve(int(i)).mark_saturated().marked.sum()
    return counts


def _fit_one_by_one(
    request: FitRequest, stretch: Stretch, progress: Callable[[int], None] | None
) -> FittedStretch:
    out, refusals = empty_columns(request, len(stretch.place)), set()
    for i in range(len(stretch.place)):
        if progress is not None and i:
            progress(i)
        try:
            curve = stretch.curve(i)
        except PymdrError:
            out["ending"][i] = UNREAD
            continue
        try:
            search = search_of(request.contact, curve, request.free, request.known)
            result = estimated_within(search, request.limits)[0] if request.limits else estimated(search)
            assumed = _assumed(result)
            ends, parts = with_uncertainty(result, request.uncertainty) if request.uncertainty else ({}, {})
        except ConvergenceError:
            out["ending"][i] = UNSETTLED
        except FewSamplesError as error:
            out["ending"][i] = TOO_FEW
            refusals.add(str(error))
        except PymdrError as error:
            out["ending"][i] = REFUSED
            refusals.add(str(error))
        else:
            for name in request.names:
                out[name][i], out[f"{name}_error"][i] = result.values[name].value, result.values[name].error
                if request.uncertainty:
                    out[f"{name}{LOW}"][i], out[f"{name}{HIGH}"][i] = ends[name].low, ends[name].high
                    shared = [parts[source][name] for source in request.uncertainty]
                    out[f"{name}{SYSTEMATIC}"][i] = math.hypot(*shared)
            out["noise"][i], out["correlated"][i] = result.noise, result.correlated
            out[WAVES][i], out[OF_LIMIT][i] = result.waves, _of_limit(assumed)
            out["indentation"][i] = result.deepest
            out[IN_CONTACT][i], out[RESIDUAL][i], out[DRIFT][i] = result.quality
            out["ending"][i] = FITTED
    return FittedStretch(out, frozenset(refusals))


def _assumed(result: Estimate) -> tuple[Assumption, ...]:
    """Assumptions for a curve; for bodies with memory without its history, which is slower than the search."""
    if not result.contact.is_viscoelastic:
        return solve_fitted(result).assumptions
    line = ElasticLine(equivalent_profile(result.contact.profile), 1.0)
    return assumptions_with_memory(
        result.contact, states_at_depth(line, [max(result.deepest, 0.0)]).contact_radius
    )


def _of_limit(assumed: Sequence[Assumption]) -> float:
    """The largest ratio of a measure to its limit, without Dundurs' beta, which is the same for all curves."""
    parts = [a.measure / a.limit for a in assumed if a.name != _SIMILAR and a.limit > 0.0]
    return max((part for part in parts if math.isfinite(part)), default=math.nan)


def of_limits(request: FitRequest, axes: FamilyAxes, columns: Columns, first: float) -> FloatArray:
    """
    The largest ratio of a measure to its limit of every curve, from a table over depth and family.

    The family is that of the first curve if it is deep enough, so that the result does not depend on stored stretches.
    """
    from scipy.interpolate import RegularGridInterpolator

    out = np.full(columns["ending"].size, math.nan)
    fitted = np.flatnonzero((columns["ending"] == FITTED) & (columns["indentation"] > 0.0))
    if not fitted.size:
        return out
    depth = columns["indentation"][fitted]
    numbers = axes.numbers(np.column_stack([columns[u.name][fitted] for u in request.unknowns]))
    family = request.family(max(first, rounded_up(float(depth.max()))))
    last = len(family.members) - 1
    rungs = np.clip((numbers - family.first) / family.step, 0.0, float(last))
    chosen = np.unique(
        np.linspace(np.floor(rungs.min()), min(np.floor(rungs.max()) + 1.0, last), _JUDGED).astype(int)
    )
    depths = np.geomspace(depth.min(), depth.max() * _WIDER, _JUDGED)
    table = np.empty((chosen.size, depths.size))
    for row, rung in zip(table, chosen, strict=True):
        value = (
            {}
            if axes.number is None
            else {axes.number.name: axes.number.from_free(family.first + family.step * rung)}
        )
        contact = with_parameters(
            replace(request.contact, adhesion=None), {k: v for k, v in value.items() if k != WORK}
        )
        if isinstance(contact.profile, Shape):
            row[:] = [_of_limit(solve(contact, indent(depth)).assumptions) for depth in depths.tolist()]
            continue
        mapped, member = map_to_line(contact), family.members[rung]
        row[:] = [_of_limit(assumptions(contact, mapped, radius[None])) for radius in member.radius(depths)]
    at = np.column_stack([np.log(depth), rungs])
    if chosen.size == 1:
        out[fitted] = np.exp(np.interp(at[:, 0], np.log(depths), np.log(table[0])))
    else:
        out[fitted] = np.exp(RegularGridInterpolator((np.log(depths), chosen), np.log(table.T))(at))
    return out
