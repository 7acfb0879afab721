"""Fretting wear by rings of uniform pressure, solved anew in every block of cycles, without the method."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import ellipkm1

from pymdr.errors import ConvergenceError
from pymdr.independent.torsion import over_rings
from pymdr.units import FloatArray

_TURNS = 200
_SETTLED = 1e-9
_RELAXED, _RELAXATIONS = 0.5, (0.1, 1.0)
"""Relaxation of the slip in the first turn, and its bounds."""
_STAGE = 1.0 - math.sqrt(0.5)
"""Diagonal of the L-stable method of two stages (Alexander 1977)."""


@dataclass(frozen=True)
class WornRings:
    """A worn surface."""

    radii: FloatArray
    """Middles of the rings in m."""
    worn: FloatArray
    """Depth of wear in m, shape (rows, rings)."""
    volume: FloatArray
    """In m^3, shape (rows,)."""
    indentation: FloatArray
    """In m, shape (rows,)."""
    pressure: FloatArray
    """In Pa, shape (rows, rings)."""
    force: FloatArray
    """In N, shape (rows,)."""


def ring_matrix(edges: FloatArray) -> FloatArray:
    """
    Displacement in m at the middles of rings by unit pressure on each, for E* = 1 Pa.

    u(r) = (4/(pi E*)) int p(s) s K(m)/(r + s) ds with m = 4 r s/(r + s)^2.

    Parameters
    ----------
    edges : ndarray, shape (n + 1,)
        Rising radii in m, from 0.

    Notes
    -----
    Timoshenko and Goodier (1951). The shear of equal bodies with nu = 0 has the same kernel.

    Examples
    --------
    >>> edges = np.linspace(0.0, 1.0, 101)
    >>> force = math.pi * np.diff(edges**2) @ np.linalg.solve(ring_matrix(edges), np.ones(100))  # a flat punch
    >>> bool(abs(force / 2.0 - 1) < 6e-3)
    True
    """
    return over_rings(_kernel, edges)


def _kernel(r: FloatArray | float, s: FloatArray) -> FloatArray:
    return np.asarray(4.0 / math.pi * s / (r + s) * ellipkm1(((r - s) / (r + s)) ** 2))


def wear_by_rings(
    edges: FloatArray,
    profile: Callable[[FloatArray], FloatArray],
    moduli: tuple[float, float, float],
    load: tuple[float | None, float | None],
    amplitude: float,
    coefficient: float,
    cycles: FloatArray,
    progress: Callable[[int, int], None] | None = None,
) -> WornRings:
    """
    Wear of a profile on a half-space, in blocks that end at given cycles, each by an implicit method of second order (SDIRK2).

    Parameters
    ----------
    edges : ndarray
        Radii in m between the rings, from 0, beyond the contact.
    profile : callable
        f(r) in m.
    moduli : tuple of float
        E* and G* in Pa, and mu.
    load : tuple
        The indentation in m, or the normal force in N; the other is None.
    amplitude : float
        Of the shift in m.
    coefficient : float
        Archard's, in m^2/N.
    cycles : ndarray
        Ends of blocks.
    progress : callable, optional
        Called with the number of finished blocks and all of them.
    """
    normal, tangential, mu = moduli
    matrix = ring_matrix(edges)
    r, areas = (edges[1:] + edges[:-1]) / 2.0, math.pi * np.diff(edges**2)
    f = np.asarray(profile(r), dtype=float)
    worn, now = np.zeros(r.size), 0.0
    slip = np.zeros(r.size)
    rows = []
    for number, stop in enumerate(np.append(0.0, cycles)):
        weight = _STAGE * coefficient * 4.0 * (stop - now)
        before = worn
        for stage in range(2 if weight > 0.0 else 1):
            relaxed, last = _RELAXED if weight > 0.0 else 1.0, None
            for _ in range(_TURNS):
                p, d = _pressed(matrix / normal, areas, f + before, weight * slip, load)
                rest = _slip(matrix / tangential, mu * p, amplitude) - slip
                if float(np.max(np.abs(rest))) < _SETTLED * amplitude:
                    break
                if last is not None and weight > 0.0:
                    relaxed = _aitken(relaxed, last, rest)
                slip, last = np.maximum(slip + relaxed * rest, 0.0), rest
            else:
                raise ConvergenceError(
                    f"the slip did not converge at {stop:g} cycles; use more rows or another number of rings"
                )
            worn = before + weight * slip * p
            if stage == 0:
                before = before + (1.0 - _STAGE) / _STAGE * (worn - before)
        now = float(stop)
        rows.append((worn, float(areas @ worn), d, p, float(areas @ p)))
        if progress is not None:
            progress(number, cycles.size)
    columns = [np.array([row[i] for row in rows]) for i in range(5)]
    return WornRings(r, *columns)


def _aitken(relaxed: float, last: FloatArray, rest: FloatArray) -> float:
    """The next relaxation by the last two residuals (Irons and Tuck 1969)."""
    change = rest - last
    size = float(change @ change)
    if size == 0.0:
        return relaxed
    low, high = _RELAXATIONS
    return min(max(-relaxed * float(last @ change) / size, low), high)


def _pressed(
    matrix: FloatArray,
    areas: FloatArray,
    gap: FloatArray,
    wear: FloatArray,
    load: tuple[float | None, float | None],
) -> tuple[FloatArray, float]:
    """Pressure and indentation, by the rings in contact: u + f + wear p = d on them."""
    depth, force = load
    inside = gap < (np.quantile(gap, 0.5) if depth is None else depth)
    d = 0.0 if depth is None else depth
    for _ in range(_TURNS):
        n = int(inside.sum())
        system = matrix[np.ix_(inside, inside)] + np.diag(wear[inside])
        p = np.zeros(gap.size)
        if depth is None:
            assert force is not None
            bordered = np.zeros((n + 1, n + 1))
            bordered[:n, :n], bordered[:n, n], bordered[n, :n] = system, -1.0, areas[inside]
            solved = np.linalg.solve(bordered, np.append(-gap[inside], force))
            p[inside], d = solved[:n], float(solved[n])
        else:
            p[inside] = np.linalg.solve(system, d - gap[inside])
        overlap = d - gap - matrix @ p
        new = np.where(inside, p > 0.0, overlap > 1e-12 * abs(d))
        if np.array_equal(new, inside):
            return p, d
        inside = new
    raise ConvergenceError("the contact zone did not converge; use another number of rings")


def _slip(matrix: FloatArray, cap: FloatArray, amplitude: float) -> FloatArray:
    """Slip between rest and a turning point: rings stick where their traction stays below the cap."""
    loaded = cap > 0.0
    stuck = np.zeros(cap.size, dtype=bool)
    for _ in range(_TURNS):
        q = np.where(stuck, 0.0, cap)
        if stuck.any():
            rest = amplitude - matrix[np.ix_(stuck, ~stuck)] @ cap[~stuck]
            q[stuck] = np.linalg.solve(matrix[np.ix_(stuck, stuck)], rest)
        slip = amplitude - matrix @ q
        new = np.where(stuck, q <= cap, slip < 0.0) & loaded
        if np.array_equal(new, stuck):
            return np.where(loaded & ~stuck, np.maximum(slip, 0.0), 0.0)
        # rings that turned back to slip stay there, so that the search ends
        stuck = new
    raise ConvergenceError("the zones of stick and slip did not converge; use another number of rings")
