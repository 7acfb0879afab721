"""The contact with friction under torsion: normal and torsional controls of any kind, leg by leg."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pymdr.errors import ConvergenceError, PathError, ProblemError
from pymdr.interpretation.accuracy import normal_errors, with_errors
from pymdr.interpretation.certificate import with_rings
from pymdr.interpretation.torsion import (
    TORSIONAL_FIELDS,
    TORSIONAL_QUANTITIES,
    measured_error,
    torsional_claims,
    torsional_modulus,
)
from pymdr.interpretation.validity import BoolArray
from pymdr.line.foundation import (
    elastic_energy,
    mean_pressure,
    normal_force,
    normal_stiffness,
    rises_to,
    states_at_depth,
    states_at_force,
    states_at_travel,
)
from pymdr.line.torsion.constant import (
    TabulatedLimit,
    is_simple,
    tabulated_limit,
    turn_at_constant_depth,
    twist_at_torque,
)
from pymdr.line.torsion.limits import TwistedLine
from pymdr.line.torsion.moves import TwistState, slip_work, turn
from pymdr.problem.contact import Contact, refuse_curve
from pymdr.problem.paths import TORSIONAL_CHANNELS
from pymdr.problem.schedule import Stretch, uses
from pymdr.result import Result, Status
from pymdr.rows import taken
from pymdr.solving.frictional import disks_down_to
from pymdr.solving.mapped import Springs, assumptions, map_remark, map_to_springs, refuse_unreachable
from pymdr.solving.normal import refuse_tension
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
from pymdr.units import FloatArray, written

_MANY = 12
"""Rows at one indentation from which on a table of the limit of the springs takes less time than the rows."""
_WITHIN = (0.25, 0.5, 0.75)
"""Parts of a row that unloads after slip at which the traction is compared with friction, as at its end."""


@dataclass(frozen=True)
class Rows:
    """Columns of a walk."""

    states: np.ndarray
    """A :class:`~pymdr.line.torsion.moves.TwistState` per row."""
    normal_force: FloatArray
    slip_work: FloatArray
    missed: FloatArray
    """Estimated error of the slip work in J."""
    by_force: BoolArray


@dataclass
class TorsionLaw:
    """The springs of torsion along the legs of a path."""

    contact: Contact
    mapped: Springs
    machine_stiffness: float | None
    line: TwistedLine
    table: TabulatedLimit | None = None
    """Of the last indentation at which many rows turn."""
    work: float = 0.0
    missed: float = 0.0
    deepest: float = -math.inf

    def step(
        self, state: TwistState, stretch: Stretch, kept: np.ndarray | None, progress: LegProgress | None
    ) -> tuple[Rows, TwistState, Channels]:
        """Step 2: the segments, from the state of the leg before."""
        depths = self._depths(stretch)
        by_torque = stretch.controls.tangential == "torque"
        targets = stretch.tangential if self._turns(stretch) else np.full(depths.size, state.twist)
        states: list[TwistState] = []
        works, missed = np.empty(depths.size), np.empty(depths.size)
        for i, (depth, target) in enumerate(zip(depths.tolist(), targets.tolist(), strict=True)):
            if depth == state.indentation:
                self._tabulate(depth, depths[i : i + _MANY])
            twist = self._twist_at(state, depth, target, stretch, i) if by_torque else target
            state = self._move(state, depth, twist)
            states.append(state)
            works[i], missed[i] = self.work, self.missed
        line = self.mapped.line
        force = stretch.normal if stretch.by_force else normal_force(line, states_at_depth(line, depths))
        column = np.empty(len(states), dtype=object)
        column[:] = states
        rows = Rows(column, force, works, missed, np.full(depths.size, stretch.by_force))
        here = channels_at(state.indentation, float(force[-1]), self.machine_stiffness)
        return taken(rows, kept), state, {**here, "twist": state.twist, "torque": state.torque}

    def _turns(self, stretch: Stretch) -> bool:
        return stretch.controls.tangential in TORSIONAL_CHANNELS

    def _depths(self, stretch: Stretch) -> FloatArray:
        """Indentation of every row, within reach and in contact on disks."""
        line, targets = self.mapped.line, stretch.normal
        if stretch.by_force:
            refuse_tension(stretch.leg, targets)
            states = states_at_force(line, targets)
        elif stretch.controls.normal == "travel" and self.machine_stiffness is not None:
            states = states_at_travel(line, targets, self.machine_stiffness)
        else:
            states = states_at_depth(line, targets)
        refuse_unreachable(
            line, self.contact.profile, states, float(np.max(targets)) if stretch.by_force else None
        )
        deepest = float(np.max(states.indentation))
        if deepest > self.deepest:
            self.deepest = deepest
            disks_down_to(self.contact, line, deepest, "torsion")
            if not rises_to(line, deepest):
                raise ProblemError(
                    "the equivalent profile decreases within the contact, which is not covered in torsion; use an increasing "
                    "profile, or smooth it"
                )
        return states.indentation

    def _tabulate(self, depth: float, following: FloatArray) -> None:
        """Tabulate the limit at an indentation at which many rows follow."""
        many = following.size == _MANY and np.all(following == depth)
        if many and (self.table is None or self.table.limit.depth != depth):
            limit = self.line.limit_at(depth)
            if limit.radius > 0.0 and 0.0 < self.line.friction < math.inf:
                self.table = tabulated_limit(limit)

    def _table_of(self, state: TwistState, depth: float) -> TabulatedLimit | None:
        """The table of an indentation, if it knows all springs of a state."""
        table = self.table
        if table is None or table.limit.depth != depth or not table.resolved:
            return None
        return table if is_simple(state, table.limit) else None

    def _move(self, state: TwistState, depth: float, twist: float) -> TwistState:
        """One row; where it unloads after slip, the traction is compared with friction within it too."""
        table = self._table_of(state, depth)
        if table is not None:
            end, dissipated = turn_at_constant_depth(table, state, twist)
            self.work += dissipated
            return end
        unloads = depth < state.indentation and any(one.sign for one in state.segments)
        end = turn(self.line, state, depth, twist)
        if unloads and end.segments:
            within = [
                turn(
                    self.line,
                    state,
                    state.indentation + part * (depth - state.indentation),
                    state.twist + part * (twist - state.twist),
                )
                for part in _WITHIN
            ]
            end = replace(end, excess=max(one.excess for one in (*within, end)))
        dissipated, missed = slip_work(self.line, state, end)
        self.work += dissipated
        self.missed += missed
        return end

    def _twist_at(self, state: TwistState, depth: float, torque: float, stretch: Stretch, row: int) -> float:
        """The twist in rad at which a row has a torque."""
        from scipy.optimize import brentq

        table = self._table_of(state, depth)
        most = self.largest_torque(depth) if table is None else table.full_slip
        if abs(torque) >= most:
            if torque == 0.0:
                return state.twist
            raise PathError(
                f"torque = {written(torque, 'N*m')} in {stretch.row(row)}: friction carries less than {written(most, 'N*m')} there "
                "(torque of full slip); reduce it, or turn the body with twist(...)"
            )
        if table is not None:
            return twist_at_torque(table, state, torque)

        def excess(twist: float) -> float:
            return turn(self.line, state, depth, twist).torque - torque

        start = excess(state.twist)
        if start == 0.0:
            return state.twist
        radius = self.line.limit_at(depth).radius
        range_ = abs(start) / (16.0 / 3.0 * self.line.shear * radius**3)
        other = state.twist
        for _ in range(200):
            other = state.twist - math.copysign(range_, start)
            if excess(other) * start <= 0.0:
                break
            range_ *= 2.0
        else:
            raise ConvergenceError(
                f"the search for the twist at torque = {written(torque, 'N*m')} in {stretch.row(row)} did not converge (last value {other!r} rad); "
                "take more rows, or prescribe the twist"
            )
        return float(brentq(excess, state.twist, other, xtol=1e-300, rtol=8.9e-16))

    def largest_torque(self, depth: float) -> float:
        """Torque in N m of full slip, mu int p r dA."""
        limit = self.line.limit_at(depth)
        return float(limit.torque(np.zeros(1))[0]) if limit.radius > 0.0 else 0.0


def torsion_law(contact: Contact, machine_stiffness: float | None) -> TorsionLaw:
    """The law of a contact before its path."""
    assert contact.friction is not None
    mapped = map_to_springs(contact)
    line = TwistedLine(mapped.line, torsional_modulus(contact), contact.friction.coefficient)
    return TorsionLaw(contact, mapped, machine_stiffness, line)


def solve_torsional(task: Task) -> Result:
    """Map, walk and interpret."""
    refuse_curve(task.contact, "its torque depends on the contact radius")
    for name in ("shift", "tangential_force"):
        if uses(task.path, name):
            raise PathError(
                f"the path prescribes {name} and a twist: slip under both at once does not superpose and is not available; solve them separately"
            )
    law = torsion_law(task.contact, task.machine_stiffness)
    walked = walk(task, TwistState(), law.step)
    return solution(task, walked, _interpret(task, law, walked))


def replayed(task: Task) -> tuple[TwistState, ...]:
    """The state in every kept row of a path."""
    law = torsion_law(task.contact, task.machine_stiffness)
    return tuple(walk(task, TwistState(), law.step).rows.states)


def _interpret(task: Task, law: TorsionLaw, walked: Walked[Rows]) -> Interpretation:
    """Step 3: quantities, claims and assumptions of every kept row."""
    rows, line = walked.rows, law.mapped.line
    states: Sequence[TwistState] = rows.states.tolist()
    depth, twist, torque, stick, energy, excess = (
        np.array([getattr(one, name) for one in states], dtype=float)
        for name in ("indentation", "twist", "torque", "stick_radius", "energy", "excess")
    )
    disks = states_at_depth(line, depth)
    columns = {
        "indentation": depth,
        "normal_force": rows.normal_force,
        "contact_radius": disks.contact_radius,
        "normal_stiffness": normal_stiffness(line, disks),
        "mean_pressure": mean_pressure(rows.normal_force, disks.contact_radius),
        "elastic_energy": elastic_energy(line, disks),
        "twist": twist,
        "torque": torque,
        "torsional_stiffness": 16.0 / 3.0 * law.line.shear * stick**3,
        "stick_radius": stick,
        "stored_torsional_energy": energy,
        "dissipated_energy": rows.slip_work,
    }
    depths, back = np.unique(depth, return_inverse=True)
    largest = np.array([law.largest_torque(d) for d in depths.tolist()])[back]
    everywhere = np.ones(depth.size, dtype=bool)
    claims = torsional_claims(tuple(columns), everywhere, excess, measured_error(torque, largest, excess))
    claims = with_rings(claims, disks_down_to(task.contact, line, law.deepest, "torsion"))
    errors = normal_errors(line, disks, rows.by_force)
    if errors:
        worst = np.maximum(errors["normal_force"], errors["pressure"])
        errors |= dict.fromkeys((*TORSIONAL_QUANTITIES, *TORSIONAL_FIELDS), worst)
    near_kink = np.maximum.accumulate(np.array([law.line.error_near_kink(d) for d in depths.tolist()])[back])
    if near_kink.any():
        for name in (*TORSIONAL_QUANTITIES, *TORSIONAL_FIELDS):
            errors[name] = errors.get(name, 0.0) + near_kink
    missed = np.divide(rows.missed, rows.slip_work, out=np.zeros(depth.size), where=rows.slip_work > 0.0)
    if missed.any():
        errors["dissipated_energy"] = errors.get("dissipated_energy", np.zeros(depth.size)) + missed
    at_deepest = states_at_depth(line, np.array([max(law.deepest, 0.0)]))
    claims = with_errors(claims, errors, map_remark(line, at_deepest))
    listed = assumptions(task.contact, law.mapped, disks.contact_radius)
    return Interpretation(
        columns=with_travel(task, columns),
        claims=claims,
        assumptions=listed,
        status=Status.COMPLETED,
        notes=law.mapped.notes,
        references=("sneddon", "popov-hess", "lubkin"),
        starts=walked.starts,
    )
