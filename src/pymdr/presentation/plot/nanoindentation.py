"""Unloading curves of indents, moduli, and area functions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.units import FloatArray, from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr

Drawn = Sequence[tuple[FloatArray, FloatArray, Mapping[str, FloatArray]]]
_COLOURS = {"power_law": draw.BLUE, "effective_shape": draw.ORANGE}


def indent_study(drawn: Drawn, data: xr.Dataset) -> draw.Figure:
    """
    Unloading curves with the curves fitted to them, and the moduli of every indent.

    Parameters
    ----------
    drawn : sequence
        Depths in m, forces in N, and fitted forces by procedure, of every indent that is drawn.
    data : xarray.Dataset
        Over indent and procedure.
    """
    depth_unit = good_unit(np.concatenate([row[0] for row in drawn]), "m")
    force_unit = good_unit(np.concatenate([row[1] for row in drawn]), "N")
    with draw.new_figure(9.2, 3.8) as figure:
        left, right = figure.subplots(1, 2)
        for i, (depth, force, fitted) in enumerate(drawn):
            x = np.asarray(from_si(depth, "m", depth_unit))
            y = from_si(force, "N", force_unit)
            left.plot(x, y, ".", color=draw.GREY, ms=3, label="" if i else "unloading")
            for name, values in fitted.items():
                label = "" if i else name.replace("_", " ")
                left.plot(x, from_si(values, "N", force_unit), color=_COLOURS[name], lw=1.0, label=label)
        left.set(xlabel=f"depth $h$ ({depth_unit})", ylabel=f"normal force $F$ ({force_unit})")
        name = "young_modulus" if "young_modulus" in data else "plane_strain_modulus"
        unit = good_unit(data[name].values, "Pa")
        for shift, (procedure, colour) in zip((-0.1, 0.1), _COLOURS.items(), strict=True):
            row = data.sel(procedure=procedure)
            middle, low, high = (
                np.asarray(from_si(row[name + end].values, "Pa", unit)) for end in ("", "_low", "_high")
            )
            place, bars = data["indent"].values + shift, [middle - low, high - middle]
            label = procedure.replace("_", " ")
            right.errorbar(place, middle, yerr=bars, fmt="o", color=colour, ms=3, capsize=2, label=label)
        symbol = "$E$" if name == "young_modulus" else r"$E/(1-\nu^2)$"
        right.set_ylabel(f"{symbol} with 95 % interval ({unit})")
        _indents_on(right, data)
        for axes in (left, right):
            draw.legend_above(axes)
    return figure


def area_study(data: xr.Dataset) -> draw.Figure:
    """
    Measured and fitted areas over the contact depth, and their ratio.

    Parameters
    ----------
    data : xarray.Dataset
        Over indent.
    """
    rows = data.sortby("contact_depth")
    depth_unit = good_unit(rows["contact_depth"].values, "m")
    x = np.asarray(from_si(rows["contact_depth"].values, "m", depth_unit))
    fitted, low, high, measured = (
        rows[name].values
        for name in ("contact_area", "contact_area_low", "contact_area_high", "measured_area")
    )
    area_unit = good_unit(measured, "m^2")
    with draw.new_figure(9.2, 3.8) as figure:
        left, right = figure.subplots(1, 2)
        left.plot(x, from_si(measured, "m^2", area_unit), "o", color=draw.BLUE, ms=3, label="indents")
        left.plot(x, from_si(fitted, "m^2", area_unit), color=draw.ORANGE, lw=1.0, label="area function")
        left.set_ylabel(draw.with_unit("contact area $A$", area_unit))
        bottom, top = 100.0 * (low / fitted - 1.0), 100.0 * (high / fitted - 1.0)
        right.fill_between(x, bottom, top, color=draw.LIGHT, label="95 % interval")
        right.plot(x, 100.0 * (measured / fitted - 1.0), "o", color=draw.BLUE, ms=3, label="indents")
        right.axhline(0.0, color=draw.ORANGE, lw=1.0)
        right.set_ylabel("deviation from the area function (%)")
        for axes in (left, right):
            axes.set_xlabel(f"contact depth $h_c$ ({depth_unit})")
            draw.legend_above(axes)
    return figure


def drift_study(holds: Sequence[tuple[FloatArray, FloatArray, FloatArray]], data: xr.Dataset) -> draw.Figure:
    """
    Depths in holds with the fitted lines, and the rates of all indents.

    Parameters
    ----------
    holds : sequence
        Times in s, depths in m and fitted depths of every hold that is drawn.
    data : xarray.Dataset
        Over indent.
    """
    unit = good_unit(np.concatenate([depth - depth[0] for _, depth, _ in holds]), "m")
    with draw.new_figure(9.2, 3.8) as figure:
        left, right = figure.subplots(1, 2)
        for i, (time, depth, fitted) in enumerate(holds):
            for values, style in (
                (depth, {"color": draw.GREY, "ls": "", "marker": ".", "ms": 2}),
                (fitted, {"color": draw.ORANGE}),
            ):
                label = "" if i else ("hold" if values is depth else "drift")
                left.plot(time - time[0], from_si(values - fitted[0], "m", unit), label=label, **style)
        left.set(xlabel="time in the hold (s)", ylabel=f"change of the depth ({unit})")
        rate, low, high = (data[f"rate{end}"].values * 1e9 for end in ("", "_low", "_high"))
        bars = [rate - low, high - rate]
        x = data["indent"].values
        right.errorbar(x, rate, yerr=bars, fmt="o", color=draw.BLUE, ms=3, capsize=2, label="hold")
        _indents_on(right, data)
        right.axhline(0.0, color=draw.LIGHT, lw=1.0)
        right.set_ylabel("rate with 95 % interval (nm/s)")
        for axes in (left, right):
            draw.legend_above(axes)
    return figure


def profile_study(data: xr.Dataset) -> draw.Figure:
    """
    Hardness and modulus over depth, with their 95 % intervals.

    Parameters
    ----------
    data : xarray.Dataset
        Over indent and point.
    """
    depth_unit = good_unit(data["indentation"].values, "m")
    modulus = "young_modulus" if "young_modulus" in data else "plane_strain_modulus"
    symbols = {"hardness": "hardness $H$", "young_modulus": "$E$", "plane_strain_modulus": r"$E/(1-\nu^2)$"}
    with draw.new_figure(9.2, 3.8) as figure:
        for axes, name in zip(figure.subplots(1, 2), ("hardness", modulus), strict=True):
            unit = good_unit(data[name].values, "Pa")
            for i in range(data.sizes["indent"]):
                row = data.isel(indent=i)
                x = np.asarray(from_si(row["indentation"].values, "m", depth_unit))
                middle, low, high = (
                    np.asarray(from_si(row[name + end].values, "Pa", unit)) for end in ("", "_low", "_high")
                )
                axes.fill_between(x, low, high, color=draw.LIGHT, lw=0, label="" if i else "95 % interval")
                axes.plot(x, middle, ".-", color=draw.BLUE, ms=3, lw=0.8, label="" if i else "indents")
            # without the wide intervals of shallow points
            values = np.asarray(from_si(data[name].values, "Pa", unit))
            axes.set_ylim(0.0, 1.3 * float(np.nanpercentile(values, 98.0)))
            axes.set(xlabel=f"depth $h$ ({depth_unit})", ylabel=f"{symbols[name]} ({unit})")
            draw.legend_above(axes)
    return figure


def film_study(data: xr.Dataset) -> draw.Figure:
    """
    Measured and fitted reduced moduli over the width of the contact, and the modulus of the film by each point.

    Parameters
    ----------
    data : xarray.Dataset
        Over point.
    """
    x = data["width"].values
    unit, film_unit = (good_unit(data[name].values, "Pa") for name in ("reduced_modulus", "film_modulus"))
    with draw.new_figure(9.2, 3.8) as figure:
        left, right = figure.subplots(1, 2)
        y = from_si(data["reduced_modulus"].values, "Pa", unit)
        left.plot(x, y, "o", color=draw.BLUE, ms=3, label="measured")
        y = from_si(data["fitted_modulus"].values, "Pa", unit)
        left.plot(x, y, color=draw.ORANGE, label="film on substrate")
        left.set_ylabel(draw.with_unit("reduced modulus $E_r$", unit))
        y = from_si(data["film_modulus"].values, "Pa", film_unit)
        right.plot(x, y, "o", color=draw.BLUE, ms=3, label="each point alone")
        middle, low, high = (
            float(from_si(float(data[f"young_modulus{end}"]), "Pa", film_unit))
            for end in ("", "_low", "_high")
        )
        right.axhspan(low, high, color=draw.LIGHT, lw=0, label="95 % interval")
        right.axhline(middle, color=draw.ORANGE, label="all points")
        right.set_ylabel(draw.with_unit("$E$ of the film", film_unit))
        for axes in (left, right):
            axes.set_xlabel("contact radius over thickness $a/t$")
            draw.legend_above(axes)
    return figure


def pop_in_study(records: Sequence[tuple[FloatArray, FloatArray]], data: xr.Dataset) -> draw.Figure:
    """
    Loading curves with their first pop-ins, and of several indents the loads in order.

    Parameters
    ----------
    records : sequence
        Depths in m and forces in N of every indent that is drawn.
    data : xarray.Dataset
        Over indent.
    """
    loads = [slice(0, int(np.argmax(force)) + 1) for _, force in records]
    shown_depths = [depth[rows] for (depth, _), rows in zip(records, loads, strict=True)]
    depth_unit = good_unit(np.concatenate(shown_depths), "m")
    unit = good_unit(np.concatenate([force for _, force in records]), "N")
    with draw.new_figure(9.2 if data.sizes["indent"] > 1 else 5.0, 3.8) as figure:
        left, *others = np.ravel(figure.subplots(1, 1 + (data.sizes["indent"] > 1)))
        for i, ((depth, force), rows) in enumerate(zip(records, loads, strict=True)):
            x, y = from_si(depth[rows], "m", depth_unit), from_si(force[rows], "N", unit)
            left.plot(x, y, color=draw.GREY, lw=0.8, label="" if i else "loading")
        drawn = data.isel(indent=slice(0, len(records)))
        x = from_si(drawn["pop_in_depth"].values, "m", depth_unit)
        y = from_si(drawn["pop_in_force"].values, "N", unit)
        left.plot(x, y, "o", color=draw.ORANGE, ms=4, label="first pop-in")
        left.set(xlabel=f"depth $h$ ({depth_unit})", ylabel=f"normal force $F$ ({unit})")
        for right in others:
            _draw_loads(right, data, unit)
        for axes in (left, *others):
            draw.legend_above(axes)
    return figure


def _draw_loads(axes: draw.Axes, data: xr.Dataset, unit: str) -> None:
    """The fraction of the indents with a pop-in below each force."""
    force = np.sort(data["pop_in_force"].values)
    force = np.asarray(from_si(force[np.isfinite(force)], "N", unit))
    fraction = np.arange(force.size + bool(force.size)) / max(force.size, 1)
    axes.step(np.append(force, force[-1:]), fraction, color=draw.BLUE, where="post", label="indents")
    if "strength_force" in data:
        strength = float(from_si(float(data["strength_force"]), "N", unit))
        axes.axvline(strength, color=draw.ORANGE, ls="--", label="shear strength reached")
    axes.set(xlabel=f"force of the first pop-in ({unit})", ylabel="fraction of the indents")
    axes.set_ylim(0.0, 1.02)


def _indents_on(axes: draw.Axes, data: xr.Dataset) -> None:
    """The numbers of indents along an axis."""
    axes.set_xlabel("indent")
    axes.set_xticks(data["indent"].values[:: 1 + data.sizes["indent"] // 12])
    axes.set_xlim(0.5, data.sizes["indent"] + 0.5)
