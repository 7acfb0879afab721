"""Signorini's conditions on the rings of a mesh, and the search of the contact zones and their edges."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
import scipy

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.independent.rings.meshes import (
    RingMesh,
    RingProblem,
    RingState,
    adjacent_width,
    displacement_on,
    edge_fit,
    mesh_of,
    panels_of,
    runs_of,
    union_of,
)
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
        f"The contact zone of {active.size} rings did not converge at d = {metres(depth * problem.size)} (last: {int(active.sum())} rings in "
        f"contact, {count} on the wrong side). Use another number of rings."
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


def settle(problem: RingProblem) -> RingState:
    """Alternate the active set, on rings graded to the last zones, with refinement of the zone edges."""
    level = math.inf if problem.depth is None else problem.depth
    zones: Zones = ()
    refined: RingState | None = None
    near = max(0.02, 4 / problem.n)
    for attempt in range(16):
        spans = _spans(problem, level)
        if not spans and problem.depth is None:
            raise ProblemError(
                "gap has no finite value up to max_radius or edge, so the punch carries no force. Return finite heights."
            )
        if not spans:
            return RingState(mesh_of(problem, [(0.0, 1.0, 1)]), np.zeros(1), level, 0.0, ())
        state = active_set(problem, mesh_of(problem, panels_of(problem, spans, zones)), zones)
        if not state.zones:
            return state
        if refined and refined.pressure.min() >= 0 and _agree(problem, state.zones, refined.zones, near, 0.0):
            missed = _missed(problem, refined, spans) if attempt < 5 else ()
            if not missed:
                return refined
            zones, refined = tuple(sorted((*refined.zones, *missed))), None
            continue
        # Where a hole or a zone is about to vanish, rings may give either topology.
        simple = _simplify(problem, state.zones, min(20 / problem.n, 0.3)) if attempt > 4 else state.zones
        if refined and attempt > 4 and _agree(problem, simple, refined.zones, near, 0.0):
            return state
        refined = _refine(problem, simple) if _agree(problem, simple, zones, 0.2, 0.2) else None
        zones = refined.zones if refined else simple
        if problem.depth is None:
            level = state.depth + 0.1 * (state.depth - float(state.mesh.gap.min()))
    raise ConvergenceError(
        f"The edges of the contact zones did not converge; the last were {zones_text(problem, zones)} at d = "
        f"{metres(state.depth * problem.size)}. Give breakpoints at kinks and jumps of the gap, or more rings."
    )


def _spans(problem: RingProblem, level: float) -> list[tuple[float, float]]:
    """Intervals that can be in contact."""
    below = _below(problem, level)
    if not (below and problem.surface.bulges):
        return below
    x = np.concatenate(([0.0], np.geomspace(1e-12, 1.0, 2001)))
    return [(0.0, min(1.0, max(below[-1][1], bulge_radius(x, problem.gap(x), level))))]


def bulge_radius(r: Array, f: Array, level: float) -> float:
    """Upper bound of the contact radius of surfaces that bulge, from f at some radii.

    The mean of f over the contact is below d; a fifth is added.
    """
    mean = np.cumsum((f[1:] + f[:-1]) / 2 * np.diff(r**2)) / r[1:] ** 2
    below = np.flatnonzero(mean < level)
    return 1.2 * float(r[min(below[-1] + 2, r.size - 1)]) if below.size else 0.0


def _below(problem: RingProblem, level: float) -> list[tuple[float, float]]:
    """Intervals that contain all points with f < d, the only contact if u > 0 everywhere."""
    spans: list[tuple[float, float]] = []
    pending = [(0.0, 1.0)]
    for zoom in range(40):
        again: list[tuple[float, float]] = []
        for low, high in pending:
            x = np.linspace(low, high, 65 if zoom else 2001)
            f = problem.gap(x)
            with np.errstate(invalid="ignore"):
                steps = np.nan_to_num(np.abs(np.diff(f)), posinf=0.0)
            variation = np.maximum(np.append(0.0, steps), np.append(steps, 0.0))
            for i, j in runs_of(f - variation < level):
                wide = 4 * (j - i) >= x.size and bool(np.any(f[i:j] < level))
                (spans if wide else again).append((float(x[max(i - 1, 0)]), float(x[min(j, x.size - 1)])))
        pending = again
    return union_of(spans)


def _missed(problem: RingProblem, state: RingState, spans: Sequence[tuple[float, float]]) -> Zones:
    """Intervals outside the zones where the surface would penetrate the punch."""
    mesh, missed = state.mesh, []
    for low, high, _ in panels_of(problem, spans, state.zones):
        if not any(a <= low < b for a, b in state.zones):
            x = np.linspace(low, high, 129)
            u = displacement_on(problem, x, mesh.edges)[:, mesh.live] @ state.pressure
            over = state.depth - problem.gap(x) - u > (state.depth - mesh.gap.min()) / problem.n**3
            over[:2] = over[-2:] = False
            missed += [(float(x[i - 1]), float(x[j])) for i, j in runs_of(over)]
    return tuple(missed)


def _simplify(problem: RingProblem, zones: Zones, narrow: float) -> Zones:
    """Remove holes narrower than a fraction of the adjacent zones; powers of it at the axis and for zones."""
    least = narrow**3 * max(outer - inner for inner, outer in zones)
    simple: list[tuple[float, float]] = []
    for inner, outer in zones:
        low, high = simple[-1] if simple else (0.0, 0.0)
        most = narrow * min(outer - inner, high - low) if simple else narrow**2 * (outer - inner)
        if outer - inner < least and not {inner, outer} & set(problem.corners):
            continue
        if inner - high < most and not {inner, high} & set(problem.corners):
            inner, simple = low, simple[:-1]
        simple.append((inner, outer))
    return tuple(simple)


def _agree(problem: RingProblem, new: Zones, old: Zones, tolerance: float, at_corners: float) -> bool:
    """Whether two sets of zones are equal within a tolerance relative to their widths."""
    return len(new) == len(old) and all(
        abs(new[k][side] - x) <= width * (at_corners if x in problem.corners else tolerance)
        for k in range(len(old))
        for side, (x, width) in enumerate(zip(old[k], adjacent_width(old, k), strict=True))
    )


def _refine(problem: RingProblem, zones: Zones) -> RingState | None:
    """Move the free edges of the zones until p √s = K + C s + ... has K = 0 there, s the distance from the edge.

    A step of 2 K/C is Newton's method, for √(s + δ) = √s + δ/(2√s) + ..., the zero of p².
    """
    for _ in range(15):
        mesh = mesh_of(problem, panels_of(problem, (), zones))
        if not np.all(np.isfinite(mesh.gap)):
            return None
        state = RingState(mesh, *_balance(problem, mesh, np.ones(mesh.centres.size, dtype=np.bool_)), zones)
        noise = 1e-13 * float(np.max(np.abs(mesh.gap)) / (state.depth - mesh.gap.min()))
        moved, still, tolerance = [list(zone) for zone in zones], True, max(1e-9, noise)
        for k, side in itertools.product(range(len(zones)), (0, 1)):
            x, width = zones[k][side], adjacent_width(zones, k)[side]
            K, C = edge_fit(state, k, side) if x > 0 else (0.0, 1.0)
            if x == 0 or (x in problem.corners and K >= 0):
                continue
            step = math.copysign(
                min(2 * abs(K) / C, 0.2 * width) if C > 0 else 0.2 * width, K if side else -K
            )
            still &= abs(step) <= tolerance * width
            passed = [c for c in problem.corners if (c - x) * step > 0 and abs(c - x) <= abs(step)]
            moved[k][side] = min(passed, key=lambda c: abs(c - x), default=x + step)
        if still:
            return state
        zones = _simplify(problem, tuple((a, b) for a, b in moved), (2 / problem.n) ** 2)
    return None
