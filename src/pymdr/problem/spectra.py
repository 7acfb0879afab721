"""Kernels of springs and dashpots: relaxation and creep as sums of exponentials, and their conversion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.numerics.roots import boundary
from pymdr.problem.values import Value
from pymdr.units import FloatArray

_ALIKE = 1e-9
"""Relative distance below which poles are merged; the error is a tenth of its square."""
_SMALLEST = 460.0
"""Logarithm of the smallest distance of a zero from a pole, relative to half the distance of the poles."""


class Fractions(NamedTuple):
    """h(s) = constant + sum_i weights_i s/(s + poles_i) + slope s, with terms not below 0 and not all 0."""

    constant: float
    weights: FloatArray
    poles: FloatArray
    slope: float


def reciprocal(h: Fractions) -> Fractions:
    """
    1/h as fractions of 1/s.

    Returns
    -------
    Fractions
        The k with 1/h(s) = k(1/s). Its poles are the inverses of the zeros of h, its weights above 0.

    Notes
    -----
    Zeros and poles of h alternate on the negative axis (Gross, 1953, Mathematical Structure of the Theories of
    Viscoelasticity). Each zero is computed from its distance to the nearer pole, so that no digits are lost close to a
    pole; the weights are products of such distances.

    Examples
    --------
    >>> reciprocal(Fractions(1.0, np.array([1.0]), np.array([1.0]), 0.0))
    Fractions(constant=0.5, weights=array([0.5]), poles=array([2.]), slope=0.0)
    """
    merged = _merged(h)
    constant, weights, poles, slope = merged
    zeros, distances = zeros_between(merged)
    total = constant + float(weights.sum())
    with np.errstate(over="ignore", divide="ignore"):
        residues = _residues(zeros, distances, constant == 0.0) / (zeros * (slope if slope > 0.0 else total))
    kept = (residues > 0.0) & np.isfinite(residues)
    return Fractions(
        1.0 / total if slope == 0.0 else 0.0,
        residues[kept],
        1.0 / zeros[kept],
        1.0 / (float((weights / poles).sum()) + slope) if constant == 0.0 else 0.0,
    )


def _residues(zeros: FloatArray, distances: FloatArray, flows: bool) -> FloatArray:
    """
    Residues at -zeros of prod(s + poles) / prod(s + zeros), divided by s if the material flows.

    Errors of the zeros are small compared with their distances to the poles, so the inverse is that of fractions equal to the
    given ones to rounding: Gu and Eisenstat (1994), SIAM J. Matrix Anal. Appl. 15, 1266.
    """
    if not distances.size:
        return np.ones(zeros.size)
    i = np.arange(zeros.size)
    pole_between = np.minimum(np.minimum(i[:, None], i) + int(flows), distances.shape[1] - 1)
    gaps = distances[i[:, None], pole_between] - distances[i, pole_between]
    np.fill_diagonal(gaps, 1.0)
    if flows:
        gaps = np.column_stack([-zeros, gaps])
    ratios = np.ones(gaps.shape)
    ratios[:, : distances.shape[1]] = distances
    return np.asarray(np.abs(np.prod(ratios / gaps, axis=1)))


class Modes(NamedTuple):
    """
    Springs under load as modes that creep independently.

    With the fractions e_i = E_i/E(0) of the modulus, a load q on E(0) moves the dashpots by v_i' = (w - v_i)/tau_i, w = q + sum_i e_i v_i.
    The modes m = into v obey m_j' = -decay_j m_j + participation_j q and give sum_i e_i v_i = participation . m and v = back m.
    """

    fraction: FloatArray
    """e_i of distinct times."""
    rate: FloatArray
    """1/tau_i in 1/s, rising."""
    decay: FloatArray
    """In 1/s, rising; the first is 0 if the material flows."""
    participation: FloatArray
    """In 1/s^(1/2)."""
    into: FloatArray
    back: FloatArray


def _merged(h: Fractions) -> Fractions:
    """The same with distinct rising poles."""
    order = np.argsort(h.poles)
    order = order[h.weights[order] > 0.0]
    weights, poles = h.weights[order], h.poles[order]
    if poles.size:
        first = np.flatnonzero(np.diff(poles, prepend=0.0) > _ALIKE * poles)
        moments, weights = np.add.reduceat(weights * poles, first), np.add.reduceat(weights, first)
        poles = moments / weights
    return Fractions(h.constant, weights, poles, h.slope)


def zeros_between(h: Fractions) -> tuple[FloatArray, FloatArray]:
    """
    The x > 0 with h(-x) = 0, one between neighbouring poles, and the distances of all poles from each.

    Parameters
    ----------
    h : Fractions
        With distinct rising poles and weights above 0.

    Returns
    -------
    zeros : ndarray, shape (m,)
    distances : ndarray, shape (m, poles)

    Examples
    --------
    >>> zeros_between(Fractions(1.0, np.array([1.0]), np.array([1.0]), 0.0))
    (array([0.5]), array([[0.5]]))
    """
    constant, weights, poles, slope = h
    if not poles.size:
        both = constant > 0.0 and slope > 0.0
        return np.full(int(both), constant / slope if both else 0.0), np.zeros((int(both), 0))
    left, right = poles[:-1], poles[1:]
    if constant > 0.0:
        left, right = np.append(0.0, left), np.append(poles[0], right)
    if slope > 0.0:
        last = poles[-1]
        beyond = max(last, (constant + 2.0 * float(weights.sum())) / slope)
        left, right = np.append(left, last), np.append(right, last + beyond)

    def from_base(base: FloatArray) -> Callable[[FloatArray], FloatArray]:
        """H at -(base + step), with equal rounding for both zeros next to a pole."""
        to_base = poles - base[:, None]
        own = to_base == 0.0
        others = np.where(own, np.inf, to_base)
        rest = constant - slope * base + (weights * own).sum(axis=1)
        at_base, rise, pole = (
            weights * base[:, None] / others,
            weights * poles / others,
            (weights * poles * own).sum(axis=1),
        )

        def value(step: FloatArray) -> FloatArray:
            distance, x = others - step[:, None], (base + step)[:, None]
            # the term at the base of a pole nearer than the step would cancel
            near = np.abs(others) < np.abs(step)[:, None]
            change = np.where(near, x * weights / distance, step[:, None] * (rise / distance)).sum(axis=1)
            return np.asarray(
                rest - np.where(near, 0.0, at_base).sum(axis=1) - slope * step - change + pole / step
            )

        return value

    half = 0.5 * (right - left)
    above = from_base(left)(half) > 0.0
    if slope > 0.0:
        half[-1], above[-1] = 2.0 * half[-1], False
    base, sign = np.where(above, right, left), np.where(above, -1.0, 1.0)
    value = from_base(base)
    _, log = boundary(
        lambda x: ~(value(sign * half * np.exp(-x)) * sign > 0.0), np.zeros(half.size), _SMALLEST
    )
    step = sign * half * np.exp(-log)
    return base + step, (poles - base[:, None]) - step[:, None]


def _over(time: FloatArray, times: FloatArray) -> FloatArray:
    """Each time divided by each of the given times, below the overflow of exponentials."""
    return np.asarray(np.minimum(time, 1e120)[..., None] / times)


@dataclass(frozen=True, eq=False)
class Retardation(Value):
    """
    Creep after a step of load, J(t) = instant + sum_i compliances_i (1 - exp(-t/times_i)) + fluidity t.

    Examples
    --------
    >>> float(Retardation(1.0, np.array([2.0]), np.array([1.0]), 0.0)(0.0))
    1.0
    """

    instant: float
    """In 1/Pa."""
    compliances: FloatArray
    """In 1/Pa."""
    times: FloatArray
    """In s."""
    fluidity: float
    """In 1/(Pa s)."""

    def __call__(self, time: ArrayLike) -> FloatArray:
        """J in 1/Pa at times in s, none below 0."""
        t = np.asarray(time, dtype=float)
        grown = -np.expm1(-_over(t, self.times)) @ self.compliances
        return np.asarray(self.instant + grown + self.fluidity * t)


@dataclass(frozen=True, eq=False)
class Relaxation(Value):
    """
    Relaxation after a step of strain, E(t) = equilibrium + sum_i moduli_i exp(-t/times_i) + viscosity delta(t).

    Examples
    --------
    >>> kernel = Relaxation(1.0, np.array([2.0]), np.array([1.0]))
    >>> float(kernel(0.0)), kernel.glassy, kernel.rubbery
    (3.0, 3.0, 1.0)
    """

    equilibrium: float = 0.0
    """In Pa; 0 for liquids."""
    moduli: FloatArray = field(default_factory=lambda: np.zeros(0))
    """In Pa, above 0."""
    times: FloatArray = field(default_factory=lambda: np.zeros(0))
    """In s, above 0."""
    viscosity: float = 0.0
    """Viscosity of a parallel dashpot in Pa s."""
    error: float = 0.0
    """Largest relative error of kernel, integral and creep over the requested span, if it approximates another kernel."""
    instantly_rigid: bool = False
    """Whether the approximated modulus is unbounded as the time goes to 0."""

    @property
    def glassy(self) -> float:
        """The instantaneous modulus in Pa; infinite with a parallel dashpot."""
        return np.inf if self.viscosity > 0.0 else self.equilibrium + float(self.moduli.sum())

    @property
    def rubbery(self) -> float:
        """The equilibrium modulus in Pa."""
        return self.equilibrium

    def softest(self, longest: float) -> float:
        """The equilibrium modulus in Pa, or the inverse of the creep after the longest time in s if the material flows: no load creeps more than its largest value that acts all the time."""
        return self.equilibrium or 1.0 / float(self.retardation(longest))

    def __call__(self, time: ArrayLike) -> FloatArray:
        """E in Pa at times in s, none below 0; without the delta of a dashpot."""
        t = np.asarray(time, dtype=float)
        return np.asarray(self.equilibrium + np.exp(-_over(t, self.times)) @ self.moduli)

    def storage(self, omega: ArrayLike) -> FloatArray:
        """E' in Pa at angular frequencies in rad/s."""
        x = self._cycles(omega)
        return np.asarray(self.equilibrium + (x**2 / (1.0 + x**2)) @ self.moduli)

    def loss(self, omega: ArrayLike) -> FloatArray:
        """E'' in Pa at angular frequencies in rad/s."""
        x = self._cycles(omega)
        return np.asarray((x / (1.0 + x**2)) @ self.moduli + self.viscosity * np.asarray(omega, dtype=float))

    def _cycles(self, omega: ArrayLike) -> FloatArray:
        return np.asarray(np.minimum(np.asarray(omega, dtype=float), 1e90)[..., None] * self.times)

    @cached_property
    def retardation(self) -> Retardation:
        """The creep of the same springs and dashpots."""
        inverse = reciprocal(Fractions(self.equilibrium, self.moduli, 1.0 / self.times, self.viscosity))
        return Retardation(*inverse)

    @property
    def modes(self) -> Modes:
        """
        The modes of the same springs under load.

        They are the eigenvectors of diag(d) - c c^T with d_i = 1/tau_i and c_i^2 = e_i d_i. Computed from distances of zeros to poles, they keep
        all digits where the rates spread over many decades (Gu and Eisenstat, 1994, SIAM J. Matrix Anal. Appl. 15, 1266).

        Examples
        --------
        >>> Relaxation(1.0, np.array([1.0]), np.array([1.0])).modes.decay
        array([0.5])
        """
        firm = self.equilibrium + float(self.moduli.sum())
        merged = _merged(Fractions(self.equilibrium / firm, self.moduli / firm, 1.0 / self.times, 0.0))
        _, fraction, rate, _ = merged
        zeros, distances = zeros_between(merged)
        if merged.constant == 0.0:
            zeros, distances = np.append(0.0, zeros), np.vstack([rate, distances])
        # c of the matrix whose eigenvalues are exactly these zeros
        between = rate[:, None] - rate
        np.fill_diagonal(between, 1.0)
        coupling = np.sqrt(np.prod(np.abs(distances.T / between), axis=1))
        vectors = coupling[:, None] / distances.T
        participation = 1.0 / np.linalg.norm(vectors, axis=0)
        vectors *= participation
        root = np.sqrt(fraction / rate)
        return Modes(fraction, rate, zeros, participation, vectors.T * root, vectors / root[:, None])

    def scaled(self, factor: float) -> Relaxation:
        """The kernel multiplied by a factor above 0."""
        return Relaxation(
            factor * self.equilibrium,
            factor * self.moduli,
            self.times,
            factor * self.viscosity,
            self.error,
            self.instantly_rigid,
        )

    def in_parallel(self, other: Relaxation) -> Relaxation:
        """The kernel of both in parallel: their stresses add."""
        times = np.concatenate([self.times, other.times])
        order = np.argsort(times)
        return Relaxation(
            self.equilibrium + other.equilibrium,
            np.concatenate([self.moduli, other.moduli])[order],
            times[order],
            self.viscosity + other.viscosity,
            max(self.error, other.error),
            self.instantly_rigid or other.instantly_rigid,
        )


def in_series(kernels: Sequence[Relaxation]) -> Relaxation:
    """
    The kernel of several in series: their creep adds.

    Parameters
    ----------
    kernels : sequence of Relaxation
        At least one.

    Returns
    -------
    Relaxation
        With at most as many terms as all together, plus one for each parallel dashpot; all above 0.

    Examples
    --------
    >>> in_series([Relaxation(1.0), Relaxation(viscosity=2.0)]).times
    array([2.])
    """
    if not kernels:
        raise ProblemError("at least one kernel is needed")
    if len(kernels) == 1:
        return kernels[0]
    creeps = [kernel.retardation for kernel in kernels]
    inverse = reciprocal(
        Fractions(
            sum(creep.instant for creep in creeps),
            np.concatenate([creep.compliances for creep in creeps]),
            np.concatenate([creep.times for creep in creeps]),
            sum(creep.fluidity for creep in creeps),
        )
    )
    order = np.argsort(-inverse.poles)
    return Relaxation(
        inverse.constant,
        inverse.weights[order],
        1.0 / inverse.poles[order],
        inverse.slope,
        max(kernel.error for kernel in kernels),
        all(kernel.instantly_rigid or kernel.viscosity > 0.0 for kernel in kernels) and inverse.slope == 0.0,
    )
