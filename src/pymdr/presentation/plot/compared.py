"""Figures that compare the method with other solutions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import DEPTH, QUANTITIES, RADIUS
from pymdr.units import from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr

_ROUNDING = float(np.finfo(float).eps)
"""Smallest relative difference that is drawn."""


def compared_pressures(
    pressures: xr.Dataset, history: xr.Dataset | None = None, stress: xr.Dataset | None = None
) -> draw.Figure:
    """
    Pressure by the method and by rings over the radius, with their difference below; with memory also the history.

    Parameters
    ----------
    pressures : xarray.Dataset
        ``mdr`` and ``rings`` over ``r``, in Pa and m; attribute ``infinite``: radii in m at which the pressure is infinite.
    history : xarray.Dataset, optional
        ``time``, ``normal_force`` and ``indentation`` as ``_mdr`` and ``_rings`` over ``row``, in SI units.
    stress : xarray.Dataset, optional
        In the body: ``mdr`` and ``point_loads`` in Pa over ``component`` and ``z``, ``curve`` over ``component`` and ``depth``.
    """
    columns = 1 + (history is not None) + (stress is not None)
    with draw.new_figure(6.0 if columns == 1 else 4.8 * columns, 5.0) as figure:
        panels = figure.subplots(2, columns, sharex="col", height_ratios=(2, 1), squeeze=False)
        if history is not None:
            force, depth = panels[:, 0]
            _draw_histories(force, history, "normal_force")
            _draw_histories(depth, history, "indentation")
            depth.set_xlabel(draw.axis_label("time", good_unit(history["time"].values, "s")))
        upper, lower = panels[:, int(history is not None)]
        _draw_pressures(upper, lower, pressures)
        if stress is not None:
            upper, lower = panels[:, -1]
            _draw_stresses(upper, lower, stress)
    return figure


def _draw_pressures(upper: draw.Axes, lower: draw.Axes, pressures: xr.Dataset) -> None:
    """Both pressures, and below them their difference."""
    r = pressures["r"].values
    mdr, rings = (pressures[name].values for name in ("mdr", "rings"))
    r_unit, p_unit = good_unit(r, "m"), good_unit(draw.without_peaks(rings), "Pa")
    d_unit = p_unit
    x = from_si(r, "m", r_unit)
    y = from_si(rings, "Pa", p_unit)
    upper.plot(x, y, color=draw.ORANGE, lw=3, alpha=0.6, label="boundary elements on rings")
    if np.isfinite(mdr).any():
        upper.plot(x, from_si(mdr, "Pa", p_unit), color=draw.BLUE, lw=1.2, label="MDR")
        d_unit = good_unit(mdr - rings, "Pa")
        lower.plot(x, from_si(mdr - rings, "Pa", d_unit), color=draw.GREY, lw=1)
    else:
        lower.text(0.5, 0.5, "MDR refused: not a disk contact", ha="center", transform=lower.transAxes)
    draw.limit_peaks(upper, from_si(draw.without_peaks(rings), "Pa", p_unit))
    draw.note_peaks(upper, pressures.attrs.get("infinite", ()))
    upper.set_ylabel(draw.axis_label("pressure", p_unit))
    lower.set(ylabel=f"difference ({d_unit})", xlabel=f"{RADIUS.label} ({r_unit})")
    lower.axhline(0.0, color=draw.LIGHT, zorder=0)
    draw.legend_above(upper)


def _draw_stresses(upper: draw.Axes, lower: draw.Axes, stress: xr.Dataset) -> None:
    """Components of the stress over the depth by the method and by point loads, and below them their differences over the largest stress."""
    unit = good_unit(stress["curve"].values, "Pa")
    z_unit = good_unit(stress["depth"].values, "m")
    z, depth = (draw.lengths(stress[axis].values, z_unit) for axis in ("z", "depth"))
    largest = float(np.max(np.abs(stress["curve"].values)))
    differences = np.abs((stress["mdr"] - stress["point_loads"]).values) / largest
    for i, component in enumerate(stress["component"].values.tolist()):
        row, colour = stress.sel(component=component), draw.CYCLE[i]
        name = f"$\\sigma_{{{component}}}$"
        upper.plot(depth, draw.scaled(row["curve"].values, "stress", unit), color=colour, lw=1.2, label=name)
        upper.plot(
            z, draw.scaled(row["point_loads"].values, "stress", unit), "o", ms=4, mfc="none", color=colour
        )
        lower.semilogy(z, np.maximum(differences[i], _ROUNDING), ".-", ms=4, lw=0.6, color=colour)
    upper.plot([], [], color=draw.GREY, lw=1.2, label="MDR")
    upper.plot([], [], "o", ms=4, mfc="none", color=draw.GREY, label="point loads")
    x, y = (draw.typeset(float(stress[axis]), "m", 3) for axis in ("x", "y"))
    upper.annotate(
        f"$x$ = {x}, $y$ = {y}",
        (0.97, 0.04),
        xycoords="axes fraction",
        ha="right",
        va="bottom",
        fontsize=draw.SMALL,
    )
    upper.set_ylabel(draw.axis_label("stress", unit))
    lower.yaxis.set_major_locator(LogLocator(numticks=4))
    lower.yaxis.set_minor_formatter(NullFormatter())
    lower.set(ylabel="difference / largest", xlabel=f"{DEPTH.label} ({z_unit})")
    upper.axhline(0.0, color=draw.LIGHT, zorder=0)
    draw.legend_above(upper)


def _draw_histories(axes: draw.Axes, history: xr.Dataset, name: str) -> None:
    """Both solutions over time."""
    time, mdr, rings = (history[column].values for column in ("time", f"{name}_mdr", f"{name}_rings"))
    x = from_si(time, "s", good_unit(time, "s"))
    unit = good_unit(rings, QUANTITIES[name].unit)
    axes.plot(x, from_si(rings, QUANTITIES[name].unit, unit), color=draw.ORANGE, lw=3, alpha=0.6)
    axes.plot(x, from_si(mdr, QUANTITIES[name].unit, unit), color=draw.BLUE, lw=1.2)
    axes.set_ylabel(draw.axis_label(name, unit))


def compared_shape(
    table: xr.Dataset,
    pressures: xr.DataArray | None,
    hertz: Mapping[str, xr.DataArray],
    axes: tuple[float, float] | None,
) -> draw.Figure:
    """
    Pressures by boundary elements on a plan, those along both axes, and the force over the indentation.

    Parameters
    ----------
    table : xarray.Dataset
        ``indentation``, ``normal_force_engine`` with its ``_error``, and the forces of the method over ``step``, in SI units.
    pressures : xarray.DataArray or None
        Of the last step in Pa over ``x`` and ``y`` in m; None where they are not known.
    hertz : mapping of str to xarray.DataArray
        Exact pressures over ``r`` along "x" and "y", where there are some.
    axes : tuple of float or None
        Semi-axes of the exact contact in m.
    """
    with draw.new_figure(13.0, 3.9) as figure:
        plan, cut, curve = figure.subplots(1, 3)
        if pressures is None:
            for panel in (plan, cut):
                panel.text(0.5, 0.5, "body not known at this depth", ha="center", transform=panel.transAxes)
                panel.set_axis_off()
        else:
            highest = pressures.where(pressures > 0.0)
            p_unit = good_unit(pressures.values, "Pa")
            unit = good_unit(np.concatenate([pressures[axis].values for axis in ("x", "y")]), "m")
            x, y = (
                draw.lengths(pressures[axis].values - _apex(pressures, axis), unit) for axis in ("x", "y")
            )
            image = plan.pcolormesh(
                x, y, draw.scaled(highest.values.T, "pressure", p_unit), cmap="viridis", shading="nearest"
            )
            if axes is not None:
                around = np.linspace(0.0, 2.0 * np.pi, 200)
                a_x, a_y = (draw.lengths(np.array(a), unit) for a in axes)
                x_around, y_around = a_x * np.cos(around), a_y * np.sin(around)
                plan.plot(x_around, y_around, color=draw.ORANGE, lw=1.2, label="exact outline")
                draw.legend_above(plan)
            plan.set_aspect("equal")
            plan.set(xlabel=f"$x$ ({unit})", ylabel=f"$y$ ({unit})")
            _draw_cuts(cut, pressures, hertz, unit, p_unit)
        _draw_forces(curve, table)
        if pressures is not None:
            figure.colorbar(image, ax=plan, label=draw.axis_label("pressure", p_unit), shrink=0.6)
    return figure


def _apex(pressures: xr.DataArray, axis: str) -> float:
    """Coordinate of the apex, which is a pixel of the grid."""
    return float(pressures.attrs[f"apex_{axis}"])


def _draw_cuts(
    panel: draw.Axes, pressures: xr.DataArray, hertz: Mapping[str, xr.DataArray], unit: str, p_unit: str
) -> None:
    """Pressures along both axes through the apex."""
    for axis, other, colour in (("x", "y", draw.BLUE), ("y", "x", draw.ORANGE)):
        line = pressures.sel({other: _apex(pressures, other)}, method="nearest")
        at = draw.lengths(line[axis].values - _apex(pressures, axis), unit)
        p = draw.scaled(line.values, "pressure", p_unit)
        panel.plot(at, p, ".", ms=4, color=colour, label=f"boundary elements, along ${axis}$")
        if axis in hertz:
            r, p = (
                draw.lengths(hertz[axis]["r"].values, unit),
                draw.scaled(hertz[axis].values, "pressure", p_unit),
            )
            both = np.concatenate([-r[::-1], r]), np.concatenate([p[::-1], p])
            panel.plot(*both, color=colour, lw=1.2, label=f"Hertz, along ${axis}$")
    bearing = pressures.where(pressures > 0.0, drop=True)
    ends = np.concatenate([bearing[axis].values - _apex(pressures, axis) for axis in ("x", "y")])
    half = 1.15 * float(draw.lengths(np.abs(ends).max(keepdims=True), unit)[0])
    panel.set_xlim(-half, half)
    panel.set(xlabel=f"distance from the apex ({unit})", ylabel=draw.axis_label("pressure", p_unit))
    draw.draw_zero(panel)
    draw.legend_above(panel)


def _draw_forces(panel: draw.Axes, table: xr.Dataset) -> None:
    """Forces by the method, and by boundary elements with their error."""
    depth, force = table["indentation"].values, table["normal_force_engine"].values
    forces = {
        "force_lower_bound": ("lower bound", "-.", draw.GREEN),
        "force_estimate": ("estimate", "--", draw.GREY),
    }
    forces["normal_force"] = ("MDR", "-", draw.BLUE)
    known = {name: table[f"{name}_mdr"].values for name in forces if f"{name}_mdr" in table}
    d_unit = good_unit(depth, "m")
    f_unit = good_unit(
        np.concatenate([force[np.isfinite(force)], *(v[np.isfinite(v)] for v in known.values())]), "N"
    )
    x = draw.lengths(depth, d_unit)
    for name, values in known.items():
        label, style, colour = forces[name]
        if np.isfinite(values).any():
            y = draw.scaled(values, "normal_force", f_unit)
            panel.plot(x, y, style, color=colour, lw=1.5, label=label, marker=".")
    own = draw.scaled(force * table["normal_force_error"].values, "normal_force", f_unit)
    y = draw.scaled(force, "normal_force", f_unit)
    panel.errorbar(x, y, yerr=own, fmt="o", ms=5, mfc="none", color=draw.ORANGE, label="boundary elements")
    panel.set(xlabel=draw.axis_label("indentation", d_unit), ylabel=draw.axis_label("normal_force", f_unit))
    draw.draw_zero(panel)
    draw.legend_above(panel)


def compared_tractions(
    table: xr.Dataset, tractions: xr.Dataset, curves: xr.Dataset, stress: xr.Dataset | None = None
) -> draw.Figure:
    """
    Force against shift, or torque against twist, and the traction of the last step, by the method and boundary elements.

    Parameters
    ----------
    table : xarray.Dataset
        ``shift``, ``tangential_force_mdr`` and ``tangential_force_grid`` over ``step``, or those of ``twist`` and ``torque``, in SI units.
    tractions : xarray.Dataset
        ``mdr`` and ``grid`` over ``r``, in Pa and m; attribute ``infinite``: radii in m at which the pressure is infinite.
    curves : xarray.Dataset
        ``shift`` and ``tangential_force`` over ``row``, ``shear_traction`` over ``r``: the drawn lines.
    stress : xarray.Dataset, optional
        In the body, as for :func:`compared_pressures`.
    """
    turned = "twist" in table
    motion, force_name, traction = (
        ("twist", "torque", "torsional_traction")
        if turned
        else ("shift", "tangential_force", "shear_traction")
    )
    with draw.new_figure(*((9.0, 3.9) if stress is None else (13.5, 4.6))) as figure:
        if stress is None:
            left, right = figure.subplots(1, 2)
        else:
            places = figure.add_gridspec(2, 3, height_ratios=(2, 1))
            left, right = figure.add_subplot(places[:, 0]), figure.add_subplot(places[:, 1])
            inside = figure.add_subplot(places[0, 2])
            _draw_stresses(inside, figure.add_subplot(places[1, 2], sharex=inside), stress)
            inside.tick_params(labelbottom=False)
        shift, force = curves[motion].values, curves[force_name].values
        u_unit, f_unit = (good_unit(v, QUANTITIES[n].unit) for v, n in ((shift, motion), (force, force_name)))
        other = draw.scaled(table[f"{force_name}_grid"].values, force_name, f_unit)
        moved = draw.scaled(table[motion].values, motion, u_unit)
        left.plot(moved, other, "o", ms=5, mfc="none", color=draw.ORANGE, label="boundary elements")
        moved, y = draw.scaled(shift, motion, u_unit), draw.scaled(force, force_name, f_unit)
        left.plot(moved, y, color=draw.BLUE, lw=1.2, label="MDR")
        left.set(xlabel=draw.axis_label(motion, u_unit), ylabel=draw.axis_label(force_name, f_unit))
        r_unit, t_unit = good_unit(tractions["r"].values, "m"), good_unit(tractions["grid"].values, "Pa")
        r = draw.lengths(tractions["r"].values, r_unit)
        grid = draw.scaled(tractions["grid"].values, traction, t_unit)
        label = "boundary elements" if turned else "boundary elements, near the x axis"
        right.plot(r, grid, "o", ms=5, mfc="none", color=draw.ORANGE, label=label)
        fine = draw.lengths(curves["r"].values, r_unit)
        tau = draw.scaled(curves[traction].values, traction, t_unit)
        right.plot(fine, tau, color=draw.BLUE, lw=1.2, label="MDR")
        draw.note_peaks(right, tractions.attrs.get("infinite", ()))
        right.set(xlabel=f"{RADIUS.label} ({r_unit})", ylabel=draw.axis_label(traction, t_unit))
        for axes in (left, right):
            draw.draw_zero(axes)
            draw.legend_above(axes)
    return figure
