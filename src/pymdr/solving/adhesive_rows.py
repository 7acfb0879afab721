"""The rows of a contact with adhesion: columns of the states that a leg visits."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from pymdr.interpretation.branches import Equilibria
from pymdr.interpretation.validity import BoolArray
from pymdr.line.following import Edge, History, Jumps, under_control
from pymdr.problem.schedule import Stretch
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.units import FloatArray

_CONTROL = {"indentation": math.inf, "normal_force": 0.0}
"""Machine stiffness in N/m equivalent to a prescribed channel."""


_PARAMETER = 4e-12
"""Relative error of a parameter from a table of states."""


@dataclass(frozen=True)
class State:
    """State of the contact between two legs."""

    parameter: float | None = None
    """None out of contact."""
    edge: Edge | None = None
    """With hysteresis, under the control of `stiffness`."""
    stiffness: float = math.inf
    """Machine stiffness in N/m equivalent to the control of the leg before."""
    known: bool = True
    """Whether the position is known: not after the contact was lost under a prescribed force."""
    solved: bool = True
    """Whether every row before could be solved."""
    dissipated: float = 0.0
    spent: float = 0.0


@dataclass(frozen=True)
class Rows:
    """Columns of a walk, one entry per row except for the last two."""

    parameter: FloatArray
    attached: BoolArray
    depth_rate: FloatArray
    """dd/ds."""
    force_rate: FloatArray
    """dF/ds in N/m."""
    control: FloatArray
    """Machine stiffness in N/m equivalent to the control."""
    indentation: FloatArray
    normal_force: FloatArray
    jumped: BoolArray
    jump_dissipation: FloatArray
    dissipated: FloatArray
    spent: FloatArray
    """Energy in J dissipated by hysteresis of adhesion, cumulative."""
    direction: np.ndarray
    """1 where an edge with hysteresis advances, -1 where it recedes, 0 where it rests or without hysteresis."""
    external_work: FloatArray
    solved: BoolArray
    """Whether the row and every row before it could be solved on layers."""
    residual: FloatArray
    """One entry per leg."""
    jumps: Jumps
    """One entry per jump, whose steps are rows of the path."""


def stiffness_of(stretch: Stretch, stiffness: float | None) -> float:
    """Machine stiffness in N/m equivalent to the control of a leg."""
    return _CONTROL.get(stretch.controls.normal, math.inf if stiffness is None else stiffness)


def left_out(k: float, values: FloatArray, end: State) -> Rows:
    """Rows that layers do not allow: prescribed values only."""
    unknown, none = np.full(values.shape, math.nan), np.zeros(values.shape)
    no_row = np.zeros(0)
    return Rows(
        parameter=unknown,
        attached=none > 0.0,
        depth_rate=none,
        force_rate=none,
        control=np.full(values.shape, k),
        indentation=values if math.isinf(k) else unknown,
        normal_force=values if k == 0.0 else unknown,
        jumped=none > 0.0,
        jump_dissipation=none,
        dissipated=none + end.dissipated,
        spent=none + end.spent,
        direction=np.zeros(values.shape, dtype=np.intp),
        external_work=none,
        solved=none > 0.0,
        residual=no_row,
        jumps=Jumps(no_row.astype(int), *(no_row,) * 4),
    )


class Followed(Protocol):
    """The states of a leg, one entry per row, and its jumps."""

    @property
    def parameter(self) -> FloatArray:
        """In m; NaN for a free body."""

    @property
    def attached(self) -> BoolArray:
        """Whether the bodies are in contact."""

    @property
    def jumped(self) -> BoolArray:
        """Whether the contact jumped."""

    @property
    def dissipated(self) -> FloatArray:
        """Energy dissipated in J."""

    @property
    def jumps(self) -> Jumps:
        """Every jump."""


def rows_of(
    equilibria: Equilibria,
    history: Followed,
    residual: float,
    stiffness: float | None,
    state: State,
    stretch: Stretch,
    hysteresis: tuple[np.ndarray, FloatArray] | None = None,
) -> tuple[Rows, State]:
    """The columns of a leg from its states on the curve, and the state at its end; of hysteresis the directions and the energy."""
    channel, values, k = stretch.controls.normal, stretch.normal, stiffness_of(stretch, stiffness)
    by_force = k == 0.0
    attached = history.attached
    s = np.where(attached, history.parameter, equilibria.start)
    states = equilibria.states(s)
    slopes = equilibria.slopes(s)
    between = between_parameters(k, values, s, (states.indentation, states.normal_force), slopes)
    force = np.where(attached, values if by_force else between[1], math.nan if by_force else 0.0)
    free_depth = np.full(values.shape, math.nan) if by_force else values
    depth = np.where(attached, values if channel == "indentation" else between[0], free_depth)
    elastic, surface = equilibria.energies(s, depth)
    machine = 0.0 if stiffness is None else np.where(attached, 0.5 * force * force / stiffness, 0.0)
    energy = np.where(attached, elastic + surface, 0.0) + machine
    direction, spent = hysteresis or (np.zeros(values.shape, dtype=np.intp), np.zeros(values.shape))
    dissipated = state.dissipated + np.cumsum(history.dissipated + spent)
    spent = state.spent + np.cumsum(spent)
    rows = Rows(
        parameter=np.where(attached, history.parameter, math.nan),
        attached=attached,
        depth_rate=slopes[0],
        force_rate=slopes[1],
        control=np.full(values.shape, k),
        indentation=depth,
        normal_force=force,
        jumped=history.jumped,
        jump_dissipation=history.dissipated,
        dissipated=dissipated,
        spent=spent,
        direction=direction,
        # work is stored or dissipated; the energy balance compares this with quadrature
        external_work=energy + dissipated,
        solved=np.ones(values.shape, dtype=bool),
        residual=np.array([residual]),
        jumps=replace(history.jumps, step=stretch.leg.first + history.jumps.step),
    )
    end = State(
        parameter=float(history.parameter[-1]) if attached[-1] else None,
        stiffness=k,
        known=not math.isnan(depth[-1]),
        dissipated=float(dissipated[-1]),
        spent=float(spent[-1]),
    )
    return rows, end


def between_parameters(
    k: float,
    control: FloatArray,
    s: FloatArray,
    at: tuple[FloatArray, FloatArray],
    rates: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Depth in m and force in N at a control between those of two adjacent parameters.

    Near a rim both change much within the rounding of s; they are linear in s over such a distance.
    """
    known = np.isfinite(rates[0]) & np.isfinite(rates[1])
    per_depth, per_force = (np.where(known, rate, 0.0) for rate in rates)
    step = parameter_step(control - under_control(k, *at), under_control(k, per_depth, per_force), s)
    return at[0] + per_depth * step, at[1] + per_force * step


def parameter_step(missing: FloatArray, rate: FloatArray, s: FloatArray) -> FloatArray:
    """The step of parameters that changes the control by what is missing, within the error of tables."""
    with np.errstate(divide="ignore", invalid="ignore"):
        step = np.nan_to_num(missing / rate)
    # at a fold the error of the parameter is not smaller than this
    width = _PARAMETER * np.abs(s)
    return np.clip(step, -width, width)


def with_tear_off_losses(line: AdhesiveLine, history: History) -> History:
    """The history with the energy dissipated where a dead load tore the contact off."""
    jumps = history.jumps
    torn = np.isnan(jumps.loss)
    if not torn.any():
        return history
    loss = jumps.loss.copy()
    loss[torn] = [
        line.fallen(float(s), float(force))
        for s, force in zip(jumps.before[torn], jumps.control[torn], strict=True)
    ]
    spent = np.bincount(jumps.step, weights=loss, minlength=history.control.size)
    return replace(history, jumps=replace(jumps, loss=loss), dissipated=spent.astype(float))
