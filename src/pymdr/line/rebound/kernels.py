"""Compiled steps of a mass on springs with memory. Loads numba.

On a step the acceleration is a polynomial through the nodes of Radau, at which the equation of motion holds. Speed and
depth are its integrals, and the forces of the branches are exact for the polynomial through the rates k(d) d' of the
growing contact. As the bodies part, the force depends on the motion by one number, Q = int E(t - s) dd(s): with
P(t1) = int_0^t1 E(t - s) dd(s) = Q, the force int_0^t1 E(t - s) dF0 rises with Q by k(d(t1)). Whatever the rates of the
branches, the unknowns of a step are the accelerations at its nodes.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from pymdr import compiling
from pymdr.compiling import Addressed, call
from pymdr.line.friction import reading
from pymdr.numerics.newton import narrowed
from pymdr.units import FloatArray

# the curves that are read are compiled into the callers
_STAMP = compiling.stamp_of(__file__, reading.__file__)


_FUSED = {"fastmath": {"contract"}}
"""Products and sums may be fused, nothing else."""


def compiled(function: compiling.Function, **options: Any) -> compiling.Function:
    """Compile with numba when first called; kept on disk."""
    return compiling.compiled(function, _STAMP, **_FUSED, **options)


def inner(function: compiling.Function) -> compiling.Function:
    """Compile for other kernels alone."""
    return compiled(function, **compiling.INNER)


addressed = partial(Addressed, options=_FUSED)
"""Compile for kernels that call by address."""


@inner
def curve(line: FloatArray, d: float) -> tuple[float, float, float]:
    """a, F_N and W at a depth, by a call: compiled into every caller they cost more than they save here."""
    return reading.curve(line, d)


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


class Body(NamedTuple):
    """A mass, the curves per unit modulus of its contact, and E*(t)."""

    line: FloatArray
    moduli: FloatArray
    times: FloatArray
    equilibrium: float
    viscosity: float
    mass: float
    edge: Any
    """The address of :func:`edge_at`."""
    attempt: Any
    """The address of :func:`attempt`."""


class Track(NamedTuple):
    """Steps, and at the begin of each what the branches bear: int exp dd, and int E exp dF0 up to the turning point."""

    steps: FloatArray
    pulls: FloatArray
    forces: FloatArray


class State(NamedTuple):
    """d, d' and a at a time; P = int E dd and int E dF0 up to it, and E dd/dt, all after a wait."""

    depth: float
    speed: float
    radius: float
    pull: float
    force: float
    rate: float


class Edge(NamedTuple):
    """The force, the contact radius and t1 of bodies that part."""

    force: float
    radius: float
    time: float


BASE, RIGHT, ACCELERATION, GROWTH, LOAD, STIFFNESS, BEFORE = range(7)
"""Columns of the nodes of a step: what is borne from before it, the equations, the accelerations, k(d) d', the growth of F0 over the
step, k(d), and the accelerations of the step before."""
MATRIX, SLOPE, BY_NODE, WEIGHTED = (BEFORE + 1 + NODES * k for k in range(4))
"""From these on: the equations and the rates by the accelerations, what each rate adds, and sums of E times the moments."""
_OF_NODES = WEIGHTED + NODES + 1


_NO_EDGE = Edge(0.0, 0.0, 0.0)
"""The type of what :func:`edge_at` returns."""


class Work(NamedTuple):
    """What is filled anew on every step; few arrays, since each takes time to compile where one kernel hands it on."""

    nodes: FloatArray
    part: FloatArray
    """(NODES + 1,) moments of a branch."""
    near: FloatArray
    """(2,) the step and the time in it of the last t1."""


def workspace() -> Work:
    """Arrays for the steps of one motion: allocating them in a kernel is slow to compile."""
    return Work(np.zeros((NODES, _OF_NODES)), np.zeros(NODES + 1), np.zeros(2))


def body_of(
    line: FloatArray, moduli: FloatArray, times: FloatArray, e: tuple[float, float], mass: float
) -> Body:
    """A body, whose `e` are E* after all relaxation and its viscosity, with the addresses of what kernels call."""
    body, work, none = Body(line, moduli, times, *e, mass, 0, 0), workspace(), np.zeros((0, 0))
    track = Track(none, none, none)
    edge = edge_at.address(_NO_EDGE, body, track, 0, 0.0, 0.0, work)
    return body._replace(edge=edge, attempt=attempt.address(_ENDED, body, track, 0, 0, 0.0, work))


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


@inner
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


@inner
def state_at(body: Body, track: Track, k: int, x: float, wait: float, part: FloatArray) -> State:
    """What the motion up to x in s after the begin of step k still does a time later."""
    step = track.steps[k]
    fraction = x / step[LENGTH] if step[LENGTH] > 0.0 else 0.0
    v, d, power = 0.0, 0.0, 1.0
    for p in range(NODES + 1):
        v += step[SPEED + p] * power
        d += step[SPEED + p] * power / (p + 1.0)
        power *= fraction
    d = step[DEPTH] + x * d
    a, f, _work = curve(body.line, d)
    pull, force, modulus = body.equilibrium * d, body.equilibrium * f, body.equilibrium
    for i in range(body.moduli.size):
        z = x / body.times[i]
        left = math.exp(-wait / body.times[i])
        decay = math.exp(-z)
        moments(z, part)
        own, other, power = 0.0, 0.0, 1.0
        for p in range(NODES):
            own += step[SPEED + p] * power * part[p]
            other += step[RATE + p] * power * part[p]
            power *= fraction
        own += step[SPEED + NODES] * power * part[NODES]
        pull += left * body.moduli[i] * (decay * track.pulls[k, i] + x * own)
        modulus += body.moduli[i] * left
        force += left * (decay * track.forces[k, i] + body.moduli[i] * x * other)
    return State(d, v, a, pull, force, modulus * v)


@addressed
def edge_at(body: Body, track: Track, turn: int, now: float, wanted: float, work: Work) -> Edge:
    """The edge of bodies that part, from Q: the time t1 before the turning point at which P = Q."""
    if wanted <= 0.0:
        return Edge(0.0, 0.0, 0.0)
    steps, near, part = track.steps, work.near, work.part
    k = int(near[0])
    x, start = near[1], 0.0
    # the step whose P at its begin is below what is wanted, and at its end above
    while k > 0 and state_at(body, track, k, start, now - steps[k, BEGIN], part).pull > wanted:
        k -= 1
        x = steps[k, LENGTH]
    while (
        k < turn - 1 and state_at(body, track, k + 1, start, now - steps[k + 1, BEGIN], part).pull <= wanted
    ):
        k += 1
        x = start
    low, high, begin = 0.0, steps[k, LENGTH], steps[k, BEGIN]
    here = state_at(body, track, k, x, max(now - begin - x, 0.0), part)
    for _ in range(_SEARCHES):
        over = here.pull - wanted
        if abs(over) <= 4e-16 * (abs(wanted) + abs(here.pull)):
            break
        low, high, new = narrowed(low, high, x, over, here.rate)
        if abs(new - x) <= 1e-15 * (begin + x) or high - low <= 4e-16 * (begin + high):
            break
        x = new
        here = state_at(body, track, k, x, max(now - begin - x, 0.0), part)
    near[0], near[1] = k, x
    # the force is smooth in Q where t1 is not: what the search left is made good by its slope
    return Edge(max(here.force + 2.0 * here.radius * (wanted - here.pull), 0.0), here.radius, begin + x)


@inner
def solved(nodes: FloatArray) -> bool:
    """Solve a small system in place, with row pivots; whether it could be."""
    n = nodes.shape[0]
    for i in range(n):
        best = i
        for j in range(i + 1, n):
            if abs(nodes[j, MATRIX + i]) > abs(nodes[best, MATRIX + i]):
                best = j
        if not abs(nodes[best, MATRIX + i]) > 0.0:
            return False
        if best != i:
            for p in range(n):
                nodes[i, MATRIX + p], nodes[best, MATRIX + p] = nodes[best, MATRIX + p], nodes[i, MATRIX + p]
            nodes[i, RIGHT], nodes[best, RIGHT] = nodes[best, RIGHT], nodes[i, RIGHT]
        for j in range(i + 1, n):
            factor = nodes[j, MATRIX + i] / nodes[i, MATRIX + i]
            if factor != 0.0:
                for p in range(i, n):
                    nodes[j, MATRIX + p] -= factor * nodes[i, MATRIX + p]
                nodes[j, RIGHT] -= factor * nodes[i, RIGHT]
    for i in range(n - 1, -1, -1):
        total = nodes[i, RIGHT]
        for p in range(i + 1, n):
            total -= nodes[i, MATRIX + p] * nodes[p, RIGHT]
        nodes[i, RIGHT] = total / nodes[i, MATRIX + i]
    return True


@inner
def prepare(body: Body, track: Track, k: int, length: float, grows: bool, work: Work) -> None:
    """What the branches bear at the nodes of a step, by its accelerations or rates and by what was before."""
    nodes, part = work.nodes, work.part
    for j in range(NODES):
        nodes[j, BASE] = 0.0
        for p in range(NODES + 1):
            nodes[j, WEIGHTED + p] = 0.0
        for i in range(body.moduli.size):
            z = AT[j] * length / body.times[i]
            moments(z, part)
            for p in range(NODES + 1):
                nodes[j, WEIGHTED + p] += body.moduli[i] * part[p]
            borne = track.forces[k, i] if grows else body.moduli[i] * track.pulls[k, i]
            nodes[j, BASE] += math.exp(-z) * borne
        for q in range(NODES):
            total = 0.0
            for p in range(NODES):
                if grows:
                    total += TERMS[q, p] * nodes[j, WEIGHTED + p] * AT[j] ** (p + 1)
                else:
                    total += TERMS[q, p] / (p + 1.0) * nodes[j, WEIGHTED + p + 1] * AT[j] ** (p + 2)
            nodes[j, BY_NODE + q] = length * total if grows else length * length * total


@inner
def moved(step: FloatArray, length: float, j: int, nodes: FloatArray) -> tuple[float, float]:
    """Depth and speed at a node of a step."""
    v, d = 0.0, 0.0
    for q in range(NODES):
        v += ONCE[j, q] * nodes[q, ACCELERATION]
        d += TWICE[j, q] * nodes[q, ACCELERATION]
    v0 = step[SPEED]
    return step[DEPTH] + length * (AT[j] * v0 + length * d), v0 + length * v


@inner
def approach(body: Body, step: FloatArray, length: float, work: Work) -> float:
    """
    The equations at the nodes while the contact grows.

    Returns what the polynomial lacks of the way of F0 to the last node; NaN beyond the curves.
    """
    nodes = work.nodes
    f0 = curve(body.line, step[DEPTH])[1]
    for j in range(NODES):
        d, v = moved(step, length, j, nodes)
        a, f, _work = curve(body.line, d)
        if math.isnan(a):
            return math.nan
        near_by = 1e-6 * d
        bent = 2.0 * (a - curve(body.line, d - near_by)[0]) / near_by if near_by > 0.0 else 0.0
        nodes[j, STIFFNESS] = 2.0 * a
        nodes[j, GROWTH] = 2.0 * a * v
        nodes[j, LOAD] = f - f0
        for q in range(NODES):
            nodes[j, SLOPE + q] = length * (2.0 * a * ONCE[j, q] + bent * v * length * TWICE[j, q])
    lacking = 0.0
    for j in range(NODES):
        load = nodes[j, LOAD]
        total = body.equilibrium * (f0 + load) + body.viscosity * nodes[j, GROWTH] + nodes[j, BASE]
        # what the polynomial lacks of dF0, which is known, is spread over the way to the node
        lacking = load
        for q in range(NODES):
            total += nodes[j, BY_NODE + q] * nodes[q, GROWTH]
            lacking -= length * ONCE[j, q] * nodes[q, GROWTH]
        if abs(lacking) <= _ROUNDING * (load + f0):
            lacking = 0.0
        nodes[j, RIGHT] = body.mass * nodes[j, ACCELERATION] + total + lacking * nodes[j, WEIGHTED]
        for q in range(NODES):
            total = body.equilibrium * nodes[j, STIFFNESS] * length * length * TWICE[j, q]
            total += body.viscosity * nodes[j, SLOPE + q] + (body.mass if q == j else 0.0)
            for p in range(NODES):
                total += nodes[j, BY_NODE + p] * nodes[p, SLOPE + q]
            nodes[j, MATRIX + q] = total
    return lacking


@inner
def history_at(body: Body, step: FloatArray, length: float, j: int, work: Work) -> float:
    """Q at a node of a step on the retreat: int E dd, with the dashpot."""
    nodes = work.nodes
    d, v = moved(step, length, j, nodes)
    wanted = body.equilibrium * d + body.viscosity * v + nodes[j, BASE]
    wanted += step[SPEED] * nodes[j, WEIGHTED] * AT[j] * length
    for q in range(NODES):
        wanted += nodes[j, BY_NODE + q] * nodes[q, ACCELERATION]
    return float(wanted)


@inner
def retreat(body: Body, track: Track, turn: int, k: int, length: float, work: Work) -> None:
    """The equations at the nodes while the bodies part."""
    step, nodes = track.steps[k], work.nodes
    for j in range(NODES):
        wanted = history_at(body, step, length, j, work)
        edge = call(body.edge, _NO_EDGE, (body, track, turn, step[BEGIN] + AT[j] * length, wanted, work))
        nodes[j, RIGHT] = body.mass * nodes[j, ACCELERATION] + edge.force
        for q in range(NODES):
            slope = body.equilibrium * length * length * TWICE[j, q]
            slope += body.viscosity * length * ONCE[j, q] + nodes[j, BY_NODE + q]
            nodes[j, MATRIX + q] = 2.0 * edge.radius * slope + (body.mass if q == j else 0.0)


@addressed
def attempt(
    body: Body, track: Track, turn: int, k: int, length: float, work: Work
) -> tuple[int, float, float]:
    """
    Solve step k of some length, from a guess of its accelerations; `turn` is 0 on the approach.

    Returns whether it was, the speed at its end, and Q there of bodies that part.
    """
    step, nodes = track.steps[k], work.nodes
    grows = turn == 0
    prepare(body, track, k, length, grows, work)
    lacking, smallest = 0.0, math.inf
    converged = False
    for _ in range(_TURNS):
        if grows:
            lacking = approach(body, step, length, work)
            if math.isnan(lacking):
                return TOO_DEEP, 0.0, 0.0
        else:
            retreat(body, track, turn, k, length, work)
        if not solved(nodes):
            return STUCK, 0.0, 0.0
        change, size = 0.0, 0.0
        for j in range(NODES):
            nodes[j, ACCELERATION] -= nodes[j, RIGHT]
            change = max(change, abs(nodes[j, RIGHT]))
            size = max(size, abs(nodes[j, ACCELERATION]))
        scale = abs(step[SPEED]) + length * size
        converged = length * change <= _ENOUGH * scale or change <= 4e-16 * size
        converged = converged or (change >= 0.5 * smallest and length * change <= 1e-11 * scale)
        if converged or not change < math.inf:
            break
        smallest = min(smallest, change)
    if not converged:
        return STUCK, 0.0, 0.0
    last = nodes.shape[0] - 1
    d_end, v_end = moved(step, length, last, nodes)
    step[LENGTH] = length
    for p in range(NODES):
        total, other = 0.0, 0.0
        for q in range(NODES):
            total += TERMS[q, p] * nodes[q, ACCELERATION]
            other += TERMS[q, p] * nodes[q, GROWTH]
        step[SPEED + p + 1] = length * total / (p + 1.0)
        step[RATE + p] = other if grows else 0.0
    if not grows:
        return COMPLETE, v_end, history_at(body, step, length, last, work)
    step[RATE] += lacking / length
    if not curve(body.line, d_end)[0] >= 0.0:
        return TOO_DEEP, 0.0, 0.0
    return COMPLETE, v_end, 0.0


@inner
def guess(track: Track, k: int, length: float, fresh: bool, work: Work) -> None:
    """Accelerations of a step from those of the step before, unless the motion changes its course between them."""
    nodes = work.nodes
    stretch = math.inf if fresh else length / track.steps[k - 1, LENGTH]
    for j in range(NODES):
        nodes[j, ACCELERATION] = nodes[NODES - 1, BEFORE]
        if stretch <= 2.0:
            total, power = 0.0, 1.0
            for p in range(NODES):
                term = 0.0
                for q in range(NODES):
                    term += TERMS[q, p] * nodes[q, BEFORE]
                total += term * power
                power *= 1.0 + AT[j] * stretch
            nodes[j, ACCELERATION] = total


_ENDED = int(0.0), 0.0, 0.0
"""The type of what :func:`attempt` returns."""


class Solved(NamedTuple):
    """How a step ended: its length, its error, and the speed and Q at its end."""

    code: int
    length: float
    error: float
    speed: float
    history: float


@inner
def solve_step(
    body: Body, track: Track, turn: int, k: int, length: float, tolerance: float, fresh: bool, work: Work
) -> Solved:
    """Solve a step of the given length, or of one so short that it errs by less than the tolerance."""
    step, nodes = track.steps[k], work.nodes
    while True:
        guess(track, k, length, fresh, work)
        code, v_end, history = call(body.attempt, _ENDED, (body, track, turn, k, length, work))
        error = math.inf
        scale = max(abs(step[SPEED]), abs(v_end))
        if code == COMPLETE and scale > 0.0:
            start = 0.0
            for q in range(NODES):
                start += TERMS[q, 0] * nodes[q, ACCELERATION]
            error = length * abs(start - nodes[NODES - 1, BEFORE]) / scale
        if not error < math.inf:
            length *= 0.25
        elif error <= tolerance:
            return Solved(code, length, error, v_end, history)
        else:
            length *= min(max(0.9 * (tolerance / error) ** (1.0 / (NODES + 1.0)), 0.1), 0.8)
        if code == TOO_DEEP and length * max(abs(step[SPEED]), 1e-300) <= 1e-3 * step[DEPTH]:
            return Solved(code, length, error, v_end, history)
        if not length > 1e-14 * (step[BEGIN] + length):
            return Solved(max(code, STUCK), length, error, v_end, history)


@inner
def end_within(body: Body, track: Track, turn: int, k: int, first: Solved, work: Work) -> Solved:
    """The length at which a step ends in the turning point, or the bodies part, by false positions on solved steps."""
    v, grows = track.steps[k, SPEED], turn == 0
    low, high = 0.0, first.length
    at_low, at_high = v, first.speed
    if not grows:
        at_low = state_at(body, track, k, low, low, work.part).pull + body.viscosity * v
        at_high = first.history
    size = abs(at_low) + abs(at_high)
    side = 0
    outcome = first
    for _ in range(_SEARCHES):
        trial = low + (high - low) * at_low / (at_low - at_high)
        if not low < trial < high:
            trial = 0.5 * (low + high)
        code, v_end, history = call(body.attempt, _ENDED, (body, track, turn, k, trial, work))
        outcome = Solved(code, trial, first.error, v_end, history)
        value = v_end if grows else history
        if code != COMPLETE or abs(value) <= 1e-15 * size or high - low <= 4e-16 * high:
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
    return outcome


@inner
def forward(body: Body, track: Track, k: int, speed: float, part: FloatArray) -> None:
    """Begin step k + 1 where step k ends: what the branches bear, the time, the depth and the speed."""
    step, onward = track.steps[k], track.steps[k + 1]
    length = step[LENGTH]
    for i in range(body.moduli.size):
        z = length / body.times[i]
        moments(z, part)
        total, other = step[SPEED + NODES] * part[NODES], 0.0
        for p in range(NODES):
            total += step[SPEED + p] * part[p]
            other += step[RATE + p] * part[p]
        decay = math.exp(-z)
        track.pulls[k + 1, i] = decay * track.pulls[k, i] + length * total
        # the rates are 0 on the retreat, and the forces are not read
        track.forces[k + 1, i] = decay * track.forces[k, i] + body.moduli[i] * length * other
    total = 0.0
    for p in range(NODES + 1):
        total += step[SPEED + p] / (p + 1.0)
    onward[BEGIN] = step[BEGIN] + length
    onward[DEPTH] = step[DEPTH] + length * total
    onward[SPEED] = speed


@inner
def start_search(track: Track, turn: int, near: FloatArray) -> None:
    """Look for t1 at the turning point first."""
    near[0], near[1] = turn - 1, track.steps[turn - 1, LENGTH]


@compiled
def run(
    body: Body, track: Track, first: float, tolerance: float, given: FloatArray, work: Work
) -> tuple[int, int, int]:
    """
    Follow a mass from the touch, at the speed of step 0, to the turn and to the separation.

    `given` holds lengths of steps, after the number of those before the turn; without, they follow the tolerance.
    Returns how it ended, the number of steps to the turn, and of all.
    """
    steps, nodes = track.steps, work.nodes
    speed = steps[0, SPEED]
    own = given.size > 0
    if body.viscosity > 0.0:  # a flat end meets a dashpot at once
        at_once = -body.viscosity * 2.0 * curve(body.line, 1e-12 * first * speed)[0] * speed / body.mass
        for j in range(NODES):
            nodes[j, BEFORE] = at_once
    turn = k = taken = int(0.0)  # numbers: kernels are compiled once more for constants
    fresh = k == 0
    length = first
    while k < steps.shape[0] - 1:
        if own:
            until = given.size - 1 if turn > 0 else int(given[0])
            length = given[1 + taken] if taken < until else given[until]
            tolerance = math.inf
        outcome = solve_step(body, track, turn, k, length, tolerance, fresh, work)
        if outcome.code != COMPLETE:
            return outcome.code, turn, k
        past = (outcome.history if turn > 0 else outcome.speed) <= 0.0
        if past:
            outcome = end_within(body, track, turn, k, outcome, work)
            if outcome.code != COMPLETE:
                return STUCK, turn, k
        turns = past and turn == 0
        forward(body, track, k, 0.0 if turns else outcome.speed, work.part)
        for j in range(NODES):
            nodes[j, BEFORE] = nodes[j, ACCELERATION]
        k += 1
        taken += 1
        fresh = turns
        if turns:
            turn = k
            taken = int(given[0]) if own else 0
            start_search(track, turn, work.near)
        elif past:
            return COMPLETE, turn, k
        elif turn == 0 and body.equilibrium == 0.0 and outcome.speed <= _STILL * speed:
            return RESTS, k, k
        else:
            growth = 0.9 * (tolerance / max(outcome.error, 1e-300)) ** (1.0 / (NODES + 1.0))
            length = outcome.length * min(max(growth, 0.2), 4.0)
        if past:
            length = outcome.length
    return TOO_MANY, turn, k


@inner
def force_at(body: Body, track: Track, turn: int, k: int, x: float, work: Work) -> tuple[State, Edge]:
    """The state, and the edge of the contact, at a time after the begin of a step."""
    state = state_at(body, track, k, x, 0.0, work.part)
    now = track.steps[k, BEGIN] + x
    if k < turn:
        return state, Edge(state.force + body.viscosity * 2.0 * state.radius * state.speed, state.radius, now)
    wanted = state.pull + body.viscosity * state.speed
    return state, call(body.edge, _NO_EDGE, (body, track, turn, now, wanted, work))


@inner
def hit(body: Body, track: Track, turn: int, at: int, time: float, work: Work) -> float:
    """Force at a time in a step or the one before."""
    k = at - 1 if at > 0 and time < track.steps[at, BEGIN] else at
    return force_at(body, track, turn, k, time - track.steps[k, BEGIN], work)[1].force


_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@compiled
def hardest(body: Body, track: Track, turn: int, count: int, work: Work) -> tuple[float, float]:
    """Time and size of the largest force."""
    steps = track.steps
    start_search(track, turn, work.near)
    most, at = 0.0, int(0.0)
    # a dashpot under a flat end is hit hardest at the touch
    touch = 1e-9 * steps[0, LENGTH]
    for k in range(count):
        force = hit(body, track, turn, k, steps[k, BEGIN] if k > 0 else touch, work)
        if force > most:
            most, at = force, k
    when = steps[at, BEGIN]
    low, high = steps[at - 1, BEGIN] if at > 0 else touch, steps[at + 1, BEGIN]
    inner, outer = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at_inner, at_outer = hit(body, track, turn, at, inner, work), hit(body, track, turn, at, outer, work)
    for _ in range(60):
        if at_inner > at_outer:
            if at_inner > most:
                most, when = at_inner, inner
            high, outer, at_outer = outer, inner, at_inner
            inner = high - _GOLDEN * (high - low)
            at_inner = hit(body, track, turn, at, inner, work)
        else:
            if at_outer > most:
                most, when = at_outer, outer
            low, inner, at_inner = inner, outer, at_outer
            outer = low + _GOLDEN * (high - low)
            at_outer = hit(body, track, turn, at, outer, work)
        if high - low <= 1e-8 * high:
            break
    return when, most


@compiled
def read(
    body: Body, track: Track, turn: int, count: int, time: FloatArray, out: FloatArray, work: Work
) -> None:
    """Rows at rising times: depth, speed, force, radius, t1."""
    k = int(0.0)
    start_search(track, turn, work.near)
    for r in range(time.size):
        while k < count - 1 and time[r] >= track.steps[k + 1, BEGIN]:
            k += 1
        x = min(time[r] - track.steps[k, BEGIN], track.steps[k, LENGTH])
        state, edge = force_at(body, track, turn, k, x, work)
        out[r, 0], out[r, 1] = state.depth, state.speed
        out[r, 2], out[r, 3], out[r, 4] = edge.force, edge.radius, edge.time


@compiled
def extended(
    times: FloatArray, track: Track, count: int, time: FloatArray, out: FloatArray, part: FloatArray
) -> None:
    """Integrals of exp(-(t - s)/tau) dd(s) at rising times."""
    steps = track.steps
    k = 0
    for r in range(time.size):
        while k < count - 1 and time[r] >= steps[k + 1, BEGIN]:
            k += 1
        x = min(time[r] - steps[k, BEGIN], steps[k, LENGTH])
        fraction = x / steps[k, LENGTH]
        for i in range(times.size):
            moments(x / times[i], part)
            total, power = 0.0, x
            for p in range(NODES + 1):
                total += steps[k, SPEED + p] * power * part[p]
                power *= fraction
            out[r, i] = math.exp(-x / times[i]) * track.pulls[k, i] + total
