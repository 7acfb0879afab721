"""Measured and computed surfaces as heights on a grid."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ProblemError
from pymdr.problem.values import ArrayField, SidesField, Value, within_range
from pymdr.units import ArrayQuantityLike, FloatArray, shown, to_si_array


class HeightsField(ArrayField):
    """A field of heights on a grid, where nan stands for what was not measured."""

    def read(self, values: ArrayQuantityLike) -> FloatArray:
        """Convert to a read-only matrix of SI lengths."""
        name = f"{self.owner}.{self.name}"
        if isinstance(values, list | tuple):
            with suppress(ValueError, TypeError):
                values = np.asarray(values, dtype=float)
        heights = to_si_array(values, self.unit, name=name, missing=True)
        if heights.ndim != 2 or min(heights.shape) < 2:
            raise ProblemError(
                f"{name}: a matrix of at least 2 x 2 heights is needed, not shape {heights.shape}"
            )
        if np.all(np.isnan(heights)):
            raise ProblemError(f"{name}: all heights are missing; nan stands for what was not measured")
        within_range(np.nan_to_num(heights), self.unit, name)
        return heights


@dataclass(frozen=True, eq=False)
class Topography(Value):
    """
    The heights of a surface on a rectangular grid of pixels.

    Parameters
    ----------
    heights : array_like of quantity
        Heights in m, (nx, ny), that grow out of the body: its summits touch first. nan where nothing was measured.
    size : quantity or pair of quantities
        Sides along x and y in m of the whole patch, nx and ny pixels; one length for a square.
    steps : tuple of str, optional
        Where the heights come from and what was done to them, in words, one after the other.

    Raises
    ------
    ProblemError
        If the heights are no matrix of at least 2 x 2, all missing, or a side is not above 0.
    UnitError
        If something is no length, or a height is infinite.

    Examples
    --------
    >>> surface = Topography([[0.0, 1e-9], [2e-9, 3e-9]], "2 um")
    >>> surface.spacing.tolist()
    [1e-06, 1e-06]
    """

    heights: HeightsField = HeightsField("m", words="heights, growing out of the body")
    size: SidesField = SidesField("m", words="sides along x and y, or side of a square")
    steps: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.steps, tuple) or not all(isinstance(step, str) for step in self.steps):
            raise ProblemError(f"Topography.steps = {shown(self.steps)}: a tuple of texts is needed")

    def whole(self, who: str) -> FloatArray:
        """The heights, refused if some are missing."""
        count = int(np.count_nonzero(self.missing))
        if count:
            raise ProblemError(
                f"{who}: {count} of {self.heights.size} heights are missing; fill them by fill_missing(topography, 'interpolate'), or "
                "cut down to what was measured by fill_missing(topography, 'crop')"
            )
        return self.heights

    @property
    def spacing(self) -> FloatArray:
        """Width of a pixel in m along x and y."""
        return np.asarray(self.size / self.heights.shape)

    @property
    def x(self) -> FloatArray:
        """Centres of the pixels along x in m, (nx,), from the corner."""
        return np.asarray((np.arange(self.heights.shape[0]) + 0.5) * self.spacing[0])

    @property
    def y(self) -> FloatArray:
        """Centres of the pixels along y in m, (ny,), from the corner."""
        return np.asarray((np.arange(self.heights.shape[1]) + 0.5) * self.spacing[1])

    @cached_property
    def missing(self) -> NDArray[np.bool_]:
        """Whether a pixel was not measured, (nx, ny)."""
        return np.isnan(self.heights)


def as_topography(topography: object, who: str) -> Topography:
    """
    A topography as it is.

    Raises
    ------
    ProblemError
        If it is none.
    """
    if not isinstance(topography, Topography):
        raise ProblemError(f"{who}: {shown(topography)} is no surface; write Topography(heights, size)")
    return topography
