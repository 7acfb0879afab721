"""Unloading curves of indents, moduli, and area functions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot.shared import (
    BLUE,
    GREY,
    LIGHT,
    ORANGE,
    legend_above,
    letter_panels,
    new_figure,
    styled,
    with_unit,
)
from pymdr.units import FloatArray, from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Drawn = Sequence[tuple[FloatArray, FloatArray, Mapping[str, FloatArray]]]
_COLOURS = {"power_law": BLUE, "effective_shape": ORANGE}


def indent_study(drawn: Drawn, data: xr.Dataset) -> Figure:
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
    with styled():
        figure = new_figure(9.2, 3.8)
        left, right = figure.subplots(1, 2)
        for i, (depth, force, fitted) in enumerate(drawn):
            x = np.asarray(from_si(depth, "m", depth_unit))
            left.plot(
                x, from_si(force, "N", force_unit), ".", color=GREY, ms=3, label="" if i else "unloading"
            )
            for name, values in fitted.items():
                label = "" if i else name.replace("_", " ")
                left.plot(x, from_si(values, "N", force_unit), color=_COLOURS[name], lw=1.0, label=label)
        left.set_xlabel(f"depth $h$ ({depth_unit})")
        left.set_ylabel(f"normal force $F$ ({force_unit})")
        name = "young_modulus" if "young_modulus" in data else "plane_strain_modulus"
        unit = good_unit(data[name].values, "Pa")
        for shift, (procedure, colour) in zip((-0.1, 0.1), _COLOURS.items(), strict=True):
            row = data.sel(procedure=procedure)
            middle, low, high = (
                np.asarray(from_si(row[name + end].values, "Pa", unit)) for end in ("", "_low", "_high")
            )
            right.errorbar(
                data["indent"].values + shift,
                middle,
                yerr=[middle - low, high - middle],
                fmt="o",
                color=colour,
                ms=3,
                capsize=2,
                label=procedure.replace("_", " "),
            )
        right.set_xlabel("indent")
        symbol = "$E$" if name == "young_modulus" else r"$E/(1-\nu^2)$"
        right.set_ylabel(f"{symbol} with 95 % interval ({unit})")
        right.set_xticks(data["indent"].values[:: 1 + data.sizes["indent"] // 12])
        right.set_xlim(0.5, data.sizes["indent"] + 0.5)
        for axes in (left, right):
            legend_above(axes)
        letter_panels(figure)
    return figure


def area_study(data: xr.Dataset) -> Figure:
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
    with styled():
        figure = new_figure(9.2, 3.8)
        left, right = figure.subplots(1, 2)
        left.plot(x, from_si(measured, "m^2", area_unit), "o", color=BLUE, ms=3, label="indents")
        left.plot(x, from_si(fitted, "m^2", area_unit), color=ORANGE, lw=1.0, label="area function")
        left.set_ylabel(with_unit("contact area $A$", area_unit))
        right.fill_between(
            x, 100.0 * (low / fitted - 1.0), 100.0 * (high / fitted - 1.0), color=LIGHT, label="95 % interval"
        )
        right.plot(x, 100.0 * (measured / fitted - 1.0), "o", color=BLUE, ms=3, label="indents")
        right.axhline(0.0, color=ORANGE, lw=1.0)
        right.set_ylabel("deviation from the area function (%)")
        for axes in (left, right):
            axes.set_xlabel(f"contact depth $h_c$ ({depth_unit})")
            legend_above(axes)
        letter_panels(figure)
    return figure
