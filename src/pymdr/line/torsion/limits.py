"""The limit of the springs under torsion: the image of the largest frictional traction."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from pymdr.line.curves import ElasticLine
from pymdr.line.foundation import states_at_depth
from pymdr.numerics.panels import Place
from pymdr.numerics.table import Table, tabulated
from pymdr.units import FloatArray

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
_WIDEST = 1.5
"""Largest width of a panel of t = arcosh(s/x)."""
_FARTHEST = 40.0
"""Where sech^3 t vanishes to rounding."""
_ONTO_KINK = 1e-8
"""Relative distance from a kink up to which a contact ends there."""
_NEAR_KINK = 0.1
"""Relative distance from a kink beyond which the rounding of the contact radius loses no digits."""
_CANCELLING = 0.75
"""1 - k^2 above which Carlson's integrals replace those of Legendre, whose difference loses digits."""


Kernel = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True)
class TwistedLine:
    """
    The line of a contact under torsion.

    Parameters
    ----------
    line : ElasticLine
        Of a profile that rises.
    shear : float
        G in Pa; 1/G is the sum of 1/G_i over both bodies.
    friction : float
        The coefficient mu.
    """

    line: ElasticLine
    shear: float
    friction: float

    def limit_at(self, depth: float) -> Limit:
        """The limit of the springs at an indentation in m."""
        own = self._radius(depth)
        radius = max(self._steep_kink(own, _ONTO_KINK), default=own)
        excess = depth - float(self.line.equivalent.g(np.array([radius]))[0])
        return Limit(depth, radius, excess if excess > 1e-13 * depth else 0.0, self)

    def _radius(self, depth: float) -> float:
        return float(states_at_depth(self.line, np.array([depth])).contact_radius[0])

    def _steep_kink(self, radius: float, near: float) -> tuple[float, ...]:
        """The kink below a radius, if it is within a relative distance and g' has no bound there."""
        inner = max(self.kinks(radius), default=0.0)
        if inner == 0.0 or radius - inner > near * radius:
            return ()
        with np.errstate(divide="ignore", invalid="ignore"):
            steep = not math.isfinite(float(self.line.equivalent.slope(np.array([inner]))[0]))
        return (inner,) if steep else ()

    def error_near_kink(self, depth: float) -> float:
        """
        Relative error of the limit by the rounding of a contact radius next to a kink where g' has no bound.

        The distance d from the kink, relative to the radius, is rounded to eps/d; up to 1e-8 the contact ends at the kink, which changes the limit
        by up to 0.3 d.
        """
        radius = self._radius(depth)
        for inner in self._steep_kink(radius, _NEAR_KINK):
            distance = (radius - inner) / radius
            return 0.3 * distance if distance <= _ONTO_KINK else float(np.finfo(float).eps) / distance
        return 0.0

    def kinks(self, top: float) -> tuple[float, ...]:
        """Radii in m below `top` to whose right g is not smooth."""
        return tuple(x for x in self.line.equivalent.kinks(top) if 0.0 < x < top)

    def marks(self, top: float) -> tuple[FloatArray, FloatArray]:
        """
        The axis with the kinks below `top`, and radii in m that bound panels above kinks, where g' and loads have roots.

        A panel above a kink is at most four times as long as the distance from the point before it.
        """
        points = np.array([0.0, *self.kinks(top)])
        gaps = np.diff(np.append(points, top))
        counts = np.maximum(np.ceil(0.5 * np.log2(gaps[1:] / gaps[:-1])), 1.0).astype(int)
        above = [
            kink + gap * 4.0 ** np.arange(1, n)
            for kink, gap, n in zip(points[1:], gaps[:-1], counts, strict=True)
        ]
        return points, np.sort(np.concatenate([points[1:], *above]))


@dataclass(frozen=True)
class Limit:
    """The largest load of the springs at an indentation; :meth:`TwistedLine.limit_at` makes it."""

    depth: float
    """Indentation in m."""
    radius: float
    """Contact radius a in m."""
    excess: float
    """D - g(a) in m, above 0 at a sharp edge."""
    twisted: TwistedLine = field(repr=False, compare=False)

    @property
    def _scale(self) -> float:
        """4 mu E*/pi in Pa."""
        return 4.0 * self.twisted.friction * self.twisted.line.modulus / math.pi

    def load(self, x: FloatArray) -> FloatArray:
        """
        Largest Q in Pa at some x in m.

        Q_max = 4 mu int_x^a p dr/sqrt(r^2 - x^2) = (4 mu E*/pi) [int_x^a g'(s) K(k) ds/s + (d - g(a)) K(k_a)/a],
        k^2 = 1 - x^2/s^2; without bound toward the axis.
        """
        from scipy.special import ellipkm1

        a = self.radius
        total = self._integral(x, lambda ratio, s: ellipkm1(np.minimum(ratio**2, 1.0)) / s)
        total += self.excess * ellipkm1(np.minimum((x / a) ** 2, 1.0)) / a
        return np.where(x <= a, self._scale * total, 0.0)

    def rate(self, x: FloatArray) -> FloatArray:
        """Derivative of :meth:`load` over the indentation in Pa/m, at some x in m below the contact radius: (4 mu E*/pi) K(k_a)/a."""
        from scipy.special import ellipkm1

        return np.asarray(self._scale / self.radius * ellipkm1((x / self.radius) ** 2))

    def slope(self, x: FloatArray) -> FloatArray:
        """
        Derivative of :meth:`load` over x in Pa/m, at some x in m below the contact radius, from the right.

        -(4 mu E*/(pi x)) [(pi/2) g'(x) + int_x^a g'(s) B(k) ds/s + (d - g(a)) B(k_a)/a], B = (E - (1 - k^2) K)/k^2.
        """
        a = self.radius
        total = self._integral(x, lambda ratio, s: _complete(ratio**2) / s)
        total += self.excess * _complete((x / a) ** 2) / a
        total += 0.5 * math.pi * self.twisted.line.equivalent.slope(x)
        return np.where(x < a, -self._scale / x * total, 0.0)

    def torque(self, x: FloatArray) -> FloatArray:
        """
        Torque in N m of the springs from x outward if all are at their limit.

        2 int_x^a y^2 Q_max dy = (8 mu E*/pi) [int_x^a g'(s) s^2 H(x/s) ds + (d - g(a)) a^2 H(x/a)],
        H(t) = int_t^1 y^2 K(sqrt(1 - y^2)) dy.
        """
        a = self.radius
        x = np.minimum(x, a)
        total = self._integral(x, lambda ratio, s: s**2 * _moment(ratio))
        total += self.excess * a**2 * _moment(x / a)
        return np.asarray(2.0 * self._scale * total)

    def traction(self, r: FloatArray) -> FloatArray:
        """Mu p in Pa at some r in m below the contact radius."""
        a = self.radius
        with np.errstate(divide="ignore"):
            edge = self.excess / np.sqrt((a - r) * (a + r))
        smooth = self.twisted.line.equivalent.pressure_integral(r, a)
        return np.asarray(0.25 * self._scale * (smooth + edge))

    def _integral(self, x: FloatArray, kernel: Kernel) -> FloatArray:
        """Integral of g'(s) times a kernel of x/s and s, from every x to the contact radius."""
        s, weights = self._radii(x)
        with np.errstate(divide="ignore", invalid="ignore"):
            terms = self.twisted.line.equivalent.slope(s) * kernel(x[:, None] / s.x, s.x) * weights
        # at a kink itself g' may have no bound, where its weight is 0
        return np.asarray(np.sum(np.where(weights > 0.0, terms, 0.0), axis=1))

    def _radii(self, x: FloatArray) -> tuple[Place, FloatArray]:
        """
        Nodes s between every x and the contact radius, and their weights.

        From x and every mark on up to twice that radius s is the square of the variable, counted from the kink below, where g' may have an inverse
        square root; beyond it is x cosh t, in which logarithms of s/x are smooth.
        """
        a, v = self.radius, (NODES + 1.0) / 2.0
        inner = np.maximum(x, 1e-16 * a)[:, None]
        points, marks = self.twisted.marks(a)
        bases = np.maximum(np.append(0.0, marks), inner)
        ends = np.maximum(np.append(marks, a), inner)
        near = np.minimum(2.0 * bases, ends)
        kink = points[np.searchsorted(points, bases, side="right") - 1]
        step, weight = nodes_above(kink, bases, near)
        places, weights = [(np.broadcast_to(bases[:, :, None], step.shape), step)], [weight]
        far = np.flatnonzero(np.any(ends > near, axis=0))
        if far.size:
            base, end = near[:, far], ends[:, far]
            # the differences of arcosh s/x between near ends, from those of s
            start = 2.0 * np.arcsinh(np.sqrt((base - inner) / (2.0 * inner)))
            span = 2.0 * np.arcsinh(np.sqrt((end - inner) / (2.0 * inner))) - start
            counts = np.ceil(np.max(span, axis=0) / _WIDEST).astype(int)
            part = (
                np.concatenate([np.arange(n) / n for n in counts])[:, None]
                + v / np.repeat(counts, counts)[:, None]
            )
            start, span, base = (np.repeat(one, counts, axis=1)[:, :, None] for one in (start, span, base))
            along = span * part
            places.append(
                (
                    np.broadcast_to(base, along.shape),
                    2.0 * inner[:, :, None] * np.sinh(start + 0.5 * along) * np.sinh(0.5 * along),
                )
            )
            weights.append(
                span
                / np.repeat(counts, counts)[:, None]
                * WEIGHTS
                / 2.0
                * inner[:, :, None]
                * np.sinh(start + along)
            )
        base, offset, weight = (
            np.concatenate([one.reshape(x.size, -1) for one in parts], axis=1)
            for parts in (*zip(*places, strict=True), weights)
        )
        return Place(base, offset), weight


def nodes_above(base: FloatArray, start: FloatArray, stop: FloatArray) -> tuple[FloatArray, FloatArray]:
    """
    Nodes, counted from the start, and weights of panels in the root of the distance from a base: shape (..., panels, nodes).

    The base is the kink below a panel, from which loads rise as a power series in this root, wherever the panel starts.
    """
    low = np.sqrt(start - base)
    width = ((stop - start) / (np.sqrt(stop - base) + low + 1e-300))[..., None]
    step = width * (NODES + 1.0) / 2.0
    low = low[..., None]
    return step * (2.0 * low + step), (low + step) * width * WEIGHTS


def _complete(rest: FloatArray) -> FloatArray:
    """B = (E - (1 - k^2) K)/k^2 of rest = 1 - k^2, a complete elliptic integral without cancellation."""
    from scipy.special import ellipe, ellipkm1, elliprd, elliprf

    rest = np.clip(rest, 1e-300, 1.0)
    near = rest > _CANCELLING
    values = np.empty(rest.shape)
    far = rest[~near]
    values[~near] = (ellipe(1.0 - far) - far * ellipkm1(far)) / (1.0 - far)
    values[near] = elliprf(0.0, rest[near], 1.0) - elliprd(0.0, rest[near], 1.0) / 3.0
    return values


@cache
def _moments() -> Table:
    """H over t = arcosh(1/ratio): int_0^t tanh sech^3 K(tanh) dt."""
    from scipy.special import ellipkm1

    def integral(t: FloatArray, _: np.ndarray) -> FloatArray:
        parts = int(max(np.ceil(t.max() / 0.5), 1.0))
        low = t[:, None] * np.arange(parts) / parts
        at = low[:, :, None] + (t / parts)[:, None, None] * (NODES + 1.0) / 2.0
        sech = 1.0 / np.cosh(at)
        values = np.tanh(at) * sech**3 * ellipkm1(sech**2)
        return np.asarray((np.sum(values @ WEIGHTS, axis=1) * t / (2.0 * parts))[None, :])

    return tabulated(integral, np.array([0.0]), np.array([_FARTHEST]))


def _moment(ratio: FloatArray) -> FloatArray:
    """H(t) = int_t^1 y^2 K(sqrt(1 - y^2)) dy."""
    t = np.arccosh(1.0 / np.clip(ratio, 1.0 / math.cosh(_FARTHEST), 1.0))
    return np.asarray(_moments()(t.ravel())[0].reshape(t.shape))
