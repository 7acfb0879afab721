"""Figures of fits to measured curves."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
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


def fitted_map(data: xr.Dataset, names: Sequence[str]) -> Figure:
    """
    What was found in many curves: pictures over a grid of two dimensions, points over any other.

    Parameters
    ----------
    data : xarray.Dataset
        Over the grid of the curves; NaN where nothing was found.
    names : sequence of str
        The panels.

    Returns
    -------
    matplotlib.figure.Figure
    """
    dims = data["ending"].dims
    with styled():
        columns = min(len(names), 3)
        rows = -(-len(names) // columns)
        figure = new_figure(3.4 * columns, 2.9 * rows)
        panels = np.atleast_1d(figure.subplots(rows, columns)).ravel()
        for name, axes in zip(names, panels, strict=False):
            unit = good_unit(data[name].values, str(data[name].attrs["units"]))
            values = np.asarray(from_si(data[name].values, str(data[name].attrs["units"]), unit))
            words = f"{name.replace('_', ' ')} ({unit})"
            if len(dims) == 2:
                low, high = _middle(values)
                picture = axes.pcolormesh(
                    *_edges(data, dims), values, vmin=low, vmax=high, cmap="viridis", rasterized=True
                )
                axes.set_facecolor(GREY)
                axes.set_aspect("equal" if all(d in data.coords for d in dims) else "auto")
                figure.colorbar(picture, ax=axes, label=words)
                for label, dim in ((axes.set_ylabel, dims[0]), (axes.set_xlabel, dims[1])):
                    own = str(data[dim].attrs.get("units", "")) if dim in data.coords else ""
                    label(f"{dim} ({own})" if own else str(dim))
            else:
                axes.plot(np.arange(1, values.size + 1), values.ravel(), ".", color=BLUE, ms=4)
                axes.set_xlabel("curve")
                axes.set_ylabel(words)
        for axes in panels[len(names) :]:
            figure.delaxes(axes)
        letter_panels(figure)
    return figure


def _middle(values: np.ndarray) -> tuple[float, float]:
    """Where all but the outermost hundredths lie."""
    if not np.isfinite(values).any():
        return 0.0, 1.0
    low, high = (float(q) for q in np.nanquantile(values, [0.01, 0.99]))
    return (low, high) if high > low else (low - 0.5 * abs(low) - 1e-300, high + 0.5 * abs(high) + 1e-300)


def _edges(data: xr.Dataset, dims: Sequence[object]) -> tuple[np.ndarray, np.ndarray]:
    """Of the pixels, along x and y."""
    edges = []
    for dim in (dims[1], dims[0]):
        at = data[dim].values if dim in data.coords else np.arange(data.sizes[dim], dtype=float)
        step = np.diff(at) if at.size > 1 else np.ones(1)
        edges.append(
            np.concatenate([[at[0] - 0.5 * step[0]], 0.5 * (at[1:] + at[:-1]), [at[-1] + 0.5 * step[-1]]])
        )
    return edges[0], edges[1]


def weighed_laws(data: Mapping[str, xr.Dataset], weights: Mapping[str, float]) -> Figure:
    """
    A record with the models of several laws, and what each of them leaves.

    Parameters
    ----------
    data : mapping of str to xarray.Dataset
        As for :func:`fitted_curves`, by the names of the laws.
    weights : mapping of str to float
        Akaike's.

    Returns
    -------
    matplotlib.figure.Figure
    """
    colours = (BLUE, ORANGE, "#4c9a2a", "#8c4bb5", "#a0522d", "#17a2b8")
    order = sorted(weights, key=lambda name: -weights[name])
    with styled():
        figure = new_figure(9.6, max(4.2, 1.3 * len(order)))
        grid = figure.add_gridspec(len(order), 2, width_ratios=[3, 2])
        curve = figure.add_subplot(grid[:, 0])
        first = data[order[0]]
        length = good_unit(first["indentation"].values, "m")
        newton = good_unit(first["normal_force"].values, "N")
        x = scaled(first["indentation"].values, "indentation", length)
        curve.plot(
            x,
            scaled(first["normal_force"].values, "normal_force", newton),
            ".",
            color=GREY,
            ms=2.5,
            alpha=0.6,
        )
        rows = [figure.add_subplot(grid[i, 1]) for i in range(len(order))]
        for name, colour, axes in zip(order, itertools.cycle(colours), rows, strict=False):
            own = data[name]
            curve.plot(
                scaled(own["indentation"].values, "indentation", length),
                np.asarray(from_si(own["model"].values, "N", newton)),
                color=colour,
                lw=1.3,
                label=f"{name} ({weights[name]:.2g})",
            )
            residual = np.where(own["used"].values, own["residual"].values, np.nan)
            unit = good_unit(first["residual"].values, "N")
            axes.plot(
                np.arange(1, residual.size + 1),
                from_si(residual, "N", unit),
                ".",
                color=colour,
                ms=2,
                rasterized=True,
            )
            axes.axhline(0.0, color=GREY, lw=0.8)
            axes.set_ylabel(f"{name} ({unit})", fontsize=8)
        rows[0].set_title("measured less model", fontsize=9)
        rows[-1].set_xlabel("sample")
        draw_zero(curve)
        curve.set_xlabel(axis_label("indentation", length))
        curve.set_ylabel(axis_label("normal_force", newton))
        legend_above(curve)
    return figure
