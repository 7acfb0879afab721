"""Figures of rolling and sliding."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot.shared import (
    BLUE,
    CYCLE,
    GREEN,
    GREY,
    MARKED_ROWS,
    ORANGE,
    draw_zero,
    legend_above,
    lengths,
    letter_panels,
    new_figure,
    scaled,
    styled,
)
from pymdr.units import from_si, good_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_CREEP_LAWS = {"plain": ("MDR springs", BLUE), "calibrated": ("with Kalker's slope", ORANGE)}


_MOST_LOADS = 5


def rolling_study(data: xr.Dataset, curves: xr.Dataset, springs: xr.Dataset | None) -> Figure:
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
    with styled():
        figure = new_figure(9.6, 4.0)
        left, right = figure.subplots(1, 2)
        limit = float(curves.attrs["limit"])
        unit = good_unit(np.array([limit]), "N")
        forces = curves["creep_force"].values
        for law, force in zip(curves["law"].values, forces, strict=True):
            label, colour = _CREEP_LAWS[str(law)]
            left.plot(
                curves["creepage"].values,
                scaled(force, "tangential_force", unit),
                color=colour,
                lw=1.5,
                label=label,
            )
        left.axhline(
            float(scaled(np.array(limit), "tangential_force", unit)),
            color=GREY,
            lw=1.0,
            ls=":",
            label=r"$\mu F_N$",
        )
        left.set_xlabel(r"creepage $\zeta$")
        left.set_ylabel(f"creep force $F_x$ ({unit})")
        left.set_xlim(0.0, float(curves["creepage"][-1]))
        left.set_ylim(bottom=0.0)
        if springs is None:
            x = data["distance"].values
            x_unit = good_unit(x, "m")
            right.plot(
                lengths(x, x_unit),
                scaled(data["creep_force"].values, "tangential_force", unit),
                "o-",
                ms=3,
                color=BLUE,
            )
            right.set_xlabel(f"distance rolled ({x_unit})")
            right.set_ylabel(f"creep force $F_x$ ({unit})")
            draw_zero(right)
        else:
            zeta = data["creepage"].values
            few = "o" if zeta.size <= MARKED_ROWS else "."
            colour = _CREEP_LAWS[str(data.attrs["law"])][1]
            left.plot(
                np.abs(zeta),
                np.abs(scaled(data["creep_force"].values, "tangential_force", unit)),
                few,
                ms=4,
                color=colour,
            )
            _draw_springs(right, springs)
            legend_above(right)
        legend_above(left)
        letter_panels(figure)
    return figure


def _draw_springs(axes: Axes, springs: xr.Dataset) -> None:
    x, cap = springs["x"].values, springs["cap"].values
    x_unit, unit = good_unit(x, "m"), good_unit(cap, "N/m")
    place = lengths(x, x_unit)
    signs = [sign for sign in (1.0, -1.0) if np.any(sign * springs["line_load"].values > 0.0)] or [1.0]
    for sign, label in zip(signs, (r"$\mu E^* (d - g)$", None), strict=False):
        limit = sign * np.asarray(from_si(cap, "N/m", unit))
        axes.plot(place, limit, color=GREY, lw=1.0, ls="--", zorder=3, label=label)
    rows = np.unique(np.linspace(0, springs.sizes["creepage"] - 1, _MOST_LOADS).round().astype(int))
    for i, row in enumerate(rows):
        zeta, q = float(springs["creepage"][row]), springs["line_load"].values[row]
        axes.plot(
            place,
            from_si(q, "N/m", unit),
            color=CYCLE[i % len(CYCLE)],
            lw=1.5,
            label=rf"$\zeta$ = {zeta:.3g}",
        )
    axes.set_xlabel(f"position on the line $x$ ({x_unit}), rolling to the right")
    axes.set_ylabel(f"line load $q$ ({unit})")


def sliding_study(data: xr.Dataset) -> Figure:
    """
    Coefficient of friction against speed with its limits, and the leading and trailing edge of the contact.

    Parameters
    ----------
    data : xarray.Dataset
        ``friction_coefficient`` over ``speed`` (m/s), ``leading_edge`` and ``trailing_edge`` (m) or ``indentation`` (m), and
        optionally ``slow_limit`` and ``fast_limit``.
    """
    with styled():
        figure = new_figure(9.6, 4.0)
        left, right = figure.subplots(1, 2)
        ordered = data.sortby("speed")
        v_unit = good_unit(ordered["speed"].values, "m/s")
        v = np.asarray(from_si(ordered["speed"].values, "m/s", v_unit))
        few = "o" if v.size <= MARKED_ROWS else None
        friction = ordered["friction_coefficient"].values
        left.loglog(v, friction, color=BLUE, lw=1.5, marker=few, ms=3, label="MDR springs")
        for name, label, colour in (
            ("slow_limit_over_speed", "slow limit (half of MDR)", ORANGE),
            ("fast_limit_times_speed", "fast limit", GREEN),
        ):
            if name in data.attrs:
                speed = ordered["speed"].values
                along = data.attrs[name] * (speed if name.endswith("over_speed") else 1.0 / speed)
                left.loglog(v, along, color=colour, lw=1.2, ls="--", label=label)
        if "fast_limit" in ordered and "fast_limit_times_speed" not in data.attrs:
            left.loglog(v, ordered["fast_limit"].values, color=GREEN, lw=1.2, ls="--", label="fast limit")
        # outside its range a limit is far off
        left.set_ylim(0.3 * float(friction.min()), 4.0 * float(friction.max()))
        left.set_ylabel("coefficient of friction $F_x/F_N$")
        parts = {"leading_edge": ("leading", "-"), "trailing_edge": ("trailing", "--")}
        if "leading_edge" not in ordered:
            parts = {"indentation": ("indentation", "-")}
        unit = good_unit(np.concatenate([ordered[name].values for name in parts]), "m")
        for name, (label, style) in parts.items():
            shown = lengths(ordered[name].values, unit)
            right.semilogx(v, shown, style, color=BLUE, lw=1.5, marker=few, ms=3, label=label)
        right.set_ylabel(
            f"edges of the contact on the line ({unit})" if len(parts) == 2 else f"depth $d$ ({unit})"
        )
        draw_zero(right)
        for axes in (left, right):
            axes.set_xlabel(f"speed $v$ ({v_unit})")
            legend_above(axes)
        letter_panels(figure)
    return figure
