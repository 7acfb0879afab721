"""Compiled steps of springs with memory. Imported only when a history is followed: it loads numba.

A spring in contact keeps the forces h of its Maxwell branches, whose length w follows the indentation: exact for
straight moves. A free one keeps the amplitudes of the modes in which it creeps back. Branches and modes that fall within a
step are convex and lie above their tangents at both ends, those that rise are concave and lie above their chord: their sum
bounds the force, or the gap, from below. Where it is not above 0, and the force does not rise or fall throughout either, the
step is halved, down to 2^-LEVELS of it, and the spring changes sides there. The first change is found whatever the step.
Most springs stay on their side by far: branches and modes are monotone within a step, and a bound from their ends shows it.
"""

from __future__ import annotations

import math

import numpy as np

from pymdr.compiling import compiled
from pymdr.units import FloatArray

LEVELS = 40
FULL = 1 << LEVELS
MOST = 10000
"""Parts of a step in which a spring is tried before it is given up."""
_ROUNDING = 2e-15
_NEWTON = 30
_SHORTLY = 1e-3
"""Of a step: the time that tells the modulus by which the force of a spring that is let go is continued."""
_SLACK = 1e-12
"""Of the terms: what a gap, or a force, that grows throughout may lack at its beginning, where it is 0 but for many roundings."""
DECAY, MEAN, RAMP, OWN, CROSS, MOVED = range(6)
"""Of a branch over a step x = s/tau, h -> DECAY h + E MEAN dw; work dw (MEAN h + E RAMP dw); its dissipation in units of
1/E: OWN h^2 + 2 CROSS h E dw + MOVED (E dw)^2."""
FORCE, RATE, STORED, LOST, WORK, EDGE_DEPTH, LAST, COUNT, PARTS = range(9)
"""Columns of a row; RATE is dF/dd, LAST the outermost spring in contact, COUNT how many are, PARTS what was tried
of all, infinite where a spring was given up."""
COLUMNS = 9
HEIGHT, SHARE, CENTRE, OUTER = range(4)
"""Rows of the springs: d0, dk, and k per unit modulus at the spring and at the outer end of its part."""
FREE, REST, TURN = range(3)
"""Rows of the sides of springs: 1 where one is free, then w less its modes, and at which part of a step it last changed sides."""
SIDES = 3


@compiled
def fill(
    level: int, duration: float, times: FloatArray, rates: FloatArray, branch: FloatArray, mode: FloatArray
) -> None:
    """Coefficients of a step of duration / 2^level."""
    s = duration * 2.0**-level
    for j in range(times.size):
        x = s / times[j]
        c = -math.expm1(-x)
        branch[level, j, DECAY] = 1.0 - c if x < 0.5 else math.exp(-x)
        branch[level, j, MEAN] = c / x if x > 0.0 else 1.0
        branch[level, j, OWN] = -0.5 * math.expm1(-2.0 * x)
        branch[level, j, CROSS] = 0.5 * c * c / x if x > 0.0 else 0.0
        if x > 0.3:
            branch[level, j, RAMP] = (x - c) / (x * x)
            branch[level, j, MOVED] = (x - c - 0.5 * c * c) / (x * x)
        else:  # the differences above lose their digits
            ramp, moved, term, power = 0.0, 0.0, 0.5, 2.0
            for k in range(2, 16):
                ramp += term
                moved += term * (2.0 - power)
                term *= -x / (k + 1)
                power *= 2.0
            branch[level, j, RAMP] = ramp
            branch[level, j, MOVED] = moved
    for k in range(rates.size):
        mode[level, k, 0] = math.exp(-rates[k] * s)
        mode[level, k, 1] = -0.5 * math.expm1(-2.0 * rates[k] * s)


@compiled
def rise_of(elastic: float, relaxed: float) -> float:
    """What a branch gains less what relaxes: nothing but rounding where it bears a steady drag, as one that relaxes at once does."""
    rise = elastic - relaxed
    return rise if abs(rise) > _ROUNDING * abs(elastic) else 0.0


@compiled
def _least(before: float, after: float, fall: float, fallen: float, steep: float, flat: float) -> float:
    """
    Bound from below of a sum that goes from `before` to `after`.

    Its convex share goes from `fall` to `fallen`, with the slopes `steep` and `flat` over the whole way; the rest is concave.
    """
    least = min(before, after)
    if steep < flat:
        meet = min(max((fallen - flat - fall) / (steep - flat), 0.0), 1.0)
        chord = (after - fallen) - (before - fall)
        least = min(least, before + (steep + chord) * meet)
    return least


@compiled
def _parts(
    equilibrium: float,
    drag: float,
    moduli: FloatArray,
    times: FloatArray,
    move: float,
    duration: float,
    w: float,
    bears: FloatArray,
) -> float:
    """At which part of a step a spring in contact parts whose force falls throughout; 2 where it is not that simple."""
    begins, ends, highest = equilibrium * w + drag, equilibrium * (w + move) + drag, equilibrium * move
    for j in range(moduli.size):
        x = duration / times[j]
        decay = math.exp(-x)
        slow = moduli[j] * move - x * bears[j]
        highest += max(slow, slow * decay)
        begins += bears[j]
        ends += decay * bears[j] + moduli[j] * move * (-math.expm1(-x) / x if x > 0.0 else 1.0)
    if not (begins > 0.0 > ends and highest <= 0.0):
        return 2.0
    low, high = 0.0, 1.0
    part = begins / (begins - ends)
    for _ in range(_NEWTON):
        force, slope = equilibrium * (w + part * move) + drag, equilibrium * move
        for j in range(moduli.size):
            x = duration / times[j]
            gone = -math.expm1(-x * part)
            slow = moduli[j] * move - x * bears[j]
            force += (1.0 - gone) * bears[j] + moduli[j] * move * (gone / x if x > 0.0 else part)
            slope += slow * (1.0 - gone)
        if force > 0.0:
            low = part
        else:
            high = part
        there = part - force / slope if slope < 0.0 else low
        if not low < there < high:
            there = 0.5 * (low + high)
        if abs(there - part) <= _ROUNDING:
            return there
        part = there
    return 2.0


@compiled
def _touches(
    rates: FloatArray,
    reach: FloatArray,
    move: float,
    duration: float,
    above: float,
    amplitudes: FloatArray,
) -> float:
    """At which part of a step a free spring is touched whose gap falls throughout, from `above` without modes; else 2."""
    begins, ends, highest = above, above - move, -move
    for k in range(rates.size):
        x = duration * rates[k]
        decay = math.exp(-x)
        near = reach[k] * amplitudes[k]
        highest += max(-x * near, -x * near * decay)
        begins += near
        ends += near * decay
    if not (begins > 0.0 > ends and highest <= 0.0):
        return 2.0
    low, high = 0.0, 1.0
    part = begins / (begins - ends)
    for _ in range(_NEWTON):
        gap, slope = above - part * move, -move
        for k in range(rates.size):
            x = duration * rates[k]
            near = reach[k] * amplitudes[k] * math.exp(-x * part)
            gap += near
            slope -= x * near
        if gap > 0.0:
            low = part
        else:
            high = part
        there = part - gap / slope if slope < 0.0 else low
        if not low < there < high:
            there = 0.5 * (low + high)
        if abs(there - part) <= _ROUNDING:
            return there
        part = there
    return 2.0


@compiled
def step(
    springs: FloatArray,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    rates: FloatArray,
    reach: FloatArray,
    to_modes: FloatArray,
    to_branches: FloatArray,
    start: float,
    end: float,
    duration: float,
    active: int,
    w_old: FloatArray,
    z_old: FloatArray,
    free_old: FloatArray,
    w_new: FloatArray,
    z_new: FloatArray,
    free_new: FloatArray,
    branch: FloatArray,
    mode: FloatArray,
    filled: int,
    row: FloatArray,
    cut: bool,
    first: int,
) -> int:
    """
    Move the springs from `first` on straight from one indentation to another; returns how many levels of the tables are filled.

    `body` holds equilibrium and viscosity, A dashpot moves nowhere in no
    time: the way to `end` then stands for its load, as if its viscosity were that of one second.
    """
    n, modes = moduli.size, rates.size
    equilibrium, viscosity = body[0], body[1]
    soft, glassy = 1.0 / moduli, equilibrium + moduli.sum()
    move, lasting = end - start, duration
    sudden = viscosity > 0.0 and duration == 0.0
    if sudden:
        lasting = 1.0
    drag = viscosity * move / lasting if viscosity > 0.0 and move != 0.0 else 0.0
    if sudden:
        move, end = 0.0, start
    h = np.zeros(max(n, 1))
    m = np.zeros(max(modes, 1))
    ahead = np.zeros(max(n, modes, 1))
    stored, lost, work, force, rate = 0.0, 0.0, 0.0, 0.0, 0.0
    last, count, parts = -1, 0, 0
    q_last, q_before = 0.0, 0.0
    stiff = viscosity if sudden else equilibrium + (viscosity / duration if viscosity > 0.0 else 0.0)
    if filled == 0:
        fill(0, duration, times, rates, branch, mode)
        filled = 1
    if not sudden:
        for j in range(n):
            stiff += moduli[j] * branch[0, j, MEAN]
    # of the springs that stay in contact by far: k, what their branches bear before, and its square
    stays = 0.0
    borne, squared = np.zeros(max(n, 1)), np.zeros(max(n, 1))
    once, once_modes = np.zeros((1, max(n, 1), 6)), np.zeros((1, max(modes, 1), 2))
    for i in range(first, active):
        y, share = springs[HEIGHT, i], springs[SHARE, i]
        free = free_old[FREE, i] != 0.0
        w, rest = w_old[i], free_old[REST, i]
        free_new[TURN, i] = 0.0
        if not free:
            there = end - y
            q = equilibrium * there + drag
            least = min(equilibrium * w, equilibrium * there) + drag
            for j in range(n):
                after_h = branch[0, j, DECAY] * z_old[i, j] + branch[0, j, MEAN] * (moduli[j] * move)
                z_new[i, j] = after_h
                q += after_h
                least += min(z_old[i, j], after_h)
            if least >= 0.0:
                energy = equilibrium * there * there
                for j in range(n):  # a sum keeps the compiler from short vectors, which take longer
                    loaded = share * z_old[i, j]
                    borne[j] += loaded
                    squared[j] += loaded * z_old[i, j]
                    energy += z_new[i, j] * z_new[i, j] * soft[j]
                stays += share
                stored += 0.5 * share * energy
                work += share * move * 0.5 * equilibrium * (w + there)
                w_new[i], free_new[FREE, i], free_new[REST, i] = there, 0.0, rest
                force += share * q
                rate += share * stiff
                last = i
                count += 1
                parts += 1
                q_before, q_last = q_last, q
                continue
            for j in range(n):
                h[j] = z_old[i, j]
            turn = 2.0 if sudden else _parts(equilibrium, drag, moduli, times, move, duration, w, h)
            if turn < 1.0:
                fill(0, duration * turn, times, rates[:0], once, once_modes)
                dw = move * turn
                let, spent, pushed = equilibrium * (w + dw), 0.0, 0.0
                for j in range(n):
                    elastic = moduli[j] * dw
                    pushed += once[0, j, MEAN] * h[j] + once[0, j, RAMP] * elastic
                    spent += soft[j] * (
                        once[0, j, OWN] * h[j] * h[j]
                        + elastic * (2.0 * once[0, j, CROSS] * h[j] + once[0, j, MOVED] * elastic)
                    )
                    ahead[j] = once[0, j, DECAY] * h[j] + once[0, j, MEAN] * elastic
                    let += ahead[j]
                jump = -let / glassy if viscosity == 0.0 else 0.0
                left = w + dw + jump
                for j in range(n):
                    ahead[j] += moduli[j] * jump
                fill(0, duration * (1.0 - turn), times[:0], rates, once, once_modes)
                there, opens, energy, faded = left if equilibrium == 0.0 else 0.0, -move, 0.0, 0.0
                for k in range(modes):
                    amplitude = to_modes[k, n] * left
                    for j in range(n):
                        amplitude += to_modes[k, j] * ahead[j]
                    if equilibrium == 0.0:
                        there -= reach[k] * amplitude
                    faded += once_modes[0, k, 1] * amplitude * amplitude
                    m[k] = once_modes[0, k, 0] * amplitude
                    slow = -duration * rates[k] * reach[k]
                    opens += min(slow * amplitude, slow * m[k])
                    energy += m[k] * m[k]
                if opens >= 0.0:
                    free_new[FREE, i], free_new[REST, i], free_new[TURN, i] = 1.0, there, turn
                    for k in range(modes):
                        z_new[i, k] = m[k]
                        there += reach[k] * m[k]
                    w_new[i] = there
                    stored += 0.5 * share * energy
                    lost += share * (spent + dw * drag + faded)
                    work += share * dw * (equilibrium * (w + 0.5 * dw) + pushed + drag)
                    parts += 2
                    continue
        else:
            there, least, energy, spent = rest, rest + y - max(start, end), 0.0, 0.0
            for k in range(modes):
                after_m = mode[0, k, 0] * z_old[i, k]
                z_new[i, k] = after_m
                near, far = reach[k] * z_old[i, k], reach[k] * after_m
                there += far
                least += min(near, far)
                energy += after_m * after_m
                spent += mode[0, k, 1] * z_old[i, k] * z_old[i, k]
            if least > 0.0:
                w_new[i], free_new[FREE, i], free_new[REST, i] = there, 1.0, rest
                stored += 0.5 * share * energy
                lost += share * spent
                parts += 1
                continue
            for k in range(modes):
                m[k] = z_old[i, k]
            turn = 2.0 if sudden else _touches(rates, reach, move, duration, rest + y - start, m)
            if turn < 1.0:
                fill(0, duration * turn, times[:0], rates, once, once_modes)
                faded, there = 0.0, rest
                for k in range(modes):
                    faded += once_modes[0, k, 1] * m[k] * m[k]
                    m[k] *= once_modes[0, k, 0]
                    there += reach[k] * m[k]
                left = start + move * turn - y
                fill(0, duration * (1.0 - turn), times, rates[:0], once, once_modes)
                dw = move * (1.0 - turn)
                q, rises, spent, pushed, energy = (
                    equilibrium * (end - y) + drag,
                    equilibrium * dw,
                    0.0,
                    0.0,
                    0.0,
                )
                for j in range(n):
                    bears = moduli[j] * (left - there)
                    for k in range(modes):
                        bears += to_branches[j, k] * m[k]
                    elastic = moduli[j] * dw
                    after_h = once[0, j, DECAY] * bears + once[0, j, MEAN] * elastic
                    ratio = duration * (1.0 - turn) / times[j]
                    rises += min(elastic - ratio * bears, (elastic - ratio * bears) * once[0, j, DECAY])
                    pushed += once[0, j, MEAN] * bears + once[0, j, RAMP] * elastic
                    spent += soft[j] * (
                        once[0, j, OWN] * bears * bears
                        + elastic * (2.0 * once[0, j, CROSS] * bears + once[0, j, MOVED] * elastic)
                    )
                    q += after_h
                    energy += after_h * after_h * soft[j]
                    z_new[i, j] = after_h
                if rises >= 0.0:
                    there = end - y
                    w_new[i], free_new[FREE, i], free_new[REST, i], free_new[TURN, i] = there, 0.0, rest, turn
                    stored += 0.5 * share * (energy + equilibrium * there * there)
                    lost += share * (spent + dw * drag + faded)
                    work += share * dw * (0.5 * equilibrium * (left + there) + pushed + drag)
                    force += share * q
                    rate += share * stiff
                    last = i
                    count += 1
                    parts += 2
                    q_before, q_last = q_last, q
                    continue
        if free:
            for k in range(modes):
                m[k] = z_old[i, k]
        else:
            for j in range(n):
                h[j] = z_old[i, j]
        position, level, deepest, forced, at_once = 0, 0, LEVELS, False, False
        tried = 0
        my_lost, my_work = 0.0, 0.0
        while position < FULL:
            parts += 1
            tried += 1
            if tried > MOST:
                row[PARTS] = math.inf
                return filled
            size = FULL >> level
            while filled <= level:
                fill(filled, duration, times, rates, branch, mode)
                filled += 1
            part = size / FULL
            depth = end if position + size == FULL else start + move * ((position + size) / FULL)
            dw = move * part
            if not free:
                there = depth - y
                before, after = equilibrium * w + drag, equilibrium * there + drag
                fall, fallen, steep, flat = 0.0, 0.0, 0.0, 0.0
                scale = equilibrium * abs(w)
                pushed, spent = 0.0, 0.0
                for j in range(n):
                    elastic = moduli[j] * dw
                    next_h = branch[level, j, DECAY] * h[j] + branch[level, j, MEAN] * elastic
                    ahead[j] = next_h
                    before += h[j]
                    after += next_h
                    if next_h < h[j]:
                        ratio = duration * part / times[j]
                        fall += h[j]
                        fallen += next_h
                        steep += min(rise_of(elastic, ratio * h[j]), 0.0)
                        flat += min(rise_of(elastic, ratio * next_h), 0.0)
                    scale += abs(h[j])
                    pushed += branch[level, j, MEAN] * h[j] + branch[level, j, RAMP] * elastic
                    spent += (
                        branch[level, j, OWN] * h[j] * h[j]
                        + elastic * (2.0 * branch[level, j, CROSS] * h[j] + branch[level, j, MOVED] * elastic)
                    ) * soft[j]
                low = _least(before, after, fall, fallen, steep, flat)
                at_once = False
                if low < -_ROUNDING * scale and not forced:
                    holds = level >= deepest
                    begins, ends = equilibrium * dw, equilibrium * dw
                    rise, risen, bend, bent = 0.0, 0.0, 0.0, 0.0
                    drop, dropped, curl, curled = 0.0, 0.0, 0.0, 0.0
                    for j in range(n):
                        ratio = duration * part / times[j]
                        slow = rise_of(moduli[j] * dw, ratio * h[j])
                        fast = rise_of(moduli[j] * dw, ratio * ahead[j])
                        begins += slow
                        ends += fast
                        if slow > 0.0:
                            rise, risen = rise + slow, risen + fast
                            bend, bent = bend - ratio * slow, bent - ratio * fast
                        else:
                            drop, dropped = drop - slow, dropped - fast
                            curl, curled = curl + ratio * slow, curled + ratio * fast
                    if sudden:
                        holds, at_once = True, True
                    elif _least(begins, ends, rise, risen, bend, bent) >= 0.0:
                        holds, forced = True, before >= -_SLACK * scale
                    elif _least(-begins, -ends, drop, dropped, curl, curled) >= 0.0:
                        holds, at_once = True, before <= _ROUNDING * scale
                    if (
                        holds
                        and (level >= deepest or before >= -_ROUNDING * scale)
                        and after >= -_ROUNDING * scale
                    ):
                        forced = True
                if low >= -_ROUNDING * scale or forced:
                    forced = False
                    my_work += dw * (0.5 * equilibrium * (w + there) + pushed + drag)
                    my_lost += spent + dw * drag
                    w = there
                    for j in range(n):
                        h[j] = ahead[j]
                    position += size
                    while level > 0 and position % (2 * size) == 0:
                        level -= 1
                        size *= 2
                elif level < deepest and not at_once:
                    level += 1
                else:  # it pulls from here on, or at the end of this part: it is let go there, and jumps back
                    if not at_once:
                        my_work += dw * (0.5 * equilibrium * (w + there) + pushed + drag)
                        my_lost += spent + dw * drag
                        w, position = there, position + size
                        for j in range(n):
                            h[j] = ahead[j]
                    slip = 0.0
                    if viscosity == 0.0:
                        slip = equilibrium * w
                        for j in range(n):
                            slip += h[j]
                        slip /= -glassy
                    w += slip
                    for j in range(n):
                        h[j] += moduli[j] * slip
                    for k in range(modes):
                        total = to_modes[k, n] * w
                        for j in range(n):
                            total += to_modes[k, j] * h[j]
                        m[k] = total
                    rest = 0.0
                    if equilibrium == 0.0:
                        rest = w
                        for k in range(modes):
                            rest -= reach[k] * m[k]
                    free, forced, deepest = True, True, max(deepest - 1, 1)
                    free_new[TURN, i] = position / FULL
                    level = max(level, deepest)
            else:
                scale = abs(rest) + abs(y)
                there = rest
                fall, fallen, steep, flat = 0.0, 0.0, 0.0, 0.0
                spent = 0.0
                for k in range(modes):
                    ahead[k] = mode[level, k, 0] * m[k]
                    near, far = reach[k] * m[k], reach[k] * ahead[k]
                    there += far
                    if near > 0.0:
                        ratio = -duration * part * rates[k]
                        fall, fallen = fall + near, fallen + far
                        steep, flat = steep + ratio * near, flat + ratio * far
                    scale += abs(near)
                    spent += mode[level, k, 1] * m[k] * m[k]
                before, after = w + y - (depth - dw), there + y - depth
                low = _least(before, after, fall, fallen, steep, flat)
                at_once = False
                if low < -_ROUNDING * scale and not forced:
                    holds = level >= deepest
                    begins, ends = -dw, -dw
                    rise, risen, bend, bent = 0.0, 0.0, 0.0, 0.0
                    drop, dropped, curl, curled = 0.0, 0.0, 0.0, 0.0
                    for k in range(modes):
                        ratio = -duration * part * rates[k]
                        slow, fast = ratio * reach[k] * m[k], ratio * reach[k] * ahead[k]
                        begins += slow
                        ends += fast
                        if slow > 0.0:
                            rise, risen = rise + slow, risen + fast
                            bend, bent = bend + ratio * slow, bent + ratio * fast
                        else:
                            drop, dropped = drop - slow, dropped - fast
                            curl, curled = curl - ratio * slow, curled - ratio * fast
                    if _least(begins, ends, rise, risen, bend, bent) >= 0.0:
                        holds, forced = True, before >= -_SLACK * scale
                    elif _least(-begins, -ends, drop, dropped, curl, curled) >= 0.0:
                        holds, at_once = True, before <= _ROUNDING * scale
                    if (
                        holds
                        and (level >= deepest or before >= -_ROUNDING * scale)
                        and after >= -_ROUNDING * scale
                    ):
                        forced = True
                if low >= -_ROUNDING * scale or forced:
                    forced = False
                    my_lost += spent
                    w = there
                    for k in range(modes):
                        m[k] = ahead[k]
                    position += size
                    while level > 0 and position % (2 * size) == 0:
                        level -= 1
                        size *= 2
                elif level < deepest and not at_once:
                    level += 1
                elif (
                    not at_once and ends > 0.0 and after >= -_SLACK * scale
                ):  # it only seems to touch, as its gap widens
                    forced = True
                else:
                    if at_once:
                        there, depth = w, depth - dw
                    else:
                        my_lost += spent
                        position += size
                        for k in range(modes):
                            m[k] = ahead[k]
                    w = depth - y
                    for j in range(n):
                        total = 0.0
                        for k in range(modes):
                            total += to_branches[j, k] * m[k]
                        h[j] = total + moduli[j] * (w - there)
                    free, forced, deepest = False, True, max(deepest - 1, 1)
                    free_new[TURN, i] = position / FULL
                    level = max(level, deepest)
        w_new[i] = w
        free_new[FREE, i] = 1.0 if free else 0.0
        free_new[REST, i] = rest
        energy = 0.0
        if free:
            for k in range(modes):
                z_new[i, k] = m[k]
                energy += m[k] * m[k]
            stored += 0.5 * share * energy
        else:
            q = equilibrium * w + drag
            energy = equilibrium * w * w
            for j in range(n):
                z_new[i, j] = h[j]
                q += h[j]
                energy += h[j] * h[j] * soft[j]
            stored += 0.5 * share * energy
            force += share * q
            rate += share * stiff
            last = i
            count += 1
            q_before, q_last = q_last, q
        lost += share * my_lost
        work += share * my_work
    work += move * drag * stays
    lost += move * drag * stays
    for j in range(n):
        elastic = moduli[j] * move
        work += move * (branch[0, j, MEAN] * borne[j] + branch[0, j, RAMP] * elastic * stays)
        lost += soft[j] * (
            branch[0, j, OWN] * squared[j]
            + elastic * (2.0 * branch[0, j, CROSS] * borne[j] + branch[0, j, MOVED] * elastic * stays)
        )
    row[STORED] = stored
    row[LOST] = lost
    row[WORK] = work
    row[LAST] = last
    row[COUNT] = count
    row[PARTS] = parts
    row[RATE] = rate
    row[EDGE_DEPTH] = end
    if 0 <= last < springs.shape[1] - 1:
        short = equilibrium  # what a spring feels that is let go shortly before the end
        for j in range(n):
            x = _SHORTLY * duration / times[j]
            short += moduli[j] * (-math.expm1(-x) / x if x > 0.0 else 1.0)
        edge = _edge(springs, w_new, active, last, end, q_before, q_last, short, drag)
        row[EDGE_DEPTH] = edge
        if cut or drag != 0.0:  # without, the force is continuous in the indentation
            force += _cut(springs, last, edge, q_before, q_last, drag)
    row[FORCE] = force
    return filled


@compiled
def _edge(
    springs: FloatArray,
    w: FloatArray,
    active: int,
    last: int,
    depth: float,
    q_before: float,
    q_last: float,
    stiff: float,
    drag: float,
) -> float:
    """
    The d0 of the edge, between the last spring in contact and the first free one.

    Three estimates of second order, each of which a bend of w or q spoils elsewhere: the gap of the free springs
    continued inward, the force continued outward, and the trial force from the one to the other. Their median is good
    wherever the bend lies. A dashpot leaves the first: its force jumps at the edge.
    """
    inner, y = springs[HEIGHT, last], springs[HEIGHT, last + 1]
    w_here = w[last + 1] if last + 1 < active else 0.0
    if w_here == 0.0:
        return float(min(max(depth, inner), y))
    slope, gap = 0.0, w_here + y - depth
    if last + 2 < springs.shape[1] and springs[HEIGHT, last + 2] > y:
        w_next = w[last + 2] if last + 2 < active else 0.0
        slope = (w_next - w_here) / (springs[HEIGHT, last + 2] - y)
    outward = min(max(y - gap / (1.0 + slope), inner), y) if slope > -1.0 else inner
    if drag != 0.0 or last == 0:
        return float(outward)
    inward = y
    if q_before > q_last:
        inward = min(inner + q_last * (inner - springs[HEIGHT, last - 1]) / (q_before - q_last), y)
    trial = q_last + stiff * gap
    across = inner + (y - inner) * q_last / trial if trial > 0.0 else inner
    return float(max(min(outward, inward), min(max(outward, inward), across)))


@compiled
def _cut(springs: FloatArray, last: int, edge: float, q_before: float, q_last: float, drag: float) -> float:
    """What the sum of the forces lacks of int q dk up to the edge, by trapezia beyond the last but one part."""
    inner, y = springs[HEIGHT, last], springs[HEIGHT, last + 1]
    centre, k_next = springs[CENTRE, last], springs[CENTRE, last + 1]
    k_edge = (
        centre + (k_next - centre) * ((edge - inner) / (y - inner)) if y > inner else springs[OUTER, last]
    )
    border, q_border, slope = 0.0, q_last, 0.0
    if last > 0:
        border = springs[OUTER, last - 1]
        slope = (q_last - q_before) / (centre - springs[CENTRE, last - 1])
        q_border = q_last - slope * (centre - border)
    q_edge = max(q_last + slope * (k_edge - centre), 0.0) if drag != 0.0 else 0.0
    return float(
        0.5 * (q_border + q_last) * (centre - border)
        + 0.5 * (q_last + q_edge) * (k_edge - centre)
        - q_last * springs[SHARE, last]
    )
