"""A layered body in section, to scale, and its force compared with half-spaces of its materials."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import RADIUS
from pymdr.units import FloatArray, good_unit

_SHADES = ("#F3DDB3", "#D8C3A5", "#C3CFE2", "#B7D3BF")
_COLOURS = (draw.ORANGE, draw.GREEN)


def layers(
    data: draw.FigureData, trail: Mapping[str, FloatArray] | None = None, *, joined: bool = True
) -> draw.Figure:
    """
    The layers in section, to scale, and force against indentation with those of half-spaces.

    Parameters
    ----------
    data : FigureData
        With `layers`.
    trail : mapping of str to ndarray, optional
        ``indentation`` in m and ``normal_force`` in N along the path, also between its rows; by default the rows.
    joined : bool
        Whether the states between the rows are known.
    """
    with draw.new_figure(9.6, 4.2) as figure:
        left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
        _draw_stack(left, data)
        _draw_forces(right, data, trail, joined)
    return figure


def thickness_study(depth: FloatArray, factors: Mapping[str, FloatArray]) -> draw.Figure:
    """
    Factors of a finite thickness on force and stiffness, over the indentation.

    Parameters
    ----------
    depth : ndarray
        In m.
    factors : mapping of str to ndarray
        ``force_factor`` and ``punch_factor``.
    """
    labels = {"force_factor": "force at the same indentation", "punch_factor": "stiffness at the same radius"}
    with draw.new_figure(5.8, 4.0) as figure:
        axes = figure.subplots()
        unit = good_unit(depth, "m")
        order = np.argsort(depth)
        for colour, (name, values) in zip((draw.BLUE, draw.ORANGE), factors.items(), strict=True):
            x = draw.lengths(depth[order], unit)
            axes.plot(x, values[order], "o-", ms=3, color=colour, lw=1.4, label=labels[name])
        axes.axhline(1.0, color=draw.GREY, lw=0.8)
        axes.set(xlabel=draw.axis_label("indentation", unit), ylabel="layer over half-space")
        draw.legend_above(axes)
    return figure


def _draw_stack(axes: draw.Axes, data: draw.FigureData) -> None:
    drawn = data.layers
    assert drawn is not None
    if data.field is None:
        draw.show_text(axes, "not a disk contact")
        return
    a, d = (float(data.data[name].values[data.row]) for name in ("contact_radius", "indentation"))
    if not a > 0.0:
        draw.show_text(axes, f"no contact in {draw.row_name(data, data.row)}")
        return
    total = sum(drawn.thickness)
    width = max(2.2 * a, 1.2 * min(total, 6.0 * a))
    unit = good_unit(np.array([width]), "m")
    r = np.unique(np.concatenate([np.linspace(0.0, width, 301), [a]]))
    u = data.field("normal_displacement", r).values
    with np.errstate(invalid="ignore"):
        tip = data.gap(r) - d
    x = _both(r, unit, -1.0)
    highest = 0.6 * width
    lowest = -min(max(1.3 * total, 0.3 * width), 2.0 * width)
    top = _both(-u, unit)
    depth = 0.0
    for i, (thickness, material) in enumerate(zip(drawn.thickness, drawn.materials, strict=True)):
        depth += thickness
        foot = float(draw.lengths(np.array(max(-depth, lowest)), unit))
        shade = _SHADES[i % len(_SHADES)]
        axes.fill_between(x, top, foot, color=shade, lw=0)
        if -depth < lowest:
            break
        axes.axhline(foot, color=draw.GREY, lw=0.8)
        if thickness > 0.06 * (highest - lowest):
            middle = float(draw.lengths(np.array(-depth + 0.5 * thickness), unit))
            axes.text(x[0], middle, f" {material}", fontsize=draw.SMALL, va="center", color=draw.GREY)
        top = np.full(x.shape, foot)
    bottom = float(draw.lengths(np.array(lowest), unit))
    if total < -lowest:
        axes.fill_between(
            x, top, bottom, color=draw.LIGHT, lw=0, hatch="////" if drawn.rigid else None, edgecolor=draw.GREY
        )
        axes.text(
            x[0],
            0.5 * (float(top[0]) + bottom),
            f" {drawn.base}",
            fontsize=draw.SMALL,
            va="center",
            color=draw.GREY,
        )
    axes.plot(x, _both(-u, unit), color=draw.GREY, lw=1.2)
    body = _both(np.where(np.isfinite(tip), np.minimum(tip, highest), highest), unit)
    axes.fill_between(
        x, body, float(draw.lengths(np.array(highest), unit)), color=draw.BLUE, alpha=0.18, lw=0
    )
    y = np.where(body < float(draw.lengths(np.array(highest), unit)), body, np.nan)
    axes.plot(x, y, color=draw.BLUE, lw=1.6)
    axes.set_aspect("equal")
    axes.set_xlim(float(x[0]), float(x[-1]))
    axes.set_ylim(bottom, float(draw.lengths(np.array(highest), unit)))
    axes.set(xlabel=f"{RADIUS.label} ({unit})", ylabel=f"height $z$ ({unit})")
    axes.set_title("to scale; with the displacement of both surfaces" if drawn.both else "to scale")


def _both(values: FloatArray, unit: str, sign: float = 1.0) -> FloatArray:
    return draw.lengths(np.concatenate([sign * values[::-1], values]), unit)


def _draw_forces(
    axes: draw.Axes, data: draw.FigureData, trail: Mapping[str, FloatArray] | None, joined: bool
) -> None:
    drawn = data.layers
    assert drawn is not None
    d, force = (
        data.data[name].values if name in data.data else None for name in ("indentation", "normal_force")
    )
    if d is None or force is None or not np.isfinite(d * force).any():
        draw.show_text(axes, "the force is not known")
        return
    x_unit, y_unit = good_unit(d[np.isfinite(d)], "m"), good_unit(force[np.isfinite(force)], "N")
    for colour, (material, (depth, load)) in zip(_COLOURS, drawn.half_spaces.items(), strict=False):
        x, y = draw.lengths(depth, x_unit), draw.scaled(load, "normal_force", y_unit)
        axes.plot(x, y, color=colour, lw=1.2, ls="--", label=material)
    if data.loading is None:
        x, y = draw.lengths(d, x_unit), draw.scaled(force, "normal_force", y_unit)
        if joined:
            between = (
                (x, force)
                if trail is None
                else (draw.lengths(trail["indentation"], x_unit), trail["normal_force"])
            )
            y = draw.scaled(between[1], "normal_force", y_unit)
            axes.plot(between[0], y, color=draw.BLUE, lw=1.6, label="layers")
        if not joined or d.size <= draw.MARKED_ROWS:
            axes.plot(x, y, "o", color=draw.BLUE, ms=2.5, label=None if joined else "layers")
    else:
        depth = max(float(np.max(d[np.isfinite(d * force)])), 0.0) * np.linspace(0.0, 1.0, 301) ** 2
        load = draw.scaled(data.loading(depth)["normal_force"], "normal_force", y_unit)
        axes.plot(draw.lengths(depth, x_unit), load, color=draw.BLUE, lw=1.6, label="layers")
    low, high = (
        float(draw.scaled(np.array(f(force)), "normal_force", y_unit)) for f in (np.nanmin, np.nanmax)
    )
    axes.set_ylim(min(1.1 * low, 0.0), 1.25 * max(high, 0.0) or None)
    axes.set(xlabel=draw.axis_label("indentation", x_unit), ylabel=draw.axis_label("normal_force", y_unit))
    draw.legend_above(axes)
