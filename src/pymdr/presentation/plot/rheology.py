"""Measured moduli and the fitted series."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pymdr.presentation.plot import shared as draw
from pymdr.quantities import quantity
from pymdr.units import FloatArray, from_si, good_unit


def fitted_moduli(
    measured: Mapping[str, FloatArray],
    series: Mapping[str, FloatArray],
    equilibrium: float,
    terms: tuple[FloatArray, FloatArray],
    span: tuple[float, float],
    misfit: float,
) -> draw.Figure:
    """
    Measured moduli with the fitted series, and its terms.

    Parameters
    ----------
    measured : mapping of str to ndarray
        ``time`` and ``relaxation_modulus``, or ``angular_frequency``, ``storage_modulus`` and ``loss_modulus``.
    series : mapping of str to ndarray
        The same quantities of the series.
    equilibrium : float
        In Pa.
    terms : tuple of ndarray
        Times in s and moduli in Pa.
    span : tuple of float
        Shortest and longest time in s resolved by the rows.
    misfit : float
        Relative root mean square over the rows.
    """
    with draw.new_figure(9.2, 3.8) as figure:
        left, right = figure.subplots(1, 2)
        _draw_moduli(left, measured, series, misfit)
        _draw_terms(right, equilibrium, terms, span)
        for axes in (left, right):
            draw.legend_above(axes)
    return figure


def _draw_moduli(
    axes: draw.Axes, measured: Mapping[str, FloatArray], series: Mapping[str, FloatArray], misfit: float
) -> None:
    along, *moduli = measured
    unit = good_unit(np.concatenate([measured[name] for name in moduli]), "Pa")
    for name, colour in zip(moduli, (draw.BLUE, draw.ORANGE), strict=False):
        rows, line = (np.asarray(from_si(values[name], "Pa", unit)) for values in (measured, series))
        axes.plot(measured[along], rows, "o", color=colour, ms=3, label=f"${quantity(name).symbol}$")
        axes.plot(series[along], line, color=colour, lw=1.2)
    axes.plot([], [], color=draw.GREY, lw=1.2, label=f"series, rms residual {draw.typeset(100.0 * misfit)} %")
    axes.set_xscale("log")
    _scale(axes, np.concatenate([np.asarray(from_si(measured[name], "Pa", unit)) for name in moduli]))
    row = quantity(along)
    axes.set(xlabel=f"{row.label} ({row.unit})", ylabel=f"modulus in shear ({unit})")


def _scale(axes: draw.Axes, values: FloatArray) -> None:
    """Set logarithmic limits around the positive values."""
    positive = values[values > 0.0]
    axes.set_ylim(0.7 * float(positive.min()), 1.4 * float(positive.max()))
    axes.set_yscale("log")


def _draw_terms(
    axes: draw.Axes, equilibrium: float, terms: tuple[FloatArray, FloatArray], span: tuple[float, float]
) -> None:
    times, moduli = terms
    unit = good_unit(np.append(moduli, equilibrium), "Pa")
    size = np.asarray(from_si(moduli, "Pa", unit))
    level = float(from_si(equilibrium, "Pa", unit))
    axes.set_xscale("log")
    # terms at the ends of the span are drawn whole, and a single one has no span of its own
    axes.set_xlim(0.7 * span[0], span[1] / 0.7)
    _scale(axes, np.append(size, level))
    if times.size:
        axes.vlines(times, axes.get_ylim()[0], size, color=draw.BLUE, lw=1.0)
        axes.plot(times, size, "o", color=draw.BLUE, ms=4, label="moduli")
    if level > 0.0:
        axes.axhline(level, color=draw.ORANGE, lw=1.0, ls="--", label="equilibrium")
    axes.set(xlabel="relaxation time (s)", ylabel=f"modulus of the term ({unit})")
