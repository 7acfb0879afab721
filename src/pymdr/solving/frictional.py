"""The contact with friction along a path: normal and tangential controls of any kind, leg by leg."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from pymdr.errors import PathError, ProblemError, RefusedError
from pymdr.interpretation.accuracy import frictional_errors, of_own_size, with_errors
from pymdr.interpretation.certificate import (
    Certificate,
    certify_disk,
    certify_history,
    noise_remark,
    with_rings,
)
from pymdr.interpretation.friction import (
    TANGENTIAL_QUANTITIES,
    frame_error,
    frictional_claims,
    similarity_assumption,
)
from pymdr.interpretation.traction import PARTS, curves_down_to, deepest_of, friction_leg
from pymdr.interpretation.validity import (
    EXACT_WITHIN,
    TANGENTIAL_FIELDS,
    Assumption,
    BoolArray,
    Claim,
    Level,
    approximated,
)
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
from pymdr.problem.contact import Contact
from pymdr.problem.paths import Cycle, LoadingPath
from pymdr.problem.schedule import Stretch, planned, refined
from pymdr.problem.values import within_range
from pymdr.result import Result, Status
from pymdr.rows import joined, taken
from pymdr.solving.arguments import one_load
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
    within,
)
from pymdr.units import FloatArray, QuantityLike, metres, newtons, shown, to_si

_REFINED = 200_000
"""Rows up to which a leg is refined."""
_MEASURED = ("shift", "tangential_force", "slip_work")
"""Quantities whose change decides whether a leg is refined enough."""
_SLOWEST = 0.5
"""Assumed ratio of the changes of two successive refinements, where no smaller one was measured."""
_SETTLED = 1e-9
"""Tolerance of a refinement, relative to the largest value of a leg."""
_RUNS = 64
"""Largest number of runs in which rows that need refinement are separated from the others."""
_ROUNDED = 8.0 * float(np.finfo(float).eps)
"""Rounding error of the depth at which slip ends, relative to the depth."""
_CHUNK = 2_000_000
"""Rows between two calls of `progress`."""
_ONLY = {
    "torsion": "the worn profile of a row with less wear",
    "wear": "all numbers of cycles to one call, wear(..., cycles=[...])",
}
"""What serves instead of a worn profile where a force curve does not."""


_Followed = dict[str, FloatArray]
"""Rows of the stack by their names in :class:`~pymdr.line.friction.FrictionHistory`."""
_FOLLOWED = (
    "indentation",
    "shift",
    "tangential_force",
    "stick_radius",
    "stored_energy",
    "slip_work",
    "slip_distance",
)


@dataclass(frozen=True)
class _Rows:
    """Columns of a walk."""

    followed: _Followed
    normal_force: FloatArray
    parts: np.ndarray
    """One entry per leg: parts of every move, 0 where no move was divided."""
    missed: FloatArray
    """One row per row: remaining errors of the measured quantities in SI units."""
    forced: BoolArray
    dragged: BoolArray
    """Rows whose normal and tangential forces are prescribed."""


@dataclass
class _FrictionLaw:
    """The stack, on curves that are rebuilt when a leg goes deeper."""

    contact: Contact
    mapped: Springs
    machine_stiffness: float | None
    friction: float
    curves: ElasticCurves
    deepest: float = -math.inf
    """Largest depth of the curves in m."""
    certificate: Certificate | None = None
    missed: FloatArray = field(default_factory=lambda: np.zeros(len(_MEASURED)))
    """Remaining errors of the measured quantities so far, in SI units."""
    may_glide: bool = False
    """Whether the body glides under a tangential force above friction; otherwise such a force is refused."""
    glides: bool = False
    """Whether it has begun to."""

    def step(
        self, stack: FrictionState, stretch: Stretch, kept: np.ndarray | None, progress: LegProgress | None
    ) -> tuple[_Rows, FrictionState, Channels]:
        """Step 2: the stack, from the state of the leg before."""
        if stretch.by_force:
            refuse_tension(stretch.leg, stretch.normal)
        self.deepen([stretch])
        spans: list[tuple[_Followed, FloatArray]] = []
        parts = 0
        for span, together in _runs(stretch, self._leg(stretch)):
            some, own = stretch.taken(span), within(kept, span.start, span.stop - span.start)
            if together and not self.glides:
                rows, stack, divided, error = self._follow_refined(some, stack)
                rows, parts = taken(rows, own), max(parts, divided)
                self.missed = self.missed + error
            else:
                rows, stack = self._follow_in_parts(some, self._leg(some), stack, own, progress)
            spans.append((rows, np.tile(self.missed, (rows["shift"].size, 1))))
        followed, missed = (joined(each) for each in zip(*spans, strict=True))
        leg = self._leg(stretch)
        force = taken(leg.normal, kept) if leg.by_normal_force else self._forces(followed["indentation"])
        forced, dragged = (np.full(force.size, by) for by in (leg.by_normal_force, leg.by_tangential_force))
        gathered = _Rows(followed, force, np.array([parts]), missed, forced, dragged)
        return gathered, stack, self._channels(leg, stack)

    def deepen(self, stretches: Sequence[Stretch]) -> None:
        """Extend the curves to the depth of some legs, those under a force last."""
        line = self.mapped.line
        # not the largest travel: most of it may go into the machine
        depths = [deepest_of(line, [self._leg(rows)]) for rows in stretches]
        deepest = max(depths, default=-math.inf)
        if deepest <= self.deepest:
            return
        self.deepest = deepest
        forced = [rows for rows in stretches if rows.by_force]
        by_force = float(np.max(forced[0].normal)) if forced and not math.isfinite(deepest) else None
        with stretches[depths.index(deepest)].leg.named():
            refuse_unreachable(
                line, self.contact.profile, states_at_depth(line, np.array([deepest])), by_force
            )
            self.certificate = disks_down_to(self.contact, line, deepest)
        for rows in forced:
            with rows.leg.named():
                _refuse_lifted(self.contact, line, rows.normal)
        self.curves = curves_down_to(line, deepest)

    def _leg(self, stretch: Stretch) -> FrictionLeg:
        return friction_leg(self.mapped.line, stretch, self.machine_stiffness)

    def _follow(
        self, leg: FrictionLeg, stack: FrictionState, kept: np.ndarray | None = None
    ) -> FrictionHistory:
        return follow_leg(self.curves, leg, self.friction, self.mapped.moduli.tangential, stack, kept)

    def _follow_in_parts(
        self,
        stretch: Stretch,
        leg: FrictionLeg,
        stack: FrictionState,
        kept: np.ndarray | None,
        progress: LegProgress | None,
    ) -> tuple[_Followed, FrictionState]:
        """One leg, in parts if its progress is reported."""
        size = leg.normal.size
        chunk = size if progress is None else _CHUNK
        chunks: list[_Followed] = []
        for first in range(0, size, chunk):
            if first and progress is not None:
                progress(stretch.first + first)
            span = slice(first, first + chunk)
            part = replace(leg, normal=leg.normal[span], tangential=leg.tangential[span])
            own = within(kept, first, part.normal.size)
            if not self.glides:
                history = self._follow(part, stack, own)
                self.glides = self._begins_to_glide(history, part)
                if not self.glides:
                    self._refuse_stopped(history, part, stretch.row(first + history.stopped))
                stack, rows = history.state, _followed(history)
            else:
                rows = dict.fromkeys(_FOLLOWED, np.full(taken(part.normal, own).size, math.nan))
            if self.glides:
                rows["indentation"] = self._depths(part, own)
            chunks.append(rows)
        return joined(chunks), stack

    def _begins_to_glide(self, history: FrictionHistory, leg: FrictionLeg) -> bool:
        above = history.ending is Ending.NOT_ATTAINABLE and leg.by_tangential_force
        return self.may_glide and above

    def _depths(self, leg: FrictionLeg, kept: np.ndarray | None) -> FloatArray:
        """Indentation in m of rows that the stack does not follow."""
        normal = taken(leg.normal, kept)
        return states_at_force(self.mapped.line, normal).indentation if leg.by_normal_force else normal

    def _follow_refined(
        self, stretch: Stretch, stack: FrictionState
    ) -> tuple[_Followed, FrictionState, int, FloatArray]:
        """
        A leg that moves a shift together with a load or with the travel of a machine.

        Between rows the stack moves along a straight line in (indentation, shift); the moves are divided until the result converges.

        Returns
        -------
        _Followed
            The rows of the leg.
        FrictionState
            At the end of the leg.
        int
            Parts of every move.
        ndarray
            Remaining errors of the measured quantities in SI units, extrapolated from their decrease.
        """

        def run(parts: int) -> tuple[FrictionHistory, FrictionLeg, np.ndarray]:
            finer = refined(stretch, parts)
            leg = self._leg(finer.rows)
            return self._follow(leg, stack, finer.own), leg, finer.own

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
        self._refuse_stopped(history, leg, stretch.row(int(np.searchsorted(own, history.stopped))))
        return _followed(history), history.state, parts, error * _sizes(history)

    def _refuse_stopped(self, history: FrictionHistory, leg: FrictionLeg, where: str) -> None:
        if history.ending is Ending.COMPLETE:
            return
        i = history.stopped
        if history.ending is Ending.NOT_ATTAINABLE and leg.by_tangential_force:
            pressed = leg.normal[i] if leg.by_normal_force else float(self._forces(leg.normal[[i]])[0])
            raise PathError(
                f"tangential_force = {newtons(leg.tangential[i])} in {where}: friction carries at most mu F_N = "
                f"{newtons(self.friction * pressed if pressed else 0.0)} there; "
                "reduce it, or move the body with shift(...)"
            )
        raise PathError(f"{where} cannot be followed: {history.ending.value}")

    def _forces(self, depth: FloatArray) -> FloatArray:
        return normal_force(self.mapped.line, states_at_depth(self.mapped.line, depth))

    def _channels(self, leg: FrictionLeg, stack: FrictionState) -> Channels:
        d, u = np.array([stack.indentation]), np.array([stack.shift])
        if self.glides:
            d = self._depths(leg, np.array([-1]))
        force = float(leg.normal[-1]) if leg.by_normal_force else float(self._forces(d)[0])
        if self.glides:
            unknown = dict.fromkeys(("shift", "tangential_force"), math.nan)
            return channels_at(float(d[0]), force, self.machine_stiffness) | unknown
        last = self._follow(FrictionLeg(False, False, d, u), stack)
        return {
            **channels_at(stack.indentation, force, self.machine_stiffness),
            "shift": stack.shift,
            "tangential_force": float(last.tangential_force[0]),
        }


def solve_frictional(task: Task, may_glide: bool = False) -> Result:
    """Map, walk and interpret; a tangential force above friction is refused, or the body may glide from there on."""
    contact, mapped = task.contact, map_to_springs(task.contact)
    assert contact.friction is not None
    curves = curves_down_to(mapped.line, 0.0)
    law = _FrictionLaw(
        contact, mapped, task.machine_stiffness, contact.friction.coefficient, curves, may_glide=may_glide
    )
    law.deepen(_foreseen(task.path))
    virgin = virgin_state(law.friction, mapped.moduli.normal / mapped.moduli.tangential)
    walked = walk(task, virgin, law.step)
    starts = tuple(
        {**here, PARTS: float(parts)} if parts else here
        for here, parts in zip(walked.starts, walked.rows.parts, strict=True)
    )
    return solution(task, walked, _interpret(task, law, walked, starts))


def _foreseen(path: LoadingPath) -> list[Stretch]:
    """The largest targets of a path that are known in advance, that of the force last."""
    largest: dict[str, Stretch] = {}
    for leg in planned(path):
        channel = leg.controls.normal
        target = None if isinstance(leg.leg, Cycle) else getattr(leg.leg, channel, None)
        if target is not None:
            most = np.array([max(float(np.max(target)), 0.0)])
            if channel not in largest or most > largest[channel].normal:
                largest[channel] = Stretch(leg, most, np.zeros(1))
    return sorted(largest.values(), key=lambda rows: rows.by_force)


def _followed(history: FrictionHistory) -> _Followed:
    return {name: getattr(history, name) for name in _FOLLOWED}


def _runs(stretch: Stretch, leg: FrictionLeg) -> list[tuple[slice, bool]]:
    """
    Rows in a run, and whether they move a shift together with a load or a travel.

    Only these need rows in between: the stack is exact for all others. Many short runs are merged into one.
    """
    size = stretch.normal.size
    if leg.by_tangential_force or not (leg.by_normal_force or leg.normal is not stretch.normal):
        return [(slice(0, size), False)]
    moves = [
        np.diff(values, prepend=start) != 0.0
        for values, start in zip((stretch.normal, stretch.tangential), stretch.start, strict=True)
    ]
    together = moves[0] & moves[1]
    ends = np.flatnonzero(np.diff(together)) + 1
    if ends.size >= _RUNS:
        return [(slice(0, size), True)]
    borders = [0, *ends.tolist(), size]
    return [(slice(a, b), bool(together[a])) for a, b in pairwise(borders)]


def _refuse_lifted(contact: Contact, line: ElasticLine, force: FloatArray) -> None:
    certificate = certify_disk(line, states_at_force(line, np.array([float(np.max(force))])))
    if not certificate.disk.all():
        raise RefusedError(
            f"friction needs a contact that is a disk at every depth up to that of the load: {certificate.reason}"
            f"{_instead(contact, 'friction')}"
        )


def disks_down_to(
    contact: Contact, line: ElasticLine, deepest: float, subject: str = "friction"
) -> Certificate:
    """The certificate of all depths from the first touch on, whose pressures add up to the tractions."""
    certificate = certify_history(line, deepest)
    if not certificate.disk.all():
        raise RefusedError(
            f"{subject} needs a contact that is a disk at every depth up to {metres(deepest)}: "
            f"{certificate.reason}{noise_remark(contact.profile, line.equivalent, deepest)}{_instead(contact, subject)}"
        )
    return certificate


def _instead(contact: Contact, subject: str) -> str:
    """What serves where the contact of a profile is not a disk; empty if that is not known."""
    serves = contact.profile.instead
    return f"; give {_ONLY.get(subject, serves)}" if serves else ""


def _change(coarse: FrictionHistory, fine: FrictionHistory) -> FloatArray:
    """The largest differences of two runs of one leg, over its largest values."""
    if coarse.ending is not Ending.COMPLETE or fine.ending is not Ending.COMPLETE:
        return np.full(len(_MEASURED), math.inf)
    pairs = [(getattr(coarse, name), getattr(fine, name)) for name in _MEASURED]
    return np.array([np.max(np.abs(one - other)) for one, other in pairs]) / _sizes(fine)


def _sizes(history: FrictionHistory) -> FloatArray:
    """The largest value of each measured quantity, above 0."""
    largest = [float(np.max(np.abs(getattr(history, name)), initial=0.0)) for name in _MEASURED]
    return np.maximum(largest, math.ulp(0.0))


def _columns(task: Task, mapped: Springs, rows: _Rows) -> dict[str, FloatArray]:
    line, followed = mapped.line, rows.followed
    states = states_at_depth(line, followed["indentation"])
    # a table of a(d) and the line round differently
    stick = np.minimum(followed["stick_radius"], states.contact_radius)
    columns = {
        "indentation": followed["indentation"],
        "normal_force": rows.normal_force,
        "contact_radius": states.contact_radius,
        "normal_stiffness": normal_stiffness(line, states),
        "mean_pressure": mean_pressure(rows.normal_force, states.contact_radius),
        "elastic_energy": elastic_energy(line, states),
        "shift": followed["shift"],
        "tangential_force": followed["tangential_force"],
        "tangential_stiffness": 2.0 * mapped.moduli.tangential * stick,
        "stick_radius": stick,
        "slip_distance": followed["slip_distance"],
        "stored_tangential_energy": followed["stored_energy"],
        "dissipated_energy": followed["slip_work"],
    }
    return with_travel(task, columns)


def _interpret(
    task: Task, law: _FrictionLaw, walked: Walked[_Rows], starts: tuple[Channels, ...]
) -> Interpretation:
    """Step 3: quantities, claims and assumptions of every row that is kept."""
    rows = walked.rows
    contact, mapped = task.contact, law.mapped
    columns = _columns(task, mapped, rows)
    known = np.isfinite(columns["shift"])
    claims = frictional_claims(contact, mapped.moduli, tuple(columns), np.ones(known.size, dtype=bool))
    for name in (*TANGENTIAL_QUANTITIES, *TANGENTIAL_FIELDS):
        if name in claims:
            claims[name] = replace(claims[name], where=known)
    if law.certificate is not None:
        claims = with_rings(claims, law.certificate)
    missed = _missed(rows)
    for name in (*TANGENTIAL_QUANTITIES, *TANGENTIAL_FIELDS):
        left = missed[{"dissipated_energy": "slip_work", "shift": "shift"}.get(name, "tangential_force")]
        if (largest := float(left.max(initial=0.0))) > EXACT_WITHIN and name in claims:
            remark = f"; rows that move a load and a shift at once are integrated with an error of {largest:.1g} of the largest value"
            own = of_own_size(left, columns[name]) if name in columns else left
            claims |= approximated({name: claims[name]}, remark, own)
    at_deepest = states_at_depth(mapped.line, np.array([max(law.deepest, 0.0)]))
    rounded = {"dissipated_energy": _slip_work_error(mapped.line, columns)}
    if float(rounded["dissipated_energy"].max(initial=0.0)) > EXACT_WITHIN:
        remark = "; the slip annulus is so thin that rounding of the depth matters"
        claims |= approximated(
            {"dissipated_energy": claims["dissipated_energy"]}, remark, rounded["dissipated_energy"]
        )
    ratio = mapped.moduli.normal / mapped.moduli.tangential
    mapping = frictional_errors(mapped.line, law.friction, ratio, columns, rows.forced, rows.dragged)
    claims = with_errors(claims, mapping, map_remark(mapped.line, at_deepest))
    claims |= _in_frame(contact, mapped, columns, claims["tangential_force"], rows.dragged)
    return Interpretation(
        columns=columns,
        claims=claims,
        assumptions=frictional_assumptions(contact, mapped, columns["contact_radius"]),
        status=Status.GLIDING if law.glides else Status.COMPLETED,
        notes=(*mapped.notes, *glide_notes(law.glides)),
        references=("sneddon", "popov-hess", "cattaneo-mindlin", "memory"),
        starts=starts,
    )


def glide_notes(glides: bool) -> tuple[str, ...]:
    """What a body that glides lacks."""
    if not glides:
        return ()
    return (
        "a tangential force above mu F_N determines no shift: the body slides, and all later rows are NaN; prescribe the shift to follow the sliding",
    )


def _in_frame(
    contact: Contact, mapped: Springs, columns: Mapping[str, FloatArray], claim: Claim, dragged: BoolArray
) -> dict[str, Claim]:
    """The claim of the tangential force with the measured error of the frame, 0 for prescribed forces."""
    fraction = frame_error(contact, mapped.moduli)
    if not fraction or claim.level is not Level.APPROXIMATE:
        return {}
    assert contact.friction is not None
    carried = contact.friction.coefficient * np.maximum.accumulate(np.abs(columns["normal_force"]))
    pulled = np.abs(columns["tangential_force"])
    with np.errstate(divide="ignore", invalid="ignore"):
        own = np.where(dragged | (pulled == 0.0), 0.0, fraction * carried / pulled)
    return approximated({"tangential_force": claim}, "", np.fmin(own, 1.0))


def _missed(rows: _Rows) -> dict[str, FloatArray]:
    """Remaining errors relative to the largest value of a path; the tangential force includes the error of the shift."""
    sizes = [float(np.nanmax(np.abs(rows.followed[name]), initial=0.0)) for name in _MEASURED]
    relative = rows.missed / np.maximum(sizes, math.ulp(0.0))
    errors = dict(zip(_MEASURED, relative.T, strict=True))
    return errors | {"tangential_force": np.maximum(errors["shift"], errors["tangential_force"])}


def _slip_work_error(line: ElasticLine, columns: Mapping[str, FloatArray]) -> FloatArray:
    """Relative error of the slip work by rounding of the depth down to which springs slip."""
    depth, work = columns["indentation"], columns["dissipated_energy"]
    if not np.nanmax(work, initial=0.0) > 0.0:
        return np.zeros(work.shape)
    slips = columns["stick_radius"] < columns["contact_radius"]
    down = np.where(slips, depth - np.where(slips, line.depth(columns["stick_radius"]), depth), 0.0)
    deepest = np.maximum.accumulate(np.maximum(depth, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.fmin(_ROUNDED * deepest / np.maximum.accumulate(down), 1.0)
    return np.where(work > 0.0, error, 0.0)


def frictional_assumptions(contact: Contact, mapped: Springs, radii: FloatArray) -> tuple[Assumption, ...]:
    """Assumptions of the model, including the elastic similarity that friction needs."""
    assert contact.friction is not None
    listed = assumptions(contact, mapped, radii)
    similar = similarity_assumption(mapped.moduli.dundurs_beta, contact.friction.coefficient)
    return (*(a for a in listed if a.name != similar.name), similar)


def pressed_joint(
    meaningless: str,
    contact: Contact,
    normal_force: QuantityLike | None,
    indentation: QuantityLike | None,
) -> tuple[Springs, float, float, Certificate]:
    """The line, depth in m, coefficient and certificate of a joint under a constant load; `meaningless` names what is not defined for mu = 0."""
    if contact.friction is None:
        raise ProblemError("the contact has no friction; give Contact(..., friction=Coulomb(0.3))")
    mu = contact.friction.coefficient
    if not 0.0 < mu < math.inf:
        raise ProblemError(f"mu = {mu:g} has no {meaningless}; it must be above 0 and finite")
    one_load(normal_force, indentation)
    mapped = map_to_springs(contact)
    line = mapped.line
    if indentation is not None:
        d = float(within_range(to_si(indentation, "m", name="indentation"), "m", "indentation"))
    else:
        assert normal_force is not None
        force = float(within_range(to_si(normal_force, "N", name="normal_force"), "N", "normal_force"))
        d = float(states_at_force(line, np.array([max(force, 0.0)])).indentation[0])
    by_force = None if indentation is not None else force
    refuse_unreachable(line, contact.profile, states_at_depth(line, np.array([d])), by_force)
    if d <= 0.0:
        name, given, unit = (
            ("normal_force", normal_force, "N") if indentation is None else ("indentation", indentation, "m")
        )
        raise ProblemError(f"{name} = {shown(given)}; it must be above 0 {unit}")
    return mapped, d, mu, disks_down_to(contact, line, d, "wear" if meaningless == "wear" else "friction")
