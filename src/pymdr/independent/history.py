"""A loading history by rings: states of all steps and their fields."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pymdr.errors import ProblemError, QuantityError
from pymdr.independent.rings import (
    HALF_SPACE,
    Rings,
    RingSolution,
    Surface,
    bulge_radius,
    displacement_at,
    pressure_at,
    solve_force,
    solve_indentation,
)
from pymdr.problem.profiles import Function, Profile, Sampled, Sum
from pymdr.units import FloatArray, metres

_DECADES = np.geomspace(1e-16, 1e7, 23 * 16 + 1)
"""Radii in m for the search of a bound of the contact if the profile has no end."""


@dataclass(frozen=True)
class RingHistory:
    """Solutions of all steps; None without contact."""

    profile: Profile
    solutions: tuple[RingSolution | None, ...]
    indentation: FloatArray

    @property
    def gap_function(self) -> Callable[[FloatArray], FloatArray]:
        """f(r)."""
        return gap_of(self.profile)

    def default_radii(self, step: int) -> FloatArray:
        """A grid from 0 to twice the contact radius, graded to every edge of the contact."""
        solution = self.solutions[step]
        if solution is None or not solution.zones:
            return np.linspace(0.0, 1.0 if solution is None else float(solution.edges[-1]), 11)
        a = solution.contact_radius
        marks = sorted({0.0, *(edge for zone in solution.zones for edge in zone)})
        graded = 0.5 * (1.0 - np.cos(np.linspace(0.0, math.pi, 101)))
        zones = [low + (high - low) * graded for low, high in pairwise(marks)]
        outside = a + a * np.linspace(0.0, 1.0, 61)[1:] ** 2
        return np.unique(np.concatenate([*zones, outside]))

    def marks(self, step: int) -> list[float]:
        """Radii between which the pressure is smooth."""
        radii: list[float] = self.default_radii(step).tolist()
        return radii

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Pressure, surface displacement or gap at radii in one step."""
        solution = self.solutions[step]
        d = float(self.indentation[step])
        if name == "pressure":
            return np.zeros(position.shape) if solution is None else pressure_at(solution, position)
        u = np.zeros(position.shape) if solution is None else displacement_at(solution, position)
        if name == "normal_displacement":
            return u
        if name == "gap":
            h = self.gap_function(position) - d + u
            inside = np.zeros(position.shape, dtype=bool)
            for low, high in () if solution is None else solution.zones:
                inside |= (position >= low) & (position <= high)
            return np.where(inside, 0.0, h)
        raise QuantityError(
            f"no field {name!r}: rings give pressure, normal_displacement and gap; leave solver=Rings() out for the fields of the line"
        )

    def edge_amplitude(self, step: int) -> float:
        """Amplitude of the pressure singularity at the outermost edge in Pa m^0.5."""
        solution = self.solutions[step]
        return solution.edge_amplitudes[-1][1] if solution is not None and solution.zones else 0.0


def gap_of(profile: Profile) -> Callable[[FloatArray], FloatArray]:
    """f(r) of a profile as a callable, integrated from the derivative if f is not given."""
    parts = profile.parts if isinstance(profile, Sum) else (profile,)
    if all(not isinstance(part, Function) or part.f is not None for part in parts):
        return profile.gap
    nodes, weights = np.polynomial.legendre.leggauss(48)
    s, weights = (nodes + 1.0) / 2.0, weights / 2.0
    marks = np.array([0.0, *profile.breakpoints, math.inf])

    def gap(r: FloatArray) -> FloatArray:
        total = np.zeros(r.shape)
        for low, high in pairwise(marks):
            width = np.clip(r, low, high) - low
            for t, w in zip(s, weights, strict=True):
                slope = profile.gap_slope(low + width * t)
                total = total + np.where(width > 0.0, w * width * slope, 0.0)
        return np.where(r > profile.edge, math.inf, total)

    return gap


def solve_steps(
    profile: Profile,
    modulus: float,
    targets: FloatArray,
    by_force: bool,
    rings: Rings,
    surface: Surface = HALF_SPACE,
) -> list[RingSolution | None]:
    """
    Solve every step of a leg by rings.

    Parameters
    ----------
    profile : Profile
        The gap f(r).
    modulus : float
        E* in Pa.
    targets : ndarray
        Indentations in m, or forces in N.
    surface : Surface
        Elastic surface, displaced in proportion to 1/E*.

    Returns
    -------
    list of RingSolution or None
        None without contact.
    """
    gap = gap_of(profile)
    marks = () if isinstance(profile, Sampled) else profile.breakpoints
    f = gap(_radii(profile))
    lowest = min(0.0, float(np.nanmin(f)))
    solutions: list[RingSolution | None] = []
    for target in targets.tolist():
        if (by_force and target <= 0.0) or (not by_force and target <= lowest):
            solutions.append(None)
            continue
        solver = solve_force if by_force else solve_indentation
        depth = target if not by_force else _max_depth(profile, modulus, target, rings, surface)
        max_radius = _max_radius(profile, gap, depth, surface)
        solutions.append(
            solver(
                gap,
                target,
                modulus,
                max_radius=max_radius,
                n=rings.n,
                edge=profile.edge,
                breakpoints=marks,
                surface=surface,
            )
        )
    return solutions


def _radii(profile: Profile) -> FloatArray:
    limit = min(profile.edge, profile.max_radius)
    if math.isfinite(limit):
        return limit * np.concatenate([np.geomspace(1e-9, 1e-2, 60), np.linspace(0.01, 1.0, 400)])
    return _DECADES


def _max_depth(
    profile: Profile, modulus: float, force: float, rings: Rings, surface: Surface
) -> float | None:
    """Upper bound of the depth under a force, by the softest equivalent half-space; None if not needed."""
    if not surface.bulges:
        return None
    (softer,) = solve_steps(
        profile, modulus / surface.softness, np.array([force]), True, Rings(min(rings.n, 60))
    )
    return None if softer is None else 1.5 * softer.indentation


def _max_radius(
    profile: Profile, gap: Callable[[FloatArray], FloatArray], depth: float | None, surface: Surface
) -> float:
    """Upper bound of the contact radius: contact lies where f < d, or slightly beyond."""
    limit = min(profile.edge, profile.max_radius)
    if math.isfinite(limit):
        return limit
    f = gap(_DECADES)
    known = np.flatnonzero(np.isfinite(f))
    if depth is None:
        return float(_DECADES[known[-1]])
    below = np.flatnonzero(f < depth)
    if below.size and below[-1] == _DECADES.size - 1:
        raise ProblemError(
            f"the profile never rises to {metres(depth)}, so the contact has no edge; add "
            "FlatPunch(radius) for a cylinder with this end"
        )
    bound = float(_DECADES[below[-1] + 1]) if below.size else float(_DECADES[0])
    return max(bound, bulge_radius(_DECADES[known], f[known], depth)) if surface.bulges else bound
