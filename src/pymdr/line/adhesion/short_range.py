"""Adhesion of short range: JKR for any profile, and its opposite, the rigid limit of DMT.

Both are curves of equilibrium states with one parameter s [m]. Up to a sharp edge s is the contact radius (but for
the stretches behind corners, see `pymdr.line.adhesion.radii`); from there on the contact radius sticks and s - edge
counts the indentation above its value at the edge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pymdr.line.adhesion.equivalent_line import (
    EquivalentLine,
    States,
    as_floats,
    inner_knots,
    own_edge,
    stretched_energy,
)
from pymdr.line.adhesion.radii import Radii, radii_of
from pymdr.mapping.series import Position, rounded
from pymdr.units import FloatArray


def jkr_opening(radius: ArrayLike, modulus: ArrayLike, work: ArrayLike) -> FloatArray:
    """Return the critical elongation of the outermost springs, Δl = sqrt(2π a γ / E*).

    Parameters
    ----------
    radius : array_like
        Contact radius a [m].
    modulus : array_like
        Effective modulus E* [Pa].
    work : array_like
        Work of adhesion γ [J/m²].

    Returns
    -------
    ndarray
        Δl [m], of the broadcast shape.

    Notes
    -----
    Heß (2011), the rule that makes the line reproduce Johnson, Kendall & Roberts (1971).

    Examples
    --------
    >>> float(jkr_opening(2.0, modulus=np.pi, work=1.0))
    2.0
    """
    return np.sqrt(2.0 * np.pi * as_floats(radius) * as_floats(work) / as_floats(modulus))


def energy_release_rate(radius: ArrayLike, opening: ArrayLike, modulus: ArrayLike) -> FloatArray:
    """Return G = E* (g(a) - d)² / (2π a) of the edge of the contact, 0 where the edge is pressed.

    Parameters
    ----------
    radius : array_like
        Contact radius a > 0 [m].
    opening : array_like
        Elongation of the outermost springs, g(a) - d [m]; below 0 they are pressed, and no energy is released.
    modulus : array_like
        Effective modulus E* [Pa].

    Returns
    -------
    ndarray
        G [J/m²]; the contact grows when G < γ and shrinks when G > γ.

    Notes
    -----
    From U = E* int_0^a (d - g)² dx at constant d (Popov & Heß 2015, ch. 4).

    Examples
    --------
    >>> float(energy_release_rate(2.0, jkr_opening(2.0, 3.0, work=0.5), modulus=3.0))
    0.5
    """
    open_by: FloatArray = np.maximum(as_floats(opening), 0.0)
    return as_floats(modulus) * open_by**2 / (2.0 * np.pi * as_floats(radius))


def stress_intensity(radius: ArrayLike, opening: ArrayLike, modulus: ArrayLike) -> FloatArray:
    """Return K_I = E* (g(a) - d) / sqrt(π a) of the edge of the contact.

    Parameters
    ----------
    radius, opening, modulus : array_like
        As in `energy_release_rate`.

    Returns
    -------
    ndarray
        K_I [Pa m^½] with G = K_I² / (2 E*) where the edge is open; negative for the compressed edge of a sharp punch.

    Notes
    -----
    Maugis (1992); Popov & Heß (2015), ch. 4.

    Examples
    --------
    >>> float(stress_intensity(np.pi, 1.0, modulus=2.0) * np.pi)
    2.0
    """
    return as_floats(modulus) * as_floats(opening) / np.sqrt(np.pi * as_floats(radius))


@dataclass(frozen=True)
class JKR:
    """The curve of JKR states of any profile.

    d = g(a) - Δl, F = 2E* [int_0^a x g' dx - a Δl], Δl = sqrt(2π a γ / E*).

    Parameters
    ----------
    line : EquivalentLine
        The equivalent profile.
    modulus : float
        Effective modulus E* [Pa].
    work : float
        Work of adhesion γ >= 0 [J/m²]; 0 gives the contact without adhesion.

    Attributes
    ----------
    start, limit : float
        Range of the parameter s [m]: 0 and the end of what is known (``inf`` beyond a sharp edge).
    knots : tuple of float
        Values of s where the curve is not smooth [m].
    touch : float
        Indentation of the first touch [m], always 0.

    Notes
    -----
    Johnson, Kendall & Roberts (1971); Heß (2011); Popov & Heß (2015), ch. 4. Exact for a Griffith edge and
    a contact that is a disk.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> ball = SimpleNamespace(g=lambda x: x**2, slope=lambda x: 2 * x, moment=lambda x: 2 * x**3 / 3,
    ...                        squared=lambda x: 8 * x**5 / 15, edge=np.inf, reach=np.inf, breakpoints=())
    >>> snap = JKR(ball, modulus=1.0, work=1.0).states((np.pi / 8) ** (1 / 3))
    >>> round(float(snap.normal_force / np.pi), 12)
    -0.833333333333
    """

    line: EquivalentLine
    modulus: float
    work: float

    @property
    def start(self) -> float:
        """The parameter of the first touch [m]."""
        return 0.0

    @property
    def limit(self) -> float:
        """The largest parameter [m]."""
        return np.inf if np.isfinite(own_edge(self.line)) else float(self.line.reach)

    @property
    def knots(self) -> tuple[float, ...]:
        """Parameters where the curve is not smooth [m]."""
        edge = own_edge(self.line)
        own = (edge,) if np.isfinite(edge) else ()
        return tuple(sorted({*inner_knots(self.line), *self._radii.knots, *own}))

    @property
    def touch(self) -> float:
        """Indentation of the first touch [m]."""
        return 0.0

    @property
    def _radii(self) -> Radii:
        return radii_of(self.line)

    def _position_and_opening(self, s: FloatArray) -> tuple[Position, FloatArray]:
        edge = own_edge(self.line)
        position = self._radii.position(np.minimum(s, edge))
        return position, jkr_opening(rounded(position), self.modulus, self.work) - np.maximum(s - edge, 0.0)

    def opening(self, s: ArrayLike) -> FloatArray:
        """Return the elongation g(a) - d of the outermost springs [m], below 0 where they are pressed."""
        return self._position_and_opening(as_floats(s))[1]

    def states(self, s: ArrayLike) -> States:
        """Return the states at the parameters `s` [m]."""
        position, opening = self._position_and_opening(as_floats(s))
        a = rounded(position)
        force = 2.0 * self.modulus * (self.line.moment(position) - a * opening)
        return States(a, a, self.line.g(position) - opening, force)

    def slopes(self, s: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return dd/ds = g' - Δl/2a (dimensionless) and dF/ds = 2E*(a g' - 3Δl/2) [N/m], times da/ds.

        Both are -inf or finite at s = 0, and (1, 2E*a) on the vertical piece above a sharp edge.
        """
        s = as_floats(s)
        edge, radii = own_edge(self.line), self._radii
        at = radii.beside(np.minimum(s, edge))
        position = radii.position(at)
        a = rounded(position)
        opening = jkr_opening(a, self.modulus, self.work)
        slope = self.line.slope(position)
        with np.errstate(divide="ignore", invalid="ignore"):
            half = np.where(opening > 0.0, opening / (2.0 * a), np.inf if self.work > 0.0 else 0.0)
            # at a tip the opening, of order sqrt(a), outdoes a slope that is infinite too
            rate = np.where(np.isinf(half), -half, slope - half)
            moment_rate = np.where(a > 0.0, a * slope, 0.0)
        stuck, per = s >= edge, radii.rate(at)
        return (
            np.where(stuck, 1.0, rate * per),
            2.0 * self.modulus * np.where(stuck, a, (moment_rate - 1.5 * opening) * per),
        )

    def energies(self, s: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the elastic energy E* int_0^a (d - g)² dx and the surface energy -π a² γ [J]."""
        position, opening = self._position_and_opening(as_floats(s))
        elastic = stretched_energy(self.line, self.modulus, position, opening)
        return elastic, -np.pi * rounded(position) ** 2 * self.work


@dataclass(frozen=True)
class DMT:
    """The curve without deformation by adhesion: d = g(a), F = 2E* int_0^a x g' dx - pull.

    Parameters
    ----------
    line : EquivalentLine
        The equivalent profile.
    modulus : float
        Effective modulus E* [Pa].
    pull : float
        The constant adhesive pull [N]: `dmt_pull` for a paraboloid, `rigid_pull` for other profiles.

    Attributes
    ----------
    start, limit, knots, touch
        As in `JKR`.

    Notes
    -----
    Derjaguin, Muller & Toporov (1975), in the form of Maugis (1992): the limit of Maugis-Dugdale for
    λ -> 0. Only the paraboloid has a pull without the range of the forces, 2π γ R.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> ball = SimpleNamespace(g=lambda x: x**2, slope=lambda x: 2 * x, moment=lambda x: 2 * x**3 / 3,
    ...                        squared=lambda x: 8 * x**5 / 15, edge=np.inf, reach=np.inf, breakpoints=())
    >>> DMT(ball, modulus=3.0, pull=1.0).states([0.0, 1.0]).normal_force
    array([-1.,  3.])
    """

    line: EquivalentLine
    modulus: float
    pull: float

    @property
    def _bare(self) -> JKR:
        return JKR(self.line, self.modulus, 0.0)

    @property
    def start(self) -> float:
        """The parameter of the first touch [m]."""
        return 0.0

    @property
    def limit(self) -> float:
        """The largest parameter [m]."""
        return self._bare.limit

    @property
    def knots(self) -> tuple[float, ...]:
        """Parameters where the curve is not smooth [m]."""
        return self._bare.knots

    @property
    def touch(self) -> float:
        """Indentation of the first touch [m]."""
        return 0.0

    def states(self, s: ArrayLike) -> States:
        """Return the states at the parameters `s` [m]."""
        bare = self._bare.states(s)
        force = bare.normal_force - self.pull
        return States(bare.contact_radius, bare.cohesive_radius, bare.indentation, force)

    def slopes(self, s: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return dd/ds (dimensionless) and dF/ds [N/m]."""
        return self._bare.slopes(s)

    def energies(self, s: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the elastic energy and the energy of the pull, -pull d [J]."""
        return self._bare.energies(s)[0], -self.pull * self._bare.states(s).indentation
