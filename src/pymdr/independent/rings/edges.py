"""The pressure next to the edge of a contact zone."""

from __future__ import annotations

import math

import numpy as np

from pymdr.independent.rings.meshes import RingState
from pymdr.independent.rings.surfaces import Array, Zones


def edge_fit(state: RingState, k: int, side: int, sharp: bool = False) -> tuple[float, float]:
    """K and C of p √s = K + C s + ..., s the distance into the contact from a zone edge."""
    mesh, end = state.mesh, state.zones[k][side]
    rings = np.flatnonzero(mesh.panel == mesh.panel[np.searchsorted(mesh.centres, end) - side])
    rings = rings[::-1] if side else rings
    s = np.abs(mesh.centres[rings] - end)
    near = int(np.searchsorted(s, adjacent_width(state.zones, k)[side] / 2))
    count = max(6, min(rings.size // 8, near)) + 3 * sharp
    s, y = s[:count], state.pressure[rings[:count]] * np.sqrt(s[:count])
    first = 3 * sharp
    # at a sharp edge only K needs the correction of the rings
    known = 1 / sharp_correction(s.size) if sharp else np.ones_like(s)
    powers = np.column_stack((known, *((s / s[-1]) ** k for k in (1, 2, 3))))
    fit = np.linalg.lstsq(powers[first:], y[first:])[0]
    return float(fit[0]), float(fit[1] / s[-1])


def adjacent_width(zones: Zones, k: int) -> tuple[float, float]:
    """Smaller of the widths of a zone and of the adjacent hole, for its inner and outer edge."""
    inner, outer = zones[k]
    before = zones[k - 1][1] if k else 0.0
    after = zones[k + 1][0] if k + 1 < len(zones) else math.inf
    return min(outer - inner, inner - before), min(outer - inner, after - outer)


def sharp_correction(n: int) -> Array:
    """Exact over computed pressure of n rings counted from a sharp edge; poor for the first three."""
    return np.asarray(1 + 1 / (12 * (np.arange(n) + 0.5) ** 2), dtype=np.float64)
