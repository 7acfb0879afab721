"""One approach and one retreat of bodies with memory by tables: for searches that follow a record thousands of times."""

from __future__ import annotations

import math

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.line.curves import Curve
from pymdr.line.foundation import rises_to, states_at_depth
from pymdr.mapping.relaxation import Relaxation
from pymdr.numerics.graded import GradedTable, graded_table
from pymdr.units import FloatArray

_WITHIN, _TOLERANCE = 1.0 - 1e-9, 1e-12
_ROWS, _DRAGGED = 400, 1600
"""Smallest number of parts of a record on a machine, and of one with a dashpot, whose force has an error of first
order."""


def tabulated(curve: Curve, deepest: float) -> GradedTable | None:
    """
    The stiffness in m per unit modulus over the depth in m, up to a depth or to the end of the curve, and its integral.

    None where the contacts are not disks, or the stiffness cannot be tabulated with a relative error of 1e-12.
    """
    if math.isfinite(curve.max_radius) and curve.max_radius < curve.edge:
        deepest = min(deepest, float(curve.depth(np.array(_WITHIN * curve.max_radius))))
    if not rises_to(curve, deepest):
        return None

    def stiffness(depth: FloatArray) -> FloatArray:
        return np.asarray(curve.stiffness(states_at_depth(curve, depth).place))

    try:
        return graded_table(stiffness, deepest, tolerance=_TOLERANCE)
    except (ConvergenceError, ProblemError):
        return None


def approach_and_retreat(
    table: GradedTable, relaxation: Relaxation, time: FloatArray, travel: FloatArray, compliance: float = 0.0
) -> FloatArray | None:
    """
    The forces in N of bodies that approach and separate once; None for other paths, or beyond the end of the table.

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
    table: GradedTable,
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
    bodies = ting_kernels.Bodies(
        table.rows,
        float(relaxation.equilibrium),
        float(relaxation.viscosity),
        relaxation.moduli.copy(),
        relaxation.times.copy(),
        float(compliance),
    )
    force = np.zeros(t.size)
    branches = np.zeros((2, t.size, relaxation.times.size))
    record = ting_kernels.Record(t, np.zeros(t.size), branches[0], branches[1])
    ended = ting_kernels.follow(bodies, record, target, force)
    met = ended == ting_kernels.MET and record.depth.max() <= table.max_argument
    return force[1::parts] if met else None
