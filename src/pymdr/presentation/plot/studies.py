"""Figures of studies without a path."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import QUANTITIES
from pymdr.units import FloatArray, from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr

    from pymdr.interpretation.validity import Assumption

_ABREAST = 4
"""Largest number of panels beside each other."""


def loop_study(studies: Sequence[tuple[float | None, xr.Dataset]]) -> draw.Figure:
    """
    Dissipation, damping ratio and stiffness of steady loops against their amplitude.

    Parameters
    ----------
    studies : sequence of (coefficient, xarray.Dataset)
        For every coefficient of friction (None if there is only one) ``amplitude`` (m), ``dissipated_per_cycle``
        (J), ``damping_ratio`` and ``secant_stiffness`` (N/m) in one dimension, with ``sliding_shift`` (m).
    """
    with draw.new_figure(10.4, 3.5) as figure:
        amplitudes = np.concatenate([study["amplitude"].values for _, study in studies])
        unit = good_unit(amplitudes, "m")
        columns = (
            ("dissipated_per_cycle", "energy dissipated per cycle", "J"),
            ("damping_ratio", "damping ratio", ""),
            ("secant_stiffness", "secant stiffness", "N/m"),
        )
        for axes, (name, y_label, si) in zip(figure.subplots(1, 3), columns, strict=True):
            values = np.concatenate([study[name].values for _, study in studies])
            shown = good_unit(values, si) if si else ""
            axes.set_xscale("log" if amplitudes.size > len(studies) else "linear")
            if name == "dissipated_per_cycle" and (values > 0.0).any():
                axes.set_yscale("log")
            for i, (mu, study) in enumerate(studies):
                order = np.argsort(study["amplitude"].values)
                u, sliding = study["amplitude"].values[order], float(study["sliding_shift"].values)
                x, limit = draw.lengths(u, unit), draw.lengths(np.array(sliding), unit)
                y = study[name].values[order]
                y = np.asarray(from_si(y, si, shown)) if si else y
                if mu is None and u.min() < sliding < u.max():
                    axes.axvline(float(limit), color=draw.ORANGE, lw=1.0, ls=":", label="sliding begins")
                if mu is None and name == "dissipated_per_cycle" and (y > 0.0).any():
                    _draw_cubic(axes, x, y, limit)
                few = "o" if u.size <= draw.MARKED_ROWS else None
                colour, label = (
                    (draw.BLUE, None) if mu is None else (draw.CYCLE[i % len(draw.CYCLE)], f"$\\mu$ = {mu:g}")
                )
                axes.plot(x, y, color=colour, lw=1.5, marker=few, ms=3, label=label)
                if f"{name}_low" in study:
                    ends = [study[f"{name}_{end}"].values[order] for end in ("low", "high")]
                    low, high = (np.asarray(from_si(v, si, shown)) if si else v for v in ends)
                    band = "band of the scatter" if mu is None else None
                    axes.fill_between(x, low, high, color=colour, alpha=0.2, lw=0, label=band)
            axes.set(xlabel=f"amplitude of the shift ({unit})", ylabel=draw.with_unit(y_label, shown))
            if name == "damping_ratio":
                axes.set_ylim(bottom=0.0)
            draw.legend_above(axes)
    return figure


def _draw_cubic(axes: draw.Axes, x: FloatArray, y: FloatArray, sliding: FloatArray) -> None:
    """The cubic law of small loops, from the smallest dissipating one."""
    first = int(np.flatnonzero(y > 0.0)[np.argmin(x[y > 0.0])])
    end = max(min(float(x.max()), float(sliding)), x[first])
    if end > x[first]:
        ends = np.array([x[first], end])
        cube = y[first] * (ends / ends[0]) ** 3
        axes.plot(ends, cube, color=draw.GREY, lw=1.0, ls="--", label="cube of the amplitude")


def columns_study(
    data: xr.Dataset, labels: Mapping[str, str], curve: xr.Dataset | None = None
) -> draw.Figure:
    """
    Columns of a study over its rows, a panel each, after one of a curve.

    Parameters
    ----------
    data : xarray.Dataset
        Over one dimension.
    labels : mapping of str to str
        Axis labels by column.
    curve : xarray.Dataset, optional
        Two quantities in SI units, the second over the first.
    """
    (along,) = data.dims
    names = [
        name for name in labels if name in data.data_vars and not np.all(np.isnan(data[name].values))
    ]  # a column that no row has would be an empty panel
    before = int(curve is not None)
    rows = max(math.ceil((len(names) + before) / _ABREAST), 1)
    columns = max(math.ceil((len(names) + before) / rows), 1)
    with draw.new_figure(2.9 * columns, 2.9 * rows) as figure:
        if curve is not None:
            _draw_curve(figure.add_subplot(rows, columns, 1), curve)
        for i, name in enumerate(names, 1 + before):
            axes = figure.add_subplot(rows, columns, i)
            si = str(data[name].attrs.get("units", ""))
            unit = good_unit(data[name].values, si)
            values = np.asarray(from_si(data[name].values, si, unit))
            axes.plot(data[along].values, values, "o-", color=draw.BLUE, ms=3.0, lw=1.0)
            draw.label_history(axes, str(along))
            label = QUANTITIES[name].label if name in QUANTITIES else labels[name]
            axes.set_ylabel(draw.with_unit(label, unit))
            draw.limit_rounding(axes, values)
    return figure


def _draw_curve(axes: draw.Axes, curve: xr.Dataset) -> None:
    """One quantity over another."""
    names = [str(name) for name in curve]
    units = [good_unit(curve[name].values, QUANTITIES[name].unit) for name in names]
    some = draw.thinned(curve[names[1]].values)
    x, y = (
        draw.scaled(curve[name].values[some], name, unit) for name, unit in zip(names, units, strict=True)
    )
    axes.plot(x, y, color=draw.BLUE, lw=0.8)
    axes.set(xlabel=draw.axis_label(names[0], units[0]), ylabel=draw.axis_label(names[1], units[1]))


def conditions_study(assumptions: Sequence[Assumption]) -> draw.Figure:
    """Assumptions of a model, each relative to its limit."""
    with draw.new_figure(6.4, 1.2 + 0.35 * len(assumptions)) as figure:
        axes = figure.add_subplot()
        colours = [draw.BLUE if a.met else draw.ORANGE for a in assumptions]
        measures, limits = (np.array([getattr(a, n) for a in assumptions]) for n in ("measure", "limit"))
        with np.errstate(divide="ignore", invalid="ignore"):
            axes.barh([a.name for a in assumptions], np.minimum(measures / limits, 3.0), color=colours)
        axes.axvline(1.0, color=draw.GREY, lw=1.0)
        axes.invert_yaxis()
        axes.set_xlabel("measure / limit (cut at 3)")
    return figure
