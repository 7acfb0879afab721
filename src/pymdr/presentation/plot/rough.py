"""The figure of a rough contact: stiffness against force, springs in contact, the spectrum."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.units import FloatArray, good_unit

if TYPE_CHECKING:
    import xarray as xr

_CLOSED = {
    "power_law_stiffness": ("power law, as published", "--", draw.ORANGE),
    "fitted_stiffness": ("power law, fitted", "-", draw.ORANGE),
    "hertz_stiffness": ("Hertz", "-", draw.GREEN),
}


def rough_study(
    data: xr.Dataset, curves: xr.Dataset, springs: xr.Dataset, spectrum: tuple[FloatArray, FloatArray]
) -> draw.Figure:
    """
    Stiffness of a rough contact against force, the springs of one line below the plane, and the spectrum.

    Parameters
    ----------
    data : xarray.Dataset
        ``normal_force`` (N) and ``normal_stiffness`` (N/m); optional attribute ``full_contact_stiffness`` (N/m).
    curves : xarray.Dataset
        ``normal_stiffness`` with ``_low`` and ``_high`` (N/m) over ``normal_force`` (N), and closed forms.
    springs : xarray.Dataset
        ``height`` (m) over ``x`` (m), attributes ``plane`` (m) and, for a ball, ``radius`` (m).
    spectrum : tuple of ndarray
        Wave numbers in 1/m and C2D in m^4.
    """
    with draw.new_figure(12.4, 3.8) as figure:
        first, second, third = figure.subplots(1, 3, width_ratios=(1.2, 1.2, 1.0))
        _draw_stiffness(first, data, curves)
        _draw_springs(second, springs)
        third.loglog(*spectrum, color=draw.BLUE, lw=1.5)
        third.set(xlabel="wave number $q$ (1/m)", ylabel=r"spectrum $C_\mathrm{2D}$ (m$^4$)")
    return figure


def _draw_stiffness(axes: draw.Axes, data: xr.Dataset, curves: xr.Dataset) -> None:
    force, stiffness = curves["normal_force"].values, curves["normal_stiffness"].values
    x_unit = good_unit(np.sqrt(force[:1] * force[-1:]), "N")
    unit = good_unit(stiffness[np.isfinite(stiffness)][-1:], "N/m")
    x = draw.scaled(force, "normal_force", x_unit)

    def shown(values: FloatArray) -> FloatArray:
        return draw.scaled(values, "normal_stiffness", unit)

    low, high = (shown(curves[f"normal_stiffness_{end}"].values) for end in ("low", "high"))
    axes.fill_between(x, low, high, color=draw.BLUE, alpha=0.2, lw=0, label="16 to 84 % of the lines")
    axes.loglog(x, shown(stiffness), color=draw.BLUE, lw=1.5, label="lines, geometric mean")
    few = "o" if data["normal_stiffness"].size <= draw.MARKED_ROWS else "."
    at = draw.scaled(data["normal_force"].values, "normal_force", x_unit)
    axes.plot(at, shown(data["normal_stiffness"].values), few, color=draw.BLUE, ms=4)
    for name, (label, style, colour) in _CLOSED.items():
        if name in curves:
            axes.plot(x, shown(curves[name].values), style, color=colour, lw=1.1, label=label)
    if "full_contact_stiffness" in data.attrs:
        full = float(shown(np.array(data.attrs["full_contact_stiffness"])))
        axes.axhline(full, color=draw.GREY, lw=1.0, ls=":", label="full contact $k_c$")
    axes.set(xlabel=draw.axis_label("normal_force", x_unit), ylabel=draw.axis_label("normal_stiffness", unit))
    draw.legend_above(axes)


def _draw_springs(axes: draw.Axes, springs: xr.Dataset) -> None:
    """The line and its part compressed by a plane from above; for a ball, only near the contact."""
    x, z = springs["x"].values, springs["height"].values
    if "radius" in springs.attrs:
        depth = float(z.max()) - springs.attrs["plane"]
        near = np.abs(x) <= max(3.0 * np.sqrt(springs.attrs["radius"] * depth), x[-1] / 50.0)
        x, z = x[near], z[near]
    x_unit, z_unit = good_unit(x, "m"), good_unit(z, "m")
    place, height = draw.lengths(x, x_unit), draw.lengths(z, z_unit)
    plane = float(draw.lengths(np.array(springs.attrs["plane"]), z_unit))
    axes.fill_between(place, height.min(), np.minimum(height, plane), color=draw.LIGHT, lw=0)
    axes.plot(place, np.minimum(height, plane), color=draw.GREY, lw=0.6)
    axes.fill_between(
        place, plane, height, where=height > plane, color=draw.ORANGE, lw=0, label="springs in contact"
    )
    axes.axhline(plane, color=draw.BLUE, lw=1.0, label="plane")
    axes.set_xlim(float(place[0]), float(place[-1]))
    axes.set(xlabel=f"position on the line $x$ ({x_unit})", ylabel=f"height ({z_unit})")
    draw.legend_above(axes)


_GEIKE_RANGE = (0.89, 1.44)
"""Range of Geike's line over boundary elements: 26 surfaces, 64 and 128 shortest waves per side, H from 0.2 to 0.8."""
_LINES = {
    "line_stiffness": (r"Geike, $\lambda = \pi$", draw.GREEN, "--"),
    "fitted_stiffness": (r"fitted, $\lambda$ = {:.3g}", draw.BLUE, "-"),
}


def calibration_study(data: xr.Dataset) -> draw.Figure:
    """
    Stiffness against load by lines, power law and boundary elements, their ratios to the last, and areas.

    Parameters
    ----------
    data : xarray.Dataset
        Over ``load``, without units: ``stiffness``, ``line_stiffness``, ``fitted_stiffness`` and ``area`` with their bands, ``power_law``
        and ``line_fraction``; ``coefficient``, ``full_contact_stiffness``, ``hurst`` and ``bandwidth`` in its attributes.
    """
    with draw.new_figure(13.0, 4.2) as figure:
        first, second, third = figure.subplots(1, 3)
        attributes, load = data.attrs, data["load"].values
        full, mean = attributes["full_contact_stiffness"], data["stiffness"].values
        for axes, over in ((first, 1.0), (second, mean)):
            low, high = (data[f"stiffness_{end}"].values / over for end in ("low", "high"))
            axes.fill_between(load, low, high, color=draw.ORANGE, alpha=0.25, lw=0)
            axes.plot(load, mean / over, "o-", color=draw.ORANGE, ms=4, lw=1.2, label="three dimensions")
            for name, (template, colour, style) in _LINES.items():
                low, high = (data[f"{name}_{end}"].values / over for end in ("low", "high"))
                axes.fill_between(load, low, high, color=colour, alpha=0.15, lw=0)
                label = template.format(attributes["coefficient"])
                axes.plot(load, data[name].values / over, style, color=colour, lw=1.4, label=label)
            y = data["power_law"].values / over
            axes.plot(load, y, "-.", color=draw.GREY, lw=1.2, label="power law, $C$ = 1.9412")
            inside = load[(mean > 0.03 * full) & (mean < 0.85 * full)]
            axes.axvspan(inside[0], inside[-1], color=draw.LIGHT, alpha=0.35, lw=0, zorder=0)
            axes.set_xscale("log")
        first.axhline(full, color=draw.GREY, lw=1.0, ls=":")
        first.set_yscale("log")
        first.set_ylabel("stiffness $k/E^*L$")
        second.set_ylim(0.5, 2.5)
        for at in _GEIKE_RANGE:
            second.axhline(at, color=draw.GREEN, lw=0.8, ls=":")
        second.set_ylabel("ratio to boundary elements")
        note = "dotted: Geike's line as measured\nwith 64 and 128 waves, 0.89 to 1.44"
        second.annotate(note, (0.04, 0.9), xycoords="axes fraction", fontsize=draw.SMALL, color=draw.GREY)
        third.fill_between(
            load, data["area_low"].values, data["area_high"].values, color=draw.ORANGE, alpha=0.25, lw=0
        )
        third.loglog(
            load, data["area"].values, "o-", color=draw.ORANGE, ms=4, lw=1.2, label="true area of contact"
        )
        y = data["line_fraction"].values
        third.plot(load, y, "--", color=draw.GREEN, lw=1.4, label="fraction of springs (not an area)")
        third.set_ylabel("fraction of the square")
        for axes in (first, second, third):
            axes.set_xlabel("load $F/E^*Lh$")
        for axes in (first, third):
            draw.legend_above(axes)
        second.set_title(
            f"$H$ = {attributes['hurst']:g}, {attributes['bandwidth']:.4g} shortest waves per side"
        )
    return figure
