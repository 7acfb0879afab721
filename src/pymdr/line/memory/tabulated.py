"""One approach and one retreat of bodies with memory by tables: for searches that follow a record thousands of times."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymdr.line.curves import Curve
from pymdr.line.foundation import rises_to, states_at_depth
from pymdr.mapping.relaxation import Relaxation
from pymdr.units import FloatArray

_CELLS, _WITHIN = 4096, 1.0 - 1e-9
_ROWS, _DRAGGED = 400, 1600
"""Parts into which a record on a machine is divided at least, and with a dashpot, whose force errs by the first power of a part."""


@dataclass(frozen=True, eq=False)
class Tabulated:
    """Stiffness in m and force in m^2 of a curve per unit modulus, at even steps of the fourth root of the depth."""

    columns: FloatArray
    """(2, cells + 1)."""
    deepest: float
    """In m."""


def tabulated(curve: Curve, deepest: float) -> Tabulated | None:
    """
    The table of a curve per unit modulus up to a depth in m, or to where it ends; None where its contacts are not disks.

    Between the columns the stiffness is straight in the fourth root of the depth, which errs by about 1e-8 of the largest.
    """
    if math.isfinite(curve.max_radius) and curve.max_radius < curve.edge:
        deepest = min(deepest, float(curve.depth(np.array(_WITHIN * curve.max_radius))))
    if not rises_to(curve, deepest):
        return None
    root = np.linspace(0.0, 1.0, _CELLS + 1)
    states = states_at_depth(curve, deepest * root**4)
    stiffness = curve.stiffness(states.place)
    rise = np.diff(stiffness) * _CELLS
    base = stiffness[:-1] - rise * root[:-1]
    steps = base * np.diff(root**4) + 0.8 * rise * np.diff(root**5)
    return Tabulated(np.stack([stiffness, np.append(0.0, np.cumsum(steps))]) * [[1.0], [deepest]], deepest)


def approach_and_retreat(
    table: Tabulated, relaxation: Relaxation, time: FloatArray, travel: FloatArray, compliance: float = 0.0
) -> FloatArray | None:
    """
    The forces in N of bodies that approach and part once; None where they do anything else, or go deeper than the table.

    Parameters
    ----------
    relaxation : Relaxation
        E*(t).
    time, travel : ndarray, shape (m,)
        t in s, rising, and the travels of a machine in m, straight between the rows; the bodies are apart before.
    compliance : float
        Of the machine in m/N; 0 where the travels are indentations.

    Notes
    -----
    Equations and sources are those of :func:`~pymdr.line.memory.ting.ting`, which follows the curve itself. On a machine the
    indentation is not straight where the travel is: it is followed over parts of the rows and over halves of those, and what
    they leave is extrapolated (Richardson).
    """
    if relaxation.viscosity > 0.0 and travel[0] > 0.0:
        return None
    if compliance == 0.0:
        return followed(table, relaxation, time, travel, 0.0, 1)
    rows, order = (_ROWS, 2) if relaxation.viscosity == 0.0 else (_DRAGGED, 1)
    parts = math.ceil(rows / time.size)
    coarse, fine = (followed(table, relaxation, time, travel, compliance, n) for n in (parts, 2 * parts))
    if coarse is None or fine is None:
        return None
    even = fine + (fine - coarse) / (2.0**order - 1.0)
    return np.where((fine == 0.0) | (even < 0.0), 0.0, even)


def divided(time: FloatArray, travel: FloatArray, parts: int) -> tuple[FloatArray, FloatArray]:
    """Straight parts of rows, as many in each."""
    rows, ends = np.arange(time.size), np.arange(parts * (time.size - 1) + 1) / parts
    return np.interp(ends, rows, time), np.interp(ends, rows, travel)


def followed(
    table: Tabulated,
    relaxation: Relaxation,
    time: FloatArray,
    travel: FloatArray,
    compliance: float,
    parts: int,
) -> FloatArray | None:
    """The forces with the indentation straight over parts of rows."""
    from pymdr.line.memory import ting_kernels

    time, travel = divided(time, travel, parts)
    t, target = np.append(time[0], time), np.append(min(0.0, travel[0]), travel)
    depth, force = np.empty(t.size), np.empty(t.size)
    bodies = ting_kernels.Bodies(
        table.columns,
        float(table.deepest),
        float(relaxation.equilibrium),
        float(relaxation.viscosity),
        relaxation.moduli.copy(),
        relaxation.times.copy(),
        float(compliance),
    )
    ended = ting_kernels.follow(bodies, t, target, depth, force)
    return None if ended != ting_kernels.MET or depth.max() > table.deepest else force[1::parts]
