"""Surfaces of contacts with friction or twist: what they share with their normal contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from pymdr.units import FloatArray


class NormalSurface(Protocol):
    """The surface of a contact that is pressed."""

    def gap_function(self, r: FloatArray) -> FloatArray:
        """The profile f(r)."""

    def default_radii(self, step: int) -> FloatArray:
        """Radii in m at which fields are shown."""

    def marks(self, step: int) -> Sequence[float]:
        """Radii in m at which fields have kinks or edges."""

    def edge_amplitude(self, step: int) -> float:
        """The factor of the singularity of the pressure at the edge."""


Normal = TypeVar("Normal", bound=NormalSurface)


@dataclass(frozen=True, eq=False)
class OnNormal(Generic[Normal]):
    """A surface whose profile and radii are those of its normal contact."""

    normal: Normal

    def gap_function(self, r: FloatArray) -> FloatArray:
        """The profile f(r)."""
        return self.normal.gap_function(r)

    def default_radii(self, step: int) -> FloatArray:
        """As that of the normal contact."""
        return self.normal.default_radii(step)

    def marks(self, step: int) -> Sequence[float]:
        """As those of the normal contact."""
        return self.normal.marks(step)

    def edge_amplitude(self, step: int) -> float:
        """As that of the normal contact."""
        return self.normal.edge_amplitude(step)
