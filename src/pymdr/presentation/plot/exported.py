"""The figure of an exported law: force over indentation, and the errors of the table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import quantity
from pymdr.units import FloatArray, good_unit

if TYPE_CHECKING:
    import xarray as xr

_DRAWN = {
    "normal_force": (draw.BLUE, "F"),
    "normal_stiffness": (draw.ORANGE, "k"),
    "contact_radius": (draw.GREEN, "a"),
}


def law_study(
    knots: xr.Dataset,
    curve: tuple[FloatArray, FloatArray],
    checks: xr.Dataset,
    tolerance: float,
    pull_off: float | None,
) -> draw.Figure:
    """
    Force over indentation with the knots of its table, and the measured errors.

    Parameters
    ----------
    knots : xarray.Dataset
        ``indentation`` (m) and ``normal_force`` (N) of the table.
    curve : tuple of ndarray
        Indentations in m and interpolated forces in N.
    checks : xarray.Dataset
        ``indentation`` (m) and relative errors of the quantities.
    tolerance : float
        The requested relative error.
    pull_off : float or None
        Indentation in m at pull-off; None without adhesion.
    """
    with draw.new_figure(9.6, 3.8) as figure:
        law, errors = figure.subplots(1, 2)
        _draw_law(law, knots, curve, pull_off)
        _draw_errors(errors, checks, tolerance, pull_off)
        if law.get_xscale() == "log":  # below the first knots the law is a power
            errors.set_xlim(law.get_xlim())
    return figure


def _draw_law(
    axes: draw.Axes, knots: xr.Dataset, curve: tuple[FloatArray, FloatArray], pull_off: float | None
) -> None:
    units = {
        name: good_unit(knots[name].values, quantity(name).unit) for name in ("indentation", "normal_force")
    }
    d, force = (draw.scaled(v, n, units[n]) for n, v in zip(units, curve, strict=True))
    axes.plot(d, force, color=draw.BLUE, label="law")
    at, forces = (draw.scaled(knots[n].values, n, units[n]) for n in units)
    axes.plot(at, forces, "o", ms=3.0, color=draw.GREY, label=f"{at.size} knots")
    if pull_off is None and np.all(force > 0.0):
        axes.set(xscale="log", yscale="log")
        axes.set_xlim(0.5 * d[0], 1.5 * d[-1])
    else:
        draw.draw_zero(axes)
        if pull_off is not None:
            axes.plot(at[:1], forces[:1], "s", color=draw.ORANGE, label="pull-off")
    axes.set_xlabel(draw.axis_label("indentation", units["indentation"]))
    axes.set_ylabel(draw.axis_label("normal_force", units["normal_force"]))
    draw.legend_above(axes)


def _draw_errors(axes: draw.Axes, checks: xr.Dataset, tolerance: float, pull_off: float | None) -> None:
    d = checks["indentation"].values - (pull_off or 0.0)
    unit = good_unit(d, "m")
    x = draw.scaled(d, "indentation", unit)
    for name, (colour, symbol) in _DRAWN.items():
        errors = checks[name].values
        y = np.where(errors > 0.0, errors, np.nan)
        axes.plot(x, y, ".", ms=2.0, color=colour, label=f"of ${symbol}$")
    axes.axhline(tolerance, color=draw.GREY, lw=0.8, ls="--", label="tolerance")
    axes.set(xscale="log", yscale="log", ylabel="relative difference from solve")
    axes.set_xlabel(
        draw.axis_label("indentation", unit)
        if pull_off is None
        else f"indentation above the pull-off ({unit})"
    )
    draw.legend_above(axes)
