"""Step 1 of a rough surface: the line of springs that is statistically equivalent to it."""

from __future__ import annotations

import math

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.rough import GEIKE, RoughSurface
from pymdr.units import FloatArray

POINTS_PER_WAVE, FEWEST_PER_WAVE, FEWEST = 16, 4, 1024
_MOST = 2**31
"""A line of this many springs exceeds any memory."""


def default_points(surface: RoughSurface) -> int:
    """
    The default number of springs of a line: 16 for its shortest wave.

    Examples
    --------
    >>> default_points(RoughSurface(0.8, "1 um", "1 mm", "1 um"))
    16000
    """
    from scipy.fft import next_fast_len

    wanted = max(POINTS_PER_WAVE * modes_of(surface), FEWEST)
    return int(next_fast_len(wanted, real=True)) if wanted < _MOST else wanted


def modes_of(surface: RoughSurface) -> int:
    """The number of waves of a line: its longest one is as long as the longer side of the surface."""
    return math.floor(surface.longer_side / surface.shortest * (1.0 + 1e-12))


def refuse_coarse(surface: RoughSurface, points: int) -> None:
    """Refuse a line of fewer points than 4 for the shortest wave."""
    needed = FEWEST_PER_WAVE * modes_of(surface)
    if points < needed:
        raise ProblemError(
            f"points = {points}: the line has {modes_of(surface)} waves and needs at least {needed} points, 4 for the shortest "
            "wave; use more points, or a longer shortest wavelength"
        )


def rough_heights(
    surface: RoughSurface, realisation: int = 0, points: int | None = None, coefficient: float = GEIKE
) -> FloatArray:
    """
    Heights of the equivalent line of a rough surface, of the spectrum C1D = lambda q C2D with random phases.

    Parameters
    ----------
    realisation : int, optional
        Which line of the ensemble: its phases are those of the generator of (seed, realisation), whatever else is computed.
    points : int, optional
        Number of springs, at least 4 for the shortest wave; 16 unless given. The phases do not depend on it.
    coefficient : float, optional
        lambda; pi, of Geike, keeps the rms height. It does nothing but scale the heights by sqrt(lambda/pi).

    Returns
    -------
    ndarray
        Heights in m about their mean, one period of the longer side, of the rms height h sqrt(lambda/pi) to rounding.

    Raises
    ------
    ProblemError
        If there are fewer points than 4 for the shortest wave.

    Notes
    -----
    Geike and Popov (2007), Phys. Rev. E 76, 036710; Popov and Hess (2015), chapter 10. The waves are those of the
    surface's own size; the position of a height along the line has no physical meaning, since springs do not interact.

    Examples
    --------
    >>> heights = rough_heights(RoughSurface(0.8, "1 um", "1 mm", "10 um"))
    >>> round(float(np.sqrt(np.mean(heights**2))) * 1e6, 12)
    1.0
    """
    n = default_points(surface) if points is None else points
    refuse_coarse(surface, n)
    q, amplitude = rough_waves(surface, coefficient)
    phases = 2.0 * math.pi * np.random.default_rng([surface.seed, realisation]).random(q.size)
    spectrum = np.zeros(n // 2 + 1, dtype=complex)
    spectrum[1 : q.size + 1] = 0.5 * n * amplitude * np.exp(1j * phases)
    return np.asarray(np.fft.irfft(spectrum, n), dtype=float)


def rough_waves(surface: RoughSurface, coefficient: float = GEIKE) -> tuple[FloatArray, FloatArray]:
    """
    Wave numbers and amplitudes of the line of a rough surface, z = sum A cos(q x + phi).

    Parameters
    ----------
    coefficient : float, optional
        lambda.

    Returns
    -------
    q, A : ndarray
        In 1/m and m; A^2 ~ q C2D(q), and sum A^2 / 2 is the square of the rms height h sqrt(lambda/pi).

    Examples
    --------
    >>> q, A = rough_waves(RoughSurface(0.8, "1 um", "1 mm", "10 um"))
    >>> round(float(np.sqrt(np.sum((A * q) ** 2) / 2)), 4)
    0.0205
    """
    q = surface.wave_numbers[0] * np.arange(1, modes_of(surface) + 1)
    power = surface.spectrum_1d(q)
    # waves are orthogonal on even places, so that these give the rms height itself
    height = surface.rms * math.sqrt(2.0 * coefficient / math.pi)
    return np.asarray(q), np.asarray(height * np.sqrt(power / power.sum()))
