"""Rings graded to the edges of contact zones, contacts on them, and the pressure next to an edge."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pymdr.independent.rings.surfaces import HALF_SPACE, Array, Mask, Surface, Zones

_LEAST = 12  # rings of a panel: the fit at an edge needs nine


class RingProblem(NamedTuple):
    """A contact with lengths over `size`, the end of the rings, and pressures over E*; `corners` may be singular."""

    gap: Callable[[Array], Array]
    depth: float | None
    force: float | None
    corners: tuple[float, ...]
    n: int
    size: float
    surface: Surface = HALF_SPACE


class RingMesh(NamedTuple):
    """Contiguous rings; `live` ones may carry pressure, others fill the space between."""

    edges: Array
    live: Mask
    centres: Array
    gap: Array
    panel: NDArray[np.intp]
    area: Array
    matrix: Array
    inverses: tuple[Array, Array] | None = None
    """Inverse factors of the matrix for many contacts that start at the axis; see `leading_inverses`."""


class RingState(NamedTuple):
    """A contact on a mesh, in the units of its problem, whose E* is 1."""

    mesh: RingMesh
    pressure: Array
    depth: float
    stiffness: float
    zones: Zones


def panels_of(
    problem: RingProblem, spans: Sequence[tuple[float, float]], zones: Zones
) -> list[tuple[float, float, int]]:
    """Cut spans and zones at zone edges and corners, and distribute the rings over the panels."""
    marks = sorted({*problem.corners, *(x for zone in zones for x in zone)})
    segments = []
    for low, high in union_of([*spans, *zones]):
        cuts = [low, *(x for x in marks if low < x < high), high]
        segments += [(a, b, any(z[0] <= a and b <= z[1] for z in zones)) for a, b in itertools.pairwise(cuts)]
    panels = []
    for low, high, inside in segments:
        rings = problem.n if inside else problem.n // 4 if zones else max(problem.n, 100)
        weight = math.sqrt(high - low) / sum(math.sqrt(b - a) for a, b, other in segments if other == inside)
        panels.append((low, high, max(_LEAST, round(rings * weight))))
    return panels


def mesh_of(problem: RingProblem, panels: Sequence[tuple[float, float, int]]) -> RingMesh:
    """The rings of panels, graded to both ends of each, and their influence matrix."""
    edges, live, centres, panel = [panels[0][0]], [], [], []
    for k, (low, high, n) in enumerate(panels):
        if low > edges[-1]:
            edges.append(low)
            live.append(False)
        x = low + (high - low) * np.sin(np.pi / 4 * np.arange(2 * n) / n) ** 2
        edges += [*x[2::2], high]
        centres += [*x[1::2]]
        live += [True] * n
        panel += [k] * n
    a, r, own = np.array(edges), np.array(centres), np.array(live)
    area = np.pi * (np.diff(a) * (a[1:] + a[:-1]))[own]
    matrix = displacement_on(problem, r, a)[:, own]
    return RingMesh(a, own, r, problem.gap(r), np.array(panel), area, matrix)


def displacement_on(problem: RingProblem, r: Array, a: Array) -> Array:
    """Displacement by unit pressure on each ring, in the length unit of the problem."""
    return problem.surface.displacement(r * problem.size, a * problem.size) / problem.size


def runs_of(mask: Mask) -> list[tuple[int, int]]:
    """Start and stop of every run of True."""
    steps = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False])).astype(np.int8)))
    return [(int(i), int(j)) for i, j in steps.reshape(-1, 2)]


def union_of(intervals: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """The union of intervals."""
    union: list[tuple[float, float]] = []
    for low, high in sorted(intervals):
        if union and low <= union[-1][1]:
            low, high = union[-1][0], max(high, union.pop()[1])
        union.append((low, high))
    return union


def edge_fit(state: RingState, k: int, side: int, sharp: bool = False) -> tuple[float, float]:
    """K and C of p √s = K + C s + ..., s the distance into the contact from a zone edge."""
    mesh, end = state.mesh, state.zones[k][side]
    rings = np.flatnonzero(mesh.panel == mesh.panel[np.searchsorted(mesh.centres, end) - side])
    rings = rings[::-1] if side else rings
    s = np.abs(mesh.centres[rings] - end)
    near = int(np.searchsorted(s, adjacent_width(state.zones, k)[side] / 2))
    count = max(6, min(rings.size // 8, near)) + 3 * sharp
    s, y = s[:count], state.pressure[rings[:count]] * np.sqrt(s[:count])
    first = 3 * sharp
    # at a sharp edge only K needs the correction of the rings
    known = 1 / sharp_correction(s.size) if sharp else np.ones_like(s)
    powers = np.column_stack((known, *((s / s[-1]) ** k for k in (1, 2, 3))))
    fit = np.linalg.lstsq(powers[first:], y[first:])[0]
    return float(fit[0]), float(fit[1] / s[-1])


def adjacent_width(zones: Zones, k: int) -> tuple[float, float]:
    """Smaller of the widths of a zone and of the adjacent hole, for its inner and outer edge."""
    inner, outer = zones[k]
    before = zones[k - 1][1] if k else 0.0
    after = zones[k + 1][0] if k + 1 < len(zones) else math.inf
    return min(outer - inner, inner - before), min(outer - inner, after - outer)


def sharp_correction(n: int) -> Array:
    """Exact over computed pressure of n rings counted from a sharp edge; poor for the first three."""
    return np.asarray(1 + 1 / (12 * (np.arange(n) + 0.5) ** 2), dtype=np.float64)
