"""Pressure and tangential tractions of a row, and rows of indentation and shift followed from the initial state."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymdr.errors import ConvergenceError, PathError, ProblemError
from pymdr.independent.sliding.surface import Surface, make_surface
from pymdr.problem.materials import Material
from pymdr.problem.profiles import Profile
from pymdr.units import FloatArray, metres

_TOLERANCE = 1e-9
_ITERATIONS = 5000


def solve_pressure(surface: Surface, gap: FloatArray, depth: float, start: FloatArray) -> FloatArray:
    """
    Pressure p >= 0 with zero gap f - d + u in the contact and no overlap elsewhere.

    Parameters
    ----------
    gap : ndarray (n, n), m
        f, inf outside the body.
    depth : float, m
        d.
    start : ndarray (n, n), Pa
        First iterate.

    Notes
    -----
    Conjugate gradients on the cells in contact: Polonsky and Keer (1999), Wear 231, 206.
    """
    free = gap < depth
    overlap = np.where(free, depth - np.where(free, gap, 0.0), 0.0)
    if not free.any():
        return np.zeros_like(gap)
    size = float(overlap.max())
    p = np.where(free, start, 0.0)
    if not p.any():
        p = np.where(free, size / float(surface.normal.real.max()), 0.0)
    direction, last, error = np.zeros_like(p), math.inf, math.inf
    for _ in range(_ITERATIONS):
        contact = p > 0
        rest = surface.normal_displacement(p) - overlap
        error = max(float(np.abs(rest[contact]).max(initial=0.0)), -float(rest[free].min()))
        if error <= _TOLERANCE * size:
            return p
        norm = float(np.sum(rest[contact] ** 2))
        direction = np.where(contact, rest + (norm / last if last else 0.0) * direction, 0.0)
        pull = surface.normal_displacement(direction)
        step = (
            float(np.sum((rest * direction)[contact]) / np.sum((pull * direction)[contact])) if norm else 0.0
        )
        p = np.maximum(p - step * direction, 0.0)
        touching = free & (p == 0) & (rest < 0)
        last = norm
        if touching.any():
            p = np.where(touching, p - (step or 1 / float(surface.normal.real.max())) * rest, p)
            last = math.inf
    raise ConvergenceError(
        f"the pressure at {metres(depth)} did not converge: relative residual {error / size:.1e} (limit {_TOLERANCE:g}); use a coarser grid"
    )


def solve_tractions(
    surface: Surface, reference: FloatArray, limit: FloatArray, start: FloatArray
) -> FloatArray:
    """
    Tractions that minimise q C q / 2 - w q under |q| <= limit.

    Parameters
    ----------
    reference : ndarray (2, n, n), m
        w: displacement of a cell without slip.
    limit : ndarray (n, n), Pa
        mu p.
    start : ndarray (2, n, n), Pa
        First iterate.

    Notes
    -----
    Projected gradients with momentum (Beck and Teboulle 2009) and restarts (O'Donoghue and Candes 2015).
    """
    q = ahead = _capped(start, limit)
    size = float(np.abs(reference[:, limit > 0]).max(initial=0.0))
    momentum, error = 1.0, 0.0
    for _ in range(_ITERATIONS):
        slip = reference - surface.tangential_displacement(ahead)
        new = _capped(ahead + slip / surface.stiffest, limit)
        error = surface.stiffest * float(np.abs(new - ahead).max())
        if error <= _TOLERANCE * size:
            return new
        if np.sum((ahead - new) * (new - q)) > 0:
            momentum = 1.0
        following = (1 + math.sqrt(1 + 4 * momentum**2)) / 2
        ahead, q, momentum = new + (momentum - 1) / following * (new - q), new, following
    raise ConvergenceError(
        f"the tractions did not converge: relative residual of slip {error / size:.1e} (limit {_TOLERANCE:g}); use more rows or a coarser grid"
    )


def _capped(q: FloatArray, limit: FloatArray) -> FloatArray:
    """Tractions reduced to their limit, in unchanged directions."""
    size = np.hypot(*q)
    return np.asarray(q * np.where(size > limit, limit / np.where(size > 0, size, 1.0), 1.0))


Mask = NDArray[np.bool_]

_COARSE = 24
_LENGTHS = np.geomspace(1e-16, 1e7, 23 * 16 + 1)
_STUCK = 1e-6
_WEIGHTY = 0.05


@dataclass(frozen=True)
class HalfSpaceGrid:
    """
    Option of ``solve_sliding``: a square of `n` times `n` cells.

    Parameters
    ----------
    n : int
        Cells along each side; at least 8.
    half_width : float, optional, m
        Half the side of the square; by default slightly more than the largest contact radius.

    Raises
    ------
    ProblemError
        If `n` is not a whole number of at least 8, or `half_width` is not finite and above 0.

    Examples
    --------
    >>> HalfSpaceGrid(n=48)
    HalfSpaceGrid(n=48, half_width=None)
    """

    n: int = 32
    half_width: float | None = None

    def __post_init__(self) -> None:
        if isinstance(self.n, bool) or not isinstance(self.n, (int, np.integer)) or self.n < 8:
            raise ProblemError(f"n = {self.n!r}; give a whole number of at least 8")
        if self.half_width is not None and not 0 < self.half_width < math.inf:
            raise ProblemError(f"half_width = {self.half_width!r} m; give a finite length above 0")


@dataclass(frozen=True, eq=False)
class SlidingSolution:
    """
    A history on the grid: one entry per row, and the fields of the last row.

    Attributes
    ----------
    indentation : array (m,), m
    shift : array (m,) or (m, 2), m
    normal_force, tangential_force, transverse_force : array (m,), N
        F_N, and the forces along x and y.
    contact_radius, stick_radius : array (m,), m
        Radii of disks with the area of the cells in contact, and of those below Coulomb's limit.
    x, y : array (n,), m
        Centres of the cells.
    pressure, q_x, q_y : array (n, n), Pa
        Of the last row; x along the first axis.
    largest_slip_angle : float, degrees
        Largest angle between traction and x axis in the last row, among slipping cells with at least 5 % of the
        largest traction; 0 without slip.
    """

    indentation: FloatArray
    shift: FloatArray
    normal_force: FloatArray
    tangential_force: FloatArray
    transverse_force: FloatArray
    contact_radius: FloatArray
    stick_radius: FloatArray
    x: FloatArray
    y: FloatArray
    pressure: FloatArray
    q_x: FloatArray
    q_y: FloatArray
    largest_slip_angle: float


def solve_sliding(
    profile: Profile,
    body: Material,
    counterbody: Material,
    friction: float,
    indentation: ArrayLike,
    shift: ArrayLike,
    grid: HalfSpaceGrid = HalfSpaceGrid(),
    progress: Callable[[int, int], None] | None = None,
) -> SlidingSolution:
    """
    Follow rows of (indentation, shift) from the initial state with vector friction on the grid.

    In each row the tractions minimise q C q / 2 - w q under |q| <= mu p, with w the preceding displacement plus the
    increment of the shift: the slip increment w - C q vanishes below the limit and is parallel to q at the limit.

    Parameters
    ----------
    profile : Profile
        f(r).
    body, counterbody : Elastic, TransverselyIsotropic or Rigid
        At least one elastic. Elastic dissimilarity is neglected: pressure causes no tangential displacement.
    friction : float
        mu, finite and above 0.
    indentation : array_like, shape (m,), m
        Approach d.
    shift : array_like, shape (m,) or (m, 2), m
        Rigid shift along x, or along x and y; the first row is one increment from 0.
    progress : callable, optional
        Called as ``progress(done, total)``.

    Raises
    ------
    ProblemError
        If an argument is outside its limits, or the contact exceeds the cells or the profile.
    PathError
        If the rows are not finite, differ in number, or never touch.
    ConvergenceError
        If residuals exceed 1e-9 of the displacements of a row.

    Notes
    -----
    Polonsky and Keer (1999), Wear 231, 206; Kalker (1990), Three-Dimensional Elastic Bodies in Rolling Contact,
    chapter 4; Beck and Teboulle (2009) and O'Donoghue and Candes (2015) for the iteration. A cell that enters the
    contact takes the full increment of the shift, so growing contacts are of first order in the rows.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic, Rigid
    >>> from pymdr.problem.profiles import Paraboloid
    >>> slid = solve_sliding(Paraboloid(1.0), Elastic(1.0, 0.0), Rigid(), 0.5, [0.01, 0.01], [0.0, 0.02])
    >>> (slid.tangential_force / (0.5 * slid.normal_force)).round(9).tolist()
    [0.0, 1.0]
    """
    d, u = (np.array(v, dtype=float, ndmin=1) for v in (indentation, shift))
    if not 0 < friction < math.inf:
        raise ProblemError(f"friction = {friction!r}; give a finite coefficient above 0")
    if d.ndim != 1 or u.shape not in (d.shape, (*d.shape, 2)) or d.size == 0:
        raise PathError(f"{d.size} indentations and {len(u)} shifts; give equal numbers")
    if not (np.isfinite(d).all() and np.isfinite(u).all()):
        raise PathError("indentation and shift must be finite in every row")
    n, width = int(grid.n), grid.half_width
    if width is None:
        width = _half_width(profile, float(d.max()), n, body, counterbody)
    surface = make_surface(width, n, body, counterbody)
    gap = _gap(profile, surface.x)
    p, q = np.zeros((n, n)), np.zeros((2, n, n))
    displaced, rows = np.zeros_like(q), []
    moves = np.diff(u if u.ndim == 2 else np.stack([u, np.zeros_like(u)], axis=1), axis=0, prepend=0.0)
    for i in range(d.size):
        p = solve_pressure(surface, gap, float(d[i]), p)
        _check_extent(profile, surface, p > 0)
        q = solve_tractions(surface, displaced + moves[i][:, None, None], friction * p, q)
        displaced = surface.tangential_displacement(q)
        rows.append(_row(p, q, friction, surface.side))
        if progress is not None:
            progress(i + 1, d.size)
    force, along, across, contact, stick = np.array(rows).T
    return SlidingSolution(
        indentation=d,
        shift=u,
        normal_force=force,
        tangential_force=along,
        transverse_force=across,
        contact_radius=contact,
        stick_radius=stick,
        x=surface.x,
        y=surface.x.copy(),
        pressure=p,
        q_x=q[0],
        q_y=q[1],
        largest_slip_angle=_largest_angle(p, q, friction),
    )


def _half_width(profile: Profile, depth: float, n: int, body: Material, counterbody: Material) -> float:
    """Half width in m of the grid, from a coarse solution where f < d."""
    limit = min(profile.edge, profile.max_radius)
    known = _LENGTHS[limit > _LENGTHS]
    below = np.flatnonzero(profile.gap(known) < depth)
    if not below.size:
        raise PathError(f"no row touches; give an indentation above the lowest gap, not {metres(depth)}")
    if below[-1] + 1 < known.size:
        bound = _crossing(profile, depth, float(known[below[-1]]), float(known[below[-1] + 1]))
    elif math.isfinite(limit):
        bound = limit
    else:
        raise ProblemError(f"the profile never rises to {metres(depth)}; add FlatPunch(radius) as its end")
    coarse = make_surface(1.01 * bound, _COARSE, body, counterbody)
    p = solve_pressure(coarse, _gap(profile, coarse.x), depth, np.zeros((_COARSE, _COARSE)))
    radius = float(np.hypot(*np.meshgrid(coarse.x, coarse.x))[p > 0].max()) + coarse.side / 2
    return min(radius * (1 + 2.5 / n), 1.01 * bound)


def _crossing(profile: Profile, depth: float, low: float, high: float) -> float:
    while high - low > 1e-6 * high:
        middle = (low + high) / 2
        low, high = (middle, high) if profile.gap(np.array([middle]))[0] < depth else (low, middle)
    return high


def _gap(profile: Profile, x: FloatArray) -> FloatArray:
    f = np.asarray(profile.gap(np.hypot(x[:, None], x)), dtype=float)
    return np.where(np.isnan(f), np.inf, f)


def _check_extent(profile: Profile, surface: Surface, contact: Mask) -> None:
    end, r = surface.x[-1] + surface.side / 2, np.hypot(surface.x[:, None], surface.x)
    widest = float(r[contact].max(initial=0.0))
    if profile.max_radius < profile.edge and widest + surface.side > profile.max_radius:
        raise ProblemError(
            f"the contact extends to {metres(widest)}, the profile to {metres(profile.max_radius)}; "
            "give a smaller indentation or a larger profile"
        )
    outermost = np.concatenate([contact[0], contact[-1], contact[:, 0], contact[:, -1]]).any()
    if outermost and end < profile.edge:
        raise ProblemError(
            f"the contact extends to the last cells at {metres(end)}; give a larger half_width"
        )


def _slipping(p: FloatArray, q: FloatArray, friction: float) -> Mask:
    return np.asarray((p > 0) & (np.hypot(*q) >= (1 - _STUCK) * friction * p))


def _row(p: FloatArray, q: FloatArray, friction: float, side: float) -> tuple[float, ...]:
    cells = np.count_nonzero(p > 0)
    stuck = cells - np.count_nonzero(_slipping(p, q, friction))
    forces = (float(np.sum(field)) * side**2 for field in (p, q[0], q[1]))
    return *forces, side * math.sqrt(cells / math.pi), side * math.sqrt(stuck / math.pi)


def _largest_angle(p: FloatArray, q: FloatArray, friction: float) -> float:
    size = np.hypot(*q)
    selected = _slipping(p, q, friction) & (size >= _WEIGHTY * size.max())
    return math.degrees(float(np.arctan2(np.abs(q[1]), np.abs(q[0]))[selected].max(initial=0.0)))
