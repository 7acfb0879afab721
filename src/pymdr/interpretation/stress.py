"""Stress and displacement inside an elastic half-space from the load on the line.

A line load q(s) is a sum of flat punches: of radius s and weight -dq, and at an edge where q jumps of that weight. With
zeta = z + i s, R = sqrt(r^2 + zeta^2) and P = R + zeta each punch has a closed form, and every component of the stress is
one integral over the punches. With s = r + z sinh(t), split at s = r, it is as precise next to the surface as far below.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.interpretation.punch_tree import Punches as Punches
from pymdr.interpretation.punch_tree import resolved, unit_of
from pymdr.line.curves import ElasticLine
from pymdr.numerics.panels import Place
from pymdr.units import FloatArray, metres

if TYPE_CHECKING:
    from pymdr.interpretation.punch_kernel import Cells

_LEVELS = (0.25, 0.125, 0.0625, 0.03125, 0.015625, 0.0078125)
"""Step lengths of the rule, each half of the preceding one."""
_END = 4.0
"""End of the rule: beyond it a root singularity at the end of a segment contributes less than rounding."""
_AGREEMENT = 3e-8
"""Relative difference of two levels below which the finer one is accepted; its error is about the square of the
difference."""
_ENOUGH = 1e-11
"""Difference of the last two levels, relative to a typical stress, that is accepted."""
_ROUNDING = 1e-15
"""Difference of two levels that counts as rounding, over the typical stress."""
_SURFACE = 1e-30
"""Smallest depth over the radius; at smaller depths the stress differs from that at the surface by rounding only."""
_BLOCK = 1 << 16
"""Largest number of nodes evaluated together."""


@dataclass(frozen=True)
class LineLoad:
    """A load on the line of a half-space as punches."""

    segments: tuple[Punches, ...]
    edge_radius: float
    """Radius in m of the contact."""
    edge: float
    """Weight of the punch at that radius in N/m: the line load at the edge."""
    radius: float
    """Largest loaded radius in m."""
    scale: float
    """A typical stress in Pa."""
    rings: tuple[tuple[float, float], ...] = ()
    """Radii in m and weights in N/m of more punches, at steps of the line load inside the edge."""
    noise: float = _ROUNDING
    """Error of the load, over the typical stress."""

    @cached_property
    def cells(self) -> Cells | None:
        """The load resolved into series and punches; None where it cannot be, or without compiled code."""
        from pymdr.compiling import INTERPRETED

        if INTERPRETED or not self.segments or self.scale == 0.0:
            return None
        return resolved(self.segments, self.radius, self.scale, self.noise)


class Loads(NamedTuple):
    """The loads on the line of a body in one step."""

    normal: LineLoad
    shear: LineLoad | None = None
    """Shear load on the body, in the direction of x; None without friction."""
    twist: LineLoad | None = None
    """Torsional load Q on the body, around the axis, in Pa, with its scale in Pa/m; None without torsion."""


def line_load(
    line: ElasticLine, contact: Place, excess: float, *, zone: float = 0.0, strength: float = 0.0
) -> LineLoad:
    """
    The load q = E* (d - g) of a contact, with that of a cohesive zone.

    Parameters
    ----------
    line : ElasticLine
        Profile and modulus of homogeneous half-spaces.
    contact : Place
        Contact radius a in m.
    excess : float
        d - g(a) in m; not 0 at a sharp or an adhesive edge.
    zone : float
        Outer radius c of the cohesive zone in m; 0 without one.
    strength : float
        Its stress sigma0 in Pa: q = -2 sigma0 sqrt(c^2 - s^2) between a and c.
    """
    a = float(contact.x)
    segments = list(contact_segments(line, contact))
    if zone > a:

        def pulled(below: FloatArray) -> FloatArray:
            return -2.0 * strength * (zone - below) / np.sqrt(below * (2.0 * zone - below))

        segments.append(Punches(zone, a - zone, pulled))
        excess = 0.0
    edge, radius = line.modulus * excess, max(a, zone)
    pressed = line.modulus * float(line.depth(contact)) + abs(edge)
    scale = strength + (abs(pressed) / a if a > 0.0 else 0.0)
    return LineLoad(tuple(segments), a, edge, radius, scale)


def contact_segments(
    line: ElasticLine, contact: Place, inside: Place | None = None, factor: float = 1.0
) -> Iterator[Punches]:
    """
    The punches of the load E* (d - g) times a factor up to a radius, between the radii at which g is not smooth.

    Parameters
    ----------
    contact : Place
        The radius in m.
    inside : Place, optional
        Radius in m from which they are needed; from the axis by default.
    factor : float
        By which they are multiplied.

    Yields
    ------
    Punches
    """
    equivalent, a = line.equivalent, float(contact.x)
    bases = [0.0, *sorted(b for b in equivalent.kinks(a) if 0.0 < b < a)]
    for low, high in zip(bases, [*bases[1:], math.inf], strict=True):
        begin = 0.0 if inside is None else max(float(inside.base) - low + float(inside.offset), 0.0)
        width = min(high - low, float(contact.base) - low + float(contact.offset))

        # the upper end itself is read as the beginning of what follows
        last = float(np.nextafter(width, 0.0))

        def density(
            above: FloatArray, low: float = low, begin: float = begin, last: float = last
        ) -> FloatArray:
            at = Place(np.full(above.shape, low), np.minimum(begin + above, last))
            return factor * line.modulus * equivalent.slope(at)

        if width > begin:
            yield Punches(low + begin, width - begin, density)


class Sums(NamedTuple):
    """The integrals from which every component follows, imaginary parts of sums over punches, in Pa (`log` in N/m)."""

    inverse: FloatArray
    """1 / R."""
    cubed: FloatArray
    """z zeta / R^3."""
    mean: FloatArray
    """1 / P."""
    mixed: FloatArray
    """z / (R P)."""
    shear: FloatArray
    """z r / R^3."""
    log: FloatArray
    """ln P."""


Kernel: TypeAlias = Callable[[FloatArray, FloatArray, FloatArray, FloatArray], FloatArray]
"""Closed forms of a punch of weight 1 at r and z: of its radius s, and of s - r without cancellation."""


def sums(load: LineLoad, r: FloatArray, z: FloatArray, *, logarithm: bool = True) -> Sums:
    """
    The integrals at points inside the body.

    Parameters
    ----------
    r, z : ndarray
        Radius and depth in m, at least 0, of one shape.
    logarithm : bool
        Whether that of ln P, which only displacements need, is computed.

    Returns
    -------
    Sums
        Arrays of that shape.
    """
    integrals = quick_sums(load, r, z, logarithm)
    if integrals is not None:
        return Sums(integrals[0], integrals[1], integrals[2], integrals[3], integrals[4], integrals[8])
    return Sums(*integrated(load, r, z, _punch, np.array([1.0, 1.0, 1.0, 1.0, 1.0, load.radius])))


def quick_sums(load: LineLoad, r: FloatArray, z: FloatArray, logarithm: bool = True) -> FloatArray | None:
    """
    All closed forms summed over a load by compiled code.

    Returns
    -------
    ndarray or None
        Of shape (9, ...), in the order of :data:`pymdr.interpretation.punch_kernel.FORMS`; None without compiled code, or where the
        load cannot be resolved by series.
    """
    cells = load.cells
    if cells is None:
        return None
    from pymdr.interpretation.punch_kernel import FORMS, summed

    unit = unit_of(load.radius)
    radius, depth = np.ravel(r) / unit, np.ravel(z) / unit
    depth = np.maximum(depth, _SURFACE * np.maximum(radius, load.radius / unit))
    total = np.zeros((radius.size, FORMS))
    summed(cells, radius, depth, total, logarithm)
    total *= load.scale
    total[:, -1] *= unit
    integrals = total.T.reshape(FORMS, *np.shape(r))
    return integrals + _of_rings(load, np.asarray(r), depth.reshape(np.shape(r)) * unit, punch_forms)


def integrated(load: LineLoad, r: FloatArray, z: FloatArray, punch: Kernel, sizes: FloatArray) -> FloatArray:
    """
    Closed forms of punches summed over a load.

    Parameters
    ----------
    punch : callable
        The closed forms of one punch, shape (k, ...).
    sizes : ndarray, shape (k,)
        Typical sums over a typical stress, 1 or a length in m.
    """
    radius, depth = np.ravel(r), np.ravel(z)
    depth = np.maximum(depth, _SURFACE * np.maximum(radius, load.radius))
    total = np.zeros((sizes.size, radius.size))
    limits = np.outer([load.noise, _ENOUGH], load.scale * sizes)
    if load.radius > 0.0:
        for segment in itertools.chain.from_iterable(segment.parts() for segment in load.segments):
            total += _integrated(segment, radius, depth, punch, limits)
        total += _of_rings(load, radius, depth, punch)
    return total.reshape(-1, *np.shape(r))


def _of_rings(load: LineLoad, r: FloatArray, z: FloatArray, punch: Kernel) -> FloatArray:
    """The closed forms of the punches at steps of the load."""
    rings = [ring for ring in ((load.edge_radius, load.edge), *load.rings) if ring[1] != 0.0]
    forms = (weight * punch(r, z, np.full(r.shape, ring), ring - r) for ring, weight in rings)
    return np.asarray(sum(forms, np.zeros(())))


def _punch(r: FloatArray, z: FloatArray, s: FloatArray, above: FloatArray) -> FloatArray:
    """The closed forms of a punch of radius s and weight 1 of :class:`Sums`; `above` is s - r with all its digits."""
    return punch_forms(r, z, s, above)[[0, 1, 2, 3, 4, 8]]


def punch_forms(r: FloatArray, z: FloatArray, s: FloatArray, above: FloatArray) -> FloatArray:
    """All closed forms of a punch of radius s and weight 1, shape (9, ...); `above` is s - r with all its digits."""
    zeta = z + 1j * s
    root = np.sqrt(z * z - above * (r + s) + 2j * z * s)
    total = root + zeta
    inverse, mean = 1.0 / root, 1.0 / total
    cubed, both = z * inverse**3, inverse * mean
    return np.array(
        [
            inverse.imag,
            (cubed * zeta).imag,
            mean.imag,
            (z * both).imag,
            r * cubed.imag,
            r * both.imag,
            r * (mean * mean).imag,
            z * r * (both * mean).imag,
            np.angle(total),
        ]
    )


class _Parts(NamedTuple):
    """Points, and for each the punches of a segment on one side of its radius, whose radii are counted from that one."""

    r: FloatArray
    z: FloatArray
    start: FloatArray
    """Lower end of the segment."""
    low: FloatArray
    """Lower end of the part."""
    high: FloatArray
    """Upper end of the part."""
    stop: FloatArray
    """Upper end of the segment."""

    def take(self, some: np.ndarray) -> _Parts:
        """Those of some points."""
        return _Parts(*(values[some] for values in self))


def _integrated(
    segment: Punches, r: FloatArray, z: FloatArray, punch: Kernel, limits: FloatArray
) -> FloatArray:
    """
    The closed forms integrated over the punches of a segment, at points of shape (n,).

    The limits are the errors that are rounding, and those that are accepted where the load itself changes on lengths that no rule resolves.
    """
    answer = np.zeros((limits.shape[1], r.size))
    ends = segment.anchor - r, (segment.anchor - r) + segment.extent
    start, stop = ends if segment.extent > 0.0 else ends[::-1]
    for low, high in ((start, np.minimum(stop, 0.0)), (np.maximum(start, 0.0), stop)):
        inside = np.flatnonzero(high > low)
        for some in np.array_split(inside, max(1, inside.size * _nodes(1).shape[1] // _BLOCK)):
            if some.size:
                parts = _Parts(r, z, start, low, high, stop).take(some)
                answer[:, some] += _converged(segment, parts, punch, limits)
    return answer


def _converged(segment: Punches, parts: _Parts, punch: Kernel, limits: FloatArray) -> FloatArray:
    """The integral over parts of a segment, by a double exponential rule of rising level."""
    noise, enough = limits[:, :, None]
    answer = np.empty((noise.size, parts.r.size))
    left = np.arange(parts.r.size)
    total, size = _rule(segment, parts, punch, 0)
    for level in range(1, len(_LEVELS)):
        more, sizes = _rule(segment, parts.take(left), punch, level)
        finer, size = 0.5 * total + more, 0.5 * size + sizes
        least = noise if level < len(_LEVELS) - 1 else enough
        agreed = np.all(np.abs(finer - total) <= _AGREEMENT * size + least, axis=0)
        answer[:, left[agreed]] = finer[:, agreed]
        left, total, size = left[~agreed], finer[:, ~agreed], size[:, ~agreed]
        if left.size == 0:
            return answer
    r, z = parts.r[left[0]], parts.z[left[0]]
    raise ConvergenceError(
        f"stress at r = {metres(r)}, z = {metres(z)}: the quadrature did not converge; name the radii where the profile is "
        "not smooth as breakpoints"
    )


@lru_cache(maxsize=len(_LEVELS))
def _nodes(level: int) -> FloatArray:
    """The nodes that a level adds: shares of the interval below and above, and weights, shape (3, n)."""
    h = _LEVELS[level]
    count = round(_END / h)
    w = h * np.arange(-count, count + 1)
    if level > 0:
        w = w[1::2]
    below = 1.0 / (1.0 + np.exp(-math.pi * np.sinh(w)))
    above = 1.0 / (1.0 + np.exp(math.pi * np.sinh(w)))
    return np.array([below, above, h * math.pi * np.cosh(w) * below * above])


def _rule(segment: Punches, parts: _Parts, punch: Kernel, level: int) -> tuple[FloatArray, FloatArray]:
    """Contributions of the nodes of a level to the integrals, and to those of their absolute values."""
    below, above, weight = _nodes(level)[:, :, None]
    r, z, start, low, high, stop = parts
    first, last = np.arcsinh(low / z), np.arcsinh(high / z)
    # of a whole segment the difference of its ends has lost the digits of its extent
    width = np.where((low == start) & (high == stop), abs(segment.extent), high - low)
    length = 2.0 * np.arcsinh(0.5 * width / z / np.cosh(0.5 * (first + last)))
    t = np.where(below < 0.5, first + length * below, last - length * above)
    # distances from an end as products: differences of radii lose the digits of nodes close to it
    if segment.extent > 0.0:
        step = 0.5 * length * below
        distance = (low - start) + 2.0 * z * np.cosh(first + step) * np.sinh(step)
        s = segment.anchor + distance
    else:
        step = 0.5 * length * above
        distance = (stop - high) + 2.0 * z * np.cosh(last - step) * np.sinh(step)
        s = segment.anchor - distance
    terms = punch(r, z, s, z * np.sinh(t))
    terms *= weight * length * z * np.cosh(t) * segment.density(distance)
    return terms.sum(axis=1), np.abs(terms).sum(axis=1)


def stress(integrals: Sums, poisson: float) -> FloatArray:
    """The components rr, tt, zz, rz of the stress in Pa, tension positive, shape (4, ...)."""
    lateral = (1.0 - 2.0 * poisson) * integrals.mean
    return (
        np.array(
            [
                integrals.inverse - lateral - integrals.cubed + integrals.mixed,
                2.0 * poisson * integrals.inverse + lateral - integrals.mixed,
                integrals.inverse + integrals.cubed,
                integrals.shear,
            ]
        )
        / math.pi
    )


def displacement(integrals: Sums, r: FloatArray, z: FloatArray, poisson: float, shear: float) -> FloatArray:
    """
    The displacements u_r and u_z in m, positive outward and into the body, shape (2, ...).

    Parameters
    ----------
    r, z : ndarray
        Radius and depth in m.
    poisson, shear : float
        nu, and G in Pa, of the body.
    """
    outward = r * ((1.0 - 2.0 * poisson) * integrals.mean - integrals.mixed)
    inward = 2.0 * (1.0 - poisson) * integrals.log - z * integrals.inverse
    return np.array([outward, inward]) / (2.0 * math.pi * shear)
