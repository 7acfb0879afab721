"""Contacts at an indentation, under a force, and on a disk."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ProblemError
from pymdr.independent.rings.meshes import RingMesh, RingProblem, RingState, edge_fit, mesh_of, panels_of
from pymdr.independent.rings.settling import settle
from pymdr.independent.rings.solution import RingSolution, solution_of
from pymdr.independent.rings.surfaces import (
    HALF_SPACE,
    Array,
    Gap,
    Surface,
    Zones,
    ring_displacement,
    valid_radii,
)
from pymdr.problem.values import Value
from pymdr.units import metres, shown

_FULL_DISK: Zones = ((0.0, 1.0),)


@dataclass(frozen=True, eq=False)
class Rings(Value):
    """
    Boundary elements on rings, as an option of ``solve``.

    Parameters
    ----------
    n : int
        Number of rings in contact, 20 to 5000; 400 by default.

    Raises
    ------
    ProblemError
        If `n` is not an integer from 20 to 5000.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Rings(n=200)
    Rings(n=200)
    """

    n: int = 400

    def __post_init__(self) -> None:
        if isinstance(self.n, bool) or not isinstance(self.n, (int, np.integer)) or not 20 <= self.n <= 5000:
            raise ProblemError(f"n = {shown(self.n)}; a whole number from 20 to 5000 is needed")


def solve_indentation(
    gap: Gap,
    indentation: float,
    modulus: float,
    *,
    max_radius: float,
    n: int = 400,
    edge: float = math.inf,
    breakpoints: Sequence[float] = (),
    surface: Surface = HALF_SPACE,
) -> RingSolution:
    """Contact at a given approach d: p >= 0, u >= d - f(r), p (u - d + f) = 0.

    Parameters
    ----------
    gap : callable
        f(r) in m for an array of radii in m; of any sign, nan or inf outside the punch.
    indentation : float, m
        Approach d, counted from f = 0; no contact if d <= min f.
    modulus : float, Pa
        E*.
    max_radius : float, m
        Upper bound of the contact radius.
    n : int
        Rings in contact, 20 to 5000.
    edge : float, m
        Sharp outer edge of the punch, at which the pressure may be singular.
    breakpoints : sequence of float, m
        Radii of kinks, jumps and inner edges of f.
    surface : Surface
        Elastic surface, displaced in proportion to 1/E*.

    Raises
    ------
    ProblemError
        If an argument is outside its limits, or the contact grows to `max_radius` or to the end of f.
    ConvergenceError
        If the contact zones do not converge.

    References
    ----------
    Júdice and Pires 1994, Comput. Oper. Res. 21, 587: block principal pivoting, the active set used.

    Examples
    --------
    >>> hertz = solve_indentation(lambda r: r**2 / 2, 0.01, 1.0, max_radius=1.0)
    >>> f"{hertz.force / (4 / 3 * 0.01**1.5):.7f} {hertz.contact_radius:.6f} {hertz.is_disk}"
    '1.0000000 0.100000 True'
    """
    if not math.isfinite(indentation):
        raise ProblemError(f"The indentation must be a finite number of metres, not {indentation!r}.")
    problem = _problem(gap, float(modulus), max_radius, n, edge, breakpoints, surface)
    loaded = problem._replace(depth=indentation / problem.size)
    return solution_of(loaded, settle(loaded), float(modulus))


def solve_force(
    gap: Gap,
    force: float,
    modulus: float,
    *,
    max_radius: float,
    n: int = 400,
    edge: float = math.inf,
    breakpoints: Sequence[float] = (),
    surface: Surface = HALF_SPACE,
) -> RingSolution:
    """Contact under a given positive force in N; d is an additional unknown of the active set.

    Parameters, errors and source as in `solve_indentation`.

    Raises
    ------
    ProblemError, ConvergenceError

    Examples
    --------
    >>> f"{solve_force(lambda r: r**2 / 2, 4 / 3 * 0.01**1.5, 1.0, max_radius=1.0).indentation:.7f}"
    '0.0100000'
    """
    if not (math.isfinite(force) and force > 0):
        raise ProblemError(f"The force must be a positive finite number of newtons, not {force!r}.")
    problem = _problem(gap, float(modulus), max_radius, n, edge, breakpoints, surface)
    loaded = problem._replace(force=force / modulus / problem.size**2)
    return solution_of(loaded, settle(loaded), float(modulus))


def solve_disk(
    gap: Gap,
    radius: float,
    indentation: float,
    modulus: float,
    *,
    n: int = 400,
    breakpoints: Sequence[float] = (),
    surface: Surface = HALF_SPACE,
) -> RingSolution:
    """Contact on the disk of a given radius a at a given approach d, in compression or tension: u = d - f(r).

    Parameters
    ----------
    gap : callable
        f(r) in m for an array of radii in m up to a.
    radius : float, m
        a.
    indentation : float, m
        Approach d, counted from f = 0.
    modulus, n, breakpoints, surface
        As in `solve_indentation`.

    Raises
    ------
    ProblemError
        If an argument is outside its limits, or f is not known up to a.

    Examples
    --------
    >>> f"{solve_disk(lambda r: 0 * r, 0.3, -1.0, 1.0).force:.6f}"
    '-0.600000'
    """
    if not math.isfinite(indentation):
        raise ProblemError(f"The indentation must be a finite number of metres, not {indentation!r}.")
    problem, mesh, unit, shape = _disk(gap, radius, modulus, n, breakpoints, surface)
    return _on_disk(problem, mesh, unit, shape, indentation / radius, modulus)


def solve_adhesion(
    gap: Gap,
    radius: float,
    work: float,
    modulus: float,
    *,
    n: int = 400,
    breakpoints: Sequence[float] = (),
    surface: Surface = HALF_SPACE,
) -> RingSolution:
    """Adhesive contact on the disk of a given radius a, pulled at its edge like a crack: p √(a - r) → -√(E* w/π).

    Parameters
    ----------
    gap, radius, modulus, n, breakpoints, surface
        As in `solve_disk`.
    work : float, J/m²
        Work of adhesion.

    Raises
    ------
    ProblemError
        If an argument is outside its limits, or f is not known up to a.

    References
    ----------
    Johnson, Kendall and Roberts 1971, Proc. R. Soc. A 324, 301; Irwin 1957, J. Appl. Mech. 24, 361, for the edge.

    Examples
    --------
    >>> jkr = solve_adhesion(lambda r: r**2 / 2, 0.3, 0.05, 1.0)
    >>> f"{jkr.force / (4 / 3 * 0.3**3 - (8 * math.pi * 0.05 * 0.3**3) ** 0.5):.6f}"
    '1.000000'
    """
    if not (math.isfinite(work) and work >= 0):
        raise ProblemError(f"The work of adhesion must be finite and not negative, not {work!r} J/m².")
    problem, mesh, unit, shape = _disk(gap, radius, modulus, n, breakpoints, surface)
    known = np.linalg.solve(ring_displacement(mesh.centres, mesh.edges), np.ones_like(mesh.gap))
    of_unit, of_shape, of_known = (
        edge_fit(RingState(mesh, np.asarray(p), 0.0, 0.0, _FULL_DISK), 0, 1, sharp=True)[0]
        for p in (unit, shape, known)
    )
    # the error of the rings at the edge is that on the half-space, where p √(1 - r) → 1/(π √2)
    pull = math.sqrt(work / (math.pi * modulus * radius)) * of_known * math.pi * math.sqrt(2)
    return _on_disk(problem, mesh, unit, shape, (of_shape - pull) / of_unit, modulus)


def _problem(
    gap: Gap,
    modulus: float,
    max_radius: float,
    n: int,
    edge: float,
    breakpoints: Sequence[float],
    surface: Surface,
) -> RingProblem:
    """A contact problem without depth and force."""
    if not (math.isfinite(modulus) and modulus > 0):
        raise ProblemError(f"The modulus E* must be positive and finite, not {modulus!r} Pa.")
    if not (math.isfinite(max_radius) and max_radius > 0 and edge > 0):
        raise ProblemError(
            f"max_radius must be positive and finite and edge positive, not {max_radius!r} and {edge!r} m."
        )
    size = float(min(max_radius, edge))

    def scaled_gap(x: Array) -> Array:
        f = np.asarray(gap(x * size), dtype=np.float64) / size
        if f.shape != x.shape or np.any(np.isneginf(f)):
            raise ProblemError("gap must return one height for each radius, and no height may be -inf.")
        return np.where(np.isnan(f), np.inf, f)

    corners = {float(b) for b in valid_radii(breakpoints) / size if 0 < b < 1} | (
        {1.0} if edge <= max_radius else set()
    )
    return RingProblem(scaled_gap, None, None, tuple(sorted(corners)), int(Rings(n).n), size, surface)


def _disk(
    gap: Gap, radius: float, modulus: float, n: int, breakpoints: Sequence[float], surface: Surface
) -> tuple[RingProblem, RingMesh, Array, Array]:
    """Rings on a disk, and their pressures for u = 1 and for u = f."""
    problem = _problem(gap, modulus, radius, n, radius, breakpoints, surface)
    mesh = mesh_of(problem, panels_of(problem, (), _FULL_DISK))
    if not np.all(np.isfinite(mesh.gap)):
        raise ProblemError(
            f"gap ends within the contact radius of {metres(radius)}. Give a smaller indentation, or gaps at larger radii."
        )
    displacements = np.stack((np.ones_like(mesh.gap), mesh.gap), axis=1)
    unit, shape = np.linalg.solve(mesh.matrix, displacements).T
    return problem, mesh, unit, shape


def _on_disk(
    problem: RingProblem, mesh: RingMesh, unit: Array, shape: Array, depth: float, modulus: float
) -> RingSolution:
    state = RingState(mesh, depth * unit - shape, depth, float(mesh.area @ unit), _FULL_DISK)
    return solution_of(problem, state, modulus)
