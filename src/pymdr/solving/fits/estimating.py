"""What a search of a fit found, with its errors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ProblemError
from pymdr.problem.contact import Contact
from pymdr.problem.paths import Path, indent
from pymdr.result import Result
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.best import best_end, machine_in_words, refuse_few, refuse_unseen
from pymdr.solving.fits.determining import refuse_blind, refuse_lost
from pymdr.solving.fits.found import Fitted
from pymdr.solving.fits.loops import ShearRecord
from pymdr.solving.fits.residuals import hanging
from pymdr.solving.fits.searching import Modelled, Search, beside_jumps, found_from, refuse_unsettled
from pymdr.solving.fits.timing import refuse_untimed
from pymdr.solving.fits.unknowns import (
    ORIGINS,
    SHIFT_ORIGIN,
    Free,
    put_into,
    unknowns_of,
)
from pymdr.solving.verb import solve
from pymdr.units import FloatArray

if TYPE_CHECKING:
    pass


_UNFELT = 1e-6
"""Of the largest: rates of the residuals over an origin that a record does not feel."""
_ROUNDED = 1e-12
"""Of the largest: singular values that are rounding."""
_WIDER = 1.1
"""Errors of the family of forces that count, which also tell where a pull stands in a few samples."""
_AT_BOUND = 1e-4
"""Of what lies between the bounds in the numbers that the search changes."""


class Estimate(NamedTuple):
    """Where a search ended, and what it tells."""

    search: Search
    best: FloatArray
    """The free numbers."""
    values: dict[str, Fitted]
    contact: Contact
    """With the values that were found."""
    models: list[Modelled]
    felt: NDArray[np.bool_]
    """Which of the free numbers the record feels."""
    errors: FloatArray
    """Standard errors of the free numbers by noise; nan where the record does not feel them."""
    width: float
    """Of half an interval of 95 %, in standard errors."""
    moved: FloatArray
    """By how much a relative error 1 of all forces of the model may move the free numbers."""
    noise: float
    """In N."""
    correlated: float
    waves: float
    aicc: float

    @property
    def deepest(self) -> float:
        """Largest indentation in m."""
        return max(float(one.depth.max()) for one in self.models)


def estimate(contact: Contact, curve: MeasuredCurve, free: Free, known: Mapping[str, float]) -> Estimate:
    """What :func:`fit` finds in one force curve with some origins known, not how far to trust the model: that takes bodies with memory longer than the search."""
    return estimated(Search(contact, unknowns_of(contact, free), (checked(curve),), dict(known)))


def estimated(search: Search) -> Estimate:
    """What a search finds, refused where the records do not determine it."""
    misfit, best, wide = best_end(search)
    refuse_few(search, best)
    refuse_unseen(search, misfit, best)
    if not search.contact.remembers:  # whose end is only about the best
        refuse_blind(search, best)
    used = search.used or beside_jumps(search.models(best), search)
    if not all(part.all() for part in used):
        search = replace(search, used=used)
    minimum = found_from(search, best)
    refuse_unsettled(minimum)
    best = minimum.free
    values, _ = search.from_free(best)
    found = put_into(search.contact, search.unknowns, values)
    if found.remembers:
        times = [one.time for one in search.curves if one.time is not None]
        refuse_untimed(found, search.unknowns, values, times)
    refuse_blind(search, best)
    return _with_errors(search, best, wide)


def _with_errors(search: Search, best: FloatArray, wide: FloatArray) -> Estimate:
    """What a search found, with its errors."""
    from scipy.special import stdtrit

    residuals = search.residuals(best)
    slopes = search.slopes(best)
    n, p = residuals.size, best.size
    noise = math.sqrt(float((residuals**2).sum()) / max(n - p, 1))
    models = search.models(best)
    span = max(float(np.ptp(one.force)) for one in models)
    hang = hanging(residuals[None, :], np.array([span]))
    correlated = float(hang.correlated[0])
    independent = n / correlated
    refuse_lost(search, best, slopes, noise * math.sqrt(correlated))
    scale = np.linalg.norm(slopes, axis=0)
    felt = scale > _UNFELT * scale.max()
    left, singular, rows = np.linalg.svd(slopes[:, felt] / scale[felt], full_matrices=False)
    # what the record cannot tell apart has errors without end, but for the rounding of its slopes
    apart = rows / np.maximum(singular, _ROUNDED * singular.max())[:, None]
    errors = np.full(p, math.nan)
    errors[felt] = noise * np.sqrt(correlated) * np.linalg.norm(apart, axis=0) / scale[felt]
    used = search.used or tuple(np.ones(one.model.size, dtype=bool) for one in models)
    forces = np.concatenate([np.abs(one.model[part]) for one, part in zip(models, used, strict=True)])
    moved = np.zeros(p)
    moved[felt] = np.abs(apart.T @ left.T) @ forces / scale[felt]
    errors = np.where(wide > _WIDER * errors, wide, errors)
    width = float(stdtrit(max(independent - p, 1.0), 0.975))
    inner, _ = search.from_free(best)
    return Estimate(
        search,
        best,
        with_intervals(search, best, errors, width),
        put_into(search.contact, search.unknowns, inner),
        models,
        felt,
        errors,
        width,
        moved,
        noise,
        correlated,
        float(hang.waves[0]),
        aicc(float((residuals**2).mean()), independent, p),
    )


def judged(found: Estimate) -> Result:
    """The contact that was found, where it is pressed deepest; with memory or friction along the whole record."""
    contact, curve = found.contact, found.search.curves[0]
    if isinstance(curve, ShearRecord):
        return curve.solved(contact, found.search.from_free(found.best)[1][0][SHIFT_ORIGIN])
    if contact.remembers:
        assert curve.time is not None
        return solve(contact, Path(time=curve.time - curve.time[0], indentation=found.models[0].depth))
    if found.deepest <= 0.0:
        softness = 0.0 if curve.travel is None or not curve.spring_constant else 1.0 / curve.spring_constant
        raise ProblemError(
            f"fit: the bodies touch at no sample; {machine_in_words(curve.position, curve.force, softness)}give contact_point, or a "
            "record that presses them"
        )
    return solve(contact, indent(found.deepest))


def with_intervals(search: Search, best: FloatArray, errors: FloatArray, width: float) -> dict[str, Fitted]:
    """What was found by name, with intervals of the free numbers' errors."""
    found, rest = {}, at_bounds(search, best)
    bounds = {u.name: (u.low, u.high) for u in search.unknowns}
    units = {u.name: u.unit for u in search.unknowns}
    for i, name in enumerate(search.names):
        if math.isnan(errors[i]):
            continue
        ends = []
        for side in (0.0, -width, width, 1.0):
            moved = best.copy()
            moved[i] += side * errors[i]
            ends.append(search.named(moved)[name])
        value, low, high, one = ends
        unit = units.get(name) or ORIGINS.get(name.partition("[")[0], "")
        if name in rest:
            found[name] = Fitted(name, value, math.nan, *bounds[name], unit)
            continue
        found[name] = Fitted(name, value, abs(one - value), min(low, high), max(low, high), unit)
    return found


def at_bounds(search: Search, best: FloatArray) -> tuple[str, ...]:
    """Unknowns that rest at a bound."""
    rest = []
    for unknown, x, (low, high) in zip(search.unknowns, best, search.bounds(), strict=False):
        room = _AT_BOUND * (high - low if math.isfinite(high - low) else 1.0)
        if min(x - low, high - x) < room:
            rest.append(unknown.name)
    return tuple(rest)


def aicc(mean_square: float, independent: float, p: int) -> float:
    """AICc of least squares with an unknown noise (Burnham and Anderson 2002), of the independent samples."""
    k = p + 1
    room = max(independent - k - 1.0, 1.0)
    return independent * math.log(max(mean_square, 1e-300)) + 2.0 * k + 2.0 * k * (k + 1) / room


def checked(curve: MeasuredCurve) -> MeasuredCurve:
    """The samples of a record that are not marked; refused where they do not change."""
    for name, column in (("force", curve.force), ("depth", curve.position)):
        if float(np.ptp(column)) == 0.0:
            raise ProblemError(f"fit: the {name} of the record does not change: no contact is seen in it")
    return curve.leave_out_marked() if curve.marked.any() else curve
