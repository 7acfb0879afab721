"""Compiled histories of springs with memory: rows of indentations, forces or travels. Imported only when one is followed: it loads numba."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from pymdr.compiling import Addressed, call, inner, merged, uncounted
from pymdr.line.memory.groups import (
    edge_count,
    exchange_group,
    group_forces,
    is_outgrown,
    least_force,
    move_group,
    note_group,
)
from pymdr.line.memory.kernels import (
    BENT,
    COLUMNS,
    COUNT,
    DECAY,
    DISSIPATED,
    DK,
    FIRST_DECAY,
    FIRST_GAIN,
    FORCE,
    GROUP_DECAY,
    GROUP_GAIN,
    GROUP_MOVE,
    GROUPED,
    HEIGHT,
    INDENTATION,
    MEAN,
    MODULUS,
    OUTER,
    OWNER,
    PART,
    PARTS,
    RATE,
    STORED,
    WORK,
    Body,
    Move,
    step,
    straight,
)
from pymdr.line.memory.modes import BRANCHES, FREE, TURN, W
from pymdr.units import FloatArray

# the steps are compiled into the histories
ENDED, FULL, STUCK = -1, -2, -3
"""Why rows were not followed or divided: the springs end, there are more parts than rows to write, or no indentation meets a target."""
TIME, TARGET, STRENGTH = range(3)
"""Rows of the course: time, the target F + machine d, and the strength of every row in N for its division."""
LOAD, GAP, TURNED = range(3)
"""Notes on springs: the load per length without a parallel dashpot, the gap above free ones, -1 in contact, and the part of a row at
which they last changed sides."""
NOTES = 3
CUT, WHOLE = 1.0, 0.0
"""Whether forces are integrated up to the edge. Flags are floats: kernels are compiled once more for every constant of another type."""
_CLOSE = 1e-13
_NEWTON, TRIES = 100, 2400
"""Most steps of a search by Newton's method, and in all: halving the range of all numbers takes 2100."""
_DEEPEST = 48
"""Most halvings of a row."""
_SUDDEN = 2.0**-16
"""Fraction of a row below which it is not divided for loads, which jump with a dashpot."""
_WORTH = 0.1
"""Least work of a history, relative to its largest force times its largest indentation."""
_TIMED = 1e-13
"""Durations relative to the time, below which rounding determines them."""


class Run(NamedTuple):
    """The springs of a history, valid up to `limit`; an infinite machine stiffness prescribes d, 0 the force."""

    springs: FloatArray
    body: Body
    machine: float
    limit: float
    row: FloatArray
    step: Any
    history: Any
    """Addresses of :func:`pymdr.line.memory.kernels.step` and :func:`_follow_rows`."""


class Division(NamedTuple):
    """Tolerances by which rows are divided: of the indentation in m, and of loads relative to the strength, inf where they do not count."""

    tolerance: float
    straightness: float


class RowStart(NamedTuple):
    """Start of a row: the indentation, that before, the duration of the row, and how many springs were touched."""

    here: float
    before: float
    duration: float
    active: int


MET = 0.0, 0.0, int(0.0), int(0.0)
"""The type of what :func:`solve_row` returns."""


class Guess(NamedTuple):
    """Where a search for an indentation starts, its first guess, a bound of the stiffness, and the kind of the row."""

    here: float
    guess: float
    stiffest: float
    sudden: bool
    """A dashpot takes the load in no time."""
    lift: bool
    """The force is 0."""
    parting: bool
    """The bodies part at once, and then rest on each other."""


def run_of(
    springs: FloatArray, body: Body, machine: float, limit: float, state: FloatArray
) -> tuple[Run, Any]:
    """What kernels follow, and how they do: springs whose state has the shape of `state`, on a machine."""
    row = np.zeros(COLUMNS)
    by_address = step.address(None, springs, body, Move(0.0, 0.0, 0.0, 0.0), (0, 0, 0.0), state, state, row)
    run = Run(springs, body, machine, limit, row, by_address, 0)
    by_target = move_to if math.isinf(machine) else solve_row
    meet = by_target.address(MET, run, RowStart(0.0, 0.0, 0.0, 0), 0.0, state, state)
    notes = np.zeros((NOTES, 0, 0))
    history = _follow_rows.address(0, run, state, np.zeros(4), (state, state), state, notes, meet)
    return run._replace(history=history), meet


@inner
def copy_spring(state: FloatArray, other: FloatArray, i: int) -> None:
    """Copy a spring, number by number: slices of arrays take seconds to compile."""
    for j in range(state.shape[1]):
        state[i, j] = other[i, j]


@inner
def _record_loads(run: Run, depth: float, state: FloatArray, notes: FloatArray, r: int) -> None:
    """Note loads and gaps of all springs."""
    body, table, known = run.body, run.body.table, run.body.known
    grouped, same = int(known[GROUPED]), body.equilibrium * known[GROUP_MOVE]
    for j in range(body.branches):
        same += table[j, GROUP_GAIN]
    for i in range(notes.shape[2]):
        member = i < grouped
        free = not member and state[i, FREE] != 0.0
        q = body.equilibrium * state[i, W] + (same if member else 0.0)
        for j in range(body.branches):
            q += (table[j, GROUP_DECAY] if member else 1.0) * state[i, BRANCHES + j]
        notes[LOAD, r, i] = 0.0 if free else q
        notes[GAP, r, i] = max(state[i, W] + run.springs[HEIGHT, i] - depth, 0.0) if free else -1.0
        notes[TURNED, r, i] = 0.0 if member else state[i, TURN]


@inner
def _separation(springs: FloatArray, state: FloatArray, active: int) -> float:
    """The largest indentation at which no spring is touched, of springs that are all free."""
    if active == 0:  # of bodies that have not touched
        return 0.0
    depth = springs[HEIGHT, active] if active < springs.shape[1] else math.inf
    for i in range(active):
        depth = min(depth, springs[HEIGHT, i] + state[i, W])
    return float(depth)


@merged
def _count_touched(springs: FloatArray, active: int, depth: float) -> int:
    """Number of springs that a depth touches, at least the active ones."""
    touched = active
    while touched < springs.shape[1] and springs[HEIGHT, touched] < depth:
        touched += 1
    return touched


@inner
def _count_in_contact(count: int, active: int, state: FloatArray) -> int:
    """Number of springs in contact from the innermost on, of which `count` surely are."""
    while count < active and state[count, FREE] == 0.0:
        count += 1
    return count


@merged
def _first_guess(run: Run, now: RowStart, target: float, old: FloatArray, new: FloatArray) -> Guess:
    """The first guess of an indentation; springs well within the contact are grouped, or released where that is not possible."""
    springs, body, machine = run.springs, run.body, run.machine
    here, lift = now.here, machine == 0.0 and target <= 0.0
    sudden = body.viscosity > 0.0 and now.duration == 0.0
    if lift or sudden:
        call(body.dissolve, None, (old, body))
    elif body.known[GROUPED] == 0.0:
        count = _count_in_contact(int(run.body.known[GROUPED]), now.active, old)
        call(body.form, None, (springs, count, old, new, body))
    if body.known[GROUPED] == 0.0:
        if machine == 0.0 and not lift:  # separated bodies rest on each other before a force presses
            here = max(here, _separation(springs, old, now.active))
        elif sudden and machine > 0.0:
            here = max(here, min(_separation(springs, old, now.active), target / machine))
    springy = body.equilibrium
    for j in range(body.branches):
        springy += body.table[j, MODULUS]
    last = springs.shape[1] - 1
    stiffest = springy
    if body.viscosity > 0.0:
        stiffest += body.viscosity / (1.0 if sudden else now.duration)
    guess = min(2.0 * here - now.before, run.limit)
    parting = lift or (sudden and target < machine * here)
    if parting:
        guess = here - 1e2 * (springs[HEIGHT, last] + abs(here))
        if sudden:  # by a load that no spring of the body withstands
            guess += (guess - here) * springy / body.viscosity
    return Guess(here, guess, stiffest * springs[OUTER, last], sudden, lift, parting)


@merged
def _move_springs(
    run: Run, move: Move, limits: tuple[int, int, float], old: FloatArray, new: FloatArray
) -> float:
    """Move springs and their group; returns how many of those moved one by one are in contact."""
    row = run.row
    call(run.step, None, (run.springs, run.body, move, limits, old, new, row))
    alone, grouped = row[COUNT], limits[0]
    if grouped > 0:
        force, rate, stored, work, dissipated = group_forces(run.body, move)
        row[FORCE] += force
        row[RATE] += rate
        row[STORED] += stored
        row[WORK] += work
        row[DISSIPATED] += dissipated
        row[COUNT] += grouped
        row[PARTS] += grouped
    return float(alone)


@Addressed
def move_to(
    run: Run, now: RowStart, depth: float, old: FloatArray, new: FloatArray
) -> tuple[float, float, int, int]:
    """Move springs straight to an indentation; returns what :func:`solve_row` does."""
    springs, body = run.springs, run.body
    sudden = body.viscosity > 0.0 and now.duration == 0.0
    if sudden:
        call(body.dissolve, None, (old, body))
    elif body.known[GROUPED] == 0.0:
        count = _count_in_contact(int(body.known[GROUPED]), now.active, old)
        call(body.form, None, (springs, count, old, new, body))
    touched = _count_touched(springs, now.active, now.here if sudden else max(now.here, depth))
    move = straight(body.viscosity, now.here, depth, now.duration)
    grouped = int(body.known[GROUPED])
    alone = _move_springs(run, move, (grouped, touched, CUT), old, new)
    if grouped > 0:
        # without two springs next to the group the edge is unknown
        if alone >= 2.0 and least_force(body, move) >= 0.0:
            move_group(body, move.change)
        else:
            call(body.dissolve, None, (old, body))
            every = int(body.known[GROUPED]), touched, CUT
            call(run.step, None, (springs, body, move, every, old, new, run.row))
    return depth, now.here, touched, touched


@Addressed
def solve_row(
    run: Run, now: RowStart, target: float, old: FloatArray, new: FloatArray
) -> tuple[float, float, int, int]:
    """
    Move springs straight to where the target of a row is met, on a machine of finite stiffness.

    Springs well within the contact move as one while all of them surely stay in it. They get their own values where they may not.

    Returns the indentation, where it starts, the springs touched, and those moved in the search. The indentation is inf where the
    springs end; without a force it is where the bodies part. It is nan if the search does not converge.
    """
    springs, body, known, row = run.springs, run.body, run.body.known, run.row
    machine, limit, active, most = run.machine, run.limit, now.active, now.active
    here, guess, stiffest, sudden, lift, parting = _first_guess(run, now, target, old, new)
    low, high, out, edge, whole, tries = -math.inf, math.inf, 0.0, 0, False, 0
    if known[GROUPED] > 0.0:
        edge = _count_in_contact(int(known[GROUPED]), active, old)
    while True:
        tries += 1
        touched = _count_touched(springs, active, here if sudden else max(here, guess))
        most = max(most, touched)
        grouped = int(known[GROUPED])
        near = touched if grouped == 0 or whole else min(touched, edge + edge_count(edge))
        move = straight(body.viscosity, here, guess, now.duration)
        alone = _move_springs(run, move, (grouped, near, WHOLE), old, new)
        if parting:
            if lift:
                return _separation(springs, new, touched), here, touched, most
            row[FORCE] = 0.0
            return target / machine, here, touched, most
        place = here if sudden else guess
        over, small = row[FORCE] + machine * place - target, _CLOSE * (abs(target) + machine * abs(place))
        close = abs(over) <= small or (sudden and row[COUNT] == 0.0)  # nothing bears the load yet
        if not close:
            low, high = (low, min(high, guess)) if over > 0.0 else (max(low, guess), high)
        enclosed = low > -math.inf and high < math.inf
        close |= enclosed and high - low <= 4e-16 * max(abs(high), abs(low), abs(here))
        ends = limit <= low < math.inf and not sudden
        if grouped > 0 and (close or ends):
            # without two springs next to the group the edge is unknown
            stays = near < touched or (alone >= 2.0 and least_force(body, move) >= 0.0)
            if stays and near == touched:
                if close:
                    move_group(body, move.change)
                break
            if not stays:
                call(body.dissolve, None, (old, body))
            whole, low, high, out = True, -math.inf, math.inf, 0.0  # with all springs, from here
            continue
        if close or ends:
            break
        if tries > TRIES:
            return math.nan, here, touched, most
        slope = row[RATE] + (0.0 if sudden else machine)
        newton = guess - over / slope if slope > 0.0 and tries < _NEWTON else math.nan
        if low < newton < high:
            guess = newton if newton < limit or sudden else limit
        elif not enclosed:
            out = max(2.0 * out, abs(over) / stiffest, 1e-15 * abs(guess), 1e-300)
            guess = (low + out if sudden else min(low + out, limit)) if math.isinf(high) else high - out
        else:
            guess = 0.5 * (low + high)
    if not close:
        return math.inf, here, touched, most
    if sudden or (machine > 0.0 and abs(over) > small):
        # where springs touch all at once, the force is between those beside
        row[FORCE] = max(target - machine * place, 0.0)
    return place, here, touched, most


@merged
def _must_halve(
    run: Run,
    now: RowStart,
    goals: tuple[float, float, bool],
    place: tuple[float, float, int],
    states: tuple[FloatArray, FloatArray, FloatArray],
    limits: tuple[float, float, float],
) -> bool:
    """
    Whether a part is to be halved.

    `goals` are the targets half-way and at the end, and whether loads count; `place` the indentation, where it starts and the
    springs touched; `states` those before, after and half-way, of a group as noted and as it is; `limits` the tolerance in m, the
    straightness of loads and the strength of the row in N.
    """
    middle, goal, loads = goals
    there, start, touched = place
    tolerance, straightness, strength = limits
    body, slope, lift = run.body, run.row[RATE], run.machine == 0.0 and goal <= 0.0
    half = start if lift else 0.5 * (start + there)
    move = straight(body.viscosity, start, half, 0.5 * now.duration)
    every = int(body.known[GROUPED]), touched, CUT if math.isinf(run.machine) else WHOLE
    exchange_group(body)
    _move_springs(run, move, every, states[0], states[2])
    exchange_group(body)
    over = 0.0
    if lift:  # what is parted in one part bears nothing half-way
        over, slope = middle, run.row[RATE]
    elif not math.isinf(run.machine):
        over = abs(run.row[FORCE] + run.machine * half - middle)
        slope = max(run.row[RATE], slope) + run.machine
    if over > tolerance * slope or over * abs(there - start) > _WORTH * tolerance * strength:
        return True
    return loads and _bent_loads(run, move.change, touched, states, lift) > straightness * strength


@merged
def _bent_loads(
    run: Run, change: float, touched: int, states: tuple[FloatArray, FloatArray, FloatArray], lift: bool
) -> float:
    """How far the loads of springs half-way through a part are off the middle of those before and after, summed in N."""
    body, table, grouped = run.body, run.body.table, int(run.body.known[GROUPED])
    bent, same = 0.0, 0.0
    for j in range(body.branches):
        gain = table[j, DECAY] * table[j, FIRST_GAIN] + table[j, MEAN] * (table[j, MODULUS] * change)
        same += gain - 0.5 * (table[j, FIRST_GAIN] + table[j, GROUP_GAIN])
        mean = 0.5 * (table[j, FIRST_DECAY] + table[j, GROUP_DECAY])
        table[j, BENT] = table[j, DECAY] * table[j, FIRST_DECAY] - mean
    for i in range(grouped):
        load = same
        for j in range(body.branches):
            load += table[j, BENT] * states[0][i, BRANCHES + j]
        bent += run.springs[DK, i] * abs(load)
    for i in range(grouped, touched):
        load = 0.0 if lift else _load(body, states[2], i)
        bent += run.springs[DK, i] * abs(load - 0.5 * (_load(body, states[0], i) + _load(body, states[1], i)))
    return float(bent)


@inner
def _load(body: Body, state: FloatArray, i: int) -> float:
    """The load of a spring that is not grouped, without a parallel dashpot."""
    if state[i, FREE] != 0.0:
        return 0.0
    q = body.equilibrium * state[i, W]
    for j in range(body.branches):
        q += state[i, BRANCHES + j]
    return float(q)


@merged
def _next_size(halve: bool, first: bool, size: float, levels: tuple[int, int]) -> tuple[float, int, int]:
    """
    Size of the part to try next, the same if it is accepted, and the levels of the first part: too long and short enough.

    What starts suddenly needs many halvings, so the level of the first part is bisected.
    """
    long, short = levels
    if first and short - long > 1 and (halve or size < 1.0):
        level = round(-math.log2(size))
        if halve:
            long = level
        else:
            short = level
        if short - long > 1:
            size = 2.0 ** -((long + short) // 2)
        elif halve:
            size = 2.0**-short
    elif halve:
        size *= 0.5
    return size, long, short


@Addressed
def _follow_rows(
    run: Run,
    course: FloatArray,
    start: FloatArray,
    states: tuple[FloatArray, FloatArray],
    rows: FloatArray,
    notes: FloatArray,
    meet: Any,
) -> int:
    """As :func:`follow`."""
    now, here, before, target, active = start[0], start[1], start[1], start[2], int(start[3])
    (state, new), body, known, row = states, run.body, run.body.known, run.row
    old, done = state, int(0.0)  # numbers: kernels are compiled once more for constants
    work, dissipated = 0.0, 0.0
    for r in range(course.shape[1]):
        if notes.shape[1] > 0:
            _record_loads(run, here, old, notes, r)
        goal = course[TARGET, r]
        part = RowStart(here, before, course[TIME, r] - now, active)
        there, begin, touched, most = call(meet, MET, (run, part, goal, old, new))
        if math.isnan(there):
            start[0] = course[TIME, r]
            return STUCK
        # both states are equal beyond the touched springs, also where the springs end and the row is not taken
        for i in range(active if math.isinf(there) else touched, most):
            copy_spring(new, old, i)
        if math.isinf(there):
            break
        for c in range(INDENTATION):
            rows[r, c] = row[c]
        before, here, active = begin, there, touched
        old, new = new, old
        grouped = int(known[GROUPED])
        if grouped > 0 and is_outgrown(grouped, int(row[COUNT])):
            call(body.dissolve, None, (old, body))
        work += row[WORK]
        dissipated += row[DISSIPATED]
        rows[r, WORK], rows[r, DISSIPATED], rows[r, INDENTATION] = work, dissipated, there
        now, target, done = course[TIME, r], goal, r + 1
    if notes.shape[1] > 0:
        _record_loads(run, here, old, notes, done)
    call(body.dissolve, None, (old, body))
    for i in range(active):
        copy_spring(state, old, i)
    start[0], start[1], start[2], start[3] = now, here, target, active
    return done


@uncounted
def follow(
    run: Run,
    course: FloatArray,
    start: FloatArray,
    states: tuple[FloatArray, FloatArray],
    rows: FloatArray,
    notes: FloatArray,
    meet: Any,
) -> int:
    """
    Follow rows on which the indentation is straight.

    Parameters
    ----------
    course : ndarray, shape (3, m)
    start : ndarray
        Time, indentation, target and active springs before the first row; takes those after the last.
    states : tuple of ndarray
        Of the springs, two equal ones; the first takes that after the last row.
    rows : ndarray
        Takes the end of each row: its columns, and the indentation.
    notes : ndarray
        Takes the loads of springs before every row and after the last, unless it is empty.
    meet : int
        The address of what meets the target of a row: :func:`move_to` of an indentation, :func:`solve_row` of others.

    Returns
    -------
    int
        How many rows were followed: fewer where the springs end. STUCK if no indentation meets a target; the start takes its time.
    """
    return int(call(run.history, 0, (run, course, start, states, rows, notes, meet)))


@uncounted
def divide(
    run: Run,
    course: FloatArray,
    start: FloatArray,
    states: tuple[FloatArray, FloatArray, FloatArray],
    rows: FloatArray,
    meet: Any,
    division: Division,
) -> int:
    """
    Divide rows into parts on which the indentation is all but straight.

    Parameters
    ----------
    states : tuple of ndarray
        Of the springs, three equal ones.
    rows : ndarray
        Takes the row of each part, and its end as a fraction of that.
    division : Division
        A part is halved where the indentation that meets its target half-way is off the middle by more than the tolerance, or the
        work of the difference exceeds a part of tolerance times strength; and where the loads half-way are off a straight line by
        more than the straightness times the strength.

    Returns
    -------
    int
        How many parts, or why rows were not divided.
    """
    now, here, before, target, active = start[0], start[1], start[1], start[2], int(start[3])
    (old, new, half), loads = states, division.straightness < math.inf
    body, known = run.body, run.body.known
    deepest = float(_DEEPEST)  # numbers: kernels are compiled once more for constants
    parts, moved = int(0.0), active
    for r in range(course.shape[1]):
        whole, rise, done, size = course[TIME, r] - now, course[TARGET, r] - target, 0.0, 1.0
        long, short = int(0.0), int(deepest)
        while done < 1.0:
            if parts == rows.shape[0]:
                return FULL
            goal = course[TARGET, r] if done + size == 1.0 else target + rise * (done + size)
            part = RowStart(here, before, whole * size, active)
            note_group(body)
            there, begin, touched, most = call(meet, MET, (run, part, goal, old, new))
            moved, count = max(moved, most), int(run.row[COUNT])
            if not math.isfinite(there):
                return ENDED if math.isinf(there) else STUCK
            halve = False
            if size > 2.0**-_DEEPEST and whole * size > _TIMED * abs(course[TIME, r]):
                goals = target + rise * (done + 0.5 * size), goal, loads and size > _SUDDEN
                limits = division.tolerance, division.straightness, course[STRENGTH, r]
                halve = _must_halve(run, part, goals, (there, begin, touched), (old, new, half), limits)
            tried = size
            size, long, short = _next_size(halve, done == 0.0, size, (long, short))
            if size != tried:
                exchange_group(body)  # where one was dissolved, this changes nothing
                continue
            before, here, active = begin, there, touched
            old, new = new, old
            for i in range(active, moved):
                copy_spring(old, new, i)
            moved, grouped = active, int(known[GROUPED])
            if grouped > 0 and is_outgrown(grouped, count):
                call(body.dissolve, None, (old, body))
            done += size
            rows[parts, OWNER], rows[parts, PART] = r, done
            parts += 1
            while size < 1.0 and (done / size) % 2.0 == 0.0:
                size *= 2.0
        now, target = course[TIME, r], course[TARGET, r]
    return parts
