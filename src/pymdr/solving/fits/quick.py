"""Fits of many curves by one family of forces."""

from __future__ import annotations

import logging
import math
from contextlib import suppress
from functools import cache

import numpy as np

from pymdr.errors import PymdrError
from pymdr.interpretation.theories import theory_of
from pymdr.solving.fits.families import WORK, Family, FamilyAxes, forces_at
from pymdr.solving.fits.forces import bare_forces, rounded_up
from pymdr.solving.fits.kernels import (
    AS_IT_IS,
    BASE,
    NUMBERS,
    POINT,
    SHAPE,
    Batch,
    CurveFits,
    Engine,
    FamilyTable,
    Wanted,
    fit_curves,
    member_at,
    read,
)
from pymdr.solving.fits.kernels import TILT as TILTED
from pymdr.solving.fits.records import Stretch
from pymdr.solving.fits.request import (
    AT_END,
    FITTED,
    REFUSED,
    SEEN,
    UNDETERMINED,
    UNREAD,
    UNSETTLED,
    WAVES,
    WIDTH,
    Columns,
    FitRequest,
    FittedStretch,
    empty_columns,
)
from pymdr.solving.fits.residuals import waves_of
from pymdr.solving.fits.unknowns import BASELINE, CONTACT_POINT, TILT
from pymdr.units import FloatArray, written

_PLACES = {CONTACT_POINT: POINT, BASELINE: BASE, TILT: TILTED}
"""Indices of the origins among the numbers of the model."""
_DEPTH = NUMBERS + 2
_PLAINLY = 8.0
"""Work of adhesion that a record with waves shows, in standard errors by the density of its residuals."""

_SMALL_PART = 0.125
"""Depth of a contact over the range of its table below which it is fitted again by a finer table."""

_log = logging.getLogger("pymdr")


def fit_by_family(request: FitRequest, axes: FamilyAxes, stretch: Stretch) -> FittedStretch:
    """Fit some curves by one family of forces."""
    count, width = stretch.place.shape
    free = len(request.names)
    square, row = np.full((count, free, free), math.nan), np.full((count, free), math.nan)
    fits = CurveFits(
        np.full((count, NUMBERS + 5), math.nan),
        square,
        square.copy(),
        square.copy(),
        row,
        row.copy(),
        row.copy(),
        np.full((count, width), math.nan),
        np.full(count, UNREAD, dtype=np.int8),
    )
    refusals: set[str] = set()
    wanted = wanted_of(request, axes)
    engine = _compiled() if request.many else AS_IT_IS
    ranges = depth_ranges(stretch)
    _fit_ranges(request, stretch, (wanted, engine), ranges, fits, refusals)
    # a table to the length of the record is coarse for a contact that is a small part of it
    depths = fits.numbers[:, _DEPTH]
    small = np.flatnonzero((fits.ended == FITTED) & (depths < _SMALL_PART * ranges) & (depths > 0.0))
    if small.size:
        some, again = fits.of(small), fits.of(small)
        finer = np.array([rounded_up(2.0 * depth) for depth in depths[small].tolist()])
        part = stretch._replace(
            place=stretch.place[small], force=stretch.force[small], softness=stretch.softness[small]
        )
        _fit_ranges(request, part, (wanted, engine), finer, again, set())
        good = np.flatnonzero(again.ended == FITTED)
        some.put(good, again.of(good))
        fits.put(small, some)
    with np.errstate(invalid="ignore"):  # curves that were not fitted have no covariances
        fits = fits._replace(
            covariances=wanted.back @ fits.covariances @ wanted.back.T, asides=fits.asides @ wanted.back.T
        )
    return FittedStretch(_columns(request, axes, fits, stretch), frozenset(refusals))


def _fit_ranges(
    request: FitRequest,
    stretch: Stretch,
    search: tuple[Wanted, Engine],
    ranges: FloatArray,
    fits: CurveFits,
    refusals: set[str],
) -> None:
    """Fit curves by families of forces, one for every range of depths in m."""
    wanted, engine = search
    for deepest in np.unique(ranges[ranges > 0.0]):
        chosen = np.flatnonzero(ranges == deepest)
        try:
            family = request.family(float(deepest))
        except PymdrError as error:
            fits.ended[chosen] = REFUSED
            refusals.add(str(error))
            continue
        curves = Batch(stretch.place[chosen], stretch.force[chosen], stretch.softness[chosen])
        with fits.kept(chosen) as own:
            fit_curves(curves, wanted, table_of(family), own, engine)
        end = family.end(fits.numbers[chosen, SHAPE])
        depths = fits.numbers[:, _DEPTH]
        beyond = chosen[(fits.ended[chosen] == FITTED) & (depths[chosen] > end)]
        if beyond.size:
            fits.ended[beyond] = REFUSED
            refusals.add(
                f"the profile ends at {written(float(end.min()), 'm', 4)} of indentation, and a curve has "
                f"{written(float(depths[beyond].max()), 'm', 4)}; extend the profile"
            )


def table_of(family: Family) -> FamilyTable:
    """The arrays of a family."""
    return FamilyTable(family.forces, family.slopes, family.folds, family.first, family.step, family.deepest)


def table_error(request: FitRequest, axes: FamilyAxes, numbers: FloatArray) -> float:
    """
    The largest difference of the tables from the forces between their nodes, relative to the range of the forces.

    It is measured at the smallest, median and largest of the free numbers of the fitted curves, which are between rungs.
    """
    worst = 0.0
    for deepest, family in request.families.items():
        last = family.first + family.step * (family.folds.size - 1)
        within = numbers[(numbers >= family.first) & (numbers <= last)]
        for free in np.unique(np.quantile(within, (0.0, 0.5, 1.0), method="nearest")) if within.size else ():
            with suppress(PymdrError):
                exact = (
                    bare_forces(request.contact, deepest)
                    if axes.number is None
                    else forces_at(request.contact, axes.number, float(free), deepest)
                )
                member = member_at(table_of(family), float(free))
                cells = member.force.size - 1
                depth = exact.fold + (deepest - exact.fold) * ((np.arange(cells) + 0.5) / cells) ** 2
                depth = depth[(depth <= exact.end) & (depth >= member.fold)]
                at = np.sqrt((depth - member.fold) / (deepest - member.fold))
                off = read(member.force, member.slope, at)[0] - exact.at(depth)[0]
                worst = max(worst, float(np.abs(off).max(initial=0.0) / np.ptp(member.force)))
    return worst


def _compiled() -> Engine:
    """The compiled search; the interpreted one, with a warning, if numba is missing."""
    try:
        from pymdr.solving.fits.kernels import compiled
    except ImportError:
        _say_slow()
        return AS_IT_IS
    return compiled.ENGINE


@cache
def _say_slow() -> None:
    """Warn that fits of maps are slow without numba."""
    _log.warning("numba cannot be imported: fits of maps are about fifty times slower; install numba")


def wanted_of(request: FitRequest, axes: FamilyAxes) -> Wanted:
    """The free numbers of the search."""
    rates, number = axes.columns(), axes.number
    directions, back = np.zeros((len(request.names), NUMBERS)), np.eye(len(request.names))
    if rates.shape[1] == 2:
        back[:2, :2] = np.linalg.inv(rates)
    # both numbers of the family are free, so that one of them may be at its end
    directions[: len(axes.unknowns), :2] = np.eye(2) if rates.shape[1] == 2 else rates.T
    for i, name in enumerate(request.origins, len(axes.unknowns)):
        directions[i, _PLACES[name]] = 1.0
    known = np.array([0.0, 0.0, *(request.known.get(name, 0.0) for name in _PLACES)])
    if number is not None and axes.shape is None:
        known[SHAPE] = number.to_free(number.start)
    free = [axes.scale is not None, axes.shape is not None, *(name not in request.known for name in _PLACES)]
    law = request.contact.adhesion
    pulled = law is not None and number is not None and number.name == WORK and theory_of(law).pulls_beyond
    adhesive, intervals = law is not None, bool(request.uncertainty)
    return Wanted(known, np.array(free), directions, back, axes.is_tied, adhesive, pulled, intervals)


def depth_ranges(stretch: Stretch) -> FloatArray:
    """Depth ranges in m, rounded up, that the tables for each curve need; 0 where there is none."""
    depth = stretch.place - stretch.softness[:, None] * stretch.force
    depth = np.where(np.isfinite(depth), depth, math.nan)
    spans = np.fmax.reduce(depth, axis=1) - np.fmin.reduce(depth, axis=1)
    return np.array([rounded_up(span) for span in np.nan_to_num(spans).tolist()])


def _errors(fits: CurveFits, noise: FloatArray, unknowns: int) -> tuple[FloatArray, FloatArray]:
    """Standard errors of the free numbers, and how many samples are equivalent to one, from the unknowns of the contact."""
    own = np.abs(np.einsum("ijj->ij", fits.spectral))
    with np.errstate(invalid="ignore", divide="ignore"):  # a constant record has no noise
        white = noise[:, None] ** 2 * np.abs(np.einsum("ijj->ij", fits.covariances))
        ratios = np.where(white[:, :unknowns] > 0.0, own[:, :unknowns] / white[:, :unknowns], 1.0)
    correlated = ratios.max(axis=1, initial=1.0)
    return np.sqrt(np.where(own > 0.0, own, white) + correlated[:, None] * fits.asides**2), correlated


def _columns(request: FitRequest, axes: FamilyAxes, fits: CurveFits, stretch: Stretch) -> Columns:
    """Values and errors of every curve."""
    span = np.fmax.reduce(stretch.force, axis=1) - np.fmin.reduce(stretch.force, axis=1)
    numbers, ended = fits.numbers, fits.ended
    out = empty_columns(request, len(numbers))
    out["ending"][:] = ended
    theta, (misfit, used, depth, grows, slow) = numbers[:, :NUMBERS], numbers[:, NUMBERS:].T
    free = len(request.names)
    with np.errstate(invalid="ignore", divide="ignore"):
        noise = np.sqrt(misfit / np.maximum(used - free, 1.0))
    fitted = np.flatnonzero(np.isfinite(noise))
    if fitted.size:
        some = slice(None) if fitted.size == len(numbers) else fitted
        out[WAVES][some] = waves_of(fits.residuals[some], span[some], slow[some])
    error, correlated = _errors(fits, noise, len(axes.unknowns))
    values, rates = axes.values(theta[:, 0], theta[:, 1])
    plain = {name: theta[:, place] for name, place in _PLACES.items()}
    for i, name in enumerate(request.names):
        value = plain[name] if name in plain else values[:, i]
        out[name][:] = value
        with np.errstate(invalid="ignore"):  # an infinite value without an error
            out[f"{name}_error"][:] = error[:, i] * (1.0 if name in plain else np.abs(rates[:, i]))
        if request.uncertainty:
            out[f"{name}{WIDTH}"] = fits.widths[:, i]
    for name, (low, high) in request.bounded.items():
        outside = (out[name] < low) | (out[name] > high)
        out["ending"][outside & (ended == FITTED)] = AT_END
    sizes = np.array([unknown.is_size for unknown in request.unknowns], dtype=bool)
    if WORK in out:
        # the misfit decides if a pull of a few samples widens the error, the error if the law leaves waves; where they are not
        # stationary, which widens it too much, the density of the residuals themselves with a stricter limit
        i = request.names.index(WORK)
        plainly = np.abs(fits.unmodelled[:, i, i]) + correlated * fits.asides[:, i] ** 2
        with np.errstate(invalid="ignore"):
            unseen = (grows < SEEN) & (out[WORK] < math.sqrt(SEEN) * out[f"{WORK}_error"])
            unseen &= out[WORK] < _PLAINLY * np.sqrt(plainly) * np.abs(rates[:, i])
            # without a modulus, the record does not show what the adhesion is
            unseen &= ~(np.delete(sizes & (error[:, : sizes.size] > 1.0), i, axis=1)).any(axis=1)
        out["ending"][unseen & (ended == FITTED)] = AT_END
    # a search along a flat valley: a change of a size by itself changes the sum of squares by less than a variance of the noise
    flat = sizes & (1.0 + 2.0 * np.abs(fits.ahead[:, : sizes.size]) < error[:, : sizes.size] ** 2)
    out["ending"][flat.any(axis=1) & (ended == UNSETTLED)] = UNDETERMINED
    out["noise"][:], out["correlated"][:], out["indentation"][:] = noise, correlated, depth
    return out
