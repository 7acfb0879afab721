"""The figures of contacts without adhesion, friction or memory."""

from __future__ import annotations

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.presentation.plot.curves import curves, draw_curve, draw_pressure, fields
from pymdr.presentation.plot.layers import layers
from pymdr.presentation.plot.section import section, section_into


def normal_overview(data: draw.FigureData) -> draw.Figure:
    """
    The contact in section above its springs, with its curve or loop and a field, in one figure.

    Returns
    -------
    matplotlib.figure.Figure
        Section, force against indentation, and pressure.
    """
    with draw.new_figure(10.0, 5.6) as figure:
        left, right = np.ravel(np.asarray(figure.subfigures(1, 2, width_ratios=(1.25, 1.0))))
        section_into(left, data)
        if data.field is None:
            draw_curve(right.subplots(), data, "normal_force")
            return figure
        force, pressure = right.subplots(2, 1)
        draw_curve(force, data, "normal_force")
        draw_pressure(pressure, data)
    return figure


def normal_figures(data: draw.FigureData) -> dict[str, draw.Figure]:
    """
    The figures of a result by name.

    Returns
    -------
    dict of str to matplotlib.figure.Figure
        ``section``, ``curves`` and ``fields``; ``layers`` of a body of layers.
    """
    own = {} if data.layers is None else {"layers": layers(data)}
    return {"section": section(data), "curves": curves(data), "fields": fields(data), **own}
