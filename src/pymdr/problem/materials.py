"""Materials of the two bodies."""

from __future__ import annotations

import sys
from abc import ABC
from dataclasses import KW_ONLY, InitVar, dataclass, fields
from typing import NamedTuple

from pymdr.errors import ProblemError
from pymdr.problem.rheology import Rheology
from pymdr.problem.values import OptionalSIField, SIField, Value
from pymdr.units import shown


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Material(Value, ABC):
    """
    One of the two bodies; its moduli are in `mapping/moduli.py`.

    Parameters
    ----------
    thermal_conductivity : quantity, optional
        Thermal conductivity lambda in W/(m K), above 0.
    resistivity : quantity, optional
        Electrical resistivity rho in ohm m, above 0.
    thermal_diffusivity : quantity, optional
        Thermal diffusivity kappa in m^2/s, above 0.

    Notes
    -----
    For a body that conducts differently along its surface and its axis, give the geometric mean
    sqrt(lambda_plane lambda_axis).

    Examples
    --------
    >>> Rigid(resistivity="17 nohm m")
    Rigid(resistivity=1.7e-08)
    """

    thermal_conductivity: OptionalSIField = OptionalSIField(
        "W/(m*K)", above=0.0, description="thermal conductivity"
    )
    resistivity: OptionalSIField = OptionalSIField("ohm*m", above=0.0, description="electrical resistivity")
    thermal_diffusivity: OptionalSIField = OptionalSIField(
        "m^2/s", above=0.0, description="thermal diffusivity"
    )

    def __repr__(self) -> str:
        names = sorted((f.name for f in fields(self)), key=lambda name: name in Material.__dataclass_fields__)
        given = ((name, getattr(self, name)) for name in names)
        arguments = ", ".join(f"{name}={value!r}" for name, value in given if value is not None)
        return f"{type(self).__name__}({arguments})"

    @property
    def homogeneous(self) -> bool:
        """Whether it is the same at every depth."""
        return self.grading == 0.0 and self.half_space

    @property
    def grading(self) -> float:
        """Exponent of the depth in its modulus; 0 for homogeneous bodies."""
        return 0.0

    @property
    def is_viscoelastic(self) -> bool:
        """Whether it is viscoelastic: its stress depends on the strain history."""
        return False

    @property
    def half_space(self) -> bool:
        """Whether it is a half-space, whose springs on the line are independent."""
        return True


@dataclass(frozen=True, eq=False, repr=False)
class Elastic(Material):
    """
    An isotropic linear-elastic half-space.

    Parameters
    ----------
    young : quantity
        Young's modulus E in Pa, above 0.
    poisson : quantity
        Poisson's ratio, -1 < nu <= 0.5.
    thickness : quantity, optional
        By keyword: true thickness in m, above 0, on a rigid base. The body is still solved as a half-space, and the claims
        include the error of that, up to 10 %; use :class:`~pymdr.Layered` for thinner layers.
    thermal_conductivity, resistivity, thermal_diffusivity : quantity, optional
        By keyword, in W/(m K), ohm m and m^2/s.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Elastic("210 GPa", 0.3).young
    210000000000.0
    """

    young: SIField = SIField("Pa", above=0.0, description="Young's modulus")
    poisson: SIField = SIField("", above=-1.0, at_most=0.5, description="Poisson's ratio")
    _: KW_ONLY
    thickness: OptionalSIField = OptionalSIField("m", above=0.0, description="thickness on a rigid base")

    @property
    def shear(self) -> float:
        """Shear modulus G = E / (2 (1 + nu)) in Pa."""
        return self.young / (2.0 * (1.0 + self.poisson))


@dataclass(frozen=True, eq=False, repr=False)
class Rigid(Material):
    """
    A body that does not deform.

    Parameters
    ----------
    thermal_conductivity, resistivity, thermal_diffusivity : quantity, optional
        By keyword, in W/(m K), ohm m and m^2/s.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Rigid() == mdr.Rigid()
    True
    """


class Stiffnesses(NamedTuple):
    """The stiffnesses of a transversely isotropic body in Pa; 3 is its axis, 4 shear along it, 6 shear across."""

    c11: float
    c33: float
    c13: float
    c44: float
    c66: float


_STIFFNESSES = Stiffnesses._fields
_ROUNDING = 4.0 * sys.float_info.epsilon
_ENGINEERING = ("young_plane", "young_axis", "poisson_plane", "poisson_axis", "shear_axis")


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class TransverselyIsotropic(Material):
    """
    A linear-elastic half-space that is isotropic in planes along its surface; its axis is the normal.

    Parameters
    ----------
    c11, c33, c13, c44, c66 : quantity, optional
        Stiffnesses in Pa: along the surface, along the axis, between the two, in shear along the axis, and in shear
        along the surface. All above 0 but c13; c11 > c66 and (c11 - c66) c33 > c13^2.
    young_plane, young_axis : quantity, optional
        Young's moduli along the surface and along the axis in Pa, above 0.
    poisson_plane : quantity, optional
        Poisson's ratio between two directions of the surface, above -1 and below 1.
    poisson_axis : quantity, optional
        Contraction along the surface over extension along the axis, under a stress along the axis;
        poisson_axis^2 <= (1 - poisson_plane) young_axis / (2 young_plane).
    shear_axis : quantity, optional
        Shear modulus of planes that contain the axis in Pa, above 0.
    thermal_conductivity, resistivity, thermal_diffusivity : quantity, optional
        By keyword, in W/(m K), ohm m and m^2/s.

    Raises
    ------
    ProblemError
        If not exactly one complete set of five constants is given, a value is outside its limits, or the stiffnesses
        are not positive definite.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> import pymdr as mdr
    >>> zinc = mdr.TransverselyIsotropic(c11="161 GPa", c33="61 GPa", c13="50.1 GPa", c44="38.3 GPa", c66="63.4 GPa")
    >>> round(zinc.axial_modulus / 1e9, 3)
    35.283
    """

    c11: OptionalSIField = OptionalSIField("Pa", above=0.0, description="stiffness along the surface")
    c33: OptionalSIField = OptionalSIField("Pa", above=0.0, description="stiffness along the axis")
    c13: OptionalSIField = OptionalSIField("Pa", description="stiffness between surface and axis")
    c44: OptionalSIField = OptionalSIField("Pa", above=0.0, description="shear stiffness along the axis")
    c66: OptionalSIField = OptionalSIField("Pa", above=0.0, description="shear stiffness along the surface")
    young_plane: OptionalSIField = OptionalSIField(
        "Pa", above=0.0, description="Young's modulus along the surface"
    )
    young_axis: OptionalSIField = OptionalSIField(
        "Pa", above=0.0, description="Young's modulus along the axis"
    )
    poisson_plane: OptionalSIField = OptionalSIField(
        "", above=-1.0, below=1.0, description="Poisson's ratio along the surface"
    )
    poisson_axis: OptionalSIField = OptionalSIField(
        "", description="contraction along the surface over extension along the axis"
    )
    shear_axis: OptionalSIField = OptionalSIField("Pa", above=0.0, description="shear modulus along the axis")

    def __post_init__(self) -> None:
        given = [[n for n in names if getattr(self, n) is not None] for names in (_STIFFNESSES, _ENGINEERING)]
        if all(given) or not any(given):
            fault = (
                f"{given[0][0]} and {given[1][0]} belong to different sets"
                if all(given)
                else "no constants are given"
            )
            raise ProblemError(
                f"{fault}; give the stiffnesses {', '.join(_STIFFNESSES)}, or "
                f"the engineering constants {', '.join(_ENGINEERING)}"
            )
        names = _STIFFNESSES if given[0] else _ENGINEERING
        missing = [name for name in names if getattr(self, name) is None]
        if missing:
            raise ProblemError(
                f"{' and '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing; "
                f"{', '.join(names)} are needed together"
            )
        if given[0]:
            self._check_stiffnesses()
        else:
            self._check_engineering()

    def _check_stiffnesses(self) -> None:
        c11, c33, c13, _, c66 = self.stiffnesses
        if not c11 > c66:
            raise ProblemError(
                f"the stiffnesses are not positive definite: c11 = {c11:.6g} Pa must exceed "
                f"c66 = {c66:.6g} Pa"
            )
        if not (c11 - c66) * c33 > c13**2:
            raise ProblemError(
                "the stiffnesses are not positive definite: (c11 - c66) c33 = "
                f"{(c11 - c66) * c33:.6g} Pa^2 must exceed c13^2 = {c13**2:.6g} Pa^2"
            )

    def _check_engineering(self) -> None:
        young_plane, young_axis, poisson_plane, poisson_axis, _ = self._engineering
        if self._spare_volume < -_ROUNDING:
            largest = (1.0 - poisson_plane) * young_axis / (2.0 * young_plane)
            raise ProblemError(
                "the stiffnesses are not positive definite: poisson_axis^2 = "
                f"{poisson_axis**2:.6g} must be at most (1 - poisson_plane) young_axis / (2 young_plane) = {largest:.6g}"
            )

    @property
    def _engineering(self) -> tuple[float, ...]:
        return tuple(getattr(self, name) for name in _ENGINEERING)

    @property
    def _spare_volume(self) -> float:
        """Distance of poisson_axis from its limit, 1 - 2 nu_a^2 E_p / ((1 - nu_p) E_a)."""
        young_plane, young_axis, poisson_plane, poisson_axis, _ = self._engineering
        return 1.0 - 2.0 * poisson_axis**2 * (young_plane / young_axis) / (1.0 - poisson_plane)

    @property
    def stiffnesses(self) -> Stiffnesses:
        """
        The five stiffnesses in Pa, whichever set is given.

        For an incompressible body they are as large as rounding permits.
        """
        if self.c11 is not None:
            return Stiffnesses(*(getattr(self, name) for name in _STIFFNESSES))
        young_plane, young_axis, poisson_plane, poisson_axis, shear_axis = self._engineering
        c66 = young_plane / (2.0 * (1.0 + poisson_plane))
        bulk = young_plane / (2.0 * (1.0 - poisson_plane) * max(self._spare_volume, _ROUNDING))
        c13 = 2.0 * poisson_axis * bulk
        return Stiffnesses(bulk + c66, young_axis + 2.0 * poisson_axis * c13, c13, shear_axis, c66)

    @property
    def axial_modulus(self) -> float:
        """Young's modulus along the axis, c33 - c13^2 / (c11 - c66), in Pa."""
        if self.young_axis is not None:
            return self.young_axis
        c11, c33, c13, _, c66 = self.stiffnesses
        return ((c11 - c66) * c33 - c13**2) / (c11 - c66)


@dataclass(frozen=True, eq=False, repr=False)
class Graded(Material):
    """
    An elastic half-space whose Young's modulus is a power of the depth, E(z) = young (z / depth)^exponent.

    Parameters
    ----------
    young : quantity
        Young's modulus at the depth in Pa, above 0.
    depth : quantity
        Depth in m of the given modulus, above 0.
    exponent : quantity
        Above -1 and below 1; 0 is a homogeneous body.
    poisson : quantity
        Poisson's ratio at every depth, -1 < nu <= 0.5.
    thermal_conductivity, resistivity, thermal_diffusivity : quantity, optional
        By keyword, in W/(m K), ohm m and m^2/s.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Graded("10 MPa", depth="1 mm", exponent=0.5, poisson=0.3).depth
    0.001
    """

    young: SIField = SIField("Pa", above=0.0, description="Young's modulus at the depth")
    depth: SIField = SIField("m", above=0.0, description="depth at which the modulus is given")
    exponent: SIField = SIField(
        "", above=-1.0, below=1.0, description="exponent of the modulus over the depth"
    )
    poisson: SIField = SIField("", above=-1.0, at_most=0.5, description="Poisson's ratio")

    @property
    def shear(self) -> float:
        """Shear modulus at the depth, young / (2 (1 + nu)), in Pa."""
        return self.young / (2.0 * (1.0 + self.poisson))

    @property
    def grading(self) -> float:
        """The exponent."""
        return self.exponent


@dataclass(frozen=True, eq=False, repr=False)
class Viscoelastic(Material):
    """
    A linear viscoelastic half-space.

    Parameters
    ----------
    shear : Prony, Maxwell, StandardSolid, KelvinVoigt or PowerLawRheology
        Relaxation in shear, G(t).
    poisson : quantity, optional
        Poisson's ratio if constant in time, -1 < nu <= 0.5.
    bulk : quantity, optional
        Bulk modulus in Pa if constant in time, above 0. Give exactly one of poisson and bulk.
    young : Prony, Maxwell, StandardSolid, KelvinVoigt or PowerLawRheology, optional
        Relaxation in tension, E(t) = 2 (1 + nu) G(t), instead of `shear`; needs poisson. It is converted to `shear`.
    thermal_conductivity, resistivity, thermal_diffusivity : quantity, optional
        By keyword, in W/(m K), ohm m and m^2/s.

    Raises
    ------
    ProblemError
        If a value is outside its limits, `shear` is not a rheology, or not exactly one of poisson and bulk is given.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "10 ms"), poisson=0.5).poisson
    0.5
    >>> mdr.Viscoelastic(young=mdr.StandardSolid("3 MPa", "9 MPa", "10 ms"), poisson=0.5).shear.equilibrium
    1000000.0
    """

    shear: Rheology = None  # type: ignore[assignment]  # where young is given
    poisson: OptionalSIField = OptionalSIField(
        "", above=-1.0, at_most=0.5, description="Poisson's ratio at all times"
    )
    bulk: OptionalSIField = OptionalSIField("Pa", above=0.0, description="bulk modulus at all times")
    young: InitVar[Rheology | None] = None

    def __post_init__(self, young: Rheology | None) -> None:
        if young is not None:
            self._take_young(young)
        if not isinstance(self.shear, Rheology):
            raise ProblemError(
                f"shear = {shown(self.shear)}: a rheology such as StandardSolid('1 MPa', '3 MPa', '10 ms') "
                "is needed"
            )
        if (self.poisson is None) == (self.bulk is None):
            given = "neither poisson nor bulk is" if self.poisson is None else "both poisson and bulk are"
            raise ProblemError(
                f"{given} given; give the one that is constant in time, such as poisson = 0.5 for an "
                "incompressible body"
            )

    def _take_young(self, young: Rheology) -> None:
        if self.shear is not None:
            raise ProblemError("both shear and young are given; give one of them (young = 2 (1 + nu) shear)")
        if not isinstance(young, Rheology):
            raise ProblemError(
                f"young = {shown(young)}: a rheology such as StandardSolid('1 MPa', '3 MPa', '10 ms') is needed"
            )
        if self.poisson is None:
            raise ProblemError("young needs poisson (E = 2 (1 + nu) G); give poisson, or shear with bulk")
        object.__setattr__(self, "shear", young.scaled(0.5 / (1.0 + self.poisson)))

    @property
    def is_viscoelastic(self) -> bool:
        """True."""
        return True


def common_exponent(body: Material, counterbody: Material) -> float:
    """
    Common grading exponent of two bodies: 0 for homogeneous bodies, any for rigid ones.

    Examples
    --------
    >>> common_exponent(Graded("1 MPa", "1 mm", 0.2, 0.5), Rigid())
    0.2
    """
    for material in (body, counterbody):
        if not isinstance(material, Material):
            raise ProblemError(f"{material!r}: a material such as Elastic('210 GPa', 0.3) is needed")
    exponents = [material.grading for material in (body, counterbody) if not isinstance(material, Rigid)]
    if not exponents:
        raise ProblemError("both bodies are rigid; at least one must be elastic")
    if exponents[0] != exponents[-1]:
        raise ProblemError(
            f"bodies of different grading exponents, {exponents[0]:g} and {exponents[-1]:g} (0 is homogeneous), have no "
            "common line of springs; give both the same exponent, or use Rigid() for the stiffer one"
        )
    return exponents[0]
