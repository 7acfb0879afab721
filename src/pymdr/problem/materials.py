"""Materials of the two bodies."""

from __future__ import annotations

import sys
from abc import ABC
from copy import copy
from dataclasses import KW_ONLY, InitVar, dataclass, fields
from typing import NamedTuple

from pymdr.errors import ProblemError
from pymdr.problem.rheology import Rheology
from pymdr.problem.values import OptionalSIField, SIField, Value
from pymdr.units import QuantityLike, shown


class _BodyField(OptionalSIField):
    """A field of all bodies, which refuses in the name of the one that it is given to."""

    def __set__(self, instance: object, value: QuantityLike | None) -> None:
        if value is not None:
            own = copy(self)
            own.owner = type(instance).__name__
            value = own.read(value)
        instance.__dict__[self.name] = value


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Material(Value, ABC):
    """
    One of the two bodies; what its surface does is in `mapping/moduli.py`.

    Parameters
    ----------
    thermal_conductivity : quantity, optional
        How it conducts heat, lambda in W/(m K), above 0.
    resistivity : quantity, optional
        How it resists a current, rho in ohm m, above 0.
    thermal_diffusivity : quantity, optional
        How fast heat spreads in it, kappa in m^2/s, above 0.

    Notes
    -----
    A body that conducts otherwise along its surface than along its axis conducts through a contact as one of the
    geometric mean of both: sqrt(lambda_plane lambda_axis).

    Examples
    --------
    >>> Rigid(resistivity="17 nohm m")
    Rigid(resistivity=1.7e-08)
    """

    thermal_conductivity: OptionalSIField = _BodyField("W/(m*K)", above=0.0, words="thermal conductivity")
    resistivity: OptionalSIField = _BodyField("ohm*m", above=0.0, words="electrical resistivity")
    thermal_diffusivity: OptionalSIField = _BodyField("m^2/s", above=0.0, words="thermal diffusivity")

    def __repr__(self) -> str:
        names = sorted((f.name for f in fields(self)), key=lambda name: name in Material.__dataclass_fields__)
        given = ((name, getattr(self, name)) for name in names)
        told = ", ".join(f"{name}={value!r}" for name, value in given if value is not None)
        return f"{type(self).__name__}({told})"

    @property
    def homogeneous(self) -> bool:
        """Whether it is the same at every depth."""
        return self.grading == 0.0 and self.half_space

    @property
    def grading(self) -> float:
        """The power of the depth with which its stiffness grows; 0 for homogeneous bodies."""
        return 0.0

    @property
    def remembers(self) -> bool:
        """Whether its stress depends on how it was strained before."""
        return False

    @property
    def half_space(self) -> bool:
        """Whether it is one, whose springs on the line know nothing of one another."""
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
        By keyword, in m, above 0: how thick it really is, bonded to a rigid base. It is solved as a half-space all the same, and
        claims tell the error of that, up to 10 %; :class:`~pymdr.Layered` is solved as what it is.
    thermal_conductivity, resistivity, thermal_diffusivity : quantity, optional
        By keyword, in W/(m K), ohm m and m^2/s: what it conducts.

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
    _: KW_ONLY
    thickness: OptionalSIField = OptionalSIField("m", above=0.0, words="thickness on a rigid base")

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
        By keyword, in W/(m K), ohm m and m^2/s: what it conducts.

    Examples
    --------
    >>> Rigid() == Rigid()
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
        Shear modulus of planes that hold the axis in Pa, above 0.
    thermal_conductivity, resistivity, thermal_diffusivity : quantity, optional
        By keyword, in W/(m K), ohm m and m^2/s: what it conducts.

    Raises
    ------
    ProblemError
        If neither the five stiffnesses nor the five engineering constants are given, or some of both; if a value is
        outside its limits, or the stiffnesses are not positive definite.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> zinc = TransverselyIsotropic(c11="161 GPa", c33="61 GPa", c13="50.1 GPa", c44="38.3 GPa", c66="63.4 GPa")
    >>> round(zinc.axial_modulus / 1e9, 3)
    35.283
    """

    c11: OptionalSIField = OptionalSIField("Pa", above=0.0, words="stiffness along the surface")
    c33: OptionalSIField = OptionalSIField("Pa", above=0.0, words="stiffness along the axis")
    c13: OptionalSIField = OptionalSIField("Pa", words="stiffness between surface and axis")
    c44: OptionalSIField = OptionalSIField("Pa", above=0.0, words="shear stiffness along the axis")
    c66: OptionalSIField = OptionalSIField("Pa", above=0.0, words="shear stiffness along the surface")
    young_plane: OptionalSIField = OptionalSIField("Pa", above=0.0, words="Young's modulus along the surface")
    young_axis: OptionalSIField = OptionalSIField("Pa", above=0.0, words="Young's modulus along the axis")
    poisson_plane: OptionalSIField = OptionalSIField(
        "", above=-1.0, below=1.0, words="Poisson's ratio along the surface"
    )
    poisson_axis: OptionalSIField = OptionalSIField(
        "", words="contraction along the surface over extension along the axis"
    )
    shear_axis: OptionalSIField = OptionalSIField("Pa", above=0.0, words="shear modulus along the axis")

    def __post_init__(self) -> None:
        given = [[n for n in names if getattr(self, n) is not None] for names in (_STIFFNESSES, _ENGINEERING)]
        if all(given) or not any(given):
            found = f"{given[0][0]} and {given[1][0]} are of two sets" if all(given) else "nothing is given"
            raise ProblemError(
                f"TransverselyIsotropic: {found}; give the stiffnesses {', '.join(_STIFFNESSES)}, or "
                f"the engineering constants {', '.join(_ENGINEERING)}"
            )
        names = _STIFFNESSES if given[0] else _ENGINEERING
        missing = [name for name in names if getattr(self, name) is None]
        if missing:
            raise ProblemError(
                f"TransverselyIsotropic: {' and '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing; "
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
                f"TransverselyIsotropic: the stiffnesses are not positive definite: c11 = {c11:.6g} Pa must exceed "
                f"c66 = {c66:.6g} Pa"
            )
        if not (c11 - c66) * c33 > c13**2:
            raise ProblemError(
                "TransverselyIsotropic: the stiffnesses are not positive definite: (c11 - c66) c33 = "
                f"{(c11 - c66) * c33:.6g} Pa^2 must exceed c13^2 = {c13**2:.6g} Pa^2"
            )

    def _check_engineering(self) -> None:
        young_plane, young_axis, poisson_plane, poisson_axis, _ = self._engineering
        if self._spare_volume < -_ROUNDING:
            largest = (1.0 - poisson_plane) * young_axis / (2.0 * young_plane)
            raise ProblemError(
                "TransverselyIsotropic: the stiffnesses are not positive definite: poisson_axis^2 = "
                f"{poisson_axis**2:.6g} must be at most (1 - poisson_plane) young_axis / (2 young_plane) = {largest:.6g}"
            )

    @property
    def _engineering(self) -> tuple[float, ...]:
        return tuple(getattr(self, name) for name in _ENGINEERING)

    @property
    def _spare_volume(self) -> float:
        """How far poisson_axis is from its limit, 1 - 2 nu_a^2 E_p / ((1 - nu_p) E_a)."""
        young_plane, young_axis, poisson_plane, poisson_axis, _ = self._engineering
        return 1.0 - 2.0 * poisson_axis**2 * (young_plane / young_axis) / (1.0 - poisson_plane)

    @property
    def stiffnesses(self) -> Stiffnesses:
        """
        The five stiffnesses in Pa, whichever set is given.

        Those of a body that keeps its volume are as large as rounding lets them be.
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
        The depth in m at which it is given, above 0.
    exponent : quantity
        Above -1 and below 1; 0 is a homogeneous body.
    poisson : quantity
        Poisson's ratio at every depth, -1 < nu <= 0.5.
    thermal_conductivity, resistivity, thermal_diffusivity : quantity, optional
        By keyword, in W/(m K), ohm m and m^2/s: what it conducts.

    Raises
    ------
    ProblemError
        If a value is outside its limits.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> Graded("10 MPa", depth="1 mm", exponent=0.5, poisson=0.3).depth
    0.001
    """

    young: SIField = SIField("Pa", above=0.0, words="Young's modulus at the depth")
    depth: SIField = SIField("m", above=0.0, words="depth at which the modulus is given")
    exponent: SIField = SIField("", above=-1.0, below=1.0, words="exponent of the modulus over the depth")
    poisson: SIField = SIField("", above=-1.0, at_most=0.5, words="Poisson's ratio")

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
        How it relaxes in shear, G(t).
    poisson : quantity, optional
        Poisson's ratio where it is the same at all times, -1 < nu <= 0.5.
    bulk : quantity, optional
        Bulk modulus in Pa where it is the same at all times, above 0. Exactly one of the two is given.
    young : Prony, Maxwell, StandardSolid, KelvinVoigt or PowerLawRheology, optional
        Instead of `shear`, how it relaxes in tension, E(t) = 2 (1 + nu) G(t); with poisson only. The body keeps it as `shear`.
    thermal_conductivity, resistivity, thermal_diffusivity : quantity, optional
        By keyword, in W/(m K), ohm m and m^2/s: what it conducts.

    Raises
    ------
    ProblemError
        If a value is outside its limits, `shear` is no rheology, or both or none of poisson and bulk are given.
    UnitError
        If a text is not a quantity of the right kind.

    Examples
    --------
    >>> from pymdr.problem.rheology import StandardSolid
    >>> Viscoelastic(StandardSolid("1 MPa", "3 MPa", "10 ms"), poisson=0.5).poisson
    0.5
    >>> Viscoelastic(young=StandardSolid("3 MPa", "9 MPa", "10 ms"), poisson=0.5).shear.equilibrium
    1000000.0
    """

    shear: Rheology = None  # type: ignore[assignment]  # where young is given
    poisson: OptionalSIField = OptionalSIField(
        "", above=-1.0, at_most=0.5, words="Poisson's ratio at all times"
    )
    bulk: OptionalSIField = OptionalSIField("Pa", above=0.0, words="bulk modulus at all times")
    young: InitVar[Rheology | None] = None

    def __post_init__(self, young: Rheology | None) -> None:
        if young is not None:
            self._take_young(young)
        if not isinstance(self.shear, Rheology):
            raise ProblemError(
                f"Viscoelastic.shear = {shown(self.shear)}: a rheology such as StandardSolid('1 MPa', '3 MPa', '10 ms') "
                "is needed"
            )
        if (self.poisson is None) == (self.bulk is None):
            found = "neither poisson nor bulk is" if self.poisson is None else "both poisson and bulk are"
            raise ProblemError(
                f"Viscoelastic: {found} given; give poisson = 0.5 for a body that keeps its volume, or the one of the "
                "two that does not change in time"
            )

    def _take_young(self, young: Rheology) -> None:
        if self.shear is not None:
            raise ProblemError(
                "Viscoelastic: both shear and young are given; give one of them, young = 2 (1 + nu) times shear"
            )
        if not isinstance(young, Rheology):
            raise ProblemError(
                f"Viscoelastic.young = {shown(young)}: a rheology such as StandardSolid('1 MPa', '3 MPa', '10 ms') is needed"
            )
        if self.poisson is None:
            raise ProblemError(
                "Viscoelastic: young is given without poisson, which E = 2 (1 + nu) G needs; give poisson, or shear with bulk"
            )
        object.__setattr__(self, "shear", young.scaled(0.5 / (1.0 + self.poisson)))

    @property
    def remembers(self) -> bool:
        """True."""
        return True


def common_exponent(body: Material, counterbody: Material) -> float:
    """
    Exponent of the grading that two bodies share; homogeneous bodies have 0, rigid ones any.

    Parameters
    ----------
    body, counterbody : Elastic, TransverselyIsotropic, Graded, Viscoelastic or Rigid

    Returns
    -------
    float

    Raises
    ------
    ProblemError
        If the exponents differ, both bodies are rigid, or one is no material.

    Examples
    --------
    >>> common_exponent(Graded("1 MPa", "1 mm", 0.2, 0.5), Rigid())
    0.2
    """
    for one in (body, counterbody):
        if not isinstance(one, Material):
            raise ProblemError(f"{one!r}: a material such as Elastic('210 GPa', 0.3) is needed")
    exponents = [one.grading for one in (body, counterbody) if not isinstance(one, Rigid)]
    if not exponents:
        raise ProblemError("both bodies are rigid; at least one must be elastic")
    if exponents[0] != exponents[-1]:
        raise ProblemError(
            f"bodies that are graded with the exponents {exponents[0]:g} and {exponents[-1]:g} (0 is homogeneous) "
            "share no line of springs, whose stiffness grows with one power of x; give both the same exponent, or take "
            "the stiffer one as Rigid()"
        )
    return exponents[0]
