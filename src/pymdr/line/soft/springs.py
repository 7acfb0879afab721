"""Springs with memory under Dugdale's zone, in SI units."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.mapping.relaxation import Relaxation
from pymdr.units import FloatArray, metres

FINE, COARSE = (1, 0.05, 0.005), (2, 0.1, 0.01)
"""Spacing of the nodes over the finest, largest move of an edge and largest error of its prediction over the length of the zone."""
_IN_ZONE, _IN_CONTACT, _MOST = 24.0, 500.0, 60_000
"""Nodes in the shortest zone, nodes within the largest, and the largest number of nodes."""
_SOLVED = 1e-9
_BEYOND = 1.05
_SPARE = 8


@dataclass(frozen=True)
class ZoneSetting:
    """A contact with a cohesive zone: springs, stress and profile.

    Attributes
    ----------
    relaxation : Relaxation
        E*(t) [Pa], with an equilibrium modulus and without a parallel dashpot.
    strength, work : float
        Cohesive stress [Pa] and work of adhesion [J/m²].
    profile : callable
        g(x) and int_0^x g dx [m, m²] at arrays of x [m].
    widest : float
        Largest radius of the zone [m].
    """

    relaxation: Relaxation
    strength: float
    work: float
    profile: Callable[[FloatArray], tuple[FloatArray, FloatArray]]
    widest: float

    @property
    def shortest_zone(self) -> float:
        """Length of the zone of a relaxed contact that is long compared with it, π γ E_inf / 4 σ² [m] (Maugis 1992)."""
        return math.pi * self.work * self.relaxation.rubbery / (4.0 * self.strength**2)

    @property
    def spacing(self) -> float:
        """Spacing of the finest nodes [m]."""
        h = min(self.shortest_zone / _IN_ZONE, self.widest / _IN_CONTACT)
        if self.widest / h > _MOST:
            least = self.work / math.sqrt(
                math.pi * self.work * self.relaxation.rubbery * _MOST / (4.0 * _IN_ZONE * self.widest)
            )
            raise ProblemError(
                f"the cohesive zone, {metres(self.shortest_zone)} long, is too short for a contact of {metres(self.widest)}: a range of "
                f"attraction of at least {metres(least)} can be resolved (now {metres(self.work / self.strength)})"
            )
        return h


class ZoneSprings:
    """The springs of one contact, followed leg by leg.

    Parameters
    ----------
    setting : ZoneSetting
    level : tuple of float
        `FINE` or `COARSE`.
    """

    def __init__(self, setting: ZoneSetting, level: tuple[float, float, float]) -> None:
        from pymdr.line.soft import driver, kernels

        relaxation = setting.relaxation
        self._unit, self._firm = setting.widest, relaxation.glassy
        share, tau = relaxation.moduli / self._firm, relaxation.times
        coupling = np.sqrt(share / tau)
        decay, vectors = np.linalg.eigh(np.diag(1.0 / tau) - np.outer(coupling, coupling))
        root = np.sqrt(share * tau)
        self._body = kernels.Body(
            setting.strength / self._firm,
            setting.work / setting.strength / self._unit,
            share.copy(),
            1.0 / tau,
            decay,
            vectors.T @ coupling,
            np.ascontiguousarray(vectors.T * root),
            np.ascontiguousarray(vectors / root[:, None]),
        )
        spacing = level[0] * setting.spacing / self._unit
        size, n = int(_BEYOND / spacing) + _SPARE, tau.size
        x: FloatArray = spacing * np.arange(size, dtype=np.float64)
        g, area = setting.profile(x * self._unit)
        self._line = kernels.Line(spacing, np.asarray(g / self._unit), np.asarray(area / self._unit**2))
        self._state = kernels.State(
            np.zeros(8), np.zeros((size, n)), np.zeros(size), np.zeros(n), np.zeros(n), np.zeros((3, n))
        )
        self._state.now[kernels.DEPTH] = -self._body.height
        self._effort = driver.Effort(level[1], level[2], _SOLVED)

    @property
    def free(self) -> bool:
        """Whether the surfaces are beyond the range of the attraction."""
        from pymdr.line.soft import kernels

        return bool(self._state.now[kernels.OUTER] == 0.0)

    def follow(
        self, time: FloatArray, control: FloatArray, machine_stiffness: float
    ) -> dict[str, FloatArray]:
        """Follow a leg and return its rows in SI units.

        Parameters
        ----------
        time, control : ndarray
            Times [s] and D = d + F/k [m], for k = 0 the force [N]; the first entries are those before the leg.
        machine_stiffness : float
            k [N/m]; inf prescribes the indentation, 0 the force.

        Raises
        ------
        ConvergenceError
            When a step cannot be solved.
        """
        from pymdr.line.soft import driver, kernels

        by_force = machine_stiffness == 0.0
        size, n = self._line.g.size, self._body.rate.size
        load = self._firm * self._unit**2
        softness = 0.0 if math.isinf(machine_stiffness) else load / self._unit / (machine_stiffness or 1.0)
        alpha, beta = (0.0, 1.0) if by_force else (1.0, softness)
        work = (np.zeros(8), np.zeros(n), np.zeros(n), np.zeros((3, n)), np.zeros((3, n)), np.zeros((4, n)))
        step = kernels.Step(0.0, alpha, beta, 0.0, *work, np.zeros(size), np.zeros(size))
        now = self._state.now
        now[kernels.TIME] = time[0]
        if now[kernels.OUTER] == 0.0 and not by_force:
            now[kernels.DEPTH] = control[0] / self._unit
        out = np.zeros((time.size - 1, driver.OUT_STEP + 1))
        scaled = control / (load if by_force else self._unit)
        end = driver.follow_rows(
            self._body,
            self._line,
            self._state,
            step,
            self._effort,
            time.astype(float),
            scaled.astype(float),
            out,
        )
        if end != driver.DONE:
            why = (
                "its zone would be wider than expected"
                if end == driver.TOO_WIDE
                else "its steps became too short"
            )
            raise ConvergenceError(
                f"the contact with memory and a cohesive zone could not be followed beyond t = {now[kernels.TIME]:.6g} s, a = "
                f"{metres(now[kernels.RADIUS] * self._unit)}: {why}; take a longer range of attraction, or a slower path"
            )
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
            "jump_dissipation": (driver.OUT_LOST, energy),
        }
        return {name: unit * out[:, column] for name, (column, unit) in units.items()}
