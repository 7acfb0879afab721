"""Compiled histories of springs with memory: rows of indentations, forces or travels. Imported only when one is followed: it loads numba."""

from __future__ import annotations

import math
from typing import NamedTuple

from pymdr import compiling
from pymdr.compiling import inner
from pymdr.line.memory.kernels import (
    COUNT,
    FORCE,
    HEIGHT,
    LOST,
    MODULUS,
    OUTER,
    OWNER,
    PART,
    PARTS,
    RATE,
    SHARE,
    STORED,
    THERE,
    WORK,
    Body,
    Room,
    step,
    straight,
)
from pymdr.line.memory.modes import BORNE, FREE, TURN, W
from pymdr.line.memory.together import (
    ALL,
    GAINED,
    HELD,
    LEFT,
    SINCE,
    bear,
    beside,
    carry,
    join,
    lowest,
    release,
    strays,
)
from pymdr.units import FloatArray

# the steps are compiled into the histories
_STAMP = compiling.stamp_of(__file__)


def compiled(function: compiling.Function) -> compiling.Function:
    """Compile with numba when first called; kept on disk."""
    return compiling.compiled(function, _STAMP)


ENDED, FULL = -1, -2
"""Why rows were not divided: the springs end, or the parts are more than there is room for."""
LOAD, GAP, TURNED = range(3)
"""What is noted of springs: the load per length without a dashpot beside them, the gap above free ones, -1 in contact, and at
which part of a row they last changed sides."""
NOTES = 3
_CLOSE = 1e-13
_DEEPEST = 48
"""How often a row is halved at most."""
_SUDDEN = 2.0**-16
"""Part of a row below which it is not divided for loads, which a dashpot lets jump."""
_WORTH = 0.1
"""Of the largest force times the largest indentation: about the least work of a history that goes there."""
_TIMED = 1e-13
"""Of the time: parts of rows below which rounding tells how long they are."""


class Run(NamedTuple):
    """What a history is followed with; an infinite machine prescribes d, one of 0 the force. Springs end at `limit`."""

    springs: FloatArray
    body: Body
    machine: float
    limit: float
    room: Room
    group: FloatArray
    row: FloatArray


class Division(NamedTuple):
    """How straight parts of rows are to be: a tolerance in m, one of loads, and the strength of every row in N, none for whole rows."""

    tolerance: float
    straightness: float
    strength: FloatArray


class Now(NamedTuple):
    """Where a row begins: the indentation, that before, the duration of the row, and how many springs were touched."""

    here: float
    before: float
    duration: float
    active: int


@inner
def copy_spring(state: FloatArray, other: FloatArray, i: int) -> None:
    """Take a spring over, number by number: slices of arrays take seconds to compile."""
    for j in range(state.shape[1]):
        state[i, j] = other[i, j]


@inner
def _note(run: Run, depth: float, state: FloatArray, notes: FloatArray, r: int) -> None:
    """Note what springs bear, or how far they are away."""
    body, group, n = run.body, run.group, run.group.shape[0] - 1
    held, same = int(group[ALL, HELD]), body.equilibrium * group[ALL, SINCE]
    for j in range(1, n + 1):
        same += group[j, GAINED]
    for i in range(notes.shape[2]):
        grouped = i < held
        free = not grouped and state[i, FREE] != 0.0
        q = body.equilibrium * state[i, W] + (same if grouped else 0.0)
        for j in range(n):
            q += (group[j + 1, LEFT] if grouped else 1.0) * state[i, BORNE + j]
        notes[LOAD, r, i] = 0.0 if free else q
        notes[GAP, r, i] = max(state[i, W] + run.springs[HEIGHT, i] - depth, 0.0) if free else -1.0
        notes[TURNED, r, i] = 0.0 if grouped else state[i, TURN]


@inner
def _rest(springs: FloatArray, state: FloatArray, active: int) -> float:
    """The largest indentation at which no spring is touched, of those that are all free."""
    if active == 0:  # of bodies that have not touched
        return 0.0
    depth = springs[HEIGHT, active] if active < springs.shape[1] else math.inf
    for i in range(active):
        depth = min(depth, springs[HEIGHT, i] + state[i, W])
    return float(depth)


@inner
def _touched(springs: FloatArray, active: int, depth: float) -> int:
    """How many springs a depth reaches, and no fewer than are active."""
    touched = active
    while touched < springs.shape[1] and springs[HEIGHT, touched] < depth:
        touched += 1
    return touched


@inner
def _touching(count: int, active: int, state: FloatArray) -> int:
    """How many springs touch from the innermost on, where some surely do."""
    while count < active and state[count, FREE] == 0.0:
        count += 1
    return count


@inner
def _press(
    run: Run, now: Now, target: float, old: FloatArray, new: FloatArray, lasting: bool
) -> tuple[float, float, int, int]:
    """
    Move springs straight to where the target of a row is met.

    Springs well within the contact move as one while all of them surely stay in it, and are given what they have only where they
    may not; or at the end, unless that is `lasting`.

    Returns the indentation there, where it starts, the springs touched, and those that were moved on the way. The indentation is
    inf where the springs end. Without a force it is where the bodies part.
    """
    springs, body, group, row = run.springs, run.body, run.group, run.row
    machine, limit, most = run.machine, run.limit, now.active
    here, active = now.here, now.active
    lift, by_depth, held = machine == 0.0 and target <= 0.0, math.isinf(machine), int(group[ALL, HELD])
    sudden = body.viscosity > 0.0 and now.duration == 0.0  # a dashpot takes the load where it is
    if lift or sudden:
        release(old, group)
    elif held == 0 and (lasting or not by_depth):
        join(springs, _touching(held, active, old), old, new, group)
    if machine == 0.0 and not lift and group[ALL, HELD] == 0.0:
        # bodies that are apart rest on each other before a force presses
        here = max(here, _rest(springs, old, active))
    elif sudden and 0.0 < machine < math.inf:
        here = max(here, min(_rest(springs, old, active), target / machine))
    springy = body.equilibrium
    for j in range(body.branches.shape[0]):
        springy += body.branches[j, MODULUS]
    hardest, outer = springy, springs[OUTER, springs.shape[1] - 1]
    if body.viscosity > 0.0:
        hardest += body.viscosity / (1.0 if sudden else now.duration)
    guess = target if by_depth else min(2.0 * here - now.before, limit)
    parting = lift or (sudden and not by_depth and target < machine * here)
    if parting:  # the bodies part at once, and then rest on each other where nothing holds them
        guess = here - 1e2 * (springs[HEIGHT, springs.shape[1] - 1] + abs(here))
        if sudden:  # by a load that no spring of the body withstands
            guess += (guess - here) * springy / body.viscosity
    low, high, out, whole, edge = -math.inf, math.inf, 0.0, by_depth, 0
    if group[ALL, HELD] > 0.0 and not whole:
        edge = _touching(int(group[ALL, HELD]), active, old)
    while True:
        touched = _touched(springs, active, here if sudden else max(here, guess))
        most = max(most, touched)
        held = int(group[ALL, HELD])
        near = touched if held == 0 or whole else min(touched, edge + beside(edge))
        move = straight(body.viscosity, here, guess, now.duration)
        step(springs, body, move, (held, near, by_depth), old, new, run.room, row)
        alone = row[COUNT]  # without two next to those that move as one, no edge is known
        if held > 0:
            force, rate, stored, work, lost = bear(body, move, group, run.room.branch)
            row[FORCE] += force
            row[RATE] += rate
            row[STORED] += stored
            row[WORK] += work
            row[LOST] += lost
            row[COUNT] += held
            row[PARTS] += held
        if held == 0 and by_depth:
            return guess, here, touched, most
        if lift:
            return _rest(springs, new, touched), here, touched, most
        if parting:
            row[FORCE] = 0.0
            return target / machine, here, touched, most
        over = 0.0 if by_depth else row[FORCE] + machine * (here if sudden else guess) - target
        close = by_depth or abs(over) <= _CLOSE * (abs(target) + machine * abs(here if sudden else guess))
        close |= sudden and row[COUNT] == 0.0  # nothing bears the load yet
        if not close:
            low, high = (low, min(high, guess)) if over > 0.0 else (max(low, guess), high)
        enclosed = low > -math.inf and high < math.inf
        close |= enclosed and high - low <= 4e-16 * max(abs(high), abs(low), abs(here))
        ends = low >= limit and not sudden
        if held > 0 and (close or ends):
            stays = lasting and (
                near < touched or (alone >= 2.0 and lowest(body, move, group, run.room.branch) >= 0.0)
            )
            if stays and near == touched:
                if close:
                    carry(body, move.way, group, run.room.branch)
                break
            if not stays:
                release(old, group)
            whole, low, high, out = True, -math.inf, math.inf, 0.0  # with all springs, from here
            continue
        if close or ends:
            break
        slope = row[RATE] + (0.0 if sudden else machine)
        newton = guess - over / slope if slope > 0.0 else math.nan
        if low < newton < high:
            guess = newton if newton < limit or sudden else limit
        elif not enclosed:
            out = max(2.0 * out, abs(over) / (hardest * outer), 1e-15 * abs(guess), 1e-300)
            guess = (low + out if sudden else min(low + out, limit)) if math.isinf(high) else high - out
        else:
            guess = 0.5 * (low + high)
    if not close:
        return math.inf, here, touched, most
    if sudden or (machine > 0.0 and abs(over) > _CLOSE * (abs(target) + machine * abs(guess))):
        # where springs touch all at once, the force is between those beside
        row[FORCE] = max(target - machine * (here if sudden else guess), 0.0)
    return here if sudden else guess, here, touched, most


@inner
def _is_bent(
    run: Run,
    now: Now,
    goals: tuple[float, float, bool],
    found: tuple[float, float, int],
    states: tuple[FloatArray, FloatArray, FloatArray],
    notes: FloatArray,
    limits: tuple[float, float, float],
) -> bool:
    """
    Whether a part is to be halved.

    `goals` are the targets half-way and in the end, and whether loads count; `found` the indentation, where it starts and the springs
    touched; `states` those before, after and half-way; `limits` the tolerance in m, the straightness of loads and the strength of the
    row in N.
    """
    middle, goal, loads = goals
    there, start, touched = found
    tolerance, straightness, strength = limits
    slope, lift = run.row[RATE], run.machine == 0.0 and goal <= 0.0
    half = start if lift else 0.5 * (start + there)
    move = straight(run.body.viscosity, start, half, 0.5 * now.duration)
    every = int(run.group[ALL, HELD]), touched, math.isinf(run.machine)
    step(run.springs, run.body, move, every, states[0], states[2], run.room, run.row)
    over = 0.0
    if lift:  # what is parted in one part bears nothing half-way
        over, slope = middle, run.row[RATE]
    elif not math.isinf(run.machine):
        over = abs(run.row[FORCE] + run.machine * half - middle)
        slope = max(run.row[RATE], slope) + run.machine
    if over > tolerance * slope or over * abs(there - start) > _WORTH * tolerance * strength:
        return True
    if not loads:
        return False
    depths, bent = (start, there, half), 0.0
    for k in range(3):
        _note(run, depths[k], states[k], notes, k)
    for i in range(touched):
        bent += run.springs[SHARE, i] * abs(notes[LOAD, 2, i] - 0.5 * (notes[LOAD, 0, i] + notes[LOAD, 1, i]))
    return bent > straightness * strength


@compiled
def follow(
    run: Run,
    course: tuple[FloatArray, FloatArray],
    begin: FloatArray,
    states: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    rows: FloatArray,
    notes: FloatArray,
    division: Division,
) -> int:
    """
    Follow rows, or parts of rows on which the indentation is all but straight.

    Parameters
    ----------
    run : Run
    course : tuple of ndarray
        Times, and targets F + machine d.
    begin : ndarray
        Time, indentation, target and active springs before the first row; takes those after the last.
    states : tuple of ndarray
        Of the springs, four times the same; the first takes that after the last row.
    rows : ndarray
        Takes what a row or part ends with: its columns, the indentation, the row that it belongs to and its end as a share of that.
    notes : ndarray
        Unless it is empty, takes what springs bear before every row and after the last; of rows that are divided, room to compare
        loads.
    division : Division
        A part is halved where the indentation that meets its target half-way is not half-way to within the tolerance, or what the
        force is off there is worth more than a part of the tolerance times the strength; and, unless `notes` is empty, where the
        loads of the springs half-way are off a straight line by more than their tolerance of the strength.

    Returns
    -------
    int
        How many rows or parts were followed: fewer rows where the springs end. Or why rows were not divided.
    """
    now, here, before, from_target, active = begin[0], begin[1], begin[1], begin[2], int(begin[3])
    (state, old, new, half), (time, target), group, row = states, course, run.group, run.row
    divides, noted = division.strength.size > 0, notes.shape[1] > 0
    work, lost, parts, moved, ended = 0.0, 0.0, int(group[ALL, HELD]), active, False
    for r in range(time.size):
        whole, rise, done, size = time[r] - now, target[r] - from_target, 0.0, 1.0
        # levels of the first part, too long and short enough: what begins suddenly is short by many
        long, short = 0, _DEEPEST
        if noted and not divides:
            _note(run, here, old, notes, parts)
        while done < 1.0:
            if parts == rows.shape[0]:
                return FULL
            goal = target[r] if done + size == 1.0 else from_target + rise * (done + size)
            step_now = Now(here, before, whole * size, active)
            there, start, touched, most = _press(run, step_now, goal, old, new, not divides)
            moved = max(moved, most)
            if math.isinf(there):
                ended = True
                break
            for c in range(THERE):  # the middle of a part is worked out in the same place
                rows[parts, c] = row[c]
            halve = False
            if divides and size > 2.0**-_DEEPEST and whole * size > _TIMED * abs(time[r]):
                goals = from_target + rise * (done + 0.5 * size), goal, noted and size > _SUDDEN
                limits = division.tolerance, division.straightness, division.strength[r]
                halve = _is_bent(
                    run, step_now, goals, (there, start, touched), (old, new, half), notes, limits
                )
            if done == 0.0 and short - long > 1 and (halve or size < 1.0):
                level = round(-math.log2(size))
                long, short = (level, short) if halve else (long, level)
                if short - long > 1:
                    size = 2.0 ** -((long + short) // 2)
                    continue
                if halve:
                    size = 2.0**-short
                    continue
            elif halve:
                size *= 0.5
                continue
            before, here, active = start, there, touched
            old, new = new, old
            for i in range(active, moved):
                copy_spring(old, new, i)
            moved = active
            held = int(group[ALL, HELD])
            if held > 0 and strays(held, int(row[COUNT])):
                release(old, group)
            done += size
            work += rows[parts, WORK]
            lost += rows[parts, LOST]
            rows[parts, WORK], rows[parts, LOST], rows[parts, THERE] = work, lost, there
            rows[parts, OWNER], rows[parts, PART] = r, done
            parts += 1
            while size < 1.0 and (done / size) % 2.0 == 0.0:
                size *= 2.0
        if ended:
            break
        now, from_target = time[r], target[r]
    if ended and divides:
        return ENDED
    if noted and not divides:
        _note(run, here, old, notes, parts)
    release(old, group)
    for i in range(active):
        copy_spring(state, old, i)
    begin[0], begin[1], begin[2], begin[3] = now, here, from_target, active
    return parts
