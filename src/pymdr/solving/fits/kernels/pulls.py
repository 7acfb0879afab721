"""Starts of contacts with a constant pull, whose misfit jumps whenever the contact point crosses a sample."""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np

from pymdr.solving.fits.kernels.descent import Wanted
from pymdr.solving.fits.kernels.model import (
    BASE,
    NUMBERS,
    OUTSIDE,
    POINT,
    SCALE,
    SHAPE,
    TILT,
    Batch,
    FamilyTable,
    member_at,
    read,
)
from pymdr.units import FloatArray

FEW = 192
"""Samples of the first search."""
BEST, _POINTS, _FINE, _ZOOMS, _NARROWER = 3, 33, 17, 3, 8.0
"""Starts of each curve; points of the first scan and of each finer one, number of these, and the ratio of their widths."""
_MOST, _FRACTION = 4096, 1.0 / 64.0
"""Largest number of samples of a scan near a contact point, and its width relative to the range of the places."""
_NEAR = 48
"""Samples on either side of a contact point between which it may move."""
_SINGULAR = 1e-12
"""Smallest determinant of the normal equations, whose diagonal is 1."""


class Scan(NamedTuple):
    """Linear least squares of one curve at contact points: at a fixed one scale, pull, baseline and tilt are linear."""

    place: FloatArray
    """In m."""
    force: FloatArray
    """In N, without a first tilt."""
    softness: float
    """Compliance of the machine in m/N."""
    wanted: Wanted
    family: FamilyTable
    known: FloatArray
    """Known numbers of the model."""

    @property
    def depth(self) -> FloatArray:
        """Travel less deflection in m, the baseline among it."""
        return self.place - self.softness * self.force

    def best(self) -> FloatArray:
        """The numbers of the best starts, the best first, shape (starts, 5)."""
        depth = self.depth
        low, high = float(depth.min()), float(depth.max())
        if not self.wanted.free[POINT]:
            # the deflection includes the baseline, the level farthest from the body
            level = float(self.force[np.argmin(self.place)])
            misfits, numbers = self.at(np.array([self.known[POINT] - self.softness * level]))
            return numbers[np.isfinite(misfits)]
        width = (high - low) / _POINTS
        points = np.linspace(low, high - width, _POINTS)
        misfits, _ = self.at(points)
        around = np.concatenate([[math.inf], misfits, [math.inf]])
        dips = np.flatnonzero((misfits <= around[:-2]) & (misfits <= around[2:]) & np.isfinite(misfits))
        return self.near(points[dips[np.argsort(misfits[dips], kind="stable")][:BEST]], width)

    def near(self, points: FloatArray, width: float) -> FloatArray:
        """The numbers of the best starts within a width in m of some contact points, the best first, shape (starts, 5)."""
        least, numbers = self.at(points)
        rows = np.arange(points.size)
        for _ in range(_ZOOMS if points.size else 0):
            finer = points[:, None] + width * np.linspace(-1.0, 1.0, _FINE)
            misfits, tried = self.at(finer.ravel())
            misfits, tried = misfits.reshape(finer.shape), tried.reshape(*finer.shape, NUMBERS)
            at = np.argmin(misfits, axis=1)
            better = misfits[rows, at] < least
            least = np.where(better, misfits[rows, at], least)
            points = np.where(better, finer[rows, at], points)
            numbers = np.where(better[:, None], tried[rows, at], numbers)
            width /= _NARROWER
        order = np.argsort(least, kind="stable")
        return numbers[order][np.isfinite(least[order])]

    def at(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Smallest sums of squares at contact points in m, infinite without a contact that presses, and the numbers of the model."""
        wanted, family, known = self.wanted, self.family, self.known
        scale_known, pull_known = math.exp(known[SCALE]), math.nan
        if wanted.tied:
            pull_known = scale_known * _pull_at(family, float(known[SHAPE]))
        pressed, pulled = _columns(self.depth, points, family)
        middle, constant = float(self.place.mean()), np.ones_like(pressed)
        side, rows = np.broadcast_to(self.force, constant.shape).copy(), {}
        for name, column, is_free, value in (
            (SCALE, pressed, wanted.free[SCALE], scale_known),
            (SHAPE, pulled, not wanted.tied, pull_known),
            (BASE, constant, wanted.free[BASE], known[BASE]),
            (TILT, constant * (self.place - middle), wanted.free[TILT], 0.0),
        ):
            if is_free:
                rows[name] = column
            else:
                side -= value * column
        solved, misfits = _least_squares(np.stack(list(rows.values()), axis=1), side)
        values = {
            SCALE: np.full(points.size, scale_known),
            SHAPE: np.full(points.size, pull_known),
            BASE: np.full(points.size, known[BASE]),
            TILT: np.zeros(points.size),
        } | dict(zip(rows, solved.T, strict=True))
        numbers, presses = np.tile(known, (points.size, 1)), values[SCALE] > 0.0
        scale = np.where(presses, values[SCALE], 1.0)
        numbers[:, SCALE], numbers[:, TILT] = np.log(scale), values[TILT]
        numbers[:, BASE] = values[BASE] - values[TILT] * middle
        numbers[:, SHAPE] = (
            known[SCALE] + known[SHAPE] - numbers[:, SCALE]
            if wanted.tied
            else _number_of_pull(family, values[SHAPE] / scale)
        )
        if wanted.free[POINT]:
            numbers[:, POINT] = points + self.softness * numbers[:, BASE]
        return np.where(presses, misfits, math.inf), numbers


def starts_of_pull(
    level: Batch, wanted: Wanted, family: FamilyTable, known: FloatArray, tilts: FloatArray
) -> FloatArray:
    """
    The best starts of curves with a constant pull.

    Parameters
    ----------
    level : Batch
        A few samples of each curve, without the first tilt.
    wanted : Wanted
    family : FamilyTable
    known : ndarray, shape (curves, 5)
        Known numbers of the model.
    tilts : ndarray, shape (curves,)
        First tilts in N/m.

    Returns
    -------
    ndarray, shape (curves, 3, 5)
        Numbers of the model, the best first; NaN if there are fewer.
    """
    out = np.full((len(tilts), BEST, NUMBERS), math.nan)
    for own, place, force, soft, numbers in zip(out, *level, known, strict=True):
        best = Scan(place, force, float(soft), wanted, family, numbers).best()
        own[: len(best)] = best
    out[..., TILT] += tilts[:, None]
    return out


def start_near(
    place: FloatArray, force: FloatArray, wanted: Wanted, family: FamilyTable, theta: FloatArray
) -> FloatArray:
    """
    The best numbers of one curve of indentations with contact points near one.

    Parameters
    ----------
    place : ndarray
        Indentations in m.
    force : ndarray
        In N.
    wanted : Wanted
    family : FamilyTable
    theta : ndarray, shape (5,)
        Numbers of the model near which the best ones are searched.
    """
    stride = max(place.size // _MOST, 1)
    known = np.where(wanted.free, theta, wanted.known)
    if wanted.tied:
        known[SCALE], known[SHAPE] = wanted.known[SCALE], wanted.known[SHAPE]
    scan = Scan(place[::stride], force[::stride] - theta[TILT] * place[::stride], 0.0, wanted, family, known)
    numbers = scan.near(theta[[POINT]], float(np.ptp(place)) * _FRACTION)
    numbers[:, TILT] += theta[TILT]
    return numbers[0] if len(numbers) else theta


def _columns(depth: FloatArray, points: FloatArray, family: FamilyTable) -> FloatArray:
    """Forces in N without a pull and of a pull of 1 N, at contact points, shape (2, points, samples)."""
    beyond = depth - points[:, None]
    touches = beyond > 0.0
    root = np.minimum(np.sqrt(np.where(touches, beyond, 0.0) / family.deepest), OUTSIDE)
    pressed = read(family.forces[0], family.slopes[0], root)[0] - family.forces[0, 0]
    return np.array([np.where(touches, pressed, 0.0), -touches.astype(float)])


def _least_squares(rows: FloatArray, side: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Solutions and sums of squares of many problems, shape (problems, columns, samples); infinite sums where one is singular."""
    sizes = np.sqrt(np.einsum("ijk,ijk->ij", rows, rows))
    safe = np.where(sizes > 0.0, sizes, 1.0)
    rows = rows / safe[:, :, None]
    square, right = rows @ rows.transpose(0, 2, 1), np.einsum("ijk,ik->ij", rows, side)
    good = np.linalg.det(square) > _SINGULAR
    square[~good] = np.eye(rows.shape[1])
    solved = np.linalg.solve(square, right[..., None])[..., 0]
    left = side - np.einsum("ij,ijk->ik", solved, rows)
    return solved / safe, np.where(good, np.einsum("ij,ij->i", left, left), math.inf)


def _pull_at(family: FamilyTable, number: float) -> float:
    """Pull in N of the member of scale 1: a power of the work, whose logarithm is the number."""
    at = (number - family.first) / family.step
    return math.exp(float(np.interp(at, np.arange(family.folds.size), np.log(-family.forces[:, 0]))))


def _number_of_pull(family: FamilyTable, pulls: FloatArray) -> FloatArray:
    """The number of the family of pulls in N at scale 1, at most that of its ends."""
    logs = np.log(-family.forces[:, 0])
    at = np.interp(np.log(np.maximum(pulls, math.exp(logs[0]))), logs, np.arange(logs.size))
    return np.asarray(family.first + family.step * at)


class AtDepths(Protocol):
    """Forces over depths."""

    def at(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force in N and stiffness in N/m, at depths in m above 0."""


class OfFamily(NamedTuple):
    """Forces of a member of a family without a fold."""

    family: FamilyTable
    theta: FloatArray
    """The numbers of the model."""

    def at(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force in N and its rate over the root of the depth, at depths in m above 0."""
        member = member_at(self.family, self.theta[SHAPE])
        root = np.minimum(np.sqrt(depth / member.deepest), OUTSIDE)
        force, slope, _ = read(member.force, member.slope, root)
        return math.exp(self.theta[SCALE]) * force, slope


def point_across_samples(place: FloatArray, force: FloatArray, point: float, model: AtDepths) -> float:
    """
    The contact point in m with the smallest sum of squares near one, with the other numbers of the model fixed.

    Parameters
    ----------
    place : ndarray
        Indentations in m.
    force : ndarray
        In N, without baseline and tilt.
    point : float
        In m.
    model : AtDepths
    """
    for near in sorted({max(place.size // FEW, _NEAR), _NEAR}, reverse=True):
        order = np.argsort(np.abs(place - point), kind="stable")[: 2 * near]
        nearest = np.unique(place[order])
        gaps = 0.5 * (nearest[1:] + nearest[:-1])
        tried = np.append(point, gaps[:: max(gaps.size // (2 * _NEAR), 1)])
        beyond = place[order] - tried[:, None]
        touches = beyond > 0.0
        borne = np.where(touches, model.at(np.where(touches, beyond, 0.0))[0], 0.0)
        point = float(tried[np.argmin(((force[order] - borne) ** 2).sum(axis=1))])
    return point
