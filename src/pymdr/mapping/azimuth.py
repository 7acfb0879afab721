"""Bodies that are not axisymmetric: their azimuthal mean, and integrals along their rays."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache, singledispatch

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem import profiles
from pymdr.units import FloatArray, metres, shown

_FEWEST_DIRECTIONS, _MOST_DIRECTIONS = 32, 256
_SAME = 1e-11
"""Relative difference of two means at convergence."""
_PER_STEP = 32
_SPACING = math.log(4.0) / _PER_STEP
"""Spacing of the radii of a table, in their logarithm."""
_FEWEST_NODES, _MOST_NODES = 32, 512
_SAME_INTEGRAL = 1e-7
_AT_ONCE = 200_000
"""Largest number of points in one evaluation of a gap."""


def azimuthal_mean(shape: profiles.Shape) -> profiles.Profile:
    """
    The mean over all directions, <f>(r) = int f(r cos phi, r sin phi) dphi / (2 pi).

    The force of this axisymmetric profile at a depth is a lower bound of that of the shape: the pressure of a flat disk does the
    same work on both gaps, and of all trial areas the true one carries the largest force.

    Parameters
    ----------
    shape : Shape
        A body that is not axisymmetric; it must not tilt.

    Raises
    ------
    ProblemError
        If it is not a shape, or its grid is too small about the apex.

    Notes
    -----
    Shield (1967), J. Appl. Math. Phys. 18, 682-693; Barber (1974), Int. J. Eng. Sci. 12, 813-819.

    Examples
    --------
    >>> from pymdr import EllipticParaboloid
    >>> round(azimuthal_mean(EllipticParaboloid(3.0, 1.0)).radius, 15)
    1.5
    """
    if not isinstance(shape, profiles.Shape):
        raise ProblemError(f"{shown(shape)} is not a body with a gap f(x, y), such as Pyramid.vickers()")
    return _mean_of(shape)


@singledispatch
def _mean_of(shape: profiles.Shape) -> profiles.Profile:
    raise ProblemError(f"no mean of {type(shape).__name__}; give it as Function2D(shape.gap_at)")


@_mean_of.register
def _(shape: profiles.EllipticParaboloid) -> profiles.Profile:
    low, high = sorted((shape.radius_x, shape.radius_y))
    return profiles.Paraboloid(2.0 * low / (1.0 + low / high))


@_mean_of.register
def _(shape: profiles.Pyramid) -> profiles.Profile:
    sector = math.pi / shape.sides
    return profiles.Cone(slope=shape.gradient * math.sin(sector) / sector)


@_mean_of.register
@lru_cache(maxsize=64)
def _(shape: profiles.Function2D) -> profiles.Profile:
    chosen, _change = _converged(shape)
    return profiles.Function(lambda r: _mean_at(shape, r, chosen), max_radius=shape.max_radius)


def mean_error(shape: profiles.Shape) -> float:
    """Largest relative change of the azimuthal mean of a callable by the last doubling of its directions; 0 for others."""
    return _converged(shape)[1] if isinstance(shape, profiles.Function2D) else 0.0


@lru_cache(maxsize=64)
def _converged(shape: profiles.Function2D) -> tuple[int, float]:
    """Number of directions of the mean, and its relative change by the last doubling."""
    radii: FloatArray = np.logspace(-12.0, 0.0, 13)
    if math.isfinite(shape.max_radius):
        radii = shape.max_radius * np.array([1e-3, 1e-2, 0.1, 0.3, 0.6, 0.9])
    directions, change = _FEWEST_DIRECTIONS, math.inf
    _refuse_saddle(shape, radii)
    now = _mean_at(shape, radii, directions)
    while directions < _MOST_DIRECTIONS and change > _SAME:
        directions, before = 2 * directions, now
        now = _mean_at(shape, radii, directions)
        with np.errstate(divide="ignore", invalid="ignore"):
            change = float(np.nanmax(np.abs(now - before) / np.abs(now), initial=0.0))
    return directions, change


def _refuse_saddle(shape: profiles.Function2D, radii: FloatArray) -> None:
    """Refuse a gap that is below its apex at all distances."""
    phi = _directions(_FEWEST_DIRECTIONS)
    gap = shape.gap_at(radii[:, None] * np.cos(phi), radii[:, None] * np.sin(phi))
    gap = gap[np.isfinite(gap).all(axis=1)]
    nonzero = gap[np.abs(gap).max(axis=1) > 0.0] if gap.size else gap
    if nonzero.size and np.all(nonzero.min(axis=1) < -1e-6 * np.abs(nonzero).max(axis=1)):
        where = math.degrees(phi[int(np.argmin(nonzero[0]))])
        raise ProblemError(
            f"in the direction of {where:.3g} degrees the gap is below that at x = y = 0; the apex must be the lowest point "
            "of the gap: put the origin at the apex, and give a gap that increases away from it"
        )
    if not gap.size:
        raise ProblemError(
            "the gap is not finite on any circle about x = y = 0 with a radius from 1e-12 m to 1 m; it must be finite there"
            if math.isinf(shape.max_radius)
            else f"the gap is not finite on circles about x = y = 0 within max_radius = {metres(shape.max_radius)}"
        )


def _mean_at(shape: profiles.Shape, r: FloatArray, directions: int) -> FloatArray:
    phi = _directions(directions)
    x, y = r[:, None] * np.cos(phi), r[:, None] * np.sin(phi)
    return np.asarray(shape.gap_at(x, y).mean(axis=1))


@_mean_of.register
@lru_cache(maxsize=64)
def _(shape: profiles.Sampled2D) -> profiles.Profile:
    step = float(np.min(shape.spacing))
    count = int(shape.max_radius / step * (1.0 + 1e-12))
    if count < 4:
        raise ProblemError(
            f"the apex is {count} pixels from the edge of the grid; at least 4 are needed for a mean over directions"
        )
    radius: FloatArray = step * np.arange(count + 1, dtype=float)
    directions = 2 ** math.ceil(math.log2(max(64.0, 8.0 * math.pi * count)))
    rows = max(1, _AT_ONCE // directions)
    parts = [_mean_at(shape, radius[i : i + rows], directions) for i in range(0, radius.size, rows)]
    return profiles.Sampled(radius, np.concatenate(parts), interpolation=profiles.ShapePreserving())


def _directions(count: int) -> FloatArray:
    """Angles of a mean over directions; kinks that fall on whole steps do not harm it."""
    # where the error of the trapezoidal rule at a kink, B_2 of its place between two angles, is 0
    return np.asarray(2.0 * math.pi * (np.arange(count) + 0.5 - math.sqrt(1.0 / 12.0)) / count)


@dataclass(frozen=True)
class RayTable:
    """P(a, phi) = int_0^(pi/2) f(a sin t, phi) sin t dt, of which int_0^a g_phi dx = a P, as splines over ln a: of ln P if all P > 0."""

    low: float
    """ln a of the first radius."""
    coefficients: FloatArray
    """Of the cubic segments, (4, segments, directions), highest power first."""
    logarithmic: bool
    """Whether they are of ln P, which is straight for powers."""
    gap: FloatArray
    """F in m at the ends of the segments, (segments + 1, directions)."""
    error: float
    """Of P, relative: its change by the last doubling of nodes, and an eighth of that by the doubling of radii."""

    @property
    def directions(self) -> int:
        """Number of rays."""
        return int(self.coefficients.shape[2])

    @property
    def nodes(self) -> FloatArray:
        """Ln a of the ends of the segments."""
        return np.asarray(self.low + _SPACING * np.arange(self.coefficients.shape[1] + 1))

    def half(self) -> RayTable:
        """The table of every other ray."""
        return replace(self, coefficients=self.coefficients[:, :, ::2], gap=self.gap[:, ::2])

    def at(self, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """
        P, dP/ds and d2P/ds2 at s = ln a.

        Parameters
        ----------
        s : ndarray
            (..., directions).
        """
        segment = np.clip(((s - self.low) / _SPACING).astype(int), 0, self.coefficients.shape[1] - 1)
        x = s - self.low - _SPACING * segment
        c3, c2, c1, c0 = self.coefficients[:, segment, np.arange(self.directions)]
        value = ((c3 * x + c2) * x + c1) * x + c0
        first, second = (3.0 * c3 * x + 2.0 * c2) * x + c1, 6.0 * c3 * x + 2.0 * c2
        if self.logarithmic:
            value = np.exp(value)
            first, second = value * first, value * (second + first * first)
        return value, first, second


@lru_cache(maxsize=32)
def ray_table(shape: profiles.Shape, first: int, last: int, directions: int) -> RayTable | None:
    """
    The table of a shape for radii from 4^first to 4^last m, as far as all rays are known.

    Returns
    -------
    RayTable or None
        None where fewer than a handful of radii are known.

    Notes
    -----
    Without derivatives of f, from int_0^a g dx = int_0^a r f(r) / sqrt(a^2 - r^2) dr.
    """
    from scipy.interpolate import CubicSpline

    low = first * math.log(4.0)
    radii = np.exp(low + _SPACING * np.arange(_PER_STEP * (last - first) + 1))
    radii = radii[radii <= shape.max_radius * (1.0 + 1e-12)]
    phi = _directions(directions)
    few = radii[:: max(1, radii.size // 12)], phi[:: max(1, directions // 16)]
    nodes, error = _FEWEST_NODES, math.inf
    now = _integrals(shape, *few, nodes)
    while nodes < _MOST_NODES and error > _SAME_INTEGRAL:
        nodes, before = 2 * nodes, now
        now = _integrals(shape, *few, nodes)
        with np.errstate(invalid="ignore"):
            change = np.abs(now - before) / np.abs(now).max(axis=1, keepdims=True)
        error = float(np.nanmax(change, initial=0.0))
    values = _integrals(shape, radii, phi, nodes)
    unknown = np.flatnonzero(~np.isfinite(values).all(axis=1))
    values = values[: unknown[0]] if unknown.size else values
    if values.shape[0] < 8:
        return None
    lowest = float(values.min())
    if lowest < -1e-6 * float(values.max()):
        where = np.unravel_index(int(np.argmin(values)), values.shape)
        raise ProblemError(
            f"in the direction of {math.degrees(phi[where[1]]):.3g} degrees the gap is below that at x = y = 0 "
            f"within {metres(float(radii[where[0]]))}; the apex must be the lowest point of the gap: put the origin at the apex"
        )
    s = low + _SPACING * np.arange(values.shape[0])
    logarithmic = lowest > 0.0
    values = np.log(values) if logarithmic else values
    between = CubicSpline(s[::2], values[::2], axis=0)(s[1:-1:2]) - values[1:-1:2]
    size = 1.0 if logarithmic else values[1:-1:2] + 1e-12 * values[-1]
    error += float(np.max(np.abs(between) / size)) / 8.0
    r = np.exp(s)[:, None]
    gap = shape.gap_at(r * np.cos(phi), r * np.sin(phi))
    return RayTable(low, CubicSpline(s, values, axis=0).c, logarithmic, gap, error)


def _integrals(shape: profiles.Shape, radii: FloatArray, phi: FloatArray, nodes: int) -> FloatArray:
    """P at (radii, directions)."""
    sine, weights = _panels(nodes)
    r = np.multiply.outer(sine, radii)  # (nodes, radii)
    cos, sin = np.cos(phi), np.sin(phi)
    answer = np.empty((radii.size, phi.size))
    block = max(1, _AT_ONCE // max(1, r.size))
    for i in range(0, phi.size, block):
        rays = slice(i, i + block)
        gap = shape.gap_at(r[..., None] * cos[rays], r[..., None] * sin[rays])
        answer[:, rays] = np.einsum("t,trp->rp", weights * sine, gap)
    return answer


@lru_cache(maxsize=8)
def _panels(nodes: int) -> tuple[FloatArray, FloatArray]:
    """Sin t and the weights of dt from 0 to pi/2, on panels of 16 nodes."""
    x, weights = np.polynomial.legendre.leggauss(16)
    count = nodes // 16
    t = (np.arange(count)[:, None] + 0.5 * (x + 1.0)) * (0.5 * math.pi / count)
    return np.sin(t.ravel()), np.tile(0.25 * math.pi / count * weights, count)


def mean_over_ellipses(shape: profiles.Shape, ellipse: FloatArray, along: int, around: int) -> float:
    """
    The mean of a gap under the pressure of a flat elliptic punch, 1 / (2 pi a b sqrt(1 - rho^2)) for a unit of force.

    Parameters
    ----------
    shape : Shape
    ellipse : ndarray
        Centre x, y and semi-axes a, b in m, and the direction of the first in rad.
    along, around : int
        Nodes; `along` is a multiple of 16.

    Returns
    -------
    float
        In m; nan where the gap is not known.
    """
    x, y, a, b, angle = ellipse
    sine, weights = _panels(along)
    phi = _directions(around)
    u, v = a * np.multiply.outer(sine, np.cos(phi)), b * np.multiply.outer(sine, np.sin(phi))
    cos, sin = math.cos(angle), math.sin(angle)
    gap = shape.gap_at(x + u * cos - v * sin, y + u * sin + v * cos)
    return float((weights * sine) @ gap.mean(axis=1))


def ray_slopes(shape: profiles.Shape, radius: float) -> FloatArray:
    """
    Magnitudes of the gradient of a gap within a radius in m, on a polar grid, by central differences.

    Returns
    -------
    ndarray
        nan where the gap is not known.
    """
    step = 1e-3 * radius
    if isinstance(shape, profiles.Sampled2D):
        step = max(step, float(np.max(shape.spacing)))
    r, phi = np.meshgrid(np.linspace(0.02, 1.0, 40) * radius, _directions(64))
    x, y = r * np.cos(phi), r * np.sin(phi)
    along = (shape.gap_at(x + step, y) - shape.gap_at(x - step, y)) / (2.0 * step)
    across = (shape.gap_at(x, y + step) - shape.gap_at(x, y - step)) / (2.0 * step)
    return np.asarray(np.hypot(along, across))
