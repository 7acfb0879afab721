"""Adhesion of short range: JKR for any profile, and its opposite, the rigid limit of DMT.

Both are curves of equilibrium states with one parameter s [m]. Up to a sharp edge s is the contact radius (but for
the stretches behind corners, see `pymdr.line.adhesion.radii`); from there on the contact radius sticks and s - edge
counts the indentation above its value at the edge.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pymdr.line.adhesion.equivalent_line import States, inner_knots, own_edge
from pymdr.line.adhesion.radii import Radii, radii_of
from pymdr.line.curves import Contacts, Disk
from pymdr.line.curves import ElasticLine as ElasticLine
from pymdr.numerics.panels import Position
from pymdr.units import FloatArray


def jkr_opening(line: Disk, radius: Position, work: float) -> FloatArray:
    """Return the critical elongation of the edge, Δl = sqrt(4π a γ / k'(a)).

    Parameters
    ----------
    line : Disk
        The body, k'(a) the derivative of its stiffness.
    radius : array_like
        Contact radius a [m].
    work : float
        Work of adhesion γ [J/m²].

    Returns
    -------
    ndarray
        Δl [m], of the shape of `radius`.

    Notes
    -----
    Hess (2011) for half-spaces, sqrt(2π a γ / E*), the rule that makes the line reproduce Johnson, Kendall & Roberts
    (1971). For any linear body the energy released by an edge is that of its punch, k' Δl² / (4π a).

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> float(jkr_opening(ElasticLine(equivalent_profile(Paraboloid(1.0)), np.pi), 2.0, work=1.0))
    2.0
    """
    return _opening(np.asarray(radius, dtype=float), line.stiffness_rate(radius), work)


def _opening(a: FloatArray, stiffness_rate: FloatArray, work: float) -> FloatArray:
    with np.errstate(divide="ignore", invalid="ignore"):
        opening = np.sqrt(4.0 * np.pi * work * a / stiffness_rate)
    return np.where(a > 0.0, opening, 0.0)


def energy_release_rate(line: Disk, radius: Position, opening: ArrayLike) -> FloatArray:
    """Return G = k'(a) Δl² / (4π a) of the edge of the contact, 0 where the edge is pressed.

    Parameters
    ----------
    line : Disk
        The body, k'(a) the derivative of its stiffness.
    radius : array_like
        Contact radius a > 0 [m].
    opening : array_like
        Elongation of the edge, d0(a) - d [m]; below 0 it is pressed, and no energy is released.

    Returns
    -------
    ndarray
        G [J/m²]; the contact grows when G < γ and shrinks when G > γ.

    Notes
    -----
    From U = U0 + F0 w + k w²/2 at constant d, where dF0 = k dd0; for half-spaces E* Δl² / (2π a) (Popov & Hess 2015, ch. 4).

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = ElasticLine(equivalent_profile(Paraboloid(1.0)), 3.0)
    >>> round(float(energy_release_rate(ball, 2.0, jkr_opening(ball, 2.0, work=0.5))), 14)
    0.5
    """
    open_by: FloatArray = np.maximum(np.asarray(opening, dtype=float), 0.0)
    return line.stiffness_rate(radius) * open_by**2 / (4.0 * np.pi * np.asarray(radius, dtype=float))


def stress_intensity(radius: ArrayLike, opening: ArrayLike, modulus: ArrayLike) -> FloatArray:
    """Return K_I = E* (g(a) - d) / sqrt(π a) of the edge of the contact.

    Parameters
    ----------
    radius, opening : array_like
        As in `energy_release_rate`.
    modulus : array_like
        E* of homogeneous half-spaces [Pa].

    Returns
    -------
    ndarray
        K_I [Pa m^½] with G = K_I² / (2 E*) where the edge is open; negative for the compressed edge of a sharp punch.

    Notes
    -----
    Maugis (1992); Popov & Hess (2015), ch. 4.

    Examples
    --------
    >>> float(stress_intensity(np.pi, 1.0, modulus=2.0) * np.pi)
    2.0
    """
    size, elongation, stiffness = (np.asarray(x, dtype=float) for x in (radius, opening, modulus))
    intensity: FloatArray = stiffness * elongation / np.sqrt(np.pi * size)
    return intensity


@dataclass(frozen=True)
class JKR:
    """The curve of JKR states of any profile on any linear body.

    d = d0 - Δl, F = F0 - k Δl, U = U0 - F0 Δl + k Δl²/2, Δl = sqrt(4π a γ / k'(a)); for half-spaces
    d = g(a) - Δl, F = 2E* [int_0^a x g' dx - a Δl], Δl = sqrt(2π a γ / E*).

    Parameters
    ----------
    line : Disk
        The contact without adhesion.
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
    Johnson, Kendall & Roberts (1971); Hess (2011); Popov & Hess (2015), ch. 4. Exact for a Griffith edge and
    a contact that is a disk.

    Examples
    --------
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = ElasticLine(equivalent_profile(Paraboloid(1.0)), 1.0)
    >>> snap = JKR(ball, work=1.0).states((np.pi / 8) ** (1 / 3))
    >>> round(float(snap.normal_force / np.pi), 12)
    -0.833333333333
    """

    line: Disk
    work: float
    ranged: ClassVar[bool] = False
    """Whether the attraction reaches beyond the contact."""
    touch: ClassVar[float] = 0.0
    """Indentation of the first touch [m]."""
    contact: ClassVar[float] = 0.0
    """The parameter where contact begins [m]."""

    @property
    def start(self) -> float:
        """The parameter of the first touch [m]."""
        return 0.0

    @property
    def limit(self) -> float:
        """The largest parameter [m]."""
        return np.inf if np.isfinite(self._edge) else float(self.line.max_radius)

    @property
    def knots(self) -> tuple[float, ...]:
        """Parameters where the curve is not smooth [m]."""
        edge = self._edge
        own = (edge,) if np.isfinite(edge) else ()
        return tuple(sorted({*inner_knots(self.line), *self._radii.knots, *own}))

    def parameter_below(self, radius: float, zone: float, depth: float) -> float:
        """Return a parameter near that of the state of a given contact radius and indentation, not above it [m]."""
        if radius < self._edge or radius == 0.0:
            return radius
        return radius + max(depth - float(self.states(radius).indentation), 0.0)

    @cached_property
    def _radii(self) -> Radii:
        return radii_of(self.line, self.line.depth_rate)

    @cached_property
    def _edge(self) -> float:
        return own_edge(self.line)

    def _stretch(self, a: FloatArray, stiffness_rate: FloatArray) -> FloatArray:
        """Return the elongation of an edge that recedes [m]."""
        return _opening(a, stiffness_rate, self.work)

    def _contacts(self, s: FloatArray) -> tuple[Position, FloatArray, Contacts, FloatArray]:
        """Return radii as positions and as floats, their contacts and the elongations of their edges."""
        edge, radii = self._edge, self._radii
        below = np.minimum(s, edge)
        position = radii.position(below) if radii.corners.size else below
        a, contacts = np.asarray(position, dtype=float), self.line.contacts(position)
        return position, a, contacts, self._stretch(a, contacts.stiffness_rate) - np.maximum(s - edge, 0.0)

    def _positions_and_rates(self, s: FloatArray) -> tuple[Position, FloatArray]:
        """Return positions at which rates are finite, and da/ds there, below the sharp edge."""
        at, radii = np.minimum(s, self._edge), self._radii
        if radii.corners.size == 0:
            return at, np.ones(at.shape)
        at = radii.off_corners(at)
        return radii.position(at), radii.rate(at)

    def opening(self, s: ArrayLike) -> FloatArray:
        """Return the elongation d0(a) - d of the edge [m], below 0 where it is pressed."""
        return self._contacts(np.asarray(s, dtype=float))[3]

    def states(self, s: ArrayLike) -> States:
        """Return the states at the parameters `s` [m]."""
        _, a, contacts, opening = self._contacts(np.asarray(s, dtype=float))
        return States(a, a, contacts.depth - opening, contacts.force - contacts.stiffness * opening)

    def slopes(self, s: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return dd/ds = d0' - Δl' (dimensionless) and dF/ds = k d0' - (k Δl)' [N/m], times da/ds.

        With Δl' = (1 - a k''/k') Δl / 2a. Both are -inf or finite at s = 0, and (1, k) on the vertical segment above a
        sharp edge.
        """
        s = np.asarray(s, dtype=float)
        position, per = self._positions_and_rates(s)
        a, slope = np.asarray(position, dtype=float), self.line.depth_rate(position)
        stiffness, spread, power = self.line.punch(position)
        opening, half_rest = self._stretch(a, spread), 0.5 * (1.0 - power)
        with np.errstate(divide="ignore", invalid="ignore"):
            widening = np.where(
                opening > 0.0, half_rest * opening / a, np.where(np.greater(self.work, 0.0), np.inf, 0.0)
            )
            # at a tip the opening, of order sqrt(a), outdoes a slope that is infinite too
            rate = np.where(np.isinf(widening), -widening, slope - widening)
            pulled = (a * spread + half_rest * stiffness) * opening / a
            force_rate = np.where(a > 0.0, stiffness * slope - pulled, 0.0)
        stuck = s >= self._edge
        return np.where(stuck, 1.0, rate * per), np.where(stuck, stiffness, force_rate * per)

    def radius_rate(self, s: ArrayLike) -> FloatArray:
        """Return da/ds, 0 on the vertical segment above a sharp edge; next to a corner as `slopes`."""
        s = np.asarray(s, dtype=float)
        return np.where(s >= self._edge, 0.0, self._positions_and_rates(s)[1])

    def energies(self, s: ArrayLike, indentation: ArrayLike | None = None) -> tuple[FloatArray, FloatArray]:
        """
        Return the elastic energy U0 - F0 Δl + k Δl²/2 and the surface energy -π a² γ [J].

        Parameters
        ----------
        s : array_like
            Parameters [m].
        indentation : array_like, optional
            Indentations of these states [m]. Beyond a sharp edge s resolves them to the rounding of its radius only.
        """
        s = np.asarray(s, dtype=float)
        position, a, contacts, opening = self._contacts(s)
        if indentation is not None:
            opening = np.where(s >= self._edge, contacts.depth - np.asarray(indentation), opening)
        elastic = (
            self.line.energy(position) - opening * contacts.force + 0.5 * opening**2 * contacts.stiffness
        )
        return elastic, -np.pi * a**2 * self.work


@dataclass(frozen=True)
class DMT:
    """The curve without deformation by adhesion: d = d0(a), F = F0(a) - pull.

    Parameters
    ----------
    line : Disk
        The contact without adhesion.
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
    >>> from pymdr.mapping.equivalent import equivalent_profile
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = ElasticLine(equivalent_profile(Paraboloid(1.0)), 3.0)
    >>> DMT(ball, pull=1.0).states([0.0, 1.0]).normal_force
    array([-1.,  3.])
    """

    line: Disk
    pull: float
    ranged: ClassVar[bool] = True
    """Whether the attraction reaches beyond the contact."""
    start: ClassVar[float] = 0.0
    """The parameter of the first touch [m]."""
    touch: ClassVar[float] = 0.0
    """Indentation of the first touch [m]."""
    contact: ClassVar[float] = 0.0
    """The parameter where contact begins [m]."""

    @cached_property
    def _bare(self) -> JKR:
        return JKR(self.line, 0.0)

    @property
    def limit(self) -> float:
        """The largest parameter [m]."""
        return self._bare.limit

    @property
    def knots(self) -> tuple[float, ...]:
        """Parameters where the curve is not smooth [m]."""
        return self._bare.knots

    def parameter_below(self, radius: float, zone: float, depth: float) -> float:
        """Return a parameter near that of a state, as `JKR` does [m]."""
        return self._bare.parameter_below(radius, zone, depth)

    def states(self, s: ArrayLike) -> States:
        """Return the states at the parameters `s` [m]."""
        bare = self._bare.states(s)
        force = bare.normal_force - self.pull
        return States(bare.contact_radius, bare.cohesive_radius, bare.indentation, force)

    def slopes(self, s: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return dd/ds (dimensionless) and dF/ds [N/m]."""
        return self._bare.slopes(s)

    def energies(self, s: ArrayLike, indentation: ArrayLike | None = None) -> tuple[FloatArray, FloatArray]:
        """Return the elastic energy and the energy of the pull, -pull d [J], as `JKR` does."""
        depth = self._bare.states(s).indentation if indentation is None else np.asarray(indentation)
        return self._bare.energies(s, indentation)[0], -self.pull * depth
