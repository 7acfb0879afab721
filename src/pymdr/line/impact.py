"""Impacts on a curve of contacts, by quadrature: durations and states of rest.

A reduced mass m in the potential E(s) of a contact keeps m v^2 / 2 + E(s) = C between two jumps. It passes from one
parameter to another in int d'(s) ds / v. Where it comes to rest, that integrand has no bound; there the momentum
m v = p cos(phi) is the variable, dt = p sin(phi) dphi / F, and s follows from E(s) = C - (p^2 / 2 m) cos(phi)^2, in
which nothing cancels. All integrals are double-exponential between the knots of the curve. Many collisions are followed
at once, one per row.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy
from numpy.polynomial import chebyshev

from pymdr.errors import ConvergenceError
from pymdr.line.curves import Curve
from pymdr.line.foundation import elastic_energy, normal_force, states_at_depth
from pymdr.numerics.quadrature import gauss
from pymdr.units import FloatArray

_RANGE, _STEP = 3.2, 0.125
_TURNS = 100
_TERMS = 24
_STILL = 1e-15


class Along(NamedTuple):
    """States of a contact at some parameters."""

    depth: FloatArray
    """In m."""
    rate: FloatArray
    """dd/ds."""
    force: FloatArray
    """In N."""
    energy: FloatArray
    """In J."""


@dataclass(frozen=True)
class Potential:
    """A curve of contacts on which a mass moves, dE = F dd."""

    at: Callable[[FloatArray], Along]
    """The states at parameters s, arrays of one dimension."""
    knots: tuple[float, ...] = ()
    """Parameters at which the curve is not smooth."""

    def along(self, s: FloatArray) -> Along:
        """The states at parameters in an array of any shape."""
        return Along(*(x.reshape(s.shape) for x in self.at(s.ravel())))


@dataclass(frozen=True)
class Passage:
    """One stretch of a collision, one entry per row."""

    parameter: FloatArray
    """S, rising or falling."""
    time: FloatArray
    """Time in s since the first row."""
    speed: FloatArray
    """|dd/dt| in m/s."""


def elastic_potential(line: Curve, deepest: float) -> Potential:
    """
    The elastic energy over the indentation, which is the parameter.

    Parameters
    ----------
    line : Curve
    deepest : float
        Up to which depth in m knots are needed.

    Examples
    --------
    >>> from pymdr.line.curves import ElasticLine
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> hertz = elastic_potential(ElasticLine(equivalent_profile(Paraboloid(1.0)), 0.75), 1.0)
    >>> [float(x[0]) for x in hertz.at(np.array([1.0]))]
    [1.0, 1.0, 1.0, 0.4]
    """

    def at(d: FloatArray) -> Along:
        states = states_at_depth(line, d)
        return Along(d, np.ones(d.shape), normal_force(line, states), elastic_energy(line, states))

    radii = [b for b in (*line.breakpoints, line.edge) if b <= line.max_radius and math.isfinite(b)]
    depths = line.depth(np.array(radii)) if radii else np.zeros(0)
    return Potential(at, tuple(sorted({float(d) for d in depths if 0.0 < d < deepest})))


def depths_of_energy(potential: Potential, energy: FloatArray, deepest: float) -> FloatArray:
    """
    The indentations at which an elastic energy is stored, E(d) = energy.

    Parameters
    ----------
    potential : Potential
        Of :func:`elastic_potential`.
    energy : ndarray
        In J, above 0.
    deepest : float
        A depth in m that stores at least as much.

    Returns
    -------
    ndarray
        In m.

    Examples
    --------
    >>> from pymdr.line.curves import ElasticLine
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> hertz = elastic_potential(ElasticLine(equivalent_profile(Paraboloid(1.0)), 0.75), 1.0)
    >>> depths_of_energy(hertz, np.array([0.4]), 2.0).round(14).tolist()
    [1.0]
    """
    low, high = np.zeros(energy.shape), np.full(energy.shape, deepest)
    d = high.copy()
    for _ in range(_TURNS):
        here = potential.along(d)
        above = here.energy >= energy
        low, high = np.where(above, low, d), np.where(above, d, high)
        # energies grow like powers of the depth: Newton in logarithms
        with np.errstate(all="ignore"):
            step = d * np.exp(np.log(energy / here.energy) * here.energy / (here.force * d))
        before, d = d, np.where((step >= low) & (step <= high), step, 0.5 * (low + high))
        moved = np.abs(d - before)
        if np.all(moved <= 4.0 * _STILL * d):
            break
    if not np.all(moved <= 1e-12 * d):
        raise ConvergenceError(
            "the search for the largest indentation did not converge; check the magnitudes of mass and speed"
        )
    return d


def parameter_of_energy(potential: Potential, energy: float, begin: float, end: float) -> float:
    """The parameter between two others at which an energy in J is met, E(s) - energy changing its sign between them."""

    def missing(s: float) -> float:
        return float(potential.along(np.array([s])).energy[0]) - energy

    low, high = missing(begin), missing(end)
    if low == 0.0 or high == 0.0 or low * high > 0.0:
        return begin if abs(low) < abs(high) else end
    return float(
        scipy.optimize.brentq(missing, begin, end, xtol=4e-16 * max(abs(begin), abs(end)), rtol=1e-15)
    )


def move(
    potential: Potential, mass: float, total: float, begin: float, end: float, rows: FloatArray
) -> Passage:
    """
    Pass from one parameter to another without rest.

    Parameters
    ----------
    mass : float
        M in kg.
    total : float
        C = m v^2 / 2 + E in J.
    begin, end : float
        Parameters; `end` may be below `begin`.
    rows : ndarray
        Fractions of the distance, rising from 0 to 1, at which rows are required.
    """
    low, high = min(begin, end), max(begin, end)
    wanted = np.clip(begin + (end - begin) * rows, low, high)
    inner = [k for k in potential.knots if low < k < high]
    marks = np.unique(np.concatenate([wanted, inner]))
    lasting = np.append(0.0, np.cumsum(passing_times(potential, mass, np.array([total]), marks[None])[0]))
    time = lasting[np.searchsorted(marks, wanted)]
    kinetic = total - potential.along(wanted).energy
    return Passage(wanted, np.abs(time - time[0]), np.sqrt(2.0 * np.maximum(kinetic, 0.0) / mass))


def stop(
    potential: Potential, mass: float, total: float, begin: float, rest: float, rows: FloatArray
) -> Passage:
    """
    Pass from a parameter to the state of rest, at which E = C, on an interval without a change of sign of the force.

    Parameters
    ----------
    potential, mass, total, rows
        As in :func:`move`; `rows` are shares of the angle phi, the momentum falling like cos(phi).
    begin, rest : float
        Parameters.
    """
    low, high = min(begin, rest), max(begin, rest)
    knots = np.array([k for k in potential.knots if low < k < high])
    start = float(potential.along(np.array([begin])).energy[0])
    kinetic = total - start
    fraction = (potential.along(knots).energy - start) / kinetic
    angles = 0.5 * math.pi * rows
    marks = np.unique(np.concatenate([angles, np.arcsin(np.sqrt(np.clip(fraction, 0.0, 1.0)))]))
    given = (np.array([begin]), np.array([rest]))
    times = stopping_times(potential, mass, np.array([kinetic]), *given, marks[None])[0]
    time = np.append(0.0, np.cumsum(times))[np.searchsorted(marks, angles)]
    parameter = _at_angle(potential, np.array([kinetic]), *given, angles[None])[0][0]
    parameter[rows == 0.0], parameter[rows == 1.0] = begin, rest
    speed = math.sqrt(2.0 * kinetic / mass) * np.cos(angles)
    return Passage(parameter, time, np.where(rows == 1.0, 0.0, speed))


def passing_times(potential: Potential, mass: float, total: FloatArray, marks: FloatArray) -> FloatArray:
    """
    Times in s between successive parameters, int |d'| ds / v.

    Parameters
    ----------
    mass : float
        In kg.
    total : ndarray, shape (n,)
        C in J, above E between the parameters.
    marks : ndarray, shape (n, k)
        Parameters, not falling, the knots among them.

    Returns
    -------
    ndarray, shape (n, k - 1)
    """
    width, s, weights = _panels(marks)
    here = potential.along(s)
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = np.sqrt(2.0 * (total[:, None, None] - here.energy) / mass)
        rate = np.where(width[..., None] > 0.0, np.abs(here.rate) / speed, 0.0)
    return np.asarray(width * (rate @ weights))


def stopping_times(
    potential: Potential,
    mass: float,
    kinetic: FloatArray,
    begin: FloatArray,
    rest: FloatArray,
    marks: FloatArray,
) -> FloatArray:
    """
    Times in s between successive angles phi of the momentum p cos(phi), int p sin(phi) dphi / |F|.

    Parameters
    ----------
    mass : float
        In kg.
    kinetic : ndarray, shape (n,)
        M v^2 / 2 in J at `begin`, all of which is stored at `rest`.
    begin, rest : ndarray, shape (n,)
        Parameters between which the force does not turn.
    marks : ndarray, shape (n, k)
        Angles in [0, pi/2], not falling, those of the knots among them.

    Returns
    -------
    ndarray, shape (n, k - 1)
    """
    width, angle, weights = _panels(marks)
    flat = angle.reshape(angle.shape[0], -1)
    force = np.abs(_at_angle(potential, kinetic, begin, rest, flat)[1]).reshape(angle.shape)
    momentum = np.sqrt(2.0 * mass * kinetic)[:, None, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.where(width[..., None] > 0.0, momentum * np.sin(angle) / force, 0.0)
    return np.asarray(width * (rate @ weights))


def _at_angle(
    potential: Potential, kinetic: FloatArray, begin: FloatArray, rest: FloatArray, angle: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Parameters at angles of the momentum, shape (n, k), and the force there: E(s) = E(begin) + K sin(phi)^2."""
    base = potential.along(begin).energy
    gained = np.sin(angle) ** 2
    target = base[:, None] + kinetic[:, None] * gained
    first, last = begin[:, None] + 0.0 * angle, rest[:, None] + 0.0 * angle
    s = first + (last - first) * gained
    length = np.abs(rest - begin)[:, None]
    for _ in range(_TURNS):
        here = potential.along(s)
        short = here.energy < target
        first, last = np.where(short, s, first), np.where(short, last, s)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = s - (here.energy - target) / (here.force * here.rate)
        inside = (step - first) * (step - last) <= 0.0
        step = np.where(inside, step, 0.5 * (first + last))
        moved = np.abs(step - s)
        s = step
        # the last step is beyond what is seen of it: Newton squares it
        if np.all(moved <= 1e-9 * length):
            break
    return s, potential.along(s).force


def at_many(
    function: Callable[[FloatArray], FloatArray], x: FloatArray, marks: FloatArray, tolerance: float = 1e-12
) -> FloatArray:
    """
    Rows of a function at many points, by Chebyshev series where these take fewer calls.

    Parameters
    ----------
    function : callable
        Rows (k, n) of values at n points.
    x : ndarray, shape (n,)
    marks : ndarray
        Points at which the function is not smooth.
    tolerance : float
        Largest difference from a series, between its nodes.

    Returns
    -------
    ndarray, shape (k, n)

    Examples
    --------
    >>> x = np.linspace(0.0, 1.0, 1000)
    >>> calls = []
    >>> def sine(x):
    ...     calls.append(x.size)
    ...     return np.sin(x)[None]
    >>> bool(np.max(np.abs(at_many(sine, x, np.zeros(0)) - np.sin(x))) < 1e-13), sum(calls)
    (True, 32)
    """
    low, high = float(x.min()), float(x.max())
    ends = np.array([low, *sorted(m for m in marks if low < m < high), high])
    first = np.clip(np.searchsorted(ends, x, side="right") - 1, 0, ends.size - 2)
    left = [(ends[i], ends[i + 1], np.flatnonzero(first == i)) for i in range(ends.size - 1)]
    result: FloatArray | None = None
    while left:
        begin, end, which = left.pop()
        if which.size == 0:
            continue
        values: FloatArray | None = None
        if which.size > 2 * _TERMS and end > begin:
            middle, half = 0.5 * (begin + end), 0.5 * (end - begin)
            nodes = np.cos(math.pi * (np.arange(_TERMS) + 0.5) / _TERMS)
            series = chebyshev.chebfit(nodes, function(middle + half * nodes).T, _TERMS - 1)
            between = 0.5 * (nodes[1:] + nodes[:-1])[::3]
            missed = np.abs(chebyshev.chebval(between, series) - function(middle + half * between))
            if not np.max(missed) <= tolerance:
                over = x[which] > middle
                left += [(begin, middle, which[~over]), (middle, end, which[over])]
                continue
            values = chebyshev.chebval((x[which] - middle) / half, series)
        else:
            values = function(x[which])
        result = np.empty((values.shape[0], x.size)) if result is None else result
        result[:, which] = values
    assert result is not None
    return result


def work(potential: Potential, marks: FloatArray) -> float:
    """The work int F dd in J between the first and the last of some rising parameters, by quadrature of the force."""
    width, s, weights = _panels(marks[None])
    here = potential.along(s)
    return float((width * ((here.force * here.rate) @ weights)).sum())


def _double_exponential() -> tuple[FloatArray, FloatArray]:
    """Nodes and weights on [0, 1] for integrands that are bounded at the ends of a panel."""
    t = np.arange(-_RANGE, _RANGE + 0.5 * _STEP, _STEP)
    bent = 0.5 * math.pi * np.sinh(t)
    weights = _STEP * 0.25 * math.pi * np.cosh(t) / np.cosh(bent) ** 2
    return 1.0 / (1.0 + np.exp(-2.0 * bent)), weights / weights.sum()


_ENDS = _double_exponential()
_MANY = 500
"""Number of panels from which on eight nodes per panel suffice."""


def _panels(marks: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Widths (n, k - 1), nodes (n, k - 1, nodes) and their weights (nodes,) of panels."""
    width = np.diff(marks, axis=1)
    nodes, weights = gauss(8) if width.shape[1] > _MANY else _ENDS
    return width, marks[:, :-1, None] + width[..., None] * nodes, weights
