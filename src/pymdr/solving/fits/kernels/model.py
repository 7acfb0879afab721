"""Forces of one member of a family at the samples of a record, and their rates."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pymdr.solving.fits.touching import BoolArray, in_contact
from pymdr.units import FloatArray

SCALE, SHAPE, POINT, BASE, TILT = range(5)
"""The numbers of the model: logarithm of the scale of the forces, the number in which the family differs (free, see
:class:`pymdr.solving.fits.unknowns.Unknown`), contact point in m, baseline in N, and its tilt in N/m about the origin of the places."""
NUMBERS = 5
OUTSIDE = 1.02
"""Largest root, relative to that of the deepest depth."""
NEWTON, CLOSE = 30, 1e-6
"""Largest number of steps, and the last step, whose square is the error."""
LEAST_ROOT = 1e-4
_MEMBERS = 8
"""Number of members through which the family is interpolated."""


class FamilyTable(NamedTuple):
    """
    Forces of the members of a family over the root of the depth.

    The columns of a member with the fold d_f are at d = d_f + (deepest - d_f) r^2, with even r from 0 to 1.
    """

    forces: FloatArray
    """In N, one member in each row."""
    slopes: FloatArray
    """dF/dr in N."""
    folds: FloatArray
    """In m."""
    first: float
    step: float
    """Step of the number in which the members differ."""
    deepest: float
    """In m."""


class Batch(NamedTuple):
    """Measured curves of as many samples, one in each row."""

    place: FloatArray
    """Travel or indentation in m."""
    force: FloatArray
    """In N."""
    softness: FloatArray
    """Compliance of the machine of each in m/N; 0 for indentations."""


class Record(NamedTuple):
    """A measured curve."""

    place: FloatArray
    """Travel or indentation in m."""
    force: FloatArray
    """In N."""
    softness: float
    """Compliance of the machine in m/N; 0 for indentations."""
    inside: BoolArray
    """Samples in contact, if they are prescribed; else empty, and the forces decide."""


class Member(NamedTuple):
    """Forces of one member of a family, of scale 1."""

    force: FloatArray
    slope: FloatArray
    """dF/dr."""
    force_rate: FloatArray
    """dF over the number in which the family differs."""
    slope_rate: FloatArray
    fold: float
    fold_rate: float
    deepest: float
    varies: bool
    """Whether the family has other members."""


class Machine(NamedTuple):
    """A member on a machine; its travel d_f + (deepest - d_f) r^2 + soft F(r) is smallest at the loss of contact."""

    travels: FloatArray
    """In m, at the nodes of the member."""
    root: float
    travel: float
    rate: float
    """dtravel/dr at the loss of contact in m."""
    cell: int
    turn: float
    """Second derivative of the travel over r in m at the loss of contact; infinite if it is at the fold, whose root is always 0."""


class Model(NamedTuple):
    """Forces of a member at the samples of a record."""

    force: FloatArray
    """In N, without baseline; 0 where the bodies are separated."""
    rates: FloatArray
    """Over the first three numbers of the model, one in each row."""
    touches: BoolArray


def on_rung(family: FamilyTable, k: int) -> Member:
    """A tabulated member, without its rates."""
    row, slope, fold = family.forces[k], family.slopes[k], family.folds[k]
    return Member(row, slope, row, slope, fold, 0.0, family.deepest, False)


def blended(weight: FloatArray, rows: FloatArray) -> FloatArray:
    """Sum of rows by their weights."""
    return np.asarray(np.dot(weight, rows))


def member_at(family: FamilyTable, number: float) -> Member:
    """Interpolate the family at a number, by polynomials through some members."""
    forces, slopes, folds = family.forces, family.slopes, family.folds
    if folds.size == 1:
        return on_rung(family, 0)
    many = min(_MEMBERS, folds.size)
    at = (number - family.first) / family.step
    k = min(max(int(at) - many // 2 + 1, 0), folds.size - many)
    weight, rate = np.ones(many), np.zeros(many)
    for i in range(many):
        for j in range(many):
            if j != i:
                rate[i] = (rate[i] * (at - k - j) + weight[i]) / (i - j)
                weight[i] *= (at - k - j) / (i - j)
    rate /= family.step
    fold, fold_rate = 0.0, 0.0
    for i in range(many):
        # folds are nearly powers of the number
        part = math.log(-folds[k + i]) if folds[0] < 0.0 else folds[k + i]
        fold += weight[i] * part
        fold_rate += rate[i] * part
    if folds[0] < 0.0:
        fold = -math.exp(fold)
        fold_rate *= fold
    return Member(
        blended(weight, forces[k : k + many]),
        blended(weight, slopes[k : k + many]),
        blended(rate, forces[k : k + many]),
        blended(rate, slopes[k : k + many]),
        fold,
        fold_rate,
        family.deepest,
        True,
    )


def read(row: FloatArray, slope: FloatArray, root: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Value, slope and second derivative of a row at roots, by the cubics of Hermite."""
    cells = row.size - 1
    x = root * cells
    j = np.minimum(x.astype(np.int64), cells - 1)
    t = x - j
    a, b, u, v = row[j], row[j + 1], slope[j] / cells, slope[j + 1] / cells
    c3 = 2.0 * (a - b) + u + v
    c2 = 3.0 * (b - a) - 2.0 * u - v
    return (
        a + t * (u + t * (c2 + t * c3)),
        (u + t * (2.0 * c2 + 3.0 * t * c3)) * cells,
        (2.0 * c2 + 6.0 * t * c3) * (cells * cells),
    )


def on_machine(member: Member, soft: float) -> Machine:
    """Travels of a member on a machine of a compliance in m/N."""
    cells, span = member.force.size - 1, member.deepest - member.fold
    if soft == 0.0:
        return Machine(member.force, 0.0, member.fold, 0.0, 0, math.inf)
    nodes = np.arange(cells + 1) / cells
    travels = member.fold + span * nodes * nodes + soft * member.force
    lowest = int(np.argmin(travels))
    # in retraction the contact keeps to the deepest branch until that loses its stability
    for i in range(cells - 1, lowest, -1):
        travels[i] = min(travels[i], travels[i + 1])
    rate = 2.0 * span * lowest / cells + soft * member.slope[lowest]
    if lowest == 0 and rate >= 0.0:
        return Machine(travels, 0.0, travels[0], rate, 0, math.inf)
    # the rate of the travel is a quadratic in the cell of the minimum
    j = min(lowest, cells - 1) if rate < 0.0 else lowest - 1
    rise, u, v = member.force[j + 1] - member.force[j], member.slope[j] / cells, member.slope[j + 1] / cells
    bend, turn = 3.0 * rise - 2.0 * u - v, u + v - 2.0 * rise
    c0 = 2.0 * span * j / cells + soft * cells * u
    c1, c2 = 2.0 * span / cells + soft * cells * 2.0 * bend, soft * cells * 3.0 * turn
    t = -2.0 * c0 / max(c1 + math.sqrt(max(c1 * c1 - 4.0 * c0 * c2, 0.0)), 1e-300)
    t = min(max(t, 0.0), 1.0)
    root, value = (j + t) / cells, member.force[j] + t * (u + t * (bend + t * turn))
    rate = 2.0 * span * root + soft * cells * (u + t * (2.0 * bend + 3.0 * t * turn))
    travel = member.fold + span * root * root + soft * value
    cell, second = min(int(root * cells), cells - 1), cells * (c1 + 2.0 * c2 * t)
    return Machine(travels, root, travel, max(rate, 0.0), cell, second if second > 0.0 else math.inf)


def roots_at(member: Member, machine: Machine, soft: float, travel: FloatArray) -> FloatArray:
    """Roots at travels in m beyond the loss of contact."""
    cells, span, first = member.force.size - 1, member.deepest - member.fold, machine.cell
    beyond = np.searchsorted(machine.travels[first + 1 :], travel)
    cell = np.minimum(beyond + first, cells - 1)
    begins = cell == first
    low = np.where(begins, machine.root, cell / cells)
    before = np.where(begins, machine.travel, machine.travels[cell])
    wide = (cell + 1) / cells - low
    rise = wide * np.where(begins, machine.rate, 2.0 * span * low + soft * member.slope[cell])
    # the parabola through both ends of the cell, exact next to the fold
    across, off = machine.travels[cell + 1] - before, travel - before
    bent = np.sqrt(np.maximum(rise * rise + 4.0 * (across - rise) * off, 1e-300))
    root: FloatArray = np.minimum(low + 2.0 * off * wide / (rise + bent), OUTSIDE)
    for _ in range(NEWTON):
        value, slope, _ = read(member.force, member.slope, root)
        off = travel - member.fold - span * root * root - soft * value
        moved = root + off / np.maximum(2.0 * span * root + soft * slope, 1e-6 * span)
        step = np.minimum(np.maximum(moved, 0.5 * (root + machine.root)), OUTSIDE) - root
        root = root + step
        if np.all(np.abs(step) < CLOSE):
            break
    return root


def model_of(record: Record, theta: FloatArray, member: Member) -> Model:
    """Forces of the model and their rates over its numbers."""
    n, scale, span = record.place.size, math.exp(theta[SCALE]), member.deepest - member.fold
    soft = record.softness * scale
    machine = on_machine(member, soft)
    travel = record.place - theta[POINT]
    beyond = np.flatnonzero(travel > machine.travel)
    if soft == 0.0:
        root = np.minimum(np.sqrt((travel[beyond] - member.fold) / span), OUTSIDE)
    else:
        root = roots_at(member, machine, soft, travel[beyond])
    value, slope, _ = read(member.force, member.slope, root)
    stretch = 2.0 * span * np.maximum(root, LEAST_ROOT) + soft * slope
    fraction = scale * slope / np.maximum(stretch, 1e-4 * span)
    rates, force = np.zeros((BASE, n)), np.zeros(n)
    touches = record.inside if record.inside.size else travel > 0.0
    if machine.travel < 0.0 or record.inside.size:
        # samples just beyond the loss of contact may be in contact, with the force there
        at = np.array([machine.root])
        start, rise = (column[0] for column in read(member.force, member.slope, at)[:2])
        over, over_rise = (column[0] for column in read(member.force_rate, member.slope_rate, at)[:2])
        force[:] = scale * start
        # the root of the smallest travel moves too
        rates[SCALE] = scale * (start - rise * soft * rise / machine.turn)
        moved = 2.0 * machine.root * member.fold_rate - soft * over_rise
        rates[SHAPE] = scale * (over + rise * moved / machine.turn)
    force[beyond] = scale * value
    rates[SCALE][beyond] = scale * value - fraction * soft * value
    rates[POINT][beyond] = -fraction
    if member.varies:
        over = read(member.force_rate, member.slope_rate, root)[0]
        rates[SHAPE][beyond] = scale * over - fraction * (
            member.fold_rate * (1.0 - root * root) + soft * over
        )
    if machine.travel < 0.0 or record.inside.size:
        if not record.inside.size:
            measured = record.force - theta[BASE] - theta[TILT] * record.place
            touches = in_contact(travel, measured, force, machine.travel)
        mask = touches.astype(np.float64)
        force *= mask
        rates *= mask
    return Model(force, rates, touches)
