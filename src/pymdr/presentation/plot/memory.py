"""Figures of viscoelastic contacts: histories and the loop."""

from __future__ import annotations

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.presentation.plot.curves import draw_curve, draw_pressure, fields
from pymdr.presentation.plot.section import section, section_into
from pymdr.units import from_si, good_unit

_COLOURS = {"normal_force": draw.BLUE, "contact_radius": draw.GREEN, "indentation": draw.ORANGE}


def memory_overview(data: draw.FigureData) -> draw.Figure:
    """The contact in section above its springs, its force against time, its loop, and its pressure."""
    with draw.new_figure(10.0, 6.4) as figure:
        left, right = np.ravel(np.asarray(figure.subfigures(1, 2, width_ratios=(1.25, 1.0))))
        section_into(left, data)
        force, loop, pressure = right.subplots(3, 1)
        draw_against_time(force, data, "normal_force")
        draw_curve(loop, data, "normal_force")
        if data.field is not None:
            draw_pressure(pressure, data)
    return figure


def memory_figures(data: draw.FigureData) -> dict[str, draw.Figure]:
    """``section``, ``history``, ``loop`` and ``fields``."""
    with draw.new_figure(9.6, 3.2) as history:
        for axes, name in zip(history.subplots(1, 3), _COLOURS, strict=True):
            draw_against_time(axes, data, name)
    with draw.new_figure(4.8, 3.6) as loop:
        draw_curve(loop.subplots(), data, "normal_force")
    return {"section": section(data), "history": history, "loop": loop, "fields": fields(data)}


def draw_against_time(axes: draw.Axes, data: draw.FigureData, name: str) -> None:
    """A quantity against time."""
    time, values = (data.data[column].values for column in ("time", name))
    unit = str(data.data[name].attrs["units"])
    t_unit, own = good_unit(time, "s"), good_unit(values, unit)
    axes.plot(
        *draw.thinned_curve(from_si(time, "s", t_unit), from_si(values, unit, own)),
        color=_COLOURS[name],
        lw=1.5,
    )
    axes.set(xlabel=draw.axis_label("time", t_unit), ylabel=draw.axis_label(name, own))
