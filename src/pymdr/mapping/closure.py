"""The stiffness of a contact from its force curve: what is left of a topography on the line.

On elastic half-spaces without adhesion contacts of any shape grow with the depth, so that k = dF/dd does not fall
(Barber 1974). A curve through data is therefore one whose k(d) is rising and piecewise linear. Points whose slopes rise
are met exactly, by two straight pieces of k between neighbours (Schumaker 1983); piecewise linear data, those of finitely
many springs, come back as steps of k. Noisy points are met in the sense of non-negative least squares.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.profiles import ForceCurve
from pymdr.problem.profiles.curves import noise_of
from pymdr.problem.profiles.forcecurve import FEWEST_POINTS
from pymdr.units import FloatArray, metres, newtons

_ROUNDING = 1e-13
"""Of the largest force: by how much rounding may bend a curve."""
_PIECES = (2, 3, 4, 6, 8, 11, 16, 23, 32, 45, 64, 91, 128)
_PARTS = 8
"""Straight parts of k in a piece."""
_PATIENCE = 3
"""Numbers of pieces that may be no better before the search ends."""
_MOST = 3000
"""Points of which a fit makes use one by one."""
_BLOCK, _BLOCKS = 24, 12
_QUIETEST = 0.05
"""Of the usual noise: the least that a stretch of a curve is believed to have."""
_BEGINNING = 60
"""Points on a power of the depth before the first point."""
_TOUCH_PIECES, _TOUCHES = 6, 80
_SYSTEMATIC = 5.0
"""Noises by which the mean of neighbouring points may lie off the curve."""
_NO_CURVE = 0.05
"""Of the largest force: points that lie farther off any rising stiffness are no curve of an elastic contact."""
_NO_NOISE = 2.0
"""Noises by which points with noise may always lie off."""
_ROUGHEST = 1e-9
"""Least excess of the exponent of a curve over 1 by which an error of its bends is divided."""
_OCTAVE = 4
"""Entries of the table of errors in a factor of 2 of the depth."""
_LAST = 0.05
"""Of a depth: what slip of a part of the contact feels."""


class Polyline(NamedTuple):
    """A rising k(d), straight between nodes; a step is two nodes at one depth."""

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


@dataclass(frozen=True, eq=False)
class Closure:
    """What a force curve says of a contact."""

    stiffness: Polyline
    contact_point: float
    """Depth of the data in m at which the bodies touch."""
    noise: float
    """Noise of the force in N; 0 where the slopes of the points rise."""
    misfit: float
    """Root mean square in N by which the points lie off the curve."""
    errors: tuple[FloatArray, FloatArray]
    """Depths in m, rising, and the relative errors at each of k, F, U and of the rise of k, shape (4, n)."""
    given: tuple[FloatArray, FloatArray] | None
    """Depths in m of the points and the relative errors of their forces; None if none were given."""
    notes: tuple[str, ...]
    """What was done to the data, in words."""

    @property
    def deepest(self) -> float:
        """The last depth in m from the contact point."""
        return float(self.errors[0][-1])

    @property
    def largest_force(self) -> float:
        """The force in N at the last depth, of the bodies whose curve it is."""
        return float(self.stiffness.at(np.array([self.deepest]))[1, 0])

    def error(self, depth: FloatArray) -> FloatArray:
        """Relative errors of k, F, U and the rise of k at depths in m, shape (4, n): what half of the points, and more pieces, give otherwise."""
        table, found = self.errors
        j = np.clip(np.searchsorted(table, depth), 0, table.size - 1)
        return np.where(depth > 0.0, found[:, j], 0.0)

    def given_error(self, depth: FloatArray) -> FloatArray:
        """
        Relative errors of k, F, U and the rise of k at depths in m that those of the points leave, shape (4, n); nan where not known.

        An error e of F that varies with the depth no faster than its first power, as d^m with |m| <= 1, leaves in k = dF/dd no more
        than e (1 + 1/n), n = k d / F, and in dk/dd no more than e (n + 1)/(n - 1). That of U is the mean over its parts.
        """
        if self.given is None:
            return np.zeros((4, depth.size))
        points, error = self.given
        j = np.searchsorted(points, depth)
        step = np.fmax(error, np.append(error[0], error[:-1]))  # of the two ends of a stretch
        step[np.isnan(error) | np.isnan(np.append(error[0], error[:-1]))] = math.nan
        here = np.append(step, error[-1])[j]
        before = np.append(0.0, self.stiffness.at(points)[2])
        gathered = np.append(0.0, np.cumsum(step * np.diff(before)))
        stiffness, force, energy = self.stiffness.at(depth)
        with np.errstate(divide="ignore", invalid="ignore"):
            exponent = np.maximum(stiffness * depth / force, 1.0)
            whole = (gathered[j] + here * (energy - before[j])) / energy
        bends = here * np.minimum((exponent + 1.0) / np.maximum(exponent - 1.0, _ROUGHEST), 1.0 / _ROUGHEST)
        found = np.stack([here * (1.0 + 1.0 / exponent), here, whole, bends])
        found = np.where(here > 0.0, found, np.where(here == 0.0, 0.0, found))
        return np.where((depth > 0.0) & (force > 0.0), found, 0.0)


@lru_cache(maxsize=64)
def closure_of(curve: ForceCurve) -> Closure:
    """
    The stiffness of a force curve, with its contact point, noise and errors.

    Parameters
    ----------
    curve : ForceCurve

    Returns
    -------
    Closure

    Raises
    ------
    ProblemError
        If no stiffness that rises with the depth is near the points.

    Notes
    -----
    The errors are those by which the curves through every other point, and that of twice as many pieces, differ from the curve,
    the scatter of the points, and by how much they lie off the curve beyond their noise, the largest of a factor of 2 of the depth on
    both sides; 1 where the data tell nothing.

    Examples
    --------
    >>> d = np.linspace(0, 1e-6, 101)
    >>> found = closure_of(ForceCurve(d, 1e4 * d**1.5, modulus="1 GPa"))
    >>> bool(abs(found.stiffness.at(np.array([0.5e-6]))[0, 0] / (1.5e4 * 0.5e-6**0.5) - 1) < 1e-3)
    True
    """
    d, force = curve.indentation, curve.force
    # lengths and forces near 1
    scales = float(np.max(np.abs(d))), curve.largest_force
    touch = None if curve.contact_point is None else curve.contact_point / scales[0]
    if touch is None and d[0] >= 0.0:
        touch = 0.0
    whole = _fit(d / scales[0], force / scales[1], touch)
    if whole.misfit > max(_NO_CURVE, _NO_NOISE * whole.noise):
        raise ProblemError(
            f"ForceCurve: the points lie {newtons(whole.misfit * scales[1])} (root mean square) off any curve whose stiffness "
            "rises with the depth, as that of an elastic contact without adhesion does; give the approach alone, of an elastic "
            "contact, and its contact_point where that is not the depth 0"
        )
    halves = [_fit(*_half(d / scales[0], force / scales[1], first), touch) for first in (0, 1)]
    depths, errors = _errors(whole, halves)
    line = Polyline(whole.line.depth * scales[0], whole.line.stiffness * (scales[1] / scales[0]))
    given = None
    if curve.error is not None:
        inside = d / scales[0] > whole.touch
        given = (d[inside] - whole.touch * scales[0], curve.error[inside])
    return Closure(
        line,
        whole.touch * scales[0],
        whole.noise * scales[1],
        whole.misfit * scales[1],
        (depths * scales[0], errors),
        given,
        _notes(curve, whole, scales),
    )


@dataclass(frozen=True, eq=False)
class _Fit:
    """A stiffness through points in their own units."""

    line: Polyline
    points: FloatArray
    """Depths of the points in contact."""
    finer: Polyline
    """That of twice as many pieces, where there are any."""
    touch: float
    noise: float
    misfit: float
    found: bool
    """Whether the contact point was found."""
    pieces: int
    """Pieces of a fit; 0 where the points are met."""
    missed: FloatArray
    """By how much the curve misses the points beyond their noise."""
    off: tuple[float, float, float] | None
    """Ends of the stretch whose points lie farthest off the curve beyond their noise, and by how many noises."""

    @property
    def first(self) -> float:
        """Depth of the first point in contact."""
        return float(self.points[0])

    @property
    def deepest(self) -> float:
        """Depth of the last point."""
        return float(self.points[-1])


def _fit(d: FloatArray, force: FloatArray, touch: float | None) -> _Fit:
    sigma = _noise(d, force)
    found = touch is None
    few = _grouped(d, force, sigma)
    if touch is None:
        touch = _contact_point(*few)
    x = d - touch
    inside = x > 0.0
    depth = np.append(0.0, x[inside])
    values = np.append(0.0, force[inside])
    quiet = bool(np.all(np.abs(force[~inside]) <= _ROUNDING))
    met = quiet and _slopes_rise(depth, values)
    if met:
        line, pieces, off = _through(*_begun(depth, values)), 0, None
        finer = line
        noise = misfit = 0.0
        missed = np.zeros(depth.size - 1)
    else:
        few = few[:, few[0] > touch] - np.array([[touch], [0.0], [0.0]])
        line, nodes = _least_squares(*few)
        pieces = nodes.size - 1
        finer = _ramps(few[0], few[1], few[2], np.sort(np.append(nodes, 0.5 * (nodes[1:] + nodes[:-1]))))[0]
        residual = force - line.at(x)[1]
        misfit = float(np.sqrt(np.mean(residual**2)))
        noise, off = float(np.median(sigma)), _systematic(x, residual / sigma)
        missed, own = _missed(residual, sigma)[inside], line.at(x[inside])[1]
        # the share is that of the points, which may lie below the curve
        missed *= own / np.maximum(own - missed, np.maximum(0.5 * own, math.ulp(0.0)))
        if off is not None:
            # is it the points, or too few pieces?
            freest = _ramps(few[0], few[1], few[2], _nodes(few[0], _PIECES[-1]))[0]
            off = _systematic(x, (force - freest.at(x)[1]) / sigma)
    return _Fit(line, depth[1:], finer, touch, noise, misfit, found, pieces, missed, off)


def _half(d: FloatArray, force: FloatArray, first: int) -> tuple[FloatArray, FloatArray]:
    """Every other point, with the last."""
    rows = np.unique(np.append(np.arange(first, d.size, 2), d.size - 1))
    return d[rows], force[rows]


def _grouped(d: FloatArray, force: FloatArray, sigma: FloatArray) -> FloatArray:
    """Depths, forces and noises, of so many neighbours together that no more are left than a fit can use."""
    size = -(-d.size // _MOST)
    whole = d.size // size * size
    means = [values[d.size - whole :].reshape(-1, size).mean(axis=1) for values in (d, force, sigma)]
    means[2] /= math.sqrt(size)
    if size > 1:
        # the ends stay
        means = [np.append(means[i], values[-1]) for i, values in enumerate((d, force, sigma))]
    return np.array(means)


def _noise(d: FloatArray, force: FloatArray) -> FloatArray:
    """The noise of every force, from stretches of neighbours; 1 where there is none."""
    if d.size < FEWEST_POINTS:
        return np.ones(d.size)
    blocks = min(max(d.size // _BLOCK, 1), _BLOCKS)
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
    """The depth from which on a stiffness that rises with a few pieces is nearest to all points."""
    from scipy.optimize import minimize_scalar

    def missed(touch: float) -> float:
        inside = d > touch
        if np.count_nonzero(inside) < _TOUCH_PIECES:
            return math.inf
        x, y, s = d[inside] - touch, force[inside], sigma[inside]
        _, rest = _ramps(x, y, s, _nodes(x, _TOUCH_PIECES))
        return float(rest + np.sum((force[~inside] / sigma[~inside]) ** 2))

    last = min(int(np.searchsorted(np.maximum.accumulate(force), 0.5)), d.size - _TOUCH_PIECES - 1)
    if last < 1:
        return max(float(d[0]), 0.0)
    trial = d[np.unique(np.linspace(0, last, _TOUCHES).astype(int))]
    sizes = [missed(float(t)) for t in trial]
    i = int(np.argmin(sizes))
    low, high = trial[max(i - 1, 0)], trial[min(i + 1, trial.size - 1)]
    best = minimize_scalar(missed, bounds=(low, high), method="bounded", options={"xatol": 1e-9})
    touch = float(best.x if best.fun < sizes[i] else trial[i])
    # points without noise: no later than their slopes allow
    begun = np.flatnonzero(np.abs(force) > _ROUNDING)
    if begun.size > 1 and begun[0] and np.all(np.abs(force[: begun[0]]) <= _ROUNDING):
        one, two = begun[:2]
        slope = (force[two] - force[one]) / (d[two] - d[one])
        if slope > 0.0:
            touch = max(min(touch, float(d[one] - force[one] / slope)), float(d[one - 1]))
    return touch


def _slopes_rise(depth: FloatArray, force: FloatArray) -> bool:
    """Whether the mean slopes between points rise, to rounding."""
    slopes = np.append(0.0, np.diff(force) / np.diff(depth))
    falls = np.maximum.accumulate(slopes)[1:] - slopes[1:]
    return bool(np.all(falls <= _ROUNDING / np.diff(depth)))


def _begun(depth: FloatArray, force: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points with others before the first, on the power of the depth that leads through the first two."""
    one, two = force[1:3]
    if not one > 0.0:
        return depth, force
    power = max(math.log(two / one) / math.log(depth[2] / depth[1]), 1.0)
    part = 2.0 ** -(np.arange(_BEGINNING, 0, -1) / _OCTAVE)
    depth = np.concatenate([[0.0], depth[1] * part, depth[1:]])
    return depth, np.concatenate([[0.0], one * part**power, force[1:]])


def _through(depth: FloatArray, force: FloatArray) -> Polyline:
    """
    A rising k whose force is that of points with rising slopes.

    At the points k is that of a local power of the depth, between the mean slopes on both sides; between two points it
    rises to the mean slope and then on, in two straight pieces that meet where that leaves the mean as it is (Schumaker
    1983).
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
        share = np.where(rise > 0.0, (k[1:] - slope) / rise, 0.5)
    share = np.where(share < 1e-9, 0.0, np.where(share > 1.0 - 1e-9, 1.0, share))
    meet = np.minimum(depth[:-1] + share * h, depth[1:])
    t = np.append(np.stack([depth[:-1], meet], axis=1).ravel(), depth[-1])
    return Polyline(t, np.append(np.stack([k[:-1], slope], axis=1).ravel(), k[-1]))


def _nodes(x: FloatArray, n: int) -> FloatArray:
    """Depths between which dk/dd is straight, closer toward the contact point, with a point at least between two of them."""
    rows = np.arange(n + 1) / n
    index = np.maximum(x.size * rows**2, np.arange(n + 1.0))
    return np.unique(np.interp(index, np.arange(x.size + 1), np.append(0.0, x)))


def _ramps(x: FloatArray, y: FloatArray, sigma: FloatArray, nodes: FloatArray) -> tuple[Polyline, float]:
    """
    The rising k whose force is nearest to points, and the squares that are left.

    dk/dd is straight between nodes and nowhere below 0, so that k is smooth; k may begin with a step.
    """
    from scipy.optimize import nnls

    columns = np.column_stack([x, _forces(x, nodes)]) / sigma[:, None]
    size = np.linalg.norm(columns, axis=0)
    size[size == 0.0] = 1.0
    target = y / sigma
    reduced = np.asarray(np.linalg.qr(np.column_stack([columns / size, target]), mode="r"))
    found = nnls(reduced[:, :-1], reduced[:, -1])[0] / size
    part = np.arange(_PARTS) / _PARTS
    h = np.diff(nodes)[:, None]
    begin, end = found[1:-1, None], found[2:, None]
    rise = np.append(0.0, np.cumsum(0.5 * h * (begin + end)))
    k = found[0] + rise[:-1, None] + h * part * (begin + 0.5 * (end - begin) * part)
    depth = np.append((nodes[:-1, None] + h * part).ravel(), nodes[-1])
    line = Polyline(
        np.append(0.0, depth),
        np.maximum.accumulate(np.concatenate([[0.0], k.ravel(), [found[0] + rise[-1]]])),
    )
    return line, float(np.sum((target - columns @ found) ** 2))


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


def _least_squares(x: FloatArray, y: FloatArray, sigma: FloatArray) -> tuple[Polyline, FloatArray]:
    """The rising k with as many pieces as the points ask for (Schwarz' criterion), where they ask for them; and its nodes."""

    def tried(nodes: FloatArray) -> tuple[float, Polyline, FloatArray]:
        line, rest = _ramps(x, y, sigma, nodes)
        return x.size * math.log(rest / x.size + 1e-30) + math.log(x.size) * nodes.size, line, nodes

    best, worse = tried(_nodes(x, 1)), 0
    for n in _PIECES:
        nodes = _nodes(x, n)
        if nodes.size > 1 + max(x.size // 2, 2) or worse == _PATIENCE:
            break
        found = tried(nodes)
        worse = 0 if found[0] < best[0] else worse + 1
        best = min(best, found, key=lambda one: one[0])
    current, worse = best, 0
    while worse < _PATIENCE:
        off = _systematic(x, (y - current[1].at(x)[1]) / sigma)
        if off is None:
            break
        nodes = current[2]
        beside = (nodes[1:] > off[0]) & (nodes[:-1] < off[1])
        current = tried(np.sort(np.append(nodes, 0.5 * (nodes[1:] + nodes[:-1])[beside])))
        worse = 0 if current[0] < best[0] else worse + 1
        best = min(best, current, key=lambda one: one[0])
    return best[1], best[2]


def _systematic(x: FloatArray, residual: FloatArray) -> tuple[float, float, float] | None:
    """The stretch whose points lie off the curve on one side, in noises of its mean."""
    width = max(x.size // 16, 4)
    if x.size < 2 * width:
        return None
    sums = np.append(0.0, np.cumsum(residual))
    mean = np.abs(sums[width:] - sums[:-width]) / math.sqrt(width)
    i = int(np.argmax(mean))
    return (float(x[i]), float(x[i + width - 1]), float(mean[i])) if mean[i] > _SYSTEMATIC else None


def _missed(residual: FloatArray, sigma: FloatArray) -> FloatArray:
    """
    By how much a curve lies off every point beyond its noise: the largest mean of 1, 2, 4 ... neighbours that noise does not explain.

    The noise is that of differences, which no smooth curve has: what is left of points without noise is all misfit.
    """
    missed = np.zeros(residual.size)
    # without noise at all every sigma is 1, and no point is farther off than that
    noise = np.where(sigma < 1.0, sigma, 0.0)
    # the noise of a few points is uncertain: the largest of two stretches beside a point counts
    noise = np.lib.stride_tricks.sliding_window_view(np.pad(noise, _BLOCK, mode="edge"), 2 * _BLOCK + 1).max(
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


def _told(line: Polyline, depth: FloatArray) -> FloatArray:
    """k, F and U at depths, and by how much k rises in the last part of them, shape (4, n)."""
    at = line.at(depth)
    return np.vstack([at, at[0] - line.at((1.0 - _LAST) * depth)[0]])


def _errors(whole: _Fit, halves: list[_Fit]) -> tuple[FloatArray, FloatArray]:
    """Depths, and the relative errors of k, F, U and the rise of k there."""
    deepest = min(fit.deepest for fit in (whole, *halves))
    number = 1 + math.ceil(_OCTAVE * math.log2(deepest / whole.first)) if deepest > whole.first else 1
    depth = deepest * 2.0 ** -(np.arange(number)[::-1] / _OCTAVE)
    others = (whole.finer, *(fit.line for fit in halves))
    # curves differ most between the points, and where their stiffness bends
    inside = np.concatenate(
        [whole.points, 0.5 * (whole.points[1:] + whole.points[:-1]), *(o.depth for o in others)]
    )
    inside = inside[(inside >= depth[0]) & (inside <= deepest)]
    tried = np.concatenate([depth, inside])
    own = _told(whole.line, tried)
    apart = np.max([np.abs(_told(other, tried) - own) for other in others], axis=0)
    apart = np.maximum(apart, _scatter(whole, tried))
    with np.errstate(divide="ignore", invalid="ignore"):
        each = np.minimum(np.where(apart > 0.0, apart / own, 0.0), 1.0)
    found = np.zeros((4, number))
    np.maximum.at(found.T, np.clip(np.searchsorted(depth, tried), 0, number - 1), each.T)
    padded = np.pad(found, ((0, 0), (_OCTAVE, _OCTAVE)), mode="edge")
    spread = np.lib.stride_tricks.sliding_window_view(padded, 2 * _OCTAVE + 1, axis=1).max(axis=2)
    depth[-1] = whole.deepest
    return depth, np.maximum(spread, 1e-15)


def _scatter(fit: _Fit, depth: FloatArray) -> FloatArray:
    """By how much k, F, U and the rise of k err by the noise of the points of a factor of 2 of the depth, or by what misses them, shape (4, n)."""
    low, high = 0.5 * depth, np.minimum(2.0 * depth, fit.deepest)
    held = np.maximum(np.searchsorted(fit.points, high, "right") - np.searchsorted(fit.points, low), 1)
    j = np.clip(np.searchsorted(fit.points, depth), 1, fit.points.size - 1)
    missed = np.maximum(fit.missed[j - 1], fit.missed[j])
    force = np.maximum(fit.noise / np.sqrt(held), missed)
    stiffness = force * math.sqrt(12.0) / (high - low)
    return np.stack([stiffness, force, force * depth, stiffness])


def _notes(curve: ForceCurve, fit: _Fit, scales: tuple[float, float]) -> tuple[str, ...]:
    length, force = scales
    n = curve.force.size
    if fit.pieces == 0:
        words = f"the line is that of a force curve through all of its {n} points, whose slopes rise"
    else:
        words = (
            f"the line is that of a force curve by non-negative least squares, whose stiffness rises in {fit.pieces} pieces; its "
            f"{n} points lie off it by {newtons(fit.misfit * force)} (root mean square), their noise is about "
            f"{newtons(fit.noise * force)}"
        )
    notes = [words]
    if fit.found:
        notes.append(
            f"the contact point was found at {metres(fit.touch * length)} of the data, from which indentations are counted"
        )
    elif fit.touch != 0.0:
        notes.append(f"indentations are counted from {metres(fit.touch * length)} of the data")
    if fit.off is not None:
        low, high, size = fit.off
        notes.append(
            f"between d = {metres(low * length)} and {metres(high * length)} the points lie off every rising stiffness by "
            f"{size:.2g} noises of their mean: adhesion, plasticity, tilting or drift"
        )
    return tuple(notes)
