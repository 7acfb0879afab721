"""The frictionless contact without adhesion along a path."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from pymdr.errors import ConvergenceError, PathError, ProblemError
from pymdr.interpretation.accuracy import normal_errors, with_errors
from pymdr.interpretation.certificate import (
    certify_disk,
    describe_ranges,
    noise_remark,
    valid_ranges,
    with_rings,
)
from pymdr.interpretation.fields import edge_amplitude
from pymdr.interpretation.validity import (
    BoolArray,
    Claim,
    bodies_of,
    bound_claim,
    normal_claims,
    trial_claim,
    with_prescribed,
)
from pymdr.line.curves import ElasticLine, Line
from pymdr.line.foundation import (
    DiskStates,
    elastic_energy,
    mean_pressure,
    normal_force,
    normal_stiffness,
    states_at_depth,
    states_at_force,
    states_at_travel,
)
from pymdr.line.layered import LayeredLine, lower_bound
from pymdr.numerics.panels import Place
from pymdr.problem.contact import Contact
from pymdr.problem.paths import TANGENTIAL_CHANNELS, Cycle, LoadingPath, Path, named_channels
from pymdr.problem.schedule import Planned, Stretch, planned
from pymdr.result import Result, Status
from pymdr.rows import taken
from pymdr.solving.mapped import Mapped, assumptions, g_samples, map_remark, map_to_line, refuse_unreachable
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
from pymdr.units import FloatArray, newtons


@dataclass(frozen=True)
class _Rows:
    states: DiskStates
    prescribed: FloatArray
    """The force where it is prescribed, else NaN."""
    moved: BoolArray
    """Whether the indentation is prescribed."""
    solved: BoolArray
    """Whether the row could be solved on layers; other rows contain the prescribed values only."""


def solve_normal(task: Task) -> Result:
    """Map, walk and interpret."""
    check_normal_path(task.path)
    mapped = map_to_line(task.contact)
    walked = walk(task, None, partial(_step, task, mapped.line))
    return solution(task, walked, _interpret(task, mapped, walked))


def _step(
    task: Task, line: Line, _: None, stretch: Stretch, kept: np.ndarray | None, progress: LegProgress | None
) -> tuple[_Rows, None, Channels]:
    """Step 2: every row is a state of the line at the prescribed value, without memory."""
    targets, machine = stretch.normal, task.machine_stiffness
    if stretch.by_force:
        refuse_tension(stretch.leg, targets)
    compliance = 0.0
    if stretch.controls.normal == "travel" and machine is not None:
        compliance = 1.0 / machine
    states, solved = _states(line, targets, stretch.by_force, compliance)
    if solved.any():
        most = float(np.max(targets[solved])) if stretch.by_force else None
        refuse_unreachable(line, task.contact.profile, states.take(solved), most)
    here = dict.fromkeys(("indentation", "normal_force", "travel"), math.nan)
    if solved[-1]:
        last = states.take(slice(-1, None))
        here = channels_at(float(last.indentation[0]), float(normal_force(line, last)[0]), machine)
    prescribed = targets if stretch.by_force else np.full(targets.size, math.nan)
    moved = np.full(targets.size, not stretch.by_force and compliance == 0.0)
    return taken(_Rows(states, prescribed, moved, solved), kept), None, here


def _states(
    line: Line, targets: FloatArray, by_force: bool, compliance: float
) -> tuple[DiskStates, BoolArray]:
    """
    States at the prescribed values, and which of them could be solved.

    On layers, contacts beyond some size cannot be solved: too wide for the equation, not resolved, or where the profile decreases.
    """

    def solve(values: FloatArray, deepest: float = math.inf) -> DiskStates:
        if by_force:
            return states_at_force(line, values)
        if compliance > 0.0:
            return states_at_travel(line, values, 1.0 / compliance, deepest)
        return states_at_depth(line, values)

    def control(depth: float, force: float) -> float:
        return force if by_force else depth + compliance * force

    try:
        return solve(targets), np.ones(targets.shape, dtype=bool)
    except (ConvergenceError, ProblemError):
        most = float(np.max(targets))
        limit = line.limit(lambda *state: control(*state) >= most) if isinstance(line, LayeredLine) else None
        if limit is None or not limit.depth > 0.0:
            raise
        solved = targets <= control(limit.depth, limit.load)
    states = DiskStates(
        np.where(compliance > 0.0, limit.depth, targets),
        Place(np.zeros(targets.shape), np.zeros(targets.shape)),
        np.zeros(targets.shape),
    )
    below = solve(targets[solved], limit.depth)
    states.indentation[solved] = below.indentation
    states.place.base[solved], states.place.offset[solved] = below.place.base, below.place.offset
    states.edge_excess[solved] = below.edge_excess
    return states, solved


def check_normal_path(path: LoadingPath) -> None:
    """Refuse paths that a contact without friction and adhesion cannot follow."""
    refuse_tangential(path, "the contact has no friction: add Contact(..., friction=Coulomb(0.3))")
    for leg in planned(path):
        force = getattr(leg.leg, "normal_force", None)
        if force is not None and not isinstance(leg.leg, Cycle):
            with leg.named():
                refuse_tension(leg, np.atleast_1d(force))


def refuse_tangential(path: LoadingPath, why: str, channels: tuple[str, ...] = TANGENTIAL_CHANNELS) -> None:
    """Refuse legs that prescribe one of some tangential channels."""
    for leg in planned(path):
        for name in named_channels(leg.leg):
            if name in channels:
                with leg.named():
                    raise PathError(f"the path prescribes {name}, but {why}")


def refuse_tension(leg: Planned, force: FloatArray) -> None:
    """Refuse negative forces; name the row where the path gives every row."""
    lowest = int(np.argmin(force))
    if force[lowest] < 0.0:
        given = isinstance(leg.leg, Path)
        where = f" in {leg.row(lowest)}" if given else ""
        raise PathError(
            f"normal_force = {newtons(float(force[lowest]))}{where}: without adhesion the force cannot be below 0 N; "
            "unload to 0 N, or lift off with indent(...)"
            + (
                "; in a measured record, begin at the contact point and set negative noise to 0 N"
                if given
                else ""
            )
        )


def _interpret(task: Task, mapped: Mapped, walked: Walked[_Rows]) -> Interpretation:
    """Step 3: quantities, claims and assumptions of every row."""
    rows = walked.rows
    line, states = mapped.line, rows.states
    by_force = np.isfinite(rows.prescribed)
    force = np.where(by_force, rows.prescribed, normal_force(line, states))
    claims, disk = _claims(task.contact, line, rows)
    bound = force
    if isinstance(line, LayeredLine) and not np.all(disk | by_force):
        bound, claims["force_lower_bound"] = _bound(line, rows, disk, force, claims["force_lower_bound"])
    columns: dict[str, FloatArray] = {
        "indentation": states.indentation,
        "normal_force": force,
        "contact_radius": states.contact_radius,
        "normal_stiffness": normal_stiffness(line, states),
        "mean_pressure": mean_pressure(force, states.contact_radius),
        "elastic_energy": elastic_energy(line, states),
        "force_lower_bound": bound,
    }
    if math.isfinite(line.edge) and line.exponent == 0.0:
        columns["edge_amplitude"] = edge_amplitude(line, states.contact_radius, states.edge_excess)
    if task.machine_stiffness is not None:
        claims["travel"] = claims["normal_force"]
    return Interpretation(
        columns=with_travel(task, columns),
        claims=claims,
        assumptions=assumptions(task.contact, mapped, states.contact_radius, states.edge_excess),
        status=Status.COMPLETED if disk.all() else Status.PARTLY_REFUSED if disk.any() else Status.REFUSED,
        notes=mapped.notes,
        references=("sneddon", "popov-hess", *(() if disk.all() else ("barber",))),
    )


def _claims(contact: Contact, line: Line, rows: _Rows) -> tuple[dict[str, Claim], BoolArray]:
    """The claims of every quantity, and whether every row is a disk."""
    states, by_force = rows.states, np.isfinite(rows.prescribed)
    certificate = certify_disk(line, states)
    disk, reason = certificate.disk & rows.solved, certificate.reason
    if isinstance(line, LayeredLine) and not rows.solved.all():
        limit = line.limit(lambda *_: False)
        assert limit is not None
        if not rows.solved.any():
            raise limit.error
        reason = "; ".join(text for text in (reason, str(limit.error)) if text)
    claims = normal_claims(
        disk,
        reason,
        _range_text(contact, line, states, disk),
        bodies_of(line),
    )
    claims = with_rings(claims, certificate) | {"force_lower_bound": bound_claim(disk)}
    claims = with_errors(claims, normal_errors(line, states, by_force), map_remark(line, states))
    claims = with_prescribed(claims, disk, {"indentation": rows.moved, "normal_force": by_force})
    if not (math.isfinite(line.edge) and line.exponent == 0.0):
        del claims["edge_amplitude"]
    return claims, disk


def _bound(
    line: LayeredLine, rows: _Rows, disk: BoolArray, force: FloatArray, claim: Claim
) -> tuple[FloatArray, Claim]:
    """The lower bound of the force where the contact is not a disk, with its claim."""
    states, open_ = rows.states, ~(disk | np.isfinite(rows.prescribed))
    radius = np.where(rows.solved, states.contact_radius, math.nan)
    bound, error = force.copy(), np.zeros(force.shape) if claim.error is None else claim.error.copy()
    bound[open_], error[open_] = lower_bound(line, states.indentation[open_], radius[open_])
    return bound, with_errors({"force_lower_bound": trial_claim(disk)}, {"force_lower_bound": error})[
        "force_lower_bound"
    ]


def _range_text(contact: Contact, line: Line, states: DiskStates, disk: BoolArray) -> str:
    """The loads at which the contact is a disk, if not at all of them, and the remedy."""
    if disk.all() or not isinstance(line, ElasticLine):
        return ""
    deepest = float(np.max(states.indentation))
    remedy = noise_remark(contact.profile, line.equivalent, deepest)
    if math.isfinite(line.equivalent.edge):
        deepest = max(4.0 * deepest, 4.0 * float(np.max(np.abs(g_samples(line)))))
    ranges = valid_ranges(line, deepest)
    top = normal_force(line, states_at_depth(line, np.array([deepest])))
    return remedy + describe_ranges(ranges, float(top[0]))
