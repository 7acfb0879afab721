"""The stress inside a body under the contact."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot.shared import axis_label, lengths, mark_radii, new_figure, scaled, styled
from pymdr.quantities import ALONG, DEPTH, RADIUS
from pymdr.units import good_unit, written

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LEVELS = 16
_SHOWN = 0.995
"""Share of the points whose values the colours resolve; those beside a singular edge are beyond."""


def stress_section(
    field: xr.DataArray, contact_radius: float, outer_radius: float, largest: xr.DataArray | None
) -> Figure:
    """
    A measure of stress below the surface in section, with the contact and the place of the largest value.

    Parameters
    ----------
    field : xarray.DataArray
        Over ``z`` and ``r``, or over ``z`` and ``x`` along the shift; depths of interfaces twice.
    contact_radius, outer_radius : float
        Radii in m of the contact and of its cohesive zone.
    largest : xarray.DataArray or None
        The largest value with the coordinates ``r`` (or ``x``) and ``z``; None where the stress has no bound.

    Returns
    -------
    matplotlib.figure.Figure
    """
    name = str(field.name)
    along = "x" if "x" in field.dims else "r"
    unit = good_unit(field[along].values, "m")
    across, z = (lengths(field[axis].values, unit) for axis in (along, "z"))
    values = np.where(np.isfinite(field.values), field.values, np.nan)
    stress_unit = good_unit(values, str(field.attrs["units"]))
    shown = scaled(values, name, stress_unit)
    low = min(float(np.nanmin(shown)), 0.0)
    top = float(np.nanmax(shown)) if largest is not None else float(np.nanquantile(shown, _SHOWN))
    shown = np.where(np.isnan(shown), np.inf, shown).clip(max=1.5 * top)
    if along == "r":
        across, shown = (
            np.concatenate([-across[:0:-1], across]),
            np.concatenate([shown[:, :0:-1], shown], axis=1),
        )
    with styled():
        figure = new_figure(6.0, 4.0)
        axes = figure.subplots()
        drawn = axes.contourf(
            across,
            z,
            shown,
            levels=np.linspace(low, top, _LEVELS + 1),
            cmap="viridis",
            extend="neither" if largest is not None else "max",
        )
        figure.colorbar(drawn, ax=axes, label=axis_label(name, stress_unit))
        # a depth that is read twice is an interface, with both its sides
        for interface in z[1:][np.diff(z) == 0.0]:
            axes.axhline(float(interface), color="white", lw=0.8, ls=(0, (5, 3)))
        mark_radii(axes, contact_radius, outer_radius, unit, both_sides=True)
        if largest is not None:
            _mark_largest(axes, largest, along, unit)
        axes.set(
            xlabel=f"{(ALONG if along == 'x' else RADIUS).label} ({unit})",
            ylabel=f"{DEPTH.label} ({unit})",
            aspect="equal",
        )
        axes.set_ylim(float(z[-1]), 0.0)
    return figure


def _mark_largest(axes: Axes, largest: xr.DataArray, along: str, unit: str) -> None:
    """The place and the value of the largest stress."""
    place, depth = (float(lengths(largest[axis].values, unit)) for axis in (along, "z"))
    places = sorted({-place, place}) if along == "r" else [place]
    axes.plot(places, [depth] * len(places), "o", color="white", ms=5, mec="black", clip_on=False)
    axes.annotate(
        written(float(largest), "Pa"),
        (place, depth),
        (6, -4),
        textcoords="offset points",
        color="black",
        va="top",
        fontsize=8,
    )
