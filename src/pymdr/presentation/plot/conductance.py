"""Figures of what flows through a contact."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot.shared import (
    BLUE,
    GREY,
    MARKED_ROWS,
    ORANGE,
    FigureData,
    as_seen,
    axis_label,
    column,
    legend_above,
    lengths,
    letter_panels,
    limit_peaks,
    new_figure,
    scaled,
    styled,
    typeset,
    without_peaks,
)
from pymdr.quantities import QUANTITIES, RADIUS
from pymdr.units import from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def conduction_figure(
    data: FigureData, levels: Mapping[str, str], fluxes: Mapping[str, xr.DataArray]
) -> Figure:
    """
    Conductance and resistance against load, and the flux over the radius.

    Parameters
    ----------
    data : FigureData
    levels : mapping of str to str
        What is claimed of every quantity that is drawn, one or more.
    fluxes : mapping of str to xarray.DataArray
        Fields of the drawn row for a unit of the drop between the bodies.

    Returns
    -------
    matplotlib.figure.Figure
    """
    with styled():
        across = len(levels) + bool(fluxes)
        figure = new_figure(4.2 * across, 3.6)
        panels = np.ravel(np.asarray(figure.subplots(1, across)))
        for axes, (name, level) in zip(panels, levels.items(), strict=False):
            _draw_against_load(axes, data, name, level)
        if fluxes:
            _draw_fluxes(panels[-1], fluxes)
        letter_panels(figure)
    return figure


def _draw_against_load(axes: Axes, data: FigureData, name: str, level: str) -> None:
    along = "normal_force" if "normal_force" in data.data else "indentation"
    load, load_unit = column(data, along)
    values, unit = column(data, name)
    values = np.where(np.isfinite(values), values, math.nan)
    few = "o" if values.size <= MARKED_ROWS else None
    axes.plot(*as_seen(load, values), color=BLUE, lw=1.5, marker=few, ms=2.5, label=level)
    if name in data.bands:
        low, high = (scaled(end, name, unit) for end in data.bands[name])
        axes.fill_between(load, low, high, color=BLUE, alpha=0.15, lw=0, label="band of the scatter")
    if data.row >= 0:
        axes.plot(load[data.row], values[data.row], "o", color=BLUE, ms=5)
    known = values[np.isfinite(values)]
    if known.size and known.min() > 0.0 and known.max() > 30.0 * known.min():
        axes.set_yscale("log")
    else:
        axes.set_ylim(bottom=0.0)
    axes.set_xlabel(axis_label(along, load_unit))
    axes.set_ylabel(axis_label(name, unit))
    legend_above(axes)


def _draw_fluxes(axes: Axes, fluxes: Mapping[str, xr.DataArray]) -> None:
    """Fluxes over the radius, each with its own scale."""
    for i, (name, flux) in enumerate(fluxes.items()):
        one, colour = (axes, ORANGE) if i == 0 else (axes.twinx(), GREY)
        r, unit = flux["r"].values, QUANTITIES[name].unit
        r_unit = good_unit(r, "m")
        shown = np.where(np.isfinite(flux.values), flux.values, math.nan)
        one.plot(lengths(r, r_unit), shown, color=colour, lw=1.5, ls="-" if i == 0 else "--")
        limit_peaks(one, without_peaks(flux.values))
        edge = float(from_si(float(np.max(r[np.isinf(flux.values)], initial=0.0)), "m", r_unit))
        one.set_ylabel(axis_label(name, unit), color=colour)
        if i == 0:
            axes.axvline(edge, color=GREY, lw=0.9, ls=":")
            axes.set_xlabel(f"{RADIUS.label} ({r_unit})")
            size = typeset(float(flux["edge_amplitude"]))
            words = f"$j \\simeq K/\\sqrt{{a-r}}$ at $r = a$\n$K$ = {size} in SI units"
            axes.text(0.97, 0.95, words, ha="right", va="top", transform=axes.transAxes, fontsize=8)
