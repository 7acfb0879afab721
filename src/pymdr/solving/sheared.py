"""The contact of JKR under shear without slip along a path: its edge follows the curve of the present shift."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from pymdr.errors import PathError, ProblemError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.adhesion import is_always_open
from pymdr.interpretation.adhesive_accuracy import adhesive_errors
from pymdr.interpretation.full_stick import PunchTraction, difference_of_views, statement
from pymdr.interpretation.validity import NORMAL_FIELDS, BoolArray, Claim, with_prescribed
from pymdr.line.adhesion import ShearedJKR
from pymdr.line.following import Jumps, Track, settled, trace, under_machine
from pymdr.line.foundation import mean_pressure
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.schedule import Stretch, is_planar
from pymdr.result import Result, Status
from pymdr.solving.adhesive import refuse_pull_on_nothing
from pymdr.solving.adhesive_rows import stiffness_of
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.mapped import assumptions
from pymdr.solving.normal import refuse_tangential
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

FREE, ATTACHED, SLIPPED = range(3)


@dataclass(frozen=True)
class Edge:
    """State of the contact."""

    kind: int = FREE
    parameter: float = math.nan
    unsheared: float = math.nan
    """Parameter of JKR without shear on the same path; NaN without such a contact."""
    origin: float = 0.0
    """Shift in m at which the contact formed."""


@dataclass(frozen=True)
class Rows:
    """Columns of a walk, one entry per row."""

    edges: np.ndarray
    """An :class:`Edge` per row."""
    value: FloatArray
    """The prescribed normal channel."""
    shift: FloatArray
    control: FloatArray
    """Machine stiffness in N/m equivalent to the control."""
    jumped: BoolArray

    @property
    def kind(self) -> np.ndarray:
        """FREE, ATTACHED or SLIPPED."""
        return np.array([one.kind for one in self.edges])

    def of(self, name: str) -> FloatArray:
        """A number of every edge."""
        return np.array([getattr(one, name) for one in self.edges], dtype=float)


@dataclass
class ShearedLine:
    """The curves of a contact by its shear.

    Parameters
    ----------
    line : AdhesiveLine
        Without shear.
    tangential : float
        G* in Pa.
    """

    line: AdhesiveLine
    tangential: float
    _kept: tuple[tuple[float, float, float], Track | None] = field(
        default=((math.nan, math.nan, math.nan), None)
    )

    def curve(self, shift: float | FloatArray) -> ShearedJKR:
        """The states at shifts in m since the contact formed."""
        return ShearedJKR(self.line.line, self.line.law.work, self.tangential * shift * shift)

    def track(self, k: float, shift: float, plain: Track) -> Track | None:
        """The curve at a shift under a control, as far as that without shear; None if no state is stable."""
        if shift == 0.0:
            return plain
        key = k, shift, plain.curve.stop
        if self._kept[0] != key:
            curve, track = self.curve(shift), None
            if curve.start < min(plain.curve.stop, self.line.line.edge):
                try:
                    track = trace(under_machine(curve, plain.curve.stop, k))
                except PathError:
                    # no state of this shift is stable
                    track = None
            self._kept = key, track
        return self._kept[1]

    def moved(self, edge: Edge, plain: Track, k: float, control: float, shift: float) -> tuple[Edge, bool]:
        """The edge at a control and a shift, from the one before, and whether it jumps."""
        touches = control >= plain.touch
        free = Edge(origin=shift)
        if edge.kind == SLIPPED:
            return (free if k != 0.0 and not touches else edge), False
        if edge.kind == FREE:
            s = settled(plain, plain.curve.start, control)[0] if touches else math.nan
            return (Edge(ATTACHED, s, s, shift) if touches else free), touches
        unsheared = edge.unsheared
        if not math.isnan(unsheared):
            unsheared, _ = settled(plain, unsheared, control)
        track = self.track(k, shift - edge.origin, plain)
        s, jumped = (math.nan, True) if track is None else settled(track, edge.parameter, control)
        if math.isnan(s):
            return (Edge(SLIPPED) if touches else free), True
        return replace(edge, parameter=s, unsheared=unsheared), jumped

    def step(
        self,
        stiffness: float | None,
        edge: Edge,
        stretch: Stretch,
        kept: np.ndarray | None,
        progress: LegProgress | None,
    ) -> tuple[Rows, Edge, Channels]:
        """Step 2: the edge of every row."""
        if kept is not None:
            raise PathError("keep= is not available for adhesion under shear; leave it out")
        values, k = stretch.normal, stiffness_of(stretch, stiffness)
        plain = self.line.track(k, float(np.max(values)), 0.0 if edge.kind == FREE else _above(edge))
        if k == 0.0 and edge.kind == FREE:
            refuse_pull_on_nothing(values, float(plain.curve.control(np.array([plain.pull_off]))[0]))
        edges, jumped = np.empty(values.size, dtype=object), np.zeros(values.size, dtype=bool)
        for i, (value, shift) in enumerate(zip(values.tolist(), stretch.tangential.tolist(), strict=True)):
            edge, jumped[i] = self.moved(edge, plain, k, value, shift)
            edges[i] = edge
        rows = Rows(edges, values, stretch.tangential, np.full(values.size, k), jumped)
        d, force = self.state(rows)
        here = channels_at(float(d[-1]), float(force[-1]), stiffness)
        return rows, edge, {**here, "shift": float(stretch.tangential[-1])}

    def state(self, rows: Rows) -> tuple[FloatArray, FloatArray]:
        """Indentation in m and normal force in N of rows; NaN where they are not known."""
        kind, by_force = rows.kind, rows.control == 0.0
        attached = kind == ATTACHED
        curve = self.curve(np.where(attached, rows.shift - rows.of("origin"), 0.0))
        states = curve.states(np.where(attached, rows.of("parameter"), 0.0))
        known = kind != SLIPPED
        depth = np.where(attached, states.indentation, np.where(known & ~by_force, rows.value, math.nan))
        force = np.where(attached, states.normal_force, np.where(known & ~by_force, 0.0, math.nan))
        return np.where(np.isinf(rows.control), rows.value, depth), np.where(by_force, rows.value, force)


def _above(edge: Edge) -> float:
    return max(0.0 if math.isnan(each) else each for each in (edge.parameter, edge.unsheared))


def solve_sheared(task: Task) -> Result:
    """Map, walk and interpret."""
    refuse_tangential(
        task.path,
        "adhesion under shear is covered for one shift only; prescribe shift",
        ("tangential_force", "twist", "torque"),
    )
    if is_planar(task.path):
        raise PathError(
            "the path prescribes shift as pairs, but adhesion under shear is covered along one line; give single numbers"
        )
    line = AdhesiveLine(task.contact)
    if not is_always_open(line.line, line.law):
        raise ProblemError(
            "the equivalent profile decreases somewhere, or is not known to increase: whether the surfaces touch outside a sheared contact is "
            "not checked; use an increasing profile, or leave friction out"
        )
    sheared = ShearedLine(line, line.origin.moduli.tangential)
    walked = walk(task, Edge(), partial(sheared.step, task.machine_stiffness))
    return solution(task, walked, _interpret(task, sheared, walked))


def sheared_traction(result: Result) -> PunchTraction:
    """The source of the shear traction."""
    force, a = (result.data[name].values for name in ("tangential_force", "contact_radius"))
    tangential = effective_moduli(result.contact.body, result.contact.counterbody).tangential
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = np.where(a > 0.0, force / (2.0 * tangential * a), 0.0)
    return PunchTraction(tangential, shift, a)


def _interpret(task: Task, sheared: ShearedLine, walked: Walked[Rows]) -> Interpretation:
    """Step 3: quantities, claims and assumptions of every row."""
    rows, line = walked.rows, sheared.line
    kind = rows.kind
    attached, slipped = kind == ATTACHED, kind == SLIPPED
    unknown = slipped | ((kind == FREE) & (rows.control == 0.0))
    u = np.where(attached, rows.shift - rows.of("origin"), 0.0)
    curve, s = sheared.curve(u), np.where(attached, rows.of("parameter"), 0.0)
    columns = _columns(sheared, rows, curve, s, u, np.where(unknown, math.nan, 0.0))
    columns = with_travel(task, columns)
    everywhere = np.ones(kind.size, dtype=bool)
    said = Claim(*statement(line.origin.moduli), everywhere)
    claims = dict.fromkeys((*columns, *NORMAL_FIELDS, "shear_traction"), said)
    claims = with_errors(claims, _errors(sheared, rows, curve, s, columns))
    prescribed = {
        "shift": everywhere,
        "indentation": np.isinf(rows.control),
        "normal_force": rows.control == 0.0,
    }
    if task.machine_stiffness is not None:
        prescribed["travel"] = (rows.control > 0.0) & np.isfinite(rows.control)
    claims = with_prescribed(claims, everywhere, prescribed)
    if unknown.any():
        why = f"; not valid at {int(unknown.sum())} of {kind.size} steps: the contact has slipped, or a dead load has separated the bodies"
        claims = {
            name: one
            if name in ("shift", "jumped")
            else replace(one, where=one.where & ~unknown, reason=f"{one.reason}{why}")
            for name, one in claims.items()
        }
    status = Status.ATTACHED if attached[-1] else Status.PULLED_OFF if attached.any() else Status.NOT_TOUCHED
    opening = np.where(attached, curve.opening(s), 0.0)
    return Interpretation(
        columns=columns,
        claims=claims,
        assumptions=assumptions(task.contact, line.origin, columns["contact_radius"], -opening),
        status=Status.SLIPPED if slipped.any() else status,
        notes=(*line.origin.notes, *line.unsmoothed, *_notes(kind, columns)),
        references=("sneddon", "popov-hess", "jkr", "hess", "savkoor-briggs"),
        starts=walked.starts,
    )


def _columns(
    sheared: ShearedLine, rows: Rows, curve: ShearedJKR, s: FloatArray, u: FloatArray, blank: FloatArray
) -> dict[str, FloatArray]:
    """Quantities of the rows; `blank` is 0 for a free body and NaN where it is unknown."""
    attached, line = rows.kind == ATTACHED, sheared.line.line

    def shown(values: FloatArray) -> FloatArray:
        return np.where(attached, values, blank)

    depth, force = sheared.state(rows)
    a, opening = curve.states(s).contact_radius, curve.opening(s)
    rates, tangential = curve.slopes(s), 2.0 * sheared.tangential * a * u
    with np.errstate(divide="ignore", invalid="ignore"):
        stiffness = rates[1] / rates[0]
        released = line.stiffness_rate(a) * np.maximum(opening, 0.0) ** 2 + 2.0 * curve.shear
        released = released / (4.0 * math.pi * a)
    elastic, surface = curve.energies(s, depth)
    return {
        "indentation": depth,
        "normal_force": force,
        "contact_radius": shown(a),
        "normal_stiffness": shown(stiffness),
        "mean_pressure": blank + np.nan_to_num(mean_pressure(force, np.where(attached, a, 0.0))),
        "elastic_energy": shown(elastic),
        "surface_energy": shown(surface),
        "energy_release_rate": shown(released),
        "shift": rows.shift,
        "tangential_force": shown(tangential),
        "stored_tangential_energy": shown(0.5 * tangential * u),
        "jumped": rows.jumped.astype(float),
    }


def _errors(
    sheared: ShearedLine, rows: Rows, curve: ShearedJKR, s: FloatArray, columns: dict[str, FloatArray]
) -> dict[str, FloatArray]:
    """Errors from the map of the profile, and the difference of the two views of shear."""
    line, none = sheared.line.line, np.zeros(s.size)
    lossless = {**columns, "dissipated_energy": none, "jump_dissipation": none}
    jumps = Jumps(np.zeros(0, dtype=np.intp), *(np.zeros(0),) * 4)
    errors = adhesive_errors(line, curve, s, rows.control, lossless, jumps, 0.0)
    attached, plain = rows.kind == ATTACHED, rows.of("unsheared")
    unresolved = attached & np.isnan(plain)
    here, there = curve.states(s), sheared.line.equilibria.states(np.where(np.isnan(plain), s, plain))
    w = np.abs(curve.opening(s))
    a = here.contact_radius
    sizes = a, np.abs(line.depth(a)) + w, np.abs(line.force(a)) + line.stiffness(a) * w
    views = difference_of_views(
        (a, here.indentation, here.normal_force),
        (there.contact_radius, there.indentation, there.normal_force),
        sizes,
    )
    views = np.where(unresolved, 1.0, np.where(attached, views, 0.0))
    names = (*columns, *NORMAL_FIELDS, "shear_traction")
    return {name: np.minimum(errors.get(name, none) + views, 1.0) for name in names if name != "jumped"}


def _notes(kind: np.ndarray, columns: dict[str, FloatArray]) -> tuple[str, ...]:
    """Notes on the first slip and the last loss of contact."""
    notes: list[str] = []
    for event, after in (("slipped", SLIPPED), ("pulled off", FREE)):
        rows = np.flatnonzero((kind[:-1] == ATTACHED) & (kind[1:] == after))
        if rows.size:
            row = int(rows[-1])
            u, a, tangential = (
                float(columns[name][row]) for name in ("shift", "contact_radius", "tangential_force")
            )
            notes.append(
                f"{event} after row {row}, shift = {metres(u)}, a = {metres(a)}, tangential force = {newtons(tangential)}"
            )
    return tuple(notes)
