"""Protocols of the sources of fields of every law."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, runtime_checkable

from pymdr.units import FloatArray


class EdgedField(Protocol):
    """A field that may be singular at the edge of the contact, step by step."""

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Values of a field at radii (or positions on the line) in m in one step."""

    def default_radii(self, step: int) -> FloatArray:
        """Default radii in m of fields."""

    def edge_amplitude(self, step: int) -> float:
        """Amplitude of the singularity at the edge in its unit times m^0.5; NaN if it is not a square root."""


class FieldReader(EdgedField, Protocol):
    """The source of fields, step by step; its edge is that of the pressure."""

    @property
    def gap_function(self) -> Callable[[FloatArray], FloatArray]:
        """The profile f(r)."""

    def marks(self, step: int) -> Sequence[float]:
        """Radii in m in the contact at which its pressure may have a kink or be unbounded."""


@runtime_checkable
class DirectedReader(FieldReader, Protocol):
    """A reader of fields that depend on the direction."""

    def towards(self, angle: float) -> FieldReader:
        """The reader for radii in the direction of an angle in rad from the x-axis."""


@runtime_checkable
class DeflectedReader(Protocol):
    """A reader whose springs have deflections of their own, which the profile and the indentation do not determine."""

    def deflection(self, step: int, position: FloatArray) -> FloatArray:
        """Deflection in m of springs at positions in m in one step, in and out of contact."""
