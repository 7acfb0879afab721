"""Figures of contacts that are moved in the plane: the path, its force, and slip vectors."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.presentation.plot.section import section, section_into
from pymdr.quantities import AXES, RADIUS, quantity
from pymdr.units import FloatArray, from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr

_RINGS, _SPOKES = 9, 24


def planar_overview(data: draw.FigureData) -> draw.Figure:
    """The contact in section, its path and its force in the plane."""
    with draw.new_figure(10.4, 5.8) as figure:
        left, right = np.ravel(np.asarray(figure.subfigures(1, 2, width_ratios=(1.2, 1.0))))
        section_into(left, data)
        path, force = right.subplots(2, 1)
        _draw_path(path, data, "shift")
        _draw_path(force, data, "tangential_force")
    return figure


def planar_figures(data: draw.FigureData) -> dict[str, draw.Figure]:
    """
    The figures of a contact that is moved in the plane, by name.

    Returns
    -------
    dict of str to matplotlib.figure.Figure
        ``section``, ``plane`` (the path with the force next to it) and ``slip`` (slip vectors of a row over the contact).
    """
    with draw.new_figure(9.6, 4.4) as plane:
        left, right = plane.subplots(1, 2)
        _draw_path(left, data, "shift")
        _draw_path(right, data, "tangential_force")
    with draw.new_figure(5.6, 5.0) as slip:
        _draw_slip(slip.subplots(), data)
    return {"section": section(data), "plane": plane, "slip": slip}


def compared_plane(table: xr.Dataset, tractions: xr.Dataset, curves: xr.Dataset) -> draw.Figure:
    """
    Tangential forces in the plane, and the components of the traction of the last step, by the method and boundary elements.

    Parameters
    ----------
    table : xarray.Dataset
        ``tangential_force_x_grid`` and ``tangential_force_y_grid`` over ``step``, in N.
    tractions : xarray.Dataset
        ``grid_x`` and ``grid_y`` over ``r``, in Pa and m.
    curves : xarray.Dataset
        ``tangential_force_x`` and ``tangential_force_y`` over ``row``, ``shear_traction_x`` and ``shear_traction_y`` over ``r``: the drawn
        lines.
    """
    with draw.new_figure(9.6, 4.4) as figure:
        left, right = figure.subplots(1, 2)
        force = {axis: curves[f"tangential_force_{axis}"].values for axis in "xy"}
        unit = good_unit(np.concatenate(list(force.values())), "N")
        grid = [from_si(table[f"tangential_force_{axis}_grid"].values, "N", unit) for axis in "xy"]
        left.plot(*grid, "o", ms=5, mfc="none", color=draw.ORANGE, label="boundary elements")
        left.plot(*(from_si(force[axis], "N", unit) for axis in "xy"), color=draw.BLUE, lw=1.2, label="MDR")
        left.set_aspect("equal", adjustable="datalim")
        left.set_xlabel(draw.with_unit(quantity("tangential_force_x").label, unit))
        left.set_ylabel(draw.with_unit(quantity("tangential_force_y").label, unit))
        r_unit = good_unit(tractions["r"].values, "m")
        t_unit = good_unit(np.concatenate([tractions[f"grid_{axis}"].values for axis in "xy"]), "Pa")
        for axis, colour in (("x", draw.BLUE), ("y", draw.GREEN)):
            name = f"grid_{axis}"
            points = from_si(tractions[name].values, "Pa", t_unit)
            x = from_si(tractions["r"].values, "m", r_unit)
            right.plot(x, points, "o", ms=5, mfc="none", color=colour)
            fine = from_si(curves[f"shear_traction_{axis}"].values, "Pa", t_unit)
            label = f"along {axis}, MDR"
            right.plot(from_si(curves["r"].values, "m", r_unit), fine, color=colour, lw=1.2, label=label)
        right.plot([], [], "o", ms=5, mfc="none", color=draw.GREY, label="boundary elements, near the x axis")
        right.set_xlabel(f"{RADIUS.label} ({r_unit})")
        right.set_ylabel(draw.with_unit(quantity("shear_traction").label, t_unit))
        for axes in (left, right):
            draw.draw_zero(axes)
            draw.legend_above(axes)
    return figure


def _draw_path(axes: draw.Axes, data: draw.FigureData, name: str) -> None:
    """A vector over the path, its start and the drawn row, and for forces the circle mu F_N."""
    values = data.data[name].values
    unit = good_unit(values[np.isfinite(values)], data.data[name].attrs["units"])
    x, y = from_si(values, data.data[name].attrs["units"], unit).T
    axes.plot(*draw.thinned_curve(x, y), color=draw.GREY, lw=1.2)
    axes.plot(x[:1], y[:1], "o", color=draw.GREEN, ms=5, label="first row")
    if data.row >= 0:
        label = draw.row_name(data, data.row)
        axes.plot(x[[data.row]], y[[data.row]], "o", color=draw.BLUE, ms=6, label=label)
        if name == "tangential_force" and data.friction is not None and math.isfinite(data.friction):
            most = data.friction * float(data.data["normal_force"].values[data.row])
            circle = _circle(float(from_si(most, "N", unit)))
            axes.plot(*circle, "--", color=draw.GREY, lw=0.9, label=r"$\mu F_N$")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(draw.with_unit(quantity(f"{name}_x").label, unit))
    axes.set_ylabel(draw.with_unit(quantity(f"{name}_y").label, unit))
    draw.legend_above(axes)


def _draw_slip(axes: draw.Axes, data: draw.FigureData) -> None:
    """Slip vectors on rings of the contact, the longest half as long as the distance of two rings."""
    if data.field is None or data.row < 0:
        return
    a = float(data.data["contact_radius"].values[data.row])
    stick = float(data.data["stick_radius"].values[data.row])
    if not a > 0.0:
        return
    r = a * (np.arange(_RINGS) + 0.5) / _RINGS
    slip = np.nan_to_num(np.asarray(data.field("slip", r)))
    unit = good_unit(np.array([a]), "m")
    scale = float(from_si(1.0, "m", unit))
    longest = float(np.max(np.hypot(*slip)))
    angle = 2.0 * np.pi * np.arange(_SPOKES) / _SPOKES
    x, y = (np.multiply.outer(r, part(angle)).ravel() * scale for part in (np.cos, np.sin))
    u, v = (np.repeat(part, _SPOKES) for part in slip)
    if longest > 0.0:
        length = 1.5 * a * scale / _RINGS / longest
        axes.quiver(
            x,
            y,
            length * u,
            length * v,
            angles="xy",
            scale_units="xy",
            scale=1.0,
            color=draw.BLUE,
            width=0.004,
        )
    for radius, colour, label in ((a, draw.GREY, "contact"), (stick, draw.ORANGE, "stick")):
        axes.plot(*_circle(radius * scale), color=colour, lw=1.2, label=label)
    axes.set_aspect("equal")
    unit_of_slip = good_unit(np.array([longest or a]), "m")
    shown = float(from_si(longest, "m", unit_of_slip))
    axes.set_title(
        f"slip, longest arrow {shown:.3g} {unit_of_slip}, {draw.row_name(data, data.row)}", fontsize=9
    )
    axes.set_xlabel(draw.with_unit(f"position {AXES['x']}", unit))
    axes.set_ylabel(draw.with_unit(f"position {AXES['y']}", unit))
    axes.legend(loc="lower right", fontsize=8)


def _circle(radius: float) -> FloatArray:
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    return radius * np.array([np.cos(angle), np.sin(angle)])
