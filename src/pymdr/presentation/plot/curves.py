"""Curves against indentation and fields of contacts without adhesion or friction."""

from __future__ import annotations

import math

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import QUANTITIES, RADIUS
from pymdr.units import FloatArray, from_si, good_unit


def curves(data: draw.FigureData) -> draw.Figure:
    """Force, contact radius and stiffness against indentation."""
    with draw.new_figure(9.6, 3.2) as figure:
        for axes, name in zip(
            figure.subplots(1, 3), ("normal_force", "contact_radius", "normal_stiffness"), strict=True
        ):
            draw_curve(axes, data, name)
    return figure


def fields(data: draw.FigureData) -> draw.Figure:
    """Pressure, and displacement with gap, over the radius."""
    with draw.new_figure(9.0, 3.6) as figure:
        if data.field is None:
            draw.show_refusal(figure.subplots(), data)
            return figure
        left, right = figure.subplots(1, 2)
        draw_pressure(left, data)
        draw_displacement(right, data)
    return figure


def draw_curve(axes: draw.Axes, data: draw.FigureData, name: str) -> None:
    """A quantity against indentation, with its band, and the lower bound of refused rows."""
    d = data.data["indentation"].values if "indentation" in data.data else None
    bound = data.data["force_lower_bound"].values if "force_lower_bound" in data.data else None
    values = data.data[name].values if name in data.data else None
    is_force = name == "normal_force"
    if d is None or (values is None and not (is_force and bound is not None)):
        draw.show_refusal(axes, data)
        return
    drawn = values if values is not None else np.full(d.shape, math.nan)
    shown = np.concatenate([drawn, bound]) if is_force and bound is not None else drawn
    x_unit, y_unit = good_unit(d, "m"), good_unit(shown, QUANTITIES[name].unit)
    unit = QUANTITIES[name].unit
    known = np.isfinite(d) & np.isfinite(drawn)
    x = from_si(d, "m", x_unit)

    def scaled(column: FloatArray) -> FloatArray:
        return np.asarray(from_si(column, unit, y_unit))

    few = "o" if d.size <= draw.MARKED_ROWS else None

    if name in data.bands:
        low, high = (scaled(end) for end in data.bands[name])
        axes.fill_between(x, low, high, color=draw.BLUE, alpha=0.15, lw=0, label="band of the scatter")
    if is_force and bound is not None and not np.isfinite(drawn).all():
        label = "rigorous lower bound" + ("" if np.isfinite(drawn).any() else ":\nnot a disk contact")
        axes.plot(x, scaled(bound), color=draw.ORANGE, ls="--", lw=1.2, marker=few, ms=2.5, label=label)
    if known.any() and data.loading is not None:
        depth = max(float(d[known].max()), 0.0) * np.linspace(0.0, 1.0, 301) ** 2
        between = from_si(data.loading(depth)[name], unit, y_unit)
        axes.plot(from_si(depth, "m", x_unit), between, color=draw.BLUE, lw=1.5)
        if few:
            axes.plot(from_si(d, "m", x_unit), from_si(drawn, unit, y_unit), "o", color=draw.BLUE, ms=2.5)
    elif known.any():
        axes.plot(*draw.thinned_curve(x, scaled(drawn)), color=draw.BLUE, lw=1.5, marker=few, ms=2.5)
    if data.row >= 0 and values is not None:
        at = from_si(d[data.row], "m", x_unit), from_si(values[data.row], unit, y_unit)
        axes.plot(*at, "o", color=draw.BLUE, ms=5)
    axes.locator_params(axis="x", nbins=6)
    axes.set(xlabel=draw.axis_label("indentation", x_unit), ylabel=draw.axis_label(name, y_unit))
    axes.set_ylim(bottom=min(0.0, float(np.nanmin(scaled(shown[: d.size]), initial=0.0))))
    draw.legend_above(axes)


def draw_pressure(axes: draw.Axes, data: draw.FigureData) -> None:
    """Pressure over the radius, with labels of its singularities."""
    assert data.field is not None
    p = data.field("pressure", None)
    r, values = p["r"].values, p.values
    r_unit, unit = good_unit(r, "m"), good_unit(draw.without_peaks(values), "Pa")
    shown = from_si(draw.without_peaks(values), "Pa", unit)
    axes.plot(from_si(r, "m", r_unit), from_si(values, "Pa", unit), color=draw.ORANGE, lw=1.5)
    draw.limit_peaks(axes, shown)
    a = float(data.data["contact_radius"].values[data.row])
    sign = draw.edge_sign(p, a)
    peaks = draw.infinite_within(data, a)
    for radius in (*peaks, *([a] if sign != 0.0 else [])):
        axes.axvline(from_si(radius, "m", r_unit), color=draw.ORANGE, lw=0.9, ls="--")
    notes = draw.singularities(float(p["edge_amplitude"]), sign, peaks)
    axes.text(0.97, 0.95, notes, ha="right", va="top", transform=axes.transAxes, fontsize=draw.SMALL)
    axes.set(xlabel=f"{RADIUS.label} ({r_unit})", ylabel=draw.axis_label("pressure", unit))


def draw_displacement(axes: draw.Axes, data: draw.FigureData) -> None:
    """Surface displacement, undeformed body and gap over the radius."""
    assert data.field is not None
    u = data.field("normal_displacement", None)
    r = u["r"].values
    h = data.field("gap", r).values
    d = float(data.data["indentation"].values[data.row])
    r_unit, unit = good_unit(r, "m"), good_unit(np.array([d, *u.values]), "m")
    x = from_si(r, "m", r_unit)
    y = from_si(u.values, "m", unit)
    axes.plot(x, y, color=draw.BLUE, lw=1.5, label=QUANTITIES["normal_displacement"].label)
    with np.errstate(invalid="ignore"):
        undeformed = d - data.gap(r)
    low = -0.6 * abs(d)
    y = from_si(np.where(undeformed >= low, undeformed, np.nan), "m", unit)
    axes.plot(x, y, color=draw.GREY, lw=1, ls=":", label="$d - f(r)$")
    y = from_si(np.where(h <= 1.2 * abs(d), h, np.nan), "m", unit)
    axes.plot(x, y, color=draw.GREEN, lw=1.5, ls="--", label=QUANTITIES["gap"].label)
    axes.set_ylim(from_si(low, "m", unit), None)
    axes.set(xlabel=f"{RADIUS.label} ({r_unit})", ylabel=f"length ({unit})")
    draw.legend_above(axes)
