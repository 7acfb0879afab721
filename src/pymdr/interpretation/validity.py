"""How far each quantity can be trusted: claims, assumptions and their sources."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, replace
from html import escape

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import NotValidError
from pymdr.line.curves import Line
from pymdr.line.layered import LayeredLine
from pymdr.mapping.abel import Curve
from pymdr.problem.layers import Layered
from pymdr.problem.materials import Graded, Rigid, TransverselyIsotropic, Viscoelastic
from pymdr.problem.profiles import ForceCurve, Profile
from pymdr.units import FloatArray

BoolArray = NDArray[np.bool_]


EXACT_WITHIN = 1e-9
"""Largest relative error of a number that is called exact."""


def total_error(*errors: FloatArray | float | None) -> FloatArray | None:
    """
    The sum of relative errors of several causes, at most 1; None if one of them is not known.

    Examples
    --------
    >>> total_error(np.array([0.1, 0.2]), 0.05)
    array([0.15, 0.25])
    >>> total_error(np.array([0.1, 0.2]), None) is None
    True
    """
    total: FloatArray = np.zeros(())
    for error in errors:
        if error is None:
            return None
        total = total + error
    return np.minimum(total, 1.0)


class Level(enum.Enum):
    """How a quantity relates to the stated model.

    Examples
    --------
    >>> import pymdr as mdr
    >>> [level.value for level in mdr.Level]
    ['exact', 'approximate', 'not valid']
    """

    EXACT = "exact"
    APPROXIMATE = "approximate"
    NOT_VALID = "not valid"


@dataclass(frozen=True)
class Claim:
    """What can be said of one quantity."""

    level: Level
    reason: str
    source: str
    where: BoolArray
    """Per step, whether the claim's level holds; outside, the quantity is not valid."""
    error: FloatArray | None = None
    """Per step, the whole known relative error of the number: of the numerics, of the model where its size is known, and of the
    data. An exact claim has 0 unless it is given; a number whose whole error is known and at most 1e-9 is exact. None means not
    known, as of an approximation with exact numerics."""

    def __post_init__(self) -> None:
        if self.error is None:
            if self.level is Level.EXACT:
                object.__setattr__(self, "error", np.zeros(np.shape(self.where)))
            return
        if np.shape(self.error) != np.shape(self.where):
            return  # of a damaged file, which says so
        precise = bool(np.max(self.error, initial=0.0, where=self.where) <= EXACT_WITHIN)
        if self.level is Level.EXACT and not precise:
            object.__setattr__(self, "level", Level.APPROXIMATE)
            reason = f"{self.reason}; numbers err by more than {EXACT_WITHIN:g} of their size"
            object.__setattr__(self, "reason", reason)
        elif self.level is Level.APPROXIMATE and precise:
            # what is left of an approximation whose numerics are exact is the error of its model
            object.__setattr__(self, "error", None)

    @property
    def readable(self) -> bool:
        """Whether the quantity may be read at all."""
        return self.level is not Level.NOT_VALID and bool(self.where.any())

    def _repr_html_(self) -> str:
        """The claim for notebooks."""
        return (
            f"<div><b>{self.level.value}</b>: {escape(self.reason)}<br><small>{escape(self.source)}; "
            f"{int(self.where.sum())} of {self.where.size} steps</small></div>"
        )

    def require(self, name: str) -> None:
        """Raise :class:`~pymdr.errors.NotValidError` if the quantity may not be read."""
        if not self.readable:
            raise NotValidError(f"{name} is not valid here: {self.reason} [{self.source}]")


@dataclass(frozen=True)
class Assumption:
    """A condition of the model, measured."""

    name: str
    words: str
    measure: float
    """Largest value over the steps."""
    limit: float

    @property
    def met(self) -> bool:
        """Whether the measure stays within the limit."""
        return self.measure <= self.limit


SOURCES: dict[str, str] = {
    "sneddon": "Sneddon (1965), Int. J. Eng. Sci. 3, 47-57, doi:10.1016/0020-7225(65)90019-4",
    "galin": "Galin (1961), Contact Problems in the Theory of Elasticity",
    "stress": (
        "Huber (1904), Ann. Phys. 319, 153-163, for Hertz's pressure; here flat punches (Sneddon 1946, Proc. Camb. Philos. Soc. "
        "42, 29-39) summed along the line of Popov and Hess (2015), chapter 3"
    ),
    "popov-hess": (
        "Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, "
        "doi:10.1007/978-3-642-53876-6"
    ),
    "handbook": "Popov, Hess and Willert (2019), Handbook of Contact Mechanics, doi:10.1007/978-3-662-58709-6",
    "barber": "Barber (1974), Int. J. Eng. Sci. 12, 813-819: of all trial contact areas the true one carries most",
    "shield": (
        "Shield (1967), J. Appl. Math. Phys. 18, 682-693, with Barber (1974): reciprocity with a disk or an ellipse as trial area"
    ),
    "trial-pressure": (
        "Shield (1967), J. Appl. Math. Phys. 18, 682-693, with Barber (1974): reciprocity with a trial pressure"
    ),
    "jkr": "Johnson, Kendall and Roberts (1971), Proc. R. Soc. A 324, 301-313, doi:10.1098/rspa.1971.0141",
    "hess": (
        "Hess (2011), Ueber die Abbildung ausgewaehlter dreidimensionaler Kontakte auf Systeme mit niedrigerer "
        "raeumlicher Dimension; Popov and Hess (2015), chapter 4, doi:10.1007/978-3-642-53876-6"
    ),
    "maugis": (
        "Maugis (1992), J. Colloid Interface Sci. 150, 243-269, doi:10.1016/0021-9797(92)90285-T; any rising "
        "profile by superposition on the line"
    ),
    "dmt": (
        "Derjaguin, Muller and Toporov (1975), J. Colloid Interface Sci. 53, 314-326, "
        "doi:10.1016/0021-9797(75)90018-1, in the form of Maugis (1992)"
    ),
    "tabor": "Tabor (1977), J. Colloid Interface Sci. 58, 2-13, doi:10.1016/0021-9797(77)90366-6",
    "cattaneo-mindlin": (
        "Cattaneo (1938); Mindlin (1949), J. Appl. Mech. 16, 259-268; Jaeger (1995); Ciavarella (1998), "
        "J. Mech. Phys. Solids 46"
    ),
    "memory": (
        "Jaeger (1993); Aleshin, Bou Matar and Van Den Abeele (2015), Int. J. Solids Struct. 60-61, 92-105: "
        "memory diagrams; here as a stack on the line, Popov and Hess (2015), chapter 5"
    ),
    "kalker": (
        "Kalker (1990), Three-Dimensional Elastic Bodies in Rolling Contact, doi:10.1007/978-94-015-7889-9; Shen, Hedrick "
        "and Elkins (1983), Veh. Syst. Dyn. 12, 79-83, doi:10.1080/00423118308968725: Kalker's slope in the law of Vermeulen and Johnson (1964)"
    ),
    "johnson": "Johnson (1985), Contact Mechanics, doi:10.1017/CBO9781139171731",
    "ting": "Ting (1966), J. Appl. Mech. 33, 845-854: contacts of viscoelastic bodies that grow and shrink",
    "elliott": "Elliott (1949), Proc. Camb. Philos. Soc. 45, 621-630: transversely isotropic half-spaces",
    "delafargue-ulm": "Delafargue and Ulm (2004), Int. J. Solids Struct. 41, 7351-7360: indentation modulus",
    "graded": (
        "Booker, Balaam and Davis (1985), Int. J. Numer. Anal. Methods Geomech. 9, 353-367; Giannakopoulos and Suresh "
        "(1997), Int. J. Solids Struct. 34, 2357-2392: half-spaces graded by a power of the depth"
    ),
    "lee-radok": "Lee and Radok (1960), J. Appl. Mech. 27, 438-444: contact of linear viscoelastic bodies",
    "closure": (
        "Popov and Hess (2015), chapter 10: a rough contact on the line by its force curve, "
        "doi:10.1007/978-3-642-53876-6; Barber (1974): its stiffness does not fall"
    ),
    "hertz": "Hertz (1882), J. reine angew. Math. 92, 156-171; Johnson (1985), Contact Mechanics, chapter 11",
    "popov-shapes": (
        "Popov (2022), Symmetry 14, 390, from Shield (1967), Barber (1974) and Fabrikant's stiffness of flat punches"
    ),
    "bilodeau": "Bilodeau (1992), J. Appl. Mech. 59, 519-523: self-similar pyramids",
    "thornton-ning": "Thornton and Ning (1998), Powder Technol. 99, 154-162, doi:10.1016/S0032-5910(98)00099-0",
    "maw": "Maw, Barber and Fawcett (1976), Wear 38, 101-114, doi:10.1016/0043-1648(76)90201-5",
    "rough-line": (
        "Geike and Popov (2007), Phys. Rev. E 76, 036710, doi:10.1103/PhysRevE.76.036710; Popov and Hess (2015), chapter 10"
    ),
    "pohrt-popov": (
        "Pohrt and Popov (2012), Phys. Rev. Lett. 108, 104301, doi:10.1103/PhysRevLett.108.104301; Popov and Hess (2015), chapter 10"
    ),
    "boundary-elements": "Love (1929), Phil. Trans. R. Soc. A 228, 377-420; Polonsky and Keer (1999), Wear 231, 206-219",
    "contact-outline": "Yastrebov, Anciaux and Molinari (2017), Tribol. Int. 114, 161-171: the area of pixels on the outline",
    "spectrum": (
        "Jacobs, Junge and Pastewka (2017), Surf. Topogr.: Metrol. Prop. 5, 013001, doi:10.1088/2051-672X/aa51f8"
    ),
    "tip": "Sanner et al. (2022), Appl. Surf. Sci. Adv. 7, 100190, doi:10.1016/j.apsadv.2021.100190",
    "holm": "Holm (1967), Electric Contacts: Theory and Application, 4th ed., doi:10.1007/978-3-662-06688-1",
    "barber-conductance": (
        "Barber (2003), Proc. R. Soc. A 459, 53-66, doi:10.1098/rspa.2002.1038: bounds of the electrical resistance between "
        "contacting elastic rough bodies"
    ),
    "kohlrausch": (
        "Kohlrausch (1900), Ann. Phys. 306, 132-158: temperature and potential where metals obey "
        "Wiedemann and Franz; Holm (1967), Electric Contacts"
    ),
    "lebedev-ufliand": (
        "Lebedev and Ufliand (1958), J. Appl. Math. Mech. 22, 442-450: the punch on a layer as one Fredholm equation"
    ),
    "hayes": "Hayes, Keer, Herrmann and Mockros (1972), J. Biomech. 5, 541-551: indentation of cartilage",
    "dunkin": "Dunkin (1965), Bull. Seismol. Soc. Am. 55, 335-358: layers by minors, without growing exponentials",
    "levenberg-marquardt": "Levenberg (1944), Q. Appl. Math. 2, 164-168; Marquardt (1963), J. Soc. Ind. Appl. Math. 11, 431-441",
    "akaike": (
        "Akaike (1974), IEEE Trans. Autom. Control 19, 716-723, doi:10.1109/TAC.1974.1100705; Burnham and Anderson (2002), "
        "Model Selection and Multimodel Inference, 2nd ed., doi:10.1007/b97636"
    ),
    "hess-graded": "Hess (2016), Int. J. Eng. Sci. 104, 20-33: graded half-spaces on the line, with adhesion",
}
"""References by key; claims and :meth:`Result.cite` quote them."""

BODY_SOURCES: dict[type, tuple[str, ...]] = {
    TransverselyIsotropic: ("elliott", "delafargue-ulm"),
    Graded: ("graded", "hess-graded"),
    Viscoelastic: ("lee-radok",),
    Layered: ("lebedev-ufliand", "hayes", "dunkin"),
}
"""What is cited for bodies, besides the sources of their law."""

NORMAL_QUANTITIES = (
    "indentation",
    "normal_force",
    "contact_radius",
    "normal_stiffness",
    "mean_pressure",
    "elastic_energy",
    "edge_amplitude",
)
NORMAL_FIELDS = ("pressure", "normal_displacement", "gap")


def small_slope_assumptions(
    profile: Profile, slope: Curve, contact_radius: float, dundurs_beta: float
) -> tuple[Assumption, ...]:
    """
    What the half-space model assumes, measured over the history.

    Parameters
    ----------
    profile : Profile
        For its curvature radius, where it has one.
    slope : callable
        f'(r).
    contact_radius : float
        Largest contact radius in m.
    dundurs_beta : float
        Dundurs' beta of the pair.

    Returns
    -------
    tuple of Assumption
    """
    found = []
    if not isinstance(profile, ForceCurve):  # whose slopes nobody knows
        r = contact_radius * np.linspace(0.0, 1.0, 201)[1:]
        with np.errstate(all="ignore"):
            steepest = float(np.nanmax(np.abs(slope(r))))
        found.append(Assumption("small slope", "largest slope of the profile in the contact", steepest, 0.3))
    radius = profile.curvature_radius
    if radius is not None:
        ratio = contact_radius / radius
        found.append(Assumption("half-space", "contact radius over radius of curvature a/R", ratio, 0.3))
    found.append(
        Assumption(
            "elastic similarity",
            "Dundurs' beta; affects the pressure only with friction",
            abs(dundurs_beta),
            0.5,
        )
    )
    return tuple(found)


def half_spaces(exponent: float) -> str:
    """
    The bodies of a model, in words.

    Examples
    --------
    >>> half_spaces(0.3)
    'elastic half-spaces whose modulus grows with the depth to the power 0.3'
    """
    return "elastic half-spaces" + (
        f" whose modulus grows with the depth to the power {exponent:g}" if exponent else ""
    )


def bodies_of(line: Line) -> tuple[str, str]:
    """The bodies of a line in words, and the source of their solution."""
    if not isinstance(line, LayeredLine):
        return half_spaces(line.exponent), SOURCES["hess-graded" if line.exponent else "sneddon"]
    body = line.kernel.compliance.body
    what = (
        "an elastic layer"
        if len(body.layers) == 1
        else f"{len(body.layers)} elastic layers bonded to one another"
    )
    base = "rigid base" if isinstance(body.base, Rigid) else "elastic half-space"
    held = (
        f"bonded to a {base}"
        if body.bond == "bonded"
        else f"that may slide on a {base} but not lift off it (bilateral)"
    )
    return f"{what} {held.replace('a elastic', 'an elastic')}", SOURCES["lebedev-ufliand"]


def normal_claims(
    disk: BoolArray,
    why: str,
    extra_reason: str = "",
    bodies: tuple[str, str] = (half_spaces(0.0), SOURCES["sneddon"]),
) -> dict[str, Claim]:
    """
    Claims of the frictionless normal contact.

    Parameters
    ----------
    disk : ndarray of bool
        Steps at which the disk is certified.
    why : str
        Why it is not elsewhere.
    extra_reason : str
        Where it would be, in words.
    bodies : tuple of str
        The bodies in words, and the source of their solution; homogeneous half-spaces unless given.

    Returns
    -------
    mapping of str to Claim
    """
    words, source = bodies
    if disk.any():
        level = Level.EXACT
        reason = f"exact for {words} in frictionless contact on a disk"
        if not disk.all():
            reason += f"; {int((~disk).sum())} of {disk.size} steps are left out: {why}{extra_reason}"
    else:
        level, reason = Level.NOT_VALID, f"{why}{extra_reason}"
    return {name: Claim(level, reason, source, disk) for name in (*NORMAL_QUANTITIES, *NORMAL_FIELDS)}


def bound_claim(disk: BoolArray) -> Claim:
    """The claim of a lower bound of the force of half-spaces."""
    return Claim(
        Level.EXACT,
        "a rigorous lower bound of the normal force for any profile",
        SOURCES["barber"],
        np.ones(disk.shape, dtype=bool),
    )


def with_prescribed(
    claims: Mapping[str, Claim], disk: BoolArray, prescribed: Mapping[str, BoolArray]
) -> dict[str, Claim]:
    """
    Claims with those of quantities that are prescribed at some steps, and so known there whatever the contact is.

    Parameters
    ----------
    claims : mapping of str to Claim
    disk : ndarray of bool
        Steps at which the disk is certified.
    prescribed : mapping of str to ndarray of bool
        Steps at which each quantity is prescribed.

    Returns
    -------
    dict of str to Claim
    """
    found = dict(claims)
    for name, known in prescribed.items():
        if known.all() or (known.any() and not disk.all()):
            claim, mixed = claims[name], bool((disk & ~known).any())
            error = claim.error if mixed else np.zeros(disk.shape)
            found[name] = Claim(
                claim.level if mixed else Level.EXACT,
                f"prescribed, or {claim.reason}" if mixed else "prescribed",
                claim.source,
                disk | known,
                None if error is None else np.where(known, 0.0, error),
            )
    return found


def trial_claim(disk: BoolArray) -> Claim:
    """The claim of a lower bound of the force on layers, whose flat punches may need tension."""
    return Claim(
        Level.EXACT,
        "a rigorous lower bound of the normal force for any profile: the force itself on a disk, or where it is prescribed; elsewhere "
        "the best of trial pressures on disks of several radii that are nowhere negative",
        SOURCES["trial-pressure"],
        np.ones(disk.shape, dtype=bool),
    )


def approximated(
    claims: Mapping[str, Claim], remark: str, error: FloatArray | float | None
) -> dict[str, Claim]:
    """
    Claims of an approximation, whose error is added to theirs.

    Parameters
    ----------
    claims : mapping of str to Claim
    remark : str
        What is approximated.
    error : ndarray, float or None
        Relative, per step or of all; None where its size is not known.

    Returns
    -------
    dict of str to Claim
    """
    return {name: _approximated(claim, remark, error) for name, claim in claims.items()}


def _approximated(claim: Claim, remark: str, error: FloatArray | float | None) -> Claim:
    if claim.level is Level.NOT_VALID:
        return claim
    whole = None if error is None else with_known(claim, np.broadcast_to(error, claim.where.shape))
    counts = whole is None or bool(np.max(whole, initial=0.0, where=claim.where) > EXACT_WITHIN)
    level = Level.APPROXIMATE if counts else claim.level
    return replace(claim, level=level, reason=f"{claim.reason}{remark}", error=whole)


def with_known(claim: Claim, error: FloatArray) -> FloatArray | None:
    """
    The whole known error of a claim with one more cause.

    Where that of the model is not known, the others are all that is known if they count, and nothing is if they do not.
    """
    if claim.error is None and np.max(error, initial=0.0, where=claim.where) <= EXACT_WITHIN:
        return None
    return total_error(error, 0.0 if claim.error is None else claim.error)


def ring_claims(n: int, steps: int, layered: bool = False) -> dict[str, Claim]:
    """Claims of a result by boundary elements on rings."""
    known = (
        "the force of a punch on a bonded incompressible layer errs by 1e-6 at a radius of 16 thicknesses, by 1e-5 at 32 and "
        "4e-4 at 100, the hardest that was measured"
        if layered
        else "the force of Hertz, cone and flat punch errs by 1e-8, the pressure between 0.05 and 0.9 of the radius by 1e-5"
    )
    reason = f"boundary elements on {n} rings, the method of dimensionality reduction was not used; with 400 rings {known}"
    names = (*NORMAL_QUANTITIES, "inner_contact_radius", "contact_area", *NORMAL_FIELDS)
    claim = Claim(Level.APPROXIMATE, reason, SOURCES["johnson"], np.ones(steps, dtype=bool))
    return {name: claim for name in names if name != "edge_amplitude"}


_EXTRAPOLATED = 1e-2
"""Of the largest force: what an extrapolation to short steps may change."""


def ring_memory_claims(n: int, change: FloatArray, fewer: FloatArray) -> dict[str, Claim]:
    """
    Claims of a result with memory by boundary elements on rings.

    Of the largest force, or indentation, an extrapolation to short steps changed a part, and fewer rings tell one.
    """
    most = float(np.max(change, initial=0.0))
    reason = (
        f"boundary elements on {n} rings with a memory each, the method of dimensionality reduction was not used; forces were "
        f"extrapolated to steps without length, by at most {most:.1g} of the largest; "
    )
    if most <= _EXTRAPOLATED:
        reason += (
            f"fewer rings tell that they err by {float(np.max(fewer, initial=0.0)):.1g} of it, and the contact radius errs by less than "
            "the width of a ring"
        )
    else:
        reason += (
            "more than the extrapolation can mend: steps are long beside the times in which these bodies relax, and the numbers are "
            "rough; take a shorter path"
        )
    names = (*NORMAL_QUANTITIES, "inner_contact_radius", "contact_area", *NORMAL_FIELDS)
    where = np.ones(change.size, dtype=bool)
    claims = {
        name: Claim(Level.APPROXIMATE, reason, SOURCES["lee-radok"], where)
        for name in names
        if name != "edge_amplitude"
    }
    for name in ("normal_force", "indentation"):
        claims[name] = replace(claims[name], error=change + fewer)
    return claims
