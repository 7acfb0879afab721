"""Compiled groups of springs with memory that move as one. Imported only when a history is followed: it loads numba.

All springs that stay in contact move alike. The force of a branch is its value when the group was formed, decayed, plus a gain that
all springs share. Sums over the group follow from the sums at the start, so a step costs as much for one spring as for a thousand.
"""

from __future__ import annotations

import math

from pymdr.compiling import Addressed, inner
from pymdr.line.memory.kernels import (
    CROSS,
    DECAY,
    DK,
    FIRM,
    FIRST_DECAY,
    FIRST_GAIN,
    FIRST_MOVE,
    GREATEST_H,
    GREATEST_W,
    GROUP_DECAY,
    GROUP_GAIN,
    GROUP_MOVE,
    GROUPED,
    LEAST_H,
    LEAST_W,
    MEAN,
    MODULUS,
    MOVED,
    OWN,
    RAMP,
    SOFT,
    SQUARED,
    STIFFNESS,
    SUM_H,
    SUM_HH,
    WIDTH,
    Body,
    Move,
)
from pymdr.line.memory.modes import BRANCHES, FREE, REST, TURN, W
from pymdr.units import FloatArray

_EDGE = 16
"""Least number of springs beside an edge that may change sides while the others only move."""


@inner
def edge_count(count: int) -> int:
    """Number of springs beside an edge that may change sides."""
    return max(_EDGE, count // 8)


@inner
def is_outgrown(grouped: int, count: int) -> bool:
    """Whether the edge of `count` springs has moved so far that another group is better."""
    return count - grouped > 2 * edge_count(count) or count - grouped < edge_count(count) // 2


@Addressed
def form_group(springs: FloatArray, count: int, state: FloatArray, other: FloatArray, body: Body) -> None:
    """Group all of the first `count` springs except those next to the edge; both states keep their values."""
    grouped, table, known = max(count - edge_count(count), 0), body.table, body.known
    stiff, width, squared, least, most = 0.0, 0.0, 0.0, math.inf, -math.inf
    for j in range(body.branches):
        table[j, GROUP_DECAY], table[j, GROUP_GAIN], table[j, SUM_H], table[j, SUM_HH] = 1.0, 0.0, 0.0, 0.0
        table[j, LEAST_H], table[j, GREATEST_H] = math.inf, -math.inf
    for i in range(grouped):
        dk, w = springs[DK, i], state[i, W]
        stiff += dk
        width += dk * w
        squared += dk * w * w
        least, most = min(least, w), max(most, w)
        state[i, TURN] = 0.0
        other[i, W], other[i, FREE], other[i, REST], other[i, TURN] = w, state[i, FREE], state[i, REST], 0.0
        for j in range(body.branches):
            h = state[i, BRANCHES + j]
            table[j, LEAST_H] = min(table[j, LEAST_H], h)
            table[j, GREATEST_H] = max(table[j, GREATEST_H], h)
            table[j, SUM_H] += dk * h
            table[j, SUM_HH] += dk * h * h
            other[i, BRANCHES + j] = h
    known[GROUPED], known[STIFFNESS], known[WIDTH], known[SQUARED] = grouped, stiff, width, squared
    known[LEAST_W], known[GREATEST_W], known[GROUP_MOVE] = least, most, 0.0


@Addressed
def dissolve_group(state: FloatArray, body: Body) -> None:
    """Write the present values of the springs of a group to their state, and dissolve it."""
    table, known = body.table, body.known
    for i in range(int(known[GROUPED])):
        state[i, W] += known[GROUP_MOVE]
        for j in range(body.branches):
            state[i, BRANCHES + j] = table[j, GROUP_DECAY] * state[i, BRANCHES + j] + table[j, GROUP_GAIN]
    known[GROUPED] = 0.0


@inner
def move_group(body: Body, change: float) -> None:
    """Move a group over a step whose coefficients are known."""
    table = body.table
    body.known[GROUP_MOVE] += change
    for j in range(body.branches):
        elastic = table[j, MODULUS] * change
        table[j, GROUP_DECAY] *= table[j, DECAY]
        table[j, GROUP_GAIN] = table[j, DECAY] * table[j, GROUP_GAIN] + table[j, MEAN] * elastic


@inner
def note_group(body: Body) -> None:
    """Note where a group is before a part of a row; without one, where one is when it is formed."""
    table, known = body.table, body.known
    formed = known[GROUPED] > 0.0
    known[FIRST_MOVE] = known[GROUP_MOVE] if formed else 0.0
    for j in range(body.branches):
        table[j, FIRST_DECAY] = table[j, GROUP_DECAY] if formed else 1.0
        table[j, FIRST_GAIN] = table[j, GROUP_GAIN] if formed else 0.0


@inner
def exchange_group(body: Body) -> None:
    """Take a group to where it was noted, and note where it is."""
    table, known = body.table, body.known
    known[FIRST_MOVE], known[GROUP_MOVE] = known[GROUP_MOVE], known[FIRST_MOVE]
    for j in range(body.branches):
        decay, gain = table[j, GROUP_DECAY], table[j, GROUP_GAIN]
        table[j, GROUP_DECAY], table[j, GROUP_GAIN] = table[j, FIRST_DECAY], table[j, FIRST_GAIN]
        table[j, FIRST_DECAY], table[j, FIRST_GAIN] = decay, gain


@inner
def group_forces(body: Body, move: Move) -> tuple[float, float, float, float, float]:
    """Force of a group after a move, its derivative by the move, stored energy, work and dissipation."""
    change, drag, table, known = move.change, move.drag, body.table, body.known
    k, since = known[STIFFNESS], known[GROUP_MOVE]
    width, ahead = known[WIDTH] + k * since, since + change
    force = body.equilibrium * width
    work, dissipated = change * (body.equilibrium * (width + 0.5 * change * k) + drag * k), change * drag * k
    stored = body.equilibrium * (known[SQUARED] + ahead * (2.0 * known[WIDTH] + ahead * k))
    for j in range(body.branches):
        elastic, fade, gained, soft = (
            table[j, MODULUS] * change,
            table[j, GROUP_DECAY],
            table[j, GROUP_GAIN],
            table[j, SOFT],
        )
        first, squares = table[j, SUM_H], table[j, SUM_HH]
        borne = fade * first + gained * k
        squared = fade * fade * squares + gained * (2.0 * fade * first + gained * k)
        force += table[j, DECAY] * borne
        work += change * (table[j, MEAN] * borne + table[j, RAMP] * elastic * k)
        crossed = elastic * (2.0 * table[j, CROSS] * borne + table[j, MOVED] * elastic * k)
        dissipated += (table[j, OWN] * squared + crossed) * soft
        fade, gained = table[j, DECAY] * fade, table[j, DECAY] * gained + table[j, MEAN] * elastic
        stored += (fade * fade * squares + gained * (2.0 * fade * first + gained * k)) * soft
    rate = known[FIRM] * k
    return force + rate * change, rate, 0.5 * stored, work, dissipated


@inner
def least_force(body: Body, move: Move) -> float:
    """Lower bound of the force of any spring of a group during a move: its terms are monotone."""
    table, known = body.table, body.known
    least = body.equilibrium * (known[LEAST_W] + known[GROUP_MOVE] + min(move.change, 0.0)) + move.drag
    for j in range(body.branches):
        h = table[j, GROUP_DECAY] * table[j, LEAST_H] + table[j, GROUP_GAIN]
        least += min(h, table[j, DECAY] * h + table[j, MEAN] * (table[j, MODULUS] * move.change))
    return float(least)


@inner
def greatest_force(body: Body, change: float) -> float:
    """Upper bound of the magnitude of the force of any spring of a sheared group."""
    table, known = body.table, body.known
    ahead = known[GROUP_MOVE] + change
    low, high = body.equilibrium * (known[LEAST_W] + ahead), body.equilibrium * (known[GREATEST_W] + ahead)
    for j in range(body.branches):
        fade = table[j, DECAY] * table[j, GROUP_DECAY]
        gained = table[j, DECAY] * table[j, GROUP_GAIN] + table[j, MEAN] * (table[j, MODULUS] * change)
        low += fade * table[j, LEAST_H] + gained
        high += fade * table[j, GREATEST_H] + gained
    return float(max(abs(low), abs(high)))
