"""The contact: a profile pressed between two bodies."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from pymdr.errors import ProblemError
from pymdr.problem.laws import JKR, AdhesionLaw, Coulomb
from pymdr.problem.layers import Layered
from pymdr.problem.materials import Material, Rigid, common_exponent
from pymdr.problem.plasticity import ElasticPlastic
from pymdr.problem.profiles import ForceCurve, Paraboloid, Profile, Shape, Sphere
from pymdr.problem.values import Value
from pymdr.units import metres, shown


@dataclass(frozen=True, eq=False)
class Contact(Value):
    """
    A contact of two bodies: axisymmetric, of any shape without friction, or given by a force curve.

    Parameters
    ----------
    profile : Profile
        The combined initial gap f(r), a :class:`~pymdr.ForceCurve`, or a gap f(x, y) without axial symmetry, such as
        :class:`~pymdr.EllipticParaboloid`.
    body : Elastic, TransverselyIsotropic, Graded, Layered, Viscoelastic, ElasticPlastic or Rigid
        The first body. An ElasticPlastic body is a ball of the radius of the profile.
    counterbody : Elastic, TransverselyIsotropic, Graded, Layered, Viscoelastic, ElasticPlastic or Rigid
        The second body, by default rigid. A graded body needs a rigid one or one of the same exponent; a layered body needs one
        without grading and memory, an ElasticPlastic body a rigid one.
    adhesion : JKR, MaugisDugdale, Capillary or DMT, optional
        Law of adhesion; by default none.
    friction : Coulomb, optional
        Law of friction of elastic and viscoelastic bodies; by default frictionless. With adhesion only
        ``Coulomb(math.inf)``, under JKR of one work on homogeneous elastic bodies.

    Raises
    ------
    ProblemError
        If an argument is of the wrong kind, both bodies are rigid or of different exponents, adhesion is combined with
        finite friction or, without slip, with a law other than JKR of one work, a graded or layered body with friction or MaugisDugdale, a layered body with a viscoelastic one,
        viscoelastic layers with adhesion or a counterbody that is not rigid, a viscoelastic body with JKR or DMT, an ElasticPlastic body with anything but a Sphere or Paraboloid, a rigid
        counterbody and adhesion by JKR of one work, a ForceCurve with adhesion or a graded or layered body, or a shape
        without axial symmetry with anything but elastic half-spaces.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("210 GPa", 0.3)).counterbody
    Rigid()
    """

    profile: Profile
    body: Material
    counterbody: Material = field(default_factory=Rigid)
    adhesion: AdhesionLaw | None = None
    friction: Coulomb | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.profile, Profile):
            raise ProblemError(f"profile = {self.profile!r}: a profile such as Sphere('10 mm') is needed")
        for name in ("body", "counterbody"):
            material = getattr(self, name)
            if not isinstance(material, Material):
                raise ProblemError(
                    f"{name} = {material!r}: a material such as Elastic('210 GPa', 0.3) is needed"
                )
        exponent = common_exponent(self.body, self.counterbody)
        if not isinstance(self.adhesion, AdhesionLaw | None):
            raise ProblemError(f"adhesion = {self.adhesion!r}: a law such as JKR('50 mJ/m^2') is needed")
        if not isinstance(self.friction, Coulomb | None):
            raise ProblemError(f"friction = {self.friction!r}: a law such as Coulomb(0.3) is needed")
        if self.adhesion is not None and self.friction is not None:
            self._refuse_sliding_adhesion(self.adhesion, self.friction)
        if isinstance(self.profile, ForceCurve):
            self._refuse_beyond_curve(exponent)
        if isinstance(self.profile, Shape):
            self._refuse_beyond_shape(exponent)
        if self.plastic is not None:
            self._refuse_beyond_yield(self.plastic)
        if self.is_viscoelastic and self.layered is None:
            self._refuse_memory()
        elif isinstance(self.adhesion, JKR) and self.adhesion.range is not None:
            raise ProblemError(
                f"adhesion range = {metres(self.adhesion.range)} has no effect on bodies without memory, whose adhesion of short range does not depend "
                "on it; leave it out, or use MaugisDugdale(work, range=...)"
            )
        if self.layered is not None:
            self._refuse_beyond_layers()
        if exponent != 0.0 and self.friction is not None:
            raise ProblemError(
                f"friction of a graded body (exponent {exponent:g}) is not available: its tangential displacements are not "
                "proportional to its normal ones, and the error of the theory of Cattaneo and Mindlin is not known; leave "
                "friction out, or give exponent 0"
            )
        if exponent != 0.0 and self.is_cohesive:
            raise ProblemError(
                f"{type(self.adhesion).__name__} is not derived for a graded body (exponent {exponent:g}), only for "
                "homogeneous ones; use JKR for soft and large bodies, DMT for stiff and small ones"
            )

    def _refuse_sliding_adhesion(self, adhesion: AdhesionLaw, friction: Coulomb) -> None:
        """Adhesion bears shear without slip only: Coulomb's limit is not defined under tension."""
        if friction.coefficient != math.inf:
            raise ProblemError(
                f"adhesion with friction is not covered by the theory at a coefficient of {friction.coefficient:g}, because Coulomb's limit "
                "is not defined under tension; use Coulomb(math.inf) for JKR without slip, or leave one of the two out"
            )
        why = ""
        if not isinstance(adhesion, JKR):
            why = f"{type(adhesion).__name__} has no law for the shear of its zone; use JKR(work)"
        elif adhesion.has_hysteresis:
            why = "it is derived for one work of adhesion; use JKR(work)"
        elif self.is_viscoelastic:
            why = "it is derived for elastic bodies; use Elastic with the stiffness at one time"
        if why:
            raise ProblemError(f"adhesion with friction, full stick under shear: {why}")

    @property
    def is_viscoelastic(self) -> bool:
        """Whether one of the bodies is viscoelastic."""
        return self.body.is_viscoelastic or self.counterbody.is_viscoelastic

    @property
    def is_cohesive(self) -> bool:
        """Whether a constant stress attracts the surfaces up to a range."""
        return self.adhesion is not None and self.adhesion.cohesive_stress is not None

    @property
    def has_edge_history(self) -> bool:
        """Whether the edge of an adhesive contact depends on its history, by memory of the bodies or hysteresis of adhesion."""
        return self.adhesion is not None and (self.is_viscoelastic or self.adhesion.has_hysteresis)

    @property
    def layered(self) -> Layered | None:
        """The layered body, the first if both are; None without one."""
        return next((body for body in (self.body, self.counterbody) if isinstance(body, Layered)), None)

    @property
    def plastic(self) -> ElasticPlastic | None:
        """The body that yields; None without one."""
        bodies = (self.body, self.counterbody)
        return next((body for body in bodies if isinstance(body, ElasticPlastic)), None)

    def _refuse_beyond_yield(self, body: ElasticPlastic) -> None:
        other = self.counterbody if self.body is body else self.body
        adhesion = self.adhesion
        for present, reason in (
            (
                type(self.profile) not in (Sphere, Paraboloid),
                f"the model was fitted for balls, and {type(self.profile).__name__} is not one; give Sphere('1 mm') or Paraboloid('1 mm')",
            ),
            (
                not isinstance(other, Rigid),
                f"the model was fitted for balls on a rigid flat, and the other body is {type(other).__name__}; use Rigid()",
            ),
            (
                self.friction is not None,
                "friction of a body that yields is not available, because the model gives no tangential springs; leave it out",
            ),
            (
                adhesion is not None and (type(adhesion) is not JKR or adhesion.has_hysteresis),
                "the model has adhesion of short range with one work of adhesion only; use JKR(work), or leave adhesion out",
            ),
            (
                adhesion is not None and (body.apparent_radius or body.wall_factor),
                "adhesion is not available with apparent_radius or wall_factor; leave one of them out",
            ),
        ):
            if present:
                raise ProblemError(f"a body is ElasticPlastic: {reason}")

    def _refuse_beyond_layers(self) -> None:
        assert self.layered is not None
        if self.is_viscoelastic and not self.layered.is_viscoelastic:
            raise ProblemError(
                "a layered body against a viscoelastic one is not available: their surfaces relax differently at every "
                "wavelength, so the springs have no common relaxation function; use Elastic with the stiffness at one time"
            )
        other = self.counterbody if self.layered is self.body else self.body
        if self.is_viscoelastic and not isinstance(other, Rigid):
            raise ProblemError(
                f"viscoelastic layers need a rigid other body, not {type(other).__name__}: else both surfaces relax differently at "
                "every wavelength, and the springs have no common relaxation function; use Rigid(), or Elastic with the stiffness at one time"
            )
        if self.is_viscoelastic and self.adhesion is not None:
            raise ProblemError(
                f"{type(self.adhesion).__name__} of viscoelastic layers is not available: the cohesive zone of a layered body is "
                "not local on the line; leave adhesion out, or use a half-space"
            )
        if isinstance(self.profile, ForceCurve):
            raise ProblemError(
                "a ForceCurve needs homogeneous half-spaces, but a body is layered; give the shape as a profile"
            )
        if self.friction is not None:
            raise ProblemError(
                "friction of a layered body is not available: its tangential displacements are not proportional to its "
                "normal ones, and the error of the theory of Cattaneo and Mindlin is not known; leave friction out, or use "
                "Elastic for the body"
            )
        if self.is_cohesive:
            raise ProblemError(
                f"{type(self.adhesion).__name__} is not derived for a layered body, only for homogeneous "
                "ones; use JKR for soft and large bodies, DMT for stiff and small ones"
            )

    def _refuse_beyond_curve(self, exponent: float) -> None:
        if self.adhesion is not None:
            raise ProblemError(
                "a ForceCurve cannot have adhesion, which acts at the edges of the true contact; give the shape as a "
                "profile, or leave adhesion out"
            )
        if exponent != 0.0:
            raise ProblemError(
                f"a ForceCurve needs homogeneous half-spaces, but a body is graded (exponent {exponent:g}); "
                "give exponent 0, or the shape as a profile"
            )

    def _refuse_beyond_shape(self, exponent: float) -> None:
        name = type(self.profile).__name__
        by_curve = "solve the frictionless elastic contact, and use the force_curve() of its result instead of the shape"
        for feature, present, remedy in (
            ("adhesion", self.adhesion is not None, "leave adhesion out, or give an axisymmetric profile"),
            ("friction", self.friction is not None, by_curve),
            ("a viscoelastic body", self.is_viscoelastic, by_curve),
            ("a Layered body", self.layered is not None, "give a half-space, or an axisymmetric profile"),
            (
                f"a graded body (exponent {exponent:g})",
                exponent != 0.0,
                "give exponent 0, or an axisymmetric profile",
            ),
        ):
            if present:
                raise ProblemError(f"{name} is not axisymmetric, so {feature} is not available; {remedy}")

    def _refuse_memory(self) -> None:
        if self.adhesion is None or self.is_cohesive:
            return
        if isinstance(self.adhesion, JKR) and self.adhesion.range is not None:
            return
        name = type(self.adhesion).__name__
        raise ProblemError(
            f"{name} of a viscoelastic body has no limit of short range: the pull grows without bound as the range of the "
            "attraction decreases; use MaugisDugdale(work, range=...) with the range of the surfaces (0.3 nm to some um for polymers), "
            "JKR(work, range=...) where that is short, or Elastic with the stiffness at one time"
        )


def require_contact(contact: object) -> Contact:
    """The contact; a value that is not one is refused."""
    if not isinstance(contact, Contact):
        raise ProblemError(f"{shown(contact)} is not a Contact; write Contact(profile, body)")
    return contact


def is_curve(contact: Contact) -> bool:
    """Whether a contact is known by its force curve."""
    return isinstance(contact.profile, ForceCurve)


def refuse_curve(contact: Contact, why: str) -> None:
    """Refuse contacts that are known by a force curve only, and values that are not contacts."""
    require_contact(contact)
    if is_curve(contact):
        raise ProblemError(
            f"the contact is known by its ForceCurve only, and {why}; give the shape itself as a profile"
        )
