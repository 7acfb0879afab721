"""Claims and tangential fields of a contact with memory and friction."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from pymdr.interpretation.friction import TANGENTIAL_QUANTITIES
from pymdr.interpretation.memory import (
    TO_EDGE,
    LineState,
    MemorySurface,
    along_line,
    away_from,
    between,
    checked_rows,
    displacement,
    far_from_edge,
    spring_load,
    surface_load,
)
from pymdr.interpretation.on_normal import OnNormal
from pymdr.interpretation.stress import Loads
from pymdr.interpretation.validity import (
    SOURCES,
    TANGENTIAL_FIELDS,
    TANGENTIAL_LINE_FIELDS,
    BoolArray,
    Claim,
    Level,
)
from pymdr.line.curves import ElasticLine
from pymdr.line.memory import (
    Passage,
    TangentialState,
    follow_springs,
    prepared,
    shear_springs,
    unsheared,
    virgin,
)
from pymdr.mapping.relaxation import Relaxation
from pymdr.problem.contact import Contact
from pymdr.problem.materials import Elastic, Rigid, Viscoelastic
from pymdr.units import FloatArray

SHEARED_LINE_FIELDS = (*TANGENTIAL_LINE_FIELDS, "tangential_spring_force")
SHEARED_QUANTITIES = (*TANGENTIAL_QUANTITIES, "slip_work", "external_work")
_SOURCE = f"{SOURCES['cattaneo-mindlin']}; {SOURCES['lee-radok']}; Popov and Hess (2015), chapters 5 and 7"
_PARTS = 2, 4
"""Substeps of every row for the fields of a history with many rows, and with few."""
_MANY = 2000
"""Least number of rows that counts as many."""
_MAX_KINKS = 24
"""Number of springs with the largest change of slope of the line load that are checked in a row."""
_SEARCHED = 0.01, 0.985
"""Range of these springs over the contact radius."""


def sheared_claims(
    contact: Contact, coupling: float, names: Sequence[str], where: BoolArray, disk: BoolArray
) -> dict[str, Claim]:
    """
    Claims of the tangential quantities of a contact with memory.

    Parameters
    ----------
    contact : Contact
        With a law of friction.
    coupling : float
        The largest |Dundurs' beta|.
    where : ndarray of bool
        Rows whose contact is a disk.
    disk : ndarray of bool
        Rows whose stick region is a disk.
    """
    if not where.any():
        return dict.fromkeys(
            names, Claim(Level.NOT_VALID, "the springs in contact are not those of a disk", _SOURCE, where)
        )
    level, reason = _tangential(contact, coupling)
    if not disk.all():
        reason += (
            f"; in {int((~disk).sum())} of {disk.size} rows the stick region is not a disk, and the springs represent the surface "
            "only roughly"
        )
        level = Level.APPROXIMATE
    claims = dict.fromkeys(names, Claim(level, reason, _SOURCE, where))
    if "stick_radius" in claims:
        sticks = where & disk
        claims["stick_radius"] = (
            replace(claims["stick_radius"], where=sticks)
            if sticks.any()
            else Claim(Level.NOT_VALID, "the stick region is not a disk", _SOURCE, sticks)
        )
    return claims


def _tangential(contact: Contact, coupling: float) -> tuple[Level, str]:
    assert contact.friction is not None
    mu = contact.friction.coefficient
    if mu == 0.0:
        return Level.EXACT, "exact: without friction there is no tangential load"
    coupled = ""
    if coupling > 1e-12:
        coupled = (
            "; the coupling of pressure and shear of elastically dissimilar bodies is neglected (Dundurs' beta up to "
            f"{coupling:.3g})"
        )
    if math.isinf(mu) and not coupled and _one_poisson(contact):
        return (
            Level.EXACT,
            "exact without slip and with the same Poisson's ratio in both bodies and at all times: every increment shifts a disk "
            "uniformly",
        )
    frame = (
        "in the frame of Cattaneo and Mindlin with memory: on the line q_x = int G*(t - s) dw_x(s) and |q_x| <= mu q, equivalent to "
        "the surface while the stick region is a disk; traction in one direction is assumed to make displacements only in that "
        "direction. The error of this assumption is known for elastic bodies (at most 0.5 % of the largest mu F_N) but not with "
        "memory"
    )
    return Level.APPROXIMATE, f"{frame}{coupled}"


def _one_poisson(contact: Contact) -> bool:
    """Whether all deformable bodies have the same Poisson's ratio at all times."""
    ratios = set()
    for body in (contact.body, contact.counterbody):
        if isinstance(body, Rigid):
            continue
        ratios.add(body.poisson if isinstance(body, Elastic | Viscoelastic) else None)
    return None not in ratios and len(ratios) == 1


def uncoupled(claims: Mapping[str, Claim], contact: Contact, coupling: float) -> Mapping[str, Claim]:
    """Claims of the normal quantities with the effect of friction on elastically dissimilar bodies."""
    assert contact.friction is not None
    if coupling <= 1e-12 or contact.friction.coefficient == 0.0:
        return claims
    remark = f"; the effect of friction on the pressure is neglected (Dundurs' beta up to {coupling:.3g})"
    return {
        name: claim
        if claim.level is Level.NOT_VALID
        else replace(claim, level=Level.APPROXIMATE, reason=f"{claim.reason}{remark}")
        for name, claim in claims.items()
    }


@dataclass(frozen=True, eq=False)
class ShearedSurface(OnNormal[MemorySurface]):
    """Surface and line of a contact with memory and friction."""

    tangential: Relaxation
    friction: float
    shift: FloatArray

    @property
    def revolves(self) -> bool:
        """Whether nothing depends on the direction: without friction."""
        return self.friction == 0.0

    def loads(self, step: int) -> Loads:
        """The loads of both lines of springs; the shear traction acts in the direction of the shift."""
        normal = self.normal.loads(step)
        if self.revolves or math.isnan(self.normal.contact_radius[step]):
            return normal
        return normal._replace(shear=spring_load(_sheared_at(self, step)))

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Values of a field at radii (or positions on the line) in one step."""
        if name not in (*TANGENTIAL_FIELDS, *SHEARED_LINE_FIELDS):
            return self.normal.field(name, position, step)
        at = np.abs(position)
        if math.isnan(self.normal.contact_radius[step]):
            return np.full(at.shape, math.nan)
        state = _sheared_at(self, step)
        if name == "tangential_spring_force":
            return along_line(state, state.load, at) * (at <= state.radius)
        if name == "spring_shift":
            return along_line(state, state.deflection, at)
        if name == "shear_traction":
            return surface_load(state, at)
        u = displacement(state, at)
        if name == "tangential_displacement":
            return u
        return np.where((at <= state.radius) & (state.radius > 0.0), self.shift[step] - u, math.nan)


@lru_cache(maxsize=8)
def _sheared_at(surface: ShearedSurface, step: int) -> LineState:
    *_, state = _states(surface, [step], _parts_of(surface))
    return state


def _parts_of(surface: ShearedSurface) -> int:
    return _PARTS[int(surface.shift.size <= _MANY)]


def _states(surface: ShearedSurface, steps: Sequence[int], parts: int) -> Iterator[LineState]:
    """The tangential springs of rising rows, computed in one pass with a number of substeps per row."""
    normal, friction = surface.normal, surface.friction
    line, rows = ElasticLine(normal.equivalent, 1.0), slice(0, steps[-1] + 1)
    start = normal.start()
    time, depth, moved = (
        _finer(values[rows], first, parts)
        for values, first in ((normal.time, start[0]), (normal.indentation, start[1]), (surface.shift, 0.0))
    )
    pressed = prepared(line, normal.relaxation, float(np.max(depth)), virgin(*start), normal.n)
    now, last, done = unsheared(), None, 0

    def watch(passage: Passage) -> None:
        nonlocal now, last, done
        shifts = moved[done : done + passage.force.size]
        sheared = shear_springs(
            line, passage, (normal.relaxation, surface.tangential), friction, shifts, False, now
        )
        now, last, done = sheared.state, passage, done + shifts.size

    for step in steps:
        own = slice(done, (step + 1) * parts)
        if own.stop > done:
            pressed = follow_springs(
                line, normal.relaxation, time[own], depth[own], pressed, n=normal.n, watch=watch
            ).state
            if last is None:  # not touched yet
                now, done = replace(now, shift=float(moved[own.stop - 1])), own.stop
        yield _read(surface, now, last, moved[:done], float(normal.contact_radius[step]))


def _read(
    surface: ShearedSurface, now: TangentialState, last: Passage | None, moved: FloatArray, radius: float
) -> LineState:
    """The springs after the last row of a passage."""
    if last is None:
        none = np.zeros(0)
        return LineState(none, none, none, 0.0)
    normal, tangential = surface.normal.relaxation, surface.tangential
    waits, moves = (np.diff(values[-2:])[0] for values in (last.time, last.indentation))
    pulled = float(moved[-1] - moved[-2]) if moved.size > 1 else 0.0
    free = now.free != 0.0
    q = tangential.equilibrium * now.deflection + now.branches.sum(axis=1)
    load = last.load[-1].copy()
    if tangential.viscosity > 0.0 and waits > 0.0:
        q += tangential.viscosity * pulled / waits
        load += normal.viscosity * moves / waits
    if math.isfinite(surface.friction):
        limit = surface.friction * np.maximum(load, 0.0)
        q = np.clip(q, -limit, limit)
    return LineState(last.springs.position, now.deflection, np.where(free, 0.0, q), radius)


def sheared_errors(surface: ShearedSurface, size: int) -> dict[str, FloatArray]:
    """
    Errors of the tangential fields of all rows over their largest value in all rows.

    From half as many springs and substeps in some rows; for other rows from the checked rows on both sides.
    """
    rows = checked_rows(surface.normal.contact_radius)
    errors = {name: np.zeros(len(rows)) for name in TANGENTIAL_FIELDS}
    if not rows:
        return {name: np.zeros(size) for name in errors}
    half = replace(surface, normal=replace(surface.normal, n=surface.normal.n // 2))
    parts = _parts_of(surface)
    largest = dict.fromkeys(errors, 0.0)
    pairs = zip(rows, _states(surface, rows, parts), _states(half, rows, parts // 2), strict=True)
    for i, (row, *both) in enumerate(pairs):
        a = both[0].radius
        r = np.concatenate([a * TO_EDGE, _sharpest_kinks(both[0])]) if a > 0.0 else TO_EDGE
        away = away_from(r, surface.marks(row))
        r = r[away] if away.any() else r
        shift = float(surface.shift[row])
        moved = [displacement(state, r) for state in both]
        values = [
            (surface_load(state, r) * (far_from_edge(both[0], r) if a > 0.0 else 1.0), u, shift - u)
            for state, u in zip(both, moved, strict=True)
        ]
        for name, fine, coarse in zip(errors, *values, strict=True):
            if a > 0.0:
                errors[name][i] = float(np.max(np.abs(fine - coarse)))
                largest[name] = max(largest[name], float(np.max(np.abs(fine))))
    return {
        name: between(np.array(rows), 2.0 * values / (largest[name] or 1.0), size)
        for name, values in errors.items()
    }


def _sharpest_kinks(state: LineState) -> FloatArray:
    """Radii in m next to the sharpest bends of the line load: the errors of tractions are largest at earlier stick radii."""
    low, high = _SEARCHED
    inside = (state.position > low * state.radius) & (state.position < high * state.radius)
    x, q = state.position[inside], state.load[inside]
    if x.size < _MAX_KINKS:
        return np.zeros(0)
    slopes = np.diff(q) / np.diff(x)
    most = np.argsort(np.abs(np.diff(slopes)))[-_MAX_KINKS:]
    return np.concatenate([0.5 * (x[most] + x[most + 1]), x[most + 1], 0.5 * (x[most + 1] + x[most + 2])])


def _finer(values: FloatArray, start: float, parts: int) -> FloatArray:
    """Rows with interpolated substeps, from a start value."""
    rows = np.arange(values.size + 1.0)
    finer = np.arange(1.0, parts * values.size + 1.0) / parts
    return np.asarray(np.interp(finer, rows, np.concatenate([[start], values])))
