"""Fields of a contact with a cohesive zone on bodies with memory, from the springs of one row."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from pymdr.errors import QuantityError
from pymdr.interpretation.cohesion import cohesive_pressure, pulled_up
from pymdr.interpretation.fields import line_gap
from pymdr.interpretation.memory import between, integrated_cubics, state_at
from pymdr.interpretation.validity import NORMAL_FIELDS, Assumption
from pymdr.line.curves import ElasticLine
from pymdr.line.soft.springs import ZoneLine
from pymdr.mapping.abel import Curve
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

_POINTS = 2
"""Points of the rule over the angle between two springs."""
_TO_EDGE = 4.0 ** np.arange(-1.0, -5.0, -1.0)
"""Distances of points of the rule from the edge of the zone, over that of the last spring."""
_NEGLIGIBLE = 1e-100
"""Displacements below this fraction of the largest count as 0."""
_FEW = 3
"""Springs of a zone that are too few for its root."""
_BLOCK = 64
"""Number of radii whose integrals are computed at once."""
_OVERLAP, _WITHIN = 1e-3, 5e-3
"""Limits of the overlap in the zone, and of the lack of gap beyond it, that the numerics can cause."""
_CHECKED_INSIDE = np.concatenate([np.linspace(0.02, 0.95, 12), 1.0 - np.geomspace(0.03, 1e-3, 4)])
_CHECKED_ZONE = np.array([0.05, 0.2, 0.4, 0.6, 0.8, 0.95])
_CHECKED_BEYOND = np.array([1.0, 1.02, 1.1, 1.3, 1.8])
"""Radii over that of the contact, over the length of the zone, and over the radius of the zone, at which errors are measured."""


@dataclass(frozen=True, eq=False)
class ZoneSurface:
    """Surface and line of a contact with a cohesive zone on bodies with memory; the springs of a row are computed on demand."""

    equivalent: EquivalentProfile
    gap_function: Curve
    relaxed: float
    """Equilibrium modulus in Pa."""
    instantaneous: float
    """Instantaneous modulus in Pa."""
    strength: float
    """Cohesive stress in Pa."""
    contact_radius: FloatArray
    cohesive_radius: FloatArray
    """Of every row in m."""
    line_at: Callable[[int], ZoneLine]
    """The springs of a row."""

    def default_radii(self, step: int) -> FloatArray:
        """A grid from 0 to twice the contact radius and beyond the zone, graded to their edges."""
        a, c = float(self.contact_radius[step]), float(self.cohesive_radius[step])
        a = a or c or float(np.nanmax(self.cohesive_radius, initial=0.0)) or 1.0
        top = min(max(2.0 * a, 1.2 * c), self._known)
        outer = a + (top - a) * np.linspace(0.0, 1.0, 61)[1:] ** 2
        edge = c * np.array([1.0 - 1e-9, 1.0 + 1e-9]) if a <= c < top else np.empty(0)
        return np.unique(np.concatenate([a * np.sin(np.linspace(0.0, math.pi / 2.0, 101)), outer, edge]))

    def marks(self, step: int) -> Sequence[float]:
        """Radii in m in the contact at which its pressure may have a kink."""
        return self.equivalent.kinks(float(self.contact_radius[step]))

    def edge_amplitude(self, step: int) -> float:
        """0: the pressure is finite at the edge."""
        return 0.0

    @property
    def revolves(self) -> bool:
        """Nothing depends on the direction."""
        return True

    @property
    def _known(self) -> float:
        return min(self.equivalent.max_radius, self.equivalent.edge)

    def line_state(self, step: int) -> ZoneLine:
        """The springs of one row."""
        line: ZoneLine = state_at(self, step)
        return line

    def followed_to(self, step: int) -> ZoneLine:
        """The springs of one row, by the whole path up to it."""
        return self.line_at(step)

    def deflection(self, step: int, position: FloatArray) -> FloatArray:
        """Displacement w in m of the springs at positions in m."""
        line, x = self.line_state(step), np.abs(position)
        creep = np.interp(x, line.outside, line.creep, right=0.0)
        stretched = creep + self._pull(line, x) / self.instantaneous
        touching = (x <= line.contact_radius) & (line.contact_radius > 0.0)
        g = self.equivalent.g(np.where(touching, x, 0.0))
        return np.where(touching, line.indentation - g, stretched)

    def field(self, name: str, position: FloatArray, step: int) -> FloatArray:
        """Values of a field at radii (or positions on the line) in one row."""
        at = np.abs(position)
        if math.isnan(self.contact_radius[step]):
            return np.full(position.shape, math.nan)
        if name == "equivalent_profile":
            edge = self.equivalent.edge
            return np.where(at > edge, math.inf, self.equivalent.g(np.minimum(at, edge)))
        return self.value(name, at, self.line_state(step))

    def value(self, name: str, at: FloatArray, line: ZoneLine) -> FloatArray:
        """Values of a field at radii by the springs of a row."""
        if name == "pressure":
            return self._pressure(line, at)
        if name == "normal_displacement":
            return self._displacement(line, at)
        if name == "gap":
            return self._gap(line, at)
        if name == "spring_force":
            return self._force(line, at)
        raise QuantityError(f"no field {name!r}; fields are {', '.join(NORMAL_FIELDS)}")

    @property
    def _relaxed(self) -> ElasticLine:
        return ElasticLine(self.equivalent, self.relaxed)

    def _pull(self, line: ZoneLine, x: FloatArray) -> FloatArray:
        """Load q = -2 sigma0 sqrt(c^2 - x^2) in N/m of springs in the zone."""
        c = line.cohesive_radius
        return np.asarray(-2.0 * self.strength * np.sqrt(np.maximum((c - x) * (c + x), 0.0)))

    def _delayed(self, line: ZoneLine) -> scipy.interpolate.CubicSpline:
        """Part of the load in N/m by the dashpots, -sum E_i (y_i - y_i(a)), over x / a."""
        a = line.contact_radius
        load = self.instantaneous * (line.lag[-1] - line.lag)
        x = line.inside / a
        # a limited slope at the axis would be a logarithm in the pressure
        return scipy.interpolate.CubicSpline(x, load) if x.size > 1 else _nothing()

    def _force(self, line: ZoneLine, x: FloatArray) -> FloatArray:
        """The load in N/m of the springs, continuous at a."""
        a, force = line.contact_radius, self._pull(line, x)
        inside = (x <= a) & (a > 0.0)
        if inside.any():
            g, edge = self.equivalent.g(x[inside]), float(self.equivalent.g(np.array([a]))[0])
            pulled = float(self._pull(line, np.array([a]))[0])
            force[inside] = pulled + self.relaxed * (edge - g) + self._delayed(line)(x[inside] / a)
        return force

    def _pressure(self, line: ZoneLine, r: FloatArray) -> FloatArray:
        """That of the relaxed profile with its zone, and -(1/pi) int_r^a q' / sqrt(x^2 - r^2) dx of the dashpots."""
        a, c = line.contact_radius, line.cohesive_radius
        p = cohesive_pressure(self._relaxed, self.strength, a, c, r)
        inside = r < a
        if inside.any():
            curve, radius = self._delayed(line), np.maximum(r[inside], 1e-9 * a) / a
            blocks = np.array_split(radius, math.ceil(radius.size / _BLOCK))
            p[inside] += np.concatenate([integrated_cubics(curve, block[:, None]) for block in blocks]) / a
        return p

    def _displacement(self, line: ZoneLine, r: FloatArray) -> FloatArray:
        """The displacement d - f in the contact, and (2/pi) int_0^r w / sqrt(r^2 - x^2) dx outside, in m."""
        a, d = line.contact_radius, line.indentation
        u = np.zeros(r.shape)
        inside = (r <= a) & (a > 0.0)
        u[inside] = d - self.gap_function(r[inside])
        s = r[~inside]
        if s.size:
            springs = _over_angle(line, line.creep, s)
            if a > 0.0:
                excess = d - float(self.equivalent.g(np.array([a]))[0])
                springs = springs + self.equivalent.displacement_integral(s, a) + excess * np.arcsin(a / s)
            u[~inside] = 2.0 / math.pi * springs + self._pulled_up(line, s)
        return u

    def _gap(self, line: ZoneLine, r: FloatArray) -> FloatArray:
        """
        Gap (2/pi) int_a^r (g - d + w) / sqrt(r^2 - x^2) dx in m outside the contact.

        Both parts of the integrand are taken less their values at a, where they cancel, so that small gaps next to a have no rounding.
        """
        a, d = line.contact_radius, line.indentation
        gap = np.zeros(r.shape)
        near = (r > a) & (r < self._known) & (a > 0.0)
        if near.any():
            s = r[near]
            pulled = float(self._pull(line, np.array([a]))[0]) / self.instantaneous
            creep = _over_angle(line, line.creep - line.creep[0], s)
            opened = line_gap(self.equivalent, a, pulled, s) + 2.0 / math.pi * creep
            gap[near] = opened + self._pulled_up(line, s)
        far = ~near & ((r > a) | (a == 0.0))
        if far.any():
            gap[far] = self.gap_function(r[far]) - d + self._displacement(line, r[far])
        return gap

    def _pulled_up(self, line: ZoneLine, r: FloatArray) -> FloatArray:
        """Displacement in m by the stress of the zone on springs whose dashpots rest."""
        if not line.cohesive_radius > 0.0:
            return np.zeros(r.shape)
        springs = ElasticLine(self.equivalent, self.instantaneous)
        return pulled_up(springs, self.strength, line.contact_radius, line.cohesive_radius, r)


def _nothing() -> scipy.interpolate.CubicSpline:
    """No load."""
    return scipy.interpolate.CubicSpline([0.0, 1.0], [0.0, 0.0])


def _over_angle(line: ZoneLine, creep: FloatArray, r: FloatArray) -> FloatArray:
    """The integral int_a^r W / sqrt(r^2 - x^2) dx, over the angle arcsin(x / r); W is constant beyond its last value."""
    x, c = line.outside, line.cohesive_radius
    # tiny displacements have slopes whose reciprocals overflow
    largest = float(np.max(np.abs(creep))) or 1.0
    creep = np.where(np.abs(creep) > _NEGLIGIBLE * largest, creep / largest, 0.0)
    zone = int(np.searchsorted(x, c, side="right"))
    rooted = zone > _FEW
    start = zone - 1 if rooted else 0
    beyond = scipy.interpolate.PchipInterpolator(x[start:], creep[start:])
    if rooted:
        # at an edge at rest W falls as the root of the distance
        within = scipy.interpolate.PchipInterpolator(np.sqrt(c - x[:zone])[::-1], creep[:zone][::-1])
        last = x[zone - 2]
        x = np.insert(x, zone - 1, c - (c - last) * _TO_EDGE)

    def curve(at: FloatArray) -> FloatArray:
        values = beyond(at)
        if rooted:
            inside = at < c
            values[inside] = within(np.sqrt(c - at[inside]))
        return np.asarray(values)

    t, weights = gauss(_POINTS)
    total = []
    for radius in np.array_split(r, math.ceil(r.size / _BLOCK)):
        s = np.maximum(radius, 1e-12 * x[-1])[:, None]
        angle = np.arcsin(np.minimum(x / s, 1.0))
        width = np.diff(angle, axis=1)
        values = curve(s[:, :, None] * np.sin(angle[:, :-1, None] + width[:, :, None] * t))
        after = (0.5 * math.pi - angle[:, -1]) * creep[-1]
        total.append(np.sum(width * (values @ weights), axis=1) + after)
    return largest * np.concatenate(total)


@dataclass(frozen=True)
class ZoneCheck:
    """Errors of fields and extremes of some rows."""

    rows: np.ndarray
    """The checked rows, rising."""
    errors: dict[str, FloatArray]
    """Errors of the fields over their largest values, from fewer springs."""
    overlap: FloatArray
    """Deepest overlap over the range of the attraction, negative without one."""
    least_gap: FloatArray
    """Smallest gap beyond the zone over the range of the attraction."""

    def error(self, name: str, size: int) -> FloatArray:
        """Errors of all rows: the largest of those so far and the next checked row."""
        largest = np.maximum.accumulate(self.errors[name])
        return between(self.rows, largest, size)

    @property
    def assumptions(self) -> tuple[Assumption, ...]:
        """Whether the surfaces stay within the law of the zone in the checked rows."""
        return (
            Assumption(
                "open zone",
                "deepest overlap in the cohesive zone over the range of the attraction",
                max(float(np.max(self.overlap)), 0.0),
                _OVERLAP,
            ),
            Assumption(
                "gap beyond the zone",
                "1 minus the smallest gap beyond the zone over the range of the attraction",
                max(1.0 - float(np.min(self.least_gap)), 0.0),
                _WITHIN,
            ),
        )


def check_zone(
    surface: ZoneSurface,
    rows: Sequence[int],
    fine: Sequence[ZoneLine],
    coarse: Sequence[ZoneLine],
    range_: float,
) -> ZoneCheck:
    """
    Measure the errors of fields in some rows by fewer springs, and whether the surfaces overlap outside the contact.

    Parameters
    ----------
    fine, coarse : sequence of ZoneLine
        The springs of these rows of both levels.
    range_ : float
        Range of the attraction in m.
    """
    errors: dict[str, list[float]] = {name: [] for name in NORMAL_FIELDS}
    overlap, least_gap = [], []
    for one, other in zip(fine, coarse, strict=True):
        a, c = one.contact_radius, one.cohesive_radius
        size = c or float(one.outside[-1])
        zone = a + (c - a) * _CHECKED_ZONE
        beyond = size * _CHECKED_BEYOND
        beyond = beyond[beyond < min(surface.equivalent.max_radius, surface.equivalent.edge)]
        within = a * _CHECKED_INSIDE
        for name in NORMAL_FIELDS:
            r = within if name == "pressure" else np.concatenate([zone, beyond])
            values, others = (surface.value(name, r, line) for line in (one, other))
            largest = max(float(np.max(np.abs(values), initial=0.0)), surface.strength * (name == "pressure"))
            if name == "gap":
                largest = max(largest, range_)
            missed = float(np.max(np.abs(values - others), initial=0.0))
            errors[name].append(min(missed / largest, 1.0) if largest > 0.0 else 0.0)
            if name == "gap":
                overlap.append(-float(np.min(values[: zone.size])) / range_ if c > 0.0 else 0.0)
                least_gap.append(float(np.min(values[zone.size :], initial=math.inf)) / range_)
    return ZoneCheck(
        np.array(rows),
        {name: np.array(each) for name, each in errors.items()},
        np.array(overlap),
        np.array(least_gap),
    )
