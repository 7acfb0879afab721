"""A curve on panels as charges at nodes, in bunches of twice as many panels from level to level.

The integral of the curve times a kernel is the sum of charge times kernel, where the kernel is smooth over the bunch
(Barnes and Hut 1986, with the interpolation of Fong and Darve 2009).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymdr.numerics.panels import Panels, Series, basis, clenshaw, nodes, to_coefficients
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

POINTS = 20
"""Nodes of every panel and bunch."""
_FEW = 32
"""Bunches that are not bunched any more."""


@dataclass(frozen=True)
class Level:
    """Bunches side by side, of shape (B,)."""

    base: FloatArray
    """Radius in m from which offsets are counted."""
    low: FloatArray
    high: FloatArray
    offset: FloatArray
    """Nodes as offsets in m, shape (B, POINTS)."""
    charge: FloatArray


@dataclass(frozen=True)
class Bunches:
    """A curve on panels, and its charges: level 0 are the panels."""

    panels: Panels
    curve: Series
    levels: tuple[Level, ...]


def bunched(panels: Panels, curve: Series) -> Bunches:
    """
    The charges of a curve.

    Parameters
    ----------
    panels : Panels
        Side by side, shape (P,).
    curve : Series
        On these panels.

    Returns
    -------
    Bunches

    Examples
    --------
    >>> from pymdr.numerics.panels import TERMS
    >>> one = Panels(np.zeros(1), np.zeros(1), np.ones(1), np.zeros(1, dtype=bool))
    >>> leaf = bunched(one, Series(np.zeros(1), np.eye(1, TERMS))).levels[0]
    >>> bool(abs((leaf.charge * leaf.offset**2).sum() - 1 / 3) < 1e-15)
    True
    """
    levels = [_leaves(panels, curve)]
    while levels[-1].base.size > _FEW:
        levels.append(_paired(levels[-1]))
    return Bunches(panels, curve, tuple(levels))


def _leaves(panels: Panels, curve: Series) -> Level:
    """Gauss nodes in the variable of every panel; behind a breakpoint the power of the offset is in the weights."""
    s, w = gauss(POINTS)
    u, weights = np.tile(s, (panels.count, 1)), np.tile(w, (panels.count, 1))
    n = panels.order
    own = panels.begins & (curve.power != 0.0)
    for power in np.unique(curve.power[own]):
        rows = own & (curve.power == power)
        # d(offset) is n u^(n - 1) du on a rooted panel
        for kind, exponent in ((True, n * power + (n - 1.0)), (False, power)):
            u[rows & (panels.rooted == kind)], weights[rows & (panels.rooted == kind)] = gauss(
                POINTS, exponent
            )
    offset = panels.offsets(u)
    stretch = panels.stretch(offset)
    stretch[own] = np.where(panels.rooted, n, 1.0)[own, None] * panels.high[own, None]
    index = np.repeat(np.arange(panels.count), POINTS)
    value = clenshaw(curve.coefficients[index], u.ravel()).reshape(u.shape)
    steep = (curve.power != 0.0) & ~own
    value[steep] *= (offset[steep] / panels.high[steep, None]) ** curve.power[steep, None]
    return Level(panels.base, panels.low, panels.high, offset, value * stretch * weights)


def _paired(below: Level) -> Level:
    """Bunches of two, whose charges sit on Chebyshev points."""
    count = below.base.size
    first, second = np.arange(0, count, 2), np.minimum(np.arange(1, count + 1, 2), count - 1)
    base, low = below.base[first], below.low[first]
    high = (below.base[second] - base) + below.high[second]
    charge = np.zeros((first.size, POINTS))
    for child, used in ((first, np.ones(first.size, dtype=bool)), (second, second > first)):
        at = (below.base[child] - base)[:, None] + below.offset[child]
        u = ((at - low[:, None]) / (high - low)[:, None]).clip(0.0, 1.0)
        spread = np.einsum("ij,ijk->ik", below.charge[child], basis(u, POINTS)) @ to_coefficients(POINTS)
        charge += np.where(used[:, None], spread, 0.0)
    return Level(base, low, high, low[:, None] + (high - low)[:, None] * nodes(POINTS), charge)
