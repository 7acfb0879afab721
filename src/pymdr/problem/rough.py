"""Randomly rough surfaces: spectrum, size, and seed of the phases."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.machine import memory_of_machine
from pymdr.problem.topography import Topography
from pymdr.problem.values import OptionalSIField, SidesField, SIField, Value
from pymdr.units import FloatArray, metres, shown

GEIKE = math.pi
"""lambda of C1D = lambda q C2D that preserves the rms height (Geike and Popov, 2007)."""
_FEWEST = 4
"""Fewest pixels per shortest wave."""
_BYTES_PER_PIXEL, _BYTES_PER_WAVE = 32.0, 160.0
"""Peak memory; waves are counted in half the plane of wave numbers."""
_SECOND = 2
"""Stream of the generator, distinct from that of the lines."""


@dataclass(frozen=True, eq=False)
class RoughSurface(Value):
    """
    A patch of a randomly rough, self-affine, isotropic surface.

    Parameters
    ----------
    hurst : float
        Hurst exponent H, above 0 and at most 1: the spectrum falls as C2D ~ q^(-2 (H + 1)).
    rms : quantity
        Root mean square h of the heights of this patch about their mean, in m.
    size : quantity or pair of quantities
        Side of the square patch in m, or the sides of a rectangle.
    shortest : quantity
        Shortest wavelength of the surface in m.
    longest : quantity, optional
        Wavelength in m above which the spectrum is flat (roll-off); by default the longer side, without roll-off inside
        the patch.
    seed : int, optional
        Seed of the random phases.

    Raises
    ------
    ProblemError
        If H is outside (0, 1], a length is not above 0, the shortest wavelength is not below the longest and the size, or
        the seed is not a whole number of at least 0.

    Examples
    --------
    >>> import pymdr as mdr
    >>> surface = mdr.RoughSurface(hurst=0.8, rms="1 um", size="1 mm", shortest="10 um")
    >>> surface.size.tolist()
    [0.001, 0.001]
    >>> round(surface.rms_slope, 4)
    0.029
    """

    hurst: SIField = SIField("", description="Hurst exponent", above=0.0, at_most=1.0)
    rms: SIField = SIField("m", description="root mean square of the heights", above=0.0)
    size: SidesField = SidesField("m", description="side of a square, or sides of a rectangle")
    shortest: SIField = SIField("m", description="shortest wavelength", above=0.0)
    longest: OptionalSIField = OptionalSIField("m", description="wavelength of the roll-off", above=0.0)
    seed: int = 0

    def __post_init__(self) -> None:
        whole = isinstance(self.seed, int | np.integer) and not isinstance(self.seed, bool)
        if not whole or self.seed < 0:
            raise ProblemError(f"seed = {shown(self.seed)}: a whole number of at least 0 is needed")
        object.__setattr__(self, "seed", int(self.seed))
        for name, limit in (
            ("the longest wavelength", self.roll_off),
            ("the shorter side", float(self.size.min())),
        ):
            if not self.shortest < limit:
                raise ProblemError(
                    f"shortest = {metres(self.shortest)}: it must be below {name}, {metres(limit)}; give "
                    "a shorter wavelength or a larger patch"
                )

    @property
    def longer_side(self) -> float:
        """The longer side in m."""
        return float(self.size.max())

    @property
    def roll_off(self) -> float:
        """The wavelength in m above which the spectrum is flat; the longer side without roll-off inside."""
        return self.longer_side if self.longest is None else min(self.longest, self.longer_side)

    @property
    def has_roll_off(self) -> bool:
        """Whether part of the spectrum is flat."""
        return self.roll_off < self.longer_side

    @property
    def wave_numbers(self) -> tuple[float, float, float]:
        """Wave numbers in 1/m of the longer side, of the roll-off and of the shortest wave."""
        turn = 2.0 * math.pi
        return turn / self.longer_side, turn / self.roll_off, turn / self.shortest

    @property
    def _plateau(self) -> float:
        """C2D below the roll-off in m^4, from h^2 = 2 pi int C2D q dq."""
        return self.rms**2 / (2.0 * math.pi * self._moment(1) * self.wave_numbers[1] ** 2)

    def _moment(self, power: int) -> float:
        """The integral of q^power C2D for a plateau of 1, with q in units of the wave number of the roll-off."""
        low, roll, high = self.wave_numbers
        flat = (1.0 - (low / roll) ** (power + 1)) / (power + 1)
        exponent, octaves = power - 1 - 2.0 * self.hurst, math.log(high / roll)
        falling = math.expm1(exponent * octaves) / exponent if exponent != 0.0 else octaves
        return flat + falling

    @property
    def rms_slope(self) -> float:
        """
        Root mean square of the gradient of the surface: the square root of 2 pi int C2D q^3 dq.

        The mean square slope of a straight cut is half of its square. A line with Geike's lambda has the full value if its
        spectrum is dense; without roll-off long waves are few, and its slope is 5 (H near 0) to 35 % (H = 1) smaller.
        """
        return self.rms * self.wave_numbers[1] * math.sqrt(self._moment(3) / self._moment(1))

    def spectrum_2d(self, q: ArrayLike) -> FloatArray:
        """
        Power spectral density of the surface, with h^2 = 2 pi int C2D q dq.

        Parameters
        ----------
        q : array_like
            Wave numbers in 1/m.

        Returns
        -------
        ndarray
            C2D in m^4; 0 where the surface has no waves.
        """
        given = np.asarray(q, dtype=float)
        low, roll, high = self.wave_numbers
        inside = (given >= low * (1.0 - 1e-11)) & (given <= high * (1.0 + 1e-11))
        shape = np.where(inside, np.maximum(given / roll, 1.0), 1.0) ** (-2.0 * (self.hurst + 1.0))
        return np.asarray(np.where(inside, self._plateau * shape, 0.0))

    def spectrum_1d(self, q: ArrayLike, coefficient: float = GEIKE) -> FloatArray:
        """
        Power spectral density of the equivalent line, C1D = lambda q C2D, with h1^2 = 2 int C1D dq.

        Parameters
        ----------
        q : array_like
            Wave numbers in 1/m.
        coefficient : float, optional
            lambda; pi, of Geike, keeps the rms height.

        Returns
        -------
        ndarray
            C1D in m^3.

        Notes
        -----
        Geike and Popov (2007), Phys. Rev. E 76, 036710; Popov and Hess (2015), chapter 10.
        """
        given = np.asarray(q, dtype=float)
        return np.asarray(coefficient * given * self.spectrum_2d(given))

    def topography(self, realisation: int = 0, *, points: int | None = None) -> Topography:
        """
        The surface on pixels, from the spectrum C2D with random phases.

        Parameters
        ----------
        realisation : int, optional
            Number of the realisation; the generator is seeded with (seed, realisation).
        points : int, optional
            Pixels along the longer side, at least 4 per shortest wave; by default 8. The waves do not depend on it.

        Returns
        -------
        Topography
            Heights in m about their mean, periodic, with the given rms height to rounding.

        Raises
        ------
        ProblemError
            If there are fewer than 4 pixels per shortest wave, a number is not whole, or the memory is insufficient.

        Notes
        -----
        Persson, Albohr, Tartaglino, Volokitin and Tosatti (2005), J. Phys.: Condens. Matter 17, R1. Contact pressures vary
        within the shortest wave, which 4 pixels do not resolve: :func:`pymdr.press` gives the error of the grid.

        Examples
        --------
        >>> import pymdr as mdr
        >>> patch = mdr.RoughSurface(0.8, "1 um", "1 mm", "100 um").topography(points=64)
        >>> patch.heights.shape, round(float(patch.heights.std()) * 1e6, 9)
        ((64, 64), 1.0)
        """
        nx, ny = self.pixels(points)
        if not isinstance(realisation, int | np.integer) or isinstance(realisation, bool) or realisation < 0:
            raise ProblemError(f"realisation = {shown(realisation)}; a whole number of at least 0 is needed")
        needed, waves = float(nx) * ny, math.prod(float(side) / self.shortest for side in self.size)
        needed = _BYTES_PER_PIXEL * needed + _BYTES_PER_WAVE * waves
        if needed > memory_of_machine():
            raise ProblemError(
                f"{nx} x {ny} pixels need about {needed / 1e9:.3g} GB (this machine has {memory_of_machine() / 1e9:.3g} GB); "
                f"use a longer shortest wavelength (now {metres(self.shortest)}), a smaller patch, or fewer points"
            )
        return Topography(_heights(self, int(realisation), nx, ny), self.size)

    def pixels(self, points: int | None = None) -> tuple[int, int]:
        """
        Pixels along both sides of the patch of :meth:`topography`.

        Parameters
        ----------
        points : int, optional
            As for :meth:`topography`.

        Returns
        -------
        tuple of int

        Raises
        ------
        ProblemError
            If there are fewer than 4 per shortest wave, or points is not whole.
        """
        least = math.ceil(_FEWEST * self.longer_side / self.shortest * (1.0 - 1e-12))
        number = 2 * least if points is None else points
        if not isinstance(number, int | np.integer) or isinstance(number, bool) or number < 0:
            raise ProblemError(f"points = {shown(number)}; a whole number of at least 0 is needed")
        if number < least:
            raise ProblemError(
                f"points = {number}; at least {least} are needed along the longer side (4 per shortest wave); use "
                "more points or a longer shortest wavelength"
            )
        nx, ny = (max(2, round(int(number) * side / self.longer_side)) for side in self.size.tolist())
        return nx, ny


def _heights(surface: RoughSurface, realisation: int, nx: int, ny: int) -> FloatArray:
    """Heights in m; half the plane of wave numbers suffices, because heights are real."""
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
