"""Panels combined in pairs, pair by pair, for sums over distant ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymdr.mapping.slopes import Tail
from pymdr.numerics.panels import (
    TERMS,
    basis,
    nodes,
    to_coefficients,
)
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

POINTS = 20
"""Interpolation points of a tree node."""


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
        levels.append(_paired(levels[-1]))
    return levels


def _paired(below: TreeLevel) -> TreeLevel:
    """Parent nodes, whose strengths are on Chebyshev points."""
    count = below.base.size
    first, second = np.arange(0, count, 2), np.minimum(np.arange(1, count + 1, 2), count - 1)
    alone = second == first
    base = below.base[first]
    low = below.low[first]
    high = (below.base[second] - base) + below.high[second]
    made = [np.zeros((first.size, POINTS)) for _ in range(2)]
    for child, used in ((first, np.ones(first.size, dtype=bool)), (second, ~alone)):
        for k, (where, strength) in enumerate(((below.offset, below.slope), (below.offset_rate, below.rate))):
            at = (below.base[child] - base)[:, None] + where[child]
            u = ((at - low[:, None]) / (high - low)[:, None]).clip(0.0, 1.0)
            spread = np.einsum("ij,ijk->ik", strength[child], basis(u, POINTS)) @ to_coefficients(POINTS)
            made[k] += np.where(used[:, None], spread, 0.0)
    offset = low[:, None] + (high - low)[:, None] * nodes(POINTS)
    return TreeLevel(base, low, high, offset, made[0], offset, made[1])
