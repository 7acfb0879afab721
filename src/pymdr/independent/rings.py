"""Axisymmetric contact by boundary elements on concentric rings: no Abel map, no g(x), no springs.

The surface displacement of the elastic half-space is u = (1/(π E*)) ∬ p/R dS. With a pressure that is
constant on each ring it is a sum of closed forms with elliptic integrals; other bodies give their own. The contact is the solution
of Signorini's conditions p >= 0, u >= d - f, p (u - (d - f)) = 0: one disk, rings, or several of them.
Rings are graded as Chebyshev points to the edges of each contact zone and the condition is imposed at
the points between: the force then converges with the third power of the ring width, the pressure with
the second. Lengths inside the solver are divided by the reach, pressures by E*.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solve_triangular
from scipy.special import ellipe, ellipkm1

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.units import metres

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Gap = Callable[[Array], ArrayLike]
Zones = tuple[tuple[float, float], ...]

_LEAST = 12  # rings of a panel: the fit at an edge needs nine
_WHOLE: Zones = ((0.0, 1.0),)


class Surface(Protocol):
    """What is pressed: all that the rings know of a body."""

    @property
    def bulges(self) -> bool:
        """Whether it may rise beside a pressure, so that contact may lie where f > d."""

    @property
    def softness(self) -> float:
        """Of a half-space that is as soft to every pressure or softer: 1/E* over that of the surface."""

    def displacement(self, r: ArrayLike, edges: ArrayLike) -> Array:
        """In m at `r` (k,) by unit pressure on each ring of `edges` (n + 1,), for E* = 1: (k, n)."""


@dataclass(frozen=True)
class HalfSpace:
    """The homogeneous elastic half-space."""

    bulges = False
    softness = 1.0

    def displacement(self, r: ArrayLike, edges: ArrayLike) -> Array:
        """`ring_displacement`."""
        return ring_displacement(r, edges)


HALF_SPACE = HalfSpace()


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


@dataclass(frozen=True, eq=False)
class RingSolution:
    """Solution of the ring solver on m rings, of which those outside the contact carry no pressure.

    Attributes
    ----------
    edges : array (m + 1,), m
        Ring j lies between ``edges[j]`` and ``edges[j + 1]``.
    radii : array (m,), m
        Points at which u = d - f was imposed and to which `pressure` belongs.
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
        Limit of p √|r - edge| at the edges of each zone: positive at a sharp edge, negative at one that adhesion pulls, 0 at a
        free one.
    contact_radius : float, m
        Outermost zone edge; 0 without contact.
    contact_area : float, m²
    is_disk : bool
        Whether the contact is one full disk.
    modulus : float, Pa
        E*, or with memory the one at once.
    strain : array (m,)
        The pressure that displaces a surface of E* = 1 as far: without memory `pressure` over `modulus`.
    surface : Surface
        What is pressed.
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
    return _solve(gap, float(indentation), None, float(modulus), reach, n, edge, breakpoints, surface)


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
    return _solve(gap, None, float(force), float(modulus), reach, n, edge, breakpoints, surface)


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


def _disk(
    gap: Gap, radius: float, modulus: float, n: int, breakpoints: Sequence[float], surface: Surface
) -> tuple[RingProblem, RingMesh, Array, Array]:
    """Rings on a disk, and their pressures for d = 1 under a flat punch and for u = f."""
    problem = _problem(gap, modulus, radius, n, radius, breakpoints, surface)
    mesh = _mesh(problem, _panels(problem, (), _WHOLE))
    if not np.all(np.isfinite(mesh.gap)):
        raise ProblemError(f"gap ends within the contact radius of {metres(radius)}.")
    wanted = np.stack((np.ones_like(mesh.gap), mesh.gap), axis=1)
    unit, shape = np.linalg.solve(mesh.matrix, wanted).T
    return problem, mesh, unit, shape


def _on_disk(
    problem: RingProblem, mesh: RingMesh, unit: Array, shape: Array, depth: float, modulus: float
) -> RingSolution:
    state = RingState(mesh, depth * unit - shape, depth, float(mesh.area @ unit), _WHOLE)
    return _solution(problem, state, modulus)


def ring_displacement(r: ArrayLike, edges: ArrayLike) -> Array:
    """Displacement in m at `r` (k,) by unit pressure on each ring of `edges` (n + 1,), for E* = 1: (k, n).

    A disk of radius a under unit pressure gives (4/π) a E(m), m = r²/a², inside and
    (4/π) r [E(m) - (1 - m) K(m)], m = a²/r², outside; a ring is a difference of disks.

    Raises
    ------
    ProblemError
        If a radius in m is negative or not finite, or the edges do not increase.

    References
    ----------
    Johnson 1985, Contact Mechanics, section 3.4(a), eqs. 3.29.

    Examples
    --------
    >>> ring_displacement([0.0], [0.0, 1.0, 3.0])
    array([[2., 4.]])
    """
    r, a = np.atleast_1d(_radii(r))[:, None], np.atleast_1d(_radii(edges))
    if r.ndim != 2 or a.ndim != 1 or a.size < 2 or not np.all(np.diff(a) > 0):
        raise ProblemError("ring_displacement needs one row of radii and at least two increasing edges.")
    block = max(1, 2**18 // a.size)  # bounds the memory of the temporaries
    return np.vstack([_rings(r[i : i + block], a) for i in range(0, max(r.size, 1), block)])


def _rings(r: Array, a: Array) -> Array:
    large, small = np.maximum(r, a), np.minimum(r, a)
    size = np.where(large > 0, large, 1.0)
    rest = (large - small) / size * ((large + small) / size)
    K = ellipkm1(np.where(rest > 0, rest, 1.0))
    beyond = large * (_excess(rest, K) - np.where(r > a, rest * K, 0.0))
    return np.asarray(4 / np.pi * (np.diff(large, axis=1) + np.diff(beyond, axis=1)), dtype=np.float64)


def _excess(c: Array, K: Array) -> Array:
    """E(1 - c) - 1 for K = K(1 - c); where c is small, without cancellation by Legendre's relation."""
    excess = np.asarray(ellipe(1 - c) - 1, dtype=np.float64)
    near = c < 0.1
    order = np.arange(1, 16)
    terms = np.pi / 2 * np.cumprod(((2 * order - 1) / (2 * order)) ** 2)
    x = c[near]
    k = x * np.polynomial.polynomial.polyval(x, terms)  # K(c) - π/2
    difference = x * np.polynomial.polynomial.polyval(x, terms * 2 * order / (2 * order - 1))  # K(c) - E(c)
    excess[near] = (difference * K[near] - k) / (np.pi / 2 + k)
    return excess


def displacement_at(solution: RingSolution, r: ArrayLike) -> Array:
    """Surface displacement u(r) in m at radii `r` in m, of any shape, inside and outside the contact.

    Raises
    ------
    ProblemError
        If a radius is negative or not finite.

    Examples
    --------
    >>> flat = solve_indentation(lambda r: 0 * r, 1e-6, 1e9, reach=1e-3, edge=1e-3)
    >>> f"{displacement_at(flat, 2e-3):.5e}"
    '3.33333e-07'
    """
    r = _radii(r)
    u = solution.surface.displacement(r.ravel(), solution.edges) @ solution.strain
    return np.asarray(u.reshape(r.shape), dtype=np.float64)


def pressure_at(solution: RingSolution, r: ArrayLike) -> Array:
    """Contact pressure p(r) in Pa at radii `r` in m, of any shape; 0 outside, inf at a sharp edge and -inf at a pulled one.

    Between the edges b < a of a zone it is interpolated in θ = 2 arctan √((r - b)/(a - r)), in which
    it is smooth up to a free edge; at a sharp edge p √|r - edge| is interpolated.

    Raises
    ------
    ProblemError
        If a radius is negative or not finite.

    Examples
    --------
    >>> hertz = solve_indentation(lambda r: r**2 / 2, 1.0, 1.0, reach=2.0)
    >>> [f"{p:.4f}" for p in pressure_at(hertz, [0.0, 0.6, 0.8, 1.5]) * np.pi / 2]
    ['1.0000', '0.8000', '0.6000', '0.0000']
    """
    from scipy.interpolate import Akima1DInterpolator

    def angle(x: Array) -> Array:
        return np.asarray(2 * np.arctan2(np.sqrt(x), np.sqrt(1 - x)), dtype=np.float64)

    r = _radii(r)
    pressure = np.zeros_like(r)
    for (inner, outer), amplitudes in zip(solution.zones, solution.edge_amplitudes, strict=True):
        width, axis = outer - inner, int(inner == 0)
        own, inside = (solution.radii > inner) & (solution.radii < outer), (r >= inner) & (r <= outer)
        known, x = (solution.radii[own] - inner) / width, (r[inside] - inner) / width
        value, weight = solution.pressure[own], np.ones_like(x)
        for side, sharp in enumerate(amplitudes):
            if sharp:
                value = value * np.sqrt(np.abs(known - side)) * _correction(known.size)[:: 1 - 2 * side]
                weight = weight * np.sqrt(np.abs(x - side))
        kept = slice(3 * bool(amplitudes[0]), known.size - 3 * bool(amplitudes[1]))
        ends = np.array(amplitudes) / math.sqrt(width)
        theta = np.concatenate(([0.0], angle(known)[kept], [np.pi]))[axis:]
        value = np.concatenate((ends[:1], value[kept], ends[1:]))[axis:]
        smooth = Akima1DInterpolator(theta, value, extrapolate=True)(angle(x))
        with np.errstate(divide="ignore"):
            pressure[inside] = (smooth if value.min() < 0 else np.maximum(smooth, 0.0)) / weight
    return pressure


def _correction(n: int) -> Array:
    """Exact over computed pressure of n rings counted from a sharp edge; the first three obey it badly."""
    return np.asarray(1 + 1 / (12 * (np.arange(n) + 0.5) ** 2), dtype=np.float64)


def _radii(r: ArrayLike) -> Array:
    r = np.asarray(r, dtype=np.float64)
    if not np.all(np.isfinite(r) & (r >= 0)):
        raise ProblemError("Radii must be finite and not negative.")
    return r


class RingProblem(NamedTuple):
    """Lengths over `size`, the end of the rings, pressures over E*; the pressure may be singular at `corners`."""

    gap: Callable[[Array], Array]
    depth: float | None
    force: float | None
    corners: tuple[float, ...]
    n: int
    size: float
    surface: Surface = HALF_SPACE


class RingMesh(NamedTuple):
    """Rings with contiguous edges; the `live` ones may carry pressure, others bridge what lies between."""

    edges: Array
    live: Mask
    centres: Array
    gap: Array
    panel: NDArray[np.intp]
    area: Array
    matrix: Array
    inverses: tuple[Array, Array] | None = None
    """Of the matrix, if many contacts are solved that begin at the axis; see `leading_inverses`."""


class RingState(NamedTuple):
    """A contact on a mesh, in the units of its problem, whose E* is 1."""

    mesh: RingMesh
    pressure: Array
    depth: float
    stiffness: float
    zones: Zones


def _solve(
    gap: Gap,
    depth: float | None,
    force: float | None,
    modulus: float,
    reach: float,
    n: int,
    edge: float,
    breakpoints: Sequence[float],
    surface: Surface,
) -> RingSolution:
    problem = _problem(gap, modulus, reach, n, edge, breakpoints, surface)
    size = problem.size
    asked = problem._replace(
        depth=None if depth is None else depth / size,
        force=None if force is None else force / modulus / size / size,
    )
    return _solution(asked, _settle(asked), modulus)


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

    corners = {float(b) for b in _radii(breakpoints) / size if 0 < b < 1} | (
        {1.0} if edge <= reach else set()
    )
    return RingProblem(scaled_gap, None, None, tuple(sorted(corners)), int(Rings(n).n), size, surface)


def _solution(problem: RingProblem, state: RingState, modulus: float) -> RingSolution:
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


def _settle(problem: RingProblem) -> RingState:
    """Alternate the active set, on rings graded to the last zones, with the refinement of the zone edges."""
    level = math.inf if problem.depth is None else problem.depth
    zones: Zones = ()
    refined: RingState | None = None
    near = max(0.02, 4 / problem.n)
    for attempt in range(16):
        spans = _spans(problem, level)
        if not spans and problem.depth is None:
            raise ProblemError("gap has no finite value up to the reach or edge: no force can be carried.")
        if not spans:
            return RingState(_mesh(problem, [(0.0, 1.0, 1)]), np.zeros(1), level, 0.0, ())
        found = active_set(problem, _mesh(problem, _panels(problem, spans, zones)), zones)
        if not found.zones:
            return found
        if refined and refined.pressure.min() >= 0 and _agree(problem, found.zones, refined.zones, near, 0.0):
            missed = _missed(problem, refined, spans) if attempt < 5 else ()
            if not missed:
                return refined
            zones, refined = tuple(sorted((*refined.zones, *missed))), None
            continue
        # At a depth where a hole or a zone is about to vanish, the rings may tell either way.
        simple = _simplify(problem, found.zones, min(20 / problem.n, 0.3)) if attempt > 4 else found.zones
        if refined and attempt > 4 and _agree(problem, simple, refined.zones, near, 0.0):
            return found
        refined = _refine(problem, simple) if _agree(problem, simple, zones, 0.2, 0.2) else None
        zones = refined.zones if refined else simple
        if problem.depth is None:
            level = found.depth + 0.1 * (found.depth - float(found.mesh.gap.min()))
    raise ConvergenceError(
        f"The edges of the contact zones did not settle; the last were {_zones_in_words(problem, zones)} at d = "
        f"{metres(found.depth * problem.size)}. Give breakpoints at kinks and jumps of the gap, or more rings."
    )


def _spans(problem: RingProblem, level: float) -> list[tuple[float, float]]:
    """Intervals outside of which contact is looked for by no ring."""
    below = _below(problem, level)
    if not (below and problem.surface.bulges):
        return below
    x = np.concatenate(([0.0], np.geomspace(1e-12, 1.0, 2001)))
    return [(0.0, min(1.0, max(below[-1][1], bulge_radius(x, problem.gap(x), level))))]


def bulge_radius(r: Array, f: Array, level: float) -> float:
    """A bound of the contact with what may bulge, from f at some radii: what rises beside a disk has sunk within.

    There the mean of f over the disk is d, and a fifth more.
    """
    mean = np.cumsum((f[1:] + f[:-1]) / 2 * np.diff(r**2)) / r[1:] ** 2
    sunk = np.flatnonzero(mean < level)
    return 1.2 * float(r[min(sunk[-1] + 2, r.size - 1)]) if sunk.size else 0.0


def _below(problem: RingProblem, level: float) -> list[tuple[float, float]]:
    """Intervals that hold all points with f < d: contact is nowhere else if u > 0 everywhere."""
    spans: list[tuple[float, float]] = []
    todo = [(0.0, 1.0)]
    for zoom in range(40):
        again: list[tuple[float, float]] = []
        for low, high in todo:
            x = np.linspace(low, high, 65 if zoom else 2001)
            f = problem.gap(x)
            with np.errstate(invalid="ignore"):
                steps = np.nan_to_num(np.abs(np.diff(f)), posinf=0.0)
            variation = np.maximum(np.append(0.0, steps), np.append(steps, 0.0))
            for i, j in _runs(f - variation < level):
                wide = 4 * (j - i) >= x.size and bool(np.any(f[i:j] < level))
                (spans if wide else again).append((float(x[max(i - 1, 0)]), float(x[min(j, x.size - 1)])))
        todo = again
    return _union(spans)


def _missed(problem: RingProblem, state: RingState, spans: Sequence[tuple[float, float]]) -> Zones:
    """Where, between the rings outside the zones, the surface would enter the punch."""
    mesh, missed = state.mesh, []
    for low, high, _ in _panels(problem, spans, state.zones):
        if not any(a <= low < b for a, b in state.zones):
            x = np.linspace(low, high, 129)
            u = _displacement(problem, x, mesh.edges)[:, mesh.live] @ state.pressure
            over = state.depth - problem.gap(x) - u > (state.depth - mesh.gap.min()) / problem.n**3
            over[:2] = over[-2:] = False
            missed += [(float(x[i - 1]), float(x[j])) for i, j in _runs(over)]
    return tuple(missed)


def _runs(mask: Mask) -> list[tuple[int, int]]:
    steps = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False])).astype(np.int8)))
    return [(int(i), int(j)) for i, j in steps.reshape(-1, 2)]


def _union(intervals: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    union: list[tuple[float, float]] = []
    for low, high in sorted(intervals):
        if union and low <= union[-1][1]:
            low, high = union[-1][0], max(high, union.pop()[1])
        union.append((low, high))
    return union


def _simplify(problem: RingProblem, zones: Zones, narrow: float) -> Zones:
    """Close holes narrower than this part of the zones beside them; on the axis and for zones, powers of it."""
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


def _panels(
    problem: RingProblem, spans: Sequence[tuple[float, float]], zones: Zones
) -> list[tuple[float, float, int]]:
    """Cut the spans and zones at zone edges and corners, and share the rings out among the panels."""
    marks = sorted({*problem.corners, *(x for zone in zones for x in zone)})
    pieces = []
    for low, high in _union([*spans, *zones]):
        cuts = [low, *(x for x in marks if low < x < high), high]
        pieces += [(a, b, any(z[0] <= a and b <= z[1] for z in zones)) for a, b in itertools.pairwise(cuts)]
    panels = []
    for low, high, inside in pieces:
        rings = problem.n if inside else problem.n // 4 if zones else max(problem.n, 100)
        share = math.sqrt(high - low) / sum(math.sqrt(b - a) for a, b, other in pieces if other == inside)
        panels.append((low, high, max(_LEAST, round(rings * share))))
    return panels


def _mesh(problem: RingProblem, panels: Sequence[tuple[float, float, int]]) -> RingMesh:
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
    matrix = _displacement(problem, r, a)[:, own]
    return RingMesh(a, own, r, problem.gap(r), np.array(panel), area, matrix)


def _displacement(problem: RingProblem, r: Array, a: Array) -> Array:
    return problem.surface.displacement(r * problem.size, a * problem.size) / problem.size


def leading_inverses(matrix: Array) -> tuple[Array, Array]:
    """Inverses of L and U of a matrix of influence, without pivots: their leading blocks are those of its leading blocks."""
    factors = matrix.copy()
    for i in range(factors.shape[0] - 1):
        factors[i + 1 :, i] /= factors[i, i]
        factors[i + 1 :, i + 1 :] -= np.outer(factors[i + 1 :, i], factors[i, i + 1 :])
    one = np.eye(factors.shape[0])
    lower = solve_triangular(factors, one, lower=True, unit_diagonal=True)
    return np.ascontiguousarray(lower), np.ascontiguousarray(solve_triangular(factors, one))


def product(matrix: Array, vector: Array) -> Array:
    """Matrix times vector in one thread: others take longer to wake than the many small products of a history do."""
    return np.asarray(np.einsum("ij,j->i", matrix, vector))


def _balance(problem: RingProblem, mesh: RingMesh, active: Mask) -> tuple[Array, float, float]:
    """Pressure, d and dF/dd with the given rings in contact: matrix p = d - f and, for a force, area p = F."""
    gap, area = mesh.gap[active], mesh.area[active]
    depth = float(gap.min()) if problem.depth is None else problem.depth
    wanted = depth - gap, np.ones_like(gap)
    if mesh.inverses is not None and active[: gap.size].all():
        lower, upper = (each[: gap.size, : gap.size] for each in mesh.inverses)
        p, unit = (product(upper, product(lower, each)) for each in wanted)
    else:
        p, unit = np.linalg.solve(mesh.matrix[np.ix_(active, active)], np.stack(wanted, axis=1)).T
    stiffness = float(area @ unit)
    if problem.force is not None:
        more = (problem.force - float(area @ p)) / stiffness
        p, depth = p + more * unit, depth + more
    pressure = np.zeros(active.size)
    pressure[active] = p
    return pressure, depth, stiffness


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
            return RingState(mesh, pressure, depth, stiffness, _zones(problem, mesh, active))
        fewest, patience = (count, 10) if count < fewest else (fewest, patience - 1)
        if patience < 0:  # Murty's single pivots, which cannot cycle
            wrong[: np.flatnonzero(wrong)[-1]] = False
        active = active ^ wrong
    raise ConvergenceError(
        f"The active set of {active.size} rings did not settle: the last had {int(active.sum())} in contact, {count} of "
        f"all wrong, at d = {metres(depth * problem.size)}. Try another number of rings."
    )


def _zones_in_words(problem: RingProblem, zones: Zones) -> str:
    return ", ".join(f"{metres(a * problem.size)} to {metres(b * problem.size)}" for a, b in zones)


def _zones(problem: RingProblem, mesh: RingMesh, active: Mask) -> Zones:
    contact, end = np.zeros(mesh.live.size + 2, dtype=np.bool_), np.zeros(mesh.live.size + 2, dtype=np.bool_)
    contact[1:-1][mesh.live], end[1:-1][mesh.live] = active, np.isinf(mesh.gap)
    end[-1] = True
    zones = []
    for i, j in _runs(contact):
        inner, outer = float(mesh.edges[i - 1]), float(mesh.edges[j - 1])
        if (end[i - 1] and inner not in problem.corners) or (end[j] and outer not in problem.corners):
            raise ProblemError(
                f"The contact zone from {_zones_in_words(problem, ((inner, outer),))} meets the reach or the end of the "
                "gap. Give a larger reach, or edge or breakpoints where the punch ends."
            )
        zones.append((inner, outer))
    return tuple(zones)


def _room(zones: Zones, k: int) -> tuple[float, float]:
    """Smaller of the widths of a zone and of the hole beside it, for its inner and outer edge."""
    inner, outer = zones[k]
    before = zones[k - 1][1] if k else 0.0
    after = zones[k + 1][0] if k + 1 < len(zones) else math.inf
    return min(outer - inner, inner - before), min(outer - inner, after - outer)


def _agree(problem: RingProblem, new: Zones, old: Zones, tolerance: float, at_corners: float) -> bool:
    return len(new) == len(old) and all(
        abs(new[k][side] - x) <= room * (at_corners if x in problem.corners else tolerance)
        for k in range(len(old))
        for side, (x, room) in enumerate(zip(old[k], _room(old, k), strict=True))
    )


def _refine(problem: RingProblem, zones: Zones) -> RingState | None:
    """Move the free edges of the zones until p √s = K + C s + ... has K = 0 there, s the distance from the edge.

    A step of 2 K/C is Newton's method, for √(s + δ) = √s + δ/(2√s) + ...: the zero of p², seen from afar.
    """
    for _ in range(15):
        mesh = _mesh(problem, _panels(problem, (), zones))
        if not np.all(np.isfinite(mesh.gap)):
            return None
        state = RingState(mesh, *_balance(problem, mesh, np.ones(mesh.centres.size, dtype=np.bool_)), zones)
        noise = 1e-13 * float(np.max(np.abs(mesh.gap)) / (state.depth - mesh.gap.min()))
        moved, still, tolerance = [list(zone) for zone in zones], True, max(1e-9, noise)
        for k, side in itertools.product(range(len(zones)), (0, 1)):
            x, room = zones[k][side], _room(zones, k)[side]
            K, C = edge_fit(state, k, side) if x > 0 else (0.0, 1.0)
            if x == 0 or (x in problem.corners and K >= 0):
                continue
            step = math.copysign(min(2 * abs(K) / C, 0.2 * room) if C > 0 else 0.2 * room, K if side else -K)
            still &= abs(step) <= tolerance * room
            passed = [c for c in problem.corners if (c - x) * step > 0 and abs(c - x) <= abs(step)]
            moved[k][side] = min(passed, key=lambda c: abs(c - x), default=x + step)
        if still:
            return state
        zones = _simplify(problem, tuple((a, b) for a, b in moved), (2 / problem.n) ** 2)
    return None


def edge_fit(state: RingState, k: int, side: int, sharp: bool = False) -> tuple[float, float]:
    """K and C of p √s = K + C s + ..., s the distance into the contact from a zone edge."""
    mesh, end = state.mesh, state.zones[k][side]
    rings = np.flatnonzero(mesh.panel == mesh.panel[np.searchsorted(mesh.centres, end) - side])
    rings = rings[::-1] if side else rings
    s = np.abs(mesh.centres[rings] - end)
    near = int(np.searchsorted(s, _room(state.zones, k)[side] / 2))
    count = max(6, min(rings.size // 8, near)) + 3 * sharp
    s, y = s[:count], state.pressure[rings[:count]] * np.sqrt(s[:count])
    first = 3 * sharp
    # of what the rings get wrong at a sharp edge only K has a part
    known = 1 / _correction(s.size) if sharp else np.ones_like(s)
    powers = np.column_stack((known, *((s / s[-1]) ** k for k in (1, 2, 3))))
    fit = np.linalg.lstsq(powers[first:], y[first:])[0]
    return float(fit[0]), float(fit[1] / s[-1])
