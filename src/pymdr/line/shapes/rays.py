"""The estimate of the force of any shape, from its sections along rays."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from pymdr.line.shapes.base import BELOW, ShapeLaw, ShapeStates
from pymdr.mapping.azimuth import RayTable, ray_table
from pymdr.numerics.roots import boundary
from pymdr.problem.profiles import Shape
from pymdr.units import FloatArray

BoolArray = NDArray[np.bool_]
LONGEST_OUTLINE = 5.0
"""Longest over shortest radius of the outline of the estimate at that ratio."""
_ROWS = 16
"""Number of depths that are solved at once."""
_AROUND = 16.0
"""Radii of a table from the disk of the bound inwards, and half as far outwards."""
_FEWEST_RAYS, _MOST_RAYS = 64, 256
_SAME_FORCE = 1e-5
_CLEAR = 1.3
"""Distance over the radius of the outline from which on the surface must be free."""
_FAR, _FAR_RAYS, _FAR_RADII = 64.0, 512, 400
"""Search for other summits: distance over the radius of the outline, and number of places."""
_PER_DISTORTION, _PER_ELONGATION = 0.75, 0.2
"""Relative error of the estimate per deviation of its outline from an ellipse, and per fourth power of its
elongation."""
_MOST_DISTORTED = 0.3
"""Distortion of an outline up to which the estimate was measured."""
_MAX_DECREASE = 1e-3
"""Largest decrease of the mean image of a section per unit of ln a that counts as rising, relative to the mean."""
_WITHIN = 1e-9
"""Tolerance of a bracket of less than one unit of ln a; the error of the force is its square."""


@dataclass(frozen=True)
class RayLaw(ShapeLaw):
    """
    The estimate F = 2 E* oint (d a^2 - a int_0^a g_phi dx) dphi / oint a dphi, stationary in the outline a(phi).

    g_phi is the image of the section in the direction phi, as if it were of revolution. Stationary means 2 d a - int g_phi - a
    g_phi(a) = F / (2 E*) in every direction, of whose roots the larger one is taken; where there is none, the turning point.

    Notes
    -----
    From reciprocity (Shield 1967), the maximum of the force over trial areas (Barber 1974) and Fabrikant's stiffness of a flat
    punch 4 E* A / oint a dphi; Popov (2022), Symmetry 14, 390, names these ingredients.
    """

    shape: Shape
    known: ClassVar = False

    def at(self, depth: FloatArray, radius: FloatArray) -> ShapeStates:
        """States at depths in m, given the radii in m of the disks of the lower bound."""
        rows = np.flatnonzero((depth > 0.0) & (radius > 0.0) & np.isfinite(radius))
        values = np.full((6, depth.size), math.nan)
        values[:, ~(depth > 0.0)] = 0.0
        if rows.size:
            _, first, of_depth = np.unique(depth[rows], return_index=True, return_inverse=True)
            values[:, rows] = self._solved(depth[rows][first], radius[rows][first])[:, of_depth.ravel()]
        force, stiffness, longest, clipped, stretch, error = values
        known = ~(stretch > LONGEST_OUTLINE) & np.isfinite(force)
        force, stiffness = np.where(known, force, math.nan), np.where(known, stiffness, math.nan)
        energy = np.full(force.shape, math.nan)
        return ShapeStates(force, stiffness, energy, force, error, longest, clipped)

    def _solved(self, depth: FloatArray, radius: FloatArray) -> FloatArray:
        first = math.floor(math.log(float(radius.min()) / _AROUND, 4.0))
        last = math.ceil(math.log(float(radius.max()) * 0.5 * _AROUND, 4.0))
        rays = _FEWEST_RAYS
        while True:
            table = ray_table(self.shape, first, last, rays)
            if table is None:
                return np.full((6, depth.size), math.nan)
            ends = np.unique([int(np.argmin(depth)), int(np.argmax(depth))])
            fine, coarse = (_stationary(one, depth[ends])[0] for one in (table, table.half()))
            change = float(np.nanmax(np.abs(fine - coarse) / fine, initial=0.0))
            if rays >= _MOST_RAYS or change <= max(_SAME_FORCE, table.error):
                break
            rays *= 2
        parts = [_stationary(table, depth[i : i + _ROWS]) for i in range(0, depth.size, _ROWS)]
        whole = np.concatenate(parts, axis=1)
        on_rays = np.repeat(np.log(radius)[:, None], table.directions, axis=1)
        disk = 2.0 * radius * (depth - table.at(on_rays)[0].mean(axis=1))
        # stationary outlines that run over a second summit bear less than a disk, which no body does
        wrong = whole[0] < disk * (1.0 - BELOW - change - table.error)
        whole[:, wrong | _others_touch(self.shape, depth, whole[2], whole[0])] = math.nan
        whole[5] += change + table.error
        return whole


def _stationary(table: RayTable, depth: FloatArray) -> FloatArray:
    """Force, stiffness, longest radius, fraction of directions without a root, stretch of the outline and model error, for E* = 1."""
    s, d = table.nodes, depth[:, None]
    radii = np.exp(s)
    on_nodes = np.broadcast_to(s[:, None], (s.size, table.directions))
    p, dp, _ = table.at(on_nodes)
    # Q = 2 d a - (a int g)' over (rows, radii, rays)
    q = 2.0 * d[:, :, None] * radii[:, None] - radii[:, None] * (2.0 * p + dp)
    # no contact goes beyond where the gap first is the depth, behind which another part of the body may begin
    within = np.logical_and.accumulate(table.gap < d[:, :, None], axis=1)
    top = np.argmax(np.where(within, q, -math.inf), axis=1)
    inside = ((top > 0) & (top < s.size - 1)).all(axis=1)
    top = np.clip(top, 1, s.size - 2)

    def q_at(at: FloatArray) -> FloatArray:
        p, dp, _ = table.at(at)
        return np.asarray(np.exp(at) * (2.0 * (d - p) - dp))

    def q_above(level: FloatArray, at: FloatArray) -> FloatArray:
        return q_at(at) - level

    def rise_at(at: FloatArray) -> FloatArray:
        p, dp, ddp = table.at(at)
        return np.asarray(2.0 * (d - p) - 3.0 * dp - ddp)

    turning = _crossing(rise_at, s[top - 1], s[top + 1])
    highest = q_at(turning)
    level = np.zeros(depth.size)
    at, first = turning, top
    beyond = np.arange(s.size)[:, None] > top[:, None, :]
    for _ in range(60):
        before = level
        a = np.exp(at)
        mean = a.mean(axis=1)
        level = (a * a * (d - table.at(at)[0])).mean(axis=1) / mean
        if np.all(np.abs(level - before)[inside] <= 1e-13 * np.abs(level[inside])):
            break
        below = beyond & (q < level[:, None, None])
        ends = below.any(axis=1)
        first = np.argmax(below, axis=1)
        root = _crossing(partial(q_above, level[:, None]), turning, s[np.maximum(first, 1)])
        at = np.where(highest <= level[:, None], turning, root)
        inside &= ends.all(axis=1)
        level = np.where(inside, level, before)
    else:
        # noise lets roots jump, by which the force changes less than by the noise itself
        inside &= np.abs(level - before) <= max(1e-9, table.error) * np.abs(level)
    a = np.exp(at)
    inside &= ~_touches_beyond(table, depth, a, 2.0 * level)
    values = np.array(
        [
            2.0 * level,
            2.0 * (a * a).mean(axis=1) / a.mean(axis=1),
            a.max(axis=1),
            (highest <= level[:, None]).mean(axis=1),
            a.max(axis=1) / a.min(axis=1),
            np.where(_images_rise(table, a), model_error(a), math.nan),
        ]
    )
    values[:, ~inside] = math.nan
    return values


def model_error(outline: FloatArray) -> FloatArray:
    """
    Relative error of the estimate of :class:`RayLaw` from its outline, for contacts without holes.

    It is 0 to the second order for ellipses, and grows with the squares of the other waves of a(phi) = a0 (1 + sum h_n cos(n phi -
    phi_n)): 0.75 sum |n - 2| h_n^2 / 2 + 0.2 h_2^4.

    Parameters
    ----------
    outline : ndarray
        Radii in m, (rows, directions), evenly spaced.

    Returns
    -------
    ndarray
        nan where the sum is above 0.3, up to which it was measured.

    Notes
    -----
    Measured by boundary elements on 120 random bodies: polygonal ones of 3 to 24 faces, sharp and rounded, and smooth ones that are
    homogeneous, polynomials, long or lobed. Their errors were at most 0.43 times the sum, besides 0.1 h_2^4.

    Examples
    --------
    >>> phi = 2 * np.pi * np.arange(64) / 64
    >>> float(model_error(1 + 0.2 * np.cos(3 * phi[None]))[0].round(9))
    0.015
    """
    wave = np.abs(np.fft.rfft(outline, axis=1))
    height = 2.0 * wave[:, 1:] / wave[:, :1]
    n = np.arange(1, wave.shape[1])
    distortion = 0.5 * (np.abs(n - 2) * height**2).sum(axis=1)
    error = _PER_DISTORTION * distortion + _PER_ELONGATION * height[:, 1] ** 4
    return np.where(distortion <= _MOST_DISTORTED, error, math.nan)


def _images_rise(table: RayTable, outline: FloatArray) -> BoolArray:
    """Whether the images of all sections rise up to the outline: where one falls, the contact may have holes."""
    s = np.broadcast_to(table.nodes[:, None], (table.nodes.size, table.directions))
    p, dp, ddp = table.at(s)
    decreasing = dp + ddp < -_MAX_DECREASE * np.abs(p)
    inside = np.exp(s) < outline[:, None, :]
    return np.asarray(~(decreasing & inside).any(axis=(1, 2)))


def _touches_beyond(table: RayTable, depth: FloatArray, outline: FloatArray, force: FloatArray) -> BoolArray:
    """
    Whether another part of the body may touch: outside the outline its gap is less than d - F / (pi E* r).

    Around a round contact the surface sinks by no less than around a force at its centre, so that no summit is missed; across a
    long one it sinks by somewhat less.
    """
    r = np.exp(table.nodes)
    far = r[:, None] > _CLEAR * outline[:, None, :]
    left = depth[:, None] - force[:, None] / (math.pi * r)
    return np.asarray((far & (table.gap < left[:, :, None])).any(axis=(1, 2)))


def _others_touch(shape: Shape, depth: FloatArray, outline: FloatArray, force: FloatArray) -> BoolArray:
    """The same farther away and on more rays than those of the table: other summits are narrow from afar."""
    touches = np.zeros(depth.shape, dtype=bool)
    known = np.flatnonzero(np.isfinite(outline) & (outline > 0.0))
    if known.size == 0:
        return touches
    phi = 2.0 * math.pi * np.arange(_FAR_RAYS)[:, None] / _FAR_RAYS
    r = np.geomspace(float(outline[known].min()), _FAR * float(outline[known].max()), _FAR_RADII)
    gap = shape.gap_at(r * np.cos(phi), r * np.sin(phi))
    below = gap < depth[known].max()
    r, gap = np.broadcast_to(r, gap.shape)[below], gap[below]
    for row in known:
        far = r > _CLEAR * outline[row]
        touches[row] = bool(np.any(gap[far] < depth[row] - force[row] / (math.pi * r[far])))
    return touches


def _crossing(falling: Callable[[FloatArray], FloatArray], low: FloatArray, high: FloatArray) -> FloatArray:
    """The sign change of a function that decreases from low to high."""
    return boundary(lambda x: falling(x) > 0.0, low, high, _WITHIN)[0]
