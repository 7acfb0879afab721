"""Measures of a cycle of stress at points: smallest balls of deviators, shear and normal stresses of planes.

The first axis of a cycle holds its rows, the second the components xx, yy, zz, xz, xy, yz, the last the points.
"""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.interpretation.tensors import principal_stresses
from pymdr.units import FloatArray

DEVIATORS = np.array(
    [
        [1.0 / math.sqrt(2.0), -1.0 / math.sqrt(2.0), 0.0, 0.0, 0.0, 0.0],
        [-1.0 / math.sqrt(6.0), -1.0 / math.sqrt(6.0), 2.0 / math.sqrt(6.0), 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, math.sqrt(2.0), 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, math.sqrt(2.0), 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, math.sqrt(2.0)],
    ]
)
"""From components to a vector whose length is the norm of the deviator."""
_OUTSIDE = 1e-12
"""Of the radius: how far a point may lie outside a ball that encloses it."""
_PIVOTS = 200
"""Changes of the points that carry a smallest ball."""


def smallest_ball(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """
    The smallest ball that encloses points.

    Parameters
    ----------
    points : ndarray, shape (n, k, m)
        n points in k dimensions, m times.

    Returns
    -------
    centre, radius : ndarray, shapes (k, m) and (m,)

    Notes
    -----
    A ball is carried by at most k + 1 points. The point farthest from its centre replaces some of them until none lies outside; each
    change enlarges the ball, so that the sequence ends (Gaertner 1999).

    References
    ----------
    Gaertner (1999), Fast and robust smallest enclosing balls, Lecture Notes in Computer Science 1643, 325-338.

    Examples
    --------
    >>> corners = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 2.0], [1.0, 1.0]])[:, :, None]
    >>> centre, radius = smallest_ball(corners)
    >>> centre[:, 0].round(12).tolist(), round(float(radius[0]) ** 2, 12)
    ([2.0, 1.0], 5.0)
    """
    count, _, times = points.shape
    size = np.max(np.abs(points), axis=(0, 1), initial=0.0)
    p = points / np.where(size > 0.0, size, 1.0)
    every = np.arange(times)
    # from the first to its farthest, and to the farthest from that
    far = np.argmax(np.sum((p - p[:1]) ** 2, axis=1), axis=0)
    other = np.argmax(np.sum((p - p[far, :, every].T) ** 2, axis=1), axis=0)
    carriers = [np.unique(pair) for pair in np.stack([far, other], axis=1)]
    centre = 0.5 * (p[far, :, every] + p[other, :, every])
    square = np.sum((p[far, :, every] - centre) ** 2, axis=1)
    left = every
    for _ in range(_PIVOTS):
        distance = np.sum((p[:, :, left] - centre[left].T) ** 2, axis=1)
        farthest = np.argmax(distance, axis=0)
        outside = distance[farthest, np.arange(left.size)] > square[left] * (1.0 + _OUTSIDE) + _OUTSIDE**2
        left, farthest = left[outside], farthest[outside]
        if left.size == 0:
            radius = np.sqrt(np.max(np.sum((p - centre.T) ** 2, axis=1), axis=0)) if count else square
            return centre.T * size, radius * size
        sizes = np.array([carriers[i].size for i in left])
        for k in np.unique(sizes):
            some = left[sizes == k]
            rows = np.concatenate([np.array([carriers[i] for i in some]), farthest[sizes == k, None]], axis=1)
            kept, centre[some], square[some] = _carried(p[rows, :, some[:, None]])
            for i, row, mask in zip(some, rows, kept, strict=True):
                carriers[i] = row[mask]
    raise ConvergenceError(
        f"the search for the smallest sphere around {count} deviatoric stresses did not converge in {_PIVOTS} iterations; omit rows of the cycle whose stresses are nearly equal"
    )


def _carried(points: FloatArray) -> tuple[np.ndarray, FloatArray, FloatArray]:
    """The smallest balls around a few points each, shape (m, q, k), the last of which lies on the ball: carriers, centres, squared radii."""
    times, q, k = points.shape
    last = points[:, -1]
    relative = points[:, :-1] - last[:, None]
    gram = np.einsum("mik,mjk->mij", relative, relative)
    best = np.full(times, math.inf)
    centre, kept = last.copy(), np.zeros((times, q), dtype=bool)
    kept[:, -1] = True
    for number in range(1, min(q - 1, k) + 1):
        for subset in combinations(range(q - 1), number):
            chosen = gram[:, subset][:, :, subset]
            diagonal = np.einsum("mii->mi", chosen)
            weight = _solved(2.0 * chosen, diagonal)
            middle = np.einsum("mi,mik->mk", weight, relative[:, subset])
            square = np.sum(middle**2, axis=1)
            away = np.max(np.sum((relative - middle[:, None]) ** 2, axis=2), axis=1)
            # the weights of all carriers of a smallest ball are positive
            good = (away <= square * (1.0 + 0.5 * _OUTSIDE)) & (square < best) & np.isfinite(square)
            good &= (weight >= -1e-9).all(axis=1) & (weight.sum(axis=1) <= 1.0 + 1e-9)
            best = np.where(good, square, best)
            centre[good] = last[good] + middle[good]
            kept[good, :-1] = False
            kept[np.ix_(good, subset)] = True
    return kept, centre, best


def _solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Solutions of small systems; nan where they are singular."""
    scale = np.einsum("mii->m", matrix)[:, None, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        scaled = matrix / scale
        singular = ~(np.abs(np.linalg.det(scaled)) > 1e-300)
    scaled[singular] = np.eye(matrix.shape[1])
    solution = np.linalg.solve(scaled, right[:, :, None] / np.where(scale > 0.0, scale, 1.0))[:, :, 0]
    solution[singular] = np.nan
    return np.asarray(solution)


def dang_van(cycle: FloatArray, slope: float) -> tuple[FloatArray, FloatArray]:
    """
    Dang Van's measure and the plane of the largest shear stress at its instant.

    Parameters
    ----------
    cycle : ndarray, shape (n, 6, m)
        Stress in Pa over the rows of a cycle at m points.
    slope : float
        Weight of the mean normal stress.

    Returns
    -------
    value, plane : ndarray, shapes (m,) and (3, m)
        In Pa, and the unit normal of one of the two planes.

    Notes
    -----
    Dang Van, Griveau and Message (1989).

    Examples
    --------
    >>> wave = np.zeros((3, 6, 1))
    >>> wave[:, 0, 0] = [0.0, 300.0, -300.0]  # tension and compression: tau_a = 150, p_h = 100
    >>> round(float(dang_van(wave, 0.5)[0][0]), 9)
    200.0
    """
    points = cycle.shape[2]
    centre, _ = smallest_ball(np.einsum("dc,ncm->ndm", DEVIATORS, cycle))
    deviator = cycle.copy()
    mean = cycle[:, :3].mean(axis=1)
    deviator[:, :3] -= mean[:, None]
    deviator -= np.einsum("dc,dm->cm", DEVIATORS / np.sum(DEVIATORS**2, axis=0).clip(1.0), centre)
    principal = principal_stresses(np.moveaxis(deviator, 0, 1))
    value = 0.5 * (principal[0] - principal[2]) + slope * mean
    instant = np.argmax(value, axis=0)
    tensors = deviator[instant, :, np.arange(points)].T
    return value[instant, np.arange(points)], shear_planes(tensors)


def shear_planes(tensor: FloatArray) -> FloatArray:
    """
    The unit normal of a plane with the largest shear stress.

    Parameters
    ----------
    tensor : ndarray, shape (6, m)

    Returns
    -------
    ndarray, shape (3, m)
        With z at least 0.
    """
    xx, yy, zz, xz, xy, yz = tensor
    whole = np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), -1, 0)
    axes = np.linalg.eigh(whole)[1]
    return upward(((axes[:, :, 0] + axes[:, :, 2]) / math.sqrt(2.0)).T)


def upward(normal: FloatArray) -> FloatArray:
    """Normals of planes with z above 0, or x above 0, or y above 0; both signs are one plane."""
    x, y, z = normal
    sign = np.where(z != 0.0, np.sign(z), np.where(x != 0.0, np.sign(x), np.sign(y)))
    return np.asarray(normal * np.where(sign == 0.0, 1.0, sign))


def normal_stress(cycle: FloatArray, plane: FloatArray) -> FloatArray:
    """The normal stress on planes in Pa, tension positive, shape (n, m)."""
    return np.asarray(np.einsum("ncm,cm->nm", cycle, stress_factors(plane, plane)))


def shear_amplitude(cycle: FloatArray, plane: FloatArray) -> FloatArray:
    """
    Half of the largest distance of two shear stress vectors on planes in Pa, shape (m,).

    Examples
    --------
    >>> wave = np.zeros((2, 6, 1))
    >>> wave[1, 0, 0] = 4.0
    >>> round(float(shear_amplitude(wave, np.array([[1.0], [0.0], [1.0]]) / np.sqrt(2.0))[0]), 12)
    1.0
    """
    one, two = in_plane(plane)
    first = np.einsum("ncm,cm->nm", cycle, stress_factors(plane, one))
    second = np.einsum("ncm,cm->nm", cycle, stress_factors(plane, two))
    square = np.zeros(first.shape[1])
    for lag in range(1, first.shape[0]):
        distances = (first[lag:] - first[:-lag]) ** 2 + (second[lag:] - second[:-lag]) ** 2
        square = np.maximum(square, distances.max(axis=0))
    return np.asarray(0.5 * np.sqrt(square))


def in_plane(plane: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors in planes, at right angles, each of shape (3, m)."""
    axis = np.eye(3)[np.argmin(np.abs(plane), axis=0)].T
    one = np.cross(plane, axis, axis=0)
    one /= np.linalg.norm(one, axis=0)
    return one, np.cross(plane, one, axis=0)


def stress_factors(one: FloatArray, other: FloatArray) -> FloatArray:
    """The factors of the components of a stress in one . stress . other, shape (6, m)."""
    return np.array(
        [
            one[0] * other[0],
            one[1] * other[1],
            one[2] * other[2],
            one[0] * other[2] + one[2] * other[0],
            one[0] * other[1] + one[1] * other[0],
            one[1] * other[2] + one[2] * other[1],
        ]
    )
