"""Prony series fitted to measured moduli by non-negative least squares."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.problem.values import within_range
from pymdr.units import FloatArray, shown, written

FEWEST_ROWS = 5
WIDEST_GAP = 2.0
"""Largest gap between rows in decades."""
_PER_DECADE = 8
"""Times per decade of the full fit."""
_MISFIT_RATIO = 1.1
"""Largest misfit of a series of fewer terms, relative to the full fit."""
_ROUNDING = 1e-12
_SYSTEMATIC, _GROWN = 3.0, 10.0
"""Misfit and growth of a modulus, relative to the scatter, above which they are systematic."""
_DRIFT = 0.01
"""Relative growth of a modulus that is attributed to drift of the sensor."""
_PHASE = 0.1
"""Error of the phase in rad over the relative error of amplitudes, of rheometers."""


@dataclass(frozen=True)
class Measured:
    """Measured moduli, as equations for the terms of a series."""

    inverse: FloatArray
    """Rising times in s, or angular frequencies in rad/s."""
    moduli: tuple[FloatArray, ...]
    """G(t), or G' and G'', in Pa."""
    source: str
    """Function that was called, for messages."""

    def __post_init__(self) -> None:
        x, name = self.inverse, self.source
        if x.size < FEWEST_ROWS:
            raise ProblemError(f"{name}: {x.size} rows; at least {FEWEST_ROWS} are needed")
        for column in self.moduli:
            if column.size != x.size:
                raise ProblemError(f"{name}: {column.size} moduli for {x.size} rows; give one for each row")
            if np.any(column < 0.0):
                i = int(np.argmax(column < 0.0))
                raise ProblemError(
                    f"{name}: the modulus in row {i + 1} is {column[i]:g} Pa; it must be at least 0 Pa; leave noisy rows out"
                )
        if x[0] <= 0.0:
            raise ProblemError(
                f"{name}: row 1 is at {x[0]:g}; times since the step and frequencies must be above 0; leave "
                "earlier rows out"
            )
        if np.any(np.diff(x) <= 0.0):
            i = int(np.argmax(np.diff(x) <= 0.0))
            raise ProblemError(
                f"{name}: row {i + 2} is at {x[i + 1]:g}, not above the preceding {x[i]:g}; sort the rows and average "
                "repeated ones"
            )
        steps = np.diff(np.log10(x))
        if np.any(steps > WIDEST_GAP):
            i = int(np.argmax(steps > WIDEST_GAP))
            raise ProblemError(
                f"{name}: the gap from {x[i]:g} to {x[i + 1]:g} is {steps[i]:.6g} decades (limit {WIDEST_GAP:g}); measure "
                "in between, or fit the parts separately"
            )
        zero = np.all(np.array(self.moduli) == 0.0, axis=0)
        if np.any(zero):
            i = int(np.argmax(zero))
            raise ProblemError(f"{name}: the moduli in row {i + 1} are 0 Pa; leave the row out")
        for values, unit in ((x, "s or rad/s"), (np.max(self.moduli, axis=0), "Pa")):
            for extreme in (values.min(), values.max()):
                within_range(extreme, unit, name, size=True)

    @property
    def values(self) -> FloatArray:
        """The concatenated moduli in Pa."""
        return np.concatenate(self.moduli)

    @property
    def sizes(self) -> FloatArray:
        """Reference of the residuals in Pa: the moduli, at least a tenth of abs(G' + i G'')."""
        amplitude = np.sqrt(sum(column**2 for column in self.moduli))
        return np.maximum(self.values, np.tile(_PHASE * amplitude, len(self.moduli)))

    def misfit(self, values: FloatArray) -> float:
        """Relative root mean square residual of given moduli."""
        return float(np.sqrt(np.mean(((values - self.values) / self.sizes) ** 2)))

    @property
    def span(self) -> tuple[float, float]:
        """Shortest and longest relaxation time in s resolved by the rows."""
        low, high = float(self.inverse[0]), float(self.inverse[-1])
        return (low, high) if len(self.moduli) == 1 else (1.0 / high, 1.0 / low)

    def columns(self, times: FloatArray) -> FloatArray:
        """Contributions of unit equilibrium modulus and unit moduli at the times, per row."""
        x = self.inverse[:, None]
        if len(self.moduli) == 1:
            return np.hstack([np.ones_like(x), np.exp(-x / times)])
        y = x * times
        storage = np.hstack([np.ones_like(x), y**2 / (1.0 + y**2)])
        return np.vstack([storage, np.hstack([np.zeros_like(x), y / (1.0 + y**2)])])

    def log_derivatives(self, times: FloatArray) -> FloatArray:
        """Derivatives of the columns by the logarithms of their times."""
        x = self.inverse[:, None]
        if len(self.moduli) == 1:
            return np.asarray(x / times * np.exp(-x / times))
        y = x * times
        return np.vstack([2.0 * y**2, y * (1.0 - y**2)]) / np.tile((1.0 + y**2) ** 2, (2, 1))


@dataclass(frozen=True)
class Series:
    """A fitted series."""

    equilibrium: float
    moduli: FloatArray
    times: FloatArray
    misfit: float
    """Relative root mean square residual."""
    least: float = 0.0
    """Misfit of the full fit."""


def fitted(measured: Measured, terms: int | None = None, noise: float | None = None) -> Series:
    """
    Fit a series of few terms to measured moduli.

    Parameters
    ----------
    terms : int, optional
        Largest number of terms; by default as few as keep the misfit below `noise`.
    noise : float, optional
        Relative noise of the rows; by default 1.1 times the misfit of the full fit with eight terms per decade.

    Notes
    -----
    The fit minimises the squared relative residuals with moduli not below 0 (Lawson and Hanson, 1974) and times within the
    span of the rows. Terms are removed one by one: the least important one is left out, or two neighbours are merged. Faster
    terms are not resolved, slower ones are part of the equilibrium modulus.
    """
    _check(terms, noise)
    first, last = measured.span
    grid = np.geomspace(first, last, max(2, round(_PER_DECADE * np.log10(last / first))))
    best = full = _moved(measured, _moduli(measured, grid))
    _refuse_growing(measured, full)
    goal = max(_MISFIT_RATIO * full.misfit, _ROUNDING) if noise is None else noise
    if terms is None and full.misfit > goal:
        raise ProblemError(
            f"{measured.source}: the smallest relative misfit of a series is {full.misfit:.2g} (limit noise = {noise:g}); "
            "the body is not linear, or the noise is larger"
        )
    while best.times.size:
        fewer = _moved(measured, _with_one_less(measured, best))
        if fewer.misfit > goal if terms is None else best.times.size <= terms:
            break
        best = fewer
    if best.equilibrium == 0.0 and not best.times.size:
        raise ProblemError(
            f"{measured.source}: all fitted moduli are 0 Pa; the rows are not the relaxation of a linear body"
        )
    if not best.times.size and best.misfit > max(_DRIFT, _SYSTEMATIC * _scatter(measured)):
        raise ProblemError(
            f"{measured.source}: no term fits, and a constant modulus has a misfit of {100.0 * best.misfit:.2g} %; check that "
            "storage and loss belong to one sample and are in this order"
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
    name, unit, direction = ("G", "s", "time") if in_time else ("G'", "rad/s", "falling frequency")
    raise ProblemError(
        f"{measured.source}: {name} grows with {direction}, from {written(float(lowest[top]), 'Pa')} at {written(float(later[start]), unit)} to "
        f"{written(float(grown[top]), 'Pa')} at {written(float(later[top]), unit)}, more than the scatter of {100.0 * scatter:.2g} %, "
        "which is impossible for a linear body: leave out rows where the sample hardens, dries or slips, or correct the zero of the force"
    )


def _scatter(measured: Measured) -> float:
    """Relative rms scatter of moduli or storage moduli, from their deviation from neighbouring rows."""
    x, y = np.log(measured.inverse), measured.moduli[0]
    fraction = (x[1:-1] - x[:-2]) / (x[2:] - x[:-2])
    off = y[1:-1] - (1.0 - fraction) * y[:-2] - fraction * y[2:]
    size = np.maximum(y[1:-1], _PHASE * float(np.max(y)))
    return (
        float(np.sqrt(np.mean((off / size) ** 2 / (1.0 + fraction**2 + (1.0 - fraction) ** 2)))) + _ROUNDING
    )


def _check(terms: int | None, noise: float | None) -> None:
    if terms is not None and (isinstance(terms, bool) or not isinstance(terms, int) or not 1 <= terms <= 100):
        raise ProblemError(f"terms = {shown(terms)}: a whole number from 1 to 100 is needed")
    if noise is not None and not (isinstance(noise, int | float) and 0.0 < noise < 1.0):
        raise ProblemError(f"noise = {shown(noise)}: a fraction above 0 and below 1 is needed")
    if terms is not None and noise is not None:
        raise ProblemError("give either terms or noise; each sets the number of terms")


def _moduli(measured: Measured, times: FloatArray) -> Series:
    """The best non-negative moduli at given times."""
    from scipy.optimize import nnls

    size = measured.sizes
    matrix = measured.columns(times) / size[:, None]
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0.0] = 1.0
    try:
        moduli, residual = nnls(matrix / scale, measured.values / size, maxiter=100 * scale.size)
    except RuntimeError as error:
        raise ConvergenceError(
            f"{measured.source}: the fit of {times.size} moduli did not converge: {error}; use fewer terms, or remove scattered samples"
        ) from error
    moduli = moduli / scale
    kept = moduli[1:] > 0.0
    misfit = float(residual) / np.sqrt(size.size)
    return Series(float(moduli[0]), moduli[1:][kept], times[kept], misfit)


def _moved(measured: Measured, series: Series) -> Series:
    """The series with optimised times and moduli (Kaufman, 1975, BIT 15, 49)."""
    from scipy.optimize import least_squares

    if not series.times.size:
        return series
    low, high = np.log(measured.span)
    size = measured.sizes
    values = measured.values / size

    def terms(logs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Relative columns and their moduli."""
        matrix = measured.columns(np.exp(logs)) / size[:, None]
        best = _moduli(measured, np.exp(logs))
        moduli = np.zeros(logs.size + 1)
        moduli[0] = best.equilibrium
        moduli[1:][np.isin(np.exp(logs), best.times)] = best.moduli
        return matrix, moduli

    def residuals(logs: FloatArray) -> FloatArray:
        matrix, moduli = terms(logs)
        return np.asarray(matrix @ moduli - values)

    def slopes(logs: FloatArray) -> FloatArray:
        matrix, moduli = terms(logs)
        change = measured.log_derivatives(np.exp(logs)) / size[:, None] * moduli[1:]
        basis = np.linalg.qr(matrix[:, moduli > 0.0])[0]
        return np.asarray(change - basis @ (basis.T @ change))

    start = np.clip(np.log(series.times), low, high)
    optimum = least_squares(
        residuals, start, slopes, bounds=(low, high), xtol=1e-12, ftol=1e-12, gtol=1e-15, max_nfev=200
    )
    moved = _moduli(measured, np.exp(np.unique(optimum.x)))
    return moved if moved.misfit < series.misfit else series


def _with_one_less(measured: Measured, series: Series) -> Series:
    """The best series with one term left out or two neighbours merged."""
    t, g = series.times, series.moduli
    fewer = [np.delete(t, i) for i in range(t.size)]
    for i in range(t.size - 1):
        fraction = g[i + 1] / (g[i] + g[i + 1])
        merged = t[i] ** (1.0 - fraction) * t[i + 1] ** fraction
        fewer.append(np.concatenate([t[:i], [merged], t[i + 2 :]]))
    return min((_moduli(measured, times) for times in fewer), key=lambda series: series.misfit)
