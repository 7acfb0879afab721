"""Fits of many curves, stretch by stretch."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from pymdr.errors import ConvergenceError, PymdrError
from pymdr.interpretation.validity import Assumption
from pymdr.line.curves import ElasticLine
from pymdr.line.foundation import states_at_depth
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.numerics.panels import IndexArray
from pymdr.problem.parameters import with_parameters
from pymdr.solving.curves.marking import FLAT, SHORTEST
from pymdr.solving.fits.asking import (
    FOUND,
    OF_LIMIT,
    PLATEAU,
    REFUSED,
    UNREAD,
    UNSETTLED,
    UNTOLD,
    WAVES,
    Asked,
    Columns,
    FittedStretch,
    empty_columns,
    fewest_in_contact,
    leave_untold_out,
)
from pymdr.solving.fits.estimating import Estimate, estimate, judged
from pymdr.solving.fits.families import WORK, Ways
from pymdr.solving.fits.forces import rounded_up
from pymdr.solving.fits.quick import fit_by_family
from pymdr.solving.fits.records import Records, Stretch
from pymdr.solving.fits.unknowns import (
    CONTACT_POINT,
)
from pymdr.solving.memory import assumptions_with_memory
from pymdr.solving.reach import assumptions, map_to_line
from pymdr.units import FloatArray

_CHUNK = 2**19
"""Samples that are fitted, and kept, at a time."""
_JUDGED, _WIDER, _SIMILAR = 17, 1.0 + 1e-9, "elastic similarity"
"""Depths, and numbers of a family, at which what is assumed is measured."""


def curves_of_chunk(asked: Asked, records: Records) -> int:
    """Whole slices of the first dimension; one where each curve takes its time."""
    inner, samples = math.prod(records.shape[1:]), records.read(0, 1).place.size
    if asked.ways is None:
        return inner
    return inner * max(1, min(records.shape[0], _CHUNK // (inner * samples)))


def fitted_stretches(
    asked: Asked,
    records: Records,
    parts: Sequence[tuple[int, int]],
    workers: int | Any,
    told: Callable[[int], None],
) -> Iterator[tuple[tuple[int, int], FittedStretch]]:
    """What the fits of stretches of curves give, as they are finished."""
    if not isinstance(workers, int):
        yield from _shared(asked, records, parts, workers.get_executor(), 4 * max(len(workers.ncores()), 1))
        return
    workers = min(workers, max(1, len(parts)))
    if workers == 1:
        for part in parts:
            yield part, _fit_stretch(asked, records.read(*part), told)
    elif asked.ways is not None:
        _prepare(asked, records, parts)
        with ThreadPoolExecutor(workers) as pool:
            yield from _shared(asked, records, parts, pool, 2 * workers)
    else:
        with ProcessPoolExecutor(workers) as pool:
            yield from _shared(asked, records, parts, pool, 2 * workers)


def _prepare(asked: Asked, records: Records, parts: Sequence[tuple[int, int]]) -> None:
    """Tabulate and compile once, before threads begin."""
    if parts:
        first, _ = parts[0]
        _fit_stretch(asked, records.read(first, first + 1))


def _shared(
    asked: Asked, records: Records, parts: Sequence[tuple[int, int]], pool: Executor, waiting: int
) -> Iterator[tuple[tuple[int, int], FittedStretch]]:
    """Stretches in their order, a few of them under way at a time."""
    work: Callable[[Stretch], FittedStretch] = partial(_fit_stretch, asked)
    under_way: list[tuple[tuple[int, int], Future[FittedStretch]]] = []
    for part in parts:
        under_way.append((part, pool.submit(work, records.read(*part))))
        if len(under_way) >= waiting:
            oldest, future = under_way.pop(0)
            yield oldest, future.result()
    for oldest, future in under_way:
        yield oldest, future.result()


def _fit_stretch(asked: Asked, stretch: Stretch, told: Callable[[int], None] | None = None) -> FittedStretch:
    """What was found in some curves."""
    if asked.ways is not None:
        fitted = fit_by_family(asked, asked.ways, stretch)
        if asked.contact.adhesion is None and CONTACT_POINT not in asked.known:
            ending = fitted.columns["ending"]
            few = _pressed(fitted.columns, stretch) < fewest_in_contact(len(asked.unknowns))
            ending[few & (ending == FOUND)] = UNTOLD
    else:
        fitted = _fit_one_by_one(asked, stretch, told)
    fitted.columns[PLATEAU][:] = _plateaus(stretch)
    leave_untold_out(asked, fitted.columns)
    return fitted


def _pressed(columns: Columns, stretch: Stretch) -> IndexArray:
    """How many samples of each curve are in contact, without adhesion: those beyond the contact point, also on a machine."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.count_nonzero(stretch.place > columns[CONTACT_POINT][:, None], axis=1))


def _plateaus(stretch: Stretch) -> FloatArray:
    """How many samples of each curve have its largest force while it is pressed on."""
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


def _fit_one_by_one(asked: Asked, stretch: Stretch, told: Callable[[int], None] | None) -> FittedStretch:
    out, refusals = empty_columns(asked, len(stretch.place)), set()
    for i in range(len(stretch.place)):
        if told is not None and i:
            told(i)
        try:
            curve = stretch.curve(i)
        except PymdrError:
            out["ending"][i] = UNREAD
            continue
        try:
            found = estimate(asked.contact, curve, asked.free, asked.known)
            assumed = _assumed(found)
        except ConvergenceError:
            out["ending"][i] = UNSETTLED
        except PymdrError as error:
            out["ending"][i] = REFUSED
            refusals.add(str(error))
        else:
            for name in asked.names:
                out[name][i], out[f"{name}_error"][i] = found.values[name].value, found.values[name].error
            out["noise"][i], out["correlated"][i] = found.noise, found.correlated
            out[WAVES][i], out[OF_LIMIT][i] = found.waves, _of_limit(assumed)
            out["indentation"][i] = found.deepest
            out["ending"][i] = FOUND
    return FittedStretch(out, frozenset(refusals))


def _assumed(found: Estimate) -> tuple[Assumption, ...]:
    """What the model assumes of a curve; for bodies with memory without the history, which takes longer than the search."""
    if not found.contact.remembers:
        return judged(found).assumptions
    line = ElasticLine(equivalent_profile(found.contact.profile), 1.0)
    return assumptions_with_memory(
        found.contact, states_at_depth(line, [max(found.deepest, 0.0)]).contact_radius
    )


def _of_limit(assumed: Sequence[Assumption]) -> float:
    """The largest measure in parts of its limit; Dundurs' beta, which does not change with the curve, is none."""
    parts = [a.measure / a.limit for a in assumed if a.name != _SIMILAR and a.limit > 0.0]
    return max((part for part in parts if math.isfinite(part)), default=math.nan)


def of_limits(asked: Asked, ways: Ways, columns: Columns, first: float) -> FloatArray:
    """
    That of every curve, from a table over the largest depth and the number in which the contacts differ.

    The family is that of the first curve where it reaches, which is known already, and does not depend on what was kept before.
    """
    from scipy.interpolate import RegularGridInterpolator

    out = np.full(columns["ending"].size, math.nan)
    found = np.flatnonzero((columns["ending"] == FOUND) & (columns["indentation"] > 0.0))
    if not found.size:
        return out
    depth = columns["indentation"][found]
    numbers = ways.numbers(np.column_stack([columns[u.name][found] for u in asked.unknowns]))
    family = asked.family(max(first, rounded_up(float(depth.max()))))
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
            if ways.number is None
            else {ways.number.name: ways.number.from_free(family.first + family.step * rung)}
        )
        contact = with_parameters(
            replace(asked.contact, adhesion=None), {k: v for k, v in value.items() if k != WORK}
        )
        mapped, member = map_to_line(contact), family.members[rung]
        row[:] = [_of_limit(assumptions(contact, mapped, radius[None])) for radius in member.radius(depths)]
    at = np.column_stack([np.log(depth), rungs])
    if chosen.size == 1:
        out[found] = np.exp(np.interp(at[:, 0], np.log(depths), np.log(table[0])))
    else:
        out[found] = np.exp(RegularGridInterpolator((np.log(depths), chosen), np.log(table.T))(at))
    return out
