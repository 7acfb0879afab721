"""The contact with adhesion along a path: branches, jumps, pull-off; with hysteresis its edge advances, rests and recedes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from pymdr.errors import ConvergenceError, PathError, ProblemError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.adhesion import (
    Visited,
    adhesive_claims,
    certify_stretched_disk,
    energy_assumption,
    is_always_open,
    without_torn_rows,
)
from pymdr.interpretation.adhesive_accuracy import adhesive_errors
from pymdr.interpretation.certificate import Certificate
from pymdr.interpretation.theories import theory_of
from pymdr.interpretation.validity import BoolArray, approximated, with_prescribed
from pymdr.line.adhesion import JKR as ShortRange
from pymdr.line.adhesion import EdgeJKR, Works, edge_states
from pymdr.line.following import Track, energy_residual, follow, follow_with_hysteresis
from pymdr.line.foundation import DiskStates, mean_pressure
from pymdr.numerics.panels import Place
from pymdr.problem.contact import Contact
from pymdr.problem.laws import JKR
from pymdr.problem.schedule import Stretch
from pymdr.result import Result, Status
from pymdr.rows import joined, taken
from pymdr.solving.adhesive_rows import Rows, State, left_out, rows_of, stiffness_of, with_tear_off_losses
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.mapped import assumptions, map_remark
from pymdr.solving.normal import refuse_tangential
from pymdr.solving.walk import (
    Channels,
    Interpretation,
    LegProgress,
    Task,
    channels_at,
    solution,
    walk,
    with_travel,
)
from pymdr.units import FloatArray, metres, newtons

_ROUNDING = 1e-12


def solve_adhesive(task: Task) -> Result:
    """Map, walk and interpret."""
    refuse_tangential(
        task.path,
        "the contact is adhesive: with friction, adhesion is covered only without slip, by JKR and friction=Coulomb(math.inf); "
        "else leave the channel out",
    )
    line = AdhesiveLine(task.contact)
    walked = walk(task, State(), partial(step, line, task.machine_stiffness, _followed))
    return solution(task, walked, interpret(task, line, walked.rows))


FollowLeg = Callable[[AdhesiveLine, Track, "float | None", State, Stretch], tuple[Rows, State]]
"""Rows of a leg on the track of a line, under a machine, from a state, and the state at their end."""


def step(
    line: AdhesiveLine,
    stiffness: float | None,
    follow_leg: FollowLeg,
    state: State,
    stretch: Stretch,
    kept: np.ndarray | None,
    progress: LegProgress | None,
) -> tuple[Rows, State, Channels]:
    """Step 2: states on the curve of the law, with jumps at its folds, up to the first row that layers do not allow."""
    assert kept is None
    values, k = stretch.normal, stiffness_of(stretch, stiffness)
    parts, end, count = [], state, 0
    if state.solved:
        track = traced(line, k, float(np.max(values)), state.parameter or 0.0)
        beyond = values > np.max(track.high)
        count = int(np.argmax(beyond)) if line.limit is not None and beyond.any() else values.size
    if count > 0:
        rows, end = follow_leg(line, track, stiffness, state, replace(stretch, normal=values[:count]))
        parts.append(rows)
    if count < values.size:
        parts.append(left_out(k, values[count:], end))
        end = State(known=False, solved=False, dissipated=end.dissipated, spent=end.spent)
    whole = joined(parts)
    here = channels_at(float(whole.indentation[-1]), float(whole.normal_force[-1]), stiffness)
    return whole, end, here


def traced(line: AdhesiveLine, k: float, top: float, parameter: float) -> Track:
    """The curve up to the largest target of a path, or as far as layers allow."""
    try:
        return line.track(k, top, parameter)
    except (ConvergenceError, ProblemError):
        if not line.is_limited():
            raise
    return line.track(k, -math.inf, line.end)


def _followed(
    line: AdhesiveLine, track: Track, stiffness: float | None, state: State, stretch: Stretch
) -> tuple[Rows, State]:
    """Rows that can be solved, and the state at their end."""
    values = stretch.normal
    if stiffness_of(stretch, stiffness) == 0.0 and state.parameter is None and state.known:
        refuse_pull_on_nothing(values, float(track.curve.control(np.array([track.pull_off]))[0]))
    history = with_tear_off_losses(line, follow(track, values, state.parameter))
    return rows_of(line.equilibria, history, energy_residual(track, history), stiffness, state, stretch)


def _visited(line: AdhesiveLine, rows: Rows) -> Visited:
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


def refuse_pull_on_nothing(values: FloatArray, pull_off: float) -> None:
    """Refuse a tensile force in N on a free body; `pull_off` is the limit of a contact."""
    if values[0] >= 0.0:
        return
    raise PathError(
        f"normal_force = {newtons(values[0])}: a body out of contact cannot be pulled (in contact the limit is "
        f"{newtons(pull_off)}); make contact first, for example with load('0 N') >> ..."
    )


def _jump_notes(
    line: AdhesiveLine, rows: Rows, known: BoolArray, receding: AdhesiveLine | None
) -> tuple[str, ...]:
    """Notes on the first jump into contact and the last out of it."""
    jumps = taken(rows.jumps, known[rows.jumps.step])
    into, out = np.isnan(jumps.before), np.isnan(jumps.after)
    others = int(np.count_nonzero(rows.jumped & known)) - np.unique(jumps.step[into | out]).size
    notes: tuple[str, ...] = ()
    for event, s, curve in (
        ("jumped into contact", jumps.after[into][:1], line),
        ("pulled off", jumps.before[out][-1:], receding or line),
    ):
        states = curve.equilibria.states(s)
        for each in zip(states.indentation, states.normal_force, states.contact_radius, strict=True):
            d, force, a = map(float, each)
            smooth, load = float(line.line.depth(a)), float(line.line.force(a))
            # at a jump from 0 the sums leave rounding errors
            d, force = (0.0 if abs(x) <= _ROUNDING * size else x for x, size in ((d, smooth), (force, load)))
            notes += (f"{event} at d = {metres(d)}, F = {newtons(force)}, a = {metres(a)}",)
    return (*notes, f"the contact jumped in {others} other steps") if others > 0 else notes


@dataclass(frozen=True)
class Edge:
    """What an edge with hysteresis adds to the rows on the curve of its advance."""

    states: EdgeJKR
    receding: AdhesiveLine


def interpret(task: Task, line: AdhesiveLine, rows: Rows, edge: Edge | None = None) -> Interpretation:
    """Step 3: quantities, claims and assumptions of every row; `line` is that of an edge that advances."""
    equilibria = line.equilibria if edge is None else edge.states
    law = task.contact.adhesion
    assert law is not None
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
    elastic, surface = equilibria.energies(s, rows.indentation)
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
    theory = theory_of(law)
    if edge is None:
        opening = theory.opening(law, line.line, states.contact_radius)
    else:
        opening = np.where(s > equilibria.start, edge.states.opening(s), 0.0)
        columns["adhesion_dissipation"] = rows.spent
    columns |= {name: shown(values) for name, values in theory.columns(equilibria, line.line, s).items()}
    columns = with_travel(task, columns)
    depths = np.where(rows.attached, rows.indentation, math.nan)
    certificate = _certificate(line, rows)
    said = theory.claim(law, task.contact.profile, line.line)
    claims = adhesive_claims(said, tuple(columns), certificate.disk, certificate.reason)
    disks = DiskStates(np.nan_to_num(depths), Place(np.zeros(a.shape), np.nan_to_num(a)), np.zeros(a.shape))
    k = task.machine_stiffness
    machine = 0.0 if k is None else 0.5 * np.nan_to_num(rows.normal_force) ** 2 / k
    jumping = None if edge is None else edge.receding.equilibria
    errors = adhesive_errors(line.line, equilibria, s, rows.control, columns, rows.jumps, machine, jumping)
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
        notes=(
            *line.origin.notes,
            *line.unsmoothed,
            *_jump_notes(line, rows, certificate.disk, None if edge is None else edge.receding),
        ),
        references=("sneddon", "popov-hess", *theory.references, *(() if edge is None else ("hysteresis",))),
    )


def _certificate(line: AdhesiveLine, rows: Rows) -> Certificate:
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


def _status(rows: Rows, disk: BoolArray) -> Status:
    if not disk.any():
        return Status.ADHESION_REFUSED
    if not disk.all():
        return Status.ADHESION_PARTLY_REFUSED
    if rows.attached[-1]:
        return Status.ATTACHED
    return Status.PULLED_OFF if rows.attached.any() or rows.jumped.any() else Status.NOT_TOUCHED


@dataclass
class HystereticLine:
    """
    The curves of an edge that advances at one work of adhesion and recedes at another.

    Parameters
    ----------
    contact : Contact
        With ``JKR(work, work_receding)``.
    """

    contact: Contact
    works: Works = field(init=False)
    """Works of adhesion in J/m^2."""
    advancing: AdhesiveLine = field(init=False)
    """The curve of the smaller work."""
    receding: AdhesiveLine = field(init=False)
    """The curve of the larger work."""

    def __post_init__(self) -> None:
        assert self.contact.adhesion is not None
        self.works = Works(*self.contact.adhesion.works)
        self.advancing, self.receding = (
            AdhesiveLine(replace(self.contact, adhesion=JKR(work))) for work in self.works
        )

    @property
    def rim(self) -> float:
        """Parameter in m of a sharp edge; inf without one."""
        equivalent = self.advancing.line.equivalent
        return equivalent.edge if equivalent.edge <= equivalent.max_radius else math.inf

    def radius(self, s: FloatArray) -> FloatArray:
        """Contact radius in m at parameters; 0 for a free body."""
        states = ShortRange(self.advancing.line, 0.0).states(np.nan_to_num(s))
        return np.where(np.isnan(s), 0.0, states.contact_radius)

    def follow(
        self, line: AdhesiveLine, track: Track, stiffness: float | None, state: State, stretch: Stretch
    ) -> tuple[Rows, State]:
        """The rows of a leg, and the state at its end; `line` and `track` are those of the advancing edge."""
        values, k = stretch.normal, stiffness_of(stretch, stiffness)
        if k == 0.0 and state.parameter is None and state.known:
            fold = traced(self.receding, k, 0.0, track.curve.stop)
            refuse_pull_on_nothing(values, float(fold.curve.control(np.array([fold.pull_off]))[0]))
        receding = traced(self.receding, k, -math.inf, track.curve.stop)
        initial = state.edge and state.edge.under(same=k == state.stiffness)
        history = follow_with_hysteresis(track, receding, values, initial, self.rim)
        residual = history.residual(track, receding)
        history = replace(
            history,
            motions=tuple(
                replace(m, history=with_tear_off_losses(self.receding, m.history)) for m in history.motions
            ),
        )
        a = self.radius(history.parameter)
        before = np.append(self.radius(np.array([state.parameter or math.nan])), a[:-1])
        spent = np.where(
            history.receded, (self.works.receding - self.works.advancing) * math.pi * (before**2 - a**2), 0.0
        )
        depth = self._depth(np.nan_to_num(history.parameter), values, k)
        s, edge = edge_states(
            line.line, np.nan_to_num(history.parameter), depth, history.direction, self.works
        )
        placed = replace(history, parameter=np.where(history.attached, s, math.nan))
        rows, end = rows_of(edge, placed, residual, stiffness, state, stretch, (history.direction, spent))
        return rows, replace(end, parameter=history.end and history.end.parameter, edge=history.end)

    def _depth(self, s: FloatArray, control: FloatArray, k: float) -> FloatArray:
        """Indentation in m of an edge at rest under a control."""
        line = self.advancing.line
        smooth = ShortRange(line, 0.0).states(s)
        stiffness, touching = np.ones(s.shape), smooth.contact_radius > 0.0
        stiffness[touching] = line.stiffness(smooth.contact_radius[touching])
        if k == 0.0:
            return smooth.indentation + (control - smooth.normal_force) / stiffness
        excess = control - smooth.indentation - smooth.normal_force / k
        return smooth.indentation + excess / (1.0 + stiffness / k)


def solve_hysteretic(task: Task) -> Result:
    """Map, walk and interpret."""
    refuse_tangential(
        task.path, "the contact is adhesive: adhesion with friction is not covered; leave the channel out"
    )
    lines = HystereticLine(task.contact)
    line = lines.advancing
    walked = walk(task, State(), partial(step, line, task.machine_stiffness, lines.follow))
    rows = walked.rows
    # parameters at a sharp edge count from it again
    s = np.minimum(np.where(rows.attached, rows.parameter, 0.0), lines.rim)
    direction = np.where(rows.attached, rows.direction, 1)
    placed, edge = edge_states(line.line, s, np.nan_to_num(rows.indentation), direction, lines.works)
    rows = replace(rows, parameter=np.where(rows.attached, placed, math.nan))
    return solution(task, walked, interpret(task, line, rows, Edge(edge, lines.receding)))
