"""A lower bound of the force on layers, from trial pressures.

The true pressure p and a trial pressure t, both non-negative, do the same work on each other's displacements. If the
displacement by t is at most 1, the force is at least the work of t on the true displacements, which are at least d - f:

    F = int p dA >= int p u[t] dA = int t u[p] dA >= int t (d - f) dA

(Shield 1967; Barber 1974). On half-spaces t is the pressure of a flat punch. On a stiff layer that may be negative; then enough
of the pressure under a punch on half-spaces is added to make it non-negative, and the sum is divided by its largest displacement.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.line.layered.coupled import Added, Coupled
from pymdr.line.layered.equation import WIDEST
from pymdr.line.layered.line import LayeredLine
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.numerics.panels import as_place
from pymdr.problem.profiles import FlatPunch
from pymdr.units import FloatArray

_STEP = math.sqrt(2.0)
"""Ratio of neighbouring trial radii."""
_NARROW = 0.1
"""The smallest trial radius in thicknesses, below which layers are half-spaces of the top one."""
_OWN = 16
"""Largest number of contact radii that are tried without interpolation."""
_INSIDE = np.unique(np.concatenate([np.linspace(0.0, 1.0, 65)[:-1], 1.0 - 0.5 ** np.arange(0.0, 16.0, 0.5)]))
"""Radii at which a trial pressure is evaluated, over its radius."""
_OUTSIDE = 0.5 ** np.arange(-2.0, 14.0, 0.5)
"""Distances outside at which its displacement is evaluated, over the radius and over the thickness."""
_ROUNDS, _FINER = 3, 17
"""Refinements of an extremum between the neighbours of the best radius, and points of each."""


@dataclass(frozen=True)
class _Trial:
    """A trial pressure: int t (d - f) dA = stiffness d - gap_force."""

    stiffness: float
    """In N/m."""
    gap_force: float
    """In N."""
    error: float
    """Relative."""


def lower_bound(
    line: LayeredLine, depth: FloatArray, contact_radius: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """
    Lower bounds of the normal force at indentations, for any contact.

    Parameters
    ----------
    depth : ndarray
        d in m.
    contact_radius : ndarray
        Radii in m of the disks that might be the contacts; NaN where none is known.

    Returns
    -------
    force : ndarray
        In N, not below 0.
    error : ndarray
        Relative, of its numerics.
    """
    known = np.unique(contact_radius[np.isfinite(contact_radius) & (contact_radius > 0.0)])
    bound, error = np.zeros(depth.shape), np.zeros(depth.shape)
    end, radii = min(line.table.end, WIDEST * line.thickness), known
    if not np.isfinite(contact_radius).all() and np.any(depth > 0.0):
        ends = np.min(depth[depth > 0.0]), np.max(depth)
        # a layer that keeps its volume bulges into contact, up to twice as wide
        radii = np.append(
            known, [0.5, 2.0] * np.array([line.equivalent.overlap_radius(float(d)) for d in ends])
        )
    if radii.size == 0:
        return bound, error
    top, least = min(float(np.max(radii)), end), min(float(np.min(radii)), _NARROW * line.thickness)
    count = 1 + math.ceil(math.log(max(4.0, top / least)) / math.log(_STEP))
    own = known[np.unique(np.linspace(0, known.size - 1, min(known.size, _OWN)).astype(int))]
    for b in {*(top * _STEP ** -np.arange(count)).tolist(), *own[own <= end].tolist()}:
        try:
            trial = _trial(line, b)
        except ConvergenceError:  # any other trial is as good a bound
            continue
        force = np.nan_to_num(trial.stiffness * depth - trial.gap_force)
        better = force > bound
        with np.errstate(divide="ignore", invalid="ignore"):
            parts = (np.abs(trial.stiffness * depth) + abs(trial.gap_force)) / force
        bound, error = np.where(better, force, bound), np.where(better, trial.error * parts, error)
    return bound, error


@lru_cache(maxsize=256)
def _trial(line: LayeredLine, b: float) -> _Trial:
    """The trial pressure on a disk of a radius in m."""
    place, h, profile = as_place(np.array([b])), line.thickness, line.equivalent
    solved = line.solved(b)
    depth, force, stiffness, error = line.smooth(b)
    flat = equivalent_profile(FlatPunch(b))
    punch = Coupled(flat, Added(line.kernel, h, b, solved.x, solved.weight * (1.0 + solved.coupled[1])))
    plain = Coupled(flat, Added(line.kernel, h, b, solved.x, solved.weight))

    def tension(r: FloatArray) -> FloatArray:
        return -(solved.punch_edge + np.sqrt((b - r) * (b + r)) * punch.pressure_integral(r, b))

    added = max(0.0, _largest(tension, b * _INSIDE))

    def displacement(r: FloatArray) -> FloatArray:
        """2/pi int_0^b q / sqrt(r^2 - x^2) dx, less what the layers add."""
        angle = np.arcsin(b / np.maximum(r, b))
        sunk = np.ones(r.shape)
        far = r > b
        sunk[far] = punch.sunk(r[far]) + 2.0 / math.pi * (
            punch.displacement_integral(r[far], b) + solved.punch_edge * angle[far]
        )
        return sunk + added * (plain.sunk(r) + 2.0 / math.pi * angle) if added > 0.0 else sunk

    outside = b + np.unique(np.concatenate([b * _OUTSIDE, h * _OUTSIDE]))
    deepest = max(1.0, _largest(displacement, np.concatenate([b * _INSIDE, [b], outside])))
    g, m = (float(f(place)[0]) for f in (profile.g, profile.moment))
    size = 2.0 * line.modulus * added
    return _Trial(
        (stiffness + size * b) / deepest, (stiffness * depth - force + size * (b * g - m)) / deepest, error
    )


def _largest(f: Callable[[FloatArray], FloatArray], r: FloatArray) -> float:
    """The largest value of a smooth function, searched between the neighbours of the best of some rising radii."""
    values = f(r)
    for _ in range(_ROUNDS):
        i = int(np.argmax(values))
        r = np.linspace(r[max(i - 1, 0)], r[min(i + 1, r.size - 1)], _FINER)
        values = f(r)
    return float(np.max(values))
