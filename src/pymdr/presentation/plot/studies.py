"""Figures of what was found without a path."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot.shared import (
    BLUE,
    GREY,
    MARKED_ROWS,
    ORANGE,
    good_unit,
    lengths,
    new_figure,
    styled,
)
from pymdr.units import FloatArray, from_si

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def loop_study(data: xr.Dataset) -> Figure:
    """
    Dissipation, damping ratio and stiffness of steady loops against their amplitude.

    Parameters
    ----------
    data : xarray.Dataset
        ``dissipated_per_cycle`` (J), ``damping_ratio`` and ``secant_stiffness`` (N/m) over ``amplitude`` (m), with
        the attribute ``sliding_shift`` (m).

    Returns
    -------
    matplotlib.figure.Figure
    """
    with styled():
        figure = new_figure(10.4, 3.5)
        u, slides = data["amplitude"].values, float(data.attrs["sliding_shift"])
        unit = good_unit(u, "m")
        x = lengths(u, unit)
        few = "o" if u.size <= MARKED_ROWS else None
        columns = (
            ("dissipated_per_cycle", "energy lost per cycle", "J"),
            ("damping_ratio", "damping ratio", ""),
            ("secant_stiffness", "secant stiffness", "N/m"),
        )
        for axes, (name, words, si) in zip(figure.subplots(1, 3), columns, strict=True):
            shown = good_unit(data[name].values, si) if si else ""
            y = np.asarray(from_si(data[name].values, si, shown)) if si else data[name].values
            axes.set_xscale("log" if u.size > 1 else "linear")
            if u.min() < slides < u.max():
                label = "sliding begins"
                axes.axvline(
                    float(lengths(np.array(slides), unit)), color=ORANGE, lw=1.0, ls=":", label=label
                )
            if name == "dissipated_per_cycle" and (y > 0.0).any():
                axes.set_yscale("log")
                _draw_cubic(axes, x, y, lengths(np.array(slides), unit))
            axes.plot(x, y, color=BLUE, lw=1.5, marker=few, ms=3)
            axes.set_xlabel(f"amplitude of the shift ({unit})")
            axes.set_ylabel(f"{words} ({shown})" if shown else words)
            if name == "damping_ratio":
                axes.set_ylim(bottom=0.0)
            if axes.get_legend_handles_labels()[0]:
                axes.legend(fontsize=8)
    return figure


def _draw_cubic(axes: Axes, x: FloatArray, y: FloatArray, slides: FloatArray) -> None:
    """The slope of small loops, from the smallest one that loses energy."""
    first = int(np.flatnonzero(y > 0.0)[np.argmin(x[y > 0.0])])
    end = max(min(float(x.max()), float(slides)), x[first])
    if end > x[first]:
        ends = np.array([x[first], end])
        axes.plot(
            ends, y[first] * (ends / ends[0]) ** 3, color=GREY, lw=1.0, ls="--", label="cube of the amplitude"
        )
