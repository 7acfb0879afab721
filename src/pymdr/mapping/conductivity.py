"""Conductivity of a pair of bodies on the line, the counterpart of E*."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pymdr.problem.materials import Material

Carrier = Literal["thermal_conductivity", "resistivity"]
"""The property of a body by which it conducts heat, or a current."""


@dataclass(frozen=True)
class Conductivity:
    """Effective conductivities of two bodies, in W/(m K) or 1/(ohm m)."""

    one: float
    other: float

    @property
    def line(self) -> float:
        """Conductivity of the line, lambda_eff = 2 lambda_1 lambda_2/(lambda_1 + lambda_2) = 2/(rho_1 + rho_2): bodies in series."""
        return 2.0 / (1.0 / self.one + 1.0 / self.other)

    @property
    def both(self) -> float:
        """Sum lambda_1 + lambda_2 of both bodies in parallel."""
        return self.one + self.other


def conductivity_of(body: Material, counterbody: Material, carrier: Carrier) -> Conductivity | str:
    """
    The conductivities of two bodies, or a text why they are unknown.

    Parameters
    ----------
    carrier : str
        "thermal_conductivity" or "resistivity".

    Notes
    -----
    Holm (1967), Electric Contacts, section 3: a disk of the radius a conducts 2 a lambda_eff.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> copper = Elastic("120 GPa", 0.34, thermal_conductivity="390 W/(m K)")
    >>> conductivity_of(copper, copper, "thermal_conductivity").line
    390.0
    """
    bodies = {"body": body, "counterbody": counterbody}
    for name, one in bodies.items():
        if not one.homogeneous:
            return (
                f"the {name} is graded or layered: the conductivity over its depth is unknown; give a homogeneous "
                "half-space"
            )
    for name, one in bodies.items():
        if getattr(one, carrier) is None:
            kind = type(one).__name__
            return f"the {name}, {kind}, has no {carrier}; give {kind}(..., {carrier}=...)"
    given = getattr(body, carrier), getattr(counterbody, carrier)
    return Conductivity(*(1.0 / each for each in given) if carrier == "resistivity" else given)


def is_carried(body: Material, counterbody: Material, carrier: Carrier) -> bool:
    """Whether at least one of two bodies has the conductivity or resistivity."""
    return getattr(body, carrier) is not None or getattr(counterbody, carrier) is not None
