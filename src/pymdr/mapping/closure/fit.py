"""The stiffness of points of a force curve, with their contact point and noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymdr.mapping.closure.polyline import (
    BLOCK,
    BLOCKS,
    ROUNDING,
    SEGMENTS,
    Polyline,
    fit_ramps,
    fit_segments,
    graded_nodes,
    missed_forces,
    polyline_through,
    slopes_rise,
    systematic_stretch,
    with_beginning,
)
from pymdr.problem.profiles.curves import noise_of
from pymdr.problem.profiles.forcecurve import FEWEST_POINTS
from pymdr.units import FloatArray

_MOST = 3000
"""Largest number of points that a fit uses without averaging."""
_QUIETEST = 0.05
"""Least noise of a part of a curve, over the median noise."""
_TOUCH_SEGMENTS, _TOUCHES = 6, 80


@dataclass(frozen=True, eq=False)
class Fit:
    """A stiffness through points in their own units."""

    line: Polyline
    points: FloatArray
    """Depths of the points in contact."""
    finer: Polyline
    """The fit with twice as many segments."""
    touch: float
    noise: float
    misfit: float
    estimated: bool
    """Whether the contact point was estimated from the points."""
    segments: int
    """Number of segments of a fit; 0 for interpolation."""
    missed: FloatArray
    """Misfit of the points beyond their noise."""
    off: tuple[float, float, float] | None
    """Ends of the interval with the largest systematic misfit, and its size over the noise."""

    @property
    def first(self) -> float:
        """Depth of the first point in contact."""
        return float(self.points[0])

    @property
    def deepest(self) -> float:
        """Depth of the last point."""
        return float(self.points[-1])


def fit_points(d: FloatArray, force: FloatArray, touch: float | None) -> Fit:
    """The stiffness of points, whose contact point is estimated unless it is given."""
    sigma = _noise(d, force)
    estimated = touch is None
    few = _grouped(d, force, sigma)
    if touch is None:
        touch = _contact_point(*few)
    x = d - touch
    inside = x > 0.0
    depth = np.append(0.0, x[inside])
    values = np.append(0.0, force[inside])
    quiet = bool(np.all(np.abs(force[~inside]) <= ROUNDING))
    met = quiet and slopes_rise(depth, values)
    if met:
        line, segments, off = polyline_through(*with_beginning(depth, values)), 0, None
        finer = line
        noise = misfit = 0.0
        missed = np.zeros(depth.size - 1)
    else:
        few = few[:, few[0] > touch] - np.array([[touch], [0.0], [0.0]])
        line, nodes = fit_segments(*few)
        segments = nodes.size - 1
        finer = fit_ramps(few[0], few[1], few[2], np.sort(np.append(nodes, 0.5 * (nodes[1:] + nodes[:-1]))))[
            0
        ]
        residual = force - line.at(x)[1]
        misfit = float(np.sqrt(np.mean(residual**2)))
        noise, off = float(np.median(sigma)), systematic_stretch(x, residual / sigma)
        missed, own = missed_forces(residual, sigma)[inside], line.at(x[inside])[1]
        # the misfit is relative to the points, which may be below the curve
        missed *= own / np.maximum(own - missed, np.maximum(0.5 * own, math.ulp(0.0)))
        if off is not None:
            # distinguish a misfit of the points from too few segments
            freest = fit_ramps(few[0], few[1], few[2], graded_nodes(few[0], SEGMENTS[-1]))[0]
            off = systematic_stretch(x, (force - freest.at(x)[1]) / sigma)
    return Fit(line, depth[1:], finer, touch, noise, misfit, estimated, segments, missed, off)


def every_other(d: FloatArray, force: FloatArray, first: int) -> tuple[FloatArray, FloatArray]:
    """Every other point, with the last."""
    rows = np.unique(np.append(np.arange(first, d.size, 2), d.size - 1))
    return d[rows], force[rows]


def _grouped(d: FloatArray, force: FloatArray, sigma: FloatArray) -> FloatArray:
    """Depths, forces and noises, averaged over neighbours to at most the number that a fit uses."""
    size = -(-d.size // _MOST)
    whole = d.size // size * size
    means = [values[d.size - whole :].reshape(-1, size).mean(axis=1) for values in (d, force, sigma)]
    means[2] /= math.sqrt(size)
    if size > 1:
        # the ends stay
        means = [np.append(means[i], values[-1]) for i, values in enumerate((d, force, sigma))]
    return np.array(means)


def _noise(d: FloatArray, force: FloatArray) -> FloatArray:
    """The noise of every force, from blocks of neighbours; 1 without noise."""
    if d.size < FEWEST_POINTS:
        return np.ones(d.size)
    blocks = min(max(d.size // BLOCK, 1), BLOCKS)
    if blocks == 1:
        return np.full(d.size, noise_of(d, force) or 1.0)
    parts = np.array_split(np.arange(d.size), blocks)
    sizes = np.array([noise_of(d[part], force[part]) for part in parts])
    usual = float(np.median(sizes))
    if usual == 0.0:
        return np.ones(d.size)
    centres = np.array([float(part.mean()) for part in parts])
    logarithm = np.log(np.maximum(sizes, _QUIETEST * usual))
    return np.asarray(np.exp(np.interp(np.arange(d.size), centres, logarithm)))


def _contact_point(d: FloatArray, force: FloatArray, sigma: FloatArray) -> float:
    """The contact point for which a rising stiffness with a few segments fits all points best."""
    from scipy.optimize import minimize_scalar

    def missed(touch: float) -> float:
        inside = d > touch
        if np.count_nonzero(inside) < _TOUCH_SEGMENTS:
            return math.inf
        x, y, s = d[inside] - touch, force[inside], sigma[inside]
        _, rest = fit_ramps(x, y, s, graded_nodes(x, _TOUCH_SEGMENTS))
        return float(rest + np.sum((force[~inside] / sigma[~inside]) ** 2))

    last = min(int(np.searchsorted(np.maximum.accumulate(force), 0.5)), d.size - _TOUCH_SEGMENTS - 1)
    if last < 1:
        return max(float(d[0]), 0.0)
    trial = d[np.unique(np.linspace(0, last, _TOUCHES).astype(int))]
    sizes = [missed(float(t)) for t in trial]
    i = int(np.argmin(sizes))
    low, high = trial[max(i - 1, 0)], trial[min(i + 1, trial.size - 1)]
    best = minimize_scalar(missed, bounds=(low, high), method="bounded", options={"xatol": 1e-9})
    touch = float(best.x if best.fun < sizes[i] else trial[i])
    # points without noise: no later than their slopes allow
    loaded = np.flatnonzero(np.abs(force) > ROUNDING)
    if loaded.size > 1 and loaded[0] and np.all(np.abs(force[: loaded[0]]) <= ROUNDING):
        one, two = loaded[:2]
        slope = (force[two] - force[one]) / (d[two] - d[one])
        if slope > 0.0:
            touch = max(min(touch, float(d[one] - force[one] / slope)), float(d[one - 1]))
    return touch
