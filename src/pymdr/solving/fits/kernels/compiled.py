"""The same search compiled for maps, with what is done at every sample written as loops. Loads numba."""

from __future__ import annotations

import math
from types import FunctionType
from typing import Any

import numpy as np
from numba.extending import overload, register_jitable

from pymdr import compiling
from pymdr.solving.fits import touching
from pymdr.solving.fits.kernels import curves, descent, model, starts
from pymdr.solving.fits.kernels.model import (
    BASE,
    CLOSE,
    LEAST_ROOT,
    NEWTON,
    NUMBERS,
    OUTSIDE,
    POINT,
    SCALE,
    SHAPE,
    TILT,
    Machine,
    Member,
    Model,
    Record,
    on_machine,
)
from pymdr.solving.fits.touching import FULLY_OUT, in_contact
from pymdr.units import FloatArray

_FUSED: dict[str, Any] = {"fastmath": {"contract"}, "error_model": "numpy"}
"""Products and sums may be fused, nothing else."""


@register_jitable(**_FUSED)
def _read(row: FloatArray, slope: FloatArray, root: float) -> tuple[float, float]:
    """Value and slope of a row at one root, as :func:`pymdr.solving.fits.kernels.model.read`."""
    cells = row.size - 1
    j = min(int(root * cells), cells - 1)
    t = root * cells - j
    rise, u, v = row[j + 1] - row[j], slope[j] / cells, slope[j + 1] / cells
    c3, c2 = u + v - 2.0 * rise, 3.0 * rise - 2.0 * u - v
    return row[j] + t * (u + t * (c2 + t * c3)), (u + t * (2.0 * c2 + 3.0 * t * c3)) * cells


@register_jitable(**_FUSED)
def _root_at(member: Member, machine: Machine, soft: float, travel: float, cell: int) -> tuple[float, int]:
    """Root at one travel, and its cell, which is looked for from the given one on."""
    travels, cells, reach = machine.travels, member.force.size - 1, member.deepest - member.fold
    while cell < cells - 1 and travel > travels[cell + 1]:
        cell += 1
    while cell > machine.cell and travel < travels[cell]:
        cell -= 1
    low, before, rate = cell / cells, travels[cell], 2.0 * reach * cell / cells + soft * member.slope[cell]
    if cell <= machine.cell:
        cell, low, before, rate = machine.cell, machine.root, machine.travel, machine.rate
    wide = (cell + 1) / cells - low
    rise, across, off = rate * wide, travels[cell + 1] - before, travel - before
    bent = math.sqrt(max(rise * rise + 4.0 * (across - rise) * off, 1e-300))
    root = min(low + 2.0 * off * wide / (rise + bent), OUTSIDE)
    for _ in range(NEWTON):
        value, slope = _read(member.force, member.slope, root)
        off = travel - member.fold - reach * root * root - soft * value
        moved = root + off / max(2.0 * reach * root + soft * slope, 1e-6 * reach)
        step = min(max(moved, 0.5 * (root + machine.root)), OUTSIDE) - root
        root += step
        if abs(step) < CLOSE:
            break
    return root, cell


def _model_of(record: Record, theta: FloatArray, member: Member) -> Model:
    """As :func:`pymdr.solving.fits.kernels.model.model_of`."""
    n, scale, reach = record.place.size, math.exp(theta[SCALE]), member.deepest - member.fold
    soft = record.softness * scale
    machine = on_machine(member, soft)
    start = scale * _read(member.force, member.slope, machine.root)[0]
    start_over = scale * _read(member.force_rate, member.slope_rate, machine.root)[0]
    force, rates, touches = np.zeros(n), np.zeros((NUMBERS, n)), np.empty(n, dtype=np.bool_)
    cell = machine.cell
    for i in range(n):
        travel = record.place[i] - theta[POINT]
        touches[i] = travel > 0.0
        rates[BASE, i], rates[TILT, i] = 1.0, record.place[i]
        if travel > machine.travel:
            if soft == 0.0:
                root = min(math.sqrt((travel - member.fold) / reach), OUTSIDE)
            else:
                root, cell = _root_at(member, machine, soft, travel, cell)
            value, slope = _read(member.force, member.slope, root)
            stretch = 2.0 * reach * max(root, LEAST_ROOT) + soft * slope
            share = scale * slope / max(stretch, 1e-4 * reach)
            force[i] = scale * value
            rates[SCALE, i], rates[POINT, i] = scale * value - share * soft * value, -share
            if member.varies:
                over = _read(member.force_rate, member.slope_rate, root)[0]
                folding = member.fold_rate * (1.0 - root * root) + soft * over
                rates[SHAPE, i] = scale * over - share * folding
        elif machine.travel < 0.0:
            force[i], rates[SCALE, i], rates[SHAPE, i] = start, start, start_over
    if machine.travel < 0.0:
        measured = record.force - theta[BASE] - theta[TILT] * record.place
        touches = in_contact(record.place - theta[POINT], measured, force, machine.travel)
        for i in range(n):
            if not touches[i]:
                force[i] = 0.0
                rates[:BASE, i] = 0.0
    return Model(force, rates, touches)


def _fitted_at(
    depth: FloatArray, force: FloatArray, member: Member, level: float, known: tuple[float, float]
) -> tuple[float, float, float]:
    """As :func:`pymdr.solving.fits.kernels.starts.fitted_at`."""
    n, deepest, pull = depth.size, np.argmax(depth), min(force.min() - level, 0.0)
    some, square, plain, powers, product = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        above = force[i] - level
        plain += above
        square += above * above
        held = i > deepest and depth[i] >= member.fold and above < FULLY_OUT * pull
        if depth[i] > 0.0 or held:
            root = math.sqrt((depth[i] - member.fold) / (member.deepest - member.fold))
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


_LOOPS = {model.model_of: _model_of, starts.fitted_at: _fitted_at}


def _let_compile() -> None:
    """Let numba compile what the outermost function calls."""
    for module in (touching, model, descent, starts, curves):
        for function in vars(module).values():
            if isinstance(function, FunctionType) and function.__module__ == module.__name__:
                loops = _LOOPS.get(function, function)
                overload(function, jit_options=_FUSED, strict=False)(lambda *_, loops=loops: loops)


_let_compile()
fit_curve = compiling.compiled(
    curves.fit_curve, compiling.stamp_of(__file__, touching.__file__), fastmath={"contract"}
)
