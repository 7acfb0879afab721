"""The figure of a pressed surface: contact, pressures, force against depth, stiffness against force."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.units import FloatArray, from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.colors import Colormap
    from matplotlib.image import AxesImage


_LINE = 80
"""Characters per line of a text in place of a figure."""


def pressed_surface(
    data: xr.Dataset, heights: FloatArray, pressure: xr.DataArray | None, title: str
) -> draw.Figure:
    """
    Contact and pressures at one load, and the curves over all loads.

    Parameters
    ----------
    data : xarray.Dataset
        ``indentation`` (m), ``normal_force`` (N) and ``normal_stiffness`` (N/m) of the loads.
    heights : ndarray
        In m, (nx, ny).
    pressure : xarray.DataArray or None
        In Pa over ``x`` and ``y`` in m; None if not valid at any load.
    title : str
        The drawn load, or why none is drawn.
    """
    with draw.new_figure(9.6, 7.6) as figure:
        (first, second), (third, fourth) = figure.subplots(2, 2)
        if pressure is None:
            for axes in (first, second, third, fourth):
                axes.set_axis_off()
            figure.text(0.5, 0.5, textwrap.fill(title, _LINE), ha="center", va="center")
            return figure
        _draw_contact(first, heights, pressure)
        unit = good_unit(pressure.values, "Pa")
        image = _map(second, np.asarray(from_si(pressure.values, "Pa", unit)), pressure, "viridis")
        for axes in (first, second):
            axes.set_title(title)
        figure.colorbar(image, ax=second, label=draw.axis_label("pressure", unit))
        _draw_curve(third, data, "indentation", "normal_force")
        _draw_curve(fourth, data, "normal_force", "normal_stiffness")
    return figure


def _map(axes: draw.Axes, values: FloatArray, pressure: xr.DataArray, colours: str | Colormap) -> AxesImage:
    unit = good_unit(pressure["x"].values, "m")
    ends = []
    for axis in ("x", "y"):
        at = draw.lengths(pressure[axis].values, unit)
        half = 0.5 * (at[1] - at[0])
        ends += [float(at[0] - half), float(at[-1] + half)]
    image = axes.imshow(
        values.T,
        origin="lower",
        extent=(ends[0], ends[1], ends[2], ends[3]),
        cmap=colours,
        interpolation="none",
    )
    axes.set(xlabel=f"$x$ ({unit})", ylabel=f"$y$ ({unit})")
    return image


def _draw_contact(axes: draw.Axes, heights: FloatArray, pressure: xr.DataArray) -> None:
    """Heights over the mean in grey, and what touches."""
    from matplotlib.colors import ListedColormap

    above = heights - np.nanmean(heights)
    unit = good_unit(above, "m")
    image = _map(axes, draw.lengths(above, unit), pressure, "Greys_r")
    axes.figure.colorbar(image, ax=axes, label=f"height over the mean ({unit})")
    _map(axes, np.where(pressure.values > 0.0, 1.0, np.nan), pressure, ListedColormap([draw.ORANGE]))


def _draw_curve(axes: draw.Axes, data: xr.Dataset, along: str, up: str) -> None:
    units = {"indentation": "m", "normal_force": "N", "normal_stiffness": "N/m"}
    order = np.argsort(data[along].values)
    x, y = (data[name].values[order] for name in (along, up))
    x_unit, y_unit = good_unit(x, units[along]), good_unit(y, units[up])
    axes.plot(draw.scaled(x, along, x_unit), draw.scaled(y, up, y_unit), "o-", color=draw.BLUE, ms=4, lw=1.3)
    axes.set(xlabel=draw.axis_label(along, x_unit), ylabel=draw.axis_label(up, y_unit))
    axes.set_xlim(left=0.0)
    draw.begin_at_zero(axes)
