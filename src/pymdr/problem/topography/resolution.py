"""The shortest wavelength resolved by pixels and tip of a measurement."""

from __future__ import annotations

from pymdr.errors import ProblemError
from pymdr.problem.topography.heights import Heights
from pymdr.units import FloatArray, QuantityLike, metres, shown, to_si

_SAFETY = 0.5
"""Fraction of the curvature of the tip above which summits are blunted."""


def tip_cutoff(topography: Heights, tip_radius: QuantityLike) -> float:
    """
    The shortest wavelength that a tip can have resolved, from the curvatures of the measured heights.

    A tip of radius R measures no summit sharper than 1/R. With curvatures over a stencil of length lambda,
    h'' = [h(x + lambda/2) - 2 h(x) + h(x - lambda/2)] / (lambda/2)^2, the result is the shortest lambda at which the sharpest
    summit along x or y has h'' > -1/(2 R).

    Parameters
    ----------
    topography : Topography
        As measured, without missing heights; linear trends have no effect.
    tip_radius : quantity
        R in m, above 0.

    Returns
    -------
    float
        In m; two pixels if the tip resolves every pixel.

    Raises
    ------
    ProblemError
        If heights are missing, the radius is not above 0, or the tip resolves no wave within the patch.

    Notes
    -----
    Sanner, Noehring, Thimons, Jacobs and Pastewka (2022), Appl. Surf. Sci. Adv. 7, 100190, with the factor 1/2 from simulated
    scans. Lengths are rounded up to whole pixels.

    Examples
    --------
    >>> import pymdr as mdr
    >>> import numpy as np
    >>> x = np.arange(256.0)
    >>> wave = mdr.Topography(np.cos(0.1 * np.pi * x)[:, None] + np.zeros(256), 256.0)
    >>> wave.tip_cutoff(1.0), wave.tip_cutoff(10.0)
    (2.0, 18.0)
    """
    heights = topography.complete()
    radius = to_si(tip_radius, "m", name="tip_radius")
    if not radius > 0.0:
        raise ProblemError(f"tip_radius = {shown(tip_radius)}; it must be above 0 m")
    return max(
        _cutoff(heights if axis == 0 else heights.T, float(step), radius)
        for axis, step in enumerate(topography.spacing)
    )


def _cutoff(heights: FloatArray, step: float, radius: float) -> float:
    """Length in m of the shortest stencil along the first axis that the tip resolves."""

    def resolved(k: int) -> bool:
        curvature = heights[2 * k :] - 2.0 * heights[k:-k] + heights[: -2 * k]
        return float(curvature.min()) > -_SAFETY * (k * step) ** 2 / radius

    most = (heights.shape[0] - 1) // 2
    low, high = 0, 1
    while not resolved(high):
        if high == most:
            raise ProblemError(
                f"a tip of radius {metres(radius)} resolves no wave of this surface up to {metres(2 * most * step)}; "
                "check the radius and the units of heights and sides"
            )
        low, high = high, min(2 * high, most)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if resolved(middle) else (middle, high)
    return 2.0 * high * step
