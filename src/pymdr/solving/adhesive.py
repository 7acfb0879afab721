"""The contact with adhesion along a path: branches, jumps, pull-off."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pymdr.errors import ConvergenceError, PathError, ProblemError
from pymdr.interpretation.accuracy import adhesive_errors, with_errors
from pymdr.interpretation.adhesion import (
    Visited,
    adhesive_claims,
    certify_stretched_disk,
    energy_assumption,
    is_always_open,
    without_torn_rows,
)
from pymdr.interpretation.certificate import Certificate
from pymdr.interpretation.theories import theory_of
from pymdr.interpretation.validity import BoolArray, approximated, with_prescribed
from pymdr.line.following import History, Jumps, Track, energy_residual, follow, under_control
from pymdr.line.foundation import DiskStates, mean_pressure
from pymdr.numerics.panels import Place
from pymdr.problem.schedule import Stretch
from pymdr.result import Result, Status
from pymdr.rows import joined, taken
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.normal import refuse_tangential
from pymdr.solving.reach import assumptions, map_remark
from pymdr.solving.walk import (
    Channels,
    Interpretation,
    LegProgress,
    Task,
    Walked,
    channels_at,
    solution,
    walk,
    with_travel,
)
from pymdr.units import FloatArray, metres, newtons

_CONTROL = {"indentation": math.inf, "normal_force": 0.0}
"""Machine stiffness in N/m equivalent to a prescribed channel."""
_ROUNDING = 1e-12
_PARAMETER = 4e-12
"""Relative error of a parameter from a table of states."""


@dataclass(frozen=True)
class _State:
    """State of the contact between two legs."""

    parameter: float | None = None
    """None out of contact."""
    known: bool = True
    """Whether the position is known: not after the contact was lost under a prescribed force."""
    solved: bool = True
    """Whether every row before could be solved."""
    dissipated: float = 0.0


@dataclass(frozen=True)
class _Rows:
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
    external_work: FloatArray
    solved: BoolArray
    """Whether the row and every row before it could be solved on layers."""
    residual: FloatArray
    """One entry per leg."""
    jumps: Jumps
    """One entry per jump, whose steps are rows of the path."""


def solve_adhesive(task: Task) -> Result:
    """Map, walk and interpret."""
    refuse_tangential(
        task.path, "the contact is adhesive: adhesion with friction is not covered; leave the channel out"
    )
    line = AdhesiveLine(task.contact)
    walked = walk(task, _State(), partial(_step, line, task.machine_stiffness))
    return solution(task, walked, _interpret(task, line, walked))


def _step(
    line: AdhesiveLine,
    stiffness: float | None,
    state: _State,
    stretch: Stretch,
    kept: np.ndarray | None,
    progress: LegProgress | None,
) -> tuple[_Rows, _State, Channels]:
    """Step 2: states on the curve of the law, with jumps at its folds, up to the first row that layers do not allow."""
    assert kept is None
    values, k = stretch.normal, _stiffness_of(stretch, stiffness)
    parts, end, count = [], state, 0
    if state.solved:
        track = _track(line, k, float(np.max(values)), state.parameter or 0.0)
        beyond = values > np.max(track.high)
        count = int(np.argmax(beyond)) if line.limit is not None and beyond.any() else values.size
    if count > 0:
        rows, end = _followed(line, track, stiffness, state, replace(stretch, normal=values[:count]))
        parts.append(rows)
    if count < values.size:
        parts.append(_left_out(k, values[count:], end.dissipated))
        end = _State(known=False, solved=False, dissipated=end.dissipated)
    whole = joined(parts)
    here = channels_at(float(whole.indentation[-1]), float(whole.normal_force[-1]), stiffness)
    return whole, end, here


def _stiffness_of(stretch: Stretch, stiffness: float | None) -> float:
    """Machine stiffness in N/m equivalent to the control of a leg."""
    return _CONTROL.get(stretch.controls.normal, math.inf if stiffness is None else stiffness)


def _track(line: AdhesiveLine, k: float, top: float, parameter: float) -> Track:
    """The curve up to the largest target of a path, or as far as layers allow."""
    try:
        return line.track(k, top, parameter)
    except (ConvergenceError, ProblemError):
        if not line.is_limited():
            raise
    return line.track(k, -math.inf, line.end)


def _left_out(k: float, values: FloatArray, dissipated: float) -> _Rows:
    """Rows that layers do not allow: prescribed values only."""
    unknown, none = np.full(values.shape, math.nan), np.zeros(values.shape)
    no_row = np.zeros(0)
    return _Rows(
        parameter=unknown,
        attached=none > 0.0,
        depth_rate=none,
        force_rate=none,
        control=np.full(values.shape, k),
        indentation=values if math.isinf(k) else unknown,
        normal_force=values if k == 0.0 else unknown,
        jumped=none > 0.0,
        jump_dissipation=none,
        dissipated=none + dissipated,
        external_work=none,
        solved=none > 0.0,
        residual=no_row,
        jumps=Jumps(no_row.astype(int), *(no_row,) * 4),
    )


def _followed(
    line: AdhesiveLine, track: Track, stiffness: float | None, state: _State, stretch: Stretch
) -> tuple[_Rows, _State]:
    """Rows that can be solved, and the state at their end."""
    channel, values, k = stretch.controls.normal, stretch.normal, _stiffness_of(stretch, stiffness)
    by_force = k == 0.0
    if by_force and state.parameter is None and state.known:
        _refuse_pull_on_nothing(values, float(track.curve.control(np.array([track.pull_off]))[0]))
    history = _with_tear_off_losses(line, follow(track, values, state.parameter))
    attached = history.attached
    s = np.where(attached, history.parameter, line.equilibria.start)
    states = line.equilibria.states(s)
    elastic, surface = line.equilibria.energies(s)
    slopes = line.equilibria.slopes(s)
    between = _between_parameters(k, values, s, (states.indentation, states.normal_force), slopes)
    force = np.where(attached, values if by_force else between[1], math.nan if by_force else 0.0)
    free_depth = np.full(values.shape, math.nan) if by_force else values
    depth = np.where(attached, values if channel == "indentation" else between[0], free_depth)
    machine = 0.0 if stiffness is None else np.where(attached, 0.5 * force * force / stiffness, 0.0)
    energy = np.where(attached, elastic + surface, 0.0) + machine
    dissipated = state.dissipated + np.cumsum(history.dissipated)
    rows = _Rows(
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
        # work is stored or dissipated; the energy balance compares this with quadrature
        external_work=energy + dissipated,
        solved=np.ones(values.shape, dtype=bool),
        residual=np.array([energy_residual(track, history)]),
        jumps=replace(history.jumps, step=stretch.leg.first + history.jumps.step),
    )
    end = _State(
        parameter=float(history.parameter[-1]) if attached[-1] else None,
        known=not math.isnan(depth[-1]),
        dissipated=float(dissipated[-1]),
    )
    return rows, end


def _between_parameters(
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
    with np.errstate(divide="ignore", invalid="ignore"):
        step = np.nan_to_num((control - under_control(k, *at)) / under_control(k, per_depth, per_force))
    # at a fold the error of the parameter is not smaller than this
    width = _PARAMETER * np.abs(s)
    step = np.clip(step, -width, width)
    return at[0] + per_depth * step, at[1] + per_force * step


def _with_tear_off_losses(line: AdhesiveLine, history: History) -> History:
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


def _visited(line: AdhesiveLine, rows: _Rows) -> Visited:
    """Equilibria that a path passes between its rows, and its jumps."""
    jumps, size = rows.jumps, rows.attached.size
    if is_always_open(line.line, line.law):
        none = np.zeros(0)
        return Visited(none.astype(int), *(none,) * 2, none.astype(int), *(none,) * 5)
    # the nodes of a row are both ends of its jumps, then the row itself
    row = np.concatenate([np.repeat(jumps.step, 2), np.arange(size)])
    s = np.concatenate([np.stack([jumps.before, jumps.after], axis=1).ravel(), rows.parameter])
    jumped = np.concatenate([np.tile([False, True], jumps.step.size), np.zeros(size, dtype=bool)])
    order = np.argsort(row, kind="stable")
    row, s, jumped = row[order], s[order], jumped[order]
    a = np.where(np.isnan(s), 0.0, line.equilibria.states(np.nan_to_num(s)).contact_radius)
    before = np.concatenate([[0.0], a[:-1]])
    smooth = ~jumped & ((a > 0.0) | (before > 0.0))
    return Visited(
        row[smooth],
        before[smooth],
        a[smooth],
        row[jumped],
        rows.control[row[jumped]],
        jumps.control,
        before[jumped],
        a[jumped],
        jumps.loss,
    )


def _refuse_pull_on_nothing(values: FloatArray, pull_off: float) -> None:
    if values[0] >= 0.0:
        return
    raise PathError(
        f"normal_force = {newtons(values[0])}: a body out of contact cannot be pulled (in contact the limit is "
        f"{newtons(pull_off)}); make contact first, for example with load('0 N') >> ..."
    )


def _jump_notes(line: AdhesiveLine, rows: _Rows, known: BoolArray) -> tuple[str, ...]:
    """Notes on the first jump into contact and the last out of it."""
    jumps = taken(rows.jumps, known[rows.jumps.step])
    into, out = np.isnan(jumps.before), np.isnan(jumps.after)
    others = int(np.count_nonzero(rows.jumped & known)) - np.unique(jumps.step[into | out]).size
    notes: tuple[str, ...] = ()
    for event, s in (("jumped into contact", jumps.after[into][:1]), ("pulled off", jumps.before[out][-1:])):
        states = line.equilibria.states(s)
        for each in zip(states.indentation, states.normal_force, states.contact_radius, strict=True):
            d, force, a = map(float, each)
            smooth, load = float(line.line.depth(a)), float(line.line.force(a))
            # at a jump from 0 the sums leave rounding errors
            d, force = (0.0 if abs(x) <= _ROUNDING * size else x for x, size in ((d, smooth), (force, load)))
            notes += (f"{event} at d = {metres(d)}, F = {newtons(force)}, a = {metres(a)}",)
    return (*notes, f"the contact jumped in {others} other steps") if others > 0 else notes


def _interpret(task: Task, line: AdhesiveLine, walked: Walked[_Rows]) -> Interpretation:
    """Step 3: quantities, claims and assumptions of every row."""
    rows = walked.rows
    equilibria = line.equilibria
    s = np.where(rows.attached, rows.parameter, equilibria.start)
    states = equilibria.states(s)
    torn = ~rows.attached & rows.solved & np.isnan(rows.indentation)
    blank = np.where(torn, math.nan, 0.0)

    def shown(values: FloatArray) -> FloatArray:
        return np.where(rows.attached, values, blank)

    a = shown(states.contact_radius)
    with np.errstate(divide="ignore", invalid="ignore"):
        stiffness_now = np.where(
            rows.attached & (s > equilibria.start), rows.force_rate / rows.depth_rate, 0.0
        )
    elastic, surface = equilibria.energies(s)
    columns: dict[str, FloatArray] = {
        "indentation": rows.indentation,
        "normal_force": rows.normal_force,
        "contact_radius": a,
        "normal_stiffness": shown(stiffness_now),
        "mean_pressure": np.where(torn, math.nan, mean_pressure(rows.normal_force, np.nan_to_num(a))),
        "elastic_energy": shown(elastic),
        "surface_energy": shown(surface),
        "external_work": rows.external_work,
        "jumped": rows.jumped.astype(float),
        "jump_dissipation": rows.jump_dissipation,
        "dissipated_energy": rows.dissipated,
    }
    theory = theory_of(line.law)
    opening = theory.opening(line.law, line.line, states.contact_radius)
    columns |= {name: shown(values) for name, values in theory.columns(equilibria, line.line, s).items()}
    columns = with_travel(task, columns)
    depths = np.where(rows.attached, rows.indentation, math.nan)
    certificate = _certificate(line, rows)
    said = theory.claim(line.law, task.contact.profile, line.line)
    claims = adhesive_claims(said, tuple(columns), certificate.disk, certificate.reason)
    disks = DiskStates(np.nan_to_num(depths), Place(np.zeros(a.shape), np.nan_to_num(a)), np.zeros(a.shape))
    k = task.machine_stiffness
    machine = 0.0 if k is None else 0.5 * np.nan_to_num(rows.normal_force) ** 2 / k
    errors = adhesive_errors(line.line, equilibria, s, rows.control, columns, rows.jumps, machine)
    claims = with_errors(claims, errors, map_remark(line.line, disks))
    balance = energy_assumption(float(np.max(rows.residual)))
    if not balance.met:
        claims = approximated(
            claims, f"; the energy balance has a relative residual of {balance.measure:.1g}", balance.measure
        )
    prescribed = {
        "indentation": np.isinf(rows.control),
        "normal_force": rows.control == 0.0,
    }
    if k is not None:
        prescribed["travel"] = (rows.control > 0.0) & np.isfinite(rows.control) & rows.solved
    claims = with_prescribed(claims, certificate.disk, prescribed)
    return Interpretation(
        columns=columns,
        claims=without_torn_rows(claims, torn),
        assumptions=(*assumptions(task.contact, line.origin, a, -opening), balance),
        status=_status(rows, certificate.disk),
        notes=(*line.origin.notes, *line.unsmoothed, *_jump_notes(line, rows, certificate.disk)),
        references=("sneddon", "popov-hess", *theory.references),
    )


def _certificate(line: AdhesiveLine, rows: _Rows) -> Certificate:
    """The rows that are disks and could be solved, and the reason for the others."""
    certificate = certify_stretched_disk(line.line, _visited(line, rows), rows.solved.size, line.law)
    if certificate.reason:
        certificate = replace(certificate, reason="; ".join((certificate.reason, *line.unsmoothed)))
    if rows.solved.all():
        return certificate
    assert line.limit is not None
    if not rows.solved.any():
        raise line.limit.error
    last = line.equilibria.states(np.array([line.end]))
    depth, force = metres(float(last.indentation[0])), newtons(float(last.normal_force[0]))
    reason = f"{line.limit.error}; the path is followed up to its first row beyond d = {depth}, F = {force}"
    return Certificate(
        certificate.disk & rows.solved, "; ".join(w for w in (certificate.reason, reason) if w)
    )


def _status(rows: _Rows, disk: BoolArray) -> Status:
    if not disk.any():
        return Status.ADHESION_REFUSED
    if not disk.all():
        return Status.ADHESION_PARTLY_REFUSED
    if rows.attached[-1]:
        return Status.ATTACHED
    return Status.PULLED_OFF if rows.attached.any() or rows.jumped.any() else Status.NOT_TOUCHED
