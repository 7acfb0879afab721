"""The unloading of one indent, and curves fitted to it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from pymdr.errors import ProblemError
from pymdr.mapping.equivalent import power_factor
from pymdr.solving.fits.bands import orthonormal
from pymdr.solving.fits.spectrum import NORMAL_95, noise_spectra
from pymdr.solving.nanoindentation.records import Record
from pymdr.units import FloatArray, metres, shown, written

_FEWEST = 12
"""Rows to which a curve is fitted."""
_TOP, _BLOCK = 4.0, 0.98
"""Noises below the largest force, and part of it, down to which rows belong to the peak."""
_UNLOADED, _BACKWARD = 0.15, 0.4
"""Loads over the largest that count as small, and a rise of the surface over the range of the depth that no elastic indent makes between them."""
_SHALLOWEST, _ABOVE_LEAST = 0.03, 0.01
"""Parts of the largest force: where a complete unloading ends, and how far above its smallest force."""
_EXPONENTS, _UNCERTAIN = (0.4, 12.0), 1.0
"""Range of the exponents of a determined fit, and the largest standard deviation of its parameters."""
_PASSES, _NEWTON = 8, 8
"""Most fits by depth, each with the stiffness of the one before, and steps of Newton's method."""
_FAR = 1.0
"""Logarithm of the fitted force over the largest force at the begin of the unloading, beyond which there is no fit."""
_TANH_SINH = np.linspace(-3.3, 3.3, 97)


class Unloading(NamedTuple):
    """The rows after the peak of a record, by their indentations from an anchor depth."""

    depth: FloatArray
    """In m, corrected for the compliance of the frame."""
    force: FloatArray
    peak_force: float
    peak_error: float
    """Standard deviation in N."""
    fitted: slice
    """Rows of the range of the fit by a power law."""
    complete: slice
    """Rows down to where the contact ends."""
    elapsed: FloatArray | None = None
    """Times in s, in proportion to which drift was subtracted from the depths."""
    rate_error: float = 0.0
    """Standard deviation in m/s of its rate."""
    frame: float = 0.0
    """Compliance in m/N for which the depths are corrected."""


def fit_limits(fit_range: Sequence[float]) -> tuple[float, float]:
    """The range of a fit in parts of the largest force."""
    try:
        low, high = (float(end) for end in fit_range)
    except (TypeError, ValueError):
        low, high = math.nan, math.nan
    if not 0.0 < low < high <= 1.0:
        raise ProblemError(
            f"fit_range = {shown(fit_range)}; two fractions of the largest force are needed, such as (0.25, 0.98)"
        )
    return low, high


def unloading_of(record: Record, frame: float, limits: tuple[float, float]) -> Unloading:
    """
    The unloading from the largest force of a record.

    Parameters
    ----------
    frame : float
        Compliance in m/N for which its depths are corrected.
    limits : tuple of float
        Range of the fit by a power law, in parts of the largest force.
    """
    force = record.force
    depth = record.depth - frame * force
    largest = float(np.max(force))
    if not largest > 0.0:
        raise ProblemError("no force is above 0 N; compressive forces must be positive")
    if _runs_backward(depth, force / largest):
        raise ProblemError(
            f"the record begins at {metres(float(depth[0]))} and ends at {metres(float(depth[-1]))}, both at small loads, but an indent leaves "
            "the surface deeper: the rows run backward; reverse them"
        )
    noise = noise_of(force)
    last = int(np.flatnonzero(force >= largest - _TOP * noise)[-1])
    peak, error = _peak(force, last, largest, noise)
    after = force[last:]
    low = last + _first_below(after, limits[0] * peak)
    least = max(_SHALLOWEST * peak, float(after.min()) + _ABOVE_LEAST * peak, _TOP * noise)
    end = last + _first_below(after, least)
    above = np.flatnonzero(force[last:low] >= limits[1] * peak)
    begin = last + 1 + (int(above[-1]) if above.size else 0)
    if low - begin < _FEWEST:
        raise ProblemError(
            f"{max(low - begin, 0)} rows of the unloading are between {limits[0]:g} and {limits[1]:g} of the largest force; at "
            f"least {_FEWEST} are needed: give a record with its unloading, or a wider fit_range"
        )
    rows = slice(begin, max(end, low))
    return Unloading(
        depth[rows],
        force[rows],
        peak,
        error,
        slice(0, low - begin),
        slice(0, max(end, low) - begin),
        None if record.elapsed is None else record.elapsed[rows],
        record.rate_error,
        frame,
    )


def _runs_backward(depth: FloatArray, load: FloatArray) -> bool:
    """Whether a record with small loads at both ends, relative to its largest, begins much deeper than it ends."""
    unloaded = max(abs(float(load[0])), abs(float(load[-1]))) < _UNLOADED
    return unloaded and float(depth[0] - depth[-1]) > _BACKWARD * float(np.ptp(depth))


def noise_of(values: FloatArray) -> float:
    """Standard deviation of the noise of rows, from their second differences."""
    return float(np.median(np.abs(np.diff(values, 2)))) / (0.6745 * math.sqrt(6.0))


def _first_below(force: FloatArray, level: float) -> int:
    """The first row with a force below a level, or the number of rows."""
    below = np.flatnonzero(force < level)
    return int(below[0]) if below.size else force.size


def _peak(force: FloatArray, last: int, largest: float, noise: float) -> tuple[float, float]:
    """
    The largest force without its noise, and its standard deviation.

    The mean of the middle third of the rows at the peak: the ramps of a record without hold lie at the ends.
    """
    start = last
    while start > 0 and force[start - 1] >= _BLOCK * largest - 2.0 * _TOP * noise:
        start -= 1
    top = force[start : last + 1]
    top = top[int(np.argmax(top >= largest - _TOP * noise)) :]
    third = top.size // 3
    middle = top[third : top.size - third]
    return float(middle.mean()), noise / math.sqrt(middle.size)


class Errors(NamedTuple):
    """Errors of parameters of least squares."""

    covariance: FloatArray
    """1.96 of its deviations are the half widths of the 95 % intervals."""
    correlated: float
    """Number of rows equivalent to one independent row: the largest ratio of the variances of parameters to those under white noise."""
    white: float
    """Probability that the noise is white."""


class Shape(NamedTuple):
    """
    F = F0 u^m (1 + w (u - 1)) with u = 1 - (h0 - h)/L and L = F0 (m + w)/S: a power law for w = 0.

    `parameters` are ln F0, ln S, m and, unless it is a power law, w, at the anchor depth h0.
    """

    anchor: float
    parameters: FloatArray
    errors: Errors
    rows: int
    misfit: float
    """Root mean square of the residuals, in parts of the largest force."""

    @property
    def determined(self) -> bool:
        """Whether the exponents and their errors are those of a curve, and not of noise."""
        deviations = np.sqrt(np.diag(self.errors.covariance))
        exponents = self.parameters[2:]
        return bool(
            np.isfinite(self.parameters).all()
            and np.isfinite(deviations).all()
            and _EXPONENTS[0] < self.parameters[2] < _EXPONENTS[1]
            and exponents.sum() > _EXPONENTS[0]
            and deviations.max() < _UNCERTAIN
        )


def fitted_power(rows: Unloading, prior: float = 0.5) -> Shape:
    """The power law through the range of the fit; the prior probability of white noise is given."""
    return _power(rows, rows.fitted, prior)


def refitted(rows: Unloading, shape: Shape, rate: float) -> FloatArray:
    """Parameters of a shape, at its own anchor depth, fitted to its rows with a drift in m/s that is larger by `rate`."""
    assert rows.elapsed is not None
    stretch = slice(0, shape.rows)
    z = shape.anchor - rows.depth[stretch] + rate * rows.elapsed[stretch]
    force = rows.force[stretch]
    return np.asarray(
        least_squares(
            lambda p: np.nan_to_num(forces(p, z) - force) / rows.peak_force,
            shape.parameters,
            jac=lambda p: _slopes(p, z) / rows.peak_force,
            method="lm",
            xtol=1e-12,
            ftol=1e-12,
        ).x
    )


def fitted_shape(rows: Unloading, prior: float = 0.5) -> Shape:
    """The two powers through the complete unloading, or the one that noise lets it determine."""
    power = _power(rows, rows.complete, prior)
    two = _fitted(rows, rows.complete, np.append(power.parameters, 0.0), prior)
    return two if two.determined else power


def _power(rows: Unloading, stretch: slice, prior: float = 0.5) -> Shape:
    z, force = rows.depth[0] - rows.depth[stretch], rows.force[stretch]
    if not _is_decreasing(z, force):
        if _is_decreasing(z + rows.frame * (force[0] - force), force):
            raise ProblemError(
                f"the frame compliance {1e6 * rows.frame:.4g} nm/mN is too large: the measured depth decreases in the unloading, but "
                "not after subtraction of the deflection of the frame; give a smaller frame_compliance, or leave it out if the instrument has "
                "subtracted it"
            )
        raise ProblemError(
            "the depth does not fall in the unloading; check the order and the signs of the rows"
        )
    power = _fitted(rows, stretch, _first_guess(z, force, rows.peak_force), prior)
    if not power.determined:
        noise, recovery = noise_of(rows.depth[stretch]), float(np.ptp(z))
        raise ProblemError(
            f"the unloading does not determine F = B (h - h_f)^m: the noise of the depth is {written(noise, 'm')}, {100.0 * noise / recovery:.2g} % of "
            f"its recovery of {written(recovery, 'm')}; widen the range of the fit, check the frame compliance, or unload more slowly"
        )
    return power


def _is_decreasing(z: FloatArray, force: FloatArray) -> bool:
    """Whether the force falls with the recovery z of the depth."""
    spread = float(np.ptp(z))
    return spread > 0.0 and float(np.polyfit(z / spread, force, 1)[0]) < 0.0


def _fitted(rows: Unloading, stretch: slice, start: FloatArray, prior: float = 0.5) -> Shape:
    anchor = float(rows.depth[0])
    z, force = anchor - rows.depth[stretch], rows.force[stretch] / rows.peak_force
    unit = np.where(np.arange(start.size) < 2, math.log(rows.peak_force), 0.0)
    noise = noise_of(rows.depth[stretch])
    n = force.size
    if math.exp(start[1]) * noise > rows.peak_force * noise_of(force):
        p, residuals, slopes = _fitted_by_depth(start - unit, z, force)
    else:
        p = _fitted_by_force(start - unit, z, force)
        p = p + _attenuation(p, z, noise)
        residuals, slopes = np.nan_to_num(forces(p, z) - force), _slopes(p, z)
    if not abs(p[0]) < _FAR:  # noise, in which the search runs away
        return Shape(anchor, np.full(p.size, np.nan), Errors(np.eye(p.size), 1.0, 1.0), n, math.inf)
    errors = errors_of(residuals, slopes, prior)
    return Shape(anchor, p + unit, errors, n, float(np.sqrt(np.mean(residuals**2))))


def _fitted_by_force(start: FloatArray, z: FloatArray, force: FloatArray) -> FloatArray:
    """The parameters with the smallest squares of the residuals of the forces, which noise of the heights biases."""
    return np.asarray(
        least_squares(
            lambda p: np.nan_to_num(forces(p, z) - force), start, jac=lambda p: _slopes(p, z), method="lm"
        ).x
    )


def _fitted_by_depth(
    start: FloatArray, z: FloatArray, force: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Parameters, residuals and their derivatives if the noise is that of the heights, which does not bias this fit.

    The residuals are those of the heights times the stiffness at the forces of the rows, by the fit before: to first order those of the forces.
    """
    p = start
    for _ in range(_PASSES):
        last, stiffness = p, 1.0 / _heights(p, force).per_force
        p = least_squares(
            lambda p, k: np.nan_to_num(k * (_heights(p, force).height - z)),
            p,
            jac=lambda p, k: np.nan_to_num(k[:, None] * _heights(p, force).slopes),
            method="lm",
            args=(stiffness,),
        ).x
        if np.allclose(p, last, rtol=0.0, atol=1e-6):
            break
    at = _heights(p, force)
    stiffness = 1.0 / at.per_force
    return p, np.nan_to_num(stiffness * (at.height - z)), np.nan_to_num(stiffness[:, None] * at.slopes)


def errors_of(residuals: FloatArray, slopes: FloatArray, prior: float = 0.5) -> Errors:
    """
    Errors of parameters from the residuals, by the spectrum of their noise.

    With H the covariance by this spectrum, s I that by white noise of equal rows and Q by white noise that differs between rows (White 1980), all
    of orthonormal combinations of the parameters, the covariance is H^(1/2) Q H^(1/2)/s: that of either effect without the other.

    Parameters
    ----------
    slopes : ndarray, shape (n, p)
        Derivatives of the residuals.
    prior : float
        Probability of white noise without data.
    """
    basis, coefficients = orthonormal(slopes.T[None])
    spectra = noise_spectra(residuals[None], basis, prior=prior, keep=True)
    rows, own, free = basis[0], spectra.covariance[0], max(residuals.size - slopes.shape[1], 1)
    white = float(residuals @ residuals) / free
    if not white > 0.0:
        return Errors(np.zeros_like(own), 1.0, 1.0)
    values, vectors = np.linalg.eigh(own / white)
    root = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T
    coloured = coefficients[0] @ root
    ratios = (coloured**2).sum(axis=1) / (coefficients[0] ** 2).sum(axis=1)
    between = (rows * residuals**2) @ rows.T * (residuals.size / free)
    # the mean over spectra has wider tails than a normal distribution
    scaled = (spectra.quantile(coefficients)[0] / NORMAL_95)[:, None] * coloured
    return Errors(scaled @ between @ scaled.T, max(float(ratios.max()), 1.0), float(spectra.white[0]))


def _first_guess(z: FloatArray, force: FloatArray, peak: float) -> FloatArray:
    top = slice(0, max(4, z.size // 3))
    spread = float(np.ptp(z[top])) or float(np.ptp(z))
    slope, size = np.polyfit(-z[top] / spread, force[top], 1)
    stiffness, size = max(slope / spread, 0.1 * peak / float(np.ptp(z))), max(size, 0.1 * peak)
    return np.array([math.log(size), math.log(stiffness), max(1.4, 1.05 * float(z.max()) * stiffness / size)])


class _Curve(NamedTuple):
    u: FloatArray
    force: FloatArray
    by_u: FloatArray
    length: float


def _curve(p: FloatArray, z: FloatArray) -> _Curve:
    m, w = p[2], p[3] if p.size > 3 else 0.0
    # a search may try numbers that overflow
    with np.errstate(all="ignore"):
        size = np.exp(p[0])
        length = size * (m + w) / np.exp(p[1])
        u = np.maximum(1.0 - z / length, 1e-12)
        factor = 1.0 + w * (u - 1.0)
        return _Curve(u, size * u**m * factor, size * (m * u ** (m - 1.0) * factor + w * u**m), length)


def forces(p: FloatArray, z: FloatArray) -> FloatArray:
    """Forces in N at heights z in m above the anchor."""
    return _curve(p, z).force


class _Heights(NamedTuple):
    height: FloatArray
    per_force: FloatArray
    """Fall of the height with the force."""
    slopes: FloatArray
    """Derivatives of the height by the parameters."""


def _heights(p: FloatArray, force: FloatArray) -> _Heights:
    """Heights in m at forces, by Newton's method in u, and their derivatives."""
    m, w = p[2], p[3] if p.size > 3 else 0.0
    with np.errstate(all="ignore"):
        length = np.exp(p[0]) * (m + w) / np.exp(p[1])
        u = np.maximum(force / np.exp(p[0]), 1e-12) ** (1.0 / (m + w))
        for _ in range(_NEWTON if w else 0):
            at = _curve(p, length * (1.0 - u))
            u = np.maximum(u - (at.force - force) / at.by_u, 0.1 * u)
        z = length * (1.0 - u)
        per_force = length / _curve(p, z).by_u
        return _Heights(z, per_force, _slopes(p, z) * per_force[:, None])


def _attenuation(p: FloatArray, z: FloatArray, noise: float) -> FloatArray:
    """
    Bias of the parameters of a fit of forces by noise of the depths, to first order in its variance.

    With residuals r = F - f(h + e) and J = df/dp at h + e, the mean of J r is -(J' f' + J f''/2) e^2, not 0.
    """
    step = 1e-4 * float(np.ptp(z))
    low, jacobian, high = (_slopes(p, z + shift) for shift in (step, 0.0, -step))
    forces_at = [forces(p, z + shift) for shift in (step, 0.0, -step)]
    slope = (forces_at[2] - forces_at[0]) / (2.0 * step)
    bend = (forces_at[2] - 2.0 * forces_at[1] + forces_at[0]) / step**2
    bias = noise**2 * ((high - low) / (2.0 * step) * slope[:, None] + 0.5 * jacobian * bend[:, None]).sum(
        axis=0
    )
    return np.asarray(np.linalg.pinv(jacobian.T @ jacobian) @ bias)


def _slopes(p: FloatArray, z: FloatArray) -> FloatArray:
    """Derivatives of the forces by the parameters."""
    u, force, by_u, length = _curve(p, z)
    m, w = p[2], p[3] if p.size > 3 else 0.0
    with np.errstate(all="ignore"):
        moved = by_u * z / length
        columns = [force + moved, -moved, force * np.log(u) + moved / (m + w)]
        if p.size > 3:
            columns.append(np.exp(p[0]) * u**m * (u - 1.0) + moved / (m + w))
        return np.asarray(np.nan_to_num(np.stack(columns, axis=1)))


@dataclass(frozen=True)
class Peak:
    """The contact at the largest force, by a curve through its unloading."""

    force: float
    depth: float
    residual_depth: float
    stiffness: float
    epsilon: float
    """(h - h_c) S/F."""
    exponent: float
    """d ln F/d ln(h - h_f) at the largest force."""
    rising: float
    """Largest stiffness below the peak over that at the peak."""


def peak_of(anchor: float, p: FloatArray, peak_force: float, epsilon: float | None) -> Peak:
    """
    The contact at the largest force.

    Parameters
    ----------
    anchor : float
        Depth in m at which the parameters are.
    p : ndarray
        Of a :class:`Shape`.
    peak_force : float
        In N.
    epsilon : float, optional
        Given, or that of the effective shape: h - h_c = (2/pi) int_0^d arcsin(k(t)/k(d)) dt, which is d - f(a) of the profile whose line
        has the stiffness k; for a power law (1 + 1/n) (1 - 1/kappa(n)) with n = 1/(m - 1).
    """
    m, w = float(p[2]), float(p[3]) if p.size > 3 else 0.0
    size = math.exp(p[0])
    length = size * (m + w) / math.exp(p[1])
    u = (peak_force / size) ** (1.0 / (m + w))
    for _ in range(8):
        at = _curve(p, length * (1.0 - np.array([u])))
        u -= (float(at.force[0]) - peak_force) / float(at.by_u[0])
    at = _curve(p, length * (1.0 - np.array([u])))
    stiffness, rising = float(at.by_u[0]) / length, 1.0
    if epsilon is None and p.size == 3:
        epsilon = epsilon_of_power(m)
    elif epsilon is None:
        nodes, weights = _rule()
        k = _curve(p, length * (1.0 - u * nodes)).by_u / length / stiffness
        rising = float(k.max())
        sink_in = 2.0 / math.pi * length * u * float(weights @ np.arcsin(np.clip(k, 0.0, 1.0)))
        epsilon = sink_in * stiffness / peak_force
    depth, residual = anchor - length * (1.0 - u), anchor - length
    return Peak(
        peak_force, depth, residual, stiffness, epsilon, stiffness * (depth - residual) / peak_force, rising
    )


def epsilon_of_power(m: float) -> float:
    """
    Epsilon of F ~ (h - h_f)^m: (1 + 1/n) (1 - 1/kappa(n)) with n = 1/(m - 1); 1 of a flat punch.

    Examples
    --------
    >>> round(epsilon_of_power(1.5), 12), round(epsilon_of_power(2.0), 4)
    (0.75, 0.7268)
    """
    if m <= 1.0 + 1e-9:
        return 1.0
    return m * (1.0 - 1.0 / power_factor(1.0 / (m - 1.0)))


def _rule() -> tuple[FloatArray, FloatArray]:
    """Nodes and weights on [0, 1] for powers at both ends."""
    t = _TANH_SINH
    argument = 0.5 * math.pi * np.sinh(t)
    nodes = 1.0 / (1.0 + np.exp(-2.0 * argument))
    weights = 0.25 * math.pi * np.cosh(t) / np.cosh(argument) ** 2 * (t[1] - t[0])
    return nodes, weights
