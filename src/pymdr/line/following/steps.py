"""Compiled single steps of contacts on the branches of a curve. Loads numba."""

from __future__ import annotations

import math

from pymdr.compiling import Fused
from pymdr.line.following import layout
from pymdr.line.moved import BEFORE, NOW
from pymdr.numerics.table_reading import cell_of, value_in
from pymdr.units import FloatArray

_fused = Fused(__file__)


@_fused.inlined
def _keep(memory: FloatArray) -> None:
    """Keep the present state as the one before."""
    for i in range(memory.shape[1]):
        memory[BEFORE, i] = memory[NOW, i]
    memory[NOW, layout.JUMPED] = 0.0


@_fused.inner
def row_of(rows: FloatArray, branch: float) -> int:
    """The row of a branch."""
    return int(branch) + 1 if branch >= 0.0 else int(rows[0, layout.BRANCHES])


@_fused.inner
def walk(rows: FloatArray, now: FloatArray, branch: float, depth: float) -> float:
    """The branch reached at D, with the energy lost in jumps on the way."""
    row = row_of(rows, branch)
    while True:
        if depth > rows[row, layout.HIGH]:
            branch = rows[row, layout.UP_TO]
            now[layout.DISSIPATED] += rows[row, layout.UP_LOSS]
            now[layout.JUMPED] = max(now[layout.JUMPED], rows[row, layout.UP_JUMPS])
        elif depth < rows[row, layout.LOW]:
            branch = rows[row, layout.DOWN_TO]
            now[layout.DISSIPATED] += rows[row, layout.DOWN_LOSS]
            now[layout.JUMPED] = max(now[layout.JUMPED], rows[row, layout.DOWN_JUMPS])
        else:
            return branch
        row = row_of(rows, branch)


@_fused.inner
def place(rows: FloatArray, branch: float, depth: float) -> tuple[int, float]:
    """The cell of D on a branch, and the argument of its terms."""
    row, first = row_of(rows, branch), 1 + int(rows[0, layout.BRANCHES])
    low, high = int(rows[row, layout.FIRST]), int(rows[row, layout.LAST])
    while low < high:
        middle = (low + high + 1) >> 1
        if depth >= rows[first + middle, layout.SEGMENT_LOW]:
            low = middle
        else:
            high = middle - 1
    ends = rows[first + low, layout.SEGMENT_LOW], rows[first + low, layout.SEGMENT_HIGH]
    return cell_of(rows, int(rows[0, layout.CELLS]), int(rows[0, layout.CELL_COUNT]), low, ends, depth)


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
    branch = walk(rows, now, now[layout.STATE], depth)
    now[layout.STATE], now[layout.DEPTH] = branch, depth
    if branch == layout.NO_CONTACT:
        now[layout.AT], now[layout.NORMAL] = math.nan, 0.0
        now[layout.TOUCHED] = max(now[layout.TOUCHED], now[layout.JUMPED])
        return 0.0
    now[layout.TOUCHED] = 1.0
    cell, u = place(rows, branch, depth)
    terms = int(rows[0, layout.TERMS])
    now[layout.AT] = value_in(rows, cell, layout.PARAMETER, terms, u)
    now[layout.NORMAL] = value_in(rows, cell, layout.FORCE, terms, u)
    return float(now[layout.NORMAL])


@_fused.inner
def branch_at(rows: FloatArray, s: float) -> float:
    """The stable branch of a parameter, NOWHERE if there is none."""
    for i in range(int(rows[0, layout.BRANCHES]) - 1, 0, -1):
        if rows[i, layout.BOTTOM] <= s <= rows[i, layout.TOP]:
            return float(i - 1)
    return float(layout.NOWHERE)


@_fused.inner
def land(rows: FloatArray, edge: FloatArray, now: FloatArray, advances: bool) -> None:
    """Read the state of an edge that has moved, and the range in which it rests."""
    if now[layout.STATE] == layout.NO_CONTACT:
        now[layout.AT], now[layout.NORMAL], now[layout.ATTACHED], now[layout.MOVES] = math.nan, 0.0, 0.0, 0.0
        return
    depth = now[layout.DEPTH]
    cell, u = place(rows, now[layout.STATE], depth)
    row, terms = row_of(rows, now[layout.STATE]), int(rows[0, layout.TERMS])
    # rounding must not take the state off its branch, where the other curve may end too; its square root counts at a fold
    s = min(
        max(value_in(rows, cell, layout.PARAMETER, terms, u), rows[row, layout.BOTTOM]), rows[row, layout.TOP]
    )
    other = value_in(rows, cell, layout.OTHER, terms, u)
    now[layout.AT], now[layout.NORMAL] = (
        min(s, edge[layout.EDGE]),
        value_in(rows, cell, layout.FORCE, terms, u),
    )
    radius = value_in(rows, cell, layout.RADIUS, terms, u)
    now[layout.ATTACHED] = radius if advances else max(radius, edge[layout.LEAST])
    now[layout.PER_DEPTH] = value_in(rows, cell, layout.STIFFNESS, terms, u)
    now[layout.BASE_DEPTH], now[layout.BASE_FORCE] = depth, now[layout.NORMAL]
    now[layout.RESTS_FROM] = other if advances else depth
    now[layout.RESTS_TO] = depth if advances else other
    if s >= edge[layout.EDGE]:
        now[layout.RESTS_TO], now[layout.MOVES] = math.inf, 0.0


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
    attached = memory[NOW, layout.STATE] != layout.NO_CONTACT
    low = memory[NOW, layout.RESTS_FROM] if attached else -math.inf
    high = (
        memory[NOW, layout.RESTS_TO]
        if attached
        else advancing[row_of(advancing, layout.NO_CONTACT), layout.HIGH]
    )
    if low <= depth <= high:
        _keep(memory)
        now = memory[NOW]
        if depth != now[layout.DEPTH]:
            now[layout.DEPTH], now[layout.MOVES] = depth, 0.0
        if attached:
            now[layout.NORMAL] = now[layout.BASE_FORCE] + now[layout.PER_DEPTH] * (
                depth - now[layout.BASE_DEPTH]
            )
        return layout.COMPLETE, float(now[layout.NORMAL])
    advances = depth > high
    direction = 1.0 if advances else -1.0
    rows = advancing if advances else receding
    jumps = branch != layout.NOWHERE
    if not jumps:
        branch = memory[NOW, layout.STATE]
        if attached and memory[NOW, layout.CURVE] != direction:
            branch = branch_at(rows, memory[NOW, layout.AT])
            if branch == layout.NOWHERE:
                return layout.UNSTABLE, 0.0
    _keep(memory)
    now = memory[NOW]
    before = now[layout.ATTACHED]
    if jumps:
        now[layout.DISSIPATED] += loss
        now[layout.JUMPED] = 1.0
    else:
        branch = walk(rows, now, branch, depth)
    now[layout.STATE], now[layout.DEPTH], now[layout.CURVE], now[layout.MOVES] = (
        branch,
        depth,
        direction,
        direction,
    )
    if branch != layout.NO_CONTACT or now[layout.JUMPED] > 0.0:
        now[layout.TOUCHED] = 1.0
    land(rows, edge, now, advances)
    if not advances:
        spent = edge[layout.PER_AREA] * (before * before - now[layout.ATTACHED] * now[layout.ATTACHED])
        now[layout.SPENT] += spent
        now[layout.DISSIPATED] += spent
    return layout.COMPLETE, float(now[layout.NORMAL])


@_fused.compiled
def step_all(
    rows: FloatArray, memory: FloatArray, depth: FloatArray, force: FloatArray, some: tuple[int, int]
) -> None:
    """Steps of the contacts from one up to another, as :func:`step`; the forces in N are written."""
    for i in range(some[0], some[1]):
        force[i] = step(rows, memory[i], depth[i])


@_fused.compiled
def step_all_resting(
    advancing: FloatArray,
    receding: FloatArray,
    edge: FloatArray,
    memory: FloatArray,
    depth: FloatArray,
    force: FloatArray,
    some: tuple[int, int],
) -> int:
    """Steps of the contacts from one up to another, as :func:`step_resting`; the first whose edge is unstable, or that after the last."""
    for i in range(some[0], some[1]):
        ending, force[i] = step_resting(advancing, receding, edge, memory[i], depth[i], layout.NOWHERE, 0.0)
        if ending != layout.COMPLETE:
            return i
    return some[1]
