"""Figures of fits to measured curves."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pymdr.errors import UnitError
from pymdr.presentation.plot import shared as draw
from pymdr.quantities import parameter_label, quantity
from pymdr.units import FloatArray, from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr

_LAWS = tuple(zip(draw.CYCLE, ("-", "--", "-.", ":", "-", "--"), strict=True))
"""Colours and dashes of laws whose curves may coincide."""
_NAMED, _LONGEST = 8, 14
"""Largest number of groups whose names are drawn, and characters of a name."""
_TITLE = 26
"""Last characters of the name of a record on a sheet."""
_SMALL = 0.005
"""Smallest weight that is printed."""


def fitted_curves(data: xr.Dataset, captions: Sequence[str]) -> draw.Figure:
    """
    Measured forces with the model, and the residuals.

    Parameters
    ----------
    data : xarray.Dataset
        Over ``step``: ``indentation`` (m) and ``normal_force`` (N), or ``shift`` (m) and ``tangential_force`` (N), ``model`` and
        ``residual`` (N), ``used`` and ``curve``; normal forces are drawn over ``time`` (s) if given.
    captions : sequence of str
        Fitted parameters, one line each.
    """
    with draw.new_figure(9.6, 4.0 + 0.16 * len(captions)) as figure:
        curve, rest = figure.subplots(1, 2, width_ratios=[3, 2])
        along, force = _drawn_names(data)
        own, newton = (good_unit(data[name].values, quantity(name).unit) for name in (along, force))
        x, y = draw.scaled(data[along].values, along, own), draw.scaled(data[force].values, force, newton)
        used, which = data["used"].values, data["curve"].values
        _draw_measured(curve, x, y)
        model = np.asarray(from_si(data["model"].values, "N", newton))
        for one in np.unique(which):
            label = "model" if one == 0 else None
            curve.plot(x[which == one], model[which == one], color=draw.BLUE, lw=1.4, label=label)
        if not used.all():
            curve.plot(x[~used], y[~used], "x", color=draw.ORANGE, ms=5, label="left out")
        _name_axes(curve, along, own, force, newton)
        unit = good_unit(data["residual"].values[used], "N")
        sample = x if along == "time" else np.arange(1.0, x.size + 1)
        _draw_residuals(rest, sample, data, unit, draw.GREY)
        rest.set_xlabel(draw.axis_label("time", own) if along == "time" else "sample")
        rest.set_ylabel(f"measured minus model ({unit})")
        figure.suptitle(draw.typeset_unit("\n".join(captions)), fontsize=draw.SMALL)
    return figure


def sheet_of_records(records: Mapping[str, xr.Dataset], columns: int = 5) -> draw.Figure:
    """
    Many records with their models, in one small panel each.

    Parameters
    ----------
    records : mapping of str to xarray.Dataset
        By the titles of the panels; as for :func:`fitted_curves`, of normal forces.
    columns : int
        Panels of a row.
    """
    rows = -(-len(records) // columns)
    with draw.new_figure(9.6, 0.3 + 1.5 * rows, letters=False) as figure:
        figure.set_layout_engine("none")  # measuring all labels would take longer than drawing them
        inch = 1.0 / figure.get_figheight()
        sides = {"left": 0.03, "right": 0.995, "bottom": 0.2 * inch, "top": 1.0 - 0.2 * inch}
        spaces = {**sides, "wspace": 0.18, "hspace": 0.3}
        panels = figure.subplots(rows, columns, squeeze=False, gridspec_kw=spaces).ravel()
        for axes in panels[len(records) :]:
            axes.set_axis_off()
        for axes, (name, data) in zip(panels, records.items(), strict=False):
            along, force = _drawn_names(data)
            own, newton = (good_unit(data[one].values, quantity(one).unit) for one in (along, force))
            x, y = draw.scaled(data[along].values, along, own), draw.scaled(data[force].values, force, newton)
            chosen = draw.thinned(y)
            axes.plot(x[chosen], y[chosen], ".", color=draw.GREY, ms=1.5, alpha=0.6, rasterized=True)
            model = np.asarray(from_si(data["model"].values, "N", newton))
            axes.plot(x[chosen], model[chosen], color=draw.BLUE, lw=0.9)
            axes.locator_params(nbins=3)
            axes.tick_params(labelsize=5, length=2, pad=1)
            title = name if len(name) <= _TITLE else f"\N{HORIZONTAL ELLIPSIS}{name[1 - _TITLE :]}"
            axes.set_title(f"{title} ({own}, {newton})", fontsize=5.5, pad=2)
    return figure


def _drawn_names(data: xr.Dataset) -> tuple[str, str]:
    """Names of the abscissa and of the drawn force."""
    if "tangential_force" in data:
        return "shift", "tangential_force"
    return "time" if "time" in data else "indentation", "normal_force"


def _draw_measured(axes: draw.Axes, x: FloatArray, y: FloatArray) -> None:
    axes.plot(x, y, ".", color=draw.GREY, ms=3.5, alpha=0.6, label="measured", rasterized=True)


def _name_axes(axes: draw.Axes, along: str, own: str, force: str, newton: str) -> None:
    draw.draw_zero(axes)
    axes.set(xlabel=draw.axis_label(along, own), ylabel=draw.axis_label(force, newton))
    draw.legend_above(axes)


def _draw_residuals(axes: draw.Axes, x: FloatArray, data: xr.Dataset, unit: str, colour: str) -> None:
    """Residuals of the fitted samples."""
    residual = np.where(data["used"].values, data["residual"].values, np.nan)
    axes.plot(x, from_si(residual, "N", unit), ".", color=colour, ms=2.5, rasterized=True)
    axes.axhline(0.0, color=draw.BLUE if colour == draw.GREY else draw.GREY, lw=1.0)


def growing_ranges(record: xr.Dataset, data: xr.Dataset, names: Sequence[str]) -> draw.Figure:
    """
    A record with its contact point, and fitted parameters over the range of the fit.

    Parameters
    ----------
    record : xarray.Dataset
        As for :func:`fitted_curves`, of the largest range.
    data : xarray.Dataset
        Over ``fit_range`` (m): the parameters with ``..._low`` and ``..._high``.
    names : sequence of str
        The parameters, a panel each.
    """
    with draw.new_figure(4.8 + 3.6 * len(names), 3.6) as figure:
        axes, *panels = figure.subplots(1, 1 + len(names))
        own, newton = (
            good_unit(record[name].values, unit)
            for name, unit in (("indentation", "m"), ("normal_force", "N"))
        )
        x = draw.scaled(record["indentation"].values, "indentation", own)
        _draw_measured(axes, x, draw.scaled(record["normal_force"].values, "normal_force", newton))
        y = np.asarray(from_si(record["model"].values, "N", newton))
        axes.plot(x, y, color=draw.BLUE, lw=1.4, label="model")
        axes.axvline(0.0, color=draw.ORANGE, lw=1.2, label="contact point")
        axes.set(xlabel=draw.axis_label("indentation", own), ylabel=draw.axis_label("normal_force", newton))
        draw.legend_above(axes)
        for name, panel in zip(names, panels, strict=True):
            _draw_growing(panel, data, name, own)
    return figure


def _draw_growing(axes: draw.Axes, data: xr.Dataset, name: str, along: str) -> None:
    """A parameter with its interval over the largest indentation of the fit."""
    own = str(data[name].attrs["units"])
    last = float(data[name].values[-1])
    unit = good_unit(np.array([last]), own)
    x = draw.lengths(data["fit_range"].values, along)
    value, low, high = (
        np.asarray(from_si(data[f"{name}{end}"].values, own, unit)) for end in ("", "_low", "_high")
    )
    axes.fill_between(x, low, high, color=draw.BLUE, alpha=0.2, lw=0.0, label="95 %")
    axes.plot(x, value, "o-", color=draw.BLUE, ms=4, lw=1.2)
    # shallow ranges may determine nothing; their intervals would hide the rest
    size, known = abs(value[-1]), np.isfinite(value)
    inside = known & (np.abs(value - value[-1]) < 3.0 * size)
    axes.set_ylim(
        min(float(value[inside].min()), value[-1] - 0.1 * size) - 0.1 * size,
        max(float(value[inside].max()), value[-1] + 0.1 * size) + 0.1 * size,
    )
    axes.set_xlabel(f"largest fitted indentation ({along})")
    axes.set_ylabel(draw.with_unit(parameter_label(name), unit))
    draw.legend_above(axes)


def fitted_map(data: xr.Dataset, names: Sequence[str]) -> draw.Figure:
    """
    Fitted parameters of many curves: maps over a grid of two dimensions, points over any other.

    Parameters
    ----------
    data : xarray.Dataset
        Over the grid of the curves; NaN where the fit failed.
    names : sequence of str
        The panels.
    """
    dims = [str(dim) for dim in data["ending"].dims]
    columns = min(len(names), 3)
    rows = -(-len(names) // columns)
    with draw.new_figure(3.4 * columns, 2.9 * rows) as figure:
        panels = np.atleast_1d(figure.subplots(rows, columns)).ravel()
        for name, axes in zip(names, panels, strict=False):
            own = str(data[name].attrs["units"])
            unit = good_unit(data[name].values, own)
            values = np.asarray(from_si(data[name].values, own, unit))
            label = draw.with_unit(parameter_label(name), unit)
            if len(dims) == 2:
                _draw_picture(axes, data, dims, values, label)
            else:
                _draw_points(axes, data, name, unit)
                axes.set_ylabel(label)
        for axes in panels[len(names) :]:
            figure.delaxes(axes)
    return figure


def _draw_points(axes: draw.Axes, data: xr.Dataset, name: str, unit: str) -> None:
    """Values over the number of the curve, with standard errors if given."""
    own = str(data[name].attrs["units"])
    values = from_si(data[name].values.ravel(), own, unit)
    error = f"{name}_error"
    bars = from_si(data[error].values.ravel(), own, unit) if error in data else None
    number = np.arange(data[name].size)
    axes.errorbar(number, values, bars, fmt=".", color=draw.BLUE, ms=4, elinewidth=0.8)
    axes.set_xlim(-0.5, number.size - 0.5)
    draw.label_history(axes, "curve")


def _draw_picture(
    axes: draw.Axes, data: xr.Dataset, dims: Sequence[str], values: FloatArray, label: str
) -> None:
    """Values over the grid; failed fits in grey."""
    (y, up), (x, along) = (_coordinates(data, dim) for dim in dims)
    low, high = _colour_limits(values)
    picture = axes.pcolormesh(
        _edges(x), _edges(y), values, vmin=low, vmax=high, cmap="viridis", rasterized=True
    )
    axes.set_facecolor(draw.GREY)
    axes.set_aspect("equal" if up and up == along else "auto")
    axes.figure.colorbar(picture, ax=axes, label=label)
    axes.set(ylabel=draw.with_unit(dims[0], up), xlabel=draw.with_unit(dims[1], along))


def _coordinates(data: xr.Dataset, dim: str) -> tuple[FloatArray, str]:
    """Coordinates of the pixels and their unit; indices if the grid has none."""
    if dim not in data.coords:
        return np.arange(float(data.sizes[dim])), ""
    at, own = np.asarray(data[dim].values, dtype=float), str(data[dim].attrs.get("units", ""))
    try:
        metres = np.asarray(from_si(at, own, "m"))
    except UnitError:
        return at, own
    unit = good_unit(metres, "m")
    return draw.lengths(metres, unit), unit


def _colour_limits(values: np.ndarray) -> tuple[float, float]:
    """Limits of the colour scale: the 1st and 99th percentile."""
    if not np.isfinite(values).any():
        return 0.0, 1.0
    low, high = (float(q) for q in np.nanquantile(values, [0.01, 0.99]))
    return (low, high) if high > low else (low - 0.5 * abs(low) - 1e-300, high + 0.5 * abs(high) + 1e-300)


def _edges(at: FloatArray) -> FloatArray:
    """Edges of the pixels around their centres."""
    step = np.diff(at) if at.size > 1 else np.ones(1)
    return np.concatenate([[at[0] - 0.5 * step[0]], 0.5 * (at[1:] + at[:-1]), [at[-1] + 0.5 * step[-1]]])


def weighed_laws(data: Mapping[str, xr.Dataset], weights: Mapping[str, float]) -> draw.Figure:
    """
    A record with the models of several laws, and the residuals of each.

    Parameters
    ----------
    data : mapping of str to xarray.Dataset
        As for :func:`fitted_curves`, by law; the contact point is that of the law with the largest weight.
    weights : mapping of str to float
        Akaike weights by law.
    """
    order = sorted(weights, key=lambda name: -weights[name])
    first = data[order[0]]
    with draw.new_figure(9.6, max(4.2, 1.3 * len(order))) as figure:
        grid = figure.add_gridspec(len(order), 2, width_ratios=[3, 2])
        curve = figure.add_subplot(grid[:, 0])
        along, drawn = _drawn_names(first)
        own, newton = (good_unit(first[name].values, quantity(name).unit) for name in (along, drawn))
        x, force = draw.scaled(first[along].values, along, own), first[drawn].values
        _draw_measured(curve, x, draw.scaled(force, drawn, newton))
        sample = x if along == "time" else np.arange(1.0, x.size + 1)
        rows: list[draw.Axes] = []
        for i, (name, (colour, dashes)) in enumerate(zip(order, itertools.cycle(_LAWS), strict=False)):
            model = np.asarray(from_si(force - data[name]["residual"].values, "N", newton))
            weight = f"{weights[name]:.2f}" if weights[name] >= _SMALL else f"< {_SMALL:g}"
            curve.plot(x, model, color=colour, ls=dashes, lw=1.4, label=f"{name} ({weight})")
            axes = figure.add_subplot(grid[i, 1], sharex=rows[0] if rows else None)
            unit = good_unit(data[name]["residual"].values[data[name]["used"].values], "N")
            _draw_residuals(axes, sample, data[name], unit, colour)
            axes.set_ylabel(f"{name} ({unit})", fontsize=draw.SMALL)
            axes.tick_params(labelbottom=i == len(order) - 1)
            rows.append(axes)
        rows[0].set_title("measured minus model")
        rows[-1].set_xlabel(draw.axis_label("time", own) if along == "time" else "sample")
        figure.align_ylabels(rows)
        _name_axes(curve, along, own, drawn, newton)
    return figure


def fitted_groups(data: xr.Dataset, groups: Mapping[str, xr.Dataset], names: Sequence[str]) -> draw.Figure:
    """
    Parameters of many records with their intervals, in order of their groups, and the medians of the groups.

    Parameters
    ----------
    data : xarray.Dataset
        Over ``curve``: ``group``, ``good``, and the parameters with ``..._low`` and ``..._high``.
    groups : mapping of str to xarray.Dataset
        Over ``group``, by parameter: ``median``, ``median_low`` and ``median_high``.
    names : sequence of str
        The parameters, a panel each.
    """
    data = data.isel(curve=np.flatnonzero(np.isfinite(data[names[0]].values)))
    labels, good = data["group"].values, data["good"].values
    order = np.argsort(labels, kind="stable")
    with draw.new_figure(4.6 * len(names), 3.6) as figure:
        for axes, name in zip(np.atleast_1d(figure.subplots(1, len(names))), names, strict=True):
            own = str(data[name].attrs["units"])
            unit = good_unit(data[name].values[good] if good.any() else data[name].values, own)
            value, low, high = (
                np.asarray(from_si(data[f"{name}{end}"].values[order], own, unit))
                for end in ("", "_low", "_high")
            )
            place = np.arange(1.0, value.size + 1)
            kept = good[order]
            bars = [np.maximum(value - low, 0.0), np.maximum(high - value, 0.0)]
            axes.errorbar(
                place[kept], value[kept], [bar[kept] for bar in bars], fmt=".", color=draw.BLUE, ms=4, elinewidth=0.8,
                label="95 % interval",
            )  # fmt: skip
            if not kept.all() and np.isfinite(value[~kept]).any():
                axes.plot(place[~kept], value[~kept], "x", color=draw.GREY, ms=5, label="excluded")
            _draw_medians(axes, groups.get(name), labels[order], unit)
            shown = value[kept] if kept.any() else value
            axes.set_ylim(0.0, 1.25 * float(np.nanmax(shown)) if shown.min() > 0.0 else None)
            axes.set_xlim(0.5, value.size + 0.5)
            axes.set(xlabel="curve", ylabel=draw.with_unit(parameter_label(name), unit))
            draw.legend_above(axes)
    return figure


def _draw_medians(axes: draw.Axes, medians: xr.Dataset | None, labels: np.ndarray, unit: str) -> None:
    """The median of each group with its interval over the places of its curves."""
    ends = [i for i in range(1, labels.size) if labels[i] != labels[i - 1]]
    for end in ends:
        axes.axvline(end + 0.5, color=draw.LIGHT, lw=0.8)
    if medians is None:
        return
    own = str(medians["median"].attrs["units"])
    for i, group in enumerate(medians["group"].values):
        places = np.flatnonzero(labels == str(group)) + 1.0
        span = [places.min() - 0.4, places.max() + 0.4]
        middle, low, high = (
            float(from_si(float(medians[f"median{end}"][i]), own, unit)) for end in ("", "_low", "_high")
        )
        if np.isfinite(low):
            axes.fill_between(span, low, high, color=draw.ORANGE, alpha=0.2, lw=0)
        axes.plot(span, [middle, middle], color=draw.ORANGE, lw=1.4, label="" if i else "median of the group")
        if len(medians["group"]) <= _NAMED:
            axes.annotate(
                str(group)[:_LONGEST], (float(places.mean()), 0.02), xycoords=("data", "axes fraction"),
                ha="center", fontsize=draw.SMALL,
            )  # fmt: skip
