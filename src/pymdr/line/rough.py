"""Step 2 of a rough surface: springs of any heights, whose F(d), k(d) and U(d) follow from one sort and running sums."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.units import FloatArray

_BLOCK = 1 << 15
"""Number of springs whose sums fit into the cache."""


@dataclass(frozen=True)
class SortedSprings:
    """
    Springs of one stiffness in the order in which a rigid plane touches them; depths d count from the first.

    F(d) is convex and straight between the springs, and these are its corners.
    """

    stiffness: float
    """Stiffness of each spring in N/m."""
    depths: FloatArray
    """Depths in m at which the springs come into contact; rising, from 0."""
    forces: FloatArray
    """F in N at these depths."""
    energies: FloatArray
    """U in J at these depths."""

    def _below(self, depth: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The last spring in contact, the stiffness, and the depth beyond that spring."""
        last = np.maximum(np.searchsorted(self.depths, depth, side="right") - 1, 0)
        return last, self.stiffness * (last + 1.0), np.maximum(depth - self.depths[last], 0.0)

    def force(self, depth: ArrayLike) -> FloatArray:
        """F in N at depths in m; 0 above the first spring."""
        last, k, deeper = self._below(np.asarray(depth, dtype=float))
        return np.asarray(self.forces[last] + k * deeper)

    def normal_stiffness(self, depth: ArrayLike) -> FloatArray:
        """dF/dd in N/m for increasing depths in m."""
        given = np.asarray(depth, dtype=float)
        return np.asarray(np.where(given < 0.0, 0.0, self._below(given)[1]))

    def energy(self, depth: ArrayLike) -> FloatArray:
        """U in J at depths in m."""
        last, k, deeper = self._below(np.asarray(depth, dtype=float))
        return np.asarray(self.energies[last] + (self.forces[last] + 0.5 * k * deeper) * deeper)

    def indentation(self, force: ArrayLike) -> FloatArray:
        """Depths d(F) in m at forces in N from 0 on."""
        given = np.asarray(force, dtype=float)
        last = np.maximum(np.searchsorted(self.forces, given, side="right") - 1, 0)
        return np.asarray(self.depths[last] + (given - self.forces[last]) / (self.stiffness * (last + 1.0)))


def sorted_springs(heights: FloatArray, stiffness: float) -> SortedSprings:
    """
    Sort springs and sum their forces.

    Parameters
    ----------
    heights : ndarray
        Heights in m; the highest is met first.
    stiffness : float
        Of each spring in N/m.

    Notes
    -----
    With the i-th of the depths s, F_(i+1) = F_i + i k (s_(i+1) - s_i) and U_(i+1) = U_i + (F_i + F_(i+1))/2
    (s_(i+1) - s_i): sums of what is not below 0, so that nothing cancels.

    Examples
    --------
    >>> springs = sorted_springs(np.array([0.0, 3.0, 1.0]), 1.0)
    >>> springs.depths.tolist(), springs.forces.tolist(), springs.energies.tolist()
    ([0.0, 2.0, 3.0], [0.0, 2.0, 4.0], [0.0, 2.0, 5.0])
    >>> springs.indentation([1.0, 7.0]).tolist()
    [1.0, 4.0]
    """
    depths = np.negative(heights)
    depths.sort()
    depths -= depths[0]
    n = depths.size
    forces, energies = np.zeros(n), np.zeros(n)
    for start in range(1, n, _BLOCK):
        stop = min(start + _BLOCK, n)
        here, before = slice(start, stop), slice(start - 1, stop - 1)
        steps = depths[here] - depths[before]
        gain = stiffness * np.arange(start, stop) * steps
        gain[0] += forces[start - 1]
        np.cumsum(gain, out=forces[here])
        steps *= 0.5 * (forces[here] + forces[before])
        steps[0] += energies[start - 1]
        np.cumsum(steps, out=energies[here])
    return SortedSprings(stiffness, depths, forces, energies)


def power_law_stiffness(
    force: ArrayLike, hurst: float, rms: float, side: float, modulus: float, constant: float
) -> FloatArray:
    """
    Stiffness of a self-affine square by its power law, k = C/(H + 1) E* L (F/(L h E*))^(1/(1 + H)).

    Parameters
    ----------
    force : array_like
        F in N.
    hurst : float
        H.
    rms, side : float
        h and L in m.
    modulus : float
        E* in Pa.
    constant : float
        C.

    Returns
    -------
    ndarray
        In N/m. The law does not include full contact and needs a spectrum without roll-off.

    Notes
    -----
    Pohrt and Popov (2012), Phys. Rev. Lett. 108, 104301, with C = 1.9412. It integrates to
    F/(L h E*) = [C H d/((H + 1)^2 h)]^((H + 1)/H).

    Examples
    --------
    >>> power_law_stiffness(1.0, 1.0, 1.0, 1.0, 1.0, 2.0).item()
    1.0
    """
    load = np.asarray(force, dtype=float) / (side * rms * modulus)
    return np.asarray(constant / (hurst + 1.0) * modulus * side * load ** (1.0 / (1.0 + hurst)))
