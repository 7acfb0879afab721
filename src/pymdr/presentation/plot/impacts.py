"""Figures of impacts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import QUANTITIES
from pymdr.units import FloatArray, from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr


def impact_figure(data: xr.Dataset, friction: float | None) -> draw.Figure:
    """
    Force and contact radius of an impact against time, and the force against the indentation.

    Parameters
    ----------
    data : xarray.Dataset
        Over ``step``: ``time``, ``indentation``, ``normal_force`` and ``contact_radius``; for oblique impacts
        with friction also ``tangential_force`` and ``stick_radius``. Radii are optional.
    friction : float or None
        Coefficient of friction.
    """
    names = [name for name in ("time", "indentation", "normal_force", "contact_radius") if name in data]
    oblique = "tangential_force" in data
    units = {name: good_unit(data[name].values, QUANTITIES[name].unit) for name in names}
    shown = {name: draw.scaled(data[name].values, name, unit) for name, unit in units.items()}
    with draw.new_figure(11.4 if oblique else 7.6, 3.4) as figure:
        panels = figure.subplots(1, 3 if oblique else 2)
        first, second = panels[0], panels[1]
        first.plot(shown["time"], shown["normal_force"], color=draw.BLUE, lw=1.5)
        first.set_xlabel(draw.axis_label("time", units["time"]))
        first.set_ylabel(draw.axis_label("normal_force", units["normal_force"]), color=draw.BLUE)
        draw.draw_zero(first)
        if "contact_radius" in data:
            radius = first.twinx()
            radius.plot(shown["time"], shown["contact_radius"], color=draw.ORANGE, lw=1.2, ls="--")
            radius.set_ylabel(draw.axis_label("contact_radius", units["contact_radius"]), color=draw.ORANGE)
            # both scales have 0 at the same height
            low, high = first.get_ylim()
            top = 1.05 * float(np.nanmax(shown["contact_radius"], initial=0.0)) or 1.0
            if low < 0.0 < high:
                radius.set_ylim(top * low / high, top)
            else:
                first.set_ylim(bottom=0.0)
                radius.set_ylim(0.0, top)
        second.plot(shown["indentation"], shown["normal_force"], color=draw.BLUE, lw=1.5)
        second.set_xlabel(draw.axis_label("indentation", units["indentation"]))
        second.set_ylabel(draw.axis_label("normal_force", units["normal_force"]))
        draw.draw_zero(second)
        if oblique:
            _draw_tangential(panels[2], data, shown["time"], units["time"], friction)
    return figure


def restitution_study(data: xr.Dataset) -> draw.Figure:
    """
    Coefficient of restitution and contact time against the speed.

    Parameters
    ----------
    data : xarray.Dataset
        ``restitution`` and ``contact_time`` (s; inf if the bodies stick) over ``speed`` (m/s).
    """
    with draw.new_figure(8.4, 3.4) as figure:
        ordered = data.sortby("speed")
        v_unit = good_unit(ordered["speed"].values, "m/s")
        v = np.asarray(from_si(ordered["speed"].values, "m/s", v_unit))
        time = np.where(np.isfinite(ordered["contact_time"].values), ordered["contact_time"].values, np.nan)
        unit = good_unit(time, "s")
        few = "o" if v.size <= draw.MARKED_ROWS else None
        shown = (
            (ordered["restitution"].values, "coefficient of restitution $e$"),
            (np.asarray(from_si(time, "s", unit)), f"contact time $T$ ({unit})"),
        )
        for axes, (values, label) in zip(figure.subplots(1, 2), shown, strict=True):
            axes.plot(v, values, color=draw.BLUE, lw=1.5, marker=few, ms=3)
            axes.set_xscale("log" if v.size > 1 else "linear")
            axes.set(xlabel=f"speed $v$ ({v_unit})", ylabel=label)
            draw.begin_at_zero(axes)
    return figure


def _draw_tangential(
    axes: draw.Axes, data: xr.Dataset, time: FloatArray, time_unit: str, friction: float | None
) -> None:
    """The tangential force within the friction limits, shaded while part of the contact sticks."""
    unit = good_unit(data["tangential_force"].values, "N")
    force = draw.scaled(data["tangential_force"].values, "tangential_force", unit)
    limit = (friction or 0.0) * draw.scaled(data["normal_force"].values, "normal_force", unit)
    if "stick_radius" in data:
        sticking = data["stick_radius"].values > 0.0
        axes.fill_between(time, -limit, limit, where=sticking, color=draw.LIGHT, lw=0, label="part sticks")
    for sign in (-1.0, 1.0):
        label = "$\\pm\\mu F_N$" if sign > 0.0 else None
        axes.plot(time, sign * limit, color=draw.GREY, lw=0.8, ls=":", label=label)
    axes.plot(time, force, color=draw.GREEN, lw=1.5)
    axes.set(xlabel=draw.axis_label("time", time_unit), ylabel=draw.axis_label("tangential_force", unit))
    draw.draw_zero(axes)
    draw.legend_above(axes)
