"""Figures of measured force curves with baseline and contact points."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.problem.measured import MeasuredSamples
from pymdr.units import FloatArray, good_unit

Interval = tuple[float, float, float]
"""A value with the ends of its interval."""

_COLOURS = {"approach": draw.BLUE, "hold": draw.AMBER, "retreat": draw.ORANGE, "": draw.BLUE}
_MARKS = (("outliers", "x", "outliers"), ("saturated", "s", "saturated"))


def measured_curves(
    curves: Sequence[MeasuredSamples],
    baseline: Callable[[FloatArray], FloatArray] | None = None,
    methods: Mapping[str, Interval] | None = None,
    point: Interval | None = None,
) -> draw.Figure:
    """
    The segments of a record, enlarged around the contact point.

    Parameters
    ----------
    curves : sequence of MeasuredSamples
        Of one record; the contact point belongs to its first approach.
    baseline : callable, optional
        Force in N out of contact at positions in m.
    methods : mapping of str to tuple of float, optional
        Contact point in m with its interval, by method.
    point : tuple of float, optional
        Combined contact point in m.

    Returns
    -------
    matplotlib.figure.Figure
        One panel if there is no contact point.
    """
    pressed = next((one for one in curves if one.segment in ("approach", "")), None)
    zoomed = baseline is not None and point is not None and pressed is not None
    with draw.new_figure(9.6 if zoomed else 5.6, 4.2) as figure:
        panels = figure.subplots(1, 2 if zoomed else 1, squeeze=False)[0]
        name = "travel" if curves[0].indentation is None else "indentation"
        length = good_unit(np.concatenate([one.position for one in curves]), "m")
        newton = good_unit(np.concatenate([one.force for one in curves]), "N")
        _draw_record(panels[0], curves, baseline, name, length, newton)
        if point is not None:
            panels[0].axvspan(*_ends(point, length), color=draw.LIGHT, alpha=0.6, lw=0, zorder=0)
        if baseline is not None and point is not None and pressed is not None:
            _draw_beginning(panels[1], pressed, baseline, methods or {}, point, name)
    return figure


def _draw_record(
    axes: draw.Axes,
    curves: Sequence[MeasuredSamples],
    baseline: Callable[[FloatArray], FloatArray] | None,
    name: str,
    length: str,
    newton: str,
) -> None:
    labelled: set[str] = set()
    for one in curves:
        x, y = draw.scaled(one.position, name, length), draw.scaled(one.force, "normal_force", newton)
        rows = draw.thinned(one.force)
        label = None if one.segment in labelled else one.segment or "measured"
        axes.plot(x[rows], y[rows], color=_COLOURS[one.segment], lw=1.0, label=label)
        labelled.add(one.segment)
        for marks, marker, mark_label in _MARKS:
            where = getattr(one, marks)
            if where is not None and where.any():
                label = None if mark_label in labelled else mark_label
                axes.plot(x[where], y[where], marker, color="black", ms=4, mfc="none", label=label)
                labelled.add(mark_label)
    if baseline is not None:
        ends = np.array(
            [
                min(float(one.position.min()) for one in curves),
                max(float(one.position.max()) for one in curves),
            ]
        )
        line = draw.scaled(baseline(ends), "normal_force", newton)
        axes.plot(draw.scaled(ends, name, length), line, "--", color="black", lw=0.9, label="baseline")
    axes.set(xlabel=draw.axis_label(name, length), ylabel=draw.axis_label("normal_force", newton))
    axes.locator_params(axis="x", nbins=7)
    draw.legend_above(axes)


def _draw_beginning(
    axes: draw.Axes,
    curve: MeasuredSamples,
    baseline: Callable[[FloatArray], FloatArray],
    methods: Mapping[str, Interval],
    point: Interval,
    name: str,
) -> None:
    """Force minus baseline around the contact point, with the interval of every method above."""
    value, low, high = point
    deepest = int(np.argmax(curve.position))
    x, force = (
        curve.position[: deepest + 1] - value,
        (curve.force - baseline(curve.position))[: deepest + 1],
    )
    around = 0.5 * max(high - low, 0.05 * float(np.ptp(x)))
    shown = (x >= low - value - 1.3 * around) & (x <= high - value + around)
    x, force = x[shown], force[shown]
    length, newton = good_unit(x, "m"), good_unit(force, "N")
    rows = draw.thinned(force)
    y = draw.scaled(force, "normal_force", newton)
    draw.draw_zero(axes)
    axes.axvspan(
        *_ends((0.0, low - value, high - value), length), color=draw.LIGHT, alpha=0.6, lw=0, zorder=0
    )
    moved = draw.lengths(x[rows], length)
    axes.plot(moved, y[rows], ".", color=draw.GREY, ms=2.5, alpha=0.6, rasterized=True, zorder=1)
    # the limits show the force just above its noise
    noise = float(np.median(np.abs(np.diff(y))))
    before = y[x <= 0.0]
    bottom = float(y.min())
    top = min(
        float(y.max()), max(20.0 * noise, 5.0 * float(np.quantile(before, 0.99)) if before.size else 0.0)
    )
    top = top if top > bottom else float(y.max())
    margin = (top - bottom) or 1.0
    for k, (label, (at, first, last)) in enumerate(methods.items()):
        height = top + margin * (0.12 + 0.13 * (len(methods) - k))
        places = draw.lengths(np.array([first, at, last]) - value, length)
        axes.plot(places[[0, 2]], [height, height], color=draw.BLUE, lw=1.2, solid_capstyle="butt")
        axes.plot(places[1], height, "o", color=draw.BLUE, ms=4)
        axes.annotate(
            label, (0.01, height), xycoords=axes.get_yaxis_transform(), va="center", fontsize=draw.SMALL
        )
    axes.axvline(0.0, color=draw.BLUE, lw=1.0, ls=":")
    right = float(draw.lengths(np.array(high - value + around), length))
    left = float(draw.lengths(np.array(low - value), length))
    axes.set_xlim(left - 0.4 * (right - left), right)  # space for the labels
    axes.locator_params(axis="x", nbins=7)
    axes.set_ylim(bottom - 0.05 * margin, top + margin * (0.2 + 0.13 * (len(methods) + 1)))
    axes.set(xlabel=f"{name} from the contact point ({length})", ylabel=f"force minus baseline ({newton})")


def _ends(interval: Interval, length: str) -> tuple[float, float]:
    low, high = draw.lengths(np.array(interval[1:]), length)
    return float(low), float(high)
