"""A contact under a tangential force in proportion to the normal force: its shear traction is a multiple of the pressure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from pymdr.interpretation.stress import Loads, Punches
from pymdr.interpretation.surface import Surface
from pymdr.units import FloatArray


@dataclass(frozen=True)
class Dragged:
    """A surface whose shear traction is everywhere the same fraction of the pressure, in sticking and in sliding."""

    normal: Surface
    ratio: float
    """Tangential over normal force, above 0."""

    @property
    def revolves(self) -> bool:
        """Whether nothing depends on the direction: without a tangential force."""
        return self.ratio == 0.0

    def loads(self, step: int) -> Loads:
        """The normal load on the line, and its fraction as shear load."""
        normal = self.normal.loads(step).normal
        if self.revolves:
            return Loads(normal)
        segments = tuple(self._shared(segment) for segment in normal.segments)
        scale = abs(self.ratio) * normal.scale
        return Loads(normal, replace(normal, segments=segments, edge=self.ratio * normal.edge, scale=scale))

    def _shared(self, segment: Punches) -> Punches:
        """Punches of the normal load times the ratio of the tractions."""
        return segment._replace(density=lambda distance: self.ratio * segment.density(distance))

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Values of a field on the surface at radii in m."""
        if name == "shear_traction":
            return self.ratio * self.normal.field("pressure", position, step)
        return self.normal.field(name, position, step)

    def marks(self, step: int) -> Sequence[float]:
        """As those of the normal contact."""
        return self.normal.marks(step)
