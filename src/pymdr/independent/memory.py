"""Axisymmetric contact of bodies with memory by boundary elements on rings: no Abel map, no g(x), no springs.

The surface of the half-space obeys u(r, t) = K e, K the displacement by a pressure on an elastic surface of E* = 1, and
p(r, t) = int E*(t - s) de(r, s): every ring has its own spring and Maxwell branches. Within a step e is straight in time, for
which the branches are exact. A ring without pressure has a known e_0, so that with e = e_0 + x the step is
Signorini's problem x >= 0, K x >= d - (f + K e_0), that of an elastic contact whose gap is what the past has left.
Forces err as the square of the step and of the width of the rings; of two solutions, one in twice as many steps, the
limit of none is taken. Where branches relax within a step they are dashpots, whose pressure is that of a punch: its force errs
as the width of the rings.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pymdr.errors import ProblemError
from pymdr.independent.history import gap_of, solve_steps
from pymdr.independent.rings import (
    Array,
    RingMesh,
    RingProblem,
    Rings,
    RingSolution,
    RingState,
    Zones,
    active_set,
    edge_fit,
    leading_inverses,
    product,
    ring_displacement,
)
from pymdr.mapping.relaxation import Relaxation
from pymdr.problem.profiles import Profile, Sampled
from pymdr.units import FloatArray

_PARTS = 200
"""Steps of the coarser solution in a leg, shared out among its rows."""
_LEAST = 12
"""Rings between two kinks of the gap."""
_ROOM = 4
"""Rings beyond the contact that an elastic body would have."""
_FITTED = 8
"""Rings whose pressures tell where the edge is."""


class Strained(NamedTuple):
    """What the surface remembers, and its pressure."""

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
    """All that a later leg needs."""

    mesh: RingMesh
    coarse: Strained
    fine: Strained
    largest_force: float
    """In N, so far."""


class MemoryLeg(NamedTuple):
    """The rows of a leg, and the state after it."""

    solutions: list[RingSolution | None]
    """None before anything was touched."""
    change: FloatArray
    """Relative to the largest force, or indentation where forces are prescribed: what the extrapolation changed."""
    state: RingMemory | None


def follow_rings(
    profile: Profile,
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
    Follow indentations, or forces, that are straight in time between the rows.

    Parameters
    ----------
    profile : Profile
        The gap f(r).
    relaxation : Relaxation
        E*(t).
    time : ndarray, shape (m + 1,)
        t in s, not falling, at the start of the leg and of every row.
    target : ndarray, shape (m + 1,)
        Indentations in m or forces in N, none below 0, likewise.
    by_force : bool
        Which of the two.
    state : RingMemory or None
        Where to go on; None for bodies that have not touched.
    rings : Rings
        How many rings in the largest contact of the leg.
    parts : int
        Steps of the coarser of the two solutions, shared out among the rows.

    Returns
    -------
    MemoryLeg

    Raises
    ------
    ProblemError
        If a dashpot stands beside the springs, or the contact has no end inside the profile.
    ConvergenceError
        If the contact of a step cannot be settled.

    Notes
    -----
    Lee and Radok (1960), J. Appl. Mech. 27, 438, for the law of the surface.

    Examples
    --------
    >>> from pymdr.problem.profiles import Paraboloid
    >>> maxwell = Relaxation(0.0, np.array([4.0]), np.array([0.4]))
    >>> leg = follow_rings(
    ...     Paraboloid(1.0), maxwell, np.array([0.0, 0.9]), np.array([0.0, 0.36]), False, None, Rings(100)
    ... )
    >>> round(leg.solutions[0].force, 4)
    0.5487
    """
    if relaxation.viscosity > 0.0:
        raise ProblemError(
            "rings: a dashpot beside the springs (KelvinVoigt) makes the pressure infinite at an edge that moves, which rings do "
            "not follow; take StandardSolid with a short time for it"
        )
    largest = max(float(target.max()) if by_force else 0.0, 0.0 if state is None else state.largest_force)
    radius = _largest_radius(profile, relaxation, time, target, by_force, largest)
    state = _extended(profile, state, relaxation, radius, rings.n)
    if state is None:
        return MemoryLeg([None] * (target.size - 1), np.zeros(target.size - 1), None)
    corners, mesh = _corners(profile), state.mesh
    coarse, fine = state.coarse, state.fine
    solutions: list[RingSolution | None] = []
    told = np.zeros((2, target.size - 1))
    for i, count in enumerate(_shares(time, target, parts)):
        at, to = time[i : i + 2], target[i : i + 2]
        coarse, fine = (
            _followed(relaxation, mesh, corners, begun, at, to, by_force, times * count)
            for begun, times in ((coarse, 1), (fine, 2))
        )
        solutions.append(_solution(relaxation, mesh, corners, _limit(coarse, fine)))
        told[:, i] = [one.depth if by_force else float(one.pressure @ mesh.area) for one in (coarse, fine)]
        largest = max(largest, float(fine.pressure @ mesh.area))
    change = np.abs(told[1] - told[0]) / 3.0 / (float(np.max(np.abs(told))) or 1.0)
    return MemoryLeg(solutions, change, RingMemory(mesh, coarse, fine, largest))


def _largest_radius(
    profile: Profile,
    relaxation: Relaxation,
    time: FloatArray,
    target: FloatArray,
    by_force: bool,
    force: float,
) -> float:
    """That of an elastic body at the deepest row, or under the largest force as soft as it has become in the end."""
    modulus = 1.0 / float(relaxation.retardation(time[-1])) if by_force else 1.0
    most = force if by_force else float(target.max())
    (found,) = solve_steps(profile, modulus, np.array([most]), by_force, Rings(60))
    return 0.0 if found is None else found.contact_radius


def _extended(
    profile: Profile, state: RingMemory | None, relaxation: Relaxation, radius: float, n: int
) -> RingMemory | None:
    """Rings out to a radius and a few beyond; what was there stays as it is, what is new remembers nothing."""
    border = 0.0 if state is None else float(state.mesh.edges[-1])
    end = min(radius * (1.0 + _ROOM / n), profile.edge, profile.reach)
    if end <= border or (radius * (1.0 + 0.5 * _ROOM / n) <= border):
        return state
    marks = [x for x in _corners(profile) if border < x < end]
    edges, centres, panel = [np.array([border])], [np.zeros(0)], [np.zeros(0, dtype=np.intp)]
    first = 0
    if state is not None:
        edges, centres, panel = [state.mesh.edges], [state.mesh.centres], [state.mesh.panel]
        first = int(state.mesh.panel[-1]) + 1
    for number, (low, high) in enumerate(pairwise([border, *marks, end]), first):
        points = _panel(low, high, radius / n, low in marks, high in marks or high == profile.edge)
        edges.append(points[1::2])
        centres.append(points[::2])
        panel.append(np.full(points.size // 2, number))
    a, r = np.concatenate(edges), np.concatenate(centres)
    f = np.asarray(gap_of(profile)(r), dtype=float)
    matrix = ring_displacement(r, a)
    mesh = RingMesh(
        a,
        np.ones(r.size, dtype=bool),
        r,
        np.where(np.isnan(f), np.inf, f),
        np.concatenate(panel),
        np.pi * np.diff(a) * (a[1:] + a[:-1]),
        matrix,
        leading_inverses(matrix),
    )
    if state is None:
        none = Strained(np.zeros(0), np.zeros((relaxation.moduli.size, 0)), np.zeros(0), 0.0, (), 0.0)
        state = RingMemory(mesh, none, none, 0.0)
    return RingMemory(mesh, _longer(state.coarse, r.size), _longer(state.fine, r.size), state.largest_force)


def _corners(profile: Profile) -> tuple[float, ...]:
    """Radii at which the pressure may be singular."""
    inner = () if isinstance(profile, Sampled) else profile.breakpoints
    return (*inner, profile.edge) if math.isfinite(profile.edge) else tuple(inner)


def _panel(low: float, high: float, width: float, kink: bool, end: bool) -> Array:
    """Centres and outer edges of rings between two kinks in turn, finer at those that are."""
    count = max(_LEAST if kink or end else 1, math.ceil((high - low) / width - 1e-9))
    s = 0.5 * np.pi * np.arange(1, 2 * count + 1) / (2 * count)
    if kink and end:
        share = np.sin(s) ** 2
    elif kink:
        share = 1.0 - np.cos(s)
    elif end:
        share = np.sin(s)
    else:
        share = s / s[-1]
    points = low + (high - low) * share
    points[-1] = high
    return points


def _longer(known: Strained, size: int) -> Strained:
    more = size - known.strain.size
    return known._replace(
        strain=np.pad(known.strain, (0, more)),
        branches=np.pad(known.branches, ((0, 0), (0, more))),
        pressure=np.pad(known.pressure, (0, more)),
    )


def _shares(time: FloatArray, target: FloatArray, parts: int) -> list[int]:
    """Steps from row to row, by what they move and how long they last."""
    shares = [np.abs(np.diff(values)) for values in (time, target)]
    share = sum(values / (values.sum() or 1.0) for values in shares) / 2.0
    counts: list[int] = np.maximum(np.ceil(parts * np.asarray(share) - 1e-9), 1.0).astype(int).tolist()
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
    """One row, in a number of steps."""
    wait = float(time[1] - time[0]) / count
    for to in np.linspace(target[0], target[1], count + 1)[1:].tolist():
        state = _step(relaxation, mesh, corners, state, wait, to, by_force)
    return state


def _step(
    relaxation: Relaxation,
    mesh: RingMesh,
    corners: tuple[float, ...],
    state: Strained,
    wait: float,
    target: float,
    by_force: bool,
) -> Strained:
    x = wait / relaxation.times
    share = relaxation.moduli * np.where(x > 0.0, -np.expm1(-x) / np.where(x > 0.0, x, 1.0), 1.0)
    stiff = relaxation.equilibrium + float(share.sum())
    branches = state.branches * np.exp(-x)[:, None]
    free = state.strain - (relaxation.equilibrium * state.strain + branches.sum(axis=0)) / stiff
    gap = mesh.gap + product(mesh.matrix, free)
    if by_force and target <= 0.0:
        settled = RingState(mesh, np.zeros(free.size), _touch(mesh, gap), 0.0, ())
    else:
        depth, force = (None, target / stiff) if by_force else (target, None)
        problem = RingProblem(np.zeros_like, depth, force, corners, free.size, 1.0)
        settled = active_set(problem, mesh._replace(gap=gap), state.zones)
    strain = free + settled.pressure
    branches = branches + share[:, None] * (strain - state.strain)
    return Strained(
        strain, branches, stiff * settled.pressure, settled.depth, settled.zones, settled.stiffness
    )


def _touch(mesh: RingMesh, gap: Array) -> float:
    """The least gap, from the rings and from where their two innermost ones point to on the axis."""
    inner = gap[0] - (gap[1] - gap[0]) * mesh.centres[0] / (mesh.centres[1] - mesh.centres[0])
    return float(min(gap.min(), inner))


def _limit(coarse: Strained, fine: Strained) -> Strained:
    """Of steps without length."""

    def limit(a: Array, b: Array) -> Array:
        return b + (b - a) / 3.0

    return fine._replace(
        strain=limit(coarse.strain, fine.strain),
        branches=limit(coarse.branches, fine.branches),
        pressure=limit(coarse.pressure, fine.pressure) if fine.zones else fine.pressure,
        depth=fine.depth + (fine.depth - coarse.depth) / 3.0,
    )


def _solution(
    relaxation: Relaxation, mesh: RingMesh, corners: tuple[float, ...], state: Strained
) -> RingSolution:
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
    """Where p^2, which is straight at a free edge, vanishes between the last rings of a contact."""
    own = np.flatnonzero((mesh.centres > low) & (mesh.centres < high))
    fitted = own[-_FITTED - 1 : -1]
    if fitted.size < 2:
        return high
    r, p = mesh.centres[fitted], pressure[fitted]
    slope, height = np.polyfit((r - high) / high, p * p, 1)
    last = mesh.edges[own[-1]], mesh.edges[min(own[-1] + 2, mesh.edges.size - 1)]
    return float(np.clip(high * (1.0 - height / slope), *last)) if slope < 0.0 else high
