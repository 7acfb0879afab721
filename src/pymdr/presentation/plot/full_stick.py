"""Figures of adhesive contacts that are sheared without slip: tangential force and contact radius over the shift."""

from __future__ import annotations

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.presentation.plot.adhesion import adhesive_fields, draw_tensile_pressure
from pymdr.presentation.plot.section import section, section_into


def sheared_overview(data: draw.FigureData) -> draw.Figure:
    """The contact in section, its tangential force and radius over the shift, and its pressure, in one figure."""
    with draw.new_figure(10.4, 6.6) as figure:
        if data.field is None:
            section_into(figure, data)
            return figure
        left, right = np.ravel(np.asarray(figure.subfigures(1, 2, width_ratios=(1.2, 1.0))))
        section_into(left, data)
        force, radius, pressure = right.subplots(3, 1)
        _draw(force, data, "tangential_force")
        _draw(radius, data, "contact_radius")
        draw_tensile_pressure(pressure, data)
    return figure


def sheared_figures(data: draw.FigureData) -> dict[str, draw.Figure]:
    """``section``, ``shear`` and ``fields``."""
    with draw.new_figure(9.6, 3.8) as shear:
        left, right = shear.subplots(1, 2)
        _draw(left, data, "tangential_force")
        _draw(right, data, "contact_radius")
    return {"section": section(data), "shear": shear, "fields": adhesive_fields(data)}


def _draw(axes: draw.Axes, data: draw.FigureData, name: str) -> None:
    """A quantity over the shift; the drawn row and the last one before slip are marked."""
    (u, u_unit), (y, unit) = draw.column(data, "shift"), draw.column(data, name)
    axes.plot(u, y, color=draw.BLUE, lw=1.5, marker="o" if u.size <= draw.MARKED_ROWS else None, ms=2.5)
    ends = np.flatnonzero(np.isfinite(y[:-1]) & np.isnan(y[1:]))
    for k, row in enumerate(ends):
        axes.plot(
            u[[row]], y[[row]], "x", color=draw.ORANGE, ms=8, mew=2, label="before slip" if k == 0 else None
        )
    if data.row >= 0:
        label = draw.row_name(data, data.row)
        axes.plot(u[[data.row]], y[[data.row]], "o", color=draw.GREY, ms=6, label=label, zorder=3)
    draw.draw_zero(axes)
    axes.set(xlabel=draw.axis_label("shift", u_unit), ylabel=draw.axis_label(name, unit))
    draw.legend_above(axes)
