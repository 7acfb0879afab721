"""Kernels of springs and dashpots: relaxation and creep as sums of exponentials, and the one from the other."""

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
"""Poles that differ by less, relatively, are one at their mean: that errs by a tenth of the square."""
_SMALLEST = 460.0
"""Logarithm of how much closer to a pole a zero may lie than half the way to the next one."""


class Fractions(NamedTuple):
    """h(s) = constant + sum_i weights_i s/(s + poles_i) + slope s, no part below 0 and not all of them 0."""

    constant: float
    weights: FloatArray
    poles: FloatArray
    slope: float


def reciprocal(h: Fractions) -> Fractions:
    """
    1/h as fractions of 1/s.

    Parameters
    ----------
    h : Fractions

    Returns
    -------
    Fractions
        The k with 1/h(s) = k(1/s). What is left of it is above 0, and its poles are the inverses of the zeros of h.

    Notes
    -----
    Zeros and poles of h take turns on the negative axis (Gross, 1953, Mathematical Structure of the Theories of
    Viscoelasticity). Each zero is found from its distance to the nearer pole, so that it has all its digits however
    close it lies, and however many decades the poles span; the weights are products of such distances.

    Examples
    --------
    >>> reciprocal(Fractions(1.0, np.array([1.0]), np.array([1.0]), 0.0))
    Fractions(constant=0.5, weights=array([0.5]), poles=array([2.]), slope=0.0)
    """
    merged = _merged(h)
    constant, weights, poles, slope = merged
    zeros, away = zeros_between(merged)
    total = constant + float(weights.sum())
    with np.errstate(over="ignore", divide="ignore"):
        found = _residues(zeros, away, constant == 0.0) / (zeros * (slope if slope > 0.0 else total))
    kept = (found > 0.0) & np.isfinite(found)
    return Fractions(
        1.0 / total if slope == 0.0 else 0.0,
        found[kept],
        1.0 / zeros[kept],
        1.0 / (float((weights / poles).sum()) + slope) if constant == 0.0 else 0.0,
    )


def _residues(zeros: FloatArray, away: FloatArray, flows: bool) -> FloatArray:
    """
    Of the product of all s + poles over that of all s + zeros, and over s where it flows, at -zeros.

    What a zero errs by is small beside its distances to the poles, and an inverse made of the zeros as they were found is
    that of fractions all but equal to those given: Gu and Eisenstat (1994), SIAM J. Matrix Anal. Appl. 15, 1266.
    """
    if not away.size:
        return np.ones(zeros.size)
    i = np.arange(zeros.size)
    pole_between = np.minimum(np.minimum(i[:, None], i) + int(flows), away.shape[1] - 1)
    apart = away[i[:, None], pole_between] - away[i, pole_between]
    np.fill_diagonal(apart, 1.0)
    if flows:
        apart = np.column_stack([-zeros, apart])
    ratios = np.ones(apart.shape)
    ratios[:, : away.shape[1]] = away
    return np.asarray(np.abs(np.prod(ratios / apart, axis=1)))


def _merged(h: Fractions) -> Fractions:
    """The same with rising poles, each of them once."""
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
    The x > 0 with h(-x) = 0, one between neighbouring poles, and all poles less each of them without loss of digits.

    Parameters
    ----------
    h : Fractions
        With rising poles, no two alike, and weights above 0.

    Returns
    -------
    zeros : ndarray, shape (m,)
    away : ndarray, shape (m, poles)

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
        """What h is at -(base + step): the same rounding of its part at -base for both zeros beside a pole."""
        to_base = poles - base[:, None]
        own = to_base == 0.0
        apart = np.where(own, np.inf, to_base)
        rest = constant - slope * base + (weights * own).sum(axis=1)
        there, rise, pole = (
            weights * base[:, None] / apart,
            weights * poles / apart,
            (weights * poles * own).sum(axis=1),
        )

        def value(step: FloatArray) -> FloatArray:
            away, x = apart - step[:, None], (base + step)[:, None]
            # of a pole nearer to the base than the zero is, the part there is far larger than the whole
            near = np.abs(apart) < np.abs(step)[:, None]
            from_there = np.where(near, x * weights / away, step[:, None] * (rise / away)).sum(axis=1)
            return np.asarray(
                rest - np.where(near, 0.0, there).sum(axis=1) - slope * step - from_there + pole / step
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
    """Each time over each of some others, as far as exponentials can tell."""
    return np.asarray(np.minimum(time, 1e120)[..., None] / times)


@dataclass(frozen=True, eq=False)
class Retardation(Value):
    """
    How something creeps under a step of load, J(t) = instant + sum_i compliances_i (1 - exp(-t/times_i)) + fluidity t.

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
    How a stress relaxes after a step of strain, E(t) = equilibrium + sum_i moduli_i exp(-t/times_i) + viscosity delta(t).

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
    """In Pa s; 0 unless a dashpot stands beside the springs."""
    error: float = 0.0
    """Largest relative error of the shear kernels that it replaces, and of their integrals and creep, over the span requested."""
    instantly_rigid: bool = False
    """Whether it stands for a modulus that grows without limit as the time goes to 0."""

    @property
    def glassy(self) -> float:
        """The modulus in Pa that answers a step at once; infinite with a dashpot beside."""
        return np.inf if self.viscosity > 0.0 else self.equilibrium + float(self.moduli.sum())

    @property
    def rubbery(self) -> float:
        """The modulus in Pa that is left in the end."""
        return self.equilibrium

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

    def scaled(self, factor: float) -> Relaxation:
        """The kernel times a number above 0."""
        return Relaxation(
            factor * self.equilibrium,
            factor * self.moduli,
            self.times,
            factor * self.viscosity,
            self.error,
            self.instantly_rigid,
        )

    def beside(self, other: Relaxation) -> Relaxation:
        """The kernel with another one beside it, whose stresses add."""
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
    The kernel of several in series, whose creep adds.

    Parameters
    ----------
    kernels : sequence of Relaxation
        At least one.

    Returns
    -------
    Relaxation
        Of no more terms than all of them have together, and one for each that has a dashpot beside; all above 0.

    Raises
    ------
    ProblemError
        If there is none.

    Examples
    --------
    >>> in_series([Relaxation(1.0), Relaxation(viscosity=2.0)]).times
    array([2.])
    """
    if not kernels:
        raise ProblemError("in_series: at least one kernel is needed")
    if len(kernels) == 1:
        return kernels[0]
    creeps = [kernel.retardation for kernel in kernels]
    whole = reciprocal(
        Fractions(
            sum(creep.instant for creep in creeps),
            np.concatenate([creep.compliances for creep in creeps]),
            np.concatenate([creep.times for creep in creeps]),
            sum(creep.fluidity for creep in creeps),
        )
    )
    order = np.argsort(-whole.poles)
    return Relaxation(
        whole.constant,
        whole.weights[order],
        1.0 / whole.poles[order],
        whole.slope,
        max(kernel.error for kernel in kernels),
        all(kernel.instantly_rigid or kernel.viscosity > 0.0 for kernel in kernels) and whole.slope == 0.0,
    )
