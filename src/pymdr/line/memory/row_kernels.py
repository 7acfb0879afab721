"""Compiled histories of springs with memory: rows of indentations, forces or travels. Imported only when one is followed: it loads numba."""

from __future__ import annotations

import math

import numpy as np

from pymdr import compiling
from pymdr.line.memory.kernels import (
    COLUMNS,
    COUNT,
    DECAY,
    FORCE,
    FREE,
    HEIGHT,
    LEVELS,
    LOST,
    MEAN,
    OUTER,
    PARTS,
    RATE,
    SHARE,
    STORED,
    TURN,
    WORK,
    step,
)
from pymdr.line.memory.together import (
    BRANCHES,
    GAINED,
    GROUP,
    HELD,
    LEAST,
    LEFT,
    LOWEST,
    SINCE,
    bear,
    beside,
    carry,
    join,
    release,
    strays,
)
from pymdr.units import FloatArray

# the steps are compiled into the histories
_STAMP = compiling.stamp_of(__file__)


def compiled(function: compiling.Function) -> compiling.Function:
    """Compile with numba when first called; kept on disk."""
    return compiling.compiled(function, _STAMP)


ENDED, FULL, GIVEN_UP = -1, -2, -3
"""Why rows were not divided: the springs end, the parts are more than there is room for, a spring was given up."""
_CLOSE = 1e-13
_DEEPEST = 48
"""How often a row is halved at most."""
_SUDDEN = 2.0**-16
"""Part of a row below which it is not divided for loads, which a dashpot lets jump."""
_WORTH = 0.1
"""Of the largest force times the largest indentation: about the least work of a history that goes there."""
_TIMED = 1e-13
"""Of the time: parts of rows below which rounding tells how long they are."""


@compiled
def _keep(
    w: FloatArray,
    z: FloatArray,
    free: FloatArray,
    w_other: FloatArray,
    z_other: FloatArray,
    free_other: FloatArray,
    first: int,
) -> None:
    """Take the springs from `first` on over, number by number: slices of arrays take seconds to compile."""
    for i in range(first, w.size):
        w[i] = w_other[i]
        for j in range(z.shape[1]):
            z[i, j] = z_other[i, j]
        for j in range(free.shape[0]):
            free[j, i] = free_other[j, i]


@compiled
def _note(
    springs: FloatArray,
    equilibrium: float,
    n: int,
    depth: float,
    w: FloatArray,
    z: FloatArray,
    free: FloatArray,
    group: FloatArray,
    branches: FloatArray,
    load: FloatArray,
    gap: FloatArray,
    turn: FloatArray,
) -> None:
    """
    What springs in contact bear without the dashpot beside them, how far the free ones are, and when springs changed sides.

    The gap is -1 in contact, the last a part of the row.
    """
    held, same = int(group[HELD]), equilibrium * group[SINCE]
    for j in range(n):
        same += branches[GAINED, j]
    for i in range(held):
        q = equilibrium * w[i] + same
        for j in range(n):
            q += branches[LEFT, j] * z[i, j]
        load[i], gap[i], turn[i] = q, -1.0, 0.0
    for i in range(held, load.size):
        turn[i] = free[TURN, i]
        if free[FREE, i] != 0.0:
            load[i], gap[i] = 0.0, max(w[i] + springs[HEIGHT, i] - depth, 0.0)
            continue
        q = equilibrium * w[i]
        for j in range(n):
            q += z[i, j]
        load[i], gap[i] = q, -1.0


@compiled
def _rest(springs: FloatArray, w: FloatArray, active: int) -> float:
    """The largest indentation at which no spring is touched, of those that are all free."""
    if active == 0:  # of bodies that have not touched
        return 0.0
    depth = springs[HEIGHT, active] if active < springs.shape[1] else math.inf
    for i in range(active):
        depth = min(depth, springs[HEIGHT, i] + w[i])
    return float(depth)


@compiled
def _touched(springs: FloatArray, active: int, depth: float) -> int:
    """How many springs a depth reaches, and no fewer than are active."""
    touched = active
    while touched < springs.shape[1] and springs[HEIGHT, touched] < depth:
        touched += 1
    return touched


@compiled
def _active(w: FloatArray, z: FloatArray, free: FloatArray) -> int:
    """Springs up to the last one that bears something or has not crept back."""
    active = w.size
    while (
        active > 0
        and free[0, active - 1] != 0.0
        and w[active - 1] == 0.0
        and not np.any(z[active - 1] != 0.0)
    ):
        active -= 1
    return active


@compiled
def _touching(count: int, active: int, free: FloatArray) -> int:
    """How many springs touch from the innermost on, where some surely do."""
    while count < active and free[FREE, count] == 0.0:
        count += 1
    return count


@compiled
def _stays(
    body: FloatArray,
    moduli: FloatArray,
    duration: float,
    move: float,
    group: FloatArray,
    branches: FloatArray,
    branch: FloatArray,
) -> bool:
    """Whether the springs of a group all stay in contact: their branches and springs are monotone, and bound what they bear."""
    drag = body[1] * move / duration if body[1] > 0.0 and move != 0.0 else 0.0
    least = body[0] * (group[LEAST] + group[SINCE] + min(move, 0.0)) + drag
    for j in range(moduli.size):
        lowest = branches[LEFT, j] * branches[LOWEST, j] + branches[GAINED, j]
        least += min(lowest, branch[0, j, DECAY] * lowest + branch[0, j, MEAN] * (moduli[j] * move))
    return bool(least >= 0.0)


@compiled
def _press(
    springs: FloatArray,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    rates: FloatArray,
    reach: FloatArray,
    to_modes: FloatArray,
    to_branches: FloatArray,
    target: float,
    machine: float,
    limit: float,
    here: float,
    before: float,
    duration: float,
    active: int,
    w1: FloatArray,
    z1: FloatArray,
    free1: FloatArray,
    w2: FloatArray,
    z2: FloatArray,
    free2: FloatArray,
    branch: FloatArray,
    mode: FloatArray,
    filled: int,
    row: FloatArray,
    group: FloatArray,
    branches: FloatArray,
    lasting: bool,
) -> tuple[float, float, int, int]:
    """
    Move springs straight to where the target of a row is met.

    Springs well within the contact move as one while all of them surely stay in it, and are given what they have only where they
    may not; or at the end, unless that is `lasting`.

    Returns the indentation there, where it starts, the springs touched, and how many levels of the tables are filled. The
    indentation is inf where the springs end at `limit`, and nan where a spring was given up. Without a force it is where
    the bodies part.
    """
    n = springs.shape[1]
    low, high = -math.inf, math.inf
    out = 0.0
    lift = machine == 0.0 and target <= 0.0
    hardest = (body[0] + moduli.sum()) * springs[OUTER, n - 1]
    sudden = body[1] > 0.0 and duration == 0.0  # a dashpot takes the load where it is
    if lift or sudden:
        release(moduli.size, w1, z1, group, branches)
    elif group[HELD] == 0.0 and (lasting or not math.isinf(machine)):
        touching = _touching(0, active, free1)
        join(springs[SHARE], moduli.size, touching - beside(touching), w1, z1, w2, z2, group, branches)
        for i in range(int(group[HELD])):
            free1[TURN, i] = 0.0
            for j in range(free1.shape[0]):
                free2[j, i] = free1[j, i]
    if body[1] > 0.0:
        hardest += body[1] / (1.0 if sudden else duration) * springs[OUTER, n - 1]
    if machine == 0.0 and not lift and group[HELD] == 0.0:
        # bodies that are apart rest on each other before a force presses
        here = max(here, _rest(springs, w1, active))
    elif sudden and 0.0 < machine < math.inf:
        here = max(here, min(_rest(springs, w1, active), target / machine))
    guess = target if math.isinf(machine) else min(here + (here - before), limit)
    parting = lift or (sudden and machine < math.inf and target < machine * here)
    if parting:  # the bodies part at once, and then rest on each other where nothing holds them
        guess = here - 1e2 * (springs[HEIGHT, n - 1] + abs(here))
        if sudden:  # by a load that no spring of the body withstands
            guess += (guess - here) * (body[0] + moduli.sum()) / body[1]
    whole, edge = math.isinf(machine), 0
    if group[HELD] > 0.0 and not whole:
        edge = _touching(int(group[HELD]), active, free1)
    while True:
        touched = _touched(springs, active, here if sudden else max(here, guess))
        held = int(group[HELD])
        near = touched if held == 0 or whole else min(touched, edge + beside(edge))
        filled = step(
            springs, body, moduli, times, rates, reach, to_modes, to_branches, here, guess, duration,
            near, w1, z1, free1, w2, z2, free2, branch, mode, filled, row, math.isinf(machine), held,
        )  # fmt: skip
        if math.isinf(row[PARTS]):
            return math.nan, here, touched, filled
        alone = row[COUNT]  # without two beside those that move as one, no edge is known
        if held > 0:
            force, rate, stored, work, lost = bear(
                body, moduli, duration, guess - here, group, branches, branch[0]
            )
            row[FORCE] += force
            row[RATE] += rate
            row[STORED] += stored
            row[WORK] += work
            row[LOST] += lost
            row[COUNT] += held
            row[PARTS] += held
        if held == 0 and math.isinf(machine):
            return guess, here, touched, filled
        if lift:
            return _rest(springs, w2, touched), here, touched, filled
        if sudden and parting:
            row[FORCE] = 0.0
            return target / machine, here, touched, filled
        there = here if sudden else guess
        over = 0.0 if math.isinf(machine) else row[FORCE] + machine * there - target
        close = math.isinf(machine) or abs(over) <= _CLOSE * (abs(target) + machine * abs(there))
        close |= sudden and row[COUNT] == 0.0  # nothing bears the load yet
        if not close:
            if over > 0.0:
                high = min(high, guess)
            else:
                low = max(low, guess)
            enclosed = low > -math.inf and high < math.inf
            close = enclosed and high - low <= 4e-16 * max(abs(high), abs(low), abs(here))
        if held > 0 and (close or low >= limit):
            stays = lasting and (
                near < touched
                or (alone >= 2.0 and _stays(body, moduli, duration, guess - here, group, branches, branch))
            )
            if stays and near == touched:
                if not close:
                    return math.inf, here, touched, filled
                carry(moduli, guess - here, group, branches, branch[0])
                break
            if not stays:
                release(moduli.size, w1, z1, group, branches)
            whole, low, high, out = True, -math.inf, math.inf, 0.0  # with all springs, from here
            continue
        if close:
            break
        if low >= limit and not sudden:
            return math.inf, here, touched, filled
        slope = row[RATE] + (0.0 if sudden else machine)
        newton = guess - over / slope if slope > 0.0 else math.nan
        if low < newton < high:
            guess = newton if newton < limit or sudden else limit
        elif not enclosed:
            out = max(2.0 * out, abs(over) / hardest, 1e-15 * abs(guess), 1e-300)
            guess = (low + out if sudden else min(low + out, limit)) if math.isinf(high) else high - out
        else:
            guess = 0.5 * (low + high)
    if sudden:
        row[FORCE] = max(target - machine * here, 0.0)
        return here, here, touched, filled
    return guess, here, touched, filled


@compiled
def run(
    springs: FloatArray,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    rates: FloatArray,
    reach: FloatArray,
    to_modes: FloatArray,
    to_branches: FloatArray,
    time: FloatArray,
    target: FloatArray,
    machine: float,
    limit: float,
    begin: FloatArray,
    w: FloatArray,
    z: FloatArray,
    free: FloatArray,
    rows: FloatArray,
    depths: FloatArray,
    loads: FloatArray,
    gaps: FloatArray,
    turns: FloatArray,
) -> int:
    """
    Follow rows from begin = (time, indentation); returns how many were followed: fewer where the springs end at `limit`.

    Where a spring was given up it returns -1 less the row.

    `machine` in N/m: infinite prescribes the indentation d, 0 the force F, between them F + machine d = target. `loads`, `gaps` and
    `turns`, of one row more, take what `_note` says before every row and after the last, unless they are empty.
    """
    now, here, before = begin[0], begin[1], begin[1]
    group, branches = np.zeros(GROUP), np.zeros((BRANCHES, moduli.size))
    watched = loads.shape[0] > 0
    if watched:
        _note(
            springs, body[0], moduli.size, here, w, z, free, group, branches, loads[0], gaps[0], turns[0]
        )  # fmt: skip
    active = _active(w, z, free)
    w1, z1, free1 = w.copy(), z.copy(), free.copy()
    w2, z2, free2 = w.copy(), z.copy(), free.copy()
    branch = np.zeros((LEVELS + 1, max(moduli.size, 1), 6))
    mode = np.zeros((LEVELS + 1, max(rates.size, 1), 2))
    filled, known = 0, math.nan
    work, lost = 0.0, 0.0
    followed = 0
    for r in range(time.size):
        duration = time[r] - now
        if duration != known:
            filled, known = 0, duration
        row = rows[r]
        there, here, active_then, filled = _press(
            springs, body, moduli, times, rates, reach, to_modes, to_branches, target[r], machine, limit,
            here, before, duration, active, w1, z1, free1, w2, z2, free2, branch, mode, filled, row,
            group, branches, True,
        )  # fmt: skip
        if math.isnan(there):
            return -1 - r
        if math.isinf(there):
            break
        active = active_then
        w1, w2 = w2, w1
        z1, z2 = z2, z1
        free1, free2 = free2, free1
        _keep(w1, z1, free1, w2, z2, free2, active)
        if group[HELD] > 0.0:
            held, touching = int(group[HELD]), int(row[COUNT])
            if strays(held, touching):
                release(moduli.size, w1, z1, group, branches)
        work += row[WORK]
        lost += row[LOST]
        row[WORK] = work
        row[LOST] = lost
        before, here, now = here, there, time[r]
        depths[r] = here
        followed = r + 1
        if watched:
            _note(
                springs, body[0], moduli.size, here, w1, z1, free1, group, branches,
                loads[r + 1], gaps[r + 1], turns[r + 1],
            )  # fmt: skip
    release(moduli.size, w1, z1, group, branches)
    _keep(w, z, free, w1, z1, free1, 0)
    begin[0], begin[1] = now, here
    return followed


@compiled
def divide(
    springs: FloatArray,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    rates: FloatArray,
    reach: FloatArray,
    to_modes: FloatArray,
    to_branches: FloatArray,
    time: FloatArray,
    target: FloatArray,
    machine: float,
    limit: float,
    begin: FloatArray,
    w: FloatArray,
    z: FloatArray,
    free: FloatArray,
    tolerance: float,
    straight: float,
    strength: FloatArray,
    loads: FloatArray,
    owner: np.ndarray,
    shares: FloatArray,
) -> int:
    """
    Divide rows from begin = (time, indentation, target) into parts on which the indentation is all but straight.

    A part is halved where the indentation that meets its target half-way is not half-way to within `tolerance` in m, or what the
    force is off there is worth more than a part of `tolerance` times the `strength` of the row in N; and, unless `loads` of the
    shape (5, n), a place to work in, is empty, where the loads of the springs half-way are off a straight line by more than
    `straight` of the strength. Returns how many parts there are, with the row and the end of each, as a share of it, in `owner` and `shares`, or why not.
    """
    now, here, before, from_target = begin[0], begin[1], begin[1], begin[2]
    active = _active(w, z, free)
    w1, z1, free1 = w.copy(), z.copy(), free.copy()
    w2, z2, free2 = w.copy(), z.copy(), free.copy()
    w3, z3, free3 = w.copy(), z.copy(), free.copy()
    branch = np.zeros((LEVELS + 1, max(moduli.size, 1), 6))
    mode = np.zeros((LEVELS + 1, max(rates.size, 1), 2))
    row, group, branches = np.zeros(COLUMNS), np.zeros(GROUP), np.zeros((BRANCHES, moduli.size))
    parts = 0
    for r in range(time.size):
        whole, rise = time[r] - now, target[r] - from_target
        done, size = 0.0, 1.0
        # levels of the first part, too long and short enough: what begins suddenly is short by many
        long, short = 0, _DEEPEST
        while done < 1.0:
            if parts == owner.size:
                return FULL
            duration = whole * size
            goal = target[r] if done + size == 1.0 else from_target + rise * (done + size)
            there, start, touched, _ = _press(
                springs, body, moduli, times, rates, reach, to_modes, to_branches, goal, machine, limit,
                here, before, duration, active, w1, z1, free1, w2, z2, free2, branch, mode, 0, row,
                group, branches, False,
            )  # fmt: skip
            if math.isinf(there):
                return ENDED
            given_up = math.isnan(there)
            halve = False
            if size > 2.0**-_DEEPEST and duration > _TIMED * abs(time[r]):
                slope = row[RATE]
                middle = from_target + rise * (done + 0.5 * size)
                lift = machine == 0.0 and goal <= 0.0
                half = start if lift else 0.5 * (start + there)
                over = math.inf
                if not given_up:
                    step(
                        springs, body, moduli, times, rates, reach, to_modes, to_branches, start, half,
                        0.5 * duration, touched, w1, z1, free1, w3, z3, free3, branch, mode, 0, row, math.isinf(machine), 0,
                    )  # fmt: skip
                    over = 0.0
                    if lift:  # what is parted in one part bears nothing half-way
                        over, slope = middle, row[RATE]
                    elif not math.isinf(machine):
                        over = abs(row[FORCE] + machine * half - middle)
                        slope = max(row[RATE], slope) + machine
                halve = (
                    over > tolerance * slope or over * abs(there - start) > _WORTH * tolerance * strength[r]
                )
                if not halve and loads.shape[0] > 0 and size > _SUDDEN:
                    _note(
                        springs, body[0], moduli.size, start, w1, z1, free1, group, branches, loads[0], loads[3], loads[4],
                    )  # fmt: skip
                    _note(
                        springs, body[0], moduli.size, half, w3, z3, free3, group, branches, loads[1], loads[3], loads[4],
                    )  # fmt: skip
                    _note(
                        springs, body[0], moduli.size, there, w2, z2, free2, group, branches, loads[2], loads[3], loads[4],
                    )  # fmt: skip
                    bent = 0.0
                    for i in range(touched):
                        bent += springs[SHARE, i] * abs(loads[1, i] - 0.5 * (loads[0, i] + loads[2, i]))
                    halve = bent > straight * strength[r]
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
            if given_up:
                return GIVEN_UP
            active = touched
            w1, w2 = w2, w1
            z1, z2 = z2, z1
            free1, free2 = free2, free1
            _keep(w1, z1, free1, w2, z2, free2, active)
            before, here = start, there
            done += size
            owner[parts], shares[parts] = r, done
            parts += 1
            while size < 1.0 and (done / size) % 2.0 == 0.0:
                size *= 2.0
        now, from_target = time[r], target[r]
    return parts
