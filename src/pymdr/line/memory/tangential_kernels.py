"""Compiled steps of the tangential partners of springs with memory. Imported only when a history is followed: it loads numba.

Between rows the load of a spring and the shift change linearly. A stuck spring moves with the shift, exactly. Where its force would
leave +-mu q it sticks up to there and then moves straight to where it bears +-mu q at the end; the rest of the shift is slip. A free
spring creeps back in its modes.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from pymdr.compiling import Addressed, call, inner, merged, uncounted
from pymdr.line.memory.groups import (
    greatest_force,
    group_forces,
    is_outgrown,
    move_group,
)
from pymdr.line.memory.kernels import (
    CROSS,
    DECAY,
    DK,
    FIRM,
    GROUPED,
    HEIGHT,
    MEAN,
    MODULUS,
    MOVED,
    OUTER,
    OWN,
    PART_DECAY,
    PART_MEAN,
    PARTICIPATION,
    POSITION,
    RAMP,
    RATE_OF_MODE,
    RELAXING,
    SOFT,
    STIFFNESS,
    Body,
    H,
    M,
    Move,
    fill,
    load_spring,
    move_branches,
    prepare,
    recover,
    stiffness,
    store_spring,
    to_branches,
    to_modes,
    unload,
)
from pymdr.line.memory.modes import BRANCHES, FREE, REST, W
from pymdr.line.memory.row_kernels import GAP, LOAD, TURNED, copy_spring
from pymdr.numerics.exponentials import CROSSED, DECAYING, GROWING, RATES, moments
from pymdr.units import FloatArray

FORCE, RATE, STORED, DISSIPATED, SLIP, WORK, SLID, SIZE, STICK, DISK, SHIFT = range(11)
"""Columns of a row; RATE is dF/du, SIZE the sum of the magnitudes, STICK the stick radius, infinite where all springs stick."""
COLUMNS = 11
TIME, MOVE, DRAG, STIFF, NORMAL, AREA = range(6)
"""Columns given for a row: its duration, the change of d, what a dashpot adds to a load, the stiffness of a spring without one, F_N,
and k of the contact per unit modulus."""
GIVEN = 6
_OWN_LOSS, _OWN_SLIP, _OWN_WORK, _OWN_RATE, _OWN_LEFT, _OWN_STORED, _OWN_FORCE, _MARGIN = range(8)
"""Of every spring in a row: dissipation of its dashpots and of friction, the work, dq/du, its slip, its energy, q, and the distance
of abs(q) from the limit of sticking."""
OWN_COLUMNS = 8
_AT_LIMIT = 1e-9
_AT_ONCE = 1e-10
"""Fraction of a row in which no spring sticks before it slips, except by rounding."""
_CLOSE = 1e-13
_TRIES = 500


class Pressed(NamedTuple):
    """Rows of normal contact: what is given for each, and the notes on its springs."""

    given: FloatArray
    notes: FloatArray


class Shear(NamedTuple):
    """The springs, their coefficient of friction, and numbers of every spring."""

    springs: FloatArray
    friction: float
    body: Body
    own: FloatArray
    change: Any
    step: Any
    """Addresses of :func:`_change` and :func:`_step`."""


def shear_of(springs: FloatArray, friction: float, body: Body) -> Shear:
    """Springs, with the address of their steps."""
    run = Shear(springs, friction, body, np.zeros((OWN_COLUMNS, springs.shape[1])), 0, 0)
    none, pressed = np.zeros((0, 0)), Pressed(np.zeros((0, 0)), np.zeros((0, 0, 0)))
    run = run._replace(change=_change.address(0.0, run, pressed, 0, 0.0, 0, none, none))
    return run._replace(step=_step.address(None, run, pressed, 0, 0.0, 0, none, none, np.zeros(0)))


@inner
def _drive(body: Body, start: float, end: float, duration: float, v: float) -> tuple[float, float, float]:
    """
    Change the force on the spring at work linearly, with a parallel dashpot; its position, the work and the dissipation.

    The amplitudes of the modes minus their equilibrium values under the force relax as a branch that is moved by the force.
    """
    table = body.table
    rise, below, flowing = end - start, (start * start + start * end + end * end) / 3.0, body.viscosity
    for j in range(body.branches):
        flowing += table[j, MODULUS] * table[j, RELAXING]
    flow = 0.0 if body.equilibrium > 0.0 else duration * below / flowing
    given, dissipated, there = flow, flow, 0.0
    to_modes(body, v)
    for k in range(body.modes):
        participation, m = table[k, PARTICIPATION], table[k, M]
        there -= participation * m
        decay, mean, ramp, own, cross, moved = moments(duration * table[k, RATE_OF_MODE])
        pushed, rest = -participation * rise, m - participation * start
        after = decay * rest + mean * pushed
        dissipated += own * rest * rest + pushed * (2.0 * cross * rest + moved * pushed)
        given += participation * (end * after - start * rest - rise * (mean * rest + ramp * pushed))
        given += 0.5 * participation * participation * (end * end - start * start)
        table[k, M] = after + participation * end
        there += participation * table[k, M]
    to_branches(body)
    if body.equilibrium == 0.0:
        there += 0.5 * duration * (start + end) / flowing
    return v + there, given, dissipated


@inner
def _contact_part(run: Shear, pressed: Pressed, r: int, i: int) -> tuple[float, float, float, float]:
    """The part of a row in which a spring is in contact, and its loads at the ends of that part."""
    given, notes = pressed.given, pressed.notes
    touches, drag = notes[GAP, r + 1, i] < 0.0, given[r, DRAG]
    load = notes[LOAD, r + 1, i] + drag
    before, after, begin, end = 0.0, max(load, 0.0) if touches else 0.0, 0.0, 1.0
    if notes[GAP, r, i] < 0.0:
        before = max(notes[LOAD, r, i] + drag, 0.0)
        if not touches:
            end = notes[TURNED, r + 1, i]
    elif touches:
        begin = notes[TURNED, r + 1, i]
        if run.body.viscosity > 0.0:
            before = max(load - given[r, STIFF] * given[r, MOVE] * (1.0 - begin), 0.0)
    else:
        begin = 1.0
    return begin, end, before, after


@inner
def _sticks(
    run: Shear, change: float, duration: float, loads: tuple[float, float], v: float, trial: float
) -> float:
    """Fraction of its move for which a spring sticks whose trial force exceeds the limit at the end."""
    body, table, sign = run.body, run.body.table, 1.0 if trial > 0.0 else -1.0
    drag = body.viscosity * change / duration if body.viscosity > 0.0 and change != 0.0 else 0.0
    for j in range(body.branches):
        table[j, DECAYING], table[j, GROWING] = -sign * table[j, H], -sign * table[j, MODULUS] * change
        table[j, RATES] = duration / table[j, RELAXING]
    line = (
        run.friction * loads[0] - sign * (body.equilibrium * v + drag),
        run.friction * (loads[1] - loads[0]) - sign * body.equilibrium * change,
    )
    part, _ = call(body.crossing, CROSSED, (line, table, body.branches, 0.0))
    return float(min(part, 1.0))


@inner
def _relaxed(body: Body, v: float) -> float:
    """The force of the spring at work at the end of the durations of `fill`, if it rests at v."""
    table, force = body.table, body.equilibrium * v
    for j in range(body.branches):
        force += table[j, PART_DECAY] * table[j, H]
    return float(force)


@inner
def _slide(
    run: Shear,
    change: float,
    duration: float,
    loads: tuple[float, float],
    v: float,
    stuck: float,
    trials: tuple[float, int],
) -> float:
    """
    Move a spring that sticks for a fraction of its move and then slips, by its force: a long shift minus a long slip loses its digits.

    `trials` are its trial force at the end, and the index of the spring; returns its position.
    """
    body, own = run.body, run.own
    trial, i = trials
    sign = 1.0 if trial > 0.0 else -1.0
    if stuck > 0.0:
        fill(duration * stuck, body)
        drag = body.viscosity * change / duration if body.viscosity > 0.0 and change != 0.0 else 0.0
        force, dissipated = move_branches(body, change * stuck, v)
        v += change * stuck
        own[_OWN_WORK, i] += change * stuck * (force + drag)
        own[_OWN_LOSS, i] += dissipated + change * stuck * drag
    left, lasted = 1.0 - stuck, duration * (1.0 - stuck)
    if body.viscosity > 0.0 and lasted > 0.0:
        first = sign * run.friction * (loads[0] + (loads[1] - loads[0]) * stuck)
        limit = sign * run.friction * loads[1]
        there, work, dissipated = _drive(body, first, limit, lasted, v)
        given = change * left * 0.5 * (first + limit)
        own[_OWN_LEFT, i] = change * left - (there - v)
        own[_OWN_WORK, i] += given
        own[_OWN_SLIP, i] += given - work
        own[_OWN_LOSS, i] += dissipated
        return float(there)
    fill(lasted, body)
    dv = change * left  # in zero time a dashpot does not move
    if body.viscosity == 0.0:
        dv = (sign * run.friction * loads[1] - _relaxed(body, v)) / stiffness(body, lasted)
    force, dissipated = move_branches(body, dv, v)
    given = change * left * sign * run.friction * 0.5 * (loads[0] + (loads[1] - loads[0]) * stuck + loads[1])
    own[_OWN_LEFT, i] = change * left - dv
    own[_OWN_WORK, i] += given
    own[_OWN_SLIP, i] += given - dv * force
    own[_OWN_LOSS, i] += dissipated
    return v + dv


@Addressed
def _change(
    run: Shear, pressed: Pressed, r: int, du: float, i: int, old: FloatArray, new: FloatArray
) -> float:
    """Move a spring that slips, or changes sides, in a row; returns its force, or nan if it is free."""
    body, table, own, friction, n = run.body, run.body.table, run.own, run.friction, run.body.branches
    free, v, rest = load_spring(old, i, body), old[i, W], old[i, REST]
    for c in range(_MARGIN):
        own[c, i] = 0.0
    duration = pressed.given[r, TIME]
    begin, end, before, after = _contact_part(run, pressed, r, i)
    drag, trial, over = 0.0, 0.0, -math.inf
    if free and begin > 0.0:
        v, own[_OWN_LOSS, i] = recover(body, duration * begin, rest)
    if begin < 1.0:
        if free:
            to_branches(body)
            free = False
        span = end - begin
        change, lasts = du * span, duration * span
        fill(lasts, body)
        tangent = stiffness(body, lasts)
        drag = body.viscosity * change / lasts if body.viscosity > 0.0 and change != 0.0 else 0.0
        now, trial = body.equilibrium * v + drag, body.equilibrium * (v + change) + drag
        for j in range(n):
            now += table[j, H]
            trial += table[j, PART_DECAY] * table[j, H] + table[j, PART_MEAN] * table[j, MODULUS] * change
        if friction < math.inf:
            over = abs(trial) - friction * after
        if over <= 0.0:
            force, dissipated = move_branches(body, change, v)
            v += change
            own[_OWN_RATE, i] = tangent * span
            own[_OWN_WORK, i] += change * (force + drag)
            own[_OWN_LOSS, i] += dissipated + change * drag
        else:
            under = (now if trial > 0.0 else -now) - friction * before
            stuck = _sticks(run, change, lasts, (before, after), v, trial) if under < 0.0 else 0.0
            stuck = stuck if stuck > _AT_ONCE else 0.0
            v = _slide(run, change, lasts, (before, after), v, stuck, (trial, i))
        if pressed.notes[GAP, r + 1, i] >= 0.0:
            if body.viscosity == 0.0:  # the remaining force is released at once
                moved, dissipated = unload(body, v)
                v -= moved
                own[_OWN_SLIP, i] += dissipated
            rest, free = to_modes(body, v), True
            v, dissipated = recover(body, duration * (1.0 - end), rest)
            own[_OWN_LOSS, i] += dissipated
    store_spring(new, i, free, v, rest, body)
    energy, q = body.equilibrium * v * v, body.equilibrium * v + drag
    if free:
        energy = 0.0
        for k in range(body.modes):
            energy += table[k, M] * table[k, M]
        own[_OWN_STORED, i] = 0.5 * energy
        return math.nan
    for j in range(n):
        q += table[j, H]
        energy += table[j, H] * table[j, H] * table[j, SOFT]
    own[_OWN_STORED, i] = 0.5 * energy
    return math.copysign(friction * after, trial) if over > 0.0 else q


@inner
def _plain(
    run: Shear, pressed: Pressed, r: int, du: float, top: int, old: FloatArray, new: FloatArray
) -> None:
    """
    Move the springs without a parallel dashpot that stay in contact and stick, or slip, throughout a row.

    The force of all others is nan in `own`.
    """
    body, table, own, friction, notes = run.body, run.body.table, run.own, run.friction, pressed.notes
    equilibrium, n, firm = body.equilibrium, body.branches, body.known[FIRM]
    for i in range(int(body.known[GROUPED]), top):
        own[_OWN_FORCE, i] = math.nan
        if body.viscosity > 0.0 or old[i, FREE] != 0.0:
            continue
        if notes[GAP, r, i] >= 0.0 or notes[GAP, r + 1, i] >= 0.0:
            continue
        v, limit = old[i, W], friction * max(notes[LOAD, r + 1, i], 0.0)
        first = friction * max(notes[LOAD, r, i], 0.0)
        now, relaxed, q, dv = equilibrium * v, equilibrium * v, equilibrium * (v + du), du
        for j in range(n):
            now += old[i, BRANCHES + j]
            remaining = table[j, DECAY] * old[i, BRANCHES + j]
            relaxed += remaining
            q += remaining + table[j, MEAN] * (table[j, MODULUS] * du)
        sticks = abs(q) <= limit or friction == math.inf
        if not sticks:
            sign, over = math.copysign(1.0, q), abs(q) - limit
            under = sign * now - first
            if under < -_AT_ONCE * (over - under):
                continue
            q = sign * limit
            dv = (q - relaxed) / firm
        mean, dissipated, energy = equilibrium * (v + 0.5 * dv), 0.0, equilibrium * (v + dv) * (v + dv)
        for j in range(n):
            h, elastic = old[i, BRANCHES + j], table[j, MODULUS] * dv
            mean += table[j, MEAN] * h + table[j, RAMP] * elastic
            crossed = elastic * (2.0 * table[j, CROSS] * h + table[j, MOVED] * elastic)
            dissipated += table[j, SOFT] * (table[j, OWN] * h * h + crossed)
            h = table[j, DECAY] * h + table[j, MEAN] * elastic
            new[i, BRANCHES + j] = h
            energy += h * h * table[j, SOFT]
        new[i, W], new[i, FREE], new[i, REST] = v + dv, 0.0, old[i, REST]
        # what slips bears its limit, which is straight; the spring gets the work of its own straight move
        given = du * mean if sticks else du * math.copysign(0.5 * (first + limit), q)
        own[_OWN_FORCE, i], own[_OWN_LOSS, i], own[_OWN_SLIP, i] = q, dissipated, given - dv * mean
        own[_OWN_WORK, i], own[_OWN_RATE, i] = given, firm if sticks else 0.0
        own[_OWN_LEFT, i], own[_OWN_STORED, i] = du - dv, 0.5 * energy


@Addressed
def _step(
    run: Shear,
    pressed: Pressed,
    r: int,
    du: float,
    top: int,
    old: FloatArray,
    new: FloatArray,
    row: FloatArray,
) -> None:
    """Shift the body by du while the loads change from one row to the next; the springs of a group stick."""
    springs, body, own, friction, known = run.springs, run.body, run.own, run.friction, run.body.known
    given, notes, grouped = pressed.given, pressed.notes, int(known[GROUPED])
    force, rate, stored, worked, dissipated, size, normal = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if grouped > 0:
        force, rate, stored, worked, dissipated = group_forces(body, Move(0.0, du, given[r, TIME], 0.0))
        size = known[STIFFNESS] * greatest_force(body, du)
        for i in range(grouped):
            normal += springs[DK, i] * notes[LOAD, r + 1, i]
    last, slipped, innermost = top - 1, 0.0, 0.0
    while last >= 0 and notes[GAP, r + 1, last] >= 0.0:
        last -= 1
    _plain(run, pressed, r, du, top, old, new)
    for i in range(grouped, top):
        dk, q = springs[DK, i], own[_OWN_FORCE, i]
        own[_MARGIN, i] = math.inf
        if math.isnan(q):
            q = call(run.change, 0.0, (run, pressed, r, du, i, old, new))
        if not math.isnan(q):
            carried, after = dk, max(notes[LOAD, r + 1, i] + given[r, DRAG], 0.0)
            if i == last:
                carried = max(given[r, AREA] - (springs[OUTER, i - 1] if i > 0 else 0.0), 0.0)
            force += carried * q
            rate += carried * own[_OWN_RATE, i]
            size += carried * abs(q)
            normal += carried * after
            if friction < math.inf:
                limit = friction * after
                own[_MARGIN, i] = limit - abs(q) if abs(q) < (1.0 - _AT_LIMIT) * limit else 0.0
        if i == 0:
            innermost = abs(own[_OWN_LEFT, i])
        stored += dk * own[_OWN_STORED, i]
        dissipated += dk * own[_OWN_LOSS, i]
        slipped += dk * own[_OWN_SLIP, i]
        worked += dk * own[_OWN_WORK, i]
    scale = 1.0  # full slip gives exactly mu F_N, without the error of a sum over springs
    if friction < math.inf:
        scale = given[r, NORMAL] / normal if normal > 0.0 else 0.0
    row[FORCE], row[RATE], row[SIZE] = force * scale, rate * scale, size * scale
    row[STORED], row[DISSIPATED], row[SLIP], row[WORK] = stored, dissipated, slipped, worked
    _stick(run, pressed, r + 1, last, row)
    row[SLID] = innermost if row[STICK] == 0.0 else 0.0


@inner
def _sticking(
    run: Shear, pressed: Pressed, r: int, start: tuple[int, int], top: int, state: FloatArray
) -> int:
    """
    Number of springs from the innermost on that stick and stay in contact over row r, of which start[0] surely do.

    Their gaps are those from row start[1] on.
    """
    count, first = start
    while (
        count < top
        and pressed.notes[GAP, first, count] < 0.0
        and pressed.notes[GAP, r + 1, count] < 0.0
        and state[count, FREE] == 0.0
        and run.own[_MARGIN, count] > 0.0
    ):
        count += 1
    return count


@inner
def _stick(run: Shear, pressed: Pressed, r: int, last: int, row: FloatArray) -> None:
    """The stick radius, where margins that fall linearly with d0 would vanish; and whether the sticking region is a disk."""
    springs, own, notes, stuck = run.springs, run.own, pressed.notes, 0
    while stuck <= last and (notes[GAP, r, stuck] >= 0.0 or own[_MARGIN, stuck] > 0.0):
        stuck += 1
    row[DISK] = 1.0
    for i in range(stuck, last + 1):
        if notes[GAP, r, i] < 0.0 and own[_MARGIN, i] > 0.0:
            row[DISK] = 0.0
    if last < 0 or stuck == 0:
        row[STICK] = 0.0
    elif stuck > last:
        row[STICK] = math.inf
    else:
        x, y, before = springs[POSITION, stuck], springs[HEIGHT, stuck], own[_MARGIN, stuck - 1]
        row[STICK] = x
        inner_x, inner_y = springs[POSITION, stuck - 1], springs[HEIGHT, stuck - 1]
        if stuck > 1 and own[_MARGIN, stuck - 2] > before and y > inner_y:
            fall = (own[_MARGIN, stuck - 2] - before) / (inner_y - springs[HEIGHT, stuck - 2])
            row[STICK] = inner_x + min(before / fall / (y - inner_y), 1.0) * (x - inner_x)


@merged
def _group_sticking(
    run: Shear, pressed: Pressed, r: int, top: int, old: FloatArray, new: FloatArray
) -> float:
    """Group the springs that may stick over a row; returns the least load of one."""
    body, known = run.body, run.body.known
    if known[GROUPED] == 0.0 and body.viscosity == 0.0:
        sticking = _sticking(run, pressed, r, (int(known[GROUPED]), r), top, old)
        call(body.form, None, (run.springs, sticking, old, new, body))
    least = math.inf
    for i in range(int(known[GROUPED])):
        run.own[_MARGIN, i] = math.inf
        least = min(least, pressed.notes[LOAD, r + 1, i] if pressed.notes[GAP, r + 1, i] < 0.0 else 0.0)
    if not least > 0.0:
        call(body.dissolve, None, (old, body))
    return least


@merged
def _shift(
    run: Shear,
    pressed: Pressed,
    r: int,
    goal: tuple[float, float, bool],
    top: int,
    old: FloatArray,
    new: FloatArray,
    row: FloatArray,
) -> tuple[float, int]:
    """
    Shift the body to where the target of a row is met, nan if it is not; and the number of springs that stick from the innermost on.

    `goal` is the tangential force, the first guess of the shift, or the shift, and whether the force is prescribed.
    """
    target, du, forced = goal
    body, known, sticking = run.body, run.body.known, 0
    least = _group_sticking(run, pressed, r, top, old, new)
    low, high, out, tries = -math.inf, math.inf, 0.0, 0
    while True:
        call(run.step, None, (run, pressed, r, du, top, old, new, row))
        over = row[FORCE] - target
        tries += 1
        close = not forced or abs(over) <= _CLOSE * max(abs(target), row[SIZE])
        if not close:
            low, high = (low, min(high, du)) if over > 0.0 else (max(low, du), high)
        enclosed = low > -math.inf and high < math.inf
        close |= enclosed and high - low <= 4e-16 * max(abs(high), abs(low))
        grouped = int(known[GROUPED])
        if grouped > 0 and (close or tries > _TRIES):
            most = greatest_force(body, du)
            sticking = _sticking(run, pressed, r, (grouped, r + 1), top, new)
            if tries > _TRIES or most > run.friction * least or sticking < grouped + 2:
                call(body.dissolve, None, (old, body))  # all springs, one by one
                low, high, out, tries = -math.inf, math.inf, 0.0, 0
                continue
        if close:
            return du, sticking
        if tries > _TRIES:
            return math.nan, 0
        newton = du - over / row[RATE] if row[RATE] > 0.0 else math.nan
        if low < newton < high:
            du = newton
        elif not enclosed:
            stiffest = known[FIRM] * pressed.given[r, AREA]
            out = max(2.0 * out, abs(over) / stiffest, 1e-15 * abs(du), 1e-300)
            du = low + out if math.isinf(high) else high - out
        else:
            du = 0.5 * (low + high)


@uncounted
def shear(
    run: Shear,
    pressed: Pressed,
    target: FloatArray,
    control: tuple[bool, float],
    start: tuple[float, int],
    states: tuple[FloatArray, FloatArray, FloatArray],
    rows: FloatArray,
) -> int:
    """
    Follow rows of shifts or of tangential forces; returns how many were followed: fewer if friction cannot carry one.

    `control` says whether forces are prescribed, and by what fraction of mu F_N they may exceed it; `start` is the shift and the
    number of active springs; `states` are three equal ones, the first of which takes that after the last row.
    """
    (forced, slack), (here, top), (state, old, new) = control, start, states
    body, known, given, before, followed = run.body, run.body.known, pressed.given, 0.0, 0
    for r in range(target.size):
        duration, normal, goal = given[r, TIME], given[r, NORMAL], target[r]
        prepare(body, duration)
        for i in range(run.springs.shape[1] - 1, top - 1, -1):
            if pressed.notes[GAP, r + 1, i] < 0.0:
                top = i + 1
                break
        du, by_force = goal - here, forced and normal > 0.0
        if forced:
            bound = run.friction * normal if normal > 0.0 else 0.0
            if abs(goal) > bound * (1.0 + 1e-12 + slack):
                break
            goal = min(max(goal, -bound), bound)
            du = before if by_force else 0.0
        du, sticking = _shift(run, pressed, r, (goal, du, by_force), top, old, new, rows[r])
        if math.isnan(du):
            break
        old, new = new, old
        grouped = int(known[GROUPED])
        if grouped > 0:
            move_group(body, du)
            if is_outgrown(grouped, sticking):
                call(body.dissolve, None, (old, body))
        here, before, followed = here + du if forced else goal, du, r + 1
        rows[r, SHIFT] = here
    call(body.dissolve, None, (old, body))
    for i in range(top):
        copy_spring(state, old, i)
    return followed
