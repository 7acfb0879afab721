"""Adhesion by menisci of a liquid that condenses from its vapour."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pymdr.errors import ProblemError
from pymdr.problem.laws import AdhesionLaw
from pymdr.problem.values import OptionalSIField, SIField
from pymdr.units import written

_GAS = 8.314462618
"""Molar gas constant in J/(mol K)."""
_MOLAR_MASS = 18.01528e-3
"""Of water in kg/mol."""
_CRITICAL = 647.096
"""Critical temperature of water in K."""
_ROOM_TEMPERATURE = 293.15
_COLDEST, _HOTTEST = 273.15, 423.15
_DENSITY = (999.83952, 16.945176, -7.9870401e-3, -46.170461e-6, 105.56302e-9, -280.54253e-12)


def water_surface_tension(temperature: float) -> float:
    """
    Surface tension of water against its vapour.

    Parameters
    ----------
    temperature : float
        In K.

    Returns
    -------
    float
        In N/m; 235.8 mN/m (1 - T/T_c)^1.256 (1 - 0.625 (1 - T/T_c)).

    Notes
    -----
    IAPWS R1-76 (2014), uncertainty 0.5 %.

    Examples
    --------
    >>> round(1e3 * water_surface_tension(298.15), 2)
    71.97
    """
    distance = 1.0 - temperature / _CRITICAL
    return 235.8e-3 * math.pow(distance, 1.256) * (1.0 - 0.625 * distance)


def water_molar_volume(temperature: float) -> float:
    """
    Molar volume of liquid water at atmospheric pressure.

    Parameters
    ----------
    temperature : float
        In K.

    Returns
    -------
    float
        In m^3/mol.

    Notes
    -----
    Kell (1975), J. Chem. Eng. Data 20, 97-105, for 0 to 150 degC.

    Examples
    --------
    >>> round(_MOLAR_MASS / water_molar_volume(293.15), 2)
    998.2
    """
    t = temperature - 273.15
    density = sum(c * t**n for n, c in enumerate(_DENSITY)) / (1.0 + 16.879850e-3 * t)
    return _MOLAR_MASS / density


@dataclass(frozen=True, eq=False)
class Capillary(AdhesionLaw):
    """
    Adhesion by the meniscus of a liquid in equilibrium with its vapour, in contact with humid air.

    Exactly one of humidity and kelvin_radius is needed. Values that are not given are those of water.

    Parameters
    ----------
    surface_tension : quantity, optional
        Surface tension gamma_L of the liquid in N/m, above 0.
    contact_angle : quantity, optional
        Contact angle theta of the liquid on both surfaces in rad, at least 0 and below 90 deg; 0 (complete wetting) by default.
    humidity : quantity, optional
        Relative humidity p/p_s of the vapour, above 0 and below 1.
    kelvin_radius : quantity, optional
        Radius r_K of the meniscus in m, above 0.
    temperature : quantity, optional
        In K, above 0; 20 degC by default.
    molar_volume : quantity, optional
        Molar volume V_m of the liquid in m^3/mol, above 0.
    volume : quantity, optional
        Refused: a meniscus of fixed volume follows another law.

    Raises
    ------
    ProblemError
        If neither or both of humidity and kelvin_radius are given, a value is outside its limits, water is not liquid at the
        temperature, or a volume is given.

    See Also
    --------
    MaugisDugdale : the law of a constant stress up to a range, which this is.

    Notes
    -----
    The meniscus pulls with the stress sigma_0 = gamma_L / r_K where the gap is below h_0 = 2 r_K cos(theta) (Maugis and
    Gauthier-Manuel 1994), so its work of adhesion is 2 gamma_L cos(theta) at any humidity. Kelvin's equation gives
    r_K = gamma_L V_m / (R_gas T ln(1/humidity)). Water: surface tension by IAPWS R1-76, density by Kell (1975).

    References
    ----------
    - Maugis and Gauthier-Manuel (1994), J. Adhes. Sci. Technol. 8, 1311-1322.
    - Kell (1975), J. Chem. Eng. Data 20, 97-105.

    Examples
    --------
    >>> import pymdr as mdr
    >>> humid = mdr.Capillary(humidity=0.5, contact_angle="30 deg")
    >>> round(1e9 * humid.radius, 3), round(1e3 * humid.work, 1)
    (0.777, 126.0)
    """

    surface_tension: OptionalSIField = OptionalSIField(
        "N/m", above=0.0, description="surface tension of the liquid"
    )
    contact_angle: SIField = SIField(
        "rad", at_least=0.0, below=0.5 * math.pi, default=0.0, description="contact angle of the liquid"
    )
    humidity: OptionalSIField = OptionalSIField(
        "", above=0.0, below=1.0, description="relative humidity of the vapour"
    )
    kelvin_radius: OptionalSIField = OptionalSIField("m", above=0.0, description="radius of the meniscus")
    temperature: SIField = SIField("K", above=0.0, default=_ROOM_TEMPERATURE, description="temperature")
    molar_volume: OptionalSIField = OptionalSIField(
        "m^3/mol", above=0.0, description="molar volume of the liquid"
    )
    volume: OptionalSIField = OptionalSIField(
        "m^3", above=0.0, description="refused: a fixed volume is another law"
    )

    def __post_init__(self) -> None:
        if self.volume is not None:
            raise ProblemError(
                f"volume = {written(self.volume, 'm^3')}: a meniscus of fixed volume pulls with a stress that changes with "
                "the gap, which is another law and not available; give humidity= or kelvin_radius= of a meniscus in equilibrium "
                "with its vapour"
            )
        if (self.humidity is None) == (self.kelvin_radius is None):
            given = "neither" if self.humidity is None else "both"
            raise ProblemError(
                f"{given} of humidity and kelvin_radius given; name exactly one, for example Capillary(humidity=0.5)"
            )
        of_water = self.surface_tension is None or (self.humidity is not None and self.molar_volume is None)
        if of_water and not _COLDEST <= self.temperature <= _HOTTEST:
            raise ProblemError(
                f"temperature = {written(self.temperature, 'K', 6)}: the constants of water are known from {_COLDEST} K to "
                f"{_HOTTEST} K; give surface_tension, and molar_volume with humidity"
            )

    @property
    def tension(self) -> float:
        """Surface tension in N/m: the given one, or that of water."""
        return (
            water_surface_tension(self.temperature) if self.surface_tension is None else self.surface_tension
        )

    @property
    def radius(self) -> float:
        """Radius of the meniscus in m: the given one, or that of Kelvin's equation."""
        if self.kelvin_radius is not None:
            return self.kelvin_radius
        assert self.humidity is not None
        volume = water_molar_volume(self.temperature) if self.molar_volume is None else self.molar_volume
        return self.tension * volume / (_GAS * self.temperature * -math.log(self.humidity))

    @property
    def range(self) -> float:
        """Largest gap of the meniscus in m, 2 r_K cos(theta)."""
        return 2.0 * self.radius * math.cos(self.contact_angle)

    @property
    def work(self) -> float:  # type: ignore[override]
        """Work of adhesion in J/m^2, 2 gamma_L cos(theta)."""
        return 2.0 * self.tension * math.cos(self.contact_angle)

    @property
    def cohesive_stress(self) -> float:
        """Pressure below that of the air in the meniscus in Pa, gamma_L / r_K."""
        return self.tension / self.radius
