"""A stiffness that rises with the depth, linear between nodes, through or near points of a force curve with contact point and noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymdr.problem.profiles.curves import noise_of
from pymdr.problem.profiles.forcecurve import FEWEST_POINTS
from pymdr.units import FloatArray

ROUNDING = 1e-13
"""Rounding of a curve, over the largest force."""
SEGMENTS = (2, 3, 4, 6, 8, 11, 16, 23, 32, 45, 64, 91, 128)
_PARTS = 8
"""Linear parts of k in a segment."""
_PATIENCE = 3
"""Number of trials without improvement before the search ends."""
BLOCK, BLOCKS = 24, 12
BEGINNING = 60
"""Number of points on a power of the depth before the first point."""
_SYSTEMATIC = 5.0
"""Largest accepted misfit of a mean of neighbouring points, over its noise."""
OCTAVE = 4
"""Entries of the table of errors in a factor of 2 of the depth."""
_STEEPEST = 1e-3
"""Least distance of a mean of k from its ends, over its rise, that a power of the depth has."""
LAST = 0.05
"""Relative step of the depth for the rise of the stiffness."""


class Polyline(NamedTuple):
    """A rising k(d), linear between nodes; a step is two nodes at one depth."""

    depth: FloatArray
    """In m from the contact point, not falling, from 0 on."""
    stiffness: FloatArray
    """In N/m, not falling, from 0 on."""

    def at(self, d: FloatArray) -> FloatArray:
        """k, F and U at depths, shape (3, n)."""
        t, k = self
        h = np.diff(t)
        with np.errstate(divide="ignore", invalid="ignore"):
            rate = np.where(h > 0.0, np.diff(k) / h, 0.0)
        force = np.append(0.0, np.cumsum(h * (k[:-1] + 0.5 * rate * h)))
        energy = np.append(0.0, np.cumsum(h * (force[:-1] + h * (0.5 * k[:-1] + rate * h / 6.0))))
        j = np.clip(np.searchsorted(t, d, side="right") - 1, 0, h.size - 1)
        s = np.maximum(d, 0.0) - t[j]
        return np.stack(
            [
                k[j] + rate[j] * s,
                force[j] + s * (k[j] + 0.5 * rate[j] * s),
                energy[j] + s * (force[j] + s * (0.5 * k[j] + rate[j] * s / 6.0)),
            ]
        )


class PowerRises(NamedTuple):
    """
    A k(d) that rises between points by one power of the depth, from below or from above, where `polyline_through` has two lines.

    Both have the same k at the points and the same mean between them, so that their difference is near the error between the points,
    which curves through fewer points miss beside a wide gap.
    """

    line: Polyline
    """From `polyline_through`; where its k steps this one does too."""

    @property
    def depth(self) -> FloatArray:
        """Depths of the points, rising, from 0 on."""
        return self.line.depth[::2]

    def at(self, d: FloatArray) -> FloatArray:
        """k, F and U at depths, shape (3, n)."""
        t, k = self.depth, self.line.stiffness[::2]
        h, rise = np.diff(t), np.diff(k)
        _, force, energy = self.line.at(t)
        with np.errstate(divide="ignore", invalid="ignore"):
            part = np.where(rise > 0.0, (np.diff(force) / h - k[:-1]) / rise, 0.0)
        steps = (part < _STEEPEST) | (part > 1.0 - _STEEPEST)
        part, late = np.where(steps, 0.5, part), part < 0.5
        power = np.where(late, 1.0 / part, 1.0 / (1.0 - part))

        def between(j: NDArray[np.intp], x: FloatArray) -> FloatArray:
            p, y = power[j], np.where(late[j], x, 1.0 - x)
            flat = np.array([x**0, x, 0.5 * x * x])
            risen = np.array([y ** (p - 1.0), y**p / p, y ** (p + 1.0) / (p * (p + 1.0))])
            ends = np.array([0.0 * x, 1.0 / p, (x - 1.0 / (p + 1.0)) / p])
            early = flat - [[1.0], [-1.0], [1.0]] * risen - ends
            own = k[j] * flat + rise[j] * np.where(late[j], risen, early)
            return np.array([own[0], force[j] + h[j] * own[1], h[j] * (force[j] * x + h[j] * own[2])])

        j = np.clip(np.searchsorted(t, d, side="right") - 1, 0, h.size - 1)
        states = between(j, (np.maximum(d, 0.0) - t[j]) / h[j])
        every = between(np.arange(h.size), np.ones(h.size))[2]
        states[2] += np.append(0.0, np.cumsum(np.where(steps, np.diff(energy), every)))[j]
        return np.where(steps[j], self.line.at(d), states)


def slopes_rise(depth: FloatArray, force: FloatArray) -> bool:
    """Whether the mean slopes between points rise, to rounding."""
    slopes = np.append(0.0, np.diff(force) / np.diff(depth))
    decreases = np.maximum.accumulate(slopes)[1:] - slopes[1:]
    return bool(np.all(decreases <= ROUNDING / np.diff(depth)))


def with_beginning(
    depth: FloatArray, force: FloatArray, *, changing: bool = False
) -> tuple[FloatArray, FloatArray]:
    """Points preceded by others on the power of the depth through the first two points, or on one that goes on changing."""
    if not force[1] > 0.0:
        return depth, force
    u, v = np.log(depth[1:4]), np.log(force[1:4])
    power = np.diff(v) / np.diff(u)
    part = np.arange(BEGINNING, -1, -1) * -math.log(2.0) / OCTAVE
    # twice the change between the first points: it may become faster toward the contact point
    rate = 4.0 * (power[1] - power[0]) / (u[2] - u[0]) if changing and power.size > 1 else 0.0
    local = np.maximum(power[0] + rate * (part + 0.5 * (u[0] - u[1])), 1.0)
    fall = np.append(np.cumsum((0.5 * np.diff(part) * (local[1:] + local[:-1]))[::-1])[::-1], 0.0)
    before = depth[1] * np.exp(part[:-1]), force[1] * np.exp(-fall[:-1])
    return (
        np.concatenate([[0.0], before[0], depth[1:]]),
        np.concatenate([[0.0], before[1], force[1:]]),
    )


def polyline_through(depth: FloatArray, force: FloatArray) -> Polyline:
    """
    A rising k whose force is that of points with rising slopes.

    At the points k follows a local power of the depth, between the mean slopes on both sides; between two points it has two
    linear segments that meet at the mean slope where they preserve the mean (Schumaker 1983).
    """
    h = np.diff(depth)
    slope = np.maximum.accumulate(np.diff(force) / h)
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v = np.log(depth[1:]), np.log(force[1:])
        du, dv = np.diff(u), np.diff(v)
        power = (du[1:] * dv[:-1] / du[:-1] + du[:-1] * dv[1:] / du[1:]) / (du[1:] + du[:-1])
        inner = force[2:-1] / depth[2:-1] * power
    inner = np.append(slope[0], np.where(np.isfinite(inner), inner, slope[1:-1]))
    inner = np.clip(inner, slope[:-1], slope[1:])
    last = 2.0 * slope[-1] - inner[-1]
    if power.size and np.isfinite(power[-1]):
        last = force[-1] / depth[-1] * (2.0 * dv[-1] / du[-1] - power[-1])
    k = np.concatenate([[0.0], inner, [max(last, slope[-1])]])
    rise = np.diff(k)
    with np.errstate(divide="ignore", invalid="ignore"):
        fraction = np.where(rise > 0.0, (k[1:] - slope) / rise, 0.5)
    fraction = np.where(fraction < 1e-9, 0.0, np.where(fraction > 1.0 - 1e-9, 1.0, fraction))
    meet = np.minimum(depth[:-1] + fraction * h, depth[1:])
    t = np.append(np.stack([depth[:-1], meet], axis=1).ravel(), depth[-1])
    return Polyline(t, np.append(np.stack([k[:-1], slope], axis=1).ravel(), k[-1]))


def graded_nodes(x: FloatArray, n: int) -> FloatArray:
    """Nodes of a linear dk/dd, denser toward the contact point, with at least one point between two of them."""
    rows = np.arange(n + 1) / n
    index = np.maximum(x.size * rows**2, np.arange(n + 1.0))
    return np.unique(np.interp(index, np.arange(x.size + 1), np.append(0.0, x)))


def fit_ramps(x: FloatArray, y: FloatArray, sigma: FloatArray, nodes: FloatArray) -> tuple[Polyline, float]:
    """
    The rising k whose force fits points best, and the sum of the squared residuals.

    dk/dd is linear between nodes and never negative, so that k is smooth; k may begin with a step.
    """
    from scipy.optimize import nnls

    columns = np.column_stack([x, _forces(x, nodes)]) / sigma[:, None]
    size = np.linalg.norm(columns, axis=0)
    size[size == 0.0] = 1.0
    target = y / sigma
    reduced = np.asarray(np.linalg.qr(np.column_stack([columns / size, target]), mode="r"))
    rates = nnls(reduced[:, :-1], reduced[:, -1])[0] / size
    part = np.arange(_PARTS) / _PARTS
    h = np.diff(nodes)[:, None]
    begin, end = rates[1:-1, None], rates[2:, None]
    rise = np.append(0.0, np.cumsum(0.5 * h * (begin + end)))
    k = rates[0] + rise[:-1, None] + h * part * (begin + 0.5 * (end - begin) * part)
    depth = np.append((nodes[:-1, None] + h * part).ravel(), nodes[-1])
    line = Polyline(
        np.append(0.0, depth),
        np.maximum.accumulate(np.concatenate([[0.0], k.ravel(), [rates[0] + rise[-1]]])),
    )
    return line, float(np.sum((target - columns @ rates) ** 2))


def _forces(x: FloatArray, nodes: FloatArray) -> FloatArray:
    """Forces at depths of stiffnesses whose rates are hats, 1 at one node and 0 at all others; one column per node."""
    h = np.diff(nodes)
    cubes = np.clip(x[:, None] - nodes, 0.0, None) ** 3 / 6.0
    ramps = np.diff(cubes, axis=1) / h
    hats = np.empty(cubes.shape)
    hats[:, 1:-1] = ramps[:, 1:] - ramps[:, :-1]
    hats[:, 0] = 0.5 * x**2 + ramps[:, 0]
    hats[:, -1] = -ramps[:, -1]
    return hats


def fit_segments(x: FloatArray, y: FloatArray, sigma: FloatArray) -> tuple[Polyline, FloatArray]:
    """The rising k with the number and places of segments by Schwarz' criterion, and its nodes."""

    def tried(nodes: FloatArray) -> tuple[float, Polyline, FloatArray]:
        line, rest = fit_ramps(x, y, sigma, nodes)
        return x.size * math.log(rest / x.size + 1e-30) + math.log(x.size) * nodes.size, line, nodes

    best, worse = tried(graded_nodes(x, 1)), 0
    for n in SEGMENTS:
        nodes = graded_nodes(x, n)
        if nodes.size > 1 + max(x.size // 2, 2) or worse == _PATIENCE:
            break
        trial = tried(nodes)
        worse = 0 if trial[0] < best[0] else worse + 1
        best = min(best, trial, key=lambda one: one[0])
    current, worse = best, 0
    while worse < _PATIENCE:
        off = systematic_stretch(x, (y - current[1].at(x)[1]) / sigma)
        if off is None:
            break
        nodes = current[2]
        adjacent = (nodes[1:] > off[0]) & (nodes[:-1] < off[1])
        current = tried(np.sort(np.append(nodes, 0.5 * (nodes[1:] + nodes[:-1])[adjacent])))
        worse = 0 if current[0] < best[0] else worse + 1
        best = min(best, current, key=lambda one: one[0])
    return best[1], best[2]


def systematic_stretch(x: FloatArray, residual: FloatArray) -> tuple[float, float, float] | None:
    """Ends of the interval with the largest mean residual, and its size over the noise of the mean; None if insignificant."""
    width = max(x.size // 16, 4)
    if x.size < 2 * width:
        return None
    sums = np.append(0.0, np.cumsum(residual))
    mean = np.abs(sums[width:] - sums[:-width]) / math.sqrt(width)
    i = int(np.argmax(mean))
    return (float(x[i]), float(x[i + width - 1]), float(mean[i])) if mean[i] > _SYSTEMATIC else None


def missed_forces(residual: FloatArray, sigma: FloatArray) -> FloatArray:
    """
    Misfit of every point beyond its noise: the largest mean of 1, 2, 4 ... neighbours that noise does not explain.

    The noise is estimated from differences, so that for points without noise all residuals are misfit.
    """
    missed = np.zeros(residual.size)
    # without noise every sigma is 1
    noise = np.where(sigma < 1.0, sigma, 0.0)
    # the noise of a few points is uncertain, so the largest of the blocks on both sides counts
    noise = np.lib.stride_tricks.sliding_window_view(np.pad(noise, BLOCK, mode="edge"), 2 * BLOCK + 1).max(
        axis=1
    )
    sums, squares = (np.append(0.0, np.cumsum(each)) for each in (residual, noise**2))
    width = 1
    while width <= max(residual.size // 4, 1):
        mean = np.abs(sums[width:] - sums[:-width]) / width
        explained = _SYSTEMATIC * np.sqrt(np.maximum(squares[width:] - squares[:-width], 0.0)) / width
        real = np.pad(np.where(mean > explained, mean, 0.0), width - 1)
        windows = np.lib.stride_tricks.sliding_window_view(real, width).max(axis=1)
        missed = np.maximum(missed, windows)
        width *= 2
    return missed


def stiffness_states(line: Polyline | PowerRises, depth: FloatArray) -> FloatArray:
    """k, F and U at depths, and the rise of k over the last 5 % of the depth, shape (4, n)."""
    at = line.at(depth)
    return np.vstack([at, at[0] - line.at((1.0 - LAST) * depth)[0]])


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
    """The fit with twice as many segments, or the interpolation with a beginning whose exponent goes on changing."""
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
        finer = polyline_through(*with_beginning(depth, values, changing=True))
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
