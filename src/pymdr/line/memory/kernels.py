"""Compiled steps of springs with memory. Imported only when a history is followed: it loads numba.

A spring in contact keeps the forces h of its Maxwell branches; its deflection w follows the indentation. The update is exact for
straight moves. A free spring keeps the amplitudes of the modes in which it creeps back. Branches and modes are monotone within a
step, so their end values bound the force or the gap of a spring from below, and most springs need no search. For the others the
force and the gap are sums of exponentials, whose first crossing of 0 is found whatever the step.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from pymdr.compiling import Addressed, call, inner, merged, uncounted
from pymdr.line.memory.modes import BRANCHES, FREE, REST, TURN, Modes, W
from pymdr.line.memory.springs import Springs
from pymdr.mapping.relaxation import Relaxation
from pymdr.numerics.exponentials import (
    CROSSED,
    DECAYING,
    GROWING,
    NEVER,
    RATES,
    ROUNDING,
    SHORTEST,
    first_crossing,
    mean,
    moments,
)
from pymdr.units import FloatArray

_SHORTLY = 1e-3
"""Fraction of a step whose mean modulus continues the force of a released spring."""
H, M, MODE_DECAY, MODE_DISSIPATION, ELASTIC, SUM_KH, SUM_KHH, MODULUS, SOFT, RELAXING = range(
    RATES + 1, RATES + 11
)
"""Columns of the table of a body after the terms of a sum. Of the spring at work: h and the amplitudes m; of the modes after a step:
exp(-rate s) and their dissipation; of a step: E dw, sum k h and sum k h^2 over the springs that stay in contact; of the branches:
E, 1/E, tau."""
DECAY, MEAN, RAMP, OWN, CROSS, MOVED = range(RELAXING + 1, RELAXING + 7)
"""Of a branch over a whole step x = s/tau: h -> DECAY h + E MEAN dw; work dw (MEAN h + E RAMP dw); its dissipation in units of
1/E: OWN h^2 + 2 CROSS h E dw + MOVED (E dw)^2."""
PART_DECAY, PART_MEAN, PART_RAMP, PART_OWN, PART_CROSS, PART_MOVED = range(MOVED + 1, MOVED + 7)
"""The same over a part of a step."""
GROUP_DECAY, GROUP_GAIN, LEAST_H, GREATEST_H, SUM_H, SUM_HH = range(PART_MOVED + 1, PART_MOVED + 7)
"""Of the branches of a group: h is FADE times the first h plus GAINED; the lowest and highest first h, sum k h, sum k h^2."""
FIRST_DECAY, FIRST_GAIN, BENT = range(SUM_HH + 1, SUM_HH + 4)
"""Of the branches of a group: the first two before a part of a row; how far h half-way is off the middle, per first h."""
RATE_OF_MODE, PARTICIPATION, BACK = range(BENT + 1, BENT + 4)
"""Of the modes: the rate and the deflection of a unit amplitude; from BACK on what each mode adds to a branch."""
(
    DURATION,
    FIRM,
    _DISSIPATED,
    _WORK,
    _TRIED,
    GROUPED,
    STIFFNESS,
    WIDTH,
    SQUARED,
    LEAST_W,
    GREATEST_W,
    GROUP_MOVE,
    FIRST_MOVE,
) = range(13)
"""Numbers of a body: duration of the step, stiffness of a spring; of the last spring that changed sides the dissipation, work and
intervals tried; of a group the number of its springs, sums of k, k w, k w^2, the least and largest w when formed, and its move since, now and
before a part of a row."""
FORCE, RATE, STORED, DISSIPATED, WORK, EDGE_DEPTH, LAST, COUNT, PARTS, INDENTATION, OWNER, PART = range(12)
"""Columns of a row; RATE is dF/dd, LAST the outermost spring in contact, COUNT the number in contact, PARTS all intervals tried. A
history adds the indentation, the row of a part and the end of the part as a fraction of the row."""
COLUMNS = 12
HEIGHT, DK, CENTRE, OUTER, POSITION = range(5)
"""Rows of the springs: d0, dk, k per unit modulus at the spring and at the outer end of its part, and x."""


class Body(NamedTuple):
    """How a spring relaxes and creeps back. Few arrays of many columns: each array that kernels pass on takes time to compile."""

    equilibrium: float
    viscosity: float
    branches: int
    modes: int
    table: FloatArray
    """One row per branch and per mode."""
    known: FloatArray
    crossing: Any
    changes: Any
    form: Any
    dissolve: Any
    """Addresses of :func:`first_crossing`, :func:`_follow_changes` and those that group springs, 0 where springs are not released."""


class Move(NamedTuple):
    """A straight change of the indentation, and the force of a dashpot on every spring during it."""

    start: float
    change: float
    duration: float
    drag: float


def body_of(relaxation: Relaxation, modes: Modes | None = None) -> Body:
    """A body without a group of springs; without modes its springs cannot be released."""
    from pymdr.line.memory import groups

    n, k = relaxation.moduli.size, 0 if modes is None else modes.rates.size
    size = max(n, k)
    table = np.zeros((size, BACK + size + n + 1))
    table[:n, MODULUS], table[:n, SOFT] = relaxation.moduli, 1.0 / relaxation.moduli
    table[:n, RELAXING] = relaxation.times
    if modes is not None:
        table[:k, RATE_OF_MODE], table[:k, PARTICIPATION] = modes.rates, modes.participation
        table[:n, BACK : BACK + k] = modes.to_branches
        table[:k, BACK + size :] = modes.to_modes
    known = np.zeros(FIRST_MOVE + 1)
    known[DURATION] = math.nan
    body = Body(float(relaxation.equilibrium), float(relaxation.viscosity), n, k, table, known, 0, 0, 0, 0)
    if modes is None:
        return body
    crossing = first_crossing.address(CROSSED, (0.0, 0.0), table, 0, 0.0)
    changes = _follow_changes.address(False, body, Move(0.0, 0.0, 0.0, 0.0), 0.0, 0, table, table)
    form = groups.form_group.address(None, table, 0, table, table, body)
    dissolve = groups.dissolve_group.address(None, table, body)
    return body._replace(crossing=crossing, changes=changes, form=form, dissolve=dissolve)


def table_of(springs: Springs) -> FloatArray:
    """The rows of springs."""
    return np.stack([springs.height, springs.stiffness, springs.centre, springs.outer, springs.position])


@uncounted
def fill(duration: float, body: Body) -> None:
    """Compute the coefficients of the branches for a part of a step."""
    table = body.table
    for j in range(body.branches):
        (
            table[j, PART_DECAY],
            table[j, PART_MEAN],
            table[j, PART_RAMP],
            table[j, PART_OWN],
            table[j, PART_CROSS],
            table[j, PART_MOVED],
        ) = moments(duration / table[j, RELAXING])


@inner
def stiffness(body: Body, duration: float) -> float:
    """Derivative of the force after a straight move by the move over a part of a step."""
    if body.viscosity > 0.0 and duration == 0.0:
        return body.viscosity
    stiff = body.equilibrium + (body.viscosity / duration if body.viscosity > 0.0 else 0.0)
    for j in range(body.branches):
        stiff += body.table[j, MODULUS] * body.table[j, PART_MEAN]
    return float(stiff)


@inner
def prepare(body: Body, duration: float) -> None:
    """Compute the coefficients of a whole step."""
    table, known = body.table, body.known
    if known[DURATION] != duration:
        fill(duration, body)
        known[DURATION], known[FIRM] = duration, stiffness(body, duration)
        for j in range(body.branches):
            for c in range(DECAY, PART_DECAY):
                table[j, c] = table[j, PART_DECAY - DECAY + c]
        for k in range(body.modes):
            x = table[k, RATE_OF_MODE] * duration
            table[k, MODE_DECAY] = math.exp(-x)
            table[k, MODE_DISSIPATION] = -0.5 * math.expm1(-2.0 * x)


@inner
def straight(viscosity: float, start: float, end: float, duration: float) -> Move:
    """A straight move. In zero time a dashpot does not move; its load is then that of a viscosity over one second."""
    change = end - start
    sudden = viscosity > 0.0 and duration == 0.0
    drag = viscosity * change / (1.0 if sudden else duration) if viscosity > 0.0 and change != 0.0 else 0.0
    return Move(start, 0.0 if sudden else change, duration, drag)


@inner
def move_branches(body: Body, move: float, w: float) -> tuple[float, float]:
    """Move the spring at work in contact over a part of a step; its mean force and dissipation without a parallel dashpot."""
    table = body.table
    force, dissipated = body.equilibrium * (w + 0.5 * move), 0.0
    for j in range(body.branches):
        elastic, h = table[j, MODULUS] * move, table[j, H]
        force += table[j, PART_MEAN] * h + table[j, PART_RAMP] * elastic
        crossed = elastic * (2.0 * table[j, PART_CROSS] * h + table[j, PART_MOVED] * elastic)
        dissipated += (table[j, PART_OWN] * h * h + crossed) * table[j, SOFT]
        table[j, H] = table[j, PART_DECAY] * h + table[j, PART_MEAN] * elastic
    return force, dissipated


@inner
def to_modes(body: Body, w: float) -> float:
    """Convert the branches of the spring at work, whose force is 0, to modes; returns its rest position."""
    table, rest, n = body.table, w, body.branches
    into = BACK + table.shape[0]
    for k in range(body.modes):
        m = table[k, into + n] * w
        for j in range(n):
            m += table[k, into + j] * table[j, H]
        table[k, M] = m
        rest -= table[k, PARTICIPATION] * m
    return rest if body.equilibrium == 0.0 else 0.0


@inner
def to_branches(body: Body) -> None:
    """Convert the modes of the spring at work to branches."""
    table = body.table
    for j in range(body.branches):
        h = 0.0
        for k in range(body.modes):
            h += table[j, BACK + k] * table[k, M]
        table[j, H] = h


@inner
def recover(body: Body, duration: float, rest: float) -> tuple[float, float]:
    """Let the free spring at work creep; returns its position and dissipation."""
    table, w, dissipated = body.table, rest, 0.0
    for k in range(body.modes):
        x, m = table[k, RATE_OF_MODE] * duration, table[k, M]
        dissipated -= 0.5 * math.expm1(-2.0 * x) * m * m
        m *= math.exp(-x)
        table[k, M] = m
        w += table[k, PARTICIPATION] * m
    return w, dissipated


@inner
def unload(body: Body, w: float) -> tuple[float, float]:
    """Move the spring at work at once to zero force; returns the distance and the energy lost."""
    table, borne, glassy = body.table, body.equilibrium * w, body.equilibrium
    for j in range(body.branches):
        borne += table[j, H]
        glassy += table[j, MODULUS]
    for j in range(body.branches):
        table[j, H] -= table[j, MODULUS] * borne / glassy
    return borne / glassy, 0.5 * borne * borne / glassy


@inner
def load_spring(state: FloatArray, i: int, body: Body) -> bool:
    """Take a spring to work on; returns whether it is free."""
    free = state[i, FREE] != 0.0
    column = M if free else H
    for j in range(body.table.shape[0]):
        body.table[j, column] = state[i, BRANCHES + j]
    return bool(free)


@inner
def store_spring(state: FloatArray, i: int, free: bool, w: float, rest: float, body: Body) -> None:
    """Put the spring at work back."""
    state[i, W], state[i, FREE], state[i, REST] = w, 1.0 if free else 0.0, rest
    column = M if free else H
    for j in range(body.table.shape[0]):
        state[i, BRANCHES + j] = body.table[j, column]


@merged
def _next_change(
    body: Body, move: Move, done: float, free: bool, level: float, start: float
) -> tuple[float, int]:
    """
    Fraction of the rest of a step at which the spring at work changes sides.

    `level` is w of a spring in contact, and the distance of a free one above the indentation without its modes.
    """
    left, n, table = 1.0 - done, body.branches, body.table
    change, duration = move.change * left, move.duration * left
    if free:
        n = body.modes
        for k in range(n):
            table[k, DECAYING], table[k, GROWING] = table[k, PARTICIPATION] * table[k, M], 0.0
            table[k, RATES] = duration * table[k, RATE_OF_MODE]
    else:
        for j in range(n):
            table[j, DECAYING], table[j, GROWING] = table[j, H], table[j, MODULUS] * change
            table[j, RATES] = duration / table[j, RELAXING]
    value = level if free else body.equilibrium * level + move.drag
    line = value, -change if free else body.equilibrium * change
    part, tried = call(body.crossing, CROSSED, (line, table, n, start))
    return part, tried


@Addressed
def _follow_changes(body: Body, move: Move, y: float, i: int, old: FloatArray, new: FloatArray) -> bool:
    """
    Move a spring that may change sides; returns whether it is free then, with its branches, or modes, at work.

    `known` takes its dissipation, the work and the intervals tried. A crossing within rounding of a change is not another one:
    the search after each change starts later, and about a hundred changes end the step.
    """
    done, dissipated, worked, turns, tried = 0.0, 0.0, 0.0, 0, 0
    table, known = body.table, body.known
    free, w, rest, turn = load_spring(old, i, body), old[i, W], old[i, REST], 0.0
    while True:
        start = 0.0 if turns == 0 else SHORTEST * 2.0 ** min(turns - 1, 39)
        level = rest + y - move.start - done * move.change if free else w
        left, part = 1.0 - done, NEVER
        # with a dashpot a free spring touches nothing in no time: a gap below 0 is the rounding of its modes
        if left > 0.0 and not (free and move.duration == 0.0 and body.viscosity > 0.0):
            part, count = _next_change(body, move, done, free, level, start)
            tried += count
        fraction = left * min(part, 1.0)
        if free:
            w, spent = recover(body, move.duration * fraction, rest)
            dissipated += spent
        else:
            dw = move.change * fraction
            fill(move.duration * fraction, body)
            force, spent = move_branches(body, dw, w)
            dissipated += spent + dw * move.drag
            worked += dw * (force + move.drag)
            w += dw
        if part > 1.0:
            break
        turns += 1
        done += fraction
        turn = done
        if free:
            there = move.start + done * move.change - y
            to_branches(body)
            # the search error is moved within the time resolution of the search: in zero time, branches that relax faster
            # would absorb an energy that nothing supplies
            missed, within = there - w, max(start, ROUNDING) * left * move.duration
            for j in range(body.branches):
                table[j, H] += table[j, MODULUS] * missed * mean(within / table[j, RELAXING])
            w = there
        else:  # the force left by rounding is released
            if body.viscosity == 0.0:
                w -= unload(body, w)[0]
            rest = to_modes(body, w)
        free = not free
    if not free:
        w = move.start + move.change - y
    store_spring(new, i, free, w, rest, body)
    new[i, TURN] = turn
    known[_DISSIPATED], known[_WORK], known[_TRIED] = dissipated, worked, tried
    return free


@inner
def _work_in_contact(body: Body, move: Move, stays: float) -> tuple[float, float]:
    """Work on springs that stay in contact, except that on their own equilibrium springs, and its dissipated part."""
    work = dissipated = move.change * move.drag * stays
    table = body.table
    for j in range(body.branches):
        elastic, borne = table[j, ELASTIC], table[j, SUM_KH]
        work += move.change * (table[j, MEAN] * borne + table[j, RAMP] * elastic * stays)
        crossed = elastic * (2.0 * table[j, CROSS] * borne + table[j, MOVED] * elastic * stays)
        dissipated += table[j, SOFT] * (table[j, OWN] * table[j, SUM_KHH] + crossed)
    return work, dissipated


@Addressed
def step(
    springs: FloatArray,
    body: Body,
    move: Move,
    limits: tuple[int, int, float],
    old: FloatArray,
    new: FloatArray,
    row: FloatArray,
) -> None:
    """
    Move the springs limits[0] <= i < limits[1].

    Unless limits[2] is 0, the force is integrated up to the edge, where it jumps as a spring changes sides.
    """
    first, active, cut = limits
    change, drag, end, equilibrium = move.change, move.drag, move.start + move.change, body.equilibrium
    table, n, modes = body.table, body.branches, body.modes
    prepare(body, move.duration)
    for j in range(n):
        table[j, ELASTIC], table[j, SUM_KH], table[j, SUM_KHH] = table[j, MODULUS] * change, 0.0, 0.0
    stiff = body.known[FIRM]
    stored, dissipated, work, force, rate, stays = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    last, count, parts, q_last, q_before = first - 1, 0, 0, 0.0, 0.0
    for i in range(first, active):
        y, dk, w = springs[HEIGHT, i], springs[DK, i], old[i, W]
        there, free = end - y, old[i, FREE] != 0.0
        q, least, energy = equilibrium * there + drag, min(equilibrium * w, equilibrium * there) + drag, 0.0
        if free:
            rest, faded = old[i, REST], 0.0
            gap, there_free = rest + y - max(move.start, end), rest
            parts += 1
            for k in range(modes):
                before, participation = old[i, BRANCHES + k], table[k, PARTICIPATION]
                after = table[k, MODE_DECAY] * before
                new[i, BRANCHES + k] = after
                there_free += participation * after
                gap += min(participation * before, participation * after)
                energy += after * after
                faded += table[k, MODE_DISSIPATION] * before * before
            if gap > 0.0:
                new[i, W], new[i, FREE], new[i, REST], new[i, TURN] = there_free, 1.0, rest, 0.0
                dissipated += dk * faded
                stored += 0.5 * dk * energy
                continue
            energy = 0.0
        else:
            for j in range(n):
                before = old[i, BRANCHES + j]
                after = table[j, DECAY] * before + table[j, MEAN] * table[j, ELASTIC]
                new[i, BRANCHES + j] = after
                q += after
                least += min(before, after)
        if free or least < 0.0:
            free = call(body.changes, False, (body, move, y, i, old, new))
            dissipated += dk * body.known[_DISSIPATED]
            work += dk * body.known[_WORK]
            parts += int(body.known[_TRIED])
            if free:
                for k in range(modes):
                    stored += 0.5 * dk * new[i, BRANCHES + k] * new[i, BRANCHES + k]
                continue
            q = equilibrium * there + drag
            for j in range(n):
                q += new[i, BRANCHES + j]
        else:
            for j in range(n):
                loaded = dk * old[i, BRANCHES + j]
                table[j, SUM_KH] += loaded
                table[j, SUM_KHH] += loaded * old[i, BRANCHES + j]
            stays += dk
            work += dk * change * 0.5 * equilibrium * (w + there)
            new[i, W], new[i, FREE], new[i, REST], new[i, TURN] = there, 0.0, old[i, REST], 0.0
            parts += 1
        for j in range(n):
            energy += new[i, BRANCHES + j] * new[i, BRANCHES + j] * table[j, SOFT]
        stored += 0.5 * dk * (energy + equilibrium * there * there)
        force += dk * q
        last, count, q_before, q_last = i, count + 1, q_last, q
        rate += dk * stiff
    last = last if count > 0 else -1
    stayed, taken = _work_in_contact(body, move, stays)
    row[STORED], row[DISSIPATED], row[WORK], row[RATE] = stored, dissipated + taken, work + stayed, rate
    row[EDGE_DEPTH], row[LAST], row[COUNT], row[PARTS], row[FORCE] = end, last, count, parts, force
    if 0 <= last < springs.shape[1] - 1:
        short = equilibrium  # modulus of a spring released shortly before the end
        for j in range(n):
            short += table[j, MODULUS] * mean(_SHORTLY * move.duration / table[j, RELAXING])
        beyond = new[last + 1, W] if last + 1 < active else 0.0
        after = new[last + 2, W] if last + 2 < active else 0.0
        row[EDGE_DEPTH] = _edge_depth(springs, last, end, (beyond, after), (q_before, q_last, short, drag))
        if cut != 0.0 or drag != 0.0:  # without, the force is continuous in the indentation
            row[FORCE] += _force_up_to_edge(springs, last, row[EDGE_DEPTH], q_before, q_last, drag)


@inner
def _edge_depth(
    springs: FloatArray,
    last: int,
    depth: float,
    beyond: tuple[float, float],
    forces: tuple[float, float, float, float],
) -> float:
    """
    The d0 of the edge, between the last spring in contact and the first free one.

    `beyond` are w of the next two springs, `forces` those of the last two in contact, the modulus of a released one and that of
    the dashpot. The median of three estimates of second order: the gap of the free springs extrapolated inward, the force
    extrapolated outward, and the trial force between both. A bend of w or q spoils at most one. With a dashpot, whose force jumps
    at the edge, the first.
    """
    q_before, q_last, stiff, drag = forces
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
def _force_up_to_edge(
    springs: FloatArray, last: int, edge: float, q_before: float, q_last: float, drag: float
) -> float:
    """Correction of the sum of forces to int q dk up to the edge, by trapezia beyond the last but one part."""
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
        - q_last * springs[DK, last]
    )
