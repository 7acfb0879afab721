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
from pymdr.line.memory.modes import Modes
from pymdr.line.memory.springs import Springs
from pymdr.mapping.relaxation import Relaxation
from pymdr.numerics.exponentials import ROUNDING, SHORTEST, Sum, empty_sum, first_crossing, mean, moments
from pymdr.units import FloatArray

_SHORTLY = 1e-3
"""Of a step: the time that tells the modulus by which the force of a spring that is let go is continued."""
DECAY, MEAN, RAMP, OWN, CROSS, MOVED = range(6)
"""Of a branch over a step x = s/tau, h -> DECAY h + E MEAN dw; work dw (MEAN h + E RAMP dw); its dissipation in units of
1/E: OWN h^2 + 2 CROSS h E dw + MOVED (E dw)^2."""
FORCE, RATE, STORED, LOST, WORK, EDGE_DEPTH, LAST, COUNT, PARTS = range(9)
"""Columns of a row; RATE is dF/dd, LAST the outermost spring in contact, COUNT how many are, PARTS what was tried of all."""
COLUMNS = 9
HEIGHT, SHARE, CENTRE, OUTER, POSITION = range(5)
"""Rows of the springs: d0, dk, k per unit modulus at the spring and at the outer end of its part, and x."""
FREE, REST, TURN = range(3)
"""Rows of the sides of springs: 1 where one is free, then w less its modes, and at which part of a step it last changed sides."""
_SPRING, _LOST, _WORK, _TRIED = 3, 0, 1, 2
"""Of what is told of a spring."""


class Body(NamedTuple):
    """How a spring relaxes and creeps back."""

    equilibrium: float
    viscosity: float
    moduli: FloatArray
    soft: FloatArray
    """Their inverses."""
    times: FloatArray
    rates: FloatArray
    reach: FloatArray
    to_modes: FloatArray
    to_branches: FloatArray


class State(NamedTuple):
    """Of all springs: w; the forces of branches, or the amplitudes of modes of free ones; and the rows FREE, REST, TURN."""

    w: FloatArray
    z: FloatArray
    free: FloatArray

    def alike(self) -> State:
        """A state of as many springs."""
        return State(np.zeros_like(self.w), np.zeros_like(self.z), np.zeros_like(self.free))


class Move(NamedTuple):
    """A straight way from one indentation to another, with what a dashpot adds to every spring on it."""

    start: float
    way: float
    duration: float
    drag: float


class Room(NamedTuple):
    """Coefficients of a whole step and of a part of one, and where springs that change sides are worked on."""

    known: FloatArray
    """(2,) the duration of the whole step, and the stiffness of a spring in it."""
    branch: FloatArray
    mode: FloatArray
    part: FloatArray
    h: FloatArray
    m: FloatArray
    force: Sum
    gap: Sum
    spring: FloatArray
    sums: FloatArray


def body_of(relaxation: Relaxation, modes: Modes) -> Body:
    """What kernels ask of a body; copies, since numba compiles once more for arrays that cannot be written."""
    moduli, times = relaxation.moduli.copy(), relaxation.times.copy()
    return Body(
        float(relaxation.equilibrium), float(relaxation.viscosity), moduli, 1.0 / moduli, times, *modes
    )


def table_of(springs: Springs) -> FloatArray:
    """The rows of springs."""
    return np.stack([springs.height, springs.share, springs.centre, springs.outer, springs.position])


def room_for(body: Body) -> Room:
    """A place to work in."""
    n, k = body.moduli.size, body.rates.size
    return Room(
        np.full(2, math.nan),
        np.zeros((n, 6)),
        np.zeros((k, 2)),
        np.zeros((n, 6)),
        np.zeros(n),
        np.zeros(k),
        empty_sum(n),
        empty_sum(k),
        np.zeros(_SPRING),
        np.zeros((3, n)),
    )


@compiled
def fill(duration: float, times: FloatArray, branch: FloatArray) -> None:
    """Coefficients of the branches for a duration."""
    for j in range(times.size):
        (
            branch[j, DECAY],
            branch[j, MEAN],
            branch[j, RAMP],
            branch[j, OWN],
            branch[j, CROSS],
            branch[j, MOVED],
        ) = moments(duration / times[j])


@inner
def fade(duration: float, rates: FloatArray, mode: FloatArray) -> None:
    """What is left of the modes after a duration, and what their dashpots take."""
    for k in range(rates.size):
        mode[k, 0] = math.exp(-rates[k] * duration)
        mode[k, 1] = -0.5 * math.expm1(-2.0 * rates[k] * duration)


@inner
def prepare(body: Body, duration: float, room: Room) -> None:
    """Have the coefficients of a whole step."""
    if room.known[0] != duration:
        fill(duration, body.times, room.branch)
        fade(duration, body.rates, room.mode)
        room.known[0] = duration


@inner
def straight(body: Body, start: float, end: float, duration: float) -> Move:
    """A way; in no time a dashpot moves nowhere, and the way stands for its load as if its viscosity were that of one second."""
    way = end - start
    sudden = body.viscosity > 0.0 and duration == 0.0
    drag = (
        body.viscosity * way / (1.0 if sudden else duration) if body.viscosity > 0.0 and way != 0.0 else 0.0
    )
    return Move(start, 0.0 if sudden else way, duration, drag)


@inner
def stiffness(body: Body, duration: float, branch: FloatArray) -> float:
    """How the force at the end of a straight move grows with it; of a dashpot in no time as `straight` says."""
    if body.viscosity > 0.0 and duration == 0.0:
        return body.viscosity
    stiff = body.equilibrium + (body.viscosity / duration if body.viscosity > 0.0 else 0.0)
    for j in range(body.moduli.size):
        stiff += body.moduli[j] * branch[j, MEAN]
    return float(stiff)


@inner
def move_branches(
    body: Body, move: float, w: float, branch: FloatArray, h: FloatArray
) -> tuple[float, float]:
    """Move a spring in contact; returns its mean force and what its dashpots take, without the one beside it."""
    force, lost, moduli, soft = body.equilibrium * (w + 0.5 * move), 0.0, body.moduli, body.soft
    for j in range(h.size):
        elastic = moduli[j] * move
        force += branch[j, MEAN] * h[j] + branch[j, RAMP] * elastic
        lost += (
            branch[j, OWN] * h[j] * h[j]
            + elastic * (2.0 * branch[j, CROSS] * h[j] + branch[j, MOVED] * elastic)
        ) * soft[j]
        h[j] = branch[j, DECAY] * h[j] + branch[j, MEAN] * elastic
    return force, lost


@inner
def let_go(body: Body, w: float, h: FloatArray, m: FloatArray) -> float:
    """Find the modes of a spring that bears nothing; returns where it rests."""
    rest, n, to_modes, reach = w, h.size, body.to_modes, body.reach
    for k in range(m.size):
        m[k] = to_modes[k, n] * w
        for j in range(n):
            m[k] += to_modes[k, j] * h[j]
        rest -= reach[k] * m[k]
    return rest if body.equilibrium == 0.0 else 0.0


@inner
def branches_of(body: Body, m: FloatArray, h: FloatArray) -> None:
    """Find what the branches of a free spring bear."""
    to_branches = body.to_branches
    for j in range(h.size):
        h[j] = 0.0
        for k in range(m.size):
            h[j] += to_branches[j, k] * m[k]


@inner
def creep_back(body: Body, duration: float, rest: float, m: FloatArray) -> tuple[float, float]:
    """Let a free spring creep; returns where it is and what its dashpots take."""
    w, lost, rates, reach = rest, 0.0, body.rates, body.reach
    for k in range(m.size):
        x = rates[k] * duration
        lost -= 0.5 * math.expm1(-2.0 * x) * m[k] * m[k]
        m[k] *= math.exp(-x)
        w += reach[k] * m[k]
    return w, lost


@inner
def _parts(body: Body, move: Move, done: float, w: float, room: Room, begin: float) -> tuple[float, int]:
    """At which part of what is left of a step a spring in contact parts."""
    left, f = 1.0 - done, room.force
    (line, decaying, growing, rates, _), h, moduli, times = f, room.h, body.moduli, body.times
    line[0], line[1] = body.equilibrium * w + move.drag, body.equilibrium * move.way * left
    for j in range(h.size):
        decaying[j], growing[j] = h[j], moduli[j] * move.way * left
        rates[j] = move.duration * left / times[j]
    return first_crossing(f, begin)


@inner
def _touches(
    body: Body, move: Move, done: float, above: float, room: Room, begin: float
) -> tuple[float, int]:
    """At which part of what is left of a step a free spring is touched that is so far above the indentation without its modes."""
    left, f = 1.0 - done, room.gap
    (line, decaying, _, rates, _), m, reach, slow = f, room.m, body.reach, body.rates
    line[0], line[1] = above, -move.way * left
    for k in range(m.size):
        decaying[k], rates[k] = reach[k] * m[k], move.duration * left * slow[k]
    return first_crossing(f, begin)


@inner
def _turn(body: Body, move: Move, y: float, i: int, old: State, new: State, room: Room) -> bool:
    """
    Move a spring that may change sides; returns whether it is free then, with its branches, or modes, in `room`.

    `room.spring` takes what its dashpots take, the work and what was tried. What comes within a rounding of a change is no other
    one: for that, the time after each is longer.
    """
    done, lost, work, turns, tried = 0.0, 0.0, 0.0, 0, 0
    free, w, rest, turn = old.free[FREE, i] != 0.0, old.w[i], old.free[REST, i], 0.0
    h, m = room.h, room.m
    for j in range(h.size if not free else m.size):
        if free:
            m[j] = old.z[i, j]
        else:
            h[j] = old.z[i, j]
    while True:
        begin = 0.0 if turns == 0 else SHORTEST * 2.0 ** min(turns - 1, 39)
        if free:
            part, count = _touches(body, move, done, rest + y - move.start - done * move.way, room, begin)
        else:
            part, count = _parts(body, move, done, w, room, begin)
        tried += count
        left = 1.0 - done
        share = left * min(part, 1.0)
        if free:
            w, spent = creep_back(body, move.duration * share, rest, m)
            lost += spent
        else:
            dw = move.way * share
            fill(move.duration * share, body.times, room.part)
            force, spent = move_branches(body, dw, w, room.part, h)
            lost += spent + dw * move.drag
            work += dw * (force + move.drag)
            w += dw
        if part > 1.0:
            break
        turns += 1
        done += share
        turn = done
        if free:
            there = move.start + done * move.way - y
            branches_of(body, m, h)
            # what the search misses by is moved in no less time than it tells apart: in none, branches that relax faster
            # would take an energy that nobody gives
            missed, within = there - w, max(begin, ROUNDING) * left * move.duration
            for j in range(h.size):
                h[j] += body.moduli[j] * missed * mean(within / body.times[j])
            w = there
        else:  # what rounding leaves it to bear is let go
            if body.viscosity == 0.0:
                borne, glassy = body.equilibrium * w, body.equilibrium
                for j in range(h.size):
                    borne += h[j]
                    glassy += body.moduli[j]
                w -= borne / glassy
                for j in range(h.size):
                    h[j] -= body.moduli[j] * borne / glassy
            rest = let_go(body, w, h, m)
        free = not free
    if not free:
        w = move.start + move.way - y
    new.w[i], new.free[FREE, i], new.free[REST, i], new.free[TURN, i] = w, 1.0 if free else 0.0, rest, turn
    for j in range(m.size if free else h.size):
        new.z[i, j] = m[j] if free else h[j]
    room.spring[_LOST], room.spring[_WORK], room.spring[_TRIED] = lost, work, tried
    return bool(free)


@inner
def _stayed(
    body: Body, move: Move, branch: FloatArray, sums: FloatArray, stays: float
) -> tuple[float, float]:
    """The work on springs that stay in contact, but for that on their own springs, and what dashpots take of it."""
    work = lost = move.way * move.drag * stays
    for j in range(body.times.size):
        elastic, borne = sums[0, j], sums[1, j]
        work += move.way * (branch[j, MEAN] * borne + branch[j, RAMP] * elastic * stays)
        lost += body.soft[j] * (
            branch[j, OWN] * sums[2, j]
            + elastic * (2.0 * branch[j, CROSS] * borne + branch[j, MOVED] * elastic * stays)
        )
    return work, lost


@inner
def step(
    springs: FloatArray,
    body: Body,
    move: Move,
    limits: tuple[int, int, bool],
    old: State,
    new: State,
    room: Room,
    row: FloatArray,
) -> None:
    """
    Move the springs from the first to before the last of `limits` along a way.

    The third of them says whether the force is that up to the very edge, which jumps where a spring changes sides.
    """
    first, active, cut = limits
    soft, branch, equilibrium = body.soft, room.branch, body.equilibrium
    way, drag, end, n = move.way, move.drag, move.start + move.way, body.times.size
    # looked up once: in a loop that counts references
    (w_old, z_old, free_old), (w_new, z_new, free_new), mode, reach = old, new, room.mode, body.reach
    prepare(body, move.duration, room)
    sums = (
        room.sums
    )  # moduli times the way, and of springs that stay in contact what they bear before, and its square
    for j in range(n):
        sums[0, j], sums[1, j], sums[2, j] = body.moduli[j] * way, 0.0, 0.0
    stiff = stiffness(body, move.duration, branch)
    stored, lost, work, force, rate, stays = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    last, count, parts, q_last, q_before = -1, 0, 0, 0.0, 0.0
    for i in range(first, active):
        y, share, w = springs[HEIGHT, i], springs[SHARE, i], w_old[i]
        there, free = end - y, free_old[FREE, i] != 0.0
        q, least, energy = equilibrium * there + drag, min(equilibrium * w, equilibrium * there) + drag, 0.0
        if free:
            gap, there_free, faded = free_old[REST, i] + y - max(move.start, end), free_old[REST, i], 0.0
            parts += 1
            for k in range(reach.size):
                before = z_old[i, k]
                after = mode[k, 0] * before
                z_new[i, k] = after
                there_free += reach[k] * after
                gap += min(reach[k] * before, reach[k] * after)
                energy += after * after
                faded += mode[k, 1] * before * before
            if gap > 0.0:
                w_new[i], free_new[FREE, i] = there_free, 1.0
                free_new[REST, i], free_new[TURN, i] = free_old[REST, i], 0.0
                lost += share * faded
                stored += 0.5 * share * energy
                continue
            energy = 0.0
        else:
            for j in range(n):
                after = branch[j, DECAY] * z_old[i, j] + branch[j, MEAN] * sums[0, j]
                z_new[i, j] = after
                q += after
                least += min(z_old[i, j], after)
        if free or least < 0.0:
            free = _turn(body, move, y, i, old, new, room)
            lost += share * room.spring[_LOST]
            work += share * room.spring[_WORK]
            parts += int(room.spring[_TRIED])
            if free:
                for k in range(reach.size):
                    stored += 0.5 * share * z_new[i, k] * z_new[i, k]
                continue
            q = equilibrium * there + drag
            for j in range(n):
                q += z_new[i, j]
        else:
            for j in range(n):  # a sum keeps the compiler from short vectors, which take longer
                loaded = share * z_old[i, j]
                sums[1, j] += loaded
                sums[2, j] += loaded * z_old[i, j]
            stays += share
            work += share * way * 0.5 * equilibrium * (w + there)
            w_new[i], free_new[FREE, i], free_new[REST, i], free_new[TURN, i] = (
                there,
                0.0,
                free_old[REST, i],
                0.0,
            )
            parts += 1
        for j in range(n):
            energy += z_new[i, j] * z_new[i, j] * soft[j]
        stored += 0.5 * share * (energy + equilibrium * there * there)
        force += share * q
        last, count, q_before, q_last = i, count + 1, q_last, q
        rate += share * stiff
    stayed, taken = _stayed(body, move, branch, sums, stays)
    row[STORED], row[LOST], row[WORK], row[RATE], row[EDGE_DEPTH] = (
        stored,
        lost + taken,
        work + stayed,
        rate,
        end,
    )
    row[LAST], row[COUNT], row[PARTS], row[FORCE] = last, count, parts, force
    if 0 <= last < springs.shape[1] - 1:
        short = equilibrium  # what a spring feels that is let go shortly before the end
        for j in range(n):
            short += body.moduli[j] * mean(_SHORTLY * move.duration / body.times[j])
        beyond = w_new[last + 1] if last + 1 < active else 0.0, w_new[last + 2] if last + 2 < active else 0.0
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
