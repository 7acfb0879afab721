"""Figures of adhesive contacts: loops with jumps, radii, and fields with tension at the edge."""

from __future__ import annotations

import math

import numpy as np

from pymdr.interpretation.validity import BoolArray
from pymdr.presentation.plot import shared as draw
from pymdr.presentation.plot.layers import layers
from pymdr.presentation.plot.loops import course_of, draw_loop, draw_radius
from pymdr.presentation.plot.section import graded_inside, section, section_into
from pymdr.quantities import QUANTITIES, RADIUS
from pymdr.units import FloatArray, good_unit


def adhesive_overview(data: draw.FigureData) -> draw.Figure:
    """The contact in section, its force loop, and its pressure, in one figure."""
    with draw.new_figure(10.4, 6.2) as figure:
        if data.field is None:
            section_into(figure, data)
            return figure
        left, right = np.ravel(np.asarray(figure.subfigures(1, 2, width_ratios=(1.2, 1.0))))
        section_into(left, data)
        loop, pressure = right.subplots(2, 1, height_ratios=(1.25, 1.0))
        draw_loop(loop, course_of(data), _abscissas(data)[0])
        draw_tensile_pressure(pressure, data)
    return figure


def adhesive_figures(data: draw.FigureData) -> dict[str, draw.Figure]:
    """
    The figures of a contact with adhesion by name.

    Returns
    -------
    dict of str to matplotlib.figure.Figure
        ``section``, ``loop``, ``radius`` and ``fields``; ``layers`` of a body of layers.
    """
    course, abscissas = course_of(data), _abscissas(data)
    with draw.new_figure(9.6 if len(abscissas) > 1 else 5.8, 4.8) as loop:
        for axes, across in zip(
            np.ravel(np.asarray(loop.subplots(1, len(abscissas)))), abscissas, strict=True
        ):
            draw_loop(axes, course, across)
    with draw.new_figure(5.8, 4.6) as radius:
        draw_radius(radius.subplots(), course)
    own = {} if data.layers is None else {"layers": layers(data, course.trail, joined=course.joined)}
    return {"section": section(data), "loop": loop, "radius": radius, "fields": adhesive_fields(data), **own}


def adhesive_fields(data: draw.FigureData) -> draw.Figure:
    """The pressure with the tension at its edge, and both deformed surfaces."""
    with draw.new_figure(9.6, 3.8) as figure:
        left, right = figure.subplots(1, 2)
        draw_tensile_pressure(left, data)
        _draw_surfaces(right, data)
    return figure


def _abscissas(data: draw.FigureData) -> list[str]:
    return ["travel", "indentation"] if "travel" in data.data else ["indentation"]


def draw_tensile_pressure(axes: draw.Axes, data: draw.FigureData) -> None:
    """Pressure over the radius with the tension at its edge, cut where it is infinite."""
    if data.field is None:
        draw.show_refusal(axes, data)
        return
    r, a, c = _radii(data)
    if not c > 0.0:
        draw.show_text(axes, f"no contact in {draw.row_name(data, data.row)}")
        return
    p = data.field("pressure", r)
    r_unit = good_unit(r, "m")
    low, high = _pressure_limits(p.values, r < a, finite=c > a)
    unit = good_unit(np.array([low, high]), "Pa")
    x, y = draw.lengths(r, r_unit), draw.scaled(p.values, "pressure", unit)
    axes.plot(x, y, color=draw.ORANGE, lw=1.5)
    axes.set_ylim(*draw.scaled(np.array([low, high]), "pressure", unit))
    axes.set_xlim(0.0, x[-1])
    draw.draw_zero(axes)
    draw.mark_radii(axes, a, c, r_unit)
    if c > a and np.any((r > a) & (r < c)):
        strength = float(np.min(p.values[(r > a) & (r < c)]))
        label = f"$-\\sigma_0$ = {draw.typeset(strength, 'Pa')}"
        at = float(draw.scaled(np.array(strength), "pressure", unit))
        axes.text(x[-1], at, label, ha="right", va="bottom", fontsize=draw.SMALL)
    sign = draw.edge_sign(p, a)
    # halfway between p = 0 and the limit toward which the edge goes
    height = 0.5 * float(draw.scaled(np.array(low if sign < 0.0 else high), "pressure", unit))
    label = draw.singularities(float(p["edge_amplitude"]), sign, draw.infinite_within(data, a))
    if data.pull is not None:
        label = "\n".join(
            [*label.splitlines(), f"and outside, not drawn,\na pull of {draw.typeset(data.pull, 'N')}"]
        )
    axes.text(0.98 * x[-1], height, label, ha="right", va="center", fontsize=draw.SMALL)
    axes.set_xlabel(f"{RADIUS.label} ({r_unit}), in {draw.row_name(data, data.row)}")
    axes.set_ylabel(draw.axis_label("pressure", unit))


def _radii(data: draw.FigureData) -> tuple[FloatArray, float, float]:
    """Radii graded to both edges, the contact radius and the cohesive radius, in m."""
    assert data.field is not None
    a = float(data.data["contact_radius"].values[data.row])
    c = float(data.data["cohesive_radius"].values[data.row]) if "cohesive_radius" in data.data else a
    c = max(a, c) if not math.isnan(c) else a
    parts = []
    if a > 0.0:
        parts = [graded_inside(a), a + a * np.linspace(0.0, 1.0, 61)[1:] ** 2]
    if c > a:
        outer = max(2.0 * a, 1.3 * c) if a > 0.0 else 1.6 * c
        around = c * np.array([1.0 - 1e-9, 1.0 + 1e-9])
        parts += [np.linspace(a or 1e-6 * c, c, 81), around, np.linspace(c, outer, 41)]
    return np.unique(np.concatenate([[], *parts])), a, c


def _pressure_limits(p: FloatArray, inside: BoolArray, *, finite: bool) -> tuple[float, float]:
    known = p[np.isfinite(p)]
    low, high = float(np.min(known, initial=0.0)), float(np.max(known, initial=0.0))
    if not finite:
        within = np.abs(p[inside & np.isfinite(p)])
        clip = max(1.3 * high, 3.0 * float(np.median(within)) if within.size else 0.0)
        low, high = max(low, -clip), min(high, clip)
    margin = 0.1 * (high - low) or 1.0
    return low - margin, high + 1.5 * margin


def _draw_surfaces(axes: draw.Axes, data: draw.FigureData) -> None:
    """Both deformed surfaces and the gap between them."""
    if data.field is None:
        draw.show_refusal(axes, data)
        return
    r, a, c = _radii(data)
    if not c > 0.0:
        draw.show_text(axes, f"no contact in {draw.row_name(data, data.row)}")
        return
    d = float(data.data["indentation"].values[data.row])
    surface = -data.field("normal_displacement", r).values
    gap = data.field("gap", r).values
    with np.errstate(invalid="ignore"):
        body = data.gap(r) - d
    size = max(abs(d), float(np.nanmax(np.abs(surface))), float(np.nanmin(gap[r > a], initial=0.0)))
    near = r <= max(1.3 * a, 1.1 * c)
    wanted = np.concatenate([surface, gap[near & np.isfinite(gap)]])
    low, high = float(np.nanmin(wanted)), max(float(np.nanmax(wanted)), 0.3 * size)
    r_unit, unit = good_unit(r, "m"), good_unit(np.array([low, high]), "m")
    x = draw.lengths(r, r_unit)
    inside = np.isfinite(body)
    axes.plot(
        x[inside], draw.lengths(body[inside], unit), color=draw.BLUE, lw=1.5, label="indenter $f(r) - d$"
    )
    axes.plot(x, draw.lengths(surface, unit), color=draw.GREY, lw=1.5, label="surface $-u_z$")
    open_gap = np.isfinite(gap)
    y = draw.lengths(gap[open_gap], unit)
    axes.plot(x[open_gap], y, color=draw.GREEN, lw=1.2, ls="--", label=QUANTITIES["gap"].label)
    margin = 0.1 * (high - low) or 1.0
    axes.set_ylim(*draw.lengths(np.array([low - margin, high + margin]), unit))
    axes.set_xlim(0.0, x[-1])
    draw.mark_radii(axes, a, c, r_unit, named=False)
    draw.draw_zero(axes)
    axes.set(xlabel=f"{RADIUS.label} ({r_unit})", ylabel=f"height ({unit})")
    draw.legend_above(axes)
