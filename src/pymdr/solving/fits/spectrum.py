"""Spectrum of the noise of records: white noise plus one slow part, by restricted likelihood."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pymdr.solving.fits.bands import Bands, bands_of, restricted_likelihood, without_noise
from pymdr.units import FloatArray

_FEWEST = 8
"""Modes beyond the free numbers from which a spectrum is determined."""
_LOWEST, _HIGHEST, _STEPS, _LENGTHS = 0.1, 1e8, 19, 7
"""Range of the density of the slow part at frequency 0 relative to that of the white one, and sizes of the first grid."""
_INNER, _LIKELY = (13, 11), 9.0
"""Size of the second grid, and logarithm of the likelihood ratio of its ends."""
WHITE_PRIOR = 0.2
"""Probability of white noise without data: the 95 % bound by 14 baselines of eight measured files, of which none is white."""
_ADEQUATE = 0.05
"""Probability of white noise from which on the first grid is fine enough: the likelihood is broad there."""
_MOST_FRACTIONS = 400
_OUTSIDE, _STEPS_OF_QUANTILE, _CLOSE = 0.05, 100, 1e-9
"""Probability outside of an interval, largest number of steps to its end, and the last one, relative."""
NORMAL_95 = 1.959963984540054
"""Half width of a 95 % interval of a normal distribution in standard deviations."""


class NoiseSpectra(NamedTuple):
    """Spectra of the noise of records, averaged over what their residuals leave possible."""

    covariance: FloatArray
    """Of the coefficients of the tangents in N^2, shape (records, p, p)."""
    slow: FloatArray
    """Covariance of neighbours in N^2 that the slow part contributes."""
    length: FloatArray
    """Correlation length of the slow part in samples, the geometric mean."""
    white: FloatArray
    """Probability that there is no slow part."""
    squares: FloatArray
    """Squares of the residuals in all bands in N^2, shape (records, bands)."""
    density: FloatArray
    """Mean density in all bands in N^2, shape (records, bands)."""
    weights: FloatArray
    """Probability of each spectrum, shape (records, spectra)."""
    spectra: FloatArray
    """Densities of each spectrum in all bands in N^2, shape (records, spectra, bands); empty unless requested."""
    bands: Bands

    def growth(self, residuals: FloatArray, lengths: Sequence[int] = ()) -> FloatArray:
        """Increase of the squares of other residuals, over the density of the noise at each frequency; infinite without noise."""
        none = np.zeros((len(residuals), 0, residuals.shape[1]))
        grows = bands_of(residuals, none, lengths).squares - self.squares
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(np.nan_to_num((grows / self.density).sum(axis=1), nan=math.inf))

    def unmodelled(self) -> FloatArray:
        """Covariance of the coefficients if the density is that of the residuals in every band, which is small at low frequencies."""
        return _covariance(self.bands, self.squares / self.bands.modes)

    def quantile(self, directions: FloatArray) -> FloatArray:
        """
        Half widths of 95 % intervals in standard deviations, shape (records, numbers).

        Parameters
        ----------
        directions : ndarray, shape (records, numbers, p)
            Each number as a combination of the coefficients of the tangents.
        """
        products = np.einsum("mik,mbkl,mil->mbi", directions, self.bands.tangents, directions)
        variances, weights = self.spectra @ products, self.weights[:, :, None]
        mean = (weights * variances).sum(axis=1, keepdims=True)
        with np.errstate(invalid="ignore", divide="ignore"):  # a record without noise
            deviations = np.where(mean > 0.0, np.sqrt(variances / mean), 1.0)
        return np.asarray(_mixture_quantile(weights, deviations) * _student(self.bands)[:, None])


def noise_spectra(
    residuals: FloatArray,
    tangents: FloatArray,
    lengths: Sequence[int] = (),
    *,
    prior: float | None = WHITE_PRIOR,
    keep: bool = False,
) -> NoiseSpectra:
    """
    Covariance of least squares under noise with a spectrum that the residuals themselves determine.

    Parameters
    ----------
    residuals : ndarray, shape (records, samples)
        Residuals of least squares in N, in the order of measurement.
    tangents : ndarray, shape (records, p, samples)
        Orthonormal rates of the residuals over combinations of the free numbers; rows of zeros are left out.
    lengths : sequence of int, optional
        Numbers of samples of the curves that a record consists of; one curve by default.
    prior : float, optional
        Probability of white noise without data, `WHITE_PRIOR` or that of :func:`white_priors`. With None the records are of one instrument, and
        the others determine it.
    keep : bool
        Whether all spectra are returned, which :meth:`NoiseSpectra.quantile` needs.

    Returns
    -------
    NoiseSpectra

    Notes
    -----
    The density at frequency omega is s (1 + c (1 - phi)^2/((1 - phi)^2 + 4 phi sin(omega/2)^2)), of white noise and an
    autoregressive process of the correlation length -1/log(phi). The cosine transform makes the covariances of both diagonal
    (Rao and Yip 1990; the process is reflected at its ends), so that the restricted likelihood (Patterson and Thompson 1971;
    Harville 1974) is a sum over frequencies. It is taken over the 100 lowest ones, and the density of the others is that of the
    residuals. The covariance is averaged over s, c and phi with a uniform prior of s, c and the length on logarithmic scales, and
    `prior` for white noise.

    Examples
    --------
    >>> import numpy as np
    >>> rng = np.random.default_rng(1)
    >>> wave = np.sqrt(0.002) * np.cos(0.008 * np.pi * (np.arange(1000) + 0.5))
    >>> white = rng.normal(size=1000)
    >>> slow = np.repeat(rng.normal(size=50), 20)
    >>> left = np.array([noise - wave * (wave @ noise) for noise in (white, white + slow)])
    >>> spectra = noise_spectra(left, np.tile(wave, (2, 1, 1)))
    >>> spectra.covariance[:, 0, 0].round().tolist()  # of one record each; the noise has 1 and 21
    [1.0, 36.0]
    """
    bands = bands_of(residuals, tangents, lengths)
    return _averaged(bands, 0.5 if prior is None else prior, keep, pooled=prior is None)


def white_priors(white: FloatArray, expected: float = WHITE_PRIOR) -> FloatArray:
    """
    Prior probabilities of white noise of the records of one instrument, each from all others.

    Parameters
    ----------
    white : ndarray, shape (records,)
        Probabilities by :func:`noise_spectra` with the prior 1/2.
    expected : float
        Expected fraction of records with white noise without data, that of a single record. The fraction has the beta distribution of
        1 and 1/expected - 1, which is uniform for 1/2.

    Returns
    -------
    ndarray, shape (records,)
        The expected fraction.

    Examples
    --------
    >>> import numpy as np
    >>> white_priors(np.array([0.8])).round(3).tolist()
    [0.2]
    >>> white_priors(np.full(16, 0.8)).round(2).tolist()[0]
    0.73
    """
    if white.size == 1:
        return np.full(1, expected)
    nodes, nodal_weights = np.polynomial.legendre.leggauss(min(white.size // 2 + 5, _MOST_FRACTIONS))
    fraction = 0.5 * (1.0 + nodes)
    own = np.log(np.outer(white, fraction) + np.outer(1.0 - white, 1.0 - fraction))
    # products of the records are polynomials of the fraction, whose integrals the rule gives to rounding
    others = own.sum(axis=0) - own + (1.0 / expected - 2.0) * np.log1p(-fraction) + np.log(nodal_weights)
    weights = np.exp(others - others.max(axis=1, keepdims=True))
    return np.asarray(weights @ fraction / weights.sum(axis=1))


class _Grid(NamedTuple):
    """Spectra at the middles of equal cells in the logarithms of the slow density and of its length, for records."""

    slow: FloatArray
    """Logarithm of the density at frequency 0 relative to the white one, shape (records or 1, spectra)."""
    length: FloatArray
    """Logarithm of the correlation length in samples."""
    cell: FloatArray
    """Sides of the cells, shape (2, records or 1, 1)."""


def _ends(samples: float, modes: float) -> FloatArray:
    """Ends of the logarithms of the slow density and of its length; shorter lengths are white noise in the modes."""
    shortest = max(1.0, samples / (4.0 * modes))
    return np.asarray(np.log(np.array([[_LOWEST, _HIGHEST], [shortest, samples]])))


def _grid(low: FloatArray, high: FloatArray, sizes: tuple[int, int]) -> _Grid:
    """Cells between ends, shape (2, records)."""
    cell = (high - low) / np.array(sizes)[:, None]
    middles = [(np.arange(size) + 0.5) * cell[i][:, None] + low[i][:, None] for i, size in enumerate(sizes)]
    return _Grid(
        np.repeat(middles[0], sizes[1], axis=1), np.tile(middles[1], (1, sizes[0])), cell[:, :, None]
    )


def _finer(grid: _Grid, logarithm: FloatArray, ends: FloatArray) -> _Grid:
    """The cells about the likely spectra of each record."""
    likely = logarithm > logarithm.max(axis=1, keepdims=True) - _LIKELY
    low, high = [], []
    for place, cell, (first, last) in zip((grid.slow, grid.length), grid.cell, ends, strict=True):
        low.append(np.maximum(np.where(likely, place - cell, math.inf).min(axis=1), first))
        high.append(np.minimum(np.where(likely, place + cell, -math.inf).max(axis=1), last))
    return _grid(np.array(low), np.array(high), _INNER)


class _Mean(NamedTuple):
    """Averages over the spectra of a grid and white noise, as in :class:`NoiseSpectra`, in the low bands."""

    density: FloatArray
    slow: FloatArray
    length: FloatArray
    white: FloatArray
    level: FloatArray
    """Density of white noise alone in N^2, shape (records, 1)."""
    weights: FloatArray
    spectra: FloatArray
    logarithm: FloatArray


def _mean(bands: Bands, grid: _Grid, ends: FloatArray, prior: float, keep: bool) -> _Mean:
    """Averages over a grid."""
    none = np.zeros((len(bands.squares), 1))
    alone, level, _ = restricted_likelihood(bands, none, none + 1.0)
    slow, length = np.exp(grid.slow), np.exp(grid.length)
    logarithm, white, density = restricted_likelihood(bands, slow, length)
    part = grid.cell.prod(axis=0) / np.ptp(ends, axis=1).prod() * (1.0 - prior)
    top = np.maximum(logarithm.max(axis=1, keepdims=True), alone)
    weights = np.concatenate([prior * np.exp(alone - top), part * np.exp(logarithm - top)], axis=1)
    weights /= weights.sum(axis=1, keepdims=True)
    own = weights[:, 1:]
    mean = (own * white)[:, None, :] @ density
    phi = np.exp(-1.0 / length)
    neighbours = own * white * slow * phi * (1.0 - phi) / (1.0 + phi)
    spectra = np.zeros((0, 0, 0))
    if keep:
        flat = np.broadcast_to(level[:, :, None], (*level.shape, bands.low))
        spectra = np.concatenate([flat, white[:, :, None] * density], axis=1)
    return _Mean(
        mean[:, 0] + weights[:, :1] * level,
        neighbours.sum(axis=1),
        np.exp((own * grid.length).sum(axis=1) / np.maximum(own.sum(axis=1), 1e-300)),
        weights[:, 0],
        level,
        weights if keep else np.zeros((0, 0)),
        spectra,
        logarithm,
    )


def _with_priors(mean: _Mean, priors: FloatArray) -> _Mean:
    """Averages with other prior probabilities of white noise than 1/2."""
    white = priors * mean.white / (priors * mean.white + (1.0 - priors) * (1.0 - mean.white))
    part = np.where(mean.white < 1.0, (1.0 - white) / np.maximum(1.0 - mean.white, 1e-300), 0.0)
    own = mean.density - mean.white[:, None] * mean.level
    weights = (
        np.column_stack([white, part[:, None] * mean.weights[:, 1:]]) if mean.weights.size else mean.weights
    )
    return mean._replace(
        density=white[:, None] * mean.level + part[:, None] * own,
        slow=part * mean.slow,
        white=white,
        weights=weights,
    )


def _averaged(bands: Bands, prior: float, keep: bool, pooled: bool) -> NoiseSpectra:
    """The average over spectra of some records."""
    low, samples = bands.low, float(bands.modes.sum())
    modes = float(bands.modes[:low].sum())
    scale = samples / np.maximum(samples - bands.rank, 1.0)
    rest = bands.squares[:, low:] / bands.modes[low:] * scale[:, None]
    if modes - bands.rank.max() < _FEWEST:
        return _white(bands, keep)
    ends = _ends(samples, modes)
    coarse = _grid(ends[:, :1], ends[:, 1:], (_STEPS, _LENGTHS))
    smooth = without_noise(bands)
    mean = _mean(smooth, coarse, ends, prior, keep)
    narrow = np.flatnonzero(mean.white < _ADEQUATE)
    if narrow.size:
        some = smooth._replace(
            **{name: getattr(smooth, name)[narrow] for name in ("tangents", "mixed", "squares", "rank")}
        )
        fine = _mean(some, _finer(coarse, mean.logarithm[narrow], ends), ends, prior, keep)
        if narrow.size == len(bands.squares):
            mean = fine
        else:
            if keep:  # the first grid has fewer spectra
                more = (0, fine.weights.shape[1] - mean.weights.shape[1])
                weights = np.pad(mean.weights, ((0, 0), more))
                spectra = np.pad(mean.spectra, ((0, 0), more, (0, 0)), mode="edge")
                mean = mean._replace(weights=weights, spectra=spectra)
            for column, other in zip(mean[:7], fine[:7], strict=True):
                if other.size:
                    column[narrow] = other
    if pooled:
        mean = _with_priors(mean, white_priors(mean.white))
    density = np.concatenate([mean.density, rest], axis=1)
    spectra = mean.spectra
    if keep:
        high = np.broadcast_to(rest[:, None, :], (*spectra.shape[:2], rest.shape[1]))
        spectra = np.concatenate([spectra, high], axis=2)
    return NoiseSpectra(
        _covariance(bands, density),
        mean.slow,
        mean.length,
        mean.white,
        bands.squares,
        density,
        mean.weights,
        spectra,
        bands,
    )


def _white(bands: Bands, keep: bool) -> NoiseSpectra:
    """White noise, of records that are too short for a spectrum."""
    freedom = np.maximum(bands.modes.sum() - bands.rank, 1.0)
    density = np.broadcast_to((bands.squares.sum(axis=1) / freedom)[:, None], bands.squares.shape)
    none = np.zeros(len(density))
    return NoiseSpectra(
        _covariance(bands, density),
        none,
        none,
        none + 1.0,
        bands.squares,
        density,
        np.ones((len(density), 1)),
        density[:, None, :] if keep else np.zeros((0, 0, 0)),
        bands,
    )


def _covariance(bands: Bands, density: FloatArray) -> FloatArray:
    """Covariance of the coefficients of orthonormal tangents."""
    return np.asarray(np.einsum("mb,mbij->mij", density, bands.tangents))


def _student(bands: Bands) -> FloatArray:
    """Ratios of the 95 % quantiles of Student's and the normal distribution."""
    from scipy.special import stdtrit

    freedom = bands.modes[: bands.low].sum() - bands.rank
    return np.asarray(stdtrit(np.maximum(freedom, 1.0), 0.975) / NORMAL_95)


def _mixture_quantile(weights: FloatArray, deviations: FloatArray) -> FloatArray:
    """Half widths of 95 % intervals of mixtures of normal distributions, shape (records, spectra, numbers), by Newton's method from 0."""
    from scipy.special import ndtr

    half = np.zeros((len(deviations), 1, deviations.shape[2]))
    for _ in range(_STEPS_OF_QUANTILE):
        place = half / deviations
        outside = (2.0 * weights * ndtr(-place)).sum(axis=1, keepdims=True)
        density = (weights * np.exp(-0.5 * place**2) / deviations).sum(axis=1, keepdims=True)
        # what is outside falls with a decreasing slope, so that no step is too long
        step = (outside - _OUTSIDE) / (math.sqrt(2.0 / math.pi) * density)
        half = half + step
        if np.all(np.abs(step) <= _CLOSE * half):
            break
    return np.asarray(half[:, 0])
