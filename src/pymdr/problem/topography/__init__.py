"""Measured and computed surfaces as heights on a grid, and their preparation."""

from __future__ import annotations

from pymdr.errors import ProblemError
from pymdr.problem.topography import preparing, resolution
from pymdr.problem.topography.heights import Heights, HeightsField
from pymdr.units import shown

__all__ = ["HeightsField", "Topography", "as_topography"]


class Topography(Heights):
    """
    The heights of a surface on a rectangular grid of pixels.

    Parameters
    ----------
    heights : array_like of quantity
        Heights in m, (nx, ny), positive out of the body, so that summits touch first; nan where not measured.
    size : quantity or pair of quantities
        Sides of the patch along x and y in m; one length for a square.
    steps : tuple of str, optional
        Origin of the heights and the steps of their preparation.

    Raises
    ------
    ProblemError
        If the heights are not a matrix of at least 2 x 2, are all missing, or a side is not above 0.
    UnitError
        If a value is not a length, or a height is infinite.

    Examples
    --------
    >>> import pymdr as mdr
    >>> surface = mdr.Topography([[0.0, 1e-9], [2e-9, 3e-9]], "2 um")
    >>> surface.spacing.tolist()
    [1e-06, 1e-06]
    """

    detrend = preparing.detrend
    fill_missing = preparing.fill_missing
    tip_cutoff = resolution.tip_cutoff


def as_topography(topography: object) -> Topography:
    """
    Check that a value is a topography.

    Raises
    ------
    ProblemError
        If it is not.
    """
    if not isinstance(topography, Topography):
        raise ProblemError(f"{shown(topography)} is not a Topography; write Topography(heights, size)")
    return topography
