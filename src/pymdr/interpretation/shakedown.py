"""Bounds of the load up to which a body that is passed over again and again by a contact stops yielding."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.interpretation.cycles import DEVIATORS, smallest_ball
from pymdr.interpretation.interior import Interior
from pymdr.units import FloatArray

_ALONG = np.concatenate([[0.0], 0.1 * np.arange(1.0, 13.0), 1.2 * 1.25 ** np.arange(1.0, 6.0)])
"""Positions along the path over the loaded radius, on either side, of the first net."""
_ACROSS = np.concatenate([0.1 * np.arange(13.0), [1.4, 1.8, 2.5]])
_DOWN = np.concatenate([[0.0, 1e-3, 0.01, 0.03], 0.06 * np.arange(1.0, 15.0), [1.0, 1.4]])
_EXCHANGES, _GAP = 60, 1e-10
"""Most guesses of the best residual stress, and the relative gap of the bounds of its measure at which one is taken."""
_NEAR, _NEARER = 0.04, 0.3
"""Share of the largest value within which a point carries it, and its factor from one net to the next."""
_AGREED, _ROUNDS = 1e-6, 14
"""Relative change of a bound from one net to the next at which it is taken, and the most nets."""
_CLOSE = 3e-4
"""Tolerance of depths over the loaded radius."""


class Bound(NamedTuple):
    """The largest shear measure of a state that the best residual stress leaves, and where."""

    shear: float
    """Square root of the second invariant of the deviator in Pa, compared with the yield stress in shear."""
    y: float
    """Position across the path in m."""
    z: float
    """Depth in m."""


Evaluated: TypeAlias = tuple[FloatArray, FloatArray]
"""Squares of the shear measure at depths, and at positions along, across and down."""
Stresses: TypeAlias = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""Components in Pa, shape (6, along, across, down), at rows of positions."""
Measure: TypeAlias = Callable[[FloatArray], Evaluated]
"""Of stresses, shape (6, along, across, down)."""


def safe_bound(interior: Interior, step: int) -> Bound:
    """
    The shear measure with the best of some residual stresses: the body shakes down if it is at most the yield stress in shear.

    Parameters
    ----------
    interior : Interior
        A half-space that the contact passes along x.

    Notes
    -----
    By Melan's theorem a body shakes down if there is a residual stress in equilibrium, free of tractions, with which the stress exceeds
    yield nowhere. After many passes it does not depend on x. Here it is any xx(y, z) together with any yy(z), which are in equilibrium.
    """
    stresses, radius, along, marks = _relative(interior, step)
    across = np.unique(np.concatenate([_ACROSS, marks]))
    return _scaled(_largest(stresses, _by_two_residuals, along, across, _DOWN), radius)


def failing_bound(interior: Interior, step: int) -> Bound:
    """
    The shear measure that no residual stress lowers: above the yield stress in shear the body never stops yielding.

    Notes
    -----
    At every point of the plane y = 0 the residual stress is the best of all, which is the centre of the smallest ball around the
    deviators, whether in equilibrium or not; on the surface it is the best of those that leave the surface free.
    """
    stresses, radius, along, _ = _relative(interior, step)
    inside = _largest(stresses, _by_any_residual, along, np.zeros(1), _DOWN)
    surface = _largest(stresses, _by_two_residuals, along, np.zeros(1), np.zeros(1))
    return _scaled(max(inside, surface), radius)


def _relative(interior: Interior, step: int) -> tuple[Stresses, float, FloatArray, FloatArray]:
    """Stresses at lengths over the loaded radius; that radius, positions along the path, and radii where the stress may not be smooth."""
    radius = interior.load(step).radius
    marks = np.array(sorted({mark / radius for mark in interior.marks(step) if mark > 0.0}))
    half = np.unique(np.concatenate([_ALONG, marks]))

    def stresses(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
        points = np.meshgrid(radius * x, radius * y, radius * z, indexing="ij")
        return interior.spatial("stress", (points[0], points[1], points[2]), step)

    return stresses, radius, np.concatenate([-half[:0:-1], half]), marks


def _scaled(bound: Bound, radius: float) -> Bound:
    return bound._replace(y=bound.y * radius, z=bound.z * radius)


def _largest(stresses: Stresses, measure: Measure, x: FloatArray, y: FloatArray, depths: FloatArray) -> Bound:
    """The largest value over depths, on nets that are refined around the points that carry it."""
    from scipy.optimize import minimize_scalar

    def at(z: float) -> Evaluated:
        return measure(stresses(x, y, np.array([z])))

    values = measure(stresses(x, y, depths))[0]
    best = int(np.argmax(values))
    z, width = float(depths[best]), float(np.diff(depths[max(best - 1, 0) : best + 2]).max(initial=0.0))
    before, near = float(values[best]), _NEAR
    for _ in range(_ROUNDS):
        if width > _CLOSE and z > 0.0:
            span = max(z - width, 0.0), z + width
            minimum = minimize_scalar(
                lambda depth: -at(depth)[0][0], bounds=span, method="bounded", options={"xatol": _CLOSE}
            )
            z, width = float(minimum.x), 0.1 * width
        value, carried = at(z)
        top = float(value[0])
        active = np.asarray(carried[..., 0] >= (1.0 - near) * top)
        if not top > 0.0 or (abs(top - before) <= _AGREED * top and near < _AGREED):
            row = int(np.argmax(carried[..., 0].max(axis=0)))
            return Bound(math.sqrt(top), float(y[min(row, y.size - 1)]), z)
        before, near = top, near * _NEARER
        x, y = _refined(x, np.any(active, axis=1)), _refined(y, np.any(active, axis=0))
    raise ConvergenceError(
        f"the bound still changes by more than {_AGREED:g} after {_ROUNDS} refinements of the grid; round narrow features of the profile"
    )


def _refined(nodes: FloatArray, active: np.ndarray) -> FloatArray:
    """Nodes, and the middles of the intervals next to active ones."""
    if nodes.size < 2:
        return nodes
    adjacent = active[: nodes.size - 1] | active[1 : nodes.size]
    return np.unique(np.concatenate([nodes, 0.5 * (nodes[1:] + nodes[:-1])[adjacent]]))


def _by_any_residual(stress: FloatArray) -> Evaluated:
    """By any residual stress at a point: half of the square of the radius of the smallest ball around the deviators."""
    _, along, across, down = stress.shape
    deviators = np.einsum("dc,cxn->xdn", DEVIATORS, stress.reshape(6, along, -1))
    centre, radius = smallest_ball(deviators)
    square = 0.5 * np.sum((deviators - centre) ** 2, axis=1).reshape(along, across, down)
    return (0.5 * radius**2).reshape(across, down).max(axis=0), square


def _by_two_residuals(stress: FloatArray) -> Evaluated:
    """
    By residual stresses xx at every y and z, and yy at every z.

    With residuals u and v the measure is (u^2 - u v + v^2)/3 + b u + e v + c, convex, and least for the largest of its linear parts.
    """
    # the unloaded body far away bears the residual stress too; across the path only if yy is the same there
    wide = stress.shape[2] > 1
    s = np.pad(stress, ((0, 0), (0, 1), (0, int(wide)), (0, 0)))
    b, e = (2.0 * s[0] - s[1] - s[2]) / 3.0, (2.0 * s[1] - s[0] - s[2]) / 3.0
    c = ((s[0] - s[1]) ** 2 + (s[1] - s[2]) ** 2 + (s[2] - s[0]) ** 2) / 6.0 + np.sum(s[3:] ** 2, axis=0)

    def at_positions(v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """At every y and z the best residual xx, the largest value over x and its slope over the residual yy."""
        offset = e * v + c

        def largest(u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            top = np.argmax(b * u + offset, axis=0)[None]
            slope, rest, across = (np.take_along_axis(part, top, axis=0)[0] for part in (b, offset, e))
            return (u * u - u * v + v * v) / 3.0 + slope * u + rest, (2.0 * u - v) / 3.0 + slope, across

        u, value, across = _least(largest, 1.0 / 3.0, *(0.5 * v - 1.5 * end for end in (b.max(0), b.min(0))))
        return u, value, (2.0 * v - u) / 3.0 + across

    def at_depths(v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        _, value, slope = at_positions(v)
        top = np.argmax(value, axis=0)[None]
        value, slope = (np.take_along_axis(part, top, axis=0)[0] for part in (value, slope))
        return value, slope, slope

    most = 3.0 * np.max(np.abs(s), axis=(0, 1, 2))
    v, least, _ = _least(at_depths, 0.25, -most, most)
    u = at_positions(v)[0]
    return least, (u * u - u * v + v * v) / 3.0 + b * u + e * v + c


def _least(
    function: Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]],
    curvature: float,
    low: FloatArray,
    high: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Where functions of one variable are least, their values, and a further value, in the mean of both sides that carry the least one.

    The functions give value, slope and the further value. Less the curvature times the square of the variable they are convex, so each
    slope gives a parabola below them, and the least of the two nearest parabolas is the next guess.
    """
    sides = []
    for at in (low, high):
        value, slope, more = function(at)
        sides.append([slope - 2.0 * curvature * at, value - slope * at + curvature * at * at, more])
    best = at = low
    least = np.full(np.shape(low), math.inf)
    for _ in range(_EXCHANGES):
        (b0, c0, _), (b1, c1, _) = sides
        with np.errstate(divide="ignore", invalid="ignore"):
            at = np.where(b1 > b0, (c0 - c1) / (b1 - b0), low)
        # the crossing of two parabolas, unless one of them is least before
        at = np.clip(np.clip(at, -b1 / (2.0 * curvature), -b0 / (2.0 * curvature)), low, high)
        value, slope, more = function(at)
        model = curvature * at * at + np.maximum(b0 * at + c0, b1 * at + c1)
        best, least = np.where(value < least, at, best), np.minimum(value, least)
        if np.all(least - model <= _GAP * np.abs(least)):
            break
        fresh = slope - 2.0 * curvature * at, value - slope * at + curvature * at * at, more
        falling = slope < 0.0
        low, high = np.where(falling, at, low), np.where(falling, high, at)
        sides = [
            [np.where(falling == side, new, old) for new, old in zip(fresh, lines, strict=True)]
            for side, lines in zip((True, False), sides, strict=True)
        ]
    (b0, _, more0), (b1, _, more1) = sides
    left, right = np.minimum(2.0 * curvature * at + b0, 0.0), np.maximum(2.0 * curvature * at + b1, 0.0)
    fraction = np.divide(right, right - left, out=np.full(np.shape(left), 0.5), where=right > left)
    return best, least, fraction * more0 + (1.0 - fraction) * more1
