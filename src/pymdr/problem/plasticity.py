"""Bodies that yield."""

from __future__ import annotations

from dataclasses import dataclass, field

from pymdr.errors import ProblemError
from pymdr.problem.materials import Material
from pymdr.problem.values import OptionalSIField as OptionalSIField
from pymdr.problem.values import SIField
from pymdr.units import shown


@dataclass(frozen=True, eq=False, repr=False)
class ElasticPlastic(Material):
    """
    An elastic, ideally plastic ball pressed on a rigid flat (Zunker and Kamrin 2024).

    Its contact is that of an elastic ball until the mean pressure of Hertz, 4 E_eff sqrt(d/R) / (3 pi), reaches
    p_Y = Y (1 + 1.75 exp(-4.4 d_max/R)). From there the pressure at the largest indentation d_max is p_Y everywhere in the
    contact, and unloading and reloading follow an elastic line of elliptic shape.

    Parameters
    ----------
    young : quantity
        Young's modulus E in Pa, above 0.
    poisson : quantity
        Poisson's ratio, -1 < nu <= 0.5.
    yield_strength : quantity
        Yield strength Y in uniaxial tension in Pa, above 0.
    apparent_radius : bool
        By keyword: whether the radius of the ball grows with its plastic volume. The rows of a path are then the steps of a
        particle code, because the growth is averaged over ten rows: the result depends on their number. Impacts take the
        limit of many.
    wall_factor : bool
        By keyword: whether the force is multiplied by 1 + exp(10.7 d/R - 10), the stiffening of a ball between rigid walls.
    thermal_conductivity, resistivity, thermal_diffusivity : quantity, optional
        By keyword, in W/(m K), ohm m and m^2/s.

    Notes
    -----
    The body is the ball of a :class:`Sphere` or :class:`Paraboloid`; the flat counterbody is :class:`Rigid`.

    References
    ----------
    - Zunker and Kamrin (2024), J. Mech. Phys. Solids 183, 105492, doi:10.1016/j.jmps.2023.105492 (part I), and 105493,
      doi:10.1016/j.jmps.2023.105493 (part II).

    Examples
    --------
    >>> import pymdr as mdr
    >>> copper = mdr.ElasticPlastic("120 GPa", 0.34, yield_strength="200 MPa")
    >>> ball = mdr.Contact(mdr.Sphere("1 mm"), copper)
    >>> pressed = mdr.solve(ball, mdr.indent("10 um") >> mdr.indent(0.0))
    >>> round(float(pressed.to("residual_indentation", "um")[-1]), 3)
    9.027
    """

    young: SIField = SIField("Pa", above=0.0, description="Young's modulus")
    poisson: SIField = SIField("", above=-1.0, at_most=0.5, description="Poisson's ratio")
    yield_strength: SIField = SIField("Pa", above=0.0, description="yield strength in uniaxial tension")
    apparent_radius: bool = field(
        default=False,
        metadata={
            "description": "whether the radius grows with the plastic volume; rows are then steps of a particle code"
        },
    )
    wall_factor: bool = field(
        default=False, metadata={"description": "whether the force is multiplied by 1 + exp(10.7 d/R - 10)"}
    )

    def __post_init__(self) -> None:
        for name in ("apparent_radius", "wall_factor"):
            value = getattr(self, name)
            if not isinstance(value, bool):
                raise ProblemError(f"{name} = {shown(value)}: True or False is needed")

    @property
    def shear(self) -> float:
        """Shear modulus G = E / (2 (1 + nu)) in Pa."""
        return self.young / (2.0 * (1.0 + self.poisson))

    @property
    def effective_modulus(self) -> float:
        """E_eff = E / (1 - nu^2) in Pa, against a rigid body."""
        return self.young / (1.0 - self.poisson**2)
