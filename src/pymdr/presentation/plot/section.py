"""The contact in section with its pressure, above the line of springs."""

from __future__ import annotations

import math
import textwrap
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import RADIUS
from pymdr.units import FloatArray, good_unit, written

_SPRINGS = 41
_FREE = "#AAAAAA"
_ZIGZAG = np.array([0.0, 0.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 0.0, 0.0])
_ALONG = np.array([0.0, 0.12, 0.2, 0.33, 0.46, 0.59, 0.72, 0.8, 0.88, 1.0])


def section(data: draw.FigureData) -> draw.Figure:
    """The contact in section with its pressure, above the equivalent line with its springs."""
    with draw.new_figure(6.4, 5.6) as figure:
        section_into(figure, data)
    return figure


def section_into(figure: Any, data: draw.FigureData) -> None:
    """Draw the section and the springs into a figure or a part of one."""
    if data.field is None:
        _draw_refused(figure.subplots(), data)
        return
    c = _outer_radius(data)
    if not c > 0.0:
        draw.show_text(figure.subplots(), f"no contact in {draw.row_name(data, data.row)}")
        return
    if data.on_line:
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(1.25, 1.0))
    else:
        upper, lower = figure.subplots(), None
    a, d = (float(data.data[name].values[data.row]) for name in ("contact_radius", "indentation"))
    width = 1.8 * a if data.equilibria is None else max(1.8 * a, 1.25 * c)
    x_unit = good_unit(np.array([width]), "m")
    z_unit = _draw_bodies(upper, data, a, d, width, x_unit)
    _draw_pressure_profile(upper, data, a, c, x_unit)
    draw.mark_radii(upper, a, c, x_unit, both_sides=True)
    if data.data.sizes["step"] > 1:
        upper.set_title(draw.row_name(data, data.row), pad=14)
    if "stick_radius" in data.data:
        _draw_stick(upper, a, float(data.data["stick_radius"].values[data.row]), x_unit)
    if lower is not None:
        draw.mark_radii(lower, a, c, x_unit, both_sides=True, named=False)
    if lower is None:
        upper.set_xlabel(f"{RADIUS.label} ({x_unit})")
        return
    _draw_springs(lower, data, a, d, width, x_unit, z_unit)
    lower.set_xlabel(
        f"radius $r$ above, position $x$ on the line below ({x_unit})\n"
        "(the springs are a step of the calculation, not a picture of the body)"
    )


def _draw_refused(axes: draw.Axes, data: draw.FigureData) -> None:
    """The undeformed profile, with the reason why its contact is refused."""
    if data.extent is None:
        draw.show_refusal(axes, data)
        return
    r = np.linspace(0.0, data.extent, 1201)
    with np.errstate(invalid="ignore"):
        f = data.gap(r)
    known = np.isfinite(f)
    z = np.where(known, f, np.nan) - np.min(f[known])
    height = float(np.nanmax(z)) or data.extent
    x_unit, z_unit = good_unit(r, "m"), good_unit(np.array([height]), "m")
    x, body = draw.lengths(np.concatenate([-r[::-1], r]), x_unit), _mirrored(draw.lengths(z, z_unit))
    lowest, highest = draw.lengths(height * np.array([-0.35, 1.1]), z_unit)
    axes.fill_between(x, 0.0, lowest, color=draw.LIGHT, lw=0)
    axes.axhline(0.0, color=draw.GREY, lw=1.2)
    axes.fill_between(
        x, body, highest, where=_mirrored(known).astype(bool), color=draw.BLUE, alpha=0.18, lw=0
    )
    axes.plot(x, body, color=draw.BLUE, lw=1.6)
    if not known.all():
        end = float(draw.lengths(r[known].max(), x_unit))
        axes.vlines([-end, end], body[_mirrored(known).astype(bool)][-1], highest, color=draw.BLUE, lw=1.6)
    axes.set_ylim(lowest, highest)
    axes.set_ylabel(f"height $z$ ({z_unit})")
    reason = data.refusal
    if "force_lower_bound" in data.data:
        reason += f". The force is at least {written(float(data.data['force_lower_bound'].values[-1]), 'N')} (rigorous)"
    caption = textwrap.fill(reason.replace("$", ""), 78)
    axes.set_title("not a disk contact: undeformed profile")
    axes.set_xlabel(f"{RADIUS.label} ({x_unit})\n\n{caption}")


def _draw_stick(axes: draw.Axes, a: float, b: float, x_unit: str) -> None:
    """A strip at the bottom of the section that shows stick and slip."""
    edge, inner = draw.lengths(np.array([a, min(b, a)]), x_unit)
    strip: Any = {"ymin": 0.0, "ymax": 0.05, "lw": 0, "zorder": 4}
    if inner > 0.0:
        axes.axvspan(-inner, inner, color=draw.BLUE, alpha=0.8, label="stick", **strip)
    if inner < edge:
        label: str | None = "slip"
        for low, high in ((-edge, -inner), (inner, edge)):
            axes.axvspan(low, high, color=draw.ORANGE, alpha=0.8, label=label, **strip)
            label = None
    if 0.0 < inner < 0.97 * edge:
        for x in (-inner, inner):
            axes.axvline(x, color=draw.GREY, lw=0.8, ls=":")
        place: dict[str, Any] = {"xycoords": axes.get_xaxis_transform(), "textcoords": "offset points"}
        axes.annotate("$b$", (inner, 1.0), (0, 2), ha="center", color=draw.GREY, **place)
    draw.legend_above(axes)


def _outer_radius(data: draw.FigureData) -> float:
    """Radius in m inside which the bodies interact."""
    names = ("contact_radius", "cohesive_radius")
    radii = [float(data.data[name].values[data.row]) for name in names if name in data.data]
    return float(np.nanmax(radii, initial=0.0))


def _mirrored(values: FloatArray) -> FloatArray:
    return np.concatenate([values[::-1], values])


def _draw_bodies(
    axes: draw.Axes, data: draw.FigureData, a: float, d: float, width: float, x_unit: str
) -> str:
    """Draw half-space and indenter; returns the unit of their heights."""
    assert data.field is not None
    r = np.unique(np.concatenate([np.linspace(0.0, width, 241), a * np.array([0.999, 1.0, 1.001])]))
    u = data.field("normal_displacement", r).values
    with np.errstate(invalid="ignore"):
        tip = d - data.gap(r)
    size = max(abs(d), float(np.nanmax(np.abs(u))))
    z_unit = good_unit(np.array([size]), "m")
    x = draw.lengths(np.concatenate([-r[::-1], r]), x_unit)
    surface = -_mirrored(draw.lengths(u, z_unit))
    body = -_mirrored(draw.lengths(np.where(np.isfinite(tip), tip, np.nan), z_unit))
    if data.equilibria is None:
        deepest = float(np.nanmin(surface))
        lowest, highest = 1.6 * deepest, 1.5 * max(1.1 * abs(deepest), 1e-300)
    else:
        # a flat punch at d = 0 leaves everything flat
        extent = float(draw.lengths(np.array(size), z_unit)) or 1.0
        lowest = min(float(np.nanmin(surface)), 0.0) - 0.8 * extent
        highest = max(float(np.nanmax(surface)), 0.0) + 1.1 * extent
    axes.fill_between(x, surface, lowest, color=draw.LIGHT, lw=0)
    axes.plot(x, surface, color=draw.GREY, lw=1.2)
    inside = np.isfinite(body)
    with np.errstate(invalid="ignore"):
        top = np.where(inside, np.minimum(body, highest), highest)
    axes.fill_between(x, top, highest, where=inside, color=draw.BLUE, alpha=0.18, lw=0)
    axes.plot(x, np.where(body <= highest, body, np.nan), color=draw.BLUE, lw=1.6)
    if np.isinf(tip).any():
        axes.vlines([-x[inside].max(), x[inside].max()], body[inside][-1], highest, color=draw.BLUE, lw=1.6)
    axes.set_ylim(lowest, highest)
    axes.set_ylabel(f"height $z$ ({z_unit})")
    axes.spines["bottom"].set_visible(False)
    axes.tick_params(bottom=False)
    return z_unit


def graded_inside(a: float) -> FloatArray:
    """Radii in m up to the contact radius, dense at the edge, starting next to the axis, where p may be infinite."""
    return np.asarray(a * np.sin(np.linspace(1e-6, 0.5 * math.pi, 121)))


def _draw_pressure_profile(axes: draw.Axes, data: draw.FigureData, a: float, c: float, x_unit: str) -> None:
    """Pressure above z = 0 with its own scale at the right; tension below."""
    assert data.field is not None
    r = graded_inside(a)
    if c > a:
        r = np.concatenate(
            [r, np.linspace(a or 1e-6 * c, c, 41)[1:-1], c * np.array([1.0 - 1e-9, 1.0 + 1e-9])]
        )
    p = data.field("pressure", r).values
    size = tension_scale(p) if data.equilibria is not None else float(draw.without_peaks(p).max())
    unit = good_unit(np.array([size]), "Pa")
    span = 1.05 * float(draw.scaled(np.array(size), "pressure", unit))
    # infinite values are not drawn
    shown = draw.scaled(np.where(np.isfinite(p), p, math.nan), "pressure", unit)
    x = draw.lengths(np.concatenate([-r[::-1], r]), x_unit)
    draw.note_peaks(axes, draw.infinite_within(data, a))
    right = axes.twinx()
    right.spines["right"].set_visible(True)
    right.fill_between(x, _mirrored(shown), color=draw.ORANGE, alpha=0.25, lw=0)
    right.plot(x, _mirrored(shown), color=draw.ORANGE, lw=1.2)
    low, high = axes.get_ylim()
    largest, least = (float(np.clip(f(shown, initial=0.0), -span, span)) for f in (np.nanmax, np.nanmin))
    up, down = largest / high, least / low
    scale = 1.25 * max(up, down) or 1.0
    right.set_ylim(scale * low, scale * high)
    ticks = [t for t in right.get_yticks() if least <= t <= largest]
    right.set_yticks(ticks)
    right.set_ylabel(draw.axis_label("pressure", unit), color=draw.ORANGE)
    right.tick_params(colors=draw.ORANGE)


def tension_scale(p: FloatArray) -> float:
    """Largest drawn pressure in Pa of a contact whose edge may be singular."""
    finite = np.abs(p[np.isfinite(p)])
    return float(np.quantile(finite, 0.9)) if finite.size else 0.0


def _draw_springs(
    axes: draw.Axes, data: draw.FigureData, a: float, d: float, width: float, x_unit: str, z_unit: str
) -> None:
    """Independent springs from a rigid base to the profile: compressed, stretched or free."""
    assert data.field is not None
    x = np.linspace(-width, width, 2 * _SPRINGS + 1)[1::2]
    fine = np.unique(np.concatenate([np.linspace(0.0, width, 401), [a]]))
    with np.errstate(invalid="ignore"):
        tip = data.field("equivalent_profile", fine).values - d
    head = _heads(data, x, a, d)
    edge = tip[fine <= a]
    size = max(abs(d), float(np.max(np.abs(head))), float(np.nanmax(np.abs(edge), initial=0.0))) or 1.0
    base, top = -2.2 * size, 1.2 * size
    half = 0.28 * (x[1] - x[0])
    ends = np.full(x.size, np.nan)
    winding = np.column_stack([x[:, None] + half * _ZIGZAG, ends])
    along = np.column_stack([base + (head[:, None] - base) * _ALONG, ends])
    for colour, label, which in _kinds_of_springs(head):
        axes.plot(
            draw.lengths(winding[which].ravel(), x_unit),
            draw.lengths(along[which].ravel(), z_unit),
            color=colour,
            lw=0.8,
            label=label if data.equilibria is not None else None,
        )
    shown = np.where(tip <= top, tip, np.nan)
    xs = draw.lengths(np.concatenate([-fine[::-1], fine]), x_unit)
    axes.plot(xs, _mirrored(draw.lengths(shown, z_unit)), color=draw.BLUE, lw=1.6)
    if np.isinf(tip).any():
        known = np.isfinite(tip)
        end = float(draw.lengths(fine[known].max(), x_unit))
        foot, highest = draw.lengths(np.array([tip[known][-1], top]), z_unit)
        axes.vlines([-end, end], foot, highest, color=draw.BLUE, lw=1.6)
    axes.axhline(float(draw.lengths(np.array(base), z_unit)), color=draw.GREY, lw=2)
    axes.set_ylim(*draw.lengths(np.array([base - 0.15 * size, 1.05 * top]), z_unit))
    axes.set_ylabel(f"line $g(x) - d$ ({z_unit})")
    draw.legend_above(axes)


def _heads(data: draw.FigureData, x: FloatArray, a: float, d: float) -> FloatArray:
    """Displacements of the ends of the springs, 0 at rest."""
    assert data.field is not None
    g = data.field("equivalent_profile", np.abs(x)).values
    touching = (np.abs(x) <= a) & np.isfinite(g)
    with np.errstate(invalid="ignore"):
        inside = np.where(touching, g - d, 0.0)
    if data.deflection is not None:
        return np.where(touching, inside, -data.deflection(x))
    if data.modulus is None:
        return inside
    pulled = data.field("spring_force", np.abs(x)).values
    return inside - np.where(touching, 0.0, pulled / data.modulus)


def _kinds_of_springs(head: FloatArray) -> list[tuple[str, str, NDArray[np.bool_]]]:
    """Colour, label and springs of each kind that exists."""
    kinds = [
        (draw.GREEN, "pressed", head < 0.0),
        (draw.ORANGE, "pulled", head > 0.0),
        (_FREE, "free", head == 0.0),
    ]
    return [kind for kind in kinds if kind[2].any()]
