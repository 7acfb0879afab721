"""The compiled work per sample of many curves, as loops. Loads numba."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba.extending import overload, register_jitable
from numpy.typing import NDArray

from pymdr import compiling
from pymdr.solving.fits import touching
from pymdr.solving.fits.kernels import descent, model, starts
from pymdr.solving.fits.kernels.model import (
    BASE,
    CLOSE,
    LEAST_ROOT,
    NEWTON,
    OUTSIDE,
    POINT,
    SCALE,
    SHAPE,
    TILT,
    FamilyTable,
    Machine,
    Member,
    Model,
    Record,
    on_machine,
)
from pymdr.solving.fits.touching import FULLY_OUT, BoolArray, last_place
from pymdr.units import FloatArray

_FUSED: dict[str, Any] = {"fastmath": {"contract"}, "error_model": "numpy"}
"""Products and sums may be fused, nothing else."""


@register_jitable(**_FUSED)
def _read(row: FloatArray, slope: FloatArray, root: float) -> tuple[float, float]:
    """Value and slope of a row at one root, as :func:`pymdr.solving.fits.kernels.model.read`."""
    cells = row.size - 1
    j, wide = min(int(root * cells), cells - 1), 1.0 / cells
    t = root * cells - j
    rise, u, v = row[j + 1] - row[j], slope[j] * wide, slope[j + 1] * wide
    c3, c2 = u + v - 2.0 * rise, 3.0 * rise - 2.0 * u - v
    return row[j] + t * (u + t * (c2 + t * c3)), (u + t * (2.0 * c2 + 3.0 * t * c3)) * cells


@register_jitable(**_FUSED)
def _root_at(member: Member, machine: Machine, soft: float, travel: float, cell: int) -> tuple[float, int]:
    """Root at one travel, and its cell, searched from the given one on."""
    travels, cells, span = machine.travels, member.force.size - 1, member.deepest - member.fold
    while cell < cells - 1 and travel > travels[cell + 1]:
        cell += 1
    while cell > machine.cell and travel < travels[cell]:
        cell -= 1
    low, before, rate = cell / cells, travels[cell], 2.0 * span * cell / cells + soft * member.slope[cell]
    if cell <= machine.cell:
        cell, low, before, rate = machine.cell, machine.root, machine.travel, machine.rate
    wide = (cell + 1) / cells - low
    rise, across, off = rate * wide, travels[cell + 1] - before, travel - before
    bent = math.sqrt(max(rise * rise + 4.0 * (across - rise) * off, 1e-300))
    root = min(low + 2.0 * off * wide / (rise + bent), OUTSIDE)
    for _ in range(NEWTON):
        value, slope = _read(member.force, member.slope, root)
        off = travel - member.fold - span * root * root - soft * value
        moved = root + off / max(2.0 * span * root + soft * slope, 1e-6 * span)
        step = min(max(moved, 0.5 * (root + machine.root)), OUTSIDE) - root
        root += step
        if abs(step) < CLOSE:
            break
    return root, cell


def _put(row: NDArray[Any], values: NDArray[Any]) -> None:
    """As :func:`pymdr.solving.fits.kernels.descent.put`."""
    for i in range(row.size):
        row[i] = values[i]


def _blended(weight: FloatArray, rows: FloatArray) -> FloatArray:
    """As :func:`pymdr.solving.fits.kernels.model.blended`."""
    out: FloatArray = weight[0] * rows[0]
    for i in range(1, weight.size):
        for j in range(out.size):
            out[j] += weight[i] * rows[i, j]
    return out


@register_jitable(**_FUSED)
def _turn(gain: FloatArray, first: int, last: int, step: int) -> int:
    """The sample, going from the first to before the last, up to which being in contact fits best."""
    total, best, where, i = 0.0, 0.0, first - step, first
    while i != last:
        total += gain[i]
        if total > best:
            best, where = total, i
        i += step
    return where


@register_jitable(**_FUSED)
def _leave(record: Record, theta: FloatArray, fold: float, fitted: Model) -> None:
    """As :func:`pymdr.solving.fits.touching.in_contact`; the force out of contact is 0."""
    force, rates, touches = fitted
    n, deepest, gain = force.size, int(np.argmax(record.place)), np.zeros(force.size)
    either, point = np.zeros(n, dtype=np.bool_), theta[POINT]
    approach, retreat = (
        last_place(record.place[0] - point, fold),
        last_place(record.place[n - 1] - point, fold),
    )
    for i in range(n):
        either[i] = (approach if i < deepest else retreat) <= record.place[i] - point <= -fold
        if either[i]:
            measured = record.force[i] - theta[BASE] - theta[TILT] * record.place[i]
            gain[i] = measured * measured - (measured - force[i]) ** 2
    first, last = _turn(gain, deepest - 1, -1, -1), _turn(gain, deepest + 1, n, 1)
    for i in range(n):
        if either[i]:
            touches[i] = first <= i <= last
        if not touches[i]:
            force[i] = 0.0
            for p in range(BASE):
                rates[p, i] = 0.0


@register_jitable(**_FUSED)
def _model_of(record: Record, theta: FloatArray, member: Member) -> Model:
    """As :func:`pymdr.solving.fits.kernels.model.model_of`."""
    n, scale, span = record.place.size, math.exp(theta[SCALE]), member.deepest - member.fold
    soft = record.softness * scale
    machine = on_machine(member, soft)
    start, rise = _read(member.force, member.slope, machine.root)
    over, over_rise = _read(member.force_rate, member.slope_rate, machine.root)
    start_scale = scale * (start - rise * soft * rise / machine.turn)
    moved = 2.0 * machine.root * member.fold_rate - soft * over_rise
    start_over = scale * (over + rise * moved / machine.turn)
    force, rates, touches = np.zeros(n), np.zeros((BASE, n)), np.empty(n, dtype=np.bool_)
    cell, decided = machine.cell, record.inside.size > 0
    for i in range(n):
        if decided and not record.inside[i]:
            touches[i] = False
            continue
        travel = record.place[i] - theta[POINT]
        touches[i] = decided or travel > 0.0
        if travel > machine.travel:
            if soft == 0.0:
                root = min(math.sqrt((travel - member.fold) / span), OUTSIDE)
            else:
                root, cell = _root_at(member, machine, soft, travel, cell)
            value, slope = _read(member.force, member.slope, root)
            stretch = 2.0 * span * max(root, LEAST_ROOT) + soft * slope
            fraction = scale * slope / max(stretch, 1e-4 * span)
            force[i] = scale * value
            rates[SCALE, i], rates[POINT, i] = scale * value - fraction * soft * value, -fraction
            if member.varies:
                over = _read(member.force_rate, member.slope_rate, root)[0]
                folding = member.fold_rate * (1.0 - root * root) + soft * over
                rates[SHAPE, i] = scale * over - fraction * folding
        elif decided or machine.travel < 0.0:
            force[i], rates[SCALE, i], rates[SHAPE, i] = scale * start, start_scale, start_over
    result = Model(force, rates, touches)
    if machine.travel < 0.0 and not decided:
        _leave(record, theta, machine.travel, result)
    return result


def _compared(
    record: Record, theta: FloatArray, member: Member, used: BoolArray
) -> tuple[Model, FloatArray, float]:
    """As :func:`pymdr.solving.fits.kernels.descent.compared`."""
    result, left, misfit = _model_of(record, theta, member), np.zeros(used.size), 0.0
    for i in range(used.size):
        if used[i]:
            left[i] = record.force[i] - theta[BASE] - theta[TILT] * record.place[i] - result.force[i]
            misfit += left[i] * left[i]
    return result, left, misfit


def _tangents(place: FloatArray, model: Model, used: BoolArray, directions: FloatArray) -> FloatArray:
    """As :func:`pymdr.solving.fits.kernels.descent.tangents`, without unneeded sums."""
    m = directions.shape[0]
    rows = np.empty((m, place.size))
    for p in range(m):
        for i in range(place.size):
            rows[p, i] = directions[p, BASE] + directions[p, TILT] * place[i] if used[i] else 0.0
        for j in range(BASE):
            if directions[p, j] != 0.0:
                for i in range(place.size):
                    rows[p, i] += directions[p, j] * model.rates[j, i] if used[i] else 0.0
    return rows


def _normal_equations(
    place: FloatArray, model: Model, left: FloatArray, used: BoolArray, directions: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """As :func:`pymdr.solving.fits.kernels.descent.normal_equations`."""
    m, rows = directions.shape[0], descent.tangents(place, model, used, directions)
    square, side = np.zeros((m, m)), np.zeros(m)
    for p in range(m):
        side[p] = np.dot(rows[p], left)
        for q in range(p + 1):
            square[p, q] = np.dot(rows[p], rows[q])
            square[q, p] = square[p, q]
    return square, side


@register_jitable(**_FUSED)
def _fitted_at(
    depth: FloatArray, force: FloatArray, member: Member, level: float, known: tuple[float, float]
) -> tuple[float, float, float]:
    """Best scale and baseline of a member at approximate depths, and the sum of squares; NaN in `known` means unknown."""
    n, deepest, least, span = depth.size, 0, 0.0, 1.0 / (member.deepest - member.fold)
    for i in range(n):
        if depth[i] > depth[deepest]:
            deepest = i
        least = min(least, force[i] - level)
    some, square, plain, powers, product = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        above = force[i] - level
        plain += above
        square += above * above
        pulled = i > deepest and depth[i] >= member.fold and above < FULLY_OUT * least
        if depth[i] > 0.0 or pulled:
            root = math.sqrt((depth[i] - member.fold) * span)
            value = _read(member.force, member.slope, min(root, OUTSIDE))[0]
            some += value
            powers += value * value
            product += value * above
    scale, base = known[0], known[1] - level
    if math.isnan(scale) and math.isnan(base):
        power = powers - some * some / n
        scale = (product - some * plain / n) / power if power > 0.0 else -1.0
    elif math.isnan(scale):
        scale = (product - base * some) / powers if powers > 0.0 else -1.0
    if math.isnan(base):
        base = (plain - scale * some) / n
    misfit = square - 2.0 * (base * plain + scale * product) + 2.0 * base * scale * some
    return scale, base + level, misfit + base * base * n + scale * scale * powers


def _best_points(trials: starts.Trials, family: FamilyTable, scales: FloatArray, places: FloatArray) -> None:
    """As :func:`pymdr.solving.fits.kernels.starts.best_points`."""
    for i in range(places.shape[0]):
        depth, force, level = trials.depth[i], trials.force[i], trials.level[i]
        for k in range(scales.shape[0]):
            member, known = model.on_rung(family, int(scales[k, 0])), (scales[k, 1], trials.baseline)
            best = places[i, k]
            for point in trials.points[i]:
                scale, offset, misfit = _fitted_at(depth - point, force, member, level, known)
                if scale > 0.0 and misfit < best[0]:
                    best[0], best[1], best[2], best[3] = misfit, scale, offset, point


def _let_compile() -> None:
    """Register the functions that the two outermost ones call with numba, some of them as loops."""
    same: tuple[Any, ...] = (
        last_place,
        model.member_at,
        model.on_rung,
        model.on_machine,
        descent.solved,
        descent.fixed_at_end,
        descent.descend,
    )
    loops: dict[Any, Any] = {
        model.blended: _blended,
        descent.put: _put,
        descent.compared: _compared,
        descent.normal_equations: _normal_equations,
        descent.tangents: _tangents,
    }
    options: Any = _FUSED
    for function, own in ({function: function for function in same} | loops).items():
        overload(function, jit_options=options, strict=False)(lambda *_, own=own: own)


_let_compile()
_STAMP = compiling.stamp_of(__file__, touching.__file__)
ENGINE = starts.Engine(
    compiling.compiled(descent.descend_all, _STAMP, fastmath={"contract"}),
    compiling.compiled(_best_points, _STAMP, fastmath={"contract"}),
    compiling.compiled(descent.tangents_all, _STAMP, fastmath={"contract"}),
)
"""The search of :mod:`pymdr.solving.fits.kernels`, compiled when it is first used."""
