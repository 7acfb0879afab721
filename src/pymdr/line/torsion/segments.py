"""Segments of springs under torsion: their loads, torque, energy, traction and displacement."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from pymdr.line.torsion.limits import Limit, TwistedLine, nodes_above
from pymdr.units import FloatArray

_TERMS = 20
_OCTAVES = 34
_FEW_OCTAVES = 6
"""Toward the axis, for integrands with a factor x^2."""
_KINKS = 14
"""Panels above the kinks of g, each four times as long as the one before, for tractions next to kinks."""
_ROUNDING = 1e-11
"""Of the largest load: steps of the load below it are those of a border between stick and slip, which is found to rounding."""


@dataclass(frozen=True)
class Segment:
    """Springs between two radii with Q = constant + sign Q_max(x) - rate g(x)."""

    low: float
    high: float
    constant: float = 0.0
    """In Pa."""
    sign: int = 0
    limit: Limit | None = None
    """The limit Q_max that these springs reached, if they have a sign."""
    rate: float = 0.0
    """In Pa/m, of springs that entered while the body turned."""

    def slips(self, indentation: float) -> bool:
        """Whether the springs are at their limit at an indentation."""
        return self.limit is not None and self.limit.depth == indentation and self.constant == 0.0


def load_of(line: TwistedLine, segment: Segment, x: FloatArray) -> FloatArray:
    """Q in Pa of some springs of a segment."""
    q = np.full(x.shape, segment.constant)
    if segment.limit is not None:
        q = q + segment.sign * segment.limit.load(x)
    return q - segment.rate * line.line.equivalent.g(x) if segment.rate else q


def load_slope(line: TwistedLine, segment: Segment, x: FloatArray) -> FloatArray:
    """Derivative of :func:`load_of` over x in Pa/m at some x in m above 0, from the right."""
    slope = np.zeros(x.shape) if segment.limit is None else segment.sign * segment.limit.slope(x)
    return slope - segment.rate * line.line.equivalent.slope(x) if segment.rate else slope


def steps_of(line: TwistedLine, segments: Sequence[Segment]) -> tuple[tuple[float, float], ...]:
    """Radii in m at which the load Q drops, with the drops in Pa: of springs that entered a contact already twisted, and at its edge."""
    borders = np.array([one.high for one in segments])
    inner = np.array(
        [float(load_of(line, one, at)[0]) for one, at in zip(segments, borders[:, None], strict=True)]
    )
    outer = [
        float(load_of(line, one, at)[0]) for one, at in zip(segments[1:], borders[:-1, None], strict=True)
    ]
    drops = inner - np.append(outer, [0.0] * bool(segments))
    size = np.max(np.abs([*inner, *(one.constant for one in segments)]), initial=0.0)
    steep = np.abs(drops) > _ROUNDING * size
    return tuple(zip(borders[steep].tolist(), drops[steep].tolist(), strict=True))


def torque_of(line: TwistedLine, segments: Iterable[Segment]) -> float:
    """M = 2 int x^2 Q dx in N m."""
    total = 0.0
    for one in segments:
        total += 2.0 / 3.0 * one.constant * (one.high**3 - one.low**3)
        if one.limit is not None:
            low, high = one.limit.torque(np.array([one.low, one.high]))
            total += one.sign * float(low - high)
        if one.rate:
            x, weights = nodes_of(line, one.low, one.high)
            total -= 2.0 * one.rate * float(np.sum(weights * x**2 * line.line.equivalent.g(x)))
    return total


def energy_of(line: TwistedLine, segments: Iterable[Segment]) -> float:
    """U = int x^2 Q^2 dx / (8 G) in J."""
    total = 0.0
    for one in segments:
        if one.sign or one.rate:
            x, weights = nodes_of(line, one.low, one.high)
            total += float(np.sum(weights * x**2 * load_of(line, one, x) ** 2))
        else:
            total += one.constant**2 * (one.high**3 - one.low**3) / 3.0
    return total / (8.0 * line.shear)


def traction_of(line: TwistedLine, segments: Sequence[Segment], r: FloatArray) -> FloatArray:
    """
    Circumferential traction in Pa at some r above 0 in m, below the contact radius.

    tau = -(r/2 pi) int_r^a dQ(x)/sqrt(x^2 - r^2), with x^2 = r^2 + y^2 and every step of Q, the last at the edge.
    """
    total = np.zeros(r.shape)
    innermost = float(np.min(r, initial=math.inf))
    for one in segments:
        if one.high <= innermost or not (one.sign or one.rate):
            continue
        inside = max(one.low, innermost, 1e-10 * one.high)
        base, low, high = _panels(line, inside, one.high, _OCTAVES)
        root, width = np.sqrt(low - base), np.sqrt(high - base) - np.sqrt(low - base)
        u = np.cos(math.pi * (np.arange(_TERMS) + 0.5) / _TERMS)
        at = base + (root + width * (u[:, None] + 1.0) / 2.0) ** 2
        values = load_of(line, one, at.ravel()).reshape(_TERMS, -1)
        series = np.polynomial.chebyshev.chebfit(u, values, _TERMS - 1)
        slopes = np.asarray(np.polynomial.chebyshev.chebder(series), dtype=np.float64)
        # shorter panels next to kinks, of the same series: the rounding of loads would be a larger part of theirs
        longer = low
        base, low, high = _panels(line, inside, one.high, _OCTAVES, _KINKS)
        of = np.searchsorted(longer, low, side="right") - 1
        slopes, root, width = slopes[:, of], root[of], width[of]
        inner, start, stop = (
            np.sqrt(np.maximum((end - r[:, None]) * (end + r[:, None]), 0.0)) for end in (base, low, high)
        )
        offset, weights = nodes_above(inner, start, stop)
        y = start[:, :, None] + offset
        x = np.sqrt(r[:, None, None] ** 2 + y**2)
        # x less the base without cancellation
        above = ((start - inner)[:, :, None] + offset) * (y + inner[:, :, None])
        nearest = np.maximum(r[:, None], base)[:, :, None]
        above = above / (x + nearest) + (nearest - base[:, None])
        v = np.sqrt(np.clip(above, np.maximum(low - base, 1e-300)[:, None], (high - base)[:, None]))
        rates = _series(slopes, 2.0 * (v - root[:, None]) / width[:, None] - 1.0) / (v * width[:, None] * x)
        total -= np.sum(weights * rates, axis=(1, 2))
    for radius, drop in steps_of(line, segments):
        with np.errstate(divide="ignore"):
            total += np.where(r <= radius, drop / np.sqrt(np.maximum((radius - r) * (radius + r), 0.0)), 0.0)
    return np.asarray(r / (2.0 * math.pi) * total)


def displacement_of(line: TwistedLine, segments: Iterable[Segment], r: FloatArray) -> FloatArray:
    """
    Circumferential displacement in m at some r above 0 in m.

    u = (4/pi r) int_0^min(r, a) x w dx/sqrt(r^2 - x^2), w = x Q/(8 G), with x = r sin(angle).
    """
    total = np.zeros(r.shape)
    for one in segments:
        panels = _panels(line, one.low, one.high, _FEW_OCTAVES)
        base, start, stop = (np.arcsin(np.minimum(end / r[:, None], 1.0)) for end in panels)
        angle, weights = nodes_above(base, start, stop)
        x = r[:, None, None] * np.sin(start[:, :, None] + angle)
        q = load_of(line, one, np.minimum(x, one.high).ravel()).reshape(x.shape)
        total += np.sum(weights * x**2 * q, axis=(1, 2))
    return np.asarray(4.0 / (math.pi * r) * total / (8.0 * line.shear))


def nodes_of(line: TwistedLine, low: float, high: float) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of integrals between two radii."""
    base, start, stop = _panels(line, low, high, _FEW_OCTAVES)
    offset, weights = nodes_above(base, start, stop)
    return (start[:, None] + offset).ravel(), weights.ravel()


def _panels(
    line: TwistedLine, low: float, high: float, octaves: int, above_kinks: int = 0
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Base, start and end of panels between two radii; the variable is the root of the distance from the base.

    Loads have roots above the kinks of g, and logarithms at the axis: the base is the last of these points below a panel. Panels are in
    octaves toward the axis.
    """
    points, marks = line.marks(high)
    toward_axis = high * 0.5 ** np.arange(octaves, 0.0, -1.0)
    gaps = np.diff(np.append(points, high))[1:, None]
    toward_kinks = points[1:, None] + gaps * 0.25 ** np.arange(above_kinks, 0.0, -1.0)
    inside = np.concatenate([toward_axis, marks, toward_kinks.ravel()])
    edges = np.unique(np.concatenate([[low], inside[(inside > low) & (inside < high)], [high]]))
    return points[np.searchsorted(points, edges[:-1], side="right") - 1], edges[:-1], edges[1:]


def _series(coefficients: FloatArray, u: FloatArray) -> FloatArray:
    """Chebyshev series of panels, shape (terms, panels), at u of shape (..., panels, nodes)."""
    last, before = np.zeros(u.shape), np.zeros(u.shape)
    for term in coefficients[:0:-1]:
        last, before = term[:, None] + 2.0 * u * last - before, last
    return np.asarray(coefficients[0][:, None] + u * last - before)
