"""Compiled groups of springs with memory that move as one. Imported only when a history is followed: it loads numba.

All springs that stay in contact are shortened alike. What a branch of such a spring bears is therefore what it bore when the group
was formed, faded alike, and what all gained alike since: sums over the group follow from sums at first, and a row costs as much
for one spring as for a thousand.
"""

from __future__ import annotations

import math

import numpy as np

from pymdr.compiling import inner
from pymdr.line.memory.kernels import (
    CROSS,
    DECAY,
    MEAN,
    MODULUS,
    MOVED,
    OWN,
    RAMP,
    SHARE,
    SOFT,
    Body,
    Move,
    stiffness,
)
from pymdr.line.memory.modes import BORNE, FREE, REST, TURN, W
from pymdr.units import FloatArray

ALL = 0
"""The row of a group that tells of all its springs; row j + 1 tells of their branch j."""
HELD, STIFFNESS, WIDTH, SQUARED, LEAST, MOST, SINCE = range(7)
"""Of a group: how many springs from the innermost on; the sums of their k, k w and k w^2, the least and the largest w, all when
it was formed; and how far they moved since."""
LEFT, GAINED, LOWEST, HIGHEST, LOADED, ENERGY = range(6)
"""Of their branches: h is LEFT times that at first and GAINED; the lowest and highest h, and the sums of k h and k h^2 at first."""
_EDGE = 16
"""Springs beside an edge, at least, that may change sides while others only move."""


def no_group(body: Body) -> FloatArray:
    """A group of no springs."""
    return np.zeros((1 + body.branches.shape[0], SINCE + 1))


@inner
def beside(count: int) -> int:
    """How many springs beside an edge may change sides."""
    return max(_EDGE, count // 8)


@inner
def strays(held: int, count: int) -> bool:
    """Whether the edge of `count` springs has moved so far that another group is better."""
    return count - held > 2 * beside(count) or count - held < beside(count) // 2


@inner
def join(springs: FloatArray, count: int, state: FloatArray, other: FloatArray, group: FloatArray) -> None:
    """Form a group of the first springs but those next to the edge of `count`; their state is kept in both places."""
    held, n = max(count - beside(count), 0), group.shape[0] - 1
    stiff, width, squared, least, most = 0.0, 0.0, 0.0, math.inf, -math.inf
    for j in range(1, n + 1):
        group[j, LEFT], group[j, GAINED], group[j, LOADED], group[j, ENERGY] = 1.0, 0.0, 0.0, 0.0
        group[j, LOWEST], group[j, HIGHEST] = math.inf, -math.inf
    for i in range(held):
        share, w = springs[SHARE, i], state[i, W]
        stiff += share
        width += share * w
        squared += share * w * w
        least, most = min(least, w), max(most, w)
        state[i, TURN] = 0.0
        other[i, W], other[i, FREE], other[i, REST], other[i, TURN] = w, state[i, FREE], state[i, REST], 0.0
        for j in range(n):
            h = state[i, BORNE + j]
            group[j + 1, LOWEST] = min(group[j + 1, LOWEST], h)
            group[j + 1, HIGHEST] = max(group[j + 1, HIGHEST], h)
            group[j + 1, LOADED] += share * h
            group[j + 1, ENERGY] += share * h * h
            other[i, BORNE + j] = h
    group[ALL, HELD], group[ALL, STIFFNESS], group[ALL, WIDTH], group[ALL, SQUARED] = (
        held,
        stiff,
        width,
        squared,
    )
    group[ALL, LEAST], group[ALL, MOST], group[ALL, SINCE] = least, most, 0.0


@inner
def release(state: FloatArray, group: FloatArray) -> None:
    """Give the springs of a group what they have now."""
    for i in range(int(group[ALL, HELD])):
        state[i, W] += group[ALL, SINCE]
        for j in range(1, group.shape[0]):
            state[i, BORNE + j - 1] = group[j, LEFT] * state[i, BORNE + j - 1] + group[j, GAINED]
    group[ALL, HELD] = 0.0


@inner
def carry(body: Body, way: float, group: FloatArray, branch: FloatArray) -> None:
    """Move a group on over a step whose coefficients are given."""
    group[ALL, SINCE] += way
    for j in range(branch.shape[0]):
        group[j + 1, LEFT] *= branch[j, DECAY]
        group[j + 1, GAINED] = branch[j, DECAY] * group[j + 1, GAINED] + branch[j, MEAN] * (
            body.branches[j, MODULUS] * way
        )


@inner
def bear(
    body: Body, move: Move, group: FloatArray, branch: FloatArray
) -> tuple[float, float, float, float, float]:
    """The force of a group after a move, how it grows with it, the energy stored then, the work and what dashpots take."""
    way, drag, branches = move.way, move.drag, body.branches
    all_of, since = group[ALL, STIFFNESS], group[ALL, SINCE]
    width, ahead = group[ALL, WIDTH] + all_of * since, since + way
    force = body.equilibrium * width
    work, lost = way * (body.equilibrium * (width + 0.5 * way * all_of) + drag * all_of), way * drag * all_of
    stored = body.equilibrium * (group[ALL, SQUARED] + ahead * (2.0 * group[ALL, WIDTH] + ahead * all_of))
    for j in range(branch.shape[0]):
        elastic, left, gained = branches[j, MODULUS] * way, group[j + 1, LEFT], group[j + 1, GAINED]
        first, squares = group[j + 1, LOADED], group[j + 1, ENERGY]
        borne = left * first + gained * all_of
        squared = left * left * squares + gained * (2.0 * left * first + gained * all_of)
        force += branch[j, DECAY] * borne
        work += way * (branch[j, MEAN] * borne + branch[j, RAMP] * elastic * all_of)
        lost += (
            branch[j, OWN] * squared
            + elastic * (2.0 * branch[j, CROSS] * borne + branch[j, MOVED] * elastic * all_of)
        ) * branches[j, SOFT]
        left, gained = branch[j, DECAY] * left, branch[j, DECAY] * gained + branch[j, MEAN] * elastic
        stored += (left * left * squares + gained * (2.0 * left * first + gained * all_of)) * branches[
            j, SOFT
        ]
    rate = stiffness(body, move.duration, branch) * all_of
    return force + rate * way, rate, 0.5 * stored, work, lost


@inner
def lowest(body: Body, move: Move, group: FloatArray, branch: FloatArray) -> float:
    """What no spring of a group falls below over a move: its branches and springs are monotone."""
    least = body.equilibrium * (group[ALL, LEAST] + group[ALL, SINCE] + min(move.way, 0.0)) + move.drag
    for j in range(branch.shape[0]):
        bears = group[j + 1, LEFT] * group[j + 1, LOWEST] + group[j + 1, GAINED]
        least += min(
            bears, branch[j, DECAY] * bears + branch[j, MEAN] * (body.branches[j, MODULUS] * move.way)
        )
    return float(least)


@inner
def highest(body: Body, way: float, group: FloatArray, branch: FloatArray) -> float:
    """What no spring of a group exceeds that is sheared, whichever way."""
    ahead = group[ALL, SINCE] + way
    low, high = body.equilibrium * (group[ALL, LEAST] + ahead), body.equilibrium * (group[ALL, MOST] + ahead)
    for j in range(branch.shape[0]):
        left = branch[j, DECAY] * group[j + 1, LEFT]
        gained = branch[j, DECAY] * group[j + 1, GAINED] + branch[j, MEAN] * (body.branches[j, MODULUS] * way)
        low += left * group[j + 1, LOWEST] + gained
        high += left * group[j + 1, HIGHEST] + gained
    return float(max(abs(low), abs(high)))
