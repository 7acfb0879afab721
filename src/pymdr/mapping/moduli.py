"""Effective moduli and conductivities of a pair of bodies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import singledispatch
from typing import Literal

from pymdr.errors import ProblemError
from pymdr.problem.layers import Layered
from pymdr.problem.materials import (
    Elastic,
    Graded,
    Material,
    Rigid,
    TransverselyIsotropic,
    Viscoelastic,
    common_exponent,
)
from pymdr.problem.plasticity import ElasticPlastic
from pymdr.problem.values import values_html


@dataclass(frozen=True)
class EffectiveModuli:
    """Moduli of the springs on the line, and how similar the two bodies are."""

    normal: float
    """
    Normal stiffness of the line per length: E* in Pa. For bodies graded with an exponent k it is c in Pa/m^k, and a
    spring at x has the stiffness c |x|^k per length.
    """
    tangential: float
    """G* in Pa: tangential stiffness of the line per length; with an exponent as the normal one."""
    dundurs_beta: float
    """Dundurs' beta; 0 for elastically similar bodies."""
    exponent: float = 0.0
    """The power of |x| with which the stiffnesses grow; 0 for homogeneous bodies."""

    @property
    def similar(self) -> bool:
        """Whether the bodies are elastically similar (beta = 0 to rounding)."""
        return abs(self.dundurs_beta) < 1e-12

    def _repr_html_(self) -> str:
        """The moduli as a table, for notebooks."""
        unit = f"Pa/m^{self.exponent:g}" if self.exponent else "Pa"
        rows = (
            ("normal", self.normal, unit),
            ("tangential", self.tangential, unit),
            ("dundurs_beta", self.dundurs_beta, ""),
            ("exponent", self.exponent or None, ""),
        )
        return values_html(type(self).__name__, rows)


@dataclass(frozen=True)
class SurfaceCompliances:
    """
    Compliances of the surface of one body under traction waves of the wavenumber q.

    A pressure displaces it by 2 normal/q, a shear traction along the wave by 2 longitudinal/q and one across it by
    2 transverse/q; a pressure displaces it along the wave by coupling/q, a quarter of a wavelength aside. All in 1/Pa.
    For an exponent k they are in m^k/Pa, and cos(k pi/2) Gamma((1 - k)/2)/Gamma((1 + k)/2) (2/q)^(1 - k) stands for 2/q.
    """

    normal: float
    longitudinal: float
    transverse: float
    coupling: float

    @property
    def tangential(self) -> float:
        """The mean of both directions, which round contacts feel, in the unit of the others."""
        return 0.5 * (self.longitudinal + self.transverse)


@singledispatch
def surface_compliances(body: Material) -> SurfaceCompliances:
    """
    Compliances of the surface of one body; those of two bodies add.

    Notes
    -----
    Elastic: (1 - nu)/(2G) normal and longitudinal, 1/(2G) transverse, (1 - 2 nu)/(2G) coupling (Johnson, 1985).

    TransverselyIsotropic, with P = sqrt(c11 c33): 1/E* normal, 1/E_L longitudinal, 1/(2 sqrt(c44 c66)) transverse,
    1/(P + c13) coupling, E* = 2 sqrt(c44) (P^2 - c13^2) / sqrt(c11 (P - c13) (P + c13 + 2 c44)), E_L = E* sqrt(c11/c33)
    (Elliott, 1949; Delafargue and Ulm, 2004).

    Graded, with the exponent k and B = sqrt((1 + k) (1 - k nu/(1 - nu))): per depth^k, (1 - nu^2)/(h E) normal,
    ((1 + k)/B)^2 of it longitudinal, 1/(2G cos(k pi/2)) transverse, and 2 (1 + k)/B tan((B - 1) pi/2)/tan(k pi/2) of
    the normal one coupling (Booker, Balaam and Davis, 1985; Giannakopoulos and Suresh, 1997; Hess, 2016), h as in
    :func:`grading_factor`.

    Examples
    --------
    >>> surface_compliances(Elastic(1.0, 0.0)).tangential
    1.0
    """
    raise ProblemError(f"{body!r}: a material such as Elastic('210 GPa', 0.3) is needed")


@surface_compliances.register
def _(body: Rigid) -> SurfaceCompliances:
    return SurfaceCompliances(0.0, 0.0, 0.0, 0.0)


@surface_compliances.register
def _(body: Elastic) -> SurfaceCompliances:
    nu, doubled = body.poisson, 2.0 * body.shear
    normal = (1.0 - nu) / doubled
    return SurfaceCompliances(normal, normal, 1.0 / doubled, (1.0 - 2.0 * nu) / doubled)


@surface_compliances.register
def _(body: TransverselyIsotropic) -> SurfaceCompliances:
    c11, c33, c13, c44, c66 = body.stiffnesses
    mean = math.sqrt(c11) * math.sqrt(c33)
    # P^2 - c13^2 from Young's modulus: c11 c33 - c13^2 has no digits left where the body nearly keeps its volume
    product = (c11 - c66) * body.axial_modulus + c66 * c33
    total = mean + c13 if c13 >= 0.0 else product / (mean - c13)
    modulus = 2.0 * math.sqrt(c44 / (1.0 + 2.0 * c44 / total)) * math.sqrt(product / c11)
    along = modulus * math.sqrt(c11 / c33)
    across = 2.0 * math.sqrt(c44) * math.sqrt(c66)
    return SurfaceCompliances(1.0 / modulus, 1.0 / along, 1.0 / across, 1.0 / total)


@surface_compliances.register
def _(body: Graded) -> SurfaceCompliances:
    k, nu = body.exponent, body.poisson
    wave = _wave_exponent(k, nu)
    unit = body.depth**k
    normal = unit * (1.0 - nu) / (2.0 * body.shear * grading_factor(k, nu))
    # tan((B - 1) pi/2) / tan(k pi/2): both vanish toward k = 0, and both grow toward k = -1 and 1
    factor = (1.0 - nu * (2.0 + k)) / ((1.0 - nu) * (1.0 + wave))
    if k == 0.0:
        ratio = factor
    elif abs(k) < 0.5:
        ratio = math.tan(factor * k * math.pi / 2.0) / math.tan(k * math.pi / 2.0)
    else:
        away = math.tan((1.0 - abs(k)) * math.pi / 2.0)
        ratio = -math.copysign(away, k) / math.tan(wave * math.pi / 2.0)
    return SurfaceCompliances(
        normal,
        normal * ((1.0 + k) / wave) ** 2,
        unit / (2.0 * body.shear * _cosine(k)),
        2.0 * normal * (1.0 + k) / wave * ratio,
    )


@surface_compliances.register
def _(body: Viscoelastic) -> SurfaceCompliances:
    raise ProblemError(
        "the stiffness of a viscoelastic body depends on the history; solve(...) computes it, and "
        "pymdr.relaxation_of(body, counterbody) gives E*(t); for studies without a history use Elastic with the stiffness at "
        "one time"
    )


@surface_compliances.register
def _(body: Layered) -> SurfaceCompliances:
    raise ProblemError(
        "a Layered body has no single modulus, because its stiffness depends on the contact radius; solve(...) and pull_off(...) cover "
        "it. For other studies use Elastic with the material of the layer if the contact is much smaller than its thickness, "
        "or with that of the base if it is much larger"
    )


@surface_compliances.register
def _(body: ElasticPlastic) -> SurfaceCompliances:
    raise ProblemError(
        "an ElasticPlastic body has no single modulus, because its stiffness depends on its largest indentation; solve(...), impact(...) and "
        "restitution(...) cover it. For other studies use Elastic(young, poisson) below yield"
    )


def _wave_exponent(k: float, nu: float) -> float:
    """B = sqrt((1 + k) (1 - k nu/(1 - nu))), which lies between 0 and sqrt(3)."""
    return math.sqrt((1.0 + k) * ((1.0 - 2.0 * nu) + nu * (1.0 - k)) / (1.0 - nu))


def _cosine(k: float) -> float:
    """cos(k pi/2) with all its digits toward k = -1 and 1."""
    return math.sin((1.0 - abs(k)) * math.pi / 2.0)


def grading_factor(exponent: float, poisson: float) -> float:
    """
    The factor h by which grading changes the stiffness of the springs, c = h E |x/z0|^k / (1 - nu^2).

    h = 2 (1 + k) cos(k pi/2) Gamma(1 + k/2) / (sqrt(pi) C B sin(B pi/2) Gamma((1 + k)/2)),
    C = 2^(1 + k) Gamma((3 + k + B)/2) Gamma((3 + k - B)/2) / (pi Gamma(2 + k)), B = sqrt((1 + k) (1 - k nu/(1 - nu))).

    Parameters
    ----------
    exponent : float
        k, above -1 and below 1.
    poisson : float
        nu, -1 < nu <= 0.5.

    Returns
    -------
    float
        Above 0; 1 for k = 0.

    Notes
    -----
    Booker, Balaam and Davis (1985), Int. J. Numer. Anal. Methods Geomech. 9, 353; Giannakopoulos and Suresh (1997),
    Int. J. Solids Struct. 34, 2357; Hess (2016), Int. J. Eng. Sci. 104, 20.

    Examples
    --------
    >>> round(grading_factor(0.2, 0.3), 9)
    1.165829003
    """
    k, gamma = exponent, math.gamma
    wave = _wave_exponent(k, poisson)
    constant = math.exp2(1.0 + k) * gamma((3.0 + k + wave) / 2.0) * gamma((3.0 + k - wave) / 2.0)
    constant /= math.pi * gamma(2.0 + k)
    numerator = 2.0 * (1.0 + k) * _cosine(k) * gamma(1.0 + k / 2.0)
    sine = math.sin(wave * math.pi / 2.0)
    return numerator / (math.sqrt(math.pi) * constant * wave * sine * gamma((1.0 + k) / 2.0))


def effective_moduli(body: Material, counterbody: Material | None = None) -> EffectiveModuli:
    """
    Effective moduli E*, G* and Dundurs' beta of two bodies.

    1/E* = sum (1 - nu_i^2)/E_i,  1/G* = sum (2 - nu_i)/(4 G_i),
    beta = [(1 - 2 nu_1)/G_1 - (1 - 2 nu_2)/G_2] / (2 [(1 - nu_1)/G_1 + (1 - nu_2)/G_2])
    for isotropic bodies; for all, sums and differences of their :func:`surface_compliances`.

    Parameters
    ----------
    body, counterbody : Elastic, TransverselyIsotropic, Graded or Rigid
        The two bodies; the second is rigid unless given.

    Returns
    -------
    EffectiveModuli
        E* and G* in Pa, or in Pa/m^k for the exponent k of graded bodies; beta without unit.

    Raises
    ------
    ProblemError
        If both bodies are rigid, or their exponents differ.

    See Also
    --------
    equivalent_profile : the other part of the equivalent line.

    Notes
    -----
    Johnson (1985), eqs. 4.6 and 5.3; Popov and Hess (2015), chapters 2 and 5. The
    constant called Dundurs' in Argatov's discussion of the method lacks the factor 1/2 and has
    (1 - 2 nu) for (1 - nu) in its denominator; both vanish together.

    References
    ----------
    - Johnson (1985), Contact Mechanics, Cambridge University Press, doi:10.1017/CBO9781139171731.
    - Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, Springer,
      doi:10.1007/978-3-642-53876-6.

    Examples
    --------
    >>> import pymdr as mdr
    >>> round(mdr.effective_moduli(mdr.Elastic("210 GPa", 0.3), mdr.Elastic("70 GPa", 0.33)).dundurs_beta, 9)
    -0.11673597
    """
    counterbody = Rigid() if counterbody is None else counterbody
    exponent = common_exponent(body, counterbody)
    one, other = surface_compliances(body), surface_compliances(counterbody)
    normal, tangential = one.normal + other.normal, one.tangential + other.tangential
    beta = 0.5 * (one.coupling - other.coupling) / normal
    moduli = EffectiveModuli(1.0 / normal, 1.0 / tangential, beta, exponent)
    if not all(map(math.isfinite, (moduli.normal, moduli.tangential, beta))):
        raise ProblemError(f"{body!r} and {counterbody!r} overflow; use moduli in Pa")
    return moduli


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
            return f"the {name}, {type(one).__name__}, has no {carrier}; give it one"
    given = getattr(body, carrier), getattr(counterbody, carrier)
    return Conductivity(*(1.0 / each for each in given) if carrier == "resistivity" else given)


def is_carried(body: Material, counterbody: Material, carrier: Carrier) -> bool:
    """Whether at least one of two bodies has the conductivity or resistivity."""
    return getattr(body, carrier) is not None or getattr(counterbody, carrier) is not None
