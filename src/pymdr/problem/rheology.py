"""Rheologies: how the shear stress of a body follows its shear strain in time."""

from __future__ import annotations

import inspect
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Self

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.problem.fitting import Measured, fitted
from pymdr.problem.spectra import Relaxation
from pymdr.problem.values import ArrayField, OptionalSIField, SIField, Value, within_range
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, to_si, to_si_array, written


class Rheology(Value, ABC):
    """How a body relaxes and creeps in shear."""

    @abstractmethod
    def relaxation(self, time: ArrayQuantityLike) -> FloatArray:
        """
        Relaxation modulus G(t) in Pa: the stress after a unit step of shear.

        Parameters
        ----------
        time : array_like or quantity
            In s, not below 0. The impulse of a dashpot at t = 0 is not in it.
        """

    @abstractmethod
    def creep(self, time: ArrayQuantityLike) -> FloatArray:
        """
        Creep compliance J(t) in 1/Pa: the shear after a unit step of stress.

        Parameters
        ----------
        time : array_like or quantity
            In s, not below 0.
        """

    @abstractmethod
    def storage(self, omega: ArrayQuantityLike) -> FloatArray:
        """
        Storage modulus G' in Pa.

        Parameters
        ----------
        omega : array_like or quantity
            Angular frequency in rad/s, not below 0; 2 pi times the frequency in Hz.
        """

    @abstractmethod
    def loss(self, omega: ArrayQuantityLike) -> FloatArray:
        """
        Loss modulus G'' in Pa.

        Parameters
        ----------
        omega : array_like or quantity
            Angular frequency in rad/s, not below 0; 2 pi times the frequency in Hz.
        """

    @abstractmethod
    def kernel(self, span: tuple[float, float] | None = None) -> Relaxation:
        """
        The relaxation as a sum of exponentials.

        Parameters
        ----------
        span : tuple of float, optional
            The shortest and the longest time in s that matter; needed where the sum stands for another law.
        """

    def scaled(self, factor: float) -> Self:
        """The same rheology with all moduli and viscosities times a number above 0."""
        sizes = (f.name for f in fields(self) if inspect.getattr_static(self, f.name).unit in ("Pa", "Pa*s"))
        found = ((name, getattr(self, name)) for name in sizes)
        return replace(self, **{name: factor * value for name, value in found if value is not None})

    def _times(self, time: ArrayQuantityLike) -> FloatArray:
        return _not_negative(time, "s", f"{type(self).__name__}: time")

    def _frequencies(self, omega: ArrayQuantityLike) -> FloatArray:
        return _not_negative(omega, "rad/s", f"{type(self).__name__}: omega")


def _not_negative(values: ArrayQuantityLike, unit: str, name: str) -> FloatArray:
    array = to_si_array(values, unit, name=name)
    if np.any(array < 0.0):
        raise ProblemError(f"{name} = {array.min():g} {unit}: it must be at least 0 {unit}")
    return array


class SpringsAndDashpots(Rheology, ABC):
    """A rheology whose kernel is a finite sum: everything is read from that."""

    @cached_property
    def _springs(self) -> Relaxation:
        return self.kernel()

    def relaxation(self, time: ArrayQuantityLike) -> FloatArray:
        """Relaxation modulus G(t) in Pa, as :meth:`Rheology.relaxation`."""
        return self._springs(self._times(time))

    def creep(self, time: ArrayQuantityLike) -> FloatArray:
        """Creep compliance J(t) in 1/Pa, as :meth:`Rheology.creep`."""
        return self._springs.retardation(self._times(time))

    def storage(self, omega: ArrayQuantityLike) -> FloatArray:
        """Storage modulus G' in Pa, as :meth:`Rheology.storage`."""
        return self._springs.storage(self._frequencies(omega))

    def loss(self, omega: ArrayQuantityLike) -> FloatArray:
        """Loss modulus G'' in Pa, as :meth:`Rheology.loss`."""
        return self._springs.loss(self._frequencies(omega))


@dataclass(frozen=True, eq=False)
class Prony(SpringsAndDashpots):
    """
    A spring beside Maxwell elements, G(t) = equilibrium + sum_i moduli_i exp(-t/times_i).

    Parameters
    ----------
    equilibrium : quantity
        Modulus that is left in the end in Pa, at least 0; 0 for liquids.
    moduli : array_like or quantity
        In Pa, above 0.
    times : array_like or quantity
        Relaxation times in s, above 0, in any order, each once.

    Raises
    ------
    ProblemError
        If the lengths differ, an entry is not above 0, a time repeats, or the terms add to nothing.
    UnitError
        If an entry is not a finite number of the right kind.

    Examples
    --------
    >>> rubber = Prony("1 MPa", ["2 MPa", "3 MPa"], ["1 ms", "1 s"])
    >>> float(rubber.relaxation(0.0)), float(rubber.relaxation("1 h"))
    (6000000.0, 1000000.0)
    """

    equilibrium: SIField = SIField("Pa", at_least=0.0, words="shear modulus that is left in the end")
    moduli: ArrayField = ArrayField("Pa", words="shear moduli that relax")
    times: ArrayField = ArrayField("s", words="relaxation times")

    def __post_init__(self) -> None:
        if self.moduli.size != self.times.size:
            raise ProblemError(
                f"Prony: {self.moduli.size} moduli for {self.times.size} times; give one for each"
            )
        for name, unit in (("moduli", "Pa"), ("times", "s")):
            values = getattr(self, name)
            if np.any(values <= 0.0):
                i = int(np.argmax(values <= 0.0))
                raise ProblemError(f"Prony.{name}[{i}] = {values[i]:g} {unit}: it must be above 0 {unit}")
            for value in values:
                within_range(value, unit, f"Prony.{name}", size=True)
        if self.equilibrium == 0.0 and not self.moduli.size:
            raise ProblemError(
                "Prony: equilibrium = 0 Pa and no moduli add to nothing; give at least one of them"
            )
        rising = np.sort(self.times)
        if np.any(rising[1:] == rising[:-1]):
            twice = float(rising[int(np.argmax(rising[1:] == rising[:-1]))])
            raise ProblemError(
                f"Prony.times: {written(twice, 's')} is there twice; add the moduli of those terms"
            )

    @classmethod
    def from_relaxation(
        cls,
        time: ArrayQuantityLike,
        modulus: ArrayQuantityLike,
        *,
        terms: int | None = None,
        noise: float | None = None,
    ) -> Prony:
        """
        The series of few terms that lies nearest to a measured relaxation modulus.

        Parameters
        ----------
        time : array_like or quantity
            Times since the step in s, above 0 and rising, without a gap of more than two decades; at least 5.
        modulus : array_like or quantity
            G(t) in Pa at those times, not below 0.
        terms : int, optional
            The largest number of terms. Unless given, they become fewer as long as the misfit is at most `noise`.
        noise : float, optional
            Relative noise of the moduli; unless given, 1.1 of the misfit of the full fit, which begins with eight terms
            a decade.

        Returns
        -------
        Prony
            With times inside the span of the rows: what relaxes before is not in it, what relaxes after is in the
            equilibrium modulus.

        Raises
        ------
        ProblemError
            If the rows are too few or do not rise, have a gap, are negative or nothing; if no series reaches the noise.
        UnitError
            If an entry is not a finite number of the right kind.

        Notes
        -----
        The squares of what the series lies off the rows, relative to their size, are least; moduli are not below 0 (Lawson
        and Hanson, 1974), and times move to where they fit best (Kaufman, 1975, BIT 15, 49).

        Examples
        --------
        >>> t = np.geomspace(1e-3, 1e2, 50)
        >>> found = Prony.from_relaxation(t, 1e5 + 3e5 * np.exp(-t / 0.2))
        >>> round(found.times[0], 9), round(found.moduli[0], 3)
        (np.float64(0.2), np.float64(300000.0))
        """
        return cls._through(
            Measured(
                to_si_array(time, "s", name="time"),
                (to_si_array(modulus, "Pa", name="modulus"),),
                "from_relaxation",
            ),
            terms,
            noise,
        )

    @classmethod
    def from_dma(
        cls,
        omega: ArrayQuantityLike,
        storage: ArrayQuantityLike,
        loss: ArrayQuantityLike,
        *,
        terms: int | None = None,
        noise: float | None = None,
    ) -> Prony:
        """
        The series of few terms that lies nearest to measured storage and loss moduli.

        Parameters
        ----------
        omega : array_like or quantity
            Angular frequencies in rad/s (2 pi times those in Hz), above 0 and rising, without a gap of more than two
            decades; at least 5.
        storage, loss : array_like or quantity
            G' and G'' in Pa, not below 0.
        terms, noise : optional
            As for :meth:`from_relaxation`; a modulus below a tenth of abs(G' + i G'') counts relative to that.

        Returns
        -------
        Prony
            With times inside the span of 1/omega.

        Raises
        ------
        ProblemError, UnitError
            As :meth:`from_relaxation`.

        Examples
        --------
        >>> w = np.geomspace(0.1, 1e3, 41)
        >>> rubber = StandardSolid("1 MPa", "3 MPa", "20 ms")
        >>> found = Prony.from_dma(w, rubber.storage(w), rubber.loss(w))
        >>> round(found.times[0], 9), round(found.equilibrium)
        (np.float64(0.02), 1000000)
        """
        moduli = to_si_array(storage, "Pa", name="storage"), to_si_array(loss, "Pa", name="loss")
        return cls._through(
            Measured(to_si_array(omega, "rad/s", name="omega"), moduli, "from_dma"), terms, noise
        )

    @classmethod
    def _through(cls, measured: Measured, terms: int | None, noise: float | None) -> Prony:
        found = fitted(measured, terms, noise)
        return cls(found.equilibrium, found.moduli, found.times)

    def kernel(self, span: tuple[float, float] | None = None) -> Relaxation:
        """The series itself, with rising times."""
        order = np.argsort(self.times)
        return Relaxation(self.equilibrium, self.moduli[order], self.times[order])

    def prony(self) -> Prony:
        """The series itself."""
        return self


@dataclass(frozen=True, eq=False)
class Maxwell(SpringsAndDashpots):
    """
    A spring and a dashpot in series: a liquid with G(t) = modulus exp(-t/time).

    Parameters
    ----------
    modulus : quantity
        Shear modulus in Pa, above 0.
    time : quantity, optional
        Relaxation time in s, above 0.
    viscosity : quantity, optional
        modulus * time in Pa s, above 0. Exactly one of the two is given.

    Raises
    ------
    ProblemError
        If a value is outside its limits, or both or none of time and viscosity are given.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> Maxwell("2 kPa", viscosity="1 kPa*s").relaxation_time
    0.5
    """

    modulus: SIField = SIField("Pa", above=0.0, words="shear modulus")
    time: OptionalSIField = OptionalSIField("s", above=0.0, words="relaxation time")
    viscosity: OptionalSIField = OptionalSIField("Pa*s", above=0.0, words="shear viscosity")

    def __post_init__(self) -> None:
        if (self.time is None) == (self.viscosity is None):
            found = "neither time nor viscosity is" if self.time is None else "both time and viscosity are"
            raise ProblemError(f"Maxwell: {found} given; give one of them")

    @property
    def relaxation_time(self) -> float:
        """In s."""
        if self.time is not None:
            return self.time
        assert self.viscosity is not None
        return self.viscosity / self.modulus

    def kernel(self, span: tuple[float, float] | None = None) -> Relaxation:
        """Its one term."""
        return self.prony().kernel()

    def prony(self) -> Prony:
        """The same as a series of one term."""
        return Prony(0.0, [self.modulus], [self.relaxation_time])


@dataclass(frozen=True, eq=False)
class StandardSolid(SpringsAndDashpots):
    """
    A spring beside a Maxwell element, G(t) = equilibrium + modulus exp(-t/time).

    Parameters
    ----------
    equilibrium : quantity
        Shear modulus that is left in the end in Pa, above 0.
    modulus : quantity
        Shear modulus that relaxes in Pa, above 0.
    time : quantity
        Relaxation time in s, above 0.

    Raises
    ------
    ProblemError
        If a value is outside its limits.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> float(StandardSolid("1 MPa", "3 MPa", "10 ms").creep(0.0))
    2.5e-07
    """

    equilibrium: SIField = SIField("Pa", above=0.0, words="shear modulus that is left in the end")
    modulus: SIField = SIField("Pa", above=0.0, words="shear modulus that relaxes")
    time: SIField = SIField("s", above=0.0, words="relaxation time")

    def kernel(self, span: tuple[float, float] | None = None) -> Relaxation:
        """Its spring and its one term."""
        return Relaxation(self.equilibrium, np.array([self.modulus]), np.array([self.time]))

    def prony(self) -> Prony:
        """The same as a series of one term."""
        return Prony(self.equilibrium, [self.modulus], [self.time])


@dataclass(frozen=True, eq=False)
class KelvinVoigt(SpringsAndDashpots):
    """
    A spring beside a dashpot: G(t) = modulus + viscosity delta(t), which answers no step at once.

    Parameters
    ----------
    modulus : quantity
        Shear modulus in Pa, above 0.
    viscosity : quantity
        Shear viscosity in Pa s, above 0.

    Raises
    ------
    ProblemError
        If a value is outside its limits.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> round(float(KelvinVoigt("1 Pa", "1 Pa*s").creep("1 s")), 12)
    0.632120558829
    """

    modulus: SIField = SIField("Pa", above=0.0, words="shear modulus")
    viscosity: SIField = SIField("Pa*s", above=0.0, words="shear viscosity")

    def kernel(self, span: tuple[float, float] | None = None) -> Relaxation:
        """Its spring and its dashpot."""
        return Relaxation(self.modulus, viscosity=self.viscosity)


@dataclass(frozen=True, eq=False)
class PowerLawRheology(Rheology):
    """
    A power of time, G(t) = modulus (t/time)^-exponent, as in biological tissue, gels and pastes.

    Parameters
    ----------
    modulus : quantity
        Relaxation modulus at the time in Pa, above 0.
    time : quantity
        The time in s at which it is given, above 0.
    exponent : quantity
        Above 0 (a solid) and below 1 (a liquid).

    Raises
    ------
    ProblemError
        If a value is outside its limits.
    UnitError
        If a text is not a quantity of the right kind.

    Notes
    -----
    With the exponent b, J(t) = sin(pi b)/(pi b) (t/time)^b / modulus, and
    G' + i G'' = modulus Gamma(1 - b) (i omega time)^b (Nutting, 1921; Scott Blair, 1947).

    Examples
    --------
    >>> cell = PowerLawRheology("1 kPa", "1 s", 0.2)
    >>> round(float(cell.loss(1.0) / cell.storage(1.0)), 9)
    0.324919696
    """

    modulus: SIField = SIField("Pa", above=0.0, words="relaxation modulus at the time")
    time: SIField = SIField("s", above=0.0, words="time at which the modulus is given")
    exponent: SIField = SIField("", above=0.0, below=1.0, words="exponent of the decay")

    def relaxation(self, time: ArrayQuantityLike) -> FloatArray:
        """Relaxation modulus G(t) in Pa, infinite at 0, as :meth:`Rheology.relaxation`."""
        with np.errstate(divide="ignore"):
            return np.asarray(self.modulus * (self._times(time) / self.time) ** -self.exponent)

    def creep(self, time: ArrayQuantityLike) -> FloatArray:
        """Creep compliance J(t) in 1/Pa, as :meth:`Rheology.creep`."""
        factor = float(np.sinc(self.exponent)) / self.modulus
        return np.asarray(factor * (self._times(time) / self.time) ** self.exponent)

    def storage(self, omega: ArrayQuantityLike) -> FloatArray:
        """Storage modulus G' in Pa, as :meth:`Rheology.storage`."""
        return self._amplitude(omega) * math.sin((1.0 - self.exponent) * math.pi / 2.0)

    def loss(self, omega: ArrayQuantityLike) -> FloatArray:
        """Loss modulus G'' in Pa, as :meth:`Rheology.loss`."""
        return self._amplitude(omega) * math.sin(self.exponent * math.pi / 2.0)

    def _amplitude(self, omega: ArrayQuantityLike) -> FloatArray:
        factor = self.modulus * math.gamma(1.0 - self.exponent)
        return np.asarray(factor * (self._frequencies(omega) * self.time) ** self.exponent)

    def kernel(self, span: tuple[float, float] | None = None) -> Relaxation:
        """The series that stands for it over a span, with its measured error."""
        if span is None:
            raise ProblemError(
                "PowerLawRheology: a power of time is no sum of exponentials; give the span of times that matter, such "
                "as span = ('1 ms', '100 s')"
            )
        first, last = _span(*span)
        (moduli, times), error = self._series(first, last, _SERIES_ERROR)
        faster, shorter = _impulse(self.exponent, _step(self.exponent, _SERIES_ERROR))
        kernel = Relaxation(
            0.0,
            np.append(moduli[0] * faster, moduli),
            np.append(times[0] * shorter, times),
            instantly_rigid=True,
        )
        return replace(kernel, error=_BETWEEN * max(error, self._impulse_error(kernel, first, last)))

    def _series(self, first: float, last: float, error: float) -> tuple[tuple[FloatArray, FloatArray], float]:
        """Moduli and rising times of a series over a span, and the largest relative error of its G(t) there."""
        rates, weights = _exponentials(self.exponent, first, last, error)
        size = self.modulus * (last / self.time) ** -self.exponent
        kernel = Relaxation(0.0, size * weights[::-1], 1.0 / rates[::-1])
        t = _grid(first, last)
        found = float(np.max(np.abs(kernel(t) / self.relaxation(t) - 1.0)))
        if found > error:
            raise ConvergenceError(
                f"PowerLawRheology.prony: {rates.size} terms err by {found:.2g}, more than error = {error:g}; "
                "ask for a larger error"
            )
        return (kernel.moduli, kernel.times), found

    def _impulse_error(self, kernel: Relaxation, first: float, last: float) -> float:
        """The largest relative error of the integral of G from 0 on, and of J, over a span."""
        t = _grid(first, last)
        flow = -np.expm1(-t[:, None] / kernel.times) @ (kernel.moduli * kernel.times)
        exact = self.relaxation(t) * t / (1.0 - self.exponent)
        creep = kernel.retardation(t) / self.creep(t)
        return float(max(np.max(np.abs(flow / exact - 1.0)), np.max(np.abs(creep - 1.0))))

    def prony(self, shortest: QuantityLike, longest: QuantityLike, *, error: float = 1e-9) -> Prony:
        """
        A series that stands for the power over a span of times.

        Parameters
        ----------
        shortest, longest : quantity
            The span in s. Outside, the series is another material: finite at once, and a liquid in the end.
        error : float
            Largest relative error of G(t) within the span, from 1e-12 to 0.1.

        Returns
        -------
        Prony
            All moduli above 0; 19 to 31 terms for six decades and an error of 1e-3, 45 to 58 for 1e-9.

        Raises
        ------
        ProblemError
            If the span is empty or longer than 30 decades, or the error is outside its limits.
        ConvergenceError
            If the error that is measured on the span is larger than the one asked for.

        Notes
        -----
        t^-b = int exp(b y - t exp(y)) dy / Gamma(b) by the trapezoidal rule, whose relative error
        2 |Gamma(b + 2 pi i/h)|/Gamma(b) for the step h is the same at every t (McLean, 2018, in Contemporary Computational
        Mathematics). Terms slower than the span are as few as a Gaussian rule for them needs.

        Examples
        --------
        >>> series = PowerLawRheology("1 kPa", "1 s", 0.2).prony("1 ms", "1 ks")
        >>> round(float(series.relaxation("1 s")), 5)
        1000.0
        """
        first, last = _span(shortest, longest)
        if not 1e-12 <= error <= 0.1:
            raise ProblemError(f"PowerLawRheology.prony: error = {error:g}; it must be from 1e-12 to 0.1")
        (moduli, times), _ = self._series(first, last, error)
        return Prony(0.0, moduli, times)


WIDEST = 1e30
"""The longest over the shortest time of a span."""
_SERIES_ERROR = 1e-11
"""Largest relative error of the series for a span: a hundredth of what is still exact, because rows that are small beside their history multiply it."""
_BETWEEN = 2.0
"""How much larger an error may be between the times at which it is measured."""
_FAST_TERMS = 4
"""Terms for all that is faster than a series, beside one at 0."""
_FASTEST = 60.0
"""Logarithm of how much faster than a series what counts in the moments of the times is."""
_INSTANT = 1e-24
"""Time of the term at 0, of the shortest of the others."""


def _span(shortest: QuantityLike, longest: QuantityLike) -> tuple[float, float]:
    first, last = to_si(shortest, "s", name="shortest"), to_si(longest, "s", name="longest")
    if not 0.0 < first < last <= WIDEST * first:
        raise ProblemError(
            f"span from {first:g} s to {last:g} s: it must begin above 0 s and end later, at most {WIDEST:g} times as late"
        )
    return first, last


def _grid(first: float, last: float) -> FloatArray:
    """Times of a span at which a series is compared."""
    return np.geomspace(first, last, 64 + 32 * math.ceil(math.log10(last / first)))


def _step(exponent: float, error: float) -> float:
    """The step of the trapezoidal rule in the logarithm of the rate."""
    from scipy.special import gammaln, loggamma

    goal = math.log(0.05 * error)
    step = 2.0
    while (loggamma(exponent + 2j * math.pi / step).real - gammaln(exponent)) > goal:
        step *= 0.95
    return step


def _exponentials(exponent: float, first: float, last: float, error: float) -> tuple[FloatArray, FloatArray]:
    """Rising rates in 1/s and weights of a sum of exponentials for (t/last)^-exponent."""
    from scipy.special import gammaln

    goal, step = math.log(0.05 * error), _step(exponent, error)
    fastest = math.log(last / first) + math.log(-2.0 * goal)
    slowest = goal / exponent if exponent * 60.0 > -goal else -60.0
    y = np.arange(math.floor(min(slowest, 0.0) / step), math.ceil(fastest / step) + 1) * step
    # what is slower than that is alike to a constant over the span, and the first weight holds it
    weights = np.exp(exponent * y + math.log(step) - gammaln(exponent))
    weights[0] /= -math.expm1(-exponent * step)
    slow = y < 0.0
    nodes, few = _gauss(np.exp(y[slow]), weights[slow])
    return np.append(nodes, np.exp(y[~slow])) / last, np.append(few, weights[~slow])


def _impulse(exponent: float, step: float) -> tuple[FloatArray, FloatArray]:
    """
    Moduli and rising times of few terms that stand for all terms of the trapezoidal rule faster than a term of 1 Pa and 1 s.

    The k-th of these has the time exp(-k step) and the impulse (modulus times time) exp((exponent - 1) k step). A Gauss-Radau rule
    for the impulses keeps their sum and their moments over the times: a load that is smooth over times longer than 1 s feels no
    difference. Its node at 0 has a time so short that no sudden load moves it.
    """
    ratio = math.exp((exponent - 1.0) * step)
    k = np.arange(1.0, math.ceil(_FASTEST / step) + 1.0)
    points, impulses = np.exp(-k * step), ratio**k
    times, weights = _gauss(points, points * impulses, _FAST_TERMS)
    rest = ratio / (1.0 - ratio) - float((weights / times).sum())
    return np.append(rest / _INSTANT, weights / times**2), np.append(_INSTANT, times)


def _gauss(points: FloatArray, weights: FloatArray, most: int = 8) -> tuple[FloatArray, FloatArray]:
    """So many rising points with weights above 0 that stand for more, exact for polynomials of twice the degree less 1 (Lanczos)."""
    total = float(weights.sum())
    columns = [np.sqrt(weights / total)]
    diagonal, beside = [], []
    for _ in range(min(most, points.size)):
        latest = columns[-1]
        diagonal.append(float(latest @ (points * latest)))
        rest = points * latest
        for _ in range(2):
            for column in columns:
                rest = rest - (column @ rest) * column
        beside.append(float(np.linalg.norm(rest)))
        columns.append(rest / beside[-1])
    n = len(diagonal)
    matrix = np.diag(diagonal) + np.diag(beside[: n - 1], 1) + np.diag(beside[: n - 1], -1)
    nodes, vectors = np.linalg.eigh(matrix)
    return nodes, total * vectors[0] ** 2
