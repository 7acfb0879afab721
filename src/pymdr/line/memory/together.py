"""Compiled groups of springs with memory that move as one. Imported only when a history is followed: it loads numba.

All springs that stay in contact are shortened alike. What a branch of such a spring bears is therefore what it bore when the group
was formed, faded alike, and what all gained alike since: sums over the group follow from sums at first, and a row costs as much
for one spring as for a thousand.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pymdr.compiling import inner
from pymdr.line.memory.kernels import (
    CROSS,
    DECAY,
    FREE,
    MEAN,
    MOVED,
    OWN,
    RAMP,
    REST,
    SHARE,
    TURN,
    Body,
    Move,
    State,
    stiffness,
)
from pymdr.units import FloatArray

HELD, STIFFNESS, WIDTH, SQUARED, LEAST, MOST, SINCE = range(7)
"""Of a group: how many springs from the innermost on; the sums of their k, k w and k w^2, the least and the largest w, all when
it was formed; and how far they moved since."""
LEFT, GAINED, LOWEST, HIGHEST, BORNE, ENERGY = range(6)
"""Of their branches: h is LEFT times that at first and GAINED; the lowest and highest h, and the sums of k h and k h^2 at first."""
_EDGE = 16
"""Springs beside an edge, at least, that may change sides while others only move."""


class Group(NamedTuple):
    """Springs that move as one."""

    whole: FloatArray
    branches: FloatArray


def no_group(body: Body) -> Group:
    """A group of no springs."""
    return Group(np.zeros(7), np.zeros((6, body.moduli.size)))


@inner
def beside(count: int) -> int:
    """How many springs beside an edge may change sides."""
    return max(_EDGE, count // 8)


@inner
def strays(held: int, count: int) -> bool:
    """Whether the edge of `count` springs has moved so far that another group is better."""
    return count - held > 2 * beside(count) or count - held < beside(count) // 2


@inner
def join(springs: FloatArray, count: int, state: State, other: State, group: Group) -> None:
    """Form a group of the first springs but those beside the edge of `count`; their state is kept in both places."""
    whole, branches, held = group.whole, group.branches, max(count - beside(count), 0)
    for i in range(whole.size):
        whole[i] = 0.0
    whole[HELD], whole[LEAST], whole[MOST] = held, math.inf, -math.inf
    n = branches.shape[1]
    for j in range(n):
        branches[LEFT, j], branches[GAINED, j] = 1.0, 0.0
        branches[LOWEST, j], branches[HIGHEST, j] = math.inf, -math.inf
        branches[BORNE, j], branches[ENERGY, j] = 0.0, 0.0
    for i in range(held):
        share, w = springs[SHARE, i], state.w[i]
        whole[STIFFNESS] += share
        whole[WIDTH] += share * w
        whole[SQUARED] += share * w * w
        whole[LEAST], whole[MOST] = min(whole[LEAST], w), max(whole[MOST], w)
        state.free[TURN, i] = 0.0
        other.w[i] = w
        other.free[FREE, i], other.free[REST, i], other.free[TURN, i] = (
            state.free[FREE, i],
            state.free[REST, i],
            0.0,
        )
        for j in range(n):
            h = state.z[i, j]
            branches[LOWEST, j] = min(branches[LOWEST, j], h)
            branches[HIGHEST, j] = max(branches[HIGHEST, j], h)
            branches[BORNE, j] += share * h
            branches[ENERGY, j] += share * h * h
            other.z[i, j] = h


@inner
def release(state: State, group: Group) -> None:
    """Give the springs of a group what they have now."""
    for i in range(int(group.whole[HELD])):
        state.w[i] += group.whole[SINCE]
        for j in range(group.branches.shape[1]):
            state.z[i, j] = group.branches[LEFT, j] * state.z[i, j] + group.branches[GAINED, j]
    group.whole[HELD] = 0.0


@inner
def carry(body: Body, way: float, group: Group, branch: FloatArray) -> None:
    """Move a group on over a step whose coefficients are given."""
    branches = group.branches
    group.whole[SINCE] += way
    for j in range(body.moduli.size):
        branches[LEFT, j] *= branch[j, DECAY]
        branches[GAINED, j] = branch[j, DECAY] * branches[GAINED, j] + branch[j, MEAN] * (
            body.moduli[j] * way
        )


@inner
def bear(
    body: Body, move: Move, group: Group, branch: FloatArray
) -> tuple[float, float, float, float, float]:
    """The force of a group after a move, how it grows with it, the energy stored then, the work and what dashpots take."""
    whole, branches, way, drag = group.whole, group.branches, move.way, move.drag
    all_of, since = whole[STIFFNESS], whole[SINCE]
    width, ahead = whole[WIDTH] + all_of * since, since + way
    force = body.equilibrium * width
    work, lost = way * (body.equilibrium * (width + 0.5 * way * all_of) + drag * all_of), way * drag * all_of
    stored = body.equilibrium * (whole[SQUARED] + ahead * (2.0 * whole[WIDTH] + ahead * all_of))
    for j in range(body.moduli.size):
        elastic, left, gained = body.moduli[j] * way, branches[LEFT, j], branches[GAINED, j]
        first, squares = branches[BORNE, j], branches[ENERGY, j]
        borne = left * first + gained * all_of
        squared = left * left * squares + gained * (2.0 * left * first + gained * all_of)
        force += branch[j, DECAY] * borne
        work += way * (branch[j, MEAN] * borne + branch[j, RAMP] * elastic * all_of)
        lost += (
            branch[j, OWN] * squared
            + elastic * (2.0 * branch[j, CROSS] * borne + branch[j, MOVED] * elastic * all_of)
        ) * body.soft[j]
        left, gained = branch[j, DECAY] * left, branch[j, DECAY] * gained + branch[j, MEAN] * elastic
        stored += (left * left * squares + gained * (2.0 * left * first + gained * all_of)) * body.soft[j]
    rate = stiffness(body, move.duration, branch) * all_of
    return force + rate * way, rate, 0.5 * stored, work, lost


@inner
def lowest(body: Body, move: Move, group: Group, branch: FloatArray) -> float:
    """What no spring of a group falls below over a move: its branches and springs are monotone."""
    least = body.equilibrium * (group.whole[LEAST] + group.whole[SINCE] + min(move.way, 0.0)) + move.drag
    for j in range(body.moduli.size):
        bears = group.branches[LEFT, j] * group.branches[LOWEST, j] + group.branches[GAINED, j]
        least += min(bears, branch[j, DECAY] * bears + branch[j, MEAN] * (body.moduli[j] * move.way))
    return float(least)


@inner
def highest(body: Body, way: float, group: Group, branch: FloatArray) -> float:
    """What no spring of a group exceeds that is sheared, whichever way."""
    whole, branches = group.whole, group.branches
    ahead = whole[SINCE] + way
    low, high = body.equilibrium * (whole[LEAST] + ahead), body.equilibrium * (whole[MOST] + ahead)
    for j in range(body.moduli.size):
        left = branch[j, DECAY] * branches[LEFT, j]
        gained = branch[j, DECAY] * branches[GAINED, j] + branch[j, MEAN] * (body.moduli[j] * way)
        low += left * branches[LOWEST, j] + gained
        high += left * branches[HIGHEST, j] + gained
    return float(max(abs(low), abs(high)))
