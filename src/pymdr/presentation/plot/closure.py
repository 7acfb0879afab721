"""Figures of contacts given by a force curve: its points, its line, and the solved path."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from pymdr.presentation.plot.shared import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    FigureData,
    along_history,
    axis_label,
    draw_zero,
    label_history,
    legend_above,
    lengths,
    letter_panels,
    new_figure,
    scaled,
    styled,
    thinned_curve,
    typeset,
)
from pymdr.quantities import POSITION
from pymdr.units import FloatArray, good_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Drawn = TypeVar("Drawn")


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

    def drawn_by(self, draw: Callable[[FigureData, CurveData], Drawn]) -> Callable[[FigureData], Drawn]:
        """A figure of this curve and the data of a result."""
        return lambda data: draw(data, self)


def closure_overview(data: FigureData, curve: CurveData) -> Figure:
    """The force curve with its points, its stiffness, its line, and the solved path."""
    with styled():
        figure = new_figure(9.6, 6.4)
        force, stiffness, line, solved = figure.subplots(2, 2).ravel()
        draw_points(force, data, curve)
        draw_stiffness(stiffness, curve)
        draw_line(line, curve)
        draw_solved(solved, data)
        letter_panels(figure)
    return figure


def closure_figures(data: FigureData, curve: CurveData) -> dict[str, Figure]:
    """``curve``, ``line`` and ``history``."""
    with styled():
        first = new_figure(9.6, 3.4)
        force, stiffness = first.subplots(1, 2)
        draw_points(force, data, curve)
        draw_stiffness(stiffness, curve)
        letter_panels(first)
        second, third = new_figure(4.8, 3.4), new_figure(4.8, 3.4)
        draw_line(second.subplots(), curve)
        draw_solved(third.subplots(), data)
    return {"curve": first, "line": second, "history": third}


def draw_points(axes: Axes, data: FigureData, curve: CurveData) -> None:
    """Points, the curve through them, and the rows."""
    d_unit, f_unit = good_unit(curve.depth, "m"), good_unit(curve.force, "N")
    d, force = curve.points
    axes.plot(
        lengths(d, d_unit),
        scaled(force, "normal_force", f_unit),
        ".",
        ms=3,
        color=GREY,
        alpha=0.6,
        zorder=3,
        label="data",
    )
    axes.plot(
        lengths(curve.depth, d_unit),
        scaled(curve.force, "normal_force", f_unit),
        color=BLUE,
        lw=1.5,
        label="curve through them",
    )
    if not curve.is_viscoelastic:
        d, force = data.data["indentation"].values, data.data["normal_force"].values
        axes.plot(
            *thinned_curve(lengths(d, d_unit), scaled(force, "normal_force", f_unit)),
            ".",
            ms=6,
            color=ORANGE,
            label="this path",
        )
    axes.annotate(
        f"$E^*$ = {typeset(curve.modulus, 'Pa')}", (0.05, 0.88), xycoords="axes fraction", color=GREY
    )
    axes.set_xlabel(axis_label("indentation", d_unit))
    axes.set_ylabel(axis_label("normal_force", f_unit))
    draw_zero(axes)
    legend_above(axes)


def draw_stiffness(axes: Axes, curve: CurveData) -> None:
    """The stiffness, which does not decrease."""
    d_unit, k_unit = good_unit(curve.depth, "m"), good_unit(curve.stiffness, "N/m")
    axes.plot(
        lengths(curve.depth, d_unit), scaled(curve.stiffness, "normal_stiffness", k_unit), color=BLUE, lw=1.5
    )
    axes.set_xlabel(axis_label("indentation", d_unit))
    axes.set_ylabel(axis_label("normal_stiffness", k_unit))
    axes.set_ylim(bottom=0.0)


def draw_line(axes: Axes, curve: CurveData) -> None:
    """The line, which is not a picture of the contact."""
    x, g = curve.line
    x_unit, g_unit = good_unit(x, "m"), good_unit(g, "m")
    both = np.append(-x[::-1], x), np.append(g[::-1], g)
    axes.plot(lengths(both[0], x_unit), lengths(both[1], g_unit), color=GREEN, lw=1.5)
    axes.set_title("line from a curve, not a picture of the contact", color=GREY)
    axes.set_xlabel(f"{POSITION.label} ({x_unit})")
    axes.set_ylabel(axis_label("equivalent_profile", g_unit))


def draw_solved(axes: Axes, data: FigureData) -> None:
    """Tangential force over shift, or force over the history."""
    if "tangential_force" in data.data and np.ptp(np.nan_to_num(data.data["shift"].values)) > 0.0:
        across, name = "shift", "tangential_force"
        unit = good_unit(data.data[across].values, "m")
        x = lengths(data.data[across].values, unit)
        axes.set_xlabel(axis_label(across, unit))
    else:
        name = "normal_force"
        x, label = along_history(data)
        label_history(axes, label)
    unit = good_unit(data.data[name].values, "N")
    axes.plot(*thinned_curve(np.asarray(x), scaled(data.data[name].values, name, unit)), color=ORANGE, lw=1.5)
    axes.set_ylabel(axis_label(name, unit))
    draw_zero(axes)
