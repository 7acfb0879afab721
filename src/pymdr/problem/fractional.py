"""Power-law rheology, and its approximation by exponentials."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.problem.rheology import Prony, Rheology
from pymdr.problem.spectra import Relaxation
from pymdr.problem.values import SIField
from pymdr.units import ArrayQuantityLike, FloatArray, QuantityLike, to_si

Faster = Callable[[float, float], tuple[FloatArray, FloatArray]]
"""Moduli and rising times of terms faster than one of 1 Pa and 1 s, by the exponent and the step of a rule."""


@dataclass(frozen=True, eq=False)
class PowerLawRheology(Rheology):
    """
    A power of time, G(t) = modulus (t/time)^-exponent, as in biological tissue, gels and pastes.

    Parameters
    ----------
    modulus : quantity
        Relaxation modulus at the reference time in Pa, above 0.
    time : quantity
        Reference time in s, above 0.
    exponent : quantity
        Above 0 (a solid) and below 1 (a liquid).

    See Also
    --------
    Prony : a sum of exponentials.

    Notes
    -----
    With the exponent b, J(t) = sin(pi b)/(pi b) (t/time)^b / modulus, and
    G' + i G'' = modulus Gamma(1 - b) (i omega time)^b (Nutting, 1921; Scott Blair, 1947).

    References
    ----------
    - Nutting (1921), J. Franklin Inst. 191, 679-685.
    - Scott Blair (1947), J. Colloid Sci. 2, 21-32.

    Examples
    --------
    >>> import pymdr as mdr
    >>> cell = mdr.PowerLawRheology("1 kPa", "1 s", 0.2)
    >>> round(float(cell.loss(1.0) / cell.storage(1.0)), 9)
    0.324919696
    """

    modulus: SIField = SIField("Pa", above=0.0, description="relaxation modulus at the time")
    time: SIField = SIField("s", above=0.0, description="time at which the modulus is given")
    exponent: SIField = SIField("", above=0.0, below=1.0, description="exponent of the decay")

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
        """The series that approximates it over a span, with its measured error."""
        if span is None:
            raise ProblemError(
                "a finite series needs a span of times; give for example span = ('1 ms', '100 s')"
            )
        first, last = _span(*span)
        return replace(self._whole(first, last, _SERIES_ERROR, _impulse), instantly_rigid=True)

    def softened(self, span: tuple[float, float], error: float) -> Relaxation:
        """
        A series of few terms with a finite instantaneous modulus.

        Parameters
        ----------
        span : tuple of float
            Shortest and longest relevant time in s.
        error : float
            Largest relative error of G(t) in the span. The error of the series includes its integral and its creep, to which faster terms contribute.
        """
        return self._whole(*_span(*span), error, _smooth_impulse)

    def _whole(self, first: float, last: float, error: float, faster: Faster) -> Relaxation:
        """A series over a span with terms for faster relaxation, and its measured error."""
        (moduli, times), missed = self._series(first, last, error)
        stiffer, shorter = faster(self.exponent, _step(self.exponent, error))
        kernel = Relaxation(0.0, np.append(moduli[0] * stiffer, moduli), np.append(times[0] * shorter, times))
        return replace(kernel, error=_BETWEEN * max(missed, self._impulse_error(kernel, first, last)))

    def _series(self, first: float, last: float, error: float) -> tuple[tuple[FloatArray, FloatArray], float]:
        """Moduli and rising times of a series over a span, and the largest relative error of its G(t) there."""
        rates, weights = _exponentials(self.exponent, first, last, error)
        size = self.modulus * (last / self.time) ** -self.exponent
        kernel = Relaxation(0.0, size * weights[::-1], 1.0 / rates[::-1])
        t = _grid(first, last)
        largest = float(np.max(np.abs(kernel(t) / self.relaxation(t) - 1.0)))
        if largest > error:
            raise ConvergenceError(
                f"the relative error of {rates.size} terms is {largest:.2g} (limit {error:g}); "
                "give a larger error"
            )
        return (kernel.moduli, kernel.times), largest

    def _impulse_error(self, kernel: Relaxation, first: float, last: float) -> float:
        """The largest relative error of the integral of G from 0 on, and of J, over a span."""
        t = _grid(first, last)
        flow = -np.expm1(-t[:, None] / kernel.times) @ (kernel.moduli * kernel.times)
        exact = self.relaxation(t) * t / (1.0 - self.exponent)
        creep = kernel.retardation(t) / self.creep(t)
        return float(max(np.max(np.abs(flow / exact - 1.0)), np.max(np.abs(creep - 1.0))))

    def prony(self, shortest: QuantityLike, longest: QuantityLike, *, error: float = 1e-9) -> Prony:
        """
        A series that approximates the power law over a span of times.

        Parameters
        ----------
        shortest, longest : quantity
            The span in s. Outside it the series differs: its instantaneous modulus is finite, and it flows as a liquid.
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
            If the measured error on the span exceeds `error`.

        Notes
        -----
        t^-b = int exp(b y - t exp(y)) dy / Gamma(b) by the trapezoidal rule, whose relative error
        2 |Gamma(b + 2 pi i/h)|/Gamma(b) for the step h is the same at every t (McLean, 2018, in Contemporary Computational
        Mathematics). Terms slower than the span are replaced by a Gaussian rule.

        Examples
        --------
        >>> import pymdr as mdr
        >>> series = mdr.PowerLawRheology("1 kPa", "1 s", 0.2).prony("1 ms", "1 ks")
        >>> round(float(series.relaxation("1 s")), 5)
        1000.0
        """
        first, last = _span(shortest, longest)
        if not 1e-12 <= error <= 0.1:
            raise ProblemError(f"error = {error:g}; it must be from 1e-12 to 0.1")
        (moduli, times), _ = self._series(first, last, error)
        return Prony(0.0, moduli, times)


WIDEST = 1e30
"""Largest ratio of the times of a span."""


_SERIES_ERROR = 1e-11
"""Largest relative error of the series for a span; far below 1e-9, because rows small compared with their history amplify it."""


_BETWEEN = 2.0
"""Safety factor for errors between the times at which they are measured."""


_FAST_TERMS, _SMOOTH_TERMS = 4, 3
"""Terms that represent faster relaxation, in addition to one at 0 or without it."""


_FASTEST = 60.0
"""Logarithm of the largest rate, relative to the series, that enters the moments of the times."""


_INSTANT = 1e-24
"""Time of the term at 0, relative to the shortest of the others."""


def _span(shortest: QuantityLike, longest: QuantityLike) -> tuple[float, float]:
    first, last = to_si(shortest, "s", name="shortest"), to_si(longest, "s", name="longest")
    if not 0.0 < first < last <= WIDEST * first:
        raise ProblemError(
            f"span from {first:g} s to {last:g} s: it must be above 0 s and rise, by a factor of at most {WIDEST:g}"
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
    # slower terms are constant over the span; the first weight includes them
    weights = np.exp(exponent * y + math.log(step) - gammaln(exponent))
    weights[0] /= -math.expm1(-exponent * step)
    slow = y < 0.0
    nodes, few = _gauss(np.exp(y[slow]), weights[slow])
    return np.append(nodes, np.exp(y[~slow])) / last, np.append(few, weights[~slow])


def _impulse(exponent: float, step: float) -> tuple[FloatArray, FloatArray]:
    """
    Moduli and rising times of few terms that represent all terms of the trapezoidal rule faster than a term of 1 Pa and 1 s.

    The k-th of these has the time exp(-k step) and the impulse (modulus times time) exp((exponent - 1) k step). A Gauss-Radau rule
    for the impulses keeps their sum and moments, so that loads smooth over 1 s are unaffected. The time of its node at 0 is
    negligibly short.
    """
    points, impulses = _faster(exponent, step)
    times, weights = _gauss(points, points * impulses, _FAST_TERMS)
    ratio = math.exp((exponent - 1.0) * step)
    rest = ratio / (1.0 - ratio) - float((weights / times).sum())
    return np.append(rest / _INSTANT, weights / times**2), np.append(_INSTANT, times)


def _smooth_impulse(exponent: float, step: float) -> tuple[FloatArray, FloatArray]:
    """As `_impulse`, by a Gauss rule, whose moduli are finite."""
    times, weights = _gauss(*_faster(exponent, step), _SMOOTH_TERMS)
    return weights / times, times


def _faster(exponent: float, step: float) -> tuple[FloatArray, FloatArray]:
    """Times and impulses of all terms that are faster; the last one stands for those that are negligibly short."""
    k = np.arange(1.0, math.ceil(_FASTEST / step) + 1.0)
    impulses = np.exp((exponent - 1.0) * k * step)
    impulses[-1] /= -math.expm1((exponent - 1.0) * step)
    return np.exp(-k * step), impulses


def _gauss(points: FloatArray, weights: FloatArray, most: int = 8) -> tuple[FloatArray, FloatArray]:
    """At most `most` rising nodes with positive weights, exact for polynomials of degree 2 n - 1 (Lanczos)."""
    total = float(weights.sum())
    columns = [np.sqrt(weights / total)]
    diagonal, off_diagonal = [], []
    for _ in range(min(most, points.size)):
        latest = columns[-1]
        diagonal.append(float(latest @ (points * latest)))
        rest = points * latest
        for _ in range(2):
            for column in columns:
                rest = rest - (column @ rest) * column
        off_diagonal.append(float(np.linalg.norm(rest)))
        columns.append(rest / off_diagonal[-1])
    n = len(diagonal)
    matrix = np.diag(diagonal) + np.diag(off_diagonal[: n - 1], 1) + np.diag(off_diagonal[: n - 1], -1)
    nodes, vectors = np.linalg.eigh(matrix)
    return nodes, total * vectors[0] ** 2
