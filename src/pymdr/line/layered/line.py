"""
The disk of a layered body, the half-spaces that carry the same load, and a lower bound of the force, from trial pressures.

The true pressure p and a trial pressure t, both non-negative, do the same work on each other's displacements. If the
displacement by t is at most 1, the force is at least the work of t on the true displacements, which are at least d - f:

    F = int p dA >= int p u[t] dA = int t u[p] dA >= int t (d - f) dA

(Shield 1967; Barber 1974). On half-spaces t is the pressure of a flat punch. On a stiff layer that may be negative; then enough
of the pressure under a punch on half-spaces is added to make it non-negative, and the sum is divided by its largest displacement.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import ConvergenceError
from pymdr.line.curves import Carried, Contacts, ElasticLine, Profiled, Punch
from pymdr.line.layered.coupled import Added, Coupled
from pymdr.line.layered.equation import WIDEST, Outline, Solved, solve_contact
from pymdr.line.layered.tables import DEPTH, EDGE, ENERGY, FORCE, STIFFNESS, Limit, Table
from pymdr.mapping.equivalent import EquivalentProfile, equivalent_profile
from pymdr.mapping.layers import Kernel
from pymdr.numerics.panels import BoolArray, Place, Position, as_place
from pymdr.numerics.roots import rising_root
from pymdr.problem.profiles import FlatPunch
from pymdr.units import FloatArray


@dataclass(frozen=True)
class LayeredLine(Profiled):
    """
    The line of layers under an equivalent profile.

    Parameters
    ----------
    equivalent : EquivalentProfile
        g(x) of the profile, as for half-spaces.
    kernel : Kernel
        What the surface of the body does.

    Notes
    -----
    Curves are read from a table of solved contacts, extended on request; its relative errors, measured between
    its nodes and by doubled quadratures, are part of :meth:`error`.

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.mapping.layers import kernel_of
    >>> from pymdr.problem.layers import Layer, Layered
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Paraboloid
    >>> film = kernel_of(Layered([Layer(Elastic(0.75, 0.5), 1.0)]))
    >>> LayeredLine(equivalent_profile(Paraboloid(1.0)), film).stiffness([1.0]).round(9).tolist()
    [7.237471698]
    """

    equivalent: EquivalentProfile
    kernel: Kernel
    table: Table = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "table", Table(self.equivalent, self.kernel))

    @property
    def modulus(self) -> float:
        """E* of the top layer in Pa."""
        return self.kernel.compliance.modulus

    @property
    def thickness(self) -> float:
        """Thickness of the top layer in m."""
        return self.table.thickness

    def _read(self, a: Position, column: int, slopes: bool = False) -> FloatArray:
        return np.asarray(self._columns(a, (column,), slopes)[0])

    def _columns(self, a: Position, which: tuple[int, ...], slopes: bool = False) -> FloatArray:
        place = as_place(a)
        flat = Place(np.ravel(place.base), np.ravel(place.offset))
        return self.table.read(flat, which, slopes).T.reshape(len(which), *np.shape(place.offset))

    def depth(self, a: Position) -> FloatArray:
        """The indentation d0 in m."""
        return self.equivalent.g(a) * self._read(a, DEPTH)

    def depth_rate(self, a: Position) -> FloatArray:
        """The derivative d0'(a)."""
        g, slope = self.equivalent.g(a), self.equivalent.slope(a)
        with np.errstate(invalid="ignore"):
            rate = slope * self._read(a, DEPTH) + np.where(
                g == 0.0, 0.0, g * self._read(a, DEPTH, slopes=True)
            )
        return np.where(np.isinf(slope), slope, rate)

    def force(self, a: Position) -> FloatArray:
        """The normal force F0 in N."""
        return 2.0 * self.modulus * self.equivalent.moment(a) * self._read(a, FORCE)

    def energy(self, a: Position) -> FloatArray:
        """The elastic energy U0 in J."""
        return self.modulus * self.equivalent.squared(a) * self._read(a, ENERGY)

    def stiffness(self, a: Position) -> FloatArray:
        """The normal stiffness k in N/m."""
        return 2.0 * self.modulus * np.asarray(a, dtype=float) * self._read(a, STIFFNESS)

    def stiffness_rate(self, a: Position) -> FloatArray:
        """The derivative k' in N/m^2."""
        return 2.0 * self.modulus * self._read(a, EDGE) ** 2

    def punch(self, a: Position) -> Punch:
        """Stiffnesses of flat punches of some radii, with their derivatives."""
        stiffness, edge = self._columns(a, (STIFFNESS, EDGE))
        radius, size = np.asarray(a, dtype=float), 2.0 * self.modulus
        power = 2.0 * radius * self._read(a, EDGE, slopes=True) / edge
        return Punch(size * radius * stiffness, size * edge**2, power)

    def contacts(self, a: Position) -> Contacts:
        """The smooth contacts and the punches of some radii."""
        depth, force, stiffness, edge = self._columns(a, (DEPTH, FORCE, STIFFNESS, EDGE))
        size = 2.0 * self.modulus
        return Contacts(
            self.equivalent.g(a) * depth,
            size * self.equivalent.moment(a) * force,
            size * np.asarray(a, dtype=float) * stiffness,
            size * edge**2,
        )

    def under(self, equivalent: EquivalentProfile) -> LayeredLine:
        """The same bodies under another profile."""
        return self if equivalent is self.equivalent else LayeredLine(equivalent, self.kernel)

    def error(self, place: Position) -> FloatArray:
        """Measured relative errors of d0, d0', F0 and U0: those of the map of the profile and of the table."""
        at = as_place(place)
        errors = self.table.error(Place(np.ravel(at.base), np.ravel(at.offset)))
        punch = np.maximum(errors[:, STIFFNESS], errors[:, EDGE])
        own = np.stack(
            [errors[:, DEPTH], errors[:, DEPTH] + punch, errors[:, FORCE], errors[:, ENERGY]], axis=1
        )
        return self.equivalent.error(place) + own.reshape(*np.shape(at.offset), 4)

    def place(self, depth: ArrayLike) -> Place:
        """The first radius at which d0 has a value in m; inf where it never has."""
        return self.table.first(DEPTH, np.asarray(depth, dtype=float))

    def place_of_force(self, force: ArrayLike) -> Place:
        """The first radius at which F0 has a value in N."""
        return self.table.first(FORCE, np.asarray(force, dtype=float) / (2.0 * self.modulus))

    def between(self, depth: FloatArray, low: float, high: float) -> Place:
        """The radii at which d0 has values in m on a stretch on which it rises."""
        ends = np.full(depth.shape, low), np.full(depth.shape, high)
        x = rising_root(self.depth, depth, *ends)
        return Place(np.zeros(x.shape), x)

    def turning_points(self, top: float) -> tuple[float, ...]:
        """No radii: an equivalent profile that decreases is refused."""
        self.table.refuse_falling(top)
        return ()

    def overlap_radius(self, depth: float) -> float:
        """The largest radius in m at which the bodies would overlap if they were shifted by a depth in m, or touch."""
        touching = float(self.place(depth).x)
        return max(self.equivalent.overlap_radius(depth), min(touching, self.edge, self.max_radius))

    def rough_radius(self, reached: Callable[[FloatArray, FloatArray], BoolArray]) -> float:
        """A radius a in m near which ``reached(a, d0)`` becomes true, going outward."""
        return self.table.rough_radius(reached)

    def limit(self, is_enough: Callable[[float, float], bool]) -> Limit | None:
        """The deepest contact that can be solved; None if all contacts up to ``is_enough(d0, F0)``, in m and N, can be."""
        size = 2.0 * self.modulus
        limit = self.table.limit(lambda depth, moment: is_enough(depth, size * moment))
        return None if limit is None else Limit(limit.depth, size * limit.load, limit.error)

    def solved(self, a: Position) -> Solved:
        """The contact of one radius in m."""
        place = as_place(a)
        return _solved_at(self, float(np.ravel(place.base)[0]), float(np.ravel(place.offset)[0]))[0]

    def smooth(self, a: float) -> tuple[float, float, float, float]:
        """The solved contact of one radius in m: d0 in m, F0 in N, k in N/m, and their relative error."""
        solved, errors = _solved_at(self, 0.0, a)
        g, m = (float(f(as_place(np.array([a])))[0]) for f in (self.equivalent.g, self.equivalent.moment))
        size = 2.0 * self.modulus
        return (
            g - solved.lift,
            size * (m + solved.force * self.thickness),
            size * solved.stiffness * self.thickness,
            float(np.max(errors)),
        )

    def carried(self, a: Position, excess: float) -> Carried:
        """
        The half-spaces of the top layer that carry the same pressure in a contact of one radius.

        Their profile is g - c, with the part c = (K q) - (K q)(0) of the line load that the layers add.

        Parameters
        ----------
        a : float or Place
            Contact radius in m.
        excess : float
            d - d0(a) in m.
        """
        place = as_place(a)
        return _carried(self, float(np.ravel(place.base)[0]), float(np.ravel(place.offset)[0]), float(excess))

    def line_load(self, a: Position, excess: float) -> tuple[FloatArray, FloatArray]:
        """Positions in m and loads in N of a contact of one radius: loads per length times Gauss weights."""
        solved = self.solved(a)
        return solved.x * self.thickness, self.modulus * self.thickness * solved.loads(excess)


@lru_cache(maxsize=16)
def _solved_at(line: LayeredLine, base: float, offset: float) -> tuple[Solved, FloatArray]:
    """A contact and the relative errors of its numbers."""
    place = Place(np.array([base]), np.array([offset]))
    return solve_contact(line.kernel, Outline(line.equivalent, line.thickness, place))[:2]


@lru_cache(maxsize=16)
def _carried(line: LayeredLine, base: float, offset: float, excess: float) -> Carried:
    solved, _ = _solved_at(line, base, offset)
    added = Added(line.kernel, line.thickness, base + offset, solved.x, solved.loads(excess))
    coupled = Coupled(line.equivalent, added)
    return Carried(ElasticLine(coupled, line.modulus), excess * solved.punch_edge, coupled.sunk)


_STEP = math.sqrt(2.0)
"""Ratio of neighbouring trial radii."""
_NARROW = 0.1
"""The smallest trial radius in thicknesses, below which layers are half-spaces of the top one."""
_OWN = 16
"""Largest number of contact radii that are tried without interpolation."""
_INSIDE = np.unique(np.concatenate([np.linspace(0.0, 1.0, 65)[:-1], 1.0 - 0.5 ** np.arange(0.0, 16.0, 0.5)]))
"""Radii at which a trial pressure is evaluated, over its radius."""
_OUTSIDE = 0.5 ** np.arange(-2.0, 14.0, 0.5)
"""Distances outside at which its displacement is evaluated, over the radius and over the thickness."""
_ROUNDS, _FINER = 3, 17
"""Refinements of an extremum between the neighbours of the best radius, and points of each."""


@dataclass(frozen=True)
class _Trial:
    """A trial pressure: int t (d - f) dA = stiffness d - gap_force."""

    stiffness: float
    """In N/m."""
    gap_force: float
    """In N."""
    error: float
    """Relative."""


def lower_bound(
    line: LayeredLine, depth: FloatArray, contact_radius: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """
    Lower bounds of the normal force at indentations, for any contact.

    Parameters
    ----------
    depth : ndarray
        d in m.
    contact_radius : ndarray
        Radii in m of the disks that might be the contacts; NaN where none is known.

    Returns
    -------
    force : ndarray
        In N, not below 0.
    error : ndarray
        Relative, of its numerics.
    """
    known = np.unique(contact_radius[np.isfinite(contact_radius) & (contact_radius > 0.0)])
    bound, error = np.zeros(depth.shape), np.zeros(depth.shape)
    end, radii = min(line.table.end, WIDEST * line.thickness), known
    if not np.isfinite(contact_radius).all() and np.any(depth > 0.0):
        ends = np.min(depth[depth > 0.0]), np.max(depth)
        # a layer that keeps its volume bulges into contact, up to twice as wide
        radii = np.append(
            known, [0.5, 2.0] * np.array([line.equivalent.overlap_radius(float(d)) for d in ends])
        )
    if radii.size == 0:
        return bound, error
    top, least = min(float(np.max(radii)), end), min(float(np.min(radii)), _NARROW * line.thickness)
    count = 1 + math.ceil(math.log(max(4.0, top / least)) / math.log(_STEP))
    own = known[np.unique(np.linspace(0, known.size - 1, min(known.size, _OWN)).astype(int))]
    for b in {*(top * _STEP ** -np.arange(count)).tolist(), *own[own <= end].tolist()}:
        try:
            trial = _trial(line, b)
        except ConvergenceError:  # any other trial is as good a bound
            continue
        force = np.nan_to_num(trial.stiffness * depth - trial.gap_force)
        better = force > bound
        with np.errstate(divide="ignore", invalid="ignore"):
            parts = (np.abs(trial.stiffness * depth) + abs(trial.gap_force)) / force
        bound, error = np.where(better, force, bound), np.where(better, trial.error * parts, error)
    return bound, error


@lru_cache(maxsize=256)
def _trial(line: LayeredLine, b: float) -> _Trial:
    """The trial pressure on a disk of a radius in m."""
    place, h, profile = as_place(np.array([b])), line.thickness, line.equivalent
    solved = line.solved(b)
    depth, force, stiffness, error = line.smooth(b)
    flat = equivalent_profile(FlatPunch(b))
    punch = Coupled(flat, Added(line.kernel, h, b, solved.x, solved.weight * (1.0 + solved.coupled[1])))
    plain = Coupled(flat, Added(line.kernel, h, b, solved.x, solved.weight))

    def tension(r: FloatArray) -> FloatArray:
        return -(solved.punch_edge + np.sqrt((b - r) * (b + r)) * punch.pressure_integral(r, b))

    added = max(0.0, _largest(tension, b * _INSIDE))

    def displacement(r: FloatArray) -> FloatArray:
        """2/pi int_0^b q / sqrt(r^2 - x^2) dx, less what the layers add."""
        angle = np.arcsin(b / np.maximum(r, b))
        sunk = np.ones(r.shape)
        far = r > b
        sunk[far] = punch.sunk(r[far]) + 2.0 / math.pi * (
            punch.displacement_integral(r[far], b) + solved.punch_edge * angle[far]
        )
        return sunk + added * (plain.sunk(r) + 2.0 / math.pi * angle) if added > 0.0 else sunk

    outside = b + np.unique(np.concatenate([b * _OUTSIDE, h * _OUTSIDE]))
    deepest = max(1.0, _largest(displacement, np.concatenate([b * _INSIDE, [b], outside])))
    g, m = (float(f(place)[0]) for f in (profile.g, profile.moment))
    size = 2.0 * line.modulus * added
    return _Trial(
        (stiffness + size * b) / deepest, (stiffness * depth - force + size * (b * g - m)) / deepest, error
    )


def _largest(f: Callable[[FloatArray], FloatArray], r: FloatArray) -> float:
    """The largest value of a smooth function, searched between the neighbours of the best of some rising radii."""
    values = f(r)
    for _ in range(_ROUNDS):
        i = int(np.argmax(values))
        r = np.linspace(r[max(i - 1, 0)], r[min(i + 1, r.size - 1)], _FINER)
        values = f(r)
    return float(np.max(values))
