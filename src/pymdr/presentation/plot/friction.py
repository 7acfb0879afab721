"""Figures of frictional contacts: loops, stick and slip, tractions and energies."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.presentation.plot.section import section, section_into
from pymdr.quantities import QUANTITIES, RADIUS
from pymdr.units import FloatArray, good_unit

_SHOWN = (draw.BLUE, draw.ORANGE, draw.GREEN)
_BLOCKS = 1000


class _Names(NamedTuple):
    """Names of the quantities and fields of one kind of motion."""

    motion: str
    force: str
    stored: str
    traction: str
    displacement: str


_SHEARED = _Names(
    "shift", "tangential_force", "stored_tangential_energy", "shear_traction", "tangential_displacement"
)
_TURNED = _Names(
    "twist", "torque", "stored_torsional_energy", "torsional_traction", "circumferential_displacement"
)


def _names(data: draw.FigureData) -> _Names:
    return _TURNED if "twist" in data.data else _SHEARED


def frictional_overview(data: draw.FigureData) -> draw.Figure:
    """The contact in section, its loop, and the tractions of some steps, in one figure."""
    with draw.new_figure(10.4, 5.8) as figure:
        left, right = np.ravel(np.asarray(figure.subfigures(1, 2, width_ratios=(1.2, 1.0))))
        section_into(left, data)
        loop, tractions = right.subplots(2, 1)
        rows = _chosen(data)
        _draw_loop(loop, data, rows)
        _draw_tractions(tractions, data, rows)
    return figure


def frictional_figures(data: draw.FigureData) -> dict[str, draw.Figure]:
    """
    The figures of a contact with friction by name.

    Returns
    -------
    dict of str to matplotlib.figure.Figure
        ``section``, ``loop``, ``tractions`` and ``energies``.
    """
    rows = _chosen(data)
    with draw.new_figure(9.6, 3.8) as loop:
        left, right = loop.subplots(1, 2)
        _draw_loop(left, data, rows)
        _draw_zones(right, data, rows)
    with draw.new_figure(9.6, 3.8) as tractions:
        left, right = tractions.subplots(1, 2)
        _draw_tractions(left, data, rows)
        _draw_slip(right, data, rows)
    with draw.new_figure(9.6, 3.8) as energies:
        _draw_energies(energies, data)
    return {"section": section(data), "loop": loop, "tractions": tractions, "energies": energies}


def _draw_loop(axes: draw.Axes, data: draw.FigureData, rows: list[int]) -> None:
    """Force over shift or torque over twist; marked rows are those whose tractions are drawn."""
    names = _names(data)
    (u, u_unit), (force, force_unit) = (draw.column(data, name) for name in (names.motion, names.force))
    if _is_thinned(data):
        axes.plot(u, force, ".", color=draw.GREY, ms=2.5, label="kept rows")
    else:
        few = "o" if u.size <= draw.MARKED_ROWS else None
        axes.plot(*draw.thinned_curve(u, force), color=draw.GREY, lw=1.3, marker=few, ms=2.5)
    for row, colour in zip(rows, _SHOWN, strict=False):
        name = draw.row_name(data, row)
        axes.plot(u[[row]], force[[row]], "o", color=colour, ms=6, label=name, zorder=3)
    _draw_limits(axes, data, u, force_unit)
    draw.draw_zero(axes)
    axes.axvline(0.0, color=draw.GREY, lw=0.5, zorder=0)
    axes.set(xlabel=draw.axis_label(names.motion, u_unit), ylabel=draw.axis_label(names.force, force_unit))
    draw.legend_above(axes)


def _draw_limits(axes: draw.Axes, data: draw.FigureData, u: FloatArray, force_unit: str) -> None:
    """The friction limits +-mu F_N, as lines if the load is constant while sheared."""
    if data.friction is None or not 0.0 < data.friction < math.inf or _names(data) is _TURNED:
        return
    load = data.data["normal_force"].values
    sheared = (data.data["tangential_force"].values != 0.0) & np.isfinite(load)
    if not sheared.any():
        return
    limit = draw.scaled(data.friction * load, "tangential_force", force_unit)
    style: dict[str, Any] = {"color": draw.ORANGE, "lw": 0.9, "ls": (0, (4, 2)), "zorder": 1}
    label: str | None = "$\\pm\\mu F_N$"
    if np.ptp(limit[sheared]) <= 1e-6 * np.max(limit[sheared]):
        for sign in (1.0, -1.0):
            axes.axhline(sign * float(np.max(limit[sheared])), label=label, **style)
            label = None
        return
    for sign in (1.0, -1.0):
        x, y = draw.thinned_curve(u, np.where(sheared, sign * limit, np.nan))
        if _is_thinned(data):
            axes.plot(x, y, ".", color=draw.ORANGE, ms=1.5, label=label)
        else:
            axes.plot(x, y, label=label, **style)
        label = None


def _is_thinned(data: draw.FigureData) -> bool:
    """Whether only some rows of the path were kept."""
    return "row" in data.data.coords and bool(np.any(np.diff(data.data["row"].values) > 1))


def _draw_zones(axes: draw.Axes, data: draw.FigureData, rows: list[int]) -> None:
    """Stick and slip zones over the history, with lines at the rows whose tractions are drawn."""
    a, unit = draw.column(data, "contact_radius")
    least = most = draw.lengths(data.data["stick_radius"].values, unit)
    x, x_label = draw.along_history(data)
    for row, colour in zip(rows, _SHOWN, strict=False):
        axes.axvline(x[row], color=colour, lw=1.2, ls=":", clip_on=False)  # a last row is the edge
    if x.size == 1:
        x, a, least, most = np.array([x[0] - 0.5, x[0] + 0.5]), *(np.repeat(v, 2) for v in (a, least, most))
    if _is_thinned(data):
        axes.vlines(x, least, a, color=draw.ORANGE, alpha=0.35, lw=1.2, label="slip")
        axes.vlines(x, 0.0, least, color=draw.BLUE, alpha=0.3, lw=1.2, label="stick")
        axes.plot(x, a, ".", color=draw.GREY, ms=3, label="contact radius, kept rows")
        axes.plot(x, least, ".", color=draw.BLUE, ms=3, label="stick radius, kept rows")
    else:
        _fill_zones(axes, x, a, least, most)
    draw.label_history(axes, x_label)
    axes.set_ylabel(f"radius ({unit})")
    axes.set_ylim(0.0, 1.1 * float(np.nanmax(a, initial=0.0)) or 1.0)
    axes.margins(x=0.0)
    draw.legend_above(axes)


def _fill_zones(axes: draw.Axes, x: FloatArray, a: FloatArray, least: FloatArray, most: FloatArray) -> None:
    """Stick and slip zones over consecutive rows."""
    if x.size > draw.MOST:
        # more rows than pixels: the extremes of blocks of rows
        starts = np.linspace(0, x.size, _BLOCKS, endpoint=False, dtype=int)
        least, most = np.fmin.reduceat(least, starts), np.fmax.reduceat(most, starts)
        x, a = x[starts], np.fmax.reduceat(a, starts)
        axes.fill_between(
            x, least, most, color=draw.ORANGE, alpha=0.12, lw=0, label="alternating stick and slip"
        )
    axes.fill_between(x, most, a, color=draw.ORANGE, alpha=0.35, lw=0, label="slip")
    axes.fill_between(x, 0.0, least, color=draw.BLUE, alpha=0.3, lw=0, label="stick")
    axes.plot(x, a, color=draw.GREY, lw=1.2, label=QUANTITIES["contact_radius"].label)
    axes.plot(x, least, color=draw.BLUE, lw=1.2, label=QUANTITIES["stick_radius"].label)


def _chosen(data: draw.FigureData) -> list[int]:
    """The drawn row, the row of the largest force, and that of the largest opposite force or one in between."""
    force = data.data[_names(data).force].values
    touching = np.isfinite(force) & (data.data["contact_radius"].values > 0.0)
    if not touching.any():
        return []
    drawn = data.row if data.row >= 0 and touching[data.row] else int(np.flatnonzero(touching)[-1])
    largest = int(np.argmax(np.where(touching, np.abs(force), -1.0)))
    opposite = np.where(touching, -force * np.sign(force[largest]), -math.inf)
    rows = {drawn, largest, int(np.argmax(opposite))}
    if np.max(opposite) < 0.05 * abs(force[largest]):
        halfway = np.abs(force - 0.5 * (force[drawn] + force[largest]))
        rows = {drawn, largest, int(np.argmin(np.where(touching, halfway, math.inf)))}
    return sorted(rows)


def _radii(data: draw.FigureData, rows: list[int]) -> FloatArray:
    """Radii graded to the stick and contact radii of some rows, where tractions vary like square roots."""
    a, b = (data.data[name].values[rows] for name in ("contact_radius", "stick_radius"))
    top = float(np.max(a))
    from_edge = np.linspace(0.0, 1.0, 81) ** 4
    around = np.array([1.0 - 1e-6, 1.0, 1.0 + 1e-6])
    edges = np.concatenate([np.outer(around, a).ravel(), np.outer(around, b).ravel()])
    r = np.concatenate(
        [
            top * np.sin(np.linspace(0.0, 0.5 * math.pi, 161)),
            np.linspace(top, 1.3 * top, 30),
            edges,
            *(edge * (1.0 - from_edge) for edge in (*a, *b)),
            *(np.linspace(stick, edge, 41) for edge, stick in zip(a, b, strict=True)),
        ]
    )
    return np.unique(r)


def _draw_tractions(axes: draw.Axes, data: draw.FigureData, rows: list[int]) -> None:
    """Traction of some rows with the friction limits."""
    traction = _names(data).traction
    if not rows or data.field_at is None:
        draw.show_text(axes, "no contact at any step")
        return
    r = _radii(data, rows)
    tractions = [data.field_at(traction, r, row).values for row in rows]
    limits: list[FloatArray] = []
    if data.friction is not None and 0.0 < data.friction < math.inf:
        limits = [data.friction * data.field_at("pressure", r, row).values for row in rows]
    top = _largest_shown([*tractions, *limits])
    r_unit, unit = good_unit(r, "m"), good_unit(np.array([top]), "Pa")
    x = draw.lengths(r, r_unit)
    label: str | None = "$\\pm\\mu p$"
    alike = all(np.array_equal(limit, limits[0]) for limit in limits)
    for i, limit in enumerate(limits[:1] if alike else limits):
        colour = draw.GREY if alike else _SHOWN[i]
        within = np.where(r <= float(data.data["contact_radius"].values[rows[i]]), limit, np.nan)
        for sign in (1.0, -1.0):
            y = draw.scaled(sign * within, traction, unit)
            axes.plot(x, y, color=colour, lw=0.9, ls=(0, (4, 2)), label=label, zorder=3 if alike else 1)
            label = None
    for row, colour, tau in zip(rows, _SHOWN, tractions, strict=False):
        name = draw.row_name(data, row)
        axes.plot(x, draw.scaled(tau, traction, unit), color=colour, lw=1.5, label=name)
    if top > 0.0:
        low, high = (any((f[np.isfinite(f)] * s > 1e-9 * top).any() for f in tractions) for s in (-1.0, 1.0))
        ends = np.array([-1.15 * top if low else -0.1 * top, 1.15 * top if high else 0.1 * top])
        axes.set_ylim(*draw.scaled(ends, traction, unit))
    if limits:
        draw.note_peaks(
            axes, draw.infinite_within(data, float(np.max(data.data["contact_radius"].values[rows])))
        )
    draw.draw_zero(axes)
    axes.set_xlim(0.0, x[-1])
    axes.set(xlabel=f"{RADIUS.label} ({r_unit})", ylabel=draw.axis_label(traction, unit))
    draw.legend_above(axes)


def _largest_shown(values: list[FloatArray]) -> float:
    """Upper limit of a picture whose curves may be infinite at an edge or at a tip."""
    finite = [np.abs(v[np.isfinite(v)]) for v in values]
    tops = [float(min(np.max(v), 3.0 * np.median(v[v > 0.0]))) for v in finite if (v > 0.0).any()]
    return max(tops, default=0.0)


def _draw_slip(axes: draw.Axes, data: draw.FigureData, rows: list[int]) -> None:
    """Surface displacement and slip of some rows."""
    name = _names(data).displacement
    if not rows or data.field_at is None:
        draw.show_text(axes, "no contact at any step")
        return
    r = _radii(data, rows)
    shown = [data.field_at(name, r, row).values for row in rows]
    slips = [data.field_at("slip", r, row).values for row in rows]
    r_unit, unit = good_unit(r, "m"), good_unit(np.concatenate([*shown, *slips]), "m")
    x = draw.lengths(r, r_unit)
    for row, colour, u, slip in zip(rows, _SHOWN, shown, slips, strict=False):
        axes.plot(x, draw.lengths(u, unit), color=colour, lw=1.5, label=draw.row_name(data, row))
        axes.plot(x, draw.lengths(slip, unit), color=colour, lw=1.1, ls="--")
    axes.plot([], [], color=draw.GREY, lw=1.5, label=f"displacement ${QUANTITIES[name].symbol}$")
    axes.plot([], [], color=draw.GREY, lw=1.1, ls="--", label="slip $\\delta$")
    draw.draw_zero(axes)
    axes.set_xlim(0.0, x[-1])
    axes.set(xlabel=f"{RADIUS.label} ({r_unit})", ylabel=f"displacement ({unit})")
    draw.legend_above(axes)


def _draw_energies(figure: draw.Figure, data: draw.FigureData) -> None:
    """Stored and dissipated energy over the history, which may differ by orders of magnitude."""
    x, x_label = draw.along_history(data)
    names = (_names(data).stored, "dissipated_energy")
    for axes, name, colour in zip(figure.subplots(1, 2), names, (draw.BLUE, draw.ORANGE), strict=True):
        unit = good_unit(data.data[name].values, "J")
        values = draw.scaled(data.data[name].values, name, unit)
        kept = draw.thinned(values)
        if _is_thinned(data):
            axes.plot(x[kept], values[kept], ".", color=colour, ms=3, label="kept rows")
            draw.legend_above(axes)
        else:
            few = "o" if x.size <= draw.MARKED_ROWS else None
            axes.plot(x[kept], values[kept], color=colour, lw=1.5, marker=few, ms=2.5)
        draw.draw_zero(axes)
        draw.label_history(axes, x_label)
        axes.set_ylabel(draw.axis_label(name, unit))
