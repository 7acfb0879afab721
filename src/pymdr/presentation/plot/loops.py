"""Loops of adhesive contacts: force and radii over travel or indentation, with jumps and their losses."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from textwrap import fill

import numpy as np

from pymdr.errors import PymdrError
from pymdr.interpretation.jumps import Branches, Jump
from pymdr.presentation.plot import shared as draw
from pymdr.quantities import QUANTITIES
from pymdr.units import FloatArray, good_unit, written

_DRAWN_JUMPS = 100
_LINE = 60
"""Characters per line of small text in a loop."""
_DEEP = 6.0
"""Ratio of largest force to largest pull above which the pull is enlarged in an inset."""


@dataclass(frozen=True)
class Course:
    """A path among the equilibria of its contact; made by :func:`course_of`."""

    data: draw.FigureData
    branches: Branches | None
    """None if the bodies never touch or the equilibria are not known."""
    trail: Mapping[str, FloatArray]
    """Quantities by name along the path, in SI units, with nan inside jumps."""
    unknown: str = ""
    """Reason why the equilibria are not known."""

    @property
    def jumps(self) -> tuple[Jump, ...]:
        """Distinct jumps, up to the number that is drawn."""
        return () if self.branches is None else self.branches.jumps[:_DRAWN_JUMPS]

    @property
    def joined(self) -> bool:
        """Whether the states between the rows are known."""
        return not self.unknown if self.branches is None else self.branches.complete

    def extent(self, name: str) -> FloatArray:
        """Smallest and largest value of a quantity on the path and in its jumps; empty without values."""
        values = [self.trail[name], *(jump.outline[name] for jump in self.jumps)]
        finite = np.concatenate(values)
        finite = finite[np.isfinite(finite)]
        return np.array([finite.min(), finite.max()]) if finite.size else finite


def course_of(data: draw.FigureData) -> Course:
    """The course of an adhesive path, also between its rows if they are few."""
    unknown = ""
    try:
        branches = None if data.equilibria is None else data.equilibria()
    except PymdrError as error:
        # equilibria between the rows may lie outside the solved range
        branches, unknown = None, str(error)
    if branches is not None:
        return Course(data, branches, branches.trail)
    names = ("indentation", "travel", "normal_force", "contact_radius", "cohesive_radius")
    rows = {name: data.data[name].values for name in names if name in data.data}
    return Course(data, None, rows, unknown)


def draw_loop(axes: draw.Axes, course: Course, across: str) -> None:
    """Force over travel or indentation: the path on all equilibria, its jumps and their losses."""
    plane = _plane(axes, course, across, "normal_force")
    if plane is None:
        return
    draw.draw_zero(axes)
    _shade_losses(plane, course)
    _draw_band(plane, course)
    _draw_equilibria(plane, course)
    _draw_path(plane, course, draw.BLUE, "path")
    _draw_jumps(plane, course)
    _mark_row(plane, course.data)
    _mark_pull_off(plane, course)
    if course.branches is None:
        text = "the surfaces never touch"
        if course.unknown:
            text = fill(f"equilibria between the rows are not known: {course.unknown}", _LINE)
        axes.text(
            0.5,
            0.9,
            text,
            ha="center",
            va="top",
            color=draw.GREY,
            fontsize=draw.SMALL,
            transform=axes.transAxes,
        )
    _enlarge_pull(plane, course)
    draw.legend_above(axes)


def draw_radius(axes: draw.Axes, course: Course) -> None:
    """Contact radius, and that of the cohesive zone, over the indentation."""
    cohesive = "cohesive_radius" in course.data.data
    plane = _plane(axes, course, "indentation", "cohesive_radius" if cohesive else "contact_radius")
    if plane is None:
        return
    _draw_equilibria(plane, course)
    if cohesive:
        _draw_path(plane, course, draw.GREEN, QUANTITIES["cohesive_radius"].label)
        _draw_jumps(plane, course, labelled=False)
        plane = _Plane(axes, "indentation", "contact_radius", plane.x_unit, plane.y_unit)
        _draw_equilibria(plane, course, labelled=False)
        axes.set_ylabel(f"radius ({plane.y_unit})")
    _draw_band(plane, course)
    _draw_path(plane, course, draw.BLUE, QUANTITIES["contact_radius"].label)
    _draw_jumps(plane, course)
    _mark_row(plane, course.data)
    draw.begin_at_zero(axes)
    draw.legend_above(axes)


@dataclass(frozen=True)
class _Plane:
    """Two quantities against each other, in their units."""

    axes: draw.Axes
    across: str
    up: str
    x_unit: str
    y_unit: str

    def points(self, values: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Values by name in the units of the axes."""
        x, y = values[self.across], values[self.up]
        return draw.scaled(x, self.across, self.x_unit), draw.scaled(y, self.up, self.y_unit)


def _plane(axes: draw.Axes, course: Course, across: str, up: str) -> _Plane | None:
    """Axes with labels and limits; None, with a text in their place, if there is nothing to draw."""
    data = course.data
    if across not in data.data or up not in data.data:
        draw.show_refusal(axes, data)
        return None
    x, y = course.extent(across), course.extent(up)
    if x.size == 0 or y.size == 0:
        draw.show_text(axes, "no contact at any step")
        return None
    plane = _Plane(axes, across, up, good_unit(x, "m"), good_unit(y, QUANTITIES[up].unit))
    for ends, unit, name, limit in (
        (x, plane.x_unit, across, axes.set_xlim),
        (y, plane.y_unit, up, axes.set_ylim),
    ):
        low, high = draw.scaled(np.array([min(ends[0], 0.0), max(ends[1], 0.0)]), name, unit)
        margin = 0.08 * (high - low) or 1.0
        limit(low - margin, high + margin)
    axes.set(xlabel=draw.axis_label(across, plane.x_unit), ylabel=draw.axis_label(up, plane.y_unit))
    return plane


def _draw_equilibria(plane: _Plane, course: Course, *, labelled: bool = True) -> None:
    if course.branches is None:
        return
    x, y = plane.points(course.branches.curve)
    # the slope vanishes at the first touch; a fold belongs to both branches
    stable = np.append(course.branches.stable[1], course.branches.stable[1:])
    unstable = ~stable | np.append(~stable[1:], False) | np.append(False, ~stable[:-1])
    for selected, dashes, label in (
        (stable, "-", "stable equilibria"),
        (unstable, (0, (4, 2)), "unstable equilibria"),
    ):
        if selected.any():
            plane.axes.plot(
                np.where(selected, x, math.nan),
                y,
                color=draw.GREY,
                lw=1.0,
                ls=dashes,
                label=label if labelled else None,
                zorder=1.5,
            )


def _draw_band(plane: _Plane, course: Course) -> None:
    """The band of the scatter over each monotone part of the path."""
    if plane.up not in course.data.bands:
        return
    x = draw.scaled(course.data.data[plane.across].values, plane.across, plane.x_unit)
    low, high = (draw.scaled(end, plane.up, plane.y_unit) for end in course.data.bands[plane.up])
    turns = np.flatnonzero(np.diff(np.sign(np.diff(x))) != 0.0) + 1
    label: str | None = "band of the scatter"
    for start, stop in pairwise([0, *turns.tolist(), x.size - 1]):
        part = slice(start, stop + 1)
        plane.axes.fill_between(x[part], low[part], high[part], color=draw.BLUE, alpha=0.2, lw=0, label=label)
        label = None


def _enlarge_pull(plane: _Plane, course: Course) -> None:
    """Enlarge the part below zero in an inset if the loop is deep."""
    force, across = course.trail["normal_force"], course.trail[plane.across]
    least, most = course.extent("normal_force")
    if not most > _DEEP * -least > 0.0:
        return
    shown = (np.abs(force) <= -least) & (force != 0.0)
    ends = [across[shown], *(jump.states[plane.across] for jump in course.jumps)]
    known = np.concatenate(ends)
    known = known[np.isfinite(known)]
    margin = 0.25 * np.ptp(known)
    if margin == 0.0:  # one row is no curve
        return
    inset = plane.axes.inset_axes((0.08, 0.5, 0.38, 0.44))
    inset.set_xlim(
        *draw.scaled(np.array([known.min() - margin, known.max() + margin]), plane.across, plane.x_unit)
    )
    inset.set_ylim(*draw.scaled(np.array([1.3 * least, -least]), plane.up, plane.y_unit))
    inset.tick_params(labelsize=draw.SMALL)
    draw.draw_zero(inset)
    enlarged = replace(plane, axes=inset)
    _shade_losses(enlarged, course)
    _draw_band(enlarged, course)
    _draw_equilibria(enlarged, course, labelled=False)
    _draw_path(enlarged, course, draw.BLUE, "path")
    _draw_jumps(enlarged, course)
    _mark_row(enlarged, course.data)
    _mark_pull_off(enlarged, course)
    plane.axes.indicate_inset_zoom(inset, edgecolor=draw.GREY, alpha=0.6)


def _draw_path(plane: _Plane, course: Course, colour: str, label: str) -> None:
    """The path as a line, with its rows as points if they are few or the line is not known."""
    if course.joined:
        plane.axes.plot(*draw.thinned_curve(*plane.points(course.trail)), color=colour, lw=1.6, label=label)
    if not course.joined or course.data.data.sizes["step"] <= draw.MARKED_ROWS:
        rows = {name: course.data.data[name].values for name in (plane.across, plane.up)}
        row_label = None if course.joined else label
        plane.axes.plot(*plane.points(rows), color=colour, ls="none", marker="o", ms=3.0, label=row_label)


def _shade_losses(plane: _Plane, course: Course) -> None:
    label: str | None = "lost in jumps"
    if "jump_dissipation" in course.data.data:
        dissipated = course.data.data["jump_dissipation"].values
        label = f"lost in jumps, {written(float(np.nansum(dissipated)), 'J')}"
    for jump in course.jumps:
        if jump.loss > 0.0 and math.isfinite(jump.loss):
            x, y = plane.points(jump.outline)
            plane.axes.fill(x, y, color=draw.ORANGE, alpha=0.15, lw=0, label=label, zorder=1)
            label = None


def _draw_jumps(plane: _Plane, course: Course, *, labelled: bool = True) -> None:
    sloped = plane.up == "normal_force" and plane.across == "indentation" and "travel" in course.data.data
    label: str | None = "jump, slope $-k$" if sloped else "jump"
    if not labelled:
        label = None
    left = plane.axes.get_xlim()[0]
    for jump in course.jumps:
        x, y = plane.points(jump.states)
        if not np.isfinite(x[1]):
            # pull-off under force control: no further equilibrium
            x = np.array([x[0], left if plane.up == "normal_force" else x[0]])
        plane.axes.plot(x, y, color=draw.ORANGE, lw=1.1, label=label, zorder=2.5)
        label = None
        if labelled:
            _point(plane.axes, x, y)


def _point(axes: draw.Axes, x: FloatArray, y: FloatArray) -> None:
    """An arrowhead near the middle of a line, if it is long enough."""
    spans = [limits[1] - limits[0] for limits in (axes.get_xlim(), axes.get_ylim())]
    if math.hypot((x[1] - x[0]) / spans[0], (y[1] - y[0]) / spans[1]) < 0.03:
        return
    tail, head = (np.array([x[0] + t * (x[1] - x[0]), y[0] + t * (y[1] - y[0])]) for t in (0.45, 0.6))
    style = {
        "arrowstyle": "-|>",
        "color": draw.ORANGE,
        "lw": 0.0,
        "mutation_scale": 11,
        "shrinkA": 0,
        "shrinkB": 0,
    }
    arrow = axes.annotate("", xy=(head[0], head[1]), xytext=(tail[0], tail[1]), arrowprops=style)
    arrow.set_in_layout(False)


def _mark_row(plane: _Plane, data: draw.FigureData) -> None:
    if data.row < 0 or data.data.sizes["step"] < 2:
        return
    here = {name: data.data[name].values[[data.row]] for name in (plane.across, plane.up)}
    x, y = plane.points(here)
    if np.isfinite([x[0], y[0]]).all():
        label = draw.row_name(data, data.row)
        plane.axes.plot(x, y, "o", mfc="white", mec=draw.BLUE, ms=5, label=label, zorder=3)


def _mark_pull_off(plane: _Plane, course: Course) -> None:
    """The last state before pull-off, and the largest pull if it is another state."""
    pull_offs = [
        jump
        for jump in course.jumps
        if jump.states["cohesive_radius"][1] == 0.0 and jump.states["normal_force"][0] < 0.0
    ]
    at = math.nan
    for jump in pull_offs[-1:]:
        at = float(jump.states["normal_force"][0])
        x, y = plane.points(jump.states)
        label = f"pull-off, {draw.typeset(at, 'N')}"
        plane.axes.plot(x[:1], y[:1], "o", color=draw.ORANGE, ms=4.5, zorder=3.5, label=label)
    force = course.trail["normal_force"]
    i = int(np.argmin(np.where(np.isnan(force), math.inf, force)))
    if force[i] < 0.0 and not force[i] > 1.02 * at:
        x, y = plane.points({name: course.trail[name][[i]] for name in (plane.across, plane.up)})
        label = f"largest pull, {draw.typeset(float(force[i]), 'N')}"
        plane.axes.plot(x, y, "v", color=draw.ORANGE, ms=5, zorder=3.5, label=label)
