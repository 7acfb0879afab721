"""The contact with friction along a path: normal and tangential controls of any kind, leg by leg."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pymdr.errors import PathError, ProblemError
from pymdr.interpretation.accuracy import EXACT_WITHIN, with_errors
from pymdr.interpretation.certificate import Certificate, certify_disk, certify_history, noise_words
from pymdr.interpretation.friction import (
    TANGENTIAL_QUANTITIES,
    frictional_claims,
    similarity_assumption,
)
from pymdr.interpretation.traction import (
    PARTS,
    TANGENTIAL_FIELDS,
    curves_down_to,
    deepest_of,
    friction_leg,
)
from pymdr.interpretation.validity import Assumption, approximated
from pymdr.line.foundation import (
    ElasticLine,
    elastic_energy,
    mean_pressure,
    normal_force,
    normal_stiffness,
    states_at_depth,
    states_at_force,
)
from pymdr.line.friction import (
    ElasticCurves,
    Ending,
    FrictionHistory,
    FrictionLeg,
    FrictionState,
    follow_leg,
    virgin_state,
)
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.contact import Contact
from pymdr.problem.paths import NORMAL_CHANNELS, Cycle, LoadingPath
from pymdr.problem.schedule import (
    Controls,
    Progress,
    Stretch,
    known_legs,
    refined,
    stretch,
    times,
    total_rows,
)
from pymdr.result import Result, Status, labelled
from pymdr.solving.normal import refuse_tension
from pymdr.solving.reach import Mapped, assumptions, map_remark, map_to_line, refuse_unreachable
from pymdr.units import FloatArray, metres, newtons

_REFINED = 200_000
"""Rows up to which a leg is refined."""
_MEASURED = ("shift", "tangential_force", "slip_work")
"""What tells whether a leg is refined enough."""
_SLOWEST = 0.5
"""By how much the changes of a leg are said to fall from one refinement to the next, where it is not known to be more."""
_SETTLED = 1e-9
"""Of the largest value of a leg: what a refinement may leave."""
_CHUNK = 2_000_000
"""Rows between two calls of `progress`."""


@dataclass
class _Line:
    """The line and its curves, made anew when a leg goes deeper."""

    contact: Contact
    mapped: Mapped
    stiffness: float | None
    curves: ElasticCurves
    deepest: float = -math.inf
    """What the curves reach, in m."""
    certificate: Certificate | None = None

    def deepen(self, asked: Sequence[Stretch]) -> None:
        """Go as deep as some legs ask."""
        line = self.mapped.line
        for rows in asked:
            if rows.by_force:
                refuse_tension(rows.normal)
        # not the largest travel: most of it may go into the machine
        deepest = deepest_of(line, [friction_leg(line, rows, self.stiffness) for rows in asked])
        if deepest <= self.deepest:
            return
        self.deepest = deepest
        forces = [float(np.max(rows.normal)) for rows in asked if rows.by_force]
        by_force = max(forces) if forces and not math.isfinite(deepest) else None
        refuse_unreachable(line, self.contact.profile, states_at_depth(line, np.array([deepest])), by_force)
        self.certificate = disks_down_to(self.contact, line, deepest)
        for rows in asked:
            if rows.by_force:
                _refuse_lifted(line, rows.normal)
        self.curves = curves_down_to(line, deepest)


def _foreseen(path: LoadingPath) -> list[Stretch]:
    """The largest targets of a path, where they are known before it is followed."""
    found: dict[str, float] = {}
    for leg in known_legs(path):
        if not isinstance(leg, Cycle):
            for name in NORMAL_CHANNELS:
                if (target := getattr(leg, name, None)) is not None:
                    found[name] = max(float(np.max(target)), found.get(name, 0.0))
    return [Stretch(Controls(name), np.array([most]), np.zeros(1)) for name, most in found.items()]


def _refuse_lifted(line: ElasticLine, force: FloatArray) -> None:
    certificate = certify_disk(line, states_at_force(line, np.array([float(np.max(force))])))
    if not certificate.disk.all():
        raise ProblemError(
            f"friction needs a contact that is a disk at every depth up to that of the load: {certificate.reason}"
        )


def disks_down_to(contact: Contact, line: ElasticLine, deepest: float) -> Certificate:
    """
    The certificate of all depths from the first touch on, of which tractions are sums of pressures.

    Raises
    ------
    ProblemError
        If the contact is not a disk at one of them.
    """
    certificate = certify_history(line, deepest)
    if not certificate.disk.all():
        raise ProblemError(
            f"friction needs a contact that is a disk at every depth up to {metres(deepest)}: "
            f"{certificate.reason}{noise_words(contact.profile, line.equivalent, deepest)}"
        )
    return certificate


def solve_frictional(
    contact: Contact,
    path: LoadingPath,
    machine_stiffness: float | None,
    keep: np.ndarray | None,
    progress: Progress | None,
) -> Result:
    """Map, follow and interpret."""
    assert contact.friction is not None
    moduli = effective_moduli(contact.body, contact.counterbody)
    origin = map_to_line(contact)
    line = _Line(contact, origin, machine_stiffness, curves_down_to(origin.line, 0.0))
    line.deepen(_foreseen(path))
    mu, tangential = contact.friction.coefficient, moduli.tangential
    state = virgin_state(mu, moduli.normal / tangential)
    here: dict[str, float] = {}
    controls = Controls()
    starts: list[Mapping[str, float]] = []
    found: list[FrictionHistory] = []
    loads: list[FloatArray] = []
    done, total, missed = 0, total_rows(path), np.zeros(len(_MEASURED))
    for number, leg in enumerate(known_legs(path), 1):
        rows = stretch(leg, controls, here)
        controls = rows.controls
        line.deepen([rows])
        size = rows.normal.size
        kept = None if keep is None else keep[(keep >= done) & (keep < done + size)] - done
        asked = friction_leg(line.mapped.line, rows, machine_stiffness)
        if _is_straight(rows, here, asked):
            history = _follow_in_parts(line.curves, asked, mu, tangential, state, kept, progress, done, total)
            _refuse_stopped(history, asked, line, number, history.stopped, mu)
            starts.append(here)
        else:
            history, parts, error = _follow_refined(line, rows, here, tangential, state, number)
            history = _taken(history, kept)
            missed = np.maximum(missed, error)
            starts.append({**here, PARTS: float(parts)})
        state = history.state
        found.append(history)
        loads.append(_forces(line.mapped.line, history, asked, kept))
        here = _end(line, rows, asked, state, history)
        done += size
        if progress is not None:
            progress(done, total)
    columns = _columns(line.mapped.line, found, np.concatenate(loads), tangential)
    if machine_stiffness is not None:
        columns["travel"] = columns["indentation"] + columns["normal_force"] / machine_stiffness
    return _interpret(contact, path, line, columns, keep, tuple(starts), machine_stiffness, missed)


def _follow_in_parts(
    curves: ElasticCurves,
    leg: FrictionLeg,
    mu: float,
    modulus: float,
    state: FrictionState,
    kept: np.ndarray | None,
    progress: Progress | None,
    done: int,
    total: int,
) -> FrictionHistory:
    """One leg, in parts where somebody watches its progress."""
    size = leg.normal.size
    if progress is None or size <= _CHUNK:
        return follow_leg(curves, leg, mu, modulus, state, kept)
    parts: list[FrictionHistory] = []
    for first in range(0, size, _CHUNK):
        last = min(first + _CHUNK, size)
        part = FrictionLeg(
            leg.by_normal_force, leg.by_tangential_force, leg.normal[first:last], leg.tangential[first:last]
        )
        chosen = None if kept is None else kept[(kept >= first) & (kept < last)] - first
        history = follow_leg(curves, part, mu, modulus, state, chosen)
        parts.append(history)
        state = history.state
        if last < size:
            progress(done + last, total)
        if history.ending is not Ending.COMPLETE:
            break
    return _joined(parts, kept)


def _is_straight(rows: Stretch, here: Mapping[str, float], leg: FrictionLeg) -> bool:
    """Whether the stack needs no rows between those of a leg: only a shift under a load or a travel does."""
    if leg.by_tangential_force or not (leg.by_normal_force or leg.normal is not rows.normal):
        return True
    return bool(refined(rows, here, 2).own[-1] + 1 == rows.normal.size)


def _follow_refined(
    line: _Line,
    rows: Stretch,
    here: Mapping[str, float],
    modulus: float,
    state: FrictionState,
    number: int,
) -> tuple[FrictionHistory, int, FloatArray]:
    """
    A leg that moves a shift together with a load or with the travel of a machine.

    Between rows the stack goes straight in (indentation, shift), so the moves are divided until that changes nothing.

    Returns
    -------
    FrictionHistory
        Its own rows.
    int
        Parts of every move.
    ndarray
        What is left of the errors of what is measured, of the largest values of the leg, if they go on falling as they did.
    """

    def run(parts: int) -> tuple[FrictionHistory, FrictionLeg, np.ndarray]:
        finer = refined(rows, here, parts)
        leg = friction_leg(line.mapped.line, finer.rows, line.stiffness)
        return follow_leg(line.curves, leg, state.friction, modulus, state, finer.own), leg, finer.own

    parts = 1
    error = before = np.full(len(_MEASURED), math.inf)
    history, leg, own = run(parts)
    while error.max() > _SETTLED:
        factor = 4 if 4 * leg.normal.size <= _REFINED else 2
        finer, leg, own = run(factor * parts)
        change = _change(history, finer)
        with np.errstate(divide="ignore", invalid="ignore"):
            rate = np.fmin(change / before, _SLOWEST)
        rate[~np.isfinite(before)] = _SLOWEST
        error = change * rate / (1.0 - rate)
        history, parts, before = finer, factor * parts, change
        if factor * leg.normal.size > _REFINED:
            break
    _refuse_stopped(history, leg, line, number, int(np.searchsorted(own, history.stopped)), state.friction)
    return replace(history, kept=None), parts, error


def _change(coarse: FrictionHistory, fine: FrictionHistory) -> FloatArray:
    """The largest differences of two runs of one leg, over its largest values."""
    if coarse.ending is not Ending.COMPLETE or fine.ending is not Ending.COMPLETE:
        return np.full(len(_MEASURED), math.inf)
    pairs = [(getattr(coarse, name), getattr(fine, name)) for name in _MEASURED]
    sizes = [max(float(np.max(np.abs(other))), math.ulp(0.0)) for _, other in pairs]
    return np.array(
        [np.max(np.abs(one - other)) / size for (one, other), size in zip(pairs, sizes, strict=True)]
    )


def _taken(history: FrictionHistory, kept: np.ndarray | None) -> FrictionHistory:
    """The kept rows of a history of all rows."""
    if kept is None:
        return history
    names = (
        "indentation",
        "shift",
        "tangential_force",
        "stick_radius",
        "stored_energy",
        "slip_work",
        "slip_distance",
    )
    return replace(history, kept=kept, **{name: getattr(history, name)[kept] for name in names})


def _joined(parts: list[FrictionHistory], kept: np.ndarray | None) -> FrictionHistory:
    def whole(name: str) -> FloatArray:
        return np.concatenate([getattr(part, name) for part in parts])

    return replace(
        parts[-1],
        kept=kept,
        indentation=whole("indentation"),
        shift=whole("shift"),
        tangential_force=whole("tangential_force"),
        stick_radius=whole("stick_radius"),
        stored_energy=whole("stored_energy"),
        slip_work=whole("slip_work"),
        slip_distance=whole("slip_distance"),
        stopped=sum(part.stopped for part in parts),
    )


def _refuse_stopped(
    history: FrictionHistory, leg: FrictionLeg, line: _Line, number: int, row: int, mu: float
) -> None:
    if history.ending is Ending.COMPLETE:
        return
    i = history.stopped
    where = f"row {row + 1} of leg {number}"
    if history.ending is Ending.NOT_ATTAINABLE and leg.by_tangential_force:
        pressed = leg.normal[i] if leg.by_normal_force else _force_at(line, float(leg.normal[i]))
        raise PathError(
            f"tangential_force = {newtons(leg.tangential[i])} in {where}: friction carries at most mu F_N = "
            f"{newtons(mu * pressed if pressed else 0.0)} there, beyond which the bodies slide apart; reduce it, or move "
            "the body with shift(...)"
        )
    raise PathError(f"{where} cannot be followed: {history.ending.value}")


def _force_at(line: _Line, depth: float) -> float:
    states = states_at_depth(line.mapped.line, np.array([depth]))
    return float(normal_force(line.mapped.line, states)[0])


def _forces(
    line: ElasticLine, history: FrictionHistory, leg: FrictionLeg, kept: np.ndarray | None
) -> FloatArray:
    if leg.by_normal_force:
        return leg.normal if kept is None else leg.normal[kept]
    return normal_force(line, states_at_depth(line, history.indentation))


def _end(
    line: _Line, rows: Stretch, leg: FrictionLeg, state: FrictionState, history: FrictionHistory
) -> dict[str, float]:
    last = follow_leg(
        line.curves,
        FrictionLeg(False, False, np.array([state.indentation]), np.array([state.shift])),
        state.friction,
        line.mapped.moduli.tangential,
        state,
    )
    d = state.indentation
    force = float(leg.normal[-1]) if leg.by_normal_force else _force_at(line, d)
    here = {
        "indentation": d,
        "normal_force": force,
        "travel": d + force / (line.stiffness or math.inf),
        "shift": state.shift,
        "tangential_force": float(last.tangential_force[0]),
    }
    here[rows.controls.normal] = float(rows.normal[-1])
    here[rows.controls.tangential] = float(rows.tangential[-1])
    return here


def _columns(
    line: ElasticLine, found: list[FrictionHistory], force: FloatArray, modulus: float
) -> dict[str, FloatArray]:
    def joined(name: str) -> FloatArray:
        return np.concatenate([getattr(history, name) for history in found])

    d = joined("indentation")
    states = states_at_depth(line, d)
    # a table of a(d) rounds otherwise than the line
    stick = np.minimum(joined("stick_radius"), states.contact_radius)
    return {
        "indentation": d,
        "normal_force": force,
        "contact_radius": states.contact_radius,
        "normal_stiffness": normal_stiffness(line, states),
        "mean_pressure": mean_pressure(force, states.contact_radius),
        "elastic_energy": elastic_energy(line, states),
        "shift": joined("shift"),
        "tangential_force": joined("tangential_force"),
        "tangential_stiffness": 2.0 * modulus * stick,
        "stick_radius": stick,
        "slip_distance": joined("slip_distance"),
        "stored_tangential_energy": joined("stored_energy"),
        "dissipated_energy": joined("slip_work"),
    }


def _interpret(
    contact: Contact,
    path: LoadingPath,
    line: _Line,
    columns: dict[str, FloatArray],
    keep: np.ndarray | None,
    starts: tuple[Mapping[str, float], ...],
    stiffness: float | None,
    missed: FloatArray,
) -> Result:
    """Step 3: quantities, claims and assumptions of every row that is kept."""
    assert contact.friction is not None
    moduli = line.mapped.moduli
    everywhere = np.ones(columns["shift"].size, dtype=bool)
    claims = frictional_claims(contact, moduli, tuple(columns), everywhere)
    if line.certificate is not None and line.certificate.error is not None:
        claims = approximated(claims, line.certificate.remark, float(line.certificate.error[0]))
    for name in (*TANGENTIAL_QUANTITIES, *TANGENTIAL_FIELDS):
        left = float(
            missed[_MEASURED.index("slip_work")] if name == "dissipated_energy" else missed[:-1].max()
        )
        if left > EXACT_WITHIN and name in claims:
            remark = f"; what lies between rows that move a load and a shift is followed to {left:.1g} of the largest value"
            claims |= approximated({name: claims[name]}, remark, left)
    at_deepest = states_at_depth(line.mapped.line, np.array([max(line.deepest, 0.0)]))
    claims = with_errors(claims, {}, map_remark(line.mapped.line, at_deepest))
    time = times(path)
    if time is not None:
        columns = {"time": time if keep is None else time[keep], **columns}
    return Result(
        contact=contact,
        path=path,
        data=labelled(columns, rows=keep),
        claims=claims,
        assumptions=frictional_assumptions(contact, line.mapped, columns["contact_radius"]),
        status=Status.COMPLETED,
        notes=line.mapped.notes,
        references=("sneddon", "popov-hess", "cattaneo-mindlin", "memory"),
        machine_stiffness=stiffness,
        starts=starts,
    )


def frictional_assumptions(contact: Contact, mapped: Mapped, radii: FloatArray) -> tuple[Assumption, ...]:
    """What the model assumes, with the similarity that friction needs."""
    assert contact.friction is not None
    listed = assumptions(contact, mapped, radii)
    similar = similarity_assumption(mapped.moduli, contact.friction.coefficient)
    return (*(a for a in listed if a.name != similar.name), similar)
