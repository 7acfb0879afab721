"""The contact with adhesion along a path: branches, jumps, pull-off."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pymdr.errors import PathError
from pymdr.interpretation.accuracy import adhesive_errors, with_errors
from pymdr.interpretation.adhesion import (
    Visited,
    adhesive_claims,
    certify_stretched_disk,
    energy_assumption,
    is_always_open,
    joined_visits,
)
from pymdr.interpretation.fields import edge_amplitude
from pymdr.interpretation.validity import BoolArray, Claim, Level, approximated
from pymdr.line.adhesion import JKR as ShortRange
from pymdr.line.adhesion import MaugisDugdale as Cohesive
from pymdr.line.adhesion import energy_release_rate, maugis_parameter, stress_intensity
from pymdr.line.following import History, energy_residual, follow
from pymdr.line.foundation import DiskStates, mean_pressure
from pymdr.mapping.series import Place
from pymdr.problem.contact import Contact
from pymdr.problem.laws import DMT, JKR
from pymdr.problem.paths import LoadingPath, Path, named_channels
from pymdr.problem.schedule import Controls, Progress, Stretch, known_legs, stretch, times, total_rows
from pymdr.result import Result, Status, labelled
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.reach import assumptions, map_remark
from pymdr.units import FloatArray, metres, newtons

_CONTROL = {"indentation": math.inf, "normal_force": 0.0}
"""Machine stiffness in N/m that stands for a prescribed channel."""


@dataclass(frozen=True)
class _Here:
    """Where the contact is between two legs."""

    parameter: float | None = None
    """None for a body that does not touch."""
    indentation: float = 0.0
    normal_force: float = 0.0
    travel: float = 0.0
    external_work: float = 0.0
    dissipated: float = 0.0
    energy: float = 0.0
    """Of contact and machine in J."""


@dataclass(frozen=True)
class _Rows:
    """What one leg gives, one entry per row."""

    parameter: FloatArray
    attached: BoolArray
    control: FloatArray
    """Stiffness in N/m of the machine that stands for the control."""
    indentation: FloatArray
    normal_force: FloatArray
    energy: FloatArray
    jumped: BoolArray
    jump_dissipation: FloatArray
    dissipated: FloatArray
    external_work: FloatArray
    residual: float
    events: tuple[_Event, ...]
    visited: Visited


@dataclass(frozen=True)
class _Event:
    """A jump into contact or out of it."""

    row: int
    into: bool
    indentation: float
    normal_force: float
    contact_radius: float


def solve_adhesive(
    contact: Contact, path: LoadingPath, machine_stiffness: float | None, progress: Progress | None
) -> Result:
    """Map, follow and interpret."""
    _check_adhesive_path(path)
    line = AdhesiveLine(contact)
    legs: list[_Rows] = []
    here, controls = _Here(), Controls()
    total, done = total_rows(path), 0
    for leg in known_legs(path):
        rows = stretch(leg, controls, vars(here))
        controls = rows.controls
        if not isinstance(leg, Path) and math.isnan(vars(here)[controls.normal]):
            raise PathError(
                "the contact was lost under a prescribed force and the body has no position from which a leg of "
                f"{controls.normal} could start; begin it with Path({controls.normal}=[...]), or go on with load(...)"
            )
        legs.append(_follow_leg(line, rows, here, machine_stiffness))
        here = _end_of(legs[-1], rows, machine_stiffness)
        done += rows.normal.size
        if progress is not None:
            progress(done, total)
    return _interpret(contact, path, line, _joined(legs), machine_stiffness)


def _check_adhesive_path(path: LoadingPath) -> None:
    for leg in known_legs(path):
        sideways = [name for name in named_channels(leg) if name in ("shift", "tangential_force")]
        if sideways:
            raise PathError(
                f"the path prescribes {sideways[0]}, but the contact is adhesive: adhesion with friction is not "
                "covered; leave the channel out"
            )


def _follow_leg(line: AdhesiveLine, asked: Stretch, here: _Here, stiffness: float | None) -> _Rows:
    channel, values = asked.controls.normal, asked.normal
    k = _CONTROL.get(channel, math.inf if stiffness is None else stiffness)
    by_force = k == 0.0
    track = line.track(k, float(np.max(values)), here.parameter or 0.0)
    if by_force and here.parameter is None and not math.isnan(here.indentation):
        _refuse_pull_on_nothing(values, float(track.curve.control(np.array([track.lost]))[0]))
    history = _with_falls(line, follow(track, values, here.parameter))
    attached = history.attached
    s = np.where(attached, history.parameter, line.equilibria.start)
    states = line.equilibria.states(s)
    elastic, surface = line.equilibria.energies(s)
    force = np.where(attached, values if by_force else states.normal_force, math.nan if by_force else 0.0)
    free_depth = np.full(values.shape, math.nan) if by_force else values
    depth = np.where(attached, values if channel == "indentation" else states.indentation, free_depth)
    machine = 0.0 if stiffness is None else np.where(attached, 0.5 * force * force / stiffness, 0.0)
    energy = np.where(attached, elastic + surface, 0.0) + machine
    spent = np.cumsum(history.dissipated)
    return _Rows(
        parameter=np.where(attached, history.parameter, math.nan),
        attached=attached,
        control=np.full(values.shape, k),
        indentation=depth,
        normal_force=force,
        energy=energy,
        jumped=history.jumped,
        jump_dissipation=history.dissipated,
        dissipated=here.dissipated + spent,
        # what goes in is stored or lost; the energy balance holds this against quadrature
        external_work=here.external_work + (energy - here.energy) + spent,
        residual=energy_residual(track, history),
        events=_events(line, history),
        visited=_visited(line, history, k),
    )


def _with_falls(line: AdhesiveLine, history: History) -> History:
    """The history with the energy lost where a dead load tore the contact off."""
    jumps = history.jumps
    falls = np.isnan(jumps.loss)
    if not falls.any():
        return history
    loss = jumps.loss.copy()
    loss[falls] = [
        line.fallen(float(s), float(force))
        for s, force in zip(jumps.before[falls], jumps.control[falls], strict=True)
    ]
    spent = np.bincount(jumps.step, weights=loss, minlength=history.control.size)
    return replace(history, jumps=replace(jumps, loss=loss), dissipated=spent.astype(float))


def _visited(line: AdhesiveLine, history: History, stiffness: float) -> Visited:
    """What a leg visits between its rows: the equilibria that lie on its stretches, and its jumps."""
    jumps, rows = history.jumps, history.control.size
    if is_always_open(line.line.equivalent, line.law):
        none = np.zeros(0)
        return Visited(rows, none.astype(int), *(none,) * 2, none.astype(int), *(none,) * 5)
    # the nodes of a row are both ends of its jumps, then the row itself
    row = np.concatenate([np.repeat(jumps.step, 2), np.arange(rows)])
    s = np.concatenate([np.stack([jumps.before, jumps.after], axis=1).ravel(), history.parameter])
    jumped = np.concatenate([np.tile([False, True], jumps.step.size), np.zeros(rows, dtype=bool)])
    order = np.argsort(row, kind="stable")
    row, s, jumped = row[order], s[order], jumped[order]
    a = np.where(np.isnan(s), 0.0, line.equilibria.states(np.nan_to_num(s)).contact_radius)
    first = (
        0.0 if math.isnan(history.initial) else float(line.equilibria.states(history.initial).contact_radius)
    )
    before = np.concatenate([[first], a[:-1]])
    smooth = ~jumped & ((a > 0.0) | (before > 0.0))
    return Visited(
        rows,
        row[smooth],
        before[smooth],
        a[smooth],
        row[jumped],
        np.full(int(jumped.sum()), stiffness),
        jumps.control,
        before[jumped],
        a[jumped],
        jumps.loss,
    )


def _events(line: AdhesiveLine, history: History) -> tuple[_Event, ...]:
    jumps = history.jumps
    into, out = np.isnan(jumps.before), np.isnan(jumps.after)
    states = line.equilibria.states(np.where(into, jumps.after, jumps.before))
    return tuple(
        _Event(
            int(jumps.step[i]),
            bool(into[i]),
            float(states.indentation[i]),
            float(states.normal_force[i]),
            float(states.contact_radius[i]),
        )
        for i in np.flatnonzero(into | out)
    )


def _refuse_pull_on_nothing(values: FloatArray, pull_off: float) -> None:
    if values[0] >= 0.0:
        return
    raise PathError(
        f"normal_force = {newtons(values[0])}: a body that does not touch cannot be pulled (the contact carries down "
        f"to {newtons(pull_off)} once it is made); touch first, for example with load('0 N') >> ..."
    )


def _end_of(rows: _Rows, asked: Stretch, stiffness: float | None) -> _Here:
    d, force = float(rows.indentation[-1]), float(rows.normal_force[-1])
    end = _Here(
        parameter=float(rows.parameter[-1]) if rows.attached[-1] else None,
        indentation=d,
        normal_force=force,
        travel=d + force / (stiffness or math.inf),
        external_work=float(rows.external_work[-1]),
        dissipated=float(rows.dissipated[-1]),
        energy=float(rows.energy[-1]),
    )
    if math.isnan(d) and not asked.by_force:
        return end
    return replace(end, **{asked.controls.normal: float(asked.normal[-1])})


def _joined(legs: list[_Rows]) -> _Rows:
    columns = {
        name: np.concatenate([getattr(leg, name) for leg in legs])
        for name in _Rows.__dataclass_fields__
        if name not in ("residual", "events", "visited")
    }
    first = np.cumsum([0, *(leg.attached.size for leg in legs)])
    events = tuple(
        replace(event, row=event.row + int(n))
        for leg, n in zip(legs, first[:-1], strict=True)
        for event in leg.events
    )
    visited = joined_visits([leg.visited for leg in legs])
    return _Rows(**columns, residual=max(leg.residual for leg in legs), events=events, visited=visited)


def _told(rows: _Rows, known: BoolArray) -> tuple[str, ...]:
    """The first jump into contact and the last out of it, in words."""
    events = [event for event in rows.events if known[event.row]]
    into = [event for event in events if event.into][:1]
    out = [event for event in events if not event.into][-1:]
    others = int(np.count_nonzero(rows.jumped & known)) - len({event.row for event in events})
    words = tuple(
        f"{'jumped into contact' if event.into else 'pulled off'} at "
        f"d = {metres(event.indentation)}, F = {newtons(event.normal_force)}, a = {metres(event.contact_radius)}"
        for event in (*into, *out)
    )
    return (*words, f"the contact jumped in {others} other steps") if others > 0 else words


def _interpret(
    contact: Contact, path: LoadingPath, line: AdhesiveLine, rows: _Rows, stiffness: float | None
) -> Result:
    """Step 3: quantities, claims and assumptions of every row."""
    equilibria, modulus = line.equilibria, line.line.modulus
    s = np.where(rows.attached, rows.parameter, equilibria.start)
    states = equilibria.states(s)
    lost = ~rows.attached & np.isnan(rows.indentation)
    blank = np.where(lost, math.nan, 0.0)

    def shown(values: FloatArray) -> FloatArray:
        return np.where(rows.attached, values, blank)

    a = shown(states.contact_radius)
    depth_rate, force_rate = equilibria.slopes(s)
    with np.errstate(divide="ignore", invalid="ignore"):
        stiffness_now = np.where(rows.attached & (s > equilibria.start), force_rate / depth_rate, 0.0)
    elastic, surface = equilibria.energies(s)
    columns: dict[str, FloatArray] = {
        "indentation": rows.indentation,
        "normal_force": rows.normal_force,
        "contact_radius": a,
        "normal_stiffness": shown(stiffness_now),
        "mean_pressure": np.where(lost, math.nan, mean_pressure(rows.normal_force, np.nan_to_num(a))),
        "elastic_energy": shown(elastic),
        "surface_energy": shown(surface),
        "external_work": rows.external_work,
        "jumped": rows.jumped.astype(float),
        "jump_dissipation": rows.jump_dissipation,
        "dissipated_energy": rows.dissipated,
    }
    if isinstance(equilibria, Cohesive):
        columns["cohesive_radius"] = shown(states.cohesive_radius)
    if isinstance(equilibria, ShortRange):
        columns |= _edge_columns(equilibria, s, rows.attached, blank, modulus)
    if stiffness is not None:
        columns["travel"] = rows.indentation + rows.normal_force / stiffness
    depths = np.where(rows.attached, rows.indentation, math.nan)
    certificate = certify_stretched_disk(line.line, rows.visited, line.law)
    claims = adhesive_claims(
        line.law, tuple(columns), certificate.disk, certificate.reason, _maugis(contact, modulus)
    )
    held = DiskStates(np.nan_to_num(depths), Place(np.zeros(a.shape), np.nan_to_num(a)), np.zeros(a.shape))
    errors = adhesive_errors(line.line, equilibria, s, rows.control)
    claims = with_errors(claims, errors, map_remark(line.line, held))
    balance = energy_assumption(rows.residual)
    if not balance.met:
        claims = approximated(
            claims, f"; work, energy and losses agree to {balance.measure:.1g} only", balance.measure
        )
    prescribed = {
        "indentation": np.isinf(rows.control),
        "normal_force": rows.control == 0.0,
        "travel": (rows.control > 0.0) & np.isfinite(rows.control),
    }
    for name, known in prescribed.items():
        if known.any() and not certificate.disk.all():
            source, where = claims["contact_radius"].source, certificate.disk | known
            claims[name] = Claim(Level.EXACT, "prescribed, or exact on a disk", source, where)
    valid = {
        name: values if claims[name].where.all() else np.where(claims[name].where, values, math.nan)
        for name, values in columns.items()
        if claims[name].readable
    }
    time = times(path)
    if time is not None:
        valid = {"time": time, **valid}
    return Result(
        contact=contact,
        path=path,
        data=labelled(valid),
        claims=claims,
        assumptions=(*assumptions(contact, line.origin, a), balance),
        status=_status(rows, certificate.disk),
        notes=(*line.origin.notes, *_told(rows, certificate.disk)),
        references=_references(line),
        machine_stiffness=stiffness,
    )


def _edge_columns(
    equilibria: ShortRange, s: FloatArray, attached: BoolArray, blank: FloatArray, modulus: float
) -> dict[str, FloatArray]:
    """The edge of a JKR contact: its amplitude, stress intensity and energy release rate."""
    a = equilibria.states(s).contact_radius
    opening = np.where(a > 0.0, equilibria.opening(s), 0.0)
    radius = np.where(a > 0.0, a, 1.0)
    columns = {
        "energy_release_rate": energy_release_rate(radius, opening, modulus),
        "stress_intensity": stress_intensity(radius, opening, modulus),
        "edge_amplitude": edge_amplitude(modulus, radius, -opening),
    }
    return {name: np.where(attached, values, blank) for name, values in columns.items()}


def _maugis(contact: Contact, modulus: float) -> float:
    """Maugis' parameter where radius and range are known, else nan."""
    law, radius = contact.adhesion, contact.profile.tip_radius
    if not isinstance(law, DMT) or law.range is None or radius is None:
        return math.nan
    return float(maugis_parameter(radius, modulus, law.work, law.work / law.range))


def _status(rows: _Rows, disk: BoolArray) -> Status:
    if not disk.any():
        return Status.ADHESION_REFUSED
    if not disk.all():
        return Status.ADHESION_PARTLY_REFUSED
    if rows.attached[-1]:
        return Status.ATTACHED
    return Status.PULLED_OFF if rows.attached.any() or rows.jumped.any() else Status.NOT_TOUCHED


def _references(line: AdhesiveLine) -> tuple[str, ...]:
    law = line.law
    theory = {JKR: ("jkr", "hess"), DMT: ("dmt", "maugis")}.get(type(law), ("maugis", "popov-hess"))
    return ("sneddon", "popov-hess", *(key for key in theory if key != "popov-hess"))
