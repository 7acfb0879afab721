"""Least squares of one family of forces in many curves together."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymdr.numerics.panels import IndexArray
from pymdr.solving.fits.bands import orthonormal
from pymdr.solving.fits.kernels.descent import (
    ITERATIONS,
    ROUGHLY,
    Ends,
    Limits,
    Wanted,
    descend_all,
    tangents_all,
    undecided,
    without_shape,
)
from pymdr.solving.fits.kernels.model import (
    BASE,
    NUMBERS,
    POINT,
    SHAPE,
    TILT,
    Batch,
    FamilyTable,
)
from pymdr.solving.fits.kernels.pulls import FEW, OfFamily, point_across_samples, start_near
from pymdr.solving.fits.kernels.starts import Engine, best_points, few_of, starts_at_tilts, tilts_of
from pymdr.solving.fits.request import AT_END, FITTED, NO_CONTACT, SEEN, UNDETERMINED, UNSETTLED
from pymdr.solving.fits.residuals import DECIDED
from pymdr.solving.fits.spectrum import noise_spectra
from pymdr.solving.fits.touching import FULLY_OUT, ROUNDS_OF_JUMPS, BoolArray, off_changes
from pymdr.units import FloatArray

_POLISH, _GAIN, _MANY = 100, 1e-6, 8
"""Steps of the last search, its gain relative to the sum of squares times the samples, and samples per start sample."""
_NEAR = 1e-5
"""Damping of the first step from the end of a search over means."""
_TOGETHER = 256
"""Number of curves that share the probability of white noise."""
_ROUNDED = 1e-14
"""Rounding error of a constant record, relative to its largest force."""
_CROSSINGS = 4
"""Largest number of searches for a contact point beyond other samples."""
_POORLY, _ASIDES, _NORMAL_95 = 20, np.array([-0.8, -0.5, -0.3, -0.15, 0.15, 0.3, 0.5, 0.8]), 1.96
"""Number of samples of a pull that are few; other starts there, in the logarithm of the number of the family."""

AS_IT_IS = Engine(descend_all, best_points, tangents_all)


class CurveFits(NamedTuple):
    """Output of the fits of curves."""

    numbers: FloatArray
    """Numbers of the model, with the baseline in the middle of the places, sum of squares in N^2, samples used, largest depth in m,
    the growth of the squares with the smallest number of the family, over the density of the noise at each frequency, and the covariance of neighbours
    in N^2 by the slow part of the noise."""
    covariances: FloatArray
    """Inverse of the normal equations of the free numbers."""
    spectral: FloatArray
    """Covariances of the unknowns by the spectrum of the noise."""
    unmodelled: FloatArray
    """Those if the density of the noise is that of the residuals in every band."""
    widths: FloatArray
    """Half widths of the 95 % intervals of the unknowns in standard errors; NaN if they are not wanted."""
    ahead: FloatArray
    """Steps of the unknowns to the expected least squares; 0 at a minimum."""
    asides: FloatArray
    """Standard errors by other ends that fit as well under white noise, with the signs of their common change."""
    residuals: FloatArray
    """Residuals in N of the used samples."""
    ended: NDArray[np.int8]

    def of(self, rows: IndexArray) -> CurveFits:
        """Copies of some rows."""
        columns: tuple[NDArray[Any], ...] = self
        return CurveFits(*(column[rows] for column in columns))

    def put(self, rows: IndexArray, some: CurveFits) -> None:
        """Write into some rows."""
        columns: tuple[NDArray[Any], ...] = self
        for column, other in zip(columns, some, strict=True):
            column[rows] = other

    @contextmanager
    def kept(self, rows: IndexArray) -> Iterator[CurveFits]:
        """Some rows in their order, which are written back."""
        own = self if rows.size == len(self.ended) else self.of(rows)
        yield own
        if own is not self:
            self.put(rows, own)


class _Search(NamedTuple):
    """The common part of the search of all curves."""

    wanted: Wanted
    family: FamilyTable
    engine: Engine

    def from_places(
        self,
        batch: Batch,
        starts: FloatArray,
        limits: Limits,
        inside: BoolArray | None = None,
        used: BoolArray | None = None,
    ) -> Ends:
        """Descents along all free numbers, with prescribed samples in contact without those adjacent to a jump."""
        if used is None:
            used = np.ones(batch.place.shape, dtype=np.bool_) if inside is None else off_changes(inside)
        return self.engine.descents(batch, self.wanted.directions, self.family, starts, used, limits, inside)

    def at_shape(self, batch: Batch, starts: FloatArray, enough: float) -> Ends:
        """Descents with a fixed number of the family."""
        used, directions = np.ones(batch.place.shape, dtype=np.bool_), without_shape(self.wanted.directions)
        return self.engine.descents(batch, directions, self.family, starts, used, Limits(ITERATIONS, enough))

    @property
    def last(self) -> float:
        """The largest number of the family."""
        return self.family.first + self.family.step * (self.family.folds.size - 1)

    def at_end(self, theta: FloatArray) -> BoolArray:
        """Whether numbers of the model are at an end of the family."""
        shape, several = theta[:, SHAPE], self.family.folds.size > 1
        return np.asarray(several & ((shape <= self.family.first) | (shape >= self.last)))


def _of(batch: Batch, curves: IndexArray) -> Batch:
    """Some of the curves, in their order."""
    if curves.size == len(batch.place):
        return batch
    return Batch(batch.place[curves], batch.force[curves], batch.softness[curves])


def _few(batch: Batch, stride: int) -> Batch:
    """Samples of all curves at a distance."""
    return batch._replace(place=batch.place[:, ::stride].copy(), force=batch.force[:, ::stride].copy())


def _means(batch: Batch, size: int) -> Batch:
    """Means of neighbouring samples of all curves."""
    count, many = len(batch.place), batch.place.shape[1] // size
    place, force = (column[:, : many * size].reshape(count, many, size).mean(axis=2) for column in batch[:2])
    return batch._replace(place=place, force=force)


def _put(ends: Ends, curves: IndexArray, others: Ends, better: BoolArray) -> None:
    """Replace the ends of some curves by better ones."""
    for column, other in zip(ends, others, strict=True):
        column[curves[better]] = other[better]


def _pulling(ends: Ends) -> IndexArray:
    """Number of samples of the pull: in contact, with at least 0.3 of its largest value."""
    pull = np.minimum(ends.force.min(axis=1, keepdims=True), 0.0)
    return np.asarray(np.count_nonzero(ends.touches & (ends.force < FULLY_OUT * pull), axis=1))


def _try_other_ends(search: _Search, batch: Batch, ends: Ends, enough: float) -> FloatArray:
    """
    Replace ends by better ones with other numbers of the family; return the distance to the farthest that fits as well.

    If a pull has few samples, the misfit jumps when one of them gets in or out of contact, which its curvature does not show. The
    farthest number is searched within the 95 % interval of one number.
    """
    distance = np.zeros((len(batch.place), NUMBERS))
    poor, n = np.flatnonzero(_pulling(ends) < _POORLY), batch.place.shape[1]
    if not poor.size:
        return distance
    trials = []
    for aside in _ASIDES:
        trial = ends.theta[poor]
        trial[:, SHAPE] += aside
        within = (search.family.first <= trial[:, SHAPE]) & (trial[:, SHAPE] <= search.last)
        curves = poor[within]
        if not curves.size:
            continue
        some = _of(batch, curves)
        fixed = search.at_shape(some, trial[within], enough)
        trials.append((curves, fixed))
        others = search.from_places(some, fixed.theta, Limits(ITERATIONS, enough))
        _put(ends, curves, others, others.misfit < ends.misfit[curves])
    for curves, fixed in trials:
        offset = fixed.theta - ends.theta[curves]
        wider = fixed.misfit <= ends.misfit[curves] * (1.0 + _NORMAL_95**2 / n)
        wider &= np.abs(offset[:, SHAPE]) > np.abs(distance[curves, SHAPE])
        distance[curves[wider]] = offset[wider]
    return distance


def _move_across_samples(search: _Search, batch: Batch, ends: Ends, enough: float) -> None:
    """Replace ends whose contact point would fit better beyond other samples, where the misfit of a constant pull jumps."""
    moving = np.flatnonzero((batch.softness == 0.0) & np.isfinite(ends.misfit))
    if not moving.size:
        return
    starts = np.array(
        [
            start_near(batch.place[i], batch.force[i], search.wanted, search.family, ends.theta[i])
            for i in moving
        ]
    )
    others = search.from_places(_of(batch, moving), starts, Limits(ITERATIONS, enough))
    _put(ends, moving, others, others.misfit < ends.misfit[moving])
    for _ in range(_CROSSINGS):
        starts = ends.theta[moving]
        for theta, i in zip(starts, moving, strict=True):
            force = batch.force[i] - theta[BASE] - theta[TILT] * batch.place[i]
            theta[POINT] = point_across_samples(
                batch.place[i], force, float(theta[POINT]), OfFamily(search.family, theta.copy())
            )
        changed = starts[:, POINT] != ends.theta[moving, POINT]
        moving, starts = moving[changed], starts[changed]
        if not moving.size:
            return
        others = search.from_places(_of(batch, moving), starts, Limits(ITERATIONS, enough))
        better = others.misfit < ends.misfit[moving]
        _put(ends, moving, others, better)
        moving = moving[better]


def _descend_off_jumps(search: _Search, batch: Batch, ends: Ends, used: BoolArray, enough: float) -> Ends:
    """
    Descents with fixed jumps without the samples adjacent to them, which are written into `used`.

    The jumps are those of the ends themselves, found in turn: an end whose jumps are elsewhere depends on its start. Those of a constant pull
    at a known indentation stay: without the samples beside it, it would move on and on. Where the law with its own samples in contact then has
    significantly larger squares than at the start, it decides in the descent: fixed samples may be fitted far beyond the loss of contact.
    """
    limits, first, inside = Limits(_POLISH, enough), ends, ends.touches.copy()
    ends = search.from_places(batch, first.theta, limits, inside)
    own = moving = np.flatnonzero((batch.softness != 0.0) | (not search.wanted.pulled))
    for _ in range(ROUNDS_OF_JUMPS - 1):
        touches = search.from_places(_of(batch, moving), ends.theta[moving], Limits(0, 0.0)).touches
        moved = (touches != inside[moving]).any(axis=1)
        moving = moving[moved]
        if not moving.size:
            break
        inside[moving] = touches[moved]
        others = search.from_places(_of(batch, moving), ends.theta[moving], limits, inside[moving])
        _put(ends, moving, others, np.ones(moving.size, dtype=np.bool_))
    used[:] = off_changes(inside)
    before = off_changes(first.touches[own])
    common, of_law = before & used[own], search.from_places(_of(batch, own), ends.theta[own], Limits(0, 0.0))
    least, larger = ((one * common) ** 2 for one in (first.left[own], of_law.left))
    astray = larger.sum(axis=1) > least.sum(axis=1) * (1.0 + SEEN / np.maximum(common.sum(axis=1), 1))
    if astray.any():
        rest = own[astray]
        used[rest] = before[astray]
        others = search.from_places(_of(batch, rest), first.theta[rest], limits, used=used[rest])
        _put(ends, rest, others, np.ones(rest.size, dtype=np.bool_))
    return ends


def _left_without_family(search: _Search, batch: Batch, ends: Ends) -> FloatArray:
    """Residuals with the smallest number of the family."""
    bare = ends.theta.copy()
    bare[:, SHAPE] = search.family.first
    return search.at_shape(batch, bare, ROUGHLY).left


def _asides(distance: FloatArray, directions: FloatArray) -> FloatArray:
    """Standard errors of the free numbers by other ends that fit as well."""
    first = np.argmax(np.abs(directions) > 0.0, axis=1)
    return np.asarray(distance[:, first] / directions[np.arange(len(first)), first] / _NORMAL_95)


def _put_spectral(
    search: _Search, batch: Batch, ends: Ends, used: BoolArray, bare: FloatArray | None, fits: CurveFits
) -> None:
    """
    Write what depends on the spectra of the noise, of curves with equal numbers of used samples together.

    The residuals `bare` are those with the smallest number of the family.
    """
    counted, directions = used.sum(axis=1), search.wanted.directions
    for size in np.unique(counted):
        group = np.flatnonzero(counted == size)
        for rows in np.array_split(group, -(-group.size // _TOGETHER)):
            rates = np.empty((rows.size, len(directions), used.shape[1]))
            search.engine.tangents_all(
                _of(batch, rows),
                directions,
                search.family,
                ends.theta[rows],
                used[rows],
                ends.touches[rows] if search.wanted.adhesive else undecided(rows.size),
                rates,
            )
            left = ends.left[rows]
            if size < used.shape[1]:
                rates = np.swapaxes(np.swapaxes(rates, 1, 2)[used[rows]].reshape(rows.size, size, -1), 1, 2)
                left = left[used[rows]].reshape(rows.size, size)
            good = np.isfinite(rates.sum(axis=2)).all(axis=1) & np.isfinite(left.sum(axis=1))
            if not good.any():
                continue
            if not good.all():
                rows, rates, left = rows[good], rates[good], left[good]
            basis, coefficients = orthonormal(rates)
            coefficients = search.wanted.back @ coefficients
            turned = np.swapaxes(coefficients, 1, 2)
            fits.ahead[rows] = (coefficients @ (basis @ left[:, :, None]))[:, :, 0]
            spectra = noise_spectra(left, basis, prior=None, keep=search.wanted.intervals)
            if search.wanted.intervals:
                fits.widths[rows] = spectra.quantile(coefficients)
            fits.spectral[rows] = coefficients @ spectra.covariance @ turned
            if bare is not None:
                fits.unmodelled[rows] = coefficients @ spectra.unmodelled() @ turned
                others = bare[rows][used[rows]].reshape(rows.size, size)
                fits.numbers[rows, NUMBERS + 3] = spectra.growth(others)
            fits.numbers[rows, NUMBERS + 4] = np.where(spectra.white < DECIDED, spectra.slow, 0.0)


def _show_contact(batch: Batch, wanted: Wanted, ends: Ends, used: BoolArray) -> BoolArray:
    """Whether a constant force leaves significantly larger squares."""
    level, count = batch.force, used.sum(axis=1)
    if ends.theta[:, TILT].any():
        level = level - ends.theta[:, TILT, None] * batch.place
    partly = not used.all()
    if partly:
        level = level * used
    mean = level.sum(axis=1) / count if wanted.free[BASE] else wanted.known[BASE]
    off = level - np.reshape(mean, (-1, 1))
    if partly:
        off *= used
    total = np.einsum("ij,ij->i", off, off)
    grows = (total / np.maximum(ends.misfit, 1e-300) - 1.0) * count >= SEEN
    rounded = count * (_ROUNDED * np.maximum(level.max(axis=1), -level.min(axis=1))) ** 2
    return np.asarray(grows & (total > rounded))


def _first_places(search: _Search, batch: Batch, known: FloatArray) -> tuple[FloatArray, IndexArray]:
    """
    Starts of the descents, NaN without contact, and the number of samples used for them.

    A few samples of a record may not show a short pull: without adhesion at the start of an adhesive contact, more of them are searched.
    """
    chosen = few_of(batch.force)
    theta = _places(search, batch, known, chosen)
    unseen = search.wanted.adhesive & (search.at_end(theta) | np.isnan(theta).any(axis=1))
    rest, stride = np.flatnonzero(unseen), max(batch.place.shape[1] // (_MANY * FEW), 1)
    if rest.size:
        chosen[rest, ::stride] = True
        theta[rest] = _places(search, _of(batch, rest), known[rest], chosen[rest])
    return theta, np.count_nonzero(chosen, axis=1)


def _places(search: _Search, batch: Batch, known: FloatArray, chosen: BoolArray) -> FloatArray:
    """Starts from the chosen samples of each curve."""
    sizes, theta = np.count_nonzero(chosen, axis=1), np.full(known.shape, math.nan)
    for size in np.unique(sizes):
        curves = np.flatnonzero(sizes == size)
        samples = chosen[curves]
        few = Batch(
            batch.place[curves][samples].reshape(-1, size),
            batch.force[curves][samples].reshape(-1, size),
            batch.softness[curves],
        )
        least = np.full(curves.size, math.inf)
        for tilts in tilts_of(few, search.wanted):
            misfit, places = starts_at_tilts(
                few, search.wanted, search.family, known[curves], tilts, search.engine
            )
            better = misfit < least
            least[better], theta[curves[better]] = misfit[better], places[better]
    return theta


def _fit_rows(search: _Search, batch: Batch, known: FloatArray, fits: CurveFits) -> None:
    """Fit curves whose samples are finite and all used."""
    n = batch.place.shape[1]
    if n < 2 * len(search.wanted.directions) + 2:
        return
    starts, sizes = _first_places(search, batch, known)
    has_start = np.isfinite(starts).all(axis=1) & (np.ptp(batch.force, axis=1) > 0.0)
    fits.ended[:] = NO_CONTACT
    rest = np.flatnonzero(has_start)
    if rest.size:
        with fits.kept(rest) as own:
            _descend_from(search, _of(batch, rest), starts[rest], sizes[rest], own)


def _descend_from(
    search: _Search, batch: Batch, starts: FloatArray, sizes: IndexArray, fits: CurveFits
) -> None:
    """Fit curves from their starts."""
    wanted, (count, n) = search.wanted, batch.place.shape
    used, enough = np.ones(batch.place.shape, dtype=np.bool_), _GAIN / n
    last, long = Limits(_POLISH, enough), np.flatnonzero(n > _MANY * sizes)
    if long.size:
        # an intermediate number of samples first saves steps over all of them
        some, stride = _of(batch, long), max(n // (_MANY * FEW), 1)
        if wanted.adhesive:
            more, limits = _few(some, stride), Limits(ITERATIONS, ROUGHLY)
        else:
            # means state nearly what all samples state of a force without jumps
            more, limits = _means(some, stride), last
            if long.size == count:
                last = last._replace(damping=_NEAR)
        starts[long] = search.from_places(more, starts[long], limits).theta
    ends = search.from_places(batch, starts, last)
    if wanted.pulled and wanted.free[POINT]:
        _move_across_samples(search, batch, ends, enough)
    distance, bare = np.zeros((count, NUMBERS)), None
    if wanted.adhesive:
        if wanted.free[SHAPE] and not wanted.tied:
            distance = _try_other_ends(search, batch, ends, enough)
            bare = _left_without_family(search, batch, ends)
        ends = _descend_off_jumps(search, batch, ends, used, enough)
    counted, rows, at = used.sum(axis=1), np.arange(count), np.argmax(batch.place, axis=1)
    deepest = batch.place[rows, at] - ends.theta[:, POINT] - batch.softness * ends.force[rows, at]
    shows, at_end = _show_contact(batch, wanted, ends, used), search.at_end(ends.theta)
    fits.ended[:] = np.select(
        [~ends.settled, ~shows, deepest <= 0.0, at_end],
        [UNSETTLED, NO_CONTACT, UNDETERMINED, AT_END],
        FITTED,
    )
    fits.numbers[:, :NUMBERS] = ends.theta
    fits.numbers[:, NUMBERS : NUMBERS + 4] = np.column_stack(
        [ends.misfit, counted, deepest, np.full(count, math.inf)]
    )
    fits.covariances[:], fits.asides[:] = ends.covariance, _asides(distance, wanted.directions)
    fits.asides[ends.misfit <= 0.0] = 0.0
    _put_spectral(search, batch, ends, used, bare, fits)
    fits.residuals[np.arange(fits.residuals.shape[1]) < counted[:, None]] = ends.left[used]


def fit_curves(curves: Batch, wanted: Wanted, family: FamilyTable, fits: CurveFits, engine: Engine) -> None:
    """Fit many curves; samples that are not finite are left out."""
    search = _Search(wanted, family, engine)
    good = np.isfinite(curves.place) & np.isfinite(curves.force)
    sizes = np.count_nonzero(good, axis=1)
    for size in np.unique(sizes):
        rows = np.flatnonzero(sizes == size)
        batch = _of(curves, rows)
        if size < good.shape[1]:
            place, force = (column[good[rows]].reshape(-1, size) for column in batch[:2])
            batch = batch._replace(place=place, force=force)
        known, middle = np.tile(wanted.known, (rows.size, 1)), np.zeros(rows.size)
        if size and wanted.free[TILT]:
            middle = 0.5 * (batch.place.min(axis=1) + batch.place.max(axis=1))
            known[:, POINT] -= middle
            batch = batch._replace(place=batch.place - middle[:, None])
        with fits.kept(rows) as own:
            _fit_rows(search, batch, known, own)
            own.numbers[:, POINT] += middle
