"""How far each quantity can be trusted: claims, assumptions and the certificate of the disk."""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import NotValidError
from pymdr.interpretation.fields import line_gap, pressure
from pymdr.line.foundation import (
    DiskStates,
    ElasticLine,
    mean_pressure,
    normal_force,
    states_at_depth,
    touching_radius,
)
from pymdr.mapping.abel import Curve
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.problem.profiles import Profile
from pymdr.units import FloatArray, metres, written

BoolArray = NDArray[np.bool_]


class Level(enum.Enum):
    """How a quantity relates to the stated model."""

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
    """Per step, a measured bound of the relative error of the number; None where it is rounding."""

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


@dataclass(frozen=True)
class Certificate:
    """Per step, whether the disk solution is the solution, and why not."""

    disk: BoolArray
    reason: str


SOURCES: dict[str, str] = {
    "sneddon": "Sneddon (1965), Int. J. Eng. Sci. 3, 47-57, doi:10.1016/0020-7225(65)90019-4",
    "galin": "Galin (1961), Contact Problems in the Theory of Elasticity",
    "popov-hess": (
        "Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, "
        "doi:10.1007/978-3-642-53876-6"
    ),
    "handbook": "Popov, Hess and Willert (2019), Handbook of Contact Mechanics, doi:10.1007/978-3-662-58709-6",
    "barber": "Barber (1974), Int. J. Eng. Sci. 12, 813-819: of all trial contact areas the true one carries most",
    "shield": (
        "Shield (1967), J. Appl. Math. Phys. 18, 682-693, with Barber (1974): reciprocity with a disk as trial area"
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
    "johnson": "Johnson (1985), Contact Mechanics, doi:10.1017/CBO9781139171731",
}
"""References by key; claims and :meth:`Result.cite` quote them."""

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

_TOLERANCE = 1e-10
"""Relative to the mean pressure and the indentation: what rounding can do to a certificate."""


def certify_disk(line: ElasticLine, states: DiskStates) -> Certificate:
    """
    Check that the disk solution is the solution: pressure >= 0 inside and gap >= 0 outside.

    Where g is known to rise this holds for every load. Elsewhere both integrals are computed step by
    step; together they are equivalent to the unilateral contact conditions, whose solution is unique.

    Parameters
    ----------
    line : ElasticLine
        Profile and modulus.
    states : DiskStates
        The disks to be checked.

    Returns
    -------
    Certificate
    """
    a, d = states.contact_radius, states.indentation
    equivalent = line.equivalent
    if equivalent.rises:
        return Certificate(np.ones(a.shape, dtype=bool), "")
    disk = np.ones(a.shape, dtype=bool)
    reasons: list[str] = []
    top = seen_upto(equivalent, float(np.max(d[np.isfinite(d)], initial=-math.inf)))
    turning = equivalent.turning_points(top) if top > 0.0 else ()
    if not turning:
        return Certificate(disk, "")
    for i in np.flatnonzero(~_obviously_a_disk(equivalent, turning, top, a, d)):
        failure = _why_not_a_disk(line, turning, top, states.take(slice(i, i + 1)))
        if failure:
            disk[i] = False
            reasons.append(failure)
    return Certificate(disk, reasons[-1] if reasons else "")


def seen_upto(equivalent: EquivalentProfile, depth: float) -> float:
    """The radius in m up to which bodies at a depth in m might touch."""
    return min(touching_radius(equivalent, depth), equivalent.edge, equivalent.reach)


def _obviously_a_disk(
    equivalent: EquivalentProfile, turning: tuple[float, ...], top: float, a: FloatArray, d: FloatArray
) -> BoolArray:
    """Where g rises inside the disk and stays above d outside, which makes both integrals positive."""
    marks = np.append(np.array(turning), top)
    g = equivalent.g(marks)
    lowest_beyond = np.minimum.accumulate(g[::-1])[::-1]
    first_beyond = np.searchsorted(marks, a, side="left").clip(0, marks.size - 1)
    return np.asarray((a <= turning[0]) & ((d <= lowest_beyond[first_beyond]) | (a >= top)))


def _why_not_a_disk(line: ElasticLine, turning: tuple[float, ...], top: float, state: DiskStates) -> str:
    equivalent = line.equivalent
    place, d, edge_excess = state.place.take(0), float(state.indentation[0]), float(state.edge_excess[0])
    a = float(place.x)
    grid = (np.arange(96) + 0.5) / 96
    marked = _between_turns(turning, top)
    if a > 0.0:
        scale = float(mean_pressure(normal_force(line, state), state.contact_radius)[0])
        kinks = np.array([b for b in equivalent.kinks(a) if b < a])
        beside = np.concatenate([kinks * (1.0 - 1e-9), kinks * (1.0 + 1e-9)])
        r = np.concatenate(
            [
                a * np.append(1e-6, np.sin(0.5 * np.pi * grid)),
                marked[(marked > 1e-6 * a) & (marked < a)],
                beside[beside < a],
            ]
        )
        p = pressure(line, place, edge_excess, r)
        if not p.min() >= -_TOLERANCE * scale:
            return (
                f"at d = {metres(d)} a disk of radius {metres(a)} would need tension at r = {metres(r[p.argmin()])}, "
                "so the contact is not a disk"
            )
    if a < top:
        r = np.concatenate([a + (top - a) * grid**2, marked[marked > a]])
        h = line_gap(equivalent, place, edge_excess, r) if a > 0.0 else surface_gap(equivalent, r) - d
        if not h.min() >= -_TOLERANCE * max(abs(d), float(np.max(np.abs(equivalent.g(r))))):
            return (
                f"at d = {metres(d)} the surfaces touch again outside a disk of radius {metres(a)}, at "
                f"r = {metres(r[h.argmin()])}, so the contact is not a disk"
            )
    return ""


def surface_gap(equivalent: EquivalentProfile, r: FloatArray) -> FloatArray:
    """The profile f(r) from its image, (2/pi) int_0^r g' arccos(x/r) dx (Popov and Hess 2015, chapter 3)."""
    return 2.0 / math.pi * equivalent.gap_integral(r, 0.0)


def _between_turns(turning: tuple[float, ...], top: float) -> FloatArray:
    """Radii between the turning points of g, so that no dip is stepped over however narrow it is."""
    ends = np.array([*turning, top])
    count = min(8, max(2, 96 // ends.size))
    inner = (np.arange(count) + 0.5) / count
    return np.asarray((ends[:-1, None] + np.diff(ends)[:, None] * inner).ravel())


def valid_ranges(line: ElasticLine, deepest: float) -> list[tuple[float, float]]:
    """
    Force ranges in N in which the contact is a disk, found by scanning and bisection.

    Parameters
    ----------
    line : ElasticLine
    deepest : float
        Largest indentation in m to be scanned.

    Returns
    -------
    list of (lowest, highest) force
    """

    def disk_at(depths: FloatArray) -> BoolArray:
        return certify_disk(line, states_at_depth(line, depths)).disk

    depths = np.linspace(0.0, deepest, 41)[1:]
    valid = disk_at(depths)
    ends = []
    for i in np.flatnonzero(valid[1:] != valid[:-1]):
        low, high = depths[i], depths[i + 1]
        for _ in range(20):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if disk_at(np.array([middle]))[0] == valid[i] else (low, middle)
        ends.append(0.5 * (low + high))
    marks = np.array([depths[0] if not valid[0] else 0.0, *ends, deepest])
    starts_valid = bool(valid[0])
    forces = normal_force(line, states_at_depth(line, marks))
    first = 0 if starts_valid else 1
    return [(float(forces[i]), float(forces[i + 1])) for i in range(first, forces.size - 1, 2)]


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
    r = contact_radius * np.linspace(0.0, 1.0, 201)[1:]
    with np.errstate(all="ignore"):
        steepest = float(np.nanmax(np.abs(slope(r))))
    found = [Assumption("small slope", "largest slope of the profile in the contact", steepest, 0.3)]
    radius = profile.curvature_radius
    if radius is not None:
        ratio = contact_radius / radius
        found.append(Assumption("half-space", "contact radius over radius of curvature a/R", ratio, 0.3))
    found.append(
        Assumption(
            "elastic similarity",
            "Dundurs' beta; only with friction does it change the pressure",
            abs(dundurs_beta),
            0.5,
        )
    )
    return tuple(found)


def normal_claims(
    disk: BoolArray, why: str, extra_reason: str = "", prescribed: Mapping[str, BoolArray] | None = None
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
    prescribed : mapping of str to ndarray of bool, optional
        Steps at which a quantity is prescribed and so known whatever the contact is.

    Returns
    -------
    mapping of str to Claim
    """
    source = SOURCES["sneddon"]
    if disk.any():
        level = Level.EXACT
        reason = "exact for elastic half-spaces in frictionless contact on a disk"
        if not disk.all():
            reason += f"; {int((~disk).sum())} of {disk.size} steps are not a disk: {why}{extra_reason}"
    else:
        level, reason = Level.NOT_VALID, f"{why}{extra_reason}"
    claims = {name: Claim(level, reason, source, disk) for name in (*NORMAL_QUANTITIES, *NORMAL_FIELDS)}
    for name, known in (prescribed or {}).items():
        if known.all() or (known.any() and not disk.all()):
            claims[name] = Claim(Level.EXACT, "prescribed, or exact on a disk", source, disk | known)
    everywhere = np.ones(disk.shape, dtype=bool)
    claims["force_lower_bound"] = Claim(
        Level.EXACT,
        "a rigorous lower bound of the normal force for any profile",
        SOURCES["barber"],
        everywhere,
    )
    return claims


def ring_claims(n: int, steps: int) -> dict[str, Claim]:
    """Claims of a result by boundary elements on rings."""
    reason = (
        f"boundary elements on {n} rings, the method of dimensionality reduction was not used; with 400 rings the "
        "force of Hertz, cone and flat punch errs by 1e-8, the pressure between 0.05 and 0.9 of the radius by 1e-5"
    )
    names = (*NORMAL_QUANTITIES, "inner_contact_radius", "contact_area", *NORMAL_FIELDS)
    claim = Claim(Level.APPROXIMATE, reason, SOURCES["johnson"], np.ones(steps, dtype=bool))
    return {name: claim for name in names if name != "edge_amplitude"}


def describe_ranges(ranges: list[tuple[float, float]], deepest_force: float) -> str:
    """The valid load ranges in words."""
    way_out = "; solve(..., solver=Rings()) solves it by boundary elements on rings"
    if not ranges:
        return f"; it is a disk for no load up to {written(deepest_force, 'N')}{way_out}"
    words = [
        f"{written(low, 'N')} to {written(high, 'N')}"
        if not math.isclose(high, deepest_force)
        else f"{written(low, 'N')} and more"
        for low, high in ranges
    ]
    return f"; it is a disk for loads of {', '.join(words)} (scanned up to {written(deepest_force, 'N')}){way_out}"
