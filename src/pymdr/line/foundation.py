"""The elastic line: contact radius, indentation, force, stiffness and energy from one another.

The kernels take and give arrays. :func:`spring_foundation` is the discretised form of the founding paper, in
which the method is taught and drawn; the kernels use the exact integrals.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError
from pymdr.mapping.equivalent import EquivalentProfile, NumericLine, ProxyLine, rising_root
from pymdr.units import FloatArray, metres, newtons


@dataclass(frozen=True)
class ElasticLine:
    """Independent springs of stiffness E* per length under an equivalent profile."""

    equivalent: EquivalentProfile
    modulus: float
    """E* in Pa."""


@dataclass(frozen=True)
class DiskStates:
    """States of a disk contact, one entry per row."""

    indentation: FloatArray
    """d in m."""
    contact_radius: FloatArray
    """a in m; 0 without contact."""
    edge_excess: FloatArray
    """d - g(a) in m: above 0 only at a sharp edge, where the pressure is singular."""


def disk_states(line: ElasticLine, indentation: FloatArray, contact_radius: FloatArray) -> DiskStates:
    """States from known indentations and contact radii in m."""
    return DiskStates(indentation, contact_radius, _edge_excess(line.equivalent, contact_radius, indentation))


def line_upto_depth(line: ElasticLine, depth: float) -> ElasticLine:
    """
    The line made fast on every radius that a contact of up to the given indentation can reach.

    Parameters
    ----------
    line : ElasticLine
    depth : float
        Largest indentation in m.

    Returns
    -------
    ElasticLine
    """
    equivalent = line.equivalent
    if not isinstance(equivalent, NumericLine):
        return line
    return ElasticLine(equivalent.upto(equivalent.top_for(depth)), line.modulus)


def line_upto_force(line: ElasticLine, force: float) -> ElasticLine:
    """
    The line made fast on every radius that a contact of up to the given force can reach.

    Parameters
    ----------
    line : ElasticLine
    force : float
        Largest normal force in N.

    Returns
    -------
    ElasticLine
    """
    equivalent = line.equivalent
    if not isinstance(equivalent, NumericLine):
        return line
    top = equivalent.top_for(force / (2.0 * line.modulus), "moment")
    return ElasticLine(equivalent.upto(top), line.modulus)


def states_at_depth(line: ElasticLine, indentation: ArrayLike) -> DiskStates:
    """
    Contact radius from indentation, g(a) = d, cut at a sharp edge.

    Where g does not rise, the disk of largest force is taken, which is the only one that can be the
    solution (Barber 1974).

    Parameters
    ----------
    line : ElasticLine
        Profile and modulus.
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
    equivalent = line.equivalent
    if isinstance(equivalent, ProxyLine) and not equivalent.rises:
        a = _best_disk(equivalent, d)
    else:
        a = np.minimum(equivalent.inverse(d), equivalent.edge)
    return disk_states(line, d, a)


def _edge_excess(equivalent: EquivalentProfile, a: FloatArray, d: FloatArray) -> FloatArray:
    excess = np.zeros(np.shape(a))
    at_edge = a == equivalent.edge
    if at_edge.any():
        excess[at_edge] = np.maximum(d[at_edge] - equivalent.g(a[at_edge]), 0.0)
    return excess


def _rising_branches(equivalent: ProxyLine) -> list[tuple[float, float]]:
    """Intervals of x on which g rises."""
    ends = np.array([0.0, *(t for t in equivalent.turning_points if t > 0.0), equivalent.reach])
    g = equivalent.g(ends)
    return [(ends[i], ends[i + 1]) for i in range(ends.size - 1) if g[i + 1] > g[i]]


def _best_disk(equivalent: ProxyLine, d: FloatArray) -> FloatArray:
    """The radius of largest d a - int_0^a g; 0 where no disk carries load."""
    best = np.zeros(d.shape)
    load = np.zeros(d.shape)
    for low, high in _rising_branches(equivalent):
        g_low, g_high = (float(equivalent.g(np.array([x]))[0]) for x in (low, high))
        inside = (d > g_low) & (d <= g_high)
        if inside.any():
            a = rising_root(equivalent.g, d[inside], np.full(inside.sum(), low), np.full(inside.sum(), high))
            _take_better(best, load, inside, a, d[inside] * a - equivalent.integral(a))
    if math.isfinite(equivalent.edge):
        b = equivalent.edge
        at_edge = d >= float(equivalent.g(np.array([b]))[0])
        whole = d[at_edge] * b - float(equivalent.integral(np.array([b]))[0])
        _take_better(best, load, at_edge, np.full(at_edge.sum(), b), whole)
    return best


def _take_better(
    best: FloatArray, load: FloatArray, where: np.ndarray, a: FloatArray, value: FloatArray
) -> None:
    better = value > load[where]
    index = np.flatnonzero(where)[better]
    best.flat[index] = a[better]
    load.flat[index] = value[better]


def states_at_force(line: ElasticLine, normal_force: ArrayLike) -> DiskStates:
    """
    Contact radius and indentation from the normal force.

    Parameters
    ----------
    line : ElasticLine
        Profile and modulus.
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
    equivalent = line.equivalent
    moment = force / (2.0 * line.modulus)
    if isinstance(equivalent, ProxyLine) and not equivalent.rises:
        return states_at_depth(line, _depth_of_best_disk(line, force))
    b = equivalent.edge
    if not math.isfinite(b):
        a = equivalent.inverse_moment(moment)
        return DiskStates(equivalent.g(a), a, np.zeros(np.shape(a)))
    m_edge, g_edge = (float(curve(np.array([b]))[0]) for curve in (equivalent.moment, equivalent.g))
    at_edge = moment > m_edge
    a = np.where(moment > 0.0, b, 0.0)
    a[~at_edge] = np.minimum(equivalent.inverse_moment(moment[~at_edge]), b)
    excess = np.where(at_edge, (moment - m_edge) / b, 0.0)
    d = np.where(at_edge, g_edge + excess, 0.0)
    d[~at_edge] = equivalent.g(a[~at_edge])
    return DiskStates(d, a, excess)


def states_at_travel(line: ElasticLine, travel: ArrayLike, machine_stiffness: float) -> DiskStates:
    """
    Contact radius and indentation from the travel of a machine, d + F(d)/k = D.

    Parameters
    ----------
    line : ElasticLine
        Profile and modulus.
    travel : array_like
        D in m.
    machine_stiffness : float
        k in N/m, above 0.

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
    d = D.copy()
    loaded = (states_at_depth(line, D).contact_radius > 0.0) & (D > 0.0)
    if not loaded.any():
        return states_at_depth(line, d)
    equivalent = line.equivalent
    if isinstance(equivalent, ProxyLine) and not equivalent.rises:
        pressed = rising_root(
            lambda x: x + normal_force(line, states_at_depth(line, x)) / machine_stiffness,
            D[loaded],
            np.zeros(int(loaded.sum())),
            D[loaded],
        )
        d[loaded] = pressed
        return states_at_depth(line, d)
    a = np.minimum(equivalent.inverse(D), equivalent.edge)
    soft = 2.0 * line.modulus / machine_stiffness
    reached = equivalent.g(a) + soft * equivalent.moment(a)
    inside = loaded & (reached > D)
    stuck = loaded & ~inside
    if inside.any():
        a[inside] = rising_root(
            lambda x: equivalent.g(x) + soft * equivalent.moment(x),
            D[inside],
            np.zeros(int(inside.sum())),
            a[inside],
        )
        d[inside] = equivalent.g(a[inside])
    excess = np.zeros(D.shape)
    if stuck.any():
        excess[stuck] = (D[stuck] - reached[stuck]) / (1.0 + soft * a[stuck])
        d[stuck] = equivalent.g(a[stuck]) + excess[stuck]
    return DiskStates(d, np.where(loaded, a, 0.0), excess)


def _depth_of_best_disk(line: ElasticLine, force: FloatArray) -> FloatArray:
    equivalent = line.equivalent
    assert isinstance(equivalent, ProxyLine)
    end = min(equivalent.reach, equivalent.edge)
    depths = np.sort(
        equivalent.g(np.array([0.0, *equivalent.turning_points, *np.linspace(0.0, end, 65)[1:]]))
    )

    def load(d: FloatArray) -> FloatArray:
        return normal_force(line, states_at_depth(line, d))

    if math.isfinite(equivalent.edge):
        deepest = float(depths[-1]) + float(np.max(force)) / (2.0 * line.modulus * equivalent.edge)
        depths = np.append(depths, deepest)
    # beyond the depths whose whole contact is known the load falls again, so the first that suffices is taken
    enough = np.flatnonzero(load(depths) >= np.max(force))
    if enough.size == 0:
        raise ConvergenceError(f"no indentation up to {metres(depths[-1])} gives {newtons(np.max(force))}")
    low, high = min(float(depths[0]), 0.0), float(depths[enough[0]])
    d = np.zeros(force.shape)
    loaded = force > 0.0
    d[loaded] = rising_root(load, force[loaded], low, high)
    return d


def normal_force(line: ElasticLine, states: DiskStates) -> FloatArray:
    """
    Normal force F = 2 E* int_0^a (d - g) dx (Sneddon 1965; Popov and Hess 2015, eq. 3.8).

    Parameters
    ----------
    line : ElasticLine
    states : DiskStates

    Returns
    -------
    ndarray
        F in N.
    """
    a = states.contact_radius
    force = line.equivalent.moment(a)
    if math.isfinite(line.equivalent.edge):
        force = force + states.edge_excess * a
    return 2.0 * line.modulus * force


def normal_stiffness(line: ElasticLine, states: DiskStates) -> FloatArray:
    """Normal stiffness dF/dd = 2 E* a in N/m."""
    return 2.0 * line.modulus * states.contact_radius


def elastic_energy(line: ElasticLine, states: DiskStates) -> FloatArray:
    """
    Elastic energy U = E* int_0^a (d - g)^2 dx.

    Parameters
    ----------
    line : ElasticLine
    states : DiskStates

    Returns
    -------
    ndarray
        U in J.
    """
    a, w = states.contact_radius, states.edge_excess
    energy = line.equivalent.squared(a)
    if math.isfinite(line.equivalent.edge):
        energy = energy + 2.0 * w * line.equivalent.moment(a) + w * w * a
    return line.modulus * energy


def mean_pressure(force: FloatArray, contact_radius: FloatArray) -> FloatArray:
    """Mean pressure F / (pi a^2) in Pa; 0 without contact."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(contact_radius > 0.0, force / (math.pi * contact_radius * contact_radius), 0.0)


@dataclass(frozen=True)
class SpringFoundation:
    """The discretised foundation of the founding paper: n springs under the equivalent profile.

    Popov and Hess (2015), chapter 3; eqs. (5) to (11) of the founding discussion paper.
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

    Returns
    -------
    SpringFoundation

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
