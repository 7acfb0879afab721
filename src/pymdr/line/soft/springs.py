"""Springs with memory under Dugdale's zone, in SI units."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.mapping.relaxation import Relaxation
from pymdr.units import FloatArray, metres

_IN_ZONE, _IN_CONTACT = 24.0, 1000.0
"""Nodes in the shortest zone, and nodes within the largest."""
_BEYOND, _MORE = 1.05, 1.05
"""End of the springs over the largest radius, and margin of a range that is recommended: the length of a zone is about the square of the range."""
_SPARE = 8
_DRAWN, _NEAR = 2000, 200
"""Nodes from which fields are computed, and all these next to both edges."""


class ZoneLevel(NamedTuple):
    """Resolution of space and time."""

    spacing: float
    """Spacing of the nodes over the finest."""
    cells: float
    """Cells of the gap over the zone."""
    largest: float
    """Largest move of an edge in a step over the length of the zone."""
    missed: float
    """Largest error of its prediction over that length."""
    most: float = 150_000.0
    """Largest number of the finest nodes."""


def zone_level(spacing: float) -> ZoneLevel:
    """The resolution of a spacing of the nodes over the finest of :data:`FINE`."""
    return ZoneLevel(spacing, 48.0 / spacing, 0.03 * spacing, 0.002 * spacing)


FINE, COARSE, ROUGH = map(zone_level, (1.0, 2.0, 4.0))
"""`ROUGH` is for guesses and errors: five times faster than `FINE`, with errors of the force of up to 1e-3 of the largest."""
HASTY = ROUGH._replace(most=30_000.0)
"""For one of many guesses: short zones, which would take seconds, are refused."""


@dataclass(frozen=True)
class ZoneSetting:
    """A contact with a cohesive zone: springs, stress and profile.

    Attributes
    ----------
    relaxation : Relaxation
        E*(t) [Pa], without a parallel dashpot.
    shortest_zone : float
        Length of the shortest zone [m].
    strength, work : float
        Cohesive stress [Pa] and work of adhesion [J/m²].
    profile : callable
        g(x) and int_0^x g dx [m, m²] at arrays of x [m].
    widest : float
        Largest radius of the zone [m].
    """

    relaxation: Relaxation
    shortest_zone: float
    strength: float
    work: float
    profile: Callable[[FloatArray], tuple[FloatArray, FloatArray]]
    widest: float

    @property
    def nodes(self) -> float:
        """Number of the finest nodes."""
        return max(_IN_ZONE * self.widest / self.shortest_zone, _IN_CONTACT)

    def spacing(self, level: ZoneLevel) -> float:
        """Spacing of the nodes [m]."""
        if self.nodes > level.most:
            # zones are about as long as the square of their range, on contacts that change with it
            least = _MORE * self.work / self.strength * math.sqrt(self.nodes / level.most)
            raise ProblemError(
                f"the cohesive zone, {metres(self.shortest_zone)} long, is too short for a contact of {metres(self.widest)}; give a range of "
                f"attraction of at least {metres(least)} (now {metres(self.work / self.strength)})"
            )
        return level.spacing * self.widest / self.nodes


@dataclass(frozen=True)
class ZoneLine:
    """The springs of one row, by which its fields are computed."""

    contact_radius: float
    """a in m; 0 where only the attraction acts."""
    cohesive_radius: float
    """c in m; 0 for free surfaces."""
    indentation: float
    """d in m."""
    inside: FloatArray
    """x in m from 0 to a; empty without contact."""
    lag: FloatArray
    """sum E_i y_i / E_0 in m there, with the displacements of the dashpots v_i = D_i(t) - g + y_i."""
    outside: FloatArray
    """x in m from a on, c among them."""
    creep: FloatArray
    """W = sum E_i v_i / E_0 in m there."""


class ZoneSprings:
    """The springs of one contact, followed leg by leg.

    Parameters
    ----------
    setting : ZoneSetting
    level : ZoneLevel
        `FINE` or `COARSE`.
    watched : sequence of int, optional
        Rows, counted from 0 over all legs in rising order, whose springs are kept in `lines`.
    """

    def __init__(self, setting: ZoneSetting, level: ZoneLevel, watched: Sequence[int] = ()) -> None:
        from pymdr.line.soft import driver, kernels

        self.setting, relaxation = setting, setting.relaxation
        self.spacing = level.spacing
        self._unit, self._firm = setting.widest, relaxation.glassy
        body = np.vstack(relaxation.modes)
        spacing = setting.spacing(level) / self._unit
        size, n = int(_BEYOND / spacing) + _SPARE, body.shape[1]
        x: FloatArray = spacing * np.arange(size, dtype=np.float64)
        g, area = setting.profile(x * self._unit)
        self._limits = np.array([level.largest, level.missed])
        self._watched, self._rows = watched, 0
        self.lines: list[ZoneLine] = []
        """The springs of the watched rows so far."""
        zeros = np.zeros
        self._zone = kernels.Zone(
            body,
            np.vstack([g / self._unit, area / self._unit**2]),
            zeros(7),
            zeros((size, n + 1)),
            zeros((8, n)),
            zeros(16),
            zeros((8, n)),
            zeros((9, n)),
            zeros((2, 4)),
            zeros((2, size)),
            zeros(size, dtype=np.int64),
        )
        height = setting.work / setting.strength / self._unit
        self._zone.now[kernels.DEPTH] = -height
        end = self._zone.end
        end[kernels.SIGMA], end[kernels.HEIGHT] = setting.strength / self._firm, height
        end[kernels.SPACING], end[kernels.CELLS] = spacing, level.cells
        self._pace = zeros(driver.ROW + 1)

    @property
    def state(self) -> tuple[FloatArray, ...]:
        """All that the springs remember, in arrays that :meth:`follow` changes."""
        zone = self._zone
        return zone.now, zone.node, zone.edge, zone.end, self._pace

    @property
    def free(self) -> bool:
        """Whether the surfaces are beyond the range of the attraction."""
        from pymdr.line.soft import kernels

        return bool(self._zone.now[kernels.OUTER] == 0.0)

    def _line(self) -> ZoneLine:
        """The springs now."""
        from pymdr.line.soft import kernels as k

        zone, unit = self._zone, self._unit
        t, a, c, d = (float(v) for v in zone.now[: k.FORCE])
        h, touching = float(zone.end[k.SPACING]), k.TOUCHING * float(zone.end[k.SPACING])
        size, n = zone.node.shape[0], zone.body.shape[1]
        i = np.arange(size)
        x: FloatArray = h * np.arange(size, dtype=np.float64)
        stride = max(size // _DRAWN, 1)
        near = np.minimum(np.abs(x - a), np.abs(x - c)) < _NEAR * h
        i = i[near | (i % stride == 0)]
        x = x[i]
        entries, idle = zone.node[i, :n], t - zone.node[i, n:]
        within, beyond = (x < a - touching) & (a > 0.0), (x > a + touching) | (a == 0.0)
        lag = (entries * np.exp(-zone.body[k.RATE] * idle))[within] @ zone.body[k.FRACTION]
        creep = (entries * np.exp(-zone.body[k.DECAY] * idle))[beyond] @ zone.body[k.PARTICIPATION]
        inside, outside = x[within], x[beyond]
        if a > 0.0:
            inside, outside = np.append(inside, a), np.append(a, outside)
            lag = np.append(lag, zone.edge[k.INNER_EDGE] @ zone.body[k.FRACTION])
            creep = np.append(zone.edge[k.OUTER_EDGE] @ zone.body[k.PARTICIPATION], creep)
        if c > 0.0:
            distinct = np.abs(outside - c) > touching
            place = int(np.searchsorted(outside[distinct], c))
            outside = np.insert(outside[distinct], place, c)
            creep = np.insert(creep[distinct], place, zone.edge[k.RIM] @ zone.body[k.PARTICIPATION])
        return ZoneLine(unit * a, unit * c, unit * d, unit * inside, unit * lag, unit * outside, unit * creep)

    def follow(
        self, time: FloatArray, control: FloatArray, machine_stiffness: float, onward: bool = False
    ) -> dict[str, FloatArray]:
        """Follow a leg and return its rows in SI units.

        Parameters
        ----------
        time, control : ndarray
            Times [s] and D = d + F/k [m], for k = 0 the force [N]; the first entries are those before the leg.
        machine_stiffness : float
            k [N/m]; inf prescribes the indentation, 0 the force.
        onward : bool
            Whether the rows are further ones of the leg before: steps then go on as in one leg.

        Raises
        ------
        ConvergenceError
            When a step cannot be solved.
        """
        from pymdr.line.soft import driver, kernels

        by_force = machine_stiffness == 0.0
        load = self._firm * self._unit**2
        softness = 0.0 if math.isinf(machine_stiffness) else load / self._unit / (machine_stiffness or 1.0)
        trial, now = self._zone.end, self._zone.now
        trial[kernels.ALPHA], trial[kernels.BETA] = (0.0, 1.0) if by_force else (1.0, softness)
        if not onward:
            trial[kernels.RISE] = 0.0
            self._pace[:] = 0.0
        if now[kernels.OUTER] == 0.0 and not by_force:
            now[kernels.DEPTH] = control[0] / self._unit
        out = np.zeros((time.size - 1, driver.OUTPUTS))
        out[:, [driver.OUT_EVENT_D, driver.OUT_JUMP_TIME]] = math.nan
        spans = np.diff(time)
        scaled = control.astype(float) / (load if by_force else self._unit)
        zone = driver.addressed(self._zone)
        watched = [row - self._rows + 1 for row in self._watched if 0 <= row - self._rows < spans.size]
        ends = sorted({*watched, spans.size})
        for begin, end in zip([0, *ends], ends, strict=False):
            rows = scaled[begin : end + 1], out[begin:end]
            why = driver.follow_rows(zone, self._limits, self._pace, spans[begin:end], *rows)
            row, self._pace[driver.ROW] = begin + int(self._pace[driver.ROW]), 0.0
            if why != driver.DONE:
                reason = (
                    "its zone becomes wider than the grid of springs allows"
                    if why == driver.TOO_WIDE
                    else "its steps became too short"
                )
                raise ConvergenceError(
                    f"the contact with memory and a cohesive zone could not be followed beyond t = {time[row] + now[kernels.TIME]:.6g} s, a = "
                    f"{metres(now[kernels.RADIUS] * self._unit)}: {reason}; use a longer range of attraction, or a slower path"
                )
            if end in watched:
                self.lines.append(self._line())
        self._rows += spans.size
        energy = load * self._unit
        units = {
            "contact_radius": (driver.OUT_A, self._unit),
            "cohesive_radius": (driver.OUT_C, self._unit),
            "indentation": (driver.OUT_D, self._unit),
            "normal_force": (driver.OUT_F, load),
            "jumped": (driver.OUT_JUMPED, 1.0),
            "elastic_energy": (driver.OUT_STORED, energy),
            "surface_energy": (driver.OUT_COHESIVE, energy),
            "work": (driver.OUT_WORK, energy),
            "jump_dissipation": (driver.OUT_JUMP_LOSS, energy),
            "body_dissipation": (driver.OUT_SPENT, energy),
            "event_depth": (driver.OUT_EVENT_D, self._unit),
            "event_force": (driver.OUT_EVENT_F, load),
            "jump_time": (driver.OUT_JUMP_TIME, 1.0),
        }
        columns = {name: unit * out[:, column] for name, (column, unit) in units.items()}
        columns["jump_time"] += time[:-1]
        return columns
