"""Figures of contacts with friction: loops, stick and slip, tractions, energies, and studies of loops."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import (
    BLUE,
    GREEN,
    GREY,
    LIGHT,
    ORANGE,
    FigureData,
    axis_label,
    good_unit,
    new_figure,
    section_into,
    styled,
    thinned,
)
from pymdr.quantities import QUANTITIES
from pymdr.units import FloatArray, from_si

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SHOWN = (BLUE, ORANGE, GREEN)


def frictional_overview(data: FigureData, field_at: Callable[..., xr.DataArray], friction: float) -> Figure:
    """The contact in section, its loop, and the tractions of a step, in one figure."""
    with styled():
        figure = new_figure(10.0, 5.6)
        left, right = np.ravel(np.asarray(figure.subfigures(1, 2, width_ratios=(1.25, 1.0))))
        section_into(left, data)
        loop, tractions = right.subplots(2, 1)
        _draw_loop(loop, data)
        _draw_tractions(tractions, data, field_at, friction, [data.row])
    return figure


def frictional_figures(
    data: FigureData, field_at: Callable[..., xr.DataArray], friction: float
) -> dict[str, Figure]:
    """
    The figures of a contact with friction by name.

    Parameters
    ----------
    data : FigureData
    field_at : callable
        ``field_at(name, radii, step)`` gives a field.
    friction : float
        Coefficient of friction.

    Returns
    -------
    dict of str to matplotlib.figure.Figure
        ``loop``, ``tractions`` and ``energies``.
    """
    with styled():
        loop = new_figure(9.6, 3.8)
        left, right = loop.subplots(1, 2)
        _draw_loop(left, data)
        _draw_zones(right, data)
        tractions = new_figure(9.6, 3.8)
        left, right = tractions.subplots(1, 2)
        _draw_tractions(left, data, field_at, friction, _chosen(data))
        _draw_slip(right, data, field_at, _chosen(data))
        energies = new_figure(5.6, 3.8)
        _draw_energies(energies.subplots(), data)
    return {"loop": loop, "tractions": tractions, "energies": energies}


def loop_study(data: xr.Dataset) -> Figure:
    """
    Dissipation, damping ratio and stiffness against amplitude.

    Parameters
    ----------
    data : xarray.Dataset
        As :class:`pymdr.FrictionLoop` holds it.

    Returns
    -------
    matplotlib.figure.Figure
    """
    with styled():
        figure = new_figure(10.0, 3.4)
        u = data["amplitude"].values
        unit = good_unit(u, "m")
        x = from_si(u, "m", unit)
        slip = from_si(float(data.attrs["sliding_shift"]), "m", unit)
        columns = (
            ("dissipated_per_cycle", "energy lost per cycle", "J"),
            ("damping_ratio", "damping ratio", ""),
            ("secant_stiffness", "secant stiffness", "N/m"),
        )
        for axes, (name, words, si) in zip(figure.subplots(1, 3), columns, strict=True):
            values = data[name].values
            shown = good_unit(values, si) if si else ""
            scaled = from_si(values, si, shown) if si else values
            draw = axes.loglog if name == "dissipated_per_cycle" else axes.plot
            draw(x, scaled, color=BLUE, lw=1.5, marker="o" if u.size < 12 else None, ms=3)
            if name == "dissipated_per_cycle" and values[0] > 0.0:
                axes.loglog(
                    x, scaled[0] * (x / x[0]) ** 3, color=GREY, lw=0.8, ls="--", label="cube of the amplitude"
                )
                axes.legend(fontsize=8)
            if u.min() < data.attrs["sliding_shift"] < u.max():
                axes.axvline(slip, color=ORANGE, lw=0.9, ls=":")
            axes.set_xlabel(f"amplitude ({unit})")
            axes.set_ylabel(f"{words} ({shown})" if shown else words)
    return figure


def _column(data: FigureData, name: str) -> tuple[FloatArray, str]:
    values = data.data[name].values
    unit = good_unit(values, QUANTITIES[name].unit)
    return np.asarray(from_si(values, QUANTITIES[name].unit, unit)), unit


def _draw_loop(axes: Axes, data: FigureData) -> None:
    (u, u_unit), (force, force_unit) = (_column(data, name) for name in ("shift", "tangential_force"))
    kept = thinned(force)
    axes.plot(u[kept], force[kept], color=BLUE, lw=1.3, marker="o" if u.size == 1 else None)
    axes.plot(u[data.row], force[data.row], "o", color=ORANGE, ms=5)
    axes.axhline(0.0, color=GREY, lw=0.5, zorder=0)
    axes.set_xlabel(axis_label("shift", u_unit))
    axes.set_ylabel(axis_label("tangential_force", force_unit))


def _over(data: FigureData) -> tuple[FloatArray, str]:
    if "time" in data.data:
        values, unit = _column(data, "time")
        return values, f"time $t$ ({unit})"
    if "row" in data.data.coords:
        return np.asarray(data.data["row"].values, dtype=float), "row of the path"
    return np.arange(float(data.data.sizes["step"])), "step"


def _draw_zones(axes: Axes, data: FigureData) -> None:
    a, unit = _column(data, "contact_radius")
    stick = np.asarray(from_si(data.data["stick_radius"].values, "m", unit))
    x, words = _over(data)
    kept = thinned(stick)
    axes.fill_between(x[kept], stick[kept], a[kept], color=ORANGE, alpha=0.35, lw=0, label="slip")
    axes.fill_between(x[kept], 0.0, stick[kept], color=BLUE, alpha=0.25, lw=0, label="stick")
    axes.plot(x[kept], a[kept], color=GREY, lw=1)
    axes.set_xlabel(words)
    axes.set_ylabel(f"radius ({unit})")
    axes.set_ylim(0.0, 1.25 * float(np.nanmax(a, initial=0.0)) or 1.0)
    axes.legend(fontsize=8, ncols=2, loc="upper left")


def _chosen(data: FigureData) -> list[int]:
    """The drawn row, that of the largest force, and one in between."""
    force = np.abs(data.data["tangential_force"].values)
    largest = int(np.nanargmax(force))
    return sorted({data.row, largest, (data.row + largest) // 2})


def _radii(data: FigureData, rows: list[int]) -> FloatArray:
    a = float(np.nanmax(data.data["contact_radius"].values[rows])) or 1.0
    return np.concatenate(
        [a * np.sin(np.linspace(0.0, 0.5 * np.pi, 161)), a * np.linspace(1.0, 1.25, 30)[1:]]
    )


def _draw_tractions(
    axes: Axes, data: FigureData, field_at: Callable[..., xr.DataArray], friction: float, rows: list[int]
) -> None:
    r = _radii(data, rows)
    found = [field_at("shear_traction", r, row).values for row in rows]
    pressures = [field_at("pressure", r, row).values for row in rows]
    finite = np.concatenate([np.abs(values[np.isfinite(values)]) for values in found])
    top = float(np.quantile(finite, 0.98)) if finite.size else 0.0
    r_unit, unit = good_unit(r, "m"), good_unit(np.array([top]), "Pa")
    x = from_si(r, "m", r_unit)
    for row, colour, tau, p in zip(rows, _SHOWN, found, pressures, strict=False):
        axes.plot(x, from_si(tau, "Pa", unit), color=colour, lw=1.4, label=f"step {row}")
        if np.isfinite(friction) and friction > 0.0:
            limit = from_si(friction * p, "Pa", unit)
            axes.plot(x, limit, color=LIGHT, lw=0.9, zorder=0)
            axes.plot(x, -limit, color=LIGHT, lw=0.9, zorder=0)
    if top > 0.0:
        axes.set_ylim(*(sign * 1.6 * from_si(top, "Pa", unit) for sign in (-1.0, 1.0)))
    axes.axhline(0.0, color=GREY, lw=0.5, zorder=0)
    axes.set_xlabel(f"radius $r$ ({r_unit})")
    axes.set_ylabel(axis_label("shear_traction", unit))
    axes.legend(fontsize=8, title="grey: friction limit" if np.isfinite(friction) else None, title_fontsize=8)


def _draw_slip(axes: Axes, data: FigureData, field_at: Callable[..., xr.DataArray], rows: list[int]) -> None:
    r = _radii(data, rows)
    shown = [field_at("tangential_displacement", r, row).values for row in rows]
    slips = [field_at("slip", r, row).values for row in rows]
    every = np.concatenate([*shown, *slips])
    r_unit, unit = good_unit(r, "m"), good_unit(every[np.isfinite(every)], "m")
    x = from_si(r, "m", r_unit)
    for row, colour, u, slip in zip(rows, _SHOWN, shown, slips, strict=False):
        axes.plot(x, from_si(u, "m", unit), color=colour, lw=1.4, label=f"step {row}")
        axes.plot(x, from_si(slip, "m", unit), color=colour, lw=1.0, ls="--")
    axes.plot([], [], color=GREY, lw=1.0, ls="--", label="slip")
    axes.axhline(0.0, color=GREY, lw=0.5, zorder=0)
    axes.set_xlabel(f"radius $r$ ({r_unit})")
    axes.set_ylabel(f"tangential displacement ({unit})")
    axes.legend(fontsize=8, title="displacement of the surface", title_fontsize=8)


def _draw_energies(axes: Axes, data: FigureData) -> None:
    names = ("stored_tangential_energy", "dissipated_energy")
    unit = good_unit(np.concatenate([data.data[name].values for name in names]), "J")
    x, words = _over(data)
    for name, colour in zip(names, (BLUE, ORANGE), strict=True):
        values = np.asarray(from_si(data.data[name].values, "J", unit))
        kept = thinned(values)
        axes.plot(x[kept], values[kept], color=colour, lw=1.4, label=QUANTITIES[name].label)
    axes.set_xlabel(words)
    axes.set_ylabel(f"energy ({unit})")
    axes.legend(fontsize=8)
