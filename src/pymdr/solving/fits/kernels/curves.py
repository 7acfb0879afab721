"""Least squares of one family of forces: thousands of curves, one after another. Loads numba."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pymdr.solving.fits.asking import AT_END, FOUND, NO_CONTACT, SEEN, UNREAD, UNSETTLED
from pymdr.solving.fits.kernels.descent import ITERATIONS, ROUGHLY, descend, settle, solved
from pymdr.solving.fits.kernels.ends import NORMAL_95, POORLY, other_ends, pulling, ways_without_shape
from pymdr.solving.fits.kernels.model import ALL, BASE, POINT, SHAPE, TILT, Family, compiled
from pymdr.solving.fits.kernels.starts import FEW, begun, few_of
from pymdr.units import FloatArray

_POLISH, _TOLD, _MANY = 100, 1e-3, 8
"""The second, a gain in parts of the sum of squares times the samples, where 1 is a standard error."""


_ROUNDED = 1e-14
"""Of the largest force: what a record that does not change is off its mean."""


@compiled
def _nearer(
    place: FloatArray,
    force: FloatArray,
    theta: FloatArray,
    ways: FloatArray,
    family: Family,
    softness: float,
    plain: bool,
) -> None:
    """Take `theta` on to the best place of more samples, so that the last steps over all of them are few."""
    m = ways.shape[1]
    square = np.empty((m, m))
    if plain:
        near = theta.copy()
        if settle(place, force, near, ways, family, softness, ROUGHLY, square, np.empty(place.size))[1]:
            theta[:] = near
            return
    everything, touches = np.ones(place.size, dtype=np.bool_), np.empty(place.size, dtype=np.bool_)
    out = np.empty((place.size, 4))
    descend(
        place, force, everything, theta, ways, family, softness, ITERATIONS, ROUGHLY, square, touches, out
    )  # fmt: skip


@compiled
def _ended_adhesive(
    place: FloatArray,
    force: FloatArray,
    theta: FloatArray,
    ways: FloatArray,
    family: Family,
    softness: float,
    misfit: float,
    square: FloatArray,
    touches: NDArray[np.bool_],
    out: FloatArray,
    apart: FloatArray,
) -> tuple[float, float]:
    """The sum of squares with the best number of the family, and by how many variances it grows with the smallest."""
    n = place.size
    if pulling(touches, out[:, 0]) < POORLY:
        misfit = other_ends(
            place, force, theta, ways, family, softness, _TOLD / n, misfit, square, touches, out, apart
        )
    held, bare = ways_without_shape(ways), theta.copy()
    bare[SHAPE] = family[3]
    larger, _ = descend(
        place, force, np.ones(n, dtype=np.bool_), bare, held, family, softness, ITERATIONS, ROUGHLY,
        np.empty((held.shape[1], held.shape[1])), touches.copy(), out.copy(),
    )  # fmt: skip
    return misfit, (larger / misfit - 1.0) * n if misfit > 0.0 else math.inf


@compiled
def _invert(square: FloatArray, covariance: FloatArray) -> None:
    m = square.shape[0]
    unit, column = np.zeros(m), np.empty(m)
    for p in range(m):
        unit[:] = 0.0
        unit[p] = 1.0
        solved(square, 0.0, unit, column)
        covariance[:, p] = column


@compiled
def _widen(covariance: FloatArray, apart: FloatArray, ways: FloatArray, variance: float) -> None:
    """Other ends that fit as well widen what the curvature tells."""
    m = ways.shape[1]
    column = np.zeros(m)
    for p in range(m):
        for i in range(ALL):
            if ways[i, p] != 0.0:
                column[p] = apart[i] / ways[i, p]
                break
    for p in range(m):
        for q in range(m):
            covariance[p, q] += column[p] * column[q] / NORMAL_95**2 / variance


@compiled
def fit_curve(
    place: FloatArray,
    force: FloatArray,
    known: FloatArray,
    free: NDArray[np.bool_],
    tied: bool,
    ways: FloatArray,
    family: Family,
    softness: float,
    adhesive: bool,
    theta: FloatArray,
    covariance: FloatArray,
    residual: FloatArray,
    used: NDArray[np.bool_],
) -> tuple[int, float, float, float]:
    """
    Fit one curve: how it ended, the sum of squares in N^2, the largest depth in m, and what is gained by the family.

    The last is by how many variances of the noise the sum grows with the smallest number of the family. `theta`, the inverse of the
    normal equations, residuals and what was used are left in the last four.
    """
    n, m, folds = place.size, ways.shape[1], family[2]
    covariance[:, :], residual[:], used[:], theta[:] = math.nan, math.nan, False, math.nan
    if n < 2 * m + 2 or not np.all(np.isfinite(force)) or not np.all(np.isfinite(place)):
        return UNREAD, math.nan, math.nan, math.nan
    chosen = few_of(force)
    few = place[chosen]
    misfit = begun(few, force[chosen], known, free, tied, ways, family, softness, adhesive, theta)
    if not math.isfinite(misfit):
        return NO_CONTACT, math.nan, math.nan, math.nan
    plain = not adhesive and folds.size == 1
    if n > _MANY * few.size:
        between = max(n // (_MANY * FEW), 1)
        _nearer(place[::between].copy(), force[::between].copy(), theta, ways, family, softness, plain)
    used[:] = True
    square, enough, settled = np.empty((m, m)), _TOLD / n, False
    apart, grows = np.zeros(ALL), math.inf
    if plain:
        near = theta.copy()
        misfit, settled = settle(place, force, near, ways, family, softness, enough, square, residual)
        if settled:
            theta[:] = near
    if not settled:
        out, touches = np.empty((n, 4)), np.empty(n, dtype=np.bool_)
        misfit, settled = descend(
            place, force, used, theta, ways, family, softness, _POLISH, enough, square, touches, out
        )
        if adhesive and free[SHAPE] and not tied:
            misfit, grows = _ended_adhesive(
                place, force, theta, ways, family, softness, misfit, square, touches, out, apart
            )
        if adhesive:
            for i in range(n - 1):
                if touches[i] != touches[i + 1]:
                    used[i], used[i + 1] = False, False
            misfit, settled = descend(
                place, force, used, theta, ways, family, softness, _POLISH, enough, square, touches, out
            )
        for i in range(n):
            residual[i] = force[i] - theta[BASE] - theta[TILT] * place[i] - out[i, 0]
    count, total, largest = 0, 0.0, 0.0
    for i in range(n):
        if used[i]:
            count += 1
            above = force[i] - theta[TILT] * place[i]
            total += above
            largest = max(largest, abs(above))
    level = total / count if free[BASE] else known[BASE]
    flat = 0.0
    for i in range(n):
        if used[i]:
            flat += (force[i] - theta[TILT] * place[i] - level) ** 2
    _invert(square, covariance)
    if apart[SHAPE] != 0.0 and misfit > 0.0:
        _widen(covariance, apart, ways, misfit / (count - m))
    at = int(np.argmax(place))
    pressed = force[at] - theta[BASE] - theta[TILT] * place[at] - residual[at]
    deepest = place[at] - theta[POINT] - softness * pressed
    if not settled:
        return UNSETTLED, misfit, deepest, grows
    if (
        (flat / max(misfit, 1e-300) - 1.0) * count < SEEN
        or deepest <= 0.0
        or flat <= count * (_ROUNDED * largest) ** 2
    ):
        return NO_CONTACT, misfit, deepest, grows
    last = family[3] + family[4] * (folds.size - 1)
    if folds.size > 1 and (theta[SHAPE] <= family[3] or theta[SHAPE] >= last):
        return AT_END, misfit, deepest, grows
    return FOUND, misfit, deepest, grows


@compiled
def fit_curves(
    places: FloatArray,
    forces: FloatArray,
    softness: FloatArray,
    known: FloatArray,
    free: NDArray[np.bool_],
    tied: bool,
    adhesive: bool,
    ways: FloatArray,
    family: Family,
    numbers: FloatArray,
    covariances: FloatArray,
    residuals: FloatArray,
    ended: NDArray[np.int8],
) -> None:
    """
    Fit many curves, one in each row; samples that are not finite are left out.

    Numbers: the five of the model, of which the baseline stands in the middle of the places, sum of squares in N^2, samples used, largest depth in m, and what :func:`fit_curve` says that the
    sum grows by.
    """
    for i in range(places.shape[0]):
        place, force = places[i], forces[i]
        if not (np.all(np.isfinite(place)) and np.all(np.isfinite(force))):
            good = np.isfinite(place) & np.isfinite(force)
            place, force = place[good], force[good]
        residual, used = np.empty(place.size), np.empty(place.size, dtype=np.bool_)
        own, middle = known.copy(), 0.0
        if place.size and free[TILT]:
            middle = 0.5 * (place.min() + place.max())
            place = place - middle
            own[POINT] -= middle
        ended[i], numbers[i, 5], numbers[i, 7], numbers[i, 8] = fit_curve(
            place, force, own, free, tied, ways, family, softness[i], adhesive, numbers[i, :5], covariances[i],
            residual, used,
        )  # fmt: skip
        numbers[i, POINT] += middle
        kept = residual[used]
        numbers[i, 6] = kept.size
        residuals[i, :] = math.nan
        residuals[i, : kept.size] = kept
