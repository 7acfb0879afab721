"""Fields of a contact with memory from the springs of one row, and their check against tension and overlap."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain, groupby
from typing import Any, NamedTuple, Protocol

import numpy as np
import scipy

from pymdr.errors import QuantityError
from pymdr.interpretation.stress import LineLoad, Loads, Punches
from pymdr.interpretation.validity import NORMAL_FIELDS, SOURCES, BoolArray, Claim, Level
from pymdr.line.curves import ElasticLine, Line
from pymdr.line.memory import MemoryState, follow_springs, line_state, prepared, virgin
from pymdr.mapping.abel import Curve
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.mapping.relaxation import Relaxation
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

_NODES = 96
_KINK_DISTANCE = 0.01
"""Least distance from a kink at which errors are measured, over its radius; the pressure at a kink may be infinite."""
_BLOCK = 256
"""Number of radii whose pressures are integrated at once."""
_TENSION = 1e-3
"""Tension that the spacing of the springs can cause, over the mean pressure."""
_OVERLAP = 1e-3
"""Overlap that the spacing of the springs can cause, with a margin, over the largest displacement."""
_SURELY = 4.0
"""Margin of a tension or overlap, in differences between all and half the springs."""
_TELLING = 20
"""Least number of springs in a contact for a check of its pressure and gap."""
_OF_ONE_SIZE = 30.0
"""Ratio of contact radii up to which contacts share one set of springs."""
_CHECKED = 48
"""Largest number of rows whose pressure and gap are checked."""
_AT_EDGE = 0.1
"""Least distance of the last spring from the edge, in spacings; below it the cubic interpolation loses its digits."""
_ENDS = 0.5
"""Extrapolated load at the edge over that of the last spring, above which the load does not vanish at the edge."""
_NEGLIGIBLE = 1e-100
"""Deflections below this fraction of the largest of a row count as 0."""
_TO_EDGE = 2.0
"""Error of pressures over the difference between all and half the springs; near an edge the order of convergence is below 1."""
INSIDE = (np.arange(64.0) + 0.5) / 66.0
TO_EDGE = np.concatenate([INSIDE, 1.0 - np.geomspace(0.03, 1e-5, 12)])
"""Radii over that of the contact at which errors of pressures and tractions are measured."""
_OUTSIDE = 1.0 + np.geomspace(1e-3, 2.0, 16)
"""Radii over that of the contact at which gap and displacement are checked."""
_SOURCE = f"{SOURCES['lee-radok']}; {SOURCES['ting']}"


@dataclass(frozen=True)
class LineState:
    """The springs of one row."""

    position: FloatArray
    """x in m, rising."""
    deflection: FloatArray
    """w in m."""
    load: FloatArray
    """q in N/m."""
    radius: float
    """Contact radius in m."""


def along_line(state: LineState, values: FloatArray, position: FloatArray) -> FloatArray:
    """Values of the springs at positions in m on the line; 0 beyond the last spring."""
    if state.position.size == 0:
        return np.zeros(position.shape)
    return np.asarray(np.interp(position, state.position, values, right=0.0))


@dataclass(frozen=True, eq=False)
class MemorySurface:
    """Surface and line of a contact with memory; the springs of a row are computed again on demand."""

    equivalent: EquivalentProfile
    relaxation: Relaxation
    gap_function: Curve
    time: FloatArray
    indentation: FloatArray
    contact_radius: FloatArray
    n: int
    """Springs in the largest contact."""

    def default_radii(self, step: int) -> FloatArray:
        """A grid from 0 to twice the contact radius, graded to its edge."""
        known = min(self.equivalent.edge, self.equivalent.max_radius)
        a = (
            float(self.contact_radius[step])
            or float(np.nanmax(self.contact_radius, initial=0.0))
            or min(1.0, 0.4 * known)
        )
        inner = a * np.sin(np.linspace(0.0, math.pi / 2.0, 101))
        top = min(2.0 * a, self.equivalent.max_radius)
        return np.unique(np.concatenate([inner, a + (top - a) * np.linspace(0.0, 1.0, 61)[1:] ** 2]))

    def marks(self, step: int) -> Sequence[float]:
        """Radii in m in the contact at which its pressure may have a kink."""
        return self.equivalent.kinks(float(self.contact_radius[step]))

    def edge_amplitude(self, step: int) -> float:
        """Amplitude of the pressure at the edge in Pa m^0.5; 0 without a dashpot in the bodies."""
        state = self.line_state(step)
        if self.relaxation.viscosity == 0.0 or state.radius <= 0.0:
            return 0.0
        return float(_edge_load(state) / (math.pi * math.sqrt(2.0 * state.radius)))

    @property
    def revolves(self) -> bool:
        """Nothing depends on the direction."""
        return True

    def loads(self, step: int) -> Loads:
        """The load of the springs on the line."""
        return Loads(spring_load(self.line_state(step)))

    def hides_edge(self, state: LineState) -> bool:
        """Whether a load that vanishes at the edge drops only between the last spring and the edge, where it is not resolved."""
        ends = self.relaxation.viscosity > 0.0 or state.radius >= self.equivalent.edge
        return not ends and state.radius > 0.0 and edge_load(state) != 0.0

    @property
    def curve(self) -> Line:
        """The line per unit modulus."""
        return ElasticLine(self.equivalent, 1.0)

    def line_state(self, step: int) -> LineState:
        """The springs of one row."""
        state: LineState = state_at(self, step)
        return state

    def deflection(self, step: int, position: FloatArray) -> FloatArray:
        """Deflection in m of springs at positions in m, in and out of contact."""
        state = self.line_state(step)
        return along_line(state, state.deflection, np.abs(position))

    def followed_to(self, step: int) -> LineState:
        """The springs of one row, by the whole path up to it."""
        *_, state = self.states([step])
        return state

    def states(self, steps: Sequence[int]) -> Iterator[LineState]:
        """The springs of rising rows, computed in one pass."""
        line = self.curve
        if not steps:
            return
        deepest = float(np.max(self.indentation[: steps[-1] + 1]))
        state = prepared(line, self.relaxation, deepest, virgin(*self.start()), self.n)
        first = 0
        for step in steps:
            if step >= first:
                rows = slice(first, step + 1)
                state = follow_springs(
                    line, self.relaxation, self.time[rows], self.indentation[rows], state, n=self.n
                ).state
                first = step + 1
            yield self._read(state, step)

    def start(self) -> tuple[float, float]:
        """Time in s and indentation in m at the start of the history."""
        return 0.0, min(float(self.indentation[0]), 0.0)

    def _read(self, state: MemoryState, step: int) -> LineState:
        x, w, load = line_state(state, self.relaxation)
        if self.relaxation.viscosity > 0.0 and x.size:
            times, depths = (np.concatenate([[0.0], v]) for v in (self.time, self.indentation))
            rate = (depths[step + 1] - depths[step]) / (times[step + 1] - times[step])
            load = np.where(state.free == 0.0, load + self.relaxation.viscosity * rate, 0.0)
        return LineState(x, w, load, float(self.contact_radius[step]))

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Values of a field at radii (or positions on the line) in one step."""
        if math.isnan(self.contact_radius[step]):
            return np.full(position.shape, math.nan)
        state, d = self.line_state(step), float(self.indentation[step])
        at = np.abs(position)
        if name == "equivalent_profile":
            return self.equivalent.g(at)
        if name == "spring_force":
            return along_line(state, state.load, at) * (at <= state.radius)
        if name == "pressure":
            return surface_load(state, at)
        if name not in ("normal_displacement", "gap"):
            raise QuantityError(f"no field {name!r}; fields are {', '.join(NORMAL_FIELDS)}")
        u = self._displacement(state, d, at)
        if name == "normal_displacement":
            return u
        return np.where(at <= state.radius, 0.0, self.gap_function(at) - d + u)

    def _displacement(self, state: LineState, d: float, r: FloatArray) -> FloatArray:
        """D - f(r) in the contact, from the springs outside."""
        inside = (r <= state.radius) & (state.radius > 0.0)
        u = np.empty(r.shape)
        u[inside] = d - self.gap_function(r[inside])
        u[~inside] = displacement(state, r[~inside])
        return u

    def gap_and_displacement(
        self, state: LineState, step: int, r: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Both at radii outside the contact, the gap only where the profile is known."""
        d = float(self.indentation[step])
        u = self._displacement(state, d, r)
        known = r <= min(self.equivalent.max_radius, self.equivalent.edge)
        return self.gap_function(r[known]) - d + u[known], u

    def outside(self, state: LineState) -> FloatArray:
        """Radii to three times that of the contact; without contact, over the largest contact so far."""
        touched = float(state.position[-1])
        return state.radius * _OUTSIDE if state.radius > 0.0 else touched * np.append(INSIDE[::4], _OUTSIDE)


def displacement(state: LineState, r: FloatArray) -> FloatArray:
    """Displacement (2/pi) int_0^r w / sqrt(r^2 - x^2) dx in m of the surface."""
    u = np.zeros(r.shape)
    if state.position.size == 0 or r.size == 0:
        return u
    position, deflection = state.position, state.deflection
    size = float(np.max(np.abs(deflection)))
    if size == 0.0:
        return u
    # tiny deflections have slopes whose reciprocals overflow
    deflection = np.where(np.abs(deflection) > _NEGLIGIBLE * size, deflection / size, 0.0)
    if state.radius > position[-1]:  # at a sharp edge, to which the last spring stands for w
        position, deflection = np.append(position, state.radius), np.append(deflection, deflection[-1])
    top, (t, weights) = float(position[-1]), gauss(_NODES)
    # scaled by the largest position, since the squares of tiny contacts underflow
    w = scipy.interpolate.PchipInterpolator(
        np.append(0.0, position / top), np.append(deflection[0], deflection)
    )
    radii = np.maximum(r, 1e-9 * top)[:, None]
    # w has a kink at the edge of the contact and ends at the last spring
    ends = np.arcsin(np.minimum(np.array([0.0, state.radius, top, math.inf]) / radii, 1.0))
    width = np.diff(ends, axis=1)
    x = radii[:, :, None] * np.sin(ends[:, :-1, None] + width[:, :, None] * t)
    values = np.where(x <= top, w(np.minimum(x / top, 1.0)), 0.0)
    return np.asarray(2.0 / math.pi * size * np.sum(width * (values @ weights), axis=1))


class Followed(Protocol):
    """A surface whose springs are computed by its path."""

    def followed_to(self, step: int) -> Any:
        """The springs of one row."""


@lru_cache(maxsize=8)
def state_at(surface: Followed, step: int) -> Any:
    """The springs of one row, kept for the next fields."""
    return surface.followed_to(step)


def _inside(state: LineState) -> tuple[FloatArray, FloatArray]:
    """Positions and loads of the springs in contact, without one very close to the edge."""
    x, q = (values[state.position < state.radius] for values in (state.position, state.load))
    if x.size > 1 and state.radius - x[-1] < _AT_EDGE * (x[-1] - x[-2]):
        return x[:-1], q[:-1]
    return x, q


def _edge_load(state: LineState) -> float:
    """The line load in N/m continued to the edge of the contact."""
    x, q = (values[-2:] for values in _inside(state))
    if x.size < 2:
        return 0.0
    return float(q[-1] + (q[-1] - q[-2]) / (x[-1] - x[-2]) * (state.radius - x[-1]))


def surface_load(state: LineState, r: FloatArray) -> FloatArray:
    """
    Pressure -(1/pi) [int_r^a q' / sqrt(x^2 - r^2) dx - q(a) / sqrt(a^2 - r^2)] in Pa of the springs of one row.

    Shear traction for springs of the tangential line.

    q is interpolated between the springs by a shape-preserving curve; its error is about the square of their spacing.
    """
    a = state.radius
    p = np.zeros(r.shape)
    within = r < a
    x, q = _inside(state)
    if x.size < 4 or not within.any():
        return p
    edge, size = edge_load(state), float(np.max(np.abs(q)))
    if size == 0.0:
        return p
    q = np.where(np.abs(q) > _NEGLIGIBLE * size, q / size, 0.0)  # as displacements
    curve = scipy.interpolate.PchipInterpolator(
        np.concatenate([[0.0], x / a, [1.0]]), np.concatenate([q[:1], q, [edge / size]])
    )
    radius = np.maximum(r[within], 1e-9 * a)
    blocks = np.array_split(radius / a, math.ceil(radius.size / _BLOCK))
    p[within] = size / a * np.concatenate([integrated_cubics(curve, block[:, None]) for block in blocks])
    if edge != 0.0:
        with np.errstate(divide="ignore"):
            p[within] += edge / (math.pi * np.sqrt((a - radius) * (a + radius)))
        p[r == a] = math.copysign(math.inf, edge)
    return p


def spring_load(state: LineState) -> LineLoad:
    """The load of the springs of one row as punches, of the curve from which :func:`surface_load` is computed."""
    a, (x, q) = state.radius, _inside(state)
    if not a > 0.0 or x.size < 4:
        return LineLoad((), a, 0.0, a, 0.0)
    edge, size = edge_load(state), float(np.max(np.abs(q)))
    curve = scipy.interpolate.PchipInterpolator(
        np.concatenate([[0.0], x / a, [1.0]]), np.concatenate([q[:1], q, [edge]])
    ).derivative()

    def density(above: FloatArray) -> FloatArray:
        return np.asarray(-curve(np.minimum(above / a, 1.0)) / a)

    # its slope has kinks at the springs
    segment = Punches(0.0, a, density, a * curve.x)
    return LineLoad((segment,), a, edge, a, size / a)


def edge_load(state: LineState) -> float:
    """The line load in N/m at the edge of the contact; 0 where it vanishes there up to the resolution of the springs."""
    edge, (_, q) = _edge_load(state), _inside(state)
    return edge if q.size and abs(edge) > _ENDS * abs(q[-1]) else 0.0


def far_from_edge(state: LineState, r: FloatArray) -> FloatArray:
    """Weights of radii in a contact that remove the singularity of a traction whose load does not vanish at the edge."""
    if edge_load(state) == 0.0:
        return np.ones(r.shape)
    x = r / state.radius
    return np.asarray(np.minimum(np.sqrt((1.0 - x) * (1.0 + x) / (1.0 - INSIDE[-1] ** 2)), 1.0))


def integrated_cubics(curve: scipy.interpolate.PPoly, r: FloatArray) -> FloatArray:
    """
    -(1/pi) int_r^a q' / sqrt(x^2 - r^2) dx of a q that is a cubic between the springs, in closed form.

    A quadrature rule would miss that q' is infinite next to a kink of the profile.
    """
    third, second, first, _ = curve.c
    start = curve.x[:-1]
    powers = (
        first - 2.0 * second * start + 3.0 * third * start**2,
        2.0 * second - 6.0 * third * start,
        3.0 * third,
    )
    x = np.maximum(curve.x, r)
    root = np.sqrt((x - r) * (x + r))
    angle = np.arcsinh(root / r)
    moments = angle, root, 0.5 * (x * root + r * r * angle)
    total = sum(np.diff(moment, axis=1) @ power for power, moment in zip(powers, moments, strict=True))
    return np.asarray(-total / math.pi)


class MemoryCheck(NamedTuple):
    """Result of the check of some rows."""

    rows: np.ndarray
    """The checked rows, rising."""
    tension: FloatArray
    """Largest tension inside the contact over its mean pressure; negative without tension, nan with too few springs."""
    overlap: FloatArray
    """Deepest overlap outside over the largest displacement; negative without overlap."""
    errors: dict[str, FloatArray]
    """Errors of the fields over their largest value, from half as many springs."""
    doubt: FloatArray
    """Errors of the pressure over its mean and of the gap over the largest displacement, shape (rows, 2)."""

    @property
    def violated(self) -> int | None:
        """The first index in `rows` with tension or overlap."""
        tension, overlap = _SURELY * self.doubt.T
        wrong = np.flatnonzero((self.tension > _TENSION + tension) | (self.overlap > _OVERLAP + overlap))
        return int(wrong[0]) if wrong.size else None

    def sound(self, size: int) -> BoolArray:
        """Rows before the first tension or overlap; all later rows depend on it."""
        first = self.violated
        where = np.ones(size, dtype=bool)
        if first is not None:
            where[self.rows[first - 1] + 1 if first else self.rows[0] :] = False
        return where

    def error(self, name: str, size: int) -> FloatArray:
        """Errors of all rows, from the checked rows on both sides."""
        return between(self.rows, self.errors[name], size) if self.rows.size else np.zeros(size)


def between(rows: np.ndarray, known: FloatArray, size: int) -> FloatArray:
    """The larger of the values of the checked rows on both sides, one entry per row."""
    after = np.searchsorted(rows, np.arange(size))
    return np.maximum(known[np.minimum(after, known.size - 1)], known[np.maximum(after - 1, 0)])


NOT_CHECKED = MemoryCheck(np.zeros(0, dtype=int), np.zeros(0), np.zeros(0), {}, np.zeros((0, 2)))
"""The result without checked rows."""


def check_memory(surface: MemorySurface, force: FloatArray | None) -> MemoryCheck:
    """
    Check that there is no tension inside and no overlap outside the contact, and estimate the errors of the fields.

    Parameters
    ----------
    force : ndarray or None
        Normal force of every row in N, unless the indentation is prescribed in all rows.
    """
    rows = checked_rows(surface.contact_radius)
    half = replace(surface, n=surface.n // 2)
    extremes: list[tuple[float, float]] = []
    errors: list[tuple[float, float, float]] = []
    doubts: list[tuple[float, float]] = []
    groups = alike(rows, surface.contact_radius)
    followed = (chain.from_iterable(map(level.states, groups)) for level in (surface, half))
    for row, fine, coarse in zip(rows, *followed, strict=True):
        beyond = surface.outside(fine)
        gap, u = surface.gap_and_displacement(fine, row, beyond)
        other_gap, other_u = surface.gap_and_displacement(coarse, row, beyond)
        replayed = 0.0 if force is None else _replayed(fine, row, force)
        r = fine.radius * TO_EDGE
        p, other_p = (surface_load(level, r) * far_from_edge(fine, r) for level in (fine, coarse))
        away = away_from(r, surface.marks(row))
        missed = np.abs(p - other_p)[away]
        r, p = r[: INSIDE.size], p[: INSIDE.size]
        size = max(float(np.max(fine.deflection, initial=0.0)), abs(float(surface.indentation[row])))
        few = 0 < np.count_nonzero(fine.position < fine.radius) < _TELLING
        mean = float(np.sum(p * r) / np.sum(r)) if fine.radius > 0.0 else 0.0
        extremes.append(
            (
                math.nan if few else -float(p.min()) / mean if mean > 0.0 else 0.0,
                math.nan if few else -float(np.min(gap, initial=math.inf)) / size if size > 0.0 else 0.0,
            )
        )
        errors.append(
            (
                1.0
                if surface.hides_edge(fine)
                else _TO_EDGE * _distance(missed, 0.0, float(np.max(np.abs(p), initial=0.0))) + replayed,
                _distance(u, other_u, size) + replayed,
                _distance(gap, other_gap, size) + replayed,
            )
        )
        doubts.append((_distance(missed, 0.0, mean), _distance(gap, other_gap, size)))
    names = ("pressure", "normal_displacement", "gap")
    by_field = np.array(errors).reshape(-1, 3)
    tension, overlap = np.array(extremes).reshape(-1, 2).T
    by_name = dict(zip(names, by_field.T, strict=True))
    return MemoryCheck(np.array(rows, dtype=int), tension, overlap, by_name, np.array(doubts).reshape(-1, 2))


def _replayed(state: LineState, row: int, force: FloatArray) -> float:
    """
    Difference between the force of the springs and that of the row, over the largest force.

    The springs follow indentations linear between rows; with a prescribed force the indentation is not linear there.
    """
    borne = 2.0 * float(np.trapezoid(state.load, state.position)) if state.position.size else 0.0
    return abs(borne - float(force[row])) / (float(np.max(force)) or 1.0)


def away_from(r: FloatArray, kinks: Sequence[float]) -> BoolArray:
    """Whether radii differ by more than 1 % from kinks of the profile, where the pressure may be infinite."""
    away = np.ones(r.shape, dtype=bool)
    for kink in kinks:
        away &= np.abs(r - kink) > _KINK_DISTANCE * kink
    return away


def _distance(values: FloatArray, others: FloatArray | float, size: float) -> float:
    return float(np.max(np.abs(values - others), initial=0.0)) / size if size > 0.0 else 0.0


def checked_rows(radius: FloatArray) -> list[int]:
    """Rows to be checked: the first touch, the last row, the largest contact, and some between."""
    touching = np.flatnonzero(radius > 0.0)
    if touching.size == 0:
        return []
    first, last = int(touching[0]), radius.size - 1
    some = np.unique(np.linspace(first, last, min(last - first + 1, _CHECKED)).astype(int))
    return sorted({*some.tolist(), int(np.nanargmax(radius))})


def alike(rows: Sequence[int], radius: FloatArray) -> list[list[int]]:
    """Rows in groups whose largest contacts so far are of similar size and share one set of springs."""
    so_far = np.fmax.accumulate(radius)[list(rows)]
    with np.errstate(divide="ignore"):
        size = np.floor(np.log(so_far / np.max(so_far, initial=1e-300)) / math.log(_OF_ONE_SIZE))
    return [list(group) for _, group in groupby(rows, dict(zip(rows, size.tolist(), strict=True)).get)]


def memory_claims(
    names: Sequence[str],
    disk: BoolArray,
    forced: BoolArray,
    moved: BoolArray,
    check: MemoryCheck,
    remark: str,
) -> dict[str, Claim]:
    """
    Claims of a contact with memory, valid up to the first row that is not a disk; all later rows depend on it.

    Parameters
    ----------
    disk : ndarray of bool
        Rows whose springs in contact are those of a disk.
    forced, moved : ndarray of bool
        Rows whose force is prescribed, and rows whose indentation is.
    """
    where = np.logical_and.accumulate(disk) & check.sound(disk.size)
    why = "" if disk.all() else "the springs in contact are not those of a disk"
    if (first := check.violated) is not None:
        tension, overlap = float(check.tension[first]), float(check.overlap[first])
        why = (
            f"a disk would need tension inside, {tension:.2g} of its mean pressure"
            if tension > _TENSION
            else f"the surfaces would overlap outside a disk by {overlap:.2g} of the largest displacement"
        )
    if not where.any():
        return dict.fromkeys(names, Claim(Level.NOT_VALID, why, _SOURCE, where)) | _given(
            where, forced, moved
        )
    reason = (
        "exact for viscoelastic half-spaces in frictionless contact on a disk under any history; no tension inside and no "
        f"overlap outside in {np.count_nonzero(~np.isnan(check.tension[:first]))} checked rows{remark}"
    )
    if not where.all():
        reason += f"; not valid from row {int(np.argmin(where)) + 1} of {disk.size} on: {why}"
    return dict.fromkeys(names, Claim(Level.EXACT, reason, _SOURCE, where)) | _given(where, forced, moved)


def _given(where: BoolArray, forced: BoolArray, moved: BoolArray) -> dict[str, Claim]:
    """Claims of prescribed quantities, which are known for any contact."""
    known = {"indentation": where | moved, "normal_force": where | forced}
    return {
        name: Claim(Level.EXACT, "prescribed, or exact on a disk", _SOURCE, rows)
        for name, rows in known.items()
        if rows.any() and not where.all()
    }
