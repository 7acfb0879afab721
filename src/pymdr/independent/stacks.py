"""Surface of a stack of elastic layers for the rings, without Fredholm's equation or its kernel.

A pressure cos(q x) displaces the surface by 2 L/(E* q) with E* of the top layer. L is computed by adding layers from the base
up. The symmetric and antisymmetric part of each layer are solved in closed form, in displacements and tractions whose
coefficients are free of cancellation for thin, thick and incompressible layers. The displacement by rings is that of the
half-space minus a Hankel integral with 1 - L, which decays like e^(-2 q h).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pymdr.errors import ProblemError
from pymdr.independent.rings import Array, ring_displacement
from pymdr.mapping.moduli import surface_compliances
from pymdr.problem.layers import Layered
from pymdr.problem.materials import Elastic, Material

_END = 22.0
"""q h of the top layer above which 1 - L is below rounding."""
_NODES = 24
_WAVE = 30.0
"""Phase of the Bessel functions per panel, resolved to rounding by its nodes."""
_RATIO = 2.5
"""Ratio of the ends of a panel; the poles of L stay at least a panel length away."""
_MOST = 400_000
_BLOCK = 2048


@dataclass(frozen=True)
class Stack:
    """Isotropic layers on a base, from the surface down; the base is a half-space, or rigid if its modulus is infinite.

    Parameters
    ----------
    thickness : tuple of float
        Thickness of every layer in m.
    young, poisson : tuple of float
        Young's modulus in Pa and Poisson's ratio of every layer and of the base; that of a rigid base is ignored.
    bonded : tuple of bool
        Whether each layer is bonded to the one below, or slides on it without friction and lifting.

    Examples
    --------
    >>> rubber_on_steel = Stack((1e-3,), (1e6, math.inf), (0.5, 0.3), (True,))
    >>> [f"{x:.4f}" for x in rubber_on_steel.compliance([0.1e3, 1e3, 10e3])]
    ['0.0007', '0.2406', '1.0000']
    """

    thickness: tuple[float, ...]
    young: tuple[float, ...]
    poisson: tuple[float, ...]
    bonded: tuple[bool, ...]

    bulges = True

    def __post_init__(self) -> None:
        n = len(self.thickness)
        if n == 0 or (len(self.young), len(self.poisson), len(self.bonded)) != (n + 1, n + 1, n):
            raise ProblemError(
                f"{n} thicknesses, {len(self.young)} moduli, {len(self.poisson)} Poisson's ratios and {len(self.bonded)} "
                "interfaces; n layers need n, n + 1, n + 1 and n, n of at least 1."
            )
        if not all(0 < h < math.inf for h in self.thickness):
            raise ProblemError(f"thicknesses {self.thickness} m must be positive and finite.")
        if not all(0 < e < math.inf for e in self.young[:n]) or not self.young[n] > 0:
            raise ProblemError(f"moduli {self.young} Pa must be positive, those of layers finite.")
        if not all(-1 < v <= 0.5 for v in self.poisson):
            raise ProblemError(f"Poisson's ratios {self.poisson} must be above -1 and at most 0.5.")

    @property
    def modulus(self) -> float:
        """E* of the top layer in Pa."""
        return self.young[0] / (1 - self.poisson[0] ** 2)

    @property
    def softness(self) -> float:
        """Upper bound of L."""
        q = np.geomspace(1e-9, 1e3, 400) / sum(self.thickness)
        return float(1.05 * max(self.compliance(q).max(), 1.0))

    def compliance(self, q: ArrayLike) -> Array:
        """L at wavenumbers `q` (k,) in 1/m: the displacement by a cosine pressure over that of a half-space of the top layer.

        References
        ----------
        Muskhelishvili 1953, sections 93 and 94, for the layers; Kausel and Roesset 1981, Bull. Seismol. Soc. Am. 71, 1743, for their assembly.

        Examples
        --------
        >>> Stack((1.0,), (1.0, 1.0), (0.3, 0.3), (True,)).compliance([1e-6, 1.0, 1e3])
        array([1., 1., 1.])
        """
        q = np.atleast_1d(np.asarray(q, dtype=np.float64))
        shear = [e / (2 * (1 + v)) for e, v in zip(self.young, self.poisson, strict=True)]
        kappa = [3 - 4 * v for v in self.poisson]
        below = np.empty((q.size, 2, 2))
        below[:] = (
            np.array([[kappa[-1] + 1, kappa[-1] - 1], [kappa[-1] - 1, kappa[-1] + 1]])
            / 4
            * (shear[0] / shear[-1])
        )
        for h, mu, k, bonded in reversed(
            list(zip(self.thickness, shear[:-1], kappa[:-1], self.bonded, strict=True))
        ):
            below = _added(q * h / 2, k, shear[0] / mu, below, bonded)
        return np.asarray(below[:, 1, 1] * 4 / (kappa[0] + 1), dtype=np.float64)

    def displacement(self, r: ArrayLike, edges: ArrayLike) -> Array:
        """Displacement in m at `r` (k,) by unit pressure on each ring of `edges` (n + 1,), for E* = 1: (k, n).

        :func:`pymdr.independent.rings.ring_displacement` minus 2 int (1 - L) J0(q r) [a J1(q a)] dq / q.

        Examples
        --------
        >>> two = Stack((1.0, 1.0), (1.0, 1.0, math.inf), (0.3, 0.3, 0.3), (True, True))
        >>> one = Stack((2.0,), (1.0, math.inf), (0.3, 0.3), (True,))
        >>> [f"{stack.displacement([0.5], [0.0, 1.0])[0, 0]:.6f}" for stack in (one, two)]
        ['1.232288', '1.232288']
        """
        u = ring_displacement(r, edges)
        r, a = np.atleast_1d(np.asarray(r, dtype=np.float64)), np.asarray(edges, dtype=np.float64)
        if r.size == 0:
            return u
        span = float(r.max() + a[-1])
        q, weight = _quadrature(self, 2.0 ** math.ceil(math.log2(span)))
        for i in range(0, q.size, _BLOCK):
            block = slice(i, i + _BLOCK)
            disks = a * scipy.special.j1(q[block, None] * a)
            u -= (scipy.special.j0(r[:, None] * q[block]) * weight[block]) @ np.diff(disks, axis=1)
        return u


def stack_of(body: Layered) -> Stack:
    """The stack of a layered body.

    Examples
    --------
    >>> from pymdr.problem.layers import Layer
    >>> stack_of(Layered([Layer(Elastic(1.0, 0.5), "2 mm")])).thickness
    (0.002,)
    """
    solids = body.solids
    base = (body.base.young, body.base.poisson) if isinstance(body.base, Elastic) else (math.inf, 0.0)
    return Stack(
        tuple(layer.thickness for layer in body.layers),
        (*(solid.young for solid in solids), base[0]),
        (*(solid.poisson for solid in solids), base[1]),
        (*(True for _ in solids[1:]), body.bond == "bonded"),
    )


@dataclass(frozen=True)
class Pair:
    """Two surfaces whose displacements add, at least one of them layered.

    Parameters
    ----------
    stacks : tuple of Stack
    flat : float, optional
        1/E* in 1/Pa of the other body, if it is a half-space; 0 if it is rigid.

    Examples
    --------
    >>> one = Stack((1.0,), (1.0, math.inf), (0.5, 0.3), (True,))
    >>> Pair((one, one)).modulus == one.modulus / 2
    True
    """

    stacks: tuple[Stack, ...]
    flat: float = 0.0

    bulges = True

    @property
    def modulus(self) -> float:
        """E* of the top layers in Pa."""
        return 1 / (self.flat + sum(1 / stack.modulus for stack in self.stacks))

    @property
    def _rest(self) -> float:
        """Part of the compliance of half-spaces that belongs to the body without layers."""
        return self.modulus * self.flat

    @property
    def softness(self) -> float:
        """Upper bound of L."""
        return self._rest + sum(self.modulus / stack.modulus * stack.softness for stack in self.stacks)

    def displacement(self, r: ArrayLike, edges: ArrayLike) -> Array:
        """Displacement in m at `r` (k,) by unit pressure on each ring of `edges` (n + 1,), for E* = 1: (k, n)."""
        parts = [self.modulus / stack.modulus * stack.displacement(r, edges) for stack in self.stacks]
        return sum(parts, self._rest * ring_displacement(r, edges) if self._rest else np.zeros(()))


def pair_of(body: Material, counterbody: Material) -> Pair:
    """The surfaces of two bodies, at least one of them layered.

    Examples
    --------
    >>> from pymdr.problem.layers import Layer
    >>> from pymdr.problem.materials import Rigid
    >>> pair_of(Layered([Layer(Elastic(0.75, 0.5), "2 mm")]), Elastic(0.75, 0.5)).modulus
    0.5
    """
    bodies = (body, counterbody)
    return Pair(
        tuple(stack_of(one) for one in bodies if isinstance(one, Layered)),
        sum(surface_compliances(one).normal for one in bodies if not isinstance(one, Layered)),
    )


def _added(c: Array, kappa: float, soft: float, below: Array, bonded: bool) -> Array:
    """Compliance (k, 2, 2) of a layer on a known compliance; `soft`: reference shear modulus over its own.

    Displacements (U, W) along and out of the surface, tractions (T, S) over q times the reference modulus. For q h = 2 c,
    symmetric part: T = d U + e S, W = f S - e U; antisymmetric part: U = g T - b W, S = D W + b T.
    """
    t, y, rest = _waves(c)
    d, D = 4 * (t + y), 4 * rest
    e, b = 2 * y - (kappa - 1) * t, -2 * y - (kappa - 1) * t
    f, g = (kappa - 1) * t + rest, kappa * t + y
    d, D, e, b, f, g = (x / (kappa + 1) for x in (d, D, e, b, f, g))
    zero, one = np.zeros_like(c), np.ones_like(c)
    # Columns: U and W above, U and W below, T and S below; then, on the right, T and S above.
    rows = [
        [d, zero, d, zero, one, e, one, -e],
        [e, one, e, -one, zero, -f, zero, f],
        [one, b, -one, b, -g, zero, g, zero],
        [zero, D, zero, D, b, one, -b, one],
    ]
    C = below / soft
    if bonded:
        rows.append([zero, zero, one, zero, -C[:, 0, 0], -C[:, 0, 1], zero, zero])
        rows.append([zero, zero, zero, one, -C[:, 1, 0], -C[:, 1, 1], zero, zero])
    else:
        rows.append([zero, zero, zero, zero, one, zero, zero, zero])
        rows.append([zero, zero, zero, one, zero, -C[:, 1, 1], zero, zero])
    system = np.moveaxis(np.array(rows), 2, 0)
    return np.asarray(soft * np.linalg.solve(system[:, :, :6], system[:, :, 6:])[:, :2], dtype=np.float64)


def _waves(c: Array) -> tuple[Array, Array, Array]:
    """Tanh c, c/cosh² c, and their difference without cancellation."""
    decay = np.exp(-2 * c)
    t = -np.expm1(-2 * c) / (1 + decay)
    y = 4 * c * decay / (1 + decay) ** 2
    x = np.minimum(2 * c, 1.0)
    series = np.ones_like(x)
    for k in range(9, 0, -1):
        series = 1 + series * x**2 / ((2 * k + 2) * (2 * k + 3))
    small = series * x**3 / 6 / (2 * np.cosh(x / 2) ** 2)  # sinh x - x over 2 cosh²(x/2)
    return t, y, np.where(c < 0.5, small, t - y)


@lru_cache(maxsize=64)
def _quadrature(stack: Stack, span: float) -> tuple[Array, Array]:
    """Nodes q and weights 2 (1 - L)/q dq for radii whose sum is at most `span`."""
    end = _END / stack.thickness[0]
    longest = min(_WAVE / span, 3.0 / stack.thickness[0])
    number = end / longest * _NODES
    if number > _MOST:
        raise ProblemError(
            f"rings of radii up to {span / 2:.3g} m on a layer of {stack.thickness[0]:.3g} m need {number:.2g} nodes (limit "
            f"{_MOST}); use a thicker layer or a smaller contact."
        )
    first = 1e-8 / (sum(stack.thickness) + span)
    marks = [0.0, first]
    while marks[-1] < end:
        marks.append(min(marks[-1] * _RATIO, marks[-1] + longest, end))
    x, w = np.polynomial.legendre.leggauss(_NODES)
    low, width = np.array(marks[:-1])[:, None], np.diff(marks)[:, None]
    q = (low + width * (x + 1) / 2).ravel()
    weight = (width * w / 2).ravel()
    return q, 2 * weight * (1 - stack.compliance(q)) / q
