"""Springs under a curve, each with its part of the contact stiffness."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ConvergenceError
from pymdr.line.curves import Curve
from pymdr.line.foundation import states_at_depth
from pymdr.units import FloatArray

_GRADING = 1.5
"""The n-th part of the radius is (i/n)^1.5 - ((i-1)/n)^1.5: small contacts on the way have springs too."""
_WIDER = 1.2
"""Largest ratio of the widths of neighbouring parts where springs are added."""
_CLOSE = 1.2
"""Ratio of depths where springs are added near the end of what is resolved."""


@dataclass(frozen=True, eq=False)
class Springs:
    """Springs of stiffness dk per unit modulus at height d0; both sides of the line are in dk."""

    position: FloatArray
    """(n,) radii x in m, rising."""
    height: FloatArray
    """(n,) d0(x) in m."""
    stiffness: FloatArray
    """(n,) dk in m: k at the outer minus k at the inner end of a spring's part, per unit modulus."""
    centre: FloatArray
    """(n,) k(x) in m."""
    outer: FloatArray
    """(n,) k in m at the outer end of a spring's part."""
    border: float
    """Outer end of the last part in m."""
    limit: float
    """Depth in m up to which they suffice; inf where they end at a sharp edge."""
    n: int
    """Number of springs in a contact of that depth if they were graded toward the tip for it."""


def springs_to(curve: Curve, depth: float, n: int = 1000) -> Springs:
    """
    Put n springs under a curve, in the middle of parts that are graded toward the tip, and two beyond a depth.

    Parameters
    ----------
    curve : Curve
        Per unit modulus.
    depth : float
        The deepest indentation in m, above 0.
    n : int
        Springs in the elastic contact of that depth.

    Returns
    -------
    Springs

    Raises
    ------
    ConvergenceError
        If the curve ends before the depth.
    """
    radius = float(states_at_depth(curve, [depth]).contact_radius[0])
    if not 0.0 < radius < math.inf or radius > curve.max_radius:
        raise ConvergenceError(
            f"no disk contact at the depth {depth:g} m up to r = {curve.max_radius:g} m, where the known profile ends: "
            "extend the profile, or reduce the depth"
        )
    whole = radius >= curve.edge
    ends = radius * (np.arange(n + (0 if whole else 2) + 1) / n) ** _GRADING
    ends = np.minimum(ends, min(curve.edge, curve.max_radius))
    ends = np.concatenate([ends[:1], ends[1:][np.diff(ends) > 0.0]])
    return _of_ends(curve, ends, math.inf if ends[-1] >= curve.edge else depth, n)


def _of_ends(curve: Curve, ends: FloatArray, limit: float, n: int) -> Springs:
    """Springs in the middle of parts with given ends."""
    x = 0.5 * (ends[1:] + ends[:-1])
    stiffness = curve.stiffness(ends)
    return Springs(
        x,
        curve.depth(x),
        np.diff(stiffness),
        curve.stiffness(x),
        stiffness[1:],
        float(ends[-1]),
        limit,
        n,
    )


def extended(curve: Curve, springs: Springs, depth: float) -> Springs:
    """The springs with more added for a depth in m, of the same grading."""
    if depth <= springs.limit:
        return springs
    radius = float(states_at_depth(curve, [depth]).contact_radius[0])
    if not radius < math.inf or radius > curve.max_radius:
        raise ConvergenceError(
            f"no disk contact at the depth {depth:g} m up to r = {curve.max_radius:g} m, where the known profile ends: "
            "extend the profile, or reduce the depth"
        )
    n = springs.n
    width = 2.0 * (springs.border - springs.position[-1])
    top = min(curve.edge, curve.max_radius)
    more = [springs.border]
    while more[-1] < top and (more[-1] < radius or len(more) < 3 or more[-3] < radius):
        fitting = (_GRADING / n) * radius * (more[-1] / radius) ** (1.0 - 1.0 / _GRADING)
        width = max(width, min(fitting, _WIDER * width))
        more.append(min(more[-1] + width, top))
    added = _of_ends(curve, np.array(more), math.inf, n)
    return Springs(
        np.concatenate([springs.position, added.position]),
        np.concatenate([springs.height, added.height]),
        np.concatenate([springs.stiffness, added.stiffness]),
        np.concatenate([springs.centre, added.centre]),
        np.concatenate([springs.outer, added.outer]),
        added.border,
        math.inf if added.border >= curve.edge else depth,
        n,
    )


def next_depth(curve: Curve, springs: Springs) -> float:
    """A depth in m to which insufficient springs are extended: twice the present one, less near the last known one of the curve."""
    top, twice = min(curve.edge, curve.max_radius), 2.0 * springs.limit
    if not math.isfinite(top):
        return twice
    try:
        beyond = float(curve.place(twice).x) > top
        end = float(curve.depth(np.array([top]))[0]) if beyond else twice
    except ConvergenceError:  # layers are not resolved that far
        return _CLOSE * springs.limit
    return min(twice, end) if end > springs.limit else twice
