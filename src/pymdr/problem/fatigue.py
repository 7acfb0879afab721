"""Criteria of fatigue, by which a cycle of stress is rated."""

from __future__ import annotations

from abc import ABC
from dataclasses import dataclass
from typing import ClassVar

from pymdr.problem.values import OptionalSIField, SIField, Value


class FatigueCriterion(Value, ABC):
    """A measure of a cycle of stress that is compared with an endurance limit."""

    quantity: ClassVar[str]
    """Name of the measure."""
    source: ClassVar[str]
    """Author, year, place and equation."""
    endurance_limit: OptionalSIField


@dataclass(frozen=True, eq=False)
class DangVan(FatigueCriterion):
    """
    Dang Van's criterion: the shear stress in a grain and the mean normal stress at one instant.

    Parameters
    ----------
    hydrostatic_slope : float
        alpha, at least 0, the weight of the mean normal stress; 3 (t/f - 1/2) from the fatigue limits t in torsion and f in bending.
    endurance_limit : quantity, optional
        The fatigue limit t in torsion in Pa, above 0, with which the measure is compared.

    See Also
    --------
    fatigue : the largest value of a criterion in a body.

    Notes
    -----
    max over time of tau(t) + alpha p_h(t). tau is half of the Tresca stress of s(t) - s*, where s is the deviator and s* the centre of the
    smallest ball in the space of deviators that encloses the cycle; p_h is the mean normal stress, tension positive.

    References
    ----------
    - Dang Van, Griveau and Message (1989), in Biaxial and Multiaxial Fatigue, EGF 3, 479-496.
    - Dang Van and Maitournam (1993), J. Mech. Phys. Solids 41, 1691-1710.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.DangVan(hydrostatic_slope=0.3, endurance_limit="250 MPa").endurance_limit
    250000000.0
    """

    quantity: ClassVar[str] = "dang_van_stress"
    source: ClassVar[str] = (
        "Dang Van, Griveau and Message (1989), in Biaxial and Multiaxial Fatigue, EGF 3, 479-496: max[tau(t) + alpha p_h(t)]"
    )

    hydrostatic_slope: SIField = SIField("", at_least=0.0, description="weight of the mean normal stress")
    endurance_limit: OptionalSIField = OptionalSIField(
        "Pa", above=0.0, description="fatigue limit in torsion"
    )


@dataclass(frozen=True, eq=False)
class Findley(FatigueCriterion):
    """
    Findley's criterion: the plane with the largest sum of shear amplitude and a multiple of the largest normal stress.

    Parameters
    ----------
    normal_slope : float
        k, at least 0, the weight of the largest normal stress; 0.2 to 0.3 for ductile metals.
    endurance_limit : quantity, optional
        The limit of the measure in Pa, above 0.

    See Also
    --------
    fatigue : the largest value of a criterion in a body.

    Notes
    -----
    max over planes of tau_a + k sigma_n,max. tau_a is half of the largest distance of two shear stress vectors on the plane.

    References
    ----------
    Findley (1959), J. Eng. Ind. 81, 301-306, doi:10.1115/1.4008327.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Findley(normal_slope=0.3).normal_slope
    0.3
    """

    quantity: ClassVar[str] = "findley_stress"
    source: ClassVar[str] = "Findley (1959), J. Eng. Ind. 81, 301-306: tau_a + k sigma_n,max"

    normal_slope: SIField = SIField("", at_least=0.0, description="weight of the largest normal stress")
    endurance_limit: OptionalSIField = OptionalSIField("Pa", above=0.0, description="limit of the measure")


@dataclass(frozen=True, eq=False)
class FatemiSocie(FatigueCriterion):
    """
    The criterion of Fatemi and Socie: the shear strain amplitude of a plane, raised by the normal stress that opens it.

    Parameters
    ----------
    normal_slope : float
        k, at least 0, the weight of the largest normal stress over the yield strength.
    yield_strength : quantity
        sigma_y in Pa, above 0.
    endurance_limit : quantity, optional
        The limit of the measure, a strain above 0.

    See Also
    --------
    fatigue : the largest value of a criterion in a body.

    Notes
    -----
    max over planes of gamma_a (1 + k sigma_n,max/sigma_y), with sigma_n,max at least 0 and the elastic strain gamma_a = tau_a/G. The
    authors take the plane of the largest gamma_a; the plane of the largest measure is on the safe side.

    References
    ----------
    Fatemi and Socie (1988), Fatigue Fract. Eng. Mater. Struct. 11, 149-165, doi:10.1111/j.1460-2695.1988.tb01169.x.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.FatemiSocie(normal_slope=1.0, yield_strength="500 MPa").yield_strength
    500000000.0
    """

    quantity: ClassVar[str] = "fatemi_socie_strain"
    source: ClassVar[str] = (
        "Fatemi and Socie (1988), Fatigue Fract. Eng. Mater. Struct. 11, 149-165: gamma_a (1 + k sigma_n,max/sigma_y)"
    )

    normal_slope: SIField = SIField("", at_least=0.0, description="weight of the largest normal stress")
    yield_strength: SIField = SIField("Pa", above=0.0, description="yield strength")
    endurance_limit: OptionalSIField = OptionalSIField("", above=0.0, description="limit of the measure")


@dataclass(frozen=True, eq=False)
class SmithWatsonTopper(FatigueCriterion):
    """
    The parameter of Smith, Watson and Topper on the plane where it is largest.

    Parameters
    ----------
    endurance_limit : quantity, optional
        The limit of the measure in Pa, above 0.

    See Also
    --------
    fatigue : the largest value of a criterion in a body.

    Notes
    -----
    max over planes of sigma_n,max epsilon_n,a, with sigma_n,max at least 0 and the amplitude epsilon_n,a of the elastic normal strain.

    References
    ----------
    - Smith, Watson and Topper (1970), J. Mater. 5, 767-778.
    - Szolwinski and Farris (1996), Wear 198, 93-107, doi:10.1016/0043-1648(96)06937-2: on the plane where it is largest, in fretting.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.SmithWatsonTopper(endurance_limit="1 MPa").endurance_limit
    1000000.0
    """

    quantity: ClassVar[str] = "smith_watson_topper"
    source: ClassVar[str] = (
        "Smith, Watson and Topper (1970), J. Mater. 5, 767-778, on the plane where it is largest (Szolwinski and Farris 1996, Wear 198, "
        "93-107): sigma_n,max epsilon_n,a"
    )

    endurance_limit: OptionalSIField = OptionalSIField("Pa", above=0.0, description="limit of the measure")


_RUIZ = "Ruiz, Boddington and Chen (1984), Exp. Mech. 24, 208-217, doi:10.1007/BF02323167"


@dataclass(frozen=True, eq=False)
class RuizWork(FatigueCriterion):
    """
    The first parameter of Ruiz: shear traction times slip amplitude on the surface.

    Parameters
    ----------
    endurance_limit : quantity, optional
        The limit of the measure in N/m, above 0.

    See Also
    --------
    fatigue : the largest value of a criterion in a body.

    Notes
    -----
    tau delta, with the largest shear traction of the cycle and half of the range of the slip, at one point of the surface.

    References
    ----------
    Ruiz, Boddington and Chen (1984), Exp. Mech. 24, 208-217, doi:10.1007/BF02323167.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.RuizWork(endurance_limit="100 N/m").endurance_limit
    100.0
    """

    quantity: ClassVar[str] = "ruiz_work"
    source: ClassVar[str] = f"{_RUIZ}: tau delta"

    endurance_limit: OptionalSIField = OptionalSIField("N/m", above=0.0, description="limit of the measure")


@dataclass(frozen=True, eq=False)
class RuizDamage(FatigueCriterion):
    """
    The second parameter of Ruiz: tension times shear traction times slip amplitude on the surface.

    Parameters
    ----------
    endurance_limit : quantity, optional
        The limit of the measure in Pa N/m, above 0.

    See Also
    --------
    fatigue : the largest value of a criterion in a body.

    Notes
    -----
    sigma tau delta, with the largest tension sigma_xx along the shift, at least 0, the largest shear traction of the cycle and half of the
    range of the slip, at one point of the surface.

    References
    ----------
    Ruiz, Boddington and Chen (1984), Exp. Mech. 24, 208-217, doi:10.1007/BF02323167.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.RuizDamage(endurance_limit="1e10 Pa*N/m").endurance_limit
    10000000000.0
    """

    quantity: ClassVar[str] = "ruiz_damage"
    source: ClassVar[str] = f"{_RUIZ}: sigma tau delta"

    endurance_limit: OptionalSIField = OptionalSIField(
        "Pa*N/m", above=0.0, description="limit of the measure"
    )
