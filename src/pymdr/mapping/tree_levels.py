"""
Panels combined in pairs, pair by pair, for sums over distant ones: a curve on panels as a tree of source strengths.

Where a kernel is smooth over a node, the integral of the curve times the kernel is the sum of strength times kernel
(Barnes and Hut 1986, with the interpolation of Fong and Darve 2009).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymdr.mapping.slopes import Tail
from pymdr.numerics.panels import TERMS, Panels, Series, basis, clenshaw, nodes, to_coefficients
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

POINTS = 20
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
    """Points as offsets in m, shape (B, POINTS)."""
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
        below = levels[-1]
        place, strengths = _paired(below.base, below.low, below.high, (below.offset, below.strength))
        levels.append(Level(*place, strengths[0]))
    return PanelTree(panels, curve, tuple(levels))


def _leaves(panels: Panels, curve: Series) -> Level:
    """Gauss nodes in the variable of every panel; after a breakpoint the weights contain the power of the offset."""
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


@dataclass(frozen=True)
class TreeLevel:
    """Source strengths of the nodes of one level: level 0 are the panels, a node of a higher level joins two below."""

    base: FloatArray
    low: FloatArray
    high: FloatArray
    offset: FloatArray
    """Points of the strengths of f', as offsets in m, shape (C, n)."""
    slope: FloatArray
    offset_rate: FloatArray
    """Points of the strengths of (r f')'."""
    rate: FloatArray


def with_slope(coefficients: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sums of c_j T_j(2 u - 1) and their derivatives with respect to u, rows of c for rows of u."""
    c = coefficients.T.reshape(-1, u.shape[0], *(1,) * (u.ndim - 1))
    twice = 4.0 * u - 2.0
    value, before, spare = np.zeros_like(u), np.zeros_like(u), np.empty_like(u)
    # a quarter of the derivative
    rate, rate_before = np.zeros_like(u), np.zeros_like(u)
    for j in range(c.shape[0] - 1, 0, -1):
        np.multiply(twice, rate, out=spare)
        spare -= rate_before
        spare += value
        rate, rate_before, spare = spare, rate, rate_before
        np.multiply(twice, value, out=spare)
        spare -= before
        spare += c[j]
        value, before, spare = spare, value, before
    # the last step of Clenshaw halves the argument
    total = c[0] + 0.5 * twice * value - before
    return total, 2.0 * value + 2.0 * twice * rate - 4.0 * rate_before


def with_tail(leaves: TreeLevel, tail: Tail) -> TreeLevel:
    """The leaves with one more, the power law below all panels."""
    s, w = gauss(TERMS, tail.power)
    strength = tail.slope * tail.radius * w[None, :]
    at = tail.radius * s[None, :]
    missing = leaves.rate.shape[1] - TERMS

    def padded(row: FloatArray) -> FloatArray:
        return np.pad(row, ((0, 0), (missing, 0)))

    return TreeLevel(
        np.concatenate([[0.0], leaves.base]),
        np.concatenate([[0.0], leaves.low]),
        np.concatenate([[tail.radius], leaves.high]),
        np.concatenate([at, leaves.offset]),
        np.concatenate([strength, leaves.slope]),
        np.concatenate([padded(at), leaves.offset_rate]),
        np.concatenate([padded((1.0 + tail.power) * strength), leaves.rate]),
    )


def levels_of(leaves: TreeLevel) -> list[TreeLevel]:
    """The leaves and all levels above."""
    levels = [leaves]
    while levels[-1].base.size > 1:
        below = levels[-1]
        sources = (below.offset, below.slope), (below.offset_rate, below.rate)
        place, (slope, rate) = _paired(below.base, below.low, below.high, *sources)
        levels.append(TreeLevel(*place, slope, place[-1], rate))
    return levels


def _paired(
    base: FloatArray, low: FloatArray, high: FloatArray, *sources: tuple[FloatArray, FloatArray]
) -> tuple[tuple[FloatArray, FloatArray, FloatArray, FloatArray], list[FloatArray]]:
    """Origin and ends of parent nodes with their Chebyshev points, and the strengths of sources with given offsets on these."""
    count = base.size
    first, second = np.arange(0, count, 2), np.minimum(np.arange(1, count + 1, 2), count - 1)
    origin, start = base[first], low[first]
    end = (base[second] - origin) + high[second]
    strengths = [np.zeros((first.size, POINTS)) for _ in sources]
    for child, used in ((first, np.ones(first.size, dtype=bool)), (second, second > first)):
        for total, (offset, strength) in zip(strengths, sources, strict=True):
            at = (base[child] - origin)[:, None] + offset[child]
            u = ((at - start[:, None]) / (end - start)[:, None]).clip(0.0, 1.0)
            spread = np.einsum("ij,ijk->ik", strength[child], basis(u, POINTS)) @ to_coefficients(POINTS)
            total += np.where(used[:, None], spread, 0.0)
    return (origin, start, end, start[:, None] + (end - start)[:, None] * nodes(POINTS)), strengths
