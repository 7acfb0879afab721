"""Friction on the half-space by boundary elements: tractions of both directions, Coulomb's law as vectors.

Nothing of the method is used. The surface is a square grid of cells with constant traction; the influence of a
cell is that of Boussinesq and Cerruti integrated over it. Pressure is solved alone (elastic similarity).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ConvergenceError, PathError, ProblemError
from pymdr.problem.materials import Elastic, Material
from pymdr.problem.profiles import Profile
from pymdr.units import FloatArray

_TOLERANCE = 1e-9
_MOST_ITERATIONS = 20_000


@dataclass(frozen=True)
class HalfSpaceGrid:
    """
    A square grid over the contact.

    Parameters
    ----------
    n : int
        Cells along each side, 8 to 80.

    Raises
    ------
    ProblemError
        If `n` is not a whole number from 8 to 80.

    Examples
    --------
    >>> HalfSpaceGrid().n
    32
    """

    n: int = 32

    def __post_init__(self) -> None:
        if isinstance(self.n, bool) or not isinstance(self.n, int) or not 8 <= self.n <= 80:
            raise ProblemError(f"HalfSpaceGrid.n = {self.n!r}; a whole number from 8 to 80 is needed")


@dataclass(frozen=True, eq=False)
class SlidingSolution:
    """What the boundary elements give, one entry per row."""

    indentation: FloatArray
    """d in m."""
    shift: FloatArray
    """Rigid shift along x in m."""
    normal_force: FloatArray
    """F_N in N."""
    tangential_force: FloatArray
    """Force along x in N."""
    transverse_force: FloatArray
    """Force along y in N."""
    contact_radius: FloatArray
    """Radius in m of the disk whose area is that of the cells in contact."""
    stick_radius: FloatArray
    """Radius in m of the disk whose area is that of the cells in contact below Coulomb's limit."""
    slip_angle: FloatArray
    """Angle in degrees between traction and x in slipping cells: its root mean square, weighted by traction."""
    x: FloatArray
    """Centres of the cells along a side in m, shape (n,)."""
    pressure: FloatArray
    """p in the last row in Pa, shape (n, n), x along the first axis."""
    traction: FloatArray
    """Traction (x, y) in the last row in Pa, shape (2, n, n)."""


def influence(x: FloatArray, y: FloatArray, side: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Integrals of x^2/s^3, y^2/s^3 and xy/s^3 over a square cell, s^2 = x^2 + y^2, seen from a distance.

    Parameters
    ----------
    x, y : ndarray
        Position relative to the centre of the cell in m.
    side : float
        Side of the cell in m.

    Returns
    -------
    xx, yy, xy : ndarray
        In m; xx + yy is the integral of 1/s.

    Notes
    -----
    Love (1929); Johnson (1985), sections 3.2 and 3.6.

    Examples
    --------
    >>> xx, yy, xy = influence(np.array([0.0]), np.array([0.0]), 2.0)
    >>> round(float((xx + yy)[0]), 10) == round(8.0 * math.asinh(1.0), 10)
    True
    """
    half = 0.5 * side
    total = [np.zeros(np.broadcast(x, y).shape) for _ in range(3)]
    for i in (1.0, -1.0):
        for j in (1.0, -1.0):
            u, v = x + i * half, y + j * half
            along_u, along_v = _corner(v, u), _corner(u, v)
            for sum_, term in zip(total, (along_u, along_v, -np.hypot(u, v)), strict=True):
                sum_ += i * j * term
    return total[0], total[1], total[2]


def _corner(u: FloatArray, v: FloatArray) -> FloatArray:
    """U asinh(v / |u|), 0 at u = 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(u == 0.0, 0.0, u * np.arcsinh(v / np.abs(u)))


@dataclass(frozen=True)
class _Compliance:
    """Displacements of the cells from their tractions."""

    normal: FloatArray
    tangential: FloatArray
    """Shape (2, 2, n, n)."""


def _compliance(
    x: FloatArray, y: FloatArray, side: float, body: Material, counterbody: Material
) -> _Compliance:
    xx, yy, xy = influence(x[:, None] - x, y[:, None] - y, side)
    elastic = [b for b in (body, counterbody) if isinstance(b, Elastic)]
    straight = sum((1.0 - b.poisson) / (2.0 * math.pi * b.shear) for b in elastic)
    lateral = sum(b.poisson / (2.0 * math.pi * b.shear) for b in elastic)
    plain = straight * (xx + yy)
    cross = lateral * xy
    tangential = np.array([[plain + lateral * xx, cross], [cross, plain + lateral * yy]])
    return _Compliance(plain, tangential)


def solve_sliding(
    profile: Profile,
    body: Material,
    counterbody: Material,
    friction: float,
    indentation: FloatArray,
    shift: FloatArray,
    grid: HalfSpaceGrid | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> SlidingSolution:
    """
    Follow rows of indentation and shift with vector friction on the half-space.

    In every row the tractions minimise q C q / 2 - w q under |q| <= mu p, with w the shift of the row and the
    displacement before it: slip is then against the traction where the limit is reached, and absent elsewhere.

    Parameters
    ----------
    profile : Profile
        f(r).
    body, counterbody : Elastic or Rigid
        Elastically similar, or the coupling of pressure and shear is left out.
    friction : float
        mu, above 0 and finite.
    indentation, shift : array_like, shape (m,)
        d and the shift along x of every row in m; the first is reached from (0, 0).
    grid : HalfSpaceGrid, optional
    progress : callable, optional
        Called as ``progress(done, total)``.

    Returns
    -------
    SlidingSolution

    Raises
    ------
    ProblemError, PathError
        If mu or the rows cannot be used.
    ConvergenceError
        If a row does not converge.

    Notes
    -----
    Kalker (1990) for the variational form; first-order accurate in the size of the rows where the contact grows.

    Examples
    --------
    >>> from pymdr.problem.profiles import Paraboloid
    >>> from pymdr.problem.materials import Rigid
    >>> slid = solve_sliding(Paraboloid(1.0), Elastic(1.0, 0.0), Rigid(), 0.5, [0.01, 0.01], [0.0, 0.02])
    >>> bool(abs(slid.tangential_force[-1] / (0.5 * slid.normal_force[-1]) - 1.0) < 1e-9)
    True
    """
    d, u = (np.atleast_1d(np.asarray(v, dtype=float)) for v in (indentation, shift))
    _check(d, u, friction)
    deepest = float(d.max())
    n = (grid or HalfSpaceGrid()).n
    x, side = _cells(profile, body, counterbody, deepest, n)
    X, Y = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    f = profile.gap(np.hypot(X, Y))
    near = np.flatnonzero(f < deepest)
    compliance = _compliance(X[near], Y[near], side, body, counterbody)
    stiffest = float(np.linalg.eigvalsh(_flat(compliance.tangential))[-1])
    p = np.zeros(near.size)
    q = np.zeros((2, near.size))
    moved = np.zeros((2, near.size))
    before = 0.0
    rows: list[tuple[float, ...]] = []
    for i in range(d.size):
        p = _pressure(compliance.normal, d[i] - f[near], p > 0.0)
        wanted = moved + np.array([[u[i] - before], [0.0]])
        q = _tractions(compliance.tangential, wanted, friction * p, q, stiffest)
        moved = np.einsum("abij,bj->ai", compliance.tangential, q)
        before = float(u[i])
        rows.append(_told(p, q, friction, side))
        if progress is not None:
            progress(i + 1, d.size)
    force, along, across, contact, stick, angle = np.array(rows).T
    pressure, traction = np.zeros(n * n), np.zeros((2, n * n))
    pressure[near], traction[:, near] = p, q
    return SlidingSolution(
        indentation=d,
        shift=u,
        normal_force=force,
        tangential_force=along,
        transverse_force=across,
        contact_radius=contact,
        stick_radius=stick,
        slip_angle=angle,
        x=x,
        pressure=pressure.reshape(n, n),
        traction=traction.reshape(2, n, n),
    )


def _check(d: FloatArray, u: FloatArray, friction: float) -> None:
    if not 0.0 < friction < math.inf:
        raise ProblemError(f"solve_sliding: mu = {friction!r}; it must be above 0 and finite")
    if d.shape != u.shape or d.ndim != 1 or d.size == 0:
        raise PathError(
            f"solve_sliding: {d.size} indentations and {u.size} shifts; as many of each are needed"
        )
    if not (np.all(np.isfinite(d)) and np.all(np.isfinite(u))) or d.max() <= 0.0:
        raise PathError("solve_sliding: the rows must be finite, and some indentation above 0 m")


def _cells(
    profile: Profile, body: Material, counterbody: Material, depth: float, n: int
) -> tuple[FloatArray, float]:
    """Centres and side of the cells of a square that holds the contact at a depth with little to spare."""
    half, coarse = 1.02 * _cut(profile, depth), 20
    for cells, spare in ((coarse, 1.05), (n, 0.0)):
        side = 2.0 * half / cells
        x = -half + side * (np.arange(cells) + 0.5)
        if not spare:
            break
        X, Y = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
        f = profile.gap(np.hypot(X, Y))
        near = np.flatnonzero(f < depth)
        normal = _compliance(X[near], Y[near], side, body, counterbody).normal
        p = _pressure(normal, depth - f[near], np.ones(near.size, dtype=bool))
        widest = float(np.max(np.hypot(X[near], Y[near])[p > 0.0])) + side
        half = min(half, spare * widest)
    return np.asarray(x, dtype=float), side


def _cut(profile: Profile, depth: float) -> float:
    """Radius at which the undeformed profile is as high as a depth; no disk contact passes it."""
    low, high = 0.0, 1.0
    while profile.gap(np.array([high]))[0] < depth:
        high *= 2.0
        if high > 1e6:
            raise ProblemError(
                f"solve_sliding: the profile stays below {depth:g} m, so its contact has no end"
            )
    while high - low > 1e-6 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if profile.gap(np.array([middle]))[0] < depth else (low, middle)
    return high


def _pressure(compliance: FloatArray, overlap: FloatArray, active: np.ndarray) -> FloatArray:
    """Pressure >= 0 with gap >= 0 by an active set."""
    active = (overlap > 0.0) if not active.any() else active & (overlap > 0.0)
    p = np.zeros(overlap.size)
    if not (overlap > 0.0).any():
        return p
    if not active.any():
        active = overlap > 0.0
    for _ in range(200):
        p[:] = 0.0
        index = np.flatnonzero(active)
        p[index] = np.linalg.solve(compliance[np.ix_(index, index)], overlap[index])
        gap = compliance @ p - overlap
        pulled = p < 0.0
        touching = ~active & (gap < -1e-12 * overlap.max())
        if not pulled.any() and not touching.any():
            return p
        active = (active & ~pulled) | touching
    raise ConvergenceError(f"the contact area did not settle ({int(pulled.sum())} cells still pulled)")


def _flat(compliance: FloatArray) -> FloatArray:
    n = compliance.shape[-1]
    return compliance.transpose(0, 2, 1, 3).reshape(2 * n, 2 * n)


def _tractions(
    compliance: FloatArray, wanted: FloatArray, limit: FloatArray, start: FloatArray, stiffest: float
) -> FloatArray:
    """The minimum of q C q / 2 - w q under |q| <= limit, by accelerated projected gradients with restart."""
    index = np.flatnonzero(limit > 0.0)
    answer = np.zeros_like(start)
    if index.size == 0:
        return answer
    matrix = _flat(compliance[:, :, index[:, None], index])
    w = wanted[:, index]
    cap = limit[index]
    q = _capped(start[:, index], cap)
    ahead, momentum = q, 1.0
    size = float(np.max(np.hypot(*w))) or 1.0
    for _ in range(_MOST_ITERATIONS):
        slip = w - (matrix @ ahead.ravel()).reshape(2, -1)
        new = _capped(ahead + slip / stiffest, cap)
        step = new - q
        error = float(np.max(np.abs(new - ahead))) * stiffest
        if error <= _TOLERANCE * size:
            answer[:, index] = new
            return answer
        if float(np.sum((ahead - new) * step)) > 0.0:
            momentum = 1.0
        following = 0.5 * (1.0 + math.sqrt(1.0 + 4.0 * momentum * momentum))
        ahead = new + (momentum - 1.0) / following * step
        q, momentum = new, following
    raise ConvergenceError(f"the tractions did not converge (last residual {error / size:.1e} of the shift)")


def _capped(q: FloatArray, cap: FloatArray) -> FloatArray:
    size = np.hypot(*q)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(size > cap, q * np.where(size > 0.0, cap / size, 0.0), q)


def _told(p: FloatArray, q: FloatArray, friction: float, side: float) -> tuple[float, ...]:
    area = side * side
    size = np.hypot(*q)
    contact = p > 0.0
    slipping = contact & (size >= friction * p * (1.0 - 1e-6))
    angle = 0.0
    if slipping.any():
        off = np.arctan2(np.abs(q[1, slipping]), np.abs(q[0, slipping]))
        angle = math.degrees(math.sqrt(float(np.average(off**2, weights=size[slipping]))))
    stuck = int(np.count_nonzero(contact & ~slipping))
    return (
        float(p.sum() * area),
        float(q[0].sum() * area),
        float(q[1].sum() * area),
        math.sqrt(np.count_nonzero(contact) * area / math.pi),
        math.sqrt(stuck * area / math.pi),
        angle,
    )
