"""Whether a surface is one bump, where its apex is, and its mean profile about it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pymdr.errors import ProblemError
from pymdr.units import FloatArray, metres

FEWEST_RINGS = 8
_LEVELS = 40
SECOND = 0.1
"""Of the height of the bump, from which on a second summit stands out."""
_NOISES = 6.0
"""Standard deviations of the noise of smoothed heights that chance does not reach."""
ROUNDNESS = 0.15
"""Most of the height of the bump by which heights at one radius may scatter besides noise (root mean square): radii of 1 to 2.5."""
_CAP = 0.5
"""Share of the reach within which the apex is looked for."""
_FEWEST_OF_APEX = 16
_SHARP = 20.0
"""Square of the standard deviations by which a tip must be sharp."""
_TURNS = 20


class MeanProfile(NamedTuple):
    """Means over rings about an apex."""

    centre: tuple[float, float]
    """x and y in m."""
    radius: FloatArray
    """In m, from 0."""
    height: FloatArray
    """f in m, from 0 at the apex."""
    scatter: FloatArray
    """Standard deviation in m of heights about the mean at each radius."""
    below_summit: float
    """How far in m its apex lies below the highest height within its last radius."""
    curvatures: tuple[float, float]
    """Principal curvatures of the cap in 1/m, above 0 for a summit, the larger first."""


def mean_profile(
    heights: FloatArray, spacing: FloatArray, centre: tuple[float, float] | None, reach: float | None
) -> MeanProfile:
    """
    The azimuthal mean about the apex of a surface that is one bump.

    Parameters
    ----------
    heights : ndarray
        In m, (nx, ny), none of them missing.
    spacing : ndarray
        Pixels in m.
    centre : tuple of float or None
        x and y in m about which it is taken; the vertex of the paraboloid through the cap unless given.
    reach : float or None
        Radius in m up to which it is taken; the distance from the apex to the nearest edge unless given.

    Returns
    -------
    MeanProfile

    Raises
    ------
    ProblemError
        If the surface is not one bump; the message says why.
    """
    from scipy.ndimage import gaussian_filter

    smooth = gaussian_filter(heights, 1.0, mode="nearest")
    size = spacing * heights.shape
    axes = [(np.arange(n) + 0.5) * step for n, step in zip(heights.shape, spacing, strict=True)]
    top = np.unravel_index(int(np.argmax(smooth)), heights.shape)
    start = (float(axes[0][top[0]]), float(axes[1][top[1]]))
    middle, bends = _vertex(
        heights, axes, start if centre is None else centre, size, reach, moves=centre is None
    )
    room = _room(middle, size)
    last = room if reach is None else reach
    if last > room * (1.0 + 1e-9):
        raise ProblemError(
            f"the edge of the patch is {metres(room)} from the centre, nearer than reach = {metres(last)}; take a smaller reach"
        )
    wide = float(spacing.max())
    if last < FEWEST_RINGS * wide:
        raise ProblemError(
            f"not one bump: its apex at {_place(middle)} is {metres(last)} from the edge of the patch, less than {FEWEST_RINGS} pixels; "
            "measure it with its flanks around"
        )
    r = np.hypot(axes[0][:, None] - middle[0], axes[1] - middle[1])
    inside = r <= last
    profile = _rings(heights[inside], r[inside], wide, middle, bends)
    noise = float(np.median(np.abs(heights - smooth))) / 0.6745
    _refuse_flat(profile, noise)
    _refuse_second(smooth, noise, r, axes, profile)
    return profile


def _room(middle: tuple[float, float], size: FloatArray) -> float:
    return float(min(middle[0], middle[1], size[0] - middle[0], size[1] - middle[1]))


def _place(middle: tuple[float, float]) -> str:
    return f"({metres(middle[0])}, {metres(middle[1])})"


def _vertex(
    heights: FloatArray,
    axes: list[FloatArray],
    middle: tuple[float, float],
    size: FloatArray,
    reach: float | None,
    moves: bool,
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Where the paraboloid through the heights around it has its vertex, and its principal curvatures."""
    step = max(float(axis[1] - axis[0]) for axis in axes)
    bends = (0.0, 0.0)
    for _ in range(_TURNS if moves else 1):
        room = _room(middle, size)
        if not room > 0.0:
            break
        width = max(_CAP * (room if reach is None else min(room, reach)), 2.5 * step)
        x, y = (axis - at for axis, at in zip(axes, middle, strict=True))
        part = np.ix_(np.abs(x) <= width, np.abs(y) <= width)
        u, v = np.broadcast_arrays(x[part[0]] / width, y[part[1]] / width)
        near = np.hypot(u, v) <= 1.0
        if np.count_nonzero(near) < _FEWEST_OF_APEX:
            break
        u, v, z = u[near], v[near], heights[part][near]
        columns = np.array([np.ones(u.size), u, v, 0.5 * u * u, u * v, 0.5 * v * v]).T
        found = np.linalg.lstsq(columns, z - z.mean(), rcond=None)[0]
        matrix = -np.array([[found[3], found[4]], [found[4], found[5]]])
        low, high = np.linalg.eigvalsh(matrix)
        bends = (float(high) / width**2, float(low) / width**2)
        if not moves:
            break
        if not low > 0.0:
            raise ProblemError(
                f"not one bump: about its highest place, {_place(middle)}, the surface does not fall to all sides (curvatures "
                f"{bends[0]:.3g} and {bends[1]:.3g} 1/m); give the centre yourself if it is known"
            )
        move = np.linalg.solve(matrix, found[1:3])
        move *= width * min(1.0, 0.5 / float(np.linalg.norm(move) or 1.0))
        middle = (
            float(np.clip(middle[0] + move[0], 0.0, size[0])),
            float(np.clip(middle[1] + move[1], 0.0, size[1])),
        )
        if float(np.linalg.norm(move)) < 1e-3 * step:
            break
    return middle, bends


def _rings(
    heights: FloatArray, r: FloatArray, wide: float, middle: tuple[float, float], bends: tuple[float, float]
) -> MeanProfile:
    """Means over rings as wide as a pixel; at r = 0 the curve through the innermost heights."""
    ring = np.floor(r / wide).astype(int)
    count = np.bincount(ring)
    # the last ring may hold corners of pixels only
    ring_kept = np.flatnonzero(count >= 3)
    # a parabola has its mean at the root mean square of the radius
    radius = np.sqrt((np.bincount(ring, r**2) / np.maximum(count, 1))[ring_kept])
    mean = (np.bincount(ring, heights) / np.maximum(count, 1))[ring_kept]
    few = r <= 3.0 * wide
    tip = _tip(r[few] / wide, heights[few])
    radius, mean = np.append(0.0, radius), np.append(tip, mean)
    # the slope within a ring is no scatter
    beyond = mean[-1] + (mean[-1] - mean[-2]) / (radius[-1] - radius[-2]) * wide
    off = heights - np.interp(r, np.append(radius, radius[-1] + wide), np.append(mean, beyond))
    square = (np.bincount(ring, off**2) / np.maximum(count - 1, 1))[ring_kept]
    scatter = np.sqrt(np.append(float(np.mean(off[few] ** 2)), square))
    below = float(heights.max()) - tip
    return MeanProfile(middle, radius, tip - mean, scatter, below, bends)


def _tip(r: FloatArray, heights: FloatArray) -> float:
    """The height at r = 0: of a parabola, and of one with a sharp tip where chance does not make it."""
    middle = float(heights.mean())
    found = []
    for columns in ([r**0, r**2], [r**0, r, r**2]):
        fitted, off = np.linalg.lstsq(np.array(columns).T, heights - middle, rcond=None)[:2]
        found.append((middle + float(fitted[0]), float(off.sum())))
    (round_tip, round_off), (sharp_tip, sharp_off) = found
    return sharp_tip if round_off > sharp_off * (1.0 + _SHARP / (r.size - 3)) else round_tip


def _refuse_flat(profile: MeanProfile, noise: float) -> None:
    tall = float(profile.height[-1])
    wide = math.sqrt(max(float(np.mean(profile.scatter**2)) - noise**2, 0.0))
    if not tall > 0.0:
        raise ProblemError(
            f"not one bump: at {metres(float(profile.radius[-1]))} from its apex at {_place(profile.centre)} the surface is on the average "
            f"{metres(-tall)} higher than there"
        )
    if wide > ROUNDNESS * tall:
        raise ProblemError(
            f"not one bump: heights at one radius differ by {metres(wide)} (root mean square, besides noise), and the mean falls by {metres(tall)} from the "
            f"apex at {_place(profile.centre)} to {metres(float(profile.radius[-1]))}: they may not by more than {100 * ROUNDNESS:g} % of that; "
            "a rough plane is for power_spectrum, an oblong bump is pressed as it is"
        )


def _refuse_second(
    smooth: FloatArray, noise: float, r: FloatArray, axes: list[FloatArray], profile: MeanProfile
) -> None:
    """Refuse a second summit that stands out of what lies around it, and anything outside that is as high as the bump is in its reach."""
    from scipy.ndimage import label

    tall = float(profile.height[-1])
    least = max(SECOND * tall, _NOISES * noise)
    top = float(smooth[r <= 2.0 * profile.radius[1]].max())
    foot = top - tall
    for level in np.linspace(top, foot, _LEVELS + 1)[1:]:
        parts, count = label(smooth > level)
        if count < 2:
            continue
        own = set(np.unique(parts[(r <= 3.0 * profile.radius[1]) & (parts > 0)]).tolist())
        highest = np.full(count + 1, -math.inf)
        np.maximum.at(highest, parts.ravel(), smooth.ravel())
        highest[[0, *own]] = -math.inf
        other = int(np.argmax(highest))
        if highest[other] - level > least:
            at = np.unravel_index(int(np.argmax(np.where(parts == other, smooth, -np.inf))), smooth.shape)
            raise ProblemError(
                f"not one bump: the highest place near {_place(profile.centre)} is not the only summit, another at "
                f"{_place((float(axes[0][at[0]]), float(axes[1][at[1]])))} stands {metres(float(highest[other]) - float(level))} out of what is "
                "around it; cut the patch down to one of them, or press the surface as it is"
            )
