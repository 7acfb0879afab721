"""A randomly rough surface in two dimensions: heights on pixels, of the spectrum that its line has too."""

from __future__ import annotations

import math

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.rough import RoughSurface
from pymdr.problem.topography import Topography
from pymdr.units import FloatArray, shown

PIXELS_PER_WAVE, FEWEST_PER_WAVE = 8, 4
_SECOND = 2
"""Of the generator: its phases are not those of the line."""


def rough_topography(surface: RoughSurface, realisation: int = 0, *, points: int | None = None) -> Topography:
    """
    A patch of a rough surface, of the spectrum C2D with random phases.

    Parameters
    ----------
    surface : RoughSurface
    realisation : int, optional
        Which one: its phases are those of the generator of (seed, realisation).
    points : int, optional
        Pixels along the longer side, at least 4 for the shortest wave; 8 unless given. The waves do not depend on it.

    Returns
    -------
    Topography
        Heights in m about their mean, one period of either side, of the rms height to rounding.

    Raises
    ------
    ProblemError
        If there are fewer pixels than 4 for the shortest wave, or a number is not whole.

    Notes
    -----
    Persson, Albohr, Tartaglino, Volokitin and Tosatti (2005), J. Phys.: Condens. Matter 17, R1. Pressures of contacts change
    over the shortest wave, which 4 pixels do not resolve: :func:`pymdr.press` tells how much the grid matters.

    Examples
    --------
    >>> patch = rough_topography(RoughSurface(0.8, "1 um", "1 mm", "100 um"), points=64)
    >>> patch.heights.shape, round(float(patch.heights.std()) * 1e6, 9)
    ((64, 64), 1.0)
    """
    if not isinstance(surface, RoughSurface):
        raise ProblemError(
            f"rough_topography: {shown(surface)} is not a RoughSurface; write RoughSurface(hurst=0.8, rms='1 um', size='1 mm', "
            "shortest='10 um')"
        )
    least = math.ceil(FEWEST_PER_WAVE * surface.longer_side / surface.shortest * (1.0 - 1e-12))
    number = 2 * least if points is None else points
    for name, value in (("realisation", realisation), ("points", number)):
        if not isinstance(value, int | np.integer) or isinstance(value, bool) or value < 0:
            raise ProblemError(
                f"rough_topography: {name} = {shown(value)}; a whole number from 0 on is needed"
            )
    if number < least:
        raise ProblemError(
            f"rough_topography: points = {number}; at least {least} are needed along the longer side, 4 for the shortest wave; take "
            "more of them, or a longer shortest wavelength"
        )
    nx, ny = (max(2, round(number * side / surface.longer_side)) for side in surface.size.tolist())
    return Topography(_heights(surface, int(realisation), nx, ny), surface.size)


def _heights(surface: RoughSurface, realisation: int, nx: int, ny: int) -> FloatArray:
    """Half of the plane of waves has all of them, since heights are real."""
    most_x, most_y = (math.floor(side / surface.shortest * (1.0 + 1e-12)) for side in surface.size)
    i, j = np.meshgrid(np.arange(-most_x, most_x + 1), np.arange(most_y + 1), indexing="ij")
    phases = np.random.default_rng([surface.seed, realisation, _SECOND]).random(i.shape)
    q = 2.0 * math.pi * np.hypot(i / surface.size[0], j / surface.size[1])
    half = (j > 0) | (i > 0)
    waves = np.where(half, np.sqrt(surface.spectrum_2d(q)), 0.0) * np.exp(2j * math.pi * phases)
    spectrum = np.zeros((nx, ny // 2 + 1), dtype=complex)
    spectrum[i % nx, j] += waves
    spectrum[-i[:, 0] % nx, 0] += np.conj(waves[:, 0])
    heights = np.fft.irfft2(spectrum, (nx, ny))
    return np.asarray(heights * (surface.rms / math.sqrt(np.mean(heights**2))))
