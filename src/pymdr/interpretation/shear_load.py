"""The shear traction of a contact as a load on the line: the punches of its slopes, and those of its steps."""

from __future__ import annotations

import numpy as np

from pymdr.interpretation.disk_sums import grouped
from pymdr.interpretation.stress import LineLoad, Punches, contact_segments
from pymdr.line.curves import ElasticLine
from pymdr.line.foundation import DiskStates, states_at_depth
from pymdr.line.friction import FrictionState, superposition
from pymdr.units import FloatArray

_ROUNDING = 1e-14
"""Fraction of the sum of magnitudes below which a sum of steps is rounding."""
_NOTHING = LineLoad((), 0.0, 0.0, 0.0, 0.0)


def steps_of(disks: DiskStates, weight: FloatArray, edge: FloatArray) -> tuple[FloatArray, FloatArray]:
    """
    Radii at which a superposition of disks steps on the line, and their heights over E* and its scale.

    Parameters
    ----------
    disks : DiskStates
        The disks of a superposition.
    weight, edge : ndarray
        Its weights, and its steps in m.

    Returns
    -------
    radii, heights : ndarray
        In m. Steps of several depths at one edge are added first, because they may cancel there.
    """
    a, height = disks.contact_radius, weight * disks.edge_excess + edge
    rings, total, size = grouped(a[height != 0.0], height[height != 0.0])
    real = np.abs(total) > _ROUNDING * size
    return rings[real], total[real]


def shear_load(line: ElasticLine, state: FrictionState) -> LineLoad:
    """
    The load of the shear traction on the line, G* times the shifts of its springs, as punches.

    Between two vertices of the anchor curve it is a multiple of the normal load, so the density of its punches is that of the normal
    ones times the slope of the anchor curve.

    Parameters
    ----------
    state : FrictionState
        The memory of the contact.
    """
    depth, weight, edge, scale = superposition(state)
    disks = states_at_depth(line, depth)
    a = disks.contact_radius
    if not np.any(a > 0.0):
        return _NOTHING
    slopes = scale * np.cumsum(weight[::-1])[::-1]
    segments: list[Punches] = []
    inside = None
    for i in np.flatnonzero(a > 0.0):
        outer = disks.place.take(i)
        if abs(slopes[i]) > _ROUNDING * scale:
            segments += contact_segments(line, outer, inside, float(slopes[i]))
        inside = outer
    rings, heights = steps_of(disks, weight, edge)
    pairs = zip(rings.tolist(), (scale * line.modulus * heights).tolist(), strict=True)
    largest = float(np.max(np.abs(slopes), initial=0.0)) * float(depth[-1]) + scale * float(
        np.sum(np.abs(heights))
    )
    radius = float(a[-1])
    return LineLoad(tuple(segments), radius, 0.0, radius, line.modulus * largest / radius, tuple(pairs))
