"""The disk of a layered body, and the half-spaces that carry the same load."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from pymdr.line.curves import Carried, ElasticLine, Profiled
from pymdr.line.layered.coupled import Added, Coupled
from pymdr.line.layered.equation import Outline, Solved, solve_contact
from pymdr.line.layered.tables import DEPTH, EDGE, ENERGY, FORCE, STIFFNESS, Limit, Table
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.mapping.layers import Kernel
from pymdr.numerics.panels import Place, Position, as_place, rounded
from pymdr.numerics.roots import rising_root
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
        place = as_place(a)
        flat = Place(np.ravel(place.base), np.ravel(place.offset))
        return self.table.read(flat, (column,), slopes)[:, 0].reshape(np.shape(place.offset))

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
        return 2.0 * self.modulus * rounded(a) * self._read(a, STIFFNESS)

    def stiffness_rate(self, a: Position) -> FloatArray:
        """The derivative k' in N/m^2."""
        return 2.0 * self.modulus * self._read(a, EDGE) ** 2

    def stiffness_power(self, a: Position) -> FloatArray:
        """The local power a k''/k' of k'."""
        return 2.0 * rounded(a) * self._read(a, EDGE, slopes=True) / self._read(a, EDGE)

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
        """
        No radii: an equivalent profile that decreases is refused.

        Raises
        ------
        ProblemError
            If g falls somewhere up to `top`.
        """
        self.table.refuse_falling(top)
        return ()

    def overlap_radius(self, depth: float) -> float:
        """The largest radius in m at which the bodies would overlap if they were shifted by a depth in m, or touch."""
        touching = float(self.place(depth).x)
        return max(self.equivalent.overlap_radius(depth), min(touching, self.edge, self.max_radius))

    def rough_radius(self, reached: Callable[[float, float], bool]) -> float:
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
