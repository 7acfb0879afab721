"""The cohesive zone of a moving edge that is short compared with its contact: its work by its speed, and an equation for the contact radius."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError, PathError
from pymdr.line.soft import edge
from pymdr.mapping.relaxation import Relaxation
from pymdr.units import FloatArray, metres

_TABLE, _DECADES = 6000, 12.0
"""Entries of the table of passing times, and its decades beyond the shortest and the longest time of retardation."""
_NODES = 4
"""Gauss nodes of an interval of the table of the integrals."""
_TOLERANCE = 1e-8
_POINTS, _EXTENT_OF_TABLES = 4000, 4.0
"""Nodes of the table of the profile, and its first end over the size of the contact."""
_CLOSED = 5e-4
"""Contact radius, over the size of the contact, at which a contact that closes rests."""
_MOST = 300_000
"""Largest number of evaluations of the equation in a stretch."""
_AT_ONCE = 1e-7
"""Shortest passing time over the shortest time of relaxation, with which an edge faster than any steady one moves."""


def _dawson_integrals(x: FloatArray) -> FloatArray:
    """The integral of Dawson's function from 0 to every one of rising x."""
    points, weights = np.polynomial.legendre.leggauss(_NODES)
    half = 0.5 * np.diff(x, prepend=0.0)
    at = (x - 2.0 * half)[:, None] + half[:, None] * (points + 1.0)
    return np.cumsum(half * (scipy.special.dawsn(at) @ weights))


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


class ShortRows(NamedTuple):
    """Rows of a leg in SI units; zeros where the bodies are free."""

    contact_radius: FloatArray
    indentation: FloatArray
    normal_force: FloatArray
    line_load: FloatArray
    """q_a [N/m] at the edge, below 0."""
    unrelaxed: FloatArray
    """Load [N/m] that the springs of the contact have yet to relax."""
    jumped: FloatArray
    """1 in the first row after the edge has parted."""


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
        self.zone, self._profile, self._size, self._end = zone, profile, size, end
        self.free, self.separated = True, False
        self.parted: tuple[float, float] | None = None
        """Depth [m] and force [N] where the edge became faster than any steady one before the bodies parted."""
        relaxation = zone.relaxation
        self._radius, self._lag = 0.0, np.zeros(relaxation.times.size)
        self._springs = np.stack([relaxation.moduli, relaxation.times])
        self._setting = np.zeros(edge.SHORTEST + 1)
        self._setting[edge.RUBBERY], self._setting[edge.GLASSY] = relaxation.rubbery, relaxation.glassy
        self._setting[edge.WORK], self._setting[edge.UNIT] = zone.work, zone.unit
        self._setting[edge.CLOSED], self._setting[edge.SHORTEST] = _CLOSED * size, zone.shortest
        self._tabulate(_EXTENT_OF_TABLES * size)

    def _tabulate(self, radius: float) -> None:
        """Tabulate the profile up to a radius or its end, with nodes that are even in the square root."""
        self._setting[edge.TOP] = top = min(radius, self._end)
        self._table = np.stack(self._profile(top * np.linspace(0.0, 1.0, _POINTS) ** 2))

    def follow(self, time: FloatArray, control: FloatArray, machine_stiffness: float) -> ShortRows:
        """Follow a leg and return its rows.

        Parameters
        ----------
        time, control : ndarray
            Times [s] and D = d + F/k [m], for k = 0 the force [N]; the first entries are those before the leg.
        machine_stiffness : float
            k [N/m]; inf prescribes the indentation, 0 the force.

        Raises
        ------
        ConvergenceError
            If the equation cannot be integrated.
        PathError
            If the bodies touch again after they have separated, or the contact passes the end of the profile.
        """
        rows, k = [], machine_stiffness
        if time[1] == time[0] and self.free:
            # a free body may start anywhere
            rows.append(_out_of_contact(float(control[1]), k))
            time, control = time[1:], control[1:]
        # straight stretches of the control
        steps = np.diff(time)
        lasts = steps > 0.0
        rate = np.divide(np.diff(control), steps, out=np.zeros_like(steps), where=lasts)
        shaken = 1e-9 + 1e-15 * time[-1] / float(np.min(steps, initial=math.inf, where=lasts))
        kinks = np.flatnonzero(np.abs(np.diff(rate)) > shaken * np.max(np.abs(rate), initial=0.0)) + 1
        for first, last in pairwise([0, *kinks.tolist(), time.size - 1]):
            rows += self._stretch(time[first : last + 1], control[first : last + 1], k)
        return ShortRows(*(np.array(column) for column in zip(*rows, strict=True)))

    def _stretch(self, time: FloatArray, control: FloatArray, k: float) -> list[tuple[float, ...]]:
        t0, span = float(time[0]), float(time[-1] - time[0])
        rows: list[tuple[float, ...]] = []
        done = 0
        if self.free:
            # after a separation the surfaces stay apart while they are pulled further
            nearing = not self.separated or control[-1] > control[0]
            touching = np.flatnonzero(control[1:] >= 0.0) if nearing else np.zeros(0, dtype=np.intp)
            done = int(touching[0]) if touching.size else time.size - 1
            rows = [_out_of_contact(each, k) for each in control[1 : done + 1].tolist()]
            if not touching.size:
                return rows
            if self.separated:
                raise PathError(
                    "the bodies touch again after they have separated, which the law of a small zone does not cover; give MaugisDugdale(work, range=...)"
                )
            p0, p1 = float(control[done]), float(control[done + 1])
            until = -p0 / (p1 - p0) if p0 < 0.0 else 0.0
            t0 = float(time[done]) + until * (float(time[done + 1]) - float(time[done]))
            self.free, self._lag[:] = False, 0.0
            self._radius = 8.0 * _CLOSED * self._size
        setting = self._setting
        setting[edge.MACHINE] = k
        setting[edge.BEGIN], setting[edge.CONTROL] = time[0], control[0]
        setting[edge.SLOPE] = (control[-1] - control[0]) / span if span > 0.0 else 0.0
        calls, below = 0, (math.nan, math.nan)
        limit = 2.0 * math.pi * setting[edge.RUBBERY] * self.zone.work * self.zone.limit

        def rates(t: float, y: FloatArray) -> FloatArray:
            nonlocal calls, below
            calls += 1
            if calls > _MOST:
                raise ConvergenceError(
                    f"the equation of the contact radius could not be integrated beyond t = {t:.6g} s, a = {metres(float(y[0]))}: its steps became too "
                    "short; use MaugisDugdale(work, range=...)"
                )
            if setting[edge.TOP] < min(y[0], self._end):
                self._tabulate(2.0 * float(setting[edge.TOP]))
            d, force, _, load = edge.state(t, y, setting, self._springs, self._table)
            # steps of a jump are too short for the roots of an integrator
            if min(load, 0.0) ** 2 <= limit * y[0]:
                below = d, force
            return edge.rates(t, y, setting, self._springs, self._table, self.zone.table)

        y0 = np.concatenate([[self._radius], self._lag])
        deep = float(self._profile(np.array([self._size]))[0][0])
        sizes = np.concatenate([[self._size], np.full(self._lag.size, deep)])
        solved = scipy.integrate.solve_ivp(
            rates,
            (t0, float(time[-1])),
            y0,
            method="LSODA",
            t_eval=np.maximum(time[done + 1 :], t0),
            rtol=_TOLERANCE,
            atol=_TOLERANCE * sizes,
        )
        if solved.status < 0:
            raise ConvergenceError(
                f"the equation of the contact radius could not be integrated beyond t = {float(solved.t[-1]) if len(solved.t) else t0:.6g} s ({solved.message}); use MaugisDugdale(work, range=...)"
            )
        radii = solved.y[0]
        if np.max(radii) > self._end:
            raise PathError(
                f"the contact would pass r = {metres(self._end)}, the last radius at which the profile is known; use a smaller indentation or force"
            )
        open_ = np.flatnonzero(radii < 3.0 * setting[edge.CLOSED])
        end = int(open_[0]) if open_.size else radii.size
        for t, y in zip(solved.t[:end].tolist(), solved.y.T[:end].copy(), strict=True):
            d, force, Q, load = edge.state(t, y, setting, self._springs, self._table)
            rows.append((float(y[0]), d, force, load, Q - setting[edge.RUBBERY] * d, 0.0))
        if open_.size:
            self.free = self.separated = True
            self.parted = below
            first = len(rows)
            rows += [_out_of_contact(each, k) for each in control[1 + first :].tolist()]
            rows[first] = (*rows[first][:-1], 1.0)
        else:
            self._radius, self._lag = float(radii[-1]), solved.y[1:, -1].copy()
        return rows


def _out_of_contact(control: float, k: float) -> tuple[float, ...]:
    """The row of a body out of contact; under a force it is nowhere."""
    d, force = (math.nan, math.nan) if k == 0.0 else (control, 0.0)
    return 0.0, d, force, 0.0, 0.0, 0.0
