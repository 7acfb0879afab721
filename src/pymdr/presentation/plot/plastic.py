"""Figures of bodies that yield: loading and unloading, and the history of the residual indentation and the energies."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.presentation.plot.curves import curves
from pymdr.quantities import QUANTITIES
from pymdr.units import FloatArray, good_unit

_Curve = tuple[FloatArray, FloatArray]


@dataclass(frozen=True, eq=False)
class PlasticData:
    """Curves of a ball that yields: indentations in m and forces in N."""

    loading: _Curve
    """First loading."""
    unloading: _Curve
    """Unloading from the largest indentation."""
    elastic: _Curve
    """Without yield."""
    yield_depth: float
    """Indentation in m of first yield."""
    own_curves: bool
    """Whether the rows follow these curves; they do not with adhesion or a growing apparent radius."""


def plastic_overview(data: draw.FigureData, drawn: PlasticData) -> draw.Figure:
    """Force against indentation, contact radius, and the history of residual indentation and energies."""
    with draw.new_figure(10.0, 6.0) as figure:
        left, right = np.ravel(np.asarray(figure.subfigures(1, 2, width_ratios=(1.25, 1.0))))
        draw_force(left.subplots(), data, drawn)
        depth, energy = right.subplots(2, 1)
        draw_depths(depth, data)
        draw_energies(energy, data)
    return figure


def plastic_figures(data: draw.FigureData, drawn: PlasticData) -> dict[str, draw.Figure]:
    """``force``, ``curves`` and ``history``."""
    with draw.new_figure(5.6, 4.4) as force:
        draw_force(force.subplots(), data, drawn)
    with draw.new_figure(9.6, 3.4) as history:
        depth, energy = history.subplots(1, 2)
        draw_depths(depth, data)
        draw_energies(energy, data)
    return {"force": force, "curves": curves(data), "history": history}


def draw_force(axes: draw.Axes, data: draw.FigureData, drawn: PlasticData) -> None:
    """The rows of the path, coloured by yielding, between the curves of loading and unloading."""
    d, force = data.data["indentation"].values, data.data["normal_force"].values
    yields = data.data["yielding"].values > 0.0
    d_unit = good_unit(np.append(d, drawn.loading[0]), "m")
    f_unit = good_unit(np.append(force, drawn.loading[1]), "N")

    def curve(points: _Curve) -> _Curve:
        return draw.lengths(points[0], d_unit), draw.scaled(points[1], "normal_force", f_unit)

    axes.plot(*curve(drawn.elastic), color=draw.GREY, lw=1.0, ls=":", label="without yield")
    if drawn.own_curves:
        axes.plot(*curve(drawn.loading), color=draw.ORANGE, lw=1.0, label="first loading")
        axes.plot(*curve(drawn.unloading), color=draw.BLUE, lw=1.0, label="unloading and reloading")
    else:
        axes.plot(*draw.thinned_curve(*curve((d, force))), color=draw.BLUE, lw=0.8)
    for rows, colour, label in ((yields, draw.ORANGE, "yielding"), (~yields, draw.BLUE, "elastic")):
        if rows.any():
            axes.plot(*curve((d[rows], force[rows])), "o", ms=3, color=colour, label=label)
    if math.isfinite(drawn.yield_depth) and drawn.yield_depth < float(np.max(drawn.loading[0], initial=0.0)):
        at = float(draw.lengths(np.array(drawn.yield_depth), d_unit))
        axes.axvline(at, color=draw.GREY, lw=0.8, ls="--", label="first yield")
    # the elastic force may be many times that of the path
    high = max(float(np.nanmax(force, initial=0.0)), float(np.max(drawn.loading[1])))
    low = float(np.nanmin(force, initial=0.0))
    if high > 0.0:
        top, bottom = draw.scaled(np.array([1.15 * high, low - 0.05 * (high - low)]), "normal_force", f_unit)
        axes.set_ylim(float(bottom), float(top))
    axes.set(xlabel=draw.axis_label("indentation", d_unit), ylabel=draw.axis_label("normal_force", f_unit))
    draw.draw_zero(axes)
    draw.legend_above(axes)


def draw_depths(axes: draw.Axes, data: draw.FigureData) -> None:
    """Indentation and residual indentation along the path."""
    x, label = draw.along_history(data)
    names = {"indentation": draw.BLUE, "residual_indentation": draw.ORANGE}
    unit = good_unit(np.concatenate([data.data[name].values for name in names]), "m")
    for name, colour in names.items():
        y = draw.lengths(data.data[name].values, unit)
        axes.plot(x, y, color=colour, lw=1.5, label=QUANTITIES[name].long_name)
    axes.set_ylabel(draw.with_unit("indentation", unit))
    draw.label_history(axes, label)
    draw.draw_zero(axes)
    draw.legend_above(axes)


def draw_energies(axes: draw.Axes, data: draw.FigureData) -> None:
    """Elastic and dissipated energy along the path."""
    x, label = draw.along_history(data)
    names = {"elastic_energy": draw.GREEN, "dissipated_energy": draw.ORANGE}
    unit = good_unit(np.concatenate([data.data[name].values for name in names]), "J")
    for name, colour in names.items():
        values = draw.scaled(data.data[name].values, name, unit)
        axes.plot(x, values, color=colour, lw=1.5, label=QUANTITIES[name].long_name)
    axes.set_ylabel(draw.with_unit("energy", unit))
    draw.label_history(axes, label)
    draw.draw_zero(axes)
    draw.legend_above(axes)
