"""The branch of a curve from which its baseline and its contact point are determined."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ProblemError
from pymdr.problem.measured import MeasuredSamples
from pymdr.units import FloatArray, written

IntArray = NDArray[np.int_]

MOST = 600
"""Largest number of blocks, whose means represent a branch in exhaustive searches."""
_FLAT = 1e-9
"""Rounding error relative to the range of the forces."""


@dataclass(frozen=True)
class Branch:
    """Unmarked samples from the free end to the deep one."""

    samples: IntArray
    """Their indices in the curve."""
    position: FloatArray
    force: FloatArray


def branch_of(curve: MeasuredSamples) -> Branch:
    """
    The approach, or the reversed retreat if there is no approach.

    Raises
    ------
    ProblemError
        If the curve is a hold, its position does not change, or fewer than 20 samples are left.
    """
    if curve.segment == "hold":
        raise ProblemError(
            "a hold has neither baseline nor contact point: give those of the approach, or join the segments"
        )
    position, marked = curve.position, curve.marked
    width = float(np.ptp(position))
    if not width > 1e-12 * float(np.max(np.abs(position))):
        raise ProblemError(
            f"the position is constant, {written(float(position[0]), 'm')}; give a curve along which it changes"
        )
    deepest = np.flatnonzero(position >= position.max() - 0.005 * width)
    first, last = int(deepest[0]), int(deepest[-1])
    if np.ptp(position[: first + 1]) >= 0.5 * width:
        samples = np.arange(first + 1)
    else:
        samples = np.arange(last, position.size)[::-1]
    samples = samples[~marked[samples]]
    if samples.size < 20:
        raise ProblemError(
            f"{samples.size} samples are between the free end and the deepest one (limit 20); sample faster, or read the whole file"
        )
    return Branch(samples, position[samples], curve.force[samples])


def blocks(values: FloatArray, most: int = MOST) -> FloatArray:
    """Means of blocks of equal numbers of samples, without the remainder at the beginning."""
    size = max(1, values.size // most)
    return np.asarray(values[values.size % size :].reshape(-1, size).mean(axis=1))


def spread(values: FloatArray) -> float:
    """Standard deviation of a normal distribution with the same median of absolute deviations."""
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))


def correlation_length(values: FloatArray) -> float:
    """Samples per independent sample, for exponential correlation: (1 + r)/(1 - r) with the first lag."""
    d = values - values.mean()
    total = float(d @ d)
    r = float(d[1:] @ d[:-1]) / total if total > 0.0 else 0.0
    return (1.0 + max(r, 0.0)) / (1.0 - min(max(r, 0.0), 0.999))


@dataclass(frozen=True)
class BrokenPower:
    """A line plus a power of the distance from x0: f = a + b x + c (x - x0)^n, optionally with a jump."""

    start: float
    """x0 in m."""
    low: float
    high: float
    """Ends of the interval of the profile likelihood of three standard errors."""
    exponent: float
    evidence: float
    """Decrease of the sum of squares, relative to an independent residual."""
    rise: float
    """Largest departure from the line in N."""
    noise: float
    """Noise of a block of the branch in N."""
    clear_from: float
    """Position in m at which the power is half the noise."""


_EXPONENTS = (1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0)


def broken_power(x: FloatArray, f: FloatArray, *, jump: bool = False) -> BrokenPower:
    """
    Least squares of a line with a power beyond a point, for every point.

    Parameters
    ----------
    x, f : ndarray
        Positions in m from the free end on, and forces in N.
    jump : bool
        Whether the force jumps at the point, as at the end of adhesion.
    """
    u, y = blocks(x), blocks(f)
    low, width = float(u.min()), float(np.ptp(u))
    height = float(np.ptp(y)) or 1.0
    u, y = (u - low) / width, (y - y[0]) / height
    starts = np.linspace(0.0, 1.0, 161)[1:-1]
    for _ in range(2):  # the second search is finer
        squares, total, count = _squares(u, y, starts, jump)
        least = np.min(squares, axis=0)
        rounding = count * _FLAT**2
        allowed = (least + rounding) <= (float(least.min()) + rounding) * (1.0 + 9.0 / count)
        inside = starts[allowed]
        step = float(starts[1] - starts[0])
        starts_before = starts
        starts = np.linspace(max(inside[0] - step, 1e-3), min(inside[-1] + step, 1.0 - 1e-3), 81)
    which, at = np.unravel_index(int(np.argmin(squares)), squares.shape)
    start, exponent = float(starts_before[at]), _EXPONENTS[int(which)]
    power = np.clip(u - start, 0.0, None) ** exponent
    columns = _columns(u, start, power, jump)
    solved = np.linalg.lstsq(columns, y, rcond=None)[0]
    rise, noise = float(np.max(solved[2] * power)), spread(y - columns @ solved)
    hidden = (1.0 - start) * min(0.5 * noise / rise, 1.0) ** (1.0 / exponent) if rise > 0.0 else 0.0
    return BrokenPower(
        start=low + width * start,
        low=low + width * (float(inside[0]) - step),
        high=low + width * (float(inside[-1]) + step),
        exponent=exponent,
        evidence=count * (total - float(squares.min())) / (float(squares.min()) + rounding),
        rise=height * rise,
        noise=height * noise,
        clear_from=low + width * (start + hidden),
    )


def _squares(u: FloatArray, y: FloatArray, starts: FloatArray, jump: bool) -> tuple[FloatArray, float, float]:
    """Sums of squares by exponent and start, that of the line alone, and the number of independent samples."""
    basis = np.linalg.qr(np.stack([np.ones_like(u), u], axis=1))[0]
    distance = np.clip(u[:, None] - starts, 0.0, None)
    enough = np.count_nonzero(distance, axis=0) >= 4
    left = np.broadcast_to((y - basis @ (basis.T @ y))[:, None], distance.shape)
    total = float(left[:, 0] @ left[:, 0])
    steps = _without(basis, (distance > 0.0).astype(float)) if jump else None
    if steps is not None:
        left = _off(left, steps)
    squares = np.full((len(_EXPONENTS), starts.size), total)
    for k, exponent in enumerate(_EXPONENTS):
        powers = _without(basis, distance**exponent)
        if steps is not None:
            powers = _off(powers, steps)
        along = np.einsum("ij,ij->j", left, powers)
        size = np.einsum("ij,ij->j", powers, powers)
        fits = enough & (along > 0.0) & (size > 1e-24)
        squares[k, fits] = np.einsum("ij,ij->j", left, left)[fits] - along[fits] ** 2 / size[fits]
    squares = np.maximum(squares, 0.0)
    which, at = np.unravel_index(int(np.argmin(squares)), squares.shape)
    columns = _columns(u, float(starts[at]), distance[:, at] ** _EXPONENTS[int(which)], jump)
    residual = y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]
    return squares, total, u.size / correlation_length(residual)


def _columns(u: FloatArray, start: float, power: FloatArray, jump: bool) -> FloatArray:
    step = [(u > start).astype(float)] if jump else []
    return np.stack([np.ones_like(u), u, power, *step], axis=1)


def _without(basis: FloatArray, columns: FloatArray) -> FloatArray:
    """Columns without their components along an orthonormal basis."""
    return np.asarray(columns - basis @ (basis.T @ columns))


def _off(columns: FloatArray, others: FloatArray) -> FloatArray:
    """Each column orthogonalised to the other one."""
    size = np.maximum(np.einsum("ij,ij->j", others, others), 1e-300)
    return np.asarray(columns - others * (np.einsum("ij,ij->j", columns, others) / size))
