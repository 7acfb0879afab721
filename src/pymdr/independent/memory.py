"""Axisymmetric viscoelastic contact by boundary elements on rings: no Abel map, no g(x), no springs.

The surface obeys u(r, t) = K e with K the displacement by a pressure for E* = 1, and
p(r, t) = int E*(t - s) de(r, s): every ring has its own spring and Maxwell branches. Within a step e is linear in time, for
which the branches are exact. A ring without pressure has a known e_0; with e = e_0 + x a step is Signorini's problem
x >= 0, K x >= d - (f + K e_0): an elastic contact with the residual gap of the history. Errors of forces are of second order
in the step and the ring width; two solutions, one with twice as many steps, are extrapolated. Branches that relax within a
step act as dashpots with the pressure of a punch, for which errors are of first order in the ring width.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pymdr.errors import ProblemError
from pymdr.independent.history import gap_of, solve_steps
from pymdr.independent.rings import (
    HALF_SPACE,
    Array,
    RingMesh,
    RingProblem,
    Rings,
    RingSolution,
    RingState,
    Surface,
    Zones,
    active_set,
    edge_fit,
    leading_inverses,
    product,
)
from pymdr.mapping.relaxation import Relaxation
from pymdr.problem.profiles import Profile, Sampled
from pymdr.units import FloatArray

_PARTS = 200
"""Steps of the coarser solution of a leg."""
_LEAST = 12
"""Fewest rings between two kinks of the gap."""
_EXTRA = 4
"""Rings outside the largest elastic contact."""
_FITTED = 8
"""Rings whose pressures determine the edge."""


class Strained(NamedTuple):
    """Viscoelastic state of the surface, and its pressure."""

    strain: Array
    """(n,) e of every ring."""
    branches: Array
    """(k, n) pressures of the Maxwell branches in Pa."""
    pressure: Array
    """(n,) in Pa."""
    depth: float
    """d in m."""
    zones: Zones
    """Contact intervals in m, between edges of rings."""
    response: float
    """dF/dd at E* = 1 in m."""


class RingMemory(NamedTuple):
    """State at the end of a leg."""

    mesh: RingMesh
    coarse: Strained
    fine: Strained
    largest_force: float
    """Largest force so far in N."""


class Bodies(NamedTuple):
    """A profile pressed on a surface."""

    profile: Profile
    """The gap f(r)."""
    surface: Surface = HALF_SPACE
    """What relaxes: E*(t) times its stiffness for E* = 1."""


class MemoryLeg(NamedTuple):
    """The rows of a leg, and its final state."""

    solutions: list[RingSolution | None]
    """None before the first contact."""
    change: FloatArray
    """Change by the extrapolation, relative to the largest force (or indentation if forces are prescribed)."""
    state: RingMemory | None


def follow_rings(
    bodies: Bodies,
    relaxation: Relaxation,
    time: FloatArray,
    target: FloatArray,
    by_force: bool,
    state: RingMemory | None,
    rings: Rings,
    *,
    parts: int = _PARTS,
) -> MemoryLeg:
    """
    Follow indentations or forces that are linear in time between the rows.

    Parameters
    ----------
    bodies : Bodies
        The profile, and the surface on which it is pressed.
    relaxation : Relaxation
        E*(t).
    time : ndarray, shape (m + 1,)
        Non-decreasing times in s at the start of the leg and at every row.
    target : ndarray, shape (m + 1,)
        Indentations in m or forces in N at these times, not below 0.
    state : RingMemory or None
        State to continue from; None before the first contact.
    rings : Rings
        Number of rings in the largest contact of the leg.
    parts : int
        Steps of the coarser of the two solutions, distributed over the rows.

    Notes
    -----
    Lee and Radok (1960), J. Appl. Mech. 27, 438, for the constitutive law of the surface.

    Examples
    --------
    >>> from pymdr.problem.profiles import Paraboloid
    >>> maxwell = Relaxation(0.0, np.array([4.0]), np.array([0.4]))
    >>> leg = follow_rings(
    ...     Bodies(Paraboloid(1.0)), maxwell, np.array([0.0, 0.9]), np.array([0.0, 0.36]), False, None, Rings(100)
    ... )
    >>> round(leg.solutions[0].force, 4)
    0.5487
    """
    if relaxation.viscosity > 0.0:
        raise ProblemError(
            "a parallel dashpot (KelvinVoigt) makes the pressure infinite at a moving edge, which rings cannot "
            "follow; use StandardSolid with a short relaxation time"
        )
    largest = max(float(target.max()) if by_force else 0.0, 0.0 if state is None else state.largest_force)
    radius = largest_radius(bodies, relaxation, time, target, by_force, largest)
    state = _extended(bodies, state, relaxation, radius, rings.n)
    if state is None:
        return MemoryLeg([None] * (target.size - 1), np.zeros(target.size - 1), None)
    corners, mesh = corners_of(bodies.profile), state.mesh
    coarse, fine = state.coarse, state.fine
    solutions: list[RingSolution | None] = []
    outputs = np.zeros((2, target.size - 1))
    for i, count in enumerate(step_counts(time, target, parts)):
        times, targets = time[i : i + 2], target[i : i + 2]
        coarse, fine = (
            _followed(relaxation, mesh, corners, start, times, targets, by_force, refinement * count)
            for start, refinement in ((coarse, 1), (fine, 2))
        )
        solved = solution_at(relaxation, mesh, corners, _limit(coarse, fine))
        solutions.append(replace(solved, surface=bodies.surface))
        outputs[:, i] = [s.depth if by_force else float(s.pressure @ mesh.area) for s in (coarse, fine)]
        largest = max(largest, float(fine.pressure @ mesh.area))
    change = np.abs(outputs[1] - outputs[0]) / 3.0 / (float(np.max(np.abs(outputs))) or 1.0)
    return MemoryLeg(solutions, change, RingMemory(mesh, coarse, fine, largest))


def largest_radius(
    bodies: Bodies,
    relaxation: Relaxation,
    time: FloatArray,
    target: FloatArray,
    by_force: bool,
    force: float,
) -> float:
    """Contact radius of an elastic body at the deepest row, or under the largest force with the final compliance."""
    modulus = 1.0 / float(relaxation.retardation(time[-1])) if by_force else 1.0
    most = force if by_force else float(target.max())
    profile, surface = bodies
    (solution,) = solve_steps(profile, modulus, np.array([most]), by_force, Rings(60), surface)
    return 0.0 if solution is None else solution.contact_radius


def _extended(
    bodies: Bodies, state: RingMemory | None, relaxation: Relaxation, radius: float, n: int
) -> RingMemory | None:
    """Add rings up to a radius; existing ones keep their state, new ones have no history."""
    before = None if state is None else state.mesh
    mesh = extended(bodies, before, radius, n)
    if mesh is before or mesh is None:
        return state
    if state is None:
        none = Strained(np.zeros(0), np.zeros((relaxation.moduli.size, 0)), np.zeros(0), 0.0, (), 0.0)
        state = RingMemory(mesh, none, none, 0.0)
    size = mesh.centres.size
    return RingMemory(mesh, padded(state.coarse, size), padded(state.fine, size), state.largest_force)


def extended(bodies: Bodies, mesh: RingMesh | None, radius: float, n: int) -> RingMesh | None:
    """A mesh with more rings, up to a radius in m and a few more; the same one if it reaches so far."""
    profile, surface = bodies
    border = 0.0 if mesh is None else float(mesh.edges[-1])
    end = min(radius * (1.0 + _EXTRA / n), profile.edge, profile.max_radius)
    if end <= border or (radius * (1.0 + 0.5 * _EXTRA / n) <= border):
        return mesh
    marks = [x for x in corners_of(profile) if border < x < end]
    edges, centres, panel = [np.array([border])], [np.zeros(0)], [np.zeros(0, dtype=np.intp)]
    first = 0
    if mesh is not None:
        edges, centres, panel = [mesh.edges], [mesh.centres], [mesh.panel]
        first = int(mesh.panel[-1]) + 1
    for number, (low, high) in enumerate(pairwise([border, *marks, end]), first):
        points = _panel(low, high, radius / n, low in marks, high in marks or high == profile.edge)
        edges.append(points[1::2])
        centres.append(points[::2])
        panel.append(np.full(points.size // 2, number))
    a, r = np.concatenate(edges), np.concatenate(centres)
    f = np.asarray(gap_of(profile)(r), dtype=float)
    matrix = surface.displacement(r, a)
    return RingMesh(
        a,
        np.ones(r.size, dtype=bool),
        r,
        np.where(np.isnan(f), np.inf, f),
        np.concatenate(panel),
        np.pi * np.diff(a) * (a[1:] + a[:-1]),
        matrix,
        leading_inverses(matrix),
    )


def corners_of(profile: Profile) -> tuple[float, ...]:
    """Radii at which the pressure may be singular."""
    inner = () if isinstance(profile, Sampled) else profile.breakpoints
    return (*inner, profile.edge) if math.isfinite(profile.edge) else tuple(inner)


def _panel(low: float, high: float, width: float, kink: bool, end: bool) -> Array:
    """Alternating centres and outer edges of rings, graded to kinks and to the end."""
    count = max(_LEAST if kink or end else 1, math.ceil((high - low) / width - 1e-9))
    s = 0.5 * np.pi * np.arange(1, 2 * count + 1) / (2 * count)
    if kink and end:
        fraction = np.sin(s) ** 2
    elif kink:
        fraction = 1.0 - np.cos(s)
    elif end:
        fraction = np.sin(s)
    else:
        fraction = s / s[-1]
    points = low + (high - low) * fraction
    points[-1] = high
    return points


def padded(known: Strained, size: int) -> Strained:
    """The same state with rings without history up to a number."""
    extra = size - known.strain.size
    return known._replace(
        strain=np.pad(known.strain, (0, extra)),
        branches=np.pad(known.branches, ((0, 0), (0, extra))),
        pressure=np.pad(known.pressure, (0, extra)),
    )


def step_counts(time: FloatArray, target: FloatArray, parts: int) -> list[int]:
    """Number of steps of every row, by its change of target and duration."""
    changes = [np.abs(np.diff(values)) for values in (time, target)]
    fraction = sum(values / (values.sum() or 1.0) for values in changes) / 2.0
    counts: list[int] = np.maximum(np.ceil(parts * np.asarray(fraction) - 1e-9), 1.0).astype(int).tolist()
    return counts


def _followed(
    relaxation: Relaxation,
    mesh: RingMesh,
    corners: tuple[float, ...],
    state: Strained,
    time: FloatArray,
    target: FloatArray,
    by_force: bool,
    count: int,
) -> Strained:
    """Follow one row in `count` steps."""
    duration = float(time[1] - time[0]) / count
    for value in np.linspace(target[0], target[1], count + 1)[1:].tolist():
        moduli, stiff, branches, free = step_of(relaxation, state, duration)
        gap = mesh.gap + product(mesh.matrix, free)
        if by_force and value <= 0.0:
            settled = RingState(mesh, np.zeros(free.size), touch(mesh, gap), 0.0, ())
        else:
            depth, force = (None, value / stiff) if by_force else (value, None)
            problem = RingProblem(np.zeros_like, depth, force, corners, free.size, 1.0)
            settled = active_set(problem, mesh._replace(gap=gap), state.zones)
        strain = free + settled.pressure
        branches = branches + moduli[:, None] * (strain - state.strain)
        state = Strained(
            strain, branches, stiff * settled.pressure, settled.depth, settled.zones, settled.stiffness
        )
    return state


def step_of(relaxation: Relaxation, state: Strained, duration: float) -> tuple[Array, float, Array, Array]:
    """
    The surface over a step in which the strain is linear.

    Mean moduli of the branches and their sum with that of equilibrium, by which the strain follows the pressure; the pressures of
    the branches, and the strain without pressure, at its end.
    """
    x = duration / relaxation.times
    moduli = relaxation.moduli * np.where(x > 0.0, -np.expm1(-x) / np.where(x > 0.0, x, 1.0), 1.0)
    stiff = relaxation.equilibrium + float(moduli.sum())
    branches = state.branches * np.exp(-x)[:, None]
    free = state.strain - (relaxation.equilibrium * state.strain + branches.sum(axis=0)) / stiff
    return moduli, stiff, branches, free


def touch(mesh: RingMesh, gap: Array) -> float:
    """The smallest gap at the rings and, by extrapolation, on the axis."""
    inner = gap[0] - (gap[1] - gap[0]) * mesh.centres[0] / (mesh.centres[1] - mesh.centres[0])
    return float(min(gap.min(), inner))


def _limit(coarse: Strained, fine: Strained) -> Strained:
    """Extrapolation to steps of zero length."""

    def limit(a: Array, b: Array) -> Array:
        return b + (b - a) / 3.0

    return fine._replace(
        strain=limit(coarse.strain, fine.strain),
        branches=limit(coarse.branches, fine.branches),
        pressure=limit(coarse.pressure, fine.pressure) if fine.zones else fine.pressure,
        depth=fine.depth + (fine.depth - coarse.depth) / 3.0,
    )


def solution_at(
    relaxation: Relaxation, mesh: RingMesh, corners: tuple[float, ...], state: Strained
) -> RingSolution:
    """The contact of a state, with its edges and energy."""
    force = float(state.pressure @ mesh.area)
    inside = np.zeros(mesh.centres.size, dtype=bool)
    for low, high in state.zones:
        inside |= (mesh.centres > low) & (mesh.centres < high)
    pressure = np.where(inside, np.maximum(state.pressure, 0.0), 0.0)
    zones = tuple(
        (low, high if high in corners else _edge(mesh, pressure, low, high)) for low, high in state.zones
    )
    settled = RingState(mesh, pressure, state.depth, state.response, state.zones)
    amplitudes = tuple(
        (
            max(edge_fit(settled, k, 0, sharp=True)[0], 0.0) if low in corners else 0.0,
            max(edge_fit(settled, k, 1, sharp=True)[0], 0.0) if high in corners else 0.0,
        )
        for k, (low, high) in enumerate(state.zones)
    )
    parts = [(relaxation.equilibrium, state.strain)]
    parts += [(modulus, h / modulus) for modulus, h in zip(relaxation.moduli, state.branches, strict=True)]
    energy = sum(modulus * float((mesh.area * e) @ product(mesh.matrix, e)) / 2.0 for modulus, e in parts)
    area = sum(math.pi * (b - a) * (b + a) for a, b in zones)
    return RingSolution(
        edges=mesh.edges,
        radii=mesh.centres,
        pressure=pressure,
        force=force,
        indentation=state.depth,
        stiffness=state.response * relaxation.glassy,
        energy=energy,
        mean_pressure=force / area if zones else 0.0,
        zones=zones,
        edge_amplitudes=amplitudes,
        contact_radius=zones[-1][1] if zones else 0.0,
        contact_area=area,
        is_disk=len(zones) == 1 and zones[0][0] == 0.0,
        modulus=relaxation.glassy,
        strain=state.strain,
    )


def _edge(mesh: RingMesh, pressure: Array, low: float, high: float) -> float:
    """Radius at which p^2, linear at a free edge, vanishes between the last rings of a contact."""
    own = np.flatnonzero((mesh.centres > low) & (mesh.centres < high))
    fitted = own[-_FITTED - 1 : -1]
    if fitted.size < 2:
        return high
    r, p = mesh.centres[fitted], pressure[fitted]
    slope, height = np.polyfit((r - high) / high, p * p, 1)
    last = mesh.edges[own[-1]], mesh.edges[min(own[-1] + 2, mesh.edges.size - 1)]
    return float(np.clip(high * (1.0 - height / slope), *last)) if slope < 0.0 else high
