"""Figures of rolling and sliding."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.units import from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr


_CREEP_LAWS = {"plain": ("MDR springs", draw.BLUE), "calibrated": ("with Kalker's slope", draw.ORANGE)}


_MOST_LOADS = 5


def rolling_study(data: xr.Dataset, curves: xr.Dataset, springs: xr.Dataset | None) -> draw.Figure:
    """
    Creep force against creepage by several laws, with the line load below its limit, or the force along a path.

    Parameters
    ----------
    data : xarray.Dataset
        ``creep_force`` (N) over ``creepage``, or over ``distance`` (m).
    curves : xarray.Dataset
        ``creep_force`` (N) over ``law`` and ``creepage``, with the ``limit`` of friction in N.
    springs : xarray.Dataset or None
        ``line_load`` (N/m) over ``creepage`` and ``x`` (m), and ``cap``; None along a path.
    """
    with draw.new_figure(9.6, 4.0) as figure:
        left, right = figure.subplots(1, 2)
        limit = float(curves.attrs["limit"])
        unit = good_unit(np.array([limit]), "N")
        forces = curves["creep_force"].values
        for law, force in zip(curves["law"].values, forces, strict=True):
            label, colour = _CREEP_LAWS[str(law)]
            y = draw.scaled(force, "tangential_force", unit)
            left.plot(curves["creepage"].values, y, color=colour, lw=1.5, label=label)
        slips = float(draw.scaled(np.array(limit), "tangential_force", unit))
        left.axhline(slips, color=draw.GREY, lw=1.0, ls=":", label=r"$\mu F_N$")
        left.set(xlabel=r"creepage $\zeta$", ylabel=f"creep force $F_x$ ({unit})")
        left.set_xlim(0.0, float(curves["creepage"][-1]))
        left.set_ylim(bottom=0.0)
        if springs is None:
            x = data["distance"].values
            x_unit = good_unit(x, "m")
            x_drawn = draw.lengths(x, x_unit)
            y = draw.scaled(data["creep_force"].values, "tangential_force", unit)
            right.plot(x_drawn, y, "o-", ms=3, color=draw.BLUE)
            right.set(xlabel=f"distance rolled ({x_unit})", ylabel=f"creep force $F_x$ ({unit})")
            draw.draw_zero(right)
        else:
            zeta = data["creepage"].values
            few = "o" if zeta.size <= draw.MARKED_ROWS else "."
            colour = _CREEP_LAWS[str(data.attrs["law"])][1]
            y = np.abs(draw.scaled(data["creep_force"].values, "tangential_force", unit))
            left.plot(np.abs(zeta), y, few, ms=4, color=colour)
            _draw_springs(right, springs)
            draw.legend_above(right)
        draw.legend_above(left)
    return figure


def _draw_springs(axes: draw.Axes, springs: xr.Dataset) -> None:
    x, cap = springs["x"].values, springs["cap"].values
    x_unit, unit = good_unit(x, "m"), good_unit(cap, "N/m")
    place = draw.lengths(x, x_unit)
    signs = [sign for sign in (1.0, -1.0) if np.any(sign * springs["line_load"].values > 0.0)] or [1.0]
    for sign, label in zip(signs, (r"$\mu E^* (d - g)$", None), strict=False):
        limit = sign * np.asarray(from_si(cap, "N/m", unit))
        axes.plot(place, limit, color=draw.GREY, lw=1.0, ls="--", zorder=3, label=label)
    rows = np.unique(np.linspace(0, springs.sizes["creepage"] - 1, _MOST_LOADS).round().astype(int))
    for i, row in enumerate(rows):
        zeta, q = float(springs["creepage"][row]), springs["line_load"].values[row]
        y = from_si(q, "N/m", unit)
        axes.plot(place, y, color=draw.CYCLE[i % len(draw.CYCLE)], lw=1.5, label=rf"$\zeta$ = {zeta:.3g}")
    axes.set_xlabel(f"position on the line $x$ ({x_unit}), rolling to the right")
    axes.set_ylabel(f"line load $q$ ({unit})")


def sliding_study(data: xr.Dataset) -> draw.Figure:
    """
    Coefficient of friction against speed with its limits, and the leading and trailing edge of the contact.

    Parameters
    ----------
    data : xarray.Dataset
        ``friction_coefficient`` over ``speed`` (m/s), ``leading_edge`` and ``trailing_edge`` (m) or ``indentation`` (m), and
        optionally ``slow_limit`` and ``fast_limit``.
    """
    with draw.new_figure(9.6, 4.0) as figure:
        left, right = figure.subplots(1, 2)
        ordered = data.sortby("speed")
        v_unit = good_unit(ordered["speed"].values, "m/s")
        v = np.asarray(from_si(ordered["speed"].values, "m/s", v_unit))
        few = "o" if v.size <= draw.MARKED_ROWS else None
        friction = ordered["friction_coefficient"].values
        left.loglog(v, friction, color=draw.BLUE, lw=1.5, marker=few, ms=3, label="MDR springs")
        for name, label, colour in (
            ("slow_limit_over_speed", "slow limit (half of MDR)", draw.ORANGE),
            ("fast_limit_times_speed", "fast limit", draw.GREEN),
        ):
            if name in data.attrs:
                speed = ordered["speed"].values
                along = data.attrs[name] * (speed if name.endswith("over_speed") else 1.0 / speed)
                left.loglog(v, along, color=colour, lw=1.2, ls="--", label=label)
        if "fast_limit" in ordered and "fast_limit_times_speed" not in data.attrs:
            y = ordered["fast_limit"].values
            left.loglog(v, y, color=draw.GREEN, lw=1.2, ls="--", label="fast limit")
        # outside its range a limit is far off
        left.set_ylim(0.3 * float(friction.min()), 4.0 * float(friction.max()))
        left.set_ylabel("coefficient of friction $F_x/F_N$")
        parts = {"leading_edge": ("leading", "-"), "trailing_edge": ("trailing", "--")}
        if "leading_edge" not in ordered:
            parts = {"indentation": ("indentation", "-")}
        unit = good_unit(np.concatenate([ordered[name].values for name in parts]), "m")
        for name, (label, style) in parts.items():
            shown = draw.lengths(ordered[name].values, unit)
            right.semilogx(v, shown, style, color=draw.BLUE, lw=1.5, marker=few, ms=3, label=label)
        right.set_ylabel(
            f"edges of the contact on the line ({unit})" if len(parts) == 2 else f"depth $d$ ({unit})"
        )
        draw.draw_zero(right)
        for axes in (left, right):
            axes.set_xlabel(f"speed $v$ ({v_unit})")
            draw.legend_above(axes)
    return figure
