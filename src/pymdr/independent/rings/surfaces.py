"""Elastic surfaces of the ring solver, and the displacement of a half-space by rings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from pymdr.errors import ProblemError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Gap = Callable[[Array], ArrayLike]
Zones = tuple[tuple[float, float], ...]


class Surface(Protocol):
    """An elastic surface under rings of pressure."""

    @property
    def bulges(self) -> bool:
        """Whether it may rise outside a pressure, so that contact may lie where f > d."""

    @property
    def softness(self) -> float:
        """Upper bound of its compliance relative to the half-space of E*."""

    def displacement(self, r: ArrayLike, edges: ArrayLike) -> Array:
        """Displacement in m at `r` (k,) by unit pressure on each ring of `edges` (n + 1,), for E* = 1: (k, n)."""


@dataclass(frozen=True)
class HalfSpace:
    """The homogeneous elastic half-space."""

    bulges = False
    softness = 1.0

    def displacement(self, r: ArrayLike, edges: ArrayLike) -> Array:
        """As :func:`ring_displacement`."""
        return ring_displacement(r, edges)


HALF_SPACE = HalfSpace()


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
    r, a = np.atleast_1d(valid_radii(r))[:, None], np.atleast_1d(valid_radii(edges))
    if r.ndim != 2 or a.ndim != 1 or a.size < 2 or not np.all(np.diff(a) > 0):
        raise ProblemError(
            "ring_displacement needs a one-dimensional array of radii and at least two increasing edges."
        )
    block = max(1, 2**18 // a.size)  # bounds the memory of the temporaries
    return np.vstack([_rings(r[i : i + block], a) for i in range(0, max(r.size, 1), block)])


def _rings(r: Array, a: Array) -> Array:
    large, small = np.maximum(r, a), np.minimum(r, a)
    size = np.where(large > 0, large, 1.0)
    rest = (large - small) / size * ((large + small) / size)
    K = scipy.special.ellipkm1(np.where(rest > 0, rest, 1.0))
    beyond = large * (_excess(rest, K) - np.where(r > a, rest * K, 0.0))
    return np.asarray(4 / np.pi * (np.diff(large, axis=1) + np.diff(beyond, axis=1)), dtype=np.float64)


def _excess(c: Array, K: Array) -> Array:
    """E(1 - c) - 1 for K = K(1 - c); where c is small, without cancellation by Legendre's relation."""
    excess = np.asarray(scipy.special.ellipe(1 - c) - 1, dtype=np.float64)
    near = c < 0.1
    order = np.arange(1, 16)
    terms = np.pi / 2 * np.cumprod(((2 * order - 1) / (2 * order)) ** 2)
    x = c[near]
    k = x * np.polynomial.polynomial.polyval(x, terms)  # K(c) - π/2
    difference = x * np.polynomial.polynomial.polyval(x, terms * 2 * order / (2 * order - 1))  # K(c) - E(c)
    excess[near] = (difference * K[near] - k) / (np.pi / 2 + k)
    return excess


def valid_radii(r: ArrayLike) -> Array:
    """Radii as an array; negative or infinite ones are refused."""
    r = np.asarray(r, dtype=np.float64)
    if not np.all(np.isfinite(r) & (r >= 0)):
        raise ProblemError("Radii must be finite and not negative.")
    return r
