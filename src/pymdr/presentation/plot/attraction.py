"""Figures of pull-off and of the laws of adhesion side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import QUANTITIES, RADIUS
from pymdr.units import FloatArray, good_unit

if TYPE_CHECKING:
    import xarray as xr


_LINES: Mapping[str, Any] = {
    "MaugisDugdale": {"color": draw.ORANGE, "lw": 3.0, "alpha": 0.6},
    "JKR": {"color": draw.BLUE, "lw": 1.3},
    "DMT": {"color": draw.GREEN, "lw": 1.3},
}


_LABELS = {"MaugisDugdale": "Maugis-Dugdale"}


def pull_off_figure(
    curve: Mapping[str, FloatArray], data: xr.Dataset, label: str = "equilibria"
) -> draw.Figure:
    """
    Force against indentation of all equilibria, with the pull-off and the state after the jump into contact.

    Parameters
    ----------
    curve : mapping of str to ndarray
        ``indentation`` (m) and ``normal_force`` (N) of all equilibria.
    data : xarray.Dataset
        Quantities of the pull-off.
    label : str
        Name of the curve.
    """
    with draw.new_figure(5.4, 4.0) as figure:
        axes = figure.subplots()
        d_unit, unit = (
            good_unit(curve[name], QUANTITIES[name].unit) for name in ("indentation", "normal_force")
        )
        x = draw.lengths(curve["indentation"], d_unit)
        y = draw.scaled(curve["normal_force"], "normal_force", unit)
        axes.plot(x, y, color=draw.BLUE, lw=1.3, label=label)
        for name, colour, names in (
            ("last stable state", draw.ORANGE, ("indentation", "normal_force")),
            ("after the jump into contact", draw.GREEN, ("jump_in_indentation", "jump_in_force")),
        ):
            d, force = (data[each].values for each in names)
            x, y = draw.lengths(d, d_unit), draw.scaled(force, "normal_force", unit)
            axes.plot(x, y, "o", ms=5, color=colour, label=name)
        axes.set(xlabel=draw.axis_label("indentation", d_unit), ylabel=draw.axis_label("normal_force", unit))
        draw.draw_zero(axes)
        draw.legend_above(axes)
    return figure


def compared_laws(
    curves: Mapping[str, Mapping[str, FloatArray]],
    pull_off_force: Mapping[str, float],
    pressures: Mapping[str, xr.DataArray],
) -> draw.Figure:
    """
    Force against indentation, and the pressure of the unloaded contact, under several laws of adhesion.

    Parameters
    ----------
    curves : mapping of str to mapping of str to ndarray
        ``indentation`` (m) and ``normal_force`` (N) of all equilibria by law.
    pull_off_force : mapping of str to float
        In N by law, below 0.
    pressures : mapping of str to xarray.DataArray
        Pressure in Pa over ``r`` by law.
    """
    with draw.new_figure(9.6, 4.2) as figure:
        left, right = figure.subplots(1, 2)
        _draw_equilibria(left, curves, pull_off_force)
        _draw_pressures(right, pressures, -pull_off_force["DMT"] if "DMT" in pull_off_force else None)
        for axes in (left, right):
            draw.draw_zero(axes)
            draw.legend_above(axes)
    return figure


def _draw_equilibria(
    axes: draw.Axes, curves: Mapping[str, Mapping[str, FloatArray]], pull_off_force: Mapping[str, float]
) -> None:
    depths, forces = ([curve[name] for curve in curves.values()] for name in ("indentation", "normal_force"))
    x_unit = good_unit(np.concatenate(depths), "m")
    unit = good_unit(np.concatenate(forces), "N")
    for name, d, force in zip(curves, depths, forces, strict=True):
        label = f"{_LABELS.get(name, name)}, pull-off at {draw.typeset(pull_off_force[name], 'N')}"
        x, y = draw.lengths(d, x_unit), draw.scaled(force, "normal_force", unit)
        axes.plot(x, y, label=label, **_LINES[name])
    axes.set(xlabel=draw.axis_label("indentation", x_unit), ylabel=draw.axis_label("normal_force", unit))


def _draw_pressures(axes: draw.Axes, pressures: Mapping[str, xr.DataArray], pull: float | None) -> None:
    """Pressures by law; the pull of DMT in N, outside the contact, is given in its label."""
    known = [p.values[np.isfinite(p.values)] for p in pressures.values()]
    bounded = [p.values for p in pressures.values() if float(p["edge_amplitude"]) == 0.0]
    high = max(float(draw.without_peaks(p).max()) for p in known)
    deepest = min((float(p.min()) for p in bounded), default=-high)
    # an infinite or far larger edge is cut
    low = max(1.25 * deepest, -3.0 * high) or -high
    r_unit = good_unit(np.concatenate([p["r"].values for p in pressures.values()]), "m")
    unit = good_unit(np.array([low, high]), "Pa")
    for name, p in pressures.items():
        label = _LABELS.get(name, name)
        if float(p["edge_amplitude"]) != 0.0:
            label += ", singular at its edge"
        if name == "DMT" and pull is not None:
            label += f", and a pull of {draw.typeset(pull, 'N')} outside"
        y = draw.scaled(p.values, "pressure", unit)
        axes.plot(draw.lengths(p["r"].values, r_unit), y, label=label, **_LINES[name])
    axes.set_ylim(*draw.scaled(np.array([low, 1.2 * high]), "pressure", unit))
    axes.set_xlim(left=0.0)
    axes.set(xlabel=f"{RADIUS.label} ({r_unit})", ylabel=draw.axis_label("pressure", unit))
