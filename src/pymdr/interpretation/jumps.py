"""The path of a contact with adhesion between its rows: its equilibria and jumps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pymdr.interpretation.branches import Equilibria, equilibrium_curve, state_columns
from pymdr.interpretation.theories import equilibria_of
from pymdr.line.adhesion import JKR
from pymdr.line.curves import Line
from pymdr.line.following import (
    Edge,
    History,
    Track,
    follow,
    follow_with_hysteresis,
    parameter_reaching,
    trace,
    under_machine,
)
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath
from pymdr.problem.schedule import Stretch, planned
from pymdr.units import FloatArray

BoolArray = NDArray[np.bool_]

_TRAIL = 2000
"""Least number of points along a path."""
_GROWTH = 1.2


@dataclass(frozen=True)
class Jump:
    """A jump at constant travel, indentation or force."""

    states: Mapping[str, FloatArray]
    """Quantities by name, in SI units: before the jump and after it. A free body has radius 0; after pull-off under a
    prescribed force the indentation is nan."""
    outline: Mapping[str, FloatArray]
    """The equilibria between both ends: the loss is the area between them and the line of the jump in the plane of
    indentation (or travel) and force."""
    loss: float
    """Energy in J; nan for a free body under a dead load."""


@dataclass(frozen=True)
class Branches:
    """All equilibria of a contact with adhesion, and a path through them."""

    curve: Mapping[str, FloatArray]
    """Quantities along the curve of all equilibria by name, in SI units."""
    stable: BoolArray
    """Whether the states of the curve are stable under a control of the path."""
    jumps: tuple[Jump, ...]
    """Distinct jumps, in the order of their first occurrence."""
    trail: Mapping[str, FloatArray]
    """Quantities along the path, interpolated between few rows, with nan inside every jump."""
    complete: bool
    """Whether the trail covers the whole path; if rows were refused it has only the other rows, without jumps."""


def branches_of(
    contact: Contact,
    line: Line,
    path: LoadingPath,
    rows: Mapping[str, FloatArray],
    machine_stiffness: float | None,
    *,
    complete: bool = True,
) -> Branches:
    """
    All equilibria up to the largest contact of a solved path, with its jumps.

    Parameters
    ----------
    contact : Contact
        With a law of adhesion.
    rows : mapping of str to ndarray
        ``indentation``, ``normal_force``, ``contact_radius`` and, with a machine, ``travel`` of every row of the
        path; with a cohesive zone ``cohesive_radius``.
    machine_stiffness : float or None
        In N/m.
    complete : bool
        Whether no row was refused; otherwise the trail is the rows, without jumps.
    """
    assert contact.adhesion is not None
    radii = [rows[name] for name in ("contact_radius", "cohesive_radius") if name in rows]
    widest = max(float(np.nanmax(values, initial=0.0)) for values in radii)
    equilibria = equilibria_of(contact.adhesion, contact.profile, line, widest)
    legs = _stretches(path, rows, machine_stiffness)
    top = _largest_parameter(equilibria, rows)
    course = _followed(equilibria, legs, top) if complete else _Course()
    top = max(top, float(np.nanmax(course.nodes[:, _PARAMETER], initial=0.0)))
    curve = equilibrium_curve(equilibria, top, course.folds, machine_stiffness)
    stable = np.zeros(curve["parameter"].size, dtype=bool)
    for k in {k for _, k in legs}:
        stable |= under_machine(equilibria, top, k).slope(curve["parameter"]) > 0.0
    trail = _trail(equilibria, course.nodes, rows, machine_stiffness) if complete else rows
    _, kinds = np.unique(course.events[:, 1:5], axis=0, return_index=True)
    jumps = tuple(_jump(equilibria, course.events[i], machine_stiffness) for i in np.sort(kinds))
    return Branches(curve, stable, jumps, trail, complete)


def branches_of_edge(
    curves: tuple[JKR, JKR],
    path: LoadingPath,
    rows: Mapping[str, FloatArray],
    machine_stiffness: float | None,
    rim: float,
) -> Branches:
    """
    The curves of an edge that advances and recedes at two works of adhesion, and a solved path between them.

    Parameters
    ----------
    curves : tuple of JKR
        Of the advancing and of the receding edge.
    rows : mapping of str to ndarray
        As in :func:`branches_of`; none of them refused.
    rim : float
        Parameter in m of a sharp edge; inf without one.
    """
    legs = _stretches(path, rows, machine_stiffness)
    top = max(_largest_parameter(curve, rows) for curve in curves)
    trail: list[Mapping[str, FloatArray]] = []
    jumps: dict[tuple[float, ...], Jump] = {}
    state: Edge | None = None
    first, widest, before = 0, top, math.inf
    for part, k in legs:
        reached = max(top, state.parameter if state else 0.0)
        tracks = [_traced(curves[0], k, float(np.max(part.normal)), reached)]
        tracks.append(_traced(curves[1], k, -math.inf, tracks[0].curve.stop))
        widest = max(widest, tracks[0].curve.stop if tracks[0].curve.stop < 2.0 * top else top)
        initial = state and state.under(same=k == before)
        history = follow_with_hysteresis(tracks[0], tracks[1], part.normal, initial, rim)
        done = 0
        for motion in history.motions:
            curve = curves[0 if motion.direction > 0 else 1]
            trail.append({name: values[first + done : first + motion.first] for name, values in rows.items()})
            done = motion.first + motion.history.control.size
            events = _events(curve, motion.history, k, attached=math.isfinite(motion.history.initial))
            nodes = _nodes(motion.history, events, k)
            start = np.array([[0.0, k, math.nan, motion.history.initial]])
            states = {name: values[first + motion.first : first + done] for name, values in rows.items()}
            trail.append(_trail(curve, np.concatenate([start, nodes]), states, machine_stiffness))
            for event in events:
                jumps.setdefault(tuple(event[1:5]), _jump(curve, event, machine_stiffness))
        trail.append({name: values[first + done : first + part.normal.size] for name, values in rows.items()})
        state, first, before = history.end, first + part.normal.size, k
    both = [equilibrium_curve(curve, widest, (), machine_stiffness) for curve in curves]
    stable = []
    for curve, states in zip(curves, both, strict=True):
        slopes = [
            under_machine(curve, widest, k).slope(states["parameter"]) > 0.0 for k in {k for _, k in legs}
        ]
        stable.append(np.any(slopes, axis=0))
    whole = {name: np.concatenate([both[0][name], [math.nan], both[1][name]]) for name in both[0]}
    joined = {name: np.concatenate([part[name] for part in trail]) for name in rows}
    return Branches(
        whole, np.concatenate([stable[0], [False], stable[1]]), tuple(jumps.values()), joined, True
    )


def _largest_parameter(equilibria: Equilibria, rows: Mapping[str, FloatArray]) -> float:
    """A parameter in m near that of the largest contact of some rows, not above it."""

    def most(name: str) -> float:
        return float(np.nanmax(rows[name], initial=0.0)) if name in rows else 0.0

    return equilibria.parameter_below(most("contact_radius"), most("cohesive_radius"), most("indentation"))


_Legs = list[tuple[Stretch, float]]
"""Legs with the stiffness in N/m of the machine equivalent to their control."""

_ROW, _STIFFNESS, _CONTROL, _PARAMETER = range(4)
_BEFORE, _AFTER, _LOSS = 3, 4, 5
_FREE = -1.0
"""Parameter of a free body among the events; unlike nan it can be compared."""


@dataclass(frozen=True)
class _Course:
    """The states and jumps of a path."""

    nodes: FloatArray = field(default_factory=lambda: np.zeros((0, 4)))
    """Row, stiffness, control and parameter of all rows and of both ends of every jump; a free body has the
    parameter nan, and between the ends of a jump all are nan but the row."""
    events: FloatArray = field(default_factory=lambda: np.zeros((0, 6)))
    """Row, stiffness, control, parameters before and after, and loss in J of every jump."""
    folds: tuple[float, ...] = ()
    """Parameters of the folds."""


def _stretches(path: LoadingPath, rows: Mapping[str, FloatArray], machine_stiffness: float | None) -> _Legs:
    legs: _Legs = []
    state: dict[str, float] = {}
    known = {"indentation": math.inf, "normal_force": 0.0}
    machine = math.inf if machine_stiffness is None else machine_stiffness
    for leg in planned(path):
        part = leg.stretch(state)
        state = {name: float(values[leg.first + leg.size - 1]) for name, values in rows.items()} | part.end
        legs.append((part, known.get(leg.controls.normal, machine)))
    return legs


def _followed(equilibria: Equilibria, legs: _Legs, largest: float) -> _Course:
    highest: dict[float, float] = {}
    for part, k in legs:
        highest[k] = max(float(np.max(part.normal)), highest.get(k, -math.inf))
    tracks = {k: _traced(equilibria, k, top, largest) for k, top in highest.items()}
    nodes, events = [], []
    state, first = None, 0
    for part, k in legs:
        if state is not None and state > tracks[k].curve.stop:
            tracks[k] = _traced(equilibria, k, highest[k], state)
        history = follow(tracks[k], part.normal, state)
        events.append(_events(equilibria, history, k, attached=state is not None))
        nodes.append(_nodes(history, events[-1], k))
        for table in (events[-1], nodes[-1]):
            table[:, _ROW] += first
        state = float(history.parameter[-1]) if history.attached[-1] else None
        first += part.normal.size
    folds = tuple(float(s) for track in tracks.values() for s in track.turning)
    return _Course(np.concatenate(nodes), np.concatenate(events), folds)


def _traced(equilibria: Equilibria, k: float, top: float, largest: float) -> Track:
    """The curve up to a control value and beyond the largest contact, ending at a stable state."""
    end = equilibria.limit
    widest = min(1.001 * largest, end)
    curve = under_machine(equilibria, widest, k)
    while widest < end and not curve.slope(np.array([widest]))[0] > 0.0:
        widest = min(_GROWTH * widest, end)
    stop = parameter_reaching(curve.control, top, at_least=widest, limit=end)
    return trace(under_machine(equilibria, stop, k))


def _events(equilibria: Equilibria, history: History, k: float, *, attached: bool) -> FloatArray:
    """Jumps of a leg in order, including attachments and detachments without a loss."""
    jumps = history.jumps
    stiffness = np.full(jumps.step.size, k)
    table = np.stack(
        [jumps.step, stiffness, jumps.control, jumps.before, jumps.after, jumps.loss], axis=1, dtype=float
    )
    begin = equilibria.states(np.array([equilibria.start]))
    if begin.normal_force[0] != 0.0:
        was = np.concatenate([[attached], history.attached[:-1]])
        quiet = np.setdiff1d(np.flatnonzero(was != history.attached), jumps.step)
        ends = np.where(
            history.attached[quiet, None], [[math.nan, equilibria.start]], [[equilibria.start, math.nan]]
        )
        level = np.full((quiet.size, 1), begin.indentation[0])
        nothing = np.zeros((quiet.size, 1))
        table = np.concatenate([table, np.hstack([quiet[:, None], nothing + k, level, ends, nothing])])
    table[:, [_BEFORE, _AFTER]] = np.nan_to_num(table[:, [_BEFORE, _AFTER]], nan=_FREE)
    return table[np.argsort(table[:, _ROW], kind="stable")]


def _nodes(history: History, events: FloatArray, k: float) -> FloatArray:
    n = history.control.size
    rows = np.stack([np.arange(n), np.full(n, k), history.control, history.parameter], axis=1, dtype=float)
    ends = np.full((events.shape[0], 3, 4), math.nan)
    ends[:, :, _ROW] = events[:, None, _ROW]
    for i, name in ((0, _BEFORE), (2, _AFTER)):
        ends[:, i, _STIFFNESS], ends[:, i, _CONTROL] = k, events[:, _CONTROL]
        ends[:, i, _PARAMETER] = np.where(events[:, name] == _FREE, math.nan, events[:, name])
    nodes = np.concatenate([ends.reshape(-1, 4), rows])
    return nodes[np.argsort(nodes[:, _ROW], kind="stable")]


def _trail(
    equilibria: Equilibria, nodes: FloatArray, rows: Mapping[str, FloatArray], machine_stiffness: float | None
) -> dict[str, FloatArray]:
    """Quantities at the nodes and between nodes on one branch."""
    between = max(_TRAIL // rows["indentation"].size, 1)
    s = nodes[:, _PARAMETER]
    move = np.diff(s, prepend=math.nan)
    fraction = np.arange(1.0, between + 1.0) / between
    kept = (np.isfinite(move) & (move != 0.0))[:, None] | (fraction == 1.0)
    node = np.broadcast_to(np.arange(s.size)[:, None], kept.shape)[kept]
    at = np.where(fraction == 1.0, s[:, None], (s - move)[:, None] + move[:, None] * fraction)[kept]
    k, control = nodes[node, _STIFFNESS], nodes[node, _CONTROL]
    row = nodes[node, _ROW].astype(int)
    # the solved rows are the last nodes of their row
    solved = np.diff(row, append=-1) != 0
    distinct, back = np.unique(at[~solved & np.isfinite(at)], return_inverse=True)
    columns = state_columns(equilibria, distinct, machine_stiffness)
    free = _free_body(k, control, math.nan)
    trail = {}
    for name, values in rows.items():
        trail[name] = np.where(solved, values[row], free[name])
        trail[name][~solved & np.isfinite(at)] = columns[name][back]
    return trail


def _free_body(k: FloatArray, control: FloatArray, depth: float) -> dict[str, FloatArray]:
    """A free body: at the controlled travel or indentation, under a controlled force at a given depth."""
    by_force = k == 0.0
    inside_jump = np.isnan(control)
    nothing = np.where(inside_jump, math.nan, 0.0)
    at = np.where(by_force, depth, control)
    return {
        "indentation": at,
        "normal_force": np.where(by_force, control, nothing),
        "contact_radius": nothing,
        "cohesive_radius": nothing,
        "travel": at,
    }


def _jump(equilibria: Equilibria, event: FloatArray, machine_stiffness: float | None) -> Jump:
    """Both ends of a jump, and the equilibria between them."""
    before, after = (float(event[i]) for i in (_BEFORE, _AFTER))
    low, high = (equilibria.start if s == _FREE else s for s in (before, after))
    graded = np.linspace(0.0, 1.0, 601) ** 2
    between = state_columns(equilibria, low + (high - low) * graded, machine_stiffness)
    if high < low:
        between = state_columns(equilibria, high + (low - high) * graded[::-1], machine_stiffness)
    k, control = event[[_STIFFNESS]], event[[_CONTROL]]
    fallen = _free_body(k, control, math.nan)
    ends = [
        _free_body(k, control, equilibria.touch)
        if before == _FREE
        else {n: x[:1] for n, x in between.items()},
        fallen if after == _FREE else {n: x[-1:] for n, x in between.items()},
    ]
    states = {name: np.concatenate([end[name] for end in ends]) for name in between}
    outline = {name: np.concatenate([states[name][:1], x, states[name][1:]]) for name, x in between.items()}
    return Jump(states, outline, float(event[_LOSS]))
