"""The shortest waves that a measurement can have resolved: those of its pixels, and those of its tip."""

from __future__ import annotations

from pymdr.errors import ProblemError
from pymdr.problem.topography.heights import Heights
from pymdr.units import FloatArray, QuantityLike, metres, shown, to_si

_SAFETY = 0.5
"""Share of the curvature of the tip from which on it blunts what it sees."""


def tip_cutoff(topography: Heights, tip_radius: QuantityLike) -> float:
    """
    The shortest wavelength that a tip of a radius can have resolved, from the curvatures of what it measured.

    A tip of radius R sees no summit that is sharper than 1/R. With curvatures over a stencil of length lambda,
    h'' = [h(x + lambda/2) - 2 h(x) + h(x - lambda/2)] / (lambda/2)^2, it is the shortest lambda at which the sharpest summit,
    along x or along y, has h'' > -1/(2 R).

    Parameters
    ----------
    topography : Topography
        As measured, without missing heights; trends of first order do not matter.
    tip_radius : quantity
        R in m, above 0.

    Returns
    -------
    float
        In m. Two pixels where the tip was sharp enough for all that the pixels show.

    Raises
    ------
    ProblemError
        If heights are missing, the radius is not above 0, or no wave within the patch is free of the tip.

    Notes
    -----
    Sanner, Noehring, Thimons, Jacobs and Pastewka (2022), Appl. Surf. Sci. Adv. 7, 100190, who take the factor 1/2 from simulated
    scans. Lengths are whole numbers of pixels, the upper one.

    Examples
    --------
    >>> import numpy as np
    >>> from pymdr import Topography
    >>> x = np.arange(256.0)
    >>> wave = Topography(np.cos(0.1 * np.pi * x)[:, None] + np.zeros(256), 256.0)
    >>> wave.tip_cutoff(1.0), wave.tip_cutoff(10.0)
    (2.0, 18.0)
    """
    heights = topography.whole("tip_cutoff")
    radius = to_si(tip_radius, "m", name="tip_radius")
    if not radius > 0.0:
        raise ProblemError(f"tip_cutoff: tip_radius = {shown(tip_radius)}; it must be above 0 m")
    return max(
        _cutoff(heights if axis == 0 else heights.T, float(step), radius)
        for axis, step in enumerate(topography.spacing)
    )


def _cutoff(heights: FloatArray, step: float, radius: float) -> float:
    """The length of the shortest stencil along the first axis that is free of the tip."""

    def free(k: int) -> bool:
        bend = heights[2 * k :] - 2.0 * heights[k:-k] + heights[: -2 * k]
        return float(bend.min()) > -_SAFETY * (k * step) ** 2 / radius

    most = (heights.shape[0] - 1) // 2
    low, high = 0, 1
    while not free(high):
        if high == most:
            raise ProblemError(
                f"tip_cutoff: a tip of radius {metres(radius)} can have resolved nothing of this surface, whose summits are sharper "
                f"even over {metres(2 * most * step)}; is the radius right, and are heights and sides in the same unit?"
            )
        low, high = high, min(2 * high, most)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if free(middle) else (middle, high)
    return 2.0 * high * step
