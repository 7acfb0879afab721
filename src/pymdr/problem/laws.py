"""Laws of adhesion and friction."""

from __future__ import annotations

import math
from abc import ABC
from dataclasses import dataclass

from pymdr.errors import ProblemError
from pymdr.problem.values import OptionalSIField, SIField, Value
from pymdr.units import QuantityLike, written


class AdhesionLaw(Value, ABC):
    """Law of attraction between the surfaces."""

    work: SIField

    @property
    def cohesive_stress(self) -> float | None:
        """Cohesive stress in Pa around the contact; None if the law has none."""
        return None

    @property
    def attraction_range(self) -> float | None:
        """Range in m of the attraction around the contact; None if the law has none."""
        return None if self.cohesive_stress is None else self.work / self.cohesive_stress

    @property
    def works(self) -> tuple[float, float]:
        """Works of adhesion of an advancing and of a receding edge in J/m^2."""
        return self.work, self.work

    @property
    def has_hysteresis(self) -> bool:
        """Whether separating the surfaces takes more work than their contact gains."""
        return self.works[1] > self.works[0]


@dataclass(frozen=True, eq=False)
class JKR(AdhesionLaw):
    """
    Short-range adhesion: the surfaces attract each other only in contact.

    Parameters
    ----------
    work : quantity
        Work of adhesion per area in J/m^2, above 0. With work_receding it is what an advancing edge gains.
    work_receding : quantity, optional
        Work per area in J/m^2 that a receding edge takes, at least `work`, which is the default. Between both works
        the edge rests.
    range : quantity, optional
        Range of the attraction in m, above 0, which the rate of adhesion depends on: needed by `Viscoelastic` bodies, and only for them. Not
        with work_receding.

    Raises
    ------
    ProblemError
        If a value is not above 0, work_receding is below work, or given with range.

    See Also
    --------
    adhesion_regime : which law is valid.
    pull_off : the force and travel at which the bodies separate.

    Notes
    -----
    Johnson, Kendall and Roberts (1971); for any profile by the rule of Hess (2011): the outermost springs
    detach at the elongation sqrt(2 pi a work / E*). Hysteresis of adhesion (Chen, Helm and Israelachvili 1991) by two works
    of adhesion: the edge advances at the energy release rate `work`, recedes at `work_receding`, and rests between both.

    References
    ----------
    - Chen, Helm and Israelachvili (1991), J. Phys. Chem. 95, 10736-10747.
    - Johnson, Kendall and Roberts (1971), Proc. R. Soc. A 324, 301-313, doi:10.1098/rspa.1971.0141.
    - Hess (2011), Ueber die Abbildung ausgewaehlter dreidimensionaler Kontakte auf Systeme mit niedrigerer
      raeumlicher Dimension, Cuvillier.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.JKR("50 mJ/m^2").work
    0.05
    >>> mdr.JKR("20 mJ/m^2", work_receding="0.1 J/m^2").has_hysteresis
    True
    """

    work: SIField = SIField("J/m^2", above=0.0, description="work of adhesion")
    work_receding: OptionalSIField = OptionalSIField(
        "J/m^2", above=0.0, description="work of adhesion of a receding edge"
    )
    range: OptionalSIField = OptionalSIField(
        "m", above=0.0, description="range of the attraction, for bodies with memory"
    )

    def __post_init__(self) -> None:
        if self.work_receding is not None and self.work_receding < self.work:
            raise ProblemError(
                f"work_receding = {written(self.work_receding, 'J/m^2')}: it must be at least work = "
                f"{written(self.work, 'J/m^2')}, because separation takes at least the work that contact gains"
            )
        if self.work_receding is not None and self.range is not None:
            raise ProblemError(
                "work_receding (hysteresis at any rate) and range (hysteresis by the memory of the bodies) exclude each other; give one of them"
            )

    @property
    def attraction_range(self) -> float | None:
        """Range in m of the attraction around the contact; None if it is not given."""
        return self.range

    @property
    def works(self) -> tuple[float, float]:
        """Works of adhesion of an advancing and of a receding edge in J/m^2."""
        return self.work, self.work if self.work_receding is None else self.work_receding


@dataclass(frozen=True, eq=False)
class MaugisDugdale(AdhesionLaw):
    """
    Adhesion by a constant stress up to a finite distance between the surfaces.

    Parameters
    ----------
    work : quantity
        Work of adhesion in J/m^2, above 0.
    strength : quantity, optional
        The cohesive stress in Pa, above 0.
    range : quantity, optional
        The distance in m up to which it acts, above 0. Exactly one of strength and range is needed;
        work = strength * range.

    Raises
    ------
    ProblemError
        If both or neither of strength and range are given, or a value is not above 0.

    See Also
    --------
    adhesion_regime : which law is valid.
    JKR : the limit of short range.
    DMT : the limit of stiff bodies.

    Notes
    -----
    Maugis (1992), for any profile whose equivalent profile rises.

    References
    ----------
    Maugis (1992), J. Colloid Interface Sci. 150, 243-269, doi:10.1016/0021-9797(92)90285-T.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.MaugisDugdale("50 mJ/m^2", range="0.5 nm").cohesive_stress
    100000000.0
    """

    work: SIField = SIField("J/m^2", above=0.0, description="work of adhesion")
    strength: OptionalSIField = OptionalSIField("Pa", above=0.0, description="cohesive stress")
    range: OptionalSIField = OptionalSIField("m", above=0.0, description="range of the cohesive stress")

    def __post_init__(self) -> None:
        if (self.strength is None) == (self.range is None):
            given = "neither" if self.strength is None else "both"
            raise ProblemError(
                f"{given} of strength and range given; name exactly one, "
                "for example MaugisDugdale('50 mJ/m^2', strength='20 MPa')"
            )

    @property
    def cohesive_stress(self) -> float:
        """The cohesive stress in Pa."""
        if self.strength is not None:
            return self.strength
        assert self.range is not None
        return self.work / self.range


@dataclass(frozen=True, eq=False)
class DMT(AdhesionLaw):
    """
    Adhesion that does not deform the bodies: the frictionless contact under a constant pull.

    Parameters
    ----------
    work : quantity
        Work of adhesion in J/m^2, above 0.
    range : quantity, optional
        Range of the attraction in m, above 0. Not needed for a body with a radius of curvature R, whose pull is
        2 pi work R; for others the pull depends on the range.

    See Also
    --------
    adhesion_regime : which law is valid.
    MaugisDugdale : the law between the limits.
    pull_off : the force and travel at which the bodies separate.

    Notes
    -----
    Derjaguin, Muller and Toporov (1975) in the form of Maugis (1992): the limit of :class:`MaugisDugdale`
    for stiff, small bodies.

    References
    ----------
    - Derjaguin, Muller and Toporov (1975), J. Colloid Interface Sci. 53, 314-326, doi:10.1016/0021-9797(75)90018-1.
    - Maugis (1992), J. Colloid Interface Sci. 150, 243-269, doi:10.1016/0021-9797(92)90285-T.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.DMT("50 mJ/m^2").range is None
    True
    """

    work: SIField = SIField("J/m^2", above=0.0, description="work of adhesion")
    range: OptionalSIField = OptionalSIField("m", above=0.0, description="range of the attraction")


_SMALLEST_COEFFICIENT, _LARGEST_COEFFICIENT = 1e-30, 1e6


class _CoefficientField(SIField):
    """A coefficient of friction, which may be infinite."""

    def read(self, value: QuantityLike) -> float:
        """Convert and check; inf stands for no slip."""
        if (isinstance(value, float) and value == math.inf) or (
            isinstance(value, str) and value.strip() == "inf"
        ):
            return math.inf
        number = super().read(value)
        if number > _LARGEST_COEFFICIENT:
            raise ProblemError(
                f"{self.name} = {value!r}: slip above {_LARGEST_COEFFICIENT:g} cannot be "
                "resolved; use Coulomb(math.inf) for contact without slip"
            )
        if 0.0 < number < _SMALLEST_COEFFICIENT:
            raise ProblemError(
                f"{self.name} = {value!r}: friction below {_SMALLEST_COEFFICIENT:g} cannot "
                "be resolved; use Coulomb(0) for frictionless contact"
            )
        return number + 0.0  # no negative zero


@dataclass(frozen=True, eq=False)
class Coulomb(Value):
    """
    Dry friction: the shear traction is at most the coefficient times the pressure.

    Parameters
    ----------
    coefficient : quantity
        Coefficient of friction mu, 0 or from 1e-30 to 1e6; ``math.inf`` (or "inf") is contact without slip.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Coulomb(0.3).coefficient
    0.3
    """

    coefficient: SIField = _CoefficientField("", at_least=0.0, description="coefficient of friction")
