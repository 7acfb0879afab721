"""One approach and one retreat without springs, and growing contacts under force."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import PathError
from pymdr.line.curves import Curve
from pymdr.line.foundation import DiskStates, normal_force, states_at_depth, states_at_force
from pymdr.line.memory.modes import modes_of
from pymdr.mapping.relaxation import Relaxation
from pymdr.units import FloatArray

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_HALVINGS = 60
_ROUNDING = 1e-12
_NEAR = 1e-3
_ROUNDED = 2.0**-50
"""Largest duration of a row, over a relaxation time, that counts as sudden."""


class Rows(NamedTuple):
    """One entry per row."""

    indentation: FloatArray
    """d in m."""
    force: FloatArray
    """F in N."""
    contact_radius: FloatArray
    """a in m; 0 without contact."""
    gained: FloatArray
    """Relative error of the force, or the indentation, over a small relative error of the kernel."""
    widened: FloatArray
    """Relative error of the contact radius over that of the kernel."""


def ting(curve: Curve, relaxation: Relaxation, time: ArrayLike, depth: ArrayLike) -> Rows:
    """
    One approach and one retreat: F(t) = int_0^t1 E*(t - s) dF0(d(s)), a = a(t1), int_t1^t E*(t - s) dd(s) = 0.

    t1 = t as long as the contact does not shrink. By quadrature over indentations that are straight in time between the
    rows, with the exponentials of every term carried from row to row.

    Parameters
    ----------
    curve : Curve
        Per unit modulus. Its d0 has to rise.
    relaxation : Relaxation
        E*(t).
    time, depth : array_like, shape (m,)
        t in s, not falling, and d in m: from the first above 0 not falling up to the largest, and not rising after it down to
        the last above 0. The bodies just touch, or are apart, before the first row; a row at the time of the one before is a
        sudden move.

    Raises
    ------
    PathError
        If there is more than one approach and one retreat, the contact grows again, or a dashpot is moved suddenly.

    Notes
    -----
    Lee and Radok (1960); Ting (1966); Argatov and Popov (2016).

    Examples
    --------
    >>> from pymdr.line.curves import ElasticLine
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> line = ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0)
    >>> solid = Relaxation(1.2, np.array([4.0]), np.array([0.4]))
    >>> ting(line, solid, [0.0, 1.0, 1.1], [0.0, 0.4, 0.36]).force.round(6).tolist()
    [0.0, 1.006835, 0.641077]
    """
    t, given = _rows_of(time, depth, "indentations")
    t, d = np.concatenate([t[:1], t]), _straightened(np.concatenate([[min(0.0, given[0])], given]))
    waits, moves = np.diff(t), np.diff(d)
    top = int(np.argmax(d))
    if waits.min() < 0.0:
        raise PathError(
            f"the time of row {int(np.argmin(waits))} is before that of the preceding row: times must not decrease; sort the rows"
        )
    if (moves[:top] < 0.0).any() or (moves[top:] > 0.0).any():
        raise PathError(
            "the indentation turns more than once: this form covers one approach and one retraction only; use springs"
        )
    if relaxation.viscosity > 0.0 and ((waits == 0.0) & (moves != 0.0) & (d[1:] > 0.0)).any():
        raise PathError(
            "the indentation changes in zero time, for which a dashpot needs an infinite force: give the move a duration"
        )
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = np.where(moves == 0.0, 0.0, moves / waits)
    decay = np.exp(-waits[:, None] / relaxation.times)
    pushed = _pushed(waits, moves, relaxation.times)
    path = _recursed(decay, pushed)
    rise = slice(0, top)
    forces = _recursed(
        decay[rise], _convolved(curve, relaxation.times, t[:top], t[1 : top + 1], d[:top], d[1 : top + 1])
    )
    force = np.zeros(d.size)
    elastic = states_at_depth(curve, d[: top + 1])
    force[: top + 1] = relaxation.equilibrium * normal_force(curve, elastic) + forces @ relaxation.moduli
    if relaxation.viscosity > 0.0:
        force[1 : top + 1] += relaxation.viscosity * speed[:top] * curve.stiffness(elastic.place)[1:]
    radius = np.zeros(d.size)
    radius[: top + 1] = elastic.contact_radius
    gained, widened = np.ones(d.size), np.zeros(d.size)
    later = np.arange(top + 1, d.size)
    if later.size:
        row, fraction = _edge_rows(relaxation, t, d, path, speed, top, later)
        dissipated = row < 0
        row, fraction, kept = row[~dissipated], fraction[~dissipated], later[~dissipated]
        start, end = t[row], t[row] + fraction * waits[row]
        d_end = d[row] + fraction * moves[row]
        relaxed = np.exp(-(end - start)[:, None] / relaxation.times) * forces[row]
        carried = relaxed + _convolved(curve, relaxation.times, start, end, d[row], d_end)
        at_edge = states_at_depth(curve, d_end)
        rest = np.exp(-(t[kept] - end)[:, None] / relaxation.times)
        force[kept] = (
            relaxation.equilibrium * normal_force(curve, at_edge) + (rest * carried) @ relaxation.moduli
        )
        radius[kept] = at_edge.contact_radius
        # the springs between t1 and now bear nothing, by two moves that cancel: each errs by a part of its own size
        back = _recursed(decay[top:], -pushed[top:]) @ relaxation.moduli
        back = 2.0 * (back + relaxation.equilibrium * (d[top] - d[top:]))[kept - top]
        with np.errstate(divide="ignore", invalid="ignore"):
            gained[kept] += curve.stiffness(at_edge.place) * back / force[kept]
            moved = back / relaxation(t[kept] - end)
            widened[kept] = moved / (d_end * _growth(curve, at_edge))
        sizes = np.concatenate([[radius[top]], radius[later]])
        if (np.diff(sizes) > 1e-9 * sizes[:1]).any():
            raise PathError(
                f"the contact grows again at row {int(later[np.argmax(np.diff(sizes))]) - 1} while the bodies separate; use springs"
            )
    return Rows(given.copy(), force[1:], radius[1:], gained[1:], widened[1:])


def _rows_of(time: ArrayLike, values: ArrayLike, words: str) -> tuple[FloatArray, FloatArray]:
    """Times and values of rows; values that are not finite are refused."""
    t, v = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    if t.shape != v.shape or t.ndim != 1 or t.size == 0:
        raise PathError(
            f"times of shape {t.shape} for {words} of shape {v.shape}; give one time for every row"
        )
    if not (np.isfinite(t).all() and np.isfinite(v).all()):
        raise PathError("a row of the path is not finite; give finite times and values")
    return t, v


def _growth(curve: Curve, states: DiskStates) -> FloatArray:
    """Logarithmic derivative of the depth by the radius, measured over a thousandth of the radius."""
    near = curve.depth((1.0 - _NEAR) * states.contact_radius)
    return np.asarray((states.indentation - near) / (_NEAR * states.indentation))


def _straightened(depth: FloatArray) -> FloatArray:
    """Depths without the turns before the first depth above 0 and after the last; separated bodies have no memory of the path."""
    touched = np.flatnonzero(depth > 0.0)
    first, last = (touched[0], touched[-1] + 1) if touched.size else (depth.size, depth.size)
    before, after = depth[:first][::-1], depth[last:]
    return np.concatenate(
        [np.minimum.accumulate(before)[::-1], depth[first:last], np.minimum.accumulate(after)]
    )


def creep(curve: Curve, relaxation: Relaxation, time: ArrayLike, force: ArrayLike) -> Rows:
    """
    A contact that grows under forces that do not fall, straight in time between the rows: F0(d(t)) = int J(t - s) dF(s).

    J is the creep compliance. Parameters are those of :func:`ting`, with forces in N.

    Raises
    ------
    PathError
        If a force falls, or is below 0.

    Notes
    -----
    Lee and Radok (1960).
    """
    t, load = _rows_of(time, force, "forces")
    if load.min() < 0.0:
        raise PathError(
            "a force is below 0 N: bodies without adhesion separate at 0 N; give forces of at least 0 N"
        )
    if (np.diff(load) < -_ROUNDING * load.max()).any():
        raise PathError("a contact may shrink where its force decreases; use springs")
    states: DiskStates = states_at_force(curve, compliant(relaxation, t, load))
    ones = np.ones(load.size)  # neither depth nor radius grows faster than the force does
    return Rows(states.indentation, load.copy(), states.contact_radius, ones, ones)


def compliant(relaxation: Relaxation, time: FloatArray, force: FloatArray) -> FloatArray:
    """The integral of J(t - s) dF(s) per unit modulus, one entry per row, of forces in N as :func:`creep` takes them."""
    t, load = np.concatenate([time[:1], time]), np.concatenate([[0.0], force])
    waits, steps = np.diff(t), np.diff(load)
    if waits.min() < 0.0:
        raise PathError(
            f"the time of row {int(np.argmin(waits))} is before that of the preceding row: times must not decrease; sort the rows"
        )
    modes = modes_of(relaxation)
    times = 1.0 / modes.rates
    lag = _recursed(np.exp(-waits[:, None] / times), _pushed(waits, steps, times))
    parts = modes.participation**2
    answer = (load[:, None] - lag) @ parts
    if relaxation.viscosity == 0.0:
        answer = answer + load / relaxation.glassy
    if relaxation.equilibrium == 0.0:
        flow = relaxation.viscosity + float(relaxation.moduli @ relaxation.times)
        answer[1:] += np.cumsum(0.5 * (load[1:] + load[:-1]) * waits) / flow
    return np.asarray(answer[1:])


def relaxed(relaxation: Relaxation, time: FloatArray, moved: FloatArray) -> FloatArray:
    """The integral of E*(t - s) dv(s) without a dashpot, one entry per row, of a v that is straight between the rows and 0 before."""
    waits, moves = np.diff(time, prepend=time[:1]), np.diff(moved, prepend=0.0)
    branches = _recursed(np.exp(-waits[:, None] / relaxation.times), _pushed(waits, moves, relaxation.times))
    return np.asarray(relaxation.equilibrium * moved + branches[1:] @ relaxation.moduli)


def _recursed(decay: FloatArray, added: FloatArray) -> FloatArray:
    """Values v_i = decay_i v_(i-1) + added_i from 0 on, shape (m + 1, n): those of every other row from pairs of rows."""
    values = np.zeros((decay.shape[0] + 1, decay.shape[1]))
    if decay.shape[0] > 1:
        first, second = decay[:-1:2], decay[1::2]
        values[2::2] = _recursed(second * first, second * added[:-1:2] + added[1::2])[1:]
    values[1::2] = decay[::2] * values[:-1:2] + added[::2]
    return values


def _pushed(waits: FloatArray, moves: FloatArray, times: FloatArray) -> FloatArray:
    """The integral of exp(-(t - s)/tau) over straight moves that end at t, shape (m, n)."""
    x = waits[:, None] / times
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(moves[:, None] * np.where(x > 0.0, -np.expm1(-x) / x, 1.0))


def _edge_rows(
    relaxation: Relaxation,
    t: FloatArray,
    d: FloatArray,
    path: FloatArray,
    speed: FloatArray,
    top: int,
    later: np.ndarray,
) -> tuple[np.ndarray, FloatArray]:
    """The row, and the fraction of it, that is t1 of later rows; row -1 where contact is lost."""
    from scipy.optimize import elementwise

    end_time, end_depth = t[later], d[later]
    drag = relaxation.viscosity * speed[later - 1]

    def pull(row: np.ndarray, fraction: FloatArray, at: np.ndarray) -> FloatArray:
        """Negative force of a spring that is touched at that time, which increases with t1."""
        wait = fraction * (t[row + 1] - t[row])
        move = fraction * (d[row + 1] - d[row])
        branches = np.exp(-wait[:, None] / relaxation.times) * path[row] + _pushed(
            wait, move, relaxation.times
        )
        old = np.exp(-(end_time[at] - t[row] - wait)[:, None] / relaxation.times) * branches
        return np.asarray(
            relaxation.equilibrium * (d[row] + move - end_depth[at])
            - (path[later[at]] - old) @ relaxation.moduli
            - drag[at]
        )

    everyone = np.arange(later.size)
    first = int(np.searchsorted(d[: top + 1], 0.0, side="right")) - 1  # the row in which the bodies touch
    touch = -d[first] / (d[first + 1] - d[first])
    low, high = np.full(later.size, first), np.full(later.size, top)
    while (high - low > 1).any():
        middle = np.maximum((low + high) // 2, low)
        over = pull(np.minimum(middle, top - 1), np.where(middle < top, 0.0, 1.0), everyone) > 0.0
        inside = high - low > 1
        high, low = np.where(over & inside, middle, high), np.where(~over & inside, middle, low)
    begin = np.where(low == first, touch, 0.0)
    dissipated = pull(low, begin, everyone) >= 0.0
    fraction = np.ones(later.size)
    open_ = ~dissipated & (pull(low, fraction, everyone) > 0.0)
    if open_.any():
        which = np.flatnonzero(open_)
        solution = elementwise.find_root(
            lambda part, at: pull(low[at.astype(int)], part, at.astype(int)),
            (begin[which], np.ones(which.size)),
            args=(which,),
        )
        fraction[which] = solution.x
    return np.where(dissipated, -1, low), fraction


def _convolved(
    curve: Curve,
    times: FloatArray,
    t_low: FloatArray,
    t_high: FloatArray,
    d_low: FloatArray,
    d_high: FloatArray,
) -> FloatArray:
    """The integrals of exp(-(t_high - s)/tau) dF0 over straight moves, shape (m, n), by panels graded to both ends."""
    total = np.zeros((t_low.size, times.size))
    if times.size == 0:
        return total
    jump = (t_high == t_low) & (d_high > d_low)
    if jump.any():
        rise = [normal_force(curve, states_at_depth(curve, values[jump])) for values in (d_low, d_high)]
        total[jump] = (rise[1] - rise[0])[:, None]
    known = min(curve.edge, curve.max_radius)
    inside = [x for x in curve.breakpoints if 0.0 < x < known]
    # at a sharp edge F0 becomes linear
    marks = curve.depth(np.array([*inside, curve.edge] if curve.edge == known < math.inf else inside))
    moving = np.flatnonzero((t_high > t_low) & (d_high > d_low) & (d_high > 0.0))
    duration = (t_high - t_low)[moving]
    touch = np.maximum(-d_low[moving], 0.0) / (d_high - d_low)[moving]
    # what has relaxed within a rounding of the row feels its last speed alone
    instant = times[:, None] < _ROUNDED * duration
    shortest = np.min(np.where(instant, math.inf, times[:, None]), axis=0, initial=math.inf)
    plain = (duration <= shortest) & (d_high[moving] <= 2.0 * d_low[moving])
    if marks.size:
        plain &= np.searchsorted(marks, d_low[moving]) == np.searchsorted(marks, d_high[moving])
    index, low, high = [moving[plain]], [touch[plain]], [np.ones(int(plain.sum()))]
    for i, begin, length, short in zip(
        moving[~plain], touch[~plain], duration[~plain], shortest[~plain], strict=True
    ):
        halves = 0.5 ** np.arange(_HALVINGS + 1.0)
        width = 1.0 - begin
        span = d_high[i] - d_low[i]
        inner = marks[(marks > max(d_low[i], 0.0)) & (marks < d_high[i])]
        ends = [
            np.array([begin, 1.0]),
            begin + width * halves[halves * width * span > 0.5 * max(d_low[i], 0.0)],
            1.0 - width * halves[halves * width * length > 0.5 * short],
        ]
        for mark in (inner - d_low[i]) / span:  # g' may be infinite at a kink
            ends += [mark[None], mark + (1.0 - mark) * halves, mark - (mark - begin) * halves]
        cuts = np.unique(np.concatenate(ends))
        index.append(np.full(cuts.size - 1, i))
        low.append(cuts[:-1])
        high.append(cuts[1:])
    rows, start, stop = np.concatenate(index), np.concatenate(low), np.concatenate(high)
    part = start[:, None] + (stop - start)[:, None] * (0.5 + 0.5 * _NODES)
    span = (d_high - d_low)[rows]
    stiffness = curve.stiffness(states_at_depth(curve, d_low[rows, None] + span[:, None] * part).place)
    weight = 0.5 * (stop - start)[:, None] * span[:, None] * stiffness * _WEIGHTS
    before = ((t_high - t_low)[rows, None]) * (1.0 - part)
    for j, tau in enumerate(times):
        if not instant[j].all():
            np.add.at(total[:, j], rows, (weight * np.exp(-before / tau)).sum(axis=1))
    if instant.any():
        speed = (d_high - d_low)[moving] / duration
        last = curve.stiffness(states_at_depth(curve, d_high[moving]).place) * speed
        total[moving] = np.where(instant.T, times * last[:, None], total[moving])
    return total
