"""The stiffness of a contact from its force curve, which represents a topography on the line.

On elastic half-spaces without adhesion contacts of any shape grow with the depth, so that k = dF/dd never decreases
(Barber 1974). The curve through data therefore has a rising, piecewise linear k(d). Points with rising slopes are
interpolated, with two linear segments of k between neighbours (Schumaker 1983); piecewise linear data, as of finitely many
springs, give steps of k. Noisy points are fitted by non-negative least squares.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pymdr.errors import ProblemError
from pymdr.mapping.closure.polyline import (
    BEGINNING,
    LAST,
    OCTAVE,
    Fit,
    Polyline,
    PowerRises,
    every_other,
    fit_points,
    stiffness_states,
)
from pymdr.problem.profiles import ForceCurve
from pymdr.units import FloatArray, metres, newtons

_NO_CURVE = 0.05
"""Largest accepted misfit of a rising stiffness, over the largest force."""
_NO_NOISE = 2.0
"""Misfit that is always accepted, over the noise."""
_BELOW = 6
"""Octaves below the first noisy point in the table of errors."""
_ROUGHEST = 1e-9
"""Least excess of the exponent of a curve over 1 in the error of the rise of its stiffness."""


@dataclass(frozen=True, eq=False)
class Closure:
    """The properties of a contact that its force curve determines."""

    stiffness: Polyline
    contact_point: float
    """Depth of the data in m at which the bodies touch."""
    noise: float
    """Noise of the force in N; 0 where the slopes of the points rise."""
    misfit: float
    """Root mean square distance in N of the points from the curve."""
    errors: tuple[FloatArray, FloatArray]
    """
    Depths in m, rising, and at each the relative errors of k, F, U and of the rise of k, and the error of the rise in N/m, shape (5, n).
    """
    given: tuple[FloatArray, FloatArray] | None
    """Depths in m of the points and the relative errors of their forces; None without errors."""
    notes: tuple[str, ...]
    """Notes on the processing of the data."""

    @property
    def deepest(self) -> float:
        """The last depth in m from the contact point."""
        return float(self.errors[0][-1])

    @property
    def largest_force(self) -> float:
        """The force in N at the last depth, for the bodies of the curve."""
        return float(self.stiffness.at(np.array([self.deepest]))[1, 0])

    def error(self, depth: FloatArray) -> FloatArray:
        """Relative errors of k, F, U and the rise of k at depths in m, shape (4, n), from half of the points and more segments."""
        table, values = self.errors
        j = np.clip(np.searchsorted(table, depth), 0, table.size - 1)
        *relative, rise, distance = values[:, j]
        own = stiffness_states(self.stiffness, depth)[3]
        # where k is level its rise has no digits, which says nothing about the rise at other depths
        with np.errstate(divide="ignore", invalid="ignore"):
            rise = np.fmin(rise, np.where(distance > 0.0, distance / own, rise))
        return np.where(depth > 0.0, np.stack([*relative, rise]), 0.0)

    def given_error(self, depth: FloatArray) -> FloatArray:
        """
        Relative errors of k, F, U and the rise of k at depths in m from those of the points, shape (4, n); nan where unknown.

        If the error e of F varies with the depth no faster than d^m with |m| <= 1, that of k = dF/dd is at most e (1 + 1/n) with
        n = k d / F, and that of dk/dd at most e (n + 1)/(n - 1). The error of U is the mean over its parts.
        """
        if self.given is None:
            return np.zeros((4, depth.size))
        points, error = self.given
        j = np.searchsorted(points, depth)
        step = np.fmax(error, np.append(error[0], error[:-1]))  # of the two ends of a stretch
        step[np.isnan(error) | np.isnan(np.append(error[0], error[:-1]))] = math.nan
        here = np.append(step, error[-1])[j]
        before = np.append(0.0, self.stiffness.at(points)[2])
        stiffness, force, energy = self.stiffness.at(depth)
        # errors are relative to the true values, which are at most 1/(1 - e) times the given ones
        true = 1.0 - np.minimum(step, 0.9)
        true_here = 1.0 - np.minimum(here, 0.9)
        weighted, weights = (
            np.append(0.0, np.cumsum(weight * np.diff(before))) for weight in (step / true, 1.0 / true)
        )
        rest = (energy - before[j]) / true_here
        with np.errstate(divide="ignore", invalid="ignore"):
            exponent = np.maximum(stiffness * depth / force - here / true_here, 1.0)
            whole = (weighted[j] + here * rest) / (weights[j] + rest)
        rise_error = here * np.minimum(
            (exponent + 1.0) / np.maximum(exponent - 1.0, _ROUGHEST), 1.0 / _ROUGHEST
        )
        values = np.stack([here * (1.0 + 1.0 / exponent), here, whole, rise_error])
        values = np.where(here > 0.0, values, np.where(here == 0.0, 0.0, values))
        return np.where((depth > 0.0) & (force > 0.0), values, 0.0)


@lru_cache(maxsize=64)
def closure_of(curve: ForceCurve) -> Closure:
    """
    The stiffness of a force curve, with its contact point, noise and errors.

    Notes
    -----
    The errors are the largest of the differences to curves through every other point, of twice as many segments, or that rise by
    powers between the points, the scatter
    of the points, and their misfit beyond the noise, within a factor of 2 of the depth; below the first of noisy points, to a line and
    a power of the depth, below that of others to a power whose exponent goes on changing; 1 where the data determine nothing.

    Examples
    --------
    >>> d = np.linspace(0, 1e-6, 101)
    >>> result = closure_of(ForceCurve(d, 1e4 * d**1.5, modulus="1 GPa"))
    >>> bool(abs(result.stiffness.at(np.array([0.5e-6]))[0, 0] / (1.5e4 * 0.5e-6**0.5) - 1) < 1e-3)
    True
    """
    d, force = curve.indentation, curve.force
    # lengths and forces near 1
    scales = float(np.max(np.abs(d))), curve.largest_force
    touch = None if curve.contact_point is None else curve.contact_point / scales[0]
    if touch is None and d[0] >= 0.0:
        touch = 0.0
    whole = fit_points(d / scales[0], force / scales[1], touch)
    if whole.misfit > max(_NO_CURVE, _NO_NOISE * whole.noise):
        raise ProblemError(
            "the points of the force curve do not fit an elastic contact without adhesion, whose stiffness increases with the depth (misfit "
            f"{newtons(whole.misfit * scales[1])} root mean square); give only the approach of an elastic contact, and its "
            "contact_point unless it is at the depth 0"
        )
    halves = [fit_points(*every_other(d / scales[0], force / scales[1], first), touch) for first in (0, 1)]
    depths, errors = _errors(whole, halves)
    slope = scales[1] / scales[0]
    errors[4] *= slope
    line = Polyline(whole.line.depth * scales[0], whole.line.stiffness * slope)
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


def _errors(whole: Fit, halves: list[Fit]) -> tuple[FloatArray, FloatArray]:
    """Depths, and the errors there, as in `Closure`."""
    deepest = min(fit.deepest for fit in (whole, *halves))
    innermost = whole.first * 2.0 ** -(_BELOW if whole.segments else BEGINNING / OCTAVE)
    number = 1 + math.ceil(OCTAVE * math.log2(deepest / innermost)) if deepest > innermost else 1
    depth = deepest * 2.0 ** -(np.arange(number)[::-1] / OCTAVE)
    others: list[Polyline | PowerRises] = [whole.finer, *(fit.line for fit in halves)]
    if not whole.segments:
        others.append(PowerRises(whole.line))
    # curves differ most between the points, and at the kinks of their stiffness
    inside = np.concatenate(
        [whole.points, 0.5 * (whole.points[1:] + whole.points[:-1]), *(o.depth for o in others)]
    )
    inside = inside[(inside >= depth[0]) & (inside <= deepest)]
    tried = np.concatenate([depth, inside])
    own = stiffness_states(whole.line, tried)
    distance = np.max([np.abs(stiffness_states(other, tried) - own) for other in others], axis=0)
    distance = np.maximum(distance, _scatter(whole, tried))
    with np.errstate(divide="ignore", invalid="ignore"):
        each = np.minimum(np.where(distance > 0.0, distance / own, 0.0), 1.0)
    each = np.vstack([each, distance[3]])
    values = np.zeros((5, number))
    np.maximum.at(values.T, np.clip(np.searchsorted(depth, tried), 0, number - 1), each.T)
    padded = np.pad(values, ((0, 0), (OCTAVE, OCTAVE)), mode="edge")
    spread = np.lib.stride_tricks.sliding_window_view(padded, 2 * OCTAVE + 1, axis=1).max(axis=2)
    below = depth < whole.first
    if whole.segments:
        spread[:4] = np.maximum(spread[:4], _unmeasured(whole, depth))
    else:
        spread[:, below] = np.maximum(spread[:, below], spread[:, [np.count_nonzero(below)]])
    spread[4, below] = math.inf
    depth[-1] = whole.deepest
    return depth, np.maximum(spread, 1e-15)


def _unmeasured(fit: Fit, depth: FloatArray) -> FloatArray:
    """
    Relative errors of k, F, U and the rise of k from the depths below the first point, shape (4, n).

    There the curve is not measured: a line to the first point, and the power of the depth that continues the curve, are as good.
    """
    own = stiffness_states(fit.line, depth)
    stiffness, force, energy = fit.line.at(np.array([fit.first]))[:, 0]
    x = np.minimum(depth / fit.first, 1.0)
    errors = np.zeros_like(own)
    if not force > 0.0:  # the points show no contact yet
        return errors
    for power in (1.0, max(stiffness * fit.first / force, 1.0)):
        k = power * force / fit.first * x ** (power - 1.0)
        beginning = np.stack(
            [
                k,
                force * x**power,
                force * fit.first / (power + 1.0) * x ** (power + 1.0),
                k * (1.0 - (1.0 - LAST) ** (power - 1.0)),
            ]
        )
        distance = np.where(depth < fit.first, np.abs(beginning - own), 0.0)
        distance[2, depth >= fit.first] = abs(force * fit.first / (power + 1.0) - energy)
        with np.errstate(divide="ignore", invalid="ignore"):
            errors = np.maximum(errors, np.where(distance > 0.0, distance / own, 0.0))
    # an entry of the table is for the depths up to it
    errors[:, 1:] = np.maximum(errors[:, 1:], errors[:, :-1])
    return np.minimum(errors, 1.0)


def _scatter(fit: Fit, depth: FloatArray) -> FloatArray:
    """Errors of k, F, U and the rise of k from noise and misfit within a factor of 2 of the depth, shape (4, n)."""
    low, high = 0.5 * depth, np.minimum(2.0 * depth, fit.deepest)
    count = np.maximum(np.searchsorted(fit.points, high, "right") - np.searchsorted(fit.points, low), 1)
    j = np.clip(np.searchsorted(fit.points, depth), 1, fit.points.size - 1)
    missed = np.maximum(fit.missed[j - 1], fit.missed[j])
    force = np.maximum(fit.noise / np.sqrt(count), missed)
    stiffness = force * math.sqrt(12.0) / (high - low)
    return np.stack([stiffness, force, force * depth, stiffness])


def _notes(curve: ForceCurve, fit: Fit, scales: tuple[float, float]) -> tuple[str, ...]:
    length, force = scales
    n = curve.force.size
    if fit.segments == 0:
        first = f"the line is from a force curve through all of its {n} points, whose slope increases with the depth"
    else:
        first = (
            f"the line is from a force curve by non-negative least squares, with a stiffness that increases in {fit.segments} segments; misfit "
            f"of its {n} points: {newtons(fit.misfit * force)} (root mean square), noise about {newtons(fit.noise * force)}"
        )
    notes = [first]
    if fit.estimated:
        notes.append(
            f"indentations are measured from the estimated contact point at {metres(fit.touch * length)} of the data"
        )
    elif fit.touch != 0.0:
        notes.append(f"indentations are measured from {metres(fit.touch * length)} of the data")
    if fit.off is not None:
        low, high, size = fit.off
        notes.append(
            f"between d = {metres(low * length)} and {metres(high * length)} the mean of the points deviates from every curve of "
            f"increasing stiffness by {size:.2g} times its noise (adhesion, plasticity, tilt or drift)"
        )
    return tuple(notes)
