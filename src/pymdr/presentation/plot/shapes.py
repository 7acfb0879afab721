"""Figures of bodies without axial symmetry: force with bound and estimate, and the contact in plan."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from pymdr.presentation.plot import shared as draw
from pymdr.units import FloatArray, good_unit

if TYPE_CHECKING:
    import xarray as xr

_PIXELS = 161
_LEVELS = 9


@dataclass(frozen=True, eq=False)
class ShapeData:
    """A shape as it is drawn, in SI units."""

    depth: FloatArray
    """Indentations of the curves."""
    force: FloatArray
    bound: FloatArray
    estimate: FloatArray
    """Forces at these indentations in N, nan where not known."""
    source: str
    """Where a force that is no estimate comes from; empty if there is none."""
    gap: Callable[[ArrayLike, ArrayLike], FloatArray]
    """f(x, y)."""
    level: float
    """Indentation in m of the plan."""
    trial: tuple[float, float, float, float, float]
    """Trial area of the lower bound in the plan: centre x, y, semi-axes, and direction of the first in rad."""
    axes: tuple[float, float] | None
    """Semi-axes of an elliptic contact in the plan."""
    extent: float
    """Half side length of the plan in m."""
    across: Callable[[FloatArray | None], xr.DataArray] | None = None
    """Pressure along y; None if the contact is not elliptic."""


def shape_overview(data: draw.FigureData, shape: ShapeData) -> draw.Figure:
    """Force and plan; for an ellipse also the pressure along its axes."""
    panels = 2 if shape.across is None else 3
    with draw.new_figure(4.6 * panels, 3.8) as figure:
        axes = figure.subplots(1, panels)
        draw_force(axes[0], data, shape)
        draw_plan(axes[1], shape)
        if panels == 3:
            draw_pressures(axes[2], data, shape)
    return figure


def shape_figures(data: draw.FigureData, shape: ShapeData) -> dict[str, draw.Figure]:
    """``force`` and ``plan``; for an ellipse also ``pressure``."""
    with draw.new_figure(4.8, 3.8) as first, draw.new_figure(4.8, 4.2) as second:
        draw_force(first.subplots(), data, shape)
        draw_plan(second.subplots(), shape)
    figures = {"force": first, "plan": second}
    if shape.across is not None:
        with draw.new_figure(4.8, 3.6) as figures["pressure"]:
            draw_pressures(figures["pressure"].subplots(), data, shape)
    return figures


def draw_force(axes: draw.Axes, data: draw.FigureData, shape: ShapeData) -> None:
    """Force over indentation, its lower bound, its estimate, and the rows."""
    d_unit = good_unit(shape.depth, "m")
    f_unit = good_unit(np.append(shape.force[np.isfinite(shape.force)], shape.bound), "N")
    d = draw.lengths(shape.depth, d_unit)
    curves = [("lower bound", shape.bound, draw.GREEN, "-."), ("estimate", shape.estimate, draw.ORANGE, "--")]
    if shape.source:
        curves.append((shape.source, shape.force, draw.BLUE, "-"))
    for label, force, colour, line in curves:
        if np.isfinite(force).any():
            axes.plot(d, draw.scaled(force, "normal_force", f_unit), line, color=colour, lw=1.5, label=label)
    if "normal_force" in data.data and "indentation" in data.data:
        rows = (
            draw.lengths(data.data["indentation"].values, d_unit),
            draw.scaled(data.data["normal_force"].values, "normal_force", f_unit),
        )
        axes.plot(*draw.thinned_curve(*rows), ".", ms=5, color=draw.GREY, label="this path")
    axes.set(xlabel=draw.axis_label("indentation", d_unit), ylabel=draw.axis_label("normal_force", f_unit))
    draw.draw_zero(axes)
    draw.legend_above(axes)


def draw_plan(axes: draw.Axes, shape: ShapeData) -> None:
    """Contours of the gap, the known outline of the contact, and the trial area of the lower bound."""
    from matplotlib.patches import Ellipse

    side = shape.extent or 1.0
    unit = good_unit(np.array([side]), "m")
    x = np.linspace(-side, side, _PIXELS)
    gap = shape.gap(x[:, None], x[None, :]).T
    at, width = draw.lengths(x, unit), float(draw.lengths(np.array([1.0]), unit)[0])
    if shape.level > 0.0:
        levels = shape.level * np.arange(1, _LEVELS) / 3.0
        axes.contour(at, at, np.ma.masked_invalid(gap), levels=levels, colors=draw.GREY, linewidths=0.6)
    centre_x, centre_y, longer, shorter = (width * one for one in shape.trial[:4])
    if longer > 0.0:
        axes.add_patch(
            Ellipse(
                (centre_x, centre_y),
                2.0 * longer,
                2.0 * shorter,
                angle=math.degrees(shape.trial[4]),
                fill=False,
                ls="-.",
                color=draw.GREEN,
                lw=1.5,
                label=f"{'disk' if longer == shorter else 'ellipse'} of the bound",
            )
        )
    if shape.axes is not None and min(shape.axes) > 0.0:
        a_x, a_y = (2.0 * a * width for a in shape.axes)
        axes.add_patch(Ellipse((0, 0), a_x, a_y, color=draw.BLUE, alpha=0.35, lw=0.0, label="contact"))
    axes.set_aspect("equal")
    axes.set(xlabel=f"$x$ ({unit})", ylabel=f"$y$ ({unit})")
    axes.annotate(
        "contours of the gap, every $d$/3",
        (0.03, 0.03),
        xycoords="axes fraction",
        color=draw.GREY,
        fontsize=draw.SMALL,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5},
    )
    draw.legend_above(axes)


def draw_pressures(axes: draw.Axes, data: draw.FigureData, shape: ShapeData) -> None:
    """The pressure along both axes of the ellipse."""
    assert data.field is not None
    assert shape.across is not None
    along, across = data.field("pressure", None), shape.across(None)
    longest = max(shape.axes or (0.0,)) or float(along["r"].values[-1])
    unit, p_unit = good_unit(np.array([longest]), "m"), good_unit(along.values, "Pa")
    for label, p, colour in (("along $x$", along, draw.BLUE), ("along $y$", across, draw.ORANGE)):
        r = p["r"].values
        x, y = draw.lengths(r, unit), draw.scaled(p.values, "pressure", p_unit)
        axes.plot(x, y, color=colour, lw=1.5, label=label)
    axes.set_xlim(0.0, 1.2 * float(draw.lengths(np.array([longest]), unit)[0]))
    axes.set(xlabel=draw.axis_label("r", unit), ylabel=draw.axis_label("pressure", p_unit))
    draw.draw_zero(axes)
    draw.legend_above(axes)
