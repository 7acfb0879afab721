"""Figures that a notebook shows without pyplot, and a layout that measures no labels. Loads matplotlib."""

from __future__ import annotations

import io

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.layout_engine import LayoutEngine
from matplotlib.text import Text

from pymdr.units import FloatArray

_ADVANCES = {".": 0.318, "\u2212": 0.838}
"""Widths of characters of DejaVu Sans in units of its size, where they differ from those of digits."""
_ADVANCE = 0.636
"""Width of a digit of DejaVu Sans in units of its size."""
_LINE = 1.25
"""Height of a line of text in units of its size."""
_TICK, _PAD = 7.0, 4.0
"""Length of a tick with the space to its label, and space around labels of axes, in points."""
_ABOVE = 17.0
"""Space in points above a panel for its letter and for names of radii."""
_TITLE = 14.0
"""Largest space in points between a panel and its title."""
_POINTS = 72.0
"""Points per inch."""


class Drawing(Figure):
    """A figure that shows itself."""

    def _repr_png_(self) -> bytes:
        """The picture, for notebooks."""
        picture = io.BytesIO()
        self.savefig(picture, format="png", dpi=110)
        return picture.getvalue()


class EstimatedLayout(LayoutEngine):
    """
    Places the panels of one grid by the lengths of their labels.

    The other layouts of matplotlib measure every label several times, which takes longer than to draw the figure.
    """

    adjust_compatible = True
    colorbar_gridspec = True

    def execute(self, fig: Figure) -> None:
        """Set the margins of the figure and the spaces between its panels."""
        panels = [(axes, axes.get_subplotspec()) for axes in fig.axes]
        rows, columns = next((place.get_gridspec().get_geometry() for _, place in panels if place), (1, 1))
        left, right, bottom, top = np.zeros(columns), np.zeros(columns), np.zeros(rows), np.zeros(rows)
        for axes, place in panels:
            if place is None:
                continue
            edges = _edges(axes)
            for margins, at, edge in (
                (left, place.colspan.start, edges[0]),
                (right, place.colspan.stop - 1, edges[1]),
                (bottom, place.rowspan.stop - 1, edges[2]),
                (top, place.rowspan.start, edges[3]),
            ):
                margins[at] = max(margins[at], edge)
        width, height = _POINTS * fig.get_size_inches()
        low, high, wspace = _along(left, right, width)
        floor, ceiling, hspace = _along(bottom[::-1], top[::-1], height)
        fig.subplots_adjust(low, floor, high, ceiling, wspace, hspace)


def _along(before: FloatArray, after: FloatArray, size: float) -> tuple[float, float, float]:
    """First and last fraction of a size that panels take, and the space between them in units of their mean size."""
    count = before.size
    between = float(np.max(before[1:] + after[:-1], initial=0.0)) + 2.0 * _PAD
    first, last = float(before[0]) + _PAD, size - float(after[-1]) - _PAD
    mean = (last - first - (count - 1) * between) / count
    return first / size, last / size, between / mean


def _edges(axes: Axes) -> tuple[float, float, float, float]:
    """Space in points that the labels of axes take at the left, at the right, below and above."""
    sides = {"left": 0.0, "right": 0.0, "bottom": 0.0, "top": 0.0}
    if axes.axison:
        for axis in (axes.xaxis, axes.yaxis):
            sides[axis.get_label_position()] = _thickness(axis)
        sides["top"] = _ABOVE
    elif axes.xaxis.label.get_text():
        sides["bottom"] = _height(axes.xaxis.label)
    if axes.title.get_text():
        sides["top"] = _TITLE + _height(axes.title)
    legend = axes.get_legend()
    if legend is not None and axes.figure is not None:
        sides["top"] = max(sides["top"], _PAD + legend.get_window_extent().height * _POINTS / axes.figure.dpi)
    return sides["left"], sides["right"], sides["bottom"], sides["top"]


def _thickness(axis: Axis) -> float:
    """Space in points that the ticks, numbers and label of an axis take."""
    side = axis.get_label_position()
    shown = axis.get_tick_params()
    size = 0.0
    if axis.get_visible() and shown[f"label{side}"]:
        font = float(axis.label.get_fontsize())
        size = _TICK + (_LINE * font if side in ("bottom", "top") else font * _widest(axis))
    return size + (_PAD + _height(axis.label) if axis.label.get_text() else 0.0)


def _widest(axis: Axis) -> float:
    """Width of the widest number at an axis in units of its font size."""
    low, high = sorted(axis.get_view_interval())
    places = [place for place in axis.get_majorticklocs() if low <= place <= high]
    numbers = axis.get_major_formatter().format_ticks(places)
    return max((sum(_ADVANCES.get(c, _ADVANCE) for c in number) for number in numbers), default=0.0)


def _height(text: Text) -> float:
    """Height in points of a text of one or more lines."""
    return _LINE * float(text.get_fontsize()) * (text.get_text().count("\n") + 1)
