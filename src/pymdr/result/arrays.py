"""Labelled read-only arrays over the steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pymdr import presentation
from pymdr.deferred import xr
from pymdr.errors import QuantityError, UnitError
from pymdr.interpretation.validity import Claim
from pymdr.quantities import AXES, Quantity, quantity
from pymdr.units import FloatArray, from_si, shown


def _locked(values: np.ndarray) -> np.ndarray:
    """A read-only view of values."""
    view = values.view()
    view.flags.writeable = False
    return view


def locked_data(data: xr.Dataset) -> xr.Dataset:
    """A copy of the dataset with read-only arrays."""
    locked = data.copy()
    for name, variable in locked.variables.items():
        # an index of xarray is read-only already, and so are arrays of `labelled`
        if variable.ndim and name not in locked.dims and variable.values.flags.writeable:
            variable.data = _locked(variable.values)
    return locked


def locked_claim(claim: Claim) -> Claim:
    """The claim with read-only arrays."""
    error = None if claim.error is None else _locked(claim.error)
    return replace(claim, where=_locked(claim.where), error=error)


def labelled(columns: Mapping[str, ArrayLike], rows: ArrayLike | None = None) -> xr.Dataset:
    """
    Read-only arrays over ``step``, vectors over ``step`` and ``axis``, with units and names from the table of quantities.

    Parameters
    ----------
    columns : mapping of str to array_like
        Quantity name -> values.
    rows : array_like of int, optional
        The kept rows of the path, as the coordinate ``row``.
    """
    variables = {}
    for name, values in columns.items():
        q = quantity(name)
        words = {"units": q.unit, "long_name": q.long_name, "symbol": q.symbol}
        variables[name] = variable_of(("step", "axis")[: np.ndim(values)], _locked(np.asarray(values)), words)
    coords: dict[str, Any] = {}
    if rows is not None:
        coords["row"] = variable_of(("step",), _locked(np.asarray(rows)), {"long_name": "row of the path"})
    if any(one.ndim == 2 for one in variables.values()):
        coords["axis"] = list(AXES)
    return xr.Dataset(variables, coords=coords)


def variable_of(dims: Sequence[str], values: ArrayLike, attrs: Mapping[str, str]) -> xr.Variable:
    """A variable of an array as it is. To look whether it is one of dask, xarray imports dask.array, which takes longer than to solve."""
    return xr.Variable(dims, np.asarray(values), attrs, fastpath=True)


def field_array(
    name: str,
    values: FloatArray,
    places: tuple[Quantity, FloatArray],
    rows: Sequence[int],
    several: bool,
    attrs: Mapping[str, str],
    amplitude: tuple[FloatArray, str] | None,
) -> xr.DataArray:
    """
    A field over its places, and over ``step`` if there are several rows.

    Parameters
    ----------
    values : ndarray
        Over rows, components of vectors and places.
    places : tuple
        Their quantity, and radii or positions in m.
    amplitude : tuple, optional
        Of the singularity at the edge in the rows, with its unit.

    Notes
    -----
    Axes are indices already: to make an index of an array xarray imports pint.
    """
    from pandas import Index

    axis, at = places
    over, row = (("step",), slice(None)) if several else ((), 0)
    coords: dict[str, Any] = {
        axis.name: (axis.name, Index(at), {"units": "m", "long_name": axis.long_name}),
        "step": ("step", Index(rows)) if several else variable_of((), rows[0], {}),
    }
    if amplitude is not None:
        coords["edge_amplitude"] = variable_of(over, amplitude[0][row], {"units": amplitude[1]})
    if values.ndim == 3:
        coords["axis"] = list(AXES)
    dims = (*over, *["axis"] * (values.ndim - 2), axis.name)
    return xr.DataArray(variable_of(dims, values[row], attrs), coords=coords, name=name)


def by_component(data: xr.Dataset) -> xr.Dataset:
    """A dataset whose vectors are split into their components, ``shift_x`` and ``shift_y``."""
    if "axis" not in data.dims:
        return data
    parts: dict[str, xr.DataArray] = {}
    for name, array in data.items():
        if "axis" not in array.dims:
            parts[str(name)] = array
            continue
        for i, axis in enumerate(AXES):
            q = quantity(f"{name}_{axis}")
            words = {"units": q.unit, "long_name": q.long_name, "symbol": q.symbol}
            parts[q.name] = array.isel(axis=i, drop=True).assign_attrs(words)
    return data.drop_vars([*data.data_vars, "axis"], errors="ignore").assign(parts)


def titled_columns(
    table: xr.Dataset,
    rows: xr.DataArray | None,
    claims: Mapping[str, Claim],
    units: Mapping[str, str],
    known: Sequence[str],
) -> dict[str, np.ndarray]:
    """Columns of a table by their titles with units, errors of approximate quantities next to them."""
    for name in units:
        if name not in table:
            raise QuantityError(
                f"units has {shown(name)}, which is not written; add it to the quantities (available: {', '.join(known)})"
            )
    columns: dict[str, np.ndarray] = {"step": np.arange(table.sizes["step"])}
    if rows is not None:
        columns["row"] = rows.values
    for name in map(str, table):
        values, own = table[name].values, quantity(name).unit
        unit = units.get(name, own)
        try:
            given = values if unit == own else from_si(values, own, unit)
        except UnitError as error:
            raise UnitError(f"unit of {name}: {error}") from error
        columns[f"{name} [{unit}]" if unit else name] = given.astype(int) if given.dtype == bool else given
    return presentation.tables.with_error_columns(columns, claims)


def error_with_band(
    error: FloatArray, values: FloatArray, band: tuple[FloatArray, FloatArray] | None
) -> FloatArray:
    """Relative errors over the rows, including the band by the scatter of a sampled profile; NaN where not known."""
    if band is None:
        return error
    size, (low, high) = np.abs(values), band
    with np.errstate(divide="ignore", invalid="ignore"):
        off = np.maximum(np.abs(high - size), np.abs(size - low)) / size
    return error + np.where(size > 0.0, off, 0.0)
