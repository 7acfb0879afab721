"""Adhesion with a constant stress of finite range: Maugis-Dugdale for any monotone equivalent profile.

The line carries w = d - g for x < a and w = -(2σ0/E*) sqrt(c² - x²) for a < x < c; both are exact on the line.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.line.adhesion.cohesive_zone import solve_width, zone_integrals
from pymdr.line.adhesion.equivalent_line import States, inner_knots, own_edge
from pymdr.line.adhesion.radii import Radii, radii_of
from pymdr.line.adhesion.zone_panels import segment, zone_root
from pymdr.line.curves import ElasticLine
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.mapping.equivalent.panels import PanelLine
from pymdr.numerics.panels import Place, Position
from pymdr.numerics.table import Effort, Table, tabulated
from pymdr.units import FloatArray, metres

_BRANCHES = 5
_FEW = 3000
"""Number of states computed without a table, which costs as much."""
_EFFORT = Effort(terms=40)
"""Resolution of tables: shorter series on smaller cells need up to three times as many states."""
_BEYOND = 1.1
_APPROACH, _AT_EDGE, _GROWING, _CLIPPED, _STUCK = range(_BRANCHES)


@dataclass(frozen=True)
class _Zones:
    """Flat arrays over the parameter: the branch, contact radius a, width δ = c - a and indentation d."""

    branch: FloatArray
    place: Position
    width: FloatArray
    indentation: FloatArray

    @property
    def radius(self) -> FloatArray:
        return np.asarray(self.place, dtype=float)


@dataclass(frozen=True)
class MaugisDugdale:
    """The curve of Maugis-Dugdale states, from the first cohesion at a distance to full contact.

    Made by `maugis_dugdale`. Its parameter s [m] runs through at most five branches, in this order:

    1. cohesion without contact, s = c: d = f(c) - 4 σ0 c / (π E*) - h0;
    2. (sharp edge, c = edge already) the indentation rises until the centre touches;
    3. contact with the zone of the gap condition, s counts a;
    4. (sharp edge) contact with the zone ending at the edge, s counts how sqrt(edge² - a²) shrinks;
    5. (sharp edge) full contact, a = c = edge, s counts d.

    Attributes
    ----------
    line : EquivalentProfile
        The equivalent profile.
    modulus, work, strength : float
        E* [Pa], γ [J/m²] and the cohesive stress σ0 [Pa].
    ends : tuple of float
        Ends of the five branches on s [m]; a branch that does not occur has zero length.
    start, limit : float
        Range of s [m].
    touch : float
        Indentation where cohesion begins, -h0 = -γ/σ0 [m].

    Notes
    -----
    Maugis (1992) for the sphere; for any monotone g by superposition on the line, Popov & Hess (2015).
    On branch 3 d = g(a) - (2σ0/E*) sqrt(c² - a²) and the gap at c is h0:
    (2/π)[int_a^c (g - d)/sqrt(c² - x²) dx - (2σ0/E*)(c - a)] = h0. On branch 4 the gap at the edge is below
    h0 and the zone cannot grow. That the gap is positive inside the zone is assumed.
    """

    line: EquivalentProfile
    modulus: float
    work: float
    strength: float
    ends: tuple[float, ...]
    ranged: ClassVar[bool] = True
    """Whether the attraction reaches beyond the contact."""
    _tables: dict[int, Table] = field(default_factory=dict, compare=False, repr=False)
    _computed: dict[int, int] = field(default_factory=dict, compare=False, repr=False)
    """Number of states of a branch computed since its table was made."""

    @property
    def knots(self) -> tuple[float, ...]:
        """Values of s where the curve is not smooth [m], as far as the profile is known."""
        first, growing = self.ends[_APPROACH], self.ends[_GROWING]
        edge, radii = own_edge(self.line), self._radii
        kinks = np.array(inner_knots(self.line))
        crossing = kinks[kinks > first]
        target = 0.5 * np.pi * self.work / self.strength
        width = solve_width(self.line, self._k, target, crossing, crossing.copy(), outward=False)
        along = [*radii.parameter(kinks), *radii.parameter(crossing - width), *radii.knots]
        places = {*kinks[kinks < first], *self.ends, *(s for s in along if s < growing)}
        if np.isfinite(edge) and self.ends[_CLIPPED] > growing:
            late = kinks[radii.parameter(kinks) >= growing]
            places |= {*(self.ends[_CLIPPED] - np.sqrt((edge - late) * (edge + late)))}
        return tuple(sorted(float(s) for s in places if 0.0 < s < self.ends[-1]))

    @property
    def _springs(self) -> ElasticLine:
        return ElasticLine(self.line, self.modulus)

    @property
    def start(self) -> float:
        """The parameter where cohesion begins [m]."""
        return 0.0

    @property
    def limit(self) -> float:
        """The largest parameter [m]."""
        return self.ends[-1]

    @property
    def touch(self) -> float:
        """Indentation where cohesion begins [m]."""
        return -self.work / self.strength

    @property
    def contact(self) -> float:
        """The parameter where contact begins [m]."""
        return self.ends[_AT_EDGE]

    def parameter_below(self, radius: float, zone: float, depth: float) -> float:
        """Return a parameter near that of the state of given radii of contact and zone and indentation, not above it [m]."""
        return self.contact + radius if radius > 0.0 else min(zone, self.ends[_APPROACH])

    @property
    def _k(self) -> float:
        return self.strength / self.modulus

    def _zones(self, s: FloatArray) -> _Zones:
        edge = own_edge(self.line)
        branch = np.minimum(np.searchsorted(self.ends, s, side="right"), _last_branch(self.ends))
        offset = s - np.array([0.0, *self.ends])[branch]
        radius, width, d = np.zeros_like(s), np.zeros_like(s), np.zeros_like(s)

        at = np.flatnonzero(branch == _APPROACH)
        width[at] = offset[at]
        # even the first state needs a zone, however small
        first = np.maximum(offset[at], 1e-18 * self.ends[_APPROACH])
        height = (2.0 / np.pi) * self._without_contact(first)[1]
        d[at] = np.where(offset[at] > 0.0, height - (4.0 / np.pi) * self._k * width[at], 0.0) + self.touch

        at = np.flatnonzero(branch == _AT_EDGE)
        width[at] = edge
        d[at] = offset[at] - 2.0 * self._k * edge - (self.ends[_AT_EDGE] - self.ends[_APPROACH])

        base = np.zeros_like(s)
        at = np.flatnonzero(branch == _GROWING)
        if at.size:
            base[at], radius[at] = self._radii.place(s[at])
            known = self._around_contact(s[at])
            width[at] = self._width(self._position(base[at], radius[at])) if known is None else known[0]

        at = np.flatnonzero(branch == _CLIPPED)
        # the difference of two ends may round beyond the edge
        root = np.clip(self.ends[_CLIPPED] - s[at], 0.0, edge)
        radius[at] = np.sqrt((edge - root) * (edge + root))
        width[at] = root**2 / (edge + radius[at])

        at = np.flatnonzero((branch == _GROWING) | (branch == _CLIPPED))
        place = self._position(base[at], radius[at])
        d[at] = self.line.g(place) - 2.0 * self._k * zone_root(np.asarray(place, dtype=float), width[at])

        at = np.flatnonzero(branch == _STUCK)
        radius[at] = edge
        d[at] = self.line.g(radius[at]) + offset[at]
        return _Zones(branch.astype(np.float64), self._position(base, radius), width, d)

    @cached_property
    def _radii(self) -> Radii:
        return radii_of(self.line, self.line.slope, self.ends[_AT_EDGE])

    def _position(self, base: FloatArray, offset: FloatArray) -> Position:
        return Place(base, offset) if isinstance(self.line, PanelLine) else base + offset

    def _without_contact(self, c: FloatArray) -> FloatArray:
        """J0, J1 and J2 of zones without contact."""

        def direct(c: FloatArray) -> FloatArray:
            return np.stack(zone_integrals(self.line, np.zeros_like(c), c, third=True))

        known = self._read(_APPROACH, c, direct)
        return direct(c) if known is None else known

    def _around_contact(self, s: FloatArray) -> FloatArray | None:
        """Width, J0 and J2 of zones around a contact by a table; None for few states."""

        def direct(s: FloatArray) -> FloatArray:
            place = self._position(*self._radii.place(s))
            width = self._width(place)
            j0, _, j2 = zone_integrals(self.line, place, width, third=True)
            return np.stack([width, j0, j2])

        return self._read(_GROWING, s, direct)

    def _read(
        self, branch: int, s: FloatArray, direct: Callable[[FloatArray], FloatArray]
    ) -> FloatArray | None:
        """Functions of the parameter on a branch by its table; None while a table would cost more than the states."""
        high = float(np.max(s, initial=0.0))
        table = self._tables.get(branch)
        if table is None or high > table.high[-1]:
            computed = self._computed.get(branch, 0) + s.size
            self._computed[branch] = computed
            start = 0.0 if branch == _APPROACH else self.ends[_AT_EDGE]
            if computed <= _FEW or high <= start:
                return None
            most = min(start + _BEYOND * (high - start), self.ends[branch])
            top = max(most, high)
            marks = np.array([start, *sorted({k for k in self.knots if start < k < top}), top])
            table = self._tables[branch] = tabulated(lambda s, _: direct(s), marks[:-1], marks[1:], _EFFORT)
            self._computed[branch] = 0
        values = table(s)
        left = np.flatnonzero(~np.isfinite(values).all(axis=0))
        if left.size:
            values[:, left] = direct(s[left])
        return values

    def _width(self, radius: Position) -> FloatArray:
        return _width_at(self.line, self._k, self.work / self.strength, radius, self.ends[_APPROACH])

    def states(self, s: ArrayLike) -> States:
        """Return the states at the parameters `s` [m].

        The force is F = 2E* int_0^a x g' dx + 2E* a (d - g(a)) on branch 5 and otherwise
        F = 2E* int_0^a x g' dx - 2σ0 [a sqrt(c² - a²) + c² arccos(a/c)].
        """
        s = np.asarray(s, dtype=float)
        zones = self._zones(s.ravel())
        a, c = zones.radius, zones.radius + zones.width
        root = zone_root(a, zones.width)
        springs = self._springs
        contact = springs.force(zones.place)
        force = contact - 2.0 * self.strength * (a * root + c**2 * np.arctan2(root, a))
        stuck = zones.branch == _STUCK
        pressed = contact + springs.stiffness(a) * (zones.indentation - springs.depth(zones.place))
        force = np.where(stuck, pressed, force)
        return States(*(x.reshape(s.shape) for x in (a, c, zones.indentation, force)))

    def slopes(self, s: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return dd/ds (dimensionless) and dF/ds [N/m]; the derivative to the right at a knot.

        On branch 3, with W = g'(a) + 2k a / sqrt(c² - a²), H_c = J0 + 2k [ψ/sin ψ - (c - a)/c] and k = σ0/E*:
        dc/da = ψ W / H_c and dd/da = W [J0 - 2k (c - a)/c] / H_c.
        """
        s = np.asarray(s, dtype=float)
        flat = s.ravel()
        at = np.flatnonzero((flat >= self.ends[_AT_EDGE]) & (flat < self.ends[_GROWING]))
        if at.size:
            # s does not resolve smaller radii, and the slope of a sharp tip may be infinite at 0
            tip = self.ends[_AT_EDGE] + np.finfo(float).eps * max(self.ends[_AT_EDGE], self.ends[_APPROACH])
            flat = flat.copy()
            flat[at] = self._radii.off_corners(np.maximum(flat[at], tip))
        zones = self._zones(flat)
        a, width = zones.radius, zones.width
        c, root = a + width, zone_root(a, width)
        angle = np.arctan2(root, a)
        springs = self._springs
        slope, rate = np.ones_like(a), springs.stiffness(a)
        k = self._k

        at = np.flatnonzero(zones.branch == _APPROACH)
        j0 = self._without_contact(np.maximum(width[at], 1e-18 * self.ends[_APPROACH]))[0]
        slope[at] = (2.0 / np.pi) * j0 - (4.0 / np.pi) * k
        rate[at] = -2.0 * np.pi * self.strength * c[at]

        at = np.flatnonzero(zones.branch == _GROWING)
        place = zones.place.take(at) if isinstance(zones.place, Place) else a[at]
        known = self._around_contact(flat[at])
        j0 = zone_integrals(self.line, place, width[at])[0] if known is None else known[1]
        steep = self.line.slope(place) + 2.0 * k * a[at] / root[at]
        closing = j0 + 2.0 * k * (angle[at] * c[at] / root[at] - width[at] / c[at])
        # at a corner g' is infinite, and all rates with it
        numerator = j0 - 2.0 * k * width[at] / c[at]
        slope[at] = steep * (numerator / closing)
        spread = 2.0 * k * c[at] * angle[at] ** 2
        rate[at] = springs.stiffness_rate(a[at]) * steep * ((a[at] * numerator - spread) / closing)
        per = self._radii.rate(flat[at])
        slope[at] *= per
        rate[at] *= per

        at = np.flatnonzero(zones.branch == _CLIPPED)
        a[at] = np.maximum(a[at], np.sqrt(np.finfo(float).eps) * own_edge(self.line))
        steep = self.line.slope(a[at])
        slope[at] = 2.0 * k + steep * root[at] / a[at]
        rate[at] = springs.stiffness_rate(a[at]) * (2.0 * k * a[at] + steep * root[at])
        return slope.reshape(s.shape), rate.reshape(s.shape)

    def energies(self, s: ArrayLike, indentation: ArrayLike | None = None) -> tuple[FloatArray, FloatArray]:
        """Return the elastic energy E* int_0^c w² dx and the energy of cohesion [J].

        The latter is -π c² γ + σ0 int_a^c gap 2π r dr, where the integral is
        4 [J2 + ½ (g(a) - d)(c² ψ - a sqrt(c² - a²)) - (2k/3)(c - a)² (2c + a)]. Indentations [m] serve on branch 5, where
        s resolves them to the rounding of the edge only.
        """
        s = np.asarray(s, dtype=float)
        zones = self._zones(s.ravel())
        a, width, d = zones.radius, zones.width, zones.indentation
        if indentation is not None:
            d = np.where(zones.branch == _STUCK, np.broadcast_to(indentation, s.shape).ravel(), d)
        c = a + width
        angle = np.arctan2(zone_root(a, width), a)
        opening = np.where(a > 0.0, self.line.g(zones.place), 0.0) - d
        solid = width**2 * (2.0 * c + a) / 3.0
        springs = self._springs
        pulled = 0.5 * springs.stiffness(a) * opening - springs.force(zones.place)
        elastic = springs.energy(zones.place) + opening * pulled
        elastic += self.modulus * (2.0 * self._k) ** 2 * solid
        j2 = np.zeros_like(a)
        flat = s.ravel()
        for branch in range(_BRANCHES):
            at = np.flatnonzero((width > 0.0) & (zones.branch == branch))
            if at.size == 0:
                continue
            place = zones.place.take(at) if isinstance(zones.place, Place) else a[at]
            known = self._around_contact(flat[at]) if branch == _GROWING else None
            if branch == _APPROACH:
                known = self._without_contact(width[at])
            j2[at] = zone_integrals(self.line, place, width[at], third=True)[2] if known is None else known[2]
        gaps = 4.0 * (j2 + 0.5 * opening * c**2 * segment(angle) - 2.0 * self._k * solid)
        cohesion = self.strength * gaps - np.pi * c**2 * self.work
        return elastic.reshape(s.shape), cohesion.reshape(s.shape)


def _last_branch(ends: tuple[float, ...]) -> int:
    """Return the last branch of nonzero length."""
    return max(i for i in range(_BRANCHES) if ends[i] > (0.0, *ends)[i])


def _width_at(
    line: EquivalentProfile, k: float, interaction_range: float, radius: Position, begin: float | None = None
) -> FloatArray:
    """Return δ [m] of the gap condition at contact radii; at most up to the end of the profile."""
    # without g the condition alone bounds δ: sqrt(c² - a²) ψ - δ >= (π/2 - 1) δ
    bound = np.pi * interaction_range / (4.0 * k * (0.5 * np.pi - 1.0)) if k > 0.0 else np.inf
    upper = np.minimum(
        bound * (1.0 + 1e-12), min(line.edge, line.max_radius) - np.asarray(radius, dtype=float)
    )
    if isinstance(line, PanelLine) and begin is None:
        begin = line.rough_radius(lambda x, g: g + k * x >= interaction_range)
    return solve_width(
        line,
        k,
        0.5 * np.pi * interaction_range,
        radius,
        upper,
        outward=True,
        begin=begin if isinstance(line, PanelLine) else None,
    )


def maugis_dugdale(line: EquivalentProfile, modulus: float, work: float, strength: float) -> MaugisDugdale:
    """Return the curve of Maugis-Dugdale states of a profile.

    Parameters
    ----------
    line : EquivalentProfile
        The equivalent profile, nondecreasing.
    modulus : float
        Effective modulus E* [Pa].
    work : float
        Work of adhesion γ > 0 [J/m²].
    strength : float
        Cohesive stress σ0 > 0 [Pa]; its range is h0 = γ/σ0.

    Returns
    -------
    MaugisDugdale
        The curve, with the ends of its branches.

    Raises
    ------
    ProblemError
        When γ, σ0 or E* is not positive, or the known profile ends inside the first cohesive zone.

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = equivalent_profile(Paraboloid(1.0))
    >>> curve = maugis_dugdale(ball, modulus=1.0, work=1.0, strength=0.8871133596609792)
    >>> state = curve.states(curve.ends[1] + 1.330670039491469)
    >>> round(float(state.cohesive_radius), 10), round(float(state.normal_force), 10)
    (1.8841779224, -4.9625446433)
    """
    for name, value in (("modulus", modulus), ("work", work), ("strength", strength)):
        if not (value > 0.0 and np.isfinite(value)):
            raise ProblemError(
                f"Maugis-Dugdale needs a positive {name}, not {value!r}; use JKR for zero range"
            )
    k, h0 = strength / modulus, work / strength
    edge, end = own_edge(line), min(line.edge, line.max_radius)
    first = float(_width_at(line, k, h0, np.zeros(1))[0])
    at_edge = growing = 0.0
    if first >= end:
        if not np.isfinite(edge):
            raise ProblemError(
                f"the profile is known only to {metres(end)}, but cohesion of range {metres(h0)} "
                "extends beyond it before contact; extend the profile or raise the strength"
            )
        height = (2.0 / np.pi) * float(zone_integrals(line, np.zeros(1), np.full(1, edge))[1][0])
        at_edge = max(h0 - 2.0 * k * edge * (1.0 - 2.0 / np.pi) - height, 0.0)
    elif np.isfinite(end):
        width = solve_width(line, k, 0.5 * np.pi * h0, np.full(1, end), np.full(1, end), outward=False)
        # a zone thinner than a rounding still lies inside
        growing = min(end - float(width[0]), float(np.nextafter(end, 0.0)))
    else:
        growing = np.inf
    clipped, stuck = (
        (np.sqrt((edge - growing) * (edge + growing)), np.inf) if np.isfinite(edge) else (0.0, 0.0)
    )
    grown = (
        float(radii_of(line, line.slope).parameter(np.array([growing]))[0])
        if np.isfinite(growing)
        else growing
    )
    ends = tuple(float(x) for x in np.cumsum([first, at_edge, grown, clipped, stuck]))

    return MaugisDugdale(line, modulus, work, strength, ends)
