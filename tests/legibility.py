"""What a reader cannot read in a figure."""

import contextlib
import itertools
import re

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.category import StrCategoryFormatter
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

SLACK = 1.5
"""Pixels by which texts may leave the canvas or overlap: the rounding of glyphs."""
ROUNDING = 1e-12
"""Largest relative error that may be of rounding only."""
NUMBERS = {
    "row of the path",
    "tangential over normal force $Q/F$",
    "peak pressure over yield stress in shear $p_0/k$",
    "step",
    "sample",
    "curve",
    "indent",
    "cycle",
    "damping",
    "damping ratio",
    "layer over half-space",
    "fraction of the force",
    "fraction of the indents",
    "number of cycles",
    "largest $F_x/F_N$",
    "contact radius over thickness $a/t$",
    "relative difference from solve",
    "claimed relative error",
    "actual relative error",
    "creepage $\\zeta$",
    "coefficient of restitution",
    "coefficient of restitution $e$",
    "coefficient of friction $F_x/F_N$",
    "Dundurs' beta",
    "Poisson's ratio of the second body",
    "constant for steel on a 70 GPa body",
}
"""Labels of axes of numbers without unit; ratios of two symbols need no entry."""

_UNIT = re.compile(r"\([^()]+(\([^()]+\)[^()]*)?\)|\S /\s?\S")


@contextlib.contextmanager
def collected_figures():
    """All figures that are made meanwhile."""
    figures, make = [], Figure.__init__

    def remember(self, *args, **kwargs):
        make(self, *args, **kwargs)
        figures.append(self)

    Figure.__init__ = remember
    try:
        yield figures
    finally:
        Figure.__init__ = make


def faults(figure):
    """
    Texts off the canvas, texts on each other, legends on data, axes without unit, panels of rounding.

    Parameters
    ----------
    figure : matplotlib.figure.Figure

    Returns
    -------
    list of str
        A sentence for each fault.
    """
    boxes = _drawn_texts(figure)
    return [
        *_misplaced(figure, boxes),
        *_covered(figure),
        *_unlabelled(figure, boxes),
        *_rounding(figure),
        *_cut_points(figure),
        *_flattened(figure),
    ]


def _drawn_texts(figure):
    """Texts with their boxes in pixels, and the legends to which they belong."""
    boxes, draw = [], Text.draw

    def remember(self, renderer, *args, **kwargs):
        if self.get_visible() and self.get_text().strip():
            boxes.append((self, self.get_window_extent(renderer).frozen()))
        draw(self, renderer, *args, **kwargs)

    Text.draw = remember
    try:
        FigureCanvasAgg(figure).draw()
    finally:
        Text.draw = draw
    legends = {
        text: legend for legend in _legends(figure) for text in (*legend.get_texts(), legend.get_title())
    }
    return [(text, box, legends.get(text)) for text, box in boxes]


def _legends(figure):
    return [axes.get_legend() for axes in figure.axes if axes.get_legend() is not None]


def _entries(legend):
    return [text.get_text() for text in legend.get_texts()]


def _overlap(one, other):
    wide = min(one.x1, other.x1) - max(one.x0, other.x0)
    high = min(one.y1, other.y1) - max(one.y0, other.y0)
    return min(wide, high) > SLACK


def _misplaced(figure, boxes):
    canvas = figure.bbox.padded(SLACK)
    named = [(repr(text.get_text()), box, legend) for text, box, legend in boxes]
    named += [
        (f"the legend {_entries(legend)}", legend.get_window_extent(), legend) for legend in _legends(figure)
    ]
    for name, box, _ in named:
        if box.x0 < canvas.x0 or box.y0 < canvas.y0 or box.x1 > canvas.x1 or box.y1 > canvas.y1:
            yield f"{name} leaves the canvas"
    for (one, first, mine), (other, second, yours) in itertools.combinations(named, 2):
        if (mine is None or mine is not yours) and _overlap(first, second):
            yield f"{one} overlaps {other}"


def _covered(figure):
    for legend, axes in itertools.product(_legends(figure), figure.axes):
        box = Bbox.intersection(legend.get_window_extent(), axes.bbox)
        if box is None or min(box.size) <= SLACK:
            continue
        for line in axes.lines:
            points = line.get_transform().transform_path(line.get_path()).cleaned(remove_nans=True)
            joined = line.get_linestyle() != "None"
            if points.intersects_bbox(box, filled=False) if joined else box.count_contains(points.vertices):
                yield f"the legend {_entries(legend)} covers the line {line.get_label()!r}"


def _rounding(figure):
    """Panels that show nothing but errors of rounding."""
    for axes in figure.axes:
        drawn = [
            np.ma.masked_invalid(np.asarray(line.get_ydata(orig=False), dtype=float)) for line in axes.lines
        ]
        if "error" in axes.get_ylabel() and drawn and max(np.ma.max(y) for y in drawn) < ROUNDING:
            yield f"the panel {axes.get_ylabel()!r} shows rounding"


def _unlabelled(figure, boxes):
    drawn = {text for text, _, _ in boxes}
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if not axes.axison or drawn.isdisjoint(
                label for tick in axis.get_major_ticks() for label in (tick.label1, tick.label2)
            ):
                continue
            label, power = axis.label.get_text(), axis.get_offset_text().get_text()
            if power:
                yield f"the axis {label!r} has the factor {power!r}"
            if not (
                label in NUMBERS
                or _UNIT.search(label)
                or isinstance(axis.get_major_formatter(), StrCategoryFormatter)
            ):
                yield f"the axis {label!r} has no unit"
            if re.search(r"[a-z]\.[a-z]|[\^*_]", re.sub(r"\$[^$]*\$", "", label)):
                yield f"the axis {label!r} has a name of the program"


def _cut_points(figure):
    """Points of which the edge of their axes cuts a half away; axes that enlarge a part of a curve may."""
    for axes in figure.axes:
        for line in axes.lines:
            if line.get_marker() == "None" or not (line.get_clip_on() and line.get_visible()):
                continue
            half = 0.5 * line.get_markersize() * figure.dpi / 72.0
            points = line.get_transform().transform(np.asarray(line.get_xydata(), dtype=float))
            box = axes.get_window_extent()
            inside = np.minimum(points - [box.x0, box.y0], [box.x1, box.y1] - points)
            nearest = inside[np.isfinite(inside).all(axis=1)].min(axis=1)
            if nearest.size and -SLACK < nearest.min() < 0.3 * half:
                yield f"the axes {axes.get_ylabel()!r} cut points of {line.get_label()!r}"


def _flattened(figure):
    """Curves that vary, but look like a straight line because another is far larger; sections to scale may."""
    for axes in figure.axes:
        if axes.get_aspect() != "auto":
            continue
        for line in axes.lines:
            y = np.ma.masked_invalid(np.asarray(line.get_ydata(orig=False), dtype=float)).compressed()
            if (
                axes.get_yscale() == "linear"
                and y.size > 2
                and np.ptp(y) > 0.5 * np.max(np.abs(y)) > ROUNDING
            ):
                shown = line.get_transform().transform(np.column_stack([np.zeros(2), [y.min(), y.max()]]))
                if np.ptp(shown[:, 1]) < 0.01 * axes.get_window_extent().height:
                    yield f"the panel {axes.get_ylabel()!r} flattens {line.get_label()!r}"
