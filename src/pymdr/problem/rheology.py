"""Rheologies: relaxation and creep of a body in shear."""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Self

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.fitting import Measured, fitted
from pymdr.problem.spectra import Relaxation
from pymdr.problem.values import ArrayField, OptionalSIField, SIField, Value, within_range
from pymdr.units import ArrayQuantityLike, FloatArray, to_si_array, written


class Rheology(Value, ABC):
    """Relaxation and creep of a body in shear."""

    @abstractmethod
    def relaxation(self, time: ArrayQuantityLike) -> FloatArray:
        """
        Relaxation modulus G(t) in Pa: the stress after a unit step of shear.

        Parameters
        ----------
        time : array_like or quantity
            In s, not below 0. The impulse of a dashpot at t = 0 is not included.
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
            Shortest and longest relevant time in s; required if the sum approximates another law.
        """

    def scaled(self, factor: float) -> Self:
        """The same rheology with all moduli and viscosities multiplied by a factor above 0."""
        sizes = (f.name for f in fields(self) if inspect.getattr_static(self, f.name).unit in ("Pa", "Pa*s"))
        given = ((name, getattr(self, name)) for name in sizes)
        return replace(self, **{name: factor * value for name, value in given if value is not None})

    def _times(self, time: ArrayQuantityLike) -> FloatArray:
        return _not_negative(time, "s", "time")

    def _frequencies(self, omega: ArrayQuantityLike) -> FloatArray:
        return _not_negative(omega, "rad/s", "omega")


def _not_negative(values: ArrayQuantityLike, unit: str, name: str) -> FloatArray:
    array = to_si_array(values, unit, name=name)
    if np.any(array < 0.0):
        raise ProblemError(f"{name} = {array.min():g} {unit}: it must be at least 0 {unit}")
    return array


class SpringsAndDashpots(Rheology, ABC):
    """A rheology whose kernel is a finite sum of exponentials."""

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
    A spring parallel to Maxwell elements, G(t) = equilibrium + sum_i moduli_i exp(-t/times_i).

    Parameters
    ----------
    equilibrium : quantity
        Equilibrium modulus in Pa, at least 0; 0 for liquids.
    moduli : array_like or quantity
        In Pa, above 0.
    times : array_like or quantity
        Distinct relaxation times in s, above 0, in any order.

    Raises
    ------
    ProblemError
        If the lengths differ, an entry is not above 0, a time repeats, or all moduli are 0.
    UnitError
        If an entry is not a finite number of the right kind.

    Examples
    --------
    >>> import pymdr as mdr
    >>> rubber = mdr.Prony("1 MPa", ["2 MPa", "3 MPa"], ["1 ms", "1 s"])
    >>> float(rubber.relaxation(0.0)), float(rubber.relaxation("1 h"))
    (6000000.0, 1000000.0)
    """

    equilibrium: SIField = SIField("Pa", at_least=0.0, description="equilibrium shear modulus")
    moduli: ArrayField = ArrayField("Pa", description="relaxing shear moduli")
    times: ArrayField = ArrayField("s", description="relaxation times")

    def __post_init__(self) -> None:
        if self.moduli.size != self.times.size:
            raise ProblemError(f"{self.moduli.size} moduli for {self.times.size} times; give one for each")
        for name, unit in (("moduli", "Pa"), ("times", "s")):
            values = getattr(self, name)
            if np.any(values <= 0.0):
                i = int(np.argmax(values <= 0.0))
                raise ProblemError(f"{name}[{i}] = {values[i]:g} {unit}: it must be above 0 {unit}")
            for value in values:
                within_range(value, unit, name, size=True)
        if self.equilibrium == 0.0 and not self.moduli.size:
            raise ProblemError("equilibrium = 0 Pa without moduli; give at least one of them")
        rising = np.sort(self.times)
        if np.any(rising[1:] == rising[:-1]):
            twice = float(rising[int(np.argmax(rising[1:] == rising[:-1]))])
            raise ProblemError(f"times: {written(twice, 's')} occurs twice; add the moduli of the two terms")

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
        Fit a series of few terms to a measured relaxation modulus.

        Parameters
        ----------
        time : array_like or quantity
            Times since the step in s, above 0 and rising, at least 5, without gaps of more than two decades.
        modulus : array_like or quantity
            G(t) in Pa at those times, not below 0.
        terms : int, optional
            Largest number of terms; by default as few as keep the misfit below `noise`.
        noise : float, optional
            Relative noise of the moduli; by default 1.1 times the misfit of the full fit with eight terms per decade.

        Returns
        -------
        Prony
            With times inside the span of the rows: faster relaxation is not included, slower relaxation is part of the
            equilibrium modulus.

        Raises
        ------
        ProblemError
            If the rows are too few, do not rise, have a gap, are negative or 0, or no series reaches the noise.
        UnitError
            If an entry is not a finite number of the right kind.

        Notes
        -----
        The fit minimises the squared relative residuals with moduli not below 0 (Lawson and Hanson, 1974), and optimises
        the times (Kaufman, 1975, BIT 15, 49).

        Examples
        --------
        >>> import numpy as np
        >>> import pymdr as mdr
        >>> t = np.geomspace(1e-3, 1e2, 50)
        >>> series = mdr.Prony.from_relaxation(t, 1e5 + 3e5 * np.exp(-t / 0.2))
        >>> round(series.times[0], 9), round(series.moduli[0], 3)
        (np.float64(0.2), np.float64(300000.0))
        """
        measured = Measured(
            to_si_array(time, "s", name="time"),
            (to_si_array(modulus, "Pa", name="modulus"),),
            "from_relaxation",
        )
        return cls._fitted(measured, terms, noise)

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
        Fit a series of few terms to measured storage and loss moduli.

        Parameters
        ----------
        omega : array_like or quantity
            Angular frequencies in rad/s (2 pi times those in Hz), above 0 and rising, without a gap of more than two
            decades; at least 5.
        storage, loss : array_like or quantity
            G' and G'' in Pa, not below 0.
        terms, noise : optional
            As for :meth:`from_relaxation`; residuals are relative to at least a tenth of abs(G' + i G'').

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
        >>> import numpy as np
        >>> import pymdr as mdr
        >>> w = np.geomspace(0.1, 1e3, 41)
        >>> rubber = mdr.StandardSolid("1 MPa", "3 MPa", "20 ms")
        >>> series = mdr.Prony.from_dma(w, rubber.storage(w), rubber.loss(w))
        >>> round(series.times[0], 9), round(series.equilibrium)
        (np.float64(0.02), 1000000)
        """
        moduli = to_si_array(storage, "Pa", name="storage"), to_si_array(loss, "Pa", name="loss")
        return cls._fitted(
            Measured(to_si_array(omega, "rad/s", name="omega"), moduli, "from_dma"), terms, noise
        )

    @classmethod
    def _fitted(cls, measured: Measured, terms: int | None, noise: float | None) -> Prony:
        series = fitted(measured, terms, noise)
        return cls(series.equilibrium, series.moduli, series.times)

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
        modulus * time in Pa s, above 0. Give exactly one of time and viscosity.

    Raises
    ------
    ProblemError
        If a value is outside its limits, or not exactly one of time and viscosity is given.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Maxwell("2 kPa", viscosity="1 kPa*s").relaxation_time
    0.5
    """

    modulus: SIField = SIField("Pa", above=0.0, description="shear modulus")
    time: OptionalSIField = OptionalSIField("s", above=0.0, description="relaxation time")
    viscosity: OptionalSIField = OptionalSIField("Pa*s", above=0.0, description="shear viscosity")

    def __post_init__(self) -> None:
        if (self.time is None) == (self.viscosity is None):
            given = "neither time nor viscosity is" if self.time is None else "both time and viscosity are"
            raise ProblemError(f"{given} given; give one of them")

    @property
    def relaxation_time(self) -> float:
        """The relaxation time in s."""
        if self.time is not None:
            return self.time
        assert self.viscosity is not None
        return self.viscosity / self.modulus

    def kernel(self, span: tuple[float, float] | None = None) -> Relaxation:
        """The single term."""
        return self.prony().kernel()

    def prony(self) -> Prony:
        """The same as a series of one term."""
        return Prony(0.0, [self.modulus], [self.relaxation_time])


@dataclass(frozen=True, eq=False)
class StandardSolid(SpringsAndDashpots):
    """
    A spring parallel to a Maxwell element, G(t) = equilibrium + modulus exp(-t/time).

    Parameters
    ----------
    equilibrium : quantity
        Equilibrium shear modulus in Pa, above 0.
    modulus : quantity
        Relaxing shear modulus in Pa, above 0.
    time : quantity
        Relaxation time in s, above 0.

    Examples
    --------
    >>> import pymdr as mdr
    >>> float(mdr.StandardSolid("1 MPa", "3 MPa", "10 ms").creep(0.0))
    2.5e-07
    """

    equilibrium: SIField = SIField("Pa", above=0.0, description="equilibrium shear modulus")
    modulus: SIField = SIField("Pa", above=0.0, description="relaxing shear modulus")
    time: SIField = SIField("s", above=0.0, description="relaxation time")

    def kernel(self, span: tuple[float, float] | None = None) -> Relaxation:
        """The spring and the single term."""
        return Relaxation(self.equilibrium, np.array([self.modulus]), np.array([self.time]))

    def prony(self) -> Prony:
        """The same as a series of one term."""
        return Prony(self.equilibrium, [self.modulus], [self.time])


@dataclass(frozen=True, eq=False)
class KelvinVoigt(SpringsAndDashpots):
    """
    A spring parallel to a dashpot: G(t) = modulus + viscosity delta(t).

    Parameters
    ----------
    modulus : quantity
        Shear modulus in Pa, above 0.
    viscosity : quantity
        Shear viscosity in Pa s, above 0.

    Examples
    --------
    >>> import pymdr as mdr
    >>> round(float(mdr.KelvinVoigt("1 Pa", "1 Pa*s").creep("1 s")), 12)
    0.632120558829
    """

    modulus: SIField = SIField("Pa", above=0.0, description="shear modulus")
    viscosity: SIField = SIField("Pa*s", above=0.0, description="shear viscosity")

    def kernel(self, span: tuple[float, float] | None = None) -> Relaxation:
        """The spring and the dashpot."""
        return Relaxation(self.modulus, viscosity=self.viscosity)
