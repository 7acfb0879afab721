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
"""Least prominence of a second summit, over the height of the bump."""
_SIGNIFICANCE = 6.0
"""Least prominence of a second summit, over the noise of smoothed heights."""
ROUNDNESS = 0.15
"""Largest scatter of heights at one radius without noise (root mean square), over the height of the bump: radii of 1 to 2.5."""
_CAP = 0.5
"""Radius of the search for the apex, over `max_radius`."""
_FEWEST_OF_APEX = 16
_SHARP = 20.0
"""Square of the significance of a sharp tip."""
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
    """Distance in m of its apex below the highest height within the last radius."""
    curvatures: tuple[float, float]
    """Principal curvatures of the cap in 1/m, above 0 for a summit, the larger first."""


def mean_profile(
    heights: FloatArray, spacing: FloatArray, centre: tuple[float, float] | None, max_radius: float | None
) -> MeanProfile:
    """
    The azimuthal mean about the apex of a surface that is one bump.

    Parameters
    ----------
    heights : ndarray
        In m, (nx, ny), without missing values.
    spacing : ndarray
        Pixels in m.
    centre : tuple of float or None
        x and y in m of the apex; default the vertex of the paraboloid through the cap.
    max_radius : float or None
        Largest radius in m; default the distance from the apex to the nearest edge.

    Raises
    ------
    ProblemError
        If the surface is not one bump, with the reason.
    """
    from scipy.ndimage import gaussian_filter

    smooth = gaussian_filter(heights, 1.0, mode="nearest")
    size = spacing * heights.shape
    axes = [(np.arange(n) + 0.5) * step for n, step in zip(heights.shape, spacing, strict=True)]
    top = np.unravel_index(int(np.argmax(smooth)), heights.shape)
    start = (float(axes[0][top[0]]), float(axes[1][top[1]]))
    middle, principal = _vertex(
        heights, axes, start if centre is None else centre, size, max_radius, moves=centre is None
    )
    border_distance = _border_distance(middle, size)
    last = border_distance if max_radius is None else max_radius
    if last > border_distance * (1.0 + 1e-9):
        raise ProblemError(
            f"max_radius = {metres(last)} is above the distance {metres(border_distance)} of the centre from the edge of the patch; use a smaller max_radius"
        )
    wide = float(spacing.max())
    if last < FEWEST_RINGS * wide:
        raise ProblemError(
            f"not one bump: its apex at {_place(middle)} is {metres(last)} from the edge of the patch (at least {FEWEST_RINGS} pixels are "
            "needed); measure the whole bump"
        )
    r = np.hypot(axes[0][:, None] - middle[0], axes[1] - middle[1])
    inside = r <= last
    profile = _rings(heights[inside], r[inside], wide, middle, principal)
    noise = float(np.median(np.abs(heights - smooth))) / 0.6745
    _refuse_flat(profile, noise)
    _refuse_second(smooth, noise, r, axes, profile)
    return profile


def _border_distance(middle: tuple[float, float], size: FloatArray) -> float:
    return float(min(middle[0], middle[1], size[0] - middle[0], size[1] - middle[1]))


def _place(middle: tuple[float, float]) -> str:
    return f"({metres(middle[0])}, {metres(middle[1])})"


def _vertex(
    heights: FloatArray,
    axes: list[FloatArray],
    middle: tuple[float, float],
    size: FloatArray,
    max_radius: float | None,
    moves: bool,
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Vertex of the paraboloid through the heights around it, and its principal curvatures."""
    step = max(float(axis[1] - axis[0]) for axis in axes)
    principal = (0.0, 0.0)
    for _ in range(_TURNS if moves else 1):
        border_distance = _border_distance(middle, size)
        if not border_distance > 0.0:
            break
        width = max(
            _CAP * (border_distance if max_radius is None else min(border_distance, max_radius)), 2.5 * step
        )
        x, y = (axis - at for axis, at in zip(axes, middle, strict=True))
        part = np.ix_(np.abs(x) <= width, np.abs(y) <= width)
        u, v = np.broadcast_arrays(x[part[0]] / width, y[part[1]] / width)
        near = np.hypot(u, v) <= 1.0
        if np.count_nonzero(near) < _FEWEST_OF_APEX:
            break
        u, v, z = u[near], v[near], heights[part][near]
        columns = np.array([np.ones(u.size), u, v, 0.5 * u * u, u * v, 0.5 * v * v]).T
        fitted = np.linalg.lstsq(columns, z - z.mean(), rcond=None)[0]
        matrix = -np.array([[fitted[3], fitted[4]], [fitted[4], fitted[5]]])
        low, high = np.linalg.eigvalsh(matrix)
        principal = (float(high) / width**2, float(low) / width**2)
        if not moves:
            break
        if not low > 0.0:
            raise ProblemError(
                f"not one bump: the surface does not decrease in all directions about its highest place, {_place(middle)} (curvatures "
                f"{principal[0]:.3g} and {principal[1]:.3g} 1/m); give the centre if it is known"
            )
        move = np.linalg.solve(matrix, fitted[1:3])
        move *= width * min(1.0, 0.5 / float(np.linalg.norm(move) or 1.0))
        middle = (
            float(np.clip(middle[0] + move[0], 0.0, size[0])),
            float(np.clip(middle[1] + move[1], 0.0, size[1])),
        )
        if float(np.linalg.norm(move)) < 1e-3 * step:
            break
    return middle, principal


def _rings(
    heights: FloatArray,
    r: FloatArray,
    wide: float,
    middle: tuple[float, float],
    principal: tuple[float, float],
) -> MeanProfile:
    """Means over rings one pixel wide; at r = 0 a fit to the innermost heights."""
    ring = np.floor(r / wide).astype(int)
    count = np.bincount(ring)
    # the last ring may contain only corners
    ring_kept = np.flatnonzero(count >= 3)
    # a parabola has its mean at the root mean square of the radius
    radius = np.sqrt((np.bincount(ring, r**2) / np.maximum(count, 1))[ring_kept])
    mean = (np.bincount(ring, heights) / np.maximum(count, 1))[ring_kept]
    few = r <= 3.0 * wide
    tip = _tip(r[few] / wide, heights[few])
    radius, mean = np.append(0.0, radius), np.append(tip, mean)
    # the slope within a ring is not scatter
    beyond = mean[-1] + (mean[-1] - mean[-2]) / (radius[-1] - radius[-2]) * wide
    off = heights - np.interp(r, np.append(radius, radius[-1] + wide), np.append(mean, beyond))
    square = (np.bincount(ring, off**2) / np.maximum(count - 1, 1))[ring_kept]
    scatter = np.sqrt(np.append(float(np.mean(off[few] ** 2)), square))
    below = float(heights.max()) - tip
    return MeanProfile(middle, radius, tip - mean, scatter, below, principal)


def _tip(r: FloatArray, heights: FloatArray) -> float:
    """The height at r = 0 of a parabola, with a sharp tip where that is significant."""
    middle = float(heights.mean())
    fits = []
    for columns in ([r**0, r**2], [r**0, r, r**2]):
        fitted, off = np.linalg.lstsq(np.array(columns).T, heights - middle, rcond=None)[:2]
        fits.append((middle + float(fitted[0]), float(off.sum())))
    (round_tip, round_off), (sharp_tip, sharp_off) = fits
    return sharp_tip if round_off > sharp_off * (1.0 + _SHARP / (r.size - 3)) else round_tip


def _refuse_flat(profile: MeanProfile, noise: float) -> None:
    tall = float(profile.height[-1])
    wide = math.sqrt(max(float(np.mean(profile.scatter**2)) - noise**2, 0.0))
    if not tall > 0.0:
        raise ProblemError(
            f"not one bump: at {metres(float(profile.radius[-1]))} from its apex at {_place(profile.centre)} the surface is on average "
            f"{metres(-tall)} higher than the apex; check the sign of the heights (positive out of the body), or give the centre"
        )
    if wide > ROUNDNESS * tall:
        raise ProblemError(
            f"not one bump: heights at one radius scatter by {metres(wide)} (root mean square, without noise; limit {100 * ROUNDNESS:g} % of the "
            f"height {metres(tall)} from the apex at {_place(profile.centre)} to {metres(float(profile.radius[-1]))}); use power_spectrum for a rough "
            "plane, or press(...) for an oblong bump"
        )


def _refuse_second(
    smooth: FloatArray, noise: float, r: FloatArray, axes: list[FloatArray], profile: MeanProfile
) -> None:
    """Refuse a second prominent summit."""
    from scipy.ndimage import label

    tall = float(profile.height[-1])
    least = max(SECOND * tall, _SIGNIFICANCE * noise)
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
                f"not one bump: besides the summit near {_place(profile.centre)} there is another at "
                f"{_place((float(axes[0][at[0]]), float(axes[1][at[1]])))} with a prominence of {metres(float(highest[other]) - float(level))}; "
                "crop the patch to one of them, or use press(...) for the complete surface"
            )
