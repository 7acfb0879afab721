"""Figures: the contact above its line of springs, curves against indentation, and fields.

Everything is drawn on :class:`matplotlib.figure.Figure` objects, without pyplot and its global state; the axes can
be restyled afterwards.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pymdr.presentation.text import in_good_units, written
from pymdr.quantities import QUANTITIES, RADIUS
from pymdr.units import FloatArray, from_si

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

IntArray = NDArray[np.int_]

BLUE, ORANGE, GREEN, GREY, LIGHT = "#0072B2", "#D55E00", "#009E73", "#666666", "#DDDDDD"
"""Okabe and Ito's colours, told apart by every eye."""
_STYLE: Any = {"axes.spines.top": False, "axes.spines.right": False, "font.size": 9, "legend.frameon": False}
_SPRINGS = 41


@dataclass(frozen=True)
class FigureData:
    """What the figures are drawn from."""

    data: xr.Dataset
    """Quantities over ``step``."""
    row: int
    """The row that is drawn; -1 if none is valid."""
    field: Callable[[str, FloatArray | None], xr.DataArray] | None
    """A field of that row at radii; None where there is none."""
    gap: Callable[[FloatArray], FloatArray]
    """f(r)."""
    bands: Mapping[str, tuple[FloatArray, FloatArray]]
    """Ends of the bands of quantities, by name."""
    on_line: bool
    """Whether there is a line of springs to draw."""


def styled() -> AbstractContextManager[None]:
    """The style of all figures."""
    import matplotlib as mpl

    return mpl.rc_context(_STYLE)


def thinned(values: FloatArray, most: int = 20_000) -> IntArray:
    """Indices of at most about `most` points, with the extremes of every stretch."""
    n = values.size
    if n <= most:
        return np.arange(n)
    edges = np.linspace(0, n, most // 2 + 1).astype(int)
    kept = {0, n - 1}
    for low, high in pairwise(edges):
        part = values[low:high]
        if np.isfinite(part).any():
            kept |= {low + int(np.nanargmin(part)), low + int(np.nanargmax(part))}
    return np.array(sorted(kept))


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of a size in inches."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def good_unit(values: FloatArray, unit: str) -> str:
    """The prefixed unit that suits the largest finite value."""
    finite = np.abs(values[np.isfinite(values)])
    return in_good_units(float(finite.max()) if finite.size else 0.0, unit)[1]


def axis_label(name: str, unit: str) -> str:
    """Words, symbol and unit of a quantity."""
    row = QUANTITIES.get(name, RADIUS)
    return f"{row.label} ({unit})"


def overview(data: FigureData) -> Figure:
    """
    The contact with its springs, force and radius against indentation, and the pressure, in one figure.

    Parameters
    ----------
    data : FigureData

    Returns
    -------
    matplotlib.figure.Figure
    """
    import matplotlib as mpl

    with mpl.rc_context(_STYLE):
        figure = new_figure(10.0, 5.6)
        left, right = np.ravel(np.asarray(figure.subfigures(1, 2, width_ratios=(1.25, 1.0))))
        _draw_section(left, data)
        force, second = right.subplots(2, 1)
        _draw_curve(force, data, "normal_force")
        if data.field is None:
            _draw_curve(second, data, "force_lower_bound")
        else:
            _draw_pressure(second, data)
    return figure


def all_figures(data: FigureData) -> dict[str, Figure]:
    """
    The three figures of a result by name.

    Parameters
    ----------
    data : FigureData

    Returns
    -------
    dict of str to matplotlib.figure.Figure
        ``section``, ``curves`` and ``fields``.
    """
    return {"section": section(data), "curves": curves(data), "fields": fields(data)}


def section_into(figure: Any, data: FigureData) -> None:
    """Draw the section and the springs into a figure or a part of one."""
    _draw_section(figure, data)


def section(data: FigureData) -> Figure:
    """The contact in section with its pressure, above the equivalent line with its springs."""
    import matplotlib as mpl

    with mpl.rc_context(_STYLE):
        figure = new_figure(6.4, 5.6)
        _draw_section(figure, data)
    return figure


def curves(data: FigureData) -> Figure:
    """Force, contact radius and stiffness against indentation."""
    import matplotlib as mpl

    with mpl.rc_context(_STYLE):
        figure = new_figure(9.6, 3.2)
        for axes, name in zip(
            figure.subplots(1, 3), ("normal_force", "contact_radius", "normal_stiffness"), strict=True
        ):
            _draw_curve(axes, data, name)
    return figure


def fields(data: FigureData) -> Figure:
    """Pressure, and displacement with gap, over the radius."""
    import matplotlib as mpl

    with mpl.rc_context(_STYLE):
        figure = new_figure(9.0, 3.6)
        if data.field is None:
            _say_refused(figure.subplots(), data)
            return figure
        left, right = figure.subplots(1, 2)
        _draw_pressure(left, data)
        _draw_displacement(right, data)
    return figure


def compared_pressures(pressures: xr.Dataset) -> Figure:
    """
    Pressure by the method and by rings over the radius, with their difference below.

    Parameters
    ----------
    pressures : xarray.Dataset
        ``mdr`` and ``rings`` over ``r``, in Pa and m.

    Returns
    -------
    matplotlib.figure.Figure
    """
    import matplotlib as mpl

    with mpl.rc_context(_STYLE):
        figure = new_figure(6.0, 5.0)
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        r, mdr, rings = (pressures[name].values for name in ("r", "mdr", "rings"))
        r_unit, p_unit = good_unit(r, "m"), good_unit(_without_peaks(rings), "Pa")
        x = from_si(r, "m", r_unit)
        upper.plot(
            x, from_si(rings, "Pa", p_unit), color=ORANGE, lw=3, alpha=0.6, label="boundary elements on rings"
        )
        if np.isfinite(mdr).any():
            upper.plot(x, from_si(mdr, "Pa", p_unit), color=BLUE, lw=1.2, label="MDR")
            lower.plot(x, from_si(mdr - rings, "Pa", p_unit), color=GREY, lw=1)
        else:
            lower.text(0.5, 0.5, "MDR refused: not a disk contact", ha="center", transform=lower.transAxes)
        _limit_peaks(upper, from_si(_without_peaks(rings), "Pa", p_unit))
        upper.set_ylabel(axis_label("pressure", p_unit))
        lower.set_ylabel(f"difference ({p_unit})")
        lower.set_xlabel(f"{RADIUS.label} ({r_unit})")
        lower.axhline(0.0, color=LIGHT, zorder=0)
        upper.legend()
    return figure


def _without_peaks(p: FloatArray) -> FloatArray:
    """Finite values without those next to a singularity."""
    finite = p[np.isfinite(p)]
    if finite.size == 0:
        return np.zeros(1)
    return np.minimum(
        finite, 2.5 * float(np.quantile(finite[finite > 0.0], 0.9)) if (finite > 0.0).any() else 0.0
    )


def _limit_peaks(axes: Axes, values: FloatArray) -> None:
    top = float(values.max())
    if top > 0.0:
        axes.set_ylim(min(0.0, float(values.min())), 1.12 * top)


def _say_refused(axes: Axes, data: FigureData) -> None:
    axes.set_axis_off()
    bound = float(data.data["force_lower_bound"].values[-1])
    axes.text(
        0.5,
        0.5,
        "Not a disk contact: the method does not give this.\n"
        f"The force is at least {written(bound, 'N')} (rigorous lower bound).",
        ha="center",
        va="center",
        transform=axes.transAxes,
    )


def _draw_section(figure: Any, data: FigureData) -> None:
    if data.field is None:
        _say_refused(figure.subplots(), data)
        return
    if data.on_line:
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(1.25, 1.0))
    else:
        upper, lower = figure.subplots(), None
    a, d = (float(data.data[name].values[data.row]) for name in ("contact_radius", "indentation"))
    if a == 0.0:
        upper.text(0.5, 0.5, "no contact in this step", ha="center", transform=upper.transAxes)
        return
    reach = 1.8 * a
    r = np.unique(np.concatenate([np.linspace(0.0, reach, 241), a * np.array([0.999, 1.0, 1.001])]))
    x_unit = good_unit(np.array([reach]), "m")
    u = data.field("normal_displacement", r).values
    with np.errstate(invalid="ignore"):
        tip = d - data.gap(r)
    z_unit = good_unit(np.array([max(d, float(np.nanmax(np.abs(u))))]), "m")
    x = from_si(np.concatenate([-r[::-1], r]), "m", x_unit)

    def mirrored(values: FloatArray, unit: str) -> FloatArray:
        return np.asarray(from_si(np.concatenate([values[::-1], values]), "m", unit))

    depth = -mirrored(u, z_unit)
    body = -mirrored(np.where(np.isfinite(tip), tip, np.nan), z_unit)
    low, high = float(np.nanmin(depth)), max(1.1 * abs(float(np.nanmin(depth))), 1e-300)
    upper.fill_between(x, depth, 1.6 * low, color=LIGHT, lw=0)
    upper.plot(x, depth, color=GREY, lw=1.2)
    ceiling = 1.5 * high
    edge = from_si(np.array([a]), "m", x_unit)[0]
    with np.errstate(invalid="ignore"):
        top = np.where(np.isfinite(body), np.minimum(body, ceiling), ceiling)
    inside_body = np.isfinite(body)
    upper.fill_between(x, top, ceiling, where=inside_body, color=BLUE, alpha=0.18, lw=0)
    upper.plot(x, np.where(body <= ceiling, body, np.nan), color=BLUE, lw=1.6)
    if np.isinf(tip).any():
        end, foot = x[inside_body].max(), body[inside_body][-1]
        upper.vlines([-end, end], foot, ceiling, color=BLUE, lw=1.6)
    upper.set_ylim(1.6 * low, ceiling)
    upper.set_ylabel(f"height $z$ ({z_unit})")
    upper.spines["bottom"].set_visible(False)
    upper.tick_params(bottom=False)
    _draw_pressure_profile(upper, data, a, x_unit)
    for axes in (upper, lower):
        if axes is not None:
            axes.axvline(-edge, color=GREY, lw=0.8, ls=":")
            axes.axvline(edge, color=GREY, lw=0.8, ls=":")
    upper.text(edge, 0.93 * ceiling, " $a$", va="top", color=GREY)
    if lower is None:
        upper.set_xlabel(f"{RADIUS.label} ({x_unit})")
        return
    _draw_springs(lower, data, a, d, reach, x_unit, z_unit)
    lower.set_xlabel(
        f"radius $r$ above, position $x$ on the line below ({x_unit})\n"
        "(the springs are a step of the calculation, not a picture of the body)"
    )


def _draw_pressure_profile(axes: Axes, data: FigureData, a: float, x_unit: str) -> None:
    assert data.field is not None
    r = a * np.sin(np.linspace(0.0, math.pi / 2.0, 121))
    p = data.field("pressure", r).values
    unit = good_unit(_without_peaks(p), "Pa")
    top = float(_without_peaks(p).max())
    shown = from_si(np.minimum(np.where(np.isfinite(p), p, np.inf), 1.05 * top), "Pa", unit)
    x = from_si(np.concatenate([-r[::-1], r]), "m", x_unit)
    right = axes.twinx()
    right.spines["right"].set_visible(True)
    right.fill_between(x, np.concatenate([shown[::-1], shown]), color=ORANGE, alpha=0.25, lw=0)
    right.plot(x, np.concatenate([shown[::-1], shown]), color=ORANGE, lw=1.2)
    span = 1.05 * from_si(top, "Pa", unit)
    low, high = axes.get_ylim()
    share = -low / (high - low)
    right.set_ylim(-span * share / (1.0 - share) * 1.25, 1.25 * span)
    ticks = [t for t in right.get_yticks() if 0.0 <= t <= span]
    right.set_yticks(ticks)
    right.set_ylabel(axis_label("pressure", unit), color=ORANGE)
    right.tick_params(colors=ORANGE)


def _draw_springs(
    axes: Axes, data: FigureData, a: float, d: float, reach: float, x_unit: str, z_unit: str
) -> None:
    """Independent springs pressed by g(x): zigzags from a rigid base to the profile."""
    assert data.field is not None
    x = np.linspace(-reach, reach, 2 * _SPRINGS + 1)[1::2]
    g = data.field("equivalent_profile", np.abs(x)).values
    rest, base = 0.0, -2.2 * d
    with np.errstate(invalid="ignore"):
        head = np.where((np.abs(x) <= a) & (g < d), g - d, rest)
    zigzag = np.array([0.0, 0.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 0.0, 0.0])
    along = np.array([0.0, 0.12, 0.2, 0.33, 0.46, 0.59, 0.72, 0.8, 0.88, 1.0])
    half = 0.28 * (x[1] - x[0])
    for xi, top in zip(x, head, strict=True):
        pressed = abs(xi) <= a
        axes.plot(
            from_si(xi + half * zigzag, "m", x_unit),
            from_si(base + (top - base) * along, "m", z_unit),
            color=GREEN if pressed else "#AAAAAA",
            lw=0.8,
        )
    fine = np.unique(np.concatenate([np.linspace(0.0, reach, 401), [a]]))
    with np.errstate(invalid="ignore"):
        tip = data.field("equivalent_profile", fine).values - d
    shown = np.where(tip <= 1.2 * d, tip, np.nan)
    xs = from_si(np.concatenate([-fine[::-1], fine]), "m", x_unit)
    axes.plot(xs, from_si(np.concatenate([shown[::-1], shown]), "m", z_unit), color=BLUE, lw=1.6)
    known = np.isfinite(tip)
    if np.isinf(tip).any():
        end = from_si(fine[known].max(), "m", x_unit)
        axes.vlines(
            [-end, end],
            from_si(tip[known][-1], "m", z_unit),
            from_si(1.2 * d, "m", z_unit),
            color=BLUE,
            lw=1.6,
        )
    axes.axhline(from_si(base, "m", z_unit), color=GREY, lw=2)
    axes.set_ylim(from_si(base - 0.15 * d, "m", z_unit), from_si(1.25 * d, "m", z_unit))
    axes.set_ylabel(f"line $g(x) - d$ ({z_unit})")


def _draw_curve(axes: Axes, data: FigureData, name: str) -> None:
    d = data.data["indentation"].values if "indentation" in data.data else None
    bound = data.data["force_lower_bound"].values if "force_lower_bound" in data.data else None
    values = data.data[name].values if name in data.data else None
    if d is None or (values is None and bound is None):
        _say_refused(axes, data)
        return
    drawn = values if values is not None else np.full(d.shape, math.nan)
    is_force = name in ("normal_force", "force_lower_bound")
    shown = np.concatenate([drawn, bound]) if is_force and bound is not None else drawn
    x_unit, y_unit = good_unit(d, "m"), good_unit(shown, QUANTITIES[name].unit)
    unit = QUANTITIES[name].unit
    # a disk that was never refused began at the origin
    lead = [0.0] if d[0] > 0.0 and np.isfinite(drawn).all() and name != "force_lower_bound" else []
    x = from_si(np.concatenate([lead, d]), "m", x_unit)

    def scaled(column: FloatArray) -> FloatArray:
        return np.asarray(from_si(np.concatenate([lead, column]), unit, y_unit))

    if name in data.bands:
        low, high = data.bands[name]
        axes.fill_between(
            x, scaled(low), scaled(high), color=BLUE, alpha=0.15, lw=0, label="band of the scatter"
        )
    if is_force and bound is not None and not np.isfinite(drawn).all():
        axes.plot(x, scaled(bound), color=ORANGE, ls="--", lw=1.2, label="rigorous lower bound")
    if np.isfinite(drawn).any():
        axes.plot(x, scaled(drawn), color=BLUE, lw=1.5, marker="o" if d.size == 1 else None, ms=4)
    if data.row >= 0 and values is not None and d.size > 1:
        axes.plot(
            from_si(d[data.row], "m", x_unit), from_si(values[data.row], unit, y_unit), "o", color=BLUE, ms=4
        )
    elif values is None or not np.isfinite(drawn).any():
        axes.text(0.5, 0.9, "not a disk contact", ha="center", transform=axes.transAxes, color=GREY)
    axes.set_xlabel(axis_label("indentation", x_unit))
    axes.set_ylabel(axis_label(name, y_unit))
    axes.set_ylim(bottom=min(0.0, float(np.nanmin(scaled(shown[: d.size]), initial=0.0))))
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=8)


def _draw_pressure(axes: Axes, data: FigureData) -> None:
    assert data.field is not None
    p = data.field("pressure", None)
    r, values = p["r"].values, p.values
    r_unit, unit = good_unit(r, "m"), good_unit(_without_peaks(values), "Pa")
    shown = from_si(_without_peaks(values), "Pa", unit)
    axes.plot(from_si(r, "m", r_unit), from_si(values, "Pa", unit), color=ORANGE, lw=1.5)
    _limit_peaks(axes, shown)
    a = float(data.data["contact_radius"].values[data.row])
    amplitude = float(p["edge_amplitude"])
    notes = []
    if amplitude != 0.0:
        axes.axvline(from_si(a, "m", r_unit), color=ORANGE, lw=0.9, ls="--")
        notes.append(f"singular edge: $p \\to K/\\sqrt{{a-r}}$\n$K$ = {amplitude:.3g} Pa m$^{{1/2}}$")
    if math.isinf(values[0]):
        axes.axvline(0.0, color=ORANGE, lw=0.9, ls="--")
        notes.append("sharp tip: $p(0) = \\infty$, logarithmic")
    if notes:
        axes.text(0.97, 0.95, "\n".join(notes), ha="right", va="top", transform=axes.transAxes, fontsize=8)
    axes.set_xlabel(f"{RADIUS.label} ({r_unit})")
    axes.set_ylabel(axis_label("pressure", unit))


def _draw_displacement(axes: Axes, data: FigureData) -> None:
    assert data.field is not None
    u = data.field("normal_displacement", None)
    r = u["r"].values
    h = data.field("gap", r).values
    d = float(data.data["indentation"].values[data.row])
    r_unit, unit = good_unit(r, "m"), good_unit(np.array([d, *u.values]), "m")
    x = from_si(r, "m", r_unit)
    axes.plot(
        x, from_si(u.values, "m", unit), color=BLUE, lw=1.5, label=QUANTITIES["normal_displacement"].label
    )
    with np.errstate(invalid="ignore"):
        undeformed = d - data.gap(r)
    low = -0.6 * abs(d)
    axes.plot(
        x,
        from_si(np.where(undeformed >= low, undeformed, np.nan), "m", unit),
        color=GREY,
        lw=1,
        ls=":",
        label="$d - f(r)$",
    )
    axes.plot(
        x,
        from_si(np.where(h <= 1.2 * abs(d), h, np.nan), "m", unit),
        color=GREEN,
        lw=1.5,
        ls="--",
        label=QUANTITIES["gap"].label,
    )
    axes.set_ylim(from_si(low, "m", unit), None)
    axes.set_xlabel(f"{RADIUS.label} ({r_unit})")
    axes.set_ylabel(f"length ({unit})")
    axes.legend(fontsize=8)
