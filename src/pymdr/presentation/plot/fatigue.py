"""Maps of criteria of fatigue."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import ACROSS, ALONG, DEPTH
from pymdr.units import FloatArray, good_unit

if TYPE_CHECKING:
    import xarray as xr

_LEVELS = 16
_PREFIXED = {"": ((0.0, "%"),), "Pa*N/m": ((1e9, "GPa*N/m"), (1e6, "MPa*N/m"), (1e3, "kPa*N/m"))}
"""Units of quantities without a prefix of their own, from the largest value."""
_TRACE = 0.35
"""Half of the length of the drawn plane, over the contact radius."""


def fatigue_study(
    field: xr.DataArray,
    contact_radius: float,
    place: tuple[float, float, float],
    plane: FloatArray,
    largest: float,
) -> draw.Figure:
    """
    A criterion of fatigue in section, or on the surface, with its largest value, place and plane.

    Parameters
    ----------
    field : xarray.DataArray
        Over ``z``, ``y`` and ``x``; one depth gives a map of the surface.
    contact_radius : float
        The largest of the cycle in m.
    place : tuple of float
        x, y and z in m of the largest value.
    plane : ndarray, shape (3,)
        Unit normal of its plane, nan if there is none.
    largest : float
        The largest value in its SI unit.
    """
    name = str(field.name)
    surface = field.sizes["z"] == 1
    down = "y" if surface else "z"
    section = field.isel(z=0) if surface else field.isel(y=0)
    unit = good_unit(field["x"].values, "m")
    along, across = draw.lengths(section["x"].values, unit), draw.lengths(section[down].values, unit)
    values = np.where(np.isfinite(section.values), section.values, 0.0)
    si = str(field.attrs["units"])
    value_unit = next((unit for size, unit in _PREFIXED.get(si, ()) if largest >= size), si)
    if si and value_unit == si:
        value_unit = good_unit(np.append(values, largest), si)
    values = draw.scaled(values, name, value_unit)
    top = float(draw.scaled(np.array([largest]), name, value_unit)[0]) or 1.0
    with draw.new_figure(6.4, 4.4 if surface else 3.2) as figure:
        axes = figure.subplots()
        drawn = axes.contourf(
            along, across, values.clip(0.0, top), levels=np.linspace(0.0, top, _LEVELS + 1), cmap="magma"
        )
        draw.colour_bar(drawn, axes, draw.axis_label(name, value_unit))
        radius = float(draw.lengths(np.array([contact_radius]), unit)[0])
        if surface:
            angle = np.linspace(0.0, 2.0 * math.pi, 181)
            axes.plot(radius * np.cos(angle), radius * np.sin(angle), color="white", lw=0.8, ls=(0, (5, 3)))
        else:
            draw.mark_radii(axes, contact_radius, contact_radius, unit, both_sides=True)
        x, y, z = (float(value) for value in draw.lengths(np.array(place), unit))
        if not math.isnan(x):
            depth = y if surface else z
            if not surface and not np.isnan(plane).any() and math.hypot(plane[0], plane[2]) > 1e-6:
                trace = np.array([plane[2], -plane[0]]) / math.hypot(plane[0], plane[2])
                ends = np.array([-1.0, 1.0]) * _TRACE * radius
                axes.plot(x + ends * trace[0], depth + ends * trace[1], color="cyan", lw=1.6)
            axes.plot([x], [depth], "o", color="white", ms=5, mec="black", clip_on=False)
            axes.set_title(f"largest value {draw.typeset(top, value_unit)}", fontsize="medium")
        axes.set(
            xlabel=f"{ALONG.label} ({unit})",
            ylabel=f"{(ACROSS if surface else DEPTH).label} ({unit})",
            aspect="equal",
        )
        axes.set_xlim(float(along[0]), float(along[-1]))
        axes.set_ylim(*((float(across[0]), float(across[-1])) if surface else (float(across[-1]), 0.0)))
    return figure
