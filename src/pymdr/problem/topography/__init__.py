"""Measured and computed surfaces as heights on a grid, and what is done to them before they are used."""

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
        Heights in m, (nx, ny), that grow out of the body: its summits touch first. nan where nothing was measured.
    size : quantity or pair of quantities
        Sides along x and y in m of the whole patch, nx and ny pixels; one length for a square.
    steps : tuple of str, optional
        Where the heights come from and what was done to them, in words, one after the other.

    Raises
    ------
    ProblemError
        If the heights are no matrix of at least 2 x 2, all missing, or a side is not above 0.
    UnitError
        If something is no length, or a height is infinite.

    Examples
    --------
    >>> surface = Topography([[0.0, 1e-9], [2e-9, 3e-9]], "2 um")
    >>> surface.spacing.tolist()
    [1e-06, 1e-06]
    """

    detrend = preparing.detrend
    fill_missing = preparing.fill_missing
    tip_cutoff = resolution.tip_cutoff


def as_topography(topography: object, who: str) -> Topography:
    """
    A topography as it is.

    Raises
    ------
    ProblemError
        If it is none.
    """
    if not isinstance(topography, Topography):
        raise ProblemError(f"{who}: {shown(topography)} is no surface; write Topography(heights, size)")
    return topography
