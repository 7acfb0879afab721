"""Signorini's conditions on the rings of a mesh."""

from __future__ import annotations

import numpy as np
import scipy

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.independent.rings.meshes import RingMesh, RingProblem, RingState, runs_of
from pymdr.independent.rings.surfaces import Array, Mask, Zones
from pymdr.units import metres


def leading_inverses(matrix: Array) -> tuple[Array, Array]:
    """Inverses of L and U of an influence matrix without pivots; leading blocks invert leading blocks."""
    factors = matrix.copy()
    for i in range(factors.shape[0] - 1):
        factors[i + 1 :, i] /= factors[i, i]
        factors[i + 1 :, i + 1 :] -= np.outer(factors[i + 1 :, i], factors[i, i + 1 :])
    identity = np.eye(factors.shape[0])
    lower = scipy.linalg.solve_triangular(factors, identity, lower=True, unit_diagonal=True)
    return np.ascontiguousarray(lower), np.ascontiguousarray(scipy.linalg.solve_triangular(factors, identity))


def product(matrix: Array, vector: Array) -> Array:
    """Matrix times vector in one thread, faster than several for the many small products of a history."""
    return np.asarray(np.einsum("ij,j->i", matrix, vector))


def active_set(problem: RingProblem, mesh: RingMesh, zones: Zones) -> RingState:
    """Signorini's conditions on the rings of a mesh, by block principal pivoting from the given zones."""
    active = np.isfinite(mesh.gap)
    if zones:
        active &= np.any([(mesh.centres > a) & (mesh.centres < b) for a, b in zones], axis=0)
    fewest, patience = active.size + 1, 10
    for _ in range(100 + 2 * active.size):
        if problem.depth is None and not active.any():
            active[np.argmin(mesh.gap)] = True
        pressure, depth, stiffness = _balance(problem, mesh, active)
        u = product(mesh.matrix, pressure)
        noise = 1e-12 * float(np.max(np.abs(u))) + 1e-15 * float(
            np.max(np.abs(mesh.gap[active]), initial=0.0)
        )
        wrong = np.where(active, pressure < 0, depth - mesh.gap - u > noise)
        count = int(wrong.sum())
        if count == 0:
            return RingState(mesh, pressure, depth, stiffness, zones_of(problem, mesh, active))
        fewest, patience = (count, 10) if count < fewest else (fewest, patience - 1)
        if patience < 0:  # Murty's single pivots, which cannot cycle
            wrong[: np.flatnonzero(wrong)[-1]] = False
        active = active ^ wrong
    raise ConvergenceError(
        f"The active set of {active.size} rings did not converge: in the last one {int(active.sum())} are in contact, {count} of all "
        f"wrongly assigned, at d = {metres(depth * problem.size)}. Try another number of rings."
    )


def _balance(problem: RingProblem, mesh: RingMesh, active: Mask) -> tuple[Array, float, float]:
    """Pressure, d and dF/dd with the given rings in contact: matrix p = d - f and, for a force, area p = F."""
    gap, area = mesh.gap[active], mesh.area[active]
    depth = float(gap.min()) if problem.depth is None else problem.depth
    displacements = depth - gap, np.ones_like(gap)
    if mesh.inverses is not None and active[: gap.size].all():
        lower, upper = (inverse[: gap.size, : gap.size] for inverse in mesh.inverses)
        p, unit = (product(upper, product(lower, u)) for u in displacements)
    else:
        p, unit = np.linalg.solve(mesh.matrix[np.ix_(active, active)], np.stack(displacements, axis=1)).T
    stiffness = float(area @ unit)
    if problem.force is not None:
        increment = (problem.force - float(area @ p)) / stiffness
        p, depth = p + increment * unit, depth + increment
    pressure = np.zeros(active.size)
    pressure[active] = p
    return pressure, depth, stiffness


def zones_of(problem: RingProblem, mesh: RingMesh, active: Mask) -> Zones:
    """The contact zones of the rings in contact; a zone at the end of the gap is refused."""
    contact, end = np.zeros(mesh.live.size + 2, dtype=np.bool_), np.zeros(mesh.live.size + 2, dtype=np.bool_)
    contact[1:-1][mesh.live], end[1:-1][mesh.live] = active, np.isinf(mesh.gap)
    end[-1] = True
    zones = []
    for i, j in runs_of(contact):
        inner, outer = float(mesh.edges[i - 1]), float(mesh.edges[j - 1])
        if (end[i - 1] and inner not in problem.corners) or (end[j] and outer not in problem.corners):
            raise ProblemError(
                f"The contact zone from {zones_text(problem, ((inner, outer),))} meets max_radius or the end of the "
                "gap. Give a larger max_radius, or edge or breakpoints where the punch ends."
            )
        zones.append((inner, outer))
    return tuple(zones)


def zones_text(problem: RingProblem, zones: Zones) -> str:
    """Zones with units, for messages."""
    return ", ".join(f"{metres(a * problem.size)} to {metres(b * problem.size)}" for a, b in zones)
