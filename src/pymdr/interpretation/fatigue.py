"""Criteria of fatigue over a cycle of a contact: their values inside a body, and the largest with its place and plane."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import singledispatch
from typing import Protocol

import numpy as np

from pymdr.errors import NotValidError
from pymdr.interpretation.interior import Background, Interior
from pymdr.interpretation.planes import InstantMeasure, Measure, PlaneMeasure, largest_on_planes
from pymdr.interpretation.searching import searched_radii
from pymdr.interpretation.solids import IsotropicSolid, Solid, traction_at
from pymdr.interpretation.stress import Loads
from pymdr.interpretation.tensors import fixed_axes
from pymdr.problem.fatigue import (
    DangVan,
    FatemiSocie,
    FatigueCriterion,
    Findley,
    RuizDamage,
    RuizWork,
    SmithWatsonTopper,
)
from pymdr.units import FloatArray

_DEPTHS = np.append(0.0, np.geomspace(1e-3, 2.0, 15))
"""Depths that are searched first, of the loaded radius."""
_ANGLES = 8
"""Intervals of half a turn that are searched first."""
_ROWS = 48
"""Rows of a cycle that the first search uses."""
_RINGS = 4
"""Radii of steps and slopes of a load that the first search resolves."""
_EDGES = 64
"""Radii of edges that are nodes of the first net."""
_EQUAL = 1e-12
"""Of the largest value: how far others are equal to it."""
_POINTS = 2048
"""Points at which cycles of stress are held at once."""


@dataclass(frozen=True)
class StressCycle:
    """The stress in a body over the rows of a cycle."""

    solid: Solid
    sign: float
    """Of the shear traction on this body."""
    loads: tuple[Loads, ...]
    marks: tuple[float, ...]
    """Radii in m at which the stress at the surface is not smooth."""
    backgrounds: tuple[Background, ...] | None
    """Of every row, a stress that the contact does not cause."""

    @property
    def radius(self) -> float:
        """The largest loaded radius in m."""
        return max(load.normal.radius for load in self.loads)

    @property
    def revolves(self) -> bool:
        """Whether nothing depends on the direction."""
        return self.backgrounds is None and all(load.shear is None for load in self.loads)

    @property
    def traction(self) -> str:
        """Name of the field of the traction at the surface."""
        turns = any(load.twist is not None for load in self.loads)
        return "torsional_traction" if turns else "shear_traction"

    @property
    def mirrored(self) -> bool:
        """Whether both sides of the plane y = 0 are alike."""
        if self.traction == "torsional_traction":
            return False
        if self.backgrounds is None:
            return True
        added = np.array([one(self.radius * _DEPTHS) for one in self.backgrounds])
        return not np.any(added[:, 4:])

    def at(self, r: FloatArray, angle: FloatArray, z: FloatArray, rows: Sequence[int]) -> FloatArray:
        """
        Components xx, yy, zz, xz, xy, yz in Pa, shape (n, 6, m).

        Parameters
        ----------
        r, angle, z : ndarray, shape (m,)
            Radius in m, angle from x in rad and depth in m.
        rows : sequence of int
            Of the cycle.
        """
        # points of one radius and depth share the closed forms
        pairs, where = np.unique(r + 1j * z, return_inverse=True)
        radius, depth = np.ascontiguousarray(pairs.real), np.ascontiguousarray(pairs.imag)
        c, s = np.cos(angle), np.sin(angle)
        cycle = np.empty((len(rows), 6, r.size))
        for n, row in enumerate(rows):
            normal, shear, twist = self.loads[row]
            tensor = np.zeros((6, r.size))
            if normal.radius > 0.0:
                tensor[:4] = self.solid.normal_stress(normal, radius, depth)[:, where.ravel()]
            if shear is not None and shear.radius > 0.0:
                amplitudes = self.sign * self.solid.shear_stress(shear, radius, depth)
                tensor += traction_at(amplitudes[:, where.ravel()], c, s)
            if twist is not None and twist.radius > 0.0:
                tensor[4:] += self.sign * self.solid.twist_stress(twist, radius, depth)[:, where.ravel()]
            cycle[n] = fixed_axes(tensor, c, s)
            if self.backgrounds is not None:
                cycle[n] += self.backgrounds[row](z)
        return cycle


class Rating(Protocol):
    """A criterion at points of a body, in polar coordinates."""

    depths: FloatArray
    """Depths that are searched first, of the loaded radius."""

    @property
    def revolves(self) -> bool:
        """Whether nothing depends on the direction."""

    def rough(self, r: FloatArray, angle: FloatArray, z: FloatArray) -> FloatArray:
        """Values of a first search."""

    def starts(self, r: FloatArray, angle: FloatArray, z: FloatArray) -> FloatArray:
        """Planes from which the search at points begins, shape (k, 3, m)."""

    def best(
        self, points: tuple[FloatArray, FloatArray, FloatArray], planes: FloatArray, width: float
    ) -> tuple[FloatArray, FloatArray]:
        """Values and planes near given ones."""

    def whole(self, r: FloatArray, angle: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values and planes of a whole search at each point."""


@dataclass(frozen=True)
class BodyRating:
    """A criterion of the stress inside a body."""

    cycle: StressCycle
    measure: Measure
    depths = _DEPTHS

    @property
    def revolves(self) -> bool:
        """As that of the cycle."""
        return self.cycle.revolves

    def _stress(self, r: FloatArray, angle: FloatArray, z: FloatArray) -> FloatArray:
        return self.cycle.at(r, angle, z, range(len(self.cycle.loads)))

    def rough(self, r: FloatArray, angle: FloatArray, z: FloatArray) -> FloatArray:
        """As of every rating."""
        count = len(self.cycle.loads)
        rows = np.unique(np.linspace(0, count - 1, min(count, _ROWS)).round().astype(int)).tolist()
        parts = np.array_split(np.arange(r.size), max(1, r.size // _POINTS))
        return np.concatenate([self.measure.rough(self.cycle.at(r[p], angle[p], z[p], rows)) for p in parts])

    def starts(self, r: FloatArray, angle: FloatArray, z: FloatArray) -> FloatArray:
        """As of every rating."""
        return self.measure.starts(self._stress(r, angle, z))

    def best(
        self, points: tuple[FloatArray, FloatArray, FloatArray], planes: FloatArray, width: float
    ) -> tuple[FloatArray, FloatArray]:
        """As of every rating."""
        return self.measure.best(self._stress(*points), planes, width)

    def whole(self, r: FloatArray, angle: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """As of every rating."""
        value, plane = np.empty(r.size), np.empty((3, r.size))
        for p in np.array_split(np.arange(r.size), max(1, r.size // _POINTS)):
            value[p], plane[:, p] = largest_on_planes(self.measure, self._stress(r[p], angle[p], z[p]))
        return value, plane


@dataclass(frozen=True)
class SurfaceRating:
    """The parameters of Ruiz, which are known on the surface only."""

    cycle: StressCycle
    interior: Interior
    steps: tuple[int, ...]
    """Rows of the history in which traction, slip or tension is largest or smallest somewhere."""
    rows: tuple[int, ...]
    """The same, of the cycle."""
    stretched: bool
    """Whether the tension along the shift is a factor."""
    depths = np.zeros(1)

    @property
    def revolves(self) -> bool:
        """Traction and slip are of revolution, the tension is not."""
        return not self.stretched

    def whole(self, r: FloatArray, angle: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """As of every rating."""
        radii, where = np.unique(r, return_inverse=True)
        surface = self.interior.surface
        traction = np.array([surface.field(self.cycle.traction, radii, step) for step in self.steps])
        slip = np.array([surface.field("slip", radii, step) for step in self.steps])
        separated = np.isnan(slip)
        low, high = (np.where(separated, side, slip) for side in (math.inf, -math.inf))
        range_of_slip = np.where(separated.all(axis=0), 0.0, high.max(axis=0) - low.min(axis=0))
        value = (np.abs(traction).max(axis=0) * 0.5 * range_of_slip)[where.ravel()]
        if self.stretched:
            stress = self.cycle.at(r, angle, np.zeros(r.size), self.rows)
            value = value * np.maximum(stress[:, 0].max(axis=0), 0.0)
        return np.where(np.isnan(value), 0.0, value), np.full((3, r.size), math.nan)

    def rough(self, r: FloatArray, angle: FloatArray, z: FloatArray) -> FloatArray:
        """As of every rating."""
        return self.whole(r, angle, z)[0]

    def starts(self, r: FloatArray, angle: FloatArray, z: FloatArray) -> FloatArray:
        """One, which is not used."""
        return np.zeros((1, 3, r.size))

    def best(
        self, points: tuple[FloatArray, FloatArray, FloatArray], planes: FloatArray, width: float
    ) -> tuple[FloatArray, FloatArray]:
        """As of every rating."""
        return self.whole(*points)


def stress_cycle(
    interior: Interior, steps: Sequence[int], backgrounds: Sequence[Background] | None
) -> StressCycle:
    """
    The stress in a body over rows of a history.

    Parameters
    ----------
    steps : sequence of int
        Rows of the result.
    backgrounds : sequence of callable or None
        A stress that is added, for each of them.
    """
    loads, marks = [], []
    for step in steps:
        load = interior.surface.loads(step)
        if math.isnan(load.normal.radius):
            raise NotValidError(f"fatigue is not valid here: row {step} has no valid stress; leave it out")
        if load.normal.radius > 0.0 and interior.singular_radius(step) is not None:
            raise NotValidError(f"fatigue is not valid here: in row {step} {interior.unbounded(step)}")
        loads.append(load)
        marks += interior.marks(step)
        for one in (load.shear, load.twist):
            if one is not None:
                marks += sorted({segment.anchor for segment in one.segments})
    places, added = tuple(np.unique(marks).tolist()), None if backgrounds is None else tuple(backgrounds)
    cycle = StressCycle(interior.solid, interior.sign, tuple(loads), places, added)
    if not cycle.radius > 0.0:
        raise NotValidError(
            "fatigue is not valid here: the bodies do not touch in these rows; give steps= with rows in contact"
        )
    return cycle


@singledispatch
def measure_of(criterion: FatigueCriterion, solid: Solid) -> Measure | None:
    """The measure of the stress of a criterion; None if it is one of the surface."""
    return None


@measure_of.register
def _(criterion: DangVan, solid: Solid) -> Measure:
    return InstantMeasure(criterion.hydrostatic_slope)


@measure_of.register
def _(criterion: Findley, solid: Solid) -> Measure:
    slope = criterion.normal_slope
    return PlaneMeasure(lambda shear, tension, strain: shear + slope * tension, sheared=True)


@measure_of.register
def _(criterion: FatemiSocie, solid: Solid) -> Measure:
    modulus, slope = _isotropic(criterion, solid).shear, criterion.normal_slope / criterion.yield_strength
    return PlaneMeasure(
        lambda shear, tension, strain: shear / modulus * (1.0 + slope * np.maximum(tension, 0.0)),
        sheared=True,
    )


@measure_of.register
def _(criterion: SmithWatsonTopper, solid: Solid) -> Measure:
    body = _isotropic(criterion, solid)
    return PlaneMeasure(
        lambda shear, tension, strain: np.maximum(tension, 0.0) * strain,
        sheared=False,
        poisson=body.poisson,
        young=2.0 * body.shear * (1.0 + body.poisson),
    )


def _isotropic(criterion: FatigueCriterion, solid: Solid) -> IsotropicSolid:
    """The body, if strains follow from its stress."""
    if isinstance(solid, IsotropicSolid) and not math.isnan(solid.shear):
        return solid
    raise NotValidError(
        f"{type(criterion).__name__} is not valid here: the strain is known in isotropic elastic bodies only; use DangVan or Findley"
    )


def rating_of(
    criterion: FatigueCriterion, cycle: StressCycle, interior: Interior, steps: Sequence[int]
) -> Rating:
    """A criterion at points of a body."""
    measure = measure_of(criterion, interior.solid)
    if measure is not None:
        return BodyRating(cycle, measure)
    assert isinstance(criterion, RuizWork | RuizDamage)
    if any(load.shear is load.twist is None for load in cycle.loads):
        raise NotValidError(
            f"{type(criterion).__name__} is not valid here: there is no slip without friction; give friction=Coulomb(0.3)"
        )
    if isinstance(criterion, RuizDamage) and cycle.traction == "torsional_traction":
        raise NotValidError(
            "RuizDamage is not valid here: under torsion the slip is around the axis and the tension along a shift is not defined; use "
            "RuizWork()"
        )
    return _on_surface(cycle, interior, steps, isinstance(criterion, RuizDamage))


def _on_surface(
    cycle: StressCycle, interior: Interior, steps: Sequence[int], stretched: bool
) -> SurfaceRating:
    """The parameters of Ruiz from the rows of a cycle that matter at some place."""
    radii = first_radii(cycle)
    inside = np.minimum(radii, cycle.radius)
    traction, slip = (
        np.array([interior.surface.field(name, inside, step) for step in steps])
        for name in (cycle.traction, "slip")
    )
    rows = _covering(np.abs(traction))
    for sign in (1.0, -1.0):
        rows |= _covering(np.where(np.isnan(slip), -math.inf, sign * slip))
    if stretched:
        for angle in searched_angles(cycle):
            stress = cycle.at(radii, np.full(radii.size, angle), np.zeros(radii.size), range(len(steps)))
            rows |= _covering(stress[:, 0])
    kept = tuple(sorted(rows))
    return SurfaceRating(cycle, interior, tuple(steps[n] for n in kept), kept, stretched)


def _covering(values: FloatArray) -> set[int]:
    """A few rows of values, shape (n, m), in which the largest of every column are."""
    largest = values.max(axis=0)
    known = np.isfinite(largest)
    size = float(np.max(np.abs(largest[known]), initial=0.0))
    attained = (values >= largest - _EQUAL * size) & known
    rows: set[int] = set()
    while attained.any():
        row = int(np.argmax(attained.sum(axis=1)))
        rows.add(row)
        attained = attained & ~attained[row]
    return rows


def first_radii(cycle: StressCycle) -> FloatArray:
    """Radii in m that are searched first."""
    inside = [m for m in cycle.marks if 0.0 < m < cycle.radius]
    spaced = searched_radii(inside[:: max(1, -(-len(inside) // _RINGS))], cycle.radius)
    # at the surface the edges of single rows are sharp peaks
    return np.union1d(spaced, inside[:: max(1, -(-len(inside) // _EDGES))])


def searched_angles(cycle: StressCycle) -> FloatArray:
    """Angles in rad that are searched first."""
    if cycle.mirrored:
        return np.linspace(0.0, math.pi, _ANGLES + 1)
    return np.linspace(-math.pi, math.pi, 2 * _ANGLES + 1)
