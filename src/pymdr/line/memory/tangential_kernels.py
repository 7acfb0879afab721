"""Compiled steps of the tangential partners of springs with memory. Imported only when a history is followed: it loads numba.

Between rows the load of a spring goes straight, and so does the shift. A stuck spring moves with the shift, exactly; where its
force would leave +-mu q it sticks up to there and then moves straight to where it bears +-mu q at the end. What it is left behind
is slip. A free one creeps back in its modes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from pymdr import compiling
from pymdr.compiling import inner
from pymdr.line.memory.kernels import (
    CROSS,
    DECAY,
    FADING,
    FIRM,
    HEIGHT,
    MEAN,
    MODULUS,
    MOVED,
    OUTER,
    OWN,
    POSITION,
    RAMP,
    REACH,
    RELAXING,
    SHARE,
    SOFT,
    Body,
    H,
    M,
    Move,
    Room,
    creep_back,
    fetch,
    fill,
    let_go,
    move_branches,
    prepare,
    relieve,
    stiffness,
    store,
    take_up,
)
from pymdr.line.memory.modes import BORNE, FREE, REST, W
from pymdr.line.memory.row_kernels import copy_spring
from pymdr.line.memory.together import (
    ALL,
    HELD,
    STIFFNESS,
    bear,
    carry,
    highest,
    join,
    release,
    strays,
)
from pymdr.numerics.exponentials import DECAYING, GROWING, RATES, first_crossing, moments
from pymdr.units import FloatArray

# groups of springs are compiled into the histories
_STAMP = compiling.stamp_of(__file__)


def compiled(function: compiling.Function) -> compiling.Function:
    """Compile with numba when first called; kept on disk."""
    return compiling.compiled(function, _STAMP)


FORCE, RATE, STORED, LOST, SLIP, WORK, SLID, SIZE, STICK, DISK = range(10)
"""Columns of a row; RATE is dF/du, SIZE the sum of all forces, STICK the stick radius, infinite where all stick."""
COLUMNS = 10
TIME, MOVE, DRAG, STIFF, NORMAL, AREA = range(6)
"""Columns of what is given for a row: its duration, the change of d, what a dashpot adds to a load, the stiffness of a spring
without one, F_N, and k of the contact per unit modulus."""
GIVEN = 6
_OWN_LOST, _OWN_SLIP, _OWN_WORK, _OWN_RATE, _OWN_LEFT, _OWN_STORED, _OWN_FORCE = range(7)
"""Of every spring in a row: what its dashpots and friction take, the work, dq/du, how far it is left behind, its energy and q."""
OWN_COLUMNS = 7
_AT_LIMIT = 1e-9
_AT_ONCE = 1e-10
"""Part of a row in which no spring sticks before it slips, but for rounding."""
_CLOSE = 1e-13
_TRIES = 500


class Pressed(NamedTuple):
    """Rows of normal contact: what is given for each, and of every spring its load, its gap and when it changed sides."""

    given: FloatArray
    load: FloatArray
    gap: FloatArray
    turn: FloatArray


class Shear(NamedTuple):
    """What a history is followed with; `margin` is by how much springs stick."""

    springs: FloatArray
    friction: float
    body: Body
    room: Room
    group: FloatArray
    margin: FloatArray
    own: FloatArray


@inner
def _drive(
    body: Body, start: float, end: float, duration: float, v: float, work: FloatArray
) -> tuple[float, float, float]:
    """
    Let a force go straight on the spring at work, with a dashpot in parallel; returns where it is, the work and what is dissipated.

    The amplitudes of the modes less those at rest under the force relax as a branch does that is moved by the force.
    """
    branches, modes = body.branches, body.modes
    rise, below, flowing = end - start, (start * start + start * end + end * end) / 3.0, body.viscosity
    for j in range(branches.shape[0]):
        flowing += branches[j, MODULUS] * branches[j, RELAXING]
    flow = 0.0 if body.equilibrium > 0.0 else duration * below / flowing
    given, lost, there = flow, flow, 0.0
    let_go(body, v, work)
    for k in range(modes.shape[0]):
        reach, m = modes[k, REACH], work[k, M]
        there -= reach * m
        decay, mean, ramp, own, cross, moved = moments(duration * modes[k, FADING])
        pushed, rest = -reach * rise, m - reach * start
        after = decay * rest + mean * pushed
        lost += own * rest * rest + pushed * (2.0 * cross * rest + moved * pushed)
        given += reach * (end * after - start * rest - rise * (mean * rest + ramp * pushed))
        given += 0.5 * reach * reach * (end * end - start * start)
        work[k, M] = after + reach * end
        there += reach * work[k, M]
    take_up(body, work)
    if body.equilibrium == 0.0:
        there += 0.5 * duration * (start + end) / flowing
    return v + there, given, lost


@inner
def _touching_part(run: Shear, pressed: Pressed, r: int, i: int) -> tuple[float, float, float, float]:
    """The part of a row over which a spring touches, and its loads at the ends of that part."""
    given, touches = pressed.given[r], pressed.gap[r + 1, i] < 0.0
    before, after = 0.0, max(pressed.load[r + 1, i] + given[DRAG], 0.0) if touches else 0.0
    begin, end = 0.0, 1.0
    if pressed.gap[r, i] < 0.0:
        before = max(pressed.load[r, i] + given[DRAG], 0.0)
        if not touches:
            end = pressed.turn[r + 1, i]
    elif touches:
        begin = pressed.turn[r + 1, i]
        if run.body.viscosity > 0.0:
            before = max(
                pressed.load[r + 1, i] + given[DRAG] - given[STIFF] * given[MOVE] * (1.0 - begin), 0.0
            )
    else:
        begin = 1.0
    return begin, end, before, after


@inner
def _sticks(
    run: Shear, way: float, lasts: float, loads: tuple[float, float], v: float, trial: float
) -> float:
    """For which part of its way a spring sticks that bears too much in the end."""
    body, work, sign = run.body, run.room.work, 1.0 if trial > 0.0 else -1.0
    drag = body.viscosity * way / lasts if body.viscosity > 0.0 and way != 0.0 else 0.0
    for j in range(body.branches.shape[0]):
        work[j, DECAYING], work[j, GROWING] = -sign * work[j, H], -sign * body.branches[j, MODULUS] * way
        work[j, RATES] = lasts / body.branches[j, RELAXING]
    line = (
        run.friction * loads[0] - sign * (body.equilibrium * v + drag),
        run.friction * (loads[1] - loads[0]) - sign * body.equilibrium * way,
    )
    return min(first_crossing(line, work, body.branches.shape[0], 0.0)[0], 1.0)


@inner
def _slide(
    run: Shear,
    way: float,
    lasts: float,
    loads: tuple[float, float],
    v: float,
    stuck: float,
    trials: tuple[float, float, int],
) -> float:
    """
    Move a spring straight that slips after it stuck for a part of its way, from one load to another; returns where it is.

    `trials` are what it bears in the end, and by how much that is over the limit, and which spring it is.
    """
    body, part, at_work, own = run.body, run.room.part, run.room.work, run.own
    trial, over, i = trials
    sign = 1.0 if trial > 0.0 else -1.0
    if stuck > 0.0:
        fill(lasts * stuck, body.branches, part)
        drag = body.viscosity * way / lasts if body.viscosity > 0.0 and way != 0.0 else 0.0
        force, lost = move_branches(body, way * stuck, v, part, at_work)
        v += way * stuck
        own[_OWN_WORK, i] += way * stuck * (force + drag)
        own[_OWN_LOST, i] += lost + way * stuck * drag
    left, lasted = 1.0 - stuck, lasts * (1.0 - stuck)
    if body.viscosity > 0.0 and lasted > 0.0:
        begun = sign * run.friction * (loads[0] + (loads[1] - loads[0]) * stuck)
        limit = sign * run.friction * loads[1]
        there, work, lost = _drive(body, begun, limit, lasted, v, at_work)
        own[_OWN_LEFT, i] = way * left - (there - v)
        own[_OWN_WORK, i] += way * left * 0.5 * (begun + limit)
        own[_OWN_SLIP, i] += way * left * 0.5 * (begun + limit) - work
        own[_OWN_LOST, i] += lost
        return float(there)
    fill(lasted, body.branches, part)
    slip = 0.0  # in no time a dashpot moves nowhere
    if body.viscosity == 0.0:
        slip = sign * over / stiffness(body, lasted, part)
    dv = way * left - slip
    force, lost = move_branches(body, dv, v, part, at_work)
    own[_OWN_LEFT, i] = slip
    own[_OWN_WORK, i] += (dv + slip) * force
    own[_OWN_SLIP, i] += slip * force
    own[_OWN_LOST, i] += lost
    return v + dv


@inner
def _change(
    run: Shear, pressed: Pressed, r: int, du: float, i: int, old: FloatArray, new: FloatArray
) -> float:
    """Move a spring that slips, or changes sides, in a row; returns what it bears, or nan where it is free."""
    body, branches, part, work = run.body, run.body.branches, run.room.part, run.room.work
    own, friction, n = run.own, run.friction, run.body.branches.shape[0]
    free, v, rest = fetch(old, i, work), old[i, W], old[i, REST]
    for c in range(OWN_COLUMNS):
        own[c, i] = 0.0
    duration = pressed.given[r, TIME]
    begin, end, before, after = _touching_part(run, pressed, r, i)
    drag, trial, over = 0.0, 0.0, -math.inf
    if free and begin > 0.0:
        v, own[_OWN_LOST, i] = creep_back(body, duration * begin, rest, work)
    if begin < 1.0:
        if free:
            take_up(body, work)
            free = False
        span = end - begin
        way, lasts = du * span, duration * span
        fill(lasts, branches, part)
        tangent = stiffness(body, lasts, part)
        drag = body.viscosity * way / lasts if body.viscosity > 0.0 and way != 0.0 else 0.0
        now, trial = body.equilibrium * v + drag, body.equilibrium * (v + way) + drag
        for j in range(n):
            now += work[j, H]
            trial += part[j, DECAY] * work[j, H] + part[j, MEAN] * branches[j, MODULUS] * way
        if friction < math.inf:
            over = abs(trial) - friction * after
        if over <= 0.0:
            force, lost = move_branches(body, way, v, part, work)
            v += way
            own[_OWN_RATE, i] = tangent * span
            own[_OWN_WORK, i] += way * (force + drag)
            own[_OWN_LOST, i] += lost + way * drag
        else:
            under = (now if trial > 0.0 else -now) - friction * before
            stuck = _sticks(run, way, lasts, (before, after), v, trial) if under < 0.0 else 0.0
            v = _slide(
                run, way, lasts, (before, after), v, stuck if stuck > _AT_ONCE else 0.0, (trial, over, i)
            )
        if pressed.gap[r + 1, i] >= 0.0:
            if body.viscosity == 0.0:  # what it still bears is let go at once
                moved, lost = relieve(body, v, work)
                v -= moved
                own[_OWN_SLIP, i] += lost
            rest, free = let_go(body, v, work), True
            v, lost = creep_back(body, duration * (1.0 - end), rest, work)
            own[_OWN_LOST, i] += lost
    store(new, i, free, v, rest, work)
    energy, q = body.equilibrium * v * v, body.equilibrium * v + drag
    if free:
        energy = 0.0
        for k in range(body.modes.shape[0]):
            energy += work[k, M] * work[k, M]
        own[_OWN_STORED, i] = 0.5 * energy
        return math.nan
    for j in range(n):
        q += work[j, H]
        energy += work[j, H] * work[j, H] * branches[j, SOFT]
    own[_OWN_STORED, i] = 0.5 * energy
    return math.copysign(friction * after, trial) if over > 0.0 else q


@inner
def _plain(
    run: Shear, pressed: Pressed, r: int, du: float, top: int, old: FloatArray, new: FloatArray
) -> None:
    """Move springs without a dashpot beside that stay in contact, and stick or slip all the way; `own` has nan for the force of others."""
    body, branch, own, friction, firm = run.body, run.room.branch, run.own, run.friction, run.room.known[FIRM]
    branches, equilibrium, n = body.branches, body.equilibrium, body.branches.shape[0]
    load, gap = pressed.load, pressed.gap  # looked up once: in a loop that counts references
    for i in range(int(run.group[ALL, HELD]), top):
        own[_OWN_FORCE, i] = math.nan
        if body.viscosity > 0.0 or old[i, FREE] != 0.0 or gap[r, i] >= 0.0 or gap[r + 1, i] >= 0.0:
            continue
        v, limit = old[i, W], friction * max(load[r + 1, i], 0.0)
        now, q, dv, slip = equilibrium * v, equilibrium * (v + du), du, 0.0
        for j in range(n):
            now += old[i, BORNE + j]
            q += branch[j, DECAY] * old[i, BORNE + j] + branch[j, MEAN] * (branches[j, MODULUS] * du)
        sticks = abs(q) <= limit or friction == math.inf
        if not sticks:
            sign, over = math.copysign(1.0, q), abs(q) - limit
            under = sign * now - friction * max(load[r, i], 0.0)
            if under < -_AT_ONCE * (over - under):
                continue
            slip, q = sign * over / firm, sign * limit
            dv = du - slip
        mean, lets, energy = equilibrium * (v + 0.5 * dv), 0.0, equilibrium * (v + dv) * (v + dv)
        for j in range(n):
            bears, elastic = old[i, BORNE + j], branches[j, MODULUS] * dv
            mean += branch[j, MEAN] * bears + branch[j, RAMP] * elastic
            lets += branches[j, SOFT] * (
                branch[j, OWN] * bears * bears
                + elastic * (2.0 * branch[j, CROSS] * bears + branch[j, MOVED] * elastic)
            )
            bears = branch[j, DECAY] * bears + branch[j, MEAN] * elastic
            new[i, BORNE + j] = bears
            energy += bears * bears * branches[j, SOFT]
        new[i, W], new[i, FREE], new[i, REST] = v + dv, 0.0, old[i, REST]
        own[_OWN_FORCE, i], own[_OWN_LOST, i], own[_OWN_SLIP, i], own[_OWN_WORK, i] = (
            q,
            lets,
            slip * mean,
            du * mean,
        )
        own[_OWN_RATE, i], own[_OWN_LEFT, i], own[_OWN_STORED, i] = (
            firm if sticks else 0.0,
            slip,
            0.5 * energy,
        )


@inner
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
    """Shift the body by du while the loads of the springs go from one row to the next; those of a group stick."""
    springs, body, group, own, friction, margin = (
        run.springs,
        run.body,
        run.group,
        run.own,
        run.friction,
        run.margin,
    )
    (given, load, gap, _), held = pressed, int(group[ALL, HELD])
    force, rate, stored, worked, lost, size, normal = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if held > 0:
        move = Move(0.0, du, given[r, TIME], 0.0)
        force, rate, stored, worked, lost = bear(body, move, group, run.room.branch)
        size = group[ALL, STIFFNESS] * highest(body, du, group, run.room.branch)
        for i in range(held):
            normal += springs[SHARE, i] * load[r + 1, i]
    last, slipped, innermost = top - 1, 0.0, 0.0
    while last >= 0 and gap[r + 1, last] >= 0.0:
        last -= 1
    _plain(run, pressed, r, du, top, old, new)
    for i in range(held, top):
        share, q = springs[SHARE, i], own[_OWN_FORCE, i]
        margin[i] = math.inf
        if math.isnan(q):
            q = _change(run, pressed, r, du, i, old, new)
        if not math.isnan(q):
            carried, after = share, max(load[r + 1, i] + given[r, DRAG], 0.0)
            if i == last:
                carried = max(given[r, AREA] - (springs[OUTER, i - 1] if i > 0 else 0.0), 0.0)
            force += carried * q
            rate += carried * own[_OWN_RATE, i]
            size += carried * abs(q)
            normal += carried * after
            if friction < math.inf:
                limit = friction * after
                margin[i] = limit - abs(q) if abs(q) < (1.0 - _AT_LIMIT) * limit else 0.0
        if i == 0:
            innermost = abs(own[_OWN_LEFT, i])
        stored += share * own[_OWN_STORED, i]
        lost += share * own[_OWN_LOST, i]
        slipped += share * own[_OWN_SLIP, i]
        worked += share * own[_OWN_WORK, i]
    scale = 1.0  # all slips at mu F_N, without a sum over springs
    if friction < math.inf:
        scale = given[r, NORMAL] / normal if normal > 0.0 else 0.0
    row[FORCE], row[RATE], row[SIZE] = force * scale, rate * scale, size * scale
    row[STORED], row[LOST], row[SLIP], row[WORK] = stored, lost, slipped, worked
    _stick(springs, margin, gap[r + 1], last, row)
    row[SLID] = innermost if row[STICK] == 0.0 else 0.0


@inner
def _sticking(
    count: int, top: int, gap0: FloatArray, gap1: FloatArray, state: FloatArray, margin: FloatArray
) -> int:
    """How many springs, where some surely do, stick from the innermost on and stay in contact over a row."""
    while (
        count < top
        and gap0[count] < 0.0
        and gap1[count] < 0.0
        and state[count, FREE] == 0.0
        and margin[count] > 0.0
    ):
        count += 1
    return count


@inner
def _stick(springs: FloatArray, margin: FloatArray, gap: FloatArray, last: int, row: FloatArray) -> None:
    """The stick radius, where margins that fall straight with d0 would vanish; and whether what sticks is a disk."""
    stuck = 0
    while stuck <= last and (gap[stuck] >= 0.0 or margin[stuck] > 0.0):
        stuck += 1
    row[DISK] = 1.0
    for i in range(stuck, last + 1):
        if gap[i] < 0.0 and margin[i] > 0.0:
            row[DISK] = 0.0
    if last < 0 or stuck == 0:
        row[STICK] = 0.0
    elif stuck > last:
        row[STICK] = math.inf
    else:
        x, y = springs[POSITION], springs[HEIGHT]
        row[STICK] = x[stuck]
        if stuck > 1 and margin[stuck - 2] > margin[stuck - 1] and y[stuck] > y[stuck - 1]:
            fall = (margin[stuck - 2] - margin[stuck - 1]) / (y[stuck - 1] - y[stuck - 2])
            ahead = margin[stuck - 1] / fall / (y[stuck] - y[stuck - 1])
            row[STICK] = x[stuck - 1] + min(ahead, 1.0) * (x[stuck] - x[stuck - 1])


@inner
def _gather(run: Shear, pressed: Pressed, r: int, top: int, old: FloatArray, new: FloatArray) -> float:
    """Have the group of springs that may stick over a row; returns the least load of one."""
    group, margin, held = run.group, run.margin, int(run.group[ALL, HELD])
    if held == 0 and run.body.viscosity == 0.0:
        count = _sticking(held, top, pressed.gap[r], pressed.gap[r + 1], old, margin)
        join(run.springs, count, old, new, group)
    least = math.inf
    for i in range(int(group[ALL, HELD])):
        margin[i] = math.inf
        least = min(least, pressed.load[r + 1, i] if pressed.gap[r + 1, i] < 0.0 else 0.0)
    if not least > 0.0:
        release(old, group)
    return least


@inner
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
    Shift the body to where a row is met; nan where that is not found; and how many springs stick beside those of a group.

    `goal` is the tangential force, the first guess of the shift, or the shift, and whether the force is asked for.
    """
    asked, du, forced = goal
    group, branch, given, sticking = run.group, run.room.branch, pressed.given[r], 0
    least = _gather(run, pressed, r, top, old, new)
    low, high, out, tries = -math.inf, math.inf, 0.0, 0
    while True:
        _step(run, pressed, r, du, top, old, new, row)
        over = row[FORCE] - asked
        tries += 1
        close = not forced or abs(over) <= _CLOSE * max(abs(asked), row[SIZE])
        if not close:
            low, high = (low, min(high, du)) if over > 0.0 else (max(low, du), high)
        enclosed = low > -math.inf and high < math.inf
        close |= enclosed and high - low <= 4e-16 * max(abs(high), abs(low))
        held = int(group[ALL, HELD])
        if held > 0 and (close or tries > _TRIES):
            most = highest(run.body, du, group, branch)
            sticking = _sticking(held, top, pressed.gap[r + 1], pressed.gap[r + 1], new, run.margin)
            if (
                tries > _TRIES or most > run.friction * least or sticking < held + 2
            ):  # all springs, one by one
                release(old, group)
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
            hardest = stiffness(run.body, given[TIME], branch) * given[AREA]
            out = max(2.0 * out, abs(over) / hardest, 1e-15 * abs(du), 1e-300)
            du = low + out if math.isinf(high) else high - out
        else:
            du = 0.5 * (low + high)


@compiled
def shear(
    run: Shear,
    pressed: Pressed,
    target: FloatArray,
    control: tuple[bool, float],
    begin: tuple[float, int],
    states: tuple[FloatArray, FloatArray, FloatArray],
    rows: FloatArray,
) -> int:
    """
    Follow rows of shifts or of tangential forces; returns how many were followed: fewer where friction does not carry one.

    `control` says whether forces are prescribed, and by what part of mu F_N they may be more; `begin` is the shift and the active
    springs; `states` are three times the same, the first of which takes that after the last row. The last column takes the shift.
    """
    (forced, slack), (here, top), (state, old, new) = control, begin, states
    before, followed = 0.0, 0
    for r in range(target.size):
        given, goal = pressed.given[r], target[r]
        prepare(run.body, given[TIME], run.room)
        run.room.known[FIRM] = stiffness(run.body, given[TIME], run.room.branch)
        for i in range(run.springs.shape[1] - 1, top - 1, -1):
            if pressed.gap[r + 1, i] < 0.0:
                top = i + 1
                break
        du = goal - here
        if forced:
            bound = run.friction * given[NORMAL] if given[NORMAL] > 0.0 else 0.0
            if abs(goal) > bound * (1.0 + 1e-12 + slack):
                break
            goal = min(max(goal, -bound), bound)
            du = before if given[NORMAL] > 0.0 else 0.0
        by_force = forced and given[NORMAL] > 0.0
        du, sticking = _shift(run, pressed, r, (goal, du, by_force), top, old, new, rows[r])
        if math.isnan(du):
            break
        old, new = new, old
        held = int(run.group[ALL, HELD])
        if held > 0:
            carry(run.body, du, run.group, run.room.branch)
            if strays(held, sticking):
                release(old, run.group)
        here, before, followed = here + du if forced else goal, du, r + 1
        rows[r, COLUMNS] = here
    release(old, run.group)
    for i in range(top):
        copy_spring(state, old, i)
    return followed
