"""The stress inside a body under the contact."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot.shared import axis_label, lengths, mark_radii, new_figure, scaled, styled
from pymdr.quantities import DEPTH, RADIUS
from pymdr.units import good_unit, written

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_LEVELS = 16
_SHOWN = 0.995
"""Share of the points whose values the colours resolve; those beside a singular edge are beyond."""


def stress_section(
    field: xr.DataArray, contact_radius: float, outer_radius: float, largest: xr.DataArray | None
) -> Figure:
    """
    An equivalent stress below the surface in section, with the contact and the place of the largest value.

    Parameters
    ----------
    field : xarray.DataArray
        Over ``z`` and ``r``; depths of interfaces twice.
    contact_radius, outer_radius : float
        Radii in m of the contact and of its cohesive zone.
    largest : xarray.DataArray or None
        The largest value with the coordinates ``r`` and ``z``; None where the stress has no bound.

    Returns
    -------
    matplotlib.figure.Figure
    """
    name = str(field.name)
    unit = good_unit(field["r"].values, "m")
    r, z = (lengths(field[axis].values, unit) for axis in ("r", "z"))
    values = np.where(np.isfinite(field.values), field.values, np.nan)
    stress_unit = good_unit(values, str(field.attrs["units"]))
    shown = scaled(values, name, stress_unit)
    top = float(np.nanmax(shown)) if largest is not None else float(np.nanquantile(shown, _SHOWN))
    shown = np.where(np.isnan(shown), np.inf, shown).clip(max=1.5 * top)
    with styled():
        figure = new_figure(6.0, 4.0)
        axes = figure.subplots()
        drawn = axes.contourf(
            np.concatenate([-r[:0:-1], r]),
            z,
            np.concatenate([shown[:, :0:-1], shown], axis=1),
            levels=np.linspace(0.0, top, _LEVELS + 1),
            cmap="viridis",
            extend="neither" if largest is not None else "max",
        )
        figure.colorbar(drawn, ax=axes, label=axis_label(name, stress_unit))
        # a depth that is read twice is an interface, with both its sides
        for interface in z[1:][np.diff(z) == 0.0]:
            axes.axhline(float(interface), color="white", lw=0.8, ls=(0, (5, 3)))
        mark_radii(axes, contact_radius, outer_radius, unit, both_sides=True)
        if largest is not None:
            at_r, at_z = (float(lengths(largest[axis].values, unit)) for axis in ("r", "z"))
            axes.plot(
                sorted({-at_r, at_r}), [at_z] * len({-at_r, at_r}), "o", color="white", ms=5, mec="black"
            )
            words = written(float(largest), "Pa")
            axes.annotate(
                words, (at_r, at_z), (6, -4), textcoords="offset points", color="black", va="top", fontsize=8
            )
        axes.set(xlabel=f"{RADIUS.label} ({unit})", ylabel=f"{DEPTH.label} ({unit})", aspect="equal")
        axes.set_ylim(float(z[-1]), 0.0)
    return figure
