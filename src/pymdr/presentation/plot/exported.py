"""The figure of an exported law: force over depth, and what the table errs by."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot.shared import (
    BLUE,
    GREEN,
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
from pymdr.quantities import quantity
from pymdr.units import FloatArray, good_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DRAWN = {"normal_force": (BLUE, "F"), "normal_stiffness": (ORANGE, "k"), "contact_radius": (GREEN, "a")}


def law_study(
    knots: xr.Dataset,
    curve: tuple[FloatArray, FloatArray],
    checks: xr.Dataset,
    tolerance: float,
    held_to: float | None,
) -> Figure:
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
        What was asked.
    held_to : float or None
        The indentation in m at which the contact is lost; None without adhesion.

    Returns
    -------
    matplotlib.figure.Figure
    """
    with styled():
        figure = new_figure(9.6, 3.8)
        law, errors = figure.subplots(1, 2)
        _draw_law(law, knots, curve, held_to)
        _draw_errors(errors, checks, tolerance, held_to)
        letter_panels(figure)
    return figure


def _draw_law(
    axes: Axes, knots: xr.Dataset, curve: tuple[FloatArray, FloatArray], held_to: float | None
) -> None:
    units = {
        name: good_unit(knots[name].values, quantity(name).unit) for name in ("indentation", "normal_force")
    }
    d, force = (scaled(v, n, units[n]) for n, v in zip(units, curve, strict=True))
    axes.plot(d, force, color=BLUE, label="law")
    at, forces = (scaled(knots[n].values, n, units[n]) for n in units)
    axes.plot(at, forces, "o", ms=3.0, color=GREY, label=f"{at.size} knots")
    if held_to is None and np.all(force > 0.0):
        axes.set(xscale="log", yscale="log")
        axes.set_xlim(0.5 * d[0], 1.5 * d[-1])
    else:
        draw_zero(axes)
        if held_to is not None:
            axes.plot(at[:1], forces[:1], "s", color=ORANGE, label="lost")
    axes.set_xlabel(axis_label("indentation", units["indentation"]))
    axes.set_ylabel(axis_label("normal_force", units["normal_force"]))
    legend_above(axes)


def _draw_errors(axes: Axes, checks: xr.Dataset, tolerance: float, held_to: float | None) -> None:
    d = checks["indentation"].values - (held_to or 0.0)
    unit = good_unit(d, "m")
    x = scaled(d, "indentation", unit)
    for name, (colour, symbol) in _DRAWN.items():
        errors = checks[name].values
        axes.plot(
            x, np.where(errors > 0.0, errors, np.nan), ".", ms=2.0, color=colour, label=f"of ${symbol}$"
        )
    axes.axhline(tolerance, color=GREY, lw=0.8, ls="--", label="tolerance")
    axes.set(xscale="log", yscale="log", ylabel="relative error against solve")
    axes.set_xlabel(
        axis_label("indentation", unit) if held_to is None else f"indentation above the pull-off ({unit})"
    )
    legend_above(axes)
