"""The table of the laws of adhesion for steps 2 and 3, one row for each law."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pymdr.errors import ProblemError
from pymdr.interpretation.branches import Equilibria
from pymdr.interpretation.fields import edge_amplitude
from pymdr.interpretation.validity import SOURCES, Level, bodies_of
from pymdr.line.adhesion import DMT as RigidPull
from pymdr.line.adhesion import (
    DMT_BELOW,
    JKR_ABOVE,
    dmt_pull,
    energy_release_rate,
    jkr_opening,
    maugis_dugdale,
    maugis_parameter,
    rigid_pull,
    stress_intensity,
)
from pymdr.line.adhesion import JKR as ShortRange
from pymdr.line.curves import Line
from pymdr.line.layered import LayeredLine
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.problem.capillary import Capillary
from pymdr.problem.laws import DMT, JKR, AdhesionLaw, MaugisDugdale
from pymdr.problem.profiles import Profile, Sum
from pymdr.units import FloatArray, written

Statement = tuple[Level, str, str]
"""Level, reason and source of a claim."""


def _nothing(*_: Any) -> dict[str, FloatArray]:
    return {}


def _no_opening(law: Any, line: Line, a: FloatArray) -> FloatArray:
    return np.zeros(a.shape)


def _no_pull(law: Any, profile: Profile, line: Line) -> float | None:
    return None


@dataclass(frozen=True)
class Theory:
    """One law of adhesion. The first argument of each function is the law."""

    curve: Callable[[Any, Profile, Line], Equilibria]
    """Its equilibria on a line."""
    claim: Callable[[Any, Profile, Line], Statement]
    """The claim of its contacts where they are disks."""
    references: tuple[str, ...]
    """Keys of its sources, besides those of the method."""
    rising: bool = True
    """Whether it needs a rising equivalent profile, for which surfaces never touch outside the contact."""
    opening: Callable[[Any, Line, FloatArray], FloatArray] = _no_opening
    """Elongation of the edge in m at contact radii in m."""
    columns: Callable[[Any, Line, FloatArray], dict[str, FloatArray]] = _nothing
    """Additional quantities of its equilibria, on a line at parameters."""
    range: Callable[[Any], float | None] = lambda law: None
    """The range of its attraction in m."""
    pull: Callable[[Any, Profile, Line], float | None] = _no_pull
    """An attractive force in N that is not part of its pressure."""
    proportional: Callable[[Any], bool] = lambda law: False
    """Whether its forces scale with a common factor of moduli and work, so that fits may tabulate them once."""
    limits: Callable[[Any], tuple[AdhesionLaw, ...]] = lambda law: ()
    """Its limits for ranges of attraction that are small and large compared with the deformation, from which fits start."""
    range_note: Callable[[Any, float], str] = lambda law, size: ""
    """Ranges of attraction for which it is valid, given Maugis' parameter times the range in m."""

    @property
    def opens(self) -> bool:
        """Whether its edge is stretched open by a singular stress."""
        return self.opening is not _no_opening

    @property
    def pulls_beyond(self) -> bool:
        """Whether it has an attractive force outside the contact that is not part of the pressure."""
        return self.pull is not _no_pull


def theory_of(law: AdhesionLaw) -> Theory:
    """
    The row of a law of adhesion.

    Examples
    --------
    >>> theory_of(JKR("50 mJ/m^2")).references
    ('jkr', 'hess')
    """
    theory = THEORIES.get(type(law))
    if theory is None:
        raise ProblemError(
            f"{type(law).__name__} is not a known law of adhesion; use one of {', '.join(kind.__name__ for kind in THEORIES)}"
        )
    return theory


def equilibria_of(law: AdhesionLaw, profile: Profile, line: Line, top: float) -> Equilibria:
    """
    The curve of a law on a line.

    Parameters
    ----------
    profile : Profile
        Its radius of curvature determines the attraction of DMT.
    top : float
        Radius in m up to which the curve is needed.
    """
    theory = theory_of(law)
    if law.has_hysteresis:
        raise ProblemError(
            "with work_receding the states depend on the history of the edge, not on one curve; use solve or "
            "pull_off, or one work of adhesion, such as JKR(work)"
        )
    if theory.rising and line.turning_points(min(top, line.edge, line.max_radius)):
        raise ProblemError(
            "the equivalent profile decreases somewhere, but the theory of a cohesive zone needs an increasing "
            "one; use JKR(work), which solves such profiles where their contact is a disk"
        )
    return theory.curve(law, profile, line)


_SOME = 1e-30
"""Substitute radius in m without contact, where the edge is not open."""


def _edge_columns(equilibria: ShortRange, line: Line, s: FloatArray) -> dict[str, FloatArray]:
    """The edge of a JKR contact: its energy release rate, and for a square-root singularity its amplitude and intensity."""
    a = equilibria.states(s).contact_radius
    opening = np.where(a > 0.0, equilibria.opening(s), 0.0)
    radius = np.where(a > 0.0, a, _SOME)
    columns = {"energy_release_rate": energy_release_rate(line, radius, opening)}
    if line.exponent == 0.0:
        modulus = np.sqrt(0.5 * line.modulus * line.stiffness_rate(radius))
        columns["stress_intensity"] = stress_intensity(radius, opening, modulus)
        columns["edge_amplitude"] = edge_amplitude(line, radius, -opening)
    return columns


def rigid_pull_of(law: DMT, profile: Profile, line: Line) -> float:
    """The attractive force in N of DMT, which acts outside the contact at any load."""
    if law.range is not None:
        # the zone of undeformed surfaces within the range does not depend on the body
        equivalent = line.equivalent if line.exponent == 0.0 else equivalent_profile(profile)
        return rigid_pull(equivalent, law.work, law.work / law.range)
    if profile.tip_radius is None:
        parts = profile.parts if isinstance(profile, Sum) else (profile,)
        raise ProblemError(
            f"{' + '.join(type(part).__name__ for part in parts)} has no radius of curvature at the tip, so the attractive force "
            "depends on the range; give DMT(work, range='0.3 nm')"
        )
    return float(dmt_pull(profile.tip_radius, law.work))


def _claim_of_jkr(law: JKR, profile: Profile, line: Line) -> Statement:
    bodies, source = bodies_of(line)
    edge = "a Griffith edge"
    if law.has_hysteresis:
        edge += " that advances and recedes at two works of adhesion, independent of its speed"
    return (
        Level.EXACT,
        f"exact for {bodies} with attraction only in contact ({edge}), in frictionless contact on a disk that has not "
        "opened inside",
        SOURCES["hess"] if source == SOURCES["sneddon"] else source,
    )


def _claim_of_maugis(law: MaugisDugdale, profile: Profile, line: Line) -> Statement:
    return (
        Level.EXACT,
        "exact for elastic half-spaces in frictionless contact that attract each other by a constant stress "
        "up to its range; assumes that the gap stays positive in the cohesive zone",
        SOURCES["maugis"],
    )


def _claim_of_menisci(law: Capillary, profile: Profile, line: Line) -> Statement:
    return (
        Level.EXACT,
        f"exact for elastic half-spaces in frictionless contact that a meniscus of the radius {written(law.radius, 'm', 3)} pulls by a constant "
        f"stress up to the gap {written(law.range, 'm', 3)}; assumes that the meniscus is in equilibrium with its vapour at any time, and that the "
        "gap stays positive in it",
        SOURCES["menisci"],
    )


def _claim_of_dmt(law: DMT, profile: Profile, line: Line) -> Statement:
    measured = "unknown here, give DMT(work, range=...)"
    radius = profile.tip_radius
    if line.exponent != 0.0:
        measured = "not defined for graded bodies"
    elif isinstance(line, LayeredLine):
        measured = "not defined for layers"
    elif law.range is not None and radius is not None:
        measured = f"{float(maugis_parameter(radius, line.modulus, law.work, law.work / law.range)):.3g} here"
    return (
        Level.APPROXIMATE,
        "the limit of Maugis and Dugdale for stiff, small bodies, which the attraction does not deform; the error "
        f"is of the order of Maugis' parameter (limit {DMT_BELOW:g}), which is {measured}",
        SOURCES["dmt"],
    )


def _range_of_jkr(law: JKR, size: float) -> str:
    return (
        f"JKR is valid for a range of attraction below {written(size / JKR_ABOVE, 'm', 3)} (Maugis' parameter above {JKR_ABOVE:g}); force curves "
        "of JKR do not determine the range"
    )


def _range_of_dmt(law: DMT, size: float) -> str:
    if law.range is None:
        return (
            f"DMT is valid for a range of attraction above {written(size / DMT_BELOW, 'm', 3)} (Maugis' parameter below {DMT_BELOW:g}); the range "
            "is unknown"
        )
    if size / law.range <= DMT_BELOW:
        return ""
    return (
        f"Maugis' parameter of the fit = {size / law.range:.3g} (limit {DMT_BELOW:g} of DMT): fit MaugisDugdale(work, "
        f"range='{written(law.range, 'm', 4)}')"
    )


THEORIES: dict[type[AdhesionLaw], Theory] = {
    JKR: Theory(
        curve=lambda law, profile, line: ShortRange(line, law.work),
        claim=_claim_of_jkr,
        references=("jkr", "hess"),
        rising=False,
        opening=lambda law, line, a: jkr_opening(line, a, law.work),
        columns=_edge_columns,
        proportional=lambda law: not law.has_hysteresis,
        range_note=_range_of_jkr,
    ),
    MaugisDugdale: Theory(
        curve=lambda law, profile, line: maugis_dugdale(
            line.equivalent, line.modulus, law.work, law.cohesive_stress
        ),
        claim=_claim_of_maugis,
        references=("maugis",),
        columns=lambda equilibria, line, s: {"cohesive_radius": equilibria.states(s).cohesive_radius},
        range=lambda law: law.work / law.cohesive_stress,
        limits=lambda law: (JKR(law.work), DMT(law.work, range=law.work / law.cohesive_stress)),
        proportional=lambda law: (
            replace(law, work=2.0 * law.work).cohesive_stress == 2.0 * law.cohesive_stress
        ),
    ),
    Capillary: Theory(
        curve=lambda law, profile, line: maugis_dugdale(
            line.equivalent, line.modulus, law.work, law.cohesive_stress
        ),
        claim=_claim_of_menisci,
        references=("menisci", "maugis"),
        columns=lambda equilibria, line, s: {"cohesive_radius": equilibria.states(s).cohesive_radius},
        range=lambda law: law.range,
    ),
    DMT: Theory(
        curve=lambda law, profile, line: RigidPull(line, rigid_pull_of(law, profile, line)),
        claim=_claim_of_dmt,
        references=("dmt", "maugis"),
        range=lambda law: law.range,
        pull=rigid_pull_of,
        proportional=lambda law: True,
        range_note=_range_of_dmt,
    ),
}
"""One row for each law of adhesion."""
