"""Fits judged with the jumps of their law: where contact begins and ends is part of what a law of adhesion states.

A fit takes the jumps from the record, since snap-in and pull-off scatter in measurements and would move the parameters. A comparison
of laws must not: a law with hysteresis would explain a record without, and the other way round.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pymdr.errors import PymdrError
from pymdr.solving.fits.forces import Forces, forces_of
from pymdr.solving.fits.minimizing import forward_steps
from pymdr.solving.fits.results import FitResult
from pymdr.solving.fits.searching import Search
from pymdr.solving.fits.touching import BoolArray, in_contact_by_law, off_changes
from pymdr.solving.fits.unknowns import BASELINE, TILT, put_into
from pymdr.units import FloatArray

_POINTS = 201
"""Contact points that are tried at once."""
_AROUND = 1.5
"""Contact points are tried up to this multiple of the depth of the fold away."""
_TRIALS, _TOLERANCE = 60, 1e-6
_MARGIN = 0.1
"""Distance of a jump from the samples between which it is, relative to theirs, that is not penalised."""


class Judged(NamedTuple):
    """A law against a record, with its own jumps."""

    misfit: float
    """Mean square of the used residuals in N^2."""
    residuals: FloatArray
    """In N, of all samples of all curves."""
    used: BoolArray
    """Samples that are not adjacent to a jump of the law."""


def judged(result: FitResult) -> Judged:
    """
    A law against its record, refitted with its own jumps.

    The refit starts from the fit and minimises the squares of the residuals of the samples in contact according to the record, and of
    the distances of the jumps of the law from those of the record, each sample of which weighs as much as the jump of the force. The
    contact points are then moved to where the misfit with the jumps of the law is least. Fits that follow the history of the edge have the
    jumps of their law already.
    """
    search = result.search
    if result.contact.adhesion is None or search.shears or result.contact.has_edge_history:
        residuals, used = result.data["residual"].values, result.data["used"].values
        if result.contact.has_edge_history:
            used = np.concatenate([off_changes(one.touches) for one in search.models(result.free)])
        return Judged(float((residuals[used] ** 2).mean()), residuals, used)
    touches = tuple(one.touches for one in search.models(result.free))
    refitted = _with_jumps_near(replace(search, touches=touches), result.free)
    return min(
        (_at_best_points(search, free) for free in (result.free, refitted)), key=lambda one: one.misfit
    )


def _with_jumps_near(search: Search, free: FloatArray) -> FloatArray:
    """Free numbers with which the model fits the samples in contact, with jumps near those of the record."""
    from scipy.optimize import least_squares

    unit = max(float(np.ptp(one.force)) for one in search.curves)
    low, high = np.array(search.bounds()).T

    def slopes(x: FloatArray) -> FloatArray:
        steps = forward_steps(search, x, high)
        return np.vstack([search.slopes(x, steps, central=False), _penalty_slopes(search, x, steps)]) / unit

    return np.asarray(
        least_squares(
            lambda x: np.concatenate([search.residuals(x), _penalties(search, x)]) / unit,
            np.clip(free, low, high),
            slopes,
            bounds=(low, high),
            x_scale="jac",
            ftol=_TOLERANCE,
            xtol=_TOLERANCE,
            max_nfev=_TRIALS,
        ).x
    )


def _penalties(search: Search, free: FloatArray) -> FloatArray:
    """Distances of the jumps of the law from those of the record in samples, times the changes of the force in N."""
    try:
        return np.concatenate(
            [
                jumps.heights * _distances(curve.position - jumps.origin, touches, jumps)
                for curve, touches, jumps in zip(
                    search.measured, search.touches, _jumps(search, free), strict=True
                )
            ]
        )
    except PymdrError:
        return np.full(2 * len(search.curves), max(float(np.ptp(one.force)) for one in search.curves))


def _penalty_slopes(search: Search, free: FloatArray, steps: FloatArray) -> FloatArray:
    """Rates of the penalties over the free numbers, by steps."""
    here = _penalties(search, free)
    slopes = np.zeros((here.size, free.size))
    if not here.any():
        return slopes
    # at given depths the penalties are proportional to a common factor of all forces, as the forces are
    scaled = () if any(one.compliance for one in search.measured) else search.scaled_together
    for i, name in enumerate(search.names):
        if name.partition("[")[0] not in (BASELINE, TILT) and i not in scaled[:1]:
            step = np.where(np.arange(free.size) == i, steps, 0.0)
            slopes[:, i] = (_penalties(search, free + step) - here) / steps[i]
    if scaled:
        slopes[:, scaled[0]] = here - slopes[:, list(scaled[1:])].sum(axis=1)
    return slopes


class _Jumps(NamedTuple):
    """The jumps of a law into contact and out of it."""

    origin: float
    """Contact point in m."""
    onset: float
    """In m from the contact point."""
    fold: float
    """The loss of contact, in m from the contact point."""
    heights: FloatArray
    """Changes of the force in N at both."""
    forces: Forces


def _jumps(search: Search, free: FloatArray) -> list[_Jumps]:
    """The jumps of the law in every curve."""
    values, origins = search.from_free(free)
    contact = put_into(search.contact, search.unknowns, values)
    law, jumps = contact.adhesion, []
    assert law is not None
    for own, curve in zip(origins, search.measured, strict=True):
        position = curve.position - own[search.place]
        deepest = max(
            float(np.ptp(curve.depth)), float(position.max() - curve.compliance * curve.force.max())
        )
        forces = forces_of(contact, deepest, curve.compliance, None)
        onset = max(forces.fold, -law.work / law.cohesive_stress) if law.cohesive_stress else 0.0
        heights = np.abs(forces.at(np.array([onset, forces.fold]))[0])
        jumps.append(_Jumps(own[search.place], onset, forces.fold, heights, forces))
    return jumps


def _distances(position: FloatArray, touches: BoolArray, jumps: _Jumps) -> FloatArray:
    """Distances of two jumps in samples from the interval in which the record has them; 0 inside, and where the record shows none."""
    deepest, step = int(np.argmax(position)), float(np.median(np.abs(np.diff(position))))
    changes = np.flatnonzero(np.diff(touches.astype(int)))
    distances = np.zeros(2)
    for k, (jump, at) in enumerate(
        ((jumps.onset, changes[changes < deepest]), (jumps.fold, changes[changes >= deepest]))
    ):
        if at.size:
            low, high = np.sort(position[at[-k] : at[-k] + 2])
            margin = _MARGIN * (high - low)
            distances[k] = max(low + margin - jump, jump - high + margin, 0.0) / step
    return distances


def _at_best_points(search: Search, free: FloatArray) -> Judged:
    """The least misfit over contact points near, with the jumps of the law."""
    values, origins = search.from_free(free)
    moved, touches = [dict(one) for one in origins], []
    models = search.models(free)
    for own, curve, one, jumps in zip(moved, search.measured, models, _jumps(search, free), strict=True):
        position = curve.position - jumps.origin
        shifts = np.zeros(1) if search.place in search.known else _shifts(position, jumps.fold)
        at = position - shifts[:, None]
        inside = in_contact_by_law(at, jumps.onset, jumps.fold)
        depths = np.maximum(at, jumps.fold).ravel()
        model = np.where(inside, jumps.forces.at(depths)[0].reshape(at.shape), 0.0)
        least = int(np.argmin(np.mean((one.force - model) ** 2, axis=1, where=off_changes(inside))))
        own[search.place] += float(shifts[least])
        touches.append(inside[least])
    moved_free = search.to_free(values.tolist(), moved)
    models = replace(search, touches=tuple(touches)).models(moved_free)
    residuals = np.concatenate([one.force - one.model for one in models])
    used = np.concatenate([off_changes(one) for one in touches])
    return Judged(float((residuals[used] ** 2).mean()), residuals, used)


def _shifts(position: FloatArray, fold: float) -> FloatArray:
    """Changes of the contact point in m: none, and steps over its neighbourhood."""
    step = float(np.median(np.abs(np.diff(position))))
    around = _AROUND * abs(fold) + 4.0 * step
    return np.append(0.0, np.linspace(-around, around, _POINTS))
