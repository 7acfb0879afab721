"""Compiled single steps of contacts on the branches of a curve. Loads numba."""

from __future__ import annotations

import math

from pymdr.compiling import Fused
from pymdr.line.following.layout import (
    AT,
    BASE_DEPTH,
    BASE_FORCE,
    BOTTOM,
    BRANCHES,
    CELL_COUNT,
    CELLS,
    COMPLETE,
    CURVE,
    DEPTH,
    DISSIPATED,
    DOWN_JUMPS,
    DOWN_LOSS,
    DOWN_TO,
    EDGE,
    FIRST,
    FORCE,
    HIGH,
    JUMPED,
    LAST,
    LEAST,
    LOW,
    MOVES,
    NO_CONTACT,
    NORMAL,
    NOWHERE,
    OTHER,
    PARAMETER,
    PER_AREA,
    PER_DEPTH,
    RADIUS,
    REACH,
    RESTS_FROM,
    RESTS_TO,
    SEGMENT_HIGH,
    SEGMENT_LOW,
    SPENT,
    STATE,
    STIFFNESS,
    TERMS,
    TOP,
    TOUCHED,
    UNSTABLE,
    UP_JUMPS,
    UP_LOSS,
    UP_TO,
)
from pymdr.line.moved import BEFORE, NOW
from pymdr.numerics.table_reading import cell_of, value_in
from pymdr.units import FloatArray

_fused = Fused(__file__)


@_fused.inlined
def _keep(memory: FloatArray) -> None:
    """Keep the present state as the one before."""
    for i in range(memory.shape[1]):
        memory[BEFORE, i] = memory[NOW, i]
    memory[NOW, JUMPED] = 0.0


@_fused.inner
def row_of(rows: FloatArray, branch: float) -> int:
    """The row of a branch."""
    return int(branch) + 1 if branch >= 0.0 else int(rows[0, BRANCHES])


@_fused.inner
def walk(rows: FloatArray, now: FloatArray, branch: float, depth: float) -> float:
    """The branch reached at D, with the energy lost in jumps on the way."""
    row = row_of(rows, branch)
    while True:
        if depth > rows[row, HIGH]:
            branch = rows[row, UP_TO]
            now[DISSIPATED] += rows[row, UP_LOSS]
            now[JUMPED] = max(now[JUMPED], rows[row, UP_JUMPS])
        elif depth < rows[row, LOW]:
            branch = rows[row, DOWN_TO]
            now[DISSIPATED] += rows[row, DOWN_LOSS]
            now[JUMPED] = max(now[JUMPED], rows[row, DOWN_JUMPS])
        else:
            return branch
        row = row_of(rows, branch)


@_fused.inner
def place(rows: FloatArray, branch: float, depth: float) -> tuple[int, float]:
    """The cell of D on a branch, and the argument of its terms."""
    row, first = row_of(rows, branch), 1 + int(rows[0, BRANCHES])
    low, high = int(rows[row, FIRST]), int(rows[row, LAST])
    while low < high:
        middle = (low + high + 1) >> 1
        if depth >= rows[first + middle, SEGMENT_LOW]:
            low = middle
        else:
            high = middle - 1
    ends = rows[first + low, SEGMENT_LOW], rows[first + low, SEGMENT_HIGH]
    return cell_of(rows, int(rows[0, CELLS]), int(rows[0, CELL_COUNT]), low, ends, depth)


@_fused.compiled
def step(rows: FloatArray, memory: FloatArray, depth: float) -> float:
    """
    Go straight to an indentation.

    Parameters
    ----------
    rows : ndarray
        The branches of the curve, see :mod:`pymdr.line.following.layout`.
    memory : ndarray, shape (2, 7)
        What the contact remembers, now and before the last step.
    depth : float
        In m.

    Returns
    -------
    float
        The force in N.
    """
    _keep(memory)
    now = memory[NOW]
    branch = walk(rows, now, now[STATE], depth)
    now[STATE], now[DEPTH] = branch, depth
    if branch == NO_CONTACT:
        now[AT], now[NORMAL] = math.nan, 0.0
        now[TOUCHED] = max(now[TOUCHED], now[JUMPED])
        return 0.0
    now[TOUCHED] = 1.0
    cell, u = place(rows, branch, depth)
    terms = int(rows[0, TERMS])
    now[AT] = value_in(rows, cell, PARAMETER, terms, u)
    now[NORMAL] = value_in(rows, cell, FORCE, terms, u)
    return float(now[NORMAL])


@_fused.inner
def branch_at(rows: FloatArray, s: float) -> float:
    """The stable branch of a parameter, NOWHERE if there is none."""
    for i in range(int(rows[0, BRANCHES]) - 1, 0, -1):
        if rows[i, BOTTOM] <= s <= rows[i, TOP]:
            return float(i - 1)
    return float(NOWHERE)


@_fused.inner
def land(rows: FloatArray, edge: FloatArray, now: FloatArray, advances: bool) -> None:
    """Read the state of an edge that has moved, and the range in which it rests."""
    if now[STATE] == NO_CONTACT:
        now[AT], now[NORMAL], now[REACH], now[MOVES] = math.nan, 0.0, 0.0, 0.0
        return
    depth = now[DEPTH]
    cell, u = place(rows, now[STATE], depth)
    row, terms = row_of(rows, now[STATE]), int(rows[0, TERMS])
    # rounding must not take the state off its branch, where the other curve may end too; its square root counts at a fold
    s = min(max(value_in(rows, cell, PARAMETER, terms, u), rows[row, BOTTOM]), rows[row, TOP])
    other = value_in(rows, cell, OTHER, terms, u)
    now[AT], now[NORMAL] = min(s, edge[EDGE]), value_in(rows, cell, FORCE, terms, u)
    radius = value_in(rows, cell, RADIUS, terms, u)
    now[REACH] = radius if advances else max(radius, edge[LEAST])
    now[PER_DEPTH] = value_in(rows, cell, STIFFNESS, terms, u)
    now[BASE_DEPTH], now[BASE_FORCE] = depth, now[NORMAL]
    now[RESTS_FROM] = other if advances else depth
    now[RESTS_TO] = depth if advances else other
    if s >= edge[EDGE]:
        now[RESTS_TO], now[MOVES] = math.inf, 0.0


@_fused.compiled
def step_resting(
    advancing: FloatArray,
    receding: FloatArray,
    edge: FloatArray,
    memory: FloatArray,
    depth: float,
    branch: float,
    loss: float,
) -> tuple[int, float]:
    """
    As :func:`step`, with an edge that advances on one curve, recedes on another and rests in between.

    Parameters
    ----------
    advancing, receding : ndarray
        Both curves.
    edge : ndarray, shape (3,)
        Its constants.
    memory : ndarray, shape (2, 16)
    depth : float
        In m.
    branch, loss : float
        Branch reached and energy in J lost on the way from an unstable state; NOWHERE and 0 otherwise.

    Returns
    -------
    tuple
        The ending, which leaves the state if it is UNSTABLE, and the force in N.
    """
    attached = memory[NOW, STATE] != NO_CONTACT
    low = memory[NOW, RESTS_FROM] if attached else -math.inf
    high = memory[NOW, RESTS_TO] if attached else advancing[row_of(advancing, NO_CONTACT), HIGH]
    if low <= depth <= high:
        _keep(memory)
        now = memory[NOW]
        if depth != now[DEPTH]:
            now[DEPTH], now[MOVES] = depth, 0.0
        if attached:
            now[NORMAL] = now[BASE_FORCE] + now[PER_DEPTH] * (depth - now[BASE_DEPTH])
        return COMPLETE, float(now[NORMAL])
    advances = depth > high
    direction = 1.0 if advances else -1.0
    rows = advancing if advances else receding
    jumps = branch != NOWHERE
    if not jumps:
        branch = memory[NOW, STATE]
        if attached and memory[NOW, CURVE] != direction:
            branch = branch_at(rows, memory[NOW, AT])
            if branch == NOWHERE:
                return UNSTABLE, 0.0
    _keep(memory)
    now = memory[NOW]
    before = now[REACH]
    if jumps:
        now[DISSIPATED] += loss
        now[JUMPED] = 1.0
    else:
        branch = walk(rows, now, branch, depth)
    now[STATE], now[DEPTH], now[CURVE], now[MOVES] = branch, depth, direction, direction
    if branch != NO_CONTACT or now[JUMPED] > 0.0:
        now[TOUCHED] = 1.0
    land(rows, edge, now, advances)
    if not advances:
        spent = edge[PER_AREA] * (before * before - now[REACH] * now[REACH])
        now[SPENT] += spent
        now[DISSIPATED] += spent
    return COMPLETE, float(now[NORMAL])


@_fused.compiled
def step_all(rows: FloatArray, memory: FloatArray, depth: FloatArray, force: FloatArray) -> None:
    """Steps of many contacts, as :func:`step`; the forces in N are written."""
    for i in range(depth.size):
        force[i] = step(rows, memory[i], depth[i])


@_fused.compiled
def step_all_resting(
    advancing: FloatArray,
    receding: FloatArray,
    edge: FloatArray,
    memory: FloatArray,
    depth: FloatArray,
    force: FloatArray,
    first: int,
) -> int:
    """Steps of many contacts, as :func:`step_resting`, from the contact `first` on; the first whose edge is unstable, or their number."""
    for i in range(first, depth.size):
        ending, force[i] = step_resting(advancing, receding, edge, memory[i], depth[i], NOWHERE, 0.0)
        if ending != COMPLETE:
            return i
    return int(depth.size)
