"""Materials of the two bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from pymdr.problem.values import SIField, Value


@dataclass(frozen=True, eq=False)
class Elastic(Value):
    """
    An isotropic linear-elastic half-space.

    Parameters
    ----------
    young : quantity
        Young's modulus E in Pa, above 0.
    poisson : quantity
        Poisson's ratio, -1 < nu <= 0.5.

    Raises
    ------
    ProblemError
        If a value is outside its limits.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> Elastic("210 GPa", 0.3).young
    210000000000.0
    """

    young: SIField = SIField("Pa", above=0.0, words="Young's modulus")
    poisson: SIField = SIField("", above=-1.0, at_most=0.5, words="Poisson's ratio")

    @property
    def shear(self) -> float:
        """Shear modulus G = E / (2 (1 + nu)) in Pa."""
        return self.young / (2.0 * (1.0 + self.poisson))


@dataclass(frozen=True, eq=False)
class Rigid(Value):
    """
    A body that does not deform.

    Examples
    --------
    >>> Rigid() == Rigid()
    True
    """


Material: TypeAlias = Elastic | Rigid
