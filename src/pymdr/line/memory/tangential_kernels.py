"""Compiled steps of the tangential partners of springs with memory. Imported only when a history is followed: it loads numba.

Between rows the load of a spring goes straight, and so does the shift. A stuck spring moves with the shift, exactly; where its
force would leave +-mu q it sticks up to there and then moves straight to where it bears +-mu q at the end. What it is left behind
is slip. A free one creeps back in its modes.
"""

from __future__ import annotations

import math

import numpy as np

from pymdr import compiling
from pymdr.line.memory.kernels import CROSS, DECAY, MEAN, MOVED, OWN, RAMP, fill
from pymdr.line.memory.together import (
    BRANCHES,
    GAINED,
    GROUP,
    HELD,
    HIGHEST,
    LEAST,
    LEFT,
    LOWEST,
    MOST,
    SINCE,
    STIFFNESS,
    bear,
    beside,
    carry,
    join,
    release,
    strays,
)
from pymdr.units import FloatArray

# groups of springs are compiled into the histories
_STAMP = compiling.stamp_of(__file__)


def compiled(function: compiling.Function) -> compiling.Function:
    """Compile with numba when first called; kept on disk."""
    return compiling.compiled(function, _STAMP)


FORCE, RATE, STORED, LOST, SLIP, WORK, SLID, SIZE, STICK, DISK = range(10)
"""Columns of a row; RATE is dF/du, SIZE the sum of all forces, STICK the stick radius, infinite where all stick."""
COLUMNS = 10
POSITION, HEIGHT, SHARE, OUTER = range(4)
"""Rows of the springs: x, d0, dk, and k per unit modulus at the outer end of a spring's part."""
TIME, MOVE, DRAG, STIFF, NORMAL, AREA = range(6)
"""Columns of what is given for a row: its duration, the change of d, what a dashpot adds to a load, the stiffness of a spring
without one, F_N, and k of the contact per unit modulus."""
GIVEN = 6
_AT_LIMIT = 1e-9
_AT_ONCE = 1e-10
"""Part of a row in which no spring sticks before it slips, but for rounding."""
_CLOSE = 1e-13
_TRIES = 500


@compiled
def _move(
    dv: float,
    v: float,
    body: FloatArray,
    moduli: FloatArray,
    duration: float,
    parts: FloatArray,
    h: FloatArray,
    told: FloatArray,
) -> None:
    """Move a spring straight by dv; `told` takes its mean force and what its dashpots dissipate."""
    drag = body[1] * dv / duration if body[1] > 0.0 and dv != 0.0 else 0.0
    mean, lost = body[0] * (v + 0.5 * dv) + drag, drag * dv
    for j in range(moduli.size):
        elastic = moduli[j] * dv
        mean += parts[j, MEAN] * h[j] + parts[j, RAMP] * elastic
        lost += (
            parts[j, OWN] * h[j] * h[j] + elastic * (2.0 * parts[j, CROSS] * h[j] + parts[j, MOVED] * elastic)
        ) / moduli[j]
        h[j] = parts[j, DECAY] * h[j] + parts[j, MEAN] * elastic
    told[0], told[1] = mean, lost


@compiled
def _stiffness(body: FloatArray, moduli: FloatArray, duration: float, parts: FloatArray) -> float:
    """How the force at the end of a straight move grows with it."""
    stiff = body[0] + (body[1] / duration if body[1] > 0.0 else 0.0)
    for j in range(moduli.size):
        stiff += moduli[j] * parts[j, MEAN]
    return float(stiff)


@compiled
def _creep(modes: FloatArray, reach: FloatArray, rest: float, m: FloatArray, told: FloatArray) -> None:
    """Let a free spring creep; `told` takes where it is and what its dashpots dissipate."""
    v, lost = rest, 0.0
    for k in range(reach.size):
        lost += modes[k, 1] * m[k] * m[k]
        m[k] *= modes[k, 0]
        v += reach[k] * m[k]
    told[0], told[1] = v, lost


@compiled
def _drive(
    start: float,
    end: float,
    duration: float,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    rates: FloatArray,
    reach: FloatArray,
    to_modes: FloatArray,
    to_branches: FloatArray,
    v: float,
    h: FloatArray,
    drive: FloatArray,
    spare: FloatArray,
    told: FloatArray,
) -> None:
    """
    Let a force go straight on a spring with a dashpot beside; `told` takes where it is, the work and what dashpots dissipate.

    The amplitudes of the modes less those at rest under the force relax as a branch does that is moved by the force.
    """
    n, count = moduli.size, rates.size
    rise, below = end - start, (start * start + start * end + end * end) / 3.0
    flow = 0.0 if body[0] > 0.0 else duration * below / (body[1] + (moduli * times).sum())
    work, lost, there = flow, flow, 0.0
    fill(0, duration, 1.0 / rates, rates[:0], drive, spare)
    for j in range(n):
        told[j] = 0.0
    for k in range(count):
        m = to_modes[k, n] * v
        for j in range(n):
            m += to_modes[k, j] * h[j]
        there -= reach[k] * m
        pushed, rest = -reach[k] * rise, m - reach[k] * start
        after = drive[0, k, DECAY] * rest + drive[0, k, MEAN] * pushed
        lost += drive[0, k, OWN] * rest * rest + pushed * (
            2.0 * drive[0, k, CROSS] * rest + drive[0, k, MOVED] * pushed
        )
        mean = drive[0, k, MEAN] * rest + drive[0, k, RAMP] * pushed
        work += reach[k] * (end * after - start * rest - rise * mean)
        work += 0.5 * reach[k] * reach[k] * (end * end - start * start)
        m = after + reach[k] * end
        there += reach[k] * m
        for j in range(n):
            told[j] += to_branches[j, k] * m
    for j in range(n):
        h[j] = told[j]
    if body[0] == 0.0:
        there += 0.5 * duration * (start + end) / (body[1] + (moduli * times).sum())
    told[0], told[1], told[2] = v + there, work, lost


@compiled
def _step(
    springs: FloatArray,
    friction: float,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    rates: FloatArray,
    reach: FloatArray,
    to_modes: FloatArray,
    to_branches: FloatArray,
    given: FloatArray,
    du: float,
    load0: FloatArray,
    gap0: FloatArray,
    load1: FloatArray,
    gap1: FloatArray,
    turn: FloatArray,
    top: int,
    v_old: FloatArray,
    z_old: FloatArray,
    free_old: FloatArray,
    v_new: FloatArray,
    z_new: FloatArray,
    free_new: FloatArray,
    whole: FloatArray,
    whole_modes: FloatArray,
    part: FloatArray,
    part_modes: FloatArray,
    driven: FloatArray,
    margin: FloatArray,
    row: FloatArray,
    group: FloatArray,
    branches: FloatArray,
    pressed: float,
) -> None:
    """
    Shift the body by du while the loads of the springs go from one row to the next.

    Those of a group stick; of their loads k q the sum is `pressed`.
    """
    n, count = moduli.size, rates.size
    duration, drag, stiff = given[TIME], given[DRAG], given[STIFF]
    glassy, soft = body[0] + moduli.sum(), 1.0 / moduli
    h, m, told = np.zeros(max(n, 1)), np.zeros(max(count, 1)), np.zeros(max(n, 3))
    stored, lost, slipped, worked = 0.0, 0.0, 0.0, 0.0
    force, rate, size, normal, innermost = 0.0, 0.0, 0.0, 0.0, 0.0
    held = int(group[HELD])
    if held > 0:
        force, rate, stored, worked, lost = bear(body, moduli, duration, du, group, branches, whole[0])
        size, normal = group[STIFFNESS] * _highest(body, moduli, du, group, branches, whole[0]), pressed
    last = top - 1
    while last >= 0 and gap1[last] >= 0.0:
        last -= 1
    # springs that stay in contact and stick, or slip all the way, are moved at once
    plain, firm = body[1] == 0.0, _stiffness(body, moduli, duration, whole[0])
    coefficients = np.zeros((6, max(n, 1)))
    for j in range(n):
        coefficients[:, j] = whole[0, j]
        coefficients[MEAN, j] *= moduli[j]
        coefficients[RAMP, j] *= moduli[j]
        coefficients[OWN, j] /= moduli[j]
        coefficients[MOVED, j] *= moduli[j]
    for i in range(held, top):
        touched, touches = gap0[i] < 0.0, gap1[i] < 0.0
        if plain and touched and touches and free_old[0, i] == 0.0:
            v, limit = v_old[i], friction * max(load1[i], 0.0)
            now, trial, dv, slip, lets = body[0] * v, body[0] * (v + du), du, 0.0, 0.0
            for j in range(n):
                now += z_old[i, j]
                trial += coefficients[DECAY, j] * z_old[i, j] + coefficients[MEAN, j] * du
            q, sign, sticks = trial, math.copysign(1.0, trial), abs(trial) <= limit or friction == math.inf
            at_once = sticks
            if not sticks:
                under, over = sign * now - friction * max(load0[i], 0.0), sign * trial - limit
                at_once = under >= -_AT_ONCE * (over - under)
                slip = sign * over / firm
                dv, q = du - slip, sign * limit
            if at_once:
                mean, lets, energy = body[0] * (v + 0.5 * dv), 0.0, body[0] * (v + dv) * (v + dv)
                for j in range(n):
                    bears = z_old[i, j]
                    mean += whole[0, j, MEAN] * bears + coefficients[RAMP, j] * dv
                    lets += coefficients[OWN, j] * bears * bears + dv * (
                        2.0 * coefficients[CROSS, j] * bears + coefficients[MOVED, j] * dv
                    )
                    after_h = coefficients[DECAY, j] * bears + coefficients[MEAN, j] * dv
                    z_new[i, j] = after_h
                    energy += after_h * after_h * soft[j]
                share = springs[SHARE, i]
                v_new[i], free_new[0, i], free_new[1, i] = v + dv, 0.0, free_old[1, i]
                stored += 0.5 * share * energy
                lost += share * lets
                slipped += share * slip * mean
                worked += share * du * mean
                if i == 0:
                    innermost = abs(slip)
                carried = share
                if i == last:
                    carried = max(given[AREA] - (springs[OUTER, i - 1] if i > 0 else 0.0), 0.0)
                force += carried * q
                size += carried * abs(q)
                if sticks:
                    rate += carried * firm
                if friction < math.inf:
                    normal += carried * max(load1[i], 0.0)
                    margin[i] = limit - abs(q) if abs(q) < (1.0 - _AT_LIMIT) * limit else 0.0
                else:
                    margin[i] = math.inf
                continue
        free, v, rest = free_old[0, i] != 0.0, v_old[i], free_old[1, i]
        if free:
            for k in range(count):
                m[k] = z_old[i, k]
        else:
            for j in range(n):
                h[j] = z_old[i, j]
        before, after = 0.0, max(load1[i] + drag, 0.0)
        begin, end = 0.0, 1.0
        if touched:
            before = max(load0[i] + drag, 0.0)
        elif touches:
            begin = turn[i]
            if body[1] > 0.0:
                before = max(load1[i] + drag - stiff * given[MOVE] * (1.0 - begin), 0.0)
        else:
            begin = 1.0
        if not touches:
            after = 0.0
            if touched:
                end = turn[i]
        my_lost, my_slip, my_work, my_rate, beside = 0.0, 0.0, 0.0, 0.0, 0.0
        if free and begin > 0.0:
            if begin < 1.0:
                fill(0, duration * begin, times[:0], rates, part, part_modes)
                _creep(part_modes[0], reach, rest, m, told)
            else:
                _creep(whole_modes[0], reach, rest, m, told)
            v = told[0]
            my_lost += told[1]
        if begin < 1.0:
            if free:
                for j in range(n):
                    h[j] = 0.0
                    for k in range(count):
                        h[j] += to_branches[j, k] * m[k]
                free = False
            span = end - begin
            move, lasts = du * span, duration * span
            if span < 1.0:
                fill(0, lasts, times, rates[:0], part, part_modes)
            parts = whole[0] if span == 1.0 else part[0]
            tangent = _stiffness(body, moduli, lasts, parts)
            beside = body[1] * move / lasts if body[1] > 0.0 and move != 0.0 else 0.0
            now, trial = body[0] * v + beside, body[0] * (v + move) + beside
            for j in range(n):
                now += h[j]
                trial += parts[j, DECAY] * h[j] + parts[j, MEAN] * moduli[j] * move
            over = abs(trial) - friction * after if friction < math.inf else -math.inf
            if over <= 0.0:
                _move(move, v, body, moduli, lasts, parts, h, told)
                v += move
                my_rate = tangent * span
                my_work += move * told[0]
                my_lost += told[1]
            else:
                sign = 1.0 if trial > 0.0 else -1.0
                under = sign * now - friction * before
                stuck = under / (under - over) if under < 0.0 else 0.0
                if stuck <= _AT_ONCE:
                    stuck = 0.0
                else:
                    fill(0, lasts * stuck, times, rates[:0], part, part_modes)
                    _move(move * stuck, v, body, moduli, lasts * stuck, part[0], h, told)
                    v += move * stuck
                    my_work += move * stuck * told[0]
                    my_lost += told[1]
                    fill(0, lasts * (1.0 - stuck), times, rates[:0], part, part_modes)
                    parts = part[0]
                    tangent = _stiffness(body, moduli, lasts * (1.0 - stuck), parts)
                left = 1.0 - stuck
                slip, lasted = sign * over / tangent, lasts * left
                if body[1] > 0.0 and lasted > 0.0:
                    begun = sign * friction * (before + (after - before) * stuck)
                    limit = sign * friction * after
                    from_ = v
                    _drive(
                        begun, limit, lasted, body, moduli, times, rates, reach, to_modes, to_branches, v, h, driven,
                        part_modes, told,
                    )  # fmt: skip
                    v = told[0]
                    slip = move * left - (v - from_)
                    my_work += move * left * 0.5 * (begun + limit)
                    my_slip += move * left * 0.5 * (begun + limit) - told[1]
                    my_lost += told[2]
                else:
                    dv = move * left - slip
                    _move(dv, v, body, moduli, lasted, parts, h, told)
                    v += dv
                    my_work += (dv + slip) * told[0]
                    my_slip += slip * told[0]
                    my_lost += told[1]
                if i == 0:
                    innermost = abs(slip)
            if not touches:
                if body[1] == 0.0:  # what it still bears is let go at once
                    q = body[0] * v
                    for j in range(n):
                        q += h[j]
                    my_slip += 0.5 * q * q / glassy
                    v -= q / glassy
                    for j in range(n):
                        h[j] -= moduli[j] * q / glassy
                for k in range(count):
                    m[k] = to_modes[k, n] * v
                    for j in range(n):
                        m[k] += to_modes[k, j] * h[j]
                rest = 0.0
                if body[0] == 0.0:
                    rest = v
                    for k in range(count):
                        rest -= reach[k] * m[k]
                free = True
                fill(0, duration * (1.0 - end), times[:0], rates, part, part_modes)
                _creep(part_modes[0], reach, rest, m, told)
                v = told[0]
                my_lost += told[1]
        v_new[i] = v
        free_new[0, i], free_new[1, i] = 1.0 if free else 0.0, rest
        share, energy = springs[SHARE, i], 0.0
        margin[i] = math.inf
        if free:
            for k in range(count):
                z_new[i, k] = m[k]
                energy += m[k] * m[k]
        else:
            q = body[0] * v + beside
            energy = body[0] * v * v
            for j in range(n):
                z_new[i, j] = h[j]
                q += h[j]
                energy += h[j] * h[j] / moduli[j]
            if over > 0.0:
                q = math.copysign(friction * after, trial)
            carried = share
            if i == last:
                carried = max(given[AREA] - (springs[OUTER, i - 1] if i > 0 else 0.0), 0.0)
            force += carried * q
            rate += carried * my_rate
            size += carried * abs(q)
            normal += carried * after
            if friction < math.inf:
                limit = friction * after
                margin[i] = limit - abs(q) if abs(q) < (1.0 - _AT_LIMIT) * limit else 0.0
        stored += 0.5 * share * energy
        lost += share * my_lost
        slipped += share * my_slip
        worked += share * my_work
    scale = 1.0  # all slips at mu F_N, without a sum over springs
    if friction < math.inf:
        scale = given[NORMAL] / normal if normal > 0.0 else 0.0
    row[FORCE], row[RATE], row[SIZE] = force * scale, rate * scale, size * scale
    row[STORED], row[LOST], row[SLIP], row[WORK] = stored, lost, slipped, worked
    _stick(springs, margin, gap1, last, row)
    row[SLID] = innermost if row[STICK] == 0.0 else 0.0


@compiled
def _highest(
    body: FloatArray,
    moduli: FloatArray,
    du: float,
    group: FloatArray,
    branches: FloatArray,
    branch: FloatArray,
) -> float:
    """What no spring of a group exceeds that sticks, whichever way it is sheared."""
    ahead = group[SINCE] + du
    low, high = body[0] * (group[LEAST] + ahead), body[0] * (group[MOST] + ahead)
    for j in range(moduli.size):
        left, gained = branch[j, DECAY] * branches[LEFT, j], branch[j, DECAY] * branches[GAINED, j]
        gained += branch[j, MEAN] * (moduli[j] * du)
        low += left * branches[LOWEST, j] + gained
        high += left * branches[HIGHEST, j] + gained
    return float(max(abs(low), abs(high)))


@compiled
def _sticking(
    count: int, top: int, gap0: FloatArray, gap1: FloatArray, free: FloatArray, margin: FloatArray
) -> int:
    """How many springs, where some surely do, stick from the innermost on and stay in contact over a row."""
    while (
        count < top
        and gap0[count] < 0.0
        and gap1[count] < 0.0
        and free[0, count] == 0.0
        and margin[count] > 0.0
    ):
        count += 1
    return count


@compiled
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


@compiled
def run(
    springs: FloatArray,
    friction: float,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    rates: FloatArray,
    reach: FloatArray,
    to_modes: FloatArray,
    to_branches: FloatArray,
    given: FloatArray,
    target: FloatArray,
    forced: bool,
    slack: float,
    begin: float,
    loads: FloatArray,
    gaps: FloatArray,
    turns: FloatArray,
    v: FloatArray,
    z: FloatArray,
    free: FloatArray,
    rows: FloatArray,
    shifts: FloatArray,
) -> int:
    """Follow rows of shifts or of tangential forces; returns how many were followed: fewer where friction does not carry one."""
    n = springs.shape[1]
    top = n
    while top > 0 and free[0, top - 1] != 0.0 and v[top - 1] == 0.0 and not np.any(z[top - 1] != 0.0):
        top -= 1
    v1, z1, free1 = v.copy(), z.copy(), free.copy()
    v2, z2, free2 = v.copy(), z.copy(), free.copy()
    whole, part = np.zeros((1, max(moduli.size, 1), 6)), np.zeros((1, max(moduli.size, 1), 6))
    whole_modes, part_modes = np.zeros((1, max(rates.size, 1), 2)), np.zeros((1, max(rates.size, 1), 2))
    driven = np.zeros((1, max(rates.size, 1), 6))
    margin = np.zeros(n)
    group, branches = np.zeros(GROUP), np.zeros((BRANCHES, moduli.size))
    here, before, known = begin, 0.0, math.nan
    followed, held, sticking = 0, 0, 0
    for r in range(target.size):
        row, duration, pressed = rows[r], given[r, TIME], given[r, NORMAL]
        if duration != known:
            fill(0, duration, times, rates, whole, whole_modes)
            known = duration
        for i in range(n - 1, top - 1, -1):
            if gaps[r + 1, i] < 0.0:
                top = i + 1
                break
        if group[HELD] == 0.0 and body[1] == 0.0:
            sticking = _sticking(0, top, gaps[r], gaps[r + 1], free1, margin)
            join(springs[SHARE], moduli.size, sticking - beside(sticking), v1, z1, v2, z2, group, branches)
            for i in range(int(group[HELD])):
                free2[0, i], free2[1, i] = free1[0, i], free1[1, i]
                margin[i] = math.inf
        borne, least = 0.0, math.inf
        for i in range(int(group[HELD])):
            borne += springs[SHARE, i] * loads[r + 1, i]
            least = min(least, loads[r + 1, i] if gaps[r + 1, i] < 0.0 else 0.0)
        if not least > 0.0:
            release(moduli.size, v1, z1, group, branches)
        asked = target[r]
        du = asked - here
        if forced:
            bound = friction * pressed if pressed > 0.0 else 0.0
            if abs(asked) > bound * (1.0 + 1e-12 + slack):
                break
            asked = min(max(asked, -bound), bound)
            du = before if pressed > 0.0 else 0.0
        low, high, out = -math.inf, math.inf, 0.0
        tries = 0
        while True:
            _step(
                springs, friction, body, moduli, times, rates, reach, to_modes, to_branches, given[r], du,
                loads[r], gaps[r], loads[r + 1], gaps[r + 1], turns[r + 1], top, v1, z1, free1, v2, z2, free2,
                whole, whole_modes, part, part_modes, driven, margin, row, group, branches, borne,
            )  # fmt: skip
            over = row[FORCE] - asked
            tries += 1
            close = not forced or pressed <= 0.0 or abs(over) <= _CLOSE * max(abs(asked), row[SIZE])
            if not close:
                if over > 0.0:
                    high = min(high, du)
                else:
                    low = max(low, du)
            enclosed = low > -math.inf and high < math.inf
            close |= enclosed and high - low <= 4e-16 * max(abs(high), abs(low))
            held = int(group[HELD])
            if held > 0 and (close or tries > _TRIES):
                highest = _highest(body, moduli, du, group, branches, whole[0])
                sticking = _sticking(held, top, gaps[r + 1], gaps[r + 1], free2, margin)
                if (
                    tries > _TRIES or highest > friction * least or sticking < held + 2
                ):  # all springs, one by one
                    release(moduli.size, v1, z1, group, branches)
                    low, high, out, tries = -math.inf, math.inf, 0.0, 0
                    continue
            if close:
                break
            if tries > _TRIES:
                return followed
            newton = du - over / row[RATE] if row[RATE] > 0.0 else math.nan
            if low < newton < high:
                du = newton
            elif not enclosed:
                hardest = _stiffness(body, moduli, duration, whole[0]) * given[r, AREA]
                out = max(2.0 * out, abs(over) / hardest, 1e-15 * abs(du), 1e-300)
                du = low + out if math.isinf(high) else high - out
            else:
                du = 0.5 * (low + high)
        v1, v2 = v2, v1
        z1, z2 = z2, z1
        free1, free2 = free2, free1
        if held > 0:
            carry(moduli, du, group, branches, whole[0])
            if strays(held, sticking):
                release(moduli.size, v1, z1, group, branches)
        here = here + du if forced else asked
        before = du
        shifts[r] = here
        followed = r + 1
    release(moduli.size, v1, z1, group, branches)
    v[:], z[:], free[:] = v1, z1, free1
    return followed
