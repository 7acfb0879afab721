"""What of an equivalent profile decides where its contacts are disks: turning points, falls and concave kinks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pymdr.line.foundation import touching_radius
from pymdr.mapping.equivalent import EquivalentProfile
from pymdr.units import FloatArray

TOLERANCE = 1e-10
"""Of the mean pressure and the indentation: what rounding can do to a certificate."""
_LEAST_TRUSTED = 1e-6
_ROUNDING = 1e-12
"""Of the slope: a smaller jump is none."""
_INWARD = 2.0**-12
"""Of the first radius at which g falls: where the least pressure is searched from."""


@dataclass(frozen=True)
class Fall:
    """A stretch on which g falls; without width beside a concave kink whose fall is thinner than rounding."""

    start: float
    stop: float
    size: float
    """How far it falls in m."""


@dataclass(frozen=True)
class Landscape:
    """What of an equivalent profile decides where its contacts are disks."""

    equivalent: EquivalentProfile
    top: float
    """Radius in m up to which bodies might touch."""
    falls: tuple[Fall, ...]
    dents: tuple[float, ...]
    """Radii in m of concave kinks, where the slope of f falls; 0 for the apex of a hollow cone."""
    radii: FloatArray
    """Radii in m between which g bends little."""
    tolerance: float
    """Of the mean pressure: what the measured error of g' can do."""


def seen_upto(equivalent: EquivalentProfile, depth: float) -> float:
    """The radius in m up to which bodies at a depth in m might touch."""
    return min(touching_radius(equivalent, depth), equivalent.edge, equivalent.reach)


def landscape_of(equivalent: EquivalentProfile, top: float) -> Landscape | None:
    """What decides where contacts are disks up to a radius in m; None where g rises all the way."""
    turning = equivalent.turning_points(top)
    dents = _dents(equivalent, top)
    if turning and turning[0] == 0.0 and apex_kink(equivalent) < 0.0:
        dents = (0.0, *dents)
    if not turning and not dents:
        return None
    falls = _falls(equivalent, turning, dents, top)
    radii = _candidates(equivalent, falls, top)
    error = equivalent.error(radii)[:, 1]
    tolerance = float(np.clip(4.0 * np.max(error, initial=0.0), TOLERANCE, _LEAST_TRUSTED))
    return Landscape(equivalent, top, falls, dents, radii, tolerance)


def apex_kink(equivalent: EquivalentProfile) -> float:
    """The jump of f' beside which a pressure is as logarithmic as beside the apex of a cone; 0 of other tips."""
    if equivalent.exponent != 0.0:
        return 0.0
    rate = 2.0 * float(equivalent.slope(np.zeros(1))[0])
    return rate if math.isfinite(rate) else 0.0


def _dents(equivalent: EquivalentProfile, top: float) -> tuple[float, ...]:
    """
    Radii of concave kinks, whose jump is more than what the error of the slope can do.

    Beside them the pressure is logarithmically infinite under homogeneous half-spaces; what it is under graded ones no ring
    is passed over for.
    """
    if equivalent.exponent != 0.0:
        return ()
    corners = np.array(equivalent.corners(top)).reshape(-1, 2)
    radii, jumps = corners[corners[:, 1] < 0.0].T
    # at the kink itself the slope of g is infinite
    before = radii * (1.0 - 1e-6)
    error = np.maximum(4.0 * equivalent.error(before)[:, 1], _ROUNDING)
    return tuple(radii[-jumps > error * np.abs(equivalent.slope(before))].tolist())


def _falls(
    equivalent: EquivalentProfile, turning: Sequence[float], dents: Sequence[float], top: float
) -> tuple[Fall, ...]:
    marks = [*turning, top] if (len(turning) % 2 == 1) else [*turning]
    ends = [(marks[i], marks[i + 1]) for i in range(0, len(marks), 2)]
    for b in dents:
        beside = [i for i, (start, _) in enumerate(ends) if abs(start - b) <= 1e-9 * b]
        if beside:
            ends[beside[0]] = (b, max(ends[beside[0]][1], b))
        elif not any(start < b < stop for start, stop in ends):
            ends.append((b, b))
    ends.sort()
    g = equivalent.g(np.array(ends).ravel()).reshape(-1, 2)
    return tuple(
        Fall(start, stop, max(float(first - last), 0.0))
        for (start, stop), (first, last) in zip(ends, g, strict=True)
    )


def _candidates(equivalent: EquivalentProfile, falls: Sequence[Fall], top: float) -> FloatArray:
    """Radii among which least pressures and gaps are looked for before they are refined."""
    marks = np.array(sorted({0.0, top, *(end for fall in falls for end in (fall.start, fall.stop))}))
    first = float(marks[1])
    count = max(3, min(24, 768 // marks.size))
    inner = 0.5 - 0.5 * np.cos(np.pi * (np.arange(count) + 0.5) / count)
    between = (marks[:-1, None] + np.diff(marks)[:, None] * inner).ravel()
    steps = np.array([0.1, 0.3, 0.6, 1.0, 2.0, 4.0])
    beside = np.array(
        [(f.start - (f.stop - f.start) * steps, f.stop + (f.stop - f.start) * steps) for f in falls]
    ).ravel()
    toward_tip = first * 2.0 ** -np.arange(0.0, -math.log2(_INWARD), 0.25)
    resolving = equivalent.resolving_radii(top)
    radii = np.unique(np.concatenate([between, beside, toward_tip, resolving, marks]))
    radii = radii[(radii >= _INWARD * first) & (radii <= top)]
    return np.asarray(radii[np.append(True, np.diff(radii) > 1e-12 * radii[1:])])
