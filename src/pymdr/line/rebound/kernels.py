"""Compiled steps of a mass on springs with memory. Loads numba.

On a step the acceleration is a polynomial through the nodes of Radau, at which the equation of motion holds. Speed and
depth are its integrals, and the forces of the branches are exact for the polynomial through the rates k(d) d' of the
growing contact. As the bodies part, the force depends on the motion by one number, Q = int E(t - s) dd(s): with
P(t1) = int_0^t1 E(t - s) dd(s) = Q, the force int_0^t1 E(t - s) dF0 rises with Q by k(d(t1)). Whatever the rates of the
branches, the unknowns of a step are the accelerations at its nodes.
"""

from __future__ import annotations

import math

import numpy as np

from pymdr import compiling
from pymdr.line.friction import reading
from pymdr.line.friction.reading import curve
from pymdr.units import FloatArray

# the curves that are read are compiled into the callers
_STAMP = compiling.stamp_of(__file__, reading.__file__)


def compiled(function: compiling.Function) -> compiling.Function:
    """Compile with numba when first called; kept on disk. Products and sums may be fused, nothing else."""
    return compiling.compiled(function, _STAMP, fastmath={"contract"})


NODES = 5
COMPLETE, RESTS, TOO_DEEP, TOO_MANY, STUCK = range(5)
"""How a motion ends."""
BEGIN, LENGTH, DEPTH, SPEED = 0, 1, 2, 3
"""Columns of a step: its begin and length in s, the depth there, the terms of the speed, and of k(d) d'."""
RATE = SPEED + NODES + 1
COLUMNS = RATE + NODES
READ = 5
"""Columns of what is read of a motion."""
_TURNS, _SEARCHES = 16, 80
_ENOUGH = 1e-15
_ROUNDING = 4e-15
_SERIES = 2.0
_STILL = 1e-18
"""Of the speed at the touch: a mass on a liquid that is slower comes to rest in it."""


def _radau() -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Nodes in (0, 1], the terms of their Lagrange polynomials, and their first and second integrals up to the nodes."""
    from numpy.polynomial import legendre

    high = np.zeros(NODES + 1)
    high[NODES - 1 :] = -1.0, 1.0
    nodes = np.sort(0.5 + 0.5 * legendre.legroots(high))
    nodes[-1] = 1.0
    terms: FloatArray = np.linalg.inv(np.vander(nodes, increasing=True)).T.astype(float)
    p = np.arange(NODES)
    once = nodes[:, None] ** (p + 1) / (p + 1)
    twice = nodes[:, None] ** (p + 2) / ((p + 1) * (p + 2))
    return nodes, terms, once @ terms.T, twice @ terms.T


AT, TERMS, ONCE, TWICE = _radau()


@compiled
def moments(x: float, out: FloatArray) -> None:
    """Integrals of exp(-x (1 - u)) u^p over u in [0, 1], for p = 0 ... NODES."""
    if x >= _SERIES:
        out[0] = -math.expm1(-x) / x
        for p in range(1, NODES + 1):
            out[p] = (1.0 - p * out[p - 1]) / x
        return
    term, total = 1.0, 1.0 / (NODES + 1.0)
    k = 0
    while term > 1e-17 and k < 60:
        k += 1
        term *= x / k
        total += term / (k + NODES + 1.0)
    out[NODES] = math.exp(-x) * total
    for p in range(NODES, 0, -1):
        out[p - 1] = (1.0 - x * out[p]) / p


@compiled
def held(
    line: FloatArray,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    step: FloatArray,
    pulls: FloatArray,
    forces: FloatArray,
    x: float,
    wait: float,
    grows: bool,
) -> tuple[float, float, float, float, float, float]:
    """
    What the motion up to x in s after the begin of a step still does a time later.

    d, d', a there; P = int E dd and int E dF0 up to there, and E dd/dt, all after the wait.
    """
    share = x / step[LENGTH] if step[LENGTH] > 0.0 else 0.0
    v, d, power = 0.0, 0.0, 1.0
    rising = np.empty(NODES + 1)
    rates = np.empty(NODES)
    for p in range(NODES + 1):
        rising[p] = step[SPEED + p] * power
        if p < NODES:
            rates[p] = step[RATE + p] * power
        v += rising[p]
        d += rising[p] / (p + 1.0)
        power *= share
    d = step[DEPTH] + x * d
    a, f = curve(line, d)[:2]
    pull, force, modulus = body[0] * d, body[0] * f, body[0]
    part = np.empty(NODES + 1)
    for i in range(moduli.size):
        z = x / times[i]
        left = math.exp(-wait / times[i])
        decay = math.exp(-z)
        moments(z, part)
        own = 0.0
        for p in range(NODES + 1):
            own += rising[p] * part[p]
        pull += left * moduli[i] * (decay * pulls[i] + x * own)
        modulus += moduli[i] * left
        if grows:
            own = 0.0
            for p in range(NODES):
                own += rates[p] * part[p]
            force += left * (decay * forces[i] + moduli[i] * x * own)
    return d, v, a, pull, force, modulus * v


@compiled
def touched_at(
    line: FloatArray,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    steps: FloatArray,
    pulls: FloatArray,
    forces: FloatArray,
    turn: int,
    now: float,
    wanted: float,
    near: FloatArray,
) -> tuple[float, float, float]:
    """Force, contact radius and t1 of bodies that part, from Q; `near` holds the step and the time in it of the last t1."""
    if wanted <= 0.0:
        return 0.0, 0.0, 0.0
    k = min(max(int(near[0]), 0), turn - 1)
    x = min(max(near[1], 0.0), steps[k, LENGTH])
    # the step whose P at its begin is below what is wanted, and at its end above
    while k > 0:
        here = held(
            line, body, moduli, times, steps[k], pulls[k], forces[k], 0.0, now - steps[k, BEGIN], True
        )
        if here[3] <= wanted:
            break
        k -= 1
        x = steps[k, LENGTH]
    while k < turn - 1:
        n = k + 1
        here = held(
            line, body, moduli, times, steps[n], pulls[n], forces[n], 0.0, now - steps[n, BEGIN], True
        )
        if here[3] > wanted:
            break
        k = n
        x = 0.0
    low, high = 0.0, steps[k, LENGTH]
    begin = steps[k, BEGIN]
    _, _, a, pull, force, rate = held(
        line, body, moduli, times, steps[k], pulls[k], forces[k], x, max(now - begin - x, 0.0), True
    )
    for _ in range(_SEARCHES):
        over = pull - wanted
        if abs(over) <= 4e-16 * (abs(wanted) + abs(pull)):
            break
        if over > 0.0:
            high = x
        else:
            low = x
        new = x - over / rate if rate > 0.0 else 0.5 * (low + high)
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - x) <= 1e-15 * (begin + x) or high - low <= 4e-16 * (begin + high):
            break
        x = new
        _, _, a, pull, force, rate = held(
            line, body, moduli, times, steps[k], pulls[k], forces[k], x, max(now - begin - x, 0.0), True
        )
    near[0], near[1] = float(k), x
    # the force is smooth in Q where t1 is not: what the search left is made good by its slope
    return max(force + 2.0 * a * (wanted - pull), 0.0), a, begin + x


@compiled
def solved(matrix: FloatArray, right: FloatArray) -> bool:
    """Solve a small system in place, with row pivots; whether it could be."""
    n = right.size
    for i in range(n):
        best = i
        for j in range(i + 1, n):
            if abs(matrix[j, i]) > abs(matrix[best, i]):
                best = j
        if not abs(matrix[best, i]) > 0.0:
            return False
        if best != i:
            for p in range(n):
                matrix[i, p], matrix[best, p] = matrix[best, p], matrix[i, p]
            right[i], right[best] = right[best], right[i]
        for j in range(i + 1, n):
            factor = matrix[j, i] / matrix[i, i]
            if factor != 0.0:
                for p in range(i, n):
                    matrix[j, p] -= factor * matrix[i, p]
                right[j] -= factor * right[i]
    for i in range(n - 1, -1, -1):
        total = right[i]
        for p in range(i + 1, n):
            total -= matrix[i, p] * right[p]
        right[i] = total / matrix[i, i]
    return True


@compiled
def attempt(
    line: FloatArray,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    mass: float,
    steps: FloatArray,
    pulls: FloatArray,
    forces: FloatArray,
    turn: int,
    step: FloatArray,
    pull: FloatArray,
    force: FloatArray,
    v0: float,
    length: float,
    grows: bool,
    acceleration: FloatArray,
    near: FloatArray,
) -> tuple[int, float, float]:
    """
    Solve a step of some length, from a guess of its accelerations.

    Returns whether it was, the speed at its end, and Q there of bodies that part.
    """
    n = moduli.size
    weighted = np.zeros((NODES, NODES + 1))
    base = np.zeros(NODES)
    part = np.empty(NODES + 1)
    for i in range(n):
        for j in range(NODES):
            z = AT[j] * length / times[i]
            moments(z, part)
            for p in range(NODES + 1):
                weighted[j, p] += moduli[i] * part[p]
            base[j] += math.exp(-z) * (force[i] if grows else moduli[i] * pull[i])
    by_node = np.zeros((NODES, NODES))
    for j in range(NODES):
        for q in range(NODES):
            total = 0.0
            for p in range(NODES):
                if grows:
                    total += TERMS[q, p] * weighted[j, p] * AT[j] ** (p + 1)
                else:
                    total += TERMS[q, p] / (p + 1.0) * weighted[j, p + 1] * AT[j] ** (p + 2)
            by_node[j, q] = length * total if grows else length * length * total
    equilibrium, viscosity = body[0], body[1]
    matrix, right = np.empty((NODES, NODES)), np.empty(NODES)
    v, d, k, bent, rate = np.empty(NODES), np.empty(NODES), np.empty(NODES), np.empty(NODES), np.empty(NODES)
    wanted = 0.0
    smallest = math.inf
    begin, d0 = step[BEGIN], step[DEPTH]
    f0 = curve(line, d0)[1]
    loads, lacking = np.empty(NODES), 0.0
    for _ in range(_TURNS):
        for j in range(NODES):
            v_j, d_j = 0.0, 0.0
            for q in range(NODES):
                v_j += ONCE[j, q] * acceleration[q]
                d_j += TWICE[j, q] * acceleration[q]
            v[j] = v0 + length * v_j
            d[j] = d0 + length * (AT[j] * v0 + length * d_j)
        if grows:
            for j in range(NODES):
                a, f = curve(line, d[j])[:2]
                if math.isnan(a):
                    return TOO_DEEP, 0.0, 0.0
                k[j] = 2.0 * a
                near_by = 1e-6 * d[j]
                bent[j] = (k[j] - 2.0 * curve(line, d[j] - near_by)[0]) / near_by if near_by > 0.0 else 0.0
                rate[j] = k[j] * v[j]
                loads[j] = f - f0
                right[j] = mass * acceleration[j] + base[j] + equilibrium * f + viscosity * rate[j]
            for j in range(NODES):
                # what the polynomial lacks of dF0, which is known, is spread over the way to the node
                lacking = loads[j]
                for q in range(NODES):
                    right[j] += by_node[j, q] * rate[q]
                    lacking -= length * ONCE[j, q] * rate[q]
                if abs(lacking) <= _ROUNDING * (loads[j] + f0):
                    lacking = 0.0
                right[j] += lacking * weighted[j, 0]
            for j in range(NODES):
                for q in range(NODES):
                    once, twice = length * ONCE[j, q], length * length * TWICE[j, q]
                    total = equilibrium * k[j] * twice + viscosity * (k[j] * once + bent[j] * v[j] * twice)
                    for p in range(NODES):
                        total += (
                            by_node[j, p]
                            * length
                            * (k[p] * ONCE[p, q] + bent[p] * v[p] * length * TWICE[p, q])
                        )
                    matrix[j, q] = total + (mass if q == j else 0.0)
        else:
            for j in range(NODES):
                wanted = (
                    equilibrium * d[j] + viscosity * v[j] + base[j] + v0 * weighted[j, 0] * AT[j] * length
                )
                for q in range(NODES):
                    wanted += by_node[j, q] * acceleration[q]
                f, a, _ = touched_at(
                    line,
                    body,
                    moduli,
                    times,
                    steps,
                    pulls,
                    forces,
                    turn,
                    begin + AT[j] * length,
                    wanted,
                    near,
                )
                right[j] = mass * acceleration[j] + f
                for q in range(NODES):
                    slope = (
                        equilibrium * length * length * TWICE[j, q]
                        + viscosity * length * ONCE[j, q]
                        + by_node[j, q]
                    )
                    matrix[j, q] = 2.0 * a * slope + (mass if q == j else 0.0)
        if not solved(matrix, right):
            return STUCK, 0.0, 0.0
        moved, size = 0.0, 0.0
        for j in range(NODES):
            acceleration[j] -= right[j]
            moved = max(moved, abs(right[j]))
            size = max(size, abs(acceleration[j]))
        if not moved < math.inf:
            return STUCK, 0.0, 0.0
        scale = abs(v0) + length * size
        if length * moved <= _ENOUGH * scale or moved <= 4e-16 * size:
            break
        if moved >= 0.5 * smallest and length * moved <= 1e-11 * scale:
            break
        smallest = min(smallest, moved)
    else:
        return STUCK, 0.0, 0.0
    v_end, d_end = 0.0, 0.0
    last = NODES - 1
    for q in range(NODES):
        v_end += ONCE[last, q] * acceleration[q]
        d_end += TWICE[last, q] * acceleration[q]
    v_end = v0 + length * v_end
    d_end = d0 + length * (v0 + length * d_end)
    step[LENGTH] = length
    step[SPEED] = v0
    for p in range(NODES):
        total, other = 0.0, 0.0
        for q in range(NODES):
            total += TERMS[q, p] * acceleration[q]
            other += TERMS[q, p] * rate[q]
        step[SPEED + p + 1] = length * total / (p + 1.0)
        step[RATE + p] = other if grows else 0.0
    if grows:
        step[RATE] += lacking / length
    if grows and not curve(line, d_end)[0] >= 0.0:
        return TOO_DEEP, 0.0, 0.0
    if not grows:
        wanted = equilibrium * d_end + viscosity * v_end + base[last] + v0 * weighted[last, 0] * length
        for q in range(NODES):
            wanted += by_node[last, q] * acceleration[q]
    return COMPLETE, v_end, wanted


@compiled
def forward(
    moduli: FloatArray, times: FloatArray, step: FloatArray, pull: FloatArray, force: FloatArray, grows: bool,
    next_pull: FloatArray, next_force: FloatArray,
) -> None:  # fmt: skip
    """What the branches bear at the end of a step."""
    part = np.empty(NODES + 1)
    length = step[LENGTH]
    for i in range(moduli.size):
        z = length / times[i]
        moments(z, part)
        total, other = 0.0, 0.0
        for p in range(NODES + 1):
            total += step[SPEED + p] * part[p]
            if p < NODES:
                other += step[RATE + p] * part[p]
        decay = math.exp(-z)
        next_pull[i] = decay * pull[i] + length * total
        next_force[i] = decay * force[i] + moduli[i] * length * other if grows else 0.0


@compiled
def run(
    line: FloatArray,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    mass: float,
    speed: float,
    first: float,
    tolerance: float,
    given: FloatArray,
    steps: FloatArray,
    pulls: FloatArray,
    forces: FloatArray,
    ends: FloatArray,
) -> tuple[int, int, int]:
    """
    Follow a mass from the touch to the turn and to the separation.

    `given` holds lengths of steps, after the number of those before the turn; without, they follow the tolerance. Returns
    how it ended, the number of steps to the turn, and of all. `ends` gets the depth and speed at the separation.
    """
    most = steps.shape[0] - 1
    grows = True
    turn, k, taken = 0, 0, 0
    v = speed
    length = first
    acceleration, guess, before = np.zeros(NODES), np.zeros(NODES), np.zeros(NODES)
    last = 0.0
    near = np.zeros(2)
    own = given.size > 0
    split = int(given[0]) if own else 0
    steps[0] = 0.0
    pulls[0] = 0.0
    forces[0] = 0.0
    if body[1] > 0.0:  # a flat end meets a dashpot at once
        last = -body[1] * 2.0 * curve(line, 1e-12 * first * speed)[0] * speed / mass
    fresh = True
    while k < most:
        if own:
            until = split if grows else given.size - 1
            at = min(taken, until - 1)
            length = given[1 + at]
        while True:
            stretch = length / steps[k - 1, LENGTH] if not fresh else 0.0
            for j in range(NODES):
                guess[j] = last
                if not fresh and stretch <= 2.0:
                    total, power = 0.0, 1.0
                    for p in range(NODES):
                        term = 0.0
                        for q in range(NODES):
                            term += TERMS[q, p] * before[q]
                        total += term * power
                        power *= 1.0 + AT[j] * stretch
                    guess[j] = total
                acceleration[j] = guess[j]
            code, v_end, wanted = attempt(
                line, body, moduli, times, mass, steps, pulls, forces, turn, steps[k], pulls[k], forces[k],
                v, length, grows, acceleration, near,
            )  # fmt: skip
            past = code == COMPLETE and (v_end <= 0.0 if grows else wanted <= 0.0)
            if code == COMPLETE:
                start = 0.0
                for q in range(NODES):
                    start += TERMS[q, 0] * acceleration[q]
                scale = max(abs(v), abs(v_end))
                error = length * abs(start - last) / scale if scale > 0.0 else math.inf
            else:
                error = math.inf
            if not error < math.inf:
                length *= 0.25
            elif own or error <= tolerance:
                break
            else:
                length *= min(max(0.9 * (tolerance / error) ** (1.0 / (NODES + 1.0)), 0.1), 0.8)
            if code == TOO_DEEP and length * max(abs(v), 1e-300) <= 1e-3 * steps[k, DEPTH]:
                return TOO_DEEP, turn, k
            if not length > 1e-14 * (steps[k, BEGIN] + length):
                return STUCK, turn, k
        if past:
            # the length at which it turns, or parts, by false positions on solved steps
            low, high = 0.0, length
            at_low = v if grows else math.nan
            if not grows:
                at_low = held(
                    line, body, moduli, times, steps[k], pulls[k], forces[k], 0.0, 0.0, False
                )[3] + body[1] * v  # fmt: skip
            at_high = v_end if grows else wanted
            size = abs(at_low) + abs(at_high)
            side = 0
            trial = length
            for _ in range(_SEARCHES):
                trial = low + (high - low) * at_low / (at_low - at_high)
                if not low < trial < high:
                    trial = 0.5 * (low + high)
                code, v_end, wanted = attempt(
                    line, body, moduli, times, mass, steps, pulls, forces, turn, steps[k], pulls[k], forces[k],
                    v, trial, grows, acceleration, near,
                )  # fmt: skip
                if code != COMPLETE:
                    return STUCK, turn, k
                value = v_end if grows else wanted
                if abs(value) <= 1e-15 * size or high - low <= 4e-16 * high:
                    break
                if value > 0.0:
                    low, at_low = trial, value
                    if side == 1:
                        at_high *= 0.5
                    side = 1
                else:
                    high, at_high = trial, value
                    if side == -1:
                        at_low *= 0.5
                    side = -1
            length = trial
        here, onward = steps[k], steps[k + 1]
        forward(moduli, times, here, pulls[k], forces[k], grows, pulls[k + 1], forces[k + 1])
        onward[:] = 0.0
        onward[BEGIN] = here[BEGIN] + length
        total = 0.0
        for p in range(NODES + 1):
            total += here[SPEED + p] / (p + 1.0)
        onward[DEPTH] = here[DEPTH] + length * total
        v = 0.0 if past and grows else v_end
        onward[SPEED] = v
        last = acceleration[NODES - 1]
        before[:] = acceleration
        fresh = False
        k += 1
        taken += 1
        if past:
            if not grows:
                ends[0], ends[1] = onward[DEPTH], v
                return COMPLETE, turn, k
            grows, turn, fresh, taken = False, k, True, split
            near[0], near[1] = float(k - 1), steps[k - 1, LENGTH]
        elif grows and body[0] == 0.0 and v <= _STILL * speed:
            return RESTS, k, k
        elif not own:
            length *= min(max(0.9 * (tolerance / max(error, 1e-300)) ** (1.0 / (NODES + 1.0)), 0.2), 4.0)
    return TOO_MANY, turn, k


@compiled
def _force(
    line: FloatArray,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    steps: FloatArray,
    pulls: FloatArray,
    forces: FloatArray,
    turn: int,
    k: int,
    x: float,
    near: FloatArray,
    out: FloatArray,
) -> None:
    """Depth, speed, force, radius and t1 at a time after the begin of a step."""
    grows = k < turn
    last = steps[k, BEGIN] + x
    d, v, a, pull, force, _ = held(line, body, moduli, times, steps[k], pulls[k], forces[k], x, 0.0, grows)
    if grows:
        force += body[1] * 2.0 * a * v
    else:
        force, a, last = touched_at(
            line, body, moduli, times, steps, pulls, forces, turn, steps[k, BEGIN] + x, pull + body[1] * v, near
        )  # fmt: skip
    out[0], out[1], out[2], out[3], out[4] = d, v, force, a, last


@compiled
def _hit(
    line: FloatArray,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    steps: FloatArray,
    pulls: FloatArray,
    forces: FloatArray,
    turn: int,
    at: int,
    time: float,
    near: FloatArray,
    out: FloatArray,
) -> float:
    """Force at a time in a step or the one before."""
    k = at - 1 if at > 0 and time < steps[at, BEGIN] else at
    _force(line, body, moduli, times, steps, pulls, forces, turn, k, time - steps[k, BEGIN], near, out)
    return float(out[2])


_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@compiled
def hardest(
    line: FloatArray,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    steps: FloatArray,
    pulls: FloatArray,
    forces: FloatArray,
    turn: int,
    count: int,
) -> tuple[float, float]:
    """Time and size of the largest force."""
    near, out = np.zeros(2), np.zeros(READ)
    near[0], near[1] = float(turn - 1), steps[turn - 1, LENGTH]
    best, at = 0.0, 0
    for k in range(count):
        # a dashpot under a flat end is hit hardest at the touch
        x = 1e-9 * steps[0, LENGTH] if k == 0 else 0.0
        _force(line, body, moduli, times, steps, pulls, forces, turn, k, x, near, out)
        if out[2] > best:
            best, at = out[2], k
    low = steps[max(at - 1, 0), BEGIN]
    high = steps[min(at + 1, count), BEGIN]
    if at == 0:
        low = 1e-9 * steps[0, LENGTH]
    when, most = steps[at, BEGIN], best
    inner, outer = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at_inner, at_outer = -1.0, -1.0
    for _ in range(60):
        if at_inner < 0.0:
            at_inner = _hit(line, body, moduli, times, steps, pulls, forces, turn, at, inner, near, out)
            if at_inner > most:
                most, when = at_inner, inner
        if at_outer < 0.0:
            at_outer = _hit(line, body, moduli, times, steps, pulls, forces, turn, at, outer, near, out)
            if at_outer > most:
                most, when = at_outer, outer
        if at_inner > at_outer:
            high, outer, at_outer = outer, inner, at_inner
            inner, at_inner = high - _GOLDEN * (high - low), -1.0
        else:
            low, inner, at_inner = inner, outer, at_outer
            outer, at_outer = low + _GOLDEN * (high - low), -1.0
        if high - low <= 1e-8 * high:
            break
    return when, most


@compiled
def read(
    line: FloatArray,
    body: FloatArray,
    moduli: FloatArray,
    times: FloatArray,
    steps: FloatArray,
    pulls: FloatArray,
    forces: FloatArray,
    turn: int,
    count: int,
    time: FloatArray,
    out: FloatArray,
) -> None:
    """Rows at rising times: depth, speed, force, radius, t1."""
    k = 0
    near = np.zeros(2)
    near[0], near[1] = float(turn - 1), steps[turn - 1, LENGTH]
    for r in range(time.size):
        while k < count - 1 and time[r] >= steps[k + 1, BEGIN]:
            k += 1
        x = min(time[r] - steps[k, BEGIN], steps[k, LENGTH])
        _force(line, body, moduli, times, steps, pulls, forces, turn, k, x, near, out[r])


@compiled
def extended(
    times: FloatArray, steps: FloatArray, pulls: FloatArray, count: int, time: FloatArray, out: FloatArray
) -> None:
    """Integrals of exp(-(t - s)/tau) dd(s) at rising times."""
    k = 0
    part = np.empty(NODES + 1)
    for r in range(time.size):
        while k < count - 1 and time[r] >= steps[k + 1, BEGIN]:
            k += 1
        x = min(time[r] - steps[k, BEGIN], steps[k, LENGTH])
        share = x / steps[k, LENGTH]
        for i in range(times.size):
            moments(x / times[i], part)
            total, power = 0.0, x
            for p in range(NODES + 1):
                total += steps[k, SPEED + p] * power * part[p]
                power *= share
            out[r, i] = math.exp(-x / times[i]) * pulls[k, i] + total
