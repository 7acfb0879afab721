"""Figures of the conduction of heat and current through a contact."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import QUANTITIES, RADIUS
from pymdr.units import FloatArray, from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr


def conduction_figure(
    data: draw.FigureData, levels: Mapping[str, str], fluxes: Mapping[str, xr.DataArray]
) -> draw.Figure:
    """
    Conductance and resistance against load, and the flux over the radius.

    Parameters
    ----------
    levels : mapping of str to str
        Level of the claim of every drawn quantity.
    fluxes : mapping of str to xarray.DataArray
        Fields of the drawn row for unit drop between the bodies.
    """
    across = len(levels) + bool(fluxes)
    with draw.new_figure(4.2 * across, 3.6) as figure:
        panels = np.ravel(np.asarray(figure.subplots(1, across)))
        for axes, (name, level) in zip(panels, levels.items(), strict=False):
            _draw_against_load(axes, data, name, level)
        if fluxes:
            _draw_fluxes(panels[-1], fluxes)
    return figure


def _draw_against_load(axes: draw.Axes, data: draw.FigureData, name: str, level: str) -> None:
    along = "normal_force" if "normal_force" in data.data else "indentation"
    load, load_unit = draw.column(data, along)
    values, unit = draw.column(data, name)
    values = np.where(np.isfinite(values), values, math.nan)
    few = "o" if values.size <= draw.MARKED_ROWS else None
    axes.plot(*draw.thinned_curve(load, values), color=draw.BLUE, lw=1.5, marker=few, ms=2.5, label=level)
    if name in data.bands:
        low, high = (draw.scaled(end, name, unit) for end in data.bands[name])
        axes.fill_between(load, low, high, color=draw.BLUE, alpha=0.15, lw=0, label="band of the scatter")
    if data.row >= 0:
        axes.plot(load[data.row], values[data.row], "o", color=draw.BLUE, ms=5)
    known = values[np.isfinite(values)]
    if known.size and known.min() > 0.0 and known.max() > 30.0 * known.min():
        axes.set_yscale("log")
    else:
        draw.begin_at_zero(axes)
    axes.set(xlabel=draw.axis_label(along, load_unit), ylabel=draw.axis_label(name, unit))
    draw.legend_above(axes)


def _draw_fluxes(axes: draw.Axes, fluxes: Mapping[str, xr.DataArray]) -> None:
    """The first flux over the radius; further ones are the same curve on other scales."""
    (name, flux), *others = fluxes.items()
    r, values = flux["r"].values, flux.values
    unit = good_unit(r, "m")
    shown, factor = _readable(draw.without_peaks(values), QUANTITIES[name].unit)
    y = factor * np.where(np.isfinite(values), values, math.nan)
    axes.plot(draw.lengths(r, unit), y, color=draw.ORANGE, lw=1.5)
    draw.limit_peaks(axes, factor * draw.without_peaks(values))
    edge = draw.lengths(np.max(r[np.isinf(values)], initial=0.0), unit)
    axes.axvline(float(edge), color=draw.GREY, lw=0.9, ls=":")
    axes.set(xlabel=f"{RADIUS.label} ({unit})", ylabel=draw.axis_label(name, shown))
    amplitude = flux["edge_amplitude"]
    own, power = _readable(amplitude.values[None], amplitude.attrs["units"])
    size = f"{float(power * amplitude):.4g} {draw.typeset_unit(own)}"
    label = f"$j \\simeq K/\\sqrt{{a-r}}$ at $r = a$:\n$K$ = {size}"
    axes.text(0.04, 0.96, label, va="top", transform=axes.transAxes, fontsize=draw.SMALL)
    for other, same in others:
        ratio = float(same["edge_amplitude"]) / float(amplitude)
        own, power = _readable(ratio * draw.without_peaks(values), QUANTITIES[other].unit)
        scale = axes.twinx()
        scale.set_ylim(*(ratio * power / factor * end for end in axes.get_ylim()))
        scale.spines["right"].set_visible(True)
        scale.set_ylabel(draw.axis_label(other, own))


def _readable(values: FloatArray, unit: str) -> tuple[str, float]:
    """A compound unit whose first part has a readable prefix, and the factor of values in it."""
    first, _, rest = unit.partition("/")
    prefixed = good_unit(values, "W").replace("W", first)
    return f"{prefixed}/{rest}", float(from_si(1.0, first, prefixed))
