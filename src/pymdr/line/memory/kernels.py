"""Compiled steps of springs with memory. Imported only when a history is followed: it loads numba.

A spring in contact keeps the forces h of its Maxwell branches, whose length w follows the indentation: exact for
straight moves. A free one keeps the amplitudes of the modes in which it creeps back. Branches and modes are monotone within a
step, so that their ends bound the force of a spring, or its gap, from below: most stay on their side by far. Of the others the
force and the gap are sums of exponentials, whose first crossing of 0 is found whatever the step.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pymdr.compiling import compiled, inner
from pymdr.line.memory.modes import BORNE, FREE, REST, TURN, Modes, W
from pymdr.line.memory.springs import Springs
from pymdr.mapping.relaxation import Relaxation
from pymdr.numerics.exponentials import (
    DECAYING,
    GROWING,
    RATES,
    ROUNDING,
    SHORTEST,
    first_crossing,
    mean,
    moments,
)
from pymdr.units import FloatArray

_SHORTLY = 1e-3
"""Of a step: the time that tells the modulus by which the force of a spring that is let go is continued."""
DECAY, MEAN, RAMP, OWN, CROSS, MOVED = range(6)
"""Of a branch over a step x = s/tau, h -> DECAY h + E MEAN dw; work dw (MEAN h + E RAMP dw); its dissipation in units of
1/E: OWN h^2 + 2 CROSS h E dw + MOVED (E dw)^2."""
COEFFICIENTS = 6
FORCE, RATE, STORED, LOST, WORK, EDGE_DEPTH, LAST, COUNT, PARTS, THERE, OWNER, PART = range(12)
"""Columns of a row; RATE is dF/dd, LAST the outermost spring in contact, COUNT how many are, PARTS what was tried of all. A history
adds the indentation, and the row to which a part of one belongs with its end as a share of that."""
COLUMNS = 12
HEIGHT, SHARE, CENTRE, OUTER, POSITION = range(5)
"""Rows of the springs: d0, dk, k per unit modulus at the spring and at the outer end of its part, and x."""
MODULUS, SOFT, RELAXING, BACK = range(4)
"""Columns of the branches of a body: E, 1/E, tau, and from BACK on what each mode of a free spring adds to the force."""
FADING, REACH, INTO = range(3)
"""Columns of the modes of a body: the rate, what w follows of it, and from INTO on what each branch, and w, adds to it."""
H, M, LEFT, TAKEN, ELASTIC, LOADED, SQUARES = range(RATES + 1, RATES + 8)
"""Columns of the work, after those of the terms of a sum: the branches and the modes of a spring that changes sides; what is left of
the modes after a step, and what their dashpots take; E dw, and of the springs that stay in contact the sums of h and of its square."""
DURATION, FIRM, _LOST, _WORK, _TRIED = range(5)
"""What is known of a step: how long it is and the stiffness of a spring; and of the last spring that changed sides what its dashpots
take, the work, and what was tried."""


class Body(NamedTuple):
    """How a spring relaxes and creeps back."""

    equilibrium: float
    viscosity: float
    branches: FloatArray
    modes: FloatArray


class Move(NamedTuple):
    """A straight way from one indentation to another, with what a dashpot adds to every spring on it."""

    start: float
    way: float
    duration: float
    drag: float


class Room(NamedTuple):
    """Few arrays of many columns: every array that one kernel hands on to another takes time to compile."""

    known: FloatArray
    branch: FloatArray
    """(n, 6) coefficients of a whole step, and of a part of one."""
    part: FloatArray
    work: FloatArray


def branch_table(relaxation: Relaxation) -> FloatArray:
    """The first columns of the branches of a body."""
    return np.column_stack([relaxation.moduli, 1.0 / relaxation.moduli, relaxation.times])


def body_of(relaxation: Relaxation, modes: Modes) -> Body:
    """What kernels ask of a body."""
    return Body(
        float(relaxation.equilibrium),
        float(relaxation.viscosity),
        np.ascontiguousarray(np.column_stack([branch_table(relaxation), modes.to_branches])),
        np.ascontiguousarray(np.column_stack([modes.rates, modes.reach, modes.to_modes])),
    )


def table_of(springs: Springs) -> FloatArray:
    """The rows of springs."""
    return np.stack([springs.height, springs.share, springs.centre, springs.outer, springs.position])


def room_for(body: Body) -> Room:
    """A place to work in."""
    n, k = body.branches.shape[0], body.modes.shape[0]
    return Room(
        np.full(_TRIED + 1, math.nan),
        np.zeros((n, COEFFICIENTS)),
        np.zeros((n, COEFFICIENTS)),
        np.zeros((max(n, k), SQUARES + 1)),
    )


@compiled
def fill(duration: float, branches: FloatArray, branch: FloatArray) -> None:
    """Coefficients of the branches for a duration."""
    for j in range(branches.shape[0]):
        (
            branch[j, DECAY],
            branch[j, MEAN],
            branch[j, RAMP],
            branch[j, OWN],
            branch[j, CROSS],
            branch[j, MOVED],
        ) = moments(duration / branches[j, RELAXING])


@inner
def prepare(body: Body, duration: float, room: Room) -> None:
    """Have the coefficients of a whole step."""
    modes, work = body.modes, room.work
    if room.known[DURATION] != duration:
        fill(duration, body.branches, room.branch)
        for k in range(modes.shape[0]):
            work[k, LEFT] = math.exp(-modes[k, FADING] * duration)
            work[k, TAKEN] = -0.5 * math.expm1(-2.0 * modes[k, FADING] * duration)
        room.known[DURATION] = duration


@inner
def straight(viscosity: float, start: float, end: float, duration: float) -> Move:
    """A way; in no time a dashpot moves nowhere, and the way stands for its load as if its viscosity were that of one second."""
    way = end - start
    sudden = viscosity > 0.0 and duration == 0.0
    drag = viscosity * way / (1.0 if sudden else duration) if viscosity > 0.0 and way != 0.0 else 0.0
    return Move(start, 0.0 if sudden else way, duration, drag)


@inner
def stiffness(body: Body, duration: float, branch: FloatArray) -> float:
    """How the force at the end of a straight move grows with it; of a dashpot in no time as `straight` says."""
    if body.viscosity > 0.0 and duration == 0.0:
        return body.viscosity
    stiff = body.equilibrium + (body.viscosity / duration if body.viscosity > 0.0 else 0.0)
    for j in range(branch.shape[0]):
        stiff += body.branches[j, MODULUS] * branch[j, MEAN]
    return float(stiff)


@inner
def move_branches(
    body: Body, move: float, w: float, part: FloatArray, work: FloatArray
) -> tuple[float, float]:
    """Move the spring at work, in contact; returns its mean force and what its dashpots take, without one in parallel."""
    force, lost, branches = body.equilibrium * (w + 0.5 * move), 0.0, body.branches
    for j in range(branches.shape[0]):
        elastic, h = branches[j, MODULUS] * move, work[j, H]
        force += part[j, MEAN] * h + part[j, RAMP] * elastic
        lost += (
            part[j, OWN] * h * h + elastic * (2.0 * part[j, CROSS] * h + part[j, MOVED] * elastic)
        ) * branches[j, SOFT]
        work[j, H] = part[j, DECAY] * h + part[j, MEAN] * elastic
    return force, lost


@inner
def let_go(body: Body, w: float, work: FloatArray) -> float:
    """Find the modes of the spring at work, which bears nothing; returns where it rests."""
    rest, n, modes = w, body.branches.shape[0], body.modes
    for k in range(modes.shape[0]):
        m = modes[k, INTO + n] * w
        for j in range(n):
            m += modes[k, INTO + j] * work[j, H]
        work[k, M] = m
        rest -= modes[k, REACH] * m
    return rest if body.equilibrium == 0.0 else 0.0


@inner
def take_up(body: Body, work: FloatArray) -> None:
    """Find what the branches of the spring at work bear, which is free."""
    branches = body.branches
    for j in range(branches.shape[0]):
        h = 0.0
        for k in range(body.modes.shape[0]):
            h += branches[j, BACK + k] * work[k, M]
        work[j, H] = h


@inner
def creep_back(body: Body, duration: float, rest: float, work: FloatArray) -> tuple[float, float]:
    """Let the spring at work creep, which is free; returns where it is and what its dashpots take."""
    w, lost, modes = rest, 0.0, body.modes
    for k in range(modes.shape[0]):
        x, m = modes[k, FADING] * duration, work[k, M]
        lost -= 0.5 * math.expm1(-2.0 * x) * m * m
        m *= math.exp(-x)
        work[k, M] = m
        w += modes[k, REACH] * m
    return w, lost


@inner
def relieve(body: Body, w: float, work: FloatArray) -> tuple[float, float]:
    """Let the spring at work move at once to where it bears nothing; returns how far, and the energy that is lost."""
    borne, glassy, branches = body.equilibrium * w, body.equilibrium, body.branches
    for j in range(branches.shape[0]):
        borne += work[j, H]
        glassy += branches[j, MODULUS]
    for j in range(branches.shape[0]):
        work[j, H] -= branches[j, MODULUS] * borne / glassy
    return borne / glassy, 0.5 * borne * borne / glassy


@inner
def fetch(state: FloatArray, i: int, work: FloatArray) -> bool:
    """Take a spring to work on; returns whether it is free."""
    free = state[i, FREE] != 0.0
    for j in range(work.shape[0]):
        work[j, M if free else H] = state[i, BORNE + j]
    return bool(free)


@inner
def store(state: FloatArray, i: int, free: bool, w: float, rest: float, work: FloatArray) -> None:
    """Put the spring at work back."""
    state[i, W], state[i, FREE], state[i, REST] = w, 1.0 if free else 0.0, rest
    for j in range(work.shape[0]):
        state[i, BORNE + j] = work[j, M if free else H]


@inner
def _changes(
    body: Body, move: Move, done: float, free: bool, level: float, work: FloatArray, begin: float
) -> tuple[float, int]:
    """
    At which part of what is left of a step the spring at work changes sides.

    `level` is w of a spring in contact, and how far a free one is above the indentation without its modes.
    """
    left, n = 1.0 - done, body.branches.shape[0]
    way, lasts = move.way * left, move.duration * left
    if free:
        n = body.modes.shape[0]
        for k in range(n):
            work[k, DECAYING], work[k, GROWING] = body.modes[k, REACH] * work[k, M], 0.0
            work[k, RATES] = lasts * body.modes[k, FADING]
    else:
        for j in range(n):
            work[j, DECAYING], work[j, GROWING] = work[j, H], body.branches[j, MODULUS] * way
            work[j, RATES] = lasts / body.branches[j, RELAXING]
    value = level if free else body.equilibrium * level + move.drag
    return first_crossing((value, -way if free else body.equilibrium * way), work, n, begin)


@inner
def _turn(body: Body, move: Move, y: float, i: int, old: FloatArray, new: FloatArray, room: Room) -> bool:
    """
    Move a spring that may change sides; returns whether it is free then, with its branches, or modes, at work.

    `known` takes what its dashpots take, the work and what was tried. What comes within a rounding of a change is no other one:
    for that, the time after each is longer.
    """
    done, lost, worked, turns, tried = 0.0, 0.0, 0.0, 0, 0
    work, branches = room.work, body.branches
    free, w, rest, turn = fetch(old, i, work), old[i, W], old[i, REST], 0.0
    while True:
        begin = 0.0 if turns == 0 else SHORTEST * 2.0 ** min(turns - 1, 39)
        level = rest + y - move.start - done * move.way if free else w
        part, count = _changes(body, move, done, free, level, work, begin)
        tried += count
        left = 1.0 - done
        share = left * min(part, 1.0)
        if free:
            w, spent = creep_back(body, move.duration * share, rest, work)
            lost += spent
        else:
            dw = move.way * share
            fill(move.duration * share, branches, room.part)
            force, spent = move_branches(body, dw, w, room.part, work)
            lost += spent + dw * move.drag
            worked += dw * (force + move.drag)
            w += dw
        if part > 1.0:
            break
        turns += 1
        done += share
        turn = done
        if free:
            there = move.start + done * move.way - y
            take_up(body, work)
            # what the search misses by is moved in no less time than it tells apart: in none, branches that relax faster
            # would take an energy that nobody gives
            missed, within = there - w, max(begin, ROUNDING) * left * move.duration
            for j in range(branches.shape[0]):
                work[j, H] += branches[j, MODULUS] * missed * mean(within / branches[j, RELAXING])
            w = there
        else:  # what rounding leaves it to bear is let go
            if body.viscosity == 0.0:
                w -= relieve(body, w, work)[0]
            rest = let_go(body, w, work)
        free = not free
    if not free:
        w = move.start + move.way - y
    store(new, i, free, w, rest, work)
    new[i, TURN] = turn
    room.known[_LOST], room.known[_WORK], room.known[_TRIED] = lost, worked, tried
    return free


@inner
def _stayed(body: Body, move: Move, room: Room, stays: float) -> tuple[float, float]:
    """The work on springs that stay in contact, but for that on their own springs, and what dashpots take of it."""
    work = lost = move.way * move.drag * stays
    branch, sums = room.branch, room.work
    for j in range(branch.shape[0]):
        elastic, borne = sums[j, ELASTIC], sums[j, LOADED]
        work += move.way * (branch[j, MEAN] * borne + branch[j, RAMP] * elastic * stays)
        lost += body.branches[j, SOFT] * (
            branch[j, OWN] * sums[j, SQUARES]
            + elastic * (2.0 * branch[j, CROSS] * borne + branch[j, MOVED] * elastic * stays)
        )
    return work, lost


@inner
def step(
    springs: FloatArray,
    body: Body,
    move: Move,
    limits: tuple[int, int, bool],
    old: FloatArray,
    new: FloatArray,
    room: Room,
    row: FloatArray,
) -> None:
    """
    Move the springs from the first to before the last of `limits` along a way.

    The third of them says whether the force is that up to the very edge, which jumps where a spring changes sides.
    """
    first, active, cut = limits
    way, drag, end, equilibrium = move.way, move.drag, move.start + move.way, body.equilibrium
    # looked up once: in a loop that counts references
    branch, at_work, branches, modes = room.branch, room.work, body.branches, body.modes
    n = branches.shape[0]
    prepare(body, move.duration, room)
    for j in range(n):
        at_work[j, ELASTIC], at_work[j, LOADED], at_work[j, SQUARES] = branches[j, MODULUS] * way, 0.0, 0.0
    stiff = stiffness(body, move.duration, branch)
    stored, lost, work, force, rate, stays = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    last, count, parts, q_last, q_before = first - 1, 0, 0, 0.0, 0.0
    for i in range(first, active):
        y, share, w = springs[HEIGHT, i], springs[SHARE, i], old[i, W]
        there, free = end - y, old[i, FREE] != 0.0
        q, least, energy = equilibrium * there + drag, min(equilibrium * w, equilibrium * there) + drag, 0.0
        if free:
            rest, faded = old[i, REST], 0.0
            gap, there_free = rest + y - max(move.start, end), rest
            parts += 1
            for k in range(modes.shape[0]):
                before, reach = old[i, BORNE + k], modes[k, REACH]
                after = at_work[k, LEFT] * before
                new[i, BORNE + k] = after
                there_free += reach * after
                gap += min(reach * before, reach * after)
                energy += after * after
                faded += at_work[k, TAKEN] * before * before
            if gap > 0.0:
                new[i, W], new[i, FREE], new[i, REST], new[i, TURN] = there_free, 1.0, rest, 0.0
                lost += share * faded
                stored += 0.5 * share * energy
                continue
            energy = 0.0
        else:
            for j in range(n):
                before = old[i, BORNE + j]
                after = branch[j, DECAY] * before + branch[j, MEAN] * at_work[j, ELASTIC]
                new[i, BORNE + j] = after
                q += after
                least += min(before, after)
        if free or least < 0.0:
            free = _turn(body, move, y, i, old, new, room)
            lost += share * room.known[_LOST]
            work += share * room.known[_WORK]
            parts += int(room.known[_TRIED])
            if free:
                for k in range(modes.shape[0]):
                    stored += 0.5 * share * new[i, BORNE + k] * new[i, BORNE + k]
                continue
            q = equilibrium * there + drag
            for j in range(n):
                q += new[i, BORNE + j]
        else:
            for j in range(n):
                loaded = share * old[i, BORNE + j]
                at_work[j, LOADED] += loaded
                at_work[j, SQUARES] += loaded * old[i, BORNE + j]
            stays += share
            work += share * way * 0.5 * equilibrium * (w + there)
            new[i, W], new[i, FREE], new[i, REST], new[i, TURN] = there, 0.0, old[i, REST], 0.0
            parts += 1
        for j in range(n):
            energy += new[i, BORNE + j] * new[i, BORNE + j] * branches[j, SOFT]
        stored += 0.5 * share * (energy + equilibrium * there * there)
        force += share * q
        last, count, q_before, q_last = i, count + 1, q_last, q
        rate += share * stiff
    last = last if count > 0 else -1
    stayed, taken = _stayed(body, move, room, stays)
    row[STORED], row[LOST], row[WORK], row[RATE] = stored, lost + taken, work + stayed, rate
    row[EDGE_DEPTH], row[LAST], row[COUNT], row[PARTS], row[FORCE] = end, last, count, parts, force
    if 0 <= last < springs.shape[1] - 1:
        short = equilibrium  # what a spring feels that is let go shortly before the end
        for j in range(n):
            short += branches[j, MODULUS] * mean(_SHORTLY * move.duration / branches[j, RELAXING])
        beyond = (
            new[last + 1, W] if last + 1 < active else 0.0,
            new[last + 2, W] if last + 2 < active else 0.0,
        )
        row[EDGE_DEPTH] = _edge(springs, beyond, last, end, q_before, q_last, short, drag)
        if cut or drag != 0.0:  # without, the force is continuous in the indentation
            row[FORCE] += _cut(springs, last, row[EDGE_DEPTH], q_before, q_last, drag)


@inner
def _edge(
    springs: FloatArray,
    beyond: tuple[float, float],
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
    w_here, w_next = beyond
    if w_here == 0.0:
        return float(min(max(depth, inner), y))
    slope, gap = 0.0, w_here + y - depth
    if last + 2 < springs.shape[1] and springs[HEIGHT, last + 2] > y:
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


@inner
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
