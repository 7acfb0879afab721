"""The power spectrum of a measured patch, and the self-affine law that it follows on a range."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pymdr.errors import ProblemError
from pymdr.numerics.roots import boundary
from pymdr.units import FloatArray, metres

BINS_PER_DECADE = 8
WITHIN = 0.25
"""Accepted deviation of a bin from the law, in addition to its scatter."""
FEWEST_BINS = 5
_DISBELIEF = 6.63
"""Gain of a significant roll-off: twice the logarithm of a likelihood ratio that chance exceeds in 1 % of cases."""
_SCATTERS = 2.58
_ALIKE = (1.0, 4.0 / 9.0, 1.0 / 36.0)
"""Squares of the correlation of waves that are 0, 1 or 2 steps apart under a Hann window: of the transform of its square."""
_SEPARATION = 4
_LOBE = 1.0 / 3.0
"""Variance of a wave number of a Hann window, in squares of 2 pi over the side."""
_FIRST_OF_WINDOW, _FIRST_OF_PERIOD = 2.5, 0.5
"""Wave numbers in 2 pi over the shorter side from which on rings are kept."""
_SECTORS = 6
_ROUNDING = 1.0 + 1e-9
_NOTHING = 4.0
"""Spurious amplitude of a wave by each height, in roundings of the largest height."""
_TRIES = 160


class Rings(NamedTuple):
    """Means of the spectrum over rings as wide as the coarser step of wave numbers."""

    log_q: FloatArray
    """Means of ln q, q in 1/m."""
    spectrum: FloatArray
    """C2D in m^4."""
    waves: FloatArray
    """Number of independent waves in a ring."""
    alike: FloatArray
    """Correlations of the means of rings, (rings, rings)."""
    smear: FloatArray
    """Smearing of the mean: C2D ~ q^-a is overestimated by the factor 1 + a^2 smear."""
    sectors: FloatArray
    """C2D in m^4 by direction, (rings, sectors of the half plane); nan where there are no waves."""


class Bins(NamedTuple):
    """Evenly in the logarithm of q; means of logarithms."""

    log_q: FloatArray
    log_c: FloatArray
    variance: FloatArray
    """Variance of log_c by chance."""
    waves: FloatArray
    """Number of independent waves in a bin."""
    low: FloatArray
    """ln q of the first ring of a bin."""
    high: FloatArray
    """ln q of the last ring of a bin."""


class Law(NamedTuple):
    """ln C2D = level - steepness max(0, ln q - corner), on bins from first to last."""

    level: float
    steepness: float
    corner: float
    """ln of the roll-off; that of the first bin where there is none."""
    rolled: bool
    covariance: FloatArray
    """Covariance of level, steepness and corner; 0 for the corner without one."""
    first: int
    last: int
    excess: float
    """Standard deviation of ln C2D about the law beyond chance."""

    def log_c(self, log_q: FloatArray) -> FloatArray:
        """Ln C2D."""
        x = log_q - self.corner
        return np.asarray(self.level - self.steepness * (np.maximum(x, 0.0) if self.rolled else x))


def rings_of(heights: FloatArray, size: FloatArray, periodic: bool) -> Rings:
    """
    The radially averaged spectrum C2D, with h^2 = 2 pi int C2D q dq, of a patch.

    Parameters
    ----------
    heights : ndarray, shape (nx, ny)
        In m.
    size : ndarray, shape (2,)
        In m.
    periodic : bool
        Whether the patch is a period of the surface. If not, heights are weighted by a Hann window in both directions, whose mean
        square is divided out, after their weighted mean is taken off.

    Returns
    -------
    Rings
        Up to the wave number 2 pi over two pixels. C2D = |z(q)|^2/(4 pi^2 A), z(q) the Fourier integral of the heights over the area A.

    Notes
    -----
    Jacobs, Junge and Pastewka (2017), Surf. Topogr.: Metrol. Prop. 5, 013001; Harris (1978), Proc. IEEE 66, 51, for windows.
    """
    shape = heights.shape
    step = 2.0 * math.pi / size
    if periodic:
        weighted = heights - heights.mean()
    else:
        along = [np.sin(math.pi * (np.arange(n) + 0.5) / n) ** 2 for n in shape]
        middle = float(along[0] @ heights @ along[1]) / float(along[0].sum() * along[1].sum())
        weighted = (heights - middle) * (along[0][:, None] * along[1])
        weighted /= math.sqrt(float(np.mean(along[0] ** 2) * np.mean(along[1] ** 2)))
    waves = np.fft.rfft2(weighted)
    rounding = _NOTHING * np.finfo(float).eps * float(np.max(np.abs(heights)))
    waves[np.abs(waves) <= rounding * heights.size] = 0.0
    power = (waves.real**2 + waves.imag**2) * (float(np.prod(size)) / (2.0 * math.pi * heights.size) ** 2)
    qx = step[0] * np.fft.fftfreq(shape[0], 1.0 / shape[0])
    qy = step[1] * np.arange(shape[1] // 2 + 1)
    q = np.hypot(qx[:, None], qy)
    # columns of which the other half plane has none stand for one wave, the others for two
    twice = np.full(q.shape, 2.0)
    twice[:, 0] = 1.0
    if shape[1] % 2 == 0:
        twice[:, -1] = 1.0
    wide = float(step.max())
    ring = np.rint(q / wide).astype(int)
    last = math.floor(math.pi * float(np.min(shape / size)) / wide)
    kept = (ring >= 1) & (ring <= last)
    ring, twice, power, log_q = ring[kept] - 1, twice[kept], power[kept], np.log(q[kept])

    def mean(values: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(ring, twice * values, minlength=last) / count)

    count = np.bincount(ring, twice, minlength=last)
    middle_q = mean(log_q)
    smear = 0.5 * np.maximum(mean(log_q**2) - middle_q**2, 0.0)
    if not periodic:
        smear = smear + 0.25 * _LOBE * float(np.sum(step**2)) * np.exp(-2.0 * middle_q)
    angle = np.arctan2(qy, qx[:, None])[kept] % math.pi
    sector = ring * _SECTORS + np.minimum((angle / math.pi * _SECTORS).astype(int), _SECTORS - 1)
    number = np.bincount(sector, twice, minlength=last * _SECTORS)
    with np.errstate(invalid="ignore", divide="ignore"):
        sectors = np.bincount(sector, twice * power, minlength=last * _SECTORS) / number
    scatter = _scatter(step, shape, wide, last, periodic)
    deviation = np.sqrt(np.diag(scatter))
    return Rings(
        log_q=middle_q,
        spectrum=mean(power),
        waves=1.0 / deviation**2,
        alike=scatter / np.outer(deviation, deviation),
        smear=np.asarray(smear),
        sectors=sectors.reshape(last, _SECTORS),
    )


def _scatter(step: FloatArray, shape: tuple[int, ...], wide: float, last: int, periodic: bool) -> FloatArray:
    """Covariances of the means of rings over their squares, of Gaussian heights: sums over pairs of waves that a window makes alike."""
    q = [step[k] * np.fft.fftfreq(n, 1.0 / n) for k, n in enumerate(shape)]
    ring = np.rint(np.hypot(q[0][:, None], q[1]) / wide).astype(np.int32)
    ring[ring > last] = 0
    count = np.bincount(ring.ravel(), minlength=last + 1)[1:].astype(float)
    # rings of waves two steps apart are at most four apart
    pairs = np.zeros((last + 1, 2 * _SEPARATION + 1))
    for i in range(-2, 3) if not periodic else (0,):
        for j in range(-2, 3) if not periodic else (0,):
            other = np.roll(ring, (i, j), axis=(0, 1))
            off = other - ring
            near = (ring > 0) & (other > 0) & (np.abs(off) <= _SEPARATION)
            sums = np.bincount(
                ring[near] * (2 * _SEPARATION + 1) + off[near] + _SEPARATION, minlength=pairs.size
            )
            pairs += _ALIKE[abs(i)] * _ALIKE[abs(j)] * sums.reshape(pairs.shape)
    whole = np.zeros((last, last))
    for off in range(-_SEPARATION, _SEPARATION + 1):
        rows = np.arange(max(0, -off), min(last, last - off))
        whole[rows, rows + off] = pairs[rows + 1, off + _SEPARATION]
    # waves of opposite q are the same
    return np.asarray(2.0 * whole / np.outer(count, count))


def binned(rings: Rings, periodic: bool, highest: float, steepness: float) -> Bins:
    """
    Rings in bins that are even in ln q, none of them on both sides of the highest wave number that is resolved.

    Parameters
    ----------
    periodic : bool
        If not, rings within the lobe of the window are left out.
    highest : float
        In 1/m.
    steepness : float
        a of C2D ~ q^-a, by which the smear of rings is taken out.

    Returns
    -------
    Bins
        Means of ln C2D and ln q with like weights, so that a power law keeps its exponent. The logarithm of a mean of n waves, whose
        squares are exponentially distributed, is psi(n) - ln n on the average, with the variance psi'(n).

    Raises
    ------
    ProblemError
        If there is no wave in any of the rings.
    """
    from scipy.special import polygamma, psi

    q = np.exp(rings.log_q)
    first = (_FIRST_OF_PERIOD if periodic else _FIRST_OF_WINDOW) * q[0]
    used = (q >= first) & (rings.spectrum > 0.0)
    if not used.any():
        shortest, longest = (metres(2.0 * math.pi / float(end)) for end in (q[-1], max(first, q[0])))
        raise ProblemError(
            f"the heights contain no waves from {shortest} to {longest}; measure a larger patch, or with smaller pixels"
            + ("" if periodic else ", or pass periodic=True if the patch is one period")
        )
    log_q, n = rings.log_q[used], rings.waves[used]
    log_c = np.log(rings.spectrum[used]) - (psi(n) - np.log(n)) - np.log1p(steepness**2 * rings.smear[used])
    variance = polygamma(1, n)
    even = np.floor((log_q - log_q[:1]) * (BINS_PER_DECADE / math.log(10.0)) + 1e-9).astype(int)
    beyond = np.exp(log_q) > highest * _ROUNDING
    starts, number = np.unique(even + 2 * even[-1:] * beyond, return_index=True, return_inverse=True)[1:]
    fraction = np.zeros((starts.size, log_q.size))
    fraction[number, np.arange(log_q.size)] = 1.0 / variance
    fraction /= fraction.sum(axis=1, keepdims=True)
    spread = fraction * np.sqrt(variance)
    chance = np.einsum("ij,jk,ik->i", spread, rings.alike[np.ix_(used, used)], spread, optimize=True)
    ends = np.append(starts[1:], log_q.size) - 1
    # psi'(n) = 1/n + 1/(2 n^2) + ...
    return Bins(fraction @ log_q, fraction @ log_c, chance, 1.0 / chance + 0.5, log_q[starts], log_q[ends])


def self_affine(rings: Rings, periodic: bool, highest: float) -> tuple[Bins, Law | None]:
    """
    Bins, and the law ln C2D = level - a max(0, ln q/q_r) on the widest range with deviations of at most a quarter.

    Parameters
    ----------
    highest : float
        Wave number in 1/m up to which the surface is resolved.

    Returns
    -------
    bins : Bins
    law : Law or None
        None if no range of five bins holds a law.
    """
    steepness, law = 3.0, None
    for _ in range(4):
        bins = binned(rings, periodic, highest, steepness)
        law = _widest(bins, math.log(highest * _ROUNDING))
        if law is None:
            break
        steepness = law.steepness
    return bins, law


def _widest(bins: Bins, highest: float) -> Law | None:
    """The law on the widest range of bins on which it holds; None without one."""
    count = int(np.count_nonzero(bins.high <= highest))
    off = math.log1p(WITHIN)
    for width in range(count, FEWEST_BINS - 1, -1):
        candidates: list[tuple[float, Law]] = []
        for first in range(count - width + 1):
            law = _fitted(bins, first, first + width - 1, 0.5 * off)
            x, y, variance = (part[first : first + width] for part in bins[:3])
            miss = np.abs(y - law.log_c(x))
            if np.all(miss <= off + _SCATTERS * np.sqrt(variance)):
                candidates.append((float(np.sum(miss**2 / variance)), law))
        if candidates:
            law = _weighed(bins, min(candidates, key=lambda one: one[0])[1])
            if law.excess <= 2.0 * WITHIN:
                return law
    return None


def _weighed(bins: Bins, law: Law) -> Law:
    """The law with the excess scatter of which chi-square is what is left over (Paule and Mandel, 1982, J. Res. NBS 87, 377)."""
    first, last = law.first, law.last
    x, y, variance = (part[first : last + 1] for part in bins[:3])

    def over(excess: float) -> tuple[float, Law]:
        one = _fitted(bins, first, last, excess)
        left = x.size - (3 if one.rolled else 2)
        return float(np.sum((y - one.log_c(x)) ** 2 / (variance + excess**2))) - left, one

    missed, law = over(0.0)
    if missed <= 0.0:
        return law
    excess = boundary(lambda each: np.array(over(float(each))[0] > 0.0), 0.0, 1.0, within=1e-9)[1]
    return over(float(excess))[1]


def _fitted(bins: Bins, first: int, last: int, excess: float) -> Law:
    """By least squares, with a roll-off within the range where it can be distinguished from none."""
    x, y, chance = (part[first : last + 1] for part in bins[:3])
    weight = 1.0 / (chance + excess**2)
    straight = _line(x - x[0], y, weight)
    level, steepness, chi = (float(part[0]) for part in straight)
    rolled, corner = False, float(x[0])
    if x.size >= FEWEST_BINS + 1:
        corners = np.linspace(x[1], x[-3], _TRIES)
        levels, slopes, chis = _line(np.maximum(x - corners[:, None], 0.0), y, weight)
        best = int(np.argmin(chis))
        if chi - chis[best] > _DISBELIEF * max(1.0, chis[best] / (x.size - 3)) and slopes[best] > 0.0:
            rolled, corner = True, float(corners[best])
            level, steepness = float(levels[best]), float(slopes[best])
    inside = x > corner if rolled else x >= corner
    columns = [np.ones(x.size), np.where(inside, corner - x, 0.0)]
    if rolled:
        columns.append(np.where(inside, steepness, 0.0))
    matrix = np.array(columns)
    covariance = np.zeros((3, 3))
    size = len(columns)
    covariance[:size, :size] = np.linalg.inv(matrix * weight @ matrix.T)
    return Law(level, steepness, corner, rolled, covariance, first, last, excess)


def _line(x: FloatArray, y: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Level, fall and chi-square of straight lines y = level - fall x, one for every row of x."""
    x = np.atleast_2d(x)
    mean_x = (x @ weight / weight.sum())[:, None]
    mean_y = float(y @ weight / weight.sum())
    fall = -((x - mean_x) * (y - mean_y)) @ weight / ((x - mean_x) ** 2 @ weight)
    level = mean_y + fall * mean_x[:, 0]
    chi = (y - level[:, None] + fall[:, None] * x) ** 2 @ weight
    return level, fall, chi


def anisotropy(rings: Rings, low: float, high: float) -> float:
    """
    The largest over the smallest mean of the spectrum by direction, in six sectors of the half plane.

    Parameters
    ----------
    low, high : float
        Wave numbers in 1/m between which it is taken, relative to the mean of each ring.
    """
    inside = (rings.log_q >= math.log(low)) & (rings.log_q <= math.log(high))
    inside &= np.all(np.isfinite(rings.sectors), axis=1) & (rings.spectrum > 0.0)
    if not inside.any():
        return 1.0
    fraction = rings.sectors[inside] / rings.spectrum[inside, None]
    mean = np.average(fraction, axis=0, weights=rings.waves[inside])
    return float(mean.max() / mean.min()) if mean.min() > 0.0 else math.inf
