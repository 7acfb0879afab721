"""Figures of sweeps over parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import magnitudes, parameter_label, quantity
from pymdr.units import FloatArray, from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr

_CURVES, _NAMED = 200, 8
"""Largest numbers of drawn curves, and of combinations in a legend."""
_STILL = 1e-9
"""Relative change of an indentation below which it stays the same."""


def sweep_curves(data: xr.Dataset, name: str, parameters: Sequence[str]) -> draw.Figure:
    """
    A quantity along the path at every point of a grid, and its largest value against the first parameter.

    Parameters
    ----------
    data : xarray.Dataset
        Over the parameters and ``step``.
    parameters : sequence of str
        The dimensions of the grid; colours follow the first.
    """
    with draw.new_figure(9.6, 3.8) as figure:
        along, over = figure.subplots(1, 2)
        values = magnitudes(data[name]).transpose(*parameters, "step").values
        unit = good_unit(values, quantity(name).unit)
        shown = draw.scaled(values, name, unit)
        across = "indentation" if name != "indentation" and _moves(data) else None
        _draw_along(along, data, shown, across, parameters)
        known = np.where(np.isnan(shown).all(axis=-1, keepdims=True), -np.inf, shown)
        largest = np.nanmax(known, axis=-1)
        _draw_over(over, data, np.where(np.isfinite(largest), largest, np.nan), parameters)
        label = draw.axis_label(name, unit)
        if "axis" in data[name].dims:
            label = draw.with_unit(f"magnitude of {quantity(name).long_name}", unit)
        along.set_ylabel(label)
        over.set_ylabel(f"largest {label}")
    return figure


def _moves(data: xr.Dataset) -> bool:
    """Whether the indentation changes along the path."""
    if "indentation" not in data:
        return False
    depth = data["indentation"]
    change = depth.max("step") - depth.min("step")
    return bool((change > _STILL * abs(depth).max("step")).any())


def _draw_along(
    axes: draw.Axes, data: xr.Dataset, shown: FloatArray, across: str | None, parameters: Sequence[str]
) -> None:
    from matplotlib import colormaps

    count = shown.shape[0]
    lines = shown.reshape(-1, shown.shape[-1])
    which = draw.thinned(np.arange(float(lines.shape[0])), _CURVES)
    if across is None:
        x = np.broadcast_to(np.arange(1, shown.shape[-1] + 1), shown.shape).reshape(lines.shape)
        axes.set_xlabel("row of the path")
    else:
        depth = data[across].transpose(*parameters, "step").values.reshape(lines.shape)
        unit = good_unit(depth, quantity(across).unit)
        x = draw.scaled(depth, across, unit)
        axes.set_xlabel(draw.axis_label(across, unit))
    colours = colormaps["viridis"](np.linspace(0.0, 0.9, count))
    names = _names(data, parameters[:1], bare=True)
    named = set(np.linspace(0, count - 1, min(count, _NAMED)).round().astype(int).tolist())
    for line in which:
        first = int(np.unravel_index(line, shown.shape[:-1])[0])
        few, label = "o" if lines.shape[1] == 1 else "", names[first] if first in named else None
        axes.plot(x[line], lines[line], color=colours[first], lw=1.0, marker=few, label=label)
        named.discard(first)
    draw.legend_above(axes, parameter_label(parameters[0]))


def _draw_over(axes: draw.Axes, data: xr.Dataset, largest: FloatArray, parameters: Sequence[str]) -> None:
    first = data[parameters[0]]
    numeric = "units" in first.attrs
    x = np.asarray(first.values if numeric else np.arange(first.size), dtype=float)
    if numeric:
        unit = good_unit(x, first.attrs["units"])
        x = np.asarray(from_si(x, first.attrs["units"], unit))
        axes.set_xlabel(draw.with_unit(parameter_label(parameters[0]), unit))
        if np.all(x > 0.0) and x.max() > 10.0 * x.min():
            axes.set_xscale("log")
    else:
        axes.set_xticks(x, [str(value).partition("(")[0] for value in first.values])
        axes.set_xlabel(parameter_label(parameters[0]))
    rest = largest.reshape(first.size, -1)
    names = _names(data, parameters[1:])
    for i in draw.thinned(np.arange(float(rest.shape[1])), _CURVES):
        label = names[i] if 1 < rest.shape[1] <= _NAMED else None
        axes.plot(x, rest[:, i], "o-", ms=3.5, lw=1.0, label=label)
    draw.legend_above(axes)


def _names(data: xr.Dataset, parameters: Sequence[str], bare: bool = False) -> list[str]:
    """Labels of all combinations; `bare` leaves out the names of the parameters."""
    names = [""]
    for parameter in parameters:
        texts = _distinct(data[parameter])
        labels = texts if bare else [f"{parameter_label(parameter)} = {text}" for text in texts]
        names = [f"{name}, {label}".removeprefix(", ") for name in names for label in labels]
    return names


def _distinct(values: xr.DataArray) -> list[str]:
    """Texts of values, with as many digits as distinguish them."""
    unit = values.attrs.get("units")
    if unit is None:
        return [str(value).partition("(")[0] for value in values.values]
    for digits in range(3, 18):
        texts = [draw.typeset(float(value), unit, digits) for value in values.values]
        if len(set(texts)) == np.unique(values.values).size:
            break
    return texts
