"""Figures of contacts with memory and adhesion or layers: the loop, radii and histories; with a cohesive zone section and fields."""

from __future__ import annotations

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.presentation.plot.adhesion import adhesive_fields, draw_tensile_pressure
from pymdr.presentation.plot.section import section, section_into
from pymdr.quantities import QUANTITIES
from pymdr.units import from_si, good_unit, written

_COLOURS = {
    "normal_force": draw.BLUE,
    "contact_radius": draw.BLUE,
    "cohesive_radius": draw.GREEN,
    "dissipated_energy": draw.ORANGE,
    "edge_speed": draw.ORANGE,
}


def short_overview(data: draw.FigureData) -> draw.Figure:
    """Force against depth and time, the radii, and the speed of the edge, in one figure."""
    with draw.new_figure(9.6, 6.4) as figure:
        loop, force, radii, speed = np.ravel(figure.subplots(2, 2))
        _draw_loop(loop, data)
        _draw(force, data, "time", ("normal_force",))
        _draw(radii, data, "time", ("contact_radius", "cohesive_radius"))
        _draw(speed, data, "time", ("edge_speed",))
    return figure


def soft_figures(data: draw.FigureData) -> dict[str, draw.Figure]:
    """``loop``, ``radius`` and ``history``."""
    with (
        draw.new_figure(5.6, 4.2) as loop,
        draw.new_figure(5.6, 4.2) as radius,
        draw.new_figure(9.6, 3.4) as history,
    ):
        _draw_loop(loop.subplots(), data)
        _draw(radius.subplots(), data, _across(data), ("contact_radius", "cohesive_radius"))
        names = (("normal_force",), ("contact_radius", "cohesive_radius"), (_last(data),))
        for axes, each in zip(history.subplots(1, 3), names, strict=True):
            _draw(axes, data, "time", each)
    return {"loop": loop, "radius": radius, "history": history}


def zone_overview(data: draw.FigureData) -> draw.Figure:
    """The contact in section, its force against depth, its radii, and its pressure, in one figure."""
    with draw.new_figure(10.4, 6.6) as figure:
        if data.field is None:
            section_into(figure, data)
            return figure
        left, right = np.ravel(np.asarray(figure.subfigures(1, 2, width_ratios=(1.2, 1.0))))
        section_into(left, data)
        loop, radii, pressure = right.subplots(3, 1)
        _draw_loop(loop, data)
        _draw(radii, data, "time", ("contact_radius", "cohesive_radius"))
        draw_tensile_pressure(pressure, data)
    return figure


def zone_figures(data: draw.FigureData) -> dict[str, draw.Figure]:
    """``section``, ``loop``, ``radius``, ``history`` and ``fields``."""
    return {"section": section(data), **soft_figures(data), "fields": adhesive_fields(data)}


def _last(data: draw.FigureData) -> str:
    return "edge_speed" if "edge_speed" in data.data else "dissipated_energy"


def _across(data: draw.FigureData) -> str:
    return "travel" if "travel" in data.data else "indentation"


def _draw_loop(axes: draw.Axes, data: draw.FigureData) -> None:
    """Force against depth; if the bodies part in the end, the area of the loop is the work that it takes."""
    across = _across(data)
    _draw(axes, data, across, ("normal_force",))
    force = data.data["normal_force"].values
    if "external_work" not in data.data or force[-1] != 0.0 or not np.isfinite(force).all():
        return
    parts = {"work of the loop": data.data["external_work"], "dissipated": data.data["dissipated_energy"]}
    label = ", ".join(f"{name} {written(float(energy.values[-1]), 'J')}" for name, energy in parts.items())
    x, y = (np.asarray(values, dtype=float) for values in axes.lines[0].get_data())
    axes.fill(
        np.append(x[0], x), np.append(0.0, y), color=draw.ORANGE, alpha=0.15, lw=0, label=label, zorder=1
    )
    draw.legend_above(axes)


def _draw(axes: draw.Axes, data: draw.FigureData, across: str, names: tuple[str, ...]) -> None:
    """Quantities of one unit against another one; those that the result lacks are left out."""
    names = tuple(name for name in names if name in data.data)
    x = data.data[across].values
    x_unit = good_unit(x, QUANTITIES[across].unit)
    every = np.concatenate([data.data[name].values for name in names])
    unit = good_unit(every, QUANTITIES[names[0]].unit)
    for name in names:
        label = QUANTITIES[name].label if len(names) > 1 else None
        x_drawn = from_si(x, QUANTITIES[across].unit, x_unit)
        y = from_si(data.data[name].values, QUANTITIES[name].unit, unit)
        axes.plot(x_drawn, y, color=_COLOURS[name], lw=1.5, label=label)
    draw.draw_zero(axes)
    axes.set_xlabel(draw.axis_label(across, x_unit))
    axes.set_ylabel(draw.axis_label(names[0], unit) if len(names) == 1 else f"radius ({unit})")
    if len(names) > 1:
        draw.legend_above(axes)
