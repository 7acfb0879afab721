"""Figures of fits to measured curves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot.shared import (
    BLUE,
    GREY,
    ORANGE,
    axis_label,
    draw_zero,
    legend_above,
    letter_panels,
    new_figure,
    scaled,
    styled,
)
from pymdr.units import from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def fitted_curves(data: xr.Dataset, words: Sequence[str]) -> Figure:
    """
    Measured forces with the model, and what is left of them.

    Parameters
    ----------
    data : xarray.Dataset
        Over ``step``: ``indentation`` (m), ``normal_force``, ``model`` and ``residual`` (N), ``used`` and ``curve``.
    words : sequence of str
        What was found, a line each.

    Returns
    -------
    matplotlib.figure.Figure
    """
    with styled():
        figure = new_figure(9.6, 4.2)
        curve, left = figure.subplots(1, 2, width_ratios=[3, 2])
        depth, force, model = (data[name].values for name in ("indentation", "normal_force", "model"))
        length, newton = good_unit(depth, "m"), good_unit(force, "N")
        x = scaled(depth, "indentation", length)
        y, fitted = scaled(force, "normal_force", newton), np.asarray(from_si(model, "N", newton))
        used, which = data["used"].values, data["curve"].values
        curve.plot(x, y, ".", color=GREY, ms=2.5, alpha=0.6, label="measured", rasterized=True)
        for one in np.unique(which):
            curve.plot(
                x[which == one], fitted[which == one], color=BLUE, lw=1.4, label="model" if one == 0 else None
            )
        if not used.all():
            curve.plot(x[~used], y[~used], "x", color=ORANGE, ms=5, label="left out")
        draw_zero(curve)
        curve.set_xlabel(axis_label("indentation", length))
        curve.set_ylabel(axis_label("normal_force", newton))
        legend_above(curve)
        residual = np.where(used, data["residual"].values, np.nan)
        unit = good_unit(residual, "N")
        left.plot(
            np.arange(1, residual.size + 1),
            from_si(residual, "N", unit),
            ".",
            color=GREY,
            ms=2.5,
            rasterized=True,
        )
        left.axhline(0.0, color=BLUE, lw=1.0)
        left.set_xlabel("sample")
        left.set_ylabel(f"measured less model ({unit})")
        letter_panels(figure)
        figure.text(0.5, -0.02, "\n".join(words), ha="center", va="top", fontsize=8)
    return figure
