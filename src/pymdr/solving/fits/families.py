"""Tabulated forces of contacts that differ in one number and in their scale, for fits of many curves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pymdr.errors import ProblemError, PymdrError
from pymdr.interpretation.theories import theory_of
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.contact import Contact
from pymdr.problem.materials import Elastic, Rigid
from pymdr.problem.parameters import parameters_of, with_parameters
from pymdr.solving.fits.forces import AdhesiveForces, BareForces, bare_forces
from pymdr.solving.fits.unknowns import Unknown
from pymdr.units import FloatArray, written

_CELLS, RUNGS, _LEAST = 256, 48, 16
_WORKS = (1e-6, 1.0)
"""Range of the work of adhesion, relative to the modulus times the depth."""
_SIZES = (0.1, 10.0)
"""Range of a size, relative to its start."""
_FARTHEST = 300.0
"""Limit of the logarithm of a scale, which diverges if a record has no contact."""
WORK, RANGES = "adhesion.work", ("adhesion.strength", "adhesion.range")
"""Names of the work of adhesion, and of what limits of a law do not have."""


@dataclass(frozen=True)
class FamilyAxes:
    """
    Unknowns as functions of the two numbers of a family: the logarithm of its scale, and the number in which it differs.

    The forces of elastic bodies of moduli and work s E and s w are s times those of E and w.
    """

    unknowns: tuple[Unknown, ...]
    scale: int | None
    """Index of the modulus among the unknowns."""
    shape: int | None
    """Index of the number of the family among the unknowns."""
    work: Unknown | None
    """The work of adhesion, if the modulus is unknown too: the family differs in the ratio of the work to the scale."""
    fraction: float
    """Fraction of the compliance of both bodies that belongs to the unknown modulus."""

    @property
    def is_tied(self) -> bool:
        """Whether the scale alone moves both numbers."""
        return self.work is not None and self.shape is None

    @property
    def number(self) -> Unknown | None:
        """The unknown in which the family differs."""
        return self.work if self.shape is None else self.unknowns[self.shape]

    def columns(self) -> FloatArray:
        """Rates of the two numbers over the free numbers of the unknowns, shape (2, unknowns)."""
        rates = np.zeros((2, len(self.unknowns)))
        if self.scale is not None:
            rates[0, self.scale] = 1.0
            rates[1, self.scale] = -1.0 if self.work is not None else 0.0
        if self.shape is not None:
            rates[1, self.shape] = 1.0
        return rates

    def numbers(self, values: FloatArray) -> FloatArray:
        """The number in which the family differs, free, of values of the unknowns, shape (curves, unknowns)."""
        number = self.number
        if number is None:
            return np.zeros(len(values))
        free = (
            np.full(len(values), number.to_free(number.start))
            if self.shape is None
            else np.array([number.to_free(float(v)) for v in values[:, self.shape]])
        )
        return free - self.log_scales(values) if self.work is not None else free

    def log_scales(self, values: FloatArray) -> FloatArray:
        """Logarithms of the scale of the family, of values of the unknowns, shape (curves, unknowns)."""
        if self.scale is None:
            return np.zeros(len(values))
        own = self.fraction * self.unknowns[self.scale].start / values[:, self.scale]
        return -np.log(own + 1.0 - self.fraction)

    def values(self, log_scale: FloatArray, number: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values of the unknowns and their rates over their free numbers, shape (curves, unknowns) each."""
        values = np.empty((log_scale.size, len(self.unknowns)))
        rates = np.empty_like(values)
        for i, unknown in enumerate(self.unknowns):
            if i == self.scale:
                softness = np.exp(-np.clip(log_scale, -_FARTHEST, _FARTHEST))
                own = softness - (1.0 - self.fraction)
                values[:, i] = np.where(
                    own > 0.0, unknown.start * self.fraction / np.where(own > 0.0, own, 1.0), np.inf
                )
                rates[:, i] = values[:, i] * np.where(
                    own > 0.0, softness / np.where(own > 0.0, own, 1.0), 1.0
                )
            else:
                free = number + log_scale if self.work is not None else number
                values[:, i] = [unknown.from_free(float(x)) for x in free]
                rates[:, i] = [unknown.rate(float(v)) for v in values[:, i]]
        return values, rates


def axes_of(contact: Contact, unknowns: Sequence[Unknown]) -> FamilyAxes | None:
    """The axes of a contact's unknowns; None if they are not one scale and one number."""
    if contact.is_viscoelastic or contact.has_edge_history:
        return None
    law = contact.adhesion
    if law is not None and not theory_of(law).proportional(law):
        return None
    scale = next((i for i, u in enumerate(unknowns) if u.name in _moduli(contact)), None)
    others = [i for i in range(len(unknowns)) if i != scale]
    fraction = 1.0 if scale is None else fraction_of_compliance(contact, unknowns[scale].name)
    if fraction is None:
        return None
    work = None
    if contact.adhesion is not None and scale is not None:
        work = Unknown(WORK, "J/m^2", 0.0, math.inf, contact.adhesion.work)
    if len(others) > 1 or (others and work is not None and unknowns[others[0]].name != WORK):
        return None
    return FamilyAxes(tuple(unknowns), scale, others[0] if others else None, work, fraction)


def _moduli(contact: Contact) -> list[str]:
    """Names of the moduli of the bodies."""
    return [p.name for p in parameters_of(contact) if p.unit == "Pa" and not p.name.startswith("adhesion.")]


def fraction_of_compliance(contact: Contact, name: str) -> float | None:
    """The fraction of the compliance of both bodies that belongs to a modulus; None if it is not one number."""
    pairs = {
        "body.young": (contact.body, contact.counterbody),
        "counterbody.young": (contact.counterbody, contact.body),
    }
    own, other = pairs.get(name, (None, None))
    if isinstance(own, Elastic) and isinstance(other, Elastic | Rigid):
        return (1.0 - own.poisson**2) / own.young * effective_moduli(own, other).normal
    return 1.0 if _moduli(contact) == [name] else None


def effects_of(contact: Contact, forces: AdhesiveForces, depth: FloatArray) -> dict[str, FloatArray]:
    """Rates of an adhesive force in N over the logarithms of parameters of a contact, by their names, at prescribed depths in m."""
    law = contact.adhesion
    assert law is not None
    parameters = {p.name for p in parameters_of(contact)}
    of_modulus, of_area, together = forces.effects(depth)
    of_work, of_strength = law.work * of_area, together - of_modulus - law.work * of_area
    fractions = {name: fraction_of_compliance(contact, name) for name in _moduli(contact)}
    effects = {name: part * of_modulus for name, part in fractions.items() if part is not None}
    if WORK in parameters:
        effects[WORK] = together - of_modulus if theory_of(law).proportional(law) else of_work
    if law.cohesive_stress is not None and WORK in parameters:
        effects |= dict(zip(RANGES, (of_strength, -of_strength), strict=True))
    return effects


@dataclass(frozen=True, eq=False)
class Family:
    """
    Forces over the root of the depth beyond the fold, one row for each rung of a ladder of numbers.

    The columns of a member with the fold d_f are at d = d_f + (deepest - d_f) r^2, r from 0 to 1.
    """

    forces: FloatArray
    """In N."""
    slopes: FloatArray
    """dF/dr in N."""
    folds: FloatArray
    """In m."""
    first: float
    step: float
    """Step of the free numbers of the rungs."""
    deepest: float
    """In m."""
    members: tuple[BareForces, ...]
    ends: FloatArray
    """Depths in m at which the profile ends, and from which on the forces go on along their tangent; inf where it does not."""

    def end(self, number: FloatArray) -> FloatArray:
        """Depths in m at which the profile ends under free numbers of the family."""
        rungs = self.first + self.step * np.arange(self.ends.size)
        beyond = np.isinf(self.ends)
        known = np.interp(number, rungs, np.where(beyond, self.deepest, self.ends))
        return np.where(np.interp(number, rungs, beyond.astype(float)) > 0.0, np.inf, known)


_Member = tuple[BareForces, FloatArray, FloatArray, float]
"""Forces, their values and slopes over the root, and the depth at which the profile ends."""


class Ladder(NamedTuple):
    """Rungs at even steps of a free number."""

    first: float
    last: float
    rungs: int


@lru_cache(maxsize=8)
def family_of(
    contact: Contact,
    axes: FamilyAxes,
    deepest: float,
    bounds: tuple[float, float] | None = None,
    ladder: Ladder | None = None,
) -> Family:
    """
    The tables of a contact; fits of other records ask for the same ones.

    Parameters
    ----------
    deepest : float
        Largest depth in m that is read.
    bounds : pair of float or None
        Bounds of the number in which the family differs, in its unit.
    ladder : Ladder, optional
        Rungs of that number; its whole range by default.

    Raises
    ------
    PymdrError
        If the contact cannot be solved for any of the numbers.
    """
    number = axes.number
    if number is None:
        only = bare_forces(contact, deepest)
        members, rungs = [(only, *_row(only, deepest))], np.zeros(1)
    else:
        rungs = np.linspace(*(ladder or whole_ladder(contact, number, deepest, bounds)))
        members, rungs = _members(contact, number, rungs, deepest)
    step = float(rungs[1] - rungs[0]) if rungs.size > 1 else 1.0
    return Family(
        np.array([row for _, row, _, _ in members]),
        np.array([slope for _, _, slope, _ in members]),
        np.array([forces.fold for forces, *_ in members]),
        float(rungs[0]),
        step,
        deepest,
        tuple(forces for forces, *_ in members),
        np.array([end for *_, end in members]),
    )


def _members(
    contact: Contact, number: Unknown, rungs: FloatArray, deepest: float
) -> tuple[list[_Member], FloatArray]:
    """The first run of rungs at which the contact can be solved."""
    members: list[tuple[float, _Member]] = []
    failure: PymdrError | None = None
    for rung in rungs:
        try:
            forces = forces_at(contact, number, float(rung), deepest)
            member = (forces, *_row(forces, deepest))
        except PymdrError as error:
            failure = error
            if len(members) >= 4:
                break
            members = []
        else:
            members.append((float(rung), member))
    if len(members) < 4:
        assert failure is not None
        raise failure
    return [member for _, member in members], np.array([rung for rung, _ in members])


def forces_at(contact: Contact, number: Unknown, free: float, deepest: float) -> BareForces:
    """The forces of a contact with a free number of its family, at depths up to one in m."""
    return bare_forces(with_parameters(contact, {number.name: number.from_free(free)}), deepest)


def whole_ladder(
    contact: Contact, number: Unknown, deepest: float, bounds: tuple[float, float] | None = None
) -> Ladder:
    """The whole range of the number of a family."""
    if (
        bounds is not None
        and all(math.isfinite(end) for end in bounds)
        and (bounds[0] > 0.0 or not number.is_size)
    ):
        low, high = bounds
    elif number.unit == "J/m^2":
        modulus = max(p.value for p in parameters_of(contact) if p.unit == "Pa")
        low, high = (part * modulus * deepest for part in _WORKS)
    elif number.is_size:
        low, high = (part * number.start for part in _SIZES)
    else:
        width = min(0.5 * abs(number.start) or 1.0, number.high - number.start, number.start - number.low)
        low, high = number.start - 0.9 * width, number.start + 0.9 * width
    low, high = max(low, number.low), min(high, number.high)
    return Ladder(number.to_free(low), number.to_free(high), RUNGS)


def _row(forces: BareForces, deepest: float) -> tuple[FloatArray, FloatArray, float]:
    """Forces, their slopes over the root, and the depth at which the profile ends."""
    r, span = np.linspace(0.0, 1.0, _CELLS + 1), deepest - forces.fold
    depth = forces.fold + span * r * r
    value, slope = forces.over_root(r, span)
    known = depth <= forces.end
    if known.all():
        return value, slope, math.inf
    if np.count_nonzero(known) < _LEAST:
        raise ProblemError(
            f"the record has an indentation of {written(deepest, 'm', 4)} (limit {written(forces.end, 'm', 4)}, the end of the profile); "
            "extend the profile, or leave out samples far from the contact"
        )
    beyond, stiffness = forces.at(depth)
    return np.where(known, value, beyond), np.where(known, slope, stiffness * 2.0 * r * span), forces.end
