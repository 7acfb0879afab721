"""Results of a run of the memory stack: its rows, and the state from which it can be continued."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pymdr.numerics.graded.layout import IntArray
from pymdr.units import FloatArray


class Ending(Enum):
    """How a run ended."""

    COMPLETE = "all rows were followed"
    NOT_FINITE = "a row is not finite; give finite values"
    NOT_ATTAINABLE = "a row prescribes |F_x| > mu F_N, F_x without contact, or F_N < 0, which friction cannot carry; reduce F_x, or prescribe the shift"
    TOO_DEEP = "a row is deeper than the table of the elastic line; build the table for the largest depth"


@dataclass(frozen=True, eq=False)
class FrictionState:
    """
    The memory of a contact after a row: all that a later row needs.

    The anchor curve b(y) is piecewise linear between the vertices. Without slip (mu infinite) the normalised
    shift is v = G* u_x / E* and b may jump: two vertices at one depth.
    """

    y: FloatArray
    """(m + 1,) depths of the vertices in m; from 0 to the indentation in contact, (0,) without contact."""
    b: FloatArray
    """(m + 1,) normalised anchors in m; the last is the normalised shift v."""
    slope: FloatArray
    """(m,) slopes of b, -1 to 1; exactly -1 or 1 where springs are at Coulomb's limit; 0 for a jump."""
    indentation: float
    """d in m."""
    shift: float
    """u_x in m."""
    friction: float
    """Coefficient of friction mu."""
    modulus_ratio: float
    """E* / G*."""
    slip_work: float = 0.0
    """Slip work so far in J."""
    slip_distance: float = 0.0
    """Distance in m that the whole contact has slid so far."""
    rows: int = 0
    """Number of rows followed so far."""

    @property
    def traction_scale(self) -> float:
        """Traction per pressure of a unit slope: mu, or 1 without slip."""
        return self.friction if math.isfinite(self.friction) else 1.0

    @property
    def shift_scale(self) -> float:
        """Shift u_x per normalised shift: mu E* / G*, or E* / G* without slip."""
        return self.traction_scale * self.modulus_ratio

    @property
    def energy_scale(self) -> float:
        """Energy per normalised energy: mu^2 E* / G*, or E* / G* without slip."""
        return self.traction_scale**2 * self.modulus_ratio


def virgin_state(friction: float, modulus_ratio: float) -> FrictionState:
    """Return the state before the first row: no contact, no shift."""
    origin = frozen(np.zeros(1))
    return FrictionState(origin, origin, frozen(np.zeros(0)), 0.0, 0.0, friction, modulus_ratio)


def frozen(values: ArrayLike) -> FloatArray:
    """A contiguous read-only view: numba compiles one version for a caller's arrays and those of a path."""
    view = np.ascontiguousarray(values, dtype=float).view()
    view.flags.writeable = False
    return view


@dataclass(frozen=True, eq=False)
class FrictionHistory:
    """The followed rows, one entry per kept row, NaN from the row on where the run stopped."""

    kept: IntArray | None
    """Indices of the kept rows, None if all were kept."""
    indentation: FloatArray
    """d in m."""
    shift: FloatArray
    """u_x in m."""
    tangential_force: FloatArray
    """F_x in N."""
    stick_radius: FloatArray
    """Radius in m of the disk of springs below Coulomb's limit; the contact radius when all stick, 0 in sliding."""
    stored_energy: FloatArray
    """Elastic energy of the tangential springs in J."""
    slip_work: FloatArray
    """Work of friction so far in J, from its own closed sum; without slip the energy released by separating
    springs."""
    slip_distance: FloatArray
    """Distance in m that the innermost spring, and so the whole contact, has slid so far."""
    state: FrictionState
    """State after the last row that was followed."""
    checkpoints: dict[int, FrictionState]
    """States after the requested rows."""
    ending: Ending
    """How the run ended."""
    stopped: int
    """Row that could not be followed; the number of rows if there is none."""
    slip_work_before: float = 0.0
    """Slip work before the first row in J."""

    @property
    def rows(self) -> IntArray:
        """Indices of the kept rows."""
        return np.arange(self.indentation.size) if self.kept is None else self.kept

    @property
    def slip_work_steps(self) -> FloatArray:
        """Slip work in J since the kept row before."""
        return np.diff(self.slip_work, prepend=self.slip_work_before)


class Superposition(NamedTuple):
    """Tractions as a sum of frictionless pressures, after Jaeger and Ciavarella.

    tau(r) = scale sum_i [weight_i p(r; y_i) + edge_i dp/dd(r; y_i)], and likewise for the forces:
    F_x = scale sum_i [weight_i F_N(y_i) + edge_i 2 E* a(y_i)]. p(r; y) is the pressure at depth y and
    dp/dd = (E* / pi) / sqrt(a(y)^2 - r^2) that of a flat punch.
    """

    depth: FloatArray
    """(k,) y_i in m, rising."""
    weight: FloatArray
    """(k,) dimensionless."""
    edge: FloatArray
    """(k,) in m; 0 unless there is no slip."""
    scale: float
    """mu, or 1 without slip."""


def superposition(state: FrictionState) -> Superposition:
    """
    Weights of the pressures that add up to the tangential traction.

    tau(r) = mu sum sigma_i [p(r; y_i) - p(r; y_(i-1))], written with one weight sigma_i - sigma_(i+1) per depth.

    Notes
    -----
    Jaeger (1995), Ciavarella (1998).

    Examples
    --------
    >>> from pymdr.line.friction import follow_displacements, power_law_curves
    >>> run = follow_displacements(power_law_curves(2.0, 1.0, 1.0), [0.5, 0.5], [0.0, 0.25], 1.0, 1.0)
    >>> depth, weight, edge, scale = superposition(run.state)
    >>> depth.tolist(), weight.tolist()
    ([0.25, 0.5], [-1.0, 1.0])
    """
    jump = np.where(np.diff(state.y) > 0.0, 0.0, np.diff(state.b))
    edge = jump if not math.isfinite(state.friction) else np.zeros(state.slope.size)
    weight = state.slope - np.append(state.slope[1:], 0.0)[: state.slope.size]
    return Superposition(state.y[1:], weight, edge, state.traction_scale)


def spring_shifts(state: FrictionState, y: ArrayLike) -> FloatArray:
    """
    Elastic shift q / G* = u_x - b of the springs, in m.

    With it, tau = -(G* / pi) int_r^a w' / sqrt(x^2 - r^2) dx and, inside and outside of the contact,
    u_x(r) = (2 / pi) int_0^min(r, a) w / sqrt(r^2 - x^2) dx for w(x) = spring_shifts(state, g(x)); the slip of the
    surface is u_x - u_x(r).

    Parameters
    ----------
    y : array_like
        Spring labels g(x) in m.

    Returns
    -------
    ndarray
        Of the shape of `y`; 0 for springs out of contact.

    Notes
    -----
    Popov and Hess (2015), chapter 5.

    Examples
    --------
    >>> from pymdr.line.friction import follow_displacements, power_law_curves
    >>> run = follow_displacements(power_law_curves(2.0, 1.0, 1.0), [0.5, 0.5], [0.0, 0.25], 1.0, 1.0)
    >>> spring_shifts(run.state, [0.0, 0.25, 0.4, 0.6]).round(12).tolist()
    [0.25, 0.25, 0.1, 0.0]
    """
    label = np.asarray(y, dtype=float)
    if state.slope.size == 0:
        return np.where(np.isnan(label), np.nan, 0.0)
    above = np.clip(np.searchsorted(state.y, label, side="left"), 1, state.slope.size)
    lag = state.b[-1] - state.b[above - 1] - state.slope[above - 1] * (label - state.y[above - 1])
    return np.where(label < state.y[-1], state.shift_scale * lag, np.where(np.isnan(label), np.nan, 0.0))
