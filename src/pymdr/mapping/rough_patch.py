"""A randomly rough surface in two dimensions: heights on pixels, of the spectrum that its line has too."""

from __future__ import annotations

import math

import numpy as np

from pymdr.errors import ProblemError
from pymdr.machine import memory_of_machine
from pymdr.problem.rough import RoughSurface
from pymdr.problem.topography import Topography
from pymdr.units import FloatArray, metres, shown

_FEWEST_PER_WAVE = 4
_BYTES_PER_PIXEL, _BYTES_PER_WAVE = 32.0, 160.0
"""Memory at the peak of the work; waves are those of half a plane of wave numbers."""
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
        If there are fewer pixels than 4 for the shortest wave, a number is not whole, or the memory of this machine is not enough.

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
    nx, ny = rough_pixels(surface, points)
    if not isinstance(realisation, int | np.integer) or isinstance(realisation, bool) or realisation < 0:
        raise ProblemError(
            f"rough_topography: realisation = {shown(realisation)}; a whole number from 0 on is needed"
        )
    needed, waves = float(nx) * ny, math.prod(float(side) / surface.shortest for side in surface.size)
    needed = _BYTES_PER_PIXEL * needed + _BYTES_PER_WAVE * waves
    if needed > memory_of_machine():
        raise ProblemError(
            f"rough_topography: {nx} x {ny} pixels take about {needed / 1e9:.3g} GB, more than the {memory_of_machine() / 1e9:.3g} GB of "
            f"this machine; take a longer shortest wavelength (now {metres(surface.shortest)}), a smaller patch, or fewer points"
        )
    return Topography(_heights(surface, int(realisation), nx, ny), surface.size)


def rough_pixels(surface: RoughSurface, points: int | None = None) -> tuple[int, int]:
    """
    Pixels along both sides of the patch that :func:`rough_topography` makes.

    Parameters
    ----------
    surface, points
        As for :func:`rough_topography`.

    Returns
    -------
    tuple of int

    Raises
    ------
    ProblemError
        If there are fewer than 4 for the shortest wave, or points is not whole.
    """
    if not isinstance(surface, RoughSurface):
        raise ProblemError(
            f"rough_topography: {shown(surface)} is not a RoughSurface; write RoughSurface(hurst=0.8, rms='1 um', size='1 mm', "
            "shortest='10 um')"
        )
    least = math.ceil(_FEWEST_PER_WAVE * surface.longer_side / surface.shortest * (1.0 - 1e-12))
    number = 2 * least if points is None else points
    if not isinstance(number, int | np.integer) or isinstance(number, bool) or number < 0:
        raise ProblemError(f"rough_topography: points = {shown(number)}; a whole number from 0 on is needed")
    if number < least:
        raise ProblemError(
            f"rough_topography: points = {number}; at least {least} are needed along the longer side, 4 for the shortest wave; take "
            "more of them, or a longer shortest wavelength"
        )
    nx, ny = (max(2, round(int(number) * side / surface.longer_side)) for side in surface.size.tolist())
    return nx, ny


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
