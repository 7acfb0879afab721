"""Figures of contacts with adhesion: loops with their jumps, radii, and fields with tension at the edge."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    FigureData,
    axis_label,
    good_unit,
    new_figure,
    styled,
    thinned,
)
from pymdr.presentation.text import written
from pymdr.quantities import QUANTITIES
from pymdr.units import FloatArray, from_si

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class AdhesiveFigureData:
    """What the figures of an adhesive contact are drawn from."""

    base: FigureData
    branch: Mapping[str, FloatArray]
    """The curve of all equilibria, by name of the quantity."""


def adhesive_overview(data: AdhesiveFigureData) -> Figure:
    """Force loop, contact radius and pressure in one figure."""
    with styled():
        figure = new_figure(10.0, 5.6)
        grid = figure.add_gridspec(2, 2, width_ratios=(1.3, 1.0))
        _draw_path(figure.add_subplot(grid[:, 0]), data, _against(data), "normal_force")
        _draw_path(figure.add_subplot(grid[0, 1]), data, "indentation", "contact_radius")
        _draw_pressure(figure.add_subplot(grid[1, 1]), data)
    return figure


def adhesive_figures(data: AdhesiveFigureData) -> dict[str, Figure]:
    """
    The figures of an adhesive contact by name.

    Parameters
    ----------
    data : AdhesiveFigureData

    Returns
    -------
    dict of str to matplotlib.figure.Figure
        ``loop``, ``radius`` and ``fields``.
    """
    with styled():
        loop = new_figure(9.6 if _against(data) == "travel" else 5.6, 4.0)
        ways = ["indentation"] if _against(data) == "indentation" else ["travel", "indentation"]
        for axes, way in zip(np.atleast_1d(np.asarray(loop.subplots(1, len(ways)))), ways, strict=True):
            _draw_path(axes, data, way, "normal_force")
        radius = new_figure(5.6, 4.0)
        _draw_path(radius.subplots(), data, "indentation", "contact_radius")
        fields = new_figure(9.6, 3.8)
        left, right = fields.subplots(1, 2)
        _draw_pressure(left, data)
        _draw_gap(right, data)
    return {"loop": loop, "radius": radius, "fields": fields}


def _against(data: AdhesiveFigureData) -> str:
    return "travel" if "travel" in data.base.data else "indentation"


def _draw_path(axes: Axes, data: AdhesiveFigureData, across: str, up: str) -> None:
    """The path over all equilibria, and what the loop encloses."""
    if across not in data.base.data or up not in data.base.data:
        axes.set_axis_off()
        axes.text(0.5, 0.5, "not a disk contact at any step", ha="center", transform=axes.transAxes)
        return
    x, y = (data.base.data[name].values for name in (across, up))
    x_unit, y_unit = good_unit(x, "m"), good_unit(y, QUANTITIES[up].unit)

    def scaled(values: FloatArray, unit: str, name: str) -> FloatArray:
        return np.asarray(from_si(values, QUANTITIES[name].unit, unit))

    if across in data.branch:
        bx, by = (scaled(data.branch[n], u, n) for n, u in ((across, x_unit), (up, y_unit)))
        axes.plot(bx, by, color=GREY, lw=1.0, ls="--", label="all equilibria")
    if up == "contact_radius" and "cohesive_radius" in data.base.data:
        c = data.base.data["cohesive_radius"].values
        axes.plot(
            scaled(x, x_unit, across),
            scaled(c, y_unit, "cohesive_radius"),
            color=GREEN,
            lw=1.2,
            label=QUANTITIES["cohesive_radius"].label,
        )
    kept = thinned(y)
    px, py = scaled(x, x_unit, across), scaled(y, y_unit, up)
    known = np.isfinite(px) & np.isfinite(py)
    if up == "normal_force" and known.all() and y[-1] == 0.0:
        # from the first touch at the origin and back to it along the free body
        around = (np.concatenate([[0.0], px[kept]]), np.concatenate([[0.0], py[kept]]))
        axes.fill(*around, color=ORANGE, alpha=0.15, lw=0, label="dissipated")
    axes.plot(px[kept], py[kept], color=BLUE, lw=1.5, marker="o" if x.size == 1 else None, ms=4, label="path")
    if up == "normal_force" and known.any() and np.nanmin(y) < 0.0:
        i = int(np.nanargmin(y))
        axes.plot(px[i], py[i], "o", color=ORANGE, ms=5)
        axes.annotate(
            written(float(y[i]), "N"), (px[i], py[i]), (6, -3), textcoords="offset points", va="top"
        )
    if known.any():
        _limit(axes, px[known], py[known])
    axes.axhline(0.0, color=GREY, lw=0.5, zorder=0)
    axes.set_xlabel(axis_label(across, x_unit))
    axes.set_ylabel(axis_label(up, y_unit))
    axes.legend(fontsize=8)


def _limit(axes: Axes, x: FloatArray, y: FloatArray) -> None:
    """Show the path; the branch may run out of the picture."""
    for values, limit in ((x, axes.set_xlim), (y, axes.set_ylim)):
        low, high = float(min(values.min(), 0.0)), float(max(values.max(), 0.0))
        room = 0.08 * (high - low) or 1.0
        limit(low - 1.5 * room, high + room)


def _draw_pressure(axes: Axes, data: AdhesiveFigureData) -> None:
    base = data.base
    if base.field is None or not float(np.nan_to_num(base.data["contact_radius"].values[base.row])) > 0.0:
        axes.set_axis_off()
        axes.text(0.5, 0.5, "no contact in this step", ha="center", transform=axes.transAxes)
        return
    p = base.field("pressure", None)
    r, values = p["r"].values, p.values
    size = float(np.nanquantile(np.abs(values[np.isfinite(values)]), 0.9))
    r_unit, unit = good_unit(r, "m"), good_unit(np.array([size]), "Pa")
    axes.plot(from_si(r, "m", r_unit), from_si(values, "Pa", unit), color=ORANGE, lw=1.5)
    shown = np.clip(
        from_si(values, "Pa", unit), -2.5 * from_si(size, "Pa", unit), 2.5 * from_si(size, "Pa", unit)
    )
    low, high = float(np.nanmin(shown)), float(np.nanmax(shown))
    axes.set_ylim(low - 0.08 * (high - low), high + 0.12 * (high - low))
    axes.axhline(0.0, color=GREY, lw=0.5, zorder=0)
    edge = from_si(float(base.data["contact_radius"].values[base.row]), "m", r_unit)
    axes.axvline(edge, color=GREY, lw=0.8, ls=":")
    if "cohesive_radius" in base.data:
        axes.axvline(
            from_si(float(base.data["cohesive_radius"].values[base.row]), "m", r_unit),
            color=GREEN,
            lw=0.8,
            ls=":",
        )
    elif float(p["edge_amplitude"]) != 0.0:
        axes.text(
            0.03,
            0.06,
            f"singular edge: $p \\to K/\\sqrt{{a-r}}$\n$K$ = {float(p['edge_amplitude']):.3g} Pa m$^{{1/2}}$",
            transform=axes.transAxes,
            fontsize=8,
        )
    axes.set_xlabel(f"radius $r$ ({r_unit})")
    axes.set_ylabel(axis_label("pressure", unit))
    axes.set_title(f"step {base.row}", fontsize=9, loc="left")


def _draw_gap(axes: Axes, data: AdhesiveFigureData) -> None:
    base = data.base
    if base.field is None or not float(np.nan_to_num(base.data["contact_radius"].values[base.row])) > 0.0:
        axes.set_axis_off()
        return
    u = base.field("normal_displacement", None)
    r = u["r"].values
    d = float(base.data["indentation"].values[base.row])
    gap = base.field("gap", r).values
    r_unit = good_unit(r, "m")
    with np.errstate(invalid="ignore"):
        tip = base.gap(r) - d
    shown = np.concatenate([u.values, tip[r <= 1.2 * r[100]] if r.size > 100 else tip])
    unit = good_unit(shown[np.isfinite(shown)], "m")
    x = from_si(r, "m", r_unit)
    axes.plot(x, from_si(-u.values, "m", unit), color=BLUE, lw=1.5, label="surface of the half-space")
    axes.plot(
        x, from_si(np.where(np.isfinite(tip), tip, np.nan), "m", unit), color=GREY, lw=1.5, label="indenter"
    )
    axes.plot(
        x,
        from_si(np.where(np.isfinite(gap), gap, np.nan), "m", unit),
        color=GREEN,
        lw=1.2,
        ls="--",
        label=QUANTITIES["gap"].label,
    )
    axes.set_xlabel(f"radius $r$ ({r_unit})")
    axes.set_ylabel(f"height ({unit})")
    axes.legend(fontsize=8)
