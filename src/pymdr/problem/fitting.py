"""Prony series through measured moduli, by least squares whose terms are not below 0."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.problem.values import within_range
from pymdr.units import FloatArray, shown, written

FEWEST_ROWS = 5
WIDEST_GAP = 2.0
"""Decades without a sample that are refused."""
_PER_DECADE = 8
"""Times of the full fit for each decade."""
_SHARE = 1.1
"""How much worse than the full fit a series of fewer terms may be."""
_ROUNDING = 1e-12
_SYSTEMATIC, _GROWN = 3.0, 10.0
"""Of the scatter of the rows: misfits above it are no scatter, and so is what a modulus grows by."""
_DRIFT = 0.01
"""Of a modulus: what it may grow by as a sensor drifts."""
_PHASE = 0.1
"""Rheometers tell the phase in rad about ten times better than amplitudes, relatively."""


@dataclass(frozen=True)
class Measured:
    """Moduli that were measured, as equations for the terms of a series."""

    inverse: FloatArray
    """Rising times in s, or angular frequencies in rad/s."""
    moduli: tuple[FloatArray, ...]
    """G(t), or G' and G'', in Pa."""
    words: str

    def __post_init__(self) -> None:
        x, name = self.inverse, self.words
        if x.size < FEWEST_ROWS:
            raise ProblemError(f"{name}: {x.size} rows; at least {FEWEST_ROWS} are needed")
        for column in self.moduli:
            if column.size != x.size:
                raise ProblemError(
                    f"{name}: {column.size} moduli for {x.size} rows; give one for each of them"
                )
            if np.any(column < 0.0):
                i = int(np.argmax(column < 0.0))
                raise ProblemError(
                    f"{name}: the modulus in row {i + 1} is {column[i]:g} Pa; it must be at least 0 Pa: leave out rows that "
                    "are noise"
                )
        if x[0] <= 0.0:
            raise ProblemError(
                f"{name}: row 1 is at {x[0]:g}; times since the step and frequencies must be above 0: leave "
                "out what was before"
            )
        if np.any(np.diff(x) <= 0.0):
            i = int(np.argmax(np.diff(x) <= 0.0))
            raise ProblemError(
                f"{name}: row {i + 2} is at {x[i + 1]:g}, not above {x[i]:g} in the row before: sort the rows, and average "
                "those that repeat"
            )
        steps = np.diff(np.log10(x))
        if np.any(steps > WIDEST_GAP):
            i = int(np.argmax(steps > WIDEST_GAP))
            raise ProblemError(
                f"{name}: no row between {x[i]:g} and {x[i + 1]:g}, {steps[i]:.6g} decades; terms there are not known: measure "
                f"with gaps of at most {WIDEST_GAP:g} decades, or fit the parts by themselves"
            )
        nothing = np.all(np.array(self.moduli) == 0.0, axis=0)
        if np.any(nothing):
            i = int(np.argmax(nothing))
            raise ProblemError(f"{name}: row {i + 1} adds to nothing, 0 Pa; leave it out")
        for values, unit in ((x, "s or rad/s"), (np.max(self.moduli, axis=0), "Pa")):
            for extreme in (values.min(), values.max()):
                within_range(extreme, unit, name, size=True)

    @property
    def values(self) -> FloatArray:
        """The moduli in Pa, one after the other."""
        return np.concatenate(self.moduli)

    @property
    def sizes(self) -> FloatArray:
        """What they are compared with in Pa: themselves, or a tenth of abs(G' + i G'') where that is more."""
        whole = np.sqrt(sum(column**2 for column in self.moduli))
        return np.maximum(self.values, np.tile(_PHASE * whole, len(self.moduli)))

    def misfit(self, values: FloatArray) -> float:
        """Root mean square of what others lie off them, relative to their sizes."""
        return float(np.sqrt(np.mean(((values - self.values) / self.sizes) ** 2)))

    @property
    def span(self) -> tuple[float, float]:
        """The shortest and the longest relaxation time in s that it can tell."""
        low, high = float(self.inverse[0]), float(self.inverse[-1])
        return (low, high) if len(self.moduli) == 1 else (1.0 / high, 1.0 / low)

    def columns(self, times: FloatArray) -> FloatArray:
        """What the equilibrium modulus and those of the times, of 1 Pa each, give in each row."""
        x = self.inverse[:, None]
        if len(self.moduli) == 1:
            return np.hstack([np.ones_like(x), np.exp(-x / times)])
        y = x * times
        storage = np.hstack([np.ones_like(x), y**2 / (1.0 + y**2)])
        return np.vstack([storage, np.hstack([np.zeros_like(x), y / (1.0 + y**2)])])

    def bends(self, times: FloatArray) -> FloatArray:
        """The derivatives of the columns of times by the logarithms of these."""
        x = self.inverse[:, None]
        if len(self.moduli) == 1:
            return np.asarray(x / times * np.exp(-x / times))
        y = x * times
        return np.vstack([2.0 * y**2, y * (1.0 - y**2)]) / np.tile((1.0 + y**2) ** 2, (2, 1))


@dataclass(frozen=True)
class Series:
    """A series that was fitted."""

    equilibrium: float
    moduli: FloatArray
    times: FloatArray
    misfit: float
    """Root mean square of what it lies off the moduli, relative to their sizes."""
    least: float = 0.0
    """That of the full fit."""


def fitted(measured: Measured, terms: int | None = None, noise: float | None = None) -> Series:
    """
    The series of few terms that lies nearest to measured moduli.

    Parameters
    ----------
    measured : Measured
    terms : int, optional
        The largest number of terms. Unless given, they become fewer as long as the misfit is at most `noise`.
    noise : float, optional
        Relative noise of the rows; unless given, 1.1 of the misfit of the full fit, which begins with eight terms a
        decade.

    Returns
    -------
    Series

    Raises
    ------
    ProblemError
        If terms or noise is outside its limits, or no series reaches the noise.

    Notes
    -----
    Squares of what the series lies off each modulus, relative to itself, are least; moduli are not below 0 (Lawson and Hanson,
    1974), and the times move within the span of the rows. Terms become fewer one by one: the one goes whose loss costs least,
    or two neighbours become one. Terms faster than the rows cannot be told, slower ones are in
    the equilibrium modulus.
    """
    _check(terms, noise)
    first, last = measured.span
    grid = np.geomspace(first, last, max(2, round(_PER_DECADE * np.log10(last / first))))
    best = full = _moved(measured, _moduli(measured, grid))
    _refuse_growing(measured, full)
    goal = max(_SHARE * full.misfit, _ROUNDING) if noise is None else noise
    if terms is None and full.misfit > goal:
        raise ProblemError(
            f"{measured.words}: no series comes closer to the rows than {full.misfit:.2g} of their size, more than "
            f"noise = {noise:g}; they are no relaxation of a linear body, or their noise is larger"
        )
    while best.times.size:
        fewer = _moved(measured, _with_one_less(measured, best))
        if fewer.misfit > goal if terms is None else best.times.size <= terms:
            break
        best = fewer
    if best.equilibrium == 0.0 and not best.times.size:
        raise ProblemError(
            f"{measured.words}: the terms that lie nearest to the rows add to nothing, 0 Pa; the rows are no relaxation of a "
            "linear body within their span"
        )
    if not best.times.size and best.misfit > max(_DRIFT, _SYSTEMATIC * _scatter(measured)):
        raise ProblemError(
            f"{measured.words}: no term fits, and a modulus that does not relax lies {100.0 * best.misfit:.2g} % off the rows; check that "
            "the columns of storage and loss are of one sample, and their order"
        )
    return replace(best, least=full.misfit)


def _refuse_growing(measured: Measured, full: Series) -> None:
    """Refuse moduli that grow with time, or storage moduli that fall with frequency, by more than their scatter."""
    x, y = measured.inverse, measured.moduli[0]
    scatter = _scatter(measured)
    in_time = len(measured.moduli) == 1
    later, grown = (x, y) if in_time else (x[::-1], y[::-1])
    lowest = np.minimum.accumulate(grown)
    rise = grown - lowest
    if not full.misfit > _SYSTEMATIC * scatter or not np.any(rise > max(_GROWN * scatter, _DRIFT) * grown):
        return
    top = int(np.argmax(rise))
    start = int(np.argmin(grown[: top + 1]))
    name, unit, way = ("G", "s", "time") if in_time else ("G'", "rad/s", "falling frequency")
    raise ProblemError(
        f"{measured.words}: {name} grows with {way}, from {written(float(lowest[top]), 'Pa')} at {written(float(later[start]), unit)} to "
        f"{written(float(grown[top]), 'Pa')} at {written(float(later[top]), unit)}, and its scatter is {100.0 * scatter:.2g} %; no "
        "linear body relaxes so: leave out the rows where the sample hardens, dries or slips, or correct the zero of the force"
    )


def _scatter(measured: Measured) -> float:
    """
    What moduli, or storage moduli, scatter by, relative to themselves (root mean square).

    From how far each lies off a line through both its neighbours.
    """
    x, y = np.log(measured.inverse), measured.moduli[0]
    share = (x[1:-1] - x[:-2]) / (x[2:] - x[:-2])
    off = y[1:-1] - (1.0 - share) * y[:-2] - share * y[2:]
    size = np.maximum(y[1:-1], _PHASE * float(np.max(y)))
    return float(np.sqrt(np.mean((off / size) ** 2 / (1.0 + share**2 + (1.0 - share) ** 2)))) + _ROUNDING


def _check(terms: int | None, noise: float | None) -> None:
    if terms is not None and (isinstance(terms, bool) or not isinstance(terms, int) or not 1 <= terms <= 100):
        raise ProblemError(f"terms = {shown(terms)}: a whole number from 1 to 100 is needed")
    if noise is not None and not (isinstance(noise, int | float) and 0.0 < noise < 1.0):
        raise ProblemError(f"noise = {shown(noise)}: a share of the moduli above 0 and below 1 is needed")
    if terms is not None and noise is not None:
        raise ProblemError("terms and noise are both given; one of them chooses the number of terms")


def _moduli(measured: Measured, times: FloatArray) -> Series:
    """The moduli not below 0 that fit best at given times."""
    from scipy.optimize import nnls

    size = measured.sizes
    matrix = measured.columns(times) / size[:, None]
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0.0] = 1.0
    try:
        found, off = nnls(matrix / scale, measured.values / size, maxiter=100 * scale.size)
    except RuntimeError as error:
        raise ConvergenceError(
            f"{measured.words}: the moduli of {times.size} terms were not found: {error}"
        ) from error
    found = found / scale
    kept = found[1:] > 0.0
    misfit = float(off) / np.sqrt(size.size)
    return Series(float(found[0]), found[1:][kept], times[kept], misfit)


def _moved(measured: Measured, series: Series) -> Series:
    """The series with its times where they fit best, and its moduli with them (Kaufman, 1975, BIT 15, 49)."""
    from scipy.optimize import least_squares

    if not series.times.size:
        return series
    low, high = np.log(measured.span)
    size = measured.sizes
    values = measured.values / size

    def terms(logs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """All columns over the size of the rows, and the moduli that go with them."""
        matrix = measured.columns(np.exp(logs)) / size[:, None]
        found = _moduli(measured, np.exp(logs))
        moduli = np.zeros(logs.size + 1)
        moduli[0] = found.equilibrium
        moduli[1:][np.isin(np.exp(logs), found.times)] = found.moduli
        return matrix, moduli

    def off(logs: FloatArray) -> FloatArray:
        matrix, moduli = terms(logs)
        return np.asarray(matrix @ moduli - values)

    def slopes(logs: FloatArray) -> FloatArray:
        matrix, moduli = terms(logs)
        change = measured.bends(np.exp(logs)) / size[:, None] * moduli[1:]
        basis = np.linalg.qr(matrix[:, moduli > 0.0])[0]
        return np.asarray(change - basis @ (basis.T @ change))

    start = np.clip(np.log(series.times), low, high)
    found = least_squares(
        off, start, slopes, bounds=(low, high), xtol=1e-12, ftol=1e-12, gtol=1e-15, max_nfev=200
    )
    moved = _moduli(measured, np.exp(np.unique(found.x)))
    return moved if moved.misfit < series.misfit else series


def _with_one_less(measured: Measured, series: Series) -> Series:
    """The best of those in which one term is left out, or two neighbours are one between them."""
    t, g = series.times, series.moduli
    fewer = [np.delete(t, i) for i in range(t.size)]
    for i in range(t.size - 1):
        share = g[i + 1] / (g[i] + g[i + 1])
        one = t[i] ** (1.0 - share) * t[i + 1] ** share
        fewer.append(np.concatenate([t[:i], [one], t[i + 2 :]]))
    return min((_moduli(measured, times) for times in fewer), key=lambda found: found.misfit)
