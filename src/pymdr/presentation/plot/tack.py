"""The figures of pull-off over speeds and dwells, and of the work of an edge over its speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.units import FloatArray, from_si, good_unit, written

if TYPE_CHECKING:
    import xarray as xr

_CURVES = 6
"""Largest number of dwells or speeds that are drawn."""
_COLOURS = (draw.BLUE, draw.ORANGE, draw.GREEN)


def pull_off_speeds(data: xr.Dataset, tests: Sequence[xr.Dataset]) -> draw.Figure:
    """
    Force against depth at several speeds after the last dwell, largest pull with its limits, and effective work of adhesion, over the speed; over the dwell if there is one speed.

    Parameters
    ----------
    data : xarray.Dataset
        ``largest_pull`` (N) and ``effective_work`` (J/m^2) over ``speed`` (m/s) and ``dwell`` (s), ``slow_limit`` (N), and ``fast_limit`` (N)
        over ``dwell``.
    tests : sequence of xarray.Dataset
        ``indentation`` (m), ``normal_force`` (N) and ``cohesive_radius`` (m) of the tests after the last dwell, one for every speed.
    """
    along, other = (
        ("dwell", "speed") if data.sizes["speed"] == 1 < data.sizes["dwell"] else ("speed", "dwell")
    )
    known = [name for name in ("largest_pull", "effective_work") if data[name].notnull().any()]
    with draw.new_figure(4.4 * (1 + len(known)), 4.0) as figure:
        loops, *panels = figure.subplots(1, 1 + len(known))
        _draw_tests(loops, data["speed"].values, tests)
        for axes, name in zip(panels, known, strict=True):
            _draw(axes, data, name, along, other)
    return figure


def _some(size: int) -> list[int]:
    """Evenly spaced rows, no more than are drawn."""
    rows: list[int] = np.unique(np.linspace(0, size - 1, min(size, _CURVES)).round().astype(int)).tolist()
    return rows


def _draw_tests(axes: draw.Axes, speeds: FloatArray, tests: Sequence[xr.Dataset]) -> None:
    """Force against depth while the bodies attract each other, one curve for every speed."""
    rows = _some(speeds.size)
    curves = []
    for row in rows:
        on = tests[row]["cohesive_radius"].values > 0.0
        curves.append([tests[row][name].values[on] for name in ("indentation", "normal_force")])
    x_unit, unit = (good_unit(np.concatenate([one[i] for one in curves]), ("m", "N")[i]) for i in (0, 1))
    for k, (row, (depth, force)) in enumerate(zip(rows, curves, strict=True)):
        x, y, dashes = from_si(depth, "m", x_unit), from_si(force, "N", unit), ("-", "--")[k // 3]
        label = f"speed {written(float(speeds[row]), 'm', 3)}/s"
        axes.plot(x, y, color=_COLOURS[k % 3], ls=dashes, lw=1.4, label=label)
    draw.draw_zero(axes)
    axes.set(xlabel=draw.axis_label("indentation", x_unit), ylabel=draw.axis_label("normal_force", unit))
    draw.legend_above(axes)


def _draw(axes: draw.Axes, data: xr.Dataset, name: str, along: str, other: str) -> None:
    """A quantity over the speed or the dwell, one curve for every value of the other."""
    pulls = name == "largest_pull"
    data = data.sortby(along)
    values = (-data[name] if pulls else data[name]).transpose(other, along).values
    x = data[along].values
    x_unit, unit = good_unit(x, "m/s" if along == "speed" else "s"), good_unit(values, data[name].units)
    rows, has_fast = _some(data.sizes[other]), data["fast_limit"].notnull().any()
    shown_x = np.asarray(from_si(x, "m/s" if along == "speed" else "s", x_unit))
    for k, row in enumerate(rows):
        value = float(data[other].values[row])
        at = f"{written(value, 'm', 3)}/s" if other == "speed" else written(value, "s", 3)
        y = from_si(values[row], data[name].units, unit)
        style: dict[str, Any] = {"color": _COLOURS[k % 3], "ls": ("-", "--")[k // 3], "lw": 1.4, "ms": 3.5}
        few = "o" if x.size <= draw.MARKED_ROWS else None
        axes.plot(shown_x, y, marker=few, label=f"{other} {at}", **style)
        if pulls and other == "dwell" and has_fast:
            fast = float(from_si(-float(data["fast_limit"].values[row]), "N", unit))
            axes.axhline(fast, color=_COLOURS[k % 3], ls=":", lw=1.0, label="fast limit" if k == 0 else None)
    if pulls and along == "dwell" and has_fast:
        fast = from_si(-data["fast_limit"].values, "N", unit)
        axes.plot(shown_x, fast, color=draw.GREY, ls=":", lw=1.2, label="fast limit")
    if pulls and data["slow_limit"].notnull():
        slow = float(from_si(-float(data["slow_limit"]), "N", unit))
        axes.axhline(slow, color=draw.GREY, ls="--", lw=1.0, label="slow limit")
    if x.size > 1 and x.min() > 0.0:
        axes.set_xscale("log")
    if values.min() > 0.0 and values.max() > 5.0 * values.min():
        axes.set_yscale("log")
    axes.set_xlabel(draw.axis_label(along, x_unit))
    axes.set_ylabel(f"largest pull $-F_N$ ({unit})" if pulls else draw.axis_label(name, unit))
    draw.legend_above(axes)


def edge_work_figure(data: xr.Dataset) -> draw.Figure:
    """
    Energy release rate over the speed of the edge, and the formula of a short zone with its limits; its difference over the length of the zone.

    Parameters
    ----------
    data : xarray.Dataset
        Of the study of the work of an edge, over ``row``, with its single numbers.
    """
    V, G, formula = (data[name].values for name in ("edge_speed", "energy_release_rate", "short_zone_work"))
    holds, test = data["holds"].values, data["test"].values
    v_unit, unit = good_unit(V, "m/s"), good_unit(formula, "J/m^2")
    x, rates, expected = from_si(V, "m/s", v_unit), from_si(G, "J/m^2", unit), from_si(formula, "J/m^2", unit)
    rest, fast = (float(from_si(float(data[name]), "J/m^2", unit)) for name in ("work", "fast_limit"))
    fraction = data["zone_length"].values / data["contact_radius"].values
    with draw.new_figure(9.6, 4.0) as figure:
        left, right = figure.subplots(1, 2)
        for number in np.unique(test).tolist():
            own = test == number
            left.plot(x[own], rates[own], color=draw.LIGHT, lw=1.2)
        left.plot(x[~holds], rates[~holds], "o", ms=2.5, color=draw.GREY, mfc="none", label="other rows")
        left.plot(x[holds], rates[holds], ls="", marker="o", ms=2.5, color=draw.BLUE, label="within 10 %")
        order = np.argsort(x)
        left.plot(x[order], expected[order], color=draw.ORANGE, lw=1.4, label="short zone")
        left.axhline(rest, color=draw.GREY, ls="--", lw=1.0, label="at rest")
        left.axhline(fast, color=draw.GREY, ls=":", lw=1.0, label="fast limit")
        left.set(xscale="log", yscale="log", ylim=(0.4 * rest, 2.5 * fast))
        left.set_xlabel(draw.axis_label("edge_speed", v_unit))
        left.set_ylabel(draw.axis_label("energy_release_rate", unit))
        difference = np.abs(data["difference"].values)
        steady = data["receded"].values >= 1.0
        for chosen, colour, label in (
            (~steady, draw.GREY, "receded by less than its zone"),
            (steady, draw.BLUE, "by more"),
        ):
            right.plot(
                fraction[chosen], difference[chosen], "o", ms=2.5, mfc="none", color=colour, label=label
            )
        right.axhline(0.1, color=draw.GREY, ls="--", lw=1.0)
        right.set(xscale="log", yscale="log", ylim=(1e-3, 2.0))
        right.set_xlabel("length of the zone over the contact radius")
        right.set_ylabel("difference of the formula from G")
        for axes in (left, right):
            draw.legend_above(axes)
    return figure
