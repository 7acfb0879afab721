"""A curve on panels as a tree of source strengths, with twice as many panels per node from level to level.

Where a kernel is smooth over a node, the integral of the curve times the kernel is the sum of strength times kernel
(Barnes and Hut 1986, with the interpolation of Fong and Darve 2009).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymdr.numerics.panels import Panels, Series, basis, clenshaw, nodes, to_coefficients
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

NODES = 20
"""Points of every panel and tree node."""
_MAX_ROOTS = 32
"""Largest number of nodes on the top level."""


@dataclass(frozen=True)
class Level:
    """Adjacent tree nodes, of shape (B,)."""

    base: FloatArray
    """Origin of the offsets, a radius in m."""
    low: FloatArray
    high: FloatArray
    offset: FloatArray
    """Points as offsets in m, shape (B, NODES)."""
    strength: FloatArray


@dataclass(frozen=True)
class PanelTree:
    """A curve on panels, and its source strengths; level 0 are the panels."""

    panels: Panels
    curve: Series
    levels: tuple[Level, ...]


def panel_tree(panels: Panels, curve: Series) -> PanelTree:
    """
    The tree of source strengths of a curve.

    Parameters
    ----------
    panels : Panels
        Adjacent panels, shape (P,).
    curve : Series
        On these panels.

    Examples
    --------
    >>> from pymdr.numerics.panels import TERMS
    >>> one = Panels(np.zeros(1), np.zeros(1), np.ones(1), np.zeros(1, dtype=bool))
    >>> leaf = panel_tree(one, Series(np.zeros(1), np.eye(1, TERMS))).levels[0]
    >>> bool(abs((leaf.strength * leaf.offset**2).sum() - 1 / 3) < 1e-15)
    True
    """
    levels = [_leaves(panels, curve)]
    while levels[-1].base.size > _MAX_ROOTS:
        levels.append(_paired(levels[-1]))
    return PanelTree(panels, curve, tuple(levels))


def _leaves(panels: Panels, curve: Series) -> Level:
    """Gauss nodes in the variable of every panel; after a breakpoint the weights contain the power of the offset."""
    s, w = gauss(NODES)
    u, weights = np.tile(s, (panels.count, 1)), np.tile(w, (panels.count, 1))
    n = panels.order
    own = panels.begins & (curve.power != 0.0)
    for power in np.unique(curve.power[own]):
        rows = own & (curve.power == power)
        # d(offset) is n u^(n - 1) du on a rooted panel
        for kind, exponent in ((True, n * power + (n - 1.0)), (False, power)):
            u[rows & (panels.rooted == kind)], weights[rows & (panels.rooted == kind)] = gauss(
                NODES, exponent
            )
    offset = panels.offsets(u)
    stretch = panels.stretch(offset)
    stretch[own] = np.where(panels.rooted, n, 1.0)[own, None] * panels.high[own, None]
    index = np.repeat(np.arange(panels.count), NODES)
    value = clenshaw(curve.coefficients[index], u.ravel()).reshape(u.shape)
    steep = (curve.power != 0.0) & ~own
    value[steep] *= (offset[steep] / panels.high[steep, None]) ** curve.power[steep, None]
    return Level(panels.base, panels.low, panels.high, offset, value * stretch * weights)


def _paired(below: Level) -> Level:
    """Parent nodes, whose strengths are on Chebyshev points."""
    count = below.base.size
    first, second = np.arange(0, count, 2), np.minimum(np.arange(1, count + 1, 2), count - 1)
    base, low = below.base[first], below.low[first]
    high = (below.base[second] - base) + below.high[second]
    strength = np.zeros((first.size, NODES))
    for child, used in ((first, np.ones(first.size, dtype=bool)), (second, second > first)):
        at = (below.base[child] - base)[:, None] + below.offset[child]
        u = ((at - low[:, None]) / (high - low)[:, None]).clip(0.0, 1.0)
        spread = np.einsum("ij,ijk->ik", below.strength[child], basis(u, NODES)) @ to_coefficients(NODES)
        strength += np.where(used[:, None], spread, 0.0)
    return Level(base, low, high, low[:, None] + (high - low)[:, None] * nodes(NODES), strength)
