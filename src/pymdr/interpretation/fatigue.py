"""Criteria of fatigue over a cycle of a contact: their values inside a body, and the largest with its place and plane."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import singledispatch
from typing import NamedTuple, Protocol

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
_RIVALS = 0.15
"""Of the largest value of the first search: how far others may be below it from which the second begins."""
_STARTS = 6
"""Places and planes from which it begins."""
_TURN, _ALIKE = 0.15, 1e-4
"""Distance of planes in rad that are compared first, and 1 less the cosine of the angle of planes that are one."""
_CLOSE, _CLOSER = 1e-2, 1e-3
"""Of the loaded radius: the width of nets at which starts are compared, and how far, of the largest value, others are searched on."""
_EQUAL = 1e-12
"""Of the largest value: how far others are equal to it."""
_PLACE = 1e-6
"""Of the loaded radius: how closely a largest value is located."""
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
    def mirrored(self) -> bool:
        """Whether both sides of the plane y = 0 are alike."""
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
            normal, shear = self.loads[row]
            tensor = np.zeros((6, r.size))
            if normal.radius > 0.0:
                tensor[:4] = self.solid.normal_stress(normal, radius, depth)[:, where.ravel()]
            if shear is not None and shear.radius > 0.0:
                amplitudes = self.sign * self.solid.shear_stress(shear, radius, depth)
                tensor += traction_at(amplitudes[:, where.ravel()], c, s)
            cycle[n] = fixed_axes(tensor, c, s)
            if self.backgrounds is not None:
                cycle[n] += self.backgrounds[row](z)
        return cycle


class Site(NamedTuple):
    """The largest value of a criterion, and where it is."""

    value: float
    r: float
    """In m."""
    angle: float
    """From x, in rad."""
    z: float
    """In m."""
    plane: FloatArray
    """Unit normal, nan if the criterion knows no plane."""


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
        traction = np.array([surface.field("shear_traction", radii, step) for step in self.steps])
        slip = np.array([surface.field("slip", radii, step) for step in self.steps])
        apart = np.isnan(slip)
        low, high = (np.where(apart, side, slip) for side in (math.inf, -math.inf))
        range_of_slip = np.where(apart.all(axis=0), 0.0, high.max(axis=0) - low.min(axis=0))
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
    interior : Interior
    steps : sequence of int
        Rows of the result.
    backgrounds : sequence of callable or None
        A stress that is added, for each of them.

    Raises
    ------
    NotValidError
        If a row is not valid, the stress has no bound in one, or the bodies never touch.
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
        if load.shear is not None:
            marks += sorted({piece.anchor for piece in load.shear.pieces})
    cycle = StressCycle(
        interior.solid,
        interior.sign,
        tuple(loads),
        tuple(np.unique(marks).tolist()),
        None if backgrounds is None else tuple(backgrounds),
    )
    if not cycle.radius > 0.0:
        raise NotValidError("fatigue is not valid here: the bodies do not touch in these rows")
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
        f"{type(criterion).__name__} is not valid here: the strain is known in isotropic elastic bodies only; take DangVan or Findley"
    )


def rating_of(
    criterion: FatigueCriterion, cycle: StressCycle, interior: Interior, steps: Sequence[int]
) -> Rating:
    """
    A criterion at points of a body.

    Raises
    ------
    NotValidError
        If the criterion needs the strain of a body in which it is not known, or friction where there is none.
    """
    measure = measure_of(criterion, interior.solid)
    if measure is not None:
        return BodyRating(cycle, measure)
    assert isinstance(criterion, RuizWork | RuizDamage)
    if any(load.shear is None for load in cycle.loads):
        raise NotValidError(
            f"{type(criterion).__name__} is not valid here: there is no slip without friction; give friction=Coulomb(0.3)"
        )
    return _on_surface(cycle, interior, steps, isinstance(criterion, RuizDamage))


def _on_surface(
    cycle: StressCycle, interior: Interior, steps: Sequence[int], stretched: bool
) -> SurfaceRating:
    """The parameters of Ruiz from the rows of a cycle that matter at some place."""
    radii = _first_radii(cycle)
    inside = np.minimum(radii, cycle.radius)
    traction, slip = (
        np.array([interior.surface.field(name, inside, step) for step in steps])
        for name in ("shear_traction", "slip")
    )
    rows = _covering(np.abs(traction))
    for sign in (1.0, -1.0):
        rows |= _covering(np.where(np.isnan(slip), -math.inf, sign * slip))
    if stretched:
        for angle in _searched_angles(cycle):
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


def _first_radii(cycle: StressCycle) -> FloatArray:
    """Radii in m that are searched first."""
    inside = [m for m in cycle.marks if 0.0 < m < cycle.radius]
    spaced = searched_radii(inside[:: max(1, -(-len(inside) // _RINGS))], cycle.radius)
    # at the surface the edges of single rows are sharp peaks
    return np.union1d(spaced, inside[:: max(1, -(-len(inside) // _EDGES))])


def most_endangered(rating: Rating, cycle: StressCycle) -> Site:
    """
    The largest value of a criterion in a body.

    Parameters
    ----------
    rating : Rating
    cycle : StressCycle

    Returns
    -------
    Site
        With nan for the place if the criterion is nowhere above 0.

    Notes
    -----
    A net of radii, angles and depths is searched with few planes, and around its largest values ever smaller nets with all planes.
    """
    radius = cycle.radius
    angles = np.zeros(1) if rating.revolves else _searched_angles(cycle)
    net = _first_radii(cycle), angles, radius * rating.depths
    grid = np.meshgrid(*net, indexing="ij")
    values = rating.rough(*(axis.ravel() for axis in grid)).reshape(grid[0].shape)
    top = float(values.max())
    if not top > 0.0:
        return Site(0.0, math.nan, math.nan, math.nan, np.full(3, math.nan))
    peaks = np.argwhere(_is_peak(values) & (values >= top * (1.0 - _RIVALS)))
    order = np.argsort([-values[tuple(peak)] for peak in peaks])[:_STARTS]
    begun = [
        _nearer(rating, cycle, start, _CLOSE)
        for start in _starts(rating, net, [tuple(p) for p in peaks[order]])
    ]
    begun.sort(key=lambda one: -one[0].value)
    best_site = begun[0][0]
    last: list[Site] = []
    for site, half in begun:
        known = any(_same(site, other, radius) for other in last)
        if site.value >= best_site.value * (1.0 - _CLOSER) and not known:
            last.append(_nearer(rating, cycle, (site, half), _PLACE)[0])
    return max(last, key=lambda one: one.value)


def _starts(
    rating: Rating, net: tuple[FloatArray, ...], peaks: Sequence[tuple[int, ...]]
) -> list[tuple[Site, FloatArray]]:
    """The best planes at some nodes of a net, with the distances of the neighbours of the nodes."""
    place = np.array(
        [[axis[i] for i in nodes] for axis, nodes in zip(net, zip(*peaks, strict=True), strict=True)]
    )
    points = place[0], place[1], place[2]
    starts: list[tuple[Site, FloatArray]] = []
    for planes in rating.starts(*points):
        value, best = rating.best(points, planes, _TURN)
        for n, nodes in enumerate(peaks):
            half = np.array(
                [
                    np.max(np.abs(np.diff(axis[max(i - 1, 0) : i + 2])), initial=0.0)
                    for axis, i in zip(net, nodes, strict=True)
                ]
            )
            r, angle, z = place[:, n].tolist()
            starts.append((Site(float(value[n]), r, angle, z, best[:, n]), half))
    starts.sort(key=lambda one: -one[0].value)
    distinct: list[tuple[Site, FloatArray]] = []
    for site, half in starts:
        near = any(
            site[1:4] == other[1:4] and not abs(float(site.plane @ other.plane)) < 1.0 - _ALIKE
            for other, _ in distinct
        )
        if site.value >= starts[0][0].value * (1.0 - _RIVALS) and not near:
            distinct.append((site, half))
    return distinct[:_STARTS]


def _searched_angles(cycle: StressCycle) -> FloatArray:
    """Angles in rad that are searched first."""
    if cycle.mirrored:
        return np.linspace(0.0, math.pi, _ANGLES + 1)
    return np.linspace(-math.pi, math.pi, 2 * _ANGLES + 1)


def _same(one: Site, other: Site, radius: float) -> bool:
    """Whether two searches lead to one place and plane."""
    places = [
        np.array([site.r * math.cos(site.angle), site.r * math.sin(site.angle), site.z])
        for site in (one, other)
    ]
    near = float(np.max(np.abs(places[0] - places[1]))) < 3.0 * _CLOSE * radius
    alike = abs(float(one.plane @ other.plane))
    return near and not alike < 1.0 - _CLOSE


def _is_peak(values: FloatArray) -> np.ndarray:
    """Where a value on a net of three dimensions is at least as large as its neighbours."""
    wide = np.pad(values, 1, constant_values=-math.inf)
    n, m, k = values.shape
    around = [
        wide[i : i + n, j : j + m, l : l + k]
        for i in range(3)
        for j in range(3)
        for l in range(3)  # noqa: E741
    ]
    return np.asarray(values >= np.max(around, axis=0))


def _nearer(
    rating: Rating, cycle: StressCycle, start: tuple[Site, FloatArray], precision: float
) -> tuple[Site, FloatArray]:
    """The largest value around a place on nets that shrink around it, until they are as small as the precision."""
    (value, *place, plane), half = start
    best, half = np.array(place), half.copy()
    radius, turning = cycle.radius, not rating.revolves
    steps = np.array([-1.0, 0.0, 1.0])
    while max(half[0] / radius, half[2] / radius, half[1] if turning else 0.0) > precision:
        axes = [
            centre + width * steps if width > 0.0 else np.array([centre])
            for centre, width in zip(best, half, strict=True)
        ]
        axes[0], axes[2] = np.unique(np.clip(axes[0], 0.0, 2.0 * radius)), np.unique(np.maximum(axes[2], 0.0))
        grid = [axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")]
        planes = np.repeat(plane[:, None], grid[0].size, axis=1)
        width = min(0.1, max(2.0 * float(half.max() / radius), 2e-3))
        values, found = rating.best((grid[0], grid[1], grid[2]), planes, width)
        top = int(np.argmax(values))
        moved = np.zeros(3, dtype=bool)
        if values[top] > value:
            new = np.array([axis[top] for axis in grid])
            moved = new != best
            best, value, plane = new, float(values[top]), found[:, top]
        # a net whose largest value lies at its rim is moved before it shrinks
        half *= np.where(moved, 1.0, 0.5)
        if best[0] >= 2.0 * radius:
            half[0] *= 0.5
    return Site(value, float(best[0]), float(best[1]), float(best[2]), plane), half
