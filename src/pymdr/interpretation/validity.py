"""Validity of each quantity: claims, assumptions and their sources."""

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
"""Largest relative error of an exact number."""


def total_error(*errors: FloatArray | float | None) -> FloatArray | None:
    """
    Sum of the relative errors of several causes, at most 1; None if one of them is unknown.

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


@dataclass(frozen=True, repr=False)
class Claim:
    """Validity of one quantity."""

    level: Level
    reason: str
    source: str
    where: BoolArray
    """Per step, whether the quantity has the claim's level; elsewhere it is not valid."""
    error: FloatArray | None = None
    """Per step, the total known relative error: of the numerics, of the data, and of the model where that is known. The
    default of an exact claim is 0; a number whose total error is known and at most 1e-9 is exact. None means unknown, as for
    an approximation with exact numerics."""
    excluded: str = ""
    """Part of a field that the error does not cover; elsewhere it is known, however small."""

    def __post_init__(self) -> None:
        if self.error is None:
            if self.level is Level.EXACT:
                object.__setattr__(self, "error", np.zeros(np.shape(self.where)))
            return
        if np.shape(self.error) != np.shape(self.where):
            return  # the reader of a damaged file reports this
        precise = bool(np.max(self.error, initial=0.0, where=self.where) <= EXACT_WITHIN)
        if self.level is Level.EXACT and not precise:
            object.__setattr__(self, "level", Level.APPROXIMATE)
            reason = f"{self.reason}; relative numerical error above {EXACT_WITHIN:g}"
            object.__setattr__(self, "reason", reason)
        elif self.level is Level.APPROXIMATE and precise and not self.excluded:
            # the numerics are exact, and the error of the model is unknown
            object.__setattr__(self, "error", None)

    @property
    def readable(self) -> bool:
        """Whether the quantity may be read at all."""
        return self.level is not Level.NOT_VALID and bool(self.where.any())

    def __repr__(self) -> str:
        steps = f"{int(np.sum(self.where))} of {np.size(self.where)} steps"
        known = self.error is not None and bool(np.any(self.where))
        largest = f", error up to {np.max(self.error, where=self.where, initial=0.0):.2g}" if known else ""  # type: ignore[arg-type]
        largest += f" outside {self.excluded}" if known and self.excluded else ""
        return f"<Claim {self.level.name} in {steps}{largest}: {self.reason} [{self.source}]>"

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
    description: str
    measure: float
    """Largest value over the steps."""
    limit: float

    @property
    def met(self) -> bool:
        """Whether the measure is within the limit."""
        return self.measure <= self.limit


SOURCES: dict[str, str] = {
    "sneddon": "Sneddon (1965), Int. J. Eng. Sci. 3, 47-57, doi:10.1016/0020-7225(65)90019-4",
    "galin": "Galin (1961), Contact Problems in the Theory of Elasticity",
    "stress": (
        "Huber (1904), Ann. Phys. 319, 153-163, for Hertz's pressure; here flat punches (Sneddon 1946, Proc. Camb. Philos. Soc. "
        "42, 29-39) summed along the line of Popov and Hess (2015), chapter 3"
    ),
    "shear-stress": (
        "Hamilton (1983), Proc. Inst. Mech. Eng. 197C, 53-59, for a sliding Hertz contact; here tangential punches summed along the "
        "line"
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
    "savkoor-briggs": "Savkoor and Briggs (1977), Proc. R. Soc. A 356, 103-114, doi:10.1098/rspa.1977.0123",
    "schapery": (
        "Schapery (1975), Int. J. Fract. 11, 141-159, doi:10.1007/BF00034721, for a crack; here by the load of the springs at the edge, in the limit of a "
        "short zone of Haiat and Barthel (2003)"
    ),
    "menisci": (
        "Maugis and Gauthier-Manuel (1994), J. Adhes. Sci. Technol. 8, 1311-1322; any rising profile "
        "by superposition on the line"
    ),
    "haiat-barthel": (
        "Haiat and Barthel (2003), J. Colloid Interface Sci. 264, 94-99; Maugis (1992), J. Colloid Interface Sci. 150, 243-269, with the memory "
        "of Lee and Radok (1960) on the line"
    ),
    "hysteresis": "Chen, Helm and Israelachvili (1991), J. Phys. Chem. 95, 10736-10747",
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
    "archard": "Archard (1953), J. Appl. Phys. 24, 981-988, doi:10.1063/1.1721448",
    "fouvry": "Fouvry, Kapsa and Vincent (1996), Wear 200, 186-205, doi:10.1016/S0043-1648(96)07306-1",
    "popov-wear": (
        "Popov (2014), Phys. Mesomech. 17, 163-172: the limiting shape of fretting wear; Li, Forsbach, Popov and Benad (2018), "
        "Front. Mech. Eng. 4, 7: wear of any profile on the line"
    ),
    "lubkin": (
        "Lubkin (1951), J. Appl. Mech. 18, 183-187: torsion of spheres; of any profile by the springs of torsion, Popov and Hess (2015), "
        "chapter 5"
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
    "gonzalez": "Gonzalez (1996), J. Nonlinear Sci. 6, 449-467, doi:10.1007/BF02440162, for the discrete gradient",
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
    "burmister": (
        "Burmister (1945), J. Appl. Phys. 16, 89-94, 126-127 and 296-302: stresses and displacements in layered systems"
    ),
    "dunkin": "Dunkin (1965), Bull. Seismol. Soc. Am. 55, 335-358: layers by minors, without growing exponentials",
    "levenberg-marquardt": "Levenberg (1944), Q. Appl. Math. 2, 164-168; Marquardt (1963), J. Soc. Ind. Appl. Math. 11, 431-441",
    "patterson-thompson": "Patterson and Thompson (1971), Biometrika 58, 545-554, doi:10.1093/biomet/58.3.545: restricted likelihood",
    "akaike": (
        "Akaike (1974), IEEE Trans. Autom. Control 19, 716-723, doi:10.1109/TAC.1974.1100705; Burnham and Anderson (2002), "
        "Model Selection and Multimodel Inference, 2nd ed., doi:10.1007/b97636"
    ),
    "oliver-pharr": (
        "Oliver and Pharr (1992), J. Mater. Res. 7, 1564-1583, doi:10.1557/JMR.1992.1564; (2004), J. Mater. Res. 19, 3-20, "
        "doi:10.1557/jmr.2004.19.1.3"
    ),
    "pharr-bolshakov": (
        "Pharr and Bolshakov (2002), J. Mater. Res. 17, 2660-2671, doi:10.1557/JMR.2002.0386: the effective shape of an unloading"
    ),
    "bolshakov-pharr": (
        "Bolshakov and Pharr (1998), J. Mater. Res. 13, 1049-1058, doi:10.1557/JMR.1998.0146: pile-up from the residual depth"
    ),
    "zunker-kamrin": (
        "Zunker and Kamrin (2024), J. Mech. Phys. Solids 183, 105492, doi:10.1016/j.jmps.2023.105492 (part I), and 105493, "
        "doi:10.1016/j.jmps.2023.105493 (part II): elastic-plastic balls"
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
"""Additional references for bodies."""

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
TANGENTIAL_FIELDS = ("shear_traction", "tangential_displacement", "slip")
TANGENTIAL_LINE_FIELDS = ("spring_shift",)


def small_slope_assumptions(
    profile: Profile, slope: Curve, contact_radius: float, dundurs_beta: float
) -> tuple[Assumption, ...]:
    """
    Assumptions of the half-space model, measured over the history.

    Parameters
    ----------
    profile : Profile
        Its curvature radius is used if it has one.
    slope : callable
        f'(r).
    contact_radius : float
        Largest contact radius in m.
    dundurs_beta : float
        Dundurs' beta of the pair.
    """
    assumptions = []
    if not isinstance(profile, ForceCurve):  # a force curve has no known slopes
        r = contact_radius * np.linspace(0.0, 1.0, 201)[1:]
        with np.errstate(all="ignore"):
            steepest = float(np.nanmax(np.abs(slope(r))))
        assumptions.append(
            Assumption("small slope", "largest slope of the profile in the contact", steepest, 0.3)
        )
    radius = profile.curvature_radius
    if radius is not None:
        ratio = contact_radius / radius
        assumptions.append(
            Assumption("half-space", "contact radius over radius of curvature a/R", ratio, 0.3)
        )
    assumptions.append(
        Assumption(
            "elastic similarity",
            "Dundurs' beta; affects the pressure only with friction",
            abs(dundurs_beta),
            0.5,
        )
    )
    return tuple(assumptions)


def half_spaces(exponent: float) -> str:
    """
    Description of the bodies of a model.

    Examples
    --------
    >>> half_spaces(0.3)
    'elastic half-spaces whose modulus grows with the depth to the power 0.3'
    """
    return "elastic half-spaces" + (
        f" whose modulus grows with the depth to the power {exponent:g}" if exponent else ""
    )


def bodies_of(line: Line) -> tuple[str, str]:
    """Description of the bodies of a line, and the source of their solution."""
    if not isinstance(line, LayeredLine):
        return half_spaces(line.exponent), SOURCES["hess-graded" if line.exponent else "sneddon"]
    pair = line.kernel.compliance
    bodies = [_layers_in_words(stack.body) for stack in pair.stacks]
    if pair.softness > 0.0:
        bodies.append("an elastic half-space")
    return " against ".join(bodies), SOURCES["lebedev-ufliand"]


def _layers_in_words(body: Layered) -> str:
    kind = "a viscoelastic layer" if body.is_viscoelastic else "an elastic layer"
    several = f"{len(body.layers)}{kind[kind.index(' ') :]}s bonded to one another and"
    stack = kind if len(body.layers) == 1 else several
    base = "rigid base" if isinstance(body.base, Rigid) else "elastic half-space"
    base_bond = (
        f"{'bonded ' * (len(body.layers) == 1)}to a {base}"
        if body.bond == "bonded"
        else f"that may slide on a {base} but not lift off it (bilateral)"
    )
    return f"{stack} {base_bond.replace('a elastic', 'an elastic')}"


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
        Why it is not certified at the other steps.
    extra_reason : str
        For which loads it would be a disk.
    bodies : tuple of str
        Description of the bodies and source of their solution; default homogeneous half-spaces.
    """
    names, source = bodies
    if disk.any():
        level = Level.EXACT
        reason = f"exact for {names} in frictionless contact on a disk"
        if not disk.all():
            reason += f"; not valid at {int((~disk).sum())} of {disk.size} steps: {why}{extra_reason}"
    else:
        level, reason = Level.NOT_VALID, f"{why}{extra_reason}"
    return {name: Claim(level, reason, source, disk) for name in (*NORMAL_QUANTITIES, *NORMAL_FIELDS)}


def bound_claim(disk: BoolArray) -> Claim:
    """Claim of the lower bound of the force on half-spaces."""
    reason = "a rigorous lower bound of the normal force for any profile"
    everywhere = np.ones(disk.shape, dtype=bool)
    return Claim(Level.EXACT, reason, SOURCES["barber"], everywhere)


def with_prescribed(
    claims: Mapping[str, Claim], disk: BoolArray, prescribed: Mapping[str, BoolArray]
) -> dict[str, Claim]:
    """
    Claims updated for quantities that are prescribed at some steps and therefore known there.

    Parameters
    ----------
    disk : ndarray of bool
        Steps at which the disk is certified.
    prescribed : mapping of str to ndarray of bool
        Steps at which each quantity is prescribed.
    """
    updated = dict(claims)
    for name, known in prescribed.items():
        if known.all() or (known.any() and not disk.all()):
            claim, mixed = claims[name], bool((disk & ~known).any())
            error = claim.error if mixed else np.zeros(disk.shape)
            updated[name] = Claim(
                claim.level if mixed else Level.EXACT,
                f"prescribed, or {claim.reason}" if mixed else "prescribed",
                claim.source,
                disk | known,
                None if error is None else np.where(known, 0.0, error),
            )
    return updated


def trial_claim(disk: BoolArray) -> Claim:
    """Claim of the lower bound of the force on layers, where flat punches may need tension."""
    return Claim(
        Level.EXACT,
        "a rigorous lower bound of the normal force for any profile; equal to the force on a disk and where the force is prescribed, "
        "elsewhere the best of non-negative trial pressures on disks of several radii",
        SOURCES["trial-pressure"],
        np.ones(disk.shape, dtype=bool),
    )


def approximated(
    claims: Mapping[str, Claim], remark: str, error: FloatArray | float | None
) -> dict[str, Claim]:
    """
    Claims with the error of one more approximation.

    Parameters
    ----------
    remark : str
        Description of the approximation.
    error : ndarray, float or None
        Relative, per step or for all steps; None if unknown.
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
    Total known error of a claim with one more cause.

    If the error of the model is unknown, the result is the new error, or None if that is negligible.
    """
    if claim.error is None and np.max(error, initial=0.0, where=claim.where) <= EXACT_WITHIN:
        return None
    return total_error(error, 0.0 if claim.error is None else claim.error)


def ring_claims(n: int, steps: int, layered: bool = False) -> dict[str, Claim]:
    """Claims of a boundary-element solution on rings."""
    known = (
        "the relative error of the force of a punch on a bonded incompressible layer, the hardest case measured, is 1e-6 at a radius "
        "of 16 thicknesses, 1e-5 at 32 and 4e-4 at 100"
        if layered
        else "the relative error of the force of sphere, cone and flat punch is 1e-8, that of the pressure between 0.05 and 0.9 of "
        "the radius 1e-5"
    )
    reason = f"boundary elements on {n} rings, without the method of dimensionality reduction; with 400 rings {known}"
    names = (*NORMAL_QUANTITIES, "inner_contact_radius", "contact_area", *NORMAL_FIELDS)
    claim = Claim(Level.APPROXIMATE, reason, SOURCES["johnson"], np.ones(steps, dtype=bool))
    return {name: claim for name in names if name != "edge_amplitude"}


_EXTRAPOLATED = 1e-2
"""Largest acceptable change by the extrapolation to short steps, over the largest force."""


def pulled_ring_claims(n: int, fewer: FloatArray) -> dict[str, Claim]:
    """Claims of a boundary-element solution with memory and a cohesive zone on rings, by its change in N over the largest by fewer rings."""
    reason = (
        f"boundary elements on {n} rings with memory and a cohesive zone, without the method of dimensionality reduction; fewer rings and "
        f"longer steps change the force by at most {float(np.max(fewer, initial=0.0)):.1g} of the largest"
    )
    claim = Claim(Level.APPROXIMATE, reason, SOURCES["haiat-barthel"], np.ones(fewer.size, dtype=bool))
    names = {*NORMAL_QUANTITIES, "inner_contact_radius", "contact_area", "cohesive_radius", *NORMAL_FIELDS}
    claims = dict.fromkeys(sorted(names - {"edge_amplitude", "normal_stiffness"}), claim)
    for name in ("normal_force", "indentation"):
        claims[name] = replace(claim, error=fewer)
    return claims


def ring_memory_claims(n: int, change: FloatArray, fewer: FloatArray) -> dict[str, Claim]:
    """
    Claims of a boundary-element solution with memory on rings.

    Parameters
    ----------
    n : int
        Number of rings.
    change, fewer : ndarray
        Changes by the extrapolation to short steps and by fewer rings, over the largest force or indentation.
    """
    most = float(np.max(change, initial=0.0))
    reason = (
        f"boundary elements on {n} rings with memory, without the method of dimensionality reduction; the extrapolation to zero step "
        f"length changed the forces by at most {most:.1g} of the largest; "
    )
    if most <= _EXTRAPOLATED:
        reason += (
            f"error estimated with fewer rings: {float(np.max(fewer, initial=0.0)):.1g} of the largest; error of the contact radius: "
            "less than the width of a ring"
        )
    else:
        reason += (
            f"above the limit {_EXTRAPOLATED:g}: the steps are long compared with the relaxation times of the bodies, and the numbers "
            "are rough; use shorter steps"
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
