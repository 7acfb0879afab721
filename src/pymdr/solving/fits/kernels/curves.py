"""Least squares of one family of forces in many curves together."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymdr.numerics.panels import IndexArray
from pymdr.solving.fits.asking import AT_END, FOUND, NO_CONTACT, SEEN, UNSETTLED
from pymdr.solving.fits.kernels.descent import (
    ITERATIONS,
    ROUGHLY,
    Ends,
    Wanted,
    descend_all,
    without_shape,
)
from pymdr.solving.fits.kernels.model import BASE, NUMBERS, POINT, SHAPE, TILT, Batch, FamilyTable
from pymdr.solving.fits.kernels.starts import FEW, Engine, best_points, few_of, starts_at_tilts, tilts_of
from pymdr.solving.fits.touching import FULLY_OUT, BoolArray
from pymdr.units import FloatArray

_POLISH, _TOLD, _MANY = 100, 1e-3, 8
"""The second, a gain in parts of the sum of squares times the samples, where 1 is a standard error."""
_ROUNDED = 1e-14
"""Of the largest force: what a record that does not change is off its mean."""
_POORLY, _ASIDES, _NORMAL_95 = 20, np.array([-0.8, -0.5, -0.3, -0.15, 0.15, 0.3, 0.5, 0.8]), 1.96
"""Samples of a pull that are few; other starts there, in the logarithm of the number of the family."""

AS_IT_IS = Engine(descend_all, best_points)


class Found(NamedTuple):
    """What is found in curves, into which it is written."""

    numbers: FloatArray
    """Those of the model, of which the baseline stands in the middle of the places, sum of squares in N^2, samples used, largest depth
    in m, and by how many variances of the noise the sum grows with the smallest number of the family."""
    covariances: FloatArray
    """Inverse of the normal equations of the free numbers."""
    residuals: FloatArray
    """In N, of the samples that are used."""
    ended: NDArray[np.int8]

    def of(self, rows: IndexArray) -> Found:
        """Copies of some rows."""
        return Found(self.numbers[rows], self.covariances[rows], self.residuals[rows], self.ended[rows])

    def put(self, rows: IndexArray, some: Found) -> None:
        """Write into some rows."""
        self.numbers[rows], self.covariances[rows] = some.numbers, some.covariances
        self.residuals[rows], self.ended[rows] = some.residuals, some.ended


class _Search(NamedTuple):
    """What all curves share."""

    wanted: Wanted
    family: FamilyTable
    engine: Engine

    def from_places(
        self, batch: Batch, starts: FloatArray, limits: tuple[int, float], used: BoolArray | None = None
    ) -> Ends:
        """Descents along all that is looked for."""
        used = np.ones(batch.place.shape, dtype=np.bool_) if used is None else used
        return self.engine.descents(batch, self.wanted.directions, self.family, starts, used, limits)

    def at_shape(self, batch: Batch, starts: FloatArray, enough: float) -> Ends:
        """Descents with the number of the family as it is."""
        used, held = np.ones(batch.place.shape, dtype=np.bool_), without_shape(self.wanted.directions)
        return self.engine.descents(batch, held, self.family, starts, used, (ITERATIONS, enough))

    @property
    def last(self) -> float:
        """The largest number of the family."""
        return self.family.first + self.family.step * (self.family.folds.size - 1)


def _of(batch: Batch, curves: IndexArray) -> Batch:
    """Some of the curves."""
    return Batch(batch.place[curves], batch.force[curves], batch.softness[curves])


def _put(ends: Ends, curves: IndexArray, others: Ends, better: BoolArray) -> None:
    """Put better ends of some curves in place of those that are known."""
    for column, other in zip(ends, others, strict=True):
        column[curves[better]] = other[better]


def _pulling(ends: Ends) -> IndexArray:
    """How many samples stand in the pull: touch with a third of its largest at least."""
    pull = np.minimum(ends.force.min(axis=1, keepdims=True), 0.0)
    return np.asarray(np.count_nonzero(ends.touches & (ends.force < FULLY_OUT * pull), axis=1))


def _try_other_ends(search: _Search, batch: Batch, ends: Ends, enough: float) -> FloatArray:
    """
    Take ends of smaller sums of squares with numbers of the family on both sides; the distance to the farthest that fits as well.

    Where a pull stands in a few samples, each that is taken for held or lost is a step in the misfit, which its curvature does not
    tell. The farthest number is sought within the 95 % of one number.
    """
    apart = np.zeros((len(batch.place), NUMBERS))
    poor, n = np.flatnonzero(_pulling(ends) < _POORLY), batch.place.shape[1]
    if not poor.size:
        return apart
    begun, beside = ends.theta[poor], []
    for aside in _ASIDES:
        trial = begun.copy()
        trial[:, SHAPE] += aside
        within = (search.family.first <= trial[:, SHAPE]) & (trial[:, SHAPE] <= search.last)
        curves = poor[within]
        if not curves.size:
            continue
        held = search.at_shape(_of(batch, curves), trial[within], enough)
        beside.append((curves, held))
        better = held.misfit < ends.misfit[curves]
        if better.any():
            nearer, places = curves[better], held.theta[better]
            others = search.from_places(_of(batch, nearer), places, (ITERATIONS, enough))
            _put(ends, nearer, others, others.misfit < ends.misfit[nearer])
    for curves, held in beside:
        away = held.theta - ends.theta[curves]
        farther = held.misfit <= ends.misfit[curves] * (1.0 + _NORMAL_95**2 / n)
        farther &= np.abs(away[:, SHAPE]) > np.abs(apart[curves, SHAPE])
        apart[curves[farther]] = away[farther]
    return apart


def _grown_without_family(search: _Search, batch: Batch, ends: Ends) -> FloatArray:
    """By how many variances of the noise the sums of squares grow with the smallest number of the family."""
    bare = ends.theta.copy()
    bare[:, SHAPE] = search.family.first
    larger = search.at_shape(batch, bare, ROUGHLY).misfit
    with np.errstate(divide="ignore", invalid="ignore"):
        grows = (larger / ends.misfit - 1.0) * batch.place.shape[1]
    return np.where(ends.misfit > 0.0, grows, math.inf)


def _covariances(ends: Ends, apart: FloatArray, directions: FloatArray, variance: FloatArray) -> FloatArray:
    """Inverses of the normal equations; other ends that fit as well widen what the curvature tells."""
    first = np.argmax(np.abs(directions) > 0.0, axis=1)
    moved = apart[:, first] / directions[np.arange(len(first)), first]
    wide = (apart[:, SHAPE] != 0.0) & (variance > 0.0)
    size = np.where(wide, _NORMAL_95**2 * variance, math.inf)
    widened: FloatArray = ends.covariance + moved[:, :, None] * moved[:, None, :] / size[:, None, None]
    return widened


def _show_contact(
    batch: Batch, wanted: Wanted, ends: Ends, used: BoolArray, deepest: FloatArray
) -> BoolArray:
    """Whether a constant force leaves squares that are larger than the noise makes them."""
    level, count = batch.force - ends.theta[:, TILT, None] * batch.place, used.sum(axis=1)
    mean = (level * used).sum(axis=1) / count if wanted.free[BASE] else wanted.known[BASE]
    total = (((level - np.reshape(mean, (-1, 1))) * used) ** 2).sum(axis=1)
    grows = (total / np.maximum(ends.misfit, 1e-300) - 1.0) * count >= SEEN
    rounded = count * (_ROUNDED * np.abs(level * used).max(axis=1)) ** 2
    return np.asarray(grows & (deepest > 0.0) & (total > rounded))


def _begun(search: _Search, batch: Batch, known: FloatArray) -> tuple[FloatArray, IndexArray]:
    """Where descents begin, nan where nothing touches, and how many samples told so."""
    chosen = few_of(batch.force)
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
    return theta, sizes


def _fit_rows(search: _Search, batch: Batch, known: FloatArray, found: Found) -> None:
    """Fit curves whose samples are finite, and all count."""
    count, n = batch.place.shape
    if n < 2 * len(search.wanted.directions) + 2:
        return
    starts, sizes = _begun(search, batch, known)
    begun = np.isfinite(starts).all(axis=1)
    found.ended[:] = NO_CONTACT
    if not begun.all():
        rest = np.flatnonzero(begun)
        some = found.of(rest)
        if rest.size:
            _descend_from(search, _of(batch, rest), starts[rest], sizes[rest], some)
        found.put(rest, some)
    elif count:
        _descend_from(search, batch, starts, sizes, found)


def _descend_from(search: _Search, batch: Batch, starts: FloatArray, sizes: IndexArray, found: Found) -> None:
    """Fit curves from where they begin."""
    wanted, (count, n), m = search.wanted, batch.place.shape, len(search.wanted.directions)
    long = np.flatnonzero(n > _MANY * sizes)
    if long.size:
        # more samples first, so that the last steps over all of them are few
        stride = max(n // (_MANY * FEW), 1)
        more = Batch(
            batch.place[long, ::stride].copy(), batch.force[long, ::stride].copy(), batch.softness[long]
        )
        starts[long] = search.from_places(more, starts[long], (ITERATIONS, ROUGHLY)).theta
    used, enough = np.ones(batch.place.shape, dtype=np.bool_), _TOLD / n
    ends = search.from_places(batch, starts, (_POLISH, enough))
    apart, grows = np.zeros((count, NUMBERS)), np.full(count, math.inf)
    if wanted.adhesive:
        if wanted.free[SHAPE] and not wanted.tied:
            apart = _try_other_ends(search, batch, ends, enough)
            grows = _grown_without_family(search, batch, ends)
        jumps = ends.touches[:, 1:] != ends.touches[:, :-1]
        used[:, :-1] &= ~jumps
        used[:, 1:] &= ~jumps
        ends = search.from_places(batch, ends.theta, (_POLISH, enough), used)
    counted, rows, at = used.sum(axis=1), np.arange(count), np.argmax(batch.place, axis=1)
    deepest = batch.place[rows, at] - ends.theta[:, POINT] - batch.softness * ends.force[rows, at]
    shows = _show_contact(batch, wanted, ends, used, deepest)
    shape, several = ends.theta[:, SHAPE], search.family.folds.size > 1
    at_end = several & ((shape <= search.family.first) | (shape >= search.last))
    found.ended[:] = np.select([~ends.settled, ~shows, at_end], [UNSETTLED, NO_CONTACT, AT_END], FOUND)
    found.numbers[:, :NUMBERS] = ends.theta
    found.numbers[:, NUMBERS:] = np.column_stack([ends.misfit, counted, deepest, grows])
    found.covariances[:] = _covariances(ends, apart, wanted.directions, ends.misfit / (counted - m))
    found.residuals[np.arange(found.residuals.shape[1]) < counted[:, None]] = ends.left[used]


def fit_curves(curves: Batch, wanted: Wanted, family: FamilyTable, found: Found, engine: Engine) -> None:
    """Fit many curves; samples that are not finite are left out."""
    search = _Search(wanted, family, engine)
    good = np.isfinite(curves.place) & np.isfinite(curves.force)
    sizes = np.count_nonzero(good, axis=1)
    for size in np.unique(sizes):
        rows = np.flatnonzero(sizes == size)
        place, force = (column[rows][good[rows]].reshape(-1, size) for column in curves[:2])
        known, middle = np.tile(wanted.known, (rows.size, 1)), np.zeros(rows.size)
        if size and wanted.free[TILT]:
            middle = 0.5 * (place.min(axis=1) + place.max(axis=1))
            known[:, POINT] -= middle
        own = found.of(rows)
        _fit_rows(search, Batch(place - middle[:, None], force, curves.softness[rows]), known, own)
        own.numbers[:, POINT] += middle
        found.put(rows, own)
