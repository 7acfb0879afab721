"""Figures of contacts given by a force curve: its points, its line, and the solved path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import POSITION
from pymdr.units import FloatArray, good_unit


@dataclass(frozen=True, eq=False)
class CurveData:
    """A force curve for the bodies of the contact, in SI units."""

    points: tuple[FloatArray, FloatArray]
    """Indentations and forces of the data."""
    depth: FloatArray
    """Indentations of the fit."""
    force: FloatArray
    stiffness: FloatArray
    line: tuple[FloatArray, FloatArray]
    """Positions x and g(x) in m."""
    modulus: float
    """E* in Pa of the drawn forces."""
    is_viscoelastic: bool
    """Whether the bodies are viscoelastic, so that rows deviate from the curve."""


def closure_overview(data: draw.FigureData, curve: CurveData) -> draw.Figure:
    """The force curve with its points, its stiffness, its line, and the solved path."""
    with draw.new_figure(9.6, 6.4) as figure:
        force, stiffness, line, solved = figure.subplots(2, 2).ravel()
        draw_points(force, data, curve)
        draw_stiffness(stiffness, curve)
        draw_line(line, curve)
        draw_solved(solved, data)
    return figure


def closure_figures(data: draw.FigureData, curve: CurveData) -> dict[str, draw.Figure]:
    """``curve``, ``line`` and ``history``."""
    with draw.new_figure(9.6, 3.4) as first:
        force, stiffness = first.subplots(1, 2)
        draw_points(force, data, curve)
        draw_stiffness(stiffness, curve)
    with draw.new_figure(4.8, 3.4) as second, draw.new_figure(4.8, 3.4) as third:
        draw_line(second.subplots(), curve)
        draw_solved(third.subplots(), data)
    return {"curve": first, "line": second, "history": third}


def draw_points(axes: draw.Axes, data: draw.FigureData, curve: CurveData) -> None:
    """Points, the curve through them, and the rows."""
    d_unit, f_unit = good_unit(curve.depth, "m"), good_unit(curve.force, "N")
    d, force = curve.points
    x, y = draw.lengths(d, d_unit), draw.scaled(force, "normal_force", f_unit)
    axes.plot(x, y, ".", ms=3, color=draw.GREY, alpha=0.6, zorder=3, label="data")
    x, y = draw.lengths(curve.depth, d_unit), draw.scaled(curve.force, "normal_force", f_unit)
    axes.plot(x, y, color=draw.BLUE, lw=1.5, label="curve through them")
    if not curve.is_viscoelastic:
        d, force = data.data["indentation"].values, data.data["normal_force"].values
        rows = draw.thinned_curve(draw.lengths(d, d_unit), draw.scaled(force, "normal_force", f_unit))
        axes.plot(*rows, ".", ms=6, color=draw.ORANGE, label="this path")
    axes.annotate(
        f"$E^*$ = {draw.typeset(curve.modulus, 'Pa')}",
        (0.05, 0.88),
        xycoords="axes fraction",
        color=draw.GREY,
    )
    axes.set(xlabel=draw.axis_label("indentation", d_unit), ylabel=draw.axis_label("normal_force", f_unit))
    draw.draw_zero(axes)
    draw.legend_above(axes)


def draw_stiffness(axes: draw.Axes, curve: CurveData) -> None:
    """The stiffness, which does not decrease."""
    d_unit, k_unit = good_unit(curve.depth, "m"), good_unit(curve.stiffness, "N/m")
    x, y = draw.lengths(curve.depth, d_unit), draw.scaled(curve.stiffness, "normal_stiffness", k_unit)
    axes.plot(x, y, color=draw.BLUE, lw=1.5)
    axes.set_xlabel(draw.axis_label("indentation", d_unit))
    axes.set_ylabel(draw.axis_label("normal_stiffness", k_unit))
    draw.begin_at_zero(axes)


def draw_line(axes: draw.Axes, curve: CurveData) -> None:
    """The line, which is not a picture of the contact."""
    x, g = curve.line
    x_unit, g_unit = good_unit(x, "m"), good_unit(g, "m")
    both = np.append(-x[::-1], x), np.append(g[::-1], g)
    axes.plot(draw.lengths(both[0], x_unit), draw.lengths(both[1], g_unit), color=draw.GREEN, lw=1.5)
    axes.set_title("line from a curve, not a picture of the contact", color=draw.GREY)
    axes.set(xlabel=f"{POSITION.label} ({x_unit})", ylabel=draw.axis_label("equivalent_profile", g_unit))


def draw_solved(axes: draw.Axes, data: draw.FigureData) -> None:
    """Tangential force over shift, or force over the history."""
    if "tangential_force" in data.data and np.ptp(np.nan_to_num(data.data["shift"].values)) > 0.0:
        across, name = "shift", "tangential_force"
        unit = good_unit(data.data[across].values, "m")
        x = draw.lengths(data.data[across].values, unit)
        axes.set_xlabel(draw.axis_label(across, unit))
    else:
        name = "normal_force"
        x, label = draw.along_history(data)
        draw.label_history(axes, label)
    unit = good_unit(data.data[name].values, "N")
    axes.plot(
        *draw.thinned_curve(np.asarray(x), draw.scaled(data.data[name].values, name, unit)),
        color=draw.ORANGE,
        lw=1.5,
    )
    axes.set_ylabel(draw.axis_label(name, unit))
    draw.draw_zero(axes)
