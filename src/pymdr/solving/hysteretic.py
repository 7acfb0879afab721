"""The contact with hysteresis of adhesion along a path: its edge advances, rests and recedes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from pymdr.line.adhesion import JKR as ShortRange
from pymdr.line.adhesion import Works, edge_states
from pymdr.line.following import Track, follow_with_hysteresis
from pymdr.problem.contact import Contact
from pymdr.problem.laws import JKR
from pymdr.problem.schedule import Stretch
from pymdr.result import Result
from pymdr.solving.adhesive import Edge, interpret, refuse_pull_on_nothing, step, traced
from pymdr.solving.adhesive_rows import Rows, State, rows_of, stiffness_of, with_tear_off_losses
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.normal import refuse_tangential
from pymdr.solving.walk import Task, solution, walk
from pymdr.units import FloatArray


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
        history = follow_with_hysteresis(track, receding, values, state.parameter, self.rim)
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
        return rows, replace(end, parameter=history.end)

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
