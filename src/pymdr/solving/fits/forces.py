"""The force of a contact at measured depths."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Protocol, TypeAlias

import numpy as np

from pymdr.errors import ProblemError
from pymdr.line.curves import ElasticLine, Line
from pymdr.line.memory import (
    approach_and_retreat,
    divided,
    follow_springs,
    follow_travels,
    tabulated,
)
from pymdr.line.soft.springs import FINE, ZoneLevel
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.relaxation import Relaxation, relaxation_of
from pymdr.numerics.graded import GradedTable
from pymdr.problem.contact import Contact
from pymdr.problem.profiles import Profile
from pymdr.problem.profiles.curves import cubic_spline
from pymdr.solving.equilibria import AdhesiveLine
from pymdr.solving.fits.edges import EdgeForces
from pymdr.solving.fits.elastic import LinearForces, elastic_forces
from pymdr.solving.fits.touching import BoolArray, in_contact
from pymdr.units import FloatArray, written

_NODES, _LEAST, _SPRINGS = 256, 8, 300
_ROWS = 120
"""Smallest number of rows of a record on a machine that is solved by springs."""
_TINY = float(np.finfo(float).tiny)
_BETWEEN = 65
"""Parameters of the search of a fold: few calls, because each is slow."""
_OUTWARD = 1.25 ** np.arange(12)
_SAME = 1e-9
_POLISHED = 3


class Forces(Protocol):
    """The force of a contact at measured depths."""

    @property
    def fold(self) -> float:
        """The smallest depth in m of the contact in retraction; inf if it depends on the history."""

    def at(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force in N and stiffness in N/m in contact, at depths in m."""


@dataclass(frozen=True)
class AdhesiveForces:
    """Forces of elastic bodies with adhesion: the branch that is stable at prescribed depths."""

    depth: FloatArray
    """In m, increasing, from the fold on."""
    force: FloatArray
    contact_radius: FloatArray
    cohesive_radius: FloatArray
    line: Line
    stress: float
    """Cohesive stress in Pa around the contact."""
    touch: int = 0
    """Index of the first contact, where the curvature is infinite, after cohesion at a distance; 0 without."""
    compliance: float = 0.0
    """Compliance in m/N of the machine whose travels are the depths; 0 for depths."""
    deeper: AdhesiveForces | None = None
    """The branch from its own fold on, at which the contact jumps to this one in retraction; None if the contact is lost there."""

    @property
    def fold(self) -> float:
        """The smallest depth in m of the contact."""
        return float(self.depth[0])

    @property
    def end(self) -> float:
        """The last known depth in m, beyond which the force is extrapolated along its tangent."""
        return float(self.depth[-1])

    @property
    def _knots(self) -> FloatArray:
        """Roots of the distance from the fold, over which the states are smooth."""
        return np.sqrt(self.depth - self.fold)

    def _spline(self, values: FloatArray) -> FloatArray:
        """Coefficients of splines over the roots before and after the first contact."""
        ends = [0, self.touch, self._knots.size - 1] if self._splits else [0, self._knots.size - 1]
        parts = [slice(low, high + 1) for low, high in pairwise(ends)]
        return np.hstack([cubic_spline(self._knots[part], values[part], None) for part in parts])

    @property
    def _splits(self) -> bool:
        """Whether there are enough states on both sides of the first contact."""
        return _LEAST <= self.touch <= self._knots.size - 1 - _LEAST

    @cached_property
    def _cubics(self) -> FloatArray:
        """Coefficients of F."""
        return self._spline(self.force)

    def _energy_cubics(self) -> tuple[FloatArray, FloatArray]:
        """Coefficients of the elastic energy and of the area inside of the cohesive zone."""
        line, a, c = self.line, self.contact_radius, self.cohesive_radius
        opening = np.where(a > 0.0, line.depth(a), 0.0) - self.depth + self.compliance * self.force
        elastic = line.energy(a) + opening * (0.5 * line.stiffness(a) * opening - line.force(a))
        elastic += 4.0 * self.stress**2 / line.modulus * (c - a) ** 2 * (2.0 * c + a) / 3.0
        return self._spline(elastic), self._spline(math.pi * c**2)

    def _at_roots(self, root: FloatArray, cubics: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
        """A spline, by default that of the force in N, and its slope over the root of the distance from the fold."""
        knots = self._knots
        panel = np.clip(np.searchsorted(knots, root, side="right") - 1, 0, knots.size - 2)
        cubic, square, slope, value = (self._cubics if cubics is None else cubics)[:, panel]
        x = root - knots[panel]
        return value + x * (slope + x * (square + x * cubic)), slope + x * (2.0 * square + 3.0 * x * cubic)

    def effects(self, depth: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """
        Rates of the force over the logarithm of the modulus in N, the work at a constant stress in m, and the logarithm of all together in N.

        The energy of an equilibrium is stationary, so that the rate of its derivative F = dU/dd over a parameter is the derivative of the rate of
        the energy over the parameter: that of the elastic energy over the modulus, -pi c^2 over the work.
        """
        deepest, soft = math.sqrt(self.end - self.fold), self.compliance
        root = np.sqrt(np.clip(depth - self.fold, (1e-3 * deepest) ** 2, deepest**2))
        energies = self._energy_cubics()
        force, rise = self._at_roots(root)
        elastic, area = (self._at_roots(root, cubics)[1] for cubics in energies)
        _, bend, start_rise, start_force = self._cubics[:, 0]
        before, effects = depth < self.fold, []
        # half slopes over the root are those over the depth, times the root; and those of the fold, with their own slopes there
        for half, start, slope in (
            (0.5 * elastic, 0.5 * energies[0][2, 0], energies[0][1, 0]),
            (-0.5 * area, -0.5 * energies[1][2, 0], -energies[1][1, 0]),
            (
                force * (root - 0.5 * soft * rise),
                -0.5 * soft * start_force * start_rise,
                start_force * (1.0 - soft * bend) - 0.5 * soft * start_rise**2,
            ),
        ):
            moved = -2.0 * start / start_rise if start_rise != 0.0 else 0.0
            effects.append(np.where(before, slope + bend * moved, half / root))
        if self.deeper is not None:
            effects = self._or_deeper(depth, effects, self.deeper.effects(depth))
        return effects[0], effects[1], effects[2]

    def _or_deeper(
        self, depth: FloatArray, own: Sequence[FloatArray], beyond: Sequence[FloatArray]
    ) -> list[FloatArray]:
        """Values of this branch before the fold of the deeper one, and of that from there on."""
        assert self.deeper is not None
        return [np.where(depth < self.deeper.fold, *pair) for pair in zip(own, beyond, strict=True)]

    def radius(self, depth: FloatArray) -> FloatArray:
        """Contact radius in m at depths in m."""
        own = np.interp(depth, self.depth, self.contact_radius)
        return own if self.deeper is None else self._or_deeper(depth, [own], [self.deeper.radius(depth)])[0]

    def over_root(self, r: FloatArray, span: float) -> tuple[FloatArray, FloatArray]:
        """Force in N and its slope over r at the distances span r^2 from the fold, in m."""
        root = math.sqrt(span)
        force, slope = self._at_roots(r * root)
        return force, slope * root

    def at(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force in N and stiffness in N/m; those of the fold before it."""
        root = np.sqrt(np.clip(depth - self.fold, 0.0, self.end - self.fold))
        force, slope = self._at_roots(root)
        least = np.array(1e-3 * math.sqrt(self.end - self.fold))
        rate = np.where(root > least, slope, self._at_roots(least)[1]) / (2.0 * np.maximum(root, least))
        values = [force + rate * np.maximum(depth - self.end, 0.0), rate]
        if self.deeper is not None:
            values = self._or_deeper(depth, values, self.deeper.at(depth))
        return values[0], values[1]

    def on_machine(self, compliance: float) -> AdhesiveForces:
        """The forces in retraction over the travel of a machine, to the loss of contact, with its compliance in m/N."""
        from scipy.optimize import brentq

        knots = self._knots

        def rate(root: float) -> float:
            return 2.0 * root + compliance * float(self._at_roots(np.array(root))[1])

        def travel(root: float) -> float:
            return self.fold + root**2 + compliance * float(self._at_roots(np.array(root))[0])

        # the rate is a parabola between knots: it crosses 0 at most once between these places
        cubic, square = self._cubics[:2]
        with np.errstate(divide="ignore", invalid="ignore"):
            vertex = -(1.0 + compliance * square) / (3.0 * compliance * cubic)
        inside = (vertex > 0.0) & (vertex < np.diff(knots))
        scan = np.sort(np.append(knots, (knots[:-1] + vertex)[inside]))
        rises = 2.0 * scan + compliance * self._at_roots(scan)[1] >= 0.0
        turns = np.flatnonzero(rises[:-1] != rises[1:])
        roots = [float(brentq(rate, *scan[[i, i + 1]])) for i in turns]
        folds = [0.0] if rises[0] else []
        folds += [root for root, i in zip(roots, turns, strict=True) if rises[i + 1]]
        tops = [root for root, i in zip(roots, turns, strict=True) if rises[i]]
        if not rises[-1] or folds[-1] > knots[-_LEAST]:
            raise ProblemError(
                f"the search reached an adhesive contact that is unstable at every depth of the record on the machine of "
                f"{written(1.0 / compliance, 'N/m', 4)}; check spring_constant and the units of the record, or start nearer to its modulus and work"
            )
        branch = self._branch_on_machine(folds[-1], float(knots[-1]), compliance)
        for fold in reversed(folds[:-1]):
            if travel(fold) < branch.fold:
                # it goes on up to the travel at which the contact jumps to it
                top = min(root for root in tops if root > fold)
                end = float(brentq(lambda root, fold=branch.fold: travel(root) - fold, fold, top))
                branch = replace(self._branch_on_machine(fold, end, compliance), deeper=branch)
        return branch

    def _branch_on_machine(self, first: float, last: float, compliance: float) -> AdhesiveForces:
        """The forces over travels between two roots of the distance from the fold, between which the travel rises."""
        root, touch = np.linspace(first, last, _NODES), self._knots[self.touch]
        splits = self._splits and first < touch < last
        if splits:
            half = np.linspace(0.0, 1.0, _NODES // 2)
            root = np.append(first + (touch - first) * half[:-1], touch + (last - touch) * half**2)
        force = self._at_roots(root)[0]
        radius, cohesive_radius = (
            np.maximum(self._at_roots(root, self._spline(own))[0], 0.0)
            for own in (self.contact_radius, self.cohesive_radius)
        )
        travels = self.fold + root**2 + compliance * force
        # next to the fold they rise by less than they are rounded
        rises = np.append(True, np.diff(np.maximum.accumulate(travels)) > 0.0)
        return AdhesiveForces(
            travels[rises],
            force[rises],
            radius[rises],
            cohesive_radius[rises],
            self.line,
            self.stress,
            int(np.searchsorted(root[rises], touch)) if splits else 0,
            compliance,
        )


@dataclass(frozen=True)
class OnMachine:
    """Forces of a contact without adhesion on a machine, over its travel."""

    forces: Forces
    compliance: float
    """In m/N."""
    deepest: float
    """In m."""

    @cached_property
    def _table(self) -> tuple[FloatArray, FloatArray]:
        """Depths and travels, increasing."""
        depth = self.deepest * np.linspace(0.0, 1.0, _NODES) ** 2
        force, _ = self.forces.at(depth)
        travel = depth + self.compliance * force
        rises = np.append(True, np.diff(np.maximum.accumulate(travel)) > 0.0)
        return depth[rises], travel[rises]

    @property
    def fold(self) -> float:
        """The smallest travel in m of the contact."""
        return 0.0

    def at(self, travel: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force in N and its rate over the travel in N/m."""
        depths, travels = self._table
        depth = np.interp(travel, travels, depths)
        for _ in range(_POLISHED):
            force, stiffness = self.forces.at(depth)
            slope = 1.0 + self.compliance * stiffness
            depth = np.clip(
                depth - (depth + self.compliance * force - np.maximum(travel, travels[0])) / slope,
                depths[0],
                None,
            )
        force, stiffness = self.forces.at(depth)
        return force, stiffness / (1.0 + self.compliance * stiffness)


@dataclass(frozen=True)
class RememberedForces:
    """Forces of bodies with memory, solved along the whole record."""

    contact: Contact
    time: FloatArray
    compliance: float
    fold: float = math.inf

    @cached_property
    def relaxation(self) -> Relaxation:
        """Relaxation of the springs."""
        span = float(np.diff(self.time).min()), float(self.time[-1] - self.time[0])
        return relaxation_of(self.contact.body, self.contact.counterbody, span=span)

    def at(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force in N of one record, in the order of its times, and NaN for the stiffness, which is not defined."""
        time, unknown = self.time - self.time[0], np.full(depth.shape, math.nan)
        table = _table_of(self.contact.profile, rounded_up(float(depth.max())))
        if table is not None:
            force = approach_and_retreat(table, self.relaxation, time, depth, self.compliance)
            if force is not None:
                return force, unknown
        line = _unit_line(self.contact.profile)
        if self.compliance == 0.0:
            return follow_springs(line, self.relaxation, time, depth, n=_SPRINGS).force, unknown
        # straight travels do not have straight depths
        parts = math.ceil(_ROWS / depth.size)
        many = divided(time, depth, parts)
        followed = follow_travels(line, self.relaxation, *many, 1.0 / self.compliance, n=_SPRINGS)
        return followed.force[::parts], unknown


@lru_cache(maxsize=16)
def _unit_line(profile: Profile) -> ElasticLine:
    return ElasticLine(equivalent_profile(profile), 1.0)


@lru_cache(maxsize=16)
def _table_of(profile: Profile, deepest: float) -> GradedTable | None:
    return tabulated(_unit_line(profile), deepest) if deepest > 0.0 else None


def forces_of(
    contact: Contact,
    deepest: float,
    compliance: float,
    time: FloatArray | None,
    zone: ZoneLevel = FINE,
) -> Forces:
    """
    The forces of a contact over depths, or over travels of a machine.

    Parameters
    ----------
    contact : Contact
    deepest : float
        Largest depth in m.
    compliance : float
        Compliance of the machine in m/N; 0 for depths.
    time : ndarray or None
        Times in s of the samples, needed for bodies with memory.
    zone : ZoneLevel
        Resolution of cohesive zones with memory.
    """
    if contact.is_viscoelastic and time is None:
        raise ProblemError("a body with memory needs the times of the samples; give time= to MeasuredCurve")
    if contact.has_edge_history:
        return EdgeForces(contact, time, compliance, zone)
    if time is not None and contact.is_viscoelastic:
        return RememberedForces(contact, time, compliance)
    if contact.adhesion is not None:
        return _adhesive(contact, rounded_up(deepest), compliance)
    bare = elastic_forces(contact)
    return bare if compliance == 0.0 else OnMachine(bare, compliance, rounded_up(deepest))


BareForces: TypeAlias = LinearForces | AdhesiveForces
"""Forces over depths of a contact without memory."""


def bare_forces(contact: Contact, deepest: float) -> BareForces:
    """The forces of a contact without memory at depths up to one in m."""
    if contact.adhesion is None:
        return elastic_forces(contact)
    return _adhesive(contact, rounded_up(deepest), 0.0)


def rounded_up(deepest: float) -> float:
    """A depth rounded up to one of a few values per decade, so that a branch is computed for many depths."""
    return float(10.0 ** (math.ceil(8.0 * math.log10(deepest)) / 8.0)) if deepest > 0.0 else deepest


@lru_cache(maxsize=16)
def _adhesive(contact: Contact, deepest: float, compliance: float) -> AdhesiveForces:
    """The forces over depths, or over travels of a machine; a search asks for those of one contact at many origins."""
    if compliance > 0.0:
        return _adhesive(contact, deepest, 0.0).on_machine(compliance)
    line = AdhesiveLine(contact)
    states, last = line.equilibria.states, _parameter_at_depth(line, deepest)
    first = _fold(lambda s: states(s).indentation, line.equilibria.start, last)
    s, touch = first + (last - first) * np.linspace(0.0, 1.0, _NODES) ** 1.5, line.equilibria.contact
    if first < touch < last:
        s = np.sort(np.append(s, touch))
    states_from_fold = states(s)
    rises = np.append(True, np.diff(np.maximum.accumulate(states_from_fold.indentation)) > 0.0)
    if np.any(
        ~rises
        & (
            states_from_fold.indentation - states_from_fold.indentation[0]
            > _SAME * np.ptp(states_from_fold.indentation)
        )
    ):
        raise ProblemError("the adhesive contact has several stable branches; fits are for contacts with one")
    if np.count_nonzero(rises) < _LEAST:
        raise ProblemError(
            f"the profile ends before adhesion with {written(line.law.work, 'J/m^2', 4)} keeps a contact; extend the profile"
        )
    return AdhesiveForces(
        states_from_fold.indentation[rises],
        states_from_fold.normal_force[rises],
        states_from_fold.contact_radius[rises],
        states_from_fold.cohesive_radius[rises],
        line.line,
        line.law.cohesive_stress or 0.0,
        int(np.searchsorted(s[rises], touch)) if first < touch < last else 0,
    )


def _fold(depth: Callable[[FloatArray], FloatArray], start: float, last: float) -> float:
    """The parameter in m of the smallest depth, from two scans and a parabola."""
    s = start + last * np.linspace(0.0, 1.0, _BETWEEN) ** 2
    lowest = int(np.argmin(depth(s)))
    s = np.linspace(s[max(lowest - 1, 0)], s[min(lowest + 1, _BETWEEN - 1)], _BETWEEN)
    depths = depth(s)
    at = int(np.argmin(depths))
    if not 0 < at < _BETWEEN - 1:
        return float(s[at])
    before, after = depths[at - 1] - depths[at], depths[at + 1] - depths[at]
    return float(s[at] + 0.5 * (s[1] - s[0]) * (before - after) / max(before + after, _TINY))


def _parameter_at_depth(line: AdhesiveLine, deepest: float) -> float:
    """A parameter in m at which the contact has a depth, or the end of the profile."""
    limit = line.equilibria.limit
    last = min(float(line.line.place(np.array([deepest])).x[0]), limit)
    while last < limit:
        tried = np.minimum(last * _OUTWARD, limit)
        deep_enough = line.equilibria.states(tried).indentation >= deepest
        if deep_enough.any():
            return float(tried[np.argmax(deep_enough)])
        last = float(tried[-1])
    return last


def modelled(
    forces: Forces, depth: FloatArray, measured: FloatArray, touches: BoolArray | None = None
) -> tuple[FloatArray, BoolArray, FloatArray]:
    """Force of the model in N at every sample, whether it is in contact, and its rate in N/m; between the jumps the record decides unless it is given."""
    force, rate = forces.at(depth)
    if math.isinf(forces.fold) and touches is None:
        return force, force != 0.0, rate
    if touches is None:
        touches = in_contact(depth, measured, force, forces.fold) if forces.fold < 0.0 else depth > 0.0
    # before the fold the force is that of the fold
    return np.where(touches, force, 0.0), touches, np.where(touches & (depth >= forces.fold), rate, 0.0)
