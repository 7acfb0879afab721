"""Compiled histories of springs with memory: rows of indentations, forces or travels. Imported only when one is followed: it loads numba."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pymdr import compiling
from pymdr.compiling import inner
from pymdr.line.memory.kernels import (
    COLUMNS,
    COUNT,
    FORCE,
    FREE,
    HEIGHT,
    LOST,
    OUTER,
    PARTS,
    RATE,
    SHARE,
    STORED,
    TURN,
    WORK,
    Body,
    Room,
    State,
    step,
    straight,
)
from pymdr.line.memory.together import (
    GAINED,
    HELD,
    LEFT,
    SINCE,
    Group,
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


class Course(NamedTuple):
    """Rows to follow: targets F + machine d; an infinite machine prescribes d, one of 0 the force. Springs end at `limit`."""

    time: FloatArray
    target: FloatArray
    machine: float
    limit: float


class Run(NamedTuple):
    """What a history is followed with."""

    springs: FloatArray
    body: Body
    machine: float
    limit: float
    room: Room
    group: Group
    row: FloatArray
    copies: tuple[State, State, State]


class Now(NamedTuple):
    """Where a row begins: the indentation, that before, the duration of the row, and how many springs were touched."""

    here: float
    before: float
    duration: float
    active: int


@inner
def copy_state(state: State, other: State, first: int) -> None:
    """Take the springs from `first` on over, number by number: slices of arrays take seconds to compile."""
    for i in range(first, state.w.size):
        state.w[i] = other.w[i]
        for j in range(state.z.shape[1]):
            state.z[i, j] = other.z[i, j]
        for j in range(state.free.shape[0]):
            state.free[j, i] = other.free[j, i]


@inner
def _note(
    springs: FloatArray, body: Body, depth: float, state: State, group: Group, notes: FloatArray, r: int
) -> None:
    """Note what springs bear, or how far they are away."""
    held, same = int(group.whole[HELD]), body.equilibrium * group.whole[SINCE]
    for j in range(body.moduli.size):
        same += group.branches[GAINED, j]
    for i in range(notes.shape[2]):
        if i >= held and state.free[FREE, i] != 0.0:
            notes[LOAD, r, i], notes[GAP, r, i] = 0.0, max(state.w[i] + springs[HEIGHT, i] - depth, 0.0)
            notes[TURNED, r, i] = state.free[TURN, i]
            continue
        q = body.equilibrium * state.w[i]
        if i < held:
            q += same
            for j in range(body.moduli.size):
                q += group.branches[LEFT, j] * state.z[i, j]
        else:
            for j in range(body.moduli.size):
                q += state.z[i, j]
        notes[LOAD, r, i], notes[GAP, r, i], notes[TURNED, r, i] = (
            q,
            -1.0,
            0.0 if i < held else state.free[TURN, i],
        )


@inner
def _rest(springs: FloatArray, w: FloatArray, active: int) -> float:
    """The largest indentation at which no spring is touched, of those that are all free."""
    if active == 0:  # of bodies that have not touched
        return 0.0
    depth = springs[HEIGHT, active] if active < springs.shape[1] else math.inf
    for i in range(active):
        depth = min(depth, springs[HEIGHT, i] + w[i])
    return float(depth)


@inner
def _touched(springs: FloatArray, active: int, depth: float) -> int:
    """How many springs a depth reaches, and no fewer than are active."""
    touched = active
    while touched < springs.shape[1] and springs[HEIGHT, touched] < depth:
        touched += 1
    return touched


@inner
def active_springs(state: State) -> int:
    """Springs up to the last one that bears something or has not crept back."""
    active = state.w.size
    while active > 0 and state.free[FREE, active - 1] != 0.0 and state.w[active - 1] == 0.0:
        for j in range(state.z.shape[1]):
            if state.z[active - 1, j] != 0.0:
                return active
        active -= 1
    return active


@inner
def _touching(count: int, active: int, free: FloatArray) -> int:
    """How many springs touch from the innermost on, where some surely do."""
    while count < active and free[FREE, count] == 0.0:
        count += 1
    return count


@inner
def _borne(run: Run, now: Now, guess: float, near: int, old: State, new: State) -> float:
    """Move the springs to a guess, those of the group as one; returns how many are in contact beside it."""
    body, row, whole = run.body, run.row, run.group.whole
    move = straight(body, now.here, guess, now.duration)
    step(run.springs, body, move, (int(whole[HELD]), near, math.isinf(run.machine)), old, new, run.room, row)
    alone = row[COUNT]  # without two beside those that move as one, no edge is known
    if whole[HELD] > 0.0:
        force, rate, stored, work, lost = bear(body, move, run.group, run.room.branch)
        row[FORCE] += force
        row[RATE] += rate
        row[STORED] += stored
        row[WORK] += work
        row[LOST] += lost
        row[COUNT] += whole[HELD]
        row[PARTS] += whole[HELD]
    return float(alone)


@inner
def _press(
    run: Run, now: Now, target: float, old: State, new: State, lasting: bool
) -> tuple[float, float, int]:
    """
    Move springs straight to where the target of a row is met.

    Springs well within the contact move as one while all of them surely stay in it, and are given what they have only where they
    may not; or at the end, unless that is `lasting`.

    Returns the indentation there, where it starts, and the springs touched. The indentation is inf where the springs end. Without
    a force it is where the bodies part.
    """
    springs, body, group, row, machine, limit = (
        run.springs,
        run.body,
        run.group,
        run.row,
        run.machine,
        run.limit,
    )
    here, active = now.here, now.active
    lift, by_depth = machine == 0.0 and target <= 0.0, math.isinf(machine)
    sudden = body.viscosity > 0.0 and now.duration == 0.0  # a dashpot takes the load where it is
    if lift or sudden:
        release(old, group)
    elif group.whole[HELD] == 0.0 and (lasting or not by_depth):
        join(springs, _touching(0, active, old.free), old, new, group)
    if machine == 0.0 and not lift and group.whole[HELD] == 0.0:
        # bodies that are apart rest on each other before a force presses
        here = max(here, _rest(springs, old.w, active))
    elif sudden and 0.0 < machine < math.inf:
        here = max(here, min(_rest(springs, old.w, active), target / machine))
    now = Now(here, now.before, now.duration, active)
    springy = body.equilibrium
    for j in range(body.moduli.size):
        springy += body.moduli[j]
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
    if group.whole[HELD] > 0.0 and not whole:
        edge = _touching(int(group.whole[HELD]), active, old.free)
    while True:
        touched = _touched(springs, active, here if sudden else max(here, guess))
        held = int(group.whole[HELD])
        near = touched if held == 0 or whole else min(touched, edge + beside(edge))
        alone = _borne(run, now, guess, near, old, new)
        if held == 0 and by_depth:
            return guess, here, touched
        if lift:
            return _rest(springs, new.w, touched), here, touched
        if parting:
            row[FORCE] = 0.0
            return target / machine, here, touched
        over = 0.0 if by_depth else row[FORCE] + machine * (here if sudden else guess) - target
        close = by_depth or abs(over) <= _CLOSE * (abs(target) + machine * abs(here if sudden else guess))
        close |= sudden and row[COUNT] == 0.0  # nothing bears the load yet
        if not close:
            low, high = (low, min(high, guess)) if over > 0.0 else (max(low, guess), high)
        enclosed = low > -math.inf and high < math.inf
        close |= enclosed and high - low <= 4e-16 * max(abs(high), abs(low), abs(here))
        ends = low >= limit and not sudden
        if held > 0 and (close or ends):
            move = straight(body, here, guess, now.duration)
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
        return math.inf, here, touched
    if sudden or (machine > 0.0 and abs(over) > _CLOSE * (abs(target) + machine * abs(guess))):
        # where springs touch all at once, the force is between those beside
        row[FORCE] = max(target - machine * (here if sudden else guess), 0.0)
    return here if sudden else guess, here, touched


@compiled
def follow(
    run: Run, course: Course, begin: FloatArray, state: State, rows: FloatArray, notes: FloatArray
) -> int:
    """
    Follow rows from begin = (time, indentation); returns how many were followed: fewer where the springs end.

    The indentation of every row is noted in its last column. `notes`, of one row more, take what springs bear before every row and
    after the last, unless they are empty.
    """
    now, here, before = begin[0], begin[1], begin[1]
    group, (old, new, _) = run.group, run.copies
    watched = notes.shape[1] > 0
    if watched:
        _note(run.springs, run.body, here, state, group, notes, 0)
    active = active_springs(state)
    copy_state(old, state, 0)
    copy_state(new, state, 0)
    work, lost, followed = 0.0, 0.0, 0
    for r in range(course.time.size):
        step_now = Now(here, before, course.time[r] - now, active)
        there, here, touched = _press(run, step_now, course.target[r], old, new, r >= 0)
        if math.isinf(there):
            here = step_now.here
            break
        active = touched
        old, new = new, old
        copy_state(old, new, active)
        held, row = int(group.whole[HELD]), run.row
        if held > 0 and strays(held, int(row[COUNT])):
            release(old, group)
        work += row[WORK]
        lost += row[LOST]
        for c in range(COLUMNS):
            rows[r, c] = row[c]
        rows[r, WORK], rows[r, LOST], rows[r, COLUMNS] = work, lost, there
        before, here, now, followed = here, there, course.time[r], r + 1
        if watched:
            _note(run.springs, run.body, here, old, group, notes, r + 1)
    release(old, group)
    copy_state(state, old, 0)
    begin[0], begin[1] = now, here
    return followed


@inner
def _half_way(
    run: Run, half: float, ways: tuple[float, float, float], touched: int, states: tuple[State, State, State]
) -> tuple[float, float]:
    """The force and its slope of springs that go half of the time from the first of `ways` to an indentation."""
    old, _, middle = states
    move = straight(run.body, ways[0], half, 0.5 * ways[2])
    # a constant would compile the kernel once more
    first = min(touched, 0)
    step(
        run.springs, run.body, move, (first, touched, math.isinf(run.machine)), old, middle, run.room, run.row
    )
    return run.row[FORCE], run.row[RATE]


@inner
def _bent(
    run: Run,
    half: float,
    ways: tuple[float, float, float],
    touched: int,
    states: tuple[State, State, State],
    notes: FloatArray,
) -> float:
    """By how much the loads of springs are off a straight line then, in N."""
    old, end, middle = states
    _note(run.springs, run.body, ways[0], old, run.group, notes, 0)
    _note(run.springs, run.body, half, middle, run.group, notes, 1)
    _note(run.springs, run.body, ways[1], end, run.group, notes, 2)
    bent = 0.0
    for i in range(touched):
        bent += run.springs[SHARE, i] * abs(notes[LOAD, 1, i] - 0.5 * (notes[LOAD, 0, i] + notes[LOAD, 2, i]))
    return bent


@inner
def _halves(
    run: Run, now: Now, goals: tuple[float, float, bool], found: tuple[float, float, int], states: tuple[State, State, State],
    notes: FloatArray, limits: tuple[float, float, float],
) -> bool:  # fmt: skip
    """
    Whether a part is to be halved.

    `goals` are the targets half-way and in the end, and whether loads count; `found` what `_press` returned; `limits` the tolerance in
    m, the straightness of loads and the strength of the row in N, as `divide` takes them.
    """
    middle, goal, loads = goals
    there, start, touched = found
    tolerance, straightness, strength = limits
    slope = run.row[RATE]
    lift = run.machine == 0.0 and goal <= 0.0
    half = start if lift else 0.5 * (start + there)
    ways = start, there, now.duration
    force, rate = _half_way(run, half, ways, touched, states)
    over = 0.0
    if lift:  # what is parted in one part bears nothing half-way
        over, slope = middle, rate
    elif not math.isinf(run.machine):
        over, slope = abs(force + run.machine * half - middle), max(rate, slope) + run.machine
    if over > tolerance * slope or over * abs(there - start) > _WORTH * tolerance * strength:
        return True
    return loads and _bent(run, half, ways, touched, states, notes) > straightness * strength


@compiled
def divide(
    run: Run,
    course: Course,
    begin: FloatArray,
    limits: tuple[float, float, FloatArray],
    state: State,
    notes: FloatArray,
    owner: np.ndarray,
    shares: FloatArray,
) -> int:
    """
    Divide rows from begin = (time, indentation, target) into parts on which the indentation is all but straight.

    `limits` are a tolerance in m, one of loads, and the strength of every row in N. A part is halved where the indentation that meets
    its target half-way is not half-way to within the tolerance, or what the force is off there is worth more than a part of the
    tolerance times the strength; and, unless `notes` is empty, where the loads of the springs half-way are off a straight line by
    more than their tolerance of the strength. Returns how many parts there are, with the row and the end of each, as a share of
    it, in `owner` and `shares`, or why not.
    """
    now, here, before, from_target = begin[0], begin[1], begin[1], begin[2]
    active = active_springs(state)
    old, new, half = run.copies
    copy_state(old, state, 0)
    copy_state(new, state, 0)
    copy_state(half, state, 0)
    tolerance, straightness, strength = limits
    parts = 0
    for r in range(course.time.size):
        whole, rise, done, size = course.time[r] - now, course.target[r] - from_target, 0.0, 1.0
        # levels of the first part, too long and short enough: what begins suddenly is short by many
        long, short = 0, _DEEPEST
        while done < 1.0:
            if parts == owner.size:
                return FULL
            goal = course.target[r] if done + size == 1.0 else from_target + rise * (done + size)
            step_now = Now(here, before, whole * size, active)
            found = _press(run, step_now, goal, old, new, size > 1.0)
            if math.isinf(found[0]):
                return ENDED
            halve = False
            if size > 2.0**-_DEEPEST and whole * size > _TIMED * abs(course.time[r]):
                goals = from_target + rise * (done + 0.5 * size), goal, notes.shape[1] > 0 and size > _SUDDEN
                bounds = tolerance, straightness, strength[r]
                halve = _halves(run, step_now, goals, found, (old, new, half), notes, bounds)
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
            before, here, active = found[1], found[0], found[2]
            old, new = new, old
            copy_state(old, new, active)
            done += size
            owner[parts], shares[parts] = r, done
            parts += 1
            while size < 1.0 and (done / size) % 2.0 == 0.0:
                size *= 2.0
        now, from_target = course.time[r], course.target[r]
    return parts
