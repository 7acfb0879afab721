"""The cohesive zone of a moving edge that is short compared with its contact: its work by its speed, and an equation for the contact radius."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError, PathError
from pymdr.line.soft import edge
from pymdr.mapping.relaxation import Relaxation
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray, metres

_TABLE, _DECADES = 6000, 12.0
"""Entries of the table of passing times, and its decades beyond the shortest and the longest time of retardation."""
_NODES = 4
"""Gauss nodes of an interval of the table of the integrals."""
_POINTS, _EXTENT_OF_TABLES = 4000, 4.0
"""Nodes of the table of the profile, and its first end over the size of the contact."""
_CLOSED = 5e-4
"""Contact radius, over the size of the contact, at which a contact that closes rests."""
_TOUCHING = 8.0
"""Contact radius of the first touch, over that at which a contact rests."""
_FIRST = 1e-3
"""First step over the shortest relaxation time."""
_AT_ONCE = 1e-7
"""Shortest passing time over the shortest time of relaxation, with which an edge faster than any steady one moves."""


def _dawson_integrals(x: FloatArray) -> FloatArray:
    """The integral of Dawson's function from 0 to every one of rising x."""
    points, weights = gauss(_NODES)
    width = np.diff(x, prepend=0.0)
    at = (x - width)[:, None] + width[:, None] * points
    return np.cumsum(width * (scipy.special.dawsn(at) @ weights))


@dataclass(frozen=True)
class SmallZone:
    """A cohesive zone, short compared with its contact, of an edge that moves steadily on a relaxed body.

    With the reduced creep j(t) = E_inf J(t) = 1 - Σ c_i exp(-λ_i t), the work of adhesion γ, the line load q_a at the edge, the energy
    release rate G = q_a² / (2π a E_inf), the length l of the zone and the time s = l/V of its passage,

        receding:   γ/G = 1 - Σ c_i K(λ_i s) = M0,                            l = π G E_inf / (4σ²),
        advancing:  G/γ = D1²/M,  D1 = 1 - Σ c_i D(√(λ_i s))/√(λ_i s),  M = 2 D1 - M0,   l = π γ E_inf / (4σ² M),

    where D is Dawson's function and K(T) = (2/T) ∫_0^√T D(y) dy.

    Parameters
    ----------
    relaxation : Relaxation
        E*(t) [Pa] of a solid with an instantaneous modulus.
    work : float
        γ [J/m²].
    strength : float
        σ [Pa].

    Notes
    -----
    Schapery (1975), Int. J. Fract. 11, 141-159, for cracks; here by the springs of the line, whose load at the edge vanishes as a square root.
    G lies between γ E_inf/E_0 (fast advance), γ (rest) and γ E_0/E_inf (fast recession).

    Examples
    --------
    >>> import pymdr as mdr
    >>> rubber = mdr.relaxation_of(mdr.Viscoelastic(mdr.StandardSolid(0.25, 2.25, 1.0), poisson=0.5))
    >>> zone = SmallZone(rubber, work=1.0, strength=6.0)
    >>> zone.work_at([-1e9, -1e-9, 1e-9, 1e9]).round(5).tolist()
    [0.1, 1.0, 1.0, 10.0]
    """

    relaxation: Relaxation
    work: float
    strength: float
    table: FloatArray = field(init=False, repr=False, compare=False)
    """Rows of logarithms of passing times [s], and γ/G of recession, G/γ and M of advance there, all rising."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "table", self._tabulated())

    @property
    def creep(self) -> tuple[FloatArray, FloatArray]:
        """Amplitudes and rates [1/s] of the reduced creep."""
        creep = self.relaxation.retardation
        return creep.compliances * self.relaxation.rubbery, 1.0 / creep.times

    @property
    def unit(self) -> float:
        """Length π γ E_inf/4σ² [m] of the zone at rest."""
        return math.pi * self.work * self.relaxation.rubbery / (4.0 * self.strength**2)

    @property
    def shortest(self) -> float:
        """Logarithm of the passing time [s] of an edge beyond the limits."""
        return math.log(_AT_ONCE * float(self.relaxation.times.min()))

    @property
    def limit(self) -> float:
        """G/γ of the fastest steady recession."""
        return 1.0 / float(np.interp(self.shortest, self.table[0], self.table[1]))

    def _tabulated(self) -> FloatArray:
        amplitudes, rates = self.creep
        times = np.geomspace(10.0**-_DECADES / rates.max(), 10.0**_DECADES / rates.min(), _TABLE)
        mean, last = np.ones(_TABLE), np.ones(_TABLE)
        for c, rate in zip(amplitudes, rates, strict=True):
            T = rate * times
            root = np.sqrt(T)
            # for small T the quotient of the integral loses no digits
            mean -= c * 2.0 * _dawson_integrals(root) / T
            last -= c * scipy.special.dawsn(root) / root
        M = 2.0 * last - mean
        return np.stack([np.log(times), mean, last * last / M, M])

    def speed(self, release_rate: float) -> float:
        """Return the speed da/dt [m/s] of the edge at an energy release rate [J/m²], below 0 where it recedes; a very large one beyond the limits."""
        return float(edge.speed(release_rate / self.work, self.table, self.unit, self.shortest))

    def zone_length(self, release_rate: ArrayLike) -> FloatArray:
        """Return l [m] at energy release rates [J/m²]: that of recession above γ, that of advance below."""
        fraction = np.asarray(release_rate, dtype=float) / self.work
        _, _, advance, M = self.table
        length = self.unit * np.where(fraction >= 1.0, fraction, 1.0 / np.interp(fraction, advance, M))
        return np.asarray(length)

    def work_at(self, speed: ArrayLike) -> FloatArray:
        """Return the energy release rate G [J/m²] of an edge that recedes at a speed V [m/s]; it advances below 0."""
        at, mean, advance, M = self.table
        unit = self.unit
        v = np.asarray(speed, dtype=float)
        with np.errstate(divide="ignore"):
            slowness = -np.log(np.abs(v))
        receding = 1.0 / np.interp(slowness, at + np.log(mean / unit), mean)
        fraction: FloatArray = np.where(
            v >= 0.0, receding, np.interp(slowness, at + np.log(M / unit), advance)
        )
        return np.asarray(self.work * fraction)


class ShortSprings:
    """The contact radius of one contact with a small zone, followed leg by leg.

    The springs of the contact share their history: q(x) = Q - E_inf g(x) with Q = ∫E(t - s) d'(s) ds, which is exact where those that the edge
    reaches have relaxed. So q_a = Q - E_inf g(a), F = 2 (a Q - E_inf ∫_0^a g dx), and da/dt = V(G).

    Parameters
    ----------
    zone : SmallZone
    profile : callable
        g(x) and int_0^x g dx [m, m²].
    size : float
        A contact radius [m] of the problem, for the tolerance.
    end : float
        Last radius [m] at which the profile is known, or inf.
    """

    def __init__(
        self,
        zone: SmallZone,
        profile: Callable[[FloatArray], tuple[FloatArray, FloatArray]],
        size: float,
        end: float,
    ) -> None:
        self.setting, self._profile, self._end = zone, profile, end
        relaxation = zone.relaxation
        n = relaxation.times.size
        setting = np.zeros(edge.LIMIT + 1)
        setting[edge.RUBBERY], setting[edge.GLASSY] = relaxation.rubbery, relaxation.glassy
        setting[edge.WORK], setting[edge.UNIT] = zone.work, zone.unit
        setting[edge.CLOSED], setting[edge.SHORTEST] = _CLOSED * size, zone.shortest
        setting[edge.LIMIT] = zone.limit
        depth = float(profile(np.array([size]))[0][0])
        energy = relaxation.rubbery * depth**2 * size + zone.work * math.pi * size**2
        self._now = np.zeros(edge.RADIUS + 2 + n)
        self._now[edge.FREE], self._now[edge.PACE] = 1.0, _FIRST * float(relaxation.times.min())
        self._now[edge.PARTED_DEPTH : edge.PARTED_FORCE + 1] = math.nan
        self._equation = edge.Equation(
            setting,
            np.stack([relaxation.moduli, relaxation.times]),
            np.zeros((2, _POINTS)),
            zone.table,
            np.array([size, *[depth] * n, energy]),
            np.zeros((edge.LEVELS + 1, n + 2)),
        )
        self._tabulate(_EXTENT_OF_TABLES * size)

    @property
    def state(self) -> tuple[FloatArray, ...]:
        """All that the contact remembers, in an array that :meth:`follow` changes."""
        return (self._now,)

    @property
    def free(self) -> bool:
        """Whether the bodies are out of contact."""
        return bool(self._now[edge.FREE] > 0.0)

    @property
    def parted(self) -> tuple[float, float] | None:
        """Depth [m] and force [N] where the edge became faster than any steady one before the bodies parted."""
        if not self._now[edge.SEPARATED] > 0.0:
            return None
        return float(self._now[edge.PARTED_DEPTH]), float(self._now[edge.PARTED_FORCE])

    def _tabulate(self, radius: float) -> None:
        """Tabulate the profile up to a radius or its end, with nodes that are even in the square root."""
        self._equation.setting[edge.TOP] = top = min(radius, self._end)
        root = np.linspace(0.0, 1.0, _POINTS)
        self._equation.profile[:] = self._profile(top * root**2)
        squares = self._equation.profile[0] ** 2 * (2.0 * top * root)
        self._squares = scipy.interpolate.CubicSpline(root, squares).antiderivative()

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
            Without effect: the steps of a leg go on as those of the leg before.

        Raises
        ------
        ConvergenceError
            If the equation cannot be integrated.
        PathError
            If the bodies touch again after they have separated, or the contact passes the end of the profile.
        """
        now, k = self._now, machine_stiffness
        self._equation.setting[edge.MACHINE] = k
        spans, controls = np.diff(time), control.astype(float)
        out = np.zeros((spans.size, edge.OUTPUTS))
        row = 0
        while row < spans.size:
            if self.free:
                first = self._touch(spans, controls, row)
                out[row:first, edge.OUT_SPENT] = now[-1]
                row = first
                continue
            ends, done = edge.follow_rows(now, self._equation, spans[row:], controls[row:], out[row:])
            row += done
            if ends == edge.BEYOND and self._equation.setting[edge.TOP] < self._end:
                self._tabulate(2.0 * float(self._equation.setting[edge.TOP]))
            elif ends == edge.BEYOND:
                raise PathError(
                    f"the contact would pass r = {metres(self._end)}, the last radius at which the profile is known; use a smaller indentation or force"
                )
            elif ends == edge.STUCK:
                raise ConvergenceError(
                    f"the equation of the contact radius could not be integrated beyond t = {time[row] + now[edge.PASSED]:.6g} s, a = "
                    f"{metres(float(now[edge.RADIUS]))}: its steps became too short; use MaugisDugdale(work, range=...)"
                )
        nowhere = np.full(spans.size, math.nan), math.nan
        return self._columns(out, nowhere if k == 0.0 else (controls[1:], 0.0))

    def _touch(self, spans: FloatArray, controls: FloatArray, row: int) -> int:
        """Bring free bodies into contact in the first row that does so from a row on; the number of that row, or of all rows."""
        now = self._now
        touching = controls[row + 1 :] >= 0.0
        # a free body may start anywhere
        touching &= spans[row:] > 0.0
        if now[edge.SEPARATED] > 0.0:
            # after a separation the surfaces stay apart while they are pulled further
            touching &= np.diff(controls[row:]) > 0.0
        if not touching.any():
            return spans.size
        if now[edge.SEPARATED] > 0.0:
            raise PathError(
                "the bodies touch again after they have separated, which the law of a small zone does not cover; give MaugisDugdale(work, range=...)"
            )
        row += int(np.argmax(touching))
        before, after = controls[row], controls[row + 1]
        now[edge.FREE], now[edge.RADIUS :] = 0.0, 0.0
        now[edge.RADIUS] = _TOUCHING * self._equation.setting[edge.CLOSED]
        now[edge.PASSED] = spans[row] * before / (before - after) if before < 0.0 else 0.0
        return row

    def _columns(self, out: FloatArray, free: tuple[FloatArray, float]) -> dict[str, FloatArray]:
        """Rows by name, with the depths and the force of free bodies."""
        a, d, force, load, unrelaxed, spent, parts, strains = out.T
        rubbery, zone = self.setting.relaxation.rubbery, self.setting
        attached = a > 0.0
        d, force = np.where(attached, d, free[0]), np.where(attached, force, free[1])
        with np.errstate(divide="ignore", invalid="ignore"):
            released = np.where(attached, np.minimum(load, 0.0) ** 2 / (2.0 * math.pi * a * rubbery), 0.0)
        area = (a * (unrelaxed + rubbery * d) - 0.5 * force) / rubbery
        squares = self._squares(np.sqrt(a / self._equation.setting[edge.TOP]))
        stored = rubbery * (d * (a * d - 2.0 * area) + squares) + a * strains
        return {
            "contact_radius": a.copy(),
            "cohesive_radius": np.where(attached, a + zone.zone_length(released), 0.0),
            "indentation": d,
            "normal_force": force,
            "energy_release_rate": released,
            "line_load": load,
            "unrelaxed": unrelaxed,
            "jumped": parts,
            "elastic_energy": np.where(attached, stored, 0.0),
            "surface_energy": -math.pi * zone.work * a**2,
            "body_dissipation": spent,
            "jump_dissipation": np.zeros(a.size),
        }
