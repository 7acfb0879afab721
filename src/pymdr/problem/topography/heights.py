"""Measured and computed surfaces as heights on a grid."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import ProblemError
from pymdr.problem.values import ArrayField, SidesField, Value, within_range
from pymdr.units import ArrayQuantityLike, FloatArray, shown, to_si_array


class HeightsField(ArrayField):
    """A field of heights on a grid; nan where not measured."""

    def read(self, values: ArrayQuantityLike) -> FloatArray:
        """Convert to a read-only matrix of SI lengths."""
        name = self.name
        if isinstance(values, list | tuple):
            with suppress(ValueError, TypeError):
                values = np.asarray(values, dtype=float)
        heights = to_si_array(values, self.unit, name=name, missing=True)
        if heights.ndim != 2 or min(heights.shape) < 2:
            raise ProblemError(
                f"{name}: a matrix of at least 2 x 2 heights is needed, not shape {heights.shape}"
            )
        if np.all(np.isnan(heights)):
            raise ProblemError(f"{name}: all heights are missing (nan); give measured heights")
        within_range(np.nan_to_num(heights), self.unit, name)
        return heights


@dataclass(frozen=True, eq=False)
class Heights(Value):
    """The fields of :class:`pymdr.Topography`."""

    heights: HeightsField = HeightsField("m", description="heights, positive out of the body")
    size: SidesField = SidesField("m", description="sides along x and y, or side of a square")
    steps: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.steps, tuple) or not all(isinstance(step, str) for step in self.steps):
            raise ProblemError(f"steps = {shown(self.steps)}: a tuple of texts is needed")

    def complete(self) -> FloatArray:
        """The heights; refused if some are missing."""
        count = int(np.count_nonzero(self.missing))
        if count:
            raise ProblemError(
                f"{count} of {self.heights.size} heights are missing; fill them with topography.fill_missing('interpolate'), or "
                "crop to the measured part with topography.fill_missing('crop')"
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
        """Pixels that were not measured, (nx, ny)."""
        return np.isnan(self.heights)


Surface = TypeVar("Surface", bound=Heights)
