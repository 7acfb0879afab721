"""Figures of studies without a path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot.shared import (
    BLUE,
    CYCLE,
    GREY,
    MARKED_ROWS,
    ORANGE,
    label_history,
    legend_above,
    lengths,
    letter_panels,
    limit_rounding,
    new_figure,
    styled,
    with_unit,
)
from pymdr.quantities import QUANTITIES
from pymdr.units import FloatArray, from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pymdr.interpretation.validity import Assumption


def loop_study(studies: Sequence[tuple[float | None, xr.Dataset]]) -> Figure:
    """
    Dissipation, damping ratio and stiffness of steady loops against their amplitude.

    Parameters
    ----------
    studies : sequence of (coefficient, xarray.Dataset)
        For every coefficient of friction (None if there is only one) ``amplitude`` (m), ``dissipated_per_cycle``
        (J), ``damping_ratio`` and ``secant_stiffness`` (N/m) in one dimension, with ``sliding_shift`` (m).
    """
    with styled():
        figure = new_figure(10.4, 3.5)
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
                x, limit = lengths(u, unit), lengths(np.array(sliding), unit)
                y = study[name].values[order]
                y = np.asarray(from_si(y, si, shown)) if si else y
                if mu is None and u.min() < sliding < u.max():
                    axes.axvline(float(limit), color=ORANGE, lw=1.0, ls=":", label="sliding begins")
                if mu is None and name == "dissipated_per_cycle" and (y > 0.0).any():
                    _draw_cubic(axes, x, y, limit)
                few = "o" if u.size <= MARKED_ROWS else None
                colour, label = (BLUE, None) if mu is None else (CYCLE[i % len(CYCLE)], f"$\\mu$ = {mu:g}")
                axes.plot(x, y, color=colour, lw=1.5, marker=few, ms=3, label=label)
                if f"{name}_low" in study:
                    ends = [study[f"{name}_{end}"].values[order] for end in ("low", "high")]
                    low, high = (np.asarray(from_si(v, si, shown)) if si else v for v in ends)
                    band = "band of the scatter" if mu is None else None
                    axes.fill_between(x, low, high, color=colour, alpha=0.2, lw=0, label=band)
            axes.set_xlabel(f"amplitude of the shift ({unit})")
            axes.set_ylabel(with_unit(y_label, shown))
            if name == "damping_ratio":
                axes.set_ylim(bottom=0.0)
            legend_above(axes)
        letter_panels(figure)
    return figure


def _draw_cubic(axes: Axes, x: FloatArray, y: FloatArray, sliding: FloatArray) -> None:
    """The cubic law of small loops, from the smallest dissipating one."""
    first = int(np.flatnonzero(y > 0.0)[np.argmin(x[y > 0.0])])
    end = max(min(float(x.max()), float(sliding)), x[first])
    if end > x[first]:
        ends = np.array([x[first], end])
        axes.plot(
            ends, y[first] * (ends / ends[0]) ** 3, color=GREY, lw=1.0, ls="--", label="cube of the amplitude"
        )


def columns_study(data: xr.Dataset, labels: Mapping[str, str]) -> Figure:
    """
    Columns of a study over its rows, a panel each.

    Parameters
    ----------
    data : xarray.Dataset
        Over one dimension.
    labels : mapping of str to str
        Axis labels by column.
    """
    (along,) = data.dims
    names = [name for name in labels if name in data.data_vars]
    with styled():
        figure = new_figure(2.9 * max(len(names), 1), 2.9)
        for i, name in enumerate(names):
            axes = figure.add_subplot(1, len(names), i + 1)
            si = str(data[name].attrs.get("units", ""))
            unit = good_unit(data[name].values, si)
            values = np.asarray(from_si(data[name].values, si, unit))
            axes.plot(data[along].values, values, "o-", color=BLUE, ms=3.0, lw=1.0)
            label_history(axes, str(along))
            label = QUANTITIES[name].label if name in QUANTITIES else labels[name]
            axes.set_ylabel(with_unit(label, unit))
            limit_rounding(axes, values)
        letter_panels(figure)
    return figure


def conditions_study(assumptions: Sequence[Assumption]) -> Figure:
    """Assumptions of a model, each relative to its limit."""
    with styled():
        figure = new_figure(6.4, 1.2 + 0.35 * len(assumptions))
        axes = figure.add_subplot()
        colours = [BLUE if a.met else ORANGE for a in assumptions]
        measures, limits = (np.array([getattr(a, n) for a in assumptions]) for n in ("measure", "limit"))
        with np.errstate(divide="ignore", invalid="ignore"):
            axes.barh([a.name for a in assumptions], np.minimum(measures / limits, 3.0), color=colours)
        axes.axvline(1.0, color=GREY, lw=1.0)
        axes.invert_yaxis()
        axes.set_xlabel("measure / limit (cut at 3)")
    return figure
