"""The largest value of a field over the radii, and the radii of infinite pressure."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence

import numpy as np

from pymdr.units import FloatArray

_SAMPLES = 129


def largest_value(
    field: Callable[[FloatArray], FloatArray], end: float, marks: Sequence[float] = ()
) -> float:
    """
    The largest value of a curve over radii from 0 to an end; inf for an unbounded curve.

    Between the marks the curve is sampled with more points toward both of them; the neighbourhood of the largest sample is
    refined until the value converges to rounding.

    Parameters
    ----------
    field : callable
        Value at given radii.
    end : float
        In m.
    marks : sequence of float
        Radii in m at which the curve may have a kink or a singularity.

    Examples
    --------
    >>> round(largest_value(lambda r: r * (1.0 - r), 1.0), 15)
    0.25
    """
    if not end > 0.0:
        return 0.0 if end == 0.0 else math.nan
    bounds = np.array([0.0, *sorted(m for m in marks if 0.0 < m < end), end])
    fraction = 0.5 * (1.0 - np.cos(np.pi * np.arange(_SAMPLES) / (_SAMPLES - 1)))
    r = np.unique(np.concatenate([a + (b - a) * fraction for a, b in itertools.pairwise(bounds)]))
    p = field(r)
    if np.all(np.isnan(p)):
        return math.nan
    best = float(np.nanmax(p))
    for i in np.argsort(-np.nan_to_num(p, nan=-math.inf))[:3]:
        if not math.isfinite(best):
            break
        best = max(best, _refined(field, float(r[max(i - 1, 0)]), float(r[min(i + 1, r.size - 1)])))
    return best


def _refined(field: Callable[[FloatArray], FloatArray], low: float, high: float) -> float:
    """The largest value by repeated refinement around the largest sample."""
    best = -math.inf
    for _ in range(40):
        r = np.linspace(low, high, 17)
        p = field(r)
        i = int(np.nanargmax(p)) if np.isfinite(p).any() else 0
        gain, best = float(p[i]) - best, max(best, float(p[i]))
        low, high = float(r[max(i - 1, 0)]), float(r[min(i + 1, r.size - 1)])
        if not math.isfinite(best) or abs(gain) <= 1e-15 * abs(best):
            break
    return best


def infinite_pressures(
    gap: Callable[[FloatArray], FloatArray], kinks: FloatArray, a: float
) -> tuple[float, ...]:
    """
    Radii in m within a contact at which its pressure is infinite: a sharp tip, and convex kinks.

    They are determined from the profile, because elements and springs of a finite size have finite pressures there.

    Parameters
    ----------
    gap : callable
        The profile in m at radii in m.
    kinks : ndarray
        Radii in m at which its slope may jump.
    a : float
        Contact radius in m.

    Examples
    --------
    >>> infinite_pressures(lambda r: 0.1 * r, np.array([0.5]), 1.0)
    (0.0,)
    """
    if not a > 0.0:
        return ()
    radii = np.unique(np.append(0.0, kinks))
    radii = radii[radii < (1.0 - 1e-9) * a]
    size = np.where(radii > 0.0, radii, a)
    near, far = (
        (gap(radii + h) + gap(np.abs(radii - h)) - 2.0 * gap(radii)) / h for h in (1e-6 * size, 1e-4 * size)
    )
    steepest = float(gap(np.array([a]))[0] - gap(np.zeros(1))[0]) / a
    # for a smooth profile the difference of the slopes vanishes with the distance
    return tuple(radii[(near > 0.5 * np.abs(far)) & (near > 1e-6 * abs(steepest))].tolist())
