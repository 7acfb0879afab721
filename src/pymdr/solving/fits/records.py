"""Sources of the curves of a map, read in stretches."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from pymdr.deferred import xr
from pymdr.errors import FileError, MissingExtraError, ProblemError, UnitError
from pymdr.numerics.panels import IndexArray
from pymdr.solving.curves import MeasuredCurve
from pymdr.units import FloatArray, shown, to_si

SAMPLE = "sample"
"""The dimension along a curve."""


class Stretch(NamedTuple):
    """Some curves, one per row, padded with NaN."""

    place: FloatArray
    """Travel, or indentation, in m."""
    force: FloatArray
    """In N."""
    softness: FloatArray
    """Compliance of the machine in m/N; 0 for measured indentations."""
    time: FloatArray | None
    """In s."""

    def rows(self, rows: IndexArray) -> Stretch:
        """Some of them."""
        time = None if self.time is None else self.time[rows]
        return Stretch(self.place[rows], self.force[rows], self.softness[rows], time)

    def curve(self, i: int) -> MeasuredCurve:
        """One of them; samples that are not finite are left out."""
        good = np.isfinite(self.place[i]) & np.isfinite(self.force[i])
        soft = float(self.softness[i])
        channel = "indentation" if soft == 0.0 else "travel"
        return MeasuredCurve(
            force=self.force[i][good],
            time=None if self.time is None else self.time[i][good],
            spring_constant=None if soft == 0.0 else 1.0 / soft,
            **{channel: self.place[i][good]},
        )


class Records(Protocol):
    """Curves over a grid."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the grid."""

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of the grid."""

    @property
    def coords(self) -> dict[str, Any]:
        """Coordinates of the grid, as in xarray."""

    def read(self, first: int, last: int) -> Stretch:
        """The curves from `first` to before `last`, the last dimension of the grid running fastest."""


@dataclass(frozen=True)
class ListedCurves:
    """Curves one by one; samples that are marked are left out."""

    curves: tuple[MeasuredCurve, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of curves."""
        return (len(self.curves),)

    @property
    def dims(self) -> tuple[str, ...]:
        """The dimension of their numbers."""
        return ("curve",)

    @property
    def coords(self) -> dict[str, Any]:
        """No coordinates."""
        return {}

    def read(self, first: int, last: int) -> Stretch:
        """Read some curves, padded to the longest."""
        some = self.curves[first:last]
        width = max(one.force.size for one in some)

        def filled(columns: Sequence[FloatArray]) -> FloatArray:
            out = np.full((len(some), width), math.nan)
            for row, column in zip(out, columns, strict=True):
                row[: column.size] = column
            return out

        timed = all(one.time is not None for one in some)
        return Stretch(
            filled([np.where(one.marked, math.nan, one.position) for one in some]),
            filled([one.force for one in some]),
            np.array([one.compliance for one in some]),
            filled([one.time for one in some if one.time is not None]) if timed else None,
        )


@dataclass(frozen=True)
class StoredCurves:
    """Curves in a dataset over a grid and ``sample``, read in parts."""

    data: xr.Dataset

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the grid."""
        return tuple(self.data.sizes[name] for name in self.dims)

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of the grid."""
        return tuple(str(name) for name in self.data["force"].dims if name != SAMPLE)

    @property
    def coords(self) -> dict[str, Any]:
        """Coordinates of the grid."""
        return {str(n): c.variable for n, c in self.data.coords.items() if set(c.dims) <= set(self.dims)}

    @property
    def _place(self) -> str:
        return "travel" if "travel" in self.data else "indentation"

    def read(self, first: int, last: int) -> Stretch:
        """Read some curves from whole slices of the first dimension."""
        inner = math.prod(self.shape[1:])
        low, high = first // inner, -(-last // inner)
        some = self.data.isel({self.dims[0]: slice(low, high)})
        part = slice(first - low * inner, last - low * inner)
        shape = {name: some.sizes[name] for name in self.dims}

        def column(name: str, unit: str) -> FloatArray:
            values = _over(some[name], {**shape, SAMPLE: some.sizes[SAMPLE]})
            return np.ascontiguousarray(
                values.reshape(-1, values.shape[-1])[part] * _factor(some[name], name, unit)
            )

        soft = np.zeros(last - first)
        if self._place == "travel":
            stiff = some["spring_constant"]
            soft = 1.0 / (_over(stiff, shape).reshape(-1)[part] * _factor(stiff, "spring_constant", "N/m"))
        time = column("time", "s") if "time" in some else None
        return Stretch(column(self._place, "m"), column("force", "N"), soft, time)


def _over(array: xr.DataArray, sizes: Mapping[str, int]) -> FloatArray:
    """
    Values over some dimensions, without some of which an array is the same for all.

    Of small maps, `broadcast_like` of xarray, which compares coordinates, takes a fifth of the time.
    """
    own = array.transpose(*(name for name in sizes if name in array.dims))
    shape = [own.sizes.get(name, 1) for name in sizes]
    return np.broadcast_to(np.asarray(own.values, dtype=float).reshape(shape), tuple(sizes.values()))


def records_of(curves: Any) -> Records:
    """
    The curves of a fit of many, from any accepted argument.

    Parameters
    ----------
    curves : sequence of MeasuredCurve, xarray.Dataset, or path of a Zarr store of one
        A dataset has ``force`` and ``travel`` or ``indentation`` over the grid and ``sample``, with ``units``; with travel
        ``spring_constant`` too.

    Raises
    ------
    ProblemError
        If they are of another type, empty, or the dataset lacks a variable.
    FileError
        If the store cannot be read.
    """
    if isinstance(curves, str | os.PathLike):
        return records_of(_opened(curves))
    if isinstance(curves, xr.Dataset):
        return _stored(curves)
    listed = tuple(curves) if isinstance(curves, Sequence) else ()
    if not listed or not all(isinstance(one, MeasuredCurve) for one in listed):
        raise ProblemError(
            f"curves = {shown(curves)}; MeasuredCurves are needed, a dataset of force and travel over a grid and "
            f"{SAMPLE}, or the folder of a Zarr store of one"
        )
    return ListedCurves(listed)


def zarr() -> Any:
    """The package zarr."""
    try:
        import zarr as package
    except ImportError as error:
        raise MissingExtraError("stores of Zarr need the extra maps: pip install 'pymdr[maps]'") from error
    return package


def _opened(file: str | os.PathLike[str]) -> xr.Dataset:
    """The dataset of a Zarr store."""
    zarr()
    try:
        dataset: xr.Dataset = xr.open_zarr(file, chunks=None, consolidated=False)
    except (OSError, ValueError, KeyError) as error:
        raise FileError(f"cannot read {os.fspath(file)} as a Zarr store: {error}") from error
    except ImportError as error:  # the protocol of a URL
        raise MissingExtraError(f"cannot read {os.fspath(file)}: {error}") from error
    return dataset


def _stored(data: xr.Dataset) -> StoredCurves:
    """The curves of a dataset; one without the needed variables is refused."""
    missing = [name for name in ("force",) if name not in data]
    if "travel" not in data and "indentation" not in data:
        missing.append("travel or indentation")
    if "travel" in data and "spring_constant" not in data:
        missing.append("spring_constant")
    if missing:
        raise ProblemError(
            f"the dataset has no {', no '.join(missing)}; it has {', '.join(map(str, data.variables))}"
        )
    if SAMPLE not in data["force"].dims or len(data["force"].dims) < 2:
        raise ProblemError(
            f"force has the dimensions {', '.join(map(str, data['force'].dims))}; a grid and {SAMPLE} are needed"
        )
    curves = StoredCurves(data)
    if math.prod(curves.shape) == 0 or data.sizes[SAMPLE] == 0:
        raise ProblemError("the dataset has no curve; give at least one")
    for name, unit in (
        ("force", "N"),
        ("travel", "m"),
        ("indentation", "m"),
        ("spring_constant", "N/m"),
        ("time", "s"),
    ):
        if name in data:
            _factor(data[name], name, unit)
            _refuse_misplaced(data, name, curves.dims)
    if "travel" in data:
        stiff = np.asarray(data["spring_constant"].values, dtype=float)
        if np.any(stiff <= 0.0):
            raise ProblemError(
                f"spring_constant has {shown(float(np.nanmin(stiff)))}; it must be above 0, or NaN where there is no curve"
            )
    return curves


def _refuse_misplaced(data: xr.Dataset, name: str, grid: Sequence[str]) -> None:
    """Refuse variables that do not match the grid, or are not numbers."""
    array = data[name]
    stands = [str(d) for d in array.dims]
    stray = [d for d in stands if d not in (*grid, SAMPLE)]
    if stray:
        raise ProblemError(
            f"{name} has the dimensions {', '.join(stray)}, which force does not have; its dimensions are {', '.join((*grid, SAMPLE))}"
        )
    if (SAMPLE in stands) is (name == "spring_constant"):
        dimensions = f"the dimensions {', '.join(stands)}" if stands else "no dimension"
        needed = (
            f"one number, or one over {', '.join(grid)}," if SAMPLE in stands else f"a column over {SAMPLE}"
        )
        raise ProblemError(f"{name} has {dimensions}; {needed} is needed")
    if array.dtype.kind not in "fiu":
        raise ProblemError(f"{name} is of the type {array.dtype}; real numbers are needed")


def _factor(array: xr.DataArray, name: str, unit: str) -> float:
    """The factor from the unit of a variable to SI."""
    own = array.attrs.get("units", unit)
    try:
        return to_si(f"1 {own}", unit, name=name)
    except UnitError as error:
        raise ProblemError(f"{name} has the units {shown(own)}; those of {unit} are needed") from error
