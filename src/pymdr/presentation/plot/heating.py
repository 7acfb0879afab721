"""Figures of temperature rises in contacts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.units import FloatArray, from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr

_MOST = 5


def joule_study(data: xr.Dataset, voltage: FloatArray, rise: FloatArray) -> draw.Figure:
    """
    Largest temperature rise against voltage and, where known, voltage against current or resistance.

    Parameters
    ----------
    data : xarray.Dataset
        ``voltage`` (V) and ``temperature_rise`` (K), and optionally ``current`` (A).
    voltage, rise : ndarray
        The universal curve of all metals, in V and K.
    """
    panels = 2 if "current" in data else 1
    with draw.new_figure(4.8 * panels, 3.6) as figure:
        axes = np.ravel(np.asarray(figure.subplots(1, panels)))
        unit = good_unit(voltage, "V")
        few = "o" if data["voltage"].size <= draw.MARKED_ROWS else "."
        given = np.asarray(from_si(data["voltage"].values, "V", unit))
        axes[0].plot(from_si(voltage, "V", unit), rise, color=draw.GREY, lw=1.2, label="any shape, any metal")
        axes[0].plot(given, data["temperature_rise"].values, few, color=draw.BLUE, ms=4)
        axes[0].set_xlabel(f"voltage $V$ ({unit})")
        axes[0].set_ylabel("largest temperature rise $T_\\mathrm{max} - T_0$ (K)")
        draw.begin_at_zero(axes[0])
        draw.legend_above(axes[0])
        if panels == 2:
            current, resistance = data["current"].values, data["cold_resistance"].values
            along, label, si = current, "current $I$", "A"
            if np.ptp(current) == 0.0 and np.ptp(resistance) > 0.0:
                along, label, si = resistance, "cold resistance $R_0$", "ohm"
            shown = good_unit(along, si)
            x, cold = from_si(along, si, shown), from_si(current * resistance, "V", unit)
            axes[1].plot(x, given, few, color=draw.BLUE, ms=4, label="heated")
            axes[1].plot(x, cold, few, color=draw.GREY, ms=3, label="cold")
            axes[1].set(xlabel=f"{label} ({draw.typeset_unit(shown)})", ylabel=f"voltage $V$ ({unit})")
            draw.draw_zero(axes[1])
            draw.legend_above(axes[1])
    return figure


def frictional_heat_study(data: xr.Dataset, surface: xr.Dataset) -> draw.Figure:
    """
    Largest and mean rise against speed, and the rise over the radius.

    Parameters
    ----------
    data : xarray.Dataset
        ``largest_temperature_rise`` (K) over ``speed`` (m/s), optionally ``mean_temperature_rise``; attribute
        ``contact_radius`` (m).
    surface : xarray.Dataset
        ``temperature_rise`` (K) over ``speed`` and ``r`` (m), or empty.
    """
    with draw.new_figure(9.6, 3.8) as figure:
        left, right = figure.subplots(1, 2)
        ordered = data.sortby("speed")
        v = ordered["speed"].values
        unit = good_unit(v, "m/s")
        few = "o" if v.size <= draw.MARKED_ROWS else None
        for name, label, colour in (
            ("largest_temperature_rise", "largest", draw.BLUE),
            ("mean_temperature_rise", "mean over the contact", draw.ORANGE),
        ):
            if name in ordered:
                x = from_si(v, "m/s", unit)
                left.plot(x, ordered[name].values, color=colour, marker=few, ms=3, label=label)
        left.set(xlabel=f"speed $v$ ({unit})", ylabel="temperature rise (K)")
        draw.begin_at_zero(left)
        draw.legend_above(left)
        if "temperature_rise" in surface:
            r = surface["r"].values
            r_unit = good_unit(r, "m")
            for row in np.unique(np.linspace(0, surface.sizes["speed"] - 1, _MOST).round().astype(int)):
                speed = float(from_si(float(surface["speed"][row]), "m/s", unit))
                rise = surface["temperature_rise"].values[row]
                right.plot(draw.lengths(r, r_unit), rise, lw=1.5, label=f"{speed:.3g} {unit}")
            edge = draw.lengths(np.array(data.attrs["contact_radius"]), r_unit)
            right.axvline(float(edge), color=draw.GREY, lw=0.9, ls=":")
            right.set(xlabel=f"radius $r$ ({r_unit})", ylabel="temperature rise (K)")
            draw.begin_at_zero(right)
            draw.legend_above(right)
        else:
            draw.show_text(right, "A force curve does not give\nthe temperature over the radius.")
    return figure
