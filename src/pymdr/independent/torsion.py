"""Torsion with Coulomb friction by boundary elements on rings, without the method."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.special import ellipe, ellipkm1

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.units import FloatArray

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_TURNS = 500
"""Largest number of changes of the zones of stick and slip in one row."""


@dataclass(frozen=True)
class TorsionRows:
    """Torsion of a contact along its rows."""

    edges: FloatArray
    """Radii in m between the rings, shape (n + 1,)."""
    torque: FloatArray
    """In N m, shape (rows,)."""
    traction: FloatArray
    """Circumferential traction in Pa, shape (rows, n)."""
    slips: np.ndarray
    """Whether a ring slips in the row, shape (rows, n)."""


def over_rings(
    kernel: Callable[[FloatArray | float, FloatArray], FloatArray], edges: FloatArray
) -> FloatArray:
    """Integrals over rings of a kernel with a logarithm at s = r, at the middles r of all rings, shape (n, n)."""
    r = (edges[1:] + edges[:-1]) / 2.0
    half = (_NODES + 1.0) / 2.0
    low, width = edges[:-1, None], np.diff(edges)[:, None]
    s, weights = low + width * half, width * _WEIGHTS / 2.0
    matrix = np.array([np.sum(kernel(x, s) * weights, axis=1) for x in r])
    # the ring of the point itself: a logarithm at s = r
    own = np.zeros(r.size)
    for end, sense in ((edges[1:] - r, 1.0), (r - edges[:-1], -1.0)):
        near = r[:, None] + sense * end[:, None] * half**2
        own += np.sum(kernel(r[:, None], near) * half * end[:, None] * _WEIGHTS, axis=1)
    matrix[np.diag_indices(r.size)] = own
    return matrix


def torsion_matrix(edges: FloatArray) -> FloatArray:
    """
    Circumferential displacement in m at the middles of rings by unit traction on each, for G = 1 Pa.

    u(r) = (1/G) int tau(s) s int J1(k r) J1(k s) dk ds, and int J1 J1 dk = Q_(1/2)((r^2 + s^2)/(2 r s)) / (pi sqrt(r s)).

    Parameters
    ----------
    edges : ndarray, shape (n + 1,)
        Rising radii in m, from 0.

    Notes
    -----
    Sneddon (1966), Mixed Boundary Value Problems in Potential Theory; Q_(1/2) by complete elliptic integrals.

    Examples
    --------
    >>> edges = np.linspace(0.0, 1.0, 101)
    >>> traction = np.linalg.solve(torsion_matrix(edges), (edges[1:] + edges[:-1]) / 2)  # of a disk that turns by 1 rad
    >>> torque = traction @ (2 * math.pi / 3 * np.diff(edges**3))
    >>> bool(abs(torque / (16 / 3) - 1) < 6e-3)
    True
    """
    return over_rings(_kernel, edges)


def _kernel(r: FloatArray | float, s: FloatArray) -> FloatArray:
    z = (r * r + s * s) / (2.0 * r * s)
    modulus = 2.0 * np.sqrt(r * s) / (r + s)
    rest = ((r - s) / (r + s)) ** 2
    q = z * modulus * ellipkm1(rest) - 2.0 / modulus * ellipe(1.0 - rest)
    return np.asarray(s * q / (math.pi * np.sqrt(r * s)))


def follow_torsion(
    edges: FloatArray,
    limit: Callable[[float], FloatArray],
    shear: float,
    depths: Sequence[float],
    twists: Sequence[float],
    entries: FloatArray,
    parts: int = 16,
) -> TorsionRows:
    """
    Follow a history of indentation and twist by rings that stick or slip.

    Parameters
    ----------
    edges : ndarray, shape (n + 1,)
        Radii in m between the rings, from 0 to beyond the largest contact.
    limit : callable
        Largest traction mu p in Pa, mean over every ring, at an indentation in m; 0 outside the contact.
    shear : float
        G in Pa; 1/G is the sum over both bodies.
    depths, twists : sequence of float
        Rows of indentation in m and twist in rad, straight between them from 0.
    entries : ndarray, shape (n,)
        Indentation in m at which the contact reaches the inner border of every ring.
    parts : int
        Parts of every row in which the indentation changes. Where the twist changes too, parts also end where a ring comes into contact:
        it is moved by the rest of the row only.
    """
    if len(depths) != len(twists):
        raise ProblemError(f"{len(depths)} indentations and {len(twists)} twists; give equal numbers")
    r = (edges[1:] + edges[:-1]) / 2.0
    compliance = torsion_matrix(edges) / shear
    arms = 2.0 * math.pi / 3.0 * np.diff(edges**3)
    tau, at, turned = np.zeros(r.size), 0.0, 0.0
    tractions, slips = [], []
    for depth, twist in zip(depths, twists, strict=True):
        fractions = np.linspace(0.0, 1.0, parts + 1) if depth != at else np.array([0.0, 1.0])
        if depth > at and twist != turned:
            entering = (entries[(entries > at) & (entries < depth)] - at) / (depth - at)
            fractions = np.union1d(fractions, entering)
        zones = np.zeros(r.size)
        for before, now in pairwise(fractions):
            most = limit(at + (depth - at) * now)
            tau, zones = _advanced(compliance, tau, most, r * (twist - turned) * (now - before))
        at, turned = depth, twist
        tractions.append(tau)
        slips.append(np.abs(zones) == 1.0)
    table = np.array(tractions)
    return TorsionRows(edges, table @ arms, table, np.array(slips))


def _advanced(
    compliance: FloatArray, tau: FloatArray, most: FloatArray, shift: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Tractions after a small move, and 0 for rings that stick, 1 or -1 for those that slip, 2 outside the contact."""
    target = compliance @ tau + shift
    zones = np.where(most > 0.0, 0.0, 2.0)
    for _ in range(_TURNS):
        sticks = zones == 0.0
        tau = np.where(np.abs(zones) == 1.0, zones * most, 0.0)
        if sticks.any():
            left = (target - compliance @ tau)[sticks]
            tau[sticks] = np.linalg.solve(compliance[np.ix_(sticks, sticks)], left)
        slip = target - compliance @ tau
        new = zones.copy()
        new[sticks & (np.abs(tau) > most * (1.0 + 1e-12))] = np.sign(tau)[
            sticks & (np.abs(tau) > most * (1.0 + 1e-12))
        ]
        new[(zones == 1.0) & (slip < 0.0)] = 0.0
        new[(zones == -1.0) & (slip > 0.0)] = 0.0
        if np.array_equal(new, zones):
            return tau, zones
        zones = new
    raise ConvergenceError(
        f"the zones of stick and slip did not converge within {_TURNS} iterations; use more parts"
    )
