"""Solutions of the ring solver and their fields."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.independent.rings.meshes import RingProblem, RingState, edge_fit, sharp_correction
from pymdr.independent.rings.surfaces import HALF_SPACE, Array, Surface, Zones, valid_radii


@dataclass(frozen=True, eq=False)
class RingSolution:
    """Solution of the ring solver on m rings; those outside the contact carry no pressure.

    Attributes
    ----------
    edges : array (m + 1,), m
        Ring j lies between ``edges[j]`` and ``edges[j + 1]``.
    radii : array (m,), m
        Points at which u = d - f is imposed and `pressure` is given.
    pressure : array (m,), Pa
    force : float, N
    indentation : float, m
        Approach d, counted from f = 0.
    stiffness : float, N/m
        dF/dd, the response of the contact zones to a rigid displacement.
    energy : float, J
        Elastic energy (1/2) ∫ p u dA.
    mean_pressure : float, Pa
        Force over contact area; 0 without contact.
    zones : tuple of (inner, outer), m
        Contact intervals from the axis outwards; empty without contact.
    edge_amplitudes : tuple of (inner, outer), Pa m^(1/2)
        Limit of p √|r - edge| at the edges of each zone: positive at a sharp edge, negative under adhesion, 0 at a
        free edge.
    contact_radius : float, m
        Outermost zone edge; 0 without contact.
    contact_area : float, m²
    is_disk : bool
        Whether the contact is one full disk.
    modulus : float, Pa
        E*; for viscoelastic bodies the instantaneous one.
    strain : array (m,)
        Pressure that gives the same displacement for E* = 1: `pressure` over `modulus` for elastic bodies.
    surface : Surface
        Elastic surface.
    tension, cohesive_radius : float, Pa and m
        Tension on the disk of this radius, which `force` includes and `pressure` does not.
    """

    edges: Array
    radii: Array
    pressure: Array
    force: float
    indentation: float
    stiffness: float
    energy: float
    mean_pressure: float
    zones: Zones
    edge_amplitudes: Zones
    contact_radius: float
    contact_area: float
    is_disk: bool
    modulus: float
    strain: Array
    surface: Surface = HALF_SPACE
    tension: float = 0.0
    cohesive_radius: float = 0.0


def displacement_at(solution: RingSolution, r: ArrayLike) -> Array:
    """Surface displacement u(r) in m at radii `r` in m, of any shape, inside and outside the contact.

    Raises
    ------
    ProblemError
        If a radius is negative or not finite.

    Examples
    --------
    >>> from pymdr.independent.rings import solve_indentation
    >>> flat = solve_indentation(lambda r: 0 * r, 1e-6, 1e9, max_radius=1e-3, edge=1e-3)
    >>> f"{displacement_at(flat, 2e-3):.5e}"
    '3.33333e-07'
    """
    r = valid_radii(r)
    u = solution.surface.displacement(r.ravel(), solution.edges) @ solution.strain
    return np.asarray(u.reshape(r.shape), dtype=np.float64)


def pressure_at(solution: RingSolution, r: ArrayLike) -> Array:
    """Pressure p(r) in Pa at radii `r` in m, of any shape; 0 outside, inf at a sharp edge and -inf at an adhesive one.

    Between the edges b < a of a zone it is interpolated in θ = 2 arctan √((r - b)/(a - r)), in which
    it is smooth up to a free edge; at a sharp edge p √|r - edge| is interpolated.

    Raises
    ------
    ProblemError
        If a radius is negative or not finite.

    Examples
    --------
    >>> from pymdr.independent.rings import solve_indentation
    >>> hertz = solve_indentation(lambda r: r**2 / 2, 1.0, 1.0, max_radius=2.0)
    >>> [f"{p:.4f}" for p in pressure_at(hertz, [0.0, 0.6, 0.8, 1.5]) * np.pi / 2]
    ['1.0000', '0.8000', '0.6000', '0.0000']
    """
    from scipy.interpolate import Akima1DInterpolator

    def angle(x: Array) -> Array:
        return np.asarray(2 * np.arctan2(np.sqrt(x), np.sqrt(1 - x)), dtype=np.float64)

    r = valid_radii(r)
    pressure = np.zeros_like(r)
    for (inner, outer), amplitudes in zip(solution.zones, solution.edge_amplitudes, strict=True):
        width, axis = outer - inner, int(inner == 0)
        own, inside = (solution.radii > inner) & (solution.radii < outer), (r >= inner) & (r <= outer)
        known, x = (solution.radii[own] - inner) / width, (r[inside] - inner) / width
        value, weight = solution.pressure[own], np.ones_like(x)
        for side, sharp in enumerate(amplitudes):
            if sharp:
                value = value * np.sqrt(np.abs(known - side)) * sharp_correction(known.size)[:: 1 - 2 * side]
                weight = weight * np.sqrt(np.abs(x - side))
        kept = slice(3 * bool(amplitudes[0]), known.size - 3 * bool(amplitudes[1]))
        ends = np.array(amplitudes) / math.sqrt(width)
        theta = np.concatenate(([0.0], angle(known)[kept], [np.pi]))[axis:]
        value = np.concatenate((ends[:1], value[kept], ends[1:]))[axis:]
        smooth = Akima1DInterpolator(theta, value, extrapolate=True)(angle(x))
        with np.errstate(divide="ignore"):
            pressure[inside] = (smooth if value.min() < 0 else np.maximum(smooth, 0.0)) / weight
    return pressure - np.where(r < solution.cohesive_radius, solution.tension, 0.0)


def solution_of(problem: RingProblem, state: RingState, modulus: float) -> RingSolution:
    """The solution of a contact in SI units."""
    mesh, zones, size = state.mesh, state.zones, problem.size
    pulled = bool(np.any(state.pressure < 0))
    least = -math.inf if pulled else 0.0
    amplitudes = tuple(
        tuple(
            max(edge_fit(state, k, side, sharp=True)[0], least) if zones[k][side] in problem.corners else 0.0
            for side in (0, 1)
        )
        for k in range(len(zones))
    )
    pressure, radii = np.zeros(mesh.live.size), (mesh.edges[1:] + mesh.edges[:-1]) / 2
    pressure[mesh.live], radii[mesh.live] = state.pressure, mesh.centres
    loads = state.pressure * mesh.area
    loaded = loads != 0
    low, high = (side[mesh.live][loaded] ** 2 for side in (mesh.edges[:-1], mesh.edges[1:]))
    heights = [problem.gap(np.sqrt((low + high + x * (high - low)) / 2)) for x in (-(3**-0.5), 3**-0.5)]
    work = loads[loaded] @ (state.depth - sum(heights) / 2)
    area = sum(math.pi * (b - a) * (b + a) for a, b in zones)
    arrays = mesh.edges * size, radii * size, pressure * modulus, pressure
    for array in arrays:
        array.setflags(write=False)
    return RingSolution(
        *arrays[:3],
        strain=arrays[3],
        force=float(loads.sum()) * modulus * size**2,
        indentation=state.depth * size,
        stiffness=state.stiffness * modulus * size,
        energy=float(work) / 2 * modulus * size**3,
        mean_pressure=float(loads.sum()) / area * modulus if zones else 0.0,
        zones=tuple((a * size, b * size) for a, b in zones),
        edge_amplitudes=tuple(
            (a * modulus * math.sqrt(size), b * modulus * math.sqrt(size)) for a, b in amplitudes
        ),
        contact_radius=zones[-1][1] * size if zones else 0.0,
        contact_area=area * size**2,
        is_disk=len(zones) == 1 and zones[0][0] == 0,
        modulus=modulus,
        surface=problem.surface,
    )
