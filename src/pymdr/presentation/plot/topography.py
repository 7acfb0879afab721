"""Figures of measured surfaces: heights, spectrum, and mean profile about an apex."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.units import FloatArray, good_unit

if TYPE_CHECKING:
    import xarray as xr

_PIXELS = 1024
"""Largest number of pixels drawn along a side."""


def spectrum_study(heights: FloatArray, size: FloatArray, data: xr.Dataset, rings: xr.Dataset) -> draw.Figure:
    """
    A surface, and its spectrum with the fitted law.

    Parameters
    ----------
    heights : ndarray
        In m, (nx, ny).
    size : ndarray
        Sides in m.
    data : xarray.Dataset
        ``power_spectrum`` with ``_low`` and ``_high`` and ``law`` (m^4) over ``wave_number`` (1/m), nan where not known.
    rings : xarray.Dataset
        ``power_spectrum`` of all rings.
    """
    with draw.new_figure(9.6, 4.0) as figure:
        first, second = figure.subplots(1, 2, width_ratios=(1.0, 1.2))
        draw_heights(first, heights, size)
        q, law = data["wave_number"].values, data["law"].values
        x, y = rings["wave_number"].values, rings["power_spectrum"].values
        second.loglog(x, y, ".", color=draw.LIGHT, ms=3, label="rings")
        band = [data[f"power_spectrum_{end}"].values for end in ("low", "high")]
        second.fill_between(q, *band, color=draw.BLUE, alpha=0.2, lw=0)
        second.plot(
            q, data["power_spectrum"].values, "o", color=draw.BLUE, ms=4, label="resolved, 16 to 84 %"
        )
        if np.isfinite(law).any():
            second.plot(q, law, color=draw.ORANGE, lw=1.6, label="self-affine law on its range")
        second.axvline(2.0 * math.pi / data.attrs["shortest_resolved"], color=draw.GREY, lw=0.8, ls=":")
        second.set(xlabel="wave number $q$ (1/m)", ylabel=r"spectrum $C_\mathrm{2D}$ (m$^4$)")
        draw.legend_above(second)
    return figure


def draw_heights(axes: draw.Axes, heights: FloatArray, size: FloatArray) -> None:
    """Heights as colours; missing heights are white."""
    every = [-(-n // _PIXELS) for n in heights.shape]
    drawn = heights[:: every[0], :: every[1]]
    across, up = good_unit(size, "m"), good_unit(np.abs(drawn - np.nanmean(drawn)).ravel(), "m")
    width, length = draw.lengths(size, across).tolist()
    image = axes.imshow(
        draw.lengths(drawn - np.nanmean(drawn), up).T,
        origin="lower",
        extent=(0.0, width, 0.0, length),
        cmap="viridis",
    )
    axes.figure.colorbar(image, ax=axes, label=f"height over the mean ({up})", shrink=0.8)
    axes.set(xlabel=f"$x$ ({across})", ylabel=f"$y$ ({across})")


def bump_study(
    heights: FloatArray,
    size: FloatArray,
    centre: tuple[float, float],
    profile: tuple[FloatArray, FloatArray, FloatArray],
    curve: tuple[FloatArray, FloatArray],
) -> draw.Figure:
    """
    A surface with its apex, and the mean profile about it.

    Parameters
    ----------
    heights : ndarray
        In m, (nx, ny).
    size : ndarray
        Sides in m.
    centre : tuple of float
        x and y in m.
    profile : tuple of ndarray
        Radii, means and standard deviations in m.
    curve : tuple of ndarray
        Radii and gap in m of the fitted curve.
    """
    from matplotlib.patches import Circle

    r, f, scatter = profile
    with draw.new_figure(9.6, 4.0) as figure:
        first, second = figure.subplots(1, 2, width_ratios=(1.0, 1.2))
        draw_heights(first, heights, size)
        unit = good_unit(size, "m")
        x, y, radius = (float(draw.lengths(np.array(value), unit)) for value in (*centre, r[-1]))
        first.plot([x], [y], "+", color=draw.ORANGE, ms=8)
        first.add_patch(Circle((x, y), radius, fill=False, color=draw.ORANGE, lw=1.0))
        along, up = good_unit(r, "m"), good_unit(f, "m")
        at, mean, wide = draw.lengths(r, along), draw.lengths(f, up), draw.lengths(scatter, up)
        second.fill_between(
            at, mean - wide, mean + wide, color=draw.BLUE, alpha=0.2, lw=0, label="scatter around"
        )
        second.plot(at, mean, ".", color=draw.BLUE, ms=4, label="azimuthal mean")
        at, fitted = draw.lengths(curve[0], along), draw.lengths(curve[1], up)
        second.plot(at, fitted, color=draw.ORANGE, lw=1.2, label="curve")
        second.invert_yaxis()
        second.set(xlabel=f"radius $r$ ({along})", ylabel=f"gap $f$ ({up})")
        draw.legend_above(second)
    return figure
