"""The stress inside the bodies under the contact: in section, along the axis, at the surface, and over a history."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import ALONG, DEPTH, RADIUS
from pymdr.units import FloatArray, good_unit, written

if TYPE_CHECKING:
    from pathlib import Path

    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LEVELS = 16
_SHOWN = 0.995
"""Fraction of the points whose values the colours resolve; values next to a singular edge are beyond."""
_SLIGHT = 0.03
"""Fraction of the largest value below which values of the other sign have no colours of their own."""
_DRAWN = 0.97
"""The same for lines."""
_NOTHING = 1e-9
"""Fraction of the largest component below which one is not drawn."""
_SIGNED = ("principal_stress", "hydrostatic")
"""Measures whose sign distinguishes tension and compression."""
_LINES = {
    **dict.fromkeys(("rr", "xx"), draw.BLUE),
    **dict.fromkeys(("tt", "yy"), draw.GREEN),
    "zz": draw.ORANGE,
    **dict.fromkeys(("rz", "xz"), draw.PURPLE),
    **dict.fromkeys(("rt", "xy"), draw.SKY),
    **dict.fromkeys(("tz", "yz"), draw.AMBER),
}
"""Components that are drawn along lines."""


@dataclass(frozen=True)
class StressedBody:
    """The stress in one body in one row."""

    side: str
    """"body" or "counterbody"."""
    field: xr.DataArray
    """A measure over ``z`` and ``r``, or over ``z`` and ``x`` along the shift; depths of interfaces twice."""
    largest: xr.DataArray | None
    """Its largest value with the coordinates ``r`` (or ``x``) and ``z``; None where it has none."""
    unbounded: str = ""
    """Why the stress has no bound; empty if it has one."""
    axis: xr.DataArray | None = None
    """Components below the centre over ``z``."""
    surface: xr.DataArray | None = None
    """Components at the surface over ``r`` or ``x``."""

    @property
    def along(self) -> str:
        """The horizontal dimension."""
        return "x" if "x" in self.field.dims else "r"


class _Scale(NamedTuple):
    """Units and colours that the bodies share."""

    name: str
    length: str
    unit: str
    levels: FloatArray
    bounded: bool

    @property
    def colours(self) -> dict[str, Any]:
        """Colour map and norm: diverging about 0 where a sign matters."""
        from matplotlib.colors import TwoSlopeNorm

        low, high = float(self.levels[0]), float(self.levels[-1])
        if self.name in _SIGNED:
            return {"cmap": "RdBu_r", "norm": TwoSlopeNorm(0.0, low if low < 0.0 else -high, high or -low)}
        return {"cmap": "viridis"}


def _scale_of(bodies: Sequence[StressedBody]) -> _Scale:
    """Units and colours for some bodies or rows."""
    first = bodies[0]
    values = np.concatenate([body.field.values.ravel() for body in bodies])
    values = values[np.isfinite(values)]
    values = values if values.size else np.zeros(1)
    name, bounded = str(first.field.name), not any(body.unbounded for body in bodies)
    if not bounded:
        values = values.clip(*np.quantile(values, [1.0 - _SHOWN, _SHOWN]))
    unit = good_unit(values, str(first.field.attrs["units"]))
    shown = draw.scaled(values, name, unit)
    low, top = min(float(np.min(shown)), 0.0), float(np.max(shown))
    if not top > low:
        top = low + 1.0
    # colours for a sign that hardly occurs tell nothing
    top = 0.0 if name in _SIGNED and top < _SLIGHT * -low else top
    low = 0.0 if -low < _SLIGHT * top else low
    levels = np.linspace(low, top, _LEVELS + 1)
    if name in _SIGNED and low < 0.0 < top:
        below = max(2, round(_LEVELS * -low / (top - low)))
        levels = np.concatenate(
            [np.linspace(low, 0.0, below + 1), np.linspace(0.0, top, max(2, _LEVELS - below) + 1)[1:]]
        )
    return _Scale(name, good_unit(first.field[first.along].values, "m"), unit, levels, bounded)


def stress_section(bodies: Sequence[StressedBody], contact_radius: float, outer_radius: float) -> Figure:
    """
    A measure of stress in section, with the contact and the places of the largest values.

    Parameters
    ----------
    bodies : sequence of StressedBody
        One, or both; the counterbody is drawn above the surface.
    contact_radius, outer_radius : float
        Radii in m of the contact and of its cohesive zone.
    """
    with draw.new_figure(6.0, 3.6 if len(bodies) == 1 else 5.2) as figure:
        axes = figure.subplots()
        scale = _scale_of(bodies)
        drawn = _draw_section(axes, bodies, scale, (contact_radius, outer_radius))
        draw.colour_bar(drawn, axes, draw.axis_label(scale.name, scale.unit), aspect=25, shrink=0.9)
    return figure


def stress_figure(bodies: Sequence[StressedBody], contact_radius: float, outer_radius: float) -> Figure:
    """
    The stress in section, below the centre of the contact, and at the surface.

    Parameters
    ----------
    bodies : sequence of StressedBody
        One, or both, with components on the axis and at the surface.
    contact_radius, outer_radius : float
        Radii in m of the contact and of its cohesive zone.
    """
    with draw.new_figure(10.0, 4.4 if len(bodies) == 1 else 5.2) as figure:
        _widen(figure)
        grid = figure.add_gridspec(2, 2, width_ratios=(1.35, 1.0))
        section = figure.add_subplot(grid[:, 0])
        scale = _scale_of(bodies)
        drawn = _draw_section(section, bodies, scale, (contact_radius, outer_radius))
        draw.colour_bar(drawn, section, draw.axis_label(scale.name, scale.unit), aspect=30, shrink=0.85)
        centre, surface = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
        _draw_lines(centre, [(body.side, body.axis) for body in bodies if body.axis is not None], "z", scale)
        centre.set_xlabel(draw.with_unit(DEPTH.label, scale.length))
        _draw_lines(
            surface, [(b.side, b.surface) for b in bodies if b.surface is not None], bodies[0].along, scale
        )
        surface.set_xlabel(_across(bodies[0], scale.length))
        draw.mark_radii(surface, contact_radius, outer_radius, scale.length, both_sides=True, named=False)
        # one legend for both panels
        own = centre.get_legend_handles_labels()[1]
        for label in surface.get_legend_handles_labels()[1]:
            if label not in own:
                centre.plot([], [], color=_LINES[label[9:-2]], lw=1.3, label=label)
        if len(bodies) > 1:
            centre.plot([], [], color=draw.GREY, lw=1.3, ls="--", label="counterbody")
        draw.legend_above(centre)
    return figure


def _widen(figure: Figure) -> None:
    """Leave room at the left: labels of axes of equal scales are laid out before these shrink."""
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    figure.set_layout_engine(ConstrainedLayoutEngine(rect=(0.02, 0.0, 0.98, 1.0)))


def _across(body: StressedBody, unit: str) -> str:
    return draw.with_unit((ALONG if body.along == "x" else RADIUS).label, unit)


def _draw_section(
    axes: Axes, bodies: Sequence[StressedBody], scale: _Scale, radii: tuple[float, float]
) -> Any:
    """Filled contours of one body, or of both, the counterbody above the surface."""
    ends, drawn = [0.0, 0.0], None
    low, top = float(scale.levels[0]), float(scale.levels[-1])
    beyond = 0.0 if scale.bounded else 0.5 * (top - low)
    extend = "neither" if scale.bounded else "max" if low == 0.0 else "both" if top > 0.0 else "min"
    for body in bodies:
        upward = body.side == "counterbody" and len(bodies) > 1
        across, z = (draw.lengths(body.field[axis].values, scale.length) for axis in (body.along, "z"))
        shown = draw.scaled(body.field.values, scale.name, scale.unit)
        # rows without any value lie in a rigid base, other values that are no numbers are infinite
        rigid = np.isnan(shown).all(axis=1)
        shown = np.where(np.isnan(shown), np.inf, shown).clip(
            low - beyond * (low < 0.0), top + beyond * (top > 0.0)
        )
        shown[rigid] = np.nan
        if body.along == "r":
            across = np.concatenate([-across[:0:-1], across])
            shown = np.concatenate([shown[:, :0:-1], shown], axis=1)
        heights = -z if upward else z
        drawn = axes.contourf(across, heights, shown, levels=scale.levels, extend=extend, **scale.colours)
        # a depth that is read twice is an interface, with both its sides
        for interface in heights[1:][np.diff(heights) == 0.0]:
            axes.axhline(float(interface), color="white", lw=0.8, ls=(0, (5, 3)))
        ends[0 if upward else 1] = float(heights[-1])
    axes.axhline(0.0, color="black", lw=0.6)
    contact = float(draw.lengths(np.array(max(radii)), scale.length))
    axes.plot([-contact, contact], [0.0, 0.0], color="black", lw=2.5, solid_capstyle="butt", clip_on=False)
    draw.mark_radii(axes, *radii, scale.length, both_sides=True)
    for body in bodies:
        if body.largest is not None:
            _mark_largest(axes, body, scale.length, upward=body.side == "counterbody" and len(bodies) > 1)
        if len(bodies) > 1:
            place = (0.02, 0.98) if body.side == "counterbody" else (0.02, 0.02)
            axes.text(
                *place,
                body.side,
                transform=axes.transAxes,
                va="top" if place[1] > 0.5 else "bottom",
                color="black" if scale.name in _SIGNED else "white",
                fontsize=draw.SMALL,
            )
    axes.set(
        xlabel=_across(bodies[0], scale.length),
        ylabel=draw.with_unit(DEPTH.label, scale.length),
        aspect="equal",
    )
    axes.set_ylim(ends[1], ends[0])
    if ends[0] < 0.0:
        from matplotlib.ticker import FuncFormatter

        # both depths are counted from the surface
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{abs(value):g}"))
    if why := next((body.unbounded for body in bodies if body.unbounded), ""):
        axes.set_title(f"the stress is infinite {why}", color=draw.ORANGE, fontsize=draw.SMALL, loc="left")
    return drawn


def _mark_largest(axes: Axes, body: StressedBody, unit: str, *, upward: bool) -> None:
    """The place and the value of the largest stress."""
    largest = body.largest
    assert largest is not None
    place, depth = (float(draw.lengths(largest[axis].values, unit)) for axis in (body.along, "z"))
    places = sorted({-place, place}) if body.along == "r" else [place]
    depth = -depth if upward else depth
    axes.plot(places, [depth] * len(places), "o", color="white", ms=5, mec="black", clip_on=False, zorder=5)
    axes.annotate(
        written(float(largest), "Pa"),
        (place, depth),
        (6, 4 if upward else -4),
        textcoords="offset points",
        color="black",
        va="bottom" if upward else "top",
        fontsize=draw.SMALL,
        bbox={"facecolor": "white", "alpha": 0.6, "lw": 0.0, "pad": 1.0},
    )


def _draw_lines(axes: Axes, lines: Sequence[tuple[str, xr.DataArray]], along: str, scale: _Scale) -> None:
    """Components of the stress of one body along a line, dashed in the counterbody where both are drawn."""
    seen: list[FloatArray] = []
    for side, line in lines:
        dashed = side == "counterbody" and len(lines) > 1
        x = draw.lengths(line[along].values, scale.length)
        finest = _NOTHING * float(np.max(np.abs(line.values[np.isfinite(line.values)]), initial=0.0))
        previous = np.zeros(0)
        for component in line["component"].values.tolist():
            if component not in _LINES:
                continue
            values = draw.scaled(line.sel(component=component).values, "stress", scale.unit)
            if (
                previous.size
                and component in ("tt", "yy")
                and np.allclose(values, previous, rtol=1e-9, equal_nan=True)
            ):
                continue
            previous = values
            if not np.nanmax(np.abs(line.sel(component=component).values), initial=0.0) > finest:
                continue
            finite = np.where(np.isfinite(values), values, np.nan)
            at = x
            if along == "r":
                odd = -1.0 if component == "rz" else 1.0
                at = np.concatenate([-x[:0:-1], x])
                finite = np.concatenate([odd * finite[:0:-1], finite])
            dashes, label = "--" if dashed else "-", None if dashed else f"$\\sigma_{{{component}}}$"
            axes.plot(at, finite, color=_LINES[component], lw=1.3, ls=dashes, label=label)
            seen.append(finite[np.isfinite(finite)])
    axes.axhline(0.0, color=draw.GREY, lw=0.6)
    axes.set_ylabel(draw.with_unit("stress $\\sigma$", scale.unit))
    if seen and not scale.bounded:
        every = np.concatenate(seen)
        low, high = np.quantile(every, [1.0 - _DRAWN, _DRAWN])
        margin = 0.3 * (max(float(high), 0.0) - min(float(low), 0.0))
        axes.set_ylim(min(float(low), 0.0) - margin, max(float(high), 0.0) + margin)


class StressFrame(NamedTuple):
    """One row of an animation."""

    bodies: Sequence[StressedBody]
    radii: tuple[float, float]
    """Radii in m of the contact and of its cohesive zone."""


def write_stress_animation(
    frames: Sequence[StressFrame], history: tuple[xr.DataArray, xr.DataArray], rows: FloatArray, file: Path
) -> None:
    """
    The stress in section next to the curve or loop of the path, row by row, as a GIF.

    Parameters
    ----------
    frames : sequence of StressFrame
    history : tuple of xarray.DataArray
        Abscissa and ordinate of the curve over all rows.
    rows : ndarray of int
        The row of every frame.
    file : path
        Ends with ``.gif``.
    """
    from matplotlib.animation import PillowWriter
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    (x, x_unit), (y, y_unit) = (_converted(one) for one in history)
    scale = _scale_of([body for frame in frames for body in frame.bodies])
    with draw.new_figure(9.0, 4.6 if len(frames[0].bodies) > 1 else 3.4, letters=False) as figure:
        _widen(figure)
        FigureCanvasAgg(figure)
        left, right = figure.subplots(1, 2, width_ratios=(1.5, 1.0))
        drawn = _draw_section(left, frames[0].bodies, scale, frames[0].radii)
        draw.colour_bar(drawn, left, draw.axis_label(scale.name, scale.unit), aspect=25, shrink=0.9)
        right.plot(x, y, color=draw.GREY, lw=1.0)
        (point,) = right.plot(x[rows[:1]], y[rows[:1]], "o", color=draw.ORANGE, ms=7)
        right.set_xlabel(draw.axis_label(str(history[0].name), x_unit))
        right.set_ylabel(draw.axis_label(str(history[1].name), y_unit))
        writer = PillowWriter(fps=8)
        with writer.saving(figure, str(file), dpi=90):
            for frame, row in zip(frames, rows, strict=True):
                left.clear()
                _draw_section(left, frame.bodies, scale, frame.radii)
                point.set_data(x[[row]], y[[row]])
                writer.grab_frame()


def _converted(column: xr.DataArray) -> tuple[FloatArray, str]:
    unit = good_unit(column.values, str(column.attrs["units"]))
    return draw.scaled(column.values, str(column.name), unit), unit
