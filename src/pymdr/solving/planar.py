"""The contact with friction along a path in the plane, leg by leg."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.interpretation.certificate import with_rings
from pymdr.interpretation.interior import stress_claim
from pymdr.interpretation.plane import planar_claims
from pymdr.interpretation.validity import Claim
from pymdr.line.foundation import (
    elastic_energy,
    mean_pressure,
    normal_force,
    normal_stiffness,
    states_at_depth,
    states_at_force,
    states_at_travel,
)
from pymdr.line.plane import (
    PlaneEnding,
    PlaneLaw,
    PlaneRows,
    PlaneState,
    Springs,
    follow_plane,
    virgin_plane,
)
from pymdr.problem.contact import Contact
from pymdr.problem.paths import Cycle, History, Hold, LoadingPath, Path, Ramp
from pymdr.problem.profiles import Shape
from pymdr.problem.schedule import PLANE_CHANNELS, Stretch, is_torsional, known_legs, refined, uses
from pymdr.result import Result, Status
from pymdr.rows import taken
from pymdr.solving.frictional import disks_down_to, frictional_assumptions, glide_notes, solve_frictional
from pymdr.solving.mapped import Springs as MappedSprings
from pymdr.solving.mapped import map_to_springs, refuse_unreachable
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
from pymdr.units import FloatArray, newtons

_FEWEST, _MOST = 48, 1536
"""Springs of the first solution, and of the last: each has twice as many as the one before."""
_WANTED = 2e-4
"""Change of the force by half the springs, over the largest mu F_N: about twice the error of the force."""
_WANTED_SHIFT = 2e-3
"""Change of the shift by half the springs under prescribed forces, over the largest shift."""
_WANTED_DISSIPATION = 0.05
"""Change of the dissipated energy by half the springs, over the largest: few springs would miss a zone of slip that is narrower than their cells."""
_WORK = 1e8
"""Rows times springs up to which more springs are taken."""
_SETTLED = 1e-5
"""Change of a leg by further division, over its largest force."""
_REFINED = 100_000
_ON_LINE = 1e-15
"""Distance of a target from a line through the origin, relative to it, that is rounding."""


@dataclass(frozen=True)
class Rows:
    """Columns of a walk."""

    followed: PlaneRows
    indentation: FloatArray
    normal_force: FloatArray
    missed: FloatArray
    """Change of the force by further division of rows, in N."""


@dataclass
class PlanarLaw:
    """Springs with vectors along the legs of a path."""

    mapped: MappedSprings
    machine_stiffness: float | None
    law: PlaneLaw
    springs: Springs
    parts: dict[int, tuple[int, float]] = field(default_factory=dict)
    """Parts of rows that move a load and a shift at once by leg, and the remaining change in N."""
    glides: bool = False
    """Whether a prescribed force exceeded friction, so that the body glides."""
    stop: int | None = None
    """A row of the path at which `stopped` is taken."""
    stopped: PlaneState | None = None

    def step(
        self, state: PlaneState, stretch: Stretch, kept: np.ndarray | None, progress: LegProgress | None
    ) -> tuple[Rows, PlaneState, Channels]:
        """Step 2: the springs, from the state of the leg before."""
        number = stretch.leg.number
        if number not in self.parts:
            self.parts[number] = self._divided(state, stretch)
        parts, missed = self.parts[number]
        finer = refined(stretch, parts)
        first = stretch.leg.first
        if self.stop is not None and first <= self.stop < first + stretch.normal.size:
            end = int(finer.own[self.stop - first]) + 1
            self.stopped = self._follow(finer.rows.taken(slice(0, end)), state)[1]
        followed, state = self._follow(finer.rows, state)
        rows = taken(followed, finer.own)
        depth = depths_of(self.mapped, stretch, self.machine_stiffness)
        force = _forces(self.mapped, stretch, depth)
        gathered = Rows(rows, depth, force, np.full(depth.size, missed))
        here = channels_at(float(depth[-1]), float(force[-1]), self.machine_stiffness)
        last = {"shift": rows.shift[-1].copy(), "tangential_force": rows.force[-1].copy()}
        return taken(gathered, kept), state, {**here, **last}

    def _divided(self, state: PlaneState, stretch: Stretch) -> tuple[int, float]:
        """Into how many parts rows that move a load and a shift at once are divided, and what division still changes."""
        rigid = self.machine_stiffness is None or math.isinf(self.machine_stiffness)
        straight = stretch.controls.normal == "indentation" or (stretch.controls.normal == "travel" and rigid)
        if straight or stretch.controls.tangential == "tangential_force":
            return 1, 0.0
        parts, change, coarse = 1, 0.0, None
        while refined(stretch, 2 * parts).own.size < refined(stretch, 2 * parts).rows.normal.size:
            if coarse is None:
                coarse = self._follow(stretch, state)[0].force
            parts *= 4
            finer = refined(stretch, parts)
            force = self._follow(finer.rows, state)[0].force[finer.own]
            change = float(np.nanmax(np.abs(force - coarse), initial=0.0))
            coarse = force
            if change <= _SETTLED * float(np.nanmax(np.abs(force), initial=0.0)):
                break
            if 4 * finer.rows.normal.size > _REFINED:
                break
        return parts, change

    def _radius(self, depth: FloatArray) -> dict[str, FloatArray]:
        return {"radius": states_at_depth(self.mapped.line, depth).contact_radius}

    def _follow(self, stretch: Stretch, state: PlaneState) -> tuple[PlaneRows, PlaneState]:
        depth = depths_of(self.mapped, stretch, self.machine_stiffness)
        radius = _by_distinct(depth, self._radius)["radius"]
        pulled = stretch.controls.tangential == "tangential_force"
        load = _forces(self.mapped, stretch, depth) if pulled else None
        target = np.full((depth.size, 2), math.nan) if self.glides else stretch.tangential
        if self.glides or np.isnan(target).any():
            nothing = np.full((depth.size, 2), math.nan)
            return PlaneRows(nothing, nothing, *nothing[:, :1].T.repeat(4, axis=0)), state
        rows, state, ending = follow_plane(self.law, self.springs, depth, radius, target, state, load)
        if ending is PlaneEnding.NOT_CONVERGED:
            i = int(np.argmax(np.isnan(rows.stored)))
            force = " and ".join(newtons(float(f)) for f in stretch.tangential[i])
            raise ConvergenceError(
                f"no shift found for tangential_force = {force} in {stretch.row(i)}; take more rows, or move the body with shift(...)"
            )
        self.glides = self.glides or ending is PlaneEnding.NOT_ATTAINABLE
        return rows, state


def depths_of(mapped: MappedSprings, stretch: Stretch, machine_stiffness: float | None) -> FloatArray:
    """Indentation in m of every row of a leg."""
    line, targets = mapped.line, stretch.normal
    soft = machine_stiffness is not None and math.isfinite(machine_stiffness)

    def solve(values: FloatArray) -> dict[str, FloatArray]:
        if stretch.by_force:
            return {"depth": states_at_force(line, values).indentation}
        assert machine_stiffness is not None
        return {"depth": states_at_travel(line, values, machine_stiffness).indentation}

    if stretch.by_force or (stretch.controls.normal == "travel" and soft):
        return _by_distinct(targets, solve)["depth"]
    return targets


def _forces(mapped: MappedSprings, stretch: Stretch, depth: FloatArray) -> FloatArray:
    if stretch.by_force:
        return stretch.normal

    def solve(depths: FloatArray) -> dict[str, FloatArray]:
        return {"force": normal_force(mapped.line, states_at_depth(mapped.line, depths))}

    return _by_distinct(depth, solve)["force"]


def check_planar(contact: Contact, path: LoadingPath, by_rings: bool) -> None:
    """Refuse contacts that cannot be moved in the plane."""
    why = None
    if contact.friction is None:
        why = "a frictionless contact carries no tangential force; give Contact(..., friction=Coulomb(0.3))"
    elif contact.is_viscoelastic:
        why = "springs with memory are followed along one line only; prescribe one number per leg"
    elif contact.adhesion is not None:
        why = "Coulomb's limit is not defined where the surfaces attract each other; leave adhesion out"
    elif isinstance(contact.profile, Shape):
        why = "the body is not of revolution; shifts need an axisymmetric profile"
    elif by_rings:
        why = "rings are frictionless; leave solver=Rings() out"
    elif is_torsional(path):
        why = "slip under a shift and a twist at once does not superpose; solve them one by one"
    if why is not None:
        raise ProblemError(f"the path shifts the body in the plane: {why}")


def solve_planar(task: Task) -> Result:
    """Map, walk and interpret; a path that stays on one line is solved by the exact stack along it."""
    direction = line_of_path(task.path)
    if direction is not None:
        return _along_line(task, direction)
    contact, mapped = task.contact, map_to_springs(task.contact)
    deepest, stretch = _deepest(task, mapped)
    states = states_at_depth(mapped.line, np.array([max(deepest, 0.0)]))
    with stretch.leg.named():
        refuse_unreachable(
            mapped.line, contact.profile, states, float(stretch.normal.max()) if stretch.by_force else None
        )
        certificate = disks_down_to(contact, mapped.line, max(deepest, 0.0))
    law, walked, missed = _followed(task, mapped, float(states.contact_radius[0]))
    interpretation = _interpret(task, law, walked, missed)
    return solution(
        task, walked, replace(interpretation, claims=with_rings(interpretation.claims, certificate))
    )


def _law(task: Task, mapped: MappedSprings, radius: float, n: int) -> PlanarLaw:
    assert task.contact.friction is not None
    moduli = mapped.moduli
    law = PlaneLaw(task.contact.friction.coefficient, moduli.normal, moduli.tangential)
    return PlanarLaw(mapped, task.machine_stiffness, law, Springs.along(mapped.line, max(radius, 1e-300), n))


def _deepest(task: Task, mapped: MappedSprings) -> tuple[float, Stretch]:
    """The largest indentation in m of a path, and its leg."""
    depths: list[tuple[float, Stretch]] = []

    def step(
        state: None, stretch: Stretch, kept: np.ndarray | None, progress: LegProgress | None
    ) -> tuple[FloatArray, None, Channels]:
        if stretch.by_force:
            refuse_tension(stretch.leg, stretch.normal)
        depth = depths_of(mapped, stretch, task.machine_stiffness)
        depths.append((float(np.max(depth)), stretch))
        force = _forces(mapped, stretch, depth[-1:] if not stretch.by_force else depth)
        return depth, None, channels_at(float(depth[-1]), float(force[-1]), task.machine_stiffness)

    walk(replace(task, keep=None, progress=None), None, step)
    return max(depths, key=lambda one: one[0])


def _followed(
    task: Task, mapped: MappedSprings, radius: float
) -> tuple[PlanarLaw, Walked[Rows], dict[str, FloatArray]]:
    """A path with as many springs as its error asks for, and the errors of its rows by half of them."""
    law = _law(task, mapped, radius, _FEWEST)
    walked = walk(task, virgin_plane(law.springs), law.step)
    n, many = _FEWEST, min(_MOST, _WORK / max(walked.rows.indentation.size, 1))
    while True:
        n *= 2
        coarse, law = walked.rows.followed, _law(task, mapped, radius, n)
        walked = walk(task, virgin_plane(law.springs), law.step)
        fine = walked.rows.followed
        missed = {
            "tangential_force": _largest_so_far(np.hypot(*(fine.force - coarse.force).T))
            + walked.rows.missed,
            "shift": _largest_so_far(np.hypot(*(fine.shift - coarse.shift).T)),
            "dissipated_energy": _largest_so_far(np.abs(fine.slip_work - coarse.slip_work)),
            "stick_radius": np.full(walked.rows.missed.size, law.springs.spacing),
        }
        force = _WANTED * law.law.scale * float(np.max(walked.rows.normal_force, initial=0.0))
        shift = _WANTED_SHIFT * float(np.nanmax(np.abs(fine.shift), initial=0.0))
        slips = 0.0 < law.law.friction < math.inf and not law.glides
        settled = (
            np.nanmax(missed["tangential_force"] - walked.rows.missed, initial=0.0) <= force
            and np.nanmax(missed["shift"], initial=0.0) <= shift
            and (not slips or _work_is_settled(fine.slip_work, missed["dissipated_energy"]))
        )
        if 2 * n > many or settled:
            return law, walked, missed


def _work_is_settled(work: FloatArray, change: FloatArray) -> bool:
    """Whether half the springs change the work little; none at all may be missed."""
    return (
        0.0
        < float(np.nanmax(work, initial=0.0))
        >= float(np.nanmax(change, initial=0.0)) / _WANTED_DISSIPATION
    )


def _largest_so_far(change: FloatArray) -> FloatArray:
    """The errors of rows: borders of slip cross springs one after the other, so that the change of one row may be 0."""
    return np.asarray(np.fmax.accumulate(change))


def _by_distinct(
    values: FloatArray, solve: Callable[[FloatArray], Mapping[str, FloatArray]]
) -> dict[str, FloatArray]:
    """Columns over values that may repeat, such as the depths of a held load, each solved once."""
    if values.size > 1 and np.all(values == values[0]):
        return {name: np.repeat(column, values.size) for name, column in solve(values[:1]).items()}
    distinct, rows = np.unique(values, return_inverse=True)
    return {name: column[rows] for name, column in solve(distinct).items()}


def _interpret(
    task: Task, law: PlanarLaw, walked: Walked[Rows], missed: Mapping[str, FloatArray]
) -> Interpretation:
    """Step 3: quantities, claims and assumptions of every kept row."""
    rows, line = walked.rows, law.mapped.line
    followed, contact = rows.followed, task.contact

    def normal(depth: FloatArray) -> dict[str, FloatArray]:
        states = states_at_depth(line, depth)
        return {
            "contact_radius": states.contact_radius,
            "normal_stiffness": normal_stiffness(line, states),
            "elastic_energy": elastic_energy(line, states),
        }

    pressed = _by_distinct(rows.indentation, normal)
    radius = pressed["contact_radius"]
    columns = {
        "indentation": rows.indentation,
        "normal_force": rows.normal_force,
        "contact_radius": radius,
        "normal_stiffness": pressed["normal_stiffness"],
        "mean_pressure": mean_pressure(rows.normal_force, radius),
        "elastic_energy": pressed["elastic_energy"],
        "shift": followed.shift,
        "tangential_force": followed.force,
        "stick_radius": np.minimum(followed.stick_radius, radius),
        "slip_distance": followed.slip_distance,
        "stored_tangential_energy": followed.stored,
        "dissipated_energy": followed.slip_work,
    }
    columns = with_travel(task, columns)
    claims: Mapping[str, Claim] = planar_claims(
        contact, law.mapped.moduli, columns, missed, _prescribed(task.path)
    )
    return Interpretation(
        columns=columns,
        claims=claims,
        assumptions=frictional_assumptions(contact, law.mapped, radius),
        status=Status.GLIDING if law.glides else Status.COMPLETED,
        notes=(
            *law.mapped.notes,
            f"{law.springs.label.size - 1} springs whose forces are vectors, each followed exactly between rows",
            *glide_notes(law.glides),
        ),
        references=("sneddon", "popov-hess", "cattaneo-mindlin"),
        starts=tuple({k: float(v) for k, v in s.items() if np.ndim(v) == 0} for s in walked.starts),
    )


def _prescribed(path: LoadingPath) -> str | None:
    """The channel of the plane that a path prescribes, if it is only one and its position is known from the beginning."""
    named = [name for name in PLANE_CHANNELS if uses(path, name)]
    return named[0] if named == ["shift"] else None


def replay_of(task: Task) -> Callable[[int], tuple[PlanarLaw, PlaneState]]:
    """A function that gives the springs after a row of a path, by following it again."""
    mapped = map_to_springs(task.contact)
    deepest, _ = _deepest(task, mapped)
    radius = states_at_depth(mapped.line, np.array([max(deepest, 0.0)])).contact_radius[0]
    whole = replace(task, keep=None, progress=None)
    n = _followed(whole, mapped, float(radius))[0].springs.label.size - 1
    known: dict[int, tuple[PlanarLaw, PlaneState]] = {}

    def at(row: int) -> tuple[PlanarLaw, PlaneState]:
        if row not in known:
            law = _law(task, mapped, radius, n)
            law.stop = row
            walk(whole, virgin_plane(law.springs), law.step)
            assert law.stopped is not None
            known[row] = law, law.stopped
        return known[row]

    return at


def line_of_path(path: LoadingPath) -> FloatArray | None:
    """The unit vector of the line through the origin on which all targets of a path lie; None if there is none."""
    targets = [
        np.atleast_2d(np.asarray(target))
        for leg in known_legs(path)
        for name in PLANE_CHANNELS
        if (target := getattr(leg, name, None)) is not None
    ]
    sizes = [float(np.max(np.hypot(*part.T))) for part in targets]
    if max(sizes) == 0.0:
        return np.array([1.0, 0.0])
    # shifts and forces have different sizes
    scaled = np.concatenate([part / size for part, size in zip(targets, sizes, strict=True) if size > 0.0])
    longest = scaled[int(np.argmax(np.hypot(*scaled.T)))]
    for axis in (0, 1):
        if not scaled[:, 1 - axis].any():
            unit: FloatArray = np.eye(2)[axis]
            return unit
    direction: FloatArray = longest / math.hypot(*longest)
    across = direction[0] * scaled[:, 1] - direction[1] * scaled[:, 0]
    return direction if np.all(np.abs(across) <= 4.0 * _ON_LINE) else None


def on_line(path: LoadingPath, direction: FloatArray) -> LoadingPath:
    """A path along a line as one with single numbers, the distances along it."""
    parts: list[Ramp | Cycle | Hold | Path] = []
    for leg in known_legs(path):
        named = {
            name: np.asarray(target) @ direction
            for name in PLANE_CHANNELS
            if (target := getattr(leg, name, None)) is not None
        }
        scalars: dict[str, Any] = {n: v if v.ndim else float(v) for n, v in named.items()}
        parts.append(replace(leg, **scalars) if named else leg)
    return parts[0] if len(parts) == 1 else History(tuple(parts))


def _along_line(task: Task, direction: FloatArray) -> Result:
    """The result of the stack along a line, its shift and force as vectors."""
    single = solve_frictional(replace(task, path=on_line(task.path, direction)), may_glide=True)
    columns = {str(name): single.data[name].values for name in single.data}
    for name in PLANE_CHANNELS:
        if name in columns:
            columns[name] = np.multiply.outer(columns[name], direction)
    from pymdr.result import labelled

    note = f"the path stays on the line along ({direction[0]:.6g}, {direction[1]:.6g}): solved exactly along it, without springs"
    return replace(
        single,
        path=task.path,
        claims={**single.claims, "stress": stress_claim(task.contact, False, single.claims, planar=True)},
        data=labelled(columns, rows=task.keep),
        notes=(*single.notes, note),
        reading=task.reading,
    )
