"""Contact radius, indentation, force, stiffness and energy from one another, on any curve of contacts.

The kernels accept and return arrays. :func:`spring_foundation` is the discretised form of Popov and Hess (2015), in
which the method is taught and drawn; the kernels use the exact integrals.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError
from pymdr.line.curves import Curve
from pymdr.line.curves import ElasticLine as ElasticLine
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.numerics.panels import Place, Position, Selection, as_place
from pymdr.numerics.roots import boundary, rising_root
from pymdr.problem.values import values_html
from pymdr.units import FloatArray, metres, newtons

_DOUBT = 1e-9
"""Relative error of loads in the choice between intervals."""


@dataclass(frozen=True)
class DiskStates:
    """States of a disk contact, one entry per row."""

    indentation: FloatArray
    """d in m."""
    place: Place
    """a in m, with its distance from the last breakpoint; 0 without contact."""
    edge_excess: FloatArray
    """d - d0(a) in m: above 0 only at a sharp edge, where the pressure is singular."""

    @property
    def contact_radius(self) -> FloatArray:
        """A in m; 0 without contact."""
        return self.place.x

    def take(self, index: Selection) -> DiskStates:
        """Some of the states."""
        return DiskStates(self.indentation[index], self.place.take(index), self.edge_excess[index])


def disk_states(line: Curve, indentation: FloatArray, contact_radius: Position) -> DiskStates:
    """States from known indentations and contact radii in m."""
    place = as_place(contact_radius)
    excess = np.zeros(np.shape(place.x))
    at_edge = (place.x == line.edge) & np.isfinite(place.x)
    if at_edge.any():
        excess[at_edge] = np.maximum(indentation[at_edge] - line.depth(place.x[at_edge]), 0.0)
    return DiskStates(indentation, place, excess)


def states_at_depth(line: Curve, indentation: ArrayLike) -> DiskStates:
    """
    Contact radius from indentation, g(a) = d, cut at a sharp edge.

    If several disks have this depth, the one with the largest force is returned, the only possible solution (Barber 1974).

    Parameters
    ----------
    indentation : array_like
        d in m.

    Returns
    -------
    DiskStates
        Arrays of the shape of `indentation`; d <= 0 is no contact for rising profiles.

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> line = ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0)
    >>> states_at_depth(line, [0.25, -1.0]).contact_radius.tolist()
    [0.5, 0.0]
    """
    d = np.asarray(indentation, dtype=float)
    top = _touching_within(line, _deepest(d))
    if turning := _turning_points(line, top):
        return disk_states(line, d, _best_disk(line, d, turning, top))
    return disk_states(line, d, _inside(line, line.place(d)))


def _inside(line: Curve, place: Place) -> Place:
    """Places cut at a sharp edge."""
    beyond = place.x >= line.edge
    return Place(np.where(beyond, 0.0, place.base), np.where(beyond, line.edge, place.offset))


def rises_to(line: Curve, depth: float) -> bool:
    """Whether d0 rises at all radii at which bodies at a depth in m might touch; every contact is then a disk."""
    return not _turning_points(line, _touching_within(line, depth))


def _deepest(d: FloatArray) -> float:
    return float(np.max(d[np.isfinite(d)], initial=-math.inf))


def touching_radius(line: Curve | EquivalentProfile, depth: float) -> float:
    """
    A radius in m within which bodies at a depth in m touch, if they touch.

    A profile below its tip touches at negative depths: where f <= d < 0, f <= -d as well.
    """
    if depth > 0.0:
        return line.overlap_radius(depth)
    if math.isfinite(line.edge):
        # the rim of a hollow punch is its highest part
        return min(line.edge, line.max_radius)
    return line.overlap_radius(-depth) if -math.inf < depth < 0.0 else 0.0


def _touching_within(line: Curve, depth: float) -> float:
    """Largest radius in m at which d0 must be known for contacts of a depth in m; 0 where it rises."""
    return 0.0 if line.rises else touching_radius(line, depth)


def _turning_points(line: Curve, top: float) -> tuple[float, ...]:
    return line.turning_points(top) if top > 0.0 else ()


def _best_disk(line: Curve, d: FloatArray, turning: tuple[float, ...], top: float) -> Place:
    """The radius of the disk of largest force up to one in m; 0 where no disk carries load."""
    best = Place(np.zeros(d.shape), np.zeros(d.shape))
    load = np.zeros(d.shape)
    end = min(line.edge, top)
    ends = np.array([0.0, *(t for t in turning if 0.0 < t < end), end])
    g, k = line.depth(ends), line.stiffness(ends)
    unpressed = k * g - line.force(ends)
    surely, doubt = _sure_load(d, k, g, unpressed)
    for i in np.flatnonzero(g[1:] > g[:-1]):
        (low, high), (g_low, g_high) = ends[i : i + 2], g[i : i + 2]
        # k d0 - F0 = int d0 dk is convex over k here and above its tangents at both ends, so their corner bounds the load
        x = np.clip(
            (k[i + 1] * g_high - unpressed[i + 1] - k[i] * g_low + unpressed[i]) / (g_high - g_low),
            k[i],
            k[i + 1],
        )
        most = d * x - unpressed[i] - g_low * (x - k[i])
        inside = (d > g_low) & (d <= g_high)
        inside &= most >= surely - doubt - _DOUBT * max(abs(g_low), abs(g_high)) * k[i + 1]
        if inside.any():
            place = line.between(d[inside], float(low), float(high))
            _take_better(best, load, inside, place, line.force(place))
    if math.isfinite(line.edge):
        b = np.array([line.edge])
        excess = d - line.depth(b)[0]
        at_edge = excess >= 0.0
        whole = line.force(b)[0] + excess[at_edge] * line.stiffness(b)[0]
        _take_better(best, load, at_edge, Place(np.zeros(whole.shape), np.full(whole.shape, b[0])), whole)
    return best


def _sure_load(
    d: FloatArray, k: FloatArray, g: FloatArray, unpressed: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """
    The largest force k d - (k d0 - F0) at the ends of intervals, a lower bound for the best disk, and its rounding.

    It is the support of the lower convex hull of k d0 - F0 over k. If d0 is below d at the last end, the bound is 0.
    """
    hull = [0]
    for i in range(1, k.size):
        while len(hull) > 1 and (unpressed[i] - unpressed[hull[-1]]) * (k[hull[-1]] - k[hull[-2]]) <= (
            unpressed[hull[-1]] - unpressed[hull[-2]]
        ) * (k[i] - k[hull[-1]]):
            hull.pop()
        hull.append(i)
    x, below = k[hull], unpressed[hull]
    at = np.searchsorted(np.diff(below) / np.diff(x), d)
    reached = (d <= g[-1]) & np.isfinite(d)
    d = np.where(reached, d, 0.0)
    doubt = _DOUBT * (np.abs(d) + np.max(np.abs(g))) * x[at]
    return np.where(reached, d * x[at] - below[at], 0.0), np.where(reached, doubt, 0.0)


@dataclass(frozen=True)
class PassedRing:
    """A ring over which the disk of largest force jumps."""

    depth: float
    """The last depth in m before the jump."""
    inner: tuple[float, float]
    """Radii in m of the interval before the ring, on which d0 rises."""
    outer: tuple[float, float]
    """Radii in m of the interval beyond the ring."""


def passed_rings(line: Curve, deepest: float) -> tuple[PassedRing, ...]:
    """The rings over which a contact jumps up to a depth in m."""
    top = _touching_within(line, deepest)
    turning = _turning_points(line, top)
    if not turning or turning[0] == 0.0:
        return ()
    marks = np.array([0.0, *turning, *([top] * (1 + len(turning) % 2))])
    passed = marks[1:-2:2] < states_at_depth(line, [deepest]).contact_radius
    inner, outer = marks[:-2].reshape(-1, 2)[passed], marks[2:].reshape(-1, 2)[passed]
    low, _ = boundary(
        lambda d: states_at_depth(line, d).contact_radius <= inner[:, 1], np.zeros(outer.shape[0]), deepest
    )
    return tuple(
        PassedRing(float(depth), tuple(before), tuple(after))
        for depth, before, after in zip(low, inner.tolist(), outer.tolist(), strict=True)
    )


def _take_better(best: Place, load: FloatArray, where: np.ndarray, place: Place, value: FloatArray) -> None:
    better = value > load[where]
    index = np.flatnonzero(where)[better]
    best.base.flat[index], best.offset.flat[index] = place.base[better], place.offset[better]
    load.flat[index] = value[better]


def states_at_force(line: Curve, normal_force: ArrayLike) -> DiskStates:
    """
    Contact radius and indentation from the normal force.

    Parameters
    ----------
    line : Curve
    normal_force : array_like
        F in N, not below 0.

    Returns
    -------
    DiskStates
        Arrays of the shape of `normal_force`.

    Raises
    ------
    ConvergenceError
        If no indentation gives the force.

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> line = ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0)
    >>> states_at_force(line, [4 / 3]).indentation.tolist()
    [1.0]
    """
    force = np.asarray(normal_force, dtype=float)
    place = _inside(line, line.place_of_force(force))
    if not line.rises:
        # the force may occur only between turning points
        farthest = min(float(np.max(place.x, initial=0.0)), line.edge, line.max_radius)
        reached = _deepest(line.depth(place))
        top = max(touching_radius(line, reached), farthest)
        if math.isfinite(top) and (turning := _turning_points(line, top)):
            return _best_disk_at_force(line, force, turning, top)
    excess = np.zeros(force.shape)
    at_edge = place.x == line.edge
    if at_edge.any():
        at = place.take(at_edge)
        excess[at_edge] = np.maximum(force[at_edge] - line.force(at), 0.0) / line.stiffness(at)
    return DiskStates(line.depth(place) + excess, place, excess)


def states_at_travel(
    line: Curve, travel: ArrayLike, machine_stiffness: float, deepest: float = math.inf
) -> DiskStates:
    """
    Contact radius and indentation from the travel of a machine, d + F(d)/k = D.

    Parameters
    ----------
    travel : array_like
        D in m.
    machine_stiffness : float
        k in N/m, above 0.
    deepest : float
        An indentation in m that none of the contacts passes.

    Returns
    -------
    DiskStates
        Arrays of the shape of `travel`; without contact d = D.

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> line = ElasticLine(equivalent_profile(Paraboloid(1.0)), 0.75)
    >>> states_at_travel(line, [2.0, -1.0], machine_stiffness=1.0).indentation.round(14).tolist()
    [1.0, -1.0]
    """
    D = np.asarray(travel, dtype=float)
    most = np.minimum(D, deepest)
    d = most.copy()
    bent = np.asarray(normal_force(line, states_at_depth(line, most)) / machine_stiffness)
    loaded = bent > 0.0
    if loaded.any():
        # the rim of a hollow profile may be in contact before its axis would touch
        hollow = float(normal_force(line, states_at_depth(line, np.zeros(1)))[0]) / machine_stiffness
        pressed, high = D[loaded], most[loaded]
        d[loaded] = rising_root(
            lambda x: x + normal_force(line, states_at_depth(line, x)) / machine_stiffness,
            pressed,
            np.where(pressed >= hollow, 0.0, high - bent[loaded]),
            high,
        )
    return states_at_depth(line, d)


def _best_disk_at_force(line: Curve, force: FloatArray, turning: tuple[float, ...], top: float) -> DiskStates:
    end = min(line.max_radius, line.edge)

    def states(d: FloatArray) -> DiskStates:
        # as far out at all depths: where d0 falls below the tip, a contact is wide at depths of next to nothing
        return disk_states(line, d, _best_disk(line, d, turning, top))

    def load(d: FloatArray) -> FloatArray:
        return normal_force(line, states(d))

    # a disk that carries a force alone is no less deep than the best one, but for the rounding of both depths
    alone = _inside(line, line.place_of_force(np.max(force)))
    deepest = float(np.max(line.depth(alone)))
    depths = np.sort(line.depth(np.array([0.0, *(t for t in turning if t < end)])))
    if math.isfinite(deepest):
        deepest += 1e-12 * max(abs(deepest), float(np.max(np.abs(depths))))
        depths = np.append(depths[depths < deepest], deepest)
    if math.isfinite(line.edge):
        # as deep as the whole end carries the force
        b = np.array([line.edge])
        rest = float(np.max(force)) - float(line.force(b)[0])
        depths = np.append(depths, float(line.depth(b)[0]) + max(rest, 0.0) / float(line.stiffness(b)[0]))
    # beyond the depths with a fully known contact the computed load decreases again, so the first solution is taken
    loads = load(depths)
    carried = force * (1.0 - 1e-12) <= np.max(loads)
    if math.isfinite(deepest) and not carried.all():
        raise ConvergenceError(
            f"no indentation up to {metres(depths[-1])} gives {newtons(np.max(force))}; reduce the force, or extend the profile"
        )
    d = np.zeros(force.shape)
    loaded = carried & (force > 0.0)
    if loaded.any():
        most = float(np.max(force[loaded]))
        low = min(float(depths[0]), 0.0)
        high = float(depths[np.argmax(loads >= most * (1.0 - 1e-12))])
        d[loaded] = rising_root(load, force[loaded], low, high)
    best = states(d)
    return DiskStates(
        np.where(carried, best.indentation, math.nan),
        Place(best.place.base, np.where(carried, best.place.offset, math.inf)),
        best.edge_excess,
    )


def normal_force(line: Curve, states: DiskStates) -> FloatArray:
    """
    Normal force F = F0 + k w, for half-spaces 2 E* int_0^a (d - g) dx (Sneddon 1965; Popov and Hess 2015, eq. 3.8).

    Returns
    -------
    ndarray
        F in N.
    """
    force = line.force(states.place)
    if math.isfinite(line.edge):
        force = force + states.edge_excess * line.stiffness(states.place)
    return force


def normal_stiffness(line: Curve, states: DiskStates) -> FloatArray:
    """Normal stiffness dF/dd in N/m."""
    return line.stiffness(states.place)


def elastic_energy(line: Curve, states: DiskStates) -> FloatArray:
    """
    Elastic energy U = U0 + F0 w + k w^2 / 2, for half-spaces E* int_0^a (d - g)^2 dx.

    Returns
    -------
    ndarray
        U in J.
    """
    w = states.edge_excess
    energy = line.energy(states.place)
    if math.isfinite(line.edge):
        energy = energy + w * line.force(states.place) + 0.5 * w * w * line.stiffness(states.place)
    return energy


def mean_pressure(force: FloatArray, contact_radius: FloatArray) -> FloatArray:
    """Mean pressure F / (pi a^2) in Pa; 0 without contact."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(contact_radius == 0.0, 0.0, force / contact_radius / (math.pi * contact_radius))


@dataclass(frozen=True)
class SpringFoundation:
    """The discretised foundation of Popov and Hess: n springs under the equivalent profile.

    Popov and Hess (2015), chapter 3.
    """

    position: FloatArray
    """Centres x of the springs in m, on both sides."""
    profile: FloatArray
    """g(x) in m."""
    spacing: float
    """Delta x in m."""
    modulus: float
    """E* in Pa; each spring has the stiffness E* Delta x."""

    def spring_forces(self, indentation: float) -> FloatArray:
        """Force of every spring in N: E* Delta x (d - g) where that is positive, else 0."""
        return self.modulus * self.spacing * np.maximum(indentation - self.profile, 0.0)

    def normal_force(self, indentation: float) -> float:
        """Sum of all spring forces in N."""
        return float(self.spring_forces(indentation).sum())

    def contact_radius(self, indentation: float) -> float:
        """Half the length of the line in contact in m: half the number of pressed springs times Delta x."""
        return 0.5 * self.spacing * int(np.count_nonzero(indentation > self.profile))

    def _repr_html_(self) -> str:
        """The springs as a table, for notebooks."""
        rows = (
            ("position", self.position, "m"),
            ("profile", self.profile, "m"),
            ("spacing", self.spacing, "m"),
            ("modulus", self.modulus, "Pa"),
        )
        return values_html(type(self).__name__, rows)


def spring_foundation(line: ElasticLine, half_length: float, n: int) -> SpringFoundation:
    """
    Put n springs on [-half_length, half_length].

    Parameters
    ----------
    line : ElasticLine
        Profile and modulus.
    half_length : float
        In m, above 0.
    n : int
        Number of springs, at least 2.

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> springs = spring_foundation(ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0), 2.0, 4000)
    >>> round(springs.normal_force(1.0), 5)
    1.33333
    """
    spacing = 2.0 * half_length / n
    x = np.asarray((np.arange(n) + 0.5) * spacing - half_length, dtype=float)
    g = line.equivalent.g(np.minimum(np.abs(x), line.equivalent.edge))
    return SpringFoundation(x, np.where(np.abs(x) > line.equivalent.edge, math.inf, g), spacing, line.modulus)
