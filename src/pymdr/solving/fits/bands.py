"""Sums over bands of frequencies of the residuals and tangents of records, and their restricted likelihood."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.fft import dct

from pymdr.numerics.panels import IndexArray
from pymdr.units import FloatArray

_MODES, _SINGLE, _RATIO = 100, 12, 1.2
"""Modes from which the spectrum is determined: forces that vary smoothly along a record lie in them. The first ones count singly,
others in bands of this ratio of frequencies."""
_IN_CACHE = 2**16
"""Number of values that are transformed together: more do not stay in the cache."""
_INDISTINCT = 1e-12
"""Eigenvalue of the Gram matrix of normalised tangents, relative to the largest, below which a direction is left out."""
_EXPLAINED, _FLAT, _ABOVE_FLOOR = 0.7, 0.5, 4.0
"""Part of the residuals in the upper half of the modes, and energy in the highest ones relative to it, from which on tangents are
noise; they are kept where their energy is that large relative to that of the noise."""


class Bands(NamedTuple):
    """Sums over bands of frequencies of the products of the transforms of tangents and residuals."""

    modes: FloatArray
    """Number of modes of each band."""
    frequency: FloatArray
    """Mean of 4 sin(omega/2)^2 of each band."""
    tangents: FloatArray
    """Products of the tangents, shape (records, bands, p, p)."""
    mixed: FloatArray
    """Products of the tangents with the residuals, shape (records, bands, p)."""
    squares: FloatArray
    """Squares of the residuals in N^2, shape (records, bands)."""
    low: int
    """Number of bands from which the spectrum is determined."""
    rank: FloatArray
    """Number of the tangents that are not 0, shape (records,)."""


def orthonormal(tangents: FloatArray) -> tuple[FloatArray, FloatArray]:
    """
    Orthonormal combinations of the tangents of records, and their coefficients.

    Parameters
    ----------
    tangents : ndarray, shape (records, p, samples)

    Returns
    -------
    basis : ndarray, shape (records, p, samples)
        Rows of zeros for combinations that the others contain.
    coefficients : ndarray, shape (records, p, p)
        C with basis = C' tangents; the covariance of the free numbers is C H C' with that of the basis, H.
    """
    gram = tangents @ np.swapaxes(tangents, 1, 2)
    norm = np.sqrt(np.einsum("mpp->mp", gram))
    size = np.where(norm > 0.0, norm, 1.0)
    gram = gram / (size[:, :, None] * size[:, None, :])
    values, vectors = np.linalg.eigh(gram)
    distinct = values > _INDISTINCT * values[:, -1:]
    root = np.where(distinct, 1.0 / np.sqrt(np.where(distinct, values, 1.0)), 0.0)
    coefficients = vectors * root[:, None, :] / size[:, :, None]
    return np.swapaxes(coefficients, 1, 2) @ tangents, coefficients


def bands_of(
    residuals: FloatArray,
    tangents: FloatArray,
    lengths: Sequence[int] = (),
    modes: int = _MODES,
    ratio: float = _RATIO,
) -> Bands:
    """Sums of products in bands of frequencies; see :func:`noise_spectra`."""
    records, samples, p = *residuals.shape, tangents.shape[1]
    parts = list(lengths) if len(lengths) > 1 else [samples]
    omega = np.concatenate([math.pi * np.arange(part) / part for part in parts])
    order = np.argsort(omega, kind="stable") if len(parts) > 1 else slice(None)
    low = min(modes, samples)
    edges = _edges(low, samples, ratio)
    counts = np.diff(np.append(edges, samples)).astype(float)
    products = np.empty((records, edges.size, p + 1, p + 1))
    together = max(_IN_CACHE // (samples * (p + 1)), 1)
    for first in range(0, records, together):
        rows = slice(first, first + together)
        columns = np.concatenate([tangents[rows], residuals[rows, None]], axis=1)
        segments = np.split(columns, np.cumsum(parts)[:-1], axis=2)
        columns = np.concatenate([dct(segment, axis=2, norm="ortho") for segment in segments], axis=2)
        columns = columns[:, :, order]
        for i in range(p + 1):
            sums = np.add.reduceat(columns[:, i:] * columns[:, i : i + 1], edges, axis=2)
            products[rows, :, i:, i] = products[rows, :, i, i:] = np.swapaxes(sums, 1, 2)
    return Bands(
        counts,
        np.add.reduceat(4.0 * np.sin(0.5 * omega[order]) ** 2, edges) / counts,
        products[:, :, :p, :p].copy(),
        products[:, :, :p, p].copy(),
        products[:, :, p, p].copy(),
        int(np.searchsorted(edges, low)),
        np.einsum("mbii->m", products[:, :, :p, :p]),
    )


def restricted_likelihood(
    bands: Bands, slow: FloatArray, length: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Restricted likelihood of spectra, with the best density of the white part.

    Parameters
    ----------
    bands : Bands
    slow : ndarray, shape (records, spectra)
        Density of the slow part at frequency 0, relative to that of the white one.
    length : ndarray, shape (records, spectra)
        Its correlation length in samples.

    Returns
    -------
    logarithm : ndarray, shape (records, spectra)
        Of the likelihood, up to a constant.
    white : ndarray, shape (records, spectra)
        Density of the white part in N^2.
    density : ndarray, shape (records, spectra, bands)
        Of both parts, relative to that of the white one, in the bands that determine it.
    """
    low, phi = bands.low, np.exp(-1.0 / length)
    corner = ((1.0 - phi) ** 2)[..., None]
    density = 1.0 + slow[..., None] * corner / (corner + phi[..., None] * bands.frequency[:low])
    inverse, p, count = 1.0 / density, bands.mixed.shape[2], len(bands.squares)
    rows, columns = np.tril_indices(p)
    sums = np.concatenate(
        [bands.tangents[:, :low, rows, columns], bands.mixed[:, :low], bands.squares[:, :low, None]], axis=2
    )
    sums = np.moveaxis(inverse @ sums, 2, 0)
    squares = {(i, j): sums[k] for k, (i, j) in enumerate(zip(rows.tolist(), columns.tolist(), strict=True))}
    logarithm, explained = _factored(squares, list(sums[rows.size : rows.size + p]))
    left = np.maximum(sums[-1] - explained, 1e-300)
    modes = bands.modes[:low]
    freedom = (modes.sum() - bands.rank).reshape(count, 1)
    logarithm = -0.5 * (np.log(density) @ modes + logarithm + freedom * np.log(left))
    return np.asarray(logarithm), left / freedom, density


def _factored(
    square: dict[tuple[int, int], FloatArray], side: list[FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Logarithms of the determinants of many small matrices G, and h'G^-1 h, by Cholesky; rows of zeros add a constant."""
    lower: dict[tuple[int, int], FloatArray] = {}
    turned: list[FloatArray] = []
    logarithm, explained = np.zeros_like(side[0]), np.zeros_like(side[0])
    for i, value in enumerate(side):
        for j in range(i + 1):
            rest = square[i, j]
            for k in range(j):
                rest = rest - lower[i, k] * lower[j, k]
            if j < i:
                lower[i, j] = rest / lower[j, j]
            else:
                lower[i, i] = np.where(rest > 0.0, np.sqrt(np.maximum(rest, 0.0)), 1.0)
        for k in range(i):
            value = value - lower[i, k] * turned[k]
        turned.append(value / lower[i, i])
        logarithm += 2.0 * np.log(lower[i, i])
        explained += turned[i] ** 2
    return logarithm, explained


def _edges(low: int, samples: int, ratio: float) -> IndexArray:
    """First modes of bands; one begins at `low` if there are more samples."""
    edges = [0]
    while True:
        k = edges[-1]
        step = max(int(k * (ratio - 1.0)), 1) if k >= _SINGLE else 1
        following = low if k < low < k + step + step // 2 else k + step
        if following >= samples:
            return np.array(edges)
        edges.append(following)


def without_noise(bands: Bands) -> Bands:
    """
    The sums of products without tangents where these are noise themselves.

    If the depths of a record contain its noise, so do the tangents, which then explain the residuals at high frequencies, and
    every spectrum that is small there seems likely.
    """
    half = np.cumsum(bands.modes) > 0.5 * bands.modes[: bands.low].sum()
    half[bands.low :] = False
    gram, side = bands.tangents[:, half].sum(axis=1), bands.mixed[:, half].sum(axis=1)
    energy = np.einsum("mbii->mbi", bands.tangents)
    size = np.sqrt(np.einsum("mii->mi", gram))
    size[size == 0.0] = 1.0
    inverse = np.linalg.pinv(gram / (size[:, :, None] * size[:, None, :]), hermitian=True)
    explained = np.einsum("mi,mij,mj->m", side / size, inverse, side / size)
    floor = energy[:, half].sum(axis=1) / bands.modes[half].sum()
    top = np.cumsum(bands.modes) > 0.5 * bands.modes.sum()
    level = energy[:, top].sum(axis=1) / bands.modes[top].sum()
    noisy = explained > _EXPLAINED * bands.squares[:, half].sum(axis=1)
    noisy &= level.sum(axis=1) > _FLAT * floor.sum(axis=1)
    if not noisy.any():
        return bands
    keep = (energy > _ABOVE_FLOOR * bands.modes[:, None] * floor[:, None, :]) | ~noisy[:, None, None]
    return bands._replace(
        tangents=bands.tangents * (keep[:, :, :, None] & keep[:, :, None, :]), mixed=bands.mixed * keep
    )
