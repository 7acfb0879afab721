"""Fields of a contact with memory, from the springs of the row that is asked for; and whether its pressure is one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import PchipInterpolator

from pymdr.interpretation.validity import SOURCES, BoolArray, Claim, Level
from pymdr.line.curves import ElasticLine
from pymdr.line.memory import MemoryState, Relaxation, follow_springs, line_state, virgin
from pymdr.mapping.abel import Curve, gauss
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.units import FloatArray

_NODES = 96
_TENSION = 1e-3
"""Of the mean pressure: what the distance of the springs can do to a pressure."""
_CHECKED = 48
"""Most rows whose pressure is looked at."""
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


@dataclass(frozen=True, eq=False)
class MemorySurface:
    """Surface and line of a contact with memory, whose springs are followed again to the row that is asked for."""

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
        a = float(self.contact_radius[step]) or float(np.max(self.contact_radius, initial=0.0)) or 1.0
        inner = a * np.sin(np.linspace(0.0, math.pi / 2.0, 101))
        top = min(2.0 * a, self.equivalent.reach)
        return np.unique(np.concatenate([inner, a + (top - a) * np.linspace(0.0, 1.0, 61)[1:] ** 2]))

    def marks(self, step: int) -> Sequence[float]:
        """Radii in m in the contact at which its pressure may have a kink."""
        return self.equivalent.kinks(float(self.contact_radius[step]))

    def edge_amplitude(self, step: int) -> float:
        """Amplitude of the pressure at the edge in Pa m^0.5: not 0 only where a dashpot stands beside the springs."""
        state = self.line_state(step)
        if self.relaxation.viscosity == 0.0 or state.radius <= 0.0:
            return 0.0
        return float(edge_load(state) / (math.pi * math.sqrt(2.0 * state.radius)))

    def line_state(self, step: int) -> LineState:
        """The springs of one row."""
        return _state_at(self, step)

    def states(self, steps: Sequence[int]) -> Iterator[LineState]:
        """The springs of rising rows, followed once."""
        line = ElasticLine(self.equivalent, 1.0)
        state: MemoryState = virgin(*self.start())
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
        """When in s and where in m the history begins."""
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
            return np.interp(at, state.position, state.load, right=0.0) * (at <= state.radius)
        if name == "pressure":
            return pressure(state, at)
        u = self._displacement(state, d, at)
        if name == "normal_displacement":
            return u
        return np.where(at <= state.radius, 0.0, self.gap_function(at) - d + u)

    def _displacement(self, state: LineState, d: float, r: FloatArray) -> FloatArray:
        """D - f(r) in the contact, (2/pi) int_0^r w / sqrt(r^2 - x^2) dx outside."""
        inside = (r <= state.radius) & (state.radius > 0.0)
        u = displacement(state, np.where(inside, 0.0, r))
        u[inside] = d - self.gap_function(r[inside])
        return u


def displacement(state: LineState, r: FloatArray) -> FloatArray:
    """Displacement (2/pi) int_0^r w / sqrt(r^2 - x^2) dx in m of the surface at radii above 0; 0 at others."""
    u = np.zeros(r.shape)
    far = np.flatnonzero(r > 0.0)
    if state.position.size == 0 or far.size == 0:
        return u
    w = PchipInterpolator(np.append(0.0, state.position), np.append(state.deflection[0], state.deflection))
    top, (t, weights) = float(state.position[-1]), gauss(_NODES)
    for i in far:
        # w bends at the edge of the contact and ends where nothing was touched
        ends = np.unique(np.arcsin(np.minimum(np.array([0.0, state.radius, top, r[i]]) / r[i], 1.0)))
        width = np.diff(ends)
        angle = ends[:-1, None] + width[:, None] * t
        x = r[i] * np.sin(angle)
        values = np.where(x <= top, w(np.minimum(x, top)), 0.0)
        u[i] = 2.0 / math.pi * float(width @ (values @ weights))
    return u


@lru_cache(maxsize=8)
def _state_at(surface: MemorySurface, step: int) -> LineState:
    *_, state = surface.states([step])
    return state


def edge_load(state: LineState) -> float:
    """The line load in N/m continued to the edge of the contact."""
    inside = state.position < state.radius
    if inside.sum() < 2:
        return 0.0
    x, q = state.position[inside][-2:], state.load[inside][-2:]
    return float(q[-1] + (q[-1] - q[-2]) / (x[-1] - x[-2]) * (state.radius - x[-1]))


def pressure(state: LineState, r: FloatArray) -> FloatArray:
    """
    Pressure -(1/pi) [int_r^a q' / sqrt(x^2 - r^2) dx - q(a) / sqrt(a^2 - r^2)] in Pa of the springs of one row.

    q runs through the springs by a shape-preserving curve, so that it errs by about the square of their distance.
    """
    a = state.radius
    p = np.zeros(r.shape)
    inside = state.position < a
    within = r < a
    if inside.sum() < 4 or not within.any():
        return p
    x, q = state.position[inside], state.load[inside]
    edge = edge_load(state) if q[-1] > 0.25 * q.max() else 0.0
    curve = PchipInterpolator(
        np.concatenate([[0.0], x, [a]]), np.concatenate([q[:1], q, [edge]])
    ).derivative()
    s, weights = gauss(_NODES)
    radius = np.maximum(r[within], 1e-9 * a)[:, None]
    root = np.sqrt((a - radius) * (a + radius))
    # with x^2 = r^2 + (a^2 - r^2) s^2 the integrand is q' / x
    at = np.sqrt(radius * radius + (root * s) ** 2)
    p[within] = -(root * curve(np.minimum(at, a)) / at) @ weights / math.pi
    if edge != 0.0:
        with np.errstate(divide="ignore"):
            p[within] += edge / (math.pi * root[:, 0])
    return p


def checked_rows(radius: FloatArray) -> list[int]:
    """Rows in contact whose pressures tell of the others: the last, the largest, and some between."""
    touching = np.flatnonzero(radius > 0.0)
    if touching.size == 0:
        return []
    some = touching[np.unique(np.linspace(0, touching.size - 1, min(touching.size, _CHECKED)).astype(int))]
    return sorted({*some.tolist(), int(np.argmax(radius))})


def least_pressure(state: LineState) -> float:
    """The least pressure over the mean pressure."""
    a = state.radius
    r: FloatArray = a * (np.arange(64.0) + 0.5) / 66.0
    p = pressure(state, r)
    mean = float(np.sum(p * r) / np.sum(r))
    return float(p.min()) / mean if mean > 0.0 else 0.0


def memory_claims(
    names: Sequence[str],
    disk: BoolArray,
    forced: BoolArray,
    moved: BoolArray,
    tension: float,
    checked: int,
    remark: str,
) -> dict[str, Claim]:
    """
    Claims of a contact with memory.

    Parameters
    ----------
    names : sequence of str
        Quantities and fields.
    disk : ndarray of bool
        Rows whose springs in contact are those of a disk.
    forced, moved : ndarray of bool
        Rows whose force is prescribed, and rows whose indentation is.
    tension : float
        Largest tension that was found, over the mean pressure.
    checked : int
        Rows at which it was looked for.
    remark : str
        What the numbers rest on.

    Returns
    -------
    dict of str to Claim
    """
    where = disk if tension <= _TENSION else np.zeros(disk.shape, dtype=bool)
    if not where.any():
        why = "the springs in contact are not those of a disk"
        if tension > _TENSION:
            why = f"a disk would need tension inside, {tension:.2g} of its mean pressure"
        return dict.fromkeys(names, Claim(Level.NOT_VALID, why, _SOURCE, where)) | _given(
            where, forced, moved
        )
    reason = (
        "exact for viscoelastic half-spaces in frictionless contact on a disk under any history: what a spring bears and "
        f"how it is shortened are bound by the same law as traction and displacement of the surface; no tension was found in "
        f"{checked} rows{remark}"
    )
    if not disk.all():
        reason += f"; {int((~disk).sum())} of {disk.size} rows are no disk"
    return dict.fromkeys(names, Claim(Level.EXACT, reason, _SOURCE, where)) | _given(where, forced, moved)


def _given(where: BoolArray, forced: BoolArray, moved: BoolArray) -> dict[str, Claim]:
    """What is known whatever the contact is."""
    known = {"indentation": where | moved, "normal_force": where | forced}
    return {
        name: Claim(Level.EXACT, "prescribed, or exact on a disk", _SOURCE, rows)
        for name, rows in known.items()
        if rows.any() and not where.all()
    }
