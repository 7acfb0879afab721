"""Numerical errors of contacts with adhesion, from the measured errors of the map: states, folds and jumps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pymdr.interpretation.accuracy import MOMENT, SLOPE, SQUARED, G, bounded
from pymdr.interpretation.branches import Equilibria as Adhesive
from pymdr.line.adhesion.equivalent_line import States
from pymdr.line.curves import Line
from pymdr.line.following import Jumps
from pymdr.units import FloatArray

_ROUNDED = 4.0 * float(np.finfo(float).eps)
_DIFFERENCE = 30.0
"""Ratio of the terms of an energy to their sum above which rounding counts."""
_NEAR = 1e-4
"""Relative distance from a fold at which its curvature is evaluated."""
_FEW_ROUNDINGS = 1e-14
"""Relative error of an energy that counts as rounding."""


def adhesive_errors(
    line: Line,
    equilibria: Adhesive,
    s: FloatArray,
    machine_stiffness: FloatArray,
    columns: Mapping[str, FloatArray],
    jumps: Jumps,
    machine: FloatArray | float,
    jumping: Adhesive | None = None,
) -> dict[str, FloatArray]:
    """
    Relative errors of a contact with adhesion, from those of g, g', m and s at its edges.

    Parameters
    ----------
    s : ndarray
        Parameters of the states in m.
    machine_stiffness : ndarray
        Stiffness k in N/m of the machine equivalent to the control: inf for an indentation, 0 for a force.
    columns : mapping of str to ndarray
        Energies in J of the rows.
    jumps : Jumps
        Jumps of the history.
    machine : ndarray or float
        Energy in J of the machine.
    jumping : JKR, MaugisDugdale or DMT, optional
        The curve of the jumps, if it is not that of the rows.

    Returns
    -------
    dict of str to ndarray
        For every quantity and field, over the rows; relative to the size of its terms: |F0| + |k w| for the force,
        |d0| + |w| for the depth, the sum of all energies for the work. Errors of non-negative quantities, such as the elastic
        energy and losses, are relative to the quantity and include the rounding of its terms.

    Notes
    -----
    At a given radius the error of d is e_g g and that of F is e_m F0, each plus e_g' times the term of a cohesion of finite
    range, because g' determines the end of its zone. With a prescribed D = d + F/k the error of the parameter is
    dD / (dD/ds). The elastic energy U0 + F0 w + k w^2/2 then changes by F dd + k' w^2/2 da, the potential of a jump by Y dD.
    """
    parts = _StateErrors.at(line, equilibria, s)
    states, a = parts.states, parts.states.contact_radius
    error, outer = parts.error, parts.outer
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rates = equilibria.slopes(s)
        control, steep = parts.under(machine_stiffness, rates)
        moved = np.where(control > 0.0, control / np.abs(steep), 0.0)
        depth, force = parts.misses(machine_stiffness, rates, moved)
        radius = moved / a
        depth, force = depth / (parts.smooth_depth + parts.opened), force / (parts.smooth_force + parts.pull)
        slope = error[:, SLOPE] + radius
        release = 0.5 * line.stiffness_rate(a) * parts.opened**2
        along = np.abs(states.normal_force * rates[0]) + release
        missed = parts.energy + np.nan_to_num((moved + 0.25 * _ROUNDED * a) * along, posinf=math.inf)
    errors = {
        "contact_radius": radius,
        "cohesive_radius": radius + outer,
        "normal_force": force,
        "indentation": depth,
        "travel": depth + force,
        "surface_energy": 2.0 * radius,
        "normal_stiffness": slope,
        "mean_pressure": force + 2.0 * radius,
        "edge_amplitude": radius,
        "pressure": slope,
        "normal_displacement": depth + error[:, G],
        "gap": slope + depth,
        "equivalent_profile": error[:, G],
        "spring_force": error[:, G] + depth,
    }
    touching = (a > 0.0) | (states.cohesive_radius > 0.0)
    losses = _loss_errors(line, jumping or equilibria, jumps, machine_stiffness)
    energies = _energies(columns, np.where(touching, missed, 0.0), losses, machine)
    errors["elastic_energy"] = energies.pop("elastic_energy")
    # dissipated energies are known after the bodies have separated
    later = bounded(energies, np.ones(a.shape, dtype=bool))
    errors = bounded(errors, touching) | later
    return errors if any(values.any() for values in errors.values()) else {}


@dataclass(frozen=True)
class _StateErrors:
    """States of an adhesive contact, and the errors of their terms at given radii."""

    states: States
    error: FloatArray
    """Relative errors of g, g', m and s at the edge of the contact."""
    outer: FloatArray
    """Relative error of g' at the end of the cohesive zone."""
    smooth_depth: FloatArray
    smooth_force: FloatArray
    opened: FloatArray
    """|w| in m."""
    pull: FloatArray
    """|k w| in N."""
    depth: FloatArray
    """Error of d in m."""
    force: FloatArray
    """Error of F in N."""
    energy: FloatArray
    """Error of U in J, including its rounding where that counts."""

    def under(
        self, machine_stiffness: FloatArray, rates: tuple[FloatArray, ...]
    ) -> tuple[FloatArray, FloatArray]:
        """Error of the control at a radius, and its rate from those of d and F."""
        by_force = machine_stiffness == 0.0
        soft = np.where(by_force, 1.0, machine_stiffness)
        control = np.where(by_force, self.force, self.depth + self.force / soft)
        return control, np.where(by_force, rates[1], rates[0] + rates[1] / soft)

    def misses(
        self, machine_stiffness: FloatArray, rates: tuple[FloatArray, ...], moved: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Errors of d in m and F in N for a given error of the parameter in m; 0 for a prescribed quantity."""
        depth = np.where(np.isinf(machine_stiffness), 0.0, self.depth + np.abs(rates[0]) * moved)
        return depth, np.where(machine_stiffness == 0.0, 0.0, self.force + np.abs(rates[1]) * moved)

    @classmethod
    def at(cls, line: Line, equilibria: Adhesive, s: FloatArray) -> _StateErrors:
        states = equilibria.states(s)
        a = states.contact_radius
        error = line.error(a)
        outer = np.maximum(error[:, SLOPE], line.error(states.cohesive_radius)[:, SLOPE])
        g, smooth = np.abs(line.depth(a)), np.abs(line.force(a))
        opened, pull = np.abs(line.depth(a) - states.indentation), np.abs(smooth - states.normal_force)
        ranged = outer if equilibria.ranged else 0.0
        stored, crossed = np.abs(line.energy(a)), opened * smooth
        elastic, surface = equilibria.energies(s)
        parts = stored + crossed + 0.5 * opened**2 * line.stiffness(a)
        with np.errstate(divide="ignore", invalid="ignore"):
            # 0 times an unknown relative error is 0
            missed, depth, force = (
                np.nan_to_num(each, nan=0.0, posinf=math.inf)
                for each in (
                    error[:, SQUARED] * stored + error[:, MOMENT] * crossed + ranged * parts,
                    error[:, G] * g + ranged * opened,
                    error[:, MOMENT] * smooth + ranged * pull,
                )
            )
            # without cancellation the error is a few roundings
            differs = parts > _DIFFERENCE * np.abs(elastic)
        missed = missed + np.where(differs, _ROUNDED * (parts + np.abs(surface)), 0.0)
        return cls(states, error, outer, g, smooth, opened, pull, depth, force, missed)


def fold_errors(
    line: Line, equilibria: Adhesive, s: float, machine_stiffness: float, *, folds: bool
) -> dict[str, float]:
    """
    Relative errors of the state at which contact is lost, or into which it jumps.

    Parameters
    ----------
    s : float
        Parameter of the state in m.
    machine_stiffness : float
        k in N/m: inf for an indentation, 0 for a force.
    folds : bool
        Whether the control D = d + F/k has an extreme there and is not prescribed.

    Returns
    -------
    dict of str to float
        Of contact_radius, indentation, normal_force and travel.

    Notes
    -----
    At dD/ds = 0 the error of the parameter is that of dD/ds over d^2D/ds^2; elsewhere that of D over dD/ds.
    """
    at, k = np.array([s]), np.array([machine_stiffness])
    parts = _StateErrors.at(line, equilibria, at)
    rates = equilibria.slopes(at)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        control, steep = parts.under(k, rates)
        moved = np.where(control > 0.0, control / np.abs(steep), 0.0)
        if folds:
            near = s * np.array([1.0 - _NEAR, 1.0 + _NEAR])
            by_depth, by_force = (np.diff(rate) / np.diff(near) for rate in equilibria.slopes(near))
            turn = np.abs(parts.under(k, (by_depth, by_force))[1])
            unsure = parts.error[:, SLOPE] + _ROUNDED
            rates_of_error = (
                unsure * np.abs(rate)
                for rate in (line.depth_rate(at), line.stiffness(at) * line.depth_rate(at))
            )
            moved = np.minimum(parts.under(k, tuple(rates_of_error))[1] / turn, moved)
        depth, force = parts.misses(np.full(1, math.nan) if folds else k, rates, moved)
        states = parts.states
        soft = np.where(k == 0.0, math.inf, k)
        errors = {
            "contact_radius": (moved, states.contact_radius),
            "indentation": (depth, states.indentation),
            "normal_force": (force, states.normal_force),
            "travel": (depth + force / soft, states.indentation + states.normal_force / soft),
        }
        relative = {name: part / np.abs(whole) for name, (part, whole) in errors.items()}
    return {name: min(float(np.nan_to_num(value[0], nan=0.0)), 1.0) for name, value in relative.items()}


def loss_error(line: Line, equilibria: Adhesive, jump: Jumps, machine_stiffness: float) -> float:
    """Relative error of the energy that one jump dissipates."""
    error = float(_loss_errors(line, equilibria, jump, np.array([machine_stiffness]))[0])
    loss = abs(float(jump.loss[0]))
    return min(error / loss, 1.0) if loss > 0.0 else float(error > 0.0)


def _loss_errors(line: Line, equilibria: Adhesive, jumps: Jumps, machine_stiffness: FloatArray) -> FloatArray:
    """Errors of the losses of rows in J; each loss is the difference of two potentials."""
    rows = machine_stiffness.size
    if jumps.step.size == 0:
        return np.zeros(rows)
    k = machine_stiffness[jumps.step]
    total = np.zeros(k.shape)
    for s in (jumps.before, jumps.after):
        bound = np.flatnonzero(np.isfinite(s))
        if bound.size == 0:
            continue
        parts = _StateErrors.at(line, equilibria, s[bound])
        d, force = np.abs(parts.states.indentation), np.abs(parts.states.normal_force)
        elastic, surface = (np.abs(x) for x in equilibria.energies(s[bound]))
        by_force = k[bound] == 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            soft = np.where(by_force, 1.0, k[bound])
            stored = np.where(by_force, force * d, 0.5 * force**2 / soft)
            turned = np.where(by_force, d * parts.force, force * (parts.depth + parts.force / soft))
        total[bound] += parts.energy + turned + _ROUNDED * (elastic + surface + stored)
    return np.bincount(jumps.step, weights=total, minlength=rows).astype(float)


def _energies(
    columns: Mapping[str, FloatArray],
    elastic_error: FloatArray,
    losses: FloatArray,
    machine: FloatArray | float,
) -> dict[str, FloatArray]:
    """Relative errors of energies from the errors in J of the elastic energy and of the losses of rows."""
    elastic, surface, dissipated = (
        np.abs(columns[name]) for name in ("elastic_energy", "surface_energy", "dissipated_energy")
    )
    cumulative = np.cumsum(losses)
    pairs = {
        "elastic_energy": (elastic_error, elastic),
        "jump_dissipation": (losses, np.abs(columns["jump_dissipation"])),
        "dissipated_energy": (cumulative, dissipated),
        "external_work": (elastic_error + cumulative, elastic + surface + dissipated + machine),
    }
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = {name: np.where(part > 0.0, part / whole, 0.0) for name, (part, whole) in pairs.items()}
    return {name: np.where(value > _FEW_ROUNDINGS, value, 0.0) for name, value in relative.items()}
