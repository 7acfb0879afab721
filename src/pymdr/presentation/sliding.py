"""The figure that holds the friction stack against boundary elements."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pymdr.presentation.plot import BLUE, GREY, ORANGE
from pymdr.presentation.text import in_good_units
from pymdr.units import FloatArray, from_si

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def compared_tractions(table: xr.Dataset, tractions: xr.Dataset) -> Figure:
    """
    Tangential force against shift, and the shear traction of the last step, by both solutions.

    Parameters
    ----------
    table : xarray.Dataset
        ``shift``, ``tangential_force_mdr`` and ``tangential_force_grid`` over ``step``, in SI units.
    tractions : xarray.Dataset
        ``mdr`` and ``grid`` over ``r``, in Pa and m.

    Returns
    -------
    matplotlib.figure.Figure
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    style = {"axes.spines.top": False, "axes.spines.right": False, "font.size": 9, "legend.frameon": False}
    with mpl.rc_context(style):  # type: ignore[arg-type]
        figure = Figure(figsize=(9.0, 3.8), layout="constrained")
        left, right = figure.subplots(1, 2)
        shift, shift_unit = _scaled(table["shift"].values, "m")
        force, force_unit = _scaled(table["tangential_force_mdr"].values, "N")
        other = from_si(table["tangential_force_grid"].values, "N", force_unit)
        left.plot(shift, other, "o", ms=5, mfc="none", color=ORANGE, label="boundary elements")
        left.plot(shift, force, color=BLUE, lw=1.2, label="MDR")
        left.set_xlabel(f"tangential displacement $u_x$ ({shift_unit})")
        left.set_ylabel(f"tangential force $F_x$ ({force_unit})")
        left.legend()
        r, r_unit = _scaled(tractions["r"].values, "m")
        tau, tau_unit = _scaled(tractions["grid"].values, "Pa")
        right.plot(r, tau, "o", ms=5, mfc="none", color=ORANGE, label="boundary elements, near the x axis")
        right.plot(r, from_si(tractions["mdr"].values, "Pa", tau_unit), color=BLUE, lw=1.2, label="MDR")
        right.axhline(0.0, color=GREY, lw=0.6)
        right.set_xlabel(f"radius $r$ ({r_unit})")
        right.set_ylabel(f"shear traction $\\tau$ ({tau_unit})")
    return figure


def _scaled(values: FloatArray, unit: str) -> tuple[FloatArray, str]:
    finite = np.abs(values[np.isfinite(values)])
    good = in_good_units(float(finite.max(initial=0.0)), unit)[1]
    return np.asarray(from_si(values, unit, good)), good
