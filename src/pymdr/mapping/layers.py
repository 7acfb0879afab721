"""Surface of a stack of layers: its compliance L(s), and the kernel M(t) with which it acts on the line.

A pressure wave of wavenumber q displaces the surface by 2 L(qh) / (E* q), E* and h those of the top layer. On the line

    q(x) - (1/pi) int_0^a [M(x - y) + M(x + y)] q(y) dy = E* (d - g(x)),   M(t) = int_0^inf (1 - L(s)) cos(st) ds

with lengths in units of h (Lebedev and Ufliand 1958).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

from pymdr.errors import ConvergenceError, ProblemError
from pymdr.mapping.moduli import surface_compliances
from pymdr.problem.layers import Layered
from pymdr.problem.materials import Elastic, Material, Rigid
from pymdr.units import FloatArray

ComplexArray = NDArray[np.complex128]

_PAIRS = tuple(itertools.combinations(range(4), 2))
_UV, _UP, _UT, _VP, _VT, _PT = range(6)
"""Minors of two states of (u_z, u_x, pressure, shear)."""


def generator(shear: float, poisson: float) -> FloatArray:
    """
    Generator of the growth of a state from the bottom of a layer to its top, per wavenumber times depth.

    States are u_z, u_x, and the tractions -s_zz and s_xz in units of 2 G q, G that of the top layer.
    """
    c = poisson / (1.0 - poisson)
    state = np.zeros((4, 4))
    state[0, 1], state[0, 2] = c, (1.0 - 2.0 * poisson) / ((1.0 - poisson) * shear)
    state[1, 0], state[1, 3] = -1.0, -2.0 / shear
    state[2, 3] = -1.0
    state[3, 1], state[3, 2] = -shear / (1.0 - poisson), c
    return state


def _minors_of(state: FloatArray) -> FloatArray:
    """Generator of the growth of the six minors of a pair of states."""
    minors = np.zeros((6, 6))
    for row, (i, j) in enumerate(_PAIRS):
        for column, (k, m) in enumerate(_PAIRS):
            minors[row, column] = (
                state[i, k] * (j == m)
                + state[j, m] * (i == k)
                - state[i, m] * (j == k)
                - state[j, k] * (i == m)
            )
    return minors


def _tail(z: ComplexArray, first: int) -> ComplexArray:
    """
    Remainder of the series of sinh 2z (`first` odd) or cosh 2z from the power `first` on, times e^(-2z).

    Its own series where the difference would cancel.
    """
    small = np.abs(z) < 1.0
    near = np.where(small, z, 0.0)
    term = (2.0 * near) ** first / math.factorial(first)
    series: ComplexArray = np.zeros_like(term)
    for k in range(first, first + 26, 2):
        series = series + term
        term = term * (4.0 * near * near) / ((k + 1) * (k + 2))
    decay: ComplexArray = np.exp(-2.0 * z)
    sign = -1.0 if first % 2 else 1.0
    closed: ComplexArray = 0.5 * (1.0 + sign * decay * decay)
    for k in range(first % 2, first, 2):
        closed = closed - decay * (2.0 * z) ** k / math.factorial(k)
    return np.where(small, series * decay, closed)


@dataclass(frozen=True)
class _Ply:
    """One layer of the thickness t: its minors grow upward as exp(B s t), where B^3 (B^2 - 4) = 0."""

    thickness: float
    """In units of that of the top layer."""
    powers: FloatArray
    """1, B, B^2, B^3, B^4, shape (5, 6, 6)."""

    def raised(self, s: ComplexArray, bottom: ComplexArray) -> ComplexArray:
        """Minors at its top from those at its bottom, both of shape (6, n), times e^(-2 s t)."""
        z = s * self.thickness
        decay = np.exp(-2.0 * z)
        parts = (decay, z * decay, 0.5 * z * z * decay, _tail(z, 3) / 8.0, _tail(z, 4) / 16.0)
        return self._combined(np.stack(parts), bottom)

    def returning(self, s: ComplexArray, bottom: ComplexArray) -> ComplexArray:
        """The part of them that does not grow as e^(2 s t)."""
        z = s * self.thickness
        decay = np.exp(-2.0 * z)
        back = decay * decay
        parts = (decay, z * decay, 0.5 * z * z * decay, -decay * z / 4.0 - back / 16.0)
        last = back / 32.0 - decay * (1.0 + 2.0 * z * z) / 16.0
        return self._combined(np.stack((*parts, last)), bottom)

    def _combined(self, parts: ComplexArray, bottom: ComplexArray) -> ComplexArray:
        return np.asarray(np.einsum("kn,kij,jn->in", parts, self.powers, bottom))


def _ply(thickness: float, shear: float, poisson: float) -> _Ply:
    b = _minors_of(generator(shear, poisson))
    return _Ply(thickness, np.stack([np.linalg.matrix_power(b, k) for k in range(5)]))


def _minors_of_base(body: Layered, shear: float) -> FloatArray:
    """The minors of the states that the base allows; `shear` is the unit of moduli in Pa."""
    minors = np.zeros(6)
    base, free = body.base, body.bond == "frictionless"
    if not isinstance(base, Elastic):
        minors[_VP if free else _PT] = 1.0
    elif free:
        minors[_VP], minors[_UV] = 1.0, -2.0 * (1.0 - base.poisson) * shear / base.shear
    else:
        # what decays downward is what grows upward: the eigenvector of 2
        b = _minors_of(generator(base.shear / shear, base.poisson))
        minors = np.linalg.matrix_power(b, 3)[:, _PT] / 8.0 + np.linalg.matrix_power(b, 4)[:, _PT] / 16.0
        minors /= np.max(np.abs(minors))
    return minors


@dataclass(frozen=True)
class Compliance:
    """
    The surface compliance L(s) of a layered body, as a part of that of a half-space of its top layer.

    Notes
    -----
    Plane waves, whose states at a depth are pairs of displacements and tractions; the minors of the two that a base allows
    are carried upward, layer by layer (Dunkin 1965), which loses no digits to growing exponentials.

    Examples
    --------
    >>> from pymdr.problem.layers import Layer
    >>> film = Compliance(Layered([Layer(Elastic(1.0, 0.5), 1.0)]))
    >>> float(film.ratio(0.01).real.round(12))
    6.66547e-07
    """

    body: Layered

    @property
    def modulus(self) -> float:
        """E* of the top layer in Pa."""
        top = self.body.top
        return 2.0 * top.shear / (1.0 - top.poisson)

    @property
    def thickness(self) -> float:
        """Thickness of the top layer in m, the unit of lengths."""
        return self.body.layers[0].thickness

    @cached_property
    def _plies(self) -> tuple[_Ply, ...]:
        shear = self.body.top.shear
        return tuple(
            _ply(layer.thickness / self.thickness, solid.shear / shear, solid.poisson)
            for layer, solid in zip(self.body.layers, self.body.solids, strict=True)
        )

    def _below(self, s: ComplexArray) -> ComplexArray:
        """The minors under the top layer, shape (6, n)."""
        base = _minors_of_base(self.body, self.body.top.shear)
        minors = np.broadcast_to(base.astype(complex)[:, None], (6, s.size))
        for ply in reversed(self._plies[1:]):
            minors = ply.raised(s, minors)
            minors = minors / np.max(np.abs(minors), axis=0)
        return minors

    def pressed_through(self, s: FloatArray) -> FloatArray:
        """The normal stress on a frictionless base, as a part of the pressure wave on the surface."""
        if self.body.bond != "frictionless":
            raise ProblemError("the layers are bonded to their base; give bond='frictionless'")
        base = _minors_of_base(self.body, self.body.top.shear)
        sliding, pressed = np.zeros((4, s.size)), np.zeros((4, s.size))
        sliding[1], pressed[0], pressed[2] = 1.0, -base[_UV], 1.0
        decay = np.zeros(s.size)
        for solid, ply in zip(reversed(self.body.solids), reversed(self._plies), strict=True):
            state = generator(solid.shear / self.body.top.shear, solid.poisson)
            z = s * ply.thickness
            back = np.exp(-2.0 * z)
            cosh, sinh = 0.5 * (1.0 + back), 0.5 * (1.0 - back)
            third = 0.5 * (z * cosh - sinh)
            parts = np.stack([cosh - 0.5 * z * sinh, sinh - third, 0.5 * z * sinh, third])
            powers = np.stack([np.linalg.matrix_power(state, k) for k in range(4)])
            sliding, pressed = (
                np.asarray(np.einsum("kn,kij,jn->in", parts, powers, y)) for y in (sliding, pressed)
            )
            decay += z
        # of both together, without shear at the surface
        return np.asarray(np.exp(-decay) * sliding[3] / (sliding[3] * pressed[2] - pressed[3] * sliding[2]))

    def ratio(self, s: ArrayLike) -> ComplexArray:
        """L(s), relative to its size; s with a real part above 0."""
        z = np.asarray(s, dtype=complex)
        minors = self._plies[0].raised(z.ravel(), self._below(z.ravel()))
        return np.asarray(minors[_UT] / (2.0 * (1.0 - self.body.top.poisson) * minors[_PT])).reshape(z.shape)

    def shortfall(self, s: ArrayLike) -> ComplexArray:
        """1 - L(s), relative to its size where that is below 1."""
        z = np.asarray(s, dtype=complex).ravel()
        top, below = self._plies[0], self._below(z)
        whole, rest = top.raised(z, below), top.returning(z, below)
        # the parts that grow are those of a half-space, of which nothing is left
        far = rest[_PT] - rest[_UT] / (2.0 * (1.0 - self.body.top.poisson))
        near = whole[_PT] - whole[_UT] / (2.0 * (1.0 - self.body.top.poisson))
        difference = np.where(np.abs(z) < 1.0, near, far)
        return np.asarray(difference / whole[_PT]).reshape(np.shape(s))


@dataclass(frozen=True)
class PairCompliance:
    """
    The surface compliance L(s) of two bodies, as a part of that of half-spaces of their top layers.

    Parameters
    ----------
    stacks : tuple of Compliance
        The layered bodies, one or two.
    softness : float, optional
        1/E* in 1/Pa of the other body, if it is a half-space; by default 0, rigid.

    Notes
    -----
    Under a frictionless pressure wave the normal displacements of two surfaces add:
    L = E* (L1/E1* + L2/E2*), 1/E* = 1/E1* + 1/E2*. Wavenumbers s are per thickness of the thinner top layer.

    Examples
    --------
    >>> from pymdr.problem.layers import Layer
    >>> film = Compliance(Layered([Layer(Elastic(1.0, 0.5), 1.0)]))
    >>> both = PairCompliance((film, film))
    >>> both.modulus / film.modulus, bool(both.ratio(1.0) == film.ratio(1.0))
    (0.5, True)
    """

    stacks: tuple[Compliance, ...]
    softness: float = 0.0

    @cached_property
    def modulus(self) -> float:
        """E* of the top layers in Pa."""
        if len(self.stacks) == 1 and self.softness == 0.0:
            return self.stacks[0].modulus
        return 1.0 / (self.softness + sum(1.0 / stack.modulus for stack in self.stacks))

    @property
    def thickness(self) -> float:
        """Thickness of the thinner top layer in m, the unit of lengths."""
        return min(stack.thickness for stack in self.stacks)

    def ratio(self, s: ArrayLike) -> ComplexArray:
        """L(s), relative to its size; s with a real part above 0."""
        return self.modulus * self.softness + self._added(Compliance.ratio, s)

    def shortfall(self, s: ArrayLike) -> ComplexArray:
        """1 - L(s), relative to its size where that is below 1."""
        return self._added(Compliance.shortfall, s)

    def _added(self, of: Callable[[Compliance, ArrayLike], ComplexArray], s: ArrayLike) -> ComplexArray:
        z = np.asarray(s, dtype=complex)
        total: ComplexArray = np.zeros_like(z)
        for stack in self.stacks:
            total = total + self.modulus / stack.modulus * of(stack, z * (stack.thickness / self.thickness))
        return total


_TERMS = 12
"""Powers on every panel of the kernel."""
_POWERS = np.stack(
    [
        np.pad(chebyshev.cheb2poly(unit[: n + 1]), (0, _TERMS - 1 - n))
        for n, unit in enumerate(np.eye(_TERMS))
    ],
    axis=1,
)
"""Chebyshev polynomials in powers, column by column."""
_STEP = 0.125
"""Width of its panels in log(1 + t)."""
_ANGLE = math.pi / 8.0
"""Panel width on the ray along which waves decay and the kernel is integrated."""
_LEAST, _MOST = 1e-9, 1e3
"""Ends of the ray, in wavelengths per thickness."""
_ROUNDING = 1e-12
"""Largest error of the kernel by rounding of 1 - L."""
_BLOCK = 1 << 13
"""Points evaluated at once, so that they stay in the cache."""


@dataclass(eq=False)
class Kernel:
    """
    The kernel M(t) of two bodies, one or both of them layered, tabulated as far out as requested.

    Notes
    -----
    The integral over s is taken along a ray, on which waves die out: near t = 0 as 1 - L does, farther out because of
    the distance, so that the values in the tail, which fall as a power of t, keep their digits.
    """

    compliance: PairCompliance
    error: float = 0.0
    """Difference of the integrals by two methods, over the largest value."""

    def __post_init__(self) -> None:
        self._ray = _rule(_ANGLE)
        s, weights = self._ray
        self._short = self.compliance.shortfall(s) * weights
        self._whole = self.compliance.ratio(s) * weights
        self._coefficients = np.empty((_TERMS, 0))
        axis, straight = _rule(0.0)
        at = np.array([0.0, 1.0])
        along = (np.cos(np.outer(at, axis.real)) @ (self.compliance.shortfall(axis) * straight)).real
        self.size = max(float(np.max(np.abs(self._integrated(np.linspace(0.0, 2.0, 9))))), 1e-300)
        self.error = float(np.max(np.abs(along - self._integrated(at)))) / self.size
        # of layers that are almost alike, 1 - L has little more than its rounding
        if self.error > 1e-9 and self.error * self.size > _ROUNDING:
            raise ConvergenceError(
                f"the kernel of the layers did not converge: two integrations differ by {self.error:.1g} of its size (limit 1e-9); "
                "use layers whose moduli and thicknesses differ less"
            )

    @cached_property
    def at_zero(self) -> float:
        """M(0), the integral of 1 - L."""
        return float(self._integrated(np.zeros(1))[0])

    @cached_property
    def bending(self) -> float:
        """The integral of |1 - L| s^2, a bound of the change of M from M(0)."""
        s, _ = self._ray
        return float(np.sum(np.abs(self._short * s * s)))

    def softening(self, radius: float) -> float:
        """L at the widest wave that a contact of a radius in thicknesses feels."""
        return float(self.compliance.ratio(1.5 / radius).real)

    def _integrated(self, t: FloatArray) -> FloatArray:
        s, _ = self._ray
        waves = np.exp(1j * np.outer(t, s))
        # without a linear algebra library, whose threads wait for one another
        near, far = (np.einsum("ts,s->t", waves, part).real for part in (self._short, self._whole))
        return np.asarray(np.where(t < 2.0, near, -far))

    def _extend(self, top: float) -> None:
        """Tabulate up to t = top."""
        known, needed = self._coefficients.shape[1], math.floor(math.log1p(top) / _STEP) + 1
        if needed <= known:
            return
        ends = np.expm1(_STEP * np.arange(known, needed + 1))
        middle, half = 0.5 * (ends[1:] + ends[:-1]), 0.5 * np.diff(ends)
        u = np.cos(math.pi * (np.arange(_TERMS) + 0.5) / _TERMS)
        values = self._integrated((middle + half * u[:, None]).ravel()).reshape(_TERMS, -1)
        series = chebyshev.chebfit(u, values, _TERMS - 1)
        powers = _POWERS @ series
        self._coefficients = np.concatenate([self._coefficients, powers], axis=1)
        low = np.expm1(_STEP * np.arange(needed + 1))
        self._starts, self._scales = low[:-1], 2.0 / np.diff(low)

    def __call__(self, t: FloatArray) -> FloatArray:
        """M(t), t >= 0 in thicknesses of the top layer."""
        flat = t.ravel()
        self._extend(float(np.max(flat, initial=0.0)))
        values = [self._near(flat[i : i + _BLOCK]) for i in range(0, flat.size, _BLOCK)]
        return np.concatenate(values).reshape(t.shape) if values else np.zeros(t.shape)

    def _near(self, t: FloatArray) -> FloatArray:
        index, u = self._located(t)
        total = self._coefficients[-1].take(index)
        for row in self._coefficients[-2::-1]:
            total *= u
            total += row.take(index)
        return np.asarray(total)

    def pair(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Influence at x of a load at y, [M(x - y) + M(x + y)] / pi, for all pairs: shape (x, y)."""
        return (self(np.abs(x[:, None] - y)) + self(x[:, None] + y)) / math.pi

    def _located(self, t: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
        """The panel of every t, and where on it, from -1 to 1."""
        index = (np.log1p(t) * (1.0 / _STEP)).astype(np.intp)
        u = t - self._starts.take(index)
        u *= self._scales.take(index)
        u -= 1.0
        return index, u


@lru_cache(maxsize=4)
def _rule(angle: float) -> tuple[ComplexArray, ComplexArray]:
    """Nodes and weights of a ray of wavenumbers, graded toward 0."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    ends = np.concatenate([[0.0], np.geomspace(_LEAST, _MOST, round(math.log(_MOST / _LEAST) / 0.4) + 1)])
    half = 0.5 * np.diff(ends)
    s = (ends[:-1, None] + half[:, None] * (nodes + 1.0)).ravel()
    turn = np.exp(1j * angle)
    return s * turn, (half[:, None] * weights).ravel() * turn


@lru_cache(maxsize=16)
def kernel_of(body: Material, counterbody: Material | None = None) -> Kernel:
    """The kernel of two bodies, one or both of them layered, made once; the second is rigid unless given."""
    bodies = (body, Rigid() if counterbody is None else counterbody)
    stacks = tuple(Compliance(one) for one in bodies if isinstance(one, Layered))
    softness = sum(surface_compliances(one).normal for one in bodies if not isinstance(one, Layered))
    return Kernel(PairCompliance(stacks, softness))
