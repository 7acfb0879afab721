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

import numpy as np

from pymdr.errors import ProblemError
from pymdr.mapping.closure.fit import Fit, every_other, fit_points
from pymdr.mapping.closure.polyline import OCTAVE, Polyline, stiffness_states
from pymdr.problem.profiles import ForceCurve
from pymdr.units import FloatArray, metres, newtons

_NO_CURVE = 0.05
"""Of the largest force: points that lie farther off any rising stiffness are no curve of an elastic contact."""
_NO_NOISE = 2.0
"""Noises by which points with noise may always lie off."""
_ROUGHEST = 1e-9
"""Least excess of the exponent of a curve over 1 by which an error of its bends is divided."""


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
        stiffness, force, energy = self.stiffness.at(depth)
        # errors are shares of what is true, of which no less than 1 - e was found
        true = 1.0 - np.minimum(step, 0.9)
        true_here = 1.0 - np.minimum(here, 0.9)
        gathered, held = (
            np.append(0.0, np.cumsum(weight * np.diff(before))) for weight in (step / true, 1.0 / true)
        )
        rest = (energy - before[j]) / true_here
        with np.errstate(divide="ignore", invalid="ignore"):
            exponent = np.maximum(stiffness * depth / force - here / true_here, 1.0)
            whole = (gathered[j] + here * rest) / (held[j] + rest)
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
    whole = fit_points(d / scales[0], force / scales[1], touch)
    if whole.misfit > max(_NO_CURVE, _NO_NOISE * whole.noise):
        raise ProblemError(
            f"ForceCurve: the points lie {newtons(whole.misfit * scales[1])} (root mean square) off any curve whose stiffness "
            "rises with the depth, as that of an elastic contact without adhesion does; give the approach alone, of an elastic "
            "contact, and its contact_point where that is not the depth 0"
        )
    halves = [fit_points(*every_other(d / scales[0], force / scales[1], first), touch) for first in (0, 1)]
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


def _errors(whole: Fit, halves: list[Fit]) -> tuple[FloatArray, FloatArray]:
    """Depths, and the relative errors of k, F, U and the rise of k there."""
    deepest = min(fit.deepest for fit in (whole, *halves))
    number = 1 + math.ceil(OCTAVE * math.log2(deepest / whole.first)) if deepest > whole.first else 1
    depth = deepest * 2.0 ** -(np.arange(number)[::-1] / OCTAVE)
    others = (whole.finer, *(fit.line for fit in halves))
    # curves differ most between the points, and where their stiffness bends
    inside = np.concatenate(
        [whole.points, 0.5 * (whole.points[1:] + whole.points[:-1]), *(o.depth for o in others)]
    )
    inside = inside[(inside >= depth[0]) & (inside <= deepest)]
    tried = np.concatenate([depth, inside])
    own = stiffness_states(whole.line, tried)
    apart = np.max([np.abs(stiffness_states(other, tried) - own) for other in others], axis=0)
    apart = np.maximum(apart, _scatter(whole, tried))
    with np.errstate(divide="ignore", invalid="ignore"):
        each = np.minimum(np.where(apart > 0.0, apart / own, 0.0), 1.0)
    found = np.zeros((4, number))
    np.maximum.at(found.T, np.clip(np.searchsorted(depth, tried), 0, number - 1), each.T)
    padded = np.pad(found, ((0, 0), (OCTAVE, OCTAVE)), mode="edge")
    spread = np.lib.stride_tricks.sliding_window_view(padded, 2 * OCTAVE + 1, axis=1).max(axis=2)
    depth[-1] = whole.deepest
    return depth, np.maximum(spread, 1e-15)


def _scatter(fit: Fit, depth: FloatArray) -> FloatArray:
    """By how much k, F, U and the rise of k err by the noise of the points of a factor of 2 of the depth, or by what misses them, shape (4, n)."""
    low, high = 0.5 * depth, np.minimum(2.0 * depth, fit.deepest)
    held = np.maximum(np.searchsorted(fit.points, high, "right") - np.searchsorted(fit.points, low), 1)
    j = np.clip(np.searchsorted(fit.points, depth), 1, fit.points.size - 1)
    missed = np.maximum(fit.missed[j - 1], fit.missed[j])
    force = np.maximum(fit.noise / np.sqrt(held), missed)
    stiffness = force * math.sqrt(12.0) / (high - low)
    return np.stack([stiffness, force, force * depth, stiffness])


def _notes(curve: ForceCurve, fit: Fit, scales: tuple[float, float]) -> tuple[str, ...]:
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
