"""Contacts at an indentation, under a force, and on a disk."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ProblemError
from pymdr.independent.rings.edges import edge_fit
from pymdr.independent.rings.meshes import RingMesh, RingProblem, RingState, mesh_of, panels_of
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
from pymdr.units import metres

_WHOLE: Zones = ((0.0, 1.0),)


@dataclass(frozen=True)
class Rings:
    """Option of ``solve``: the ring solver with `n` rings in contact, 20 to 5000.

    Raises
    ------
    ProblemError
        If `n` is not an integer from 20 to 5000.

    Examples
    --------
    >>> Rings(n=200)
    Rings(n=200)
    """

    n: int = 400

    def __post_init__(self) -> None:
        if isinstance(self.n, bool) or not isinstance(self.n, (int, np.integer)) or not 20 <= self.n <= 5000:
            raise ProblemError(f"Rings needs an integer n from 20 to 5000, not {self.n!r}.")


def solve_indentation(
    gap: Gap,
    indentation: float,
    modulus: float,
    *,
    reach: float,
    n: int = 400,
    edge: float = math.inf,
    breakpoints: Sequence[float] = (),
    surface: Surface = HALF_SPACE,
) -> RingSolution:
    """Contact at a given approach d: p >= 0, u >= d - f(r), p (u - d + f) = 0.

    Parameters
    ----------
    gap : callable
        f(r) in m for an array of radii in m; of any sign, nan or inf where there is no punch.
    indentation : float, m
        Approach d, counted from f = 0. Without contact if d <= min f.
    modulus : float, Pa
        E*.
    reach : float, m
        Upper bound of the contact radius.
    n : int
        Rings in contact, 20 to 5000.
    edge : float, m
        Sharp outer edge of the punch, at which the pressure may be singular.
    breakpoints : sequence of float, m
        Radii of kinks, jumps and inner edges of f.
    surface : Surface
        What is pressed, displaced in proportion to 1/E*.

    Raises
    ------
    ProblemError
        If an argument is outside its limits, or the contact grows to `reach` or to the end of f.
    ConvergenceError
        If the contact zones cannot be settled.

    References
    ----------
    Júdice and Pires 1994, Comput. Oper. Res. 21, 587: block principal pivoting, the active set used.

    Examples
    --------
    >>> hertz = solve_indentation(lambda r: r**2 / 2, 0.01, 1.0, reach=1.0)
    >>> f"{hertz.force / (4 / 3 * 0.01**1.5):.7f} {hertz.contact_radius:.6f} {hertz.is_disk}"
    '1.0000000 0.100000 True'
    """
    if not math.isfinite(indentation):
        raise ProblemError(f"The indentation must be a finite number of metres, not {indentation!r}.")
    problem = _problem(gap, float(modulus), reach, n, edge, breakpoints, surface)
    asked = problem._replace(depth=indentation / problem.size)
    return solution_of(asked, settle(asked), float(modulus))


def solve_force(
    gap: Gap,
    force: float,
    modulus: float,
    *,
    reach: float,
    n: int = 400,
    edge: float = math.inf,
    breakpoints: Sequence[float] = (),
    surface: Surface = HALF_SPACE,
) -> RingSolution:
    """Contact under a given positive force in N; d is one more unknown of the same active set.

    Parameters, errors and source as in `solve_indentation`.

    Raises
    ------
    ProblemError, ConvergenceError

    Examples
    --------
    >>> f"{solve_force(lambda r: r**2 / 2, 4 / 3 * 0.01**1.5, 1.0, reach=1.0).indentation:.7f}"
    '0.0100000'
    """
    if not (math.isfinite(force) and force > 0):
        raise ProblemError(f"The force must be a positive finite number of newtons, not {force!r}.")
    problem = _problem(gap, float(modulus), reach, n, edge, breakpoints, surface)
    asked = problem._replace(force=force / modulus / problem.size**2)
    return solution_of(asked, settle(asked), float(modulus))


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
    """Contact on the disk of a given radius a at a given approach d, whether pressed or pulled: u = d - f(r).

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
        Of adhesion.

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
        edge_fit(RingState(mesh, np.asarray(p), 0.0, 0.0, _WHOLE), 0, 1, sharp=True)[0]
        for p in (unit, shape, known)
    )
    # the rings err at the edge as they do on the half-space, of which it is known that p √(1 - r) → 1/(π √2)
    pull = math.sqrt(work / (math.pi * modulus * radius)) * of_known * math.pi * math.sqrt(2)
    return _on_disk(problem, mesh, unit, shape, (of_shape - pull) / of_unit, modulus)


def _problem(
    gap: Gap,
    modulus: float,
    reach: float,
    n: int,
    edge: float,
    breakpoints: Sequence[float],
    surface: Surface,
) -> RingProblem:
    """Without depth and force."""
    if not (math.isfinite(modulus) and modulus > 0):
        raise ProblemError(f"The modulus E* must be positive and finite, not {modulus!r} Pa.")
    if not (math.isfinite(reach) and reach > 0 and edge > 0):
        raise ProblemError(
            f"reach must be positive and finite and edge positive, not {reach!r} and {edge!r} m."
        )
    size = float(min(reach, edge))

    def scaled_gap(x: Array) -> Array:
        f = np.asarray(gap(x * size), dtype=np.float64) / size
        if f.shape != x.shape or np.any(np.isneginf(f)):
            raise ProblemError("gap must give one height for each radius, none of them -inf.")
        return np.where(np.isnan(f), np.inf, f)

    corners = {float(b) for b in valid_radii(breakpoints) / size if 0 < b < 1} | (
        {1.0} if edge <= reach else set()
    )
    return RingProblem(scaled_gap, None, None, tuple(sorted(corners)), int(Rings(n).n), size, surface)


def _disk(
    gap: Gap, radius: float, modulus: float, n: int, breakpoints: Sequence[float], surface: Surface
) -> tuple[RingProblem, RingMesh, Array, Array]:
    """Rings on a disk, and their pressures for d = 1 under a flat punch and for u = f."""
    problem = _problem(gap, modulus, radius, n, radius, breakpoints, surface)
    mesh = mesh_of(problem, panels_of(problem, (), _WHOLE))
    if not np.all(np.isfinite(mesh.gap)):
        raise ProblemError(f"gap ends within the contact radius of {metres(radius)}.")
    wanted = np.stack((np.ones_like(mesh.gap), mesh.gap), axis=1)
    unit, shape = np.linalg.solve(mesh.matrix, wanted).T
    return problem, mesh, unit, shape


def _on_disk(
    problem: RingProblem, mesh: RingMesh, unit: Array, shape: Array, depth: float, modulus: float
) -> RingSolution:
    state = RingState(mesh, depth * unit - shape, depth, float(mesh.area @ unit), _WHOLE)
    return solution_of(problem, state, modulus)
