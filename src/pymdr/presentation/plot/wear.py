"""Figures of fretting wear, of fretting logs and of running conditions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.units import from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr

_SHOWN = 6
"""Largest number of worn profiles in a panel."""


def wear_study(data: xr.Dataset, surface: xr.Dataset) -> draw.Figure:
    """
    Worn profile and pressure at some numbers of cycles, and volume and radii over cycles.

    Parameters
    ----------
    data : xarray.Dataset
        Over ``cycles``: ``worn_volume`` (m^3), ``contact_radius``, ``stick_radius`` and ``indentation`` (m).
    surface : xarray.Dataset
        Over ``cycles`` and ``node``: ``r``, ``profile`` and ``limiting_profile`` (m), ``pressure`` (Pa).
    """
    from matplotlib import colormaps

    with draw.new_figure(10.4, 6.2) as figure:
        shape, pressed, volume, radii = figure.subplots(2, 2).ravel()
        r, f = surface["r"].values, surface["profile"].values
        unit, high = good_unit(r, "m"), good_unit(f, "m")
        rows = _distinct_rows(data["worn_volume"].values)
        for row, colour in zip(rows, colormaps["viridis"](np.linspace(0.0, 0.85, len(rows))), strict=True):
            rounded = float(f"{data['cycles'].values[row]:.3g}")
            label = f"{rounded:,.10g} cycles"
            x = draw.lengths(r[row], unit)
            shape.plot(x, draw.lengths(f[row], high), color=colour, lw=1.4, label=label)
            pressed.plot(x, surface["pressure"].values[row] * 1e-6, color=colour, lw=1.4, label=label)
        limit = surface["limiting_profile"].values[-1]
        if np.isfinite(limit).all():
            x, y = draw.lengths(r[-1], unit), draw.lengths(limit, high)
            shape.plot(x, y, color=draw.ORANGE, lw=1.2, ls="--", label="end of wear")
        # beyond the worn ring both profiles are the original one
        end = 1.1 * float(data["worn_radius"].values.max() or r.max())
        inside = r[-1] <= end
        shape.set_xlim(float(draw.lengths(r.min(), unit)), float(draw.lengths(np.array(end), unit)))
        span = draw.lengths(np.array([f[:, inside].min(), f[:, inside].max()]), high)
        shape.set_ylim(float(span[0] - 0.05 * np.ptp(span)), float(span[1] + 0.05 * np.ptp(span)))
        pressed.set_xlim(*shape.get_xlim())
        shape.set_ylabel(f"worn profile f ({high})")
        pressed.set_ylabel("pressure (MPa)")
        shape.legend()
        pressed.legend()
        for axes in (shape, pressed):
            axes.set_xlabel(f"radius r ({unit})")
        _over_cycles(volume, data, {"worn_volume": "worn volume"}, "m^3")
        if "limit_volume" in data.attrs:
            cubic = good_unit(data["worn_volume"].values, "m^3")
            end_volume = float(from_si(np.array(data.attrs["limit_volume"]), "m^3", cubic))
            volume.axhline(end_volume, color=draw.ORANGE, lw=1.2, ls="--", label="end of wear")
            volume.legend()
        volume.set_yscale("log")
        _over_cycles(radii, data, {"contact_radius": "contact radius", "stick_radius": "stick radius"}, "m")
        radii.legend()
    return figure


def compared_wear(table: xr.Dataset, curves: xr.Dataset, surface: xr.Dataset) -> draw.Figure:
    """
    Worn volume over cycles, and the depth of wear in the last row, by the method and by rings.

    Parameters
    ----------
    table : xarray.Dataset
        Over ``step``: ``cycles`` and ``worn_volume_rings`` (m^3).
    curves : xarray.Dataset
        Over ``cycles``: ``worn_volume`` (m^3) by the method.
    surface : xarray.Dataset
        Over ``r`` (m): ``mdr`` and ``rings`` (m).
    """
    with draw.new_figure(9.0, 3.9) as figure:
        left, right = figure.subplots(1, 2)
        _over_cycles(left, curves, {"worn_volume": "worn volume"}, "m^3")
        cubic = good_unit(curves["worn_volume"].values, "m^3")
        left.lines[0].set_label("MDR")
        volume = from_si(table["worn_volume_rings"].values, "m^3", cubic)
        left.plot(table["cycles"].values, volume, "o", ms=5, mfc="none", color=draw.ORANGE, label="rings")
        left.set_yscale("log")
        left.legend()
        unit, deep = good_unit(surface["r"].values, "m"), good_unit(surface["rings"].values, "m")
        r = draw.lengths(surface["r"].values, unit)
        y = draw.lengths(surface["rings"].values, deep)
        right.plot(r, y, "o", ms=4, mfc="none", color=draw.ORANGE, label="rings")
        right.plot(r, draw.lengths(surface["mdr"].values, deep), color=draw.BLUE, lw=1.2, label="MDR")
        right.set_xlabel(f"radius r ({draw.typeset_unit(unit)})")
        right.set_ylabel(f"depth of wear in the last row ({draw.typeset_unit(deep)})")
        right.legend()
    return figure


def _distinct_rows(volume: np.ndarray) -> list[int]:
    """Rows whose worn volumes are spaced evenly."""
    wanted = np.linspace(volume[0], volume[-1], _SHOWN)
    return sorted({int(np.argmin(np.abs(volume - v))) for v in wanted})


def _over_cycles(axes: draw.Axes, data: xr.Dataset, names: dict[str, str], si: str) -> None:
    """Columns over cycles, from the first row that has any."""
    cycles = data["cycles"].values
    counted = cycles > 0.0
    values = np.concatenate([data[name].values for name in names])
    unit = good_unit(values, si)
    for (name, label), colour in zip(names.items(), (draw.BLUE, draw.GREEN), strict=False):
        y = np.asarray(from_si(data[name].values, si, unit))
        axes.plot(cycles[counted], y[counted], color=colour, lw=1.5, label=label)
    axes.set_xscale("log")
    axes.set_xlabel("number of cycles")
    what = next(iter(names.values())) if len(names) == 1 else "radius"
    axes.set_ylabel(f"{what} ({draw.typeset_unit(unit)})")


def fretting_log(loops: list[tuple[float, np.ndarray, np.ndarray]], data: xr.Dataset) -> draw.Figure:
    """
    Loops of force against shift over cycles, with friction coefficient, stiffness and regime of every cycle.

    Parameters
    ----------
    loops : list of (cycle, shift, force)
        Some of the cycles, in m and N.
    data : xarray.Dataset
        Over ``cycle``: ``friction_coefficient``, ``tangential_stiffness`` (N/m) and ``regime``.
    """
    from matplotlib import colormaps
    from matplotlib.ticker import MaxNLocator

    colours = {"partial": draw.BLUE, "mixed": draw.PURPLE, "gross": draw.ORANGE, "unknown": draw.GREY}
    with draw.new_figure(10.4, 4.2, letters=False) as figure:
        log = figure.add_subplot(1, 2, 1, projection="3d")
        unit = good_unit(np.concatenate([u for _, u, _ in loops]), "m")
        force = good_unit(np.concatenate([f for _, _, f in loops]), "N")
        for (cycle, u, f), colour in zip(
            loops, colormaps["viridis"](np.linspace(0.0, 0.85, len(loops))), strict=True
        ):
            x = draw.lengths(u, unit)
            log.plot(x, np.full(u.size, cycle), from_si(f, "N", force), color=colour, lw=1.0)
        log.set_xlabel(f"shift ({unit})", labelpad=12.0)
        log.set_ylabel("cycle", labelpad=16.0)
        log.set_zlabel(f"force ({force})")
        # the slanted axes are short
        log.xaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
        log.yaxis.set_major_locator(MaxNLocator("auto", integer=True, min_n_ticks=1))
        log.set_ylim(loops[0][0] - 0.5, loops[-1][0] + 0.5)
        log.set_box_aspect((1.0, 1.3, 0.8), zoom=0.85)
        friction = figure.add_subplot(2, 2, 2)
        stiffness = figure.add_subplot(2, 2, 4)
        numbers, regime = data["cycle"].values, data["regime"].values
        name = "friction_coefficient" if "friction_coefficient" in data else "force_amplitude"
        label = "largest $F_x/F_N$" if name == "friction_coefficient" else "force amplitude (N)"
        per = good_unit(data["tangential_stiffness"].values, "N/m")
        steep = np.asarray(from_si(data["tangential_stiffness"].values, "N/m", per))
        for kind, colour in colours.items():
            of = regime == kind
            if of.any():
                friction.plot(numbers[of], data[name].values[of], ".", color=colour, ms=4, label=kind)
                stiffness.plot(numbers[of], steep[of], ".", color=colour, ms=4)
        friction.set_ylabel(label)
        friction.legend(title="regime", ncols=2)
        stiffness.set_ylabel(f"tangential stiffness ({per})")
        for axes, values in ((friction, data[name].values), (stiffness, steep)):
            draw.label_history(axes, "cycle")
            draw.limit_rounding(axes, values)
    return figure


def running_conditions_map(
    data: xr.Dataset, record: tuple[np.ndarray, np.ndarray] | None = None
) -> draw.Figure:
    """
    Load against amplitude of the shift, with the boundary of gross slip, and the path of a record.

    Parameters
    ----------
    data : xarray.Dataset
        Over ``normal_force`` (N): ``sliding_shift`` (m), the amplitude from which all slips.
    record : (amplitude, normal force), optional
        Of the cycles of a record, in m and N.
    """
    with draw.new_figure(5.6, 4.0) as figure:
        axes = figure.subplots()
        load, limit = data["normal_force"].values, data["sliding_shift"].values
        all_shifts = limit if record is None else np.append(limit, record[0])
        all_loads = load if record is None else np.append(load, record[1])
        unit, force = good_unit(all_shifts, "m"), good_unit(all_loads, "N")
        x, y = draw.lengths(limit, unit), np.asarray(from_si(load, "N", force))
        right = 1.25 * float(draw.lengths(all_shifts.max(), unit))
        axes.fill_betweenx(y, 0.0, x, color=draw.BLUE, alpha=0.15, lw=0)
        axes.fill_betweenx(y, x, right, color=draw.ORANGE, alpha=0.15, lw=0)
        axes.plot(x, y, color=draw.GREY, lw=1.5)
        axes.text(0.05, 0.92, "partial slip", color=draw.BLUE, transform=axes.transAxes)
        axes.text(0.95, 0.06, "gross slip", color=draw.ORANGE, ha="right", transform=axes.transAxes)
        if record is not None:
            x, y = draw.lengths(record[0], unit), from_si(record[1], "N", force)
            axes.plot(x, y, ".-", color=draw.GREEN, lw=0.8, ms=4, label="record")
            axes.legend(loc="center right")
        axes.set_xlim(0.0, right)
        axes.set_ylim(*(float(from_si(end, "N", force)) for end in (all_loads.min(), all_loads.max())))
        axes.set(xlabel=f"amplitude of the shift ({unit})", ylabel=f"normal force ({force})")
    return figure
