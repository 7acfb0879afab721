"""Checks of contacts on layers: whether they are disks, and whether a layer stays on its base."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pymdr.interpretation.fields import line_gap, pressure
from pymdr.interpretation.validity import Assumption
from pymdr.line.adhesion.short_range import jkr_opening
from pymdr.line.layered import LayeredLine
from pymdr.mapping.layers import Compliance
from pymdr.units import FloatArray, metres

_INSIDE = 1.0 - 0.5 ** np.arange(0.0, 16.0, 0.5)
"""Radii inside a contact at which its pressure is checked, over the contact radius."""
_OUTSIDE = 0.5 ** np.arange(-2.0, 14.0, 0.5)
"""Distances from the edge at which the gap is checked, over the contact radius and over the thickness."""
_TOLERANCE = 1e-9
"""Relative to the mean pressure and to the depth."""
_LIFTING = 0.01
"""Largest acceptable tension under a frictionless layer, over the largest pressure there."""


@dataclass(frozen=True)
class Fault:
    """The first contact that is not a disk."""

    before: float
    """Radius in m of the largest checked contact before it."""
    description: str


def first_fault(
    line: LayeredLine, widest: float, excess: float = 0.0, work: float | None = None
) -> Fault | None:
    """
    The first tabulated radius at which the disk is not the solution.

    Parameters
    ----------
    widest : float
        Largest contact radius in m.
    excess : float
        Largest depth in m beyond that of the smooth contact, at a sharp edge.
    work : float, optional
        Work of adhesion in J/m^2, which stretches the edge; without it the pressure must not be negative.

    Notes
    -----
    At a sharp edge the pressure is linear in the excess, so tension is checked only at the smallest and the largest excess.
    """
    if not widest > 0.0:
        return None
    bounds = line.table.bounds(widest)
    end = min(line.edge, line.max_radius)
    radii = bounds[(bounds > 0.05 * line.thickness) | (bounds >= widest)]
    before = float(bounds[0])
    for a in radii[: int(np.searchsorted(radii, widest)) + 1]:
        radius = float(min(a, end, widest))
        text = _fault_at(line, radius, excess if radius == line.edge else 0.0, work)
        if text:
            return Fault(before, text)
        before = radius
    return None


@lru_cache(maxsize=256)
def _fault_at(line: LayeredLine, a: float, excess: float, work: float | None) -> str:
    depth, force, stiffness, _ = line.smooth(a)
    if work is None:
        r = a * _INSIDE
        for pressed in {0.0, excess}:
            p, mean = pressure(line, a, pressed, r), (force + pressed * stiffness) / (math.pi * a * a)
            if float(np.min(p)) < -_TOLERANCE * mean:
                return (
                    f"a disk of radius {metres(a)} would need tension at r = {metres(r[int(np.argmin(p))])}"
                )
    if a >= line.edge:
        return ""
    excess = 0.0 if work is None else -float(jkr_opening(line, a, work))
    beyond = a + np.unique(np.concatenate([a * _OUTSIDE, line.thickness * _OUTSIDE]))
    beyond = beyond[beyond < min(line.max_radius, line.edge)]
    springs, pressed, _ = line.carried(a, excess)
    if beyond.size:
        gap = line_gap(springs.equivalent, a, pressed, beyond)
        if float(np.min(gap)) < -_TOLERANCE * (depth + abs(excess)):
            where = beyond[int(np.argmin(gap))]
            return f"the surfaces touch again outside a disk of radius {metres(a)}, at r = {metres(where)}"
    return ""


def base_assumption(line: LayeredLine, a: float, excess: float) -> tuple[Assumption, ...]:
    """
    The assumption that layers sliding on their base stay on it: the largest tension at the base in one contact.

    Parameters
    ----------
    a, excess : float
        Contact radius and d - d0 at its edge in m.

    Returns
    -------
    tuple of Assumption
        One, of two such bodies that with the larger tension; none for bonded layers.

    Notes
    -----
    s(r) = int_0^inf k J0(k r) P(k) S(kh) dk, P(k) = (1/pi) int_0^a q(x) cos(kx) dx, with the transmission S of a wave.
    """
    sliding = [one for one in line.kernel.compliance.stacks if one.body.bond == "frictionless"]
    if not sliding or not a > 0.0:
        return ()
    return (
        Assumption(
            "contact of the base",
            "largest tension at the base over the largest pressure; a frictionless layer must not lift off",
            max(_lifting(line, one, a, excess) for one in sliding),
            _LIFTING,
        ),
    )


def _lifting(line: LayeredLine, stack: Compliance, a: float, excess: float) -> float:
    from scipy.special import j0

    h, depth = stack.thickness, stack.body.thickness
    x, loads = line.line_load(a, excess)
    r = np.concatenate(
        [np.linspace(0.0, a + 8.0 * depth, 129), a + np.linspace(-1.0, 1.0, 33) * min(a, depth)]
    )
    # waves shorter than the layers hardly reach the base
    top = 40.0 / depth
    panels = 8 + math.ceil(top * (2.0 * a + 8.0 * depth) / 20.0)
    nodes, weights = np.polynomial.legendre.leggauss(24)
    half = 0.5 * top / panels
    k = (half * (2.0 * np.arange(panels)[:, None] + 1.0 + nodes)).ravel()
    waves: FloatArray = k * stack.pressed_through(k * h) * np.tile(half * weights, panels)
    stress = np.zeros(r.shape)
    for i in range(0, k.size, 4096):
        part = slice(i, i + 4096)
        stress += j0(np.outer(r, k[part])) @ (waves[part] * (np.cos(np.outer(k[part], x)) @ loads))
    tension, largest = -float(np.min(stress)), float(np.max(stress))
    if not tension > 0.0:
        return 0.0
    return tension / largest if largest > 0.0 else math.inf
