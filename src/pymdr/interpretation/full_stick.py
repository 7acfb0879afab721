"""Claims and shear traction of an adhesive contact that is sheared without slip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymdr.interpretation.conductance import DiskFlux
from pymdr.interpretation.validity import SOURCES, Level
from pymdr.mapping.moduli import EffectiveModuli
from pymdr.units import FloatArray


def statement(moduli: EffectiveModuli) -> tuple[Level, str, str]:
    """Level, reason and source of the claims under shear without slip."""
    coupling = ""
    if not moduli.similar:
        coupling = f"; the coupling of pressure and shear of dissimilar bodies is neglected (Dundurs' beta = {moduli.dundurs_beta:.3g})"
    return (
        Level.APPROXIMATE,
        "the law of Savkoor and Briggs for elastic half-spaces on a disk: the complete contact, also where it grows, is sheared by the "
        "shift since it formed, and the full energy of this shear enters the energy release rate of the edge. This is disputed: in the "
        f"other view uniform shear does not change the contact of JKR. The stated error is the difference between the two views{coupling}",
        SOURCES["savkoor-briggs"],
    )


@dataclass(frozen=True)
class PunchTraction:
    """The shear traction G* u / (pi sqrt(a^2 - r^2)) of contacts in which one shift is carried without slip."""

    tangential: float
    """G* in Pa."""
    shift: FloatArray
    """Shift in m of every step since the contact formed."""
    contact_radius: FloatArray

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Values at radii in one step, nan without a contact radius."""
        return self._disk(step).field(name, position, step)

    def default_radii(self, step: int) -> FloatArray:
        """A grid from 0 to 1.5 contact radii, graded to the edge."""
        return self._disk(step).default_radii(step)

    def edge_amplitude(self, step: int) -> float:
        """Amplitude of the singularity at the edge in Pa m^0.5."""
        return self._disk(step).edge_amplitude(step)

    def _disk(self, step: int) -> DiskFlux:
        # a punch carries the force 2 G* a u as a disk carries the flux 2 lambda a
        return DiskFlux(self.tangential * float(np.nan_to_num(self.shift[step])), self.contact_radius)


def difference_of_views(
    state: tuple[FloatArray, FloatArray, FloatArray],
    plain: tuple[FloatArray, FloatArray, FloatArray],
    sizes: tuple[FloatArray, FloatArray, FloatArray],
) -> FloatArray:
    """The largest relative difference of radius, depth and force from those of the contact without shear, at most 1."""
    with np.errstate(divide="ignore", invalid="ignore"):
        each = [np.abs(one - other) / size for one, other, size in zip(state, plain, sizes, strict=True)]
    largest: FloatArray = np.max(each, axis=0)
    return np.minimum(np.nan_to_num(largest, nan=0.0, posinf=1.0), 1.0)
