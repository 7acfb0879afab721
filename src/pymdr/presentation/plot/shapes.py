"""Figures of bodies without axial symmetry: force with bound and estimate, and the contact in plan."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from pymdr.presentation.plot.shared import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    SMALL,
    FigureData,
    axis_label,
    draw_zero,
    legend_above,
    lengths,
    letter_panels,
    new_figure,
    scaled,
    styled,
    thinned_curve,
)
from pymdr.units import FloatArray, good_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Drawn = TypeVar("Drawn")
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

    def drawn_by(self, draw: Callable[[FigureData, ShapeData], Drawn]) -> Callable[[FigureData], Drawn]:
        """A figure of this shape and the data of a result."""
        return lambda data: draw(data, self)


def shape_overview(data: FigureData, shape: ShapeData) -> Figure:
    """Force and plan; for an ellipse also the pressure along its axes."""
    with styled():
        panels = 2 if shape.across is None else 3
        figure = new_figure(4.6 * panels, 3.8)
        axes = figure.subplots(1, panels)
        draw_force(axes[0], data, shape)
        draw_plan(axes[1], shape)
        if panels == 3:
            draw_pressures(axes[2], data, shape)
        letter_panels(figure)
    return figure


def shape_figures(data: FigureData, shape: ShapeData) -> dict[str, Figure]:
    """``force`` and ``plan``; for an ellipse also ``pressure``."""
    with styled():
        first, second = new_figure(4.8, 3.8), new_figure(4.8, 4.2)
        draw_force(first.subplots(), data, shape)
        draw_plan(second.subplots(), shape)
        figures = {"force": first, "plan": second}
        if shape.across is not None:
            figures["pressure"] = new_figure(4.8, 3.6)
            draw_pressures(figures["pressure"].subplots(), data, shape)
    return figures


def draw_force(axes: Axes, data: FigureData, shape: ShapeData) -> None:
    """Force over indentation, its lower bound, its estimate, and the rows."""
    d_unit = good_unit(shape.depth, "m")
    f_unit = good_unit(np.append(shape.force[np.isfinite(shape.force)], shape.bound), "N")
    d = lengths(shape.depth, d_unit)
    curves = [("lower bound", shape.bound, GREEN, "-."), ("estimate", shape.estimate, ORANGE, "--")]
    if shape.source:
        curves.append((shape.source, shape.force, BLUE, "-"))
    for label, force, colour, line in curves:
        if np.isfinite(force).any():
            axes.plot(d, scaled(force, "normal_force", f_unit), line, color=colour, lw=1.5, label=label)
    if "normal_force" in data.data and "indentation" in data.data:
        rows = (
            lengths(data.data["indentation"].values, d_unit),
            scaled(data.data["normal_force"].values, "normal_force", f_unit),
        )
        axes.plot(*thinned_curve(*rows), ".", ms=5, color=GREY, label="this path")
    axes.set_xlabel(axis_label("indentation", d_unit))
    axes.set_ylabel(axis_label("normal_force", f_unit))
    draw_zero(axes)
    legend_above(axes)


def draw_plan(axes: Axes, shape: ShapeData) -> None:
    """Contours of the gap, the known outline of the contact, and the trial area of the lower bound."""
    from matplotlib.patches import Ellipse

    side = shape.extent or 1.0
    unit = good_unit(np.array([side]), "m")
    x = np.linspace(-side, side, _PIXELS)
    gap = shape.gap(x[:, None], x[None, :]).T
    at, width = lengths(x, unit), float(lengths(np.array([1.0]), unit)[0])
    if shape.level > 0.0:
        levels = shape.level * np.arange(1, _LEVELS) / 3.0
        axes.contour(at, at, np.ma.masked_invalid(gap), levels=levels, colors=GREY, linewidths=0.6)
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
                color=GREEN,
                lw=1.5,
                label=f"{'disk' if longer == shorter else 'ellipse'} of the bound",
            )
        )
    if shape.axes is not None and min(shape.axes) > 0.0:
        a_x, a_y = (2.0 * a * width for a in shape.axes)
        axes.add_patch(Ellipse((0, 0), a_x, a_y, color=BLUE, alpha=0.35, lw=0.0, label="contact"))
    axes.set_aspect("equal")
    axes.set_xlabel(f"$x$ ({unit})")
    axes.set_ylabel(f"$y$ ({unit})")
    axes.annotate(
        "contours of the gap, every $d$/3",
        (0.03, 0.03),
        xycoords="axes fraction",
        color=GREY,
        fontsize=SMALL,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5},
    )
    legend_above(axes)


def draw_pressures(axes: Axes, data: FigureData, shape: ShapeData) -> None:
    """The pressure along both axes of the ellipse."""
    assert data.field is not None
    assert shape.across is not None
    along, across = data.field("pressure", None), shape.across(None)
    longest = max(shape.axes or (0.0,)) or float(along["r"].values[-1])
    unit, p_unit = good_unit(np.array([longest]), "m"), good_unit(along.values, "Pa")
    for label, p, colour in (("along $x$", along, BLUE), ("along $y$", across, ORANGE)):
        r = p["r"].values
        axes.plot(lengths(r, unit), scaled(p.values, "pressure", p_unit), color=colour, lw=1.5, label=label)
    axes.set_xlim(0.0, 1.2 * float(lengths(np.array([longest]), unit)[0]))
    axes.set_xlabel(axis_label("r", unit))
    axes.set_ylabel(axis_label("pressure", p_unit))
    draw_zero(axes)
    legend_above(axes)
