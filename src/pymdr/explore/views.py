"""Bokeh figures whose data are replaced while one drags."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from bokeh.models import ColorBar, ColumnDataSource, HoverTool, LinearColorMapper
from bokeh.plotting import figure

from pymdr.explore.seen import Chart, Picture, Row

_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
"""Okabe and Ito's colours, distinct for colour-blind readers."""
_HEIGHT = 260
_LEVELS = {"exact": "#007a5a", "approximate": "#8a6100", "not valid": "#b54500"}
_TOOLS = "pan,wheel_zoom,box_zoom,save,reset"


@dataclass(frozen=True)
class Plot:
    """A figure with the data that it shows."""

    figure: figure
    lines: ColumnDataSource
    marks: ColumnDataSource


@dataclass(frozen=True)
class Image:
    """A figure of a stress in section, with its data and colours."""

    figure: figure
    source: ColumnDataSource
    colours: LinearColorMapper


def columns_of(chart: Chart) -> tuple[dict[str, list[object]], dict[str, object]]:
    """The columns of the lines and marks of a chart, nan where there is no value."""
    traces = chart.traces
    lines: dict[str, list[object]] = {
        "xs": [trace.x for trace in traces],
        "ys": [trace.y for trace in traces],
        "name": [trace.name for trace in traces],
        "colour": [_COLOURS[i % len(_COLOURS)] for i in range(len(traces))],
        "dash": ["dashed" if trace.dashed else "solid" for trace in traces],
    }
    return lines, {"x": chart.marks[0], "y": chart.marks[1]}


def new_plot(label: str, *, legend: bool = False) -> Plot:
    """An empty figure of lines, as wide as there is room."""
    plot = figure(height=_HEIGHT, sizing_mode="stretch_width", min_width=280, tools=_TOOLS, title=label)
    plot.toolbar.autohide = True
    lines, marks = columns_of(Chart("", "", ()))
    source, marked = ColumnDataSource(data=lines), ColumnDataSource(data=marks)
    shown = {"legend_field": "name"} if legend else {}
    drawn = plot.multi_line(
        "xs", "ys", line_color="colour", line_dash="dash", line_width=2, source=source, **shown
    )
    plot.scatter("x", "y", size=9, fill_color=_COLOURS[1], line_color=None, source=marked)
    plot.add_tools(
        HoverTool(renderers=[drawn], tooltips=[("", "@name"), ("x", "$x{0.0000}"), ("y", "$y{0.0000}")])
    )
    if legend:
        plot.legend.orientation, plot.legend.border_line_alpha = "horizontal", 0.0
        plot.legend.label_text_font_size = "9pt"
        plot.add_layout(plot.legend[0], "below")
    return Plot(plot, source, marked)


def show_chart(plot: Plot, chart: Chart) -> None:
    """Replace what a figure shows."""
    lines, marks = columns_of(chart)
    plot.lines.data, plot.marks.data = lines, marks
    plot.figure.xaxis.axis_label, plot.figure.yaxis.axis_label = chart.x_label, chart.y_label


def new_image(label: str) -> Image:
    """An empty figure of a stress in section, the surface above."""
    plot = figure(height=_HEIGHT, sizing_mode="stretch_width", min_width=280, tools=_TOOLS, title=label)
    plot.toolbar.autohide = True
    colours = LinearColorMapper(palette="Viridis256", low=0.0, high=1.0, nan_color="#888888")
    source = ColumnDataSource(data=image_of(None))
    plot.image("image", "x", "y", "dw", "dh", source=source, color_mapper=colours)
    plot.add_layout(ColorBar(color_mapper=colours), "right")
    plot.x_range.range_padding = plot.y_range.range_padding = 0
    return Image(plot, source, colours)


def image_of(picture: Picture | None) -> dict[str, list[object]]:
    """The columns of a picture, its lowest row first; none without a picture."""
    if picture is None:
        return {"image": [], "x": [], "y": [], "dw": [], "dh": []}
    return {
        "image": [np.ascontiguousarray(picture.values[::-1])],
        "x": [-picture.half_width],
        "y": [-picture.depth],
        "dw": [2.0 * picture.half_width],
        "dh": [picture.depth],
    }


def show_picture(image: Image, picture: Picture | None, label: str, reason: str = "") -> None:
    """Replace the stress that a figure shows, or say why there is none."""
    image.source.data = image_of(picture)
    image.figure.title.text = label if picture is None else f"{label} ({picture.unit})"
    if picture is None:
        image.figure.title.text = f"{label}: {reason}"[:120]
        return
    image.colours.low, image.colours.high = (float(end(picture.values)) for end in (np.nanmin, np.nanmax))
    image.figure.xaxis.axis_label = f"radius ({picture.length_unit})"
    image.figure.yaxis.axis_label = f"height ({picture.length_unit})"


def numbers_html(caption: str, rows: Sequence[Row]) -> str:
    """The quantities of a row with their claims, as a table with headings for screen readers."""
    head = "".join(f"<th scope='col'>{name}</th>" for name in ("quantity", "value", "claim", "error"))
    body = "".join(
        f"<tr><th scope='row'>{escape(name)}</th><td>{escape(value)}</td>"
        f"<td title='{escape(reason, quote=True)}' style='color:{_LEVELS[level]};font-weight:600'>{escape(level)}</td>"
        f"<td>{escape(error)}</td></tr>"
        for name, value, level, error, reason in rows
    )
    reasons = "".join(f"<li>{escape(text)}</li>" for text in dict.fromkeys(row[4] for row in rows))
    return (
        f"<table class='numbers'><caption>{escape(caption)}</caption><thead><tr>{head}</tr></thead>"
        f"<tbody>{body}</tbody></table><details><summary>Reasons of the claims</summary><ul>{reasons}</ul></details>"
    )
