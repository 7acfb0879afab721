"""Compiled groups of springs with memory that move as one. Imported only when a history is followed: it loads numba.

All springs that stay in contact are shortened alike. What a branch of such a spring bears is therefore what it bore when the group
was formed, faded alike, and what all gained alike since: sums over the group follow from sums at first, and a row costs as much
for one spring as for a thousand.
"""

from __future__ import annotations

import math

from pymdr.compiling import compiled
from pymdr.line.memory.kernels import CROSS, DECAY, MEAN, MOVED, OWN, RAMP
from pymdr.units import FloatArray

HELD, STIFFNESS, WIDTH, SQUARED, LEAST, MOST, SINCE = range(7)
"""Of a group: how many springs from the innermost on; the sums of their k, k w and k w^2, the least and the largest w, all when
it was formed; and how far they moved since."""
GROUP = 7
LEFT, GAINED, LOWEST, HIGHEST, BORNE, ENERGY = range(6)
"""Of their branches: h is LEFT times that at first and GAINED; the lowest and highest h, and the sums of k h and k h^2 at first."""
BRANCHES = 6
_EDGE = 16
"""Springs beside an edge, at least, that may change sides while others only move."""


@compiled
def beside(count: int) -> int:
    """How many springs beside an edge may change sides."""
    return max(_EDGE, count // 8)


@compiled
def strays(held: int, count: int) -> bool:
    """Whether the edge of `count` springs has moved so far that another group is better."""
    return count - held > 2 * beside(count) or count - held < beside(count) // 2


@compiled
def join(
    shares: FloatArray,
    n: int,
    held: int,
    w: FloatArray,
    z: FloatArray,
    w_other: FloatArray,
    z_other: FloatArray,
    group: FloatArray,
    branches: FloatArray,
) -> None:
    """Form a group of the first springs, whose state is kept in both places."""
    for i in range(GROUP):
        group[i] = 0.0
    group[HELD], group[LEAST], group[MOST] = max(held, 0), math.inf, -math.inf
    for j in range(n):
        branches[LEFT, j], branches[GAINED, j] = 1.0, 0.0
        branches[LOWEST, j], branches[HIGHEST, j] = math.inf, -math.inf
        branches[BORNE, j], branches[ENERGY, j] = 0.0, 0.0
    for i in range(held):
        share = shares[i]
        group[STIFFNESS] += share
        group[WIDTH] += share * w[i]
        group[SQUARED] += share * w[i] * w[i]
        group[LEAST], group[MOST] = min(group[LEAST], w[i]), max(group[MOST], w[i])
        w_other[i] = w[i]
        for j in range(n):
            h = z[i, j]
            branches[LOWEST, j] = min(branches[LOWEST, j], h)
            branches[HIGHEST, j] = max(branches[HIGHEST, j], h)
            branches[BORNE, j] += share * h
            branches[ENERGY, j] += share * h * h
            z_other[i, j] = h


@compiled
def release(n: int, w: FloatArray, z: FloatArray, group: FloatArray, branches: FloatArray) -> None:
    """Give the springs of a group what they have now."""
    for i in range(int(group[HELD])):
        w[i] += group[SINCE]
        for j in range(n):
            z[i, j] = branches[LEFT, j] * z[i, j] + branches[GAINED, j]
    group[HELD] = 0.0


@compiled
def carry(
    moduli: FloatArray, move: float, group: FloatArray, branches: FloatArray, branch: FloatArray
) -> None:
    """Move a group on over a step whose coefficients are given."""
    group[SINCE] += move
    for j in range(moduli.size):
        branches[LEFT, j] *= branch[j, DECAY]
        branches[GAINED, j] = branch[j, DECAY] * branches[GAINED, j] + branch[j, MEAN] * (moduli[j] * move)


@compiled
def bear(
    body: FloatArray,
    moduli: FloatArray,
    duration: float,
    move: float,
    group: FloatArray,
    branches: FloatArray,
    branch: FloatArray,
) -> tuple[float, float, float, float, float]:
    """The force of a group after a move, how it grows with it, the energy stored then, the work and what dashpots take."""
    all_of, since = group[STIFFNESS], group[SINCE]
    drag = body[1] * move / duration if body[1] > 0.0 and move != 0.0 else 0.0
    stiff = body[0] + (body[1] / duration if body[1] > 0.0 else 0.0)
    width, ahead = group[WIDTH] + all_of * since, since + move
    force, work, lost = body[0] * width, move * (body[0] * (width + 0.5 * move * all_of) + drag * all_of), 0.0
    stored = body[0] * (group[SQUARED] + ahead * (2.0 * group[WIDTH] + ahead * all_of))
    for j in range(moduli.size):
        elastic, left, gained = moduli[j] * move, branches[LEFT, j], branches[GAINED, j]
        first, squares = branches[BORNE, j], branches[ENERGY, j]
        stiff += moduli[j] * branch[j, MEAN]
        borne = left * first + gained * all_of
        squared = left * left * squares + gained * (2.0 * left * first + gained * all_of)
        force += branch[j, DECAY] * borne
        work += move * (branch[j, MEAN] * borne + branch[j, RAMP] * elastic * all_of)
        lost += (
            branch[j, OWN] * squared
            + elastic * (2.0 * branch[j, CROSS] * borne + branch[j, MOVED] * elastic * all_of)
        ) / moduli[j]
        left, gained = branch[j, DECAY] * left, branch[j, DECAY] * gained + branch[j, MEAN] * elastic
        stored += (left * left * squares + gained * (2.0 * left * first + gained * all_of)) / moduli[j]
    rate = stiff * all_of
    return force + rate * move, rate, 0.5 * stored, work, lost + move * drag * all_of
