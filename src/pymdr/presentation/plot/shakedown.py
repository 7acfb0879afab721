"""The shakedown map: pressures of first yield and shakedown over the ratio of forces."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pymdr.presentation.plot import shared as draw

if TYPE_CHECKING:
    import xarray as xr


def shakedown_map(data: xr.Dataset) -> draw.Figure:
    """
    Peak pressure over the yield stress in shear at both bounds of shakedown, against the ratio of forces.

    Parameters
    ----------
    data : xarray.Dataset
        ``pressure_ratio``, ``pressure_ratio_high`` and ``pressure_ratio_yield`` over ``force_ratio``.
    """
    with draw.new_figure(5.2, 3.8) as figure:
        axes = figure.subplots()
        ratio = data["force_ratio"].values
        first, low, high = (
            data[name].values for name in ("pressure_ratio_yield", "pressure_ratio", "pressure_ratio_high")
        )
        few = "o" if ratio.size <= draw.MARKED_ROWS else None
        axes.plot(ratio, first, color=draw.GREY, lw=1.2, ls="--", label="first yield", marker=few, ms=3.0)
        axes.plot(ratio, low, color=draw.BLUE, lw=1.5, label="shakedown, safe", marker=few, ms=3.0)
        axes.plot(ratio, high, color=draw.ORANGE, lw=1.2, label="upper bound", marker=few, ms=3.0)
        axes.fill_between(ratio, low, high, color=draw.ORANGE, alpha=0.15, lw=0)
        axes.fill_between(ratio, first, low, color=draw.BLUE, alpha=0.12, lw=0)
        axes.set(
            xlabel="tangential over normal force $Q/F$",
            ylabel="peak pressure over yield stress in shear $p_0/k$",
            xlim=(float(ratio[0]), float(ratio[-1])),
        )
        axes.set_ylim(bottom=0.0)
        draw.legend_above(axes)
    return figure
